// What a race is doing, in words and as a bar.

import { get } from './dom.js';
import { seconds } from './format.js';

/** Workers of the reference. */
const REFERENCE = 2;
const processors = navigator.hardwareConcurrency ?? 1;

const sharesOf = (integrators) => {
  const workers = integrators + REFERENCE;
  const share = Math.round(100 * processors / workers);
  const each = workers > processors
    ? `share ${processors} processor${processors === 1 ? '' : 's'}: each has ${share} % of one.`
    : 'have a processor each.';
  return `${workers} workers, two of them for the reference, ${each}`;
};

/** Shows a phase of a race of some integrators. */
export const showPhase = (phase, integrators) => {
  get('status').textContent = {
    idle: `Press Start: ${sharesOf(integrators)}`,
    preparing: 'Building the scene in every worker …',
    racing: sharesOf(integrators),
    settling: 'The race is over. The reference goes on, and the errors are measured again.',
    done: 'The race is over.',
  }[phase];
  const isRunning = phase !== 'idle' && phase !== 'done';
  get('start').textContent = isRunning ? 'Stop' : 'Start';
  document.body.dataset.phase = phase;
};

/** Shows how much of a race's time is over; without a limit only the time. */
export const showTime = (time, limit) => {
  const bar = get('progress').querySelector('progress');
  bar.hidden = limit === null;
  if (limit !== null) bar.value = Math.min(time / limit, 1);
  get('time').textContent = time > 0 ? seconds(time) : '';
};

// The values of all pictures in the pixel under the pointer.

import { clamp, get, html } from './dom.js';
import { number, words } from './format.js';

const row = ([name, { radiance, error }]) => html('tr', {},
  html('th', { scope: 'row' }, words(name)),
  ...radiance.map((value) => html('td', {}, number(value))),
  html('td', {}, error === null ? '' : `${error > 0 ? '+' : ''}${number(100 * error)} %`));

/** A function that shows the values at a place, from 0 to 1, or nothing. */
export const readoutOf = (statistics, filmNow) => {
  const element = get('pixel-readout');
  // The place to look at next, while an answer is awaited.
  let wanted = null;
  let isAsking = false;
  const ask = async () => {
    isAsking = true;
    while (wanted) {
      const { width, height } = filmNow();
      const [x, y] = [width, height].map((size, axis) =>
        clamp(Math.floor(wanted[axis] * size), 0, size - 1));
      wanted = null;
      const values = await statistics.look(y * width + x);
      element.hidden = values.length === 0;
      const head = ['', 'R', 'G', 'B', 'error'].map((text) => html('th', {}, text));
      element.replaceChildren(html('table', {},
        html('caption', {}, `pixel (${x}, ${y})`),
        html('thead', {}, html('tr', {}, ...head)),
        html('tbody', {}, ...values.map(row))));
    }
    isAsking = false;
  };
  let isAway = true;
  return async (x, y) => {
    isAway = x === undefined;
    wanted = isAway ? null : [x, y];
    if (!isAway && !isAsking) await ask();
    if (isAway) element.hidden = true;
  };
};

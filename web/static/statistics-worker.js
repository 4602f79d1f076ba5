// The worker that looks after a race: it keeps what the integrators deliver, measures errors
// against the reference, and makes the pictures that the page shows.

import { attach, drop, forget, paint, picturesOf } from './canvases.js';
import {
  average, errorMap, exposed, gainOf, pixelOf, relativeWeights, weightedSquares,
} from './pixels.js';

/** Snapshots are kept at times that grow by this factor, so that a curve can be measured again
 * when the reference is better. */
const SPACING = 1.3;
/** Milliseconds between reports, pictures, and curves. */
const REPORTS_EVERY = 300;
const PICTURES_EVERY = 200;
const CURVES_EVERY = 600;

let race = 0;
/** Pixels in a row of the film. */
let width = 1;
let view = { stops: 0, errors: false };
/** Integrators by name: snapshots in order of time, the last of which is the newest image. */
let contestants = new Map();
/** The two images of the reference, and what is made of them. */
let halves = [null, null];
let reference = null;
/** Names of what is to be shown anew, and reports that the page does not know. */
let stale = new Set();
let reports = new Map();
let timers = {};
/** The images of techniques, one after the other, with their names; the first is their sum. */
let techniques = null;
const TECHNIQUE = 'technique ';

// Calls `action` at most once in a while.
const soon = (name, milliseconds, action) => {
  timers[name] ??= setTimeout(() => {
    delete timers[name];
    action();
  }, milliseconds);
};

const reset = (number) => {
  Object.values(timers).forEach(clearTimeout);
  [race, contestants, halves, reference] = [number, new Map(), [null, null], null];
  [stale, reports, timers] = [new Set(), new Map(), {}];
  forget((key) => !key.startsWith(TECHNIQUE));
};

// What the reference is now: the mean of its halves, whose difference tells its own error. Each has
// twice the variance of the mean, and their difference four times that.
const renewReference = () => {
  const [a, b] = halves;
  if (!a && !b) return;
  const image = a && b ? average(a, b) : a ?? b;
  const weights = relativeWeights(image);
  const own = a && b && weights ? weightedSquares(a, b, weights) / 4 : null;
  reference = { image, weights, own, gain: gainOf(image) };
};

const errorOf = (snapshot) => {
  if (snapshot.against !== reference) {
    // The reference's own variance would count as the integrator's.
    snapshot.error = weightedSquares(snapshot.image, reference.image, reference.weights)
      - reference.own;
    snapshot.against = reference;
  }
  return { seconds: snapshot.seconds, error: snapshot.error };
};

const postCurves = () => {
  renewReference();
  if (reference?.own == null) return;
  const curves = [...contestants].map(([name, snapshots]) => [name, snapshots.map(errorOf)]);
  postMessage({ race, curves, own: reference.own });
  stale.add('reference');
  if (view.errors) contestants.forEach((_, name) => stale.add(name));
  soon('pictures', PICTURES_EVERY, paintPictures);
};

const paintPictures = () => {
  if (!reference) renewReference();
  const newest = (name) => contestants.get(name)?.at(-1).image;
  // Until there is a reference, an image is exposed for itself.
  const gainFor = (image) => (reference?.gain ?? gainOf(image)) * 2 ** view.stops;
  for (const name of stale) {
    const image = name === 'reference' ? reference?.image : newest(name);
    if (!image) continue;
    paint(`${name}/image`, exposed(image, gainFor(image)), width);
    if (view.errors && reference?.own != null && name !== 'reference') {
      paint(`${name}/error`, errorMap(image, reference.image), width);
    }
  }
  stale.clear();
};

// Techniques are exposed like the race's pictures; `stops` are those of each image besides.
const paintTechniques = () => {
  if (!techniques) return;
  const { images, names, stops, width: columns } = techniques;
  const length = images.length / names.length;
  const gain = reference?.gain ?? gainOf(images.subarray(0, length));
  names.forEach((name, i) => {
    const image = images.subarray(i * length, (i + 1) * length);
    paint(`${TECHNIQUE}${name}/image`, exposed(image, gain * 2 ** (view.stops + stops[i])), columns);
  });
};

const postReports = () => {
  postMessage({ race, reports: [...reports] });
  reports.clear();
};

const arrive = (name, half, report, image) => {
  const { seconds } = report;
  if (name === 'reference') {
    halves[half] = image;
  } else {
    const snapshots = contestants.get(name) ?? [];
    contestants.set(name, snapshots);
    // The newest image is a snapshot for good if it is late enough after the one before.
    const [before, last] = [snapshots.at(-2), snapshots.at(-1)];
    if (last && before && last.seconds < SPACING * before.seconds) snapshots.pop();
    snapshots.push({ seconds, image });
  }
  reports.set(name, report);
  soon('reports', REPORTS_EVERY, postReports);
  stale.add(name);
  soon('pictures', PICTURES_EVERY, paintPictures);
  soon('curves', CURVES_EVERY, postCurves);
};

const look = ({ question, pixel }) => {
  const values = [...contestants].map(([name, snapshots]) =>
    [name, pixelOf(snapshots.at(-1).image, reference?.image, pixel)]);
  if (reference) values.unshift(['reference', pixelOf(reference.image, null, pixel)]);
  postMessage({ question, answer: values });
};

const actions = {
  attach,
  drop,
  pictures: ({ question, keys }) => postMessage({ question, answer: picturesOf(keys) }),
  reset,
  film(pixels) { width = pixels; },
  listen({ name, half, port }) {
    const ownRace = race;
    port.addEventListener('message', ({ data: { progress, image } }) => {
      if (race === ownRace) arrive(name, half, progress, image);
    });
    port.start();
  },
  look,
  show(wanted) {
    view = wanted;
    stale = new Set(['reference', ...contestants.keys()]);
    soon('pictures', 30, paintPictures);
    paintTechniques();
  },
  techniques(arrived) {
    techniques = arrived;
    paintTechniques();
  },
};

addEventListener('message', ({ data: [action, value] }) => actions[action](value));

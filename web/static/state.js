// What the page shows, as the part of its address after "#", so that a link repeats a lesson.

const inRange = (low, high, isWhole = false) => (text) => {
  const value = Number(text);
  const isFine = text !== '' && value >= low && value <= high;
  return isFine && (!isWhole || Number.isInteger(value)) ? value : undefined;
};
const whole = (low, high) => inRange(low, high, true);
const flag = (text) => ({ 0: false, 1: true })[text];
const list = (text) => text.split(',').filter((name) => name !== '');
const name = (text) => (/^[a-z0-9-]+$/.test(text) ? text : undefined);

/** Seconds of a race, to choose from; null is no limit. */
export const TIMES = [5, 10, 30, 60, null];
/** Width and height of the film in pixels, to choose from. */
export const SIZES = [96, 128, 192, 256];

/** The integrators that race if nobody chooses others. */
const SHORT_LIST = [
  'path-tracing', 'light-tracing', 'uniform-area', 'bidirectional', 'photon-mapping',
  'instant-radiosity', 'vcm',
];

/** For each part of the state its value if the address is silent, and its reader. */
const FIELDS = {
  scene: ['cornell-box', name],
  integrators: [SHORT_LIST, list],
  time: [10, (text) => (text === 'none' ? null : inRange(0.5, 3600)(text))],
  size: [128, whole(16, 512)],
  // null is what the scene has.
  depth: [null, whole(0, 64)],
  light: [1, inRange(0.1, 3)],
  roughness: [null, inRange(0.001, 1)],
  radius: [null, inRange(1e-9, 1e9)],
  // The integrator of the reference; null is the one that suits the scene.
  reference: [null, name],
  seed: [1, whole(0, 2 ** 32 - 1)],
  // Stops above or below what the page exposes for.
  stops: [0, inRange(-12, 12)],
  // Techniques.
  rows: [3, whole(0, 8)],
  merges: [false, flag],
  off: [[], (text) => text.split(';').filter((name) => name !== '')],
  weighted: [true, flag],
  // One path; null is any.
  x: [null, whole(0, 511)],
  y: [null, whole(0, 511)],
  bounces: [null, whole(0, 60)],
  technique: [null, (text) => (/^(merge )?\d+,\d+$/.test(text) ? text : undefined)],
};
/** The tabs, by the flag that opens them; the race needs none. */
const TABS = { pyramid: 'techniques', board: 'path' };

const same = (a, b) => JSON.stringify(a) === JSON.stringify(b);

/** A state as nobody has changed it. */
export const initial = () => {
  const values = Object.entries(FIELDS).map(([key, [value]]) => [key, structuredClone(value)]);
  return { ...Object.fromEntries(values), tab: 'race' };
};

/**
 * Reads the part of an address after "#".
 * @returns {{state: object, run: boolean, wrong: string[]}} with what could not be understood
 */
export const read = (hash) => {
  const state = initial();
  const wrong = [];
  const parameters = new URLSearchParams(hash.replace(/^#/, '').replaceAll('+', '%2B'));
  for (const [key, text] of parameters) {
    if (key in TABS) {
      if (text === '1') state.tab = TABS[key];
    } else if (key in FIELDS) {
      const value = FIELDS[key][1](text);
      if (value === undefined) wrong.push(`${key}=${text}`);
      else state[key] = value;
    } else if (key !== 'run') {
      wrong.push(key);
    }
  }
  return { state, run: parameters.get('run') === '1', wrong };
};

/** The part of an address after "#", without what is as it is anyway. */
export const write = (state) => {
  const text = (key) => {
    const value = state[key];
    if (key === 'off') return value.join(';');
    if (value === null) return 'none';
    return typeof value === 'boolean' ? String(Number(value)) : String(value);
  };
  // A scene is always named, so that a link says what it shows.
  const keys = Object.keys(FIELDS)
    .filter((key) => key === 'scene' || !same(state[key], FIELDS[key][0]));
  const tab = Object.keys(TABS).filter((key) => TABS[key] === state.tab).map((key) => `${key}=1`);
  const encode = (value) => encodeURIComponent(value).replaceAll('%2C', ',').replaceAll('%3B', ';');
  return `#${keys.map((key) => `${key}=${encode(text(key))}`).concat(tab).join('&')}`;
};

/** The state with another scene: what was set for the last one is as the new one has it. */
export const withScene = (state, scene) => {
  const { depth, light, roughness, radius, reference, off, x, y, bounces, technique } = initial();
  return {
    ...state, scene, depth, light, roughness, radius, reference, off, x, y, bounces, technique,
  };
};

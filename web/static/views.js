// Zoom and place in the picture, which all pictures of the page share.

import { clamp } from './dom.js';

const root = document.documentElement;
const MOST = 32;
/** The part of each picture that is seen: its left upper corner, in widths and heights. */
const part = { zoom: 1, left: 0, top: 0 };

const show = () => {
  const room = 1 - 1 / part.zoom;
  part.left = clamp(part.left, 0, room);
  part.top = clamp(part.top, 0, room);
  Object.entries(part).forEach(([name, value]) => root.style.setProperty(`--${name}`, value));
  root.classList.toggle('zoomed', part.zoom > 1);
};

/** Zooms; (x, y) is the place in the view that stays where it is, from 0 to 1. */
export const zoom = (factor, x = 0.5, y = 0.5) => {
  const before = part.zoom;
  part.zoom = clamp(before * factor, 1, MOST);
  part.left += x / before - x / part.zoom;
  part.top += y / before - y / part.zoom;
  show();
};
export const showWhole = () => {
  Object.assign(part, { zoom: 1, left: 0, top: 0 });
  show();
};
const pan = (x, y) => {
  part.left += x / part.zoom;
  part.top += y / part.zoom;
  show();
};

/** Zooms in on a place of the picture, from 0 to 1, or back out. */
const zoomOn = (x, y) => {
  if (part.zoom > 1) {
    showWhole();
    return;
  }
  part.zoom = 4;
  [part.left, part.top] = [x, y].map((place) => place - 0.5 / part.zoom);
  show();
};

// The place under a pointer, in widths and heights of the view.
const placeIn = (view, event) => {
  const box = view.getBoundingClientRect();
  return [(event.clientX - box.left) / box.width, (event.clientY - box.top) / box.height];
};
const inPicture = ([x, y]) => [part.left + x / part.zoom, part.top + y / part.zoom];

/** Fingers and mice that move less than this, in parts of the view, click. */
const STILL = 0.02;
const STEPS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };

/**
 * Makes a view zoom and move. `pick` gets the place in the picture, from 0 to 1, that is clicked;
 * `look` the one that is pointed at, or nothing. The keys + and − zoom, arrows move with shift.
 */
export const watch = (view, { pick = zoomOn, look = () => {} } = {}) => {
  const fingers = new Map();
  let isClick = false;
  view.addEventListener('wheel', (event) => {
    // Without a click before, the wheel scrolls the page.
    if (!event.ctrlKey && document.activeElement !== view) return;
    event.preventDefault();
    zoom(2 ** (-event.deltaY / (event.ctrlKey ? 50 : 200)), ...placeIn(view, event));
  }, { passive: false });
  view.addEventListener('pointerdown', (event) => {
    view.focus({ preventScroll: true });
    view.setPointerCapture(event.pointerId);
    isClick = fingers.size === 0 && event.button === 0;
    fingers.set(event.pointerId, { start: placeIn(view, event), at: placeIn(view, event) });
  });
  view.addEventListener('pointermove', (event) => {
    const [x, y] = placeIn(view, event);
    const finger = fingers.get(event.pointerId);
    if (finger) {
      const [a, b] = finger.at;
      const other = [...fingers].find(([id]) => id !== event.pointerId)?.[1];
      if (Math.hypot(x - finger.start[0], y - finger.start[1]) > STILL) isClick = false;
      if (other) {
        const [c, d] = other.at;
        zoom(Math.hypot(x - c, y - d) / Math.max(Math.hypot(a - c, b - d), 1e-3), c, d);
      } else if (!isClick) {
        pan(a - x, b - y);
      }
      finger.at = [x, y];
    }
    look(...inPicture([x, y]));
  });
  view.addEventListener('pointerup', (event) => {
    fingers.delete(event.pointerId);
    if (isClick) pick(...inPicture(placeIn(view, event)));
    isClick = false;
  });
  view.addEventListener('pointercancel', (event) => fingers.delete(event.pointerId));
  view.addEventListener('pointerleave', ({ pointerType }) => {
    if (pointerType === 'mouse') look();
  });
  view.addEventListener('blur', () => look());
  view.addEventListener('keydown', (event) => {
    if (event.ctrlKey || event.altKey || event.metaKey) return;
    const step = event.shiftKey && STEPS[event.key];
    if (step) pan(step[0] / 4, step[1] / 4);
    else if (event.key === '+' || event.key === '=') zoom(2);
    else if (event.key === '-') zoom(0.5);
    else return;
    event.preventDefault();
  });
};

show();

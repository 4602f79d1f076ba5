// Zoom, place and pixel under the pointer, which all pictures of the page share.
const root = document.documentElement;
const settings = Object.fromEntries(
  Object.entries(document.body.dataset).map(([name, text]) => [name, Number(text)]),
);
const clamp = (x, low, high) => Math.min(Math.max(x, low), high);

// The part of each picture that is seen: its left upper corner, in widths and heights.
const part = { zoom: 1, left: 0, top: 0 };
const show = () => {
  const room = 1 - 1 / part.zoom;
  part.left = clamp(part.left, 0, room);
  part.top = clamp(part.top, 0, room);
  Object.entries(part).forEach(([name, value]) => root.style.setProperty(`--${name}`, value));
  root.classList.toggle('zoomed', part.zoom > 1);
};
// (x, y) is the place in the view that stays where it is, from 0 to 1.
const zoom = (factor, x, y) => {
  const before = part.zoom;
  part.zoom = clamp(before * factor, 1, 64);
  part.left += x / before - x / part.zoom;
  part.top += y / before - y / part.zoom;
  show();
};
const pan = (x, y) => {
  part.left += x / part.zoom;
  part.top += y / part.zoom;
  show();
};

// The place under a pointer, in widths and heights of the view.
const placeIn = (frame, event) => {
  const box = frame.getBoundingClientRect();
  return [(event.clientX - box.left) / box.width, (event.clientY - box.top) / box.height];
};
// Tells `look` of the place in the picture, from 0 to 1, when one is pointed at, or of none.
const watch = (frame, look) => {
  const fingers = new Map();
  const point = (x, y) => look(frame, part.left + x / part.zoom, part.top + y / part.zoom);
  frame.addEventListener('wheel', (event) => {
    // Without a click before, the wheel scrolls the page.
    if (!event.ctrlKey && document.activeElement !== frame) return;
    event.preventDefault();
    zoom(2 ** (-event.deltaY / (event.ctrlKey ? 50 : 200)), ...placeIn(frame, event));
  }, { passive: false });
  frame.addEventListener('pointerdown', (event) => {
    frame.focus({ preventScroll: true });
    frame.setPointerCapture(event.pointerId);
    fingers.set(event.pointerId, placeIn(frame, event));
  });
  frame.addEventListener('pointermove', (event) => {
    const [x, y] = placeIn(frame, event);
    if (fingers.has(event.pointerId)) {
      const [a, b] = fingers.get(event.pointerId);
      const others = [...fingers].filter(([finger]) => finger !== event.pointerId);
      if (others.length > 0) {
        const [c, d] = others[0][1];
        zoom(Math.hypot(x - c, y - d) / Math.max(Math.hypot(a - c, b - d), 1e-3), c, d);
      } else {
        pan(a - x, b - y);
      }
      fingers.set(event.pointerId, [x, y]);
    }
    point(x, y);
  });
  // Or the browser would drag the picture away.
  frame.addEventListener('dragstart', (event) => event.preventDefault());
  ['pointerup', 'pointercancel'].forEach((name) => {
    frame.addEventListener(name, (event) => fingers.delete(event.pointerId));
  });
  frame.addEventListener('pointerleave', () => look(frame));
  frame.addEventListener('blur', () => look(frame));
  frame.addEventListener('keydown', (event) => {
    if (event.ctrlKey || event.altKey || event.metaKey) return;
    const steps = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
    const step = event.shiftKey && steps[event.key];
    if (step) pan(step[0] / 4, step[1] / 4);
    else if (event.key === '+' || event.key === '=') zoom(2, 0.5, 0.5);
    else if (event.key === '-') zoom(0.5, 0.5, 0.5);
    else return;
    event.preventDefault();
    point(0.5, 0.5);
  });
};

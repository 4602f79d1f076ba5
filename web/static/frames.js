// The longest gap between frames while something renders, which tests read.

let before = null;
window.__frames = 0;

const measure = (now) => {
  if (before === null) return;
  window.__frames = Math.max(window.__frames, now - before);
  before = now;
  requestAnimationFrame(measure);
};

/** Begins to measure, or ends it; what was measured stays until the next beginning. */
export const watchFrames = (isRendering) => {
  if (isRendering === (before !== null)) return;
  before = isRendering ? performance.now() : null;
  if (!isRendering) return;
  window.__frames = 0;
  requestAnimationFrame(measure);
};

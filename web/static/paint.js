// Pictures on canvases, a few in each frame, so that no frame is late however many arrive.

/** Pictures in a frame: processors are busy, and who takes long must wait. */
const MOST = 2;
const waiting = new Map();

const paintSome = () => {
  for (const [canvas, { pixels, size }] of [...waiting].slice(0, MOST)) {
    waiting.delete(canvas);
    if (canvas.width !== size) [canvas.width, canvas.height] = [size, size];
    canvas.getContext('2d').putImageData(new ImageData(pixels, size, size), 0, 0);
  }
  if (waiting.size > 0) requestAnimationFrame(paintSome);
};

/** Shows bytes in sRGB on a canvas; of several pictures for one canvas the last. */
export const paint = (canvas, pixels) => {
  if (waiting.size === 0) requestAnimationFrame(paintSome);
  waiting.set(canvas, { pixels, size: Math.sqrt(pixels.length / 4) });
};

export const clear = (canvas) => {
  waiting.delete(canvas);
  canvas.getContext('2d').clearRect(0, 0, canvas.width, canvas.height);
};

// The page's canvases, as the worker that makes the pictures paints them: the page itself has then
// nothing to do with a picture, and keeps its frames while all processors are busy.

/** Canvases by number, each with the key of the picture that it shows. */
const canvases = new Map();
/** The newest picture of each key: bytes in sRGB, and pixels in a row. */
const newest = new Map();

const draw = ({ canvas, context, key }) => {
  const picture = newest.get(key);
  if (!picture) {
    context.clearRect(0, 0, canvas.width, canvas.height);
    return;
  }
  const image = new ImageData(picture.bytes, picture.width);
  if (canvas.width !== image.width) canvas.width = image.width;
  if (canvas.height !== image.height) canvas.height = image.height;
  context.putImageData(image, 0, 0);
};

/** Shows a picture on all canvases of its key. */
export const paint = (key, bytes, width) => {
  newest.set(key, { bytes, width });
  canvases.forEach((canvas) => {
    if (canvas.key === key) draw(canvas);
  });
};

/** Forgets the pictures whose keys fit. */
export const forget = (fits) => {
  [...newest.keys()].filter(fits).forEach((key) => newest.delete(key));
  canvases.forEach((canvas) => {
    if (fits(canvas.key)) draw(canvas);
  });
};

/** Makes a canvas show the picture of a key from now on; a new one comes with its number. */
export const attach = ({ id, canvas, key }) => {
  if (canvas) canvases.set(id, { canvas, context: canvas.getContext('2d') });
  const known = canvases.get(id);
  if (known.key === key) return;
  known.key = key;
  draw(known);
};

/** Takes leave of canvases that the page has no more. */
export const drop = (ids) => ids.forEach((id) => canvases.delete(id));

/** The pictures of keys, where there are any. */
export const picturesOf = (keys) => keys.map((key) => newest.get(key));

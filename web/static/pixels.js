// Images as floats, three channels a pixel: their errors, and how they are shown. Definitions are
// those of the crate's report (docs/report.md).

const clamp = (x, low, high) => Math.min(Math.max(x, low), high);
const luminance = (image, i) => 0.2126 * image[i] + 0.7152 * image[i + 1] + 0.0722 * image[i + 2];
const meanOf = (image) => image.reduce((sum, x) => sum + x, 0) / image.length;

const meanLuminance = (image) => {
  let sum = 0;
  for (let i = 0; i < image.length; i += 3) sum += luminance(image, i);
  return 3 * sum / image.length;
};

/** Mean of two images. */
export const average = (a, b) => a.map((x, i) => (x + b[i]) / 2);

/** 1 / (R² + 0.01 mean(R)²) of every channel: the weights of relMSE. */
export const relativeWeights = (reference) => {
  const floor = 0.01 * meanOf(reference) ** 2;
  return floor > 0 ? reference.map((r) => 1 / (r * r + floor)) : null;
};

/** Weighted mean of (a − b)² over pixels and channels. */
export const weightedSquares = (a, b, weights) => {
  let sum = 0;
  for (let i = 0; i < a.length; i++) {
    const difference = a[i] - b[i];
    sum += difference * difference * weights[i];
  }
  return sum / a.length;
};

/** A gain with which nine pixels of ten are not too bright. */
export const gainOf = (image) => {
  const values = [];
  for (let i = 0; i < image.length; i += 3) {
    const value = luminance(image, i);
    if (value > 0 && Number.isFinite(value)) values.push(value);
  }
  values.sort((a, b) => a - b);
  return values.length > 0 ? 0.7 / values[Math.floor(values.length * 0.9)] : 1;
};

const srgb = (x) => 255 * (x <= 0.0031308 ? 12.92 * x : 1.055 * x ** (1 / 2.4) - 0.055);
// By the square root, where 4096 steps are finer than 255 are in sRGB.
const tones = Uint8ClampedArray.from({ length: 4097 }, (_, i) => srgb((i / 4096) ** 2));
const tone = (x) => tones[Math.round(4096 * Math.sqrt(clamp(x, 0, 1)))];
const NOT_A_NUMBER = [255, 0, 255];

const paint = (image, colour) => {
  const pixels = new Uint8ClampedArray(4 * image.length / 3);
  for (let i = 0, k = 0; i < image.length; i += 3, k += 4) {
    colour(pixels, i, k);
    pixels[k + 3] = 255;
  }
  return pixels;
};

/** An image as a screen shows it: bytes in sRGB. */
export const exposed = (image, gain) => paint(image, (pixels, i, k) => {
  for (let c = 0; c < 3; c++) pixels[k + c] = tone(gain * image[i + c]);
});

const TOO_BRIGHT = [1, 0.87, 0.25];
const TOO_DARK = [0, 0.003, 0.06];
/** Relative error that gets the full colour. */
const ERROR_SCALE = 0.5;
// The square root of the error is shown, so that small ones can be seen.
const errorColour = (error) => {
  if (Number.isNaN(error)) return NOT_A_NUMBER;
  const amount = Math.sqrt(Math.min(Math.abs(error) / ERROR_SCALE, 1));
  const colour = error > 0 ? TOO_BRIGHT : TOO_DARK;
  return colour.map((c) => tone(0.25 * (1 - amount) + c * amount));
};
const STEPS = 512;
const errorColours = Array.from({ length: 2 * STEPS + 1 }, (_, i) =>
  errorColour(ERROR_SCALE * (i / STEPS - 1)));

// Luminance below 2 % of the mean has no relative error; it is taken relative to that.
const errorFloor = (reference) => 0.02 * meanLuminance(reference);
const relativeError = (image, reference, floor, i) =>
  (luminance(image, i) - luminance(reference, i)) / (luminance(reference, i) + floor);

/** A map of signed relative errors: grey is exact, yellow too bright, dark blue too dark. */
export const errorMap = (image, reference) => {
  const floor = errorFloor(reference);
  return paint(image, (pixels, i, k) => {
    const error = relativeError(image, reference, floor, i);
    const step = Math.round(STEPS * (clamp(error / ERROR_SCALE, -1, 1) + 1));
    pixels.set(Number.isNaN(error) ? NOT_A_NUMBER : errorColours[step], k);
  });
};

/** The colours of error maps from −50 % to +50 %, for a legend. */
export const errorScale = (steps) => Array.from({ length: steps }, (_, i) =>
  `rgb(${errorColour(ERROR_SCALE * (2 * i / (steps - 1) - 1)).join(' ')})`);

/** A pixel's radiance, and its relative error if there is a reference. */
export const pixelOf = (image, reference, pixel) => {
  const i = 3 * pixel;
  const error = reference ? relativeError(image, reference, errorFloor(reference), i) : null;
  return { radiance: [image[i], image[i + 1], image[i + 2]], error };
};

// Radiance from the page's half floats, and what is made of it: exposed pictures, differences.
const halves = Float32Array.from({ length: 1 << 16 }, (_, bits) => {
  const [exponent, digits] = [(bits >> 10) & 31, bits & 1023];
  const size = exponent === 31 ? (digits ? NaN : Infinity)
    : exponent === 0 ? digits * 2 ** -24 : (1024 + digits) * 2 ** (exponent - 25);
  return bits >> 15 ? -size : size;
});
const decode = async (image) => {
  const packed = Uint8Array.from(atob(image.dataset.values), (c) => c.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream('deflate'));
  const bytes = new Uint8Array(await new Response(stream).arrayBuffer());
  const pixels = bytes.length / 6;
  const radiance = new Float32Array(3 * pixels);
  for (let channel = 0; channel < 3; channel++) {
    const [low, high] = [2 * channel * pixels, (2 * channel + 1) * pixels];
    for (let i = 0; i < pixels; i++) {
      radiance[3 * i + channel] =
        halves[bytes[low + i] | (bytes[high + i] << 8)] * 2 ** -settings.stops;
    }
  }
  return radiance;
};
// The largest half float stands for all that is larger.
const largest = 65504 * 2 ** -settings.stops;
const known = new Map();
const radianceOf = (image) => {
  if (!known.has(image)) known.set(image, decode(image));
  return known.get(image);
};

const luminance = (rgb, i) => 0.2126 * rgb[i] + 0.7152 * rgb[i + 1] + 0.0722 * rgb[i + 2];
const srgb = (x) => 255 * (x <= 0.0031308 ? 12.92 * x : 1.055 * x ** (1 / 2.4) - 0.055);
// By the square root, where 4096 steps are finer than 255 are in sRGB.
const tones = Uint8ClampedArray.from({ length: 4097 }, (_, i) => srgb((i / 4096) ** 2));
const tone = (x) => tones[Math.round(4096 * Math.sqrt(clamp(x, 0, 1)))];

const exposed = (radiance, stops) => {
  const gain = 2 ** (settings.gain + stops);
  return (i) => [0, 1, 2].map((c) => tone(gain * radiance[i + c]));
};
// Luminance below 2 % of the mean has no relative error; it is taken relative to that.
const floorOf = (radiance) => {
  let sum = 0;
  for (let i = 0; i < radiance.length; i += 3) sum += luminance(radiance, i);
  return 0.02 * sum / (radiance.length / 3);
};
const errorAt = (radiance, from, floor, i) =>
  (luminance(radiance, i) - luminance(from, i)) / (luminance(from, i) + floor);
// The colours of the error maps: grey is the same, yellow brighter, dark blue darker.
const difference = (radiance, from) => {
  const floor = floorOf(from);
  return (i) => {
    const error = errorAt(radiance, from, floor, i);
    if (Number.isNaN(error)) return [255, 0, 255];
    const amount = Math.sqrt(Math.min(Math.abs(error) / settings.errorScale, 1));
    const colour = error > 0 ? [1, 0.87, 0.25] : [0, 0.003, 0.06];
    return colour.map((c) => tone(0.25 * (1 - amount) + c * amount));
  };
};
const paint = (canvas, image, colour) => {
  [canvas.width, canvas.height] = [image.naturalWidth, image.naturalHeight];
  const context = canvas.getContext('2d');
  const pixels = context.createImageData(canvas.width, canvas.height);
  for (let i = 0, k = 0; k < pixels.data.length; i += 3, k += 4) {
    pixels.data.set(colour(i), k);
    pixels.data[k + 3] = 255;
  }
  context.putImageData(pixels, 0, 0);
};

// As everywhere on the page: three significant digits.
const number = (x) => {
  const size = Math.abs(x);
  if (Number.isNaN(x)) return '–';
  if (size === Infinity) return x > 0 ? '∞' : '-∞';
  if (size === 0) return '0';
  if (size < 0.001 || size >= 1e5) return x.toExponential(2).replace('e+', 'e');
  return x.toFixed(clamp(2 - Math.floor(Math.log10(size)), 0, 6));
};

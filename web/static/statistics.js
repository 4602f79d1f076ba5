// The page's side of the worker that measures errors and makes pictures.

/** What the worker tells, which listeners may replace. */
const nothing = () => {};

export class Statistics {
  #worker = new Worker(new URL('statistics-worker.js', import.meta.url), { type: 'module' });
  #race = 0;
  #asked = new Map();
  #questions = 0;
  /** Called with a name, 'image' or 'error', and bytes in sRGB. */
  onPicture = nothing;
  /** Called with [name, [{seconds, error}]] of all integrators, and the reference's own error. */
  onCurves = nothing;
  /** Called with the bytes of each technique's picture, that of their sum first. */
  onTechniques = nothing;

  constructor() {
    this.#worker.addEventListener('message', ({ data }) => this.#receive(data));
  }

  #receive(data) {
    if (data.techniques) this.onTechniques(data.techniques);
    // The rest may be of a race that is over.
    else if (data.race !== this.#race) return;
    else if (data.pixels) this.onPicture(data.name, data.kind, data.pixels);
    else if (data.curves) this.onCurves(data.curves, data.own);
    else if (data.values) {
      this.#asked.get(data.question)?.(data.values);
      this.#asked.delete(data.question);
    }
  }

  /** Forgets the last race. */
  reset() {
    this.#asked.forEach((answer) => answer([]));
    this.#asked.clear();
    this.#worker.postMessage(['reset', ++this.#race]);
  }

  /** Takes an image that an integrator, or a half of the reference, has made in some seconds. */
  arrive(name, seconds, image, half = 0) {
    this.#worker.postMessage(['arrive', { name, half, seconds, image }], [image.buffer]);
  }

  /** Takes the images of techniques, each of which is shown brighter by its stops. */
  techniques(images, stops) {
    this.#worker.postMessage(['techniques', { images, stops }], [images.buffer]);
  }

  /** Chooses what pictures show: stops of exposure, and whether there are error maps. */
  show(stops, errors) { this.#worker.postMessage(['show', { stops, errors }]); }

  /** The values of all images in a pixel: [name, {radiance, error}]. */
  look(pixel) {
    const question = ++this.#questions;
    return new Promise((resolve) => {
      this.#asked.set(question, resolve);
      this.#worker.postMessage(['look', { question, pixel }]);
    });
  }
}

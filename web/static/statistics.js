// The page's side of the worker that measures errors and makes pictures.

export class Statistics {
  #worker = new Worker(new URL('statistics-worker.js', import.meta.url), { type: 'module' });
  #race = 0;
  #asked = new Map();
  #questions = 0;

  /**
   * @param onReports gets the newest report of each integrator that has sent one, [name, report]
   * @param onCurves gets [name, [{seconds, error}]] of all integrators, and the reference's own error
   */
  constructor(onReports, onCurves) {
    this.#worker.addEventListener('message', ({ data }) => {
      const { race, reports, curves, own, question, answer } = data;
      // What comes may be of a race that is over.
      if (reports && race === this.#race) onReports(reports);
      if (curves && race === this.#race) onCurves(curves, own);
      this.#asked.get(question)?.(answer);
      this.#asked.delete(question);
    });
  }

  /** Asks the worker for an action. */
  send(action, values, transfer = []) { this.#worker.postMessage([action, values], transfer); }

  /** Asks the worker for an answer. */
  ask(action, values) {
    const question = ++this.#questions;
    return new Promise((resolve) => {
      this.#asked.set(question, resolve);
      this.send(action, { ...values, question });
    });
  }

  /** Forgets the last race. */
  reset() { this.send('reset', ++this.#race); }

  /** Tells how many pixels images have in a row. */
  film(width) { this.send('film', width); }

  /** A port for reports and images of an integrator, or of a half of the reference. */
  portFor(name, half = 0) {
    const { port1, port2 } = new MessageChannel();
    this.send('listen', { name, half, port: port1 }, [port1]);
    return port2;
  }

  /** Takes the images of techniques by name, one after the other, each brighter by its stops. */
  techniques(images, width, names, stops) {
    this.send('techniques', { images, width, names, stops }, [images.buffer]);
  }

  /** Chooses what pictures show: stops of exposure, and whether there are error maps. */
  show(stops, errors) { this.send('show', { stops, errors }); }

  /** The values of all images in a pixel: [name, {radiance, error}]. */
  look(pixel) { return this.ask('look', { pixel }); }
}

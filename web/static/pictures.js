// The page's side of its canvases, which the worker of the statistics paints.

const keyOf = (name, kind) => `${name}/${kind}`;

export class Pictures {
  #ids = new Map();
  #last = 0;

  constructor(statistics) { this.statistics = statistics; }

  /** Makes a canvas show a picture from now on: of whom, and 'image' or 'error'. */
  attach(canvas, name, kind = 'image') {
    const key = keyOf(name, kind);
    if (this.#ids.has(canvas)) {
      this.statistics.send('attach', { id: this.#ids.get(canvas), key });
      return;
    }
    const id = ++this.#last;
    this.#ids.set(canvas, id);
    const offscreen = canvas.transferControlToOffscreen();
    this.statistics.send('attach', { id, canvas: offscreen, key }, [offscreen]);
  }

  /** Takes leave of canvases. */
  drop(canvases) {
    this.statistics.send('drop', canvases.map((canvas) => this.#ids.get(canvas)));
    canvases.forEach((canvas) => this.#ids.delete(canvas));
  }

  /** The newest pictures, {bytes, width}, of [name, kind], where there are any. */
  newest(wanted) {
    return this.statistics.ask('pictures', { keys: wanted.map((picture) => keyOf(...picture)) });
  }
}

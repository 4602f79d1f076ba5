// The newest pictures, and the canvases that show them.

import { clear, paint } from './paint.js';

const keyOf = (name, kind) => `${name}/${kind}`;

export class Pictures {
  #newest = new Map();
  #keys = new Map();

  /** Takes a picture of an integrator: 'image' or 'error'. */
  put(name, kind, pixels) {
    const key = keyOf(name, kind);
    this.#newest.set(key, pixels);
    this.#keys.forEach((shown, canvas) => {
      if (shown === key) paint(canvas, pixels);
    });
  }

  /** The bytes of a picture, if there is one. */
  get(name, kind) { return this.#newest.get(keyOf(name, kind)); }

  /** Makes a canvas show a picture from now on. */
  attach(canvas, name, kind) {
    this.#keys.set(canvas, keyOf(name, kind));
    const pixels = this.get(name, kind);
    if (pixels) paint(canvas, pixels);
    else clear(canvas);
  }

  detach(canvas) { this.#keys.delete(canvas); }

  /** Forgets all pictures of which others are to come. */
  forget() {
    this.#newest.clear();
    this.#keys.forEach((_, canvas) => clear(canvas));
  }
}

// One picture at a time, large: flipping shows differences that side by side nobody sees.

import { get, html } from './dom.js';
import { words } from './format.js';
import { watch } from './views.js';

export class Stage {
  #names = [];
  #shown = 'reference';
  #before = 'reference';
  #kind = 'image';

  /** `look` gets the place that is pointed at. */
  constructor(pictures, look) {
    Object.assign(this, { pictures, element: get('stage'), canvas: get('stage').querySelector('canvas') });
    watch(this.element.querySelector('.view'), { look });
    get('flip').addEventListener('click', () => this.flip());
    get('save').addEventListener('click', () => this.#save());
    addEventListener('keydown', (event) => this.#press(event));
  }

  /** Offers pictures by name and title. */
  renew(titles) {
    this.#names = titles.map(([name]) => name);
    const fallback = (name, i) => (this.#names.includes(name) ? name : this.#names[i]);
    const [shown, before] = [fallback(this.#shown, 1), fallback(this.#before, 0)];
    const buttons = titles.map(([name, title], i) => {
      const label = [i < 9 ? html('kbd', {}, String(i + 1)) : null, ` ${words(name)}`];
      return html('button', { type: 'button', 'data-name': name, title, onclick: () => this.show(name) }, ...label);
    });
    get('choices').replaceChildren(...buttons);
    [this.#shown, this.#before] = [shown, before];
    this.#draw();
  }

  /** Shows a picture. */
  show(name) {
    if (name !== this.#shown) [this.#shown, this.#before] = [name, this.#shown];
    this.#draw();
  }

  /** Shows the picture before this one. */
  flip() { this.show(this.#before); }

  /** Chooses images or error maps. */
  kind(kind) {
    this.#kind = kind;
    this.#draw();
  }

  #draw() {
    // The reference has no error map.
    const kind = this.#shown === 'reference' ? 'image' : this.#kind;
    this.pictures.attach(this.canvas, this.#shown, kind);
    get('choices').childNodes.forEach((button) => {
      button.setAttribute('aria-pressed', button.dataset.name === this.#shown);
    });
  }

  #press(event) {
    const isTyping = event.target.matches('input, select, textarea');
    if (isTyping || event.ctrlKey || event.altKey || event.metaKey || get('race').hidden) return;
    const name = /^[1-9]$/.test(event.key) && this.#names[Number(event.key) - 1];
    if (name) this.show(name);
    else if (event.key === 'f' || event.key === 'F') this.flip();
  }

  #save() {
    this.canvas.toBlob((blob) => blob && download(blob, `${this.#shown}.png`));
  }
}

/** Offers a file to the reader's disk. */
export const download = (blob, name) => {
  const link = html('a', { href: URL.createObjectURL(blob), download: name });
  link.click();
  // The download has its own hold of the data once it has begun.
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
};

/** A sheet with all pictures of a race, errors below where there are maps. */
export const sheet = (pictures, texts, size) => {
  const scale = Math.max(1, Math.round(240 / size));
  const [side, gap, line] = [size * scale, 12, 22];
  const hasErrors = texts.some(({ name }) => pictures.get(name, 'error'));
  const canvas = html('canvas', {
    width: texts.length * (side + gap) + gap,
    height: gap + (hasErrors ? 2 : 1) * (side + gap) + 2 * line,
  });
  const context = canvas.getContext('2d');
  context.fillStyle = '#fff';
  context.fillRect(0, 0, canvas.width, canvas.height);
  context.imageSmoothingEnabled = false;
  texts.forEach(({ name, title, error }, i) => {
    const left = gap + i * (side + gap);
    ['image', 'error'].forEach((kind, row) => {
      const pixels = pictures.get(name, kind);
      if (!pixels) return;
      const small = html('canvas', { width: size, height: size });
      small.getContext('2d').putImageData(new ImageData(pixels, size, size), 0, 0);
      context.drawImage(small, left, gap + row * (side + gap), side, side);
    });
    context.fillStyle = '#1a1a1a';
    context.font = '600 15px system-ui, sans-serif';
    context.fillText(title, left, canvas.height - line - 12, side);
    context.font = '14px system-ui, sans-serif';
    context.fillText(`${name === 'reference' ? 'own error' : 'relMSE'} ${error}`, left, canvas.height - 14, side);
  });
  return new Promise((resolve) => canvas.toBlob(resolve));
};

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
    const view = get('stage').querySelector('.view');
    Object.assign(this, { pictures, canvas: view.querySelector('canvas') });
    watch(view, { look });
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
      const onclick = () => this.show(name);
      return html('button', { type: 'button', 'data-name': name, title, onclick }, ...label);
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

  // The reference has no error map.
  #kindNow() { return this.#shown === 'reference' ? 'image' : this.#kind; }

  #draw() {
    this.pictures.attach(this.canvas, this.#shown, this.#kindNow());
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

  async #save() {
    const [picture] = await this.pictures.newest([[this.#shown, this.#kindNow()]]);
    if (!picture) return;
    canvasOf(picture).toBlob((blob) => blob && download(blob, `${this.#shown}.png`));
  }
}

const canvasOf = ({ bytes, width }) => {
  const image = new ImageData(bytes, width);
  const canvas = html('canvas', { width, height: image.height });
  canvas.getContext('2d').putImageData(image, 0, 0);
  return canvas;
};

/** Offers a file to the reader's disk. */
export const download = (blob, name) => {
  const link = html('a', { href: URL.createObjectURL(blob), download: name });
  link.click();
  // The download has its own hold of the data once it has begun.
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
};

/** Width of a picture in a sheet. */
const SIDE = 240;

/** A sheet with all pictures of a race, with error maps below where there are some. */
export const sheet = async (pictures, texts) => {
  const rows = await Promise.all(['image', 'error'].map((kind) =>
    pictures.newest(texts.map(({ name }) => [name, kind]))));
  if (!rows[0][0]) return null;
  const { bytes, width } = rows[0][0];
  const tall = Math.round(SIDE * bytes.length / 4 / width ** 2);
  const shown = rows.filter((row) => row.some((picture) => picture));
  const [gap, line] = [12, 22];
  const canvas = html('canvas', {
    width: gap + texts.length * (SIDE + gap),
    height: gap + shown.length * (tall + gap) + 2 * line,
  });
  const context = canvas.getContext('2d');
  context.fillStyle = '#fff';
  context.fillRect(0, 0, canvas.width, canvas.height);
  context.imageSmoothingEnabled = false;
  context.fillStyle = '#1a1a1a';
  texts.forEach(({ title, error }, i) => {
    const left = gap + i * (SIDE + gap);
    shown.forEach((row, k) => {
      if (row[i]) context.drawImage(canvasOf(row[i]), left, gap + k * (tall + gap), SIDE, tall);
    });
    context.font = '600 15px system-ui, sans-serif';
    context.fillText(title, left, canvas.height - line - 12, SIDE);
    context.font = '14px system-ui, sans-serif';
    context.fillText(error, left, canvas.height - 14, SIDE);
  });
  return new Promise((resolve) => canvas.toBlob(resolve));
};

// The wall of pictures: a card for the reference and for each integrator of a race.

import { html } from './dom.js';
import { count, number, words } from './format.js';
import { watch } from './views.js';

/** The paths that an integrator cannot draw or need not, from its result or the catalogue. */
const lackOf = (result, seesAll) => {
  if (!result && seesAll === undefined) return [];
  if (!result) return [seesAll ? 'sees every path' : 'misses paths of this scene'];
  const { missing, left_out: unneeded } = result;
  return [
    missing.length > 0 ? `misses ${missing.join('; ')}` : 'sees every path',
    ...(unneeded.length > 0 ? [`leaves out ${unneeded.join('; ')}`] : []),
  ];
};

class Card {
  /** `look` gets the place that is pointed at. */
  constructor(name, title, style, look) {
    Object.assign(this, { name, title });
    const canvases = { image: html('canvas'), error: html('canvas') };
    this.canvases = canvases;
    this.views = Object.fromEntries(Object.entries(canvases).map(([kind, canvas]) => {
      const label = kind === 'image' ? title : `${title}, relative error`;
      const view = html('div',
        { class: 'view', tabindex: 0, role: 'group', 'aria-label': label }, canvas);
      watch(view, { look });
      return [kind, view];
    }));
    this.error = html('b', {}, '–');
    this.work = [html('span'), html('span')];
    this.kind = html('p', { class: 'kind' });
    const swatch = html('span', { class: 'swatch', style: `background: ${style.colour}` });
    this.figure = html('figure', { class: 'card', 'data-name': name },
      html('h3', { title }, swatch, words(name)),
      this.views.image,
      this.views.error,
      html('figcaption', {},
        html('p', {}, name === 'reference' ? 'own error ' : 'relMSE ', this.error),
        html('p', {}, this.work[0], ' ', this.work[1]),
        this.kind));
  }

  report({ passes, seconds, samples }) {
    const isOne = passes === 1 ? 'pass' : 'passes';
    this.work[0].textContent = `${count(passes)} ${isOne},`;
    this.work[1].textContent = `${count(samples / seconds)} samples/s`;
  }
}

export class Cards {
  #cards = new Map();

  constructor(element, pictures) {
    Object.assign(this, { element, pictures });
  }

  /**
   * Shows empty cards.
   * @param contestants {name, title, style, estimator, seesAll} of each, the reference first
   */
  renew(contestants, look) {
    this.pictures.drop([...this.#cards.values()].flatMap(({ canvases }) => Object.values(canvases)));
    this.contestants = new Map(contestants.map((contestant) => [contestant.name, contestant]));
    this.#cards = new Map(contestants.map(({ name, title, style }) =>
      [name, new Card(name, title, style, look)]));
    this.#cards.forEach((card, name) => {
      Object.entries(card.canvases).forEach(([kind, canvas]) => {
        this.pictures.attach(canvas, name, kind);
      });
      this.#describe(name, null);
    });
    this.element.replaceChildren(...[...this.#cards.values()].map((card) => card.figure));
  }

  #describe(name, result) {
    const { estimator, seesAll } = this.contestants.get(name);
    const parts = [result?.estimator ?? estimator, ...lackOf(result, seesAll)];
    this.#cards.get(name).kind.textContent = parts.join(' · ');
  }

  /** Says that all have begun. */
  begin() {
    this.#cards.forEach((card) => { card.work[0].textContent = 'first pass …'; });
  }

  report(name, report) { this.#cards.get(name)?.report(report); }

  result(name, result) {
    if (this.#cards.has(name)) this.#describe(name, result);
  }

  /** Says on a card why there is no picture. */
  fault(name, error) {
    const card = this.#cards.get(name);
    if (!card) return;
    card.kind.textContent = error.message;
    card.figure.classList.add('fault');
  }

  /** Shows the newest error of each integrator, and the reference's own. */
  errors(curves, own) {
    const show = (name, error) => {
      const card = this.#cards.get(name);
      if (card) card.error.textContent = error > 0 ? number(error) : 'below the reference’s';
    };
    curves.forEach(([name, points]) => show(name, points.at(-1).error));
    show('reference', own);
  }

  /** Titles by name, for what else shows the same pictures. */
  titles() { return [...this.contestants.values()].map(({ name, title }) => [name, title]); }

  /** The texts of the cards, for a sheet of their pictures. */
  texts() {
    return [...this.#cards.values()].map(({ name, title, figure }) =>
      ({ name, title, error: figure.querySelector('figcaption p').textContent }));
  }
}

// The pyramid of techniques: a picture for each way (s, t) to draw a path, which can be switched
// off, and their sum.

import { radios } from './choices.js';
import { debounce, get, html } from './dom.js';
import { count, number, percent } from './format.js';
import { Lesson, sceneOf } from './lesson.js';
import { watch } from './views.js';

/** Longest paths to choose from. */
const ROWS = 6;
/** Most seconds without a limit: a pyramid needs no more. */
const LONGEST = 120;

/** Whose picture the sum of the techniques is. */
const SUM = 'technique sum';

export class Techniques {
  #lesson = null;
  #key = null;
  #buttons = new Map();
  #list = [];
  #mean = {};

  /** `change` gets changes of the state; `fault` an error. */
  constructor(module, statistics, pictures, change, fault) {
    Object.assign(this, { module, statistics, pictures, change, fault });
    pictures.attach(get('sum').querySelector('canvas'), SUM);
    this.restart = debounce(250, () => this.#start());
    watch(get('sum').querySelector('.view'));
    const options = Array.from({ length: ROWS + 1 }, (_, k) =>
      new Option(`${k} bounce${k === 1 ? '' : 's'}`, k));
    get('rows').append(...options);
    get('rows').addEventListener('change', ({ target }) => change({ rows: Number(target.value) }));
    get('merges').addEventListener('change', ({ target }) => change({ merges: target.checked }));
    get('brighter').addEventListener('change', () => this.#start());
    get('all-on').addEventListener('click', () => change({ off: [] }));
    get('all-off').addEventListener('click', () => {
      change({ off: this.#list.map(({ name }) => name) });
    });
    get('techniques-again').addEventListener('click', () => this.#start());
    this.showWeights = radios(get('weights'), 'weighted', [[true, 'weighted'], [false, 'unweighted']],
      (weighted) => change({ weighted }));
  }

  /** Shows the techniques of a state, from the beginning if it is another one. */
  show(state, file) {
    [this.state, this.file] = [state, file];
    get('rows').value = state.rows;
    get('merges').checked = state.merges;
    this.showWeights(state.weighted);
    this.#press();
    const { rows, merges, off, weighted, seed, radius, time } = state;
    const key = JSON.stringify([sceneOf(state, file), rows, merges, off, weighted, seed, radius, time]);
    if (key === this.#key) return;
    this.#key = key;
    this.restart();
  }

  /** Ends the worker; pictures stay. */
  close() {
    this.#lesson?.close();
    this.#lesson = null;
    this.#key = null;
  }

  async #start() {
    this.#lesson?.close();
    if (get('techniques').hidden) return;
    const { state, file } = this;
    const lesson = new Lesson();
    this.#lesson = lesson;
    const { rows: bounces, merges, off, weighted, seed, radius, time } = state;
    const job = { bounces, merges, off, weighted, seconds: time ?? LONGEST, seed, radius };
    get('techniques-status').textContent = 'Building the scene …';
    try {
      const { width } = await lesson.open(this.module, sceneOf(state, file), file?.blob);
      const take = (report, images) => this.#take(report, images, width);
      const result = await lesson.techniques(job, take);
      get('techniques-status').textContent = `Finished: ${count(result.passes)} passes.`;
    } catch (error) {
      get('techniques-status').textContent = '';
      this.fault(error);
    }
    lesson.close();
  }

  #take(report, images, width) {
    const names = report.techniques.map(({ name }) => name).join(';');
    if (names !== this.#list.map(({ name }) => name).join(';')) this.#build(report.techniques);
    this.#list = report.techniques;
    this.#list.forEach(({ name, on, share }) => {
      this.#buttons.get(name).share.textContent = on ? percent(share) : 'off';
    });
    const gain = get('brighter').checked ? 1 : 0;
    this.statistics.techniques(
      images,
      width,
      ['sum', ...this.#list.map(({ name }) => name)],
      [0, ...this.#list.map(({ bounces }) => gain * bounces)],
    );
    get('techniques-status').textContent = `${count(report.passes)} passes`;
    this.#tellSum();
  }

  // Shares and the sum's mean; the mean with all techniques is kept to compare.
  #tellSum() {
    const on = this.#list.filter((technique) => technique.on);
    const mean = on.reduce((sum, technique) => sum + technique.mean, 0);
    const { rows, merges, weighted } = this.state;
    const key = JSON.stringify([sceneOf(this.state, this.file), rows, merges, weighted]);
    if (on.length === this.#list.length) this.#mean = { key, mean };
    const all = this.#mean.key === key && on.length < this.#list.length
      ? `, with all of them ${number(this.#mean.mean)}` : '';
    get('sum').querySelector('figcaption').replaceChildren(
      html('b', {}, `Sum of ${on.length} of ${this.#list.length} techniques`),
      html('br'), `mean luminance ${number(mean)}${all}`);
    get('sum').dataset.mean = mean;
  }

  // A button for each technique: connections in the pyramid, then those that merge.
  #build(list) {
    this.pictures.drop([...this.#buttons.values()].map(({ canvas }) => canvas));
    this.#buttons = new Map(list.map(({ name, merged }) => {
      const canvas = html('canvas');
      this.pictures.attach(canvas, `technique ${name}`);
      const share = html('span', { class: 'share' });
      const label = merged ? name : `(${name})`;
      const button = html('button', { type: 'button', class: 'layer', 'data-name': name },
        canvas, html('span', { class: 'name' }, label), share);
      button.addEventListener('click', () => this.#toggle(name));
      return [name, { button, canvas, share }];
    }));
    const lengths = [...new Set(list.map(({ bounces }) => bounces))];
    const widest = Math.max(...lengths.map((length) =>
      list.filter(({ bounces, merged }) => bounces === length && !merged).length));
    const row = (merged) => (length) => {
      const inRow = list.filter(({ bounces, merged: isMerged }) =>
        bounces === length && isMerged === merged);
      const buttons = inRow.sort((a, b) => a.s - b.s).map(({ name }) => this.#buttons.get(name).button);
      const title = `${length} bounce${length === 1 ? '' : 's'}`;
      return buttons.length > 0
        ? html('div', { class: 'row', role: 'group', 'aria-label': title }, html('h4', {}, title),
          html('div', { class: 'techniques' }, ...buttons))
        : null;
    };
    const merging = lengths.map(row(true)).filter((element) => element);
    get('layers').style.setProperty('--widest', widest);
    get('layers').replaceChildren(
      html('h3', {}, 'Connect'), ...lengths.map(row(false)).filter((element) => element),
      ...(merging.length > 0 ? [html('h3', {}, 'Merge'), ...merging] : []));
    this.#list = list;
    this.#press();
  }

  #press() {
    this.#buttons.forEach(({ button }, name) => {
      button.setAttribute('aria-pressed', !this.state.off.includes(name));
    });
  }

  #toggle(name) {
    const { off } = this.state;
    this.change({ off: off.includes(name) ? off.filter((other) => other !== name) : [...off, name] });
  }
}

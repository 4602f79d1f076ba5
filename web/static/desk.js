// The desk: the scene, the integrators, and the sliders.

import { clamp, get, html } from './dom.js';
import { number, words } from './format.js';
import { SIZES } from './state.js';
import { styleOf } from './plot.js';

/** The depth that the slider shows where the scene has no limit. */
const DEEP = 20;
/** Roughness that the slider shows where materials keep their own. */
const AS_IT_IS = 0.1;
const log = {
  toPlace: (value) => Math.log10(value),
  toValue: (place) => Number((10 ** place).toPrecision(3)),
};
const plain = { toPlace: (value) => value, toValue: (place) => place };

/**
 * The sliders: for each part of the state its name, its range, how places on the slider are values,
 * and what it means where nobody has moved it.
 */
const SLIDERS = {
  depth: {
    title: 'Depth', hint: 'Most scattering events of a path.', range: [0, DEEP, 1], ...plain,
    initial: (about) => about?.depth ?? DEEP,
    own: (about) => (about?.depth == null ? 'no limit' : `${about.depth}, as in the scene`),
    text: (value) => `${value} bounces`,
  },
  light: {
    title: 'Size of the lights', hint: 'Same power. Small lights are hard to hit.',
    range: [-1, Math.log10(3), 0.01], ...log,
    initial: () => 1, own: () => '× 1', text: (value) => `× ${value}`,
  },
  roughness: {
    title: 'Roughness', hint: 'α of mirrors, metals and glass. Smooth is hard to connect to.',
    range: [-2, 0, 0.01], ...log,
    initial: () => AS_IT_IS, own: () => 'as in the scene', text: (value) => `α = ${value}`,
  },
  radius: {
    title: 'Merge radius', hint: 'Of photon mapping and the like. Large blurs, small is noisy.',
    range: [-1, 1, 0.01],
    toPlace: (value, about) => Math.log10(value / (about?.radius ?? 1)),
    toValue: (place, about) => Number(((about?.radius ?? 1) * 10 ** place).toPrecision(3)),
    initial: (about) => about?.radius ?? 1,
    own: (about) => (about ? number(about.radius) : ''),
    text: (value) => number(value),
  },
};

export class Desk {
  #inputs = new Map();
  #state = {};
  #about = null;

  /**
   * @param shortList the integrators in front
   * @param change called with changes of the state
   */
  constructor(catalogue, shortList, change) {
    Object.assign(this, { catalogue, change });
    get('scene').append(...catalogue.scenes.map(({ name }) => new Option(words(name), name)));
    get('scene').addEventListener('change', ({ target }) => change({ scene: target.value }));
    get('size').append(...SIZES.map((size) => new Option(`${size} × ${size}`, size)));
    get('size').addEventListener('change', ({ target }) => change({ size: Number(target.value) }));
    get('seed').addEventListener('change', ({ target }) => {
      if (target.value !== '' && target.checkValidity()) change({ seed: Number(target.value) });
    });
    get('reference').addEventListener('change', ({ target }) => {
      change({ reference: target.value === '' ? null : target.value });
    });
    this.boxes = catalogue.integrators.map(({ name, title, description }, i) => {
      const box = html('input', { type: 'checkbox', value: name, onchange: () => this.#choose() });
      const swatch = html('span', { class: 'swatch', style: `background: ${styleOf(i).colour}` });
      const label = html('label', { title: description }, box, swatch, title);
      get(shortList.includes(name) ? 'integrators' : 'others').append(label);
      return box;
    });
    get('more').hidden = get('others').childElementCount === 0;
    Object.keys(SLIDERS).forEach((key) => get('sliders').append(this.#slider(key)));
  }

  #choose() {
    const chosen = this.boxes.filter((box) => box.checked).map((box) => box.value);
    // A race of none is none: the last box stays.
    if (chosen.length === 0) this.show(this.#state, this.#about);
    else this.change({ integrators: chosen });
  }

  #slider(key) {
    const { title, hint, range: [min, max, step], toValue, text } = SLIDERS[key];
    const output = html('output');
    const input = html('input', { type: 'range', min, max, step, 'aria-describedby': `hint-${key}` });
    const valueNow = () => toValue(input.valueAsNumber, this.#about);
    input.addEventListener('input', () => {
      output.textContent = text(valueNow());
      this.change({ [key]: valueNow() });
    });
    const reset = html('button',
      { type: 'button', class: 'reset', 'aria-label': `${title}: as it was` }, '↺');
    reset.addEventListener('click', () => this.change({ [key]: key === 'light' ? 1 : null }));
    this.#inputs.set(key, { input, output, reset });
    return html('div', { class: 'slider', 'data-key': key },
      html('label', {}, html('span', {}, title), output, input), reset,
      html('small', { id: `hint-${key}` }, hint));
  }

  /** Shows a state, and what a lesson says about its scene, which may come later. */
  show(state, about) {
    [this.#state, this.#about] = [state, about];
    const isFile = state.scene === 'file';
    const scene = this.catalogue.scenes.find(({ name }) => name === state.scene);
    get('scene').querySelector('[value=file]')?.remove();
    if (isFile) get('scene').append(new Option(about?.name ?? 'file', 'file'));
    get('scene').value = state.scene;
    get('scene-text').textContent = scene?.description ?? about?.description ?? '';
    this.#warn(about?.warnings ?? []);
    this.boxes.forEach((box) => { box.checked = state.integrators.includes(box.value); });
    if (this.boxes.some((box) => box.checked && box.closest('#others'))) get('more').open = true;
    const able = scene?.sees ?? this.catalogue.integrators.map(({ name }) => name);
    get('reference').replaceChildren(new Option('as suits the scene', ''),
      ...able.map((name) => new Option(words(name), name)));
    get('reference').value = state.reference ?? '';
    get('size').value = state.size;
    get('seed').value = state.seed;
    this.#inputs.forEach(({ input, output, reset }, key) => {
      const { initial, own, text, toPlace } = SLIDERS[key];
      const value = state[key];
      const isOwn = value === null || (key === 'light' && value === 1);
      const place = toPlace(value ?? initial(about), about);
      input.value = clamp(place, Number(input.min), Number(input.max));
      output.textContent = isOwn ? own(about) : text(value);
      reset.disabled = isOwn;
    });
  }

  #warn(warnings) {
    get('warnings').hidden = warnings.length === 0;
    const many = warnings.length === 1 ? 'One thing' : `${warnings.length} things`;
    get('warnings').querySelector('summary').textContent = `${many} to know about this scene`;
    const items = warnings.map((warning) => html('li', {}, warning));
    get('warnings').querySelector('ul').replaceChildren(...items);
  }
}

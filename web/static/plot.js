// Error against time, both logarithmic: one curve per integrator, labelled at its end.

import { clamp, html, svg } from './dom.js';
import { powerOfTen, number, seconds, words } from './format.js';

/** Room around the plotting area, in CSS pixels; on the right for the labels of curves. */
const LEFT = 62;
const TOP = 14;
const BOTTOM = 44;
const LABEL_HEIGHT = 15;
const CHARACTER = 8;
const FONT = 12;
/** Labels have at most this part of the width; longer ones are smaller. */
const MOST_LABELS = 0.36;
const DASHES = ['', '8 3', '2 3'];

/** The style of an integrator everywhere: a colour, and a dash once colours become alike. */
export const styleOf = (index) => ({
  colour: `var(--curve-${index % 8})`,
  dash: DASHES[Math.floor(index / 6) % DASHES.length],
});

const decades = (low, high) => {
  const [from, to] = [Math.floor(Math.log10(low)), Math.ceil(Math.log10(high))];
  const powers = Array.from({ length: to - from + 1 }, (_, i) => 10 ** (from + i));
  const steps = high / low < 50 ? [1, 2, 5] : [1];
  const ticks = powers.flatMap((power) => steps.map((step) => Number((step * power).toPrecision(3))));
  return ticks.filter((tick) => tick >= low && tick <= high);
};

const tickText = (value) => {
  if (value >= 0.01 && value < 1000) return String(value);
  const exponent = Math.floor(Math.log10(value) + 1e-9);
  const mantissa = Math.round(value / 10 ** exponent);
  return mantissa === 1 ? powerOfTen(exponent) : `${mantissa}·${powerOfTen(exponent)}`;
};

// Places from top to bottom that keep a distance, each as near as can be to where it should be.
const spread = (wanted, distance, low, high) => {
  const places = wanted.map((place) => clamp(place, low, high));
  for (let i = 1; i < places.length; i++) {
    places[i] = Math.max(places[i], places[i - 1] + distance);
  }
  for (let i = places.length - 1; i >= 0; i--) {
    const limit = i === places.length - 1 ? high : places[i + 1] - distance;
    places[i] = Math.min(places[i], limit);
  }
  return places;
};

// The point of a curve at a time, or the last before it.
const at = (points, time) => {
  const i = points.findIndex((point) => point.seconds > time * 1.0001);
  return i < 0 ? points.at(-1) : points[i - 1];
};

export class Plot {
  #curves = [];
  #own = null;
  #time = null;
  #drawn = null;

  /** `styles` are those of integrators by name; `readout` shows errors at a time. */
  constructor(element, readout, styles) {
    Object.assign(this, { element, readout, styles });
    new ResizeObserver(() => this.#draw()).observe(element);
    element.addEventListener('pointermove', (event) => this.#point(event));
    element.addEventListener('pointerdown', (event) => this.#point(event));
    element.addEventListener('pointerleave', ({ pointerType }) => {
      // A finger that has tapped is gone, but its eyes are not.
      if (pointerType === 'mouse') this.#read(null);
    });
    element.addEventListener('blur', () => this.#read(null));
    element.addEventListener('keydown', (event) => {
      const step = { ArrowLeft: 1 / 1.2, ArrowRight: 1.2 }[event.key];
      if (!step || !this.#drawn) return;
      event.preventDefault();
      const [low, high] = this.#drawn.times;
      this.#read(clamp((this.#time ?? high) * step, low, high));
    });
  }

  /** Shows curves, [name, [{seconds, error}]], and the reference's own error. */
  show(curves, own) {
    const positive = ([name, points]) => [name, points.filter(({ error }) => error > 0)];
    this.#curves = curves.map(positive).filter(([, points]) => points.length > 0);
    this.#own = own;
    this.#draw();
  }

  clear() {
    this.show([], null);
    this.#read(null);
  }

  // Where times and errors are.
  #scales(width, height) {
    const longest = 16 + CHARACTER * Math.max(...this.#curves.map(([name]) => name.length));
    const labels = Math.min(longest, MOST_LABELS * width);
    const right = width - labels;
    const points = this.#curves.flatMap(([, points]) => points);
    const times = points.map((point) => point.seconds);
    const errors = points.map((point) => point.error);
    const bounds = (values, least) => {
      const [low, high] = [Math.min(...values), Math.max(...values)];
      return [low, Math.max(high, low * least)];
    };
    const [from, to] = bounds(times, 3);
    const [low, high] = bounds(this.#own > 0 ? errors.concat(this.#own) : errors, 10);
    const [bottom, top] = [low / 1.5, high * 1.5];
    const scale = (value, [a, b], [c, d]) => c + Math.log(value / a) / Math.log(b / a) * (d - c);
    return {
      right,
      text: FONT * labels / longest,
      bottom: height - BOTTOM,
      times: [from, to],
      errors: [bottom, top],
      x: (time) => scale(time, [from, to], [LEFT, right]),
      y: (error) => scale(error, [bottom, top], [height - BOTTOM, TOP]),
      timeAt: (x) => from * (to / from) ** clamp((x - LEFT) / (right - LEFT), 0, 1),
    };
  }

  #draw() {
    const { width, height } = this.element.getBoundingClientRect();
    if (width === 0) return;
    this.element.setAttribute('viewBox', `0 0 ${width} ${height}`);
    this.#drawn = this.#curves.length > 0 ? this.#scales(width, height) : null;
    if (!this.#drawn) {
      const text = 'The curves begin with the first images.';
      this.element.replaceChildren(
        svg('text', { x: width / 2, y: height / 2, class: 'empty', 'text-anchor': 'middle' }, text),
      );
      return;
    }
    this.element.replaceChildren(
      ...this.#axes(width, height), this.#guide(), this.#floor(), ...this.#lines(),
      ...this.#labels(), this.#cursor(),
    );
  }

  #axes(width, height) {
    const { x, y, times, errors, right, bottom } = this.#drawn;
    const grid = (x1, y1, x2, y2) => svg('line', { x1, y1, x2, y2, class: 'grid' });
    const label = (x, y, anchor, text) => svg('text', { x, y, 'text-anchor': anchor }, text);
    const vertical = decades(...times).flatMap((time) => [
      grid(x(time), TOP, x(time), bottom),
      label(x(time), bottom + 16, 'middle', String(time)),
    ]);
    const horizontal = decades(...errors).flatMap((error) => [
      grid(LEFT, y(error), right, y(error)),
      label(LEFT - 6, y(error) + 4, 'end', tickText(error)),
    ]);
    const middle = (TOP + bottom) / 2;
    const upright = { x: 13, y: middle, 'text-anchor': 'middle', transform: `rotate(-90 13 ${middle})` };
    return [
      ...vertical,
      ...horizontal,
      svg('rect', { x: LEFT, y: TOP, width: right - LEFT, height: bottom - TOP, class: 'frame' }),
      label((LEFT + right) / 2, height - 8, 'middle', 'time [s]'),
      svg('text', upright, 'error (relMSE)'),
    ];
  }

  // The slope of Monte Carlo, from the middle of the upper edge on: error ∝ 1/time.
  #guide() {
    const { x, y, times: [from, to], errors: [low, high] } = this.#drawn;
    const start = from * (to / from) ** 0.25;
    const end = Math.min(to, start * high / low);
    const [a, b] = [[x(start), y(high)], [x(end), y(high * start / end)]];
    const angle = Math.atan2(b[1] - a[1], b[0] - a[0]) * 180 / Math.PI;
    const [u, v] = [a[0] + 0.25 * (b[0] - a[0]), a[1] + 0.25 * (b[1] - a[1])];
    return svg('g', { class: 'guide' },
      svg('line', { x1: a[0], y1: a[1], x2: b[0], y2: b[1] }),
      svg('text', { x: u, y: v - 5, transform: `rotate(${angle} ${u} ${v})` }, 'slope −1'));
  }

  #floor() {
    if (!(this.#own > 0)) return '';
    const { y, right } = this.#drawn;
    const height = y(this.#own);
    return svg('g', { class: 'floor' },
      svg('line', { x1: LEFT, y1: height, x2: right, y2: height }),
      svg('text', { x: LEFT + 6, y: height - 4 }, 'the reference’s own error'));
  }

  #lines() {
    const { x, y } = this.#drawn;
    return this.#curves.flatMap(([name, points]) => {
      const { colour, dash } = this.styles.get(name);
      const places = points.map(({ seconds, error }) => [x(seconds), y(error)]);
      const line = places.map((place) => place.map((c) => c.toFixed(1)).join()).join(' ');
      const [cx, cy] = places.at(-1);
      return [
        svg('polyline', { points: line, class: 'curve', stroke: colour, 'stroke-dasharray': dash }),
        svg('circle', { cx, cy, r: 3.5, fill: colour }),
      ];
    });
  }

  #labels() {
    const { x, y, right, bottom, text } = this.#drawn;
    const ends = this.#curves.map(([name, points]) => ({ name, end: points.at(-1) }));
    ends.sort((a, b) => b.end.error - a.end.error);
    const places = spread(ends.map(({ end }) => y(end.error)), LABEL_HEIGHT, TOP + 4, bottom);
    return ends.flatMap(({ name, end }, i) => {
      const { colour } = this.styles.get(name);
      const start = [x(end.seconds) + 5, y(end.error)];
      const corners = [start, [right + 2, places[i]], [right + 8, places[i]]];
      return [
        svg('polyline', { points: corners.join(' '), class: 'leader', stroke: colour }),
        svg('text', {
          x: right + 11, y: places[i] + 4, fill: colour, class: 'name', 'font-size': text,
        }, words(name)),
      ];
    });
  }

  #cursor() {
    const { x, bottom } = this.#drawn;
    if (this.#time === null) return '';
    const place = x(this.#time);
    return svg('line', { x1: place, y1: TOP, x2: place, y2: bottom, class: 'cursor' });
  }

  #point(event) {
    if (!this.#drawn) return;
    this.#read(this.#drawn.timeAt(event.clientX - this.element.getBoundingClientRect().left));
  }

  // Shows the errors at a time, or nothing.
  #read(time) {
    this.#time = this.#drawn ? time : null;
    this.#draw();
    this.readout.hidden = this.#time === null;
    if (this.readout.hidden) return;
    const rows = this.#curves
      .map(([name, points]) => [name, at(points, this.#time)?.error])
      .sort(([, a], [, b]) => (a ?? Infinity) - (b ?? Infinity))
      .map(([name, error]) => html('tr', {},
        html('th', { scope: 'row', style: `color: ${this.styles.get(name).colour}` }, words(name)),
        html('td', {}, number(error))));
    const head = html('caption', {}, `relMSE after ${seconds(this.#time)}`);
    this.readout.replaceChildren(html('table', {}, head, html('tbody', {}, ...rows)));
  }
}

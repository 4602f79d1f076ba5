// Numbers as people read them: three significant digits.

import { clamp, html, math } from './dom.js';

const MINUS = '\u2212';
const SUPERSCRIPTS = '⁰¹²³⁴⁵⁶⁷⁸⁹';
const SUBSCRIPTS = '₀₁₂₃₄₅₆₇₈₉';
/** A vertex as text: x₃. */
export const vertexName = (k) => [...String(k)].reduce((text, digit) => text + SUBSCRIPTS[digit], 'x');

/** A power of ten as text: 10⁻³. */
export const powerOfTen = (exponent) => [...String(Math.abs(exponent))]
  .reduce((text, digit) => text + SUPERSCRIPTS[digit], exponent < 0 ? '10⁻' : '10');

// Mantissa and power of ten; no power for numbers of everyday size.
const parts = (x) => {
  const size = Math.abs(x);
  if (size === 0 || (size >= 0.001 && size < 1e5)) {
    const digits = size === 0 ? 0 : clamp(2 - Math.floor(Math.log10(size)), 0, 6);
    return [x.toFixed(digits), 0];
  }
  const [mantissa, exponent] = x.toExponential(2).split('e');
  return [mantissa, Number(exponent)];
};

/** A number as text. */
export const number = (x) => {
  if (x == null || Number.isNaN(x)) return '–';
  if (!Number.isFinite(x)) return x > 0 ? '∞' : `${MINUS}∞`;
  const [mantissa, exponent] = parts(x);
  const text = mantissa.replace('-', MINUS);
  return exponent === 0 ? text : `${text}·${powerOfTen(exponent)}`;
};

/** A number as MathML. */
export const mathNumber = (x) => {
  if (!Number.isFinite(x)) return math('mtext', number(x));
  const [mantissa, exponent] = parts(x);
  const digits = math('mn', mantissa.replace('-', MINUS));
  if (exponent === 0) return digits;
  const power = math('msup', math('mn', '10'), math('mn', String(exponent).replace('-', MINUS)));
  return math('mrow', digits, math('mo', '·'), power);
};

/** A share, of which small ones keep a digit. */
export const percent = (x) => {
  if (!Number.isFinite(x)) return '–';
  if (x > 0 && x < 0.0001) return '< 0.01 %';
  const digits = x === 0 || x >= 0.0995 ? 0 : x >= 0.00995 ? 1 : 2;
  return `${(100 * x).toFixed(digits)} %`;
};

/** A large count: 34 k, 1.2 M. */
export const count = (x) => {
  const step = [[1e9, 'G'], [1e6, 'M'], [1e3, 'k']].find(([size]) => x >= size);
  if (!step) return String(Math.round(x));
  const scaled = x / step[0];
  return `${scaled.toFixed(scaled < 10 ? 1 : 0)} ${step[1]}`;
};

export const seconds = (x) => `${x < 9.95 ? x.toFixed(1) : Math.round(x)} s`;

/** One table cell for each channel. */
export const channels = (values) => (values ?? [null, null, null])
  .map((value) => html('td', {}, value == null ? '–' : number(value)));

/** The name of an integrator or scene in running text. */
export const words = (name) => name.replaceAll('-', ' ');

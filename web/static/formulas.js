// The formulas on the board: a path's contribution, written down step by step with its numbers.

import { html, math } from './dom.js';
import { mathNumber } from './format.js';

const symbol = (name) => math('mi', name);
const operator = (sign) => math('mo', sign);
const indexed = (name, index) => math('msub', symbol(name), math('mn', String(index)));
const row = (...parts) => math('mrow', ...parts);
const open = () => operator('(');
const shut = () => operator(')');
const vertex = (k) => indexed('x', k);
const at = (name, k) => row(name, open(), vertex(k), shut());
const ofPath = (name) => row(symbol(name), open(), symbol('x̄'), shut());
const edge = (k) => row(symbol('G'), open(), vertex(k), operator(','), vertex(k + 1), shut());
const medium = (k) => row(symbol('τ'), open(), vertex(k), operator(','), vertex(k + 1), shut());
const formula = (...parts) => {
  const element = math('math', ...parts);
  element.setAttribute('display', 'block');
  return element;
};

/** The name of a vertex's factor: importance, BSDF or emitted radiance. */
const factorSymbol = (name) => ({
  We: indexed('W', 'e'),
  Le: indexed('L', 'e'),
}[name] ?? symbol(name.startsWith('f') ? 'f' : name));

// A factor of a product: how it is written, and its numbers of the three channels.
const factorOf = (path, k) => {
  const { factor_name: name, factor } = path.vertices[k];
  return [at(factorSymbol(name), k), factor];
};
const edgeOf = (path, k) => {
  const { g, transmittance } = path.vertices[k];
  const factors = [[edge(k), [g, g, g]]];
  if (transmittance?.some((part) => part !== 1)) factors.push([medium(k), transmittance]);
  return factors;
};

// An equation between a name and a product; the same in numbers for each channel.
const equation = (name, factors, result) => {
  const line = (channel) => {
    const numbers = factors.map(([, values]) => mathNumber(values[channel]));
    const parts = numbers.flatMap((value, i) => (i > 0 ? [operator('·'), value] : [value]));
    return row(operator('='), ...parts, operator('='), mathNumber(result[channel]));
  };
  const channels = ['red', 'green', 'blue'].map((title, channel) => html('div', { class: 'channel' },
    html('span', { class: title }, title), math('math', line(channel))));
  return {
    formula: formula(row(name, operator('='), ...factors.map(([written]) => written))),
    numbers: html('div', {}, ...channels),
    result,
  };
};

/**
 * The steps of a path's contribution: T_k from T_(k-1), the whole, and what its technique makes of it.
 * @returns {{title: string, vertex: number | null, formula: Node, numbers: Node, result: number[]}[]}
 *   where vertex is the one that the step adds
 */
export const stepsOf = (path) => {
  const last = path.vertices.length - 1;
  const before = (i) => (i === 0 ? [1, 1, 1] : path.steps[i - 1].throughput);
  const along = path.steps.map(({ k, throughput: result }, i) => ({
    title: `Vertex ${k}`,
    vertex: k,
    ...equation(
      indexed('T', k),
      [factorOf(path, k), ...edgeOf(path, k), [indexed('T', k - 1), before(i)]],
      result,
    ),
  }));
  const whole = {
    title: 'The contribution',
    vertex: last,
    ...equation(
      ofPath('f'),
      [factorOf(path, 0), ...edgeOf(path, 0), [indexed('T', last - 1), before(path.steps.length)],
        factorOf(path, last)],
      path.contribution,
    ),
  };
  const used = path.techniques.find(({ name }) => name === path.technique);
  const weighted = used?.estimate && {
    title: `What technique (${used.name}) adds to the pixel`,
    vertex: null,
    ...equation(
      symbol('I'),
      [[symbol('w'), [used.weight, used.weight, used.weight]],
        [math('mfrac', ofPath('f'), ofPath('p')), used.estimate]],
      used.estimate.map((value) => used.weight * value),
    ),
  };
  return [...along, whole, weighted].filter((step) => step);
};

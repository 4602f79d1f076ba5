// The tables on the board: the vertices of a path, and the techniques that could have drawn it.

import { html } from './dom.js';
import { channels, number, vertexName } from './format.js';

const table = (title, head, rows, foot = null) => html('section', {},
  html('h3', {}, title),
  html('div', { class: 'scroll', tabindex: 0, role: 'group', 'aria-label': title }, html('table', {},
    html('thead', {}, html('tr', {}, ...head.map((name) => html('th', { scope: 'col' }, name)))),
    html('tbody', {}, ...rows),
    foot && html('tfoot', {}, foot))));
const cell = (value) => html('td', {}, value == null ? '–' : number(value));
const words = (text) => html('td', { class: 'text' }, text);
const rowHead = (...content) => html('th', { scope: 'row' }, ...content);

const positionOf = ({ kind, position }) =>
  (kind.includes('∞') ? 'at infinity' : position.map(number).join(', '));

/** The vertices of a path; rows know theirs, so that one can be marked. */
export const verticesOf = ({ vertices }) => {
  const head = [
    '', 'kind', 'surface', 'factor', 'red', 'green', 'blue', 'G to the next', 'a', 'b', 'position',
  ];
  const rows = vertices.map((vertex, k) => html('tr', { 'data-vertex': k },
    rowHead('x', html('sub', {}, String(k))),
    words(vertex.kind), words(vertex.surface ?? '–'), words(vertex.factor_name),
    ...channels(vertex.factor), cell(vertex.g),
    cell(vertex.towards_light), cell(vertex.towards_camera), words(positionOf(vertex))));
  const section = table('The vertices, from the lens to the light', head, rows);
  section.append(html('p', {}, 'f is the BSDF, G = V |cos θ cos θ′| / r² of the edge to the next '
    + 'vertex. a is the density of the direction in which a walk from the camera goes on, b that of '
    + 'a walk from the light, both per projected solid angle.'));
  return section;
};

/** The techniques of a path, and the sum of their weights. */
export const techniquesOf = ({ techniques, technique: used, verification }) => {
  const head = ['(s, t)', 'density p', 'f/p red', 'green', 'blue', 'weight w', ''];
  const rows = techniques.map(({ name, merged, density, estimate, weight, possible, reason }) => {
    const isUsed = name === used;
    const note = reason?.replace(/x_(\d+)/g, (_, k) => vertexName(k))
      ?? (isUsed ? 'drew this path' : '');
    return html('tr', { class: isUsed ? 'used' : possible ? '' : 'impossible' },
      rowHead(merged ? name : `(${name})`),
      cell(density), ...channels(estimate), cell(weight), words(note));
  });
  const sum = techniques.reduce((total, { weight }) => total + weight, 0);
  const foot = html('tr', { id: 'weights-sum', 'data-sum': sum },
    rowHead('Sum'), html('td', { colspan: 4 }), html('td', {}, sum.toFixed(6)), words(''));
  const section = table('The techniques that could have drawn it', head, rows, foot);
  section.append(html('p', {}, 'A technique (s, t) has s vertices from the light and t from the '
    + 'camera. Its weight is large where its density is: the sum is one. What the integrator had '
    + `computed differs from the definitions by ${number(verification.value_error)} (f/p) and `
    + `${number(verification.weight_error)} (w).`));
  return section;
};

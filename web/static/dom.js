// Elements and formulas, built without parsing text: names in files may hold anything.

const MATHML = 'http://www.w3.org/1998/Math/MathML';
const SVG = 'http://www.w3.org/2000/svg';

const build = (node, attributes, children) => {
  for (const [name, value] of Object.entries(attributes)) {
    if (name.startsWith('on')) node.addEventListener(name.slice(2), value);
    else if (value === true) node.setAttribute(name, '');
    else if (value !== false && value != null) node.setAttribute(name, value);
  }
  node.append(...children.filter((child) => child != null));
  return node;
};

/** The element with an id, which the page must have. */
export const get = (id) => document.getElementById(id);
/** An HTML element; attributes that begin with "on" are listeners. */
export const html = (tag, attributes = {}, ...children) =>
  build(document.createElement(tag), attributes, children);
/** An SVG element. */
export const svg = (tag, attributes = {}, ...children) =>
  build(document.createElementNS(SVG, tag), attributes, children);
/** A MathML element. */
export const math = (tag, ...children) =>
  build(document.createElementNS(MATHML, tag), {}, children);

/** The last of many calls in a row, `milliseconds` after it. */
export const debounce = (milliseconds, action) => {
  let timer;
  return (...values) => {
    clearTimeout(timer);
    timer = setTimeout(action, milliseconds, ...values);
  };
};

export const clamp = (x, low, high) => Math.min(Math.max(x, low), high);

// Groups of which one is chosen: radio buttons and tabs.

import { get, html } from './dom.js';

/** Radio buttons for [value, text]; returns a function that shows a choice without making it. */
export const radios = (element, name, options, choose) => {
  const inputs = options.map(([value, text]) => {
    const input = html('input', { type: 'radio', name, value: String(value) });
    input.addEventListener('change', () => choose(value));
    element.append(html('label', {}, input, text));
    return input;
  });
  return (value) => inputs.forEach((input) => { input.checked = input.value === String(value); });
};

/** Tabs by the names of their panels; returns a function that opens one. */
export const tabs = (names, choose) => {
  const tabOf = (name) => get(`tab-${name}`);
  names.forEach((name, i) => {
    tabOf(name).addEventListener('click', () => choose(name));
    tabOf(name).addEventListener('keydown', ({ key }) => {
      const step = { ArrowLeft: -1, ArrowRight: 1 }[key];
      if (!step) return;
      const next = names[(i + step + names.length) % names.length];
      choose(next);
      tabOf(next).focus();
    });
  });
  return (open) => names.forEach((name) => {
    get(name).hidden = name !== open;
    tabOf(name).setAttribute('aria-selected', name === open);
    tabOf(name).tabIndex = name === open ? 0 : -1;
  });
};

// What did not work, in words, until the next thing works.

import { get, html } from './dom.js';

export const quiet = () => get('messages').replaceChildren();

export const complain = (text) => get('messages').replaceChildren(html('p', { class: 'message' }, text,
  html('button', { type: 'button', 'aria-label': 'Close', onclick: quiet }, '×')));

// Scene files: chosen, or dropped anywhere on the page.

import { get } from './dom.js';

/** Calls `open` with each file that the reader offers. */
export const acceptFiles = (open) => {
  get('file').addEventListener('change', ({ target }) => {
    const [file] = target.files;
    if (file) open(file);
    // The same file again is another change.
    target.value = '';
  });
  addEventListener('dragover', (event) => {
    if (!event.dataTransfer.types.includes('Files')) return;
    event.preventDefault();
    get('drop').hidden = false;
  });
  addEventListener('dragleave', (event) => {
    if (event.relatedTarget === null) get('drop').hidden = true;
  });
  addEventListener('drop', (event) => {
    get('drop').hidden = true;
    const [file] = event.dataTransfer.files;
    if (!file) return;
    event.preventDefault();
    open(file);
  });
};

// A worker with one lesson of the engine: a scene that integrators render. Calls block; what they
// find on the way is posted as progress.

import { catalogue, initSync, Lesson } from './pathspace_web.js';

let lesson;

/** Posts what is found on the way to a port, if there is one, or else to the page. */
const progressOf = ({ id, port }) => (report, image) => {
  (port ?? self).postMessage({ id, progress: JSON.parse(report), image }, [image.buffer]);
  return false;
};

const calls = {
  catalogue({ module }) {
    initSync({ module });
    return JSON.parse(catalogue());
  },
  async open({ module, scene, file }) {
    initSync({ module });
    const bytes = file ? new Uint8Array(await file.arrayBuffer()) : undefined;
    lesson = new Lesson(JSON.stringify(scene), bytes);
    return JSON.parse(lesson.describe());
  },
  outline: () => lesson.outline(),
  project: ({ points }) => lesson.project(points),
  render: (call) => JSON.parse(lesson.render(JSON.stringify(call.job), progressOf(call))),
  techniques: (call) => JSON.parse(lesson.techniques(JSON.stringify(call.job), progressOf(call))),
  path: ({ job }) => JSON.parse(lesson.path(JSON.stringify(job))),
};

addEventListener('message', async ({ data }) => {
  const { id, call } = data;
  try {
    postMessage({ id, result: await calls[call](data) });
  } catch (error) {
    const text = error?.message ?? String(error);
    const isTrap = error instanceof WebAssembly.RuntimeError;
    postMessage({ id, error: isTrap ? `The engine broke down: ${text}.` : text });
  }
});

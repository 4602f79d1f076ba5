// The page's side of a worker with a lesson.

/** The scene of a lesson. `file` is a Blob, if the scene is one. */
export const sceneOf = (state, file) => ({
  scene: state.scene,
  ...(file && { name: file.name }),
  width: state.size,
  height: state.size,
  depth: state.depth,
  light_size: state.light,
  roughness: state.roughness,
});

/** A worker, to be closed: a lesson that blocks can be stopped in no other way. */
export class Lesson {
  #worker = new Worker(new URL('lesson-worker.js', import.meta.url), { type: 'module' });
  #waiting = new Map();
  #calls = 0;

  constructor() {
    this.#worker.addEventListener('message', ({ data }) => this.#receive(data));
    const fail = (event) => {
      event.preventDefault();
      this.#fail(new Error(event.message || 'The worker could not be loaded.'));
    };
    this.#worker.addEventListener('error', fail);
    this.#worker.addEventListener('messageerror', fail);
  }

  #receive({ id, progress, image, error, result }) {
    const waiting = this.#waiting.get(id);
    if (!waiting) return;
    if (progress) {
      waiting.onProgress?.(progress, image);
      return;
    }
    this.#waiting.delete(id);
    if (error === undefined) waiting.resolve(result);
    else waiting.reject(new Error(error));
  }

  #fail(error) {
    this.#waiting.forEach(({ reject }) => reject(error));
    this.#waiting.clear();
  }

  #call(call, values = {}, { onProgress, transfer = [] } = {}) {
    const id = ++this.#calls;
    return new Promise((resolve, reject) => {
      this.#waiting.set(id, { resolve, reject, onProgress });
      this.#worker.postMessage({ id, call, ...values }, transfer);
    });
  }

  /** The scenes and integrators of the engine. */
  catalogue(module) { return this.#call('catalogue', { module }); }
  /** Builds the scene, and describes it. */
  open(module, scene, file) { return this.#call('open', { module, scene, file }); }
  /** Line segments of the scene. */
  outline() { return this.#call('outline'); }
  /** Raster positions of points in space. */
  project(points) { return this.#call('project', { points: Float64Array.from(points) }); }
  /** Renders; reports and images go to a port. */
  render(job, port) { return this.#call('render', { job, port }, { transfer: [port] }); }
  /** Renders techniques; `onProgress` gets reports and images. */
  techniques(job, onProgress) { return this.#call('techniques', { job }, { onProgress }); }
  path(job) { return this.#call('path', { job }); }

  /** Ends the worker; calls under way never return. */
  close() {
    this.#waiting.clear();
    this.#worker.terminate();
  }
}

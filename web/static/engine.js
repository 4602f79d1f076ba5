// The Rust engine: what a browser must have for it, its code, and its catalogue.

import { Lesson } from './lesson.js';

/** True if workers may be modules: a browser that knows them reads the option. */
const hasModuleWorkers = () => {
  let isRead = false;
  const options = { get type() { isRead = true; return 'module'; } };
  try {
    new Worker('http://[', options);
  } catch {
    // That is no address; a browser that knows modules has read the option before it says so.
  }
  return isRead;
};

const compile = async (url) => {
  const response = await fetch(url);
  if (!response.ok) throw new Error(`The engine is missing: ${url.pathname} (${response.status}).`);
  // Streams are compiled only if the server names the right type.
  const isNamed = response.headers.get('Content-Type')?.startsWith('application/wasm');
  if (isNamed && WebAssembly.compileStreaming) return WebAssembly.compileStreaming(response);
  return WebAssembly.compile(await response.arrayBuffer());
};

/**
 * Compiles the engine once, for this page and all workers.
 * @returns {Promise<{module: WebAssembly.Module, catalogue: object}>}
 */
export const load = async () => {
  if (typeof WebAssembly !== 'object') {
    throw new Error('This browser has no WebAssembly, which the integrators need.');
  }
  if (!hasModuleWorkers()) {
    throw new Error('This browser has no module workers, in which the integrators run.');
  }
  if (typeof OffscreenCanvas !== 'function') {
    throw new Error('This browser cannot paint in workers: it has no OffscreenCanvas.');
  }
  let module;
  try {
    module = await compile(new URL('pathspace_web_bg.wasm', import.meta.url));
  } catch (error) {
    if (!(error instanceof WebAssembly.CompileError)) throw error;
    throw new Error(
      'This browser cannot compile the engine; it may be too old for SIMD instructions. '
      + `(${error.message})`,
    );
  }
  const lesson = new Lesson();
  try {
    return { module, catalogue: await lesson.catalogue(module) };
  } finally {
    lesson.close();
  }
};

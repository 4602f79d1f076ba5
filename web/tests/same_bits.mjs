// Compares the engine in WebAssembly with the native one: images to the bit, and samples per second.
//
// node web/tests/same_bits.mjs [PAGE-FOLDER] [NATIVE-PROGRAM]
//
// The native program runs on one thread without AVX, the engine in Node's V8, in turn.

import { execFileSync } from "node:child_process";
import { readFileSync } from "node:fs";
import { resolve } from "node:path";
import { pathToFileURL } from "node:url";

const page = resolve(process.argv[2] ?? "target/web");
const native = resolve(process.argv[3] ?? "target/release/examples/native");
const SCENES = ["cornell-box", "caustic"];
const SIZE = 64;
const SAMPLES = 32;

const engine = await import(pathToFileURL(`${page}/pathspace_web.js`));
const bytes = readFileSync(`${page}/pathspace_web_bg.wasm`);
engine.initSync({ module: new WebAssembly.Module(bytes) });
const { integrators } = JSON.parse(engine.catalogue());

const means = (image) =>
  [0, 1, 2].map((c) => {
    let sum = 0;
    for (let i = c; i < image.length; i += 3) sum += image[i];
    return (3 * sum) / image.length;
  });

const one = (scene, job) => {
  const lesson = new engine.Lesson(JSON.stringify(scene));
  let mean;
  const finished = JSON.parse(
    lesson.render(JSON.stringify(job), (_, image) => {
      mean = means(image);
      return false;
    }),
  );
  lesson.free();
  return { finished, mean };
};

const environment = { ...process.env, RAYON_NUM_THREADS: "1", PATHSPACE_SIMD: "sse2" };
const other = (scene, job) =>
  JSON.parse(execFileSync(native, [scene, job].map((x) => JSON.stringify(x)), { env: environment }));

const speed = ({ finished: { samples, seconds, preparation } }) => samples / (seconds - preparation);
let wrong = 0;
let logarithms = 0;
console.log("scene        integrator               bits of image  wasm/native samples per second");
for (const name of SCENES) {
  for (const { name: integrator } of integrators) {
    const scene = { scene: name, width: SIZE, height: SIZE, depth: 8 };
    const job = { integrator, samples: SAMPLES, seed: 7 };
    // V8 compiles functions for speed after they were called a while.
    one(scene, { ...job, samples: 4 });
    const [a, b] = [one(scene, job), other(scene, job)];
    const same = a.finished.fingerprint === b.finished.fingerprint;
    const difference = Math.max(...a.mean.map((x, c) => Math.abs(x / b.mean[c] - 1)));
    if (!same) wrong += 1;
    const ratio = speed(a) / speed(b);
    logarithms += Math.log(ratio);
    const bits = same ? "the same" : `mean off by ${difference.toExponential(1)}`;
    console.log(`${name.padEnd(12)} ${integrator.padEnd(24)} ${bits.padEnd(22)} ${ratio.toFixed(2)}`);
  }
}
const mean = Math.exp(logarithms / (SCENES.length * integrators.length));
console.log(`mean ratio of samples per second (geometric): ${mean.toFixed(2)}`);
if (wrong > 0) {
  console.error(`${wrong} images differ from the native ones`);
  process.exit(1);
}

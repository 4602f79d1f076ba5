// What of the lecture room needs no browser: addresses, errors and pictures, numbers, labels.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import { count, number, percent } from '../static/format.js';
import { cornersOf } from '../static/labels.js';
import {
  average, errorMap, exposed, gainOf, pixelOf, relativeWeights, weightedSquares,
} from '../static/pixels.js';
import { initial, read, withScene, write } from '../static/state.js';

const near = (a, b, tolerance = 1e-6) =>
  assert(Math.abs(a - b) <= tolerance * Math.max(Math.abs(a), Math.abs(b)), `${a} is not ${b}`);

test('an address says what differs, and is read back', () => {
  assert.equal(write(initial()), '#scene=cornell-box');
  const state = {
    ...initial(), scene: 'pool', integrators: ['path-tracing', 'vcm'], time: null, depth: 3,
    light: 0.5, roughness: 0.2, radius: 0.05, seed: 7, off: ['1,3', 'merge 2,2'], weighted: false,
    x: 3, y: 5, bounces: 2, technique: 'merge 2,3', reference: 'vcm', tab: 'path',
  };
  assert.deepEqual(read(write(state)), { state, run: false, wrong: [] });
});

test('links of the book are understood', () => {
  const { state, run, wrong } = read('#scene=cornell-box&integrators=path-tracing,light-tracing'
    + '&depth=8&light=0.5&roughness=0.2&radius=0.05&seed=1&time=10&board=1&run=1');
  assert.deepEqual(wrong, []);
  assert(run);
  assert.equal(state.tab, 'path');
  assert.deepEqual(state.integrators, ['path-tracing', 'light-tracing']);
  assert.equal(state.depth, 8);
  assert.equal(read('#pyramid=1').state.tab, 'techniques');
});

test('what an address has wrong is told and left out', () => {
  const { state, wrong } = read('#depth=-1&light=big&seed=1.5&time=&colour=red&scene=../x');
  assert.deepEqual(wrong, ['depth=-1', 'light=big', 'seed=1.5', 'time=', 'colour', 'scene=../x']);
  assert.deepEqual(state, initial());
});

test('another scene begins as it is, with the same integrators', () => {
  const state = withScene({ ...initial(), depth: 2, integrators: ['vcm'], off: ['1,1'] }, 'pool');
  assert.equal(state.depth, null);
  assert.deepEqual(state.off, []);
  assert.deepEqual(state.integrators, ['vcm']);
});

test('relMSE is that of the definition', () => {
  const reference = Float32Array.of(1, 2, 3, 4, 5, 6);
  const image = Float32Array.of(1.5, 2, 3, 4, 5, 5);
  const floor = 0.01 * 3.5 ** 2;
  const expected = (0.25 / (1 + floor) + 1 / (36 + floor)) / 6;
  near(weightedSquares(image, reference, relativeWeights(reference)), expected);
  assert.equal(relativeWeights(new Float32Array(6)), null);
});

test('the difference of two halves tells the error of their mean', () => {
  // Noise of variance 1/12 around 10; the mean of two has half of it.
  const noisy = () => Float32Array.from({ length: 60_000 }, () => 10 + Math.random() - 0.5);
  const [a, b] = [noisy(), noisy()];
  const truth = new Float32Array(60_000).fill(10);
  const weights = relativeWeights(truth);
  near(weightedSquares(a, b, weights) / 4, weightedSquares(average(a, b), truth, weights), 0.05);
});

test('pictures are exposed, and errors have a sign', () => {
  const grey = new Float32Array(3 * 100).fill(0.25);
  near(gainOf(grey), 2.8);
  assert.deepEqual([...exposed(grey, 4).subarray(0, 4)], [255, 255, 255, 255]);
  assert.equal(gainOf(new Float32Array(30)), 1);
  const map = (factor) => errorMap(grey.map((x) => factor * x), grey);
  const [exact, bright, dark] = [1, 2, 0].map((factor) => [...map(factor).subarray(0, 3)]);
  assert(exact[0] === exact[1] && exact[1] === exact[2]);
  assert(bright[0] > 250 && bright[2] < bright[0]);
  assert(dark[0] === 0 && dark[2] > 0);
  near(pixelOf(grey.map((x) => 1.1 * x), grey, 5).error, 0.1 / 1.02, 1e-4);
  assert.deepEqual([...errorMap(grey.map(() => NaN), grey).subarray(0, 3)], [255, 0, 255]);
});

test('numbers have three digits', () => {
  assert.equal(number(0.012345), '0.0123');
  assert.equal(number(-1234.5), '−1235');
  assert.equal(number(3.6187e-18), '3.62·10⁻¹⁸');
  assert.equal(number(0), '0');
  assert.equal(number(Infinity), '∞');
  assert.equal(number(null), '–');
  assert.equal(percent(0.57), '57 %');
  assert.equal(percent(0.032), '3.2 %');
  assert.equal(percent(1e-6), '< 0.01 %');
  assert.equal(count(34_000), '34 k');
});

test('labels of near vertices lie apart', () => {
  const [alone] = cornersOf([[50, 50]], 5);
  assert.deepEqual(alone, [1, -1]);
  const points = [[50, 50], null, [51, 50]];
  const corners = cornersOf(points, 5);
  assert.equal(corners[1], null);
  const [a, b] = [0, 2].map((i) => points[i].map((place, axis) => place + 5 * corners[i][axis]));
  assert(Math.hypot(a[0] - b[0], a[1] - b[1]) > 5);
});

// Drives the lecture room in Chromium as a student would, at the widths of a screen and of a phone.
//
//   npm install && npm test
//
// Environment: CHROMIUM, the browser [/usr/bin/chromium]; RACE, the seconds of a race [10]; SITE,
// the folder with the page [target/web]; OUT, for screenshots [target/web-test]; FRAME, the bound on
// frames in milliseconds [50], for machines that have other work as well.

import assert from 'node:assert/strict';
import { mkdir, readFile } from 'node:fs/promises';
import { fileURLToPath } from 'node:url';
import { join } from 'node:path';
import { chromium } from 'playwright-core';
import { serve } from './server.mjs';

const root = fileURLToPath(new URL('../..', import.meta.url));
const site = process.env.SITE ?? join(root, 'target/web');
const out = process.env.OUT ?? join(root, 'target/web-test');
const length = Number(process.env.RACE ?? 10);
const box = join(root, 'tests/data/gltf/box.glb');

/**
 * Milliseconds between frames while integrators race. More workers than processors are busy then,
 * and the browser's own threads wait for their turn like all others; so the bound holds for 95 % of
 * the frames. The longest one is printed.
 */
const FRAME = Number(process.env.FRAME ?? 50);
/** Shares of techniques are rounded to 0.1 %, the smallest to 0.01 %. */
const SHARES = 0.02;
/** Relative change of the sum's mean when a technique is switched off: noise of a few seconds. */
const MEAN = 0.05;

const VIEWS = { screen: { width: 1400, height: 1000 }, phone: { width: 390, height: 844 } };
const started = Date.now();
const say = (text) => console.log(`${((Date.now() - started) / 1000).toFixed(1).padStart(6)} s  ${text}`);

await mkdir(out, { recursive: true });
const { server, address } = await serve(site);
const browser = await chromium.launch({
  executablePath: process.env.CHROMIUM ?? '/usr/bin/chromium',
  args: [
    '--no-sandbox', '--disable-gpu', '--no-first-run', '--disable-background-networking',
    '--disable-component-update', '--disable-sync',
  ],
});

/** A page that notes what must not happen: errors, and requests to elsewhere. */
const openPage = async (options, hash) => {
  const context = await browser.newContext(options);
  const page = await context.newPage();
  const faults = [];
  page.on('console', (message) => {
    if (['error', 'warning'].includes(message.type())) faults.push(message.text());
  });
  page.on('pageerror', (error) => faults.push(error.stack));
  page.on('request', (request) => {
    if (!/^(http:\/\/127\.0\.0\.1:|blob:|data:)/.test(request.url())) faults.push(request.url());
  });
  page.on('response', (response) => {
    if (response.status() >= 400) faults.push(`${response.status()} ${response.url()}`);
  });
  // The gaps between frames, as the page's own meter sees them, of which it keeps the longest.
  await page.addInitScript(() => {
    window.gaps = [];
    let before = performance.now();
    const measure = (now) => {
      if (document.body?.dataset.phase === 'racing') window.gaps.push(now - before);
      before = now;
      requestAnimationFrame(measure);
    };
    requestAnimationFrame(measure);
  });
  await page.goto(`${address}#${hash}`);
  return { page, faults, close: () => context.close() };
};

const shot = (page, name, fullPage = true) =>
  page.screenshot({ path: join(out, `${name}.png`), fullPage });
const phase = (page, wanted, timeout) => page.waitForFunction(
  (wanted) => wanted.includes(document.body.dataset.phase), wanted, { timeout });
const noScroll = async (page) => {
  const [width, room] = await page.evaluate(() => [document.documentElement.scrollWidth, innerWidth]);
  assert(width <= room, `the page is ${width} px wide on ${room} px`);
};
/** Share of the pixels of a canvas that are not black. */
const lit = (page, selector) => page.locator(selector).first().evaluate((canvas) => {
  // A worker paints the canvas; a copy can be read.
  const copy = document.createElement('canvas');
  [copy.width, copy.height] = [64, 64];
  const context = copy.getContext('2d');
  context.drawImage(canvas, 0, 0, copy.width, copy.height);
  const { data } = context.getImageData(0, 0, copy.width, copy.height);
  let count = 0;
  for (let i = 0; i < data.length; i += 4) if (data[i] + data[i + 1] + data[i + 2] > 0) count++;
  return count / (data.length / 4);
});

const race = async (page, name) => {
  await phase(page, ['settling', 'done'], 60_000 + 4000 * length);
  // The last reports are shown a moment later.
  await page.waitForTimeout(1000);
  const cards = await page.locator('.card:not([data-name=reference])').evaluateAll((all) =>
    all.map((card) => ({
      name: card.dataset.name,
      passes: parseFloat(card.querySelector('figcaption').innerText.match(/([\d.]+ ?[kM]?) pass/)?.[1]),
      error: card.querySelector('b').textContent,
      kind: card.querySelector('.kind').textContent,
    })));
  const chosen = await page.locator('#desk input[type=checkbox]:checked').count();
  assert.equal(cards.length, chosen);
  for (const card of cards) {
    assert(card.passes > 0, `${card.name} has no passes: ${card.kind}`);
    const share = await lit(page, `.card[data-name="${card.name}"] canvas`);
    assert(share > 0.05, `${card.name} is black`);
  }
  const gaps = (await page.evaluate(() => window.gaps)).sort((a, b) => a - b);
  const at = (share) => gaps[Math.floor(share * (gaps.length - 1))].toFixed(0);
  const longest = (await page.evaluate(() => window.__frames)).toFixed(0);
  say(`${name}: ${cards.map(({ name, error }) => `${name} ${error}`).join(', ')}`);
  say(`${name}: ${gaps.length} frames, median ${at(0.5)} ms, 95 % within ${at(0.95)} ms, longest ${longest} ms`);
  assert(Number(at(0.95)) <= FRAME, 'frames are late');
};

/** Errors of an integrator as the plot reads them out, from the left to the right. */
const readCurve = async (page, name) => {
  const plot = page.locator('#plot');
  await plot.scrollIntoViewIfNeeded();
  await plot.focus();
  const errors = [];
  const read = async (key) => {
    await plot.press(key);
    const text = await page.locator('#plot-readout tr', { hasText: name }).locator('td').innerText();
    errors.push(Number(text.replace('·10', 'e').replace(/[⁰¹²³⁴⁵⁶⁷⁸⁹⁻]/g, (c) =>
      ({ '⁻': '-' }[c] ?? '⁰¹²³⁴⁵⁶⁷⁸⁹'.indexOf(c)))));
  };
  await read('ArrowRight');
  for (let i = 0; i < 30; i++) await read('ArrowLeft');
  return errors.reverse().filter((error) => error > 0);
};

/** The buttons that save pictures, and those that zoom. */
const look = async (page) => {
  for (const button of ['Save PNG', 'Save all']) {
    const [download] = await Promise.all([
      page.waitForEvent('download'), page.getByRole('button', { name: button }).click(),
    ]);
    const bytes = await readFile(await download.path());
    assert.equal(bytes.subarray(1, 4).toString(), 'PNG', `${button} saves no PNG`);
    assert(bytes.length > 10_000, `${button} saves ${bytes.length} bytes`);
  }
  const zoom = () => page.evaluate(() =>
    Number(document.documentElement.style.getPropertyValue('--zoom')));
  const view = page.locator('.card .view').first();
  await view.click();
  assert.equal(await zoom(), 4);
  await page.keyboard.press('+');
  assert.equal(await zoom(), 8);
  await page.getByRole('button', { name: 'Whole picture' }).click();
  assert.equal(await zoom(), 1);
  const shown = () => page.locator('#choices [aria-pressed=true]').getAttribute('data-name');
  await page.keyboard.press('2');
  assert.equal(await shown(), 'path-tracing');
  await page.keyboard.press('f');
  assert.equal(await shown(), 'reference');
};

const techniques = async (page, name) => {
  await page.getByRole('tab', { name: 'Techniques' }).click();
  const share = (technique) => page.locator(`.layer[data-name="${technique}"] .share`);
  const read = () => page.locator('.layer .share').evaluateAll((all) => all.map((element) =>
    (/^(off|<)/.test(element.textContent) ? 0 : parseFloat(element.textContent) / 100)));
  const mean = () => page.locator('#sum').evaluate((figure) => Number(figure.dataset.mean));
  const settled = () => page.waitForFunction(() =>
    /Finished/.test(document.querySelector('#techniques-status').textContent), null, { timeout: 60_000 });
  const sumsToOne = (shares) => {
    const sum = shares.reduce((a, b) => a + b, 0);
    assert(Math.abs(sum - 1) < SHARES, `shares add up to ${sum}`);
  };
  await settled();
  const before = { shares: await read(), mean: await mean() };
  sumsToOne(before.shares);
  await shot(page, `${name}-techniques`);
  const button = page.locator('.layer[data-name="1,3"]');
  assert.equal(await button.getAttribute('aria-pressed'), 'true');
  await button.focus();
  await page.keyboard.press('Enter');
  assert.equal(await button.getAttribute('aria-pressed'), 'false');
  await page.waitForFunction((element) => element.textContent === 'off', await share('1,3').elementHandle());
  await settled();
  const after = { shares: await read(), mean: await mean() };
  sumsToOne(after.shares);
  assert.notDeepEqual(after.shares, before.shares);
  const change = after.mean / before.mean - 1;
  say(`${name}: without (1,3) the mean changes by ${(100 * change).toFixed(2)} %`);
  assert(Math.abs(change) < MEAN, 'the sum changes without a technique');
  assert.match(await page.evaluate(() => location.hash), /off=1,3/);
  await shot(page, `${name}-techniques-off`);
  await page.getByRole('button', { name: 'All on' }).click();
};

const path = async (page, name) => {
  await page.getByRole('tab', { name: 'One path' }).click();
  await page.locator('#bounces').selectOption('3');
  const view = page.locator('#board-view');
  const { width, height } = await view.boundingBox();
  await view.click({ position: { x: 0.45 * width, y: 0.85 * height } });
  await page.locator('#weights-sum').waitFor({ timeout: 60_000 });
  const sum = await page.locator('#weights-sum').evaluate((row) => Number(row.dataset.sum));
  assert(Math.abs(sum - 1) < 1e-6, `weights add up to ${sum}`);
  assert.equal(await page.locator('tr[data-vertex]').count(), 5);
  await shot(page, `${name}-path`);
  // T_1 to T_3, the contribution, the estimate.
  for (let step = 1; step <= 5; step++) {
    assert.equal(await page.locator('#formula li').count(), step);
    assert.match(await page.locator('#step-name').innerText(), new RegExp(`${step} of 5`));
    if (step < 5) await page.getByRole('button', { name: 'Next' }).click();
  }
  assert(await page.locator('#next').isDisabled());
  await shot(page, `${name}-path-end`);
  await page.getByRole('button', { name: 'Back' }).click();
  assert.equal(await page.locator('#formula li').count(), 4);
  const status = page.locator('#path-status');
  const first = await page.locator('#tables').innerText();
  await page.getByRole('button', { name: 'Another path' }).click();
  await page.waitForFunction((first) => {
    const text = document.querySelector('#tables').innerText;
    return text !== '' && text !== first;
  }, first, { timeout: 60_000 });
  say(`${name}: ${await status.innerText()}`);
};

/** All that the catalogue has, the sliders, and addresses. */
const everything = async (page, name) => {
  await page.getByRole('tab', { name: 'Race' }).click();
  await page.getByText('More integrators').click();
  for (const box of await page.locator('#others input').all()) await box.check();
  const light = page.locator('[data-key=light] input');
  await light.focus();
  for (let i = 0; i < 10; i++) await page.keyboard.press('ArrowLeft');
  assert.match(await page.locator('[data-key=light] output').innerText(), /× 0\.\d+/);
  await phase(page, ['preparing', 'racing'], 10_000);
  await phase(page, ['settling'], 120_000 + 4000 * length);
  await page.waitForTimeout(1000);
  const works = await page.locator('.card figcaption').allInnerTexts();
  works.forEach((text) => assert.match(text, /pass/));
  assert.match(await page.evaluate(() => location.hash), /light=0\.\d+/);
  say(`${name}: ${works.length - 1} integrators, with a small light`);
  await shot(page, `${name}-everything`);
  await page.evaluate(() => { location.hash = '#scene=caustic&integrators=path-tracing,vcm&depth=5&time=5&run=1'; });
  await phase(page, ['racing'], 30_000);
  assert.equal(await page.locator('#scene').inputValue(), 'caustic');
  assert.match(await page.locator('[data-key=depth] output').innerText(), /^5 /);
  assert.equal(await page.locator('.card').count(), 3);
  await page.evaluate(() => { location.hash = '#scene=cornell-box'; });
  await page.waitForFunction(() => document.querySelector('#scene').value === 'cornell-box');
};

const files = async (page, name) => {
  await page.getByRole('tab', { name: 'Race' }).click();
  const desk = page.locator('#desk');
  if (!await desk.evaluate((element) => element.open)) await page.locator('#desk > summary').click();
  const broken = { name: '<img src=x>.glb', mimeType: 'model/gltf-binary', buffer: Buffer.from('no glTF') };
  await page.locator('#file').setInputFiles(broken);
  await page.locator('.message').waitFor();
  const message = await page.locator('.message').innerText();
  assert(message.includes(broken.name), message);
  say(`${name}: ${message.split('\n')[0]}`);
  assert.equal(await page.locator('#scene').inputValue(), 'cornell-box');
  await shot(page, `${name}-broken`, false);
  await page.locator('#file').setInputFiles({
    name: 'box.glb', mimeType: 'model/gltf-binary', buffer: await readFile(box),
  });
  await page.waitForFunction(() => document.querySelector('#scene').value === 'file', null, { timeout: 30_000 });
  assert.equal(await page.locator('.message').count(), 0);
  // The camera of the file has a wider film than the scene before.
  await page.waitForFunction(() =>
    Number(document.documentElement.style.getPropertyValue('--aspect')) > 1, null, { timeout: 30_000 });
  await page.locator('.card[data-name=path-tracing] figcaption', { hasText: 'samples/s' }).waitFor();
  await page.waitForTimeout(1000);
  assert(await lit(page, '.card[data-name=path-tracing] canvas') > 0.05, 'the file is black');
  await shot(page, `${name}-file`);
  await page.locator('#start').click();
  await phase(page, ['done'], 5000);
};

try {
  for (const [name, viewport] of Object.entries(VIEWS)) {
    const hash = `scene=cornell-box&time=${length}&run=1`;
    const { page, faults, close } = await openPage({ viewport, hasTouch: name === 'phone' }, hash);
    await phase(page, ['racing'], 60_000);
    await page.waitForTimeout(500 * length);
    await shot(page, `${name}-race`);
    await race(page, name);
    await noScroll(page);
    await page.getByText('Both', { exact: true }).click();
    await page.waitForTimeout(2000);
    await shot(page, `${name}-race-end`);
    const curve = await readCurve(page, 'path tracing');
    say(`${name}: path tracing from ${curve[0]} to ${curve.at(-1)}`);
    assert(curve.at(-1) < curve[0] / 2, 'the error does not fall');
    await look(page);
    await techniques(page, name);
    await noScroll(page);
    await path(page, name);
    await noScroll(page);
    if (name === 'screen') await everything(page, name);
    await files(page, name);
    assert.deepEqual(faults, []);
    await close();
  }
  const dark = await openPage({ viewport: VIEWS.screen, colorScheme: 'dark' }, 'scene=pool&board=1&x=80&y=110');
  await dark.page.locator('#weights-sum').waitFor({ timeout: 60_000 });
  await shot(dark.page, 'dark-path');
  assert.deepEqual(dark.faults, []);
  say('all is well');
} finally {
  await browser.close();
  server.close();
}

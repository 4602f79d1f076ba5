// The lecture room: puts the state of the page, its controls and its lessons together.

import { Board } from './board.js';
import { Cards } from './cards.js';
import { Desk } from './desk.js';
import { clamp, debounce, get, html, throttle } from './dom.js';
import * as engine from './engine.js';
import { number, seconds, words } from './format.js';
import { watchFrames } from './frames.js';
import { Lesson, sceneOf } from './lesson.js';
import { errorScale } from './pixels.js';
import { Pictures } from './pictures.js';
import { Plot, styleOf } from './plot.js';
import { Race } from './race.js';
import { download, sheet, Stage } from './stage.js';
import { initial, read, TIMES, withScene, write } from './state.js';
import { Statistics } from './statistics.js';
import { Techniques } from './techniques.js';
import { showWhole, zoom } from './views.js';

/** The reference of scene files: no path of theirs is known to be missing from it. */
const FILE_REFERENCE = 'bidirectional';
const TABS = ['race', 'techniques', 'path'];
const KINDS = { image: 'Images', error: 'Errors', both: 'Both' };

/** Tells the reader something that did not work, until the next thing works. */
const complain = (text) => get('messages').replaceChildren(html('p', { class: 'message bad' }, text,
  html('button', { type: 'button', 'aria-label': 'Close', onclick: () => quiet() }, '×')));
const quiet = () => get('messages').replaceChildren();

const open = async () => {
  const { module, catalogue } = await engine.load();
  const styles = new Map(catalogue.integrators.map(({ name }, i) => [name, styleOf(i)]));
  styles.set('reference', { colour: 'var(--ink)', dash: '' });
  const titles = new Map(catalogue.integrators.map(({ name, title }) => [name, title]));
  const statistics = new Statistics();
  const pictures = new Pictures();
  const reports = new Map();
  let state = initial();
  let file = null;
  let about = null;
  let kind = 'image';

  const sceneInfo = () => catalogue.scenes.find(({ name }) => name === state.scene);
  const reference = () => sceneInfo()?.reference ?? FILE_REFERENCE;

  // The values of all pictures under the pointer.
  let isLooking = false;
  const look = async (x, y) => {
    const readout = get('pixel-readout');
    if (x === undefined) {
      readout.hidden = true;
      return;
    }
    if (isLooking) return;
    isLooking = true;
    const [column, line] = [x, y].map((place) =>
      clamp(Math.floor(place * state.size), 0, state.size - 1));
    const values = await statistics.look(line * state.size + column);
    isLooking = false;
    readout.hidden = values.length === 0;
    const rows = values.map(([name, { radiance, error }]) => html('tr', {},
      html('th', { scope: 'row' }, words(name)),
      ...radiance.map((value) => html('td', {}, number(value))),
      html('td', {}, error === null ? '' : `${error > 0 ? '+' : ''}${number(100 * error)} %`)));
    const head = ['', 'R', 'G', 'B', 'error'].map((text) => html('th', {}, text));
    readout.replaceChildren(html('table', {}, html('caption', {}, `pixel (${column}, ${line})`),
      html('thead', {}, html('tr', {}, ...head)), html('tbody', {}, ...rows)));
  };

  const cards = new Cards(get('cards'), pictures);
  const stage = new Stage(pictures, look);
  const plot = new Plot(get('plot'), get('plot-readout'), styles);
  statistics.onPicture = (name, kind, pixels) => pictures.put(name, kind, pixels);
  statistics.onCurves = (curves, own) => {
    plot.show(curves, own);
    cards.errors(curves, own);
  };

  // What the race tells.
  const processors = navigator.hardwareConcurrency ?? 1;
  const tellPhase = (phase) => {
    const many = state.integrators.length;
    const shares = many + 2 > processors
      ? `${many + 2} workers, two of them for the reference, share ${processors} processors: each has ${Math.round(100 * processors / (many + 2))} % of one.`
      : `${many + 2} workers, two of them for the reference, each on a processor of its own.`;
    const texts = {
      idle: `Press Start: ${shares}`,
      preparing: 'Building the scene in every worker …',
      racing: shares,
      settling: 'The race is over. The reference goes on, and the errors are measured again.',
      done: 'The race is over.',
    };
    get('status').textContent = texts[phase];
    const isRunning = phase !== 'idle' && phase !== 'done';
    get('start').textContent = isRunning ? 'Stop' : 'Start';
    get('start').setAttribute('aria-pressed', isRunning);
    document.body.dataset.phase = phase;
    watchFrames(phase === 'racing');
  };
  const tellTime = () => {
    const longest = Math.max(0, ...[...reports].filter(([name]) => name !== 'reference')
      .map(([, report]) => report.seconds));
    const bar = get('progress').querySelector('progress');
    bar.hidden = state.time === null;
    bar.value = state.time === null ? 0 : Math.min(longest / state.time, 1);
    bar.title = seconds(longest);
  };
  // All at once: a page that changes ten times a frame is laid out ten times.
  const tellReports = throttle(300, () => {
    reports.forEach((report, name) => cards.report(name, report));
    tellTime();
  });
  const race = new Race(module, statistics, {
    phase: tellPhase,
    about(description) {
      about = description;
      desk.show(state, about);
    },
    report(name, report) {
      reports.set(name, report);
      tellReports();
    },
    result: (name, result) => cards.result(name, result),
    fault(name, error) {
      if (name === null) complain(error.message);
      else cards.fault(name, error);
    },
  });

  const empty = () => {
    reports.clear();
    plot.clear();
    tellTime();
    const sees = sceneInfo()?.sees;
    const contestants = state.integrators.map((name) => ({
      name,
      title: titles.get(name),
      style: styles.get(name),
      estimator: catalogue.integrators.find((known) => known.name === name).estimator,
      seesAll: sees?.includes(name),
    }));
    const title = 'Reference';
    cards.renew(
      [{ name: 'reference', title, style: styles.get('reference'), estimator: titles.get(reference()) }, ...contestants],
      look,
    );
    stage.renew(cards.titles());
    get('reference-name').textContent = `here ${titles.get(reference()) ?? words(reference())}`;
  };
  const start = () => {
    pictures.forget();
    empty();
    race.start(state, file, reference());
  };
  const startSoon = debounce(400, start);
  const previewSoon = debounce(100, () => race.preview(state, file, reference()));

  // Does what a change of the state asks for.
  const sceneKey = () => JSON.stringify([sceneOf(state, file), file?.number]);
  const raceKey = () =>
    JSON.stringify([sceneKey(), state.integrators, state.time, state.radius]);
  let known = { scene: null, race: null };
  const saveAddress = debounce(300, () => history.replaceState(null, '', write(state)));
  const techniques = new Techniques(module, statistics, (changes) => change(changes), ({ message }) => complain(message));
  const board = new Board(module, pictures, (changes) => change(changes), ({ message }) => complain(message));
  const show = ({ again = false } = {}) => {
    const keys = { scene: sceneKey(), race: raceKey() };
    const isOther = keys.scene !== known.scene;
    if (again || (keys.race !== known.race && race.phase !== 'idle')) {
      startSoon();
    } else if (keys.race !== known.race) {
      empty();
      if (isOther) previewSoon();
      tellPhase(race.phase);
    }
    known = keys;
    statistics.show(state.stops, kind !== 'image');
    desk.show(state, about);
    get('stops').value = state.stops;
    get('stops-text').textContent = `${state.stops > 0 ? '+' : ''}${state.stops}`;
    get('times').querySelectorAll('input').forEach((input) => {
      input.checked = input.value === String(state.time);
    });
    TABS.forEach((tab) => {
      get(tab).hidden = tab !== state.tab;
      get(`tab-${tab}`).setAttribute('aria-selected', tab === state.tab);
      get(`tab-${tab}`).tabIndex = tab === state.tab ? 0 : -1;
    });
    if (state.tab === 'techniques') techniques.show(state, file);
    else techniques.close();
    if (state.tab === 'path') board.show(state, file);
  };
  const change = (changes, options) => {
    const { scene } = changes;
    if (scene !== undefined) about = null;
    state = { ...(scene === undefined ? state : withScene(state, scene)), ...changes };
    if (state.scene !== 'file') file = null;
    saveAddress();
    show(options);
  };

  // Scenes in files.
  let files = 0;
  const openFile = async (chosen) => {
    const lesson = new Lesson();
    try {
      const blob = new Blob([await chosen.arrayBuffer()]);
      const next = { name: chosen.name, blob, number: ++files };
      // A file that cannot be rendered leaves everything as it was.
      await lesson.open(module, sceneOf({ ...initial(), scene: 'file', size: state.size }, next), blob);
      file = next;
      quiet();
      change({ scene: 'file' });
    } catch (error) {
      complain(error.message.includes(chosen.name) ? error.message : `${chosen.name}: ${error.message}`);
    } finally {
      lesson.close();
    }
  };
  const desk = new Desk(
    catalogue,
    (changes) => change(changes, { again: 'seed' in changes && race.phase !== 'idle' }),
    openFile,
  );
  desk.offer(initial().integrators);
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
    if (event.dataTransfer.files.length === 0) return;
    event.preventDefault();
    openFile(event.dataTransfer.files[0]);
  });

  // Controls of the race and of the pictures.
  const choices = (id, group, options, chosen, choose) => get(id).append(...options.map(([value, text]) => {
    const input = html('input', { type: 'radio', name: group, value: String(value) });
    input.checked = value === chosen;
    input.addEventListener('change', () => choose(value));
    return html('label', {}, input, text);
  }));
  const timeText = (time) => (time === null ? 'no limit' : `${time} s`);
  choices('times', 'time', TIMES.map((time) => [time, timeText(time)]), state.time, (time) => change({ time }));
  choices('kinds', 'kind', Object.entries(KINDS), kind, (chosen) => {
    kind = chosen;
    get('cards').dataset.kind = kind;
    get('scale').hidden = kind === 'image';
    stage.kind(kind === 'error' ? 'error' : 'image');
    statistics.show(state.stops, kind !== 'image');
  });
  get('cards').dataset.kind = kind;
  const scale = get('scale').querySelector('.colours');
  scale.style.background = `linear-gradient(to right, ${errorScale(33).join()})`;
  get('start').addEventListener('click', () => {
    if (race.phase === 'idle' || race.phase === 'done') start();
    else race.stop();
  });
  get('stops').addEventListener('input', ({ target }) => change({ stops: target.valueAsNumber }));
  get('zoom-in').addEventListener('click', () => zoom(2));
  get('zoom-out').addEventListener('click', () => zoom(0.5));
  get('zoom-whole').addEventListener('click', showWhole);
  get('save-all').addEventListener('click', async () => {
    const blob = await sheet(pictures, cards.texts(), state.size);
    if (blob) download(blob, `${state.scene}.png`);
  });
  TABS.forEach((tab, i) => {
    get(`tab-${tab}`).addEventListener('click', () => change({ tab }));
    get(`tab-${tab}`).addEventListener('keydown', ({ key }) => {
      const step = { ArrowLeft: -1, ArrowRight: 1 }[key];
      if (!step) return;
      const next = TABS[(i + step + TABS.length) % TABS.length];
      change({ tab: next });
      get(`tab-${next}`).focus();
    });
  });
  // On phones the desk would hide the pictures.
  const isNarrow = matchMedia('(max-width: 60rem)');
  const fold = () => { get('desk').open = !isNarrow.matches; };
  isNarrow.addEventListener('change', fold);
  fold();

  // The state that the address asks for; what is not here is said and left out.
  const follow = () => {
    const { state: wanted, run, wrong } = read(location.hash);
    const isScene = catalogue.scenes.some(({ name }) => name === wanted.scene)
      || (wanted.scene === 'file' && file);
    if (!isScene) {
      wrong.push(wanted.scene === 'file' ? 'scene=file (open the file again)' : `scene=${wanted.scene}`);
      wanted.scene = initial().scene;
    }
    wrong.push(...wanted.integrators.filter((name) => !titles.has(name)));
    wanted.integrators = wanted.integrators.filter((name) => titles.has(name));
    if (wanted.integrators.length === 0) {
      wanted.integrators = initial().integrators.filter((name) => titles.has(name));
    }
    if (wrong.length > 0) complain(`The address asks for what is not here: ${wrong.join(', ')}.`);
    if (wanted.scene !== state.scene) about = null;
    state = wanted;
    if (state.scene !== 'file') file = null;
    show({ again: run });
  };
  addEventListener('hashchange', follow);
  follow();
};

open().catch((error) => {
  document.body.dataset.phase = 'broken';
  complain(error.message);
});

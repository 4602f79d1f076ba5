// The lecture room: puts the state of the page, its controls and its lessons together.

import { Board } from './board.js';
import { Cards } from './cards.js';
import { radios, tabs } from './choices.js';
import { Desk } from './desk.js';
import { debounce, get } from './dom.js';
import { load } from './engine.js';
import { acceptFiles } from './files.js';
import { words } from './format.js';
import { watchFrames } from './frames.js';
import { Lesson, sceneOf } from './lesson.js';
import { complain, quiet } from './messages.js';
import { errorScale } from './pixels.js';
import { Pictures } from './pictures.js';
import { Plot, styleOf } from './plot.js';
import { showPhase, showTime } from './progress.js';
import { Race } from './race.js';
import { readoutOf } from './readout.js';
import { download, sheet, Stage } from './stage.js';
import { initial, read, TIMES, withScene, write } from './state.js';
import { Statistics } from './statistics.js';
import { Techniques } from './techniques.js';
import { showWhole, zoom } from './views.js';

/** The reference of scene files, of which nobody knows what is hard in them. */
const FILE_REFERENCE = 'vcm';
/** Own error from which the page warns of the reference. */
const NOISY = 0.02;
const TABS = ['race', 'techniques', 'path'];
const KINDS = [['image', 'Images'], ['error', 'Errors'], ['both', 'Both']];

const open = async () => {
  const { module, catalogue } = await load();
  const integrators = new Map(catalogue.integrators.map((integrator, i) =>
    [integrator.name, { ...integrator, style: styleOf(i) }]));
  const styles = new Map([...integrators].map(([name, { style }]) => [name, style]));
  const statistics = new Statistics((reports) => {
    reports.forEach(([name, report]) => cards.report(name, report));
    const times = reports.filter(([name]) => name !== 'reference').map(([, { seconds }]) => seconds);
    if (times.length > 0) showTime(Math.max(...times), state.time);
  }, (curves, own) => {
    plot.show(curves, own);
    cards.errors(curves, own);
    get('noisy').hidden = own < NOISY;
  });
  const pictures = new Pictures(statistics);
  let state = initial();
  /** The scene file, if there is one: {name, blob, number}. */
  let file = null;
  /** The description of the scene by a lesson, once it is built. */
  let about = null;
  let kind = 'image';

  const sceneInfo = () => catalogue.scenes.find(({ name }) => name === state.scene);
  const reference = () => state.reference ?? sceneInfo()?.reference ?? FILE_REFERENCE;

  // The pictures, and the plot.
  const look = readoutOf(statistics, () => about ?? { width: 1, height: 1 });
  const cards = new Cards(get('cards'), pictures);
  const stage = new Stage(pictures, look);
  const plot = new Plot(get('plot'), get('plot-readout'), styles);

  // The race.
  const enter = (phase) => {
    showPhase(phase, state.integrators.length);
    watchFrames(phase === 'racing');
    if (phase === 'racing') cards.begin();
  };
  const race = new Race(module, statistics, {
    phase: enter,
    about(description) {
      about = description;
      document.documentElement.style.setProperty('--aspect', about.width / about.height);
      desk.show(state, about);
    },
    result: (name, result) => cards.result(name, result),
    fault(name, error) {
      if (name === null) complain(error.message);
      else cards.fault(name, error);
    },
  });
  const empty = () => {
    plot.clear();
    get('noisy').hidden = true;
    showTime(0, state.time);
    const sees = sceneInfo()?.sees;
    const contestants = state.integrators.map((name) =>
      ({ ...integrators.get(name), seesAll: sees?.includes(name) }));
    const title = integrators.get(reference())?.title ?? words(reference());
    const style = { colour: 'var(--ink)' };
    const own = { name: 'reference', title, style, estimator: `by ${words(reference())}` };
    cards.renew([own, ...contestants], look);
    stage.renew(cards.titles());
    const { estimator } = integrators.get(reference()) ?? {};
    get('reference-name').textContent = `here ${title}, ${estimator}`;
  };
  const start = () => {
    empty();
    race.start(state, file, reference());
  };
  const startSoon = debounce(400, start);
  const previewSoon = debounce(100, () => race.preview(state, file, reference()));

  // Does what a change of the state asks for: `again` starts even if nothing has changed.
  let known = { scene: null, race: null };
  const follow = (again) => {
    const scene = JSON.stringify([sceneOf(state, file), file?.number]);
    const { integrators: names, time, radius } = state;
    const keys = { scene, race: JSON.stringify([scene, names, time, radius, reference()]) };
    const [isOtherScene, isOtherRace] = [keys.scene !== known.scene, keys.race !== known.race];
    known = keys;
    if (again || (isOtherRace && race.phase !== 'idle')) {
      startSoon();
    } else if (isOtherRace) {
      empty();
      enter('idle');
      if (isOtherScene) previewSoon();
    }
    if (state.tab === 'techniques') techniques.show(state, file);
    else techniques.close();
    if (state.tab === 'path') board.show(state, file);
  };
  const saveAddress = debounce(300, () => history.replaceState(null, '', write(state)));
  const show = (again = false) => {
    statistics.show(state.stops, kind !== 'image');
    desk.show(state, about);
    showTab(state.tab);
    showLength(state.time);
    get('stops').value = state.stops;
    get('stops-text').textContent = `${state.stops > 0 ? '+' : ''}${state.stops}`;
    follow(again);
  };
  const change = (changes) => {
    const { scene } = changes;
    if (scene !== undefined) about = null;
    state = { ...(scene === undefined ? state : withScene(state, scene)), ...changes };
    if (state.scene !== 'file') file = null;
    saveAddress();
    show();
  };
  const fault = ({ message }) => complain(message);
  const techniques = new Techniques(module, statistics, pictures, change, fault);
  const board = new Board(module, pictures, change, fault);

  // The controls.
  const showTab = tabs(TABS, (tab) => change({ tab }));
  const lengths = TIMES.map((time) => [time, time === null ? 'no limit' : `${time} s`]);
  const showLength = radios(get('times'), 'time', lengths, (time) => change({ time }));
  const showKind = radios(get('kinds'), 'kind', KINDS, (chosen) => {
    kind = chosen;
    get('cards').dataset.kind = kind;
    get('scale').hidden = kind === 'image';
    stage.kind(kind === 'error' ? 'error' : 'image');
    statistics.show(state.stops, kind !== 'image');
  });
  showKind(kind);
  get('cards').dataset.kind = kind;
  get('colours').style.background = `linear-gradient(to right, ${errorScale(33).join()})`;
  get('start').addEventListener('click', () => {
    if (race.phase === 'idle' || race.phase === 'done') start();
    else race.stop();
  });
  get('stops').addEventListener('input', ({ target }) => change({ stops: target.valueAsNumber }));
  get('zoom-in').addEventListener('click', () => zoom(2));
  get('zoom-out').addEventListener('click', () => zoom(0.5));
  get('zoom-whole').addEventListener('click', showWhole);
  get('save-all').addEventListener('click', async () => {
    const blob = await sheet(pictures, cards.texts());
    if (blob) download(blob, `${state.scene}.png`);
  });
  // The desk's seed is that of the race, too; a path's next seed leaves a race alone.
  const desk = new Desk(catalogue, initial().integrators, (changes) => {
    change(changes);
    if ('seed' in changes && race.phase !== 'idle') startSoon();
  });
  // On phones the desk would hide the pictures.
  const isNarrow = matchMedia('(max-width: 60rem)');
  const fold = () => { get('desk').open = !isNarrow.matches; };
  isNarrow.addEventListener('change', fold);
  fold();

  // A file that cannot be rendered leaves everything as it was.
  let files = 0;
  acceptFiles(async (chosen) => {
    const lesson = new Lesson();
    const next = { name: chosen.name, number: ++files };
    try {
      next.blob = new Blob([await chosen.arrayBuffer()]);
      const scene = sceneOf({ ...initial(), scene: 'file', size: state.size }, next);
      await lesson.open(module, scene, next.blob);
      file = next;
      quiet();
      change({ scene: 'file' });
    } catch ({ message }) {
      const reason = message.replace(`${chosen.name}: `, '');
      complain(`${chosen.name} cannot be opened as glTF 2.0: ${reason}`);
    } finally {
      lesson.close();
    }
  });

  // The state that the address asks for; what is not here is said and left out.
  const readAddress = () => {
    const { state: wanted, run, wrong } = read(location.hash);
    const isKnown = catalogue.scenes.some(({ name }) => name === wanted.scene);
    if (!isKnown && !(wanted.scene === 'file' && file)) {
      wrong.push(wanted.scene === 'file' ? 'the file, which is to be opened again' : wanted.scene);
      wanted.scene = initial().scene;
    }
    wrong.push(...wanted.integrators.filter((name) => !integrators.has(name)));
    wanted.integrators = wanted.integrators.filter((name) => integrators.has(name));
    if (wanted.reference !== null && !integrators.has(wanted.reference)) {
      wrong.push(wanted.reference);
      wanted.reference = null;
    }
    if (wanted.integrators.length === 0) wanted.integrators = initial().integrators;
    if (wrong.length > 0) complain(`The address asks for what is not here: ${wrong.join(', ')}.`);
    if (wanted.scene !== state.scene) about = null;
    state = wanted;
    if (state.scene !== 'file') file = null;
    show(run);
  };
  addEventListener('hashchange', readAddress);
  readAddress();
};

open().catch(({ message }) => {
  document.body.dataset.phase = 'broken';
  get('status').textContent = '';
  complain(message);
});

// One path on the board: through a pixel, in the picture and in space, with every factor of its
// contribution and every technique that could have drawn it.

import { clamp, debounce, get, html, svg } from './dom.js';
import { number, vertexName } from './format.js';
import { stepsOf } from './formulas.js';
import { cornersOf } from './labels.js';
import { Lesson, sceneOf } from './lesson.js';
import { SideView } from './sideview.js';
import { techniquesOf, verticesOf } from './tables.js';
import { watch } from './views.js';

/** Most bounces to choose from. */
const BOUNCES = 8;
/** Pieces of an edge in the picture: a straight line is straight there, but may leave the view. */
const PIECES = 16;
/** Milliseconds that a search has once another path is asked for: a new worker takes longer. */
const PATIENCE = 500;
/** From a vertex to its label, in widths of the picture. */
const LABEL = 0.05;

export class Board {
  #lesson = null;
  #opened = null;
  #about = null;
  #isBusy = false;
  #asked = null;
  #wish = null;
  #interrupt = () => {};
  #path = null;
  #edges = [];
  #steps = [];
  #step = 0;

  /** `change` gets changes of the state; `fault` an error. */
  constructor(module, pictures, change, fault) {
    Object.assign(this, { module, change, fault });
    this.view = get('board-view');
    this.side = new SideView(get('side'));
    this.overlay = svg('svg', { class: 'overlay', 'aria-hidden': true });
    this.view.append(this.overlay);
    pictures.attach(this.view.querySelector('canvas'), 'reference');
    watch(this.view, { pick: (x, y) => this.#pick(x, y) });
    this.view.addEventListener('keydown', (event) => this.#move(event));
    this.renew = debounce(150, () => this.#draw());
    [['from-side', 'side'], ['from-above', 'above'], ['from-behind', 'behind']].forEach(
      ([id, from]) => get(id).addEventListener('click', () => this.side.look(from)));
    get('next').addEventListener('click', () => this.#go(this.#step + 1));
    get('back').addEventListener('click', () => this.#go(this.#step - 1));
    get('another').addEventListener('click', () => change({ seed: (this.state.seed + 1) % 2 ** 32 }));
    get('bounces').append(new Option('any', ''), ...Array.from({ length: BOUNCES + 1 }, (_, k) =>
      new Option(k, k)));
    get('bounces').addEventListener('change', ({ target }) => {
      change({ bounces: target.value === '' ? null : Number(target.value), technique: null });
    });
    get('technique').addEventListener('change', ({ target }) => {
      change({ technique: target.value === '' ? null : target.value });
    });
    get('path-merges').addEventListener('change', ({ target }) => {
      change({ merges: target.checked, technique: null });
    });
  }

  /** Shows the path of a state. */
  show(state, file) {
    [this.state, this.file] = [state, file];
    get('bounces').value = state.bounces ?? '';
    get('path-merges').checked = state.merges;
    this.#offerTechniques();
    this.#mark();
    this.renew();
  }

  // The techniques that draw paths of the chosen length.
  #offerTechniques() {
    const { bounces, merges, technique } = this.state;
    const names = bounces === null ? [] : Array.from({ length: bounces + 3 }, (_, s) =>
      `${s},${bounces + 2 - s}`);
    if (merges && bounces > 0) {
      for (let s = 2; s <= bounces + 1; s++) names.push(`merge ${s},${bounces + 3 - s}`);
    }
    if (technique !== null && !names.includes(technique)) names.push(technique);
    const options = names.map((name) => new Option(/^m/.test(name) ? name : `(${name})`, name));
    get('technique').replaceChildren(new Option('any technique', ''), ...options);
    get('technique').value = technique ?? '';
  }

  // Columns and rows of the film.
  #film() { return [this.#about?.width ?? this.state.size, this.#about?.height ?? this.state.size]; }

  // The pixel of the state, or that in the middle.
  #pixel() {
    const { x, y } = this.state;
    return this.#film().map((size, axis) =>
      Math.min([x, y][axis] ?? Math.floor(size / 2), size - 1));
  }

  #pick(...place) {
    const [x, y] = this.#film().map((size, axis) =>
      clamp(Math.floor(place[axis] * size), 0, size - 1));
    this.change({ x, y });
  }

  // Arrow keys move the pixel, so that a mouse is not needed.
  #move(event) {
    const step = {
      ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1], Enter: [0, 0],
    }[event.key];
    if (!step || event.shiftKey || event.ctrlKey || event.altKey || event.metaKey) return;
    event.preventDefault();
    const film = this.#film();
    const [x, y] = this.#pixel().map((place, axis) =>
      clamp(place + step[axis], 0, film[axis] - 1));
    this.change({ x, y });
  }

  // Asks for the path of the state; of several wishes while one is under way the last.
  async #draw() {
    if (get('path').hidden) return;
    const { x, y, bounces, technique, merges, seed, radius } = this.state;
    const isMerge = technique?.startsWith('merge') ?? false;
    const job = { x, y, bounces, technique, merges: merges || isMerge, seed, radius };
    const [scene, file] = [sceneOf(this.state, this.file), this.file];
    const key = JSON.stringify([job, scene, file?.number]);
    if (key === this.#asked) return;
    this.#asked = key;
    this.#wish = { job, scene, file };
    if (this.#isBusy) {
      this.#interrupt();
      return;
    }
    this.#isBusy = true;
    while (this.#wish) {
      const wish = this.#wish;
      this.#wish = null;
      try {
        await this.#fulfil(wish);
      } catch (error) {
        this.#clear('');
        this.fault(error);
      }
    }
    this.#isBusy = false;
  }

  async #fulfil({ job, scene, file }) {
    await this.#open(scene, file);
    if (this.#wish) return;
    // How large the film of a file is, its camera says.
    const [x, y] = this.#pixel();
    this.#tell(`Looking for a path through pixel (${x}, ${y}) …`);
    const interrupted = new Promise((resolve) => {
      this.#interrupt = () => setTimeout(resolve, PATIENCE, null);
    });
    const path = await Promise.race([this.#lesson.path({ ...job, x, y }), interrupted]);
    if (path) {
      await this.#present(path);
    } else {
      this.#opened = null;
    }
  }

  // A worker with a scene.
  async #open(scene, file) {
    const key = JSON.stringify([scene, file?.number]);
    if (key === this.#opened) return;
    this.#opened = null;
    this.#lesson?.close();
    this.#lesson = new Lesson();
    this.#about = await this.#lesson.open(this.module, scene, file?.blob);
    this.side.scene(await this.#lesson.outline(), this.#about);
    this.#opened = key;
  }

  #tell(text) { get('path-status').textContent = text; }

  #clear(text) {
    this.#path = null;
    this.#tell(text);
    get('steps').hidden = true;
    get('tables').replaceChildren();
    this.overlay.replaceChildren();
    this.side.path([]);
    this.#mark();
  }

  async #present(path) {
    if (!path.found) {
      this.#clear(path.reason);
      return;
    }
    this.#path = path;
    const kind = path.bounces === 1 ? 'bounce' : 'bounces';
    this.#tell(`A path of ${path.bounces} ${kind}, drawn by technique ${path.technique} in sample `
      + `${path.sample}.`);
    this.#edges = await this.#projectEdges(path);
    this.#steps = stepsOf(path);
    get('steps').hidden = false;
    get('tables').replaceChildren(verticesOf(path), techniquesOf(path));
    this.#go(0);
  }

  // The edges in the picture, as pieces: places where one is not in front of the lens are null.
  async #projectEdges({ vertices }) {
    const positions = vertices.map(({ position }) => position);
    const edges = positions.slice(1).map((to, i) => [positions[i], to]);
    const points = edges.flatMap(([from, to]) => Array.from({ length: PIECES + 1 }, (_, piece) =>
      from.map((start, axis) => start + (to[axis] - start) * piece / PIECES)));
    const raster = await this.#lesson.project(points.flat());
    return edges.map((_, edge) => Array.from({ length: PIECES + 1 }, (_, piece) => {
      const i = 2 * (edge * (PIECES + 1) + piece);
      return Number.isFinite(raster[i]) && Number.isFinite(raster[i + 1])
        ? [raster[i], raster[i + 1]] : null;
    }));
  }

  // Goes to a step: its vertex and edge are marked everywhere.
  #go(step) {
    this.#step = clamp(step, 0, this.#steps.length - 1);
    const { title, vertex } = this.#steps[this.#step];
    get('back').disabled = this.#step === 0;
    get('next').disabled = this.#step === this.#steps.length - 1;
    get('step-name').textContent = `${title} (${this.#step + 1} of ${this.#steps.length})`;
    // As on a board, what has been written stays; the newest line has its numbers.
    const written = this.#steps.slice(0, this.#step + 1).map(({ formula, numbers, result }, i) => {
      const isNewest = i === this.#step;
      const short = html('p', { class: 'result' }, `= (${result.map(number).join(', ')})`);
      return html('li', { class: isNewest ? 'newest' : '' }, formula, isNewest ? numbers : short);
    });
    get('formula').replaceChildren(html('p', {}, 'T₀ = 1'), html('ol', {}, ...written));
    get('tables').querySelectorAll('[data-vertex]').forEach((row) => {
      row.classList.toggle('marked', Number(row.dataset.vertex) === vertex);
    });
    this.side.path(this.#path.vertices.map(({ position }) => position), vertex);
    this.#mark(vertex);
  }

  // The pixel and the path over the picture.
  #mark(marked = null) {
    const [width, height] = this.#film();
    const [x, y] = this.#pixel();
    this.overlay.setAttribute('viewBox', `0 0 ${width} ${height}`);
    this.overlay.style.setProperty('--text', `${LABEL * width}px`);
    const pixel = svg('rect', { x, y, width: 1, height: 1, class: 'pixel' });
    if (!this.#path) {
      this.overlay.replaceChildren(pixel);
      return;
    }
    const isInside = (point) => point?.every((place, axis) =>
      place >= 0 && place <= [width, height][axis]);
    const line = (points, kind) => {
      const known = points.filter((point) => point);
      return svg('polyline', { points: known.map((point) => point.join()).join(' '), class: kind });
    };
    // The first edge is a point: it leads into the lens.
    const edges = this.#edges.slice(1).map((points, i) => {
      const leaves = points.some((point) => !isInside(point));
      const kind = ['edge', leaves && 'outside', i + 1 === marked && 'marked'];
      return line(points, kind.filter((part) => part).join(' '));
    });
    const places = this.#path.vertices.map(({ raster }) => (isInside(raster) ? raster : null));
    const corners = cornersOf(places, LABEL * width);
    const dots = places.flatMap((place, k) => {
      if (!place) return [];
      const [u, v] = place;
      const [dx, dy] = corners[k];
      const kind = k === marked ? 'vertex marked' : 'vertex';
      // A line without length is a dot whose size does not grow with the picture.
      return [
        svg('path', { d: `M${u} ${v}h0`, class: kind }),
        svg('text', { x: u, y: v, dx: `${0.9 * dx}em`, dy: `${0.35 + 0.8 * dy}em` }, vertexName(k)),
      ];
    });
    this.overlay.replaceChildren(...edges, ...dots, pixel);
  }
}

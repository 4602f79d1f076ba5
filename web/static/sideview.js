// The scene from outside, without perspective: its outline, the lens, and a path in it.

import { clamp } from './dom.js';
import { vertexName } from './format.js';
import { cornersOf } from './labels.js';

const MARGIN = 34;
/** From a vertex to its label, along each axis. */
const LABEL = 12;
const subtract = (a, b) => a.map((x, i) => x - b[i]);
const isFinitePoint = (point) => point?.every(Number.isFinite);

export class SideView {
  #turn = { around: 0, above: 0.25 };
  #outline = new Float32Array();
  #about = null;
  #path = { points: [], step: null };

  constructor(canvas) {
    this.canvas = canvas;
    new ResizeObserver(() => this.draw()).observe(canvas);
    canvas.addEventListener('pointerdown', (event) => canvas.setPointerCapture(event.pointerId));
    canvas.addEventListener('pointermove', (event) => {
      if (event.buttons === 0) return;
      this.#move(event.movementX / 120, event.movementY / 120);
    });
    canvas.addEventListener('keydown', (event) => {
      const step = {
        ArrowLeft: [-0.15, 0], ArrowRight: [0.15, 0], ArrowUp: [0, -0.15], ArrowDown: [0, 0.15],
      }[event.key];
      if (!step) return;
      event.preventDefault();
      this.#move(...step);
    });
  }

  /** Shows a scene: its outline as line segments, and what a lesson says about it. */
  scene(outline, about) {
    [this.#outline, this.#about] = [outline, about];
    this.look('side');
  }

  /** Shows the points of a path; one step's vertex and edge are marked. */
  path(points, step = null) {
    this.#path = { points, step };
    this.draw();
  }

  /** Looks from the 'side' of the camera's direction, from 'above', or from 'behind' the lens. */
  look(from) {
    const { min, max, eye } = this.#about ?? {};
    const centre = min?.map((low, i) => (low + max[i]) / 2) ?? [0, 0, 0];
    const direction = isFinitePoint(eye) ? subtract(centre, eye) : [0, 0, 1];
    const behind = Math.atan2(-direction[0], -direction[2]);
    this.#turn = {
      side: { around: behind + Math.PI / 2, above: 0.12 },
      above: { around: behind, above: Math.PI / 2 },
      behind: { around: behind + 0.25, above: 0.25 },
    }[from];
    this.draw();
  }

  #move(x, y) {
    this.#turn.around -= x;
    this.#turn.above = clamp(this.#turn.above + y, -Math.PI / 2, Math.PI / 2);
    this.draw();
  }

  // The map from points in space to the canvas, which scene and lens fill. Lights may be at infinity.
  #projection(width, height) {
    const { around, above } = this.#turn;
    const [sin, cos, up, level] = [Math.sin(around), Math.cos(around), Math.sin(above), Math.cos(above)];
    const flat = ([x, y, z]) => [
      cos * x - sin * z,
      -(level * y - up * (sin * x + cos * z)),
    ];
    const { min, max, eye } = this.#about;
    const corners = [0, 1, 2, 3, 4, 5, 6, 7].map((bits) =>
      min.map((low, i) => ((bits >> i) & 1 ? max[i] : low)));
    const shown = [...corners, eye].filter(isFinitePoint).map(flat);
    const range = (i) => {
      const values = shown.map((point) => point[i]);
      return [Math.min(...values), Math.max(...values)];
    };
    const [[left, right], [top, bottom]] = [range(0), range(1)];
    const scale = Math.min(
      (width - 2 * MARGIN) / Math.max(right - left, 1e-9),
      (height - 2 * MARGIN) / Math.max(bottom - top, 1e-9),
    );
    return (point) => {
      const [x, y] = flat(point);
      return [
        width / 2 + scale * (x - (left + right) / 2),
        height / 2 + scale * (y - (top + bottom) / 2),
      ];
    };
  }

  draw() {
    const { canvas } = this;
    const { clientWidth: width, clientHeight: height } = canvas;
    if (width === 0 || !this.#about) return;
    const density = devicePixelRatio;
    [canvas.width, canvas.height] = [width * density, height * density];
    const context = canvas.getContext('2d');
    context.scale(density, density);
    const colours = getComputedStyle(canvas);
    const colour = (name) => colours.getPropertyValue(`--${name}`);
    const place = this.#projection(width, height);

    context.lineWidth = 1;
    context.strokeStyle = colour('outline');
    context.beginPath();
    const segments = this.#outline;
    for (let i = 0; i + 5 < segments.length; i += 6) {
      context.moveTo(...place([segments[i], segments[i + 1], segments[i + 2]]));
      context.lineTo(...place([segments[i + 3], segments[i + 4], segments[i + 5]]));
    }
    context.stroke();

    const text = (words, [x, y]) => {
      context.lineWidth = 4;
      context.strokeStyle = colour('paper');
      context.strokeText(words, x, y);
      context.fillText(words, x, y);
    };
    context.textAlign = 'center';
    context.textBaseline = 'middle';
    context.font = '600 13px system-ui, sans-serif';
    const { points, step } = this.#path;
    const { eye } = this.#about;
    if (isFinitePoint(eye) && points.length === 0) {
      const [x, y] = place(eye);
      context.fillStyle = colour('ink');
      context.fillRect(x - 4, y - 4, 8, 8);
      text('lens', [x, y + LABEL]);
    }
    const places = points.map((point) => (isFinitePoint(point) ? place(point) : null));
    places.slice(1).forEach((to, i) => {
      const from = places[i];
      if (!from || !to) return;
      context.lineWidth = i === step ? 4 : 2;
      context.strokeStyle = colour(i === step ? 'marked' : 'path');
      context.beginPath();
      context.moveTo(...from);
      context.lineTo(...to);
      context.stroke();
    });
    const corners = cornersOf(places, LABEL);
    places.forEach((vertex, i) => {
      if (!vertex) return;
      context.fillStyle = colour(i === step ? 'marked' : 'path');
      context.beginPath();
      context.arc(...vertex, i === step ? 6 : 4, 0, 2 * Math.PI);
      context.fill();
      context.fillStyle = colour('ink');
      text(vertexName(i), vertex.map((place, axis) => place + LABEL * corners[i][axis]));
    });
  }
}

// A race: integrators that render the same scene at the same time, each in a worker of its own,
// with two more for the reference.

import { Lesson, sceneOf } from './lesson.js';

/** The reference goes on after the race for so many times its length: all errors are then better
 * known. */
const REFERENCE_GOES_ON = 3;
/** Seconds of the picture that is shown before a race. */
const PREVIEW = 1.5;
/** Seeds of the reference are far from those that people type. */
const REFERENCE_SEEDS = [0x5eed0001, 0x5eed0002];

/**
 * @typedef {'idle' | 'preparing' | 'racing' | 'settling' | 'done'} Phase
 * settling: the race is over, the reference goes on
 */

export class Race {
  #lessons = [];
  #timer;
  /** @type {Phase} */
  phase = 'idle';

  /**
   * @param statistics where images go
   * @param on listeners: phase(phase), about(description), result(name, result),
   *   fault(name or null, error)
   */
  constructor(module, statistics, on) {
    Object.assign(this, { module, statistics, on });
  }

  #enter(phase) {
    this.phase = phase;
    this.on.phase(phase);
  }

  #close() {
    clearTimeout(this.#timer);
    this.#lessons.forEach((lesson) => lesson.close());
    this.#lessons = [];
  }

  /** Ends whatever is under way; pictures and curves stay. */
  stop() {
    this.#close();
    if (this.phase !== 'idle') this.#enter('done');
  }

  // Lessons of a state, all with their scene built: they start together. Null if there are none,
  // or if others have been asked for in the meantime.
  async #open(count, state, file) {
    this.#close();
    const lessons = Array.from({ length: count }, () => new Lesson());
    this.#lessons = lessons;
    try {
      const scene = sceneOf(state, file);
      const opened = lessons.map((lesson) => lesson.open(this.module, scene, file?.blob));
      const [about] = await Promise.all(opened);
      if (this.#lessons !== lessons) return null;
      this.statistics.film(about.width);
      this.on.about(about);
      return lessons;
    } catch (error) {
      if (this.#lessons === lessons) {
        this.#close();
        this.#enter('idle');
        this.on.fault(null, error);
      }
      return null;
    }
  }

  #reference(lesson, integrator, half, limit = null) {
    const job = { integrator, seconds: limit, samples: null, seed: REFERENCE_SEEDS[half], radius: null };
    const port = this.statistics.portFor('reference', half);
    return lesson.render(job, port).catch((error) => this.on.fault('reference', error));
  }

  /** Shows what the scene looks like. */
  async preview(state, file, integrator) {
    this.statistics.reset();
    this.#enter('idle');
    const lessons = await this.#open(1, state, file);
    if (!lessons) return;
    await this.#reference(lessons[0], integrator, 0, PREVIEW);
    if (this.#lessons === lessons) this.#close();
  }

  /** Starts all integrators of a state. */
  async start(state, file, reference) {
    this.statistics.reset();
    this.#enter('preparing');
    const names = state.integrators;
    const lessons = await this.#open(names.length + REFERENCE_SEEDS.length, state, file);
    if (!lessons) return;
    this.#enter('racing');
    REFERENCE_SEEDS.forEach((_, half) => {
      this.#reference(lessons[names.length + half], reference, half);
    });
    await Promise.all(names.map((name, i) => this.#contest(lessons[i], name, state)));
    if (this.#lessons !== lessons) return;
    this.#enter('settling');
    this.#timer = setTimeout(() => this.stop(), 1000 * REFERENCE_GOES_ON * state.time);
  }

  async #contest(lesson, name, { time, seed, radius }) {
    const job = { integrator: name, seconds: time, samples: null, seed, radius };
    try {
      this.on.result(name, await lesson.render(job, this.statistics.portFor(name)));
    } catch (error) {
      this.on.fault(name, error);
    }
    lesson.close();
  }
}

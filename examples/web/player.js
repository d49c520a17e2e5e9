// Plays an animation, or shows one step of it.

import { Smoke } from './smoke.js';

const STEPS_PER_SECOND = 14;
/** How long the first and the last step stand, in steps. */
const REST = 10;

export class Player {
  constructor() {
    const [stage, play, frame, clock] = ['stage', 'play', 'frame', 'clock'].map((id) => document.getElementById(id));
    Object.assign(this, { smoke: new Smoke(stage), play, frame, clock, at: 0, playing: false, animation: null });
    play.addEventListener('click', () => (this.playing ? this.pause() : this.start()));
    frame.addEventListener('input', () => {
      this.pause();
      this.show(Number(frame.value));
    });
  }

  /** Shows a density alone. */
  still(density, n, target) {
    this.pause();
    this.animation = null;
    this.at = 0;
    [this.play.disabled, this.frame.disabled] = [true, true];
    this.smoke.draw(density, n, { full: brightest(density), target });
    this.#tell(0);
  }

  /** Takes an animation of `steps` steps, `densities` one after the other, and goes on where the last one was. */
  take({ densities, n, steps, target }) {
    const frames = Array.from({ length: steps + 1 }, (_, i) => densities.subarray(i * n * n, (i + 1) * n * n));
    const first = this.animation === null;
    this.animation = { frames, n, target, full: brightest(frames[0]) };
    [this.play.disabled, this.frame.disabled] = [false, false];
    this.frame.max = steps;
    this.at = Math.min(this.at, steps);
    if (first) this.start();
    else this.show(this.at);
  }

  start() {
    if (!this.animation || this.playing) return;
    this.#set(true);
    let before = performance.now();
    let rest = this.at === 0 ? REST : 0;
    const tick = (now) => {
      if (!this.playing) return;
      // A frame's time may lie before the call that asked for it.
      let passed = (Math.max(0, now - before) * STEPS_PER_SECOND) / 1e3;
      before = now;
      const waited = Math.min(rest, passed);
      rest -= waited;
      passed -= waited;
      const last = this.animation.frames.length - 1;
      if (this.at >= last && passed > 0) [this.at, rest] = [0, REST];
      else if (this.at + passed >= last) [this.at, rest] = [last, REST];
      else this.at += passed;
      this.show(this.at);
      requestAnimationFrame(tick);
    };
    requestAnimationFrame(tick);
  }

  pause() {
    this.#set(false);
  }

  /** Shows a step; between two steps, a blend of them. */
  show(at) {
    this.at = at;
    const { frames, n, target, full } = this.animation;
    const step = Math.min(Math.floor(at), frames.length - 1);
    const [low, high] = [frames[step], frames[Math.min(step + 1, frames.length - 1)]];
    const part = at - step;
    const density = part > 0 ? low.map((value, i) => value + part * (high[i] - value)) : low;
    this.smoke.draw(density, n, { full, target });
    this.#tell(step);
  }

  #tell(step) {
    this.frame.value = step;
    this.clock.textContent = `${step} / ${this.frame.max}`;
  }

  #set(playing) {
    this.playing = playing;
    this.play.classList.toggle('playing', playing);
    this.play.setAttribute('aria-label', playing ? 'Pause' : 'Play');
  }
}

/** What is shown brightest: a little more than the densest smoke, so that there is something to see inside. */
function brightest(density) {
  return 1.08 * Math.max(1e-6, density.reduce((most, value) => Math.max(most, value), 0));
}

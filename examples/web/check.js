// What `?test` runs: the page as a visitor uses it, and the same bits as elsewhere. The outcome is the title of the page and the query
// of a request, so that whoever serves the page reads it in the log.

import { page } from './main.js';
import { Solve } from './thurible.js';

/** The hash of the densities that the native library finds for the scene of `sameBits`. */
const BITS = 0x40b41b6c;
/** A machine may be slow, but not this slow. */
const PATIENCE = 60e3;

const at = (id) => document.getElementById(id);
const state = () => document.body.dataset.state;

run().then(
  () => tell('ok'),
  (error) => tell(`failed: ${error.message}`),
);

function tell(outcome) {
  document.title = outcome;
  return fetch(`outcome?${encodeURIComponent(outcome)}`);
}

async function run() {
  await sameBits();
  await emits();
  await solves();
  await plays();
  await stops();
  await refuses();
}

async function sameBits() {
  const module = await WebAssembly.compileStreaming(fetch('thurible.wasm'));
  holds(WebAssembly.Module.imports(module).length === 0, 'the module imports something');
  const block = (x, y) => Float32Array.from({ length: 256 }, (_, i) => Number(i % 16 >= x && i % 16 < x + 5 && i >> 4 >= y && i >> 4 < y + 5));
  const solver = new Solve(module, { cells: [16, 16], steps: 6, keyframes: [6], iterations: 4 }, { preview: true });
  solver.setSource(block(3, 4));
  solver.setKeyframe(0, block(8, 7));
  // Looking at the animation in between changes nothing.
  while (solver.step().status === 0) solver.preview(6);
  solver.finish();
  const hash = new Uint32Array(solver.densities(6).buffer).reduce((hash, word) => Math.imul(hash ^ word, 0x01000193), 0x811c9dc5) >>> 0;
  holds(hash === BITS, `other bits: 0x${hash.toString(16)}`);
}

async function emits() {
  const module = await WebAssembly.compileStreaming(fetch('thurible.wasm'));
  const shape = Float32Array.from({ length: 256 }, (_, i) => Number(i % 16 >= 6 && i % 16 < 10 && i >> 4 < 3));
  const mass = (density) => density.reduce((sum, value) => sum + value, 0);
  const scene = { cells: [16, 16], steps: 6, method: 4, emitters: [{ from: 1, to: 4, rate: 0.5 }], buoyancy: [0, 0.01, 0] };
  const solver = new Solve(module, scene);
  solver.setEmitter(0, shape);
  while (solver.step().status === 0);
  solver.finish();
  const densities = solver.densities(6);
  const grown = Array.from({ length: 7 }, (_, step) => mass(densities.slice(256 * step, 256 * (step + 1))) / mass(shape));
  const wanted = [0, 0, 0.5, 1, 1.5, 1.5, 1.5];
  holds(distance(grown, wanted) < 1e-3, `the emitter made ${grown}`);
  const height = (step) => mass(densities.slice(256 * step, 256 * (step + 1)).map((value, i) => value * (i >> 4)));
  holds(height(6) > height(4), 'the smoke does not rise');
  let refusal = '';
  try {
    new Solve(module, { ...scene, emitters: [{ from: 1, to: 4 }] });
  } catch (error) {
    refusal = error.message;
  }
  holds(refusal.includes('emitters[0]'), `an emitter without rate and target: ${refusal}`);
}

async function solves() {
  choose({ cells: 32, steps: 8, iterations: 3 });
  page.pads.to.shape('heart');
  at('solve').click();
  holds(state() === 'solving', 'the solve did not begin');
  await until(() => state() !== 'solving', 'the end of a solve');
  holds(state() === 'done', `the solve ended as ${state()}: ${at('error').textContent}`);
  const { frames, target } = page.player.animation;
  holds(frames.length === 9, `there are ${frames.length} frames`);
  holds(distance(frames[8], target) < 0.5 * distance(frames[0], target), 'the smoke did not come near the shape');
  holds(page.chart.points.length >= 3, 'the chart has no points');
}

async function plays() {
  const seen = () => page.player.smoke.pixels.reduce((sum, pixel) => (Math.imul(sum, 31) + pixel) | 0, 0);
  const shown = (step) => {
    at('frame').value = step;
    at('frame').dispatchEvent(new Event('input'));
    holds(!page.player.playing && at('clock').textContent === `${step} / 8`, `step ${step} is not shown`);
    return seen();
  };
  holds(shown(0) !== shown(8), 'first and last step look the same');
  shown(3);
  at('play').click();
  await until(() => Number(at('frame').value) > 4, 'the animation');
  at('play').click();
  holds(!page.player.playing, 'the animation does not pause');
}

async function stops() {
  choose({ cells: 64, steps: 30, iterations: 500 });
  at('solve').click();
  await until(() => page.chart.points.length >= 2, 'the first iterations');
  at('stop').click();
  await until(() => state() !== 'solving', 'the stop');
  holds(state() === 'stopped', `stopping ended as ${state()}`);
  holds(page.player.animation.frames.length === 31, 'a stopped solve leaves no animation');
}

async function refuses() {
  page.pads.from.clear();
  at('solve').click();
  await until(() => state() !== 'solving', 'the refusal');
  holds(state() === 'error' && !at('error').hidden && at('error').textContent.includes('mass'), `an empty source: ${at('error').textContent}`);
  page.pads.from.shape('ring');
  choose({ cells: 32, steps: 1, iterations: 3 });
  at('solve').click();
  await until(() => state() !== 'solving', 'the refusal');
  holds(state() === 'error' && at('error').textContent.includes('must be from 2'), `one step: ${at('error').textContent}`);
}

function choose(values) {
  for (const [id, value] of Object.entries(values)) {
    at(id).value = value;
    at(id).dispatchEvent(new Event('change'));
  }
}

function distance(left, right) {
  return Math.hypot(...left.map((value, i) => value - right[i]));
}

function holds(condition, otherwise) {
  if (!condition) throw new Error(otherwise);
}

async function until(condition, what) {
  const end = performance.now() + PATIENCE;
  while (!condition()) {
    holds(performance.now() < end, `waited in vain for ${what}`);
    await new Promise((resume) => setTimeout(resume, 20));
  }
}

// The page: what is drawn goes to the worker, what it finds to the stage.

import { Chart } from './chart.js';
import { Pad } from './pad.js';
import { Player } from './player.js';

const at = (id) => document.getElementById(id);
const controls = Object.fromEntries(['brush', 'cells', 'steps', 'iterations', 'solve', 'stop', 'error', 'status', 'caption'].map((id) => [id, at(id)]));

const pads = {};
const player = new Player();
const chart = new Chart(at('chart'));

/** The module, compiled, and the solve that is going on. */
let module = null;
let solve = null;

/** What the page shows, for whoever checks it. */
export const page = { player, chart, pads };

begin();

async function begin() {
  const options = { brush: () => Number(controls.brush.value) / 100, changed };
  pads.from = new Pad('from', options);
  pads.to = new Pad('to', options);
  pads.to.write('S');
  pads.from.shape('circle', radiusOf(pads.to));
  for (const id of ['cells', 'steps']) controls[id].addEventListener('change', still);
  controls.solve.addEventListener('click', start);
  controls.stop.addEventListener('click', stop);
  window.addEventListener('error', ({ message }) => fail(message));
  window.addEventListener('unhandledrejection', ({ reason }) => fail(reason.message));
  try {
    module = await load('thurible.wasm');
    become('idle', 'Ready.');
  } catch (error) {
    fail(error.message);
  }
  if (new URLSearchParams(location.search).has('test')) await import('./check.js');
}

async function load(name) {
  const answer = await fetch(name);
  if (!answer.ok) throw new Error(`${name} is not here (${answer.status}): make it with examples/web/build`);
  return WebAssembly.compile(await answer.arrayBuffer());
}

/** A circle to begin with has as much smoke as the shape that it becomes. */
function radiusOf(pad) {
  const density = pad.density(64);
  const share = density.reduce((sum, value) => sum + value, 0) / density.length;
  return Math.min(0.42, Math.max(0.05, Math.sqrt(share / Math.PI)));
}

function changed(pad) {
  if (!pads.from || !pads.to) return;
  if (pad === pads.to && pads.from.preset === 'circle') pads.from.shape('circle', radiusOf(pads.to));
  else still();
}

/** What will be solved, before it is. */
function still() {
  if (solve) return;
  const n = Number(controls.cells.value);
  at('frame').max = controls.steps.value;
  player.still(pads.from.density(n), n, pads.to.density(n));
  controls.caption.textContent = '';
}

function start() {
  const [n, steps, iterations] = ['cells', 'steps', 'iterations'].map((id) => Number(controls[id].value));
  const [source, keyframe] = [pads.from.density(n), pads.to.density(n)];
  still();
  chart.clear();
  controls.error.hidden = true;
  solve = { n, steps, target: keyframe, worker: new Worker('worker.js', { type: 'module' }) };
  solve.worker.onmessage = ({ data }) => hear[data.type](data);
  solve.worker.onerror = ({ message }) => fail(message ?? 'the worker could not be started');
  become('solving', 'Preparing …');
  const scene = { cells: [n, n], steps, keyframes: [steps], iterations };
  solve.worker.postMessage({ type: 'solve', module, scene, source, keyframe });
}

function stop() {
  controls.stop.disabled = true;
  solve.worker.postMessage({ type: 'stop' });
}

const hear = {
  planned({ bytes }) {
    controls.status.textContent = `Memory: ${megabytes(bytes)} MB, taken once.`;
  },
  progress({ progress }) {
    chart.add(progress);
    const { iteration, cells, data, force } = progress;
    controls.status.textContent = `Iteration ${iteration} on ${cells[0]} × ${cells[1]} cells, objective ${number(data + force)}`;
  },
  preview({ densities }) {
    player.take({ ...solve, densities });
    controls.caption.textContent = 'so far';
  },
  result({ densities, how, data, force, iteration, seconds }) {
    player.take({ ...solve, densities });
    controls.caption.textContent = '';
    end(
      how === 'stopped' ? 'stopped' : 'done',
      `${how[0].toUpperCase()}${how.slice(1)}. ${iteration} iterations on all grids in ${seconds.toFixed(1)} s. ` +
        `Objective ${number(data + force)}: ${number(data)} for the shape, ${number(force)} for the force.`,
    );
  },
  error({ message }) {
    fail(message);
  },
};

function end(state, words) {
  solve?.worker.terminate();
  solve = null;
  become(state, words);
}

function fail(words) {
  controls.error.textContent = `${words[0].toUpperCase()}${words.slice(1)}.`;
  controls.error.hidden = false;
  end('error', 'Nothing was solved.');
}

function become(state, words) {
  controls.status.textContent = words;
  controls.solve.disabled = module === null || state === 'solving';
  controls.stop.disabled = state !== 'solving';
  document.body.dataset.state = state;
}

function number(value) {
  return Number(value.toPrecision(3)).toString();
}

function megabytes(bytes) {
  return (bytes / 1e6).toFixed(1);
}

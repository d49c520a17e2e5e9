// The solve, away from the page: one iteration at a time, and between two of them the page is heard.

import { Refused, STATUS, Solve } from './thurible.js';

/** Of the time, at most this part goes into showing what the animation would be now. */
const PREVIEW_SHARE = 0.2;

let stopping = false;

self.onmessage = ({ data }) => {
  if (data.type === 'stop') stopping = true;
  if (data.type === 'solve') solve(data).catch((error) => self.postMessage({ type: 'error', message: words(error) }));
};

async function solve({ module, scene, source, keyframe }) {
  stopping = false;
  const began = performance.now();
  const solver = new Solve(module, scene, { preview: true });
  solver.setSource(source);
  solver.setKeyframe(0, keyframe);
  self.postMessage({ type: 'planned', bytes: solver.bytes });

  let progress;
  let previewing = 0;
  do {
    progress = solver.step();
    self.postMessage({ type: 'progress', progress });
    const now = performance.now();
    if (progress.status === STATUS.GOES && previewing < PREVIEW_SHARE * (now - began)) {
      show('preview', solver.preview(scene.steps));
      previewing += performance.now() - now;
    }
    await breath();
  } while (progress.status === STATUS.GOES && !stopping);

  const { status, data, force } = solver.finish();
  if (status === STATUS.NOT_FINITE) throw new Refused('the solve left the finite numbers; take more steps or a smaller distance');
  const how = progress.status === STATUS.GOES ? 'stopped' : solver.statusText(status);
  show('result', solver.densities(scene.steps), { how, data, force, iteration: progress.iteration, seconds: (performance.now() - began) / 1e3 });
}

/** Lets messages in. */
function breath() {
  return new Promise((resume) => setTimeout(resume));
}

function show(type, densities, more) {
  if (densities) self.postMessage({ type, densities, ...more }, [densities.buffer]);
}

function words(error) {
  if (error instanceof WebAssembly.RuntimeError) return `the module trapped: ${error.message}`;
  return error.message;
}

// The C interface of thurible (core/ffi/thurible.h) for JavaScript. Works in a page, in a worker and without a browser.

// The structures, word for word as the header declares them.
const CONFIG = layout(`
  size_t size; uint32_t precision; uint32_t dimensions; size_t cells[3]; uint32_t boundary[3]; uint32_t method; double length; double dt;
  size_t steps; const size_t *keyframes; size_t keyframe_count; const double *keyframe_weights; const ThuribleEmitter *emitters;
  size_t emitter_count; const ThuribleFactor *schedule; size_t schedule_count; const ThuribleTemplate *templates;
  size_t template_count; size_t release; double buoyancy[3];
  double force_weight; double viscosity; double smoothness; uint32_t filters;
  uint32_t match_mass; uint32_t scheme; uint32_t keyframe_regions; uint32_t solids; uint32_t mask; double advection_tolerance; double projection_tolerance; size_t iterations;
  size_t threads; size_t memory_ceiling; uint32_t direct_history; uint32_t direct_nested; double direct_tolerance; double admm_penalty;
  double admm_relaxation; double admm_ao_momentum; double admm_density_tolerance; uint32_t admm_ao_iterations; uint32_t admm_nested;
  uint32_t nso_solver; uint32_t nso_cycles; double nso_tolerance; uint32_t nso_norm; uint32_t nso_colours; double lbfgs_tolerance;
  uint32_t lbfgs_history; uint32_t lbfgs_nested; double pd_drive; double pd_attenuation; double pd_gathering; double simulation_tolerance;
  uint32_t templates_history; uint32_t direct_coarse_iterations; double templates_tolerance;
  double guide_radius; double guide_smoothness; double guide_kinetic; double guide_penalty; uint32_t guide_iterations; uint32_t guide_solver;
  uint32_t direct_history_precision; uint32_t lbfgs_history_precision; double guide_curl_noise; double guide_noise_sigma;
  uint32_t guide_noise_seed; uint32_t no_slip; double direct_coarse_force_weight;
`);
const EMITTER = layout(`
  size_t from; size_t to; double rate; double target; double velocity[3]; uint32_t pushes; uint32_t reserved;
`);
const FACTOR = layout(`
  size_t step; double factor;
`);
const TEMPLATE = layout(`
  uint32_t kind; uint32_t moves; size_t from; size_t to; size_t interval; double center[3]; double radius; double amplitude[3]; double size;
  uint32_t seed; uint32_t reserved;
`);
const PROGRESS = layout(`
  ThuribleStatus status; size_t iteration; double data; double force; size_t cells[3]; size_t level; size_t level_iteration; double step;
  size_t evaluations; double density_change; double gap; double kkt;
`);

const PAGE = 65536;
const LINE = 64;
const FIELD_DENSITY = 0;

/** How a solve ended: `ThuribleStatus`. */
export const STATUS = { GOES: 0, CONVERGED: 1, MAX_ITERATIONS: 2, STALLED: 3, NOT_FINITE: 4, CANCELLED: 5, NOT_READY: 6 };

/** What the library or the engine refused, in words. */
export class Refused extends Error {
  name = 'Refused';
}

/** Where the fields of a structure lie on wasm32: a double takes eight bytes, everything else four. */
function layout(declarations) {
  const fields = {};
  let bytes = 0;
  for (const declaration of declarations.split(';').map((text) => text.trim()).filter(Boolean)) {
    const [, type, pointer, name, count] = /^(?:const )?(\w+) (\*?)(\w+)(?:\[(\d+)\])?$/.exec(declaration);
    const width = type === 'double' && !pointer ? 8 : 4;
    const at = up(bytes, width);
    fields[name] = { at, width, count: Number(count ?? 1) };
    bytes = at + width * fields[name].count;
  }
  return { fields, bytes: up(bytes, 8) };
}

function up(bytes, multiple) {
  return Math.ceil(bytes / multiple) * multiple;
}

/**
 * One solve in two dimensions with numbers of four bytes, in a module instance of its own. Memory is taken once: the instance, room for
 * one density, and, where `preview` is asked for, room for a saved instance.
 */
export class Solve {
  /**
   * `module` is the compiled module. `scene` holds fields of `ThuribleConfig` by name: `keyframes` as an array of steps, `keyframe_weights` of
   * numbers, `emitters` of objects with the fields of `ThuribleEmitter`, `schedule` with those of `ThuribleFactor`,
   * `templates` with those of `ThuribleTemplate`. Throws `Refused`.
   */
  constructor(module, scene, { preview = false } = {}) {
    this.library = new WebAssembly.Instance(module).exports;
    this.end = this.library.__heap_base.value;
    this.cells = scene.cells.reduce((product, cells) => product * cells, 1);
    const { keyframes = [], keyframe_weights: weights, emitters = [], schedule = [], templates = [], ...fields } = scene;
    const config = this.#take(CONFIG.bytes);
    const steps = this.#take(4 * keyframes.length);
    const factors = weights ? this.#take(8 * weights.length) : 0;
    const makers = this.#list(EMITTER, emitters);
    const knots = this.#list(FACTOR, schedule);
    const forms = this.#list(TEMPLATE, templates);
    this.words = this.#take(1024);
    this.out = this.#take(PROGRESS.bytes);
    this.field = this.#take(4 * this.cells);

    this.#check(this.library.thurible_defaults(config, CONFIG.bytes));
    new Uint32Array(this.#buffer, steps, keyframes.length).set(keyframes);
    if (weights) new Float64Array(this.#buffer, factors, weights.length).set(weights);
    this.#write(CONFIG, config, {
      ...fields,
      keyframes: steps,
      keyframe_count: keyframes.length,
      keyframe_weights: factors,
      emitters: makers,
      emitter_count: emitters.length,
      schedule: knots,
      schedule_count: schedule.length,
      templates: forms,
      template_count: templates.length,
    });
    const wrong = this.library.thurible_explain(config, this.words, 1024);
    if (wrong > 0) throw new Refused(this.#text(this.words));

    this.#check(this.library.thurible_plan(config, this.out, this.out + 4, this.out + 8));
    const [bytes, , saved] = new Uint32Array(this.#buffer, this.out, 3);
    this.bytes = bytes;
    this.savedBytes = saved;
    this.saved = preview ? this.#take(saved) : 0;
    const memory = this.#take(bytes);
    this.#check(this.library.thurible_init(memory, bytes, config, this.out));
    this.handle = new Uint32Array(this.#buffer, this.out, 1)[0];
  }

  /** Sets which cells are solid, before anything else: 1 where one is and 0 where it is not. */
  setSolids(solid) {
    if (solid.length !== this.cells) throw new Refused(`solid cells have ${solid.length} flags instead of ${this.cells}`);
    new Uint8Array(this.#buffer, this.field, this.cells).set(solid);
    this.#enter(this.library.thurible_set_solids(this.handle, this.field, this.cells));
  }

  /** Sets the density of step 0. */
  setSource(density) {
    this.#fill(density);
    this.#enter(this.library.thurible_set_source(this.handle, this.field, density.byteLength));
  }

  /** Sets the shape of an emitter: where it adds smoke. */
  setEmitter(index, shape) {
    this.#fill(shape);
    this.#enter(this.library.thurible_set_emitter(this.handle, index, this.field, shape.byteLength));
  }

  /** Sets where a keyframe matters, from 0 to 1. */
  setRegion(index, region) {
    this.#fill(region);
    this.#enter(this.library.thurible_set_region(this.handle, index, this.field, region.byteLength));
  }

  /** Sets where force may act, from 0 to 1. */
  setMask(mask) {
    this.#fill(mask);
    this.#enter(this.library.thurible_set_mask(this.handle, this.field, mask.byteLength));
  }

  /** Sets the target of a keyframe, after the source and all emitters. */
  setKeyframe(index, density) {
    this.#fill(density);
    this.#enter(this.library.thurible_set_keyframe(this.handle, index, this.field, density.byteLength, 0));
  }

  /** One iteration. */
  step() {
    this.#enter(this.library.thurible_step(this.handle, 0, 0, this.out));
    return this.#progress();
  }

  /** Makes the result feasible, so that densities can be read. */
  finish() {
    this.#enter(this.library.thurible_finish(this.handle, 0, this.out));
    return this.#progress();
  }

  /** The densities of steps 0 to `steps`, one after the other. */
  densities(steps) {
    const all = new Float32Array((steps + 1) * this.cells);
    for (let step = 0; step <= steps; step++) {
      this.#enter(this.library.thurible_copy(this.handle, FIELD_DENSITY, step, 0, this.field, 4 * this.cells));
      all.set(new Float32Array(this.#buffer, this.field, this.cells), step * this.cells);
    }
    return all;
  }

  /** The animation as it would be if the solve ended now; the solve then goes on as if this had not been. */
  preview(steps) {
    this.#enter(this.library.thurible_save(this.handle, this.saved, this.savedBytes));
    const finite = this.finish().status !== STATUS.NOT_FINITE;
    const densities = finite ? this.densities(steps) : null;
    this.#enter(this.library.thurible_restore(this.handle, this.saved, this.savedBytes));
    return densities;
  }

  /** A few words for a status. */
  statusText(status) {
    return this.#text(this.library.thurible_status_text(status));
  }

  get #buffer() {
    return this.library.memory.buffer;
  }

  /** The next `bytes` bytes behind what is taken; the memory grows where it must. */
  #take(bytes) {
    const at = up(this.end, LINE);
    const missing = Math.ceil((at + bytes - this.#buffer.byteLength) / PAGE);
    if (missing > 0) {
      try {
        this.library.memory.grow(missing);
      } catch {
        const wanted = Math.ceil((at + bytes) / 2 ** 20);
        throw new Refused(`this solve takes ${wanted} MiB, which the browser does not give; take fewer cells or steps`);
      }
    }
    this.end = at + bytes;
    return at;
  }

  #fill(density) {
    if (density.length !== this.cells) throw new Refused(`a density has ${density.length} numbers instead of ${this.cells}`);
    new Float32Array(this.#buffer, this.field, this.cells).set(density);
  }

  /** Structures one after the other; what is not said of one is 0. */
  #list(structure, list) {
    const at = this.#take(structure.bytes * list.length);
    new Uint8Array(this.#buffer, at, structure.bytes * list.length).fill(0);
    list.forEach((fields, index) => this.#write(structure, at + structure.bytes * index, fields));
    return at;
  }

  #write(structure, address, fields) {
    const view = new DataView(this.#buffer, address, structure.bytes);
    for (const [name, value] of Object.entries(fields)) {
      const { at, width } = structure.fields[name];
      const put = (number, offset) => (width === 8 ? view.setFloat64(offset, number, true) : view.setUint32(offset, number, true));
      [value].flat().forEach((number, index) => put(number, at + width * index));
    }
  }

  #progress() {
    const view = new DataView(this.#buffer, this.out, PROGRESS.bytes);
    const read = ({ at, width, count }) => {
      const all = Array.from({ length: count }, (_, i) => (width === 8 ? view.getFloat64(at + 8 * i, true) : view.getUint32(at + 4 * i, true)));
      return count === 1 ? all[0] : all;
    };
    return Object.fromEntries(Object.entries(PROGRESS.fields).map(([name, field]) => [name, read(field)]));
  }

  #check(result) {
    if (result !== 0) throw new Refused(this.#text(this.library.thurible_result_text(result)));
  }

  #enter(result) {
    if (result === 0) return;
    this.library.thurible_message(this.handle, this.words, 1024);
    throw new Refused(this.#text(this.words));
  }

  #text(at) {
    const bytes = new Uint8Array(this.#buffer, at);
    return new TextDecoder().decode(bytes.slice(0, bytes.indexOf(0)));
  }
}

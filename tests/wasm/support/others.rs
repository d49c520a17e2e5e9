//! Stable Fluids, an operator and an elastic body, by the module and by the core itself.

use super::header::{code, structure};
use super::scene::{bits, ok};
use super::{Host, LINE, PAGE};
use core::mem::MaybeUninit;
use core::ops::ControlFlow;
use thurible_core::condense::{
    CondenseParams, CondensePlan, Condenser, Material, Mesh, Regular, Step, Topology,
};
use thurible_core::operator::{Operator, OperatorParams, OperatorPlan, Start};
use thurible_core::stable_fluids::Slots;
use thurible_core::{Boundary, D2, Fluids, FluidsParams, FluidsPlan, Plan, Problem, Serial, Silent};
use wasmi::Module;

/// Cells along each axis, and steps.
const SIDE: usize = 10;
const STEPS: usize = 4;
const ITERATIONS: usize = 3;

fn narrow(count: usize) -> u32 {
    u32::try_from(count).unwrap()
}

/// A blob of smoke about cell `x`.
fn blob(x: f64) -> Vec<f64> {
    let density = |cell: usize| {
        let (dx, dy) = ((cell % SIDE) as f64 - x, (cell / SIDE) as f64 - 4.5);
        1.0 / (1.0 + dx * dx + dy * dy)
    };
    (0..SIDE * SIDE).map(density).collect()
}

/// Calls `work` with so many bytes that begin on a multiple of what blocks must.
fn with_block<R>(bytes: usize, work: impl FnOnce(&mut [MaybeUninit<u8>]) -> R) -> R {
    let mut memory = vec![MaybeUninit::<u8>::uninit(); bytes + Plan::ALIGN];
    let start = memory.as_ptr().align_offset(Plan::ALIGN);
    work(&mut memory[start..][..bytes])
}

/// A structure in the module's memory, filled with its defaults and then with some numbers.
fn filled(host: &mut Host, name: &str, defaults: &str, numbers: &[(&str, u32)]) -> u32 {
    let (fields, bytes) = structure(name);
    let at = host.take(bytes).unwrap();
    ok(host.call(defaults, &[at, bytes]));
    for &(name, number) in numbers {
        let field = fields.iter().find(|field| field.name == name).unwrap();
        host.write(at + field.at, &number.to_le_bytes());
    }
    at
}

/// Writes numbers behind what is taken.
fn put(host: &mut Host, bytes: &[u8]) -> u32 {
    let at = host.take(narrow(bytes.len())).unwrap();
    host.write(at, bytes);
    at
}

/// The scene of both, in double precision, with its keyframe at the last step.
fn scene(host: &mut Host) -> u32 {
    let keyframe = put(host, &narrow(STEPS).to_le_bytes());
    let numbers = [
        ("precision", code("THURIBLE_PRECISION_F64")),
        ("dimensions", 2),
        ("steps", narrow(STEPS)),
        ("keyframes", keyframe),
        ("keyframe_count", 1),
    ];
    let at = filled(host, "ThuribleConfig", "thurible_defaults", &numbers);
    let (fields, _) = structure("ThuribleConfig");
    let cells = fields.iter().find(|field| field.name == "cells").unwrap().at;
    for axis in [0, 4] {
        host.write(at + cells + axis, &narrow(SIDE).to_le_bytes());
    }
    at
}

/// Plans by `plan` with `before`, takes the memory, and makes it by `init`: the handle. One byte less is refused.
fn made(host: &mut Host, [plan, init]: [&str; 2], before: &[u32], configs: &[u32], outs: usize) -> u32 {
    let out = host.take(LINE).unwrap();
    let nobody = vec![0; outs];
    ok(host.call(plan, &[configs, before, &[out], &nobody].concat()));
    let bytes = host.word(out);
    let memory = host.take(bytes).unwrap();
    let short = host.call(init, &[&[memory, bytes - 1], configs, &[out]].concat());
    assert_eq!(short, code("THURIBLE_RESULT_TOO_SMALL"));
    ok(host.call(init, &[&[memory, bytes], configs, &[out]].concat()));
    host.word(out)
}

fn host(module: &Module) -> Host {
    Host::new(module, PAGE - 1)
}

/// The densities of a search by Stable Fluids that is saved and restored on the way, as the module finds them.
pub fn search_in_module(module: &Module) -> Vec<u8> {
    let host = &mut host(module);
    let scene = scene(host);
    let numbers = [("iterations", narrow(ITERATIONS)), ("slots", 2)];
    let config = filled(host, "ThuribleFluidsConfig", "thurible_fluids_defaults", &numbers);
    let calls = ["thurible_fluids_plan", "thurible_fluids_init"];
    let handle = made(host, calls, &[], &[scene, config], 3);
    let field = narrow(8 * SIDE * SIDE);
    let (from, to) = (put(host, &bits(&blob(3.5))), put(host, &bits(&blob(5.5))));
    ok(host.call("thurible_fluids_set_source", &[handle, from, field]));
    ok(host.call("thurible_fluids_set_keyframe", &[handle, 0, to, field, 0]));
    ok(host.call("thurible_fluids_step", &[handle, 0, 0, 0]));
    let out = host.take(LINE).unwrap();
    ok(host.call("thurible_fluids_saved_bytes", &[scene, config, out]));
    let bytes = host.word(out);
    let saved = host.take(bytes).unwrap();
    ok(host.call("thurible_fluids_save", &[handle, saved, bytes]));
    ok(host.call("thurible_fluids_step", &[handle, 0, 0, 0]));
    ok(host.call("thurible_fluids_restore", &[handle, saved, bytes]));
    ok(host.call("thurible_fluids_solve", &[handle, 0, 0, 0]));
    let all = narrow(STEPS + 1) * field;
    let densities = host.take(all).unwrap();
    let states = steps(host, densities, all);
    ok(host.call("thurible_fluids_replay", &[handle, 0, 0, states, 0, out]));
    assert_eq!(host.word(out), code("THURIBLE_STATUS_CONVERGED"));
    ok(host.call("thurible_fluids_close", &[handle]));
    host.read(densities, all as usize).to_vec()
}

/// A `ThuribleSteps` of a density alone.
fn steps(host: &mut Host, density: u32, bytes: u32) -> u32 {
    let (fields, whole) = structure("ThuribleSteps");
    let at = put(host, &vec![0; whole as usize]);
    for (name, number) in [("density", density), ("density_bytes", bytes)] {
        let field = fields.iter().find(|field| field.name == name).unwrap();
        host.write(at + field.at, &number.to_le_bytes());
    }
    at
}

fn problem() -> Problem<'static> {
    Problem::new(&[SIDE; 2], &[Boundary::Wall; 2], &[STEPS])
}

/// The same by the core.
pub fn native_search() -> Vec<u8> {
    let params = FluidsParams {
        iterations: ITERATIONS,
        slots: Slots::States(2),
        ..FluidsParams::default()
    };
    let bytes = FluidsPlan::new::<f64, D2>(&problem(), &params).unwrap().bytes();
    with_block(bytes, |block| {
        let mut fluids = Fluids::<f64, D2>::new(&problem(), &params, block).unwrap();
        fluids.set_source(&blob(3.5)).unwrap();
        fluids.set_keyframe(0, &blob(5.5)).unwrap();
        fluids.solve(&Serial, &mut Silent, &mut |_| ());
        let mut all = Vec::new();
        let replayed = fluids.replay(&Serial, &mut Silent, &mut |mut moment| {
            all.extend(bits(moment.density()));
            ControlFlow::Continue(())
        });
        replayed.unwrap();
        all
    })
}

/// The last density of an operator on the staggered grid, and what the sum of its squares is for the density at the start.
pub fn operator_in_module(module: &Module) -> Vec<u8> {
    let host = &mut host(module);
    let scene = scene(host);
    let config = filled(host, "ThuribleOperatorConfig", "thurible_operator_defaults", &[]);
    let calls = ["thurible_operator_plan", "thurible_operator_init"];
    let handle = made(host, calls, &[], &[scene, config], 3);
    let field = narrow(8 * SIDE * SIDE);
    let all = narrow(STEPS + 1) * field;
    let (from, densities) = (put(host, &bits(&blob(3.5))), host.take(all).unwrap());
    let (start, states) = (steps(host, from, field), steps(host, densities, all));
    let (_, ran) = structure("ThuribleRan");
    let ran = host.take(ran).unwrap();
    ok(host.call(
        "thurible_operator_simulate",
        &[handle, 0, 0, start, 0, states, ran],
    ));
    assert_eq!(host.word(ran), code("THURIBLE_STATUS_CONVERGED"));
    // The covectors are the densities themselves.
    ok(host.call("thurible_operator_vjp", &[handle, 0, 0, 0, states, 0, ran]));
    assert_eq!(host.word(ran), code("THURIBLE_STATUS_CONVERGED"));
    let by_start = host.take(field).unwrap();
    ok(host.call("thurible_operator_gradient", &[handle, 0, by_start, field]));
    let mut found = host.read(densities, all as usize).to_vec();
    found.extend_from_slice(host.read(by_start, field as usize));
    found
}

/// The same by the core.
pub fn native_operator() -> Vec<u8> {
    let problem = Problem {
        keyframes: &[],
        ..problem()
    };
    let params = OperatorParams::default();
    let bytes = OperatorPlan::new::<f64, D2>(&problem, &params).unwrap().bytes();
    with_block(bytes, |block| {
        let mut operator = Operator::<f64, D2>::new(&problem, &params, block).unwrap();
        let (source, mut densities) = (blob(3.5), Vec::new());
        let start = Start {
            density: &source,
            velocity: [&[]; 3],
        };
        let done = operator.simulate(&Serial, &mut Silent, &start, &mut |_, _| (), &mut |_, view| {
            let mut density = vec![0.0; SIDE * SIDE];
            view.read_density(&mut density);
            densities.push(density);
        });
        done.unwrap();
        let mut cotangent = |step: usize, given: &mut thurible_core::operator::Given<'_, f64>| {
            given.density(&densities[step]);
        };
        let done = operator.vjp(
            &Serial,
            &mut Silent,
            &mut |_, _| (),
            &mut cotangent,
            &mut |_, _| (),
        );
        done.unwrap();
        let mut by_start = vec![0.0; SIDE * SIDE];
        operator.gradient().read_density(&mut by_start);
        let all: Vec<f64> = densities.into_iter().flatten().chain(by_start).collect();
        bits(&all)
    })
}

/// A square whose right end is pulled.
struct Body {
    rest: Vec<f64>,
    elements: Vec<u32>,
    held: Vec<bool>,
    pull: Vec<f64>,
}

fn body() -> Body {
    let mesh = Regular::new(&[4, 4], &[1.0, 1.0]).unwrap();
    let places: Vec<[f64; 3]> = (0..mesh.vertices()).map(|vertex| mesh.place(vertex)).collect();
    let ends = |place: &[f64; 3]| place[0] == 0.0 || place[0] == 1.0;
    let moved = |place: &[f64; 3]| [if place[0] == 1.0 { 0.1 } else { 0.0 }, 0.0];
    Body {
        rest: places.iter().flat_map(|place| [place[0], place[1]]).collect(),
        elements: (0..mesh.elements())
            .flat_map(|element| mesh.corners(element)[..3].to_vec())
            .collect(),
        held: places.iter().map(ends).collect(),
        pull: places.iter().flat_map(moved).collect(),
    }
}

/// Where the vertices of a body are after a step, as the module finds it.
pub fn body_in_module(module: &Module) -> Vec<u8> {
    let host = &mut host(module);
    let Body {
        rest,
        elements,
        held,
        pull,
    } = body();
    let corners: Vec<u8> = elements.iter().flat_map(|corner| corner.to_le_bytes()).collect();
    let flags: Vec<u8> = held.iter().map(|&held| u8::from(held)).collect();
    let numbers = [
        ("vertex_count", narrow(held.len())),
        ("rest", put(host, &bits(&rest))),
        ("held", put(host, &flags)),
        ("element_count", narrow(elements.len() / 3)),
        ("elements", put(host, &corners)),
    ];
    let config = filled(
        host,
        "ThuribleCondenseConfig",
        "thurible_condense_defaults",
        &numbers,
    );
    let out = host.take(LINE).unwrap();
    ok(host.call("thurible_condense_scratch", &[config, out]));
    let scratch_bytes = host.word(out);
    let scratch = host.take(scratch_bytes).unwrap();
    let calls = ["thurible_condense_plan", "thurible_condense_init"];
    let handle = made(host, calls, &[scratch, scratch_bytes], &[config], 1);
    let size = narrow(8 * rest.len());
    let pull = put(host, &bits(&pull));
    let arguments = [handle, 0, 0, pull, size, 0, 0, 0, 0];
    ok(host.call("thurible_condense_step", &arguments));
    let position = host.take(size).unwrap();
    let part = code("THURIBLE_CONDENSE_PART_POSITION");
    ok(host.call("thurible_condense_read", &[handle, part, position, size]));
    ok(host.call("thurible_condense_close", &[handle]));
    host.read(position, size as usize).to_vec()
}

/// The same by the core.
pub fn native_body() -> Vec<u8> {
    let Body {
        rest,
        elements,
        held,
        pull,
    } = body();
    let mesh = Mesh {
        dims: 2,
        rest: &rest,
        elements: &elements,
        springs: &[],
        held: &held,
        regular: [0; 3],
        material: Material::default(),
    };
    let params = CondenseParams::default();
    let mut words = vec![0; Topology::words(&mesh)];
    let topology = Topology::new(&mesh, None, &mut words).unwrap();
    let bytes = CondensePlan::new::<f64>(&mesh, &topology, &params)
        .unwrap()
        .bytes();
    with_block(bytes, |block| {
        let mut run = Condenser::<f64, 2>::new(mesh, topology, params, block).unwrap();
        let step = Step {
            shift: &pull,
            ..Step::default()
        };
        run.step(&Serial, &step, &mut Silent, &mut |_| ()).unwrap();
        let places: Vec<f64> = (0..held.len())
            .flat_map(|vertex| run.position(vertex)[..2].to_vec())
            .collect();
        bits(&places)
    })
}

//! Memory: the examples of the design, plan = used, one byte short refused.

use super::case::{Scene, built};
use crate::fields::{Memory, boundaries};
use thurible_core::stable_fluids::{Adjoint, Control, Controls, Pressure, Slots};
use thurible_core::{
    D2, D3, Fluids, FluidsParams, FluidsPlan, Problem, Real, SolverError, Space, Template, TemplateKind,
};

/// Bytes without the small lines: steps of states, of keyframes, weights and templates, taps, sums.
fn without_small<S: Space>(problem: &Problem<'_>, controls: Controls, slots: Slots) -> usize {
    let params = FluidsParams {
        controls,
        slots,
        ..FluidsParams::default()
    };
    let plan = FluidsPlan::new::<f32, S>(problem, &params).unwrap();
    let small = [
        "steps of states",
        "steps of keyframes",
        "weights, templates and their factors",
        "Gaussian taps and rows",
        "sums of rows",
    ];
    let left_out = plan.entries().iter().filter(|entry| small.contains(&entry.name));
    plan.bytes() - left_out.map(|entry| entry.bytes).sum::<usize>()
}

#[test]
fn the_examples_of_the_design() {
    let walls = boundaries("www");
    let flat = Problem::new(&[128, 128], &walls[..2], &[40]);
    let deep = Problem::new(&[64, 64, 64], &walls, &[60]);
    let only = |control| Controls::none().with(control);
    let kept = |steps: usize| {
        [
            Slots::States(steps),
            Slots::States(10),
            Slots::States(5),
            Slots::States(3),
            Slots::Tape,
        ]
    };
    // 16 winds of 2 numbers and 16 vortices of 1, in 4 intervals: 192.
    let template = |kind| Template {
        interval: 10,
        ..Template::new(kind, [0.5; 3], 0.1, 40)
    };
    let templates: Vec<Template> = [TemplateKind::Wind, TemplateKind::Vortex]
        .into_iter()
        .flat_map(|kind| vec![template(kind); 16])
        .collect();
    let by_templates = Problem {
        templates: &templates,
        ..flat
    };
    let bytes = |problem: &Problem<'_>, control| {
        kept(40).map(|slots| without_small::<D2>(problem, only(control), slots))
    };
    assert_eq!(
        bytes(&flat, Control::InitialVelocity),
        [10_908_544, 5_010_304, 4_027_264, 3_634_048, 16_151_424]
    );
    assert_eq!(
        bytes(&by_templates, Control::Templates),
        [9_214_592, 3_316_352, 2_333_312, 1_940_096, 14_457_472]
    );
    assert_eq!(
        bytes(&flat, Control::Forces),
        [77_362_048, 71_463_808, 70_480_768, 70_087_552, 82_604_928]
    );
    assert_eq!(
        kept(60).map(|slots| without_small::<D3>(&deep, only(Control::InitialVelocity), slots)),
        [320_593_024, 110_877_824, 89_906_304, 81_517_696, 509_336_704]
    );
}

fn plan_is_used<T: Real, S: Space>(scene: &Scene) {
    let problem = scene.problem();
    let bytes = built::<T, S>(&problem, &scene.params).unwrap();
    // A carve that leaves a byte fails in debug builds.
    let mut memory = Memory::new(bytes);
    assert!(Fluids::<T, S>::new(&problem, &scene.params, memory.block()).is_ok());
    let short = Fluids::<T, S>::new(&problem, &scene.params, &mut memory.block()[..bytes - 1]);
    let expected = SolverError::TooSmall {
        needed: bytes,
        given: bytes - 1,
    };
    assert_eq!(short.err(), Some(expected));
    let misaligned = Fluids::<T, S>::new(&problem, &scene.params, &mut memory.block()[1..]);
    assert_eq!(misaligned.err(), Some(SolverError::Misaligned));
}

#[test]
fn what_is_planned_is_used_and_one_byte_less_refused() {
    let all = [Control::InitialVelocity, Control::Forces, Control::Templates];
    for slots in [Slots::None, Slots::Tape, Slots::States(3)] {
        for (pressure, adjoint) in [
            (Pressure::GaussSeidel, Adjoint::Exact),
            (Pressure::Conjugate, Adjoint::Exact),
            (Pressure::Conjugate, Adjoint::SecondSolve),
        ] {
            let mut flat = Scene::new(&[9, 7], "wp", &all).kept(slots);
            let mut deep = Scene::new(&[7, 5, 6], "wpw", &all).kept(slots);
            for scene in [&mut flat, &mut deep] {
                (scene.params.pressure, scene.params.adjoint, scene.params.threads) = (pressure, adjoint, 3);
            }
            plan_is_used::<f32, D2>(&flat);
            plan_is_used::<f64, D2>(&flat);
            plan_is_used::<f32, D3>(&deep);
        }
    }
}

#[test]
fn the_most_that_a_ceiling_allows_is_kept() {
    let scene = Scene::new(&[16, 12], "ww", &[Control::InitialVelocity]);
    let problem = scene.problem();
    let fitting = |bytes| {
        FluidsPlan::fitting::<f32, D2>(&problem, &scene.params, bytes)
            .unwrap()
            .slots
    };
    let with = |slots| {
        let params = FluidsParams {
            slots,
            ..scene.params
        };
        built::<f32, D2>(&problem, &params).unwrap()
    };
    assert_eq!(fitting(usize::MAX), Slots::Tape);
    assert_eq!(fitting(with(Slots::Tape) - 1), Slots::States(5));
    assert_eq!(fitting(with(Slots::States(3))), Slots::States(3));
    assert_eq!(fitting(with(Slots::States(3)) - 1), Slots::States(2));
    assert_eq!(fitting(0), Slots::States(1));
}

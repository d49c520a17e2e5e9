//! Everything that is refused, by name.

use super::case::Scene;
use crate::fields::boundaries;
use thurible_core::stable_fluids::{Adjoint, Control, Controls, Slots};
use thurible_core::{
    D2, Emitter, FluidsParams, FluidsPlan, InputError, Problem, Status, Supply, Template, TemplateKind,
};
use thurible_core::{Serial, Silent};

#[track_caller]
fn refused(scene: &Scene, problem: &Problem<'_>, params: FluidsParams, why: &str) {
    let error = FluidsPlan::new::<f32, D2>(problem, &params)
        .unwrap_err()
        .to_string();
    assert!(error.contains(why), "{error}");
    assert!(FluidsPlan::new::<f32, D2>(&scene.problem(), &scene.params).is_ok());
}

#[test]
fn what_the_method_does_not_know() {
    let scene = Scene::new(&[8, 8], "ww", &[Control::InitialVelocity]);
    let (problem, params) = (scene.problem(), scene.params);
    let open = boundaries("ow");
    let emitters = [Emitter {
        from: 0,
        to: 2,
        supply: Supply::Rate(0.1),
        velocity: None,
    }];
    refused(
        &scene,
        &Problem {
            solids: true,
            ..problem
        },
        params,
        "solid cells",
    );
    refused(
        &scene,
        &Problem {
            boundary: &open,
            match_mass: false,
            ..problem
        },
        params,
        "open sides",
    );
    refused(
        &scene,
        &Problem {
            emitters: &emitters,
            ..problem
        },
        params,
        "emitters",
    );
    refused(
        &scene,
        &Problem {
            mask: true,
            ..problem
        },
        params,
        "mask",
    );
    refused(
        &scene,
        &Problem {
            schedule: &[(0, 1.0)],
            ..problem
        },
        params,
        "schedule",
    );
    refused(
        &scene,
        &Problem {
            release: Some(3),
            ..problem
        },
        params,
        "release",
    );
    refused(
        &scene,
        &Problem {
            keyframe_regions: true,
            ..problem
        },
        params,
        "regions",
    );
    refused(
        &scene,
        &Problem {
            smoothness: Some(1.0),
            ..problem
        },
        params,
        "smoothness",
    );
}

#[test]
fn keyframes_and_templates() {
    let scene = Scene::new(&[8, 8], "ww", &[Control::Templates]);
    let (problem, params) = (scene.problem(), scene.params);
    refused(
        &scene,
        &Problem {
            keyframes: &[0, 3],
            ..problem
        },
        params,
        "from 1 to steps = 5",
    );
    refused(
        &scene,
        &Problem {
            keyframes: &[3, 6],
            ..problem
        },
        params,
        "from 1 to steps = 5",
    );
    refused(
        &scene,
        &Problem {
            keyframes: &[3, 3],
            ..problem
        },
        params,
        "not after",
    );
    refused(
        &scene,
        &Problem {
            keyframes: &[],
            ..problem
        },
        params,
        "no keyframe",
    );
    refused(
        &scene,
        &Problem {
            templates: &[],
            ..problem
        },
        params,
        "no template",
    );
    let wind = scene.templates[0];
    let template = |change: &dyn Fn(&mut Template), why: &str| {
        let mut wrong = [wind];
        change(&mut wrong[0]);
        refused(
            &scene,
            &Problem {
                templates: &wrong,
                ..problem
            },
            params,
            why,
        );
    };
    template(&|wind| wind.radius = 0.0, "template.radius");
    template(&|wind| wind.to = wind.from, "must act");
    template(&|wind| wind.interval = 0, "interval");
    template(&|wind| wind.center[0] = 2.5, "outside the box");
    template(&|wind| wind.kind = TemplateKind::Noise, "takes wind and vortex");
    template(&|wind| wind.kind = TemplateKind::Attract, "takes wind and vortex");
    template(&|wind| wind.amplitude[0] = f64::NAN, "template.amplitude");
}

#[test]
fn choices() {
    let scene = Scene::new(&[8, 8], "ww", &[Control::InitialVelocity]);
    let (problem, params) = (scene.problem(), scene.params);
    let second = FluidsParams {
        adjoint: Adjoint::SecondSolve,
        ..params
    };
    refused(&scene, &problem, second, "second_solve");
    let slots = |slots| FluidsParams {
        slots: Slots::States(slots),
        ..params
    };
    refused(&scene, &problem, slots(6), "slots is 6");
    refused(
        &scene,
        &problem,
        FluidsParams { sweeps: 0, ..params },
        "stable_fluids.sweeps",
    );
    refused(
        &scene,
        &problem,
        FluidsParams { history: 9, ..params },
        "stable_fluids.history",
    );
    refused(
        &scene,
        &problem,
        FluidsParams {
            diffusion: -1.0,
            ..params
        },
        "stable_fluids.diffusion",
    );
    refused(
        &scene,
        &problem,
        FluidsParams {
            cg_tolerance: 1.0,
            ..params
        },
        "stable_fluids.cg_tolerance",
    );
    refused(&scene, &problem, FluidsParams { threads: 0, ..params }, "threads");
    refused(
        &scene,
        &problem,
        FluidsParams {
            iterations: 0,
            ..params
        },
        "iterations",
    );
}

#[test]
fn inputs() {
    let scene = Scene::new(&[8, 8], "ww", &[Control::InitialVelocity]);
    scene.with::<f64, D2, _>(|fluids| {
        let count = 2;
        assert_eq!(
            fluids.set_keyframe(2, &[1.0; 64]),
            Err(InputError::Index { given: 2, count })
        );
        assert_eq!(fluids.set_source(&[0.0; 64]), Err(InputError::Empty));
        assert_eq!(
            fluids.set_source(&[-1.0; 64]),
            Err(InputError::Negative { index: 0 })
        );
        assert_eq!(
            fluids.set_source(&[1.0; 63]),
            Err(InputError::Length {
                expected: 64,
                given: 63
            })
        );
        assert_eq!(
            fluids.set_initial_velocity(2, &[0.0; 64]),
            Err(InputError::Index { given: 2, count })
        );
        assert_eq!(
            fluids.set_initial_velocity(0, &[f64::NAN; 64]),
            Err(InputError::NotFinite { index: 0 })
        );
    });
}

#[test]
fn nothing_is_searched_for_before_all_is_given() {
    let mut scene = Scene::new(&[8, 8], "ww", &[Control::InitialVelocity]);
    scene.keyframes.truncate(1);
    let status = scene.with::<f64, D2, _>(|fluids| fluids.solve(&Serial, &mut Silent, &mut |_| {}));
    assert_eq!(status, Status::NotReady);
    // The last one alone is not all of them.
    let last = scene.keyframes[0].clone();
    scene.keyframes.clear();
    let status = scene.with::<f64, D2, _>(|fluids| {
        fluids.set_keyframe(1, &last).unwrap();
        fluids.solve(&Serial, &mut Silent, &mut |_| {})
    });
    assert_eq!(status, Status::NotReady);
    let mut scene = Scene::new(&[8, 8], "ww", &[]);
    scene.params.controls = Controls::none();
    let status = scene.with::<f64, D2, _>(|fluids| fluids.solve(&Serial, &mut Silent, &mut |_| {}));
    assert_eq!(status, Status::NotReady);
}

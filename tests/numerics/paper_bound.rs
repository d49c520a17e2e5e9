//! The paper's bound on memory holds for every plan of ADMM, and for the direct method under that ceiling.

use crate::fields::cases::{Scene, admm};
use thurible_core::{D2, D3, Method, Params, Real, Space};

/// Plans with N >= 20 and at most 2 threads that exceed the paper's bound; the direct method under that ceiling, without keyframes.
fn above_the_bound<T: Real, S: Space>(list: &[&[usize]]) -> Vec<String> {
    let mut above = Vec::new();
    for (cells, steps, threads) in list.iter().flat_map(|&cells| {
        [20, 21, 61]
            .into_iter()
            .flat_map(move |n| [(cells, n, 1), (cells, n, 2)])
    }) {
        for ends in ["www", "ppp", "wpw"] {
            let mut scene = Scene::small(cells, &ends[..S::DIM], steps);
            scene.params.threads = threads;
            for method in [Method::Admm, Method::Direct] {
                scene.params.method = method;
                scene.params.ceiling =
                    (method == Method::Direct).then_some(scene.plan::<T, S>().paper_bound());
                let plan = scene.plan::<T, S>();
                let ratio = plan.method_bytes() as f64 / plan.paper_bound() as f64;
                if ratio > 1.0 {
                    above.push(format!(
                        "{method:?} on {cells:?} {ends} x {steps}, {}, {threads} threads: {ratio:.4}",
                        T::NAME
                    ));
                }
            }
        }
    }
    above
}

#[test]
fn the_method_fits_the_papers_bound() {
    let plane: [&[usize]; 12] = [
        &[32, 32],
        &[33, 33],
        &[35, 37],
        &[33, 47],
        &[50, 50],
        &[64, 64],
        &[65, 65],
        &[96, 60],
        &[128, 128],
        &[32, 200],
        &[200, 33],
        &[255, 131],
    ];
    let space: [&[usize]; 8] = [
        &[32, 32, 32],
        &[33, 33, 33],
        &[35, 32, 37],
        &[64, 64, 32],
        &[32, 48, 40],
        &[64, 64, 64],
        &[65, 65, 65],
        &[32, 33, 100],
    ];
    let mut above = [
        above_the_bound::<f32, D2>(&plane),
        above_the_bound::<f64, D2>(&plane),
    ]
    .concat();
    above.extend(
        [
            above_the_bound::<f32, D3>(&space),
            above_the_bound::<f64, D3>(&space),
        ]
        .concat(),
    );
    assert!(
        above.is_empty(),
        "{} plans exceed the bound:\n{}",
        above.len(),
        above.join("\n")
    );
}

#[test]
fn the_papers_size_in_the_papers_bytes() {
    let scene = |threads| Scene {
        params: Params { threads, ..admm() },
        ..Scene::small(&[64, 64, 64], "www", 60)
    };
    for threads in [1, 2] {
        let plan = scene(threads).plan::<f32, D3>();
        assert_eq!(plan.paper_bound(), 1_150_437_668);
        assert!(
            plan.method_bytes() <= plan.paper_bound(),
            "{} bytes",
            plan.method_bytes()
        );
        assert!(
            plan.bytes() - plan.method_bytes() <= 64 * 64 * 64 * 4 + 64,
            "one keyframe and its step"
        );
    }
}

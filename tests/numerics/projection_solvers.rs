//! The two solvers of the projection: how fast V-cycles converge, that both agree, that a stop is heard.

use crate::fields::random::Random;
use crate::fields::{Components, add_scaled_all, grid, largest_of};
use crate::projection::{By, GRIDS, divergence, project, project_by};

#[test]
fn a_cycle_leaves_at_most_a_quarter() {
    let sizes: [(&[usize], &str); 14] = [
        (&[512, 4], "ww"),
        (&[4, 64, 5], "www"),
        (&[96, 60], "ww"),
        (&[50, 50], "ww"),
        (&[33, 47], "ww"),
        (&[64, 8], "ww"),
        (&[64, 64], "pp"),
        (&[33, 47], "pw"),
        (&[130, 5], "wp"),
        (&[17, 20, 15], "www"),
        (&[33, 9, 12], "www"),
        (&[15, 21, 11], "pwp"),
        (&[16, 16, 16], "ppp"),
        (&[5, 5, 5], "ppp"),
    ];
    for (cells, ends) in sizes {
        let (mut random, grid) = (Random::new(56), grid(cells, ends));
        let v: Components<f64> = random.faces(&grid, 1);
        let before = divergence(&grid, 1, &v);
        let [early, late] = [1e-4, 1e-11].map(|tolerance| {
            let mut v = v.clone();
            let done = project_by(By::Multigrid, &grid, 1, &mut v, None, tolerance, usize::MAX);
            (divergence(&grid, 1, &v) / before, done.cycles as f64)
        });
        let factor = (late.0 / early.0).powf(1.0 / (late.1 - early.1));
        println!(
            "projection on {cells:?} {ends}: {factor:.3} a cycle, {} cycles to 1e-11",
            late.1
        );
        assert!(factor <= 0.25, "{cells:?} {ends}: a V-cycle leaves {factor:.3}");
    }
}

#[test]
fn a_stop_is_heard_and_nan_is_not_hidden() {
    let grid = grid(&[20, 20], "ww");
    let mut v: Components<f64> = Random::new(57).faces(&grid, 4);
    let done = project_by(By::Multigrid, &grid, 4, &mut v, None, 1e-10, 2);
    assert_eq!((done.divergence, done.cycles), (None, 2));
    for (by, poison) in [By::Eigenvectors, By::Multigrid]
        .into_iter()
        .flat_map(|by| [(by, f64::NAN), (by, f64::INFINITY)])
    {
        let mut v: Components<f64> = Random::new(58).faces(&grid, 4);
        v[1][777] = poison;
        assert!(
            project_by(by, &grid, 4, &mut v, None, 1e-5, usize::MAX)
                .divergence
                .unwrap()
                .is_nan()
        );
    }
    let mut v: Components<f64> = Random::new(59).faces(&grid, 4);
    assert_eq!(project(&grid, 4, &mut v, None, 1e-14, 1).divergence, None);
}

/// Where both can be had they agree, and eigenvectors need no more than two passes in double precision.
#[test]
fn eigenvectors_and_multigrid_agree() {
    let mut random = Random::new(60);
    for (cells, ends) in GRIDS
        .into_iter()
        .chain([(&[200, 7][..], "ww"), (&[100, 33], "pw")])
    {
        let grid = grid(cells, ends);
        let v: Components<f64> = random.faces(&grid, 3);
        let [one, other] = [By::Eigenvectors, By::Multigrid].map(|by| {
            let mut v = v.clone();
            let done = project_by(by, &grid, 3, &mut v, None, 1e-12, usize::MAX);
            assert!(
                by == By::Multigrid || done.cycles <= 2,
                "{} passes on {cells:?} {ends}",
                done.cycles
            );
            v
        });
        assert!(
            largest_of(&add_scaled_all(&one, -1.0, &other)) < 1e-9,
            "{cells:?} {ends}"
        );
    }
}

/// Axes that are too long for eigenvectors.
#[test]
fn long_boxes_are_projected_too() {
    for (cells, ends) in [(&[300, 5][..], "ww"), (&[5, 300], "wp"), (&[4, 5, 260], "wwp")] {
        let grid = grid(cells, ends);
        let mut v: Components<f32> = Random::new(61).faces(&grid, 5);
        let before = divergence(&grid, 5, &v);
        project(&grid, 5, &mut v, None, 1e-4, usize::MAX);
        assert!(divergence(&grid, 5, &v) <= 1.1e-4 * before, "{cells:?} {ends}");
    }
}

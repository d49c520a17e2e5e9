//! STFAS: how fast V-cycles converge.

use crate::fields::naive::Solid;
use crate::fields::spacetime::{Case, setup};
use crate::fields::{add_scaled_all, flow, grid, largest_of, places};
use thurible_core::grid::Grid;
use thurible_core::nso::Setup;
use thurible_core::nso::colours::Colours;
use thurible_core::{D2, D3, NsoParams, Real, Serial, Space};

/// A synthetic problem, whose target is a swirling flow.
#[derive(Clone, Copy)]
pub struct Scene<'a> {
    pub cells: &'a [usize],
    pub ends: &'a str,
    pub slots: usize,
    pub courant: f64,
    pub kappa: f64,
    pub colours: Colours,
    /// Kinematic viscosity over squared cell size, nu / h^2.
    pub viscosity: f64,
}

impl<'a> Scene<'a> {
    /// Courant number 1, kappa 1, red-black, no viscosity.
    pub fn new(cells: &'a [usize], ends: &'a str, slots: usize) -> Self {
        Scene {
            cells,
            ends,
            slots,
            courant: 1.0,
            kappa: 1.0,
            colours: Colours::RedBlack,
            viscosity: 0.0,
        }
    }

    pub fn case<T: Real>(&self) -> Case<T> {
        let grid = grid(self.cells, self.ends);
        Case::towards(&grid, self.slots, flow::swirl(&grid, self.slots, self.courant))
    }

    pub fn setup(&self) -> Setup {
        let h = grid(self.cells, self.ends).h[0];
        let params = NsoParams {
            tolerance: 0.0,
            colours: self.colours,
            ..NsoParams::default()
        };
        Setup {
            params,
            viscosity: self.viscosity * h * h,
            ..setup(self.kappa, self.slots)
        }
    }

    /// What a V-cycle leaves of the residual: the mean of the last three of six.
    pub fn factor<S: Space>(&self) -> f64 {
        let list = self.case::<f64>().residuals::<S>(&Serial, &self.setup(), 6);
        let factor = (list[6] / list[3]).cbrt();
        let Scene {
            cells,
            ends,
            slots,
            courant,
            kappa,
            colours,
            viscosity,
        } = self;
        println!(
            "STFAS on {cells:?} {ends} x {slots}, Courant {courant}, kappa {kappa}, viscosity {viscosity}, {colours:?}: {factor:.3} a cycle"
        );
        factor
    }

    #[track_caller]
    pub fn converges_by<S: Space>(&self, most: f64) {
        let factor = self.factor::<S>();
        assert!(factor <= most, "a V-cycle leaves {factor:.3}, more than {most}");
    }
}

#[test]
fn two_dimensions() {
    for (cells, slots) in [([32, 32], 19), ([32, 32], 39), ([64, 64], 19)] {
        Scene::new(&cells, "ww", slots).converges_by::<D2>(0.15);
    }
    for ends in ["wp", "pp"] {
        Scene::new(&[24, 40], ends, 15).converges_by::<D2>(0.15);
    }
}

#[test]
fn sizes_that_do_not_halve() {
    for cells in [[96, 60], [50, 50], [33, 47], [64, 8], [4, 128]] {
        Scene::new(&cells, "ww", 11).converges_by::<D2>(0.15);
    }
    for (cells, ends) in [
        ([33, 47], "wp"),
        ([33, 47], "pp"),
        ([5, 5], "pp"),
        ([47, 10], "pw"),
    ] {
        Scene::new(&cells, ends, 11).converges_by::<D2>(0.15);
    }
}

#[test]
fn viscous_flows() {
    for viscosity in [0.01, 1.0, 100.0] {
        Scene {
            viscosity,
            ..Scene::new(&[32, 32], "ww", 15)
        }
        .converges_by::<D2>(0.25);
        Scene {
            viscosity,
            ..Scene::new(&[24, 40], "wp", 15)
        }
        .converges_by::<D2>(0.25);
        Scene {
            viscosity,
            ..Scene::new(&[16, 16, 16], "www", 9)
        }
        .converges_by::<D3>(0.35);
        Scene {
            viscosity,
            colours: Colours::PowerOfTwo,
            ..Scene::new(&[32, 32], "ww", 15)
        }
        .converges_by::<D2>(0.25);
    }
}

#[test]
fn three_dimensions() {
    Scene::new(&[16, 16, 16], "www", 15).converges_by::<D3>(0.15);
    Scene::new(&[24, 16, 8], "wpw", 9).converges_by::<D3>(0.15);
    Scene::new(&[17, 12, 15], "www", 9).converges_by::<D3>(0.15);
    Scene::new(&[4, 4, 32], "wpw", 5).converges_by::<D3>(0.15);
    Scene::new(&[9, 7, 10], "ppp", 9).converges_by::<D3>(0.15);
}

#[test]
fn fast_flows() {
    let fast = Scene {
        courant: 2.2,
        ..Scene::new(&[64, 64], "ww", 19)
    };
    fast.converges_by::<D2>(0.45);
    Scene {
        cells: &[32, 32],
        ..fast
    }
    .converges_by::<D2>(0.45);
    Scene {
        courant: 3.0,
        ..Scene::new(&[16, 16, 16], "www", 11)
    }
    .converges_by::<D3>(0.45);
}

#[test]
fn the_papers_colours() {
    for courant in [1.0, 2.2] {
        Scene {
            courant,
            colours: Colours::PowerOfTwo,
            ..Scene::new(&[32, 32], "ww", 19)
        }
        .converges_by::<D2>(0.45);
    }
    Scene {
        colours: Colours::PowerOfTwo,
        ..Scene::new(&[12, 12, 12], "wwp", 9)
    }
    .converges_by::<D3>(0.3);
    Scene {
        colours: Colours::PowerOfTwo,
        ..Scene::new(&[15, 9], "pp", 9)
    }
    .converges_by::<D2>(0.4);
}

/// At rest the factor depends neither on the number of steps nor on the weights.
#[test]
fn at_rest_the_factor_is_the_same_for_all_weights_and_steps() {
    for (cells, slots) in [([32, 32], 3), ([32, 32], 19), ([32, 32], 79), ([64, 64], 19)] {
        for kappa in [1e-3, 1.0, 100.0] {
            Scene {
                kappa,
                courant: 1e-4,
                ..Scene::new(&cells, "ww", slots)
            }
            .converges_by::<D2>(0.1);
        }
    }
}

/// A disc or ball beside the middle.
fn disc(grid: &Grid, at: [usize; 3]) -> bool {
    let along = |axis: usize| at[axis] as f64 + 0.5 - 0.47 * grid.n[axis] as f64;
    let radius = 0.2 * grid.n[0] as f64;
    (0..grid.dims).map(|axis| along(axis).powi(2)).sum::<f64>() < radius * radius
}

/// A plate of one cell that the next grid has as closed faces.
fn plate(grid: &Grid, at: [usize; 3]) -> bool {
    at[0] == grid.n[0] / 2 - 1 && at[1] >= grid.n[1] / 4 && at[1] < 3 * grid.n[1] / 4
}

/// A plate of one cell at a wall, of which the grid after the next has nothing.
fn lost_plate(grid: &Grid, at: [usize; 3]) -> bool {
    at[0] == grid.n[0] / 2 - 2 && at[1] < 3 * grid.n[1] / 4
}

/// The case of a scene among solids: its target is projected, and it is as fast as before.
fn among<T: Real>(scene: &Scene<'_>, solid: Solid) -> Case<T> {
    let grid = grid(scene.cells, scene.ends);
    let cells: Vec<bool> = places(&grid).map(|at| solid(&grid, at)).collect();
    let swirl = crate::effects::among(&grid, &cells, flow::swirl(&grid, scene.slots, scene.courant));
    let target = flow::scaled(&grid, scene.slots, &swirl, scene.courant);
    Case::towards(&grid, scene.slots, target).among(Some(solid))
}

/// What a cycle among solids leaves, from rest and near the rounding floor, by the core and by the second implementation.
fn converges_among<S: Space>(cells: &[usize], ends: &str, solid: Solid) {
    let scene = Scene::new(cells, ends, 7);
    let mut case = among::<f64>(&scene, solid);
    let list = case.residuals::<S>(&Serial, &scene.setup(), 4);
    for pair in list.windows(2).take_while(|pair| pair[0] > 1e-9 * list[0]) {
        assert!(
            pair[1] <= 0.3 * pair[0],
            "{cells:?} {ends}: a V-cycle leaves {} of {}",
            pair[1],
            pair[0]
        );
    }
    let residual = case.equations(scene.kappa, 0.0).residual().norm(case.grid.h[0]);
    assert!(
        residual < 1e-5 * list[0],
        "{cells:?} {ends}: {residual:e} is left of {:e}",
        list[0]
    );
    let mut single = among::<f32>(&scene, solid);
    let list = single.residuals::<S>(&Serial, &scene.setup(), 3);
    assert!(list[3] < 1e-4 * list[0], "{cells:?} {ends} in f32: {list:?}");
}

#[test]
fn solids_in_the_way() {
    let solids: [Solid; 3] = [disc, plate, lost_plate];
    for solid in solids {
        converges_among::<D2>(&[32, 32], "ww", solid);
        converges_among::<D2>(&[33, 20], "wp", solid);
        converges_among::<D2>(&[24, 27], "pw", solid);
        converges_among::<D3>(&[16, 12, 13], "wpw", solid);
    }
}

/// A solution stays where it is, whatever the smoother does to the cells around closed faces.
#[test]
fn solutions_among_solids_stay() {
    let scene = Scene::new(&[20, 18], "ww", 5);
    let mut case = among::<f64>(&scene, disc);
    case.residuals::<D2>(&Serial, &scene.setup(), 12);
    let before = case.clone();
    let list = case.residuals::<D2>(&Serial, &scene.setup(), 1);
    assert!(list[0] < 1e-13 && list[1] < 1e-13, "{list:?}");
    let change = largest_of(&add_scaled_all(&case.v, -1.0, &before.v));
    assert!(change < 1e-12, "the flow changes by {change:e}");
}

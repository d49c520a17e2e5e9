//! STFAS: how fast V-cycles converge.

use crate::fields::spacetime::{Case, setup};
use crate::fields::{flow, grid};
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

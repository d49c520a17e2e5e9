//! A flow among solid cells whose change is smooth, and small where the flow matters.

use crate::fields::feasible::faces;
use crate::fields::naive::Naive;
use crate::fields::random::Random;
use crate::fields::{
    Components, Memory, add_scaled_all, boundaries, dot_all, flow, largest, largest_of, places, with_threads,
};
use crate::refined::{files, problem};
use thurible_core::grid::Grid;
use thurible_core::{Problem, Refined, Refinement, Silent, Yielding};

/// A block in the box, away from its walls.
fn is_solid(at: [usize; 3]) -> bool {
    (5..9).contains(&at[0]) && (4..8).contains(&at[1]) && at[2] < 5
}

/// A case: its grid, the flow that is given, and an importance of cells.
struct Case {
    cells: Vec<usize>,
    ends: &'static str,
    grid: Grid,
    v: Components<f64>,
    importance: Vec<f64>,
}

impl Case {
    fn new(cells: &[usize], ends: &'static str) -> Self {
        let grid = Grid::new(cells, &boundaries(ends));
        let of = |[x, y, z]: [usize; 3]| 0.1 + ((3 * x + 5 * y + 7 * z) % 10) as f64 * 0.1;
        Self {
            cells: cells.to_vec(),
            ends,
            v: flow::rough(&mut Random::new(75), &grid, 1, 0.7),
            importance: places(&grid).map(of).collect(),
            grid,
        }
    }

    /// The flow that gives way, and in how many iterations.
    fn found(&self, how: Option<Yielding>, threads: usize) -> (Components<f64>, usize) {
        let ends = &boundaries(self.ends);
        let problem = Problem {
            solids: true,
            projection_tolerance: 1e-11,
            ..problem(&self.cells, ends, &[])
        };
        let refinement = Refinement {
            weighted: how,
            threads,
            ..Refinement::default()
        };
        let bytes = Refined::<f64>::bytes(&problem, refinement).unwrap();
        let mut memory = Memory::new(bytes);
        let mut refined = Refined::<f64>::carve(&problem, refinement, memory.block()).unwrap();
        let solid: Vec<bool> = places(&self.grid).map(is_solid).collect();
        refined.set_solids(&solid).unwrap();
        refined.set_density(&vec![1.0; self.grid.cells()]).unwrap();
        if how.is_some() {
            refined.set_importance(&self.importance).unwrap();
        }
        let unit = problem.length / problem.dt;
        for (axis, faces) in files(&self.grid, &self.v).into_iter().enumerate() {
            let faces: Vec<f64> = faces.into_iter().map(|face| face * unit).collect();
            refined.set_velocity(axis, &faces).unwrap();
        }
        with_threads(threads, |exec| refined.advance(exec, &mut Silent)).unwrap();
        let component = |axis| {
            let mut out = vec![f64::NAN; refined.faces(axis)];
            refined.velocity(axis, &mut out).unwrap();
            out.iter().map(|x| x / unit).collect()
        };
        let all: Vec<Vec<f64>> = (0..self.grid.dims).map(component).collect();
        (faces(&self.grid, &all), refined.effort().iterations)
    }

    /// W^2 Delta + alpha C^T C Delta in cells, plaquettes at closed faces left out.
    fn slope(&self, alpha: f64, change: &Components<f64>) -> Components<f64> {
        let naive = Naive::new(&self.grid);
        let closed = |at: [usize; 3], axis: usize| {
            let low = naive.step(at, axis, -1);
            low.is_none_or(|low| is_solid(low) || is_solid(at))
        };
        let mut out = naive.at_faces(|axis, at| {
            let low = naive.step(at, axis, -1).unwrap();
            let mean = 0.5 * (self.importance[naive.id(low)] + self.importance[naive.id(at)]);
            mean * mean * change[axis][naive.id(at)]
        });
        for a in 0..self.grid.dims {
            for b in a + 1..self.grid.dims {
                for at in places(&self.grid) {
                    let (Some(below), Some(left)) = (naive.step(at, b, -1), naive.step(at, a, -1)) else {
                        continue;
                    };
                    if closed(at, a) || closed(below, a) || closed(at, b) || closed(left, b) {
                        continue;
                    }
                    let [here, below, left] = [at, below, left].map(|at| naive.id(at));
                    let omega = change[b][here] - change[b][left] - change[a][here] + change[a][below];
                    out[b][here] += alpha * omega;
                    out[b][left] -= alpha * omega;
                    out[a][here] -= alpha * omega;
                    out[a][below] += alpha * omega;
                }
            }
        }
        out
    }
}

fn exact(smoothness: f64) -> Option<Yielding> {
    Some(Yielding {
        smoothness,
        tolerance: 1e-9,
        iterations: 4000,
    })
}

#[test]
fn no_admissible_change_makes_it_less() {
    for (cells, ends) in [(&[14, 12][..], "ww"), (&[12, 13], "pw"), (&[11, 10, 7], "wpw")] {
        let case = Case::new(cells, ends);
        let naive = Naive::new(&case.grid);
        let (plain, none) = case.found(None, 1);
        let (weighted, _) = case.found(exact(0.0), 1);
        let (found, iterations) = case.found(exact(0.5), 1);
        assert!(
            none == 0 && (5..4000).contains(&iterations),
            "{iterations} iterations"
        );
        let divergence = largest(naive.divergence(&found)) * case.grid.h[0] / largest_of(&case.v);
        assert!(divergence < 1e-9, "{cells:?}: divergence {divergence:e}");
        for (at, axis) in places(&case.grid).flat_map(|at| (0..cells.len()).map(move |axis| (at, axis))) {
            let solid = is_solid(at) || naive.step(at, axis, -1).is_some_and(is_solid);
            assert!(!solid || found[axis][naive.id(at)] == 0.0, "{at:?}");
        }
        // Differences of flows that all fit are what may be added.
        let change = add_scaled_all(&found, -1.0, &case.v);
        let slope = case.slope(0.5, &change);
        let rough = |flow: &Components<f64>| {
            let change = add_scaled_all(flow, -1.0, &case.v);
            dot_all(&case.slope(1.0, &change), &change) - dot_all(&case.slope(0.0, &change), &change)
        };
        for other in [&plain, &weighted] {
            let way = add_scaled_all(other, -1.0, &found);
            let size = (dot_all(&slope, &slope) * dot_all(&way, &way)).sqrt();
            let along = dot_all(&slope, &way) / size;
            assert!(size > 0.0 && along.abs() < 1e-6, "{cells:?}: {along:e}");
        }
        assert!(rough(&found) < rough(&weighted), "{cells:?}: it is no smoother");
        assert_eq!(found, case.found(exact(0.5), 3).0, "{cells:?}: on three threads");
    }
}

#[test]
fn without_a_price_of_vorticity_it_is_the_weighted_solve() {
    let case = Case::new(&[14, 12], "wp");
    let (weighted, _) = case.found(exact(0.0), 1);
    let (found, _) = case.found(exact(1e-9), 1);
    let apart = largest_of(&add_scaled_all(&found, -1.0, &weighted)) / largest_of(&case.v);
    assert!(apart < 1e-6, "{apart:e}");
    // As it ends by itself it is near the limit, soon.
    let near = Yielding {
        smoothness: 0.5,
        ..Yielding::default()
    };
    let (limit, _) = case.found(exact(0.5), 1);
    let (ended, iterations) = case.found(Some(near), 1);
    let change = add_scaled_all(&limit, -1.0, &case.v);
    let off = add_scaled_all(&ended, -1.0, &limit);
    let apart = (dot_all(&off, &off) / dot_all(&change, &change)).sqrt();
    assert!(apart < 0.02 && iterations < 100, "{apart:e} after {iterations}");
}

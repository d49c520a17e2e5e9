//! Seconds of the kernels that solves are made of, in f32 on synthetic flows, and the least bytes that each must move.

use super::navier_stokes::Case;
use super::pieces::{Carried, Trajectories};
use super::timing::{best, timed};
use super::{scenes, solves};
use core::hint::black_box;
use thurible::exit::Failure;
use thurible_core::{DirectParams, Exec, Scheme, Silent, Space};

/// Part of its divergence that the projection leaves.
const PROJECTION_TOLERANCE: f64 = 1e-4;
/// Iterations of the direct method beyond the repeats, of all of which the median counts: those that first touch the memory of a pair are slow.
const MORE_ITERATIONS: usize = 8;

/// A piece of a solve that is measured by itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kernel {
    /// One V(2,2) cycle of STFAS.
    Cycle,
    /// Forward transport of all steps.
    Forward,
    /// Backward transport of all steps with the gradient by the velocity.
    Backward,
    /// Projection of all slots.
    Projection,
    /// One iteration of the direct method, everything.
    Direct,
}

impl Kernel {
    /// All of them.
    pub const ALL: [Self; 5] = [
        Self::Cycle,
        Self::Forward,
        Self::Backward,
        Self::Projection,
        Self::Direct,
    ];

    /// Its name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Cycle => "STFAS V(2,2) cycle",
            Self::Forward => "forward transport",
            Self::Backward => "backward transport with gradient",
            Self::Projection => "projection to 1e-4",
            Self::Direct => "direct iteration",
        }
    }

    /// Its name on the command line.
    pub fn word(self) -> &'static str {
        match self {
            Self::Cycle => "cycle",
            Self::Forward => "forward",
            Self::Backward => "backward",
            Self::Projection => "projection",
            Self::Direct => "direct",
        }
    }

    /// Seconds on `cells` and `steps`, the best of `repeats`; of the direct method, the median of its iterations from number `repeats` on.
    ///
    /// # Errors
    /// [`Failure`]: there is no memory for it.
    pub fn seconds<S: Space>(
        self,
        exec: &dyn Exec,
        cells: &[usize],
        steps: usize,
        repeats: usize,
    ) -> Result<f64, Failure> {
        match self {
            Self::Cycle => Case::new(cells, steps, 1.0).pose::<f32, S, _>(exec, |nso| {
                best(repeats, || {
                    let _ = nso.vcycle(exec, &mut Silent);
                })
            }),
            Self::Forward => Ok(forward::<S>(exec, cells, steps, repeats)),
            Self::Backward => Ok(backward::<S>(exec, cells, steps, repeats)),
            Self::Projection => projection::<S>(exec, cells, steps, repeats),
            Self::Direct => {
                let prepared = scenes::drift(cells, steps, false, exec.threads())?;
                solves::iterations::<f32, S, 1>([exec], &prepared, [repeats, repeats + MORE_ITERATIONS])
                    .map(|[iterations]| iterations.seconds)
            }
        }
    }

    /// Values that must at least be read or written for each cell and step in `dims` dimensions: every field once in each pass
    /// that the algorithm cannot do without.
    pub fn least_values(self, dims: usize) -> f64 {
        let d = dims as f64;
        match self {
            // Four smoothings, each reading targets and unknowns and writing these; a residual, which reads both; two
            // corrections, which read and write the unknowns. Coarser grids add a part 2^-d each.
            Self::Cycle => {
                let unknowns = 2.0 * (1.0 + d);
                let finest = 4.0 * (2.0 * unknowns + d) + unknowns + d + 2.0 * 2.0 * unknowns;
                finest / (1.0 - 0.5_f64.powi(dims as i32))
            }
            // Density and velocity read, density written.
            Self::Forward => d + 2.0,
            // Density and velocity read, gradient written.
            Self::Backward => 2.0 * d + 1.0,
            // Velocity read and written.
            Self::Projection => 2.0 * d,
            // With one evaluation: the direction from all pairs, each of which L-BFGS reads twice, and its projection; the move,
            // densities, the force and its projection; the gradient of force and data and its projection; a new pair.
            Self::Direct => {
                let [forward, backward, projection] =
                    [Self::Forward, Self::Backward, Self::Projection].map(|kernel| kernel.least_values(dims));
                let pairs = DirectParams::MOST_BY_DEFAULT as f64;
                let direction = (4.0 * pairs + 2.0) * d + projection;
                let value = 3.0 * d + forward + 2.0 * d + projection;
                let gradient = 3.0 * d + backward + projection;
                direction + value + gradient + 4.0 * d
            }
        }
    }
}

/// Carries the density through all steps.
fn run(
    exec: &dyn Exec,
    transport: &mut thurible_core::transport::Transport<'_, f32>,
    flow: &thurible_core::transport::Flow<'_, f32>,
    slots: usize,
    rho: &mut [f32],
    sums: &mut [f64],
) {
    let _ = (0..=slots).try_for_each(|step| transport.step(exec, flow, slots, step, rho, sums));
}

fn forward<S: Space>(exec: &dyn Exec, cells: &[usize], steps: usize, repeats: usize) -> f64 {
    let all = Trajectories::new(cells, steps - 1);
    all.transport::<S, _>(exec, Scheme::Quick, |transport, Carried { flow, rho, sums }| {
        best(repeats, || {
            run(exec, transport, &flow, all.slots, rho, sums);
        })
    })
}

fn backward<S: Space>(exec: &dyn Exec, cells: &[usize], steps: usize, repeats: usize) -> f64 {
    let all = Trajectories::new(cells, steps - 1);
    let (len, slots) = (all.grid.cells(), all.slots);
    all.transport::<S, _>(exec, Scheme::Quick, |transport, Carried { flow, rho, sums }| {
        run(exec, transport, &flow, slots, rho, sums);
        let mut mu = vec![0f32; len];
        best(repeats, || {
            mu.copy_from_slice(&rho[(slots + 1) * len..]);
            for step in (1..=slots).rev() {
                let _ = transport.load(exec, &flow, slots, step, sums);
                transport.backward(exec, &rho[step * len..][..len], &mut mu);
            }
            black_box(transport.gradient());
        })
    })
}

fn projection<S: Space>(
    exec: &dyn Exec,
    cells: &[usize],
    steps: usize,
    repeats: usize,
) -> Result<f64, Failure> {
    let all = Trajectories::new(cells, steps - 1);
    all.projection::<S, _>(exec, |projection, start, sums| {
        let run = |_| {
            let mut v = start.clone();
            let mut v = v.each_mut().map(|component| &mut component[..]);
            timed(|| {
                let _ = projection.project(exec, &mut Silent, &mut v, None, PROJECTION_TOLERANCE, sums);
            })
        };
        (0..repeats).map(run).fold(f64::INFINITY, f64::min)
    })
}

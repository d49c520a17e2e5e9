//! Optimal control of smoke in one block of memory: the numerical core of thurible.
//!
//! Given the density rho_0 of some smoke and keyframes rho*_i that it should pass through, find the smallest force that takes
//! it there:
//!
//! ```text
//! minimise    J = 1/2 sum_i <rho_i - rho*_i, C (rho_i - rho*_i)>  +  r/2 sum_k |u_k|^2            (paper eq. 5)
//! where       rho_{i+1} = A[rho_i, v_i]                                 density rides on the flow   (eq. 4)
//!             (v_{k+1} - v_k)/dt + (curl v_{k+1}) x v_{k+1} = u_k - grad p_{k+1},   div v = 0       (eqs. 1 to 3)
//! ```
//!
//! with C a sum of Gaussian blurs. The problem is that of Pan & Manocha, *Efficient Optimal Control of Smoke using Spacetime
//! Multigrid* (arXiv 1608.01102); their method, ADMM with a multigrid for all time steps of the flow at once, is one of several
//! ([`Method`]).
//!
//! No `alloc`, no `std`: [`Plan`] computes every byte from the problem, the caller brings the memory, [`Solver`] carves it
//! once. Threads are a value too ([`Exec`]), and any number of them gives the same bits.
//!
//! # The path of the data
//!
//! A module imports only from those before it, and from those in its row; `tests/layering` reads this table.
//!
//! | | module | what it does |
//! |---|---|---|
//! | ground | [`words`] | the words of choices and outcomes, for every interface |
//! | | [`memory`] | the caller's bytes, handed out; the ledger of named buffers, together and in turn |
//! | | [`simd`], [`real`] | vectors, and loops compiled for several instruction sets; f32 and f64 behind one trait |
//! | | [`exec`] | threads: rows of a field as tasks |
//! | | [`observe`] | what a host can watch and stop |
//! | | [`checkpoint`] | the state of a solve as plain bytes |
//! | | [`reversal`] | the order in which steps are taken back where few states are kept |
//! | | [`progress`] | what an iteration reports, and how a solve ends |
//! | what is solved | [`grid`] | the staggered grid, coarser grids and the weights between them, eigenvectors along its axes |
//! | | [`problem`] | box, time, weights; checked once |
//! | | [`field`] | views of trajectories, their algebra, loops over rows, sums in a fixed order |
//! | pieces | [`operators`] | divergence, gradient, self-advection and its adjoint, blur |
//! | | [`walk`] | a random walk that places samples, and priors on them |
//! | | [`poisson`] | the projection onto div v = 0, by eigenvectors |
//! | | [`transport`] | A\[rho, v\] and its exact adjoint |
//! | | [`force`] | the force that a given flow needs |
//! | | [`flow`] | the flow between two frames of smoke, as optical flow without divergence |
//! | | [`objective`] | keyframes and data term, the density's sweep forward and back, J as a function of the flow, coarser scenes |
//! | | [`optimise`] | L-BFGS over trajectories, line search |
//! | | [`nso`] | the Navier-Stokes problem: the cheapest forced flow near a given one, by STFAS or Newton-CG |
//! | before it is solved | [`deblur`], [`tomography`] | a sharp image from a blurred one; density from photographs |
//! | ways to solve it | [`method`] | the paper's ADMM, the direct method, L-BFGS over the forces, simulation free or driven |
//! | front door | [`solver`] | [`Plan`], [`Solver`], [`Status`] |
//! | another simulator | [`stable_fluids`] | [`Fluids`]: Stam's solver at cell centres, its exact adjoint, and control by few numbers |
//! | bodies | [`condense`] | coordinate condensation: an elastic body's energy, minimised block by block |
//! | for other programs | [`operator`] | [`Operator`]: the simulation and its exact adjoint, step by step, in planned memory |
//! | from frames | [`track`] | [`Tracker`]: the flow behind a sequence of frames, in the memory of three of them |
//!
//! # Example
//!
//! A blob of smoke that moves one cell to the right, solved in an array.
//!
//! ```
//! use core::mem::MaybeUninit;
//! use thurible_core::{Boundary, D2, Params, Plan, Problem, Serial, Silent, Solver, Status};
//!
//! # fn main() -> Result<(), Box<dyn core::error::Error>> {
//! let problem = Problem { force_weight: 1.0, ..Problem::new(&[8, 8], &[Boundary::Wall, Boundary::Periodic], &[4]) };
//! let params = Params::default();
//! assert!(Plan::new::<f64, D2>(&problem, &params)?.bytes() <= 1 << 18);
//!
//! #[repr(align(64))]
//! struct Memory([MaybeUninit<u8>; 1 << 18]);
//! let mut memory = Memory([MaybeUninit::uninit(); 1 << 18]);
//!
//! // One density for each cell, x fastest.
//! let blob = |x: f64| -> [f64; 64] {
//!     core::array::from_fn(|cell| 1.0 / (1.0 + ((cell % 8) as f64 - x).powi(2) + ((cell / 8) as f64 - 3.5).powi(2)))
//! };
//! let mut solver = Solver::<f64, D2>::new(&problem, &params, &mut memory.0)?;
//! solver.set_source(&blob(2.5))?;
//! solver.set_keyframe(0, &blob(3.5))?;
//!
//! let mut first = None;
//! let status = solver.solve(&Serial, &mut Silent, &mut |progress| {
//!     first.get_or_insert(progress.objective.total());
//! });
//! assert_eq!(status, Status::Converged);
//! assert!(first.is_some_and(|first| solver.objective().total() < first / 2.0));
//!
//! let (before, after): (f64, f64) = (solver.density(0).iter().sum(), solver.density(4).iter().sum());
//! assert!((before - after).abs() < 1e-9 * before, "smoke is neither made nor lost");
//! # Ok(())
//! # }
//! ```
#![no_std]

pub mod checkpoint;
pub mod condense;
pub mod deblur;
pub mod exec;
pub mod field;
pub mod flow;
pub mod force;
pub mod grid;
pub mod memory;
pub mod method;
pub mod nso;
pub mod objective;
pub mod observe;
pub mod operator;
pub mod operators;
pub mod optimise;
pub mod poisson;
pub mod problem;
pub mod progress;
pub mod real;
pub mod reversal;
pub mod simd;
pub mod solver;
pub mod stable_fluids;
pub mod tomography;
pub mod track;
pub mod transport;
pub mod walk;
pub mod words;

pub use exec::{Exec, Serial};
pub use flow::{turbulence::Turbulence, yielding::Yielding};
pub use grid::{Boundary, D2, D3, Space};
pub use memory::{Entry, Sharing};
pub use method::choices;
pub use method::output::{self, Output, Place, Unit};
pub use method::params::each::*;
pub use method::simulate::guide::GuideSolver;
pub use nso::{Norm, NsoParams, NsoSolver, colours::Colours};
pub use observe::{Event, Observer, Phase, Silent};
pub use operator::{Operator, OperatorParams, OperatorPlan};
pub use optimise::quasi_newton::history::HistoryPrecision;
pub use problem::{
    Advection, Emitter, Feature, Problem, ProblemError, Scheme, ShareError, Supply, Template, TemplateKind,
};
pub use progress::{Fact, Falls, Kind, Objective, Progress, Report, Rule, Status};
pub use real::Real;
pub use solver::{
    Elsewhere, InputError, Method, Params, Plan, PlanError, Refined, Refinement, SavedError, Solver,
    SolverError,
};
pub use stable_fluids::{Fluids, FluidsParams, FluidsPlan};
pub use track::{Capture, TrackParams, TrackPlan, Tracker};
pub use words::Named;

/// The example of the README.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;

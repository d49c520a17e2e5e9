//! What a call of AO is given, and what it tells.

use crate::field::{Vector, VectorMut};
use crate::objective::flow;
use crate::objective::script::Script;
use crate::progress::MAX_RESIDUALS;

/// What does not change from call to call.
#[derive(Clone, Copy, Debug)]
pub struct Setup {
    /// Penalty K in scaled numbers.
    pub penalty: f64,
    /// Fixed-point iterations of a call.
    pub iterations: usize,
    /// Momentum beta between the iterations of a call.
    pub momentum: f64,
    /// The objective of a flow.
    pub flow: flow::Setup,
}

/// The fields of a call.
#[derive(Debug)]
pub struct Fields<'a, T> {
    /// v of the Navier-Stokes problem.
    pub v: Vector<'a, T>,
    /// lambda / K.
    pub multiplier: Vector<'a, T>,
    /// v*, which begins as v.
    pub star: VectorMut<'a, T>,
    /// Work: the direction in which v* moves.
    pub direction: VectorMut<'a, T>,
    /// The given velocity v_0.
    pub initial: Vector<'a, T>,
    /// rho_0 .. rho_N of the last call, and of this one afterwards.
    pub rho: &'a mut [T],
    /// What is given for the steps.
    pub script: &'a Script<'a, T>,
}

/// What a call did.
#[derive(Clone, Debug, Default)]
pub struct Info {
    /// The blending step of the last iteration.
    pub step: f64,
    /// Data term of v before the call.
    pub data_before: f64,
    /// Data term of v* after it.
    pub data: f64,
    /// AO objective after it.
    pub objective: f64,
    /// max |direction| of each blend: without momentum the residual of the fixed point.
    pub residuals: heapless::Vec<f64, MAX_RESIDUALS>,
    /// max over cells and steps of the change of rho since the last call.
    pub density_change: f64,
}

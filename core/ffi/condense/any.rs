//! A condenser of any of six types: either precision in one, two or three dimensions.

use super::config::ThuribleCondenseConfig;
use crate::config::{ConfigError, ThuriblePrecision};
use crate::result::ThuribleResult;
use core::mem::MaybeUninit;
use thurible_core::condense::{
    CondenseError, CondenseParams, CondensePlan, Condenser, Iteration, Mesh, Step, Stepped, Topology,
};
use thurible_core::{Exec, Observer, Real};

/// What all of them do.
pub trait Elastic {
    /// Vertices.
    fn vertices(&self) -> usize;
    /// As [`Condenser::step`].
    ///
    /// # Errors
    /// [`CondenseError`].
    fn step(
        &mut self,
        exec: &dyn Exec,
        step: &Step<'_>,
        observer: &mut dyn Observer,
        tell: &mut dyn FnMut(&Iteration),
    ) -> Result<Stepped, CondenseError>;
    /// As [`Condenser::shift`].
    ///
    /// # Errors
    /// [`CondenseError`].
    fn shift(&mut self, shift: &[f64]) -> Result<(), CondenseError>;
    /// As [`Condenser::set_velocity`].
    ///
    /// # Errors
    /// [`CondenseError`].
    fn set_velocity(&mut self, velocity: &[f64]) -> Result<(), CondenseError>;
    /// Position, displacement, gradient and direction of a vertex.
    fn of(&self, vertex: usize) -> [[f64; 3]; 4];
}

impl<T: Real, const D: usize> Elastic for Condenser<'static, T, D> {
    fn vertices(&self) -> usize {
        self.vertices()
    }

    fn step(
        &mut self,
        exec: &dyn Exec,
        step: &Step<'_>,
        observer: &mut dyn Observer,
        tell: &mut dyn FnMut(&Iteration),
    ) -> Result<Stepped, CondenseError> {
        self.step(exec, step, observer, tell)
    }

    fn shift(&mut self, shift: &[f64]) -> Result<(), CondenseError> {
        self.shift(shift)
    }

    fn set_velocity(&mut self, velocity: &[f64]) -> Result<(), CondenseError> {
        self.set_velocity(velocity)
    }

    fn of(&self, vertex: usize) -> [[f64; 3]; 4] {
        [
            self.position(vertex),
            self.displacement(vertex),
            self.gradient(vertex),
            self.direction(vertex),
        ]
    }
}

/// Either precision in one, two or three dimensions.
#[derive(Debug)]
pub enum AnyCondenser {
    /// A rod in `f32`,
    Line32(Condenser<'static, f32, 1>),
    /// in `f64`,
    Line64(Condenser<'static, f64, 1>),
    /// a plane,
    Plane32(Condenser<'static, f32, 2>),
    /// in `f64`,
    Plane64(Condenser<'static, f64, 2>),
    /// a body,
    Space32(Condenser<'static, f32, 3>),
    /// in `f64`.
    Space64(Condenser<'static, f64, 3>),
}

impl AnyCondenser {
    /// What is inside.
    pub fn one(&mut self) -> &mut dyn Elastic {
        match self {
            Self::Line32(one) => one,
            Self::Line64(one) => one,
            Self::Plane32(one) => one,
            Self::Plane64(one) => one,
            Self::Space32(one) => one,
            Self::Space64(one) => one,
        }
    }

    /// Makes one of `kind` in the first bytes of `memory`.
    ///
    /// # Errors
    /// [`CondenseError`].
    pub fn new(
        kind: (ThuriblePrecision, usize),
        mesh: Mesh<'static>,
        topology: Topology<'static>,
        params: CondenseParams,
        memory: &'static mut [MaybeUninit<u8>],
    ) -> Result<Self, CondenseError> {
        Ok(match kind {
            (ThuriblePrecision::F32, 1) => Self::Line32(Condenser::new(mesh, topology, params, memory)?),
            (ThuriblePrecision::F64, 1) => Self::Line64(Condenser::new(mesh, topology, params, memory)?),
            (ThuriblePrecision::F32, 2) => Self::Plane32(Condenser::new(mesh, topology, params, memory)?),
            (ThuriblePrecision::F64, 2) => Self::Plane64(Condenser::new(mesh, topology, params, memory)?),
            (ThuriblePrecision::F32, _) => Self::Space32(Condenser::new(mesh, topology, params, memory)?),
            (ThuriblePrecision::F64, _) => Self::Space64(Condenser::new(mesh, topology, params, memory)?),
        })
    }
}

/// Bytes of the lists of a body and of the block of its condenser, which is planned with the lists in `memory`.
///
/// # Errors
/// [`ConfigError`].
///
/// # Safety
/// The lists of `config` have as many entries as it says.
pub unsafe fn bytes(
    config: &ThuribleCondenseConfig,
    memory: &'static mut [MaybeUninit<u8>],
) -> Result<usize, ConfigError> {
    let (precision, _) = config.kind()?;
    // SAFETY: the caller's promise.
    let (mesh, topology) = unsafe { config.body(memory) }?;
    let params = config.params()?;
    let own = match precision {
        ThuriblePrecision::F32 => block::<f32>(&mesh, &topology, &params),
        ThuriblePrecision::F64 => block::<f64>(&mesh, &topology, &params),
    };
    let all = config.lists_bytes()?.checked_add(own?);
    Ok(all.ok_or(ThuribleResult::TooLarge)?)
}

// Not inlined: a plan takes much of a stack.
#[inline(never)]
fn block<T: Real>(
    mesh: &Mesh<'_>,
    topology: &Topology<'_>,
    params: &CondenseParams,
) -> Result<usize, CondenseError> {
    Ok(CondensePlan::new::<T>(mesh, topology, params)?.bytes())
}

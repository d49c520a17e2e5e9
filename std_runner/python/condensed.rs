//! An elastic body as Python chooses it, in memory of its own.

use crate::block::Block;
use crate::plan::{Precision, precision};
use crate::words::{flag, number, read, refused, unknown, whole, word};
use core::mem::MaybeUninit;
use pyo3::exceptions::PyMemoryError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use thurible::bytes::grouped;
use thurible::threads;
use thurible_core::condense::{
    CondenseError, CondenseParams, CondensePlan, Iteration, Material, Mesh, Spring, Step, Stepped, Topology,
};
use thurible_core::{Exec, Observer, Real};

/// A body of any precision and dimension.
pub trait Body: Send + Sync {
    /// The next step.
    fn step(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        step: &Step<'_>,
        tell: &mut dyn FnMut(&Iteration),
    ) -> Result<Stepped, CondenseError>;
    /// Gives free vertices a velocity.
    fn set_velocity(&mut self, velocity: &[f64]) -> Result<(), CondenseError>;
    /// Where a vertex is.
    fn position(&self, vertex: usize) -> [f64; 3];
    /// The gradient by a vertex.
    fn gradient(&self, vertex: usize) -> [f64; 3];
    /// Steps and builds.
    fn done(&self) -> [usize; 2];
}

impl<T: Real, const D: usize> Body for thurible_core::condense::Condenser<'static, T, D> {
    fn step(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        step: &Step<'_>,
        tell: &mut dyn FnMut(&Iteration),
    ) -> Result<Stepped, CondenseError> {
        self.step(exec, step, observer, tell)
    }

    fn set_velocity(&mut self, velocity: &[f64]) -> Result<(), CondenseError> {
        self.set_velocity(velocity)
    }

    fn position(&self, vertex: usize) -> [f64; 3] {
        self.position(vertex)
    }

    fn gradient(&self, vertex: usize) -> [f64; 3] {
        self.gradient(vertex)
    }

    fn done(&self) -> [usize; 2] {
        [self.steps(), self.builds()]
    }
}

/// What a body points to.
pub struct Kept {
    /// Positions at rest.
    pub rest: Vec<f64>,
    /// Corners of elements.
    pub elements: Vec<u32>,
    /// Springs.
    pub springs: Vec<Spring>,
    /// Whether each vertex is held.
    pub held: Vec<bool>,
    words: Vec<u32>,
    block: Block,
}

/// What is chosen by name.
pub struct Choices {
    /// How it is minimised.
    pub params: CondenseParams,
    /// What it is made of.
    pub material: Material,
    /// Springs.
    pub springs: Vec<Spring>,
    /// Of all numbers.
    pub precision: Precision,
    /// Bytes at most.
    pub limit: Option<usize>,
}

const NAMES: [&str; 18] = [
    "springs",
    "young",
    "poisson",
    "density",
    "area",
    "method",
    "basis",
    "rebuild",
    "radius",
    "order",
    "block",
    "tolerance",
    "cap",
    "search",
    "dt",
    "dtype",
    "threads",
    "memory_limit",
];

impl Choices {
    /// Those of `given`.
    pub fn read(given: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        let mut own = Self {
            params: CondenseParams {
                threads: threads::available(),
                ..CondenseParams::default()
            },
            material: Material::default(),
            springs: Vec::new(),
            precision: Precision::Double,
            limit: None,
        };
        for (name, value) in given.into_iter().flat_map(PyDictMethods::iter) {
            let name: String = name.extract()?;
            if !value.is_none() {
                own.set(&name, &value)?;
            } else if !NAMES.contains(&name.as_str()) {
                return Err(unknown("argument", &name, &NAMES));
            }
        }
        Ok(own)
    }

    fn set(&mut self, name: &str, value: &Bound<'_, PyAny>) -> PyResult<()> {
        let (params, material) = (&mut self.params, &mut self.material);
        match name {
            "springs" => self.springs = springs(value)?,
            "young" => material.young = number(name, value)?,
            "poisson" => material.poisson = number(name, value)?,
            "density" => material.density = number(name, value)?,
            "area" => material.area = number(name, value)?,
            "method" => params.method = word(name, value)?,
            "basis" => params.basis = word(name, value)?,
            "rebuild" => params.rebuild = whole(name, value)?,
            "radius" => params.radius = Some(whole(name, value)?),
            "order" => params.order = word(name, value)?,
            "block" => params.block = word(name, value)?,
            "tolerance" => params.tolerance = number(name, value)?,
            "cap" => params.cap = whole(name, value)?,
            "search" => params.search = flag(name, value)?,
            "dt" => params.dt = Some(number(name, value)?),
            "dtype" => self.precision = precision(value)?,
            "threads" => params.threads = whole(name, value)?,
            "memory_limit" => self.limit = Some(whole(name, value)?),
            _ => return Err(unknown("argument", name, &NAMES)),
        }
        Ok(())
    }
}

/// Springs as tuples (one end, other end, stiffness, rest length).
fn springs(value: &Bound<'_, PyAny>) -> PyResult<Vec<Spring>> {
    let wanted = "a list of tuples (vertex, vertex, stiffness, rest length)";
    let given: Vec<(u32, u32, f64, f64)> = read("springs", value, wanted)?;
    let spring = |(one, other, stiffness, rest_length)| Spring {
        ends: [one, other],
        stiffness,
        rest_length,
        in_basis: true,
    };
    Ok(given.into_iter().map(spring).collect())
}

/// `values`, which stay where they are as long as they are not changed or dropped.
///
/// # Safety
/// They are neither, as long as the slice is used.
unsafe fn staying<V>(values: &[V]) -> &'static [V] {
    // SAFETY: the caller's promise.
    unsafe { core::slice::from_raw_parts(values.as_ptr(), values.len()) }
}

/// The refusal of a body or a step.
pub fn wrong(error: CondenseError) -> PyErr {
    match error {
        CondenseError::Setting { name, allowed } => {
            refused(name, format!("must be {allowed}; change it to that"))
        }
        CondenseError::NoBasis { .. } | CondenseError::NoTurn { .. } => {
            refused("basis", format!("cannot be used: {error}; take it out"))
        }
        CondenseError::Colours { .. } => {
            refused("order", format!("cannot be used: {error}; take \"jacobi\""))
        }
        other => refused("the body", format!("cannot be used: {other}; change that")),
    }
}

impl Kept {
    /// A mesh without a body yet.
    pub fn new(rest: Vec<f64>, elements: Vec<u32>, springs: Vec<Spring>, held: Vec<bool>) -> PyResult<Self> {
        Ok(Self {
            rest,
            elements,
            springs,
            held,
            words: Vec::new(),
            block: Block::new(1).ok_or_else(|| PyMemoryError::new_err("the system has no memory"))?,
        })
    }

    /// Makes the body in a block of its own, and says its bytes.
    pub fn make<T: Real, const D: usize>(&mut self, choices: &Choices) -> PyResult<(Box<dyn Body>, usize)> {
        // SAFETY: they are dropped after the body, the only one to use them, and never changed.
        let mesh = unsafe {
            Mesh {
                dims: D,
                rest: staying(&self.rest),
                elements: staying(&self.elements),
                springs: staying(&self.springs),
                held: staying(&self.held),
                regular: [0; 3],
                material: choices.material,
            }
        };
        self.words = vec![0; Topology::words(&mesh)];
        // SAFETY: as above, and nobody else writes to them.
        let words = unsafe { core::slice::from_raw_parts_mut(self.words.as_mut_ptr(), self.words.len()) };
        let topology = Topology::new(&mesh, choices.params.radius, words).map_err(wrong)?;
        let plan = CondensePlan::new::<T>(&mesh, &topology, &choices.params).map_err(wrong)?;
        let bytes = plan.bytes();
        if let Some(limit) = choices.limit.filter(|&limit| bytes > limit) {
            return Err(PyMemoryError::new_err(format!(
                "the body needs {} bytes, and memory_limit allows {}; raise memory_limit, give a radius, or take a method without a basis",
                grouped(bytes),
                grouped(limit)
            )));
        }
        let remedy = "give a radius, or take a method without a basis";
        self.block = Block::planned(bytes.max(1), "the body", remedy)?;
        let memory = self.block.bytes_mut();
        // SAFETY: as above.
        let memory: &'static mut [MaybeUninit<u8>] =
            unsafe { core::slice::from_raw_parts_mut(memory.as_mut_ptr(), memory.len()) };
        let made = thurible_core::condense::Condenser::<T, D>::new(mesh, topology, choices.params, memory);
        Ok((Box::new(made.map_err(wrong)?), bytes))
    }
}

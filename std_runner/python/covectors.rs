//! Covectors of a trajectory, as Python gives them.

use crate::arrays::numbers;
use crate::place::Number;
use numpy::PyReadonlyArrayDyn;
use pyo3::prelude::*;
use std::borrow::Cow;

/// Arrays by axis, borrowed.
pub type Fields<'py, T> = Vec<PyReadonlyArrayDyn<'py, T>>;

/// Covectors of a trajectory: whole, or of single steps.
pub enum Covectors<'py, T: Number> {
    /// None of them.
    None,
    /// Of all steps.
    Whole(Fields<'py, T>),
    /// Of these.
    Steps(Vec<(usize, Fields<'py, T>)>),
}

/// Covectors whose numbers lie in order.
pub enum InOrder<'a, T: Clone> {
    /// None of them.
    None,
    /// Of all steps.
    Whole(Vec<Cow<'a, [T]>>),
    /// Of these.
    Steps(Vec<(usize, Vec<Cow<'a, [T]>>)>),
}

impl<T: Number> Covectors<'_, T> {
    /// Puts them in order: copies what does not lie so.
    pub fn in_order(&self) -> PyResult<InOrder<'_, T>> {
        Ok(match self {
            Self::None => InOrder::None,
            Self::Whole(fields) => InOrder::Whole(fields.iter().map(numbers).collect::<PyResult<_>>()?),
            Self::Steps(steps) => InOrder::Steps(
                steps
                    .iter()
                    .map(|(step, fields)| Ok((*step, fields.iter().map(numbers).collect::<PyResult<_>>()?)))
                    .collect::<PyResult<_>>()?,
            ),
        })
    }
}

impl<T: Number> InOrder<'_, T> {
    /// Component `axis` of what there is for a step.
    pub fn at(&self, step: usize, len: usize, axis: usize) -> impl Iterator<Item = &[T]> {
        let whole = match self {
            Self::Whole(fields) => fields
                .get(axis)
                .and_then(|field| field.get(step * len..(step + 1) * len)),
            _ => None,
        };
        let steps = match self {
            Self::Steps(steps) => steps.as_slice(),
            _ => &[],
        };
        let single = steps.iter().filter(move |(at, _)| *at == step);
        let single = single.filter_map(move |(_, fields)| fields.get(axis).map(|field| &field[..]));
        whole.into_iter().chain(single)
    }
}

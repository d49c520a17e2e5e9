//! NumPy's arrays as numbers, checked: their kind, their shape and what transport has undershot.

use crate::place::Number;
use crate::plan::Precision;
use crate::words::refused;
use numpy::{Element, PyArrayDyn, PyArrayMethods, PyReadonlyArrayDyn, PyUntypedArray, PyUntypedArrayMethods};
use pyo3::exceptions::{PyMemoryError, PyTypeError, PyUserWarning};
use pyo3::prelude::*;
use std::borrow::Cow;
use std::ffi::CString;
use thurible::undershoot::{Undershoot, clip};

/// What all arrays have in common.
pub struct Common {
    /// Their shape.
    pub shape: Vec<usize>,
    /// Their precision.
    pub precision: Precision,
    /// Where that was found: words for the source, or for the emitter that is first where there is no source.
    pub of: String,
}

/// An array of any kind of numbers, but for a masked one.
pub(crate) fn untyped<'a, 'py>(
    field: &str,
    value: &'a Bound<'py, PyAny>,
) -> PyResult<&'a Bound<'py, PyUntypedArray>> {
    if is_masked(value)? {
        return Err(PyTypeError::new_err(format!(
            "{field} is a masked array, whose hidden values would be taken as they are; give {field}.filled(0)"
        )));
    }
    value.cast().map_err(|_| {
        let kind = value
            .get_type()
            .name()
            .map_or_else(|_| "something else".into(), |name| name.to_string());
        PyTypeError::new_err(format!(
            "{field} is a {kind}; give a NumPy array, as numpy.asarray makes one"
        ))
    })
}

/// Whether `value` is a `numpy.ma.MaskedArray`, which casts to an array without its mask.
fn is_masked(value: &Bound<'_, PyAny>) -> PyResult<bool> {
    let masked = value.py().import("numpy.ma")?.getattr("MaskedArray")?;
    value.is_instance(&masked)
}

/// An array of numbers `T` as all others.
pub(crate) fn array<'py, T: Number>(
    field: &str,
    value: &Bound<'py, PyAny>,
    common: &Common,
) -> PyResult<PyReadonlyArrayDyn<'py, T>> {
    let found = untyped(field, value)?;
    let wanted = numpy::dtype::<T>(value.py());
    let Ok(array) = value.cast::<PyArrayDyn<T>>() else {
        let (found, of) = (found.dtype(), &common.of);
        let why = format!("has dtype {found} where {of} has {wanted}; use .astype(numpy.{wanted})");
        return Err(refused(field, why));
    };
    readable(field, array, common)
}

/// The truth values of an array as all others.
pub(crate) fn flags(field: &str, value: &Bound<'_, PyAny>, common: &Common) -> PyResult<Vec<bool>> {
    let found = untyped(field, value)?;
    let Ok(array) = value.cast::<PyArrayDyn<bool>>() else {
        let why = format!(
            "has dtype {}; give an array of truth values, as array > 0.5",
            found.dtype()
        );
        return Err(refused(field, why));
    };
    let array = readable(field, array, common)?;
    copied(array.len(), array.as_array().iter().copied())
}

/// An array to read, of the shape of all others.
fn readable<'py, V: Element>(
    field: &str,
    array: &Bound<'py, PyArrayDyn<V>>,
    Common { shape, .. }: &Common,
) -> PyResult<PyReadonlyArrayDyn<'py, V>> {
    if array.shape() != shape {
        let found = array.shape();
        let why = format!("has shape {found:?} where {shape:?} is needed; give an array of that shape");
        return Err(refused(field, why));
    }
    laid(array)?
        .try_readonly()
        .map_err(|error| refused(field, format!("is being written to: {error}; let go of it first")))
}

/// The array itself, or a copy where numbers do not lie on multiples of their size, as in a field of a packed record: views of
/// those would read beside them.
fn laid<'py, V: Element>(array: &Bound<'py, PyArrayDyn<V>>) -> PyResult<Bound<'py, PyArrayDyn<V>>> {
    let mut strides = array.strides().iter();
    if array.is_aligned() && strides.all(|stride| stride.unsigned_abs().is_multiple_of(size_of::<V>())) {
        return Ok(array.clone());
    }
    Ok(array.call_method0("copy")?.cast_into::<PyArrayDyn<V>>()?)
}

/// The values of a density in order. What transport has undershot becomes 0 in a copy, with a warning; what is plainly no density is
/// refused.
pub(crate) fn density<'a, T: Number>(
    field: &str,
    array: &'a PyReadonlyArrayDyn<'_, T>,
) -> PyResult<Cow<'a, [T]>> {
    let values = numbers(array)?;
    let Some(found) = Undershoot::of(&values) else {
        return Ok(values);
    };
    if !found.is_small() {
        let [found, remedy] = found.refused(array.shape());
        return Err(refused(field, format!("{found}; {remedy}")));
    }
    let (py, text) = (array.py(), CString::new(format!("{field} {}", found.taken()))?);
    PyErr::warn(py, &py.get_type::<PyUserWarning>(), &text, 1)?;
    let mut values = match values {
        Cow::Owned(values) => values,
        Cow::Borrowed(values) => copied(values.len(), values.iter().copied())?,
    };
    clip(&mut values);
    Ok(Cow::Owned(values))
}

/// The numbers in order, x fastest; copied only if they do not lie so.
pub(crate) fn numbers<'a, T: Number>(array: &'a PyReadonlyArrayDyn<'_, T>) -> PyResult<Cow<'a, [T]>> {
    match array.as_slice() {
        Ok(numbers) if array.is_c_contiguous() => return Ok(Cow::Borrowed(numbers)),
        _ => {}
    }
    copied(array.len(), array.as_array().iter().copied()).map(Cow::Owned)
}

/// A list of `count` values.
fn copied<T>(count: usize, values: impl Iterator<Item = T>) -> PyResult<Vec<T>> {
    let mut copy = Vec::new();
    copy.try_reserve_exact(count)
        .map_err(|_| PyMemoryError::new_err("the system has not the memory to put an array in order"))?;
    copy.extend(values);
    Ok(copy)
}

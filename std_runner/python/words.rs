//! Arguments of Python's, read one by one; what is wrong names the argument and the remedy.

use core::fmt::Display;
use pyo3::exceptions::{PyMemoryError, PyOverflowError, PyTypeError, PyValueError};
use pyo3::prelude::*;
use thurible_core::words::{Alternatives, Named};
use thurible_core::{PlanError, ProblemError};

/// The refusal of an argument's value.
pub fn refused(field: &str, why: impl Display) -> PyErr {
    PyValueError::new_err(format!("{field} {why}"))
}

/// An argument as a `V`, which `wanted` describes.
pub fn read<'a, 'py, V: FromPyObject<'a, 'py>>(
    field: &str,
    value: &'a Bound<'py, PyAny>,
    wanted: &str,
) -> PyResult<V> {
    value.extract().map_err(|error: V::Error| {
        let error: PyErr = error.into();
        let given = value
            .repr()
            .map_or_else(|_| "something".into(), |text| shortened(&text.to_string()));
        let sentence = format!("{field} is {given}, but must be {wanted}; change it to that");
        if error.is_instance_of::<PyOverflowError>(value.py()) {
            PyValueError::new_err(sentence)
        } else {
            PyTypeError::new_err(sentence)
        }
    })
}

/// The most characters of a value that a refusal shows.
const SHOWN: usize = 60;

/// The beginning of what a value is written as: of an array that would be all its numbers.
fn shortened(text: &str) -> String {
    let mut line = text.split_whitespace().collect::<Vec<_>>().join(" ");
    if let Some((end, _)) = line.char_indices().nth(SHOWN) {
        line.truncate(end);
        line.push_str(" ..");
    }
    line
}

/// A whole number from 0.
pub fn whole(field: &str, value: &Bound<'_, PyAny>) -> PyResult<usize> {
    read(field, value, "a whole number from 0")
}

/// The same, or `None` where there is none.
pub fn whole_if_any(field: &str, value: Option<&Bound<'_, PyAny>>) -> PyResult<Option<usize>> {
    value.map(|value| whole(field, value)).transpose()
}

/// A number.
pub fn number(field: &str, value: &Bound<'_, PyAny>) -> PyResult<f64> {
    read(field, value, "a number")
}

/// A number that is positive and finite.
pub fn positive(field: &str, value: &Bound<'_, PyAny>) -> PyResult<f64> {
    let given = number(field, value)?;
    if given > 0.0 && given.is_finite() {
        Ok(given)
    } else {
        Err(refused(
            field,
            format!("is {given}; it must be positive and finite; change it to that"),
        ))
    }
}

/// A truth value.
pub fn flag(field: &str, value: &Bound<'_, PyAny>) -> PyResult<bool> {
    read(field, value, "True or False")
}

/// Whether it is `None` or the word `"auto"`.
pub fn is_automatic(value: &Bound<'_, PyAny>) -> bool {
    value.is_none() || value.extract::<&str>().is_ok_and(|word| word == "auto")
}

/// `None`, or a whole number from 0; the word `"auto"` is `None` too.
pub fn automatic(field: &str, value: &Bound<'_, PyAny>) -> PyResult<Option<usize>> {
    if is_automatic(value) {
        return Ok(None);
    }
    read(field, value, "None, \"auto\" or a whole number from 0").map(Some)
}

/// The choice that a word stands for.
pub fn word<V: Named>(field: &str, value: &Bound<'_, PyAny>) -> PyResult<V> {
    let word = one_of(field, value, V::WORDS)?;
    V::from_name(word).map_err(|known| refused(field, format!("must be {known}")))
}

/// The word among `words` that is given.
pub fn one_of(field: &str, value: &Bound<'_, PyAny>, words: &[&'static str]) -> PyResult<&'static str> {
    let known = Alternatives(words);
    let given: String = read(field, value, &known.to_string())?;
    let found = words.iter().copied().find(|word| *word == given);
    found.ok_or_else(|| {
        refused(
            field,
            format!("is \"{given}\", but must be {known}; change it to that"),
        )
    })
}

/// The refusal of a name that is not known.
pub fn unknown(what: &str, given: &str, known: &[&str]) -> PyErr {
    PyTypeError::new_err(format!(
        "there is no {what} {given}; there are {}; correct its name or take it out",
        known.join(", ")
    ))
}

/// The refusal of a plan.
pub fn plan_refused(error: PlanError) -> PyErr {
    match error {
        PlanError::TooLarge => PyMemoryError::new_err(error.to_string()),
        // Their words have the remedy.
        PlanError::Problem(
            ProblemError::Unfit { .. }
            | ProblemError::MassLeaves
            | ProblemError::MassUnknown { .. }
            | ProblemError::SolidScheme,
        ) => PyValueError::new_err(error.to_string().replace("= false", "= False")),
        // The core's words for arguments that Python spells otherwise.
        other => PyValueError::new_err(format!(
            "{}; change it to that",
            other.to_string().replace("ion.tolerance", "ion_tolerance")
        )),
    }
}

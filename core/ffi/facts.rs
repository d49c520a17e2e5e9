//! What a method reported of the last iteration, one fact after the other.

use crate::instance::{self, Body, Thurible};
use crate::pointer::{array, required};
use crate::result::ThuribleResult;
use crate::text::{THURIBLE_NAME_BYTES, THURIBLE_WORDS_BYTES, put_text};
use core::ffi::{c_char, c_void};
use thurible_core::{Fact, Kind};

/// What the values of a fact are.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ThuribleFactKind {
    /// A number.
    Number = 0,
    /// A whole number from 0.
    Count = 1,
    /// 1 for yes, 0 for no.
    Flag = 2,
    /// Any number of numbers, in order.
    Series = 3,
}

impl From<Kind> for ThuribleFactKind {
    fn from(kind: Kind) -> Self {
        match kind {
            Kind::Number => Self::Number,
            Kind::Count => Self::Count,
            Kind::Flag => Self::Flag,
            Kind::Series => Self::Series,
        }
    }
}

/// Something that the method of an instance reported of its last iteration.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct ThuribleFact {
    /// Its name, lower case with underscores, as reports have it.
    pub name: [c_char; THURIBLE_NAME_BYTES],
    /// What it is, in a few words.
    pub words: [c_char; THURIBLE_WORDS_BYTES],
    /// What its values are.
    pub kind: ThuribleFactKind,
    /// How many values it has: 1, but for a series.
    pub values: usize,
}

/// Fact `index` of the last iteration with its values.
fn at(body: &Body, index: usize) -> Result<(Fact, &[f64]), ThuribleResult> {
    body.report.iter().nth(index).ok_or(ThuribleResult::Index)
}

/// How many facts the method reported of the last iteration, those that `thurible_progress` has fields for among them; 0 before the
/// first and after `thurible_restore`.
///
/// # Safety
/// `instance` as in `thurible_close`; `count` is null or may be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thurible_fact_count(instance: *const Thurible, count: *mut usize) -> ThuribleResult {
    // SAFETY: the caller's promises.
    unsafe {
        instance::enter(instance, |body| {
            required(count)?;
            count.write(body.report.iter().count());
            Ok(())
        })
    }
}

/// Says what fact `index` is, from 0 on.
///
/// # Safety
/// `instance` as in `thurible_close`; `fact` is null or may be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thurible_fact(
    instance: *const Thurible,
    index: usize,
    fact: *mut ThuribleFact,
) -> ThuribleResult {
    // SAFETY: the caller's promises.
    unsafe {
        instance::enter(instance, |body| {
            required(fact)?;
            let (found, values) = at(body, index)?;
            let mut said = ThuribleFact {
                name: [0; _],
                words: [0; _],
                kind: found.kind.into(),
                values: values.len(),
            };
            put_text(&mut said.name, found.name);
            put_text(&mut said.words, found.words);
            fact.write(said);
            Ok(())
        })
    }
}

/// Copies all values of fact `index` into `values` of exactly `bytes` bytes, which is 8 for each of them.
///
/// # Safety
/// `instance` as in `thurible_close`; `values` is null or points to `bytes` bytes to write.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thurible_fact_values(
    instance: *const Thurible,
    index: usize,
    values: *mut f64,
    bytes: usize,
) -> ThuribleResult {
    // SAFETY: the caller's promises.
    unsafe {
        instance::enter(instance, |body| {
            let (_, found) = at(body, index)?;
            let values = array::<f64>(values.cast::<c_void>(), bytes, found.len())?;
            values
                .iter_mut()
                .zip(found)
                .for_each(|(value, &found)| *value = found);
            Ok(())
        })
    }
}

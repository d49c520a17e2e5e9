//! Checks of single values, each with its sentence: where, what was found, what is allowed.

use crate::exit::Failure;
use crate::scene::document::Document;
use core::fmt::Display;
use core::ops::RangeInclusive;
use thurible_core::choices::Numbers;
use thurible_core::words::{Named, one_of};
use toml::Value;

/// Weights, of forces in units of dt and length, within which single precision keeps its digits.
pub(super) const WEIGHTS: RangeInclusive<f64> = 1e-15..=1e15;

impl Document {
    /// What stands at `key`, or the sentence for a key that is needed and missing.
    pub(crate) fn required<T>(&self, key: &str, value: Option<T>, remedy: &str) -> Result<T, Failure> {
        value.ok_or_else(|| {
            Failure::Input(format!(
                "{}: `{key}` is missing and has no default; {remedy}",
                self.place(key)
            ))
        })
    }

    /// A whole number in `allowed`.
    pub(crate) fn whole(
        &self,
        key: &str,
        found: i64,
        allowed: RangeInclusive<usize>,
    ) -> Result<usize, Failure> {
        match usize::try_from(found) {
            Ok(number) if allowed.contains(&number) => Ok(number),
            _ => Err(self.not_whole(key, found, &allowed)),
        }
    }

    /// As [`Self::whole`], of a value that may be anything.
    pub(crate) fn whole_value(
        &self,
        key: &str,
        found: &Value,
        allowed: RangeInclusive<usize>,
    ) -> Result<usize, Failure> {
        match found {
            Value::Integer(number) => self.whole(key, *number, allowed),
            other => Err(self.not_whole(key, shown(other), &allowed)),
        }
    }

    /// The step of a keyframe, or of one of a sequence, among those that are allowed.
    pub(super) fn step_of_keyframe(
        &self,
        key: &str,
        found: &Value,
        allowed: &RangeInclusive<usize>,
    ) -> Result<usize, Failure> {
        if *found == Value::Integer(1) && !allowed.contains(&1) {
            let why = format!(
                "is 1, but only a whole number from 2 to {} is allowed: the initial velocity alone decides what is there at step 1, \
                 before any force can act; begin at 2",
                allowed.end()
            );
            return Err(self.refuse(key, why));
        }
        self.whole_value(key, found, allowed.clone())
    }

    /// The refusal of what is no whole number in `allowed`.
    fn not_whole(&self, key: &str, found: impl Display, allowed: &RangeInclusive<usize>) -> Failure {
        let (least, most) = (allowed.start(), allowed.end());
        self.outside(key, found, format_args!("a whole number from {least} to {most}"))
    }

    /// A number among those allowed.
    pub(crate) fn number(&self, key: &str, found: f64, allowed: Numbers) -> Result<f64, Failure> {
        if allowed.allow(found) {
            return Ok(found);
        }
        Err(self.outside(key, format_args!("{found:?}"), allowed))
    }

    /// A positive number, of a value that may be anything.
    pub(super) fn positive_value(&self, key: &str, found: &Value) -> Result<f64, Failure> {
        match found {
            Value::Float(number) => self.number(key, *number, Numbers::Positive),
            Value::Integer(number) => self.number(key, *number as f64, Numbers::Positive),
            other => Err(self.outside(key, shown(other), Numbers::Positive)),
        }
    }

    /// A positive number that multiplies a part of the objective, of a value that may be anything.
    pub(super) fn weight_value(&self, key: &str, found: &Value) -> Result<f64, Failure> {
        let weight = self.positive_value(key, found)?;
        if WEIGHTS.contains(&weight) {
            return Ok(weight);
        }
        let (least, most) = (WEIGHTS.start(), WEIGHTS.end());
        let wanted = format_args!("a number from {least:e} to {most:e}");
        Err(self.outside(key, format_args!("{weight:?}"), wanted))
    }

    /// A list of so many finite numbers; one may stand alone.
    pub(super) fn numbers(
        &self,
        key: &str,
        found: &Value,
        count: usize,
        example: &str,
    ) -> Result<Vec<f64>, Failure> {
        let number = |value: &Value| match value {
            Value::Float(number) => Some(*number),
            Value::Integer(number) => Some(*number as f64),
            _ => None,
        };
        let numbers = match found {
            Value::Array(values) if values.len() == count => values.iter().map(number).collect(),
            one if count == 1 => number(one).map(|number| vec![number]),
            _ => None,
        };
        let finite = numbers.filter(|numbers: &Vec<f64>| numbers.iter().all(|number| number.is_finite()));
        finite.ok_or_else(|| {
            let wanted = if count == 1 {
                "a finite number".into()
            } else {
                format!("a list of {count} finite numbers")
            };
            self.outside(key, shown(found), format_args!("{wanted}, as in {example},"))
        })
    }

    /// The choice that the word `found` stands for.
    pub(crate) fn word<T: Named>(&self, key: &str, found: &str) -> Result<T, Failure> {
        self.one_of(key, found, T::ALL)
    }

    /// As [`Self::word`], where only `choices` are allowed.
    pub(crate) fn one_of<T: Named>(&self, key: &str, found: &str, choices: &[T]) -> Result<T, Failure> {
        one_of(choices, found).map_err(|unknown| self.outside(key, format!("\"{found}\""), unknown))
    }

    /// The refusal of a value outside what is allowed.
    pub(crate) fn outside(&self, key: &str, found: impl Display, allowed: impl Display) -> Failure {
        self.refuse(
            key,
            format!("is {found}, but only {allowed} is allowed; change it to that"),
        )
    }
}

/// A TOML value as a short text for messages.
pub(crate) fn shown(value: &Value) -> String {
    match value {
        Value::Table(_) => "a table".into(),
        Value::Array(items) => format!("a list of {}", items.len()),
        other => other.to_string(),
    }
}

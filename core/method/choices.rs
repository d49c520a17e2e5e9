//! What can be chosen for a method, said once: a table of names, words and ranges beside its parameters. Scenes, Python, the C
//! configuration and the scene that `thurible new` writes go over the tables; none of them names a choice.

use super::refusal::{PlanError, count};
use crate::problem::{ProblemError, not_negative, positive};
use crate::words::{Alternatives, Named};
use core::fmt;

/// One choice: a line of the table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Choice {
    /// Its name: lower case, with underscores.
    pub name: &'static str,
    /// Its name after that of its table, as refusals have it: `direct.history`.
    pub field: &'static str,
    /// What it is, in a few words.
    pub words: &'static str,
    /// What can be chosen.
    pub kind: Kind,
}

/// What can be chosen. Shown, it says so: `a whole number from 1 to 8`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kind {
    /// A number.
    Number(Numbers),
    /// A whole number from 1 to this one.
    Count(usize),
    /// The same, or none, where the solver chooses.
    Automatic(usize),
    /// Yes or no.
    Flag,
    /// One of these words.
    Word(&'static [&'static str]),
}

/// Numbers that can be chosen. Shown, they say which.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Numbers {
    /// Finite ones.
    Finite,
    /// Finite ones above 0.
    Positive,
    /// Finite ones from 0.
    NotNegative,
    /// Those from 0 up to but not 1.
    Fraction,
    /// Those above 0 and below this one in a scene. The solver takes all above 0: a program may ask for a tolerance so large that one
    /// iteration is enough.
    Below(f64),
    /// Those above 0 and below this one, for the solver too: beyond it nothing is found, or what there is to do has no bound.
    Within(f64),
    /// Those from 0 up to this one.
    UpTo(f64),
}

/// What is chosen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Value<'a> {
    /// For [`Kind::Number`].
    Number(f64),
    /// For [`Kind::Count`] and [`Kind::Automatic`].
    Count(usize),
    /// For [`Kind::Automatic`]: the solver chooses.
    Automatic,
    /// For [`Kind::Flag`].
    Flag(bool),
    /// For [`Kind::Word`].
    Word(&'a str),
}

/// Parameters with a table. A choice is known by its place there.
pub trait Choices {
    /// Name of the table: that of the method; another one where the choices concern several methods.
    fn group(&self) -> &'static str;

    /// The table.
    fn table(&self) -> &'static [Choice];

    /// What is chosen at place `index` of the table, if there is one.
    fn get(&self, index: usize) -> Option<Value<'static>>;

    /// Chooses at place `index`, in any range; whether there is such a place and `value` is of its kind and one of its words.
    #[must_use]
    fn set(&mut self, index: usize, value: Value<'_>) -> bool;

    /// Checks every number.
    ///
    /// # Errors
    /// [`PlanError`] names the first that is wrong.
    fn check(&self) -> Result<(), PlanError> {
        let table = self.table().iter().enumerate();
        for (choice, value) in table.filter_map(|(index, choice)| Some((choice, self.get(index)?))) {
            match (choice.kind, value) {
                (Kind::Number(numbers), Value::Number(given)) => numbers.check(choice.field, given)?,
                (Kind::Count(most) | Kind::Automatic(most), Value::Count(given)) => {
                    count(choice.field, given, most)?;
                }
                _ => {}
            }
        }
        Ok(())
    }
}

impl Numbers {
    /// Whether a scene may say `number`.
    #[must_use]
    pub fn allow(self, number: f64) -> bool {
        match self {
            Self::Finite => number.is_finite(),
            Self::Positive => number.is_finite() && number > 0.0,
            Self::NotNegative => number.is_finite() && number >= 0.0,
            Self::Fraction => (0.0..1.0).contains(&number),
            Self::Below(limit) | Self::Within(limit) => number > 0.0 && number < limit,
            Self::UpTo(most) => (0.0..=most).contains(&number),
        }
    }

    /// Refuses a number that the solver cannot take.
    fn check(self, field: &'static str, given: f64) -> Result<(), ProblemError> {
        match self {
            Self::Positive | Self::Below(_) => positive(field, given),
            Self::NotNegative => not_negative(field, given),
            _ if self.allow(given) => Ok(()),
            Self::Fraction => Err(ProblemError::NotFraction { field, given }),
            Self::Finite => Err(ProblemError::NotFinite { field, given }),
            Self::Within(limit) => Err(ProblemError::NotWithin { field, given, limit }),
            Self::UpTo(most) => Err(ProblemError::NotUpTo { field, given, most }),
        }
    }
}

impl fmt::Display for Numbers {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Finite => write!(f, "a finite number"),
            Self::Positive => write!(f, "a finite number above 0"),
            Self::NotNegative => write!(f, "a finite number from 0"),
            Self::Fraction => write!(f, "a number from 0 up to but not 1"),
            Self::Below(limit) | Self::Within(limit) => write!(f, "a number above 0 and below {limit}"),
            Self::UpTo(most) => write!(f, "a number from 0 to {most}"),
        }
    }
}

impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Number(numbers) => numbers.fmt(f),
            Self::Count(most) => write!(f, "a whole number from 1 to {most}"),
            Self::Automatic(most) => write!(f, "\"auto\" or a whole number from 1 to {most}"),
            Self::Flag => write!(f, "true or false"),
            Self::Word(words) => Alternatives(words).fmt(f),
        }
    }
}

/// A field that holds a choice.
pub(crate) trait Field {
    /// What it holds.
    fn value(&self) -> Value<'static>;

    /// Takes `value` if that is of its kind; whether it is.
    fn take(&mut self, value: Value<'_>) -> bool;
}

impl Field for f64 {
    fn value(&self) -> Value<'static> {
        Value::Number(*self)
    }

    fn take(&mut self, value: Value<'_>) -> bool {
        let Value::Number(number) = value else {
            return false;
        };
        *self = number;
        true
    }
}

impl Field for usize {
    fn value(&self) -> Value<'static> {
        Value::Count(*self)
    }

    fn take(&mut self, value: Value<'_>) -> bool {
        let Value::Count(count) = value else {
            return false;
        };
        *self = count;
        true
    }
}

impl Field for Option<usize> {
    fn value(&self) -> Value<'static> {
        self.map_or(Value::Automatic, Value::Count)
    }

    fn take(&mut self, value: Value<'_>) -> bool {
        *self = match value {
            Value::Automatic => None,
            Value::Count(count) => Some(count),
            _ => return false,
        };
        true
    }
}

impl Field for bool {
    fn value(&self) -> Value<'static> {
        Value::Flag(*self)
    }

    fn take(&mut self, value: Value<'_>) -> bool {
        let Value::Flag(flag) = value else {
            return false;
        };
        *self = flag;
        true
    }
}

impl<T: Named> Field for T {
    fn value(&self) -> Value<'static> {
        Value::Word(self.name())
    }

    fn take(&mut self, value: Value<'_>) -> bool {
        let Value::Word(word) = value else {
            return false;
        };
        let chosen = T::from_name(word);
        chosen.map(|chosen| *self = chosen).is_ok()
    }
}

/// Implements [`Choices`] for parameters: the name of the table, and for each choice its name, the field that holds it, its kind and
/// its words.
macro_rules! choices {
    ($params:ty, $group:literal {
        $($name:ident: $($field:ident).+, $kind:expr, $words:literal;)*
    }) => {
        impl $crate::method::choices::Choices for $params {
            fn group(&self) -> &'static str {
                $group
            }

            fn table(&self) -> &'static [$crate::method::choices::Choice] {
                const TABLE: &[$crate::method::choices::Choice] = &[$(
                    $crate::method::choices::Choice {
                        name: stringify!($name),
                        field: concat!($group, ".", stringify!($name)),
                        words: $words,
                        kind: $kind,
                    }
                ),*];
                TABLE
            }

            fn get(&self, index: usize) -> Option<$crate::method::choices::Value<'static>> {
                let fields: &[&dyn $crate::method::choices::Field] = &[$(&self.$($field).+),*];
                fields.get(index).map(|field| field.value())
            }

            fn set(&mut self, index: usize, value: $crate::method::choices::Value<'_>) -> bool {
                let fields: [&mut dyn $crate::method::choices::Field; _] = [$(&mut self.$($field).+),*];
                fields.into_iter().nth(index).is_some_and(|field| field.take(value))
            }
        }
    };
}

pub(crate) use choices;

/// Choices of a method that leaves nothing to choose.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct NoChoices;

choices!(NoChoices, "nothing" {});

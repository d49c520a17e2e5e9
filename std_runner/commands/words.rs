//! Arguments that are one of some words, which shells complete.

use clap::builder::{PossibleValue, StringValueParser, TypedValueParser};
use clap::{Arg, Command, Error};
use std::ffi::OsStr;
use thurible_core::Named;

/// A text; `words` are what shells propose, and who reads it says what is wrong with another.
#[derive(Clone, Debug)]
pub(crate) struct Words(pub Vec<&'static str>);

/// A value by its word.
#[derive(Clone, Debug)]
pub(crate) struct OneOf<T>(core::marker::PhantomData<T>);

impl<T> OneOf<T> {
    /// Of all that there are.
    pub fn all() -> Self {
        Self(core::marker::PhantomData)
    }
}

fn proposed<'a>(words: &'a [&'static str]) -> Option<Box<dyn Iterator<Item = PossibleValue> + 'a>> {
    Some(Box::new(words.iter().copied().map(PossibleValue::new)))
}

impl TypedValueParser for Words {
    type Value = String;

    fn parse_ref(&self, command: &Command, argument: Option<&Arg>, value: &OsStr) -> Result<String, Error> {
        StringValueParser::new().parse_ref(command, argument, value)
    }

    fn possible_values(&self) -> Option<Box<dyn Iterator<Item = PossibleValue> + '_>> {
        proposed(&self.0)
    }
}

impl<T: Named + Send + Sync> TypedValueParser for OneOf<T> {
    type Value = T;

    fn parse_ref(&self, command: &Command, argument: Option<&Arg>, value: &OsStr) -> Result<T, Error> {
        let read = |text: &str| {
            T::from_name(text).map_err(|allowed| format!("found \"{text}\", allowed is {allowed}"))
        };
        read.parse_ref(command, argument, value)
    }

    fn possible_values(&self) -> Option<Box<dyn Iterator<Item = PossibleValue> + '_>> {
        proposed(T::WORDS)
    }
}

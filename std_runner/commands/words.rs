//! Arguments that are one of some words, which shells complete.

use clap::builder::{PossibleValue, StringValueParser, TypedValueParser};
use clap::{Arg, Command, Error};
use std::ffi::OsStr;
use thurible_core::Named;

/// A text; the words are what shells propose, and who reads it says what is wrong with another.
#[derive(Clone, Debug)]
pub(crate) struct Words(pub Vec<&'static str>);

impl TypedValueParser for Words {
    type Value = String;

    fn parse_ref(&self, command: &Command, argument: Option<&Arg>, value: &OsStr) -> Result<String, Error> {
        StringValueParser::new().parse_ref(command, argument, value)
    }

    fn possible_values(&self) -> Option<Box<dyn Iterator<Item = PossibleValue> + '_>> {
        Some(Box::new(self.0.iter().copied().map(PossibleValue::new)))
    }
}

/// A value by its word.
pub(crate) fn one_of<T: Named + Send + Sync>() -> impl TypedValueParser<Value = T> {
    Words(T::WORDS.to_vec()).try_map(|text| {
        T::from_name(&text).map_err(|allowed| format!("found \"{text}\", allowed is {allowed}"))
    })
}

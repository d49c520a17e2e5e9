//! Fields of the configuration that hold choices of methods, filled and read by the tables of the core.

use super::ConfigError;
use super::choices::{flag, wide};
use thurible_core::choices::{Choices, Kind, Value};

/// What a number of the configuration holds to leave the choice to the library.
pub const THURIBLE_AUTOMATIC: u32 = u32::MAX;

/// A field that holds a choice.
pub struct Held<'a> {
    /// Its name.
    pub field: &'static str,
    /// What the core calls the choice.
    pub choice: &'static str,
    /// Where it lies.
    pub slot: Slot<'a>,
}

/// Where a choice lies.
pub enum Slot<'a> {
    /// A number.
    Number(&'a mut f64),
    /// Anything else: a count, 0 or 1, the place of a word.
    Code(&'a mut u32),
}

impl<'a> From<&'a mut f64> for Slot<'a> {
    fn from(number: &'a mut f64) -> Self {
        Self::Number(number)
    }
}

impl<'a> From<&'a mut u32> for Slot<'a> {
    fn from(code: &'a mut u32) -> Self {
        Self::Code(code)
    }
}

impl Held<'_> {
    /// Writes what is chosen at place `index` of a table.
    pub fn write(self, choices: &dyn Choices, index: usize) {
        let kind = choices.table().get(index).map(|choice| choice.kind);
        match (self.slot, choices.get(index)) {
            (Slot::Number(slot), Some(Value::Number(number))) => *slot = number,
            (Slot::Code(slot), Some(value)) => *slot = code(value, kind),
            _ => {}
        }
    }

    /// Chooses at place `index` of a table what it holds.
    ///
    /// # Errors
    /// [`ConfigError::Code`].
    pub fn read(self, choices: &mut dyn Choices, index: usize) -> Result<(), ConfigError> {
        let kind = choices.table().get(index).map(|choice| choice.kind);
        let value = kind.and_then(|kind| self.slot.value(kind));
        if value.is_some_and(|value| choices.set(index, value)) {
            Ok(())
        } else {
            self.unknown()
        }
    }

    /// Refuses a code that stands for nothing.
    ///
    /// # Errors
    /// [`ConfigError::Code`].
    pub fn unknown(self) -> Result<(), ConfigError> {
        match self.slot {
            Slot::Code(&mut given) => Err(ConfigError::Code {
                field: self.field,
                given,
            }),
            Slot::Number(_) => Ok(()),
        }
    }
}

/// The place of a choice in a table.
fn place(choices: &dyn Choices, name: &str) -> Option<usize> {
    choices.table().iter().position(|choice| choice.name == name)
}

/// Writes what is chosen to the fields that hold it.
pub fn put_choices<'a>(fields: impl IntoIterator<Item = Held<'a>>, choices: &dyn Choices) {
    for held in fields {
        if let Some(index) = place(choices, held.choice) {
            held.write(choices, index);
        }
    }
}

/// Chooses what the fields hold.
///
/// # Errors
/// [`ConfigError::Code`].
pub fn take_choices<'a>(
    fields: impl IntoIterator<Item = Held<'a>>,
    choices: &mut dyn Choices,
) -> Result<(), ConfigError> {
    for held in fields {
        match place(choices, held.choice) {
            Some(index) => held.read(choices, index)?,
            None => held.unknown()?,
        }
    }
    Ok(())
}

impl Slot<'_> {
    /// What lies there, where something of this kind is chosen.
    fn value(&self, kind: Kind) -> Option<Value<'static>> {
        match (self, kind) {
            (Self::Number(number), _) => Some(Value::Number(**number)),
            (Self::Code(code), Kind::Automatic(_)) if **code == THURIBLE_AUTOMATIC => Some(Value::Automatic),
            (Self::Code(code), Kind::Count(_) | Kind::Automatic(_)) => Some(Value::Count(wide(**code))),
            (Self::Code(code), Kind::Flag) => flag(**code).map(Value::Flag),
            (Self::Code(code), Kind::Word(words)) => words.get(wide(**code)).copied().map(Value::Word),
            (Self::Code(_), Kind::Number(_)) => None,
        }
    }
}

/// A choice of `kind` that is no number, as C gives it.
fn code(value: Value<'_>, kind: Option<Kind>) -> u32 {
    let place = match (value, kind) {
        (Value::Count(count), _) => Some(count),
        (Value::Flag(flag), _) => Some(flag.into()),
        (Value::Word(word), Some(Kind::Word(words))) => words.iter().position(|known| *known == word),
        _ => None,
    };
    place
        .and_then(|place| place.try_into().ok())
        .unwrap_or(THURIBLE_AUTOMATIC)
}

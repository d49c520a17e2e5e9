//! The words that stand for choices and outcomes in scenes, reports, Python and on the command line: each is spelled here, beside
//! its enum, and nowhere else.

use core::fmt;

/// An enum whose every value has a word.
pub trait Named: Copy + PartialEq + fmt::Debug + 'static {
    /// Every value, the default first where there is one.
    const ALL: &'static [Self];
    /// Their words, in the same order.
    const WORDS: &'static [&'static str];

    /// Its word: lower case, with underscores.
    fn name(self) -> &'static str;

    /// The value that `word` stands for.
    ///
    /// # Errors
    /// Where no value has that word: the error lists the words that there are.
    fn from_name(word: &str) -> Result<Self, UnknownWord<'static, Self>> {
        one_of(Self::ALL, word)
    }
}

/// The value among `allowed` that `word` stands for, where not all values of an enum are.
///
/// # Errors
/// Where none of them has that word.
pub fn one_of<'a, T: Named>(allowed: &'a [T], word: &str) -> Result<T, UnknownWord<'a, T>> {
    let found = allowed.iter().find(|value| value.name() == word);
    found.copied().ok_or(UnknownWord { allowed })
}

/// A word that stands for nothing. Shown, it is the list of those allowed: `"wall" or "periodic"`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct UnknownWord<'a, T> {
    /// The values that are allowed there.
    pub allowed: &'a [T],
}

impl<T: Named> fmt::Display for UnknownWord<'_, T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        alternatives(f, self.allowed.iter().map(|value| value.name()))
    }
}

/// `"wall" or "periodic"`.
fn alternatives<'a>(f: &mut fmt::Formatter<'_>, words: impl Iterator<Item = &'a str>) -> fmt::Result {
    for (index, word) in words.enumerate() {
        let or = if index == 0 { "" } else { " or " };
        write!(f, "{or}\"{word}\"")?;
    }
    Ok(())
}

impl<T: Named> core::error::Error for UnknownWord<'_, T> {}

/// Words of which one is meant. Shown: `"wall" or "periodic"`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Alternatives<'a>(pub &'a [&'a str]);

impl fmt::Display for Alternatives<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        alternatives(f, self.0.iter().copied())
    }
}

/// Implements [`Named`]; a value that is left out or out of order does not compile.
macro_rules! named {
    ($kind:ident { $($value:ident = $word:literal),+ $(,)? }) => {
        impl $crate::words::Named for $kind {
            const ALL: &'static [Self] = &[$(Self::$value),+];
            const WORDS: &'static [&'static str] = &[$($word),+];

            fn name(self) -> &'static str {
                match self {
                    $(Self::$value => $word),+
                }
            }
        }

        // The C interface numbers values by their places.
        const _: () = {
            let mut place = 0;
            $(
                assert!($kind::$value as usize == place);
                place += 1;
            )+
            assert!(place > 0);
        };
    };
}

pub(crate) use named;

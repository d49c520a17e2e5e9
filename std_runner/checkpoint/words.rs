//! What the runner has to remember of a solve, as words of 8 bytes: one list serves for writing and for reading, so that the two cannot
//! drift apart.

use thurible_core::Named;
use thurible_core::checkpoint::Damaged;

/// Most bytes of a name.
const NAME: usize = 256;

/// More than there are names of phases and facts in any solve.
const NAMES: usize = 256;

/// Above any count of a solve. What adds a few of them cannot overflow, whatever a file says.
pub(super) const MANY: u64 = 1 << 48;

/// Passes over what is remembered, to write it or to read it back.
#[derive(Debug, Default)]
pub(crate) struct Words {
    bytes: Vec<u8>,
    /// Where the next word is read; `None` while they are written.
    at: Option<usize>,
    /// Names that were read, each once.
    names: Vec<&'static str>,
}

impl Words {
    /// Reads back what was written.
    pub fn read(bytes: Vec<u8>) -> Self {
        Self {
            bytes,
            at: Some(0),
            names: Vec::new(),
        }
    }

    /// What was written.
    pub fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// Whether they are read.
    pub fn reads(&self) -> bool {
        self.at.is_some()
    }

    /// The next `count` bytes to read.
    fn next(&mut self, count: usize) -> Result<&[u8], Damaged> {
        let at = self.at.unwrap_or(0);
        let bytes = self.bytes.get(at..).and_then(|rest| rest.get(..count));
        self.at = Some(at + count);
        bytes.ok_or(Damaged)
    }

    /// A word.
    pub fn word(&mut self, value: &mut u64) -> Result<(), Damaged> {
        if !self.reads() {
            self.bytes.extend_from_slice(&value.to_le_bytes());
            return Ok(());
        }
        let (word, _) = self.next(8)?.split_first_chunk().ok_or(Damaged)?;
        *value = u64::from_le_bytes(*word);
        Ok(())
    }

    /// A number, to the bit.
    pub fn real(&mut self, value: &mut f64) -> Result<(), Damaged> {
        let mut bits = value.to_bits();
        self.word(&mut bits)?;
        *value = f64::from_bits(bits);
        Ok(())
    }

    /// A count, up to [`MANY`].
    pub fn count(&mut self, value: &mut usize) -> Result<(), Damaged> {
        let mut word = *value as u64;
        self.word(&mut word)?;
        let count = usize::try_from(word).ok().filter(|_| word <= MANY);
        *value = count.ok_or(Damaged)?;
        Ok(())
    }

    /// Yes or no.
    pub fn flag(&mut self, value: &mut bool) -> Result<(), Damaged> {
        let mut word = u64::from(*value);
        self.word(&mut word)?;
        *value = word == 1;
        if word > 1 { Err(Damaged) } else { Ok(()) }
    }

    /// A choice, by its word.
    pub fn named<T: Named>(&mut self, value: &mut T) -> Result<(), Damaged> {
        let mut name = value.name();
        self.name(&mut name)?;
        *value = T::from_name(name).map_err(|_| Damaged)?;
        Ok(())
    }

    /// A name that lasts as long as the program: the few that there are are kept once each.
    pub fn name(&mut self, value: &mut &'static str) -> Result<(), Damaged> {
        let mut text = String::new();
        if !self.reads() {
            text.push_str(value);
        }
        self.text(&mut text)?;
        if self.reads() {
            let known = self.names.iter().find(|known| **known == text).copied();
            *value = match known {
                Some(name) => name,
                None if self.names.len() == NAMES => return Err(Damaged),
                None => text.leak(),
            };
            if known.is_none() {
                self.names.push(*value);
            }
        }
        Ok(())
    }

    /// A short text.
    pub fn text(&mut self, value: &mut String) -> Result<(), Damaged> {
        let mut length = value.len();
        self.count(&mut length)?;
        if length > NAME {
            return Err(Damaged);
        }
        if !self.reads() {
            self.bytes.extend_from_slice(value.as_bytes());
            return Ok(());
        }
        let bytes = self.next(length)?.to_vec();
        *value = String::from_utf8(bytes).map_err(|_| Damaged)?;
        Ok(())
    }

    /// A value that may be missing.
    pub fn option<V: Default>(
        &mut self,
        value: &mut Option<V>,
        each: impl FnOnce(&mut Self, &mut V) -> Result<(), Damaged>,
    ) -> Result<(), Damaged> {
        let mut there = value.is_some();
        self.flag(&mut there)?;
        if there {
            return each(self, value.get_or_insert_default());
        }
        *value = None;
        Ok(())
    }

    /// A list, of no more values than there are words left for.
    pub fn list<V: Clone>(
        &mut self,
        values: &mut Vec<V>,
        empty: V,
        mut each: impl FnMut(&mut Self, &mut V) -> Result<(), Damaged>,
    ) -> Result<(), Damaged> {
        let mut count = values.len();
        self.count(&mut count)?;
        if self.reads() {
            let left = self.bytes.len() - self.at.unwrap_or(0).min(self.bytes.len());
            if count > left / 8 {
                return Err(Damaged);
            }
            values.clear();
            // One after the other, so that they take no more memory than there is of them in the file.
            return (0..count).try_for_each(|_| {
                let mut value = empty.clone();
                each(self, &mut value)?;
                values.push(value);
                Ok(())
            });
        }
        values.iter_mut().try_for_each(|value| each(self, value))
    }

    /// Numbers.
    pub fn reals(&mut self, values: &mut Vec<f64>) -> Result<(), Damaged> {
        self.list(values, 0.0, Self::real)
    }

    /// Counts.
    pub fn counts(&mut self, values: &mut Vec<usize>) -> Result<(), Damaged> {
        self.list(values, 0, Self::count)
    }

    /// That nothing is left to read.
    pub fn end(&self) -> Result<(), Damaged> {
        match self.at {
            Some(at) if at != self.bytes.len() => Err(Damaged),
            _ => Ok(()),
        }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use thurible_core::Status;

    type Values = (f64, usize, Option<f64>, Vec<f64>, Status, String);

    fn pass(words: &mut Words, (x, n, some, list, status, text): &mut Values) -> Result<(), Damaged> {
        words.real(x)?;
        words.count(n)?;
        words.option(some, Words::real)?;
        words.reals(list)?;
        words.named(status)?;
        words.text(text)?;
        words.end()
    }

    #[test]
    fn what_was_written_is_read_and_nothing_shorter_or_longer() {
        let mut written = (
            f64::from_bits(0x7FF8_0000_0000_1234),
            7,
            Some(-0.0),
            vec![1.5, f64::INFINITY],
            Status::Stalled,
            "abc".into(),
        );
        let mut words = Words::default();
        pass(&mut words, &mut written).unwrap();
        let fresh = || (0.0, 0, None, Vec::new(), Status::Converged, String::new());
        let mut read = fresh();
        pass(&mut Words::read(words.bytes().to_vec()), &mut read).unwrap();
        assert_eq!(read.0.to_bits(), written.0.to_bits());
        assert_eq!((&read.3, read.4, &read.5), (&written.3, written.4, &written.5));
        for length in 0..words.bytes().len() {
            let short = words.bytes()[..length].to_vec();
            assert_eq!(
                pass(&mut Words::read(short), &mut fresh()),
                Err(Damaged),
                "{length}"
            );
        }
        let longer = [words.bytes(), &[0; 8]].concat();
        assert_eq!(pass(&mut Words::read(longer), &mut fresh()), Err(Damaged));
        for place in 0..words.bytes().len() {
            let mut other = words.bytes().to_vec();
            other[place] ^= 0xFF;
            // It may read something else, but in order.
            let _ = pass(&mut Words::read(other), &mut fresh());
        }
    }

    #[test]
    fn a_list_may_be_all_that_is_left() {
        let mut words = Words::default();
        words.reals(&mut vec![1.0, 2.0]).unwrap();
        let mut read = Vec::new();
        let mut again = Words::read(words.bytes().to_vec());
        again.reals(&mut read).and_then(|()| again.end()).unwrap();
        assert_eq!(read, [1.0, 2.0]);
    }

    /// Each of few names is kept once, however often it stands there; of many the state is damaged.
    #[test]
    fn few_names_are_kept() {
        let written = |names: &[&'static str]| {
            let mut words = Words::default();
            names
                .iter()
                .copied()
                .try_for_each(|mut name| words.name(&mut name))
                .unwrap();
            words.bytes().to_vec()
        };
        let read = |bytes: Vec<u8>, count: usize| {
            let mut words = Words::read(bytes);
            let names: Result<Vec<&'static str>, Damaged> = (0..count)
                .map(|_| {
                    let mut name = "";
                    words.name(&mut name).map(|()| name)
                })
                .collect();
            names
        };
        let often = ["ao", "nso"].repeat(NAMES);
        let names = read(written(&often), often.len()).unwrap();
        assert_eq!(names, often);
        assert!(names.iter().step_by(2).all(|name| core::ptr::eq(*name, names[0])));
        let many: Vec<&'static str> = (0..=NAMES).map(|number| &*number.to_string().leak()).collect();
        assert_eq!(read(written(&many[..NAMES]), NAMES).unwrap(), many[..NAMES]);
        assert_eq!(read(written(&many), many.len()), Err(Damaged));
        let long: &'static str = "x".repeat(NAME).leak();
        assert_eq!(read(written(&[long]), 1).unwrap(), [long]);
        let longer: &'static str = "x".repeat(NAME + 1).leak();
        assert_eq!(Words::default().name(&mut { longer }), Err(Damaged));
    }
}

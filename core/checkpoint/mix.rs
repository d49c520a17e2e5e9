//! Words mixed into one.

/// Words mixed into one. Every step can be undone, so that one changed word always changes the end.
#[derive(Clone, Copy, Debug)]
pub struct Mix([u64; 4]);

impl Default for Mix {
    fn default() -> Self {
        Self::new()
    }
}

impl Mix {
    /// Nothing mixed in yet.
    #[must_use]
    pub fn new() -> Self {
        Self([1, 2, 3, 4])
    }

    fn step(lane: u64, word: u64) -> u64 {
        (lane ^ word).wrapping_mul(0x9E37_79B9_7F4A_7C15).rotate_left(29)
    }

    /// Mixes a word in.
    pub fn word(&mut self, word: u64) {
        let [a, b, c, d] = self.0;
        self.0 = [b, c, d, Self::step(a, word)];
    }

    /// Mixes the bits of a scalar in.
    pub fn real(&mut self, number: f64) {
        self.word(number.to_bits());
    }

    /// Mixes bytes in, four words at a time. The same bytes in other pieces give another word.
    pub fn bytes(&mut self, bytes: &[u8]) {
        let (blocks, rest) = bytes.as_chunks::<32>();
        for block in blocks {
            let (words, _) = block.as_chunks::<8>();
            for (lane, word) in self.0.iter_mut().zip(words) {
                *lane = Self::step(*lane, u64::from_le_bytes(*word));
            }
        }
        let mut last = [0; 32];
        last.iter_mut().zip(rest).for_each(|(to, &from)| *to = from);
        let (words, _) = last.as_chunks::<8>();
        words.iter().for_each(|word| self.word(u64::from_le_bytes(*word)));
        self.word(bytes.len() as u64);
    }

    /// The word that all those before were mixed into.
    #[must_use]
    pub fn finish(self) -> u64 {
        let all = self.0.into_iter().fold(0, Self::step);
        all ^ all >> 32
    }
}

//! Random numbers of a chain, or of noise: SplitMix64 (Steele, Lea & Flood 2014), a stream for each chain of each frame.

use libm::{log, sqrt};

/// Sebastiano Vigna's constants of SplitMix64.
const STEP: u64 = 0x9e37_79b9_7f4a_7c15;
const MIX: [u64; 2] = [0xbf58_476d_1ce4_e5b9, 0x94d0_49bb_1331_11eb];
/// Spreads the numbers of streams over all states.
const STREAM: u64 = 0xd134_2543_de82_ef95;

/// A stream of random numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Random {
    state: u64,
}

impl Random {
    /// The stream of chain `chain` of frame `frame`.
    #[must_use]
    pub fn new(seed: u64, frame: u64, chain: u64) -> Self {
        let number = (frame << 32).wrapping_add(chain).wrapping_add(1);
        let mut random = Self {
            state: seed ^ number.wrapping_mul(STREAM),
        };
        random.bits();
        random
    }

    fn bits(&mut self) -> u64 {
        self.state = self.state.wrapping_add(STEP);
        let mut bits = self.state;
        bits = (bits ^ (bits >> 30)).wrapping_mul(MIX[0]);
        bits = (bits ^ (bits >> 27)).wrapping_mul(MIX[1]);
        bits ^ (bits >> 31)
    }

    /// Uniform in [0, 1): 53 bits.
    #[inline(always)]
    pub fn uniform(&mut self) -> f64 {
        (self.bits() >> 11) as f64 * (1.0 / 9_007_199_254_740_992.0)
    }

    /// A whole number from 0 to `count` - 1.
    #[inline(always)]
    pub fn below(&mut self, count: usize) -> usize {
        ((self.uniform() * count as f64) as usize).min(count.saturating_sub(1))
    }

    /// Standard normal, by Marsaglia's polar method: the first of each pair.
    #[inline(always)]
    pub fn normal(&mut self) -> f64 {
        loop {
            let x = 2.0 * self.uniform() - 1.0;
            let y = 2.0 * self.uniform() - 1.0;
            let square = x * x + y * y;
            if square > 0.0 && square < 1.0 {
                return x * sqrt(-2.0 * log(square) / square);
            }
        }
    }
}

//! Proves that nothing is lost: `thurible-nothing-lost PROGRAM WORK kill N [SEED]`, `damage N [SEED]` and `calls [EVERY]`. PROGRAM is the program
//! `thurible`, WORK a folder that may be filled.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test says what went wrong by panicking"
)]

mod calls;
mod damage;
mod kill;
mod place;
mod scenes;

use place::Place;
use std::path::PathBuf;

/// Numbers that look random and are the same for the same seed: xorshift64*, Vigna 2016.
pub struct Random(u64);

impl Random {
    /// A number from 0 to below `end`.
    pub fn below(&mut self, end: u64) -> u64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        (self.0.wrapping_mul(0x2545_F491_4F6C_DD1D) >> 16) % end.max(1)
    }
}

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [program, work, what, rest @ ..] = arguments.as_slice() else {
        eprintln!(
            "usage: thurible-nothing-lost PROGRAM WORK kill N [SEED] | damage N [SEED] | calls [EVERY]"
        );
        std::process::exit(2);
    };
    let number = |index: usize, or: u64| rest.get(index).map_or(or, |text| text.parse().unwrap());
    let (count, mut random) = (number(0, 100), Random(number(1, 1).max(1)));
    let place = Place::new(
        std::fs::canonicalize(program).unwrap(),
        std::path::absolute(PathBuf::from(work)).unwrap(),
    );
    match what.as_str() {
        "kill" => kill::all(&place, count, &mut random),
        "damage" => damage::all(&place, count, &mut random),
        "calls" => calls::all(&place, number(0, 1)),
        other => panic!("there is no test {other}"),
    }
}

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
#[path = "../fuzz/random.rs"]
mod random;
mod scenes;

use place::Place;
use random::Random;
use std::path::PathBuf;

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [program, work, what, rest @ ..] = arguments.as_slice() else {
        eprintln!(
            "usage: thurible-nothing-lost PROGRAM WORK kill N [SEED] | damage N [SEED] | calls [EVERY]"
        );
        std::process::exit(2);
    };
    let number = |index: usize, or: u64| rest.get(index).map_or(or, |text| text.parse().unwrap());
    let (count, mut random) = (number(0, 100), Random::new(number(1, 1)));
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

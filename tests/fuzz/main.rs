//! `thurible-fuzz WORK RUNS [SEED] [READER ..]`: gives every reader RUNS files that begin as good ones and are changed at random, and prints
//! a table. No input may be met by a panic, take longer than a second, or more memory than 16 times its size and 64 MiB; what breaks that
//! stays in WORK. A reader more is one line of `READERS`.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test says what went wrong by panicking"
)]

mod change;
mod memory;
mod readers;
mod seeds;

use change::{Random, changed};
use core::panic::AssertUnwindSafe;
use core::sync::atomic::{AtomicU64, Ordering};
use core::time::Duration;
use readers::{READERS, Reader};
use std::fs;
use std::panic::catch_unwind;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Most bytes of an input.
const MOST: usize = 1 << 20;
/// Seconds after which an input that is still being read ends the program.
const HANGS: u64 = 20;

/// Seconds that the input has been read, the largest number where none is.
static BEGUN: AtomicU64 = AtomicU64::new(u64::MAX);

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [work, runs, rest @ ..] = arguments.as_slice() else {
        eprintln!("usage: thurible-fuzz WORK RUNS [SEED] [READER ..]");
        std::process::exit(2);
    };
    let work = std::path::absolute(PathBuf::from(work)).unwrap();
    fs::create_dir_all(&work).unwrap();
    let runs: u64 = runs.parse().unwrap();
    let seed = rest.first().and_then(|seed| seed.parse().ok()).unwrap_or(1);
    let wanted: Vec<&String> = rest.iter().filter(|text| text.parse::<u64>().is_err()).collect();
    watch_for_hangs();
    // What is printed of a panic is printed once, below.
    std::panic::set_hook(Box::new(|_| {}));
    println!("| reader | runs | accepted | refused | slowest | most memory beside the input |");
    println!("|---|---|---|---|---|---|");
    let mut broken = 0;
    for reader in READERS
        .iter()
        .filter(|reader| wanted.is_empty() || wanted.iter().any(|name| *name == reader.name))
    {
        broken += tried(reader, &work, runs, &mut Random::new(seed));
    }
    if broken > 0 {
        eprintln!("{broken} inputs broke a promise; they are in {}", work.display());
        std::process::exit(1);
    }
}

/// Ends the program where an input hangs.
fn watch_for_hangs() {
    let start = Instant::now();
    std::thread::spawn(move || {
        loop {
            std::thread::sleep(Duration::from_secs(1));
            BEGUN
                .fetch_update(Ordering::SeqCst, Ordering::SeqCst, |seconds| {
                    // Counted up, so that no clock is asked for every input.
                    (seconds != u64::MAX).then_some(seconds + 1)
                })
                .ok();
            if (HANGS..u64::MAX).contains(&BEGUN.load(Ordering::SeqCst)) {
                eprintln!(
                    "an input hangs: it is in the folder of work ({:?} after the start)",
                    start.elapsed()
                );
                std::process::exit(1);
            }
        }
    });
}

/// What one reader makes of many inputs; how many broke a promise.
fn tried(reader: &Reader, work: &Path, runs: u64, random: &mut Random) -> u64 {
    // What goes wrong with the good inputs is the test's own fault, and is to be read.
    let silent = std::panic::take_hook();
    let seeds = (reader.seeds)(work);
    std::panic::set_hook(silent);
    let runs = runs / reader.dear;
    let path = work.join(reader.file);
    let (mut accepted, mut refused, mut broken) = (0, 0, 0);
    let (mut slowest, mut most) = (Duration::ZERO, 0);
    for number in 0..runs + seeds.len() as u64 {
        let whole = usize::try_from(number).ok().and_then(|index| seeds.get(index));
        let mut bytes = match whole {
            Some(seed) => seed.clone(),
            None => changed(&seeds, reader.is_text, random),
        };
        bytes.truncate(MOST);
        if whole.is_none() {
            (reader.mend)(&mut bytes, random);
        }
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(&path, &bytes).unwrap();
        let before = memory::begin();
        BEGUN.store(0, Ordering::SeqCst);
        let begun = Instant::now();
        let read = catch_unwind(AssertUnwindSafe(|| (reader.read)(&path, &bytes)));
        let (took, took_memory) = (begun.elapsed(), memory::most_since(before));
        BEGUN.store(u64::MAX, Ordering::SeqCst);
        slowest = slowest.max(took);
        most = most.max(took_memory.saturating_sub(16 * bytes.len()));
        let why = match read {
            Ok(is_good) => {
                if !is_good && whole.is_some() {
                    eprintln!("{}: input {number} is good and was refused", reader.name);
                    std::process::exit(1);
                }
                accepted += u64::from(is_good);
                refused += u64::from(!is_good);
                if took > Duration::from_secs(1) {
                    Some(format!("took {took:?}"))
                } else if took_memory > 16 * bytes.len() + (64 << 20) {
                    Some(format!("took {took_memory} bytes"))
                } else {
                    None
                }
            }
            Err(panic) => Some(format!("panicked: {}", words(&*panic))),
        };
        if let Some(why) = why {
            broken += 1;
            let kept = work.join(format!(
                "{}_{number}.{}",
                reader.name,
                path.extension().unwrap().display()
            ));
            fs::write(&kept, &bytes).unwrap();
            eprintln!("{}: {} {why}", reader.name, kept.display());
            assert!(broken < 20, "{}: too many to go on", reader.name);
        }
    }
    println!(
        "| {} | {runs} | {accepted} | {refused} | {:.0} ms | {:.1} MiB |",
        reader.name,
        slowest.as_secs_f64() * 1e3,
        most as f64 / f64::from(1 << 20)
    );
    broken
}

fn words(panic: &(dyn core::any::Any + Send)) -> String {
    let text = panic.downcast_ref::<String>().cloned();
    text.or_else(|| panic.downcast_ref::<&str>().map(|text| (*text).to_owned()))
        .unwrap_or_default()
}

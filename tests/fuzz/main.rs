//! `thurible-fuzz WORK RUNS [SEED] [READER ..]`: gives every reader RUNS files that begin as good ones and are changed at random, and prints
//! a table. No input may be met by a panic, take longer than a second of the processor, or more memory than 16 times its size and 64 MiB; what breaks that
//! stays in WORK. A reader more is one line of `READERS`. `thurible-fuzz solve ..` is the program's command, for the readers' good inputs.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test says what went wrong by panicking"
)]

mod change;
mod memory;
mod place;
mod processor;
mod random;
mod readers;
mod seeds;

use change::changed;
use core::panic::AssertUnwindSafe;
use core::sync::atomic::{AtomicU64, Ordering};
use core::time::Duration;
use place::Place;
use random::Random;
use readers::{READERS, Reader, command};
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
    if arguments.first().is_some_and(|first| first == "solve") {
        let all: Vec<&str> = arguments.iter().map(String::as_str).collect();
        std::process::exit(command(&all).map_or(2, i32::from));
    }
    let [work, runs, rest @ ..] = arguments.as_slice() else {
        eprintln!("usage: thurible-fuzz WORK RUNS [SEED] [READER ..]");
        std::process::exit(2);
    };
    let work = std::path::absolute(PathBuf::from(work)).unwrap();
    fs::create_dir_all(&work).unwrap();
    let runs: u64 = runs.parse().unwrap();
    let seed = rest.first().and_then(|seed| seed.parse().ok()).unwrap_or(1);
    let wanted: Vec<&String> = rest.iter().filter(|text| text.parse::<u64>().is_err()).collect();
    for name in &wanted {
        assert!(
            READERS.iter().any(|reader| reader.name == **name),
            "there is no reader {name}"
        );
    }
    // One thread, which waits for no other; what it calls itself has the room that the first one of a program has.
    let alone = rayon::ThreadPoolBuilder::new()
        .num_threads(1)
        .stack_size(8 << 20)
        .build()
        .unwrap();
    let broken = alone.install(|| all(&work, runs, seed, &wanted));
    if broken > 0 {
        eprintln!("{broken} inputs broke a promise; they are in {}", work.display());
        std::process::exit(1);
    }
}

/// Tries all readers, or those that are wanted; how many inputs broke a promise.
fn all(work: &Path, runs: u64, seed: u64, wanted: &[&String]) -> u64 {
    let place = Place::new(work);
    watch_for_hangs(place.folder.clone());
    // What is printed of a panic is printed once, below.
    std::panic::set_hook(Box::new(|_| {}));
    println!("| reader | runs | accepted | a run | slowest | most memory beside 16 times the input |");
    println!("|---|---|---|---|---|---|");
    let is_wanted = |reader: &&Reader| wanted.is_empty() || wanted.iter().any(|name| *name == reader.name);
    READERS
        .iter()
        .filter(is_wanted)
        .map(|reader| tried(reader, [&place.folder, work], runs, &mut Random::new(seed)))
        .sum()
}

/// Ends the program where an input hangs; it stays in `folder`.
fn watch_for_hangs(folder: PathBuf) {
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
                    "the input in {} hangs, {:?} after the start",
                    folder.display(),
                    start.elapsed()
                );
                std::process::exit(1);
            }
        }
    });
}

/// What one reader makes of many inputs, which are written into the first folder, and stay in the second one where they break a promise;
/// how many did.
fn tried(reader: &Reader, [place, work]: [&Path; 2], runs: u64, random: &mut Random) -> u64 {
    // What goes wrong with the good inputs is the test's own fault, and is to be read.
    let silent = std::panic::take_hook();
    let seeds = (reader.seeds)(place);
    std::panic::set_hook(silent);
    let runs = runs.div_ceil(reader.dear);
    let path = place.join(reader.file);
    let (mut accepted, mut broken) = (0, 0);
    let (mut slowest, mut most) = (Duration::ZERO, 0);
    let start = Instant::now();
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
        if fs::write(&path, &bytes).is_err() {
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(&path, &bytes).unwrap();
        }
        let before = memory::begin();
        memory::give(reader.given);
        BEGUN.store(0, Ordering::SeqCst);
        let begun = processor::time();
        let read = catch_unwind(AssertUnwindSafe(|| (reader.read)(&path, &bytes)));
        let (took, took_memory) = (processor::time() - begun, memory::most_since(before));
        memory::give(usize::MAX);
        BEGUN.store(u64::MAX, Ordering::SeqCst);
        slowest = slowest.max(took);
        most = most.max(took_memory.saturating_sub(16 * bytes.len()));
        if let (Ok(false), true) = (&read, whole.is_some()) {
            eprintln!("{}: input {number} is good and was refused", reader.name);
            std::process::exit(1);
        }
        accepted += u64::from(whole.is_none() && *read.as_ref().unwrap_or(&false));
        let why = match read {
            Err(panic) => format!("panicked: {}", words(&*panic)),
            Ok(_) if took > Duration::from_secs(1) => format!("took {took:?}"),
            Ok(_) if took_memory > 16 * bytes.len() + (64 << 20) => format!("took {took_memory} bytes"),
            Ok(_) => continue,
        };
        broken += 1;
        let ending = path.extension().unwrap().display();
        let kept = work.join(format!("{}_{number}.{ending}", reader.name));
        fs::write(&kept, &bytes).unwrap();
        eprintln!("{}: {} {why}", reader.name, kept.display());
        assert!(broken < 20, "{}: too many to go on", reader.name);
    }
    // The good ones take their time too, but say nothing of how many are accepted.
    let each = start.elapsed().as_secs_f64() / (runs + seeds.len() as u64).max(1) as f64;
    println!(
        "| {} | {runs} | {:.1} % | {:.0} us | {:.0} ms | {:.1} MiB |",
        reader.name,
        100.0 * accepted as f64 / runs.max(1) as f64,
        each * 1e6,
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

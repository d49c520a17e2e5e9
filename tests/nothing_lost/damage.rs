//! States that are cut off or changed: with one of the two damaged the other is gone on from, with both the solve is refused.

use crate::Random;
use crate::place::{Place, result, run};
use crate::scenes::{CASES, Case};
use core::time::Duration;
use std::fs;
use std::path::{Path, PathBuf};
use std::thread::sleep;

/// The files of states.
const STATES: [&str; 2] = ["state.0", "state.1"];

/// Damages `count` pairs of states, of each case as many but for one.
pub fn all(place: &Place, count: u64, random: &mut Random) {
    let cases = CASES.len() as u64;
    for (index, case) in (0..).zip(CASES.iter().take(usize::try_from(count).unwrap())) {
        let (expected, takes) = place.whole(case);
        let kept = two_states(place, case, takes);
        for number in (index..count).step_by(CASES.len()) {
            let folder = place.fresh(case);
            copy(&kept, &folder.join("out.checkpoint"));
            let both = (number / cases).is_multiple_of(2);
            let one = random.below(2);
            let damaged = if both { &STATES[..] } else { &STATES[one..=one] };
            for state in damaged {
                let path = folder.join("out.checkpoint").join(state);
                let mut bytes = fs::read(&path).unwrap();
                let place = random.below(bytes.len());
                if random.below(2) == 0 {
                    bytes.truncate(place);
                } else {
                    bytes[place] ^= 1 << random.below(8);
                }
                fs::write(&path, bytes).unwrap();
            }
            let ended = run(&mut place.command(&folder, &["resume", "out"]));
            if both {
                assert!(
                    ended.code == Some(4) && ended.is_in_order(),
                    "{}: {ended:?}",
                    case.name
                );
                assert!(
                    ended.err.contains("is not whole") && ended.err.contains("--force"),
                    "{ended:?}"
                );
            } else {
                assert!(ended.is_well(), "{}: {ended:?}", case.name);
                assert!(
                    result(&folder).as_deref() == Some(&expected),
                    "{}: another result",
                    case.name
                );
            }
        }
        fs::remove_dir_all(&kept).unwrap();
    }
    println!("{count} damaged states: refused where both are, gone on from the other where one is");
}

/// Kills a solve when it has kept two states; a copy of their folder.
fn two_states(place: &Place, case: &Case, takes: Duration) -> PathBuf {
    let kept = place.work.join("kept");
    for part in 1.. {
        let folder = place.fresh(case);
        let mut program = place.solving(&folder, case, &[]).spawn().unwrap();
        sleep(takes * (part % 19 + 1) / 20);
        let _ = program.kill();
        program.wait().unwrap();
        let states = folder.join("out.checkpoint");
        if STATES.iter().all(|state| states.join(state).is_file()) {
            copy(&states, &kept);
            break;
        }
    }
    kept
}

fn copy(from: &Path, to: &Path) {
    if to.exists() {
        fs::remove_dir_all(to).unwrap();
    }
    fs::create_dir_all(to).unwrap();
    for entry in fs::read_dir(from).unwrap() {
        let entry = entry.unwrap();
        fs::copy(entry.path(), to.join(entry.file_name())).unwrap();
    }
}

//! States that are cut off or changed: with one of the two damaged the other is gone on from, with both the solve is refused.

use crate::Random;
use crate::place::{Place, result, run};
use crate::scenes::{CASES, Case};
use core::time::Duration;
use std::fs;
use std::path::{Path, PathBuf};
use std::thread::sleep;

/// Damages `count` states.
pub fn all(place: &Place, count: u64, random: &mut Random) {
    for case in &CASES {
        let (expected, takes) = place.whole(case);
        let kept = two_states(place, case, takes);
        for number in 0..count / CASES.len() as u64 {
            let folder = place.fresh(case);
            copy(&kept, &folder.join("out.checkpoint"));
            let both = number % 2 == 0;
            for state in ["state.0", "state.1"].iter().take(1 + usize::from(both)) {
                let path = folder.join("out.checkpoint").join(state);
                let mut bytes = fs::read(&path).unwrap();
                let place = usize::try_from(random.below(bytes.len() as u64)).unwrap();
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
        if ["state.0", "state.1"]
            .iter()
            .all(|state| states.join(state).is_file())
        {
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

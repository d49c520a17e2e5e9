//! Killed at random moments, again and again: what goes on ends in the identical result, and nothing is left behind.

use crate::Random;
use crate::place::{Place, left_over, result, run};
use crate::scenes::{CASES, Case};
use core::time::Duration;
use std::fs;
use std::path::Path;
use std::process::Command;
use std::thread::sleep;

/// Kills `count` solves.
pub fn all(place: &Place, count: u64, random: &mut Random) {
    let whole: Vec<(Vec<u8>, Duration)> = CASES.iter().map(|case| place.whole(case)).collect();
    let mut tally = [0u64; 4];
    for number in 0..count {
        let index = usize::try_from(number).unwrap() % CASES.len();
        let (case, (expected, takes)) = (&CASES[index], &whole[index]);
        one(place, case, expected, *takes, random, &mut tally);
    }
    let [kills, gone_on, anew, over] = tally;
    println!(
        "{count} solves were killed {kills} times: {gone_on} went on from a state, {anew} had none yet and were solved anew, {over} were over before; every result is identical"
    );
    assert!(gone_on > count / 4, "hardly any state was gone on from");
}

/// Starts a command and kills it after a random part of `takes`; whether it was still running.
fn killed(command: &mut Command, takes: Duration, random: &mut Random) -> bool {
    let mut program = command.spawn().unwrap();
    let micros = usize::try_from(takes.as_micros()).unwrap() * 11 / 10;
    sleep(Duration::from_micros(random.below(micros) as u64));
    let over = program.try_wait().unwrap().is_some();
    // SIGKILL.
    let _ = program.kill();
    program.wait().unwrap();
    !over
}

fn one(
    place: &Place,
    case: &Case,
    expected: &[u8],
    takes: Duration,
    random: &mut Random,
    [kills, gone_on, anew, over]: &mut [u64; 4],
) {
    let folder = place.fresh(case);
    // Half of them write over an earlier result.
    let earlier = random.below(2) == 0;
    if earlier {
        let before = run(&mut place.solving(&folder, case, &["--set", "flow.buoyancy=2e-3"]));
        assert!(before.is_well(), "{before:?}");
    }
    let old = result(&folder);
    *kills += u64::from(killed(
        &mut place.solving(&folder, case, &["--force"]),
        takes,
        random,
    ));
    let threads = if random.below(2) == 0 { "1" } else { "2" };
    let on = ["resume", "out", "--checkpoint", "every=1", "--threads", threads];
    while has_state(&folder) && random.below(3) == 0 {
        *kills += u64::from(killed(&mut place.command(&folder, &on), takes, random));
    }
    let had_state = has_state(&folder);
    let ended = run(&mut place.command(&folder, &on));
    assert!(ended.is_well() || !had_state, "{}: {ended:?}", case.name);
    if ended.is_well() {
        *gone_on += 1;
    } else {
        assert!(ended.is_in_order(), "{}: {ended:?}", case.name);
        // No state was kept yet, or the result is whole. Asking without force puts in order what was under way.
        let asked = run(&mut place.solving(&folder, case, &[]));
        assert!(asked.is_in_order(), "{}: {asked:?}", case.name);
        let found = result(&folder);
        assert!(
            found.is_some() == (old.is_some() || found.as_deref() == Some(expected)),
            "{}: a result is neither the earlier nor the new one",
            case.name
        );
        if found.as_deref() == Some(expected) {
            *over += 1;
        } else {
            assert!(found == old, "{}: the earlier result is not intact", case.name);
            *anew += 1;
            let again = run(&mut place.solving(&folder, case, &["--force"]));
            assert!(again.is_well(), "{}: {again:?}", case.name);
        }
    }
    assert!(
        result(&folder).as_deref() == Some(expected),
        "{}: another result, in {}",
        case.name,
        folder.display()
    );
    let left = left_over(&folder);
    assert!(left.is_empty(), "{}: left behind: {left:?}", case.name);
}

fn has_state(folder: &Path) -> bool {
    let states = folder.join("out.checkpoint");
    ["state.0", "state.1"]
        .iter()
        .any(|state| fs::metadata(states.join(state)).is_ok())
}

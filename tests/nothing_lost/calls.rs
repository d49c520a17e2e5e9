//! Every call of the system that writes fails once, and from it on: the earlier result is intact or the new one whole, one sentence says what
//! is wrong, and where it says that the state is kept, it is.

use crate::place::{Ended, Place, result, run};
use crate::scenes::{CASES, Case};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Fails each call of each case, or one of `every` so many: others for each way to fail.
pub fn all(place: &Place, every: u64) {
    let layer = place.work.join("fail.so");
    let source = concat!(env!("CARGO_MANIFEST_DIR"), "/fail.c");
    let compiler = Command::new("cc")
        .args(["-O1", "-Wall", "-Wextra", "-shared", "-fPIC", source, "-o"])
        .arg(&layer)
        .args(["-ldl"])
        .status();
    assert!(
        compiler.is_ok_and(|status| status.success()),
        "cc does not compile {source}"
    );
    let (mut runs, mut kept) = (0, 0);
    for case in CASES
        .iter()
        .filter(|case| ["direct", "fluids", "windows"].contains(&case.name))
    {
        let (expected, _) = place.whole(case);
        for (first, (how, on)) in (1..).zip([
            ("ENOSPC", true),
            ("ENOSPC", false),
            ("EIO", false),
            ("EROFS", true),
            ("short", false),
        ]) {
            let mut at = if every > 1 { first } else { 1 };
            loop {
                let (folder, old) = with_earlier(place, case);
                let mut command = place.solving(&folder, case, &["--force"]);
                command
                    .env("LD_PRELOAD", &layer)
                    .env("FAIL_UNDER", &folder)
                    .env("FAIL_AS", how)
                    .env("FAIL_AT", at.to_string())
                    .env("FAIL_COUNT", place.work.join("count"));
                if on {
                    command.env("FAIL_ON", "1");
                }
                let ended = run(&mut command);
                let what = format!(
                    "{}: call {at} fails by {how}, those after it too: {on}",
                    case.name
                );
                assert!(ended.is_in_order() || is_warned(&ended), "{what}: {ended:?}");
                kept += u64::from(is_right(place, &folder, (&expected, &old), &ended, &what));
                runs += 1;
                let count = fs::read_to_string(place.work.join("count")).unwrap();
                if count.trim().parse::<u64>().unwrap() < at {
                    break;
                }
                at += every;
            }
        }
    }
    println!("{runs} runs of which a call failed: no result was lost, {kept} were gone on from their state");
    assert!(kept > 0, "no state was gone on from");
}

/// A result that went elsewhere is told of by a sentence and code 4 as well; warnings come before.
fn is_warned(ended: &Ended) -> bool {
    let lines: Vec<&str> = ended.err.lines().collect();
    let warned = lines
        .iter()
        .all(|line| line.starts_with("thurible: ") || line.starts_with("warning: "));
    matches!(ended.code, Some(0 | 4 | 5)) && warned && !ended.err.contains("panicked")
}

/// A folder with an earlier result, and its arrays.
fn with_earlier(place: &Place, case: &Case) -> (PathBuf, Vec<u8>) {
    let folder = place.fresh(case);
    let out = folder.join("out");
    fs::create_dir_all(&out).unwrap();
    let earlier = place.work.join(format!("{}_earlier", case.name));
    if !earlier.is_dir() {
        let ended = run(&mut place.solving(&folder, case, &["--set", "flow.buoyancy=2e-3", "--force"]));
        assert!(ended.is_well(), "{ended:?}");
        fs::rename(&out, &earlier).unwrap();
        fs::create_dir_all(&out).unwrap();
    }
    for entry in fs::read_dir(&earlier).unwrap() {
        let entry = entry.unwrap();
        // Times are those of the copy: the manifest is read before.
        fs::copy(entry.path(), out.join(entry.file_name())).unwrap();
    }
    let old = result(&folder).unwrap();
    (folder, old)
}

/// Demands that the earlier or the new result is whole, and goes on where a state is said to be kept; whether it did.
fn is_right(
    place: &Place,
    folder: &Path,
    (expected, old): (&[u8], &[u8]),
    ended: &Ended,
    what: &str,
) -> bool {
    let found = result(folder);
    if ended.is_well() {
        assert!(found.as_deref() == Some(expected), "{what}: another result");
        return false;
    }
    let is_whole = [expected, old].iter().any(|one| found.as_deref() == Some(one));
    // Asked again, the next run puts in order what could not be put back.
    if !is_whole {
        let _ = run(&mut place.command(folder, &["solve", "scene.toml", "-o", "out"]));
        let found = result(folder);
        assert!(
            [expected, old].iter().any(|one| found.as_deref() == Some(one)),
            "{what}: the earlier result is lost: {ended:?}"
        );
    }
    let Some((_, rest)) = ended.err.split_once("is kept in ") else {
        return false;
    };
    let (states, _) = rest.split_once(": ").unwrap();
    let on = run(&mut place.command(folder, &["resume", states]));
    assert!(on.is_well(), "{what}: {ended:?} and then {on:?}");
    assert!(
        result(folder).as_deref() == Some(expected),
        "{what}: going on gives another result"
    );
    true
}

//! Good states: of a solver, of a solve that was killed, and of one that is done.

use crate::readers::{command, is_resumed};
use core::ops::Range;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Mutex;
use thurible::region::Region;
use thurible_core::checkpoint::{CHECK, FORMAT, HEAD, Label, MAGIC, Mix};
use thurible_core::{Boundary, D2, Params, Plan, Problem, Serial, Silent, Solver};

/// A solver of 6 x 5 cells and 3 steps.
pub fn with_solver<R>(work: impl FnOnce(&mut Solver<'_, f32, D2>) -> R) -> R {
    let ends = [Boundary::Wall, Boundary::Periodic];
    let problem = Problem::new(&[6, 5], &ends, &[3]);
    let params = Params::default();
    let bytes = Plan::new::<f32, D2>(&problem, &params).unwrap().bytes();
    let mut memory = Region::new(bytes).unwrap();
    work(&mut Solver::new(&problem, &params, memory.carve(bytes).unwrap()).unwrap())
}

/// What a solver saved before its first iteration, and after some.
pub fn saved(_: &Path) -> Vec<Vec<u8>> {
    let one = |iterations: usize| {
        with_solver(|solver| {
            let density = |cell: usize| if cell % 6 > 2 { 1.0 } else { 0.1 };
            let source: Vec<f32> = (0..30).map(density).collect();
            let target: Vec<f32> = (0..30).map(|cell| density(cell + 2)).collect();
            solver.set_source(&source).unwrap();
            solver.set_keyframe(0, &target).unwrap();
            for _ in 0..iterations {
                solver.step(&Serial, &mut Silent);
            }
            let mut bytes = vec![0; solver.saved_bytes()];
            solver.save(&mut bytes).unwrap();
            bytes
        })
    };
    let all = vec![one(0), one(1), one(3)];
    remember_parts(&all[0]);
    all
}

/// The fields of saved bytes, by the count of these.
static PARTS: Mutex<Vec<(u64, Vec<Range<usize>>)>> = Mutex::new(Vec::new());

/// The fields of so many saved bytes, each with its checksum.
pub fn parts(bytes: u64) -> Vec<Range<usize>> {
    let known = PARTS.lock().unwrap();
    let found = known.iter().find(|(count, _)| *count == bytes);
    found.map(|(_, parts)| parts.clone()).unwrap_or_default()
}

/// Finds the fields of good saved bytes: where one ends its checksum follows.
fn remember_parts(saved: &[u8]) {
    let (mut all, mut begin) = (Vec::new(), HEAD);
    while begin < saved.len() {
        let ends = |length: &usize| {
            let (mut sum, elements) = (Mix::new(), &saved[begin..begin + length]);
            elements.chunks(HEAD).for_each(|piece| sum.bytes(piece));
            saved.get(begin + length..begin + length + CHECK) == Some(&sum.finish().to_le_bytes()[..])
        };
        let mut lengths = (4..=saved.len() - begin - CHECK).step_by(4);
        let length = lengths.find(ends).expect("a field has its checksum behind it");
        all.push(begin..begin + length + CHECK);
        begin += length + CHECK;
    }
    PARTS.lock().unwrap().push((saved.len() as u64, all));
}

/// A scene that takes so long that its states can be seen, and what its limit is changed to in them: going on from one must not.
const SCENE: &str = "\
[grid]
cells = [6, 5]
[time]
steps = 3
[source]
circle = { center = [0.4, 0.4], radius = 0.3 }
[[keyframe]]
step = 3
circle = { center = [0.6, 0.5], radius = 0.3 }
[method]
iterations = 100000
direct = { tolerance = 1e-300, nested = false }
[output]
frames = false
";
const LIMITS: [&str; 2] = ["iterations = 100000", "iterations = 3     "];

/// States of solves that were killed: of a whole scene, of one in windows, and by ADMM.
pub fn checkpoints(work: &Path) -> Vec<Vec<u8>> {
    let windows = ["time.steps=9", "method.window=4", "keyframe[0].step=7"];
    let windows = windows.map(|set| ["--set", set]).concat();
    let admm = [
        "--method",
        "admm",
        "--set",
        "method.admm.density_tolerance=1e-300",
    ];
    vec![killed(work, &[]), killed(work, &windows), killed(work, &admm)]
}

/// The first state that a solve kept, which a child of this process ran until it was killed.
fn killed(work: &Path, options: &[&str]) -> Vec<u8> {
    let scene = work.join("kept.toml");
    let state = work.join("kept.checkpoint/state.1");
    for _ in 0..100 {
        fs::write(&scene, SCENE).unwrap();
        let _ = fs::remove_dir_all(work.join("kept.checkpoint"));
        let mut child = Command::new(std::env::current_exe().unwrap())
            .args([
                "solve",
                scene.to_str().unwrap(),
                "--quiet",
                "--force",
                "--threads",
                "1",
            ])
            .args([
                "--checkpoint",
                "every=1",
                "-o",
                work.join("kept").to_str().unwrap(),
            ])
            .args(options)
            .spawn()
            .unwrap();
        // A solve that is over has no state; it is tried again.
        while !state.exists() && child.try_wait().unwrap().is_none() {
            core::hint::spin_loop();
        }
        let _ = child.kill();
        child.wait().unwrap();
        // Its text is in the state: the file is not needed, and must not differ.
        fs::remove_file(&scene).unwrap();
        // One of a later window needs the files beside it.
        let kept = fs::read(&state).ok().and_then(sealed_again);
        if let Some(kept) = kept.filter(|kept| goes_on(work, kept)) {
            return kept;
        }
    }
    panic!("no state was seen");
}

/// Whether a solve goes on from this state alone.
fn goes_on(work: &Path, state: &[u8]) -> bool {
    let (states, out) = (work.join("alone"), work.join("alone_on"));
    fs::create_dir_all(&states).unwrap();
    fs::write(states.join("state.0"), state).unwrap();
    is_resumed(&states, &out)
}

/// The same state of a solve that goes on for few iterations, with the fields of what the core saved remembered; none where it saved nothing.
fn sealed_again(mut kept: Vec<u8>) -> Option<Vec<u8>> {
    core_state(&kept)?;
    let [long, short] = LIMITS.map(str::as_bytes);
    let place = kept.windows(long.len()).position(|part| part == long)?;
    kept[place..place + short.len()].copy_from_slice(short);
    let sum = kept.len() - CHECK;
    let right = state_sum(&kept[..sum]).to_le_bytes();
    kept[sum..].copy_from_slice(&right);
    let begin = core_state(&kept).unwrap();
    let bytes = Label::of(&kept[begin..]).unwrap().bytes;
    remember_parts(&kept[begin..begin + usize::try_from(bytes).unwrap()]);
    Some(kept)
}

/// Where in a state what the core saved begins: the word alone is in paths too.
pub fn core_state(kept: &[u8]) -> Option<usize> {
    let begins = [MAGIC, FORMAT].map(u64::to_le_bytes).concat();
    kept.windows(begins.len()).position(|part| part == begins)
}

/// The checksum of a state: of all before it, in pieces.
pub fn state_sum(bytes: &[u8]) -> u64 {
    let mut sum = Mix::new();
    let (pieces, rest) = bytes.as_chunks::<{ 1 << 16 }>();
    pieces.iter().for_each(|piece| sum.bytes(piece));
    sum.bytes(rest);
    sum.finish()
}

/// The folder of a solve in space that is done.
pub fn solved(work: &Path) -> PathBuf {
    let (scene, done) = (work.join("done.toml"), work.join("done"));
    let text = "[grid]\ncells = [6, 5, 7]\n[time]\nsteps = 2\n[source]\nsphere = { center = [0.4, 0.4, 0.5], radius = 0.3 }\n\
                [[keyframe]]\nstep = 2\nsphere = { center = [0.5, 0.4, 0.5], radius = 0.3 }\n[method]\niterations = 2\n[output]\nframes = false\n";
    fs::write(&scene, text).unwrap();
    let [scene, out] = [&scene, &done].map(|path| path.to_str().unwrap());
    command(&["solve", scene, "--quiet", "--force", "--threads", "1", "-o", out]).unwrap();
    done
}

/// What a result says of itself.
pub fn reports(work: &Path) -> Vec<Vec<u8>> {
    vec![fs::read(solved(work).join("report.json")).unwrap()]
}

//! The readers, one line each.

use crate::change::Random;
use crate::seeds;
use clap::Parser;
use std::path::{Path, PathBuf};
use thurible::cli::{Cli, Command};
use thurible::commands::{resume, solve};
use thurible::keyframes::{Canvas, Frames, ShapeSpec, read_velocity, steps_of_array};
use thurible::scene::{Document, Scene};
use thurible_core::checkpoint::{HEAD, Mix};
use thurible_core::{Boundary, D2, Params, Problem, Solver};

/// What reads files, or texts.
pub struct Reader {
    pub name: &'static str,
    /// The name of the file that it is given.
    pub file: &'static str,
    pub is_text: bool,
    /// Good inputs; what else they need is written into the folder of work.
    pub seeds: fn(&Path) -> Vec<Vec<u8>>,
    /// Makes checksums right again, often, so that changes come to what is behind them.
    pub mend: fn(&mut [u8], &mut Random),
    /// Of how many runs one is made, where one takes long.
    pub dear: u64,
    /// Whether it accepts them.
    pub read: fn(&Path, &[u8]) -> bool,
}

/// All of them.
pub const READERS: &[Reader] = &[
    Reader {
        name: "scene",
        file: "a.toml",
        is_text: true,
        seeds: seeds::scenes,
        mend: as_it_is,
        dear: 1,
        read: scene,
    },
    Reader {
        name: "set",
        file: "a.txt",
        is_text: true,
        seeds: seeds::assignments,
        mend: as_it_is,
        dear: 1,
        read: assignment,
    },
    Reader {
        name: "npy",
        file: "a.npy",
        is_text: false,
        seeds: seeds::arrays,
        mend: as_it_is,
        dear: 1,
        read: array,
    },
    Reader {
        name: "npz",
        file: "a.npz",
        is_text: false,
        seeds: seeds::archives,
        mend: as_it_is,
        dear: 1,
        read: archive,
    },
    Reader {
        name: "velocity",
        file: "v.npz",
        is_text: false,
        seeds: seeds::archives,
        mend: as_it_is,
        dear: 1,
        read: velocity,
    },
    Reader {
        name: "frames",
        file: "f.npy",
        is_text: false,
        seeds: seeds::arrays,
        mend: as_it_is,
        dear: 1,
        read: frames,
    },
    Reader {
        name: "image",
        file: "a.png",
        is_text: false,
        seeds: seeds::pictures,
        mend: mend_png,
        dear: 1,
        read: image,
    },
    Reader {
        name: "font",
        file: "a.ttf",
        is_text: false,
        seeds: seeds::fonts,
        mend: as_it_is,
        dear: 4,
        read: font,
    },
    Reader {
        name: "saved",
        file: "a.saved",
        is_text: false,
        seeds: saved_seeds,
        mend: mend_saved,
        dear: 1,
        read: saved,
    },
    Reader {
        name: "checkpoint",
        file: "states/state.0",
        is_text: false,
        seeds: checkpoints,
        mend: mend_state,
        dear: 20,
        read: checkpoint,
    },
];

fn as_it_is(_: &mut [u8], _: &mut Random) {}

fn canvas() -> Canvas {
    Canvas {
        cells: vec![8, 8],
        periodic: vec![false, false],
        length: 1.0,
    }
}

fn document(path: &Path, bytes: &[u8]) -> Option<Document> {
    let text = String::from_utf8(bytes.to_vec()).ok()?;
    Document::parse(path, text).ok()
}

fn scene(path: &Path, bytes: &[u8]) -> bool {
    document(path, bytes).is_some_and(|document| Scene::of(document).is_ok())
}

fn assignment(path: &Path, bytes: &[u8]) -> bool {
    let text = seeds::scenes(path).swap_remove(0);
    let (Some(mut document), Ok(assignment)) = (document(path, &text), core::str::from_utf8(bytes)) else {
        return false;
    };
    // That it is taken is enough: not each fits this scene.
    let is_taken = document.set(assignment).is_ok();
    let _ = Scene::of(document);
    is_taken
}

fn shape(text: &str) -> ShapeSpec {
    toml::from_str(text).unwrap()
}

fn folder(path: &Path) -> PathBuf {
    path.parent().unwrap().to_path_buf()
}

fn array(path: &Path, _: &[u8]) -> bool {
    let shape = shape("file = \"a.npy\"");
    let steps = steps_of_array(&shape, &folder(path));
    shape.rasterise(&canvas(), &folder(path)).is_ok() || steps.is_ok()
}

fn archive(path: &Path, _: &[u8]) -> bool {
    shape("file = \"a.npz\"\nname = \"density\"")
        .rasterise(&canvas(), &folder(path))
        .is_ok()
}

fn velocity(path: &Path, _: &[u8]) -> bool {
    read_velocity(path, &canvas()).is_ok()
}

fn frames(path: &Path, _: &[u8]) -> bool {
    let Ok(mut frames) = Frames::of_array(path, None, "capture.file") else {
        return false;
    };
    (0..frames.count().min(4)).all(|frame| frames.read(frame).is_ok())
}

fn image(path: &Path, _: &[u8]) -> bool {
    shape("image = \"a.png\"")
        .rasterise(&canvas(), &folder(path))
        .is_ok()
}

fn font(path: &Path, _: &[u8]) -> bool {
    let shape = shape("text = \"gF&8\"\nfont = \"a.ttf\"\nheight = 0.5");
    shape.rasterise(&canvas(), &folder(path)).is_ok()
}

/// Makes the checksums of the parts of a PNG right again, half of the time.
fn mend_png(bytes: &mut [u8], random: &mut Random) {
    if random.below(2) == 0 {
        return;
    }
    let mut at = 8;
    while let Some(head) = bytes.get(at..at + 8) {
        let length = usize::try_from(u32::from_be_bytes(head[..4].try_into().unwrap())).unwrap();
        let Some(end) = at.checked_add(8 + length).filter(|end| end + 4 <= bytes.len()) else {
            break;
        };
        let crc = !bytes[at + 4..end].iter().fold(u32::MAX, |crc, &byte| {
            (0..8).fold(crc ^ u32::from(byte), |crc, _| {
                (crc >> 1) ^ (0xEDB8_8320 & (crc & 1).wrapping_neg())
            })
        });
        bytes[end..end + 4].copy_from_slice(&crc.to_be_bytes());
        at = end + 4;
    }
}

/// A solver of 6 x 5 cells and 3 steps.
fn with_solver<R>(work: impl FnOnce(&mut Solver<'_, f32, D2>) -> R) -> R {
    let ends = [Boundary::Wall, Boundary::Periodic];
    let problem = Problem::new(&[6, 5], &ends, &[3]);
    let params = Params::default();
    let bytes = thurible_core::Plan::new::<f32, D2>(&problem, &params)
        .unwrap()
        .bytes();
    let mut memory = thurible::region::Region::new(bytes).unwrap();
    work(&mut Solver::new(&problem, &params, memory.carve(bytes).unwrap()).unwrap())
}

fn saved_seeds(_: &Path) -> Vec<Vec<u8>> {
    let one = |iterations: usize| {
        with_solver(|solver| {
            let density = |cell: usize| if cell % 6 > 2 { 1.0 } else { 0.1 };
            let source: Vec<f32> = (0..30).map(density).collect();
            let target: Vec<f32> = (0..30).map(|cell| density(cell + 2)).collect();
            solver.set_source(&source).unwrap();
            solver.set_keyframe(0, &target).unwrap();
            for _ in 0..iterations {
                solver.step(&thurible_core::Serial, &mut thurible_core::Silent);
            }
            let mut bytes = vec![0; solver.saved_bytes()];
            solver.save(&mut bytes).unwrap();
            bytes
        })
    };
    vec![one(0), one(1), one(3)]
}

/// Gives the head of saved bytes the right checksum, mostly.
fn mend_saved(bytes: &mut [u8], random: &mut Random) {
    if random.below(4) > 0 {
        let mut sum = Mix::new();
        sum.bytes(bytes.get(..32).unwrap_or(&[]));
        sum.bytes(bytes.get(40..HEAD).unwrap_or(&[]));
        if let Some(place) = bytes.get_mut(32..40) {
            place.copy_from_slice(&sum.finish().to_le_bytes());
        }
    }
}

fn saved(_: &Path, bytes: &[u8]) -> bool {
    with_solver(|solver| {
        let is_taken = solver.restore(bytes).is_ok();
        if is_taken {
            // Any numbers: it may end anywhere, but in order.
            solver.step(&thurible_core::Serial, &mut thurible_core::Silent);
            let _ = solver.finish(&thurible_core::Serial);
        }
        is_taken
    })
}

const KEPT: &str = "\
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
iterations = 60
direct = { tolerance = 1e-12, nested = false }
[output]
frames = false
";

/// Runs a command of the program in this process.
fn command(arguments: &[&str]) -> Result<u8, thurible::exit::Failure> {
    let cli = Cli::try_parse_from([&["thurible"], arguments].concat()).unwrap();
    match &cli.command {
        Command::Solve(arguments) => solve::run(arguments),
        Command::Resume(arguments) => resume::run(arguments),
        _ => unreachable!(),
    }
}

/// States that the program kept, caught while it kept them: of a whole scene and of one in windows.
fn checkpoints(work: &Path) -> Vec<Vec<u8>> {
    let caught = |windows: &[&str]| {
        let scene = work.join("kept.toml");
        std::fs::write(&scene, KEPT).unwrap();
        let (scene, out) = (scene.to_str().unwrap().to_owned(), work.join("kept"));
        let first = [
            "solve",
            &scene,
            "--quiet",
            "--force",
            "--checkpoint",
            "every=1",
            "--threads",
            "1",
        ];
        let all = [&first[..], &["-o", out.to_str().unwrap()], windows].concat();
        let state = work.join("kept.checkpoint/state.0");
        std::thread::scope(|scope| {
            let running = scope.spawn(|| command(&all));
            let mut kept = Vec::new();
            while !running.is_finished() {
                // A state of later windows is not whole without the files beside it.
                if kept.is_empty() || windows.is_empty() {
                    let found = std::fs::read(&state).ok();
                    kept = found.filter(|bytes| is_sealed(bytes)).unwrap_or(kept);
                }
            }
            running.join().unwrap().unwrap();
            assert!(!kept.is_empty(), "no state was caught");
            kept
        })
    };
    vec![
        caught(&[]),
        caught(&[
            "--set",
            "time.steps=9",
            "--set",
            "method.window=4",
            "--set",
            "keyframe[0].step=7",
        ]),
    ]
}

/// The checksum of a state: of all before it, in pieces.
fn state_sum(bytes: &[u8]) -> u64 {
    let mut sum = Mix::new();
    let (pieces, rest) = bytes.as_chunks::<{ 1 << 16 }>();
    pieces.iter().for_each(|piece| sum.bytes(piece));
    sum.bytes(rest);
    sum.finish()
}

fn is_sealed(bytes: &[u8]) -> bool {
    let end = bytes.split_last_chunk::<8>();
    end.is_some_and(|(all, sum)| state_sum(all).to_le_bytes() == *sum)
}

/// Makes the checksum of a state right again, mostly.
fn mend_state(bytes: &mut [u8], random: &mut Random) {
    if random.below(8) > 0
        && let Some((all, sum)) = bytes.split_last_chunk_mut::<8>()
    {
        *sum = state_sum(all).to_le_bytes();
    }
}

/// Goes on from it: the whole way.
fn checkpoint(path: &Path, _: &[u8]) -> bool {
    let states = folder(path);
    let out = states.with_file_name("on");
    let [states, out] = [&states, &out].map(|path| path.to_str().unwrap());
    command(&["resume", states, "-o", out, "--quiet", "--threads", "1"]).is_ok()
}

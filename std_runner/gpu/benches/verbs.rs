//! Seconds of each verb of a device in a search by the direct method: a ball that moves across a corner of a box, as `examples/small_3d.toml`.
//!
//! `cargo bench --package thurible-gpu -- [CELLS STEPS ITERATIONS PAIRS [MIB]] [here]`, as in `64 60 10 5`; on the first adapter, which is a card if
//! there is one and of whose memory it takes so many MiB at most, or `here` on one thread: objectives are to be the same but for rounding,
//! which grows from iteration to iteration.

use core::time::Duration;
use std::collections::BTreeMap;
use std::sync::{Mutex, PoisonError};
use std::time::Instant;
use thurible_core::exec::device::{NotFinite, Place, Search, Stride, WithGradient};
use thurible_core::exec::{Device, Exec, Together};
use thurible_core::solver::room;
use thurible_core::{Boundary, D3, Params, Plan, Problem, Progress, Serial, Silent, Solver};
use thurible_gpu::{Gpu, adapters};

/// What went wrong, in a sentence.
type Sentence = String;

/// Calls of a verb, and the seconds that they took.
type Times = BTreeMap<&'static str, (u32, Duration)>;

/// A device whose verbs are timed: each of them to its end, as all but the first three come back with numbers.
#[derive(Debug)]
struct Timed {
    gpu: Gpu,
    times: Mutex<Times>,
}

impl Timed {
    fn time<R>(&self, verb: &'static str, act: impl FnOnce(&Gpu) -> R) -> R {
        let begun = Instant::now();
        let answer = act(&self.gpu);
        let taken = begun.elapsed();
        let mut times = self.times.lock().unwrap_or_else(PoisonError::into_inner);
        let (calls, seconds) = times.entry(verb).or_default();
        *calls += 1;
        *seconds += taken;
        answer
    }

    fn take(&self) -> Times {
        core::mem::take(&mut *self.times.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

impl Device for Timed {
    fn begin(&self, search: &Search<'_>) {
        self.time("begin", |gpu| gpu.begin(search));
    }

    fn write(&self, place: Place, row: &mut dyn FnMut(usize, &mut [f32])) {
        self.time("write", |gpu| gpu.write(place, row));
    }

    fn read(&self, place: Place, row: &mut dyn FnMut(usize, &[f32])) {
        self.time("read", |gpu| gpu.read(place, row));
    }

    fn form(&self, into: usize, terms: &mut dyn Iterator<Item = (f64, usize)>) {
        self.time("form", |gpu| gpu.form(into, terms));
    }

    fn divergence(&self, field: usize) -> [f64; 2] {
        self.time("divergence", |gpu| gpu.divergence(field))
    }

    fn project(&self, field: usize, tolerance: f64) {
        self.time("project", |gpu| gpu.project(field, tolerance));
    }

    fn advance(&self, field: usize, s: f64) {
        self.time("advance", |gpu| gpu.advance(field, s));
    }

    fn retreat(&self, keep: f64) {
        self.time("retreat", |gpu| gpu.retreat(keep));
    }

    fn value(&self, force: usize) -> Result<[f64; 3], NotFinite> {
        self.time("value", |gpu| gpu.value(force))
    }

    fn gradient(&self, force: usize, into: usize) -> Result<(), NotFinite> {
        self.time("gradient", |gpu| gpu.gradient(force, into))
    }

    fn arrive(
        &self,
        gradient: usize,
        image: usize,
        step: Option<Stride>,
        pairs: &mut dyn Iterator<Item = [usize; 2]>,
        products: &mut dyn FnMut([f64; 2]),
    ) -> WithGradient {
        self.time("arrive", |gpu| gpu.arrive(gradient, image, step, pairs, products))
    }
}

fn ball(n: usize, centre: [f64; 3]) -> Vec<f32> {
    let at = |i: usize| (i as f64 + 0.5) / n as f64;
    let cells = (0..n * n * n).map(|cell| [cell % n, cell / n % n, cell / (n * n)].map(at));
    cells
        .map(|x| {
            let squares = (0..3).map(|axis| (x[axis] - centre[axis]).powi(2));
            let distance = squares.sum::<f64>().sqrt();
            (0.5 + (0.22 - distance) * n as f64).clamp(0.0, 1.0) as f32
        })
        .collect()
}

fn print(title: &str, times: &Times) {
    println!(
        "{title}\n{:<12}{:>8}{:>12}{:>12}",
        "verb", "calls", "s", "ms a call"
    );
    for (verb, (calls, seconds)) in times {
        let seconds = seconds.as_secs_f64();
        println!(
            "{verb:<12}{calls:>8}{seconds:>12.3}{:>12.2}",
            1e3 * seconds / f64::from(*calls)
        );
    }
}

/// What an iteration says beside its objective: slope, norm of the gradient, step, evaluations.
fn facts(progress: &Progress) -> String {
    let facts = progress.report.iter();
    let facts = facts.map(|(fact, values)| format!("{} {values:?}", fact.name));
    facts.collect::<Vec<_>>().join(", ")
}

fn main() -> Result<(), Sentence> {
    let here = std::env::args().any(|word| word == "here");
    let given: Vec<usize> = std::env::args()
        .skip(1)
        .filter_map(|word| word.parse().ok())
        .collect();
    let ([n, steps, iterations, pairs], most) = match given[..] {
        [] => ([64, 60, 10, 5], None),
        [n, steps, iterations, pairs] => ([n, steps, iterations, pairs], None),
        [n, steps, iterations, pairs, mib] => ([n, steps, iterations, pairs], Some((mib as u64) << 20)),
        _ => return Err("give CELLS STEPS ITERATIONS PAIRS, or MIB too, or nothing".into()),
    };
    let cells = [n; 3];
    let problem = Problem::new(&cells, &[Boundary::Wall; 3], core::slice::from_ref(&steps));
    let mut params = Params {
        iterations,
        ..Params::default()
    };
    (params.direct.nested, params.direct.history) = (false, Some(pairs));
    let plan = Plan::new::<f32, D3>(&problem, &params).map_err(|error| error.to_string())?;
    let first = adapters().into_iter().next().ok_or("there is no device")?;
    let device = Timed {
        gpu: first.open(most)?,
        times: Mutex::default(),
    };
    println!(
        "{n}^3 x {steps}, {pairs} pairs, on {}: {} bytes here",
        first.name,
        plan.bytes()
    );
    if !here {
        let taken = device.gpu.plan(&room(&problem, plan.params())?)?;
        for (name, bytes) in taken.lines {
            println!("{bytes:>16}  {name}");
        }
        println!("{:>16}  here, streamed", taken.here);
    }
    let mut memory: Vec<u8> = Vec::with_capacity(plan.bytes() + Plan::ALIGN);
    let spare = memory.spare_capacity_mut();
    let at = spare.as_ptr().align_offset(Plan::ALIGN);
    let mut solver = Solver::<f32, D3>::new(&problem, plan.params(), &mut spare[at..])
        .map_err(|error| error.to_string())?;
    solver
        .set_source(&ball(n, [0.4, 0.4, 0.5]))
        .map_err(|error| error.to_string())?;
    solver
        .set_keyframe(0, &ball(n, [0.6, 0.55, 0.5]))
        .map_err(|error| error.to_string())?;
    let beside = Together::beside(&Serial, &device);
    let begun = Instant::now();
    let exec: &dyn Exec = if here { &Serial } else { &beside };
    let first = solver.step(exec, &mut Silent);
    println!(
        "the first iteration: {:.3} s, {}",
        begun.elapsed().as_secs_f64(),
        facts(&first)
    );
    print("until then", &device.take());
    let streamed = device.gpu.streamed();
    let begun = Instant::now();
    let mut objectives = vec![first.objective.total()];
    let (mut done, mut last) = (0, Progress::default());
    while done + 1 < iterations && last.status.is_none() {
        last = solver.step(exec, &mut Silent);
        println!("  {}", facts(&last));
        objectives.push(last.objective.total());
        done += 1;
    }
    let seconds = begun.elapsed().as_secs_f64();
    println!(
        "{done} more: {:.4} s each, {} bytes streamed in each, {:?}; objectives {objectives:.1?}",
        seconds / f64::from(done.max(1) as u32),
        (device.gpu.streamed() - streamed) / done.max(1) as u64,
        last.status
    );
    print("in these", &device.take());
    device.gpu.failure().map_or(Ok(()), Err)
}

//! Tracking: known motions, the minimum, its memory, its bits.

use crate::fields::random::Random;
use crate::fields::{Memory, boundaries, cast, with_threads};
use thurible_core::flow::{Minimiser, Warping};
use thurible_core::track::{Pair, Part, Prediction};
use thurible_core::{
    Capture, D2, D3, Exec, InputError, Real, Serial, Silent, SolverError, Space, TrackParams, TrackPlan,
    Tracker,
};

/// The flows of all pairs in f64, component by component, and what was said of them.
struct Tracked {
    flows: Vec<[Vec<f64>; 3]>,
    pairs: Vec<Pair>,
}

fn track<T: Real, S: Space>(
    exec: &dyn Exec,
    capture: &Capture<'_>,
    params: &TrackParams,
    frames: &[Vec<f64>],
) -> Tracked {
    let plan = TrackPlan::new::<T, S>(capture, params).unwrap();
    let mut memory = Memory::new(plan.bytes());
    let mut tracker = Tracker::<T, S>::new(capture, params, memory.block()).unwrap();
    let (mut flows, mut pairs) = (Vec::new(), Vec::new());
    for frame in frames {
        tracker.give(exec, &cast::<f64, T>(frame)).unwrap();
        if !tracker.is_ready() {
            continue;
        }
        let mut flow: [Vec<f64>; 3] = Default::default();
        let pair = tracker
            .step(exec, &mut Silent, &mut |part, faces| {
                if part == Part::Velocity {
                    for axis in 0..S::DIM {
                        let mut out = vec![T::ZERO; faces.len(axis)];
                        faces.read(axis, &mut out);
                        flow[axis] = cast(&out);
                    }
                }
            })
            .unwrap();
        flows.push(flow);
        pairs.push(pair);
    }
    Tracked { flows, pairs }
}

const PERIODIC: [usize; 2] = [48, 40];

/// Noise on 48 x 40 periodic cells, blurred by sigma 2 and stretched to 0 .. 10, moved by so many cells.
fn texture(seed: u64, shift: [f64; 2]) -> Vec<f64> {
    let [nx, ny] = PERIODIC;
    let mut random = Random::new(seed);
    let noise: Vec<f64> = (0..nx * ny).map(|_| random.signed()).collect();
    let still = filtered(&noise, [0.0; 2]);
    let (low, high) = still
        .iter()
        .fold((f64::MAX, f64::MIN), |(low, high), &x| (low.min(x), high.max(x)));
    let stretch = |x: f64| 10.0 * (x - low) / (high - low);
    filtered(&noise, shift).into_iter().map(stretch).collect()
}

/// Blurred and shifted, both along rows and then along columns, by the kernels of their Fourier series.
fn filtered(field: &[f64], shift: [f64; 2]) -> Vec<f64> {
    let [nx, ny] = PERIODIC;
    let (along_x, along_y) = (kernel(nx, shift[0]), kernel(ny, shift[1]));
    let mut rows = vec![0.0; nx * ny];
    for y in 0..ny {
        for x in 0..nx {
            rows[y * nx + x] = (0..nx)
                .map(|from| along_x[(x + nx - from) % nx] * field[y * nx + from])
                .sum();
        }
    }
    let mut all = vec![0.0; nx * ny];
    for y in 0..ny {
        for x in 0..nx {
            all[y * nx + x] = (0..ny)
                .map(|from| along_y[(y + ny - from) % ny] * rows[from * nx + x])
                .sum();
        }
    }
    all
}

/// A Gaussian of sigma 2 whose centre is at `shift`, as the Fourier series of a ring of n cells has it.
fn kernel(n: usize, shift: f64) -> Vec<f64> {
    let turn = 2.0 * core::f64::consts::PI / n as f64;
    let value = |x: usize| {
        (0..n)
            .map(|k| {
                let wave = if 2 * k > n { k as f64 - n as f64 } else { k as f64 };
                let angle = turn * wave;
                (-0.5 * (2.0 * angle).powi(2)).exp() * (angle * (x as f64 - shift)).cos()
            })
            .sum::<f64>()
            / n as f64
    };
    (0..n).map(value).collect()
}

fn lone(minimiser: Minimiser, alpha: f64, beta: f64, levels: usize) -> TrackParams {
    let mut params = TrackParams::of(minimiser);
    (params.flow.alpha, params.flow.beta, params.flow.levels) = (alpha, beta, levels);
    params.independent = true;
    params
}

fn ring() -> Vec<thurible_core::Boundary> {
    boundaries("pp")
}

/// A capture in cells and frames.
fn in_cells<'a>(cells: &'a [usize], ends: &'a [thurible_core::Boundary]) -> Capture<'a> {
    Capture {
        length: cells.iter().copied().max().unwrap_or(1) as f64,
        ..Capture::new(cells, ends)
    }
}

fn error(flow: &[Vec<f64>; 3], truth: [f64; 2]) -> f64 {
    let squares = |axis: usize| -> f64 { flow[axis].iter().map(|x| (x - truth[axis]).powi(2)).sum() };
    let size = (truth[0].powi(2) + truth[1].powi(2)) * flow[0].len() as f64;
    ((squares(0) + squares(1)) / size).sqrt()
}

#[test]
fn known_motions_are_found() {
    let ends = ring();
    let capture = in_cells(&PERIODIC, &ends);
    for (shift, levels, most) in [
        ([0.5, -0.25], 3, 0.02),
        ([2.0, -1.0], 3, 0.02),
        ([4.0, -2.0], 3, 0.05),
        ([6.0, -3.0], 5, 0.04),
    ] {
        let frames = [texture(1, [0.0; 2]), texture(1, shift)];
        let params = lone(Minimiser::Direct, 1.0, 0.0, levels);
        let found = track::<f64, D2>(&Serial, &capture, &params, &frames);
        let error = error(&found.flows[0], shift);
        assert!(error <= most, "{shift:?}: {error}");
        let [before, after] = found.pairs[0].misfit;
        assert!(after < 0.05 * before, "{shift:?}: misfit {before} -> {after}");
    }
}

/// beta rewards stillness: one pair gives a part of the motion, the more the less beta.
#[test]
fn kinetic_energy_shrinks_a_lone_pair() {
    let ends = ring();
    let capture = in_cells(&PERIODIC, &ends);
    let frames = [texture(1, [0.0; 2]), texture(1, [0.5, 0.0])];
    let along = |beta: f64| {
        let found = track::<f64, D2>(
            &Serial,
            &capture,
            &lone(Minimiser::Direct, 1e-4, beta, 3),
            &frames,
        );
        found.flows[0][0].iter().sum::<f64>() / found.flows[0][0].len() as f64
    };
    let [strong, weak] = [1.0, 0.01].map(along);
    assert!(
        strong > 0.02 && strong < 0.3 && weak > 1.5 * strong && weak < 0.5,
        "{strong}, {weak}"
    );
}

/// Smooth smoke in a box of any shape, one frame an argument of time.
fn smoke(cells: &[usize], time: f64) -> Vec<f64> {
    let count: usize = cells.iter().product();
    (0..count)
        .map(|cell| {
            let mut rest = cell;
            let value = cells.iter().enumerate().map(|(axis, &n)| {
                let at = (rest % n) as f64 / n as f64;
                rest /= n;
                (9.0 * at + (axis as f64 + 1.0) * (0.6 + 0.4 * time))
                    .sin()
                    .powi(2)
            });
            2.0 * value.product::<f64>() + 0.05 * (0.7 * cell as f64 + 0.3 * time).cos()
        })
        .collect()
}

fn gap(one: &[Vec<f64>; 3], other: &[Vec<f64>; 3]) -> f64 {
    let pairs = || one.iter().flatten().zip(other.iter().flatten());
    let squares: f64 = pairs().map(|(x, y)| (x - y).powi(2)).sum();
    let size: f64 = pairs().map(|(_, y)| y * y).sum();
    (squares / size).sqrt()
}

#[test]
fn admm_goes_where_the_direct_way_goes() {
    for (cells, ends) in [(&[24usize, 20][..], "wp"), (&[10, 9, 8], "wpw")] {
        let ends = boundaries(ends);
        let capture = in_cells(cells, &ends);
        let frames = [smoke(cells, 0.0), smoke(cells, 1.0)];
        let flow = |minimiser, iterations| {
            let mut params = lone(minimiser, 1e-2, 0.3, 1);
            params.flow.iterations = iterations;
            params.flow.cg_tolerance = 1e-8;
            params.flow.cg_iterations = 1000;
            let mut found = if cells.len() == 2 {
                track::<f64, D2>(&Serial, &capture, &params, &frames)
            } else {
                track::<f64, D3>(&Serial, &capture, &params, &frames)
            };
            found.flows.remove(0)
        };
        let direct = flow(Minimiser::Direct, 5);
        let apart = gap(&flow(Minimiser::Admm, 50), &direct);
        assert!(apart < 1e-6, "{cells:?}: {apart:e}");
        let early = gap(&flow(Minimiser::Admm, 5), &direct);
        assert!(
            early > 1e-4 && early < 1.0,
            "{cells:?}: {early:e} after five iterations"
        );
    }
}

#[test]
fn weights_and_densities_scale_together() {
    let (cells, ends) = ([20, 16], boundaries("ww"));
    let frames: Vec<Vec<f64>> = (0..3).map(|time| smoke(&cells, f64::from(time))).collect();
    for minimiser in [Minimiser::Direct, Minimiser::Admm, Minimiser::HornSchunck] {
        let by = |s: f64| {
            let mut params = TrackParams::of(minimiser);
            params.flow.gamma = 10.0;
            for weight in [
                &mut params.flow.alpha,
                &mut params.flow.beta,
                &mut params.flow.gamma,
            ] {
                *weight *= s * s;
            }
            params.flow.lambda /= s * s;
            let capture = Capture {
                density_scale: 3.0 * s,
                ..in_cells(&cells, &ends)
            };
            track::<f64, D2>(&Serial, &capture, &params, &frames).flows
        };
        for (one, other) in by(1.0).iter().zip(&by(4.0)) {
            let apart = gap(one, other);
            assert!(apart < 1e-9, "{minimiser:?}: {apart:e}");
        }
    }
}

fn some_params() -> Vec<TrackParams> {
    let mut all: Vec<TrackParams> = [Minimiser::Direct, Minimiser::Admm, Minimiser::HornSchunck]
        .into_iter()
        .map(TrackParams::of)
        .collect();
    all[2].flow.gamma = 100.0;
    let direct = all[0];
    for predict in [Prediction::Bfecc, Prediction::None] {
        all.push(TrackParams { predict, ..direct });
    }
    let mut quick = direct;
    (quick.flow.warp, quick.flow.warps, quick.readvect) = (Warping::Quick, 2, false);
    all.push(quick);
    all
}

fn plans_are_exact<T: Real, S: Space>(cells: &[usize], ends: &str, frames: usize) {
    let ends = boundaries(ends);
    let capture = in_cells(cells, &ends);
    for mut params in some_params() {
        for threads in [1, 3] {
            params.threads = threads;
            let bytes = TrackPlan::new::<T, S>(&capture, &params).unwrap().bytes();
            let mut memory = Memory::new(bytes);
            let short = Tracker::<T, S>::new(&capture, &params, &mut memory.block()[..bytes - 1]);
            let refused = SolverError::TooSmall {
                needed: bytes,
                given: bytes - 1,
            };
            assert_eq!(short.err(), Some(refused));
            // What is carved is what is planned: `new` asserts that nothing is left, and no phase finds too little.
            let mut tracker = Tracker::<T, S>::new(&capture, &params, memory.block()).unwrap();
            for time in 0..frames {
                let frame: Vec<T> = cast(&smoke(cells, 0.2 * time as f64));
                tracker.give(&Serial, &frame).unwrap();
                if tracker.is_ready() {
                    tracker.step(&Serial, &mut Silent, &mut |_, _| {}).unwrap();
                }
            }
            assert_eq!(tracker.pairs(), frames - 1);
        }
    }
}

#[test]
fn plans_are_exact_for_two_frames_and_for_two_hundred() {
    plans_are_exact::<f32, D2>(&[17, 24], "wp", 3);
    plans_are_exact::<f64, D3>(&[9, 10, 8], "pww", 3);
    plans_are_exact::<f64, D2>(&[8, 9], "ww", 201);
}

fn bits<T: Real, S: Space>(cells: &[usize], ends: &str, params: &TrackParams, threads: usize) -> Vec<u64> {
    let ends = boundaries(ends);
    let capture = Capture {
        buoyancy: [0.0, 0.01, 0.0],
        ..in_cells(cells, &ends)
    };
    let frames: Vec<Vec<f64>> = (0..3).map(|time| smoke(cells, f64::from(time))).collect();
    let params = TrackParams { threads, ..*params };
    let found = with_threads(threads, |exec| track::<T, S>(exec, &capture, &params, &frames));
    let flows = found.flows.iter().flatten().flatten().copied();
    let said = found.pairs.iter().flat_map(|pair| {
        [
            pair.terms.data,
            pair.terms.optimality,
            pair.misfit[1],
            pair.readvection,
        ]
    });
    flows.chain(said).map(f64::to_bits).collect()
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    for params in some_params() {
        let one = bits::<f32, D2>(&[70, 66], "wp", &params, 1);
        assert!(one.iter().any(|&bits| bits != 0));
        for threads in [2, 3] {
            assert!(
                one == bits::<f32, D2>(&[70, 66], "wp", &params, threads),
                "{params:?}"
            );
        }
    }
    let direct = TrackParams::default();
    let one = bits::<f64, D3>(&[18, 20, 16], "wpw", &direct, 1);
    assert!((2..=3).all(|threads| one == bits::<f64, D3>(&[18, 20, 16], "wpw", &direct, threads)));
}

/// Divergence is left by rounding alone, in f32 too, and the walls hold.
#[test]
fn flows_have_no_divergence() {
    let (cells, ends) = ([40, 30], boundaries("ww"));
    let frames: Vec<Vec<f64>> = (0..4).map(|time| smoke(&cells, f64::from(time))).collect();
    let found = track::<f32, D2>(
        &Serial,
        &in_cells(&cells, &ends),
        &TrackParams::default(),
        &frames,
    );
    for ([x, y, _], pair) in found.flows.iter().zip(&found.pairs) {
        for j in 0..30 {
            assert!(x[j * 41] == 0.0 && x[j * 41 + 40] == 0.0);
            for i in 0..40 {
                let divergence = x[j * 41 + i + 1] - x[j * 41 + i] + y[(j + 1) * 40 + i] - y[j * 40 + i];
                assert!(divergence.abs() < 1e-4 * pair.fastest, "{divergence:e}");
            }
        }
        assert!(pair.fastest > 0.01);
    }
}

/// Frames that do not change, or hold nothing, have no flow.
#[test]
fn stillness_is_found() {
    let (cells, ends) = ([16, 12], boundaries("ww"));
    for params in some_params() {
        for frame in [vec![0.0; 192], smoke(&cells, 0.0)] {
            let found = track::<f32, D2>(
                &Serial,
                &in_cells(&cells, &ends),
                &params,
                &[frame.clone(), frame.clone(), frame],
            );
            assert!(
                found.flows.iter().flatten().flatten().all(|&x| x == 0.0),
                "{params:?}"
            );
        }
    }
}

/// Smoke that rests while all of it becomes brighter has a gradient that no flow without divergence follows: what is left of it is rounding, and no
/// flow is made of that. The same with smoke that appears from nothing, and with a motion far below the change in brightness.
#[test]
fn rounding_is_no_flow() {
    fn fastest<T: Real, S: Space>(cells: &[usize], frames: &[Vec<f64>]) -> f64 {
        let ends = boundaries(["ww", "www"][cells.len() - 2]);
        let found = track::<T, S>(&Serial, &in_cells(cells, &ends), &TrackParams::default(), frames);
        let speeds = found.flows.iter().flatten().flatten();
        speeds.fold(0.0, |most: f64, speed| most.max(speed.abs()))
    }
    fn both<S: Space>(what: &str, cells: &[usize], frames: &[Vec<f64>], most: f64) {
        let [single, double] = [fastest::<f32, S>(cells, frames), fastest::<f64, S>(cells, frames)];
        assert!(
            single < most && double < most,
            "{what} {cells:?}: {single} and {double}"
        );
    }
    let blob = |cells: &[usize], moved: f64, times: f64| -> Vec<f64> {
        let place = |cell: usize| {
            let (mut rest, mut squares) = (cell, 0.0);
            for (axis, &n) in cells.iter().enumerate() {
                let at = (rest % n) as f64 + 0.5 - 0.5 * n as f64 - if axis == 0 { moved } else { 0.0 };
                squares += (at / (0.2 * n as f64)).powi(2);
                rest /= n;
            }
            squares
        };
        (0..cells.iter().product())
            .map(|cell| times * (-place(cell)).exp())
            .collect()
    };
    for cells in [&[64usize, 96][..], &[16, 14, 12]] {
        let flicker: Vec<_> = [1.0, 1.05, 0.97].map(|times| blob(cells, 0.0, times)).into();
        let begun: Vec<_> = [0.0, 1.0, 1.0].map(|times| blob(cells, 0.0, times)).into();
        let slow: Vec<_> = [(0.0, 1.0), (1e-3, 1.05)]
            .map(|(moved, times)| blob(cells, moved, times))
            .into();
        for (what, frames, most) in [
            ("flicker", &flicker, 1e-3),
            ("begun", &begun, 1e-3),
            ("slow", &slow, 0.01),
        ] {
            if cells.len() == 2 {
                both::<D2>(what, cells, frames, most);
            } else {
                both::<D3>(what, cells, frames, most);
            }
        }
    }
}

/// Smoke that rests, to which a blob is added in every step: what was made, and the frames.
fn made(cells: &[usize; 2], frames: usize) -> (Vec<f64>, Vec<Vec<f64>>) {
    let still = smoke(cells, 0.0);
    let blob: Vec<f64> = (0..cells[0] * cells[1])
        .map(|cell| {
            let (x, y) = ((cell % cells[0]) as f64 - 14.0, (cell / cells[0]) as f64 - 12.0);
            0.5 * (-(x * x + y * y) / 12.0).exp()
        })
        .collect();
    let frame = |time: usize| {
        let both = still.iter().zip(&blob);
        both.map(|(still, blob)| still + time as f64 * blob).collect()
    };
    (blob.clone(), (0..frames).map(frame).collect())
}

/// Frames that rest but for what is made have no flow when that is known, and one when it is not; what is carried has it too.
#[test]
fn what_is_made_is_no_motion() {
    let (cells, ends) = ([36, 28], boundaries("ww"));
    let (blob, frames) = made(&cells, 4);
    for minimiser in [Minimiser::Direct, Minimiser::Admm, Minimiser::HornSchunck] {
        let params = TrackParams::of(minimiser);
        let fastest = |emission: bool| -> (f64, f64) {
            let capture = Capture {
                emission,
                ..in_cells(&cells, &ends)
            };
            let bytes = TrackPlan::new::<f64, D2>(&capture, &params).unwrap().bytes();
            let mut memory = Memory::new(bytes);
            let mut tracker = Tracker::<f64, D2>::new(&capture, &params, memory.block()).unwrap();
            let (mut fastest, mut apart) = (0.0_f64, 0.0_f64);
            for frame in &frames {
                let taken = if emission {
                    tracker.give_with_emission(&Serial, frame, &blob)
                } else {
                    tracker.give(&Serial, frame)
                };
                taken.unwrap();
                if tracker.is_ready() {
                    let pair = tracker.step(&Serial, &mut Silent, &mut |_, _| {}).unwrap();
                    fastest = fastest.max(pair.fastest);
                    apart = apart.max(pair.readvection);
                }
            }
            (fastest, apart)
        };
        let (with, without) = (fastest(true), fastest(false));
        assert!(
            with.0 < 1e-9 && with.1 < 1e-9,
            "{minimiser:?}: {with:?} cells a frame, and apart, where nothing moves"
        );
        assert!(
            without.0 > 0.01 && without.1 > 0.05,
            "{minimiser:?}: {without:?} without"
        );
    }
}

/// One field of cells more, no more; what is wrong is refused and changes nothing.
#[test]
fn emission_is_planned_and_checked() {
    let (cells, ends) = ([20, 16], boundaries("wp"));
    let params = TrackParams::default();
    let (blob, frames) = made(&cells, 3);
    let plain = in_cells(&cells, &ends);
    let capture = Capture {
        emission: true,
        ..plain
    };
    let bytes = TrackPlan::new::<f64, D2>(&capture, &params).unwrap().bytes();
    let before = TrackPlan::new::<f64, D2>(&plain, &params).unwrap().bytes();
    assert_eq!(bytes - before, (20 * 16 * 8_usize).next_multiple_of(64));
    let mut memory = Memory::new(bytes);
    assert!(Tracker::<f64, D2>::new(&capture, &params, &mut memory.block()[..bytes - 1]).is_err());
    let mut tracker = Tracker::<f64, D2>::new(&capture, &params, memory.block()).unwrap();
    tracker.give(&Serial, &frames[0]).unwrap();
    let mut wrong = blob.clone();
    wrong[7] = -1e-9;
    let refused = tracker.give_with_emission(&Serial, &frames[1], &wrong);
    assert_eq!(refused, Err(InputError::Negative { index: 7 }));
    wrong[7] = f64::NAN;
    let refused = tracker.give_with_emission(&Serial, &frames[1], &wrong);
    assert_eq!(refused, Err(InputError::NotFinite { index: 7 }));
    let refused = tracker.give_with_emission(&Serial, &frames[1], &blob[1..]);
    let length = InputError::Length {
        expected: 320,
        given: 319,
    };
    assert_eq!(refused, Err(length));
    assert!(!tracker.is_ready());
    tracker.give_with_emission(&Serial, &frames[1], &blob).unwrap();
    assert!(tracker.is_ready());
    let mut memory = Memory::new(before);
    let mut tracker = Tracker::<f64, D2>::new(&plain, &params, memory.block()).unwrap();
    let refused = tracker.give_with_emission(&Serial, &frames[0], &blob);
    assert_eq!(refused, Err(InputError::NoEmission));
    assert!(
        refused
            .unwrap_err()
            .to_string()
            .contains("`emission` must be set")
    );
}

/// A frame of which no flow was asked is passed over: what is found after it is the flow of the last two, once.
#[test]
fn frames_may_be_passed_over() {
    let (cells, ends) = ([34, 30], boundaries("ww"));
    let (capture, params) = (in_cells(&cells, &ends), TrackParams::default());
    let mut memory = Memory::new(TrackPlan::new::<f64, D2>(&capture, &params).unwrap().bytes());
    let mut tracker = Tracker::<f64, D2>::new(&capture, &params, memory.block()).unwrap();
    for time in 0..3 {
        tracker.give(&Serial, &smoke(&cells, f64::from(time))).unwrap();
    }
    assert!(tracker.is_ready());
    tracker.step(&Serial, &mut Silent, &mut |_, _| {}).unwrap();
    assert!(!tracker.is_ready());
}

/// Where nothing is made, all bits are those without.
#[test]
fn emission_of_nothing_changes_no_bit() {
    let (cells, ends) = ([34, 30], boundaries("wp"));
    let frames: Vec<Vec<f64>> = (0..3).map(|time| smoke(&cells, f64::from(time))).collect();
    let params = TrackParams::default();
    let bits = |emission: bool| -> Vec<u64> {
        let capture = Capture {
            emission,
            ..in_cells(&cells, &ends)
        };
        let bytes = TrackPlan::new::<f64, D2>(&capture, &params).unwrap().bytes();
        let mut memory = Memory::new(bytes);
        let mut tracker = Tracker::<f64, D2>::new(&capture, &params, memory.block()).unwrap();
        let (mut bits, nothing) = (Vec::new(), vec![0.0; 34 * 30]);
        for frame in &frames {
            if emission {
                tracker.give_with_emission(&Serial, frame, &nothing).unwrap();
            } else {
                tracker.give(&Serial, frame).unwrap();
            }
            if tracker.is_ready() {
                let mut keep = |_: Part, faces: thurible_core::track::Faces<'_, f64>| {
                    for axis in 0..2 {
                        let mut out = vec![0.0; faces.len(axis)];
                        faces.read(axis, &mut out);
                        bits.extend(out.into_iter().map(f64::to_bits));
                    }
                };
                tracker.step(&Serial, &mut Silent, &mut keep).unwrap();
            }
            bits.extend(tracker.carried().iter().map(|value| value.to_bits()));
        }
        bits
    };
    assert!(bits(true) == bits(false));
}

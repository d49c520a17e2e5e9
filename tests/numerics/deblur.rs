//! Deconvolution: exact changes of priors, residuals, memory, bits, and what comes out.

use crate::allocations::count;
use crate::fields::Memory;
use crate::fields::random::Random as Plain;
use thurible_core::deblur::{
    Blur, Clusters, Deblur, DeblurError, Frame, ImagePrior, Kernels, Moves, Patch, Restoration, Restorer,
    Tuning, change, change_patch, whole,
};
use thurible_core::{Named, Real};

const ALL: [ImagePrior; 7] = [
    ImagePrior::None,
    ImagePrior::Tv,
    ImagePrior::Atv,
    ImagePrior::Mtv,
    ImagePrior::Sparse,
    ImagePrior::Gamma,
    ImagePrior::Clusters,
];

#[test]
fn a_pixel_changes_a_prior_by_what_the_whole_says() {
    let mut plain = Plain::new(1);
    let mut clusters = Clusters {
        count: 3,
        mu: 0.7,
        ..Clusters::default()
    };
    for colour in &mut clusters.colours {
        *colour = core::array::from_fn(|_| plain.unit());
    }
    for channels in [1, 3] {
        let frame = Frame {
            width: 6,
            height: 5,
            channels,
            border: 1,
        };
        let planes: Vec<f64> = (0..frame.unknowns() * channels).map(|_| plain.unit()).collect();
        for prior in ALL {
            let before = whole(prior, &clusters, &frame, &planes);
            for place in 0..planes.len() {
                let mass = 0.3 * plain.unit();
                let found = change(prior, &clusters, &frame, &planes, place, mass);
                for (found, mass) in found.into_iter().zip([mass, -mass]) {
                    let mut after = planes.clone();
                    after[place] += mass;
                    let expected = whole(prior, &clusters, &frame, &after) - before;
                    assert!(
                        (found - expected).abs() < 1e-12 * before.max(1.0),
                        "{prior:?}, {channels} channels, {place}: {found} for {expected}"
                    );
                }
            }
        }
    }
}

/// The same of a rectangle that changes at once, at the edges too; and of one pixel what a pixel changes.
#[test]
fn a_patch_changes_a_prior_by_what_the_whole_says() {
    let mut plain = Plain::new(3);
    let mut clusters = Clusters {
        count: 3,
        mu: 0.7,
        ..Clusters::default()
    };
    for colour in &mut clusters.colours {
        *colour = core::array::from_fn(|_| plain.unit());
    }
    for channels in [1, 3] {
        let frame = Frame {
            width: 7,
            height: 6,
            channels,
            border: 2,
        };
        let planes: Vec<f64> = (0..frame.unknowns() * channels).map(|_| plain.unit()).collect();
        let mut draw = |count: usize| ((plain.unit() * count as f64) as usize).min(count - 1);
        for prior in ALL {
            let before = whole(prior, &clusters, &frame, &planes);
            for number in 0..80 {
                let size = if number == 0 {
                    [1; 2]
                } else {
                    [1 << draw(4), 1 << draw(4)]
                };
                let patch = Patch {
                    at: [draw(frame.wide() + 1 - size[0]), draw(frame.high() + 1 - size[1])],
                    size,
                    channel: draw(channels),
                };
                let mass = 0.1 + 0.02 * draw(10) as f64;
                let found = change_patch(prior, &clusters, &frame, &planes, &patch, mass);
                for (found, mass) in found.into_iter().zip([mass, -mass]) {
                    let mut after = planes.clone();
                    patch.places(&frame).for_each(|place| after[place] += mass);
                    let expected = whole(prior, &clusters, &frame, &after) - before;
                    assert!(
                        (found - expected).abs() < 1e-12 * before.max(1.0),
                        "{prior:?}, {channels} channels, {patch:?}: {found} for {expected}"
                    );
                }
                if size == [1; 2] {
                    let place = patch.places(&frame).next().unwrap();
                    let pixel = change(prior, &clusters, &frame, &planes, place, mass);
                    assert!((0..2).all(|sign| (pixel[sign] - found[sign]).abs() < 1e-12 * before.max(1.0)));
                }
            }
        }
    }
}

/// A lopsided kernel of radius 2.
fn kernel(seed: u64) -> Vec<f64> {
    let mut plain = Plain::new(seed);
    let values: Vec<f64> = (0..25).map(|_| plain.unit()).collect();
    let sum: f64 = values.iter().sum();
    values.iter().map(|value| value / sum).collect()
}

fn frame(channels: usize) -> Frame {
    Frame {
        width: 24,
        height: 20,
        channels,
        border: 2,
    }
}

/// Steps of brightness, with the border.
fn truth(frame: &Frame) -> Vec<f64> {
    (0..frame.unknowns() * frame.channels)
        .map(|place| {
            let (x, y) = (place % frame.wide(), place / frame.wide() % frame.high());
            let tint = 0.1 * (place / frame.unknowns()) as f64;
            0.1 + tint + 0.6 * f64::from(u8::from((8..18).contains(&x) && (6..16).contains(&y)))
        })
        .collect()
}

/// f * p by its definition: q(y) = sum over k of f(k) p(y - k).
fn blurred(frame: &Frame, kernels: &Kernels<'_>, planes: &[f64]) -> Vec<f64> {
    let radius = kernels.radius as isize;
    let side = kernels.side();
    let mut image = Vec::new();
    for plane in planes.chunks(frame.unknowns()) {
        for pixel in 0..frame.pixels() {
            let (x, y) = ((pixel % frame.width) as isize, (pixel / frame.width) as isize);
            let which = kernels.which.get(pixel).copied().unwrap_or(0) as usize;
            let mut sum = 0.0;
            for dy in -radius..=radius {
                for dx in -radius..=radius {
                    let number = (dy + radius) as usize * side + (dx + radius) as usize;
                    let from = (y - dy + radius) as usize * frame.wide() + (x - dx + radius) as usize;
                    sum += kernels.values[which * side * side + number] * plane[from];
                }
            }
            image.push(sum);
        }
    }
    image
}

fn several(frame: &Frame) -> (Vec<f64>, Vec<u16>) {
    let values = [kernel(1), kernel(2), kernel(3)].concat();
    let which = (0..frame.pixels())
        .map(|pixel| (pixel % frame.width * 3 / frame.width) as u16)
        .collect();
    (values, which)
}

#[test]
fn kernels_and_their_transpose_are_adjoint_and_as_defined() {
    let mut plain = Plain::new(5);
    let frame = frame(1);
    let (values, which) = several(&frame);
    for which in [&which[..], &[]] {
        let blur = Blur {
            frame,
            values: &values,
            which,
        };
        let p: Vec<f64> = (0..frame.unknowns()).map(|_| plain.signed()).collect();
        let r: Vec<f64> = (0..frame.pixels()).map(|_| plain.signed()).collect();
        let mask = vec![1; frame.pixels()];
        let (mut image, mut plane) = (vec![0.0; frame.pixels()], vec![0.0; frame.unknowns()]);
        blur.apply(&p, &mut image);
        blur.transpose(&r, &mask, &mut plane);
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        assert!((dot(&image, &r) - dot(&p, &plane)).abs() < 1e-12);
        let kernels = Kernels {
            radius: 2,
            values: &values,
            which,
        };
        let plainly = blurred(&frame, &kernels, &p);
        assert!(
            image
                .iter()
                .zip(&plainly)
                .all(|(one, other)| (one - other).abs() < 1e-13)
        );
    }
}

fn with<R>(problem: Deblur<'_>, image: &[f64], run: impl FnOnce(&mut Restoration<'_, f64>) -> R) -> R {
    let mut memory = Memory::new(Restoration::<f64>::bytes(&problem).unwrap());
    let mut found = Restoration::<f64>::new(problem, image, memory.block()).unwrap();
    run(&mut found)
}

/// The objective falls all along, and the residual stays q - f * p.
#[test]
fn the_objective_never_rises_and_the_residual_stays_true() {
    for (channels, moves) in [
        (1, Moves::Pixel),
        (3, Moves::Pixel),
        (1, Moves::Patch),
        (3, Moves::Patch),
    ] {
        let frame = frame(channels);
        let (values, which) = several(&frame);
        for prior in ALL {
            let kernels = Kernels {
                radius: 2,
                values: &values,
                which: &which,
            };
            let image = blurred(&frame, &kernels, &truth(&frame));
            let tuning = Tuning {
                prior,
                gamma: 1e-3,
                moves,
                budget: 12.0,
                saturation: Some(0.75),
                ..Tuning::default()
            };
            let problem = Deblur {
                frame,
                kernels,
                tuning,
            };
            with(problem, &image, |found| {
                let mut last = found.objective().iter().sum::<f64>();
                let (mut over, mut gathered) = (false, *found.clusters());
                while !over {
                    over = found.advance(97);
                    let now = found.objective().iter().sum::<f64>();
                    // Where colours are gathered again their distances are others.
                    if gathered == *found.clusters() {
                        assert!(now <= last * (1.0 + 1e-12), "{prior:?}: {now} after {last}");
                    }
                    (last, gathered) = (now, *found.clusters());
                }
                assert!(found.walked().recorded > if moves == Moves::Pixel { 500 } else { 200 });
                assert!(found.planes().iter().all(|&p| p >= 0.0));
                let again = blurred(&frame, &problem.kernels, found.planes());
                let off = image
                    .iter()
                    .zip(&again)
                    .zip(found.residual())
                    .map(|((q, seen), r)| (q - seen - r).abs());
                assert!(off.fold(0.0, f64::max) < 1e-11);
            });
        }
    }
}

/// After a million mutations the residual is q - f * p to rounding.
#[test]
fn the_residual_stays_true_for_a_million_mutations() {
    let frame = frame(1);
    let values = kernel(8);
    let kernels = Kernels {
        radius: 2,
        values: &values,
        which: &[],
    };
    let image = blurred(&frame, &kernels, &truth(&frame));
    let tuning = Tuning {
        prior: ImagePrior::None,
        nonnegative: false,
        budget: 1e6 / frame.unknowns() as f64 + 1.0,
        ..Tuning::default()
    };
    let problem = Deblur {
        frame,
        kernels,
        tuning,
    };
    with(problem, &image, |found| {
        while !found.advance(u64::MAX) {}
        let walked = found.walked();
        assert!(walked.mutations >= 1_000_000 && walked.recorded > 10_000);
        let again = blurred(&frame, &kernels, found.planes());
        let seen = image.iter().zip(&again).zip(found.residual());
        let off = seen.map(|((q, seen), r)| (q - seen - r).abs());
        assert!(off.fold(0.0, f64::max) < 1e-10);
    });
}

#[test]
fn bits_memory_and_allocations() {
    let frame = frame(1);
    let values = kernel(4);
    let kernels = Kernels {
        radius: 2,
        values: &values,
        which: &[],
    };
    let image = blurred(&frame, &kernels, &truth(&frame));
    let moves = Restorer::ALL.iter().map(|method| (method, Moves::Pixel));
    for (method, moves) in moves.chain([(&Restorer::Walk, Moves::Patch)]) {
        let tuning = Tuning {
            method: *method,
            moves,
            budget: 5.0,
            iterations: 3,
            ..Tuning::default()
        };
        let problem = Deblur {
            frame,
            kernels,
            tuning,
        };
        let bytes = Restoration::<f64>::bytes(&problem).unwrap();
        let mut small = Memory::new(bytes - 1);
        let refused = Restoration::<f64>::new(problem, &image, small.block()).err();
        assert_eq!(refused, Some(DeblurError::Memory { needed: bytes }));
        let run = |step: u64| {
            let mut memory = Memory::new(bytes);
            let before = count();
            let mut found = Restoration::<f64>::new(problem, &image, memory.block()).unwrap();
            while !found.advance(step) {}
            core::hint::black_box(found.objective());
            assert_eq!(count() - before, 0, "{method:?}");
            found.planes().iter().map(|p| p.to_bits()).collect::<Vec<u64>>()
        };
        assert_eq!(run(u64::MAX), run(11), "{method:?}");
    }
}

/// What comes out is nearer to the truth than what went in, by every method; and the walk's objective is about that of the convex
/// optimum.
#[test]
fn images_become_sharper() {
    let frame = frame(1);
    let values = kernel(6);
    let kernels = Kernels {
        radius: 2,
        values: &values,
        which: &[],
    };
    let sharp = truth(&frame);
    let image = blurred(&frame, &kernels, &sharp);
    let far = |value: &dyn Fn(usize) -> f64| -> f64 {
        let square = (0..frame.pixels()).map(|pixel| (value(pixel) - sharp[frame.bordered(pixel)]).powi(2));
        (square.sum::<f64>() / frame.pixels() as f64).sqrt()
    };
    let before = far(&|pixel| image[pixel]);
    let after = |tuning: Tuning| {
        with(
            Deblur {
                frame,
                kernels,
                tuning,
            },
            &image,
            |found| {
                while !found.advance(u64::MAX) {}
                let objective: f64 = found.objective().iter().sum();
                (far(&|pixel| found.planes()[frame.bordered(pixel)]), objective)
            },
        )
    };
    let atv = Tuning {
        prior: ImagePrior::Atv,
        gamma: 1e-3,
        ..Tuning::default()
    };
    let (walk, energy) = after(atv);
    let [(_, long), (_, patches)] = [Moves::Pixel, Moves::Patch].map(|moves| {
        after(Tuning {
            moves,
            budget: 300.0,
            ..atv
        })
    });
    let (convex, least) = after(Tuning {
        method: Restorer::PrimalDual,
        iterations: 2000,
        ..atv
    });
    let (lucy, _) = after(Tuning {
        method: Restorer::RichardsonLucy,
        iterations: 50,
        ..atv
    });
    let (wiener, _) = after(Tuning {
        method: Restorer::Wiener,
        iterations: 100,
        gamma: 1e-3,
        ..atv
    });
    assert!(
        walk < 0.3 * before && convex < 0.3 * before,
        "{walk} {convex} {before}"
    );
    assert!(
        lucy < 0.7 * before && wiener < 0.7 * before,
        "{lucy} {wiener} {before}"
    );
    assert!(energy < 1.1 * least && energy > 0.99 * least, "{energy} {least}");
    assert!(
        patches < long && patches - least < 0.7 * (long - least),
        "{patches} by patches, {long} by pixels, {least} the optimum"
    );
}

#[test]
fn what_cannot_be_is_refused() {
    let frame = frame(1);
    let values = kernel(4);
    let good = Deblur {
        frame,
        kernels: Kernels {
            radius: 2,
            values: &values,
            which: &[],
        },
        tuning: Tuning::default(),
    };
    assert_eq!(good.check(), Ok(()));
    let small = Deblur {
        frame: Frame { width: 4, ..frame },
        ..good
    };
    assert_eq!(small.check(), Err(DeblurError::KernelTooLarge));
    let bright: Vec<f64> = values.iter().map(|value| 2.0 * value).collect();
    let double = Deblur {
        kernels: Kernels {
            values: &bright,
            ..good.kernels
        },
        ..good
    };
    assert_eq!(double.check(), Err(DeblurError::KernelSum));
    let odd = vec![1; frame.pixels()];
    let which = Deblur {
        kernels: Kernels {
            which: &odd,
            ..good.kernels
        },
        ..good
    };
    assert_eq!(which.check(), Err(DeblurError::Which));
    let tuning = Tuning {
        tau: 1.0,
        ..good.tuning
    };
    assert!(matches!(
        Deblur { tuning, ..good }.check(),
        Err(DeblurError::Setting { name: "tau", .. })
    ));
    let mut memory = Memory::new(Restoration::<f32>::bytes(&good).unwrap());
    let mut image = vec![f32::ZERO; frame.pixels()];
    image[7] = f32::NAN;
    let refused = Restoration::<f32>::new(good, &image, memory.block()).err();
    assert_eq!(refused, Some(DeblurError::Image { at: Some(7) }));
    let tuning = Tuning {
        saturation: Some(0.5),
        ..good.tuning
    };
    let bright = vec![1.0_f32; frame.pixels()];
    let refused = Restoration::<f32>::new(Deblur { tuning, ..good }, &bright, memory.block()).err();
    assert_eq!(refused, Some(DeblurError::Saturated));
}

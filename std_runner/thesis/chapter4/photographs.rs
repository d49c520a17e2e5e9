//! Figures 4.3 to 4.7 and 4.9 to 4.12, and what the text says of speed.

use super::super::bench::{Bench, Halt};
use super::super::sheet::Sheet;
use super::images::{colours, lights, plumes, shapes, strokes};
use super::restored::{Way, richardson_lucy, walk};
use super::turned;
use thurible_core::deblur::{ImagePrior, Tuning};

/// Pixels along a side.
const SIDE: usize = 192;
/// Those of 0.7 million pixels.
const LARGE: usize = 836;

fn side(bench: &Bench<'_>, side: usize) -> usize {
    // A kernel must fit.
    bench.cells(&[side]).first().copied().unwrap_or(side).max(32)
}

/// What an image has at a place, and the whitest that a photograph shows.
type Scene = (&'static dyn Fn(usize, f64, f64) -> f64, f64);

/// Three photographs, each with three priors of the thesis' weights.
pub(super) fn figure_3(bench: &mut Bench<'_>, sheet: &mut Sheet) -> Result<(), Halt> {
    let side = side(bench, SIDE);
    let photographs: [(&str, &str, Scene, [f64; 2]); 3] = [
        (
            "strokes",
            "strokes, for the train: ",
            (&strokes, 1.0),
            [2.5e-4, 1e-3],
        ),
        ("lights", "lights, for the car: ", (&lights, 1.0), [5e-4, 1.5e-3]),
        (
            "plumes",
            "plumes, for the fountain: ",
            (&plumes, 1.0),
            [1e-4, 3e-3],
        ),
    ];
    for (whose, label, scene, [sparse, gamma]) in photographs {
        let photograph = bench.blur(whose, (side, 1), "motion:11,30".into(), scene)?;
        let masked = |way: Way| Way {
            tuning: Tuning {
                saturation: (whose == "lights").then_some(1.0),
                ..way.tuning
            },
            ..way
        };
        let ways = [
            richardson_lucy(),
            masked(walk("walk, sparse", ImagePrior::Sparse, sparse)),
            masked(walk("walk, gamma", ImagePrior::Gamma, gamma)),
            masked(walk("walk, TV", ImagePrior::Tv, 2.5e-4)),
        ];
        bench.restore(sheet, (whose, label), &photograph, &ways)?;
    }
    Ok(())
}

/// Out of focus.
pub(super) fn figure_9(bench: &mut Bench<'_>, sheet: &mut Sheet) -> Result<(), Halt> {
    let size = (side(bench, SIDE), 1);
    let photograph = bench.blur("defocus", size, "disc:5".into(), (&strokes, 1.0))?;
    let ways = [
        richardson_lucy(),
        walk("walk, sparse, the thesis' weight", ImagePrior::Sparse, 1e-3),
        walk("walk, TV", ImagePrior::Tv, 3e-4),
    ];
    bench.restore(sheet, ("defocus", ""), &photograph, &ways)
}

/// In colour, whose edges are charged once.
pub(super) fn figure_10(bench: &mut Bench<'_>, sheet: &mut Sheet) -> Result<(), Halt> {
    let size = (side(bench, SIDE), 3);
    let photograph = bench.blur("colour", size, "motion:11,30".into(), (&colours, 1.0))?;
    let ways = [
        richardson_lucy(),
        walk("walk, TV of each colour", ImagePrior::Tv, 3e-4),
        walk("walk, TV of all colours together", ImagePrior::Mtv, 3e-4),
    ];
    bench.restore(sheet, ("colour", ""), &photograph, &ways)
}

/// By a camera that was turned.
pub(super) fn figure_11(bench: &mut Bench<'_>, sheet: &mut Sheet) -> Result<(), Halt> {
    let side = side(bench, SIDE);
    let kernels = turned::kernels(bench, side)?;
    let psf = kernels.display().to_string();
    let photograph = bench.blur("turned", (side, 1), psf, (&strokes, 1.0))?;
    let ways = [
        richardson_lucy(),
        walk("walk, TV, a kernel for each place", ImagePrior::Tv, 3e-4),
    ];
    bench.restore(sheet, ("turned", ""), &photograph, &ways)
}

/// Five colours: total variation against clusters.
pub(super) fn figure_12(bench: &mut Bench<'_>, sheet: &mut Sheet) -> Result<(), Halt> {
    let size = (side(bench, 128), 3);
    let photograph = bench.blur("five_colours", size, "disc:4".into(), (&colours, 1.0))?;
    let ways = [
        Way {
            thesis: &[("thesis: PSNR, dB", "32.0 (text 31.91)")],
            ..walk("walk, TV", ImagePrior::Tv, 3e-4)
        },
        Way {
            thesis: &[("thesis: PSNR, dB", "32.7")],
            ..walk("walk, clusters", ImagePrior::Clusters, 3e-4)
        },
    ];
    bench.restore(sheet, ("five_colours", ""), &photograph, &ways)
}

/// Seconds of 0.7 million pixels and a kernel of 21 x 21, and how much is accepted.
pub(super) fn speed(bench: &mut Bench<'_>, sheet: &mut Sheet) -> Result<(), Halt> {
    let size = (side(bench, LARGE), 1);
    let photograph = bench.blur("speed", size, "disc:10".into(), (&shapes, 1.0))?;
    let ways = [Way {
        thesis: &[("thesis: seconds", "126"), ("thesis: accepted, %", "30 to 40")],
        ..walk("walk, TV, 100 mutations a pixel", ImagePrior::Tv, 3e-4)
    }];
    bench.restore(sheet, ("speed", ""), &photograph, &ways)
}

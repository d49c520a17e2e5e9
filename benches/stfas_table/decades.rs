//! Seconds that a decade of the residual takes: with the outside-face term alone, and with the mass of the cells beside too.

use crate::common::rate::asymptotic;
use crate::common::{size, sure};
use crate::residuals::{FLOOR, cycles};
use thurible_bench::navier_stokes::Case;
use thurible_bench::timing::timed;
use thurible_core::nso::Nso;
use thurible_core::nso::surroundings::Surroundings;
use thurible_core::{Colours, D2, D3, Serial, Silent, Space};

/// Cycles of which the fastest counts.
const TIMED: usize = 7;

/// What was measured with a smoother.
struct Measured {
    ratio: f64,
    seconds: f64,
}

impl Measured {
    /// Seconds of a cycle over the decades that it gains.
    fn per_decade(&self) -> f64 {
        if self.ratio < 1.0 {
            -self.seconds / self.ratio.log10()
        } else {
            f64::INFINITY
        }
    }
}

/// The box and steps of letter_f and a small case in 3D, at three Courant numbers.
pub fn decades() {
    println!(
        "{:<36}{:^28}{:^28}",
        "", "outside-face term alone", "with the mass of cells beside"
    );
    println!(
        "{:<36}{}{}{:>8}",
        "",
        ["ratio", "s/cycle", "s/decade"]
            .map(|title| format!("{title:>9}"))
            .concat(),
        ["ratio", "s/cycle", "s/decade"]
            .map(|title| format!("{title:>9}"))
            .concat(),
        "quotient"
    );
    let mut product = 1.0;
    let speeds = [2.0, 3.0, 5.0];
    for courant in speeds {
        product *= row::<D2>(&Case::new(&[128, 128], 40, courant));
    }
    for courant in speeds {
        product *= row::<D3>(&Case::new(&[32, 32, 32], 20, courant));
    }
    println!(
        "geometric mean of the quotients: {:.2}",
        f64::powf(product, 1.0 / 6.0)
    );
}

/// One row; returns the quotient of the seconds per decade.
fn row<S: Space>(case: &Case) -> f64 {
    let pair = [
        Surroundings::outside_alone::<S>(Colours::RedBlack),
        Surroundings::WITH_MASS,
    ]
    .map(|surroundings| Case {
        surroundings,
        ..case.clone()
    });
    let seconds = seconds::<S>(&pair);
    let ratios = pair
        .each_ref()
        .map(|case| asymptotic(&cycles::<S>(&Serial, case), FLOOR));
    let measured = [0, 1].map(|i| Measured {
        ratio: ratios[i],
        seconds: seconds[i],
    });
    let quotient = measured[1].per_decade() / measured[0].per_decade();
    let columns = measured
        .iter()
        .map(|m| format!("{:>9.3}{:>9.4}{:>9.4}", m.ratio, m.seconds, m.per_decade()))
        .collect::<String>();
    let name = format!(
        "{}, N = {}, Courant {}",
        size(&case.cells),
        case.steps,
        case.courant
    );
    println!("{name:<36}{columns}{quotient:>8.2}");
    quotient
}

/// Seconds of a cycle in f32 on one thread, in turns, so that a busy machine is as busy for both.
fn seconds<S: Space>([first, second]: &[Case; 2]) -> [f64; 2] {
    let mut least = [f64::INFINITY; 2];
    sure(first.pose::<f32, S, _>(&Serial, |first| {
        sure(second.pose::<f32, S, _>(&Serial, |second| {
            for _ in 0..TIMED {
                least[0] = least[0].min(cycle(first));
                least[1] = least[1].min(cycle(second));
            }
        }));
    }));
    least
}

fn cycle<S: Space>(nso: &mut Nso<'_, f32, S>) -> f64 {
    timed(|| {
        let _ = nso.vcycle(&Serial, &mut Silent);
    })
}

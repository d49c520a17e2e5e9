//! What the machine can do, measured in the same run as what is compared with it: a triad for its memory, multiplications and
//! additions for its arithmetic, and how long a value takes from thread to thread.

mod arithmetic;
mod latency;
mod triad;

pub use triad::gain;

use arithmetic::arithmetic;
use latency::handover;
use serde::Serialize;
use thurible::exit::Failure;
use thurible_core::{Exec, Serial};
use triad::triad;

/// What the machine did.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Machine {
    /// Threads of the run.
    pub threads: usize,
    /// What changes from minute to minute.
    #[serde(flatten)]
    pub moment: Moment,
    /// Bytes a second of the triad on one thread.
    pub triad_on_one: f64,
    /// Operations a second on one thread.
    pub flops_on_one: f64,
}

/// What the machine did at one time: other machines may share its processors.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Moment {
    /// Bytes a second of the triad.
    pub triad: f64,
    /// Multiplications and additions in f32 a second, as many of one as of the other, none fused.
    pub flops: f64,
    /// Seconds until one thread reads what another wrote; none where no two run at the same time.
    pub handover: Option<f64>,
}

impl Moment {
    /// Measures; `quick` in arrays that fit in a cache.
    ///
    /// # Errors
    /// [`Failure`]: there is no memory for them.
    pub fn measure(exec: &dyn Exec, quick: bool) -> Result<Self, Failure> {
        Ok(Self {
            triad: triad(exec, quick)?,
            flops: arithmetic(exec),
            handover: handover(exec),
        })
    }

    /// The mean of what was before and what is after something.
    #[must_use]
    pub fn mean(self, after: Self) -> Self {
        let handover = self
            .handover
            .zip(after.handover)
            .map(|(before, after)| 0.5 * (before + after));
        Self {
            triad: 0.5 * (self.triad + after.triad),
            flops: 0.5 * (self.flops + after.flops),
            handover,
        }
    }
}

impl Machine {
    /// Measures; `quick` in arrays that fit in a cache.
    ///
    /// # Errors
    /// [`Failure`]: there is no memory for them.
    pub fn measure(exec: &dyn Exec, quick: bool) -> Result<Self, Failure> {
        let moment = Moment::measure(exec, quick)?;
        Ok(Self {
            threads: exec.threads(),
            moment,
            triad_on_one: triad(&Serial, quick)?,
            flops_on_one: arithmetic(&Serial),
        })
    }

    /// All of it in a sentence.
    pub fn sentence(&self) -> String {
        let [triad, one, flops, one_flops] = [
            self.moment.triad,
            self.triad_on_one,
            self.moment.flops,
            self.flops_on_one,
        ]
        .map(|rate| rate / 1e9);
        let handover = self.moment.handover.map_or_else(String::new, |seconds| {
            format!(" From thread to thread in {:.0} ns.", 1e9 * seconds)
        });
        format!(
            "Triad a = b + 3 c in f32 on {} threads: {triad:.1} GB/s, on one {one:.1}. \
             Multiplications and additions in f32, not fused: {flops:.0} GFLOP/s, on one thread {one_flops:.0}.{handover}",
            self.threads
        )
    }
}

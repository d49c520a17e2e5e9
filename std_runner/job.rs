//! Everything about one solve but the solver itself.

use crate::destination::Destination;
use crate::inputs::Inputs;
use crate::plan::Planned;
use crate::progress::Mode;
use crate::report::Parts;
use crate::scene::Scene;

/// A solve that is ready to run.
pub struct Job {
    /// The scene.
    pub scene: Scene,
    /// Problem, parameters, precision and ledger.
    pub planned: Planned,
    /// What the solve starts from.
    pub inputs: Inputs,
    /// Where the result goes.
    pub destination: Destination,
    /// Bytes that the block really takes.
    pub footprint: usize,
    /// How progress is shown.
    pub mode: Mode,
    /// What is written beside the report.
    pub(crate) parts: Parts,
}

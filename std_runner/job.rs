//! Everything about one solve but the solver itself.

use crate::interrupt::Interrupt;
use crate::plan::Planned;
use crate::progress::Mode;
use crate::scene::Scene;
use crate::solve::Parts;
use std::path::PathBuf;

/// A solve that is ready to run.
pub struct Job {
    /// The scene.
    pub scene: Scene,
    /// Problem, parameters, precision and ledger.
    pub planned: Planned,
    /// A result from whose last step it goes on, in the place of the scene's source.
    pub from: Option<PathBuf>,
    /// Where the result goes.
    pub folder: PathBuf,
    /// Bytes that the block really takes.
    pub footprint: usize,
    /// How progress is shown.
    pub mode: Mode,
    /// What is written beside the report.
    pub(crate) parts: Parts,
    /// Who listens for Ctrl-C already, if somebody does.
    pub interrupt: Option<Interrupt>,
}

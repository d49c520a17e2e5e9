//! A request: what is to be solved, and with which options.

use super::earlier::Origin;
use crate::checkpoint::{Every, Found};
use crate::destination::Earlier;
use crate::devices::Searching;
use crate::exit::Failure;
use crate::interrupt::Interrupt;
use crate::live::Live;
use crate::plan::PlanOptions;
use crate::progress::{Clock, Display, Mode, Watch};
use crate::scene::Scene;
use serde_json::json;
use std::path::PathBuf;
use thurible_core::exec::Ranks;

/// How scenes are to be solved.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RunOptions {
    /// Precision, threads and memory.
    pub plan: PlanOptions,
    /// How progress is shown.
    pub mode: Mode,
    /// What stays in the result folder beside the report.
    pub outputs: Outputs,
    /// The programs that share the scene, where there are several.
    pub ranks: Option<&'static dyn Ranks>,
    /// The device that the search goes on, where that is no processor.
    pub device: Option<&'static dyn Searching>,
}

/// Which of the large parts of a result folder are wanted.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Outputs {
    /// Whether `result.npz` stays.
    pub arrays: bool,
    /// Whether frames and an animation are drawn.
    pub images: bool,
}

/// A scene to be solved.
pub(crate) struct Request {
    /// The checked scene.
    pub scene: Scene,
    /// The result folder.
    pub folder: PathBuf,
    /// A clock that was started before the scene was read.
    pub clock: Clock,
    /// The step of a result that the flow continues from, instead of the scene's source.
    pub from: Option<Origin>,
    /// The step of a result from which on its flow guides this one.
    pub reference: Option<Origin>,
    /// Listens for Ctrl-C; if there is none, the solve listens itself.
    pub interrupt: Option<Interrupt>,
    /// Ends the solve as converged where no density changes by more than this part of the largest at the start between two iterations.
    pub settled: Option<f64>,
    /// What becomes of a result that is in the folder.
    pub earlier: Earlier,
    /// Whether the state of a solve into the folder that was not finished may go.
    pub forced: bool,
    /// The port of a page on which it can be watched, 0 for any.
    pub watch: Option<u16>,
    /// How often the state is kept.
    pub checkpoint: Every,
    /// Whether keyframes and method of the scene's file are left out.
    pub free: bool,
    /// The state that the solve goes on from.
    pub found: Option<Found>,
}

impl Request {
    /// A scene that starts from its source.
    pub fn new(scene: Scene, folder: PathBuf, clock: Clock) -> Self {
        Self {
            scene,
            folder,
            clock,
            from: None,
            reference: None,
            interrupt: None,
            settled: None,
            earlier: Earlier::Replaced,
            forced: false,
            watch: None,
            checkpoint: Every::Off,
            free: false,
            found: None,
        }
    }

    /// What watches its solve, of at most so many iterations on the finest grid and on all; its page is open then, if there is one.
    ///
    /// # Errors
    /// The system lets nobody listen: for signals, or at the port.
    pub(crate) fn watched(&self, mode: Mode, [finest, all]: [usize; 2]) -> Result<Watch, Failure> {
        let interrupt = self.interrupt.clone().map_or_else(Interrupt::listen, Ok)?;
        let display = Display::new(mode, finest);
        if let Some(note) = self.found.as_ref().and_then(|found| found.note.as_ref()) {
            display.warning(note);
        }
        let live = match self.watch {
            Some(port) => {
                let title = self.scene.document.path().display().to_string();
                let live = Live::open(port, title, finest, interrupt.clone())?;
                display.event("watch", json!({ "address": live.address() }));
                display.note(&format!("watch it at {}", live.address()));
                Some(live)
            }
            None => None,
        };
        let mut watch = Watch::new(self.clock.clone(), display, all, interrupt);
        watch.live = live;
        Ok(watch)
    }
}

//! The page of a solve that runs: `--watch`. Frames and curves as they come, the time that is left, and a button that stops it.
//!
//! The server listens on the loopback address alone, and answers nobody who does not know the token in its address.

mod server;
mod shared;
mod state;
mod strip;

use crate::exit::Failure;
use crate::interrupt::Interrupt;
use crate::report::IterationRecord;
use core::time::Duration;
use server::Server;
use shared::Shared;
use state::State;
use std::sync::{Arc, Mutex};
use std::time::Instant;
use strip::strip;
pub(crate) use strip::{Held, Played};

/// Seconds from one drawing of the frames to the next, at least, and the most that they may take, in parts of the time between.
const OFTEN: f64 = 1.0;
const SHARE: f64 = 0.05;
/// How long the end of the solve waits for a page that is open to hear of it.
const FAREWELL: Duration = Duration::from_millis(1500);

/// A page that is there while it lives.
pub struct Live {
    shared: Arc<Shared>,
    server: Server,
    /// When frames were drawn last, and how long that took in seconds.
    drawn: Option<(Instant, f64)>,
}

impl Live {
    /// Opens the page of a solve of at most `limit` iterations, at `port` or at any free one where that is 0.
    ///
    /// # Errors
    /// The port is taken, or the system gives no random numbers or no thread.
    pub(crate) fn open(
        port: u16,
        title: String,
        limit: usize,
        interrupt: Interrupt,
    ) -> Result<Self, Failure> {
        let token = token()?;
        let listener = server::listen(port)?;
        let shared = Arc::new(Shared {
            state: Mutex::new(State::new(title, limit)),
            interrupt,
            token,
            port: listener.port(),
        });
        let server = listener.serve(Arc::clone(&shared))?;
        Ok(Self {
            shared,
            server,
            drawn: None,
        })
    }

    /// Where the page is.
    pub(crate) fn address(&self) -> String {
        format!("http://127.0.0.1:{}/{}/", self.shared.port, self.shared.token)
    }

    /// Shows an iteration, after which so many are `done` on the finest grid.
    pub(crate) fn iteration(&mut self, record: &IterationRecord, done: usize) {
        self.shared.state().iteration(record, done);
    }

    /// Whether frames may be drawn again.
    pub(crate) fn wants_frames(&self) -> bool {
        self.drawn
            .is_none_or(|(when, took)| when.elapsed().as_secs_f64() >= OFTEN.max(took / SHARE))
    }

    /// Draws some of the first `steps` of `played`, which count on from `first`, and shows them; what they took was `begun` then.
    pub(crate) fn draw(&mut self, begun: Instant, played: &mut dyn Played, first: usize, steps: usize) {
        // What cannot be drawn is not shown; the solve goes on.
        if let Ok(drawn) = strip(played, first, steps) {
            self.shared.state().frames(drawn);
        }
        self.drawn = Some((Instant::now(), begun.elapsed().as_secs_f64()));
    }

    /// Tells those who look how it ended, and closes the page.
    pub(crate) fn end(self, how: &str) {
        self.shared.state().end(how);
        let since = Instant::now();
        while self.shared.state().is_watched() && since.elapsed() < FAREWELL {
            std::thread::sleep(Duration::from_millis(20));
        }
        self.server.close();
    }
}

/// 128 random bits in hexadecimal.
fn token() -> Result<String, Failure> {
    let mut bytes = [0; 16];
    getrandom::fill(&mut bytes).map_err(|error| {
        Failure::Input(format!(
            "--watch: the system gives no random numbers: {error}; leave the option out"
        ))
    })?;
    Ok(bytes.iter().map(|byte| format!("{byte:02x}")).collect())
}

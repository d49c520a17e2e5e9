//! What the page shows.

use crate::report::IterationRecord;
use core::time::Duration;
use serde_json::{Value, json};
use std::time::Instant;

/// A page that has not asked for so long is closed.
const GONE: Duration = Duration::from_secs(3);

/// What the page shows.
pub(super) struct State {
    /// The scene.
    pub title: String,
    /// All iterations so far.
    pub history: Vec<IterationRecord>,
    /// Iterations on the finest grid at most, and those so far.
    limit: usize,
    done: usize,
    /// The latest frames, each with its step, and how often there were new ones.
    frames: Vec<(usize, Vec<u8>)>,
    drawings: usize,
    /// When the last iteration ended.
    since: Instant,
    /// How it ended.
    over: Option<String>,
    /// When the page asked last, and whether it has heard of the end.
    asked: Option<Instant>,
    heard: bool,
    /// Whether somebody has pressed the button.
    pub stopped: bool,
}

impl State {
    pub fn new(title: String, limit: usize) -> Self {
        Self {
            title,
            history: Vec::new(),
            limit,
            done: 0,
            frames: Vec::new(),
            drawings: 0,
            since: Instant::now(),
            over: None,
            asked: None,
            heard: false,
            stopped: false,
        }
    }

    pub fn iteration(&mut self, record: &IterationRecord, done: usize) {
        self.history.push(record.clone());
        (self.done, self.since) = (done, Instant::now());
    }

    pub fn frames(&mut self, frames: Vec<(usize, Vec<u8>)>) {
        self.frames = frames;
        self.drawings += 1;
    }

    /// A frame of the strip.
    pub fn frame(&self, index: usize) -> Option<&[u8]> {
        self.frames.get(index).map(|(_, png)| png.as_slice())
    }

    pub fn end(&mut self, how: &str) {
        self.over = Some(how.to_owned());
    }

    /// Whether a page is open that has not heard of the end.
    pub fn is_watched(&self) -> bool {
        !self.heard && self.asked.is_some_and(|asked| asked.elapsed() < GONE)
    }

    /// All of it in numbers; whoever asks has heard of it.
    pub fn told(&mut self) -> Value {
        self.asked = Some(Instant::now());
        self.heard = self.over.is_some();
        let last = self.history.last();
        let left = last.and_then(|last| last.seconds_left);
        let since = self.since.elapsed().as_secs_f64();
        json!({
            "done": self.done,
            "limit": self.limit,
            "iterations": self.history.len(),
            "level": last.and_then(|last| last.level.as_ref()),
            "objective": last.map(|last| last.objective),
            "seconds": last.map_or(0.0, |last| last.seconds) + since,
            "seconds_left": left.map(|left| (left - since).max(0.0)),
            "frames": self.frames.iter().map(|(step, _)| step).collect::<Vec<_>>(),
            "drawings": self.drawings,
            "stopped": self.stopped,
            "over": self.over,
        })
    }
}

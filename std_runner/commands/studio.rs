//! Steps of a result, drawn one after the other into a folder.

use crate::bytes::rounded;
use crate::console;
use crate::destination::Destination;
use crate::exit::{DONE, Failure, INTERRUPTED};
use crate::interrupt::Interrupt;
use crate::output::{Film, Movie, OutputError, Reel, Shot, write_bytes};
use crate::progress::{Clock, Display, Mode, in_words};
use crate::refine::{Apart, Finer, in_words as in_words_of};
use clap::ValueEnum;
use core::ops::RangeInclusive;
use serde_json::json;
use std::path::Path;

/// What tells that a folder holds pictures of ours.
const MARK: &str = "render.json";

/// What is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Format {
    /// A PNG file for each step.
    Png,
    /// An OpenEXR file for each step.
    Exr,
    /// A film, made by ffmpeg.
    Mp4,
    /// A film that pages show as a picture: lossless WebP.
    Webp,
}

impl Format {
    /// The file of a film.
    fn film(self) -> Option<&'static str> {
        match self {
            Self::Png | Self::Exr => None,
            Self::Mp4 => Some("render.mp4"),
            Self::Webp => Some("render.webp"),
        }
    }
}

/// Draws steps into a folder.
pub(super) struct Studio {
    format: Format,
    shot: Shot,
    /// Pictures of a film a second.
    pace: f64,
    display: Display,
    destination: Destination,
    interrupt: Interrupt,
    clock: Clock,
    /// Pictures so far.
    done: usize,
    /// Steps so far, those included that are only passed.
    passed: usize,
}

/// What pictures are taken of.
pub(super) struct Set<'m> {
    pub reel: Reel,
    /// The same on finer cells.
    pub finer: Option<Finer<'m>>,
}

impl Set<'_> {
    /// Says which finer cells there are, what they take, and what was found in files.
    fn announce(&self, display: &Display) {
        let Some(finer) = &self.finer else { return };
        finer.notes.iter().for_each(|note| display.file_note(note));
        let (cells, bytes) = (finer.cells(), finer.bytes);
        display.event("finer", json!({ "cells": cells, "bytes": bytes }));
        display.note(&format!(
            "on {} cells: {} for the flow and the smoke of a step, whatever the number of steps",
            in_words_of(cells),
            rounded(bytes)
        ));
    }
}

impl Studio {
    /// Writes into `folder`.
    ///
    /// # Errors
    /// As [`Destination::check_for`].
    pub(super) fn new(
        folder: &Path,
        (format, pace): (Format, f64),
        shot: Shot,
        display: Display,
    ) -> Result<Self, Failure> {
        Ok(Self {
            format,
            shot,
            pace,
            display,
            destination: Destination::check_for(folder, MARK, Vec::new())?,
            interrupt: Interrupt::listen()?,
            clock: Clock::start(),
            done: 0,
            passed: 0,
        })
    }

    /// Draws `steps`, or those before the user asked to stop; the answer is the exit code.
    pub(super) fn render(mut self, mut set: Set<'_>, steps: RangeInclusive<usize>) -> Result<u8, Failure> {
        let first = *steps.start();
        set.announce(&self.display);
        if let Some(finer) = &set.finer {
            self.note(finer.apart(&mut set.reel)?, false);
        }
        let mark = self.mark(&set);
        let drawn = match self.format.film() {
            Some(name) => self.film(&mut set, (name, &mark), steps),
            None => self.files(&mut set, &mark, steps),
        };
        self.display.close();
        drawn?;
        self.announce(first);
        Ok(if self.interrupt.asked() { INTERRUPTED } else { DONE })
    }

    /// What the folder says of its pictures.
    fn mark(&self, set: &Set<'_>) -> String {
        let Shot {
            width,
            height,
            angles,
            gain,
            detail,
        } = self.shot;
        let deep = set.reel.cells().len() == 3;
        let facts = json!({
            "format": 1,
            "size": [width, height],
            "fps": self.format.film().map(|_| self.pace),
            "exposure": gain.log2(),
            "camera": deep.then_some([angles.azimuth, angles.elevation]),
            "detail": deep.then_some(detail),
            "cells": set.finer.as_ref().map_or(set.reel.cells(), Finer::cells),
        });
        format!("{facts:#}\n")
    }

    /// The light of a step; nothing where the user asked to stop on the way there.
    fn take(&mut self, set: &mut Set<'_>, step: usize) -> Result<Option<Film>, Failure> {
        if let Some(finer) = &mut set.finer {
            while finer.step() < step {
                if self.interrupt.asked() {
                    return Ok(None);
                }
                finer.follow(&mut set.reel)?;
                let now = finer.step();
                let is_key = |step: usize| set.reel.keyframes().contains(&step);
                if is_key(now) {
                    let is_held = is_key(now - 1);
                    self.note(finer.apart(&mut set.reel)?, is_held);
                }
                if now < step {
                    self.passed(&format!("smoke carried to step {now}"));
                }
            }
        }
        if self.interrupt.asked() {
            return Ok(None);
        }
        let still = set.finer.as_ref().map(Finer::still);
        Ok(Some(set.reel.expose(step, still, &self.shot)?))
    }

    /// A file for each step, in place as soon as it is whole.
    fn files(&mut self, set: &mut Set<'_>, mark: &str, steps: RangeInclusive<usize>) -> Result<(), Failure> {
        self.destination
            .add(|folder| write_bytes(&folder.join(MARK), mark.as_bytes()))?;
        for step in steps {
            let Some(film) = self.take(set, step)? else { break };
            let (ending, bytes) = match self.format {
                Format::Exr => ("exr", film.to_exr()),
                _ => ("png", {
                    let picture = film.develop().to_png();
                    let failed = OutputError::of(Path::new("frame"));
                    picture.map_err(|error| Failure::File(failed(error).to_string()))?
                }),
            };
            let name = format!("frame_{step:04}.{ending}");
            self.destination
                .add(|folder| write_bytes(&folder.join(&name), &bytes))?;
            self.told(step, &name);
        }
        Ok(())
    }

    /// One film, which is in place when it is whole. What was drawn until somebody asked to stop is one; after a failure there is one only where there
    /// was none before, and without a picture there is none.
    fn film(
        &mut self,
        set: &mut Set<'_>,
        (name, mark): (&str, &str),
        steps: RangeInclusive<usize>,
    ) -> Result<(), Failure> {
        let mut destination = self.destination.clone();
        let had_one = destination.folder().join(name).exists();
        let (mut failure, mut given_up) = (None, false);
        let made = destination.add(|folder| {
            let path = folder.join(name);
            let mut movie = Movie::begin(&path, [self.shot.width, self.shot.height], self.pace)?;
            for step in steps.clone() {
                match self.take(set, step) {
                    Ok(Some(film)) => movie.push(&film.develop())?,
                    Ok(None) => break,
                    Err(error) => {
                        failure = Some(error);
                        break;
                    }
                }
                self.told(step, name);
            }
            given_up = self.done == 0 || (failure.is_some() && had_one);
            if given_up {
                movie.give_up();
                // Nothing of it comes into the folder.
                return Err(OutputError::Source(Failure::File(String::new())));
            }
            movie.finish()?;
            write_bytes(&folder.join(MARK), mark.as_bytes())
        });
        self.destination = destination;
        let drawn = failure.map_or(Ok(()), Err);
        if given_up { drawn } else { made.and(drawn) }
    }

    /// Notes that a step is drawn, and says how long the others take.
    fn told(&mut self, step: usize, name: &str) {
        self.done += 1;
        let seconds = self.clock.total();
        self.display
            .event("frame", json!({ "step": step, "seconds": seconds, "file": name }));
        self.passed(&format!("step {step}"));
    }

    /// Says that a piece of work is over, and how long the others take.
    fn passed(&mut self, what: &str) {
        self.passed += 1;
        let left = self.display.limit().saturating_sub(self.passed);
        let left = in_words(left as f64 * self.clock.total() / self.passed as f64);
        self.display.piece(self.passed, &format!("{what}, {left} left"));
    }

    /// Says how far the smoke of finer cells is from that of the result, at the beginning or a keyframe; nothing where there is none yet.
    /// Of a keyframe that is held people hear the first step.
    fn note(&self, apart: Apart, is_held: bool) {
        let Apart { step, relative_l2 } = apart;
        if relative_l2 == 0.0 {
            return;
        }
        self.display
            .event("keyframe", json!({ "step": step, "relative_l2": relative_l2 }));
        if is_held {
            return;
        }
        self.display.note(&format!(
            "step {step}: the smoke of the finer cells is {:.1} % from that of the result",
            100.0 * relative_l2
        ));
    }

    fn announce(&self, first: usize) {
        let folder = self.destination.shown().display();
        let Shot { width, height, .. } = self.shot;
        let (done, seconds) = (self.done, self.clock.total());
        let file = match self.format.film() {
            Some(name) => format!("{folder} as {name}"),
            None => folder.to_string(),
        };
        let stopped = if self.interrupt.asked() {
            "interrupted: "
        } else {
            ""
        };
        let steps = match done {
            0 => "no step".into(),
            1 => format!("step {first}"),
            _ => format!("steps {first} to {}", first + done - 1),
        };
        self.display.event(
            "render",
            json!({ "frames": done, "size": [width, height], "seconds": seconds, "folder": folder.to_string() }),
        );
        if self.display.mode() == Mode::Human {
            console::print(&format!(
                "{stopped}{steps} of {width} x {height} pixels in {}: {file}",
                in_words(seconds)
            ));
        }
    }
}

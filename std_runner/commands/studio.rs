//! Steps of a result, drawn one after the other into a folder.

use crate::console;
use crate::destination::Destination;
use crate::exit::{DONE, Failure, INTERRUPTED};
use crate::interrupt::Interrupt;
use crate::output::{Movie, OutputError, Reel, Shot, write_bytes};
use crate::progress::{Clock, Display, Mode, in_words};
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
    display: Display,
    destination: Destination,
    interrupt: Interrupt,
    clock: Clock,
    /// Pictures so far.
    done: usize,
}

impl Studio {
    /// Writes into `folder`.
    ///
    /// # Errors
    /// As [`Destination::check_for`].
    pub(super) fn new(folder: &Path, format: Format, shot: Shot, display: Display) -> Result<Self, Failure> {
        Ok(Self {
            format,
            shot,
            display,
            destination: Destination::check_for(folder, MARK, Vec::new())?,
            interrupt: Interrupt::listen()?,
            clock: Clock::start(),
            done: 0,
        })
    }

    /// Draws `steps`, or those before the user asked to stop; the answer is the exit code.
    pub(super) fn render(mut self, mut reel: Reel, steps: RangeInclusive<usize>) -> Result<u8, Failure> {
        let first = *steps.start();
        self.mark(&reel)?;
        let drawn = match self.format.film() {
            Some(name) => self.film(&mut reel, name, steps),
            None => self.files(&mut reel, steps),
        };
        self.display.close();
        drawn?;
        self.announce(first);
        Ok(if self.interrupt.asked() { INTERRUPTED } else { DONE })
    }

    /// Says in the folder what its pictures are of.
    fn mark(&mut self, reel: &Reel) -> Result<(), Failure> {
        let Shot {
            width,
            height,
            angles,
            gain,
            detail,
        } = self.shot;
        let deep = reel.cells().len() == 3;
        let facts = json!({
            "format": 1,
            "size": [width, height],
            "exposure": gain.log2(),
            "camera": deep.then_some([angles.azimuth, angles.elevation]),
            "detail": deep.then_some(detail),
        });
        let text = format!("{facts:#}\n");
        self.destination
            .add(|folder| write_bytes(&folder.join(MARK), text.as_bytes()))
    }

    /// A file for each step, in place as soon as it is whole.
    fn files(&mut self, reel: &mut Reel, steps: RangeInclusive<usize>) -> Result<(), Failure> {
        for step in steps {
            if self.interrupt.asked() {
                break;
            }
            let failed = |error: OutputError| Failure::File(error.to_string());
            let film = reel.expose(step, &self.shot).map_err(failed)?;
            let (ending, bytes) = match self.format {
                Format::Exr => ("exr", film.to_exr()),
                _ => ("png", {
                    let picture = film.develop();
                    picture
                        .to_png()
                        .map_err(OutputError::of(Path::new("frame")))
                        .map_err(failed)?
                }),
            };
            let name = format!("frame_{step:04}.{ending}");
            self.destination
                .add(|folder| write_bytes(&folder.join(&name), &bytes))?;
            self.told(step, &name);
        }
        Ok(())
    }

    /// One film, which is in place when it is whole.
    fn film(&mut self, reel: &mut Reel, name: &str, steps: RangeInclusive<usize>) -> Result<(), Failure> {
        let mut destination = self.destination.clone();
        let made = destination.add(|folder| {
            let mut movie = Movie::begin(&folder.join(name), self.shot.width, self.shot.height)?;
            for step in steps.clone() {
                if self.interrupt.asked() {
                    break;
                }
                movie.push(&reel.expose(step, &self.shot)?.develop())?;
                self.told(step, name);
            }
            movie.finish()
        });
        self.destination = destination;
        made
    }

    /// Notes that a step is drawn, and says how long the others take.
    fn told(&mut self, step: usize, name: &str) {
        self.done += 1;
        let seconds = self.clock.total();
        self.display
            .event("frame", json!({ "step": step, "seconds": seconds, "file": name }));
        let left = self.display.limit().saturating_sub(self.done);
        let left = in_words(left as f64 * seconds / self.done as f64);
        self.display
            .piece(self.done, &format!("step {step}, {left} left"));
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

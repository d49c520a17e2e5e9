//! The steps of a result, one after the other, into every format that is asked for. Ranks share them: each writes every so many-th step into the same folder.

use super::forecast::Forecast;
use super::orient::{Orientation, Up};
use super::request::{Format, Request, Written, earlier, facts};
use super::sink::{Manner, Sink, TimeScale};
use super::source::Source;
use super::vdb::Codec;
use super::{fga, npz, volume, vti, zarr};
use crate::among::{agreed, shared_folder};
use crate::bytes::{are_free, rounded};
use crate::console;
use crate::destination::Destination;
use crate::exit::{DONE, Failure, INTERRUPTED};
use crate::interrupt::Interrupt;
use crate::output::{OutputError, write_bytes};
use crate::plan::size_in_words;
use crate::progress::{Display, Mode};
use crate::report::number;
use core::ops::RangeInclusive;
use half::f16;
use serde_json::json;
use std::path::{Path, PathBuf};
use thurible_core::exec::Ranks;
use thurible_core::exec::ranks::{Alone, joined, tell};

/// What tells that a folder holds an export.
const MARK: &str = "export.json";
/// The optical depth of a quarter of the box where smoke of the largest density hides 95 % of what is behind.
const OPAQUE: f64 = 3.0;

/// What to do where ranks do not see the folder.
const SHARED: &str = "export into a folder that all machines share, with -o DIR";

/// Writes what `request` asks for; the answer is the exit code.
pub(crate) fn run(request: &Request) -> Result<u8, Failure> {
    let mut source = Source::open(&request.result)?;
    let steps = steps(request, &source)?;
    let up = request.up.unwrap_or(Up::Z);
    let manner = Manner {
        orientation: Orientation::new(source.said.cells.len(), up),
        up,
        time: TimeScale::of(source.said.dt, request.fps),
        first_frame: request.first_frame,
        half: request.half.unwrap_or(true),
        codec: request.codec.unwrap_or(Codec::Blosc),
    };
    check(request, &source)?;
    let packed = [Format::Zarr, Format::Npz];
    let packed = request.formats.iter().any(|format| packed.contains(format));
    let bytes = source.bytes(request.staggered, packed);
    let ranks = request.ranks.unwrap_or(&Alone);
    if !are_free(bytes.saturating_mul(ranks.on_this_machine())) {
        return Err(Failure::Memory(format!(
            "a step of {} cells takes {}, which the system has not; close other programs",
            size_in_words(&source.said.cells),
            rounded(bytes)
        )));
    }
    let mut sinks = sinks(request, &source, &manner, *steps.start())?;
    let parts: Vec<PathBuf> = sinks.iter().flat_map(|sink| sink.parts()).collect();
    let follows = ranks.rank() > 0;
    let mode = if follows { Mode::Quiet } else { request.mode };
    let (display, interrupt) = (Display::new(mode, steps.clone().count()), Interrupt::listen()?);
    let later = sinks.iter().map(|sink| sink.later(&steps)).sum();
    let mut run = Run {
        forecast: Forecast::new(steps.clone().count(), later),
        shown: &request.folder,
        sinks: &mut sinks,
        source: &mut source,
        display: &display,
        interrupt: &interrupt,
        ranks,
    };
    if follows {
        let folder = shared_folder(ranks, Path::new(""), SHARED)?;
        let written = run.steps(&folder, steps, request.staggered);
        return written.map(|_| DONE).map_err(failure);
    }
    // Folders of an earlier export may be there, whose files are looked at one by one.
    let new = parts.iter().filter(|part| !request.folder.join(part).is_dir());
    let planned = new.cloned().chain([MARK.into()]).collect();
    let mut destination = Destination::check_for(&request.folder, MARK, planned)?;
    announce(request, run.source, &display, [bytes, steps.clone().count()]);
    let earlier = earlier(&request.folder.join(MARK), request);
    let stays = |file: &Path| !parts.iter().any(|part| file.starts_with(part));
    let written = destination.exchange(&stays, |folder| {
        shared_folder(ranks, folder, SHARED).map_err(OutputError::Source)?;
        let written = run.steps(folder, steps.clone(), request.staggered)?;
        run.finish(folder, &written)?;
        let mut facts = facts(request, &manner, run.source, &written);
        facts["earlier"] = earlier.clone();
        write_bytes(&folder.join(MARK), format!("{facts:#}\n").as_bytes())?;
        Ok(written)
    });
    display.close();
    let written = written?;
    let is_half = manner.half && request.writes_volumes();
    if is_half && written.largest > 0.0 && written.largest < f64::from(f16::MIN_POSITIVE) {
        display.warning(&format!(
            "the densest smoke is {:.1e}, of which half precision keeps less than three digits, and of the rest less: write --precision float, or denser smoke",
            written.largest
        ));
    }
    ended(&display, &destination, &written, &manner, &interrupt)
}

/// An export on its way.
struct Run<'a, 'm> {
    forecast: Forecast,
    /// The folder, as the user knows it.
    shown: &'a Path,
    sinks: &'a mut [Box<dyn Sink + 'm>],
    source: &'a mut Source,
    display: &'a Display,
    interrupt: &'a Interrupt,
    ranks: &'a dyn Ranks,
}

impl Run<'_, '_> {
    /// Writes `steps`, or those before the user asked to stop, the first at least; of those that are written a rank every so many-th.
    fn steps(
        &mut self,
        folder: &Path,
        steps: RangeInclusive<usize>,
        staggered: bool,
    ) -> Result<Written, OutputError> {
        let (first, end, count) = (*steps.start(), *steps.end(), self.ranks.count());
        let (mut next, mut largest) = (first, 0.0_f64);
        while next <= end && (next == first || !self.is_to_stop()) {
            let step = next + self.ranks.rank();
            let written = match self.look_ahead(folder, next - first) {
                Ok(()) if step <= end => self.step(folder, step, staggered),
                ahead => ahead.map(|()| 0.0),
            };
            largest = largest.max(self.all_of(written)?);
            for step in next..=end.min(next + count - 1) {
                self.display.event("step", json!({ "step": step }));
                self.display.piece(step - first + 1, &format!("step {step}"));
            }
            next += count;
        }
        let largest = joined(self.ranks, largest, f64::max);
        let depth = 0.25 * self.source.said.length * largest;
        Ok(Written {
            steps: first..=end.min(next - 1),
            largest,
            shader: if depth > 0.0 { OPAQUE / depth } else { 1.0 },
        })
    }

    /// Whether what is left finds room behind the `done` steps; the first rank looks.
    fn look_ahead(&mut self, folder: &Path, done: usize) -> Result<(), OutputError> {
        if self.ranks.rank() > 0 {
            return Ok(());
        }
        let checked = self.forecast.check(folder, self.shown, done);
        checked.map_err(OutputError::Source)
    }

    /// Writes what is said of all steps, which are there.
    fn finish(&mut self, folder: &Path, written: &Written) -> Result<(), OutputError> {
        self.sinks
            .iter_mut()
            .try_for_each(|sink| sink.finish(folder, self.source, written.steps.clone()))
    }

    /// Writes a step; its largest density.
    fn step(&mut self, folder: &Path, step: usize, staggered: bool) -> Result<f64, OutputError> {
        let frame = self.source.frame(step, staggered).map_err(OutputError::Source)?;
        for sink in self.sinks.iter_mut() {
            sink.step(folder, self.source, &frame)?;
        }
        Ok(frame.density.iter().copied().fold(0.0, f64::max))
    }

    /// What this rank has, when all have theirs, or what went wrong in one of them: no rank writes any more then.
    fn all_of(&self, own: Result<f64, OutputError>) -> Result<f64, OutputError> {
        if self.ranks.count() == 1 {
            return own;
        }
        agreed(self.ranks, own.map_err(failure)).map_err(OutputError::Source)
    }

    /// Whether the user asked the first rank to stop.
    fn is_to_stop(&self) -> bool {
        let mut asked = [u8::from(self.interrupt.asked())];
        tell(self.ranks, 0, &mut asked);
        asked == [1]
    }
}

/// How an export ends that could not be written.
fn failure(error: OutputError) -> Failure {
    match error {
        OutputError::Source(failure) => failure,
        other => Failure::File(other.to_string()),
    }
}

/// The steps that are asked for.
fn steps(request: &Request, source: &Source) -> Result<RangeInclusive<usize>, Failure> {
    let steps = request.steps.clone().unwrap_or(0..=source.steps());
    if *steps.end() > source.steps() {
        return Err(Failure::Input(format!(
            "--steps {}..{}: the result has the steps 0 to {}; name some of those",
            steps.start(),
            steps.end(),
            source.steps()
        )));
    }
    Ok(steps)
}

/// Refuses what the result has nothing for.
fn check(request: &Request, source: &Source) -> Result<(), Failure> {
    let lacks = |option: &str| {
        source.refuse(&format!(
            "has no velocity, which {option} writes; leave it out, or export a result with a flow"
        ))
    };
    if request.formats.contains(&Format::Fga) && !source.has_flow() {
        return Err(lacks("--format fga"));
    }
    let volumes = request.writes_volumes();
    let turned = volumes || request.formats.contains(&Format::Fga);
    let options = [
        ("--staggered", request.staggered, volumes, "vdb or usd"),
        ("--precision", request.half.is_some(), volumes, "vdb or usd"),
        ("--compression", request.codec.is_some(), volumes, "vdb or usd"),
        ("--up", request.up.is_some(), turned, "vdb, usd or fga"),
    ];
    for (option, given, matters, formats) in options {
        if given && !matters {
            return Err(Failure::Input(format!(
                "{option} is of {formats}, which are not written; add one to --format, or leave {option} out"
            )));
        }
    }
    if request.staggered && !source.has_flow() {
        return Err(lacks("--staggered"));
    }
    if request.staggered && source.said.centred {
        return Err(source.refuse("has its velocity in cells and not on faces; leave --staggered out"));
    }
    Ok(())
}

fn sinks<'m>(
    request: &Request,
    source: &Source,
    manner: &'m Manner,
    first: usize,
) -> Result<Vec<Box<dyn Sink + 'm>>, Failure> {
    let mut formats = request.formats.clone();
    formats.sort_unstable();
    formats.dedup();
    let stage = formats.contains(&Format::Usd);
    // A stage shows volumes, which are written with it.
    formats.retain(|&format| format != Format::Vdb || !stage);
    let sink = |format: Format| -> Result<Box<dyn Sink + 'm>, Failure> {
        Ok(match format {
            Format::Vdb | Format::Usd => Box::new(volume::Volumes { manner, stage }),
            Format::Vti => Box::new(vti::Images(manner)),
            Format::Zarr => Box::new(zarr::Group::of(source, first)?),
            Format::Fga => Box::new(fga::Fields(manner)),
            Format::Npz => Box::new(npz::Archive::of(source)?),
        })
    };
    formats.into_iter().map(sink).collect()
}

fn announce(request: &Request, source: &Source, display: &Display, [bytes, count]: [usize; 2]) {
    let (names, cells) = (request.names(), &source.said.cells);
    display.event(
        "plan",
        json!({ "command": "export", "formats": names, "cells": cells, "steps": count, "bytes": bytes }),
    );
    display.note(&format!(
        "export of {} as {}: {} cells, {count} steps, {} for one, whatever their number",
        request.result.display(),
        names.join(", "),
        size_in_words(cells),
        rounded(bytes)
    ));
}

/// Says how it ended; the exit code.
fn ended(
    display: &Display,
    destination: &Destination,
    written: &Written,
    manner: &Manner,
    interrupt: &Interrupt,
) -> Result<u8, Failure> {
    let (folder, fps) = (destination.shown().display().to_string(), manner.time.fps);
    let [first, last] = [written.steps.start(), written.steps.end()].map(|step| manner.frame(*step));
    display.event(
        "export",
        json!({ "folder": folder, "frames": [first, last], "fps": fps, "shader_density": written.shader }),
    );
    if display.mode() == Mode::Human {
        let stopped = if interrupt.asked() { "interrupted: " } else { "" };
        console::print(&format!(
            "{stopped}frames {first} to {last} at {fps} a second in {folder}; a shader with density {} makes the smoke opaque",
            number(written.shader)
        ));
    }
    Ok(if interrupt.asked() { INTERRUPTED } else { DONE })
}

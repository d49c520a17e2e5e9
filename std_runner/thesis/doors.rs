//! The doors by which runs are made: those of `simulate`, `guide`, `track`, `readvect`, `remap`, `photograph`, `tomography` and `deblur`.

use super::bench::{Bench, Halt, Made};
use crate::commands::options::Options;
use crate::destination::Destination;
use crate::exit::DONE;
use crate::flows::{self, Deed};
use crate::output::{OutputError, Plain, write_arrays, write_bytes};
use crate::progress::Clock;
use crate::run::{Origin, Outputs, Request};
use crate::scene::{Document, Scene};
use crate::tomography::{self, Rig};
use crate::track::{self, CaptureScene};
use crate::{deblur, threads};
use std::path::{Path, PathBuf};
use std::rc::Rc;
use thurible_core::{Method, Status};

/// A scene that nobody steers.
pub(super) struct Free<'a> {
    /// The scene, as a file would have it, and the folder that its paths start from.
    pub text: String,
    pub beside: &'a Path,
    /// The result and its step that the flow goes on from, instead of the scene's source,
    pub from: Option<(&'a Path, usize)>,
    /// and the one whose flow is followed.
    pub reference: Option<(&'a Path, usize)>,
}

impl Bench<'_> {
    /// As `thurible simulate`, or with a reference `thurible guide`.
    pub(super) fn simulate(&mut self, name: &str, free: &Free<'_>) -> Result<Rc<Made>, Halt> {
        self.once(name, |bench, folder| {
            let path = free.beside.join(format!("{}.toml", name.replace('/', "_")));
            let method = match free.reference {
                Some(_) => Method::Guide,
                None => Method::Simulate,
            };
            let scene = Scene::free_of(Document::parse(&path, free.text.clone())?)?.flow_by(method, false);
            let options = bench.options.run(Outputs {
                arrays: true,
                images: false,
            });
            let origin = |option| {
                move |(folder, step): (&Path, usize)| Origin {
                    option,
                    folder: folder.to_owned(),
                    step: Some(step),
                }
            };
            let outcome = options.solve(Request {
                from: free.from.map(origin("--from")),
                reference: free.reference.map(origin("--reference")),
                interrupt: Some(bench.interrupt.clone()),
                ..Request::new(scene, folder.to_owned(), Clock::start())
            })?;
            // A flow that became too fast to follow.
            if outcome.record.status == Status::Stalled {
                let why = outcome.record.remarks.first().cloned();
                return Err(Halt::Failed(why.unwrap_or_else(|| "stalled".into())));
            }
            Ok(outcome.exit_code())
        })
    }

    /// As `thurible track` on an archive of frames; `sets` are those of `--set`.
    pub(super) fn track(&mut self, name: &str, archive: &Path, sets: &[String]) -> Result<Rc<Made>, Halt> {
        self.once(name, |bench, folder| {
            let sets: Vec<(String, String)> = sets
                .iter()
                .map(|set| (format!("--set {set}"), set.clone()))
                .collect();
            let scene = CaptureScene::load(archive, &sets)?;
            let planned = track::planned(&scene, &bench.options.plan())?;
            let request = track::Request {
                scene,
                folder: folder.to_owned(),
                mode: bench.options.mode(),
                clock: Clock::start(),
            };
            Ok(track::run(&request, planned)?)
        })
    }

    /// As `thurible readvect` or `thurible remap`.
    pub(super) fn take(&mut self, name: &str, from: (&Path, usize), deed: Deed) -> Result<Rc<Made>, Halt> {
        self.once(name, |bench, folder| {
            let resources = &bench.options.resources;
            Ok(flows::run(&flows::Request {
                deed,
                at: from.1,
                from: from.0.to_owned(),
                folder: folder.to_owned(),
                precision: resources.precision,
                threads: bench.threads(),
                limit: resources.memory_limit,
                mode: resources.mode(),
            })?)
        })
    }

    /// As `thurible photograph`; the folder is that of `name`.
    pub(super) fn photograph(&mut self, name: &str, rig: Rig) -> Result<Rc<Made>, Halt> {
        self.once(name, |bench, folder| {
            let rig = Rig {
                folder: folder.to_owned(),
                ..rig
            };
            let count = bench.threads();
            threads::with(count, || {
                threads::together(count, |exec| tomography::photograph(&rig, exec))
            })??;
            Ok(DONE)
        })
    }

    /// As `thurible tomography`; `sets` are those of `--set`.
    pub(super) fn tomography(&mut self, name: &str, views: &Path, sets: &[String]) -> Result<Rc<Made>, Halt> {
        self.once(name, |bench, folder| {
            let options = Options {
                resources: bench.options.resources.clone(),
                set: sets.to_vec(),
            };
            Ok(tomography::reconstruct(&tomography::Request {
                views,
                folder: folder.to_owned(),
                plan: false,
                options: &options,
            })?)
        })
    }

    /// As `thurible deblur`; the folder is that of `name`.
    pub(super) fn deblur(&mut self, name: &str, request: deblur::Request) -> Result<Rc<Made>, Halt> {
        self.once(name, |bench, folder| {
            Ok(deblur::restore(&deblur::Request {
                folder: folder.to_owned(),
                limit: bench.options.resources.memory_limit,
                mode: bench.options.mode(),
                ..request
            })?)
        })
    }

    /// Files that runs read, written by `write` into the folder of `name`.
    pub(super) fn files(
        &mut self,
        name: &str,
        files: &[&str],
        write: impl FnMut(&Path) -> Result<(), OutputError>,
    ) -> Result<Rc<Made>, Halt> {
        self.once(name, |_, folder| {
            let mut destination = Bench::data(folder, files)?;
            destination.fill(marked(write))?;
            Ok(DONE)
        })
    }

    /// An archive `file` of arrays, each with its counts along x, y and so on.
    pub(super) fn write_arrays(
        &mut self,
        name: &str,
        file: &str,
        arrays: &[(&str, &[usize], &[f64])],
    ) -> Result<Rc<Made>, Halt> {
        self.files(name, &[file], |folder| put(&folder.join(file), arrays))
    }

    /// A folder for `files` that are no result.
    pub(super) fn data(folder: &Path, files: &[&str]) -> Result<Destination, Halt> {
        let files = files.iter().copied().chain([MARK]).map(PathBuf::from);
        Ok(Destination::check_for(folder, MARK, files.collect())?)
    }

    fn threads(&self) -> usize {
        let given = self.options.resources.threads;
        given.unwrap_or_else(threads::available)
    }
}

/// What tells that a folder holds data of ours.
const MARK: &str = "data.json";

/// What `write` writes, and the mark beside it.
pub(super) fn marked(
    mut write: impl FnMut(&Path) -> Result<(), OutputError>,
) -> impl FnMut(&Path) -> Result<(), OutputError> {
    move |folder| {
        write(folder)?;
        write_bytes(&folder.join(MARK), b"{ \"format\": 1 }\n")
    }
}

/// Writes the archive `path` of arrays, each with its counts along x, y and so on.
pub(super) fn put(path: &Path, arrays: &[(&str, &[usize], &[f64])]) -> Result<(), OutputError> {
    let arrays = arrays.iter().map(|(name, counts, values)| Plain {
        name: (*name).into(),
        shape: counts.iter().rev().copied().collect(),
        parts: vec![*values],
    });
    write_arrays(path, &arrays.collect::<Vec<_>>())
}

//! One scene by several methods, one after the other in this process.

use super::figures::{Figures, descends, ends};
use super::staggered::{self, Staggered, staggered};
use super::words::listed;
use crate::console;
use crate::destination::remove_written;
use crate::exit::{DONE, FILE, Failure, worse};
use crate::interrupt::Interrupt;
use crate::progress::{Clock, Mode};
use crate::report::{ARCHIVE, RunRecord};
use crate::run::{Outcome, Outputs, Request, RunOptions};
use crate::scene::{Document, Scene};
use crate::solves;
use serde_json::{Value, json};
use std::path::Path;
use thurible_core::method::registry::takes;
use thurible_core::{Feature, Method, Named};

/// A scene once for each method that solves it.
pub(crate) struct Lineup {
    /// The scene with each of the methods, in their order.
    pub scenes: Vec<Scene>,
    /// What was changed so that all solve the same problem.
    pub note: Option<String>,
    /// A method that ends where no density changes by more than this part of the largest between two iterations.
    pub settled: Option<(Method, f64)>,
}

/// The same scene, as `document` has it for each method. Each is checked and planned here, so that nothing is refused after hours of solving.
pub(crate) fn scenes_by_method(
    document: impl Fn(&str) -> Result<Document, Failure>,
    methods: &[String],
    options: &RunOptions,
) -> Result<Lineup, Failure> {
    if let Some(twice) = methods
        .iter()
        .enumerate()
        .find(|(index, name)| methods[..*index].contains(name))
    {
        return Err(Failure::Input(format!(
            "--methods {}: \"{}\" is named twice; name each method once",
            methods.join(","),
            twice.1
        )));
    }
    let scene = |name: &String| scene_by(document(name)?, name);
    let mut scenes = methods.iter().map(scene).collect::<Result<Vec<_>, _>>()?;
    let note = price_alike(&mut scenes);
    for scene in &scenes {
        solves::check(scene, &options.plan)?;
        if scene.method.fluids.chosen {
            staggered::check(scene, &options.plan)?;
        }
    }
    Ok(Lineup {
        scenes,
        note,
        settled: None,
    })
}

/// The scene of `document` by the method `name`.
pub(crate) fn scene_by(mut document: Document, name: &str) -> Result<Scene, Failure> {
    document.replace(format!("--methods {name}"), "method.name", name.into())?;
    Scene::of(document)
}

/// Where some of the methods cannot price curls and the smoothness is automatic, it becomes 0 for all: an objective with a price of curls
/// is not to be compared with one without. The sentence says so.
fn price_alike(scenes: &mut [Scene]) -> Option<String> {
    let automatic =
        |scene: &Scene| scene.control.smoothness.is_none() && scene.advection.scheme.smoothness() > 0.0;
    // What Stable Fluids find is priced as the direct method does it.
    let (able, unable): (Vec<&Scene>, Vec<&Scene>) = scenes
        .iter()
        .partition(|scene| scene.method.fluids.chosen || takes(&scene.method.params, Feature::Smoothness));
    if unable.is_empty() || !able.into_iter().any(automatic) {
        return None;
    }
    let unable: Vec<&str> = unable
        .iter()
        .map(|scene| scene.method.params.method.name())
        .collect();
    let note = format!(
        "{} cannot price curls, so all methods solve with `control.smoothness` 0, not with the {} that goes with this transport",
        listed(&unable),
        scenes.first()?.advection.scheme.smoothness()
    );
    for scene in scenes.iter_mut() {
        scene.control.smoothness = Some(0.0);
    }
    Some(note)
}

/// A method without a row in the table.
pub(crate) struct Lost {
    pub method: String,
    /// Why, as a sentence.
    pub why: String,
    /// The exit code that goes with it.
    code: u8,
}

/// What the methods made of a scene.
#[derive(Default)]
pub(crate) struct Comparison {
    /// Methods with a result, in order.
    pub solved: Vec<Outcome>,
    /// The results of another simulator on the grid of the others, at the places of `solved`.
    pub staggered: Vec<Option<Staggered>>,
    /// Methods without a result.
    pub failed: Vec<Lost>,
    /// What was changed so that all solve the same problem.
    pub note: Option<String>,
}

impl Comparison {
    /// Solves each scene of `lineup` into a folder below `folder` that has its method's name; stops when the user interrupts it.
    pub fn run(
        lineup: Lineup,
        methods: &[String],
        options: &RunOptions,
        folder: &Path,
        interrupt: &Interrupt,
    ) -> Result<Self, Failure> {
        let mut comparison = Self {
            note: lineup.note,
            ..Self::default()
        };
        if let (Some(note), Mode::Human) = (&comparison.note, options.mode) {
            console::print(&format!("note: {note}"));
        }
        for (scene, method) in lineup.scenes.into_iter().zip(methods) {
            if interrupt.asked() {
                break;
            }
            let rule = lineup.settled.filter(|(of, _)| *of == scene.method.params.method);
            let request = Request {
                interrupt: Some(interrupt.clone()),
                settled: rule.map(|(_, part)| part),
                ..Request::new(scene, folder.join(method), Clock::start())
            };
            match solved(request, options) {
                Ok((outcome, brought)) => {
                    comparison.staggered.push(brought);
                    comparison.solved.push(outcome);
                }
                Err(Broken::Method(why, code)) => {
                    console::error(&format!("thurible: {method}: {why}"));
                    let method = method.clone();
                    comparison.failed.push(Lost { method, why, code });
                }
                Err(Broken::All(failure)) => return Err(failure),
            }
        }
        Ok(comparison)
    }

    /// The records of the results.
    pub fn records(&self) -> impl Iterator<Item = &RunRecord> {
        self.solved.iter().map(|solved| &solved.record)
    }

    /// The rows of the table: of another simulator what it comes to on the grid of the others.
    pub fn figures(&self) -> Vec<Figures> {
        let ends = self.ends();
        let rows = self.records().zip(&self.staggered);
        rows.map(|(record, staggered)| Figures::of(record, staggered.as_ref(), ends))
            .collect()
    }

    /// The least objective, and the largest of those that descend to it.
    fn ends(&self) -> (f64, f64) {
        let totals = self.records().zip(&self.staggered).map(|(record, staggered)| {
            let objective = staggered.map_or(record.objective, |found| found.objective);
            (objective.total(), staggered.is_none() && descends(record))
        });
        ends(totals)
    }

    /// The comparison as JSON: the least objective, the rows of the table, what failed, and what was changed.
    pub fn facts(&self) -> Value {
        let failed: Value = self
            .failed
            .iter()
            .map(|lost| json!({ "method": lost.method, "why": lost.why }))
            .collect();
        json!({ "best": self.ends().0, "rows": self.figures(), "failed": failed, "note": self.note })
    }

    /// The exit code of a comparison that was not interrupted.
    pub fn exit_code(&self) -> u8 {
        let failed = self.failed.iter().map(|lost| lost.code);
        let codes = self.solved.iter().map(Outcome::exit_code).chain(failed);
        codes.fold(DONE, worse)
    }
}

/// What ends with a solve that comes to nothing.
enum Broken {
    /// That method alone, for this reason and with this exit code.
    Method(String, u8),
    /// All that is left.
    All(Failure),
}

/// Solves the scene of `request`; what another simulator found is brought to the grid of the others, too.
fn solved(request: Request, options: &RunOptions) -> Result<(Outcome, Option<Staggered>), Broken> {
    let (scene, folder) = (request.scene.clone(), request.folder.clone());
    let elsewhere = scene.method.fluids.chosen;
    let with_arrays = RunOptions {
        outputs: Outputs {
            arrays: options.outputs.arrays || elsewhere,
            ..options.outputs
        },
        ..*options
    };
    let outcome = solves::solve(&with_arrays, request).map_err(|failure| match failure {
        Failure::NotFinite(_) => Broken::Method(failure.to_string(), failure.code()),
        other => Broken::All(other),
    })?;
    if !elsewhere {
        return Ok((outcome, None));
    }
    let not_compared = |why: &str, code: u8| {
        let folder = folder.display();
        Broken::Method(
            format!("what it found, for {folder}, cannot be compared on the grid of the others: {why}"),
            code,
        )
    };
    if outcome.diverted {
        return Err(not_compared("it was written elsewhere", FILE));
    }
    let brought = staggered(&scene, &folder, &options.plan)
        .map_err(|failure| not_compared(&failure.to_string(), failure.code()));
    if !options.outputs.arrays {
        remove_written(&folder, ARCHIVE).map_err(Broken::All)?;
    }
    Ok((outcome, Some(brought?)))
}

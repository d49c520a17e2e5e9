//! One scene by several methods, one after the other in this process.

use super::figures::{Figures, ends};
use crate::console;
use crate::exit::Failure;
use crate::interrupt::Interrupt;
use crate::plan;
use crate::progress::{Clock, Mode};
use crate::report::RunRecord;
use crate::scene::{Document, Scene};
use crate::solve::{Finished, Order, Start};
use std::path::Path;

/// The same scene once for each method, checked and planned: what would be refused is refused before anything is solved.
pub(crate) fn entries(document: &Document, methods: &[String], order: &Order) -> Result<Vec<Scene>, Failure> {
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
    let entry = |name: &String| {
        let mut document = document.clone();
        document.replace(format!("--methods {name}"), "method.name", name.as_str().into())?;
        let scene = Scene::of(document)?;
        plan::choose(&scene, &order.wishes)?;
        Ok(scene)
    };
    methods.iter().map(entry).collect()
}

/// What the methods made of a scene.
#[derive(Default)]
pub(crate) struct Contest {
    /// Those that came to a result, in order.
    pub solved: Vec<Finished>,
    /// Those that did not: the method and why.
    pub failed: Vec<(String, String)>,
}

impl Contest {
    /// Solves each entry into a folder of its method's name below `folder`, until the user says stop.
    pub fn hold(
        entries: Vec<Scene>,
        methods: &[String],
        order: &Order,
        folder: &Path,
        interrupt: &Interrupt,
    ) -> Result<Self, Failure> {
        let mut contest = Self::default();
        for (scene, method) in entries.into_iter().zip(methods) {
            if interrupt.asked() {
                break;
            }
            match order.solve(
                scene,
                folder.join(method),
                Clock::start(),
                Start {
                    interrupt: Some(interrupt.clone()),
                    ..Start::default()
                },
            ) {
                Ok(solved) => contest.solved.push(solved),
                Err(Failure::NotFinite(why)) => {
                    if order.mode != Mode::Quiet {
                        console::error(&format!("thurible: {method}: {why}"));
                    }
                    contest.failed.push((method.clone(), why));
                }
                Err(other) => return Err(other),
            }
        }
        Ok(contest)
    }

    /// The records of the results.
    pub fn records(&self) -> impl Iterator<Item = &RunRecord> {
        self.solved.iter().map(|solved| &solved.record)
    }

    /// The least objective of the results.
    pub fn best(&self) -> f64 {
        ends(self.records()).0
    }

    /// The rows of the table.
    pub fn figures(&self) -> Vec<Figures> {
        let ends = ends(self.records());
        self.records().map(|record| Figures::of(record, ends)).collect()
    }
}

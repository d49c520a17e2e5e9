//! `thurible paper`: the scenes of the paper's Table 2 and figures, on one page beside the paper's own figures.

use super::options::{MethodList, Options, Overwriting};
use super::words::Words;
use crate::bytes::rounded;
use crate::compare::{Comparison, listed, publish, scene_by};
use crate::console;
use crate::exit::{DONE, Failure, worse};
use crate::interrupt::Interrupt;
use crate::paper::{self, Entry, SECTIONS, Selection, SolvedScene};
use crate::plan::size_in_words;
use crate::progress::{Display, Mode};
use crate::quoted::Scale;
use crate::run::{Outputs, RunOptions};
use crate::scene::Scene;
use crate::solves;
use clap::Args;
use serde_json::{Value, json};
use std::path::PathBuf;

/// The name of the page and of its facts.
const STEM: &str = "paper";

/// Arguments of `paper`.
#[derive(Args, Debug)]
pub struct PaperArguments {
    /// Which of them; all of Table 2 if none is named. --list shows the names.
    #[arg(value_name = "NAME", value_parser = Words(paper::known().words()), hide_possible_values = true)]
    pub names: Vec<String>,
    /// Print the names and what they are, and solve nothing.
    #[arg(long)]
    pub list: bool,
    /// The paper's cells along each axis times this: 1, 1/2, 1/4 or 1/8; the steps stay.
    #[arg(long, value_name = "S", default_value = "1", value_parser = Scale::parse)]
    pub scale: Scale,
    /// The methods that solve them.
    #[command(flatten)]
    pub methods: MethodList,
    /// Keep result.npz of every solve too; at full size they are gigabytes.
    #[arg(long)]
    pub arrays: bool,
    /// Leave pictures and curves out of paper.md; paper.html keeps them.
    #[arg(long)]
    pub no_pictures: bool,
    /// The common options.
    #[command(flatten)]
    pub options: Options,
    /// What becomes of a page and results that are there.
    #[command(flatten)]
    pub overwriting: Overwriting,
    /// Where the page and the result folders go.
    #[arg(short, long, value_name = "DIR", default_value = "out/paper")]
    pub output: PathBuf,
}

/// Solves the paper's scenes and writes the page; the answer is the exit code.
pub fn run(arguments: &PaperArguments) -> Result<u8, Failure> {
    let options = arguments.options.run(Outputs {
        arrays: arguments.arrays,
        images: false,
    });
    let selection = arguments.selection();
    if arguments.list {
        return list(arguments, &options);
    }
    let sections = selection.sections()?;
    let planned = selection.scenes(&sections, &arguments.output, &options)?;
    let earlier = arguments.overwriting.earlier();
    let mut folder = publish::prepare(&arguments.output, STEM, earlier)?;
    planned.iter().try_for_each(|planned| {
        let images = options.outputs.images;
        publish::check_below(
            (&planned.folder, earlier),
            &planned.methods,
            &planned.lineup.scenes,
            images,
        )
    })?;
    let interrupt = Interrupt::listen()?;
    let mut solved = Vec::new();
    for planned in planned {
        if interrupt.asked() {
            break;
        }
        solved.push(SolvedScene {
            entry: planned.entry,
            comparison: Comparison::run(
                planned.lineup,
                &planned.methods,
                &options,
                &planned.folder,
                &interrupt,
            )?,
        });
        // After each scene, so that the page of a long run can be read meanwhile, and stays if the run is stopped.
        let mut page = paper::page(&sections, &solved, arguments.scale);
        page.pictures = !arguments.no_pictures;
        publish::write(&mut folder, STEM, &page, &facts(&solved, arguments.scale))?;
    }
    let table = format!("{}\n{}\n", paper::table(&solved).plain(), paper::verdict::RULE);
    let facts = facts(&solved, arguments.scale);
    publish::announce(options.mode, &folder, STEM, &table, facts);
    Ok(publish::code(&folder, &interrupt, exit_code(&solved)))
}

impl PaperArguments {
    fn selection(&self) -> Selection<'_> {
        Selection {
            names: &self.names,
            methods: &self.methods.methods,
            scale: self.scale,
            sets: &self.options.set,
        }
    }

    /// The first method that an entry is solved by, if there is one, its scene by that, and the bytes that its block takes.
    fn needs(&self, entry: &Entry, options: &RunOptions) -> Result<Option<(String, Scene, usize)>, Failure> {
        let Some(method) = entry.methods(&self.methods.methods).into_iter().next() else {
            return Ok(None);
        };
        let document = entry.document(self.scale, &self.options.set, &method)?;
        let scene = scene_by(document, &method)?;
        let bytes = solves::bytes(&scene, &options.plan)?;
        Ok(Some((method, scene, bytes)))
    }
}

/// The worst exit code of all scenes.
fn exit_code(solved: &[SolvedScene]) -> u8 {
    let codes = solved.iter().map(|scene| scene.comparison.exit_code());
    codes.fold(DONE, worse)
}

fn facts(solved: &[SolvedScene], scale: Scale) -> Value {
    let scene = |scene: &SolvedScene| {
        let mut facts = scene.comparison.facts();
        facts["name"] = scene.entry.name.into();
        let verdicts = scene.comparison.figures().into_iter();
        let verdicts = verdicts.map(|figures| paper::verdict::failed(scene.entry, Some(&figures)));
        if let Some(rows) = facts["rows"].as_array_mut() {
            rows.iter_mut()
                .zip(verdicts)
                .for_each(|(row, why)| row["failed"] = why.into());
        }
        facts
    };
    json!({ "format": 1, "scale": scale.name(), "scenes": solved.iter().map(scene).collect::<Vec<_>>() })
}

/// Prints the names, and the memory that each scene takes by the first method.
fn list(arguments: &PaperArguments, options: &RunOptions) -> Result<u8, Failure> {
    for section in SECTIONS {
        if options.mode != Mode::Json {
            console::print(&format!("{:<10}{}", section.name, section.title));
        }
        for entry in section.members() {
            let needs = arguments.needs(entry, options)?;
            if options.mode == Mode::Json {
                let mut fields = json!({ "section": section.name, "name": entry.name, "title": entry.about });
                if let Some((method, scene, bytes)) = needs {
                    fields["method"] = method.into();
                    fields["cells"] = scene.grid.cells.into();
                    fields["steps"] = scene.time.steps.into();
                    fields["bytes"] = bytes.into();
                }
                Display::new(Mode::Json, 0).event("scene", fields);
                continue;
            }
            let needs = needs.map_or_else(
                || format!("only by {}", listed(entry.only)),
                |(method, scene, bytes)| {
                    let cells = size_in_words(&scene.grid.cells);
                    format!(
                        "{cells}, {} steps, {} by {method}",
                        scene.time.steps,
                        rounded(bytes)
                    )
                },
            );
            console::print(&format!(
                "{:<10}  {:<18}{:<40}{needs}",
                "", entry.name, entry.about
            ));
        }
    }
    if options.mode == Mode::Json {
        return Ok(DONE);
    }
    paper::known()
        .lines()
        .iter()
        .for_each(|line| console::print(line));
    Ok(DONE)
}

//! What a state belongs to: the scene and the options of its solve, whole enough to go on without the scene's file.

use super::inputs::{Input, check_for_more};
use crate::among::told;
use crate::exit::Failure;
use crate::report::{ARCHIVE, REPORT, is_said_of};
use crate::scene::Document;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::{fs, io};
use thurible_core::exec::Ranks;
use thurible_core::grid::Share;

/// A solve, as its states name it.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Solve {
    /// Version of the program, which may compute other bits in another.
    pub version: String,
    /// The state's number: the larger one is the later one.
    pub number: u64,
    /// The scene file as it was named, and the folder that it was named from.
    scene: PathBuf,
    named_from: PathBuf,
    text: String,
    /// What the command line changed of it, in order.
    pub assignments: Vec<String>,
    #[serde(flatten)]
    pub options: Options,
    /// The ranks that have parts of the state, if several shared the solve.
    pub cut: Option<Cut>,
    inputs: Vec<Input>,
}

/// How many ranks share a box, and how many of them are beside each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "[usize; 2]", into = "[usize; 2]")]
pub(crate) struct Cut([usize; 2]);

impl From<Share> for Cut {
    fn from(share: Share) -> Self {
        Self([share.ranks, share.beside])
    }
}

impl From<Cut> for [usize; 2] {
    fn from(Cut(numbers): Cut) -> Self {
        numbers
    }
}

impl TryFrom<[usize; 2]> for Cut {
    type Error = &'static str;

    fn try_from([ranks, beside]: [usize; 2]) -> Result<Self, Self::Error> {
        let are_some = (2..=MOST).contains(&ranks) && beside > 0 && ranks.is_multiple_of(beside);
        if are_some {
            Ok(Self([ranks, beside]))
        } else {
            Err("no ranks share a box so")
        }
    }
}

impl Cut {
    /// How many ranks there are.
    pub fn ranks(self) -> usize {
        self.0[0]
    }

    /// Bytes of all their parts of a state of so many, of a box of these `cells`: each is as long as the longest.
    pub fn parts_bytes(self, state: u64, cells: &[usize]) -> u64 {
        let share = self.share();
        let lines = [share.along_planes().count, share.along_rows().count];
        let axes = cells.iter().rev().zip(lines);
        axes.fold(state, |bytes, (&cells, count)| {
            let most = cells.div_ceil(count) as u64 * count as u64;
            bytes.saturating_mul(most).div_ceil((cells as u64).max(1))
        })
    }

    /// The first of them.
    pub fn share(self) -> Share {
        let Self([ranks, beside]) = self;
        Share::new(0, ranks).in_blocks(beside)
    }
}

/// The most ranks.
const MOST: usize = 1 << 24;

/// A folder in a sentence of a command, and a step of the result in it.
pub(crate) type Earlier = Option<(String, PathBuf, Option<usize>)>;

/// The options of a solve that its states have to know.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Options {
    /// Whether keyframes and method of the file are left out, and the method that is taken then.
    pub free: Option<String>,
    /// f32 or f64.
    pub precision: String,
    /// The ceiling of the memory that choices were made under, in bytes.
    pub ceiling: Option<usize>,
    /// The result folder, absolute, and as the user knows it.
    pub folder: PathBuf,
    pub shown: PathBuf,
    /// The checksum of the report of a result that was there when it began, over which it may be written.
    #[serde(default)]
    pub over: Option<u64>,
    /// Whether pictures are drawn.
    pub images: bool,
    /// Earlier results that it begins with or is guided by.
    pub from: Earlier,
    pub reference: Earlier,
}

impl Options {
    /// The files of earlier results that it reads.
    pub fn results(&self) -> Vec<PathBuf> {
        let earlier = [&self.from, &self.reference].into_iter().flatten();
        earlier.map(|(_, folder, _)| folder.join(ARCHIVE)).collect()
    }
}

impl Solve {
    /// The solve of `document`, which began with these `inputs`.
    pub fn of(document: &Document, options: Options, inputs: Vec<Input>) -> io::Result<Self> {
        Ok(Self {
            version: env!("CARGO_PKG_VERSION").into(),
            number: 0,
            scene: document.path().to_owned(),
            named_from: std::env::current_dir()?,
            text: document.text().into(),
            assignments: document.assignments().map(Into::into).collect(),
            inputs,
            cut: None,
            options: Options {
                from: absolute(options.from)?,
                reference: absolute(options.reference)?,
                ..options
            },
        })
    }

    /// Tells the other ranks of it, who have [`Self::heard`].
    pub fn tell(&self, ranks: &dyn Ranks) -> Result<(), Failure> {
        let text = serde_json::to_vec(self).map_err(|_| unlike_ranks())?;
        told(ranks, 0, text);
        Ok(())
    }

    /// What the first rank goes on with.
    pub fn heard(ranks: &dyn Ranks) -> Result<Self, Failure> {
        serde_json::from_slice(&told(ranks, 0, Vec::new())).map_err(|_| unlike_ranks())
    }

    /// Refuses files that the scene names and that were changed since, or came.
    pub fn check_inputs(&self) -> Result<(), Failure> {
        self.inputs.iter().try_for_each(Input::check)?;
        check_for_more(&self.document()?, &self.inputs)
    }

    /// The scene that it began with. One that was changed since is refused.
    pub fn document(&self) -> Result<Document, Failure> {
        if self.version != env!("CARGO_PKG_VERSION") {
            return Err(Failure::Input(format!(
                "the state was kept by thurible {}, and this is {}, which may compute other bits; go on with that one, or solve anew",
                self.version,
                env!("CARGO_PKG_VERSION")
            )));
        }
        let here = std::env::current_dir().unwrap_or_default();
        let path = if here == self.named_from {
            self.scene.clone()
        } else {
            self.named_from.join(&self.scene)
        };
        // A scene that is gone is not needed: its text is here.
        let text = self.text.as_bytes();
        // What is no file may have no end.
        let is_another = |now: fs::Metadata| {
            let differs = || fs::read(&path).is_ok_and(|now| now != text);
            now.is_file() && (now.len() != text.len() as u64 || differs())
        };
        if fs::metadata(&path).is_ok_and(is_another) {
            return Err(Failure::Input(format!(
                "{} was changed since the solve began; put it back as it was, or solve anew",
                path.display()
            )));
        }
        let mut document = Document::parse(&path, self.text.clone())?;
        for assignment in &self.assignments {
            document.set(assignment)?;
        }
        Ok(document)
    }

    /// Whether it is that of `document`, with all that was set, in this precision.
    pub fn is_of(&self, document: &Document, precision: &str) -> bool {
        self.text == document.text()
            && self
                .assignments
                .iter()
                .map(String::as_str)
                .eq(document.assignments())
            && self.options.precision == precision
    }

    /// Whether the result in `folder`, if there is one, may be written over by this solve's: it was there when it began, or is of the same
    /// scene, as an interrupted solve leaves it.
    pub fn may_replace(&self, folder: &Path) -> bool {
        let Some(sum) = report_sum(folder) else {
            return true;
        };
        let is_own = || {
            let text = fs::read(folder.join(REPORT)).unwrap_or_default();
            let report: Value = serde_json::from_slice(&text).unwrap_or_default();
            let set = self.assignments.iter().map(String::as_str);
            is_said_of(&report, (&self.text, set), &self.options.precision)
        };
        self.options.over == Some(sum) || is_own()
    }

    /// The result goes to `folder`, beside which the states are now.
    pub fn move_to(&mut self, folder: PathBuf) {
        self.options.folder = std::path::absolute(&folder).unwrap_or_else(|_| folder.clone());
        self.options.shown = folder;
    }

    /// Where the result goes, as the user knows it if he is where he was.
    pub fn destination(&self) -> &Path {
        let here = std::env::current_dir().unwrap_or_default();
        if here == self.named_from {
            &self.options.shown
        } else {
            &self.options.folder
        }
    }
}

/// The checksum of the report of the result in `folder`, if there is one.
pub(crate) fn report_sum(folder: &Path) -> Option<u64> {
    Input::now(&folder.join(REPORT))
        .ok()
        .map(|report| report.digest())
}

/// What the first rank says is of a program that is not this one.
pub(crate) fn unlike_ranks() -> Failure {
    Failure::Input("the ranks are not all the same thurible; start the same program in all of them".into())
}

fn absolute(earlier: Earlier) -> io::Result<Earlier> {
    earlier
        .map(|(option, folder, step)| Ok((option, std::path::absolute(folder)?, step)))
        .transpose()
}

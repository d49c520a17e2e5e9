//! `steps = { from, every }` of a keyframe or an emitter: a shape for each of many steps, from many files or one array.

use super::document::Document;
use super::numbered::Numbered;
use super::raw::read;
use crate::exit::Failure;
use crate::keyframes::{ShapeSpec, steps_of_array};
use core::ops::RangeInclusive;
use std::path::{Path, PathBuf};
use toml::{Table, Value};

/// Where a sequence stands, and the pattern of its files if it has one.
pub(super) struct Sequence {
    from: usize,
    /// How many steps apart its shapes are.
    pub every: usize,
    /// The last step that one may stand at.
    last: usize,
    files: Option<Value>,
}

impl Sequence {
    /// Takes `steps` and `files` out of the table at `key`, if they are there; `single` are the keys of a shape without a sequence, and `allowed` the
    /// steps that one may stand at.
    pub fn taken(
        document: &Document,
        key: &str,
        table: &mut Table,
        (single, allowed): (&[&str], &RangeInclusive<usize>),
    ) -> Result<Option<Self>, Failure> {
        let at = format!("{key}.steps");
        let Some(found) = table.remove("steps") else {
            let remedy = "write where the shapes of `files` stand, as in steps = { from = 10, every = 5 }";
            let needed = table
                .get(ShapeSpec::PATTERN)
                .map(|_| document.required(&at, None, remedy));
            return needed.unwrap_or(Ok(None));
        };
        if let Some(beside) = single.iter().find(|beside| table.contains_key(**beside)) {
            let why = format!(
                "stands beside `{beside}`; a sequence of shapes has its own steps: take one of them out"
            );
            return Err(document.refuse(&at, why));
        }
        let files = table.remove(ShapeSpec::PATTERN);
        let one = ["mesh", "image", "file"]
            .into_iter()
            .find(|one| table.contains_key(*one));
        if let (Some(one), Some(_)) = (one, &files) {
            let why = "stands beside `files`, which names the files of the sequence; take one of them out";
            return Err(document.refuse(&format!("{key}.{one}"), why));
        }
        if files.is_none() && table.contains_key("entry") {
            let why =
                "stands beside `steps`, by which every entry of the array is taken; take one of them out";
            return Err(document.refuse(&format!("{key}.entry"), why));
        }
        Self::read(document, &at, found, files, allowed).map(Some)
    }

    /// What stands at `key`, the `steps` of a table.
    fn read(
        document: &Document,
        key: &str,
        found: Value,
        files: Option<Value>,
        allowed: &RangeInclusive<usize>,
    ) -> Result<Self, Failure> {
        let Value::Table(mut table) = found else {
            let wanted = "a table, as in { from = 10, every = 5 },";
            return Err(document.outside(key, super::check::shown(&found), wanted));
        };
        document.only(key, &table, &["from", "every"])?;
        let mut found = |name: &str| {
            let at = format!("{key}.{name}");
            let remedy =
                "write the first step and how many steps apart they are, as in { from = 10, every = 5 }";
            let found = document.required(&at, table.remove(name), remedy)?;
            Ok::<_, Failure>((at, found))
        };
        let ((from_key, from), (every_key, every)) = (found("from")?, found("every")?);
        Ok(Self {
            from: document.step_of_keyframe(&from_key, &from, allowed)?,
            every: document.whole_value(&every_key, &every, 1..=*allowed.end())?,
            last: *allowed.end(),
            files,
        })
    }

    /// Step and shape of every one of the sequence that the table at `key` names by `files`, or by `file` with a leading axis. `table` is what is
    /// left of it, the keys of a shape, and the scene has so many `steps`.
    pub fn shapes(
        &self,
        document: &Document,
        key: &str,
        table: Table,
        steps: usize,
    ) -> Result<Vec<(usize, ShapeSpec)>, Failure> {
        let shape = &read(document, key, Value::Table(table))?;
        let shapes = match &self.files {
            Some(Value::String(pattern)) => by_pattern(document, key, pattern, shape)?,
            Some(other) => {
                let wanted = "a pattern with one `*`, as in \"horse_*.png\",";
                return Err(document.outside(&format!("{key}.files"), super::check::shown(other), wanted));
            }
            None => {
                let count = of_array(document, key, shape)?;
                // A density for every frame of the scene: those at the steps are taken.
                if count == steps + 1 {
                    let taken = (self.from..=self.last).step_by(self.every);
                    return Ok(taken.map(|step| (step, shape.of_step(step))).collect());
                }
                self.check(document, key, count)?;
                (0..count).map(|step| shape.of_step(step)).collect()
            }
        };
        self.check(document, key, shapes.len())?;
        let at = |(index, shape)| (self.from + index * self.every, shape);
        Ok(shapes.into_iter().enumerate().map(at).collect())
    }

    /// Refuses a sequence of `count` shapes that goes on after the last step that one may stand at.
    fn check(&self, document: &Document, key: &str, count: usize) -> Result<(), Failure> {
        let most = self.last;
        let between = count.saturating_sub(1);
        let last = self.from.saturating_add(between.saturating_mul(self.every));
        if last <= most {
            return Ok(());
        }
        let why = format!(
            "put {count} shapes at steps up to {last}, but none may stand after step {most}; raise `time.steps`, or begin sooner"
        );
        Err(document.refuse(&format!("{key}.steps"), why))
    }
}

/// The shapes of all files whose names fit `pattern`, by number where they have one.
fn by_pattern(
    document: &Document,
    key: &str,
    pattern: &str,
    shape: &ShapeSpec,
) -> Result<Vec<ShapeSpec>, Failure> {
    let table = key.split('[').next().unwrap_or(key);
    let key = format!("{key}.files");
    let otherwise = format!(", or write one [[{table}]] for each");
    let files = in_order(document, &key, pattern, ["number", &otherwise])?;
    let paths = files.paths;
    // Shapes look for their files from the folder of the scene on.
    let folder = document.folder();
    let relative = |path: &PathBuf| path.strip_prefix(folder).unwrap_or(path).to_owned();
    let first = paths.first().map(relative).unwrap_or_default();
    Ok(paths
        .iter()
        .map(|path| shape.of_file(relative(path), &first))
        .collect())
}

/// All files whose names fit `pattern`, which stands at `key`, where nothing is in doubt of their order. A number of theirs is a number of `each`;
/// `otherwise` says what else helps where one is missing.
pub(crate) fn in_order(
    document: &Document,
    key: &str,
    pattern: &str,
    [each, otherwise]: [&str; 2],
) -> Result<Numbered, Failure> {
    let files = files_of(document, key, pattern)?;
    let refuse = |why: String| Err(document.refuse(key, format!("is \"{pattern}\", {why}")));
    if let Some(name) = files.uncounted() {
        return refuse(format!(
            "which {name} fits too, that has no number where others have one: nothing says where it comes; take it away, or write more of the names before the `*`"
        ));
    }
    if let Some([one, other]) = files.doubled() {
        return refuse(format!(
            "and {one} and {other} have the same number: nothing says which comes first; rename one, or take it away"
        ));
    }
    match files.missing() {
        None => Ok(files),
        Some(gap) => refuse(format!(
            "and {each} {} is missing between {} and {}; add it, or give the files without it other numbers{otherwise}",
            gap.missing, gap.before, gap.after
        )),
    }
}

/// All files whose names fit `pattern`, which stands at `key`, by number where they have one.
pub(crate) fn files_of(document: &Document, key: &str, pattern: &str) -> Result<Numbered, Failure> {
    let path = document.folder().join(pattern);
    let name = path.file_name().map(|name| name.to_string_lossy().into_owned());
    let Some((before, after)) = name.as_deref().and_then(|name| name.split_once('*')) else {
        let why = format!(
            "is \"{pattern}\", which has no `*` in its last part; write it where the numbers stand, as in \"horse_*.png\""
        );
        return Err(document.refuse(key, why));
    };
    if after.contains('*') {
        let why = format!(
            "is \"{pattern}\", which has more than one `*`; write one, where the numbers stand, as in \"horse_*.png\""
        );
        return Err(document.refuse(key, why));
    }
    // A bare name has a parent without letters, which is no folder.
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    let folder = folder.unwrap_or(Path::new("."));
    let entries = std::fs::read_dir(folder).map_err(|error| {
        let sentence = format!(
            "names the folder {}, which cannot be read ({error}); correct it",
            folder.display()
        );
        Failure::File(format!("{}: `{key}` {sentence}", document.place(key)))
    })?;
    let fits = |path: &PathBuf| {
        let name = path.file_name().map(|name| name.to_string_lossy().into_owned());
        name.is_some_and(|name| {
            // As for shells, what is hidden is meant only where it is asked for.
            let hidden = before.is_empty() && name.starts_with('.');
            let is_long = name.len() >= before.len() + after.len();
            !hidden && is_long && name.starts_with(before) && name.ends_with(after)
        })
    };
    let paths = entries.filter_map(|entry| Some(path.with_file_name(entry.ok()?.file_name())));
    let files = Numbered::of(paths.filter(fits));
    if files.paths.is_empty() {
        let why = format!(
            "is \"{pattern}\", which fits no file in {}; correct it",
            folder.display()
        );
        return Err(document.refuse(key, why));
    }
    Ok(files)
}

/// How many steps one array has.
fn of_array(document: &Document, key: &str, shape: &ShapeSpec) -> Result<usize, Failure> {
    steps_of_array(shape, document.folder()).map_err(|error| {
        let sentence = format!("{}: in {key}: {error}", document.place(key));
        error.failure(sentence)
    })
}

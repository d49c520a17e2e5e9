//! The files that a scene names: what they are when a state is kept, and whether they still are.

use crate::exit::Failure;
use crate::keyframes::{ShapeSpec, files_beside};
use crate::scene::{Document, files_of};
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;
use std::fs::{self, File};
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use thurible_core::checkpoint::Mix;
use toml::Value;

/// Bytes that are mixed together.
const PIECE: usize = 1 << 16;

/// A file, by which it is known again.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Input {
    /// Where it is, absolute.
    path: PathBuf,
    bytes: u64,
    digest: u64,
}

impl Input {
    /// The file at `path` as it is now.
    pub(super) fn now(path: &Path) -> io::Result<Self> {
        let (mut file, mut piece, mut sum, mut bytes) = (File::open(path)?, vec![0; PIECE], Mix::new(), 0);
        loop {
            let mut filled = 0;
            while filled < PIECE {
                match file.read(piece.get_mut(filled..).unwrap_or(&mut []))? {
                    0 => break,
                    count => filled += count,
                }
            }
            bytes += filled as u64;
            sum.bytes(piece.get(..filled).unwrap_or(&[]));
            if filled < PIECE {
                break;
            }
        }
        Ok(Self {
            path: std::path::absolute(path)?,
            bytes,
            digest: sum.finish(),
        })
    }

    /// Its checksum.
    pub(super) fn digest(&self) -> u64 {
        self.digest
    }

    /// Refuses a file that is not what it was.
    pub fn check(&self) -> Result<(), Failure> {
        let shown = self.path.display();
        let remedy = "put it back as it was, or solve anew";
        // What is no file may have no end.
        let now = fs::metadata(&self.path).and_then(|now| {
            let may_be_it = now.is_file() && now.len() == self.bytes;
            may_be_it.then(|| Self::now(&self.path)).transpose()
        });
        match now {
            Ok(Some(now)) if now == *self => Ok(()),
            Ok(_) => Err(Failure::Input(format!(
                "{shown} was changed since the solve began, which read it; {remedy}"
            ))),
            Err(error) => Err(Failure::File(format!(
                "cannot read {shown}, which the solve began with: {error}; {remedy}"
            ))),
        }
    }
}

/// The files that the scene of `document` names, and `others`, as they are now.
pub(crate) fn inputs_of(document: &Document, others: &[PathBuf]) -> io::Result<Vec<Input>> {
    let paths = paths_of(document, others);
    paths.iter().map(|path| Input::now(path)).collect()
}

/// Refuses a file that the scene of `document` names now and that was not among its `inputs`, as one more that fits a pattern.
pub(super) fn check_for_more(document: &Document, inputs: &[Input]) -> Result<(), Failure> {
    let is_new = |path: &PathBuf| {
        let path = std::path::absolute(path).ok();
        path.is_some_and(|path| inputs.iter().all(|input| input.path != path))
    };
    match paths_of(document, &[]).into_iter().find(is_new) {
        None => Ok(()),
        Some(path) => Err(Failure::Input(format!(
            "{} was not there when the solve began, and the scene means it too; take it away, or solve anew",
            path.display()
        ))),
    }
}

/// Those files.
fn paths_of(document: &Document, others: &[PathBuf]) -> BTreeSet<PathBuf> {
    let mut paths: BTreeSet<PathBuf> = others.iter().cloned().collect();
    for (section, value) in document.table() {
        // Where a result goes is no input.
        if section != "output" {
            gather(document, section, value, &mut paths);
        }
    }
    let beside: Vec<PathBuf> = paths.iter().flat_map(|path| files_beside(path)).collect();
    paths.extend(beside.into_iter().filter(|path| path.is_file()));
    paths
}

/// The files below `value`, which stands at `key`: those that the keys of shapes name, alone or by a pattern. Other texts may be the names of
/// files by chance.
fn gather(document: &Document, key: &str, value: &Value, paths: &mut BTreeSet<PathBuf>) {
    let mut add = |found: Vec<PathBuf>| paths.extend(found.into_iter().filter(|path| path.is_file()));
    match value {
        Value::String(text) if key == ShapeSpec::PATTERN => add(files_of(document, key, text)
            .map(|files| files.paths)
            .unwrap_or_default()),
        Value::String(text) if ShapeSpec::FILES.contains(&key) => add(vec![document.folder().join(text)]),
        Value::Array(values) => values
            .iter()
            .for_each(|value| gather(document, key, value, paths)),
        Value::Table(table) => table
            .iter()
            .for_each(|(key, value)| gather(document, key, value, paths)),
        _ => {}
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    /// A letter `*` beside a folder, a text that is the name of a file by chance, a pattern that a folder fits as well.
    #[test]
    fn only_files_that_keys_of_files_name_are_inputs() {
        let folder = std::env::temp_dir().join(format!("thurible-inputs-{}", std::process::id()));
        fs::create_dir_all(folder.join("horse_3.png")).unwrap();
        for name in [
            "F",
            "horse_1.png",
            "horse_2.png",
            "v.npz",
            "other.png",
            "mask.npy",
            "Font.ttf",
            "points of it.bin",
        ] {
            fs::write(folder.join(name), name).unwrap();
        }
        let body = "{\"buffers\": [{\"uri\": \"points%20of%20it.bin\"}, {\"uri\": \"data:;base64,AA==\"}]}";
        fs::write(folder.join("body.gltf"), body).unwrap();
        let text = "\
[source]
shapes = [{ text = \"*\", font = \"Font.ttf\" }, { text = \"F\" }]
[[keyframe]]
steps = { from = 2, every = 2 }
files = \"horse_*.png\"
[control]
initial_velocity = { file = \"v.npz\" }
mask = { file = \"mask.npy\" }
[[obstacle]]
mesh = \"body.gltf\"
[output]
folder = \"F\"
";
        let document = Document::parse(&folder.join("scene.toml"), text.into()).unwrap();
        let inputs = inputs_of(&document, &[]).unwrap();
        let names: Vec<_> = inputs
            .iter()
            .map(|input| input.path.file_name().unwrap())
            .collect();
        assert_eq!(
            names,
            [
                "Font.ttf",
                "body.gltf",
                "horse_1.png",
                "horse_2.png",
                "mask.npy",
                "points of it.bin",
                "v.npz"
            ]
        );
        // One more that fits the pattern, as a renderer writes that is still at work.
        assert!(check_for_more(&document, &inputs).is_ok());
        fs::write(folder.join("horse_4.png"), "4").unwrap();
        let refused = check_for_more(&document, &inputs).unwrap_err().to_string();
        assert!(refused.contains("horse_4.png was not there"), "{refused}");
        fs::remove_dir_all(&folder).unwrap();
    }
}

//! The scene of a written result, read again for finer cells.

use crate::console::quoted_path;
use crate::exit::Failure;
use crate::scene::{Document, Scene};
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};
use toml::Value as Toml;

/// The failure of a file that a scene names, with what helps where the scene itself is not at `path`, beside which files are looked for.
pub(super) fn located(path: &Path, failure: Failure) -> Failure {
    match failure {
        Failure::File(why) if !path.is_file() => Failure::File(format!(
            "{why}; the scene of the result is not there: say with --scene where it is"
        )),
        other => other,
    }
}

/// What a result says of how it was made.
pub(super) struct Origin {
    report: Value,
    /// The result folder.
    folder: PathBuf,
}

impl Origin {
    /// That of the result in `folder`.
    pub fn of(folder: &Path) -> Result<Self, Failure> {
        let path = folder.join("report.json");
        let text = fs::read_to_string(&path).map_err(|error| {
            let path = path.display();
            Failure::File(format!("cannot read {path}: {error}; check the result folder"))
        })?;
        Ok(Self {
            report: serde_json::from_str(&text).unwrap_or_default(),
            folder: folder.to_owned(),
        })
    }

    /// The scene, what the command line changed of it included, on cells `scale` times as fine in every direction; and as it was solved. Files that
    /// shapes name are looked for beside `file`, or where the scene file was.
    pub fn scenes(&self, scale: usize, file: Option<&Path>) -> Result<[Scene; 2], Failure> {
        if let Some(kind) = self.report.get("kind").and_then(Value::as_str) {
            let folder = quoted_path(&self.folder);
            return Err(Failure::Input(format!(
                "--scale {scale}: {folder} was made by {kind}, not from a scene whose source can be drawn on finer cells; write `thurible upsample {folder} --factor {scale}`, and draw what that leaves"
            )));
        }
        let text = self.report.get("scene").and_then(Value::as_str);
        let text = text.filter(|text| !text.is_empty()).ok_or_else(|| {
            self.refuse(
                scale,
                "holds no scene, from which source and emitters are drawn again; solve it again",
            )
        })?;
        let named = self.report.get("scene_file").and_then(Value::as_str);
        let named = named.map(|name| self.folder.join(name));
        let path = file.map(Path::to_owned).or(named);
        let path = path.unwrap_or_else(|| self.folder.join("scene.toml"));
        let mut document = Document::parse(&path, text.into())?;
        let overrides = self.report.get("overrides").and_then(Value::as_array);
        for assignment in overrides.into_iter().flatten().filter_map(Value::as_str) {
            document.set(assignment)?;
        }
        let coarse = Scene::free_of(document.clone()).map_err(|failure| located(&path, failure))?;
        self.check(scale, &coarse)?;
        let finer = |&count: &usize| Toml::Integer(i64::try_from(count * scale).unwrap_or(i64::MAX));
        let cells = coarse.grid.cells.iter().map(finer).collect();
        document.replace(format!("--scale {scale}"), "grid.cells", Toml::Array(cells))?;
        Ok([
            Scene::free_of(document).map_err(|failure| located(&path, failure))?,
            coarse,
        ])
    }

    /// Refuses a scene that is not that of the result, and a result whose density did not only go with its flow.
    fn check(&self, scale: usize, scene: &Scene) -> Result<(), Failure> {
        let is = |key: &str, value: Value| self.report.get(key).is_none_or(|found| *found == value);
        let cells = scene.grid.cells.clone();
        if !is("cells", cells.into()) || !is("steps", scene.time.steps.into()) {
            let why = "holds a scene of other cells or steps than the result's, since it was written before changes from the command line were kept; solve it again";
            return Err(self.refuse(scale, why));
        }
        if !is("velocity_location", "face".into()) {
            let why = "says that its flow is that of cells, not of faces (stable_fluids), which goes to no finer ones; leave --scale out, or solve it by another method";
            return Err(self.refuse(scale, why));
        }
        let driven = self.report.get("method").and_then(Value::as_str) == Some("pd");
        if driven && scene.method.params.pd.gathering > 0.0 {
            let why = "says that smoke was gathered (method.pd.gathering), which the flow alone does not do; solve it again with --set method.pd.gathering=0";
            return Err(self.refuse(scale, why));
        }
        Ok(())
    }

    fn refuse(&self, scale: usize, why: &str) -> Failure {
        let folder = self.folder.display();
        Failure::Input(format!("--scale {scale}: report.json of {folder} {why}"))
    }
}

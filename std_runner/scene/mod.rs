//! The scene file: TOML in, a checked [`Scene`] out, or one sentence that says where and why not.

mod build;
mod check;
mod document;
mod effects;
mod keys;
mod kinds;
mod method;
mod model;
mod numbered;
mod place;
mod raw;
mod schema;
mod sequence;
mod shapes;
mod templates;

pub(crate) use check::shown;
pub use document::Document;
pub(crate) use method::{choose, section, steering};
pub use model::{Control, Flow, FluidsSection, Grid, Keyframe, MethodSection, Output, Scene, Time};
pub(crate) use numbered::Numbered;
pub(crate) use raw::read;
pub use schema::schema;
pub(crate) use sequence::{files_of, in_order};

use crate::exit::Failure;
use std::path::Path;
use thurible_core::Method;

/// The file at `path` with what the `assignments` change of it, in order.
fn document(path: &Path, assignments: &[String]) -> Result<Document, Failure> {
    let mut document = Document::read(path)?;
    for assignment in assignments {
        document.set(assignment)?;
    }
    Ok(document)
}

impl Scene {
    /// Reads `path`, applies the `--set` assignments in order, then `--method`, and checks everything.
    pub fn load(path: &Path, assignments: &[String], method: Option<&str>) -> Result<Self, Failure> {
        let mut document = document(path, assignments)?;
        if let Some(name) = method {
            document.replace(format!("--method {name}"), "method.name", name.into())?;
        }
        build::scene(document)
    }

    /// As [`Self::load`], for the flow alone: the keyframes and the method of the file are left out.
    pub fn load_free(path: &Path, assignments: &[String]) -> Result<Self, Failure> {
        Self::free_of(document(path, assignments)?)
    }

    /// As [`Self::load`], or where there is no keyframe as [`Self::load_free`].
    pub fn load_any(path: &Path, assignments: &[String]) -> Result<Self, Failure> {
        let document = document(path, assignments)?;
        if document.table().contains_key("keyframe") {
            build::scene(document)
        } else {
            Self::free_of(document)
        }
    }

    /// As [`Self::load_free`], of a document that is complete.
    pub fn free_of(document: Document) -> Result<Self, Failure> {
        build::free(document)
    }

    /// The same for its flow by `method`, or by Stable Fluids, instead of what the file says.
    #[must_use]
    pub fn flow_by(mut self, method: Method, fluids: bool) -> Self {
        self.method.params.method = method;
        self.method.fluids.chosen = fluids;
        if method == Method::Guide {
            // The flow that is followed stands in the velocities of all steps, so there is nothing to save by windows.
            self.method.windows = None;
        }
        self
    }

    /// Checks a document that is complete.
    pub fn of(document: Document) -> Result<Self, Failure> {
        build::scene(document)
    }
}

//! What a run left in its folder before.

use crate::report::{REPORT, is_said_of};
use crate::scene::Scene;
use serde_json::Value;
use std::fs;
use std::path::Path;

/// The report of a run, if it has a whole result: none that was interrupted.
pub(super) fn report_in(folder: &Path) -> Option<Value> {
    let report = fs::read(folder.join(REPORT)).ok()?;
    let report: Value = serde_json::from_slice(&report).ok()?;
    let is_whole = report["status"].is_string() && report["status"] != "cancelled";
    is_whole.then_some(report)
}

/// Whether a result is that of this very scene, with all that was set, in this precision.
pub(super) fn is_of(report: &Value, scene: &Scene, precision: &str) -> bool {
    let document = &scene.document;
    is_said_of(report, (document.text(), document.assignments()), precision)
}

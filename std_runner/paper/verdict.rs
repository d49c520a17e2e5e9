//! Which rows of the page count as failed.

use super::catalogue::Entry;
use crate::compare::{self, Figures};
use crate::quoted::NOT_GIVEN;
use crate::remarks::MISSED;
use crate::report::SolvedBy;
use thurible_core::{Method, Status};

/// The rule of [`failed`], for readers.
pub(crate) const RULE: &str = "A row has failed where there is no result, where a keyframe is missed by more than 20 %, or where admm or lbfgs did \
     not converge in a scene for which the paper gives the time of its own solve by that method.";

/// What the paper has where its own program could not solve a scene.
const NOT_SOLVED: &str = "N/A";

/// How a row ended: as its status says, or that it failed, and why.
pub(crate) fn ended(entry: &Entry, figures: Option<&Figures>) -> String {
    match (figures, failed(entry, figures)) {
        (_, Some(why)) => format!("failed: {why}"),
        (Some(figures), None) => compare::status(figures.status).into(),
        (None, None) => String::new(),
    }
}

/// Why the row of a scene and method has failed, if it has; without figures there is no result.
pub(crate) fn failed(entry: &Entry, figures: Option<&Figures>) -> Option<String> {
    let Some(figures) = figures else {
        return Some("no result".into());
    };
    if figures.status == Status::Cancelled {
        return None;
    }
    let unconverged = figures.status != Status::Converged && converges(entry, figures.method);
    let ended = unconverged.then(|| compare::status(figures.status).to_owned());
    let missed = figures.keyframe_error.is_nan() || figures.keyframe_error > MISSED;
    let missed = missed.then(|| format!("missed by {:.1} %", 100.0 * figures.keyframe_error));
    let reasons: Vec<String> = missed.into_iter().chain(ended).collect();
    (!reasons.is_empty()).then(|| reasons.join(", "))
}

/// Whether the paper's own solve of the scene by `method` converged.
fn converges(entry: &Entry, method: SolvedBy) -> bool {
    entry.quoted.is_some_and(|row| match method {
        SolvedBy::Method(Method::Admm) => true,
        SolvedBy::Method(Method::Lbfgs) => ![NOT_SOLVED, NOT_GIVEN].contains(&row.lbfgs_total),
        _ => false,
    })
}

#[cfg(test)]
mod tests {
    use super::super::catalogue::ENTRIES;
    use super::*;
    use crate::report::ObjectiveRecord;

    fn figures(method: Method, status: Status, keyframe_error: f64) -> Figures {
        Figures {
            method: method.into(),
            status,
            threads: 1,
            iterations: 60,
            coarser_iterations: 0,
            seconds: 1.0,
            seconds_to_best: None,
            seconds_to_worst: None,
            iteration_average: 1.0,
            ao_average: None,
            nso_average: None,
            objective: ObjectiveRecord {
                data: 1.0,
                force: 1.0,
                plain: 1.0,
                initial: None,
            },
            own_objective: None,
            keyframe_error,
            keyframe_error_before: 0.9,
            remarks: Vec::new(),
            planned_bytes: 1,
            paper_bound_bytes: 1,
        }
    }

    #[test]
    fn what_failed_says_so_and_why() {
        let entry = |name: &str| ENTRIES.iter().find(|entry| entry.name == name);
        for (name, method, status, error, said) in [
            (
                "figure",
                Method::Direct,
                Status::Converged,
                0.572,
                "failed: missed by 57.2 %",
            ),
            ("figure", Method::Admm, Status::Stalled, 0.1, "failed: stalled"),
            (
                "figure",
                Method::Admm,
                Status::MaxIterations,
                0.58,
                "failed: missed by 58.0 %, at its limit",
            ),
            // The paper's own LBFGS came to nothing there.
            (
                "figure",
                Method::Lbfgs,
                Status::MaxIterations,
                0.1,
                "at its limit",
            ),
            (
                "fluid_f",
                Method::Lbfgs,
                Status::MaxIterations,
                0.1,
                "failed: at its limit",
            ),
            (
                "fluid_f",
                Method::Direct,
                Status::MaxIterations,
                0.1,
                "at its limit",
            ),
            ("quick", Method::Admm, Status::Stalled, 0.1, "stalled"),
            ("fluid_f", Method::Admm, Status::Cancelled, 0.9, "interrupted"),
            ("fluid_f", Method::Admm, Status::Converged, 0.2, "converged"),
        ] {
            let figures = figures(method, status, error);
            let ended = entry(name).map(|entry| ended(entry, Some(&figures)));
            assert_eq!(ended.as_deref(), Some(said));
        }
        let nothing = entry("abc").map(|entry| ended(entry, None));
        assert_eq!(nothing.as_deref(), Some("failed: no result"));
    }
}

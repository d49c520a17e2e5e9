//! Choices that a plan makes under its ceiling, made again as they were under another.

use crate::problem::{OwnedProblem, Precision};
use thurible_core::{DirectParams, LbfgsParams, Params};

/// `params` with the choices that bits follow from as they were made under another ceiling, if there was one.
pub(crate) fn chosen(
    problem: &OwnedProblem,
    params: &Params,
    precision: Precision,
    began_under: Option<Option<usize>>,
) -> Params {
    let before = began_under.map(|ceiling| Params { ceiling, ..*params });
    // They were those of one program, or of ranks that made them as one program does that has enough.
    let alone = OwnedProblem {
        share: None,
        ..problem.clone()
    };
    let before = before.and_then(|params| alone.plan(&params, precision).ok());
    before.map_or(*params, |plan| Params {
        direct: DirectParams {
            history: plan.params().direct.history,
            ..params.direct
        },
        lbfgs: LbfgsParams {
            history: plan.params().lbfgs.history,
            ..params.lbfgs
        },
        ..*params
    })
}

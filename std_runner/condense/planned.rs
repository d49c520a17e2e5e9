//! What a variant takes of memory, under a ceiling.

use super::cases::{Case, Variant};
use crate::bytes::{self, grouped, rounded};
use crate::console::print;
use crate::exit::Failure;
use crate::plan::PlanOptions;
use crate::problem::Precision;
use crate::progress::{Display, Mode};
use crate::region::MARGIN;
use crate::threads;
use serde_json::{Value, json};
use thurible_core::condense::{CondenseError, CondenseParams, CondensePlan, Topology, Update};

/// Edges of the patches that a plan shows beside the whole basis.
const SHOWN_RADIUS: usize = 2;

/// A variant that fits.
pub(super) struct Planned {
    pub params: CondenseParams,
    /// Words of the mesh's order and neighbours.
    pub words: usize,
    pub plan: CondensePlan,
}

/// A line of a ledger.
#[derive(Clone, Debug)]
pub(super) struct Line {
    pub name: &'static str,
    pub bytes: usize,
    pub depth: usize,
}

impl Planned {
    /// Bytes of the lists of the mesh and of the block.
    pub fn bytes(&self) -> usize {
        self.plan.bytes().saturating_add(self.words.saturating_mul(4))
    }

    /// The ledger, the lists of the mesh first.
    pub fn ledger(&self) -> Vec<Line> {
        let lists = Line {
            name: "order and neighbours",
            bytes: 4 * self.words,
            depth: 0,
        };
        let lines = self.plan.entries().iter();
        let lines = lines.map(|entry| Line {
            name: entry.name,
            bytes: entry.bytes,
            depth: entry.depth,
        });
        core::iter::once(lists).chain(lines).collect()
    }
}

/// Refuses a mesh of a case, or a choice.
pub(super) fn refused(case: &Case, error: &CondenseError) -> Failure {
    let (key, remedy) = match error {
        CondenseError::NoneHeld | CondenseError::Unheld { .. } => {
            ("hold", "hold it with hold = [ { box = .. } ], or give time.dt")
        }
        CondenseError::AllHeld => ("hold", "make the boxes smaller"),
        CondenseError::Loose { .. } => ("mesh", "give it an element"),
        _ => ("mesh", "change it"),
    };
    case.document
        .refuse(key, format!("is refused: {error}; {remedy}"))
}

/// Plans a variant within the ceiling; on fewer threads, if their number was not given and that makes it fit.
pub(super) fn planned(case: &Case, variant: &Variant, options: &PlanOptions) -> Result<Planned, Failure> {
    let ceiling = options.limit.or_else(bytes::of_machine);
    let mut threads = options.threads.unwrap_or_else(threads::available);
    loop {
        let params = CondenseParams {
            threads,
            ..variant.params
        };
        let planned = plan_of(case, params, options.precision)?;
        let needed = planned.bytes().saturating_add(MARGIN);
        match ceiling {
            Some(limit) if needed > limit => {
                if options.threads.is_some() || threads <= 1 {
                    return Err(over_limit(case, variant, options, (needed, limit)));
                }
                threads /= 2;
            }
            _ => return Ok(planned),
        }
    }
}

fn plan_of(case: &Case, params: CondenseParams, precision: Precision) -> Result<Planned, Failure> {
    let mesh = case.problem.mesh.mesh();
    let words = Topology::words(&mesh);
    let mut list = vec![0; words];
    let refuse = |error| refused(case, &error);
    let topology = Topology::new(&mesh, params.radius, &mut list).map_err(refuse)?;
    let plan = match precision {
        Precision::F32 => CondensePlan::new::<f32>(&mesh, &topology, &params),
        Precision::F64 => CondensePlan::new::<f64>(&mesh, &topology, &params),
    };
    Ok(Planned {
        params,
        words,
        plan: plan.map_err(refuse)?,
    })
}

fn over_limit(
    case: &Case,
    variant: &Variant,
    options: &PlanOptions,
    (needed, limit): (usize, usize),
) -> Failure {
    let whose = if options.limit.is_some() {
        "--memory-limit allows"
    } else {
        "this machine has"
    };
    let less = if variant.params.method.keeps_basis() {
        "use --radius W or the method \"warped\", which keeps no basis"
    } else if options.precision == Precision::F64 {
        "use --precision f32"
    } else {
        "give a coarser mesh"
    };
    Failure::Memory(format!(
        "{}: {} needs {} bytes ({}), but {whose} {} bytes ({}); raise --memory-limit to {} bytes, or {less}",
        case.document.path().display(),
        variant.name,
        grouped(needed),
        rounded(needed),
        grouped(limit),
        rounded(limit),
        grouped(needed)
    ))
}

/// What a whole basis, patches and no basis at all take, side by side.
fn beside(case: &Case, options: &PlanOptions) -> Vec<(String, usize)> {
    let radius = case.problem.params.radius.unwrap_or(SHOWN_RADIUS);
    let threads = options.threads.unwrap_or_else(threads::available);
    let rows = [
        ("cc, the whole basis".to_owned(), Update::Cc, None),
        (
            format!("cc, patches of radius {radius}"),
            Update::Cc,
            Some(radius),
        ),
        ("warped, no basis".to_owned(), Update::Warped, None),
    ];
    let base = CondenseParams {
        noise: 0.0,
        order: thurible_core::condense::Order::Jacobi,
        ..case.problem.params
    };
    rows.into_iter()
        .filter_map(|(name, method, radius)| {
            let params = CondenseParams {
                method,
                radius,
                threads,
                ..base
            };
            Some((name, plan_of(case, params, options.precision).ok()?.bytes()))
        })
        .collect()
}

/// Says what every variant of a case takes, buffer by buffer.
pub(super) fn print_plan(case: &Case, options: &PlanOptions, mode: Mode) -> Result<(), Failure> {
    if mode == Mode::Json {
        return json_plan(case, options);
    }
    for variant in &case.variants {
        let planned = planned(case, variant, options)?;
        let label = if case.label.is_empty() {
            String::new()
        } else {
            format!(", {}", case.label)
        };
        print(&format!(
            "{}{label}: {}, {}, {} threads",
            case.document.path().display(),
            variant.name,
            options.precision.name(),
            planned.params.threads
        ));
        print(&format!("\n{:>18}  buffer", "bytes"));
        for line in planned.ledger() {
            print(&format!(
                "{:>18}  {:indent$}{}",
                grouped(line.bytes),
                "",
                line.name,
                indent = 2 * line.depth
            ));
        }
        print(&format!(
            "{:>18}  in all ({}), whatever the number of steps\n",
            grouped(planned.bytes()),
            rounded(planned.bytes())
        ));
    }
    for (name, bytes) in beside(case, options) {
        print(&format!("{:>18}  {name} ({})", grouped(bytes), rounded(bytes)));
    }
    print("");
    Ok(())
}

fn json_plan(case: &Case, options: &PlanOptions) -> Result<(), Failure> {
    let mut variants = Vec::new();
    for variant in &case.variants {
        let planned = planned(case, variant, options)?;
        variants.push(json!({
            "name": variant.name, "planned_bytes": planned.bytes(), "threads": planned.params.threads, "ledger": ledger(&planned.ledger()),
        }));
    }
    let beside: Vec<Value> = beside(case, options)
        .into_iter()
        .map(|(name, bytes)| json!({ "name": name, "bytes": bytes }))
        .collect();
    let fields = json!({ "case": case.label, "variants": variants, "beside": beside });
    Display::new(Mode::Json, 0).event("plan", fields);
    Ok(())
}

/// A ledger as JSON.
pub(super) fn ledger(lines: &[Line]) -> Vec<Value> {
    let line = |line: &Line| json!({ "name": line.name, "bytes": line.bytes, "depth": line.depth });
    lines.iter().map(line).collect()
}

//! What a variant takes of memory, under a ceiling.

use super::cases::{Case, Variant};
use crate::bytes::{self, grouped, rounded};
use crate::console::print;
use crate::exit::Failure;
use crate::ledger::{over, print_least, print_ledger};
use crate::plan::PlanOptions;
use crate::problem::Precision;
use crate::progress::{Display, Mode};
use crate::region::MARGIN;
use crate::report::count;
use crate::threads;
use serde_json::{Value, json};
use thurible_core::condense::{CondenseError, CondenseParams, CondensePlan, Order, Topology, Update};

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

/// Plans the variants of a case within the ceiling; each on fewer threads, if their number was not given and that makes it fit.
pub(super) fn planned(case: &Case, options: &PlanOptions) -> Result<Vec<Planned>, Failure> {
    let (mesh, mut list) = (case.problem.mesh.mesh(), lists(case, options)?);
    let mut radii: Vec<Option<usize>> = Vec::new();
    for variant in &case.variants {
        if !radii.contains(&variant.params.radius) {
            radii.push(variant.params.radius);
        }
    }
    let mut plans = Vec::new();
    for radius in radii {
        let topology = Topology::new(&mesh, radius, &mut list).map_err(|error| refused(case, &error))?;
        let variants = case.variants.iter().enumerate();
        for (index, variant) in variants.filter(|(_, variant)| variant.params.radius == radius) {
            plans.push((index, fitting(case, variant, options, &topology)?));
        }
    }
    plans.sort_by_key(|(index, _)| *index);
    Ok(plans.into_iter().map(|(_, plan)| plan).collect())
}

/// Words for the order and neighbours of a mesh, which the ceiling allows.
fn lists(case: &Case, options: &PlanOptions) -> Result<Vec<u32>, Failure> {
    let words = Topology::words(&case.problem.mesh.mesh());
    let needed = words.saturating_mul(4).saturating_add(MARGIN);
    match options.limit.or_else(bytes::of_machine) {
        Some(limit) if needed > limit => {
            let (path, given) = (case.document.path(), options.limit.is_some());
            let what = "the order and neighbours of the mesh alone need";
            Err(over(
                path,
                what,
                (needed, limit),
                given,
                &["give a coarser mesh".into()],
            ))
        }
        _ => Ok(vec![0; words]),
    }
}

fn fitting(
    case: &Case,
    variant: &Variant,
    options: &PlanOptions,
    topology: &Topology<'_>,
) -> Result<Planned, Failure> {
    let ceiling = options.limit.or_else(bytes::of_machine);
    let mut threads = options.threads.unwrap_or_else(threads::available);
    loop {
        let params = CondenseParams {
            threads,
            ..variant.params
        };
        let planned = plan_of(case, params, options.precision, topology)?;
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

fn plan_of(
    case: &Case,
    params: CondenseParams,
    precision: Precision,
    topology: &Topology<'_>,
) -> Result<Planned, Failure> {
    let mesh = case.problem.mesh.mesh();
    let plan = match precision {
        Precision::F32 => CondensePlan::new::<f32>(&mesh, topology, &params),
        Precision::F64 => CondensePlan::new::<f64>(&mesh, topology, &params),
    };
    Ok(Planned {
        params,
        words: Topology::words(&mesh),
        plan: plan.map_err(|error| refused(case, &error))?,
    })
}

fn over_limit(case: &Case, variant: &Variant, options: &PlanOptions, bytes: (usize, usize)) -> Failure {
    let less = if variant.params.method.keeps_basis() {
        "use --radius W or the method \"warped\", which keeps no basis"
    } else if options.precision == Precision::F64 {
        "use --precision f32"
    } else {
        "give a coarser mesh"
    };
    let (path, given) = (case.document.path(), options.limit.is_some());
    let what = format!("{} needs", variant.name);
    over(path, &what, bytes, given, &[less.into()])
}

/// What a whole basis, patches and no basis at all take, side by side; those that the core takes.
fn beside(case: &Case, options: &PlanOptions) -> Result<Vec<(String, usize)>, Failure> {
    let radius = case.problem.params.radius.unwrap_or(SHOWN_RADIUS);
    let threads = options.threads.unwrap_or_else(threads::available);
    let (mesh, mut list) = (case.problem.mesh.mesh(), lists(case, options)?);
    let mut bytes = |radius: Option<usize>, methods: &[Update]| -> Vec<Option<usize>> {
        let Ok(topology) = Topology::new(&mesh, radius, &mut list) else {
            return vec![None; methods.len()];
        };
        let bytes = |&method: &Update| {
            let params = CondenseParams {
                method,
                radius,
                threads,
                noise: 0.0,
                order: Order::Jacobi,
                ..case.problem.params
            };
            Some(plan_of(case, params, options.precision, &topology).ok()?.bytes())
        };
        methods.iter().map(bytes).collect()
    };
    let whole = bytes(None, &[Update::Cc, Update::Warped]);
    let patches = bytes(Some(radius), &[Update::Cc]);
    let rows = [
        ("cc, the whole basis".to_owned(), whole.first()),
        (format!("cc, patches of radius {radius}"), patches.first()),
        ("warped, no basis".to_owned(), whole.last()),
    ];
    let known = |(name, bytes): (String, Option<&Option<usize>>)| Some((name, bytes.copied().flatten()?));
    Ok(rows.into_iter().filter_map(known).collect())
}

/// Bytes of the states of a result, which lie beside the plan until they are written.
fn result_bytes(case: &Case) -> usize {
    let states = case.problem.steps.saturating_add(1);
    let state = case.problem.mesh.rest.len().saturating_mul(size_of::<f64>());
    states.saturating_mul(state)
}

/// Says what every variant of a case takes, buffer by buffer.
pub(super) fn print_plan(case: &Case, options: &PlanOptions, mode: Mode) -> Result<(), Failure> {
    let plans = planned(case, options)?;
    if mode == Mode::Json {
        return json_plan(case, options, &plans);
    }
    for (variant, planned) in case.variants.iter().zip(&plans) {
        let label = if case.label.is_empty() {
            String::new()
        } else {
            format!(", {}", case.label)
        };
        print(&format!(
            "{}{label}: {}, {}, {}",
            case.document.path().display(),
            variant.name,
            options.precision.name(),
            count(planned.params.threads, "thread")
        ));
        let lines = planned.ledger();
        let lines = lines.iter().map(|line| (line.name, line.bytes, line.depth));
        print_ledger(lines, planned.bytes(), ", whatever the number of steps");
        print_least(planned.bytes());
        print("");
    }
    for (name, bytes) in beside(case, options)? {
        print(&format!("{:>18}  {name} ({})", grouped(bytes), rounded(bytes)));
    }
    let states = result_bytes(case);
    print(&format!(
        "{:>18}  beside each: the states of its result, until they are written ({})\n",
        grouped(states),
        rounded(states)
    ));
    Ok(())
}

fn json_plan(case: &Case, options: &PlanOptions, plans: &[Planned]) -> Result<(), Failure> {
    let variant = |(variant, planned): (&Variant, &Planned)| {
        json!({
            "name": variant.name, "planned_bytes": planned.bytes(), "threads": planned.params.threads, "ledger": ledger(&planned.ledger()),
        })
    };
    let variants: Vec<Value> = case.variants.iter().zip(plans).map(variant).collect();
    let beside: Vec<Value> = beside(case, options)?
        .into_iter()
        .map(|(name, bytes)| json!({ "name": name, "bytes": bytes }))
        .collect();
    let fields = json!({ "case": case.label, "variants": variants, "beside": beside, "result_bytes": result_bytes(case) });
    Display::new(Mode::Json, 0).event("plan", fields);
    Ok(())
}

/// A ledger as JSON.
pub(super) fn ledger(lines: &[Line]) -> Vec<Value> {
    let line = |line: &Line| json!({ "name": line.name, "bytes": line.bytes, "depth": line.depth });
    lines.iter().map(line).collect()
}

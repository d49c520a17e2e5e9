//! The scene: which body, what happens to it, how it is solved.

use super::body::{OwnedMesh, hold, material, mesh, place, springs};
use super::raw::{RawLoad, RawScene, RawSolver};
use crate::exit::Failure;
use crate::scene::{Document, read, shown};
use thurible_core::Named;
use thurible_core::choices::Numbers;
use thurible_core::condense::{Basis, CondenseParams, Update};
use toml::Value;

/// Steps at most.
const MOST_STEPS: usize = 100_000;
/// Iterations of a step, and steps from one build to the next, at most.
const MOST: usize = 100_000_000;
/// One problem, with all that it is solved by.
#[derive(Clone, Debug)]
pub(super) struct Problem {
    pub mesh: OwnedMesh,
    pub steps: usize,
    /// By how much every vertex moves at every step, and once more in the first; empty where none does.
    pub moves: Vec<f64>,
    pub bump: Vec<f64>,
    /// The whole acceleration; quasi-static steps reach it evenly.
    pub gravity: [f64; 3],
    /// A vertex that is hit, and by what.
    pub impulse: Option<(usize, Vec<f64>)>,
    pub methods: Vec<Update>,
    pub bases: Vec<Basis>,
    /// Whether a basis was asked for, and not by a scene whose methods the command line replaces.
    pub basis_given: bool,
    /// What all methods share.
    pub params: CondenseParams,
}

impl Problem {
    /// Reads a document that is complete, whose mesh takes no more than `most` bytes.
    pub fn of(document: &Document, most: usize) -> Result<Self, Failure> {
        let raw: RawScene = read(document, "", Value::Table(document.table().clone()))?;
        let remedy = "write mesh = { grid = [16, 3], size = [1.0, 0.2] }, a rod or a file";
        let mut mesh = mesh(document, document.required("mesh", raw.mesh, remedy)?, most)?;
        mesh.material = material(document, raw.material.unwrap_or_default(), mesh.material)?;
        let time = raw.time.unwrap_or_default();
        let steps = document.whole("time.steps", time.steps.unwrap_or(1), 1..=MOST_STEPS)?;
        let dt = time
            .dt
            .map(|dt| document.number("time.dt", dt, Numbers::Positive))
            .transpose()?;
        let moves = hold(document, raw.hold, &mut mesh)?;
        let moves = springs(document, raw.spring, &mut mesh, moves)?;
        let load = raw.load.unwrap_or_default();
        let solver = raw.solver.unwrap_or_default();
        let problem = Self {
            steps,
            gravity: gravity(document, &load, &mesh)?,
            impulse: impulse(document, &load, &mesh, dt)?,
            bump: bump(document, &load, &mesh)?,
            methods: methods(document, &solver)?,
            bases: bases(document, &solver)?,
            basis_given: solver.basis.is_some()
                && (document.overrides("solver.basis") || !document.overrides("solver.methods")),
            params: params(document, &solver, dt)?,
            moves: if moves.iter().all(|&x| x == 0.0) {
                Vec::new()
            } else {
                moves
            },
            mesh,
        };
        let refused = |error| document.refuse("mesh", format!("is refused: {error}; change it"));
        problem.mesh.mesh().check().map_err(refused)?;
        Ok(problem)
    }
}

fn gravity(document: &Document, load: &RawLoad, mesh: &OwnedMesh) -> Result<[f64; 3], Failure> {
    let mut out = [0.0; 3];
    if let Some(gravity) = &load.gravity {
        let gravity = place(document, "load.gravity", gravity, mesh.dims)?;
        out.iter_mut().zip(gravity).for_each(|(to, from)| *to = from);
    }
    Ok(out)
}

fn impulse(
    document: &Document,
    load: &RawLoad,
    mesh: &OwnedMesh,
    dt: Option<f64>,
) -> Result<Option<(usize, Vec<f64>)>, Failure> {
    let Some(impulse) = &load.impulse else {
        return Ok(None);
    };
    if dt.is_none() {
        return Err(document.refuse("load.impulse", "needs inertia; give time.dt, or leave it out"));
    }
    let at = place(document, "load.impulse.at", &impulse.at, mesh.dims)?;
    let value = place(document, "load.impulse.value", &impulse.value, mesh.dims)?;
    let vertex = mesh.nearest(&at);
    if mesh.held.get(vertex).copied().unwrap_or(true) {
        return Err(document.refuse(
            "load.impulse.at",
            "is next to a vertex that is held; hit a free one",
        ));
    }
    Ok(Some((vertex, value)))
}

/// What is added to free vertices in the first step: upwards, times sin(pi x / length).
fn bump(document: &Document, load: &RawLoad, mesh: &OwnedMesh) -> Result<Vec<f64>, Failure> {
    let Some(height) = load.bump else {
        return Ok(Vec::new());
    };
    let height = document.number("load.bump", height, Numbers::Finite)?;
    let [low, high] = mesh.extent().first().copied().unwrap_or([0.0, 1.0]);
    let mut bump = vec![0.0; mesh.rest.len()];
    let rows = mesh
        .rest
        .chunks_exact(mesh.dims)
        .zip(bump.chunks_exact_mut(mesh.dims));
    for ((place, to), held) in rows.zip(&mesh.held) {
        if let (false, Some(x), Some(up)) = (*held, place.first(), to.last_mut()) {
            *up = height * (core::f64::consts::PI * (x - low) / (high - low)).sin();
        }
    }
    Ok(bump)
}

fn methods(document: &Document, raw: &RawSolver) -> Result<Vec<Update>, Failure> {
    let given = raw
        .methods
        .clone()
        .unwrap_or_else(|| vec![Update::default().name().into()]);
    let mut methods = Vec::new();
    for word in &given {
        let method = document.word("solver.methods", word)?;
        if !methods.contains(&method) {
            methods.push(method);
        }
    }
    if methods.is_empty() {
        return Err(document.outside("solver.methods", "empty", "a list of at least one method"));
    }
    Ok(methods)
}

fn bases(document: &Document, raw: &RawSolver) -> Result<Vec<Basis>, Failure> {
    let key = "solver.basis";
    let wrong = |found: &Value| document.outside(key, shown(found), "a word or a list of words");
    let words: Vec<String> = match &raw.basis {
        None => return Ok(vec![Basis::default()]),
        Some(Value::String(word)) => vec![word.clone()],
        Some(Value::Array(words)) if !words.is_empty() => {
            let word = |word: &Value| word.as_str().map(str::to_owned).ok_or_else(|| wrong(word));
            words.iter().map(word).collect::<Result<_, _>>()?
        }
        Some(other) => return Err(wrong(other)),
    };
    words.iter().map(|word| document.word(key, word)).collect()
}

fn params(document: &Document, raw: &RawSolver, dt: Option<f64>) -> Result<CondenseParams, Failure> {
    let base = CondenseParams::default();
    let whole = |key: &str, found: Option<i64>, otherwise: usize, least: usize| match found {
        None => Ok(otherwise),
        Some(found) => document.whole(&format!("solver.{key}"), found, least..=MOST),
    };
    let word = |word: &Option<String>| word.clone();
    Ok(CondenseParams {
        rebuild: whole("rebuild", raw.rebuild, base.rebuild, 1)?,
        cap: whole("cap", raw.cap, base.cap, 1)?,
        radius: raw
            .radius
            .map(|radius| document.whole("solver.radius", radius, 0..=MOST))
            .transpose()?,
        seed: whole("seed", raw.seed, base.seed as usize, 0)? as u64,
        tolerance: document.number(
            "solver.tolerance",
            raw.tolerance.unwrap_or(base.tolerance),
            Numbers::Positive,
        )?,
        noise: document.number("solver.noise", raw.noise.unwrap_or(0.0), Numbers::NotNegative)?,
        block: word(&raw.block).map_or(Ok(base.block), |word| document.word("solver.block", &word))?,
        order: word(&raw.order).map_or(Ok(base.order), |word| document.word("solver.order", &word))?,
        search: raw.search.unwrap_or(true),
        dt,
        ..base
    })
}

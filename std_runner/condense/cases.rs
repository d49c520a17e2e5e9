//! What is solved: the problem at every value of its sweeps, each by every method with every basis that it takes.

use super::presets::{preset, preset_names};
use super::raw::RawSweep;
use super::scene::Problem;
use crate::exit::Failure;
use crate::scene::{Document, read, shown};
use std::collections::BTreeSet;
use std::path::Path;
use thurible_core::Named;
use thurible_core::condense::{Basis, CondenseError, CondenseParams, Update};
use toml::Value;

/// Problems of a scene at most.
const MOST: usize = 1000;

/// A problem by one value of every sweep.
#[derive(Clone, Debug)]
pub(super) struct Case {
    /// The values, as in `young 100`; empty where nothing is swept.
    pub label: String,
    pub document: Document,
    pub problem: Problem,
    pub variants: Vec<Variant>,
}

/// A way to solve it.
#[derive(Clone, Debug)]
pub(super) struct Variant {
    /// Its name, which is that of its folder.
    pub name: String,
    pub params: CondenseParams,
}

/// Reads the preset or the scene file `name`, and applies what the command line changes: options, keys and values.
pub(crate) fn document(
    name: &str,
    changes: &[(String, String, Value)],
    set: &[String],
) -> Result<Document, Failure> {
    let path = Path::new(name);
    let mut document = if path.extension().is_some_and(|end| end == "toml") {
        Document::read(path)?
    } else {
        let found = preset(name).ok_or_else(|| {
            Failure::Input(format!(
                "\"{name}\" is neither a preset nor the name of a scene file that ends in .toml; presets are {}",
                preset_names().join(", ")
            ))
        })?;
        Document::parse(path, found.text.into())?
    };
    for assignment in set {
        document.set(assignment)?;
    }
    for (option, key, value) in changes {
        document.replace(option.clone(), key, value.clone())?;
    }
    Ok(document)
}

/// All cases of a document, whose meshes take no more than `most` bytes together.
pub(super) fn cases(document: &Document, mut most: usize) -> Result<Vec<Case>, Failure> {
    let mut documents = vec![(String::new(), document.clone())];
    for (index, sweep) in sweeps(document)? {
        let place = format!("sweep[{index}]");
        if sweep.values.is_empty() || sweep.values.len() * documents.len() > MOST {
            let why = format!(
                "has {} values; give some, and no more than {MOST} problems in all",
                sweep.values.len()
            );
            return Err(document.refuse(&format!("{place}.values"), why));
        }
        let mut next = Vec::new();
        for (label, document) in &documents {
            for value in &sweep.values {
                let mut document = document.clone();
                document.replace(document.place(&place), &sweep.key, value.clone())?;
                let gap = if label.is_empty() { "" } else { ", " };
                next.push((format!("{label}{gap}{}", named(&sweep.key, value)), document));
            }
        }
        let mut folders = BTreeSet::new();
        let twice = |(label, _): &&(String, Document)| !folders.insert(folder(label));
        if let Some((label, _)) = next.iter().find(twice) {
            let why = format!(
                "has values whose results would lie in one folder, {}; leave one of them out",
                folder(label)
            );
            return Err(document.refuse(&format!("{place}.values"), why));
        }
        documents = next;
    }
    let mut all = Vec::new();
    for (label, document) in documents {
        let case = case(label, document, most)?;
        most = most.saturating_sub(case.problem.mesh.bytes());
        all.push(case);
    }
    Ok(all)
}

/// The sweeps with their places, but for those of keys that the command line sets.
fn sweeps(document: &Document) -> Result<Vec<(usize, RawSweep)>, Failure> {
    let Some(raw) = document.table().get("sweep") else {
        return Ok(Vec::new());
    };
    let sweeps: Vec<RawSweep> = read(document, "sweep", raw.clone())?;
    for (index, sweep) in sweeps.iter().enumerate() {
        if sweeps.iter().take(index).any(|other| other.key == sweep.key) {
            let why = format!(
                "is {}, which is swept before; give all its values in one list",
                sweep.key
            );
            return Err(document.refuse(&format!("sweep[{index}].key"), why));
        }
    }
    let set: Vec<&str> = document
        .assignments()
        .filter_map(|set| Some(set.split_once('=')?.0.trim()))
        .collect();
    Ok(sweeps
        .into_iter()
        .enumerate()
        .filter(|(_, sweep)| !set.contains(&sweep.key.as_str()))
        .collect())
}

/// `young 100`, `grid 8 x 8`.
fn named(key: &str, value: &Value) -> String {
    let name = key.rsplit('.').next().unwrap_or(key).replace('_', " ");
    let number = |value: &Value| match value {
        Value::Float(value) => format!("{value}"),
        Value::String(word) => word.clone(),
        other => shown(other),
    };
    let value = match value {
        Value::Array(items) => items.iter().map(number).collect::<Vec<_>>().join(" x "),
        other => number(other),
    };
    format!("{name} {value}")
}

/// The folder of a case: its label, in letters that every system takes.
pub(super) fn folder(label: &str) -> String {
    let plain = |letter: char| letter.is_ascii_alphanumeric() || matches!(letter, '.' | '-');
    let letters = label.chars();
    let letters: String = letters
        .map(|letter| if plain(letter) { letter } else { '_' })
        .collect();
    letters.replace("__", "_")
}

fn case(label: String, document: Document, most: usize) -> Result<Case, Failure> {
    let problem = Problem::of(&document, most)?;
    let mut variants: Vec<Variant> = Vec::new();
    let takes = problem.methods.iter().any(|method| method.is_built());
    if problem.basis_given && !takes {
        let name = problem.methods.first().map_or("newton", |method| method.name());
        return Err(document.refuse("solver.basis", format!("is for methods that have one, and \"{name}\" has none; leave it out, or add the method \"cc\"")));
    }
    let keeps = problem.methods.iter().any(|method| method.keeps_basis());
    if !keeps && (problem.params.radius.is_some() || problem.params.noise > 0.0) {
        let key = if problem.params.radius.is_some() {
            "solver.radius"
        } else {
            "solver.noise"
        };
        return Err(document.refuse(
            key,
            "is for methods that keep a basis; leave it out, or add the method \"cc\"",
        ));
    }
    for &method in &problem.methods {
        for &basis in &problem.bases {
            let Some(variant) = variant(&document, &problem, method, basis)? else {
                continue;
            };
            if variants.iter().all(|other| other.name != variant.name) {
                variants.push(variant);
            }
        }
    }
    Ok(Case {
        label,
        document,
        problem,
        variants,
    })
}

/// A method with a basis; none where another one is the same. Newton's method and `plain` have none, `chord` does not turn, `warped` always does.
fn variant(
    document: &Document,
    problem: &Problem,
    method: Update,
    basis: Basis,
) -> Result<Option<Variant>, Failure> {
    let unturned = match basis {
        Basis::Corotated => Basis::Fixed,
        Basis::CorotatedRebuilt => Basis::Rebuilt,
        Basis::CorotatedAdaptive => Basis::Adaptive,
        other => other,
    };
    let basis = match method {
        Update::Newton | Update::Plain => Basis::Fixed,
        Update::Warped => unturned,
        Update::Chord if basis.turns() && (problem.methods.len() > 1 || problem.bases.len() > 1) => {
            return Ok(None);
        }
        _ => basis,
    };
    let keeps = method.keeps_basis();
    let params = CondenseParams {
        method,
        basis,
        radius: problem.params.radius.filter(|_| keeps),
        noise: if keeps { problem.params.noise } else { 0.0 },
        ..problem.params
    };
    params.check(problem.mesh.dims).map_err(|error| {
        let key = match error {
            CondenseError::Colours { .. } => "solver.order",
            CondenseError::NoTurn { .. } => "solver.basis",
            _ => "solver",
        };
        document.refuse(key, format!("is refused: {error}; change it"))
    })?;
    let name = if method.is_built() {
        format!("{}-{}", method.name(), basis.name())
    } else {
        method.name().into()
    };
    Ok(Some(Variant { name, params }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn meshes_that_take_more_than_is_left_are_refused_before_they_are_made() {
        let text = "mesh = { grid = [8, 8] }\nhold = [{ box = { min = [0, 0], max = [0, 1] } }]\n\
                    [[sweep]]\nkey = \"mesh.grid\"\nvalues = [[4, 4], [4000, 4000]]\n";
        let document = Document::parse(Path::new("a.toml"), text.into());
        let refused = document.map(|document| cases(&document, 1 << 20).map(|cases| cases.len()));
        let Ok(Err(Failure::Memory(why))) = refused else {
            unreachable!("{refused:?}");
        };
        assert!(
            why.contains("`mesh.grid` is [4000, 4000]") && why.contains("--memory-limit"),
            "{why}"
        );
    }
}

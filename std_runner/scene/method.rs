//! `[method]`, `[advection]` and `[simulation]`: how a scene is solved.

use super::check::shown;
use super::document::Document;
use super::model::MethodSection;
use super::raw::{RawAdmm, RawAdvection, RawDirect, RawLbfgs, RawMethod, RawPd, RawSimulation};
use crate::exit::Failure;
use core::ops::RangeInclusive;
use thurible_core::solver::MAX_ITERATIONS;
use thurible_core::{
    AdmmParams, Advection, DirectParams, LbfgsParams, Method, Named, NsoParams, Params, PdParams, Problem,
    SimulationParams,
};
use toml::Value;

pub(super) fn advection(document: &Document, raw: RawAdvection) -> Result<Advection, Failure> {
    let Advection { scheme, tolerance } = Advection::default();
    Ok(Advection {
        scheme: word(document, "advection.scheme", raw.scheme, scheme)?,
        tolerance: document.between("advection.tolerance", raw.tolerance.unwrap_or(tolerance), 1.0)?,
    })
}

/// A count, or the one that is meant where there is none.
fn whole(
    document: &Document,
    key: &str,
    count: Option<i64>,
    allowed: RangeInclusive<usize>,
    standard: usize,
) -> Result<usize, Failure> {
    count.map_or(Ok(standard), |count| document.whole(key, count, allowed))
}

/// The choice that a word stands for, or the one that is made where there is none.
fn word<T: Named>(document: &Document, key: &str, word: Option<String>, standard: T) -> Result<T, Failure> {
    word.map_or(Ok(standard), |word| document.word(key, &word))
}

/// A method that steers: a scene is simulated by a command of its own.
fn method_name(document: &Document, word: Option<String>) -> Result<Method, Failure> {
    let steers: Vec<Method> = Method::ALL
        .iter()
        .copied()
        .filter(|&method| method != Method::Simulate)
        .collect();
    word.map_or_else(
        || Ok(Method::default()),
        |word| document.one_of("method.name", &word, &steers),
    )
}

pub(super) fn method(document: &Document, raw: RawMethod) -> Result<MethodSection, Failure> {
    let standard = Problem::new(&[], &[], &[]).projection_tolerance;
    let projection = raw.projection.tolerance.unwrap_or(standard);
    Ok(MethodSection {
        name: method_name(document, raw.name)?,
        iterations: whole(
            document,
            "method.iterations",
            raw.iterations,
            1..=MAX_ITERATIONS,
            Params::default().iterations,
        )?,
        direct: direct(document, raw.direct)?,
        admm: admm(document, raw.admm)?,
        lbfgs: lbfgs(document, raw.lbfgs)?,
        pd: pd(document, raw.pd)?,
        projection_tolerance: document.between("method.projection.tolerance", projection, 1.0)?,
    })
}

fn lbfgs(document: &Document, raw: RawLbfgs) -> Result<LbfgsParams, Failure> {
    let standard = LbfgsParams::default();
    Ok(LbfgsParams {
        history: pairs(document, "method.lbfgs.history", raw.history, LbfgsParams::MOST)?,
        tolerance: document.between(
            "method.lbfgs.tolerance",
            raw.tolerance.unwrap_or(standard.tolerance),
            1.0,
        )?,
        nested: raw.nested.unwrap_or(standard.nested),
    })
}

fn pd(document: &Document, raw: RawPd) -> Result<PdParams, Failure> {
    let standard = PdParams::default();
    Ok(PdParams {
        drive: document.not_negative("method.pd.drive", raw.drive.unwrap_or(standard.drive))?,
        attenuation: document.not_negative(
            "method.pd.attenuation",
            raw.attenuation.unwrap_or(standard.attenuation),
        )?,
        gathering: document
            .not_negative("method.pd.gathering", raw.gathering.unwrap_or(standard.gathering))?,
    })
}

pub(super) fn simulation(document: &Document, raw: RawSimulation) -> Result<SimulationParams, Failure> {
    let standard = SimulationParams::default();
    Ok(SimulationParams {
        buoyancy: document.finite("simulation.buoyancy", raw.buoyancy.unwrap_or(standard.buoyancy))?,
        tolerance: document.between(
            "simulation.tolerance",
            raw.tolerance.unwrap_or(standard.tolerance),
            1.0,
        )?,
    })
}

/// Pairs of L-BFGS, from 1 to `most`, or `None` for as many as memory allows.
fn pairs(document: &Document, key: &str, raw: Option<Value>, most: usize) -> Result<Option<usize>, Failure> {
    match raw {
        None => Ok(None),
        Some(Value::String(word)) if word == "auto" => Ok(None),
        Some(Value::Integer(count)) => document.whole(key, count, 1..=most).map(Some),
        Some(other) => Err(document.outside(
            key,
            shown(&other),
            &format!("\"auto\" or a whole number from 1 to {most}"),
        )),
    }
}

fn direct(document: &Document, raw: RawDirect) -> Result<DirectParams, Failure> {
    let standard = DirectParams::default();
    Ok(DirectParams {
        history: pairs(document, "method.direct.history", raw.history, DirectParams::MOST)?,
        tolerance: document.between(
            "method.direct.tolerance",
            raw.tolerance.unwrap_or(standard.tolerance),
            1.0,
        )?,
        nested: raw.nested.unwrap_or(standard.nested),
        ..standard
    })
}

fn admm(document: &Document, raw: RawAdmm) -> Result<AdmmParams, Failure> {
    let key = |name: &str| format!("method.admm.{name}");
    let standard = AdmmParams::default();
    let nso = NsoParams {
        solver: word(document, &key("nso"), raw.nso, standard.nso.solver)?,
        tolerance: document.between(
            &key("nso_tolerance"),
            raw.nso_tolerance.unwrap_or(standard.nso.tolerance),
            1.0,
        )?,
        norm: word(document, &key("nso_norm"), raw.nso_norm, standard.nso.norm)?,
        colours: word(
            document,
            &key("smoother_colours"),
            raw.smoother_colours,
            standard.nso.colours,
        )?,
        ..standard.nso
    };
    Ok(AdmmParams {
        penalty: document.positive(&key("penalty"), raw.penalty.unwrap_or(standard.penalty))?,
        relaxation: document.between(
            &key("relaxation"),
            raw.relaxation.unwrap_or(standard.relaxation),
            2.0,
        )?,
        ao_iterations: whole(
            document,
            &key("ao_iterations"),
            raw.ao_iterations,
            1..=AdmmParams::MOST_AO_ITERATIONS,
            standard.ao_iterations,
        )?,
        ao_momentum: document.fraction(
            &key("ao_momentum"),
            raw.ao_momentum.unwrap_or(standard.ao_momentum),
        )?,
        density_tolerance: document.between(
            &key("density_tolerance"),
            raw.density_tolerance.unwrap_or(standard.density_tolerance),
            1.0,
        )?,
        nested: raw.nested.unwrap_or(standard.nested),
        nso,
        ..standard
    })
}

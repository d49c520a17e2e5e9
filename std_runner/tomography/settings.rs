//! The section `tomography` of a file of views.

use super::raw::RawSettings;
use crate::exit::Failure;
use crate::scene::Document;
use thurible_core::Named;
use thurible_core::tomography::{Method, Settings, TomographyError};
use toml::Value;

/// The settings, and whether gamma is still to be found from the pictures.
pub(super) struct Chosen {
    pub settings: Settings,
    pub automatic_gamma: bool,
}

/// Reads the settings for a box of `cells` seen by `cameras`.
pub(super) fn chosen(
    document: &Document,
    raw: &RawSettings,
    cells: &[usize],
    cameras: usize,
) -> Result<Chosen, Failure> {
    let default = Settings::default();
    let budget = Settings::automatic_budget(cells.iter().product(), cameras) as f64;
    let prior = word(document, "prior", raw.prior.as_deref(), default.prior)?;
    if raw.volume == Some(false) && prior.on_images().is_none() {
        let why = format!(
            "is false, but the prior {} is on the volume; take image_tv or image_sad, or leave it out",
            prior.name()
        );
        return Err(document.refuse("tomography.volume", why));
    }
    let gamma = automatic(document, "gamma", raw.gamma.as_ref())?;
    let settings = Settings {
        method: word(document, "method", raw.method.as_deref(), default.method)?,
        prior,
        gamma: gamma.unwrap_or(default.gamma),
        nonnegative: raw.nonnegative.unwrap_or(default.nonnegative),
        volume: raw.volume.unwrap_or(prior.on_images().is_none()),
        sigma: raw.sigma.unwrap_or(default.sigma),
        length: raw.length.unwrap_or(default.length),
        budget: whole(document, raw.budget.unwrap_or(budget))?,
        eps: automatic(document, "eps", raw.eps.as_ref())?,
        accept: raw.accept.unwrap_or(default.accept),
        tolerance: raw.tolerance.unwrap_or(default.tolerance),
        rule: word(document, "walk", raw.walk.as_deref(), default.rule)?,
        hull_threshold: raw.hull_threshold.unwrap_or(default.hull_threshold),
        seed: raw.seed.unwrap_or(default.seed),
        warm: raw.warm.unwrap_or(default.warm),
        warm_budget: raw.warm_budget.unwrap_or(default.warm_budget),
        sweeps: raw.sweeps.unwrap_or(default.sweeps),
        relax: raw.relax.unwrap_or(default.relax),
    };
    settings.check().map_err(|error| match error {
        TomographyError::Setting { name, allowed } => document.refuse(
            &format!("tomography.{name}"),
            format!("must be {allowed}; change it"),
        ),
        other => document.refuse("tomography", other),
    })?;
    Ok(Chosen {
        settings,
        automatic_gamma: gamma.is_none(),
    })
}

/// What is said of choices of the walk where it does not reconstruct.
pub(super) fn unheard(settings: &Settings, raw: &RawSettings) -> Option<String> {
    let given = raw.prior.is_some() || raw.gamma.is_some();
    (settings.method == Method::Sart && given)
        .then(|| "`tomography.prior` and `tomography.gamma` are the walk's, and do nothing with sart".into())
}

fn word<T: Named>(document: &Document, key: &str, found: Option<&str>, default: T) -> Result<T, Failure> {
    found.map_or(Ok(default), |found| {
        T::from_name(found).map_err(|allowed| {
            document.refuse(
                &format!("tomography.{key}"),
                format!("is \"{found}\"; allowed is {allowed}"),
            )
        })
    })
}

/// A number, or `None` for "auto".
fn automatic(document: &Document, key: &str, found: Option<&Value>) -> Result<Option<f64>, Failure> {
    match found {
        None => Ok(None),
        Some(Value::String(word)) if word == "auto" => Ok(None),
        Some(Value::Float(number)) => Ok(Some(*number)),
        Some(Value::Integer(number)) => Ok(Some(*number as f64)),
        Some(other) => Err(document.refuse(
            &format!("tomography.{key}"),
            format!("is {other}; write a number, or \"auto\""),
        )),
    }
}

/// Mutations, which people write as 6e6.
fn whole(document: &Document, found: f64) -> Result<u64, Failure> {
    if (1.0..1e15).contains(&found) {
        return Ok(found as u64);
    }
    let why = format!("is {found}; write a number of mutations from 1 to 1e15, as in 6e6");
    Err(document.refuse("tomography.budget", why))
}

//! The image, `result.npz`, `report.json` and the page of a restoration.

use super::light::{Image, Light, interleaved};
use super::request::Request;
use crate::output::{OutputError, Plain, Tone, colour_plate, plate, write_arrays, write_bytes};
use crate::report::{self, Block, Chart, Curve, Document, Scale, Shot, Table, bytes, number, seconds};
use crate::run::command_line;
use serde_json::{Value, json};
use std::path::Path;
use thurible_core::Named;
use thurible_core::deblur::Deblur;
use thurible_core::memory::Ledger;

/// What a run came to.
pub(super) struct Outcome<'a> {
    pub request: &'a Request,
    pub problem: &'a Deblur<'a>,
    pub image: &'a Image,
    pub light: Light,
    /// The restored image, planes of the channels one after the other.
    pub inner: Vec<f64>,
    pub residual: Vec<f64>,
    pub history: Vec<Value>,
    pub interrupted: bool,
    pub planned: usize,
    pub used: usize,
    pub ledger: Ledger,
    pub precision: &'static str,
    pub seconds: f64,
    pub psnr: Option<f64>,
    pub blurred_psnr: Option<f64>,
}

impl Outcome<'_> {
    /// How it ended, in a word.
    pub fn status(&self) -> &'static str {
        if self.interrupted {
            "cancelled"
        } else {
            "converged"
        }
    }

    fn record(&self) -> Value {
        let tuning = self.problem.tuning;
        let ledger = self.ledger.entries().iter();
        let ledger =
            ledger.map(|entry| json!({ "name": entry.name, "bytes": entry.bytes, "depth": entry.depth }));
        json!({
            "format": 1,
            "kind": "deblur",
            "width": self.image.width,
            "height": self.image.height,
            "channels": self.image.channels,
            "kernels": self.problem.kernels.count(),
            "radius": self.problem.kernels.radius,
            "precision": self.precision,
            "version": env!("CARGO_PKG_VERSION"),
            "status": self.status(),
            "seconds": self.seconds,
            "memory": {
                "planned_bytes": self.planned,
                "used_bytes": self.used,
                "ledger": ledger.collect::<Vec<_>>(),
            },
            "command": command_line(),
            "psf": self.request.psf,
            "deblur": {
                "method": tuning.method.name(),
                "prior": tuning.prior.name(),
                "gamma": tuning.gamma,
                "nonnegative": tuning.nonnegative,
                "saturation": tuning.saturation,
                "sigma": tuning.sigma,
                "budget": tuning.budget,
                "eps": tuning.eps,
                "tau": tuning.tau,
                "move": tuning.moves.name(),
                "eps_min": tuning.eps_min,
                "colours": tuning.colours,
                "mu": tuning.mu,
                "iterations": tuning.iterations,
                "seed": tuning.seed,
            },
            "psnr": self.psnr,
            "blurred_psnr": self.blurred_psnr,
            "history": self.history,
        })
    }

    /// Planes as a PNG file, coded as the image was.
    fn png(&self, planes: &[f64]) -> Result<Vec<u8>, OutputError> {
        let channels = self.image.channels;
        let values: Vec<f32> = interleaved(planes, channels)
            .into_iter()
            .map(|light| self.light.coded(light.clamp(0.0, 1.0)) as f32)
            .collect();
        colour_plate(&values, self.image.width, channels)
    }
}

/// Writes all files into `folder`.
pub(super) fn write(folder: &Path, outcome: &Outcome<'_>) -> Result<(), OutputError> {
    let Image {
        width,
        height,
        channels,
        ..
    } = *outcome.image;
    let shape = if channels == 1 {
        vec![height, width]
    } else {
        vec![height, width, channels]
    };
    let [image, residual] = [&outcome.inner, &outcome.residual].map(|planes| interleaved(planes, channels));
    let arrays = [("image", &image), ("residual", &residual)].map(|(name, values)| Plain {
        name: name.into(),
        shape: shape.clone(),
        parts: vec![values.as_slice()],
    });
    write_arrays(&folder.join(report::ARCHIVE), &arrays)?;
    write_bytes(&folder.join("image.png"), &outcome.png(&outcome.inner)?)?;
    let path = folder.join("report.json");
    let json = serde_json::to_vec_pretty(&outcome.record()).map_err(OutputError::of(&path))?;
    write_bytes(&path, &json)?;
    page(outcome)?.write(folder, "report")
}

fn page(outcome: &Outcome<'_>) -> Result<Document, OutputError> {
    let shot = |caption: &str, png: Vec<u8>| Shot {
        caption: caption.into(),
        png,
    };
    let worst = outcome
        .residual
        .iter()
        .fold(f64::MIN_POSITIVE, |most, value| most.max(value.abs()));
    let left: Vec<f32> = outcome
        .residual
        .iter()
        .take(outcome.image.width * outcome.image.height)
        .map(|value| (value / worst) as f32)
        .collect();
    let kernel = outcome.problem.kernels;
    let number_of = kernel.side() * kernel.side();
    let most = kernel.values.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
    let kernels: Vec<f32> = kernel
        .values
        .iter()
        .take(number_of)
        .map(|value| (value / most) as f32)
        .collect();
    let pictures = vec![
        shot("as it was taken", outcome.png(&outcome.image.values)?),
        shot("restored", outcome.png(&outcome.inner)?),
        shot(
            "what is left, first channel",
            plate(&left, outcome.image.width, Tone::Difference)?,
        ),
        shot("the kernel", plate(&kernels, kernel.side(), Tone::Light)?),
    ];
    Ok(Document {
        title: "Deconvolution".into(),
        lead: format!(
            "{} x {} pixels by {}, {}.",
            outcome.image.width,
            outcome.image.height,
            outcome.problem.tuning.method.name(),
            outcome.status()
        ),
        blocks: vec![
            facts(outcome),
            Block::Pictures(pictures),
            Block::Heading("The way there".into()),
            Block::Charts(charts(outcome)),
        ],
        pictures: false,
    })
}

fn facts(outcome: &Outcome<'_>) -> Block {
    let tuning = outcome.problem.tuning;
    let last = outcome
        .history
        .last()
        .and_then(|entry| entry.get("objective"))
        .and_then(Value::as_f64);
    let mut rows = vec![
        ("objective", number(last.unwrap_or_default())),
        (
            "prior, gamma",
            format!("{}, {}", tuning.prior.name(), number(tuning.gamma)),
        ),
        ("seconds", seconds(outcome.seconds)),
        ("memory", bytes(outcome.planned)),
    ];
    if let (Some(before), Some(after)) = (outcome.blurred_psnr, outcome.psnr) {
        rows.insert(
            0,
            ("PSNR, before and after", format!("{before:.2} and {after:.2} dB")),
        );
    }
    Block::Table(Table::of_facts(rows))
}

fn charts(outcome: &Outcome<'_>) -> Vec<Chart> {
    let curve = |name: &str, colour: usize, key: &str| {
        let points = outcome.history.iter().filter_map(|entry| {
            let at = |key: &str| entry.get(key).and_then(Value::as_f64);
            Some((at("chain")?, at(key)?))
        });
        Curve::new(name, colour, points)
    };
    let chart = |title: &'static str, curves: Vec<Curve>| Chart {
        title,
        note: String::new(),
        across: "chains, or iterations",
        scale: Scale::Counts,
        curves,
    };
    let mut charts = vec![
        chart(
            "The objective",
            vec![curve("objective", 1, "objective"), curve("prior", 2, "prior")],
        ),
        chart(
            "The chains",
            vec![curve("acceptance", 1, "acceptance"), curve("eps", 2, "eps")],
        ),
    ];
    if outcome.psnr.is_some() {
        charts.push(chart("PSNR in dB", vec![curve("PSNR", 3, "psnr")]));
    }
    charts
}

//! One run: from an image to its result folder.

use super::light::{Image, Light};
use super::psf::Psf;
use super::request::Request;
use super::written::{Outcome, write};
use crate::destination::Destination;
use crate::exit::{DONE, FILE, Failure, INTERRUPTED};
use crate::interrupt::Interrupt;
use crate::ledger::{plan_event, print_least};
use crate::problem::Precision;
use crate::progress::{Clock, Display, Mode, in_words};
use crate::region::{MARGIN, Region, touch};
use crate::{bytes, console};
use serde_json::{Value, json};
use std::path::PathBuf;
use thurible_core::deblur::{Deblur, DeblurError, Frame, Kernels, Restoration};
use thurible_core::memory::Ledger;
use thurible_core::{Named, Real};

/// Mutations between two looks at whether the user wants to stop.
const BREATH: u64 = 100_000;

/// Restores an image; the answer is the exit code.
pub(crate) fn restore(request: &Request) -> Result<u8, Failure> {
    let clock = Clock::start();
    let light = request.light.unwrap_or_else(|| Light::of(&request.image));
    let image = Image::read("image", &request.image, light)?;
    let psf = Psf::read(&request.psf, [image.width, image.height])?;
    let truth = request.truth.as_ref().map(|path| {
        let truth = Image::read("truth", path, request.light.unwrap_or_else(|| Light::of(path)))?;
        if [truth.width, truth.height, truth.channels] != [image.width, image.height, image.channels] {
            let (path, [width, height]) = (path.display(), [truth.width, truth.height]);
            return Err(Failure::Input(format!(
                "--truth {path} has {width} x {height} pixels of {} channels, and the image {} x {} of {}; give the sharp image of the same size",
                truth.channels, image.width, image.height, image.channels
            )));
        }
        Ok(truth)
    });
    let truth = truth.transpose()?;
    let problem = Deblur {
        frame: Frame {
            width: image.width,
            height: image.height,
            channels: image.channels,
            border: psf.radius,
        },
        kernels: Kernels {
            radius: psf.radius,
            values: &psf.values,
            which: &psf.which,
        },
        tuning: request.tuning,
    };
    problem
        .check()
        .map_err(|error| refused(request, &problem, &error))?;
    match request.precision {
        Precision::F32 => solve::<f32>(request, &problem, &image, truth.as_ref(), light, clock),
        Precision::F64 => solve::<f64>(request, &problem, &image, truth.as_ref(), light, clock),
    }
}

fn refused(request: &Request, problem: &Deblur<'_>, error: &DeblurError) -> Failure {
    let image = request.image.display();
    let (side, frame) = (problem.kernels.side(), problem.frame);
    Failure::Input(match error {
        DeblurError::KernelTooLarge => format!(
            "--psf {}: the kernel is {side} x {side}, odd as kernels are here, larger than the image `{image}` of {} x {} pixels; give a smaller kernel, or cut its dark edges off",
            request.psf, frame.width, frame.height
        ),
        DeblurError::Setting { name, allowed } => {
            format!("--{}: must be {allowed}; change it", name.replace('_', "-"))
        }
        DeblurError::Saturated => format!(
            "image `{image}` has no pixel below --saturation {}; raise it",
            request.tuning.saturation.unwrap_or_default()
        ),
        other => format!("image `{image}`: {other}; check the image and --psf"),
    })
}

fn solve<T: Real>(
    request: &Request,
    problem: &Deblur<'_>,
    image: &Image,
    truth: Option<&Image>,
    light: Light,
    clock: Clock,
) -> Result<u8, Failure> {
    let mut ledger = Ledger::new();
    Restoration::<T>::plan(problem, &mut ledger);
    let planned = ledger.bytes().unwrap_or(usize::MAX);
    if request.plan {
        print_plan(request, &ledger, planned);
        return Ok(DONE);
    }
    let limit = request.limit.or_else(bytes::of_machine).unwrap_or(usize::MAX);
    let too_large = || {
        Failure::Memory(format!(
            "image `{}` takes {} bytes ({}), and no more than {} bytes are allowed; raise --memory-limit, or cut the image",
            request.image.display(),
            bytes::grouped(planned.saturating_add(MARGIN)),
            bytes::rounded(planned.saturating_add(MARGIN)),
            bytes::grouped(limit)
        ))
    };
    if planned.saturating_add(MARGIN) > limit {
        return Err(too_large());
    }
    let files = [
        "image.png",
        "result.npz",
        "report.json",
        "report.html",
        "report.md",
    ];
    let mut destination = Destination::check(&request.folder, files.map(PathBuf::from).to_vec())?;
    let interrupt = Interrupt::listen()?;
    let mut region = Region::new(planned).ok_or_else(too_large)?;
    let used = region.footprint();
    let block = region.carve(planned).ok_or_else(too_large)?;
    touch(block);
    let measured: Vec<T> = image.values.iter().map(|&value| T::from_f64(value)).collect();
    let mut restoration = Restoration::<T>::new(*problem, &measured, block)
        .map_err(|error| refused(request, problem, &error))?;
    let display = Display::new(request.mode, restoration.pieces());
    announce::<T>(request, problem, planned, &display);
    let history = go(&mut restoration, problem, truth, &interrupt, &display, &clock);
    let outcome = Outcome {
        request,
        problem,
        image,
        light,
        inner: inner(&restoration, problem),
        residual: restoration
            .residual()
            .iter()
            .map(|value| value.to_f64())
            .collect(),
        history,
        interrupted: !restoration.over(),
        planned,
        used,
        ledger,
        precision: T::NAME,
        seconds: clock.total(),
        psnr: truth.map(|truth| psnr(&inner(&restoration, problem), &truth.values)),
        blurred_psnr: truth.map(|truth| psnr(&image.values, &truth.values)),
    };
    destination.fill(|folder| write(folder, &outcome))?;
    display.close();
    Ok(say(&outcome, &destination, &display))
}

/// The image without its border.
fn inner<T: Real>(restoration: &Restoration<'_, T>, problem: &Deblur<'_>) -> Vec<f64> {
    let frame = problem.frame;
    let planes = restoration.planes().chunks_exact(frame.unknowns());
    planes
        .flat_map(|plane| {
            let value = move |pixel| {
                plane
                    .get(frame.bordered(pixel))
                    .map_or(0.0, |value| value.to_f64())
            };
            (0..frame.pixels()).map(value)
        })
        .collect()
}

/// Peak signal to noise in dB, of a peak of 1.
fn psnr(values: &[f64], truth: &[f64]) -> f64 {
    let square = |(value, truth): (&f64, &f64)| (value - truth).powi(2);
    let sum: f64 = values.iter().zip(truth).map(square).sum();
    -10.0 * (sum / truth.len().max(1) as f64).log10()
}

/// Runs chain after chain, or iteration after iteration; the history of the objective.
fn go<T: Real>(
    restoration: &mut Restoration<'_, T>,
    problem: &Deblur<'_>,
    truth: Option<&Image>,
    interrupt: &Interrupt,
    display: &Display,
    clock: &Clock,
) -> Vec<Value> {
    let (mut history, mut over) = (Vec::new(), false);
    while !over && !interrupt.asked() {
        let before = restoration.walked();
        let length = restoration.length();
        let mut left = length;
        let eps = restoration.eps();
        while left > 0 && !over && !interrupt.asked() {
            let count = left.min(BREATH);
            over = restoration.advance(count);
            left -= count;
            if !matches!(problem.tuning.method, thurible_core::deblur::Restorer::Walk) {
                break;
            }
        }
        let walked = restoration.walked();
        let mutations = walked.mutations - before.mutations;
        let acceptance = (walked.recorded - before.recorded) as f64 / mutations.max(1) as f64;
        let [data, prior] = restoration.objective();
        let mut entry = json!({
            "chain": history.len() + 1, "mutations": walked.mutations, "accepted": walked.recorded,
            "acceptance": acceptance, "eps": eps, "data": data, "prior": prior, "objective": data + prior,
            "seconds": clock.total(),
        });
        if let Some(truth) = truth {
            entry["psnr"] = psnr(&inner(restoration, problem), &truth.values).into();
        }
        display.event("progress", entry.clone());
        history.push(entry);
        let done = history.len();
        let left = clock.total() / done as f64 * display.limit().saturating_sub(done) as f64;
        display.piece(
            done,
            &format!(
                "objective {:.4e}, acceptance {:.1} %, {} left",
                data + prior,
                100.0 * acceptance,
                in_words(left)
            ),
        );
    }
    history
}

fn print_plan(request: &Request, ledger: &Ledger, planned: usize) {
    if request.mode == Mode::Quiet {
        return;
    }
    if request.mode == Mode::Json {
        return plan_event(ledger.entries(), planned, json!({}));
    }
    for entry in ledger.entries() {
        console::print(&format!("{:>18}  {}", bytes::grouped(entry.bytes), entry.name));
    }
    console::print(&format!("{:>18}  the block", bytes::grouped(planned)));
    print_least(planned);
}

fn announce<T: Real>(request: &Request, problem: &Deblur<'_>, planned: usize, display: &Display) {
    let (frame, tuning) = (problem.frame, problem.tuning);
    display.event("plan", json!({ "planned_bytes": planned }));
    display.note(&format!(
        "{} by {}: {} x {} pixels, {} channels, {} kernels of {side} x {side}, prior {} (gamma {:.1e}), {} bytes ({}) in {}",
        request.image.display(),
        tuning.method.name(),
        frame.width,
        frame.height,
        frame.channels,
        problem.kernels.count(),
        tuning.prior.name(),
        tuning.gamma,
        bytes::grouped(planned),
        bytes::rounded(planned),
        T::NAME,
        side = problem.kernels.side(),
    ));
}

fn say(outcome: &Outcome<'_>, destination: &Destination, display: &Display) -> u8 {
    let folder = destination.shown();
    let code = match (outcome.interrupted, destination.diverted()) {
        (true, _) => INTERRUPTED,
        (_, Some(_)) => FILE,
        _ => DONE,
    };
    display.event(
        "result",
        json!({
            "status": outcome.status(), "exit_code": code, "seconds": outcome.seconds, "psnr": outcome.psnr,
            "folder": folder.display().to_string(),
        }),
    );
    if outcome.request.mode == Mode::Human {
        let [before, after] = [outcome.blurred_psnr, outcome.psnr].map(Option::unwrap_or_default);
        let truth = outcome.psnr.map_or(String::new(), |_| {
            format!(", {after:.1} dB of {before:.1} before")
        });
        console::print(&format!(
            "{} after {}{truth}",
            outcome.status(),
            in_words(outcome.seconds)
        ));
        console::print(&format!(
            "result in {}; open {}",
            folder.display(),
            folder.join("report.html").display()
        ));
    }
    if let Some(why) = destination.diverted() {
        console::error(&format!("thurible: {why}"));
    }
    code
}

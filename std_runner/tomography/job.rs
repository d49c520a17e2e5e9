//! One run: from a file of views to its result folder.

use super::frames::{Frame, Watch, pieces, refused, run};
use super::page::draw;
use super::plan::{Plan, plan, print_plan, too_large};
use super::request::Request;
use super::views::Views;
use super::written::{Outcome, write};
use crate::destination::Destination;
use crate::exit::{DONE, FILE, Failure, INTERRUPTED};
use crate::interrupt::Interrupt;
use crate::output::Sample;
use crate::plan::size_in_words;
use crate::problem::Precision;
use crate::progress::{Clock, Display, Mode};
use crate::region::{Region, touch};
use crate::report::count;
use crate::{address_space, bytes, console, report, threads};
use serde_json::json;
use thurible_core::tomography::{Camera, Tomography};
use thurible_core::walk::Cells;
use thurible_core::{Named, Real};

/// Reconstructs the frames of a file of views; the answer is the exit code.
pub(crate) fn reconstruct(request: &Request<'_>) -> Result<u8, Failure> {
    let clock = Clock::start();
    let views = Views::load(request.views, &request.options.set)?;
    match (views.cells.len(), request.options.resources.precision) {
        (2, Some(Precision::F64)) => solve::<f64, 2>(request, views, clock),
        (2, _) => solve::<f32, 2>(request, views, clock),
        (_, Some(Precision::F64)) => solve::<f64, 3>(request, views, clock),
        _ => solve::<f32, 3>(request, views, clock),
    }
}

fn solve<T: Real + Sample, const D: usize>(
    request: &Request<'_>,
    views: Views,
    clock: Clock,
) -> Result<u8, Failure> {
    let cameras: Vec<Camera<D>> = views
        .cameras
        .iter()
        .map(|view| view.optics.camera(view.pixels))
        .collect();
    let novel = views.novel.iter();
    let novel: Vec<Camera<D>> = novel.map(|view| view.optics.camera(view.pixels)).collect();
    let problem = Tomography {
        cells: Cells {
            counts: core::array::from_fn(|axis| views.cells.get(axis).copied().unwrap_or(1)),
        },
        cameras: &cameras,
        novel: &novel,
        settings: views.settings,
    };
    problem.check().map_err(|error| refused(&views, &error))?;
    let plan = plan::<T, D>(request, &views, &problem)?;
    if request.plan {
        print_plan(request, &plan);
        return Ok(DONE);
    }
    let mut destination = Destination::check(&request.folder, report::files(views.frames - 1, true))?;
    let watch = Watch::new(
        Display::new(request.options.mode(), pieces(&views)),
        Interrupt::listen()?,
        clock,
    );
    announce::<T>(&views, &plan, &watch);
    let no_memory = || too_large(request, &views, &plan);
    let mut region = Region::new(plan.block())
        .filter(|_| bytes::are_free(plan.beside))
        .ok_or_else(no_memory)?;
    let used = region.footprint();
    address_space::check(plan.threads)?;
    threads::with(plan.threads, || {
        let block = region.carve(plan.block()).ok_or_else(no_memory)?;
        touch(block);
        let found = run::<T, D>(&views, problem, block, plan.lane, &watch)?;
        let (frames, interrupted) = kept(found);
        if frames.is_empty() {
            watch.display.close();
            console::error("thurible: interrupted before there was anything to write");
            return Ok(INTERRUPTED);
        }
        let outcome = Outcome {
            views: &views,
            frames,
            interrupted,
            plan: &plan,
            used,
            seconds: watch.clock.total(),
        };
        destination.fill(|folder| write(folder, &outcome))?;
        let result = destination.folder().to_path_buf();
        destination.add(|folder| draw(&result, folder, &outcome))?;
        watch.display.close();
        say(request, &outcome, &destination, &watch);
        Ok(match (interrupted, destination.diverted()) {
            (true, _) => INTERRUPTED,
            (_, Some(_)) => FILE,
            _ => DONE,
        })
    })?
}

/// The frames from the first on that are complete, or the first as far as it came; and whether any is missing.
fn kept<T>(found: Vec<Option<Frame<T>>>) -> (Vec<Frame<T>>, bool) {
    let count = found.len();
    let mut frames: Vec<Frame<T>> = found.into_iter().map_while(|frame| frame).collect();
    let whole = frames.iter().take_while(|frame| frame.complete).count();
    frames.truncate(whole.max(1));
    let interrupted = whole < count;
    (frames, interrupted)
}

fn announce<T: Real>(views: &Views, plan: &Plan, watch: &Watch) {
    let settings = views.settings;
    watch.display.event(
        "plan",
        json!({ "planned_bytes": plan.block(), "result_bytes": plan.beside, "frames": views.frames }),
    );
    watch.display.note(&format!(
        "{} by {}: {} cells, {} cameras, {} frames, prior {} (gamma {:.3e}), {:.3e} mutations a frame, {} bytes ({}) in {}, {}",
        views.document.path().display(),
        settings.method.name(),
        size_in_words(&views.cells),
        views.cameras.len(),
        views.frames,
        settings.prior.name(),
        settings.gamma,
        settings.budget as f64,
        bytes::grouped(plan.block()),
        bytes::rounded(plan.block()),
        T::NAME,
        count(plan.threads, "thread")
    ));
    views.notes.iter().for_each(|note| watch.display.note(note));
}

fn say<T: Real>(request: &Request<'_>, outcome: &Outcome<'_, T>, destination: &Destination, watch: &Watch) {
    let folder = destination.shown();
    let residual = outcome.frames.iter().map(|frame| frame.residual_relative);
    let residual = residual.fold(0.0, f64::max);
    let error = outcome.rms_error();
    watch.display.event(
        "result",
        json!({
            "frames": outcome.frames.len(), "seconds": outcome.seconds, "residual_relative": residual,
            "rms_error": error, "status": outcome.status(), "folder": folder.display().to_string(),
        }),
    );
    if request.options.mode() == Mode::Human {
        let truth = error.map_or(String::new(), |error| format!(", RMS error {error:.4}"));
        console::print(&format!(
            "{}: {} frames in {}, residual at most {:.2} %{truth}",
            outcome.status(),
            outcome.frames.len(),
            crate::progress::in_words(outcome.seconds),
            100.0 * residual
        ));
        console::print(&format!(
            "result in {}; open {}",
            folder.display(),
            folder.join("report.html").display()
        ));
    }
    for doubt in outcome.doubts() {
        watch.display.warning(&doubt);
    }
    if let Some(why) = destination.diverted() {
        console::error(&format!("thurible: {why}"));
    }
}

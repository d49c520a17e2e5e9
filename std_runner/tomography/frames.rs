//! The frames of a capture, each reconstructed by one thread in its lane of the block.

use super::views::Views;
use crate::exit::Failure;
use crate::interrupt::Interrupt;
use crate::progress::{Clock, Display, in_words};
use core::mem::MaybeUninit;
use rayon::prelude::*;
use serde_json::{Value, json};
use std::sync::Mutex;
use thurible_core::tomography::{Method, Reconstruction, Tomography, TomographyError};
use thurible_core::{Named, Real};

/// Mutations between two looks at whether the user wants to stop.
const BREATH: u64 = 100_000;
/// Entries of the history of a frame.
const TENTHS: u64 = 10;

/// What came of a frame.
pub(super) struct Frame<T> {
    pub density: Vec<T>,
    /// What each camera would see of it.
    pub reprojected: Vec<Vec<T>>,
    /// What each novel view shows.
    pub novel: Vec<Vec<T>>,
    pub history: Vec<Value>,
    pub rms_error: Option<f64>,
    pub residual_relative: f64,
    /// Whether it ran to its end.
    pub complete: bool,
}

impl<T: Real> Frame<T> {
    /// Whether nothing was found, although pictures have smoke.
    pub fn is_empty(&self) -> bool {
        let seen = self.residual_relative > 0.0;
        seen && !self.density.is_empty() && self.density.iter().all(|&value| value == T::ZERO)
    }
}

/// Who watches: progress, and whether to stop.
pub(super) struct Watch {
    pub display: Display,
    pub interrupt: Interrupt,
    pub clock: Clock,
    done: Mutex<u64>,
}

impl Watch {
    pub fn new(display: Display, interrupt: Interrupt, clock: Clock) -> Self {
        Self {
            display,
            interrupt,
            clock,
            done: Mutex::new(0),
        }
    }

    /// A tenth of a frame is over.
    fn tenth(&self, text: &str, entry: &Value) {
        let mut done = self.done.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
        *done += 1;
        let left = self.display.limit().saturating_sub(*done as usize) as f64;
        let left = in_words(self.clock.total() / *done as f64 * left);
        self.display.event("progress", entry.clone());
        self.display
            .piece(*done as usize, &format!("{text}, {left} left"));
    }
}

/// Pieces of progress of `frames` frames.
pub(super) fn pieces(views: &Views) -> usize {
    let each = match views.settings.method {
        Method::Walk => TENTHS as usize,
        Method::Sart => views.settings.sweeps,
    };
    views.frames * each
}

/// Reconstructs all frames in `block`, which has `bytes` for each lane. A frame that nobody came to is missing.
pub(super) fn run<T: Real, const D: usize>(
    views: &Views,
    problem: Tomography<'_, D>,
    block: &mut [MaybeUninit<u8>],
    bytes: usize,
    watch: &Watch,
) -> Result<Vec<Option<Frame<T>>>, Failure> {
    let lanes = (block.len() / bytes.max(1)).max(1);
    let done: Mutex<Vec<Option<Frame<T>>>> = Mutex::new((0..views.frames).map(|_| None).collect());
    block
        .par_chunks_exact_mut(bytes.max(1))
        .take(lanes)
        .enumerate()
        .try_for_each(|(lane, memory)| {
            let mut reconstruction =
                Reconstruction::<T, D>::new(problem, memory).map_err(|error| refused(views, &error))?;
            for frame in (lane..views.frames).step_by(lanes) {
                if watch.interrupt.asked() {
                    break;
                }
                let found = one(views, &mut reconstruction, frame, watch)?;
                let mut done = done.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
                if let Some(slot) = done.get_mut(frame) {
                    *slot = Some(found);
                }
            }
            Ok::<(), Failure>(())
        })?;
    Ok(done.into_inner().unwrap_or_else(|poisoned| poisoned.into_inner()))
}

/// The sentence for what the core refuses.
pub(super) fn refused(views: &Views, error: &TomographyError) -> Failure {
    let camera = |camera: &usize| views.cameras.get(*camera);
    match error {
        TomographyError::Blind { camera: number } => {
            let (key, name) = camera(number).map_or(("camera", ""), |view| (view.key(), &view.name));
            views.document.refuse(
                key,
                format!("(\"{name}\") sees nothing of the box; turn it to the box, or take it out"),
            )
        }
        TomographyError::Novel { view, blind } => {
            let key = views.novel.get(*view).map_or("novel", |view| &view.key);
            let why = if *blind {
                "sees nothing of the box; turn it to the box, or take it out"
            } else {
                "has a number that is not finite; correct it"
            };
            views.document.refuse(key, why)
        }
        TomographyError::NoNovel => views.document.refuse(
            "tomography.prior",
            format!(
                "is \"{}\", and there is no novel view; add a [[novel]] with a camera and its size, or choose another prior",
                views.settings.prior.name()
            ),
        ),
        other => views
            .document
            .refuse("tomography", format!("cannot run: {other}")),
    }
}

fn one<T: Real, const D: usize>(
    views: &Views,
    reconstruction: &mut Reconstruction<'_, T, D>,
    frame: usize,
    watch: &Watch,
) -> Result<Frame<T>, Failure> {
    for (number, view) in views.cameras.iter().enumerate() {
        let picture = views.picture(view, frame)?;
        let pixels: Vec<T> = picture.values.iter().map(|&value| T::from_f64(value)).collect();
        reconstruction
            .measure(number, &pixels)
            .map_err(|error| refused(views, &error))?;
    }
    let kept = views.settings.keeps_cells();
    let truth = kept.then(|| views.truth(frame)).flatten();
    let warm = views.settings.warm && frame > 0;
    let mut history = Vec::new();
    match reconstruction.begin((views.first + frame) as u64, warm) {
        Ok(()) => go(views, reconstruction, truth.as_deref(), &mut history, watch),
        Err(TomographyError::Dark) => {}
        Err(error) => return Err(refused(views, &error)),
    }
    let dark = !(reconstruction.total() > 0.0);
    let reprojected = |camera: usize| -> Vec<T> {
        let pixels = reconstruction
            .measured(camera)
            .iter()
            .zip(reconstruction.residual(camera));
        pixels
            .map(|(&q, &r)| if dark { T::ZERO } else { q - r })
            .collect()
    };
    let density: Vec<T> = if dark {
        vec![T::ZERO; reconstruction.density().len()]
    } else {
        reconstruction.density().to_vec()
    };
    let novel = |view: usize| -> Vec<T> {
        let picture = reconstruction.novel(view).iter();
        picture.map(|&pixel| if dark { T::ZERO } else { pixel }).collect()
    };
    Ok(Frame {
        novel: (0..views.novel.len()).map(novel).collect(),
        rms_error: truth.as_deref().map(|truth| rms(&density, truth)),
        reprojected: (0..views.cameras.len()).map(reprojected).collect(),
        residual_relative: if dark {
            0.0
        } else {
            reconstruction.residual_relative()
        },
        complete: dark || reconstruction.over(),
        density,
        history,
    })
}

/// Walks a frame to its end, or until the user wants to stop.
fn go<T: Real, const D: usize>(
    views: &Views,
    reconstruction: &mut Reconstruction<'_, T, D>,
    truth: Option<&[f64]>,
    history: &mut Vec<Value>,
    watch: &Watch,
) {
    let budget = reconstruction.budget();
    let tenth = budget.div_ceil(TENTHS).max(1);
    let mut over = false;
    while !over && !watch.interrupt.asked() {
        let before = reconstruction.walked().mutations;
        let next = (before / tenth + 1) * tenth;
        over = reconstruction.advance(BREATH.min(next - before));
        let walked = reconstruction.walked();
        if walked.mutations < next && !over {
            continue;
        }
        let energy = reconstruction.energy();
        let mut entry = json!({
            "frame": reconstruction.frame(),
            "mutations": walked.mutations,
            "accepted": walked.recorded,
            "data": energy.data,
            "prior": energy.prior,
            "seconds": watch.clock.total(),
            "residual_relative": reconstruction.residual_relative(),
        });
        let error = truth.map(|truth| rms(reconstruction.density(), truth));
        if let Some(error) = error {
            entry["rms_error"] = error.into();
        }
        let text = format!(
            "frame {} of {}, residual {:.2} %",
            reconstruction.frame(),
            views.first + views.frames - 1,
            100.0 * reconstruction.residual_relative(),
        );
        watch.tenth(&text, &entry);
        history.push(entry);
    }
}

/// Root mean square of the difference over all cells.
fn rms<T: Real>(density: &[T], truth: &[f64]) -> f64 {
    let square = |(value, truth): (&T, &f64)| (value.to_f64() - truth).powi(2);
    let sum: f64 = density.iter().zip(truth).map(square).sum();
    (sum / truth.len().max(1) as f64).sqrt()
}

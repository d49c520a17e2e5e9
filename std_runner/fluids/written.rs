//! `result.npz`, by one run forward that hands out a step at a time.

use crate::exit::Failure;
use crate::output::{OutputError, Precision, Store};
use crate::remarks::{KeyframeError, Wanted, densest};
use crate::report::{ARCHIVE, RunRecord, write_words};
use crate::run::drawn::drawn;
use crate::scene::Scene;
use crate::stay::Stay;
use core::ops::ControlFlow;
use std::path::Path;
use thurible_core::stable_fluids::Moment;
use thurible_core::{Exec, Fluids, Real, Silent, Space};

/// The ends of the names of components.
const AXES: [&str; 3] = ["x", "y", "z"];

/// What was seen of the densities while they were written.
pub(super) struct Seen {
    /// The smallest and the largest.
    pub range: [f64; 2],
    /// How far each keyframe was missed, for every step that it stands at.
    pub errors: Vec<KeyframeError>,
    /// The mass of the smoke at each of those steps, over that of the source.
    pub mass_ratios: Vec<f64>,
}

/// The arrays by their numbers in the store, and what is seen on the way.
struct Writing<'a> {
    scene: &'a Scene,
    mass_factors: &'a [f64],
    store: &'a mut Store,
    density: usize,
    velocity: Vec<usize>,
    force: Vec<usize>,
    keyframe: usize,
    seen: Seen,
    /// The largest density of the source.
    densest: f64,
    /// The mass of the source.
    mass: f64,
}

/// Runs forward with the unknowns as they are, and puts all steps into the store.
pub(super) fn write<T: Real, S: Space>(
    fluids: &mut Fluids<'_, T, S>,
    exec: &dyn Exec,
    scene: &Scene,
    mass_factors: &[f64],
    store: &mut Store,
) -> Result<Seen, Failure> {
    let shape: Vec<usize> = scene.grid.cells.iter().rev().copied().collect();
    let components = |store: &mut Store, name: &str| -> Result<Vec<usize>, Failure> {
        let axes = AXES.iter().take(S::DIM);
        axes.map(|axis| store.begin(&format!("{name}_{axis}"), shape.clone()))
            .collect()
    };
    let mut writing = Writing {
        scene,
        mass_factors,
        density: store.begin("density", shape.clone())?,
        velocity: components(store, "velocity")?,
        force: components(store, "force")?,
        keyframe: store.begin("keyframe_density", shape.clone())?,
        store,
        seen: Seen {
            range: [f64::INFINITY, f64::NEG_INFINITY],
            errors: Vec::new(),
            mass_ratios: Vec::new(),
        },
        densest: 0.0,
        mass: 0.0,
    };
    let mut failed = None;
    // Nobody stops it: a result is written of what was found, however it ended.
    let _ = fluids.replay(exec, &mut Silent, &mut |moment| match writing.step(moment) {
        Ok(()) => ControlFlow::Continue(()),
        Err(failure) => {
            failed = Some(failure);
            ControlFlow::Break(())
        }
    });
    if let Some(failure) = failed {
        return Err(failure);
    }
    let seen = writing.seen;
    put_templates(fluids, scene, store)?;
    store.flush()?;
    Ok(seen)
}

impl Writing<'_> {
    fn step<T: Real>(&mut self, mut moment: Moment<'_, '_, T>) -> Result<(), Failure> {
        let step = moment.step;
        let density = moment.density();
        self.store.push(self.density, density)?;
        let [least, most] = &mut self.seen.range;
        for value in density {
            (*least, *most) = (least.min(value.to_f64()), most.max(value.to_f64()));
        }
        if step == 0 {
            self.densest = densest(density);
            self.mass = mass(density);
        }
        self.keyframes(step, density)?;
        for (axis, &array) in self.velocity.iter().enumerate() {
            self.store.push(array, moment.velocity(axis))?;
        }
        for (axis, &array) in self.force.iter().enumerate() {
            if let Some(force) = moment.force(axis) {
                self.store.push(array, force)?;
            }
        }
        Ok(())
    }

    /// Measures the keyframe at a step, if there is one, drawn anew.
    fn keyframes<T: Real>(&mut self, step: usize, found: &[T]) -> Result<(), Failure> {
        let scene = self.scene;
        let Some(keyframe) = scene
            .keyframes
            .iter()
            .find(|keyframe| keyframe.stay().contains(step))
        else {
            return Ok(());
        };
        let shape: Vec<T> = drawn(scene, &keyframe.key, &keyframe.shape, &mut Vec::new())?;
        let factor = self
            .mass_factors
            .get(self.seen.errors.len())
            .copied()
            .unwrap_or(1.0);
        let wanted: Vec<T> = shape.iter().map(|x| T::from_f64(x.to_f64() * factor)).collect();
        self.store.push(self.keyframe, &wanted)?;
        let source: Vec<T> = match &scene.source {
            Some(source) => drawn(scene, "source", source, &mut Vec::new())?,
            None => Vec::new(),
        };
        let wanted = Wanted {
            target: &wanted,
            region: &[],
        };
        self.seen.errors.push(KeyframeError {
            stay: Stay::at(step),
            before: wanted.distance(&source),
            after: wanted.distance(found),
            denser: wanted.densest() / self.densest,
        });
        self.seen.mass_ratios.push(mass(found) / self.mass);
        Ok(())
    }
}

/// The sum of a density over cells.
fn mass<T: Real>(density: &[T]) -> f64 {
    density.iter().map(|density| density.to_f64()).sum()
}

/// Adds what was found of the templates.
fn put_templates<T: Real, S: Space>(
    fluids: &mut Fluids<'_, T, S>,
    scene: &Scene,
    store: &mut Store,
) -> Result<(), Failure> {
    let narrowed = |values: &[f64]| -> Vec<T> { values.iter().map(|&value| T::from_f64(value)).collect() };
    for index in 0..scene.templates.len() {
        let Some(found) = fluids.template(index) else {
            break;
        };
        let (intervals, numbers) = (found.intervals, found.numbers);
        let amplitudes: Vec<f64> = (0..intervals)
            .filter_map(|interval| fluids.template_amplitude(index, interval))
            .flat_map(|amplitude| amplitude.into_iter().take(numbers))
            .collect();
        let name = |what: &str| format!("template_{index}_{what}");
        let center: Vec<f64> = found.template.center.iter().take(S::DIM).copied().collect();
        store.put(
            &name("amplitude"),
            vec![intervals, numbers],
            &narrowed(&amplitudes),
        )?;
        store.put(&name("center"), vec![S::DIM], &narrowed(&center))?;
        store.put(&name("radius"), Vec::new(), &narrowed(&[found.template.radius]))?;
    }
    Ok(())
}

/// Writes the result of the store and its report into `folder`.
pub(super) fn pack(
    store: &Store,
    (folder, result): (&Path, &Path),
    record: &RunRecord,
    precision: Precision,
) -> Result<(), OutputError> {
    let keys = record.keyframes.len();
    let count = |name: &str| match name {
        "keyframe_density" => keys,
        name if name.starts_with("force") => record.steps,
        _ => record.steps + 1,
    };
    store.pack(&folder.join(ARCHIVE), precision, count)?;
    write_words(folder, result, record)
}

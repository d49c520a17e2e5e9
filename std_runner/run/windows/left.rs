//! What a window leaves to the next: the density and the velocity there, and the rest of its flow to begin the search with.

use crate::checkpoint::{Sealed, Unsealed, Words};
use crate::destination::Aside;
use crate::exit::Failure;
use crate::keyframes::Note;
use crate::output::{Frames, OutputError, Sample, Samples, Series};
use crate::run::Origin;
use crate::run::drawn::{drawn, refuse};
use crate::run::inputs::{set_emitters, set_obstacles, set_velocity};
use crate::scene::Scene;
use crate::windows::Window;
use thurible_core::checkpoint::{Damaged, Refused, Sink, Source};
use thurible_core::output::{DENSITY, VELOCITY};
use thurible_core::{InputError, Real, Solver, Space};

/// Files that hold it, so that memory has to hold no more than a field.
pub(super) struct Left {
    density: Series,
    /// The velocities from there on, for each axis.
    velocity: Vec<Series>,
    samples: Samples,
}

impl Left {
    /// Nothing yet, in files of this name.
    pub fn new(scratch: &Aside, name: &str, dims: usize, samples: Samples) -> Result<Self, Failure> {
        let file =
            |what: &str| Series::create(&scratch.file(&format!("{name}_{what}"))).map_err(Failure::from);
        let along = (0..dims).map(|axis| file(&format!("velocity_{axis}")));
        Ok(Self {
            density: file("density")?,
            velocity: along.collect::<Result<_, _>>()?,
            samples,
        })
    }

    /// Whether a window has left something.
    pub fn is_there(&self) -> bool {
        self.density.count() > 0
    }

    /// Takes what is left of the frames of `window` after the steps that it keeps.
    pub fn take(&mut self, frames: &dyn Frames, window: &Window) -> Result<(), Failure> {
        let Self {
            density,
            velocity,
            samples,
        } = self;
        density.clear()?;
        frames.read(&DENSITY, window.keeps, 0, samples);
        density.append(samples)?;
        for (axis, series) in velocity.iter_mut().enumerate() {
            series.clear()?;
            for step in window.keeps..window.steps {
                frames.read(&VELOCITY, step, axis, samples);
                series.append(samples)?;
            }
        }
        Ok(())
    }

    /// How many fields of how many numbers there are: of the density, and of the velocity along each axis.
    pub fn record(&self, words: &mut Words, sizes: &mut Vec<(usize, usize)>) -> Result<(), Damaged> {
        let size = |series: &Series| (series.state().0, series.state().1);
        if !words.reads() {
            *sizes = [&self.density]
                .into_iter()
                .chain(&self.velocity)
                .map(size)
                .collect();
        }
        words.list(sizes, (0, 0), |words, (len, count)| {
            words.count(len)?;
            words.count(count)
        })
    }

    /// Writes all fields into a checkpoint.
    pub fn write(&mut self, file: &mut Sealed) -> Result<(), Refused> {
        let samples = &mut self.samples;
        for series in [&self.density].into_iter().chain(&self.velocity) {
            for index in 0..series.count() {
                series.read(index, samples).map_err(|_| Refused)?;
                match &*samples {
                    Samples::F32(values) => values
                        .iter()
                        .try_for_each(|value| file.put(&value.to_le_bytes()))?,
                    Samples::F64(values) => values
                        .iter()
                        .try_for_each(|value| file.put(&value.to_le_bytes()))?,
                }
            }
        }
        Ok(())
    }

    /// Takes fields of these `sizes` out of a checkpoint, `most` of each at most.
    pub fn go_on(
        &mut self,
        file: &mut Unsealed,
        sizes: &[(usize, usize)],
        most: usize,
    ) -> Result<(), Option<OutputError>> {
        let samples = &mut self.samples;
        let all = [&mut self.density].into_iter().chain(&mut self.velocity);
        // Fields of nothing would have no end.
        let have_an_end = sizes
            .iter()
            .all(|&(len, count)| count <= if len > 0 { most } else { 0 });
        if !have_an_end {
            return Err(None);
        }
        for (series, &(len, count)) in all.zip(sizes) {
            for _ in 0..count {
                samples.clear(0);
                match &mut *samples {
                    Samples::F32(values) => pull(file, len, values, f32::from_le_bytes),
                    Samples::F64(values) => pull(file, len, values, f64::from_le_bytes),
                }
                .map_err(|Refused| None)?;
                series.append(samples).map_err(Some)?;
            }
        }
        Ok(())
    }

    /// The density where the next window begins.
    pub fn density(&mut self) -> Result<&mut Samples, Failure> {
        self.density.read(0, &mut self.samples)?;
        Ok(&mut self.samples)
    }

    /// Hands `solver` the smoke, the flow and the obstacles that `window` begins with: those of the scene, or of the earlier result `from`,
    /// where no window was before.
    pub fn begin<T: Real + Sample, S: Space>(
        &mut self,
        scene: &Scene,
        from: Option<&Origin>,
        window: &Window,
        solver: &mut Solver<'_, T, S>,
        notes: &mut Vec<Note>,
    ) -> Result<(), Failure> {
        let among = Some(window.emitters.as_slice());
        if !self.is_there() {
            if let Some(from) = from {
                notes.extend(from.begin(scene, solver, among, 1.0)?.notes);
                return Ok(());
            }
            set_obstacles(scene, solver, notes)?;
            match &scene.source {
                Some(source) => solver
                    .set_source(&drawn::<T>(scene, "source", source, notes)?)
                    .map_err(refuse(scene, "source"))?,
                // Emitters are to make it.
                None => {
                    self.samples.clear(solver.cells());
                    solver.go_on_from(T::list(&mut self.samples)).map_err(unusable)?;
                }
            }
            set_emitters(scene, solver, among, &mut None, notes)?;
            return set_velocity(scene, solver);
        }
        let mut unheard = Vec::new();
        set_obstacles(scene, solver, &mut unheard)?;
        set_emitters(scene, solver, among, &mut None, &mut unheard)?;
        for axis in 0..S::DIM {
            let faces = self.velocity(axis, 0)?;
            solver
                .set_initial_velocity(axis, T::list(faces))
                .map_err(unusable)?;
        }
        solver.go_on_from(T::list(self.density()?)).map_err(unusable)
    }

    /// Gives `solver` the rest of the flow, its last velocity standing on, to begin the search of so many steps with.
    pub fn give<T: Real + Sample, S: Space>(
        &mut self,
        solver: &mut Solver<'_, T, S>,
        steps: usize,
    ) -> Result<(), Failure> {
        for axis in 0..S::DIM {
            for step in 1..steps {
                let faces = self.velocity(axis, step)?;
                solver
                    .give_velocity(step, axis, T::list(faces))
                    .map_err(unusable)?;
            }
        }
        Ok(())
    }

    /// The velocity so many steps after the begin, or the last one that there is.
    fn velocity(&mut self, axis: usize, step: usize) -> Result<&mut Samples, Failure> {
        if let Some(series) = self.velocity.get(axis) {
            let last = series.count().saturating_sub(1);
            series.read(step.min(last), &mut self.samples)?;
        }
        Ok(&mut self.samples)
    }
}

/// `values` become the next `count` numbers of a checkpoint.
fn pull<V, const N: usize>(
    file: &mut Unsealed,
    count: usize,
    values: &mut Vec<V>,
    number: impl Fn([u8; N]) -> V,
) -> Result<(), Refused> {
    let mut bytes = [0; N];
    for _ in 0..count {
        file.take(&mut bytes)?;
        values.push(number(bytes));
    }
    Ok(())
}

/// The failure of a field that a window gave and the next refuses.
fn unusable(error: InputError) -> Failure {
    Failure::NotFinite(format!(
        "what a window left cannot be gone on from: {error}; try --precision f64 or more `time.steps`"
    ))
}

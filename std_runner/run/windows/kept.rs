//! What is kept of windows: growing files, which show themselves as the frames of one result.

use crate::destination::Aside;
use crate::exit::Failure;
use crate::output::{
    Frames, Given, GivenValues, OutputError, Precision, Sample, Samples, Series, array_name,
};
use crate::problem::OwnedProblem;
use crate::remarks::{KeyframeError, Wanted};
use crate::run::frames::{EMISSION, REGION, given};
use crate::stay::Stay;
use crate::windows::Window;
use core::cell::RefCell;
use std::collections::BTreeMap;
use thurible_core::output::{DENSITY, FORCE};
use thurible_core::{Boundary, Output, Real};

/// The targets of keyframes.
const TARGET: &str = "keyframe";

/// The fields of all steps so far.
pub(super) struct Kept {
    pub(super) scratch: Aside,
    /// What there is a result of.
    pub problem: OwnedProblem,
    periodic: Vec<bool>,
    pub(super) precision: Precision,
    pub(super) outputs: &'static [Output],
    pub(super) series: BTreeMap<String, Series>,
    /// The keyframes that were judged, in the order of their steps.
    pub errors: Vec<KeyframeError>,
    /// The mass that emitters have added.
    pub emitted: f64,
    /// Factors of the price of the force.
    pub(super) factors: Vec<f64>,
    /// Why something could not be read back.
    trouble: RefCell<Option<OutputError>>,
}

impl Kept {
    /// Nothing yet of `whole`, in files of `scratch`.
    pub fn new(scratch: Aside, whole: &OwnedProblem, precision: Precision) -> Self {
        let periodic = whole
            .boundary
            .iter()
            .map(|&boundary| boundary == Boundary::Periodic);
        Self {
            scratch,
            periodic: periodic.collect(),
            problem: whole.clone(),
            precision,
            outputs: &[],
            series: BTreeMap::new(),
            errors: Vec::new(),
            emitted: 0.0,
            factors: Vec::new(),
            trouble: RefCell::new(None),
        }
    }

    /// Appends what `window` keeps of its frames, with `forces` of 0 where it was left to itself.
    pub fn take<T: Real + Sample>(
        &mut self,
        frames: &mut dyn Frames,
        outputs: &'static [Output],
        window: &Window,
        factors: impl Iterator<Item = f64>,
        is_free: bool,
    ) -> Result<(), Failure> {
        self.outputs = outputs;
        let (dims, mut samples) = (frames.cells().len(), Samples::new(self.precision));
        for output in outputs {
            let count = self.count(output.fewer, window);
            for axis in 0..output.components(dims) {
                let name = array_name(output, axis);
                for step in 0..count {
                    frames.read(output, step, axis, &mut samples);
                    if is_free && *output == FORCE {
                        samples.clear(samples.len());
                    }
                    self.append(&name, &samples)?;
                }
            }
        }
        self.factors.extend(factors.take(window.forces()));
        self.take_keyframes::<T>(frames, window)?;
        self.take_given::<T>(frames, window)
    }

    /// How many fields of an array, which has so many fewer than there are densities, are taken of a window.
    fn count(&self, fewer: usize, window: &Window) -> usize {
        if window.is_last {
            window.steps + 1 - fewer
        } else {
            window.keeps
        }
    }

    /// The keyframes that the window is judged by.
    fn take_keyframes<T: Real + Sample>(
        &mut self,
        frames: &mut dyn Frames,
        window: &Window,
    ) -> Result<(), Failure> {
        let [mut target, mut region, mut density, mut source] =
            [(); 4].map(|()| Samples::new(self.precision));
        self.field(&array_name(&DENSITY, 0), 0, &mut source)?;
        let steps = frames.keyframe_steps().to_vec();
        let judged = steps.into_iter().enumerate();
        for (index, step) in judged.filter(|(_, step)| window.judges().contains(&(window.start + step))) {
            frames.keyframe(index, &mut target);
            self.append(TARGET, &target)?;
            if self.problem.keyframe_regions {
                frames.given_field(REGION, index, &mut region);
                self.append(REGION, &region)?;
            }
            frames.read(&DENSITY, step, 0, &mut density);
            let [target, region, source, density] =
                [&mut target, &mut region, &mut source, &mut density].map(|samples| &*T::list(samples));
            let wanted = Wanted { target, region };
            self.errors.push(KeyframeError {
                stay: Stay::at(window.start + step),
                before: wanted.distance(source),
                after: wanted.distance(density),
                denser: wanted.densest(),
            });
        }
        Ok(())
    }

    /// What else the scene gives: fields once, and those of its steps.
    fn take_given<T: Real + Sample>(
        &mut self,
        frames: &mut dyn Frames,
        window: &Window,
    ) -> Result<(), Failure> {
        let mut samples = Samples::new(self.precision);
        for Given { name, values } in given(&self.problem, Vec::new()) {
            let count = match values {
                GivenValues::Cells if self.series.contains_key(name) || !has(frames, name) => 0,
                GivenValues::Cells => 1,
                GivenValues::Fields(_) if name == EMISSION => self.count(1, window),
                GivenValues::Faces(..) => self.count(2, window),
                GivenValues::Fields(_) | GivenValues::Numbers(_) => 0,
            };
            for index in 0..count {
                frames.given_field(name, index, &mut samples);
                self.append(name, &samples)?;
                if name == EMISSION {
                    self.emitted += T::list(&mut samples).iter().map(|x| x.to_f64()).sum::<f64>();
                }
            }
        }
        Ok(())
    }

    /// Ends the result with so many steps, the last of which has this density if there is none of it yet.
    pub fn end(&mut self, steps: usize, density: Option<&Samples>) -> Result<(), Failure> {
        if let Some(density) = density {
            self.append(&array_name(&DENSITY, 0), density)?;
        }
        // Of the last window's keyframes one may stand just beyond.
        self.errors.retain(|error| error.stay.first <= steps);
        let judged = self.errors.len();
        let problem = &mut self.problem;
        problem.release = problem.release.filter(|step| *step < steps);
        problem.keyframes.truncate(judged);
        problem.keyframe_weights.truncate(judged);
        problem.steps = steps;
        self.factors.truncate(steps.saturating_sub(1));
        Ok(())
    }

    /// What could not be read back when an archive was written, or `error`.
    pub fn trouble(&self, error: OutputError) -> OutputError {
        self.trouble.take().unwrap_or(error)
    }

    fn append(&mut self, name: &str, field: &Samples) -> Result<(), Failure> {
        if !self.series.contains_key(name) {
            let series = Series::create(&self.scratch.file(name))?;
            self.series.insert(name.into(), series);
        }
        let series = self.series.get_mut(name);
        series
            .map_or(Ok(()), |series| series.append(field))
            .map_err(Failure::from)
    }

    /// `out` becomes field `index` of an array.
    fn field(&self, name: &str, index: usize, out: &mut Samples) -> Result<(), Failure> {
        self.series
            .get(name)
            .map_or(Ok(()), |series| series.read(index, out))
            .map_err(Failure::from)
    }

    /// As [`Self::field`], for a caller who looks at [`Self::trouble`] later.
    fn show(&self, name: &str, index: usize, out: &mut Samples) {
        if let Some(Err(error)) = self.series.get(name).map(|series| series.read(index, out)) {
            out.clear(0);
            self.trouble.replace(Some(error));
        }
    }
}

/// Whether frames give an array of this name.
fn has(frames: &dyn Frames, name: &str) -> bool {
    frames.given().iter().any(|given| given.name == name)
}

impl Frames for Kept {
    fn cells(&self) -> &[usize] {
        &self.problem.cells
    }

    fn periodic(&self) -> &[bool] {
        &self.periodic
    }

    fn steps(&self) -> usize {
        self.problem.steps
    }

    fn precision(&self) -> Precision {
        self.precision
    }

    fn keyframe_steps(&self) -> &[usize] {
        &self.problem.keyframes
    }

    fn keyframe(&self, index: usize, out: &mut Samples) {
        self.show(TARGET, index, out);
    }

    fn outputs(&self) -> &[Output] {
        self.outputs
    }

    fn read(&self, output: &Output, step: usize, axis: usize, out: &mut Samples) {
        self.show(&array_name(output, axis), step, out);
    }

    fn given(&self) -> Vec<Given> {
        let all = given(&self.problem, self.factors.clone());
        let there = |given: &Given| {
            matches!(given.values, GivenValues::Numbers(_)) || self.series.contains_key(given.name)
        };
        all.into_iter().filter(there).collect()
    }

    fn given_field(&mut self, name: &str, index: usize, out: &mut Samples) {
        self.show(name, index, out);
    }
}

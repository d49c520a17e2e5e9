//! Taylor's test of a scene's gradient: the operator of its simulation, and the data term of its keyframes.
//!
//! ```text
//! J = 1/2 sum over keyframes of W |R (rho_i - rho*)|^2,   with |.|^2 a plain sum over cells; without keyframes 1/2 |rho_N|^2
//! ```

mod point;
mod table;

pub(crate) use point::noise;
pub use point::{INPUTS, Point};
pub(crate) use table::STEPS;
pub use table::{Kept, Row, Table};

use crate::bytes;
use crate::exit::Failure;
use crate::ledger::over;
use crate::plan::PlanOptions;
use crate::problem::{OwnedProblem, refusal};
use crate::region::{MARGIN, Region};
use crate::run::drawn::solid_cells;
use crate::run::drawn::{drawn, refuse};
use crate::scene::Scene;
use crate::threads;
use thurible_core::operator::{OperatorError, Start};
use thurible_core::{D2, D3, Exec, Operator, OperatorParams, OperatorPlan, PlanError, Silent, Space};

/// What a step should look like.
struct Wanted {
    step: usize,
    weight: f64,
    target: Vec<f64>,
    region: Option<Vec<f64>>,
}

/// The check of one scene.
pub(crate) struct Check<'s> {
    scene: &'s Scene,
    problem: OwnedProblem,
    params: OperatorParams,
    solid: Option<Vec<bool>>,
    wanted: Vec<Wanted>,
    /// Where the gradient is taken, and the direction.
    point: Point,
}

/// Checks the gradient of a scene, in double precision.
///
/// # Errors
/// [`Failure`]
pub fn check(scene: &Scene, options: &PlanOptions) -> Result<Table, Failure> {
    let limit = options.limit.or_else(bytes::of_machine);
    let notes = &mut Vec::new();
    let mut check = Check {
        scene,
        problem: OwnedProblem::of(scene),
        params: OperatorParams {
            threads: options.threads.unwrap_or_else(threads::available),
            ceiling: limit.map(|limit| limit.saturating_sub(MARGIN)),
            tolerance: 1e-13,
            ..OperatorParams::default()
        },
        solid: solid_cells(scene, notes)?,
        wanted: wanted(scene)?,
        point: Point::new(scene)?,
    };
    // On fewer threads, if their number was not given and that makes it fit.
    let plan = loop {
        match check.plan() {
            Err(PlanError::Ceiling { .. }) if options.threads.is_none() && check.params.threads > 1 => {
                check.params.threads /= 2;
            }
            planned => break planned.map_err(|error| check.refused(error, options))?,
        }
    };
    let threads = check.params.threads;
    threads::with(threads, || {
        threads::together(threads, |exec| {
            if scene.grid.cells.len() == 2 {
                check.run::<D2>(exec, &plan)
            } else {
                check.run::<D3>(exec, &plan)
            }
        })
    })?
}

/// The keyframes of a scene, drawn.
fn wanted(scene: &Scene) -> Result<Vec<Wanted>, Failure> {
    let mut all = Vec::new();
    for keyframe in &scene.keyframes {
        let target: Vec<f64> = drawn(scene, &keyframe.key, &keyframe.shape, &mut Vec::new())?;
        let region = match &keyframe.region {
            Some(region) => Some(drawn(
                scene,
                &format!("{}.region", keyframe.key),
                region,
                &mut Vec::new(),
            )?),
            None => None,
        };
        for step in keyframe.stay().steps() {
            all.push(Wanted {
                step,
                weight: keyframe.weight,
                target: target.clone(),
                region: region.clone(),
            });
        }
    }
    if all.is_empty() {
        all.push(Wanted {
            step: scene.time.steps,
            weight: 1.0,
            target: vec![0.0; scene.grid.cells.iter().product()],
            region: None,
        });
    }
    Ok(all)
}

impl Wanted {
    /// R in a cell.
    fn factor(&self, at: usize) -> f64 {
        let region = self.region.as_ref();
        region.and_then(|region| region.get(at)).copied().unwrap_or(1.0)
    }

    /// R (rho - rho*).
    fn error<'w>(&'w self, rho: &'w [f64]) -> impl Iterator<Item = f64> + 'w {
        let errors = rho.iter().zip(&self.target).enumerate();
        errors.map(move |(at, (rho, target))| self.factor(at) * (rho - target))
    }

    fn value(&self, rho: &[f64]) -> f64 {
        0.5 * self.weight * self.error(rho).map(|e| e * e).sum::<f64>()
    }

    /// W R R (rho - rho*).
    fn covector(&self, rho: &[f64]) -> Vec<f64> {
        let errors = self.error(rho).enumerate();
        errors.map(|(at, e)| self.weight * self.factor(at) * e).collect()
    }
}

impl Check<'_> {
    fn plan(&self) -> Result<OperatorPlan, PlanError> {
        let problem = self.problem.problem();
        if self.scene.grid.cells.len() == 2 {
            OperatorPlan::new::<f64, D2>(&problem, &self.params)
        } else {
            OperatorPlan::new::<f64, D3>(&problem, &self.params)
        }
    }

    fn run<S: Space>(&self, exec: &dyn Exec, plan: &OperatorPlan) -> Result<Table, Failure> {
        let mut region = Region::new(plan.bytes()).ok_or_else(|| {
            Failure::Memory(format!(
                "the system has not {} bytes for the check; set --memory-limit, or make `grid.cells` smaller",
                bytes::grouped(plan.bytes())
            ))
        })?;
        let block = region
            .carve(plan.bytes())
            .ok_or_else(|| Failure::Memory("the block of memory is too small".into()))?;
        let (value, parts) = self.gradient::<S>(exec, block)?;
        let kept = Kept {
            bytes: plan.bytes(),
            slots: plan.slots(),
            repeated: plan.repeated_steps(),
        };
        let mut table = Table::new(value, INPUTS.into_iter().zip(parts).collect(), kept);
        for step in STEPS {
            table.push(step, self.value::<S>(exec, block, step)?);
        }
        Ok(table)
    }

    fn refused(&self, error: PlanError, options: &PlanOptions) -> Failure {
        match error {
            PlanError::Ceiling { needed, ceiling } => {
                let bytes = [needed, ceiling].map(|bytes| bytes.saturating_add(MARGIN));
                let path = self.scene.document.path();
                let less = "make `grid.cells` smaller".into();
                over(
                    path,
                    "the check needs",
                    bytes.into(),
                    options.limit.is_some(),
                    &[less],
                )
            }
            other => refusal(self.scene, other),
        }
    }

    fn stopped(&self, error: OperatorError) -> Failure {
        match error {
            OperatorError::TooFast { .. } => {
                Failure::NotFinite(format!("{}: {error}", self.scene.document.path().display()))
            }
            other => Failure::Input(format!("{}: {other}", self.scene.document.path().display())),
        }
    }

    /// Calls `work` with the operator and the start at `t` along the direction.
    fn with<S: Space, R>(
        &self,
        block: &mut [core::mem::MaybeUninit<u8>],
        t: f64,
        work: impl FnOnce(&mut Operator<'_, f64, S>, &Start<'_, f64>) -> Result<R, OperatorError>,
    ) -> Result<R, Failure> {
        let problem = self.point.moved(&self.problem, t);
        let mut operator = Operator::<f64, S>::new(&problem.problem(), &self.params, block)
            .map_err(|error| crate::run::inputs::solver_refusal(&error))?;
        if let Some(solid) = &self.solid {
            let refuse = refuse(self.scene, "obstacle[0]");
            operator.set_solids(solid).map_err(refuse)?;
        }
        for (index, shape) in self.point.shapes(t).iter().enumerate() {
            let refuse = refuse(self.scene, &format!("emitter[{index}]"));
            operator.set_emitter(index, shape).map_err(refuse)?;
        }
        let (density, velocity) = (self.point.density(t), self.point.velocity(t));
        let start = Start {
            density: &density,
            velocity: core::array::from_fn(|axis| velocity.get(axis).map_or(&[][..], |v| v)),
        };
        work(&mut operator, &start).map_err(|error| self.stopped(error))
    }

    /// J at `t` along the direction.
    fn value<S: Space>(
        &self,
        exec: &dyn Exec,
        block: &mut [core::mem::MaybeUninit<u8>],
        t: f64,
    ) -> Result<f64, Failure> {
        self.with::<S, _>(block, t, |operator, start| {
            let (mut rho, mut sum) = (vec![0.0; operator.cells()], 0.0);
            operator.simulate(
                exec,
                &mut Silent,
                start,
                &mut |step, given| self.point.push(step, t, given),
                &mut |step, view| {
                    for wanted in self.wanted.iter().filter(|wanted| wanted.step == step) {
                        view.read_density(&mut rho);
                        sum += wanted.value(&rho);
                    }
                },
            )?;
            Ok(sum)
        })
    }

    /// J, and the part of its derivative along the direction that each input has.
    fn gradient<S: Space>(
        &self,
        exec: &dyn Exec,
        block: &mut [core::mem::MaybeUninit<u8>],
    ) -> Result<(f64, [f64; INPUTS.len()]), Failure> {
        self.with::<S, _>(block, 0.0, |operator, start| {
            let (mut rho, mut sum) = (vec![0.0; operator.cells()], 0.0);
            let mut covectors: Vec<(usize, Vec<f64>)> = Vec::new();
            operator.simulate(
                exec,
                &mut Silent,
                start,
                &mut |step, given| self.point.push(step, 0.0, given),
                &mut |step, view| {
                    for wanted in self.wanted.iter().filter(|wanted| wanted.step == step) {
                        view.read_density(&mut rho);
                        sum += wanted.value(&rho);
                        covectors.push((step, wanted.covector(&rho)));
                    }
                },
            )?;
            let mut by_force = 0.0;
            let lens: Vec<usize> = (0..S::DIM).map(|axis| operator.faces_len(axis)).collect();
            operator.vjp(
                exec,
                &mut Silent,
                &mut |step, given| self.point.push(step, 0.0, given),
                &mut |step, given| {
                    for (_, covector) in covectors.iter().filter(|(at, _)| *at == step) {
                        given.density(covector);
                    }
                },
                &mut |step, view| {
                    for (axis, &len) in lens.iter().enumerate() {
                        let mut gradient = vec![0.0; len];
                        view.read_vector(axis, &mut gradient);
                        by_force += self.point.along_force(step, axis, &gradient);
                    }
                },
            )?;
            Ok((sum, self.point.along(operator, by_force)))
        })
    }
}

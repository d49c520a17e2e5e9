//! `thurible-bench`: how long kernels, iterations and solves take, beside a triad of the same run.

use super::kernels::Kernel;
use super::machine::{Machine, Moment};
use super::printer::Printer;
use super::row::{Peak, Row};
use super::solves::{self, Reached};
use super::table::Table;
use super::threads::with_threads;
use super::{scenes, section};
use crate::arguments::Arguments;
use serde_json::json;
use thurible::exit::{DONE, Failure};
use thurible_core::{D2, D3, Exec};

/// Part of the distance from the keyframe at which the circles are there.
pub(super) const PART: f64 = 0.01;
/// Iterations on the finest grid that are measured, from 1; the first has more to do.
const FEW: [usize; 2] = [2, 4];
const MANY: [usize; 2] = [2, 21];

/// A box for the kernels, squares, and how scenes are changed.
struct Sizes {
    cube: (Vec<usize>, usize),
    squares: [(Vec<usize>, usize); 2],
    sets: Vec<String>,
}

impl Sizes {
    fn new(quick: bool) -> Self {
        if quick {
            let sets = [
                "grid.cells=[32,32]",
                "time.steps=8",
                "keyframe[0].step=8",
                "method.iterations=5",
            ]
            .map(String::from);
            return Self {
                cube: (vec![12; 3], 6),
                squares: [(vec![32; 2], 8), (vec![16; 2], 6)],
                sets: sets.to_vec(),
            };
        }
        Self {
            cube: (vec![64; 3], 60),
            squares: [(vec![128; 2], 40), (vec![64; 2], 20)],
            sets: Vec::new(),
        }
    }

    /// The scene of the cube.
    fn sets_of_cube(&self) -> Vec<String> {
        let (cells, steps) = &self.cube;
        let keyframes = (1..=3).map(|third| format!("keyframe[{}].step={}", third - 1, third * steps / 3));
        [format!("grid.cells={cells:?}"), format!("time.steps={steps}")]
            .into_iter()
            .chain(keyframes)
            .collect()
    }
}

/// A run of the table.
struct Run<'a> {
    exec: &'a dyn Exec,
    /// What the machine did after the last row.
    moment: Moment,
    sizes: Sizes,
    quick: bool,
    table: Table<Row, 11>,
}

/// Measures kernels, iterations and solves.
pub(super) fn run(arguments: &Arguments) -> Result<u8, Failure> {
    let common = &arguments.common;
    section::check(common.out.as_deref())?;
    with_threads(common.threads, |exec| {
        let (printer, machine) = (Printer::of(common), Machine::measure(exec, common.quick)?);
        printer.say(&machine.sentence(), json!({ "machine": machine }));
        let mut run = Run {
            exec,
            moment: machine.moment,
            sizes: Sizes::new(common.quick),
            quick: common.quick,
            table: Table::begin(printer),
        };
        let peak = run.iterations_in_3d()?;
        run.kernels()?;
        run.in_2d()?;
        if arguments.long {
            run.long()?;
        }
        printer.say(&peak.sentence(), json!({ "memory": peak }));
        let text = format!(
            "{}\n\n{}\n{}\n",
            machine.sentence(),
            run.table.markdown(),
            peak.sentence()
        );
        section::write(common.out.as_deref(), "speed", &text)
    })?;
    Ok(DONE)
}

impl Run<'_> {
    /// Completes a row and tells it.
    fn add(&mut self, row: Row) -> Result<(), Failure> {
        let before = core::mem::replace(&mut self.moment, Moment::measure(self.exec, self.quick)?);
        self.table.add(row.beside(before.mean(self.moment), self.quick));
        Ok(())
    }

    fn kernels(&mut self) -> Result<(), Failure> {
        let (cells, steps) = self.sizes.cube.clone();
        for (kernel, target) in [
            (Kernel::Cycle, 2.0),
            (Kernel::Forward, 0.3),
            (Kernel::Backward, 0.9),
            (Kernel::Projection, 0.35),
        ] {
            let seconds = kernel.seconds::<D3>(self.exec, &cells, steps, 2)?;
            let row = Row::new(kernel.name(), &cells, steps, Some(seconds)).targeting(target);
            self.add(row.moving(kernel.least_values(3)))?;
        }
        Ok(())
    }

    /// Iterations of the direct method in the cube, and what memory they took.
    fn iterations_in_3d(&mut self) -> Result<Peak, Failure> {
        let prepared = scenes::moving_sphere(&self.sizes.sets_of_cube(), "direct", self.exec.threads())?;
        let [iterations] = solves::iterations::<f32, D3, 1>([self.exec], &prepared, FEW)?;
        let (cells, steps) = self.sizes.cube.clone();
        let row = Row::new(
            "direct iteration, moving_sphere",
            &cells,
            steps,
            Some(iterations.seconds),
        )
        .targeting(2.0);
        self.add(row.moving(Kernel::Direct.least_values(3)).of(&iterations))?;
        Ok(Peak::new(&iterations, self.exec.threads()))
    }

    fn in_2d(&mut self) -> Result<(), Failure> {
        for ((cells, steps), target) in self.sizes.squares.clone().into_iter().zip([0.030, 0.004]) {
            let sets = [
                format!("grid.cells={cells:?}"),
                format!("time.steps={steps}"),
                format!("keyframe[0].step={steps}"),
            ];
            let prepared = scenes::letter_f(&sets, "direct", self.exec.threads())?;
            let [iterations] = solves::iterations::<f32, D2, 1>([self.exec], &prepared, MANY)?;
            let row = Row::new(
                "direct iteration, letter_f",
                &cells,
                steps,
                Some(iterations.seconds),
            )
            .targeting(target);
            self.add(row.moving(Kernel::Direct.least_values(2)).of(&iterations))?;
        }
        let circles = scenes::two_circles(&self.sizes.sets, self.exec.threads())?;
        let reached = solves::to_part::<f32, D2>(self.exec, &circles, PART)?;
        self.solved(
            "circle to two, to 1 % of the distance",
            circles.problem().cells,
            circles.problem().steps,
            reached,
            1.5,
        )?;
        let letter = scenes::letter_f(&self.sizes.sets, "direct", self.exec.threads())?;
        let reached = solves::to_final::<D2>(self.exec, &letter)?;
        self.solved(
            "letter_f, to 1 % of its end",
            letter.problem().cells,
            letter.problem().steps,
            reached,
            2.0,
        )
    }

    fn long(&mut self) -> Result<(), Failure> {
        let (cells, steps) = self.sizes.cube.clone();
        let sets = [self.sizes.sets_of_cube(), vec!["method.iterations=60".into()]].concat();
        let reached = solves::to_final::<D3>(
            self.exec,
            &scenes::moving_sphere(&sets, "direct", self.exec.threads())?,
        )?;
        self.solved(
            "moving_sphere by direct, to 1 % of its end",
            &cells,
            steps,
            reached,
            60.0,
        )?;
        let sets = [
            self.sizes.sets_of_cube(),
            vec!["method.iterations=150".into(), "method.admm.penalty=4e3".into()],
        ]
        .concat();
        let reached = solves::to_stop::<D3>(
            self.exec,
            &scenes::moving_sphere(&sets, "admm", self.exec.threads())?,
        )?;
        self.solved(
            "moving_sphere by admm, to its stop",
            &cells,
            steps,
            reached,
            900.0,
        )
    }

    fn solved(
        &mut self,
        name: &str,
        cells: &[usize],
        steps: usize,
        reached: Reached,
        target: f64,
    ) -> Result<(), Failure> {
        let row = Row::new(name, cells, steps, reached.seconds).targeting(target);
        self.add(Row {
            iterations: Some(reached.iterations),
            ..row
        })
    }
}

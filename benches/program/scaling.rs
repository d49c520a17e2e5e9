//! `thurible-bench scaling`: cost for each cell and step at many sizes, on one thread and on all.

use super::kernels::Kernel;
use super::machine::{Machine, Moment, gain};
use super::printer::Printer;
use super::solves;
use super::table::{Line, Table};
use super::threads::with_threads;
use super::{files, scenes, section};
use crate::arguments::MeasureArguments;
use serde::Serialize;
use serde_json::json;
use thurible::exit::{DONE, Failure};
use thurible::plan::size_in_words;
use thurible::report::{Chart, Curve, Scale};
use thurible_core::{D2, D3, Exec, Serial, Space};

const SIZES: [(&[usize], usize); 11] = [
    (&[32; 2], 20),
    (&[64; 2], 20),
    (&[64; 2], 40),
    (&[128; 2], 40),
    (&[256; 2], 40),
    (&[256; 2], 80),
    (&[16; 3], 16),
    (&[32; 3], 20),
    (&[48; 3], 20),
    (&[64; 3], 60),
    (&[96; 3], 20),
];
const QUICK_SIZES: [(&[usize], usize); 4] = [(&[16; 2], 6), (&[24; 2], 6), (&[8; 3], 6), (&[12; 3], 6)];

/// Cells times steps that are worth one repetition fewer.
const ENOUGH: usize = 20_000_000;
/// Iterations of the direct method on the finest grid that are measured, in boxes of fewer and of more cells times steps than
/// [`LARGE`], and as many more on all threads: from where there are as many pairs as there will be, and few, since a solve that has
/// converged only searches.
const ITERATIONS: [[usize; 2]; 2] = [[7, 11], [7, 8]];
const LARGE: usize = 1_000_000;

/// A line of the table: one size.
#[derive(Clone, Debug, Serialize)]
struct Row {
    cells: Vec<usize>,
    steps: usize,
    threads: usize,
    /// Nanoseconds for each cell and step of an iteration of the direct method, on one thread and on all.
    direct_ns: [f64; 2],
    /// Objectives that an iteration computed.
    evaluations: f64,
    /// The largest Courant number at the end of them.
    courant: f64,
    /// The same of a V(2,2) cycle of STFAS.
    cycle_ns: [f64; 2],
    /// How many times as fast a triad over one slot of a field is on all threads as on one, and over all slots.
    triad_gains: [f64; 2],
    /// What the machine did before and after, on average.
    #[serde(flatten)]
    moment: Moment,
}

/// Runs `scaling`.
pub(super) fn run(arguments: &MeasureArguments) -> Result<u8, Failure> {
    section::check(arguments.out.as_deref())?;
    let sizes: &[_] = if arguments.quick { &QUICK_SIZES } else { &SIZES };
    let printer = Printer::of(arguments);
    let (machine, table) = with_threads(arguments.threads, |exec| {
        let machine = Machine::measure(exec, arguments.quick)?;
        printer.say(&machine.sentence(), json!({ "machine": machine }));
        let mut table = Table::begin(printer);
        for &(cells, steps) in sizes {
            let quick = arguments.quick;
            table.add(if cells.len() == 2 {
                Row::measure::<D2>(exec, cells, steps, quick)
            } else {
                Row::measure::<D3>(exec, cells, steps, quick)
            }?);
        }
        Ok((machine, table))
    })?;
    let Some(folder) = &arguments.out else {
        return Ok(DONE);
    };
    for dims in [2, 3] {
        files::put(
            folder,
            &format!("scaling_{dims}d.svg"),
            &chart(table.lines(), dims).to_svg(),
        )?;
    }
    section::write(Some(folder), "scaling", &text(&machine, &table))?;
    Ok(DONE)
}

impl Row {
    fn measure<S: Space>(
        exec: &dyn Exec,
        cells: &[usize],
        steps: usize,
        quick: bool,
    ) -> Result<Self, Failure> {
        let before = Moment::measure(exec, quick)?;
        let count = cells.iter().product::<usize>() * steps;
        let repeats = (ENOUGH / count).clamp(1, 20);
        let prepared = scenes::drift(cells, steps, true, exec.threads())?;
        let among = ITERATIONS[usize::from(count > LARGE)];
        let cycle = |exec: &dyn Exec| Kernel::Cycle.seconds::<S>(exec, cells, steps, repeats);
        let [alone, together] = solves::iterations::<f32, S, 2>([&Serial, exec], &prepared, among)?;
        let rows = cells.iter().skip(1).product();
        let ns = |seconds: f64| 1e9 * seconds / count as f64;
        Ok(Self {
            cells: cells.to_vec(),
            steps,
            threads: exec.threads(),
            direct_ns: [ns(alone.seconds), ns(together.seconds)],
            evaluations: together.evaluations,
            courant: together.courant,
            cycle_ns: [ns(cycle(&Serial)?), ns(cycle(exec)?)],
            triad_gains: [gain(exec, rows, cells[0])?, gain(exec, rows, cells[0] * steps)?],
            moment: before.mean(Moment::measure(exec, quick)?),
        })
    }
}

impl Line<14> for Row {
    const HEAD: [&'static str; 14] = [
        "cells",
        "steps",
        "direct, 1",
        "direct, all",
        "speed-up",
        "evaluations",
        "Courant",
        "cycle, 1",
        "cycle, all",
        "speed-up",
        "triad, a slot",
        "triad, all slots",
        "GB/s",
        "ns",
    ];
    const WIDTHS: &'static [usize] = &[14];

    fn texts(&self) -> [String; 14] {
        let ([alone, together], [in_slot, in_all]) = (self.direct_ns, self.triad_gains);
        let [cycle_alone, cycle_together] = self.cycle_ns;
        let nanoseconds = [alone, together, cycle_alone, cycle_together].map(|ns| format!("{ns:.1}"));
        let [alone_ns, together_ns, cycle_alone_ns, cycle_together_ns] = nanoseconds;
        [
            size_in_words(&self.cells),
            self.steps.to_string(),
            alone_ns,
            together_ns,
            format!("{:.2}", alone / together),
            format!("{:.2}", self.evaluations),
            format!("{:.1}", self.courant),
            cycle_alone_ns,
            cycle_together_ns,
            format!("{:.2}", cycle_alone / cycle_together),
            format!("{in_slot:.2}"),
            format!("{in_all:.2}"),
            format!("{:.1}", 1e-9 * self.moment.triad),
            self.moment
                .handover
                .map_or_else(|| "-".into(), |seconds| format!("{:.0}", 1e9 * seconds)),
        ]
    }
}

fn text(machine: &Machine, table: &Table<Row, 14>) -> String {
    format!(
        "{} The triad gains {:.2} from all threads.\n\nNanoseconds for each cell and step, f32, on one thread and on all, and what all gain on a triad over the box:\n\n{}\n\
         ![Cost in 2D](scaling_2d.svg)\n\n![Cost in 3D](scaling_3d.svg)",
        machine.sentence(),
        machine.moment.triad / machine.triad_on_one,
        table.markdown()
    )
}

/// Cost against size.
fn chart(rows: &[Row], dims: usize) -> Chart {
    let rows: Vec<&Row> = rows.iter().filter(|row| row.cells.len() == dims).collect();
    let curve = |name: &str, colour: usize, value: fn(&Row) -> f64| {
        let points = rows.iter().map(|row| {
            (
                (row.cells.iter().product::<usize>() * row.steps) as f64,
                value(row),
            )
        });
        Curve::new(name, colour, points.collect::<Vec<_>>().into_iter())
    };
    Chart {
        title: "Nanoseconds for each cell and step",
        note: "".into(),
        across: "cells times steps, f32",
        scale: Scale::Logarithmic,
        curves: vec![
            curve("direct, 1 thread", 1, |row| row.direct_ns[0]),
            curve("direct, all", 2, |row| row.direct_ns[1]),
            curve("cycle, 1 thread", 3, |row| row.cycle_ns[0]),
            curve("cycle, all", 4, |row| row.cycle_ns[1]),
        ],
    }
}

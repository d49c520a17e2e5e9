//! The scenes of the paper, and what its own table says of them.
//!
//! The paper is Z. Pan and D. Manocha, "Efficient Optimal Control of Smoke using Spacetime Multigrid" (arXiv 1608.01102). Where it
//! uses meshes and motion capture, shapes of balls and capsules stand in; places and sizes of shapes are ours.

use crate::quoted::NOT_GIVEN;

/// A scene, and by what it may be solved.
pub(crate) struct Entry {
    /// Name of its result folder.
    pub name: &'static str,
    /// What it is called in tables.
    pub about: &'static str,
    /// The scene file that it comes from.
    pub text: &'static str,
    /// What it says otherwise than that file: keys and their values in TOML.
    pub sets: &'static [(&'static str, &'static str)],
    /// The only methods that it is about; all, if none is named.
    pub only: &'static [&'static str],
    /// Its row in the paper's Table 2.
    pub quoted: Option<Quoted>,
}

/// A row of the paper's Table 2.
#[derive(Clone, Copy)]
pub(crate) struct Quoted {
    /// ADMM iterations.
    pub loops: &'static str,
    /// Seconds per AO, on average over the ADMM iterations.
    pub ao: &'static str,
    /// Seconds per NSO, likewise.
    pub nso: &'static str,
    /// Time of ADMM in all.
    pub total: &'static str,
    /// Memory of ADMM.
    pub memory: &'static str,
    /// Iterations of LBFGS.
    pub lbfgs_loops: &'static str,
    /// Time of LBFGS in all.
    pub lbfgs_total: &'static str,
}

impl Quoted {
    /// The figures in the order of the columns.
    pub const fn cells(self) -> [&'static str; 7] {
        [
            self.loops,
            self.ao,
            self.nso,
            self.total,
            self.memory,
            self.lbfgs_loops,
            self.lbfgs_total,
        ]
    }
}

/// Names of the columns that quote the paper, in the order of [`Quoted::cells`].
pub(crate) const QUOTED: [&str; 7] = [
    "paper: iterations",
    "paper: s per AO",
    "paper: s per NSO",
    "paper: in all",
    "paper: memory",
    "paper: iterations of LBFGS",
    "paper: LBFGS in all",
];

/// How many of them are of ADMM; the others are of LBFGS.
pub(crate) const QUOTED_OF_ADMM: usize = 5;

/// Where the figures of [`Quoted`] come from.
pub(crate) const QUOTED_FROM: &str = "The columns \"paper\" quote Table 2 of Z. Pan and D. Manocha, \"Efficient Optimal Control of Smoke using \
     Spacetime Multigrid\" (arXiv 1608.01102), and its text for the iterations of LBFGS: measured by its authors with their own program on an \
     i7-4790 with 12 GB. All but the last two are of ADMM and stand in its row, seconds are averages for one ADMM iteration; the last two stand in the \
     row of lbfgs. A scene that was not solved by one of the two has its figures in the first row. The paper's LBFGS keeps 8 pairs and stops as its \
     ADMM does, where no density changes by more than a hundredth of the largest from one iteration to the next; so does lbfgs here. \"N/A\" is the paper's own word, a dash is a figure that the paper does not give. Its bounds for memory, in numbers, are \
     M = 4 (1 + d) N prod(n) / (1 - 2^-d) for ADMM and L (1 + d) N prod(n) with L from 5 to 10 for LBFGS.";

const FLUID: &str = include_str!("fluid.toml");
const RABBIT: &str = include_str!("../../examples/two_circles_rabbit.toml");
const ABC: &str = include_str!("../../examples/abc.toml");
const ANIMALS: &str = include_str!("animals.toml");
const GENUS: &str = include_str!("../../examples/genus.toml");
const FIGURE: &str = include_str!("figure.toml");
const SPHERE: &str = include_str!("../../examples/moving_sphere.toml");

/// A row of the paper's Table 2 with what its text says of LBFGS, in the order of [`Quoted::cells`].
const fn row(cells: [&'static str; 7]) -> Option<Quoted> {
    let [loops, ao, nso, total, memory, lbfgs_loops, lbfgs_total] = cells;
    Some(Quoted {
        loops,
        ao,
        nso,
        total,
        memory,
        lbfgs_loops,
        lbfgs_total,
    })
}

/// Each of the letters.
const FLUID_ROW: Option<Quoted> = row(["13", "10", "60", "0.25 h", "0.06 GB", "71", "4 h"]);

/// A scene as its file has it.
const fn plain(name: &'static str, about: &'static str, text: &'static str) -> Entry {
    Entry {
        name,
        about,
        text,
        sets: &[],
        only: &[],
        quoted: None,
    }
}

impl Entry {
    const fn with(mut self, sets: &'static [(&'static str, &'static str)]) -> Self {
        self.sets = sets;
        self
    }

    const fn only(mut self, methods: &'static [&'static str]) -> Self {
        self.only = methods;
        self
    }

    const fn quoting(mut self, row: Option<Quoted>) -> Self {
        self.quoted = row;
        self
    }
}

const R: &str = "control.force_weight";
const LETTER: &str = "keyframe[0].text";
/// Smoke cannot be compressed, so the circle is as large as the letter.
const RADIUS: &str = "source.circle.radius";

pub(crate) const ENTRIES: &[Entry] = &[
    plain("fluid_f", "FLUID: circle to F", FLUID).quoting(FLUID_ROW),
    plain("fluid_l", "FLUID: circle to L", FLUID)
        .with(&[(LETTER, "\"L\""), (RADIUS, "0.1660")])
        .quoting(FLUID_ROW),
    plain("fluid_u", "FLUID: circle to U", FLUID)
        .with(&[(LETTER, "\"U\""), (RADIUS, "0.2080")])
        .quoting(FLUID_ROW),
    plain("fluid_i", "FLUID: circle to I", FLUID)
        .with(&[(LETTER, "\"I\""), (RADIUS, "0.1433")])
        .quoting(FLUID_ROW),
    plain("fluid_d", "FLUID: circle to D", FLUID)
        .with(&[(LETTER, "\"D\""), (RADIUS, "0.2214")])
        .quoting(FLUID_ROW),
    plain("rabbit_1e2", "circle, two circles, rabbit, r = 1e2", RABBIT)
        .with(&[(R, "1e2")])
        .quoting(row(["25", "20", "130", "1.04 h", "0.2 GB", "152", "12 h"])),
    plain("rabbit_1e3", "circle, two circles, rabbit, r = 1e3", RABBIT)
        .with(&[(R, "1e3")])
        .quoting(row(["37", "20", "220", "2.46 h", "0.2 GB", "170", "15 h"])),
    plain("rabbit_1e4", "circle, two circles, rabbit, r = 1e4", RABBIT)
        .with(&[(R, "1e4")])
        .quoting(row(["43", "20", "218", "2.84 h", "0.2 GB", "212", "16 h"])),
    plain("abc", "A, B, C", ABC).quoting(row(["33", "16", "179", "1.78 h", "0.15 GB", NOT_GIVEN, "14 h"])),
    plain("animals", "ball, dog, duck", ANIMALS)
        .quoting(row(["17", "103", "1341", "6.81 h", "1.34 GB", NOT_GIVEN, "N/A"])),
    plain("genus", "varying genus", GENUS)
        .quoting(row(["20", "82", "840", "5.12 h", "0.67 GB", NOT_GIVEN, "N/A"])),
    plain("figure", "walking and punching figure", FIGURE)
        .quoting(row(["5", "1437", "3534", "6.9 h", "4.0 GB", NOT_GIVEN, "N/A"])),
    plain("sphere_1e2", "moving sphere, r = 1e2", SPHERE)
        .with(&[(R, "1e2")])
        .quoting(row(["17", "630", "1792", "11.43 h", "2.2 GB", NOT_GIVEN, "N/A"])),
    plain("sphere_1e3", "moving sphere, r = 1e3", SPHERE)
        .with(&[(R, "1e3")])
        .quoting(row(["22", "630", "1978", "15.93 h", "2.2 GB", NOT_GIVEN, "N/A"])),
    plain("sphere_1e4", "moving sphere, r = 1e4", SPHERE).with(&[(R, "1e4")]),
    plain("quick", "circle to F, quick", FLUID),
    plain("central", "circle to F, central", FLUID).with(&[("advection.scheme", "\"central\"")]),
    plain("semi_lagrangian", "circle to F, semi-Lagrangian", FLUID)
        .with(&[("advection.scheme", "\"semi_lagrangian\"")]),
    plain("coarse_20", "coarse grid, 20 steps", FLUID)
        .with(COARSE_20)
        .only(NSO),
    plain("coarse_40", "coarse grid, 40 steps", FLUID)
        .with(COARSE_40)
        .only(NSO),
    plain("fine_20", "fine grid, 20 steps", FLUID)
        .with(FINE_20)
        .only(NSO),
    plain("fine_40", "fine grid, 40 steps", FLUID)
        .with(FINE_40)
        .only(NSO),
    plain("optimality", "circle to F", FLUID)
        .with(&[("method.admm.ao_iterations", "8")])
        .only(&["admm"]),
    plain("damped_1e4", "circle to F, r = 1e4", FLUID).with(&[(R, "1e4")]),
    plain("damped_1e5", "circle to F, r = 1e5", FLUID).with(&[(R, "1e5")]),
    plain("pd", "driven, without gathering", FLUID)
        .with(&[("method.pd.gathering", "0.0")])
        .only(PD),
    plain("pd_gathering", "driven, with gathering", FLUID)
        .with(&[("method.pd.gathering", "0.01")])
        .only(PD),
    plain("pd_strong", "driven too strongly", FLUID)
        .with(&[("method.pd.drive", "100.0")])
        .only(PD),
    plain("pd_weak", "driven too weakly", FLUID)
        .with(&[("method.pd.drive", "1.0")])
        .only(PD),
    plain("dt_0.4", "circle to F, dt = 0.4", FLUID).with(&[("time.dt", "0.4")]),
    plain("dt_1", "circle to F, dt = 1", FLUID),
    plain("dt_2", "circle to F, dt = 2", FLUID).with(&[("time.dt", "2.0")]),
];

const NSO: &[&str] = &["admm", "lbfgs"];
const PD: &[&str] = &["pd"];

/// Figure 6 is about the first Navier-Stokes problem alone, from rest, in the paper's own norm of the residual.
const COARSE_20: &[(&str, &str)] = &[
    CELLS_64,
    ("time.steps", "20"),
    ("keyframe[0].step", "20"),
    FEW,
    FROM_REST,
    NORM,
    FAR,
];
const COARSE_40: &[(&str, &str)] = &[CELLS_64, FEW, FROM_REST, NORM, FAR];
const FINE_20: &[(&str, &str)] = &[
    ("time.steps", "20"),
    ("keyframe[0].step", "20"),
    FEW,
    FROM_REST,
    NORM,
    FAR,
];
const FINE_40: &[(&str, &str)] = &[FEW, FROM_REST, NORM, FAR];
const CELLS_64: (&str, &str) = ("grid.cells", "[64, 64]");
const FEW: (&str, &str) = ("method.iterations", "5");
const FROM_REST: (&str, &str) = ("method.admm.nested", "false");
/// Far enough to see the rate.
const FAR: (&str, &str) = ("method.admm.nso_tolerance", "1e-7");
const NORM: (&str, &str) = ("method.admm.nso_norm", "\"plain\"");

//! The parts of the page: rows of the paper's Table 2 and figures.

/// A part of the page: a row of Table 2 in its variants, or a figure.
pub(crate) struct Section {
    /// Name on the command line.
    pub name: &'static str,
    /// Heading on the page.
    pub title: &'static str,
    /// What to look for.
    pub text: &'static str,
    /// Names of its scenes in the catalogue.
    pub entries: &'static [&'static str],
    /// What it shows beside the table.
    pub content: Content,
}

/// What a section shows of its scenes.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Content {
    /// The objective against time, and the last keyframe.
    Results,
    /// The same, and some steps on the way.
    Steps,
    /// The residual of the first Navier-Stokes problem by V-cycle.
    Cycles,
    /// The residuals of ADMM's optimality conditions.
    Optimality,
}

/// Words for several sections at once.
pub(crate) const GROUPS: [(&str, &[&str]); 4] = [
    (
        "table2",
        &["fluid", "rabbit", "abc", "animals", "genus", "figure", "sphere"],
    ),
    ("2d", &["fluid", "rabbit", "abc"]),
    (
        "figures",
        &["fig4", "fig6", "fig7", "fig8", "fig13", "fig14", "fig15", "dt"],
    ),
    (
        "all",
        &[
            "fluid", "rabbit", "abc", "animals", "genus", "figure", "sphere", "fig4", "fig6", "fig7", "fig8",
            "fig13", "fig14", "fig15", "dt",
        ],
    ),
];

const fn section(
    name: &'static str,
    title: &'static str,
    text: &'static str,
    entries: &'static [&'static str],
    content: Content,
) -> Section {
    Section {
        name,
        title,
        text,
        entries,
        content,
    }
}

pub(crate) const SECTIONS: &[Section] = &[
    section(
        "fluid",
        "FLUID",
        "A circle of smoke becomes each of five letters; each is a solve of its own.",
        &["fluid_f", "fluid_l", "fluid_u", "fluid_i", "fluid_d"],
        Content::Results,
    ),
    section(
        "rabbit",
        "Circle, two circles, rabbit",
        "One circle splits into two, and the two become a rabbit, at three weights of the force.",
        &["rabbit_1e2", "rabbit_1e3", "rabbit_1e4"],
        Content::Steps,
    ),
    section(
        "abc",
        "ABC",
        "A chain of three letters in one solve.",
        &["abc"],
        Content::Steps,
    ),
    section(
        "animals",
        "Ball, dog, duck",
        "In 3D; animals of balls and capsules stand for the paper's meshes.",
        &["animals"],
        Content::Steps,
    ),
    section(
        "genus",
        "Varying genus",
        "A ball opens to a ring and the ring to a figure eight, in a box that repeats along all axes.",
        &["genus"],
        Content::Steps,
    ),
    section(
        "figure",
        "A figure that walks and punches",
        "30 keyframes, one at every second step, in a box that repeats; joint angles stand for the paper's motion capture.",
        &["figure"],
        Content::Steps,
    ),
    section(
        "sphere",
        "Moving sphere",
        "A ball travels through three places, at two weights of the force.",
        &["sphere_1e2", "sphere_1e3"],
        Content::Steps,
    ),
    section(
        "fig4",
        "Figure 4: advection operators",
        "The same scene with three ways to carry the density.",
        &["quick", "central", "semi_lagrangian"],
        Content::Steps,
    ),
    section(
        "fig6",
        "Figure 6: convergence on two grids and two lengths",
        "The residual of the first Navier-Stokes problem by V-cycle of STFAS, in the paper's plain norm: the rate should depend neither on the grid nor on the number of steps. With adjoint control among the methods, its objective stands in the charts against time.",
        &["coarse_20", "coarse_40", "fine_20", "fine_40"],
        Content::Cycles,
    ),
    section(
        "fig7",
        "Figure 7: optimality",
        "The residual of the whole problem's optimality conditions by iteration of ADMM, and that of the advection problem by fixed-point iteration, of which there are eight here instead of two.",
        &["optimality"],
        Content::Optimality,
    ),
    section(
        "fig8",
        "Figure 8: more wake as r grows, 2D",
        "The dearer the force, the more the smoke is left to its own flow.",
        &["rabbit_1e2", "rabbit_1e3", "rabbit_1e4"],
        Content::Steps,
    ),
    section(
        "fig13",
        "Figure 13: more wake as r grows, 3D",
        "The dearer the force, the more the smoke is left to its own flow.",
        &["sphere_1e2", "sphere_1e3", "sphere_1e4"],
        Content::Steps,
    ),
    section(
        "fig14",
        "Figure 14: large r",
        "Where the force is very dear, the Navier-Stokes problem needs Levenberg-Marquardt damping. The curves are the residual of the first such problem.",
        &["damped_1e4", "damped_1e5"],
        Content::Cycles,
    ),
    section(
        "fig15",
        "Figure 15: driven smoke",
        "Target-driven smoke (Fattal and Lischinski) without and with the gathering term, too strong and too weak.",
        &["pd", "pd_gathering", "pd_strong", "pd_weak"],
        Content::Steps,
    ),
    section(
        "dt",
        "The length of a step",
        "The same scene at dt = 0.4, 1 and 2, with the same weights: convergence should not depend on it.",
        &["dt_0.4", "dt_1", "dt_2"],
        Content::Results,
    ),
];

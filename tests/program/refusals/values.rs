//! Scenes that are refused: values out of their range.

use super::{CELLS, METHOD, OUTPUT, STEP, STEPS, Spoiled, spoiled};

pub const VALUES: &[Spoiled] = &[
    // ranges
    spoiled(
        CELLS,
        "cells = [8]",
        &["scene.toml:2", "`grid.cells` has 1", "2 (a plane) or 3"],
    ),
    spoiled(CELLS, "cells = [8, 8, 8, 8]", &["`grid.cells` has 4"]),
    spoiled(CELLS, "cells = [3, 8]", &["`grid.cells[0]` is 3", "4 to 4096"]),
    spoiled(
        CELLS,
        "cells = [8, 4097]",
        &["`grid.cells[1]` is 4097", "4 to 4096"],
    ),
    spoiled(CELLS, "cells = [8, -8]", &["-8", "4 to 4096"]),
    spoiled(
        CELLS,
        "cells = [8, 8]\nlength = 0.0",
        &["scene.toml:3", "`grid.length` is 0", "above 0"],
    ),
    spoiled(CELLS, "cells = [8, 8]\nlength = nan", &["`grid.length` is NaN"]),
    spoiled(CELLS, "cells = [8, 8]\nlength = inf", &["`grid.length` is inf"]),
    spoiled(
        CELLS,
        "cells = [8, 8]\nboundary = \"closed\"",
        &[
            "scene.toml:3",
            "\"closed\"",
            "\"wall\" or \"periodic\" or \"open\"",
        ],
    ),
    spoiled(
        CELLS,
        "cells = [8, 8]\nboundary = [\"wall\"]",
        &["`grid.boundary`", "2 such words"],
    ),
    spoiled(
        CELLS,
        "cells = [8, 8]\nboundary = [\"wall\", 3]",
        &["`grid.boundary[1]` is 3"],
    ),
    spoiled(STEPS, "steps = 1", &["`time.steps` is 1", "from 2"]),
    spoiled(STEPS, "steps = -4", &["`time.steps` is -4"]),
    spoiled(STEPS, "steps = 4\ndt = -0.1", &["`time.dt` is -0.1", "above 0"]),
    spoiled(
        STEP,
        "step = 5\n",
        &["scene.toml:8", "`keyframe[0].step` is 5", "2 to 4"],
    ),
    spoiled(STEP, "step = 1\n", &["`keyframe[0].step` is 1", "2 to 4"]),
    spoiled(METHOD, "iterations = 0", &["`method.iterations` is 0"]),
    spoiled(OUTPUT, "folder = \"\"", &["`output.folder` is empty"]),
    spoiled(
        METHOD,
        "[flow]\nviscosity = -1e-3",
        &["`flow.viscosity` is -0.001", "from 0"],
    ),
    spoiled(
        METHOD,
        "[flow]\nslip = false",
        &["`flow.slip` is false", "flow.viscosity is 0", "flow.slip = true"],
    ),
    spoiled(
        METHOD,
        "[flow]\nviscosity = 1e30",
        &["`flow.viscosity` is 1e30", "smaller"],
    ),
    spoiled(
        OUTPUT,
        "frames = false\n[control]\nforce_weight = -1.0",
        &["scene.toml:15", "`control.force_weight` is -1"],
    ),
    spoiled(
        OUTPUT,
        "frames = false\n[control]\nforce_weight = 0",
        &["`control.force_weight` is 0", "above 0"],
    ),
    spoiled(
        OUTPUT,
        "frames = false\n[control]\nfilters = \"all\"",
        &["`control.filters` is \"all\"", "\"auto\""],
    ),
    spoiled(
        OUTPUT,
        "frames = false\n[control]\nfilters = 99",
        &["`control.filters` is 99", "0 to 12"],
    ),
    spoiled(
        OUTPUT,
        "frames = false\n[control]\nsmoothness = -1.0",
        &["`control.smoothness` is -1.0", "from 0 to 64"],
    ),
    spoiled(
        OUTPUT,
        "frames = false\n[control]\nsmoothness = nan",
        &["`control.smoothness` is NaN", "from 0 to 64"],
    ),
    spoiled(
        OUTPUT,
        "frames = false\n[control]\nsmoothness = true",
        &["`control.smoothness` is true", "\"auto\""],
    ),
    spoiled(
        OUTPUT,
        "frames = false\n[control]\ninitial_velocity = \"fast\"",
        &["`control.initial_velocity`", "\"rest\""],
    ),
    spoiled(
        OUTPUT,
        "frames = false\n[control]\ninitial_velocity = { path = \"v\" }",
        &["initial_velocity", "path", "file"],
    ),
    spoiled(
        OUTPUT,
        "frames = false\n[advection]\nscheme = \"upwind\"",
        &["`advection.scheme` is \"upwind\"", "\"quick\""],
    ),
    spoiled(
        OUTPUT,
        "frames = false\n[advection]\ntolerance = 0",
        &["`advection.tolerance` is 0"],
    ),
    spoiled(
        OUTPUT,
        "frames = false\n[method.admm]\npenalty = -3.0",
        &["`method.admm.penalty` is -3"],
    ),
    spoiled(
        OUTPUT,
        "frames = false\n[method.admm]\nrelaxation = 2.5",
        &["`method.admm.relaxation` is 2.5"],
    ),
    spoiled(
        OUTPUT,
        "frames = false\n[method.admm]\nao_momentum = 1.0",
        &["`method.admm.ao_momentum` is 1", "from 0 up to but not 1"],
    ),
    spoiled(
        OUTPUT,
        "frames = false\n[method.admm]\nnso_norm = \"max\"",
        &["`method.admm.nso_norm` is \"max\"", "\"scaled\" or \"plain\""],
    ),
    spoiled(
        OUTPUT,
        "frames = false\n[method.direct]\nhistory_precision = \"quarter\"",
        &[
            "`method.direct.history_precision` is \"quarter\"",
            "\"full\" or \"half\"",
        ],
    ),
    spoiled(
        OUTPUT,
        "frames = false\n[method.admm]\nao_iterations = 0",
        &["`method.admm.ao_iterations` is 0"],
    ),
    spoiled(
        OUTPUT,
        "frames = false\n[method.admm]\nnso_tolerance = nan",
        &["`method.admm.nso_tolerance` is NaN"],
    ),
    spoiled(
        OUTPUT,
        "frames = false\n[method.admm]\nnso = \"magic\"",
        &["`method.admm.nso` is \"magic\"", "\"stfas\" or \"newton_cg\""],
    ),
    spoiled(
        OUTPUT,
        "frames = false\n[method.direct]\nhistory = 9",
        &[
            "`method.direct.history` is 9",
            "only \"auto\" or a whole number from 1 to 8",
        ],
    ),
    spoiled(
        OUTPUT,
        "frames = false\n[method.direct]\nhistory = 2.0",
        &[
            "`method.direct.history` is 2.0",
            "only \"auto\" or a whole number from 1 to 8",
        ],
    ),
    spoiled(
        OUTPUT,
        "frames = false\n[method.direct]\nhistory = \"all\"",
        &["`method.direct.history`", "\"auto\""],
    ),
    spoiled(
        OUTPUT,
        "frames = false\n[method.direct]\ntolerance = 0.0",
        &["`method.direct.tolerance`"],
    ),
    spoiled(
        OUTPUT,
        "frames = false\n[method.direct]\nnested = 1",
        &["`method.direct.nested`", "boolean"],
    ),
    spoiled(
        OUTPUT,
        "frames = false\n[method.admm]\nsmoother_colours = \"blue\"",
        &["\"blue\"", "\"red_black\" or \"2^d\""],
    ),
    spoiled(
        OUTPUT,
        "frames = false\n[method.projection]\ntolerance = -1",
        &["`method.projection.tolerance` is -1"],
    ),
    spoiled(
        STEPS,
        "steps = 4\ndt = 1e-200",
        &["`control.force_weight`", "`time.dt`"],
    ),
];

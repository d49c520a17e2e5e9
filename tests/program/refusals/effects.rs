//! Scenes that are refused: emitters, buoyancy, schedules, weights, regions and releases.

use super::{METHOD, OUTPUT, SOURCE, STEP, STEPS, Spoiled, TARGET, spoiled};

/// The whole source of [`super::GOOD`].
const WHOLE_SOURCE: &str = "[source]\ncircle = { center = [0.5, 0.5], radius = 0.3 }\n";

pub const EFFECTS: &[Spoiled] = &[
    // windows
    spoiled(
        METHOD,
        "window = 1",
        &["scene.toml:11: `method.window` is 1", "whole number from 2"],
    ),
    spoiled(
        METHOD,
        "window = \"all\"",
        &["`method.window` is \"all\"", "whole number from 2"],
    ),
    spoiled(
        METHOD,
        "stride = 2",
        &[
            "scene.toml:11: `method.stride` stands without `window`",
            "write window = 40",
        ],
    ),
    spoiled(
        METHOD,
        "window = 3\nstride = 0",
        &["scene.toml:12: `method.stride` is 0", "whole number from 1"],
    ),
    spoiled(
        METHOD,
        "window = 3\nstride = 3",
        &[
            "scene.toml:12: `method.stride` is 3",
            "a window of 3 steps",
            "2 at most",
        ],
    ),
    spoiled(
        METHOD,
        "name = \"pd\"\nwindow = 3",
        &[
            "`method.window` is more than the method pd can do",
            "take the method direct",
        ],
    ),
    spoiled(
        METHOD,
        "window = 3\n[[template]]\nkind = \"wind\"\ncenter = [0.5, 0.5]\nradius = 0.3",
        &[
            "`method.window` is more than the method templates can do",
            "all steps at once",
        ],
    ),
    // steps of emitters
    spoiled(
        SOURCE,
        "circle = { center = [0.5, 0.5], radius = 0.3 }\n[[emitter]]\nfrom = 4\nrate = 0.1\ncircle = { center = [0.5, 0.2], radius = 0.2 }",
        &["scene.toml:8: `emitter[0].from` is 4", "whole number from 0 to 3"],
    ),
    spoiled(
        SOURCE,
        "circle = { center = [0.5, 0.5], radius = 0.3 }\n[[emitter]]\nto = 5\nrate = 0.1\ncircle = { center = [0.5, 0.2], radius = 0.2 }",
        &["scene.toml:8: `emitter[0].to` is 5", "whole number from 1 to 4"],
    ),
    spoiled(
        SOURCE,
        "circle = { center = [0.5, 0.5], radius = 0.3 }\n[[emitter]]\nfrom = 2\nto = 2\nrate = 0.1\ncircle = { center = [0.5, 0.2], radius = 0.2 }",
        &[
            "scene.toml:9: `emitter[0].to` is 2",
            "begins at step 2",
            "let it end later",
        ],
    ),
    spoiled(
        SOURCE,
        "circle = { center = [0.5, 0.5], radius = 0.3 }\n[[emitter]]\nfrom = 3\nto = 1\nrate = 0.1\ncircle = { center = [0.5, 0.2], radius = 0.2 }",
        &["`emitter[0].to` is 1", "begins at step 3"],
    ),
    spoiled(
        SOURCE,
        "circle = { center = [0.5, 0.5], radius = 0.3 }\n[[emitter]]\nfrom = 0.5\nrate = 0.1\ncircle = { center = [0.5, 0.2], radius = 0.2 }",
        &["`emitter[0].from` is 0.5", "whole number from 0 to 3"],
    ),
    // how much they make
    spoiled(
        SOURCE,
        "circle = { center = [0.5, 0.5], radius = 0.3 }\n[[emitter]]\ncircle = { center = [0.5, 0.2], radius = 0.2 }",
        &[
            "scene.toml:7: `emitter[0].rate` is missing",
            "rate = 0.2",
            "target = 1.0",
        ],
    ),
    spoiled(
        SOURCE,
        "circle = { center = [0.5, 0.5], radius = 0.3 }\n[[emitter]]\nrate = 0.1\ntarget = 1.0\ncircle = { center = [0.5, 0.2], radius = 0.2 }",
        &[
            "scene.toml:9: `emitter[0].target` stands beside `rate`",
            "take one of them out",
        ],
    ),
    spoiled(
        SOURCE,
        "circle = { center = [0.5, 0.5], radius = 0.3 }\n[[emitter]]\nrate = 0\ncircle = { center = [0.5, 0.2], radius = 0.2 }",
        &["scene.toml:8: `emitter[0].rate` is 0", "above 0"],
    ),
    spoiled(
        SOURCE,
        "circle = { center = [0.5, 0.5], radius = 0.3 }\n[[emitter]]\nrate = -0.5\ncircle = { center = [0.5, 0.2], radius = 0.2 }",
        &["`emitter[0].rate` is -0.5", "above 0"],
    ),
    spoiled(
        SOURCE,
        "circle = { center = [0.5, 0.5], radius = 0.3 }\n[[emitter]]\nrate = \"much\"\ncircle = { center = [0.5, 0.2], radius = 0.2 }",
        &["`emitter[0].rate` is \"much\"", "above 0"],
    ),
    spoiled(
        SOURCE,
        "circle = { center = [0.5, 0.5], radius = 0.3 }\n[[emitter]]\nrate = inf\ncircle = { center = [0.5, 0.2], radius = 0.2 }",
        &["`emitter[0].rate` is inf", "above 0"],
    ),
    // the velocity of their smoke
    spoiled(
        SOURCE,
        "circle = { center = [0.5, 0.5], radius = 0.3 }\n[[emitter]]\nrate = 0.1\nvelocity = 0.1\ncircle = { center = [0.5, 0.2], radius = 0.2 }",
        &[
            "scene.toml:9: `emitter[0].velocity` is 0.1",
            "list of 2 finite numbers",
        ],
    ),
    spoiled(
        SOURCE,
        "circle = { center = [0.5, 0.5], radius = 0.3 }\n[[emitter]]\nrate = 0.1\nvelocity = [0, inf]\ncircle = { center = [0.5, 0.2], radius = 0.2 }",
        &["`emitter[0].velocity` is a list of 2", "finite"],
    ),
    spoiled(
        SOURCE,
        "circle = { center = [0.5, 0.5], radius = 0.3 }\n[[emitter]]\nrate = 0.1\nvelocity = [0, 2]\ncircle = { center = [0.5, 0.2], radius = 0.2 }",
        &["`emitter[0].velocity` is 2.0 boxes a step", "make it slower"],
    ),
    spoiled(
        METHOD,
        "name = \"admm\"\n[[emitter]]\nrate = 0.1\nvelocity = [0, 0.01]\ncircle = { center = [0.5, 0.2], radius = 0.2 }",
        &[
            "`emitter` is more than the method admm can do",
            "leave out its `velocity`",
        ],
    ),
    // sequences
    spoiled(
        STEP,
        "step = 4\nsteps = { from = 2, every = 1 }\n",
        &["`keyframe[0].steps` stands beside `step`"],
    ),
    spoiled(
        STEP,
        "steps = { from = 2, every = 1 }\n",
        &[
            "in keyframe[0]: `steps` asks for a sequence of shapes",
            "files = \"horse_*.png\"",
        ],
    ),
    spoiled(
        STEP,
        "steps = 4\n",
        &["`keyframe[0].steps` is 4", "{ from = 10, every = 5 }"],
    ),
    spoiled(
        STEP,
        "steps = { from = 2 }\n",
        &["`keyframe[0].steps.every` is missing"],
    ),
    spoiled(
        "step = 4\ncircle = { center = [0.5, 0.6], radius = 0.3 }",
        "step = 4\nfiles = \"horse_*.png\"",
        &["`keyframe[0].steps` is missing"],
    ),
    spoiled(
        "step = 4\ncircle = { center = [0.5, 0.6], radius = 0.3 }",
        "steps = { from = 2, every = 1 }\nfiles = \"horse.png\"",
        &["`keyframe[0].files` is \"horse.png\"", "no `*`"],
    ),
    spoiled(
        "step = 4\ncircle = { center = [0.5, 0.6], radius = 0.3 }",
        "steps = { from = 2, every = 1 }\nfiles = \"no_such_*.png\"",
        &["`keyframe[0].files` is \"no_such_*.png\"", "fits no file"],
    ),
    spoiled(
        "step = 4\ncircle = { center = [0.5, 0.6], radius = 0.3 }",
        "steps = { from = 2, every = 1 }\nfiles = 4",
        &["`keyframe[0].files` is 4", "pattern with one `*`"],
    ),
    // obstacles
    spoiled(
        SOURCE,
        "circle = { center = [0.25, 0.25], radius = 0.1 }\n[[obstacle]]\nbox = { min = [0, 0], max = [0.75, 0.75] }",
        &["`source` cannot be used", "inside solid cells"],
    ),
    // of a keyframe, a mask and an emitter nothing but a soft edge
    spoiled(
        TARGET,
        "circle = { center = [0.8125, 0.8125], radius = 0.12 }\n[[obstacle]]\ncircle = { center = [0.8125, 0.8125], radius = 0.25 }",
        &["`keyframe[0]` cannot be used", "inside solid cells"],
    ),
    spoiled(
        TARGET,
        "circle = { center = [0.5, 0.6], radius = 0.3 }\n[control]\nmask = { circle = { center = [0.8125, 0.8125], radius = 0.12 } }\n[[obstacle]]\ncircle = { center = [0.8125, 0.8125], radius = 0.25 }",
        &["`control.mask`", "allows force nowhere"],
    ),
    spoiled(
        TARGET,
        "circle = { center = [0.5, 0.6], radius = 0.3 }\n[[emitter]]\nrate = 0.1\ncircle = { center = [0.8125, 0.8125], radius = 0.12 }\n[[obstacle]]\ncircle = { center = [0.8125, 0.8125], radius = 0.25 }",
        &["`emitter[0]` cannot be used", "inside solid cells"],
    ),
    spoiled(
        SOURCE,
        "circle = { center = [0.5, 0.5], radius = 0.3 }\n[[obstacle]]\nbox = { min = [-1, -1], max = [2, 2] }",
        &[
            "`obstacle[0]` cannot be used",
            "all cells are solid",
            "leave room",
        ],
    ),
    spoiled(
        SOURCE,
        "box = { min = [0.0, 0.0], max = [0.125, 1.0] }\n[[obstacle]]\nbox = { min = [0.375, -1], max = [0.625, 2] }",
        &["`keyframe[0]` cannot be reached", "obstacles let no smoke come"],
    ),
    spoiled(
        SOURCE,
        "circle = { center = [0.5, 0.5], radius = 0.3 }\n[[obstacle]]\ncircle = { center = [0.1, 0.1], radius = 0.001 }",
        &["`obstacle[0]` covers no cell by half"],
    ),
    spoiled(
        SOURCE,
        "circle = { center = [0.5, 0.5], radius = 0.3 }\n[[obstacle]]\nbox = { min = [0, 0], max = [0.1, 0.2] }\n[advection]\nscheme = \"quick\"",
        &["limited transport", "solid cells"],
    ),
    spoiled(
        SOURCE,
        "circle = { center = [0.5, 0.5], radius = 0.3 }\n[[emitter]]\nrate = 1e7\ncircle = { center = [0.5, 0.2], radius = 0.2 }",
        &[
            "`emitter[0].rate` is 10000000.0",
            "a number from 1e-30 to 1000000",
        ],
    ),
    // their keys and shapes
    spoiled(
        SOURCE,
        "circle = { center = [0.5, 0.5], radius = 0.3 }\n[[emitter]]\nspeed = 1.0\nrate = 0.1\ncircle = { center = [0.5, 0.2], radius = 0.2 }",
        &[
            "scene.toml:8: `emitter[0].speed`",
            "no key `speed`",
            "`from`, `to`, `steps`, `files`, `rate`, `target`, `velocity`, `circle`",
        ],
    ),
    spoiled(
        SOURCE,
        "circle = { center = [0.5, 0.5], radius = 0.3 }\n[emitter]\nrate = 0.1\ncircle = { center = [0.5, 0.2], radius = 0.2 }",
        &["`emitter`", "[[emitter]]"],
    ),
    spoiled(
        SOURCE,
        "circle = { center = [0.5, 0.5], radius = 0.3 }\n[[emitter]]\nrate = 0.1",
        &["scene.toml:7", "in emitter[0]", "circle, sphere, box"],
    ),
    spoiled(
        SOURCE,
        "circle = { center = [0.5, 0.5], radius = 0.3 }\n[[emitter]]\nrate = 0.1\nshapes = []",
        &["scene.toml:9", "in emitter[0]: `shapes` is empty"],
    ),
    spoiled(
        SOURCE,
        "circle = { center = [0.5, 0.5], radius = 0.3 }\n[[emitter]]\nrate = 0.1\ncircle = { center = [9, 9], radius = 0.2 }",
        &[
            "scene.toml:9",
            "in emitter[0]: `circle` puts nothing into the box",
            "move it into the box",
        ],
    ),
    // no smoke at all, or none yet
    spoiled(
        WHOLE_SOURCE,
        "",
        &[
            "`source` is missing",
            "[source] with a shape",
            "or an [[emitter]]",
        ],
    ),
    spoiled(
        WHOLE_SOURCE,
        "[[emitter]]\nfrom = 3\nrate = 0.1\ncircle = { center = [0.5, 0.2], radius = 0.2 }\n[[keyframe]]\nstep = 3\ncircle = { center = [0.5, 0.6], radius = 0.3 }\n",
        &[
            "scene.toml:10: `keyframe[0].step` is 3",
            "begins at step 3",
            "no smoke yet",
            "write a [source]",
        ],
    ),
    // releases
    spoiled(
        METHOD,
        "[[release]]\nfrom = 4",
        &[
            "scene.toml:12: `release[0].from` is 4",
            "ends at step 4",
            "raise `time.steps`",
        ],
    ),
    spoiled(
        METHOD,
        "[[release]]\nfrom = 3",
        &[
            "scene.toml:12: `release[0].from` is 3",
            "a keyframe stands at step 4",
            "there or later",
        ],
    ),
    spoiled(
        STEP,
        "step = 2\nhold = 1\ncircle = { center = [0.5, 0.6], radius = 0.3 }\n[[release]]\nfrom = 2\n[[keyframe]]\nstep = 4\n",
        &["`release[0].from` is 2", "a keyframe stands at step 4"],
    ),
    spoiled(
        "step = 4\ncircle = { center = [0.5, 0.6], radius = 0.3 }\n",
        "step = 2\nhold = 1\ncircle = { center = [0.5, 0.6], radius = 0.3 }\n[[release]]\nfrom = 2\n",
        &[
            "scene.toml:12: `release[0].from` is 2",
            "a keyframe stands at step 3",
        ],
    ),
    spoiled(
        METHOD,
        "[[release]]\nfrom = 1",
        &["`release[0].from` is 1", "whole number from 2"],
    ),
    spoiled(
        STEP,
        "step = 2\ncircle = { center = [0.5, 0.6], radius = 0.3 }\n[[release]]\nfrom = 3\n[[release]]\nfrom = 3\n[[keyframe]]\nstep = 4\n",
        &["`release[1]` is a second release", "write one"],
    ),
    spoiled(
        METHOD,
        "[[release]]",
        &["scene.toml:11: `release[0].from` is missing", "from = 40"],
    ),
    spoiled(METHOD, "[release]\nfrom = 3", &["`release`", "[[release]]"]),
    spoiled(
        METHOD,
        "[[release]]\nfrom = 3\nto = 4",
        &["`release[0].to`", "no key `to`", "`from`"],
    ),
    // the schedule
    spoiled(
        OUTPUT,
        "frames = false\n[control]\nschedule = 2.0",
        &["scene.toml:15: `control.schedule` is 2.0", "a list of pairs"],
    ),
    spoiled(
        OUTPUT,
        "frames = false\n[control]\nschedule = []",
        &["`control.schedule` is a list of 0", "a list of pairs"],
    ),
    spoiled(
        OUTPUT,
        "frames = false\n[control]\nschedule = [0, 1.0]",
        &["`control.schedule[0]` is 0", "a pair of step and factor"],
    ),
    spoiled(
        OUTPUT,
        "frames = false\n[control]\nschedule = [[0, 1.0, 2.0]]",
        &[
            "`control.schedule[0]` is a list of 3",
            "a pair of step and factor",
        ],
    ),
    spoiled(
        OUTPUT,
        "frames = false\n[control]\nschedule = [[2, 1.0], [1, 0.5]]",
        &["`control.schedule[1]` is step 1 after step 2", "in their order"],
    ),
    spoiled(
        OUTPUT,
        "frames = false\n[control]\nschedule = [[2, 1.0], [2, 0.5]]",
        &["`control.schedule[1]` is step 2 after step 2", "each once"],
    ),
    spoiled(
        OUTPUT,
        "frames = false\n[control]\nschedule = [[0, 0]]",
        &["`control.schedule[0][1]` is 0", "above 0"],
    ),
    spoiled(
        OUTPUT,
        "frames = false\n[control]\nschedule = [[0, 1.0], [5, 0.5]]",
        &["`control.schedule[1][0]` is 5", "whole number from 0 to 4"],
    ),
    spoiled(
        OUTPUT,
        "frames = false\n[control]\nschedule = [[0, 1.0], [2, 1e300]]",
        &[
            "`control.schedule[1][1]` is 1e300",
            "only 1e-15 to 1e15",
            "or `control.force_weight`",
        ],
    ),
    // the mask
    spoiled(
        OUTPUT,
        "frames = false\n[control]\nmask = 0.5",
        &["scene.toml:15: `control.mask` is 0.5", "a shape, as in"],
    ),
    spoiled(
        OUTPUT,
        "frames = false\n[control]\nmask = { circle = { center = [4.0, 0.5], radius = 0.3 } }",
        &["in control.mask", "box"],
    ),
    spoiled(
        OUTPUT,
        "frames = false\n[control]\nmask = { density = 2.0, circle = { center = [0.5, 0.5], radius = 0.3 } }",
        &["`control.mask` has values above 1", "take out its `density`"],
    ),
    // buoyancy
    spoiled(
        METHOD,
        "[flow]\nbuoyancy = nan",
        &["scene.toml:12: `flow.buoyancy` is NaN", "finite"],
    ),
    spoiled(
        METHOD,
        "[flow]\nbuoyancy = \"up\"",
        &["`flow.buoyancy`", "a number"],
    ),
    spoiled(
        METHOD,
        "[flow]\nbuoyancy = 1e-3\ngravity = [0, 0, -1]",
        &[
            "scene.toml:13: `flow.gravity` is [0.0, 0.0, -1.0]",
            "2 numbers, not all 0, as in [0, -1]",
        ],
    ),
    spoiled(
        METHOD,
        "[flow]\nbuoyancy = 1e-3\ngravity = [0, 0]",
        &[
            "`flow.gravity` is [0.0, 0.0]",
            "2 numbers, not all 0, as in [0, -1]",
        ],
    ),
    spoiled(METHOD, "[flow]\ngravity = -9.81", &["`flow.gravity`", "a list"]),
    // weights and regions
    spoiled(
        STEP,
        "step = 4\nweight = 0\n",
        &["scene.toml:9: `keyframe[0].weight` is 0", "above 0"],
    ),
    spoiled(
        STEP,
        "step = 4\nweight = 1e16\n",
        &["`keyframe[0].weight` is 1e16", "from 1e-15 to 1e15"],
    ),
    spoiled(
        STEP,
        "step = 4\nweight = -1.5\n",
        &["`keyframe[0].weight` is -1.5", "above 0"],
    ),
    spoiled(
        STEP,
        "step = 4\nweight = \"heavy\"\n",
        &["`keyframe[0].weight` is \"heavy\"", "above 0"],
    ),
    spoiled(
        TARGET,
        "circle = { center = [0.5, 0.6], radius = 0.3 }\nregion = \"left\"",
        &[
            "scene.toml:10: `keyframe[0].region` is \"left\"",
            "a shape, as in { box",
        ],
    ),
    spoiled(
        TARGET,
        "circle = { center = [0.5, 0.6], radius = 0.3 }\nregion = { box = { min = [0, 0], max = [1, 1] }, density = 2 }",
        &[
            "scene.toml:10: `keyframe[0].region` has values above 1",
            "from 0 to 1",
            "take out its `density`",
        ],
    ),
    spoiled(
        TARGET,
        "circle = { center = [0.5, 0.6], radius = 0.3 }\nregion = { circle = { center = [9, 9], radius = 0.2 } }",
        &[
            "scene.toml:10",
            "in keyframe[0].region: `circle` puts nothing into the box",
        ],
    ),
    spoiled(
        TARGET,
        "circle = { center = [0.5, 0.6], radius = 0.3 }\nregion = {}",
        &["scene.toml:10", "in keyframe[0].region", "circle, sphere, box"],
    ),
    spoiled(
        STEPS,
        "steps = 4\n[[release]]\nfrom = 9223372036854775807",
        &["`release[0].from` is 9223372036854775807", "whole number from 2"],
    ),
];

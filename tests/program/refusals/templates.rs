//! Scenes that are refused: templates, and methods that know none.

use super::{METHOD, SOURCE, STEPS, Spoiled, spoiled};

pub const TEMPLATES: &[Spoiled] = &[
    spoiled(
        SOURCE,
        "circle = { center = [0.5, 0.5], radius = 0.3 }\n[[template]]\ncenter = [0.5, 0.5]\nradius = 0.2",
        &["scene.toml:7: `template[0].kind` is missing", "kind = \"vortex\""],
    ),
    spoiled(
        SOURCE,
        "circle = { center = [0.5, 0.5], radius = 0.3 }\n[[template]]\nkind = \"storm\"\ncenter = [0.5, 0.5]\nradius = 0.2",
        &[
            "scene.toml:8: `template[0].kind` is \"storm\"",
            "\"wind\" or \"vortex\" or \"noise\" or \"attract\"",
        ],
    ),
    spoiled(
        SOURCE,
        "circle = { center = [0.5, 0.5], radius = 0.3 }\n[[template]]\nkind = 3\ncenter = [0.5, 0.5]\nradius = 0.2",
        &["`template[0].kind` is 3", "\"vortex\""],
    ),
    spoiled(
        SOURCE,
        "circle = { center = [0.5, 0.5], radius = 0.3 }\n[[template]]\nkind = \"wind\"\nradius = 0.2",
        &["`template[0].center` is missing", "center = [0.5, 0.5]"],
    ),
    spoiled(
        SOURCE,
        "circle = { center = [0.5, 0.5], radius = 0.3 }\n[[template]]\nkind = \"wind\"\ncenter = [0.5]\nradius = 0.2",
        &["`template[0].center` is a list of 1", "list of 2 finite numbers"],
    ),
    spoiled(
        SOURCE,
        "circle = { center = [0.5, 0.5], radius = 0.3 }\n[[template]]\nkind = \"wind\"\ncenter = [0.5, nan]\nradius = 0.2",
        &["`template[0].center` is a list of 2", "finite"],
    ),
    spoiled(
        SOURCE,
        "circle = { center = [0.5, 0.5], radius = 0.3 }\n[[template]]\nkind = \"wind\"\ncenter = [0.5, 1.25]\nradius = 0.2",
        &[
            "scene.toml:9: `template[0].center[1]` is 1.25 along y",
            "outside the box",
            "move it inside",
        ],
    ),
    spoiled(
        SOURCE,
        "circle = { center = [0.5, 0.5], radius = 0.3 }\n[[template]]\nkind = \"wind\"\ncenter = [-0.1, 0.5]\nradius = 0.2",
        &["`template[0].center[0]` is -0.1 along x", "outside the box"],
    ),
    spoiled(
        SOURCE,
        "circle = { center = [0.5, 0.5], radius = 0.3 }\n[[template]]\nkind = \"wind\"\ncenter = [0.5, 0.5]",
        &["`template[0].radius` is missing", "radius = 0.1"],
    ),
    spoiled(
        SOURCE,
        "circle = { center = [0.5, 0.5], radius = 0.3 }\n[[template]]\nkind = \"wind\"\ncenter = [0.5, 0.5]\nradius = 0",
        &["scene.toml:10: `template[0].radius` is 0", "above 0"],
    ),
    spoiled(
        SOURCE,
        "circle = { center = [0.5, 0.5], radius = 0.3 }\n[[template]]\nkind = \"wind\"\ncenter = [0.5, 0.5]\nradius = 0.05",
        &[
            "`template[0].radius` is 0.05",
            "a cell has a side of 0.125",
            "make it larger",
        ],
    ),
    spoiled(
        SOURCE,
        "circle = { center = [0.5, 0.5], radius = 0.3 }\n[[template]]\nkind = \"wind\"\ncenter = [0.5, 0.5]\nradius = 0.2\nfrom = 3",
        &["`template[0].from` is 3", "whole number from 0 to 2"],
    ),
    spoiled(
        SOURCE,
        "circle = { center = [0.5, 0.5], radius = 0.3 }\n[[template]]\nkind = \"wind\"\ncenter = [0.5, 0.5]\nradius = 0.2\nfrom = 2\nto = 2",
        &["`template[0].to` is 2", "begins at step 2", "let it end later"],
    ),
    spoiled(
        SOURCE,
        "circle = { center = [0.5, 0.5], radius = 0.3 }\n[[template]]\nkind = \"wind\"\ncenter = [0.5, 0.5]\nradius = 0.2\nto = 5",
        &["`template[0].to` is 5", "whole number from 1 to 4"],
    ),
    spoiled(
        SOURCE,
        "circle = { center = [0.5, 0.5], radius = 0.3 }\n[[template]]\nkind = \"wind\"\ncenter = [0.5, 0.5]\nradius = 0.2\ninterval = 0",
        &["`template[0].interval` is 0", "whole number from 1 to 4"],
    ),
    spoiled(
        SOURCE,
        "circle = { center = [0.5, 0.5], radius = 0.3 }\n[[template]]\nkind = \"wind\"\ncenter = [0.5, 0.5]\nradius = 0.2\nmove = 1",
        &["`template[0].move` is 1", "true or false"],
    ),
    spoiled(
        SOURCE,
        "circle = { center = [0.5, 0.5], radius = 0.3 }\n[[template]]\nkind = \"wind\"\ncenter = [0.5, 0.5]\nradius = 0.2\namplitude = 0.1",
        &["`template[0].amplitude` is 0.1", "list of 2 finite numbers"],
    ),
    spoiled(
        SOURCE,
        "circle = { center = [0.5, 0.5], radius = 0.3 }\n[[template]]\nkind = \"vortex\"\ncenter = [0.5, 0.5]\nradius = 0.2\namplitude = [1, 2]",
        &["`template[0].amplitude` is a list of 2", "a finite number"],
    ),
    spoiled(
        SOURCE,
        "circle = { center = [0.5, 0.5], radius = 0.3 }\n[[template]]\nkind = \"wind\"\ncenter = [0.5, 0.5]\nradius = 0.2\nsize = 0.1",
        &["`template[0].size` is a key of noise alone", "take it out"],
    ),
    spoiled(
        SOURCE,
        "circle = { center = [0.5, 0.5], radius = 0.3 }\n[[template]]\nkind = \"wind\"\ncenter = [0.5, 0.5]\nradius = 0.2\nseed = 3",
        &["`template[0].seed` is a key of noise alone"],
    ),
    spoiled(
        SOURCE,
        "circle = { center = [0.5, 0.5], radius = 0.3 }\n[[template]]\nkind = \"noise\"\ncenter = [0.5, 0.5]\nradius = 0.2\nsize = 0",
        &["`template[0].size` is 0", "above 0"],
    ),
    spoiled(
        SOURCE,
        "circle = { center = [0.5, 0.5], radius = 0.3 }\n[[template]]\nkind = \"noise\"\ncenter = [0.5, 0.5]\nradius = 0.2\nseed = -1",
        &["`template[0].seed` is -1", "whole number from 0"],
    ),
    spoiled(
        SOURCE,
        "circle = { center = [0.5, 0.5], radius = 0.3 }\n[[template]]\nkind = \"wind\"\ncenter = [0.5, 0.5]\nradius = 0.2\nstrength = 1",
        &["there is no key `strength` here", "`amplitude`"],
    ),
    spoiled(
        SOURCE,
        "circle = { center = [0.5, 0.5], radius = 0.3 }\n[template]\nkind = \"wind\"",
        &["`template`", "[[template]]"],
    ),
    // methods that know none, and one that knows nothing else
    spoiled(
        METHOD,
        "name = \"direct\"\n[[template]]\nkind = \"wind\"\ncenter = [0.5, 0.5]\nradius = 0.2",
        &[
            "`template` is more than the method direct can do",
            "leave it out",
            "the method templates",
        ],
    ),
    spoiled(
        METHOD,
        "name = \"pd\"\n[[template]]\nkind = \"wind\"\ncenter = [0.5, 0.5]\nradius = 0.2",
        &["`template` is more than the method pd can do"],
    ),
    spoiled(
        METHOD,
        "name = \"templates\"",
        &[
            "scene.toml:11: `method.name` is templates",
            "no [[template]]",
            "write one",
        ],
    ),
    spoiled(
        METHOD,
        "[method.templates]\nhistory = 9\n[[template]]\nkind = \"wind\"\ncenter = [0.5, 0.5]\nradius = 0.2",
        &["`method.templates.history` is 9", "from 1 to 8"],
    ),
    // a release
    spoiled(
        STEPS,
        "steps = 6\n[[release]]\nfrom = 4\n[[template]]\nkind = \"wind\"\ncenter = [0.5, 0.5]\nradius = 0.2\nfrom = 3",
        &["`template[0].from` is 3", "released at 4", "sooner"],
    ),
];

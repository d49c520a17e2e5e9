//! Small scenes, one for each way in which a solve is kept.

/// A scene, the command that solves it, and what else it is told.
pub struct Case {
    pub name: &'static str,
    pub command: &'static str,
    pub scene: &'static str,
    pub more: &'static [&'static str],
}

const CIRCLES: &str = "\
[grid]
cells = [16, 14]
[time]
steps = 8
[source]
circle = { center = [0.35, 0.4], radius = 0.2 }
[[keyframe]]
step = 8
circle = { center = [0.65, 0.5], radius = 0.2 }
[method]
iterations = 12
direct = { tolerance = 1e-12 }
admm = { density_tolerance = 1e-12 }
[output]
frames = false
";

const RELEASED: &str = "\
[grid]
cells = [14, 14]
[time]
steps = 12
[source]
circle = { center = [0.35, 0.4], radius = 0.2 }
[[obstacle]]
box = { min = [0.45, 0.0], max = [0.55, 0.3] }
[[keyframe]]
step = 7
circle = { center = [0.65, 0.5], radius = 0.2 }
[flow]
buoyancy = 1e-3
[[release]]
from = 7
[method]
iterations = 10
direct = { tolerance = 1e-12 }
[output]
frames = false
";

const WINDOWS: &str = "\
[grid]
cells = [14, 12]
[time]
steps = 26
[source]
circle = { center = [0.3, 0.4], radius = 0.2 }
[[emitter]]
from = 0
to = 20
rate = 0.05
circle = { center = [0.3, 0.4], radius = 0.15 }
[[keyframe]]
step = 5
circle = { center = [0.5, 0.4], radius = 0.25 }
[[keyframe]]
step = 22
circle = { center = [0.5, 0.7], radius = 0.25 }
[flow]
buoyancy = 1e-3
[method]
iterations = 4
window = 9
stride = 5
[output]
frames = false
";

const FLUIDS: &str = "\
[grid]
cells = [16, 14]
[time]
steps = 8
[source]
circle = { center = [0.35, 0.4], radius = 0.2 }
[[keyframe]]
step = 8
circle = { center = [0.65, 0.5], radius = 0.2 }
[method]
name = \"stable_fluids\"
iterations = 30
stable_fluids = { tolerance = 1e-12 }
[output]
frames = false
";

/// All of them.
pub const CASES: [Case; 7] = [
    Case {
        name: "direct",
        command: "solve",
        scene: CIRCLES,
        more: &[],
    },
    Case {
        name: "admm",
        command: "solve",
        scene: CIRCLES,
        more: &["--method", "admm"],
    },
    Case {
        name: "lbfgs",
        command: "solve",
        scene: CIRCLES,
        more: &["--method", "lbfgs", "--precision", "f64"],
    },
    Case {
        name: "fluids",
        command: "solve",
        scene: FLUIDS,
        more: &[],
    },
    Case {
        name: "released",
        command: "solve",
        scene: RELEASED,
        more: &[],
    },
    Case {
        name: "windows",
        command: "solve",
        scene: WINDOWS,
        more: &[],
    },
    Case {
        name: "flow",
        command: "simulate",
        scene: WINDOWS,
        more: &[],
    },
];

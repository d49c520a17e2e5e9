//! Parts of the source, and why what is checked there holds.

/// A part of the source, and why what is checked there holds.
pub struct Part {
    pub name: &'static str,
    pub files: &'static [&'static str],
    pub holds: &'static str,
}

impl Part {
    /// Whether a file belongs to it.
    pub fn has(&self, file: &str) -> bool {
        self.files.iter().any(|start| file.starts_with(start))
    }
}

pub const PARTS: [Part; 11] = [
    Part {
        name: "interface",
        files: &["problem/", "solver/"],
        holds: "steps, keyframes, axes and lengths of arrays are compared with the problem, and refused, before they come here",
    },
    Part {
        name: "methods",
        files: &["method/", "objective/", "optimise/"],
        holds: "fields, sums and scratch are cut by the plan for the cells, steps, threads and pairs that are used here; there is always a finest level",
    },
    Part {
        name: "Navier-Stokes problem",
        files: &["nso/"],
        holds: "the plan cuts states, lines and rings by the sizes from which places in them are counted; neighbours are folded into the grid or left out",
    },
    Part {
        name: "transport",
        files: &["transport/"],
        holds: "states, terms and halos are cut by the grid's cells and rows; places followed backwards are folded or clamped into the grid before they are indices",
    },
    Part {
        name: "projection",
        files: &["poisson/"],
        holds: "levels, batches and panels are cut by the sizes from which places in them are counted; the halves of a row, even and odd, together have its length",
    },
    Part {
        name: "tracking and tomography",
        files: &["deblur/", "flow/", "tomography/", "track/", "walk/"],
        holds: "frames, grids of a pyramid and pictures are cut by the plan for the cells, levels and cameras that are used here; patches are of a fixed size",
    },
    Part {
        name: "operator and Stable Fluids",
        files: &["operator/", "stable_fluids/", "reversal.rs"],
        holds: "fields, states and tapes are cut by the plan for the cells, axes, steps and slots that are used here; what a program gives is checked before",
    },
    Part {
        name: "elastic bodies",
        files: &["condense/"],
        holds: "vertices, simplices and rows are numbered by the topology, which is made of a mesh whose numbers were checked; buffers are cut by the plan for them",
    },
    Part {
        name: "rows",
        files: &["field/", "force/", "grid/", "operators/"],
        holds: "rows and blocks of rows are counted from the grid by which the fields were cut; a problem whose grid has an axis without cells is refused",
    },
    Part {
        name: "parts and lanes",
        files: &["exec/", "memory/", "simd/"],
        holds: "the index of a part is below their count, the pool is as large as the plan that is carved from it, a vector is loaded where a whole one is left",
    },
    Part {
        name: "below",
        files: &["core/src/", "heapless-"],
        holds: "the language's own text of values, in buffers that it makes for it; steps of loops are never 0; no list is longer than a count that is refused above its capacity",
    },
];

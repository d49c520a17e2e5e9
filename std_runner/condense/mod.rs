//! `thurible condense`: coordinate condensation, and what it is measured by, on test problems and on meshes from files.
//!
//! | file | what it holds |
//! |---|---|
//! | `presets` | the test problems, as scenes |
//! | `raw`, `body`, `scene` | the scene file |
//! | `parsed`, `msh`, `files` | meshes from .obj and .msh |
//! | `cases` | the values of its sweeps, and by which methods and bases each is solved |
//! | `planned`, `job`, `written` | memory, one run, its folder |
//! | `canvas`, `draw`, `page` | pictures and the page |
//! | `door` | everything in its order |

mod body;
mod canvas;
mod cases;
mod door;
mod draw;
mod files;
mod job;
mod msh;
mod page;
mod parsed;
mod planned;
mod presets;
mod raw;
mod scene;
mod written;

pub(crate) use cases::document;
pub(crate) use door::{Request, plan, run};
pub(crate) use presets::{preset, preset_names, presets};

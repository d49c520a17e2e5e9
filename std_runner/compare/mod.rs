//! One scene by several methods: their runs, the figures of each, and the page.

mod columns;
mod comparison;
mod figures;
mod page;
pub(crate) mod publish;
mod staggered;
mod words;

pub use figures::{Figures, NEAR};

pub(crate) use columns::{COLUMNS, MEMORY, cells, in_brief, status};
pub(crate) use comparison::{Comparison, Lineup, Lost, scene_by, scenes_by_method};
pub(crate) use page::{by_seconds, last_keyframe, measured, page, said, strip, summary};
pub(crate) use words::listed;

//! One scene by several methods: their runs, the figures of each, and the page.

mod comparison;
mod figures;
mod page;
pub(crate) mod publish;

pub use figures::{Figures, NEAR};

pub(crate) use comparison::{Comparison, scenes_by_method};
pub(crate) use page::{
    COLUMNS, MEMORY, by_seconds, cells, in_brief, last_keyframe, listed, measured, page, strip, summary,
};

//! Coordinate condensation: an elastic body whose energy is minimised step by step.

mod any;
mod body;
mod calls;
mod config;
mod lists;
mod read;
mod step;

pub use body::ThuribleCondenser;
pub use calls::{
    thurible_condense_close, thurible_condense_explain, thurible_condense_init, thurible_condense_message,
    thurible_condense_plan, thurible_condense_scratch,
};
pub use config::{
    THURIBLE_MOST_ELEMENTS, THURIBLE_MOST_SPRINGS, THURIBLE_MOST_VERTICES, ThuribleCondenseBasis,
    ThuribleCondenseBlock, ThuribleCondenseConfig, ThuribleCondenseMethod, ThuribleCondenseOrder,
    ThuribleSpring, thurible_condense_defaults,
};
pub use read::{ThuribleCondensePart, thurible_condense_read};
pub use step::{
    ThuribleCondensed, ThuribleIteration, thurible_condense_set_velocity, thurible_condense_shift,
    thurible_condense_step,
};

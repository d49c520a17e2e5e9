//! A simulation that can be differentiated: densities and velocities by where they begin and by what pushes them, and the exact adjoint of that.

mod body;
mod calls;
mod config;
mod read;
mod run;

pub use body::{AnySimulator, ThuribleOperator};
pub use calls::{
    thurible_operator_close, thurible_operator_explain, thurible_operator_init, thurible_operator_message,
    thurible_operator_plan, thurible_operator_set_emitter, thurible_operator_set_solids,
};
pub use config::{ThuribleOperatorConfig, ThuribleSimulator, thurible_operator_defaults};
pub use read::{
    ThuribleEmitterGradient, thurible_operator_buoyancy, thurible_operator_bytes, thurible_operator_emitter,
    thurible_operator_gradient,
};
pub use run::{ThuribleRan, thurible_operator_simulate, thurible_operator_vjp};

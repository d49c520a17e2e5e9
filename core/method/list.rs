//! The registry: every method by one entry.

/// Hands all methods to a macro. An entry has a sentence about the method, its name, the word that people choose it by, the field and the
/// type of its choices in [`Params`](crate::Params), and the type that solves by it, both from this folder.
macro_rules! for_each_method {
    ($apply:ident) => {
        $apply! {
            /// Force elimination and quasi-Newton: no splitting.
            Direct "direct", direct: direct::params::DirectParams, direct::Direct;
            /// The paper's: ADMM over an advection and a Navier-Stokes problem.
            Admm "admm", admm: admm::params::AdmmParams, admm::Admm;
            /// A baseline: L-BFGS over the forces by the adjoint of a simulation.
            Lbfgs "lbfgs", lbfgs: lbfgs::params::LbfgsParams, lbfgs::Lbfgs;
            /// A baseline: smoke driven to the next keyframe while it is simulated.
            Pd "pd", pd: simulate::params::PdParams, simulate::Simulation;
            /// No control: the flow alone. Keyframes may be missing.
            Simulate "simulate", simulation: simulate::params::SimulationParams, simulate::Simulation;
            /// L-BFGS over amplitudes, middles and radii of templates, of which the force is made.
            Templates "templates", templates: templates::params::TemplatesParams, templates::Templates;
            /// No control either: a simulation that is guided by a given flow (Gregson 2015).
            Guide "guide", guide: simulate::guide::GuideParams, simulate::Simulation;
        }
    };
}

pub(super) use for_each_method;

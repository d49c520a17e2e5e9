//! What a caller chooses for ADMM.

use crate::checkpoint::Mix;
use crate::method::choices::{Kind, Numbers, choices};
use crate::nso::colours::Colours;
use crate::nso::{Norm, NsoParams, NsoSolver, SmootherMemory};
use crate::progress::MAX_CYCLES;
use crate::words::Named;

/// What a caller chooses for ADMM.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AdmmParams {
    /// Penalty K, in the scene's units.
    pub penalty: f64,
    /// Relaxation beta.
    pub relaxation: f64,
    /// Fixed-point iterations of AO in each outer iteration.
    pub ao_iterations: usize,
    /// Momentum between the iterations of one AO, at least 0 and below 1; 0 is the paper's AO.
    pub ao_momentum: f64,
    /// Stop when rho changes less than this times max rho_0 in an outer iteration.
    pub density_tolerance: f64,
    /// Whether the flow begins as that of the same scene on a grid of half as many cells an axis, solved first.
    pub nested: bool,
    /// The Navier-Stokes problem.
    pub nso: NsoParams,
    /// How the smoother uses memory; by default the fastest way within the ceiling and the paper's bound. Changes no result.
    pub memory: Option<SmootherMemory>,
}

impl Default for AdmmParams {
    fn default() -> Self {
        Self {
            penalty: 1e3,
            relaxation: 1.0,
            ao_iterations: 2,
            ao_momentum: 0.0,
            density_tolerance: 0.01,
            nested: true,
            nso: NsoParams::default(),
            memory: None,
        }
    }
}

choices!(AdmmParams, "admm" {
    penalty: penalty, Kind::Number(Numbers::Positive),
        "how strongly the two halves of the method are tied together";
    relaxation: relaxation, Kind::Number(Numbers::Within(2.0)),
        "step of the multipliers, in parts of the penalty";
    ao_iterations: ao_iterations, Kind::Count(1000),
        "fixed-point iterations for the densities in each iteration";
    ao_momentum: ao_momentum, Kind::Number(Numbers::Fraction),
        "of the heavy ball, between these iterations; 0 is the paper's";
    nested: nested, Kind::Flag,
        "begin with the flow of the same scene at half the resolution";
    nso: nso.solver, Kind::Word(NsoSolver::WORDS),
        "how Navier-Stokes problems are solved; newton_cg needs more memory";
    nso_tolerance: nso.tolerance, Kind::Number(Numbers::Below(1.0)),
        "residual at which a Navier-Stokes problem is solved";
    nso_cycles: nso.cycles, Kind::Count(MAX_CYCLES - 1),
        "V-cycles or Newton steps of a Navier-Stokes problem at most";
    nso_norm: nso.norm, Kind::Word(Norm::WORDS),
        "norm of that residual; plain is the paper's, stricter on divergence";
    density_tolerance: density_tolerance, Kind::Number(Numbers::Below(1.0)),
        "converged when the density changes by less than this part of its maximum";
    smoother_colours: nso.colours, Kind::Word(Colours::WORDS),
        "in which order the multigrid visits cells; 2^d is the paper's";
});

impl AdmmParams {
    /// Mixes in every number that results follow from, for the fingerprint of a checkpoint.
    pub fn mix(&self, mix: &mut Mix) {
        // Every field by name: a new one does not compile until it is mixed in.
        let Self {
            penalty,
            relaxation,
            ao_iterations,
            ao_momentum,
            density_tolerance,
            nested,
            nso,
            memory: _,
        } = *self;
        let NsoParams {
            solver,
            tolerance,
            cycles,
            colours,
            norm,
        } = nso;
        let numbers = [penalty, relaxation, ao_momentum, density_tolerance, tolerance];
        numbers.into_iter().for_each(|number| mix.real(number));
        let words = [
            ao_iterations as u64,
            u64::from(nested),
            solver as u64,
            cycles as u64,
            colours as u64,
            norm as u64,
        ];
        words.into_iter().for_each(|word| mix.word(word));
    }
}

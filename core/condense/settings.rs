//! What is chosen.

use super::error::CondenseError;
use crate::words::named;

/// How far a block moves in a pass.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Update {
    /// Coordinate condensation: -(H_ii - S_i)^-1 g~_i.
    #[default]
    Cc,
    /// -(H^-1 g)_i.
    Newton,
    /// -H_ii^-1 g_i: vertex block descent.
    Plain,
    /// -(H_ii + U_i^T H_CC U_i)^-1 (g_i + U_i^T g_C).
    Jgs2,
    /// The same by g_i alone.
    Jgs2Local,
    /// -(W^T H W)^-1 W^T g, with W = (I at i, U_i elsewhere).
    Projected,
    /// -(H0^-1 g)_i.
    Chord,
    /// -(R H0^-1 R^T g)_i.
    Warped,
}

named!(Update {
    Cc = "cc",
    Newton = "newton",
    Plain = "plain",
    Jgs2 = "jgs2",
    Jgs2Local = "jgs2_local",
    Projected = "projected",
    Chord = "chord",
    Warped = "warped",
});

impl Update {
    /// Whether anything is built once and used for many passes.
    #[must_use]
    pub fn is_built(self) -> bool {
        !matches!(self, Self::Newton | Self::Plain)
    }

    /// Whether its direction is found by today's Hessian.
    pub(super) fn reads_hessian(self) -> bool {
        !matches!(self, Self::Chord | Self::Warped)
    }

    /// Whether it keeps a basis, which takes most of the memory.
    #[must_use]
    pub fn keeps_basis(self) -> bool {
        matches!(self, Self::Cc | Self::Jgs2 | Self::Jgs2Local | Self::Projected)
    }
}

/// When a basis is built, and whether it turns with the body.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Basis {
    /// Once, at rest.
    #[default]
    Fixed,
    /// Every few steps, from the state before.
    Rebuilt,
    /// Once, and turned.
    Corotated,
    /// Every few steps, and turned.
    CorotatedRebuilt,
    /// When four iterations have not halved the residual.
    Adaptive,
    /// The same, and turned.
    CorotatedAdaptive,
}

named!(Basis {
    Fixed = "fixed",
    Rebuilt = "rebuilt",
    Corotated = "corotated",
    CorotatedRebuilt = "corotated_rebuilt",
    Adaptive = "adaptive",
    CorotatedAdaptive = "corotated_adaptive",
});

impl Basis {
    /// Whether its rows turn with the body.
    #[must_use]
    pub fn turns(self) -> bool {
        matches!(
            self,
            Self::Corotated | Self::CorotatedRebuilt | Self::CorotatedAdaptive
        )
    }

    /// Whether it is built every few steps.
    #[must_use]
    pub fn is_rebuilt(self) -> bool {
        matches!(self, Self::Rebuilt | Self::CorotatedRebuilt)
    }

    /// Whether it is built where iterations gain too little.
    #[must_use]
    pub fn is_adaptive(self) -> bool {
        matches!(self, Self::Adaptive | Self::CorotatedAdaptive)
    }
}

/// What a block is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Block {
    /// All components of a vertex.
    #[default]
    Vertex,
    /// One component.
    Scalar,
}

named!(Block { Vertex = "vertex", Scalar = "scalar" });

/// Who moves when.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Order {
    /// All at once.
    #[default]
    Jacobi,
    /// Colour by colour.
    Colours,
}

named!(Order { Jacobi = "jacobi", Colours = "colours" });

/// The choices of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CondenseParams {
    /// How far a block moves.
    pub method: Update,
    /// When the basis is built.
    pub basis: Basis,
    /// Steps from one build to the next, of rebuilt bases.
    pub rebuild: usize,
    /// What a block is.
    pub block: Block,
    /// Who moves when.
    pub order: Order,
    /// Edges within which a basis is kept; `None` keeps all.
    pub radius: Option<usize>,
    /// The residual below which a step is solved.
    pub tolerance: f64,
    /// Iterations of a step at most.
    pub cap: usize,
    /// Whether steps along the direction are searched for.
    pub search: bool,
    /// Standard deviation of what is added to a basis, in a study of bad ones.
    pub noise: f64,
    /// Which random numbers.
    pub seed: u64,
    /// Length of an implicit step; `None` is quasi-static.
    pub dt: Option<f64>,
    /// Threads that memory is planned for.
    pub threads: usize,
}

impl Default for CondenseParams {
    fn default() -> Self {
        Self {
            method: Update::Cc,
            basis: Basis::Fixed,
            rebuild: 5,
            block: Block::Vertex,
            order: Order::Jacobi,
            radius: None,
            tolerance: 1e-6,
            cap: 500,
            search: true,
            noise: 0.0,
            seed: 1,
            dt: None,
            threads: 1,
        }
    }
}

/// Most iterations, steps and threads.
const MOST: usize = 100_000_000;

impl CondenseParams {
    /// Whether rotations are needed.
    pub(super) fn turns(&self) -> bool {
        self.method == Update::Warped || (self.method.is_built() && self.basis.turns())
    }

    /// Numbers of a block.
    pub(super) fn size(&self, dims: usize) -> usize {
        if self.block == Block::Vertex { dims } else { 1 }
    }

    /// Whether the factor of H or H0 is kept.
    pub(super) fn factors(&self) -> bool {
        self.method != Update::Plain
    }

    /// Checks every choice, for a mesh of `dims` dimensions.
    ///
    /// # Errors
    /// [`CondenseError`] names the first that is wrong.
    pub fn check(&self, dims: usize) -> Result<(), CondenseError> {
        let word = crate::words::Named::name;
        if !self.method.is_built() && self.basis != Basis::Fixed {
            return Err(CondenseError::NoBasis {
                method: word(self.method),
            });
        }
        if self.method == Update::Chord && self.basis.turns() {
            return Err(CondenseError::NoTurn {
                with: word(self.method),
            });
        }
        let scalar = self.block == Block::Scalar && dims > 1;
        if scalar && self.method.keeps_basis() && self.basis.turns() {
            return Err(CondenseError::NoTurn { with: "scalar" });
        }
        let on_rod = dims == 1 && matches!(self.method, Update::Jgs2 | Update::Jgs2Local);
        if self.order == Order::Colours && self.method != Update::Plain && !on_rod {
            return Err(CondenseError::Colours {
                method: word(self.method),
            });
        }
        if !self.method.keeps_basis() && (self.radius.is_some() || self.noise != 0.0) {
            return Err(CondenseError::NoBasis {
                method: word(self.method),
            });
        }
        let range = |count: usize| (1..=MOST).contains(&count);
        let rules = [
            (
                "tolerance",
                self.tolerance > 0.0 && self.tolerance.is_finite(),
                "above 0",
            ),
            ("cap", range(self.cap), "from 1 to 100000000"),
            ("rebuild", range(self.rebuild), "from 1 to 100000000"),
            ("threads", (1..=4096).contains(&self.threads), "from 1 to 4096"),
            ("noise", self.noise >= 0.0 && self.noise.is_finite(), "at least 0"),
            (
                "dt",
                self.dt.is_none_or(|dt| dt > 0.0 && dt.is_finite()),
                "above 0",
            ),
        ];
        let wrong = rules.into_iter().find(|(_, holds, _)| !holds);
        wrong.map_or(Ok(()), |(name, _, allowed)| {
            Err(CondenseError::Setting { name, allowed })
        })
    }
}

//! What is refused.

use core::fmt;

/// Why there is nothing to condense.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum CondenseError {
    /// Vertices, corners and what is held do not have the lengths that belong together.
    Lengths,
    /// A vertex is not at a finite place.
    Position {
        /// Which.
        vertex: usize,
    },
    /// A simplex names a vertex that there is not.
    Corner {
        /// Which.
        element: usize,
    },
    /// A simplex has no volume, or is inverted.
    Inverted {
        /// Which.
        element: usize,
    },
    /// A spring has no two ends, or no stiffness above 0 or no rest length.
    Spring {
        /// Which.
        spring: usize,
    },
    /// No vertex is free.
    AllHeld,
    /// No vertex is held, which a quasi-static problem needs.
    NoneHeld,
    /// A part of the mesh is joined to no held vertex, which a quasi-static problem needs.
    Unheld {
        /// The first of its vertices.
        vertex: usize,
    },
    /// A free vertex belongs to no simplex: nothing gives it mass.
    Loose {
        /// Which.
        vertex: usize,
    },
    /// A basis for a method that has none.
    NoBasis {
        /// The method's word.
        method: &'static str,
    },
    /// A co-rotated basis where it cannot be.
    NoTurn {
        /// The word of the method, or of the blocks.
        with: &'static str,
    },
    /// Colours for a method that moves all at once.
    Colours {
        /// The method's word.
        method: &'static str,
    },
    /// A setting is out of its range.
    Setting {
        /// Which.
        name: &'static str,
        /// What is allowed.
        allowed: &'static str,
    },
    /// What is given for a step or a state has another number of values, or one that is not finite.
    Values,
    /// The bytes that it takes do not fit `usize`, or its counts u32.
    TooLarge,
    /// The block has too few bytes, or does not begin on a multiple of 64.
    Memory {
        /// Bytes that it takes.
        needed: usize,
    },
}

impl fmt::Display for CondenseError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Lengths => f.write_str(
                "positions, elements and held vertices do not belong together: an element has one corner more than a position has numbers",
            ),
            Self::Position { vertex } => write!(f, "vertex {vertex} is at no finite place"),
            Self::Corner { element } => write!(f, "element {element} names a vertex that there is not"),
            Self::Inverted { element } => write!(f, "element {element} is inverted or has no area"),
            Self::Spring { spring } => write!(
                f,
                "spring {spring} must have two different ends, a stiffness above 0 and a rest length of at least 0"
            ),
            Self::AllHeld => f.write_str("no vertex is free"),
            Self::NoneHeld => f.write_str("a quasi-static problem must hold a vertex"),
            Self::Unheld { vertex } => write!(
                f,
                "a quasi-static problem must hold every part, and that of vertex {vertex} is joined to no held vertex"
            ),
            Self::Loose { vertex } => write!(f, "vertex {vertex} is free and belongs to no element"),
            Self::NoBasis { method } => write!(f, "method \"{method}\" has no basis"),
            Self::NoTurn { with } => write!(f, "\"{with}\" cannot be co-rotated"),
            Self::Colours { method } => write!(
                f,
                "order \"colours\" is for method \"plain\" (and jgs2 on rods), and method \"{method}\" presumes that all move at once"
            ),
            Self::Setting { name, allowed } => write!(f, "`{name}` must be {allowed}"),
            Self::Values => f.write_str("it has another number of values, or one that is not finite"),
            Self::TooLarge => f.write_str("its bytes cannot be counted"),
            Self::Memory { needed } => write!(f, "it takes {needed} bytes from a multiple of 64 on"),
        }
    }
}

impl core::error::Error for CondenseError {}

//! What a reconstruction refuses.

use core::fmt;

/// What is wrong with the pixels of a camera.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// Another number than the camera has.
    Count {
        /// Pixels that came.
        found: usize,
        /// Pixels that it has.
        expected: usize,
    },
    /// NaN or infinite.
    NotFinite {
        /// Which.
        pixel: usize,
    },
}

/// Why there is no reconstruction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TomographyError {
    /// An axis has fewer than two cells, or more than can be counted.
    Cells {
        /// The axis, x being 0.
        axis: usize,
    },
    /// There is no camera.
    NoCamera,
    /// A camera sees nothing of the box.
    Blind {
        /// Which, from 0.
        camera: usize,
    },
    /// A camera's numbers are not finite, or it has no pixels.
    Camera {
        /// Which, from 0.
        camera: usize,
    },
    /// A novel view sees nothing of the box (`blind`), or its numbers are not finite, or it has no pixels.
    Novel {
        /// Which, from 0.
        view: usize,
        /// Whether it sees nothing.
        blind: bool,
    },
    /// A prior on pictures without a novel view.
    NoNovel,
    /// The pixels of a camera will not do.
    Pixels {
        /// Which camera, from 0.
        camera: usize,
        /// What is wrong.
        fault: Fault,
    },
    /// A setting is out of its range.
    Setting {
        /// Which.
        name: &'static str,
        /// What is allowed.
        allowed: &'static str,
    },
    /// All pictures are dark.
    Dark,
    /// The bytes that it takes do not fit `usize`.
    TooLarge,
    /// The block has too few bytes, or does not begin on a multiple of 64.
    Memory {
        /// Bytes that it takes.
        needed: usize,
    },
}

impl fmt::Display for TomographyError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Cells { axis } => write!(f, "axis {axis} must have at least two cells"),
            Self::NoCamera => f.write_str("there must be at least one camera"),
            Self::Blind { camera } => write!(f, "camera {camera} sees nothing of the box"),
            Self::Camera { camera } => {
                write!(f, "camera {camera} has no pixels, or a number that is not finite")
            }
            Self::Novel { view, blind: true } => write!(f, "novel view {view} sees nothing of the box"),
            Self::Novel { view, .. } => {
                write!(
                    f,
                    "novel view {view} has no pixels, or a number that is not finite"
                )
            }
            Self::NoNovel => f.write_str("a prior on pictures needs a novel view"),
            Self::Pixels { camera, fault } => match fault {
                Fault::Count { found, expected } => {
                    write!(f, "camera {camera} has {expected} pixels, and {found} were given")
                }
                Fault::NotFinite { pixel } => {
                    write!(f, "camera {camera} has a pixel ({pixel}) that is not finite")
                }
            },
            Self::Setting { name, allowed } => write!(f, "`{name}` must be {allowed}"),
            Self::Dark => f.write_str("all pictures are dark"),
            Self::TooLarge => f.write_str("its bytes cannot be counted"),
            Self::Memory { needed } => write!(f, "it takes {needed} bytes from a multiple of 64 on"),
        }
    }
}

impl core::error::Error for TomographyError {}

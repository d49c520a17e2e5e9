//! What a restoration refuses.

use core::fmt;

/// Why there is no restoration.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DeblurError {
    /// An image without pixels, or of other than one to three channels.
    Size,
    /// Kernels are not squares of odd sides, or the border is not their radius.
    Kernel,
    /// A kernel is larger than the image.
    KernelTooLarge,
    /// A kernel does not sum to 1, or holds a number that is not finite.
    KernelSum,
    /// A pixel names a kernel that there is not, or not every pixel names one.
    Which,
    /// A setting is out of its range.
    Setting {
        /// Which.
        name: &'static str,
        /// What is allowed.
        allowed: &'static str,
    },
    /// The image has another number of values, or one that is not finite.
    Image {
        /// The first value that is not finite, if their number is right.
        at: Option<usize>,
    },
    /// All pixels are saturated.
    Saturated,
    /// The bytes that it takes do not fit `usize`.
    TooLarge,
    /// The block has too few bytes, or does not begin on a multiple of 64.
    Memory {
        /// Bytes that it takes.
        needed: usize,
    },
}

impl fmt::Display for DeblurError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Size => f.write_str("an image has pixels, and one to three channels"),
            Self::Kernel => f.write_str("kernels are squares of an odd side"),
            Self::KernelTooLarge => f.write_str("the kernel is larger than the image"),
            Self::KernelSum => f.write_str("a kernel must sum to 1"),
            Self::Which => f.write_str("every pixel must name a kernel that there is"),
            Self::Setting { name, allowed } => write!(f, "`{name}` must be {allowed}"),
            Self::Image { at: None } => f.write_str("the image has another number of values"),
            Self::Image { at: Some(at) } => write!(f, "value {at} of the image is not finite"),
            Self::Saturated => f.write_str("all pixels are saturated"),
            Self::TooLarge => f.write_str("its bytes cannot be counted"),
            Self::Memory { needed } => write!(f, "it takes {needed} bytes from a multiple of 64 on"),
        }
    }
}

impl core::error::Error for DeblurError {}

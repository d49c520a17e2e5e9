//! The sizes of an image, and of what is looked for: the image with its border.

/// An image of some channels, and the border about it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Frame {
    /// Pixels across.
    pub width: usize,
    /// Pixels down.
    pub height: usize,
    /// Planes: 1 for grey, 3 for colour.
    pub channels: usize,
    /// Pixels of the border, R.
    pub border: usize,
}

impl Frame {
    /// Pixels of a plane of the image.
    #[must_use]
    pub fn pixels(&self) -> usize {
        self.width * self.height
    }

    /// Pixels across with the border.
    #[inline(always)]
    #[must_use]
    pub fn wide(&self) -> usize {
        self.width + 2 * self.border
    }

    /// Pixels down with the border.
    #[inline(always)]
    #[must_use]
    pub fn high(&self) -> usize {
        self.height + 2 * self.border
    }

    /// Pixels of a plane with the border.
    #[inline(always)]
    #[must_use]
    pub fn unknowns(&self) -> usize {
        self.wide() * self.high()
    }

    /// Place in the image of the pixel nearest to one of the bordered plane.
    #[must_use]
    pub fn nearest(&self, place: usize) -> usize {
        let clamp = |at: usize, count: usize| at.saturating_sub(self.border).min(count.saturating_sub(1));
        let (x, y) = (place % self.wide(), place / self.wide());
        clamp(y, self.height) * self.width + clamp(x, self.width)
    }

    /// Place in the bordered plane of a pixel of the image.
    #[must_use]
    pub fn bordered(&self, pixel: usize) -> usize {
        let (x, y) = (pixel % self.width.max(1), pixel / self.width.max(1));
        (y + self.border) * self.wide() + x + self.border
    }
}

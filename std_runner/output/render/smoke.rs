//! Densities as the renderer takes them.

/// Densities as they are drawn, 1 where the source is densest. In 2D there is one cell along y, and z is up.
pub struct Smoke {
    /// Along x, y and z.
    pub(super) cells: [usize; 3],
    /// One for each cell, x fastest.
    pub(super) values: Vec<f32>,
    /// Whether it is a plane.
    pub(super) flat: bool,
}

impl Smoke {
    /// `density` of a grid of `cells`, divided by `full`.
    pub fn new(cells: &[usize], density: Vec<f32>, full: f32) -> Self {
        let scale = if full > 0.0 { 1.0 / full } else { 1.0 };
        let drawn = |value: f32| {
            if value.is_finite() {
                (value * scale).clamp(-2.0, 2.0)
            } else {
                0.0
            }
        };
        let values = density.into_iter().map(drawn).collect();
        match *cells {
            [nx, ny, nz] => Self {
                cells: [nx, ny, nz],
                values,
                flat: false,
            },
            [nx, ny] => Self {
                cells: [nx, 1, ny],
                values,
                flat: true,
            },
            _ => Self {
                cells: [values.len(), 1, 1],
                values,
                flat: true,
            },
        }
    }

    /// What `self` has more than `other`, negative where it has less.
    pub fn minus(&self, other: &Self) -> Self {
        let values = self
            .values
            .iter()
            .zip(&other.values)
            .map(|(mine, theirs)| mine - theirs)
            .collect();
        Self { values, ..*self }
    }

    /// Cells of the longest side.
    pub(super) fn longest(&self) -> f32 {
        self.cells.iter().copied().max().unwrap_or(1) as f32
    }
}

//! The grid that shapes are drawn on.

/// A box of cells: what a shape needs to know about the grid.
#[derive(Clone, Debug, PartialEq)]
pub struct Canvas {
    /// Cells along x, y (and z).
    pub cells: Vec<usize>,
    /// Per axis: does the box repeat?
    pub periodic: Vec<bool>,
    /// The longest side of the box.
    pub length: f64,
}

impl Canvas {
    /// Two or three.
    pub fn dimensions(&self) -> usize {
        self.cells.len()
    }

    /// Side of a cell, h = length / max(cells).
    pub fn cell_size(&self) -> f64 {
        let longest = self.cells.iter().copied().max().unwrap_or(1).max(1);
        self.length / longest as f64
    }

    /// Number of cells.
    pub fn cell_count(&self) -> usize {
        self.cells.iter().product()
    }

    /// Sides of the box; 0 for an axis that is not there.
    pub fn extent(&self) -> [f64; 3] {
        let mut extent = [0.0; 3];
        for (side, &cells) in extent.iter_mut().zip(&self.cells) {
            *side = cells as f64 * self.cell_size();
        }
        extent
    }

    /// Middle of the box; 0 for an axis that is not there.
    pub fn middle(&self) -> [f64; 3] {
        self.extent().map(|side| 0.5 * side)
    }

    /// Cells along x, y, z; 1 for an axis that is not there.
    pub fn cells_3d(&self) -> [usize; 3] {
        let mut counts = [1; 3];
        for (count, &cells) in counts.iter_mut().zip(&self.cells) {
            *count = cells;
        }
        counts
    }

    /// Whether `axis` is there and repeats.
    pub fn repeats(&self, axis: usize) -> bool {
        self.periodic.get(axis).copied().unwrap_or(false)
    }

    /// By how much the box is moved to itself and to its neighbours along axes that repeat.
    pub(super) fn images(&self) -> Vec<[f64; 3]> {
        let mut shifts = vec![[0.0; 3]];
        for (axis, side) in self.extent().into_iter().enumerate() {
            if self.repeats(axis) {
                for shift in shifts.clone() {
                    for direction in [-1.0, 1.0] {
                        let mut moved = shift;
                        moved[axis] += direction * side;
                        shifts.push(moved);
                    }
                }
            }
        }
        shifts
    }

    /// Beyond which sides of the box something reaches by more than a cell, by its lowest and its highest corner.
    pub(super) fn left(&self, [low, high]: [[f64; 3]; 2]) -> Option<String> {
        let (extent, cell) = (self.extent(), self.cell_size());
        let sides: Vec<String> = ["x", "y", "z"]
            .iter()
            .enumerate()
            .filter(|&(axis, _)| !self.repeats(axis))
            .filter(|&(axis, _)| low[axis] < -cell || high[axis] > extent[axis] + cell)
            .map(|(axis, name)| {
                format!(
                    "from {name} = {:.3} to {:.3} where the box ends at 0 and {:.3}",
                    low[axis], high[axis], extent[axis]
                )
            })
            .collect();
        (!sides.is_empty()).then(|| sides.join(", "))
    }

    /// The axis that points up in pictures: y in 2D, z in 3D.
    pub fn up(&self) -> usize {
        if self.dimensions() == 3 { 2 } else { 1 }
    }

    /// The size in words, "128 x 128".
    pub fn size_in_words(&self) -> String {
        in_words(&self.cells)
    }
}

/// Counts in words, "128 x 128".
pub(super) fn in_words(counts: &[usize]) -> String {
    let counts: Vec<String> = counts.iter().map(usize::to_string).collect();
    counts.join(" x ")
}

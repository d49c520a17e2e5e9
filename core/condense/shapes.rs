//! Regular meshes: a rod, a rectangle of triangles, a box of tetrahedra (condensation, section 3).

/// Cells along each axis of a rod (one), a rectangle (two) or a box (three), and its size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Regular {
    dims: usize,
    cells: [usize; 3],
    size: [f64; 3],
}

/// The orders of the axes along the way from a cube's low corner to its high one, the odd ones last.
const WAYS: [[usize; 3]; 6] = [[0, 1, 2], [1, 2, 0], [2, 0, 1], [1, 0, 2], [0, 2, 1], [2, 1, 0]];

impl Regular {
    /// A mesh of `cells` cells of a body of `size`, which are as many: one to three, each above 0.
    #[must_use]
    pub fn new(cells: &[usize], size: &[f64]) -> Option<Self> {
        let dims = cells.len();
        let right = (1..=3).contains(&dims)
            && size.len() == dims
            && cells.iter().all(|&n| n > 0 && n < 1 << 24)
            && size.iter().all(|&x| x > 0.0 && x.is_finite());
        let mut mesh = Self {
            dims,
            cells: [0; 3],
            size: [0.0; 3],
        };
        mesh.cells
            .iter_mut()
            .zip(cells)
            .for_each(|(to, from)| *to = *from);
        mesh.size.iter_mut().zip(size).for_each(|(to, from)| *to = *from);
        (right && mesh.number().is_some_and(|count| count < 1 << 27)).then_some(mesh)
    }

    fn number(&self) -> Option<usize> {
        let mut sides = self.cells.iter().take(self.dims);
        sides.try_fold(6usize, |count, n| count.checked_mul(n + 1))
    }

    /// Components of a vector.
    #[must_use]
    pub fn dims(&self) -> usize {
        self.dims
    }

    /// Vertices along each axis, 0 beyond the last.
    #[must_use]
    pub fn sides(&self) -> [usize; 3] {
        let mut sides = [0; 3];
        for (side, n) in sides.iter_mut().zip(self.cells).take(self.dims) {
            *side = n + 1;
        }
        sides
    }

    /// Vertices.
    #[must_use]
    pub fn vertices(&self) -> usize {
        self.sides().iter().take(self.dims).product()
    }

    /// Simplices.
    #[must_use]
    pub fn elements(&self) -> usize {
        self.cells.iter().take(self.dims).product::<usize>() * self.in_cell()
    }

    /// Simplices of a cell: Kuhn's are as many as there are orders of the axes.
    fn in_cell(&self) -> usize {
        [1, 1, 2, 6].get(self.dims).copied().unwrap_or(1)
    }

    /// Where vertex `vertex` is at rest.
    #[must_use]
    pub fn place(&self, vertex: usize) -> [f64; 3] {
        let (mut rest, mut place) = (vertex, [0.0; 3]);
        for ((x, n), size) in place.iter_mut().zip(self.cells).zip(self.size).take(self.dims) {
            *x = (rest % (n + 1)) as f64 / n as f64 * size;
            rest /= n + 1;
        }
        place
    }

    /// The corners of simplex `element`, one more than there are components.
    #[must_use]
    pub fn corners(&self, element: usize) -> [u32; 4] {
        let (cell, kind) = (element / self.in_cell(), element % self.in_cell());
        let mut low = [0; 3];
        let mut rest = cell;
        for (low, n) in low.iter_mut().zip(self.cells).take(self.dims) {
            *low = rest % n;
            rest /= n;
        }
        let ways: [[usize; 3]; 4] = match self.dims {
            1 => [[0, 0, 0], [1, 0, 0], [0; 3], [0; 3]],
            2 => square((low[0] + low[1]) % 2 == 0, kind),
            _ => cube(kind),
        };
        ways.map(|step| self.number_of([low[0] + step[0], low[1] + step[1], low[2] + step[2]]))
    }

    fn number_of(&self, at: [usize; 3]) -> u32 {
        let [nx, ny, _] = self.sides();
        let number = match self.dims {
            1 => at[0],
            2 => at[1] * nx + at[0],
            _ => (at[2] * ny + at[1]) * nx + at[0],
        };
        number as u32
    }
}

/// Triangle `kind` of a square with corners a, b, c, d counterclockwise from its low one: abc and acd where it is even, else abd and bcd.
fn square(even: bool, kind: usize) -> [[usize; 3]; 4] {
    let [a, b, c, d] = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]];
    match (even, kind) {
        (true, 0) => [a, b, c, a],
        (true, _) => [a, c, d, a],
        (false, 0) => [a, b, d, a],
        (false, _) => [b, c, d, a],
    }
}

/// Tetrahedron `kind` of a cube: the corners on the way from its low to its high one, two exchanged where the order of the axes is odd.
fn cube(kind: usize) -> [[usize; 3]; 4] {
    let way = WAYS.get(kind).copied().unwrap_or_default();
    let mut corners = [[0; 3]; 4];
    for (place, axis) in way.into_iter().enumerate() {
        for corner in corners.iter_mut().skip(place + 1) {
            corner[axis] = 1;
        }
    }
    if kind >= 3 {
        corners.swap(1, 2);
    }
    corners
}

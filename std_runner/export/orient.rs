//! Which axis is up in a file: another order of the axes while writing, never a rotation that a reader might ignore.

/// The axis that is up.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Up {
    /// As in Houdini, Maya and Unity.
    Y,
    /// As in Blender and Unreal.
    Z,
}

/// How the axes of a file come from those of a result, whose last one is up.
#[derive(Clone, Copy, Debug)]
pub(super) struct Orientation {
    /// The result's axis, by axis of the file; a plane has no third one.
    pub from: [usize; 3],
    /// Whether the file's axis goes the other way.
    pub turned: [bool; 3],
}

impl Orientation {
    /// That of a result with so many axes.
    pub fn new(axes: usize, up: Up) -> Self {
        let (from, turned) = match (axes, up) {
            // (x, z, -y): a rotation about x, as programs with y up bring in files with z up.
            (3, Up::Y) => ([0, 2, 1], [false, false, true]),
            // A plane stands upright.
            (2, Up::Z) => ([0, 2, 1], [false; 3]),
            _ => ([0, 1, 2], [false; 3]),
        };
        Self { from, turned }
    }

    /// The file's places of a field of `counts` values along the result's axes.
    pub fn lattice(&self, counts: [usize; 3]) -> Lattice {
        let strides = [1, counts[0], counts[0] * counts[1]];
        Lattice {
            size: self.from.map(|axis| counts[axis]),
            stride: self.from.map(|axis| strides[axis]),
            turned: self.turned,
        }
    }

    /// The low corner of the box in the file, whose sides are `sides` along the result's axes.
    pub fn corner(&self, sides: [f64; 3]) -> [f64; 3] {
        core::array::from_fn(|axis| {
            if self.turned[axis] {
                -sides[self.from[axis]]
            } else {
                0.0
            }
        })
    }
}

/// Where the values of a field are, by their place in a file.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lattice {
    /// Values along the file's axes.
    pub size: [usize; 3],
    stride: [usize; 3],
    turned: [bool; 3],
}

impl Lattice {
    /// The place in the field of the value at `at`, if there is one.
    pub fn place(&self, at: [usize; 3]) -> Option<usize> {
        let mut place = 0;
        for axis in 0..3 {
            let (index, size) = (at[axis], self.size[axis]);
            if index >= size {
                return None;
            }
            let index = if self.turned[axis] {
                size - 1 - index
            } else {
                index
            };
            place += index * self.stride[axis];
        }
        Some(place)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn y_up_is_a_rotation() {
        let lattice = Orientation::new(3, Up::Y).lattice([2, 3, 4]);
        assert_eq!(lattice.size, [2, 4, 3]);
        // The result's (1, 0, 3) is the file's (1, 3, 2): y counts from the other end.
        assert_eq!(lattice.place([1, 3, 2]), Some(1 + 3 * 6));
        assert_eq!(lattice.place([0, 0, 0]), Some(2 * 2));
        assert_eq!(lattice.place([0, 4, 0]), None);
    }

    #[test]
    fn a_plane_stands_upright_where_z_is_up() {
        let lattice = Orientation::new(2, Up::Z).lattice([5, 7, 1]);
        assert_eq!(lattice.size, [5, 1, 7]);
        assert_eq!(lattice.place([2, 0, 6]), Some(2 + 6 * 5));
        assert_eq!(Orientation::new(2, Up::Y).lattice([5, 7, 1]).size, [5, 7, 1]);
    }
}

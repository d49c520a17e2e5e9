//! What a solver shows of itself: one field of one step at a time.

use thurible_core::Output;

/// The number type of a result.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Precision {
    /// 32 bits.
    F32,
    /// 64 bits.
    F64,
}

/// The values of one field, in the precision of the solve, x fastest.
#[derive(Clone, Debug, PartialEq)]
pub enum Samples {
    /// 32 bits each.
    F32(Vec<f32>),
    /// 64 bits each.
    F64(Vec<f64>),
}

impl Samples {
    /// None yet, ready for `precision`.
    pub fn new(precision: Precision) -> Self {
        match precision {
            Precision::F32 => Self::F32(Vec::new()),
            Precision::F64 => Self::F64(Vec::new()),
        }
    }

    /// Their precision.
    pub fn precision(&self) -> Precision {
        match self {
            Self::F32(_) => Precision::F32,
            Self::F64(_) => Precision::F64,
        }
    }

    /// So many zeros, in the precision that it has.
    pub fn clear(&mut self, count: usize) {
        match self {
            Self::F32(values) => {
                values.clear();
                values.resize(count, 0.0);
            }
            Self::F64(values) => {
                values.clear();
                values.resize(count, 0.0);
            }
        }
    }

    /// How many.
    pub fn len(&self) -> usize {
        match self {
            Self::F32(values) => values.len(),
            Self::F64(values) => values.len(),
        }
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// A number that [`Samples`] can hold.
pub trait Sample: Copy {
    /// Its precision.
    const PRECISION: Precision;
    /// The list inside `samples`, which becomes an empty list of this type if it was one of the other.
    fn list(samples: &mut Samples) -> &mut Vec<Self>;
}

macro_rules! sample {
    ($number:ty, $variant:ident) => {
        impl Sample for $number {
            const PRECISION: Precision = Precision::$variant;

            fn list(samples: &mut Samples) -> &mut Vec<Self> {
                loop {
                    match samples {
                        Samples::$variant(values) => return values,
                        _ => *samples = Samples::$variant(Vec::new()),
                    }
                }
            }
        }
    };
}

sample!(f32, F32);
sample!(f64, F64);

/// An array of a result beside its outputs: what the scene gave for the steps.
#[derive(Clone, Debug, PartialEq)]
pub struct Given {
    /// Its name.
    pub name: &'static str,
    /// What it holds.
    pub values: GivenValues,
}

/// What an array holds.
#[derive(Clone, Debug, PartialEq)]
pub enum GivenValues {
    /// One field of cells.
    Cells,
    /// So many fields of cells.
    Fields(usize),
    /// So many fields of the faces across an axis.
    Faces(usize, usize),
    /// Numbers.
    Numbers(Vec<f64>),
}

/// A solved (or stopped) trajectory.
///
/// What it gives is a list of [`Output`]s, as its method names them; whoever writes them goes through the list. Each of the field
/// functions replaces what `out` holds; [`Sample::list`] gives the list to fill. A component on faces has one face more than cells
/// along its own axis if that axis is a wall.
pub trait Frames {
    /// Cells along x, y (and z).
    fn cells(&self) -> &[usize];
    /// Per axis: does the box repeat?
    fn periodic(&self) -> &[bool];
    /// Time steps N.
    fn steps(&self) -> usize;
    /// The number type of all fields.
    fn precision(&self) -> Precision;
    /// The steps of the keyframes, ascending.
    fn keyframe_steps(&self) -> &[usize];
    /// The target of a keyframe, after any rescaling of its mass.
    fn keyframe(&self, index: usize, out: &mut Samples);
    /// All outputs.
    fn outputs(&self) -> &[Output];
    /// Component `axis` of a step of an output.
    fn read(&self, output: &Output, step: usize, axis: usize, out: &mut Samples);

    /// Arrays beside the outputs and the keyframes.
    fn given(&self) -> Vec<Given> {
        Vec::new()
    }

    /// Field `index` of the array `name` of those.
    fn given_field(&mut self, name: &str, index: usize, out: &mut Samples) {
        let _ = (name, index, out);
    }
}

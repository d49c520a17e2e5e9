//! Cameras as C gives them, and as the core takes them.

use crate::config::{ConfigError, ListNames, entries};
use thurible_core::tomography::{Camera, Lens};

/// Cameras at most, and novel views at most.
pub const THURIBLE_MOST_CAMERAS: usize = 64;

/// How a camera sees.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ThuribleLens {
    /// Parallel rays: u = across . x + at[0], v = down . x + at[1].
    Orthographic = 0,
    /// Rays through an eye: u = across . (x - eye) / Z + at[0] with Z = forward . (x - eye), v alike.
    Pinhole = 1,
}

/// A camera. Places x are in cells, from the lower corner of the box; pixel i of a row has its middle at u = i + 1/2, row 0 is the first of the
/// picture. `report.json` of `thurible tomography` has cameras in these numbers. In 2D z, v and `down` are ignored, and pictures are rows.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct ThuribleCamera {
    /// A `ThuribleLens`.
    pub lens: u32,
    /// For later versions; must be 0.
    pub reserved: u32,
    /// Pixels across and down; 1 down in 2D.
    pub pixels: [usize; 2],
    /// What u rises along: parallel, a unit vector over the cells that a pixel is wide; through an eye, one times the focal length in pixels.
    pub across: [f64; 3],
    /// The same for v.
    pub down: [f64; 3],
    /// The way of the rays, or straight ahead: of length 1.
    pub forward: [f64; 3],
    /// u and v of the origin, or of what lies straight ahead.
    pub at: [f64; 2],
    /// The eye, of a pinhole.
    pub eye: [f64; 3],
    /// Cells that a pixel is wide, of parallel rays.
    pub pitch: f64,
}

impl ThuribleCamera {
    /// What the core calls it.
    ///
    /// # Errors
    /// [`ConfigError::Code`].
    fn read<const D: usize>(&self) -> Result<Camera<D>, ConfigError> {
        if self.reserved != 0 {
            let (field, given) = ("camera.reserved", self.reserved);
            return Err(ConfigError::Code { field, given });
        }
        let (across, down) = (cut(self.across), cut(self.down));
        let (forward, at) = (cut(self.forward), self.at);
        let lens = match self.lens {
            0 => Lens::Orthographic {
                across,
                down,
                at,
                forward,
                pitch: self.pitch,
            },
            1 => Lens::Pinhole {
                eye: cut(self.eye),
                across,
                down,
                at,
                forward,
            },
            given => {
                return Err(ConfigError::Code {
                    field: "camera.lens",
                    given,
                });
            }
        };
        let [width, height] = self.pixels;
        let pixels = [width, if D == 2 { 1 } else { height }];
        Ok(Camera { lens, pixels })
    }
}

/// The first `D` of three numbers.
fn cut<const D: usize>(vector: [f64; 3]) -> [f64; D] {
    let mut from = vector.into_iter();
    [0.0; D].map(|rest| from.next().unwrap_or(rest))
}

/// Cameras as the core takes them, with their number.
pub struct Cameras<const D: usize> {
    list: [Camera<D>; THURIBLE_MOST_CAMERAS],
    count: usize,
}

impl<const D: usize> Cameras<D> {
    /// None yet. There is one and it is not moved: it takes much of a stack.
    pub const fn new() -> Self {
        let lens = Lens::Orthographic {
            across: [0.0; D],
            down: [0.0; D],
            at: [0.0; 2],
            forward: [0.0; D],
            pitch: 1.0,
        };
        let none = Camera { lens, pixels: [0, 0] };
        Self {
            list: [none; THURIBLE_MOST_CAMERAS],
            count: 0,
        }
    }

    /// Takes those of a list.
    ///
    /// # Errors
    /// [`ConfigError`].
    ///
    /// # Safety
    /// `cameras` points to `count` cameras, where it is neither null nor misaligned.
    pub unsafe fn read(
        &mut self,
        cameras: *const ThuribleCamera,
        count: usize,
        names: &'static ListNames,
    ) -> Result<(), ConfigError> {
        // SAFETY: the caller's promise.
        let given = unsafe { entries(cameras, count, names) }?;
        for (place, camera) in self.list.iter_mut().zip(given) {
            *place = camera.read()?;
        }
        self.count = given.len();
        Ok(())
    }

    /// Those that there are.
    pub fn as_slice(&self) -> &[Camera<D>] {
        self.list.get(..self.count).unwrap_or(&self.list)
    }
}

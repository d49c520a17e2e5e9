//! What a mesh is made of.

/// What a mesh is made of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Material {
    /// Young's modulus Y.
    pub young: f64,
    /// Poisson's ratio nu; a rod has none.
    pub poisson: f64,
    /// Mass in a unit of area or volume.
    pub density: f64,
    /// Cross section of a rod.
    pub area: f64,
}

impl Default for Material {
    fn default() -> Self {
        Self {
            young: 1e5,
            poisson: 0.4,
            density: 1000.0,
            area: 0.01,
        }
    }
}

impl Material {
    /// mu and lambda of Lame.
    #[must_use]
    pub fn lame(&self) -> [f64; 2] {
        let (young, nu) = (self.young, self.poisson);
        [
            young / (2.0 * (1.0 + nu)),
            young * nu / ((1.0 + nu) * (1.0 - 2.0 * nu)),
        ]
    }

    /// What a simplex is multiplied by: the cross section of a rod, the unit thickness of a plane.
    pub(super) fn thickness(&self, dims: usize) -> f64 {
        if dims == 1 { self.area } else { 1.0 }
    }
}

//! What is deformed: vertices, simplices, springs, what they are made of.

use super::element::{CORNERS, Element};
use super::error::CondenseError;
use super::material::Material;

/// A spring between two vertices.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spring {
    /// Its ends.
    pub ends: [u32; 2],
    /// k of k/2 (l - L)^2.
    pub stiffness: f64,
    /// L.
    pub rest_length: f64,
    /// Whether a basis knows it.
    pub in_basis: bool,
}

/// Vertices and what joins them.
#[derive(Clone, Copy, Debug)]
pub struct Mesh<'a> {
    /// Components of a vector: 1 (rod), 2 or 3.
    pub dims: usize,
    /// Positions at rest, vertex by vertex.
    pub rest: &'a [f64],
    /// Corners of the simplices, one more than components each.
    pub elements: &'a [u32],
    /// Springs.
    pub springs: &'a [Spring],
    /// Whether each vertex is held: it is no unknown.
    pub held: &'a [bool],
    /// Vertices along each axis of a regular mesh, numbered along x first; zeros of any other. Colours are parities there.
    pub regular: [usize; 3],
    /// What it is made of.
    pub material: Material,
}

/// Most vertices, corners and ends: their numbers and sums of them are u32.
const MOST: usize = 1 << 28;

impl Mesh<'_> {
    /// Vertices.
    #[must_use]
    pub fn vertices(&self) -> usize {
        self.held.len()
    }

    /// Corners of each simplex.
    #[must_use]
    pub fn corners(&self) -> usize {
        self.dims + 1
    }

    /// Simplices.
    #[must_use]
    pub fn count(&self) -> usize {
        self.elements.len() / self.corners()
    }

    /// Where vertex `vertex` is at rest.
    #[must_use]
    pub fn place(&self, vertex: usize) -> [f64; 3] {
        let mut place = [0.0; 3];
        let from = self
            .rest
            .chunks_exact(self.dims.max(1))
            .nth(vertex)
            .unwrap_or(&[]);
        place.iter_mut().zip(from).for_each(|(to, from)| *to = *from);
        place
    }

    /// The corners of simplex `element`.
    #[must_use]
    pub fn corners_of(&self, element: usize) -> &[u32] {
        let size = self.corners();
        self.elements
            .get(element * size..(element + 1) * size)
            .unwrap_or(&[])
    }

    /// Simplex `element` at rest.
    #[must_use]
    pub(super) fn element(&self, element: usize) -> Element {
        let mut places = [[0.0; 3]; CORNERS];
        for (place, &corner) in places.iter_mut().zip(self.corners_of(element)) {
            *place = self.place(corner as usize);
        }
        Element::new(self.dims, &places)
    }

    /// Length, area or volume of all simplices.
    #[must_use]
    pub fn volume(&self) -> f64 {
        (0..self.count())
            .map(|element| self.element(element).volume)
            .sum()
    }

    /// Refuses what is no mesh.
    ///
    /// # Errors
    /// [`CondenseError`].
    pub fn check(&self) -> Result<(), CondenseError> {
        let count = self.vertices();
        if !(1..=3).contains(&self.dims)
            || self.rest.len() != count * self.dims
            || !self.elements.len().is_multiple_of(self.corners())
        {
            return Err(CondenseError::Lengths);
        }
        if count > MOST || self.elements.len() > MOST || self.springs.len() > MOST {
            return Err(CondenseError::TooLarge);
        }
        self.check_material()?;
        if let Some(at) = self.rest.iter().position(|x| !x.is_finite()) {
            return Err(CondenseError::Position {
                vertex: at / self.dims,
            });
        }
        let beyond = |vertex: &u32| *vertex as usize >= count;
        if let Some(at) = self.elements.iter().position(beyond) {
            return Err(CondenseError::Corner {
                element: at / self.corners(),
            });
        }
        // Also where a volume is not finite.
        let flat = |element: &usize| !(self.element(*element).volume > f64::MIN_POSITIVE);
        if let Some(element) = (0..self.count()).find(flat) {
            return Err(CondenseError::Inverted { element });
        }
        let wrong = |spring: &Spring| {
            let [one, other] = spring.ends;
            one == other
                || spring.ends.iter().any(beyond)
                || !(spring.stiffness > 0.0 && spring.stiffness.is_finite())
                || !(spring.rest_length >= 0.0 && spring.rest_length.is_finite())
        };
        match self.springs.iter().position(wrong) {
            Some(spring) => Err(CondenseError::Spring { spring }),
            None => Ok(()),
        }
    }

    fn check_material(&self) -> Result<(), CondenseError> {
        let positive = |x: f64| x > 0.0 && x.is_finite();
        let material = &self.material;
        let rules = [
            ("young", positive(material.young), "above 0"),
            (
                "poisson",
                self.dims == 1 || (material.poisson > -1.0 && material.poisson < 0.5),
                "above -1 and below 1/2",
            ),
            ("density", positive(material.density), "above 0"),
            ("area", self.dims > 1 || positive(material.area), "above 0"),
        ];
        let wrong = rules.into_iter().find(|(_, holds, _)| !holds);
        wrong.map_or(Ok(()), |(name, _, allowed)| {
            Err(CondenseError::Setting { name, allowed })
        })
    }
}

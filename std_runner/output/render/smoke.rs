//! Densities, and the bodies among them, as the renderer takes them.

use std::sync::Arc;

use super::grain::Drift;

/// Densities as they are drawn, in parts of what is drawn as full. In 2D there is one cell along y, and z is up.
pub struct Smoke {
    /// Along x, y and z.
    pub(super) cells: [usize; 3],
    /// One for each cell, x fastest.
    pub(super) values: Vec<f32>,
    /// Whether it is a plane.
    pub(super) flat: bool,
    /// The solid cells, if there are any.
    pub(super) body: Option<Body>,
    /// How detail drifts, and how much of it there is, 0 ..= 1.
    pub(super) detail: Option<(Drift, f32)>,
}

/// Solid cells with soft edges: above 1/2 in every solid cell, below in every other. Pictures of all steps share it.
#[derive(Clone)]
pub struct Body(pub(super) Arc<[f32]>);

/// What is so many times as dense as what is drawn as full, or denser, is drawn alike.
pub(crate) const DENSEST: f32 = 2.0;

/// Solid cells are blurred so often.
const BLURS: usize = 2;

impl Body {
    /// The cells of a grid of `cells` where `solid` is 1; nothing where it is so nowhere.
    pub fn new(cells: &[usize], solid: &[f32]) -> Option<Self> {
        if !solid.iter().any(|&part| part > 0.5) {
            return None;
        }
        let mut soft = solid.to_vec();
        for _ in 0..BLURS {
            let mut stride = 1;
            for &count in cells {
                blur(&mut soft, stride, count);
                stride *= count;
            }
        }
        // A plate one cell thick keeps about its thickness, as does a gap, and the steps of a slope are left smooth.
        for (soft, &solid) in soft.iter_mut().zip(solid) {
            let wrong = (*soft - 0.5) * if solid > 0.5 { -1.0 } else { 1.0 };
            if wrong >= 0.0 {
                let mended = (0.01 + 16.0 * wrong * wrong).min(0.12);
                *soft = if solid > 0.5 { 0.5 + mended } else { 0.5 - mended };
            }
        }
        Some(Self(soft.into()))
    }
}

/// Weights 1/4, 1/2, 1/4 along an axis of `count` cells, `stride` apart; the last cells are repeated beyond the ends.
fn blur(values: &mut [f32], stride: usize, count: usize) {
    for block in values.chunks_exact_mut(stride * count) {
        for first in 0..stride {
            let mut before = block[first];
            for index in 0..count {
                let here = block[first + index * stride];
                let after = block[first + (index + 1).min(count - 1) * stride];
                block[first + index * stride] = 0.25 * before + 0.5 * here + 0.25 * after;
                before = here;
            }
        }
    }
}

impl Smoke {
    /// `density` of a grid of `cells`, divided by `full`, about `body`.
    pub fn new(cells: &[usize], density: Vec<f32>, full: f32, body: Option<Body>) -> Self {
        let scale = if full > 0.0 { 1.0 / full } else { 1.0 };
        let drawn = |value: f32| {
            if value.is_finite() {
                (value * scale).clamp(-DENSEST, DENSEST)
            } else {
                0.0
            }
        };
        let values: Vec<f32> = density.into_iter().map(drawn).collect();
        let (cells, flat) = match *cells {
            [nx, ny, nz] => ([nx, ny, nz], false),
            [nx, ny] => ([nx, 1, ny], true),
            _ => ([values.len(), 1, 1], true),
        };
        Self {
            cells,
            values,
            flat,
            body,
            detail: None,
        }
    }

    /// With detail of an `amount` 0 ..= 1 that went with the flow.
    pub fn with_detail(self, drift: Drift, amount: f32) -> Self {
        Self {
            detail: Some((drift, amount)),
            ..self
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
        Self {
            values,
            body: self.body.clone(),
            detail: None,
            ..*self
        }
    }

    /// Cells of the longest side.
    pub(super) fn longest(&self) -> f32 {
        self.cells.iter().copied().max().unwrap_or(1) as f32
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn solid_cells_stay_inside_of_the_body_and_others_outside() {
        // A plate one cell thick, a rod, a gap one cell wide, and a corner.
        let solid = |cell: usize| {
            let (x, y) = (cell % 12, cell / 12);
            f32::from(u8::from(y == 2 || (x == 9 && y == 5) || (y > 7 && x != 4)))
        };
        let solid: Vec<f32> = (0..144).map(solid).collect();
        let Some(Body(soft)) = Body::new(&[12, 12], &solid) else {
            unreachable!("some cells are solid")
        };
        for (cell, (soft, solid)) in soft.iter().zip(&solid).enumerate() {
            assert!((*soft > 0.5) == (*solid > 0.5), "{cell}: {soft}");
        }
        assert!(Body::new(&[12, 12], &[0.0; 144]).is_none());
    }
}

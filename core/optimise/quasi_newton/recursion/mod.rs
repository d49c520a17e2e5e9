//! The recursion of L-BFGS over inner products alone: no fields, no threads, no element type.

mod saved;

use super::history::{History, Kept, MAX_FIELDS, MAX_PAIRS};
use core::cmp::Ordering;
use heapless::Vec;

/// Inner products of some covector with s and with z = P y: of a pair, or of a step that may become one.
#[derive(Clone, Copy, Debug, Default)]
pub struct Products {
    /// With s.
    pub s: f64,
    /// With z.
    pub z: f64,
}

/// Inner products of the gradient g at a new point.
#[derive(Clone, Debug, Default)]
pub struct GradientProducts {
    /// With those of every pair, oldest first.
    pub pairs: Vec<Products, MAX_PAIRS>,
    /// <g, P g>.
    pub norm: f64,
    /// With the step to that point, and with P times the gradient where it began; 0 at the first point.
    pub step: Products,
}

/// -H g as a sum of fields.
#[derive(Clone, Debug)]
pub struct Combination {
    /// Factor of P g, which is field [`QuasiNewton::preconditioned`].
    pub preconditioned: f64,
    /// Each pair, oldest first, with the factors of its s and of its z.
    pub pairs: Vec<(Kept, [f64; 2]), MAX_PAIRS>,
}

/// A step s and z = P y, y the change of the gradient along it.
#[derive(Clone, Debug)]
struct Pair {
    kept: Kept,
    /// With its own y: <s, y> > 0 and <z, y>.
    own: Products,
    /// With the gradient at the current point.
    gradient: Products,
    /// Those of all older pairs, oldest first, with this one's y.
    older: Vec<Products, MAX_PAIRS>,
}

/// Which field plays which part, and the inner products from which the next direction follows.
#[derive(Clone, Debug)]
pub struct QuasiNewton {
    /// Oldest first.
    pairs: Vec<Pair, MAX_PAIRS>,
    /// Factor of the first inverse Hessian P: <s, y> / <y, P y> of the newest pair (Nocedal & Wright eq. 7.20, in the norm of P).
    scale: f64,
    /// <g, P g> of the current gradient g.
    norm: f64,
    /// <g, d> of the newest direction d.
    slope: f64,
    history: History,
    free: Vec<usize, MAX_FIELDS>,
    /// The direction, to be written by [`Self::descend`].
    pub direction: usize,
    /// P g at the current point.
    pub preconditioned: usize,
}

/// Two fields for a trial: one for the caller's use, one for the gradient at the new point.
#[derive(Clone, Copy, Debug)]
pub struct Borrowed {
    /// The caller's, until P times the gradient goes there.
    pub work: usize,
    /// The next gradient.
    pub gradient: usize,
}

impl QuasiNewton {
    /// No pairs yet, and as many as `history` says at most.
    #[must_use]
    pub fn new(history: History) -> Self {
        let history = History {
            pairs: history.pairs.clamp(1, MAX_PAIRS),
            ..history
        };
        let free = (2..history.fields()).collect();
        Self {
            pairs: Vec::new(),
            scale: 1.0,
            norm: 0.0,
            slope: 0.0,
            history,
            free,
            direction: 0,
            preconditioned: 1,
        }
    }

    /// <g, P g>^(1/2) of the current gradient g.
    #[must_use]
    pub fn gradient_norm(&self) -> f64 {
        libm::sqrt(self.norm)
    }

    /// Whether there are pairs.
    #[must_use]
    pub fn has_pairs(&self) -> bool {
        !self.pairs.is_empty()
    }

    /// How many pairs there are.
    #[must_use]
    pub fn count(&self) -> usize {
        self.pairs.len()
    }

    /// Whether a new pair becomes one field of halves, in the place of the gradient that it ends at.
    #[must_use]
    pub fn halves(&self) -> bool {
        self.history.halves()
    }

    /// Where the pairs are, oldest first.
    pub fn kept(&self) -> impl Iterator<Item = Kept> {
        self.pairs.iter().map(|pair| pair.kept)
    }

    /// Drops all pairs.
    pub fn forget(&mut self) {
        self.scale = 1.0;
        while self.drop_oldest() {}
    }

    fn drop_oldest(&mut self) -> bool {
        if self.pairs.is_empty() {
            return false;
        }
        let Pair { kept, .. } = self.pairs.remove(0);
        self.release(kept.fields());
        for pair in &mut self.pairs {
            pair.older.remove(0);
        }
        true
    }

    fn release(&mut self, fields: &[usize]) {
        // There is room for every field that there is.
        let _ = self.free.extend_from_slice(fields);
    }

    /// The direction -H g, and its slope <g, -H g>, which stands for that of the newest direction from here on.
    ///
    /// The two loops of algorithm 7.4 run over the inner products alone: with q = g - sum a_j y_j and z = P y,
    /// H g = scale (P g - sum a_j z_j) + sum (a_i - b_i) s_i.
    pub fn combine(&mut self) -> (Combination, f64) {
        let away = self.first_loop();
        let along = self.second_loop(&away);
        let scale = self.scale;
        let factors = away.iter().zip(&along);
        let weights = self
            .pairs
            .iter()
            .zip(factors)
            .map(|(pair, (a, c))| (pair, -c, scale * a));
        self.slope = weights.clone().fold(-scale * self.norm, |sum, (pair, s, z)| {
            sum + s * pair.gradient.s + z * pair.gradient.z
        });
        let combination = Combination {
            preconditioned: -scale,
            pairs: weights.map(|(pair, s, z)| (pair.kept, [s, z])).collect(),
        };
        (combination, self.slope)
    }

    /// a_i = <s_i, q> / <s_i, y_i>, from the newest pair to the oldest.
    fn first_loop(&self) -> [f64; MAX_PAIRS] {
        let pairs = &self.pairs;
        let mut away = [0.0; MAX_PAIRS];
        for (i, pair) in pairs.iter().enumerate().rev() {
            let newer: f64 = pairs[i + 1..]
                .iter()
                .zip(&away[i + 1..])
                .map(|(newer, a)| a * newer.older[i].s)
                .sum();
            away[i] = (pair.gradient.s - newer) / pair.own.s;
        }
        away
    }

    /// a_i - b_i with b_i = <y_i, H q> / <s_i, y_i>, from the oldest pair to the newest.
    fn second_loop(&self, away: &[f64; MAX_PAIRS]) -> [f64; MAX_PAIRS] {
        let pairs = &self.pairs;
        let mut along = [0.0; MAX_PAIRS];
        for (i, pair) in pairs.iter().enumerate() {
            let image = |j: usize| match j.cmp(&i) {
                Ordering::Less => pair.older[j].z,
                Ordering::Equal => pair.own.z,
                Ordering::Greater => pairs[j].older[i].z,
            };
            let images: f64 = (0..pairs.len()).map(|j| away[j] * image(j)).sum();
            let older: f64 = pair.older.iter().zip(&along).map(|(older, c)| c * older.s).sum();
            along[i] = away[i] - (self.scale * (pair.gradient.z - images) + older) / pair.own.s;
        }
        along
    }

    /// The fields of the first evaluation: those of the preconditioned gradient and of the direction.
    #[must_use]
    pub fn first(&self) -> Borrowed {
        Borrowed {
            work: self.preconditioned,
            gradient: self.direction,
        }
    }

    /// Two free fields; the oldest pair is dropped for them where there are as many pairs as there may be.
    pub fn borrow(&mut self) -> Option<Borrowed> {
        if self.free.len() < 2 {
            self.drop_oldest();
        }
        Some(Borrowed {
            work: self.free.pop()?,
            gradient: self.free.pop()?,
        })
    }

    /// Gives them back.
    pub fn give_back(&mut self, borrowed: Borrowed) {
        self.release(&[borrowed.work, borrowed.gradient]);
    }

    /// Moves to a point with these inner products. `step` is how many times the direction leads there, or `None` for the first
    /// point. The direction's field then holds the step, which is s of a new pair, and that of P g before is its z; or the gradient's
    /// field holds both in halves. The pair is left out where it has no positive curvature.
    pub fn move_to(&mut self, borrowed: Borrowed, step: Option<f64>, products: &GradientProducts) {
        let older = self.with_change(&products.pairs);
        let Some(length) = step else {
            self.norm = products.norm;
            return;
        };
        let GradientProducts { norm, step: with, .. } = *products;
        let own = Products {
            s: with.s - length * self.slope,
            z: norm - 2.0 * with.z + self.norm,
        };
        let before = [self.direction, self.preconditioned];
        (self.norm, self.preconditioned) = (norm, borrowed.work);
        let kept = if self.halves() {
            self.release(&before[1..]);
            Kept::Halves(borrowed.gradient)
        } else {
            self.direction = borrowed.gradient;
            Kept::Full(before)
        };
        let pair = Pair {
            kept,
            own,
            gradient: Products {
                s: with.s,
                z: norm - with.z,
            },
            older,
        };
        if own.s > 0.0 && own.z > 0.0 && self.pairs.push(pair).is_ok() {
            self.scale = own.s / own.z;
        } else {
            self.release(kept.fields());
        }
        debug_assert!(self.pairs.len() <= self.history.pairs);
    }

    /// Takes over the new gradient's inner products with every pair; those with the gradient's change.
    fn with_change(&mut self, new: &[Products]) -> Vec<Products, MAX_PAIRS> {
        let pairs = self.pairs.iter_mut().zip(new);
        pairs
            .map(|(pair, &now)| {
                let before = core::mem::replace(&mut pair.gradient, now);
                Products {
                    s: now.s - before.s,
                    z: now.z - before.z,
                }
            })
            .collect()
    }
}

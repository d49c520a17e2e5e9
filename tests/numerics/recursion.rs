//! The recursion of L-BFGS alone, on small dense vectors: its combination of fields against the two loops of Nocedal & Wright,
//! algorithm 7.4, over whole vectors.

use crate::fields::assert_close;
use crate::fields::random::Random;
use thurible_core::Real;
use thurible_core::optimise::quasi_newton::history::{History, HistoryPrecision, Kept};
use thurible_core::optimise::quasi_newton::recursion::{Borrowed, GradientProducts, Products, QuasiNewton};

const LEN: usize = 7;
type Dense = [f64; LEN];

fn dot(x: &Dense, y: &Dense) -> f64 {
    x.iter().zip(y).map(|(x, y)| x * y).sum()
}

/// x + t y.
fn add(x: &Dense, t: f64, y: &Dense) -> Dense {
    core::array::from_fn(|i| x[i] + t * y[i])
}

/// P x for the diagonal P = diag(1, 1/2, 1/3, ..).
fn precondition(x: &Dense) -> Dense {
    core::array::from_fn(|i| x[i] / (1 + i) as f64)
}

/// -H g over pairs (s, y), the newest last, from the first inverse Hessian gamma P with gamma of eq. 7.20 in the norm of P.
fn two_loops(pairs: &[(Dense, Dense)], gradient: &Dense) -> Dense {
    let mut q = *gradient;
    let mut weights = Vec::new();
    for (s, y) in pairs.iter().rev() {
        let weight = dot(s, &q) / dot(s, y);
        q = add(&q, -weight, y);
        weights.push(weight);
    }
    let gamma = pairs
        .last()
        .map_or(1.0, |(s, y)| dot(s, y) / dot(y, &precondition(y)));
    let mut r = precondition(&q).map(|x| gamma * x);
    for ((s, y), weight) in pairs.iter().zip(weights.iter().rev()) {
        r = add(&r, weight - dot(y, &r) / dot(s, y), s);
    }
    r.map(|x| -x)
}

/// The fields and the recursion, with the passes over fields in their plainest form.
struct Plain {
    newton: QuasiNewton,
    fields: Vec<Dense>,
}

impl Plain {
    fn new(history: History) -> Self {
        Self {
            newton: QuasiNewton::new(history),
            fields: vec![[f64::NAN; LEN]; history.fields()],
        }
    }

    /// s and z of a pair.
    fn pair(&self, kept: Kept) -> [Dense; 2] {
        match kept {
            Kept::Full(fields) => fields.map(|field| self.fields[field]),
            Kept::Halves(field) => [0, 1].map(|half| self.fields[field].map(|both| both.halves()[half])),
        }
    }

    /// The direction and its slope.
    fn descend(&mut self) -> (Dense, f64) {
        let (combination, slope) = self.newton.combine();
        let first = self.fields[self.newton.preconditioned].map(|x| combination.preconditioned * x);
        let direction = combination.pairs.iter().fold(first, |sum, &(kept, factors)| {
            let [s, z] = self.pair(kept);
            add(&add(&sum, factors[0], &s), factors[1], &z)
        });
        self.fields[self.newton.direction] = direction;
        (direction, slope)
    }

    /// To the point with this gradient, so many times the direction away.
    fn arrive(&mut self, borrowed: Borrowed, step: Option<f64>, gradient: &Dense) {
        let image = precondition(gradient);
        let with = |field: usize| dot(&self.fields[field], gradient);
        let of_pairs = self.newton.kept().map(|kept| {
            let [s, z] = self.pair(kept).map(|field| dot(&field, gradient));
            Products { s, z }
        });
        let (direction, before) = (self.newton.direction, self.newton.preconditioned);
        let products = GradientProducts {
            pairs: of_pairs.collect(),
            norm: dot(&image, gradient),
            step: step.map_or(Products::default(), |length| Products {
                s: length * with(direction),
                z: with(before),
            }),
        };
        if let Some(length) = step {
            let s = self.fields[direction].map(|x| length * x);
            let z = add(&image, -1.0, &self.fields[before]);
            if self.newton.halves() {
                self.fields[borrowed.gradient] = core::array::from_fn(|i| f64::of_halves([s[i], z[i]]));
            } else {
                (self.fields[direction], self.fields[before]) = (s, z);
            }
        }
        self.fields[borrowed.work] = image;
        self.newton.move_to(borrowed, step, &products);
    }
}

/// A dozen steps on a convex quartic, sum of c_i x_i^2 / 2 + x_i^4 / 4 - b_i x_i, with steps that follow no line search.
fn descends(history: History, near: f64) {
    let most = history.pairs;
    let mut random = Random::new(94 + most as u64);
    let mut next = || -> Dense { core::array::from_fn(|_| random.signed()) };
    let (stiff, linear) = (next().map(|c| 1.5 + c), next());
    let gradient_at =
        |x: &Dense| -> Dense { core::array::from_fn(|i| stiff[i] * x[i] + x[i].powi(3) - linear[i]) };
    let (mut plain, mut pairs, mut x) = (Plain::new(history), Vec::new(), next());
    let mut gradient = gradient_at(&x);
    plain.arrive(plain.newton.first(), None, &gradient);
    for step in 0..12 {
        let (direction, slope) = plain.descend();
        let kept: &[(Dense, Dense)] = &pairs;
        let expected = two_loops(&kept[kept.len().saturating_sub(most)..], &gradient);
        let largest = expected.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
        for (found, expected) in direction.iter().zip(&expected) {
            assert_close("direction", *found, *expected, largest, near);
        }
        assert_close("slope", slope, dot(&gradient, &direction), slope.abs(), near);
        let length = [0.3, 0.7, 0.5][step % 3];
        x = add(&x, length, &direction);
        let after = gradient_at(&x);
        let borrowed = plain.newton.borrow().unwrap();
        plain.arrive(borrowed, Some(length), &after);
        pairs.push((direction.map(|d| length * d), add(&after, -1.0, &gradient)));
        gradient = after;
    }
    assert_eq!(plain.newton.count(), most);
}

#[test]
fn the_recursion_is_the_two_loops_over_whole_vectors() {
    for pairs in [1, 2, 5, 8] {
        descends(History::full(pairs), 1e-8);
        let precision = HistoryPrecision::Half;
        descends(History { pairs, precision }, 1e-4);
    }
}

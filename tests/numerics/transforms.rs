//! Transforms along the axes of a box against the eigenvectors that they stand for, and how few passes a projection by them takes.

use crate::fields::random::Random;
use crate::fields::{Components, Memory, cast, gap, grid, with_threads};
use crate::projection::{GRIDS, project};
use core::f64::consts::PI;
use thurible_core::field::transform;
use thurible_core::grid::levels::Levels;
use thurible_core::memory::Arena;
use thurible_core::{Exec, Real, Serial};

/// The eigenvectors of an axis: cosines between walls, cosines and then sines on a ring; those that are even about the middle first.
fn eigenvectors(n: usize, ring: bool) -> Vec<Vec<f64>> {
    let even = (0..n.div_ceil(2)).map(|k| (2 * k, false));
    let odd = (0..n / 2).map(|k| {
        if ring {
            (2 * (k + 1), true)
        } else {
            (2 * k + 1, false)
        }
    });
    let vector = |(waves, sine): (usize, bool)| {
        let value = |i: usize| {
            let angle = PI * waves as f64 * (i as f64 + 0.5) / n as f64;
            if sine { angle.sin() } else { angle.cos() }
        };
        let values: Vec<f64> = (0..n).map(value).collect();
        let length = values.iter().map(|x| x * x).sum::<f64>().sqrt();
        values.iter().map(|x| x / length).collect()
    };
    even.chain(odd).map(vector).collect()
}

/// A column times its own factor for each eigenvector.
fn multiplied(vectors: &[Vec<f64>], factors: &[f64], column: &[f64]) -> Vec<f64> {
    let mut out = vec![0.0; column.len()];
    for (vector, factor) in vectors.iter().zip(factors) {
        let coefficient: f64 = vector.iter().zip(column).map(|(v, x)| v * x).sum();
        out.iter_mut()
            .zip(vector)
            .for_each(|(out, v)| *out += factor * coefficient * v);
    }
    out
}

fn agrees<T: Real>(n: usize, ring: bool, along_x: bool) {
    let what = format!(
        "{} along {} {n}, ring {ring}",
        T::NAME,
        if along_x { "x" } else { "y" }
    );
    // More columns than are transformed together, and no whole number of vectors.
    let others = 37;
    let (cells, ends) = match (along_x, ring) {
        (true, false) => ([n, others], "ww"),
        (true, true) => ([n, others], "pw"),
        (false, false) => ([others, n], "ww"),
        (false, true) => ([others, n], "wp"),
    };
    let mut random = Random::new(n as u64);
    let grid = grid(&cells, ends);
    let field: Vec<T> = random.cells(&grid, 1);
    let factors: Vec<f64> = (0..n).map(|_| random.signed()).collect();
    let mut memory = Memory::new(1 << 22);
    let levels = Levels::<T>::carve(&mut Arena::new(memory.block()), &grid, 0).unwrap();
    let on = |exec: &dyn Exec| {
        let mut scratch = vec![T::from_f64(f64::NAN); exec.threads() * transform::scratch_len(&grid)];
        let (mut found, spectrum) = (field.clone(), levels.spectrum(0));
        let rows = transform::multiplied(&spectrum, |row, span, old, new| {
            for ((at, &old), new) in span.zip(old).zip(new) {
                *new = T::from_f64(factors[if along_x { at } else { row }]) * old;
            }
        });
        transform::across(exec, (&grid, &spectrum), &mut found, &mut scratch, rows);
        found
    };
    let found = on(&Serial);
    assert!(
        with_threads(3, on) == found,
        "{what}: other bits on three threads"
    );
    let (vectors, field): (_, Vec<f64>) = (eigenvectors(n, ring), cast(&field));
    let place = |other: usize, i: usize| {
        if along_x {
            other * n + i
        } else {
            i * others + other
        }
    };
    let found: Vec<f64> = cast(&found);
    for other in [0, 1, 16, 31, 32, 36] {
        let [column, found] =
            [&field, &found].map(|field| (0..n).map(|i| field[place(other, i)]).collect::<Vec<_>>());
        let expected = multiplied(&vectors, &factors, &column);
        let wrong = gap(&found, &expected);
        let rounding = (3 * n) as f64 * f64::EPSILON + 60.0 * T::EPSILON;
        assert!(wrong <= rounding, "{what}, column {other}: {wrong:e}");
    }
}

/// Lengths with matrices and without: powers of two, of primes, with a large prime, primes; on both sides of the longest one with matrices.
#[test]
fn transforms_are_those_of_the_eigenvectors() {
    for n in [
        30, 32, 33, 36, 45, 60, 64, 77, 78, 97, 100, 128, 130, 200, 243, 245, 251, 256, 257, 258, 270, 300,
        343, 512, 514, 625, 729, 1000, 1021, 2048,
    ] {
        for (ring, along_x) in [(false, true), (true, true), (false, false), (true, false)] {
            agrees::<f64>(n, ring, along_x);
            agrees::<f32>(n, ring, along_x);
        }
    }
}

#[test]
fn a_stop_is_heard_and_nan_is_not_hidden() {
    for cells in [[20, 20], [300, 4]] {
        let grid = grid(&cells, "ww");
        for poison in [f64::NAN, f64::INFINITY] {
            let mut v: Components<f64> = Random::new(58).faces(&grid, 4);
            v[1][777] = poison;
            assert!(
                project(&grid, 4, &mut v, None, 1e-5, usize::MAX)
                    .divergence
                    .unwrap()
                    .is_nan()
            );
        }
        let mut v: Components<f64> = Random::new(59).faces(&grid, 4);
        assert_eq!(project(&grid, 4, &mut v, None, 1e-14, 1).divergence, None);
    }
}

/// Two passes are enough in double precision.
#[test]
fn a_projection_takes_two_passes() {
    let mut random = Random::new(60);
    for (cells, ends) in
        GRIDS
            .into_iter()
            .chain([(&[200, 7][..], "ww"), (&[100, 33], "pw"), (&[1000, 7], "pw")])
    {
        let grid = grid(cells, ends);
        let mut v: Components<f64> = random.faces(&grid, 3);
        let done = project(&grid, 3, &mut v, None, 1e-12, usize::MAX);
        assert!(done.cycles <= 2, "{} passes on {cells:?} {ends}", done.cycles);
    }
}

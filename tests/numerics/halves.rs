//! Two numbers in the bytes of one, and the rows of them.

use crate::determinism::LEVEL;
use crate::fields::random::Random;
use thurible_core::Real;
use thurible_core::field::rows::{self, LANES};
use thurible_core::simd::{Level, level, limit};

/// The bits of a bfloat16 nearest to `x`, ties to even, among its neighbours by distance in f64.
fn nearest(x: f32) -> u16 {
    let below = (x.to_bits() >> 16) as u16;
    let value = |half: u16| f64::from(f32::from_bits(u32::from(half) << 16));
    // What is beyond the largest would be the next power of two.
    let above = match value(below + 1) {
        beyond if beyond.is_infinite() => beyond.signum() * 2f64.powi(128),
        above => above,
    };
    let [down, up] = [value(below), above].map(|half| (half - f64::from(x)).abs());
    if down < up || (down == up && below.is_multiple_of(2)) {
        below
    } else {
        below + 1
    }
}

#[test]
fn halves_of_f32_are_bfloat16_to_the_nearest_even() {
    for bits in 0..=u16::MAX {
        let x = f32::from_bits(u32::from(bits) << 16);
        let other = f32::from_bits(u32::from(bits.reverse_bits()) << 16);
        let [upper, lower] = f32::of_halves([x, other]).halves();
        for (found, x) in [(upper, x), (lower, other)] {
            assert!(
                found.to_bits() == x.to_bits() || found.is_nan() && x.is_nan(),
                "{x:e} became {found:e}"
            );
        }
    }
    let mut random = Random::new(17);
    let odd = [
        0x7f7f_7fff,
        0x7f7f_8000,
        0x7f7f_ffff,
        0x0000_8000,
        0x0000_8001,
        0x3f80_8000,
        0x3f81_8000,
    ];
    let many = (0..20_000).map(|_| (random.signed() * 2f64.powi(random.between(0, 250) as i32 - 125)) as f32);
    for x in many.chain(odd.map(f32::from_bits)).flat_map(|x| [x, -x]) {
        let [upper, lower] = f32::of_halves([x, -x]).halves();
        assert_eq!((upper.to_bits() >> 16) as u16, nearest(x), "{x:e}");
        assert_eq!(lower, -upper, "{x:e}");
    }
    assert!(f32::of_halves([f32::from_bits(0x7fff_ffff), 0.0]).halves()[0].is_nan());
}

#[test]
fn halves_of_f64_are_f32() {
    let mut random = Random::new(18);
    for _ in 0..1000 {
        let numbers = [random.signed() * 1e-3, random.signed() * 1e9];
        assert_eq!(
            f64::of_halves(numbers).halves(),
            numbers.map(|x| f64::from(x as f32))
        );
    }
    let odd = [f64::NAN, 1e300];
    let [nan, beyond] = f64::of_halves(odd).halves();
    assert!(nan.is_nan() && beyond == f64::INFINITY);
}

/// What the rows of halves give of random numbers: bits of all results.
fn results<T: Real>(len: usize) -> Vec<u64> {
    let mut random = Random::new(19 + len as u64);
    let mut row = || -> Vec<T> { (0..len).map(|_| T::from_f64(random.signed())).collect() };
    let [x, y, z, factor, mut out] = core::array::from_fn(|_| row());
    let t = T::from_f64(0.3);
    let mut both = factor.clone();
    rows::keep_halves(&mut both, t, &x, &y, &z);
    for i in 0..len {
        let expected = T::of_halves([t * x[i], y[i] - z[i]]);
        assert_eq!(both[i].halves().map(T::to_f64), expected.halves().map(T::to_f64));
    }
    let before = out.clone();
    let factors = [T::from_f64(-0.7), T::from_f64(1.9)];
    rows::add_halves(&mut out, factors, &both);
    let mut lanes = [[0.25; LANES]; 2];
    rows::add_products_of_halves(&mut lanes, &both, &factor);
    let mut plain = [[0.25; LANES]; 2];
    for which in 0..2 {
        let half: Vec<T> = both.iter().map(|both| both.halves()[which]).collect();
        rows::add_products(&mut plain[which], &half, &factor);
    }
    assert_eq!(lanes, plain, "as of rows of their own");
    for i in 0..len {
        let [x, y] = both[i].halves();
        assert_eq!(out[i], before[i] + (factors[0] * x + factors[1] * y));
    }
    let numbers = both.iter().flat_map(|both| both.halves()).chain(out);
    let numbers = numbers.map(T::to_f64).chain(lanes.into_iter().flatten());
    numbers.map(f64::to_bits).collect()
}

#[test]
fn rows_of_halves_are_alike_by_every_instruction_set() {
    let _one_at_a_time = LEVEL.lock().unwrap();
    let best = level();
    for len in [0, 1, 15, 16, 33, 512, 515] {
        let at_best = (results::<f32>(len), results::<f64>(len));
        for lower in [Level::Avx2, Level::Baseline] {
            limit(lower);
            assert!(
                (results::<f32>(len), results::<f64>(len)) == at_best,
                "{len} at {lower:?}"
            );
        }
        limit(best);
    }
}

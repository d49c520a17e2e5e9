//! The walk itself: its random numbers, its budget, and that priors change by exactly what the whole says.

use crate::fields::random::Random as Plain;
use thurible_core::walk::prior::{change, whole};
use thurible_core::walk::{Cells, Chain, Course, Gain, Prior, Random, Rule, Terrain};

/// A sample anywhere changes each prior by the difference of the whole sums, in the middle and at every edge.
fn changes_exactly<const D: usize>(counts: [usize; D], seed: u64) {
    let cells = Cells { counts };
    let mut plain = Plain::new(seed);
    let field: Vec<f64> = (0..cells.len()).map(|_| plain.unit()).collect();
    for prior in [Prior::L2, Prior::Tv, Prior::Sad] {
        let before = whole(prior, &cells, &field);
        for number in 0..200 {
            let place = counts.map(|count| match number % 5 {
                0 => 0.3 * plain.unit(),
                1 => count as f64 - 0.3 * plain.unit(),
                _ => count as f64 * plain.unit(),
            });
            let footprint = cells.around(&place.map(|x: f64| x.max(0.0)));
            let mass = 0.7 * plain.unit() + 0.01;
            let found = change(prior, &cells, &field, &footprint, mass);
            for (found, mass) in found.into_iter().zip([mass, -mass]) {
                let mut after = field.clone();
                cells.add(&mut after, &footprint, mass);
                let expected = whole(prior, &cells, &after) - before;
                assert!(
                    (found - expected).abs() <= 1e-12 * before.max(1.0),
                    "{prior:?} at {place:?}: {found} for {expected}"
                );
            }
        }
    }
}

#[test]
fn a_sample_changes_a_prior_by_what_the_whole_says() {
    changes_exactly([9, 7], 1);
    changes_exactly([2, 5], 2);
    changes_exactly([3, 2], 3);
    changes_exactly([6, 5, 7], 4);
    changes_exactly([2, 3, 2], 5);
}

#[test]
fn weights_sum_to_one_and_stand_where_the_place_is() {
    let cells = Cells { counts: [5, 4, 6] };
    let mut plain = Plain::new(9);
    for _ in 0..500 {
        let place = cells.counts.map(|count| count as f64 * plain.unit());
        let mut field = vec![0.0_f64; cells.len()];
        cells.add(&mut field, &cells.around(&place), 1.0);
        assert!((field.iter().sum::<f64>() - 1.0).abs() < 1e-14);
        for axis in 0..3 {
            let mean: f64 = field
                .iter()
                .enumerate()
                .map(|(index, weight)| weight * (cells.cell(index)[axis] as f64 + 0.5))
                .sum();
            let clamped = place[axis].clamp(0.5, cells.counts[axis] as f64 - 0.5);
            assert!((mean - clamped).abs() < 1e-13);
        }
    }
}

#[test]
fn random_numbers_are_uniform_and_normal_and_streams_differ() {
    let mut random = Random::new(7, 0, 0);
    let count = 200_000;
    let (mut sum, mut square, mut uniform) = (0.0, 0.0, 0.0);
    for _ in 0..count {
        let x = random.normal();
        sum += x;
        square += x * x;
        let u = random.uniform();
        assert!((0.0..1.0).contains(&u));
        uniform += u;
    }
    let mean = |sum: f64| sum / f64::from(count);
    assert!(mean(sum).abs() < 0.01 && (mean(square) - 1.0).abs() < 0.02);
    assert!((mean(uniform) - 0.5).abs() < 0.005);
    let first = |seed, frame, chain| Random::new(seed, frame, chain).uniform();
    let all = [first(1, 0, 0), first(2, 0, 0), first(1, 1, 0), first(1, 0, 1)];
    for (at, one) in all.iter().enumerate() {
        assert!(all.iter().skip(at + 1).all(|other| other != one));
    }
    // SplitMix64 of state 0: the published first outputs, of which the first is dropped.
    let zero = 1_u64.wrapping_mul(0xd134_2543_de82_ef95);
    let mut known = Random::new(zero, 0, 0);
    assert_eq!(
        known.uniform(),
        (0x6e78_9e6a_a1b9_65f4_u64 >> 11) as f64 / 9_007_199_254_740_992.0
    );
}

/// A hill on which gains are known.
struct Hill {
    recorded: Vec<(f64, f64)>,
}

impl Terrain for Hill {
    type Place = f64;

    fn anywhere(&self, random: &mut Random) -> f64 {
        random.uniform()
    }
    fn near(&self, from: f64, random: &mut Random) -> f64 {
        from + 0.1 * random.normal()
    }
    fn gain(&self, place: f64) -> Gain {
        Gain {
            energy: 0.25 - (place - 0.5) * (place - 0.5),
            mass: 1.0,
        }
    }
    fn record(&mut self, place: f64, mass: f64) {
        self.recorded.push((place, mass));
    }
}

#[test]
fn only_gains_are_recorded_and_cuts_do_not_matter() {
    for rule in [Rule::Patient, Rule::Eager] {
        let mut whole = Hill { recorded: Vec::new() };
        Course::new(3, 2, 70, 1000, rule).advance(&mut whole, u64::MAX);
        let mut cut = Hill { recorded: Vec::new() };
        let mut course = Course::new(3, 2, 70, 1000, rule);
        while !course.over() {
            course.advance(&mut cut, 13);
        }
        assert_eq!(course.walked().mutations, 1000);
        assert_eq!(course.walked().recorded, cut.recorded.len() as u64);
        assert_eq!(whole.recorded, cut.recorded);
        assert!(whole.recorded.iter().all(|(place, _)| (0.0..1.0).contains(place)));
        assert!(whole.recorded.len() > 300);
    }
}

/// Of places with gains a chain of the patient rule visits each as often as it gains: Metropolis' rule.
#[test]
fn a_chain_visits_places_in_proportion_to_their_gain() {
    let mut hill = Hill { recorded: Vec::new() };
    let mut chain = Chain::new(&hill, Random::new(5, 0, 0));
    (0..400_000).for_each(|_| {
        chain.mutate(&mut hill, Rule::Patient);
    });
    let inner = hill
        .recorded
        .iter()
        .filter(|(place, _)| (0.25..0.75).contains(place));
    let part = inner.count() as f64 / hill.recorded.len() as f64;
    // The gains have 11/16 of theirs there; records are arrivals, not stays, which the outer places see fewer of.
    assert!((0.66..0.76).contains(&part), "{part}");
}

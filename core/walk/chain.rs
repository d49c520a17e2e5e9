//! Chains over places, one after the other, until a budget of mutations is spent.

use super::Random;
use crate::words::named;

/// What a sample at a place is worth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gain {
    /// dE: by how much the objective falls.
    pub energy: f64,
    /// The sample's mass: +eps or -eps, whichever gains more.
    pub mass: f64,
}

impl Gain {
    /// That of a place where there can be no sample.
    pub const NONE: Self = Self {
        energy: -1.0,
        mass: 0.0,
    };

    /// The better of samples of + and - `mass`, by what they gain; that of + where they gain the same.
    #[inline(always)]
    #[must_use]
    pub fn better([plus, minus]: [f64; 2], mass: f64) -> Self {
        if minus > plus {
            Self {
                energy: minus,
                mass: -mass,
            }
        } else {
            Self { energy: plus, mass }
        }
    }
}

/// What a chain walks on.
pub trait Terrain {
    /// A place.
    type Place: Copy;

    /// A place drawn uniformly from all.
    fn anywhere(&self, random: &mut Random) -> Self::Place;
    /// A place near `from`, drawn from a normal distribution.
    fn near(&self, from: Self::Place, random: &mut Random) -> Self::Place;
    /// What a sample at `place` is worth now.
    fn gain(&self, place: Self::Place) -> Gain;
    /// Adds a sample.
    fn record(&mut self, place: Self::Place, mass: f64);
    /// A chain of `mutations` is over, of which so many were recorded.
    fn chain_over(&mut self, mutations: u64, recorded: u64) {
        let _ = (mutations, recorded);
    }
}

/// When a chain walks, and when it records.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Rule {
    /// It records where it walks to (Algorithm 2).
    #[default]
    Patient,
    /// It records whatever has a gain, and proposes a place anywhere with probability 1 % (Algorithm 4).
    Eager,
}

named!(Rule { Patient = "patient", Eager = "eager" });

/// How often the eager rule proposes any place.
const ANYWHERE: f64 = 0.01;

/// Where a chain stands.
#[derive(Clone, Copy, Debug)]
pub struct Chain<P> {
    random: Random,
    place: P,
    /// dE of the place as it was when the chain came there.
    energy: f64,
}

impl<P: Copy> Chain<P> {
    /// A chain that begins anywhere.
    #[inline(always)]
    pub fn new<W: Terrain<Place = P>>(terrain: &W, mut random: Random) -> Self {
        let place = terrain.anywhere(&mut random);
        Self {
            random,
            place,
            energy: terrain.gain(place).energy,
        }
    }

    /// One mutation; whether it was recorded.
    #[inline(always)]
    pub fn mutate<W: Terrain<Place = P>>(&mut self, terrain: &mut W, rule: Rule) -> bool {
        let random = &mut self.random;
        let eager = rule == Rule::Eager;
        let place = if eager && random.uniform() < ANYWHERE {
            terrain.anywhere(random)
        } else {
            terrain.near(self.place, random)
        };
        let gain = terrain.gain(place);
        let positive = gain.energy > 0.0;
        let walks = self.energy <= 0.0 || (positive && random.uniform() <= gain.energy / self.energy);
        let records = positive && (walks || eager);
        if records {
            terrain.record(place, gain.mass);
        }
        if walks {
            (self.place, self.energy) = (place, gain.energy);
        }
        records
    }
}

/// How far a walk is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Walked {
    /// Mutations so far.
    pub mutations: u64,
    /// How many of them were recorded.
    pub recorded: u64,
}

/// Chains of one length, until a budget is spent. Where the calls of [`Self::advance`] cut it does not matter.
#[derive(Clone, Copy, Debug)]
pub struct Course<P> {
    seed: u64,
    frame: u64,
    length: u64,
    budget: u64,
    rule: Rule,
    walked: Walked,
    chain: Option<Chain<P>>,
    /// Recorded before the chain began.
    before: u64,
}

impl<P: Copy> Course<P> {
    /// `budget` mutations in chains of `length`, for frame `frame`.
    #[must_use]
    pub fn new(seed: u64, frame: u64, length: u64, budget: u64, rule: Rule) -> Self {
        Self {
            seed,
            frame,
            length: length.max(1),
            budget,
            rule,
            walked: Walked::default(),
            chain: None,
            before: 0,
        }
    }

    /// Mutations and records so far.
    #[must_use]
    pub fn walked(&self) -> Walked {
        self.walked
    }

    /// Whether the budget is spent.
    #[must_use]
    pub fn over(&self) -> bool {
        self.walked.mutations >= self.budget
    }

    /// Up to `most` mutations more.
    #[inline(always)]
    pub fn advance<W: Terrain<Place = P>>(&mut self, terrain: &mut W, most: u64) {
        let end = self.budget.min(self.walked.mutations.saturating_add(most));
        while self.walked.mutations < end {
            let (number, within) = (
                self.walked.mutations / self.length,
                self.walked.mutations % self.length,
            );
            let mut chain = match self.chain {
                Some(chain) if within > 0 => chain,
                _ => {
                    self.before = self.walked.recorded;
                    Chain::new(terrain, Random::new(self.seed, self.frame, number))
                }
            };
            let count = (self.length - within).min(end - self.walked.mutations);
            let mut recorded = 0;
            for _ in 0..count {
                recorded += u64::from(chain.mutate(terrain, self.rule));
            }
            self.walked.mutations += count;
            self.walked.recorded += recorded;
            self.chain = Some(chain);
            if within + count == self.length {
                terrain.chain_over(self.length, self.walked.recorded - self.before);
            }
        }
    }
}

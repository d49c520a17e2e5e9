//! Templates: simple fields of which a force is made, with few numbers each (Treuille et al. 2003).

use crate::words::{Named, named};
use core::fmt;
use core::ops::Range;

/// What a template does around its middle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum TemplateKind {
    /// Blows one way: a number for each axis.
    #[default]
    Wind,
    /// Turns: anticlockwise in 2D by one number; in 3D around an axis, by three.
    Vortex,
    /// Stirs by swirls that look random but are always the same: one number.
    Noise,
    /// Pulls smoke to its middle, denser smoke by more; pushes it away where negative: one number.
    Attract,
}

named!(TemplateKind { Wind = "wind", Vortex = "vortex", Noise = "noise", Attract = "attract" });

impl TemplateKind {
    /// How many numbers its amplitude has.
    #[must_use]
    pub const fn numbers(self, dims: usize) -> usize {
        match self {
            Self::Wind => dims,
            Self::Vortex => {
                if dims == 2 {
                    1
                } else {
                    3
                }
            }
            Self::Noise | Self::Attract => 1,
        }
    }

    /// Whether it acts on smoke alone: its field is multiplied by the density. What pulls all of a fluid alike to a point moves nothing.
    #[must_use]
    pub const fn on_smoke(self) -> bool {
        matches!(self, Self::Attract)
    }
}

/// Part of a force: amplitude times a field of fixed form, which fades with the distance from its middle as exp(-|x - c|^2 / (2 s^2)).
/// Its formula is that of [`force::template`](crate::force::template).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Template {
    /// The form.
    pub kind: TemplateKind,
    /// Its middle c, inside the box; of 2D the third number is not read.
    pub center: [f64; 3],
    /// Its radius s, above 0.
    pub radius: f64,
    /// The first force that it is part of: that which turns v_from.
    pub from: usize,
    /// The first that it is no part of any more; at most N, after `from`.
    pub to: usize,
    /// How many steps share an amplitude, from 1: the last of them may be fewer.
    pub interval: usize,
    /// Whether middle and radius are searched for too.
    pub moves: bool,
    /// The amplitude that a search begins with and a simulation has, in length / time^2: as many numbers as the kind has.
    pub amplitude: [f64; 3],
    /// Length of the waves that noise is made of, above 0.
    pub size: f64,
    /// Which noise it is.
    pub seed: u32,
}

/// Numbers that hold a template.
pub const PACKED: usize = 14;

impl Template {
    /// One of `kind` in all steps up to `to`, with one amplitude of 0 and waves as long as the radius.
    #[must_use]
    pub const fn new(kind: TemplateKind, center: [f64; 3], radius: f64, to: usize) -> Self {
        Self {
            kind,
            center,
            radius,
            from: 0,
            to,
            interval: to,
            moves: false,
            amplitude: [0.0; 3],
            size: radius,
            seed: 0,
        }
    }

    /// The slots of a force with so many in which it acts.
    #[must_use]
    pub fn slots(&self, slots: usize) -> Range<usize> {
        self.from..self.to.min(slots).max(self.from)
    }

    /// How many amplitudes it has where a force has so many slots.
    #[must_use]
    pub fn intervals(&self, slots: usize) -> usize {
        self.slots(slots).len().div_ceil(self.interval.max(1))
    }

    /// The interval that a force belongs to, where it acts among so many slots.
    #[must_use]
    pub fn interval_at(&self, step: usize, slots: usize) -> Option<usize> {
        let acts = self.slots(slots).contains(&step);
        acts.then(|| (step - self.from) / self.interval.max(1))
    }

    /// How many numbers are searched for: the amplitudes, then the middle and the radius where they move.
    #[must_use]
    pub fn unknowns(&self, dims: usize, slots: usize) -> usize {
        self.kind.numbers(dims) * self.intervals(slots) + if self.moves { dims + 1 } else { 0 }
    }

    /// The same where `length` is 1 and a `force` is 1.
    #[must_use]
    pub fn scaled(&self, length: f64, force: f64) -> Self {
        Self {
            center: self.center.map(|x| x / length),
            radius: self.radius / length,
            size: self.size / length,
            amplitude: self.amplitude.map(|a| a / force),
            ..*self
        }
    }

    /// All of it as numbers.
    #[must_use]
    pub fn pack(&self) -> [f64; PACKED] {
        let Self {
            center: [x, y, z],
            amplitude: [a, b, c],
            radius,
            size,
            ..
        } = *self;
        let [from, to, interval] = [self.from, self.to, self.interval].map(|step| step as f64);
        let moves = f64::from(u8::from(self.moves));
        let kind = f64::from(self.kind as u8);
        [
            kind,
            x,
            y,
            z,
            radius,
            from,
            to,
            interval,
            moves,
            a,
            b,
            c,
            size,
            f64::from(self.seed),
        ]
    }

    /// What was packed.
    #[must_use]
    pub fn unpack(
        &[
            kind,
            x,
            y,
            z,
            radius,
            from,
            to,
            interval,
            moves,
            a,
            b,
            c,
            size,
            seed,
        ]: &[f64; PACKED],
    ) -> Self {
        let [from, to, interval] = [from, to, interval].map(|step| step as usize);
        Self {
            kind: TemplateKind::ALL.get(kind as usize).copied().unwrap_or_default(),
            center: [x, y, z],
            radius,
            from,
            to,
            interval,
            moves: moves != 0.0,
            amplitude: [a, b, c],
            size,
            seed: seed as u32,
        }
    }
}

/// What is wrong with a template. Shown, it goes on after its name.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TemplateError {
    /// The method knows no templates of its kind.
    Kind {
        /// The method.
        method: &'static str,
    },
    /// Its steps are not ascending, or beyond the force.
    Steps {
        /// Forces: one for each step but the last, up to the release where there is one.
        forces: usize,
    },
    /// Its `interval` is 0.
    Interval,
    /// Its middle is outside the box.
    Outside {
        /// The axis.
        axis: usize,
        /// Where it is along that.
        given: f64,
    },
}

impl fmt::Display for TemplateError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Kind { method } => write!(
                f,
                "is of a kind that the method {method} does not know; it takes wind and vortex"
            ),
            Self::Steps { forces } => write!(
                f,
                "must act from a force to a later one; there are {forces} of them, one for each step but the last that is steered"
            ),
            Self::Interval => write!(f, "has an interval of 0 steps; it must be from 1"),
            Self::Outside { axis, given } => write!(
                f,
                "has its middle at {given} along axis {axis}, which is outside the box; move it inside"
            ),
        }
    }
}

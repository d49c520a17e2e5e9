//! Colours of levels: warm smoke on a night-dark ground, and blue to orange for differences.

/// What the 256 levels of a picture look like.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Palette {
    /// From the dark through warm greys to lit smoke.
    Smoke,
    /// From too little (blue) through right (dark) to too much (orange).
    Difference,
}

type Colour = [u8; 3];

const SMOKE: [(f32, Colour); 8] = [
    (0.00, [13, 14, 19]),
    (0.10, [26, 27, 34]),
    (0.25, [56, 54, 61]),
    (0.42, [101, 93, 92]),
    (0.60, [158, 139, 123]),
    (0.76, [208, 183, 154]),
    (0.90, [242, 224, 195]),
    (1.00, [255, 249, 236]),
];

const DIFFERENCE: [(f32, Colour); 7] = [
    (0.000, [168, 222, 255]),
    (0.200, [64, 148, 214]),
    (0.380, [30, 66, 104]),
    (0.502, [15, 16, 21]),
    (0.620, [104, 56, 24]),
    (0.800, [222, 126, 44]),
    (1.000, [255, 220, 150]),
];

/// A body.
const BODY: Colour = [112, 113, 116];

impl Palette {
    /// One colour a level.
    pub fn colours(self) -> [Colour; 256] {
        let stops: &[(f32, Colour)] = match self {
            Self::Smoke => &SMOKE,
            Self::Difference => &DIFFERENCE,
        };
        core::array::from_fn(|level| colour(stops, level as f32 / 255.0))
    }

    /// Red, green and blue of `levels` of which a body covers `parts`, 0 ..= 1.
    pub(super) fn behind(
        self,
        levels: impl Iterator<Item = u8>,
        parts: impl Iterator<Item = f32>,
    ) -> Vec<u8> {
        let colours = self.colours();
        let mixed = |(level, part): (u8, f32)| {
            let behind = colours.get(usize::from(level)).copied().unwrap_or_default();
            let mut colour = [0; 3];
            for ((colour, from), to) in colour.iter_mut().zip(behind).zip(BODY) {
                let (from, to) = (f32::from(from), f32::from(to));
                *colour = (from + part * (to - from)).round() as u8;
            }
            colour
        };
        levels.zip(parts).flat_map(mixed).collect()
    }
}

/// The level of a value -1 ..= 1.
pub(crate) fn signed(value: f32) -> u8 {
    (128.0 + value.clamp(-1.0, 1.0) * 127.0).round() as u8
}

fn colour(stops: &[(f32, Colour)], place: f32) -> Colour {
    let mut colour = [0; 3];
    for pair in stops.windows(2) {
        let [(low, from), (high, to)] = pair else { continue };
        if (*low..=*high).contains(&place) {
            let part = (place - low) / (high - low);
            colour = core::array::from_fn(|channel| {
                let (from, to) = (f32::from(from[channel]), f32::from(to[channel]));
                (from + part * (to - from)).round() as u8
            });
        }
    }
    colour
}

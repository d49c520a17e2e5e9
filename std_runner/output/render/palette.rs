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
        core::array::from_fn(|level| rounded(self.at(level as f32 / 255.0)))
    }

    /// The colour of a level 0 ..= 1, in the numbers of a byte but not rounded to one.
    pub(super) fn at(self, level: f32) -> [f32; 3] {
        let stops: &[(f32, Colour)] = match self {
            Self::Smoke => &SMOKE,
            Self::Difference => &DIFFERENCE,
        };
        let mut found = [0.0; 3];
        for pair in stops.windows(2) {
            let [(low, from), (high, to)] = pair else { continue };
            if (*low..=*high).contains(&level) {
                found = mixed(
                    from.map(f32::from),
                    to.map(f32::from),
                    (level - low) / (high - low),
                );
            }
        }
        found
    }

    /// Red, green and blue of `levels` of which a body covers `parts`, 0 ..= 1.
    pub(super) fn behind(
        self,
        levels: impl Iterator<Item = u8>,
        parts: impl Iterator<Item = f32>,
    ) -> Vec<u8> {
        let colours = self.colours();
        let seen = |(level, part): (u8, f32)| {
            let behind = colours.get(usize::from(level)).copied().unwrap_or_default();
            rounded(covered(behind.map(f32::from), part))
        };
        levels.zip(parts).flat_map(seen).collect()
    }
}

/// A colour of which a body covers a part.
pub(super) fn covered(behind: [f32; 3], part: f32) -> [f32; 3] {
    mixed(behind, BODY.map(f32::from), part)
}

fn mixed(from: [f32; 3], to: [f32; 3], part: f32) -> [f32; 3] {
    core::array::from_fn(|channel| from[channel] + part * (to[channel] - from[channel]))
}

fn rounded(colour: [f32; 3]) -> Colour {
    colour.map(|number| number.round() as u8)
}

/// The level of a value -1 ..= 1.
pub(crate) fn signed(value: f32) -> u8 {
    (128.0 + value.clamp(-1.0, 1.0) * 127.0).round() as u8
}

//! The pixels of a decoded picture.

use super::planes::Planes;

/// Colours that differ by no more than this part of the brightest level are one colour: rounding makes so much in a half
/// transparent edge.
const ONE_COLOUR: f64 = 2.5 / 255.0;

/// Pixels, row by row from the top.
pub(in crate::keyframes) struct Pixels {
    pub width: usize,
    pub height: usize,
    /// Samples of a pixel: 1 grey, 2 grey and alpha, 3 red, green and blue, 4 with alpha.
    pub channels: usize,
    pub samples: Samples,
    /// What the user should hear of the picture.
    pub note: Option<String>,
}

/// Levels as the file keeps them.
pub(in crate::keyframes) enum Samples {
    /// 8 bits, of which 255 is white.
    Narrow(Vec<u8>),
    /// 16 bits, of which 65535 is white.
    Wide(Vec<u16>),
    /// The same as pairs of bytes, the higher one first.
    Pairs(Vec<u8>),
    /// Numbers, of which 1 is white; there may be more.
    Real(Vec<f32>),
    /// The same, channel by channel.
    Planes(Planes),
}

impl Samples {
    fn get(&self, index: usize) -> f64 {
        let level = match self {
            Self::Narrow(levels) => levels.get(index).copied().map(f64::from),
            Self::Wide(levels) => levels.get(index).copied().map(f64::from),
            Self::Pairs(bytes) => {
                let pair = bytes.get(2 * index..2 * index + 2).and_then(<[u8]>::first_chunk);
                pair.map(|&pair| f64::from(u16::from_be_bytes(pair)))
            }
            Self::Real(levels) => levels.get(index).copied().map(f64::from),
            Self::Planes(planes) => planes.get(index).map(f64::from),
        };
        level.unwrap_or(0.0)
    }

    fn len(&self) -> usize {
        match self {
            Self::Narrow(levels) => levels.len(),
            Self::Wide(levels) => levels.len(),
            Self::Pairs(bytes) => bytes.len() / 2,
            Self::Real(levels) => levels.len(),
            Self::Planes(planes) => planes.len(),
        }
    }
}

/// Divides the colours of pixels of so many `channels` by their alpha, the last of them.
fn divide<T: Copy>(levels: &mut [T], channels: usize, quotient: impl Fn(T, T) -> T) {
    for pixel in levels.chunks_exact_mut(channels) {
        if let Some((&mut alpha, colours)) = pixel.split_last_mut() {
            colours
                .iter_mut()
                .for_each(|colour| *colour = quotient(*colour, alpha));
        }
    }
}

impl Pixels {
    /// Takes alpha out of colours that the file keeps multiplied by it. Where it is 0 nothing is seen, and nothing is divided.
    pub fn divide(&mut self) {
        if !self.has_alpha() {
            return;
        }
        let whole = |colour: u32, alpha: u32, top: u32| match alpha {
            0 => colour,
            alpha => ((colour * top + alpha / 2) / alpha).min(top),
        };
        match &mut self.samples {
            Samples::Narrow(levels) => divide(levels, self.channels, |colour, alpha| {
                whole(colour.into(), alpha.into(), u8::MAX.into()) as u8
            }),
            Samples::Wide(levels) => divide(levels, self.channels, |colour, alpha| {
                whole(colour.into(), alpha.into(), u16::MAX.into()) as u16
            }),
            Samples::Real(levels) => divide(levels, self.channels, |colour, alpha| {
                if alpha > 0.0 { colour / alpha } else { colour }
            }),
            // PNG is never multiplied, and planes are divided where they are read.
            Samples::Pairs(_) | Samples::Planes(_) => {}
        }
    }

    /// The level of white, and of an opaque pixel.
    pub fn top(&self) -> f64 {
        match self.samples {
            Samples::Narrow(_) => 255.0,
            Samples::Wide(_) | Samples::Pairs(_) => 65535.0,
            Samples::Real(_) | Samples::Planes(_) => 1.0,
        }
    }

    pub fn is_grey(&self) -> bool {
        self.channels < 3
    }

    fn has_alpha(&self) -> bool {
        matches!(self.channels, 2 | 4)
    }

    /// The levels of red, green, blue and alpha of pixel `index`.
    pub fn levels(&self, index: usize) -> [f64; 4] {
        let first = index * self.channels;
        let level = |sample: usize| self.samples.get(first + sample);
        let [red, green, blue] = if self.is_grey() { [0; 3] } else { [0, 1, 2] };
        let alpha = if self.has_alpha() {
            level(self.channels - 1)
        } else {
            self.top()
        };
        [level(red), level(green), level(blue), alpha]
    }

    pub fn all(&self) -> impl Iterator<Item = [f64; 4]> {
        (0..self.samples.len() / self.channels.max(1)).map(|index| self.levels(index))
    }

    /// The least and the largest level of a colour, where levels are numbers, which may be below black or above white.
    pub fn range(&self) -> Option<[f64; 2]> {
        if !matches!(self.samples, Samples::Real(_) | Samples::Planes(_)) {
            return None;
        }
        let all = self.all().flat_map(|[red, green, blue, _]| [red, green, blue]);
        Some(
            all.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], level| {
                [low.min(level), high.max(level)]
            }),
        )
    }

    /// Whether a pixel is less than opaque.
    pub fn are_transparent(&self) -> bool {
        let top = self.top();
        self.has_alpha() && self.all().any(|[.., alpha]| alpha < top)
    }

    /// Whether all pixels that can be seen well have one colour.
    pub fn are_of_one_colour(&self) -> bool {
        let densest = self.all().map(|[.., alpha]| alpha).fold(0.0, f64::max);
        let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for [red, green, blue, alpha] in self.all() {
            if alpha > 0.5 * densest {
                for (channel, level) in [red, green, blue].into_iter().enumerate() {
                    low[channel] = low[channel].min(level);
                    high[channel] = high[channel].max(level);
                }
            }
        }
        let most = ONE_COLOUR * self.top();
        low.iter().zip(high).all(|(&low, high)| !(high - low > most))
    }

    /// One number for a grey pixel, red, green and blue for one of colour: 1 is white, from the top, as they are stored. They are multiplied by
    /// alpha, since what is transparent gives no light.
    pub fn plain(&self) -> (usize, Vec<f64>) {
        let count = if self.is_grey() { 1 } else { 3 };
        let top = self.top();
        // EXR keeps colours multiplied, and where alpha is 0 they were not divided by it: there they are the light that is given.
        let multiplied = matches!(self.samples, Samples::Planes(_));
        let values = self.all().flat_map(|levels| {
            let [.., alpha] = levels;
            let share = if multiplied && !(alpha > 0.0) {
                1.0
            } else {
                alpha / top
            };
            levels
                .into_iter()
                .take(count)
                .map(move |level| level / top * share)
        });
        (count, values.collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use exr::prelude::FlatSamples;

    fn pixels(width: usize, channels: usize, samples: Samples) -> Pixels {
        Pixels {
            width,
            height: 1,
            channels,
            samples,
            note: None,
        }
    }

    /// Light is what a pixel's alpha leaves of its colour; shapes still read the colour itself.
    #[test]
    fn what_is_transparent_gives_no_light() {
        let grey = pixels(3, 2, Samples::Narrow(vec![255, 255, 255, 0, 255, 51]));
        assert_eq!(grey.plain(), (1, vec![1.0, 0.0, 0.2]));
        assert!(grey.all().all(|[red, ..]| red == 255.0));
        let opaque = pixels(1, 3, Samples::Wide(vec![65535, 0, 65535]));
        assert_eq!(opaque.plain(), (3, vec![1.0, 0.0, 1.0]));
        // Colours of EXR are multiplied in the file: as light they come out as they were stored, glow without alpha too.
        let stored = [[0.25, 0.125, 0.0, 2.0], [0.5, 0.25, 1.0, 0.0]];
        let planes = Planes {
            levels: stored.map(|plane| FlatSamples::F32(plane.to_vec())).into(),
            has_alpha: true,
            size: [4, 1],
            window: [4, 1],
            offset: [0, 0],
        };
        let smoke = pixels(4, 2, Samples::Planes(planes));
        assert_eq!(smoke.plain(), (1, vec![0.25, 0.125, 0.0, 2.0]));
        let flat: Vec<f64> = smoke.all().map(|[red, ..]| red).collect();
        assert_eq!(flat, [0.5, 0.5, 0.0, 2.0]);
    }
}

//! Priors on images. A pixel changes the terms that read it, all of which lie within a pixel of it.

use super::plane::Frame;
use crate::real::Real;
use crate::words::named;
use libm::pow;

/// Colours that pixels may gather at, at most.
pub const MOST_COLOURS: usize = 16;
/// The power of the sparse prior, and the weight of its second differences.
const SPARSE: f64 = 0.8;
const SECOND: f64 = 0.25;
/// Screens show light to this power.
const SCREEN: f64 = 2.2;

/// What is charged beside the distance from the image.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ImagePrior {
    /// Nothing.
    None,
    /// Sum of the lengths of forward differences (4.7), channel by channel.
    #[default]
    Tv,
    /// Sum of |d_x| + |d_y| (4.8).
    Atv,
    /// As `Tv`, the length taken over all channels together (4.9).
    Mtv,
    /// Sum of |d_x|^0.8 + |d_y|^0.8 + 1/4 (|d_xx|^0.8 + |d_yy|^0.8 + |d_xy|^0.8).
    Sparse,
    /// Sum over ordered pairs of 3 x 3 of |p_i^(1/2.2) - p_j^(1/2.2)|, p at least 0 (4.10).
    Gamma,
    /// `Tv`, and mu times the distance from the nearest of some colours.
    Clusters,
}

named!(ImagePrior {
    None = "none",
    Tv = "tv",
    Atv = "atv",
    Mtv = "mtv",
    Sparse = "sparse",
    Gamma = "gamma",
    Clusters = "clusters",
});

/// Colours that pixels gather at.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Clusters {
    /// How many.
    pub count: usize,
    /// The colours, of which `count` are used.
    pub colours: [[f64; 3]; MOST_COLOURS],
    /// What distance costs.
    pub mu: f64,
}

/// Which numbers of an image are thought to be others.
pub(super) trait Thought {
    /// What number `place` of the planes, which is pixel (x, y) of a channel, is thought to be; `None` where it is what it is.
    fn instead(&self, place: usize, channel: usize, at: [isize; 2]) -> Option<f64>;
}

/// One number, and what it is thought to be.
#[derive(Clone, Copy)]
struct One {
    place: usize,
    value: f64,
}

impl Thought for One {
    #[inline(always)]
    fn instead(&self, place: usize, _channel: usize, _at: [isize; 2]) -> Option<f64> {
        (place == self.place).then_some(self.value)
    }
}

/// An image with its border, of which some numbers may be thought to be others.
#[derive(Clone, Copy)]
pub(super) struct Seen<'a, T, C> {
    planes: &'a [T],
    wide: usize,
    high: usize,
    channels: usize,
    thought: C,
}

impl<'a, T: Real, C: Thought> Seen<'a, T, C> {
    #[inline(always)]
    pub fn of(frame: &Frame, planes: &'a [T], thought: C) -> Self {
        Self {
            planes,
            wide: frame.wide(),
            high: frame.high(),
            channels: frame.channels,
            thought,
        }
    }

    /// Pixel (x, y) of a channel; nothing beyond the border.
    #[inline(always)]
    fn get(&self, channel: usize, x: isize, y: isize) -> Option<f64> {
        if x < 0 || y < 0 || x as usize >= self.wide || y as usize >= self.high {
            return None;
        }
        let place = (channel * self.high + y as usize) * self.wide + x as usize;
        let instead = self.thought.instead(place, channel, [x, y]);
        instead.or_else(|| self.planes.get(place).map(|value| value.to_f64()))
    }

    /// The forward differences at (x, y), 0 at the far edges.
    #[inline(always)]
    fn ahead(&self, channel: usize, x: isize, y: isize) -> Option<[f64; 2]> {
        let here = self.get(channel, x, y)?;
        let to = |x, y| self.get(channel, x, y).map_or(0.0, |there| there - here);
        Some([to(x + 1, y), to(x, y + 1)])
    }

    /// Squares of the forward differences.
    #[inline(always)]
    pub fn steep(&self, channel: usize, x: isize, y: isize) -> f64 {
        let squares = self.ahead(channel, x, y).map(|[dx, dy]| dx * dx + dy * dy);
        squares.unwrap_or_default()
    }

    fn sparse(&self, channel: usize, x: isize, y: isize) -> f64 {
        let Some(here) = self.get(channel, x, y) else {
            return 0.0;
        };
        let power = |x: f64| if x == 0.0 { 0.0 } else { pow(x.abs(), SPARSE) };
        let second = |before: Option<f64>, after: Option<f64>| match (before, after) {
            (Some(before), Some(after)) => power(before - 2.0 * here + after),
            _ => 0.0,
        };
        let at = |dx: isize, dy: isize| self.get(channel, x + dx, y + dy);
        let [dx, dy] = self.ahead(channel, x, y).unwrap_or_default();
        let mixed = match (at(1, 0), at(0, 1), at(1, 1)) {
            (Some(right), Some(down), Some(both)) => power(both - right - down + here),
            _ => 0.0,
        };
        power(dx) + power(dy) + SECOND * (second(at(-1, 0), at(1, 0)) + second(at(0, -1), at(0, 1)) + mixed)
    }

    pub fn far(&self, clusters: &Clusters, x: isize, y: isize) -> f64 {
        let mut colour = [0.0; 3];
        for (channel, level) in colour.iter_mut().enumerate().take(self.channels) {
            *level = self.get(channel, x, y).unwrap_or_default();
        }
        let used = clusters.colours.iter().take(clusters.count);
        let least = used
            .map(|other| {
                let parts = colour.iter().zip(other).take(self.channels);
                parts
                    .map(|(one, other)| (one - other) * (one - other))
                    .sum::<f64>()
            })
            .fold(f64::INFINITY, f64::min);
        if least.is_finite() {
            clusters.mu * Real::sqrt(least)
        } else {
            0.0
        }
    }

    /// The terms at (x, y).
    pub fn term(&self, prior: ImagePrior, clusters: &Clusters, channel: usize, x: isize, y: isize) -> f64 {
        let differences = match prior {
            ImagePrior::None => 0.0,
            ImagePrior::Tv | ImagePrior::Clusters => Real::sqrt(self.steep(channel, x, y)),
            ImagePrior::Atv => self
                .ahead(channel, x, y)
                .map_or(0.0, |[dx, dy]| dx.abs() + dy.abs()),
            ImagePrior::Mtv => Real::sqrt(
                (0..self.channels)
                    .map(|channel| self.steep(channel, x, y))
                    .sum::<f64>(),
            ),
            ImagePrior::Sparse => self.sparse(channel, x, y),
            ImagePrior::Gamma => self.shown(channel, x, y),
        };
        // The distance from colours is counted with the first channel.
        if prior == ImagePrior::Clusters && channel == 0 {
            differences + self.far(clusters, x, y)
        } else {
            differences
        }
    }

    /// Sum over the 8 neighbours of the differences on a screen.
    fn shown(&self, channel: usize, x: isize, y: isize) -> f64 {
        let Some(here) = self.get(channel, x, y).map(screen) else {
            return 0.0;
        };
        let mut sum = 0.0;
        for dy in -1..=1 {
            for dx in -1..=1 {
                if (dx, dy) != (0, 0)
                    && let Some(there) = self.get(channel, x + dx, y + dy)
                {
                    sum += (screen(there) - here).abs();
                }
            }
        }
        sum
    }

    /// Gamma of the whole image.
    fn whole(&self, prior: ImagePrior, clusters: &Clusters) -> f64 {
        let channels = if prior == ImagePrior::Mtv {
            1
        } else {
            self.channels
        };
        let mut sum = 0.0;
        for channel in 0..channels {
            for place in 0..self.wide * self.high {
                let (x, y) = ((place % self.wide) as isize, (place / self.wide) as isize);
                sum += self.term(prior, clusters, channel, x, y);
            }
        }
        sum
    }
}

impl<T: Real> Seen<'_, T, One> {
    /// The sum of all terms that read the number that is replaced.
    fn local(&self, prior: ImagePrior, clusters: &Clusters) -> f64 {
        let plane = self.wide * self.high;
        let (channel, within) = (
            self.thought.place / plane.max(1),
            self.thought.place % plane.max(1),
        );
        let (x, y) = ((within % self.wide) as isize, (within / self.wide) as isize);
        let term = |dx: isize, dy: isize| self.term(prior, clusters, channel, x + dx, y + dy);
        match prior {
            ImagePrior::None => 0.0,
            ImagePrior::Tv | ImagePrior::Atv | ImagePrior::Mtv => term(0, 0) + term(-1, 0) + term(0, -1),
            ImagePrior::Clusters => {
                // Of its neighbours the differences alone: their own colours stay.
                let beside = |dx, dy| Real::sqrt(self.steep(channel, x + dx, y + dy));
                beside(0, 0) + beside(-1, 0) + beside(0, -1) + self.far(clusters, x, y)
            }
            ImagePrior::Sparse => {
                let all = (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| (dx, dy)));
                all.map(|(dx, dy)| term(dx, dy)).sum()
            }
            // Each pair is counted from both of its pixels.
            ImagePrior::Gamma => 2.0 * self.shown(channel, x, y),
        }
    }
}

/// Gamma of an image with its border, planes of the channels one after the other.
#[must_use]
pub fn whole<T: Real>(prior: ImagePrior, clusters: &Clusters, frame: &Frame, planes: &[T]) -> f64 {
    let nothing = One {
        place: usize::MAX,
        value: 0.0,
    };
    Seen::of(frame, planes, nothing).whole(prior, clusters)
}

/// By how much Gamma changes where number `place` of the planes becomes `mass` more, and where it becomes so much less.
#[inline(always)]
#[must_use]
pub fn change<T: Real>(
    prior: ImagePrior,
    clusters: &Clusters,
    frame: &Frame,
    planes: &[T],
    place: usize,
    mass: f64,
) -> [f64; 2] {
    if prior == ImagePrior::None {
        return [0.0; 2];
    }
    let value = planes.get(place).map_or(0.0, |value| value.to_f64());
    let local = |value| Seen::of(frame, planes, One { place, value }).local(prior, clusters);
    let before = local(value);
    [local(value + mass) - before, local(value - mass) - before]
}

fn screen(light: f64) -> f64 {
    if light > 0.0 {
        pow(light, 1.0 / SCREEN)
    } else {
        0.0
    }
}

//! Levels channel by channel, as EXR has them.

use exr::prelude::FlatSamples;

/// Levels of the channels one after the other, of a layer that a window shows.
pub(in crate::keyframes) struct Planes {
    pub levels: Vec<FlatSamples>,
    /// Whether the last one is alpha.
    pub has_alpha: bool,
    pub size: [usize; 2],
    pub window: [usize; 2],
    /// Where in the window the layer begins.
    pub offset: [i64; 2],
}

impl Planes {
    /// How many levels the window shows.
    pub fn len(&self) -> usize {
        self.window[0] * self.window[1] * self.levels.len()
    }

    /// Level `index`, pixel by pixel; what lies beside the layer is 0. Alpha is taken out of the colours: EXR keeps them multiplied by it.
    pub fn get(&self, index: usize) -> Option<f32> {
        let (pixel, channel) = (index.checked_div(self.levels.len())?, index % self.levels.len());
        let [x, y] = [pixel % self.window[0], pixel / self.window[0]];
        let along = |axis: usize, place: usize| {
            let place = usize::try_from(place as i64 - self.offset[axis]).ok();
            place.filter(|&place| place < self.size[axis])
        };
        let (Some(x), Some(y)) = (along(0, x), along(1, y)) else {
            return Some(0.0);
        };
        let of = |channel: usize| {
            self.levels
                .get(channel)
                .map(|plane| level(plane, y * self.size[0] + x))
        };
        let last = self.levels.len() - 1;
        let found = of(channel)?;
        Some(match of(last) {
            Some(alpha) if self.has_alpha && channel < last && alpha > 0.0 => found / alpha,
            _ => found,
        })
    }
}

fn level(samples: &FlatSamples, index: usize) -> f32 {
    let level = match samples {
        FlatSamples::F16(all) => all.get(index).map(|level| level.to_f32()),
        FlatSamples::F32(all) => all.get(index).copied(),
        FlatSamples::U32(all) => all.get(index).map(|&level| level as f32),
    };
    level.unwrap_or(0.0)
}

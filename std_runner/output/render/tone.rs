//! From light to what a screen shows.

/// One linear colour as a film takes it, 0 ..= 1 and coded as sRGB. The curve is Narkowicz's fit of the ACES film (2016).
pub(super) fn developed(light: [f32; 3]) -> [f32; 3] {
    light.map(|light| {
        let light = 0.8 * light.max(0.0);
        let shown = light * (2.51 * light + 0.03) / (light * (2.43 * light + 0.59) + 0.14);
        coded(shown)
    })
}

/// sRGB's code of a linear value, 0 ..= 1 both.
pub(super) fn coded(value: f32) -> f32 {
    let value = value.clamp(0.0, 1.0);
    if value <= 0.003_130_8 {
        12.92 * value
    } else {
        1.055 * value.powf(1.0 / 2.4) - 0.055
    }
}

/// The linear value of a code of sRGB.
pub(super) fn linear(code: f32) -> f32 {
    if code <= 0.040_45 {
        code / 12.92
    } else {
        ((code + 0.055) / 1.055).powf(2.4)
    }
}

/// A number 0 .. 1 for each pixel, the same at every time, spread evenly among neighbours: Jimenez's gradient noise (2014).
pub(super) fn scatter(column: usize, row: usize) -> f32 {
    let place = 0.067_110_56 * column as f32 + 0.005_837_15 * row as f32;
    (52.982_918 * place.fract()).fract()
}

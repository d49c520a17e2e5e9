//! Images of our own, which stand in for the thesis' photographs: in linear light, planes of the channels one after the other.

/// Places along a side of a pixel whose mean it is.
const FINE: usize = 4;

/// An image with the surroundings that light comes from.
pub(super) struct Sharp {
    /// Pixels across and down without the border, and the border.
    pub side: usize,
    pub border: usize,
    /// Planes with the border.
    pub planes: Vec<f64>,
}

impl Sharp {
    /// What `light` has at each place, x and y from 0 to 1 in the image and beyond it in its border.
    pub fn draw(side: usize, border: usize, channels: usize, light: impl Fn(usize, f64, f64) -> f64) -> Self {
        let wide = side + 2 * border;
        let at = |place: usize| ((place as f64 + 0.5) / FINE as f64 - border as f64) / side as f64;
        let pixel = |index: usize| {
            let (channel, rest) = (index / (wide * wide), index % (wide * wide));
            let part = |part: usize| {
                light(
                    channel,
                    at(rest % wide * FINE + part % FINE),
                    at(rest / wide * FINE + part / FINE),
                )
            };
            (0..FINE * FINE).map(part).sum::<f64>() / (FINE * FINE) as f64
        };
        Self {
            side,
            border,
            planes: (0..channels * wide * wide).map(pixel).collect(),
        }
    }

    /// The planes without their border.
    pub fn inner(&self) -> Vec<f64> {
        let wide = self.side + 2 * self.border;
        let inside = |index: &usize| {
            let (x, y) = (index % wide, index / wide % wide);
            let range = self.border..self.border + self.side;
            range.contains(&x) && range.contains(&y)
        };
        let all = (0..self.planes.len()).filter(inside);
        all.filter_map(|index| self.planes.get(index).copied()).collect()
    }
}

/// Flat shapes, and stripes finer than a kernel.
pub(super) fn shapes(_: usize, x: f64, y: f64) -> f64 {
    if (x * 40.0).floor().rem_euclid(3.0) == 0.0 && (0.55..0.62).contains(&y) && (0.05..0.45).contains(&x) {
        1.0
    } else if x < 0.25 && (0.65..0.92).contains(&y) {
        0.05
    } else if (x - 0.65).abs() + (y - 0.7).abs() < 0.2 {
        0.95
    } else if (0.55..0.9).contains(&x) && (0.1..0.4).contains(&y) {
        0.5
    } else if (x - 0.3).hypot(y - 0.35) < 0.2 {
        0.8
    } else {
        0.2
    }
}

/// Lines of all directions and sizes, as of rails, wheels and wires.
pub(super) fn strokes(_: usize, x: f64, y: f64) -> f64 {
    let wheel = |cx: f64, cy: f64, radius: f64| {
        let (dx, dy) = (x - cx, y - cy);
        let far = dx.hypot(dy);
        let spoke = (dy.atan2(dx) * 5.0).sin().abs() < 0.16 && far < radius;
        spoke || (far - radius).abs() < 0.014
    };
    if wheel(0.26, 0.66, 0.17) || wheel(0.7, 0.7, 0.13) {
        0.92
    } else if (y - 0.9).abs() < 0.012
        || ((x * 24.0).floor().rem_euclid(2.0) == 0.0 && (0.92..0.96).contains(&y))
    {
        0.75
    } else if (0.12..0.86).contains(&x) && (0.3..0.5).contains(&y) {
        let window = (x * 9.0).fract() > 0.45 && (0.34..0.43).contains(&y);
        if window { 0.85 } else { 0.34 }
    } else if (y - 0.16 - 0.05 * (7.0 * x).sin()).abs() < 0.007 || (y - 0.08 - 0.2 * x).abs() < 0.005 {
        0.03
    } else {
        0.12 + 0.25 * (1.0 - y)
    }
}

/// A street at night: lamps that burn out, reflections, dark walls.
pub(super) fn lights(_: usize, x: f64, y: f64) -> f64 {
    let lamp = |cx: f64, cy: f64, radius: f64| ((x - cx).hypot(y - cy) < radius).then_some(3.0);
    let lamps = [
        (0.2, 0.25, 0.012),
        (0.34, 0.31, 0.01),
        (0.46, 0.35, 0.008),
        (0.8, 0.3, 0.014),
        (0.62, 0.62, 0.02),
        (0.74, 0.62, 0.02),
    ];
    let lit = lamps
        .into_iter()
        .find_map(|(cx, cy, radius)| lamp(cx, cy, radius));
    let body = (0.56..0.8).contains(&x) && (0.54..0.68).contains(&y);
    let window = (0.6..0.76).contains(&x) && (0.5..0.54).contains(&y);
    let wall = x < 0.14 || (x < 0.5 && y < 0.16) || (x > 0.88 && y < 0.7);
    let brick = (y * 30.0).fract() < 0.2 || ((x * 20.0 + 0.5 * (y * 30.0).floor()).fract() < 0.15);
    let stripe = (y - 0.8).abs() < 0.01 && (x * 7.0).fract() < 0.5;
    lit.unwrap_or(if stripe {
        0.6
    } else if window {
        0.3
    } else if body {
        0.2
    } else if wall && brick {
        0.05
    } else if wall {
        0.12
    } else if y > 0.7 {
        0.08
    } else {
        0.02
    })
}

/// Jets of spray before a dark ground: many sizes, no edges.
pub(super) fn plumes(_: usize, x: f64, y: f64) -> f64 {
    let jet = |cx: f64, wide: f64, high: f64, turn: f64| {
        let up = (0.92 - y) / high;
        if !(0.0..1.0).contains(&up) {
            return 0.0;
        }
        let middle = cx + 0.06 * (turn + 5.0 * up).sin() * up;
        let spread = wide * (0.3 + up);
        let across = (x - middle) / spread;
        let grain = 0.5 + 0.5 * ((90.0 * (x + 0.3 * up * up) + turn).sin() * (70.0 * y + 9.0 * x).cos());
        (-across * across).exp() * (1.0 - up) * (0.45 + 0.55 * grain)
    };
    let light = jet(0.3, 0.07, 0.7, 0.3) + jet(0.52, 0.09, 0.85, 1.9) + jet(0.74, 0.06, 0.6, 4.0);
    (0.04 + 0.9 * light).min(1.0)
}

/// Five colours.
pub(super) fn colours(channel: usize, x: f64, y: f64) -> f64 {
    const FIVE: [[f64; 3]; 5] = [
        [0.85, 0.8, 0.65],
        [0.7, 0.08, 0.06],
        [0.05, 0.25, 0.5],
        [0.9, 0.6, 0.05],
        [0.03, 0.04, 0.05],
    ];
    let petal = ((y - 0.42).atan2(x - 0.5) * 3.0).cos();
    let far = (x - 0.5).hypot(y - 0.42);
    let which = if far < 0.07 {
        3
    } else if far < 0.2 + 0.12 * petal {
        1
    } else if (x - 0.5).abs() < 0.012 && y > 0.42 {
        4
    } else if y > 0.74 + 0.05 * (13.0 * x).sin() {
        2
    } else if ((x * 12.0).fract() - 0.5).hypot((y * 12.0).fract() - 0.5) < 0.16 {
        3
    } else {
        0
    };
    FIVE.get(which)
        .and_then(|colour| colour.get(channel))
        .copied()
        .unwrap_or_default()
}

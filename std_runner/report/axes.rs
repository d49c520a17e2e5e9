//! The axes of a chart: from values to pixels, and the ticks.

use super::words::number;

pub(super) const WIDTH: f64 = 560.0;
pub(super) const HEIGHT: f64 = 300.0;
pub(super) const LEFT: f64 = 62.0;
pub(super) const RIGHT: f64 = 14.0;
pub(super) const TOP: f64 = 12.0;
pub(super) const BOTTOM: f64 = 46.0;

/// Labels of whole numbers fit beside each other as long as they are no more; and those of large ones.
const MOST_MARKS: (f64, f64) = (9.0, 5.0);
/// From where on a number is large.
const LARGE: f64 = 1e5;

/// What the horizontal axis counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scale {
    /// Whole numbers, evenly.
    Counts,
    /// Powers of ten.
    Logarithmic,
}

/// Where values go.
pub(super) struct Axes {
    scale: Scale,
    /// Powers of ten where the scale is logarithmic.
    x: (f64, f64),
    /// Powers of ten.
    y: (f64, f64),
}

impl Axes {
    /// Axes that hold all `points`; `None` if there are none.
    pub fn of(points: &[(f64, f64)], scale: Scale) -> Option<Self> {
        let range = |values: &mut dyn Iterator<Item = f64>| {
            values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| {
                (low.min(x), high.max(x))
            })
        };
        let widened = |(low, high): (f64, f64)| {
            let room = (0.06 * (high - low)).max(0.1);
            (low - room, high + room)
        };
        if points.is_empty() {
            return None;
        }
        let y = widened(range(&mut points.iter().map(|point| point.1.log10())));
        let x = match scale {
            Scale::Logarithmic => widened(range(&mut points.iter().map(|point| point.0.log10()))),
            Scale::Counts => {
                let (low, high) = range(&mut points.iter().map(|point| point.0));
                if high - low < 1.0 {
                    (low - 0.5, high + 0.5)
                } else {
                    (low, high)
                }
            }
        };
        Some(Self { scale, x, y })
    }

    /// Pixels of a point.
    pub fn place(&self, (x, y): (f64, f64)) -> (f64, f64) {
        let x = if self.scale == Scale::Logarithmic {
            x.log10()
        } else {
            x
        };
        let across = (x - self.x.0) / (self.x.1 - self.x.0);
        let above = (y.log10() - self.y.0) / (self.y.1 - self.y.0);
        (
            LEFT + across * (WIDTH - LEFT - RIGHT),
            HEIGHT - BOTTOM - above * (HEIGHT - TOP - BOTTOM),
        )
    }
}

/// Lines, ticks and labels.
pub(super) fn grid(axes: &Axes) -> String {
    let (right, bottom) = (WIDTH - RIGHT, HEIGHT - BOTTOM);
    let mut svg = String::new();
    for (value, label) in levels(axes.y) {
        let (_, y) = axes.place((1.0, value));
        svg.push_str(&format!(
            "<line class=\"grid\" x1=\"{LEFT}\" y1=\"{y:.1}\" x2=\"{right}\" y2=\"{y:.1}\"/>"
        ));
        svg.push_str(&format!(
            "<text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\">{label}</text>",
            LEFT - 8.0,
            y + 4.0
        ));
    }
    let marks = match axes.scale {
        Scale::Logarithmic => levels(axes.x),
        Scale::Counts => whole_numbers(axes.x)
            .into_iter()
            .map(|value| (value, value.to_string()))
            .collect(),
    };
    for (value, label) in marks {
        let (x, _) = axes.place((value, 1.0));
        svg.push_str(&format!(
            "<line class=\"tick\" x1=\"{x:.1}\" y1=\"{bottom}\" x2=\"{x:.1}\" y2=\"{}\"/>",
            bottom + 5.0
        ));
        svg.push_str(&format!(
            "<text x=\"{x:.1}\" y=\"{}\" text-anchor=\"middle\">{label}</text>",
            bottom + 18.0
        ));
    }
    svg.push_str(&format!(
        "<line class=\"frame\" x1=\"{LEFT}\" y1=\"{bottom}\" x2=\"{right}\" y2=\"{bottom}\"/>"
    ));
    svg
}

/// Round values on a logarithmic axis with their labels: powers of ten, or finer ones if few of them fit.
fn levels((low, high): (f64, f64)) -> Vec<(f64, String)> {
    let powers = high.floor() - low.ceil() + 1.0;
    if powers >= 3.0 {
        let every = (powers / 6.0).ceil() as i64;
        let powers = (low.ceil() as i64..=high.floor() as i64).filter(|power| power.rem_euclid(every) == 0);
        return powers
            .map(|power| (10_f64.powi(power as i32), power_label(power)))
            .collect();
    }
    let within = |value: f64| (low..=high).contains(&value.log10());
    let decades = low.floor() as i32..=high.floor() as i32;
    let fine: Vec<f64> = decades
        .flat_map(|power| [1.0, 2.0, 5.0].map(|digit| digit * 10_f64.powi(power)))
        .filter(|&value| within(value))
        .collect();
    let chosen = if fine.len() >= 2 {
        fine
    } else {
        evenly(10_f64.powf(low), 10_f64.powf(high))
    };
    chosen.into_iter().map(|value| (value, number(value))).collect()
}

/// 1, 2 or 5 times a power of ten apart.
fn evenly(low: f64, high: f64) -> Vec<f64> {
    let rough = (high - low) / 3.0;
    let power = 10_f64.powf(rough.log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0]
        .into_iter()
        .map(|digit| digit * power)
        .find(|&step| step >= rough)
        .unwrap_or(rough);
    if !(step > 0.0 && step.is_finite()) {
        // Numbers so small that their differences are rounded away.
        return vec![low];
    }
    let first = (low / step).ceil() as i64;
    (first..)
        .map(|index| index as f64 * step)
        .take_while(|&value| value <= high)
        .take(8)
        .collect()
}

fn whole_numbers((low, high): (f64, f64)) -> Vec<f64> {
    // 1, 2 or 5 times a power of ten apart, so that labels have room.
    let steps = (0..15).flat_map(|power| [1.0, 2.0, 5.0].map(|digit| digit * 10_f64.powi(power)));
    let most = if high >= LARGE { MOST_MARKS.1 } else { MOST_MARKS.0 };
    let step = { steps }.find(|step| (high - low) / step <= most);
    let step = step.unwrap_or(high - low);
    let first = (low / step).ceil() as i64;
    (first..)
        .map(|index| index as f64 * step)
        .take_while(|&value| value <= high)
        .collect()
}

fn power_label(power: i64) -> String {
    match power {
        -2 => "0.01".into(),
        -1 => "0.1".into(),
        0 => "1".into(),
        1 => "10".into(),
        2 => "100".into(),
        power => format!(
            "10<tspan dy=\"-5\" class=\"power\">{}</tspan>",
            power.to_string().replace('-', "\u{2212}")
        ),
    }
}

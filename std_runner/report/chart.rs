//! A line chart as inline SVG, with ticks at round numbers.

use super::words::{escape, number};

const WIDTH: f64 = 560.0;
const HEIGHT: f64 = 300.0;
const LEFT: f64 = 62.0;
const RIGHT: f64 = 14.0;
const TOP: f64 = 12.0;
const BOTTOM: f64 = 46.0;
/// Curves of more points are drawn without dots.
const MOST_DOTS: usize = 60;
/// Colours of a figure outside the page.
const FILE_STYLE: &str = include_str!("chart.css");

/// A named curve, in pieces where it is interrupted.
pub struct Curve {
    /// Beside its end.
    pub name: String,
    /// 1 ..= 4: which of the page's colours; 5, for a bound, is dashed and only in files.
    pub colour: usize,
    /// Its points, in order.
    pub pieces: Vec<Vec<(f64, f64)>>,
}

impl Curve {
    /// An uninterrupted curve.
    pub fn new(name: impl Into<String>, colour: usize, points: impl Iterator<Item = (f64, f64)>) -> Self {
        Self {
            name: name.into(),
            colour,
            pieces: vec![points.collect()],
        }
    }

    fn last(&self) -> Option<f64> {
        self.pieces
            .last()
            .and_then(|piece| piece.last())
            .map(|point| point.1)
    }
}

/// What the horizontal axis counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scale {
    /// Whole numbers, evenly.
    Counts,
    /// Powers of ten.
    Logarithmic,
}

/// Curves; the vertical axis is logarithmic.
pub struct Chart {
    /// What it shows.
    pub title: &'static str,
    /// Below the title, if it is not empty.
    pub note: &'static str,
    /// What the horizontal axis counts.
    pub across: &'static str,
    /// How it counts.
    pub scale: Scale,
    /// The curves.
    pub curves: Vec<Curve>,
}

/// Where values go.
struct Axes {
    scale: Scale,
    /// Powers of ten where the scale is logarithmic.
    x: (f64, f64),
    /// Powers of ten.
    y: (f64, f64),
}

impl Axes {
    fn of(points: &[(f64, f64)], scale: Scale) -> Option<Self> {
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

    fn place(&self, (x, y): (f64, f64)) -> (f64, f64) {
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

impl Chart {
    /// A figure: title, legend with the last values, curves.
    pub fn to_html(&self) -> String {
        let legend: String = self.curves.iter().map(legend_entry).collect();
        format!(
            "<figure class=\"chart\"><figcaption><h3>{}</h3><p>{}</p></figcaption><ul class=\"legend\">{legend}</ul>{}</figure>\n",
            escape(self.title),
            escape(self.note),
            self.svg()
        )
    }

    /// The figure as a file of its own, with its legend and colours in it.
    pub fn to_svg(&self) -> String {
        let mut legend = String::new();
        let (mut x, apart) = (RIGHT, (WIDTH - 2.0 * RIGHT) / self.curves.len() as f64);
        for curve in &self.curves {
            let text = format!("{} {}", curve.name, curve.last().map(number).unwrap_or_default());
            let (line, words) = (x + 18.0, x + 24.0);
            legend.push_str(&format!(
                "<polyline class=\"c{}\" points=\"{x:.0},-14 {line:.0},-14\"/>",
                curve.colour
            ));
            legend.push_str(&format!(
                "<text x=\"{words:.0}\" y=\"-10\">{}</text>",
                escape(&text)
            ));
            x += apart;
        }
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 -30 {WIDTH} {}\" font-family=\"sans-serif\"><style>{FILE_STYLE}</style>\
             <rect x=\"0\" y=\"-30\" width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>{legend}{}</svg>\n",
            HEIGHT + 30.0,
            self.drawing().unwrap_or_default()
        )
    }

    fn svg(&self) -> String {
        match self.drawing() {
            Some(drawing) => format!(
                "<svg viewBox=\"0 0 {WIDTH} {HEIGHT}\" role=\"img\" aria-label=\"{}\">{drawing}</svg>",
                escape(self.title)
            ),
            None => "<p class=\"nothing\">There is nothing to draw yet.</p>".into(),
        }
    }

    /// Axes and curves, if there is anything to draw.
    fn drawing(&self) -> Option<String> {
        let points: Vec<(f64, f64)> = self
            .curves
            .iter()
            .flat_map(|curve| curve.pieces.iter().flatten())
            .filter(|point| self.drawable(point))
            .copied()
            .collect();
        let axes = Axes::of(&points, self.scale)?;
        let mut svg = grid(&axes);
        for curve in &self.curves {
            let dots = curve.pieces.iter().map(Vec::len).sum::<usize>() <= MOST_DOTS;
            for piece in &curve.pieces {
                for part in piece.split(|point| !self.drawable(point)) {
                    svg.push_str(&line(&axes, part, curve.colour, dots || piece.len() == 1));
                }
            }
        }
        let middle = LEFT + 0.5 * (WIDTH - LEFT - RIGHT);
        svg.push_str(&format!(
            "<text class=\"axis\" x=\"{middle:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{}</text>",
            HEIGHT - 8.0,
            escape(self.across)
        ));
        Some(svg)
    }

    /// Whether the axes have a place for `point`.
    fn drawable(&self, point: &(f64, f64)) -> bool {
        let across = point.0.is_finite() && (self.scale == Scale::Counts || point.0 > 0.0);
        across && point.1.is_finite() && point.1 > 0.0
    }
}

fn legend_entry(curve: &Curve) -> String {
    let last = curve.last().map(number).unwrap_or_default();
    format!(
        "<li class=\"c{}\">{} <b>{last}</b></li>",
        curve.colour,
        escape(&curve.name)
    )
}

/// A piece of a curve all of whose points can be drawn.
fn line(axes: &Axes, points: &[(f64, f64)], colour: usize, dots: bool) -> String {
    let mut svg = String::new();
    let places: Vec<(f64, f64)> = points.iter().map(|&point| axes.place(point)).collect();
    let path: Vec<String> = places.iter().map(|(x, y)| format!("{x:.1},{y:.1}")).collect();
    if places.len() > 1 {
        svg.push_str(&format!(
            "<polyline class=\"c{colour}\" points=\"{}\"/>",
            path.join(" ")
        ));
    }
    if dots {
        svg.extend(
            places
                .iter()
                .map(|(x, y)| format!("<circle class=\"c{colour}\" cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"2.2\"/>")),
        );
    }
    svg
}

fn grid(axes: &Axes) -> String {
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
    let first = (low / step).ceil() as i64;
    (first..)
        .map(|index| index as f64 * step)
        .take_while(|&value| value <= high)
        .take(8)
        .collect()
}

fn whole_numbers((low, high): (f64, f64)) -> Vec<f64> {
    let step = [1, 2, 5, 10, 20, 50, 100, 200, 500, 1000]
        .into_iter()
        .find(|&step| (high - low) / f64::from(step) <= 9.0)
        .unwrap_or(5000);
    let first = (low / f64::from(step)).ceil() as i64;
    (first..)
        .map(|index| index as f64 * f64::from(step))
        .take_while(|&value| value <= high)
        .take(50)
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

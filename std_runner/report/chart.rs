//! A line chart as inline SVG, with ticks at round values.

use super::axes::{Axes, HEIGHT, LEFT, RIGHT, Scale, WIDTH, grid};
use super::words::{escape, number};

/// Curves of more points are drawn without dots.
const MOST_DOTS: usize = 60;
/// Colours of a figure outside the page.
const FILE_STYLE: &str = include_str!("chart.css");

/// A named curve, in pieces where it is interrupted.
#[derive(Clone)]
pub struct Curve {
    /// Name in the legend.
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

    /// One of the points whose value is above 0, which is what a logarithmic axis can show.
    pub(crate) fn above_zero(
        name: &str,
        colour: usize,
        points: impl Iterator<Item = (f64, Option<f64>)>,
    ) -> Self {
        let there = points.filter_map(|(at, value)| Some((at, value.filter(|&value| value > 0.0)?)));
        Self::new(name, colour, there)
    }

    /// Whether there is nothing to draw.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.pieces.iter().all(Vec::is_empty)
    }

    fn last(&self) -> Option<f64> {
        self.pieces
            .last()
            .and_then(|piece| piece.last())
            .map(|point| point.1)
    }
}

/// Curves; the vertical axis is logarithmic.
#[derive(Clone)]
pub struct Chart {
    /// Title above the chart.
    pub title: &'static str,
    /// Below the title, if it is not empty.
    pub note: String,
    /// What the horizontal axis counts.
    pub across: &'static str,
    /// How it counts.
    pub scale: Scale,
    /// Curves, in the order of the legend.
    pub curves: Vec<Curve>,
}

impl Chart {
    /// The curves that are not empty over counts of what `across` names; nothing where all are.
    pub(crate) fn of_counts(
        title: &'static str,
        note: &str,
        across: &'static str,
        mut curves: Vec<Curve>,
    ) -> Option<Self> {
        curves.retain(|curve| !curve.is_empty());
        (!curves.is_empty()).then(|| Self {
            title,
            note: note.into(),
            across,
            scale: Scale::Counts,
            curves,
        })
    }

    /// A figure: title, legend with the last values, curves.
    pub fn to_html(&self) -> String {
        let legend: String = self.curves.iter().map(legend_entry).collect();
        format!(
            "<figure class=\"chart\"><figcaption><h3>{}</h3><p>{}</p></figcaption><ul class=\"legend\">{legend}</ul>{}</figure>\n",
            escape(self.title),
            escape(&self.note),
            self.svg()
        )
    }

    /// The figure as a file of its own, with its legend and colours in it.
    pub fn to_svg(&self) -> String {
        let mut legend = String::new();
        let mut x = RIGHT;
        let apart = (WIDTH - 2.0 * RIGHT) / self.curves.len() as f64;
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

//! The templates of a result, as a table of the page and in lines for a terminal.

use super::found::TemplateRecord;
use super::words::number;

/// Numbers side by side.
fn list(numbers: &[f64]) -> String {
    numbers.iter().map(|&x| number(x)).collect::<Vec<_>>().join(", ")
}

impl TemplateRecord {
    /// The steps that share an amplitude, and that.
    fn intervals(&self) -> impl Iterator<Item = (String, String)> {
        let steps = (self.from..self.to).step_by(self.interval.max(1));
        steps.zip(&self.amplitude).map(|(first, amplitude)| {
            let last = (first + self.interval).min(self.to) - 1;
            (format!("{first} to {last}"), list(amplitude))
        })
    }
}

/// A table with a row for each amplitude; nothing where there are no templates.
pub(super) fn table(templates: &[TemplateRecord]) -> String {
    let rows: String = templates.iter().enumerate().map(rows).collect();
    if rows.is_empty() {
        return rows;
    }
    let head: String = ["Template", "Center", "Radius", "Steps", "Amplitude"]
        .iter()
        .map(|name| format!("<th>{name}</th>"))
        .collect();
    format!(
        "<div class=\"scroll\"><table class=\"figures\"><thead><tr>{head}</tr></thead><tbody>{rows}</tbody></table></div>"
    )
}

fn rows((index, template): (usize, &TemplateRecord)) -> String {
    let name = format!("template[{index}] {}", template.kind);
    let place = [name, list(&template.center), number(template.radius)];
    let row = |(interval, (steps, amplitude)): (usize, (String, String))| {
        let (class, shown) = match interval {
            0 => (" class=\"first\"", true),
            _ => ("", false),
        };
        let [name, center, radius] = place
            .each_ref()
            .map(|text| if shown { text.as_str() } else { "" });
        format!(
            "<tr{class}><th>{name}</th><td>{center}</td><td>{radius}</td><td>{steps}</td><td>{amplitude}</td></tr>"
        )
    };
    template.intervals().enumerate().map(row).collect()
}

/// A line for each template.
pub(crate) fn lines(templates: &[TemplateRecord]) -> impl Iterator<Item = String> {
    templates.iter().enumerate().map(|(index, template)| {
        let amplitudes: Vec<String> = template
            .intervals()
            .map(|(steps, amplitude)| format!("{amplitude} in steps {steps}"))
            .collect();
        format!(
            "template[{index}] {}: center {}, radius {}, amplitude {}",
            template.kind,
            list(&template.center),
            number(template.radius),
            amplitudes.join("; ")
        )
    })
}

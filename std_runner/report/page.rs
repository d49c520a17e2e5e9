//! `report.html`: one page that needs nothing else.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;

use super::charts::charts;
use super::record::{KeyframeRecord, RunRecord};
use super::words::{count, escape, number, outcome, seconds};
use super::{tables, templates, words};
use crate::output::{Gallery, KeyframePictures};
use crate::stay::Stay;

/// Of how many densities beside an earlier result's one is told.
const TENTH: usize = 10;
const STYLE: &str = include_str!("page.css");

/// The whole page.
pub(super) fn page(title: &str, record: &RunRecord, gallery: &Gallery) -> String {
    let title = escape(title);
    let sections = [
        head(&title, record),
        hero(record, gallery),
        section("From the source to the last step", "strip", &strip(gallery)),
        section("Keyframes", "keyframes", &keyframes(record, gallery)),
        found_templates(record),
        earlier_frames(record),
        windows(record),
        section("Convergence", "charts", &charts(&record.history)),
        section(
            "Memory",
            "memory",
            &format!(
                "<p>{}</p>{}",
                tables::memory_sentence(record),
                tables::ledger(record)
            ),
        ),
        section("Time", "time", &tables::times(record)),
        scene(record),
    ];
    shell(&title, &sections.concat())
}

/// A page of its own around `body`; `title` is HTML.
pub(crate) fn shell(title: &str, body: &str) -> String {
    format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <meta name=\"color-scheme\" content=\"light dark\">\n<title>{title} \u{b7} thurible</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n<main>\n{body}</main>\n</body>\n</html>\n"
    )
}

fn section(title: &str, class: &str, body: &str) -> String {
    format!("<section><h2>{title}</h2>\n<div class=\"{class}\">{body}</div></section>\n")
}

fn head(title: &str, record: &RunRecord) -> String {
    let (word, kind, sentence) = outcome(record);
    let remarks: String = record
        .remarks
        .iter()
        .map(|remark| format!("<p class=\"lead fair\">Note: {}.</p>", escape(remark)))
        .collect();
    format!(
        "<header><p class=\"brand\">thurible</p><h1>{title} <span class=\"badge {kind}\">{word}</span></h1><p class=\"lead\">{sentence}</p>{remarks}</header>\n"
    )
}

/// The animation beside the main figures, and the parameters.
fn hero(record: &RunRecord, gallery: &Gallery) -> String {
    let moving = gallery
        .animation
        .as_deref()
        .or_else(|| gallery.strip.last().map(|(_, png)| png.as_slice()));
    let picture = moving
        .map(|png| image(png, "The smoke from first to last step"))
        .unwrap_or_default();
    let worst = |of: fn(&KeyframeRecord) -> f64| {
        let worst = record.keyframes.iter().map(of).fold(0.0, f64::max);
        number((1000.0 * worst).round() / 10.0)
    };
    let [before, after] = [
        worst(|error| error.relative_l2_before),
        worst(|error| error.relative_l2),
    ];
    let still = format!("largest keyframe error; {before} % with the source held still");
    let objective = record.objective;
    let plain = (objective.plain != objective.force)
        .then(|| (number(objective.plain), "of that without the price of curls"));
    let densities = [record.density_min, record.density_max].map(number).join(" to ");
    let parts = [
        (number(objective.total()), "objective"),
        (number(objective.data), "of it from the keyframes"),
        (number(objective.force), "of it from the force"),
    ];
    let rest = [
        (format!("{after} %"), still.as_str()),
        (densities, "densities"),
        (seconds(record.seconds.total), "to solve"),
        (words::bytes(record.memory.planned_bytes), "of memory"),
    ];
    let facts: String = parts
        .into_iter()
        .chain(plain)
        .chain(rest)
        .map(|(value, name)| format!("<li><b>{value}</b>{name}</li>"))
        .collect();
    format!(
        "<section class=\"hero\"><figure class=\"moving\">{picture}</figure><div><ul class=\"facts\">{facts}</ul>{}</div></section>\n",
        tables::parameters(record)
    )
}

fn strip(gallery: &Gallery) -> String {
    if gallery.strip.is_empty() {
        return "<p>No pictures were drawn. <code>thurible render</code> with this folder draws them from <code>result.npz</code>.</p>".into();
    }
    let is_keyframe = |step: usize| {
        gallery
            .keyframes
            .iter()
            .any(|keyframe| keyframe.stay.contains(step))
    };
    let frame = |(step, png): &(usize, Vec<u8>)| {
        let (class, mark) = if is_keyframe(*step) {
            (" class=\"key\"", " \u{b7} keyframe")
        } else {
            ("", "")
        };
        format!(
            "<figure{class}>{}<figcaption>step {step}{mark}</figcaption></figure>",
            image(png, &format!("Step {step}"))
        )
    };
    gallery.strip.iter().map(frame).collect()
}

fn keyframes(record: &RunRecord, gallery: &Gallery) -> String {
    let row = |pictures: &KeyframePictures| {
        let facts = record
            .keyframes
            .iter()
            .find(|facts| facts.step == pictures.step)
            .map(|facts| {
                let scaled = if (facts.mass_factor - 1.0).abs() > 1e-6 {
                    format!(
                        " The target was multiplied by {} to have the mass of the source.",
                        number(facts.mass_factor)
                    )
                } else {
                    String::new()
                };
                let kept = facts.mass_ratio.map_or_else(String::new, |ratio| {
                    format!(
                        " The smoke has {} % of the mass of the source.",
                        number((1000.0 * ratio).round() / 10.0)
                    )
                });
                let [after, before] = [facts.relative_l2, facts.relative_l2_before]
                    .map(|error| number((1000.0 * error).round() / 10.0));
                let Stay { first, last } = facts.stay;
                if facts.stay.is_held() {
                    format!(
                        "<p>Steps {first} to {last}: off by at most {after} % of the target (relative L2), at step {}, which is shown; \
                         the source held still by {before} %.{scaled}{kept}</p>",
                        facts.step
                    )
                } else {
                    format!(
                        "<p>Step {first}: off by {after} % of the target (relative L2), the source held still by {before} %.{scaled}{kept}</p>"
                    )
                }
            });
        let step = pictures.step;
        format!(
            "<article>{}<div class=\"three\"><figure>{}<figcaption>target</figcaption></figure><figure>{}<figcaption>reached</figcaption></figure>\
             <figure>{}<figcaption>difference <span class=\"scale\">too little<i></i>too much</span></figcaption></figure></div></article>",
            facts.unwrap_or_else(|| format!("<p>Step {step}</p>")),
            image(&pictures.target, &format!("Target at step {step}")),
            image(&pictures.reached, &format!("Density at step {step}")),
            image(&pictures.difference, &format!("Difference at step {step}")),
        )
    };
    gallery.keyframes.iter().map(row).collect()
}

/// The templates, where there are any.
fn found_templates(record: &RunRecord) -> String {
    match templates::table(&record.templates) {
        table if table.is_empty() => table,
        table => section("Templates", "templates", &table),
    }
}

/// How far the densities are from an earlier result's, where there is one.
fn earlier_frames(record: &RunRecord) -> String {
    if record.frames.is_empty() {
        return String::new();
    }
    let rows: String = record
        .frames
        .iter()
        .filter(|frame| frame.step == 1 || frame.step % TENTH == 0 || frame.step == record.frames.len())
        .map(|frame| {
            let off = number((1000.0 * frame.relative_l2).round() / 10.0);
            format!(
                "<tr><th>{}</th><td>{}</td><td>{off} %</td></tr>",
                frame.step, frame.frame
            )
        })
        .collect();
    let table = format!(
        "<table class=\"figures\"><thead><tr><th>step</th><td>step of the earlier result</td><td>apart (relative L2)</td></tr></thead><tbody>{rows}</tbody></table>"
    );
    section("Beside the earlier result", "scroll", &table)
}

/// The windows, where there are any.
fn windows(record: &RunRecord) -> String {
    if record.windows.is_empty() {
        return String::new();
    }
    section("Windows", "windows", &tables::windows(record))
}

fn scene(record: &RunRecord) -> String {
    format!(
        "<section><details><summary>The scene file ({}) and the command</summary><pre>{}</pre><pre>{}</pre></details></section>\n",
        count(record.scene.lines().count(), "line"),
        escape(&record.command),
        escape(record.scene.trim_end())
    )
}

pub(super) fn image(png: &[u8], about: &str) -> String {
    format!(
        "<img src=\"data:image/png;base64,{}\" alt=\"{}\">",
        STANDARD.encode(png),
        escape(about)
    )
}

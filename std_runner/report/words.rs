//! Values, sizes, times and outcomes as people read them.

use super::record::RunRecord;
use thurible_core::method::registry::simulates;
use thurible_core::{Params, Status};

/// Text that is safe between tags and in attributes.
pub(crate) fn escape(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
}

/// About four digits: 0.0123, 123.4, 1.23e-7.
pub(crate) fn number(value: f64) -> String {
    if !value.is_finite() {
        return "not finite".into();
    }
    if value == 0.0 {
        return "0".into();
    }
    let magnitude = value.abs().log10().floor();
    if !(-4.0..6.0).contains(&magnitude) {
        let text = format!("{value:.2e}");
        let (digits, power) = text.split_once('e').unwrap_or((&text, "0"));
        return format!("{}e{power}", digits.trim_end_matches('0').trim_end_matches('.'));
    }
    let decimals = (3.0 - magnitude).max(0.0) as usize;
    let text = format!("{value:.decimals$}");
    if text.contains('.') {
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    } else {
        text
    }
}

/// 1150437668 as "1.07 GiB".
pub(crate) fn bytes(count: usize) -> String {
    const UNITS: [(&str, f64); 4] = [
        ("GiB", 1073741824.0),
        ("MiB", 1048576.0),
        ("KiB", 1024.0),
        ("bytes", 1.0),
    ];
    let value = count as f64;
    let (unit, size) = UNITS
        .into_iter()
        .find(|(_, size)| value >= *size)
        .unwrap_or(("bytes", 1.0));
    let shown = value / size;
    let decimals = if unit == "bytes" || shown >= 100.0 {
        0
    } else if shown >= 10.0 {
        1
    } else {
        2
    };
    format!("{shown:.decimals$} {unit}")
}

/// 1150437668 as "1 150 437 668", with narrow spaces.
pub(crate) fn grouped(count: usize) -> String {
    let digits = count.to_string();
    let mut text = String::new();
    for (index, digit) in digits.chars().enumerate() {
        if index > 0 && (digits.len() - index).is_multiple_of(3) {
            text.push('\u{202f}');
        }
        text.push(digit);
    }
    text
}

/// 95.3 as "1 min 35 s".
pub(crate) fn seconds(value: f64) -> String {
    match value {
        value if !value.is_finite() => "unknown".into(),
        value if value < 0.0995 => format!("{:.1} ms", value * 1000.0),
        value if value < 59.95 => format!("{value:.1} s"),
        value => {
            let whole = value.round() as u64;
            let (hours, minutes, rest) = (whole / 3600, whole / 60 % 60, whole % 60);
            if hours > 0 {
                format!("{hours} h {minutes} min")
            } else {
                format!("{minutes} min {rest} s")
            }
        }
    }
}

/// A count with its noun.
pub(crate) fn count(number: usize, noun: &str) -> String {
    if number == 1 {
        format!("1 {noun}")
    } else {
        format!("{number} {noun}s")
    }
}

/// How it ended: a word for the badge, its kind for the colour, and a sentence.
pub(crate) fn outcome(record: &RunRecord) -> (&'static str, &'static str, String) {
    let finest = record
        .history
        .iter()
        .filter(|entry| entry.level.as_ref().is_none_or(|cells| *cells == record.cells))
        .count();
    let coarser = match record.history.len() - finest {
        0 => String::new(),
        coarser => format!(", and {coarser} on coarser grids before"),
    };
    let after = format!("after {}{coarser}", count(finest, "iteration"));
    let last = record.history.last();
    let little = if last.is_some_and(|entry| entry.facts.get("density_change").is_some()) {
        "changed the density"
    } else {
        "lowered the objective"
    };
    let params = Params {
        method: record.method.alike(),
        ..Params::default()
    };
    match record.status {
        Status::Converged if simulates(&params) => (
            "simulated",
            "good",
            "Simulated in one pass, from the source to the last step.".into(),
        ),
        Status::Converged => (
            "converged",
            "good",
            format!("Converged {after}: the last one {little} by less than the tolerance."),
        ),
        Status::MaxIterations => (
            "ran its iterations",
            "fair",
            format!("Stopped {after}, as many as were allowed; more may still improve it."),
        ),
        Status::Stalled => (
            "stalled",
            "fair",
            format!("Stalled {after}: it could not improve any more before it reached its tolerance."),
        ),
        Status::NotFinite => (
            "not finite",
            "bad",
            format!("Failed {after}: the numbers stopped being finite. What is shown is the last state."),
        ),
        Status::Cancelled => (
            "interrupted",
            "fair",
            format!("Interrupted {after}; what was reached by then is shown."),
        ),
        Status::NotReady => ("ended", "fair", format!("Ended {after}.")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short() {
        let table = [
            (0.0, "0"),
            (1.0, "1"),
            (0.012345, "0.01235"),
            (12345.6, "12346"),
            (1.5e-9, "1.5e-9"),
            (1e-5, "1e-5"),
            (f64::NAN, "not finite"),
            (-2.5, "-2.5"),
        ];
        for (value, expected) in table {
            assert_eq!(number(value), expected);
        }
        assert_eq!(number(120.0), "120");
    }

    #[test]
    fn sizes_and_times_have_units() {
        assert_eq!(bytes(1_150_437_668), "1.07 GiB");
        assert_eq!(bytes(0), "0 bytes");
        assert_eq!(grouped(1_150_437_668), "1\u{202f}150\u{202f}437\u{202f}668");
        assert_eq!(seconds(95.3), "1 min 35 s");
        assert_eq!(seconds(0.0042), "4.2 ms");
        assert_eq!(seconds(7260.0), "2 h 1 min");
    }
}

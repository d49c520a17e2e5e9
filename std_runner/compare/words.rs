//! Words that comparisons and their pages share.

/// "a, b and c"
pub(crate) fn listed(words: &[&str]) -> String {
    match words {
        [] => "no method".into(),
        [one] => (*one).into(),
        [rest @ .., last] => format!("{} and {last}", rest.join(", ")),
    }
}

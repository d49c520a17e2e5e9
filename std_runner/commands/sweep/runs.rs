//! What `--vary` says: every combination of the values of some keys is a run.

use crate::exit::Failure;
use std::path::{Path, PathBuf};

/// Most runs.
const MOST: usize = 1000;

/// One of the runs.
pub(super) struct Run {
    /// What is set, `key=value` each.
    pub set: Vec<String>,
    /// Its folder.
    pub folder: PathBuf,
}

/// All of them, with folders below `folder`.
pub(super) fn runs(vary: &[String], folder: &Path) -> Result<Vec<Run>, Failure> {
    let numbered = combinations(vary)?.into_iter().enumerate();
    let run = |(index, set): (usize, Vec<String>)| Run {
        folder: folder.join(format!("{:03}_{}", index + 1, in_a_name(&set.join("_")))),
        set,
    };
    Ok(numbered.map(run).collect())
}

/// Every combination of the values of all keys, that of the last key fastest.
fn combinations(vary: &[String]) -> Result<Vec<Vec<String>>, Failure> {
    let mut all = vec![Vec::new()];
    for one in vary {
        let (key, values) = one.split_once('=').ok_or_else(|| {
            Failure::Input(format!(
                "--vary {one}: there is no `=` in it; write key.path=a,b,c, as in --vary control.force_weight=1e2,1e3"
            ))
        })?;
        let is_key = |other: &&String| {
            other
                .split_once('=')
                .is_some_and(|(other, _)| other.trim() == key.trim())
        };
        if vary.iter().filter(is_key).count() > 1 {
            return Err(Failure::Input(format!(
                "--vary {one}: `{}` stands in another --vary too; write all of its values in one",
                key.trim()
            )));
        }
        let values = split(values);
        if all.len().saturating_mul(values.len()) > MOST {
            return Err(Failure::Input(format!(
                "--vary {one}: there are more than {MOST} combinations; take fewer values"
            )));
        }
        let with = |set: &Vec<String>, value: &String| {
            let mut set = set.clone();
            set.push(format!("{}={}", key.trim(), value.trim()));
            set
        };
        all = all
            .iter()
            .flat_map(|set| values.iter().map(move |value| with(set, value)))
            .collect();
    }
    Ok(all)
}

/// Values between commas, those within brackets, braces and quotation marks left together.
fn split(values: &str) -> Vec<String> {
    let (mut parts, mut depth, mut quoted) = (vec![String::new()], 0, false);
    for letter in values.chars() {
        match letter {
            '"' => quoted = !quoted,
            '[' | '{' if !quoted => depth += 1,
            ']' | '}' if !quoted => depth -= 1,
            ',' if !quoted && depth == 0 => {
                parts.push(String::new());
                continue;
            }
            _ => {}
        }
        if let Some(part) = parts.last_mut() {
            part.push(letter);
        }
    }
    parts
}

/// A text as a part of a file's name.
fn in_a_name(text: &str) -> String {
    let plain = |letter: char| {
        if letter.is_ascii_alphanumeric() || "-+.=_".contains(letter) {
            letter
        } else {
            '_'
        }
    };
    text.chars().map(plain).take(80).collect()
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn all_combinations_are_there_once() {
        let vary = ["a.b=1,2".to_owned(), "c=\"x,y\",[1, 2],z".into()];
        let all = combinations(&vary).unwrap();
        assert_eq!(all.len(), 6);
        assert_eq!(all[1], ["a.b=1", "c=[1, 2]"]);
        assert_eq!(all[3], ["a.b=2", "c=\"x,y\""]);
        assert!(combinations(&["a".into()]).is_err());
        assert!(combinations(&["a.b=1".into(), "a.b = 2,3".into()]).is_err());
        assert_eq!(in_a_name("a.b=[1, 2]/\""), "a.b=_1__2___");
    }
}

//! Files that are numbered: in the order of their numbers, and which number is missing.

use std::path::{Path, PathBuf};

/// Files in the order of their numbers, or of their names where they have none.
pub(crate) struct Numbered {
    pub paths: Vec<PathBuf>,
    /// None where a file has no number.
    numbers: Option<Vec<u64>>,
}

/// A number that is missing among others which are evenly apart.
pub(crate) struct Gap {
    pub missing: u64,
    /// The names of the files before and after it.
    pub before: String,
    pub after: String,
}

impl Numbered {
    /// Sorts the files of one folder.
    pub fn of(paths: impl IntoIterator<Item = PathBuf>) -> Self {
        let mut all: Vec<(String, PathBuf)> = paths.into_iter().map(|path| (name_of(&path), path)).collect();
        all.sort();
        let names: Vec<&str> = all.iter().map(|(name, _)| name.as_str()).collect();
        let Some(numbers) = numbers_in(&names) else {
            return Self {
                paths: all.into_iter().map(|(_, path)| path).collect(),
                numbers: None,
            };
        };
        let mut all: Vec<(u64, PathBuf)> = numbers
            .into_iter()
            .zip(all.into_iter().map(|(_, path)| path))
            .collect();
        all.sort();
        let (numbers, paths) = all.into_iter().unzip();
        Self {
            paths,
            numbers: Some(numbers),
        }
    }

    /// The first number that is missing among the files from number `first` to before number `end` of them. Files whose numbers follow in
    /// equal steps lack none; nor do those of which some have the same one.
    pub fn gap(&self, first: usize, end: usize) -> Option<Gap> {
        let numbers = self.numbers.as_ref()?.get(first..end)?;
        let steps = || numbers.windows(2).map(|pair| pair[1] - pair[0]);
        let usual = steps().min().filter(|&step| step > 0)?;
        let at = steps().position(|step| step != usual)?;
        let name = |at: usize| {
            self.paths
                .get(first + at)
                .map_or(String::new(), |path| name_of(path))
        };
        Some(Gap {
            missing: numbers[at] + usual,
            before: name(at),
            after: name(at + 1),
        })
    }
}

fn name_of(path: &Path) -> String {
    let name = path.file_name().unwrap_or_default();
    name.to_string_lossy().into_owned()
}

/// The numbers of names: what stands where they differ, or else the last number before the ending.
fn numbers_in(names: &[&str]) -> Option<Vec<u64>> {
    let differing = || -> Option<Vec<u64>> {
        let (first, rest) = names.split_first()?;
        let alike = |one: &str, other: &str| {
            let same = one
                .bytes()
                .zip(other.bytes())
                .take_while(|(one, other)| one == other);
            same.count()
        };
        let digit = |byte: &u8| byte.is_ascii_digit();
        let before = rest.iter().map(|name| alike(first, name)).min()?;
        // A digit that all have belongs to the number all the same.
        let digits = first.as_bytes()[..before]
            .iter()
            .rev()
            .take_while(|byte| digit(byte));
        let before = before - digits.count();
        let backwards = |name: &&str| -> Vec<u8> {
            name.bytes()
                .skip(before)
                .collect::<Vec<u8>>()
                .into_iter()
                .rev()
                .collect()
        };
        let end = backwards(first);
        let after = rest
            .iter()
            .map(|name| {
                end.iter()
                    .zip(backwards(name))
                    .take_while(|(one, other)| **one == *other)
                    .count()
            })
            .min()?;
        let digits = end[..after].iter().rev().take_while(|byte| digit(byte));
        let after = after - digits.count();
        let number = |name: &&str| name.get(before..name.len() - after)?.parse().ok();
        names.iter().map(number).collect()
    };
    differing().or_else(|| names.iter().map(|name| last_number(name)).collect())
}

/// The last number of a name before its ending.
fn last_number(name: &str) -> Option<u64> {
    let stem = Path::new(name).file_stem()?.to_str()?;
    let end = stem.rfind(|letter: char| letter.is_ascii_digit())? + 1;
    let begin = stem.get(..end)?.rfind(|letter: char| !letter.is_ascii_digit());
    stem.get(begin.map_or(0, |place| place + 1)..end)?.parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sorted(names: &[&str]) -> (Vec<String>, Option<u64>) {
        let all = Numbered::of(names.iter().map(PathBuf::from));
        let gap = all.gap(0, names.len()).map(|gap| gap.missing);
        (all.paths.iter().map(|path| name_of(path)).collect(), gap)
    }

    #[test]
    fn numbers_stand_where_names_differ() {
        for (names, gap) in [
            (&["a1.npy", "a2.npy", "a10.npy", "a11.npy"][..], Some(3)),
            (&["f_08.png", "f_09.png", "f_10.png"], None),
            (&["f1", "f11", "f21"], None),
            (&["f_1_v2.npy", "f_2_v2.npy", "f_4_v2.npy"], Some(3)),
            (&["r_1_64x64.png", "r_2_64x64.png", "r_10_64x64.png"], Some(3)),
            (&["7.npy"], None),
            // An ending in capitals is no part of the number.
            (&["h_1.OBJ", "h_2.obj", "h_10.obj"], Some(3)),
            // One that is counted twice, and names without any.
            (&["b_1.npy", "b_01.npy", "b_3.npy"], None),
            (&["ape.png", "bear.png", "cat.png"], None),
        ] {
            let mut mixed = names.to_vec();
            mixed.reverse();
            let (found, missing) = sorted(&mixed);
            if !names[0].starts_with('b') {
                assert_eq!(found, names);
            }
            assert_eq!(missing, gap, "{names:?}");
        }
    }
}

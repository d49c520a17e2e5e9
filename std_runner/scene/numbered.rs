//! Files that are numbered: in the order of their numbers, and which number is missing.

use std::path::{Path, PathBuf};

/// Files in the order of their numbers, or of their names where they have none.
pub(crate) struct Numbered {
    pub paths: Vec<PathBuf>,
    /// None where a file has no number, or several that count.
    numbers: Option<Vec<i64>>,
    /// Whether the numbers are those of one series: the names are the same before them.
    are_alike: bool,
}

/// A number that is missing among others which are evenly apart.
pub(crate) struct Gap {
    pub missing: i64,
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
        let differing = differing(&names);
        if differing.is_none() && names.windows(2).all(|pair| text_of(pair[0]) == text_of(pair[1])) {
            // As of takes and frames, or of times with a point.
            all.sort_by_cached_key(|(name, _)| runs(name).map(|(_, run)| run).collect::<Vec<_>>());
            return Self {
                paths: all.into_iter().map(|(_, path)| path).collect(),
                numbers: None,
                are_alike: true,
            };
        }
        let are_alike = differing.is_some()
            || names
                .windows(2)
                .all(|pair| before_last(pair[0]) == before_last(pair[1]));
        // Else the last number before the ending.
        let numbers = differing.or_else(|| names.iter().map(|name| last_number(name)).collect());
        let paths = all.into_iter().map(|(_, path)| path);
        let Some(numbers) = numbers else {
            return Self {
                paths: paths.collect(),
                numbers: None,
                are_alike,
            };
        };
        let mut numbered: Vec<(i64, PathBuf)> = numbers.into_iter().zip(paths).collect();
        numbered.sort();
        let (numbers, paths) = numbered.into_iter().unzip();
        Self {
            paths,
            numbers: Some(numbers),
            are_alike,
        }
    }

    /// The first file without a number, where others have one, so that nothing says where it comes.
    pub fn uncounted(&self) -> Option<String> {
        let names: Vec<String> = self.paths.iter().map(|path| name_of(path)).collect();
        let is_counted = |name: &String| last_number(name).is_some();
        let is_mixed = self.numbers.is_none() && names.iter().any(is_counted);
        names.into_iter().find(|name| is_mixed && !is_counted(name))
    }

    /// The first number that is missing among all files, if it is one series: others may be counted by chance.
    pub fn missing(&self) -> Option<Gap> {
        self.gap(0, self.paths.len()).filter(|_| self.are_alike)
    }

    /// Two files with the same number, as [`Self::missing`].
    pub fn doubled(&self) -> Option<[String; 2]> {
        self.twice(0, self.paths.len()).filter(|_| self.are_alike)
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

    /// Two files from number `first` to before number `end` that have the same number, so that nothing says which comes first.
    pub fn twice(&self, first: usize, end: usize) -> Option<[String; 2]> {
        let numbers = self.numbers.as_ref()?.get(first..end)?;
        let at = numbers.windows(2).position(|pair| pair[0] == pair[1])?;
        let paths = self.paths.get(first + at..first + at + 2)?;
        Some([name_of(&paths[0]), name_of(&paths[1])])
    }
}

fn name_of(path: &Path) -> String {
    let name = path.file_name().unwrap_or_default();
    name.to_string_lossy().into_owned()
}

/// The numbers of names that differ in nothing else.
fn differing(names: &[&str]) -> Option<Vec<i64>> {
    let before = shared(names.iter().map(|name| name.bytes().collect()).collect())?;
    let backwards = |name: &&str| name.bytes().skip(before).rev().collect();
    let after = shared(names.iter().map(backwards).collect())?;
    let number = |name: &&str| name.get(before..name.len() - after)?.parse().ok();
    names.iter().map(number).collect()
}

/// How many bytes all of them begin with. Digits at the end of these belong to the number that follows; none where there is one alone.
fn shared(names: Vec<Vec<u8>>) -> Option<usize> {
    let (first, rest) = names.split_first()?;
    let alike = |other: &Vec<u8>| {
        let pairs = first.iter().zip(other);
        pairs.take_while(|(one, other)| one == other).count()
    };
    let count = rest.iter().map(alike).min()?;
    let digits = first.get(..count)?.iter().rev();
    Some(count - digits.take_while(|byte| byte.is_ascii_digit()).count())
}

/// Digits side by side, as they are ordered.
#[derive(Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Run {
    /// A whole number, by its length without zeros before it and its digits.
    Whole(usize, String),
    /// What stands behind a point.
    Fraction(String),
}

/// The digits of a name before its ending, and where each run of them begins.
fn runs(name: &str) -> impl Iterator<Item = (usize, Run)> {
    let stem = stem_of(name);
    let is_digit = |at: usize| stem.as_bytes().get(at).is_some_and(u8::is_ascii_digit);
    let begins = (0..stem.len()).filter(move |&at| is_digit(at) && (at == 0 || !is_digit(at - 1)));
    begins.map(move |at| {
        let rest = stem.get(at..).unwrap_or_default();
        let digits: String = rest.chars().take_while(char::is_ascii_digit).collect();
        let is_fraction = at > 1 && stem.get(at - 1..at) == Some(".") && is_digit(at - 2);
        let whole = digits.trim_start_matches('0');
        let run = match is_fraction {
            true => Run::Fraction(digits),
            false => Run::Whole(whole.len(), whole.to_owned()),
        };
        (at, run)
    })
}

/// A name without its digits.
fn text_of(name: &str) -> Vec<&str> {
    let parts = name.split(|letter: char| letter.is_ascii_digit());
    parts.filter(|part| !part.is_empty()).collect()
}

/// A name up to its last number before the ending.
fn before_last(name: &str) -> Option<&str> {
    let (at, _) = runs(name).last()?;
    name.get(..at)
}

/// The last number of a name before its ending.
fn last_number(name: &str) -> Option<i64> {
    let digits: String = name
        .get(before_last(name)?.len()..)?
        .chars()
        .take_while(char::is_ascii_digit)
        .collect();
    digits.parse().ok()
}

fn stem_of(name: &str) -> &str {
    let stem = Path::new(name).file_stem();
    stem.and_then(std::ffi::OsStr::to_str).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sorted(names: &[&str]) -> (Vec<String>, Option<i64>) {
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
            // As programs count what comes before the first frame.
            (&["p_-2.png", "p_-1.png", "p_0.png", "p_1.png"], None),
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

    /// Of several numbers the first ones come first.
    #[test]
    fn several_numbers_count() {
        for names in [
            &[
                "take1_0001.png",
                "take1_0002.png",
                "take2_0001.png",
                "take10_0001.png",
            ][..],
            &[
                "smoke_t0.25.npy",
                "smoke_t0.5.npy",
                "smoke_t1.0.npy",
                "smoke_t10.5.npy",
            ],
        ] {
            let mut mixed = names.to_vec();
            mixed.reverse();
            assert_eq!(
                sorted(&mixed),
                (names.iter().map(|&name| name.to_owned()).collect(), None)
            );
        }
    }

    /// A mask of each frame is no frame.
    #[test]
    fn what_is_there_twice_is_named() {
        let of = |names: &[&str]| Numbered::of(names.iter().map(PathBuf::from)).doubled();
        let twice = of(&["p_0001.png", "p_0001_mask.png", "p_0002.png", "p_0002_mask.png"]);
        assert_eq!(twice.unwrap_or_default(), ["p_0001.png", "p_0001_mask.png"]);
        assert!(of(&["p_0001_a.png", "p_0002_b.png"]).is_none());
    }

    #[test]
    fn one_without_a_number_among_others_is_named() {
        let of = |names: &[&str]| Numbered::of(names.iter().map(PathBuf::from));
        let all = of(&["horse_1.png", "horse_10.png", "horse_walk.check.png"]);
        assert_eq!(all.uncounted().as_deref(), Some("horse_walk.check.png"));
        for names in [
            &["ape.png", "bear.png"][..],
            &["h_1.png", "h_2.png"],
            &["r_1_v2.png", "r_2_v2.png"],
        ] {
            assert!(of(names).uncounted().is_none(), "{names:?}");
        }
    }

    /// Pictures of several things may have numbers that count nothing.
    #[test]
    fn among_names_that_differ_otherwise_none_is_missing() {
        let of = |names: [&str; 3]| Numbered::of(names.map(PathBuf::from)).missing();
        assert!(of(["logo_v1.png", "title_v2.png", "end_v5.png"]).is_none());
        assert!(of(["logo_v1.png", "logo_v2.png", "logo_v5.png"]).is_some());
        let of = |names: [&str; 2]| Numbered::of(names.map(PathBuf::from)).doubled();
        assert!(of(["logo_v1.png", "title_v1.png"]).is_none());
        assert!(of(["logo_v1.png", "logo_v01.png"]).is_some());
    }
}

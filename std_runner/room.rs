//! Room on discs: how much there is, and what files take.

use std::fs;
use std::path::Path;

/// Bytes that the user may still write to the disc of `folder`, or of the closest folder above it that is there; `None` where the system
/// does not say.
pub fn free_at(folder: &Path) -> Option<u64> {
    let there = folder.ancestors().find(|folder| folder.is_dir())?;
    let found = fs4::statvfs(there).ok()?;
    // File systems that know no size say 0 of everything.
    (found.total_space() > 0).then(|| found.available_space())
}

/// Bytes of the files in `folder` and below, as far as they can be seen; of those in it whose names `count`.
pub fn taken(folder: &Path, count: &dyn Fn(&str) -> bool) -> u64 {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    let counted = entries.filter(|entry| entry.file_name().to_str().is_some_and(count));
    counted
        .map(|entry| match entry.metadata() {
            Ok(found) if found.is_dir() => taken(&entry.path(), &|_| true),
            found => found.map_or(0, |found| found.len()),
        })
        .sum()
}

/// Whether two folders, or the closest ones above them that are there, are on one disc; yes where the system does not say.
#[cfg(unix)]
pub fn are_on_one_disc(one: &Path, other: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    let device = |folder: &Path| {
        let there = folder.ancestors().find(|folder| folder.is_dir())?;
        fs::metadata(there).ok().map(|found| found.dev())
    };
    device(one)
        .zip(device(other))
        .is_none_or(|(one, other)| one == other)
}

/// As on Unix; elsewhere nobody is asked.
#[cfg(not(unix))]
pub fn are_on_one_disc(_: &Path, _: &Path) -> bool {
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_disc_of_a_folder_that_is_not_there_yet_is_that_of_the_one_above() {
        let here = free_at(&std::env::temp_dir());
        assert!(here.is_none_or(|bytes| bytes < 1 << 60));
        let below = free_at(&std::env::temp_dir().join("not/there/yet"));
        assert_eq!(here.is_some(), below.is_some());
        assert!(are_on_one_disc(
            &std::env::temp_dir(),
            &std::env::temp_dir().join("not/there/yet")
        ));
        #[cfg(target_os = "linux")]
        assert!(!are_on_one_disc(&std::env::temp_dir(), Path::new("/proc")));
    }
}

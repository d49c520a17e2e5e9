//! Room on discs: how much there is, and whether a result finds enough.

use std::path::Path;

/// Bytes that the user may still write to the disc of `folder`, or of the closest folder above it that is there; `None` where the system
/// does not say.
#[cfg(target_os = "linux")]
#[expect(unsafe_code, reason = "statvfs is a call of the system")]
pub fn free_at(folder: &Path) -> Option<u64> {
    use std::os::unix::ffi::OsStrExt;
    let there = folder.ancestors().find(|folder| folder.is_dir())?;
    let path = std::ffi::CString::new(there.as_os_str().as_bytes()).ok()?;
    let mut found = core::mem::MaybeUninit::<libc::statvfs>::zeroed();
    // SAFETY: the path ends with a zero byte, and the structure is as large as the system's and all zero, which is a value of it.
    let found = unsafe {
        if libc::statvfs(path.as_ptr(), found.as_mut_ptr()) != 0 {
            return None;
        }
        found.assume_init()
    };
    // File systems that know no size say 0 of everything.
    (found.f_blocks > 0).then(|| found.f_bavail.saturating_mul(found.f_frsize))
}

/// As on Linux; elsewhere nobody is asked.
#[cfg(not(target_os = "linux"))]
pub fn free_at(_: &Path) -> Option<u64> {
    None
}

/// Whether two folders, or the closest ones above them that are there, are on one disc; yes where the system does not say.
#[cfg(unix)]
pub fn are_on_one_disc(one: &Path, other: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    let device = |folder: &Path| {
        let there = folder.ancestors().find(|folder| folder.is_dir())?;
        std::fs::metadata(there).ok().map(|found| found.dev())
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

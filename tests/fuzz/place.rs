//! Where inputs are written: into memory, where the system has files there.

use std::fs;
use std::path::{Path, PathBuf};

/// A folder that is removed in the end.
pub struct Place {
    pub folder: PathBuf,
}

impl Place {
    /// One in memory, or else in `work`. What a killed process left behind is removed; what one that crashed read last stays until then.
    pub fn new(work: &Path) -> Self {
        let memory = Path::new("/dev/shm");
        for entry in fs::read_dir(memory).into_iter().flatten().flatten() {
            let name = entry.file_name().to_string_lossy().into_owned();
            let process = name.strip_prefix("thurible-fuzz-");
            if process.is_some_and(|process| !Path::new("/proc").join(process).exists()) {
                let _ = fs::remove_dir_all(entry.path());
            }
        }
        let folder = memory.join(format!("thurible-fuzz-{}", std::process::id()));
        let folder = match fs::create_dir(&folder) {
            Ok(()) => folder,
            Err(_) => work.join("inputs"),
        };
        fs::create_dir_all(&folder).unwrap();
        Self { folder }
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.folder);
    }
}

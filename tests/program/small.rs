//! A scene so small that what is asked is only whether its files are read.

use crate::support::Ended;
use std::fs;
use std::path::Path;

/// Cells along each axis.
pub const SIDE: usize = 8;

/// A round blob in a box of [`SIDE`] x [`SIDE`] cells.
pub fn density() -> Vec<f64> {
    let cell = |index: usize| ((index % SIDE) as f64 - 3.5).hypot((index / SIDE) as f64 - 3.5);
    (0..SIDE * SIDE)
        .map(|index| (3.0 - cell(index)).clamp(0.0, 1.0))
        .collect()
}

/// A scene of two steps in `folder` with this source and this target; its path.
pub fn scene(folder: &Path, source: &str, target: &str) -> String {
    let path = folder.join("scene.toml");
    let text = format!(
        "[grid]\ncells = [8, 8]\n[time]\nsteps = 2\n[source]\n{source}\n[[keyframe]]\nstep = 2\n{target}\n[method]\niterations = 1\n[output]\nframes = false\n"
    );
    fs::write(&path, text).unwrap();
    path.to_str().unwrap().into()
}

/// A shape that is drawn.
pub const CIRCLE: &str = "circle = { center = [0.5, 0.5], radius = 0.3 }";

/// Bad input, named by all of `words`.
pub fn refused(ended: &Ended, words: &[&str]) {
    assert_eq!(ended.code, 2, "{}", ended.err);
    assert!(words.iter().all(|word| ended.err.contains(word)), "{}", ended.err);
}

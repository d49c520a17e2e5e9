//! The scenes that are timed, with assignments as after `--set`.

use super::prepared::PreparedScene;
use thurible::exit::Failure;

const LETTER_F: &str = include_str!("../../examples/letter_f.toml");
const MOVING_SPHERE: &str = include_str!("../../examples/moving_sphere.toml");

/// A circle becomes two, all of the same mass: what `rivals.py` solves with `--target two`, with the same weight of the force.
const TWO_CIRCLES: &str = "
[grid]
cells = [128, 128]
[time]
steps = 40
[source]
circle = { center = [0.5, 0.5], radius = 0.15 }
[[keyframe]]
step = 40
shapes = [{ circle = { center = [0.34, 0.5], radius = 0.10607 } }, { circle = { center = [0.66, 0.5], radius = 0.10607 } }]
[control]
force_weight = 100.0
";

/// `assignments` after those that leave the direct method as it is by default, so that what examples choose changes no time.
fn by_default(iterations: usize, assignments: &[String]) -> Vec<String> {
    let own = [
        "method.direct={}".into(),
        format!("method.iterations={iterations}"),
    ];
    [&own, assignments].concat()
}

/// A circle becomes the letter F, in 50 iterations at most unless `assignments` say otherwise.
///
/// # Errors
/// [`Failure`]: an assignment is wrong.
pub fn letter_f(assignments: &[String], method: &str, threads: usize) -> Result<PreparedScene, Failure> {
    PreparedScene::new(
        "letter_f",
        LETTER_F,
        &by_default(50, assignments),
        method,
        threads,
    )
}

/// A circle becomes two.
///
/// # Errors
/// [`Failure`]: an assignment is wrong.
pub fn two_circles(assignments: &[String], threads: usize) -> Result<PreparedScene, Failure> {
    PreparedScene::new("two_circles", TWO_CIRCLES, assignments, "direct", threads)
}

/// A ball travels through three places, in 15 iterations at most unless `assignments` say otherwise.
///
/// # Errors
/// [`Failure`]: an assignment is wrong.
pub fn moving_sphere(assignments: &[String], method: &str, threads: usize) -> Result<PreparedScene, Failure> {
    PreparedScene::new(
        "moving_sphere",
        MOVING_SPHERE,
        &by_default(15, assignments),
        method,
        threads,
    )
}

/// Smoke that moves 0.4 cells a step, as far as there is room: much the same work for each cell and step in boxes of any size.
///
/// # Errors
/// [`Failure`]: there is no such box.
pub fn drift(cells: &[usize], steps: usize, nested: bool, threads: usize) -> Result<PreparedScene, Failure> {
    let shift = (0.2 * steps as f64 / cells[0] as f64).min(0.15);
    let circle = |x: f64| format!("circle = {{ center = [{x}, 0.5], radius = 0.15 }}");
    let text = format!(
        "[grid]\ncells = {cells:?}\n[time]\nsteps = {steps}\n[source]\n{}\n[[keyframe]]\nstep = {steps}\n{}\n[method.direct]\nnested = {nested}\n",
        circle(0.5 - shift),
        circle(0.5 + shift)
    );
    PreparedScene::new("drift", &text, &[], "direct", threads)
}

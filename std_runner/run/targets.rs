//! Keyframes for a solver: which, and scaled to which mass.

use super::drawn::{drawn, refuse, solid_cells};
use super::reach::Reach;
use crate::exit::Failure;
use crate::keyframes::Note;
use crate::scene::Scene;
use thurible_core::{Real, Solver, Space};

/// Refuses a keyframe of which obstacles let no smoke come to too much.
pub(super) fn check_reach(scene: &Scene, reach: Option<Reach>) -> Result<(), Failure> {
    let Some(reach) = reach else {
        return Ok(());
    };
    for keyframe in &scene.keyframes {
        let mut density: Vec<f32> = drawn(scene, &keyframe.key, &keyframe.shape, &mut Vec::new())?;
        // What lies outside of its region need not come anywhere.
        if let Some(region) = &keyframe.region {
            let key = format!("{}.region", keyframe.key);
            let region: Vec<f32> = drawn(scene, &key, region, &mut Vec::new())?;
            density
                .iter_mut()
                .zip(region)
                .for_each(|(cell, weight)| *cell *= weight);
        }
        if let Some(part) = reach.cut_off(density.iter().map(|&cell| cell.into())) {
            let why = format!(
                "cannot be reached: {:.0} % of it lies where obstacles let no smoke come; open a way, or put an emitter there",
                100.0 * part
            );
            return Err(scene.document.refuse(&keyframe.key, why));
        }
    }
    Ok(())
}

/// Which keyframes a solver is given, and the mass that they take.
#[derive(Clone, Copy, Default)]
pub(super) struct Which<'a> {
    /// The mass at each step of the scene, where the solver does not know it.
    pub masses: Option<&'a [f64]>,
    /// The numbers of the keyframes, of all their steps; `None` is all of them.
    pub among: Option<&'a [usize]>,
}

/// Sets keyframes; what each was multiplied by.
pub(super) fn set_keyframes<T: Real, S: Space>(
    scene: &Scene,
    solver: &mut Solver<'_, T, S>,
    Which { masses, among }: Which<'_>,
    notes: &mut Vec<Note>,
) -> Result<Vec<f64>, Failure> {
    let (mut mass_factors, mut number) = (Vec::new(), 0);
    // What lies in an obstacle is lost before masses are matched.
    let solid = match masses {
        Some(_) => solid_cells(scene, &mut Vec::new())?.unwrap_or_default(),
        None => Vec::new(),
    };
    let is_lost = |cell: usize| solid.get(cell).is_some_and(|&solid| solid);
    for keyframe in &scene.keyframes {
        let numbered = keyframe.stay().steps().zip(number..);
        number += keyframe.hold + 1;
        let wanted = |(_, number): &(usize, usize)| among.is_none_or(|among| among.contains(number));
        let steps: Vec<usize> = numbered.filter(wanted).map(|(step, _)| step).collect();
        if steps.is_empty() {
            continue;
        }
        // One after the other, so that both are not there at once.
        if let Some(region) = &keyframe.region {
            let key = format!("{}.region", keyframe.key);
            let region: Vec<T> = drawn(scene, &key, region, notes)?;
            for index in (mass_factors.len()..).take(steps.len()) {
                solver.set_region(index, &region).map_err(refuse(scene, &key))?;
            }
        }
        let density: Vec<T> = drawn(scene, &keyframe.key, &keyframe.shape, notes)?;
        let kept = density.iter().enumerate().filter(|&(cell, _)| !is_lost(cell));
        let mass: f64 = kept.map(|(_, x)| x.to_f64()).sum();
        for step in steps {
            let to_free = masses
                .and_then(|masses| masses.get(step))
                .map_or(1.0, |free| free / mass);
            let density: Vec<T> = density
                .iter()
                .map(|x| T::from_f64(x.to_f64() * to_free))
                .collect();
            let factor = solver
                .set_keyframe(mass_factors.len(), &density)
                .map_err(refuse(scene, &keyframe.key))?;
            mass_factors.push(factor * to_free);
        }
    }
    Ok(mass_factors)
}

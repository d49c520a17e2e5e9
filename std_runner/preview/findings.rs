//! What of a scene is probably not meant.

use super::dilate::dilated;
use super::layers::{Layer, Role};
use crate::keyframes::Canvas;
use crate::scene::Scene;
use crate::stay::Stay;
use std::borrow::Cow;
use thurible_core::problem::Supply;

/// Smoke that goes faster than so many cells in a step is too fast to follow.
const COURANT: usize = 5;
/// Part of a mass from which it counts.
const SOME: f64 = 0.01;
/// Masses that differ by more are probably not meant, even where they are scaled.
const TWICE: f64 = 2.0;
/// So many sentences of one kind are told, and of the rest how many they are.
const TOLD: usize = 3;
/// A side on which a shape is denser than this part of its own is one that cuts it off.
const CUT: f64 = 0.5;

/// A sentence for each.
pub(crate) fn findings(scene: &Scene, layers: &[Layer]) -> Vec<String> {
    let canvas = scene.canvas();
    let smoke = |layer: &&Layer| matches!(layer.role, Role::Source | Role::Emitter(_) | Role::Keyframe(_));
    let smoke: Vec<&Layer> = layers.iter().filter(smoke).collect();
    let cut = smoke.iter().filter_map(|layer| cut_off(&canvas, layer));
    let inside = smoke.iter().filter_map(|layer| inside_a_solid(layers, layer));
    let kept = outside_of_solids(layers);
    let kinds = [
        masses(scene, &kept),
        fast(scene, &canvas, &kept),
        cut.collect(),
        inside.collect(),
    ];
    kinds.into_iter().flat_map(shortened).collect()
}

/// The layers without what of the smoke lies in obstacles, where it is lost.
fn outside_of_solids(layers: &[Layer]) -> Cow<'_, [Layer]> {
    let Some(solid) = layers.iter().find(|layer| layer.role == Role::Solid) else {
        return Cow::Borrowed(layers);
    };
    let mut kept = layers.to_vec();
    for layer in &mut kept {
        if matches!(layer.role, Role::Source | Role::Emitter(_) | Role::Keyframe(_)) {
            let cells = layer.values.iter_mut().zip(&solid.values);
            cells
                .filter(|(_, solid)| **solid > 0.5)
                .for_each(|(value, _)| *value = 0.0);
        }
    }
    Cow::Owned(kept)
}

/// The first sentences of a kind, and how many there are more.
fn shortened(mut sentences: Vec<String>) -> Vec<String> {
    let more = sentences.len().saturating_sub(TOLD);
    if more > 1 {
        sentences.truncate(TOLD);
        sentences.push(format!("so it is with {more} more"));
    }
    sentences
}

/// Keyframes whose mass is not that of the smoke that is there by then: of the source, and of what rates have added. How much an emitter with a
/// target adds nobody knows before.
fn masses(scene: &Scene, layers: &[Layer]) -> Vec<String> {
    let supplies = scene.emitters.iter().map(|emission| emission.emits.supply);
    let rate = |supply: Supply| match supply {
        Supply::Rate(rate) => Some(rate),
        Supply::Target(_) => None,
    };
    let Some(rates) = supplies.map(rate).collect::<Option<Vec<f64>>>() else {
        return Vec::new();
    };
    let of_source = layers
        .iter()
        .find(|layer| layer.role == Role::Source)
        .map_or(0.0, Layer::sum);
    let emitted = |step: usize| -> f64 {
        let shapes = layers.iter().filter_map(|layer| match layer.role {
            Role::Emitter(stay) => Some((stay, layer.sum())),
            _ => None,
        });
        let steps = |stay: Stay| stay.last.min(step).saturating_sub(stay.first) as f64;
        shapes
            .zip(&rates)
            .map(|((stay, sum), rate)| rate * steps(stay) * sum)
            .sum()
    };
    let (whose, keeps) = if rates.is_empty() {
        ("the source", ", and smoke keeps its mass")
    } else {
        ("source and emitters by then", "")
    };
    let sentence = |layer: &Layer| {
        let Role::Keyframe(stay) = layer.role else {
            return None;
        };
        let factor = layer.sum() / (of_source + emitted(stay.first));
        if !scene.control.match_mass {
            return ((factor - 1.0).abs() > SOME).then(|| {
                format!(
                    "{} has {factor:.3} times the mass of {whose}{keeps}: it cannot be met; set control.match_mass = true, or \
                     change its size",
                    layer.title()
                )
            });
        }
        (!(1.0 / TWICE..=TWICE).contains(&factor)).then(|| {
            format!(
                "{} has {factor:.2} times the mass of {whose} and is made {} by that (control.match_mass); change its size if that is not meant",
                layer.title(),
                if factor > 1.0 { "fainter" } else { "denser" }
            )
        })
    };
    layers.iter().filter_map(sentence).collect()
}

/// Keyframes that lie too far from the smoke before them.
fn fast(scene: &Scene, canvas: &Canvas, layers: &[Layer]) -> Vec<String> {
    let is_smoke = |layer: &Layer| -> Vec<bool> {
        let densest = layer.values.iter().copied().fold(0.0, f64::max);
        layer.values.iter().map(|&value| value > 0.1 * densest).collect()
    };
    let made = layers.iter().filter_map(|layer| match layer.role {
        Role::Emitter(made) => Some((made.first, is_smoke(layer))),
        _ => None,
    });
    let made: Vec<_> = made.collect();
    let source = layers.iter().find(|layer| layer.role == Role::Source);
    // The first step goes with the initial velocity, which is rest where none is given. Stable Fluids are forced before it too.
    let forced = scene.method.fluids.chosen;
    let rests = usize::from(!forced && scene.control.initial_velocity.is_none());
    let mut before = (
        source.map_or_else(|| vec![false; canvas.cell_count()], is_smoke),
        0,
        rests,
    );
    let solid = layers.iter().find(|layer| layer.role == Role::Solid);
    let solid: Vec<bool> = solid.map_or(Vec::new(), |solid| {
        solid.values.iter().map(|&value| value > 0.5).collect()
    });
    let mut found = Vec::new();
    for layer in layers {
        let Role::Keyframe(stay) = layer.role else {
            continue;
        };
        let (mut from, last, still) = before;
        // Of the emitters, those that have begun.
        for (_, made) in made.iter().filter(|(begins, _)| *begins < stay.first) {
            from.iter_mut().zip(made).for_each(|(from, &made)| *from |= made);
        }
        let steps = stay.first.saturating_sub(last + still);
        let near = dilated(canvas, &from, COURANT.saturating_mul(steps), &solid);
        // Where it does not matter nothing has to come.
        let region = format!("{}.region", layer.key);
        let region = layers.iter().find(|other| other.key == region);
        let weight =
            |cell: usize| region.map_or(1.0, |region| region.values.get(cell).copied().unwrap_or(0.0));
        let wanted = layer
            .values
            .iter()
            .enumerate()
            .map(|(cell, value)| value * weight(cell));
        let (all, beyond) = wanted.zip(near).fold((0.0, 0.0), |(all, beyond), (value, near)| {
            (all + value, if near { beyond } else { beyond + value })
        });
        if beyond > SOME * all {
            found.push(format!(
                "{} cannot be reached: {:.0} % of it lies farther than {} cells from the smoke at step {last}{}, {COURANT} cells for each of the \
                 {steps} steps in which force acts; give it more steps, or bring it nearer",
                layer.title(),
                100.0 * beyond / all,
                COURANT * steps,
                if solid.is_empty() { "" } else { " on the way around obstacles" }
            ));
        }
        before = (is_smoke(layer), stay.last, 0);
    }
    found
}

/// Shapes that a side of the box cuts through.
fn cut_off(canvas: &Canvas, layer: &Layer) -> Option<String> {
    let densest = layer.values.iter().copied().fold(0.0, f64::max);
    let mut stride = 1;
    let mut sides = Vec::new();
    for (axis, &count) in canvas.cells.iter().enumerate() {
        let dense = |place: usize| {
            let mut cells = layer.values.iter().enumerate();
            cells.any(|(cell, &value)| cell / stride % count == place && value > CUT * densest)
        };
        if !canvas.repeats(axis) {
            let name = ["x", "y", "z"].get(axis).copied().unwrap_or_default();
            let ends = [(0, "low"), (count - 1, "high")];
            sides.extend(
                ends.into_iter()
                    .filter(|&(place, _)| dense(place))
                    .map(|(_, end)| format!("the {end} side along {name}")),
            );
        }
        stride *= count;
    }
    (!sides.is_empty()).then(|| {
        format!(
            "{} touches {}: what lies outside of the box is cut off; move it inwards, or make it smaller",
            layer.title(),
            sides.join(" and ")
        )
    })
}

/// Smoke within obstacles.
fn inside_a_solid(layers: &[Layer], layer: &Layer) -> Option<String> {
    let solid = layers.iter().find(|layer| layer.role == Role::Solid)?;
    let within: f64 = layer
        .values
        .iter()
        .zip(&solid.values)
        .map(|(value, solid)| value * solid)
        .sum();
    let part = within / layer.sum();
    (part > SOME).then(|| {
        format!(
            "{:.0} % of {} lies inside an obstacle, where there is no smoke; move one of them",
            100.0 * part,
            layer.title()
        )
    })
}

//! The script of a solve in its block: lists that follow from the problem, and fields that are given.

use super::shared::{piece_len, solid_len};
use crate::memory::{Arena, Ledger, TooSmall};
use crate::objective::script::Lists;
use crate::problem::{Problem, Supply};
use crate::real::Real;

/// Counts what [`carve`] takes.
pub(super) fn measure<T: Real>(problem: &Problem<'_>, ledger: &mut Ledger) {
    let mut arena = Arena::measuring(ledger);
    // An arena that measures is never too small.
    let _ = carve::<T>(problem, &mut arena);
    let _ = carve_shared::<T>(problem, &mut arena);
    if let Some(ledger) = arena.into_ledger() {
        ledger.count_kept(problem.fields() * problem.grid().whole().cells(), T::BYTES);
    }
}

/// Room for what a rank that follows sends of a field, and for what it knows of solid cells.
pub(super) fn carve_shared<'m, T: Real>(
    problem: &Problem<'_>,
    arena: &mut Arena<'m>,
) -> Result<(&'m mut [T], &'m mut [u8]), TooSmall> {
    let grid = problem.grid();
    if !grid.is_part() {
        return Ok((&mut [], &mut []));
    }
    let piece = arena.take("a rank's part of a field", piece_len(&grid))?;
    let solid = if problem.solids {
        arena.take("which cells are solid", solid_len(&grid))?
    } else {
        &mut []
    };
    Ok((piece, solid))
}

/// The lists of `problem`, and its fields: regions and the mask are 1 everywhere, what has to be given is 0.
pub(crate) fn carve<'m, T: Real>(
    problem: &Problem<'_>,
    arena: &mut Arena<'m>,
) -> Result<(Lists<'m>, &'m mut [T]), TooSmall> {
    let keyframes = problem.keyframes.len();
    let steps = filled(
        arena,
        "keyframe steps",
        problem.keyframes.iter().map(|&step| step as u32),
    )?;
    let weights = filled(
        arena,
        "keyframe weights",
        problem.keyframe_weights.iter().copied(),
    )?;
    let spans = problem
        .emitters
        .iter()
        .flat_map(|emitter| [emitter.from as u32, emitter.to as u32]);
    let spans = filled(arena, "emitter steps", spans)?;
    let supplies = problem.emitters.iter().flat_map(|emitter| match emitter.supply {
        Supply::Rate(rate) => [rate, 0.0],
        Supply::Target(target) => [0.0, target],
    });
    let supplies = filled(arena, "emitter rates and targets", supplies)?;
    let knots = problem.schedule.iter().map(|&(step, _)| step as u32);
    let knots = filled(arena, "schedule steps", knots)?;
    let factors = problem.schedule.iter().map(|&(_, factor)| factor);
    let factors = filled(arena, "schedule factors", factors)?;
    let jets = problem.scaled_jets();
    let jets = filled(arena, "velocities of emitters", jets.flatten())?;
    let templates = problem.scaled_templates().flat_map(|template| template.pack());
    let templates = filled(arena, "templates", templates)?;
    let lists = Lists {
        steps,
        weights,
        regions: problem.keyframe_regions,
        spans,
        supplies,
        jets,
        knots,
        factors,
        mask: problem.mask,
        templates,
    };
    let cells = problem.grid().cells();
    let targets = "given densities";
    let fields: &mut [T] = arena.take(targets, problem.fields() * cells)?;
    if problem.keyframe_regions
        && let Some(regions) = fields.get_mut(keyframes * cells..2 * keyframes * cells)
    {
        regions.fill(T::ONE);
    }
    if problem.mask
        && let Some(mask) = fields.get_mut(lists.mask_begins() * cells..)
    {
        mask.fill(T::ONE);
    }
    Ok((lists, fields))
}

/// A list of the block with `values`; none is taken where there are none.
fn filled<'m, P: crate::memory::Plain>(
    arena: &mut Arena<'m>,
    name: &'static str,
    values: impl Iterator<Item = P> + Clone,
) -> Result<&'m [P], TooSmall> {
    let count = values.clone().count();
    if count == 0 {
        return Ok(&[]);
    }
    let list = arena.take(name, count)?;
    list.iter_mut()
        .zip(values)
        .for_each(|(slot, value)| *slot = value);
    Ok(list)
}

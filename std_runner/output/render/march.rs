//! Along a ray: smoke, a body, the floor, and what is behind.

use super::blocks::{Blocks, LEAST};
use super::camera::{Ray, Vector, dot};
use super::lamp::LAMPS;
use super::stage::Stage;
use super::volume::Volume;

/// What is behind less than this is not seen.
const OPAQUE: f32 = 0.004;
/// How much light a body and the floor return.
const GREY: f32 = 0.30;
const FLOOR: f32 = 0.045;
/// Light from everywhere on them.
const AROUND: [f32; 3] = [0.14, 0.15, 0.18];
/// The backdrop at the height of the eye, and above.
const BACKDROP: [[f32; 3]; 2] = [[0.0130, 0.0142, 0.0180], [0.0050, 0.0055, 0.0075]];

type Colour = [f32; 3];

/// The light along `ray`, and the distance of the body that it ends at, if it does; each step is seen at the part `jitter` of it, the last one of what is left.
pub(super) fn look(stage: &Stage, ray: &Ray, jitter: f32) -> (Colour, f32) {
    let mut light = [0.0; 3];
    let mut clear = 1.0_f32;
    let mut begin = ray.near;
    while begin < ray.far && clear > OPAQUE {
        let step = stage.stride.min(ray.far - begin);
        let distance = begin + jitter * step;
        let point = ray.along(distance);
        let (block, busy) = stage.blocks.at(point);
        if !busy {
            let steps = ((leaves(ray, block) - distance) / stage.stride).ceil();
            begin += stage.stride * steps.max(1.0);
            continue;
        }
        if let Some(body) = &stage.body
            && body.at(point) > 0.5
        {
            let shaded = surface(stage, ray, distance);
            return (with(light, shaded, clear), distance);
        }
        let density = stage.density.at(point);
        if density > LEAST {
            let through = (-stage.extinction * step * density).exp();
            light = with(light, stage.glow(point), clear * (1.0 - through));
            clear *= through;
        }
        begin += stage.stride;
    }
    (with(light, behind(stage, ray), clear), f32::INFINITY)
}

/// The distance at which a ray leaves a block.
#[inline]
fn leaves(ray: &Ray, block: [usize; 3]) -> f32 {
    let mut leaves = f32::INFINITY;
    for axis in 0..3 {
        let [low, high] = Blocks::sides(block[axis]);
        let side = if ray.direction[axis] > 0.0 { high } else { low };
        leaves = leaves.min((side - ray.origin[axis]) / ray.direction[axis]);
    }
    leaves
}

#[inline]
fn with(light: Colour, more: Colour, part: f32) -> Colour {
    [
        light[0] + part * more[0],
        light[1] + part * more[1],
        light[2] + part * more[2],
    ]
}

/// A matt body that a ray is inside of at `distance` and was not a step before.
fn surface(stage: &Stage, ray: &Ray, distance: f32) -> Colour {
    let Some(body) = &stage.body else {
        return [0.0; 3];
    };
    let (mut outside, mut inside) = ((distance - stage.stride).max(ray.near), distance);
    let at_the_side = body.at(ray.along(outside)) > 0.5;
    for _ in 0..6 {
        let middle = 0.5 * (outside + inside);
        if body.at(ray.along(middle)) > 0.5 {
            inside = middle;
        } else {
            outside = middle;
        }
    }
    let point = ray.along(inside);
    let normal = if at_the_side {
        side(stage, ray.along(ray.near))
    } else {
        unit(body.gradient(point).map(|part| -part))
    };
    // Light is looked up outside of the body, which shades itself.
    let before: Vector = core::array::from_fn(|axis| point[axis] + 1.8 * normal[axis]);
    let mut light = AROUND.map(|part| part * (0.6 + 0.4 * normal[2]));
    for (lamp, clear) in LAMPS.iter().zip(&stage.clear) {
        let part = dot(lamp.toward, normal).max(0.0) * clear.at(before);
        light = with(light, lamp.colour, part);
    }
    light.map(|part| GREY * part)
}

/// The normal of the side of the box at a point of it.
fn side(stage: &Stage, point: Vector) -> Vector {
    let mut nearest = (f32::INFINITY, [0.0; 3]);
    for axis in 0..3 {
        for (distance, sign) in [(point[axis], -1.0), (stage.cells[axis] as f32 - point[axis], 1.0)] {
            if distance < nearest.0 {
                let mut normal = [0.0; 3];
                normal[axis] = sign;
                nearest = (distance, normal);
            }
        }
    }
    nearest.1
}

fn unit(vector: Vector) -> Vector {
    let length = dot(vector, vector).sqrt().max(1e-9);
    vector.map(|part| part / length)
}

/// The floor with the shadows on it, which gets lost in the dark, and the backdrop.
fn behind(stage: &Stage, ray: &Ray) -> Colour {
    let height = (0.5 + 1.6 * ray.direction[2]).clamp(0.0, 1.0);
    let [level, above] = BACKDROP;
    let backdrop: Colour =
        core::array::from_fn(|channel| level[channel] + height * height * (above[channel] - level[channel]));
    if ray.direction[2] >= -1e-4 {
        return backdrop;
    }
    let point = ray.along(-ray.origin[2] / ray.direction[2]);
    let sides = stage.cells.map(|count| count as f32);
    let radius = 0.5 * sides[0].hypot(sides[1]);
    let away = (point[0] - 0.5 * sides[0]).hypot(point[1] - 0.5 * sides[1]) / radius;
    let mut light = AROUND;
    for (lamp, clear) in LAMPS.iter().zip(&stage.clear) {
        let part = lamp.toward[2] * arrives(clear, sides, point, lamp.toward);
        light = with(light, lamp.colour, part);
    }
    let seen = 1.0 / (1.0 + 0.55 * away.powi(4));
    core::array::from_fn(|channel| backdrop[channel] * (1.0 - seen) + seen * FLOOR * light[channel])
}

/// How much of a lamp's light arrives at a point of the floor: what arrives where its ray leaves the box.
fn arrives(clear: &Volume, sides: Vector, point: Vector, toward: Vector) -> f32 {
    let (mut near, mut far) = (0.0_f32, f32::INFINITY);
    for axis in 0..3 {
        let ends = [0.0, sides[axis]].map(|side| (side - point[axis]) / toward[axis]);
        near = near.max(ends[0].min(ends[1]));
        far = far.min(ends[0].max(ends[1]));
    }
    if near >= far {
        return 1.0;
    }
    clear.at(core::array::from_fn(|axis| point[axis] + near * toward[axis]))
}

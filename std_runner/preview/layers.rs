//! What a scene draws, layer by layer.

use crate::bytes::{are_free, rounded};
use crate::exit::Failure;
use crate::keyframes::{Canvas, Note, ShapeSpec};
use crate::plan::size_in_words;
use crate::run::drawing_bytes;
use crate::run::drawn::{drawn, solid_cells};
use crate::scene::Scene;
use crate::stay::Stay;

/// What a layer is for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Role {
    /// Smoke at the beginning.
    Source,
    /// Smoke that is made, and from which step to which.
    Emitter(Stay),
    /// Smoke that is wanted, and when.
    Keyframe(Stay),
    /// Where a keyframe matters.
    Region,
    /// Where force may act.
    Mask,
    /// Where nothing flows.
    Solid,
}

/// A field on the cells of a scene.
#[derive(Clone)]
pub(crate) struct Layer {
    /// Its key in the scene.
    pub key: String,
    pub role: Role,
    pub values: Vec<f64>,
}

impl Layer {
    /// What it is, in the words of a caption.
    pub fn title(&self) -> String {
        match self.role {
            Role::Keyframe(stay) | Role::Emitter(stay) if stay.is_held() => {
                format!("{}, steps {} to {}", self.key, stay.first, stay.last)
            }
            Role::Keyframe(stay) => format!("{}, step {}", self.key, stay.first),
            _ => self.key.clone(),
        }
    }

    /// The sum of its values.
    pub fn sum(&self) -> f64 {
        self.values.iter().sum()
    }
}

/// The volume, in 2D the area, of a cell.
pub(crate) fn cell_volume(canvas: &Canvas) -> f64 {
    canvas.cell_size().powi(canvas.dimensions() as i32)
}

/// Refuses a scene all of whose layers, which are there at once, have no room.
fn check_memory(scene: &Scene) -> Result<(), Failure> {
    let regions = scene
        .keyframes
        .iter()
        .filter(|keyframe| keyframe.region.is_some());
    let single = [
        scene.source.is_some(),
        scene.control.mask.is_some(),
        !scene.obstacles.is_empty(),
    ];
    let single = single.into_iter().filter(|&there| there).count();
    let count = scene.emitters.len() + scene.keyframes.len() + regions.count() + single;
    // Among obstacles the smoke that they leave is another one.
    let each = if scene.obstacles.is_empty() { 1 } else { 2 };
    let field = size_of::<f64>() * scene.grid.cells.iter().product::<usize>();
    let bytes = field
        .saturating_mul(each * count)
        .saturating_add(drawing_bytes(&scene.grid.cells));
    if are_free(bytes) {
        return Ok(());
    }
    Err(Failure::Memory(format!(
        "{}: {count} shapes on {} cells take {} while they are looked at, which the system has not; look at them on fewer cells, by --set grid.cells",
        scene.document.path().display(),
        size_in_words(&scene.grid.cells),
        rounded(bytes)
    )))
}

/// Draws all of `scene`; what was found in files is added to `notes`.
///
/// # Errors
/// A shape is refused, or there is no memory for all of them.
pub(crate) fn layers(scene: &Scene, notes: &mut Vec<Note>) -> Result<Vec<Layer>, Failure> {
    check_memory(scene)?;
    let mut layers = Vec::new();
    let mut add = |key: &str, role: Role, shape: &ShapeSpec, notes: &mut Vec<Note>| {
        let values = drawn(scene, key, shape, notes)?;
        layers.push(Layer {
            key: key.to_owned(),
            role,
            values,
        });
        Ok::<_, Failure>(())
    };
    if let Some(source) = &scene.source {
        add("source", Role::Source, source, notes)?;
    }
    for emitter in &scene.emitters {
        let stay = Stay {
            first: emitter.emits.from,
            last: emitter.emits.to,
        };
        add(&emitter.key, Role::Emitter(stay), &emitter.shape, notes)?;
    }
    for keyframe in &scene.keyframes {
        add(
            &keyframe.key,
            Role::Keyframe(keyframe.stay()),
            &keyframe.shape,
            notes,
        )?;
        if let Some(region) = &keyframe.region {
            add(&format!("{}.region", keyframe.key), Role::Region, region, notes)?;
        }
    }
    if let Some(mask) = &scene.control.mask {
        add("control.mask", Role::Mask, mask, notes)?;
    }
    if let Some(solid) = solid_cells(scene, notes)? {
        let values = solid
            .into_iter()
            .map(|solid| f64::from(u8::from(solid)))
            .collect();
        layers.push(Layer {
            key: "obstacle".into(),
            role: Role::Solid,
            values,
        });
    }
    Ok(layers)
}

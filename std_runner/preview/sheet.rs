//! All layers of a scene in one picture.

use super::layers::{Layer, Role, cell_volume};
use crate::keyframes::{Canvas, caption};
use crate::output::{Body, Colours, OutputError, Picture, Smoke};
use std::path::Path;

/// Pixels of a panel's picture along x, and around it.
const WIDE: usize = 320;
const GAP: usize = 12;
/// Pixels of a line of a caption.
const LINE: usize = 20;
/// Panels beside each other, and at most in all: of longer sequences some steps are shown.
const COLUMNS: usize = 4;
const MOST: usize = 24;
/// Light of the ground and of letters.
const GROUND: u8 = 24;
const LETTERS: u8 = 232;

/// The PNG file of `layers`, each with its name and its mass.
pub(crate) fn sheet(canvas: &Canvas, layers: &[Layer], path: &Path) -> Result<Vec<u8>, OutputError> {
    let shown: Vec<&Layer> = shown(layers);
    let full = layers
        .iter()
        .filter(|layer| matches!(layer.role, Role::Source | Role::Keyframe(_)));
    let full = full.flat_map(|layer| &layer.values).copied().fold(0.0, f64::max);
    let solid = layers.iter().find(|layer| layer.role == Role::Solid);
    let narrow = |layer: &Layer| -> Vec<f32> { layer.values.iter().map(|&value| value as f32).collect() };
    let body = solid.and_then(|layer| Body::new(&canvas.cells, &narrow(layer)));
    let panels: Vec<(Picture, [String; 2])> = shown
        .iter()
        .map(|layer| {
            let densest = layer.values.iter().copied().fold(0.0, f64::max);
            let full = if matches!(layer.role, Role::Source | Role::Keyframe(_)) {
                full
            } else {
                densest
            };
            let values = if layer.role == Role::Solid {
                vec![0.0; layer.values.len()]
            } else {
                narrow(layer)
            };
            let picture = Smoke::new(&canvas.cells, values, full as f32, body.clone()).photograph();
            (picture, [layer.title(), said(canvas, layer)])
        })
        .collect();
    let high = panels
        .iter()
        .map(|(picture, _)| picture.height * WIDE / picture.width.max(1))
        .max()
        .unwrap_or(1);
    let columns = COLUMNS.min(panels.len()).max(1);
    let cell = [WIDE + GAP, high + 2 * LINE + GAP];
    let (width, height) = (
        GAP + columns * cell[0],
        GAP + panels.len().div_ceil(columns) * cell[1],
    );
    let mut page = Page {
        width,
        bytes: vec![GROUND; 3 * width * height],
    };
    for (index, (picture, lines)) in panels.iter().enumerate() {
        let corner = [GAP + index % columns * cell[0], GAP + index / columns * cell[1]];
        for (number, line) in lines.iter().enumerate() {
            page.write(line, [corner[0], corner[1] + number * LINE]);
        }
        page.paste(picture, [corner[0], corner[1] + 2 * LINE]);
    }
    let picture = Picture {
        width,
        height,
        bytes: page.bytes,
        colours: Colours::Each,
    };
    picture.to_png().map_err(OutputError::of(path))
}

/// The layers that are drawn: all, or of too many keyframes and their regions some from first to last.
pub(crate) fn shown(layers: &[Layer]) -> Vec<&Layer> {
    let is_of_a_step = |layer: &Layer| matches!(layer.role, Role::Keyframe(_) | Role::Region);
    let steps: Vec<usize> = (0..layers.len())
        .filter(|&index| layers.get(index).is_some_and(is_of_a_step))
        .collect();
    let room = MOST.saturating_sub(layers.len() - steps.len()).max(2);
    if steps.len() <= room {
        return layers.iter().collect();
    }
    let kept = |number: usize| steps.get(number * (steps.len() - 1) / (room - 1));
    let kept: Vec<&usize> = (0..room).filter_map(kept).collect();
    let numbered = layers.iter().enumerate();
    let drawn = numbered.filter(|(index, layer)| !is_of_a_step(layer) || kept.contains(&index));
    drawn.map(|(_, layer)| layer).collect()
}

/// How much of it there is.
fn said(canvas: &Canvas, layer: &Layer) -> String {
    let volume = layer.sum() * cell_volume(canvas);
    match layer.role {
        Role::Source | Role::Keyframe(_) | Role::Emitter(_) => format!("mass {volume:.5}"),
        Role::Region | Role::Mask | Role::Solid if canvas.dimensions() == 3 => format!("volume {volume:.5}"),
        Role::Region | Role::Mask | Role::Solid => format!("area {volume:.5}"),
    }
}

struct Page {
    width: usize,
    bytes: Vec<u8>,
}

impl Page {
    fn pixel(&mut self, x: usize, y: usize) -> Option<&mut [u8]> {
        let at = 3 * (y * self.width + x);
        self.bytes.get_mut(at..at + 3)
    }

    fn write(&mut self, line: &str, [left, top]: [usize; 2]) {
        for (index, ink) in caption(line, WIDE, LINE).into_iter().enumerate() {
            let (x, y) = (left + index % WIDE, top + LINE - 1 - index / WIDE);
            if let Some(pixel) = self.pixel(x, y) {
                let light = f64::from(GROUND) + ink * f64::from(LETTERS - GROUND);
                pixel.fill(light.round().clamp(0.0, 255.0) as u8);
            }
        }
    }

    fn paste(&mut self, picture: &Picture, [left, top]: [usize; 2]) {
        let high = picture.height * WIDE / picture.width.max(1);
        let colours = picture.rgb();
        for y in 0..high {
            for x in 0..WIDE {
                let from = (y * picture.height / high.max(1)) * picture.width + x * picture.width / WIDE;
                if let (Some(colour), Some(pixel)) = (colours.get(from), self.pixel(left + x, top + y)) {
                    pixel.copy_from_slice(colour);
                }
            }
        }
    }
}

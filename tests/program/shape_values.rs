//! Values of arrays and of pictures, one by one: the order of NumPy's arrays, long ones, alpha and windows of EXR.

use super::shape_keys::folder;
use exr::prelude::*;
use std::fs;
use std::path::Path;
use thurible::keyframes::{Canvas, ShapeSpec};

fn canvas(cells: usize) -> Canvas {
    Canvas {
        cells: vec![cells; 2],
        periodic: vec![false; 2],
        length: 1.0,
    }
}

fn draw(shape: &str, cells: usize, base: &Path) -> Vec<f64> {
    let spec: ShapeSpec = toml::from_str(shape).unwrap();
    spec.rasterise(&canvas(cells), base).unwrap()
}

fn npy(order: &str, side: usize, values: impl Iterator<Item = f32>) -> Vec<u8> {
    let header = format!("{{'descr': '<f4', 'fortran_order': {order}, 'shape': ({side}, {side}), }}\n");
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((header.len() as u16).to_le_bytes());
    bytes.extend(header.bytes());
    bytes.extend(values.flat_map(f32::to_le_bytes));
    bytes
}

#[test]
fn arrays_of_either_order_are_the_same_however_long() {
    let base = folder("array_orders");
    for side in [3, 100] {
        let value = |row: usize, column: usize| 0.25 + (row * side + column) as f32 / (side * side) as f32;
        let rows = (0..side * side).map(|at| value(at / side, at % side));
        let columns = (0..side * side).map(|at| value(at % side, at / side));
        let mut file = npy("False", side, rows);
        // What follows the values is not theirs.
        file.extend([0xff; 64]);
        fs::write(base.join("rows.npy"), file).unwrap();
        fs::write(base.join("columns.npy"), npy("True", side, columns)).unwrap();
        let drawn = draw("file = \"rows.npy\"", side, &base);
        assert_eq!(drawn[side + 2], f64::from(value(1, 2)));
        assert_eq!(draw("file = \"columns.npy\"", side, &base), drawn, "{side}");
    }
}

/// Values in units of their own are taken where `density` makes smoke of them, and told of where it does not.
#[test]
fn faint_values_are_multiplied_by_their_density() {
    let base = folder("array_faint");
    fs::write(
        base.join("faint.npy"),
        npy("False", 4, [0.005_f32; 16].into_iter()),
    )
    .unwrap();
    let drawn = draw("file = \"faint.npy\"\ndensity = 100", 4, &base);
    assert!((drawn[5] - 0.5).abs() < 1e-6, "{}", drawn[5]);
    let spec: ShapeSpec = toml::from_str("file = \"faint.npy\"").unwrap();
    let refused = spec.rasterise(&canvas(4), &base).unwrap_err().to_string();
    for word in [
        "faint.npy` puts no more than 5.0e-3 into the box",
        "a larger `density`",
    ] {
        assert!(refused.contains(word), "{refused}");
    }
}

/// A picture of bytes in an array is 255 times as dense as it looks.
#[test]
fn whole_numbers_up_to_white_are_told_of() {
    let base = folder("array_whole");
    for (name, values, told) in [
        ("bytes.npy", [0.0, 255.0, 17.0, 128.0], true),
        ("parts.npy", [0.0, 1.0, 0.5, 200.5], false),
        ("mask.npy", [0.0, 1.0, 1.0, 0.0], false),
    ] {
        fs::write(base.join(name), npy("False", 2, values.into_iter())).unwrap();
        let spec: ShapeSpec = toml::from_str(&format!("file = \"{name}\"")).unwrap();
        let mut notes = Vec::new();
        spec.rasterise_noting(&canvas(2), &base, &mut notes).unwrap();
        let is_told = notes
            .iter()
            .any(|note| note.warning && note.text.contains("write density = 3.922e-3"));
        assert_eq!(is_told, told, "{name}: {notes:?}");
    }
}

#[test]
fn alpha_of_exr_is_taken_out_of_its_colours_and_windows_are_kept() {
    let base = folder("exr_window");
    let channels = SpecificChannels::rgba(|_: Vec2<usize>| (0.25_f32, 0.25_f32, 0.25_f32, 0.5_f32));
    let attributes = LayerAttributes {
        layer_position: Vec2(11, 23),
        ..LayerAttributes::default()
    };
    let layer = Layer::new((4, 4), attributes, Encoding::UNCOMPRESSED, channels);
    let mut image = Image::from_layer(layer);
    image.attributes.display_window = IntegerBounds::new((10, 20), (8, 8));
    image.write().to_file(base.join("a.exr")).unwrap();
    // A pixel from the left of the window, and a pixel from below.
    let inside = |cell: usize| (1..5).contains(&(cell % 8)) && (1..5).contains(&(cell / 8));
    for (ink, expected) in [("", 0.5), ("\nink = \"light\"", 0.25), ("\nink = \"dark\"", 0.25)] {
        let drawn = draw(&format!("image = \"a.exr\"{ink}"), 8, &base);
        for (cell, value) in drawn.into_iter().enumerate() {
            let expected = if inside(cell) { expected } else { 0.0 };
            assert_eq!(value, expected, "{ink} cell {cell}");
        }
    }
}

/// A level that is no number is refused; one beyond all numbers is as one that is lighter than white.
#[test]
fn pictures_of_what_is_no_number_are_refused() {
    let base = folder("picture_not_finite");
    let drawn = |odd: f32| {
        let channels = SpecificChannels::rgba(move |at: Vec2<usize>| {
            let alpha = if at == Vec2(2, 1) { odd } else { 0.5 };
            (0.25_f32, 0.25_f32, 0.25_f32, alpha)
        });
        let image = Image::from_channels((4, 4), channels);
        image.write().to_file(base.join("a.exr")).unwrap();
        let spec: ShapeSpec = toml::from_str("image = \"a.exr\"\nink = \"alpha\"").unwrap();
        spec.rasterise(&canvas(4), &base)
    };
    let error = drawn(f32::NAN).unwrap_err().to_string();
    assert!(
        error.contains("a.exr") && error.contains("must be finite"),
        "{error}"
    );
    // A pixel from the left of the picture, and from below.
    let opaque = drawn(f32::INFINITY).unwrap();
    assert_eq!((opaque[2 + 2 * 4], opaque[0]), (1.0, 0.5));
}

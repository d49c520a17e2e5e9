//! Which pixels of a picture become smoke, how exactly, and what is said of it.

use crate::support::{fresh_folder, run};
use std::fs;
use std::path::Path;
use thurible::keyframes::{Canvas, Note, ShapeSpec};

const SIDE: usize = 16;

/// Writes a picture of `SIDE` x `SIDE` pixels, whose samples `pixel` gives by column and row from the top.
fn picture(path: &Path, color: png::ColorType, pixel: impl Fn(usize, usize) -> Vec<u8>) {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, SIDE as u32, SIDE as u32);
    encoder.set_color(color);
    let samples: Vec<u8> = (0..SIDE * SIDE)
        .flat_map(|index| pixel(index % SIDE, index / SIDE))
        .collect();
    if samples.len() > SIDE * SIDE * color.samples() {
        encoder.set_depth(png::BitDepth::Sixteen);
    }
    encoder
        .write_header()
        .unwrap()
        .write_image_data(&samples)
        .unwrap();
    fs::write(path, bytes).unwrap();
}

/// Densities in the order of the picture, row by row from the top, and what is said.
fn drawn(folder: &Path, keys: &str) -> (Vec<f64>, Vec<Note>) {
    let canvas = Canvas {
        cells: vec![SIDE; 2],
        periodic: vec![false; 2],
        length: 1.0,
    };
    let spec: ShapeSpec = toml::from_str(&format!("image = \"a.png\"\n{keys}")).unwrap();
    let mut notes = Vec::new();
    let cells = spec.rasterise_noting(&canvas, folder, &mut notes).unwrap();
    let rows = cells.chunks(SIDE).rev();
    (rows.flatten().copied().collect(), notes)
}

fn is_inside(x: usize, y: usize) -> bool {
    (x as f64 - 7.5).hypot(y as f64 - 6.5) < 4.0
}

/// Where `is_inside` is smoke, with at most `error` less or more.
fn assert_disc(cells: &[f64], error: f64) {
    for (index, found) in cells.iter().enumerate() {
        let expected = f64::from(u8::from(is_inside(index % SIDE, index / SIDE)));
        assert!((found - expected).abs() <= error, "{index}: {found}");
    }
}

fn said(notes: &[Note]) -> String {
    notes
        .iter()
        .map(|note| note.text.as_str())
        .collect::<Vec<_>>()
        .join("\n")
}

#[test]
fn alpha_is_taken_where_colours_say_nothing() {
    let folder = fresh_folder("pictures_alpha");
    let path = folder.join("a.png");
    picture(&path, png::ColorType::Rgba, |x, y| {
        vec![0, 0, 0, 255 * u8::from(is_inside(x, y))]
    });
    let (cells, notes) = drawn(&folder, "");
    assert_disc(&cells, 0.0);
    assert!(
        said(&notes).contains("smoke is the alpha of") && notes.len() == 1,
        "{notes:?}"
    );
    // A soft edge may have a rounded colour.
    picture(&path, png::ColorType::Rgba, |x, y| match (is_inside(x, y), x) {
        (true, 7) => vec![201, 99, 10, 200],
        (inside, _) => vec![200, 100, 10, 255 * u8::from(inside)],
    });
    assert!(said(&drawn(&folder, "").1).contains("alpha"));
}

#[test]
fn one_clear_pixel_does_not_make_a_picture_full() {
    let folder = fresh_folder("pictures_clear");
    picture(&folder.join("a.png"), png::ColorType::Rgba, |x, y| {
        let level = 255 * u8::from(is_inside(x, y));
        vec![level, level, level, if (x, y) == (7, 7) { 254 } else { 255 }]
    });
    let (cells, notes) = drawn(&folder, "");
    assert_disc(&cells, 1.0 / 250.0);
    assert!(said(&notes).contains("smoke is the luminance of"), "{notes:?}");
    // Colours over black: what is clear is no smoke, whatever its colour.
    picture(
        &folder.join("a.png"),
        png::ColorType::GrayscaleAlpha,
        |x, y| match (x, y) {
            (0, _) => vec![128, 255],
            _ => vec![255, 255 * u8::from(is_inside(x, y))],
        },
    );
    let (mut cells, _) = drawn(&folder, "");
    for row in cells.chunks_mut(SIDE) {
        assert!((row[0] - 128.0 / 255.0).abs() < 1e-9);
        row[0] = 0.0;
    }
    assert_disc(&cells, 0.0);
}

#[test]
fn a_key_says_that_dark_is_smoke() {
    let folder = fresh_folder("pictures_dark");
    let path = folder.join("a.png");
    picture(&path, png::ColorType::Grayscale, |x, y| {
        vec![255 * u8::from(!is_inside(x, y))]
    });
    let (cells, notes) = drawn(&folder, "");
    assert!(
        cells[0] == 1.0 && notes.len() == 2 && notes[1].warning,
        "{notes:?}"
    );
    assert!(
        notes[1].text.contains("80 % of the picture") && notes[1].text.contains("ink = \"dark\""),
        "{notes:?}"
    );
    let (cells, notes) = drawn(&folder, "ink = \"dark\"");
    assert_disc(&cells, 0.0);
    assert!(
        notes.len() == 1 && said(&notes).contains("smoke is the dark ink of"),
        "{notes:?}"
    );
    // On transparent paper too, and the other words.
    picture(&path, png::ColorType::GrayscaleAlpha, |x, y| {
        vec![40 * u8::from(x < 8), 255 * u8::from(is_inside(x, y))]
    });
    let dark = drawn(&folder, "ink = \"dark\"").0;
    assert!(
        (dark[7 * SIDE + 5] - (1.0 - 40.0 / 255.0)).abs() < 1e-9
            && dark[7 * SIDE + 9] == 1.0
            && dark[0] == 0.0
    );
    let light = drawn(&folder, "ink = \"light\"").0;
    assert!((light[7 * SIDE + 5] - 40.0 / 255.0).abs() < 1e-9 && light[7 * SIDE + 9] == 0.0);
    assert_disc(&drawn(&folder, "ink = \"alpha\"").0, 0.0);
}

#[test]
fn all_sixteen_bits_count() {
    let folder = fresh_folder("pictures_sixteen");
    let level = |x: usize, y: usize| (x * 4111 + y * 13) as u16;
    picture(&folder.join("a.png"), png::ColorType::Grayscale, |x, y| {
        level(x, y).to_be_bytes().to_vec()
    });
    let (cells, _) = drawn(&folder, "");
    for (index, found) in cells.iter().enumerate() {
        let expected = f64::from(level(index % SIDE, index / SIDE)) / 65535.0;
        assert!(
            (found - expected).abs() < 1e-12,
            "{index}: {found}, not {expected}"
        );
    }
}

#[test]
fn palettes_and_few_bits_are_read() {
    let folder = fresh_folder("pictures_palette");
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, SIDE as u32, SIDE as u32);
    encoder.set_color(png::ColorType::Indexed);
    encoder.set_depth(png::BitDepth::One);
    encoder.set_palette(vec![0, 0, 0, 255, 255, 255]);
    let rows = (0..SIDE)
        .flat_map(|y| [0, 8].map(|x| (0..8).fold(0, |byte, bit| 2 * byte + u8::from(is_inside(x + bit, y)))));
    let samples: Vec<u8> = rows.collect();
    encoder
        .write_header()
        .unwrap()
        .write_image_data(&samples)
        .unwrap();
    fs::write(folder.join("a.png"), bytes).unwrap();
    // The weights of the three colours sum to 1 but for rounding.
    assert_disc(&drawn(&folder, "").0, 1e-12);
}

#[test]
fn wrong_inks_are_refused() {
    let folder = fresh_folder("pictures_refused");
    picture(&folder.join("a.png"), png::ColorType::Grayscale, |x, _| {
        vec![16 * x as u8]
    });
    for (shape, expected) in [
        (
            "image = \"a.png\"\nink = \"red\"",
            "`ink` is \"red\"; write \"light\", \"dark\" or \"alpha\"",
        ),
        ("image = \"a.png\"\nink = \"alpha\"", "is opaque everywhere"),
        ("text = \"F\"\nink = \"dark\"", "`ink` is a key of `image`"),
    ] {
        let spec: ShapeSpec = toml::from_str(shape).unwrap();
        let canvas = Canvas {
            cells: vec![SIDE; 2],
            periodic: vec![false; 2],
            length: 1.0,
        };
        let error = spec.rasterise(&canvas, &folder).unwrap_err().to_string();
        assert!(error.contains(expected), "{error}");
    }
}

/// In 3D it stands upright, seen from -y, as it would in a flat box, in the middle and as thick as it is said.
#[test]
fn a_picture_in_a_box_stands_upright_and_is_extruded_along_y() {
    const DEEP: usize = 10;
    let folder = fresh_folder("pictures_deep");
    picture(&folder.join("a.png"), png::ColorType::Grayscale, |x, y| {
        vec![if y < 4 {
            102
        } else {
            255 * u8::from(is_inside(x, y))
        }]
    });
    let (rows, _) = drawn(&folder, "ink = \"light\"");
    let canvas = Canvas {
        cells: vec![SIDE, DEEP, SIDE],
        periodic: vec![false; 3],
        length: 1.0,
    };
    let said = "image = \"a.png\"\nink = \"light\"\n";
    let spec = |keys: &str| -> ShapeSpec { toml::from_str(&format!("{said}{keys}")).unwrap() };
    let parts = |layer: usize, half: f64| {
        let outside = (layer as f64 - 4.5).abs() - half;
        [0.5 - 0.5 * outside.tanh(), f64::from(u8::from(outside <= 0.0))]
    };
    // Four cells, and where nothing is said 0.15 of the box's height.
    for (keys, half) in [("depth = 0.25", 2.0), ("", 1.2)] {
        let soft = spec(keys).rasterise(&canvas, &folder).unwrap();
        let cut = spec(keys).cut_noting(&canvas, &folder, &mut Vec::new()).unwrap();
        for (at, (soft, cut)) in soft.iter().zip(cut).enumerate() {
            let (x, layer, z) = (at % SIDE, at / SIDE % DEEP, at / (SIDE * DEEP));
            let flat = rows[(SIDE - 1 - z) * SIDE + x];
            let [part, whole] = parts(layer, half);
            assert!((soft - flat * part).abs() < 1e-12, "{keys}: {x} {layer} {z}");
            assert!((cut - flat * whole).abs() < 1e-12, "{keys}: {x} {layer} {z}");
        }
    }
    for (keys, expected) in [
        ("depth = -1.0", "`depth` is -1"),
        ("height = 0.5", "`height` is a key of `text`"),
    ] {
        let error = spec(keys).rasterise(&canvas, &folder).unwrap_err().to_string();
        assert!(error.contains(expected), "{error}");
    }
}

#[test]
fn the_program_says_what_it_took() {
    let folder = fresh_folder("pictures_program");
    picture(&folder.join("a.png"), png::ColorType::Grayscale, |x, y| {
        vec![255 * u8::from(!is_inside(x, y))]
    });
    let scene = folder.join("scene.toml");
    let text = "[grid]\ncells = [16, 16]\n[time]\nsteps = 2\n[source]\ncircle = { center = [0.5, 0.5], radius = 0.3 }\n[[keyframe]]\nstep = 2\nimage = \"a.png\"\n[method]\niterations = 1\n[output]\nframes = false\n";
    fs::write(&scene, text).unwrap();
    let ended = run(&["solve", scene.to_str().unwrap()]);
    assert_eq!(ended.code, 0, "{}", ended.err);
    for words in [
        "\nin keyframe[0]: smoke is the luminance of",
        "\nwarning: in keyframe[0]: 80 % of the picture",
    ] {
        assert!(ended.err.contains(words), "{}", ended.err);
    }
    let ended = run(&[
        "solve",
        scene.to_str().unwrap(),
        "--force",
        "--set",
        "keyframe[0].ink=dark",
        "--json",
    ]);
    assert!(
        ended.out.contains("\"event\":\"note\"") && ended.out.contains("dark ink"),
        "{}",
        ended.out
    );
    assert!(!ended.out.contains("\"event\":\"warning\""), "{}", ended.out);
}

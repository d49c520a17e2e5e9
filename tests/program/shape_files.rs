//! Files that shapes are drawn from: every mistake is a sentence that names the file, and the axes lie the right way.

use super::shape_keys::{canvas, folder, refusal};
use std::fs;
use std::path::Path;
use thurible::keyframes::{Canvas, ShapeSpec, read_velocity};

/// A `.npy` file of the given type, shape and bytes.
fn npy(kind: &str, shape: &str, data: &[u8]) -> Vec<u8> {
    let header = format!("{{'descr': '{kind}', 'fortran_order': False, 'shape': {shape}, }}\n");
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((header.len() as u16).to_le_bytes());
    bytes.extend(header.as_bytes());
    bytes.extend(data);
    bytes
}

fn floats(values: &[f32]) -> Vec<u8> {
    values.iter().flat_map(|value| value.to_le_bytes()).collect()
}

#[test]
fn wrong_files_are_refused_by_name() {
    let base = folder("files");
    let write = |name: &str, bytes: &[u8]| fs::write(base.join(name), bytes).unwrap();
    write("text.npy", b"hello");
    write("text.png", b"hello");
    write("text.npz", b"hello");
    write("text.ttf", b"hello");
    write("text.jpg", b"hello");
    write("nan.npy", &npy("<f4", "(1, 2)", &floats(&[1.0, f32::NAN])));
    write("negative.npy", &npy("<f4", "(1, 2)", &floats(&[1.0, -2.0])));
    write("zero.npy", &npy("<f4", "(1, 2)", &floats(&[0.0, 0.0])));
    write("short.npy", &npy("<f4", "(2, 2)", &floats(&[1.0])));
    write("flat.npy", &npy("<f4", "(4,)", &floats(&[1.0; 4])));
    write("none.npy", &npy("<f4", "(0, 2)", &[]));
    write("complex.npy", &npy("<c8", "(1, 1)", &[0; 8]));
    write("object.npy", &npy("|O", "(1, 1)", &[0; 8]));
    write("huge.npy", &npy("<f8", "(99999999999, 99999999999)", &[]));
    write("minus.npy", &npy("<f8", "(-1, 2)", &[]));
    let table = [
        ("file = \"missing.npy\"", 2, "missing.npy` cannot be read"),
        ("file = \"text.npy\"", 2, "is no NumPy array"),
        ("file = \"text.jpg\"", 2, "unknown extension"),
        ("file = \"text.npz\"\nname = \"density\"", 2, "is no .npz"),
        ("file = \"nan.npy\"", 2, "holds NaN at [0, 1]"),
        ("file = \"negative.npy\"", 2, "holds -2 at [0, 1]"),
        ("file = \"zero.npy\"", 2, "puts nothing"),
        ("file = \"short.npy\"", 2, "promises 16"),
        ("file = \"flat.npy\"", 2, "has the shape (4)"),
        ("file = \"none.npy\"", 2, "has the shape (0 x 2)"),
        ("file = \"zero.npy\"", 3, "a 3D grid takes"),
        ("file = \"complex.npy\"", 2, "type '<c8'"),
        ("file = \"object.npy\"", 2, "type '|O'"),
        ("file = \"huge.npy\"", 2, "that is too many"),
        ("file = \"minus.npy\"", 2, "not NumPy's"),
        ("file = \"zero.npy\"\nname = \"density\"", 2, "remove `name`"),
        ("image = \"missing.png\"", 2, "cannot be read"),
        ("image = \"text.png\"", 2, "cannot be read as PNG"),
        ("image = \"text.png\"", 3, "cannot be read as PNG"),
        (
            "text = \"F\"\nfont = \"missing.ttf\"",
            2,
            "missing.ttf` cannot be read",
        ),
        ("text = \"F\"\nfont = \"text.ttf\"", 2, "is no TrueType"),
    ];
    for (shape, dimensions, expected) in table {
        let error = refusal(shape, dimensions, &base);
        let text = error.to_string();
        assert!(
            text.contains(expected),
            "{shape}\n  said    {text}\n  not     {expected}"
        );
        assert!(text.contains("; "), "no remedy: {text}");
        assert_eq!(
            error.is_unreadable(),
            expected.ends_with("cannot be read"),
            "{text}"
        );
    }
}

#[test]
fn every_cut_and_every_flipped_byte_ends_in_a_sentence_or_a_drawing() {
    let base = folder("mutants");
    let mut png = Vec::new();
    let mut encoder = png::Encoder::new(&mut png, 8, 8);
    encoder.set_color(png::ColorType::Rgba);
    encoder
        .write_header()
        .unwrap()
        .write_image_data(&[200; 256])
        .unwrap();
    let array = npy("<f4", "(2, 2)", &floats(&[1.0, 2.0, 3.0, 4.0]));
    for (name, key, bytes) in [("a.png", "image", png), ("a.npy", "file", array)] {
        for place in 0..bytes.len() {
            for flip in [1, 0x80, 0xff] {
                let mut mutant = bytes.clone();
                mutant[place] ^= flip;
                draw_mutant(&base, name, key, &mutant);
            }
            draw_mutant(&base, name, key, &bytes[..place]);
        }
    }
}

fn draw_mutant(base: &Path, name: &str, key: &str, bytes: &[u8]) {
    fs::write(base.join(name), bytes).unwrap();
    let spec: ShapeSpec = toml::from_str(&format!("{key} = \"{name}\"")).unwrap();
    let _ = spec.rasterise(&canvas(2), base);
}

#[test]
fn arrays_and_pictures_are_drawn_the_right_way_up() {
    let base = folder("right");
    fs::write(
        base.join("a.npy"),
        npy("<f4", "(2, 2)", &floats(&[0.0, 1.0, 2.0, 3.0])),
    )
    .unwrap();
    let small = Canvas {
        cells: vec![4, 4],
        periodic: vec![false; 2],
        length: 1.0,
    };
    let draw = |shape: &str| {
        toml::from_str::<ShapeSpec>(shape)
            .unwrap()
            .rasterise(&small, &base)
            .unwrap()
    };
    let cells = draw("file = \"a.npy\"");
    assert_eq!([cells[0], cells[3], cells[12], cells[15]], [0.0, 1.0, 2.0, 3.0]);
    let mut png = Vec::new();
    let encoder = png::Encoder::new(&mut png, 2, 2);
    encoder
        .write_header()
        .unwrap()
        .write_image_data(&[255, 0, 0, 0])
        .unwrap();
    fs::write(base.join("a.png"), png).unwrap();
    let cells = draw("image = \"a.png\"");
    assert!(
        cells[12] == 1.0 && cells[0] == 0.0 && cells[15] == 0.0,
        "{cells:?}"
    );
}

#[test]
fn velocities_need_their_faces() {
    let base = folder("velocity");
    let path = base.join("v.npz");
    let write = |shapes: [&str; 2], counts: [usize; 2]| {
        let mut archive = zip::ZipWriter::new(fs::File::create(&path).unwrap());
        for (axis, (shape, count)) in ["x", "y"].iter().zip(shapes.iter().zip(counts)) {
            let options = zip::write::SimpleFileOptions::default();
            archive
                .start_file(format!("velocity_{axis}.npy"), options)
                .unwrap();
            std::io::Write::write_all(&mut archive, &npy("<f4", shape, &floats(&vec![0.5; count]))).unwrap();
        }
        archive.finish().unwrap();
    };
    write(["(16, 17)", "(1, 17, 16)"], [272, 272]);
    let velocity = read_velocity(&path, &canvas(2)).unwrap();
    assert_eq!(velocity, vec![vec![0.5; 272]; 2]);
    write(["(16, 16)", "(17, 16)"], [256, 272]);
    let error = read_velocity(&path, &canvas(2)).unwrap_err().to_string();
    assert!(
        error.contains("velocity_x of shape (16 x 16)") && error.contains("[16, 17]"),
        "{error}"
    );
    let error = read_velocity(&path, &canvas(3)).unwrap_err().to_string();
    assert!(error.contains("initial_velocity"), "{error}");
}

//! Meshes as shapes: all formats give the same body, holes and flips and overlaps leave it, and no file is trusted.

use super::shape_keys::{canvas, folder, refusal};
use super::support::run;
use base64::Engine;
use std::fs;
use std::path::Path;
use thurible::keyframes::{Canvas, Note, ShapeSpec};

/// Points and faces of a ball, around `center`.
fn ball(center: [f64; 3], radius: f64) -> (Vec<[f64; 3]>, Vec<[usize; 3]>) {
    let (rings, sides) = (24, 48);
    let mut points = vec![[center[0], center[1], center[2] - radius]];
    for ring in 1..rings {
        let polar = core::f64::consts::PI * ring as f64 / rings as f64;
        for side in 0..sides {
            let around = core::f64::consts::TAU * side as f64 / sides as f64;
            points.push([
                center[0] + radius * polar.sin() * around.cos(),
                center[1] + radius * polar.sin() * around.sin(),
                center[2] - radius * polar.cos(),
            ]);
        }
    }
    points.push([center[0], center[1], center[2] + radius]);
    let (last, at) = (points.len() - 1, |ring: usize, side: usize| {
        1 + ring * sides + side % sides
    });
    let mut faces = Vec::new();
    for side in 0..sides {
        faces.push([0, at(0, side + 1), at(0, side)]);
        faces.push([last, at(rings - 2, side), at(rings - 2, side + 1)]);
        for ring in 0..rings - 2 {
            faces.push([at(ring, side), at(ring, side + 1), at(ring + 1, side)]);
            faces.push([at(ring, side + 1), at(ring + 1, side + 1), at(ring + 1, side)]);
        }
    }
    (points, faces)
}

fn obj(points: &[[f64; 3]], faces: &[[usize; 3]]) -> String {
    let mut text = String::from("# made by a test in C:\\models\\\no ball\n");
    for [x, y, z] in points {
        text.push_str(&format!("v {x} {y} {z}\n"));
    }
    for (index, face) in faces.iter().enumerate() {
        // All ways in which a corner is written.
        let corners = face.map(|corner| match index % 3 {
            0 => format!("{}", corner + 1),
            1 => format!("{}//1", corner + 1),
            _ => format!("{}", corner as i64 - points.len() as i64),
        });
        text.push_str(&format!("f {}\n", corners.join(" ")));
    }
    text
}

fn stl(points: &[[f64; 3]], faces: &[[usize; 3]]) -> Vec<u8> {
    // Some programs begin binary files with this word.
    let mut bytes = b"solid ".to_vec();
    bytes.resize(80, b' ');
    bytes.extend((faces.len() as u32).to_le_bytes());
    for face in faces {
        bytes.extend([0; 12]);
        bytes.extend(
            face.iter()
                .flat_map(|&corner| points[corner])
                .flat_map(|x| (x as f32).to_le_bytes()),
        );
        bytes.extend([0; 2]);
    }
    bytes
}

fn stl_in_words(points: &[[f64; 3]], faces: &[[usize; 3]]) -> String {
    let mut text = String::from("solid ball\n");
    for face in faces {
        text.push_str("facet normal 0 0 0\nouter loop\n");
        for [x, y, z] in face.map(|corner| points[corner]) {
            text.push_str(&format!("vertex {x:e} {y:e} {z:e}\n"));
        }
        text.push_str("endloop\nendfacet\n");
    }
    text + "endsolid ball\n"
}

fn ply(points: &[[f64; 3]], faces: &[[usize; 3]], format: &str) -> Vec<u8> {
    let mut bytes = format!(
        "ply\nformat {format} 1.0\ncomment of a test\nelement vertex {}\nproperty float x\nproperty float y\nproperty double z\nproperty uchar red\n\
         element face {}\nproperty list uchar int vertex_indices\nend_header\n",
        points.len(),
        faces.len()
    )
    .into_bytes();
    let big = format == "binary_big_endian";
    let put = |bytes: &mut Vec<u8>, raw: &[u8]| {
        let mut raw = raw.to_vec();
        if big {
            raw.reverse();
        }
        bytes.extend(raw);
    };
    for &[x, y, z] in points {
        if format == "ascii" {
            bytes.extend(format!("{x} {y} {z} 255\n").bytes());
            continue;
        }
        put(&mut bytes, &(x as f32).to_le_bytes());
        put(&mut bytes, &(y as f32).to_le_bytes());
        put(&mut bytes, &z.to_le_bytes());
        put(&mut bytes, &[255]);
    }
    for face in faces {
        if format == "ascii" {
            bytes.extend(format!("3 {} {} {}\n", face[0], face[1], face[2]).bytes());
            continue;
        }
        put(&mut bytes, &[3]);
        face.iter()
            .for_each(|&corner| put(&mut bytes, &(corner as i32).to_le_bytes()));
    }
    bytes
}

/// The bytes of points and faces, and a glTF text around them; its node turns z up into y up.
fn gltf(points: &[[f64; 3]], faces: &[[usize; 3]], buffer: &str) -> (String, Vec<u8>) {
    let mut bytes: Vec<u8> = points
        .iter()
        .flatten()
        .flat_map(|&x| (2.0 * x as f32).to_le_bytes())
        .collect();
    let split = bytes.len();
    bytes.extend(
        faces
            .iter()
            .flatten()
            .flat_map(|&corner| (corner as u16).to_le_bytes()),
    );
    let text = format!(
        "{{\"asset\":{{\"version\":\"2.0\"}},\"scene\":0,\"scenes\":[{{\"nodes\":[0]}}],\
         \"nodes\":[{{\"children\":[1],\"rotation\":[-0.70710678118,0,0,0.70710678118]}},{{\"mesh\":0,\"scale\":[0.5,0.5,0.5]}}],\
         \"meshes\":[{{\"primitives\":[{{\"attributes\":{{\"POSITION\":0}},\"indices\":1}}]}}],\
         \"accessors\":[{{\"bufferView\":0,\"componentType\":5126,\"count\":{},\"type\":\"VEC3\"}},\
         {{\"bufferView\":1,\"componentType\":5123,\"count\":{},\"type\":\"SCALAR\"}}],\
         \"bufferViews\":[{{\"buffer\":0,\"byteLength\":{split}}},{{\"buffer\":0,\"byteOffset\":{split},\"byteLength\":{}}}],\
         \"buffers\":[{{{buffer}\"byteLength\":{}}}]}}",
        points.len(),
        3 * faces.len(),
        bytes.len() - split,
        bytes.len()
    );
    (text, bytes)
}

fn glb(text: &str, buffer: &[u8]) -> Vec<u8> {
    let mut text = text.as_bytes().to_vec();
    text.resize(text.len().next_multiple_of(4), b' ');
    let mut bytes = b"glTF\x02\0\0\0".to_vec();
    bytes.extend(((28 + text.len() + buffer.len()) as u32).to_le_bytes());
    bytes.extend((text.len() as u32).to_le_bytes());
    bytes.extend(b"JSON");
    bytes.extend(text);
    bytes.extend((buffer.len() as u32).to_le_bytes());
    bytes.extend(b"BIN\0");
    bytes.extend(buffer);
    bytes
}

fn draw(shape: &str, canvas: &Canvas, base: &Path) -> (Vec<f64>, Vec<Note>) {
    let spec: ShapeSpec = toml::from_str(shape).unwrap();
    let mut notes = Vec::new();
    let cells = spec.rasterise_noting(canvas, base, &mut notes);
    (cells.unwrap_or_else(|error| panic!("{shape}: {error}")), notes)
}

fn farthest(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

fn box_of(cells: usize) -> Canvas {
    Canvas {
        cells: vec![cells; 3],
        periodic: vec![false; 3],
        length: 1.0,
    }
}

#[test]
fn every_format_gives_the_ball_that_the_scene_can_write_itself() {
    let base = folder("mesh_formats");
    let (points, faces) = ball([0.4, 0.5, 0.6], 0.25);
    let write = |name: &str, bytes: &[u8]| fs::write(base.join(name), bytes).unwrap();
    write("a.obj", obj(&points, &faces).as_bytes());
    write("a.stl", &stl(&points, &faces));
    write("words.stl", stl_in_words(&points, &faces).as_bytes());
    for format in ["ascii", "binary_little_endian", "binary_big_endian"] {
        write(&format!("{format}.ply"), &ply(&points, &faces, format));
    }
    let (text, buffer) = gltf(&points, &faces, "");
    write("a.glb", &glb(&text, &buffer));
    let within = format!(
        "\"uri\":\"data:application/octet-stream;base64,{}\",",
        base64::engine::general_purpose::STANDARD.encode(&buffer)
    );
    write("within.gltf", gltf(&points, &faces, &within).0.as_bytes());
    write(
        "beside.gltf",
        gltf(&points, &faces, "\"uri\":\"my%20points.bin\",").0.as_bytes(),
    );
    write("my points.bin", &buffer);
    let canvas = box_of(32);
    let (sphere, _) = draw(
        "sphere = { center = [0.4, 0.5, 0.6], radius = 0.25 }",
        &canvas,
        &base,
    );
    for name in [
        "a.obj",
        "a.stl",
        "words.stl",
        "ascii.ply",
        "binary_little_endian.ply",
        "binary_big_endian.ply",
        "a.glb",
        "within.gltf",
        "beside.gltf",
    ] {
        let up = if name == "a.obj" { "up = \"z\"" } else { "" };
        let (cells, notes) = draw(
            &format!("mesh = \"{name}\"\nfit = \"world\"\n{up}"),
            &canvas,
            &base,
        );
        // The mass is the volume of the body; that of the sphere, whose edge is as wide inside as outside, is a little more.
        let volume = 4.0 / 3.0 * core::f64::consts::PI * 0.25_f64.powi(3);
        let (off, mass) = (
            farthest(&sphere, &cells),
            cells.iter().sum::<f64>() / 32.0_f64.powi(3) / volume,
        );
        assert!(
            off < 0.08 && (mass - 1.0).abs() < 0.01,
            "{name}: off by {off}, mass {mass}"
        );
        assert!(
            notes
                .iter()
                .any(|note| note.text.contains("2,208 triangles and is closed")),
            "{name}: {notes:?}"
        );
    }
}

#[test]
fn holes_flips_and_overlaps_leave_the_body_and_are_said() {
    let base = folder("mesh_faults");
    let canvas = box_of(24);
    let (points, faces) = ball([0.5; 3], 0.3);
    let draw_faces = |name: &str, points: &[[f64; 3]], faces: &[[usize; 3]]| {
        fs::write(base.join(name), obj(points, faces)).unwrap();
        draw(
            &format!("mesh = \"{name}\"\nfit = \"world\"\nup = \"z\""),
            &canvas,
            &base,
        )
    };
    let (whole, _) = draw_faces("whole.obj", &points, &faces);
    // One face in fifty is missing.
    let torn: Vec<_> = faces
        .iter()
        .enumerate()
        .filter(|(index, _)| index % 50 != 7)
        .map(|(_, face)| *face)
        .collect();
    let (cells, notes) = draw_faces("torn.obj", &points, &torn);
    assert!(farthest(&whole, &cells) < 0.35, "{}", farthest(&whole, &cells));
    let wrong = whole
        .iter()
        .zip(&cells)
        .filter(|(a, b)| (**a > 0.5) != (**b > 0.5))
        .count();
    assert!(wrong <= 12, "{wrong} cells changed sides");
    assert!(notes[0].text.contains("open edges"), "{notes:?}");
    // All faces the other way round.
    let turned: Vec<_> = faces.iter().map(|&[a, b, c]| [a, c, b]).collect();
    let (cells, notes) = draw_faces("turned.obj", &points, &turned);
    assert!(farthest(&whole, &cells) < 1e-12);
    assert!(
        notes[0].text.contains("100.0 % of its cells inside out"),
        "{notes:?}"
    );
    // Twice the same body, a little moved: no hole where they overlap.
    let (second, _) = ball([0.55, 0.5, 0.5], 0.3);
    let both: Vec<_> = points.iter().chain(&second).copied().collect();
    let twice: Vec<_> = faces
        .iter()
        .copied()
        .chain(faces.iter().map(|face| face.map(|corner| corner + points.len())))
        .collect();
    let (cells, notes) = draw_faces("twice.obj", &both, &twice);
    assert!(whole.iter().zip(&cells).all(|(a, b)| *b > a - 0.15));
    assert!(notes[0].text.contains("covered more than once"), "{notes:?}");
}

#[test]
fn a_mesh_fits_where_it_is_wanted_and_a_sequence_moves() {
    let base = folder("mesh_fit");
    let (points, faces) = ball([7.0, -3.0, 100.0], 50.0);
    fs::write(base.join("a.ply"), ply(&points, &faces, "ascii")).unwrap();
    let canvas = box_of(24);
    let (usual, _) = draw("mesh = \"a.ply\"", &canvas, &base);
    let (sphere, _) = draw(
        "sphere = { center = [0.5, 0.5, 0.5], radius = 0.4 }",
        &canvas,
        &base,
    );
    assert!(farthest(&usual, &sphere) < 0.1);
    let (placed, _) = draw(
        "mesh = \"a.ply\"\nfit = { center = [0.3, 0.4, 0.5], size = 0.5 }\ndensity = 2.0",
        &canvas,
        &base,
    );
    let (sphere, _) = draw(
        "sphere = { center = [0.3, 0.4, 0.5], radius = 0.25 }\ndensity = 2.0",
        &canvas,
        &base,
    );
    assert!(farthest(&placed, &sphere) < 0.2);
    // Around a side that repeats: what leaves on one side comes in on the other.
    let around = Canvas {
        periodic: vec![true; 3],
        ..canvas
    };
    let (placed, _) = draw(
        "mesh = \"a.ply\"\nfit = { center = [0.05, 0.5, 0.98], size = 0.5 }",
        &around,
        &base,
    );
    let (sphere, _) = draw(
        "sphere = { center = [0.05, 0.5, 0.98], radius = 0.25 }",
        &around,
        &base,
    );
    assert!(farthest(&placed, &sphere) < 0.1, "{}", farthest(&placed, &sphere));
}

#[test]
fn wrong_meshes_are_refused_by_name() {
    let base = folder("mesh_refused");
    let write = |name: &str, bytes: &[u8]| fs::write(base.join(name), bytes).unwrap();
    write("points.obj", b"v 0 0 0\nv 1 0 0\n");
    write("far.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n");
    write("word.obj", b"v 0 0 0\nv 1 zero 0\n");
    write("nan.obj", b"v 0 0 0\nv 1 nan 0\nv 0 1 0\nf 1 2 3\n");
    write("one.obj", b"v 1 2 3\nv 1 2 3\nv 1 2 3\nf 1 2 3\n");
    write("text.stl", b"hello");
    write(
        "short.stl",
        &[[b' '; 80].as_slice(), &9_u32.to_le_bytes(), &[0; 50]].concat(),
    );
    write("text.ply", b"hello");
    write("short.ply", b"ply\nformat ascii 1.0\nelement vertex 99999999999\nproperty float x\nproperty float y\nproperty float z\nend_header\n1 2 3\n");
    write(
        "empty.ply",
        b"ply\nformat ascii 1.0\nelement vertex 99999999999999\nend_header\n",
    );
    write("text.gltf", b"hello");
    write(
        "packed.gltf",
        b"{\"extensionsRequired\":[\"KHR_draco_mesh_compression\"]}",
    );
    write("ring.gltf", b"{\"nodes\":[{\"children\":[1]},{\"children\":[2]},{\"children\":[1]}],\"scenes\":[{\"nodes\":[0]}]}");
    write("x.fbx", b"hello");
    let (points, faces) = ball([0.5; 3], 0.3);
    write("ball.obj", obj(&points, &faces).as_bytes());
    write("sheet.obj", b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n");
    let table = [
        ("mesh = \"missing.obj\"", 3, "cannot be read"),
        ("mesh = \"points.obj\"", 3, "has 2 points and no faces"),
        ("mesh = \"far.obj\"", 3, "has a face of point 8"),
        ("mesh = \"word.obj\"", 3, "a point in line 2"),
        ("mesh = \"nan.obj\"", 3, "has a point at [1.0, NaN"),
        ("mesh = \"one.obj\"", 3, "has no size"),
        ("mesh = \"text.stl\"", 3, "is no STL"),
        (
            "mesh = \"short.stl\"",
            3,
            "holds 50 bytes of triangles where its header promises 450",
        ),
        ("mesh = \"text.ply\"", 3, "is no PLY"),
        ("mesh = \"short.ply\"", 3, "ends before its last value"),
        ("mesh = \"empty.ply\"", 3, "no faces"),
        ("mesh = \"text.gltf\"", 3, "is no glTF"),
        ("mesh = \"packed.gltf\"", 3, "packed by KHR_draco"),
        ("mesh = \"ring.gltf\"", 3, "hold each other"),
        (
            "mesh = \"x.fbx\"",
            3,
            "meshes are .obj, .stl, .ply, .gltf or .glb",
        ),
        ("mesh = \"sheet.obj\"", 3, "encloses no cell; an open sheet"),
        ("mesh = \"ball.obj\"", 2, "the grid is 2D"),
        ("mesh = \"ball.obj\"\nup = \"x\"", 3, "write \"y\" or \"z\""),
        ("mesh = \"ball.obj\"\nfit = \"box\"", 3, "write \"world\""),
        ("mesh = \"ball.obj\"\nfit = { size = 0 }", 3, "`fit.size` is 0"),
        (
            "mesh = \"ball.obj\"\nfit = { center = [9, 9, 9], size = 0.5 }",
            3,
            "puts nothing into the box",
        ),
        (
            "sphere = { center = [0.5, 0.5], radius = 0.1 }\nup = \"y\"",
            3,
            "is a key of `mesh`",
        ),
    ];
    for (shape, dimensions, expected) in table {
        let error = refusal(shape, dimensions, &base).to_string();
        assert!(
            error.contains(expected) && error.contains("; "),
            "{shape}\n  said    {error}\n  not     {expected}"
        );
    }
}

/// What lies outside of the box altogether leaves no trace in it, so it is told of.
#[test]
fn a_part_outside_of_the_box_is_told_of() {
    let base = folder("mesh_outside");
    let (near, faces) = ball([0.5; 3], 0.3);
    let (far, _) = ball([2.5, 0.5, 0.5], 0.3);
    let behind = faces.iter().map(|face| face.map(|corner| corner + near.len()));
    let faces: Vec<_> = faces.iter().copied().chain(behind).collect();
    fs::write(base.join("two.obj"), obj(&[near, far].concat(), &faces)).unwrap();
    let world = "mesh = \"two.obj\"\nup = \"z\"\nfit = \"world\"";
    let (_, notes) = draw(world, &box_of(12), &base);
    let told = notes.iter().find(|note| note.warning).unwrap();
    assert!(
        told.text
            .contains("from x = 0.200 to 2.800 where the box ends at 0 and 1.000"),
        "{told:?}"
    );
    let (_, notes) = draw("mesh = \"two.obj\"", &box_of(12), &base);
    assert!(notes.iter().all(|note| !note.warning), "{notes:?}");
}

#[test]
fn a_gltf_file_says_the_same_again_and_again_without_taking_memory() {
    let base = folder("mesh_again");
    let (points, faces) = ball([0.5; 3], 0.3);
    let (text, buffer) = gltf(&points, &faces, "");
    let write = |name: &str, text: &str| fs::write(base.join(name), glb(text, &buffer)).unwrap();
    let primitive = "{\"attributes\":{\"POSITION\":0},\"indices\":1}";
    write("plain.glb", &text);
    let (plain, _) = draw("mesh = \"plain.glb\"", &box_of(12), &base);
    // Lines bound nothing, whatever their points are; primitives may share points.
    let lines = "{\"mode\":1,\"attributes\":{\"POSITION\":7}}";
    write(
        "lines.glb",
        &text.replace(primitive, &format!("{lines},{primitive}")),
    );
    write(
        "shared.glb",
        &text.replace(primitive, &format!("{primitive},{primitive}")),
    );
    let (lines, _) = draw("mesh = \"lines.glb\"", &box_of(12), &base);
    assert_eq!(plain, lines);
    let (shared, notes) = draw("mesh = \"shared.glb\"", &box_of(12), &base);
    assert_eq!(plain, shared);
    assert!(notes[0].text.contains("4,416 triangles"), "{notes:?}");
    // What is too much is known before any of it is read.
    write("many.glb", &text.replace("\"count\":6624", "\"count\":300000000"));
    // A node is there once, however often others name it.
    let many = vec!["1"; 200_000].join(",");
    let nodes = format!(
        "\"nodes\":[{{\"children\":[{many}]}},{{\"children\":[{many}]}}{}]",
        ",{}".repeat(20_000)
    );
    fs::write(
        base.join("children.gltf"),
        format!("{{\"scenes\":[{{\"nodes\":[0]}}],{nodes}}}"),
    )
    .unwrap();
    for (name, expected) in [
        ("many.glb", "has more than 67108864 triangles; reduce it"),
        ("children.gltf", "has nodes that hold each other"),
    ] {
        let error = refusal(&format!("mesh = \"{name}\""), 3, &base).to_string();
        assert!(error.contains(expected), "{name}: {error}");
    }
}

/// A node that mirrors its mesh turns no body inside out: beside and across another one it is smoke as that is.
#[test]
fn a_mirrored_node_is_a_body_like_another() {
    let base = folder("mesh_mirrored");
    let canvas = box_of(24);
    let (points, faces) = ball([0.4, 0.5, 0.5], 0.25);
    let (text, buffer) = gltf(&points, &faces, "");
    // The second ball's middle is at 1 - 0.4, or at 0.4 + 0.2.
    let node = |scale: &str, along: f64| {
        format!("{{\"mesh\":0,\"scale\":[{scale},0.5,0.5],\"translation\":[{along},0,0]}}")
    };
    let mut drawn = Vec::new();
    for (name, second) in [("plain", node("0.5", 0.2)), ("mirrored", node("-0.5", 1.0))] {
        let nodes = text.replace("\"children\":[1]", "\"children\":[1,2]").replace(
            "\"scale\":[0.5,0.5,0.5]}]",
            &format!("\"scale\":[0.5,0.5,0.5]}},{second}]"),
        );
        fs::write(base.join(format!("{name}.glb")), glb(&nodes, &buffer)).unwrap();
        let (cells, notes) = draw(&format!("mesh = \"{name}.glb\"\nfit = \"world\""), &canvas, &base);
        assert!(
            notes.iter().all(|note| !note.text.contains("inside out")),
            "{notes:?}"
        );
        drawn.push(cells);
    }
    assert!(drawn[0].iter().sum::<f64>() > 1200.0);
    let off = farthest(&drawn[0], &drawn[1]);
    assert!(off < 0.1, "{off}");
}

/// Points of another type, sparse ones, numbers of no known type, and accessors that end behind their bytes, or begin there
/// though they hold nothing.
#[test]
fn unusual_accessors_of_a_gltf_file_are_refused() {
    let base = folder("mesh_accessors");
    let (points, faces) = ball([0.5; 3], 0.3);
    let (text, buffer) = gltf(&points, &faces, "");
    let of_points = format!("\"count\":{},\"type\":\"VEC3\"", points.len());
    assert!(text.contains(&of_points));
    let sparse = of_points.clone() + ",\"sparse\":{\"count\":1}";
    let turned = of_points.replace("VEC3", "VEC2");
    let long = format!("\"count\":{},\"type\":\"VEC3\"", points.len() + 1);
    let behind = "\"count\":0,\"byteOffset\":99999999,\"type\":\"VEC3\"";
    for (name, changed, expected) in [
        (
            "sparse",
            text.replace(&of_points, &sparse),
            "stored in an unusual way",
        ),
        (
            "type",
            text.replace(&of_points, &turned),
            "stored in an unusual way",
        ),
        ("number", text.replace("5126", "5130"), "numbers are of type 5130"),
        (
            "behind",
            text.replace(&of_points, behind),
            "reaches beyond its bytes",
        ),
        (
            "long",
            text.replace(&of_points, &long),
            "reaches beyond its bytes",
        ),
    ] {
        fs::write(base.join(format!("{name}.glb")), glb(&changed, &buffer)).unwrap();
        let error = refusal(&format!("mesh = \"{name}.glb\""), 3, &base).to_string();
        assert!(error.contains(expected), "{name}: {error}");
    }
}

/// A device gives bytes without an end, or none.
#[cfg(unix)]
#[test]
fn what_is_no_file_on_a_disk_is_refused() {
    let base = folder("mesh_device");
    let (points, faces) = ball([0.5; 3], 0.3);
    let device = gltf(&points, &faces, "\"uri\":\"/dev/null\",").0;
    fs::write(base.join("device.gltf"), device).unwrap();
    for (shape, dimensions) in [
        ("mesh = \"device.gltf\"", 3),
        ("image = \"/dev/null\"", 2),
        ("text = \"F\"\nfont = \"/dev/null\"", 2),
    ] {
        let error = refusal(shape, dimensions, &base).to_string();
        assert!(error.contains("is no regular file; "), "{shape}: {error}");
    }
}

#[test]
fn a_wall_of_one_cell_stays_where_cells_are_cut() {
    let base = folder("mesh_wall");
    let corners = |index: usize| {
        [
            7.0 / 16.0 + (index & 1) as f64 / 16.0,
            [-0.1, 1.1][index >> 1 & 1],
            [-0.1, 1.1][index >> 2],
        ]
    };
    let sides = [
        [0, 2, 3, 1],
        [4, 5, 7, 6],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 4, 6, 2],
        [1, 3, 7, 5],
    ];
    let points: Vec<_> = (0..8).map(corners).collect();
    let faces: Vec<_> = sides
        .iter()
        .flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]])
        .collect();
    fs::write(base.join("wall.obj"), obj(&points, &faces)).unwrap();
    let scene = base.join("scene.toml");
    let ball = "sphere = { center = [0.2, 0.5, 0.5], radius = 0.15 }";
    let text = format!(
        "[grid]\ncells = [16, 16, 16]\n[time]\nsteps = 4\n[source]\n{ball}\n[[keyframe]]\nstep = 4\n{ball}\n\
         [[obstacle]]\nmesh = \"wall.obj\"\nfit = \"world\"\nup = \"z\"\n"
    );
    fs::write(&scene, text).unwrap();
    let picture = base.join("seen.png");
    let ended = run(&[
        "scene",
        "check",
        scene.to_str().unwrap(),
        "-o",
        picture.to_str().unwrap(),
    ]);
    assert_eq!(ended.code, 0, "{}", ended.err);
    // One layer of cells in sixteen.
    assert!(ended.out.contains("0.0625  obstacle"), "{}", ended.out);
}

#[test]
fn every_cut_and_every_flipped_byte_of_a_mesh_ends_in_a_sentence_or_a_drawing() {
    let base = folder("mesh_mutants");
    let points = [[0.2, 0.2, 0.2], [0.8, 0.2, 0.2], [0.2, 0.8, 0.2], [0.2, 0.2, 0.8]];
    let faces = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
    let (text, buffer) = gltf(&points, &faces, "");
    let files = [
        ("a.obj", obj(&points, &faces).into_bytes()),
        ("a.stl", stl(&points, &faces)),
        ("b.stl", stl_in_words(&points, &faces).into_bytes()),
        ("a.ply", ply(&points, &faces, "ascii")),
        ("b.ply", ply(&points, &faces, "binary_little_endian")),
        ("a.glb", glb(&text, &buffer)),
    ];
    let small = Canvas {
        cells: vec![4; 3],
        ..canvas(3)
    };
    for (name, bytes) in files {
        let spec: ShapeSpec = toml::from_str(&format!("mesh = \"{name}\"")).unwrap();
        let path = base.join(name);
        for place in 0..bytes.len() {
            fs::write(&path, &bytes[..place]).unwrap();
            let _ = spec.rasterise(&small, &base);
            for flip in [1, 0x10, 0x80, 0xff] {
                let mut mutant = bytes.clone();
                mutant[place] ^= flip;
                fs::write(&path, &mutant).unwrap();
                if let Ok(cells) = spec.rasterise(&small, &base) {
                    assert!(
                        cells.iter().all(|cell| (0.0..=1.0 + 1e-9).contains(cell)),
                        "{name} byte {place}"
                    );
                }
            }
        }
    }
}

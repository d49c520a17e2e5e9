//! OpenVDB volumes as shapes: written by OpenVDB itself (`volumes/make.py`), and by a few lines here where that cannot pack as others do.

use super::shape_keys::{folder, refusal};
use super::support::run;
use flate2::{Compression, write::ZlibEncoder};
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use thurible::keyframes::{Canvas, Note, ShapeSpec};

fn given() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/program/volumes")
}

fn box_of(cells: usize) -> Canvas {
    Canvas {
        cells: vec![cells; 3],
        periodic: vec![false; 3],
        length: 1.0,
    }
}

fn draw(shape: &str, canvas: &Canvas, base: &Path) -> (Vec<f64>, Vec<Note>) {
    let spec: ShapeSpec = toml::from_str(shape).unwrap();
    let mut notes = Vec::new();
    let cells = spec.rasterise_noting(canvas, base, &mut notes);
    (cells.unwrap_or_else(|error| panic!("{shape}: {error}")), notes)
}

/// What `make.py` wrote into the middle of voxel (x, y, z).
fn ball(x: usize, y: usize, z: usize) -> f64 {
    let away = |at: usize, middle: f64| at as f64 + 0.5 - middle;
    (6.0 - (away(x, 8.0).powi(2) + away(y, 10.0).powi(2) + away(z, 12.0).powi(2)).sqrt()).clamp(0.0, 1.0)
}

#[test]
fn what_openvdb_wrote_is_read_voxel_by_voxel() {
    // A voxel has a side of 0.05 and its middle at (x, y, z) times that; the box of 20 cells begins half a voxel later.
    for (name, error) in [("blosc_float.vdb", 1e-6), ("blosc_half.vdb", 1e-3)] {
        let (cells, notes) = draw(
            &format!("file = \"{name}\"\nfit = \"world\""),
            &box_of(20),
            &given(),
        );
        for (index, cell) in cells.iter().enumerate() {
            let at = [index % 20, index / 20 % 20, index / 400];
            let mean = |x: usize, y: usize, z: usize| ball(x, y, z);
            // Cell i lies from i to i + 1, the voxels i and i + 1 have their middles there: it takes half of each along every axis.
            let corners = (0..8).map(|corner| {
                mean(
                    at[0] + (corner & 1),
                    at[1] + (corner >> 1 & 1),
                    at[2] + (corner >> 2),
                )
            });
            let expected = corners.sum::<f64>() / 8.0;
            assert!(
                (cell - expected).abs() < error,
                "{name}: cell {at:?} is {cell}, not {expected}"
            );
        }
        assert!(
            notes[0].text.contains("grid `density`") && notes[0].text.contains("12 x 12 x 12 voxels"),
            "{notes:?}"
        );
    }
}

#[test]
fn a_volume_fits_the_box_and_turns() {
    let canvas = box_of(24);
    let middle = |cells: &[f64]| -> Vec<f64> {
        let mass: f64 = cells.iter().sum();
        (0..3)
            .map(|axis| {
                let weighted = cells.iter().enumerate().map(|(index, cell)| {
                    let at = [index % 24, index / 24 % 24, index / 576][axis];
                    cell * (at as f64 + 0.5) / 24.0
                });
                weighted.sum::<f64>() / mass
            })
            .collect()
    };
    let (cells, _) = draw(
        "file = \"level_set.vdb\"\nfit = { center = [0.3, 0.4, 0.6], size = 0.5 }",
        &canvas,
        &given(),
    );
    for (found, wanted) in middle(&cells).into_iter().zip([0.3, 0.4, 0.6]) {
        assert!((found - wanted).abs() < 0.02, "{found} {wanted}");
    }
    // A surface is filled: the middle of the ball is full, and nothing else.
    assert!((cells[(14 * 24 + 9) * 24 + 7] - 1.0).abs() < 0.01);
    assert_eq!(cells[0], 0.0);
    let (plain, _) = draw("file = \"blosc_float.vdb\"", &canvas, &given());
    let (turned, notes) = draw("file = \"blosc_float.vdb\"\nup = \"y\"", &canvas, &given());
    assert!(notes[0].text.contains("y up"), "{notes:?}");
    // The ball looks the same from everywhere.
    let off = plain
        .iter()
        .zip(&turned)
        .map(|(a, b)| (a - b).abs())
        .fold(0.0, f64::max);
    assert!(off < 1e-6, "{off}");
}

/// A file with one leaf of 8^3 values, packed as `compression` says, and a tile.
pub fn small(compression: u32, half: bool) -> Vec<u8> {
    let text = |bytes: &mut Vec<u8>, text: &str| {
        bytes.extend((text.len() as u32).to_le_bytes());
        bytes.extend(text.bytes());
    };
    let values: Vec<f32> = (0..512).map(|index| 1.0 + (index % 8) as f32 / 8.0).collect();
    let pack = |bytes: &mut Vec<u8>, values: &[f32]| {
        let raw: Vec<u8> = if half {
            values
                .iter()
                .flat_map(|&value| half::f16::from_f32(value).to_le_bytes())
                .collect()
        } else {
            values.iter().flat_map(|value| value.to_le_bytes()).collect()
        };
        if compression & 1 == 0 {
            bytes.extend(raw);
            return;
        }
        let mut packed = ZlibEncoder::new(Vec::new(), Compression::default());
        packed.write_all(&raw).unwrap();
        let packed = packed.finish().unwrap();
        bytes.extend((packed.len() as i64).to_le_bytes());
        bytes.extend(packed);
    };
    let mut bytes = 0x5644_4220_i64.to_le_bytes().to_vec();
    for word in [224_u32, 10, 0] {
        bytes.extend(word.to_le_bytes());
    }
    bytes.push(1);
    bytes.extend([b'0'; 36]);
    bytes.extend(0_u32.to_le_bytes());
    bytes.extend(1_u32.to_le_bytes());
    text(&mut bytes, "smoke");
    text(
        &mut bytes,
        if half {
            "Tree_float_5_4_3_HalfFloat"
        } else {
            "Tree_float_5_4_3"
        },
    );
    text(&mut bytes, "");
    let places = bytes.len();
    bytes.extend([0; 24]);
    let begin = bytes.len();
    bytes.extend(compression.to_le_bytes());
    bytes.extend(0_u32.to_le_bytes());
    text(&mut bytes, "UniformScaleMap");
    for _ in 0..15 {
        bytes.extend(1.0_f64.to_le_bytes());
    }
    for word in [1_u32, 0, 0, 1, 0, 0, 0] {
        bytes.extend(word.to_le_bytes());
    }
    for (side, tile) in [(32_usize, false), (16, true)] {
        let count = side * side * side;
        let mut mask = vec![0_u8; count / 8];
        mask[0] = 1;
        bytes.extend(&mask);
        mask[0] = if tile { 2 } else { 0 };
        bytes.extend(&mask);
        let mut values = vec![0.0; count];
        values[1] = if tile { 0.5 } else { 0.0 };
        if compression & 2 != 0 {
            bytes.push(0);
            pack(&mut bytes, if tile { &values[1..2] } else { &[] });
        } else {
            bytes.push(6);
            pack(&mut bytes, &values);
        }
    }
    bytes.extend([0xff; 64]);
    let buffers = bytes.len();
    bytes.extend([0xff; 64]);
    bytes.push(6);
    pack(&mut bytes, &values);
    for (index, place) in [begin, buffers, bytes.len()].into_iter().enumerate() {
        bytes[places + 8 * index..places + 8 * index + 8].copy_from_slice(&(place as u64).to_le_bytes());
    }
    bytes
}

#[test]
fn plain_zipped_and_half_values_are_read() {
    let base = folder("volumes_packed");
    // Half grids without values have nothing where others have a length.
    for (compression, half) in [
        (0, false),
        (1, false),
        (3, false),
        (0, true),
        (1, true),
        (2, true),
    ] {
        fs::write(base.join("a.vdb"), small(compression, half)).unwrap();
        let canvas = Canvas {
            length: 16.0,
            ..box_of(16)
        };
        let (cells, _) = draw(
            "file = \"a.vdb\"\nfit = { center = [8, 8, 8], size = 16 }\ndensity = 1",
            &canvas,
            &base,
        );
        // 8 voxels along x and y, 16 along z, of which the upper half is the tile.
        let at = |x: usize, y: usize, z: usize| cells[x + 16 * (y + 16 * z)];
        for z in 0..8 {
            let wanted = 1.0 + z as f64 / 8.0;
            assert!(
                (at(8, 8, z) - wanted).abs() < 1e-3 || z == 0 || z == 7,
                "{compression} {half}: {} not {wanted}",
                at(8, 8, z)
            );
        }
        assert!(
            (at(8, 8, 12) - 0.5).abs() < 1e-6,
            "{compression} {half}: {}",
            at(8, 8, 12)
        );
    }
}

#[test]
fn wrong_volumes_are_refused_by_name() {
    let base = folder("volumes_refused");
    let whole = fs::read(given().join("blosc_float.vdb")).unwrap();
    let write = |name: &str, bytes: &[u8]| fs::write(base.join(name), bytes).unwrap();
    write("a.vdb", &whole);
    write("text.vdb", b"hello");
    write("short.vdb", &whole[..whole.len() / 2]);
    let mut old = whole.clone();
    old[8] = 200;
    write("old.vdb", &old);
    // The only grid says that the next one begins where it does itself, a million times.
    let mut back = small(0, false);
    let begin = 61;
    back[begin..begin + 4].copy_from_slice(&1_000_000_u32.to_le_bytes());
    let end = begin + 4 + "smoke".len() + "Tree_float_5_4_3".len() + 12 + 16;
    back[end..end + 8].copy_from_slice(&(begin as u64 + 4).to_le_bytes());
    write("back.vdb", &back);
    let table = [
        ("file = \"missing.vdb\"", 3, "cannot be read"),
        ("file = \"text.vdb\"", 3, "is no OpenVDB file"),
        ("file = \"short.vdb\"", 3, "breaks off"),
        ("file = \"old.vdb\"", 3, "has version 200"),
        ("file = \"a.vdb\"\nname = \"heat\"", 3, "has no grid `heat`"),
        (
            "file = \"a.vdb\"\nname = \"velocity\"",
            3,
            "holds `velocity` as Tree_vec3s",
        ),
        ("file = \"a.vdb\"", 2, "the grid is 2D"),
        ("file = \"a.vdb\"\nentry = 0", 3, "`entry` stands beside a volume"),
        ("file = \"back.vdb\"", 3, "a grid ends before it begins"),
        ("file = \"a.npy\"\nfit = \"world\"", 3, "is a key of `mesh`"),
    ];
    for (shape, dimensions, expected) in table {
        let error = refusal(shape, dimensions, &base).to_string();
        assert!(
            error.contains(expected) && error.contains("; "),
            "{shape}\n  said    {error}\n  not     {expected}"
        );
    }
}

/// On a ring what is beyond one side comes in at the other; on walls it is cut off, which is told.
#[test]
fn a_volume_goes_round_a_ring() {
    let shape = "file = \"level_set.vdb\"\nfit = { center = [0.0, 0.5, 0.5], size = 0.5 }";
    let walls = box_of(24);
    let ring = Canvas {
        periodic: vec![true, false, false],
        ..box_of(24)
    };
    let ((cut, told), (whole, silent)) = (draw(shape, &walls, &given()), draw(shape, &ring, &given()));
    let mass = |cells: &[f64]| cells.iter().sum::<f64>();
    assert!(
        (mass(&whole) / mass(&cut) - 2.0).abs() < 0.05,
        "{} {}",
        mass(&whole),
        mass(&cut)
    );
    let row = &whole[(12 * 24 + 12) * 24..(12 * 24 + 13) * 24];
    for at in 0..12 {
        assert!((row[at] - row[23 - at]).abs() < 0.05, "{row:?}");
    }
    let says = |notes: &[Note]| {
        notes
            .iter()
            .any(|note| note.text.contains("lies outside of the box"))
    };
    assert!(says(&told) && !says(&silent), "{told:?} {silent:?}");
}

#[test]
fn a_sequence_of_volumes_is_placed_as_its_first_one_is() {
    let base = folder("volumes_sequence");
    let whole = small(0, false);
    fs::write(base.join("a_0.vdb"), &whole).unwrap();
    // The same with voxels of half the size.
    let mut half = whole.clone();
    let map = b"UniformScaleMap";
    let scale = half.windows(map.len()).position(|part| part == map).unwrap() + map.len();
    for axis in 0..3 {
        half[scale + 8 * axis..scale + 8 * axis + 8].copy_from_slice(&0.5_f64.to_le_bytes());
    }
    fs::write(base.join("a_1.vdb"), &half).unwrap();
    let scene = base.join("scene.toml");
    let text = "[grid]\ncells = [16, 16, 16]\n[time]\nsteps = 4\n[source]\nfile = \"a_0.vdb\"\n[[keyframe]]\n\
                steps = { from = 2, every = 2 }\nfiles = \"a_*.vdb\"\n";
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
    let mass = |title: &str| -> f64 {
        let line = ended.out.lines().find(|line| line.ends_with(title));
        line.unwrap().split_whitespace().next().unwrap().parse().unwrap()
    };
    let [source, first, second] = ["source", "step 2", "step 4"].map(mass);
    assert_eq!(source, first);
    assert!((second / first - 0.125).abs() < 0.005, "{}", ended.out);
}

#[test]
fn every_cut_and_every_flipped_byte_of_a_volume_ends_in_a_sentence_or_a_drawing() {
    let base = folder("volumes_mutants");
    let spec: ShapeSpec = toml::from_str("file = \"a.vdb\"").unwrap();
    let path = base.join("a.vdb");
    let files = [small(3, false), fs::read(given().join("blosc_half.vdb")).unwrap()];
    for whole in files {
        // Masks of inner nodes are long and say little: one byte in a hundred of the middle will do.
        let places = (0..whole.len()).filter(|place| *place < 700 || place % 97 == 0);
        for place in places {
            fs::write(&path, &whole[..place]).unwrap();
            let _ = spec.rasterise(&box_of(4), &base);
            for flip in [1, 0x80] {
                let mut mutant = whole.clone();
                mutant[place] ^= flip;
                fs::write(&path, &mutant).unwrap();
                if let Ok(cells) = spec.rasterise(&box_of(4), &base) {
                    assert!(cells.iter().all(|cell| cell.is_finite()), "byte {place}");
                }
            }
        }
    }
}

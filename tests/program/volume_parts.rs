//! Parts of a volume, and where they lie: however large a tile is it takes no memory, and no part lies where another one does.

use super::shape_keys::{canvas, folder, refusal};
use super::volumes::small;
use std::fs;
use thurible::keyframes::ShapeSpec;

/// Where a file says where its leaves' values begin, and where its grid ends.
const PLACES: [usize; 2] = [61 + 4 + 5 + 16 + 12 + 8, 61 + 4 + 5 + 16 + 12 + 16];

/// Where the transform begins.
fn transform(bytes: &[u8]) -> usize {
    let map = b"UniformScaleMap";
    bytes.windows(map.len()).position(|part| part == map).unwrap()
}

/// Where the root begins, behind the name of the transform and its numbers.
fn root(bytes: &[u8]) -> usize {
    transform(bytes) + "UniformScaleMap".len() + 15 * 8
}

/// A file whose root holds these tiles alone, each with the value 1.
fn with_tiles(corners: &[[i32; 3]]) -> Vec<u8> {
    let mut bytes = small(0, false);
    let root = root(&bytes);
    let counts = [corners.len() as u32, 0].map(u32::to_le_bytes).concat();
    bytes[root + 8..root + 16].copy_from_slice(&counts);
    let tiles = corners.iter().flat_map(|corner| {
        let corner = corner.map(i32::to_le_bytes).concat();
        [corner, 1.0_f32.to_le_bytes().to_vec(), vec![1]].concat()
    });
    let tiles: Vec<u8> = tiles.collect();
    bytes.splice(root + 16..root + 16, tiles);
    bytes
}

#[test]
fn a_tile_of_thousands_of_voxels_a_side_is_drawn() {
    let base = folder("volume_tile");
    fs::write(base.join("a.vdb"), with_tiles(&[[0; 3]])).unwrap();
    let spec: ShapeSpec = toml::from_str("file = \"a.vdb\"").unwrap();
    let cells = spec.rasterise(&canvas(3), &base).unwrap();
    // It fills 0.8 of the box along each axis, where 12 of 16 cells have their middle; all of them are full.
    let mean = cells.iter().sum::<f64>() / cells.len() as f64;
    assert!((mean - 0.75_f64.powi(3)).abs() < 1e-12, "{mean}");
    let middle = cells[(8 * 16 + 8) * 16 + 8];
    assert!((middle - 1.0).abs() < 1e-12, "{middle}");
}

#[test]
fn parts_that_overlap_are_refused() {
    let base = folder("volume_overlap");
    for corners in [[[0; 3], [0; 3]], [[0; 3], [1, 0, 0]]] {
        fs::write(base.join("a.vdb"), with_tiles(&corners)).unwrap();
        let error = refusal("file = \"a.vdb\"", 3, &base).to_string();
        assert!(error.contains("its parts overlap"), "{error}");
    }
}

/// A file whose voxels a matrix places, row by row.
fn with_matrix(rows: [[f64; 4]; 4]) -> Vec<u8> {
    let mut bytes = small(0, false);
    let (begin, end) = (transform(&bytes) - 4, root(&bytes));
    let numbers: Vec<u8> = rows.iter().flatten().flat_map(|x| x.to_le_bytes()).collect();
    let map = [&9_u32.to_le_bytes()[..], b"AffineMap", &numbers].concat();
    let longer = map.len() as u64 - (end - begin) as u64;
    bytes.splice(begin..end, map);
    for place in PLACES {
        let word: [u8; 8] = bytes[place..place + 8].try_into().unwrap();
        bytes[place..place + 8].copy_from_slice(&(u64::from_le_bytes(word) + longer).to_le_bytes());
    }
    bytes
}

#[test]
fn a_matrix_may_stretch_and_shift_but_not_turn() {
    let base = folder("volume_matrix");
    let straight = [
        [0.5, 0.0, 0.0, 0.0],
        [0.0, 0.5, 0.0, 0.0],
        [0.0, 0.0, 0.5, 0.0],
        [3.0, 4.0, 5.0, 1.0],
    ];
    fs::write(base.join("a.vdb"), with_matrix(straight)).unwrap();
    fs::write(base.join("b.vdb"), small(0, false)).unwrap();
    let draw = |name: &str| {
        let spec: ShapeSpec = toml::from_str(&format!("file = \"{name}\"")).unwrap();
        spec.rasterise(&canvas(3), &base).unwrap()
    };
    // What fills the box as before is the same, wherever and however large it is in the file.
    assert!(
        draw("a.vdb")
            .iter()
            .zip(draw("b.vdb"))
            .all(|(a, b)| (a - b).abs() < 1e-9)
    );
    for (row, column) in [(0, 1), (0, 2), (1, 0), (1, 2), (2, 0), (2, 1)] {
        let mut sheared = straight;
        sheared[row][column] = 0.1;
        fs::write(base.join("a.vdb"), with_matrix(sheared)).unwrap();
        let error = refusal("file = \"a.vdb\"", 3, &base).to_string();
        assert!(error.contains("turned or sheared"), "{error}");
    }
}

#[test]
fn a_volume_may_be_one_voxel_thick() {
    let base = folder("volume_thin");
    let mut bytes = small(0, false);
    // Of the node above the leaves the tile is switched off, of the leaf all planes but the first.
    let middle = root(&bytes) + 28 + 2 * 4096 + 1 + 4 * 32 * 32 * 32;
    bytes[middle + 512] = 0;
    let leaf = middle + 2 * 512 + 1 + 4 * 16 * 16 * 16;
    let word: [u8; 8] = bytes[PLACES[0]..PLACES[0] + 8].try_into().unwrap();
    let buffers = u64::from_le_bytes(word) as usize;
    for mask in [leaf, buffers] {
        assert_eq!(bytes[mask..mask + 64], [0xff; 64]);
        bytes[mask + 8..mask + 64].fill(0);
    }
    fs::write(base.join("a.vdb"), bytes).unwrap();
    let spec: ShapeSpec = toml::from_str("file = \"a.vdb\"").unwrap();
    let cells = spec.rasterise(&canvas(3), &base).unwrap();
    assert!(cells.iter().any(|cell| *cell > 0.5));
}

#[test]
fn with_y_up_places_of_the_file_turn_too() {
    let base = folder("volume_world");
    let middle = |origin: [f64; 3]| {
        let side = 1.0 / 32.0;
        let [x, y, z] = origin;
        let rows = [
            [side, 0.0, 0.0, 0.0],
            [0.0, side, 0.0, 0.0],
            [0.0, 0.0, side, 0.0],
            [x, y, z, 1.0],
        ];
        fs::write(base.join("a.vdb"), with_matrix(rows)).unwrap();
        let spec: ShapeSpec = toml::from_str("file = \"a.vdb\"\nfit = \"world\"\nup = \"y\"").unwrap();
        let cells = spec.rasterise(&canvas(3), &base).unwrap();
        let sum: f64 = cells.iter().sum();
        let mean = |stride: usize| {
            let along = cells
                .iter()
                .enumerate()
                .map(|(cell, value)| (cell / stride % 16) as f64 * value);
            along.sum::<f64>() / sum / 16.0
        };
        [mean(1), mean(16), mean(256)]
    };
    let [x, y, z] = middle([0.25, 0.25, -0.75]);
    let [across, along, up] = middle([0.3125, 0.375, -0.9375]);
    // The file's y is the box's z, its z the box's y the other way round.
    assert!((across - x - 0.0625).abs() < 1e-6, "{x} {across}");
    assert!((along - y - 0.1875).abs() < 1e-6, "{y} {along}");
    assert!((up - z - 0.125).abs() < 1e-6, "{z} {up}");
}

#[test]
fn values_that_are_none_and_values_behind_leaves_do_not_count() {
    let base = folder("volume_values");
    let whole = small(0, false);
    let middle = root(&whole) + 28 + 2 * 4096 + 1 + 4 * 32 * 32 * 32;
    let mut behind = whole.clone();
    // The place of the leaf has a value of its own that nobody sees.
    let place = middle + 2 * 512 + 1;
    behind[place..place + 4].copy_from_slice(&9.0_f32.to_le_bytes());
    let draw = |bytes: &[u8]| {
        fs::write(base.join("a.vdb"), bytes).unwrap();
        let spec: ShapeSpec = toml::from_str("file = \"a.vdb\"").unwrap();
        spec.rasterise(&canvas(3), &base)
    };
    assert_eq!(draw(&behind).unwrap(), draw(&whole).unwrap());
    let leaf = middle + 2 * 512 + 1 + 4 * 16 * 16 * 16;
    let values = leaf + 64 + 64 + 1;
    for (value, said) in [(f32::NAN, "not finite"), (-1e6, "a density is never negative")] {
        let mut odd = whole.clone();
        odd[values + 4..values + 8].copy_from_slice(&value.to_le_bytes());
        let error = draw(&odd).unwrap_err().to_string();
        assert!(error.contains(said), "{error}");
    }
}

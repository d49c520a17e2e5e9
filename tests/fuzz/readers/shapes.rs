//! Scenes, and the files that they name.

use crate::seeds::texts;
use std::path::{Path, PathBuf};
use std::sync::LazyLock;
use thurible::keyframes::{Canvas, Frames, ShapeSpec, read_velocity, steps_of_array};
use thurible::scene::{Document, Scene};
use toml::Value;

fn canvas(cells: &[usize]) -> Canvas {
    Canvas {
        cells: cells.to_vec(),
        periodic: vec![false; cells.len()],
        length: 1.0,
    }
}

fn folder(path: &Path) -> PathBuf {
    path.parent().unwrap().to_path_buf()
}

fn document(path: &Path, bytes: &[u8]) -> Option<Document> {
    let text = String::from_utf8(bytes.to_vec()).ok()?;
    Document::parse(path, text).ok()
}

pub fn scene(path: &Path, bytes: &[u8]) -> bool {
    document(path, bytes).is_some_and(|document| Scene::of(document).is_ok())
}

/// A scene to change, which is parsed once.
static SCENE: LazyLock<Document> = LazyLock::new(|| document(Path::new("a.toml"), &SCENE_BYTES).unwrap());

pub fn assignment(_: &Path, bytes: &[u8]) -> bool {
    let (mut document, Ok(assignment)) = (SCENE.clone(), core::str::from_utf8(bytes)) else {
        return false;
    };
    // That it is taken is enough: not each fits this scene.
    let is_taken = document.set(assignment).is_ok();
    let _ = Scene::of(document);
    is_taken
}

/// The names of a sequence of files.
pub fn pattern(path: &Path, bytes: &[u8]) -> bool {
    let text = format!("{}{}", String::from_utf8_lossy(&SCENE_BYTES), texts::SEQUENCE);
    let (Some(mut document), Ok(pattern)) = (document(path, text.as_bytes()), core::str::from_utf8(bytes))
    else {
        return false;
    };
    let files = Value::String(pattern.to_owned());
    let key = "keyframe[1].files";
    document.replace(key.into(), key, files).is_ok() && Scene::of(document).is_ok()
}

static SCENE_BYTES: LazyLock<Vec<u8>> = LazyLock::new(|| texts::scenes(Path::new("")).swap_remove(0));

fn drawn(keys: &str, cells: &[usize], path: &Path) -> bool {
    let shape: ShapeSpec = toml::from_str(keys).unwrap();
    shape.rasterise(&canvas(cells), &folder(path)).is_ok()
}

pub fn array(path: &Path, _: &[u8]) -> bool {
    let shape: ShapeSpec = toml::from_str("file = \"a.npy\"").unwrap();
    let steps = steps_of_array(&shape, &folder(path));
    shape.rasterise(&canvas(&[8, 8]), &folder(path)).is_ok() || steps.is_ok()
}

pub fn archive(path: &Path, _: &[u8]) -> bool {
    drawn("file = \"a.npz\"\nname = \"density\"", &[8, 8], path)
}

pub fn velocity(path: &Path, _: &[u8]) -> bool {
    read_velocity(path, &canvas(&[8, 8])).is_ok()
}

fn first_frames(frames: Result<Frames, thurible::keyframes::ShapeError>) -> bool {
    frames.is_ok_and(|mut frames| (0..frames.count().min(4)).all(|frame| frames.read(frame).is_ok()))
}

pub fn frames(path: &Path, _: &[u8]) -> bool {
    first_frames(Frames::of_array(path, None, "capture.file"))
}

/// Shapes of one file on few cells.
macro_rules! shapes {
    ($($name:ident: $keys:literal on $cells:expr;)*) => {
        $(pub fn $name(path: &Path, _: &[u8]) -> bool {
            drawn($keys, &$cells, path)
        })*
    };
}

shapes! {
    png: "image = \"a.png\"" on [8, 8];
    jpeg: "image = \"a.jpg\"" on [8, 8];
    tiff: "image = \"a.tif\"" on [8, 8];
    webp: "image = \"a.webp\"" on [8, 8];
    exr: "image = \"a.exr\"" on [8, 8];
    svg: "image = \"a.svg\"" on [8, 8];
    font: "text = \"gF&8\"\nfont = \"a.ttf\"\nheight = 0.5" on [2, 2];
    obj: "mesh = \"a.obj\"" on [2, 2, 2];
    stl: "mesh = \"a.stl\"" on [2, 2, 2];
    ply: "mesh = \"a.ply\"" on [2, 2, 2];
    gltf: "mesh = \"a.gltf\"" on [2, 2, 2];
    glb: "mesh = \"a.glb\"" on [2, 2, 2];
    volume: "file = \"a.vdb\"" on [2, 2, 2];
}

/// A volume as a frame, voxel by voxel.
pub fn volumes(path: &Path, _: &[u8]) -> bool {
    first_frames(Frames::of_files(
        vec![path.to_owned()],
        None,
        None,
        "capture.files",
    ))
}

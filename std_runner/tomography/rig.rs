//! `thurible photograph`: cameras about a known density, and what they see of it, as a folder of views.

use super::cameras::forward;
use super::place::Place;
use super::raw::RawCamera;
use super::subject::{Rig, Subject};
use super::views::FILE;
use crate::destination::Destination;
use crate::exit::Failure;
use crate::output::{OutputError, Plain, Tone, plate, write_arrays, write_bytes};
use crate::scene::Document;
use core::ops::RangeInclusive;
use serde_json::{Value, json};
use std::fs;
use std::path::{Path, PathBuf};
use thurible_core::Exec;
use thurible_core::checkpoint::Mix;
use thurible_core::tomography::{Camera, photograph as expose};
use thurible_core::walk::{Cells, Random};

/// What tells that a folder holds views, and what it says of their file.
const MARK: &str = "views.json";
const SUM: &str = "views_sum";
/// Rays along a side of a pixel.
const FINE: usize = 2;
/// How much larger the picture of a pinhole is, to which the near edges of the box are larger.
const MARGIN: f64 = 1.2;
/// Where pinholes stand, in diagonals from the middle of the box.
const DISTANCE: f64 = 1.5;

/// Takes the photographs and writes the folder of views.
pub(crate) fn photograph(rig: &Rig, exec: &dyn Exec) -> Result<Destination, Failure> {
    let subject = Subject::of(rig)?;
    let frames = rig.frames.clone().unwrap_or(0..=subject.frames() - 1);
    if *frames.end() >= subject.frames() || frames.is_empty() {
        return Err(Failure::Input(format!(
            "--frames {}..{}: {} has the frames 0 to {}; name some of those",
            frames.start(),
            frames.end(),
            subject.path().display(),
            subject.frames() - 1
        )));
    }
    if subject.cells.len() == 2 {
        refuse_height(rig)?;
    }
    if !rig.force {
        refuse_changed(&rig.folder)?;
    }
    let mut destination = Destination::check_for(&rig.folder, MARK, planned(rig))?;
    let (text, pixels) = description(rig, &subject, frames.start());
    let pictures = if subject.cells.len() == 2 {
        take::<2>(rig, &subject, &text, pixels, frames.clone(), exec)?
    } else {
        take::<3>(rig, &subject, &text, pixels, frames.clone(), exec)?
    };
    destination.fill(|folder| write(folder, &subject, &text, pixels, &pictures))?;
    Ok(destination)
}

/// Refuses what a plane has no third axis for: its cameras lie in it, and their pictures are rows of pixels.
fn refuse_height(rig: &Rig) -> Result<(), Failure> {
    let wrong = match (rig.elevation, rig.size) {
        (Some(angle), _) => format!("--elevation {angle}: cameras of a plane lie in it; leave it out"),
        (_, Some((width, height))) if height != 1 => {
            format!("--size {width}x{height}: pictures of a plane are rows of pixels; write --size {width}x1")
        }
        _ => return Ok(()),
    };
    Err(Failure::Input(wrong))
}

/// Refuses a folder whose file of views says something else than what was written there.
fn refuse_changed(folder: &Path) -> Result<(), Failure> {
    let read = |name: &str| fs::read_to_string(folder.join(name)).ok();
    let mark: Option<Value> = read(MARK).and_then(|text| serde_json::from_str(&text).ok());
    let was = mark.as_ref().and_then(|mark| mark.get(SUM)?.as_str());
    match (was, read(FILE)) {
        (Some(was), Some(text)) if was != sum(&text) => Err(Failure::File(format!(
            "{} was changed since it was written: keep it and choose another folder with -o DIR, or write over it with --force",
            folder.join(FILE).display()
        ))),
        _ => Ok(()),
    }
}

/// What tells one file of views from another.
fn sum(text: &str) -> String {
    let mut mix = Mix::new();
    mix.bytes(text.as_bytes());
    format!("{:016x}", mix.finish())
}

fn planned(rig: &Rig) -> Vec<PathBuf> {
    let names = [FILE, MARK, "pictures.npz", "truth.npz"].map(PathBuf::from);
    let plates = (0..rig.views).map(|camera| PathBuf::from(format!("camera_{camera:02}.png")));
    names.into_iter().chain(plates).collect()
}

/// Pictures of all frames, and the densities themselves.
struct Pictures {
    /// By camera, then by frame.
    cameras: Vec<Vec<Vec<f32>>>,
    truth: Vec<Vec<f32>>,
}

/// The file of views, and the size of its pictures.
fn description(rig: &Rig, subject: &Subject, first: &usize) -> (String, [usize; 2]) {
    let dims = subject.cells.len();
    let longest = subject.cells.iter().copied().max().unwrap_or(1);
    let side = subject.length / longest as f64;
    let sides: Vec<f64> = subject.cells.iter().map(|&count| count as f64).collect();
    let diagonal = sides.iter().map(|x| x * x).sum::<f64>().sqrt();
    let around = sides.iter().take(2).map(|x| x * x).sum::<f64>().sqrt();
    let rise = if dims == 3 { rig.rise().to_radians() } else { 0.0 };
    let high = sides.get(2).copied().unwrap_or(1.0) * rise.cos() + around * rise.sin().abs();
    let room = if rig.pinhole { MARGIN } else { 1.0 };
    let square = [around.max(1.0), high].map(|cells| ((room * cells).ceil() as usize).next_multiple_of(2));
    let pixels = match rig.size {
        Some((width, height)) => [width, if dims == 3 { height } else { 1 }],
        None if dims == 2 => [longest.max(square[0]), 1],
        None => square,
    };
    let scale = (square[0] as f64 / pixels[0] as f64).max(if dims == 3 {
        square[1] as f64 / pixels[1] as f64
    } else {
        0.0
    });
    let cells: Vec<String> = subject.cells.iter().map(usize::to_string).collect();
    let mut text = format!(
        "# {} views of frames from {first} on, by thurible photograph.\n\n[box]\ncells = [{}]\nlength = {}\n\n[pictures]\ndt = {}\n\n[truth]\nfile = \"truth.npz\"\narray = \"density\"\n",
        rig.views,
        cells.join(", "),
        subject.length,
        subject.dt
    );
    for view in 0..rig.views {
        let azimuth = 180.0 * view as f64 / rig.views as f64;
        text += &format!("\n[[camera]]\nname = \"{azimuth:.1} degrees\"\n");
        if rig.pinhole {
            let way = forward(azimuth, if dims == 3 { rig.rise() } else { 0.0 });
            let eye: Vec<String> = (0..dims)
                .map(|axis| {
                    format!(
                        "{:.9}",
                        side * (0.5 * sides[axis] - DISTANCE * diagonal * way[axis])
                    )
                })
                .collect();
            let half = (0.5 * scale * pixels[0] as f64 / (DISTANCE * diagonal)).atan();
            let angle = 2.0 * half.to_degrees();
            text += &format!(
                "kind = \"pinhole\"\nposition = [{}]\nfield_of_view = {angle:.6}\n",
                eye.join(", ")
            );
        } else {
            text += &format!(
                "kind = \"orthographic\"\nazimuth = {azimuth}\npitch = {:.9}\n",
                side * scale
            );
            if dims == 3 {
                text += &format!("elevation = {}\n", rig.rise());
            }
        }
        text += &format!("file = \"pictures.npz\"\narray = \"camera_{view}\"\n");
    }
    (text, pixels)
}

fn take<const D: usize>(
    rig: &Rig,
    subject: &Subject,
    text: &str,
    pixels: [usize; 2],
    frames: RangeInclusive<usize>,
    exec: &dyn Exec,
) -> Result<Pictures, Failure> {
    let document = Document::parse(Path::new(FILE), text.to_owned())?;
    let longest = subject.cells.iter().copied().max().unwrap_or(1) as f64;
    let mut sides = [1.0; 3];
    sides
        .iter_mut()
        .zip(&subject.cells)
        .for_each(|(to, &count)| *to = count as f64);
    let place = Place {
        dims: D,
        origin: [0.0; 3],
        side: subject.length / longest,
        cells: sides,
    };
    let cells = Cells::<D> {
        counts: core::array::from_fn(|axis| subject.cells.get(axis).copied().unwrap_or(1)),
    };
    let listed = document.table().get("camera").and_then(toml::Value::as_array);
    let mut cameras: Vec<Camera<D>> = Vec::new();
    for (number, table) in listed.into_iter().flatten().enumerate() {
        let key = format!("camera[{number}]");
        let raw: RawCamera = crate::scene::read(&document, &key, table.clone())?;
        cameras.push(super::cameras::optics(&document, &key, &raw, &place, pixels)?.camera(pixels));
    }
    let mut taken = Pictures {
        cameras: vec![Vec::new(); cameras.len()],
        truth: Vec::new(),
    };
    for frame in frames {
        let density = subject.density(frame)?;
        for (number, (camera, pictures)) in cameras.iter().zip(&mut taken.cameras).enumerate() {
            let mut picture = vec![0.0_f32; camera.len()];
            expose(exec, &cells, camera, &density, FINE, &mut picture);
            grain(&mut picture, rig, frame, number);
            pictures.push(picture);
        }
        taken.truth.push(density);
    }
    Ok(taken)
}

/// Noise of a camera where it sees something; it never shows less than nothing.
fn grain(picture: &mut [f32], rig: &Rig, frame: usize, camera: usize) {
    if rig.noise <= 0.0 {
        return;
    }
    let most = picture.iter().copied().fold(0.0, f32::max);
    let mut random = Random::new(rig.seed, frame as u64, camera as u64);
    for pixel in picture.iter_mut().filter(|pixel| **pixel > 0.0) {
        let noise = rig.noise * f64::from(most) * random.normal();
        *pixel = (f64::from(*pixel) + noise).max(0.0) as f32;
    }
}

fn write(
    folder: &Path,
    subject: &Subject,
    text: &str,
    [width, height]: [usize; 2],
    pictures: &Pictures,
) -> Result<(), OutputError> {
    write_bytes(&folder.join(FILE), text.as_bytes())?;
    let mark = json!({ "format": 1, "kind": "views", "frames": pictures.truth.len(), SUM: sum(text) });
    write_bytes(&folder.join(MARK), mark.to_string().as_bytes())?;
    let frames = pictures.truth.len();
    let flat = subject.cells.len() == 2;
    let arrays: Vec<Plain<'_, f32>> = pictures
        .cameras
        .iter()
        .enumerate()
        .map(|(number, taken)| Plain {
            name: format!("camera_{number}"),
            shape: if flat {
                vec![frames, width]
            } else {
                vec![frames, height, width]
            },
            parts: taken.iter().map(Vec::as_slice).collect(),
        })
        .collect();
    write_arrays(&folder.join("pictures.npz"), &arrays)?;
    let mut shape = vec![frames];
    shape.extend(subject.cells.iter().rev());
    let truth = Plain {
        name: "density".into(),
        shape,
        parts: pictures.truth.iter().map(Vec::as_slice).collect(),
    };
    write_arrays(&folder.join("truth.npz"), &[truth])?;
    for (number, taken) in pictures.cameras.iter().enumerate() {
        let Some(picture) = taken.get(frames / 2) else {
            continue;
        };
        let most = picture.iter().copied().fold(f32::MIN_POSITIVE, f32::max);
        let light: Vec<f32> = picture.iter().map(|pixel| pixel / most).collect();
        let name = format!("camera_{number:02}.png");
        write_bytes(&folder.join(name), &plate(&light, width, Tone::Light)?)?;
    }
    Ok(())
}

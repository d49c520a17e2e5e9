//! A file of views, read and checked: the box, the cameras, every picture.

use super::cameras::{Optics, optics};
use super::novel::{Novel, pictures, size_of};
use super::place::{Place, place, positive};
use super::raw::{RawCamera, RawTruth, RawViews};
use super::settings::{Chosen, chosen, unheard};
use super::sources::{Source, light, refuse};
use crate::brightness::{Brightness, Dim};
use crate::deblur::Light;
use crate::exit::Failure;
use crate::keyframes::{Measured, Measurements, is_picture};
use crate::scene::{Document, read};
use std::path::Path;
use thurible_core::tomography::Settings;
use toml::Value;

/// The file that is looked for in a folder of views.
pub(super) const FILE: &str = "views.toml";

/// What a file of views says.
pub(super) struct Views {
    pub document: Document,
    /// Cells along x, y (and z).
    pub cells: Vec<usize>,
    pub length: f64,
    pub dt: f64,
    /// Number of the first frame, and how many there are.
    pub first: usize,
    pub frames: usize,
    scale: f64,
    pub cameras: Vec<View>,
    /// Cameras that measured nothing.
    pub novel: Vec<Novel>,
    pub settings: Settings,
    truth: Option<Measurements>,
    /// What was found in the pictures.
    pub notes: Vec<String>,
}

/// A camera with its pictures.
pub(super) struct View {
    pub name: String,
    key: String,
    pub pixels: [usize; 2],
    pub optics: Optics,
    source: Source,
}

impl Views {
    /// Reads `path`, or the file of views in it, and all pictures that it names.
    pub fn load(path: &Path, assignments: &[String]) -> Result<Self, Failure> {
        let path = if path.is_dir() {
            path.join(FILE)
        } else {
            path.to_owned()
        };
        let text = std::fs::read_to_string(&path).map_err(|error| {
            let shown = path.display();
            Failure::File(format!(
                "cannot read the views {shown}: {error}; give a file of views, or a folder with {FILE} in it, as `thurible photograph` writes one"
            ))
        })?;
        let mut document = Document::parse(&path, text)?;
        for assignment in assignments {
            document.set(assignment)?;
        }
        let raw: RawViews = read(&document, "", Value::Table(document.table().clone()))?;
        let (place, cells) = place(&document, &raw.r#box)?;
        let light = light(&document, raw.pictures.light.as_deref())?;
        if raw.camera.is_empty() {
            let why =
                "is empty: there is no [[camera]]; write one for each camera, as `thurible photograph` does";
            return Err(document.refuse("camera", why));
        }
        let mut cameras = Vec::new();
        for (number, camera) in raw.camera.iter().enumerate() {
            cameras.push(view(&document, number, camera, (&place, light))?);
        }
        let Chosen {
            settings,
            automatic_gamma,
        } = chosen(&document, &raw.tomography, &cells, cameras.len())?;
        let mut views = Self {
            length: place.side * cells.iter().copied().max().unwrap_or(1) as f64,
            cells,
            dt: positive(&document, "pictures.dt", raw.pictures.dt.unwrap_or(1.0))?,
            scale: positive(&document, "pictures.scale", raw.pictures.scale.unwrap_or(1.0))?,
            first: raw.pictures.first.unwrap_or(0),
            frames: 0,
            cameras,
            novel: Vec::new(),
            settings,
            truth: None,
            notes: unheard(&settings, &raw.tomography).into_iter().collect(),
            document,
        };
        views.count(raw.pictures.last)?;
        views.look(automatic_gamma)?;
        let first = views.cameras.iter().find(|view| view.source.is_for_screens());
        if let (Some(view), None) = (first, &raw.pictures.light) {
            let note = format!(
                "{} is taken as linear light; where a camera or a film made it, write pictures.light = \"srgb\"",
                view.source.shown(views.first)
            );
            views.notes.push(note);
        }
        let frames = views.first..views.first + views.frames;
        for (number, camera) in raw.novel.iter().enumerate() {
            views.novel.push(Novel::read(
                &views.document,
                number,
                camera,
                (&place, light),
                &frames,
            )?);
        }
        views.truth = views.truth_of(raw.truth)?;
        Ok(views)
    }

    /// How many frames there are: as many of each camera.
    fn count(&mut self, last: Option<usize>) -> Result<(), Failure> {
        let counts = self.cameras.iter().map(|view| view.source.frames());
        let most = counts.max().unwrap_or(0);
        if let Some(short) = self.cameras.iter().find(|view| view.source.frames() < most) {
            let why = format!(
                "(\"{}\") has {} frames, and another camera {most}; give as many of each, or choose by pictures.first and pictures.last",
                short.name,
                short.source.frames()
            );
            return Err(self.document.refuse(&short.key, why));
        }
        let last = last.unwrap_or(most.saturating_sub(1));
        if last >= most || self.first > last {
            let why = format!(
                "asks for the frames {} to {last}; there are 0 to {}: choose among these, pictures.last not before pictures.first",
                self.first,
                most.saturating_sub(1)
            );
            return Err(self.document.refuse("pictures", why));
        }
        self.frames = last + 1 - self.first;
        Ok(())
    }

    /// Looks at every picture once: sizes, numbers, and how bright they are.
    fn look(&mut self, automatic_gamma: bool) -> Result<(), Failure> {
        let (mut brightness, mut notes) = (Brightness::new(self.settings.hull_threshold), Vec::new());
        for frame in 0..self.frames {
            let mut most = Vec::new();
            for view in &self.cameras {
                let picture = self.picture(view, frame)?;
                notes.extend(
                    picture
                        .note
                        .map(|note| format!("{} {note}", view.source.shown(self.first + frame))),
                );
                most.push(picture.values.iter().copied().fold(0.0, f64::max));
            }
            if let Some(view) = brightness.add(most).and_then(|dark| self.cameras.get(dark)) {
                let why = format!(
                    "(\"{}\") is dark in frame {}, where other cameras see smoke: nothing can be where a camera sees none; take the camera out, or check `{}`",
                    view.name,
                    self.first + frame,
                    view.source.shown(self.first + frame)
                );
                return Err(self.document.refuse(&view.key, why));
            }
        }
        let brightest = brightness.brightest().map_err(|dim| self.too_dim(dim))?;
        if automatic_gamma {
            let (prior, dims) = (self.settings.prior, self.cells.len());
            let longest = self.cells.iter().copied().max().unwrap_or(1);
            self.settings.gamma = Settings::automatic_gamma(prior, dims, longest, brightest);
        }
        self.notes.extend(notes);
        Ok(())
    }

    fn too_dim(&self, dim: Dim) -> Failure {
        match dim {
            Dim::Zeros => {
                let why = "have nothing but zeros in all frames; there is no smoke to reconstruct: check the files and `pictures.scale`";
                self.document.refuse("camera", why)
            }
            Dim::Beyond(brightest) => {
                let why = format!(
                    "have {brightest:e} as their brightest pixel; 1e-30 to 1e30 can be reconstructed: set `pictures.scale`"
                );
                self.document.refuse("camera", why)
            }
            Dim::Below(brightest) => {
                let threshold = self.settings.hull_threshold;
                let why = format!(
                    "is {threshold}, and the brightest pixel of all pictures {brightest:.4}: no camera sees smoke; it must be below that, and is 0 by default"
                );
                self.document.refuse("tomography.hull_threshold", why)
            }
        }
    }

    /// The picture of a camera in a frame, in density times cells.
    pub fn picture(&self, view: &View, frame: usize) -> Result<Measured, Failure> {
        let frame = self.first + frame;
        let mut picture = view.source.read(&self.document, &view.key, frame)?;
        let size = size_of(&picture.shape);
        if size != Some(view.pixels) {
            let why = format!(
                "(\"{}\") has a picture of {:?} pixels, `{}`, where its first has {:?}; give pictures of one size",
                view.name,
                size.unwrap_or_default(),
                view.source.shown(frame),
                view.pixels
            );
            return Err(self.document.refuse(&view.key, why));
        }
        picture.clip().map_err(|[found, remedy]| {
            let file = view.source.shown(frame);
            self.document.refuse(
                &view.key,
                format!("(\"{}\") `{file}` {found}; {remedy}", view.name),
            )
        })?;
        picture.values.iter_mut().for_each(|value| *value *= self.scale);
        Ok(picture)
    }

    fn truth_of(&self, raw: Option<RawTruth>) -> Result<Option<Measurements>, Failure> {
        let Some(raw) = raw else { return Ok(None) };
        let path = self.document.folder().join(&raw.file);
        let failed = refuse(&self.document, "truth");
        let truth = Measurements::open("truth.file", &path, raw.array.as_deref()).map_err(&failed)?;
        let shape: Vec<usize> = self.cells.iter().rev().copied().collect();
        let found = truth.read(0).map_err(&failed)?;
        if found.shape != shape {
            let why = format!(
                "has frames of {:?} cells, and the box has {shape:?}; give the box as many by `box.cells`, or leave the truth out",
                found.shape
            );
            return Err(self.document.refuse("truth", why));
        }
        // A picture is one frame, whatever the number of the first one.
        let needed = if is_picture(&path) {
            self.frames
        } else {
            self.first + self.frames
        };
        if truth.count() < needed {
            let why = format!(
                "`{}` has {} frames, and the pictures need {needed}; give as many, or end before by pictures.last",
                path.display(),
                truth.count()
            );
            return Err(self.document.refuse("truth", why));
        }
        Ok(Some(truth))
    }

    /// The true density of a frame, where it is known.
    pub fn truth(&self, frame: usize) -> Option<Vec<f64>> {
        let found = self.truth.as_ref()?.read(self.first + frame).ok()?;
        Some(found.values)
    }

    /// What was seen from novel view `view` in a frame, in density times cells, where that is known.
    pub fn compared(&self, view: &Novel, frame: usize) -> Option<Vec<f64>> {
        view.picture(&self.document, self.first + frame, self.scale)
            .ok()?
    }

    /// Pixels of all cameras and novel views.
    pub fn pixels(&self) -> usize {
        let novel = self.novel.iter().map(|view| view.pixels[0] * view.pixels[1]);
        novel.sum::<usize>() + self.measured_pixels()
    }

    fn measured_pixels(&self) -> usize {
        self.cameras
            .iter()
            .map(|view| view.pixels[0] * view.pixels[1])
            .sum()
    }
}

fn view(
    document: &Document,
    number: usize,
    raw: &RawCamera,
    (place, light): (&Place, Light),
) -> Result<View, Failure> {
    let key = format!("camera[{number}]");
    let (source, pixels) = pictures(document, &key, raw, place, light)?;
    Ok(View {
        name: raw.name.clone().unwrap_or_else(|| format!("camera {number}")),
        optics: optics(document, &key, raw, place, pixels)?,
        pixels,
        source,
        key,
    })
}

impl View {
    /// Its key in the file.
    pub fn key(&self) -> &str {
        &self.key
    }
}

//! Novel views: cameras that measured nothing, or whose pictures are only compared with.

use super::cameras::{Optics, optics};
use super::place::Place;
use super::raw::RawCamera;
use super::sources::Source;
use crate::deblur::Light;
use crate::exit::Failure;
use crate::scene::Document;
use core::ops::Range;

/// A camera whose picture is made up.
pub(super) struct Novel {
    pub name: String,
    pub key: String,
    pub pixels: [usize; 2],
    pub optics: Optics,
    /// Its pictures, where there are any.
    source: Option<Source>,
}

/// Width and height of a picture; a row of numbers is one pixel high.
pub(super) fn size_of(shape: &[usize]) -> Option<[usize; 2]> {
    match *shape {
        [width] => Some([width, 1]),
        [height, width] => Some([width, height]),
        _ => None,
    }
}

/// The pictures of camera `key`, and how large they are.
pub(super) fn pictures(
    document: &Document,
    key: &str,
    raw: &RawCamera,
    place: &Place,
    light: Light,
) -> Result<(Source, [usize; 2]), Failure> {
    if raw.size.is_some() {
        let why = "is for novel views without pictures: here they say how large they are; take it out";
        return Err(document.refuse(&format!("{key}.size"), why));
    }
    let source = Source::of(document, key, raw, place.dims, light)?;
    let first = source.read(document, key, 0)?;
    let pixels = size_of(&first.shape).filter(|size| size[0] > 0 && (place.dims == 3 || size[1] == 1));
    let pixels = pixels.ok_or_else(|| {
        let wanted = if place.dims == 3 {
            "rows and columns"
        } else {
            "one row of pixels, in a plane"
        };
        let why = format!("has pictures of shape {:?}, where one has {wanted}; save them so, or make the box another by `box.cells`", first.shape);
        document.refuse(key, why)
    })?;
    Ok((source, pixels))
}

impl Novel {
    /// Reads novel view `number` of the file, of which pictures of the frames `frames` are compared with.
    pub fn read(
        document: &Document,
        number: usize,
        raw: &RawCamera,
        (place, light): (&Place, Light),
        frames: &Range<usize>,
    ) -> Result<Self, Failure> {
        let key = format!("novel[{number}]");
        let (source, pixels) = if raw.files.is_some() || raw.file.is_some() {
            let (source, pixels) = pictures(document, &key, raw, place, light)?;
            (Some(source), pixels)
        } else {
            (None, size(document, &key, raw, place.dims)?)
        };
        let novel = Self {
            name: raw.name.clone().unwrap_or_else(|| format!("novel view {number}")),
            optics: optics(document, &key, raw, place, pixels)?,
            key,
            pixels,
            source,
        };
        for frame in frames.clone() {
            novel.picture(document, frame, 1.0)?;
        }
        Ok(novel)
    }

    /// What was seen there in frame `frame` of the files, in density times cells, where that is known.
    pub fn picture(
        &self,
        document: &Document,
        frame: usize,
        scale: f64,
    ) -> Result<Option<Vec<f64>>, Failure> {
        let Some(source) = &self.source else {
            return Ok(None);
        };
        if frame >= source.frames() {
            let why = format!(
                "(\"{}\") has {} frames, and the cameras {} or more; give as many, or none",
                self.name,
                source.frames(),
                frame + 1
            );
            return Err(document.refuse(&self.key, why));
        }
        let picture = source.read(document, &self.key, frame)?;
        let fits = size_of(&picture.shape) == Some(self.pixels);
        if !fits || picture.values.iter().any(|value| !value.is_finite()) {
            let found = if fits {
                "a number that is not finite"
            } else {
                "another size than its first"
            };
            let why = format!(
                "(\"{}\") `{}` has {found}; correct it",
                self.name,
                source.shown(frame)
            );
            return Err(document.refuse(&self.key, why));
        }
        Ok(Some(picture.values.iter().map(|value| value * scale).collect()))
    }
}

/// The size of a view without pictures.
fn size(document: &Document, key: &str, raw: &RawCamera, dims: usize) -> Result<[usize; 2], Failure> {
    let allowed = if dims == 3 {
        "[320, 240], pixels across and down"
    } else {
        "[320], pixels across"
    };
    let most = 1..=1 << 14;
    match raw.size.as_deref() {
        Some(&[width, height]) if dims == 3 && most.contains(&width) && most.contains(&height) => {
            Ok([width, height])
        }
        Some(&[width]) if dims == 2 && most.contains(&width) => Ok([width, 1]),
        Some(other) => Err(document.refuse(
            &format!("{key}.size"),
            format!("is {other:?}; write how large its picture is, as in {allowed}"),
        )),
        None => Err(document.refuse(
            key,
            format!(
                "has neither pictures nor a size; write size = {allowed}, or name pictures to compare with"
            ),
        )),
    }
}

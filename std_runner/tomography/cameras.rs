//! Cameras as people say where they are, and as the core takes them: in cells, from the box's lower corner.

use super::place::{Place, positive};
use super::raw::RawCamera;
use super::vector::{Vector, cross, dot, minus, scaled, solve, unit};
use crate::exit::Failure;
use crate::scene::Document;
use thurible_core::tomography::{Camera, Lens};

/// How a camera sees, in cells; in a plane z is 0 everywhere.
#[derive(Clone, Copy, Debug)]
pub(super) struct Optics {
    pub kind: &'static str,
    eye: Option<Vector>,
    across: Vector,
    down: Vector,
    forward: Vector,
    at: [f64; 2],
    pitch: f64,
}

/// The way of a camera turned by `azimuth` from the front (small y) to the right and raised by `elevation`, in degrees.
pub(super) fn forward(azimuth: f64, elevation: f64) -> Vector {
    let (turn, rise) = (azimuth.to_radians(), elevation.to_radians());
    [-turn.sin() * rise.cos(), turn.cos() * rise.cos(), -rise.sin()]
}

/// Reads camera `key` of the file, whose pictures have `pixels` across and down.
pub(super) fn optics(
    document: &Document,
    key: &str,
    raw: &RawCamera,
    place: &Place,
    pixels: [usize; 2],
) -> Result<Optics, Failure> {
    let reader = Reader {
        document,
        key,
        raw,
        place,
        pixels: pixels.map(|count| count as f64),
    };
    let kind = raw.kind.as_deref().unwrap_or("orthographic");
    reader.check_keys(kind)?;
    match kind {
        "orthographic" => reader.orthographic(),
        "pinhole" => reader.pinhole(),
        "matrix" => reader.matrix(),
        other => Err(reader.refuse(
            "kind",
            format!("is \"{other}\"; allowed is \"orthographic\", \"pinhole\" or \"matrix\""),
        )),
    }
}

struct Reader<'a> {
    document: &'a Document,
    key: &'a str,
    raw: &'a RawCamera,
    place: &'a Place,
    pixels: [f64; 2],
}

impl Reader<'_> {
    fn refuse(&self, name: &str, why: impl core::fmt::Display) -> Failure {
        self.document.refuse(&format!("{}.{name}", self.key), why)
    }

    /// Refuses keys that a camera of kind `kind` does not look at: whoever wrote them expects that they count.
    fn check_keys(&self, kind: &str) -> Result<(), Failure> {
        if !["orthographic", "pinhole", "matrix"].contains(&kind) {
            return Ok(());
        }
        let raw = self.raw;
        let given: [(&str, bool, &[&str]); 10] = [
            ("azimuth", raw.azimuth.is_some(), &["orthographic"]),
            ("elevation", raw.elevation.is_some(), &["orthographic"]),
            ("direction", raw.direction.is_some(), &["orthographic"]),
            ("center", raw.center.is_some(), &["orthographic"]),
            ("pitch", raw.pitch.is_some(), &["orthographic"]),
            ("up", raw.up.is_some(), &["orthographic", "pinhole"]),
            ("position", raw.position.is_some(), &["pinhole"]),
            ("target", raw.target.is_some(), &["pinhole"]),
            ("field_of_view", raw.field_of_view.is_some(), &["pinhole"]),
            ("matrix", raw.matrix.is_some(), &["matrix"]),
        ];
        for (name, is_given, kinds) in given {
            if is_given && !kinds.contains(&kind) {
                let why = format!(
                    "is for cameras of kind {}, and this one is {kind}; take it out, or write another `kind`",
                    kinds.join(" or ")
                );
                return Err(self.refuse(name, why));
            }
        }
        Ok(())
    }

    fn vector(&self, name: &str, found: &Option<Vec<f64>>) -> Result<Option<Vector>, Failure> {
        let Some(found) = found else { return Ok(None) };
        if found.len() != self.place.dims || found.iter().any(|x| !x.is_finite()) {
            let why = format!("is {found:?}; write {} finite numbers", self.place.dims);
            return Err(self.refuse(name, why));
        }
        let mut vector = [0.0; 3];
        vector.iter_mut().zip(found).for_each(|(to, from)| *to = *from);
        Ok(Some(vector))
    }

    fn positive(&self, name: &str, found: Option<f64>, remedy: &str) -> Result<f64, Failure> {
        match found {
            Some(found) => positive(self.document, &format!("{}.{name}", self.key), found),
            None => Err(self.refuse(name, format!("is missing; {remedy}"))),
        }
    }

    /// Across and down of a camera that looks along `forward`, unit vectors.
    fn frame(&self, forward: Vector) -> Result<[Vector; 2], Failure> {
        if self.place.dims == 2 {
            return Ok([[forward[1], -forward[0], 0.0], [0.0; 3]]);
        }
        let given = self.vector("up", &self.raw.up)?;
        let up = given.unwrap_or(if forward[2].abs() > 0.999 {
            [0.0, 1.0, 0.0]
        } else {
            [0.0, 0.0, 1.0]
        });
        let across = unit(cross(forward, up))
            .ok_or_else(|| self.refuse("up", "lies along the way that the camera looks; give another one"))?;
        Ok([across, cross(forward, across)])
    }

    fn orthographic(&self) -> Result<Optics, Failure> {
        let place = self.place;
        let turned = forward(
            self.raw.azimuth.unwrap_or(0.0),
            if place.dims == 3 {
                self.raw.elevation.unwrap_or(0.0)
            } else {
                0.0
            },
        );
        let way = self.vector("direction", &self.raw.direction)?.unwrap_or(turned);
        let way =
            unit(way).ok_or_else(|| self.refuse("direction", "has no length; say where the camera looks"))?;
        let [across, down] = self.frame(way)?;
        let remedy = "write the width of a pixel in the units of the box";
        let pitch = self.positive("pitch", self.raw.pitch, remedy)? / place.side;
        let center = self.vector("center", &self.raw.center)?.unwrap_or(place.middle());
        let center = place.in_cells(center);
        let [across, down] = [across, down].map(|way| scaled(way, 1.0 / pitch));
        Ok(Optics {
            kind: "orthographic",
            eye: None,
            at: [
                0.5 * self.pixels[0] - dot(across, center),
                0.5 * self.pixels[1] - dot(down, center),
            ],
            across,
            down,
            forward: way,
            pitch,
        })
    }

    fn pinhole(&self) -> Result<Optics, Failure> {
        let remedy = "write where the camera stands, in the units of the box";
        let position = self.vector("position", &self.raw.position)?;
        let position = position.ok_or_else(|| self.refuse("position", format!("is missing; {remedy}")))?;
        let target = self
            .vector("target", &self.raw.target)?
            .unwrap_or(self.place.middle());
        let way = unit(minus(target, position))
            .ok_or_else(|| self.refuse("target", "is where the camera stands; give another one"))?;
        let remedy = "write the angle in degrees that the picture is wide";
        let view = self.positive("field_of_view", self.raw.field_of_view, remedy)?;
        if view >= 180.0 {
            return Err(self.refuse(
                "field_of_view",
                format!("is {view}; write an angle below 180 degrees"),
            ));
        }
        let focal = 0.5 * self.pixels[0] / (0.5 * view).to_radians().tan();
        let [across, down] = self.frame(way)?.map(|way| scaled(way, focal));
        Ok(Optics {
            kind: "pinhole",
            eye: Some(self.place.in_cells(position)),
            across,
            down,
            forward: way,
            at: self.pixels.map(|count| 0.5 * count),
            pitch: 1.0,
        })
    }

    /// Pixels times depth = matrix (x, 1).
    fn matrix(&self) -> Result<Optics, Failure> {
        let dims = self.place.dims;
        let rows = self.raw.matrix.as_deref().unwrap_or_default();
        let fits = rows.len() == dims && rows.iter().all(|row| row.len() == dims + 1);
        if !fits || rows.iter().flatten().any(|x| !x.is_finite()) {
            let why = format!(
                "is not {dims} rows of {} finite numbers; write the camera's matrix",
                dims + 1
            );
            return Err(self.refuse("matrix", why));
        }
        let row = |index: usize| -> (Vector, f64) {
            let row = rows.get(index).map(Vec::as_slice).unwrap_or_default();
            let mut vector = [0.0; 3];
            vector
                .iter_mut()
                .zip(row.iter().take(dims))
                .for_each(|(to, from)| *to = *from);
            (vector, row.last().copied().unwrap_or_default())
        };
        let (u, depth) = (row(0), row(dims - 1));
        // In a plane the way across the picture's rows is z.
        let v = if dims == 3 { row(1) } else { ([0.0, 0.0, 1.0], 0.0) };
        let flat = || {
            self.refuse(
                "matrix",
                "cannot be inverted, so there is no eye; check its numbers",
            )
        };
        let eye = solve([u.0, v.0, depth.0], [-u.1, -v.1, -depth.1]).ok_or_else(flat)?;
        let length = dot(depth.0, depth.0).sqrt();
        let sign = if dot(depth.0, minus(self.place.middle(), eye)) < 0.0 {
            -1.0
        } else {
            1.0
        };
        let norm = |way: Vector| scaled(way, sign / length);
        let (forward, u, v) = (norm(depth.0), norm(u.0), norm(v.0));
        let at = [dot(u, forward), if dims == 3 { dot(v, forward) } else { 0.5 }];
        let across = minus(u, scaled(forward, at[0]));
        let down = if dims == 3 {
            minus(v, scaled(forward, at[1]))
        } else {
            [0.0; 3]
        };
        if dot(across, down).abs() > 1e-3 * (dot(across, across) * dot(down, down)).sqrt() {
            return Err(self.refuse(
                "matrix",
                "shears its pixels; take the shear out of the pictures and the matrix",
            ));
        }
        Ok(Optics {
            kind: "matrix",
            eye: Some(self.place.in_cells(eye)),
            across,
            down,
            forward,
            at,
            pitch: 1.0,
        })
    }
}

impl Optics {
    /// The core's camera.
    pub fn camera<const D: usize>(&self, pixels: [usize; 2]) -> Camera<D> {
        let cut = |vector: Vector| core::array::from_fn(|axis| vector[axis]);
        let (across, down, forward, at) = (cut(self.across), cut(self.down), cut(self.forward), self.at);
        let lens = match self.eye {
            None => Lens::Orthographic {
                across,
                down,
                at,
                forward,
                pitch: self.pitch,
            },
            Some(eye) => Lens::Pinhole {
                eye: cut(eye),
                across,
                down,
                at,
                forward,
            },
        };
        Camera { lens, pixels }
    }

    /// What `report.json` says of it, in cells.
    pub fn fields(&self) -> serde_json::Value {
        serde_json::json!({
            "kind": self.kind,
            "eye": self.eye,
            "across": self.across,
            "down": self.down,
            "forward": self.forward,
            "at": self.at,
            "pitch": self.pitch,
        })
    }
}

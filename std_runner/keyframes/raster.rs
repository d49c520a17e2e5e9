//! From the keys of a shape to densities on cells.

use std::path::Path;

use super::check::FAINTEST;
use super::ending::ends_with;
use super::error::Fault;
use super::mesh::{Edge, Placed};
use super::npy::Entry;
use super::solid::{Solid, soft};
use super::{Canvas, Note, ShapeError, ShapeSpec, array, build, image, mesh, vdb};

/// The largest `density` that a shape may have.
pub(crate) const DENSEST: f64 = 1e6;

const SHAPES: &str = "circle, sphere, box, torus, capsule, text, image, file, mesh, shapes";

impl ShapeSpec {
    /// Fills the cells of `canvas`, x fastest. Relative paths start at `base`.
    ///
    /// # Errors
    /// Whatever is wrong with the keys or with the files that they name.
    pub fn rasterise(&self, canvas: &Canvas, base: &Path) -> Result<Vec<f64>, ShapeError> {
        self.rasterise_noting(canvas, base, &mut Vec::new())
    }

    /// As [`Self::rasterise`]; what a user should hear of the files is added to `notes`.
    ///
    /// # Errors
    /// As [`Self::rasterise`].
    pub fn rasterise_noting(
        &self,
        canvas: &Canvas,
        base: &Path,
        notes: &mut Vec<Note>,
    ) -> Result<Vec<f64>, ShapeError> {
        self.drawn((canvas, base), Edge::Soft, notes)
    }

    /// As [`Self::rasterise_noting`], for cells that are inside from 0.5 on: the middle of a cell decides of a mesh too.
    ///
    /// # Errors
    /// As [`Self::rasterise`].
    pub fn cut_noting(
        &self,
        canvas: &Canvas,
        base: &Path,
        notes: &mut Vec<Note>,
    ) -> Result<Vec<f64>, ShapeError> {
        self.drawn((canvas, base), Edge::Cut, notes)
    }

    fn drawn(
        &self,
        place: (&Canvas, &Path),
        edge: Edge,
        notes: &mut Vec<Note>,
    ) -> Result<Vec<f64>, ShapeError> {
        let name = self.the_shape()?;
        self.refuse_stray_keys(name)?;
        let density = self.checked_density()?;
        let mut cells = self.draw(place, edge, notes)?;
        let largest = cells.iter().copied().fold(0.0, f64::max);
        // What a file holds may be in units of its own.
        let is_held = matches!(name, "file" | "image");
        let counted = if is_held { largest * density } else { largest };
        if counted < FAINTEST {
            let held = Some(largest).filter(|&largest| is_held && largest > 0.0);
            return Err(self.nothing(name, place.1, edge, held));
        }
        cells.iter_mut().for_each(|cell| *cell *= density);
        Ok(cells)
    }

    /// The refusal of a shape that puts nothing into the box, or `held` at most, which is next to nothing.
    fn nothing(&self, name: &'static str, base: &Path, edge: Edge, held: Option<f64>) -> ShapeError {
        let remedy = match name {
            _ if held.is_some() => "multiply its values by a larger `density` beside it",
            "image" if self.depth.is_some() && edge == Edge::Cut => {
                "give it a `depth` of a cell or more, or draw something into it; `ink` says what is smoke"
            }
            "image" => "draw something into it that is smoke; `ink` says what is",
            "mesh" => {
                "move it into the box, which begins at 0 along each axis and has z up: with up = \"y\" the file's (x, y, z) is at (x, -z, y) there; without `fit` it is made to fit"
            }
            _ => "move it into the box or make it larger",
        };
        let what = match held {
            Some(held) => format!("puts no more than {held:.1e} into the box"),
            None => "puts nothing into the box".to_owned(),
        };
        let found = match self.step {
            Some(step) => format!("{what} by its entry {step}"),
            None => what,
        };
        let file = self.image.as_ref().or(self.mesh.as_ref()).or(self.file.as_ref());
        match file {
            Some(path) => Fault::content(found, remedy).of(name, &base.join(path)),
            None => ShapeError::key(name, found, remedy),
        }
    }

    fn draw(
        &self,
        (canvas, base): (&Canvas, &Path),
        edge: Edge,
        notes: &mut Vec<Note>,
    ) -> Result<Vec<f64>, ShapeError> {
        if let Some(shapes) = &self.shapes {
            return union(shapes, (canvas, base), edge, notes);
        }
        let first = self.first.as_ref().map(|first| base.join(first));
        if let Some(path) = &self.image {
            return image::draw(self, (&base.join(path), first.as_deref()), (canvas, edge), notes);
        }
        let placed = Placed {
            fit: self.fit.as_ref(),
            up: self.up.as_deref(),
            first: first.as_deref(),
            edge,
        };
        if let Some(path) = &self.mesh {
            return mesh::draw(&base.join(path), &placed, canvas, notes);
        }
        if let Some(path) = &self.file {
            let path = base.join(path);
            if ends_with(&path, "vdb") {
                return vdb::draw(&path, self.name.as_deref(), &placed, canvas, notes);
            }
            let entry = match &self.entry {
                Some(key) => Some(array::entry(&path, self.name.as_deref(), key)?),
                None => self.step.map(Entry::At),
            };
            return array::draw(&path, (self.name.as_deref(), entry), canvas, notes);
        }
        Ok(fill(canvas, build::solid(self, canvas, base)?.as_ref()))
    }

    /// The one key that says which shape it is.
    fn the_shape(&self) -> Result<&'static str, ShapeError> {
        let given: Vec<&'static str> = [
            ("circle", self.circle.is_some()),
            ("sphere", self.sphere.is_some()),
            ("box", self.block.is_some()),
            ("torus", self.torus.is_some()),
            ("capsule", self.capsule.is_some()),
            ("text", self.text.is_some()),
            ("image", self.image.is_some()),
            ("file", self.file.is_some()),
            ("mesh", self.mesh.is_some()),
            ("shapes", self.shapes.is_some()),
        ]
        .iter()
        .filter_map(|&(name, there)| there.then_some(name))
        .collect();
        match given.as_slice() {
            [] => Err(ShapeError::key(
                "shape",
                "is missing",
                format!("write one of {SHAPES}"),
            )),
            [name] => Ok(name),
            [first, second, ..] => {
                let found = format!("stands beside `{first}`, two shapes in one table");
                Err(ShapeError::key(
                    *second,
                    found,
                    "keep one, or list both in `shapes = [ ... ]`",
                ))
            }
        }
    }

    fn refuse_stray_keys(&self, shape: &str) -> Result<(), ShapeError> {
        // A volume is placed as a mesh is, and has no entries.
        let is_volume = self.file.as_deref().is_some_and(|file| ends_with(file, "vdb"));
        let placed: &[&str] = if is_volume { &["file"] } else { &["mesh"] };
        let owned: [(_, &[&str], _); 10] = [
            ("font", &["text"], self.font.is_some()),
            ("height", &["text"], self.height.is_some()),
            ("center", &["text"], self.center.is_some()),
            ("depth", &["text", "image"], self.depth.is_some()),
            ("weight", &["text"], self.weight.is_some()),
            ("ink", &["image"], self.ink.is_some()),
            ("name", &["file"], self.name.is_some()),
            ("entry", &["file"], self.entry.is_some()),
            ("fit", placed, self.fit.is_some()),
            ("up", placed, self.up.is_some()),
        ];
        for (key, owners, there) in owned {
            if there && !owners.contains(&shape) {
                let remedy = format!(
                    "remove it, or put it where it belongs (into {{ }} after `{shape}`, if that has such a key)"
                );
                let owners = owners.join("` or `");
                return Err(ShapeError::key(
                    key,
                    format!("is a key of `{owners}`, and the shape is `{shape}`"),
                    remedy,
                ));
            }
        }
        if is_volume && self.entry.is_some() {
            let remedy = "leave it out, and name the volume of the frame that you want";
            return Err(ShapeError::key(
                "entry",
                "stands beside a volume, which is one frame",
                remedy,
            ));
        }
        Ok(())
    }

    /// The largest density that it asks for, by itself and by what it lists.
    fn asked(&self) -> f64 {
        let listed = self.shapes.iter().flatten().map(Self::asked);
        self.density.unwrap_or(1.0) * listed.fold(1.0, f64::max)
    }

    fn checked_density(&self) -> Result<f64, ShapeError> {
        let density = self.density.unwrap_or(1.0);
        if !(density > 0.0 && density <= DENSEST) {
            return Err(ShapeError::key(
                "density",
                format!("is {density:?}"),
                format!("it must be above 0 and at most {DENSEST:?}; 1 is usual"),
            ));
        }
        Ok(density)
    }
}

/// The sum of the shapes, clipped to 1 (or to the largest `density` that one of them asks for).
fn union(
    shapes: &[ShapeSpec],
    place: (&Canvas, &Path),
    edge: Edge,
    notes: &mut Vec<Note>,
) -> Result<Vec<f64>, ShapeError> {
    if shapes.is_empty() {
        return Err(ShapeError::key("shapes", "is empty", "list at least one shape"));
    }
    let mut sum = vec![0.0; place.0.cell_count()];
    let mut ceiling = 1.0_f64;
    for shape in shapes {
        let cells = shape.drawn(place, edge, notes)?;
        sum.iter_mut().zip(cells).for_each(|(total, cell)| *total += cell);
        ceiling = ceiling.max(shape.asked());
    }
    sum.iter_mut().for_each(|cell| *cell = cell.min(ceiling));
    Ok(sum)
}

/// 0.5 - 0.5 tanh(signed distance / h) at cell centres (i + 0.5) h; periodic axes take the nearest image.
pub(super) fn fill(canvas: &Canvas, solid: &dyn Solid) -> Vec<f64> {
    let h = canvas.cell_size();
    let [nx, ny, nz] = canvas.cells_3d();
    let depth = if canvas.dimensions() == 3 { 0.5 } else { 0.0 };
    let shifts = canvas.images();
    let mut cells = Vec::with_capacity(canvas.cell_count());
    for k in 0..nz {
        for j in 0..ny {
            for i in 0..nx {
                let point = [(i as f64 + 0.5) * h, (j as f64 + 0.5) * h, (k as f64 + depth) * h];
                let image =
                    |shift: &[f64; 3]| solid.distance(core::array::from_fn(|axis| point[axis] + shift[axis]));
                let distance = shifts.iter().map(image).fold(f64::INFINITY, f64::min);
                cells.push(soft(distance / h));
            }
        }
    }
    cells
}

//! The body of a scene: its mesh, what holds it, its springs.

use super::files;
use super::raw::{RawHold, RawMaterial, RawMesh, RawSpring};
use crate::bytes::{grouped, rounded};
use crate::exit::Failure;
use crate::scene::Document;
use thurible_core::choices::Numbers;
use thurible_core::condense::{Material, Mesh, Regular, Spring};

/// What a vertex may be outside a box and still count as inside, in parts of the body.
const SLACK: f64 = 1e-9;

/// A mesh that owns its lists.
#[derive(Clone, Debug)]
pub(super) struct OwnedMesh {
    pub dims: usize,
    pub rest: Vec<f64>,
    pub elements: Vec<u32>,
    pub springs: Vec<Spring>,
    pub held: Vec<bool>,
    pub regular: [usize; 3],
    pub material: Material,
    /// Vertices of the body itself: behind them lie the fixed points of springs.
    pub own: usize,
}

impl OwnedMesh {
    /// The core's view of it.
    pub fn mesh(&self) -> Mesh<'_> {
        Mesh {
            dims: self.dims,
            rest: &self.rest,
            elements: &self.elements,
            springs: &self.springs,
            held: &self.held,
            regular: self.regular,
            material: self.material,
        }
    }

    /// The places of the body's own vertices.
    fn places(&self) -> impl Iterator<Item = &[f64]> {
        self.rest.chunks_exact(self.dims).take(self.own)
    }

    /// The least and the largest place of the body along each axis.
    pub fn extent(&self) -> Vec<[f64; 2]> {
        let mut extent = vec![[f64::INFINITY, f64::NEG_INFINITY]; self.dims];
        for place in self.places() {
            for (extent, x) in extent.iter_mut().zip(place) {
                *extent = [extent[0].min(*x), extent[1].max(*x)];
            }
        }
        extent
    }

    /// Bytes of its lists.
    pub fn bytes(&self) -> usize {
        let dims = self.dims.max(1);
        bytes_of(dims, self.rest.len() / dims, self.elements.len() / (dims + 1))
    }

    fn slack(&self) -> f64 {
        let longest = self.extent().into_iter().map(|[low, high]| high - low);
        SLACK * longest.fold(0.0, f64::max)
    }

    /// The vertex of the body next to a place.
    pub fn nearest(&self, at: &[f64]) -> usize {
        let square = |place: &[f64]| place.iter().zip(at).map(|(x, y)| (x - y) * (x - y)).sum::<f64>();
        let nearest = self
            .places()
            .enumerate()
            .min_by(|one, other| square(one.1).total_cmp(&square(other.1)));
        nearest.map_or(0, |(vertex, _)| vertex)
    }
}

/// The mesh that a scene describes. One of cells is refused before it is made, where it takes more than `most` bytes.
pub(super) fn mesh(document: &Document, raw: RawMesh, most: usize) -> Result<OwnedMesh, Failure> {
    let ways = [raw.grid.is_some(), raw.file.is_some(), raw.rod.is_some()];
    if ways.iter().filter(|there| **there).count() != 1 {
        return Err(document.refuse(
            "mesh",
            "must have one of `grid`, `rod` and `file`; write one of them",
        ));
    }
    refuse_foreign(document, &raw)?;
    let area = document.number("mesh.area", raw.area.unwrap_or(0.01), Numbers::Positive)?;
    let material = Material {
        area,
        ..Material::default()
    };
    if let Some(file) = raw.file {
        let path = document.folder().join(&file);
        let found = files::read(&path).map_err(|why| match why {
            files::Unread::Missing(why) => Failure::File(format!(
                "{}: `mesh.file` \"{file}\" cannot be read: {why}; give the path of an .obj or .msh file",
                document.place("mesh.file")
            )),
            files::Unread::Damaged(why) => document.refuse("mesh.file", format!("\"{file}\" {why}")),
        })?;
        return Ok(OwnedMesh {
            dims: found.dims,
            own: found.rest.len() / found.dims,
            held: vec![false; found.rest.len() / found.dims],
            rest: found.rest,
            elements: found.elements,
            springs: Vec::new(),
            regular: [0; 3],
            material,
        });
    }
    let (key, cells, size) = match (raw.rod, raw.grid) {
        (Some(rod), _) => {
            let length = document.number("mesh.length", raw.length.unwrap_or(1.0), Numbers::Positive)?;
            ("mesh.rod", vec![rod], vec![length])
        }
        (None, grid) => {
            let grid = grid.unwrap_or_default();
            let size = raw.size.unwrap_or_else(|| vec![1.0; grid.len()]);
            ("mesh.grid", grid, size)
        }
    };
    let given = cells.clone();
    let cells: Vec<usize> = cells
        .into_iter()
        .map(|n| usize::try_from(n).unwrap_or(0))
        .collect();
    let right = raw.rod.is_some() || (2..=3).contains(&cells.len());
    let regular = Regular::new(&cells, &size).filter(|_| right);
    let regular = regular.ok_or_else(|| {
        document.refuse(
            key,
            format!("is {given:?} with size {size:?}; give two or three whole numbers from 1 (a rod: one), of no more than 22 million vertices in all, and as many sizes above 0 in `mesh.size`"),
        )
    })?;
    let needed = bytes_of(regular.dims(), regular.vertices(), regular.elements());
    if needed > most {
        return Err(Failure::Memory(format!(
            "{}: `{key}` is {given:?}, and the lists of the mesh alone need {} bytes ({}), more than the {} bytes that are left; give a coarser mesh, or raise --memory-limit",
            document.place(key),
            grouped(needed),
            rounded(needed),
            grouped(most)
        )));
    }
    Ok(regular_mesh(&regular, material))
}

/// Bytes of the lists of a mesh: places, corners, and whether a vertex is held.
fn bytes_of(dims: usize, vertices: usize, elements: usize) -> usize {
    vertices * (dims * size_of::<f64>() + size_of::<bool>()) + elements * (dims + 1) * size_of::<u32>()
}

/// Refuses keys of another kind of mesh.
fn refuse_foreign(document: &Document, raw: &RawMesh) -> Result<(), Failure> {
    let keys = [
        ("size", raw.size.is_some(), raw.grid.is_some(), "grid"),
        ("length", raw.length.is_some(), raw.rod.is_some(), "rod"),
        ("area", raw.area.is_some(), raw.rod.is_some(), "rod"),
    ];
    let foreign = keys.into_iter().find(|(_, given, taken, _)| *given && !taken);
    foreign.map_or(Ok(()), |(key, _, _, kind)| {
        let why = format!("is for a mesh by `{kind}`; leave it out");
        Err(document.refuse(&format!("mesh.{key}"), why))
    })
}

fn regular_mesh(regular: &Regular, material: Material) -> OwnedMesh {
    let dims = regular.dims();
    let places = (0..regular.vertices()).map(|vertex| regular.place(vertex));
    let elements = (0..regular.elements()).map(|element| regular.corners(element));
    OwnedMesh {
        dims,
        rest: places.flat_map(|place| place.into_iter().take(dims)).collect(),
        elements: elements
            .flat_map(|corners| corners.into_iter().take(dims + 1))
            .collect(),
        springs: Vec::new(),
        held: vec![false; regular.vertices()],
        own: regular.vertices(),
        regular: regular.sides(),
        material,
    }
}

pub(super) fn material(
    document: &Document,
    raw: RawMaterial,
    otherwise: Material,
) -> Result<Material, Failure> {
    let positive = |key: &str, given: Option<f64>, otherwise: f64| {
        document.number(
            &format!("material.{key}"),
            given.unwrap_or(otherwise),
            Numbers::Positive,
        )
    };
    let poisson = raw.poisson.unwrap_or(otherwise.poisson);
    if !(poisson > -1.0 && poisson < 0.5) {
        let allowed = "a number above -1 and below 1/2";
        return Err(document.outside("material.poisson", format_args!("{poisson:?}"), allowed));
    }
    Ok(Material {
        young: positive("young", raw.young, otherwise.young)?,
        density: positive("density", raw.density, otherwise.density)?,
        poisson,
        area: otherwise.area,
    })
}

/// Numbers of a place, as many as the mesh has dimensions.
pub(super) fn place(document: &Document, key: &str, found: &[f64], dims: usize) -> Result<Vec<f64>, Failure> {
    if found.len() == dims && found.iter().all(|x| x.is_finite()) {
        return Ok(found.to_vec());
    }
    Err(document.outside(
        key,
        format_args!("{found:?}"),
        format_args!("a list of {dims} finite numbers"),
    ))
}

/// Holds vertices; by how much each moves at every step.
pub(super) fn hold(
    document: &Document,
    raw: Vec<RawHold>,
    mesh: &mut OwnedMesh,
) -> Result<Vec<f64>, Failure> {
    let (dims, slack) = (mesh.dims, mesh.slack());
    let mut moves = vec![0.0; mesh.rest.len()];
    for (index, hold) in raw.into_iter().enumerate() {
        let key = format!("hold[{index}]");
        let low = place(document, &format!("{key}.box.min"), &hold.bounds.min, dims)?;
        let high = place(document, &format!("{key}.box.max"), &hold.bounds.max, dims)?;
        let by = hold.by.unwrap_or_else(|| vec![0.0; dims]);
        let by = place(document, &format!("{key}.move"), &by, dims)?;
        let mut caught = false;
        let rows = mesh.rest.chunks_exact(dims).zip(moves.chunks_exact_mut(dims));
        for ((at, to), held) in rows.zip(&mut mesh.held) {
            let mut bounds = at.iter().zip(low.iter().zip(&high));
            if bounds.all(|(x, (low, high))| *x >= low - slack && *x <= high + slack) {
                (*held, caught) = (true, true);
                to.copy_from_slice(&by);
            }
        }
        if !caught {
            return Err(document.refuse(
                &format!("{key}.box"),
                "holds no vertex; make it larger, or leave it out",
            ));
        }
    }
    Ok(moves)
}

/// Adds springs; those that end outside of the mesh add a fixed point, which does not move.
pub(super) fn springs(
    document: &Document,
    raw: Vec<RawSpring>,
    mesh: &mut OwnedMesh,
    mut moves: Vec<f64>,
) -> Result<Vec<f64>, Failure> {
    let (extent, slack) = (mesh.extent(), mesh.slack());
    for (index, spring) in raw.into_iter().enumerate() {
        let key = format!("spring[{index}]");
        let from = place(document, &format!("{key}.from"), &spring.from, mesh.dims)?;
        let to = place(document, &format!("{key}.to"), &spring.to, mesh.dims)?;
        let outside = |(x, [low, high]): (&f64, &[f64; 2])| *x < low - slack || *x > high + slack;
        let start = mesh.nearest(&from);
        let end = if to.iter().zip(&extent).any(outside) {
            mesh.rest.extend(&to);
            mesh.held.push(true);
            moves.extend(to.iter().map(|_| 0.0));
            mesh.held.len() - 1
        } else {
            mesh.nearest(&to)
        };
        if start == end {
            return Err(document.refuse(&key, "begins and ends at the same vertex; move `to`"));
        }
        let at = |name: &str| format!("{key}.{name}");
        mesh.springs.push(Spring {
            ends: [start as u32, end as u32],
            stiffness: document.number(&at("stiffness"), spring.stiffness, Numbers::Positive)?,
            rest_length: document.number(&at("rest_length"), spring.rest_length, Numbers::NotNegative)?,
            in_basis: spring.in_basis.unwrap_or(true),
        });
    }
    Ok(moves)
}

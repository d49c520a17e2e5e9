//! What is joined to what: the order of the unknowns, the rows of the Hessian, colours. Made once from a mesh, in words of the caller.

use super::colouring::colours;
use super::error::CondenseError;
use super::mesh::Mesh;
use super::ordering::{Marks, Neighbours, Ordering};
use super::patches::{self, Counted};
use super::words::{Words, begin_rows, fill_rows, row};

/// Who is joined to whom in a mesh. Free vertices are numbered anew, in the order of the unknowns: reverse Cuthill-McKee's.
#[derive(Clone, Copy, Debug)]
pub struct Topology<'t> {
    /// The number of each vertex: a free one's among the free, a held one's behind all of them.
    pub(super) place: &'t [u32],
    /// The vertex of each number.
    pub(super) vertex: &'t [u32],
    /// Where the star of each vertex begins.
    star_begin: &'t [u32],
    /// Its simplices with the corner that it is, as simplex (d + 1) + corner.
    star: &'t [u32],
    tie_begin: &'t [u32],
    /// Springs of each vertex.
    tie: &'t [u32],
    /// Where the row of each free vertex begins in `columns`,
    pub(super) row_begin: &'t [u32],
    /// the free vertices that it is joined to, itself among them, in ascending order.
    pub(super) columns: &'t [u32],
    /// The colour of each free vertex.
    pub(super) colour: &'t [u32],
    pub(super) colours: usize,
    free: usize,
    /// The largest difference of numbers that are joined.
    width: usize,
    unheld: Option<usize>,
    /// Edges of the patches, and how many free vertices they have.
    pub(super) patches: Option<(usize, Counted)>,
}

impl<'t> Topology<'t> {
    /// Words that the topology of a mesh takes, those that only its making needs among them.
    #[must_use]
    pub fn words(mesh: &Mesh<'_>) -> usize {
        let counts = [mesh.vertices(), mesh.count(), mesh.springs.len()];
        Self::words_of(mesh.dims, counts).unwrap_or(usize::MAX)
    }

    /// The same of a mesh of so many vertices, simplices and springs, if they can be counted.
    #[must_use]
    pub fn words_of(dims: usize, [vertices, simplices, springs]: [usize; 3]) -> Option<usize> {
        let (corners, ends) = (simplices.checked_mul(dims + 1)?, springs.checked_mul(2)?);
        // place, vertex, colour, three lists of where rows begin, marks, levels and degrees, and each vertex of its own columns,
        let of_vertices = vertices.checked_mul(10)?.checked_add(3)?;
        // stars and the columns that they make, ties and the same.
        let of_stars = corners.checked_mul(dims + 1)?;
        of_vertices
            .checked_add(of_stars)?
            .checked_add(ends.checked_mul(2)?)
    }

    /// The topology of a mesh, in at least [`Self::words`] words; `radius` is that of the basis' patches.
    ///
    /// # Errors
    /// What [`Mesh::check`] refuses; no free vertex; a free vertex of no simplex; too few words.
    pub fn new(mesh: &Mesh<'_>, radius: Option<usize>, words: &'t mut [u32]) -> Result<Self, CondenseError> {
        mesh.check()?;
        let needed = Self::words(mesh);
        let short = CondenseError::Memory {
            needed: needed.saturating_mul(4),
        };
        let mut words = Words(words.get_mut(..needed).ok_or(short)?);
        Self::fill(mesh, radius, &mut words).ok_or(short)?
    }

    fn fill(
        mesh: &Mesh<'_>,
        radius: Option<usize>,
        words: &mut Words<'t>,
    ) -> Option<Result<Self, CondenseError>> {
        let n = mesh.vertices();
        let free = mesh.held.iter().filter(|held| !**held).count();
        if free == 0 {
            return Some(Err(CondenseError::AllHeld));
        }
        let (star_begin, star) = stars(mesh, words)?;
        let (tie_begin, tie) = ties(mesh, words)?;
        let loose = (0..n).find(|&vertex| {
            !mesh.held.get(vertex).copied().unwrap_or(true) && row(star_begin, star, vertex).is_empty()
        });
        if let Some(vertex) = loose {
            return Some(Err(CondenseError::Loose { vertex }));
        }
        let neighbours = Neighbours {
            mesh: *mesh,
            star_begin,
            star,
            tie_begin,
            tie,
        };
        let (place, vertex) = (words.take(n)?, words.take(n)?);
        let colour = words.take(n)?;
        let (marks, level, degree) = (words.take(n)?, words.take(n)?, words.take(n)?);
        let unheld = Ordering {
            neighbours: &neighbours,
            marks: Marks::new(marks),
            level,
            degree,
        }
        .run(&mut vertex[..free]);
        number(mesh, place, vertex, free);
        let mut marks = Marks::new(marks);
        let (row_begin, columns) = rows(&neighbours, place, &vertex[..free], &mut marks, words)?;
        let patches = radius.map(|radius| {
            (
                radius,
                patches::count((row_begin, columns), radius, &mut marks, degree),
            )
        });
        let colours = colours(&neighbours, place, &mut colour[..free], level);
        let distance = |(number, columns): (usize, &[u32])| {
            columns
                .iter()
                .map(|&column| number.abs_diff(column as usize))
                .max()
                .unwrap_or(0)
        };
        let width = (0..free)
            .map(|number| distance((number, row(row_begin, columns, number))))
            .max();
        Some(Ok(Self {
            place,
            vertex,
            star_begin,
            star,
            tie_begin,
            tie,
            row_begin,
            columns,
            colour,
            colours,
            free,
            width: width.unwrap_or(0),
            unheld,
            patches,
        }))
    }

    /// Vertices that are not held.
    #[must_use]
    pub fn free(&self) -> usize {
        self.free
    }

    /// The free vertices, in the order of the unknowns.
    #[must_use]
    pub fn free_vertices(&self) -> &'t [u32] {
        self.vertex.get(..self.free).unwrap_or(&[])
    }

    /// Pairs of free vertices that are joined, each vertex with itself among them: blocks of the Hessian.
    #[must_use]
    pub fn blocks(&self) -> usize {
        self.columns.len()
    }

    /// Half the bandwidth of the Hessian, in unknowns of `dims` to a vertex, without the diagonal.
    #[must_use]
    pub fn band(&self, dims: usize) -> usize {
        self.width * dims + dims - 1
    }

    /// The first vertex of a part that is joined to no held vertex.
    #[must_use]
    pub fn unheld(&self) -> Option<usize> {
        self.unheld
    }

    /// Colours of which no two vertices that are joined have the same.
    #[must_use]
    pub fn colours(&self) -> usize {
        self.colours
    }

    /// The simplices of a vertex and the corner that it is of each.
    pub(super) fn star(
        &self,
        vertex: usize,
        corners: usize,
    ) -> impl Iterator<Item = (usize, usize)> + use<'t> {
        let star = row(self.star_begin, self.star, vertex).iter();
        star.map(move |&at| (at as usize / corners, at as usize % corners))
    }

    /// The springs of a vertex.
    pub(super) fn ties(&self, vertex: usize) -> &'t [u32] {
        row(self.tie_begin, self.tie, vertex)
    }

    /// Free vertices that free vertex `number` is joined to, and itself.
    #[inline(always)]
    pub(super) fn row(&self, number: usize) -> &'t [u32] {
        row(self.row_begin, self.columns, number)
    }
}

type Lists<'t> = (&'t [u32], &'t [u32]);

/// The simplices of each vertex.
fn stars<'t>(mesh: &Mesh<'_>, words: &mut Words<'t>) -> Option<Lists<'t>> {
    let (begin, list) = (words.take(mesh.vertices() + 1)?, words.take(mesh.elements.len())?);
    for &corner in mesh.elements {
        *begin.get_mut(corner as usize + 1)? += 1;
    }
    begin_rows(begin);
    let entries = mesh.elements.iter().enumerate();
    fill_rows(
        begin,
        list,
        entries.map(|(at, &corner)| (corner as usize, at as u32)),
    );
    Some((begin, list))
}

/// The springs of each vertex.
fn ties<'t>(mesh: &Mesh<'_>, words: &mut Words<'t>) -> Option<Lists<'t>> {
    let (begin, list) = (
        words.take(mesh.vertices() + 1)?,
        words.take(2 * mesh.springs.len())?,
    );
    for end in mesh.springs.iter().flat_map(|spring| spring.ends) {
        *begin.get_mut(end as usize + 1)? += 1;
    }
    begin_rows(begin);
    let ends = mesh.springs.iter().enumerate();
    let entries = ends.flat_map(|(at, spring)| spring.ends.map(|end| (end as usize, at as u32)));
    fill_rows(begin, list, entries);
    Some((begin, list))
}

/// Numbers free vertices as they lie in `vertex`, and held ones behind them.
fn number(mesh: &Mesh<'_>, place: &mut [u32], vertex: &mut [u32], free: usize) {
    let held = mesh.held.iter().enumerate().filter(|(_, held)| **held);
    for (to, (from, _)) in vertex.iter_mut().skip(free).zip(held) {
        *to = from as u32;
    }
    for (number, &vertex) in vertex.iter().enumerate() {
        if let Some(place) = place.get_mut(vertex as usize) {
            *place = number as u32;
        }
    }
}

/// The columns of each row of the Hessian.
fn rows<'t>(
    neighbours: &Neighbours<'_>,
    place: &[u32],
    vertices: &[u32],
    marks: &mut Marks<'_>,
    words: &mut Words<'t>,
) -> Option<Lists<'t>> {
    let begin = words.take(vertices.len() + 1)?;
    let rest = core::mem::take(&mut words.0);
    let mut count = 0;
    for (number, &vertex) in vertices.iter().enumerate() {
        let first = count;
        *rest.get_mut(count)? = number as u32;
        count += 1;
        marks.renew();
        neighbours.visit(vertex as usize, marks, |other| {
            if let (Some(to), Some(&from)) = (rest.get_mut(count), place.get(other)) {
                *to = from;
                count += 1;
            }
        });
        rest.get_mut(first..count)?.sort_unstable();
        *begin.get_mut(number + 1)? = count as u32;
    }
    Some((begin, rest.get(..count)?))
}

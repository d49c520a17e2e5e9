//! Reverse Cuthill-McKee: an order of the free vertices in which those that are joined lie near each other.

use super::mesh::Mesh;
use super::words::row;

/// Marks that are taken back all at once.
pub struct Marks<'a> {
    marks: &'a mut [u32],
    round: u32,
}

impl<'a> Marks<'a> {
    /// One for each of `marks`.
    pub fn new(marks: &'a mut [u32]) -> Self {
        marks.fill(0);
        Self { marks, round: 0 }
    }

    /// Takes all back.
    pub fn renew(&mut self) {
        self.round = self.round.wrapping_add(1);
        if self.round == 0 {
            self.marks.fill(0);
            self.round = 1;
        }
    }

    /// Marks `index`; whether it was not marked.
    pub fn mark(&mut self, index: usize) -> bool {
        let mark = self.marks.get_mut(index);
        mark.is_some_and(|mark| core::mem::replace(mark, self.round) != self.round)
    }
}

/// Who is joined to whom, by simplices and by springs.
pub struct Neighbours<'a> {
    pub mesh: Mesh<'a>,
    pub star_begin: &'a [u32],
    pub star: &'a [u32],
    pub tie_begin: &'a [u32],
    pub tie: &'a [u32],
}

impl Neighbours<'_> {
    /// Calls `each` once for every vertex, held or not, that `vertex` is joined to.
    fn visit_all(&self, vertex: usize, marks: &mut Marks<'_>, mut each: impl FnMut(usize)) {
        marks.mark(vertex);
        let corners = self.mesh.corners();
        for &at in row(self.star_begin, self.star, vertex) {
            for &other in self.mesh.corners_of(at as usize / corners) {
                if marks.mark(other as usize) {
                    each(other as usize);
                }
            }
        }
        for &at in row(self.tie_begin, self.tie, vertex) {
            let ends = self.mesh.springs.get(at as usize).map(|spring| spring.ends);
            for other in ends.into_iter().flatten() {
                if marks.mark(other as usize) {
                    each(other as usize);
                }
            }
        }
    }

    fn is_held(&self, vertex: usize) -> bool {
        self.mesh.held.get(vertex).copied().unwrap_or(true)
    }

    /// Calls `each` once for every other free vertex that `vertex` is joined to and that is not marked.
    pub fn visit(&self, vertex: usize, marks: &mut Marks<'_>, mut each: impl FnMut(usize)) {
        self.visit_all(vertex, marks, |other| {
            if !self.is_held(other) {
                each(other);
            }
        });
    }
}

/// What orders.
pub struct Ordering<'a, 'b> {
    pub neighbours: &'a Neighbours<'b>,
    pub marks: Marks<'a>,
    /// 1 where a vertex has its place, 2 where the breadth-first search of this round has been.
    pub level: &'a mut [u32],
    pub degree: &'a mut [u32],
}

/// A vertex has its place.
const PLACED: u32 = u32::MAX;

impl Ordering<'_, '_> {
    /// Writes all free vertices into `order`; the first vertex of a part that is joined to no held one.
    pub fn run(mut self, order: &mut [u32]) -> Option<usize> {
        let n = self.neighbours.mesh.vertices();
        for vertex in 0..n {
            let mut count = 0;
            self.marks.renew();
            self.neighbours.visit(vertex, &mut self.marks, |_| count += 1);
            if let Some(degree) = self.degree.get_mut(vertex) {
                *degree = count;
            }
        }
        let (mut placed, mut round, mut unheld) = (0, 0, None);
        for vertex in 0..n {
            if self.neighbours.is_held(vertex) || self.level.get(vertex) == Some(&PLACED) {
                continue;
            }
            let rest = order.get_mut(placed..).unwrap_or(&mut []);
            let start = self.outermost(vertex, rest, &mut round);
            round += 1;
            let (count, _) = self.search(start, rest, round);
            let part = rest.get(..count).unwrap_or(&[]);
            if unheld.is_none() && !self.touches_held(part) {
                unheld = part.iter().map(|&vertex| vertex as usize).min();
            }
            for &vertex in part {
                if let Some(level) = self.level.get_mut(vertex as usize) {
                    *level = PLACED;
                }
            }
            placed += count;
        }
        order.reverse();
        unheld
    }

    fn touches_held(&mut self, part: &[u32]) -> bool {
        let mut touches = false;
        for &vertex in part {
            self.marks.renew();
            let neighbours = self.neighbours;
            neighbours.visit_all(vertex as usize, &mut self.marks, |other| {
                touches |= neighbours.is_held(other);
            });
        }
        touches
    }

    /// A vertex that is far from another (George and Liu 1979).
    fn outermost(&mut self, start: usize, queue: &mut [u32], round: &mut u32) -> usize {
        let (mut start, mut depth) = (start, 0);
        loop {
            *round += 1;
            let (count, (first, deep)) = self.search(start, queue, *round);
            if deep <= depth {
                return start;
            }
            depth = deep;
            let last = queue.get(first..count).unwrap_or(&[]);
            let degree = |vertex: &&u32| self.degree.get(**vertex as usize).copied();
            match last.iter().min_by_key(degree) {
                Some(&next) => start = next as usize,
                None => return start,
            }
        }
    }

    /// Writes the part of `start` into `queue` in the order of Cuthill and McKee: how many there are, and where the last level begins and its depth.
    fn search(&mut self, start: usize, queue: &mut [u32], round: u32) -> (usize, (usize, usize)) {
        let reach = |level: &mut [u32], vertex: usize| match level.get_mut(vertex) {
            Some(level) if *level != round && *level != PLACED => {
                *level = round;
                true
            }
            _ => false,
        };
        reach(self.level, start);
        let Some(first) = queue.first_mut() else {
            return (0, (0, 0));
        };
        *first = start as u32;
        let (mut count, mut next, mut depth, mut begin) = (1, 0, 0, 0);
        while next < count {
            let end = count;
            begin = next;
            while next < end {
                let vertex = queue.get(next).copied().unwrap_or_default() as usize;
                next += 1;
                let from = count;
                self.marks.renew();
                let level = &mut *self.level;
                self.neighbours.visit(vertex, &mut self.marks, |other| {
                    if reach(level, other)
                        && let Some(place) = queue.get_mut(count)
                    {
                        *place = other as u32;
                        count += 1;
                    }
                });
                let degree = &*self.degree;
                let key = |vertex: &u32| (degree.get(*vertex as usize).copied(), *vertex);
                queue
                    .get_mut(from..count)
                    .unwrap_or(&mut [])
                    .sort_unstable_by_key(key);
            }
            depth += 1;
        }
        (count, (begin, depth))
    }
}

//! How often a surface goes round a point: the fast winding number of Barill, Dickson, Schmidt, Levin and Jacobson, "Fast winding numbers
//! for soups and clouds", ACM Transactions on Graphics 37 (2018).
//!
//! w(p) = 1/(4 pi) times the sum of the solid angles of all triangles, seen from p: 1 inside of a closed surface, 0 outside, and in between
//! where there are holes. A group of triangles that is far away counts as a dipole: n . (c - p) / |c - p|^3, with the sum n of their
//! normals times area and the mean c of their middles by area.

use super::surface::{Point, Surface};
use crate::keyframes::solid::{dot, minus};

/// Triangles of the smallest groups.
const LEAF: usize = 8;
/// A group counts as a dipole beyond so many of its radii.
const FAR: f64 = 2.0;

/// The triangles in a tree of groups.
pub(super) struct Winding {
    /// In the order of a walk that goes down first; each says where it goes on without going down.
    groups: Vec<Group>,
    triangles: Vec<[Point; 3]>,
}

struct Group {
    middle: Point,
    radius: f64,
    /// Sum of normals times area.
    dipole: Point,
    /// Its triangles, where it is one of the smallest.
    triangles: core::ops::Range<u32>,
    next: u32,
}

impl Winding {
    pub fn new(surface: &Surface) -> Self {
        let mut triangles: Vec<[Point; 3]> = surface
            .triangles
            .iter()
            .map(|&triangle| surface.corners(triangle))
            .collect();
        let mut groups = Vec::with_capacity(4 * triangles.len() / LEAF + 1);
        split(&mut triangles, 0, &mut groups);
        Self { groups, triangles }
    }

    /// w at `point`.
    pub fn at(&self, point: Point) -> f64 {
        let (mut sum, mut index) = (0.0, 0);
        while let Some(group) = self.groups.get(index) {
            let away = minus(group.middle, point);
            let distance = dot(away, away).sqrt();
            if distance > FAR * group.radius {
                sum += dot(group.dipole, away) / (distance * distance * distance);
                index = group.next as usize;
                continue;
            }
            let (begin, end) = (group.triangles.start as usize, group.triangles.end as usize);
            for triangle in self.triangles.get(begin..end).unwrap_or_default() {
                sum += solid_angle(triangle.map(|corner| minus(corner, point)));
            }
            index += 1;
        }
        sum / (4.0 * core::f64::consts::PI)
    }
}

/// Adds the group of `triangles`, which begin at `begin` of all, and those within it.
fn split(triangles: &mut [[Point; 3]], begin: u32, groups: &mut Vec<Group>) {
    let own = groups.len();
    let (middle, dipole) = moments(triangles);
    let square = |corner: &Point| {
        let away = minus(*corner, middle);
        dot(away, away)
    };
    let radius = triangles.iter().flatten().map(square).fold(0.0, f64::max).sqrt();
    let leaf = triangles.len() <= LEAF;
    let held = if leaf {
        begin..begin + triangles.len() as u32
    } else {
        0..0
    };
    groups.push(Group {
        middle,
        radius,
        dipole,
        triangles: held,
        next: 0,
    });
    if !leaf {
        let axis = longest_axis(triangles);
        let half = triangles.len() / 2;
        triangles.select_nth_unstable_by(half, |a, b| sum_along(a, axis).total_cmp(&sum_along(b, axis)));
        let (low, high) = triangles.split_at_mut(half);
        split(low, begin, groups);
        split(high, begin + half as u32, groups);
    }
    let next = groups.len() as u32;
    if let Some(group) = groups.get_mut(own) {
        group.next = next;
    }
}

/// The mean of the middles by area, and the sum of normals times area.
fn moments(triangles: &[[Point; 3]]) -> (Point, Point) {
    let (mut middle, mut plain, mut dipole, mut areas) = ([0.0; 3], [0.0; 3], [0.0; 3], 0.0);
    for &[a, b, c] in triangles {
        let normal = cross(minus(b, a), minus(c, a)).map(|x| 0.5 * x);
        let area = dot(normal, normal).sqrt();
        areas += area;
        for axis in 0..3 {
            let third = (a[axis] + b[axis] + c[axis]) / 3.0;
            middle[axis] += area * third;
            plain[axis] += third / triangles.len() as f64;
            dipole[axis] += normal[axis];
        }
    }
    let middle = if areas > 0.0 {
        middle.map(|x| x / areas)
    } else {
        plain
    };
    (middle, dipole)
}

fn longest_axis(triangles: &[[Point; 3]]) -> usize {
    let width = |axis: usize| {
        let sums = triangles.iter().map(|triangle| sum_along(triangle, axis));
        let (low, high) = sums.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| {
            (low.min(x), high.max(x))
        });
        high - low
    };
    (0..3).max_by(|&a, &b| width(a).total_cmp(&width(b))).unwrap_or(0)
}

fn sum_along(triangle: &[Point; 3], axis: usize) -> f64 {
    triangle.iter().filter_map(|corner| corner.get(axis)).sum()
}

/// The solid angle of a triangle, seen from the origin: van Oosterom and Strackee 1983.
fn solid_angle([a, b, c]: [Point; 3]) -> f64 {
    let [la, lb, lc] = [a, b, c].map(|corner| dot(corner, corner).sqrt());
    let volume = dot(a, cross(b, c));
    let below = la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb;
    2.0 * volume.atan2(below)
}

pub(super) fn cross(a: Point, b: Point) -> Point {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

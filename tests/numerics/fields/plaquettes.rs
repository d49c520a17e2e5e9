//! The plaquettes of the second implementation and self-advection by them (section 2).

use super::naive::Naive;
use super::{Components, largest, places};

impl Naive {
    /// The ordered axis pairs of the plaquettes.
    pub fn pairs(&self) -> &'static [(usize, usize)] {
        if self.grid.dims == 2 {
            &[(0, 1)]
        } else {
            &[(0, 1), (1, 2), (2, 0)]
        }
    }

    /// Calls `visit` with the axes a, b of every plaquette that is not on a wall or at a closed face, and the places of its faces A-, A+, B-, B+.
    pub fn each_plaquette(&self, mut visit: impl FnMut((usize, usize), [[usize; 3]; 4])) {
        for &(a, b) in self.pairs() {
            for at in places(&self.grid) {
                if let (Some(below), Some(left)) = (self.step(at, b, -1), self.step(at, a, -1)) {
                    let faces = [(a, below), (a, at), (b, left), (b, at)];
                    if !faces.iter().any(|&(axis, at)| self.wall(at, axis)) {
                        visit((a, b), [below, at, left, at]);
                    }
                }
            }
        }
    }

    /// omega, abar, bbar of a plaquette.
    fn plaquette(&self, v: &Components<f64>, (a, b): (usize, usize), faces: [[usize; 3]; 4]) -> [f64; 3] {
        let [am, ap, bm, bp] = self.values(v, (a, b), faces);
        [
            (bp - bm) / self.grid.h[a] - (ap - am) / self.grid.h[b],
            (am + ap) / 2.0,
            (bm + bp) / 2.0,
        ]
    }

    fn values(&self, v: &Components<f64>, (a, b): (usize, usize), faces: [[usize; 3]; 4]) -> [f64; 4] {
        [
            v[a][self.id(faces[0])],
            v[a][self.id(faces[1])],
            v[b][self.id(faces[2])],
            v[b][self.id(faces[3])],
        ]
    }

    fn spread(
        &self,
        (a, b): (usize, usize),
        faces: [[usize; 3]; 4],
        by: [f64; 4],
        out: &mut Components<f64>,
    ) {
        for (i, axis) in [a, a, b, b].into_iter().enumerate() {
            out[axis][self.id(faces[i])] += by[i];
        }
    }

    /// Adv[v] + nu C^T C v.
    pub fn advection(&self, v: &Components<f64>) -> Components<f64> {
        let mut out = self.at_faces(|_, _| 0.0);
        self.each_plaquette(|pair, faces| {
            self.spread(
                pair,
                faces,
                self.at_plaquette(pair, self.values(v, pair, faces)),
                &mut out,
            )
        });
        out
    }

    /// What a plaquette does to its faces A-, A+, B-, B+ by the velocities there.
    pub fn at_plaquette(&self, (a, b): (usize, usize), [am, ap, bm, bp]: [f64; 4]) -> [f64; 4] {
        let (ha, hb) = (self.grid.h[a], self.grid.h[b]);
        let omega = (bp - bm) / ha - (ap - am) / hb;
        let (to_a, to_b) = (-omega * (bm + bp) / 4.0, omega * (am + ap) / 4.0);
        let drag = self.viscosity * omega;
        [
            to_a + drag / hb,
            to_a - drag / hb,
            to_b - drag / ha,
            to_b + drag / ha,
        ]
    }

    /// J(v)^T m + nu C^T C m, plaquette by plaquette.
    pub fn adjoint(&self, v: &Components<f64>, m: &Components<f64>) -> Components<f64> {
        let mut out = self.at_faces(|_, _| 0.0);
        self.each_plaquette(|pair, faces| {
            let [omega, abar, bbar] = self.plaquette(v, pair, faces);
            let [mam, map, mbm, mbp] = self.values(m, pair, faces);
            let (ma, mb) = (-(mam + map) / 2.0, (mbm + mbp) / 2.0);
            let g = ma * bbar + mb * abar + self.viscosity * self.plaquette(m, pair, faces)[0];
            let (ga, gb) = (g / self.grid.h[pair.1], g / self.grid.h[pair.0]);
            let by = [
                ga + mb * omega / 2.0,
                -ga + mb * omega / 2.0,
                -gb + ma * omega / 2.0,
                gb + ma * omega / 2.0,
            ];
            self.spread(pair, faces, by, &mut out);
        });
        out
    }

    /// max |omega| over the plaquettes.
    pub fn largest_curl(&self, v: &Components<f64>) -> f64 {
        let mut all = 0.0;
        self.each_plaquette(|pair, faces| all = largest([all, self.plaquette(v, pair, faces)[0]]));
        all
    }
}

//! Meshes for the tests, and a run of each.

use crate::fields::Memory;
use thurible_core::condense::{
    CondenseParams, CondensePlan, Condenser, Material, Mesh, Regular, Spring, Step, Topology,
};
use thurible_core::{Exec, Real, Serial, Silent, Status};

/// A mesh that owns its lists.
#[derive(Clone)]
pub struct Bench {
    pub dims: usize,
    pub rest: Vec<f64>,
    pub elements: Vec<u32>,
    pub springs: Vec<Spring>,
    pub held: Vec<bool>,
    pub regular: [usize; 3],
    pub material: Material,
}

impl Bench {
    /// A regular mesh, held where `held` says so.
    pub fn new(cells: &[usize], size: &[f64], held: impl Fn([f64; 3]) -> bool) -> Self {
        let mesh = Regular::new(cells, size).unwrap();
        let dims = mesh.dims();
        let places: Vec<[f64; 3]> = (0..mesh.vertices()).map(|vertex| mesh.place(vertex)).collect();
        Self {
            dims,
            rest: places.iter().flat_map(|place| place[..dims].to_vec()).collect(),
            elements: (0..mesh.elements())
                .flat_map(|element| mesh.corners(element)[..=dims].to_vec())
                .collect(),
            springs: Vec::new(),
            held: places.iter().map(|&place| held(place)).collect(),
            regular: mesh.sides(),
            material: Material::default(),
        }
    }

    /// A unit square or cube of `m` cells a side, its ends along x held.
    pub fn stretch(dims: usize, m: usize) -> Self {
        Self::new(&vec![m; dims], &vec![1.0; dims], |place| {
            place[0] == 0.0 || place[0] == 1.0
        })
    }

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

    pub fn vertices(&self) -> usize {
        self.held.len()
    }

    /// Components of the free vertices, as vertex and axis.
    pub fn unknowns(&self) -> Vec<[usize; 2]> {
        let vertices = (0..self.vertices()).filter(|&vertex| !self.held[vertex]);
        vertices
            .flat_map(|vertex| (0..self.dims).map(move |k| [vertex, k]))
            .collect()
    }

    pub fn place(&self, vertex: usize) -> &[f64] {
        &self.rest[vertex * self.dims..(vertex + 1) * self.dims]
    }

    /// Numbers of vertices, made of their place and whether they are held.
    pub fn field(&self, made: impl Fn(&[f64], bool, usize) -> f64) -> Vec<f64> {
        let each = |vertex: usize| {
            let made = &made;
            (0..self.dims).map(move |axis| made(self.place(vertex), self.held[vertex], axis))
        };
        (0..self.vertices()).flat_map(each).collect()
    }

    /// What the right end moves by in a step of `stretch`.
    pub fn pull(&self, by: f64) -> Vec<f64> {
        self.field(|place, held, axis| {
            if held && place[0] == 1.0 && axis == 0 {
                by
            } else {
                0.0
            }
        })
    }

    /// Random numbers below `size` at the free vertices, and at held ones too if `all`.
    pub fn random(&self, size: f64, all: bool) -> Vec<f64> {
        let mut random = crate::fields::random::Random::new(7);
        let mut values: Vec<f64> = (0..self.rest.len()).map(|_| size * random.signed()).collect();
        for (vertex, held) in self.held.iter().enumerate() {
            if *held && !all {
                values[vertex * self.dims..(vertex + 1) * self.dims].fill(0.0);
            }
        }
        values
    }

    /// What `work` makes of a run.
    pub fn run<T: Real, const D: usize, R>(
        &self,
        params: CondenseParams,
        work: impl FnOnce(&mut Condenser<'_, T, D>) -> R,
    ) -> R {
        let mesh = self.mesh();
        let mut words = vec![0; Topology::words(&mesh)];
        let topology = Topology::new(&mesh, params.radius, &mut words).unwrap();
        let plan = CondensePlan::new::<T>(&mesh, &topology, &params).unwrap();
        let mut memory = Memory::new(plan.bytes());
        work(&mut Condenser::new(mesh, topology, params, memory.block()).unwrap())
    }

    /// Iterations of each step while they converge, builds of each, and the energy at the end.
    pub fn steps<T: Real, const D: usize>(
        &self,
        params: CondenseParams,
        steps: &[Step<'_>],
    ) -> (Vec<usize>, Vec<usize>, f64) {
        self.steps_on::<T, D>(&Serial, params, steps)
    }

    pub fn steps_on<T: Real, const D: usize>(
        &self,
        exec: &dyn Exec,
        params: CondenseParams,
        steps: &[Step<'_>],
    ) -> (Vec<usize>, Vec<usize>, f64) {
        self.run::<T, D, _>(params, |condenser| {
            let (mut iterations, mut builds, mut energy) = (Vec::new(), Vec::new(), 0.0);
            for step in steps {
                let stepped = condenser
                    .step(exec, step, &mut Silent, &mut |at| energy = at.energy)
                    .unwrap();
                iterations.push(stepped.iterations);
                builds.push(stepped.builds);
                if stepped.status != Status::Converged {
                    break;
                }
            }
            (iterations, builds, energy)
        })
    }
}

/// The largest difference, in parts of the largest that is expected.
pub fn apart(found: &[f64], expected: &[f64]) -> f64 {
    assert_eq!(found.len(), expected.len());
    let largest = expected
        .iter()
        .fold(0.0, |most: f64, value| most.max(value.abs()));
    let differences = found
        .iter()
        .zip(expected)
        .map(|(found, expected)| (found - expected).abs());
    differences.fold(0.0, f64::max) / largest
}

/// The same count, within 1 below 20 and 5 % above.
pub fn close(found: usize, expected: usize) -> bool {
    let most = if expected < 20 {
        1.0
    } else {
        0.05 * expected as f64
    };
    (found as f64 - expected as f64).abs() <= most
}

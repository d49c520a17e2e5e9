//! A scene, solved by the module and by the core itself.

use super::header::{self, Field, code};
use super::{Host, LINE, PAGE};
use core::mem::MaybeUninit;
use thurible_core::{Boundary, Method, Params, Plan, Problem, Real, Serial, Silent, Solver, Space, Status};
use wasmi::Module;

/// First cells of the block in the source and in the keyframe.
const SOURCE: [usize; 2] = [3, 4];
const KEYFRAME: [usize; 2] = [8, 7];

/// A block of smoke that should be elsewhere at the end.
#[derive(Clone, Debug)]
pub struct Scene {
    /// Cells along each axis.
    pub cells: Vec<usize>,
    /// N, where the keyframe is.
    pub steps: usize,
    pub method: Method,
    pub iterations: usize,
}

/// Bytes that a solve takes in the module's memory.
#[derive(Clone, Copy, Debug)]
pub struct Needs {
    /// Bytes of the instance.
    pub instance: u32,
    /// Pages of the whole memory.
    pub pages: u32,
}

/// Where the host keeps what it hands over.
struct Places {
    config: u32,
    out: u32,
    field: u32,
    field_bytes: u32,
}

impl Scene {
    /// One in a block of 5 x 5 cells (through all of z) whose first is `corner`, nothing elsewhere.
    pub fn density<T: Real>(&self, corner: [usize; 2]) -> Vec<T> {
        let (width, height) = (self.cells[0], self.cells[1]);
        let near = |at: usize, first: usize| (first..first + 5).contains(&at);
        let inside = |cell: usize| near(cell % width, corner[0]) && near(cell / width % height, corner[1]);
        (0..self.cells.iter().product())
            .map(|cell| if inside(cell) { T::ONE } else { T::ZERO })
            .collect()
    }

    /// The bytes of all densities that the core finds.
    pub fn native<T: Real, S: Space>(&self) -> Vec<u8> {
        let (boundary, keyframes) = (vec![Boundary::Wall; self.cells.len()], [self.steps]);
        let problem = Problem::new(&self.cells, &boundary, &keyframes);
        let params = Params {
            method: self.method,
            iterations: self.iterations,
            ..Params::default()
        };
        let bytes = Plan::new::<T, S>(&problem, &params).unwrap().bytes();
        let mut memory = vec![MaybeUninit::<u8>::uninit(); bytes + Plan::ALIGN];
        let start = memory.as_ptr().align_offset(Plan::ALIGN);
        let mut solver = Solver::<T, S>::new(&problem, &params, &mut memory[start..][..bytes]).unwrap();
        solver.set_source(&self.density(SOURCE)).unwrap();
        solver.set_keyframe(0, &self.density(KEYFRAME)).unwrap();
        let status = solver.solve(&Serial, &mut Silent, &mut |_| ());
        assert!(
            matches!(status, Status::Converged | Status::MaxIterations),
            "{status:?}"
        );
        (0..=self.steps)
            .flat_map(|step| bits(solver.density(step)))
            .collect()
    }

    /// What the module needs for it.
    pub fn needs<T: Real>(&self, module: &Module) -> Needs {
        let mut host = Host::new(module, PAGE - 1);
        let places = self.prepare::<T>(&mut host);
        let instance = host.word(places.out);
        Needs {
            instance,
            pages: (host.next() + instance).div_ceil(PAGE),
        }
    }

    /// The bytes of all densities that the module finds with no more pages than it needs.
    pub fn in_module<T: Real>(&self, module: &Module, needs: Needs) -> Vec<u8> {
        let Needs { instance, pages } = needs;
        let mut host = Host::new(module, pages);
        let places = self.prepare::<T>(&mut host);
        let memory = host.take(instance).unwrap();
        ok(host.call("thurible_init", &[memory, instance, places.config, places.out]));
        let handle = host.word(places.out);
        let mut give = |name: &str, corner, before: &[u32], after: &[u32]| {
            host.write(places.field, &bits(&self.density::<T>(corner)));
            ok(host.call(
                name,
                &[&[handle], before, &[places.field, places.field_bytes], after].concat(),
            ));
        };
        give("thurible_set_source", SOURCE, &[], &[]);
        give("thurible_set_keyframe", KEYFRAME, &[0], &[0]);
        ok(host.call("thurible_solve", &[handle, 0, 0, 0]));
        let density = code("THURIBLE_FIELD_DENSITY");
        let mut all = Vec::new();
        for step in 0..=u32::try_from(self.steps).unwrap() {
            ok(host.call(
                "thurible_copy",
                &[handle, density, step, 0, places.field, places.field_bytes],
            ));
            all.extend_from_slice(host.read(places.field, places.field_bytes as usize));
        }
        assert_eq!(
            host.pages(),
            pages,
            "the module has other pages than it was given"
        );
        ok(host.call("thurible_close", &[handle]));
        all
    }

    /// What a host with one page less than [`Needs::pages`] meets: whether the engine refuses to grow, and what the library says of what
    /// is left.
    pub fn refused<T: Real>(&self, module: &Module, needs: Needs) -> (bool, u32) {
        let Needs { instance, pages } = needs;
        let mut host = Host::new(module, pages - 1);
        let places = self.prepare::<T>(&mut host);
        let refused = host.take(instance).is_err();
        let rest = (pages - 1) * PAGE - host.next();
        let memory = host.take(rest).unwrap();
        (
            refused,
            host.call("thurible_init", &[memory, rest, places.config, places.out]),
        )
    }

    /// Writes the configuration and plans it: the bytes of the instance are at `out`.
    fn prepare<T: Real>(&self, host: &mut Host) -> Places {
        let (fields, bytes) = header::structure("ThuribleConfig");
        let field_bytes = u32::try_from(self.cells.iter().product::<usize>() * T::BYTES).unwrap();
        let [config, keyframes, out, field] =
            [bytes, 4, LINE, field_bytes].map(|bytes| host.take(bytes).unwrap());
        ok(host.call("thurible_defaults", &[config, bytes]));
        let place = |name: &str| {
            config
                + fields
                    .iter()
                    .find(|field| field.name == name)
                    .map(|Field { at, .. }| at)
                    .unwrap()
        };
        let precision = if T::BYTES == 4 {
            "THURIBLE_PRECISION_F32"
        } else {
            "THURIBLE_PRECISION_F64"
        };
        let method = match self.method {
            Method::Direct => "THURIBLE_METHOD_DIRECT",
            Method::Admm => "THURIBLE_METHOD_ADMM",
            _ => panic!("{:?} is not in these tests", self.method),
        };
        let steps = self.steps.try_into().unwrap();
        host.write(keyframes, &u32::to_le_bytes(steps));
        let numbers = [
            ("precision", code(precision)),
            ("dimensions", self.cells.len().try_into().unwrap()),
            ("method", code(method)),
            ("steps", steps),
            ("keyframes", keyframes),
            ("keyframe_count", 1),
            ("iterations", self.iterations.try_into().unwrap()),
        ];
        numbers
            .into_iter()
            .for_each(|(name, number)| host.write(place(name), &number.to_le_bytes()));
        for (at, &cells) in (place("cells")..).step_by(4).zip(&self.cells) {
            host.write(at, &u32::try_from(cells).unwrap().to_le_bytes());
        }
        ok(host.call("thurible_plan", &[config, out, 0, 0]));
        Places {
            config,
            out,
            field,
            field_bytes,
        }
    }
}

/// The bytes of numbers as they lie in the module's memory.
pub fn bits<T: Real>(numbers: &[T]) -> Vec<u8> {
    let mut bytes = vec![0; numbers.len() * T::BYTES];
    bytes
        .chunks_exact_mut(T::BYTES)
        .zip(numbers)
        .for_each(|(bytes, number)| number.write(bytes));
    bytes
}

pub fn ok(result: u32) {
    assert_eq!(result, code("THURIBLE_RESULT_OK"));
}

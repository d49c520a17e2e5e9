//! Ranks that share a box, each with a slab of it: the bits of one program, whatever their number.

use crate::fields::Memory;
use crate::fields::channels::{Channels, with_ranks};
use core::sync::atomic::Ordering;
use std::sync::Mutex;
use thurible_core::checkpoint::{HEAD, PartStore, Refused, SavedParts, Sink};
use thurible_core::exec::ranks::{in_order, joined, swap, tell};
use thurible_core::exec::{Ranks, Together};
use thurible_core::field::borders::refresh;
use thurible_core::grid::part::made_here;
use thurible_core::grid::tables::Tables;
use thurible_core::grid::taps::{TRANSFERS, Transfer};
use thurible_core::grid::{Grid, Share, levels};
use thurible_core::nso::transfer;
use thurible_core::objective::coarse;
use thurible_core::words::Named;
use thurible_core::{
    Advection, Boundary, Colours, D2, D3, Emitter, Exec, Feature, Method, NsoSolver, Params, Plan, PlanError,
    Problem, ProblemError, Real, SavedError, Scheme, Serial, ShareError, Silent, Solver, Space, Status,
    Supply, Template, TemplateKind,
};

const W: Boundary = Boundary::Wall;
const P: Boundary = Boundary::Periodic;

/// A box whose flow is simulated, or steered by the direct method or by ADMM.
#[derive(Clone, Copy, Debug)]
struct Case {
    /// How many ranks share rows of the same planes: 1 where each has whole planes.
    beside: usize,
    steered: bool,
    admm: Option<Admm>,
    /// Whether the search begins on coarser grids.
    nested: bool,
    cells: &'static [usize],
    ends: &'static [Boundary],
    scheme: Scheme,
    steps: usize,
    /// What else is asked for: masks, regions, a release, templates.
    more: &'static [Feature],
}

/// What ADMM is asked for.
#[derive(Clone, Copy, Debug)]
struct Admm {
    colours: Colours,
    relaxation: f64,
    penalty: f64,
    solver: NsoSolver,
}

/// A wind, swirls and a pull, each for some of the steps.
const TEMPLATES: [Template; 4] = [
    Template {
        amplitude: [0.01, -0.02, 0.005],
        from: 1,
        ..Template::new(TemplateKind::Wind, [0.5, 0.3, 0.6], 0.3, 3)
    },
    Template {
        amplitude: [0.02, 0.0, 0.0],
        size: 0.2,
        ..Template::new(TemplateKind::Noise, [0.4, 0.6, 0.5], 0.4, 4)
    },
    Template {
        amplitude: [0.03, 0.0, 0.0],
        ..Template::new(TemplateKind::Attract, [0.6, 0.6, 0.4], 0.5, 4)
    },
    Template {
        amplitude: [0.01, -0.01, 0.02],
        ..Template::new(TemplateKind::Vortex, [0.5, 0.7, 0.8], 0.3, 4)
    },
];

const EMITTERS: [Emitter; 2] = [
    Emitter {
        from: 0,
        to: 3,
        supply: Supply::Rate(0.3),
        velocity: Some([0.02, 0.03, -0.01]),
    },
    Emitter {
        from: 1,
        to: 2,
        supply: Supply::Target(0.7),
        velocity: None,
    },
];

/// Without a jet, which ADMM does not know.
const STILL: [Emitter; 1] = [Emitter {
    velocity: None,
    ..EMITTERS[0]
}];

impl Case {
    fn asks_for(&self, feature: Feature) -> bool {
        self.more.contains(&feature)
    }

    fn problem(&self, share: Option<Share>) -> Problem<'_> {
        let keyframes: &[usize] = match (self.steered, self.nested) {
            (false, _) => &[],
            (true, false) => &[2, 4],
            // Two steps are one on coarser grids.
            (true, true) => &[4, 6],
        };
        Problem {
            steps: self.steps,
            // What is filled up to a target has no mass that a keyframe could take.
            emitters: match (self.steered, self.admm) {
                (false, _) => &EMITTERS,
                (true, None) => &EMITTERS[..1],
                (true, Some(_)) => &STILL,
            },
            keyframe_weights: if self.steered { &[0.5] } else { &[] },
            schedule: if self.steered && self.admm.is_none() {
                &[(0, 2.0), (3, 1.0)]
            } else {
                &[]
            },
            buoyancy: [1e-3, 4e-3, 2e-3],
            viscosity: 1e-4,
            slip: !self.asks_for(Feature::Sticking),
            // Smoke that leaves takes mass along.
            match_mass: !self.ends.iter().any(|end| end.is_open()),
            solids: self.asks_for(Feature::Solids),
            mask: self.asks_for(Feature::Mask),
            keyframe_regions: self.asks_for(Feature::Regions),
            release: keyframes
                .last()
                .copied()
                .filter(|_| self.asks_for(Feature::Release)),
            templates: if self.asks_for(Feature::Templates) {
                &TEMPLATES
            } else {
                &[]
            },
            advection: Advection {
                scheme: self.scheme,
                ..Advection::default()
            },
            share,
            ..Problem::new(self.cells, self.ends, keyframes)
        }
    }

    fn params(&self) -> Params {
        let mut params = simulate();
        if self.steered {
            (params.method, params.iterations) = (Method::Direct, 4);
            params.direct.nested = self.nested;
            params.direct.coarse_iterations = Some(3);
        }
        if let Some(admm) = self.admm {
            (params.method, params.iterations) = (Method::Admm, 3);
            params.admm.nested = self.nested;
            params.admm.nso.colours = admm.colours;
            params.admm.relaxation = admm.relaxation;
            params.admm.penalty = admm.penalty;
            params.admm.nso.solver = admm.solver;
        }
        params
    }

    /// A blob of smoke around a place, in parts of the box.
    fn blob<T: Real>(&self, around: [f64; 3]) -> Vec<T> {
        let [nx, ny] = [0, 1].map(|axis| self.cells[axis]);
        let density = |cell: usize| {
            let at = [cell % nx, cell / nx % ny, cell / (nx * ny)];
            let far = (0..self.cells.len()).map(|axis| {
                let x = (at[axis] as f64 + 0.5) / self.cells[axis] as f64 - around[axis];
                x * x
            });
            let near: f64 = 1.0 - 9.0 * far.sum::<f64>();
            T::from_f64(near.max(0.0))
        };
        (0..self.cells.iter().product()).map(density).collect()
    }

    /// A block in the middle and a plate one cell thick across half of the box.
    fn is_solid(&self, cell: usize) -> bool {
        let [nx, ny] = [0, 1].map(|axis| self.cells[axis]);
        let at = [cell % nx, cell / nx % ny, cell / (nx * ny)];
        let part = |axis: usize| at[axis] as f64 / self.cells[axis] as f64;
        let last = self.cells.len() - 1;
        let block = (0..=last).all(|axis| (0.45..0.6).contains(&part(axis)));
        block || (at[last] == self.cells[last] * 3 / 4 && part(0) < 0.5)
    }

    fn set_solids<T: Real, S: Space>(&self, solver: &mut Solver<'_, T, S>) {
        if self.asks_for(Feature::Solids) {
            let cells = self.cells.iter().product();
            let solid: Vec<bool> = (0..cells).map(|cell| self.is_solid(cell)).collect();
            solver.set_solids(&solid).unwrap();
        }
    }

    fn set<T: Real, S: Space>(&self, solver: &mut Solver<'_, T, S>) {
        self.set_solids(solver);
        solver.set_source(&self.blob([0.4, 0.45, 0.5])).unwrap();
        solver.set_emitter(0, &self.blob([0.6, 0.3, 0.4])).unwrap();
        if !self.steered {
            solver.set_emitter(1, &self.blob([0.3, 0.7, 0.6])).unwrap();
        }
        // From 0 to 1, in about a third of the box.
        if self.asks_for(Feature::Mask) {
            solver.set_mask(&self.blob([0.5, 0.5, 0.5])).unwrap();
        }
        if self.asks_for(Feature::Regions) {
            solver.set_region(1, &self.blob([0.5, 0.7, 0.5])).unwrap();
        }
        for axis in 0..S::DIM {
            let wave = |face: usize| T::from_f64(0.02 * (0.37 * (face + 5 * axis) as f64).sin());
            let faces: Vec<T> = (0..solver.faces(axis)).map(wave).collect();
            solver.set_initial_velocity(axis, &faces).unwrap();
        }
    }

    /// Everything that the first rank can read, bit by bit; nothing of the others.
    fn bits<T: Real, S: Space>(&self, exec: &dyn Exec, ranks: Option<&Channels>) -> Vec<u64> {
        self.with::<T, S, _>(exec, ranks, |solver, exec| self.solved(solver, exec))
            .unwrap_or_default()
    }

    /// What `work` makes of a solver in the first rank, which the others follow.
    fn with<T: Real, S: Space, R>(
        &self,
        exec: &dyn Exec,
        ranks: Option<&Channels>,
        work: impl FnOnce(&mut Solver<'_, T, S>, &dyn Exec) -> R,
    ) -> Option<R> {
        let states = Mutex::default();
        let mut store = Store::new(ranks, &states);
        self.with_store(exec, ranks, &mut store, |solver, exec, _| work(solver, exec))
    }

    /// The same, with states in `store`.
    fn with_store<T: Real, S: Space, R>(
        &self,
        exec: &dyn Exec,
        ranks: Option<&Channels>,
        store: &mut Store<'_>,
        work: impl FnOnce(&mut Solver<'_, T, S>, &dyn Exec, &mut Store<'_>) -> R,
    ) -> Option<R> {
        let share = ranks.map(|ranks| Share::new(ranks.rank(), ranks.count()).in_blocks(self.beside));
        let (problem, params) = (self.problem(share), self.params());
        let plan = Plan::new::<T, S>(&problem, &params).unwrap();
        let mut memory = Memory::new(plan.bytes());
        let mut solver = Solver::<T, S>::new(&problem, &params, memory.block()).unwrap();
        let Some(ranks) = ranks else {
            return Some(work(&mut solver, exec, store));
        };
        solver.share(ranks);
        let exec = &Together::new(exec, ranks);
        if ranks.rank() > 0 {
            solver.follow(exec, store);
            return None;
        }
        let done = work(&mut solver, exec, store);
        solver.dismiss();
        Some(done)
    }

    /// Gives a solver all that it needs.
    fn begin<T: Real, S: Space>(&self, solver: &mut Solver<'_, T, S>, exec: &dyn Exec) -> Vec<u64> {
        self.set(solver);
        let mut bits = Vec::new();
        for index in 0..if self.steered { 2 } else { 0 } {
            let factor = solver.set_keyframe(index, &self.blob([0.6, 0.6, 0.4]));
            bits.push(factor.unwrap().to_bits());
        }
        bits.push(solver.prepare(exec).unwrap().to_bits());
        bits
    }

    fn solved<T: Real, S: Space>(&self, solver: &mut Solver<'_, T, S>, exec: &dyn Exec) -> Vec<u64> {
        let mut bits = self.begin(solver, exec);
        bits.extend(self.rest(solver, exec));
        bits
    }

    /// What is still done to the end, and the result.
    fn rest<T: Real, S: Space>(&self, solver: &mut Solver<'_, T, S>, exec: &dyn Exec) -> Vec<u64> {
        let mut bits = Vec::new();
        let status = solver.solve(exec, &mut Silent, &mut |progress| {
            bits.push(progress.objective.total().to_bits());
        });
        let ended = if self.steered {
            Status::MaxIterations
        } else {
            Status::Converged
        };
        assert_eq!(status, ended, "{self:?}");
        let objective = solver.objective();
        bits.extend([objective.data, objective.force, objective.plain].map(f64::to_bits));
        let mut add = |values: &[T]| bits.extend(values.iter().map(|x| x.to_f64().to_bits()));
        for output in solver.outputs() {
            for step in 0..output.count(self.steps) {
                for axis in 0..output.components(S::DIM) {
                    let mut out = vec![T::from_f64(7.0); solver.elements(output, axis)];
                    solver.read(output, step, axis, &mut out);
                    add(&out);
                }
            }
        }
        let mut given = |read: &dyn Fn(&mut [T])| {
            let mut out = vec![T::from_f64(7.0); solver.cells()];
            read(&mut out);
            add(&out);
        };
        if self.steered {
            given(&|out| solver.read_keyframe(1, out));
        }
        if self.asks_for(Feature::Regions) {
            given(&|out| solver.read_region(0, out));
            given(&|out| solver.read_region(1, out));
        }
        if self.asks_for(Feature::Mask) {
            given(&|out| solver.read_mask(out));
        }
        if self.asks_for(Feature::Solids) {
            let [nx, ny] = [0, 1].map(|axis| self.cells[axis]);
            for cell in 0..self.cells.iter().product() {
                let at = [cell % nx, cell / nx % ny, cell / (nx * ny)];
                assert_eq!(solver.is_solid(at), self.is_solid(cell));
            }
        }
        for step in 0..self.steps {
            let mut out = vec![T::from_f64(7.0); solver.cells()];
            solver.emission(exec, step, &mut out);
            add(&out);
        }
        for axis in 0..S::DIM {
            let mut out = vec![T::from_f64(7.0); solver.faces(axis)];
            solver.jet(1, axis, &mut out);
            add(&out);
        }
        bits
    }

    fn ranks_agree<T: Real, S: Space>(&self, counts: &[usize]) {
        let alone = self.bits::<T, S>(&Serial, None);
        assert!(alone.iter().any(|&bits| bits != 0), "{self:?} does nothing");
        for &count in counts {
            let shared = with_ranks(count, |ranks| self.bits::<T, S>(&Serial, Some(ranks)));
            let different = alone
                .iter()
                .zip(&shared[0])
                .filter(|(one, other)| one != other)
                .count();
            assert_eq!(
                (shared[0].len(), different),
                (alone.len(), 0),
                "{count} ranks in {} on {self:?}",
                T::NAME
            );
        }
    }
}

/// What a solver is saved as.
fn saved<T: Real, S: Space>(solver: &mut Solver<'_, T, S>) -> Vec<u8> {
    let mut bytes = vec![0xEE; solver.saved_bytes()];
    solver.save(&mut bytes).unwrap();
    bytes
}

/// The parts of a state.
#[derive(Clone, Debug, Default, PartialEq)]
struct Parted(Vec<Vec<u8>>);

/// States in memory, of which every rank writes its part.
struct Store<'a> {
    ranks: Option<&'a Channels>,
    states: &'a Mutex<Vec<Parted>>,
    /// How many this rank wrote, and the most bytes that it can.
    count: usize,
    room: usize,
    /// The state that is read, and the first of the ranks that wrote it.
    read: Option<(&'a Parted, Share)>,
}

impl<'a> Store<'a> {
    fn new(ranks: Option<&'a Channels>, states: &'a Mutex<Vec<Parted>>) -> Self {
        Self {
            ranks,
            states,
            count: 0,
            room: usize::MAX,
            read: None,
        }
    }
}

struct Bytes(Vec<u8>, usize);

impl Sink for Bytes {
    fn put(&mut self, bytes: &[u8]) -> Result<(), Refused> {
        self.0.extend_from_slice(bytes);
        if self.0.len() <= self.1 {
            Ok(())
        } else {
            Err(Refused)
        }
    }
}

impl PartStore for Store<'_> {
    fn write(&mut self, fill: &mut dyn FnMut(&mut dyn Sink) -> Result<(), Refused>) -> Result<(), Refused> {
        let (rank, count) = self.ranks.map_or((0, 1), |ranks| (ranks.rank(), ranks.count()));
        let mut bytes = Bytes(Vec::new(), self.room);
        let failed = f64::from(u8::from(fill(&mut bytes).is_err()));
        let failed = self.ranks.map_or(failed, |ranks| joined(ranks, failed, f64::max));
        let mut states = self.states.lock().unwrap();
        let new = (self.count + 1).max(states.len());
        states.resize(new, Parted(vec![Vec::new(); count]));
        states[self.count].0[rank] = bytes.0;
        self.count += 1;
        if failed > 0.0 { Err(Refused) } else { Ok(()) }
    }

    fn read(
        &mut self,
        take: &mut dyn FnMut(&mut dyn SavedParts) -> Result<(), SavedError>,
    ) -> Result<(), SavedError> {
        let (parted, share) = self.read.unwrap();
        take(&mut Saved(parted, share))
    }
}

struct Saved<'a>(&'a Parted, Share);

impl SavedParts for Saved<'_> {
    fn share(&self) -> Share {
        self.1
    }

    fn take(&mut self, rank: usize, at: u64, bytes: &mut [u8]) -> Result<(), Refused> {
        let begin = at as usize;
        let part = self
            .0
            .0
            .get(rank)
            .and_then(|part| part.get(begin..begin.saturating_add(bytes.len())));
        bytes.copy_from_slice(part.ok_or(Refused)?);
        Ok(())
    }
}

impl Case {
    /// From the states that one program saves, or some ranks, any other number goes on with the same bits.
    fn goes_on<T: Real, S: Space>(&self, counts: &[usize]) {
        let states = |ranks: Option<&Channels>, states: &Mutex<Vec<Parted>>| {
            let mut store = Store::new(ranks, states);
            self.with_store::<T, S, _>(&Serial, ranks, &mut store, |solver, exec, store| {
                let mut keep = |solver: &mut Solver<'_, T, S>| match ranks {
                    Some(_) => solver.save_parts(store).unwrap(),
                    None => states.lock().unwrap().push(Parted(vec![saved(solver)])),
                };
                self.begin(solver, exec);
                keep(solver);
                while solver.step(exec, &mut Silent).status.is_none() {
                    keep(solver);
                }
            });
        };
        let rest = |case: &Self, state: &Parted, ranks: Option<&Channels>, own: &Mutex<Vec<Parted>>| {
            let mut store = Store::new(ranks, own);
            let share = Share::new(0, state.0.len());
            let blocks = if state.0.len() > 1 { self.beside } else { 1 };
            store.read = Some((state, share.in_blocks(blocks)));
            case.with_store::<T, S, _>(&Serial, ranks, &mut store, |solver, exec, store| {
                self.set_solids(solver);
                solver.restore_parts(store).unwrap();
                if ranks.is_some() {
                    solver.save_parts(store).unwrap();
                } else {
                    let bytes = saved(solver);
                    let is_same = state.0.len() > 1 || bytes == state.0[0];
                    assert!(is_same, "{self:?} is saved as something else");
                    solver.restore(&bytes).unwrap();
                }
                self.rest(solver, exec)
            })
        };
        let in_all = |case: &Self, count: usize, state: &Parted| {
            let own = Mutex::default();
            let found = with_ranks(count, |ranks| {
                rest(case, state, (count > 1).then_some(ranks), &own)
            });
            let own = own.into_inner().unwrap();
            if count > 1 && (count, case.beside) == (state.0.len(), self.beside) {
                assert!(own[0] == *state, "{self:?} has other parts of {count} ranks");
            }
            found.into_iter().next().flatten()
        };
        let of_one = Mutex::default();
        states(None, &of_one);
        let of_one = of_one.into_inner().unwrap();
        for &count in counts {
            let shared = Mutex::default();
            with_ranks(count, |ranks| states(Some(ranks), &shared));
            let shared = shared.into_inner().unwrap();
            assert_eq!(shared.len(), of_one.len());
            for (step, (alone, shared)) in of_one.iter().zip(&shared).enumerate() {
                let expected = in_all(self, 1, alone);
                let slabs = Self { beside: 1, ..*self };
                let others = [
                    (self, shared, 1),
                    (self, alone, count),
                    (self, shared, count),
                    (self, shared, count + self.beside),
                    (&slabs, shared, count),
                ];
                for (case, state, ranks) in others {
                    let found = in_all(case, ranks, state);
                    assert!(
                        found == expected,
                        "{ranks} of {count} ranks from step {step} of {self:?}"
                    );
                }
            }
        }
    }
}

fn simulate() -> Params {
    Params {
        method: Method::Simulate,
        ..Params::default()
    }
}

const QUICK_2D: Case = Case {
    beside: 1,
    steered: false,
    admm: None,
    nested: false,
    cells: &[14, 13],
    ends: &[P, W],
    scheme: Scheme::Quick,
    steps: 4,
    more: &[],
};
const LIMITED_3D: Case = Case {
    beside: 1,
    steered: false,
    admm: None,
    nested: false,
    cells: &[9, 7, 8],
    ends: &[W, P, W],
    scheme: Scheme::Limited,
    steps: 3,
    more: &[],
};

#[test]
fn planes_and_walls() {
    QUICK_2D.ranks_agree::<f64, D2>(&[2, 3, 6]);
    LIMITED_3D.ranks_agree::<f32, D3>(&[2, 3, 4]);
}

/// The search by the direct method on one grid: values, gradients, pairs, and the result.
#[test]
fn steered() {
    let plane = Case {
        steered: true,
        ..QUICK_2D
    };
    plane.ranks_agree::<f64, D2>(&[2, 3]);
    let limited = Case {
        scheme: Scheme::Limited,
        ends: &[W, P],
        ..plane
    };
    limited.ranks_agree::<f32, D2>(&[2, 3]);
    let space = Case {
        steered: true,
        steps: 4,
        ..LIMITED_3D
    };
    space.ranks_agree::<f32, D3>(&[2, 4]);
    let quick = Case {
        scheme: Scheme::Quick,
        ends: &[W, W, P],
        ..space
    };
    quick.ranks_agree::<f64, D3>(&[3]);
}

/// Three grids in 2D, two in 3D: of the coarser ones ranks have parts, or all of each where there are too many of them.
const NESTED_2D: Case = Case {
    beside: 1,
    steered: true,
    admm: None,
    nested: true,
    cells: &[64, 32],
    ends: &[P, W],
    scheme: Scheme::Quick,
    steps: 6,
    more: &[],
};
const NESTED_3D: Case = Case {
    cells: &[16, 16, 16],
    ends: &[W, P, P],
    ..NESTED_2D
};

const RED_BLACK: Admm = Admm {
    colours: Colours::RedBlack,
    relaxation: 1.0,
    penalty: 1e3,
    solver: NsoSolver::Stfas,
};
const PAPERS: Admm = Admm {
    colours: Colours::PowerOfTwo,
    relaxation: 0.7,
    ..RED_BLACK
};

const ALTERNATED: Case = Case {
    steered: true,
    admm: Some(RED_BLACK),
    cells: &[14, 27],
    more: &[Feature::Regions, Feature::Release],
    steps: 5,
    ..QUICK_2D
};

/// ADMM with the spacetime multigrid: of its coarse grids ranks have parts, or all of each.
#[test]
fn alternated() {
    ALTERNATED.ranks_agree::<f64, D2>(&[2, 3, 5]);
    // An odd ring has colours of its own.
    for (ends, cells, counts) in [(&[W, P], &[9, 25], [2, 5]), (&[P, P], &[13, 18], [2, 3])] {
        let ring = Case {
            ends,
            cells,
            admm: Some(PAPERS),
            ..ALTERNATED
        };
        ring.ranks_agree::<f32, D2>(&counts);
    }
    for (ends, cells) in [(&[W, P, W], &[9, 6, 17]), (&[P, W, P], &[6, 7, 15])] {
        let space = Case {
            ends,
            cells,
            steps: 4,
            more: &[],
            ..ALTERNATED
        };
        space.ranks_agree::<f32, D3>(&[2, 3]);
        let papers = Case {
            admm: Some(PAPERS),
            ..space
        };
        papers.ranks_agree::<f64, D3>(&[3]);
    }
    // Where r is so large that the Navier-Stokes problem is damped.
    let damped = Case {
        admm: Some(Admm {
            penalty: 1e-2,
            ..RED_BLACK
        }),
        ..ALTERNATED
    };
    damped.ranks_agree::<f64, D2>(&[3]);
}

/// The same from coarser grids, of which ranks have parts, or all of each and more memory for them.
#[test]
fn alternated_from_coarser_grids() {
    let nested = Case {
        cells: &[32, 48],
        nested: true,
        more: &[],
        steps: 7,
        ..ALTERNATED
    };
    let on_one_grid = Case {
        nested: false,
        ..nested
    };
    let bits = |case: Case| case.bits::<f32, D2>(&Serial, None);
    assert_ne!(bits(nested), bits(on_one_grid));
    nested.ranks_agree::<f32, D2>(&[2, 5, 9]);
    let space = Case {
        cells: &[16, 8, 17],
        ends: &[P, W, W],
        ..nested
    };
    space.ranks_agree::<f64, D3>(&[2, 3]);
}

/// Round solid cells: simulated, steered on one grid and on several, in 2D and 3D.
#[test]
fn among_solids() {
    let plane = Case {
        cells: &[14, 17],
        scheme: Scheme::Limited,
        more: &[Feature::Solids],
        ..QUICK_2D
    };
    plane.ranks_agree::<f64, D2>(&[2, 3]);
    let ring = Case {
        ends: &[W, P],
        ..plane
    };
    ring.ranks_agree::<f32, D2>(&[2, 4]);
    let steered = Case {
        steered: true,
        steps: 6,
        more: &[
            Feature::Solids,
            Feature::Sticking,
            Feature::Mask,
            Feature::Regions,
            Feature::Release,
        ],
        ..plane
    };
    steered.ranks_agree::<f32, D2>(&[3]);
    steered.goes_on::<f64, D2>(&[2]);
    let nested = Case {
        scheme: Scheme::Limited,
        more: &[Feature::Solids],
        ..NESTED_2D
    };
    nested.ranks_agree::<f32, D2>(&[2, 5]);
    let space = Case {
        scheme: Scheme::Limited,
        more: &[Feature::Solids, Feature::Sticking],
        ..NESTED_3D
    };
    space.ranks_agree::<f32, D3>(&[3]);
}

/// The Navier-Stokes problem by Newton's method.
#[test]
fn alternated_by_newton() {
    let newton = Some(Admm {
        solver: NsoSolver::NewtonCg,
        ..RED_BLACK
    });
    let plane = Case {
        admm: newton,
        ..ALTERNATED
    };
    plane.ranks_agree::<f64, D2>(&[2, 3]);
    let open = Case {
        ends: &[OPEN, W],
        scheme: Scheme::Limited,
        more: &[Feature::Solids],
        ..plane
    };
    open.ranks_agree::<f32, D2>(&[2, 5, 9]);
    let space = Case {
        ends: &[W, P, P],
        cells: &[9, 6, 17],
        steps: 4,
        more: &[],
        ..plane
    };
    space.ranks_agree::<f32, D3>(&[3]);
}

const OPEN: Boundary = Boundary::Open;
const LOW: Boundary = Boundary::OpenLow;
const HIGH: Boundary = Boundary::OpenHigh;
const OPEN_2D: Case = Case {
    cells: &[14, 13],
    ends: &[HIGH, W],
    scheme: Scheme::Limited,
    more: &[],
    ..QUICK_2D
};
const OPEN_STEERED: Case = Case {
    steered: true,
    steps: 6,
    more: &[Feature::Solids, Feature::Mask, Feature::Regions, Feature::Release],
    ..OPEN_2D
};
const OPEN_NESTED: Case = Case {
    ends: &[OPEN, W],
    scheme: Scheme::Limited,
    ..NESTED_2D
};
const OPEN_3D: Case = Case {
    ends: &[W, HIGH, P],
    scheme: Scheme::Limited,
    more: &[Feature::Solids, Feature::Mask],
    ..NESTED_3D
};
const OPEN_NEWTON: Case = Case {
    ends: &[W, OPEN],
    scheme: Scheme::Limited,
    more: &[Feature::Solids],
    admm: Some(Admm {
        solver: NsoSolver::NewtonCg,
        ..RED_BLACK
    }),
    ..ALTERNATED
};

/// Some rows of some planes for each rank, two or three of which are beside each other.
const BLOCKS: Case = Case {
    beside: 2,
    cells: &[9, 11, 10],
    ..LIMITED_3D
};
const STEERED_BLOCKS: Case = Case {
    steered: true,
    steps: 5,
    more: &[Feature::Mask, Feature::Regions, Feature::Release],
    ..BLOCKS
};
const NESTED_BLOCKS: Case = Case {
    beside: 2,
    ..NESTED_3D
};

#[test]
fn in_blocks() {
    BLOCKS.ranks_agree::<f32, D3>(&[4, 6]);
    for (ends, scheme, more) in [
        (&[P, W, P], Scheme::Quick, &[Feature::Templates][..]),
        (&[W, P, W], Scheme::SemiLagrangian, &[]),
        (&[W, OPEN, W], Scheme::Limited, &[Feature::Solids]),
        (&[OPEN, LOW, HIGH], Scheme::Limited, &[Feature::Solids]),
    ] {
        let case = Case {
            beside: 3,
            ends,
            scheme,
            more,
            steps: 6,
            ..BLOCKS
        };
        case.ranks_agree::<f64, D3>(&[6]);
    }
}

#[test]
fn steered_in_blocks() {
    STEERED_BLOCKS.ranks_agree::<f32, D3>(&[4, 6]);
    let open = Case {
        ends: &[W, HIGH, OPEN],
        more: &[Feature::Mask, Feature::Solids],
        ..STEERED_BLOCKS
    };
    open.ranks_agree::<f64, D3>(&[6]);
    let traced = Case {
        ends: &[W, P, P],
        scheme: Scheme::SemiLagrangian,
        more: &[],
        ..STEERED_BLOCKS
    };
    traced.ranks_agree::<f64, D3>(&[4]);
    // Of coarser grids ranks have blocks, or all of each where they have too few rows or planes.
    NESTED_BLOCKS.ranks_agree::<f32, D3>(&[4, 8]);
    let flat = Case {
        cells: &[8, 16, 32],
        ends: &[W, HIGH, LOW],
        scheme: Scheme::Limited,
        more: &[Feature::Solids],
        ..NESTED_BLOCKS
    };
    flat.ranks_agree::<f64, D3>(&[4, 6]);
}

#[test]
fn alternated_in_blocks() {
    let stfas = Case {
        beside: 2,
        ends: &[W, P, W],
        cells: &[6, 13, 11],
        steps: 4,
        more: &[],
        ..ALTERNATED
    };
    stfas.ranks_agree::<f32, D3>(&[4]);
    let ring = Case {
        beside: 3,
        ends: &[P, W, P],
        cells: &[5, 15, 10],
        admm: Some(PAPERS),
        ..stfas
    };
    ring.ranks_agree::<f64, D3>(&[6]);
    let nested = Case {
        cells: &[8, 16, 16],
        ends: &[W, P, W],
        nested: true,
        steps: 7,
        ..stfas
    };
    nested.ranks_agree::<f32, D3>(&[4]);
    let newton = Case {
        beside: 2,
        ends: &[W, OPEN, P],
        cells: &[7, 9, 12],
        steps: 4,
        ..OPEN_NEWTON
    };
    newton.ranks_agree::<f64, D3>(&[4]);
    let solids = Case {
        more: &[Feature::Solids],
        scheme: Scheme::Limited,
        cells: &[6, 10, 11],
        ..stfas
    };
    solids.ranks_agree::<f64, D3>(&[4]);
}

#[test]
fn states_in_blocks() {
    STEERED_BLOCKS.goes_on::<f32, D3>(&[4]);
    NESTED_BLOCKS.goes_on::<f64, D3>(&[4]);
}

/// Where columns and rows are transformed together, bricks end with their groups: with groups within a row, or over several; within a plane, or over several.
#[test]
fn long_axes_in_blocks() {
    for cells in [
        &[32, 6, 64],
        &[12, 8, 64],
        &[64, 64, 8],
        &[64, 12, 8],
        &[40, 36, 48],
    ] {
        let case = Case { cells, ..BLOCKS };
        case.ranks_agree::<f32, D3>(&[4, 6]);
    }
    // With more ranks along z than groups along x.
    let deep = Case {
        cells: &[64, 6, 32],
        steps: 3,
        more: &[],
        ..BLOCKS
    };
    deep.ranks_agree::<f32, D3>(&[16]);
}

/// With sides that smoke leaves by, across the planes that ranks share.
#[test]
fn with_open_sides() {
    OPEN_2D.ranks_agree::<f64, D2>(&[2, 3]);
    let solids = Case {
        ends: &[OPEN, P],
        more: &[Feature::Solids],
        ..OPEN_2D
    };
    solids.ranks_agree::<f32, D2>(&[2, 4]);
    OPEN_STEERED.ranks_agree::<f32, D2>(&[3]);
    OPEN_STEERED.goes_on::<f64, D2>(&[2]);
    OPEN_NESTED.ranks_agree::<f64, D2>(&[2, 5]);
    OPEN_3D.ranks_agree::<f32, D3>(&[3]);
}

/// With sides that smoke leaves by at the ends of the axis that ranks cut, whose layers outside are planes of the first and the last rank.
#[test]
fn with_open_ends() {
    for ends in [&[W, OPEN], &[P, LOW], &[OPEN, HIGH]] {
        Case { ends, ..OPEN_2D }.ranks_agree::<f64, D2>(&[2, 3, 6]);
    }
    let steered = Case {
        ends: &[OPEN, OPEN],
        ..OPEN_STEERED
    };
    steered.ranks_agree::<f32, D2>(&[3]);
    steered.goes_on::<f64, D2>(&[2]);
    let nested = Case {
        ends: &[P, HIGH],
        ..OPEN_NESTED
    };
    nested.ranks_agree::<f64, D2>(&[2, 5]);
    // A low layer, which coarser grids have too, shifts no planes from rank to rank.
    for ends in [&[W, LOW], &[P, OPEN]] {
        Case { ends, ..OPEN_NESTED }.ranks_agree::<f32, D2>(&[3, 4, 5, 6]);
    }
    let space = Case {
        ends: &[W, HIGH, OPEN],
        ..OPEN_3D
    };
    space.ranks_agree::<f32, D3>(&[3]);
    OPEN_NEWTON.ranks_agree::<f32, D2>(&[2, 4]);
    let blown = Case {
        more: &[Feature::Templates],
        ends: &[W, LOW],
        ..OPEN_2D
    };
    blown.ranks_agree::<f64, D2>(&[2, 3]);
}

/// By Newton's method from coarser grids, on an axis that does not halve: as the ends open, and where none does.
#[test]
fn alternated_by_newton_from_coarser_grids() {
    for ends in [&[W, OPEN], &[W, LOW], &[W, W]] {
        let nested = Case {
            cells: &[16, 35],
            nested: true,
            steps: 7,
            ends,
            more: &[],
            ..OPEN_NEWTON
        };
        let on_one_grid = Case {
            nested: false,
            ..nested
        };
        let bits = |case: Case| case.bits::<f64, D2>(&Serial, None);
        assert_ne!(bits(nested), bits(on_one_grid));
        nested.ranks_agree::<f64, D2>(&[2, 3, 5, 7]);
    }
}

#[test]
fn alternated_among_solids() {
    let solids = Case {
        more: &[Feature::Solids],
        scheme: Scheme::Limited,
        ..ALTERNATED
    };
    solids.ranks_agree::<f64, D2>(&[2, 3]);
    let nested = Case {
        cells: &[32, 48],
        nested: true,
        steps: 7,
        ..solids
    };
    nested.ranks_agree::<f32, D2>(&[3, 9]);
    let space = Case {
        cells: &[9, 6, 17],
        ends: &[W, P, W],
        steps: 4,
        admm: Some(PAPERS),
        ..solids
    };
    space.ranks_agree::<f32, D3>(&[2, 3]);
}

#[test]
fn states_of_an_alternation() {
    ALTERNATED.goes_on::<f32, D2>(&[3]);
}

#[test]
fn nested() {
    let levels = NESTED_2D
        .with::<f64, D2, _>(&Serial, None, |solver, exec| {
            NESTED_2D.begin(solver, exec);
            solver.step(exec, &mut Silent).level
        })
        .unwrap();
    assert_eq!(levels, 2);
    NESTED_2D.ranks_agree::<f64, D2>(&[2, 3, 5, 9]);
    let ring = Case {
        ends: &[W, P],
        steps: 7,
        ..NESTED_2D
    };
    ring.ranks_agree::<f32, D2>(&[3, 6, 15]);
    NESTED_3D.ranks_agree::<f32, D3>(&[2, 3, 5]);
}

/// Force here and there alone, parts of keyframes, and a flow that is let go, on one grid and on several.
#[test]
fn masks_regions_and_release() {
    let all = &[Feature::Mask, Feature::Regions, Feature::Release];
    let plane = Case {
        steered: true,
        scheme: Scheme::Limited,
        steps: 6,
        more: all,
        ..QUICK_2D
    };
    plane.ranks_agree::<f64, D2>(&[2, 3]);
    plane.goes_on::<f32, D2>(&[2]);
    let space = Case {
        steered: true,
        steps: 5,
        ends: &[W, W, P],
        more: all,
        ..LIMITED_3D
    };
    space.ranks_agree::<f32, D3>(&[2, 4]);
    for more in [all, &all[..1], &all[1..2], &all[2..]] {
        let nested = Case {
            steps: 8,
            more,
            ..NESTED_2D
        };
        nested.ranks_agree::<f32, D2>(&[3, 9]);
    }
}

#[test]
fn blown_by_templates() {
    let plane = Case {
        more: &[Feature::Templates],
        ..QUICK_2D
    };
    plane.ranks_agree::<f64, D2>(&[2, 5]);
    let ring = Case {
        ends: &[W, P],
        ..plane
    };
    ring.ranks_agree::<f32, D2>(&[3]);
    for ends in [&[W, P, W], &[W, W, P]] {
        let space = Case {
            steps: 4,
            ends,
            more: &[Feature::Templates],
            ..LIMITED_3D
        };
        space.ranks_agree::<f64, D3>(&[2, 4]);
    }
}

#[test]
fn states_on_coarser_grids() {
    NESTED_2D.goes_on::<f32, D2>(&[5]);
    NESTED_3D.goes_on::<f32, D3>(&[3]);
}

#[test]
fn states_of_any_number_of_ranks() {
    let plane = Case {
        steered: true,
        ..QUICK_2D
    };
    plane.goes_on::<f64, D2>(&[2, 4]);
    let space = Case {
        steered: true,
        steps: 4,
        ends: &[W, P, P],
        ..LIMITED_3D
    };
    space.goes_on::<f32, D3>(&[2, 3]);
    QUICK_2D.goes_on::<f32, D2>(&[3]);
}

/// A part that cannot be written or read ends nothing but the pass: all ranks know it, and go on.
#[test]
fn a_state_that_cannot_be_kept_or_read_ends_no_rank() {
    let case = Case {
        steered: true,
        ..QUICK_2D
    };
    let alone = case.bits::<f64, D2>(&Serial, None);
    let states = Mutex::default();
    let found = with_ranks(3, |ranks| {
        let mut store = Store::new(Some(ranks), &states);
        // The second one has no room.
        store.room = if ranks.rank() == 1 { 500 } else { usize::MAX };
        case.with_store::<f64, D2, _>(&Serial, Some(ranks), &mut store, |solver, exec, store| {
            let mut bits = case.begin(solver, exec);
            assert_eq!(solver.save_parts(store), Err(Refused));
            let mut alone = vec![0; solver.saved_bytes()];
            assert_eq!(
                solver.save(&mut alone),
                Err(SavedError::Refused),
                "a part is no state"
            );
            bits.extend(case.rest(solver, exec));
            bits
        })
    });
    assert!(found[0].as_ref() == Some(&alone));
    // The part of one rank ends early: no rank goes on with the rest.
    let states = Mutex::default();
    with_ranks(3, |ranks| {
        let mut store = Store::new(Some(ranks), &states);
        case.with_store::<f64, D2, _>(&Serial, Some(ranks), &mut store, |solver, exec, store| {
            case.begin(solver, exec);
            solver.save_parts(store).unwrap();
        })
    });
    let whole = states.into_inner().unwrap().swap_remove(0);
    for rank in 0..3 {
        let mut short = whole.clone();
        let half = short.0[rank].len() / 2;
        short.0[rank].truncate(half);
        let unread = Mutex::default();
        with_ranks(2, |ranks| {
            let mut store = Store::new(Some(ranks), &unread);
            store.read = Some((&short, Share::new(0, 3)));
            case.with_store::<f64, D2, _>(&Serial, Some(ranks), &mut store, |solver, exec, store| {
                case.set_solids(solver);
                assert_eq!(solver.restore_parts(store), Err(SavedError::Refused));
                // Half of it is another state now.
                assert_eq!(solver.step(exec, &mut Silent).status, Some(Status::NotReady));
            })
        });
    }
}

/// Parts that somebody else made, or changed, are refused or taken for numbers: nothing else comes of them.
#[test]
fn parts_of_any_bytes_do_no_harm() {
    let case = Case {
        steered: true,
        ..QUICK_2D
    };
    let states = Mutex::default();
    with_ranks(2, |ranks| {
        let mut store = Store::new(Some(ranks), &states);
        case.with_store::<f32, D2, _>(&Serial, Some(ranks), &mut store, |solver, exec, store| {
            case.begin(solver, exec);
            solver.save_parts(store).unwrap();
        })
    });
    let whole = states.into_inner().unwrap().swap_remove(0);
    // What says how the first field is cut: its planes, its rows, its layers.
    let cut = HEAD..HEAD + 24;
    let words = whole.0[0][cut.clone()].as_chunks::<8>().0;
    assert_eq!(words.iter().map(|word| word[0]).collect::<Vec<_>>(), [13, 0, 0]);
    let mut ended = [0; 2];
    for (byte, value) in cut.flat_map(|byte| [1, 2, 7, 128, 255].map(|value| (byte, value))) {
        for (ranks, beside) in [(2, 1), (2, 2), (1 << 20, 1 << 10)] {
            let mut changed = whole.clone();
            changed.0[0][byte] ^= value;
            changed.0.resize(ranks.min(4), whole.0[1].clone());
            let unread = Mutex::default();
            let mut store = Store::new(None, &unread);
            store.read = Some((&changed, Share::new(0, ranks).in_blocks(beside)));
            case.with_store::<f32, D2, _>(&Serial, None, &mut store, |solver, _, store| {
                case.set_solids(solver);
                ended[usize::from(solver.restore_parts(store).is_ok())] += 1;
            });
        }
    }
    assert!(ended[0] > 100, "{ended:?}");
}

/// What a window leaves to the next: a density, the flow that the search begins with, and what of the objective is of its first steps.
fn goes_on_from_a_window<T: Real, S: Space>(case: &Case, counts: &[usize]) {
    let work = |solver: &mut Solver<'_, T, S>, exec: &dyn Exec| {
        case.set(solver);
        // Below 0 where transport undershoots, and in two blobs.
        let blobs = case
            .blob::<T>([0.3, 0.4, 0.5])
            .into_iter()
            .zip(case.blob([0.7, 0.5, 0.4]));
        let left: Vec<T> = blobs.map(|(a, b)| a + b - T::from_f64(0.01)).collect();
        solver.go_on_from(&left).unwrap();
        let mut bits = Vec::new();
        for index in 0..2 {
            let factor = solver.set_keyframe(index, &case.blob([0.6, 0.6, 0.4]));
            bits.push(factor.unwrap().to_bits());
        }
        for step in 1..case.steps {
            for axis in 0..S::DIM {
                let wave = |face: usize| T::from_f64(0.03 * (0.29 * (face + 7 * step + axis) as f64).sin());
                let faces: Vec<T> = (0..solver.faces(axis)).map(wave).collect();
                solver.give_velocity(step, axis, &faces).unwrap();
            }
        }
        assert!(solver.begin_at_given(exec).unwrap());
        bits.extend(case.rest(solver, exec));
        for (last, forces) in [(4, 3), (3, 2), (2, 1)] {
            let of = solver.objective_of(exec, last, forces);
            bits.extend([of.data, of.force, of.plain].map(f64::to_bits));
        }
        bits
    };
    let alone = case.with(&Serial, None, work);
    for &count in counts {
        let shared = with_ranks(count, |ranks| case.with(&Serial, Some(ranks), work));
        assert!(shared[0] == alone, "{count} ranks in {} on {case:?}", T::NAME);
    }
}

#[test]
fn what_a_window_left() {
    let plane = Case {
        steered: true,
        ..QUICK_2D
    };
    goes_on_from_a_window::<f64, D2>(&plane, &[2, 3]);
    let open = Case {
        ends: &[W, OPEN],
        scheme: Scheme::Limited,
        more: &[Feature::Solids],
        ..plane
    };
    goes_on_from_a_window::<f32, D2>(&open, &[2, 4]);
    let space = Case {
        steered: true,
        steps: 4,
        ..LIMITED_3D
    };
    goes_on_from_a_window::<f32, D3>(&space, &[2, 3]);
}

#[test]
fn rings() {
    let limited = Case {
        ends: &[W, P],
        scheme: Scheme::Limited,
        ..QUICK_2D
    };
    limited.ranks_agree::<f32, D2>(&[2, 3]);
    let quick = Case {
        ends: &[P, W, P],
        scheme: Scheme::Quick,
        ..LIMITED_3D
    };
    quick.ranks_agree::<f64, D3>(&[2, 3]);
}

#[test]
fn other_schemes() {
    for (scheme, ends) in [
        (Scheme::Central, &[W, W]),
        (Scheme::SemiLagrangian, &[W, W]),
        (Scheme::SemiLagrangian, &[P, P]),
    ] {
        let simulated = Case {
            scheme,
            ends,
            ..QUICK_2D
        };
        simulated.ranks_agree::<f64, D2>(&[2, 3]);
        // What comes from behind the seam of a ring counts for the gradient too.
        let steered = Case {
            steered: true,
            steps: 5,
            ..simulated
        };
        steered.ranks_agree::<f64, D2>(&[2, 3]);
    }
}

/// Axes with a fast transform, whose columns and rows are transformed together.
#[test]
fn long_axes() {
    let tall = Case {
        cells: &[5, 300],
        ends: &[W, W],
        steps: 3,
        ..QUICK_2D
    };
    tall.ranks_agree::<f64, D2>(&[2, 3]);
    let wide = Case {
        cells: &[270, 9],
        ends: &[P, W],
        steps: 3,
        ..QUICK_2D
    };
    wide.ranks_agree::<f32, D2>(&[2, 4]);
    let deep = Case {
        cells: &[270, 5, 6],
        steps: 3,
        ..LIMITED_3D
    };
    deep.ranks_agree::<f32, D3>(&[3]);
}

/// What a rank's own planes of a grid are made of it has of the next one, with the weights of one program; and what it collects residuals from is not the
/// lowest of what it has, whose residuals would read further.
#[test]
fn a_rank_has_what_its_planes_are_made_of() {
    let ends = [W, P, OPEN, LOW, HIGH];
    for (n, end) in (4..64)
        .chain([97, 127, 130])
        .flat_map(|n| ends.map(|end| (n, end)))
    {
        // Transport's reach is enough where an axis halves, and a nested start's wherever nothing is collected.
        for (ranks, reach) in [2, 3, 4, 5, 7]
            .into_iter()
            .flat_map(|ranks| [2, coarse::REACH, transfer::REACH].map(|reach| (ranks, reach)))
        {
            let whole = Grid::new(&[3, n], &[W, end]);
            for rank in (0..ranks).filter(|_| n >= reach * ranks) {
                let share = Share {
                    reach,
                    ..Share::new(rank, ranks)
                };
                let [own, all] = [whole.shared(Some(share)), whole].map(|grid| levels::hierarchy(&grid));
                let pairs = own.windows(2).zip(all.windows(2));
                for (own, all) in pairs.filter(|(own, _)| own[0].is_part()) {
                    let halves = all[0].inside()[1].len() == 2 * all[1].inside()[1].len();
                    if halves || reach > 2 {
                        same_taps(own, all, reach == transfer::REACH);
                    }
                }
            }
        }
    }
}

fn same_taps(own: &[Grid], all: &[Grid], collects: bool) {
    let lens = [own, all].map(|pair| Tables::<f64>::len(&pair[0], &pair[1]));
    let [(mut i, mut x), (mut j, mut y)] = lens.map(|len| (vec![0; len], vec![0.0; len]));
    let here = Tables::new(&own[0], &own[1], &mut i, &mut x);
    let everywhere = Tables::new(&all[0], &all[1], &mut j, &mut y);
    for transfer in TRANSFERS {
        let to_finer = matches!(transfer, Transfer::ProlongCell | Transfer::ProlongFace);
        let (from, to) = if to_finer {
            (own[1], own[0])
        } else {
            (own[0], own[1])
        };
        let is_collected = matches!(transfer, Transfer::CollectCell | Transfer::CollectFace);
        if is_collected && !collects {
            continue;
        }
        let is_of_faces = matches!(transfer, Transfer::RestrictFace | Transfer::ProlongFace);
        for plane in made_here(&from, &to) {
            let found: Vec<(usize, f64)> = here.taps(1, transfer, plane).collect();
            // On the lowest faces of copies stands 0.
            let untold = if is_collected { 2 } else { usize::from(is_of_faces) };
            let has_below = from.own_planes().start > 0;
            assert!(
                !has_below || found.iter().all(|&(plane, _)| plane >= untold),
                "{transfer:?} {plane} of {own:?}"
            );
            let in_whole = found
                .iter()
                .map(|&(plane, weight)| (from.in_whole(1, plane), weight));
            let expected = everywhere.taps(1, transfer, to.in_whole(1, plane));
            assert!(in_whole.eq(expected), "{transfer:?} {plane} of {own:?}");
        }
    }
}

/// Each rank holds its slab alone, and the plan says it to the byte.
#[test]
fn a_rank_plans_what_it_holds() {
    let case = Case {
        cells: &[16, 16, 64],
        ..LIMITED_3D
    };
    let bytes = |share| {
        Plan::new::<f32, D3>(&case.problem(share), &simulate())
            .unwrap()
            .bytes()
    };
    let alone = bytes(None);
    for (ranks, beside) in [(2, 1), (4, 1), (8, 1), (8, 2)] {
        for rank in 0..ranks {
            let share = Share::new(rank, ranks).in_blocks(beside);
            let own = bytes(Some(share));
            // What does not shrink: copies of four planes and rows, the tables of the axes.
            let planes = 64 * beside / ranks + 4;
            let rows = if beside > 1 { 16 / beside + 4 } else { 16 };
            let most = alone * planes / 64 * rows / 16 + (200 << 10);
            assert!(own <= most, "rank {rank} of {ranks}: {own} bytes, {alone} alone");
            let problem = case.problem(Some(share));
            let mut memory = Memory::new(own - 1);
            assert!(Solver::<f32, D3>::new(&problem, &simulate(), memory.block()).is_err());
        }
    }
}

#[test]
fn what_ranks_cannot_share_is_refused() {
    let share = Some(Share::new(0, 4));
    let refused = |problem: &Problem<'_>, params: Params| Plan::new::<f32, D2>(problem, &params).unwrap_err();
    let thin = Case {
        cells: &[16, 7],
        ..QUICK_2D
    };
    assert_eq!(
        refused(&thin.problem(share), simulate()),
        PlanError::Problem(ProblemError::Share(ShareError::Thin {
            ranks: 4,
            planes: 7,
            least: 2
        }))
    );
    let admm = Params {
        method: Method::Admm,
        ..simulate()
    };
    let keyframe = Problem {
        keyframes: &[2],
        emitters: &[],
        ..QUICK_2D.problem(share)
    };
    assert_eq!(
        refused(&keyframe, admm),
        PlanError::Problem(ProblemError::Share(ShareError::Thin {
            ranks: 4,
            planes: 13,
            least: transfer::REACH
        }))
    );
    for (rank, ranks) in [(4, 4), (1, 1), (0, 0)] {
        let share = Share::new(rank, ranks);
        let error = refused(&QUICK_2D.problem(Some(share)), simulate());
        assert_eq!(
            error,
            PlanError::Problem(ProblemError::Share(ShareError::Rank { rank, ranks }))
        );
        assert!(error.to_string().contains("count from 0"), "{error}");
    }
    let flat = QUICK_2D.problem(Some(Share::new(0, 4).in_blocks(2)));
    assert!(refused(&flat, simulate()).to_string().contains("two axes"));
    for (beside, ranks, expected) in [
        (3, 4, "3 beside each other"),
        (4, 4, "smaller"),
        (0, 4, "0 beside each other"),
        (6, 12, "11 rows of cells; each needs at least 2, so put 5"),
        (2, 12, "6 ranks one behind the other share 10 planes"),
    ] {
        let problem = BLOCKS.problem(Some(Share::new(0, ranks).in_blocks(beside)));
        let error = Plan::new::<f32, D3>(&problem, &simulate()).unwrap_err();
        assert!(error.to_string().contains(expected), "{error}");
    }
    for method in [Method::Lbfgs, Method::Pd] {
        let params = Params { method, ..simulate() };
        let error = refused(&keyframe, params).to_string();
        let expected = format!("{} cannot be shared by ranks", method.name());
        assert!(error.contains(&expected), "{error}");
    }
}

#[test]
fn ranks_hear_each_other() {
    for count in 1..=5 {
        let found = with_ranks(count, |ranks| {
            let own = ranks.rank() as f64;
            let mut told = [own; 3];
            tell(ranks, count / 2, &mut told);
            let mut sum = [0.1];
            in_order(ranks, &mut sum, |sum| sum[0] = 3.0 * sum[0] + own);
            tell(ranks, count - 1, &mut sum);
            let most = joined(ranks, own, f64::max);
            let mut other = [0u32];
            let next = (ranks.rank() + 1) % count;
            let before = (ranks.rank() + count - 1) % count;
            if count > 1 {
                swap(
                    ranks,
                    Some(next),
                    &[ranks.rank() as u32],
                    Some(before),
                    &mut other,
                );
                assert_eq!(other, [before as u32]);
            }
            (told, sum[0], most)
        });
        let sum = (0..count).fold(0.1, |sum, rank| 3.0 * sum + rank as f64);
        for found in found {
            assert_eq!(found, ([(count / 2) as f64; 3], sum, count as f64 - 1.0));
        }
    }
}

/// Every copy is what its owner has, on a ring too, and in blocks, in their corners too.
#[test]
fn copies_are_refreshed() {
    for ends in [W, P] {
        for (count, beside) in [(2, 1), (3, 1), (4, 1), (4, 2), (6, 3), (6, 2)] {
            let cells: &[usize] = if beside == 1 { &[3, 9] } else { &[3, 8, 9] };
            let messages = with_ranks(count, |ranks| {
                let share = Share::new(ranks.rank(), count).in_blocks(beside);
                let whole = Grid::new(cells, &[W, ends, ends]);
                let grid = whole.shared(Some(share));
                let value = |row: usize, x: usize| {
                    let [y, z] = grid.row_at(row);
                    (x + 10 * grid.in_whole(1, y) + 100 * grid.in_whole(2, z)) as f64
                };
                let mut field = vec![-1.0; grid.cells()];
                for row in (0..grid.rows()).filter(|&row| grid.is_own(row)) {
                    (0..3).for_each(|x| field[3 * row + x] = value(row, x));
                }
                refresh(&Together::new(&Serial, ranks), &grid, &mut field);
                for row in 0..grid.rows() {
                    (0..3).for_each(|x| assert_eq!(field[3 * row + x], value(row, x), "row {row}"));
                }
                ranks.sent.each_ref().map(|sent| sent.load(Ordering::Relaxed))
            });
            let sides = |count: usize| if ends == P { 2 * count } else { 2 * (count - 1) };
            let (high, [sent, bytes]) = (count / beside, sum_of(&messages));
            if beside == 1 {
                assert_eq!([sent, bytes], [sides(count), sides(count) * 2 * 3 * 8]);
            } else {
                assert_eq!(sent, beside * sides(high) + high * sides(beside));
            }
        }
    }
}

fn sum_of(messages: &[[usize; 2]]) -> [usize; 2] {
    messages
        .iter()
        .fold([0; 2], |sum, own| [sum[0] + own[0], sum[1] + own[1]])
}

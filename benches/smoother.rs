//! One sweep of the time-line smoother in f32, red-black and the paper's 2^d colours.

mod common;

use common::{pool, size};
use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use thurible_bench::flow;
use thurible_core::field::VectorMut;
use thurible_core::grid::Grid;
use thurible_core::nso::damping::LocalDamping;
use thurible_core::nso::level::{Coefficients, LevelMut, State};
use thurible_core::nso::surroundings::Surroundings;
use thurible_core::nso::{SmootherMemory, local, smoother};
use thurible_core::{Boundary, Colours, D2, D3, Exec, Space};

/// Slots of the trajectories.
const SLOTS: usize = 39;

fn sweeps(criterion: &mut Criterion) {
    let exec = pool();
    of_box::<D2>(criterion, exec, &[128, 128]);
    of_box::<D3>(criterion, exec, &[32, 32, 32]);
}

fn of_box<S: Space>(criterion: &mut Criterion, exec: &dyn Exec, cells: &[usize]) {
    let grid = Grid::new(cells, &vec![Boundary::Wall; cells.len()]);
    let len = grid.cells() * SLOTS;
    let [mut v, mut a] = [0; 2].map(|_| flow::synthetic::<f32, S>(&grid, SLOTS, 1.0));
    let mut w: [Vec<f32>; 3] = core::array::from_fn(|axis| vec![0.0; v[axis].len()]);
    let mut v0: [Vec<f32>; 3] = core::array::from_fn(|axis| vec![0.0; v[axis].len() / SLOTS]);
    let [mut p, mut pbar] = [0; 2].map(|_| vec![0f32; len]);
    let mut table = vec![0f32; local::table_len::<S>()];
    local::fill_table::<f32, S>(grid.h, false, &mut table);
    let mut level = LevelMut {
        grid: &grid,
        solids: Default::default(),
        state: State {
            v: writable(&mut v),
            w: writable(&mut w),
            p: &mut p,
            pbar: &mut pbar,
        },
        v0: writable(&mut v0),
        a: writable(&mut a),
        scale: 1.0,
        b: &mut [],
        c: Default::default(),
        d: &mut [],
        table: &table,
    };
    let coefficients = Coefficients {
        slots: SLOTS,
        kappa: 1.0,
        viscosity: 0.0,
        surroundings: Surroundings::WITH_MASS.to(),
        damping: LocalDamping::USUAL.at(1.0),
    };
    let memory = SmootherMemory::all::<f32, S>(&grid)
        .next()
        .unwrap_or(SmootherMemory::LEAST);
    let mut waiting = vec![0f32; smoother::waiting_len::<S>(&grid, SLOTS, exec.threads(), memory.split)];
    let mut scratch = vec![0f32; exec.threads() * smoother::scratch_len::<S>(&grid, SLOTS, memory)];
    let mut group = criterion.benchmark_group(format!("smoother {}, {SLOTS} slots", size(cells)));
    group.sample_size(10).throughput(Throughput::Elements(len as u64));
    for colours in [Colours::RedBlack, Colours::PowerOfTwo] {
        group.bench_function(format!("sweep, {colours:?}"), |bencher| {
            let mut workspace = smoother::Workspace {
                waiting: &mut waiting,
                scratch: &mut scratch,
                memory,
            };
            bencher
                .iter(|| smoother::sweep::<f32, S>(exec, &mut level, &coefficients, colours, &mut workspace));
        });
    }
    group.finish();
}

fn writable(field: &mut [Vec<f32>; 3]) -> VectorMut<'_, f32> {
    field.each_mut().map(|component| &mut component[..])
}

criterion_group!(benches, sweeps);
criterion_main!(benches);

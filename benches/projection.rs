//! The projection of a trajectory onto flows without divergence, f32, to the default tolerance.

mod common;

use common::{size, sure, team};
use criterion::{BatchSize, Criterion, Throughput, criterion_group, criterion_main};
use thurible::bench::pieces::Trajectories;
use thurible_core::{D2, D3, Exec, Silent, Space};

/// Slots of the trajectories.
const SLOTS: usize = 19;
/// Relative tolerance.
const TOLERANCE: f64 = 1e-5;

fn projection(criterion: &mut Criterion) {
    let exec = team();
    of_box::<D2>(criterion, exec, &[128, 128]);
    of_box::<D2>(criterion, exec, &[96, 60]);
    of_box::<D3>(criterion, exec, &[32, 32, 32]);
}

fn of_box<S: Space>(criterion: &mut Criterion, exec: &dyn Exec, cells: &[usize]) {
<<<<<<< HEAD
    let grid = Grid::new(cells, &vec![Boundary::Wall; cells.len()]);
    let mut ledger = Ledger::new();
    Levels::<f32>::requirement(&mut ledger, &grid);
    let Some(mut region) = ledger.bytes().and_then(Region::new) else { return };
    let Some(block) = region.carve(ledger.bytes().unwrap_or(0)) else { return };
    let Ok(levels) = Levels::<f32>::carve(&mut Arena::new(block), &grid) else { return };
    let mut ledger = Ledger::new();
    Projection::<f32>::requirement(&mut ledger, &grid, SLOTS, exec.threads());
    let mut memory = vec![0f32; ledger.bytes().unwrap_or(0) / size_of::<f32>()];
    let mut projection = Projection::carve(&levels, 0, SLOTS, exec.threads(), &mut Pool::new(&mut memory));
    let mut sums = vec![0.0; grid.rows()];
    let start = divergent::<S>(&grid);
=======
    let all = Trajectories::new(cells, SLOTS);
>>>>>>> bench
    let mut group = criterion.benchmark_group(format!("projection {}, {SLOTS} slots", size(cells)));
    group.sample_size(10).throughput(Throughput::Elements((all.grid.cells() * SLOTS) as u64));
    sure(all.projection::<S, _>(exec, |projection, start, sums| {
        group.bench_function("to 1e-5", |bencher| {
            bencher.iter_batched_ref(
                || start.clone(),
                |v| {
                    let mut v = v.each_mut().map(|component| &mut component[..]);
                    projection.project(exec, &mut Silent, SLOTS, &mut v, None, TOLERANCE, sums)
                },
                BatchSize::LargeInput,
            );
        });
    }));
    group.finish();
}

criterion_group!(benches, projection);
criterion_main!(benches);

//! The projection of a trajectory onto flows without divergence, f32, to the default tolerance, and the divergence of all its slots.

mod common;

use common::{pool, size, sure};
use criterion::{BatchSize, Criterion, Throughput, criterion_group, criterion_main};
use thurible_bench::pieces::Trajectories;
use thurible_core::{D2, D3, Exec, Silent, Space};

/// Relative tolerance of every projection.
const TOLERANCE: f64 = 1e-5;

fn projection(criterion: &mut Criterion) {
    let exec = pool();
    of_box::<D2>(criterion, exec, (&[128, 128], 19));
    of_box::<D2>(criterion, exec, (&[96, 60], 19));
    of_box::<D2>(criterion, exec, (&[256, 256], 19));
    of_box::<D3>(criterion, exec, (&[32, 32, 32], 19));
    of_box::<D3>(criterion, exec, (&[64, 64, 64], 19));
    // As tracking has them: one flow at a time.
    of_box::<D2>(criterion, exec, (&[128, 256], 1));
    of_box::<D3>(criterion, exec, (&[100, 200, 100], 1));
}

fn of_box<S: Space>(criterion: &mut Criterion, exec: &dyn Exec, (cells, slots): (&[usize], usize)) {
    let all = Trajectories::new(cells, slots);
    let mut group = criterion.benchmark_group(format!("projection {}, {slots} slots", size(cells)));
    group
        .sample_size(10)
        .throughput(Throughput::Elements((all.grid.cells() * slots) as u64));
    sure(all.projection::<S, _>(exec, |projection, start, sums| {
        let mut v = start.clone();
        let v = v.each_mut().map(|component| &mut component[..]);
        group.bench_function("divergence", |bencher| {
            bencher.iter(|| projection.relative_divergence(exec, &v, sums))
        });
        group.bench_function("to 1e-5", |bencher| {
            bencher.iter_batched_ref(
                || start.clone(),
                |v| {
                    let mut v = v.each_mut().map(|component| &mut component[..]);
                    projection.project(exec, &mut Silent, &mut v, None, TOLERANCE, sums)
                },
                BatchSize::LargeInput,
            );
        });
    }));
    group.finish();
}

criterion_group!(benches, projection);
criterion_main!(benches);

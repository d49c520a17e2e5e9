//! One step of density transport in f32, forward and backward, at Courant number 1, and the velocities of all steps taken out of a trajectory.

mod common;

use common::{pool, size};
use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use thurible_bench::pieces::Trajectories;
use thurible_core::{D2, D3, Exec, Named, Scheme, Space};

fn transport(criterion: &mut Criterion) {
    let exec = pool();
    for &scheme in Scheme::ALL {
        of_box::<D2>(criterion, exec, &[128, 128], scheme);
        of_box::<D3>(criterion, exec, &[64, 64, 64], scheme);
    }
    velocities::<D2>(criterion, exec, &[128, 128], 39);
    velocities::<D3>(criterion, exec, &[64, 64, 64], 59);
}

/// Steps of a trajectory are far apart in memory, so all are loaded in turn.
fn velocities<S: Space>(criterion: &mut Criterion, exec: &dyn Exec, cells: &[usize], slots: usize) {
    let all = Trajectories::new(cells, slots);
    all.transport::<S, _>(exec, Scheme::Quick, |transport, carried| {
        let mut group = criterion.benchmark_group(format!("velocities {}, {slots} slots", size(cells)));
        group
            .sample_size(10)
            .throughput(Throughput::Elements((all.grid.cells() * slots) as u64));
        group.bench_function("load", |bencher| {
            bencher.iter(|| {
                (1..=slots)
                    .try_for_each(|step| transport.load(exec, &carried.flow, slots, step, carried.sums))
            });
        });
        group.finish();
    });
}

fn of_box<S: Space>(criterion: &mut Criterion, exec: &dyn Exec, cells: &[usize], scheme: Scheme) {
    let all = Trajectories::new(cells, 1);
    let len = all.grid.cells();
    all.transport::<S, _>(exec, scheme, |transport, carried| {
        assert!(
            transport.load(exec, &carried.flow, 1, 1, carried.sums).is_ok(),
            "the flow is too fast"
        );
        let (source, rest) = carried.rho.split_at_mut(len);
        let (out, mu) = (&mut rest[..len], &mut vec![0f32; len]);
        let mut group = criterion.benchmark_group(format!("transport {}, {scheme:?}", size(cells)));
        group.sample_size(10).throughput(Throughput::Elements(len as u64));
        group.bench_function("forward", |bencher| {
            bencher.iter(|| transport.forward(exec, source, out))
        });
        group.bench_function("backward", |bencher| {
            bencher.iter(|| {
                mu.copy_from_slice(source);
                transport.backward(exec, source, mu);
            });
        });
        group.finish();
    });
}

criterion_group!(benches, transport);
criterion_main!(benches);

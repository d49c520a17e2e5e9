//! Outer iterations of ADMM, from the second on, on `examples/letter_f.toml` in f32.

mod common;

use common::exec::THREADS;
use common::scene::Ready;
use common::team;
use core::time::Duration;
use criterion::{Criterion, criterion_group, criterion_main};
use thurible_core::{D2, Silent};

fn admm(criterion: &mut Criterion) {
    let exec = team();
    let ready = Ready::example("letter_f", &[], THREADS);
    let mut group = criterion.benchmark_group("admm letter_f 128x128, 40 steps");
    group.sample_size(10).warm_up_time(Duration::from_millis(1)).measurement_time(Duration::from_secs(20));
    group.bench_function("iterations 2 to 11", |bencher| {
        ready.with::<f32, D2, _>(exec, |solver| {
            solver.step(exec, &mut Silent);
            bencher.iter(|| solver.step(exec, &mut Silent).iteration);
        });
    });
    group.finish();
}

criterion_group!(benches, admm);
criterion_main!(benches);

//! Outer iterations of each method on `examples/letter_f.toml` in f32; PD's one pass on fewer cells.

mod common;

use common::exec::THREADS;
use common::{pool, size, sure};
use core::time::Duration;
use criterion::{Criterion, criterion_group, criterion_main};
use thurible_bench::scenes::letter_f;
use thurible_core::{D2, Silent};

fn methods(criterion: &mut Criterion) {
    let exec = pool();
    for (method, sets) in [
        ("direct", &["method.direct.nested=false"][..]),
        ("admm", &[]),
        ("lbfgs", &[]),
        (
            "pd",
            &["grid.cells=[64,64]", "time.steps=20", "keyframe[0].step=20"],
        ),
    ] {
        let sets: Vec<String> = sets.iter().map(|&set| set.into()).collect();
        let ready = sure(letter_f(&sets, method, THREADS));
        let problem = ready.problem();
        let mut group = criterion.benchmark_group(format!(
            "{method}, letter_f {}, {} steps",
            size(problem.cells),
            problem.steps
        ));
        group
            .sample_size(10)
            .warm_up_time(Duration::from_millis(1))
            .measurement_time(Duration::from_secs(10));
        group.bench_function("an iteration", |bencher| {
            sure(ready.with::<f32, D2, _>(exec, |solver| {
                if method != "pd" {
                    solver.step(exec, &mut Silent);
                }
                bencher.iter(|| solver.step(exec, &mut Silent).iteration);
            }));
        });
        group.finish();
    }
}

criterion_group!(benches, methods);
criterion_main!(benches);

//! One step of density transport in f32, forward and backward, at Courant number 1.

mod common;

use common::{flow, size, team};
use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use thurible_core::grid::Grid;
use thurible_core::plan::{Ledger, Pool};
use thurible_core::transport::{Flow, Transport};
use thurible_core::{Boundary, D2, D3, Exec, Scheme, Space};

fn transport(criterion: &mut Criterion) {
    let exec = team();
    for scheme in [Scheme::Quick, Scheme::Central, Scheme::SemiLagrangian] {
        of_box::<D2>(criterion, exec, &[128, 128], scheme);
        of_box::<D3>(criterion, exec, &[64, 64, 64], scheme);
    }
}

fn of_box<S: Space>(criterion: &mut Criterion, exec: &dyn Exec, cells: &[usize], scheme: Scheme) {
    let grid = Grid::new(cells, &vec![Boundary::Wall; cells.len()]);
    let field = flow::synthetic::<f32, S>(&grid, 1, 0.999);
    let v = [&field[0][..], &field[1][..], &field[2][..]];
    let rest: [Vec<f32>; 3] = core::array::from_fn(|axis| vec![0.0; v[axis].len()]);
    let mut ledger = Ledger::new();
    Transport::<f32>::requirement(&mut ledger, &grid, exec.threads());
    let mut memory = vec![0f32; ledger.bytes().unwrap_or(0) / size_of::<f32>()];
    let mut transport = Transport::carve(&grid, scheme, 1e-5, 1.0, exec.threads(), &mut Pool::new(&mut memory));
    let mut sums = vec![0.0; 2 * grid.rows()];
    let flow = Flow { initial: [&rest[0], &rest[1], &rest[2]], v, along: None };
    assert!(transport.load(exec, &flow, 1, 1, &mut sums).is_ok(), "the flow is too fast");
    let source = blob(&grid);
    let (mut out, mut mu) = (source.clone(), source.clone());
    let mut group = criterion.benchmark_group(format!("transport {}, {scheme:?}", size(cells)));
    group.sample_size(10).throughput(Throughput::Elements(grid.cells() as u64));
    group.bench_function("forward", |bencher| bencher.iter(|| transport.forward(exec, &source, &mut out, &mut sums)));
    group.bench_function("backward", |bencher| {
        bencher.iter(|| {
            mu.copy_from_slice(&source);
            transport.backward(exec, &source, &mut mu, &mut sums);
        });
    });
    group.finish();
}

/// A smooth blob in the middle.
fn blob(grid: &Grid) -> Vec<f32> {
    let [nx, ny, nz] = grid.n;
    let away = |i: usize, n: usize| ((i as f64 + 0.5) / n as f64 - 0.5) * if n == 1 { 0.0 } else { 6.0 };
    let value = |x, y, z| (-(away(x, nx).powi(2) + away(y, ny).powi(2) + away(z, nz).powi(2))).exp() as f32;
    (0..nz).flat_map(|z| (0..ny).flat_map(move |y| (0..nx).map(move |x| value(x, y, z)))).collect()
}

criterion_group!(benches, transport);
criterion_main!(benches);

//! The operators on whole trajectories in f32: divergence, self-advection, its adjoint, and the metric's blur.

mod common;

use common::{pool, size, sure};
use criterion::{
    BenchmarkGroup, Criterion, Throughput, criterion_group, criterion_main, measurement::WallTime,
};
use thurible_bench::flow;
use thurible_bench::pieces::Trajectories;
use thurible_core::exec::{RowBuffers, for_rows};
use thurible_core::field::{Block, Vector, VectorMut};
use thurible_core::grid::Grid;
use thurible_core::operators::self_advection::Fluid;
use thurible_core::operators::{divergence, self_advection};
use thurible_core::{Boundary, D2, D3, Exec, Space};

/// Slots of the trajectories.
const SLOTS: usize = 39;

fn operators(criterion: &mut Criterion) {
    let exec = pool();
    of_box::<D2>(criterion, exec, &[128, 128]);
    of_box::<D3>(criterion, exec, &[32, 32, 32]);
}

fn of_box<S: Space>(criterion: &mut Criterion, exec: &dyn Exec, cells: &[usize]) {
    let grid = Grid::new(cells, &vec![Boundary::Wall; cells.len()]);
    let field = flow::synthetic::<f32, S>(&grid, SLOTS, 1.0);
    let v: Vector<'_, f32> = [&field[0], &field[1], &field[2]];
    let mut group = criterion.benchmark_group(format!("operators {}, {SLOTS} slots", size(cells)));
    group
        .sample_size(10)
        .throughput(Throughput::Elements((grid.cells() * SLOTS) as u64));
    bench_divergence(&mut group, exec, &grid, v);
    bench_self_advection::<S>(&mut group, exec, &grid, v);
    bench_blur(&mut group, exec, cells);
    group.finish();
}

fn bench_divergence(
    group: &mut BenchmarkGroup<'_, WallTime>,
    exec: &dyn Exec,
    grid: &Grid,
    v: Vector<'_, f32>,
) {
    let mut out = vec![0f32; grid.cells() * SLOTS];
    let mut scratch = vec![0f32; exec.threads() * Block::largest(grid.n[0], SLOTS)];
    group.bench_function("divergence", |bencher| {
        bencher.iter(|| {
            let buffers = RowBuffers::fields([&mut out[..]]).with_scratch(&mut scratch[..]);
            for_rows(exec, grid.rows(), buffers, |task| {
                let [out] = task.fields;
                out.fill(0.0);
                for block in Block::all(grid, SLOTS) {
                    divergence::add_divergence(
                        &block,
                        task.row,
                        1.0,
                        v,
                        &mut out[block.span_in_row()],
                        &mut task.scratch[..block.len()],
                    );
                }
            });
        });
    });
}

fn bench_self_advection<S: Space>(
    group: &mut BenchmarkGroup<'_, WallTime>,
    exec: &dyn Exec,
    grid: &Grid,
    v: Vector<'_, f32>,
) {
    let mut out: [Vec<f32>; 3] = core::array::from_fn(|axis| vec![0.0; v[axis].len()]);
    let mut scratch = vec![0f32; exec.threads() * self_advection::scratch_per_thread(grid, SLOTS)];
    let fluid = Fluid {
        grid,
        slots: SLOTS,
        viscosity: 0.0,
        solids: thurible_core::grid::solids::Solids::default(),
    };
    group.bench_function("self-advection", |bencher| {
        bencher.iter(|| self_advection::apply::<f32, S>(exec, fluid, v, writable(&mut out), &mut scratch));
    });
    group.bench_function("its adjoint", |bencher| {
        bencher.iter(|| {
            self_advection::apply_adjoint::<f32, S>(exec, fluid, v, v, writable(&mut out), &mut scratch)
        });
    });
}

/// One field of cells, all filters that such a box has by default.
fn bench_blur(group: &mut BenchmarkGroup<'_, WallTime>, exec: &dyn Exec, cells: &[usize]) {
    let (all, filters) = (Trajectories::new(cells, 1), 1 + (cells[0] / 4).ilog2() as usize);
    let mut out = vec![0f32; all.grid.cells()];
    group.throughput(Throughput::Elements(out.len() as u64));
    sure(all.blur(exec, filters, |blur, error| {
        group.bench_function(format!("blur of one field, {filters} filters"), |bencher| {
            bencher.iter(|| blur.apply(exec, error, &mut out))
        });
    }));
}

fn writable(field: &mut [Vec<f32>; 3]) -> VectorMut<'_, f32> {
    field.each_mut().map(|component| &mut component[..])
}

criterion_group!(benches, operators);
criterion_main!(benches);

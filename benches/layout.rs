//! How a trajectory should lie in memory: the access patterns of the solver on three layouts, with a synthetic kernel.
//!
//! `cargo bench --bench layout` prints ns per cell and slot, the best of some rounds, on one thread (see `docs/log/layout.md`).
//! All layouts must end with the same bits.
#![allow(
    unsafe_code,
    reason = "calling functions compiled for AVX-512 after asking the machine for it"
)]

use thurible_bench::timing::best;

/// Coefficients of the kernel: own and other colour of the neighbour rows, own cell, other colour, time. Their sum is about 1.
const C: [f32; 5] = [0.013, -0.011, 0.31, 0.17, 0.55];
/// Cells along x that are solved side by side.
const GROUP: usize = 32;

/// Where the row along x of a slot begins.
#[derive(Clone, Copy)]
struct Layout {
    name: &'static str,
    slots: usize,
    n: [usize; 3],
    of_slot: usize,
    of_row: usize,
    of_plane: usize,
}

impl Layout {
    /// The three layouts of a box: outermost the slots, the planes, or the rows.
    fn all(n: [usize; 3], slots: usize) -> Vec<Self> {
        let [nx, ny, nz] = n;
        let plane = nx * ny;
        let base = Self {
            name: "slot-major",
            slots,
            n,
            of_slot: nz * plane,
            of_row: nx,
            of_plane: plane,
        };
        let mut all = vec![base];
        if nz > 1 {
            all.push(Self {
                name: "plane-major",
                of_slot: plane,
                of_plane: slots * plane,
                ..base
            });
        }
        all.push(Self {
            name: "padded",
            of_slot: nz * plane + 80,
            ..base
        });
        all.push(Self {
            name: "pencil-major",
            of_slot: nx,
            of_row: slots * nx,
            of_plane: slots * plane,
            ..base
        });
        all
    }

    fn at(&self, slot: usize, y: usize, z: usize) -> usize {
        slot * self.of_slot + z * self.of_plane + y * self.of_row
    }

    fn len(&self) -> usize {
        let [nx, ny, nz] = self.n;
        self.at(self.slots - 1, ny - 1, nz - 1) + nx
    }

    /// Every row of every slot, in the order in which they lie.
    fn rows(&self, mut visit: impl FnMut(usize, usize, usize)) {
        let [_, ny, nz] = self.n;
        let mut rows: Vec<_> = (0..nz)
            .flat_map(|z| (0..ny).flat_map(move |y| (0..self.slots).map(move |slot| (slot, y, z))))
            .collect();
        rows.sort_by_key(|&(slot, y, z)| self.at(slot, y, z));
        rows.into_iter().for_each(|(slot, y, z)| visit(slot, y, z));
    }
}

/// v, w, p and pbar: 2 (d + 1) fields.
type Fields = Vec<Vec<f32>>;

fn fill(layout: &Layout, fields: &mut Fields) {
    let [nx, ny, _] = layout.n;
    for (number, field) in fields.iter_mut().enumerate() {
        layout.rows(|slot, y, z| {
            let at = layout.at(slot, y, z);
            for (x, value) in field[at..at + nx].iter_mut().enumerate() {
                let seed = (((number * layout.slots + slot) * 128 + z) * ny + y) * nx + x;
                let hash = (seed as u32).wrapping_mul(0x9E37_79B1);
                *value = ((hash ^ (hash >> 15)).wrapping_mul(0x85EB_CA77) >> 8) as f32 / 8_388_608.0 - 1.0;
            }
        });
    }
}

fn checksum(layout: &Layout, fields: &Fields) -> u64 {
    let mut sum = 0u64;
    for field in fields {
        for slot in 0..layout.slots {
            for z in 0..layout.n[2] {
                for y in 0..layout.n[1] {
                    let at = layout.at(slot, y, z);
                    sum = field[at..at + layout.n[0]].iter().fold(sum, |sum, x| {
                        sum.rotate_left(5).wrapping_mul(0x0100_0000_01b3) ^ u64::from(x.to_bits())
                    });
                }
            }
        }
    }
    sum
}

/// Both colours of a smoother that takes a group of cells through all slots, reading the rows around them.
#[inline(always)]
fn smooth_body(layout: &Layout, fields: &mut Fields) {
    let [nx, ny, nz] = layout.n;
    for colour in 0..2 {
        for z in 0..nz {
            for y in 0..ny {
                let parity = (colour + y + z) % 2;
                let mut around = vec![layout.at(0, (y + ny - 1) % ny, z), layout.at(0, (y + 1) % ny, z)];
                if nz > 1 {
                    around.extend([layout.at(0, y, (z + nz - 1) % nz), layout.at(0, y, (z + 1) % nz)]);
                }
                for group in (0..nx).step_by(GROUP) {
                    smooth_group(layout, fields, layout.at(0, y, z) + group, &around, group, parity);
                }
            }
        }
    }
}

/// The cells of one colour of one group, in all slots.
#[inline(always)]
fn smooth_group(
    layout: &Layout,
    fields: &mut Fields,
    here: usize,
    around: &[usize],
    group: usize,
    parity: usize,
) {
    let own: [bool; GROUP] = core::array::from_fn(|x| x % 2 == parity);
    let count = fields.len();
    let mut carried = [[0f32; GROUP]; 8];
    for slot in 0..layout.slots {
        let shift = slot * layout.of_slot;
        let mut sums = [[0f32; GROUP]; 8];
        for (field, sum) in fields.iter().zip(&mut sums) {
            let row: &[f32] = &field[shift + here..][..GROUP];
            for x in 0..GROUP {
                sum[x] = C[2] * row[x] + C[3] * row[x ^ 1];
            }
            for &row in around {
                let row: &[f32] = &field[shift + row + group..][..GROUP];
                for x in 0..GROUP {
                    sum[x] += C[0] * row[x] + C[1] * row[x ^ 1];
                }
            }
        }
        for (number, field) in fields.iter_mut().enumerate() {
            let row: &mut [f32] = &mut field[shift + here..][..GROUP];
            let (sum, other, carried) = (&sums[number], &sums[(number + 1) % count], &mut carried[number]);
            for x in 0..GROUP {
                carried[x] = C[3] * other[x] + sum[x] + C[4] * carried[x] * 0.5;
                row[x] = if own[x] { carried[x] } else { row[x] };
            }
        }
    }
}

/// p = div v, w = grad pbar, row by row in the order of memory.
#[inline(always)]
fn stencils_body(layout: &Layout, fields: &mut Fields, rows: &[(usize, usize, usize)]) {
    let ([nx, ny, nz], dims) = (layout.n, fields.len() / 2 - 1);
    let (v, rest) = fields.split_at_mut(dims);
    let (w, scalars) = rest.split_at_mut(dims);
    let (p, pbar) = scalars.split_at_mut(1);
    for &(slot, y, z) in rows {
        let at = layout.at(slot, y, z);
        let next = [layout.at(slot, (y + 1) % ny, z), layout.at(slot, y, (z + 1) % nz)];
        let (out, low) = (&mut p[0][at..at + nx], &v[0][at..at + nx]);
        for x in 0..nx - 1 {
            out[x] = low[x + 1] - low[x];
        }
        out[nx - 1] = low[0] - low[nx - 1];
        for axis in 1..dims {
            let (low, high) = (&v[axis][at..at + nx], &v[axis][next[axis - 1]..][..nx]);
            out.iter_mut()
                .zip(low)
                .zip(high)
                .for_each(|((out, &low), &high)| *out += high - low);
        }
        let (out, low) = (&mut w[0][at..at + nx], &pbar[0][at..at + nx]);
        for x in 0..nx - 1 {
            out[x] = low[x + 1] - low[x];
        }
        out[nx - 1] = low[0] - low[nx - 1];
        for axis in 1..dims {
            let (out, high) = (&mut w[axis][at..at + nx], &pbar[0][next[axis - 1]..][..nx]);
            out.iter_mut()
                .zip(low)
                .zip(high)
                .for_each(|((out, &low), &high)| *out = high - low);
        }
    }
}

/// Every slot of the velocities copied to a field of its own and back: what transport does.
fn copy_slots(layout: &Layout, fields: &mut Fields, buffer: &mut [f32]) {
    let ([nx, ny, nz], dims) = (layout.n, fields.len() / 2 - 1);
    for slot in 0..layout.slots {
        for field in &mut fields[..dims] {
            for (row, out) in buffer.chunks_exact_mut(nx).enumerate() {
                let at = layout.at(slot, row % ny, row / ny);
                out.copy_from_slice(&field[at..at + nx]);
            }
            core::hint::black_box(&mut *buffer);
            for row in 0..ny * nz {
                let at = layout.at(slot, row % ny, row / ny);
                field[at..at + nx].copy_from_slice(&buffer[row * nx..(row + 1) * nx]);
            }
        }
    }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f")]
fn smooth_wide(layout: &Layout, fields: &mut Fields) {
    smooth_body(layout, fields);
}

fn smooth(layout: &Layout, fields: &mut Fields) {
    #[cfg(target_arch = "x86_64")]
    if is_x86_feature_detected!("avx512f") {
        // SAFETY: the machine has AVX-512.
        return unsafe { smooth_wide(layout, fields) };
    }
    smooth_body(layout, fields);
}

fn measure(n: [usize; 3], slots: usize, rounds: usize) {
    let dims = if n[2] > 1 { 3 } else { 2 };
    let work = (n[0] * n[1] * n[2] * slots) as f64 * 1e-9;
    println!(
        "\n{n:?}, T = {slots}, f32: ns per cell and slot\n{:<14}{:>12}{:>12}{:>12}",
        "", "smoother", "div, grad", "slot copy"
    );
    let mut ends = Vec::new();
    for layout in Layout::all(n, slots) {
        let mut fields: Fields = (0..2 * (dims + 1)).map(|_| vec![0.0; layout.len()]).collect();
        let mut buffer = vec![0f32; n[0] * n[1] * n[2]];
        let mut rows = Vec::new();
        layout.rows(|slot, y, z| rows.push((slot, y, z)));
        fill(&layout, &mut fields);
        let smoother = best(rounds, || smooth(&layout, &mut fields));
        let stencils = best(rounds, || stencils_body(&layout, &mut fields, &rows));
        let copies = best(rounds, || copy_slots(&layout, &mut fields, &mut buffer));
        println!(
            "{:<14}{:>12.2}{:>12.2}{:>12.2}",
            layout.name,
            smoother / work,
            stencils / work,
            copies / work
        );
        ends.push(checksum(&layout, &fields));
    }
    assert!(
        ends.windows(2).all(|pair| pair[0] == pair[1]),
        "the layouts computed different things"
    );
}

fn main() {
    measure([128, 128, 1], 39, 25);
    measure([64, 64, 64], 59, 3);
}

//! The smoke that stands in for the thesis' captures.

use super::bench::Bench;
use super::fields::texture;
use super::truth::Play;

/// A blob: its middle and its radius in widths of the box (x, y), the height from its floor (z).
type Blob = ([f64; 3], f64);

/// The sum of blobs with even tops, whose smoke is grained.
fn blobs(cells: &[usize], blobs: &[Blob], seed: u64) -> Vec<f64> {
    let wide = cells.first().copied().unwrap_or(1) as f64;
    let grain = texture(cells, (wide / 40.0).max(2.5), seed);
    let [nx, ny] = [0, 1].map(|axis| cells.get(axis).copied().unwrap_or(1));
    let inside = |cell: usize| {
        let place = [cell % nx, cell / nx % ny, cell / (nx * ny)].map(|at| (at as f64 + 0.5) / wide);
        let one = |(middle, radius): &Blob| {
            let square: f64 = place.iter().zip(middle).map(|(x, c)| (x - c) * (x - c)).sum();
            (-(square / (radius * radius)).powi(2)).exp()
        };
        blobs.iter().map(one).sum::<f64>().min(1.0)
    };
    let values = grain.iter().enumerate();
    values
        .map(|(cell, grain)| inside(cell) * (0.25 + 0.75 * grain))
        .collect()
}

/// Acceleration by which smoke crosses a box of so many cells along its longest side in so many steps.
fn lift(longest: usize, steps: usize) -> f64 {
    0.045 * longest as f64 / 256.0 * (236.0 / steps as f64).powi(2)
}

/// Waves that stir the whole box for some steps: turbulence that the tracker does not know. `part` is about their speed in parts of that of
/// rising smoke.
fn stir(cells: &[usize], part: f64) -> String {
    let longest = cells.iter().copied().max().unwrap_or(1) as f64;
    let middle: Vec<f64> = cells.iter().map(|&count| 0.5 * count as f64).collect();
    let one = |seed: usize, waves: f64| {
        let (radius, size) = (4.0 * longest, longest * waves);
        format!(
            "[[template]]\nkind = \"noise\"\ncenter = {middle:?}\nradius = {radius:?}\nsize = {size:?}\nseed = {seed}\nto = {STIRRED}\namplitude = {:?}\n",
            part * RISE * longest / STIRRED as f64
        )
    };
    one(1, 0.25) + &one(2, 0.12)
}

/// Speed of rising smoke in boxes a step, about.
const RISE: f64 = 5e-3;
/// Steps of the simulation in which the box is stirred.
const STIRRED: usize = 12;

/// Puffs that rise in turbulent air: the smoke of chapter 5.
pub(super) fn smoke(bench: &Bench<'_>) -> Play {
    let (cells, frames) = (bench.cells(&[48, 48, 96]), 60);
    let fine: Vec<usize> = cells.iter().map(|count| 2 * count).collect();
    let longest = fine.iter().copied().max().unwrap_or(1);
    let puffs = [
        ([0.34, 0.44, 0.38], 0.25),
        ([0.68, 0.58, 0.52], 0.22),
        ([0.46, 0.54, 0.96], 0.2),
    ];
    Play {
        name: "smoke",
        source: blobs(&fine, &puffs, 1),
        buoyancy: lift(longest, 4 * (frames - 1)),
        viscosity: 0.0,
        tables: String::new(),
        stir: stir(&fine, 0.05),
        cells,
        frames,
        emits: false,
    }
}

/// A thin tube of smoke that rises steadily: that of figures 3.8 and 3.9.
pub(super) fn tube(bench: &Bench<'_>) -> Play {
    let (cells, frames) = (bench.cells(&[32, 32, 80]), 31);
    let fine: Vec<usize> = cells.iter().map(|count| 2 * count).collect();
    let [wide, high] = [0, 2].map(|axis| fine.get(axis).copied().unwrap_or(1) as f64);
    let speed = 0.5 * high / (4 * (frames - 1)) as f64;
    let vent = format!(
        "[[emitter]]\ntarget = 1.0\nvelocity = [0.0, 0.0, {:?}]\ncapsule = {{ from = {:?}, to = {:?}, radius = {:?} }}\n",
        2.0 * speed,
        [0.5 * wide, 0.5 * wide, 0.0],
        [0.5 * wide, 0.5 * wide, 0.06 * high],
        0.11 * wide
    );
    Play {
        name: "tube",
        source: Vec::new(),
        buoyancy: 0.5 * lift(high as usize, 4 * (frames - 1)),
        viscosity: 0.01,
        tables: vent,
        stir: stir(&fine, 0.03),
        cells,
        frames,
        emits: false,
    }
}

/// Dye that sinks into still water and opens: the bloom.
pub(super) fn bloom(bench: &Bench<'_>) -> Play {
    let (cells, frames) = (bench.cells(&[48, 48, 48]), 41);
    let fine: Vec<usize> = cells.iter().map(|count| 2 * count).collect();
    let drops = [([0.5, 0.5, 0.8], 0.12), ([0.47, 0.52, 0.94], 0.07)];
    Play {
        name: "bloom",
        source: blobs(&fine, &drops, 2),
        buoyancy: -0.6 * lift(2 * fine.iter().copied().max().unwrap_or(1), 4 * (frames - 1)),
        viscosity: 0.02,
        tables: String::new(),
        stir: stir(&fine, 0.06),
        cells,
        frames,
        emits: false,
    }
}

/// Puffs from a vent below a solid ball: figure 5.3.
pub(super) fn ball(bench: &Bench<'_>) -> Play {
    let (cells, frames) = (bench.cells(&[48, 48, 96]), 61);
    let fine: Vec<usize> = cells.iter().map(|count| 2 * count).collect();
    let longest = fine.iter().copied().max().unwrap_or(1);
    // One puff in each stretch of the simulation.
    let puffs = "[[emitter]]\nfrom = 0\nto = 13\nrate = 0.08\nfile = \"source.npz\"\nname = \"density\"\n";
    let wide = fine.first().copied().unwrap_or(1) as f64;
    Play {
        name: "ball",
        source: blobs(&fine, &[([0.5, 0.5, 0.14], 0.15)], 3),
        buoyancy: lift(longest, 4 * (frames - 1)),
        viscosity: 0.0,
        tables: puffs.to_owned() + &solid_ball([0.5 * wide, 0.5 * wide, 0.62 * wide], 0.16 * wide),
        stir: stir(&fine, 0.15),
        cells,
        frames,
        emits: true,
    }
}

/// A ball as an obstacle of a scene.
pub(super) fn solid_ball(center: [f64; 3], radius: f64) -> String {
    format!("[[obstacle]]\nsphere = {{ center = {center:?}, radius = {radius:?} }}\n")
}

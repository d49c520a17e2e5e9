//! Tomography: gains and residuals against a plain second implementation, memory, bits, refusals, and what comes out.

use crate::allocations::count;
use crate::fields::Memory;
use crate::fields::random::Random as Plain;
use thurible_core::tomography::{
    Camera, Fault, Lens, Method, Reconstruction, Settings, Tomography, TomographyError, integral, photograph,
    project,
};
use thurible_core::walk::prior::whole;
use thurible_core::walk::{Cells, Course, Gain, Prior, Random, Rule, Terrain};
use thurible_core::{Real, Serial};

/// Cameras around a plane.
fn around(count: usize, cells: [usize; 2], width: usize) -> Vec<Camera<2>> {
    let middle = cells.map(|count| 0.5 * count as f64);
    (0..count)
        .map(|k| {
            let turn = core::f64::consts::PI * k as f64 / count as f64;
            let (across, forward) = ([turn.cos(), turn.sin()], [-turn.sin(), turn.cos()]);
            let at = 0.5 * width as f64 - across[0] * middle[0] - across[1] * middle[1];
            let lens = Lens::Orthographic {
                across,
                down: [0.0; 2],
                at: [at, 0.5],
                forward,
                pitch: 1.0,
            };
            Camera {
                lens,
                pixels: [width, 1],
            }
        })
        .collect()
}

/// A pinhole before a box, and an orthographic camera above it.
fn pair() -> Vec<Camera<3>> {
    let pinhole = Lens::Pinhole {
        eye: [3.5, -12.0, 4.5],
        across: [14.0, 0.0, 0.0],
        down: [0.0, 0.0, -14.0],
        at: [5.0, 6.0],
        forward: [0.0, 1.0, 0.0],
    };
    let above = Lens::Orthographic {
        across: [0.8, 0.0, 0.0],
        down: [0.0, -0.8, 0.0],
        at: [1.5, 8.0],
        forward: [0.0, 0.0, -1.0],
        pitch: 1.25,
    };
    vec![
        Camera {
            lens: pinhole,
            pixels: [10, 12],
        },
        Camera {
            lens: above,
            pixels: [9, 9],
        },
    ]
}

fn disc(cells: [usize; 2]) -> Vec<f64> {
    (0..cells[0] * cells[1])
        .map(|index| {
            let at = [index % cells[0], index / cells[0]].map(|at| at as f64 + 0.5);
            let far = |x: f64, y: f64| (at[0] - x * cells[0] as f64).hypot(at[1] - y * cells[1] as f64);
            let side = cells[0] as f64;
            f64::from(u8::from(far(0.45, 0.5) < 0.25 * side))
                + 0.5 * f64::from(u8::from(far(0.7, 0.6) < 0.12 * side))
        })
        .collect()
}

fn pictures<const D: usize>(cells: &Cells<D>, cameras: &[Camera<D>], density: &[f64]) -> Vec<Vec<f64>> {
    cameras
        .iter()
        .map(|camera| {
            let mut picture = vec![0.0; camera.len()];
            photograph(&Serial, cells, camera, density, 2, &mut picture);
            picture
        })
        .collect()
}

fn measured<'m, T: Real, const D: usize>(
    problem: Tomography<'m, D>,
    pictures: &[Vec<f64>],
    memory: &'m mut Memory,
) -> Reconstruction<'m, T, D> {
    let mut found = Reconstruction::new(problem, memory.block()).unwrap();
    for (camera, picture) in pictures.iter().enumerate() {
        let picture: Vec<T> = picture.iter().map(|&x| T::from_f64(x)).collect();
        found.measure(camera, &picture).unwrap();
    }
    found
}

/// The pixels of a place with their weights, by the definition alone.
fn footprint<const D: usize>(camera: &Camera<D>, place: &[f64; D]) -> Vec<(usize, f64)> {
    let dot = |a: &[f64; D], b: &[f64; D]| -> f64 { a.iter().zip(b).map(|(a, b)| a * b).sum() };
    let (u, v, weight) = match &camera.lens {
        Lens::Orthographic {
            across,
            down,
            at,
            pitch,
            ..
        } => (
            dot(across, place) + at[0],
            dot(down, place) + at[1],
            pitch.powi(1 - D as i32),
        ),
        Lens::Pinhole {
            eye,
            across,
            down,
            at,
            forward,
        } => {
            let way: [f64; D] = core::array::from_fn(|axis| place[axis] - eye[axis]);
            let depth = dot(forward, &way);
            let cosine = depth / dot(&way, &way).sqrt();
            let focal = dot(across, across).sqrt();
            let area = if D == 2 {
                depth / focal
            } else {
                (depth / focal).powi(2)
            };
            (
                dot(across, &way) / depth + at[0],
                dot(down, &way) / depth + at[1],
                1.0 / (area * cosine),
            )
        }
    };
    let mut list = Vec::new();
    for y in 0..camera.pixels[1] {
        for x in 0..camera.pixels[0] {
            let hat = |at: f64, pixel: usize| (1.0 - (at - pixel as f64 - 0.5).abs()).max(0.0);
            let part = hat(u, x) * if D == 2 { 1.0 } else { hat(v, y) };
            if part > 0.0 {
                list.push((y * camera.pixels[0] + x, part * weight));
            }
        }
    }
    list
}

/// The walk written down plainly: every gain is a difference of whole objectives.
struct Naive<'a, const D: usize> {
    problem: Tomography<'a, D>,
    measured: Vec<Vec<f64>>,
    residual: Vec<Vec<f64>>,
    density: Vec<f64>,
    novel: Vec<Vec<f64>>,
    samples: Vec<([f64; D], f64)>,
    eps: f64,
}

/// Residual, density and novel views.
type State = (Vec<Vec<f64>>, Vec<f64>, Vec<Vec<f64>>);

/// Priors on a picture, pixel by pixel, by their definitions.
fn of_picture(prior: Prior, [width, height]: [usize; 2], image: &[f64]) -> f64 {
    let at = |x: usize, y: usize| (x < width && y < height).then(|| image[y * width + x]);
    let mut sum = 0.0;
    for y in 0..height {
        for x in 0..width {
            let here = image[y * width + x];
            let to = |there: Option<f64>| there.map_or(0.0, |there| there - here);
            sum += match prior {
                Prior::ImageTv => to(at(x + 1, y)).hypot(to(at(x, y + 1))),
                Prior::ImageSad => {
                    let before = (x > 0).then(|| at(x - 1, y + 1)).flatten();
                    [at(x + 1, y), at(x, y + 1), at(x + 1, y + 1), before]
                        .map(|there| to(there).abs())
                        .iter()
                        .sum()
                }
                _ => 0.0,
            };
        }
    }
    sum
}

impl<const D: usize> Naive<'_, D> {
    fn with(&self, place: &[f64; D], mass: f64) -> State {
        let (mut residual, mut density) = (self.residual.clone(), self.density.clone());
        let mut novel = self.novel.clone();
        for (camera, image) in self.problem.novel.iter().zip(&mut novel) {
            for (pixel, weight) in footprint(camera, place) {
                image[pixel] += mass * weight;
            }
        }
        for (camera, residual) in self.problem.cameras.iter().zip(&mut residual) {
            for (pixel, weight) in footprint(camera, place) {
                residual[pixel] -= mass * weight;
            }
        }
        self.problem
            .cells
            .add(&mut density, &self.problem.cells.around(place), mass);
        (residual, density, novel)
    }

    fn energy(&self, (residual, density, novel): &State) -> f64 {
        let settings = self.problem.settings;
        let data: f64 = residual.iter().flatten().map(|r| r * r).sum();
        let views = self.problem.novel.iter().zip(novel);
        let images: f64 = views
            .map(|(camera, image)| of_picture(settings.prior, camera.pixels, image))
            .sum();
        0.5 * data + settings.gamma * (whole(settings.prior, &self.problem.cells, density) + images)
    }

    fn now(&self) -> State {
        (self.residual.clone(), self.density.clone(), self.novel.clone())
    }
}

impl<const D: usize> Terrain for Naive<'_, D> {
    type Place = [f64; D];

    fn anywhere(&self, random: &mut Random) -> [f64; D] {
        self.problem
            .cells
            .counts
            .map(|count| random.uniform() * count as f64)
    }

    fn near(&self, from: [f64; D], random: &mut Random) -> [f64; D] {
        let diagonal: f64 = self.problem.cells.counts.iter().map(|&n| (n * n) as f64).sum();
        from.map(|x| x + self.problem.settings.sigma * diagonal.sqrt() * random.normal())
    }

    fn gain(&self, place: [f64; D]) -> Gain {
        let inside = place
            .iter()
            .zip(&self.problem.cells.counts)
            .all(|(&x, &n)| x >= 0.0 && x < n as f64);
        if !inside {
            return Gain::NONE;
        }
        let mut seen = false;
        for (camera, measured) in self.problem.cameras.iter().zip(&self.measured) {
            let touched = footprint(camera, &place);
            seen |= !touched.is_empty();
            if !touched.is_empty() && touched.iter().all(|&(pixel, _)| measured[pixel] <= 0.0) {
                return Gain::NONE;
            }
        }
        if !seen {
            return Gain::NONE;
        }
        let before = self.energy(&self.now());
        let mut best = Gain {
            energy: f64::NEG_INFINITY,
            mass: 0.0,
        };
        for mass in [self.eps, -self.eps] {
            let after = self.with(&place, mass);
            let settings = self.problem.settings;
            let falls = if settings.keeps_cells() {
                after.1.iter().any(|&p| p < 0.0)
            } else {
                after.2.iter().flatten().any(|&p| p < 0.0)
            };
            if mass < 0.0 && settings.nonnegative && falls {
                continue;
            }
            let energy = before - self.energy(&after);
            if energy > best.energy {
                best = Gain { energy, mass };
            }
        }
        best
    }

    fn record(&mut self, place: [f64; D], mass: f64) {
        (self.residual, self.density, self.novel) = self.with(&place, mass);
        self.samples.push((place, mass));
    }
}

/// After some thousand mutations the core stands where the plain walk stands: the same samples, the same residual, the same density.
fn agrees<const D: usize>(cells: [usize; D], cameras: &[Camera<D>], density: &[f64], settings: Settings) {
    agrees_with(cells, [cameras, &[]], density, settings);
}

/// The same with novel views.
fn agrees_with<const D: usize>(
    cells: [usize; D],
    [cameras, novel]: [&[Camera<D>]; 2],
    density: &[f64],
    settings: Settings,
) {
    let cells = Cells { counts: cells };
    let problem = Tomography {
        cells,
        cameras,
        novel,
        settings,
    };
    let q = pictures(&cells, cameras, density);
    let mut memory = Memory::new(Reconstruction::<f64, D>::bytes(&problem).unwrap());
    let mut found = measured::<f64, D>(problem, &q, &mut memory);
    found.begin(3, false).unwrap();
    let mut naive = Naive {
        problem,
        measured: q.clone(),
        residual: q,
        density: vec![0.0; cells.len()],
        novel: novel.iter().map(|camera| vec![0.0; camera.len()]).collect(),
        samples: Vec::new(),
        eps: found.eps(),
    };
    while !found.advance(997) {}
    let mut course = Course::new(settings.seed, 3, settings.length, settings.budget, settings.rule);
    course.advance(&mut naive, u64::MAX);
    assert_eq!(found.walked(), course.walked(), "{settings:?}");
    assert!(course.walked().recorded > 30);
    let close = |one: &[f64], other: &[f64]| {
        one.iter()
            .zip(other)
            .all(|(one, other)| (one - other).abs() < 1e-9)
    };
    if settings.keeps_cells() {
        assert!(close(found.density(), &naive.density), "{settings:?}");
    } else {
        assert!(found.density().is_empty());
    }
    for (view, image) in naive.novel.iter().enumerate() {
        assert!(image.iter().any(|&pixel| pixel > 0.1));
        assert!(close(found.novel(view), image), "{settings:?}");
    }
    for (camera, residual) in naive.residual.iter().enumerate() {
        assert!(close(found.residual(camera), residual));
    }
    let energy = naive.energy(&naive.now());
    assert!((found.energy().total() - energy).abs() < 1e-9 * energy.max(1.0));
}

fn few(prior: Prior, rule: Rule) -> Settings {
    Settings {
        prior,
        rule,
        gamma: 0.05,
        budget: 3000,
        length: 200,
        eps: Some(0.3),
        tolerance: 0.0,
        seed: 11,
        ..Settings::default()
    }
}

#[test]
fn the_walk_agrees_with_a_plain_one() {
    let cells = [12, 10];
    for (prior, rule) in [
        (Prior::None, Rule::Patient),
        (Prior::L2, Rule::Patient),
        (Prior::Tv, Rule::Eager),
        (Prior::Sad, Rule::Patient),
    ] {
        agrees(cells, &around(5, cells, 16), &disc(cells), few(prior, rule));
    }
    let signed = Settings {
        nonnegative: false,
        ..few(Prior::Sad, Rule::Patient)
    };
    agrees(cells, &around(3, cells, 11), &disc(cells), signed);
}

#[test]
fn the_walk_agrees_with_a_plain_one_in_a_box() {
    let cells = [7, 6, 8];
    let density: Vec<f64> = (0..7 * 6 * 8)
        .map(|index| {
            f64::from(u8::from(matches!(
                (index % 7, index / 7 % 6, index / 42),
                (2..=4, 2..=4, 3..=5)
            )))
        })
        .collect();
    for prior in [Prior::None, Prior::Sad, Prior::Tv, Prior::L2] {
        let settings = Settings {
            budget: 1200,
            ..few(prior, Rule::Patient)
        };
        agrees(cells, &pair(), &density, settings);
    }
}

/// A million mutations later the residual is still that of the samples, but for rounding.
#[test]
fn the_residual_stays_that_of_the_samples() {
    let cells = Cells { counts: [24, 24] };
    let cameras = around(6, cells.counts, 34);
    let settings = Settings {
        prior: Prior::None,
        nonnegative: false,
        budget: 1_000_000,
        eps: Some(0.01),
        tolerance: 0.0,
        ..Settings::default()
    };
    let problem = Tomography {
        cells,
        cameras: &cameras,
        novel: &[],
        settings,
    };
    let q = pictures(&cells, &cameras, &disc(cells.counts));
    let mut memory = Memory::new(Reconstruction::<f64, 2>::bytes(&problem).unwrap());
    let mut found = measured::<f64, 2>(problem, &q, &mut memory);
    found.begin(0, false).unwrap();
    while !found.advance(u64::MAX) {}
    // The same walk over plain footprints, which keeps its samples.
    struct Kept<'a>(Naive<'a, 2>);
    impl Terrain for Kept<'_> {
        type Place = [f64; 2];
        fn anywhere(&self, random: &mut Random) -> [f64; 2] {
            self.0.anywhere(random)
        }
        fn near(&self, from: [f64; 2], random: &mut Random) -> [f64; 2] {
            self.0.near(from, random)
        }
        fn gain(&self, place: [f64; 2]) -> Gain {
            if !self.0.problem.cells.hold(&place) {
                return Gain::NONE;
            }
            let (mut along, mut square) = (0.0, 0.0);
            for ((camera, q), r) in self
                .0
                .problem
                .cameras
                .iter()
                .zip(&self.0.measured)
                .zip(&self.0.residual)
            {
                let touched = camera_row(camera, &place);
                if !touched.is_empty() && touched.iter().all(|&(pixel, _)| q[pixel] <= 0.0) {
                    return Gain::NONE;
                }
                for (pixel, weight) in touched {
                    along += weight * r[pixel];
                    square += weight * weight;
                }
            }
            let mass = self.0.eps;
            let energy = mass * f64::abs(along) - 0.5 * mass * mass * square;
            let mass = if along < 0.0 { -mass } else { mass };
            Gain { energy, mass }
        }
        fn record(&mut self, place: [f64; 2], mass: f64) {
            for (camera, r) in self.0.problem.cameras.iter().zip(&mut self.0.residual) {
                for (pixel, weight) in camera_row(camera, &place) {
                    r[pixel] -= mass * weight;
                }
            }
            self.0.samples.push((place, mass));
        }
    }
    fn camera_row(camera: &Camera<2>, place: &[f64; 2]) -> Vec<(usize, f64)> {
        let Lens::Orthographic { across, at, .. } = &camera.lens else {
            unreachable!()
        };
        let u = across[0] * place[0] + across[1] * place[1] + at[0] - 0.5;
        let (low, part) = (u.floor() as i64, u - u.floor());
        [(low, 1.0 - part), (low + 1, part)]
            .into_iter()
            .filter(|(pixel, _)| (0..camera.pixels[0] as i64).contains(pixel))
            .map(|(pixel, weight)| (pixel as usize, weight))
            .collect()
    }
    let mut kept = Kept(Naive {
        problem,
        measured: q.clone(),
        residual: q.clone(),
        novel: Vec::new(),
        density: vec![0.0; cells.len()],
        samples: Vec::new(),
        eps: found.eps(),
    });
    Course::new(settings.seed, 0, settings.length, settings.budget, settings.rule)
        .advance(&mut kept, u64::MAX);
    assert_eq!(found.walked().recorded, kept.0.samples.len() as u64);
    let (mut summed, mut density) = (q, vec![0.0; cells.len()]);
    for (place, mass) in &kept.0.samples {
        for (camera, r) in cameras.iter().zip(&mut summed) {
            for (pixel, weight) in camera_row(camera, place) {
                r[pixel] -= mass * weight;
            }
        }
        cells.add(&mut density, &cells.around(place), *mass);
    }
    for (camera, summed) in summed.iter().enumerate() {
        for (found, summed) in found.residual(camera).iter().zip(summed) {
            assert!((found - summed).abs() < 1e-10, "{found} {summed}");
        }
    }
    assert!(
        found
            .density()
            .iter()
            .zip(&density)
            .all(|(one, other)| (one - other).abs() < 1e-10)
    );
}

#[test]
fn the_objective_never_rises() {
    let cells = Cells { counts: [20, 20] };
    let cameras = around(6, cells.counts, 28);
    let q = pictures(&cells, &cameras, &disc(cells.counts));
    for prior in [Prior::None, Prior::L2, Prior::Tv, Prior::Sad] {
        for rule in [Rule::Patient, Rule::Eager] {
            let settings = Settings {
                budget: 40_000,
                ..few(prior, rule)
            };
            let problem = Tomography {
                cells,
                cameras: &cameras,
                novel: &[],
                settings,
            };
            let mut memory = Memory::new(Reconstruction::<f64, 2>::bytes(&problem).unwrap());
            let mut found = measured::<f64, 2>(problem, &q, &mut memory);
            found.begin(0, false).unwrap();
            let mut last = found.energy().total();
            while !found.advance(101) {
                let now = found.energy().total();
                assert!(
                    now <= last * (1.0 + 1e-13),
                    "{prior:?} {rule:?}: {now} after {last}"
                );
                last = now;
            }
            assert!(found.density().iter().all(|&p| p >= 0.0));
        }
    }
}

fn bits<T: Real>(step: u64, seed: u64) -> Vec<u64> {
    let cells = Cells { counts: [16, 12] };
    let cameras = around(5, cells.counts, 22);
    let settings = Settings {
        budget: 20_000,
        seed,
        ..few(Prior::Sad, Rule::Patient)
    };
    let problem = Tomography {
        cells,
        cameras: &cameras,
        novel: &[],
        settings,
    };
    let q = pictures(&cells, &cameras, &disc(cells.counts));
    let mut memory = Memory::new(Reconstruction::<T, 2>::bytes(&problem).unwrap());
    let mut found = measured::<T, 2>(problem, &q, &mut memory);
    found.begin(0, false).unwrap();
    while !found.advance(step) {}
    found.begin(1, true).unwrap();
    while !found.advance(step) {}
    found.density().iter().map(|p| p.to_f64().to_bits()).collect()
}

#[test]
fn the_same_seed_gives_the_same_bits() {
    assert_eq!(bits::<f64>(u64::MAX, 1), bits::<f64>(37, 1));
    assert_eq!(bits::<f32>(u64::MAX, 1), bits::<f32>(1000, 1));
    assert_ne!(bits::<f64>(u64::MAX, 1), bits::<f64>(u64::MAX, 2));
    let best = thurible_core::simd::level();
    let wide = bits::<f32>(u64::MAX, 4);
    thurible_core::simd::limit(thurible_core::simd::Level::Baseline);
    let narrow = bits::<f32>(u64::MAX, 4);
    thurible_core::simd::limit(best);
    assert_eq!(wide, narrow, "instruction sets differ");
}

#[test]
fn the_plan_is_exact_and_nothing_is_allocated() {
    let cells = Cells { counts: [18, 14] };
    let cameras = around(4, cells.counts, 24);
    let q = pictures(&cells, &cameras, &disc(cells.counts));
    let narrow: Vec<Vec<f32>> = q.iter().map(|q| q.iter().map(|&x| x as f32).collect()).collect();
    for method in [Method::Walk, Method::Sart] {
        let settings = Settings {
            method,
            budget: 5000,
            ..Settings::default()
        };
        let problem = Tomography {
            cells,
            cameras: &cameras,
            novel: &[],
            settings,
        };
        let bytes = Reconstruction::<f32, 2>::bytes(&problem).unwrap();
        let up = |count: usize| (4 * count).next_multiple_of(64);
        let work = if method == Method::Sart {
            2 * up(18 * 14)
        } else {
            0
        };
        assert_eq!(bytes, 2 * up(4 * 24) + up(18 * 14) + work);
        let mut small = Memory::new(bytes - 1);
        assert_eq!(
            Reconstruction::<f32, 2>::new(problem, small.block()).err(),
            Some(TomographyError::Memory { needed: bytes })
        );
        let mut memory = Memory::new(bytes);
        let before = count();
        let mut found = Reconstruction::<f32, 2>::new(problem, memory.block()).unwrap();
        for (camera, picture) in narrow.iter().enumerate() {
            found.measure(camera, picture).unwrap();
        }
        found.begin(0, false).unwrap();
        while !found.advance(1000) {}
        found.begin(1, true).unwrap();
        while !found.advance(1000) {}
        core::hint::black_box((found.energy(), found.residual_relative()));
        assert_eq!(count() - before, 0, "{method:?}");
    }
}

#[test]
fn what_cannot_be_is_refused() {
    let cells = Cells { counts: [8, 8] };
    let cameras = around(2, cells.counts, 12);
    let settings = Settings {
        budget: 100,
        ..Settings::default()
    };
    let good = Tomography {
        cells,
        cameras: &cameras,
        novel: &[],
        settings,
    };
    assert_eq!(good.check(), Ok(()));
    let none = Tomography { cameras: &[], ..good };
    assert_eq!(none.check(), Err(TomographyError::NoCamera));
    let thin = Tomography {
        cells: Cells { counts: [1, 8] },
        ..good
    };
    assert_eq!(thin.check(), Err(TomographyError::Cells { axis: 0 }));
    // Sums of pixels that wrap, and planes of pixels that nobody goes through one by one.
    for pixels in [[1 << 40, 1 << 40], [1 << 62, 1], [1 << 40, 1]] {
        let mut wide = cameras.clone();
        wide.iter_mut().for_each(|camera| camera.pixels = pixels);
        if let Lens::Orthographic { at, .. } = &mut wide[1].lens {
            at[0] -= 1e6;
        }
        let begun = std::time::Instant::now();
        let large = Tomography {
            cameras: &wide,
            ..good
        }
        .check();
        assert!(large.is_err(), "{pixels:?}");
        assert!(begun.elapsed().as_secs() < 5, "{pixels:?}");
    }
    let mut away = cameras.clone();
    let Lens::Orthographic { at, .. } = &mut away[1].lens else {
        unreachable!()
    };
    at[0] += 1000.0;
    let blind = Tomography {
        cameras: &away,
        ..good
    };
    assert_eq!(blind.check(), Err(TomographyError::Blind { camera: 1 }));
    for wrong in [
        Settings {
            gamma: f64::NAN,
            ..settings
        },
        Settings {
            gamma: -1.0,
            ..settings
        },
        Settings {
            sigma: 0.0,
            ..settings
        },
        Settings {
            eps: Some(0.0),
            ..settings
        },
        Settings {
            budget: 0,
            ..settings
        },
        Settings {
            relax: 2.0,
            ..settings
        },
    ] {
        let refused = Tomography {
            settings: wrong,
            ..good
        }
        .check();
        assert!(
            matches!(refused, Err(TomographyError::Setting { .. })),
            "{wrong:?}"
        );
    }
    let mut memory = Memory::new(Reconstruction::<f64, 2>::bytes(&good).unwrap());
    let mut found = Reconstruction::<f64, 2>::new(good, memory.block()).unwrap();
    assert!(matches!(
        found.measure(0, &[1.0]),
        Err(TomographyError::Pixels {
            fault: Fault::Count {
                found: 1,
                expected: 12
            },
            ..
        })
    ));
    let mut picture = [0.0; 12];
    picture[5] = f64::NAN;
    assert!(matches!(
        found.measure(1, &picture),
        Err(TomographyError::Pixels {
            camera: 1,
            fault: Fault::NotFinite { pixel: 5 }
        })
    ));
    assert_eq!(found.begin(0, false), Err(TomographyError::Dark));
}

/// A place on the ray of a pixel is seen at that pixel.
#[test]
fn rays_and_images_agree() {
    let mut plain = Plain::new(3);
    for camera in pair() {
        for _ in 0..100 {
            let at = [10.0 * plain.unit(), 9.0 * plain.unit()];
            let (start, way) = camera.ray(at);
            assert!((way.iter().map(|x| x * x).sum::<f64>() - 1.0).abs() < 1e-12);
            let t = 5.0 + 20.0 * plain.unit();
            let place = core::array::from_fn(|axis| start[axis] + t * way[axis]);
            let seen = camera.see(&place).unwrap();
            assert!((seen.at[0] - at[0]).abs() < 1e-9 && (seen.at[1] - at[1]).abs() < 1e-9);
        }
    }
}

/// F of a uniform density is the length of the rays, by samples and by rays alike.
#[test]
fn a_uniform_box_is_as_bright_as_it_is_deep() {
    let cells = Cells { counts: [30, 30] };
    let cameras = around(3, cells.counts, 30);
    let density = vec![0.5_f64; cells.len()];
    let straight = integral(&cells, &cameras[0], &density, [15.5, 0.5], 0.25);
    assert!((straight - 15.0).abs() < 1e-9, "{straight}");
    let mut picture = vec![0.0_f64; 30];
    project(&cells, &cameras[0], &density, 1.0, &mut picture);
    assert!(picture[5..25].iter().all(|&x| (x - 15.0).abs() < 1e-9));
    // The mass that all pixels hold is that of the box, for a pinhole too.
    let cells = Cells { counts: [7, 7, 9] };
    let camera = pair()[0];
    let far = Camera {
        pixels: [40, 40],
        lens: match camera.lens {
            Lens::Pinhole {
                eye,
                across,
                down,
                forward,
                ..
            } => Lens::Pinhole {
                eye,
                across,
                down,
                forward,
                at: [20.0, 20.0],
            },
            other => other,
        },
    };
    let density = vec![1.0_f64; cells.len()];
    let (mut samples, mut rays) = (vec![0.0_f64; far.len()], vec![0.0_f64; far.len()]);
    project(&cells, &far, &density, 1.0, &mut samples);
    photograph(&Serial, &cells, &far, &density, 4, &mut rays);
    let (samples, rays): (f64, f64) = (samples.iter().sum(), rays.iter().sum());
    assert!((samples / rays - 1.0).abs() < 0.01, "{samples} {rays}");
}

/// What comes out is the disc: by the walk better with a prior than without, and by SART.
#[test]
fn a_disc_comes_out() {
    let cells = Cells { counts: [32, 32] };
    let cameras = around(10, cells.counts, 46);
    let truth = disc(cells.counts);
    let q = pictures(&cells, &cameras, &truth);
    let rms = |settings: Settings| {
        let problem = Tomography {
            cells,
            cameras: &cameras,
            novel: &[],
            settings,
        };
        let mut memory = Memory::new(Reconstruction::<f32, 2>::bytes(&problem).unwrap());
        let mut found = measured::<f32, 2>(problem, &q, &mut memory);
        found.begin(0, false).unwrap();
        while !found.advance(u64::MAX) {}
        let square: f64 = found
            .density()
            .iter()
            .zip(&truth)
            .map(|(p, t)| (p.to_f64() - t).powi(2))
            .sum();
        (square / truth.len() as f64).sqrt()
    };
    let budget = Settings {
        budget: 400_000,
        ..Settings::default()
    };
    let sad = rms(budget);
    let none = rms(Settings {
        prior: Prior::None,
        ..budget
    });
    let sart = rms(Settings {
        method: Method::Sart,
        sweeps: 20,
        ..budget
    });
    assert!(
        sad < 0.065 && sad < none && sad < sart && sart < 0.12,
        "SAD {sad}, none {none}, SART {sart}"
    );
}

/// A frame that begins with the one before needs a fifth of the budget for what a cold one does not reach with it.
#[test]
fn a_warm_frame_is_better_than_a_cold_one_of_its_budget() {
    let cells = Cells { counts: [32, 32] };
    let cameras = around(8, cells.counts, 46);
    let truth = disc(cells.counts);
    let q = pictures(&cells, &cameras, &truth);
    let settings = Settings {
        budget: 200_000,
        warm_budget: 0.1,
        tolerance: 0.0,
        ..Settings::default()
    };
    let energy = |warm: bool| {
        let settings = if warm {
            settings
        } else {
            Settings {
                budget: 20_000,
                eps: Some(0.05),
                ..settings
            }
        };
        let problem = Tomography {
            cells,
            cameras: &cameras,
            novel: &[],
            settings,
        };
        let mut memory = Memory::new(Reconstruction::<f64, 2>::bytes(&problem).unwrap());
        let mut found = measured::<f64, 2>(problem, &q, &mut memory);
        found.begin(0, false).unwrap();
        while !found.advance(u64::MAX) {}
        if warm {
            found.begin(1, true).unwrap();
            assert_eq!(found.budget(), 20_000);
            while !found.advance(u64::MAX) {}
        }
        found.energy().total()
    };
    let (warm, cold) = (energy(true), energy(false));
    assert!(warm < cold, "{warm} for {cold}");
}

/// A camera that measured nothing, part of whose picture is beside the box.
fn beside() -> [Camera<2>; 2] {
    [0.7_f64, 2.2].map(|turn| Camera {
        lens: Lens::Orthographic {
            across: [turn.cos(), turn.sin()],
            down: [0.0; 2],
            at: [1.5 - turn.sin(), 0.5],
            forward: [-turn.sin(), turn.cos()],
            pitch: 1.0,
        },
        pixels: [9, 1],
    })
}

/// Gains of priors on novel views are differences of whole objectives, at the edges of their pictures too; with a volume and without, and
/// novel views beside a prior on cells.
#[test]
fn priors_on_novel_views_agree_with_plain_ones() {
    let cells = [12, 10];
    for (prior, rule, volume) in [
        (Prior::ImageSad, Rule::Patient, false),
        (Prior::ImageTv, Rule::Eager, false),
        (Prior::ImageSad, Rule::Eager, true),
        (Prior::Sad, Rule::Patient, true),
    ] {
        for nonnegative in [true, false] {
            let settings = Settings {
                volume,
                nonnegative,
                ..few(prior, rule)
            };
            agrees_with(cells, [&around(4, cells, 16), &beside()], &disc(cells), settings);
        }
    }
    let mut plain = Plain::new(21);
    let density: Vec<f64> = (0..7 * 7 * 9).map(|_| plain.unit()).collect();
    let mut novel = pair();
    novel.reverse();
    let Lens::Pinhole { at, .. } = &mut novel[1].lens else {
        unreachable!()
    };
    *at = [1.0, 2.0];
    for prior in [Prior::ImageSad, Prior::ImageTv] {
        let settings = Settings {
            volume: false,
            budget: 1500,
            ..few(prior, Rule::Patient)
        };
        agrees_with([7, 7, 9], [&pair(), &novel], &density, settings);
    }
}

/// dE of a prior on pictures is exact to rounding: the objective falls by the sum of all gains.
#[test]
fn the_objective_falls_by_what_was_gained() {
    let cells = Cells { counts: [18, 16] };
    let (cameras, novel) = (around(5, cells.counts, 24), beside());
    let q = pictures(&cells, &cameras, &disc(cells.counts));
    for prior in [Prior::ImageSad, Prior::ImageTv] {
        let settings = Settings {
            volume: false,
            budget: 20_000,
            ..few(prior, Rule::Eager)
        };
        let problem = Tomography {
            cells,
            cameras: &cameras,
            novel: &novel,
            settings,
        };
        let mut memory = Memory::new(Reconstruction::<f64, 2>::bytes(&problem).unwrap());
        let mut found = measured::<f64, 2>(problem, &q, &mut memory);
        found.begin(0, false).unwrap();
        let mut last = found.energy().total();
        while !found.advance(1) {
            let now = found.energy().total();
            assert!(now <= last + 1e-12 * last, "{prior:?}: {now} after {last}");
            last = now;
        }
        assert!(
            found
                .novel(0)
                .iter()
                .chain(found.novel(1))
                .all(|&pixel| pixel >= 0.0)
        );
    }
}

/// Without a volume a frame takes pixels alone, which no number of cells changes.
#[test]
fn novel_views_take_the_memory_of_their_pixels() {
    let (small, large) = (Cells { counts: [16, 12] }, Cells { counts: [64, 48] });
    let novel = beside();
    let up = |count: usize| (4 * count).next_multiple_of(64);
    for (volume, prior) in [
        (false, Prior::ImageSad),
        (true, Prior::ImageSad),
        (false, Prior::Sad),
    ] {
        for cells in [small, large] {
            let cameras = around(3, cells.counts, 20);
            let settings = Settings {
                volume,
                ..few(prior, Rule::Patient)
            };
            let problem = Tomography {
                cells,
                cameras: &cameras,
                novel: &novel,
                settings,
            };
            let kept = if volume || prior == Prior::Sad {
                up(cells.len())
            } else {
                0
            };
            let bytes = Reconstruction::<f32, 2>::bytes(&problem).unwrap();
            assert_eq!(bytes, 2 * up(3 * 20) + kept + up(2 * 9));
            let mut memory = Memory::new(bytes);
            let before = count();
            let mut found = Reconstruction::<f32, 2>::new(problem, memory.block()).unwrap();
            (0..3).for_each(|camera| found.measure(camera, &[1.0; 20]).unwrap());
            found.begin(0, false).unwrap();
            while !found.advance(500) {}
            core::hint::black_box((found.energy(), found.novel(1)));
            assert_eq!(count() - before, 0);
        }
    }
}

/// What the visual hull takes from the density after a sweep is missed by the residual: all of it, where nothing is in the hull.
#[test]
fn the_residual_of_sart_is_that_of_the_hull() {
    let cells = Cells { counts: [24, 24] };
    let cameras = around(8, cells.counts, 34);
    let q = pictures(&cells, &cameras, &disc(cells.counts));
    let problem = Tomography {
        cells,
        cameras: &cameras,
        novel: &[],
        settings: Settings {
            method: Method::Sart,
            sweeps: 2,
            hull_threshold: 1e9,
            ..Settings::default()
        },
    };
    let mut memory = Memory::new(Reconstruction::<f64, 2>::bytes(&problem).unwrap());
    let mut found = measured::<f64, 2>(problem, &q, &mut memory);
    found.begin(0, false).unwrap();
    let nothing = found.energy().total();
    while !found.advance(u64::MAX) {}
    assert!(found.density().iter().all(|&x| x == 0.0));
    assert_eq!(found.energy().total(), nothing);
}

/// What a novel view shows is F p of the density, where that is kept too: by the walk to rounding of the places of samples, by SART exactly.
#[test]
fn a_novel_view_shows_the_density() {
    let cells = Cells { counts: [24, 24] };
    let (cameras, novel) = (around(8, cells.counts, 34), around(1, cells.counts, 34));
    let q = pictures(&cells, &cameras, &disc(cells.counts));
    for (method, most) in [(Method::Walk, 0.06), (Method::Sart, 1e-12)] {
        let settings = Settings {
            method,
            budget: 100_000,
            ..Settings::default()
        };
        let problem = Tomography {
            cells,
            cameras: &cameras,
            novel: &novel,
            settings,
        };
        let mut memory = Memory::new(Reconstruction::<f64, 2>::bytes(&problem).unwrap());
        let mut found = measured::<f64, 2>(problem, &q, &mut memory);
        for (frame, warm) in [(0, false), (1, true)] {
            found.begin(frame, warm).unwrap();
            while !found.advance(u64::MAX) {}
            let mut shown = vec![0.0; 34];
            project(&cells, &novel[0], found.density(), 1.0, &mut shown);
            let far = shown
                .iter()
                .zip(found.novel(0))
                .map(|(a, b)| (a - b).powi(2))
                .sum::<f64>();
            let size = shown.iter().map(|a| a * a).sum::<f64>();
            assert!((far / size).sqrt() < most, "{method:?}: {}", (far / size).sqrt());
        }
    }
}

#[test]
fn novel_views_that_cannot_be_are_refused() {
    let cells = Cells { counts: [8, 8] };
    let cameras = around(2, cells.counts, 12);
    let mut novel = around(2, cells.counts, 12);
    let check = |novel: &[Camera<2>], settings| {
        let problem = Tomography {
            cells,
            cameras: &cameras,
            novel,
            settings,
        };
        problem.check()
    };
    let on_images = few(Prior::ImageTv, Rule::Patient);
    assert_eq!(check(&[], on_images), Err(TomographyError::NoNovel));
    assert_eq!(check(&novel, on_images), Ok(()));
    let warm = Settings {
        warm: true,
        volume: false,
        ..on_images
    };
    let refused = check(&novel, warm);
    assert!(matches!(
        refused,
        Err(TomographyError::Setting { name: "warm", .. })
    ));
    let Lens::Orthographic { at, .. } = &mut novel[1].lens else {
        unreachable!()
    };
    at[0] += 1000.0;
    let refused = check(&novel, on_images);
    assert_eq!(refused, Err(TomographyError::Novel { view: 1, blind: true }));
    novel[1].pixels = [0, 1];
    let refused = check(&novel, on_images);
    assert_eq!(
        refused,
        Err(TomographyError::Novel {
            view: 1,
            blind: false
        })
    );
}

//! What every picture must be, whatever its look.

use super::{Angles, Body, Drift, Shot, Smoke};

const CELLS: [usize; 3] = [9, 6, 8];

fn shot(width: usize, height: usize) -> Shot {
    Shot {
        width,
        height,
        angles: Angles::default(),
        gain: 1.0,
        detail: 0.0,
    }
}

/// A ball of smoke in the middle.
fn ball(cells: [usize; 3]) -> Vec<f32> {
    let [nx, ny, nz] = cells;
    let distance = |cell: usize| {
        let place = [cell % nx, cell / nx % ny, cell / (nx * ny)];
        let offset = |axis: usize| place[axis] as f32 + 0.5 - 0.5 * cells[axis] as f32;
        (0..3).map(|axis| offset(axis) * offset(axis)).sum::<f32>().sqrt()
    };
    let inside = |cell| (2.5 - distance(cell)).clamp(0.0, 1.0);
    (0..nx * ny * nz).map(inside).collect()
}

fn is_light(light: &[[f32; 3]]) -> bool {
    light
        .as_flattened()
        .iter()
        .all(|light| light.is_finite() && *light >= 0.0)
}

#[test]
fn an_empty_box_is_even_and_smoke_is_brighter_than_what_is_behind_it() {
    let empty = Smoke::new(&CELLS, vec![0.0; 432], 1.0, None).expose(&shot(64, 36));
    let smoke = Smoke::new(&CELLS, ball(CELLS), 1.0, None).expose(&shot(64, 36));
    assert!(is_light(&empty.light) && is_light(&smoke.light));
    let middle = 18 * 64 + 32;
    assert!(smoke.light[middle][0] > 5.0 * empty.light[middle][0]);
    // The corners of the picture see neither smoke nor its shadow.
    assert_eq!(smoke.light[0], empty.light[0]);
    assert_eq!(empty.develop().bytes.len(), 3 * 64 * 36);
}

#[test]
fn a_lamp_on_one_side_leaves_the_other_in_the_shade() {
    let film = Smoke::new(&[24, 24, 24], ball_of(24), 1.0, None).expose(&Shot {
        angles: Angles {
            azimuth: 0.0,
            elevation: 0.0,
        },
        ..shot(80, 80)
    });
    let mean = |columns: core::ops::Range<usize>| {
        let row = &film.light[40 * 80..][..80];
        columns.map(|column| row[column][0]).sum::<f32>()
    };
    assert!(
        mean(24..40) > 1.3 * mean(40..56),
        "{} {}",
        mean(24..40),
        mean(40..56)
    );
}

/// A ball that fills a box of `count` cells a side by half.
fn ball_of(count: usize) -> Vec<f32> {
    let distance = |cell: usize| {
        let offset = |place: usize| place as f32 + 0.5 - 0.5 * count as f32;
        let (x, y, z) = (cell % count, cell / count % count, cell / (count * count));
        offset(x).hypot(offset(y)).hypot(offset(z))
    };
    let radius = 0.3 * count as f32;
    (0..count.pow(3))
        .map(|cell| (radius - distance(cell)).clamp(0.0, 1.0))
        .collect()
}

#[test]
fn numbers_that_are_none_and_boxes_of_one_cell_are_drawn() {
    let mut density = ball(CELLS);
    density[0] = f32::NAN;
    density[1] = f32::INFINITY;
    density[2] = -1.0;
    assert!(is_light(
        &Smoke::new(&CELLS, density, 0.0, None).expose(&shot(20, 30)).light
    ));
    for cells in [[1, 1, 1], [1, 5, 3], [40, 1, 2]] {
        let count = cells.iter().product();
        let smoke = Smoke::new(
            &cells,
            vec![1.0; count],
            1.0,
            Body::new(&cells, &vec![1.0; count]),
        );
        assert!(is_light(&smoke.expose(&shot(16, 9)).light));
        assert!(!smoke.photograph().bytes.is_empty());
    }
}

#[test]
fn a_body_hides_smoke_and_is_seen() {
    let solid: Vec<f32> = (0..432)
        .map(|cell| f32::from(u8::from((cell / 9) % 6 == 1)))
        .collect();
    let body = Body::new(&CELLS, &solid);
    let behind = |density| Smoke::new(&CELLS, density, 1.0, body.clone()).expose(&shot(64, 36));
    let (plate, alone) = (behind(ball(CELLS)), behind(vec![0.0; 432]));
    assert!(alone.light[18 * 64 + 32][0] > 0.01);
    let change = |pixel: usize| (plate.light[pixel][0] - alone.light[pixel][0]).abs();
    assert!(change(18 * 64 + 32) < 0.5 * alone.light[18 * 64 + 32][0]);
}

#[test]
fn any_number_of_threads_draws_the_same() {
    let drawn = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        let Ok(pool) = pool else {
            unreachable!("threads can be started")
        };
        pool.install(|| {
            let mut drift = Drift::new(CELLS);
            for _ in 0..30 {
                drift.follow(&[[0.4, 0.1, -0.3]; 432]);
            }
            let smoke = Smoke::new(&CELLS, ball(CELLS), 1.0, None);
            let film = smoke.with_detail(drift, 0.8).expose(&shot(64, 36));
            assert!(is_light(&film.light));
            film.develop().bytes
        })
    };
    assert!(drawn(1) == drawn(2) && drawn(1) == drawn(3));
}

/// Smoke that a side of the box cuts has an even edge: next to each other no pixel is dark and the next one bright.
#[test]
fn smoke_at_a_side_of_the_box_has_an_even_edge() {
    let front = Angles {
        azimuth: 0.0,
        elevation: 0.0,
    };
    let count: usize = 16;
    let slab = |cell: usize| f32::from(u8::from(cell / count.pow(2) >= 8 && cell % count >= 8));
    let density = (0..count.pow(3)).map(slab).collect();
    let film = Smoke::new(&[count; 3], density, 1.0, None).expose(&Shot {
        angles: front,
        ..shot(240, 240)
    });
    let brightness = |column: usize, row: usize| film.light[row * 240 + column][0];
    // Down the right side of the slab, where rays pass through a corner of it, from its inside to where it is not seen.
    let of_column = |column: usize| -> f32 {
        let rows = 30..90;
        let jumps = rows.map(|row| (brightness(column, row) - brightness(column, row + 1)).abs());
        jumps.fold(0.0, f32::max)
    };
    let brightest = film.light.iter().map(|light| light[0]).fold(0.0, f32::max);
    let worst = (180..240).map(of_column).fold(0.0, f32::max);
    assert!(worst < 0.25 * brightest, "{worst} of {brightest}");
}

/// What a plane sends is no number of a byte.
#[test]
fn a_plane_has_more_than_the_levels_of_a_byte() {
    let density: Vec<f32> = (0..1600).map(|cell| (cell % 40) as f32 / 40.0).collect();
    let film = Smoke::new(&[40, 40], density, 1.0, None).expose(&shot(400, 400));
    let mut reds: Vec<u32> = film.light.iter().map(|light| light[0].to_bits()).collect();
    reds.sort_unstable();
    reds.dedup();
    assert!(reds.len() > 1000, "{}", reds.len());
}

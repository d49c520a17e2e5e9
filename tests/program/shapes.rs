//! Shapes have the mass, the place and the look that their words promise.

use core::f64::consts::PI;
use std::path::Path;

use thurible::keyframes::{Canvas, ShapeSpec};

fn canvas(cells: &[usize], periodic: bool, length: f64) -> Canvas {
    Canvas {
        cells: cells.to_vec(),
        periodic: vec![periodic; cells.len()],
        length,
    }
}

fn draw(shape: &str, canvas: &Canvas) -> Vec<f64> {
    let spec: ShapeSpec = toml::from_str(shape).unwrap();
    spec.rasterise(canvas, Path::new("")).unwrap()
}

fn mass(cells: &[f64]) -> f64 {
    cells.iter().sum()
}

/// Middle of the mass in cells, per axis.
fn middle(cells: &[f64], canvas: &Canvas) -> Vec<f64> {
    let mut stride = 1;
    let mut middle = Vec::new();
    for &count in &canvas.cells {
        let place = |(index, value): (usize, &f64)| value * ((index / stride % count) as f64 + 0.5);
        middle.push(cells.iter().enumerate().map(place).sum::<f64>() / mass(cells));
        stride *= count;
    }
    middle
}

/// A plane of cells as a picture, y up: one letter a cell, from empty to full.
fn picture(cells: &[f64], width: usize) -> String {
    let letter = |value: &f64| b".-+#"[(value * 3.999).clamp(0.0, 3.0) as usize] as char;
    let rows = cells
        .chunks(width)
        .rev()
        .map(|row| row.iter().map(letter).collect::<String>());
    rows.collect::<Vec<_>>().join("\n")
}

fn near(found: f64, expected: f64, tolerance: f64) {
    assert!(
        (found / expected - 1.0).abs() < tolerance,
        "{found} is not {expected}"
    );
}

#[test]
fn masses_are_areas_and_volumes() {
    let flat = canvas(&[96, 96], false, 1.0);
    let h2 = 96.0 * 96.0;
    near(
        mass(&draw("circle = { center = [0.5, 0.5], radius = 0.2 }", &flat)),
        PI * 0.04 * h2,
        0.01,
    );
    near(
        mass(&draw("box = { min = [0.2, 0.3], max = [0.6, 0.8] }", &flat)),
        0.2 * h2,
        0.01,
    );
    near(
        mass(&draw(
            "torus = { center = [0.5, 0.5], radius = 0.3, tube = 0.05 }",
            &flat,
        )),
        2.0 * PI * 0.3 * 0.1 * h2,
        0.01,
    );
    let capsule = "capsule = { from = [0.3, 0.5], to = [0.7, 0.5], radius = 0.1 }";
    near(mass(&draw(capsule, &flat)), (0.4 * 0.2 + PI * 0.01) * h2, 0.01);
    let deep = canvas(&[48, 48, 48], false, 1.0);
    let h3 = 48.0_f64.powi(3);
    near(
        mass(&draw("sphere = { center = [0.5, 0.5], radius = 0.3 }", &deep)),
        4.0 / 3.0 * PI * 0.027 * h3,
        0.02,
    );
    near(
        mass(&draw(
            "torus = { center = [0.5, 0.5], axis = [1, 1, 0], radius = 0.25, tube = 0.1 }",
            &deep,
        )),
        2.0 * PI * PI * 0.25 * 0.01 * h3,
        0.05,
    );
}

#[test]
fn lengths_are_in_the_unit_of_the_longest_side() {
    let small = draw(
        "circle = { center = [0.25, 0.5], radius = 0.2 }",
        &canvas(&[32, 48], false, 1.0),
    );
    let large = draw(
        "circle = { center = [2.5, 5.0], radius = 2.0 }",
        &canvas(&[32, 48], false, 10.0),
    );
    assert!(
        small
            .iter()
            .zip(&large)
            .all(|(one, other)| (one - other).abs() < 1e-9)
    );
}

#[test]
fn centres_are_where_they_were_put() {
    let deep = canvas(&[32, 24, 16], false, 1.0);
    let ball = draw("sphere = { center = [0.3, 0.4, 0.2], radius = 0.1 }", &deep);
    for (found, expected) in middle(&ball, &deep).iter().zip([0.3, 0.4, 0.2]) {
        assert!((found / 32.0 - expected).abs() < 2e-3, "{found}");
    }
    let middle_height = middle(
        &draw("sphere = { center = [0.3, 0.4], radius = 0.1 }", &deep),
        &deep,
    )[2];
    assert!((middle_height - 8.0).abs() < 1e-6);
}

#[test]
fn periodic_axes_wrap() {
    let walls = draw(
        "circle = { center = [0, 0], radius = 0.2 }",
        &canvas(&[64, 64], false, 1.0),
    );
    let torus = draw(
        "circle = { center = [0, 0], radius = 0.2 }",
        &canvas(&[64, 64], true, 1.0),
    );
    near(mass(&torus), 4.0 * mass(&walls), 0.01);
    near(mass(&torus), PI * 0.04 * 4096.0, 0.01);
    let word = draw("text = \"F\"\ncenter = [0.0, 0.5]", &canvas(&[64, 64], true, 1.0));
    near(
        mass(&word),
        mass(&draw("text = \"F\"", &canvas(&[64, 64], true, 1.0))),
        0.02,
    );
}

/// A layer all the way round a ring has no seam; on walls its ends are soft.
#[test]
fn a_box_round_a_ring_has_no_ends() {
    let layer = "box = { min = [0, 0.25], max = [1, 0.75] }";
    let middle = |periodic| draw(layer, &canvas(&[16, 16], periodic, 1.0))[8 * 16..9 * 16].to_vec();
    assert!(
        middle(true).iter().all(|&value| value > 0.999),
        "{:?}",
        middle(true)
    );
    assert!(middle(false)[0] < 0.8);
}

#[test]
fn edges_are_smooth_over_one_cell() {
    let row = draw(
        "box = { min = [0.25, -9], max = [2, 9] }",
        &canvas(&[16, 16], false, 1.0),
    );
    for (index, found) in row[..8].iter().enumerate() {
        let expected = 0.5 - 0.5 * (4.0 - (index as f64 + 0.5)).tanh();
        assert!((found - expected).abs() < 1e-9, "cell {index}: {found}");
    }
}

#[test]
fn unions_add_up_and_are_clipped() {
    let flat = canvas(&[48, 48], false, 1.0);
    let twice = "shapes = [{ circle = { center = [0.5, 0.5], radius = 0.2 } }, { circle = { center = [0.5, 0.5], radius = 0.2 }, density = 0.25 }]";
    let twice = draw(twice, &flat);
    assert!(twice.iter().all(|&value| value <= 1.0));
    assert!((twice[24 * 48 + 24] - 1.0).abs() < 1e-9);
    let faint = draw(
        "circle = { center = [0.5, 0.5], radius = 0.2 }\ndensity = 0.25",
        &flat,
    );
    assert!((faint[24 * 48 + 24] - 0.25).abs() < 1e-3);
    let within = "shapes = [{ shapes = [{ circle = { center = [0.5, 0.5], radius = 0.2 }, density = 3.0 }] }, { circle = { center = [0.1, 0.1], radius = 0.1 } }]";
    assert!((draw(within, &flat)[24 * 48 + 24] - 3.0).abs() < 1e-3);
}

#[test]
fn a_letter_reads_as_itself() {
    let cells = draw("text = \"F\"\nheight = 0.9", &canvas(&[20, 20], false, 1.0));
    let expected = "\
....------------....
...-++++++++++++-...
...-############-...
...-############-...
...-####++++++++-...
...-####-...........
...-####-...........
...-####--------....
...-###########+....
...-###########+....
...-###########+....
...-####--------....
...-####-...........
...-####-...........
...-####-...........
...-####-...........
...-####-...........
...-####-...........
...-++++-...........
....-----...........";
    assert_eq!(picture(&cells, 20), expected, "\n{}", picture(&cells, 20));
}

/// A font has no glyph for them, and the box that stands for that is no ink.
#[test]
fn tabs_are_blank() {
    let canvas = canvas(&[96, 32], false, 3.0);
    let of = |text: &str| mass(&draw(&format!("text = \"{text}\"\nheight = 0.5"), &canvas));
    let blank = of("H H");
    for tab in ["\\t", "\\u000B", "\\f", "\\u0085"] {
        near(of(&format!("H{tab}H")), blank, 0.02 * blank);
    }
}

#[test]
fn text_is_centred_and_fits() {
    let flat = canvas(&[64, 64], false, 1.0);
    let letter = draw("text = \"F\"", &flat);
    let inked: Vec<usize> = (0..64)
        .filter(|row| letter[row * 64..][..64].iter().any(|&value| value > 0.5))
        .collect();
    assert_eq!((inked.first(), inked.last()), (Some(&16), Some(&47)));
    let word = draw("text = \"SMOKE\"", &flat);
    let margin = |column: usize| (0..64).all(|row| word[row * 64 + column] < 0.1);
    assert!(margin(4) && margin(59) && !margin(8) && !margin(55));
    let bold = draw("text = \"F\"\nweight = 0.2", &flat);
    assert!(mass(&bold) > 1.4 * mass(&letter));
}

#[test]
fn text_in_a_box_stands_upright_and_is_extruded_along_y() {
    let deep = canvas(&[24, 20, 24], false, 1.0);
    let cells = draw("text = \"F\"\ndepth = 0.25", &deep);
    let flat = draw("text = \"F\"", &canvas(&[24, 24], false, 1.0));
    let slice: Vec<f64> = (0..24)
        .flat_map(|z| cells[(z * 20 + 10) * 24..][..24].to_vec())
        .collect();
    assert_eq!(picture(&slice, 24), picture(&flat, 24));
    near(mass(&cells), mass(&flat) * 6.0, 0.2);
}

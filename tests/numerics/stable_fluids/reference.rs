//! Arrays that two other programs agree on: densities, the last velocity, J, and its gradient by every input.

use super::case::{built, replay};
use crate::fields::Memory;
use crate::npz::{Array, read_without};
use std::collections::BTreeMap;
use std::path::Path;
use thurible_core::stable_fluids::{Control, Controls, FluidsParams, Pressure, Slots};
use thurible_core::words::Named;
use thurible_core::{Boundary, D2, D3, Fluids, Problem, Serial, Silent, Space, Template, TemplateKind};

/// Relative differences of all outputs are below this.
const CLOSE: f64 = 1e-10;

struct Reference {
    arrays: BTreeMap<String, Array>,
    meta: serde_json::Value,
}

impl Reference {
    fn number(&self, key: &str) -> f64 {
        self.meta[key].as_f64().unwrap()
    }

    fn data(&self, name: &str) -> &[f64] {
        &self.arrays[name].data
    }

    fn template(&self, index: usize) -> Template {
        let own = &self.meta["templates"][index];
        let kind = own["kind"].as_str().unwrap();
        let step = |key: &str| own[key].as_u64().unwrap() as usize;
        let mut center = [0.0; 3];
        let given = self.data(&format!("{kind}_centre"));
        center[..given.len()].copy_from_slice(given);
        Template {
            from: step("from"),
            interval: step("interval"),
            moves: true,
            ..Template::new(
                TemplateKind::from_name(kind).unwrap(),
                center,
                own["radius"].as_f64().unwrap(),
                step("to"),
            )
        }
    }
}

fn close(name: &str, found: &[f64], expected: &[f64]) {
    assert_eq!(found.len(), expected.len(), "{name}");
    let largest = expected.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
    let worst = found
        .iter()
        .zip(expected)
        .fold(0.0, |most: f64, (x, y)| most.max((x - y).abs()));
    assert!(worst <= CLOSE * largest, "{name}: {:e}", worst / largest);
}

fn agrees<S: Space>(name: &str, slots: Slots) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("reference");
    let arrays = read_with_text(&folder.join(name));
    let reference = Reference {
        meta: serde_json::from_str(&arrays.1).unwrap(),
        arrays: arrays.0,
    };
    let list = |key: &str| reference.meta[key].as_array().unwrap().clone();
    let cells: Vec<usize> = list("cells")
        .iter()
        .map(|n| n.as_u64().unwrap() as usize)
        .collect();
    let boundary: Vec<Boundary> = list("boundary")
        .iter()
        .map(|end| Boundary::from_name(end.as_str().unwrap()).unwrap())
        .collect();
    let keys: Vec<usize> = reference
        .data("keyframe_step")
        .iter()
        .map(|&step| step as usize)
        .collect();
    let templates = [reference.template(0), reference.template(1)];
    let mut buoyancy = [0.0; 3];
    buoyancy[S::DIM - 1] = reference.number("buoyancy");
    let problem = Problem {
        steps: reference.number("steps") as usize,
        templates: &templates,
        buoyancy,
        viscosity: reference.number("viscosity"),
        force_weight: reference.number("force_weight"),
        filters: Some(reference.number("filters") as usize),
        match_mass: false,
        ..Problem::new(&cells, &boundary, &keys)
    };
    let everything = [Control::InitialVelocity, Control::Forces, Control::Templates];
    let params = FluidsParams {
        controls: everything.into_iter().fold(Controls::none(), Controls::with),
        pressure: if reference.meta["pressure"] == "cg" {
            Pressure::Conjugate
        } else {
            Pressure::GaussSeidel
        },
        sweeps: reference.number("sweeps") as usize,
        cg_iterations: reference.meta["cg_iterations"].as_u64().unwrap_or(200) as usize,
        cg_tolerance: reference.meta["cg_tolerance"].as_f64().unwrap_or(1e-5),
        diffusion: reference.number("diffusion"),
        initial_weight: reference.number("initial_weight"),
        slots,
        ..FluidsParams::default()
    };
    let (count, steps, dims) = (cells.iter().product::<usize>(), problem.steps, S::DIM);
    let mut memory = Memory::new(built::<f64, S>(&problem, &params).unwrap());
    let mut fluids = Fluids::<f64, S>::new(&problem, &params, memory.block()).unwrap();
    fluids.set_source(reference.data("source")).unwrap();
    for (index, keyframe) in reference.data("keyframe_density").chunks(count).enumerate() {
        fluids.set_keyframe(index, keyframe).unwrap();
    }
    // v_0 = z/N, f = z/N^2, a = z/N^2.
    let n = steps as f64;
    let mut z: Vec<f64> = reference.data("initial_velocity").iter().map(|v| v * n).collect();
    z.extend(reference.data("force").iter().map(|f| f * n * n));
    for kind in ["wind", "vortex"] {
        z.extend(
            reference
                .data(&format!("{kind}_amplitude"))
                .iter()
                .map(|a| a * n * n),
        );
        z.extend(vec![0.0; dims + 1]);
    }
    fluids.unknowns_mut().copy_from_slice(&z);

    let mut densities = Vec::new();
    let mut last = vec![Vec::new(); dims];
    replay(&mut fluids, |mut moment| {
        densities.extend_from_slice(moment.density());
        for (axis, last) in last.iter_mut().enumerate() {
            *last = moment.velocity(axis).to_vec();
        }
    });
    close("density", &densities, reference.data("density"));
    close("final_velocity", &last.concat(), reference.data("final_velocity"));

    let objective = fluids.value(&Serial, &mut Silent).unwrap();
    let given = |key: &str| reference.meta["objective"][key].as_f64().unwrap();
    close(
        "objective",
        &[
            objective.data,
            objective.force,
            objective.initial,
            objective.total(),
        ],
        &[given("data"), given("force"), given("initial"), given("total")],
    );

    let mut gradient = vec![0.0; z.len()];
    fluids.gradient(&Serial, &mut Silent, &mut gradient).unwrap();
    let mut rest = &gradient[..];
    let mut next = |count: usize, unit: f64| -> Vec<f64> {
        let (own, behind) = rest.split_at(count);
        rest = behind;
        own.iter().map(|g| g * unit).collect()
    };
    close(
        "by v_0",
        &next(dims * count, n),
        reference.data("gradient_initial_velocity"),
    );
    close(
        "by f",
        &next(steps * dims * count, n * n),
        reference.data("gradient_force"),
    );
    for (template, kind) in templates.iter().zip(["wind", "vortex"]) {
        for (part, unit) in [
            ("amplitude", n * n),
            ("centre", 1.0 / template.radius),
            ("radius", 1.0 / template.radius),
        ] {
            let name = format!("gradient_{kind}_{part}");
            let expected = reference.data(&name);
            close(&name, &next(expected.len(), unit), expected);
        }
    }
}

/// All arrays of numbers, and the text `meta`.
fn read_with_text(path: &Path) -> (BTreeMap<String, Array>, String) {
    let arrays = read_without(path, &["meta"]);
    let mut archive = zip::ZipArchive::new(std::fs::File::open(path).unwrap()).unwrap();
    let mut bytes = Vec::new();
    std::io::Read::read_to_end(&mut archive.by_name("meta.npy").unwrap(), &mut bytes).unwrap();
    let start = 10 + usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
    let letters = bytes[start..]
        .as_chunks()
        .0
        .iter()
        .map(|&letter| u32::from_le_bytes(letter));
    (arrays, letters.filter_map(char::from_u32).collect())
}

#[test]
fn gauss_seidel_in_2d_agrees() {
    agrees::<D2>("stable_fluids_2d_gs.npz", Slots::Tape);
    agrees::<D2>("stable_fluids_2d_gs.npz", Slots::States(2));
}

#[test]
fn conjugate_gradients_in_2d_agree() {
    agrees::<D2>("stable_fluids_2d_cg.npz", Slots::Tape);
    agrees::<D2>("stable_fluids_2d_cg.npz", Slots::States(2));
}

#[test]
fn gauss_seidel_in_3d_agrees() {
    agrees::<D3>("stable_fluids_3d_gs.npz", Slots::Tape);
    agrees::<D3>("stable_fluids_3d_gs.npz", Slots::States(2));
}

//! The library as a WebAssembly module, in an engine with a memory maximum; and the page of `examples/web`, which uses it.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test says what went wrong by panicking"
)]

mod support;

use std::fs;
use support::header::{code, functions, structure};
use support::others;
use support::scene::Scene;
use support::{module, root};
use thurible_core::simd::{Level, limit};
use thurible_core::{D2, D3, Method, Real, Space};
use wasmi::ExternType;

/// The scene of `examples/web/check.js`.
fn small() -> Scene {
    Scene {
        cells: vec![16, 16],
        steps: 6,
        method: Method::Direct,
        iterations: 4,
    }
}

fn web(name: &str) -> String {
    fs::read_to_string(root().join("examples/web").join(name)).unwrap()
}

#[test]
fn the_module_imports_nothing_and_exports_the_interface() {
    let Some(module) = module() else { return };
    assert_eq!(
        module
            .imports()
            .map(|import| import.name().to_owned())
            .collect::<Vec<_>>(),
        [""; 0]
    );
    let functions = functions();
    assert!(functions.len() > 15, "thurible.h has {functions:?}");
    for name in functions {
        assert!(
            matches!(module.get_export(&name), Some(ExternType::Func(_))),
            "{name} is not exported"
        );
    }
    assert!(
        matches!(module.get_export("memory"), Some(ExternType::Memory(memory)) if memory.maximum().is_none())
    );
    assert!(matches!(
        module.get_export("__heap_base"),
        Some(ExternType::Global(_))
    ));
}

#[test]
fn exactly_the_pages_are_needed() {
    let Some(module) = module() else { return };
    let scene = small();
    let needs = scene.needs::<f32>(module);
    limit(Level::Baseline);
    assert!(
        scene.in_module::<f32>(module, needs) == scene.native::<f32, D2>(),
        "other bits"
    );
    assert_eq!(
        scene.refused::<f32>(module, needs),
        (true, code("THURIBLE_RESULT_TOO_SMALL"))
    );
}

fn agree<T: Real, S: Space>(scene: &Scene) {
    let Some(module) = module() else { return };
    limit(Level::Baseline);
    let native = scene.native::<T, S>();
    assert!(
        scene.in_module::<T>(module, scene.needs::<T>(module)) == native,
        "other bits: {} in {scene:?}",
        T::NAME
    );
}

#[test]
fn the_same_bits_in_every_precision_and_dimension() {
    agree::<f64, D2>(&Scene {
        method: Method::Admm,
        iterations: 2,
        ..small()
    });
    agree::<f32, D3>(&Scene {
        cells: vec![16, 14, 6],
        steps: 3,
        iterations: 2,
        ..small()
    });
    agree::<f64, D3>(&Scene {
        cells: vec![16, 14, 6],
        steps: 3,
        method: Method::Admm,
        iterations: 1,
    });
}

/// A search by Stable Fluids that is saved and restored, an operator and its gradient, an elastic body.
#[test]
fn the_same_bits_of_everything_else() {
    let Some(module) = module() else { return };
    limit(Level::Baseline);
    assert!(
        others::search_in_module(module) == others::native_search(),
        "of a search"
    );
    assert!(
        others::operator_in_module(module) == others::native_operator(),
        "of an operator"
    );
    assert!(
        others::body_in_module(module) == others::native_body(),
        "of a body"
    );
}

/// The page declares the structures by hand.
#[test]
fn the_page_declares_what_the_header_does() {
    let script = web("thurible.js");
    for (constant, name) in [
        ("CONFIG", "ThuribleConfig"),
        ("EMITTER", "ThuribleEmitter"),
        ("FACTOR", "ThuribleFactor"),
        ("TEMPLATE", "ThuribleTemplate"),
        ("PROGRESS", "ThuribleProgress"),
    ] {
        let declared = script
            .split(&format!("const {constant} = layout(`"))
            .nth(1)
            .unwrap()
            .split('`')
            .next()
            .unwrap();
        let fields = declared
            .split(';')
            .map(|field| field.split_whitespace().collect::<Vec<_>>().join(" "));
        let declared: Vec<String> = fields.filter(|field| !field.is_empty()).collect();
        assert_eq!(
            declared,
            structure(name)
                .0
                .into_iter()
                .map(|field| field.declaration)
                .collect::<Vec<_>>(),
            "{name}"
        );
    }
    let status = script
        .split("STATUS = {")
        .nth(1)
        .unwrap()
        .split('}')
        .next()
        .unwrap();
    for (name, number) in status.split(',').map(|pair| pair.split_once(':').unwrap()) {
        assert_eq!(
            number.trim().parse(),
            Ok(code(&format!("THURIBLE_STATUS_{}", name.trim()))),
            "{name}"
        );
    }
}

/// A browser must find the densities that this machine finds: their hash is written in the page's own check.
#[test]
fn the_page_expects_the_bits_of_this_machine() {
    let words = small().native::<f32, D2>();
    let hash = words.chunks_exact(4).fold(0x811C_9DC5_u32, |hash, word| {
        (hash ^ u32::from_le_bytes(word.try_into().unwrap())).wrapping_mul(0x0100_0193)
    });
    let expected = format!("const BITS = 0x{hash:08x};");
    assert!(
        web("check.js").contains(&expected),
        "examples/web/check.js should say: {expected}"
    );
}

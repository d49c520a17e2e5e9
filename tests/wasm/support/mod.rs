//! What the tests of the WebAssembly module share: building it, reading the header, and a host with a memory maximum.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test says what went wrong by panicking"
)]

pub mod header;
pub mod others;
pub mod scene;

use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;
use wasmi::errors::MemoryError;
use wasmi::{Engine, Func, Instance, Linker, Memory, Module, Store, StoreLimits, StoreLimitsBuilder, Val};

/// Bytes of a page.
pub const PAGE: u32 = 65536;
/// What every block begins on a multiple of.
pub const LINE: u32 = 64;
/// What has a core, no instructions beyond the first version of WebAssembly, and no host.
const TARGET: &str = "wasm32v1-none";

pub fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// The module, or nothing, once it was said why, where it cannot be built.
pub fn module() -> Option<&'static Module> {
    static MODULE: OnceLock<Option<Module>> = OnceLock::new();
    let module = MODULE.get_or_init(|| {
        if !has_target() {
            // Not captured by the test harness, as what macros print is.
            io::stderr()
                .write_all(format!("SKIPPED the WebAssembly module: rustup target add {TARGET}\n").as_bytes())
                .unwrap();
            return None;
        }
        Some(Module::new(&Engine::default(), std::fs::read(build()).unwrap()).unwrap())
    });
    module.as_ref()
}

fn has_target() -> bool {
    let sysroot = Command::new("rustc")
        .args(["--print", "sysroot"])
        .output()
        .unwrap()
        .stdout;
    Path::new(String::from_utf8(sysroot).unwrap().trim())
        .join("lib/rustlib")
        .join(TARGET)
        .exists()
}

/// Compiled quickly: the interpreter decides how fast it is.
fn build() -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("wasm");
    let mut cargo = Command::new(env!("CARGO"));
    cargo.current_dir(root()).args([
        "rustc",
        "--release",
        "--locked",
        "--manifest-path",
        "core/ffi/Cargo.toml",
        "--target-dir",
    ]);
    cargo
        .arg(&folder)
        .args(["--target", TARGET, "--crate-type", "cdylib"]);
    cargo.envs([
        ("CARGO_PROFILE_RELEASE_LTO", "off"),
        ("CARGO_PROFILE_RELEASE_OPT_LEVEL", "1"),
        ("CARGO_PROFILE_RELEASE_CODEGEN_UNITS", "16"),
    ]);
    let output = cargo.output().unwrap();
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    folder.join(TARGET).join("release/thurible.wasm")
}

/// A host: the module in an engine that refuses to give it more than some pages.
pub struct Host {
    store: Store<StoreLimits>,
    instance: Instance,
    memory: Memory,
    end: u32,
}

impl Host {
    /// An instance of `module` with at most `pages` pages.
    pub fn new(module: &Module, pages: u32) -> Self {
        let engine = module.engine();
        let limits = StoreLimitsBuilder::new()
            .memory_size((pages * PAGE) as usize)
            .build();
        let mut store = Store::new(engine, limits);
        store.limiter(|limits| limits);
        let instance = Linker::new(engine)
            .instantiate_and_start(&mut store, module)
            .unwrap();
        let memory = instance.get_memory(&store, "memory").unwrap();
        let end = instance
            .get_global(&store, "__heap_base")
            .unwrap()
            .get(&store)
            .i32()
            .unwrap();
        Host {
            store,
            instance,
            memory,
            end: u32::try_from(end).unwrap(),
        }
    }

    /// Calls a function whose arguments are all pointers, sizes and codes.
    pub fn call(&mut self, name: &str, arguments: &[u32]) -> u32 {
        let function: Func = self
            .instance
            .get_func(&self.store, name)
            .unwrap_or_else(|| panic!("there is no {name}"));
        let arguments: Vec<Val> = arguments
            .iter()
            .map(|&argument| Val::I32(argument.cast_signed()))
            .collect();
        let mut results = [Val::I32(0)];
        function
            .call(&mut self.store, &arguments, &mut results)
            .unwrap_or_else(|error| panic!("{name}: {error}"));
        results[0].i32().unwrap().cast_unsigned()
    }

    /// The next `bytes` bytes behind what is taken; the memory grows where it must.
    ///
    /// # Errors
    /// What the engine says when it does not give them.
    pub fn take(&mut self, bytes: u32) -> Result<u32, MemoryError> {
        let at = self.next();
        let missing = (at + bytes).div_ceil(PAGE).saturating_sub(self.pages());
        self.memory.grow(&mut self.store, u64::from(missing))?;
        self.end = at + bytes;
        Ok(at)
    }

    /// Pages that the memory has.
    pub fn pages(&self) -> u32 {
        u32::try_from(self.memory.size(&self.store)).unwrap()
    }

    /// Where the next block begins.
    pub fn next(&self) -> u32 {
        self.end.next_multiple_of(LINE)
    }

    /// The first `bytes` bytes at an address.
    pub fn read(&self, at: u32, bytes: usize) -> &[u8] {
        &self.memory.data(&self.store)[at as usize..][..bytes]
    }

    /// A number of four bytes.
    pub fn word(&self, at: u32) -> u32 {
        u32::from_le_bytes(self.read(at, 4).try_into().unwrap())
    }

    /// Writes `bytes` to the module's memory.
    pub fn write(&mut self, at: u32, bytes: &[u8]) {
        self.memory.write(&mut self.store, at as usize, bytes).unwrap();
    }
}

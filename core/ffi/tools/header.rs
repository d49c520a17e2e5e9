//! Makes `core/ffi/thurible.h` from the C interface. With `--check` it writes nothing and fails where the file is not current.
//!
//! `cargo run --manifest-path core/ffi/tools/Cargo.toml --bin header [-- --check]`

use std::path::Path;
use std::process::ExitCode;

fn main() -> ExitCode {
    let check = std::env::args().nth(1).as_deref() == Some("--check");
    match header(check) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("header: {error}");
            ExitCode::FAILURE
        }
    }
}

fn header(check: bool) -> Result<(), Box<dyn core::error::Error>> {
    let own = Path::new(env!("CARGO_MANIFEST_DIR"));
    let ffi = own.parent().ok_or("this crate is nowhere")?;
    let config = cbindgen::Config::from_file(own.join("cbindgen.toml"))?;
    let mut builder = cbindgen::Builder::new().with_config(config);
    // In the order of the header.
    for source in [
        "result.rs",
        "config/mod.rs",
        "host.rs",
        "instance/mod.rs",
        "calls/make.rs",
        "calls/inputs.rs",
        "calls/solve.rs",
        "calls/save.rs",
        "text.rs",
        "outputs.rs",
        "fields.rs",
        "facts.rs",
        "templates.rs",
        "track/mod.rs",
        "tomography/mod.rs",
        "steps.rs",
        "fluids/mod.rs",
        "operator/mod.rs",
        "condense/mod.rs",
    ] {
        builder = builder.with_src(ffi.join(source));
    }
    let mut bytes = Vec::new();
    builder.generate()?.write(&mut bytes);
    let (path, text) = (
        ffi.join("thurible.h"),
        with_plain_comments(&String::from_utf8(bytes)?),
    );
    if !check {
        return Ok(std::fs::write(path, text)?);
    }
    if std::fs::read_to_string(&path)? == text {
        Ok(())
    } else {
        Err(format!("{} is not current; run this without --check", path.display()).into())
    }
}

/// C has no headings in comments.
fn with_plain_comments(text: &str) -> String {
    text.replace("//\n// # Safety\n// ", "// Safety: ")
}

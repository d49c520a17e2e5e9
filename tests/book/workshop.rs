//! The folder in which a page's commands run: the examples on few cells and with few iterations, a result, views, and programs named
//! `thurible` and `cargo` that make what a command asks for small.

use super::root;
use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::OnceLock;
use toml::{Table, Value};

/// What stands in synopses for what a reader puts there.
const STANDS_FOR: [(&str, &str); 14] = [
    ("SCENE.toml", "scene.toml"),
    ("SCENE", "scene.toml"),
    ("PRESET", "stretch"),
    ("CAPTURE", "out/scene"),
    ("VIEWS", "captured"),
    ("IMAGE", "photo.png"),
    ("FILE", "walls.toml"),
    ("NAME", "letter_f"),
    ("DIR", "out/scene"),
    ("PNG", "scene.png"),
    ("NU", "1e-4"),
    ("X", "disc:2"),
    ("W", "8"),
    ("K", "4"),
];

/// `thurible` as the pages call it: the program with less to do. Exit code 5, stalled, is no failure of a solve that is cut short.
const THURIBLE: &str = r#"#!/usr/bin/env bash
more=()
case ${1-} in
    # Lines of a block are often alternatives, and may leave the same folder.
    solve|simulate|guide|compare|paper|thesis) more=(--force) ;;
    condense) [[ " $* " == *" --list "* ]] || more=(--force --set time.steps=1) ;;
    render)
        [[ " $* " == *" --size "* ]] || more=(--size 96x96)
        [[ " $* " != *" --scale "* || " $* " == *" --steps "* ]] || more+=(--steps 0..1) ;;
    tomography) more=(--set tomography.budget=1e5) ;;
esac
arguments=()
for argument; do
    case $argument in
        method.iterations=*) argument=method.iterations=2 ;;
        method.direct.coarse_iterations=*) argument=method.direct.coarse_iterations=2 ;;
        grid.cells=*,*,*) argument='grid.cells=[12,12,12]' ;;
        mp4) command -v ffmpeg >/dev/null || argument=webp ;;
        [1-9][0-9]*x[1-9][0-9]*) argument=96x96 ;;
    esac
    arguments+=("$argument")
done
"$THURIBLE_PROGRAM" "${arguments[@]}" "${more[@]}" || { code=$?; [[ $code == 5 ]] || exit $code; }
"#;

/// `cargo` for what it runs; what else it does is no command for a small folder.
const CARGO: &str = r#"#!/usr/bin/env bash
case "$*" in
    'build --release') mkdir -p target/release && ln -sf "$(command -v thurible)" target/release/thurible ;;
    'run --release -- '*) exec thurible "${@:4}" ;;
    'run --release --example '*)
        program=$(dirname "$THURIBLE_PROGRAM")/examples/$4
        [[ -x $program ]] || { echo "the example $4 is not built: cargo build --examples" >&2; exit 0; }
        if [[ ${5-} == -- ]]; then exec "$program" "${@:6}"; else exec "$program"; fi ;;
    *) echo "cargo $*: no test runs this; say why in a comment before it: <!-- not run: why -->" >&2; exit 9 ;;
esac
"#;

pub struct Workshop {
    folder: PathBuf,
}

fn temporary(name: &str) -> PathBuf {
    Path::new(env!("CARGO_TARGET_TMPDIR")).join("book").join(name)
}

fn fresh(name: &str) -> PathBuf {
    let folder = temporary(name);
    if folder.exists() {
        fs::remove_dir_all(&folder).unwrap();
    }
    fs::create_dir_all(&folder).unwrap();
    folder
}

fn copy(from: &Path, to: &Path, file: &dyn Fn(&Path, &Path)) {
    fs::create_dir_all(to).unwrap();
    for entry in fs::read_dir(from).unwrap().map(Result::unwrap) {
        let (path, target) = (entry.path(), to.join(entry.file_name()));
        if path.is_dir() {
            copy(&path, &target, file);
        } else {
            file(&path, &target);
        }
    }
}

/// Copies a file; of a scene a small one.
fn smaller(from: &Path, to: &Path) {
    if from.extension().is_none_or(|end| end != "toml") {
        fs::copy(from, to).unwrap();
        return;
    }
    let mut scene: Table = fs::read_to_string(from).unwrap().parse().unwrap();
    if let Some(cells) = scene
        .get_mut("grid")
        .and_then(|grid| grid.get_mut("cells"))
        .and_then(Value::as_array_mut)
    {
        let (part, least) = if cells.len() == 3 { (4, 8) } else { (5, 16) };
        for count in cells {
            *count = Value::Integer((count.as_integer().unwrap() / part).max(least));
        }
    }
    let method = scene
        .entry("method")
        .or_insert(Table::new().into())
        .as_table_mut()
        .unwrap();
    method.insert("iterations".into(), 2.into());
    let direct = method
        .entry("direct")
        .or_insert(Table::new().into())
        .as_table_mut()
        .unwrap();
    direct.insert("coarse_iterations".into(), 2.into());
    fs::write(to, toml::to_string(&scene).unwrap()).unwrap();
}

fn script(path: &Path, text: &str) {
    fs::write(path, text).unwrap();
    fs::set_permissions(path, fs::Permissions::from_mode(0o755)).unwrap();
}

/// A grey picture that is bright in its middle.
fn picture(path: &Path, [width, height]: [u32; 2]) {
    let level = |at: u32, size: u32| 255 * (at + 1).min(size - at) / size.div_ceil(2);
    let pixels: Vec<u8> = (0..width * height)
        .map(|at| u8::try_from(level(at % width, width).min(level(at / width, height))).unwrap())
        .collect();
    let mut encoder = png::Encoder::new(fs::File::create(path).unwrap(), width, height);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.write_header().unwrap().write_image_data(&pixels).unwrap();
}

const SCENE: &str = "[grid]\ncells = [16, 16]\n[time]\nsteps = 60\n[source]\ncircle = { center = [0.4, 0.4], radius = 0.2 }\n\
    [[keyframe]]\nstep = 60\ntext = \"F\"\n[method]\niterations = 2\n[method.direct]\ncoarse_iterations = 2\n[output]\nfolder = \"out/scene\"\n";
const WALLS: &str = "[[obstacle]]\nbox = { min = [0.7, 0.7], max = [0.9, 0.9] }\n";

/// A result in 2D, its views and a picture, made once; the folder that every page's own begins as.
fn model() -> &'static Path {
    static MODEL: OnceLock<PathBuf> = OnceLock::new();
    MODEL.get_or_init(|| {
        let workshop = Workshop {
            folder: fresh("model"),
        };
        let folder = &workshop.folder;
        copy(&root().join("examples"), &folder.join("examples"), &smaller);
        for made in ["bin", "docs/images", "out"] {
            fs::create_dir_all(folder.join(made)).unwrap();
        }
        script(&folder.join("bin/thurible"), THURIBLE);
        script(&folder.join("bin/cargo"), CARGO);
        fs::write(folder.join("scene.toml"), SCENE).unwrap();
        fs::write(folder.join("walls.toml"), format!("{SCENE}{WALLS}")).unwrap();
        let begin =
            "thurible solve scene.toml && thurible photograph out/scene --views 3 --frames 0..1 -o captured";
        picture(&folder.join("photo.png"), [32, 24]);
        picture(&folder.join("kernel.png"), [3, 3]);
        let output = workshop.run(begin);
        assert!(output.status.success(), "{}", told(&output));
        folder.clone()
    })
}

impl Workshop {
    /// The folder of the page `name`.
    pub fn new(name: &str) -> Self {
        let folder = fresh(&name.replace(['/', '.'], "_"));
        copy(model(), &folder, &|from, to| assert!(fs::copy(from, to).is_ok()));
        Self { folder }
    }

    /// Runs a script there.
    pub fn run(&self, script: &str) -> Output {
        let path = std::env::var("PATH").unwrap_or_default();
        Command::new("bash")
            .args(["-euo", "pipefail", "-c", script])
            .current_dir(&self.folder)
            .env("PATH", format!("{}:{path}", self.folder.join("bin").display()))
            .env("THURIBLE_PROGRAM", env!("CARGO_BIN_EXE_thurible"))
            .output()
            .unwrap()
    }
}

/// What was printed.
pub fn told(output: &Output) -> String {
    format!(
        "{}{}",
        String::from_utf8_lossy(&output.stdout),
        String::from_utf8_lossy(&output.stderr)
    )
}

/// A synopsis as one would call it: without what stands in brackets, and with files of the folder for what stands in capitals.
pub fn called(synopsis: &str) -> String {
    let mut depth = 0;
    let bare: String = synopsis
        .chars()
        .filter(|&letter| {
            depth += i32::from(letter == '[' && !synopsis.contains("=["));
            let kept = depth == 0;
            depth -= i32::from(letter == ']' && !synopsis.contains("=["));
            kept
        })
        .collect();
    filled(bare.split("\\|").next().unwrap())
}

/// The same with files of the folder for what stands in capitals.
pub fn filled(text: &str) -> String {
    let part = |letter: char| letter.is_alphanumeric() || letter == '_';
    STANDS_FOR.iter().fold(text.to_owned(), |text, (word, file)| {
        let (mut whole, mut rest) = (String::new(), text.as_str());
        while let Some(at) = rest.find(word) {
            let (before, after) = (&rest[..at], &rest[at + word.len()..]);
            let alone = !before.ends_with(part) && !after.starts_with(part) && !before.ends_with('$');
            whole.push_str(before);
            whole.push_str(if alone { file } else { word });
            rest = after;
        }
        whole + rest
    })
}

#[test]
fn synopses_become_commands() {
    assert_eq!(
        called("thurible simulate SCENE [--from DIR [--at K]] [-o DIR]").trim(),
        "thurible simulate scene.toml"
    );
    assert_eq!(
        called("thurible condense PRESET\\|SCENE.toml [--basis fixed]"),
        "thurible condense stretch"
    );
    assert_eq!(
        called("thurible x --set grid.cells=[8,8] DIRS"),
        "thurible x --set grid.cells=[8,8] DIRS"
    );
}

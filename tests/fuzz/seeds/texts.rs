//! Good texts: scenes of each kind, options, command lines, drawings.

use super::ROOT;
use super::arrays::{npy, numbers};
use std::fs;
use std::path::Path;

/// Texts as inputs.
fn all<const N: usize>(texts: [&str; N]) -> Vec<Vec<u8>> {
    texts.map(|text| text.as_bytes().to_vec()).to_vec()
}

fn files(names: &[&str]) -> Vec<Vec<u8>> {
    let read = |name: &&str| fs::read(format!("{ROOT}/{name}.toml")).unwrap();
    names.iter().map(read).collect()
}

/// Scenes of the examples, with few cells where they have many.
pub fn scenes(_: &Path) -> Vec<Vec<u8>> {
    files(&[
        "examples/small_letter",
        "examples/small_3d",
        "examples/small_mixed",
        "examples/small_two_keyframes",
        "examples/effects/gate",
        "examples/effects/parade",
        "examples/effects/whirl",
    ])
}

/// What `--set` is given.
pub fn assignments(_: &Path) -> Vec<Vec<u8>> {
    all([
        "time.steps=20",
        "keyframe[0].text=\"G\"",
        "grid.boundary=[\"wall\", [\"open\", \"wall\"]]",
        "source={ circle = { center = [0.5, 0.5], radius = 0.2 } }",
        "method.direct.history=3",
        "emitter[0]={ from = 0, to = 9, rate = 0.1, box = { min = [0, 0], max = [0.2, 0.2] } }",
        "control.schedule=[[0, 1.0], [9, 100.0]]",
    ])
}

/// A keyframe for each of many files, behind a scene.
pub const SEQUENCE: &str = "\n[[keyframe]]\nsteps = { from = 2, every = 2 }\nfiles = \"\"\n";

/// What names such files.
pub fn patterns(work: &Path) -> Vec<Vec<u8>> {
    for number in ["0", "01", "2"] {
        let array = npy("<f4", "(8, 8)", &numbers(64));
        fs::write(work.join(format!("p_{number}.npy")), array).unwrap();
    }
    all(["p_*.npy", "./p_*", "p_0*.npy", "p*_2.npy"])
}

/// Command lines, an argument in each line.
pub fn arguments(_: &Path) -> Vec<Vec<u8>> {
    all([
        "solve\na.toml\n--set\ntime.steps=9\n--threads\n2\n--memory-limit\n1.5GiB\n--checkpoint\nevery=60s\n-o\nout/a",
        "resume\nout\n--checkpoint\nevery=20\n--json",
        "render\nout\n--steps\n0..9\n--size\n1920x1080",
        "export\nout\n--format\nvdb,usd\n--fps\n24\n--up\ny\n--steps\n3",
        "sweep\na.toml\n--vary\ncontrol.force_weight=1e2,1e3\n--only\n2",
        "photograph\nout\n--views\n9\n--size\n64x48\n--frames\n0..3\n--elevation\n-15.5\n--noise\n0.01",
        "simulate\na.toml\n--from\nout\n--at\n3\n--watch=8080",
        "deblur\na.png\n--psf\ndisc:3\n--saturation\n--budget\n1e3\n--move\npatch",
        "track\nframes\n--alpha\n1e-3\n--truth\na.npz\n--precision\nf64",
        "compare\na.toml\n--methods\ndirect,admm\n--quiet",
    ])
}

/// What a sweep varies.
pub fn varied(work: &Path) -> Vec<Vec<u8>> {
    fs::write(work.join("s.toml"), scenes(work).swap_remove(0)).unwrap();
    all([
        "control.force_weight=1e2,1e3",
        "time.steps=16,20",
        "source={ circle = { center = [0.5, 0.5], radius = 0.2 } },{ text = \"A, B\" }",
        "grid.boundary=[\"wall\", \"periodic\"],\"wall\"",
    ])
}

/// SVG: curves, colours that flow, patterns, masks, what is used again, styles.
pub fn drawings(_: &Path) -> Vec<Vec<u8>> {
    all([
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 64 64\"><circle cx=\"20\" cy=\"25\" r=\"12\"/></svg>",
        "<?xml version=\"1.0\"?>\n<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"40mm\" height=\"30\">\n\
         <style>.a { fill: #08f; stroke-width: 2 }</style>\n\
         <defs><linearGradient id=\"g\" x1=\"0\" x2=\"1\"><stop offset=\"0\" stop-color=\"red\"/><stop offset=\"1\" stop-opacity=\"0.2\"/></linearGradient>\n\
         <clipPath id=\"c\"><rect x=\"1\" y=\"2\" width=\"20\" height=\"20\" rx=\"3\"/></clipPath>\n\
         <mask id=\"m\"><rect width=\"40\" height=\"30\" fill=\"white\"/></mask>\n\
         <filter id=\"f\"><feGaussianBlur stdDeviation=\"2\"/><feOffset dx=\"1\" dy=\"1\"/></filter></defs>\n\
         <g transform=\"translate(2,3) rotate(15)\" clip-path=\"url(#c)\" class=\"a\">\n\
         <path id=\"p\" d=\"M 1 1 C 5 5 9 0 12 12 S 3 3 20 20 q 1 2 3 4 A 5 5 0 0 1 9 9 Z\" fill=\"url(#g)\" stroke=\"black\" stroke-dasharray=\"2 1\"/></g>\n\
         <use href=\"#p\" x=\"4\" mask=\"url(#m)\" opacity=\"0.5\"/>\n\
         <polygon points=\"0,0 9,3 4,9\" fill-rule=\"evenodd\" filter=\"url(#f)\"/>\n</svg>",
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 20 20\" preserveAspectRatio=\"xMinYMax slice\">\n\
         <pattern id=\"h\" width=\"4\" height=\"4\" patternUnits=\"userSpaceOnUse\"><path d=\"M0 0L4 4\" stroke=\"#123\"/></pattern>\n\
         <marker id=\"k\" markerWidth=\"3\" markerHeight=\"3\"><circle r=\"1\"/></marker>\n\
         <rect width=\"15\" height=\"15\" fill=\"url(#h)\"/><line x2=\"9\" y2=\"9\" stroke=\"red\" marker-end=\"url(#k)\"/>\n\
         <switch><ellipse cx=\"9\" cy=\"9\" rx=\"4\" ry=\"2\"/></switch></svg>",
    ])
}

/// Scenes of elastic bodies.
pub fn condensed(_: &Path) -> Vec<Vec<u8>> {
    let presets = ["stretch", "cantilever_3d", "rod", "spring", "buckle", "noise"];
    let names = presets.map(|name| format!("std_runner/condense/presets/{name}"));
    files(&names.each_ref().map(String::as_str))
}

/// Files of views, with cameras of each kind.
pub fn views(work: &Path) -> Vec<Vec<u8>> {
    fs::write(work.join("line.npy"), npy("<f4", "(8,)", &numbers(8))).unwrap();
    fs::write(work.join("front.npy"), npy("<f4", "(2, 6, 8)", &numbers(96))).unwrap();
    fs::write(work.join("side_0.npy"), npy("<f4", "(6, 8)", &numbers(48))).unwrap();
    fs::write(work.join("side_1.npy"), npy("<f4", "(6, 8)", &numbers(48))).unwrap();
    all([
        "[box]\ncells = [8, 8]\n[pictures]\nscale = 2.0\n[[camera]]\nname = \"a\"\nazimuth = 30.0\npitch = 0.125\nfile = \"line.npy\"\n\
         [[camera]]\nkind = \"pinhole\"\nposition = [2.0, 0.5]\ntarget = [0.5, 0.5]\nfield_of_view = 40.0\nfile = \"line.npy\"\n\
         [tomography]\nmethod = \"walk\"\nprior = \"tv\"\ngamma = 0.01\nseed = 3\n",
        "[box]\ncells = [8, 8, 6]\nlength = 2.0\norigin = [0.0, -1.0, 0.0]\n[pictures]\nfirst = 0\nlast = 1\ndt = 0.5\n\
         [[camera]]\nazimuth = 10.0\nelevation = 15.0\nup = [0.0, 0.0, 1.0]\npitch = 0.25\nfile = \"front.npy\"\n\
         [[camera]]\nkind = \"matrix\"\nmatrix = [[8.0, 4.0, 0.0, 0.0], [0.0, 3.0, -8.0, 10.0], [0.0, 1.0, 0.0, 2.0]]\nfiles = \"side_*.npy\"\n\
         [[novel]]\nkind = \"pinhole\"\nposition = [5.0, 0.5, 0.5]\ntarget = [0.5, 0.5, 0.5]\nfield_of_view = 40.0\nsize = [8, 6]\n",
    ])
}

/// Captures.
pub fn captures(work: &Path) -> Vec<Vec<u8>> {
    fs::write(work.join("smoke.npy"), npy("<f4", "(3, 8, 8)", &numbers(192))).unwrap();
    for number in 0..3 {
        let frame = npy("<f4", "(8, 8)", &numbers(64));
        fs::write(work.join(format!("smoke_{number}.npy")), frame).unwrap();
    }
    all([
        "[capture]\nfiles = \"smoke.npy\"\nboundary = [\"wall\", \"periodic\"]\nlength = 2.0\ndt = 0.5\nfirst = 0\nlast = 2\n\
         [track]\nmethod = \"direct\"\nalpha = 1e-3\nbeta = 0.1\n",
        "[capture]\nfiles = \"smoke_*.npy\"\ndensity_scale = \"auto\"\nemission = \"none\"\n[track]\nmethod = \"admm\"\n",
    ])
}

/// What blurred an image.
pub fn blurs(work: &Path) -> Vec<Vec<u8>> {
    fs::write(work.join("b.npy"), npy("<f4", "(16, 16)", &numbers(256))).unwrap();
    all(["disc:3", "motion:5,30", "gaussian:1.5", "disc:2.25", "motion:4"])
}

//! The readers, one line each.

mod commands;
mod mend;
mod shapes;
mod states;

use crate::random::Random;
use crate::seeds::{arrays, bodies, kept, pictures, texts};
use std::path::Path;

pub use commands::{command, is_resumed};

/// What reads files, or texts.
pub struct Reader {
    pub name: &'static str,
    /// The name of the file that it is given.
    pub file: &'static str,
    pub is_text: bool,
    /// Good inputs; what else they need is written into the folder of work.
    pub seeds: fn(&Path) -> Vec<Vec<u8>>,
    /// Makes checksums right again, often, so that changes come to what is behind them.
    pub mend: fn(&mut [u8], &mut Random),
    /// Of how many runs one is made, where one takes long.
    pub dear: u64,
    /// Bytes that the machine gives at once.
    pub given: usize,
    /// Whether it accepts them.
    pub read: fn(&Path, &[u8]) -> bool,
}

/// All of them.
pub const READERS: &[Reader] = &[
    Reader::of("scene", "a.toml", texts::scenes, shapes::scene).text(),
    Reader::of("set", "a.txt", texts::assignments, shapes::assignment).text(),
    Reader::of("pattern", "a.txt", texts::patterns, shapes::pattern).text(),
    Reader::of("arguments", "a.txt", texts::arguments, commands::arguments).text(),
    Reader::of("vary", "a.txt", texts::varied, commands::varied).text(),
    Reader::of("npy", "a.npy", arrays::arrays, shapes::array),
    Reader::of("npz", "a.npz", arrays::archives, shapes::archive).mended(mend::zip),
    Reader::of("velocity", "v.npz", arrays::archives, shapes::velocity).mended(mend::zip),
    Reader::of("frames", "f.npy", arrays::arrays, shapes::frames),
    Reader::of("png", "a.png", pictures::pngs, shapes::png).mended(mend::png),
    Reader::of("jpeg", "a.jpg", pictures::jpegs, shapes::jpeg),
    Reader::of("tiff", "a.tif", pictures::tiffs, shapes::tiff),
    Reader::of("webp", "a.webp", pictures::webps, shapes::webp),
    Reader::of("exr", "a.exr", pictures::exrs, shapes::exr),
    Reader::of("svg", "a.svg", texts::drawings, shapes::svg).text(),
    Reader::of("font", "a.ttf", pictures::fonts, shapes::font),
    Reader::of("obj", "a.obj", bodies::objs, shapes::obj).text(),
    Reader::of("stl", "a.stl", bodies::stls, shapes::stl),
    Reader::of("ply", "a.ply", bodies::plys, shapes::ply),
    Reader::of("gltf", "a.gltf", bodies::gltfs, shapes::gltf).text(),
    Reader::of("glb", "a.glb", bodies::glbs, shapes::glb),
    Reader::of("vdb", "a.vdb", bodies::volumes, shapes::volume),
    // A frame is an array of its own size, whatever its file takes, and is to be refused where the machine does not give as much.
    Reader::of("vdb_frames", "v.vdb", bodies::volumes, shapes::volumes).given(32 << 20),
    Reader::of("condense", "c.toml", texts::condensed, commands::condensed).text(),
    Reader::of(
        "condense_obj",
        "m.obj",
        bodies::flat_objs,
        commands::condensed_obj,
    )
    .text(),
    Reader::of("condense_msh", "m.msh", bodies::mshs, commands::condensed_msh).text(),
    Reader::of("views", "views.toml", texts::views, commands::views).text(),
    Reader::of("capture", "k.toml", texts::captures, commands::capture).text(),
    Reader::of("psf", "a.txt", texts::blurs, commands::blur).text(),
    Reader::of("report", "done/report.json", kept::reports, commands::report).text(),
    Reader::of("saved", "a.saved", kept::saved, states::saved).mended(mend::saved),
    Reader::of("state", "known/state.0", kept::checkpoints, states::state).mended(mend::state),
    Reader::of(
        "checkpoint",
        "states/state.0",
        kept::checkpoints,
        states::checkpoint,
    )
    .mended(mend::state)
    .dear(100),
];

impl Reader {
    const fn of(
        name: &'static str,
        file: &'static str,
        seeds: fn(&Path) -> Vec<Vec<u8>>,
        read: fn(&Path, &[u8]) -> bool,
    ) -> Self {
        Self {
            name,
            file,
            is_text: false,
            seeds,
            mend: mend::nothing,
            dear: 1,
            given: usize::MAX,
            read,
        }
    }

    const fn text(self) -> Self {
        Self {
            is_text: true,
            ..self
        }
    }

    const fn mended(self, mend: fn(&mut [u8], &mut Random)) -> Self {
        Self { mend, ..self }
    }

    const fn dear(self, dear: u64) -> Self {
        Self { dear, ..self }
    }

    const fn given(self, given: usize) -> Self {
        Self { given, ..self }
    }
}

//! Devices beside the processors, on which a search by the direct method can go: graphics cards, with the feature `gpu`.

use crate::exit::Failure;
use crate::plan::{self, PlanOptions, Planned};
use crate::problem::Precision;
use crate::scene::Scene;
use thurible_core::exec::Device;
use thurible_core::exec::device::Room;
use thurible_core::solver::room;

/// A device, as it is listed.
#[derive(Clone, Debug)]
pub(crate) struct Listed {
    /// Its name.
    pub name: String,
    /// Whether it is a program on the processors that plays a card: right, and slow.
    pub is_software: bool,
}

/// A device that searches.
pub(crate) trait Searching: Device {
    /// Its name.
    fn name(&self) -> &str;
    /// What went wrong first, if anything did.
    fn failure(&self) -> Option<String>;
    /// Bytes that a search takes.
    ///
    /// # Errors
    /// A sentence, where the search does not fit.
    fn plan(&self, room: &Room) -> Result<Taken, String>;
}

/// What a search on a device takes.
#[derive(Clone, Debug)]
pub(crate) struct Taken {
    /// Bytes of the device's memory, by name.
    pub lines: Vec<(&'static str, usize)>,
    /// Bytes of this machine's memory beside the block: steps that are streamed to the device.
    pub here: usize,
}

#[cfg(feature = "gpu")]
mod cards {
    use super::{Listed, Searching, Taken};
    use thurible_core::exec::device::Room;
    use thurible_gpu::{Gpu, adapters};

    impl Searching for Gpu {
        fn name(&self) -> &str {
            Gpu::name(self)
        }

        fn failure(&self) -> Option<String> {
            Gpu::failure(self)
        }

        fn plan(&self, room: &Room) -> Result<Taken, String> {
            let taken = Gpu::plan(self, room)?;
            let shown = |bytes: u64| usize::try_from(bytes).unwrap_or(usize::MAX);
            let lines = taken.lines.iter();
            Ok(Taken {
                lines: lines.map(|&(name, bytes)| (name, shown(bytes))).collect(),
                here: shown(taken.here),
            })
        }
    }

    /// All cards, and behind them programs that play one.
    pub fn list() -> Option<Vec<Listed>> {
        let listed = |(name, is_software)| Listed { name, is_software };
        let all = adapters().into_iter();
        Some(all.map(|named| listed((named.name, named.is_software))).collect())
    }

    /// Opens the first of a name. It stays open as long as the program runs.
    pub fn open(name: &str, most: Option<u64>) -> Result<&'static dyn Searching, String> {
        let named = adapters().into_iter().find(|named| named.name == name);
        let gpu = named.ok_or("it is gone")?.open(most)?;
        Ok(Box::leak(Box::new(gpu)))
    }
}

#[cfg(not(feature = "gpu"))]
mod cards {
    use super::{Listed, Searching};

    /// None are known.
    pub fn list() -> Option<Vec<Listed>> {
        None
    }

    /// Never asked for.
    pub fn open(name: &str, _: Option<u64>) -> Result<&'static dyn Searching, String> {
        Err(format!("nobody knows {name}"))
    }
}

/// All cards, and behind them programs that play one.
///
/// # Errors
/// That this program knows none.
pub(crate) fn list() -> Result<Vec<Listed>, Failure> {
    cards::list().ok_or_else(|| {
        Failure::Input(
            "this program was built without graphics cards; build it with them: cargo install --path . --features gpu".into(),
        )
    })
}

/// Opens the device that is called `wanted`, or a part of that, for searches that take at most `most` bytes of it: `gpu` is the first card,
/// `cpu` none.
///
/// # Errors
/// That there is none, or why it cannot be opened.
pub(crate) fn open(wanted: &str, most: Option<usize>) -> Result<Option<&'static dyn Searching>, Failure> {
    if wanted.eq_ignore_ascii_case("cpu") {
        return Ok(None);
    }
    let refuse = |why: String| Failure::Input(format!("--device {wanted}: {why}"));
    let all = list().map_err(|failure| refuse(failure.to_string()))?;
    let any_card = wanted.eq_ignore_ascii_case("gpu");
    let fits = |listed: &&Listed| {
        if any_card {
            !listed.is_software
        } else {
            !wanted.is_empty() && listed.name.to_lowercase().contains(&wanted.to_lowercase())
        }
    };
    let Some(found) = all.iter().find(fits) else {
        return Err(refuse(missing(&all, any_card)));
    };
    let opened = cards::open(&found.name, most.map(|most| most as u64));
    opened
        .map(Some)
        .map_err(|why| refuse(format!("{} cannot be used: {why}", found.name)))
}

/// What to do where none of `all` is meant.
fn missing(all: &[Listed], any_card: bool) -> String {
    let names: Vec<_> = all.iter().map(|listed| format!("\"{}\"", listed.name)).collect();
    let (names, driver) = (
        names.join(", "),
        "install the card's driver (in containers set NVIDIA_DRIVER_CAPABILITIES=graphics,compute)",
    );
    if all.is_empty() {
        return format!("no device with Vulkan was found; {driver}, or leave --device out");
    }
    if any_card {
        return format!(
            "no card with Vulkan was found, but {names}, which the processors play; {driver}, or leave --device out"
        );
    }
    format!("there is no such card; a part of a name chooses one of {names}")
}

/// The sentence that refuses what a device cannot do yet.
pub(crate) fn refusal(scene: &Scene, what: &str) -> Failure {
    let path = scene.document.path().display();
    Failure::Input(format!(
        "{path}: a device knows no {what} yet; choose otherwise, or leave out --device"
    ))
}

/// Refuses a scene that no device solves yet, whatever it plans.
///
/// # Errors
/// What of it.
pub(crate) fn steers(scene: &Scene) -> Result<(), Failure> {
    if scene.method.fluids.chosen {
        return Err(refusal(scene, "solver stable_fluids"));
    }
    Ok(())
}

/// Refuses what a device cannot do yet; the bytes that it takes.
///
/// # Errors
/// What that is, or that there is not so much memory.
pub(crate) fn check(
    device: &dyn Searching,
    scene: &Scene,
    planned: &Planned,
    options: &PlanOptions,
) -> Result<Taken, Failure> {
    let refuse = |what: &str| refusal(scene, what);
    if planned.precision != Precision::F32 {
        return Err(refuse("other precision than f32"));
    }
    if planned.windows.is_some() {
        return Err(refuse("`method.window`"));
    }
    let room = room(&planned.problem.problem(), planned.plan.params()).map_err(refuse)?;
    let path = scene.document.path().display();
    let taken = device
        .plan(&room)
        .map_err(|why| Failure::Memory(format!("{path}: {why}")))?;
    plan::leaves(scene, planned, options, taken.here)?;
    Ok(taken)
}

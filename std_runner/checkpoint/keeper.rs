//! Keeps the state of a solve while it runs.

use super::inputs::{Input, inputs_of};
use super::open::{held, make_way, write};
use super::parts::clean;
use super::{
    Every, Found, Needs, Options, PartFiles, Place, SLOTS, Saving, Solve, Words, beside, has_states,
};
use crate::destination::Destination;
use crate::exit::Failure;
use crate::held::remove;
use crate::output::sync_folder;
use crate::progress::Watch;
use crate::scene::Document;
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;
use std::{env, io};
use thurible_core::checkpoint::Refused;
use thurible_core::exec::Ranks;
use thurible_core::grid::Share;

/// Solves that take longer than this are kept without being asked, in seconds.
const LONG: f64 = 300.0;
/// How often, in seconds, and the most that it may take, in parts of the time between.
const OFTEN: f64 = 60.0;
const SHARE: f64 = 0.05;

/// Files as they were when a solve began, or why one could not be read.
pub(crate) type Inputs = io::Result<Vec<Input>>;

/// How a solve begins.
pub(crate) enum Begin<'a> {
    /// Anew, with these files; a state that is in its way may go if that is `forced`.
    Anew { inputs: Option<Inputs>, forced: bool },
    /// On from a state.
    From(&'a Found),
}

/// Keeps the states of a solve: the last two.
pub(crate) struct Keeper {
    every: Every,
    /// Where, and as the user knows it.
    place: PathBuf,
    document: Document,
    options: Options,
    /// The files that it began with, as they were then.
    inputs: Option<Inputs>,
    solve: Option<Solve>,
    /// Held from the first state on, and where states were asked for from the start.
    lock: Option<Arc<File>>,
    /// When the last state was kept, how long that took, and the iterations so far.
    last: Instant,
    took: f64,
    iterations: usize,
    /// Whether the user has heard that a state could not be kept.
    told: bool,
    /// The ranks that share the solve.
    ranks: Option<(&'static dyn Ranks, Share)>,
}

impl Keeper {
    /// For a solve of `document`. Sees whether there is room for what it is going to write, and makes way for its states: nothing else stands
    /// against it. Those that were asked for have their folder from now on.
    ///
    /// # Errors
    /// There is no room for the result, or for states that were asked for; another run keeps states there.
    pub fn new(
        every: Every,
        destination: &Destination,
        needs: Needs,
        (document, options): (Document, Options),
        begin: Begin<'_>,
        ranks: Option<(&'static dyn Ranks, Share)>,
    ) -> Result<Self, Failure> {
        let (found, inputs, forced) = match begin {
            Begin::Anew { inputs, forced } => (None, inputs, forced),
            Begin::From(found) => (Some(found), None, false),
        };
        let place = found.map_or_else(|| beside(destination.folder()), |found| found.place.clone());
        let goes_on = found.is_some();
        let needs = if every == Every::Off {
            needs.without_states(goes_on)
        } else {
            needs
        };
        let has_room = needs.have_room(destination, &place, (every.is_asked_for(), goes_on))?;
        if !goes_on {
            make_way(destination.folder(), forced)?;
        }
        let mut keeper = Self {
            every: if has_room { every } else { Every::Off },
            place,
            document,
            options,
            inputs,
            solve: found.map(|found| found.solve.clone()),
            lock: found.map(|found| Arc::clone(&found.lock)),
            last: Instant::now(),
            took: 0.0,
            iterations: 0,
            told: false,
            ranks,
        };
        if every.is_asked_for() {
            keeper.folder()?;
        }
        Ok(keeper)
    }

    /// Whether anything is kept at all.
    fn is_on(&self) -> bool {
        self.every != Every::Off
    }

    /// A folder for files that states belong to, where there is one: held from now on.
    ///
    /// # Errors
    /// The system refused, or another run holds it.
    pub fn beside_states(&mut self) -> Result<Option<&Path>, Failure> {
        if self.is_on() || self.lock.is_some() {
            self.folder().map(Some)
        } else {
            Ok(None)
        }
    }

    /// The folder of the states, held from now on.
    fn folder(&mut self) -> Result<&Path, Failure> {
        if self.lock.is_none() {
            let cannot = |error: io::Error| {
                let shown = self.place.display();
                Failure::File(format!(
                    "cannot write {shown}: {error}; choose another folder with -o DIR, or keep no state with --checkpoint off"
                ))
            };
            fs::create_dir_all(&self.place).map_err(cannot)?;
            self.place.parent().map_or(Ok(()), sync_folder).map_err(cannot)?;
            let lock = held(&self.place)?;
            // What is gone on from is this solve, not one that another run left here meanwhile.
            for slot in SLOTS.map(|slot| self.place.join(slot)) {
                match fs::remove_file(slot) {
                    Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(cannot(error)),
                    _ => {}
                }
            }
            self.lock = Some(Arc::new(lock));
        }
        Ok(&self.place)
    }

    /// Whether a state should be kept after the iteration that is over.
    pub fn is_due(&self, watch: &Watch) -> bool {
        let since = self.last.elapsed().as_secs_f64();
        match self.every {
            Every::Off => false,
            Every::Seconds(seconds) => since >= seconds,
            Every::Iterations(count) => watch.history.len() >= self.iterations + count,
            Every::ByItself => since >= OFTEN.max(self.took / SHARE) && expected_seconds(watch) > LONG,
        }
    }

    /// Keeps a state, which was `begun` then: `words`, and what `fields` writes. What cannot be written is no reason to end a solve: the user is told
    /// once.
    pub fn keep(
        &mut self,
        begun: Instant,
        watch: &Watch,
        words: &Words,
        fields: &mut dyn FnMut(&mut Saving<'_>) -> Result<(), Refused>,
    ) {
        if let Err(failure) = self.write(words, fields)
            && !self.told
        {
            self.told = true;
            watch.display.warning(&format!(
                "the state of the solve could not be kept: {failure}. The solve goes on, and states that were kept before stay"
            ));
        }
        self.last = Instant::now();
        self.took = begun.elapsed().as_secs_f64();
        self.iterations = watch.history.len();
    }

    fn write(
        &mut self,
        words: &Words,
        fields: &mut dyn FnMut(&mut Saving<'_>) -> Result<(), Refused>,
    ) -> Result<(), Failure> {
        self.folder()?;
        let refused = |place: &Path, error: &io::Error| {
            Failure::File(match error.get_ref() {
                // What went wrong in a rank.
                Some(said) => said.to_string(),
                None => format!(
                    "cannot write {}: {error}; check that its disc has room",
                    place.display()
                ),
            })
        };
        if self.solve.is_none() {
            // Where no states were going to be kept the files are looked at late.
            let now = || inputs_of(&self.document, &self.options.results());
            let inputs = self.inputs.take().unwrap_or_else(now);
            let solve = inputs.and_then(|inputs| Solve::of(&self.document, self.options.clone(), inputs));
            self.solve = Some(solve.map_err(|error| {
                Failure::File(format!("a file that the scene names cannot be read: {error}"))
            })?);
        }
        let Some(solve) = &mut self.solve else {
            return Ok(());
        };
        solve.number += 1;
        solve.cut = self.ranks.map(|(_, share)| share.into());
        let slot = SLOTS.get((solve.number % 2) as usize).unwrap_or(&"state");
        let parts = self.ranks.map(|(ranks, _)| {
            let place = Place {
                number: solve.number,
                ..Place::default()
            };
            PartFiles::new(Some(ranks), &self.place, place)
        });
        let written = write(&self.place.join(slot), (solve, words), parts, fields);
        written.map_err(|error| {
            // The next one takes the same place: the other holds the last whole state.
            solve.number -= 1;
            clean(&self.place, solve.number);
            refused(&self.place, &error)
        })?;
        clean(&self.place, solve.number);
        Ok(())
    }

    /// Keeps the state at the end of a solve whose result could not be written, and says how it is gone on with; `None` where there is no
    /// room for it either. Of a solve that was `cut_off` one that was kept before is the better one: bit for bit it goes on from that. A state
    /// without files beside it may go `elsewhere`.
    pub fn keep_end(
        &mut self,
        (cut_off, elsewhere): (bool, bool),
        words: &Words,
        fields: &mut dyn FnMut(&mut Saving<'_>) -> Result<(), Refused>,
    ) -> Option<PathBuf> {
        if cut_off && let Some(place) = self.kept() {
            return Some(place.to_owned());
        }
        if self.write(words, fields).is_ok() || self.kept().is_some() {
            return Some(self.place.clone());
        }
        // Parts have to be where all machines see them.
        if !elsewhere || self.ranks.is_some() {
            return None;
        }
        self.forget();
        // Nothing was kept yet, and nothing can be here: elsewhere, then.
        self.place = env::temp_dir().join(self.place.file_name()?);
        if self.place.exists() || self.write(words, fields).is_err() {
            return None;
        }
        Some(self.place.clone())
    }

    /// The folder of the states, if there are any.
    pub fn kept(&self) -> Option<&Path> {
        (self.lock.is_some() && has_states(&self.place)).then_some(&self.place)
    }

    /// Removes all states: the result is written.
    pub fn forget(&mut self) {
        if self.lock.take().is_some() {
            // States go before the files that they need. What is left behind is not what the user must hear of.
            for slot in SLOTS {
                let _ = fs::remove_file(self.place.join(slot));
            }
            let _ = remove(&self.place);
        }
    }
}

impl Drop for Keeper {
    /// A folder without a state is of no use to anybody.
    fn drop(&mut self) {
        if self.kept().is_none() {
            self.forget();
        }
    }
}

/// Seconds that the solve takes in all, about; those so far where nothing tells more.
fn expected_seconds(watch: &Watch) -> f64 {
    let seconds = watch.clock.seconds();
    seconds + watch.left(seconds).unwrap_or(0.0)
}

//! States of which every rank writes its part, and reads what it needs of the parts that others wrote.

use super::error::SavedError;
use super::gather::SavedParts;
use super::label::HEAD;
use super::record::Record;
use super::resumable::{Resumable, accept};
use super::{Broken, Refused, Sink};
use crate::exec::ranks::{joined, tell};

/// Where ranks keep their parts of a state.
pub trait PartStore {
    /// Lets `fill` write the part of this rank.
    ///
    /// # Errors
    /// [`Refused`], in all ranks alike.
    fn write(&mut self, fill: &mut dyn FnMut(&mut dyn Sink) -> Result<(), Refused>) -> Result<(), Refused>;

    /// Lets `take` read the parts that are there.
    ///
    /// # Errors
    /// [`SavedError`], in all ranks alike.
    fn read(
        &mut self,
        take: &mut dyn FnMut(&mut dyn SavedParts) -> Result<(), SavedError>,
    ) -> Result<(), SavedError>;
}

/// Saves the parts of all ranks, of which the first one calls this and has the others, who follow, do the same.
///
/// # Errors
/// [`Refused`], also where no ranks share it.
pub fn save_parts(one: &mut dyn Resumable, store: &mut dyn PartStore) -> Result<(), Refused> {
    let rank = one.ranks().ok_or(Refused)?.rank();
    store.write(&mut |sink| {
        let mut record = Record::part(sink, rank);
        one.scalars(&mut record).map_err(|_| Refused)?;
        let label = (one.saved_bytes(), one.fingerprint());
        let sealed = record.seal(label.0, label.1);
        one.fields(&mut record);
        sealed.and(record.ended()).map_err(|_| Refused)
    })
}

/// Goes on from what any number of ranks saved, or one program, as all ranks of this solve do at the same time.
///
/// # Errors
/// [`SavedError`], in all ranks alike. Where it is not that of the head nothing can be done with the state any more.
pub fn restore_parts(one: &mut dyn Resumable, store: &mut dyn PartStore) -> Result<(), SavedError> {
    store.read(&mut |saved| {
        let mut head = [0; HEAD];
        let is_first = one.ranks().is_none_or(|ranks| ranks.rank() == 0);
        let accepted = if is_first {
            let taken = saved.take(0, 0, &mut head);
            let taken = taken.map_err(|refused| SavedError::from(Broken::from(refused)));
            taken.and_then(|()| accept(one, &head, one.saved_bytes()))
        } else {
            Ok(())
        };
        agreed(one, accepted)?;
        // All have the head that the first one read, and come to the same.
        if let Some(ranks) = one.ranks() {
            tell(ranks, 0, &mut head);
        }
        let mut record = Record::gather(head, saved);
        one.scalars(&mut record).map_err(Broken::from)?;
        one.fields(&mut record);
        let ended = record.ended().map_err(SavedError::from);
        let ended = agreed(one, ended);
        match ended {
            Ok(()) => one.taken(),
            Err(_) => one.spoil(),
        }
        ended
    })
}

/// What went wrong here, or that something did in another rank.
fn agreed(one: &dyn Resumable, own: Result<(), SavedError>) -> Result<(), SavedError> {
    let Some(ranks) = one.ranks() else {
        return own;
    };
    let failed = if own.is_err() { 1.0 } else { 0.0 };
    if joined(ranks, failed, f64::max) > 0.0 {
        own.and(Err(SavedError::Refused))
    } else {
        own
    }
}

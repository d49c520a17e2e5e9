//! Whatever has a state that is saved and gone on from: the head and the order are the same for all.

use super::error::SavedError;
use super::label::{FORMAT, HEAD, Label, MAGIC};
use super::record::Record;
use super::{Broken, Damaged, Sink, Source};
use crate::exec::Ranks;

/// What has a state that can be saved as plain bytes and gone on from.
pub trait Resumable {
    /// Bytes of a checkpoint, its head included.
    fn saved_bytes(&self) -> usize;

    /// All that the bits of a step follow from, but for the fields, in one word.
    fn fingerprint(&self) -> u64;

    /// Passes over all scalars, which are all checked before anything is changed.
    ///
    /// # Errors
    /// [`Damaged`]: nothing has changed.
    fn scalars(&mut self, record: &mut Record<'_>) -> Result<(), Damaged>;

    /// Passes over all fields.
    fn fields(&mut self, record: &mut Record<'_>);

    /// The ranks that share it, if there are others.
    fn ranks(&self) -> Option<&dyn Ranks> {
        None
    }

    /// A whole state was taken.
    fn taken(&mut self) {}

    /// Half of it is another state now: nothing can be done with it until all that was given is given again, or at all.
    fn spoil(&mut self);
}

/// Writes the whole state as plain bytes, into the first [`Resumable::saved_bytes`] of `bytes`. Nothing is changed: it is borrowed to write
/// because one list of the state serves for [`restore`] too.
///
/// # Errors
/// [`SavedError::Length`] when `bytes` are too few; [`SavedError::Refused`] of what ranks share.
pub fn save(one: &mut dyn Resumable, bytes: &mut [u8]) -> Result<(), SavedError> {
    let (expected, given) = (one.saved_bytes(), bytes.len());
    let short = SavedError::Length { expected, given };
    let mut bytes = bytes.get_mut(..expected).ok_or(short)?;
    save_to(one, &mut bytes)
}

/// As [`save`], piece by piece to `sink`, through one block of [`HEAD`] bytes.
///
/// # Errors
/// [`SavedError::Refused`] where the sink refuses, and of what ranks share.
pub fn save_to(one: &mut dyn Resumable, sink: &mut dyn Sink) -> Result<(), SavedError> {
    alone(one)?;
    let mut record = Record::write(sink);
    one.scalars(&mut record).map_err(Broken::from)?;
    record.seal(one.saved_bytes(), one.fingerprint())?;
    one.fields(&mut record);
    record.ended()?;
    debug_assert_eq!(
        record.bytes(),
        one.saved_bytes(),
        "planned and saved bytes differ"
    );
    Ok(())
}

/// Goes on from what another one with the same fingerprint saved: every later step gives the bits that it would have given there. Nothing is
/// changed where the bytes are refused, as they are of what ranks share.
///
/// # Errors
/// [`SavedError`].
pub fn restore(one: &mut dyn Resumable, bytes: &[u8]) -> Result<(), SavedError> {
    let (expected, given) = (one.saved_bytes(), bytes.len());
    let length = SavedError::Length { expected, given };
    let (head, fields) = bytes.split_first_chunk::<HEAD>().ok_or(length)?;
    alone(one)?;
    accept(one, head, given)?;
    let (mut source, mut again) = (fields, fields);
    let mut record = Record::check(*head, &mut source);
    one.fields(&mut record);
    record.ended()?;
    take(one, *head, &mut again)
}

/// As [`restore`], piece by piece from `source`, through one block of [`HEAD`] bytes. A source that is refused for what its first bytes say has
/// changed nothing; where it ends early, or a later field is damaged, the state is of no use any more.
///
/// # Errors
/// [`SavedError`].
pub fn restore_from(one: &mut dyn Resumable, source: &mut dyn Source) -> Result<(), SavedError> {
    alone(one)?;
    let mut head = [0; HEAD];
    source.take(&mut head).map_err(Broken::from)?;
    accept(one, &head, one.saved_bytes())?;
    take(one, head, source)
}

/// Refuses what ranks share: each has a part of the state, for which there are [`save_parts`](super::save_parts) and
/// [`restore_parts`](super::restore_parts).
fn alone(one: &dyn Resumable) -> Result<(), SavedError> {
    if one.ranks().is_some() {
        Err(SavedError::Refused)
    } else {
        Ok(())
    }
}

/// Whether bytes with this head, of which so many are given, are a state of this one.
pub(super) fn accept(one: &dyn Resumable, head: &[u8; HEAD], given: usize) -> Result<(), SavedError> {
    let expected = one.saved_bytes();
    let length = SavedError::Length { expected, given };
    match Label::of(head).ok_or(length)? {
        Label { magic, .. } if magic != MAGIC => Err(SavedError::NotSaved),
        Label { format, .. } if format != FORMAT => Err(SavedError::Format { given: format }),
        Label { fingerprint, .. } if fingerprint != one.fingerprint() => Err(SavedError::OtherSolve),
        Label { bytes: said, .. } if given != expected || said != expected as u64 => Err(length),
        label if !label.fits(head) => Err(SavedError::Damaged),
        _ => Ok(()),
    }
}

/// Takes a state whose head was accepted.
fn take(one: &mut dyn Resumable, head: [u8; HEAD], source: &mut dyn Source) -> Result<(), SavedError> {
    let mut record = Record::read(head, source);
    one.scalars(&mut record).map_err(Broken::from)?;
    one.fields(&mut record);
    if let Err(broken) = record.ended() {
        one.spoil();
        return Err(broken.into());
    }
    one.taken();
    Ok(())
}

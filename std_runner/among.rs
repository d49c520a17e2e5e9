//! What programs that share a command, its ranks, tell each other beside what the numerics exchange: bytes, a folder, and what went wrong in one of them.

use crate::exit::{Failure, INPUT, MEMORY};
use std::path::{Path, PathBuf, absolute};
use thurible_core::exec::Ranks;
use thurible_core::exec::ranks::{joined, tell};

/// The bytes that rank `whose` has.
pub(crate) fn told(ranks: &dyn Ranks, whose: usize, mut bytes: Vec<u8>) -> Vec<u8> {
    let mut len = [bytes.len()];
    tell(ranks, whose, &mut len);
    bytes.resize(len[0], 0);
    tell(ranks, whose, &mut bytes);
    bytes
}

/// What this rank has, when all have theirs, or what went wrong in one of them.
pub(crate) fn agreed<V>(ranks: &dyn Ranks, own: Result<V, Failure>) -> Result<V, Failure> {
    if ranks.count() == 1 {
        return own;
    }
    // The first rank that failed speaks: it knows most.
    let count = ranks.count();
    let failed = own.as_ref().map_or((count - ranks.rank()) as f64, |_| 0.0);
    let failed = joined(ranks, failed, f64::max) as usize;
    let Some(whose) = count.checked_sub(failed).filter(|&rank| rank < count) else {
        return own;
    };
    let own = own.err();
    let code = told(ranks, whose, vec![own.as_ref().map_or(0, Failure::code)]);
    let said = own.map_or(String::new(), |failure| failure.to_string());
    let said = told(ranks, whose, said.into_bytes());
    let code = code.first().copied().unwrap_or_default();
    Err(said_by_rank(whose, code, &String::from_utf8_lossy(&said)))
}

/// What went wrong in a rank, by the exit code and the sentence of its failure.
pub(crate) fn said_by_rank(rank: usize, code: u8, said: &str) -> Failure {
    let kind = match code {
        INPUT => Failure::Input,
        MEMORY => Failure::Memory,
        _ => Failure::File,
    };
    kind(format!("rank {rank}: {said}"))
}

/// The `folder` that the first rank knows, which has to be one for all of them; `remedy` is what to do where it is not.
///
/// # Errors
/// It is not, or its name cannot be told, in all ranks alike.
pub(crate) fn shared_folder(ranks: &dyn Ranks, folder: &Path, remedy: &str) -> Result<PathBuf, Failure> {
    if ranks.count() == 1 {
        return Ok(folder.to_owned());
    }
    let name = absolute(folder).ok().filter(|_| ranks.rank() == 0);
    let name = name.as_ref().and_then(|name| name.to_str()).unwrap_or("");
    let name = told(ranks, 0, name.as_bytes().to_vec());
    let name = String::from_utf8_lossy(&name).into_owned();
    let shared = if name.is_empty() {
        Err(Failure::Input(format!(
            "{} is no name in UTF-8, by which ranks know a folder; {remedy}",
            folder.display()
        )))
    } else if !Path::new(&name).is_dir() {
        Err(Failure::File(format!(
            "{name} is not seen from this machine; {remedy}"
        )))
    } else {
        Ok(PathBuf::from(name))
    };
    agreed(ranks, shared)
}

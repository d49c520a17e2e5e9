//! What a glTF file is made of: its text, the buffer behind it, names of others.

use std::borrow::Cow;
use std::path::{Path, PathBuf};

use base64::Engine;
use base64::engine::general_purpose::STANDARD;

use super::surface::bytes_of;
use crate::keyframes::error::Fault;

/// What to do with a file that cannot be read.
pub(super) const AGAIN: &str = "export it again as glTF 2.0, without compression";

/// The refusal of a file that does not make sense.
pub(super) fn broken(what: &str) -> Fault {
    Fault::content(format!("is no glTF that can be read ({what})"), AGAIN)
}

/// The JSON text, and the buffer of a `.glb` that stands behind it.
pub(super) fn parts(bytes: &[u8]) -> Result<(&[u8], Option<&[u8]>), Fault> {
    let Some(rest) = bytes.strip_prefix(b"glTF") else {
        return Ok((bytes, None));
    };
    let (version, _) = word(rest)?;
    if version != 2 {
        return Err(broken(&format!("its version is {version}")));
    }
    let (text, rest) = chunk(rest.get(8..).unwrap_or_default())?;
    let inside = if rest.len() < 8 {
        None
    } else {
        Some(chunk(rest)?.0)
    };
    Ok((text, inside))
}

fn word(bytes: &[u8]) -> Result<(usize, &[u8]), Fault> {
    let (word, rest) = bytes.split_first_chunk().ok_or_else(|| broken("it breaks off"))?;
    Ok((u32::from_le_bytes(*word) as usize, rest))
}

/// A chunk: bytes that it has, its kind, and they.
fn chunk(bytes: &[u8]) -> Result<(&[u8], &[u8]), Fault> {
    let (size, rest) = word(bytes)?;
    let (_, rest) = word(rest)?;
    rest.split_at_checked(size).ok_or_else(|| broken("it breaks off"))
}

/// The buffer that `uri` names: the one `inside` where it names none, what it holds itself, or a file beside the one at `path`.
pub(super) fn buffer<'a>(
    uri: Option<&str>,
    inside: Option<&'a [u8]>,
    path: &Path,
) -> Result<Cow<'a, [u8]>, Fault> {
    let Some(uri) = uri else {
        return inside.map(Cow::from).ok_or_else(|| broken("a buffer is nowhere"));
    };
    let bytes = match held(uri) {
        Some(text) => STANDARD.decode(text).map_err(|_| broken("a buffer is no base64")),
        None => beside(&path.with_file_name(plain(uri))),
    };
    bytes.map(Cow::from)
}

/// What `uri` holds itself, in base64.
fn held(uri: &str) -> Option<&str> {
    let (_, text) = uri.strip_prefix("data:")?.split_once(";base64,")?;
    Some(text)
}

/// The file beside the one at `path` that `uri` names, if it names one.
pub(super) fn named(uri: &str, path: &Path) -> Option<PathBuf> {
    held(uri).is_none().then(|| path.with_file_name(plain(uri)))
}

fn beside(path: &Path) -> Result<Vec<u8>, Fault> {
    let kept = |why: String| format!("keeps its points in `{}`, which {why}", path.display());
    bytes_of(path).map_err(|fault| match fault {
        Fault::Read(error) => Fault::content(
            kept(format!("cannot be read ({error})")),
            "put that file beside it, or export it as .glb",
        ),
        Fault::Content { found, remedy } => Fault::content(kept(found), remedy),
    })
}

/// A name in which `%20` stands for a space.
fn plain(uri: &str) -> String {
    let mut bytes = Vec::new();
    let mut rest = uri.as_bytes();
    while let Some((&first, after)) = rest.split_first() {
        let hex = after.get(..2).and_then(|two| core::str::from_utf8(two).ok());
        match hex.and_then(|two| u8::from_str_radix(two, 16).ok()) {
            Some(byte) if first == b'%' => {
                bytes.push(byte);
                rest = after.get(2..).unwrap_or_default();
            }
            _ => {
                bytes.push(first);
                rest = after;
            }
        }
    }
    String::from_utf8_lossy(&bytes).into_owned()
}

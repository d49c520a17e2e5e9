//! What a glTF file is made of: its text, the buffer behind it, names of others.

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

/// A name in which `%20` stands for a space.
pub(super) fn plain(uri: &str) -> String {
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

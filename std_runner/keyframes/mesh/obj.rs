//! Wavefront OBJ: lines `v x y z` and `f 1/1/1 2 3 ..`, all others passed over.

use super::surface::Surface;
use crate::keyframes::error::Fault;

/// Reads points and faces.
pub(super) fn read(bytes: &[u8]) -> Result<Surface, Fault> {
    let mut surface = Surface::default();
    let mut corners = Vec::new();
    let mut joined: Vec<u8> = Vec::new();
    for (index, line) in bytes.split(|&byte| byte == b'\n').enumerate() {
        let line = line.strip_suffix(b"\r").unwrap_or(line);
        // A backslash at its end goes on with the line on the next one, but for comments, which may end in a folder of Windows.
        let is_comment = joined.is_empty() && line.trim_ascii_start().starts_with(b"#");
        if let (false, Some(part)) = (is_comment, line.strip_suffix(b"\\")) {
            joined.extend(part);
            joined.push(b' ');
            continue;
        }
        joined.extend(line);
        let broken = |what: &str| {
            let found = format!("has {what} in line {} that cannot be read", index + 1);
            Fault::content(found, "export it again as Wavefront OBJ")
        };
        let text = String::from_utf8_lossy(&joined);
        let mut words = text.split_ascii_whitespace();
        match words.next() {
            Some("v") => {
                let mut next = || words.next().and_then(|word| word.parse::<f64>().ok());
                let (Some(x), Some(y), Some(z)) = (next(), next(), next()) else {
                    return Err(broken("a point"));
                };
                surface.points.push([x, y, z]);
            }
            Some("f") => {
                corners.clear();
                for word in words {
                    let corner = corner(word, surface.points.len());
                    corners.push(corner.ok_or_else(|| broken("a face"))?);
                }
                surface.polygon(&corners)?;
            }
            _ => {}
        }
        joined.clear();
    }
    Ok(surface)
}

/// The point that `12/3/4`, from 1, or `-1`, from the last of `count`, stands for.
fn corner(word: &str, count: usize) -> Option<u32> {
    let number: i64 = word.split('/').next()?.parse().ok()?;
    let from_zero = if number < 0 {
        i64::try_from(count).ok()?.checked_add(number)?
    } else {
        number - 1
    };
    u32::try_from(from_zero).ok()
}

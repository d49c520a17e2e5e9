//! Files of which every bit is known again: a length, bytes, and a checksum of all before it. Written under a temporary name, synced,
//! and renamed.

use crate::output::sync_folder;
use std::fs::{self, File};
use std::io::{self, ErrorKind, Read, Seek, SeekFrom, Write};
use std::path::Path;
use thurible_core::checkpoint::{Mix, Refused, Sink, Source};

/// Bytes that are mixed together; the checksum depends on it.
const PIECE: usize = 1 << 16;
/// What such a file begins with: name and format.
const MAGIC: [u8; 16] = *b"thurible state 1";
/// Where bytes begin in it.
pub(super) const BEGIN: u64 = MAGIC.len() as u64;
/// Bytes of the checksum at the end.
const SUM: usize = 8;

/// A file that is written.
pub(crate) struct Sealed {
    file: File,
    piece: Vec<u8>,
    sum: Mix,
    /// Why the last piece could not be written.
    pub trouble: Option<io::Error>,
}

impl Sealed {
    /// Lets `fill` write the file at `path`, which is whole or as it was; what is under the name `part` meanwhile is removed. Its checksum.
    pub fn write(
        path: &Path,
        part: &Path,
        fill: &mut dyn FnMut(&mut Self) -> Result<(), Refused>,
    ) -> io::Result<u64> {
        let filled = Self::fill(part, fill);
        let written = filled.and_then(|sum| fs::rename(part, path).map(|()| sum));
        if written.is_err() {
            // What is left is of no use, and the first error says more than a second one would.
            let _ = fs::remove_file(part);
            return written;
        }
        path.parent().map_or(Ok(()), sync_folder)?;
        written
    }

    fn fill(part: &Path, fill: &mut dyn FnMut(&mut Self) -> Result<(), Refused>) -> io::Result<u64> {
        let mut sealed = Self {
            file: File::create(part)?,
            piece: Vec::with_capacity(PIECE),
            sum: Mix::new(),
            trouble: None,
        };
        let filled = sealed.put(&MAGIC).and_then(|()| fill(&mut sealed));
        if let Err(Refused) = filled {
            let other = || io::Error::from(ErrorKind::Other);
            return Err(sealed.trouble.unwrap_or_else(other));
        }
        sealed.flush()?;
        let sum = sealed.sum.finish();
        sealed.file.write_all(&sum.to_le_bytes())?;
        sealed.file.sync_all()?;
        Ok(sum)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.sum.bytes(&self.piece);
        self.file.write_all(&self.piece)?;
        self.piece.clear();
        Ok(())
    }

    /// A count of bytes, and the bytes.
    pub fn block(&mut self, bytes: &[u8]) -> Result<(), Refused> {
        self.put(&(bytes.len() as u64).to_le_bytes())?;
        self.put(bytes)
    }
}

impl Sink for Sealed {
    fn put(&mut self, mut bytes: &[u8]) -> Result<(), Refused> {
        while !bytes.is_empty() {
            let (now, later) = bytes.split_at(bytes.len().min(PIECE - self.piece.len()));
            self.piece.extend_from_slice(now);
            bytes = later;
            if self.piece.len() == PIECE
                && let Err(error) = self.flush()
            {
                self.trouble = Some(error);
                return Err(Refused);
            }
        }
        Ok(())
    }
}

/// A file that is read, every bit of which was checked.
pub(crate) struct Unsealed {
    file: io::BufReader<File>,
    /// Bytes before the checksum that are not taken yet.
    left: u64,
}

impl Unsealed {
    /// Opens the file at `path`. `None` where it is not one of ours or is not whole.
    pub fn open(path: &Path) -> io::Result<Option<Self>> {
        let mut file = File::open(path)?;
        if sum(&mut file)?.is_none() {
            return Ok(None);
        }
        let left = file.metadata()?.len().saturating_sub(BEGIN + SUM as u64);
        file.seek(SeekFrom::Start(BEGIN))?;
        let file = io::BufReader::with_capacity(PIECE, file);
        Ok(Some(Self { file, left }))
    }

    /// Where the next byte is in the file.
    pub fn place(&mut self) -> io::Result<u64> {
        self.file.stream_position()
    }

    /// A count of bytes, and the bytes; no more than there are left.
    pub fn block(&mut self) -> Result<Vec<u8>, Refused> {
        let mut count = [0; 8];
        self.take(&mut count)?;
        let count = u64::from_le_bytes(count);
        if count > self.left {
            return Err(Refused);
        }
        let mut bytes = vec![0; usize::try_from(count).map_err(|_| Refused)?];
        self.take(&mut bytes)?;
        Ok(bytes)
    }
}

impl Source for Unsealed {
    fn take(&mut self, bytes: &mut [u8]) -> Result<(), Refused> {
        self.left = self.left.checked_sub(bytes.len() as u64).ok_or(Refused)?;
        self.file.read_exact(bytes).map_err(|_| Refused)
    }
}

/// The checksum of the file at `path`; `None` where it is not one of ours or is not whole.
pub(super) fn sum_of(path: &Path) -> io::Result<Option<u64>> {
    sum(&mut File::open(path)?)
}

/// What stands at the end of a file, unchecked.
pub(super) fn seal(file: &mut File) -> io::Result<u64> {
    let mut said = [0; SUM];
    let end = file.metadata()?.len().saturating_sub(SUM as u64);
    file.seek(SeekFrom::Start(end))?;
    file.read_exact(&mut said)?;
    Ok(u64::from_le_bytes(said))
}

fn sum(file: &mut File) -> io::Result<Option<u64>> {
    let Some(length) = file.metadata()?.len().checked_sub(SUM as u64) else {
        return Ok(None);
    };
    if length < BEGIN {
        return Ok(None);
    }
    let (mut sum, mut piece, mut left) = (Mix::new(), vec![0; PIECE], length);
    let mut is_ours = true;
    loop {
        let count = usize::try_from(left).unwrap_or(PIECE).min(PIECE);
        let piece = piece.get_mut(..count).unwrap_or(&mut []);
        file.read_exact(piece)?;
        is_ours &= left != length || piece.starts_with(&MAGIC);
        sum.bytes(piece);
        left -= count as u64;
        // The last piece is shorter than a whole one, and may be empty.
        if count < PIECE {
            break;
        }
    }
    let mut said = [0; SUM];
    file.read_exact(&mut said)?;
    let sum = sum.finish();
    Ok(Some(sum).filter(|sum| is_ours && said == sum.to_le_bytes()))
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    /// Of files around the size of a piece every length but the whole and every changed bit is found.
    #[test]
    fn only_what_was_written_is_read() {
        let folder = std::env::temp_dir().join(format!("thurible-sealed-{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        let (path, part, other) = (folder.join("a"), folder.join("part"), folder.join("b"));
        let payload: Vec<u8> = (0..300u32).map(|byte| (byte * 7 % 251) as u8).collect();
        Sealed::write(&path, &part, &mut |file| {
            file.block(&payload)?;
            file.put(b"rest")
        })
        .unwrap();
        let mut read = Unsealed::open(&path).unwrap().unwrap();
        assert_eq!(read.block().unwrap(), payload);
        let mut rest = [0; 4];
        read.take(&mut rest).unwrap();
        assert!(&rest == b"rest" && read.take(&mut [0]).is_err());
        let bytes = fs::read(&path).unwrap();
        for length in 0..bytes.len() {
            fs::write(&other, &bytes[..length]).unwrap();
            assert!(Unsealed::open(&other).unwrap().is_none(), "{length} bytes");
        }
        for bit in 0..8 * bytes.len() {
            let mut changed = bytes.clone();
            changed[bit / 8] ^= 1 << (bit % 8);
            fs::write(&other, changed).unwrap();
            assert!(Unsealed::open(&other).unwrap().is_none(), "bit {bit}");
        }
        for length in [PIECE - 40, PIECE - 24, PIECE - 16, PIECE, 2 * PIECE - 24] {
            let payload = vec![3; length];
            Sealed::write(&path, &part, &mut |file| file.block(&payload)).unwrap();
            assert_eq!(Unsealed::open(&path).unwrap().unwrap().block().unwrap(), payload);
        }
        assert!(!part.exists());
        fs::remove_dir_all(&folder).unwrap();
    }
}

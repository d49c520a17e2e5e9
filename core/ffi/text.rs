//! Text into the caller's buffer, cut where it does not fit and always ended by a zero byte.

use core::ffi::c_char;
use core::fmt::{self, Write};

/// Bytes of a name in a structure, the zero byte at its end included.
pub const THURIBLE_NAME_BYTES: usize = 32;
/// Bytes of a few words in a structure, likewise. What does not fit is cut.
pub const THURIBLE_WORDS_BYTES: usize = 128;

struct Text<'a> {
    buffer: &'a mut [u8],
    /// Bytes of the whole text so far, whether they fit or not.
    length: usize,
}

impl Write for Text<'_> {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        // The last byte is kept for the end.
        let room = self.buffer.len().saturating_sub(1);
        let places = self.buffer.iter_mut().take(room).skip(self.length);
        places.zip(text.bytes()).for_each(|(place, byte)| *place = byte);
        self.length = self.length.saturating_add(text.len());
        Ok(())
    }
}

/// Writes `what` into `buffer` of `size` bytes; bytes of the whole text without the zero at its end.
///
/// # Safety
/// `buffer` is null or points to `size` bytes to write.
pub unsafe fn write(buffer: *mut c_char, size: usize, what: &dyn fmt::Display) -> usize {
    let buffer: &mut [u8] = if buffer.is_null() || size == 0 || size > isize::MAX as usize {
        &mut []
    } else {
        // SAFETY: not null, and the caller promises the bytes; zeroed before they are read as bytes.
        unsafe {
            core::ptr::write_bytes(buffer, 0, size);
            core::slice::from_raw_parts_mut(buffer.cast(), size)
        }
    };
    let mut text = Text { buffer, length: 0 };
    // Writing to a buffer cannot fail.
    let _ = write!(text, "{what}");
    text.length
}

/// Writes `text` into an array of a structure.
pub fn put_text(array: &mut [c_char], text: &str) {
    // SAFETY: the array has as many bytes.
    unsafe { write(array.as_mut_ptr(), array.len(), &text) };
}

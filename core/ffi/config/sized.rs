//! Structures of C that tell their size, by which later versions are known.

use super::ConfigError;
use crate::result::ThuribleResult;

/// A structure whose first field is its size in a program.
///
/// # Safety
/// It is `repr(C)`, its first field is a `usize`, and every pattern of bits is one.
pub unsafe trait Versioned: Copy {}

/// No version will have more bytes.
const MOST_BYTES: usize = 1 << 16;

/// Reads a structure of any version up to this one.
///
/// # Errors
/// [`ConfigError`]: null, misaligned, or of an unknown size.
///
/// # Safety
/// `config` is null or points to a structure of as many bytes as its first field says.
pub unsafe fn read<C: Versioned>(config: *const C) -> Result<C, ConfigError> {
    if config.is_null() {
        return Err(ConfigError::Result(ThuribleResult::Null));
    }
    if !config.is_aligned() {
        return Err(ConfigError::Result(ThuribleResult::Misaligned));
    }
    let own = size_of::<C>();
    // SAFETY: not null and aligned; the size is the first field of every version.
    let size = unsafe { config.cast::<usize>().read() };
    if !(own..=MOST_BYTES).contains(&size) {
        return Err(ConfigError::Result(ThuribleResult::ConfigSize));
    }
    // SAFETY: the caller promises `size` bytes.
    let later = unsafe { core::slice::from_raw_parts(config.cast::<u8>().add(own), size - own) };
    // What a later version added is known only as far as it is left at nothing.
    if later.iter().any(|&byte| byte != 0) {
        return Err(ConfigError::Result(ThuribleResult::ConfigSize));
    }
    // SAFETY: as above, and every pattern of bits is one.
    Ok(unsafe { config.read() })
}

/// Fills a structure of `size` bytes.
///
/// # Safety
/// `config` is null or points to `size` bytes to write.
pub unsafe fn fill<C: Versioned>(config: *mut C, size: usize, default: C) -> ThuribleResult {
    if config.is_null() {
        return ThuribleResult::Null;
    }
    if !config.is_aligned() {
        return ThuribleResult::Misaligned;
    }
    let own = size_of::<C>();
    if !(own..=MOST_BYTES).contains(&size) {
        return ThuribleResult::ConfigSize;
    }
    // SAFETY: not null, aligned, and the caller promises `size` bytes, which are no fewer than this version's.
    unsafe {
        config.cast::<u8>().add(own).write_bytes(0, size - own);
        config.write(default);
        config.cast::<usize>().write(size);
    }
    ThuribleResult::Ok
}

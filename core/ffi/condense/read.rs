//! What is read of a body.

use super::body::ThuribleCondenser;
use crate::instance;
use crate::pointer::array;
use crate::result::ThuribleResult;
use core::ffi::c_void;

/// What is read of every vertex.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ThuribleCondensePart {
    /// Where it is.
    Position = 0,
    /// How far it is from rest.
    Displacement = 1,
    /// The gradient of the energy by it, when that was made last; 0 of a held one.
    Gradient = 2,
    /// How far it goes along the direction that was found last; 0 of a held one.
    Direction = 3,
}

/// Copies what `part`, a `ThuribleCondensePart`, says of all vertices into `out` of exactly `bytes` bytes: `dimensions` numbers for each vertex.
///
/// # Safety
/// `condenser` as in `thurible_condense_close`; `out` is null or points to `bytes` bytes to write.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thurible_condense_read(
    condenser: *mut ThuribleCondenser,
    part: u32,
    out: *mut f64,
    bytes: usize,
) -> ThuribleResult {
    // SAFETY: the caller's promises.
    unsafe {
        instance::enter(condenser, |body| {
            let one = body.condenser.one();
            if part > ThuribleCondensePart::Direction as u32 {
                return Err(ThuribleResult::Index.into());
            }
            let out: &mut [f64] = array(out.cast::<c_void>(), bytes, one.vertices() * body.dims)?;
            for (vertex, out) in out.chunks_exact_mut(body.dims.max(1)).enumerate() {
                let found = one.of(vertex);
                let found = found.get(part as usize).into_iter().flatten();
                out.iter_mut().zip(found).for_each(|(out, &value)| *out = value);
            }
            Ok(())
        })
    }
}

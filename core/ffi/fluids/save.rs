//! The state of a search as bytes, and back.

use super::body::{ThuribleFluids, plan};
use super::calls::read;
use super::config::ThuribleFluidsConfig;
use super::searched::ThuribleSearched;
use crate::config::ThuribleConfig;
use crate::each;
use crate::instance::{self, Refusal, asked};
use crate::result::ThuribleResult;
use core::ffi::c_void;

/// How many bytes `thurible_fluids_save` writes.
///
/// # Safety
/// `scene` and `config` as in `thurible_fluids_plan`; `bytes` is null or may be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thurible_fluids_saved_bytes(
    scene: *const ThuribleConfig,
    config: *const ThuribleFluidsConfig,
    bytes: *mut usize,
) -> ThuribleResult {
    // SAFETY: the caller's promises.
    unsafe {
        asked::plan([bytes], core::ptr::null_mut(), || {
            let planned = read(scene, config).and_then(|(scene, config)| plan(&scene, &config))?;
            Ok([planned.saved])
        })
    }
}

/// Saves the whole state of a search, densities included, as `thurible_save` does: into `bytes` of `size` bytes, `thurible_fluids_saved_bytes` or more.
///
/// # Safety
/// `fluids` as in `thurible_fluids_close`; `bytes` is null or points to `size` bytes to write.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thurible_fluids_save(
    fluids: *mut ThuribleFluids,
    bytes: *mut c_void,
    size: usize,
) -> ThuribleResult {
    // SAFETY: the caller's promises.
    unsafe {
        instance::enter(
            fluids,
            |body| each!(&mut body.fluids, one => instance::save(one, bytes, size)),
        )
    }
}

/// Goes on from what `thurible_fluids_save` wrote, of exactly `thurible_fluids_saved_bytes`, as `thurible_restore` does: threads, ceiling, slots and iterations
/// may be others. Every later step gives the same bits; what is damaged or of another scene or choice is refused and changes nothing.
///
/// # Safety
/// `fluids` as in `thurible_fluids_close`; `bytes` is null or points to `size` bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thurible_fluids_restore(
    fluids: *mut ThuribleFluids,
    bytes: *const c_void,
    size: usize,
) -> ThuribleResult {
    // SAFETY: the caller's promises.
    unsafe {
        instance::enter(fluids, |body| {
            let objective = each!(&mut body.fluids, one => {
                instance::restore(one, bytes, size)?;
                one.objective()
            });
            body.searched = ThuribleSearched {
                data: objective.data,
                force: objective.force,
                initial: objective.initial,
                ..ThuribleSearched::default()
            };
            Ok::<(), Refusal>(())
        })
    }
}

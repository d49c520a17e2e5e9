//! The state of an instance as bytes, and back.

use crate::each;
use crate::instance::{self, Refusal, Thurible, ThuribleProgress};
use crate::result::ThuribleResult;
use core::ffi::c_void;
use thurible_core::Report;

/// Saves the whole state, densities included, into `bytes` of `size` bytes, `saved_bytes` of `thurible_plan` or more: plain bytes, the
/// same on every machine.
///
/// # Safety
/// `instance` as in `thurible_close`; `bytes` is null or points to `size` bytes to write.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thurible_save(
    instance: *mut Thurible,
    bytes: *mut c_void,
    size: usize,
) -> ThuribleResult {
    // SAFETY: the caller's promises.
    unsafe {
        instance::enter(
            instance,
            |body| each!(&mut body.solver, solver => instance::save(solver, bytes, size)),
        )
    }
}

/// Goes on from what `thurible_save` wrote, of exactly `saved_bytes`, here or in another instance, process or machine, whose
/// configuration may differ in threads, ceiling and iterations alone, unless automatic pairs of L-BFGS become fewer under the ceiling: every later step gives the same bits. Damaged bytes and those of
/// another configuration are refused and change nothing. Solid cells are not among them: `thurible_set_solids` comes first, with the same cells.
///
/// # Safety
/// `instance` as in `thurible_close`; `bytes` is null or points to `size` bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thurible_restore(
    instance: *mut Thurible,
    bytes: *const c_void,
    size: usize,
) -> ThuribleResult {
    // SAFETY: the caller's promises.
    unsafe {
        instance::enter(instance, |body| {
            each!(&mut body.solver, solver => instance::restore(solver, bytes, size))?;
            body.report = Report::default();
            body.progress = each!(&body.solver, solver => {
                let objective = solver.objective();
                ThuribleProgress { data: objective.data, force: objective.force, ..ThuribleProgress::default() }
            });
            Ok::<(), Refusal>(())
        })
    }
}

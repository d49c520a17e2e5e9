//! The templates of a result, by number.

use crate::config::ThuribleTemplate;
use crate::each;
use crate::instance::{self, Body, Thurible};
use crate::pointer::required;
use crate::result::ThuribleResult;
use thurible_core::Template;

/// Template `index` of an instance, whose result is there.
fn at(body: &Body, index: usize) -> Result<Template, ThuribleResult> {
    let found = each!(&body.solver, solver => solver.template(index));
    let found = found.ok_or(ThuribleResult::Index)?;
    if each!(&body.solver, solver => solver.is_finished()) {
        Ok(found)
    } else {
        Err(ThuribleResult::NoResult)
    }
}

/// Template `index` of the result, from 0 on, as it was found: its middle and radius, and its first amplitude. It ends with the force.
///
/// # Safety
/// `instance` as in `thurible_close`; `found` is null or may be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thurible_template(
    instance: *const Thurible,
    index: usize,
    found: *mut ThuribleTemplate,
) -> ThuribleResult {
    // SAFETY: the caller's promises.
    unsafe {
        instance::enter(instance, |body| {
            required(found)?;
            found.write(at(body, index)?.into());
            Ok(())
        })
    }
}

/// The amplitude that template `index` of the result has at step `step`, from its `from` to before its `to`: three numbers, of which the
/// template's kind says how many count.
///
/// # Safety
/// `instance` as in `thurible_close`; `amplitude` is null or points to three numbers to write.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thurible_template_amplitude(
    instance: *const Thurible,
    index: usize,
    step: usize,
    amplitude: *mut f64,
) -> ThuribleResult {
    // SAFETY: the caller's promises.
    unsafe {
        instance::enter(instance, |body| {
            required(amplitude)?;
            let template = at(body, index)?;
            let interval = template
                .interval_at(step, template.to)
                .ok_or(ThuribleResult::Index)?;
            let found = each!(&body.solver, solver => solver.amplitude(index, interval));
            amplitude.cast::<[f64; 3]>().write(found);
            Ok(())
        })
    }
}

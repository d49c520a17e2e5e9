//! Libraries that panic on what is in a file: the panic is caught, and the terminal does not hear of it.

use core::cell::Cell;
use core::panic::AssertUnwindSafe;
use std::panic::{catch_unwind, set_hook, take_hook};
use std::sync::Once;

thread_local! {
    static IS_QUIET: Cell<bool> = const { Cell::new(false) };
}

/// What `work` makes, or `None` where it panics. Whatever it was writing to is in no state to be used then.
///
/// The first call puts a hook before the one that the program has, which tells of panics as before, except of those that are caught here.
pub(crate) fn guarded<R>(work: impl FnOnce() -> R) -> Option<R> {
    static HOOK: Once = Once::new();
    HOOK.call_once(|| {
        let before = take_hook();
        set_hook(Box::new(move |info| {
            if !IS_QUIET.get() {
                before(info);
            }
        }));
    });
    let was_quiet = IS_QUIET.replace(true);
    let made = catch_unwind(AssertUnwindSafe(work));
    IS_QUIET.set(was_quiet);
    made.ok()
}

#[cfg(test)]
#[expect(clippy::panic, reason = "a test of panics")]
mod tests {
    use super::guarded;

    #[test]
    fn a_panic_is_caught_and_the_next_one_too() {
        assert_eq!(guarded(|| 3), Some(3));
        for _ in 0..2 {
            let inner = || guarded(|| -> i32 { panic!("caught inside") });
            assert_eq!(guarded(inner), Some(None));
        }
        assert!(std::panic::catch_unwind(|| panic!("told")).is_err());
    }
}

//! The end of a panic: there is nobody to unwind to.

use core::panic::PanicInfo;

#[cfg(feature = "host_panic")]
unsafe extern "C" {
    fn thurible_panicked() -> !;
}

#[panic_handler]
fn panic(_info: &PanicInfo<'_>) -> ! {
    #[cfg(feature = "host_panic")]
    // SAFETY: the host defines it and it does not return.
    unsafe {
        thurible_panicked()
    }
    #[cfg(not(feature = "host_panic"))]
    trap()
}

/// Stops the thread or the machine by an instruction that is none.
#[cfg(not(feature = "host_panic"))]
fn trap() -> ! {
    #[cfg(any(target_arch = "x86_64", target_arch = "x86"))]
    // SAFETY: does not return and touches nothing.
    unsafe {
        core::arch::asm!("ud2", options(noreturn, nomem, nostack))
    }
    #[cfg(target_arch = "arm")]
    // SAFETY: as above.
    unsafe {
        core::arch::asm!("udf #0", options(noreturn, nomem, nostack))
    }
    #[cfg(target_arch = "aarch64")]
    // SAFETY: as above.
    unsafe {
        core::arch::asm!("brk #1", options(noreturn, nomem, nostack))
    }
    #[cfg(target_arch = "wasm32")]
    core::arch::wasm32::unreachable();
    #[cfg(not(any(target_arch = "x86_64", target_arch = "x86", target_arch = "arm", target_arch = "aarch64", target_arch = "wasm32")))]
    loop {
        core::hint::spin_loop();
    }
}

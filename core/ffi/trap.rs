//! The end of a panic: there is nobody to unwind to.

#[cfg(feature = "host_panic")]
use core::ffi::c_char;
use core::panic::PanicInfo;

#[cfg(feature = "host_panic")]
unsafe extern "C" {
    /// Ends the program, or at least never returns: `length` bytes of the name of a source file and a line say where it happened.
    fn thurible_panicked(file: *const c_char, length: usize, line: u32) -> !;
}

#[panic_handler]
fn panic(_info: &PanicInfo<'_>) -> ! {
    #[cfg(feature = "host_panic")]
    {
        let (file, line) = _info
            .location()
            .map_or(("", 0), |place| (place.file(), place.line()));
        // SAFETY: the host defines it and it does not return; the text lives for ever.
        unsafe { thurible_panicked(file.as_ptr().cast(), file.len(), line) }
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
    #[cfg(not(any(
        target_arch = "x86_64",
        target_arch = "x86",
        target_arch = "arm",
        target_arch = "aarch64",
        target_arch = "wasm32"
    )))]
    loop {
        core::hint::spin_loop();
    }
}

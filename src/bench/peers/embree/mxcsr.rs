//! The processor's floating-point control register, which Embree needs in another state than our
//! kernels.
//!
//! Its manual recommends flushing denormal results to zero, and treating denormal inputs as zero,
//! while it traces. Our own kernels must do neither, or bits would differ. On processors other than
//! x86-64, nothing is changed.

/// Restores the register when this is dropped.
#[must_use]
pub(super) struct RestoreMxcsr(u32);

/// Flush to zero, and denormals are zero.
const FLUSH: u32 = 1 << 15 | 1 << 6;

impl RestoreMxcsr {
    /// Saves the register before a call that might change it.
    pub(super) fn later() -> RestoreMxcsr {
        RestoreMxcsr(read())
    }

    /// Saves the register, then turns on the flushing of denormals. Until it is restored, Rust code
    /// may move floats but do no arithmetic on them.
    #[inline]
    pub(super) fn flushing() -> RestoreMxcsr {
        let before = read();
        write(before | FLUSH);
        RestoreMxcsr(before)
    }
}

impl Drop for RestoreMxcsr {
    #[inline]
    fn drop(&mut self) {
        write(self.0);
    }
}

#[cfg(target_arch = "x86_64")]
#[inline]
fn read() -> u32 {
    let mut value = 0u32;
    // SAFETY: stores four bytes into four bytes that we own. (`_mm_getcsr` is deprecated in favour
    // of this.)
    unsafe {
        std::arch::asm!("stmxcsr [{}]", in(reg) &raw mut value, options(nostack, preserves_flags));
    }
    value
}

#[cfg(target_arch = "x86_64")]
#[inline]
fn write(value: u32) {
    // SAFETY: the value was read from the register, with two mode bits added that every x86-64 has;
    // no exception is unmasked. Rust does no arithmetic on floats between the changed value and the
    // old one: callers only move them.
    unsafe {
        std::arch::asm!("ldmxcsr [{}]", in(reg) &raw const value, options(nostack, preserves_flags));
    }
}

#[cfg(not(target_arch = "x86_64"))]
fn read() -> u32 {
    0
}

#[cfg(not(target_arch = "x86_64"))]
fn write(_: u32) {}

#[cfg(target_arch = "x86_64")]
#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_register_is_put_back() {
        // The status flags change all the time; only the control bits are compared.
        let control = || read() & !0x3f;
        let before = control();
        {
            let _restore = RestoreMxcsr::flushing();
            assert_eq!(control(), before | FLUSH);
        }
        assert_eq!(control(), before);
        {
            let _restore = RestoreMxcsr::later();
            write(before | FLUSH);
        }
        assert_eq!(control(), before);
    }
}

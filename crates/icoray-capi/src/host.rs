//! The host's floating-point state and signal mask, which calls restore.
//!
//! Models run with floating-point traps (`-ffpe-trap=invalid,overflow`), flush denormals to zero, and print raised
//! exception flags at their end. icoray computes with NaN, so every call sets the default state and restores the
//! caller's, including flags; threads that a call starts inherit the default. These threads block signals that are sent
//! to the process, as the model handles them; signals that a thread raises itself, such as page faults that a
//! checkpointer handles, are not blocked.

use std::cell::Cell;

thread_local! {
    /// State of the caller of the current call.
    static CALLER: Cell<State> = const { Cell::new(State::DEFAULT) };
}

/// Sets the default floating-point state (IEC 60559: round to nearest, no traps, no flushing); drop restores the
/// caller's.
pub(crate) struct FloatingPoint {
    /// State of the outer caller: a log callback may call icoray.
    outer: State,
}

impl FloatingPoint {
    pub fn set_default() -> Self {
        let outer = CALLER.replace(State::read());
        State::DEFAULT.write();
        FloatingPoint { outer }
    }
}

impl Drop for FloatingPoint {
    fn drop(&mut self) {
        CALLER.replace(self.outer).write();
    }
}

/// Runs code of the caller in the caller's state, and stores the state that it leaves.
pub(crate) fn as_caller<R>(code: impl FnOnce() -> R) -> R {
    let own = State::read();
    CALLER.get().write();
    let result = code();
    CALLER.set(State::read());
    own.write();
    result
}

/// The control and status register of SSE, which Rust's arithmetic uses; that of x87 is not changed.
#[cfg(target_arch = "x86_64")]
#[derive(Debug, Clone, Copy, PartialEq)]
struct State(u32);

#[cfg(target_arch = "x86_64")]
impl State {
    /// All exceptions masked, no flags, round to nearest, denormals kept (Intel SDM vol. 1, 10.2.3).
    const DEFAULT: State = State(0x1f80);

    fn read() -> Self {
        let mut value = 0u32;
        // SAFETY: stores four bytes at the address of `value`.
        unsafe {
            std::arch::asm!("stmxcsr [{}]", in(reg) &raw mut value, options(nostack, preserves_flags));
        }
        State(value)
    }

    fn write(self) {
        let value = self.0;
        // SAFETY: loads four bytes that were read from the register before or are its reset value, so no reserved bit
        // is set. The state is never left other than it was while foreign code runs after the call.
        unsafe {
            std::arch::asm!("ldmxcsr [{}]", in(reg) &raw const value, options(nostack, preserves_flags));
        }
    }
}

/// The control (FPCR) and status (FPSR) registers.
#[cfg(target_arch = "aarch64")]
#[derive(Debug, Clone, Copy, PartialEq)]
struct State(u64, u64);

#[cfg(target_arch = "aarch64")]
impl State {
    const DEFAULT: State = State(0, 0);

    fn read() -> Self {
        let (control, status): (u64, u64);
        // SAFETY: reads two registers that user code may read.
        unsafe {
            std::arch::asm!("mrs {}, fpcr", "mrs {}, fpsr", out(reg) control, out(reg) status);
        }
        State(control, status)
    }

    fn write(self) {
        // SAFETY: writes two registers that user code may write, with what was read from them or their reset values.
        unsafe {
            std::arch::asm!("msr fpcr, {}", "msr fpsr, {}", in(reg) self.0, in(reg) self.1);
        }
    }
}

/// On other architectures the state is not changed.
#[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64")))]
#[derive(Debug, Clone, Copy, PartialEq)]
struct State;

#[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64")))]
impl State {
    const DEFAULT: State = State;

    fn read() -> Self {
        State
    }

    fn write(self) {}
}

/// Runs `start` with signals blocked on this thread; threads that it starts inherit the mask.
pub(crate) fn without_signals<R>(start: impl FnOnce() -> R) -> R {
    /// Restores the mask, also if `start` panics.
    struct Mask(libc::sigset_t);

    impl Drop for Mask {
        fn drop(&mut self) {
            // SAFETY: a mask that pthread_sigmask filled in.
            unsafe { libc::pthread_sigmask(libc::SIG_SETMASK, &raw const self.0, std::ptr::null_mut()) };
        }
    }

    let mut all = std::mem::MaybeUninit::uninit();
    let mut before = std::mem::MaybeUninit::uninit();
    // SAFETY: both are filled in by the calls that get them; SIG_SETMASK is a valid `how`, so the call cannot fail.
    let mask = unsafe {
        libc::sigfillset(all.as_mut_ptr());
        // Synchronous signals, which are not blocked.
        for own in [libc::SIGSEGV, libc::SIGBUS, libc::SIGFPE, libc::SIGILL, libc::SIGTRAP, libc::SIGSYS] {
            libc::sigdelset(all.as_mut_ptr(), own);
        }
        libc::pthread_sigmask(libc::SIG_SETMASK, all.as_ptr(), before.as_mut_ptr());
        Mask(before.assume_init())
    };
    let started = start();
    drop(mask);
    started
}

#[cfg(all(test, target_arch = "x86_64"))]
mod tests {
    use super::*;

    /// Flush to zero, denormals are zero, round down, no traps, the inexact flag raised.
    const ODD: State = State(0x1f80 | 0x8000 | 0x0040 | 0x2000 | 0x0020);

    #[test]
    fn the_callers_code_has_the_callers_state() {
        let usual = State::read();
        ODD.write();
        let (inside, again) = {
            let _guard = FloatingPoint::set_default();
            let inside = as_caller(|| {
                let inside = State::read();
                // The division-by-zero flag, raised by the caller's code.
                State(ODD.0 | 0x4).write();
                inside
            });
            (inside, State::read())
        };
        let after = State::read();
        usual.write();
        assert_eq!(inside, ODD);
        assert_eq!(again.0 & !0x3f, State::DEFAULT.0);
        assert_eq!(after, State(ODD.0 | 0x4), "what the caller's code did stays");
    }
}

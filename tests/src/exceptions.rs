//! Records the floating-point exceptions that calls raise. Hosts that trap invalid, divide-by-zero and overflow (usual in Fortran codes) must not
//! stop on ordinary input.
//!
//! The flags are read instead of trapped, so that a failure names the call. Flags belong to a thread, and all calls run on that thread.
#![expect(unsafe_code, reason = "the flags belong to C's floating-point environment")]

use std::fmt::Display;

/// The flags of C's `<fenv.h>` and the functions that clear and read them.
#[cfg(all(target_os = "linux", target_env = "gnu", any(target_arch = "x86_64", target_arch = "aarch64")))]
mod flags {
    use std::ffi::c_int;

    /// The flags with the names of glibc.
    pub const ALL: [(c_int, &str); 3] = if cfg!(target_arch = "x86_64") {
        [(1, "invalid"), (4, "divide-by-zero"), (8, "overflow")]
    } else {
        [(1, "invalid"), (2, "divide-by-zero"), (4, "overflow")]
    };

    #[link(name = "m")]
    unsafe extern "C" {
        pub fn feclearexcept(which: c_int) -> c_int;
        pub fn fetestexcept(which: c_int) -> c_int;
    }
}

/// Clears the flags of this thread.
pub fn clear() {
    #[cfg(all(target_os = "linux", target_env = "gnu", any(target_arch = "x86_64", target_arch = "aarch64")))]
    // SAFETY: the call clears flags of this thread.
    unsafe {
        flags::feclearexcept(flags::ALL.iter().fold(0, |all, (flag, _)| all | flag));
    }
}

/// Those of invalid, divide-by-zero and overflow that this thread has raised since. Empty with C libraries other than glibc.
#[must_use]
pub fn raised() -> Vec<&'static str> {
    #[cfg(all(target_os = "linux", target_env = "gnu", any(target_arch = "x86_64", target_arch = "aarch64")))]
    // SAFETY: the call reads flags of this thread.
    return unsafe {
        let set = |flag| flags::fetestexcept(flag) != 0;
        flags::ALL.iter().filter(|(flag, _)| set(*flag)).map(|(_, name)| *name).collect()
    };
    #[cfg(not(all(target_os = "linux", target_env = "gnu", any(target_arch = "x86_64", target_arch = "aarch64"))))]
    Vec::new()
}

/// A series of calls, each expected to succeed and to raise none of the three exceptions.
#[derive(Debug, Default)]
pub struct Rows {
    failed: Vec<String>,
    count: usize,
}

impl Rows {
    /// Makes a call, which returns its status.
    pub fn row(&mut self, name: impl Display, call: impl FnOnce() -> i32) {
        self.count += 1;
        clear();
        let status = call();
        let raised = raised();
        if status != 0 {
            self.failed.push(format!("{name}: status {status}"));
        }
        if !raised.is_empty() {
            self.failed.push(format!("{name}: {}", raised.join(", ")));
        }
    }

    /// Fails with the list of calls that did not behave as expected.
    ///
    /// # Panics
    /// If there is such a call, or if no call was made.
    pub fn finish(self) {
        assert!(self.count > 0);
        assert!(self.failed.is_empty(), "{} of {} calls:\n{}", self.failed.len(), self.count, self.failed.join("\n"));
    }
}

#[cfg(all(test, target_os = "linux", target_env = "gnu", any(target_arch = "x86_64", target_arch = "aarch64")))]
mod tests {
    use super::{clear, raised};
    use std::hint::black_box;

    #[test]
    fn each_is_seen() {
        clear();
        assert!(black_box(black_box(1.0_f64) / 3.0) > 0.0 && raised().is_empty());
        for (a, b, name) in [(0.0_f64, 0.0, "invalid"), (1.0, 0.0, "divide-by-zero"), (1e300, 1e-300, "overflow")] {
            clear();
            black_box(black_box(a) / black_box(b));
            assert_eq!(raised(), [name]);
        }
    }
}

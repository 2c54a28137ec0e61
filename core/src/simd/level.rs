//! Detection of the instruction sets of this machine, done once and cached in one atomic.

/// The instruction set that a call uses.
///
/// A level is an argument of a call and is never stored in a prepared object, so a checkpoint can move between machines.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[repr(i32)]
pub enum Level {
    /// Only + - * / and sqrt, in one defined order: the same bits on every machine.
    Portable = 0,
    /// 128-bit vectors, available on every aarch64.
    Neon = 1,
    /// 256-bit vectors with fused multiply-add.
    Avx2 = 2,
    /// 512-bit vectors (F, DQ, BW, VL).
    Avx512 = 3,
}

impl Level {
    /// Every level, slowest first.
    pub const ALL: [Level; 4] = [Level::Portable, Level::Neon, Level::Avx2, Level::Avx512];

    /// The fastest level of this machine. The first call queries the processor, later calls read an atomic.
    #[must_use]
    pub fn best() -> Self {
        machine::best()
    }

    /// Whether this machine can run the level. Calls with a level that it cannot run return
    /// [`crate::Error::Unsupported`].
    #[must_use]
    pub fn is_available(self) -> bool {
        match self {
            Level::Portable => true,
            Level::Neon => cfg!(target_arch = "aarch64"),
            Level::Avx2 | Level::Avx512 => cfg!(target_arch = "x86_64") && self <= Level::best(),
        }
    }

    /// The levels that this machine can run, slowest first, for tests to iterate over.
    pub fn available() -> impl Iterator<Item = Self> {
        Self::ALL.into_iter().filter(|level| level.is_available())
    }

    /// Its name: `portable`, `neon`, `avx2`, `avx512`.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Level::Portable => "portable",
            Level::Neon => "neon",
            Level::Avx2 => "avx2",
            Level::Avx512 => "avx512",
        }
    }
}

impl Default for Level {
    fn default() -> Self {
        Self::best()
    }
}

#[cfg(target_arch = "x86_64")]
mod machine {
    use core::arch::x86_64::{__cpuid, __cpuid_count, _xgetbv};
    use core::sync::atomic::{AtomicU8, Ordering};

    use super::Level;

    /// 0 before detection, then 1 + the level. The only global of the crate. Concurrent first calls repeat the detection.
    static FOUND: AtomicU8 = AtomicU8::new(0);

    pub fn best() -> Level {
        match FOUND.load(Ordering::Relaxed) {
            1 => Level::Portable,
            3 => Level::Avx2,
            4 => Level::Avx512,
            _ => {
                let level = detect();
                FOUND.store(1 + level as u8, Ordering::Relaxed);
                level
            }
        }
    }

    /// Queries the processor, and whether the operating system saves the wide registers (XCR0). A processor with AVX-512 must not execute
    /// one such instruction under an operating system without it. (cpuid traps under a hypervisor: 10 us each.)
    fn detect() -> Level {
        let (leaf1, highest) = (__cpuid(1), __cpuid(0).eax);
        let bit = |word: u32, n: u32| word >> n & 1 == 1;
        let (fma, osxsave, avx) = (bit(leaf1.ecx, 12), bit(leaf1.ecx, 27), bit(leaf1.ecx, 28));
        if !(fma && osxsave && avx) || highest < 7 {
            return Level::Portable;
        }
        // SAFETY: OSXSAVE is set, so the system has enabled the instruction.
        #[expect(unsafe_code, reason = "XGETBV, after its cpuid bit was seen")]
        let saved = unsafe { saved_registers() };
        let leaf7 = __cpuid_count(7, 0).ebx;
        // XMM and YMM: bits 1, 2. Opmasks and ZMM: bits 5, 6, 7.
        if saved & 0x06 != 0x06 || !bit(leaf7, 5) {
            return Level::Portable;
        }
        let wide = bit(leaf7, 16) && bit(leaf7, 17) && bit(leaf7, 30) && bit(leaf7, 31);
        if saved & 0xE6 == 0xE6 && wide { Level::Avx512 } else { Level::Avx2 }
    }

    #[target_feature(enable = "xsave")]
    #[expect(unsafe_code, reason = "XGETBV")]
    fn saved_registers() -> u64 {
        // SAFETY: register 0 exists wherever the instruction does.
        unsafe { _xgetbv(0) }
    }
}

#[cfg(not(target_arch = "x86_64"))]
mod machine {
    use super::Level;

    pub const fn best() -> Level {
        // Every aarch64 has 128-bit vectors, so nothing is detected.
        if cfg!(target_arch = "aarch64") { Level::Neon } else { Level::Portable }
    }
}

#[cfg(test)]
mod tests {
    use super::Level;

    #[test]
    fn the_best_level_is_what_the_standard_library_finds() {
        #[cfg(target_arch = "x86_64")]
        {
            let avx2 = std::is_x86_feature_detected!("avx2") && std::is_x86_feature_detected!("fma");
            let avx512 = avx2
                && std::is_x86_feature_detected!("avx512f")
                && std::is_x86_feature_detected!("avx512dq")
                && std::is_x86_feature_detected!("avx512bw")
                && std::is_x86_feature_detected!("avx512vl");
            assert_eq!(Level::Avx2.is_available(), avx2);
            assert_eq!(Level::Avx512.is_available(), avx512);
        }
        assert!(Level::available().eq(Level::available().filter(|&l| l <= Level::best())));
        assert_eq!(Level::available().last(), Some(Level::best()));
        assert_eq!(Level::best(), Level::best());
    }
}

//! Calls under another floating-point control than Rust's own, as a host may set it: directed rounding, subnormal numbers taken as zero, traps.
#![expect(unsafe_code, reason = "the control register belongs to the processor")]

use std::arch::asm;

/// Flags of the exceptions that have arisen.
const FLAGS: u32 = 0x3F;
/// The masks of invalid, divide-by-zero and overflow. An exception whose mask is clear traps.
const MASKS: u32 = 1 << 7 | 1 << 9 | 1 << 10;
/// Both bits of the rounding direction.
const ROUNDING: u32 = 3 << 13;
/// Subnormal results, and subnormal operands, are zero.
const ZERO: u32 = 1 << 15 | 1 << 6;

/// Another control: bits of MXCSR that are set, and bits that are cleared.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Control {
    /// For messages.
    pub name: &'static str,
    set: u32,
    clear: u32,
}

impl Control {
    /// Invalid, divide-by-zero and overflow stop the program.
    pub const TRAPS: Self = Self { name: "traps", set: 0, clear: MASKS | FLAGS };

    /// Every rounding direction, with and without subnormal numbers.
    pub const ALL: [Self; 8] = [
        Self::of("nearest", 0, 0),
        Self::of("down", 1, 0),
        Self::of("up", 2, 0),
        Self::of("towards zero", 3, 0),
        Self::of("nearest, no subnormal numbers", 0, ZERO),
        Self::of("down, no subnormal numbers", 1, ZERO),
        Self::of("up, no subnormal numbers", 2, ZERO),
        Self::of("towards zero, no subnormal numbers", 3, ZERO),
    ];

    const fn of(name: &'static str, direction: u32, zero: u32) -> Self {
        Self { name, set: direction << 13 | zero, clear: ROUNDING }
    }

    /// Calls the function under this control, on this thread alone. The former control returns with the result, or with a panic.
    #[inline(never)]
    pub fn during<R>(self, call: impl FnOnce() -> R) -> R {
        struct Former(u32);
        impl Drop for Former {
            fn drop(&mut self) {
                write(self.0);
            }
        }
        let former = Former(read());
        write(former.0 & !self.clear | self.set);
        call()
    }
}

/// MXCSR.
#[inline(never)]
fn read() -> u32 {
    let mut value = 0_u32;
    // SAFETY: the instruction writes four bytes to the address.
    unsafe { asm!("stmxcsr [{}]", in(reg) &raw mut value, options(nostack, preserves_flags)) };
    value
}

/// Overwrites MXCSR. Functions that are compiled in line may be moved across, so callers are not.
#[inline(never)]
fn write(value: u32) {
    // SAFETY: the value was read from the register but for defined bits, so that no reserved one is set.
    unsafe { asm!("ldmxcsr [{}]", in(reg) &raw const value, options(nostack, preserves_flags)) };
}

#[cfg(test)]
mod tests {
    use super::Control;
    use std::hint::black_box;

    #[test]
    fn each_control_is_felt_and_restored() {
        let third = |sign: f64| black_box(sign) / black_box(3.0);
        let half = || black_box(f64::MIN_POSITIVE) * black_box(0.5);
        let plain = (third(1.0), third(-1.0), half());
        for control in Control::ALL {
            let (plus, minus, small) = control.during(|| (third(1.0), third(-1.0), half()));
            // 1/3 in binary is rounded down to the nearest number.
            let next = f64::from_bits(plain.0.to_bits() + 1);
            let want = match control.name.split(',').next() {
                Some("down") => (plain.0, -next),
                Some("up") => (next, plain.1),
                _ => (plain.0, plain.1),
            };
            assert_eq!((plus, minus), want, "{}", control.name);
            assert_eq!(small == 0.0, control.name.ends_with("numbers"), "{}", control.name);
            assert_eq!((third(1.0), third(-1.0), half()), plain, "{}", control.name);
        }
        assert_eq!(Control::TRAPS.during(|| third(1.0)), plain.0);
    }
}

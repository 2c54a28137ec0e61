//! Every level of instructions that this machine has: the operations of the lanes, the direct sum, and the sums of every kernel.
//!
//! With `MOLLIS_LEVEL` set to a level's name only that one runs, and a machine without it fails; with `MOLLIS_THIN` set there are fewer cases, for
//! emulators. (`cargo xtask avx512` runs these tests so.)

mod direct;
mod kernels;
mod operations;

use mollis_core::simd::Level;
use mollis_tests::Split;

/// The levels to test.
fn levels() -> Vec<Level> {
    let Ok(name) = std::env::var("MOLLIS_LEVEL") else { return Level::available().collect() };
    let level = Level::ALL.into_iter().find(|level| level.name() == name).expect("MOLLIS_LEVEL names no level");
    assert!(level.is_available(), "this machine has no {name}");
    vec![level]
}

/// So many cases; a twentieth of them in an emulator.
fn cases(n: usize) -> usize {
    if std::env::var_os("MOLLIS_THIN").is_some() { n.div_ceil(20) } else { n }
}

/// Numbers for the tests.
struct Random(Split);

impl Random {
    fn new(seed: u64) -> Self {
        Self(Split(seed))
    }

    fn bits(&mut self) -> u64 {
        self.0.next()
    }

    /// In -1..1, exact in f32.
    fn number(&mut self) -> f64 {
        (self.bits() >> 40) as f64 / f64::from(1_u32 << 23) - 1.0
    }

    /// Below `n`.
    fn below(&mut self, n: usize) -> usize {
        (self.bits() >> 33) as usize % n
    }
}

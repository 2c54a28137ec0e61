//! Helpers for several tests.

mod cloud;
#[cfg(target_arch = "x86_64")]
pub mod control;
pub mod exceptions;
pub mod positional;
pub mod ranks;
pub mod sums;

pub use cloud::Cloud;

use std::ffi::c_void;
use std::sync::atomic::{AtomicUsize, Ordering};

use mollis_core::Result;
use mollis_core::exec::Executor;
use mollis_core::memory::ALIGN;
use mollis_core::random::Generator;

/// Bytes with arbitrary contents that start at a multiple of [`ALIGN`], inside a slightly larger block with arbitrary contents.
#[derive(Debug)]
pub struct Aligned {
    memory: Vec<u8>,
    start: usize,
    len: usize,
}

impl Aligned {
    const DIRT: u8 = 0xA5;

    /// This many bytes.
    #[must_use]
    pub fn new(len: usize) -> Self {
        let memory = vec![Self::DIRT; len + ALIGN];
        let start = memory.as_ptr().align_offset(ALIGN);
        Self { memory, start, len }
    }

    /// The bytes.
    pub fn bytes(&mut self) -> &mut [u8] {
        &mut self.memory[self.start..self.start + self.len]
    }

    /// The pointer to the bytes, for C.
    pub fn pointer(&mut self) -> *mut c_void {
        self.bytes().as_mut_ptr().cast()
    }

    /// The pointer to the bytes, to read.
    #[must_use]
    pub fn start(&self) -> *const c_void {
        self.memory[self.start..].as_ptr().cast()
    }

    /// Whether nothing was written, neither inside nor around.
    #[must_use]
    pub fn is_untouched(&self) -> bool {
        self.memory.iter().all(|&byte| byte == Self::DIRT)
    }
}

/// An executor with this many threads, which take tasks in turn.
#[derive(Debug)]
pub struct Threads(pub usize);

impl Executor for Threads {
    fn workers(&self) -> usize {
        self.0
    }

    fn run(&self, tasks: usize, task: &(dyn Fn(usize) + Sync)) -> Result<()> {
        let next = AtomicUsize::new(0);
        std::thread::scope(|scope| {
            for worker in 0..self.0 {
                let next = &next;
                scope.spawn(move || {
                    while next.fetch_add(1, Ordering::Relaxed) < tasks {
                        task(worker);
                    }
                });
            }
        });
        Ok(())
    }
}

/// SplitMix64 (Steele, Lea & Flood 2014), for initial conditions and as a stream.
#[derive(Clone, Copy, Debug)]
pub struct Split(pub u64);

impl Split {
    /// The next word.
    #[expect(clippy::should_implement_trait, reason = "it never ends")]
    pub fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let z = (self.0 ^ self.0 >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let z = (z ^ z >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ z >> 31
    }

    /// A number in [0, 1).
    pub fn uniform(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1_u64 << 53) as f64
    }
}

impl Generator for Split {
    fn fill(&mut self, _: u64, _: u32, _: u32, out: &mut [u64]) -> Result<()> {
        out.iter_mut().for_each(|word| *word = self.next());
        Ok(())
    }
}

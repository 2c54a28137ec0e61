//! The C interface as sequences of calls with hostile arguments: nothing crashes, nothing is written beside a buffer or to an input, the status is a known
//! one, and a refused call leaves its outputs as they were.
//!
//! Arguments keep the contract of the header as far as the library can't check it: a pointer that is neither null nor misaligned has its length.
#![expect(unsafe_code, reason = "calls the C ABI as a C program does")]

mod coalescing;
mod forms;
mod host;
mod kernels;
mod meshes;
mod particles;
mod small;
mod sums;

use std::cell::RefCell;

use mollis_core::Error;

use crate::draw::Draw;
use crate::memory::{LARGE, Memory, Role};
use forms::Form;
use kernels::Kernels;

/// Statuses that only functions of the host return.
const OF_HOST: [i32; 3] = [300, -7, i32::MIN];

thread_local! {
    /// The same pages serve all inputs.
    static MEMORY: RefCell<Memory> = RefCell::default();
}

/// The calls that these bytes say.
pub fn abi(bytes: &[u8]) {
    MEMORY.with_borrow_mut(|memory| {
        let mut calls = Calls { draw: Draw::new(bytes), memory, kernels: Kernels::default() };
        for _ in 0..16 {
            if calls.draw.is_empty() {
                break;
            }
            calls.call();
        }
    });
}

/// A sequence of calls.
struct Calls<'a, 'm> {
    draw: Draw<'a>,
    memory: &'m mut Memory,
    kernels: Kernels,
}

impl Calls<'_, '_> {
    fn call(&mut self) {
        self.memory.clear();
        let first = self.draw.byte();
        self.draw.tame = first < 128;
        match first % 8 {
            0 => self.in_form::<f64, 1>(),
            1 | 2 => self.in_form::<f64, 2>(),
            3 => self.in_form::<f64, 3>(),
            4 => self.in_form::<f32, 1>(),
            5 => self.in_form::<f32, 2>(),
            6 => self.in_form::<f32, 3>(),
            _ => self.without_form(),
        }
    }

    fn in_form<T: Form<D> + Form<2>, const D: usize>(&mut self) {
        match self.draw.below(12) {
            0 | 1 => self.sum::<T, D>(),
            2 | 3 => self.blob::<T, D>(),
            4 => self.prepare::<T, D>(),
            5 => self.evaluate_kernel::<T, D>(),
            6 => self.mollifier::<T, D>(),
            7 => self.diagnostics::<T, D>(),
            8 => self.norms::<T, D>(),
            9 => self.mesh::<T>(),
            _ => self.coalescing::<T>(),
        }
    }

    /// A pointer to these values, or one that the library must notice.
    fn pointer<T: Copy>(&mut self, values: &[T], role: Role) -> *mut T {
        let align = align_of::<T>();
        if values.is_empty() {
            return match self.draw.below(3) {
                0 => std::ptr::null_mut(),
                1 => std::ptr::without_provenance_mut(64),
                _ => self.memory.place(0, align, 0, role).cast(),
            };
        }
        let mut offset = 0;
        if !self.draw.tame && self.draw.rarely(40) {
            match self.draw.below(4) {
                0 | 1 => return std::ptr::null_mut(),
                shift if align > 1 => offset = 1 + (shift * 3) % (align - 1),
                _ => {}
            }
        }
        let start = self.memory.place(size_of_val(values), align, offset, role);
        // SAFETY: room for them, wherever it begins.
        unsafe { start.copy_from_nonoverlapping(values.as_ptr().cast(), size_of_val(values)) };
        start.cast()
    }

    fn input<T: Copy>(&mut self, values: &[T]) -> *const T {
        self.pointer(values, Role::Input)
    }

    fn output<T: Copy>(&mut self, n: usize, value: T) -> *mut T {
        self.pointer(&vec![value; n], Role::Output)
    }

    /// An output that may be null, which means "not wanted".
    fn perhaps<T: Copy>(&mut self, n: usize, value: T) -> *mut T {
        if self.draw.rarely(3) { std::ptr::null_mut() } else { self.output(n, value) }
    }

    /// What tells why a call was refused, or null.
    fn told<T: Copy>(&mut self, value: T) -> *mut T {
        if self.draw.rarely(3) { std::ptr::null_mut() } else { self.pointer(&[value], Role::Scratch) }
    }

    /// A structure that begins with its size, as a program with another header passes it: no byte behind that size is there.
    fn options<T: Copy>(&mut self, mut value: T) -> *const T {
        if self.draw.rarely(4) {
            return std::ptr::null();
        }
        let full = size_of::<T>();
        if self.draw.tame || !self.draw.rarely(6) {
            return self.input(&[value]);
        }
        let size = usize::from(self.draw.byte()) % (full + 24);
        let held = size.clamp(4, full);
        let start = self.memory.place(held, align_of::<T>(), 0, Role::Input);
        // SAFETY: the structures are plain and begin with a `u32`; `held` bytes fit both.
        unsafe {
            (&raw mut value).cast::<u32>().write(size as u32);
            start.copy_from_nonoverlapping((&raw const value).cast(), held);
        }
        start.cast()
    }

    /// The number of elements that a call is told: rarely one that no memory holds.
    fn stated(&mut self, n: usize) -> usize {
        if !self.draw.tame && self.draw.rarely(60) { self.draw.pick(&[usize::MAX, 1 << 63, usize::MAX - 1]) } else { n }
    }

    fn numbers<T: forms::Scalar>(&mut self, n: usize) -> Vec<T> {
        self.draw.numbers(n, false).into_iter().map(T::of).collect()
    }

    fn positive<T: forms::Scalar>(&mut self, n: usize) -> Vec<T> {
        self.draw.numbers(n, true).into_iter().map(T::of).collect()
    }

    fn points<T: forms::Scalar, const D: usize>(&mut self, n: usize) -> Vec<[T; D]> {
        let numbers = self.numbers::<T>(n * D);
        numbers.chunks_exact(D).map(|x| std::array::from_fn(|k| x[k])).collect()
    }

    /// A workspace for a call whose size query said so: of these bytes, or of others. Returns whether they suffice.
    fn workspace(&mut self, needed: Option<usize>) -> Option<(*mut std::ffi::c_void, usize, bool)> {
        let asked = needed.unwrap_or(1000);
        if asked > LARGE {
            return None;
        }
        let (mut bytes, mut offset) = (asked, 0);
        if !self.draw.tame {
            match self.draw.below(12) {
                0 => bytes = asked.saturating_sub(1 + self.draw.below(200)),
                1 => bytes = 0,
                2 => bytes = asked / 2,
                3 => return Some((std::ptr::null_mut(), asked, false)),
                4 => bytes = asked + self.draw.below(100),
                5 | 6 => offset = self.draw.below(64),
                _ => {}
            }
        }
        let start = self.memory.place(bytes, 1, offset, Role::Scratch);
        Some((start.cast(), bytes, needed.is_some() && bytes >= asked))
    }

    fn begin(&mut self) {
        self.memory.begin();
    }

    /// Checks the status and the buffers of a call.
    fn end(&mut self, what: &str, status: i32) {
        if std::env::var_os("MOLLIS_FUZZ_LOG").is_some() {
            eprintln!("{what}: {status}");
        }
        let error = Error::from_code(status);
        let known = status == 0 || error.is_some() || OF_HOST.contains(&status);
        assert!(known, "{what}: unknown status {status}");
        assert!(error != Some(Error::Internal), "{what}: an invariant is broken");
        // From 40 on a run stopped; below that the arguments were refused.
        self.memory.check(what, status, (1..40).contains(&status));
    }
}

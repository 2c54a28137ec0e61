//! Kernels: size, preparation, values; and blocks for other calls, whole or spoiled.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::ffi::c_void;

use mollis_abi::*;

use super::Calls;
use super::forms::Form;
use crate::memory::{LARGE, Role};

/// Prepared blocks, by the index of their form.
#[derive(Default)]
pub struct Kernels {
    blocks: Vec<(usize, Vec<u8>)>,
    /// Preparations of this input, which take longer than other calls.
    made: usize,
}

/// A kernel's block as an argument.
pub struct Block {
    pub start: *const c_void,
    pub bytes: usize,
    /// It is what the library prepared.
    pub whole: bool,
}

impl Calls<'_, '_> {
    /// A mollifier.
    pub fn shape(&mut self) -> mollis_mollifier {
        if !self.draw.tame && self.draw.rarely(8) {
            let any = |byte: u8| i32::from(byte as i8);
            let (kind, order, exponent) = (self.draw.byte(), self.draw.byte(), self.draw.byte());
            return mollis_mollifier { kind: i32::from(kind % 8), order: any(order), exponent: any(exponent) };
        }
        let kind = self.draw.pick(&[1, 6, 1, 0, 2, 3, 4, 5]);
        mollis_mollifier { kind, order: self.draw.pick(&[2, 4, 6, 8]), exponent: self.draw.pick(&[4, 1, 2, 9]) }
    }

    /// The mollifier's length.
    pub fn delta(&mut self) -> f64 {
        let usual = self.draw.positive();
        self.draw.or_wild(usual)
    }

    fn terms(&mut self) -> Vec<mollis_kernel_term> {
        let most = if self.draw.tame { 2 } else { self.draw.pick(&[1, 2, 3, 8, 9, 0]) };
        (0..most)
            .map(|_| {
                let kind = self.draw.pick(&[0, 0, 1, 2, 3]);
                let usual =
                    if kind == 1 { self.draw.pick(&[2.0, 4.0, 0.5, 1.5, 0.0, -0.5]) } else { self.draw.positive() };
                let coefficient = self.draw.plain();
                mollis_kernel_term {
                    kind: if !self.draw.tame && self.draw.rarely(20) { self.draw.wild() as i32 } else { kind },
                    reserved: 0,
                    coefficient: self.draw.or_wild(coefficient),
                    parameter: [self.draw.or_wild(usual), 0.0],
                }
            })
            .collect()
    }

    pub fn prepare<T: Form<D>, const D: usize>(&mut self) {
        if self.kernels.made > 0 {
            return;
        }
        self.kernels.made += 1;
        let (terms, mollifier, own) = (self.terms(), self.shape(), self.own());
        let (pointer, n) = (self.input(&terms), self.stated(terms.len()));
        let bytes = self.output(1, 0_usize);
        self.begin();
        // SAFETY: every pointer is null, misaligned, or has its length.
        let status = unsafe { T::kernel_bytes(pointer, n, own, mollifier, bytes) };
        self.end("kernel_bytes", status);
        // SAFETY: written, as the call succeeded.
        let needed = if status == 0 { unsafe { *bytes } } else { 3000 };
        if needed > LARGE {
            return;
        }
        let given =
            if self.draw.tame || !self.draw.rarely(8) { needed } else { needed - needed.min(self.draw.below(256)) };
        let align = if self.draw.rarely(4) { 8 } else { 64 };
        let offset = if !self.draw.tame && self.draw.rarely(16) { self.draw.below(64) } else { 0 };
        // Of a refused preparation the block may be anything.
        let start = self.memory.place(given, align, offset, Role::Scratch);
        let delta = T::of(self.delta());
        self.begin();
        // SAFETY: as above.
        let made = unsafe { T::kernel_prepare(start.cast(), given, pointer, n, own, mollifier, delta) };
        self.end("kernel_prepare", made);
        if status == 0 && made == 0 {
            assert!(given >= needed, "prepared in {given} of {needed} bytes");
            // SAFETY: this many bytes were placed.
            let block = unsafe { std::slice::from_raw_parts(start, given) }.to_vec();
            self.kernels.blocks.push((T::INDEX, block));
        }
    }

    /// A block for a call: of this form if there is one, else a Newtonian kernel; rarely another one or a spoiled one.
    pub fn kernel<T: Form<D>, const D: usize>(&mut self) -> Block {
        let mut fitting: Vec<usize> = (0..self.kernels.blocks.len()).collect();
        let mut whole = true;
        if self.draw.tame || !self.draw.rarely(10) {
            fitting.retain(|&k| self.kernels.blocks[k].0 == T::INDEX);
        } else {
            whole = false;
        }
        let mut block = match fitting.last() {
            Some(&last) if !self.draw.rarely(8) => self.kernels.blocks[last].1.clone(),
            _ => newtonian::<T, D>(self.draw.pick(&[1, 1, 0, 2, 3]), self.draw.pick(&[4, 2, 0])),
        };
        if !self.draw.tame && self.draw.rarely(12) {
            whole = false;
            match self.draw.below(4) {
                0 => block.truncate(usize::from(self.draw.byte()) * 8 % (block.len() + 1)),
                1 => block.fill(0),
                2 => {
                    // The head checks mistakes, and is no border of safety: its kind, version and sizes may be wrong.
                    let at = self.draw.below(block.len().clamp(1, 24));
                    block[at] ^= 1 << self.draw.below(8);
                }
                _ => block.truncate(block.len() - 1),
            }
        }
        let bytes = block.len();
        if bytes == 0 {
            return Block { start: std::ptr::null(), bytes, whole: false };
        }
        let align = if self.draw.rarely(4) { 8 } else { 64 };
        let offset = if !self.draw.tame && self.draw.rarely(40) { self.draw.below(16) } else { 0 };
        let start = self.memory.place(bytes, align, offset, Role::Input);
        // SAFETY: room for them.
        unsafe { start.copy_from_nonoverlapping(block.as_ptr(), bytes) };
        Block { start: start.cast_const().cast(), bytes, whole: whole && offset == 0 }
    }

    pub fn evaluate_kernel<T: Form<D>, const D: usize>(&mut self) {
        let block = self.kernel::<T, D>();
        let n = self.draw.count();
        let r = self.numbers::<T>(n);
        let (r, n_stated) = (self.input(&r), self.stated(n));
        let zero = T::of(7.0);
        let [value, factor, laplacian] = std::array::from_fn(|_| self.perhaps(n, zero));
        self.begin();
        // SAFETY: as above.
        let status = unsafe { T::kernel_eval(block.start, block.bytes, n_stated, r, value, factor, laplacian) };
        self.end("kernel_eval", status);
    }
}

/// Form, mollifier's kind, and exponent of its length.
type Which = (usize, i32, i32);

thread_local! {
    /// Kernels that many inputs use.
    static USUAL: RefCell<BTreeMap<Which, Vec<u8>>> = RefCell::default();
}

/// A Newtonian kernel under a mollifier of this kind and the length `2^-length`.
fn newtonian<T: Form<D>, const D: usize>(kind: i32, length: i32) -> Vec<u8> {
    let made = USUAL.with_borrow(|usual| usual.get(&(T::INDEX, kind, length)).cloned());
    made.unwrap_or_else(|| {
        let block = prepared::<T, D>(kind, 2_f64.powi(-length));
        USUAL.with_borrow_mut(|usual| usual.insert((T::INDEX, kind, length), block.clone()));
        block
    })
}

fn prepared<T: Form<D>, const D: usize>(kind: i32, delta: f64) -> Vec<u8> {
    let term = mollis_kernel_term { kind: MOLLIS_KERNEL_NEWTONIAN, reserved: 0, coefficient: 1.0, parameter: [0.0; 2] };
    let mollifier = mollis_mollifier { kind, order: 2, exponent: 4 };
    let mut bytes = 0;
    // SAFETY: sound arguments.
    unsafe {
        assert_eq!(T::kernel_bytes(&raw const term, 1, std::ptr::null(), mollifier, &raw mut bytes), 0);
        let mut words = vec![0_u64; bytes.div_ceil(8)];
        let made = T::kernel_prepare(
            words.as_mut_ptr().cast(),
            bytes,
            &raw const term,
            1,
            std::ptr::null(),
            mollifier,
            T::of(delta),
        );
        assert_eq!(made, 0);
        std::slice::from_raw_parts(words.as_ptr().cast(), bytes).to_vec()
    }
}

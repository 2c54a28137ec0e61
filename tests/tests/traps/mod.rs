//! Ordinary input raises none of the floating-point exceptions that hosts trap: invalid, divide-by-zero and overflow. One row for each function of
//! the header and kind of input.
#![expect(unsafe_code, reason = "calls the C ABI as a C program does")]
#![allow(
    clippy::undocumented_unsafe_blocks,
    reason = "each call passes buffers of the stated sizes that live through it"
)]

mod diagnostics;
mod field;
mod kernels;
mod meshes;
mod mollifiers;
mod others;
mod particles;

use std::ffi::c_void;

use mollis_abi::*;

const NONE: mollis_mollifier = mollis_mollifier { kind: MOLLIS_MOLLIFIER_NONE, order: 0, exponent: 0 };

const fn compact(order: i32, exponent: i32) -> mollis_mollifier {
    mollis_mollifier { kind: MOLLIS_MOLLIFIER_COMPACT, order, exponent }
}

const fn gaussian(order: i32) -> mollis_mollifier {
    mollis_mollifier { kind: MOLLIS_MOLLIFIER_GAUSSIAN, order, exponent: 0 }
}

const fn richardson(order: i32, exponent: i32) -> mollis_mollifier {
    mollis_mollifier { kind: MOLLIS_MOLLIFIER_RICHARDSON, order, exponent }
}

/// Mollifiers of each kind that exist in this dimension.
fn mollifiers_in(dimension: usize) -> Vec<mollis_mollifier> {
    let mut all = vec![NONE, compact(2, 1), compact(2, 4), compact(4, 4), compact(6, 9), compact(8, 2)];
    all.extend([richardson(4, 4), richardson(6, 1)]);
    all.extend([gaussian(4)].into_iter().filter(|_| dimension < 3));
    all.extend([gaussian(6)].into_iter().filter(|_| dimension == 1));
    all
}

fn name(mollifier: mollis_mollifier) -> String {
    let mollis_mollifier { kind, order, exponent } = mollifier;
    let kinds = ["none", "compact", "Gaussian", "Plummer", "algebraic", "Vatistas", "Richardson"];
    format!("{} {order} {exponent}", kinds[kind as usize])
}

/// Points on a skew lattice, with the origin and two equal points among them.
macro_rules! points {
    ($n:expr, $t:ty, $d:literal) => {{
        let at = |k: usize, d: usize| ((k * 7 + d * 3) as f64 * 0.31 % 1.7 - 0.85) as $t;
        let mut points: Vec<[$t; $d]> = (0..$n).map(|k| std::array::from_fn(|d| at(k, d))).collect();
        points[0] = [0.0; $d];
        points[3] = points[2];
        points
    }};
}
use points;

/// The pointer to the bytes, for C.
fn pointer(memory: &mut mollis_tests::Aligned) -> *mut c_void {
    memory.pointer()
}

//! Vectors of portable code.

/// Of any instruction set: sixteen f32 in 512 bits.
pub const MAX_LANES: usize = 16;

/// Numbers in a vector: two SSE2 registers in f64, so that the loops stay in registers.
pub const LANES: usize = 4;

#[inline(always)]
pub fn first<T: Copy>(from: &[T; MAX_LANES]) -> [T; LANES] {
    let [a, b, c, d, ..] = *from;
    [a, b, c, d]
}

#[inline(always)]
pub fn each<T: Copy, R>(a: [T; LANES], mut f: impl FnMut(T) -> R) -> [R; LANES] {
    let [a0, a1, a2, a3] = a;
    [f(a0), f(a1), f(a2), f(a3)]
}

#[inline(always)]
pub fn both<A: Copy, B: Copy, R>(a: [A; LANES], b: [B; LANES], mut f: impl FnMut(A, B) -> R) -> [R; LANES] {
    let ([a0, a1, a2, a3], [b0, b1, b2, b3]) = (a, b);
    [f(a0, b0), f(a1, b1), f(a2, b2), f(a3, b3)]
}

//! Vectors of portable code for machines without vectors and with little flash: one number. Lanes are independent, so the bits are the same.

/// There is no other instruction set.
pub const MAX_LANES: usize = 1;
pub const LANES: usize = 1;

#[inline(always)]
pub fn first<T: Copy>(from: &[T; 1]) -> [T; 1] {
    *from
}

#[inline(always)]
pub fn each<T: Copy, R>([a]: [T; 1], mut f: impl FnMut(T) -> R) -> [R; 1] {
    [f(a)]
}

#[inline(always)]
pub fn both<A: Copy, B: Copy, R>([a]: [A; 1], [b]: [B; 1], mut f: impl FnMut(A, B) -> R) -> [R; 1] {
    [f(a, b)]
}

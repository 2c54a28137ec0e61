//! Polynomials of one to three variables, in lanes.

use super::{LANES, MONOMIALS, monomials};
use crate::checked::Present;
use crate::real::Real;

/// A polynomial of one variable by Horner's rule, lane by lane: the first `N` of `c`, lowest power first.
#[inline(always)]
pub(super) fn row<T: Real, const N: usize>(c: &[T], x: &[T; LANES]) -> [T; LANES] {
    match c.first_chunk::<N>() {
        Some(c) => any_row(c, x),
        None => [T::ZERO; LANES],
    }
}

/// The same of any number of coefficients.
#[inline(always)]
pub(super) fn any_row<T: Real>(c: &[T], x: &[T; LANES]) -> [T; LANES] {
    let Some((highest, rest)) = c.split_last() else { return [T::ZERO; LANES] };
    let mut sum = [*highest; LANES];
    for &c in rest.iter().rev() {
        sum.iter_mut().zip(x).for_each(|(s, &x)| *s = *s * x + c);
    }
    sum
}

/// The same of the first `n`; the short ones of the usual degrees have loops of known length.
#[inline(always)]
pub(super) fn first_row<T: Real>(c: &[T], n: usize, x: &[T; LANES]) -> [T; LANES] {
    match n {
        1 => row::<T, 1>(c, x),
        2 => row::<T, 2>(c, x),
        3 => row::<T, 3>(c, x),
        4 => row::<T, 4>(c, x),
        5 => row::<T, 5>(c, x),
        _ => any_row(c.get(..n).present_or(&[]), x),
    }
}

/// A polynomial by Horner's rule in each variable, lane by lane.
#[inline(always)]
pub(super) fn horner<T: Real, const D: usize>(c: &[T; MONOMIALS], degree: usize, x: &[[T; LANES]; D]) -> [T; LANES] {
    let none = [T::ZERO; LANES];
    let (x0, x1, x2) = (x.first().unwrap_or(&none), x.get(1).unwrap_or(&none), x.get(2).unwrap_or(&none));
    // rows of the last variable, from the highest power of the first down
    let mut end = monomials(D, degree);
    if D == 1 {
        return first_row(c, degree + 1, x0);
    }
    let mut sum = [T::ZERO; LANES];
    for left in 0..=degree {
        if D == 2 {
            end = end.saturating_sub(left + 1);
            step(&mut sum, x0, &first_row(c.get(end..).present_or(&[]), left + 1, x1));
            continue;
        }
        let mut inner = [T::ZERO; LANES];
        for n in 1..=left + 1 {
            end = end.saturating_sub(n);
            step(&mut inner, x1, &first_row(c.get(end..).present_or(&[]), n, x2));
        }
        step(&mut sum, x0, &inner);
    }
    sum
}

/// sum x + add, lane by lane.
#[inline(always)]
pub(super) fn step<T: Real>(sum: &mut [T; LANES], x: &[T; LANES], add: &[T; LANES]) {
    sum.iter_mut().zip(x).zip(add).for_each(|((s, &x), &a)| *s = *s * x + a);
}

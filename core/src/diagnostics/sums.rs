//! Compensated sums in double precision. Products are scaled by powers of two where a factor is very large or very small, so no
//! intermediate result leaves the range.

use super::compensated::Sum;
use crate::real::{Extended, Real, Scalar};

/// The range of the exponents of the nonzero numbers.
#[derive(Clone, Copy)]
struct Range {
    least: i32,
    most: i32,
}

/// Products of numbers with these exponents, and sums of them, stay in the normal range.
const PLAIN: Range = Range { least: -1000, most: 1000 };

/// The sum of the products of each item's factors, for fewer than 2^63 items.
///
/// As accurate as if each product were rounded N - 1 times and the sum then once, as for [`Sum`], for factors of any size. If products might
/// leave the range, all are scaled exactly by the power of two that makes the largest about 1. A factor that is not finite gives a result
/// that is not finite.
pub(crate) fn sum_of_products<const N: usize>(items: impl Iterator<Item = [f64; N]> + Clone) -> Extended {
    let mut extremes = [(f64::INFINITY, 0.0_f64); N];
    let mut count = 0_u64;
    for item in items.clone() {
        for ((least, most), factor) in extremes.iter_mut().zip(item) {
            let size = factor.abs();
            *most = if size > *most { size } else { *most };
            *least = if size < *least && size > 0.0 { size } else { *least };
        }
        count += 1;
    }
    let mut range = Range { least: 0, most: (64 - count.leading_zeros()) as i32 };
    for (least, most) in extremes {
        // If all are zero, the initial infinity counts as 1.
        range = Range { least: range.least + least.frexp().1, most: range.most + most.frexp().1 };
    }
    let mut sum = Sum::<f64>::default();
    if range.least > PLAIN.least && range.most < PLAIN.most {
        items.for_each(|item| sum.add(item.into_iter().fold(1.0, |product, factor| product * factor)));
        return Extended::new(sum.value(), 0);
    }
    let product = |item: [f64; N]| {
        item.into_iter().fold((1.0, 0), |(product, exponent), factor| {
            let (fraction, own) = factor.frexp();
            (product * fraction, exponent + own)
        })
    };
    let top = items.clone().map(product).filter(|&(value, _)| value != 0.0).map(|(_, exponent)| exponent).max();
    let top = top.unwrap_or(0);
    items.map(product).for_each(|(value, exponent)| sum.add(value.ldexp(exponent - top)));
    Extended::new(sum.value(), top)
}

/// The sum of the products of the elements of two slices.
///
/// Sums of short blocks are added in double precision and combined with compensation. For positive products the relative error is below
/// 300 u, on average the square root of 300 times u. In single precision this adds no error.
pub(crate) fn dot<T: Real>(a: &[T], b: &[T]) -> f64 {
    const SHORT: usize = 256;
    let mut sum = Sum::<f64>::default();
    for (a, b) in a.chunks(SHORT).zip(b.chunks(SHORT)) {
        sum.add(a.iter().zip(b).fold(0.0, |sum, (&a, &b)| sum + a.to_f64() * b.to_f64()));
    }
    sum.value()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_of_any_size() {
        // 3 * 5 + 7 * 11 = 92 at every scale of the two factors.
        for a in (-1070..1020).step_by(13) {
            for b in (-1070..1020).step_by(17) {
                let items = [[3.0, 5.0], [7.0, 11.0], [0.0, 1.0]];
                let scaled = items.map(|[x, y]: [f64; 2]| [x.ldexp(a), y.ldexp(b)]);
                let sum = sum_of_products(scaled.into_iter());
                assert_eq!(sum.in_units(a + b), 92.0, "{a} {b}");
                assert_eq!(sum.get(), 92.0_f64.ldexp(a + b));
            }
        }
        assert!(sum_of_products([[f64::NAN], [1.0]].into_iter()).get().is_nan());
        assert!(!sum_of_products([[f64::INFINITY, 0.0], [1.0, 1.0]].into_iter()).get().is_finite());
        assert_eq!(sum_of_products(core::iter::empty::<[f64; 2]>()).get(), 0.0);
        assert_eq!(sum_of_products([[0.0], [0.0]].into_iter()).get(), 0.0);
    }

    #[test]
    fn wide_numbers() {
        let x = Extended::new(3.0, 2000);
        assert_eq!((x.get(), x.over(Extended::new(1.5, 1999)).get()), (f64::INFINITY, 4.0));
        assert_eq!(x.plus(Extended::new(-3.0, 2000)).get(), 0.0);
        assert_eq!(x.plus(Extended::ZERO).over(x).get(), 1.0);
        assert_eq!(x.times(Extended::new(1.0, -2000)).get(), 3.0);
        for n in 1..4 {
            for exponent in -9..9 {
                let root = Extended::new(1.7, exponent).root(n).get();
                // One root and a rounded exponent.
                assert!((root / Scalar::pow(1.7.ldexp(exponent), 1.0 / f64::from(n)) - 1.0).abs() < 4.0 * f64::EPSILON);
            }
        }
        assert!(
            Extended::new(1.0, 3).is_smaller(Extended::new(9.0, 0))
                && !Extended::new(9.0, 0).is_smaller(Extended::new(1.0, 3))
        );
    }

    #[test]
    fn long_sums_of_ones_in_single_precision() {
        let ones = std::vec![1.0_f32; 1 << 25];
        assert_eq!(dot(&ones, &ones), 33_554_432.0);
    }
}

//! The solid harmonics themselves, the moments of sources and the values at targets.
//!
//! With w_0 = 1, w_1 = 1, w_m = w_(m-1) sqrt((2 m - 1) / (2 m)), and S_m = w_m, S_(m-1) = 0,
//!
//! S_n = (2 n - 1) / q_n z S_(n-1) - q_(n-1) / q_n r^2 S_(n-2),    q_n = sqrt(n^2 - m^2),
//!
//! the harmonics are Y_n^(m,c) + i Y_n^(m,s) = S_n (x + i y)^m. Tables and sums are by m, then n.

use crate::field::tree::series::{Frame, Targets, load_points};
use crate::real::{Real, Scalar};
use crate::simd::{BlockJob, Isa, Job, MAX_LANES};

/// Numbers of a pair (m, n) that [`Values`] needs: of the potential and of the gradient's components the coefficients of cosine and sine.
pub(super) const OUTPUTS: usize = 8;

/// The factors of the gradient of Y_(n+1) as a combination of Y_n: from (n + 1, m + 1) and (n + 1, m - 1) along x and y, and from (n + 1, m) along z.
pub(super) type Slopes<T> = [T; 3];

/// Fills the factors of S_(n-1) z and S_(n-2) r^2, and those of the gradient.
pub(super) fn recurrences<T: Real>(order: usize, to: &mut [[T; 2]], slopes: &mut [Slopes<T>]) {
    let mut slots = to.iter_mut().zip(slopes);
    for m in 0..order {
        for n in m..order {
            let Some((to, slope)) = slots.next() else { return };
            let (k, q) = (n as f64, |n: usize| Scalar::sqrt((n * n - m * m) as f64));
            *to = if n == m {
                [T::ONE, T::ZERO]
            } else {
                let before = if n > m + 1 { q(n - 1) } else { 0.0 };
                [T::from_f64((2.0 * k - 1.0) / q(n)), T::from_f64(before / q(n))]
            };
            // w = sqrt 2 between m = 0 and m = 1.
            let root = |product: usize, twice: bool| {
                T::from_f64(0.5 * Scalar::sqrt(product as f64) * if twice { core::f64::consts::SQRT_2 } else { 1.0 })
            };
            let n = n + 1;
            *slope = [
                root((n + m + 1) * (n + m), m == 0),
                root(if m > 0 { (n + 1 - m) * (n - m) } else { 0 }, m == 1),
                T::from_f64(Scalar::sqrt(((n - m) * (n + m)) as f64)),
            ];
        }
    }
}

/// w_m, one after the other.
fn next_weight<T: Real>(weight: T, m: usize) -> T {
    let m = m as f64;
    if m > 1.0 { weight * T::from_f64(Scalar::sqrt((2.0 * m - 1.0) / (2.0 * m))) } else { weight }
}

/// Adds the moments of sources: lanes are sources.
pub(super) struct Moments<'a, T> {
    pub recurrence: &'a [[T; 2]],
    pub order: usize,
    pub points: &'a [[T; 3]],
    pub masses: &'a [T],
    pub frame: Frame<T>,
    pub to: &'a mut [T],
    /// Two vectors of each pair (m, n).
    pub sums: &'a mut [T],
}

impl<T: Real> Job<T> for Moments<'_, T> {
    type Out = ();

    #[inline(always)]
    fn run<I: Isa<T>>(self, isa: I) {
        isa.in_blocks(self);
    }
}

impl<T: Real> BlockJob<T> for Moments<'_, T> {
    type Out = ();

    #[inline(always)]
    fn run<I: Isa<T>, const N: usize>(self, isa: I) {
        let Self { recurrence, order, points, masses, frame, to, sums } = self;
        let zero = isa.splat(T::ZERO);
        let sums = sums.as_chunks_mut::<MAX_LANES>().0.as_chunks_mut::<2>().0;
        let sums = sums.get_mut(..recurrence.len()).unwrap_or_default();
        sums.iter_mut().for_each(|sum| *sum = [[T::ZERO; MAX_LANES]; 2]);
        let each = (N * I::LANES).max(1);
        for (points, masses) in points.chunks(each).zip(masses.chunks(each)) {
            let [x, y, z] = load_points::<T, I, N>(isa, points.as_flattened(), 3, &frame);
            let mut square = [zero; N];
            for ((square, &x), (&y, &z)) in square.iter_mut().zip(&x).zip(y.iter().zip(&z)) {
                *square = isa.mul_add(x, x, isa.mul_add(y, y, isa.mul(z, z)));
            }
            // m (x + i y)^m
            let (mut cosine, mut sine) = ([zero; N], [zero; N]);
            for (mass, masses) in cosine.iter_mut().zip(masses.chunks(I::LANES.max(1))) {
                let mut lanes = [T::ZERO; MAX_LANES];
                lanes.iter_mut().zip(masses).for_each(|(to, &m)| *to = m);
                *mass = isa.load(&lanes);
            }
            let (mut weight, mut rest, mut rest_factors) = (T::ONE, &mut *sums, recurrence);
            for m in 0..order {
                weight = next_weight(weight, m);
                let (of_m, others) = core::mem::take(&mut rest).split_at_mut_checked(order - m).unwrap_or_default();
                let (factors, other_factors) = rest_factors.split_at_checked(order - m).unwrap_or_default();
                (rest, rest_factors) = (others, other_factors);
                let (mut last, mut now) = ([zero; N], [isa.splat(weight); N]);
                for (number, ([of_cosine, of_sine], &[a, b])) in of_m.iter_mut().zip(factors).enumerate() {
                    if number > 0 {
                        let (a, b) = (isa.splat(a), isa.splat(b));
                        for (((last, now), &z), &square) in last.iter_mut().zip(&mut now).zip(&z).zip(&square) {
                            let next = isa.neg_mul_add(isa.mul(b, square), *last, isa.mul(isa.mul(a, z), *now));
                            (*last, *now) = (*now, next);
                        }
                    }
                    let (mut c, mut s) = (isa.load(of_cosine), isa.load(of_sine));
                    for ((&now, &cosine), &sine) in now.iter().zip(&cosine).zip(&sine) {
                        c = isa.mul_add(now, cosine, c);
                        s = isa.mul_add(now, sine, s);
                    }
                    (*of_cosine, *of_sine) = (isa.store(c), isa.store(s));
                }
                for ((c, s), (&x, &y)) in cosine.iter_mut().zip(&mut sine).zip(x.iter().zip(&y)) {
                    let next = isa.neg_mul_add(*s, y, isa.mul(*c, x));
                    *s = isa.mul_add(*c, y, isa.mul(*s, x));
                    *c = next;
                }
            }
        }
        let mut sums = sums.iter();
        for m in 0..order {
            for (n, [cosine, sine]) in (m..order).zip(&mut sums) {
                let all = |sum: &[T; MAX_LANES]| sum.iter().take(I::LANES).fold(T::ZERO, |sum, &x| sum + x);
                to.get_mut(n * n + m).into_iter().for_each(|to| *to += all(cosine));
                if m > 0 {
                    to.get_mut(n * n + n + m).into_iter().for_each(|to| *to += all(sine));
                }
            }
        }
    }
}

/// Brings a local expansion into the order of [`Values`], with those of its derivatives.
pub(super) fn prepare_values<T: Real>(order: usize, slopes: &[Slopes<T>], from: &[T], to: &mut [T]) {
    let at = |place: usize, n: usize, m: usize| {
        if m <= n && n < order { from.get(place).copied().unwrap_or(T::ZERO) } else { T::ZERO }
    };
    let cosine = |n: usize, m: usize| at(n * n + m, n, m);
    let sine = |n: usize, m: usize| if m > 0 { at(n * n + n + m, n, m) } else { T::ZERO };
    let mut slots = to.as_chunks_mut::<OUTPUTS>().0.iter_mut().zip(slopes);
    for m in 0..order {
        for n in m..order {
            let Some((to, &[above, below, along])) = slots.next() else { return };
            let (c_above, s_above) = (above * cosine(n + 1, m + 1), above * sine(n + 1, m + 1));
            let (c_below, s_below) = match m.checked_sub(1) {
                Some(less) => (below * cosine(n + 1, less), below * sine(n + 1, less)),
                None => (T::ZERO, T::ZERO),
            };
            *to = [
                cosine(n, m),
                sine(n, m),
                c_above - c_below,
                s_above - s_below,
                s_above + s_below,
                -c_above - c_below,
                along * cosine(n + 1, m),
                along * sine(n + 1, m),
            ];
        }
    }
}

/// Adds the values of a local expansion at targets: lanes are targets.
pub(super) struct Values<'a, T> {
    pub recurrence: &'a [[T; 2]],
    pub order: usize,
    /// See [`prepare_values`].
    pub coefficients: &'a [T],
    pub to: Targets<'a, T>,
    /// Factors of potential and gradient besides one over the half width, multiplied one after the other.
    pub scales: [[T; 3]; 2],
}

impl<T: Real> Job<T> for Values<'_, T> {
    type Out = ();

    #[inline(always)]
    fn run<I: Isa<T>>(self, isa: I) {
        if self.to.gradient.is_some() {
            self.all::<I, OUTPUTS>(isa);
        } else {
            self.all::<I, 2>(isa);
        }
    }
}

impl<T: Real> Values<'_, T> {
    /// The first so many of the coefficients.
    #[inline(always)]
    fn all<I: Isa<T>, const K: usize>(self, isa: I) {
        let Self { recurrence, order, coefficients, to, scales } = self;
        let Targets { points, frame, mut potential, mut gradient } = to;
        let coefficients = coefficients.as_chunks::<OUTPUTS>().0;
        let (zero, each) = (isa.splat(T::ZERO), I::LANES.max(1));
        for (block, points) in points.as_chunks::<3>().0.chunks(each).enumerate() {
            let [[x], [y], [z]] = load_points::<T, I, 1>(isa, points.as_flattened(), 3, &frame);
            let square = isa.mul_add(x, x, isa.mul_add(y, y, isa.mul(z, z)));
            let mut totals = [zero; 4];
            let (mut cosine, mut sine) = (isa.splat(T::ONE), zero);
            let (mut weight, mut rest, mut rest_factors) = (T::ONE, coefficients, recurrence);
            for m in 0..order {
                weight = next_weight(weight, m);
                let (of_m, others) = rest.split_at_checked(order - m).unwrap_or_default();
                let (factors, other_factors) = rest_factors.split_at_checked(order - m).unwrap_or_default();
                (rest, rest_factors) = (others, other_factors);
                let (mut last, mut now) = (zero, isa.splat(weight));
                let mut sums = [zero; K];
                for (number, (of_n, &[a, b])) in of_m.iter().zip(factors).enumerate() {
                    if number > 0 {
                        let (a, b) = (isa.splat(a), isa.splat(b));
                        let next = isa.neg_mul_add(isa.mul(b, square), last, isa.mul(isa.mul(a, z), now));
                        (last, now) = (now, next);
                    }
                    for (sum, &coefficient) in sums.iter_mut().zip(of_n) {
                        *sum = isa.mul_add(isa.splat(coefficient), now, *sum);
                    }
                }
                for (total, pair) in totals.iter_mut().zip(sums.as_chunks::<2>().0) {
                    *total = isa.mul_add(pair[0], cosine, isa.mul_add(pair[1], sine, *total));
                }
                let next = isa.neg_mul_add(sine, y, isa.mul(cosine, x));
                sine = isa.mul_add(cosine, y, isa.mul(sine, x));
                cosine = next;
            }
            let [value, slope @ ..] = totals;
            let [of_value, of_slope] = scales;
            let by = |x: T, [a, b, c]: [T; 3]| x * a * b * c;
            let per_half = frame.per_half;
            if let Some(potential) = potential.as_deref_mut() {
                let to = potential.iter_mut().skip(block * each).take(each);
                to.zip(&isa.store(value)).for_each(|(to, &value)| *to += by(value * per_half, of_value));
            }
            if let Some(gradient) = gradient.as_deref_mut() {
                for (axis, &slope) in slope.iter().enumerate() {
                    let to = gradient.iter_mut().skip(block * each * 3 + axis).step_by(3).take(each);
                    to.zip(&isa.store(slope)).for_each(|(to, &slope)| *to += by(slope * per_half * per_half, of_slope));
                }
            }
        }
    }
}

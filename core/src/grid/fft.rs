//! Complex Fourier transforms of any length, of several sequences at a time, in the caller's memory.
//!
//! Lengths with prime factors up to [`MAX_PRIME`] use Stockham's self-sorting passes (Cochran et al. 1967; Van Loan,
//! *Computational Frameworks for the FFT*, 1992, Section 1.7) of radix 4, 2, 3, 5 and any odd prime. Other lengths use Bluestein's
//! convolution (1970) of length 2^a 3^b 5^c. Each element holds one number of [`LANES`] sequences. Every operation is the same in
//! all lanes, so the compiler can use vector registers.

use crate::checked::Present;
use crate::error::{Error, Result};
use crate::memory::Space;
use crate::real::{Real, Scalar};

/// Number of complex sequences transformed together.
pub(super) const LANES: usize = 4;
/// One element of all sequences: the real parts, then the imaginary parts.
pub(super) type Element<T> = [[T; LANES]; 2];
/// The largest prime factor with its own pass. Above it Bluestein's convolution is faster.
pub(super) const MAX_PRIME: usize = 31;
/// Most passes of a length below 2^21.
const MAX_PASSES: usize = 24;

/// The radices of the passes, padded with zeros.
type Radices = [usize; MAX_PASSES];

/// Radices of `n` in the order of the passes; `None` when a prime factor is above [`MAX_PRIME`].
fn radices(mut n: usize) -> Option<Radices> {
    let mut found = [0; MAX_PASSES];
    let mut slots = found.iter_mut();
    for radix in [4, 2, 3, 5, 7, 11, 13, 17, 19, 23, 29, MAX_PRIME] {
        while n > 1 && n.is_multiple_of(radix) {
            *slots.next()? = radix;
            n /= radix;
        }
    }
    (n == 1).then_some(found)
}

/// The smallest 2^a 3^b 5^c >= `n`.
pub(super) fn smooth(n: usize) -> usize {
    let mut best = n.next_power_of_two();
    let mut fives = 1_usize;
    while fives < best {
        let mut threes = fives;
        while threes < best {
            // The smallest power of two times `threes` that is >= n.
            let mut size = threes;
            while size < n {
                size *= 2;
            }
            best = best.min(size);
            threes *= 3;
        }
        fives *= 5;
    }
    best
}

/// Approximate number of operations of a transform of this length, to compare lengths.
pub(super) fn cost(n: usize) -> usize {
    match radices(n) {
        Some(radices) => {
            n * radices
                .iter()
                .map(|&r| {
                    if r == 0 {
                        0
                    } else if r <= 5 {
                        8 + r
                    } else {
                        8 + 4 * r
                    }
                })
                .sum::<usize>()
        }
        None => 2 * cost(smooth(2 * n)) + 20 * n,
    }
}

/// exp(-2 pi i k / n), correct to the rounding of the scalar: the angle is reduced to an eighth of a turn in integers.
fn root<T: Real>(k: usize, n: usize) -> [T; 2] {
    // Eighths of a turn: 8 k = octant * n + rest.
    let eight = 8 * (k % n.max(1));
    let (octant, rest) = (eight / n.max(1), eight % n.max(1));
    let (odd, rest) = if octant % 2 == 1 { (true, n - rest) } else { (false, rest) };
    let angle = core::f64::consts::FRAC_PI_4 * (rest as f64 / n as f64);
    let (mut c, mut s) = (Scalar::cos(angle), Scalar::sin(angle));
    if odd {
        (c, s) = (s, c);
    }
    // (c, s) is the point within its quadrant.
    let (c, s) = match octant / 2 {
        0 => (c, s),
        1 => (-s, c),
        2 => (-c, -s),
        _ => (s, -c),
    };
    [T::from_f64(c), T::from_f64(-s)]
}

/// sin(pi j / n) and cos(pi j / n).
pub(super) fn half_root<T: Real>(j: usize, n: usize) -> [T; 2] {
    let [c, s] = root::<T>(j, 2 * n);
    [-s, c]
}

/// The passes of a length without a prime factor above [`MAX_PRIME`].
#[derive(Debug)]
struct Passes<'w, T> {
    length: usize,
    radices: Radices,
    /// For each pass of radix r on length l and each p < l / r: the r - 1 factors exp(-2 pi i p k / l).
    twiddles: &'w mut [[T; 2]],
    /// exp(-2 pi i k / length).
    roots: &'w mut [[T; 2]],
}

impl<'w, T: Real> Passes<'w, T> {
    fn layout(space: &mut impl Space<'w>, length: usize) -> Result<Self> {
        let radices = radices(length).ok_or(Error::TooLarge)?;
        // The passes need sum (l - l / r) = length - 1 factors.
        Ok(Self { length, radices, twiddles: space.try_array(length)?, roots: space.try_array(length)? })
    }

    fn prepare(&mut self) {
        let n = self.length;
        for (k, slot) in self.roots.iter_mut().enumerate() {
            *slot = root(k, n);
        }
        let mut slots = self.twiddles.iter_mut();
        let mut length = n;
        for radix in self.radices.into_iter().take_while(|&radix| radix > 0) {
            let m = length / radix.max(1);
            // exp(-2 pi i p k / length) is the root p k (n / length).
            let stride = n / length.max(1);
            for p in 0..m {
                for k in 1..radix {
                    if let (Some(slot), Some(&w)) = (slots.next(), self.roots.get(p * k * stride)) {
                        *slot = w;
                    }
                }
            }
            length = m;
        }
    }

    /// Transforms `a`. Returns the buffer with the result and the spare buffer.
    #[inline(always)]
    fn run<'b>(
        &self,
        mut a: &'b mut [Element<T>],
        mut b: &'b mut [Element<T>],
    ) -> (&'b mut [Element<T>], &'b mut [Element<T>]) {
        let mut length = self.length;
        let mut stride = 1;
        let mut twiddles: &[[T; 2]] = self.twiddles;
        for radix in self.radices.into_iter().take_while(|&radix| radix > 0) {
            let m = length / radix.max(1);
            let (here, rest) = twiddles.split_at_checked(m * (radix - 1)).unwrap_or((&[], &[]));
            twiddles = rest;
            match radix {
                2 => pass(m, stride, here, a, b, butterfly2),
                3 => pass(m, stride, here, a, b, butterfly3),
                4 => pass(m, stride, here, a, b, butterfly4),
                5 => pass(m, stride, here, a, b, butterfly5),
                _ => pass_prime(radix, m, stride, here, self.roots, a, b),
            }
            (a, b) = (b, a);
            stride *= radix;
            length = m;
        }
        (a, b)
    }
}

/// y[q + s (R p + k)] = w^(p k) sum_j x[q + s (p + m j)] exp(-2 pi i j k / R).
#[inline(always)]
fn pass<T: Real, const R: usize>(
    m: usize,
    stride: usize,
    twiddles: &[[T; 2]],
    x: &[Element<T>],
    y: &mut [Element<T>],
    butterfly: impl Fn([Element<T>; R]) -> [Element<T>; R],
) {
    let span = m * stride;
    for p in 0..m {
        let w = twiddles.get(p * (R - 1)..).present_or_default();
        for q in 0..stride {
            let from = q + stride * p;
            let mut v = [[[T::ZERO; LANES]; 2]; R];
            let mut at = from;
            for v in &mut v {
                if let Some(&x) = x.get(at) {
                    *v = x;
                }
                at += span;
            }
            let v = butterfly(v);
            let mut at = q + stride * R * p;
            let mut first = true;
            let mut w = w.iter();
            for v in v {
                let turned = if first { v } else { w.next().map_or(v, |&w| times(v, w)) };
                first = false;
                if let Some(y) = y.get_mut(at) {
                    *y = turned;
                }
                at += stride;
            }
        }
    }
}

/// As [`pass`], for an odd prime: combines the sums and differences of x_j and x_(r-j) with cosines and sines.
#[inline(always)]
fn pass_prime<T: Real>(
    radix: usize,
    m: usize,
    stride: usize,
    twiddles: &[[T; 2]],
    roots: &[[T; 2]],
    x: &[Element<T>],
    y: &mut [Element<T>],
) {
    let span = m * stride;
    // exp(-2 pi i k / radix) is the root k (length / radix).
    let step = roots.len() / radix.max(1);
    let half = radix / 2;
    let zero = [[T::ZERO; LANES]; 2];
    for p in 0..m {
        for q in 0..stride {
            let load = |j: usize| x.get(q + stride * p + span * j).copied().unwrap_or(zero);
            let mut sums = [zero; MAX_PRIME / 2];
            let mut differences = [zero; MAX_PRIME / 2];
            let first = load(0);
            let mut total = first;
            for ((j, sum), difference) in (1..=half).zip(&mut sums).zip(&mut differences) {
                let (a, b) = (load(j), load(radix - j));
                *sum = add(a, b);
                *difference = sub(a, b);
                total = add(total, *sum);
            }
            let mut store = |k: usize, v: Element<T>| {
                let turned = match k.checked_sub(1).and_then(|k| twiddles.get(p * (radix - 1) + k)) {
                    Some(&w) => times(v, w),
                    None => v,
                };
                if let Some(y) = y.get_mut(q + stride * (radix * p + k)) {
                    *y = turned;
                }
            };
            store(0, total);
            for k in 1..=half {
                let (mut even, mut odd) = (first, zero);
                let mut turn = 0;
                for (sum, difference) in sums.iter().zip(&differences).take(half) {
                    turn += k;
                    if turn >= radix {
                        turn -= radix;
                    }
                    let [c, s] = roots.get(turn * step).copied().present_or_default();
                    even = add(even, scale(*sum, c));
                    odd = add(odd, scale(*difference, s));
                }
                // s has the sign of exp(-i ..): x_j w^(jk) + x_(r-j) w^(-jk) = sum c + i difference s.
                let odd = times_i(odd);
                store(k, add(even, odd));
                store(radix - k, sub(even, odd));
            }
        }
    }
}

/// A transform of any length.
#[derive(Debug)]
pub(super) struct Fft<'w, T> {
    length: usize,
    passes: Passes<'w, T>,
    bluestein: Option<Bluestein<'w, T>>,
}

#[derive(Debug)]
struct Bluestein<'w, T> {
    /// exp(-i pi j^2 / length).
    chirp: &'w mut [[T; 2]],
    /// The transform of the conjugate chirp, periodic with the length of the convolution.
    filter: &'w mut [[T; 2]],
    /// Buffers to transform the filter.
    buffers: [&'w mut [Element<T>]; 2],
}

impl<'w, T: Real> Fft<'w, T> {
    /// Elements of each of the two buffers of a transform of this length.
    pub(super) fn buffer(length: usize) -> usize {
        if radices(length).is_some() { length } else { smooth(2 * length) }
    }

    pub(super) fn layout(space: &mut impl Space<'w>, length: usize) -> Result<Self> {
        let inner = Self::buffer(length);
        let passes = Passes::layout(space, inner)?;
        let bluestein = if inner == length {
            None
        } else {
            Some(Bluestein {
                chirp: space.try_array(length)?,
                filter: space.try_array(inner)?,
                buffers: [space.try_array(inner)?, space.try_array(inner)?],
            })
        };
        Ok(Self { length, passes, bluestein })
    }

    pub(super) fn prepare(&mut self) {
        self.passes.prepare();
        let (n, inner) = (self.length, self.passes.length);
        let Some(Bluestein { chirp, filter, buffers: [a, b] }) = &mut self.bluestein else { return };
        // j^2 mod 2 n, by (j + 1)^2 = j^2 + 2 j + 1.
        let mut square = 0;
        for (j, slot) in chirp.iter_mut().enumerate() {
            *slot = root(square, 2 * n);
            square = (square + 2 * j + 1) % (2 * n).max(1);
        }
        let zero = [[T::ZERO; LANES]; 2];
        a.fill(zero);
        for (j, &[c, s]) in chirp.iter().enumerate() {
            for at in [j, (inner - j) % inner.max(1)] {
                if let Some(slot) = a.get_mut(at) {
                    *slot = [[c; LANES], [-s; LANES]];
                }
            }
        }
        let (result, _) = self.passes.run(a, b);
        let per = T::ONE / T::from_usize(inner);
        for (slot, &[[re, ..], [im, ..]]) in filter.iter_mut().zip(result.iter()) {
            *slot = [re * per, im * per];
        }
    }

    /// Transforms the first `length` elements of `a`, x_k -> sum_j x_j exp(-2 pi i j k / length). Returns the buffer with the
    /// result and the spare buffer. Both hold at least [`Fft::buffer`] elements.
    #[inline(always)]
    pub(super) fn run<'b>(
        &self,
        a: &'b mut [Element<T>],
        b: &'b mut [Element<T>],
    ) -> (&'b mut [Element<T>], &'b mut [Element<T>]) {
        let Some(Bluestein { chirp, filter, .. }) = &self.bluestein else {
            return self.passes.run(a, b);
        };
        let zero = [[T::ZERO; LANES]; 2];
        for (x, &w) in a.iter_mut().zip(chirp.iter()) {
            *x = times(*x, w);
        }
        a.iter_mut().take(self.passes.length).skip(self.length).for_each(|x| *x = zero);
        let (mut a, mut b) = (a, b);
        for backward in [false, true] {
            (a, b) = self.passes.run(a, b);
            if !backward {
                for (x, &w) in a.iter_mut().zip(filter.iter()) {
                    // The inverse transform is the forward transform with real and imaginary parts exchanged.
                    let [re, im] = times(*x, w);
                    *x = [im, re];
                }
            }
        }
        for (x, &w) in a.iter_mut().zip(chirp.iter()) {
            let [im, re] = *x;
            *x = times([re, im], w);
        }
        (a, b)
    }
}

#[inline(always)]
fn lanes<T: Real>(mut a: [T; LANES], b: [T; LANES], f: impl Fn(T, T) -> T) -> [T; LANES] {
    for (a, b) in a.iter_mut().zip(b) {
        *a = f(*a, b);
    }
    a
}
#[inline(always)]
pub(super) fn add<T: Real>([a, b]: Element<T>, [c, d]: Element<T>) -> Element<T> {
    [lanes(a, c, |x, y| x + y), lanes(b, d, |x, y| x + y)]
}
#[inline(always)]
pub(super) fn sub<T: Real>([a, b]: Element<T>, [c, d]: Element<T>) -> Element<T> {
    [lanes(a, c, |x, y| x - y), lanes(b, d, |x, y| x - y)]
}
#[inline(always)]
pub(super) fn scale<T: Real>([a, b]: Element<T>, by: T) -> Element<T> {
    [a.map(|x| x * by), b.map(|x| x * by)]
}
/// i (a + i b) = -b + i a.
#[inline(always)]
pub(super) fn times_i<T: Real>([a, b]: Element<T>) -> Element<T> {
    [b.map(|x| -x), a]
}
#[inline(always)]
fn times<T: Real>([a, b]: Element<T>, [c, s]: [T; 2]) -> Element<T> {
    [lanes(a, b, |a, b| a * c - b * s), lanes(a, b, |a, b| a * s + b * c)]
}

#[inline(always)]
fn butterfly2<T: Real>([a, b]: [Element<T>; 2]) -> [Element<T>; 2] {
    [add(a, b), sub(a, b)]
}

#[inline(always)]
fn butterfly3<T: Real>([a, b, c]: [Element<T>; 3]) -> [Element<T>; 3] {
    let (sum, difference) = (add(b, c), sub(b, c));
    let middle = sub(a, scale(sum, T::HALF));
    // -i sin(pi/3) (b - c)
    let turned = times_i(scale(difference, T::from_f64(-0.866_025_403_784_438_6)));
    [add(a, sum), add(middle, turned), sub(middle, turned)]
}

#[inline(always)]
fn butterfly4<T: Real>([a, b, c, d]: [Element<T>; 4]) -> [Element<T>; 4] {
    let (e, f) = (add(a, c), sub(a, c));
    let (g, h) = (add(b, d), times_i(sub(b, d)));
    [add(e, g), sub(f, h), sub(e, g), add(f, h)]
}

#[inline(always)]
fn butterfly5<T: Real>([a, b, c, d, e]: [Element<T>; 5]) -> [Element<T>; 5] {
    let c1 = T::from_f64(0.309_016_994_374_947_45);
    let c2 = T::from_f64(-0.809_016_994_374_947_5);
    let s1 = T::from_f64(-0.951_056_516_295_153_5);
    let s2 = T::from_f64(-0.587_785_252_292_473_1);
    let (p, q, r, s) = (add(b, e), add(c, d), sub(b, e), sub(c, d));
    let even1 = add(a, add(scale(p, c1), scale(q, c2)));
    let even2 = add(a, add(scale(p, c2), scale(q, c1)));
    let odd1 = times_i(add(scale(r, s1), scale(s, s2)));
    let odd2 = times_i(sub(scale(r, s2), scale(s, s1)));
    [add(a, add(p, q)), add(even1, odd1), add(even2, odd2), sub(even2, odd2), sub(even1, odd1)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::tests::{aligned, unit};
    use crate::memory::{Carve, Measure};
    use std::vec;

    /// The largest error over all lanes, compared with the direct sum in f64, divided by the l2 norm of the sequence.
    fn error<T: Real>(n: usize) -> f64 {
        let bytes = Measure::of(|space| Fft::<T>::layout(space, n).map(|_| ())).unwrap();
        let mut memory = vec![0xA5_u8; bytes + 64];
        let mut fft = Fft::<T>::layout(&mut Carve::new(aligned(&mut memory, bytes)).unwrap(), n).unwrap();
        fft.prepare();
        let mut seed = n as u64;
        let zero = [[T::NAN; LANES]; 2];
        let (mut a, mut b) = (vec![zero; Fft::<T>::buffer(n) + 1], vec![zero; Fft::<T>::buffer(n) + 1]);
        a[..n].fill_with(|| [0, 1].map(|_| [0; LANES].map(|_| T::from_f64(unit(&mut seed) - 0.5))));
        let x = a.clone();
        let norm = x[..n].iter().map(|[re, _]| re[0].to_f64().powi(2)).sum::<f64>().sqrt();
        let (result, _) = fft.run(&mut a, &mut b);
        let mut worst = 0.0_f64;
        for (k, got) in result.iter().enumerate().take(n) {
            let mut want = [[0.0_f64; LANES]; 2];
            for (j, x) in x[..n].iter().enumerate() {
                let [c, s] = root::<f64>(j * k, n);
                for l in 0..LANES {
                    let (re, im) = (x[0][l].to_f64(), x[1][l].to_f64());
                    want[0][l] += re * c - im * s;
                    want[1][l] += re * s + im * c;
                }
            }
            for l in 0..LANES {
                for part in 0..2 {
                    worst = worst.max((got[part][l].to_f64() - want[part][l]).abs());
                }
            }
        }
        worst / norm
    }

    #[test]
    fn any_length_against_the_sum() {
        // The direct sum in f64 has an error of about sqrt(n) u. The fast transform has a few u per pass, Bluestein's twice that and the
        // error of its filter. 40 u covers log2(1024) passes at 2 u each and the error of the direct sum.
        let lengths =
            (1..=80).chain([97, 101, 121, 125, 127, 128, 135, 169, 187, 243, 251, 256, 257, 270, 320, 509, 511, 1000]);
        for n in lengths {
            let (double, single) = (error::<f64>(n), error::<f32>(n));
            assert!(double < 40.0 * f64::EPSILON, "{n}: {double:e}");
            assert!(single < 40.0 * f64::from(f32::EPSILON), "{n}: {single:e}");
        }
    }

    #[test]
    fn roots_are_rounded_correctly_at_the_eighths() {
        let r = core::f64::consts::FRAC_1_SQRT_2;
        let eighths = [[1.0, 0.0], [r, -r], [0.0, -1.0], [-r, -r], [-1.0, 0.0], [-r, r], [0.0, 1.0], [r, r]];
        for (k, want) in eighths.iter().enumerate() {
            let got = root::<f64>(k * 5, 40);
            assert!((got[0] - want[0]).abs() <= 1.2e-16 && (got[1] - want[1]).abs() <= 1.2e-16, "{k} {got:?}");
        }
    }

    #[test]
    fn smooth_sizes_are_the_next_ones() {
        let is = |mut n: usize| {
            for p in [2, 3, 5] {
                while n.is_multiple_of(p) {
                    n /= p;
                }
            }
            n == 1
        };
        for n in 1..2000 {
            assert_eq!(smooth(n), (n..).find(|&m| is(m)).unwrap(), "{n}");
        }
        assert_eq!((crate::grid::good_size(257), crate::grid::good_size(0)), (270, 2));
        assert!(cost(320) < cost(257) && cost(270) < cost(269) && cost(256) < cost(255));
    }
}

//! One source against one register block of targets, for the Newtonian kernel, mollified or not: the innermost loop.
//!
//! Lanes are targets. With d = x_source - x_target and r2 = |d|^2 in the units of [`super::packed`], and S_D = 2, 2 pi, 4 pi:
//!
//! | | outside delta | inside, t = 1 - r2 / delta^2 (`BASIS`: powers of t, nothing cancels) |
//! |---|---|---|
//! | S_D g, grad K = g x | r^-D | delta^-D G(t) |
//! | S_D K | \|x\|, log r, -1/r | delta (c + s R(t) / 2), log delta + P(t), P(t) / delta |
//! | S_D Laplacian K | 0 | delta^-D b(t) |
//!
//! A register block of targets meets one source after the other. If no lane is inside, no polynomial is evaluated
//! ([`far_run`]); if all are, nothing is divided ([`near_run`]); a block with some lanes inside adds the others and is noted,
//! and gets its polynomials later ([`inside`]), so that the common loop keeps its registers. In 2D the mass goes into the
//! numerator, m / r2, with one division for two vectors; in 3D m / r^3 comes from the machine's square root and a shared
//! division (AVX2) or from a 14-bit seed y and the series of (1 - e)^(-3/2), e = 1 - r2 y^2 (AVX-512).
//!
//! # Rounding
//! With u the unit roundoff and to first order: a coordinate difference has 1 u, r2 has 5 u. Outside, g has in 1D 2 u, in 2D
//! 8 u (r2, 3 u of the shared division), in 3D 12 u (1.5 times r2's, square root, product, shared division, or the series
//! and its cut); inside at most 12 u (`Polynomials`). The products by d and by the coefficient add 4 u: c = 16 u a term.
//! `direct` adds what the summation adds. The 2D potential is the logarithm of a rounded number, which has a zero at r = 1: its
//! error is relative to |log r| + 1. The density has zeros too: its error is relative to its maximum.

use super::packed::{Units, least_square_exponent, power_of_two};
use crate::isa::{Isa, log, log_numerator};
use crate::mollifier::{Blob, MAX_TERMS, Mollifier, Polynomial};
use crate::real::Real;

/// Coefficients in powers of t, highest first.
#[derive(Clone, Copy, Debug)]
struct Descending<C> {
    coefficients: [C; MAX_TERMS],
    terms: usize,
}

impl<T: Real> Descending<T> {
    /// Those of a polynomial of the blob.
    fn of<const D: usize>(blob: &Blob<T, D>, polynomial: Polynomial, scale: T) -> Self {
        let mut coefficients = [T::ZERO; MAX_TERMS];
        let terms = descending(&mut coefficients, blob, polynomial, scale);
        Self { coefficients, terms }
    }

    #[inline(always)]
    fn lanes<I: Isa<T>>(&self, isa: I) -> Descending<I::V> {
        Descending { coefficients: self.coefficients.map(|c| isa.splat(c)), terms: self.terms }
    }
}

/// The coefficients of a polynomial of the blob, times `scale`, highest power of t first; how many. None without a compact mollifier.
#[cfg_attr(feature = "small", inline(never))]
pub(super) fn descending<T: Real, const D: usize>(
    to: &mut [T; MAX_TERMS],
    blob: &Blob<T, D>,
    polynomial: Polynomial,
    scale: T,
) -> usize {
    let terms = blob.terms(polynomial).unwrap_or(0).min(MAX_TERMS);
    for (to, k) in to.iter_mut().zip((0..terms).rev()) {
        *to = blob.coefficient(polynomial, k) * scale;
    }
    terms
}

/// [`descending`] for what leads to S_D K, twice that in 2D, and what is added to it; `delta` is in units.
pub(super) fn descending_potential<T: Real, const D: usize>(
    to: &mut [T; MAX_TERMS],
    blob: &Blob<T, D>,
    delta: T,
) -> (usize, T) {
    let per = T::ONE / delta;
    match D {
        1 => {
            // R_j = sum over k >= j of g_k / (k + 1); c = 1 - R_0 / 2: every term is positive for orders 2 to 6.
            let terms = blob.terms(Polynomial::Gradient).unwrap_or(0).min(MAX_TERMS);
            let mut sum = T::ZERO;
            for (to, k) in to.iter_mut().zip((0..terms).rev()) {
                sum += blob.coefficient(Polynomial::Gradient, k) / T::from_usize(k + 1);
                // s R(t) = (r2 / delta^2) R(t); the r2 is multiplied later.
                *to = sum * (T::HALF * per);
            }
            (terms, delta * (T::ONE - T::HALF * sum))
        }
        2 => (descending(to, blob, Polynomial::Potential, T::TWO), T::TWO * blob.delta().log()),
        _ => (descending(to, blob, Polynomial::Potential, per), T::ZERO),
    }
}

impl<V: Copy> Descending<V> {
    /// Horner's rule. A `TERMS` above 0 must be the number of terms, as [`Descending::terms`] says it.
    #[inline(always)]
    fn at<T: Real, I: Isa<T, V = V>, const N: usize, const TERMS: usize>(&self, isa: I, t: &[V; N]) -> [V; N] {
        let terms = if TERMS > 0 { TERMS } else { self.terms };
        let Some((&first, rest)) = self.coefficients.get(..terms).and_then(<[V]>::split_first) else {
            return [isa.splat(T::ZERO); N];
        };
        let mut sums = [first; N];
        for &c in rest {
            for (sum, &t) in sums.iter_mut().zip(t) {
                *sum = isa.mul_add(*sum, t, c);
            }
        }
        sums
    }
}

impl<V: Copy> Inside<V> {
    /// The gradient's polynomial in powers of r2 - delta^2 = -delta^2 t (two roundings more a power), and -delta^2.
    #[inline(always)]
    fn shifted<T: Real, I: Isa<T, V = V>>(&self, isa: I, square: V) -> (Descending<V>, V) {
        let zero = isa.splat(T::ZERO);
        let mut shifted = self.gradient;
        let mut factor = isa.splat(T::ONE);
        for c in shifted.coefficients.iter_mut().take(shifted.terms).rev() {
            *c = isa.mul(*c, factor);
            factor = isa.sub(zero, isa.mul(factor, self.per_square));
        }
        (shifted, isa.sub(zero, square))
    }

    /// S_D K_delta, twice that in 2D.
    #[inline(always)]
    fn potential<T: Real, I: Isa<T, V = V>, const D: usize, const N: usize>(
        &self,
        isa: I,
        t: &[V; N],
        r2: &[V; N],
    ) -> [V; N] {
        let mut k = self.potential.at::<T, I, N, 0>(isa, t);
        for (k, &r2) in k.iter_mut().zip(r2) {
            *k = if D == 1 { isa.mul_add(*k, r2, self.offset) } else { isa.add(*k, self.offset) };
        }
        k
    }
}

/// The inside of the support, in units.
#[derive(Clone, Copy, Debug)]
pub(super) struct Inside<C> {
    /// 1 / delta^2.
    per_square: C,
    gradient: Descending<C>,
    potential: Descending<C>,
    /// Added to the potential: 2 log delta in 2D (true units), delta c in 1D.
    offset: C,
    density: Descending<C>,
}

/// What the lanes know of a mollified Newtonian kernel.
#[derive(Clone, Copy, Debug)]
pub(super) struct Softened<C> {
    /// Lanes with r2 below this are not plainly Newtonian: inside the support, or too close for the fast path.
    edge: C,
    /// `None`: what is below the edge takes the scaled path.
    inside: Option<Inside<C>>,
    /// Added to the exponent of r2, so that its logarithm is that of true units.
    log_exponent: C,
}

impl<T: Real> Softened<T> {
    /// Prepares the numbers, in units of which delta is at most about 1.
    pub fn new<const D: usize>(blob: &Blob<T, D>, units: Units<T>) -> Self {
        let least = power_of_two::<T>(-least_square_exponent::<T>());
        let delta = blob.delta() * power_of_two(units.position);
        let square = delta * delta;
        let inside = match blob.mollifier() {
            Mollifier::Compact { .. } if square >= least => Some(Self::shape(blob, delta)),
            _ => None,
        };
        let edge = match blob.mollifier() {
            _ if inside.is_some() => square,
            Mollifier::Gaussian { .. } => {
                let support = blob.delta() * T::from_f64(GAUSSIAN_SUPPORT) * power_of_two(units.position);
                least.max(support * support)
            }
            _ => least,
        };
        Self { edge, inside, log_exponent: T::from_i32(units.position.saturating_mul(-2)) }
    }

    /// A compact mollifier inside its support.
    fn shape<const D: usize>(blob: &Blob<T, D>, delta: T) -> Inside<T> {
        let per = T::ONE / delta;
        let scale = per.powi(D as u32);
        let mut coefficients = [T::ZERO; MAX_TERMS];
        let (terms, offset) = descending_potential(&mut coefficients, blob, delta);
        Inside {
            per_square: per * per,
            gradient: Descending::of(blob, Polynomial::Gradient, scale),
            potential: Descending { coefficients, terms },
            offset,
            density: Descending::of(blob, Polynomial::Density, scale),
        }
    }

    /// The same in every lane.
    #[inline(always)]
    pub fn lanes<I: Isa<T>>(&self, isa: I) -> Softened<I::V> {
        Softened {
            edge: isa.splat(self.edge),
            inside: self.inside.as_ref().map(|inside| Inside {
                per_square: isa.splat(inside.per_square),
                gradient: inside.gradient.lanes(isa),
                potential: inside.potential.lanes(isa),
                offset: isa.splat(inside.offset),
                density: inside.density.lanes(isa),
            }),
            log_exponent: isa.splat(self.log_exponent),
        }
    }
}

impl<V> Softened<V> {
    /// Lanes with r2 below this are not plainly Newtonian.
    #[inline(always)]
    pub fn edge(&self) -> &V {
        &self.edge
    }

    /// Terms of the gradient's polynomial.
    #[inline(always)]
    pub fn gradient_terms(&self) -> usize {
        self.inside.as_ref().map_or(0, |inside| inside.gradient.terms)
    }

    /// Whether the inside of the support is evaluated in lanes.
    #[inline(always)]
    pub fn has_polynomials(&self) -> bool {
        self.inside.is_some()
    }
}

/// Beyond this many delta a Gaussian mollifier's field is Newtonian to rounding: e^{-r^2 / (4 delta)^2} < 2^-54 at the widest
/// part of order 6, which is 4 delta.
const GAUSSIAN_SUPPORT: f64 = 26.0;

/// One vector of targets: where they are and what they have gathered.
#[derive(Clone, Copy, Debug)]
pub(super) struct Group<V, const D: usize> {
    pub x: [V; D],
    pub sums: Sums<V, D>,
    /// What additions lost, in compensated sums.
    pub lost: Sums<V, D>,
}

/// Sums of m S_D K (2D: twice that), m g d S_D and m S_D Laplacian K.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sums<V, const D: usize> {
    pub potential: V,
    pub gradient: [V; D],
    pub laplacian: V,
}

impl<V: Copy, const D: usize> Sums<V, D> {
    #[inline(always)]
    pub fn zero<T: Real, I: Isa<T, V = V>>(isa: I) -> Self {
        let zero = isa.splat(T::ZERO);
        Self { potential: zero, gradient: [zero; D], laplacian: zero }
    }

    /// Adds other sums.
    #[inline(always)]
    pub fn add<T: Real, I: Isa<T, V = V>>(&mut self, isa: I, other: &Self) {
        self.potential = isa.add(self.potential, other.potential);
        self.gradient.iter_mut().zip(other.gradient).for_each(|(sum, other)| *sum = isa.add(*sum, other));
        self.laplacian = isa.add(self.laplacian, other.laplacian);
    }
}

/// Sources one after the other: positions and masses of equal length.
pub(super) type List<'a, T, const D: usize> = (&'a [[T; D]], &'a [T]);

/// Sources with a lane below the edge, for [`inside`]: their places in a list of at most [`BLOCK`].
#[derive(Debug)]
pub(super) struct Pending {
    at: [u16; BLOCK],
    n: usize,
}

impl Pending {
    /// None.
    pub fn new() -> Self {
        Self { at: [0; BLOCK], n: 0 }
    }

    #[inline(always)]
    fn push(&mut self, at: usize) {
        if let Some(slot) = self.at.get_mut(self.n) {
            *slot = at as u16;
            self.n += 1;
        }
    }

    /// Takes them all out.
    #[inline(always)]
    pub fn take(&mut self) -> impl Iterator<Item = usize> {
        let n = core::mem::take(&mut self.n);
        self.at.iter().take(n).map(|&at| usize::from(at))
    }
}

/// Sources added up before their sum joins the total.
pub(super) const BLOCK: usize = 256;

/// Adds sources, but not where a lane is below the edge: such sources are noted in `pending`, at their place after `start`.
/// Stops where every lane is inside the support, which [`near_run`] does without dividing, and on machines that add in order
/// behind a source that it noted. Returns how many it did.
///
/// Targets and sums live in registers here: this loop is where a sum without near pairs spends its time.
#[inline(always)]
pub(super) fn far_run<
    T: Real,
    I: Isa<T>,
    const D: usize,
    const NB: usize,
    const P: bool,
    const G: bool,
    const C: bool,
>(
    isa: I,
    kernel: &Softened<I::V>,
    sources: List<'_, T, D>,
    start: usize,
    pending: &mut Pending,
    groups: &mut [Group<I::V, D>; NB],
) -> usize {
    let (zero, one) = (isa.splat(T::ZERO), isa.splat(T::ONE));
    let mut done = 0;
    let mut local = *groups;
    for (x, &m) in sources.0.iter().zip(sources.1) {
        let (mut d, mut r2) = distances(isa, x, &local);
        let mass = isa.splat(m);
        let mut noted = false;
        if isa.any_below(&r2, kernel.edge) {
            if kernel.inside.is_some() && isa.all_below(&r2, kernel.edge) {
                break;
            }
            pending.push(start + done);
            noted = I::IN_ORDER;
            // Lanes below the edge add nothing: d = 0, and r2 = 1 is harmless. Only the potential, log or -1/r, has no zero there.
            let below = r2.map(|r2| isa.lt(r2, kernel.edge));
            for ((d, r2), &below) in d.iter_mut().zip(&mut r2).zip(&below) {
                d.iter_mut().for_each(|d| *d = isa.select(below, zero, *d));
                *r2 = isa.select(below, one, *r2);
            }
            if P && D > 1 {
                let far = outside::<T, I, D, NB, P, G>(isa, kernel.log_exponent, mass, &d, &r2);
                for (((group, d), (k, g)), &below) in local.iter_mut().zip(&d).zip(far).zip(&below) {
                    gather::<T, I, D, P, G, C>(isa, group, d, mass, isa.select(below, zero, k), g);
                }
                done += 1;
                if noted {
                    break;
                }
                continue;
            }
        }
        if P || G {
            let far = outside::<T, I, D, NB, P, G>(isa, kernel.log_exponent, mass, &d, &r2);
            for ((group, d), (k, g)) in local.iter_mut().zip(&d).zip(far) {
                gather::<T, I, D, P, G, C>(isa, group, d, mass, k, g);
            }
        }
        done += 1;
        if noted {
            break;
        }
    }
    *groups = local;
    done
}

/// Adds sources as long as every lane is inside the support; how many. Nothing is divided.
///
/// `TERMS` unrolls the gradient's polynomial where it has just so many; 0 takes any number. Without `TEST` the caller
/// knows that every lane is inside.
#[inline(always)]
pub(super) fn near_run<
    T: Real,
    I: Isa<T>,
    const D: usize,
    const NB: usize,
    const P: bool,
    const G: bool,
    const C: bool,
    const TERMS: usize,
    const TEST: bool,
>(
    isa: I,
    kernel: &Softened<I::V>,
    laplacian: bool,
    sources: List<'_, T, D>,
    groups: &mut [Group<I::V, D>; NB],
) -> usize {
    let Some(inside) = &kernel.inside else { return 0 };
    let one = isa.splat(T::ONE);
    let mut done = 0;
    let mut local = *groups;
    let (mut positions, mut masses) = sources;
    if !(TEST || P || C || laplacian || I::IN_ORDER) {
        // Four sources at a time, stage by stage: the polynomials' long chains of dependent operations then overlap beyond
        // what the processor's window holds of one source after the other. The polynomial is one of r2 - delta^2 here, which
        // the sum of squares begins with, so that t costs nothing. (Level portable keeps the operations of one pair at a time.)
        let (shifted, start) = inside.shifted(isa, kernel.edge);
        let ((four_x, rest_x), (four_m, rest_m)) = (positions.as_chunks::<4>(), masses.as_chunks::<4>());
        (positions, masses) = (rest_x, rest_m);
        for (xs, ms) in four_x.iter().zip(four_m) {
            let mut factors = [[one; NB]; 4];
            for (factors, x) in factors.iter_mut().zip(xs) {
                let (d, _) = distances(isa, x, &local);
                for (factor, d) in factors.iter_mut().zip(&d) {
                    *factor = start;
                    for &d in d {
                        *factor = isa.mul_add(d, d, *factor);
                    }
                }
            }
            for (factors, &m) in factors.iter_mut().zip(ms) {
                let mass = isa.splat(m);
                *factors = shifted.at::<T, I, NB, TERMS>(isa, factors);
                for factor in factors {
                    *factor = isa.mul(mass, *factor);
                }
            }
            for (factors, x) in factors.iter().zip(xs) {
                let (d, _) = distances(isa, x, &local);
                for ((group, d), &g) in local.iter_mut().zip(&d).zip(factors) {
                    gather::<T, I, D, P, G, C>(isa, group, d, one, g, g);
                }
            }
            done += 4;
        }
    }
    for (x, &m) in positions.iter().zip(masses) {
        let (d, r2) = distances(isa, x, &local);
        if TEST && !isa.all_below(&r2, kernel.edge) {
            break;
        }
        let mass = isa.splat(m);
        let t = r2.map(|r2| isa.neg_mul_add(r2, inside.per_square, one));
        let (mut k, mut g) = (r2, r2);
        if G {
            g = inside.gradient.at::<T, I, NB, TERMS>(isa, &t);
        }
        if P {
            k = inside.potential::<T, I, D, NB>(isa, &t, &r2);
        }
        for ((group, d), (&k, &g)) in local.iter_mut().zip(&d).zip(k.iter().zip(&g)) {
            gather::<T, I, D, P, G, C>(isa, group, d, mass, k, if G { isa.mul(mass, g) } else { g });
        }
        if laplacian {
            let b = inside.density.at::<T, I, NB, 0>(isa, &t);
            for (group, b) in local.iter_mut().zip(b) {
                let Group { sums, lost, .. } = group;
                accumulate::<T, I, C>(isa, &mut sums.laplacian, &mut lost.laplacian, mass, b);
            }
        }
        done += 1;
    }
    *groups = local;
    done
}

/// Adds what one source gives to the lanes inside the support, and to no other; returns one word of lanes a vector: those
/// below the edge. Without polynomials nothing is added, and the lanes go to the scaled path.
#[inline(always)]
pub(super) fn inside<
    T: Real,
    I: Isa<T>,
    const D: usize,
    const NB: usize,
    const P: bool,
    const G: bool,
    const C: bool,
>(
    isa: I,
    kernel: &Softened<I::V>,
    laplacian: bool,
    source: &[T; D],
    mass: T,
    groups: &mut [Group<I::V, D>; NB],
) -> [u32; NB] {
    let (zero, one, mass) = (isa.splat(T::ZERO), isa.splat(T::ONE), isa.splat(mass));
    let (d, r2) = distances(isa, source, groups);
    let mut lanes = [0; NB];
    for (((group, d), &r2), lanes) in groups.iter_mut().zip(&d).zip(&r2).zip(&mut lanes) {
        let below = isa.lt(r2, kernel.edge);
        *lanes = isa.bits(below);
        let Some(inside) = &kernel.inside else { continue };
        let t = [isa.neg_mul_add(r2, inside.per_square, one)];
        let (mut k, mut g) = (zero, zero);
        if G {
            let [factor] = inside.gradient.at::<T, I, 1, 0>(isa, &t);
            g = isa.select(below, isa.mul(mass, factor), zero);
        }
        if P {
            let [value] = inside.potential::<T, I, D, 1>(isa, &t, &[r2]);
            k = isa.select(below, value, zero);
        }
        gather::<T, I, D, P, G, C>(isa, group, d, mass, k, g);
        if laplacian {
            let [density] = inside.density.at::<T, I, 1, 0>(isa, &t);
            let Group { sums, lost, .. } = group;
            let b = isa.select(below, density, zero);
            accumulate::<T, I, C>(isa, &mut sums.laplacian, &mut lost.laplacian, mass, b);
        }
    }
    lanes
}

/// Source minus target, and its square, for every vector.
#[inline(always)]
fn distances<T: Real, I: Isa<T>, const D: usize, const NB: usize>(
    isa: I,
    source: &[T; D],
    groups: &[Group<I::V, D>; NB],
) -> ([[I::V; D]; NB], [I::V; NB]) {
    let zero = isa.splat(T::ZERO);
    let at = source.map(|c| isa.splat(c));
    let (mut d, mut r2) = ([[zero; D]; NB], [zero; NB]);
    for ((d, r2), group) in d.iter_mut().zip(&mut r2).zip(groups) {
        *d = difference(isa, at, group.x);
        *r2 = square(isa, d);
    }
    (d, r2)
}

/// Source minus target.
#[inline(always)]
fn difference<T: Real, I: Isa<T>, const D: usize>(isa: I, source: [I::V; D], target: [I::V; D]) -> [I::V; D] {
    let mut d = source;
    d.iter_mut().zip(target).for_each(|(d, x)| *d = isa.sub(*d, x));
    d
}

#[inline(always)]
fn square<T: Real, I: Isa<T>, const D: usize>(isa: I, d: &[I::V; D]) -> I::V {
    let mut parts = d.iter();
    let first = parts.next().map_or(isa.splat(T::ZERO), |&d| isa.mul(d, d));
    parts.fold(first, |sum, &d| isa.mul_add(d, d, sum))
}

/// (S_D K, m S_D g) of the bare kernel; in 2D the first is log r2.
#[inline(always)]
pub(super) fn outside<T: Real, I: Isa<T>, const D: usize, const NB: usize, const P: bool, const G: bool>(
    isa: I,
    log_exponent: I::V,
    mass: I::V,
    d: &[[I::V; D]; NB],
    r2: &[I::V; NB],
) -> [(I::V, I::V); NB] {
    let zero = isa.splat(T::ZERO);
    let mut result = [(zero, zero); NB];
    match D {
        1 => {
            // K = |x| / 2; the gradient factor is 1 / |x|, of which only the sign of x remains.
            if G {
                let g = isa.quotients(mass, r2.map(|r2| isa.sqrt(r2)));
                result.iter_mut().zip(g).for_each(|(result, g)| result.1 = g);
            }
            if P {
                for (result, d) in result.iter_mut().zip(d) {
                    result.0 = d.first().map_or(zero, |&d| isa.abs(d));
                }
            }
        }
        2 if P => {
            // Stage by stage for all vectors: their chains of dependent operations then run beside each other.
            let (one, two) = (isa.splat(T::ONE), isa.splat(T::TWO));
            let (mut z, mut e, mut s) = ([zero; NB], [zero; NB], [zero; NB]);
            for ((z, e), &r2) in z.iter_mut().zip(&mut e).zip(r2) {
                (*z, *e) = log_numerator(isa, r2);
                *e = isa.add(*e, log_exponent);
            }
            if G {
                // 1 / (r2 (2 + z)) serves both divisions.
                for ((both, &r2), &z) in s.iter_mut().zip(r2).zip(&z) {
                    *both = isa.div(one, isa.mul(r2, isa.add(two, z)));
                }
                for (((s, &r2), &z), result) in s.iter_mut().zip(r2).zip(&z).zip(&mut result) {
                    result.1 = isa.mul(isa.mul(mass, *s), isa.add(two, z));
                    *s = isa.mul(isa.mul(z, *s), r2);
                }
            } else {
                for (s, &z) in s.iter_mut().zip(&z) {
                    *s = isa.div(z, isa.add(two, z));
                }
            }
            let logs = log(isa, e, s);
            result.iter_mut().zip(logs).for_each(|(result, log)| result.0 = log);
        }
        2 => {
            if G {
                let g = isa.quotients(mass, *r2);
                result.iter_mut().zip(g).for_each(|(result, g)| result.1 = g);
            }
        }
        _ => {
            if P {
                for (result, &r2) in result.iter_mut().zip(r2) {
                    let root = isa.inverse_root(r2);
                    result.0 = isa.sub(zero, root);
                    if G {
                        result.1 = isa.mul(isa.mul(mass, root), isa.mul(root, root));
                    }
                }
            } else if G {
                let g = isa.over_cubed_roots(mass, *r2);
                result.iter_mut().zip(g).for_each(|(result, g)| result.1 = g);
            }
        }
    }
    result
}

/// m S_D g of the bare kernel at one place, rounded as [`outside`] rounds it at level portable.
#[inline(always)]
pub(super) fn far_gradient<T: Real, const D: usize>(mass: T, r2: T) -> T {
    match D {
        1 => mass / r2.sqrt(),
        2 => mass / r2,
        _ => mass / (r2 * r2.sqrt()),
    }
}

#[inline(always)]
fn gather<T: Real, I: Isa<T>, const D: usize, const P: bool, const G: bool, const C: bool>(
    isa: I,
    group: &mut Group<I::V, D>,
    d: &[I::V; D],
    mass: I::V,
    k: I::V,
    g: I::V,
) {
    let Group { sums, lost, .. } = group;
    if P {
        accumulate::<T, I, C>(isa, &mut sums.potential, &mut lost.potential, mass, k);
    }
    if G {
        for ((sum, lost), &d) in sums.gradient.iter_mut().zip(&mut lost.gradient).zip(d) {
            accumulate::<T, I, C>(isa, sum, lost, g, d);
        }
    }
}

/// sum + a b; compensated, the addition's error (Knuth's two-sum) goes to `lost`.
#[inline(always)]
fn accumulate<T: Real, I: Isa<T>, const C: bool>(isa: I, sum: &mut I::V, lost: &mut I::V, a: I::V, b: I::V) {
    if C {
        let term = isa.mul(a, b);
        let total = isa.add(*sum, term);
        let back = isa.sub(total, *sum);
        let error = isa.add(isa.sub(*sum, isa.sub(total, back)), isa.sub(term, back));
        *lost = isa.add(*lost, error);
        *sum = total;
    } else {
        *sum = isa.mul_add(a, b, *sum);
    }
}

//! One dimension: sort once, then sweep.
//!
//! Where the kernel is a polynomial of the distance (|x|/2, |x|^3/3, also with even powers), all sources left of a target
//! enter through their moments, and so do all right of it; the sweep keeps both up to date, O(n log n) in all. Under a
//! mollifier the polynomial holds beyond its reach only; the few sources closer than that are summed one by one.
//!
//! Moments are taken about the sources' centre (weights |m|), which bounds sum |m| |y-c|^k and |x-c|^k sum |m| each by 2^k
//! times sum |m| |x-y|^k: the expansion of (x-y)^k in them then loses a factor 4^k at most, not digits without bound. They are
//! kept in double-word arithmetic, so that adding up n of them costs nothing more. Those of the sources on the right are added up from the right,
//! at every [`STRIDE`]-th source before the sweep and between these in it: what stands elsewhere, however heavy, takes no digits from them. Near
//! sources are added up in blocks.
//!
//! Moments are computed in units ([`Units`]), near sources in units of delta, so that a true result in range is computed whatever the scene's
//! units. All masses have one unit: those below 2^-126 (f64: 2^-1022) of the largest lose digits, and count as zero in the end.

use super::options::{Accumulation, Options};
use super::pairs::{BLOCK, SHORT_BLOCK, Units, power_of_two_pair as power_of_two};
use super::problem::{Outputs, Sources, Wanted};
use crate::build;
use crate::checked::Present;
use crate::error::{Error, Result};
use crate::exec::{Run, Statistics};
use crate::kernel::{Far, Kernel, Near, POWERS, Scaled};
use crate::memory::{Carve, Measure, Space};
use crate::real::{DoubleWord, Extended, Real, Scalar, quotient};
use crate::simd::{Loops, with_simd};
use crate::sort::radix::{Entry, order};

/// Targets whose results are written together: the outputs' order is another, so each write may miss every cache, and one after the other
/// they wait for memory at the same time.
const TOGETHER: usize = 64;
/// Targets between two calls of `should_stop`.
const STOP_INTERVAL: usize = 64 * TOGETHER;
/// Near sources per vector operation (16 was slower, although one iteration would then suffice for most targets).
const LANES: usize = 8;
/// Sources from one place to the next where the moments of all sources to the right are kept.
const STRIDE: usize = 32;

/// The moments of all sources from one place on: high and low words.
type Kept<T> = [[T; 2]; POWERS];

struct Arrays<'w, T> {
    entries: &'w mut [Entry],
    spare: &'w mut [Entry],
    /// At every [`STRIDE`]-th place.
    kept: &'w mut [Kept<T>],
    /// Sorted sources, then padding at infinite distance.
    positions: &'w mut [T],
    masses: &'w mut [T],
}

fn layout<'w, T: Real>(space: &mut impl Space<'w>, n_sources: usize, n_targets: usize) -> Result<Arrays<'w, T>> {
    let most = n_sources.max(n_targets);
    let padded = n_sources.checked_add(LANES).ok_or(Error::TooLarge)?;
    Ok(Arrays {
        entries: space.try_array(most)?,
        spare: space.try_array(most)?,
        kept: space.try_array(n_sources / STRIDE + 1)?,
        positions: space.try_array(padded)?,
        masses: space.try_array(padded)?,
    })
}

/// Bytes of workspace.
pub(super) fn workspace_bytes<T: Real>(n_sources: usize, n_targets: usize) -> Result<usize> {
    Measure::of(|space| layout::<T>(space, n_sources, n_targets).map(|_| ()))
}

/// Moments of powers 0 .. N - 1.
type Moments<T, const N: usize> = [DoubleWord<T>; N];

#[inline(always)]
fn add<T: Real, const N: usize>(moments: &mut Moments<T, N>, y: T, m: T) {
    let mut term = m;
    for value in moments {
        *value = value.plus(term);
        term *= y;
    }
}

/// Weights of the expansion: `weights[l][j] = a_{j+l} C(j+l, l) (-1)^l`.
type Weights<T, const N: usize> = [[T; N]; N];

fn weights<T: Real, const N: usize>(far: &Scaled<T>) -> Weights<T, N> {
    let mut weights = [[T::ZERO; N]; N];
    for (l, row) in weights.iter_mut().enumerate() {
        // C(k, l) for k = l, l + 1, ...: whole numbers below 2^8, exact
        let mut binomial = if l % 2 == 0 { T::ONE } else { -T::ONE };
        for (j, (slot, &coefficient)) in row.iter_mut().zip(far.coefficients.iter().skip(l)).enumerate() {
            *slot = coefficient * binomial;
            binomial = binomial * T::from_usize(j + l + 1) / T::from_usize(j + 1);
        }
    }
    weights
}

/// c_0 .. c_{N-1} of the sum over both sides as a polynomial of x - c: from left and right moments L, R,
/// c_j = sum_{l, k = j + l} a_k C(k, l) (-1)^l (L_l + (-1)^k R_l).
#[inline(always)]
fn expand<T: Real, const N: usize>(weights: &Weights<T, N>, left: &Moments<T, N>, right: &Moments<T, N>) -> [T; N] {
    let mut c = [T::ZERO; N];
    for (l, ((left, right), row)) in left.iter().zip(right).zip(weights).enumerate() {
        // one rounding of |L| + |R| each: the low words only correct it
        let even = (left.hi + right.hi) + (left.lo + right.lo);
        let odd = (left.hi - right.hi) + (left.lo - right.lo);
        for (j, (&weight, slot)) in row.iter().zip(&mut c).take(N - l).enumerate() {
            *slot += weight * if (j + l) % 2 == 0 { even } else { odd };
        }
    }
    c
}

/// The moments of the sources from any place on.
struct Right<'a, T, const N: usize> {
    positions: &'a [T],
    masses: &'a [T],
    length: T,
    centre: T,
    kept: &'a [Kept<T>],
    /// The stretch whose places are in `here`.
    stretch: usize,
    here: [Moments<T, N>; STRIDE],
}

impl<'a, T: Real, const N: usize> Right<'a, T, N> {
    fn new((positions, masses): (&'a [T], &'a [T]), (length, centre): (T, T), kept: &'a mut [Kept<T>]) -> Self {
        let mut sum = [DoubleWord::ZERO; N];
        for (k, (&y, &m)) in positions.iter().zip(masses).enumerate().rev() {
            add(&mut sum, y * length - centre, m);
            if let Some(kept) = kept.get_mut(k / STRIDE).filter(|_| k.is_multiple_of(STRIDE)) {
                kept.iter_mut().zip(&sum).for_each(|(to, from)| *to = [from.hi, from.lo]);
            }
        }
        let here = [[DoubleWord::ZERO; N]; STRIDE];
        Self { positions, masses, length, centre, kept, stretch: usize::MAX, here }
    }

    /// Of the sources from number `k` on.
    #[inline(always)]
    fn from(&mut self, k: usize) -> &Moments<T, N> {
        if self.stretch != k / STRIDE {
            self.enter(k / STRIDE);
        }
        let [first, ..] = &self.here;
        self.here.get(k % STRIDE).unwrap_or(first)
    }

    #[inline(always)]
    fn enter(&mut self, stretch: usize) {
        self.stretch = stretch;
        let (start, end) = (stretch * STRIDE, (stretch + 1) * STRIDE);
        let mut sum = [DoubleWord::ZERO; N];
        if end < self.positions.len() {
            let kept = self.kept.get(stretch + 1).into_iter().flatten();
            sum.iter_mut().zip(kept).for_each(|(to, &[hi, lo])| *to = DoubleWord { hi, lo });
        }
        let end = end.min(self.positions.len());
        let sources = (self.positions.get(start..end).present_or(&[]), self.masses.get(start..end).present_or(&[]));
        self.here = [[DoubleWord::ZERO; N]; STRIDE];
        let places = self.here.iter_mut().zip(sources.0.iter().zip(sources.1));
        for (here, (&y, &m)) in places.rev() {
            add(&mut sum, y * self.length - self.centre, m);
            *here = sum;
        }
    }
}

/// Writes the sums. The caller has checked lengths, values and the workspace's size.
pub(super) fn evaluate<T: Real, const D: usize>(
    (kernel, far): (&Kernel<'_, T, D>, &Far),
    options: &Options,
    sources: Sources<'_, T, D>,
    targets: &[[T; D]],
    outputs: Outputs<'_, T, D>,
    workspace: &mut [u8],
    run: &mut Run<'_>,
) -> Result<()> {
    let Arrays { entries, spare, kept, positions, masses } =
        layout::<T>(&mut Carve::new(workspace)?, sources.positions.len(), targets.len())?;
    let mass = |index: usize| sources.masses.get(index).copied().unwrap_or(T::ZERO);
    let source = |index: usize| if mass(index) == T::ZERO { None } else { sources.positions.get(index).map(first) };
    let count = order(sources.positions.len(), source, entries, spare);
    let massless = sources.masses.len() - count;
    let [coordinate, mass_of_all] = sources.largest(1);
    let units = Units::of([coordinate.max(kernel.delta()), mass_of_all], targets);
    let (length, heavy) = (T::ONE.ldexp(units.position), T::ONE.ldexp(units.mass));
    positions.iter_mut().skip(count).for_each(|y| *y = T::INFINITY);
    masses.iter_mut().skip(count).for_each(|m| *m = T::ZERO);
    for ((&index, y), m) in entries.as_flattened().iter().take(count).zip(positions.iter_mut()).zip(masses.iter_mut()) {
        (*y, *m) = (source(index as usize).unwrap_or(T::ZERO), mass(index as usize) * heavy);
    }
    // The order of the targets is known already where they are the sources.
    let same = core::ptr::eq(sources.positions, targets) && massless == 0;
    if !same {
        order(targets.len(), |index| targets.get(index).map(first), entries, spare);
    }
    let order = entries.as_flattened().get(..targets.len()).present()?;
    let scaled = far.in_units(units.position, 0);
    let exponent = scaled.exponent - units.mass;
    let reach = T::from_f64(far.reach);
    let near = match kernel.near() {
        Some(near) => Close::Polynomials(near, Unit::of(kernel.delta())),
        None => Close::any(kernel, reach),
    };
    let all = Sweep::<T, D, POWERS> {
        kernel,
        far: &scaled,
        reach,
        near: &near,
        compensated: options.accumulation == Accumulation::Compensated,
        length,
        scales: [0, 1, 2].map(|times: i32| power_of_two(exponent + times * units.position)),
        near_exponents: near.exponents().map(|exponent| exponent.saturating_sub(units.mass)),
        count,
        positions,
        masses,
        kept,
        sorted_targets: if same { positions.get(..count) } else { None },
        order,
        targets,
        outputs,
        should_stop: run.should_stop,
    };
    // Firmware has no room for three of them.
    let near_pairs = match far.degree() {
        0 | 1 if build::TILES => with_simd(run.level, all.with_moments::<2>()),
        2 | 3 if build::TILES => with_simd(run.level, all.with_moments::<4>()),
        _ => with_simd(run.level, all),
    }?;
    if let Some(counters) = run.counters.as_deref_mut() {
        let count =
            Statistics { pairs: near_pairs, near_pairs, massless_sources: massless as u64, ..Statistics::default() };
        counters.add(&count);
    }
    Ok(())
}

#[inline(always)]
fn first<T: Real, const D: usize>(x: &[T; D]) -> T {
    x.first().copied().unwrap_or(T::ZERO)
}

/// Distances in units of delta: two factors, as 1 / delta may not be normal.
#[derive(Clone, Copy)]
struct Unit<T> {
    length: T,
    per_delta: T,
}

impl<T: Real> Unit<T> {
    fn of(delta: T) -> Self {
        let limit = T::MAX_EXPONENT - 2;
        let length = delta.frexp().1.saturating_neg().max(-limit).min(limit);
        Self { length: T::ONE.ldexp(length), per_delta: T::ONE / delta.ldexp(length) }
    }
}

/// How sources within the reach are summed. Exponents: those that the sums of value, slope and Laplacian lack.
enum Close<T> {
    Polynomials(Near<T>, Unit<T>),
    /// One by one; in the scalar where `plain`, as nothing can leave its range.
    Any {
        exponents: [i32; 3],
        plain: bool,
    },
}

impl<T: Real> Close<T> {
    /// One by one, the exponents being about those of the largest values within the reach.
    fn any<const D: usize>(kernel: &Kernel<'_, T, D>, reach: T) -> Self {
        let (delta, reach) = (kernel.delta().to_f64(), reach.to_f64());
        let at = |r: f64, length: f64| {
            let [u, g, l] = kernel.pair_scaled(r, [true; 3]);
            [u, g.scale(length), l]
        };
        let mut exponents = [0; 3];
        for (to, (a, b)) in exponents.iter_mut().zip(at(0.0, delta).into_iter().zip(at(reach, reach))) {
            *to = [a, b].into_iter().filter_map(Extended::exponent).max().unwrap_or(0);
        }
        let [u, g, l] = exponents;
        let (limit, delta) = (T::MAX_EXPONENT / 4, Scalar::frexp(delta).1);
        let plain = [u, g, g.saturating_sub(delta), l, delta].iter().all(|e| (-limit..limit).contains(e));
        Self::Any { exponents, plain }
    }

    fn exponents(&self) -> [i32; 3] {
        match self {
            Self::Polynomials(near, _) => near.exponents,
            Self::Any { exponents, .. } => *exponents,
        }
    }
}

/// The sweep over sorted sources and targets, with moments of powers below N.
struct Sweep<'a, 'k, T: Real, const D: usize, const N: usize> {
    kernel: &'a Kernel<'k, T, D>,
    far: &'a Scaled<T>,
    reach: T,
    near: &'a Close<T>,
    compensated: bool,
    /// The factor of coordinates.
    length: T,
    /// Factors of the sums over distant sources, to be multiplied one after the other.
    scales: [[T; 2]; 3],
    /// The exponents of the sums over near ones.
    near_exponents: [i32; 3],
    /// How many sources there are; lanes of none follow them.
    count: usize,
    /// In true units.
    positions: &'a [T],
    /// In units.
    masses: &'a [T],
    kept: &'a mut [Kept<T>],
    /// The targets in order, where they stand so already.
    sorted_targets: Option<&'a [T]>,
    order: &'a [u64],
    targets: &'a [[T; D]],
    outputs: Outputs<'a, T, D>,
    should_stop: Option<&'a (dyn Fn() -> bool + Sync)>,
}

impl<'a, 'k, T: Real, const D: usize, const N: usize> Sweep<'a, 'k, T, D, N> {
    fn with_moments<const LESS: usize>(self) -> Sweep<'a, 'k, T, D, LESS> {
        let Self { kernel, far, reach, near, compensated, length, scales, near_exponents, count, .. } = self;
        let Self { positions, masses, kept, sorted_targets, order, targets, outputs, should_stop, .. } = self;
        Sweep {
            kernel,
            far,
            reach,
            near,
            compensated,
            length,
            scales,
            near_exponents,
            count,
            positions,
            masses,
            kept,
            sorted_targets,
            order,
            targets,
            outputs,
            should_stop,
        }
    }
}

impl<T: Real, const D: usize, const N: usize> Loops for Sweep<'_, '_, T, D, N> {
    /// The number of near pairs.
    type Out = Result<u64>;

    #[inline(always)]
    fn run(self) -> Self::Out {
        let Self { kernel, far, reach, near, compensated, length, scales, near_exponents, count, .. } = self;
        let Self { positions, masses, kept, sorted_targets, order, targets, mut outputs, should_stop, .. } = self;
        let weights = weights::<T, N>(far);
        let (singular, wanted) = (kernel.is_singular(), outputs.wanted());
        let (sources, source_masses) = (positions.get(..count).present()?, masses.get(..count).present()?);
        let none = (DoubleWord::ZERO, DoubleWord::ZERO);
        let (weight, moment) = sources.iter().zip(source_masses).fold(none, |(w, s), (&y, &m)| {
            let share = m.abs();
            (w.plus(share), s.plus(share * (y * length)))
        });
        let centre = if weight.hi > T::ZERO { quotient(moment.hi, weight.hi) } else { T::ZERO };

        // sources further left than the reach, and from the first one further right on
        let mut left = [DoubleWord::ZERO; N];
        let mut right = Right::<T, N>::new((sources, source_masses), (length, centre), kept);
        let (mut low, mut high) = (0_usize, 0_usize);
        let source = |k: usize| Some((*sources.get(k)?, *source_masses.get(k)?));
        let mut near_pairs = 0_u64;
        for (block, indices) in order.chunks(TOGETHER).enumerate() {
            let first_step = block * TOGETHER;
            if first_step.is_multiple_of(STOP_INTERVAL) && should_stop.is_some_and(|stop| stop()) {
                return Err(Error::Stopped);
            }
            let mut results = [[T::ZERO; 3]; TOGETHER];
            for ((step, &index), result) in (first_step..).zip(indices).zip(&mut results) {
                let x = match sorted_targets {
                    Some(sorted) => sorted.get(step).copied(),
                    None => targets.get(index as usize).map(first),
                };
                let Some(x) = x else { continue };
                while let Some((y, m)) = source(low).filter(|&(y, _)| x - y > reach) {
                    add(&mut left, y * length - centre, m);
                    low += 1;
                }
                while sources.get(high).is_some_and(|&y| y - x <= reach) {
                    high += 1;
                }
                let at = x * length - centre;
                let (mut u, mut du, mut ddu) = (T::ZERO, T::ZERO, T::ZERO);
                for &c in expand(&weights, &left, right.from(high)).iter().rev() {
                    // value, first and half the second derivative together
                    ddu = ddu * at + du;
                    du = du * at + u;
                    u = u * at + c;
                }
                ddu += ddu;
                let [of_potential, of_gradient, of_laplacian] = &scales;
                let scale = |value: T, factors: &[T; 2]| value * factors[0] * factors[1];
                *result = [scale(u, of_potential), scale(du, of_gradient), scale(ddu, of_laplacian)];
                if !singular {
                    let count = high.saturating_sub(low);
                    near_pairs += count as u64;
                    let behind = (positions.get(low..).present()?, masses.get(low..).present()?);
                    let how = (compensated, wanted);
                    let sums = match near {
                        Close::Polynomials(near, unit) => {
                            near_polynomials((near, unit), (x, reach), behind, count, how)
                        }
                        Close::Any { exponents, plain } => {
                            near_one_by_one(kernel, (exponents, *plain), x, behind, count, how)
                        }
                    };
                    for ((result, sum), exponent) in result.iter_mut().zip(sums).zip(near_exponents) {
                        *result += sum.ldexp(exponent);
                    }
                }
            }
            let done = indices.iter().map(|&index| index as usize).zip(&results);
            if let Some(out) = outputs.potential.as_deref_mut() {
                done.clone().for_each(|(at, &[u, ..])| out.get_mut(at).into_iter().for_each(|slot| *slot = u));
            }
            if let Some(out) = outputs.gradient.as_deref_mut() {
                for (at, &[_, du, _]) in done.clone() {
                    out.get_mut(at).and_then(|g| g.first_mut()).into_iter().for_each(|slot| *slot = du);
                }
            }
            if let Some(out) = outputs.laplacian.as_deref_mut() {
                done.for_each(|(at, &[.., ddu])| out.get_mut(at).into_iter().for_each(|slot| *slot = ddu));
            }
        }
        Ok(near_pairs)
    }
}

/// Sums of value, slope and Laplacian over blocks.
struct Totals<T> {
    compensated: bool,
    sums: [DoubleWord<T>; 3],
}

impl<T: Real> Totals<T> {
    #[inline(always)]
    fn new(compensated: bool) -> Self {
        Self { compensated, sums: [DoubleWord::ZERO; 3] }
    }

    #[inline(always)]
    fn add(&mut self, block: [T; 3]) {
        for (sum, term) in self.sums.iter_mut().zip(block) {
            if self.compensated {
                *sum = sum.plus(term);
            } else {
                sum.hi += term;
            }
        }
    }

    /// Sources in a block.
    #[inline(always)]
    fn block(&self) -> usize {
        if self.compensated { SHORT_BLOCK } else { BLOCK }
    }

    #[inline(always)]
    fn values(&self) -> [T; 3] {
        self.sums.map(|sum| sum.hi)
    }
}

/// The sums over near sources by the polynomials inside a compact mollifier, lanes of sources at a time. `positions` and
/// `masses` begin with the near sources, which are `count`; what follows them is further than `reach`, or not there.
#[inline(always)]
fn near_polynomials<T: Real>(
    (near, unit): (&Near<T>, &Unit<T>),
    (x, reach): (T, T),
    (positions, masses): (&[T], &[T]),
    count: usize,
    (compensated, wanted): (bool, Wanted),
) -> [T; 3] {
    let (mut totals, mut sums) = (Totals::new(compensated), [[T::ZERO; LANES]; 3]);
    let each = totals.block();
    let all = |sums: [[T; LANES]; 3]| sums.map(|lanes| lanes.into_iter().fold(T::ZERO, |sum, v| sum + v));
    for block in 0..count.div_ceil(LANES) {
        let start = LANES * block;
        if start.is_multiple_of(each) && start > 0 {
            totals.add(all(sums));
            sums = [[T::ZERO; LANES]; 3];
        }
        let (Some(&y), Some(&mass)) = (
            positions.get(start..).and_then(<[T]>::first_chunk::<LANES>),
            masses.get(start..).and_then(<[T]>::first_chunk::<LANES>),
        ) else {
            break;
        };
        // lanes further than the reach stand on the target and have no mass
        let (mut offset, mut m) = ([T::ZERO; LANES], [T::ZERO; LANES]);
        for ((offset, m), (&y, &mass)) in offset.iter_mut().zip(&mut m).zip(y.iter().zip(&mass)) {
            let d = x - y;
            let inside = d.abs() <= reach;
            let (d, mass) = (if inside { d } else { T::ZERO }, if inside { mass } else { T::ZERO });
            (*offset, *m) = (d * unit.length * unit.per_delta, mass);
        }
        let (mut t, mut s) = ([T::ZERO; LANES], [T::ZERO; LANES]);
        for ((t, s), &q) in t.iter_mut().zip(&mut s).zip(&offset) {
            (*t, *s) = (T::ONE - q * q, q * q);
        }
        let [u, du, ddu] = &mut sums;
        if wanted.potential {
            let value = near_series(near, 0, &t, &s);
            u.iter_mut().zip(&m).zip(&value).for_each(|((sum, &m), &value)| *sum += m * value);
        }
        if wanted.gradient {
            let factor = near_series(near, 1, &t, &s);
            let terms = du.iter_mut().zip(&m).zip(&offset).zip(&factor);
            terms.for_each(|(((sum, &m), &offset), &factor)| *sum += m * factor * offset);
        }
        if wanted.laplacian {
            let value = near_series(near, 2, &t, &s);
            ddu.iter_mut().zip(&m).zip(&value).for_each(|((sum, &m), &value)| *sum += m * value);
        }
    }
    totals.add(all(sums));
    totals.values()
}

/// A polynomial in every lane, lowest power first, by Horner's rule.
#[inline(always)]
fn horner<T: Real>(coefficients: impl DoubleEndedIterator<Item = T>, x: &[T; LANES]) -> [T; LANES] {
    coefficients.rev().fold([T::ZERO; LANES], |mut sum, c| {
        sum.iter_mut().zip(x).for_each(|(sum, &x)| *sum = *sum * x + c);
        sum
    })
}

/// The k-th quantity (value, gradient factor, Laplacian) of every lane: a polynomial of t and one of s = 1 - t.
#[inline(always)]
fn near_series<T: Real>(near: &Near<T>, k: usize, t: &[T; LANES], s: &[T; LANES]) -> [T; LANES] {
    let mut edge = horner(near.edge.get(k).and_then(|e| e.get(..near.edge_terms)).present_or(&[]).iter().copied(), t);
    if near.square_terms > 0 {
        let square =
            horner(near.square.get(k).and_then(|e| e.get(..near.square_terms)).present_or(&[]).iter().copied(), s);
        edge.iter_mut().zip(&square).for_each(|(sum, &more)| *sum += more);
    }
    edge
}

/// The same for any kernel, pair by pair.
#[inline(never)]
fn near_one_by_one<T: Real, const D: usize>(
    kernel: &Kernel<'_, T, D>,
    (exponents, plain): (&[i32; 3], bool),
    x: T,
    (positions, masses): (&[T], &[T]),
    count: usize,
    (compensated, wanted): (bool, Wanted),
) -> [T; 3] {
    let (positions, masses) = (positions.get(..count).unwrap_or(positions), masses.get(..count).unwrap_or(masses));
    let mut totals = Totals::new(compensated);
    let each = totals.block().max(1);
    let [of_value, of_slope, of_laplacian] = exponents.map(i32::saturating_neg);
    let wanted = wanted.into();
    for (positions, masses) in positions.chunks(each).zip(masses.chunks(each)) {
        totals.add(positions.iter().zip(masses).fold([T::ZERO; 3], |[u, du, ddu], (&y, &m)| {
            let offset = x - y;
            let [value, slope, laplacian] = if plain {
                let [value, factor, laplacian] = kernel.pair(offset.abs(), wanted);
                [value.ldexp(of_value), (factor * offset).ldexp(of_slope), laplacian.ldexp(of_laplacian)]
            } else {
                let [value, factor, laplacian] = kernel.pair_scaled(offset.abs().to_f64(), wanted);
                let slope = factor.times(Extended::new(offset.to_f64(), 0));
                let scaled = [value.shift(of_value), slope.shift(of_slope), laplacian.shift(of_laplacian)];
                scaled.map(|v| T::from_f64(v.get()))
            };
            [u + m * value, du + m * slope, ddu + m * laplacian]
        }));
    }
    totals.values()
}

impl From<Wanted> for [bool; 3] {
    fn from(wanted: Wanted) -> Self {
        [wanted.potential, wanted.gradient, wanted.laplacian]
    }
}

//! One dimension: sort once, then sweep.
//!
//! Where the kernel is a polynomial of the distance (|x|/2, |x|^3/3, also with even powers), all sources left of a target
//! enter through their moments, and so do all right of it; the sweep keeps both up to date, O(n log n) in all. Under a
//! mollifier the polynomial holds beyond its reach only; the few sources closer than that are summed one by one.
//!
//! Moments are taken about the sources' centre (weights |m|), which bounds sum |m| |y-c|^k and |x-c|^k sum |m| each by 2^k
//! times sum |m| |x-y|^k: the expansion of (x-y)^k in them then loses a factor 4^k at most, not digits without bound. They are
//! kept in double-word arithmetic, so that adding up n of them costs nothing more. Near sources are added up in blocks. Everything is
//! computed in units ([`Units`]), so that a true result in range is computed whatever the scene's units.

use super::pairs::{BLOCK, Units, power_of_two_pair as power_of_two};
use super::problem::{Outputs, Sources, Wanted};
use crate::error::{Error, Result};
use crate::exec::{Run, Statistics};
use crate::kernel::{Far, Kernel, Near, POWERS};
use crate::memory::{Carve, Measure, Space};
use crate::real::{DoubleWord, Real};
use crate::simd::{Loops, with_simd};
use crate::sort::radix::{Entry, order};

/// Targets whose results are written together: the outputs' order is another, so each write may miss every cache, and one after the other
/// they wait for memory at the same time.
const TOGETHER: usize = 64;
/// So many between two questions whether to stop.
const ASK: usize = 64 * TOGETHER;
/// Near sources side by side (sixteen take longer, though one round would then do for most targets).
const LANES: usize = 8;

struct Arrays<'w, T> {
    entries: &'w mut [Entry],
    spare: &'w mut [Entry],
    /// Sorted sources, and behind them lanes of none, infinitely far.
    positions: &'w mut [T],
    masses: &'w mut [T],
}

fn layout<'w, T: Real>(space: &mut impl Space<'w>, n_sources: usize, n_targets: usize) -> Result<Arrays<'w, T>> {
    let most = n_sources.max(n_targets);
    let padded = n_sources.checked_add(LANES).ok_or(Error::TooLarge)?;
    Ok(Arrays {
        entries: space.try_array(most)?,
        spare: space.try_array(most)?,
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

fn weights<T: Real, const N: usize>(far: &Far<T>) -> Weights<T, N> {
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
/// c_j = sum_{l, k = j + l} a_k C(k, l) (-1)^l (L_l + (-1)^k R_l), where R is the total less what has been passed.
#[inline(always)]
fn expand<T: Real, const N: usize>(
    weights: &Weights<T, N>,
    left: &Moments<T, N>,
    passed: &Moments<T, N>,
    total: &Moments<T, N>,
) -> [T; N] {
    let mut c = [T::ZERO; N];
    for (l, (((left, passed), total), row)) in left.iter().zip(passed).zip(total).zip(weights).enumerate() {
        // one rounding of |L| + |R| each: the low words only correct it
        let (right, rest) = (total.hi - passed.hi, total.lo - passed.lo);
        let even = (left.hi + right) + (left.lo + rest);
        let odd = (left.hi - right) + (left.lo - rest);
        for (j, (&weight, slot)) in row.iter().zip(&mut c).take(N - l).enumerate() {
            *slot += weight * if (j + l) % 2 == 0 { even } else { odd };
        }
    }
    c
}

/// Writes the sums. The caller has checked lengths, values and the workspace's size.
pub(super) fn evaluate<T: Real, const D: usize>(
    kernel: &Kernel<'_, T, D>,
    far: &Far<T>,
    sources: Sources<'_, T, D>,
    targets: &[[T; D]],
    outputs: Outputs<'_, T, D>,
    workspace: &mut [u8],
    run: &mut Run<'_>,
) -> Result<()> {
    let Arrays { entries, spare, positions, masses } =
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
        (*y, *m) = (source(index as usize).unwrap_or(T::ZERO) * length, mass(index as usize) * heavy);
    }
    // The order of the targets is known already where they are the sources.
    let same = core::ptr::eq(sources.positions, targets) && massless == 0;
    if !same {
        order(targets.len(), |index| targets.get(index).map(first), entries, spare);
    }
    let order = entries.as_flattened().get(..targets.len()).unwrap_or(&[]);
    let (far, largest) = far.in_units(units.position);
    let exponent = largest - units.mass;
    let all = Sweep::<T, D, POWERS> {
        kernel,
        far: &far,
        near: kernel.near().map(|near| near.in_units(units.position, largest)),
        units: (units.position, largest),
        length,
        scales: [0, 1, 2].map(|times: i32| power_of_two(exponent + times * units.position)),
        count,
        positions,
        masses,
        sorted_targets: if same { positions.get(..count) } else { None },
        order,
        targets,
        outputs,
        should_stop: run.should_stop,
    };
    // Firmware has no room for three of them.
    let near_pairs = match far.degree() {
        0 | 1 if !cfg!(feature = "small") => with_simd(run.level, all.with_moments::<2>()),
        2 | 3 if !cfg!(feature = "small") => with_simd(run.level, all.with_moments::<4>()),
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

/// The sweep over sorted sources and targets, with moments of powers below N.
struct Sweep<'a, 'k, T: Real, const D: usize, const N: usize> {
    kernel: &'a Kernel<'k, T, D>,
    far: &'a Far<T>,
    near: Option<Near<T>>,
    /// What [`Far::in_units`] was given and returned.
    units: (i32, i32),
    /// The factor of the targets' coordinates.
    length: T,
    /// Factors of the results, to be multiplied one after the other.
    scales: [[T; 2]; 3],
    /// How many sources there are; lanes of none follow them.
    count: usize,
    positions: &'a [T],
    masses: &'a [T],
    /// The targets in order, where they stand so already.
    sorted_targets: Option<&'a [T]>,
    order: &'a [u64],
    targets: &'a [[T; D]],
    outputs: Outputs<'a, T, D>,
    should_stop: Option<&'a (dyn Fn() -> bool + Sync)>,
}

impl<'a, 'k, T: Real, const D: usize, const N: usize> Sweep<'a, 'k, T, D, N> {
    fn with_moments<const LESS: usize>(self) -> Sweep<'a, 'k, T, D, LESS> {
        let Self { kernel, far, near, units, length, scales, count, positions, masses, .. } = self;
        let Self { sorted_targets, order, targets, outputs, should_stop, .. } = self;
        Sweep {
            kernel,
            far,
            near,
            units,
            length,
            scales,
            count,
            positions,
            masses,
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
        let Self {
            kernel,
            far,
            near,
            units,
            length,
            scales,
            count,
            positions,
            masses,
            sorted_targets,
            order,
            targets,
            mut outputs,
            should_stop,
        } = self;
        let (weights, reach) = (weights::<T, N>(far), far.reach);
        let (singular, wanted) = (kernel.is_singular(), outputs.wanted());
        let (sources, source_masses) = (positions.get(..count).unwrap_or(&[]), masses.get(..count).unwrap_or(&[]));
        let none = (DoubleWord::ZERO, DoubleWord::ZERO);
        let (weight, moment) = sources.iter().zip(source_masses).fold(none, |(w, s), (&y, &m)| {
            let share = m.abs();
            (w.plus(share), s.plus(share * y))
        });
        let centre = if weight.hi > T::ZERO { moment.hi / weight.hi } else { T::ZERO };
        let mut total = [DoubleWord::ZERO; N];
        for (&y, &m) in sources.iter().zip(source_masses) {
            add(&mut total, y - centre, m);
        }

        // sources further left than the reach, and sources not further right
        let (mut left, mut passed) = ([DoubleWord::ZERO; N], [DoubleWord::ZERO; N]);
        let (mut low, mut high) = (0_usize, 0_usize);
        let source = |k: usize| Some((*sources.get(k)?, *source_masses.get(k)?));
        let mut near_pairs = 0_u64;
        for (block, indices) in order.chunks(TOGETHER).enumerate() {
            let first_step = block * TOGETHER;
            if first_step.is_multiple_of(ASK) && should_stop.is_some_and(|stop| stop()) {
                return Err(Error::Stopped);
            }
            let mut results = [[T::ZERO; 3]; TOGETHER];
            for ((step, &index), result) in (first_step..).zip(indices).zip(&mut results) {
                let x = match sorted_targets {
                    Some(sorted) => sorted.get(step).copied(),
                    None => targets.get(index as usize).map(|x| first(x) * length),
                };
                let Some(x) = x else { continue };
                while let Some((y, m)) = source(low).filter(|&(y, _)| x - y > reach) {
                    add(&mut left, y - centre, m);
                    low += 1;
                }
                while let Some((y, m)) = source(high).filter(|&(y, _)| y - x <= reach) {
                    add(&mut passed, y - centre, m);
                    high += 1;
                }
                let at = x - centre;
                let (mut u, mut du, mut ddu) = (T::ZERO, T::ZERO, T::ZERO);
                for &c in expand(&weights, &left, &passed, &total).iter().rev() {
                    // value, first and half the second derivative together
                    ddu = ddu * at + du;
                    du = du * at + u;
                    u = u * at + c;
                }
                ddu += ddu;
                if !singular {
                    let count = high.saturating_sub(low);
                    near_pairs += count as u64;
                    let behind = positions.get(low..).unwrap_or(&[]);
                    let masses_behind = masses.get(low..).unwrap_or(&[]);
                    let sums = match &near {
                        Some(near) => near_polynomials(near, (x, reach), behind, masses_behind, count, wanted),
                        None => near_one_by_one(kernel, units, x, (behind, masses_behind), count, wanted),
                    };
                    (u, du, ddu) = (u + sums[0], du + sums[1], ddu + sums[2]);
                }
                let [of_potential, of_gradient, of_laplacian] = &scales;
                let scale = |value: T, factors: &[T; 2]| value * factors[0] * factors[1];
                *result = [scale(u, of_potential), scale(du, of_gradient), scale(ddu, of_laplacian)];
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

/// The sums over near sources by the polynomials inside a compact mollifier, lanes of sources at a time. `positions` and
/// `masses` begin with the near sources, which are `count`; what follows them is further than `reach`, or not there.
#[inline(always)]
fn near_polynomials<T: Real>(
    near: &Near<T>,
    (x, reach): (T, T),
    positions: &[T],
    masses: &[T],
    count: usize,
    wanted: Wanted,
) -> [T; 3] {
    let (mut totals, mut sums) = ([T::ZERO; 3], [[T::ZERO; LANES]; 3]);
    let all = |lanes: [T; LANES]| lanes.into_iter().fold(T::ZERO, |sum, v| sum + v);
    for block in 0..count.div_ceil(LANES) {
        let start = LANES * block;
        if start.is_multiple_of(BLOCK) {
            totals.iter_mut().zip(&mut sums).for_each(|(total, lanes)| *total += all(*lanes));
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
            (*offset, *m) = (if inside { d } else { T::ZERO }, if inside { mass } else { T::ZERO });
        }
        let (mut t, mut s) = ([T::ZERO; LANES], [T::ZERO; LANES]);
        for ((t, s), &offset) in t.iter_mut().zip(&mut s).zip(&offset) {
            let q = offset * near.per_delta;
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
    totals.iter_mut().zip(sums).for_each(|(total, lanes)| *total += all(lanes));
    totals
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
    let mut edge = horner(near.edge.get(k).and_then(|e| e.get(..near.edge_terms)).unwrap_or(&[]).iter().copied(), t);
    if near.square_terms > 0 {
        let square =
            horner(near.square.get(k).and_then(|e| e.get(..near.square_terms)).unwrap_or(&[]).iter().copied(), s);
        edge.iter_mut().zip(&square).for_each(|(sum, &more)| *sum += more);
    }
    edge
}

/// The same for any kernel, pair by pair.
#[inline(never)]
fn near_one_by_one<T: Real, const D: usize>(
    kernel: &Kernel<'_, T, D>,
    (position, largest): (i32, i32),
    x: T,
    (positions, masses): (&[T], &[T]),
    count: usize,
    wanted: Wanted,
) -> [T; 3] {
    let (positions, masses) = (positions.get(..count).unwrap_or(positions), masses.get(..count).unwrap_or(masses));
    let mut totals = [T::ZERO; 3];
    for (positions, masses) in positions.chunks(BLOCK).zip(masses.chunks(BLOCK)) {
        let sums = positions.iter().zip(masses).fold([T::ZERO; 3], |[u, du, ddu], (&y, &m)| {
            let offset = x - y;
            let [value, factor, laplacian] = kernel.pair(offset.abs().ldexp(-position), wanted.into());
            let slope = factor.ldexp(-largest - 2 * position);
            [u + m * value.ldexp(-largest), du + m * slope * offset, ddu + m * laplacian.ldexp(-largest - 2 * position)]
        });
        totals.iter_mut().zip(sums).for_each(|(total, sum)| *total += sum);
    }
    totals
}

impl From<Wanted> for [bool; 3] {
    fn from(wanted: Wanted) -> Self {
        [wanted.potential, wanted.gradient, wanted.laplacian]
    }
}

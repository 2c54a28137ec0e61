//! One dimension: sort once, then sweep.
//!
//! Where the kernel is a polynomial of the distance (|x|/2, |x|^3/3, also with even powers), all sources left of a target
//! enter through their moments, and so do all right of it; the sweep keeps both up to date, O(n log n) in all. Under a
//! mollifier the polynomial holds beyond its reach only; the few sources closer than that are summed one by one.
//!
//! Moments are taken about the sources' centre (weights |m|), which bounds sum |m| |y-c|^k and |x-c|^k sum |m| each by 2^k
//! times sum |m| |x-y|^k: the expansion of (x-y)^k in them then loses a factor 4^k at most, not digits without bound. They are
//! kept in double-word arithmetic, so that adding up n of them costs nothing more.

use super::radix::{Entry, ordered_bits, sort};
use super::{Counters, Outputs, Run, Sources, Wanted};
use crate::error::{Error, Result};
use crate::kernel::{Far, Kernel, POWERS};
use crate::real::{DoubleWord, Real};
use crate::space::{Carve, Measure, Space};

/// Targets between two questions whether to stop.
const ASK: usize = 4096;

struct Arrays<'w, T> {
    entries: &'w mut [Entry],
    spare: &'w mut [Entry],
    positions: &'w mut [T],
    masses: &'w mut [T],
}

fn lay<'w, T: Real>(space: &mut impl Space<'w>, n_sources: usize, n_targets: usize) -> Result<Arrays<'w, T>> {
    let most = n_sources.max(n_targets);
    Ok(Arrays {
        entries: space.array(most)?,
        spare: space.array(most)?,
        positions: space.array(n_sources)?,
        masses: space.array(n_sources)?,
    })
}

/// Bytes of workspace.
pub(super) fn workspace_bytes<T: Real>(n_sources: usize, n_targets: usize) -> Result<usize> {
    Measure::of(|space| lay::<T>(space, n_sources, n_targets).map(|_| ()))
}

/// Moments of powers 0 .. degree.
#[derive(Clone, Copy)]
struct Moments<T> {
    values: [DoubleWord<T>; POWERS],
}

impl<T: Real> Moments<T> {
    fn new() -> Self {
        Self { values: [DoubleWord::ZERO; POWERS] }
    }

    fn add(&mut self, degree: usize, y: T, m: T) {
        let mut term = m;
        for value in self.values.iter_mut().take(degree + 1) {
            // a sum of a double word and a number (Knuth's two-sum, and one renormalisation)
            let sum = DoubleWord::sum(value.hi, term);
            let lo = sum.lo + value.lo;
            let hi = sum.hi + lo;
            *value = DoubleWord { hi, lo: lo - (hi - sum.hi) };
            term *= y;
        }
    }
}

/// Weights of the expansion: `weights[l][j] = a_{j+l} C(j+l, l) (-1)^l`.
type Weights<T> = [[T; POWERS]; POWERS];

fn weights<T: Real>(far: &Far<T>) -> Weights<T> {
    let mut weights = [[T::ZERO; POWERS]; POWERS];
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

/// c_0 .. c_degree of the sum over both sides as a polynomial of x - c: from left and right moments L, R,
/// c_j = sum_{l, k = j + l} a_k C(k, l) (-1)^l (L_l + (-1)^k R_l).
fn expand<T: Real>(weights: &Weights<T>, degree: usize, left: &Moments<T>, right: &Moments<T>) -> [T; POWERS] {
    let mut c = [T::ZERO; POWERS];
    for (l, ((a, b), row)) in left.values.iter().zip(&right.values).zip(weights).take(degree + 1).enumerate() {
        let (even, odd) = ((*a + *b).hi, (*a - *b).hi);
        for (j, (&weight, slot)) in row.iter().zip(c.iter_mut()).take(degree + 1 - l).enumerate() {
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
    mut outputs: Outputs<'_, T, D>,
    workspace: &mut [u8],
    run: &mut Run<'_>,
) -> Result<()> {
    let first = |x: &[T; D]| x.first().copied().unwrap_or(T::ZERO);
    let Arrays { entries, spare, positions, masses } =
        lay::<T>(&mut Carve::new(workspace)?, sources.positions.len(), targets.len())?;
    let (degree, weights) = (far.degree(), weights(far));
    let singular = kernel.is_singular();
    let wanted = outputs.wanted();

    let sort_points = |points: &[[T; D]], masses: Option<&[T]>, entries: &mut [Entry], spare: &mut [Entry]| {
        let mut count = 0;
        for (index, x) in points.iter().enumerate() {
            if masses.is_some_and(|m| m.get(index).is_none_or(|&m| m == T::ZERO)) {
                continue;
            }
            if let Some(slot) = entries.get_mut(count) {
                *slot = [ordered_bits(first(x)), index as u64];
                count += 1;
            }
        }
        if let (Some(entries), Some(spare)) = (entries.get_mut(..count), spare.get_mut(..count)) {
            sort(entries, spare);
        }
        count
    };
    let count = sort_points(sources.positions, Some(sources.masses), entries, spare);
    let massless = sources.masses.len() - count;
    for ((entry, y), m) in entries.iter().take(count).zip(positions.iter_mut()).zip(masses.iter_mut()) {
        let index = entry[1] as usize;
        (*y, *m) = (
            sources.positions.get(index).map_or(T::ZERO, first),
            sources.masses.get(index).copied().unwrap_or(T::ZERO),
        );
    }
    let (positions, masses) = (positions.get(..count).unwrap_or(&[]), masses.get(..count).unwrap_or(&[]));
    // The order of the targets is known already where they are the sources.
    let same = core::ptr::eq(sources.positions, targets) && massless == 0;
    if !same {
        sort_points(targets, None, entries, spare);
    }

    let (weight, moment) = positions.iter().zip(masses).fold((T::ZERO, T::ZERO), |(w, s), (&y, &m)| {
        let share = m.abs();
        (w + share, s + share * y)
    });
    let centre = if weight > T::ZERO && (moment / weight).is_finite() { moment / weight } else { T::ZERO };
    let mut total = Moments::new();
    for (&y, &m) in positions.iter().zip(masses) {
        total.add(degree, y - centre, m);
    }

    // sources further left than the reach, and sources not further right
    let (mut left, mut passed) = (Moments::new(), Moments::new());
    let (mut low, mut high) = (0_usize, 0_usize);
    let source = |k: usize| Some((*positions.get(k)?, *masses.get(k)?));
    let mut near_pairs = 0_u64;
    for (step, entry) in entries.iter().take(targets.len()).enumerate() {
        if step % ASK == 0 && run.should_stop.is_some_and(|stop| stop()) {
            return Err(Error::Stopped);
        }
        let index = entry[1] as usize;
        let Some(x) = targets.get(index).map(first) else { continue };
        while let Some((y, m)) = source(low).filter(|&(y, _)| x - y > far.reach) {
            left.add(degree, y - centre, m);
            low += 1;
        }
        while let Some((y, m)) = source(high).filter(|&(y, _)| y - x <= far.reach) {
            passed.add(degree, y - centre, m);
            high += 1;
        }
        let mut right = Moments::new();
        for ((r, &t), &p) in right.values.iter_mut().zip(&total.values).zip(&passed.values).take(degree + 1) {
            *r = t - p;
        }
        let c = expand(&weights, degree, &left, &right);
        let at = x - centre;
        let (mut u, mut du, mut ddu) = (T::ZERO, T::ZERO, T::ZERO);
        for &c in c.iter().take(degree + 1).rev() {
            // value, first and half the second derivative together
            ddu = ddu * at + du;
            du = du * at + u;
            u = u * at + c;
        }
        ddu += ddu;
        if !singular {
            let near = positions.get(low..high).unwrap_or(&[]).iter().zip(masses.get(low..high).unwrap_or(&[]));
            near_pairs += high.saturating_sub(low) as u64;
            for (&y, &m) in near {
                let offset = x - y;
                let [value, gradient, laplacian] = kernel.pair(offset.abs(), wanted.into());
                u += m * value;
                du += m * gradient * offset;
                ddu += m * laplacian;
            }
        }
        let slot = |output: &mut Option<&mut [T]>, value: T| {
            if let Some(slot) = output.as_mut().and_then(|o| o.get_mut(index)) {
                *slot = value;
            }
        };
        slot(&mut outputs.potential, u);
        slot(&mut outputs.laplacian, ddu);
        if let Some([slot, ..]) = outputs.gradient.as_mut().and_then(|o| o.get_mut(index)).map(|g| g.as_mut_slice()) {
            *slot = du;
        }
    }
    if let Some(counters) = run.counters.as_deref_mut() {
        let count =
            Counters { pairs: near_pairs, near_pairs, massless_sources: massless as u64, ..Counters::default() };
        counters.add(&count);
    }
    Ok(())
}

impl From<Wanted> for [bool; 3] {
    fn from(wanted: Wanted) -> Self {
        [wanted.potential, wanted.gradient, wanted.laplacian]
    }
}

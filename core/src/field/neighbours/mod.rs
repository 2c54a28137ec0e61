//! Sums of a mollifier and of its gradient: over sources within its reach alone. O(n). The mollifier is the Laplacian of the mollified Newtonian kernel, and the
//! kernel of [`super::Density`]. A compact one reaches delta, a Gaussian as far as it is above rounding ([`profile`]).
//!
//! Sources are sorted by the cell of a grid a little wider than the reach; the neighbours of a target lie in runs of three
//! successive cells, found by bisection. No array of cells, so distant particles cost nothing (but see `Grid::new`).
//!
//! Cells are found in units ([`Units`]); distances are taken in units of delta, masses in those of their class, and the sums of the classes meet
//! in true units: a true result in range is computed.

mod profile;

use core::sync::atomic::{AtomicUsize, Ordering};

use crate::error::{Error, Result};
use crate::exec::{Chunks, Run, Statistics, par_chunks};
use crate::field::options::{Accumulation, Options};
use crate::field::pairs::{BLOCK, SHORT_BLOCK, Units};
use crate::field::problem::Sources;
use crate::memory::{Carve, Measure, Space};
use crate::mollifier::{Blob, Mollifier};
use crate::real::{DoubleWord, Real, quotient};
use crate::sort::radix::{Entry, sort};
use profile::{Combination, Gaussians, Profile};

/// Targets of one task.
const TASK: usize = 512;
/// Bits of a cell's index in each of so many dimensions.
const fn bits(dimension: usize) -> u32 {
    match dimension {
        1 => 40,
        2 => 31,
        _ => 21,
    }
}

struct Arrays<'w, T, const D: usize> {
    entries: &'w mut [Entry],
    spare: &'w mut [Entry],
    positions: &'w mut [[T; D]],
    masses: &'w mut [T],
}

fn layout<'w, T: Real, const D: usize>(space: &mut impl Space<'w>, n: usize) -> Result<Arrays<'w, T, D>>
where
    [T; D]: crate::memory::Plain,
{
    Ok(Arrays {
        entries: space.try_array(n)?,
        spare: space.try_array(n)?,
        positions: space.try_array(n)?,
        masses: space.try_array(n)?,
    })
}

/// Bytes of workspace.
pub(super) fn workspace_bytes<T: Real, const D: usize>(n_sources: usize) -> Result<usize> {
    Measure::of(|space| layout::<T, D>(space, n_sources).map(|_| ()))
}

/// The grid: cell of x = 1 + floor((x - least)/size) in each dimension, all in units.
struct Grid<T, const D: usize> {
    units: Units<T>,
    least: [T; D],
    size: T,
    /// Cells in one dimension, at most.
    most: T,
}

impl<T: Real, const D: usize> Grid<T, D> {
    fn new(units: Units<T>, positions: &[[T; D]], delta: T) -> Self {
        let (mut least, mut most) = ([T::INFINITY; D], [-T::INFINITY; D]);
        for x in positions {
            let x = units.point(x);
            for ((least, most), x) in least.iter_mut().zip(&mut most).zip(x) {
                (*least, *most) = (least.min(x), most.max(x));
            }
        }
        let sides = least.iter().zip(&most).filter(|(low, high)| low <= high);
        let extent = sides.fold(T::ZERO, |extent, (&low, &high)| extent.max(high - low));
        // Cells are wider than delta by more than the rounding of an index, u times the number of cells; so there are
        // at most 2^39, 2^30, 2^20 (f64) or 2^12 (f32) of them in each of 1, 2, 3 dimensions, and wider ones where the
        // particles spread further. They are also wider than what underflow takes from a coordinate.
        let most = T::ONE.ldexp(if T::DIGITS > 32 { bits(D) as i32 - 1 } else { 12 });
        let margin = T::ONE + T::from_f64(1.0 / 128.0);
        let size = (delta.ldexp(units.position) * margin).max(extent / most * margin);
        Self { units, least, size: size.max(T::MIN_POSITIVE / T::EPSILON), most: most + T::TWO }
    }

    /// The cell, moved by one so that a neighbour's index is not negative; None where no source is near.
    fn cell(&self, x: &[T; D]) -> Option<[u64; D]> {
        let mut cell = [0; D];
        for ((slot, x), &least) in cell.iter_mut().zip(self.units.point(x)).zip(&self.least) {
            let index = quotient(x - least, self.size).floor() + T::ONE;
            if !(index >= T::ZERO && index <= self.most) {
                return None;
            }
            *slot = index.to_f64() as u64;
        }
        Some(cell)
    }
}

/// A key whose lowest digits are the first dimension's.
fn key<const D: usize>(cell: &[u64; D]) -> u64 {
    cell.iter().rev().fold(0, |key, &index| (key << bits(D)) | index)
}

/// Classes of masses, each with a unit of its own: the exponents of f64 span three times 900, those of f32 three times 100.
const CLASSES: usize = 3;

/// The units of masses.
#[derive(Clone, Copy)]
struct Classes {
    /// Of the largest mass.
    exponent: i32,
    width: i32,
}

impl Classes {
    fn new<T: Real>(largest: T) -> Self {
        Self { exponent: largest.frexp().1, width: if T::DIGITS > 24 { 900 } else { 100 } }
    }

    /// The class of a mass that is not zero.
    fn of<T: Real>(&self, m: T) -> usize {
        let below = self.exponent - m.frexp().1;
        if below < self.width { 0 } else { 1 + usize::from(below >= 2 * self.width) }
    }

    /// A mass in the class's unit is the true one times 2^-this.
    fn unit(&self, class: usize) -> i32 {
        self.exponent - class as i32 * self.width
    }

    /// The sum of the classes' sums, each in its unit, times factor 2^shift.
    fn in_true_units<'a, T: Real>(&self, sums: impl Iterator<Item = &'a Sum<T>>, (factor, shift): (T, i32)) -> T {
        sums.enumerate().fold(T::ZERO, |out, (class, sum)| {
            out + (sum.value() * factor).ldexp(self.unit(class).saturating_add(shift))
        })
    }
}

/// A sum in blocks of terms, so that the error grows with their length and their number, not with the product.
#[derive(Clone, Copy)]
struct Sum<T> {
    total: DoubleWord<T>,
    block: T,
    terms: usize,
}

impl<T: Real> Sum<T> {
    const ZERO: Self = Self { total: DoubleWord::ZERO, block: T::ZERO, terms: 0 };

    #[inline(always)]
    fn add(&mut self, term: T, compensated: bool) {
        self.block += term;
        self.terms += 1;
        if self.terms == if compensated { SHORT_BLOCK } else { BLOCK } {
            if compensated {
                self.total = self.total.plus(self.block);
            } else {
                self.total.hi += self.block;
            }
            (self.block, self.terms) = (T::ZERO, 0);
        }
    }

    fn value(&self) -> T {
        self.total.plus(self.block).hi
    }
}

/// Where the sums go, each `[n_targets]`; `None` is not computed.
pub(super) struct Sums<'a, T, const D: usize> {
    /// `coefficient sum_j m_j psi_delta(x_i - x_j)`.
    pub density: Option<&'a mut [T]>,
    /// Its gradient.
    pub gradient: Option<&'a mut [[T; D]]>,
}

/// By what the sums of a profile are multiplied for densities and for gradients: factor 2^exponent, for delta in units of 2^-shift.
struct Factors<T> {
    density: (T, i32),
    gradient: (T, i32),
}

/// Densities and gradients at a target, by class, and how many pairs were looked at and near.
type SumsAt<T, const D: usize> = ([Sum<T>; CLASSES], [[Sum<T>; D]; CLASSES], [usize; 2]);

/// The sources in the order of their cells.
struct Sorted<'a, T, const D: usize> {
    grid: &'a Grid<T, D>,
    entries: &'a [Entry],
    positions: &'a [[T; D]],
    masses: &'a [T],
    /// Distances times both are in units of delta: two factors, as 1 / delta may not be normal.
    per_delta: [T; 2],
    /// Of the mollifier, in squares of delta.
    end: T,
}

/// A source within reach.
struct NearSource<T, const D: usize> {
    /// Of its mass, which is in the class's unit.
    class: usize,
    mass: T,
    /// Target minus source, in units of delta.
    offset: [T; D],
    /// (r / delta)^2.
    s: T,
}

impl<T: Real, const D: usize> Sorted<'_, T, D> {
    /// Calls `f` with each source within reach of x. Returns how many were looked at and how many were near.
    #[inline(always)]
    fn each_near(&self, x: &[T; D], mut f: impl FnMut(NearSource<T, D>)) -> [usize; 2] {
        let (mut looked, mut found) = (0, 0);
        let Some(cell) = self.grid.cell(x) else { return [0; 2] };
        let [length, per_delta] = self.per_delta;
        each_row(&cell, |first, last| {
            let start = self.entries.partition_point(|e| e[0] < first);
            let sources = self.entries.iter().zip(self.positions).zip(self.masses);
            for ((entry, y), &mass) in sources.skip(start).take_while(|((e, _), _)| e[0] <= last) {
                looked += 1;
                let mut offset = *x;
                offset.iter_mut().zip(y).for_each(|(a, &b)| *a = (*a - b) * length * per_delta);
                let s = offset.iter().fold(T::ZERO, |s, &q| s + q * q);
                if s < self.end {
                    found += 1;
                    f(NearSource { class: entry[1] as usize, mass, offset, s });
                }
            }
        });
        [looked, found]
    }

    /// The sums at x in the units of their classes, of the profile alone, and how many pairs were looked at and near.
    #[inline(always)]
    fn at<const DENSITY: bool, const GRADIENT: bool, P: Profile<T>>(
        &self,
        profile: &P,
        x: &[T; D],
        compensated: bool,
    ) -> SumsAt<T, D> {
        let (mut densities, mut gradients) = ([Sum::ZERO; CLASSES], [[Sum::ZERO; D]; CLASSES]);
        let counts = self.each_near(x, |NearSource { class, mass, offset, s }| {
            if DENSITY && let Some(sum) = densities.get_mut(class) {
                sum.add(mass * profile.density(s), compensated);
            }
            if GRADIENT && let Some(sums) = gradients.get_mut(class) {
                let factor = mass * profile.slope(s);
                sums.iter_mut().zip(offset).for_each(|(sum, q)| sum.add(factor * q, compensated));
            }
        });
        (densities, gradients, counts)
    }
}

/// Overwrites `sums` with those of `coefficient psi_delta`; psi is compact, a combination of such, Gaussian or zero. The caller has
/// checked lengths, values and the workspace's size.
pub(super) fn evaluate<T: Real, const D: usize>(
    (coefficient, blob): (T, &Blob<T, D>),
    options: &Options,
    sources: Sources<'_, T, D>,
    targets: &[[T; D]],
    sums: Sums<'_, T, D>,
    workspace: &mut [u8],
    run: &mut Run<'_>,
) -> Result<()>
where
    [T; D]: crate::memory::Plain,
{
    // In units of a power of two near delta.
    let (fraction, exponent) = blob.delta().frexp();
    let (coefficient, shift) = coefficient.frexp();
    let shift = shift.saturating_sub(exponent.saturating_mul(D as i32));
    // A gradient is slope / r times r: one delta less in the denominator than slope / r has.
    let factors = |density: T, slope: T| Factors {
        density: (coefficient * density, shift),
        gradient: (coefficient * (slope * fraction), shift.saturating_sub(exponent)),
    };
    let call = Call { delta: blob.delta(), options, sources, targets };
    if let Mollifier::Gaussian { order } = blob.mollifier() {
        let per_width = T::ONE / (T::PI.sqrt() * fraction);
        let peak = per_width.powi(D as u32);
        let factors = factors(peak, peak / (fraction * fraction));
        return call.of_profile(&Gaussians::new(D, order), &factors, sums, workspace, run);
    }
    let Some(polynomials) = Blob::<T, D>::new(blob.mollifier(), fraction)?.polynomials_of_part() else {
        // without a mollifier the field is harmonic away from the sources
        sums.density.unwrap_or_default().fill(T::ZERO);
        return Ok(());
    };
    let factors = factors(polynomials.scale, polynomials.hessian_scale);
    if blob.mollifier().radii() > 1 {
        let profile = Combination::new(D, blob.mollifier(), polynomials);
        return call.of_profile(&profile, &factors, sums, workspace, run);
    }
    call.of_profile(&polynomials, &factors, sums, workspace, run)
}

/// What is summed over, and where.
struct Call<'a, T, const D: usize> {
    delta: T,
    options: &'a Options,
    sources: Sources<'a, T, D>,
    targets: &'a [[T; D]],
}

impl<T: Real, const D: usize> Call<'_, T, D>
where
    [T; D]: crate::memory::Plain,
{
    fn of_profile<P: Profile<T>>(
        &self,
        profile: &P,
        factors: &Factors<T>,
        sums: Sums<'_, T, D>,
        workspace: &mut [u8],
        run: &mut Run<'_>,
    ) -> Result<()> {
        let &Self { delta, options, sources, targets } = self;
        let Sums { density, gradient } = sums;
        if density.is_none() && gradient.is_none() {
            return Ok(());
        }
        let arrays = layout::<T, D>(&mut Carve::new(workspace)?, sources.positions.len())?;
        let [coordinate, largest] = sources.largest(1);
        let (end, exponent) = (profile.end(), delta.frexp().1);
        let reach = if end == T::ONE { delta } else { end.sqrt() * delta };
        let grid = Grid::new(Units::new(coordinate.max(reach), largest), sources.positions, reach);
        let classes = Classes::new(largest);
        let mut count = 0;
        for (index, (x, &m)) in sources.positions.iter().zip(sources.masses).enumerate() {
            if m != T::ZERO
                && let (Some(cell), Some(slot)) = (grid.cell(x), arrays.entries.get_mut(count))
            {
                *slot = [key(&cell), index as u64];
                count += 1;
            }
        }
        let massless = sources.masses.len() - count;
        let (Some(entries), Some(spare)) = (arrays.entries.get_mut(..count), arrays.spare.get_mut(..count)) else {
            return Err(Error::WorkspaceTooSmall);
        };
        sort(entries, spare);
        for ((entry, y), m) in entries.iter_mut().zip(arrays.positions.iter_mut()).zip(arrays.masses.iter_mut()) {
            let index = entry[1] as usize;
            *y = sources.positions.get(index).copied().unwrap_or([T::ZERO; D]);
            let mass = sources.masses.get(index).copied().unwrap_or(T::ZERO);
            let class = classes.of(mass);
            *m = mass.ldexp(-classes.unit(class));
            // The index has served.
            entry[1] = class as u64;
        }
        let (entries, positions, masses) = (&*entries, &*arrays.positions, &*arrays.masses);
        let compensated = options.accumulation == Accumulation::Compensated;
        let limit = T::MAX_EXPONENT - 2;
        let length = exponent.saturating_neg().max(-limit).min(limit);
        let (length, per_delta) = (T::ONE.ldexp(length), T::ONE / delta.ldexp(length));
        let sorted = Sorted { grid: &grid, entries, positions, masses, per_delta: [length, per_delta], end };
        let should_stop = run.should_stop;
        let (pairs, near) = (AtomicUsize::new(0), AtomicUsize::new(0));
        let tasks = targets.len().div_ceil(TASK);
        let outputs = (density.map(|to| Chunks::new(to, TASK)), gradient.map(|to| Chunks::new(to, TASK)));
        par_chunks(run.executor, tasks, outputs, (), &|task, (mut density, mut gradient), ()| {
            if should_stop.is_some_and(|stop| stop()) {
                return Err(Error::Stopped);
            }
            let (mut looked, mut found) = (0, 0);
            for (k, x) in targets.iter().skip(task.saturating_mul(TASK)).take(TASK).enumerate() {
                let (densities, gradients, counts) = match (&density, &gradient) {
                    (Some(_), None) => sorted.at::<true, false, _>(profile, x, compensated),
                    (None, _) => sorted.at::<false, true, _>(profile, x, compensated),
                    (Some(_), Some(_)) => sorted.at::<true, true, _>(profile, x, compensated),
                };
                looked += counts[0];
                found += counts[1];
                if let Some(out) = density.as_mut().and_then(|to| to.get_mut(k)) {
                    *out = classes.in_true_units(densities.iter(), factors.density);
                }
                if let Some(out) = gradient.as_mut().and_then(|to| to.get_mut(k)) {
                    for (d, out) in out.iter_mut().enumerate() {
                        *out = classes.in_true_units(gradients.iter().filter_map(|sums| sums.get(d)), factors.gradient);
                    }
                }
            }
            pairs.fetch_add(looked, Ordering::Relaxed);
            near.fetch_add(found, Ordering::Relaxed);
            Ok(())
        })?;
        if let Some(counters) = run.counters.as_deref_mut() {
            counters.add(&Statistics {
                pairs: pairs.load(Ordering::Relaxed) as u64,
                near_pairs: near.load(Ordering::Relaxed) as u64,
                massless_sources: massless as u64,
                ..Statistics::default()
            });
        }
        Ok(())
    }
}

/// The key ranges of the cells next to this one and itself: three successive cells in each row.
fn each_row<const D: usize>(cell: &[u64; D], mut f: impl FnMut(u64, u64)) {
    let rows = 3_usize.pow((D as u32).saturating_sub(1));
    for row in 0..rows {
        let (mut first, mut left, mut outside) = (*cell, row, false);
        for index in first.iter_mut().skip(1) {
            // one of -1, 0, 1
            match (*index + left as u64 % 3).checked_sub(1) {
                Some(moved) => *index = moved,
                None => outside = true,
            }
            left /= 3;
        }
        if outside {
            continue;
        }
        let mut last = first;
        if let (Some(a), Some(b)) = (first.first_mut(), last.first_mut()) {
            *a = a.saturating_sub(1);
            *b += 1;
        }
        f(key(&first), key(&last));
    }
}

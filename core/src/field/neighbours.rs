//! The Laplacian of the mollified Newtonian kernel is the mollifier itself: a sum over sources closer than delta. O(n).
//!
//! Sources are sorted by the cell of a grid a little wider than delta; the neighbours of a target lie in runs of three
//! successive cells, found by bisection. No array of cells, so distant particles cost nothing (but see `Grid::new`).
//!
//! Cells are found in units ([`Units`]); distances are taken in units of delta, masses in those of their class, and the sums of the classes meet
//! in true units: a true result in range is computed.

use core::sync::atomic::{AtomicUsize, Ordering};

use super::options::{Accumulation, Options};
use super::pairs::{BLOCK, SHORT_BLOCK, Units};
use super::problem::{Outputs, Sources};
use crate::error::{Error, Result};
use crate::exec::{Chunks, Run, Statistics, par_chunks};
use crate::memory::{Carve, Measure, Space};
use crate::mollifier::Blob;
use crate::real::{DoubleWord, Real, quotient};
use crate::sort::radix::{Entry, sort};

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

/// Overwrites `outputs.laplacian` with `coefficient sum_j m_j psi_delta(x_i - x_j)`; psi is compact or zero. The caller has
/// checked lengths, values and the workspace's size, and that no other output is wanted.
pub(super) fn evaluate<T: Real, const D: usize>(
    (coefficient, blob): (T, &Blob<T, D>),
    options: &Options,
    sources: Sources<'_, T, D>,
    targets: &[[T; D]],
    outputs: Outputs<'_, T, D>,
    workspace: &mut [u8],
    run: &mut Run<'_>,
) -> Result<()>
where
    [T; D]: crate::memory::Plain,
{
    let Some(laplacian) = outputs.laplacian else { return Ok(()) };
    // In units of a power of two near delta.
    let (fraction, exponent) = blob.delta().frexp();
    let Some(polynomials) = Blob::<T, D>::new(blob.mollifier(), fraction)?.polynomials() else {
        // without a mollifier the field is harmonic away from the sources
        laplacian.fill(T::ZERO);
        return Ok(());
    };
    let arrays = layout::<T, D>(&mut Carve::new(workspace)?, sources.positions.len())?;
    let [coordinate, largest] = sources.largest(1);
    let grid = Grid::new(Units::new(coordinate.max(blob.delta()), largest), sources.positions, blob.delta());
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
    // Distances in units of delta: two factors, as 1 / delta may not be normal.
    let limit = T::MAX_EXPONENT - 2;
    let length = exponent.saturating_neg().max(-limit).min(limit);
    let (length, per_delta) = (T::ONE.ldexp(length), T::ONE / blob.delta().ldexp(length));
    let (coefficient, shift) = coefficient.frexp();
    let factor = coefficient * polynomials.scale;
    let shift = shift.saturating_sub(exponent.saturating_mul(D as i32));
    let should_stop = run.should_stop;
    let (pairs, near) = (AtomicUsize::new(0), AtomicUsize::new(0));
    let tasks = targets.len().div_ceil(TASK);
    par_chunks(run.executor, tasks, Chunks::new(laplacian, TASK), (), &|task, out: &mut [T], ()| {
        if should_stop.is_some_and(|stop| stop()) {
            return Err(Error::Stopped);
        }
        let (mut looked, mut found) = (0, 0);
        for (x, out) in targets.iter().skip(task.saturating_mul(TASK)).zip(out) {
            let mut sums = [Sum::<T>::ZERO; CLASSES];
            if let Some(cell) = grid.cell(x) {
                each_row(&cell, |first, last| {
                    let start = entries.partition_point(|e| e[0] < first);
                    let run =
                        entries.iter().zip(positions).zip(masses).skip(start).take_while(|((e, _), _)| e[0] <= last);
                    for ((entry, y), &m) in run {
                        looked += 1;
                        let s = x.iter().zip(y).fold(T::ZERO, |s, (&a, &b)| {
                            let q = (a - b) * length * per_delta;
                            s + q * q
                        });
                        let t = T::ONE - s;
                        if t > T::ZERO {
                            found += 1;
                            if let Some(sum) = sums.get_mut(entry[1] as usize) {
                                sum.add(m * polynomials.density.at(t), compensated);
                            }
                        }
                    }
                });
            }
            *out = sums.iter().enumerate().fold(T::ZERO, |out, (class, sum)| {
                out + (sum.value() * factor).ldexp(classes.unit(class).saturating_add(shift))
            });
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

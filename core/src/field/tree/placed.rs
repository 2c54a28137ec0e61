//! Sources and targets in the order of the cells.

use super::cells::{Cells, Limits, Words, index};
use super::settings::Settings;
use crate::checked::Present;
use crate::error::{Error, Result};
use crate::field::pairs::{self, ErasedCall, Packed, Units, largest};
use crate::memory::{Carve, Space};
use crate::real::Real;
use crate::sort::words::BUCKETS;

/// Room to place them.
pub(super) struct Room<'w, T> {
    /// The sources in their order, as the engine for pairs lays them out.
    packed: &'w mut [u8],
    /// Of vector strengths the components, one after the other, in the order of the sources.
    components: &'w mut [T],
    /// Keys and indices.
    words: [&'w mut [u64]; 2],
    spare: &'w mut [u64],
    counts: &'w mut [u32],
    cells: Cells<'w, T>,
    /// The targets in their order, and where each result comes from.
    points: &'w mut [T],
    ranks: &'w mut [u32],
}

/// Sources and targets in their order.
pub(super) struct Placed<'w, T: Real> {
    pub cells: Cells<'w, T>,
    pub units: Units<T>,
    /// Sources with mass.
    pub count: usize,
    /// The targets, in true units, and where each result comes from.
    pub points: &'w [T],
    pub ranks: &'w [u32],
    /// The engine's sources.
    pub packed: &'w mut [u8],
    components: &'w mut [T],
    n_sources: usize,
    extras: [bool; 2],
    pub dimension: usize,
}

/// Bytes of the engine's sources.
pub(super) fn packed_bytes<T: Real>(dimension: usize, n: usize, extras: [bool; 2]) -> Result<usize> {
    match dimension {
        1 => pairs::workspace_bytes::<T, 1>(n, extras),
        2 => pairs::workspace_bytes::<T, 2>(n, extras),
        _ => pairs::workspace_bytes::<T, 3>(n, extras),
    }
}

/// The engine's sources: positions, masses, vector strengths, origins.
type Sources<'w, T> = (&'w mut [T], &'w mut [T], &'w mut [T], &'w mut [u32]);

/// Opens the engine's sources.
fn open_packed<T: Real>(dimension: usize, packed: &mut [u8], n: usize, extras: [bool; 2]) -> Result<Sources<'_, T>> {
    fn of<T: Real, const D: usize>(packed: &mut [u8], n: usize, extras: [bool; 2]) -> Result<Sources<'_, T>> {
        let packed = Packed::<T, D>::layout(&mut Carve::reopen(packed)?, n, extras)?;
        let strengths = packed.strengths.as_flattened_mut();
        Ok((packed.positions.as_flattened_mut(), packed.masses, strengths, packed.origins))
    }
    match dimension {
        1 => of::<T, 1>(packed, n, extras),
        2 => of::<T, 2>(packed, n, extras),
        _ => of::<T, 3>(packed, n, extras),
    }
}

/// A point in three coordinates.
pub(super) fn spatial<T: Real>(point: &[T], factor: T) -> [T; 3] {
    let mut x = [T::ZERO; 3];
    x.iter_mut().zip(point).for_each(|(to, &x)| *to = x * factor);
    x
}

impl<'w, T: Real> Room<'w, T> {
    /// The layout, for so many sources and targets, and whether sources have core radii and vector strengths.
    pub fn layout(
        space: &mut impl Space<'w>,
        settings: Settings,
        (sources, targets): (usize, usize),
        extras: [bool; 2],
    ) -> Result<Self> {
        let d = settings.dimension;
        let most = sources.max(targets);
        let times = |a: usize, b: usize| a.checked_mul(b).ok_or(Error::TooLarge);
        Ok(Self {
            packed: space.try_array(packed_bytes::<T>(d, sources, extras)?)?,
            components: space.try_array(if extras[1] { times(sources, 3)? } else { 0 })?,
            words: [space.try_array(sources)?, space.try_array(targets)?],
            spare: space.try_array(most)?,
            counts: space.try_array(BUCKETS)?,
            cells: Cells::layout(space, d, settings.cells(most)?)?,
            points: space.try_array(times(targets, d)?)?,
            ranks: space.try_array(targets)?,
        })
    }

    /// Sorts sources and targets into cells no narrower than `reach` and the largest core.
    pub fn place(self, call: &ErasedCall<'_, T>, settings: Settings, reach: T) -> Result<Placed<'w, T>> {
        let Self { packed, components, words, spare, counts, mut cells, points, ranks } = self;
        let ErasedCall { dimension: d, positions, masses, strengths, targets, radii, .. } = *call;
        let (n_sources, n_targets) = (positions.len() / d.max(1), targets.len() / d.max(1));
        let extras = [radii.is_some(), strengths.is_some()];
        let length = largest(largest(T::ZERO, positions), targets).max(reach);
        let units = Units::new(length, largest(T::ZERO, strengths.unwrap_or(masses)));
        let unit = T::ONE.ldexp(units.position);
        let [source_words, target_words] = words;
        let mut count = 0;
        let per_source = if strengths.is_some() { d.max(1) } else { 1 };
        let of_sources = strengths.unwrap_or(masses);
        for (source, mass) in of_sources.chunks(per_source.max(1)).enumerate() {
            if mass.iter().any(|&m| m != T::ZERO) {
                *source_words.get_mut(count).present()? = source as u64;
                count += 1;
            }
        }
        let source_words = source_words.get_mut(..count).present()?;
        // Targets that are the sources are in the same cells in the same order.
        let same = core::ptr::eq(positions, targets) && count == n_targets;
        let target_words = target_words.get_mut(..if same { 0 } else { n_targets }).present()?;
        target_words.iter_mut().enumerate().for_each(|(k, word)| *word = k as u64);
        let of =
            |points: &[T], k: usize| spatial(points.get(k * d..).and_then(|rest| rest.get(..d)).present_or(&[]), unit);
        let (source_point, target_point) = (|k: usize| of(positions, k), |k: usize| of(targets, k));
        let words = Words {
            sorts: [&mut *source_words, &mut *target_words],
            spare,
            counts: counts.first_chunk_mut().present()?,
        };
        let width = reach.ldexp(units.position);
        let limits = Limits { leaf: settings.leaf, width, mean: settings.mean, aligned: false };
        let leaf = cells.divide(words, limits, &[&source_point, &target_point])?;
        cells.find_adjacent()?;
        if same {
            cells.share();
        }
        let target_words = if same { &*source_words } else { &*target_words };
        let (in_order, heavy, vectors, origins) = open_packed::<T>(d, packed, n_sources, extras)?;
        let in_order = in_order.get_mut(..count * d).present()?;
        let of_mass = T::ONE.ldexp(units.mass);
        for ((to, origin), &word) in in_order.chunks_mut(d.max(1)).zip(origins).zip(&*source_words) {
            let source = index(word);
            let from = positions.get(source * d..).and_then(|rest| rest.get(..d)).present()?;
            to.iter_mut().zip(from).for_each(|(to, &x)| *to = x * unit);
            *origin = source as u32;
        }
        // The masses, or the components of the strengths one after the other.
        let loads = if strengths.is_some() { &mut *components } else { &mut *heavy };
        let loads = loads.get_mut(..count * per_source).present()?;
        for (component, loads) in loads.chunks_mut(count.max(1)).enumerate() {
            for (to, &word) in loads.iter_mut().zip(&*source_words) {
                *to = of_sources.get(index(word) * per_source + component).copied().present()? * of_mass;
            }
        }
        if radii.is_none() {
            cells.merge(leaf, (&mut *loads, count), &|k| {
                spatial(in_order.get(k * d..).and_then(|rest| rest.get(..d)).unwrap_or_default(), T::ONE)
            });
        }
        if strengths.is_some() {
            for (component, loads) in loads.chunks(count.max(1)).enumerate() {
                let to = vectors.iter_mut().skip(component).step_by(per_source.max(1));
                to.zip(loads).for_each(|(to, &x)| *to = x);
            }
            heavy.get_mut(..count).present()?.fill(T::ONE);
        }
        for ((rank, to), &word) in (0..).zip(points.chunks_mut(d.max(1))).zip(target_words) {
            let target = index(word);
            let from = targets.get(target * d..).and_then(|rest| rest.get(..d)).present()?;
            to.iter_mut().zip(from).for_each(|(to, &x)| *to = x);
            *ranks.get_mut(target).present()? = rank;
        }
        Ok(Placed { cells, units, count, points, ranks, packed, components, n_sources, extras, dimension: d })
    }
}

impl<T: Real> Placed<'_, T> {
    /// The cells, and the sources in their order, in units: positions, and masses, or the components of strengths one after the other.
    pub fn parts(&mut self) -> Result<(&Cells<'_, T>, &[T], &[T])> {
        let (in_order, heavy, ..) = open_packed::<T>(self.dimension, self.packed, self.n_sources, self.extras)?;
        let loads = if self.extras[1] { &*self.components } else { &*heavy };
        let numbers = self.count * if self.extras[1] { 3 } else { 1 };
        Ok((&self.cells, in_order.get(..self.count * self.dimension).present()?, loads.get(..numbers).present()?))
    }
}

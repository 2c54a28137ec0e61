//! Merging: which clusters collapsed, in the order of their lowest labels, into the host's event buffer.

use super::collision::{Criterion, Units};
use super::search::{self, particle};
use super::state::{Counters, Event, Events, Report, State};
use crate::build;
use crate::checked::Present;
use crate::error::{Error, Result};
use crate::memory::Space;
use crate::real::{DoubleWord, Real, quotient};
use crate::sort::words as sort;

/// The collapsed clusters of a step: kept from the decision to the last merge.
#[derive(Debug)]
pub struct Queue<'w, T> {
    /// Where the cluster's members begin, in the high half, and how many they are: in the order of their lowest labels.
    ranges: &'w mut [u64],
    /// Lowest label of the cluster whose members begin at twice this place or one below.
    lowest: &'w mut [u64],
    /// As these: time after the step's start, and index.
    values: &'w mut [[T; 2]],
    /// Magic, step, count, length of the queue, merges done, clusters decided.
    head: &'w mut [u64],
}

const MAGIC: u64 = 0x6D6F_6C6C_6973_4D71;

impl<'w, T: Real> Queue<'w, T> {
    /// Lays out the queue of `n` particles.
    pub fn layout(space: &mut impl Space<'w>, n: usize) -> Self {
        let half = n / 2;
        Self { ranges: space.array(half), lowest: space.array(half), values: space.array(half), head: space.array(6) }
    }

    /// Invalidates a queue left in the memory.
    pub fn clear(&mut self) {
        self.head.fill(0);
    }

    /// Decides every cluster that the search found, by masses, or by weights if these are given in their place: the increments are those of the particles' motion from `positions` in a time of `dt`.
    pub fn decide(
        &mut self,
        criterion: &Criterion<T>,
        found: &mut search::Scratch<'_, T>,
        (positions, masses, labels): (&[[T; 2]], &[T], &[u64]),
        (increments, dt): (&[[T; 2]], T),
        counters: &Counters,
    ) {
        let Units { mass: unit, length: scale, time } = criterion.units;
        // Another unit of time, of an even exponent, in which the increments' squares stay in range.
        let half = dt.frexp().1 >> 1;
        let (root, step) = (T::ONE.ldexp(-half), dt.ldexp(-2 * half));
        let mut length = 0;
        for cluster in found.clusters() {
            // (3.14): dW~ = sum sqrt(m) (X - c) . dW / sqrt(M Y)
            let mut sum = T::ZERO;
            let mut lowest = u64::MAX;
            for k in found.members(cluster.first, cluster.count) {
                let (Some(x), Some(&m), Some(&label), Some(w)) =
                    (positions.get(k), masses.get(k), labels.get(k), increments.get(k))
                else {
                    continue;
                };
                let [cx, cy] = cluster.centre;
                let away = (x[0] * scale - cx) * (w[0] * root) + (x[1] * scale - cy) * (w[1] * root);
                sum += (m * unit).sqrt() * away;
                lowest = lowest.min(label);
            }
            let norm = (cluster.group.mass * cluster.moment * step).sqrt();
            let z = if norm > T::ZERO { sum / norm } else { T::ZERO };
            let Some(tau) = criterion.time(&cluster.group, cluster.moment, z) else { continue };
            let tau = tau.ldexp(time).min(dt);
            // Clusters hold at least two members and do not overlap, so first / 2 is a place of its own.
            let place = cluster.first / 2;
            if let (Some(range), Some(label), Some(value)) =
                (self.ranges.get_mut(length), self.lowest.get_mut(place), self.values.get_mut(place))
            {
                *range = (cluster.first as u64) << 32 | cluster.count as u64;
                *label = lowest;
                *value = [tau, criterion.constants.index(&cluster.group)];
                length += 1;
            }
        }
        let lowest = &*self.lowest;
        if let Some(ranges) = self.ranges.get_mut(..length) {
            sort::by_key(ranges, &|range| lowest.get((range >> 33) as usize).copied().unwrap_or(u64::MAX));
        }
        if let Some(head) = self.head.first_chunk_mut() {
            *head = [MAGIC, counters.step, counters.count, length as u64, 0, found.len() as u64];
        }
    }

    /// How many clusters were decided.
    pub fn clusters(&self) -> usize {
        self.head.last().map_or(0, |&clusters| clusters as usize)
    }

    /// Merges left to do.
    ///
    /// # Errors
    /// [`Error::NotPrepared`]: the memory holds no queue of this step of this run.
    pub fn left(&self, counters: &Counters) -> Result<u64> {
        match *self.head {
            [MAGIC, step, count, length, done, _] if step == counters.step && count == counters.count => {
                Ok(length - done.min(length))
            }
            _ => Err(Error::NotPrepared),
        }
    }

    /// Does the merges that are left, in order. Absorbed particles keep their places with mass zero until [`compact`].
    ///
    /// # Errors
    /// [`Error::EventsFull`]: stopped before a merge that has no room; it can be called again.
    pub fn run(
        &mut self,
        state: &mut State<'_, T>,
        found: &mut search::Scratch<'_, T>,
        events: &mut Events<'_>,
        counters: &mut Counters,
        report: &mut Option<&mut Report>,
    ) -> Result<()> {
        let left = self.left(counters)?;
        let [_, _, _, length, done, _] = &mut *self.head else { return Err(Error::NotPrepared) };
        counters.pending = left;
        for &range in self.ranges.iter().take(*length as usize).skip(*done as usize) {
            let (first, count) = ((range >> 32) as usize, (range & 0xFFFF_FFFF) as usize);
            let [tau, index] = self.values.get(first / 2).copied().present()?;
            let room = events.labels.get_mut(*events.labels_written..).present()?;
            let slot = events.events.get_mut(*events.written);
            let (Some(slot), Some(absorbed)) = (slot, room.get_mut(..count.saturating_sub(1))) else {
                return Err(Error::EventsFull);
            };
            let members = found.members_mut(first, count);
            let Some((label, mass)) = merge(state, members, absorbed) else { return Err(Error::NotPrepared) };
            *slot = Event {
                time: tau.add_to(counters.time),
                label,
                mass: mass.to_f64(),
                index: index.to_f64(),
                first: *events.labels_written as u64,
                absorbed: absorbed.len() as u64,
            };
            *events.labels_written += absorbed.len();
            *events.written += 1;
            *done += 1;
            counters.pending = length.saturating_sub(*done);
            Report { merges: 1, absorbed: absorbed.len() as u64, ..Report::default() }.add_to(report);
        }
        Ok(())
    }
}

/// Merges the members (indices in the low half of the words) into the one of lowest label, at the centre of mass, or of the weights; writes the other labels.
///
/// Mass, weight and first moments are running sums of two numbers (Joldes, Muller & Popescu 2017, algorithm 4): for n particles the mass is the exact
/// sum to a relative `u + 2 n u^2`, that is rounded once for any n below 1 / u.
fn merge<T: Real>(state: &mut State<'_, T>, members: &mut [u64], absorbed: &mut [u64]) -> Option<(u64, T)> {
    let labels = &*state.labels;
    sort::by_key(members, &|word| labels.get(particle(word)).copied().unwrap_or(u64::MAX));
    let (&kept, others) = members.split_first()?;
    let kept = particle(kept);
    let label = *labels.get(kept)?;
    for (&word, to) in others.iter().zip(absorbed) {
        *to = *labels.get(particle(word))?;
    }
    let mass = sum(state.masses, kept, others)?;
    let centre = match &mut state.weights {
        Some(weights) if build::WEIGHTS => {
            let weight = sum(weights, kept, others)?;
            let centre = centre_of(state.positions, weights, kept, others, weight)?;
            gather(weights, kept, others, weight)?;
            centre
        }
        _ => centre_of(state.positions, state.masses, kept, others, mass)?,
    };
    *state.positions.get_mut(kept)? = centre;
    gather(state.masses, kept, others, mass)?;
    Some((label, mass))
}

/// The sum over a particle and others.
fn sum<T: Real>(column: &[T], kept: usize, others: &[u64]) -> Option<T> {
    let mut sum = DoubleWord::from(*column.get(kept)?);
    for &word in others {
        sum = sum.plus(*column.get(particle(word))?);
    }
    Some(sum.hi)
}

/// The centre of a particle and others, whose masses or weights these are.
///
/// First moments are about the kept particle: of halves of the differences, and of masses in units of their sum, so that no product and no
/// difference overflows.
fn centre_of<T: Real>(positions: &[[T; 2]], masses: &[T], kept: usize, others: &[u64], total: T) -> Option<[T; 2]> {
    let start = *positions.get(kept)?;
    let (whole, unit) = total.frexp();
    let [mut first, mut second] = [DoubleWord::ZERO; 2];
    for &word in others {
        let k = particle(word);
        let (x, share) = (*positions.get(k)?, masses.get(k)?.ldexp(1 - unit));
        first = first.plus(share * (T::HALF * x[0] - T::HALF * start[0]));
        second = second.plus(share * (T::HALF * x[1] - T::HALF * start[1]));
    }
    Some([start[0] + quotient(first.hi, whole), start[1] + quotient(second.hi, whole)])
}

/// One particle gets the total, the others nothing.
fn gather<T: Real>(column: &mut [T], kept: usize, others: &[u64], total: T) -> Option<()> {
    for &word in others {
        *column.get_mut(particle(word))? = T::ZERO;
    }
    *column.get_mut(kept)? = total;
    Some(())
}

/// Removes particles of mass zero; the others keep their order. Returns how many are left.
pub fn compact<T: Real>(state: &mut State<'_, T>, count: usize) -> usize {
    let alive = |masses: &[T], k: usize| masses.get(k).is_some_and(|&m| m > T::ZERO);
    let Some(mut to) = (0..count).find(|&k| !alive(state.masses, k)) else { return count };
    for from in to + 1..count {
        if !alive(state.masses, from) {
            continue;
        }
        shift(state.positions, from, to);
        shift(state.masses, from, to);
        shift(state.labels, from, to);
        if build::WEIGHTS
            && let Some(weights) = &mut state.weights
        {
            shift(weights, from, to);
        }
        if let Some(species) = &mut state.species {
            shift(species, from, to);
        }
        to += 1;
    }
    to
}

fn shift<X: Copy>(slice: &mut [X], from: usize, to: usize) {
    if let Some(&x) = slice.get(from) {
        slice.get_mut(to).into_iter().for_each(|slot| *slot = x);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pks::testing::Uniform;
    use std::vec::Vec;

    fn merged<T: Real>() {
        const N: usize = 1 << 20;
        let mut numbers = Uniform(17);
        // Whole numbers up to 2^10 and 2^11, so that products and sums are exact in whole numbers.
        let whole: Vec<[i64; 3]> =
            (0..N).map(|_| [0, 1, 2].map(|k| (numbers.next() * [1024.0, 1024.0, 2048.0][k]) as i64 + 1)).collect();
        let mut positions: Vec<[T; 2]> = whole.iter().map(|w| [T::from_i64(w[0]), T::from_i64(-w[1])]).collect();
        let mut masses: Vec<T> = whole.iter().map(|w| T::from_i64(w[2])).collect();
        let mut labels: Vec<u64> = (0..N as u64).collect();
        let mut words = labels.clone();
        let mut absorbed = std::vec![0; N - 1];
        let state = &mut State {
            positions: &mut positions,
            masses: &mut masses,
            labels: &mut labels,
            species: None,
            weights: None,
        };
        let (label, mass) = merge(state, &mut words, &mut absorbed).unwrap();
        assert_eq!((label, absorbed[0], absorbed[N - 2]), (0, 1, N as u64 - 1));
        // All sums are below 2^53.
        let sum = |of: &dyn Fn(&[i64; 3]) -> i64| whole.iter().map(of).sum::<i64>() as f64;
        let exact = sum(&|w| w[2]);
        let u = 0.5 * T::EPSILON.to_f64();
        // One rounding, and 2 n u^2 from the sum of two numbers.
        let slack = 2.0 * N as f64 * u * u;
        assert!((mass.to_f64() - exact).abs() <= (u + slack) * exact, "{mass} {exact}");
        for (k, sign) in [1.0, -1.0].into_iter().enumerate() {
            let centre = sign * sum(&|w| w[2] * w[k]) / exact;
            // The sum's rounding, those of mass, quotient and addition; the sum's errors are relative to that of |m dx| <= 1024 M.
            let bound = (4.0 * u + slack) * 1024.0;
            assert!((positions[0][k].to_f64() - centre).abs() <= bound, "{k}: {} {centre}", positions[0][k]);
        }
    }

    #[test]
    fn products_of_mass_and_distance_may_be_out_of_range() {
        let mut positions = [[-3e38_f32, 1.0], [3e38, 1.0], [3e38, 5.0]];
        let (mut masses, mut labels, mut absorbed) = ([1e30_f32, 5e29, 5e29], [4, 9, 11], [0; 2]);
        let state = &mut State {
            positions: &mut positions,
            masses: &mut masses,
            labels: &mut labels,
            species: None,
            weights: None,
        };
        assert_eq!(merge(state, &mut [0, 1, 2], &mut absorbed), Some((4, 2e30)));
        assert!((positions[0][0] / 3e38).abs() < 1e-6 && (positions[0][1] - 2.0).abs() < 1e-6, "{:?}", positions[0]);
        let mut positions = [[1.0_f64, 1.0], [1e-200, -1e-200]];
        let (mut masses, mut labels, mut absorbed) = ([1e-300, 3e-300], [0, 1], [0]);
        let state = &mut State {
            positions: &mut positions,
            masses: &mut masses,
            labels: &mut labels,
            species: None,
            weights: None,
        };
        merge(state, &mut [0, 1], &mut absorbed).unwrap();
        assert_eq!(positions[0], [0.25, 0.25]);
    }

    #[test]
    fn a_million_masses_are_rounded_once() {
        merged::<f32>();
        merged::<f64>();
    }
}

//! What every rank knows of the particles of all ranks: those that may be part of a cluster.

use super::{Particles, Scratch};
use crate::build;
use crate::checked::Present;
use crate::error::Result;
use crate::exec::{Ranks, Reduction};
use crate::memory::Space;
use crate::real::Real;

/// Words for each particle that are exchanged at a time, at most.
const WORDS: usize = 5;
/// Words that a rank tells of itself, at most.
pub const WORDS_OF_RANK: usize = 11;
/// Instead of an index: the particle is another rank's.
const ELSEWHERE: u32 = u32::MAX;

/// Where a particle has moved to, its Wiener increment, its label.
pub type Moved<T> = ([T; 2], [T; 2], u64);

/// Which of all particles are a rank's: they are numbered in the order of the ranks, and of each rank's arrays.
#[derive(Clone, Copy, Debug, Default)]
pub struct Part {
    /// The number of its first.
    pub first: usize,
    /// How many it has.
    pub own: usize,
    /// How many all ranks have.
    pub all: usize,
}

impl Part {
    /// The index on this rank of a particle with this number, if it is here.
    pub fn index(self, number: u32) -> Option<usize> {
        (number as usize).checked_sub(self.first).filter(|&i| i < self.own)
    }
}

/// Particles that all ranks know, in arrays with room for all. Empty without ranks.
#[derive(Debug)]
pub struct Shared<'w, T> {
    /// How many are known.
    pub count: usize,
    /// Their numbers.
    pub numbers: &'w mut [u32],
    /// Where they are at the start of the step.
    pub positions: &'w mut [[T; 2]],
    /// Their masses; after merging those they then have.
    pub masses: &'w mut [T],
    /// Of particles in clusters: where they have moved to; after merging where they then are.
    pub moved: &'w mut [[T; 2]],
    /// Of particles in clusters.
    pub increments: &'w mut [[T; 2]],
    /// Of particles in clusters.
    pub labels: &'w mut [u64],
    /// What is exchanged.
    pub words: &'w mut [u64],
    /// Loads of the search's buckets.
    pub loads: &'w mut [u64],
    /// Of each rank how many particles it has in each bucket that this one looks at.
    pub table: &'w mut [u64],
    /// Where what is sent to each rank begins, and the like.
    pub starts: &'w mut [usize],
    /// Which of the occupied buckets are known as a whole.
    pub buckets: &'w mut [u8],
}

impl<'w, T: Real> Shared<'w, T> {
    /// Lays out the arrays for `all` particles on so many ranks, with so many loads and rows of the table.
    pub fn layout(space: &mut impl Space<'w>, all: usize, ranks: usize, (loads, row): (usize, usize)) -> Self {
        if !build::RANKS || ranks <= 1 {
            return Self {
                numbers: &mut [],
                positions: &mut [],
                masses: &mut [],
                moved: &mut [],
                increments: &mut [],
                labels: &mut [],
                words: &mut [],
                loads: &mut [],
                table: &mut [],
                starts: &mut [],
                buckets: &mut [],
                count: 0,
            };
        }
        Self {
            numbers: space.array(all),
            positions: space.array(all),
            masses: space.array(all),
            moved: space.array(all),
            increments: space.array(all),
            labels: space.array(all),
            words: space.array(WORDS.saturating_mul(all).max(WORDS_OF_RANK * ranks)),
            loads: space.array(loads),
            table: space.array(row.saturating_mul(ranks)),
            starts: space.array(4 * (ranks + 1)),
            buckets: space.array(row),
            count: 0,
        }
    }

    /// All particles become known.
    ///
    /// # Errors
    /// The communicator's.
    pub fn take_all(&mut self, ranks: &Ranks<'_>, part: Part, particles: &Particles<'_, T>) -> Result<()> {
        for (i, number) in self.numbers.iter_mut().enumerate() {
            *number = i as u32;
        }
        self.count = 0;
        self.fill(ranks, part, part.all, 0, particles)
    }

    /// So many more are known, whose numbers stand behind the others': their positions and masses. The words before `after` stay.
    ///
    /// # Errors
    /// The communicator's.
    pub fn fill(
        &mut self,
        ranks: &Ranks<'_>,
        part: Part,
        count: usize,
        after: usize,
        particles: &Particles<'_, T>,
    ) -> Result<()> {
        let words = self.words.get_mut(after..after + 3 * count).present()?;
        words.fill(0);
        let (words, _) = words.as_chunks_mut::<3>();
        let known = self.count;
        let numbers = self.numbers.iter().skip(known);
        for (to, &number) in words.iter_mut().zip(numbers) {
            if let Some(i) = part.index(number) {
                let (&[x, y], &m) = (particles.positions.get(i).present()?, particles.masses.get(i).present()?);
                *to = [bits(x), bits(y), bits(m)];
            }
        }
        ranks.reduce(Reduction::Sum, words.as_flattened_mut())?;
        let (positions, masses) = (self.positions.iter_mut().skip(known), self.masses.iter_mut().skip(known));
        for ((&[x, y, m], to), mass) in words.iter().zip(positions).zip(masses) {
            (*to, *mass) = ([number(x), number(y)], number(m));
        }
        self.count += count;
        Ok(())
    }

    /// Of the particles in the clusters labels and what has become of them in the motion: `own` tells it by this rank's index. Numbers become these indices,
    /// or [`ELSEWHERE`].
    ///
    /// # Errors
    /// The communicator's.
    pub fn fill_moved(
        &mut self,
        ranks: &Ranks<'_>,
        part: Part,
        found: &Scratch<'_, T>,
        own: &dyn Fn(usize) -> Result<Moved<T>>,
    ) -> Result<()> {
        let count = found.clusters().map(|cluster| cluster.count).sum::<usize>();
        let words = self.words.get_mut(..WORDS * count).present()?;
        words.fill(0);
        let (words, _) = words.as_chunks_mut::<WORDS>();
        for (to, place) in words.iter_mut().zip(places(found)) {
            let number = self.numbers.get_mut(place).present()?;
            let index = part.index(*number);
            *number = index.map_or(ELSEWHERE, |i| i as u32);
            if let Some(i) = index {
                let ([x, y], [v, w], label) = own(i)?;
                *to = [bits(x), bits(y), bits(v), bits(w), label];
            }
        }
        ranks.reduce(Reduction::Sum, words.as_flattened_mut())?;
        for (&[x, y, v, w, label], place) in words.iter().zip(places(found)) {
            *self.moved.get_mut(place).present()? = [number(x), number(y)];
            *self.increments.get_mut(place).present()? = [number(v), number(w)];
            *self.labels.get_mut(place).present()? = label;
        }
        Ok(())
    }

    /// Writes what merging made of the particles in the clusters into the arrays of this rank.
    pub fn give_back(&self, found: &Scratch<'_, T>, positions: &mut [[T; 2]], masses: &mut [T]) {
        for place in places(found) {
            let own = self.numbers.get(place).filter(|&&i| i != ELSEWHERE).map(|&i| i as usize);
            let Some(i) = own else { continue };
            if let (Some(x), Some(to)) = (self.moved.get(place), positions.get_mut(i)) {
                *to = *x;
            }
            if let (Some(m), Some(to)) = (self.masses.get(place), masses.get_mut(i)) {
                *to = *m;
            }
        }
    }
}

/// Where the particles in clusters stand.
fn places<'a, T: Real>(found: &'a Scratch<'_, T>) -> impl Iterator<Item = usize> + 'a {
    found.clusters().flat_map(|cluster| found.members(cluster.first, cluster.count))
}

/// A number as a word, without a rounding.
pub fn bits<T: Real>(x: T) -> u64 {
    x.to_f64().to_bits()
}

/// The number of such a word.
pub fn number<T: Real>(word: u64) -> T {
    T::from_f64(f64::from_bits(word))
}

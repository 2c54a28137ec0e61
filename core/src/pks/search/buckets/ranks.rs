//! Many particles that are spread over ranks.
//!
//! 1. Each rank puts its own particles into buckets. Numbers of particles and loads of the buckets are summed over the ranks.
//! 2. The buckets are divided among the ranks so that each looks at about as many particles. It receives the words of their particles, whose coordinates
//!    are fine enough to tell which are near to one another, and sieves and sorts as one process does.
//! 3. What may be part of a cluster becomes known to all: the particles of buckets in which three may collide, pairs within reach of one another by their
//!    coordinates, and those whose keys agree, each with its place in the order and the levels that it shares with its neighbours. Then their positions and masses.
//! 4. All ranks do the same with these as one process does: they sort the ties, and look at the pairs once more by their positions.
//!
//! Words and levels stand where they do in one process, with gaps where particles are not known.

use super::{BUCKETS, Buckets, HEAVY, Reach, Reaches, near, note};
use crate::checked::Present;
use crate::error::Result;
use crate::exec::{Chunks, Ranges, Ranks, Reduction, Resources, par_chunks};
use crate::pks::collision::Criterion;
use crate::pks::search::Particles;
use crate::pks::search::key_layout::KeyLayout;
use crate::pks::search::mesh::Mesh;
use crate::pks::search::order::{self, FIRST, MARK};
use crate::pks::search::shared::{Part, Shared, bits};
use crate::pks::search::tree::{ASKED, KNOWN};
use crate::real::Real;
use crate::sort::words as sort;

/// Words of the loads: numbers of own particles in each bucket; of all, their masses, and their largest masses.
pub const LOADS: usize = 4 * BUCKETS;
/// Numbers of the table for each rank.
pub const ROW: usize = BUCKETS;
/// A mark beside the shared levels: the particle becomes known.
const TOLD: u8 = 0x40;
/// Marks that are looked at together.
const CHUNK: usize = 64;
/// Instead of a level: there is no next particle in the bucket.
const NONE: u64 = 0xFF;
/// A level of up to 32 without marks.
const fn level(shared: u8) -> u8 {
    shared & !(MARK | TOLD)
}

impl Buckets<'_> {
    /// As [`Buckets::sort`] for the particles of all ranks, of which `particles` are this one's, the smallest mass that of all, as is the total. The words hold
    /// places among the known particles, where these stand in the order; levels are known there, behind, and at the start of each bucket.
    ///
    /// # Errors
    /// The executor's and the communicator's.
    pub fn sort_on_ranks<T: Real>(
        &mut self,
        (ranks, part): (&Ranks<'_>, Part),
        known: &mut Shared<'_, T>,
        (mesh, criterion): (&Mesh<T>, &Criterion<T>),
        (particles, total): (Particles<'_, T>, T),
        resources: Resources<'_>,
        (words, shared): (&mut [u64], &mut [u8]),
    ) -> Result<()> {
        let beyond = KeyLayout::new(part.all);
        let blocks = ranks.agree(self.file(mesh, beyond, part.first, particles, resources))?;
        self.add_loads(ranks, blocks, total, known)?;
        self.deal(ranks, part, blocks, known)?;
        let masses = self.masses.get(..self.occupied).present()?;
        let reaches = Reaches::new(mesh, criterion, particles.smallest, masses, beyond);
        let looked = self.look(ranks, known, (&reaches, criterion, beyond), resources, (&mut *words, &mut *shared));
        let mine = ranks.agree(looked)?;
        let (_, sums) = self.sums.split_first_mut().present()?;
        ranks.reduce(Reduction::Sum, sums.get_mut(..self.occupied).present()?.as_flattened_mut())?;
        let count = self.publish(ranks, mine, known, (&*words, &*shared))?;
        for place in 0..count {
            let &[which, levels] = known.words.get(2 * place..).and_then(<[u64]>::first_chunk).present()?;
            let at = (which >> 32) as usize;
            *known.numbers.get_mut(place).present()? = which as u32;
            *words.get_mut(at).present()? = place as u64;
            *shared.get_mut(at).present()? = levels as u8;
            if levels >> 8 != NONE {
                *shared.get_mut(at + 1).present()? = (levels >> 8) as u8;
            }
        }
        known.count = 0;
        known.fill(ranks, part, count, 2 * count, &particles)?;
        self.resolve(known, mesh, (&reaches, criterion), (&mut *words, &mut *shared))?;
        self.join(shared);
        Ok(())
    }

    /// Makes known all particles of the buckets that the walk has asked for, and looks at them as one process does. Returns whether there is room for them: else all particles have to be
    /// known.
    ///
    /// # Errors
    /// The communicator's.
    pub fn complete_on_ranks<T: Real>(
        &mut self,
        (ranks, part): (&Ranks<'_>, Part),
        known: &mut Shared<'_, T>,
        (mesh, criterion): (&Mesh<T>, &Criterion<T>),
        particles: Particles<'_, T>,
        resources: Resources<'_>,
        (words, shared): (&mut [u64], &mut [u8]),
    ) -> Result<bool> {
        let beyond = KeyLayout::new(part.all);
        let Self { blocked, spare, occupied, numbers, starts, masses, pairs, .. } = self;
        let masses = masses.get(..*occupied).present()?;
        let reaches = Reaches::new(mesh, criterion, particles.smallest, masses, beyond);
        let ranges =
            || starts.windows(2).map(|range| range.first_chunk().map_or([0; 2], |range| range.map(|at| at as usize)));
        let asked = || ranges().take(*occupied).enumerate().filter(|&(at, _)| known.buckets.get(at) == Some(&ASKED));
        let more = asked().map(|(_, [first, end])| end - first).sum::<usize>();
        let from = known.count;
        if from + more > part.all {
            return Ok(false);
        }
        let told = known.words.get_mut(..more).present()?;
        told.fill(0);
        let mut slot = 0;
        let received = Received::new(ranks, known.starts, known.table, blocked)?;
        for (at, [first, end]) in asked() {
            let bucket = usize::from(*numbers.get(at).present()?);
            let to = told.iter_mut().skip(slot);
            to.zip(received.words(bucket)).for_each(|(to, &word)| *to = beyond.number(word));
            slot += end - first;
        }
        ranks.reduce(Reduction::Sum, told)?;
        for (to, &number) in known.numbers.iter_mut().skip(from).zip(&*told) {
            *to = number as u32;
        }
        known.fill(ranks, part, more, 0, &particles)?;
        let mut place = from;
        for (at, [first, end]) in ranges().take(*occupied).enumerate() {
            let state = known.buckets.get_mut(at).present()?;
            if *state != ASKED {
                continue;
            }
            *state = KNOWN;
            let (words, spare) = (words.get_mut(first..end).present()?, spare.get_mut(first..end).present()?);
            let shared = shared.get_mut(first..end).present()?;
            let border = shared.first().copied();
            for word in words.iter_mut() {
                *word = beyond.put(mesh.cell_in_lanes(known.positions.get(place).present()?), place);
                place += 1;
            }
            let corner = KeyLayout::corner(usize::from(*numbers.get(at).present()?));
            let task = reaches.task(criterion, *masses.get(at).present()?, end - first, corner);
            let to = (words, spare, &mut *shared);
            (_, *pairs.get_mut(at).present()?) = task.run(mesh, beyond, known.positions, to, resources.level);
            shared.first_mut().zip(border).into_iter().for_each(|(level, border)| *level = border);
        }
        Ok(true)
    }

    /// Sums numbers of particles and loads over the ranks, and closes the gaps.
    fn add_loads<T: Real>(
        &mut self,
        ranks: &Ranks<'_>,
        blocks: usize,
        total: T,
        known: &mut Shared<'_, T>,
    ) -> Result<()> {
        // Masses as integers, so that sums depend on no order: rounded up, as they serve for bounds.
        const UNITS: f64 = 1_125_899_906_842_624.0;
        self.total(blocks);
        let total = total.to_f64();
        let (own, sums) = known.loads.split_at_mut_checked(BUCKETS).present()?;
        let (sums, heaviest) = sums.split_at_mut_checked(2 * BUCKETS).present()?;
        let (counts, units) = sums.split_at_mut_checked(BUCKETS).present()?;
        for (bucket, (&n, &[mass, largest])) in self.starts.iter().zip(self.masses.iter()).take(BUCKETS).enumerate() {
            let units = units.get_mut(bucket).present()?;
            *units = if n > 0 { (mass / total * UNITS) as u64 + 2 } else { 0 };
            *own.get_mut(bucket).present()? = u64::from(n);
            *counts.get_mut(bucket).present()? = u64::from(n);
            // Of numbers that are not negative the order is that of their bits.
            *heaviest.get_mut(bucket).present()? = bits(largest);
        }
        ranks.reduce(Reduction::Sum, sums)?;
        ranks.reduce(Reduction::Max, heaviest)?;
        let (counts, units) = sums.split_at_checked(BUCKETS).present()?;
        for (start, &n) in self.starts.iter_mut().zip(counts) {
            *start = n as u32;
        }
        for ((load, &units), &largest) in self.masses.iter_mut().zip(units).zip(&*heaviest) {
            *load = [units as f64 / UNITS * total, f64::from_bits(largest)];
        }
        self.close_gaps();
        Ok(())
    }

    /// Divides the buckets among the ranks and sends each the words of its buckets: see [`Received`].
    fn deal<T: Real>(&mut self, ranks: &Ranks<'_>, part: Part, blocks: usize, known: &mut Shared<'_, T>) -> Result<()> {
        let each = ranks.count() + 1;
        let (own, _) = known.loads.split_at_checked(BUCKETS).present()?;
        let (owners, rest) = known.starts.split_at_mut_checked(each).present()?;
        let (out, rest) = rest.split_at_mut_checked(each).present()?;
        let (froms, rows) = rest.split_at_mut_checked(each).present()?;
        for (rank, owner) in owners.iter_mut().enumerate() {
            // The first bucket from this share of the particles on.
            let share = (part.all as u64 * rank as u64 / ranks.count() as u64) as u32;
            let starts = self.starts.get(..self.occupied).present()?;
            let at = starts.partition_point(|&start| start < share);
            *owner = self.numbers.get(..self.occupied).and_then(|n| n.get(at)).map_or(BUCKETS, |&n| usize::from(n));
        }
        // Empty buckets belong to some rank, too.
        *owners.first_mut().present()? = 0;
        *owners.last_mut().present()? = BUCKETS;
        let mut start = 0;
        for (out, range) in out.iter_mut().zip(owners.windows(2)) {
            *out = start;
            let &[low, high] = range.first_chunk().present()?;
            start += own.get(low..high).present()?.iter().sum::<u64>() as usize;
        }
        *out.last_mut().present()? = start;
        let (low, high) = (*owners.get(ranks.rank()).present()?, *owners.get(ranks.rank() + 1).present()?);
        let row = high - low;
        rows.iter_mut().enumerate().for_each(|(rank, at)| *at = rank * row);
        let table = known.table.get_mut(..row * ranks.count()).present()?;
        ranks.exchange(own, owners, table, rows)?;
        let mut start = 0;
        for (rank, from) in froms.iter_mut().enumerate() {
            *from = start;
            for slot in table.iter_mut().skip(rank * row).take(row) {
                start += core::mem::replace(slot, start as u64) as usize;
            }
        }
        // Bucket by bucket.
        let Self { blocked, spare, ends, .. } = self;
        let mut at = 0;
        for bucket in 0..BUCKETS {
            for words in super::parts(blocked, ends, blocks, bucket) {
                let to = spare.get_mut(at..at + words.len()).present()?;
                to.iter_mut().zip(words).for_each(|(to, &from)| *to = from);
                at += words.len();
            }
        }
        let sent = spare.get(..part.own).present()?;
        ranks.exchange(sent, out, blocked.get_mut(..start).present()?, froms)
    }

    /// Looks at the buckets of this rank: sums of keys' coordinates, and marks of what becomes known. Returns which of the occupied buckets they are, and how many
    /// particles are marked.
    fn look<T: Real>(
        &mut self,
        ranks: &Ranks<'_>,
        known: &Shared<'_, T>,
        (reaches, criterion, beyond): (&Reaches<T>, &Criterion<T>, KeyLayout),
        resources: Resources<'_>,
        (words, shared): (&mut [u64], &mut [u8]),
    ) -> Result<(usize, usize, usize)> {
        let Self { blocked, spare, occupied, numbers, starts, masses, pairs, sums, .. } = self;
        let numbers = numbers.get(..*occupied).present()?;
        let received = Received::new(ranks, known.starts, known.table, blocked)?;
        let begin = numbers.partition_point(|&bucket| usize::from(bucket) < received.low);
        let end = numbers.partition_point(|&bucket| usize::from(bucket) < received.high);
        let masses = &**masses;
        let starts = starts.get(begin..=end).present()?;
        let (_, sums) = sums.split_first_mut().present()?;
        let sums = sums.get_mut(..*occupied).present()?;
        sums.fill([0; 3]);
        let (sums, found) = (sums.get_mut(begin..end).present()?, pairs.get_mut(begin..end).present()?);
        let ranges = (Ranges::new(words, starts)?, Ranges::new(spare, starts)?, Ranges::new(shared, starts)?);
        let pieces = (ranges, Chunks::new(&mut *found, 1), Chunks::new(sums, 1));
        par_chunks(resources.executor, end - begin, pieces, (), &|at, ((words, spare, shared), found, sums), ()| {
            let bucket = usize::from(*numbers.get(begin + at).present()?);
            words.iter_mut().zip(received.words(bucket)).for_each(|(to, &from)| *to = from);
            let load = masses.get(begin + at).copied().present()?;
            let mut task = reaches.task(criterion, load, words.len(), KeyLayout::corner(bucket));
            // Positions are elsewhere: coordinates decide.
            task.reach = task.reach.map(|reach| Reach { square: T::INFINITY, ..reach });
            let mut counts = [0; sort::BUCKETS];
            let (sum, ordered) = task.order(beyond, &[], (words, spare, &mut *shared), &mut counts, resources.level);
            let marked = if ordered && (task.heavy || task.reach.is_some()) { mark(shared, task.heavy) } else { 0 };
            found.iter_mut().for_each(|to| *to = marked);
            sums.iter_mut().for_each(|to| *to = sum);
            Ok(())
        })?;
        Ok((begin, end, found.iter().map(|&n| n as usize).sum()))
    }

    /// Tells all ranks of what is marked: two words each, the place in the order and the number, the levels shared with the one before and the next. Returns how many there are.
    fn publish<T: Real>(
        &mut self,
        ranks: &Ranks<'_>,
        (begin, end, mine): (usize, usize, usize),
        known: &mut Shared<'_, T>,
        (words, shared): (&[u64], &[u8]),
    ) -> Result<usize> {
        let counts = known.words.get_mut(..ranks.count()).present()?;
        ranks.gather(&[mine as u64], counts)?;
        let before = counts.iter().take(ranks.rank()).sum::<u64>() as usize;
        let count = counts.iter().sum::<u64>() as usize;
        let (told, _) = known.words.get_mut(..2 * count).present()?.as_chunks_mut::<2>();
        told.fill([0; 2]);
        let mut slots = told.iter_mut().skip(before);
        let found = self.pairs.iter().zip(self.starts.windows(2)).take(end).skip(begin);
        for (_, range) in found.filter(|&(&found, _)| found > 0) {
            let &[first, end] = range.first_chunk().present()?;
            let (first, end) = (first as usize, end as usize);
            let levels = shared.get(first..end).present()?;
            // Most are not marked.
            for (chunk, from) in levels.chunks(CHUNK).zip((first..).step_by(CHUNK)) {
                if chunk.iter().fold(0, |any, &here| any | here) & TOLD == 0 {
                    continue;
                }
                for (at, &here) in (from..).zip(chunk).filter(|&(_, here)| here & TOLD != 0) {
                    // Of the next one only the level: whether the two are near is its own to tell.
                    let next = levels.get(at + 1 - first).map_or(NONE, |&next| u64::from(level(next)));
                    let which = (at as u64) << 32 | *words.get(at).present()? & 0xFFFF_FFFF;
                    *slots.next().present()? = [which, next << 8 | u64::from(here & !TOLD)];
                }
            }
        }
        ranks.reduce(Reduction::Sum, told.as_flattened_mut())?;
        Ok(count)
    }

    /// Sorts the ties among the known particles, and notes the pairs within reach.
    fn resolve<T: Real>(
        &mut self,
        known: &mut Shared<'_, T>,
        mesh: &Mesh<T>,
        (reaches, criterion): (&Reaches<T>, &Criterion<T>),
        (words, shared): (&mut [u64], &mut [u8]),
    ) -> Result<()> {
        let Self { spare, occupied, numbers, starts, masses, pairs, .. } = self;
        let places = known.words.get(..2 * known.count).present()?;
        let mut places = places.iter().step_by(2).map(|&which| (which >> 32) as usize).peekable();
        let mut counts = [0; sort::BUCKETS];
        for at in 0..*occupied {
            let &[first, end] = starts.get(at..).and_then(<[u32]>::first_chunk).present()?;
            let (first, end) = (first as usize, end as usize);
            let load = *masses.get(at).present()?;
            let corner = KeyLayout::corner(usize::from(*numbers.get(at).present()?));
            let task = reaches.task(criterion, load, end - first, corner);
            let mut found = 0;
            while let Some(begin) = places.next_if(|&place| place < end) {
                // Those without a gap.
                let mut after = begin + 1;
                while after < end && places.next_if_eq(&after).is_some() {
                    after += 1;
                }
                let positions = &*known.positions;
                let (run, scratch) = (words.get_mut(begin..after).present()?, spare.get_mut(begin..after).present()?);
                let levels = shared.get_mut(begin..after).present()?;
                order::refine_ties(mesh, positions, run, scratch, &mut counts, levels);
                let Some(reach) = task.reach else { continue };
                let levels = shared.get_mut(begin..end.min(after + 1)).present()?;
                let marked = note(levels, scratch);
                let kept = near(reach, positions, run, scratch, marked) as usize;
                // From the bucket's first on. Half as many as particles, so none is written over before it is read.
                for k in 0..kept {
                    let place = *spare.get(begin + k).present()?;
                    *spare.get_mut(first + found).present()? = place + (begin - first) as u64;
                    found += 1;
                }
            }
            *known.buckets.get_mut(at).present()? = if task.heavy { KNOWN } else { 0 };
            *pairs.get_mut(at).present()? = if task.heavy { HEAVY } else { found as u32 };
        }
        Ok(())
    }
}

/// The words of the particles in a rank's buckets, as they were received.
struct Received<'a> {
    /// Which of all buckets, the empty ones included, are this rank's: from this one,
    low: usize,
    /// before this one.
    high: usize,
    /// Of each rank, where the words of each of these buckets begin.
    table: &'a [u64],
    /// Where those of each rank end.
    ends: &'a [usize],
    words: &'a [u64],
}

impl<'a> Received<'a> {
    /// As [`Buckets::deal`] has left it.
    fn new(ranks: &Ranks<'_>, starts: &'a [usize], table: &'a [u64], words: &'a [u64]) -> Result<Self> {
        let each = ranks.count() + 1;
        let (low, high) = (*starts.get(ranks.rank()).present()?, *starts.get(ranks.rank() + 1).present()?);
        let ends = starts.get(2 * each + 1..3 * each).present()?;
        Ok(Self { low, high, table, ends, words })
    }

    /// Those of a bucket, by ascending number; none if it is another rank's.
    fn words(&self, bucket: usize) -> impl Iterator<Item = &'a u64> {
        let &Self { low, high, table, ends, words } = self;
        let own = if low <= bucket && bucket < high { ends } else { &[] };
        own.iter().enumerate().flat_map(move |(rank, &end)| {
            let at = rank * (high - low) + bucket - low;
            let from = table.get(at).map_or(0, |&from| from as usize);
            let next = if bucket + 1 < high { table.get(at + 1).map(|&to| to as usize) } else { None };
            words.get(from..next.unwrap_or(end)).present_or(&[])
        })
    }
}

/// Marks what becomes known; how many.
fn mark(shared: &mut [u8], all: bool) -> u32 {
    if all {
        shared.iter_mut().for_each(|shared| *shared |= TOLD);
        return shared.len() as u32;
    }
    let others = |shared: &[u8], at: usize| shared.get(at).map_or(0, |&other| level(other));
    for at in 1..shared.len() {
        let here = shared.get(at).copied().present_or_default();
        if here & MARK == 0 && u32::from(level(here)) < FIRST {
            continue;
        }
        let here = level(here);
        let within = here > others(shared, at - 1) && here > others(shared, at + 1);
        if within || u32::from(here) == FIRST {
            for known in shared.iter_mut().skip(at - 1).take(2) {
                *known |= TOLD;
            }
        }
    }
    shared.iter().map(|shared| u32::from(shared & TOLD != 0)).sum()
}

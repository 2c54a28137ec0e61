//! Many particles: ordered by cells in parallel, and what is learnt on the way about each coarse cell.
//!
//! Particles go into buckets, the cells of level [`LEVEL`], block by block, so that what is written lies in a near cache; then each bucket
//! collects its particles from the blocks and, if need be, sorts them by the rest of their keys. Neither depends on the executor.
//!
//! Of most buckets nothing more is needed. Where no three particles can collide ([`Criterion::grouped`]) only pairs are of interest, and of
//! these only what is near enough to one another ([`Criterion::reach`]). Where no two are, as the [`Sieve`] finds, the bucket is not sorted; else the places
//! of the pairs are noted, and only their positions are looked at again. Sums of the keys' coordinates bound the second moments of what spans several
//! buckets.

mod ranks;

pub use ranks::{LOADS, ROW};

use super::Particles;
use super::bound::Bound;
use super::key_layout::KeyLayout;
use super::mesh::Mesh;
use super::order::{self, FIRST, LEVEL, MARK, key, levels};
use super::sieve::{LANES, Reach, Sieve, add, locals};
use crate::checked::Present;
use crate::error::Result;
use crate::exec::{Chunks, Ranges, Resources, par_chunks};
use crate::memory::Space;
use crate::pks::collision::{Criterion, Units};
use crate::real::Real;
use crate::simd::{Level, Loops, with_simd};
use crate::sort::words as sort;

/// How many buckets there are.
const BUCKETS: usize = 1 << (2 * LEVEL);
/// Particles that are put into buckets together.
const BLOCK: usize = 1 << 15;
/// From one block's table to the next: not a power of two, so that a bucket's counts in all blocks lie in different cache sets.
const PITCH: usize = BUCKETS + 32;
/// Ratios of the largest to the smallest mass, as powers of two, for which distances are known.
const RATIOS: usize = 24;

/// The search's memory for many particles.
#[derive(Debug)]
pub struct Buckets<'w> {
    /// Words of the particles, block by block, by buckets within a block.
    blocked: &'w mut [u64],
    /// Scratch of the sorts; then, bucket by bucket, the places of the pairs to look at.
    spare: &'w mut [u64],
    /// Where each bucket of a block ends in it.
    ends: &'w mut [u16],
    /// Mass and largest mass of each bucket of a block, in double precision: what is excluded by them has a margin of a thousandth.
    loads: &'w mut [[f64; 2]],
    /// Buckets that hold particles; what follows is about these, one after the other.
    occupied: usize,
    /// Which they are.
    numbers: &'w mut [u16],
    /// Where they begin, and the end of the last.
    starts: &'w mut [u32],
    /// Their masses and largest masses.
    masses: &'w mut [[f64; 2]],
    /// Pairs to look at, or [`HEAVY`].
    pairs: &'w mut [u32],
    /// Sums of the coordinates of the keys and of their squares, over all buckets before this one.
    sums: &'w mut [[u64; 3]],
}

/// Instead of a number of pairs: three or more of the bucket's particles may collide.
const HEAVY: u32 = u32::MAX;

/// What is known of a bucket.
#[derive(Clone, Copy, Debug)]
pub struct Bucket<'a> {
    /// Its first particle in the order.
    pub first: usize,
    /// How many it has, at least 1.
    pub count: usize,
    /// Their mass.
    pub mass: f64,
    /// The places, from the first, of the pairs that may collide; `None`: more than pairs may.
    pub pairs: Option<&'a [u64]>,
}

impl<'w> Buckets<'w> {
    /// Lays out the memory for `n` particles.
    pub fn layout(space: &mut impl Space<'w>, n: usize) -> Self {
        let blocks = n.div_ceil(BLOCK);
        let buckets = if n > 0 { BUCKETS } else { 0 };
        Self {
            blocked: space.array(n),
            spare: space.array(n),
            ends: space.array(blocks.saturating_mul(PITCH)),
            loads: space.array(blocks.saturating_mul(BUCKETS)),
            occupied: 0,
            numbers: space.array(buckets),
            starts: space.array(if n > 0 { BUCKETS + 1 } else { 0 }),
            masses: space.array(buckets),
            pairs: space.array(buckets),
            sums: space.array(if n > 0 { BUCKETS + 1 } else { 0 }),
        }
    }

    /// Orders the particles by buckets: `words` and `shared`, as long as they are, are overwritten as by [`order::few`], but in a bucket that has no pairs to look at
    /// words are only numbers, in the order of the particles, and of the levels only the first is known.
    ///
    /// # Errors
    /// The executor's.
    pub fn sort<T: Real>(
        &mut self,
        mesh: &Mesh<T>,
        criterion: &Criterion<T>,
        particles: Particles<'_, T>,
        resources: Resources<'_>,
        (words, shared): (&mut [u64], &mut [u8]),
    ) -> Result<()> {
        let Particles { positions, smallest, .. } = particles;
        let beyond = KeyLayout::new(positions.len());
        let blocks = self.file(mesh, beyond, 0, particles, resources)?;
        self.total(blocks);
        self.close_gaps();
        let Self { blocked, spare, ends, occupied, numbers, starts, masses, pairs, sums, .. } = self;
        let (blocked, ends, numbers, masses) = (&**blocked, &**ends, &**numbers, masses.get(..*occupied).present()?);
        let starts = starts.get(..=*occupied).present()?;
        let reaches = Reaches::new(mesh, criterion, smallest, masses, beyond);
        let ranges = (Ranges::new(words, starts)?, Ranges::new(spare, starts)?, Ranges::new(shared, starts)?);
        let (_, sums_of) = sums.split_first_mut().unwrap_or((&mut [0; 3], &mut []));
        let pieces = (ranges, Chunks::new(pairs, 1), Chunks::new(sums_of, 1));
        par_chunks(resources.executor, *occupied, pieces, (), &|at, ((words, spare, shared), pairs, sums), ()| {
            let bucket = numbers.get(at).map_or(0, |&bucket| usize::from(bucket));
            let parts = parts(blocked, ends, blocks, bucket);
            words.iter_mut().zip(parts.flatten()).for_each(|(to, &from)| *to = from);
            let load = masses.get(at).copied().present_or_default();
            let task = reaches.task(criterion, load, words.len(), KeyLayout::corner(bucket));
            let (sum, found) = task.run(mesh, beyond, positions, (words, spare, shared), resources.level);
            sums.iter_mut().for_each(|s| *s = sum);
            pairs.iter_mut().for_each(|p| *p = found);
            Ok(())
        })?;
        self.join(shared);
        Ok(())
    }

    /// Puts particles into buckets, block by block; the number of the first is given. Returns how many blocks there are.
    fn file<T: Real>(
        &mut self,
        mesh: &Mesh<T>,
        beyond: KeyLayout,
        first: usize,
        particles: Particles<'_, T>,
        resources: Resources<'_>,
    ) -> Result<usize> {
        let Particles { positions, masses, .. } = particles;
        let n = positions.len();
        let blocks = n.div_ceil(BLOCK);
        let pieces = (
            (Chunks::new(&mut *self.spare, BLOCK), Chunks::new(&mut *self.blocked, BLOCK)),
            (Chunks::new(&mut *self.ends, PITCH), Chunks::new(&mut *self.loads, BUCKETS)),
        );
        par_chunks(resources.executor, blocks, pieces, (), &|block, ((keys, words), (ends, loads)), ()| {
            let from = block * BLOCK;
            let until = n.min(from + BLOCK);
            let (positions, masses) = (positions.get(from..until).present()?, masses.get(from..until).present()?);
            let from = first + from;
            with_simd(resources.level, File { mesh, beyond, from, positions, masses, keys, words, ends, loads });
            Ok(())
        })?;
        Ok(blocks)
    }

    /// Adds up what the blocks hold: numbers of particles and loads of all buckets.
    fn total(&mut self, blocks: usize) {
        let Self { ends, loads, starts, masses, .. } = self;
        starts.fill(0);
        masses.fill([0.0; 2]);
        for (ends, loads) in ends.chunks(PITCH).zip(loads.chunks(BUCKETS)).take(blocks) {
            let before = core::iter::once(&0).chain(ends);
            for ((count, &end), &before) in starts.iter_mut().zip(ends.iter().take(BUCKETS)).zip(before) {
                *count += u32::from(end - before);
            }
            for ([mass, heaviest], &[m, h]) in masses.iter_mut().zip(loads) {
                *mass += m;
                *heaviest = if h > *heaviest { h } else { *heaviest };
            }
        }
    }

    /// Numbers of particles become starts, and the gaps that empty buckets leave are closed.
    fn close_gaps(&mut self) {
        let Self { occupied, numbers, starts, masses, .. } = self;
        *occupied = 0;
        let mut start = 0;
        for bucket in 0..BUCKETS {
            let (Some(&count), Some(&load)) = (starts.get(bucket), masses.get(bucket)) else { return };
            if count > 0
                && let (Some(to), Some(mass), Some(number)) =
                    (starts.get_mut(*occupied), masses.get_mut(*occupied), numbers.get_mut(*occupied))
            {
                (*to, *mass, *number) = (start, load, bucket as u16);
                *occupied += 1;
                start += count;
            }
        }
        if let Some(end) = starts.get_mut(*occupied) {
            *end = start;
        }
    }

    /// What runs through all buckets: levels shared across their borders, and running sums.
    fn join(&mut self, shared: &mut [u8]) {
        let mut before = None;
        let mut sum = [0_u64; 3];
        if let Some(first) = self.sums.first_mut() {
            *first = sum;
        }
        let buckets = self.numbers.iter().zip(self.starts.iter()).take(self.occupied);
        for (sums, (&bucket, &start)) in self.sums.iter_mut().skip(1).zip(buckets) {
            for (sum, here) in sum.iter_mut().zip(sums.iter_mut()) {
                *sum = sum.wrapping_add(*here);
                *here = *sum;
            }
            if let Some(level) = shared.get_mut(start as usize) {
                let at = u32::from(bucket) << (32 - 2 * LEVEL);
                *level = before.map_or(0, |before| levels(before, at));
                before = Some(at);
            }
        }
    }

    /// The buckets that hold particles.
    pub fn iter(&self) -> impl Iterator<Item = Bucket<'_>> {
        let known = self.masses.iter().zip(self.pairs.iter()).take(self.occupied);
        self.starts.windows(2).zip(known).filter_map(|(range, (&[mass, _], &pairs))| {
            let &[start, end] = range else { return None };
            let (first, count) = (start as usize, end.checked_sub(start)? as usize);
            let noted = (pairs != HEAVY).then(|| self.spare.get(first..first + pairs as usize)).flatten();
            Some(Bucket { first, count, mass, pairs: noted })
        })
    }

    /// What bounds second moments, with the smallest mass in the unit that they have.
    pub fn bound<T: Real>(&self, mesh: &Mesh<T>, smallest: T) -> Bound<'_, T> {
        Bound {
            // Entries after the occupied buckets are not in order.
            starts: self.starts.get(..=self.occupied).present_or(&[]),
            sums: self.sums,
            width: mesh.side.ldexp(-(FIRST as i32)).to_f64(),
            smallest,
        }
    }
}

/// Reaches by the largest mass of a bucket, up to which each holds; `None`: no two count.
struct Reaches<T>([(T, Option<Reach<T>>); RATIOS + 1]);

impl<T: Real> Reaches<T> {
    /// For masses from the smallest to the largest of the buckets' largest, given as they are.
    fn new(mesh: &Mesh<T>, criterion: &Criterion<T>, smallest: T, masses: &[[f64; 2]], beyond: KeyLayout) -> Self {
        let Units { mass: unit, length, .. } = criterion.units;
        let smallest = smallest * unit;
        let heaviest = masses.iter().fold(smallest, |most, &[_, h]| most.max(T::from_f64(h) * unit));
        let width = mesh.side.ldexp(-((FIRST + beyond.levels) as i32));
        // In cells, what the coordinates of two particles are rounded by at most: each is a difference, next to the mesh's far side to a whole epsilon of it if
        // its side is just above a power of two, else to half of one, and a product, to half of one.
        let roundings = T::TWO * T::EPSILON * T::ONE.ldexp((FIRST + beyond.levels) as i32);
        let mut largest = smallest;
        Self(core::array::from_fn(|_| {
            if largest >= T::TWO * heaviest {
                // No bucket asks for it.
                return (largest, None);
            }
            let reach = criterion.reach(smallest, largest).map(|reach| Reach {
                // Rounded up (test `two_within_reach_are_never_more_cells_apart`).
                cells: (reach / width * (T::ONE + T::TWO * T::EPSILON) + roundings).to_u32().saturating_add(1),
                square: reach * reach,
                unit: length,
            });
            let known = (largest, reach);
            largest = T::TWO * largest;
            known
        }))
    }

    /// What there is to find in a bucket of this load with so many particles, whose keys' coordinates begin at the corner.
    fn task(&self, criterion: &Criterion<T>, load: [f64; 2], count: usize, corner: [u32; 2]) -> Task<T> {
        let [mass, heaviest] = load.map(|m| T::from_f64(m) * criterion.units.mass);
        let heavy = count > 2 && criterion.grouped(mass, heaviest);
        Task { heavy, reach: if heavy { None } else { self.of(heaviest) }, corner }
    }

    fn of(&self, heaviest: T) -> Option<Reach<T>> {
        let any = Some(Reach { cells: u32::MAX, square: T::INFINITY, unit: T::ONE });
        self.0.iter().find(|&&(largest, _)| heaviest <= largest).map_or(any, |&(_, reach)| reach)
    }
}

/// What there is to find in a bucket.
#[derive(Clone, Copy)]
struct Task<T> {
    /// Three or more of the particles may collide.
    heavy: bool,
    /// Else: within what two may.
    reach: Option<Reach<T>>,
    /// The coordinates of the keys begin here.
    corner: [u32; 2],
}

impl<T: Real> Task<T> {
    /// Orders the words of a bucket as far as need be, and notes the places of the pairs within reach. Returns the sums of the keys' coordinates and of their
    /// squares, and how many pairs there are, or [`HEAVY`].
    #[inline]
    fn run(
        self,
        mesh: &Mesh<T>,
        beyond: KeyLayout,
        positions: &[[T; 2]],
        (words, spare, shared): (&mut [u64], &mut [u64], &mut [u8]),
        level: Level,
    ) -> ([u64; 3], u32) {
        let mut counts = [0; sort::BUCKETS];
        let to = (&mut *words, &mut *spare, &mut *shared);
        let (sum, ordered) = self.order(beyond, positions, to, &mut counts, level);
        if !ordered {
            return (sum, 0);
        }
        order::refine_ties(mesh, positions, words, spare, &mut counts, shared);
        let found = match self.reach {
            _ if self.heavy => HEAVY,
            Some(reach) => {
                let marked = note(shared, spare);
                near(reach, positions, words, spare, marked)
            }
            None => 0,
        };
        (sum, found)
    }

    /// Puts the words of a bucket in order and compares neighbours, unless no two are near to one another. Returns the sums of the keys' coordinates
    /// and of their squares, and whether there is an order.
    #[inline]
    fn order(
        self,
        beyond: KeyLayout,
        positions: &[[T; 2]],
        (words, spare, shared): (&mut [u64], &mut [u64], &mut [u8]),
        counts: &mut [u32; sort::BUCKETS],
        level: Level,
    ) -> ([u64; 3], bool) {
        let Self { heavy, reach, corner } = self;
        let count = words.len();
        let sieve = Sieve { words: &mut *words, spare: &mut *spare, beyond, reach, positions };
        if !heavy && let Some(sum) = with_simd(level, sieve) {
            return (from_corner(sum, corner, count), false);
        }
        let sum = with_simd(level, Key { words: &mut *words, beyond, corner });
        sort::by_20_bits(words, spare, counts);
        with_simd(level, Compare { words, shared, beyond, cells: reach.map(|reach| reach.cells) });
        (from_corner(sum, corner, count), true)
    }
}

/// The words of a bucket, block by block.
fn parts<'a>(blocked: &'a [u64], ends: &'a [u16], blocks: usize, bucket: usize) -> impl Iterator<Item = &'a [u64]> {
    (0..blocks).map(move |block| {
        let end = |at: usize| ends.get(block * PITCH + at).map_or(0, |&end| usize::from(end));
        let from = block * BLOCK;
        let begin = if bucket == 0 { 0 } else { end(bucket - 1) };
        blocked.get(from + begin..from + end(bucket)).present_or(&[])
    })
}

/// Puts the particles of a block into buckets.
struct File<'a, T> {
    mesh: &'a Mesh<T>,
    beyond: KeyLayout,
    /// The number of the block's first particle.
    from: usize,
    positions: &'a [[T; 2]],
    masses: &'a [T],
    keys: &'a mut [u64],
    words: &'a mut [u64],
    ends: &'a mut [u16],
    loads: &'a mut [[f64; 2]],
}

impl<T: Real> Loops for File<'_, T> {
    type Out = ();

    #[inline(always)]
    fn run(self) {
        let Self { mesh, beyond, from, positions, masses, keys, words, ends, loads } = self;
        for (i, (key, x)) in (from..).zip(keys.iter_mut().zip(positions)) {
            *key = beyond.put(mesh.cell_in_lanes(x), i);
        }
        ends.fill(0);
        loads.fill([0.0; 2]);
        let keys = keys.get(..positions.len()).present_or(&[]);
        for (&word, &m) in keys.iter().zip(masses) {
            if let (Some(count), Some([mass, heaviest])) =
                (ends.get_mut(KeyLayout::bucket(word)), loads.get_mut(KeyLayout::bucket(word)))
            {
                let m = m.to_f64();
                *count += 1;
                *mass += m;
                *heaviest = if m > *heaviest { m } else { *heaviest };
            }
        }
        let mut start = 0;
        for end in ends.iter_mut() {
            start += core::mem::replace(end, start);
        }
        for &word in keys {
            if let Some(end) = ends.get_mut(KeyLayout::bucket(word)) {
                if let Some(slot) = words.get_mut(usize::from(*end)) {
                    *slot = word;
                }
                *end += 1;
            }
        }
    }
}

/// Gives the words of a bucket their keys. Returns the sums of the keys' coordinates in the bucket and of their squares.
struct Key<'a> {
    words: &'a mut [u64],
    beyond: KeyLayout,
    corner: [u32; 2],
}

impl Loops for Key<'_> {
    type Out = [u64; 3];

    #[inline(always)]
    fn run(self) -> [u64; 3] {
        let Self { words, beyond, corner } = self;
        let mut sums = [0; 3];
        for words in words.chunks_mut(LANES) {
            add(&mut sums, beyond, &locals(beyond, words));
            words.iter_mut().for_each(|word| *word = beyond.keyed(*word, corner));
        }
        sums
    }
}

/// Sums of coordinates and of their squares over so many particles, of those in the bucket that begins here.
fn from_corner([sx, sy, squares]: [u64; 3], corner: [u32; 2], count: usize) -> [u64; 3] {
    let ([x, y], count) = (corner.map(u64::from), count as u64);
    [sx + count * x, sy + count * y, squares + 2 * (x * sx + y * sy) + count * (x * x + y * y)]
}

/// Compares each particle's word with the one before it: levels shared, and whether they may be near enough. Of the words the keys and numbers
/// are left.
struct Compare<'a> {
    words: &'a mut [u64],
    shared: &'a mut [u8],
    beyond: KeyLayout,
    /// Cells along each axis within which two are near; `None`: none are.
    cells: Option<u32>,
}

impl Loops for Compare<'_> {
    type Out = ();

    #[inline(always)]
    fn run(self) {
        let Self { words, shared, beyond, cells } = self;
        let (near, reach) = (if cells.is_some() { MARK } else { 0 }, cells.unwrap_or(0));
        let mut last = words.first().copied().unwrap_or(0);
        for (words, shared) in words.chunks_mut(LANES).zip(shared.chunks_mut(LANES)) {
            // The one before, and the particles of the chunk.
            let mut keys = [last; LANES + 1];
            keys.iter_mut().skip(1).zip(words.iter()).for_each(|(to, &word)| *to = word);
            last = words.last().copied().unwrap_or(last);
            let mut places = [[0_u32; LANES + 1]; 2];
            let [xs, ys] = &mut places;
            for ((x, y), &word) in xs.iter_mut().zip(ys).zip(&keys) {
                [*x, *y] = beyond.place(word);
            }
            let [xs, ys] = &places;
            let mut out = [0_u8; LANES];
            let steps = xs.iter().zip(xs.iter().skip(1)).zip(ys.iter().zip(ys.iter().skip(1)));
            for ((out, (&a, &b)), ((ax, bx), (ay, by))) in
                out.iter_mut().zip(keys.iter().zip(keys.iter().skip(1))).zip(steps)
            {
                let close = (ax.abs_diff(*bx) <= reach) & (ay.abs_diff(*by) <= reach);
                *out = levels(key(a), key(b)) | if close { near } else { 0 };
            }
            shared.iter_mut().zip(out).for_each(|(to, from)| *to = from);
            words.iter_mut().for_each(|word| *word = beyond.strip(*word));
        }
        // The first is compared with the bucket before, later.
        if let Some(first) = shared.first_mut() {
            *first = 0;
        }
    }
}

/// Notes the places of marked neighbours that are nearer to one another than to the next on either side; how many. Takes the marks away.
fn note(shared: &mut [u8], places: &mut [u64]) -> u32 {
    let level = |shared: &[u8], k: usize| shared.get(k).map_or(0, |&level| level & !MARK);
    let mut found = 0;
    for (k, &here) in shared.iter().enumerate().skip(1) {
        // Keys that agree are near to one another.
        if here & MARK == 0 && u32::from(here) < FIRST {
            continue;
        }
        let here = here & !MARK;
        if here > level(shared, k - 1)
            && here > level(shared, k + 1)
            && let Some(place) = places.get_mut(found as usize)
        {
            *place = (k - 1) as u64;
            found += 1;
        }
    }
    shared.iter_mut().for_each(|level| *level &= !MARK);
    found
}

/// Keeps of so many noted places those whose particles are within reach; how many. The reads of positions do not wait for one another.
fn near<T: Real>(reach: Reach<T>, positions: &[[T; 2]], words: &[u64], places: &mut [u64], noted: u32) -> u32 {
    if !reach.square.is_finite() {
        return noted;
    }
    let mut kept = 0;
    for at in 0..noted as usize {
        let Some(&place) = places.get(at) else { continue };
        let position = |k: u64| words.get(k as usize).and_then(|&word| positions.get(order::particle(word)));
        let (Some(a), Some(b)) = (position(place), position(place + 1)) else { continue };
        if let Some(slot) = places.get_mut(kept) {
            *slot = place;
            kept += usize::from(reach.holds(a, b));
        }
    }
    kept as u32
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::exec::Serial;
    use crate::memory::{ALIGN, Carve, Measure};
    use crate::pks::collision::{CollisionLaw, Merging};
    use crate::pks::extent::Extent;
    use crate::pks::search::Search;
    use crate::pks::testing::Uniform;
    use crate::pks::theory::Constants;
    use std::vec;
    use std::vec::Vec;

    fn within_reach<T: Real>(n: usize) -> u32 {
        let c = T::from_f64;
        let mut numbers = Uniform(9);
        let mut uniform = || numbers.next();
        let beyond = KeyLayout::new(n);
        let mut farthest = 0;
        for _ in 0..400 {
            // Sides next to powers of two, where coordinates are coarsest against the cells.
            let size = c(0.5 + 0.3 * uniform() * uniform());
            let corner = c(2.0 * uniform() - 1.0);
            let extent =
                Extent { low: [corner; 2], high: [corner + size; 2], smallest: T::ONE, largest: T::ONE, total: T::ONE };
            let mesh = Mesh::new(&Search::default(), &extent, (1000.0 * uniform()) as u64, T::ONE);
            // A reach of a few cells.
            let width = mesh.side.to_f64() / (1_u64 << (FIRST + beyond.levels)) as f64;
            let dt = (width * 4.0 * uniform()).powi(2);
            let law = Constants { chi: c(0.1), noise: T::ONE, gamma: T::ONE };
            let criterion = Criterion::new(law, CollisionLaw::Exact, Merging::All, c(1e-4), c(dt));
            let reach = criterion.reach(T::ONE, T::ONE).unwrap();
            let known = Reaches::new(&mesh, &criterion, T::ONE, &[[1.0; 2]], beyond).of(T::ONE).unwrap();
            for _ in 0..2000 {
                let a = [0, 1].map(|_| corner + size * c(uniform()));
                let b = a.map(|x| x + reach * c(2.0 * uniform() - 1.0));
                if (b[0] - a[0]).abs() > reach || (b[1] - a[1]).abs() > reach {
                    continue;
                }
                let [p, q] = [a, b].map(|x| mesh.cell_in_lanes(&x).map(|c| c >> (FIRST - beyond.levels)));
                let apart = p[0].abs_diff(q[0]).max(p[1].abs_diff(q[1]));
                assert!(apart <= known.cells, "{apart} {known:?} {reach} {width}");
                farthest = farthest.max(apart + 3 - known.cells.min(apart + 3));
            }
        }
        farthest
    }

    #[test]
    fn two_within_reach_are_never_more_cells_apart() {
        for n in [600, 70_000, 1_000_000, 1 << 28] {
            // The bound is reached to a cell or two.
            assert!(within_reach::<f64>(n) > 0);
            assert!(within_reach::<f32>(n) > 0);
        }
    }

    #[test]
    fn only_occupied_buckets_bound_moments() {
        // In two clumps, so that most buckets are empty, with memory that was used before.
        let mut numbers = Uniform(4);
        let n = 2000;
        let positions: Vec<[f64; 2]> = (0..n).map(|i| [0, 1].map(|_| (i % 2) as f64 + 0.1 * numbers.next())).collect();
        let masses = vec![1.0; n];
        let extent = Extent::of(&positions, &masses, &Serial).unwrap();
        let law = Constants { chi: 1e-6, noise: 1.0, gamma: 1.0 };
        let criterion = Criterion::new(law, CollisionLaw::Exact, Merging::All, 1e-4, 1e-6);
        let bytes = Measure::of(|space| {
            Buckets::layout(space, n);
            space.finish()
        });
        let mut memory = vec![0xAB_u8; bytes.unwrap() + ALIGN];
        let start = memory.as_ptr().align_offset(ALIGN);
        let mut buckets = Buckets::layout(&mut Carve::reopen(&mut memory[start..]).unwrap(), n);
        for step in 0..10 {
            let mesh = Mesh::new(&Search::default(), &extent, step, 1.0);
            let particles = Particles {
                positions: &positions,
                masses: &masses,
                charges: None,
                smallest: extent.smallest,
                medium: None,
            };
            let (mut words, mut shared) = (vec![0; n], vec![0; n]);
            buckets.sort(&mesh, &criterion, particles, Resources::default(), (&mut words, &mut shared)).unwrap();
            let bound = buckets.bound(&mesh, extent.smallest);
            assert!(bound.starts.windows(2).all(|w| w[0] < w[1]) && bound.starts.last() == Some(&(n as u32)));
            assert_eq!(buckets.iter().map(|bucket| bucket.count).sum::<usize>(), n);
            // Of all of them.
            let middle = [0, 1].map(|k| positions.iter().map(|x| x[k]).sum::<f64>() / n as f64);
            let square = |x: &[f64; 2]| (x[0] - middle[0]).powi(2) + (x[1] - middle[1]).powi(2);
            let spread: f64 = positions.iter().map(square).sum();
            let least = bound.spread(0, n as u32).unwrap();
            assert!(least <= spread && least > 0.9 * spread, "{least} {spread}");
        }
    }
}

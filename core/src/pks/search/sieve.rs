//! Which buckets hold two particles near to one another. Where a collision takes two that are very near, most buckets hold none, and their
//! particles need no order.
//!
//! A bit for each cell of a grid over the bucket tells where a second particle comes to; what lies in such cells is compared pair by pair. Two
//! within reach of one another may lie on both sides of a border: what is within reach of its cell's border is compared too. Whatever is compared is listed in
//! every cell that half the reach around it touches. So two within reach meet in the own cell of one of them, or, across a corner, in a cell that both
//! touch. Cells at the edge of a bucket are counted cyclically. The extra comparisons cannot change the result.

use super::key_layout::KeyLayout;
use crate::real::Real;
use crate::simd::Loops;

/// Buckets with fewer particles are not tested.
const WORTH: usize = 64;
/// Particles that are looked at side by side.
pub const LANES: usize = 32;

/// How far two particles of a bucket may be from one another to count.
#[derive(Clone, Copy, Debug)]
pub struct Reach<T> {
    /// Cells of the words' coordinates, along each axis.
    pub cells: u32,
    /// The square of the distance; infinite: any.
    pub square: T,
    /// What positions are multiplied by for it.
    pub unit: T,
}

/// Looks for two particles near to one another. If there are none, leaves the numbers in the words, and returns the sums of the keys' coordinates in the
/// bucket and of their squares; else, or if there may be some, nothing.
pub struct Sieve<'a, T> {
    /// The words of the particles, as they were put into the bucket.
    pub words: &'a mut [u64],
    /// As long, overwritten.
    pub spare: &'a mut [u64],
    /// What the words hold.
    pub beyond: KeyLayout,
    /// Within which two are near; `None`: none are.
    pub reach: Option<Reach<T>>,
    /// Of all particles, if the reach has a distance.
    pub positions: &'a [[T; 2]],
}

impl<T: Real> Loops for Sieve<'_, T> {
    type Out = Option<[u64; 3]>;

    #[inline(always)]
    fn run(self) -> Self::Out {
        let Self { words, spare, beyond, reach, positions } = self;
        if words.len() < WORTH {
            return None;
        }
        let mut sums = [0; 3];
        if let Some(reach) = reach {
            let grid = Grid::new(words.len(), beyond, reach.cells)?;
            let (bits, scratch) = spare.split_at_mut_checked(grid.words())?;
            let several = grid.visit(words, bits, scratch, beyond, &mut sums)?;
            let among = Among { words, beyond, reach, positions };
            if several > 0 && grid.two_within_reach(&among, bits, scratch, several)? {
                return None;
            }
        } else {
            for words in words.chunks(LANES) {
                add(&mut sums, beyond, &locals(beyond, words));
            }
        }
        words.iter_mut().for_each(|word| *word = beyond.number(*word));
        Some(sums)
    }
}

/// A bucket's particles.
struct Among<'a, T> {
    words: &'a [u64],
    beyond: KeyLayout,
    reach: Reach<T>,
    positions: &'a [[T; 2]],
}

impl<T: Real> Among<'_, T> {
    /// Whether two of the words are of particles within reach.
    #[inline(always)]
    fn near(&self, a: u32, b: u32) -> Option<bool> {
        let (&a, &b) = (self.words.get(a as usize)?, self.words.get(b as usize)?);
        let ([ax, ay], [bx, by]) = (self.beyond.local(a), self.beyond.local(b));
        if ax.abs_diff(bx) > self.reach.cells || ay.abs_diff(by) > self.reach.cells {
            return Some(false);
        }
        if !self.reach.square.is_finite() {
            // The coordinates decide.
            return Some(true);
        }
        let [a, b] = [a, b].map(|word| self.positions.get(self.beyond.number(word) as usize));
        Some(self.reach.holds(a?, b?))
    }
}

impl<T: Real> Reach<T> {
    /// Whether two places are within the distance.
    #[inline(always)]
    pub fn holds(self, a: &[T; 2], b: &[T; 2]) -> bool {
        let [dx, dy] = [(b[0] - a[0]) * self.unit, (b[1] - a[1]) * self.unit];
        dx * dx + dy * dy <= self.square
    }
}

/// The coordinates of up to [`LANES`] words, and zeros.
#[inline(always)]
pub fn locals(beyond: KeyLayout, words: &[u64]) -> [[u32; LANES]; 2] {
    let mut places = [[0; LANES]; 2];
    let [xs, ys] = &mut places;
    for ((x, y), &word) in xs.iter_mut().zip(ys).zip(words) {
        [*x, *y] = beyond.local(word);
    }
    places
}

/// Adds the coordinates of keys, and their squares.
#[inline(always)]
pub fn add([sx, sy, squares]: &mut [u64; 3], beyond: KeyLayout, [xs, ys]: &[[u32; LANES]; 2]) {
    for (&x, &y) in xs.iter().zip(ys) {
        let (x, y) = (u64::from(x >> beyond.levels), u64::from(y >> beyond.levels));
        *sx += x;
        *sy += y;
        *squares += x * x + y * y;
    }
}

/// The grid over a bucket.
#[derive(Clone, Copy)]
struct Grid {
    /// Cells along each axis, as powers of two.
    axes: [u32; 2],
    /// From a coordinate to its cell.
    shifts: [u32; 2],
    /// Half the reach, rounded up.
    half: u32,
    reach: u32,
}

impl Grid {
    /// With 8 to 16 cells for each particle, so that their bits take up to a quarter of a word each; none if they were not much wider than the reach.
    #[inline(always)]
    fn new(particles: usize, beyond: KeyLayout, reach: u32) -> Option<Self> {
        let levels = beyond.below();
        let cells = particles.ilog2() + 4;
        let axes = [cells.div_ceil(2), cells / 2];
        let [x, y] = axes;
        let shifts = [levels.checked_sub(x)?, levels.checked_sub(y)?];
        (reach <= 1 << shifts[0] >> 3).then_some(Self { axes, shifts, half: reach.div_ceil(2), reach })
    }

    /// Words for a bit for each cell.
    #[inline(always)]
    fn words(self) -> usize {
        (1 << (self.axes[0] + self.axes[1])) / 64
    }

    /// The cell of a place in units of cells, counted around.
    #[inline(always)]
    fn cell(self, [x, y]: [u32; 2]) -> u32 {
        let [p, q] = self.axes;
        (y & ((1 << q) - 1)) << p | x & ((1 << p) - 1)
    }

    /// The cells of so many places.
    #[inline(always)]
    fn locate(self, [xs, ys]: &[[u32; LANES]; 2]) -> [u32; LANES] {
        let mut cells = [0; LANES];
        let [p, q] = self.shifts;
        for ((&x, &y), cell) in xs.iter().zip(ys).zip(&mut cells) {
            *cell = self.cell([x >> p, y >> q]);
        }
        cells
    }

    /// For each place whether it is within reach of its cell's border: not zero if so.
    #[inline(always)]
    fn outer(self, [xs, ys]: &[[u32; LANES]; 2]) -> [u32; LANES] {
        let mut outer = [0; LANES];
        let across = |x: u32, shift: u32| (x.wrapping_sub(self.reach) ^ x.wrapping_add(self.reach)) >> shift;
        let [p, q] = self.shifts;
        for ((&x, &y), outer) in xs.iter().zip(ys).zip(&mut outer) {
            *outer = across(x, p) | across(y, q);
        }
        outer
    }

    /// The cells that a place reaches into, its own among them: one, two or four.
    #[inline(always)]
    fn around(self, [x, y]: [u32; 2]) -> ([u32; 4], usize) {
        let [p, q] = self.shifts;
        let [left, low] = [x.wrapping_sub(self.half) >> p, y.wrapping_sub(self.half) >> q];
        let [right, high] = [x.wrapping_add(self.half) >> p, y.wrapping_add(self.half) >> q];
        let corners = [[left, low], [right, low], [left, high], [right, high]];
        let [a, b, c, d] = [self.cell(corners[0]), self.cell(corners[1]), self.cell(corners[2]), self.cell(corners[3])];
        match (left != right, low != high) {
            (true, true) => ([a, b, c, d], 4),
            (true, false) => ([a, b, c, d], 2),
            (false, true) => ([a, c, b, d], 2),
            (false, false) => ([a, b, c, d], 1),
        }
    }

    /// Writes the cells of particles that may be near to another one, some more than once; how many, if there is room for them.
    #[inline(always)]
    fn visit(
        self,
        words: &[u64],
        bits: &mut [u64],
        several: &mut [u64],
        beyond: KeyLayout,
        sums: &mut [u64; 3],
    ) -> Option<usize> {
        bits.fill(0);
        let mut count = 0;
        for words in words.chunks(LANES) {
            let places = locals(beyond, words);
            add(sums, beyond, &places);
            let (cells, outer) = (self.locate(&places), self.outer(&places));
            for (&cell, &outer) in cells.iter().zip(&outer).take(words.len()) {
                let word = bits.get_mut(cell as usize / 64)?;
                let was = *word >> (cell % 64) & 1;
                *word |= 1 << (cell % 64);
                *several.get_mut(count)? = u64::from(cell);
                count += usize::from((was as u32 | outer) > 0);
            }
        }
        Some(count)
    }

    /// Whether two particles are within reach; nothing if there is no room to tell. Given are the first of the cells where two may be.
    #[inline(always)]
    fn two_within_reach<T: Real>(
        self,
        among: &Among<'_, T>,
        bits: &mut [u64],
        scratch: &mut [u64],
        several: usize,
    ) -> Option<bool> {
        bits.fill(0);
        for &cell in scratch.iter().take(several) {
            if let Some(word) = bits.get_mut(cell as usize / 64) {
                *word |= 1 << (cell % 64);
            }
        }
        let mut lists = Lists::new(scratch)?;
        let mut from = 0;
        for words in among.words.chunks(LANES) {
            let [xs, ys] = locals(among.beyond, words);
            let cells = self.locate(&[xs, ys]);
            let mut some = 0_u32;
            for (k, &cell) in cells.iter().take(words.len()).enumerate() {
                let set = bits.get(cell as usize / 64).map_or(0, |word| word >> (cell % 64) & 1);
                some |= (set as u32) << k;
            }
            while some > 0 {
                let k = some.trailing_zeros();
                some &= some - 1;
                let (&x, &y) = (xs.get(k as usize)?, ys.get(k as usize)?);
                let (cells, reached) = self.around([x, y]);
                for &cell in cells.iter().take(reached) {
                    if lists.meets(cell, from + k, among)? {
                        return Some(true);
                    }
                }
            }
            from += LANES as u32;
        }
        Some(false)
    }
}

/// Lists of the particles in each cell.
struct Lists<'a> {
    /// One after the last entry of the list for each hash of a cell, 0 if it has none.
    heads: &'a mut [u64],
    /// The particle in the high half, one after the entry before it in the low half.
    entries: &'a mut [u64],
    count: u32,
    /// Comparisons that may still be made: where many lie in one cell sorting is faster, and never takes n^2.
    left: usize,
}

impl<'a> Lists<'a> {
    #[inline(always)]
    fn new(scratch: &'a mut [u64]) -> Option<Self> {
        let (heads, entries) = scratch.split_at_mut_checked(1 << scratch.len().checked_ilog2()?.checked_sub(1)?)?;
        heads.fill(0);
        let left = 2 * entries.len();
        Some(Self { heads, entries, count: 0, left })
    }

    /// Whether the particle is within reach of one in the cell's list; adds it. Nothing if there is no room for it, or too many are in the list.
    #[inline(always)]
    fn meets<T: Real>(&mut self, cell: u32, particle: u32, among: &Among<'_, T>) -> Option<bool> {
        // Knuth's multiplicative hash, which keeps neighbouring cells apart, so that a particle does not meet itself.
        let hash = (u64::from(cell.wrapping_mul(0x9E37_79B1)) * self.heads.len() as u64) >> 32;
        let head = self.heads.get_mut(hash as usize)?;
        *self.entries.get_mut(self.count as usize)? = u64::from(particle) << 32 | *head;
        self.count += 1;
        let mut at = core::mem::replace(head, u64::from(self.count));
        while let Some(before) = at.checked_sub(1) {
            self.left = self.left.checked_sub(1)?;
            let &entry = self.entries.get(before as usize)?;
            if among.near((entry >> 32) as u32, particle)? {
                return Some(true);
            }
            at = entry & 0xFFFF_FFFF;
        }
        Some(false)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pks::testing::Uniform;
    use std::vec::Vec;

    /// Places anywhere in a bucket of 16 levels, some next to borders of the sieve's cells; the last one, if asked, within so many cells of another one, often
    /// at just their distance.
    fn places(numbers: &mut Uniform, count: usize, shifts: [u32; 2], beside: Option<u32>) -> Vec<[u32; 2]> {
        let inside = |x: f64| x.clamp(0.0, f64::from(1 << 16) - 1.0) as u32;
        let mut anywhere = |share: f64, reach: u32| {
            shifts.map(|shift| {
                let (x, width) = (f64::from(1 << 16) * numbers.next(), f64::from(1 << shift));
                let off = f64::from(2 * reach + 4) * (numbers.next() - 0.5);
                inside(if numbers.next() < share { (x / width).round() * width + off } else { x })
            })
        };
        let mut places: Vec<[u32; 2]> = (0..count).map(|_| anywhere(0.05, 1)).collect();
        if let Some(reach) = beside {
            let near = anywhere(0.7, reach);
            places[count / 2] = near;
            places[count - 1] = near.map(|x| {
                let off = f64::from(reach) * [-1.0, 1.0, 2.0 * numbers.next() - 1.0][(3.0 * numbers.next()) as usize];
                inside(f64::from(x) + off.round())
            });
        }
        places
    }

    #[test]
    fn no_two_within_reach_pass() {
        // Coordinates of 16 bits in the bucket.
        let beyond = KeyLayout::new(1 << 20);
        assert_eq!(beyond.below(), 16);
        let mut numbers = Uniform(3);
        let (mut with_two, mut tried, mut passed) = (0, 0, 0);
        for trial in 0..12_000 {
            let count = [64, 65, 100, 127, 300, 1500][trial % 6];
            let shifts = Grid::new(count, beyond, 0).unwrap().shifts;
            let most = 1 << shifts[0] >> 3;
            let cells = [1, 2, 5, most][trial / 6 % 4];
            let beside = (trial % 24 != trial % 48).then_some(cells);
            let places = places(&mut numbers, count, shifts, beside);
            let put = |(i, x): (usize, &[u32; 2])| beyond.put(x.map(|x| 0x1400_0000 | x << 10), i);
            let mut words: Vec<u64> = places.iter().enumerate().map(put).collect();
            let bucket = KeyLayout::bucket(words[0]);
            assert!(words.iter().all(|&word| KeyLayout::bucket(word) == bucket));
            let near = |x: &[u32; 2], y: &[u32; 2]| x[0].abs_diff(y[0]).max(x[1].abs_diff(y[1])) <= cells;
            let two = places.iter().enumerate().any(|(k, x)| places[..k].iter().any(|y| near(x, y)));
            // By coordinates alone: any distance of those counts.
            let reach = Some(Reach { cells, square: f64::INFINITY, unit: 1.0 });
            let (positions, mut spare) = (std::vec![[0.0; 2]; count], words.clone());
            let sieve = Sieve { words: &mut words, spare: &mut spare, beyond, reach, positions: &positions };
            let sums = sieve.run();
            with_two += usize::from(two);
            tried += usize::from(!two);
            if let Some([sx, sy, squares]) = sums {
                assert!(!two, "{trial} {count} {cells}");
                assert!(words.iter().enumerate().all(|(i, &word)| word == i as u64));
                let keys = places.iter().map(|x| x.map(|x| u64::from(x >> 6)));
                assert_eq!(sx, keys.clone().map(|[x, _]| x).sum::<u64>());
                assert_eq!(sy, keys.clone().map(|[_, y]| y).sum::<u64>());
                assert_eq!(squares, keys.map(|[x, y]| x * x + y * y).sum::<u64>());
                passed += 1;
            }
            // Where cells are far wider than the reach there is room, and nothing that is apart stops a bucket.
            assert!(two || cells > 2 || sums.is_some(), "{trial} {count} {cells}");
            assert!(cells > most || Grid::new(count, beyond, most + 1).is_none());
        }
        assert!(with_two > 4000 && tried > 3000 && passed > tried * 3 / 4, "{with_two} {passed} of {tried}");
    }

    #[test]
    fn a_crowd_in_one_cell_is_left_to_the_sort() {
        let (beyond, count, mut numbers) = (KeyLayout::new(1 << 20), 4000, Uniform(5));
        let grid = Grid::new(count, beyond, 1).unwrap();
        for crowd in [3, count / 10, count / 4, count / 2, count * 3 / 4] {
            let place = |i: usize| {
                if i < crowd { [1_u32, 1] } else { [0, 1].map(|_| (65_535.0 * numbers.next()) as u32) }
            };
            let places: Vec<[u32; 2]> = (0..count).map(place).collect();
            let put = |(i, x): (usize, &[u32; 2])| beyond.put(x.map(|x| x << 10), i);
            let words: Vec<u64> = places.iter().enumerate().map(put).collect();
            let positions: Vec<[f64; 2]> = (0..count).map(|i| [i as f64, 0.0]).collect();
            // In one cell, but apart.
            let (words, spare) = (&mut *words.clone(), &mut *words.clone());
            let reach = Some(Reach { cells: 1, square: 0.0, unit: 1.0 });
            let passes = Sieve { words, spare, beyond, reach, positions: &positions }.run().is_some();
            assert_eq!(passes, crowd == 3, "{crowd}");
        }
        assert!(grid.words() * 4 <= count);
    }

    #[test]
    fn none_pass_from_one_place_and_all_if_nothing_is_near() {
        let beyond = KeyLayout::new(1 << 20);
        for count in [WORTH - 1, WORTH, WORTH + 1] {
            // All in one place.
            let words: Vec<u64> = (0..count).map(|i| beyond.put([77 << 20, 33 << 20], i)).collect();
            let positions = std::vec![[0.0_f64; 2]; count];
            let passes = |reach| {
                let (words, spare) = (&mut *words.clone(), &mut *words.clone());
                Sieve { words, spare, beyond, reach, positions: &positions }.run().is_some()
            };
            assert!(!passes(Some(Reach { cells: 1, square: 0.0, unit: 1.0 })));
            assert_eq!(passes(None), count >= WORTH);
        }
    }
}

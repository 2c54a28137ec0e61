//! Cells: a cube around all points, halved along each axis as long as a part holds many points.
//!
//! The width of the cube has few digits and its corner is a multiple of a small part of it, so that the centres of all cells are numbers without rounding, and positions relative to them
//! as accurate as the points, however small a cell is. The lowest point is a third of the width from the corner, so a third of the width from a corner of cells of many levels:
//! series of a cell are least accurate in its corners, and in the lowest corner and in the middle of all points there is often something heavy.
//!
//! Sources and targets share the cells. These stand level by level, parts of a cell next to each other, and their points along the Z-order curve, so that those of any cell
//! are neighbours in memory. Cells without points are left out.
//!
//! Two cells of a level are *adjacent* if they touch or are the same. A pair of a target and a source is met once: by the largest cells around them that are not adjacent,
//! if they are of one level ([`Cells::each_apart`]), or, where such cells do not exist, at the leaf of the target ([`Cells::each_near`]).

use core::ops::Range;

use crate::checked::Present;
use crate::error::Result;
use crate::memory::Space;
use crate::real::{DoubleWord, Real, quotient};
use crate::sort::words::{BUCKETS, by_20_bits};

/// Bits of a key.
const KEY_BITS: u32 = 18;
/// The most levels below the root.
pub(super) const DEPTH: usize = 30;
/// The most cells that are adjacent to one.
const ADJACENT: usize = 27;
/// No cell.
pub(super) const NONE: u32 = u32::MAX;

/// Sorts of points.
pub(super) const SOURCES: usize = 0;
pub(super) const TARGETS: usize = 1;

/// A cell.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cell {
    /// The first source and one beyond the last, the same of the targets.
    pub spans: [[u32; 2]; 2],
    /// The first part and their number; none: a leaf.
    parts: [u32; 2],
    parent: u32,
    pub level: u32,
    /// Bits of the keys, of each axis, that are left to divide by.
    bits: u32,
    /// Its place among the cells of its level, along each axis.
    pub place: [u32; 3],
}

/// The numbers of a [`Cell`].
const WORDS: usize = 12;

impl Cell {
    fn of(w: [u32; WORDS]) -> Self {
        let [s, t, u, v, first, count, parent, level, bits, x, y, z] = w;
        Self { spans: [[s, t], [u, v]], parts: [first, count], parent, level, bits, place: [x, y, z] }
    }

    fn words(&self) -> [u32; WORDS] {
        let ([[s, t], [u, v]], [first, count], [x, y, z]) = (self.spans, self.parts, self.place);
        [s, t, u, v, first, count, self.parent, self.level, self.bits, x, y, z]
    }

    /// Its points of a sort.
    pub fn points(&self, sort: usize) -> Range<usize> {
        let [start, end] = self.spans.get(sort).copied().present_or([0; 2]);
        start as usize..end as usize
    }

    /// The cell around it.
    pub fn parent(&self) -> Option<usize> {
        (self.parent != NONE).then_some(self.parent as usize)
    }

    /// Its parts.
    pub fn parts(&self) -> Range<usize> {
        let [first, count] = self.parts;
        first as usize..first as usize + count as usize
    }

    /// The axes along which it is the upper half of its parent, one bit each.
    pub fn half(&self) -> u32 {
        self.place.iter().enumerate().fold(0, |axes, (axis, place)| axes | (place % 2) << axis)
    }

    /// Whether it has no parts.
    pub fn is_leaf(&self) -> bool {
        self.parts[1] == 0
    }

    /// The steps along each axis from another cell of the level to this one.
    pub fn steps_from(&self, other: &Cell) -> [i32; 3] {
        let mut steps = [0; 3];
        for (step, (&to, &from)) in steps.iter_mut().zip(self.place.iter().zip(&other.place)) {
            *step = to as i32 - from as i32;
        }
        steps
    }

    fn is_adjacent(&self, other: &Cell) -> bool {
        self.steps_from(other).iter().all(|step| (-1..=1).contains(step))
    }
}

/// Words to sort, of which the low halves say which point each is, and what sorting takes.
pub(super) struct Words<'a> {
    pub sorts: [&'a mut [u64]; 2],
    pub spare: &'a mut [u64],
    pub counts: &'a mut [u32; BUCKETS],
}

/// Where to stop dividing.
#[derive(Clone, Copy, Debug)]
pub(super) struct Limits<T> {
    /// No cell of at most so many sources and targets is divided.
    pub leaf: usize,
    /// No cell is narrower than this.
    pub width: T,
    /// The mean number of points of a leaf that is best if they are uniform; 0: any.
    pub mean: usize,
    /// Whether the lowest point is near a corner of large cells, so that few of them are partly filled; else it is a third of the width away.
    pub aligned: bool,
}

/// All cells.
pub(super) struct Cells<'w, T> {
    dimension: usize,
    all: &'w mut [[u32; WORDS]],
    adjacent: &'w mut [[u32; ADJACENT]],
    len: usize,
    /// The first cell of each level, and one beyond the last.
    levels: [u32; DEPTH + 2],
    n_levels: usize,
    corner: [T; 3],
    /// The width of the root.
    width: T,
}

impl<'w, T: Real> Cells<'w, T> {
    /// Room for so many cells.
    pub fn layout(space: &mut impl Space<'w>, dimension: usize, cells: usize) -> Result<Self> {
        Ok(Self {
            dimension,
            all: space.try_array(cells)?,
            adjacent: space.try_array(cells)?,
            len: 0,
            levels: [0; DEPTH + 2],
            n_levels: 0,
            corner: [T::ZERO; 3],
            width: T::ZERO,
        })
    }

    /// The number of cells.
    pub fn len(&self) -> usize {
        self.len
    }

    /// A cell.
    pub fn get(&self, k: usize) -> Cell {
        Cell::of(self.all.get(k).copied().present_or([0; WORDS]))
    }

    /// The number of levels.
    pub fn n_levels(&self) -> usize {
        self.n_levels
    }

    /// The cells of a level.
    pub fn of_level(&self, level: usize) -> Range<usize> {
        let at = |level: usize| self.levels.get(level).copied().present_or(0) as usize;
        at(level)..at(level + 1)
    }

    /// The width of the cells of a level.
    pub fn width(&self, level: usize) -> T {
        self.width.ldexp(-(level as i32))
    }

    /// The centre of a cell.
    pub fn centre(&self, cell: &Cell) -> [T; 3] {
        let width = self.width(cell.level as usize);
        let mut centre = self.corner;
        for (x, &place) in centre.iter_mut().zip(&cell.place).take(self.dimension) {
            *x += (T::from_usize(place as usize) + T::HALF) * width;
        }
        centre
    }

    /// Divides the cube around all points, and sorts the words. Returns the most points of a leaf: more than asked for where there is no room for so many cells.
    pub fn divide(
        &mut self,
        mut words: Words<'_>,
        mut limits: Limits<T>,
        point: &[&dyn Fn(usize) -> [T; 3]; 2],
    ) -> Result<usize> {
        // Any order of the words will do.
        while !self.divided(&mut words, limits, point)? {
            limits.leaf = limits.leaf.saturating_mul(2);
        }
        Ok(limits.leaf)
    }

    /// The same for leaves of this size. `false`: there is no room for the cells.
    fn divided(
        &mut self,
        words: &mut Words<'_>,
        limits: Limits<T>,
        point: &[&dyn Fn(usize) -> [T; 3]; 2],
    ) -> Result<bool> {
        let (corner, width) = self.cube(words, limits, point);
        (self.corner, self.width) = (corner, width);
        let spans = [[0, words.sorts[SOURCES].len() as u32], [0, words.sorts[TARGETS].len() as u32]];
        let root = Cell { spans, parts: [0; 2], parent: NONE, level: 0, bits: 0, place: [0; 3] };
        let Some(slot) = self.all.first_mut() else { return Ok(false) };
        *slot = root.words();
        (self.len, self.n_levels, self.levels) = (1, 1, [0; DEPTH + 2]);
        let mut k = 0;
        while k < self.len {
            let cell = self.get(k);
            let level = cell.level as usize;
            if level + 1 > self.n_levels {
                *self.levels.get_mut(level).present()? = k as u32;
                self.n_levels = level + 1;
            }
            let [sources, targets] = [SOURCES, TARGETS].map(|sort| cell.points(sort).len());
            let is_large = sources.max(targets) > limits.leaf && level < DEPTH && self.width(level + 1) >= limits.width;
            if is_large && self.width(level) > T::ZERO && !self.split(k, words, point)? {
                return Ok(false);
            }
            k += 1;
        }
        *self.levels.get_mut(self.n_levels).present()? = self.len as u32;
        Ok(true)
    }

    /// Makes the sources the targets, too.
    pub fn share(&mut self) {
        for words in self.all.iter_mut().take(self.len) {
            let mut cell = Cell::of(*words);
            cell.spans[TARGETS] = cell.spans[SOURCES];
            *words = cell.words();
        }
    }

    /// Gives the mass of coincident sources in leaves of more than `leaf` to the first of them; `masses` are `count` numbers, or the components of as many vectors, one component after
    /// the other. `points` in their order, in space.
    pub fn merge(&mut self, leaf: usize, (masses, count): (&mut [T], usize), points: &dyn Fn(usize) -> [T; 3]) {
        for words in self.all.iter_mut().take(self.len) {
            let mut cell = Cell::of(*words);
            let range = cell.points(SOURCES);
            let first = points(range.start);
            if !cell.is_leaf() || range.len() <= leaf || range.clone().any(|k| points(k) != first) {
                continue;
            }
            for masses in masses.chunks_mut(count.max(1)) {
                let mut sum = DoubleWord::ZERO;
                for mass in masses.get_mut(range.clone()).unwrap_or_default() {
                    sum = sum.plus(core::mem::replace(mass, T::ZERO));
                }
                masses.get_mut(range.start).into_iter().for_each(|mass| *mass = sum.hi);
            }
            cell.spans[SOURCES][1] = cell.spans[SOURCES][0] + 1;
            *words = cell.words();
        }
    }

    /// A cube around all points: its corner and width. The lowest point is a third of the width from the corner. With `mean` the leaves of uniform points hold about so many, and fill the box around the points
    /// up to its upper end.
    fn cube(&self, words: &Words<'_>, limits: Limits<T>, point: &[&dyn Fn(usize) -> [T; 3]; 2]) -> ([T; 3], T) {
        let Limits { mean, aligned, .. } = limits;
        let (mut least, mut most) = ([T::INFINITY; 3], [-T::INFINITY; 3]);
        for (words, point) in words.sorts.iter().zip(point) {
            let [low, high] = bounds(words, point);
            least.iter_mut().zip(low).for_each(|(to, x)| *to = to.min(x));
            most.iter_mut().zip(high).for_each(|(to, x)| *to = to.max(x));
        }
        let mut sides = [T::ZERO; 3];
        for (side, (&a, &b)) in sides.iter_mut().zip(least.iter().zip(&most)).take(self.dimension) {
            *side = b - a;
        }
        let side = sides.into_iter().fold(T::ZERO, T::max);
        if !(side > T::ZERO && side.is_finite()) {
            return ([T::ZERO; 3], T::ZERO);
        }
        // Three quarters or two thirds of the width are free above the lowest point.
        let needed = side * T::from_f64(if aligned { 4.0 / 3.0 } else { 1.5 + 0.03125 });
        let (bits, digits) = if T::DIGITS > 32 { (20, 12) } else { (10, 6) };
        let mut width = T::ONE.ldexp(needed.frexp().1);
        let points = words.sorts.iter().map(|words| words.len()).max().unwrap_or(0);
        if let Some(leaves) = points.checked_div(mean).filter(|&leaves| leaves > 1) {
            let shape = sides.map(|x| quotient(x, side));
            width = quotient(side, T::from_f64(along_side(shape, leaves, self.dimension)));
            // A third of 4^k is a third more than a whole number.
            while width < needed {
                width = width.ldexp(2);
            }
            let unit = width.frexp().1 - digits;
            width = (width.ldexp(-unit).floor() + T::ONE).ldexp(unit);
        }
        let (bits, third) = if aligned { (2, T::ZERO) } else { (bits, T::from_usize((1 << bits) / 3)) };
        let part = width.ldexp(-bits);
        (least.map(|x| if x.is_finite() { ((x / part).floor() - third) * part } else { T::ZERO }), width)
    }

    /// Divides a cell; not if its points coincide. `false`: there is no room.
    fn split(&mut self, k: usize, words: &mut Words<'_>, point: &[&dyn Fn(usize) -> [T; 3]; 2]) -> Result<bool> {
        let mut cell = self.get(k);
        let dimension = self.dimension as u32;
        if cell.bits == 0 {
            let mut corner = self.centre(&cell);
            let width = self.width(cell.level as usize);
            corner.iter_mut().for_each(|x| *x -= width * T::HALF);
            for sort in [SOURCES, TARGETS] {
                let some = words.sorts.get_mut(sort).and_then(|words| words.get_mut(cell.points(sort))).present()?;
                let point = *point.get(sort).present()?;
                set_keys(some, point, self.dimension, (corner, width));
                by_20_bits(some, words.spare.get_mut(..some.len()).present()?, words.counts);
            }
            cell.bits = KEY_BITS / dimension.max(1);
        }
        let parts = [SOURCES, TARGETS]
            .map(|sort| words.sorts.get(sort).and_then(|words| words.get(cell.points(sort))).present_or(&[]));
        if parts.iter().all(|part| all_keys_equal(part)) && coincide(parts, point) {
            return Ok(true);
        }
        cell.bits -= 1;
        let shift = 32 + cell.bits * dimension;
        let first = self.len;
        let mut starts = [cell.spans[SOURCES][0], cell.spans[TARGETS][0]];
        for code in 0..1_u64 << dimension {
            let mut spans = [[0; 2]; 2];
            for (((span, start), part), whole) in spans.iter_mut().zip(&mut starts).zip(parts).zip(cell.spans) {
                let mask = (1 << dimension) - 1;
                let end = whole[0] + part.partition_point(|word| word >> shift & mask <= code) as u32;
                *span = [*start, end];
                *start = end;
            }
            if spans.iter().all(|[start, end]| start == end) {
                continue;
            }
            let mut place = cell.place;
            place.iter_mut().enumerate().for_each(|(axis, x)| *x = 2 * *x + (code >> axis & 1) as u32);
            let part = Cell { spans, parts: [0; 2], parent: k as u32, level: cell.level + 1, bits: cell.bits, place };
            let Some(slot) = self.all.get_mut(self.len) else { return Ok(false) };
            *slot = part.words();
            self.len += 1;
        }
        cell.parts = [first as u32, (self.len - first) as u32];
        *self.all.get_mut(k).present()? = cell.words();
        Ok(true)
    }

    /// Lists the adjacent cells of each, for what asks for them.
    pub fn find_adjacent(&mut self) -> Result<()> {
        let mut of_root = [NONE; ADJACENT];
        of_root[0] = 0;
        *self.adjacent.first_mut().present()? = of_root;
        for k in 1..self.len {
            let cell = self.get(k);
            let mut list = [NONE; ADJACENT];
            let mut slots = list.iter_mut();
            for large in self.adjacent(cell.parent as usize) {
                for part in self.get(large).parts() {
                    if self.get(part).is_adjacent(&cell) {
                        *slots.next().present()? = part as u32;
                    }
                }
            }
            *self.adjacent.get_mut(k).present()? = list;
        }
        Ok(())
    }

    /// The cells that are adjacent to one, itself included.
    pub fn adjacent(&self, k: usize) -> impl Iterator<Item = usize> {
        let list = self.adjacent.get(k).present_or(&[NONE; ADJACENT]);
        list.iter().take_while(|&&k| k != NONE).map(|&k| k as usize)
    }

    /// The source cells that a target cell meets at its level: not adjacent to it, while the cells around both are.
    pub fn each_apart(&self, k: usize, mut meet: impl FnMut(usize, [i32; 3]) -> Result<()>) -> Result<()> {
        let cell = self.get(k);
        for large in cell.parent().into_iter().flat_map(|parent| self.adjacent(parent)) {
            for part in self.get(large).parts() {
                let other = self.get(part);
                if !other.points(SOURCES).is_empty() && !other.is_adjacent(&cell) {
                    meet(part, cell.steps_from(&other))?;
                }
            }
        }
        Ok(())
    }

    /// The source cells that a leaf meets as a whole, point by point: those adjacent to it, and the leaves adjacent to the cells around it.
    pub fn each_near(&self, leaf: usize, mut meet: impl FnMut(usize) -> Result<()>) -> Result<()> {
        self.adjacent(leaf).try_for_each(&mut meet)?;
        let mut next = self.get(leaf).parent();
        while let Some(above) = next {
            self.adjacent(above).filter(|&k| self.get(k).is_leaf()).try_for_each(&mut meet)?;
            next = self.get(above).parent();
        }
        Ok(())
    }

    /// The leaves with targets, in the order of these.
    pub fn leaves(&self, to: &mut [u32], stack: &mut [u32]) -> Result<usize> {
        let (mut waiting, mut found) = (1, 0);
        *stack.first_mut().present()? = 0;
        while waiting > 0 {
            waiting -= 1;
            let k = *stack.get(waiting).present()?;
            let cell = self.get(k as usize);
            if cell.points(TARGETS).is_empty() {
                continue;
            }
            if cell.is_leaf() {
                *to.get_mut(found).present()? = k;
                found += 1;
            }
            for part in cell.parts().rev() {
                *stack.get_mut(waiting).present()? = part as u32;
                waiting += 1;
            }
        }
        Ok(found)
    }
}

/// Part of a cell below the lowest point.
const BELOW: f64 = 0.34;

/// How many cells as wide as they should be lie along the longest side of a box, with the sides `shape` relative to it, so that about `leaves` of them fill it: a whole number but for what is below the lowest point.
fn along_side<T: Real>(shape: [T; 3], leaves: usize, dimension: usize) -> f64 {
    let cells = |n: f64| {
        let along = |side: &T| {
            let along = side.to_f64() * n;
            if along > 1.0 { along } else { 1.0 }
        };
        shape.iter().take(dimension).map(along).product::<f64>()
    };
    let (mut n, leaves) = (2.0 - BELOW, leaves as f64);
    // The volumes of two neighbours are as far from the one that is wanted where its square is their product.
    while cells(n) * cells(n + 1.0) < leaves * leaves {
        n += 1.0;
    }
    n
}

/// Entries that [`Cells::leaves`] needs on its stack.
pub(super) const STACK: usize = 8 * (DEPTH + 1);

/// Which point a word is of.
pub(super) fn index(word: u64) -> usize {
    (word & u64::from(u32::MAX)) as usize
}

/// The least and the largest coordinates of some points.
fn bounds<T: Real>(words: &[u64], point: &dyn Fn(usize) -> [T; 3]) -> [[T; 3]; 2] {
    let (mut least, mut most) = ([T::INFINITY; 3], [-T::INFINITY; 3]);
    for &word in words {
        let x = point(index(word));
        least.iter_mut().zip(x).for_each(|(to, x)| *to = if x < *to { x } else { *to });
        most.iter_mut().zip(x).for_each(|(to, x)| *to = if x > *to { x } else { *to });
    }
    [least, most]
}

/// Whether all keys are equal; the words are sorted.
fn all_keys_equal(words: &[u64]) -> bool {
    words.first().zip(words.last()).is_none_or(|(first, last)| first >> 32 == last >> 32)
}

/// Whether all points of both sorts coincide.
fn coincide<T: Real>(words: [&[u64]; 2], point: &[&dyn Fn(usize) -> [T; 3]; 2]) -> bool {
    let mut all = words.iter().zip(point).flat_map(|(words, point)| words.iter().map(|&word| point(index(word))));
    let first = all.next();
    all.all(|x| Some(x) == first)
}

/// Writes the keys of points into the high halves of their words: the place along the Z-order curve in a cube.
fn set_keys<T: Real>(
    words: &mut [u64],
    point: &dyn Fn(usize) -> [T; 3],
    dimension: usize,
    (corner, width): ([T; 3], T),
) {
    let bits = KEY_BITS / (dimension as u32).max(1);
    let (cells, last) = (T::ONE.ldexp(bits as i32), (1 << bits) - 1);
    for word in words {
        let x = point(index(*word));
        let mut key = 0_u64;
        for (axis, (&x, &least)) in x.iter().zip(&corner).take(dimension).enumerate() {
            // A quotient, as the inverse of the width may be infinite.
            let cell = (quotient(x - least, width) * cells).to_u32().min(last);
            for bit in 0..bits {
                key |= u64::from(cell >> bit & 1) << (bit as usize * dimension + axis);
            }
        }
        *word = key << 32 | index(*word) as u64;
    }
}

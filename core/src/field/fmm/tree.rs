//! Boxes around points that lie close together.
//!
//! Points are sorted along a Z-order curve of 2^10 cells in each dimension; a box with more points than a leaf may have is divided where the next bit of the key
//! changes: along x and y in turn, and nowhere where one side would be empty. Square cells may be leaves of twice as many points. A box whose points share all bits of their keys gets keys of its own, relative to its own
//! points. So any scale in the data is resolved, in a time that grows with the number of scales, and the number of boxes is at most twice that of leaves.
//!
//! Boxes are the least ones around their points, which is all that the rest of the method needs to know of them. They stand in depth-first order: the first part of box k
//! is box k + 1, and all that is below it lies next to it. Points that coincide cannot be divided, and are a leaf of any size. Several trees may share the arrays.

use crate::checked::Present;
use crate::error::{Error, Result};
use crate::memory::Space;
use crate::real::{DoubleWord, Real, quotient};
use crate::sort::words::{BUCKETS, by_20_bits};

/// Bits of a key in each dimension.
const BITS: u32 = 10;
/// The most trees in the same arrays.
pub(super) const MAX_ROOTS: usize = 4;
/// Boxes that wait to be divided.
const PENDING: usize = 512;
/// No box.
const NONE: u32 = u32::MAX;

/// The geometry of a box.
#[derive(Clone, Copy, Debug)]
pub(super) struct Shape<T> {
    pub centre: [T; 2],
    /// Half its sides.
    pub half: [T; 2],
    /// No point is farther from the centre.
    pub radius: T,
    /// The largest support of its sources.
    pub reach: T,
}

impl<T: Real> Shape<T> {
    fn of([x, y, half_x, half_y, radius, reach]: [T; 6]) -> Self {
        Self { centre: [x, y], half: [half_x, half_y], radius, reach }
    }
}

/// Boxes.
#[derive(Debug)]
pub(super) struct Tree<'w, T> {
    /// See [`Shape`].
    shapes: &'w mut [[T; 6]],
    /// The first point and one beyond the last, the second part (0: a leaf), one beyond the last box below, one beyond the last point that counts as a source.
    links: &'w mut [[u32; 5]],
    len: usize,
}

impl<'w, T: Real> Tree<'w, T> {
    /// Room for so many boxes.
    pub fn layout(space: &mut impl Space<'w>, boxes: usize) -> Result<Self> {
        Ok(Self { shapes: space.try_array(boxes)?, links: space.try_array(boxes)?, len: 0 })
    }

    /// The number of boxes.
    pub fn len(&self) -> usize {
        self.len
    }

    /// The geometry of a box.
    #[inline(always)]
    pub fn shape(&self, k: usize) -> Shape<T> {
        Shape::of(self.shapes.get(k).copied().present_or([T::ZERO; 6]))
    }

    #[inline(always)]
    fn link(&self, k: usize) -> [u32; 5] {
        self.links.get(k).copied().present_or([0; 5])
    }

    /// The points of a box.
    #[inline(always)]
    pub fn points(&self, k: usize) -> core::ops::Range<usize> {
        let [start, end, ..] = self.link(k);
        start as usize..end as usize
    }

    /// The sources of a box, as the sum over pairs is to see them: of a large leaf of coincident ones the first has all the mass.
    #[inline(always)]
    pub fn sources(&self, k: usize) -> [u32; 2] {
        let [start, .., end] = self.link(k);
        [start, end]
    }

    /// The two parts of a box that is not a leaf.
    #[inline(always)]
    pub fn parts(&self, k: usize) -> Option<[usize; 2]> {
        let [_, _, second, ..] = self.link(k);
        (second != 0).then_some([k + 1, second as usize])
    }

    /// One beyond the last box below this one.
    #[inline(always)]
    pub fn last(&self, k: usize) -> usize {
        self.link(k)[3] as usize
    }

    /// Forgets all boxes.
    pub fn clear(&mut self) {
        self.len = 0;
    }

    /// Sorts the points `range` of `words`, whose low halves say which point each is, and adds a tree for them. `false`: there is no room for its boxes.
    pub fn add(
        &mut self,
        words: &mut [u64],
        range: core::ops::Range<usize>,
        (spare, counts): (&mut [u64], &mut [u32; BUCKETS]),
        leaf: usize,
        point: &dyn Fn(usize) -> [T; 2],
    ) -> Result<bool> {
        if range.is_empty() {
            return Ok(true);
        }
        let mut pending = [[0_u32; 4]; PENDING];
        let (mut waiting, first) = (1, self.len);
        *pending.first_mut().present()? = [range.start as u32, range.end as u32, 0, NONE];
        while waiting > 0 {
            waiting -= 1;
            let [start, end, mut bits, parent] = pending.get(waiting).copied().present()?;
            let k = self.len;
            let Some(link) = self.links.get_mut(k) else { return Ok(false) };
            *link = [start, end, 0, 0, end];
            self.len += 1;
            if parent != NONE {
                *self.links.get_mut(parent as usize).and_then(|link| link.get_mut(2)).present()? = k as u32;
            }
            let (from, to) = (start as usize, end as usize);
            // A cell is a square when it has been divided along x as often as along y. Others have more neighbours, for the same number of points.
            let most = if bits % 2 == 0 { leaf.saturating_mul(2) } else { leaf };
            if to - from <= most || waiting + 2 > PENDING {
                continue;
            }
            let words = words.get_mut(from..to).present()?;
            let middle = loop {
                if bits == 0 {
                    if !set_keys(words, point) {
                        break None;
                    }
                    by_20_bits(words, spare.get_mut(..words.len()).present()?, counts);
                    bits = 2 * BITS;
                }
                bits -= 1;
                let middle = words.partition_point(|word| word >> (32 + bits) & 1 == 0);
                if middle > 0 && middle < words.len() {
                    break Some(middle);
                }
            };
            if let Some(middle) = middle {
                let middle = start + middle as u32;
                let [right, left, ..] = pending.get_mut(waiting..).present()? else { return Err(Error::Internal) };
                (*right, *left) = ([middle, end, bits, k as u32], [start, middle, bits, NONE]);
                waiting += 2;
            }
        }
        for k in (first..self.len).rev() {
            let last = self.parts(k).map_or(k + 1, |[_, second]| self.last(second));
            *self.links.get_mut(k).and_then(|link| link.get_mut(3)).present()? = last as u32;
        }
        Ok(true)
    }

    /// Computes the geometry of all boxes from the points in their order, which a factor brings into units, and from the support of the sources, if they are any.
    pub fn fit(&mut self, (points, factor): (&[[T; 2]], T), reach: &dyn Fn(core::ops::Range<usize>) -> T) {
        for k in (0..self.len).rev() {
            let (mut least, mut most, mut farthest) = ([T::INFINITY; 2], [-T::INFINITY; 2], T::ZERO);
            if let Some([first, second]) = self.parts(k) {
                for part in [first, second] {
                    let [x, y, u, v, _, reach] = self.shapes.get(part).copied().present_or([T::ZERO; 6]);
                    least = [least[0].min(x), least[1].min(y)];
                    most = [most[0].max(u), most[1].max(v)];
                    farthest = farthest.max(reach);
                }
            } else {
                let range = self.points(k);
                for &[x, y] in points.get(range.clone()).present_or(&[]) {
                    least = [if x < least[0] { x } else { least[0] }, if y < least[1] { y } else { least[1] }];
                    most = [if x > most[0] { x } else { most[0] }, if y > most[1] { y } else { most[1] }];
                }
                least.iter_mut().chain(&mut most).for_each(|x| *x *= factor);
                farthest = reach(range);
            }
            if let Some(shape) = self.shapes.get_mut(k) {
                *shape = [least[0], least[1], most[0], most[1], T::ZERO, farthest];
            }
        }
        // From corners to centres. Radii are rounded up; those whose inverse would not be a number count as zero, at the cost of a relative 2^-1000 (f32: 2^-110) of the distance.
        let (slack, tiny) = (T::ONE + T::from_f64(8.0) * T::EPSILON, T::MIN_POSITIVE.ldexp(12));
        for shape in self.shapes.iter_mut().take(self.len) {
            let [x, y, u, v, _, reach] = *shape;
            // In a box of a few units in the last place the rounding of the centre matters.
            let (centre_x, centre_y) = (x + (u - x) * T::HALF, y + (v - y) * T::HALF);
            let (half_x, half_y) = ((u - centre_x).max(centre_x - x), (v - centre_y).max(centre_y - y));
            let scale = half_x.max(half_y);
            let radius = if scale < tiny {
                T::ZERO
            } else {
                let (a, b) = (half_x / scale, half_y / scale);
                (a * a + b * b).sqrt() * scale * slack
            };
            *shape = [centre_x, centre_y, half_x * slack, half_y * slack, radius, reach];
        }
    }

    /// Gives boxes that are points a radius, at most 2^-20 of that of the box around them: without one the local expansion of such a box holds no second derivatives.
    pub fn widen(&mut self) {
        let (part_of, tiny) = (T::ONE.ldexp(-20), T::MIN_POSITIVE.ldexp(12));
        let mut least = part_of;
        for k in 0..self.len {
            if let Some([.., radius, _]) = self.shapes.get_mut(k) {
                *radius = if *radius > T::ZERO { *radius } else { least };
                least = (*radius * part_of).max(tiny);
            }
            for part in self.parts(k).into_iter().flatten() {
                if let Some([.., radius, _]) = self.shapes.get_mut(part) {
                    *radius = radius.max(least);
                }
            }
        }
    }

    /// Gives the mass of coincident sources in leaves of more than `leaf` to the first of them, if all have the same support.
    pub fn merge(&mut self, leaf: usize, masses: &mut [T], reach: &dyn Fn(core::ops::Range<usize>) -> T) {
        for k in 0..self.len {
            let (range, [half_x, half_y]) = (self.points(k), self.shape(k).half);
            let same = half_x == T::ZERO && half_y == T::ZERO && self.parts(k).is_none();
            if range.len() <= leaf || !same {
                continue;
            }
            let of_all = reach(range.clone());
            if range.clone().any(|at| reach(at..at + 1) != of_all) {
                continue;
            }
            let mut sum = DoubleWord::ZERO;
            for mass in masses.get_mut(range.clone()).unwrap_or_default() {
                sum = sum.plus(core::mem::replace(mass, T::ZERO));
            }
            if let (Some(mass), Some([start, .., end])) = (masses.get_mut(range.start), self.links.get_mut(k)) {
                *mass = sum.hi;
                *end = *start + 1;
            }
        }
    }

    /// The largest boxes of at most so many points, and leaves, of the tree from box `k` on. Boxes above them go to `above` before any below them; it says whether to
    /// go on below.
    pub fn cut(&self, points: usize, mut above: impl FnMut(usize) -> bool, mut found: impl FnMut(usize)) {
        let mut k = 0;
        while k < self.len {
            if self.points(k).len() <= points || self.parts(k).is_none() || !above(k) {
                found(k);
                k = self.last(k).max(k + 1);
            } else {
                k += 1;
            }
        }
    }
}

/// Writes the keys of points into the high halves of their words: the cell of the smallest square around them. `false`: they coincide.
fn set_keys<T: Real>(words: &mut [u64], point: &dyn Fn(usize) -> [T; 2]) -> bool {
    let at = |word: u64| point((word & u64::from(u32::MAX)) as usize);
    let (mut least, mut most) = ([T::INFINITY; 2], [-T::INFINITY; 2]);
    for &word in &*words {
        let [x, y] = at(word);
        least = [if x < least[0] { x } else { least[0] }, if y < least[1] { y } else { least[1] }];
        most = [if x > most[0] { x } else { most[0] }, if y > most[1] { y } else { most[1] }];
    }
    let side = (most[0] - least[0]).max(most[1] - least[1]);
    if side <= T::ZERO {
        return false;
    }
    // A quotient, as the inverse of the side may be infinite.
    let cells = T::ONE.ldexp(BITS as i32);
    let cell = |x: T, least: T| (quotient(x - least, side) * cells).to_u32().min((1 << BITS) - 1);
    for word in words {
        let [x, y] = at(*word);
        let key = spread(cell(x, least[0])) | spread(cell(y, least[1])) << 1;
        *word = u64::from(key) << 32 | *word & u64::from(u32::MAX);
    }
    true
}

/// Ten bits, with a zero between them.
fn spread(x: u32) -> u32 {
    let x = (x | x << 8) & 0x00FF_00FF;
    let x = (x | x << 4) & 0x0F0F_0F0F;
    let x = (x | x << 2) & 0x3333_3333;
    (x | x << 1) & 0x5555_5555
}

/// Boxes for so many points in leaves of at most `leaf`: what uniform points need, in leaves of half as many, and 45 % more.
///
/// # Errors
/// [`Error::TooLarge`].
pub(super) fn boxes(points: usize, leaf: usize) -> Result<usize> {
    let leaves =
        points.checked_mul(29).and_then(|points| points.checked_div(leaf.saturating_mul(10))).ok_or(Error::TooLarge)?;
    leaves.checked_mul(2).and_then(|boxes| boxes.checked_add(64)).ok_or(Error::TooLarge)
}

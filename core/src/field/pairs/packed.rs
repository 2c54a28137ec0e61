//! Sources prepared for the engine: those with mass, scaled so that nothing overflows.
//!
//! Coordinates and masses are multiplied by powers of two, so that the largest of each is about 1: exact, and r^2 <= 4 D needs no check
//! for overflow in any inner loop. A coordinate that is tiny beside the largest may lose bits to underflow by that; it can matter only for pairs
//! closer than the least distance that lanes serve ([`super::close`]), and these are computed from the caller's own numbers ([`super::exact`]).
//!
//! Masses that span more than the exponent's range are divided into classes, each with a power of two of its own, and a target's
//! sums over different classes meet in true units. Products of a mass and a kernel's value then stay normal in each class.

use super::BLOCK;
use super::lanes::{Bounds, List, WIDE};
use crate::checked::Present;
use crate::error::{Error, Result};
use crate::field::Sources;
use crate::memory::Space;
use crate::real::Real;
use crate::simd::{Isa, MAX_LANES};

/// The most classes: f64's exponents from -1074 to 1023 in classes of 900, f32's from -149 to 127 in classes of 100.
pub(super) const CLASSES: usize = 3;

/// Powers of two that the scaled numbers were multiplied with.
#[derive(Clone, Copy, Debug)]
pub(in crate::field) struct Units<T> {
    /// A coordinate in these units is the true one times 2^position.
    pub position: i32,
    /// The same for masses of class 0.
    pub mass: i32,
    pub(super) position_factor: T,
}

/// Binary orders of magnitude of a class of masses.
pub(super) const fn class_width<T: Real>() -> i32 {
    if T::DIGITS > 24 { 900 } else { 100 }
}

/// 2^-this is the least r^2, in units, of the lanes' fast path: m over a product of two r^2 (f64: of four) and 1 / r^3 stay normal, f64's r^2 is in f32's range too
/// (where the 3D seed is made).
pub(super) const fn least_square_exponent<T: Real>() -> i32 {
    if T::DIGITS > 24 { 120 } else { 56 }
}

/// The least distance that lanes serve, in units.
pub(in crate::field) fn least_distance<T: Real>() -> T {
    T::ONE.ldexp(least_square_exponent::<T>() / -2)
}

/// 2^n, for |n| below the largest exponent.
pub(super) fn power_of_two<T: Real>(n: i32) -> T {
    T::ONE.ldexp(n)
}

/// 2^n as two factors in range, for |n| up to twice the largest exponent, to be multiplied one after the other.
pub(in crate::field) fn power_of_two_pair<T: Real>(n: i32) -> [T; 2] {
    let limit = T::MAX_EXPONENT - 2;
    let clamp = |n: i32| n.max(-limit).min(limit);
    let first = clamp(n);
    [power_of_two(first), power_of_two(clamp(n - first))]
}

/// The largest magnitude, or `start`.
pub(in crate::field) fn largest<T: Real>(start: T, numbers: &[T]) -> T {
    let larger = |most: T, x: T| if x.abs() > most { x.abs() } else { most };
    // Numbers that do not wait for each other.
    let (rows, rest) = numbers.as_chunks::<MAX_LANES>();
    let mut most = [start; MAX_LANES];
    for row in rows {
        most.iter_mut().zip(row).for_each(|(most, &x)| *most = larger(*most, x));
    }
    most.iter().chain(rest).fold(start, |most, &x| larger(most, x))
}

impl<T: Real> Units<T> {
    /// Units in which the largest length and mass, and the targets' coordinates, are at most about 1.
    pub fn of<const D: usize>([length, mass]: [T; 2], targets: &[[T; D]]) -> Self {
        Self::new(largest(length, targets.as_flattened()), mass)
    }

    /// Units in which the largest magnitudes are between 1/2 and 1 (0 has no magnitude: unit 1).
    #[allow(clippy::manual_clamp, reason = "where it is not inlined, clamp's check of its bounds is a way to panic")]
    pub fn new(largest_length: T, largest_mass: T) -> Self {
        let limit = T::MAX_EXPONENT - 2;
        let unit = |largest: T| largest.frexp().1.saturating_neg().max(-limit).min(limit);
        let (position, mass) = (unit(largest_length), unit(largest_mass));
        Self { position, mass, position_factor: power_of_two(position) }
    }

    /// Units in which a length is that in these times 2^`by`: for scales and for a kernel's numbers, not for coordinates.
    pub fn closer(self, by: i32) -> Self {
        Self { position: self.position.saturating_add(by), ..self }
    }

    /// A point in these units.
    #[inline(always)]
    pub fn point<const D: usize>(&self, x: &[T; D]) -> [T; D] {
        let mut point = *x;
        point.iter_mut().for_each(|x| *x *= self.position_factor);
        point
    }

    /// The class of a mass that is not zero, and the mass in the class's unit.
    #[inline(always)]
    fn mass(&self, m: T) -> (usize, T) {
        // Exponents of the largest masses are about 0 in units.
        let below = -self.mass - m.frexp().1;
        let class = if below < class_width::<T>() { 0 } else { 1 + usize::from(below >= 2 * class_width::<T>()) };
        (class, m.ldexp(self.class(class)))
    }

    /// A mass in a class's unit is the true one times 2^this.
    pub fn class(&self, class: usize) -> i32 {
        self.mass + class as i32 * class_width::<T>()
    }
}

/// The bounds of points; (largest, least) numbers for none.
#[inline]
pub(super) fn bounds_of<T: Real, const D: usize>(points: &[[T; D]]) -> Bounds<T, D> {
    let (mut least, mut most) = ([T::MAX; D], [-T::MAX; D]);
    for x in points {
        least.iter_mut().zip(x).for_each(|(least, &x)| *least = if x < *least { x } else { *least });
        most.iter_mut().zip(x).for_each(|(most, &x)| *most = if x > *most { x } else { *most });
    }
    [least, most]
}

/// The largest r^2 between points of two boxes, rounded up.
#[inline]
pub(super) fn farthest<T: Real, const D: usize>(a: &Bounds<T, D>, b: &Bounds<T, D>) -> T {
    let [a_least, a_most] = a;
    let [b_least, b_most] = b;
    let sides = a_least.iter().zip(a_most).zip(b_least.iter().zip(b_most));
    let square = sides.fold(T::ZERO, |sum, ((&al, &am), (&bl, &bm))| {
        let side = if bm - al > am - bl { bm - al } else { am - bl };
        sum + side * side
    });
    square * (T::ONE + T::from_f64(16.0) * T::EPSILON)
}

/// Sources with mass, class by class, each in the caller's order.
#[derive(Debug)]
pub(in crate::field) struct Packed<'w, T, const D: usize> {
    pub(in crate::field) positions: &'w mut [[T; D]],
    pub(in crate::field) masses: &'w mut [T],
    /// Of their core radii, if they have any, or vector strengths ([`super::PairKernel::core`]).
    cores: &'w mut [T],
    /// Vector strengths in units, if they have any; masses are then 1.
    pub(in crate::field) strengths: &'w mut [[T; D]],
    /// Which of the caller's sources each one is.
    pub(in crate::field) origins: &'w mut [u32],
    /// The bounds of each block, class by class.
    boxes: &'w mut [Bounds<T, D>],
    /// How many there are in each class.
    counts: [usize; CLASSES],
}

/// The sources of a class.
pub(in crate::field) struct Class<'a, T, const D: usize> {
    pub positions: &'a [[T; D]],
    pub masses: &'a [T],
    pub cores: &'a [T],
    pub strengths: &'a [[T; D]],
    pub origins: &'a [u32],
    boxes: &'a [Bounds<T, D>],
}

impl<'w, T: Real, const D: usize> Packed<'w, T, D> {
    /// The layout: room for every source, for its vector strength if it has one, and for its core radius if it has one or has a vector strength.
    ///
    /// # Errors
    /// [`Error::TooLarge`]: more than 2^32 sources.
    pub fn layout(space: &mut impl Space<'w>, n: usize, [radii, strengths]: [bool; 2]) -> Result<Self> {
        if u32::try_from(n).is_err() {
            return Err(Error::TooLarge);
        }
        Ok(Self {
            positions: space.try_array(n)?,
            masses: space.try_array(n)?,
            cores: space.try_array(if radii || strengths { n } else { 0 })?,
            strengths: space.try_array(if strengths { n } else { 0 })?,
            origins: space.try_array(n)?,
            // Each class may end in a block that is not full.
            boxes: space.try_array(n / BLOCK + CLASSES)?,
            counts: [0; CLASSES],
        })
    }

    /// The arrays of a workspace that another module has filled with `count` sources, in units and all in one class; computes what is kept of their core radii, which are
    /// `delta` where the sources have none.
    pub fn ordered(
        mut self,
        units: Units<T>,
        radii: Option<&[T]>,
        delta: T,
        count: usize,
        core: &dyn Fn(T) -> T,
    ) -> Self {
        self.counts = [count, 0, 0];
        self.fill_cores(units, radii, delta, core);
        self
    }

    /// Copies the sources with mass, scaled and grouped by class, and computes the bounds of blocks. `core` is applied to the squares of core radii
    /// in units, which are `delta` where the sources have none.
    pub fn fill(&mut self, units: Units<T>, sources: Sources<'_, T, D>, delta: T, core: &dyn Fn(T) -> T) {
        let Sources { positions, masses, radii, strengths, .. } = sources;
        if let Some(strengths) = strengths {
            self.fill_strengths(units, positions, strengths);
        }
        let with_mass = || masses.iter().zip(positions).enumerate().filter(|(_, (m, _))| **m != T::ZERO);
        self.counts = [if strengths.is_some() { self.counts[0] } else { 0 }, 0, 0];
        for (_, (&m, _)) in with_mass() {
            self.counts.get_mut(units.mass(m).0).into_iter().for_each(|count| *count += 1);
        }
        let [first, second, _] = self.counts;
        let mut next = [0, first, first + second];
        for (origin, (&m, x)) in with_mass() {
            let (class, mass) = units.mass(m);
            let Some(next) = next.get_mut(class) else { continue };
            let slots = (self.positions.get_mut(*next), self.masses.get_mut(*next), self.origins.get_mut(*next));
            if let (Some(to_x), Some(to_m), Some(to)) = slots {
                (*to_x, *to_m, *to) = (units.point(x), mass, origin as u32);
            }
            *next += 1;
        }
        self.fill_cores(units, radii, delta, core);
        let (mut boxes, mut rest) = (self.boxes.iter_mut(), &*self.positions);
        for &count in &self.counts {
            let (class, later) = rest.split_at_checked(count).unwrap_or((rest, &[]));
            rest = later;
            class.chunks(BLOCK).zip(&mut boxes).for_each(|(block, bounds)| *bounds = bounds_of(block));
        }
    }

    /// What is kept of the core radii.
    fn fill_cores(&mut self, units: Units<T>, radii: Option<&[T]>, delta: T, core: &dyn Fn(T) -> T) {
        let n = self.len();
        for (to, &origin) in self.cores.iter_mut().zip(self.origins.iter().take(n)) {
            let radius = radii.map_or(Some(&delta), |radii| radii.get(origin as usize)).copied().present_or(T::ZERO);
            let radius = radius.ldexp(units.position);
            *to = core(radius * radius);
        }
    }

    /// Those with vector strengths that are not zero, all in the class of the largest.
    fn fill_strengths(&mut self, units: Units<T>, positions: &[[T; D]], strengths: &[[T; D]]) {
        let some = strengths.iter().zip(positions).enumerate().filter(|(_, (s, _))| s.iter().any(|&s| s != T::ZERO));
        let slots = self.positions.iter_mut().zip(self.masses.iter_mut());
        let slots = slots.zip(self.strengths.iter_mut().zip(self.origins.iter_mut()));
        let mut count = 0;
        for ((origin, (s, x)), ((to_x, to_m), (to_s, to))) in some.zip(slots) {
            (*to_x, *to_m, *to_s, *to) = (units.point(x), T::ONE, s.map(|s| s.ldexp(units.mass)), origin as u32);
            count += 1;
        }
        self.counts = [count, 0, 0];
    }

    /// Sources with mass.
    pub fn len(&self) -> usize {
        self.counts.iter().sum()
    }

    /// The classes that have sources, with their numbers.
    pub fn classes(&self) -> impl Iterator<Item = (usize, Class<'_, T, D>)> {
        let (mut start, mut first_box) = (0, 0);
        self.counts.iter().enumerate().filter_map(move |(class, &count)| {
            let (range, boxes) = (start..start + count, first_box..first_box + count.div_ceil(BLOCK));
            (start, first_box) = (range.end, boxes.end);
            let found = Class {
                positions: self.positions.get(range.clone())?,
                masses: self.masses.get(range.clone())?,
                cores: if self.cores.is_empty() { &[] } else { self.cores.get(range.clone())? },
                strengths: if self.strengths.is_empty() { &[] } else { self.strengths.get(range.clone())? },
                origins: self.origins.get(range)?,
                boxes: self.boxes.get(boxes)?,
            };
            (count > 0).then_some((class, found))
        })
    }
}

impl<'a, T: Real, const D: usize> Class<'a, T, D> {
    /// Blocks of at most [`BLOCK`] sources, with their bounds, what [`super::near::Groups`] says of their range, and where they begin: of all sources, or of some ranges of
    /// them, for which the bounds are those of all points.
    pub fn blocks(&self, ranges: Option<&'a [[u32; 3]]>) -> Blocks<'a, T, D> {
        let (positions, masses, boxes) = (self.positions, self.masses, self.boxes);
        let end = if ranges.is_some() { 0 } else { positions.len() };
        Blocks {
            positions,
            masses,
            boxes,
            listed: ranges.is_some(),
            ranges: ranges.unwrap_or_default().iter(),
            at: 0,
            end,
            apart: false,
        }
    }
}

/// See [`Class::blocks`].
pub(in crate::field) struct Blocks<'a, T, const D: usize> {
    positions: &'a [[T; D]],
    masses: &'a [T],
    boxes: &'a [Bounds<T, D>],
    listed: bool,
    ranges: core::slice::Iter<'a, [u32; 3]>,
    at: usize,
    end: usize,
    apart: bool,
}

impl<'a, T: Real, const D: usize> Iterator for Blocks<'a, T, D> {
    type Item = (usize, (Bounds<T, D>, bool), List<'a, T, D>);

    #[inline(always)]
    fn next(&mut self) -> Option<Self::Item> {
        while self.at >= self.end {
            let &[from, to, apart] = self.ranges.next()?;
            (self.at, self.end, self.apart) = (from as usize, to as usize, apart == 1);
        }
        let start = self.at;
        self.at = (start + BLOCK).min(self.end);
        // Coordinates are at most 1 in units.
        let bounds = if self.listed { [[-T::TWO; D], [T::TWO; D]] } else { *self.boxes.get(start / BLOCK)? };
        Some((start, (bounds, self.apart), (self.positions.get(start..self.at)?, self.masses.get(start..self.at)?)))
    }
}

/// The targets of a register block in units.
pub(super) struct Targets<T, const D: usize> {
    /// One a lane; lanes beyond the last repeat it, so that what they sum stays in range.
    lanes: [[T; WIDE * MAX_LANES]; D],
    pub bounds: Bounds<T, D>,
}

impl<T: Real, const D: usize> Targets<T, D> {
    /// Of at least one and at most [`WIDE`] times [`MAX_LANES`] targets, for so many lanes. Not in line: it is compiled once for all instruction sets.
    #[inline(never)]
    pub fn new(units: Units<T>, targets: &[[T; D]], lanes: usize) -> Self {
        let mut points = [[T::ZERO; D]; WIDE * MAX_LANES];
        points.iter_mut().zip(targets).for_each(|(point, x)| *point = units.point(x));
        let (within, beyond) = points.split_at_mut_checked(targets.len()).present_or_default();
        let bounds = bounds_of(within);
        if let Some(last) = within.last() {
            beyond.fill(*last);
        }
        let mut of_lanes = [[T::ZERO; WIDE * MAX_LANES]; D];
        for (l, point) in points.iter().enumerate().take(lanes) {
            for (lanes, &x) in of_lanes.iter_mut().zip(point) {
                lanes.get_mut(l).into_iter().for_each(|lane| *lane = x);
            }
        }
        Self { lanes: of_lanes, bounds }
    }

    /// Numbers of the targets, one a lane, as a function makes them of their core radii in units; ones without radii. Not in line, as [`Targets::new`].
    #[inline(never)]
    pub fn cores(units: Units<T>, radii: &[T], core: &dyn Fn(T) -> T) -> [T; WIDE * MAX_LANES] {
        let mut cores = [T::ONE; WIDE * MAX_LANES];
        for (to, radius) in cores.iter_mut().zip(radii) {
            let radius = radius.ldexp(units.position);
            *to = core(radius * radius);
        }
        cores
    }

    /// The vector of this number.
    #[inline(always)]
    pub fn vector<I: Isa<T>>(&self, isa: I, number: usize) -> [I::V; D] {
        let mut vector = [isa.splat(T::ZERO); D];
        for (vector, lanes) in vector.iter_mut().zip(&self.lanes) {
            if let Some(lanes) = lanes.get(number * I::LANES..).and_then(|lanes| lanes.first_chunk()) {
                *vector = isa.load(lanes);
            }
        }
        vector
    }
}

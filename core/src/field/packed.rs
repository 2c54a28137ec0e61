//! Sources as the sum wants them: without the massless ones, and in units in which nothing overflows.
//!
//! Coordinates and masses are multiplied by powers of two, so that the largest of each is about 1: exact, and r^2 <= 4 D
//! needs no check for overflow in any inner loop. What such a scaling would bring near the underflow threshold (a
//! coordinate or mass that is tiny beside the largest, but not zero) is *wild*: it keeps its own units and takes the scaled
//! path, pair by pair. Between particles that are not wild every difference of coordinates is zero or normal.

use super::newtonian::BLOCK;
use crate::error::Result;
use crate::real::Real;
use crate::space::Space;

/// Powers of two that the scaled numbers were multiplied with.
#[derive(Clone, Copy, Debug)]
pub(super) struct Units<T> {
    /// A coordinate in these units is the true one times 2^position.
    pub position: i32,
    /// The same for masses.
    pub mass: i32,
    /// 2^position, 2^mass, and the magnitude below which a scaled number is wild.
    position_factor: T,
    mass_factor: T,
    least: T,
}

/// Below 2^-this a scaled coordinate or mass is wild. A coordinate's last bit is then above 2^-(this + digits), which is
/// normal.
const fn wild_exponent<T: Real>() -> i32 {
    if T::DIGITS > 24 { 900 } else { 100 }
}

/// 2^-this is the least r^2, in units, of the lanes' fast path: m / (r^2 s^2) and 1 / r^3 stay normal, f64's r^2 is in
/// f32's range too (where the 3D seed is made).
pub(super) const fn least_square_exponent<T: Real>() -> i32 {
    if T::DIGITS > 24 { 120 } else { 56 }
}

impl<T: Real> Units<T> {
    #[allow(clippy::manual_clamp, reason = "where it is not inlined, clamp's check of its bounds is a way to panic")]
    /// Units in which the largest magnitudes are between 1/2 and 1 (0 has no magnitude: unit 1).
    pub fn new(largest_length: T, largest_mass: T) -> Self {
        let limit = T::MAX_EXPONENT - 2;
        let unit = |largest: T| largest.frexp().1.saturating_neg().max(-limit).min(limit);
        let (position, mass) = (unit(largest_length), unit(largest_mass));
        Self {
            position,
            mass,
            position_factor: power_of_two(position),
            mass_factor: power_of_two(mass),
            least: power_of_two(-wild_exponent::<T>()),
        }
    }

    /// A point in these units, and whether it is wild.
    #[inline(always)]
    pub fn point<const D: usize>(&self, x: &[T; D]) -> ([T; D], bool) {
        let scaled = x.map(|x| x * self.position_factor);
        let wild = x.iter().zip(&scaled).any(|(&x, &s)| x != T::ZERO && s.abs() < self.least);
        (scaled, wild)
    }

    /// A point in these units, wild coordinates being zero.
    #[inline(always)]
    pub fn tame_point<const D: usize>(&self, x: &[T; D]) -> [T; D] {
        let mut point = *x;
        for x in &mut point {
            let scaled = *x * self.position_factor;
            *x = if scaled.abs() < self.least { T::ZERO } else { scaled };
        }
        point
    }

    /// A mass in these units, and whether it is wild.
    #[inline(always)]
    fn mass(&self, m: T) -> (T, bool) {
        let scaled = m * self.mass_factor;
        (scaled, scaled.abs() < self.least)
    }
}

/// 2^n, for |n| below the largest exponent.
pub(super) fn power_of_two<T: Real>(n: i32) -> T {
    T::ONE.ldexp(n)
}

/// The least and the largest coordinates of some points.
pub(super) type Bounds<T, const D: usize> = [[T; D]; 2];

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

/// Compacted sources. Tame ones come first, in units and in the caller's order; wild ones last, in reverse order, as the
/// caller gave them. Between them may be unused room.
#[derive(Debug)]
pub(super) struct Packed<'w, T, const D: usize> {
    positions: &'w mut [[T; D]],
    masses: &'w mut [T],
    boxes: &'w mut [Bounds<T, D>],
    tame: usize,
    wild: usize,
}

impl<'w, T: Real, const D: usize> Packed<'w, T, D> {
    /// The layout: room for every source.
    pub fn lay(space: &mut impl Space<'w>, n: usize) -> Result<Self> {
        Ok(Self {
            positions: space.array(n)?,
            masses: space.array(n)?,
            boxes: space.array(n / BLOCK + usize::from(!n.is_multiple_of(BLOCK)))?,
            tame: 0,
            wild: 0,
        })
    }

    /// Takes the sources in.
    pub fn fill(&mut self, units: Units<T>, positions: &[[T; D]], masses: &[T]) {
        let Self { positions: to_positions, masses: to_masses, boxes, tame, wild } = self;
        let mut room = to_positions.iter_mut().zip(to_masses.iter_mut());
        for (x, &m) in positions.iter().zip(masses).filter(|&(_, &m)| m != T::ZERO) {
            let ((point, far_out), (mass, light)) = (units.point(x), units.mass(m));
            let (slot, value, count) = if far_out || light {
                (room.next_back(), (*x, m), &mut *wild)
            } else {
                (room.next(), (point, mass), &mut *tame)
            };
            if let Some((to_x, to_m)) = slot {
                (*to_x, *to_m) = value;
                *count += 1;
            }
        }
        let tame = to_positions.get(..*tame).unwrap_or(&[]);
        for (bounds, block) in boxes.iter_mut().zip(tame.chunks(BLOCK)) {
            *bounds = bounds_of(block);
        }
    }

    /// Takes the sources in, wild masses and coordinates being zero; no bounds are made.
    pub fn fill_tame(&mut self, units: Units<T>, positions: &[[T; D]], masses: &[T]) {
        let mut room = self.positions.iter_mut().zip(self.masses.iter_mut());
        for (x, &m) in positions.iter().zip(masses) {
            let (mass, light) = units.mass(m);
            if light {
                continue;
            }
            if let Some((to_x, to_m)) = room.next() {
                (*to_x, *to_m) = (units.tame_point(x), mass);
                self.tame += 1;
            }
        }
    }

    /// Tame sources in blocks of [`BLOCK`], each with its bounds.
    pub fn blocks(&self) -> impl Iterator<Item = (&Bounds<T, D>, &[[T; D]], &[T])> {
        let (positions, masses) = self.tame();
        let blocks = positions.chunks(BLOCK).zip(masses.chunks(BLOCK));
        self.boxes.iter().zip(blocks).map(|(bounds, (positions, masses))| (bounds, positions, masses))
    }

    /// Sources with mass.
    pub fn len(&self) -> usize {
        self.tame + self.wild
    }

    /// Whether any source is wild.
    pub fn has_wild(&self) -> bool {
        self.wild > 0
    }

    /// Those in units: positions and masses.
    pub fn tame(&self) -> (&[[T; D]], &[T]) {
        (self.positions.get(..self.tame).unwrap_or(&[]), self.masses.get(..self.tame).unwrap_or(&[]))
    }

    /// Those as the caller gave them, in the caller's order.
    pub fn wild(&self) -> impl Iterator<Item = (&[T; D], T)> {
        self.positions.iter().rev().zip(self.masses.iter().rev().copied()).take(self.wild)
    }
}

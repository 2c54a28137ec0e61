//! The mesh: a rectangle divided into equal cells.

use crate::error::{Error, Result};
use crate::real::{Real, Scalar};

/// Most cells along an axis. Node numbers and their first moments are then exact in 64 bits.
pub const MAX_CELLS: usize = 1 << 20;
/// Corners are at most 2^-13 of the scalar's largest number. Outside particles count up to 2^10 sides away, so no distance overflows.
const HEADROOM: i32 = 13;
/// The longer side of a cell is at most 2^40 times the shorter one, because the equations contain the square of their ratio.
const LONGEST: i32 = 40;

/// A rectangle of `cells[0]` by `cells[1]` equal cells. Node `(i, j)`, `0 <= i <= cells[0]`, `0 <= j <= cells[1]`, is at
/// `lower + (i, j) * spacing`. Arrays over the nodes run along x first: node `(i, j)` is element `j (cells[0] + 1) + i`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mesh<T> {
    lower: [T; 2],
    upper: [T; 2],
    cells: [usize; 2],
}

impl<T: Real> Mesh<T> {
    /// The mesh on `[lower, upper]`.
    ///
    /// # Errors
    /// [`Error::NotFinite`]; [`Error::OutOfDomain`]: `upper` is not above `lower`, fewer than 2 cells along an axis, a corner beyond 2^-13 of
    /// the scalar's largest number, a mesh width below its normal range, or cells more than 2^40 times as long as wide;
    /// [`Error::TooLarge`]: more than [`MAX_CELLS`], or the number of nodes overflows.
    pub fn new(lower: [T; 2], upper: [T; 2], cells: [usize; 2]) -> Result<Self> {
        if !lower.iter().chain(&upper).all(|v| v.is_finite()) {
            return Err(Error::NotFinite);
        }
        let most = T::MAX.ldexp(-HEADROOM);
        for ((&l, &u), &n) in lower.iter().zip(&upper).zip(&cells) {
            if n < 2 || u <= l || l < -most || u > most || (u - l) / T::from_usize(n) < T::MIN_POSITIVE {
                return Err(Error::OutOfDomain);
            }
            if n > MAX_CELLS {
                return Err(Error::TooLarge);
            }
        }
        (cells[0] + 1).checked_mul(cells[1] + 1).ok_or(Error::TooLarge)?;
        let mesh = Self { lower, upper, cells };
        let [h, k] = mesh.spacing();
        if h.max(k).ldexp(-LONGEST) > h.min(k) { Err(Error::OutOfDomain) } else { Ok(mesh) }
    }

    /// The lower left corner.
    pub fn lower(&self) -> [T; 2] {
        self.lower
    }

    /// The upper right corner.
    pub fn upper(&self) -> [T; 2] {
        self.upper
    }

    /// Cells along x and y.
    pub fn cells(&self) -> [usize; 2] {
        self.cells
    }

    /// The number of nodes.
    pub fn nodes(&self) -> usize {
        (self.cells[0] + 1) * (self.cells[1] + 1)
    }

    /// The mesh widths along x and y.
    pub fn spacing(&self) -> [T; 2] {
        let [n, m] = self.cells.map(T::from_usize);
        [(self.upper[0] - self.lower[0]) / n, (self.upper[1] - self.lower[1]) / m]
    }

    /// The exponent of a power of two >= the longer side. This power is the length unit of second moments.
    pub(super) fn reach(&self) -> i32 {
        let [w, h] = [self.upper[0] - self.lower[0], self.upper[1] - self.lower[1]];
        w.max(h).frexp().1
    }

    /// The position of node (i, j). i and j may lie outside the mesh (ghost nodes).
    pub fn node(&self, i: isize, j: isize) -> [T; 2] {
        let [h, k] = self.spacing();
        [self.lower[0] + signed::<T>(i) * h, self.lower[1] + signed::<T>(j) * k]
    }

    /// Whether `x` is in the closed rectangle, lower <= x <= upper. Deposit and interpolation find a cell for exactly these positions.
    pub fn contains(&self, x: [T; 2]) -> bool {
        let within = |a: T, l: T, u: T| l <= a && a <= u;
        within(x[0], self.lower[0], self.upper[0]) && within(x[1], self.lower[1], self.upper[1])
    }

    /// `x` reflected at the walls until it is in the rectangle, and for each axis whether the number of reflections is odd.
    /// Points inside or on the border do not change.
    pub fn reflect(&self, x: [T; 2]) -> ([T; 2], [bool; 2]) {
        let fold = |a: T, l: T, u: T| {
            if l <= a && a <= u {
                return (a, false);
            }
            let width = u - l;
            // In sides of the mesh; the period is two sides.
            let g = (a - l) / width;
            let g = g - T::TWO * (g * T::HALF).floor();
            let (g, odd) = if g > T::ONE { (T::TWO - g, true) } else { (g, false) };
            ((l + g * width).max(l).min(u), odd)
        };
        let (a, odd_a) = fold(x[0], self.lower[0], self.upper[0]);
        let (b, odd_b) = fold(x[1], self.lower[1], self.upper[1]);
        ([a, b], [odd_a, odd_b])
    }
}

/// Exact, because |n| <= MAX_CELLS + 1.
fn signed<T: Real>(n: isize) -> T {
    T::from_i32(n as i32)
}

/// The mesh parameters for loops over particles, in f64 for both scalars. Only this type computes cells.
#[derive(Clone, Copy, Debug)]
pub(super) struct Locator {
    lower: [f64; 2],
    upper: [f64; 2],
    inverse: [f64; 2],
    cells: [f64; 2],
    pitch: f64,
}

/// 2^52. Adding it to a number in 0..2^51 rounds that to an integer and leaves the integer in the low bits.
const ROUND: f64 = 4_503_599_627_370_496.0;

/// Number of particles located together.
pub(super) const BLOCK: usize = 64;
/// The node number that marks a particle outside the mesh.
pub(super) const OUTSIDE: u64 = u64::MAX;

/// Locations of particles: the lower left node `j (nx + 1) + i` of the cell and the coordinates in the cell, 0 to 1 along each axis.
#[derive(Clone, Copy, Debug)]
pub(super) struct Places {
    pub node: [u64; BLOCK],
    pub x: [f64; BLOCK],
    pub y: [f64; BLOCK],
}

impl Places {
    pub(super) const NONE: Self = Self { node: [OUTSIDE; BLOCK], x: [0.0; BLOCK], y: [0.0; BLOCK] };
}

impl Locator {
    pub(super) fn new<T: Real>(mesh: &Mesh<T>) -> Self {
        let (l, u) = (mesh.lower.map(Scalar::to_f64), mesh.upper.map(Scalar::to_f64));
        let cells = mesh.cells.map(|n| n as f64);
        let inverse = [cells[0] / (u[0] - l[0]), cells[1] / (u[1] - l[1])];
        Self { lower: l, upper: u, inverse, cells, pitch: cells[0] + 1.0 }
    }

    /// Locates at most [`BLOCK`] particles.
    #[inline(always)]
    pub(super) fn places<T: Real>(&self, positions: &[[T; 2]], places: &mut Places) {
        let Places { node, x, y } = places;
        for (((node, x), y), &at) in node.iter_mut().zip(x).zip(y).zip(positions) {
            (*node, [*x, *y]) = self.place(at);
        }
    }

    /// The node and the coordinates in its cell. The coordinates decide what is inside, as in [`Mesh::contains`]. The quotient that
    /// gives the cell is rounded, may exceed the number of cells at the upper border, and is clamped to the mesh.
    ///
    /// Branch-free, so that the compiler can vectorise it. NaN counts as outside.
    #[inline(always)]
    pub(super) fn place<T: Real>(&self, x: [T; 2]) -> (u64, [f64; 2]) {
        let [x, y] = x.map(Scalar::to_f64);
        let ([lx, ly], [ux, uy]) = (self.lower, self.upper);
        let inside = (x >= lx) & (x <= ux) & (y >= ly) & (y <= uy);
        let (gx, gy) = ((x - lx) * self.inverse[0], (y - ly) * self.inverse[1]);
        let (gx, gy) = (within(gx, self.cells[0]), within(gy, self.cells[1]));
        let (cx, cy) = (cell(gx, self.cells[0]), cell(gy, self.cells[1]));
        let node = (cy * self.pitch + cx + ROUND).to_bits() & ((1 << 52) - 1);
        (if inside { node } else { OUTSIDE }, [gx - cx, gy - cy])
    }
}

/// `g` clamped to [0, cells]; 0 for NaN.
#[inline(always)]
fn within(g: f64, cells: f64) -> f64 {
    let g = if g > 0.0 { g } else { 0.0 };
    if g < cells { g } else { cells }
}

/// The cell that contains `g`; at the upper border the last one.
#[inline(always)]
fn cell(g: f64, cells: f64) -> f64 {
    let rounded = (g + ROUND) - ROUND;
    let floor = if rounded > g { rounded - 1.0 } else { rounded };
    if floor >= cells { cells - 1.0 } else { floor }
}

//! From the moments of a cell to the local expansion of another one of its level: a matrix for each step between cells.
//!
//! The kernel between two cells is a function of the difference alone: with the step R from source cell to target cell, in widths, K(w (R + v)) for v in a cube of half
//! width 1. It is interpolated there by products of Chebyshev polynomials, K = sum_k c_k T_k(v), cut at the least |k| < P for which what is left out is within the tolerance.
//! With v = (y - x) / 2 along each axis, y and x the coordinates of target and source in their cells, T_k((y - x) / 2) = sum_(d + a <= k) B_kda T_d(y) T_a(x) is exact, so that
//!
//! L_d = sum_a G_da M_a,    G_da = sum_k c_k B_k1d1a1 B_k2d2a2 B_k3d3a3.
//!
//! The matrix of a reflected step differs by signs alone. G_da is zero for |a + d| >= P; rows and columns are in order of |d| and |a|, so a row ends early.
//!
//! What is left out is known from the coefficients: where even the largest P is not enough (a mollifier's edge within the cube, a step over a great range of values), the pair of
//! cells is not summed in this way.

use super::basis::{Basis, MAX_ORDER};
use crate::checked::Present;
use crate::error::Result;
use crate::field::pairs::largest;
use crate::field::tree::levels::step_of;
use crate::field::tree::series::Pair;
use crate::memory::Space;
use crate::real::{Real, Scalar};
use crate::simd::{Isa, Job, MAX_LANES};

/// The most nodes along an axis.
pub(in crate::field::tree) const MAX_NODES: usize = 2 * MAX_ORDER;
/// What interpolation takes.
pub(in crate::field::tree) struct Nodes<'w, T> {
    pub n: usize,
    /// The nodes.
    pub at: &'w mut [T],
    /// From values at the nodes to coefficients: row k for c_k.
    to_coefficients: &'w mut [T],
    /// B_kda, by (k n + d) p + a.
    products: &'w mut [T],
}

impl<'w, T: Real> Nodes<'w, T> {
    /// Room for so many nodes, and a basis of this order.
    pub fn layout(space: &mut impl Space<'w>, n: usize, order: usize) -> Result<Self> {
        Ok(Self {
            n,
            at: space.try_array(n)?,
            to_coefficients: space.try_array(n * n)?,
            products: space.try_array(n * order * order)?,
        })
    }

    /// Fills the tables.
    pub fn prepare(&mut self, order: usize) {
        let (n, order) = (self.n.max(1), order.max(1));
        let cosine = |numerator: usize| Scalar::cos(core::f64::consts::PI * numerator as f64 / (2 * n) as f64);
        for (i, at) in self.at.iter_mut().enumerate() {
            *at = T::from_f64(cosine(2 * i + 1));
        }
        for (k, row) in self.to_coefficients.chunks_mut(n.max(1)).enumerate() {
            let weight = if k == 0 { 1.0 } else { 2.0 } / n as f64;
            for (i, to) in row.iter_mut().enumerate() {
                *to = T::from_f64(weight * cosine(k * (2 * i + 1) % (4 * n).max(1)));
            }
        }
        // T_(k+1)(v) = 2 v T_k(v) - T_(k-1)(v), 2 v = y - x, and y T_d = (T_(d+1) + T_|d-1|) / 2.
        const ROOM: usize = MAX_NODES + 1;
        let mut last = [[0.0_f64; ROOM]; ROOM];
        let mut next = [[0.0_f64; ROOM]; ROOM];
        last[0][0] = 1.0;
        let half_step = |from: &[[f64; ROOM]; ROOM]| {
            let mut to = [[0.0; ROOM]; ROOM];
            for (d, row) in from.iter().enumerate() {
                for (a, &c) in row.iter().enumerate().filter(|(_, c)| **c != 0.0) {
                    let mut add = |d: usize, a: usize, c: f64| {
                        to.get_mut(d).and_then(|row| row.get_mut(a)).into_iter().for_each(|to| *to += c);
                    };
                    // (y - x) T_d(y) T_a(x)
                    add(d + 1, a, 0.5 * c);
                    add(d.abs_diff(1), a, 0.5 * c);
                    add(d, a + 1, -0.5 * c);
                    add(d, a.abs_diff(1), -0.5 * c);
                }
            }
            to
        };
        for (k, table) in self.products.chunks_mut((order * order).max(1)).enumerate() {
            let now = if k == 0 { &last } else { &next };
            for (to, row) in table.chunks_mut(order.max(1)).zip(now) {
                to.iter_mut().zip(row).for_each(|(to, &c)| *to = T::from_f64(c));
            }
            if k == 0 {
                next = half_step(&last);
                next.as_flattened_mut().iter_mut().for_each(|c| *c *= 0.5);
            } else {
                let mut after = half_step(&next);
                for (to, &c) in after.as_flattened_mut().iter_mut().zip(last.as_flattened()) {
                    *to -= c;
                }
                (last, next) = (next, after);
            }
        }
    }

    /// Values at the nodes to coefficients, along each axis. `scratch` has the same length.
    fn interpolate(&self, values: &mut [T], scratch: &mut [T], dimension: usize) {
        along_axes(self.to_coefficients, (self.n, dimension), values, scratch);
    }

    /// B_kda.
    fn product(&self, order: usize, [k, d, a]: [usize; 3]) -> T {
        self.products.get((k * order + d) * order + a).copied().present_or(T::ZERO)
    }
}

/// Multiplies a square, or a cube, of n numbers along each axis by an n x n matrix along each axis. `scratch` has the same length.
pub(in crate::field::tree) fn along_axes<T: Real>(
    matrix: &[T],
    (n, dimension): (usize, usize),
    values: &mut [T],
    scratch: &mut [T],
) {
    let (mut pitch, n) = (1_usize, n.max(1));
    for _ in 0..dimension {
        scratch.fill(T::ZERO);
        let both = (pitch * n).max(1);
        for (to, from) in scratch.chunks_mut(both).zip(values.chunks(both)) {
            for (to, weights) in to.chunks_mut(pitch.max(1)).zip(matrix.chunks(n.max(1))) {
                for (from, &weight) in from.chunks(pitch.max(1)).zip(weights) {
                    to.iter_mut().zip(from).for_each(|(to, &x)| *to += weight * x);
                }
            }
        }
        values.iter_mut().zip(&*scratch).for_each(|(to, &x)| *to = x);
        pitch = (pitch * n).max(1);
    }
}

/// What errors of an interpolation are allowed.
#[derive(Clone, Copy, Debug)]
pub(in crate::field::tree) struct Allowed<T> {
    /// Of the values and of the slopes, in root mean square, relative to their size in the cube, or to `mean` if that is larger. (Of both, whatever is wanted, so that an output does not
    /// depend on what else is.)
    pub share: T,
    /// The mean sizes of values and slopes over all pairs; slopes per width.
    pub mean: [T; 2],
}

/// What is known of an operator.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::field::tree) enum Quality {
    /// The kernel is zero in the whole cube.
    Zero,
    /// The least P.
    Order(usize),
    /// No P is enough.
    Rough,
}

/// Replaces the kernel's values at the nodes by coefficients, and finds the least P. `corner` is the value where source and target are closest, at no node: a kernel with an edge may be
/// smooth at all nodes and not there. `scratch` has the length of the values.
pub(in crate::field::tree) fn interpolate<T: Real>(
    nodes: &Nodes<'_, T>,
    basis: &Basis<'_, T>,
    (class, corner): (usize, T),
    (values, scratch): (&mut [T], &mut [T]),
    allowed: &Allowed<T>,
) -> Quality {
    if !(corner.is_finite() && values.iter().all(|x| x.is_finite())) {
        return Quality::Rough;
    }
    if values.iter().all(|&x| x == T::ZERO) {
        return if corner == T::ZERO { Quality::Zero } else { Quality::Rough };
    }
    // In units in which squares are in range.
    let exponent = largest(allowed.mean[0].max(allowed.mean[1]), values).frexp().1;
    let scaled = |x: T| x.ldexp(exponent.saturating_neg());
    nodes.interpolate(values, scratch, basis.dimension);
    // The squares of what each shell of |k| adds to the mean squares of value and slope.
    let mut shells = [[T::ZERO; 2]; 2 * MAX_NODES];
    let (n, mut at_corner) = (nodes.n.max(1), T::ZERO);
    for (number, &c) in values.iter().enumerate() {
        let (k, c) = ([number % n, number / n % n, number / (n * n).max(1)], scaled(c));
        let square: usize = k.iter().map(|k| k * k).sum();
        let flat = k.iter().fold(T::ONE, |half, &k| if k > 0 { half * T::HALF } else { half });
        if let Some([value, slope]) = shells.get_mut(T::from_usize(square).sqrt().to_u32() as usize) {
            *value += c * c * flat;
            *slope += c * c * flat * T::from_usize(2 * square);
        }
        at_corner += k.iter().zip(step_of(class)).fold(c, |c, (&k, step)| c * at_closest(k, step));
    }
    let total = shells.iter().fold([T::ZERO; 2], |[u, v], [value, slope]| [u + *value, v + *slope]);
    let limit = |own: T, mean: T| allowed.share * own.sqrt().max(scaled(mean));
    let limits = [limit(total[0], allowed.mean[0]), limit(total[1], allowed.mean[1])];
    if (at_corner - scaled(corner)).abs() > T::from_f64(CORNER) * limits[0] {
        return Quality::Rough;
    }
    let (mut left, mut order) = ([T::ZERO; 2], shells.len());
    for [value, slope] in shells.iter().rev() {
        left = [left[0] + *value, left[1] + *slope];
        if left[0] > limits[0] * limits[0] || left[1] > limits[1] * limits[1] {
            break;
        }
        order -= 1;
    }
    if order > most_shells(basis.order).min(n) { Quality::Rough } else { Quality::Order(order.max(1)) }
}

/// T_k where source and target are closest along an axis, so many steps of which are between their cells: at v = -1, or at 0 if there is none.
fn at_closest<T: Real>(k: usize, step: usize) -> T {
    match (step, k % 4) {
        (0, 1 | 3) => T::ZERO,
        (0, 2) | (1.., 1 | 3) => -T::ONE,
        _ => T::ONE,
    }
}

/// The point of the cube of a step where source and target are closest, in widths.
pub(in crate::field::tree) fn closest(class: usize) -> [usize; 3] {
    step_of(class).map(|step| step.saturating_sub(1))
}

/// The largest error at the closest point, relative to that allowed in root mean square.
const CORNER: f64 = 16.0;

/// The largest P for a basis of this order: beyond, there is nothing in it.
pub(in crate::field::tree) fn most_shells(order: usize) -> usize {
    2 * order - 1
}

/// A matrix: blocks of [`MAX_LANES`] rows, and in each one column after the other.
pub(in crate::field::tree) struct Matrix<'a, T> {
    pub numbers: &'a [T],
    /// How many columns each block has.
    pub columns: &'a [u16],
}

/// Numbers of a matrix for a basis, and its blocks.
pub(in crate::field::tree) fn matrix_size(n: usize) -> Option<(usize, usize)> {
    let blocks = n.div_ceil(MAX_LANES);
    // Vectors are loaded from within a block's columns, so the last one needs room behind it.
    Some((blocks.checked_mul(MAX_LANES)?.checked_mul(n)?.checked_add(MAX_LANES)?, blocks))
}

/// Writes the matrix of the coefficients `c`, cut at |k| < P.
pub(in crate::field::tree) fn fill<T: Real>(
    nodes: &Nodes<'_, T>,
    basis: &Basis<'_, T>,
    (c, cut): (&[T], usize),
    (numbers, columns): (&mut [T], &mut [u16]),
) -> Result<()> {
    let (n, order, len) = (nodes.n.max(1), basis.order, basis.exponents.len());
    let limit = |axis: usize| if axis < basis.dimension { order } else { 1 };
    let size = len * MAX_LANES;
    columns.fill(0);
    numbers.fill(T::ZERO);
    let mut of_z = [T::ZERO; MAX_NODES * MAX_NODES];
    let planes = if basis.dimension > 2 { n } else { 1 };
    let lines = if basis.dimension > 1 { n } else { 1 };
    let square = cut * cut;
    for dz in 0..limit(2) {
        for az in (0..limit(2)).take_while(|az| dz + az < cut) {
            let left = square - (dz + az) * (dz + az);
            // Over k_3, for each k_1 and k_2.
            let plane = of_z.get_mut(..n * lines).present()?;
            plane.fill(T::ZERO);
            for kz in (dz + az..planes.min(cut)).step_by(2) {
                let factor = nodes.product(order, [kz, dz, az]);
                let from = c.get(kz * n * lines..).present()?;
                let room = square - kz * kz;
                for (ky, (to, from)) in plane.chunks_mut(n.max(1)).zip(from.chunks(n.max(1))).enumerate() {
                    let Some(room) = room.checked_sub(ky * ky).filter(|&room| room > 0) else { break };
                    let some = to.iter_mut().zip(from).enumerate().take_while(|(kx, _)| kx * kx < room);
                    some.for_each(|(_, (to, &c))| *to += factor * c);
                }
            }
            for dy in 0..limit(1) {
                for ay in (0..limit(1)).take_while(|ay| (dy + ay) * (dy + ay) < left) {
                    let left = left - (dy + ay) * (dy + ay);
                    let mut of_y = [T::ZERO; MAX_NODES];
                    for ky in (dy + ay..lines.min(cut)).step_by(2) {
                        let factor = nodes.product(order, [ky, dy, ay]);
                        let from = plane.get(ky * n..).present()?;
                        of_y.iter_mut().zip(from).take(n).for_each(|(to, &c)| *to += factor * c);
                    }
                    for dx in 0..order {
                        let Some(row) = basis.rank([dx, dy, dz]) else { break };
                        for ax in (0..order).take_while(|ax| (dx + ax) * (dx + ax) < left) {
                            let Some(column) = basis.rank([ax, ay, az]) else { break };
                            let mut sum = T::ZERO;
                            for (kx, &c) in of_y.iter().enumerate().take(n).skip(dx + ax).step_by(2) {
                                sum += nodes.product(order, [kx, dx, ax]) * c;
                            }
                            let block = row / MAX_LANES;
                            let last = columns.get_mut(block).present()?;
                            *last = (*last).max(column as u16 + 1);
                            let at = block * size + column * MAX_LANES + row % MAX_LANES;
                            *numbers.get_mut(at).present()? = sum;
                        }
                    }
                }
            }
        }
    }
    Ok(())
}

/// Adds the products of a matrix and moments to local expansions: lanes are rows.
pub(in crate::field::tree) struct Apply<'a, 'w, T> {
    pub basis: &'a Basis<'w, T>,
    pub matrix: Matrix<'a, T>,
    /// The pairs: the source cell, the target cell counted from the first of `to`, and the axes along which the step is negative.
    pub pairs: &'a [Pair],
    pub from: &'a [T],
    pub to: &'a mut [T],
    /// Room for moments of [`basis::TOGETHER`](super::basis::TOGETHER) cells.
    pub scratch: &'a mut [T],
}

impl<T: Real> Job<T> for Apply<'_, '_, T> {
    type Out = ();

    #[inline(always)]
    fn run<I: Isa<T>>(self, isa: I) {
        // The other forms are not compiled.
        if const { I::LANES == 16 } {
            self.tiles::<I, 1, 6>(isa);
        } else if const { I::LANES == 8 } {
            self.tiles::<I, 2, 6>(isa);
        } else if const { I::LANES == 4 } {
            self.tiles::<I, 4, 3>(isa);
        } else {
            self.tiles::<I, 8, 1>(isa);
        }
    }
}

impl<T: Real> Apply<'_, '_, T> {
    /// The products, `V` vectors of rows and `C` cells at a time.
    #[inline(always)]
    fn tiles<I: Isa<T>, const V: usize, const C: usize>(self, isa: I) {
        let Self { basis, matrix, pairs, from, to, scratch } = self;
        if const { V * I::LANES > MAX_LANES } {
            return;
        }
        let (stride, size) = (basis.stride.max(1), basis.exponents.len() * MAX_LANES);
        for pairs in pairs.chunks(C) {
            for (column, &[source, _, axes]) in scratch.chunks_mut(stride).zip(pairs) {
                let moments = from.get(source as usize * stride..).present_or(&[]);
                let signs = basis.signs(axes as usize);
                column.iter_mut().zip(moments.iter().zip(signs)).for_each(|(to, (&m, &sign))| *to = m * sign);
            }
            let mut columns: [&[T]; C] = [&[]; C];
            for (column, moments) in columns.iter_mut().zip(scratch.chunks(stride)) {
                *column = moments;
            }
            for (block, &n) in matrix.columns.iter().enumerate() {
                let numbers = matrix.numbers.get(block * size..).present_or(&[]);
                let sums = tile::<T, I, V, C>(isa, numbers, &columns, usize::from(n));
                for (sums, &[_, target, axes]) in sums.iter().zip(pairs) {
                    let start = block * MAX_LANES;
                    let to = to.get_mut(target as usize * stride + start..).unwrap_or_default();
                    let signs = basis.signs(axes as usize).get(start..).unwrap_or_default();
                    for (v, &sum) in sums.iter().enumerate() {
                        let sum = isa.store(sum);
                        let lanes = to.iter_mut().zip(signs).skip(v * I::LANES).zip(&sum).take(I::LANES);
                        lanes.for_each(|((to, &sign), &sum)| *to += sum * sign);
                    }
                }
            }
        }
    }
}

/// The products of a block of rows with some columns of numbers.
#[inline(always)]
fn tile<T: Real, I: Isa<T>, const V: usize, const C: usize>(
    isa: I,
    numbers: &[T],
    columns: &[&[T]; C],
    n: usize,
) -> [[I::V; V]; C] {
    let mut sums = [[isa.splat(T::ZERO); V]; C];
    let mut rows: [&[[T; MAX_LANES]]; V] = [&[]; V];
    for (v, rows) in rows.iter_mut().enumerate() {
        *rows = numbers.get(v * I::LANES..).unwrap_or_default().as_chunks().0.get(..n).unwrap_or_default();
    }
    let mut some = *columns;
    some.iter_mut().for_each(|column| *column = column.get(..n).unwrap_or_default());
    for a in 0..n {
        let mut row = [isa.splat(T::ZERO); V];
        for (row, rows) in row.iter_mut().zip(&rows) {
            *row = rows.get(a).map_or(*row, |lanes| isa.load(lanes));
        }
        for (sums, column) in sums.iter_mut().zip(&some) {
            let x = isa.splat(column.get(a).copied().unwrap_or(T::ZERO));
            for (sum, &row) in sums.iter_mut().zip(&row) {
                *sum = isa.mul_add(row, x, *sum);
            }
        }
    }
    sums
}

//! Products of Chebyshev polynomials on a cell, and the operators within the tree.
//!
//! In a cell with centre c and width w the coordinates are x = 2 (y - c) / w, and the basis is T_a(x) = T_a1(x_1) T_a2(x_2) T_a3(x_3) for all exponents a with |a| < p in the
//! Euclidean norm. A smooth function's coefficients fall with that norm, whatever its direction.
//!
//! * The *moments* of a cell's sources are M_a = sum_j m_j T_a(x_j).
//! * Its *local expansion* is a field sum_d L_d T_d(x).
//!
//! On the way to a larger cell, T_a((x + s) / 2) = sum_(b <= a) C_ab T_b(x) along each axis, s = 1 or -1, is exact: moments of the parts add up to those of the whole, and a
//! local expansion of the whole is one of each part. The module `operators` leads from moments to local expansions.

use crate::checked::Present;
use crate::error::Result;
use crate::field::tree::series::{Frame, Pair, Series, Targets, load_points};
use crate::memory::Space;
use crate::real::Real;
use crate::simd::{BlockJob, Isa, Job, Level, Loops, MAX_LANES, with_simd};
use crate::sort;

/// The largest p.
pub(in crate::field::tree) const MAX_ORDER: usize = 20;

/// Source cells that an operator takes at a time, at most.
pub(in crate::field::tree) const TOGETHER: usize = 6;

/// The basis.
pub(in crate::field::tree) struct Basis<'w, T> {
    pub dimension: usize,
    /// p.
    pub order: usize,
    /// The exponents in order of their norm, with its square.
    pub exponents: &'w mut [[u16; 4]],
    /// The number of each exponent in that order, by a_1 + p a_2 + p^2 a_3; [`OUTSIDE`] for one that is not in the basis.
    ranks: &'w mut [u16],
    /// Rows of equal a_2 and a_3: these, and how many a_1 there are.
    rows: &'w mut [[u8; 4]],
    /// The numbers of the exponents, row by row.
    by_rows: &'w mut [u16],
    /// C_ab by a p + b, and by b p + a, for s = -1; the same for s = 1.
    shifts: &'w mut [T],
    /// The signs of all T_a under reflections, a row for each set of axes.
    signs: &'w mut [T],
    /// The length of a row of signs, of moments and of local expansions.
    pub stride: usize,
}

/// No number of an exponent.
const OUTSIDE: u16 = u16::MAX;

/// Exponents with |a| < p.
pub(in crate::field::tree) fn count(dimension: usize, order: usize) -> usize {
    each_exponent(dimension, order).filter(|e| usize::from(e[3]) < order * order).count()
}

/// All exponents below p along each axis, a_1 first, with the squares of their norms.
fn each_exponent(dimension: usize, order: usize) -> impl Iterator<Item = [u16; 4]> {
    let limit = move |axis: usize| if axis < dimension { order as u16 } else { 1 };
    (0..limit(2)).flat_map(move |c| {
        (0..limit(1)).flat_map(move |b| (0..limit(0)).map(move |a| [a, b, c, a * a + b * b + c * c]))
    })
}

/// The cube of exponents.
fn cube(dimension: usize, order: usize) -> usize {
    order * if dimension > 1 { order } else { 1 } * if dimension > 2 { order } else { 1 }
}

impl<'w, T: Real> Basis<'w, T> {
    /// Room for a basis.
    pub fn layout(space: &mut impl Space<'w>, dimension: usize, order: usize) -> Result<Self> {
        let (n, cube) = (count(dimension, order), cube(dimension, order));
        let stride = n.next_multiple_of(MAX_LANES);
        Ok(Self {
            dimension,
            order,
            exponents: space.try_array(n)?,
            ranks: space.try_array(cube)?,
            rows: space.try_array(cube / order.max(1))?,
            by_rows: space.try_array(n)?,
            shifts: space.try_array(4 * order * order)?,
            signs: space.try_array(stride << dimension)?,
            stride,
        })
    }

    /// Fills the tables.
    pub fn prepare(&mut self) -> Result<()> {
        let order = self.order.max(1);
        let within = move |e: &[u16; 4]| usize::from(e[3]) < order * order;
        let dimension = self.dimension;
        let all = || each_exponent(dimension, order).filter(within);
        let mut starts = [0_u32; MAX_ORDER * MAX_ORDER];
        for e in all() {
            *starts.get_mut(usize::from(e[3])).present()? += 1;
        }
        sort::words::starts(&mut starts);
        for e in all() {
            let place = starts.get_mut(usize::from(e[3])).present()?;
            *self.exponents.get_mut(*place as usize).present()? = e;
            *place += 1;
        }
        self.ranks.fill(OUTSIDE);
        for (rank, &[a, b, c, _]) in self.exponents.iter().enumerate() {
            let at = usize::from(a) + order * (usize::from(b) + order * usize::from(c));
            *self.ranks.get_mut(at).present()? = rank as u16;
        }
        let mut by_rows = self.by_rows.iter_mut();
        for (row, (number, ranks)) in self.rows.iter_mut().zip(self.ranks.chunks(order.max(1)).enumerate()) {
            let inside = ranks.iter().take_while(|&&rank| rank != OUTSIDE);
            *row = [(number % order.max(1)) as u8, (number / order.max(1)) as u8, inside.clone().count() as u8, 0];
            inside.zip(&mut by_rows).for_each(|(&rank, to)| *to = rank);
        }
        // T_(a+1)(u) = 2 u T_a(u) - T_(a-1)(u), and 2 u = x + 1; for x - 1 signs alternate with a + b.
        self.shifts.fill(T::ZERO);
        let (backward, forward) = self.shifts.split_at_mut_checked(2 * order * order).present()?;
        let (table, transposed) = forward.split_at_mut_checked(order * order).present()?;
        for a in 0..order {
            let (before, rest) = table.split_at_mut_checked(a * order).present()?;
            let row = rest.get_mut(..order).present()?;
            let Some(last) = a.checked_sub(1).and_then(|last| before.get(last * order..)) else {
                *row.first_mut().present()? = T::ONE;
                continue;
            };
            let scale = if a == 1 { T::HALF } else { T::ONE };
            for (b, &c) in last.iter().enumerate().take(a) {
                // x T_b = (T_(b+1) + T_|b-1|) / 2
                *row.get_mut(b).present()? += scale * c;
                *row.get_mut(b + 1).present()? += scale * T::HALF * c;
                *row.get_mut(b.abs_diff(1)).present()? += scale * T::HALF * c;
            }
            let earlier = a.checked_sub(2).and_then(|earlier| before.get(earlier * order..)).unwrap_or_default();
            row.iter_mut().zip(earlier).for_each(|(to, &c)| *to -= c);
        }
        for (at, &c) in table.iter().enumerate() {
            let (a, b) = (at / order.max(1), at % order.max(1));
            let other = if (a + b) % 2 == 1 { -c } else { c };
            *transposed.get_mut(b * order + a).present()? = c;
            *backward.get_mut(at).present()? = other;
            *backward.get_mut((order + b) * order + a).present()? = other;
        }
        for (axes, row) in self.signs.chunks_mut(self.stride.max(1)).enumerate() {
            row.fill(T::ZERO);
            for (to, exponent) in row.iter_mut().zip(&*self.exponents) {
                let odd = exponent.iter().enumerate().take(3).filter(|(axis, a)| axes >> axis & 1 == 1 && **a % 2 == 1);
                *to = if odd.count() % 2 == 1 { -T::ONE } else { T::ONE };
            }
        }
        Ok(())
    }

    /// The number of an exponent.
    pub fn rank(&self, [a, b, c]: [usize; 3]) -> Option<usize> {
        let order = self.order;
        let inside = a < order && b < order && c < order;
        let rank = self.ranks.get(a + order * (b + order * c)).filter(|&&rank| inside && rank != OUTSIDE)?;
        Some(usize::from(*rank))
    }

    /// The signs of all T_a under reflection of a set of axes, one bit each.
    pub fn signs(&self, axes: usize) -> &[T] {
        self.signs.get(axes * self.stride..).and_then(|rest| rest.get(..self.stride)).present_or(&[])
    }

    /// The matrix along an axis, and the same transposed, to the larger cell, or to its part (`down`).
    fn shift_along(&self, forward: bool, down: bool) -> [&[T]; 2] {
        let size = self.order * self.order;
        let table = |transposed: bool| {
            let number = 2 * usize::from(forward) + usize::from(transposed);
            self.shifts.get(number * size..).and_then(|rest| rest.get(..size)).present_or(&[])
        };
        [table(down), table(!down)]
    }

    /// Adds the moments of a part to those of the cell around it, or the local expansion of a cell to that of its part (`down`); `axes`: those along which the part is the upper half.
    /// `scratch`: two cubes.
    pub fn shift_one(&self, axes: u32, down: bool, (from, to): (&[T], &mut [T]), scratch: &mut [T], level: Level) {
        let (mut a, rest) = scratch.split_at_mut_checked(self.ranks.len()).unwrap_or_default();
        let mut b = rest.get_mut(..self.ranks.len()).unwrap_or_default();
        for (to, &rank) in a.iter_mut().zip(&*self.ranks) {
            *to = from.get(usize::from(rank)).copied().filter(|_| rank != OUTSIDE).unwrap_or(T::ZERO);
        }
        let mut pitch = 1;
        for axis in 0..self.dimension {
            let [matrix, transposed] = self.shift_along(axes >> axis & 1 == 1, down);
            b.fill(T::ZERO);
            with_simd(level, Along { order: self.order, pitch, matrix, transposed, from: &*a, to: &mut *b });
            core::mem::swap(&mut a, &mut b);
            pitch *= self.order;
        }
        for (&x, &rank) in a.iter().zip(&*self.ranks) {
            to.get_mut(usize::from(rank)).into_iter().for_each(|to| *to += x);
        }
    }
}

impl<T: Real> Series<T> for Basis<'_, T> {
    fn stride(&self) -> usize {
        self.stride
    }

    fn scratch(&self) -> usize {
        scratch(self.dimension, self.order)
    }

    fn moments(
        &self,
        (points, masses): (&[T], &[T]),
        frame: Frame<T>,
        (to, scratch): (&mut [T], &mut [T]),
        level: Level,
    ) {
        let sums = scratch.as_chunks_mut().0.get_mut(..self.exponents.len()).unwrap_or_default();
        level.run(Moments { basis: self, points, masses, frame, sums, to });
    }

    fn shift(&self, down: bool, pairs: &[Pair], (from, to, scratch): (&[T], &mut [T], &mut [T]), level: Level) {
        for &[source, target, axes] in pairs {
            let from = from.get(source as usize * self.stride..).and_then(|rest| rest.get(..self.stride));
            let to = to.get_mut(target as usize * self.stride..).and_then(|rest| rest.get_mut(..self.stride));
            if let (Some(from), Some(to)) = (from, to) {
                self.shift_one(axes, down, (from, to), scratch, level);
            }
        }
    }

    fn values(&self, from: &[T], to: Targets<'_, T>, scratch: &mut [T], level: Level) {
        level.run(Values { basis: self, from, to, scratch });
    }
}

/// Numbers of scratch that a basis needs.
pub(in crate::field::tree) fn scratch(dimension: usize, order: usize) -> usize {
    let terms = count(dimension, order);
    let (sums, cubes) = (terms * MAX_LANES, 2 * cube(dimension, order));
    let columns = TOGETHER * terms.next_multiple_of(MAX_LANES);
    sums.max(cubes).max(columns)
}

/// Adds the products of a matrix and the numbers along an axis, which are `pitch` apart.
struct Along<'a, T> {
    order: usize,
    pitch: usize,
    matrix: &'a [T],
    transposed: &'a [T],
    from: &'a [T],
    to: &'a mut [T],
}

impl<T: Real> Loops for Along<'_, T> {
    type Out = ();

    #[inline(always)]
    fn run(self) {
        let Self { order, pitch, matrix, transposed, from, to } = self;
        let both = (pitch * order).max(1);
        for (to, from) in to.chunks_mut(both).zip(from.chunks(both)) {
            // The loop inside runs over what lies next to each other in memory.
            if pitch == 1 {
                for (&x, column) in from.iter().zip(transposed.chunks(order.max(1))) {
                    to.iter_mut().zip(column).for_each(|(to, &c)| *to += c * x);
                }
                continue;
            }
            for (to, row) in to.chunks_mut(pitch.max(1)).zip(matrix.chunks(order.max(1))) {
                for (from, &c) in from.chunks(pitch.max(1)).zip(row).filter(|(_, c)| **c != T::ZERO) {
                    to.iter_mut().zip(from).for_each(|(to, &x)| *to += c * x);
                }
            }
        }
    }
}

/// T_k of the vectors of a coordinate, for all k in use.
type Polynomials<V, const N: usize> = [[V; N]; MAX_ORDER];

/// T_k(x), and its derivatives if they are wanted.
#[inline(always)]
fn polynomials<T: Real, I: Isa<T>, const N: usize>(
    isa: I,
    x: &[I::V; N],
    order: usize,
    slopes: bool,
) -> [Polynomials<I::V, N>; 2] {
    let (zero, one) = (isa.splat(T::ZERO), isa.splat(T::ONE));
    let mut all = [[[zero; N]; MAX_ORDER]; 2];
    let [values, derivatives] = &mut all;
    // 2 x, T_k and T_(k+1), and their derivatives.
    let mut states = [(zero, [one; 2], [zero, one]); N];
    for ((twice, [_, next], _), &x) in states.iter_mut().zip(x) {
        (*twice, *next) = (isa.add(x, x), x);
    }
    for (value, derivative) in values.iter_mut().zip(derivatives).take(order) {
        let slots = value.iter_mut().zip(derivative);
        for ((twice, [last, next], [last_slope, next_slope]), (value, derivative)) in states.iter_mut().zip(slots) {
            *value = *last;
            (*last, *next) = (*next, isa.sub(isa.mul(*twice, *next), *last));
            if slopes {
                *derivative = *last_slope;
                // T_(k+2)' = 2 T_(k+1) + 2 x T_(k+1)' - T_k'; T_(k+1) is now `last`.
                let sum = isa.mul_add(*twice, *next_slope, isa.add(*last, *last));
                (*last_slope, *next_slope) = (*next_slope, isa.sub(sum, *last_slope));
            }
        }
    }
    all
}

/// Adds the moments of sources: lanes are sources.
pub(in crate::field::tree) struct Moments<'a, 'w, T> {
    pub basis: &'a Basis<'w, T>,
    pub points: &'a [T],
    pub masses: &'a [T],
    pub frame: Frame<T>,
    pub sums: &'a mut [[T; MAX_LANES]],
    pub to: &'a mut [T],
}

impl<T: Real> Job<T> for Moments<'_, '_, T> {
    type Out = ();

    #[inline(always)]
    fn run<I: Isa<T>>(self, isa: I) {
        isa.in_blocks(self);
    }
}

impl<T: Real> BlockJob<T> for Moments<'_, '_, T> {
    type Out = ();

    #[inline(always)]
    fn run<I: Isa<T>, const N: usize>(self, isa: I) {
        let Self { basis, points, masses, frame, sums, to } = self;
        let zero = isa.splat(T::ZERO);
        sums.iter_mut().for_each(|sum| *sum = [T::ZERO; MAX_LANES]);
        let each = N * I::LANES;
        for (points, masses) in points.chunks((each * basis.dimension).max(1)).zip(masses.chunks(each)) {
            let [x, y, z] = load_points::<T, I, N>(isa, points, basis.dimension, &frame);
            let [x, _] = polynomials(isa, &x, basis.order, false);
            let [y, _] = polynomials(isa, &y, if basis.dimension > 1 { basis.order } else { 1 }, false);
            let [z, _] = polynomials(isa, &z, if basis.dimension > 2 { basis.order } else { 1 }, false);
            let mut mass = [zero; N];
            for (mass, masses) in mass.iter_mut().zip(masses.chunks(I::LANES)) {
                let mut lanes = [T::ZERO; MAX_LANES];
                lanes.iter_mut().zip(masses).for_each(|(to, &m)| *to = m);
                *mass = isa.load(&lanes);
            }
            let mut sums = sums.iter_mut();
            for &[b, c, len, _] in &*basis.rows {
                let (Some(y), Some(z)) = (y.get(usize::from(b)), z.get(usize::from(c))) else { break };
                let mut weight = mass;
                for (weight, (&y, &z)) in weight.iter_mut().zip(y.iter().zip(z)) {
                    *weight = isa.mul(*weight, isa.mul(y, z));
                }
                for (x, sum) in x.iter().take(usize::from(len)).zip(&mut sums) {
                    let mut total = isa.load(sum);
                    for (&x, &weight) in x.iter().zip(&weight) {
                        total = isa.mul_add(x, weight, total);
                    }
                    *sum = isa.store(total);
                }
            }
        }
        for (sum, &rank) in sums.iter().zip(&*basis.by_rows) {
            let sum = sum.iter().take(I::LANES).fold(T::ZERO, |sum, &x| sum + x);
            to.get_mut(usize::from(rank)).into_iter().for_each(|to| *to += sum);
        }
    }
}

/// Adds the values of a local expansion at targets: lanes are targets.
struct Values<'a, 'w, T> {
    basis: &'a Basis<'w, T>,
    from: &'a [T],
    to: Targets<'a, T>,
    /// Room for an expansion.
    scratch: &'a mut [T],
}

impl<T: Real> Job<T> for Values<'_, '_, T> {
    type Out = ();

    #[inline(always)]
    fn run<I: Isa<T>>(self, isa: I) {
        isa.in_blocks(self);
    }
}

impl<T: Real> BlockJob<T> for Values<'_, '_, T> {
    type Out = ();

    #[inline(always)]
    fn run<I: Isa<T>, const N: usize>(self, isa: I) {
        let Self { basis, from, to: Targets { points, frame, mut potential, mut gradient }, scratch } = self;
        let [first, second] = [frame.per_half, frame.factor];
        let (dimension, order) = (basis.dimension.max(1), basis.order);
        for (to, &rank) in scratch.iter_mut().zip(&*basis.by_rows) {
            *to = from.get(usize::from(rank)).copied().present_or(T::ZERO);
        }
        let (zero, slopes, each) = (isa.splat(T::ZERO), gradient.is_some(), N * I::LANES);
        for (block, points) in points.chunks((each * dimension).max(1)).enumerate() {
            let [x, y, z] = load_points::<T, I, N>(isa, points, dimension, &frame);
            let [x, dx] = polynomials(isa, &x, order, slopes);
            let [y, dy] = polynomials(isa, &y, if dimension > 1 { order } else { 1 }, slopes);
            let [z, dz] = polynomials(isa, &z, if dimension > 2 { order } else { 1 }, slopes);
            // Of each vector the value, and the slope along each axis.
            let mut totals = [(zero, [zero; 3]); N];
            let mut coefficients = &*scratch;
            for &[b, c, len, _] in &*basis.rows {
                let (b, c) = (usize::from(b), usize::from(c));
                let (row, rest) = coefficients.split_at_checked(usize::from(len)).unwrap_or_default();
                coefficients = rest;
                let mut sums = [[zero; 2]; N];
                for ((&coefficient, x), dx) in row.iter().zip(&x).zip(&dx) {
                    let coefficient = isa.splat(coefficient);
                    for ([sum, along], (&x, &dx)) in sums.iter_mut().zip(x.iter().zip(dx)) {
                        *sum = isa.mul_add(coefficient, x, *sum);
                        if slopes {
                            *along = isa.mul_add(coefficient, dx, *along);
                        }
                    }
                }
                let (Some(y), Some(z), Some(dy), Some(dz)) = (y.get(b), z.get(c), dy.get(b), dz.get(c)) else { break };
                let factors = y.iter().zip(z).zip(dy.iter().zip(dz));
                for (((value, [along_x, along_y, along_z]), &[sum, along]), ((&y, &z), (&dy, &dz))) in
                    totals.iter_mut().zip(&sums).zip(factors)
                {
                    let product = isa.mul(y, z);
                    *value = isa.mul_add(sum, product, *value);
                    if slopes {
                        *along_x = isa.mul_add(along, product, *along_x);
                        *along_y = isa.mul_add(sum, isa.mul(dy, z), *along_y);
                        *along_z = isa.mul_add(sum, isa.mul(y, dz), *along_z);
                    }
                }
            }
            for (v, (value, slope)) in totals.into_iter().enumerate() {
                let start = block * each + v * I::LANES;
                if let Some(potential) = potential.as_deref_mut() {
                    let to = potential.iter_mut().skip(start).take(I::LANES);
                    to.zip(&isa.store(value)).for_each(|(to, &value)| *to += value);
                }
                if let Some(gradient) = gradient.as_deref_mut() {
                    for (axis, slope) in slope.iter().enumerate().take(dimension) {
                        let to = gradient.iter_mut().skip(start * dimension + axis).step_by(dimension).take(I::LANES);
                        to.zip(&isa.store(*slope)).for_each(|(to, &slope)| *to += slope * first * second);
                    }
                }
            }
        }
    }
}

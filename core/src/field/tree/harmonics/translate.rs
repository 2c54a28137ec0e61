//! Translations of expansions, one step at a time: lanes are pairs of cells.

use super::bands::{BAND, place};
use super::turns::Turn;
use crate::field::tree::series::Pair;
use crate::real::{Real, Scalar};
use crate::simd::{BlockJob, Isa, Job, MAX_LANES, ROW, Row};

/// The same of a translation along the axis, where rows of even number stand before those of odd number, as a matrix of their own each.
fn place_by_parity((row, column): (usize, usize), size: usize) -> usize {
    let even = size.div_ceil(2);
    let (start, rows) = if row % 2 == 0 { (0, even) } else { (even * size, size - even) };
    start + place((row / 2, column), rows, size)
}

/// Fills the translations by so many half widths from moments to local expansions along the z axis, for one m after the other:
/// (-1)^(n + m) (n + k)! / sqrt((n - m)! (n + m)! (k - m)! (k + m)!) / d^(n + k + 1) from M_k to L_n.
pub(super) fn across<T: Real>(to: &mut [T], terms: usize, distance: f64) {
    let mut rest = to;
    let mut first = 1.0 / distance;
    for m in 0..terms {
        let rows = terms - m;
        let (of_m, others) = core::mem::take(&mut rest).split_at_mut_checked(rows * rows).unwrap_or_default();
        rest = others;
        let mut of_row = first;
        for i in 0..rows {
            let (n, mut value) = (m + i, of_row);
            for j in 0..rows {
                let k = m + j;
                of_m.get_mut(place_by_parity((i, j), rows)).into_iter().for_each(|to| *to = T::from_f64(value));
                value *= (n + k + 1) as f64 / (distance * Scalar::sqrt(((k + 1 - m) * (k + 1 + m)) as f64));
            }
            of_row *= -((n + m + 1) as f64) / (distance * Scalar::sqrt(((n + 1 - m) * (n + 1 + m)) as f64));
        }
        first /= distance * distance;
    }
}

/// The same from the moments of a part to those of the cell around it, or from the local expansion of a cell to that of a part (`down`), whose centre is sqrt(3) / 2 half widths of the larger cell farther along the
/// axis: sqrt((n - m)! (n + m)! / ((k - m)! (k + m)!)) s^(n - k) / (n - k)! / 2^k from k to n, or down from n to k, where potentials are in units of one over the half width.
pub(super) fn between_levels<T: Real>(to: &mut [T], terms: usize, down: bool) {
    let step = 0.5 * Scalar::sqrt(3.0);
    let mut rest = to;
    let mut scale = if down { 0.5 } else { 1.0 };
    for m in 0..terms {
        let rows = terms - m;
        let (of_m, others) = core::mem::take(&mut rest).split_at_mut_checked(rows * rows).unwrap_or_default();
        rest = others;
        of_m.fill(T::ZERO);
        let mut of_column = scale;
        for j in 0..rows {
            let mut value = of_column;
            for i in j..rows {
                let n = m + i;
                let at = if down { (j, i) } else { (i, j) };
                of_m.get_mut(place_by_parity(at, rows)).into_iter().for_each(|to| *to = T::from_f64(value));
                value *= Scalar::sqrt(((n + 1 - m) * (n + 1 + m)) as f64) * step / (i + 1 - j) as f64;
            }
            of_column *= 0.5;
        }
        scale *= 0.5;
    }
}

/// A step.
#[derive(Clone, Copy)]
pub(super) struct Operator<'a, T> {
    pub terms: usize,
    /// cos(m phi), sin(m phi), if phi is not zero.
    pub azimuth: Option<&'a [[T; 2]]>,
    /// The rotation by theta, if that is not zero.
    pub turn: Option<Turn<'a, T>>,
    /// The translations along the z axis.
    pub along: &'a [T],
    pub parities: &'a [u8],
    /// From the expansion of a cell to that of the next.
    pub stride: usize,
}

/// Numbers of scratch that [`Translate`] needs.
pub(super) fn scratch(order: usize) -> usize {
    4 * ((order * order).next_multiple_of(MAX_LANES) + 1) * MAX_LANES
}

/// No cell.
pub(super) const NONE: u32 = u32::MAX;

/// The cell from which by the step, the one from which by the opposite step (or [`NONE`]), the one to which, and the axes along which the step is negative.
pub(super) type Steps = [u32; 4];

/// Pairs of a class of steps, those of opposite steps to the same cell as one.
pub(super) struct Together<'a> {
    pairs: &'a [Pair],
    /// The axes along which the class's steps are not zero.
    axes: u32,
    /// Those of the first pairs that have been given with another one.
    done: u32,
}

impl<'a> Together<'a> {
    /// The pairs, those to one cell next to each other.
    pub fn new(pairs: &'a [Pair], axes: u32) -> Self {
        Self { pairs, axes, done: 0 }
    }
}

impl Iterator for Together<'_> {
    type Item = Steps;

    #[inline(always)]
    fn next(&mut self) -> Option<Steps> {
        loop {
            let (&[source, target, signs], others) = self.pairs.split_first()?;
            let done = self.done & 1 == 1;
            (self.pairs, self.done) = (others, self.done >> 1);
            if done {
                continue;
            }
            let mut of_target = others.iter().take_while(|pair| pair[1] == target);
            let opposite = of_target.position(|&[_, _, other]| other == signs ^ self.axes);
            self.done |= opposite.map_or(0, |other| 1 << other);
            let other = opposite.and_then(|other| others.get(other)).map_or(NONE, |pair| pair[0]);
            return Some([source, other, target, signs]);
        }
    }
}

/// Adds what a step makes of the expansions of some cells to those of others.
pub(super) struct Translate<'a, T> {
    pub operator: Operator<'a, T>,
    pub steps: &'a [Steps],
    pub from: &'a [T],
    pub to: &'a mut [T],
    pub scratch: &'a mut [T],
}

/// A number of all lanes: some vectors, in memory one after the other.
#[inline(always)]
fn get<T: Real, I: Isa<T>, const V: usize>(isa: I, rows: &[I::Row], at: usize) -> [I::V; V] {
    let mut vectors = [isa.splat(T::ZERO); V];
    if let Some(rows) = rows.as_chunks::<V>().0.get(at) {
        for (vector, row) in vectors.iter_mut().zip(rows) {
            *vector = isa.load_row(row);
        }
    }
    vectors
}

/// Writes it.
#[inline(always)]
fn set<T: Real, I: Isa<T>, const V: usize>(isa: I, rows: &mut [I::Row], at: usize, vectors: [I::V; V]) {
    if let Some(rows) = rows.as_chunks_mut::<V>().0.get_mut(at) {
        for (row, &vector) in rows.iter_mut().zip(&vectors) {
            *row = isa.store_row(vector);
        }
    }
}

/// Some of the numbers of an expansion.
#[inline(always)]
fn part<R, const V: usize>(rows: &[R], first: usize, n: usize) -> &[R] {
    rows.get(first * V..(first + n) * V).unwrap_or_default()
}

/// The same.
#[inline(always)]
fn part_mut<R, const V: usize>(rows: &mut [R], first: usize, n: usize) -> &mut [R] {
    rows.get_mut(first * V..(first + n) * V).unwrap_or_default()
}

/// Where the products of a matrix with `C` columns of numbers of all lanes go. (Not a closure: these are not always in line, and then compiled without the instructions.)
trait Take<T: Real, I: Isa<T>, const V: usize, const C: usize> {
    /// Takes those of a row.
    fn take(&mut self, isa: I, row: usize, sums: [[I::V; V]; C]);
}

/// What a matrix is multiplied with, by its columns.
trait Columns<T: Real, I: Isa<T>, const V: usize, const C: usize>: Copy {
    /// That of a column.
    fn column(self, isa: I, column: usize) -> [[I::V; V]; C];
}

/// Some rows of vectors that follow each other.
#[derive(Clone, Copy)]
struct Successive<'a, R, const C: usize>([&'a [R]; C]);

impl<T: Real, I: Isa<T>, const V: usize, const C: usize> Columns<T, I, V, C> for Successive<'_, I::Row, C> {
    #[inline(always)]
    fn column(self, isa: I, column: usize) -> [[I::V; V]; C] {
        let mut vectors = [[isa.splat(T::ZERO); V]; C];
        for (vector, &rows) in vectors.iter_mut().zip(&self.0) {
            *vector = get(isa, rows, column);
        }
        vectors
    }
}

/// The products of a band of rows.
#[inline(always)]
fn band<T: Real, I: Isa<T>, const V: usize, const R: usize, const C: usize>(
    isa: I,
    (matrix, row): (&[T], usize),
    columns: impl Columns<T, I, V, C>,
    to: &mut impl Take<T, I, V, C>,
) {
    let mut sums = [[[isa.splat(T::ZERO); V]; C]; R];
    for (column, numbers) in matrix.as_chunks::<R>().0.iter().enumerate() {
        let x = columns.column(isa, column);
        for (sums, &number) in sums.iter_mut().zip(numbers) {
            let number = isa.splat(number);
            for (sums, x) in sums.iter_mut().zip(&x) {
                for (sum, &x) in sums.iter_mut().zip(x) {
                    *sum = isa.mul_add(number, x, *sum);
                }
            }
        }
    }
    for (i, sums) in sums.iter().enumerate() {
        to.take(isa, row + i, *sums);
    }
}

/// The products of a matrix.
#[inline(always)]
fn product<T: Real, I: Isa<T>, const V: usize, const C: usize>(
    isa: I,
    (matrix, rows, n): (&[T], usize, usize),
    columns: impl Columns<T, I, V, C>,
    to: &mut impl Take<T, I, V, C>,
) {
    let mut rest = matrix;
    let mut row = 0;
    while row + BAND <= rows {
        let (numbers, others) = rest.split_at_checked(BAND * n).unwrap_or_default();
        rest = others;
        band::<T, I, V, BAND, C>(isa, (numbers, row), columns, to);
        row += BAND;
    }
    match rows - row {
        1 => band::<T, I, V, 1, C>(isa, (rest, row), columns, to),
        2 => band::<T, I, V, 2, C>(isa, (rest, row), columns, to),
        3 => band::<T, I, V, 3, C>(isa, (rest, row), columns, to),
        _ => {}
    }
}

/// Rows that follow each other.
struct Straight<'a, R>(&'a mut [R]);

impl<T: Real, I: Isa<T>, const V: usize> Take<T, I, V, 1> for Straight<'_, I::Row> {
    #[inline(always)]
    fn take(&mut self, isa: I, row: usize, [sum]: [[I::V; V]; 1]) {
        set(isa, self.0, row, sum);
    }
}

/// The sums and the differences of steps and opposite steps: a step back is one forward of moments that have (-1)^(n + k) times their signs, so rows of even number need the sums for columns of
/// even number and the differences for others (`even`), rows of odd number the other ones (`odd`).
struct Opposites<'a, R> {
    even: &'a mut [R],
    odd: &'a mut [R],
    /// The parity of n - m of the first row.
    parity: usize,
}

impl<T: Real, I: Isa<T>, const V: usize> Take<T, I, V, 2> for Opposites<'_, I::Row> {
    #[inline(always)]
    fn take(&mut self, isa: I, row: usize, [plus, minus]: [[I::V; V]; 2]) {
        let (mut sum, mut difference) = (plus, plus);
        for ((sum, difference), &minus) in sum.iter_mut().zip(&mut difference).zip(&minus) {
            (*sum, *difference) = (isa.add(*sum, minus), isa.sub(*difference, minus));
        }
        let (to_sum, to_difference) = if (self.parity + row).is_multiple_of(2) {
            (&mut *self.even, &mut *self.odd)
        } else {
            (&mut *self.odd, &mut *self.even)
        };
        set(isa, to_sum, row, sum);
        set(isa, to_difference, row, difference);
    }
}

/// The blocks of the harmonics of one n: the first, how many there are, and the parity of n - m of the first.
#[inline(always)]
fn blocks(n: usize) -> [[usize; 3]; 2] {
    // Cosines from m = 0, sines from m = 1 on.
    [[n * n, n + 1, n % 2], [n * n + n + 1, n, (n + 1) % 2]]
}

/// The rotation of all n.
#[inline(always)]
fn turn<T: Real, I: Isa<T>, const V: usize>(isa: I, terms: usize, matrices: &[T], from: &[I::Row], to: &mut [I::Row]) {
    let mut rest = matrices;
    for n in 0..terms {
        for [first, rows, _] in blocks(n) {
            let (matrix, others) = rest.split_at_checked(rows * rows).unwrap_or_default();
            rest = others;
            let columns = Successive([part::<_, V>(from, first, rows)]);
            let mut to = Straight(part_mut::<_, V>(to, first, rows));
            product::<T, I, V, 1>(isa, (matrix, rows, rows), columns, &mut to);
        }
    }
}

/// The same of opposite steps; without matrices only sums and differences.
#[inline(always)]
fn turn_both<T: Real, I: Isa<T>, const V: usize>(
    isa: I,
    terms: usize,
    matrices: Option<&[T]>,
    from: [&[I::Row]; 2],
    [even, odd]: [&mut [I::Row]; 2],
) {
    let mut rest = matrices.unwrap_or_default();
    for n in 0..terms {
        for [first, rows, parity] in blocks(n) {
            let (matrix, others) = rest.split_at_checked(rows * rows).unwrap_or_default();
            rest = others;
            let [plus, minus] = from;
            let columns = Successive([part::<_, V>(plus, first, rows), part::<_, V>(minus, first, rows)]);
            let even = part_mut::<_, V>(even, first, rows);
            let odd = part_mut::<_, V>(odd, first, rows);
            let mut to = Opposites { even, odd, parity };
            if matrices.is_some() {
                product::<T, I, V, 2>(isa, (matrix, rows, rows), columns, &mut to);
            } else {
                for row in 0..rows {
                    to.take(isa, row, Columns::<T, I, V, 2>::column(columns, isa, row));
                }
            }
        }
    }
}

/// The cosines, and with `C` = 2 the sines, of one m, by n.
#[derive(Clone, Copy)]
struct OfOrder<'a, R> {
    rows: &'a [R],
    m: usize,
}

impl<T: Real, I: Isa<T>, const V: usize, const C: usize> Columns<T, I, V, C> for OfOrder<'_, I::Row> {
    #[inline(always)]
    fn column(self, isa: I, column: usize) -> [[I::V; V]; C] {
        let n = self.m + column;
        let mut vectors = [[isa.splat(T::ZERO); V]; C];
        for (sine, vector) in vectors.iter_mut().enumerate() {
            *vector = get(isa, self.rows, n * n + self.m + sine * n);
        }
        vectors
    }
}

/// Those of every other n from m + parity on.
struct EveryOther<'a, R> {
    rows: &'a mut [R],
    m: usize,
    parity: usize,
}

impl<T: Real, I: Isa<T>, const V: usize, const C: usize> Take<T, I, V, C> for EveryOther<'_, I::Row> {
    #[inline(always)]
    fn take(&mut self, isa: I, row: usize, sums: [[I::V; V]; C]) {
        let n = self.m + 2 * row + self.parity;
        for (sine, &sum) in sums.iter().enumerate() {
            set(isa, self.rows, n * n + self.m + sine * n, sum);
        }
    }
}

/// The translation along the axis of all m. `from` has what rows of even number and of odd number are products with.
#[inline(always)]
fn along<T: Real, I: Isa<T>, const V: usize>(
    isa: I,
    terms: usize,
    matrices: &[T],
    from: [&[I::Row]; 2],
    to: &mut [I::Row],
) {
    let mut rest = matrices;
    for m in 0..terms {
        let size = terms - m;
        for (parity, rows_from) in from.into_iter().enumerate() {
            let rows = (size + 1 - parity) / 2;
            let (matrix, others) = rest.split_at_checked(rows * size).unwrap_or_default();
            rest = others;
            let matrix = (matrix, rows, size);
            let (columns, mut to) = (OfOrder { rows: rows_from, m }, EveryOther { rows: &mut *to, m, parity });
            if m == 0 {
                product::<T, I, V, 1>(isa, matrix, columns, &mut to);
            } else {
                product::<T, I, V, 2>(isa, matrix, columns, &mut to);
            }
        }
    }
}

/// The rotation about the z axis, by phi or by -phi (`back`).
#[inline(always)]
fn spin<T: Real, I: Isa<T>, const V: usize>(isa: I, terms: usize, azimuth: &[[T; 2]], back: bool, rows: &mut [I::Row]) {
    for n in 1..terms {
        for (m, &[cos, sin]) in azimuth.iter().enumerate().take(n + 1).skip(1) {
            let (cos, sin) = (isa.splat(cos), isa.splat(if back { -sin } else { sin }));
            let (mut c, mut s) = (get::<T, I, V>(isa, rows, n * n + m), get::<T, I, V>(isa, rows, n * n + n + m));
            for (c, s) in c.iter_mut().zip(&mut s) {
                (*c, *s) = (isa.mul_add(cos, *c, isa.mul(sin, *s)), isa.neg_mul_add(sin, *c, isa.mul(cos, *s)));
            }
            set(isa, rows, n * n + m, c);
            set(isa, rows, n * n + n + m, s);
        }
    }
}

impl<T: Real> Job<T> for Translate<'_, T> {
    type Out = ();

    #[inline(always)]
    fn run<I: Isa<T>>(self, isa: I) {
        isa.in_blocks(self);
    }
}

impl<T: Real> BlockJob<T> for Translate<'_, T> {
    type Out = ();

    #[inline(always)]
    fn run<I: Isa<T>, const N: usize>(self, isa: I) {
        // Two vectors at a time where there are registers for four bands of them.
        if const { N == 4 && 2 * I::LANES <= MAX_LANES } {
            self.all::<I, 2>(isa);
        } else {
            self.all::<I, 1>(isa);
        }
    }
}

impl<T: Real> Translate<'_, T> {
    /// All steps, so many vectors at a time.
    #[inline(always)]
    fn all<I: Isa<T>, const V: usize>(self, isa: I) {
        let Self { operator, steps, from, to, scratch } = self;
        let Operator { terms, azimuth, turn: rotation, along: matrices, parities, stride } = operator;
        let each = scratch.len() / 4;
        let mut pieces = scratch.chunks_mut(each.max(1)).map(I::Row::of_mut);
        let (Some(mut a), Some(mut b), Some(mut c), Some(d)) =
            (pieces.next(), pieces.next(), pieces.next(), pieces.next())
        else {
            return;
        };
        for steps in steps.chunks((V * I::LANES).max(1)) {
            let signs = signs::<T, I, V>(isa, steps);
            let of = (parities, terms);
            gather::<T, I, V>(isa, (starts(steps, 0, stride), from), of, &signs, a);
            if let Some(azimuth) = azimuth {
                spin::<T, I, V>(isa, terms, azimuth, false, a);
            }
            if steps.iter().any(|step| step[1] != NONE) {
                gather::<T, I, V>(isa, (starts(steps, 1, stride), from), of, &signs, b);
                if let Some(azimuth) = azimuth {
                    spin::<T, I, V>(isa, terms, azimuth, false, b);
                }
                let forward = rotation.map(|[forward, _]| forward);
                turn_both::<T, I, V>(isa, terms, forward, [a, b], [&mut *c, &mut *d]);
                along::<T, I, V>(isa, terms, matrices, [c, d], a);
            } else if let Some([forward, _]) = rotation {
                turn::<T, I, V>(isa, terms, forward, a, c);
                along::<T, I, V>(isa, terms, matrices, [c, c], a);
            } else {
                along::<T, I, V>(isa, terms, matrices, [a, a], c);
                core::mem::swap(&mut a, &mut c);
            }
            if let Some([_, backward]) = rotation {
                turn::<T, I, V>(isa, terms, backward, a, b);
            } else {
                core::mem::swap(&mut a, &mut b);
            }
            if let Some(azimuth) = azimuth {
                spin::<T, I, V>(isa, terms, azimuth, true, b);
            }
            scatter::<T, I, V>(isa, (steps, &mut *to, stride), of, &signs, b);
        }
    }
}

/// The signs of the lanes, by the axes under whose reflection a harmonic changes its own.
#[inline(always)]
fn signs<T: Real, I: Isa<T>, const V: usize>(isa: I, steps: &[Steps]) -> [[I::V; V]; 8] {
    let mut signs = [[isa.splat(T::ONE); V]; 8];
    for (parity, signs) in signs.iter_mut().enumerate() {
        for (signs, steps) in signs.iter_mut().zip(steps.chunks(I::LANES.max(1))) {
            let mut lanes = [T::ONE; MAX_LANES];
            for (to, &[.., axes]) in lanes.iter_mut().zip(steps) {
                *to = if (axes & parity as u32).count_ones() % 2 == 1 { -T::ONE } else { T::ONE };
            }
            *signs = isa.load(&lanes);
        }
    }
    signs
}

/// Where the expansions of the cells from which begin, by the steps or by the opposite ones.
fn starts(steps: &[Steps], opposite: usize, stride: usize) -> [usize; MAX_LANES] {
    let mut starts = [usize::MAX; MAX_LANES];
    for (start, step) in starts.iter_mut().zip(steps) {
        let cell = if opposite == 0 { step[0] } else { step[1] };
        *start = if cell == NONE { usize::MAX } else { cell as usize * stride };
    }
    starts
}

/// Reads the expansions that start there; of none zeros.
#[inline(always)]
fn gather<T: Real, I: Isa<T>, const V: usize>(
    isa: I,
    (starts, from): ([usize; MAX_LANES], &[T]),
    (parities, terms): (&[u8], usize),
    signs: &[[I::V; V]; 8],
    to: &mut [I::Row],
) {
    let zeros = [T::ZERO; ROW];
    for (block, parities) in parities.chunks(ROW).enumerate().take((terms * terms).div_ceil(ROW)) {
        for (v, starts) in starts.chunks(I::LANES.max(1)).enumerate().take(V) {
            let mut rows = [&zeros; MAX_LANES];
            for (row, &start) in rows.iter_mut().zip(starts) {
                let numbers = start.checked_add(block * ROW).and_then(|at| from.get(at..));
                *row = numbers.and_then(<[T]>::first_chunk::<ROW>).unwrap_or(&zeros);
            }
            let columns = isa.columns(&rows);
            for (number, (&vector, &parity)) in columns.iter().zip(parities).enumerate() {
                let sign = signs.get(usize::from(parity)).and_then(|signs| signs.get(v)).copied().unwrap_or(vector);
                if let Some(row) = to.get_mut((block * ROW + number) * V + v) {
                    *row = isa.store_row(isa.mul(vector, sign));
                }
            }
        }
    }
}

/// Adds to the expansions of the cells to which.
#[inline(always)]
fn scatter<T: Real, I: Isa<T>, const V: usize>(
    isa: I,
    (steps, to, stride): (&[Steps], &mut [T], usize),
    (parities, terms): (&[u8], usize),
    signs: &[[I::V; V]; 8],
    from: &mut [I::Row],
) {
    let (zero, each) = (isa.splat(T::ZERO), I::LANES.max(1));
    for (at, &parity) in parities.iter().enumerate().take(terms * terms) {
        let mut vectors = get::<T, I, V>(isa, from, at);
        for (vector, &sign) in vectors.iter_mut().zip(signs.get(usize::from(parity)).unwrap_or(&[zero; V])) {
            *vector = isa.mul(*vector, sign);
        }
        set(isa, from, at, vectors);
    }
    for at in terms * terms..(terms * terms).next_multiple_of(each) {
        set(isa, from, at, [zero; V]);
    }
    let (zeros, numbers) = ([T::ZERO; ROW], I::Row::numbers(from));
    for block in 0..(terms * terms).div_ceil(each) {
        for first in (0..V * each).step_by(ROW.min(each)) {
            let mut rows = [&zeros; MAX_LANES];
            for (i, row) in rows.iter_mut().enumerate().take(each) {
                let numbers = numbers.get((block * each + i) * V * each + first..);
                *row = numbers.and_then(<[T]>::first_chunk::<ROW>).unwrap_or(&zeros);
            }
            let columns = isa.columns(&rows);
            for (&sum, &[_, _, target, _]) in columns.iter().take(each).zip(steps.iter().skip(first)) {
                let start = target as usize * stride + block * each;
                let to = I::Row::of_mut(to.get_mut(start..start + each).unwrap_or_default());
                for to in to {
                    *to = isa.store_row(isa.add(isa.load_row(to), sum));
                }
            }
        }
    }
}

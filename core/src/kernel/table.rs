//! A prepared kernel as one table in r^2, for sums: see [`crate::simd::Rows`] for how a row is found.
//!
//! With u = (r / unit)^2 + shift the table holds, for each of 2^6 panels of each octave of u, a polynomial of the gradient factor
//! g = K'(r) / r in t = u - (the panel's least u), and K at t = 0. Under a mollifier unit = delta and shift = [`SHIFT`] = 1/16: panels are 2^-10
//! wide, in r^2 / delta^2, at the centre and 2^-6 at the edge, u = 17/16, which is a panel's border. Without one shift = 0, and the table ends at a
//! multiple of the kernel's own length.
//!
//! # Accuracy
//! The derivative of g, which follows from the Laplacian, is interpolated in 6 (f32: 3) Chebyshev nodes a panel and integrated; the constant is the
//! mean of what g's values ask for. (Differentiating an interpolation of g would multiply the samples' rounding by 2^8 in the Laplacian. In the
//! first panel alone, where the derivative would be a quotient of two small numbers, g's values are used.)
//!
//! A kernel that changes over lengths of r has an interpolation error of 256^-6 = 4e-15 (f32: 256^-3 = 6e-8) of g's change within a panel, a 64th of g.
//! A compact mollifier of high order and exponent changes faster: with psi = (1 - s)^9 times a cubic, s = (r / delta)^2, panels of 2^-6 would lose
//! 10^5 u of Laplacians and 2000 u of gradients, most of it far from the edge. With those of this table the samples' errors remain.
//!
//! Measured (test `tables_of_random_kernels_are_within_their_bound`, with 20 times as many kernels) against [`Kernel::at`](super::Kernel::at) at one
//! distance, in units of u s, s being the largest size of what is computed (of a Laplacian: of D g too) at distances from r/2 to r, below delta
//! at all below delta, and of exponential and screened kernels under Gaussian mollifiers at all below r:
//!
//! | | K | g | Laplacian |
//! |---|---|---|---|
//! | f64 | 93 | 109 | 902 |
//! | f64, exponential and screened kernels whose delta is over 5 lengths | 114 | 327 | 2190 |
//! | f32 | 4 | 10 | 22 |
//!
//! In f64 these are the errors of the kernel's own fits, 1e-13 = 900 u, in the samples or at the distance itself.
//!
//! Where a compact mollifier is so rough that its edge is seen beside it (t^a with a small a, not whole), the panels that miss their goal are
//! measured and left out: [`Head::gap`], [`Head::rough`]. Where a host's three functions do not belong together, g is interpolated alone.
//!
//! # Several radii
//! Under a Richardson combination of K radii the unit is 2 delta / K: the radii are its halves, at u = (j / 2)^2 + 1/16, borders of panels. The panels inside that miss their
//! goal, of rough edges, are marked as those of a host's kernel are. A Newtonian field is a polynomial between the radii, and has none.
//!
//! # A host's kernel
//! Its first knot, or its reach, is a power of two in u, so that it is a panel's border, as are knots at 2^(n/2) times its radius. Every panel is compared with the kernel
//! ([`compare`]). One that holds another knot, or that misses the goal, is marked, and sums leave its pairs out: they are computed one by one. That is a few panels of some
//! thousands; a kernel that would need more has no table that serves it, and is refused for the error that it has without marks.

use core::f64::consts::PI;

use super::sizes::{Sizes, larger, magnitudes, relative_errors};
use crate::error::{Error, Result};
use crate::real::{Extended, Real, Scalar};
use crate::simd::{OCTAVES, PANEL_BITS, ROW, ROWS, Rows};

/// What a prepared block keeps of a table besides its rows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Head {
    /// The length that divides r.
    pub(crate) unit: f64,
    /// Added to the square: [`SHIFT`] under a mollifier, else 0.
    pub(crate) shift: f64,
    /// The table holds u from `first` to below `last`, but not from `gap[0]` to below `gap[1]`.
    pub(crate) first: f64,
    pub(crate) last: f64,
    pub(crate) gap: [f64; 2],
    /// The same where Laplacians are not served.
    pub(crate) rough: [f64; 2],
    /// Whether the kernel is zero from `last` on.
    pub(crate) ends: bool,
    /// Whether rows are marked ([`mark`]).
    pub(crate) marked: bool,
    /// Pairs at this distance and beyond are counted; infinity: none.
    pub(crate) reach: f64,
    /// K is the table's value times 2^this, g that over unit^2.
    pub(crate) exponent: i32,
    /// The largest error that was found outside the gap, relative to the largest of |g| in its panel.
    pub(crate) error: f64,
}

/// A table and what it means.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Table<'k, T> {
    pub(crate) rows: &'k Rows<T>,
    pub(crate) head: Head,
}

/// What a table is to hold.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Domain {
    pub(crate) unit: f64,
    pub(crate) shift: f64,
    /// Where the table may end: no u above matters, or the kernel jumps there.
    pub(crate) until: f64,
    /// Whether the kernel is zero from there on.
    pub(crate) ends: bool,
    /// The number of distances at which the kernel is rough. One is the unit; more are halves of it, and the panels beside them that miss their goal are marked.
    pub(crate) edges: u32,
    /// The reach of a host's kernel in the sum.
    pub(crate) reach: Option<f64>,
}

/// Numbers in [`Head::to_record`].
pub(crate) const RECORD: usize = 14;

impl Head {
    /// The numbers that a prepared block keeps.
    pub(crate) fn to_record(self) -> [f64; RECORD] {
        let Self { unit, shift, first, last, gap, rough, ends, marked, reach, exponent, error } = self;
        let [ends, marked] = [ends, marked].map(|is| f64::from(u8::from(is)));
        let exponent = f64::from(exponent);
        [1.0, unit, shift, first, last, gap[0], gap[1], rough[0], rough[1], ends, exponent, error, marked, reach]
    }

    /// None if there is no table.
    pub(crate) fn from_record(record: &[f64; RECORD]) -> Option<Self> {
        let &[there, unit, shift, first, last, from, to, rough_from, rough_to, ends, exponent, error, marked, reach] =
            record;
        (there == 1.0).then_some(Self {
            unit,
            shift,
            first,
            last,
            gap: [from, to],
            rough: [rough_from, rough_to],
            ends: ends != 0.0,
            marked: marked != 0.0,
            reach,
            exponent: exponent as i32,
            error,
        })
    }
}

/// Coefficients of g in a row.
pub(crate) const fn terms<T: Real>() -> usize {
    if T::DIGITS > 24 { 7 } else { 4 }
}

/// The binary exponent of c_0 in the row of a panel that is left out; its other numbers are zero. Times what sums multiply it by it is in range.
const fn mark_exponent<T: Real>() -> i32 {
    if T::DIGITS > 24 { 934 } else { 100 }
}

/// The least c_0 of rows that are left out.
pub(crate) fn mark<T: Real>() -> T {
    T::ONE.ldexp(mark_exponent::<T>())
}

/// The shift under a mollifier: the less, the narrower are the panels near the centre, and the more of them serve distances below delta.
pub(crate) const SHIFT: f64 = 0.0625;

/// The octave at which tables of kernels without a mollifier end.
const SINGULAR_END: i32 = 16;

/// Octaves of a table: all that the rows hold, but in f32 as many as leave the coefficients of t^3 in its range.
fn octaves<T: Real>(shift: f64) -> i32 {
    if T::DIGITS > 24 {
        OCTAVES as i32
    } else if shift > 0.0 {
        36
    } else {
        32
    }
}

/// Terms of g in the first panel, from its values alone: there the slope would be the quotient of a small difference by a small square. The panel
/// is so short that no more terms are seen.
const FIRST_TERMS: usize = 6;

/// The polynomial through N points, from its values in the Chebyshev nodes.
struct Interpolation<const N: usize> {
    /// The nodes in [0, 1].
    nodes: [f64; N],
    /// From values to Chebyshev coefficients.
    transform: [[f64; N]; N],
    /// From these to powers of y in [0, 1]. Two steps, as the first is well-conditioned and gives small numbers to the second.
    powers: [[f64; N]; N],
}

impl<const N: usize> Interpolation<N> {
    fn new() -> Self {
        let cosine = |j: usize, k: usize| Scalar::cos(PI * (j * (2 * k + 1)) as f64 / (2 * N) as f64);
        let mut nodes = [0.0; N];
        nodes.iter_mut().enumerate().for_each(|(k, node)| *node = 0.5 * (1.0 + cosine(1, k)));
        let mut transform = [[0.0; N]; N];
        for (j, row) in transform.iter_mut().enumerate() {
            let factor = if j == 0 { 1.0 } else { 2.0 } / N as f64;
            row.iter_mut().enumerate().for_each(|(k, to)| *to = factor * cosine(j, k));
        }
        // T_(j+1)(2 y - 1) = 2 (2 y - 1) T_j - T_(j-1): whole numbers.
        let (mut before, mut now) = ([0.0; N], [0.0; N]);
        now.iter_mut().take(1).for_each(|c| *c = 1.0);
        let mut powers = [[0.0; N]; N];
        for j in 0..N {
            for (row, &c) in powers.iter_mut().zip(&now) {
                row.get_mut(j).into_iter().for_each(|to| *to = c);
            }
            let factor = if j == 0 { 1.0 } else { 2.0 };
            let shifted = core::iter::once(0.0).chain(now);
            let mut next = [0.0; N];
            for (((next, now), lower), before) in next.iter_mut().zip(now).zip(shifted).zip(before) {
                *next = factor * (2.0 * lower - now) - if j == 0 { 0.0 } else { before };
            }
            (before, now) = (now, next);
        }
        Self { nodes, transform, powers }
    }

    /// The coefficients of y^0, y^1, ...
    fn coefficients(&self, values: [f64; N]) -> [f64; N] {
        self.up_to(N, values)
    }

    /// The same of the polynomial of so many terms that is nearest to the values.
    fn up_to(&self, terms: usize, values: [f64; N]) -> [f64; N] {
        let mut series = times(&self.transform, &values);
        series.iter_mut().skip(terms).for_each(|c| *c = 0.0);
        times(&self.powers, &series)
    }
}

/// A matrix, by rows, times a vector.
fn times<const N: usize>(matrix: &[[f64; N]; N], vector: &[f64; N]) -> [f64; N] {
    let mut product = [0.0; N];
    for (to, row) in product.iter_mut().zip(matrix) {
        *to = row.iter().zip(vector).map(|(a, b)| a * b).sum();
    }
    product
}

/// The binary exponent of the kernel's size within a unit, of a host's up to its reach; none if it is zero there. `sample(r)` returns K, K'/r and the Laplacian of K, in range or not.
pub(crate) fn exponent(domain: &Domain, sample: &dyn Fn(f64) -> [Extended; 3]) -> Option<i32> {
    let mut largest = if domain.shift > 0.0 { exponent_of(0.0, sample(0.0)) } else { None };
    for k in 0..=16 {
        let r = domain.unit * 1.0_f64.ldexp(-k);
        largest = largest.max(exponent_of(r, sample(r)));
    }
    // A host's kernel may be largest anywhere.
    if let Some(reach) = domain.reach {
        let mut r = domain.unit;
        for _ in 0..80 {
            r *= 1.09;
            if r < reach {
                largest = largest.max(exponent_of(r, sample(r)));
            }
        }
    }
    largest
}

/// Fills a table from `sample(r)`; `exponent` is that of the kernel's size.
///
/// # Errors
/// [`Error::NotFinite`]: a sample of the first octave is not finite.
pub(crate) fn build<T: Real, const D: usize>(
    rows: &mut Rows<T>,
    domain: &Domain,
    exponent: i32,
    sample: &dyn Fn(f64) -> [Extended; 3],
) -> Result<Head> {
    if T::DIGITS > 24 {
        fill::<T, D, 7, 6>(rows, domain, exponent, sample)
    } else {
        fill::<T, D, 4, 3>(rows, domain, exponent, sample)
    }
}

/// The coefficients of g in y, from 0 to 1 in a panel; `at(y)` returns the square of the distance, K, g and the Laplacian. `first`: distances begin
/// from zero.
fn polynomial<const D: usize, const N: usize, const M: usize>(
    (values, slopes): (&Interpolation<N>, &Interpolation<M>),
    width: f64,
    first: bool,
    at: impl Fn(f64) -> (f64, [f64; 3]),
) -> [f64; N] {
    let alone = |terms: usize| {
        let mut found = [0.0; N];
        found.iter_mut().zip(&values.nodes).for_each(|(value, &node)| *value = at(node).1[1]);
        values.up_to(terms, found)
    };
    if first {
        return alone(FIRST_TERMS);
    }
    let (mut found, mut slope) = ([0.0; M], [0.0; M]);
    for ((value, slope), &node) in found.iter_mut().zip(&mut slope).zip(&slopes.nodes) {
        let (square, [_, factor, laplacian]) = at(node);
        *value = factor;
        // lap K = D g + 2 s dg / ds
        *slope = width * (laplacian - D as f64 * factor) / (2.0 * square);
    }
    let mut coefficients = [0.0; N];
    for (k, (to, c)) in coefficients.iter_mut().skip(1).zip(slopes.coefficients(slope)).enumerate() {
        *to = c / (k as f64 + 1.0);
    }
    let horner = |y: f64| coefficients.iter().rev().fold(0.0, |sum, &c| sum * y + c);
    let mut constants = found;
    constants.iter_mut().zip(&slopes.nodes).for_each(|(value, &node)| *value -= horner(node));
    let constant = constants.iter().sum::<f64>() / M as f64;
    let size = found.iter().fold(0.0, |most: f64, v| most.max(v.abs()));
    if constants.iter().all(|c| (c - constant).abs() <= 1e-10 * size) {
        coefficients.iter_mut().take(1).for_each(|c| *c = constant);
        return coefficients;
    }
    alone(N)
}

/// The row of u.
fn row<T: Real>(u: f64) -> usize {
    (T::from_f64(u).bits() >> (T::DIGITS - 1 - PANEL_BITS)) as usize % ROWS
}

/// The exponent of the larger of |K| and r^2 |K' / r|; none if both are zero.
fn exponent_of(r: f64, [value, factor, _]: [Extended; 3]) -> Option<i32> {
    value.exponent().max(factor.scale(r).scale(r).exponent())
}

fn fill<T: Real, const D: usize, const N: usize, const M: usize>(
    rows: &mut Rows<T>,
    domain: &Domain,
    exponent: i32,
    sample: &dyn Fn(f64) -> [Extended; 3],
) -> Result<Head> {
    let &Domain { unit, shift, until, ends, edges, reach } = domain;
    let interpolations = (&Interpolation::<N>::new(), &Interpolation::<M>::new());
    let first_octave = if shift > 0.0 { Scalar::frexp(shift).1 - 1 } else { SINGULAR_END - octaves::<T>(shift) };
    let octaves = octaves::<T>(shift);
    let at = |square: f64| {
        let [value, factor, laplacian] = sample(unit * square.max(0.0).sqrt());
        let per_square = |value: Extended| value.scale(unit).scale(unit);
        [value, per_square(factor), per_square(laplacian)].map(|value| value.in_units(exponent))
    };
    let may_mark = reach.is_some() || edges > 1;
    let limit = 1.0_f64.ldexp(if may_mark { mark_exponent::<T>() - 2 } else { T::MAX_EXPONENT - 24 });
    // A panel's constant is taken beyond a knot at its border.
    let beyond = if reach.is_some() && shift == 0.0 { 1.0 + 8.0 * f64::EPSILON } else { 1.0 };
    let (goal, goal_of_slope) = if T::DIGITS > 24 { (1e-14, 1e-13) } else { (2e-7, 4e-6) };
    // The fits of several radii cancel in part; their errors are not to mark a panel.
    let slack = if edges > 1 && T::DIGITS > 24 { 10.0 } else { 1.0 };
    let mut head = Head {
        unit,
        shift,
        first: 1.0_f64.ldexp(first_octave),
        last: 1.0_f64.ldexp(first_octave + octaves).min(until),
        gap: [0.0; 2],
        rough: [0.0; 2],
        ends: ends && until <= 1.0_f64.ldexp(first_octave + octaves),
        marked: false,
        reach: reach.unwrap_or(f64::INFINITY),
        exponent,
        error: 0.0,
    };
    for octave in first_octave..first_octave + octaves {
        for panel in 0..1 << PANEL_BITS {
            let width = 1.0_f64.ldexp(octave - PANEL_BITS as i32);
            let least = 1.0_f64.ldexp(octave) + f64::from(panel) * width;
            if least >= head.last {
                return Ok(head);
            }
            // A table that ends within a panel looks no further.
            let width = width.min(head.last - least);
            let within = |y: f64| {
                let square = least - shift + width * y;
                (square, at(square))
            };
            let coefficients = polynomial::<D, N, M>(interpolations, width, least == shift, within);
            let constant = at((least - shift) * beyond)[0];
            let mut numbers = [0.0; ROW];
            let mut power = 1.0;
            for (number, c) in numbers.iter_mut().zip(coefficients) {
                *number = c / power;
                power *= width;
            }
            numbers.get_mut(N).into_iter().for_each(|slot| *slot = constant);
            if !numbers.iter().all(|number| number.abs() < limit) {
                if reach.is_some() {
                    head.marked = true;
                    rows.get_mut(row::<T>(least)).into_iter().for_each(|slot| *slot = marked());
                    continue;
                }
                if octave == first_octave {
                    return Err(Error::NotFinite);
                }
                (head.last, head.ends) = (least, false);
                return Ok(head);
            }
            let close = match edges {
                0 => false,
                1 => (least - (1.0 + shift)).abs() < 0.5,
                n => least < 0.25 * f64::from(n * n) + shift + 0.5,
            };
            let mut is_marked = false;
            if close || panel % 16 == 8 {
                let [error, of_slope] = errors::<D, N>(&coefficients, width, within);
                let (misses, slope_misses) = (error > slack * goal, of_slope > slack * goal_of_slope);
                is_marked = edges > 1 && close && (misses || slope_misses);
                let widen = |gap: &mut [f64; 2]| {
                    *gap = if gap[0] == 0.0 { [least, least + width] } else { [gap[0], least + width] };
                };
                if edges == 1 && close && misses {
                    widen(&mut head.gap);
                } else if !is_marked {
                    head.error = head.error.max(error);
                }
                if edges == 1 && close && slope_misses {
                    widen(&mut head.rough);
                }
            }
            head.marked |= is_marked;
            let numbers = if is_marked { marked() } else { numbers.map(T::from_f64) };
            rows.get_mut(row::<T>(least)).into_iter().for_each(|slot| *slot = numbers);
        }
    }
    Ok(head)
}

/// The row of a panel that is left out.
fn marked<T: Real>() -> [T; ROW] {
    let mut row = [T::ZERO; ROW];
    row.iter_mut().take(1).for_each(|c| *c = mark());
    row
}

/// K, g and the Laplacian of a row, with the operations of sums; `square` is u less the shift.
fn row_at<T: Real, const D: usize>(row: &[T; ROW], t: T, square: T) -> [T; 3] {
    let n = terms::<T>();
    let horner = |from: usize, factor: &dyn Fn(usize) -> f64| {
        let terms = row.iter().enumerate().take(n).skip(from).rev();
        terms.fold(T::ZERO, |sum, (k, &c)| sum * t + c * T::from_f64(factor(k)))
    };
    let g = horner(0, &|_| 1.0);
    let value = horner(0, &|k| 0.5 / (k as f64 + 1.0)) * t + row.get(n).copied().unwrap_or(T::NAN);
    let slope = horner(1, &|k| 2.0 * k as f64);
    [value, g, square * slope + T::from_usize(D) * g]
}

/// A host's kernel as a table must meet it.
pub(crate) struct Demands<'a> {
    /// K, K'/r and the Laplacian of the sum, and its magnitudes: of each term.
    pub(crate) sample: &'a dyn Fn(f64) -> [Extended; 3],
    pub(crate) sizes: &'a dyn Fn(f64) -> [Extended; 3],
    /// Distances at which it is not smooth.
    pub(crate) knots: &'a [f64],
    /// The error that is allowed, relative to the sizes.
    pub(crate) goal: f64,
}

/// Where in a panel it is compared.
const COMPARED: [f64; 5] = [0.03, 0.26, 0.5, 0.74, 0.97];
/// One of so many panels may be marked for its error.
const MARKED: usize = 8;

/// Compares a table's panels with a host's kernel, and marks those that hold a knot or miss the goal. Returns the largest errors of K, g and the
/// Laplacian in the others, relative to the sizes, with those that roundings of the distance make.
pub(crate) fn compare<T: Real, const D: usize>(rows: &mut Rows<T>, head: &mut Head, demands: &Demands<'_>) -> [f64; 3] {
    let Head { unit, shift, exponent, .. } = *head;
    let in_units = |r: f64, numbers: [Extended; 3]| {
        let per_square = |value: Extended| value.scale(unit).scale(unit);
        let [value, factor, laplacian] = numbers;
        let values = [value, per_square(factor), per_square(laplacian)].map(|value| value.in_units(exponent));
        (values, magnitudes::<D>(r / unit, values))
    };
    let least_size = 1.0_f64.ldexp(64 - T::MAX_EXPONENT);
    let mut inside = (0.0, [0.0; 3]);
    if shift > 0.0 {
        inside.0 = 1.0;
        for k in 0..=16 {
            let r = unit * f64::from(k) / 16.0;
            inside.1 = larger(inside.1, in_units(r, (demands.sizes)(r)).1);
        }
    }
    let mut sizes = Sizes::new(inside, [least_size; 3]);
    let mut missing = [0_u64; ROWS / 64];
    let (mut worst, mut worst_of_all) = ([0.0; 3], [0.0; 3]);
    let (mut panels, mut missed) = (0, 0);
    let rounding = T::EPSILON.to_f64();
    let mut least = head.first;
    while least < head.last {
        let octave = Scalar::frexp(least).1 - 1;
        let whole = 1.0_f64.ldexp(octave - PANEL_BITS as i32);
        let width = whole.min(head.last - least);
        let (from, number) = (least, row::<T>(least));
        least += whole;
        let Some(row) = rows.get_mut(number) else { continue };
        let is_marked = |row: &[T; ROW]| row.iter().take(1).all(|&c| c >= mark());
        let left_out = |range: &[f64; 2]| from >= range[0] && from < range[1];
        let holds = |&knot: &f64| {
            let u = (knot / unit) * (knot / unit) + shift;
            u - from > 8.0 * rounding * u && from + width - u > 8.0 * rounding * u
        };
        panels += 1;
        let skipped = is_marked(row) || left_out(&head.gap);
        if demands.knots.iter().any(holds) {
            (*row, head.marked) = (marked(), true);
            continue;
        }
        if skipped {
            continue;
        }
        let mut errors = [0.0; 3];
        for y in COMPARED {
            let square = from + y * width - shift;
            let r = unit * square.max(0.0).sqrt();
            let (want, _) = in_units(r, (demands.sample)(r));
            let (_, magnitudes) = in_units(r, (demands.sizes)(r));
            let size = sizes.at(r / unit, magnitudes);
            // The distance's square has up to 5 units of rounding.
            for moved in [1.0 - 2.0 * rounding, 1.0 + 2.0 * rounding] {
                let u = T::from_f64(square * moved + shift);
                let mut got = row_at::<T, D>(row, u - T::from_f64(from), u - T::from_f64(shift)).map(T::to_f64);
                if left_out(&head.rough) {
                    got[2] = want[2];
                }
                errors = relative_errors(errors, got, want, size);
            }
        }
        worst_of_all = larger(worst_of_all, errors);
        if errors.iter().all(|&error| error <= demands.goal) {
            worst = larger(worst, errors);
        } else {
            missing.get_mut(number / 64).into_iter().for_each(|word| *word |= 1 << (number % 64));
            missed += 1;
        }
    }
    if missed * MARKED > panels {
        return worst_of_all;
    }
    for (number, row) in rows.iter_mut().enumerate() {
        if missing.get(number / 64).is_some_and(|word| word >> (number % 64) & 1 == 1) {
            (*row, head.marked) = (marked(), true);
        }
    }
    worst
}

/// The largest errors of g, relative to the largest of the panel, and of the Laplacian, relative to the larger of it and D g.
fn errors<const D: usize, const N: usize>(
    coefficients: &[f64; N],
    width: f64,
    at: impl Fn(f64) -> (f64, [f64; 3]),
) -> [f64; 2] {
    let d = D as f64;
    let ends = [coefficients.first().copied().unwrap_or(0.0), coefficients.iter().sum()];
    let largest = ends.iter().fold(f64::MIN_POSITIVE, |most: f64, v| most.max(v.abs()));
    let mut worst = [0.0_f64; 2];
    for y in [0.03, 0.5, 0.97] {
        let (square, [_, factor, laplacian]) = at(y);
        let (mut got, mut slope) = (0.0, 0.0);
        for &c in coefficients.iter().rev() {
            slope = slope * y + got;
            got = got * y + c;
        }
        let got_laplacian = d * got + 2.0 * square * slope / width;
        let size = (d * largest).max(laplacian.abs());
        worst = [worst[0].max((got - factor).abs() / largest), worst[1].max((got_laplacian - laplacian).abs() / size)];
    }
    worst
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernel::{Kernel, Law, Term};
    use crate::mollifier::Mollifier;
    use std::vec;

    fn rows<T: Real>() -> std::boxed::Box<Rows<T>> {
        vec![[T::ZERO; ROW]; ROWS].into_boxed_slice().try_into().unwrap()
    }

    /// A kernel as a table samples it.
    fn in_range(kernel: impl Fn(f64) -> [f64; 3]) -> impl Fn(f64) -> [Extended; 3] {
        move |r| kernel(r).map(|value| Extended::new(value, 0))
    }

    /// K = sqrt(r^2 + 1), analytic in r^2.
    fn plummer(r: f64) -> [f64; 3] {
        let root = (r * r + 1.0).sqrt();
        [root, 1.0 / root, 3.0 / root - r * r / (root * root * root)]
    }

    #[test]
    fn a_smooth_kernel_is_met_to_rounding() {
        let domain = Domain { unit: 0.7, shift: 1.0, until: f64::INFINITY, ends: false, edges: 1, reach: None };
        let mut table = rows::<f64>();
        let head = build::<f64, 3>(&mut table, &domain, 0, &in_range(plummer)).unwrap();
        assert_eq!((head.gap, head.last, head.ends), ([0.0; 2], 2.0_f64.powi(64), false));
        assert!(head.error < 2e-15, "{}", head.error);
        for k in 0..2000 {
            let r = 1e-3 * 1.008_f64.powi(k);
            let u = (r / 0.7) * (r / 0.7) + 1.0;
            if u >= head.last {
                continue;
            }
            let numbers = table[row::<f64>(u)];
            let t = u - f64::from_bits(u.to_bits() >> 46 << 46);
            let g = numbers[..7].iter().rev().fold(0.0, |sum, c| sum * t + c);
            let got = g * 2.0_f64.powi(head.exponent) / (0.7 * 0.7);
            // u itself is rounded: at large r that moves g by its own rounding.
            assert!((got - plummer(r)[1]).abs() < 4e-15 * plummer(r)[1], "{r} {got}");
        }
    }

    #[test]
    fn panels_beside_a_rough_edge_are_left_out() {
        // g = 1 inside, and 1 + (s - 1)^(5/2) beyond r = 1: the fifth difference of a panel there is too large.
        let rough = |r: f64| {
            let s = (r * r - 1.0).max(0.0);
            [0.5 * r * r + s.powf(3.5) / 7.0, 1.0 + s.powf(2.5), 2.0 + 2.0 * s.powf(2.5) + 5.0 * r * r * s.powf(1.5)]
        };
        let domain = Domain { unit: 1.0, shift: 1.0, until: f64::INFINITY, ends: false, edges: 1, reach: None };
        let mut table = rows::<f64>();
        let head = build::<f64, 2>(&mut table, &domain, 0, &in_range(rough)).unwrap();
        assert!(head.gap[0] == 2.0 && head.gap[1] > 2.0 && head.gap[1] <= 2.5, "{:?}", head.gap);
    }

    #[test]
    fn a_table_may_end_within_a_panel() {
        let domain = Domain { unit: 1.0, shift: 1.0, until: 5.01, ends: true, edges: 0, reach: None };
        let mut table = rows::<f32>();
        let jump = |r: f64| if r * r + 1.0 < 5.01 { plummer(r) } else { [0.0; 3] };
        let head = build::<f32, 3>(&mut table, &domain, 0, &in_range(jump)).unwrap();
        assert!(head.ends && head.last == 5.01 && head.error < 1e-6, "{head:?}");
        let numbers = table[row::<f32>(5.005)];
        let g = numbers[..4].iter().rev().fold(0.0, |sum, c| sum * 0.005 + c);
        let got = f64::from(g) * 2.0_f64.powi(head.exponent);
        let want = plummer(4.005_f64.sqrt())[1];
        assert!((got - want).abs() < 3e-7 * want, "{got} {want}");
    }

    /// Deterministic numbers in [0, 1).
    struct Split(u64);

    impl Split {
        fn uniform(&mut self) -> f64 {
            self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
            let mut z = self.0;
            z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
            z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
            ((z ^ (z >> 31)) >> 11) as f64 / 2.0_f64.powi(53)
        }
        fn below(&mut self, n: u32) -> u32 {
            (self.uniform() * f64::from(n)) as u32
        }
    }

    fn aligned(bytes: usize) -> (vec::Vec<u8>, usize) {
        let memory = vec![0_u8; bytes + 64];
        let start = memory.as_ptr().align_offset(64);
        (memory, start)
    }

    /// K, g and the Laplacian of a table's row at r, in the scalar and with the operations of sums; none where it is left out.
    fn read<T: Real, const D: usize>(table: &Table<'_, T>, r: T) -> [Option<f64>; 3] {
        let head = &table.head;
        let scale = T::from_f64(1.0 / (head.unit * head.unit));
        let u = r * r * scale + T::from_f64(head.shift);
        let inside = |range: &[f64; 2]| u.to_f64() >= range[0] && u.to_f64() < range[1];
        if u.to_f64() < head.first || u.to_f64() >= head.last || inside(&head.gap) {
            return [None; 3];
        }
        let row = table.rows[row::<T>(u.to_f64())];
        let bits = T::DIGITS - 1 - PANEL_BITS;
        let t = if T::DIGITS > 24 {
            T::from_f64(u.to_f64() - f64::from_bits(u.bits() >> bits << bits))
        } else {
            T::from_f64(u.to_f64() - f64::from(f32::from_bits((u.bits() >> bits << bits) as u32)))
        };
        let n = terms::<T>();
        let horner = |from: usize, f: &dyn Fn(usize) -> f64| {
            row[from..n].iter().enumerate().rev().fold(T::ZERO, |sum, (k, &c)| sum * t + c * T::from_f64(f(k + from)))
        };
        let g = horner(0, &|_| 1.0);
        let value = horner(0, &|k| 0.5 / (k as f64 + 1.0)) * t + row[n];
        let slope = horner(1, &|k| 2.0 * k as f64);
        let laplacian = (u - T::from_f64(head.shift)) * slope + T::from_usize(D) * g;
        let of_value = 1.0_f64.ldexp(head.exponent);
        let of_g = of_value / (head.unit * head.unit);
        let smooth = !inside(&head.rough);
        [Some(value.to_f64() * of_value), Some(g.to_f64() * of_g), smooth.then(|| laplacian.to_f64() * of_g)]
    }

    /// The sizes that errors of sums are relative to: the largest |K|, |K'/r| and of |Laplacian| and D |K'/r|, at distances from r / 2 to r, and
    /// below delta at all distances below it.
    fn sizes<const D: usize>(kernel: &Kernel<'_, f64, D>, from: f64, to: f64) -> [f64; 3] {
        let mut most = [0.0_f64; 3];
        for k in 0..=24 {
            let [v, g, l] = kernel.at(from + (to - from) * f64::from(k) / 24.0).map(f64::abs);
            most = [most[0].max(v), most[1].max(g), most[2].max(l).max(D as f64 * g)];
        }
        most
    }

    /// The errors of K, g and the Laplacian in units of u s, s as in the module's description; none where the kernel has no table.
    fn errors_in_u<T: Real, const D: usize>(
        split: &mut Split,
        law: Law,
        (mollifier, delta): (Mollifier, f64),
        distances: usize,
    ) -> Option<[f64; 3]> {
        let terms = [Term { law, coefficient: 1.0 }];
        let delta = T::from_f64(delta);
        let (mut memory, start) = aligned(Kernel::<f64, D>::workspace_bytes(&terms, mollifier).ok()?);
        let double = Kernel::<f64, D>::prepare(&mut memory[start..], &terms, mollifier, delta.to_f64()).ok()?;
        let (mut memory, start) = aligned(Kernel::<T, D>::workspace_bytes(&terms, mollifier).unwrap());
        let kernel = Kernel::<T, D>::prepare(&mut memory[start..], &terms, mollifier, delta).ok()?;
        let table = kernel.table()?;
        let delta = delta.to_f64();
        let unit = if kernel.is_singular() { table.head.unit } else { delta };
        let inside = (!kernel.is_singular()).then(|| sizes(&double, 0.0, delta));
        let decays = matches!(law, Law::Exponential { .. } | Law::Screened { .. });
        let from_centre = decays && matches!(mollifier, Mollifier::Gaussian { .. });
        let mut worst = [0.0_f64; 3];
        for k in 0..distances {
            let ratio = match k % 6 {
                0 => 0.05 * split.uniform(),
                1 | 2 => 2.0_f64.powf(14.0 * split.uniform() - 7.0),
                _ => split.uniform(),
            };
            let r = T::from_f64(unit * ratio);
            let got = read::<T, D>(&table, r);
            let r = r.to_f64();
            let want = double.at(r);
            let mut scale = sizes(&double, 0.5 * r, r);
            if let Some(inside) = inside.filter(|_| r < delta || from_centre) {
                scale.iter_mut().zip(inside).for_each(|(s, i)| *s = s.max(i));
            }
            // K of a logarithm is zero somewhere.
            scale[0] = scale[0].max(r * r * scale[1]);
            for ((worst, scale), (got, want)) in worst.iter_mut().zip(scale).zip(got.into_iter().zip(want)) {
                // What underflows has no relative error.
                let least = 1.0_f64.ldexp(64 - T::MAX_EXPONENT + table.head.exponent);
                let error = (got.unwrap_or(want) - want).abs() / scale / (0.5 * T::EPSILON.to_f64());
                *worst = if scale < least || error <= *worst { *worst } else { error };
            }
        }
        Some(worst)
    }

    fn check<T: Real, const D: usize>(split: &mut Split, law: Law, shape: (Mollifier, f64)) {
        let Some(errors) = errors_in_u::<T, D>(split, law, shape, 300) else { return };
        let far = shape.1 > 5.0 && matches!(law, Law::Exponential { .. } | Law::Screened { .. });
        let bounds = match (T::DIGITS > 24, far) {
            (false, _) => [32.0; 3],
            (true, false) => [128.0, 128.0, 1000.0],
            (true, true) => [400.0, 400.0, 3000.0],
        };
        let within = errors.iter().zip(bounds).all(|(error, bound)| *error <= bound);
        assert!(within, "{D}D {law:?} {shape:?}: {errors:?}");
    }

    /// Exponentials of length 1 and powers under random mollifiers.
    #[test]
    fn tables_of_random_kernels_are_within_their_bound() {
        fn random<T: Real, const D: usize>(count: usize) {
            let mut split = Split(D as u64 + u64::from(T::DIGITS));
            for _ in 0..count {
                let law = match split.below(4) {
                    0 => Law::Power { exponent: (8.0 + D as f64) * split.uniform() + 2.05 - D as f64 },
                    1 => Law::Exponential { length: 1.0 },
                    2 => Law::Screened { k: 1.0 },
                    _ => Law::Newtonian,
                };
                let mollifier = match split.below(8) {
                    0 => Mollifier::None,
                    1 | 2 => Mollifier::Gaussian { order: 2 * (1 + split.below(3)) },
                    _ => Mollifier::Compact { order: 2 * (1 + split.below(4)), exponent: 1 + split.below(9) },
                };
                let delta = 2.0_f64.powf(12.0 * split.uniform() - 6.0);
                check::<T, D>(&mut split, law, (mollifier, delta));
            }
        }
        random::<f64, 1>(45);
        random::<f64, 2>(10);
        random::<f64, 3>(45);
        random::<f32, 1>(45);
        random::<f32, 2>(10);
        random::<f32, 3>(45);
    }

    /// The mollifiers that change fastest within their support.
    #[test]
    fn tables_of_the_highest_orders_are_within_their_bound() {
        let mut split = Split(5);
        for (order, exponent) in [(8, 9), (8, 8), (6, 9)] {
            let mollifier = Mollifier::Compact { order, exponent };
            check::<f64, 1>(&mut split, Law::Exponential { length: 4.382_391_825_094_345 }, (mollifier, 3.5166));
            check::<f64, 1>(&mut split, Law::Power { exponent: 5.643_698_267_871_514 }, (mollifier, 49.0));
            check::<f64, 2>(&mut split, Law::Power { exponent: 1.5 }, (mollifier, 0.1));
            check::<f64, 3>(&mut split, Law::Screened { k: 1.0 }, (mollifier, 0.5));
            check::<f32, 1>(&mut split, Law::Exponential { length: 4.382_391_825_094_345 }, (mollifier, 3.5166));
            check::<f32, 3>(&mut split, Law::Screened { k: 1.0 }, (mollifier, 0.5));
        }
    }
}

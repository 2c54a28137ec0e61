//! Even powers: the field is a polynomial of the target's position, whose coefficients are moments of the sources. O(n).
//!
//! With K_delta = sum_k a_k |x|^{2k}, mollified or not, and multi-indices over the dimensions,
//!
//! |x - y|^{2k} = sum_{|g| = k} k!/g! prod_d sum_{a_d} C(2 g_d, a_d) x_d^{a_d} (-y_d)^{2 g_d - a_d}.
//!
//! Moments and positions are taken about the sources' centre (weights |m|): then sum |m| |y-c|^{2k} and
//! |x-c|^{2k} sum |m| are each at most 4^k sum |m| |x-y|^{2k}, and the expansion loses a bounded factor only. The centre is
//! estimated from a few sources and corrected, by a second pass, where that was not good enough.
//!
//! All of it is computed in units ([`Frame`]) taken from the targets and a few sources; where that was not good enough for a power to stay in range, from all
//! sources. The largest distances from the centre are as large as their powers allow, so that the powers of others, 2^-24 times as large, are in range
//! too. Targets that are farther away, or closer to sources which are all in one place, are evaluated one by one in units of their own. So a true result in
//! range is computed, whatever the scene's units.

mod frame;
mod polynomial;

use super::finite::finite;
use super::options::{Accumulation, Options};
use super::pairs::{Units, power_of_two_pair};
use super::problem::{Outputs, Sources, Wanted};
use crate::checked::Present;
use crate::error::{Error, Result};
use crate::exec::{Chunks, MAX_WORKERS, Run, Statistics, par_chunks};
use crate::kernel::{Far, Scaled};
use crate::memory::{Carve, Measure, Space};
use crate::real::{DoubleWord, Real, quotient};
use crate::simd::{Loops, with_simd};
use frame::Frame;
use polynomial::horner;

/// Particles per vector operation: two registers of AVX2.
const LANES: usize = 8;
/// Blocks of lanes that are summed in single words before they go into double words.
const BLOCKS: usize = 64;
/// The same in compensated sums.
const FEW_BLOCKS: usize = 8;
/// Sources, or targets, of one task.
const TASK: usize = 1 << 14;
/// The highest degree.
pub(super) const DEGREE: usize = 8;
/// Monomials of at most that degree in three variables.
const MONOMIALS: usize = 165;
/// Numbers a task adds to its moments: sum |m|, sum |m| y, sum |m| |y|^2.
const EXTRA: usize = 5;
/// Sources that the first centre is taken from.
const SAMPLE: usize = 1024;
/// Distances from the centre below this, in units of the largest coordinate, have units of their own.
const SMALL_SPREAD: f64 = 1.0 / 256.0;

/// The binary exponent of the largest distances, in units. Sums of powers up to `degree` of twice that distance are in range, and so is the next power.
fn largest_distance<T: Real>(degree: usize) -> i32 {
    (T::MAX_EXPONENT - 40) / (degree.min(DEGREE) as i32 + 1)
}

/// Minus the binary exponent of the least distances, in units, whose powers up to `degree` are in the normal range.
fn least_distance<T: Real>(degree: usize) -> i32 {
    (T::MAX_EXPONENT - 8) / degree.clamp(1, DEGREE) as i32
}

/// Monomials of at most `degree` in `dimension` variables.
fn monomials(dimension: usize, degree: usize) -> usize {
    (1..=dimension).fold(1, |count, k| count * (degree + k) / k.max(1))
}

/// Calls `f(a, b, c)` for all exponents with a + b + c <= degree, in the order in which moments are kept.
fn each_exponent(dimension: usize, degree: usize, mut f: impl FnMut([usize; 3])) {
    for a in 0..=degree {
        for b in 0..=(if dimension > 1 { degree - a } else { 0 }) {
            for c in 0..=(if dimension > 2 { degree - a - b } else { 0 }) {
                f([a, b, c]);
            }
        }
    }
}

/// Where a monomial is kept.
fn place(dimension: usize, degree: usize, exponents: [usize; 3]) -> usize {
    let (mut index, mut found) = (0, 0);
    each_exponent(dimension, degree, |e| {
        if e == exponents {
            found = index;
        }
        index += 1;
    });
    found
}

struct Arrays<'w, T> {
    /// A task's sums: high words, low words, extra.
    partial: &'w mut [T],
    /// A worker's running sums: single words, high words, low words.
    running: &'w mut [[[T; LANES]; 3]],
}

/// Running sums of a worker: an even number, so that the workspace grows by as much for each.
fn running(count: usize) -> usize {
    count.next_multiple_of(2)
}

fn layout<'w, T: Real>(space: &mut impl Space<'w>, count: usize, n: usize, workers: usize) -> Result<Arrays<'w, T>> {
    let each = 2 * count + EXTRA;
    Ok(Arrays {
        partial: space.try_array(n.div_ceil(TASK).checked_mul(each).ok_or(Error::TooLarge)?)?,
        running: space.try_array(workers.clamp(1, MAX_WORKERS) * running(count))?,
    })
}

/// Bytes of workspace.
pub(super) fn workspace_bytes<T: Real, const D: usize>(
    degree: usize,
    n_sources: usize,
    workers: usize,
) -> Result<usize> {
    Measure::of(|space| layout::<T>(space, monomials(D, degree), n_sources, workers).map(|_| ()))
}

/// Sums of one task's sources.
struct Sum<'a, T, const D: usize> {
    positions: &'a [[T; D]],
    masses: &'a [T],
    frame: Frame<T, D>,
    degree: usize,
    blocks: usize,
    running: &'a mut [[[T; LANES]; 3]],
    partial: &'a mut [T],
}

impl<T: Real, const D: usize> Loops for Sum<'_, T, D> {
    type Out = ();

    #[inline(always)]
    fn run(self) {
        // the usual degrees as constants, so that their loops are unrolled
        match self.degree {
            1 => self.of_degree(1),
            3 => self.of_degree(3),
            degree => self.of_degree(degree),
        }
    }
}

impl<T: Real, const D: usize> Sum<'_, T, D> {
    #[inline(always)]
    fn of_degree(self, degree: usize) {
        let Self { positions, masses, frame, blocks, running, partial, .. } = self;
        let count = running.len();
        let (words, extra) = partial.split_at_mut_checked(2 * count).unwrap_or((&mut [], &mut []));
        let mut sizes = [[T::ZERO; LANES]; EXTRA];
        let [_, mass] = frame.factors;
        running.fill([[T::ZERO; LANES]; 3]);
        let together = (LANES * blocks).max(1);
        for (group, weights) in positions.chunks(together).zip(masses.chunks(together)) {
            for (block, weight) in group.chunks(LANES).zip(weights.chunks(LANES)) {
                let x = offsets(block, &frame);
                let mut m = match <&[T; LANES]>::try_from(weight) {
                    Ok(whole) => *whole,
                    Err(_) => {
                        let mut m = [T::ZERO; LANES];
                        m.iter_mut().zip(weight).for_each(|(m, &w)| *m = w);
                        m
                    }
                };
                m.iter_mut().for_each(|m| *m *= mass);
                add_block(&x, &m, degree, running, &mut sizes);
            }
            for [single, high, low] in running.iter_mut() {
                for ((single, high), low) in single.iter_mut().zip(high).zip(low) {
                    let sum = DoubleWord { hi: *high, lo: *low }.plus(*single);
                    (*high, *low, *single) = (sum.hi, sum.lo, T::ZERO);
                }
            }
        }
        let (high, low) = words.split_at_mut_checked(count).unwrap_or((&mut [], &mut []));
        for (([_, of_high, of_low], high), low) in running.iter().zip(high).zip(low) {
            let lanes = of_high.iter().zip(of_low);
            let sum = lanes.fold(DoubleWord::ZERO, |sum, (&hi, &lo)| sum + DoubleWord { hi, lo });
            (*high, *low) = (sum.hi, sum.lo);
        }
        for (slot, lanes) in extra.iter_mut().zip(sizes) {
            *slot = lanes.into_iter().fold(T::ZERO, |sum, v| sum + v);
        }
    }
}

/// Coordinates relative to the centre, in units, lane by lane; lanes without a point are 0.
#[inline(always)]
fn offsets<T: Real, const D: usize>(points: &[[T; D]], frame: &Frame<T, D>) -> [[T; LANES]; D] {
    let [length, _] = frame.factors;
    let centre = &frame.centre;
    let mut x = [[T::ZERO; LANES]; D];
    if let Ok(points) = <&[[T; D]; LANES]>::try_from(points) {
        // a whole block: loops of known length
        for (d, (x, &c)) in x.iter_mut().zip(centre).enumerate() {
            for (x, point) in x.iter_mut().zip(points) {
                if let Some(&y) = point.get(d) {
                    *x = y * length - c;
                }
            }
        }
        return x;
    }
    for (lane, point) in points.iter().enumerate() {
        for ((x, &y), &c) in x.iter_mut().zip(point).zip(centre) {
            if let Some(x) = x.get_mut(lane) {
                *x = y * length - c;
            }
        }
    }
    x
}

/// Adds m times every monomial, and the sizes.
#[inline(always)]
fn add_block<T: Real, const D: usize>(
    x: &[[T; LANES]; D],
    m: &[T; LANES],
    degree: usize,
    running: &mut [[[T; LANES]; 3]],
    sizes: &mut [[T; LANES]; EXTRA],
) {
    let none = [T::ZERO; LANES];
    let (x0, x1, x2) = (x.first().unwrap_or(&none), x.get(1).unwrap_or(&none), x.get(2).unwrap_or(&none));
    let mut slots = running.iter_mut().map(|[single, ..]| single);
    let mut wa = *m;
    for a in 0..=degree {
        if D == 1 {
            add(slots.next(), &wa);
        } else {
            let mut wb = wa;
            for b in 0..=degree - a {
                if D == 2 {
                    add(slots.next(), &wb);
                } else {
                    let mut wc = wb;
                    for _ in 0..=degree - a - b {
                        add(slots.next(), &wc);
                        wc = product(&wc, x2);
                    }
                }
                wb = product(&wb, x1);
            }
        }
        wa = product(&wa, x0);
    }
    let [weight, rest @ ..] = sizes;
    let (first, last) = rest.split_at_mut(3);
    let mut share = [T::ZERO; LANES];
    share.iter_mut().zip(m).for_each(|(s, m)| *s = m.abs());
    add(Some(weight), &share);
    for (x, slot) in x.iter().zip(first) {
        let moment = product(&share, x);
        // Not the square first, which may overflow where there is no mass.
        last.iter_mut().for_each(|slot| add(Some(slot), &product(&moment, x)));
        add(Some(slot), &moment);
    }
}

#[inline(always)]
fn product<T: Real>(a: &[T; LANES], b: &[T; LANES]) -> [T; LANES] {
    let mut c = *a;
    c.iter_mut().zip(b).for_each(|(c, &b)| *c *= b);
    c
}

#[inline(always)]
fn add<T: Real>(slot: Option<&mut [T; LANES]>, term: &[T; LANES]) {
    if let Some(slot) = slot {
        slot.iter_mut().zip(term).for_each(|(s, &t)| *s += t);
    }
}

/// Polynomials of the target's position, of degree p, p - 1 and p - 2, each in the order of [`each_exponent`].
struct Field<T> {
    value: [T; MONOMIALS],
    gradient: [[T; MONOMIALS]; 3],
    laplacian: [T; MONOMIALS],
}

/// The degree of the moments that the outputs need: those of degree p enter the potential's constant alone.
fn highest_moment(degree: usize, outputs: Wanted) -> usize {
    let less = match outputs {
        Wanted { potential: true, .. } => 0,
        Wanted { gradient: true, .. } => 1,
        _ => 2,
    };
    degree.saturating_sub(less)
}

impl<T: Real> Field<T> {
    fn new<const D: usize>(
        far: &Scaled<T>,
        degree: usize,
        (moments, highest): (&[DoubleWord<T>; MONOMIALS], usize),
        options: &Options,
    ) -> Self {
        let zero = [T::ZERO; MONOMIALS];
        let mut field = Self { value: zero, gradient: [zero; 3], laplacian: zero };
        // sum over |g| = k of k!/g! a_k, for each target monomial
        for (slot, e) in field.value.iter_mut().zip(exponents::<D>(degree)) {
            let mut sum = DoubleWord::ZERO;
            each_exponent(D, degree / 2, |g| {
                let k: usize = g.iter().sum();
                let Some(&coefficient) = far.coefficients.get(2 * k).filter(|&&c| c != T::ZERO) else { return };
                if e.iter().zip(g).any(|(&e, g)| e > 2 * g) {
                    return;
                }
                let multinomial = factorial(k) / g.iter().map(|&g| factorial(g)).product::<f64>();
                let binomials: f64 = e.iter().zip(g).map(|(&e, g)| choose(2 * g, e)).product();
                let sign = if e.iter().sum::<usize>() % 2 == 0 { 1.0 } else { -1.0 };
                let rest = [2 * g[0] - e[0], 2 * g[1] - e[1], 2 * g[2] - e[2]];
                if rest.iter().sum::<usize>() > highest {
                    return;
                }
                let moment = moments.get(place(D, highest, rest)).copied().unwrap_or(DoubleWord::ZERO);
                sum = sum + moment * (coefficient * T::from_f64(sign * multinomial * binomials));
            });
            *slot = sum.hi;
        }
        // d/dx_d of x^e is e_d x^(e - 1_d): the derivative's coefficient at e comes from the value's one degree up
        let up = |e: [usize; 3], d: usize, by: usize| {
            let mut raised = e;
            if let Some(slot) = raised.get_mut(d) {
                *slot += by;
            }
            let factor = T::from_usize(raised.get(d).copied().unwrap_or(0));
            (factor, field.value.get(place(D, degree, raised)).copied().unwrap_or(T::ZERO))
        };
        for d in 0..D {
            let to = field.gradient.get_mut(d).into_iter().flatten();
            for (slot, e) in to.zip(exponents::<D>(degree.saturating_sub(1))) {
                let (factor, c) = up(e, d, 1);
                *slot = factor * c;
            }
            for (slot, e) in field.laplacian.iter_mut().zip(exponents::<D>(degree.saturating_sub(2))) {
                let (factor, c) = up(e, d, 2);
                *slot += factor * (factor - T::ONE) * c;
            }
        }
        let (a, b) = options.combination;
        if (a, b) != (1.0, 0.0) {
            let (a, b) = (T::from_f64(a), T::from_f64(b));
            let [x, y, _] = &mut field.gradient;
            for (x, y) in x.iter_mut().zip(y) {
                (*x, *y) = (a * *x - b * *y, a * *y + b * *x);
            }
        }
        field
    }
}

/// All exponents in order.
fn exponents<const D: usize>(degree: usize) -> impl Iterator<Item = [usize; 3]> {
    (0..=degree).flat_map(move |a| {
        (0..=(if D > 1 { degree - a } else { 0 }))
            .flat_map(move |b| (0..=(if D > 2 { degree - a - b } else { 0 })).map(move |c| [a, b, c]))
    })
}

fn factorial(n: usize) -> f64 {
    (1..=n).map(|k| k as f64).product()
}

fn choose(n: usize, k: usize) -> f64 {
    factorial(n) / (factorial(k) * factorial(n.saturating_sub(k)))
}

/// Evaluates one task's targets.
struct Evaluate<'a, T, const D: usize> {
    field: &'a Field<T>,
    degree: usize,
    frame: Frame<T, D>,
    /// True potential, gradient and Laplacian are those in units times 2^these.
    exponents: [i32; 3],
    targets: &'a [[T; D]],
    outputs: Outputs<'a, T, D>,
}

/// One of the polynomials that lead to an output.
struct Row<'a, T> {
    coefficients: &'a [T; MONOMIALS],
    degree: usize,
    /// The result is the polynomial times 2^this, or times these factors one after the other.
    exponent: i32,
    scale: [T; 2],
    wanted: bool,
}

/// The polynomials at an offset of any size: in units of its own.
#[cold]
#[inline(never)]
fn at_any_distance<T: Real, const D: usize>(rows: &[Row<'_, T>; 5], x: &[T; D]) -> [T; 5] {
    let mut values = [T::ZERO; 5];
    let exponent = x.iter().fold(T::ZERO, |most, x| most.max(x.abs())).frexp().1;
    let mut lanes = [[T::ZERO; LANES]; D];
    for (lanes, x) in lanes.iter_mut().zip(x) {
        lanes.iter_mut().take(1).for_each(|lane| *lane = x.ldexp(exponent.saturating_neg()));
    }
    for (value, row) in values.iter_mut().zip(rows).filter(|(_, row)| row.wanted) {
        let mut coefficients = [T::ZERO; MONOMIALS];
        for ((to, c), e) in coefficients.iter_mut().zip(row.coefficients).zip(exponents::<D>(row.degree)) {
            let less = row.degree.saturating_sub(e.iter().sum()) as i32;
            *to = c.ldexp(less.saturating_mul(exponent).saturating_neg());
        }
        let [first, ..] = horner(&coefficients, row.degree, &lanes);
        *value = first.ldexp(exponent.saturating_mul(row.degree as i32).saturating_add(row.exponent));
    }
    values
}

impl<T: Real, const D: usize> Loops for Evaluate<'_, T, D> {
    type Out = ();

    #[inline(always)]
    fn run(self) {
        let Self { field, degree, frame, exponents: [of_potential, of_gradient, of_laplacian], targets, outputs } =
            self;
        let Wanted { potential, gradient, laplacian, .. } = outputs.wanted();
        let row = |coefficients, less: usize, exponent, wanted| {
            let degree = degree.saturating_sub(less);
            Row { coefficients, degree, exponent, scale: power_of_two_pair(exponent), wanted }
        };
        let [least, most] = frame.distances;
        let [x, y, z] = field.gradient.each_ref();
        let rows = [
            row(&field.value, 0, of_potential, potential),
            row(&field.laplacian, 2, of_laplacian, laplacian),
            row(x, 1, of_gradient, gradient),
            row(y, 1, of_gradient, gradient && D > 1),
            row(z, 1, of_gradient, gradient && D > 2),
        ];
        let mut blocks = (
            outputs.potential.unwrap_or_default().chunks_mut(LANES),
            outputs.laplacian.unwrap_or_default().chunks_mut(LANES),
            outputs.gradient.unwrap_or_default().chunks_mut(LANES),
        );
        for targets in targets.chunks(LANES) {
            let x = offsets(targets, &frame);
            let mut size = [T::ZERO; LANES];
            for x in &x {
                size.iter_mut().zip(x).for_each(|(size, x)| *size = if x.abs() > *size { x.abs() } else { *size });
            }
            let is_out = |size: T| size > most || (size < least && size > T::ZERO);
            let some_are_out = size.iter().any(|&size| is_out(size));
            let mut within = x;
            if some_are_out {
                // Their powers might overflow, which may be trapped.
                for x in &mut within {
                    x.iter_mut().zip(&size).for_each(|(x, &size)| *x = if is_out(size) { T::ZERO } else { *x });
                }
            }
            let mut values = [[T::ZERO; LANES]; 5];
            for (values, row) in values.iter_mut().zip(&rows) {
                if row.wanted {
                    *values = horner(row.coefficients, row.degree, &within);
                    values.iter_mut().for_each(|v| *v = *v * row.scale[0] * row.scale[1]);
                }
            }
            if some_are_out {
                for (lane, _) in size.iter().enumerate().filter(|(_, size)| is_out(**size)) {
                    let at = x.each_ref().map(|x| x.get(lane).copied().unwrap_or(T::ZERO));
                    for (values, value) in values.iter_mut().zip(at_any_distance(&rows, &at)) {
                        values.get_mut(lane).into_iter().for_each(|slot| *slot = value);
                    }
                }
            }
            let [of_potential, of_laplacian, of_gradient @ ..] = &values;
            if let Some(out) = blocks.0.next() {
                out.iter_mut().zip(of_potential).for_each(|(o, &v)| *o = v);
            }
            if let Some(out) = blocks.1.next() {
                out.iter_mut().zip(of_laplacian).for_each(|(o, &v)| *o = v);
            }
            if let Some(out) = blocks.2.next() {
                if let Ok(out) = <&mut [[T; D]; LANES]>::try_from(&mut *out) {
                    // a whole block: loops of known length
                    store::<T, D>(out, of_gradient);
                } else {
                    store::<T, D>(out, of_gradient);
                }
            }
        }
    }
}

/// Lanes of coordinates as points.
#[inline(always)]
fn store<T: Real, const D: usize>(out: &mut [[T; D]], values: &[[T; LANES]; 3]) {
    for (d, values) in values.iter().enumerate() {
        for (out, &v) in out.iter_mut().zip(values) {
            if let Some(out) = out.get_mut(d) {
                *out = v;
            }
        }
    }
}

/// Writes the sums. The caller has checked lengths, targets and the workspace's size.
///
/// # Errors
/// [`Error::NotFinite`]: a source's coordinate or mass, found by the sums themselves: another pass over a million
/// sources would cost as much.
pub(super) fn evaluate<T: Real, const D: usize>(
    (far, delta): (&Far, T),
    options: &Options,
    sources: Sources<'_, T, D>,
    targets: &[[T; D]],
    outputs: Outputs<'_, T, D>,
    workspace: &mut [u8],
    run: &mut Run<'_>,
) -> Result<()> {
    let degree = far.degree();
    let highest = highest_moment(degree, outputs.wanted());
    let count = monomials(D, highest);
    let n = sources.positions.len();
    let arrays = layout::<T>(&mut Carve::new(workspace)?, count, n, run.executor.workers())?;
    let should_stop = run.should_stop;
    let stop = || should_stop.is_some_and(|stop| stop());
    let each = 2 * count + EXTRA;
    let blocks = if options.accumulation == Accumulation::Compensated { FEW_BLOCKS } else { BLOCKS };

    let mut frame = Frame::new(sources, targets, delta, degree, (n / SAMPLE).max(1));
    let mut moments = [DoubleWord::ZERO; MONOMIALS];
    // At most: units from a few sources, a better centre in them, units from all sources, a better centre in these.
    let (mut centred, mut measured) = (false, false);
    for _ in 0..4 {
        let pieces = Chunks::new(&mut *arrays.partial, each);
        let running = Chunks::new(&mut *arrays.running, running(count));
        par_chunks(run.executor, n.div_ceil(TASK), pieces, running, &|task, partial: &mut [T], running| {
            if stop() {
                return Err(Error::Stopped);
            }
            let range = task.saturating_mul(TASK);
            let end = n.min(range.saturating_add(TASK));
            let (positions, masses) =
                (sources.positions.get(range..end).present()?, sources.masses.get(range..end).present()?);
            let running = running.get_mut(..count).present()?;
            with_simd(run.level, Sum { positions, masses, frame, degree: highest, blocks, running, partial });
            Ok(())
        })?;
        moments = [DoubleWord::ZERO; MONOMIALS];
        let mut extra = [T::ZERO; EXTRA];
        for partial in arrays.partial.chunks(each.max(1)).take(n.div_ceil(TASK)) {
            let (high, rest) = partial.split_at_checked(count).unwrap_or((&[], &[]));
            for ((slot, &hi), &lo) in moments.iter_mut().zip(high).zip(rest) {
                *slot = *slot + DoubleWord { hi, lo };
            }
            for (sum, &v) in extra.iter_mut().zip(rest.iter().skip(count)) {
                *sum += v;
            }
        }
        // A coordinate or mass that is not finite leaves its trace here; so do very large ones.
        let in_range = moments.iter().map(|m| &m.hi).chain(&extra).all(|v| v.is_finite());
        if !in_range {
            if measured || !(finite(sources.positions.as_flattened(), run.level) && finite(sources.masses, run.level)) {
                return Err(Error::NotFinite);
            }
            measured = true;
            frame = Frame::new(sources, targets, delta, degree, 1);
            continue;
        }
        // |mean|^2 <= 3/4 of the mean square: the centre is within twice the sources' spread of their mean.
        let [weight, first @ .., square] = extra;
        let offset = first.map(|v| if weight > T::ZERO { quotient(v, weight) } else { T::ZERO });
        let distance = offset.iter().fold(T::ZERO, |sum, &v| sum + v * v);
        if centred || weight == T::ZERO || distance * T::from_f64(4.0) * weight <= T::from_f64(3.0) * square {
            break;
        }
        centred = true;
        frame.centre.iter_mut().zip(offset).for_each(|(c, v)| *c += v);
    }
    let far = &far.in_units(frame.position, largest_distance::<T>(degree));
    let exponent = far.exponent - frame.mass;
    let exponents = [0, 1, 2].map(|times: i32| exponent + times * frame.position);
    let field = Field::new::<D>(far, degree, (&moments, highest), options);
    let pieces = (
        outputs.potential.map(|p| Chunks::new(p, TASK)),
        outputs.gradient.map(|g| Chunks::new(g, TASK)),
        outputs.laplacian.map(|l| Chunks::new(l, TASK)),
    );
    par_chunks(
        run.executor,
        targets.len().div_ceil(TASK),
        pieces,
        (),
        &|task, (potential, gradient, laplacian), ()| {
            if stop() {
                return Err(Error::Stopped);
            }
            let start = task.saturating_mul(TASK);
            let targets = targets.get(start..targets.len().min(start.saturating_add(TASK))).present()?;
            let outputs = Outputs { potential, gradient, laplacian, hessian: None };
            with_simd(run.level, Evaluate { field: &field, degree, frame, exponents, targets, outputs });
            Ok(())
        },
    )?;
    if let Some(counters) = run.counters.as_deref_mut() {
        let massless = sources.masses.iter().filter(|&&m| m == T::ZERO).count();
        counters.add(&Statistics { massless_sources: massless as u64, ..Statistics::default() });
    }
    Ok(())
}

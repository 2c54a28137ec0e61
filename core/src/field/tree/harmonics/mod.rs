//! Expansions in solid harmonics: for Newtonian kernels in space (Greengard & Rokhlin 1997).
//!
//! In a cell with centre c and half width h the coordinates are x = (y - c) / h, and the harmonics are
//!
//! Y_n^0 = r^n P_n(cos theta), Y_n^(m,c) + i Y_n^(m,s) = sqrt(2 (n - m)! / (n + m)!) r^n P_n^m(cos theta) e^(i m phi), 0 < m <= n < p,
//!
//! without the factor (-1)^m in P_n^m. With them 1 / |x - y| = sum Y(x) Y(y) / |x|^(2 n + 1) for |y| < |x|, and rotations are orthogonal.
//!
//! * The *moments* of a cell's sources are M = sum_j m_j Y(x_j).
//! * Its *local expansion* is a potential sum L Y(x) / h.
//!
//! An expansion is stored by n; of one n all (m, c), then all (m, s): Y_n^(m,c) is number n^2 + m, Y_n^(m,s) number n^2 + n + m. So a shorter series is the beginning of a longer one.
//!
//! # Translations
//! Along the z axis a translation mixes harmonics of one m alone. Any other one is turned into that axis first: by phi about z, which mixes (m, c) and (m, s), then by theta about y, which mixes the harmonics of one n
//! ([`turns`]). So a translation takes 2 p^3 products and not p^4. Lanes are pairs of cells with the same step but for its signs: a reflection changes signs of harmonics alone.
//!
//! # Accuracy
//! A step of two widths along one axis needs all p terms. Others need fewer for the same error ([`SHARES`]); so the translations of a cell, 189 at most, take as long as 65 with all terms.
//! [`order`] is what keeps the tolerance, in the l2 norm over targets relative to sum |m| |K|, where half of all points and most of the mass are in one cluster
//! (test `tree::clusters_in_space`: at most 0.3 of it); relative to the sums themselves, with masses of random sign and uniform points, errors are a tenth of it or less. A series is least accurate in the corners of its cell: one source that outweighs all others,
//! in the corner of cells of all levels, makes errors of up to 120 times the tolerance. So cells are placed where that takes chance ([`super::cells`]).

mod bands;
mod solid;
mod translate;
mod turns;

use super::levels::{CLASSES, FIRST, Far, Passes, Workers, step_of};
use super::series::{Frame, Pair, Series, Targets};
use crate::checked::Present;
use crate::error::{Error, Result};
use crate::exec::Run;
use crate::field::pairs::{Units, power_of_two_pair};
use crate::kernel::sphere;
use crate::memory::Space;
use crate::real::{Real, Scalar};
use crate::simd::{Level, MAX_LANES};
use solid::{Moments, Slopes, Values};
use translate::{NONE, Operator, Steps, Together, Translate};
use turns::Turns;

/// The largest p.
pub(super) const MAX_ORDER: usize = 40;

/// The class of the steps from the centre of a part to that of the cell around it.
const PART: usize = 1 + 4 + 16;

/// p for so many digits.
pub(super) fn order(digits: f64) -> usize {
    let order = (2.5 + digits * (1.92 + 0.083 * digits)) as usize;
    if order > MAX_ORDER { MAX_ORDER } else { order.max(4) }
}

/// How many points of a leaf are best: near pairs then take about as long as translations.
pub(super) fn points_of_leaf(order: usize) -> usize {
    3 * order
}

/// Whether there are steps of a class.
fn exists(class: usize) -> bool {
    class == PART || step_of(class).iter().any(|&step| step > 1)
}

/// The square of a step's length in widths.
fn square_of(class: usize) -> usize {
    step_of(class).iter().map(|step| step * step).sum()
}

/// How many of p terms are needed for the error that p make after a step of two widths, in hundredths of p, by the square of the step's length: for sources and targets that are uniform in their cells, in root
/// mean square, with p = 10; less where p is larger.
const SHARES: [[usize; 2]; 15] = [
    [4, 100],
    [5, 89],
    [6, 83],
    [8, 71],
    [9, 69],
    [10, 64],
    [11, 62],
    [12, 62],
    [13, 59],
    [14, 57],
    [17, 55],
    [18, 54],
    [19, 53],
    [22, 52],
    [27, 50],
];

/// The terms that a step of a class needs, of p.
fn terms_of(class: usize, order: usize) -> usize {
    let square = square_of(class);
    let share = SHARES.iter().find(|[of, _]| *of == square).map_or(100, |[_, share]| *share);
    (order * share).div_ceil(100)
}

/// The tables of all translations, and of the harmonics.
pub(super) struct Expansions<'w, T> {
    order: usize,
    /// See [`solid`].
    recurrence: &'w mut [[T; 2]],
    slopes: &'w mut [Slopes<T>],
    /// The axes under whose reflection each harmonic changes its sign, one bit each.
    parities: &'w mut [u8],
    turns: Turns<'w, T>,
    /// cos(m phi) and sin(m phi) for all m, by the first two components of a step.
    azimuths: &'w mut [[T; 2]],
    /// The translations along an axis, one length after the other, and for a cell's parts up and down; where they begin.
    along: &'w mut [T],
    starts: [u32; SHARES.len() + 2],
    /// The way to true potentials and gradients, in factors one after the other.
    scales: [[T; 3]; 2],
}

/// Numbers of the translations along an axis, between series of so many terms.
fn along_size(terms: usize) -> usize {
    terms * (terms + 1) * (2 * terms + 1) / 6
}

/// The lengths of steps by number, then those of parts; their terms.
fn lengths(order: usize) -> impl Iterator<Item = usize> {
    let shares = SHARES.iter().map(move |[_, share]| (order * share).div_ceil(100));
    shares.chain([order, order])
}

impl<'w, T: Real> Expansions<'w, T> {
    /// The layout for p.
    pub fn layout(space: &mut impl Space<'w>, order: usize) -> Result<Self> {
        let half = order * (order + 1) / 2;
        let along = lengths(order).map(along_size).sum();
        Ok(Self {
            order,
            recurrence: space.try_array(half)?,
            slopes: space.try_array(half)?,
            parities: space.try_array(order * order)?,
            turns: Turns::layout(space, order)?,
            azimuths: space.try_array(16 * order)?,
            along: space.try_array(along)?,
            starts: [0; SHARES.len() + 2],
            scales: [[T::ZERO; 3]; 2],
        })
    }

    /// Fills the tables, for a Newtonian kernel with this coefficient and sources in units.
    pub fn prepare(&mut self, coefficient: T, units: Units<T>) -> Result<()> {
        let order = self.order;
        solid::recurrences(order, self.recurrence, self.slopes);
        for n in 0..order {
            for m in 0..=n {
                let (z, odd) = ((n + m) % 2 * 4, m % 2);
                *self.parities.get_mut(n * n + m).present()? = (z + odd) as u8;
                if m > 0 {
                    *self.parities.get_mut(n * n + n + m).present()? = (z + 2 + (1 - odd)) as u8;
                }
            }
        }
        self.turns.prepare(order)?;
        for (number, row) in self.azimuths.chunks_mut(order.max(1)).enumerate() {
            let (a, b) = ((number % 4) as f64, (number / 4) as f64);
            let length = Scalar::sqrt(a * a + b * b);
            let (cos, sin) = if length > 0.0 { (a / length, b / length) } else { (1.0, 0.0) };
            let (mut c, mut s) = (1.0, 0.0);
            for to in row {
                *to = [T::from_f64(c), T::from_f64(s)];
                (c, s) = (c * cos - s * sin, c * sin + s * cos);
            }
        }
        let mut start = 0;
        for (number, terms) in lengths(order).enumerate() {
            *self.starts.get_mut(number).present()? = start as u32;
            let to = self.along.get_mut(start..start + along_size(terms)).present()?;
            match SHARES.get(number) {
                // In half widths.
                Some(&[square, _]) => translate::across(to, terms, 2.0 * Scalar::sqrt(square as f64)),
                None => translate::between_levels(to, terms, number > SHARES.len()),
            }
            start += along_size(terms);
        }
        // The kernel is -1 / (4 pi r).
        let factor = -coefficient / T::from_f64(sphere(3));
        self.scales = [1, 2].map(|n: i32| {
            let [a, b] = power_of_two_pair::<T>(n.saturating_mul(units.position).saturating_sub(units.mass));
            [factor, a, b]
        });
        Ok(())
    }

    /// The operator of a class of steps; of parts that to the larger cells or to the smaller ones (`down`).
    fn operator(&self, class: usize, down: bool) -> Operator<'_, T> {
        let [a, b, _] = step_of(class);
        let terms = terms_of(class, self.order);
        let square = square_of(class);
        let number = match SHARES.iter().position(|[of, _]| *of == square) {
            Some(number) if class != PART => number,
            _ => SHARES.len() + usize::from(down),
        };
        let along = self.along.get(self.starts.get(number).copied().present_or(0) as usize..);
        let azimuth = self.azimuths.get((a + 4 * b) * self.order..).and_then(|rest| rest.get(..terms));
        Operator {
            terms,
            azimuth: azimuth.filter(|_| b > 0),
            turn: self.turns.of(class),
            along: along.and_then(|rest| rest.get(..along_size(terms))).present_or(&[]),
            parities: self.parities,
            stride: self.stride(),
        }
    }
}

impl<T: Real> Series<T> for Expansions<'_, T> {
    fn stride(&self) -> usize {
        (self.order * self.order).next_multiple_of(MAX_LANES)
    }

    fn scratch(&self) -> usize {
        let moments = self.recurrence.len() * 2 * MAX_LANES;
        let values = self.recurrence.len() * solid::OUTPUTS;
        translate::scratch(self.order).max(moments).max(values)
    }

    fn moments(
        &self,
        (points, masses): (&[T], &[T]),
        frame: Frame<T>,
        (to, scratch): (&mut [T], &mut [T]),
        level: Level,
    ) {
        let points = points.as_chunks::<3>().0;
        level.run(Moments { recurrence: self.recurrence, order: self.order, points, masses, frame, to, sums: scratch });
    }

    fn shift(&self, down: bool, pairs: &[Pair], (from, to, scratch): (&[T], &mut [T], &mut [T]), level: Level) {
        // The centre of a part is above that of the cell around it along its axes.
        let steps = pairs.iter().map(|&[source, target, axes]| [source, NONE, target, axes ^ 7]);
        translate(self.operator(PART, down), steps, (from, to, scratch), level);
    }

    fn values(&self, from: &[T], to: Targets<'_, T>, scratch: &mut [T], level: Level) {
        let (slopes, recurrence) = (&*self.slopes, &*self.recurrence);
        let coefficients = scratch.get_mut(..recurrence.len() * solid::OUTPUTS).unwrap_or_default();
        solid::prepare_values(self.order, slopes, from, coefficients);
        level.run(Values { recurrence, order: self.order, coefficients, to, scales: self.scales });
    }
}

/// Adds what a step makes of the expansions of some cells to those of others.
fn translate<T: Real>(
    operator: Operator<'_, T>,
    steps: impl Iterator<Item = Steps>,
    (from, to, scratch): (&[T], &mut [T], &mut [T]),
    level: Level,
) {
    const SOME: usize = 8 * MAX_LANES;
    let (mut some, mut n) = ([[0; 4]; SOME], 0);
    let mut run = |steps: &[Steps]| {
        level.run(Translate { operator, steps, from, to: &mut *to, scratch: &mut *scratch });
    };
    for step in steps {
        some.get_mut(n).into_iter().for_each(|slot| *slot = step);
        n += 1;
        if n == SOME {
            run(&some);
            n = 0;
        }
    }
    run(some.get(..n).unwrap_or_default());
}

/// Adds to the local expansions of all levels what the moments give to them.
pub(super) fn across<T: Real>(
    expansions: &Expansions<'_, T>,
    passes: &Passes<'_, '_, T>,
    (moments, locals): (&[T], &mut [T]),
    far: &Far,
    workers: &mut Workers<'_>,
    run: &Run<'_>,
) -> Result<()> {
    let (stride, level) = (expansions.stride(), run.level);
    let mut lists = [u8::MAX; CLASSES];
    for (class, list) in lists.iter_mut().enumerate().filter(|(class, _)| exists(*class)) {
        *list = class as u8;
    }
    let step = |class: usize, pairs: &[Pair], (from, to, scratch): (&[T], &mut [T], &mut [T])| {
        let operator = expansions.operator(class, false);
        let axes = step_of(class).iter().enumerate().fold(0, |axes, (axis, &step)| axes | u32::from(step > 0) << axis);
        translate(operator, Together::new(pairs, axes), (from, to, scratch), level);
    };
    for depth in FIRST..passes.cells.n_levels() {
        let range = passes.cells.of_level(depth);
        let own = locals.get_mut(range.start * stride..range.end * stride).ok_or(Error::Internal)?;
        passes.across((depth, far), &lists, &step, (moments, own), workers, run)?;
    }
    Ok(())
}

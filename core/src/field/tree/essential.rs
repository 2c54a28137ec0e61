//! Fewer sources that act as given ones do on all targets in a box: what a process sends to another one.
//!
//! A cell that is its own width away from the box acts there through its moments alone, to the tolerance. Its sources are replaced by *proxies*: q masses along each axis, at the nodes of
//! Chebyshev interpolation, that have the moments M_a of the sources for all a_i < q:
//!
//! w_n = sum_a (2 - [a_1 = 0]) / q .. T_a(x_n) M_a,
//!
//! as sum_n T_a(x_n) T_b(x_n) is zero for different a, b < q. Proxies are ordinary sources: the receiver sums them by the method it uses for particles. With expansions in place of
//! masses this is a locally essential tree (Warren & Salmon 1992).
//!
//! How many are needed follows from the kernel: on lines through the cell the coefficients of K and its gradient from q on are what is left out ([`least_order`]). The closest point
//! of the box decides, as a kernel that is smooth away from zero is smoother farther away. A cell is kept whole if it is too near, within the reach of the mollifier, or if it holds no more sources than
//! it would have proxies.

use super::cells::{Cell, Cells, DEPTH, Limits, SOURCES, STACK, Words, index};
use super::chebyshev::{
    MAX_ORDER, along_axes,
    basis::{self, Basis},
};
use super::placed::spatial;
use super::series::{Frame, Series};
use super::settings::{Settings, effective, floor};
use crate::checked::Present;
use crate::error::{Error, Result};
use crate::exec::Run;
use crate::field::finite::finite;
use crate::field::pairs::{Units, largest, support};
use crate::field::problem::{Essential, Interaction, PROXY, Sources};
use crate::kernel::Kernel;
use crate::memory::{Carve, Measure, Space};
use crate::mollifier::{Blob, Mollifier};
use crate::real::{Extended, Real, Scalar};
use crate::simd::Level;
use crate::sort::words::BUCKETS;

/// Half widths of a cell from its centre to the box in the first class; each further class is farther by the square root of two.
const NEAREST: f64 = 3.0;
/// Classes of distances.
const FAR: usize = 24;
/// Nodes of the test that are more than the order.
const MORE: usize = 4;
/// Not computed yet, and none is enough.
const UNKNOWN: u8 = 0;
const ROUGH: u8 = u8::MAX;

/// The workspace.
struct Arrays<'w, T> {
    words: &'w mut [u64],
    spare: &'w mut [u64],
    counts: &'w mut [u32],
    cells: Cells<'w, T>,
    basis: Basis<'w, T>,
    /// Of each cell the moments, and whether they are there.
    moments: &'w mut [T],
    ready: &'w mut [u8],
    scratch: &'w mut [T],
    /// The sources in the order of the cells, in units.
    points: &'w mut [T],
    masses: &'w mut [T],
    /// Two cubes of coefficients or proxies.
    cubes: [&'w mut [T]; 2],
    orders: &'w mut [u8],
    stack: &'w mut [u32],
}

fn layout<'w, T: Real>(space: &mut impl Space<'w>, settings: Settings, n: usize) -> Result<Arrays<'w, T>> {
    u32::try_from(n).map_err(|_| Error::TooLarge)?;
    let (d, order) = (settings.dimension, settings.order);
    let n_cells = settings.cells(n)?;
    let basis = Basis::layout(space, d, order)?;
    let times = |a: usize, b: usize| a.checked_mul(b).ok_or(Error::TooLarge);
    let moments = times(n_cells, basis.stride)?;
    let cube = order.pow(d as u32);
    Ok(Arrays {
        words: space.try_array(n)?,
        spare: space.try_array(n)?,
        counts: space.try_array(BUCKETS)?,
        cells: Cells::layout(space, d, n_cells)?,
        basis,
        moments: space.try_array(moments)?,
        ready: space.try_array(n_cells)?,
        scratch: space.try_array(basis::scratch(d, order))?,
        points: space.try_array(times(n, d)?)?,
        masses: space.try_array(n)?,
        cubes: [space.try_array(cube)?, space.try_array(cube)?],
        orders: space.try_array((DEPTH + 1) * FAR)?,
        stack: space.try_array(STACK)?,
    })
}

/// The settings for a kernel and a tolerance.
fn settings<T: Real, const D: usize>(kernel: &dyn Interaction<T, D>, tolerance: f64) -> Result<Settings> {
    if !Scalar::is_finite(tolerance) {
        return Err(Error::NotFinite);
    }
    if tolerance < floor::<T>() {
        return Err(Error::OutOfDomain);
    }
    let newtonian = kernel.newtonian().is_some();
    if !newtonian && !kernel.sum().is_some_and(Kernel::is_known) {
        return Err(Error::Unsupported);
    }
    // One side alone is interpolated, so that a few terms more reach the accuracy of the tree's steps at the same distance.
    let settings = Settings::polynomials(effective::<T>(tolerance), D, newtonian);
    let order = if settings.order + MORE < MAX_ORDER { settings.order + MORE } else { MAX_ORDER };
    // Smaller cells would hardly be replaced; in space, where proxies are many, by few of them far away.
    let terms = basis::count(D, order);
    let leaf = if D < 3 && terms > settings.leaf { terms } else { settings.leaf };
    Ok(Settings { order, terms, leaf, mean: 0, ..settings })
}

/// Bytes that [`essential`] needs for so many sources.
///
/// # Errors
/// As [`essential`], of the kernel and the tolerance; [`Error::TooLarge`].
pub fn essential_bytes<T: Real, const D: usize>(
    kernel: &dyn Interaction<T, D>,
    sources: usize,
    tolerance: f64,
) -> Result<usize> {
    let settings = settings(kernel, tolerance)?;
    Measure::of(|space| layout::<T>(space, settings, sources).map(|_| ()))
}

/// Finds fewer sources that act as `sources` do on all targets in a box, for each of some boxes: what a process sends to those that own the targets there. These add them to their own sources
/// in any sum of the kernel, by whatever method.
///
/// `boxes` have a lower and an upper corner each; one whose lower corner is above the upper one, along any axis, has no targets. `starts` (one more than boxes) is overwritten with where
/// those for each box begin in `to`, and their number at the end, also if there is no `to` or not enough room there.
/// Sources near a box come back as they were, with their core radii if they have any (by their origins); others as proxies, whose core radius may be any that sources have. Massless ones are
/// left out. Never are there more for a box than sources.
///
/// `tolerance`: as [`Options::tolerance`](crate::field::Options::tolerance), for potentials and gradients at every target of the boxes; at least 1e-12 (f32: 1e-5). Whatever sum follows adds its own error.
///
/// Cost: one sort, the moments of the cells that are replaced, each once, and for each box a time proportional to what comes out; on one thread. `workspace`: [`essential_bytes`]. Accuracy: test `essential::*`.
///
/// # Errors
/// [`Error::LengthMismatch`]; [`Error::NotFinite`] (a coordinate, mass, corner or the tolerance); [`Error::OutOfDomain`]: a tolerance below the least; [`Error::Unsupported`]: a kernel with functions of the host, which
/// may be smooth nowhere, vector strengths, core radii under a mollifier without end or of a kernel that is not Newtonian; [`Error::WorkspaceTooSmall`], [`Error::Misaligned`]. All of these before anything is written.
/// [`Error::NoRoom`]: `to` is too short, and filled. [`Error::Stopped`].
pub fn essential<T: Real, const D: usize>(
    kernel: &dyn Interaction<T, D>,
    sources: Sources<'_, T, D>,
    tolerance: f64,
    boxes: &[[[T; D]; 2]],
    (starts, to): (&mut [u64], Option<Essential<'_, T, D>>),
    workspace: &mut [u8],
    run: &mut Run<'_>,
) -> Result<()> {
    let settings = settings(kernel, tolerance)?;
    let n = sources.positions.len();
    let together = to.as_ref().is_none_or(|to| {
        to.masses.len() == to.positions.len() && to.origins.as_ref().is_none_or(|o| o.len() == to.masses.len())
    });
    let alike = sources.masses.len() == n && sources.radii.is_none_or(|radii| radii.len() == n);
    if sources.strengths.is_some() {
        return Err(Error::Unsupported);
    }
    if !(together && alike && starts.len() == boxes.len() + 1) {
        return Err(Error::LengthMismatch);
    }
    if !run.level.is_available() {
        return Err(Error::Unsupported);
    }
    let blob = kernel.newtonian().map(|(_, blob)| blob).or(kernel.sum().map(Kernel::blob));
    let blob = blob.ok_or(Error::Unsupported)?;
    let ratio = support::<T>(D, blob.mollifier());
    if sources.radii.is_some() && (ratio.is_none() || kernel.newtonian().is_none()) {
        return Err(Error::Unsupported);
    }
    let level = run.level;
    let corners = boxes.as_flattened().as_flattened();
    let numbers = [sources.positions.as_flattened(), sources.masses, corners, sources.radii.unwrap_or_default()];
    if !numbers.iter().all(|numbers| finite(numbers, level)) {
        return Err(Error::NotFinite);
    }
    if sources.radii.unwrap_or_default().iter().any(|&radius| radius <= T::ZERO) {
        return Err(Error::Delta);
    }
    let core = if sources.radii.is_some() { sources.largest_radius() } else { blob.delta() };
    let given = Given {
        settings,
        tolerance: effective::<T>(tolerance),
        positions: sources.positions.as_flattened(),
        masses: sources.masses,
        reach: ratio.map_or(T::ZERO, |ratio| ratio * core),
        kernel: &|half, at, to| match kernel.newtonian() {
            Some((_, blob)) => newtonian(blob, half, at, to),
            None => kernel.sum().into_iter().for_each(|sum| others(sum, half, at, to)),
        },
    };
    let mut to = to;
    let sink = Sink {
        dimension: D,
        room: to.as_ref().map_or(0, |to| to.masses.len()),
        count: 0,
        wanted: to.is_some(),
        put: &mut |number: usize, point: [T; 3], mass: T, origin: u64| {
            let Some(to) = &mut to else { return };
            if let (Some(x), Some(m)) = (to.positions.get_mut(number), to.masses.get_mut(number)) {
                x.iter_mut().zip(point).for_each(|(to, x)| *to = x);
                *m = mass;
            }
            to.origins.as_mut().and_then(|o| o.get_mut(number)).into_iter().for_each(|to| *to = origin);
        },
    };
    given.reduce(corners, (starts, sink), workspace, run)
}

/// Overwrites K and h K' at distances h x, of which h is given first, all multiplied by one number.
type OnLine<'a> = dyn Fn(f64, &[f64], &mut [[f64; 2]]) + 'a;

/// [`OnLine`] of a Newtonian kernel: but for a constant that of delta / h at x.
fn newtonian<T: Real, const D: usize>(blob: &Blob<T, D>, half: f64, at: &[f64], to: &mut [[f64; 2]]) {
    let delta = if blob.mollifier() == Mollifier::None { 1.0 } else { blob.delta().to_f64() / half };
    match Blob::<f64, D>::new(blob.mollifier(), delta) {
        Ok(blob) => to.iter_mut().zip(at).for_each(|(to, &x)| *to = [blob.potential(x), blob.gradient_factor(x) * x]),
        // So long a delta: no cell is far.
        Err(_) => to.fill([f64::NAN; 2]),
    }
}

/// [`OnLine`] of a sum of laws, whose values may be beyond the range of double precision.
fn others<T: Real, const D: usize>(sum: &Kernel<'_, T, D>, half: f64, at: &[f64], to: &mut [[f64; 2]]) {
    let (mantissa, exponent) = Scalar::frexp(half);
    let pair = |x: f64| sum.pair_scaled(half * x, [true, true, false]);
    let mut unit = i32::MIN;
    for &x in at {
        let [value, factor, _] = pair(x).map(Extended::exponent);
        let factor = factor.map(|factor| factor.saturating_add(2 * exponent));
        unit = value.into_iter().chain(factor).fold(unit, |most, e| if e > most { e } else { most });
    }
    for (to, &x) in to.iter_mut().zip(at) {
        let [value, factor, _] = pair(x);
        let factor = factor.in_units(unit.saturating_sub(2 * exponent));
        *to = [value.in_units(unit), factor * (mantissa * mantissa) * x];
    }
}

/// The arguments, with nothing generic but the scalar.
struct Given<'a, T> {
    settings: Settings,
    tolerance: f64,
    positions: &'a [T],
    masses: &'a [T],
    /// Where the mollifier of the largest core ends.
    reach: T,
    kernel: &'a OnLine<'a>,
}

/// Where results go.
struct Sink<'a, T> {
    dimension: usize,
    room: usize,
    count: u64,
    wanted: bool,
    put: &'a mut dyn FnMut(usize, [T; 3], T, u64),
}

impl<T: Real> Sink<'_, T> {
    fn push(&mut self, point: [T; 3], mass: T, origin: u64) {
        if self.count < self.room as u64 {
            (self.put)(self.count as usize, point, mass, origin);
        }
        self.count += 1;
    }
}

impl<T: Real> Given<'_, T> {
    fn reduce(
        &self,
        boxes: &[T],
        (starts, mut sink): (&mut [u64], Sink<'_, T>),
        workspace: &mut [u8],
        run: &mut Run<'_>,
    ) -> Result<()> {
        let d = self.settings.dimension.max(1);
        let arrays = layout::<T>(&mut Carve::reopen(workspace)?, self.settings, self.masses.len())?;
        let Arrays { words, spare, counts, mut cells, mut basis, moments, ready, scratch, .. } = arrays;
        let Arrays { points, masses, cubes, orders, stack, .. } = arrays;
        let has_targets = |corners: &[T]| {
            let (lower, upper) = corners.split_at_checked(d).unwrap_or_default();
            lower.iter().zip(upper).all(|(lower, upper)| lower <= upper)
        };
        if !boxes.chunks((2 * d).max(1)).any(has_targets) {
            starts.fill(0);
            return Ok(());
        }
        let units = Units::new(largest(T::ZERO, self.positions).max(self.reach), largest(T::ZERO, self.masses));
        let (unit, of_mass) = (T::ONE.ldexp(units.position), T::ONE.ldexp(units.mass));
        let mut n = 0;
        for (source, _) in self.masses.iter().enumerate().filter(|(_, m)| **m != T::ZERO) {
            *words.get_mut(n).present()? = source as u64;
            n += 1;
        }
        let words = words.get_mut(..n).present()?;
        let of = |k: usize| self.positions.get(k * d..).and_then(|rest| rest.get(..d)).present_or(&[]);
        let point = |k: usize| spatial(of(k), unit);
        let counts = counts.first_chunk_mut().present()?;
        let Settings { leaf, mean, .. } = self.settings;
        let limits = Limits { leaf, width: T::ZERO, mean, aligned: true };
        cells.divide(Words { sorts: [&mut *words, &mut []], spare, counts }, limits, &[&point, &point])?;
        let (points, masses) = (points.get_mut(..n * d).present()?, masses.get_mut(..n).present()?);
        for ((to, mass), &word) in points.chunks_mut(d.max(1)).zip(&mut *masses).zip(&*words) {
            to.iter_mut().zip(point(index(word))).for_each(|(to, x)| *to = x);
            *mass = self.masses.get(index(word)).copied().present()? * of_mass;
        }
        basis.prepare()?;
        orders.fill(UNKNOWN);
        ready.fill(0);
        let mut reduction = Reduction {
            given: self,
            cells: &cells,
            basis: &basis,
            sources: (points, masses),
            moments: Known { moments, ready, scratch, level: run.level },
            words,
            units,
            orders,
            proxies: Proxies { order: 0, at: [T::ZERO; MAX_ORDER], weights: [T::ZERO; MAX_ORDER * MAX_ORDER], cubes },
        };
        let mut slots = starts.iter_mut();
        for corners in boxes.chunks((2 * d).max(1)) {
            if run.should_stop.is_some_and(|stop| stop()) {
                return Err(Error::Stopped);
            }
            *slots.next().present()? = sink.count;
            let (lower, upper) = corners.split_at_checked(d).present()?;
            if n > 0 && has_targets(corners) {
                reduction.of_box([spatial(lower, unit), spatial(upper, unit)], stack, &mut sink)?;
            }
        }
        *slots.next().present()? = sink.count;
        if sink.wanted && sink.count > sink.room as u64 { Err(Error::NoRoom) } else { Ok(()) }
    }
}

/// Moments, computed where they are asked for.
struct Known<'w, T> {
    moments: &'w mut [T],
    ready: &'w mut [u8],
    scratch: &'w mut [T],
    level: Level,
}

impl<T: Real> Known<'_, T> {
    /// Those of cell `k`, from its sources: to lead them up from its parts takes longer.
    fn of(
        &mut self,
        (k, cell): (usize, &Cell),
        (cells, basis): (&Cells<'_, T>, &Basis<'_, T>),
        (points, masses): (&[T], &[T]),
    ) -> Result<&[T]> {
        let (d, stride, range) = (basis.dimension, basis.stride, cell.points(SOURCES));
        let to = self.moments.get_mut(k * stride..).and_then(|rest| rest.get_mut(..stride)).present()?;
        let ready = self.ready.get_mut(k).present()?;
        if *ready == 0 {
            *ready = 1;
            to.fill(T::ZERO);
            let per_half = T::TWO / cells.width(cell.level as usize);
            let points = points.get(range.start * d..range.end * d).present()?;
            let frame = Frame { centre: cells.centre(cell), per_half, factor: T::ONE };
            let sources = (points, masses.get(range).present()?);
            basis.moments(sources, frame, (&mut *to, &mut *self.scratch), self.level);
        }
        Ok(to)
    }
}

/// The cells of all sources, with what is known of them.
struct Reduction<'a, 'w, T> {
    given: &'a Given<'a, T>,
    cells: &'a Cells<'w, T>,
    basis: &'a Basis<'w, T>,
    /// In the order of the cells, in units.
    sources: (&'a [T], &'a [T]),
    moments: Known<'w, T>,
    words: &'a [u64],
    units: Units<T>,
    /// The q of each level and class of distance.
    orders: &'w mut [u8],
    proxies: Proxies<'w, T>,
}

impl<T: Real> Reduction<'_, '_, T> {
    /// The sources for a box, in units.
    fn of_box(&mut self, corners: [[T; 3]; 2], stack: &mut [u32], sink: &mut Sink<'_, T>) -> Result<()> {
        let mut waiting = 1;
        *stack.first_mut().present()? = 0;
        while waiting > 0 {
            waiting -= 1;
            let k = *stack.get(waiting).present()? as usize;
            let cell = self.cells.get(k);
            let count = cell.points(SOURCES).len();
            let q = self.order_for(&cell, corners)?.filter(|&q| q.pow(sink.dimension as u32) < count);
            if let Some(q) = q {
                self.replace(k, &cell, q, sink)?;
            } else if cell.is_leaf() {
                self.keep(&cell, sink)?;
            } else {
                for part in cell.parts().rev() {
                    *stack.get_mut(waiting).present()? = part as u32;
                    waiting += 1;
                }
            }
        }
        Ok(())
    }

    /// Gives the sources of a cell as they are.
    fn keep(&self, cell: &Cell, sink: &mut Sink<'_, T>) -> Result<()> {
        let d = sink.dimension;
        for &word in self.words.get(cell.points(SOURCES)).present()? {
            let source = index(word);
            let x = self.given.positions.get(source * d..).and_then(|rest| rest.get(..d)).present()?;
            sink.push(spatial(x, T::ONE), self.given.masses.get(source).copied().present()?, source as u64);
        }
        Ok(())
    }

    /// Gives the proxies of a cell.
    fn replace(&mut self, k: usize, cell: &Cell, q: usize, sink: &mut Sink<'_, T>) -> Result<()> {
        let moments = self.moments.of((k, cell), (self.cells, self.basis), self.sources)?;
        let half = self.cells.width(cell.level as usize) * T::HALF;
        let centre = self.cells.centre(cell);
        let units = self.units;
        self.proxies.fill(self.basis, q, moments)?;
        let number = q.pow(sink.dimension as u32);
        for (at, &mass) in self.proxies.cubes[0].iter().take(number).enumerate() {
            let (mut x, mut left) = (centre, at);
            for x in x.iter_mut().take(sink.dimension) {
                *x += half * self.proxies.at.get(left % q.max(1)).copied().present()?;
                *x = x.ldexp(-units.position);
                left /= q.max(1);
            }
            sink.push(x, mass.ldexp(-units.mass), PROXY);
        }
        Ok(())
    }

    /// The q with which a cell may be replaced for targets in a box; none: it may not.
    fn order_for(&mut self, cell: &Cell, corners: [[T; 3]; 2]) -> Result<Option<usize>> {
        let level = cell.level as usize;
        let half = self.cells.width(level) * T::HALF;
        let centre = self.cells.centre(cell);
        let mut distance = T::ZERO;
        for ((&x, &lower), &upper) in centre.iter().zip(&corners[0]).zip(&corners[1]).take(self.basis.dimension) {
            distance = distance.max(lower - x).max(x - upper);
        }
        let reach = self.given.reach.ldexp(self.units.position);
        if distance < half * T::from_f64(NEAREST) || distance - half < reach || half == T::ZERO {
            return Ok(None);
        }
        let (mut class, mut bound) = (0, NEAREST);
        while class + 1 < FAR && half * T::from_f64(bound * core::f64::consts::SQRT_2) <= distance {
            bound *= core::f64::consts::SQRT_2;
            class += 1;
        }
        let known = self.orders.get_mut(level * FAR + class).present()?;
        if *known == UNKNOWN {
            let half = half.ldexp(-self.units.position).to_f64();
            let share = self.given.tolerance / (2 * self.basis.dimension.max(2)) as f64;
            let order = least_order(self.given.kernel, (half, bound), (self.basis.dimension, self.basis.order), share);
            *known = order.map_or(ROUGH, |order| order as u8);
        }
        Ok((*known != ROUGH).then_some(usize::from(*known)))
    }
}

/// The least q <= `order` with which a kernel is interpolated in a cell of half width `half`, x half widths away in one direction, so that what is left out of K and of its gradient
/// is at most `share` of their size at any source: on the line through the cell towards the box, and on that along its closest face, where a function of the distance is least smooth (branch
/// points at an imaginary distance from the centre, 1 to 1 with the real one from the line).
fn least_order(
    kernel: &OnLine<'_>,
    (half, x): (f64, f64),
    (dimension, order): (usize, usize),
    share: f64,
) -> Option<usize> {
    const ROOM: usize = MAX_ORDER + MORE;
    let n = order + MORE;
    let cosine = |numerator: usize| Scalar::cos(core::f64::consts::PI * numerator as f64 / (2 * n) as f64);
    let mut most = 1;
    for across in [false, true].into_iter().take(if dimension > 1 { 2 } else { 1 }) {
        let (mut at, mut slopes, mut values) = ([0.0_f64; ROOM], [[0.0_f64; 2]; ROOM], [[0.0_f64; 3]; ROOM]);
        let (at, slopes, values) = (at.get_mut(..n)?, slopes.get_mut(..n)?, values.get_mut(..n)?);
        let near = x - 1.0;
        let distance = |c: f64| if across { Scalar::sqrt(near * near + c * c) } else { x + c };
        at.iter_mut().enumerate().for_each(|(i, at)| *at = distance(cosine(2 * i + 1)));
        kernel(half, at, slopes);
        // Of each third of the nodes the mean sizes: sources may be in the farthest part of the cell alone, where a kernel that falls fast is small.
        let mut thirds = [[0.0_f64; 2]; 3];
        for ((i, (to, &[value, slope])), &r) in values.iter_mut().zip(&*slopes).enumerate().zip(&*at) {
            let (along, aside) = if across { (near / r, cosine(2 * i + 1) / r) } else { (1.0, 0.0) };
            *to = [value, slope * along, slope * aside];
            let third = thirds.get_mut(3 * i / n.max(1))?;
            third.iter_mut().zip([value, slope]).for_each(|(size, v)| *size += v.abs() * 3.0 / n as f64);
        }
        let least = |k: usize| thirds.iter().filter_map(|third| third.get(k)).fold(f64::INFINITY, |a, &b| a.min(b));
        let sizes = [least(0), least(1)];
        // A potential that is small here only, as the logarithm near 1, counts as what it is at twice the distance.
        let sizes = [sizes[0].max(x * sizes[1]), sizes[1], sizes[1]];
        let mut left_out = [0.0_f64; 3];
        for k in (0..n).rev() {
            let mut coefficients = [0.0_f64; 3];
            for (i, value) in values.iter().enumerate() {
                let c = 2.0 / n as f64 * cosine(k * (2 * i + 1) % (4 * n).max(1));
                coefficients.iter_mut().zip(value).for_each(|(to, v)| *to += c * v);
            }
            left_out.iter_mut().zip(coefficients).for_each(|(to, c)| *to += c.abs());
            // A comparison that is false for numbers that are not finite.
            let fine = left_out.iter().zip(sizes).all(|(left_out, size)| *left_out <= share * size);
            if !fine && k >= order {
                return None;
            }
            if !fine {
                most = if k + 1 > most { k + 1 } else { most };
                break;
            }
        }
    }
    Some(most)
}

/// Masses at nodes, from moments.
struct Proxies<'w, T> {
    /// q, of which nodes and weights are.
    order: usize,
    at: [T; MAX_ORDER],
    /// (2 - [a = 0]) / q T_a(x_n), by n q + a.
    weights: [T; MAX_ORDER * MAX_ORDER],
    cubes: [&'w mut [T]; 2],
}

impl<T: Real> Proxies<'_, T> {
    /// Fills the first cube, the first axis fastest.
    fn fill(&mut self, basis: &Basis<'_, T>, q: usize, moments: &[T]) -> Result<()> {
        if self.order != q {
            self.order = q;
            let cosine = |numerator: usize| Scalar::cos(core::f64::consts::PI * numerator as f64 / (2 * q) as f64);
            for (n, (at, row)) in self.at.iter_mut().zip(self.weights.chunks_mut(q.max(1))).enumerate().take(q) {
                *at = T::from_f64(cosine(2 * n + 1));
                for (a, weight) in row.iter_mut().enumerate() {
                    let factor = if a == 0 { 1.0 } else { 2.0 } / q as f64;
                    *weight = T::from_f64(factor * cosine(a * (2 * n + 1) % (4 * q).max(1)));
                }
            }
        }
        let (d, [cube, spare]) = (basis.dimension, &mut self.cubes);
        let number = q.pow(d as u32);
        let (cube, spare) = (cube.get_mut(..number).present()?, spare.get_mut(..number).present()?);
        for (at, to) in cube.iter_mut().enumerate() {
            let (mut exponent, mut left) = ([0; 3], at);
            for exponent in exponent.iter_mut().take(d) {
                *exponent = left % q.max(1);
                left /= q.max(1);
            }
            *to = basis.rank(exponent).and_then(|rank| moments.get(rank)).copied().unwrap_or(T::ZERO);
        }
        along_axes(&self.weights, (q, d), cube, spare);
        Ok(())
    }
}

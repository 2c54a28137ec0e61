//! The five-point and nine-point schemes, solved by a sine or cosine transform along one axis and tridiagonal systems along the other.
//!
//! The transform runs along the axis whose number of cells is cheaper to transform (see [`super::good_size`]). "Rows" are the
//! mesh lines along it, numbered by s. With H, K the mesh widths along and across the rows, mode k of row s satisfies
//!
//! `-U_(s-1) + b U_s - U_(s+1) = F_s,  b = 2 + K^2 (4 sin^2(pi k / 2 n) / H^2 + kappa^2),  F = -K^2 (2 / n) density^`
//!
//! with the prescribed border values moved to the right-hand side. The nine-point scheme ([`Order::Fourth`]) for Laplacian(u) - kappa^2 u = f is
//!
//! `(Dxx + Dyy + (H^2 + K^2)/12 Dxx Dyy - kappa^2 P) u = P S f,  P = 1 + (H^2 Dxx + K^2 Dyy)/12`
//!
//! with D the second differences. S = 1 - (H^2 Dxx + K^2 Dyy)/6 compensates the smoothing of cloud-in-cell deposit and interpolation,
//! which together multiply a wave p by 1 - (p_x^2 H^2 + p_y^2 K^2)/6. P S is taken as 1 - (H^2 Dxx + K^2 Dyy)/12, which is equal
//! up to fourth order. A mode then satisfies the equation above with
//!
//! `b = 2 + K^2 (l + kappa^2 (1 - l H^2 / 12)) / A,  A = 1 - (l (H^2 + K^2) + kappa^2 K^2)/12,  l = 4 sin^2(pi k / 2 n) / H^2`
//!
//! and F / A. Masses are in units of their bound ([`MassScale`](super::MassScale)), so no intermediate sum leaves the range of the
//! scalar. The potential and its differences are scaled back by powers of two. There are three phases: rows, columns, rows. Each
//! task of a phase writes its own part.

use super::deposit::TAIL;
use super::fft::{Element, LANES, cost, half_root};
use super::fixed::{BITS, exact, halves};
use super::transform::{Kind, ROWS, Transform};
use super::{Equation, Mesh, Monopole, Order, Walls};
use crate::checked::Present;
use crate::error::Result;
use crate::exec::{Block, Chunks, Columns, Resources, par_chunks};
use crate::memory::Space;
use crate::real::Real;
use crate::simd::{Level, Loops, with_simd};

/// Columns per task of the second phase.
pub(super) const WIDTH: usize = 16;

/// The mesh in the solver's orientation.
#[derive(Clone, Copy, Debug)]
pub(super) struct Shape {
    pub kind: Kind,
    /// The rows run along y.
    pub along_y: bool,
    /// Cells along a row.
    pub n: usize,
    /// Cells across the rows, which are numbered 0 to m.
    pub m: usize,
    /// Distance between rows in the array, a multiple of WIDTH.
    pub pitch: usize,
}

impl Shape {
    pub fn of<T: Real>(mesh: &Mesh<T>, equation: &Equation<T>) -> Self {
        let [nx, ny] = mesh.cells();
        // The cost of transforming all rows, per node. Ties choose x, the direction of the arrays.
        let along_y = cost(ny) / ny.max(1) < cost(nx) / nx.max(1);
        let (n, m) = if along_y { (ny, nx) } else { (nx, ny) };
        let kind = if equation.walls == Walls::NoFlux { Kind::Cosine } else { Kind::Sine };
        Self { kind, along_y, n, m, pitch: (n + 1).next_multiple_of(WIDTH) }
    }

    /// The index of node (i, j) of the mesh in the solver's array.
    pub fn at(&self, i: usize, j: usize) -> usize {
        if self.along_y { i * self.pitch + j } else { j * self.pitch + i }
    }

    /// Mesh widths along and across the rows.
    pub fn spacing<T: Real>(&self, mesh: &Mesh<T>) -> [T; 2] {
        let [h, k] = mesh.spacing();
        if self.along_y { [k, h] } else { [h, k] }
    }

    /// Whether the values of row `s` are unknown.
    pub fn is_unknown(&self, s: usize) -> bool {
        match self.kind {
            Kind::Sine => 0 < s && s < self.m,
            Kind::Cosine => s <= self.m,
        }
    }
}

/// Prescribed values on a closed line around the mesh.
#[derive(Debug)]
struct Frame<'w, T> {
    /// At the first and the last node of each row.
    ends: [&'w mut [T]; 2],
    /// On the first and the last row.
    rows: [&'w mut [T]; 2],
}

impl<'w, T: Real> Frame<'w, T> {
    fn layout(space: &mut impl Space<'w>, shape: &Shape) -> Result<Self> {
        let (n, m) = (shape.n + 1, shape.m + 1);
        Ok(Self { ends: [space.try_array(m)?, space.try_array(m)?], rows: [space.try_array(n)?, space.try_array(n)?] })
    }

    /// Fills in the potential of the monopole, `out` widths outside the mesh.
    fn fill(&mut self, shape: &Shape, mesh: &Mesh<T>, monopole: &Monopole<T>, out: isize) {
        let value = |along: isize, across: isize| {
            let (i, j) = if shape.along_y { (across, along) } else { (along, across) };
            monopole.potential(mesh.node(i, j))
        };
        let (n, m) = (shape.n as isize, shape.m as isize);
        for (line, along) in self.ends.iter_mut().zip([-out, n + out]) {
            (0..).zip(line.iter_mut()).for_each(|(s, slot)| *slot = value(along, s));
        }
        for (line, across) in self.rows.iter_mut().zip([-out, m + out]) {
            (0..).zip(line.iter_mut()).for_each(|(t, slot)| *slot = value(t, across));
        }
    }
}

/// Overwrites the modes F of the rows, given b - 2 of each mode.
pub(super) type OfColumns<'a, T> = dyn FnMut(&[T], &mut [T]) -> Result<()> + 'a;

/// All data of the solve except the density.
#[derive(Debug)]
pub(super) struct Solver<'w, T: Real> {
    shape: Shape,
    transform: Transform<'w, T>,
    /// b - 2 of each mode, padded.
    excess: &'w mut [T],
    /// 1 / A of each mode, padded.
    shares: &'w mut [T],
    /// The potential; between the phases its modes. Rows have `pitch` elements.
    values: &'w mut [T],
    border: Frame<'w, T>,
    /// Values one width outside the border, for the centred differences on it.
    ghosts: Frame<'w, T>,
    /// Two buffers of the transform for each worker.
    buffers: &'w mut [Element<T>],
    /// The factors of the elimination, one line per worker.
    factors: &'w mut [[T; WIDTH]],
}

impl<'w, T: Real> Solver<'w, T> {
    pub(super) fn layout(
        space: &mut impl Space<'w>,
        mesh: &Mesh<T>,
        equation: &Equation<T>,
        workers: usize,
    ) -> Result<Self> {
        let shape = Shape::of(mesh, equation);
        let size = crate::Error::TooLarge;
        let buffers =
            Transform::<T>::buffer(shape.n).checked_mul(2).and_then(|n| n.checked_mul(workers)).ok_or(size)?;
        Ok(Self {
            shape,
            transform: Transform::layout(space, shape.kind, shape.n)?,
            excess: space.try_array(shape.pitch)?,
            shares: space.try_array(shape.pitch)?,
            values: space.try_array(shape.pitch.checked_mul(shape.m + 1).ok_or(size)?)?,
            border: Frame::layout(space, &shape)?,
            ghosts: Frame::layout(space, &shape)?,
            buffers: space.try_array(buffers)?,
            factors: space.try_array((shape.m + 1).checked_mul(workers).ok_or(size)?)?,
        })
    }

    pub(super) fn prepare(&mut self, mesh: &Mesh<T>, equation: &Equation<T>) {
        self.transform.prepare();
        let [h, k] = self.shape.spacing(mesh);
        let ratio = k / h;
        let screening = k * equation.screening;
        let fourth = equation.order == Order::Fourth;
        let twelfth = T::ONE / T::from_i32(12);
        for (mode, (b, share)) in self.excess.iter_mut().zip(self.shares.iter_mut()).enumerate() {
            // Padding columns repeat the last mode.
            let [sin, _] = half_root::<T>(mode.min(self.shape.n), 2 * self.shape.n);
            let wave = T::TWO * ratio * sin;
            // Kept finite for any screening. If the bound applies, the field is zero to rounding.
            let (waves, screened) = (wave * wave, screening * screening);
            (*b, *share) = ((waves + screened).min(T::MAX * T::EPSILON), T::ONE);
            if fourth {
                // l H^2
                let along = T::from_i32(4) * sin * sin;
                *share = T::ONE / (T::ONE - (along + waves + screened) * twelfth);
                *b = (waves + screened * (T::ONE - along * twelfth)) * *share;
            }
        }
    }

    /// Overwrites the potential by that of the masses in `words`. The mass unit is 2^[`BITS`] units of `words`, as in the monopole.
    pub(super) fn solve(
        &mut self,
        mesh: &Mesh<T>,
        equation: &Equation<T>,
        monopole: &Monopole<T>,
        words: &[i64],
        resources: Resources<'_>,
    ) -> Result<()> {
        let shape = self.shape;
        if shape.kind == Kind::Sine {
            self.border.fill(&shape, mesh, monopole, 0);
            self.ghosts.fill(&shape, mesh, monopole, 1);
        }
        let words = words.get(..words.len().saturating_sub(TAIL)).present()?;
        self.run(mesh, equation, Density::Words(words), None, resources)
    }

    /// Overwrites the values by z, which vanishes on a free border: -Laplacian(z) + k^2 z = `residual`, an array in the layout of the values that holds
    /// integrals over the cells of the nodes. The border values are those that [`Solver::take_border`] left.
    pub(super) fn precondition(
        &mut self,
        mesh: &Mesh<T>,
        equation: &Equation<T>,
        residual: &[T],
        resources: Resources<'_>,
    ) -> Result<()> {
        self.run(mesh, equation, Density::Residual(residual), None, resources)
    }

    /// As [`Solver::precondition`], with another function of the operator than its inverse: what `columns` does in place of the elimination.
    pub(super) fn respond(
        &mut self,
        mesh: &Mesh<T>,
        equation: &Equation<T>,
        residual: &[T],
        columns: &mut OfColumns<'_, T>,
        resources: Resources<'_>,
    ) -> Result<()> {
        self.run(mesh, equation, Density::Residual(residual), Some(columns), resources)
    }

    /// Prepares the differences on a free border on which the values vanish: they continue with the opposite sign.
    pub(super) fn continue_oddly(&mut self) {
        let Self { shape: Shape { n, m, pitch, .. }, values, ghosts: Frame { ends, rows }, .. } = self;
        for (line, inner) in ends.iter_mut().zip([1, *n - 1]) {
            let column = values.get(inner..).present_or_default().iter().step_by((*pitch).max(1));
            line.iter_mut().zip(column).for_each(|(ghost, &value)| *ghost = -value);
        }
        for (line, inner) in rows.iter_mut().zip([1, *m - 1]) {
            let row = values.get(inner * *pitch..).present_or_default();
            line.iter_mut().zip(row).for_each(|(ghost, &value)| *ghost = -value);
        }
    }

    /// Writes the potential of `monopole` on a free border into `values`, prepares the differences there, and leaves border values of zero.
    pub(super) fn take_border(&mut self, mesh: &Mesh<T>, monopole: &Monopole<T>, values: &mut [T]) {
        let shape = self.shape;
        if shape.kind == Kind::Cosine {
            return;
        }
        self.border.fill(&shape, mesh, monopole, 0);
        self.ghosts.fill(&shape, mesh, monopole, 1);
        let Frame { ends: [first, last], rows: [low, high] } = &mut self.border;
        for (s, row) in values.chunks_mut(shape.pitch.max(1)).enumerate() {
            if s == 0 || s == shape.m {
                let line = if s == 0 { &*low } else { &*high };
                row.iter_mut().zip(line.iter()).for_each(|(value, &border)| *value = border);
                continue;
            }
            for (t, line) in [(0, &*first), (shape.n, &*last)] {
                if let (Some(value), Some(&border)) = (row.get_mut(t), line.get(s)) {
                    *value = border;
                }
            }
        }
        for line in [first, last, low, high] {
            line.fill(T::ZERO);
        }
    }

    /// The values, in rows of the shape's pitch.
    pub(super) fn values(&self) -> &[T] {
        self.values
    }

    /// As [`Solver::values`].
    pub(super) fn values_mut(&mut self) -> &mut [T] {
        self.values
    }

    /// The three phases, of which `columns` may replace the second.
    fn run(
        &mut self,
        mesh: &Mesh<T>,
        equation: &Equation<T>,
        density: Density<'_, T>,
        mut columns: Option<&mut OfColumns<'_, T>>,
        resources: Resources<'_>,
    ) -> Result<()> {
        let shape = self.shape;
        let [h, k] = shape.spacing(mesh);
        let norm = T::TWO / T::from_usize(shape.n);
        let unit = match density {
            Density::Words(_) => -T::ONE.ldexp(-BITS),
            Density::Residual(_) => T::ONE,
        };
        let data = Data {
            shape,
            density,
            // K^2 over the cell's area H K.
            per_unit: unit * (k / h) * norm,
            ends: [&*self.border.ends[0], &*self.border.ends[1]],
            rows: [&*self.border.rows[0], &*self.border.rows[1]],
            end_factor: (k / h) * (k / h) * norm,
            row_factor: norm,
            corner_factor: if equation.order == Order::Fourth {
                (T::ONE + (k / h) * (k / h)) / T::from_i32(12) * norm
            } else {
                T::ZERO
            },
            screened: (k * equation.screening) * (k * equation.screening) / T::from_i32(12) * norm,
            order: equation.order,
        };
        let (transform, excess, shares) = (&self.transform, &*self.excess, &*self.shares);
        let each = ROWS * shape.pitch;
        let tasks = (shape.m + 1).div_ceil(ROWS);
        let buffer = 2 * Transform::<T>::buffer(shape.n);
        for phase in [Phase::Forward, Phase::Columns, Phase::Backward] {
            if phase == Phase::Columns {
                if let Some(columns) = &mut columns {
                    columns(excess, self.values)?;
                    continue;
                }
                let singular = shape.kind == Kind::Cosine && equation.screening == T::ZERO;
                let columns = Columns::new(self.values, shape.pitch, WIDTH);
                let factors = Chunks::new(self.factors, shape.m + 1);
                par_chunks(resources.executor, shape.pitch / WIDTH, columns, factors, &|task, block, factors| {
                    let excess = excess.get(task * WIDTH..).present()?;
                    let shares = shares.get(task * WIDTH..).present()?;
                    with_simd(
                        resources.level,
                        Sweep { shape, singular: singular && task == 0, excess, shares, block, factors },
                    );
                    Ok(())
                })?;
                continue;
            }
            let rows = Chunks::new(self.values, each);
            let buffers = Chunks::new(self.buffers, buffer);
            par_chunks(resources.executor, tasks, rows, buffers, &|task, rows, buffers| {
                with_simd(resources.level, Lines { transform, data, phase, first: task * ROWS, rows, buffers });
                Ok(())
            })?;
        }
        Ok(())
    }

    /// The potential at node (i, j), in the solver's unit.
    pub(super) fn value(&self, i: usize, j: usize) -> T {
        self.values.get(self.shape.at(i, j)).copied().unwrap_or(T::NAN)
    }

    /// Overwrites `gradient` with the centred differences (3.6), (3.7), or those over five nodes. The unit of the potential is 2^`unit`.
    pub(super) fn differences(
        &self,
        mesh: &Mesh<T>,
        order: Order,
        unit: i32,
        gradient: &mut [[T; 2]],
        resources: Resources<'_>,
    ) -> Result<()> {
        let pitch = mesh.cells()[0] + 1;
        let tasks = (mesh.cells()[1] + 1).div_ceil(ROWS);
        par_chunks(resources.executor, tasks, Chunks::new(gradient, ROWS * pitch), (), &|task, rows, ()| {
            for (j, out) in (task * ROWS..).zip(rows.chunks_mut(pitch.max(1))) {
                self.differences_of_row(mesh, (unit, resources.level), j, out);
                if order == Order::Fourth {
                    self.widen(mesh, unit, j, out);
                }
            }
            Ok(())
        })
    }

    /// Turns centred differences into those over five nodes, `(8 (u_1 - u_-1) - (u_2 - u_-2)) / 12 h`, where these nodes exist. At walls
    /// the mesh continues as its mirror image.
    fn widen(&self, mesh: &Mesh<T>, unit: i32, j: usize, out: &mut [[T; 2]]) {
        let [nx, ny] = mesh.cells();
        let per_width = mesh.spacing().map(|h| Slope::new(T::ONE / (T::from_i32(12) * h), unit));
        let share = T::from_i32(4) / T::from_i32(3);
        let wall = self.shape.kind == Kind::Cosine;
        // The nodes two before and two after, where they exist. On a wall the slope is zero and is not changed.
        let around = |at: usize, n: usize| {
            let after = if at + 2 <= n { at + 2 } else { (2 * n).saturating_sub(at + 2) };
            let inside = 2 <= at && at + 2 <= n || wall && 0 < at && at < n;
            inside.then_some((at.abs_diff(2), after))
        };
        let rows = around(j, ny);
        for (i, [x, y]) in out.iter_mut().enumerate() {
            if let Some((before, after)) = around(i, nx) {
                *x = *x * share - per_width[0].of(self.value(after, j) - self.value(before, j));
            }
            if let Some((before, after)) = rows {
                *y = *y * share - per_width[1].of(self.value(i, after) - self.value(i, before));
            }
        }
    }

    fn differences_of_row(&self, mesh: &Mesh<T>, (unit, level): (i32, Level), j: usize, out: &mut [[T; 2]]) {
        let [nx, ny] = mesh.cells();
        let [per_h, per_k] = mesh.spacing().map(|h| Slope::new(T::HALF / h, unit));
        let shape = self.shape;
        // Interior nodes.
        let line = |j: usize| {
            let from = j * shape.pitch;
            self.values.get(from..from + nx + 1).present_or_default()
        };
        if shape.along_y {
            for (i, out) in out.iter_mut().enumerate() {
                let x = if 0 < i && i < nx { per_h.of(self.value(i + 1, j) - self.value(i - 1, j)) } else { T::ZERO };
                let y = if 0 < j && j < ny { per_k.of(self.value(i, j + 1) - self.value(i, j - 1)) } else { T::ZERO };
                *out = [x, y];
            }
        } else {
            let (below, here, above) = (line(j.saturating_sub(1)), line(j), line((j + 1).min(ny)));
            let job = Differences { below, here, above, per_h, per_k, out: &mut *out };
            with_simd(level, job);
        }
        // Border nodes: differences with the ghost values; zero at a wall.
        let wall = shape.kind == Kind::Cosine;
        let (low_x, high_x, low_y, high_y) = if shape.along_y {
            (&self.ghosts.rows[0], &self.ghosts.rows[1], &self.ghosts.ends[0], &self.ghosts.ends[1])
        } else {
            (&self.ghosts.ends[0], &self.ghosts.ends[1], &self.ghosts.rows[0], &self.ghosts.rows[1])
        };
        let ghost = |line: &[T], at: usize| line.get(at).copied().unwrap_or(T::NAN);
        let slope = |high: T, low: T, per: Slope<T>| if wall { T::ZERO } else { per.of(high - low) };
        if let Some([x, _]) = out.first_mut() {
            *x = slope(self.value(1, j), ghost(low_x, j), per_h);
        }
        if let Some([x, _]) = out.last_mut() {
            *x = slope(ghost(high_x, j), self.value(nx - 1, j), per_h);
        }
        if j == 0 {
            for (i, [_, y]) in out.iter_mut().enumerate() {
                *y = slope(self.value(i, 1), ghost(low_y, i), per_k);
            }
        } else if j == ny {
            for (i, [_, y]) in out.iter_mut().enumerate() {
                *y = slope(ghost(high_y, i), self.value(i, ny - 1), per_k);
            }
        }
    }
}

/// The factor that turns a difference of the potential into a slope: 1 over a length, times the unit of the potential. It is stored as
/// a number near 1 and two powers of two, because the product may be out of range where the slope is not.
#[derive(Clone, Copy)]
struct Slope<T> {
    fraction: T,
    powers: [T; 2],
}

impl<T: Real> Slope<T> {
    fn new(per_length: T, unit: i32) -> Self {
        let (fraction, exponent) = per_length.frexp();
        Self { fraction, powers: halves(exponent + unit) }
    }

    #[inline(always)]
    fn of(self, difference: T) -> T {
        let [first, second] = self.powers;
        difference * self.fraction * first * second
    }
}

/// Centred differences of one line of nodes. Those along x exist only where both neighbours are in the line.
struct Differences<'a, T> {
    below: &'a [T],
    here: &'a [T],
    above: &'a [T],
    per_h: Slope<T>,
    per_k: Slope<T>,
    out: &'a mut [[T; 2]],
}

impl<T: Real> Loops for Differences<'_, T> {
    type Out = ();

    #[inline(always)]
    fn run(self) {
        let Self { below, here, above, per_h, per_k, out } = self;
        for (([_, y], low), high) in out.iter_mut().zip(below).zip(above) {
            *y = per_k.of(*high - *low);
        }
        let right = here.get(2..).present_or_default();
        for (([x, _], left), right) in out.iter_mut().skip(1).zip(here).zip(right) {
            *x = per_h.of(*right - *left);
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Phase {
    Forward,
    Columns,
    Backward,
}

/// What a node's cell holds.
#[derive(Clone, Copy)]
enum Density<'a, T> {
    /// Masses in units, in the order of the mesh; the equation has the sign of Laplacian(u) = density.
    Words(&'a [i64]),
    /// Numbers in the layout of the values; the equation has the sign of -Laplacian(u) = density.
    Residual(&'a [T]),
}

/// The parts of the right-hand side, and the border values of the solution.
#[derive(Clone, Copy)]
struct Data<'a, T> {
    shape: Shape,
    density: Density<'a, T>,
    per_unit: T,
    ends: [&'a [T]; 2],
    rows: [&'a [T]; 2],
    end_factor: T,
    row_factor: T,
    /// The factor of the second differences of prescribed values along their lines: (H^2 + K^2) / (12 H^2), or 0.
    corner_factor: T,
    /// kappa^2 K^2 / 12.
    screened: T,
    order: Order,
}

/// The transform of [`ROWS`] rows: of the right-hand side into `rows`, or of `rows` in place.
struct Lines<'a, T> {
    transform: &'a Transform<'a, T>,
    data: Data<'a, T>,
    phase: Phase,
    /// The index of the first row.
    first: usize,
    rows: &'a mut [T],
    buffers: &'a mut [Element<T>],
}

impl<T: Real> Loops for Lines<'_, T> {
    type Out = ();

    #[inline(always)]
    fn run(self) {
        let Self { transform, data, phase, first, rows, buffers } = self;
        let Shape { n, pitch, kind, .. } = data.shape;
        let half = buffers.len() / 2;
        let Some((a, b)) = buffers.split_at_mut_checked(half) else { return };
        if phase == Phase::Forward {
            data.load(first, a);
        } else {
            // Two rows share a complex transform, so a missing row is zero and not the buffer's old content.
            let mut given = rows.chunks(pitch.max(1));
            for r in 0..ROWS {
                let elements = a.iter_mut().take(n + 1);
                match given.next() {
                    Some(row) => elements.zip(row).for_each(|(element, &value)| put(element, r, value)),
                    None => elements.for_each(|element| put(element, r, T::ZERO)),
                }
            }
        }
        let result = transform.run(a, b);
        for (r, row) in rows.chunks_mut(pitch.max(1)).enumerate() {
            for (element, value) in result.iter().zip(row.iter_mut()).take(n + 1) {
                *value = take(element, r);
            }
            let s = first + r;
            if kind == Kind::Cosine {
                continue;
            }
            let backward = phase == Phase::Backward;
            let end = |line: &[T]| line.get(s).copied().filter(|_| backward).unwrap_or(T::ZERO);
            let ends = [end(data.ends[0]), end(data.ends[1])];
            if !data.shape.is_unknown(s) {
                let line = if s == 0 { data.rows[0] } else { data.rows[1] };
                for (value, &border) in row.iter_mut().zip(line) {
                    *value = if backward { border } else { T::ZERO };
                }
            }
            if let Some(value) = row.first_mut() {
                *value = ends[0];
            }
            if let Some(value) = row.get_mut(n) {
                *value = ends[1];
            }
        }
    }
}

#[inline(always)]
pub(super) fn put<T: Real>([re, im]: &mut Element<T>, r: usize, value: T) {
    let part = if r < LANES { re } else { im };
    if let Some(slot) = part.get_mut(r % LANES) {
        *slot = value;
    }
}

#[inline(always)]
pub(super) fn take<T: Real>([re, im]: &Element<T>, r: usize) -> T {
    let part = if r < LANES { re } else { im };
    part.get(r % LANES).copied().unwrap_or(T::ZERO)
}

impl<T: Real> Data<'_, T> {
    /// Writes F of the rows from `first` on into the elements 0 to n of `a`. Rows that do not exist or are prescribed become zero.
    #[inline(always)]
    fn load(&self, first: usize, a: &mut [Element<T>]) {
        let Shape { kind, along_y, n, m, .. } = self.shape;
        // The distances in `words` between nodes of a row and between rows.
        let (step, row_step) = if along_y { (m + 1, 1) } else { (1, n + 1) };
        let Some(a) = a.get_mut(..n + 1) else { return };
        for r in 0..ROWS {
            let s = first + r;
            if !self.shape.is_unknown(s) {
                a.iter_mut().for_each(|element| put(element, r, T::ZERO));
                continue;
            }
            if self.order == Order::Fourth {
                self.load_sharpened(s, r, a);
                continue;
            }
            // A wall node has half a cell, so the same mass is twice the density.
            let wall = kind == Kind::Cosine && (s == 0 || s == m);
            let per_unit = if wall { T::TWO * self.per_unit } else { self.per_unit };
            match self.density {
                Density::Words(words) => {
                    let words = words.get(s * row_step..).present_or_default();
                    for (element, &word) in a.iter_mut().zip(words.iter().step_by(step.max(1))) {
                        put(element, r, T::from_f64(exact(word)) * per_unit);
                    }
                }
                Density::Residual(values) => {
                    let values = values.get(s * self.shape.pitch..).present_or_default();
                    for (element, &value) in a.iter_mut().zip(values) {
                        put(element, r, value * per_unit);
                    }
                }
            }
            match kind {
                Kind::Cosine => {
                    for end in [0, n] {
                        if let Some(element) = a.get_mut(end) {
                            put(element, r, T::TWO * take(element, r));
                        }
                    }
                }
                Kind::Sine => {
                    for (line, node) in self.ends.iter().zip([1, n - 1]) {
                        if let (Some(element), Some(&value)) = (a.get_mut(node), line.get(s)) {
                            put(element, r, take(element, r) + value * self.end_factor);
                        }
                    }
                    for (line, row) in self.rows.iter().zip([1, m - 1]) {
                        if s == row {
                            for (element, &value) in a.iter_mut().zip(*line) {
                                put(element, r, take(element, r) + value * self.row_factor);
                            }
                        }
                    }
                }
            }
        }
    }
}

impl<T: Real> Data<'_, T> {
    /// As [`Data::load`], for one row of the nine-point scheme.
    #[inline(always)]
    fn load_sharpened(&self, s: usize, r: usize, a: &mut [Element<T>]) {
        let Shape { kind, along_y, n, m, .. } = self.shape;
        let (step, row_step) = if along_y { (m + 1, 1) } else { (1, n + 1) };
        let walls = kind == Kind::Cosine;
        let Density::Words(words) = self.density else { return };
        // Beyond a wall the index is mirrored. A wall node has half a cell.
        let mirrored = |at: usize, n: usize| if at > n { 2 * n - at } else { at };
        let doubled = |at: usize, n: usize| if walls && (at == 0 || at == n) { T::TWO } else { T::ONE };
        let density = |t: usize, s: usize| {
            let word = words.get(s * row_step + t * step).copied().unwrap_or(0);
            T::from_f64(exact(word)) * (self.per_unit * doubled(t, n) * doubled(s, m))
        };
        let (below, above) = (s.abs_diff(1), mirrored(s + 1, m));
        let (share, twelfth) = (T::from_i32(4) / T::from_i32(3), T::ONE / T::from_i32(12));
        let (mut left, mut here) = (density(1, s), density(0, s));
        for (t, element) in a.iter_mut().enumerate() {
            let right = density(mirrored(t + 1, n), s);
            let around = (left + right) + (density(t, below) + density(t, above));
            put(element, r, here * share - around * twelfth);
            (left, here) = (here, right);
        }
        if walls {
            return;
        }
        let at = |line: &[T], k: usize| line.get(k).copied().unwrap_or(T::ZERO);
        for (line, node) in self.ends.iter().zip([1, n - 1]) {
            let Some(element) = a.get_mut(node) else { continue };
            let value = at(line, s);
            let bend = (at(line, s - 1) - value) + (at(line, s + 1) - value);
            let border = value * (self.end_factor - self.screened) + bend * self.corner_factor;
            put(element, r, take(element, r) + border);
        }
        for (line, row) in self.rows.iter().zip([1, m - 1]) {
            if s != row {
                continue;
            }
            // The lines of the ends contain the corners.
            let inside = |t: usize| if t == 0 || t == n { T::ZERO } else { at(line, t) };
            for (t, element) in a.iter_mut().enumerate().take(n).skip(1) {
                let value = at(line, t);
                let bend = (inside(t - 1) - value) + (inside(t + 1) - value);
                let border = value * (self.row_factor - self.screened) + bend * self.corner_factor;
                put(element, r, take(element, r) + border);
            }
        }
    }
}

/// The tridiagonal systems of [`WIDTH`] modes, by elimination without pivoting (b > 2, so they are diagonally dominant).
///
/// The factors e_j = 1 / (b - e_(j-1)) of low modes are close to 1. b = 2 + sigma would hold sigma >= pi^2 / n^2 only to a relative error of
/// n^2 u. So sigma is stored separately, and with e the deficit d_j = 1 - e_j = (sigma + d_(j-1)) / (1 + sigma + d_(j-1)). These are sums of
/// positive numbers, accurate to rounding. (On a mesh of 1000 cells b itself would lose 5 digits; this form loses 3.)
struct Sweep<'a, T> {
    shape: Shape,
    /// The block holds mode 0 of a box without screening. The kernel of its matrix is the constant vector.
    singular: bool,
    excess: &'a [T],
    /// The factors of the right-hand side.
    shares: &'a [T],
    block: Block<'a, T>,
    factors: &'a mut [[T; WIDTH]],
}

impl<T: Real> Loops for Sweep<'_, T> {
    type Out = ();

    #[inline(always)]
    fn run(self) {
        let Self { shape: Shape { kind, m, .. }, singular, excess, shares, mut block, factors } = self;
        let (Some(excess), Some(shares)) = (excess.first_chunk::<WIDTH>(), shares.first_chunk::<WIDTH>()) else {
            return;
        };
        if singular {
            remove_mean(&mut block, m);
        }
        let (first, last) = if kind == Kind::Sine { (1, m.saturating_sub(1)) } else { (0, m) };
        let mut at_wall = *excess;
        if singular && let Some(sigma) = at_wall.first_mut() {
            // The last pivot of mode 0 is zero. It is replaced by 1, and the quotient is overwritten below.
            *sigma = T::ONE;
        }
        let mut factor = [T::ZERO; WIDTH];
        let mut deficit = [T::ONE; WIDTH];
        let mut value = [T::ZERO; WIDTH];
        for (j, slot) in factors.iter_mut().enumerate().take(last + 1).skip(first) {
            let Some(row) = block.row(j).first_chunk_mut::<WIDTH>() else { return };
            // The row of a wall is b u_0 - 2 u_1 or b u_m - 2 u_(m-1). The pivots are 2 + sigma and sigma + 2 d_(m-1).
            let at_first = kind == Kind::Cosine && j == 0;
            let at_last = kind == Kind::Cosine && j == m;
            let excess = if at_last { &at_wall } else { excess };
            let (one, lower) = if at_last { (T::ZERO, T::TWO) } else { (T::ONE, T::ONE) };
            let (keep, upper) = if at_first { (T::ZERO, T::TWO) } else { (T::ONE, T::ONE) };
            let lanes = factor.iter_mut().zip(&mut deficit).zip(&mut value).zip(row.iter_mut()).zip(excess).zip(shares);
            for (((((e, d), g), x), &sigma), &share) in lanes {
                let pivot = T::ONE / (one + (sigma + lower * *d));
                *g = (lower * *g + share * *x) * pivot;
                *d = (sigma + keep * *d) * pivot;
                *e = upper * pivot;
                *x = *g;
            }
            *slot = factor;
        }
        if singular && let (Some(free), Some(x)) = (value.first_mut(), block.row(m).first_mut()) {
            // Any value is valid, because the mean is removed below.
            *free = T::ZERO;
            *x = T::ZERO;
        }
        for (j, factor) in factors.iter().enumerate().take(last).skip(first).rev() {
            let Some(row) = block.row(j).first_chunk_mut::<WIDTH>() else { return };
            for ((g, x), &f) in value.iter_mut().zip(row.iter_mut()).zip(factor) {
                *g = *x + f * *g;
                *x = *g;
            }
        }
        if singular {
            remove_mean(&mut block, m);
        }
    }
}

/// Subtracts the mean of mode 0 over the rows; wall rows have weight 1/2.
fn remove_mean<T: Real>(block: &mut Block<'_, T>, m: usize) {
    let mut sum = T::ZERO;
    for j in 0..=m {
        let weight = if j == 0 || j == m { T::HALF } else { T::ONE };
        sum += weight * block.row(j).first().copied().unwrap_or(T::ZERO);
    }
    let mean = sum / T::from_usize(m);
    for j in 0..=m {
        if let Some(value) = block.row(j).first_mut() {
            *value -= mean;
        }
    }
}

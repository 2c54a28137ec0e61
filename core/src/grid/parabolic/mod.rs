//! An attractant with a memory, epsilon c_t = Laplacian(c) - k^2 c + density (Zhelezov & Fatkullin, (6.1), with a time scale epsilon).
//!
//! ```
//! use mollis_core::exec::Resources;
//! use mollis_core::grid::{Equation, Mesh, Parabolic};
//! use mollis_core::memory::ALIGN;
//!
//! // The field of a mass that appears at time 0 reaches a distance r after the time epsilon r^2 / 4.
//! let mesh = Mesh::new([-2.0, -2.0], [2.0, 2.0], [128, 128])?;
//! let bytes = Parabolic::workspace_bytes(&mesh, &Equation::POISSON, 1)?;
//! let mut memory = vec![0; bytes + ALIGN];
//! let start = memory.as_ptr().align_offset(ALIGN);
//! let mut field = Parabolic::prepare(&mut memory[start..start + bytes], mesh, Equation::POISSON, 0.5, 1)?;
//! for _ in 0..10 {
//!     field.advance(&[[0.0, 0.0]], &[3.0], 0.01, Resources::default())?;
//! }
//! let exact = |r: f64| 3.0 / (std::f64::consts::TAU * r) * (-0.5 * r * r / (4.0 * 0.1)).exp();
//! let [slope, _] = field.grid().gradient_at([0.5, 0.0]);
//! assert!((slope / exact(0.5) - 1.0).abs() < 0.01);
//!
//! // What a checkpoint saves.
//! let mut c = vec![0.0; mesh.nodes()];
//! field.attractant(&mut c)?;
//! field.set_attractant(&c, Resources::default())?;
//! # Ok::<(), mollis_core::Error>(())
//! ```
//!
//! **Sign.** [`Grid`]'s: u = -c, so the drift of particles that follow c is -chi grad u.
//!
//! **Scheme.** In space the five-point equations of [`Grid::solve`], with A for -Laplacian + k^2. In time one step of the exponential Euler method (Hochbruck & Ostermann, Acta
//! Numerica 19, 2010, Section 2),
//!
//! `c' = c + phi(A dt / epsilon) (dt / epsilon) (density - A c),  phi(z) = (1 - e^-z) / z`
//!
//! by a sine or cosine transform along both axes. It is exact while the particles rest, stable for every dt and epsilon. Its fixed point solves the
//! elliptic equation on the mesh, and as epsilon / dt goes to 0 a step gives that equation's solution. For masses in motion c differs from that in proportion to epsilon
//! (test `the_field_lags_behind_by_the_time_scale`).
//!
//! **Walls.** [`Walls::NoFlux`]: a box as in [`Grid`]. Without decay the mean of c grows at the rate mass / (epsilon area), for ever; the gradient tends to that of the elliptic law, up to the rounding of
//! that mean. [`Walls::Free`]: c vanishes on the border and outside. That is free space as long as c is small at the border: until a time of
//! `epsilon R^2 / 4` and some for a distance R from the mass, or always if k R is large. Particles outside add nothing and feel nothing.

mod spectrum;

use super::fixed::exact;
use super::poisson::Shape;
use super::transform::Kind;
use super::{Equation, Grid, MassScale, Mesh, Monopole, Order, Walls};
use crate::checked::Present;
use crate::error::{Error, Result};
use crate::exec::{Chunks, MAX_WORKERS, Resources, par_chunks};
use crate::memory::{Carve, Measure, Space};
use crate::real::{Real, Scalar};
use spectrum::Spectrum;

/// Rows per task.
const ROWS: usize = 16;

/// The attractant on a mesh, in the caller's memory.
///
/// c is the state of a run beside its particles: a checkpoint saves [`Parabolic::attractant`].
#[derive(Debug)]
pub struct Parabolic<'w, T: Real> {
    grid: Grid<'w, T>,
    shape: Shape,
    time_scale: T,
    arrays: Arrays<'w, T>,
}

#[derive(Debug)]
struct Arrays<'w, T> {
    /// u = -c in the layout of the solver's values, 0 on a free border.
    u: &'w mut [T],
    /// -density - A u, integrated over the cells.
    residual: &'w mut [T],
    spectrum: Spectrum<'w, T>,
}

fn layout<'w, T: Real>(space: &mut impl Space<'w>, shape: Shape, workers: usize) -> Result<Arrays<'w, T>> {
    let nodes = shape.pitch.checked_mul(shape.m + 1).ok_or(Error::TooLarge)?;
    Ok(Arrays {
        u: space.try_array(nodes)?,
        residual: space.try_array(nodes)?,
        spectrum: Spectrum::layout(space, shape, workers)?,
    })
}

impl<'w, T: Real> Parabolic<'w, T> {
    /// The exact number of bytes that [`Parabolic::prepare`] needs for calls with at most `workers` workers: those of [`Grid`] and two numbers a node.
    ///
    /// # Errors
    /// As [`Grid::workspace_bytes`]; [`Error::Unsupported`]: fourth order, [`Walls::FreeQuadrupole`].
    pub fn workspace_bytes(mesh: &Mesh<T>, equation: &Equation<T>, workers: usize) -> Result<usize> {
        if equation.order != Order::Second || equation.walls == Walls::FreeQuadrupole {
            return Err(Error::Unsupported);
        }
        let (shape, workers) = (Shape::of(mesh, equation), workers.clamp(1, MAX_WORKERS));
        let own = Measure::of(|space| layout::<T>(space, shape, workers).map(|_| ()))?;
        Grid::workspace_bytes(mesh, equation, workers)?.checked_add(own).ok_or(Error::TooLarge)
    }

    /// Creates c = 0 in `memory`, for executors with at most `workers` workers. `time_scale` is epsilon, a time over the square of a length.
    ///
    /// # Errors
    /// As [`Parabolic::workspace_bytes`]; [`Error::NotFinite`], [`Error::OutOfDomain`]: epsilon is not finite, not positive; [`Error::WorkspaceTooSmall`], [`Error::Misaligned`].
    pub fn prepare(
        memory: &'w mut [u8],
        mesh: Mesh<T>,
        equation: Equation<T>,
        time_scale: T,
        workers: usize,
    ) -> Result<Self> {
        if !time_scale.is_finite() {
            return Err(Error::NotFinite);
        }
        if time_scale <= T::ZERO {
            return Err(Error::OutOfDomain);
        }
        if memory.len() < Self::workspace_bytes(&mesh, &equation, workers)? {
            return Err(Error::WorkspaceTooSmall);
        }
        let workers = workers.clamp(1, MAX_WORKERS);
        let of_grid = Grid::workspace_bytes(&mesh, &equation, workers)?;
        let (of_grid, own) = memory.split_at_mut_checked(of_grid).present()?;
        let grid = Grid::prepare(of_grid, mesh, equation, workers)?;
        let shape = Shape::of(&mesh, &equation);
        let mut arrays = layout(&mut Carve::new(own)?, shape, workers)?;
        arrays.spectrum.prepare();
        Ok(Self { grid, shape, time_scale, arrays })
    }

    /// The grid, for the field's results: [`Grid::potential`] (u = -c), [`Grid::gradient`], [`Grid::interpolate`], [`Grid::masses`], [`Grid::outside`].
    pub fn grid(&self) -> &Grid<'w, T> {
        &self.grid
    }

    /// epsilon.
    pub fn time_scale(&self) -> T {
        self.time_scale
    }

    /// Overwrites `out` with c at the nodes, node (i, j) at `j (cells[0] + 1) + i`.
    ///
    /// # Errors
    /// [`Error::LengthMismatch`] before anything is written.
    pub fn attractant(&self, out: &mut [T]) -> Result<()> {
        let (mesh, shape) = (self.grid.mesh, self.shape);
        if out.len() != mesh.nodes() {
            return Err(Error::LengthMismatch);
        }
        for (j, row) in out.chunks_mut((mesh.cells()[0] + 1).max(1)).enumerate() {
            for (i, c) in row.iter_mut().enumerate() {
                // Not the opposite, which would give zeros a sign.
                *c = T::ZERO - self.arrays.u.get(shape.at(i, j)).copied().present_or(T::NAN);
            }
        }
        Ok(())
    }

    /// Replaces c, and the field with it: by the initial state, or by what [`Parabolic::attractant`] gave, after which a run goes on bit for bit.
    ///
    /// # Errors
    /// Before anything is written: [`Error::LengthMismatch`], [`Error::NotFinite`], [`Error::OutOfDomain`] (not 0 on a free border), [`Error::WorkspaceTooSmall`] (more workers than
    /// prepared for).
    pub fn set_attractant(&mut self, c: &[T], resources: Resources<'_>) -> Result<()> {
        let (mesh, shape) = (self.grid.mesh, self.shape);
        self.grid.check_workers(resources)?;
        if c.len() != mesh.nodes() {
            return Err(Error::LengthMismatch);
        }
        if !c.iter().all(|c| c.is_finite()) {
            return Err(Error::NotFinite);
        }
        let [nx, ny] = mesh.cells();
        let on_border = |i: usize, j: usize| i == 0 || i == nx || j == 0 || j == ny;
        let rows = || {
            c.chunks((nx + 1).max(1))
                .enumerate()
                .flat_map(|(j, row)| row.iter().enumerate().map(move |(i, &c)| (i, j, c)))
        };
        if shape.kind == Kind::Sine && rows().any(|(i, j, c)| on_border(i, j) && c != T::ZERO) {
            return Err(Error::OutOfDomain);
        }
        for (i, j, c) in rows() {
            if let Some(u) = self.arrays.u.get_mut(shape.at(i, j)) {
                *u = T::ZERO - c;
            }
        }
        self.grid.arrays.solver.values_mut().iter_mut().zip(self.arrays.u.iter()).for_each(|(value, &u)| *value = u);
        self.differences(resources)
    }

    /// The integral of c over the mesh, by the trapezoidal rule.
    ///
    /// With no-flux walls `epsilon d/dt amount = mass - k^2 amount`, to rounding (test `what_is_produced_decays_or_stays`).
    pub fn amount(&self) -> f64 {
        let Shape { n, m, pitch, .. } = self.shape;
        let share = |at: usize, last: usize| if at == 0 || at == last { 0.5 } else { 1.0 };
        let [h, k] = self.grid.mesh.spacing().map(Scalar::to_f64);
        let rows = self.arrays.u.chunks(pitch.max(1)).enumerate();
        let sums = rows.map(|(s, row)| {
            let sum = row.iter().take(n + 1).enumerate().fold(0.0, |sum, (t, u)| sum - u.to_f64() * share(t, n));
            sum * share(s, m)
        });
        sums.sum::<f64>() * h * k
    }

    /// As [`Grid::deposit`].
    ///
    /// # Errors
    /// As there.
    pub fn deposit(&mut self, positions: &[[T; 2]], masses: &[T], resources: Resources<'_>) -> Result<()> {
        self.grid.deposit(positions, masses, resources)
    }

    /// As [`Grid::begin`].
    pub fn begin(&mut self, scale: MassScale) {
        self.grid.begin(scale);
    }

    /// As [`Grid::add`].
    ///
    /// # Errors
    /// As there.
    pub fn add(&mut self, positions: &[[T; 2]], masses: &[T], resources: Resources<'_>) -> Result<()> {
        self.grid.add(positions, masses, resources)
    }

    /// As [`Grid::words_mut`], for sums over ranks.
    pub fn words_mut(&mut self) -> &mut [i64] {
        self.grid.words_mut()
    }

    /// A step of length `dt` with the particles at rest: [`Parabolic::deposit`], [`Parabolic::look_ahead`], [`Parabolic::keep`].
    ///
    /// # Errors
    /// As these. c is then unchanged.
    pub fn advance(&mut self, positions: &[[T; 2]], masses: &[T], dt: T, resources: Resources<'_>) -> Result<()> {
        check_step(dt)?;
        self.deposit(positions, masses, resources)?;
        self.look_ahead(dt, resources)?;
        self.keep();
        Ok(())
    }

    /// Computes c after a time `dt` with the density that was deposited, and its gradient. c itself stays until [`Parabolic::keep`], so that a host's step can fail.
    ///
    /// Cost: that of [`Grid::solve`] with a transform there and back in place of the elimination, and as many exponentials as rows and columns. Accuracy: in double precision the solution in time
    /// to 1e-12 of the largest c on meshes of up to 37 cells (test `a_step_is_the_solution_in_time`).
    ///
    /// # Errors
    /// Before anything is written: [`Error::TimeStep`]: dt is not positive or not finite; [`Error::WorkspaceTooSmall`] (more workers than prepared for). [`Error::Executor`]: the
    /// field is undefined. [`Error::BecameNotFinite`]: c leaves the range of the scalar.
    pub fn look_ahead(&mut self, dt: T, resources: Resources<'_>) -> Result<()> {
        check_step(dt)?;
        self.grid.check_workers(resources)?;
        self.find_residual(resources)?;
        let Self { grid, shape, time_scale, arrays: Arrays { u, residual, spectrum } } = self;
        let (mesh, equation) = (grid.mesh, grid.equation);
        let [_, k] = shape.spacing(&mesh);
        // dt / (epsilon K^2), kept finite, as 0 times it is 0.
        let per_mode = (dt / *time_scale / k / k).min(T::MAX);
        let solver = &mut grid.arrays.solver;
        let mut columns = |along: &[T], modes: &mut [T]| spectrum.run(along, per_mode, modes, resources);
        solver.respond(&mesh, &equation, residual, &mut columns, resources)?;
        solver.values_mut().iter_mut().zip(u.iter()).for_each(|(change, &u)| *change += u);
        self.differences(resources)?;
        let poison = self.grid.arrays.solver.values().iter().fold(T::ZERO, |sum, &u| sum + u * T::ZERO);
        if poison.is_nan() { Err(Error::BecameNotFinite) } else { Ok(()) }
    }

    /// Takes over what the last [`Parabolic::look_ahead`] computed.
    pub fn keep(&mut self) {
        self.arrays.u.iter_mut().zip(self.grid.arrays.solver.values()).for_each(|(u, &value)| *u = value);
    }

    /// Replaces c by the equilibrium of the density that was deposited: the limit of many steps. In a box without decay, which has none, by that of the density less its mean, with mean zero.
    ///
    /// # Errors
    /// [`Error::WorkspaceTooSmall`] before anything is written; [`Error::Executor`].
    pub fn settle(&mut self, resources: Resources<'_>) -> Result<()> {
        self.grid.check_workers(resources)?;
        self.arrays.u.fill(T::ZERO);
        self.find_residual(resources)?;
        let (mesh, equation) = (self.grid.mesh, self.grid.equation);
        self.grid.arrays.solver.precondition(&mesh, &equation, self.arrays.residual, resources)?;
        self.keep();
        self.differences(resources)
    }

    /// Overwrites the residual by that of the deposited density and u. Only masses on the mesh count.
    fn find_residual(&mut self, resources: Resources<'_>) -> Result<()> {
        let Self { grid, shape, arrays: Arrays { u, residual, .. }, .. } = self;
        grid.locate_mass();
        // Values are in the caller's unit, and there is no field outside.
        grid.relative = Monopole { mass: T::ZERO, ..grid.relative };
        grid.unit = [T::ONE; 2];
        let Shape { kind, along_y, n, m, pitch } = *shape;
        let (step, row_step) = if along_y { (m + 1, 1) } else { (1, n + 1) };
        let [h, k] = shape.spacing(&grid.mesh);
        // Of a whole cell.
        let decay = (grid.equation.screening * h) * (grid.equation.screening * k);
        let (along, across) = (k / h, h / k);
        let (words, unit, u, shape) = (grid.words(), grid.scale.unit(), &**u, *shape);
        let half = |at: usize, last: usize| if at == 0 || at == last { T::HALF } else { T::ONE };
        // Beyond a wall the index is mirrored.
        let after = |at: usize, last: usize| if at == last { last - 1 } else { at + 1 };
        let tasks = (m + 1).div_ceil(ROWS);
        par_chunks(resources.executor, tasks, Chunks::new(residual, ROWS * pitch), (), &|task, rows, ()| {
            for (s, out) in (task * ROWS..).zip(rows.chunks_mut(pitch.max(1))) {
                if !shape.is_unknown(s) {
                    continue;
                }
                let row = |s: usize| u.get(s * pitch..).present_or_default();
                let (below, here, above) = (row(s.abs_diff(1)), row(s), row(after(s, m)));
                let at = |row: &[T], t: usize| row.get(t).copied().present_or(T::NAN);
                let words = words.get(s * row_step..).present_or_default().iter().step_by(step.max(1));
                for (t, (out, &word)) in out.iter_mut().zip(words).take(n + 1).enumerate() {
                    if kind == Kind::Sine && (t == 0 || t == n) {
                        continue;
                    }
                    let value = at(here, t);
                    let in_row = (value - at(here, t.abs_diff(1))) + (value - at(here, after(t, n)));
                    let between = (value - at(below, t)) + (value - at(above, t));
                    let area = half(s, m) * half(t, n);
                    *out =
                        -(T::from_f64(exact(word) * unit) + area * (along * in_row + across * between + decay * value));
                }
            }
            Ok(())
        })
    }

    /// The gradient of the solver's values.
    fn differences(&mut self, resources: Resources<'_>) -> Result<()> {
        let super::Arrays { gradient, solver, .. } = &mut self.grid.arrays;
        solver.continue_oddly();
        solver.differences(&self.grid.mesh, Order::Second, 0, gradient, resources)
    }
}

fn check_step<T: Real>(dt: T) -> Result<()> {
    if dt > T::ZERO && dt.is_finite() { Ok(()) } else { Err(Error::TimeStep) }
}

//! Mesh fields: deposit, Poisson solve, interpolation (Zhelezov & Fatkullin, Section 3.4).
//!
//! [`Grid`] finds u = sum_n m_n V(x - x_n), V = log r / (2 pi) or -K0(k r) / (2 pi), and its gradient at the particles:
//!
//! 1. [`Grid::deposit`] adds each particle's mass to the four nodes of its cell (cloud in cell), in 64-bit fixed point, so that
//!    the field's bits depend neither on the order of the particles nor on threads or ranks;
//! 2. [`Grid::solve`] solves the five-point scheme (3.9), Laplacian(u) - k^2 u = density, with the monopole of all mass as
//!    Dirichlet data (3.10), with its quadrupole too, or in a box with no-flux walls;
//! 3. [`Grid::interpolate`] interpolates the centred differences (3.6), (3.7) with the deposit's weights (its adjoint, so a
//!    particle does not move itself); outside the mesh the drift is the monopole's (3.8).
//!
//! That is the scheme of the paper. [`Order::Fourth`] takes a compact scheme of nine points, differences over five nodes, and undoes the
//! smoothing of deposit and interpolation.
//!
//! The sign is that of the field sums: the paper's c is -u, and its drift chi grad c is -chi grad u. Only + - * / and sqrt,
//! integers and libm are used, in an order that depends on the mesh alone: the same bits on every machine, at every
//! level and for any number of threads.

mod deposit;
mod fft;
mod fixed;
mod interpolate;
mod mesh;
mod monopole;
mod poisson;
mod transform;

pub use fixed::MassScale;
pub use mesh::{MAX_CELLS, Mesh};
pub use monopole::Monopole;

use crate::error::{Error, Result};
use crate::exec::Executor;
use crate::exec::{Chunks, MAX_WORKERS, par_chunks};
use crate::memory::{Carve, Measure, Space};
use crate::real::{Real, Scalar};
use crate::simd::{Level, with_simd};
use deposit::TAIL;
use mesh::Locator;

/// Particles of one task.
const PARTICLES: usize = 8192;

/// What surrounds the mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Walls {
    /// Free space: the field of the total mass at its centre is prescribed on the mesh's border (3.10).
    Free,
    /// Free space, with the second moments of the mass in that field as well: for long or divided mass, whose field (3.10) misses by
    /// (extent / distance of the border)^2 of its quadrupole. Without screening only.
    FreeQuadrupole,
    /// A box without flux through its walls: the normal derivative of u vanishes there, and particles outside act from, and
    /// are driven at, their mirror places. Without screening the mean density is subtracted (a box holds no steady
    /// field of a net mass otherwise) and u has mean zero.
    NoFlux,
}

/// The least number of cells >= `n` that the solve is fastest for: 2^a 3^b 5^c.
///
/// Any number works, and one smooth axis of the two suffices, as the transform runs along that one. Prime factors up to 31
/// have passes of their own; with a larger one along both axes the solve takes two to three times as long.
#[must_use]
pub fn good_size(n: usize) -> usize {
    fft::smooth(n.clamp(2, MAX_CELLS))
}

/// How fast the error of the particles' attraction falls with the mesh width h, in sums over many of them (the rate of a second moment), where
/// their density is smooth. At a single place bilinear interpolation leaves an error of second order with either.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Order {
    /// h^2: the five-point scheme and centred differences of Zhelezov & Fatkullin. Attraction within some widths is lost, in a cloud of
    /// root mean square radius a about 0.4 (h / a)^2 of all.
    #[default]
    Second,
    /// h^4, in free space with square cells: the compact scheme of nine points (Collatz, *The Numerical Treatment of Differential Equations*, 1960, table VI, "Mehrstellen"),
    /// differences over five nodes, and a density sharpened by what cloud-in-cell deposit and interpolation smooth it. Cells must be
    /// nearly square (sides within a factor of 1.25) and resolve the screening (k h <= 1); the field prescribed on a free border is then off by
    /// (k h)^2 / 12 of itself, and by a quadrupole of a sixth of the sides' difference of squares, smooth inside. On that border and next to it
    /// differences stay centred ones. Potential and gradient at the nodes are sharpened for interpolation: by themselves of second order.
    Fourth,
}

/// Which field the grid solves for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Equation<T> {
    /// k >= 0 of Laplacian(u) - k^2 u = density; 0 is Poisson's equation.
    pub screening: T,
    /// Free space or a box.
    pub walls: Walls,
    /// Of the scheme.
    pub order: Order,
}

impl<T: Real> Equation<T> {
    /// Poisson's equation in free space, by the scheme of second order.
    pub const POISSON: Self = Self { screening: T::ZERO, walls: Walls::Free, order: Order::Second };

    fn check(&self, mesh: &Mesh<T>) -> Result<()> {
        if !self.screening.is_finite() {
            return Err(Error::NotFinite);
        }
        if self.screening < T::ZERO {
            return Err(Error::KernelParameter);
        }
        let [h, k] = mesh.spacing();
        let (longer, shorter) = (h.max(k), h.min(k));
        let coarse = longer > T::from_f64(1.25) * shorter || self.screening * longer > T::ONE;
        let refused =
            self.walls == Walls::FreeQuadrupole && self.screening > T::ZERO || self.order == Order::Fourth && coarse;
        if refused { Err(Error::Unsupported) } else { Ok(()) }
    }
}

/// A mesh with its density, potential and gradient, all in the caller's memory.
///
/// Everything it holds is rewritten from the particles at each deposit and solve, so a checkpoint need not save it.
#[derive(Debug)]
pub struct Grid<'w, T: Real> {
    mesh: Mesh<T>,
    equation: Equation<T>,
    locator: Locator,
    workers: usize,
    scale: MassScale,
    outside: u64,
    monopole: Monopole<T>,
    /// As the solve sees it: with masses in units of their bound.
    relative: Monopole<T>,
    /// That unit, in two factors.
    unit: [T; 2],
    arrays: Arrays<'w, T>,
}

#[derive(Debug)]
struct Arrays<'w, T: Real> {
    /// A mesh of masses with its tail for each worker, one after the other. The first is the result.
    words: &'w mut [i64],
    /// The centred differences of u at the nodes.
    gradient: &'w mut [[T; 2]],
    solver: poisson::Solver<'w, T>,
}

fn layout<'w, T: Real>(
    space: &mut impl Space<'w>,
    mesh: &Mesh<T>,
    equation: &Equation<T>,
    workers: usize,
) -> Result<Arrays<'w, T>> {
    let nodes = mesh.nodes();
    let words = nodes.checked_add(TAIL).and_then(|n| n.checked_mul(workers)).ok_or(Error::TooLarge)?;
    Ok(Arrays {
        words: space.try_array(words)?,
        gradient: space.try_array(nodes)?,
        solver: poisson::Solver::layout(space, mesh, equation, workers)?,
    })
}

impl<'w, T: Real> Grid<'w, T> {
    /// The exact bytes that [`Grid::prepare`] needs for calls with at most `workers` workers.
    ///
    /// # Errors
    /// [`Error::TooLarge`], and those of the equation: [`Error::NotFinite`], [`Error::KernelParameter`] (k < 0),
    /// [`Error::Unsupported`] (second moments with screening; the fourth order with cells that are long or coarse for the screening).
    pub fn workspace_bytes(mesh: &Mesh<T>, equation: &Equation<T>, workers: usize) -> Result<usize> {
        equation.check(mesh)?;
        Measure::of(|space| layout(space, mesh, equation, workers.clamp(1, MAX_WORKERS)).map(|_| ()))
    }

    /// Makes a grid without mass in `memory`, for executors with at most `workers` workers.
    ///
    /// # Errors
    /// As [`Grid::workspace_bytes`], and [`Error::WorkspaceTooSmall`], [`Error::Misaligned`].
    pub fn prepare(memory: &'w mut [u8], mesh: Mesh<T>, equation: Equation<T>, workers: usize) -> Result<Self> {
        let workers = workers.clamp(1, MAX_WORKERS);
        if memory.len() < Self::workspace_bytes(&mesh, &equation, workers)? {
            return Err(Error::WorkspaceTooSmall);
        }
        let arrays = layout(&mut Carve::new(memory)?, &mesh, &equation, workers)?;
        let [h, k] = mesh.spacing();
        let monopole = Monopole {
            mass: T::ZERO,
            centre: mesh.node(0, 0),
            screening: equation.screening,
            floor: T::HALF * h.min(k),
            quadrupole: [T::ZERO; 2],
            reach: T::ONE.ldexp(mesh.reach()),
        };
        let mut grid = Self {
            mesh,
            equation,
            locator: Locator::new(&mesh),
            workers,
            scale: MassScale::for_total(T::ONE)?,
            outside: 0,
            monopole,
            relative: monopole,
            unit: [T::ONE; 2],
            arrays,
        };
        grid.arrays.solver.prepare(&grid.mesh, &grid.equation);
        Ok(grid)
    }

    /// The mesh.
    pub fn mesh(&self) -> &Mesh<T> {
        &self.mesh
    }

    /// The equation.
    pub fn equation(&self) -> &Equation<T> {
        &self.equation
    }

    fn check_workers(&self, executor: &dyn Executor) -> Result<()> {
        let used = executor.workers().clamp(1, MAX_WORKERS);
        if used > self.workers { Err(Error::WorkspaceTooSmall) } else { Ok(()) }
    }

    /// Replaces the density by that of these particles: [`Grid::begin`] with [`MassScale::of`], then [`Grid::add`].
    ///
    /// # Errors
    /// As both; a refused length or scale leaves the density as it was.
    pub fn deposit(&mut self, positions: &[[T; 2]], masses: &[T], executor: &dyn Executor) -> Result<()> {
        self.check_workers(executor)?;
        if positions.len() != masses.len() {
            return Err(Error::LengthMismatch);
        }
        self.begin(MassScale::of(masses)?);
        self.add(positions, masses, executor)
    }

    /// Removes all mass and sets the unit for what will be added, one array or rank or species after the other.
    pub fn begin(&mut self, scale: MassScale) {
        self.scale = scale;
        self.arrays.words.fill(0);
    }

    /// Adds particles to the density, cloud in cell; the four shares of a mass add up to it exactly in units of the scale.
    ///
    /// Positions outside the mesh ([`Mesh::contains`] says which: those on its border are inside) are counted ([`Grid::outside`]) and act through the monopole; with no-flux walls they act
    /// from their mirror places.
    ///
    /// Cost: about 7 ns a particle.
    ///
    /// # Errors
    /// [`Error::LengthMismatch`], [`Error::WorkspaceTooSmall`] (the executor has more workers than the grid was prepared for)
    /// before anything is added; [`Error::NotFinite`]: a position is not, the density being then undefined.
    pub fn add(&mut self, positions: &[[T; 2]], masses: &[T], executor: &dyn Executor) -> Result<()> {
        self.change(positions, masses, false, executor)
    }

    /// Takes particles out that were added with the same positions and masses, to the bit: the density is as if they had never been there.
    ///
    /// # Errors
    /// As [`Grid::add`].
    pub fn remove(&mut self, positions: &[[T; 2]], masses: &[T], executor: &dyn Executor) -> Result<()> {
        self.change(positions, masses, true, executor)
    }

    fn change(&mut self, positions: &[[T; 2]], masses: &[T], remove: bool, executor: &dyn Executor) -> Result<()> {
        self.check_workers(executor)?;
        if positions.len() != masses.len() {
            return Err(Error::LengthMismatch);
        }
        let (mesh, locator, walls, scale) = (&self.mesh, self.locator, self.equation.walls, self.scale);
        let each = mesh.nodes() + TAIL;
        let tasks = positions.len().div_ceil(PARTICLES);
        par_chunks(executor, tasks, (), Chunks::new(self.arrays.words, each), &|task, (), words| {
            let from = task * PARTICLES;
            let until = positions.len().min(from.saturating_add(PARTICLES));
            let (positions, masses) = (positions.get(from..until), masses.get(from..until));
            let (positions, masses) = (positions.unwrap_or_default(), masses.unwrap_or_default());
            with_simd(Level::best(), deposit::Deposit { mesh, locator, walls, scale, positions, masses, remove, words })
        })?;
        // Which worker took which task does not matter: integers add up to the same in any order.
        let (result, others) = self.arrays.words.split_at_mut_checked(each).ok_or(Error::WorkspaceTooSmall)?;
        for other in others.chunks_mut(each.max(1)) {
            for (sum, word) in result.iter_mut().zip(other) {
                *sum = sum.wrapping_add(*word);
                *word = 0;
            }
        }
        Ok(())
    }

    /// The masses at the nodes in units of [`Grid::scale`], then eight words about what lies outside the mesh.
    ///
    /// Ranks that hold parts of the particles add these words up over all of them, element by element, between
    /// [`Grid::add`] and [`Grid::solve`]; with one scale on all ranks ([`MassScale::for_total`]) the field has the bits of
    /// the run on one rank.
    pub fn words_mut(&mut self) -> &mut [i64] {
        let each = self.mesh.nodes() + TAIL;
        self.arrays.words.get_mut(..each).unwrap_or_default()
    }

    /// As [`Grid::words_mut`], to read.
    pub fn words(&self) -> &[i64] {
        let each = self.mesh.nodes() + TAIL;
        self.arrays.words.get(..each).unwrap_or_default()
    }

    /// The unit of the masses in [`Grid::words`].
    pub fn scale(&self) -> MassScale {
        self.scale
    }

    /// Particles outside the mesh that the last [`Grid::solve`] saw (free space only).
    pub fn outside(&self) -> u64 {
        self.outside
    }

    /// All mass at its centre, as the last [`Grid::solve`] used it.
    pub fn monopole(&self) -> &Monopole<T> {
        &self.monopole
    }

    /// Finds the total mass, its centre and the number of particles outside, as [`Grid::solve`] does first.
    pub fn locate_mass(&mut self) {
        let sum = deposit::sum(&self.mesh, self.words());
        self.outside = sum.outside;
        let (unit, relative) = (self.scale.unit(), 1.0_f64.ldexp(-fixed::BITS));
        let of = |masses: f64, unit: f64| T::from_f64(masses * unit);
        let mass = sum.units as f64;
        self.monopole.centre = sum.centre.map(T::from_f64);
        self.monopole.mass = of(mass, unit);
        self.relative = Monopole { mass: of(mass, relative), ..self.monopole };
        self.unit = fixed::halves(self.scale.exponent() + fixed::BITS);
        if self.equation.walls == Walls::FreeQuadrupole {
            let moments = deposit::second_moments(&self.mesh, self.words(), sum.centre, self.mesh.reach());
            self.monopole.quadrupole = moments.map(|q| of(q, unit));
            self.relative.quadrupole = moments.map(|q| of(q, relative));
        }
    }

    /// Overwrites `out` with the masses at the nodes, node (i, j) at `j (cells[0] + 1) + i`.
    ///
    /// # Errors
    /// [`Error::LengthMismatch`] before anything is written.
    pub fn masses(&self, out: &mut [T]) -> Result<()> {
        if out.len() != self.mesh.nodes() {
            return Err(Error::LengthMismatch);
        }
        let unit = self.scale.unit();
        for (mass, &units) in out.iter_mut().zip(self.words()) {
            *mass = T::from_f64(units as f64 * unit);
        }
        Ok(())
    }

    /// Solves for the potential and its gradient at the nodes.
    ///
    /// Cost: 14 ns a node (1.4 ms for 320 x 320 cells, one thread; [`good_size`] tells which sizes are fast). Accuracy: the
    /// five-point equations are solved to 2e-13 of the largest u for every size up to 257 and for 511 and 1000 (test
    /// `every_size_against_a_manufactured_solution`), both schemes' equations hold to 1e-14 (test `the_scheme_holds_in_every_setting`). For their
    /// errors see [`Order`] (test
    /// `what_the_mesh_loses_of_the_attraction_falls_as_the_order_says`).
    ///
    /// # Errors
    /// [`Error::WorkspaceTooSmall`]: the executor has more workers than the grid was prepared for.
    pub fn solve(&mut self, executor: &dyn Executor) -> Result<()> {
        self.check_workers(executor)?;
        self.locate_mass();
        let each = self.mesh.nodes() + TAIL;
        let Arrays { words, gradient, solver } = &mut self.arrays;
        let words = words.get(..each).ok_or(Error::WorkspaceTooSmall)?;
        solver.solve(&self.mesh, &self.equation, &self.relative, words, executor)?;
        let unit = self.scale.exponent() + fixed::BITS;
        solver.differences(&self.mesh, self.equation.order, unit, gradient, executor)
    }

    /// Overwrites `out` with u at the nodes, node (i, j) at `j (cells[0] + 1) + i`.
    ///
    /// # Errors
    /// [`Error::LengthMismatch`] before anything is written.
    pub fn potential(&self, out: &mut [T]) -> Result<()> {
        if out.len() != self.mesh.nodes() {
            return Err(Error::LengthMismatch);
        }
        let (pitch, [first, second]) = (self.mesh.cells()[0] + 1, self.unit);
        for (j, row) in out.chunks_mut(pitch.max(1)).enumerate() {
            for (i, u) in row.iter_mut().enumerate() {
                *u = self.arrays.solver.value(i, j) * first * second;
            }
        }
        Ok(())
    }

    /// The centred differences of u at the nodes (3.6), (3.7); on the border they use the Dirichlet data's continuation.
    pub fn gradient(&self) -> &[[T; 2]] {
        self.arrays.gradient
    }

    /// Overwrites `out[i]` with grad u at `positions[i]`.
    ///
    /// A position that is not finite gets NaN. Cost: about 12 ns a particle.
    ///
    /// # Errors
    /// [`Error::LengthMismatch`] before anything is written; [`Error::Executor`].
    pub fn interpolate(&self, positions: &[[T; 2]], out: &mut [[T; 2]], executor: &dyn Executor) -> Result<()> {
        if positions.len() != out.len() {
            return Err(Error::LengthMismatch);
        }
        let tasks = positions.len().div_ceil(PARTICLES);
        par_chunks(executor, tasks, Chunks::new(out, PARTICLES), (), &|task, out, ()| {
            let from = task * PARTICLES;
            let positions = positions.get(from..positions.len().min(from.saturating_add(PARTICLES)));
            self.interpolate_here(positions.unwrap_or_default(), out);
            Ok(())
        })
    }

    /// [`Grid::interpolate`] within a task of the caller's: for as many as both slices hold, in this thread.
    pub fn interpolate_here(&self, positions: &[[T; 2]], out: &mut [[T; 2]]) {
        let job = interpolate::Interpolate {
            mesh: &self.mesh,
            locator: self.locator,
            walls: self.equation.walls,
            monopole: self.relative,
            unit: self.unit,
            gradient: self.arrays.gradient,
            positions,
            out,
        };
        with_simd(Level::best(), job);
    }

    /// grad u at one point: the same bits as [`Grid::interpolate`].
    pub fn gradient_at(&self, x: [T; 2]) -> [T; 2] {
        let mut out = [[T::ZERO; 2]];
        self.interpolate_here(&[x], &mut out);
        let [gradient] = out;
        gradient
    }
}

#[cfg(test)]
mod tests;

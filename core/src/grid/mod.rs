//! Mesh fields: deposit, Poisson solve, interpolation (Zhelezov & Fatkullin, Section 3.4).
//!
//! [`Grid`] computes u = sum_n m_n V(x - x_n), V = log r / (2 pi) or -K0(k r) / (2 pi), and its gradient at the particles:
//!
//! 1. [`Grid::deposit`] adds each particle's mass to the four nodes of its cell (cloud in cell), in 64-bit fixed point. The bits
//!    of the field then depend neither on the order of the particles nor on threads or ranks.
//! 2. [`Grid::solve`] solves the five-point scheme (3.9), Laplacian(u) - k^2 u = density. The border has Dirichlet data from the
//!    monopole of all mass (3.10), optionally with the quadrupole, or no-flux walls.
//! 3. [`Grid::interpolate`] interpolates the centred differences (3.6), (3.7) with the weights of the deposit. The interpolation is
//!    its adjoint, so a particle exerts no force on itself. Outside the mesh the gradient is the monopole's (3.8).
//!
//! This is the scheme of the paper. [`Order::Fourth`] uses a compact nine-point scheme and differences over five nodes, and
//! compensates the smoothing by deposit and interpolation.
//!
//! The sign is that of the field sums: the paper's c is -u, and its drift chi grad c is -chi grad u. Only + - * / and sqrt,
//! integers and libm are used, in an order that depends on the mesh alone. The bits are the same on every machine, at every
//! level and for any number of threads.

mod deposit;
mod fft;
mod fixed;
mod interpolate;
mod mesh;
mod monopole;
mod parabolic;
mod poisson;
mod transform;
mod variable;

pub use fixed::MassScale;
pub use mesh::{MAX_CELLS, Mesh};
pub use monopole::Monopole;
pub use parabolic::Parabolic;
pub use variable::{Coefficients, Limits, Report, Variable};

use crate::checked::Present;
use crate::error::{Error, Result};
use crate::exec::{Chunks, MAX_WORKERS, Resources, par_chunks};
use crate::memory::{Carve, Measure, Space};
use crate::real::{Real, Scalar};
use crate::simd::{Level, with_simd};
use deposit::TAIL;
use mesh::Locator;

/// Particles per task.
const PARTICLES: usize = 8192;

/// The boundary conditions of the mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Walls {
    /// Free space: the field of the total mass at its centre is the Dirichlet data on the border (3.10).
    Free,
    /// Free space, with the second moments of the mass in the Dirichlet data too. For elongated or separated mass, where (3.10) has a relative
    /// error of the quadrupole's size, (extent / distance of the border)^2. Only without screening.
    FreeQuadrupole,
    /// A box with no-flux walls, where the normal derivative of u vanishes. Particles outside contribute at their mirror
    /// images and get the gradient there, mirrored. Without screening the mean density is subtracted, because a box has no steady
    /// field of a net mass, and u has mean zero.
    NoFlux,
}

/// The smallest number of cells >= `n` for which the solve is fastest: 2^a 3^b 5^c.
///
/// Any number works. One such axis suffices, because the transform runs along it. Prime factors up to 31
/// have their own passes. With a larger one along both axes the solve takes two to three times as long.
#[must_use]
pub fn good_size(n: usize) -> usize {
    fft::smooth(n.clamp(2, MAX_CELLS))
}

/// How fast the error of the attraction decreases with the mesh width h, in sums over many particles (the rate of a second moment) of
/// smooth density. At a single point bilinear interpolation has an error of second order for both.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Order {
    /// h^2: the five-point scheme and centred differences of Zhelezov & Fatkullin. Attraction within some mesh widths is lost: in a cloud
    /// of root mean square radius a about 0.4 (h / a)^2 of the total.
    #[default]
    Second,
    /// h^4, in free space with square cells: the compact nine-point scheme (Collatz, *The Numerical Treatment of Differential
    /// Equations*, 1960, table VI, "Mehrstellen"), differences over five nodes, and a density sharpened against the smoothing by cloud-in-cell
    /// deposit and interpolation. Cells must be nearly square (sides within a factor of 1.25) and resolve the screening (k h <= 1). The field
    /// prescribed on a free border then has a relative error of (k h)^2 / 12, and the error of a quadrupole of one sixth of the difference of
    /// the squared sides, smooth inside. Differences on that border and next to it remain centred. Potential and gradient at the nodes are
    /// sharpened for interpolation; by themselves they are of second order.
    Fourth,
}

/// The equation that the grid solves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Equation<T> {
    /// k >= 0 of Laplacian(u) - k^2 u = density; 0 is Poisson's equation.
    pub screening: T,
    /// Free space or a box.
    pub walls: Walls,
    /// The order of the scheme.
    pub order: Order,
}

impl<T: Real> Equation<T> {
    /// Poisson's equation in free space, with the scheme of second order.
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
/// Each deposit and solve recomputes all of it from the particles, so a checkpoint need not save it.
#[derive(Debug)]
pub struct Grid<'w, T: Real> {
    mesh: Mesh<T>,
    equation: Equation<T>,
    locator: Locator,
    workers: usize,
    scale: MassScale,
    outside: u64,
    monopole: Monopole<T>,
    /// The monopole that the solve uses: masses in units of their bound.
    relative: Monopole<T>,
    /// That unit, as two factors.
    unit: [T; 2],
    arrays: Arrays<'w, T>,
}

#[derive(Debug)]
struct Arrays<'w, T: Real> {
    /// The masses of the nodes and the tail, once per worker. The first copy is the result.
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
    /// The exact number of bytes that [`Grid::prepare`] needs for calls with at most `workers` workers.
    ///
    /// # Errors
    /// [`Error::TooLarge`], and those of the equation: [`Error::NotFinite`], [`Error::KernelParameter`] (k < 0),
    /// [`Error::Unsupported`] (second moments with screening; fourth order with cells that are too long or too coarse for the screening).
    pub fn workspace_bytes(mesh: &Mesh<T>, equation: &Equation<T>, workers: usize) -> Result<usize> {
        equation.check(mesh)?;
        Measure::of(|space| layout(space, mesh, equation, workers.clamp(1, MAX_WORKERS)).map(|_| ()))
    }

    /// Creates a grid without mass in `memory`, for executors with at most `workers` workers.
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

    fn check_workers(&self, resources: Resources<'_>) -> Result<()> {
        let used = resources.executor.workers().clamp(1, MAX_WORKERS);
        if used > self.workers { Err(Error::WorkspaceTooSmall) } else { Ok(()) }
    }

    /// Replaces the density by that of these particles: [`Grid::begin`] with [`MassScale::of`], then [`Grid::add`].
    ///
    /// # Errors
    /// As both. If a length or the scale is refused, the density is unchanged.
    pub fn deposit(&mut self, positions: &[[T; 2]], masses: &[T], resources: Resources<'_>) -> Result<()> {
        self.check_workers(resources)?;
        if positions.len() != masses.len() {
            return Err(Error::LengthMismatch);
        }
        self.begin(MassScale::of(masses)?);
        self.add(positions, masses, resources)
    }

    /// Removes all mass and sets the unit of what is added afterwards, by array, rank or species.
    pub fn begin(&mut self, scale: MassScale) {
        self.scale = scale;
        self.arrays.words.fill(0);
    }

    /// Adds particles to the density, cloud in cell. The four shares of a mass add up to it exactly, in units of the scale.
    ///
    /// Positions outside the mesh (see [`Mesh::contains`]; the border is inside) are counted ([`Grid::outside`]) and contribute to the
    /// monopole. With no-flux walls they contribute at their mirror images.
    ///
    /// Cost: about 7 ns a particle.
    ///
    /// # Errors
    /// [`Error::LengthMismatch`], [`Error::WorkspaceTooSmall`] (the executor has more workers than the grid was prepared for)
    /// before anything is added; [`Error::NotFinite`]: a position is not finite, and the density is then undefined.
    pub fn add(&mut self, positions: &[[T; 2]], masses: &[T], resources: Resources<'_>) -> Result<()> {
        self.change(positions, masses, false, resources)
    }

    /// Removes particles that were added with the same positions and masses. The density is then bit for bit the one without them.
    ///
    /// # Errors
    /// As [`Grid::add`].
    pub fn remove(&mut self, positions: &[[T; 2]], masses: &[T], resources: Resources<'_>) -> Result<()> {
        self.change(positions, masses, true, resources)
    }

    fn change(&mut self, positions: &[[T; 2]], masses: &[T], remove: bool, resources: Resources<'_>) -> Result<()> {
        self.check_workers(resources)?;
        if positions.len() != masses.len() {
            return Err(Error::LengthMismatch);
        }
        let (mesh, locator, walls, scale) = (&self.mesh, self.locator, self.equation.walls, self.scale);
        let each = mesh.nodes() + TAIL;
        let tasks = positions.len().div_ceil(PARTICLES);
        par_chunks(resources.executor, tasks, (), Chunks::new(self.arrays.words, each), &|task, (), words| {
            let from = task * PARTICLES;
            let until = positions.len().min(from.saturating_add(PARTICLES));
            let (positions, masses) = (positions.get(from..until), masses.get(from..until));
            let (positions, masses) = (positions.unwrap_or_default(), masses.unwrap_or_default());
            with_simd(
                resources.level,
                deposit::Deposit { mesh, locator, walls, scale, positions, masses, remove, words },
            )
        })?;
        // The assignment of tasks to workers does not matter, because the integer sum is the same in any order.
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
    /// Ranks that hold parts of the particles sum these words over all ranks, element by element, between
    /// [`Grid::add`] and [`Grid::solve`]. With one scale on all ranks ([`MassScale::for_total`]) the field has the bits of
    /// the run on one rank.
    pub fn words_mut(&mut self) -> &mut [i64] {
        let each = self.mesh.nodes() + TAIL;
        self.arrays.words.get_mut(..each).present_or_default()
    }

    /// As [`Grid::words_mut`], read-only.
    pub fn words(&self) -> &[i64] {
        let each = self.mesh.nodes() + TAIL;
        self.arrays.words.get(..each).present_or_default()
    }

    /// The unit of the masses in [`Grid::words`].
    pub fn scale(&self) -> MassScale {
        self.scale
    }

    /// Number of particles outside the mesh in the last [`Grid::solve`] (free space only).
    pub fn outside(&self) -> u64 {
        self.outside
    }

    /// The total mass at its centre, as used by the last [`Grid::solve`].
    pub fn monopole(&self) -> &Monopole<T> {
        &self.monopole
    }

    /// Computes the total mass, its centre and the number of particles outside; the first step of [`Grid::solve`].
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
    /// Cost: 14 ns a node (1.4 ms for 320 x 320 cells, one thread; [`good_size`] gives fast sizes). Accuracy: the
    /// five-point equations are solved to 2e-13 of the largest u for every size up to 257 and for 511 and 1000 (test
    /// `every_size_against_a_manufactured_solution`). Both schemes' equations hold to 1e-14 (test `the_scheme_holds_in_every_setting`).
    /// For the errors of the schemes see [`Order`] (test `what_the_mesh_loses_of_the_attraction_falls_as_the_order_says`).
    ///
    /// # Errors
    /// [`Error::WorkspaceTooSmall`]: the executor has more workers than the grid was prepared for.
    pub fn solve(&mut self, resources: Resources<'_>) -> Result<()> {
        self.check_workers(resources)?;
        self.locate_mass();
        let each = self.mesh.nodes() + TAIL;
        let Arrays { words, gradient, solver } = &mut self.arrays;
        let words = words.get(..each).ok_or(Error::WorkspaceTooSmall)?;
        solver.solve(&self.mesh, &self.equation, &self.relative, words, resources)?;
        let unit = self.scale.exponent() + fixed::BITS;
        solver.differences(&self.mesh, self.equation.order, unit, gradient, resources)
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

    /// The centred differences of u at the nodes (3.6), (3.7). On the border they use the field of the Dirichlet data one width outside.
    pub fn gradient(&self) -> &[[T; 2]] {
        self.arrays.gradient
    }

    /// Overwrites `out[i]` with grad u at `positions[i]`.
    ///
    /// A position that is not finite gets NaN. Cost: about 12 ns a particle.
    ///
    /// # Errors
    /// [`Error::LengthMismatch`] before anything is written; [`Error::Executor`].
    pub fn interpolate(&self, positions: &[[T; 2]], out: &mut [[T; 2]], resources: Resources<'_>) -> Result<()> {
        if positions.len() != out.len() {
            return Err(Error::LengthMismatch);
        }
        let tasks = positions.len().div_ceil(PARTICLES);
        par_chunks(resources.executor, tasks, Chunks::new(out, PARTICLES), (), &|task, out, ()| {
            let from = task * PARTICLES;
            let positions = positions.get(from..positions.len().min(from.saturating_add(PARTICLES)));
            self.interpolate_here(positions.unwrap_or_default(), out, resources.level);
            Ok(())
        })
    }

    /// [`Grid::interpolate`] in the calling thread, for use within a caller's task. The shorter slice gives the number of particles.
    pub fn interpolate_here(&self, positions: &[[T; 2]], out: &mut [[T; 2]], level: Level) {
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
        with_simd(level, job);
    }

    /// grad u at one point, with the same bits as [`Grid::interpolate`].
    pub fn gradient_at(&self, x: [T; 2]) -> [T; 2] {
        let mut out = [[T::ZERO; 2]];
        self.interpolate_here(&[x], &mut out, Level::Portable);
        let [gradient] = out;
        gradient
    }
}

#[cfg(test)]
mod tests;

//! Mesh fields in a medium: div(G grad u) - k^2 u = density with G and k^2 that depend on the place (Zhelezov & Fatkullin, (1.1), (1.2) with F = -k^2 c,
//! and Section 4.6; their c is -u).
//!
//! ```
//! use mollis_core::exec::Resources;
//! use mollis_core::grid::{Coefficients, Limits, Mesh, Variable, Walls};
//! use mollis_core::memory::ALIGN;
//!
//! // A disc of ten times the diffusivity in the middle of free space.
//! let mesh = Mesh::new([-1.0, -1.0], [1.0, 1.0], [64, 64])?;
//! let inside = |k: usize| mesh.node((k % 65) as isize, (k / 65) as isize).iter().map(|x| x * x).sum::<f64>() < 0.16;
//! let diffusivity: Vec<f64> = (0..mesh.nodes()).map(|k| if inside(k) { 10.0 } else { 1.0 }).collect();
//! let medium = Coefficients { diffusivity: &diffusivity, decay: None };
//!
//! let bytes = Variable::workspace_bytes(&mesh, Walls::Free, 1)?;
//! let mut memory = vec![0; bytes + ALIGN];
//! let start = memory.as_ptr().align_offset(ALIGN);
//! let mut field = Variable::prepare(&mut memory[start..start + bytes], mesh, Walls::Free, &medium, 1)?;
//!
//! field.deposit(&[[0.5, 0.0], [-0.3, 0.1]], &[1.0, 2.0], Resources::default())?;
//! let report = field.solve(&Limits { tolerance: 1e-10, iterations: 60 }, Resources::default())?;
//! assert!(report.iterations < 40 && report.residual <= 1e-10);
//!
//! // grad u at a place, and the strength of the logarithm there, gamma = 1 / (2 pi G), for the index (4.30).
//! let (gradient, gamma) = (field.grid().gradient_at([0.5, 0.3]), field.gamma_at([0.0, 0.0]));
//! assert!(gradient[1] > 0.0 && (gamma - 0.1 / std::f64::consts::TAU).abs() < 1e-15);
//! # Ok::<(), mollis_core::Error>(())
//! ```
//!
//! **Scheme.** G and k^2 are values at the nodes, as masses and potentials are, and stand for the cells around the nodes. A face between two nodes has the
//! harmonic mean of their G, with which the flux through a jump midway between two nodes is exact. Where G and k^2 are smooth, or jump along lines midway
//! between nodes, the error of u is of second order in the mesh width; where a jump crosses the mesh elsewhere, of first order. With equal values everywhere these
//! are the five-point equations of [`Grid::solve`](super::Grid::solve).
//!
//! **Solver.** Conjugate gradients, preconditioned by the direct solver for the means of G and k^2 (Concus & Golub, SIAM J. Numer. Anal. 10, 1973). The number of
//! iterations does not depend on the mesh. It grows as the square root of max G / min G at most, or of the same ratio of k^2 / G + 1 over the square of a side, if that
//! is larger. Observed for meshes of 64 x 64 to 512 x 512 cells and a tolerance of 1e-10:
//!
//! | medium | iterations |
//! |---|---|
//! | G = 1 and 10 in two halves | 23 to 24 |
//! | G = 10 or 0.1 in a disc, 1 outside | 25 to 27 |
//! | G random between 1 and 10, independent at each node | 26 to 29 |
//! | G = 1 and 10 on a board of 8 x 8 squares | 32 to 34 |
//! | smooth, G from 1 to 10 | 35 to 37 |
//! | G = 1000 in a disc, 1 outside | 58 to 63 |
//! | k^2 = 1e4 in a disc of one tenth of the side, 0 outside | 93 to 95 |
//!
//! **Gradients** are those of [`Grid`](super::Grid): centred differences, interpolated bilinearly. Within a mesh width of a jump of G, where the
//! gradient jumps too, they are a mean of both sides.
//!
//! **What a particle feels of itself.** Where G varies, V(x, y) is `log|x - y| / (2 pi sqrt(G(x) G(y)))` near the diagonal, so a particle's own field has a gradient at
//! its place: `(m grad G / (4 pi G^2)) log(1/h)` on a mesh of width h, and a constant. The sum of (1.3) is without it. It is small if many particles make the
//! field, and not for a heavy particle in a gradient of G.

mod iteration;
mod scheme;

use super::fixed::{BITS, halves};
use super::mesh::{Locator, OUTSIDE};
use super::poisson::Shape;
use super::{Equation, Grid, MassScale, Mesh, Monopole, Order, Walls};
use crate::checked::Present;
use crate::error::{Error, Result};
use crate::exec::{MAX_WORKERS, Resources};
use crate::memory::{Carve, Measure, Space};
use crate::real::Real;
use iteration::Vectors;
use scheme::Scheme;

/// The coefficients at the nodes of a mesh, node (i, j) at `j (cells[0] + 1) + i`.
#[derive(Clone, Copy, Debug)]
pub struct Coefficients<'a, T> {
    /// G > 0, in any unit.
    pub diffusivity: &'a [T],
    /// k^2 >= 0, in the unit of G over length^2. `None`: 0 everywhere.
    pub decay: Option<&'a [T]>,
}

impl<T: Real> Coefficients<'_, T> {
    fn check(&self, mesh: &Mesh<T>, walls: Walls) -> Result<()> {
        let Self { diffusivity, decay } = *self;
        let nodes = mesh.nodes();
        if diffusivity.len() != nodes || decay.is_some_and(|decay| decay.len() != nodes) {
            return Err(Error::LengthMismatch);
        }
        let decay = decay.unwrap_or_default();
        if !diffusivity.iter().chain(decay).all(|v| v.is_finite()) {
            return Err(Error::NotFinite);
        }
        let (least, most) =
            diffusivity.iter().fold((T::INFINITY, T::ZERO), |(least, most), &g| (least.min(g), most.max(g)));
        if least <= T::ZERO || least < most * T::EPSILON || decay.iter().any(|&k| k < T::ZERO) {
            return Err(Error::OutOfDomain);
        }
        let refused = match walls {
            Walls::NoFlux => false,
            Walls::FreeQuadrupole => true,
            Walls::Free => {
                let bounds = (border(mesh, diffusivity), border(mesh, decay));
                !matches!(bounds, (Some(_), Some(k)) if k > T::ZERO || decay.iter().all(|&k| k == T::ZERO))
            }
        };
        if refused { Err(Error::Unsupported) } else { Ok(()) }
    }
}

/// The one value on the border; 0 of no values.
fn border<T: Real>(mesh: &Mesh<T>, values: &[T]) -> Option<T> {
    let [n, m] = mesh.cells();
    let first = values.first().copied().unwrap_or(T::ZERO);
    let constant = values.chunks((n + 1).max(1)).enumerate().all(|(j, row)| {
        let inner = row.len().saturating_sub(1).max(1);
        let step = if j == 0 || j == m { 1 } else { inner };
        row.iter().step_by(step.max(1)).all(|&v| v == first)
    });
    constant.then_some(first)
}

/// When the iteration ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits<T> {
    /// The relative residual to be reached, see [`Report::residual`]; positive.
    pub tolerance: T,
    /// The largest number of iterations.
    pub iterations: u32,
}

/// What the iteration did.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Report<T> {
    /// The number of iterations. The direct solver is called twice more, in free space three times.
    pub iterations: u32,
    /// The residual r of the mesh equations, computed from the result, relative to the masses m: `sqrt(r M^-1 r / m M^-1 m)` with the preconditioner M.
    ///
    /// It bounds the error of the solve in the energy norm (the square root of sum G |grad|^2 + k^2 of it): with constant k^2 / G this error is at most
    /// `sqrt(max G / min G)` times the residual, relative to the field of the masses with zero border values.
    /// Rounding keeps it above about the scalar's epsilon times the square root of the number of nodes. 0 without mass.
    pub residual: T,
}

/// A [`Grid`] in a medium, all in the caller's memory. Each deposit and solve recomputes it from the particles.
#[derive(Debug)]
pub struct Variable<'w, T: Real> {
    grid: Grid<'w, T>,
    /// G at the nodes.
    diffusivity: &'w mut [T],
    scheme: Scheme<'w, T>,
    vectors: Vectors<'w, T>,
    /// The smallest G.
    least: T,
    /// The exponent of the unit of G.
    exponent: i32,
    /// G on the border in that unit.
    border: T,
    report: Report<T>,
}

struct Arrays<'w, T> {
    diffusivity: &'w mut [T],
    scheme: Scheme<'w, T>,
    vectors: Vectors<'w, T>,
}

fn layout<'w, T: Real>(space: &mut impl Space<'w>, mesh: &Mesh<T>, equation: &Equation<T>) -> Result<Arrays<'w, T>> {
    let shape = Shape::of(mesh, equation);
    let nodes = shape.pitch.checked_mul(shape.m + 1).ok_or(Error::TooLarge)?;
    Ok(Arrays {
        diffusivity: space.try_array(mesh.nodes())?,
        scheme: Scheme::layout(space, shape)?,
        vectors: Vectors::layout(space, nodes)?,
    })
}

/// The preconditioner's equation, but for its screening.
fn equation<T: Real>(walls: Walls) -> Equation<T> {
    Equation { screening: T::ZERO, walls, order: Order::Second }
}

impl<'w, T: Real> Variable<'w, T> {
    /// The exact number of bytes that [`Variable::prepare`] needs for calls with at most `workers` workers: those of [`Grid`] and eight numbers a node.
    ///
    /// # Errors
    /// [`Error::TooLarge`].
    pub fn workspace_bytes(mesh: &Mesh<T>, walls: Walls, workers: usize) -> Result<usize> {
        let equation = equation(walls);
        let own = Measure::of(|space| layout(space, mesh, &equation).map(|_| ()))?;
        Grid::workspace_bytes(mesh, &equation, workers)?.checked_add(own).ok_or(Error::TooLarge)
    }

    /// Creates a grid without mass in `memory`, for executors with at most `workers` workers. The coefficients are copied.
    ///
    /// # Errors
    /// As [`Variable::workspace_bytes`] and [`Variable::set_coefficients`], and [`Error::WorkspaceTooSmall`], [`Error::Misaligned`].
    pub fn prepare(
        memory: &'w mut [u8],
        mesh: Mesh<T>,
        walls: Walls,
        coefficients: &Coefficients<'_, T>,
        workers: usize,
    ) -> Result<Self> {
        let equation = equation(walls);
        coefficients.check(&mesh, walls)?;
        if memory.len() < Self::workspace_bytes(&mesh, walls, workers)? {
            return Err(Error::WorkspaceTooSmall);
        }
        let workers = workers.clamp(1, MAX_WORKERS);
        let of_grid = Grid::workspace_bytes(&mesh, &equation, workers)?;
        let (of_grid, own) = memory.split_at_mut_checked(of_grid).present()?;
        let grid = Grid::prepare(of_grid, mesh, equation, workers)?;
        let Arrays { diffusivity, scheme, vectors } = layout(&mut Carve::new(own)?, &mesh, &equation)?;
        let report = Report { iterations: 0, residual: T::ZERO };
        let mut field = Self { grid, diffusivity, scheme, vectors, least: T::ONE, exponent: 0, border: T::ONE, report };
        field.set_coefficients(coefficients)?;
        Ok(field)
    }

    /// Replaces the coefficients, for the solves that follow. Cost: about that of three iterations.
    ///
    /// # Errors
    /// Before anything is written: [`Error::LengthMismatch`]; [`Error::NotFinite`]; [`Error::OutOfDomain`]: G <= 0, k^2 < 0, or a G less than the scalar's
    /// epsilon times the largest. [`Error::Unsupported`]: with [`Walls::Free`] a G or k^2 that is not the same everywhere on the border, or a k^2
    /// that is 0 there and not everywhere, because the field far away is then not known; [`Walls::FreeQuadrupole`].
    pub fn set_coefficients(&mut self, coefficients: &Coefficients<'_, T>) -> Result<()> {
        let Self { grid, diffusivity, scheme, .. } = self;
        let mesh = grid.mesh;
        coefficients.check(&mesh, grid.equation.walls)?;
        diffusivity.iter_mut().zip(coefficients.diffusivity).for_each(|(own, &g)| *own = g);
        let most = diffusivity.iter().fold(T::ZERO, |most, &g| most.max(g));
        self.least = diffusivity.iter().fold(T::INFINITY, |least, &g| least.min(g));
        self.exponent = most.frexp().1;
        let means = scheme.set(&mesh, coefficients, self.exponent);
        let [h, k] = mesh.spacing();
        // k of the preconditioner: sqrt(k^2 h k / G) over the square root of the area, which itself may be out of range.
        grid.equation.screening = (means.decay / means.diffusivity).sqrt() / h.sqrt() / k.sqrt();
        grid.arrays.solver.prepare(&mesh, &grid.equation);
        let at_border = |values: &[T]| values.first().copied().unwrap_or(T::ZERO);
        let (g, decay) = (at_border(diffusivity), at_border(coefficients.decay.unwrap_or_default()));
        self.border = g.ldexp(-self.exponent);
        // The field far away: mass / (2 pi G) log r, or with K0(k r / sqrt(G)).
        grid.monopole.screening = decay.sqrt() / g.sqrt();
        Ok(())
    }

    /// The grid, for its results after [`Variable::solve`]: [`Grid::potential`], [`Grid::gradient`], [`Grid::interpolate`], [`Grid::masses`],
    /// [`Grid::outside`], [`Grid::monopole`]. Its [`Grid::equation`] is the preconditioner's.
    pub fn grid(&self) -> &Grid<'w, T> {
        &self.grid
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

    /// As [`Grid::locate_mass`]: a part of [`Variable::solve`], for who wants no more than the total mass.
    pub fn locate_mass(&mut self) {
        self.grid.locate_mass();
    }

    /// As [`Grid::words_mut`], for sums over ranks.
    pub fn words_mut(&mut self) -> &mut [i64] {
        self.grid.words_mut()
    }

    /// Solves for the potential and its gradient at the nodes, from zero (the result does not depend on earlier solves).
    ///
    /// Free space: the field of all mass at its centre in a medium with the border's G and k^2 is the Dirichlet data. It lacks what an inhomogeneous medium adds:
    /// a region of another G, of size a and at distance d from the mass, adds a dipole of relative size a^2 / (d R) on a border at distance R.
    /// [`Walls::NoFlux`]: with k^2 = 0 everywhere the mean density is subtracted, and u has mean zero.
    ///
    /// Cost: about 15 ns a node and iteration (one thread), of which the direct solver takes most; and two to three iterations more.
    ///
    /// # Errors
    /// Before anything is written: [`Error::NotFinite`], [`Error::OutOfDomain`] (the tolerance is not positive), [`Error::WorkspaceTooSmall`] (more workers than
    /// prepared for). [`Error::NotConverged`]: the tolerance was not reached; potential and gradient are those of the last iterate, which
    /// [`Variable::report`] describes. [`Error::Executor`]: the results are undefined.
    pub fn solve(&mut self, limits: &Limits<T>, resources: Resources<'_>) -> Result<Report<T>> {
        let Self { grid, scheme, vectors, exponent, border, report, .. } = self;
        if !limits.tolerance.is_finite() {
            return Err(Error::NotFinite);
        }
        if limits.tolerance <= T::ZERO {
            return Err(Error::OutOfDomain);
        }
        grid.check_workers(resources)?;
        grid.locate_mass();
        // u in units of the mass over that of G.
        let unit = grid.scale.exponent() + BITS - *exponent;
        grid.unit = halves(unit);
        grid.relative = Monopole { mass: grid.relative.mass / *border, ..grid.relative };
        let (result, reached) = vectors.solve(grid, scheme, limits, resources)?;
        *report = result;
        let super::Arrays { gradient, solver, .. } = &mut grid.arrays;
        solver.differences(&grid.mesh, Order::Second, unit, gradient, resources)?;
        if reached { Ok(result) } else { Err(Error::NotConverged) }
    }

    /// What the last [`Variable::solve`] did, also if it ended with [`Error::NotConverged`].
    pub fn report(&self) -> Report<T> {
        self.report
    }

    /// G at `x`, bilinear between the nodes. Outside the mesh: the border's, with no-flux walls that of the mirror image. NaN for a position that is not finite.
    pub fn diffusivity_at(&self, x: [T; 2]) -> T {
        if !x.iter().all(|v| v.is_finite()) {
            return T::NAN;
        }
        let Self { grid: Grid { mesh, equation, locator, .. }, diffusivity, .. } = self;
        if equation.walls != Walls::NoFlux && !mesh.contains(x) {
            return diffusivity.first().copied().unwrap_or(T::NAN);
        }
        bilinear(mesh, locator, diffusivity, mesh.reflect(x).0)
    }

    /// The smallest G: where the logarithm is strongest.
    pub fn least_diffusivity(&self) -> T {
        self.least
    }

    /// gamma = 1 / (2 pi G) at `x`, NaN if that is not finite: V is `gamma log r` near the place, and the index (4.30) of particles there has this gamma
    /// (`pks::theory::Constants`; a step with `pks::Attraction::Medium` sees to it by itself).
    pub fn gamma_at(&self, x: [T; 2]) -> T {
        T::ONE / (T::TWO * T::PI * self.diffusivity_at(x))
    }
}

/// A number between those at the nodes.
fn bilinear<T: Real>(mesh: &Mesh<T>, locator: &Locator, values: &[T], x: [T; 2]) -> T {
    let (node, fraction) = locator.place(x);
    if node == OUTSIDE {
        return T::NAN;
    }
    let [fx, fy] = fraction.map(T::from_f64);
    let two = |at: usize| values.get(at..).and_then(|v| v.first_chunk::<2>()).copied().present_or_default();
    let ([a, b], [c, d]) = (two(node as usize), two(node as usize + mesh.cells()[0] + 1));
    let (low, high) = (a + fx * (b - a), c + fx * (d - c));
    low + fy * (high - low)
}

//! The few heavy particles beside a mesh: their attraction is summed pair by pair, not interpolated.
//!
//! On a mesh a particle is spread over four nodes, so within a few mesh widths of it the interpolated attraction has a relative error of order one. Particle-particle
//! particle-mesh methods (Hockney & Eastwood, *Computer Simulation Using Particles*, 1988, chapter 8) subtract the smoothed force of near pairs and
//! add the true one. Here the pairs that matter have a heavy partner, and there are few heavy particles. So their smooth part is left off the mesh: they are
//! removed from the density exactly, every other particle gets their exact force at every distance, and they get the opposite force. These
//! pairs carry no error of the mesh.
//!
//! A light particle may fall all the way to a heavy one within a step, in sub-steps of its own, while the heavy one is held at its place at the start of the step. The
//! heavy one is therefore driven by the mean force of that fall: r^2 decreases by q = 2 chi m dt K'(r) / r of itself, and the factor's mean is
//! `(1 - sqrt(1 - q)) / (chi m dt)`, which is K'(r) / r for short steps. The centre of mass is kept except for noise.

use super::motion::{self, Moved, Moving};
use super::state::Options;
use crate::checked::Present;
use crate::error::{Error, Result};
use crate::exec::{Chunks, Resources, par_chunks};
use crate::field::{Interaction, Wanted};
use crate::grid::{Equation, Grid, Mesh, Walls};
use crate::mollifier::{Blob, Mollifier, Series};
use crate::random::Generator;
use crate::real::{Real, length};
use crate::simd::{Level, Loops, with_simd};

/// At most so many particles are heavy: those of the greatest masses, of equal ones the first.
pub const MAX_HEAVY: usize = 64;

/// One entry a heavy particle.
type List<X> = heapless::Vec<X, MAX_HEAVY>;

/// Particles of one task.
const PARTICLES: usize = 8192;

/// Pairs that are looked at together: few enough for the registers.
const WIDTH: usize = 8;

/// Heavy particles move in at least so many sub-steps.
const SUBSTEPS: u32 = 16;

/// Which particles act pair by pair beside a mesh, and how.
#[derive(Clone, Copy)]
pub struct Heavy<'a, T: Real> {
    /// V of the mesh's equation (with its sign and screening), mollified: see [`Heavy::softening`].
    pub kernel: &'a dyn Interaction<T, 2>,
    /// Particles of at least this mass; positive.
    pub mass: T,
    /// The kernel's delta, positive. With Euler-Maruyama sub-steps the expected jump of a light particle at distance r from a heavy one stays
    /// below a quarter of `max(core, r)`, that of heavy ones below a sixteenth of `max(core, their least distance at the start)`.
    pub core: T,
}

impl<T: Real> core::fmt::Debug for Heavy<'_, T> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Heavy").field("mass", &self.mass).field("core", &self.core).finish_non_exhaustive()
    }
}

impl<T: Real> Heavy<'_, T> {
    /// The Newtonian kernel softened over a quarter of the smaller mesh width: light particles see a point, sub-steps stay countable.
    ///
    /// # Errors
    /// None for a mesh that exists.
    pub fn softening(mesh: &Mesh<T>) -> Result<Blob<T, 2>> {
        let [h, k] = mesh.spacing();
        Blob::new(Mollifier::Compact { order: 2, exponent: 4 }, T::HALF * T::HALF * h.min(k))
    }

    /// Checks the numbers and what surrounds the mesh.
    ///
    /// # Errors
    /// [`Error::NotFinite`]; [`Error::OutOfDomain`]: the mass or the core is not positive. [`Error::Unsupported`]: walls, whose images
    /// a sum over pairs does not know, or a singular kernel, near which no sub-step is short enough.
    pub fn check(&self, equation: &Equation<T>) -> Result<()> {
        if !(self.mass.is_finite() && self.core.is_finite()) {
            return Err(Error::NotFinite);
        }
        if !(self.mass > T::ZERO && self.core > T::ZERO) {
            return Err(Error::OutOfDomain);
        }
        let refused = equation.walls == Walls::NoFlux || self.kernel.is_singular();
        if refused { Err(Error::Unsupported) } else { Ok(()) }
    }
}

/// The heavy particles of a moment, in the order of the array.
#[derive(Clone)]
pub struct HeavySet<'a, T: Real> {
    pull: Pull<'a, T>,
    core: T,
    indices: List<usize>,
    positions: List<[T; 2]>,
    masses: List<T>,
}

impl<'a, T: Real> HeavySet<'a, T> {
    /// The heavy ones of these particles; `None` without any.
    pub fn of(heavy: &Heavy<'a, T>, positions: &[[T; 2]], masses: &[T]) -> Option<Self> {
        let pull = Pull::new(heavy.kernel);
        let mut picked =
            Self { pull, core: heavy.core, indices: List::new(), positions: List::new(), masses: List::new() };
        for (index, (&m, &x)) in masses.iter().zip(positions).enumerate() {
            if m >= heavy.mass {
                picked.take(index, x, m);
            }
        }
        (!picked.masses.is_empty()).then_some(picked)
    }

    /// Inserts a particle; in a full list it replaces the lightest (of equals the last).
    fn take(&mut self, index: usize, x: [T; 2], m: T) {
        if self.masses.is_full() {
            let (mut lightest, mut at) = (T::INFINITY, 0);
            for (k, &mass) in self.masses.iter().enumerate() {
                if mass <= lightest {
                    (lightest, at) = (mass, k);
                }
            }
            if m <= lightest {
                return;
            }
            remove(&mut self.indices, at);
            remove(&mut self.positions, at);
            remove(&mut self.masses, at);
        }
        // There is room, in all three alike.
        let _ = (self.indices.push(index), self.positions.push(x), self.masses.push(m));
    }

    /// Their places among the particles, ascending.
    pub fn indices(&self) -> &[usize] {
        &self.indices
    }

    fn positions(&self) -> &[[T; 2]] {
        &self.positions
    }

    fn masses(&self) -> &[T] {
        &self.masses
    }

    /// Takes them out of the density of all particles.
    ///
    /// # Errors
    /// Those of [`Grid::remove`].
    pub fn remove_from(&self, grid: &mut Grid<'_, T>, resources: Resources<'_>) -> Result<()> {
        grid.remove(self.positions(), self.masses(), resources)
    }

    /// Adds the gradient of their potential to that at `points`, and lowers the longest jumps there. A heavy particle's own place gets
    /// nothing from itself.
    pub fn attract(&self, points: &[[T; 2]], slopes: &mut [[T; 2]], jumps: &mut [T], level: Level) {
        let (positions, masses) = (self.positions(), self.masses());
        with_simd(level, Attract { pull: &self.pull, core: self.core, positions, masses, points, slopes, jumps });
    }

    /// Overwrites the gradients at the heavy particles with that of the other particles, by pairs, in the mean over their infall if given
    /// chi and dt, and as they are if these are zero.
    ///
    /// # Errors
    /// The executor's.
    fn react(
        &self,
        (positions, masses): (&[[T; 2]], &[T]),
        [chi, dt]: [T; 2],
        slopes: &mut [[T; 2]],
        resources: Resources<'_>,
    ) -> Result<()> {
        let pull = &self.pull;
        par_chunks(resources.executor, self.masses.len(), Chunks::new(slopes, 1), (), &|task, slopes, ()| {
            let (&at, &mass) = (self.positions().get(task).present()?, self.masses().get(task).present()?);
            let slope = slopes.first_mut().present()?;
            // chi times the mass is in range where chi dt may not be; the scaling is exact.
            let (fraction, exponent) = mass.frexp();
            let infall_factor = T::TWO * chi.ldexp(exponent) * dt * fraction;
            *slope = [T::ZERO; 2];
            let mut from = 0;
            for until in self.indices().iter().copied().chain([positions.len()]) {
                let part = from..until;
                from = until + 1;
                let (positions, masses) = (positions.get(part.clone()).present()?, masses.get(part).present()?);
                let [x, y] = with_simd(resources.level, React { pull, at, infall_factor, positions, masses });
                *slope = [slope[0] + x, slope[1] + y];
            }
            Ok(())
        })
    }

    /// Overwrites `slopes` with the gradient at all of `particles`: that of the grid, which holds the others, and by pairs that of and at the heavy
    /// ones.
    ///
    /// # Errors
    /// The executor's.
    pub fn gradient(
        &self,
        grid: &Grid<'_, T>,
        (positions, masses): (&[[T; 2]], &[T]),
        slopes: &mut [[T; 2]],
        resources: Resources<'_>,
    ) -> Result<()> {
        let tasks = positions.len().div_ceil(PARTICLES);
        par_chunks(resources.executor, tasks, Chunks::new(slopes, PARTICLES), (), &|task, slopes, ()| {
            let points = positions.get(task * PARTICLES..).present()?;
            let points = points.get(..slopes.len()).present()?;
            grid.interpolate_here(points, slopes, resources.level);
            self.attract(points, slopes, &mut [], resources.level);
            Ok(())
        })?;
        let mut own = list_of(self.masses.len(), [T::ZERO; 2])?;
        self.react((positions, masses), [T::ZERO; 2], &mut own, resources)?;
        self.attract(self.positions(), &mut own, &mut [], resources.level);
        for (&index, own) in self.indices().iter().zip(&own) {
            slopes.get_mut(index).into_iter().for_each(|slope| *slope = *own);
        }
        Ok(())
    }

    /// Moves the heavy particles, with common sub-steps in which they see each other where they are, and the others where they were. The grid's
    /// gradient at a sub-step's place is corrected by what pairs and mesh differ at the start. Returns the sub-steps of all.
    ///
    /// # Errors
    /// As [`motion::together`].
    pub fn advance(
        &self,
        grid: &Grid<'_, T>,
        moving: &Moving<'_, T>,
        generator: &mut dyn Generator,
        moved: Moved<'_, T>,
        resources: Resources<'_>,
    ) -> Result<u64> {
        let n = self.masses.len();
        let (mut corrections, mut slopes) = (list_of(n, [T::ZERO; 2])?, list_of(n, [T::ZERO; 2])?);
        let (mut ends, mut jumps) = (list_of(n, [T::ZERO; 2])?, list_of(n, [T::ZERO; 2])?);
        let (mut labels, mut recorded) = (list_of(n, 0)?, list_of(n, 0)?);
        for ((&index, label), flag) in self.indices().iter().zip(&mut labels).zip(&mut recorded) {
            *label = moving.labels.get(index).copied().present()?;
            *flag = moving.recorded.get(index).copied().unwrap_or(0);
        }
        let infall = [moving.options.chi, moving.dt];
        self.react((moving.positions, moving.masses), infall, &mut corrections, resources)?;
        grid.interpolate_here(self.positions(), &mut slopes, resources.level);
        for (correction, mesh) in corrections.iter_mut().zip(&slopes) {
            *correction = [correction[0] - mesh[0], correction[1] - mesh[1]];
        }
        let part = Moving {
            positions: self.positions(),
            masses: self.masses(),
            weights: None,
            labels: &labels,
            recorded: &recorded,
            options: &self.options(moving.options),
            ..*moving
        };
        let mut there = self.clone();
        let mut sum = |points: &[[T; 2]], slopes: &mut [[T; 2]]| {
            grid.interpolate_here(points, slopes, resources.level);
            for (slope, correction) in slopes.iter_mut().zip(&corrections) {
                *slope = [slope[0] + correction[0], slope[1] + correction[1]];
            }
            there.positions.iter_mut().zip(points).for_each(|(to, x)| *to = *x);
            there.attract(points, slopes, &mut [], resources.level);
            Ok(())
        };
        let to = Moved { positions: &mut ends, increments: &mut jumps, substeps: &mut [] };
        let made = motion::together(&part, &mut sum, None, generator, to, &mut slopes)?;
        for ((&index, end), (jump, &flag)) in self.indices().iter().zip(&ends).zip(jumps.iter().zip(&recorded)) {
            moved.positions.get_mut(index).into_iter().for_each(|to| *to = *end);
            if flag != 0 {
                moved.increments.get_mut(index).into_iter().for_each(|to| *to = *jump);
            }
        }
        Ok(made * n as u64)
    }

    /// The options of their motion: Euler's error in the square of a distance is that of the jump, so sub-steps are short against the distances,
    /// which costs little for so few.
    fn options(&self, options: &Options<T>) -> Options<T> {
        let mut own = *options;
        let mut least = T::INFINITY;
        for (k, x) in self.positions().iter().enumerate() {
            for y in self.positions().iter().take(k) {
                let r = length(&[x[0] - y[0], x[1] - y[1]]);
                least = if r > T::ZERO { least.min(r) } else { least };
            }
        }
        let share = T::from_i32(SUBSTEPS as i32);
        own.control.width = own.control.width.min(least.max(self.core) / share);
        own.control.at_least = own.control.at_least.max(SUBSTEPS.min(own.control.at_most));
        own
    }
}

/// `n` times `value`.
fn list_of<X: Clone>(n: usize, value: X) -> Result<List<X>> {
    let mut list = List::new();
    list.resize(n, value).map_err(|_| Error::TooLarge)?;
    Ok(list)
}

/// Removes the element at `at`; the others keep their order.
fn remove<X: Copy>(list: &mut List<X>, at: usize) {
    let mut rest = list.iter_mut().skip(at).peekable();
    while let (Some(to), Some(next)) = (rest.next(), rest.peek()) {
        *to = **next;
    }
    list.pop();
}

/// The kernel, and what is known of it.
#[derive(Clone, Copy)]
struct Pull<'a, T: Real> {
    kernel: &'a dyn Interaction<T, 2>,
    newtonian: Option<Newtonian<T>>,
}

/// A Newtonian kernel under a compact mollifier.
#[derive(Clone, Copy)]
struct Newtonian<T> {
    /// The factor beyond delta, times r^2.
    strength: T,
    /// delta^2.
    edge: T,
    /// G(t), t = 1 - r^2 / delta^2.
    inside: Series<T>,
    /// What G is multiplied by.
    scale: T,
}

impl<T: Real> Newtonian<T> {
    #[inline(always)]
    fn is_beyond(&self, square: T) -> bool {
        (square >= self.edge) & (square > T::ZERO)
    }

    fn factor(&self, square: T) -> T {
        // Several at a time both are computed, so the divisor must not be zero inside either.
        let far = self.strength / square.max(self.edge);
        if self.is_beyond(square) { far } else { self.scale * self.inside.at(T::ONE - square / self.edge) }
    }
}

impl<'a, T: Real> Pull<'a, T> {
    fn new(kernel: &'a dyn Interaction<T, 2>) -> Self {
        let newtonian = kernel.newtonian().and_then(|(coefficient, blob)| {
            let polynomials = blob.polynomials()?;
            Some(Newtonian {
                strength: coefficient / (T::TWO * T::PI),
                edge: blob.delta() * blob.delta(),
                inside: polynomials.gradient,
                scale: coefficient * polynomials.scale,
            })
        });
        Self { kernel, newtonian }
    }

    /// K'(r) / r for these r^2.
    #[inline(always)]
    fn factors(&self, squares: &[T; WIDTH]) -> [T; WIDTH] {
        if let Some(newtonian) = &self.newtonian
            && squares.iter().fold(true, |all, &square| all & newtonian.is_beyond(square))
        {
            let mut factors = *squares;
            factors.iter_mut().for_each(|factor| *factor = newtonian.strength / *factor);
            return factors;
        }
        self.near(squares)
    }

    #[inline(never)]
    fn near(&self, squares: &[T; WIDTH]) -> [T; WIDTH] {
        let mut factors = *squares;
        if let Some(newtonian) = &self.newtonian {
            factors.iter_mut().for_each(|factor| *factor = newtonian.factor(*factor));
            return factors;
        }
        let wanted = Wanted { gradient: true, ..Wanted::default() };
        for factor in &mut factors {
            let [_, found, _] = self.kernel.pair(factor.sqrt(), wanted);
            *factor = found;
        }
        factors
    }
}

/// Calls the body for each [`WIDTH`] points, coordinate by coordinate, and where they begin; lanes beyond the last point repeat it.
#[inline(always)]
fn in_lanes<T: Real>(points: &[[T; 2]], mut body: impl FnMut(usize, &[[T; WIDTH]; 2])) {
    let (blocks, rest) = points.as_chunks::<WIDTH>();
    let mut from = 0;
    for block in blocks {
        body(from, &transposed(block));
        from += WIDTH;
    }
    if let Some(&last) = rest.last() {
        let mut block = [last; WIDTH];
        block.iter_mut().zip(rest).for_each(|(to, x)| *to = *x);
        body(from, &transposed(&block));
    }
}

#[inline(always)]
fn transposed<T: Real>(points: &[[T; 2]; WIDTH]) -> [[T; WIDTH]; 2] {
    let [mut x, mut y] = [[T::ZERO; WIDTH]; 2];
    for ((x, y), point) in x.iter_mut().zip(&mut y).zip(points) {
        [*x, *y] = *point;
    }
    [x, y]
}

/// Differences and their squares' sums.
#[inline(always)]
fn apart<T: Real>([x, y]: &[[T; WIDTH]; 2], from: [T; 2]) -> ([[T; WIDTH]; 2], [T; WIDTH]) {
    let (mut dx, mut dy, mut squares) = (*x, *y, [T::ZERO; WIDTH]);
    for ((dx, dy), square) in dx.iter_mut().zip(&mut dy).zip(&mut squares) {
        (*dx, *dy) = (*dx - from[0], *dy - from[1]);
        *square = *dx * *dx + *dy * *dy;
    }
    ([dx, dy], squares)
}

/// Adds the gradient of a few masses to that at many points.
struct Attract<'a, T: Real> {
    pull: &'a Pull<'a, T>,
    core: T,
    positions: &'a [[T; 2]],
    masses: &'a [T],
    points: &'a [[T; 2]],
    slopes: &'a mut [[T; 2]],
    /// Lowered; empty: not wanted.
    jumps: &'a mut [T],
}

impl<T: Real> Loops for Attract<'_, T> {
    type Out = ();

    #[inline(always)]
    fn run(self) {
        let Self { pull, core, positions, masses, points, slopes, jumps } = self;
        in_lanes(points, |at, here| {
            let (mut sums, mut nearest) = ([[T::ZERO; WIDTH]; 2], [T::INFINITY; WIDTH]);
            for (&from, &m) in positions.iter().zip(masses) {
                let (differences, squares) = apart(here, from);
                let factors = pull.factors(&squares);
                for (sum, difference) in sums.iter_mut().zip(&differences) {
                    for ((sum, &factor), &d) in sum.iter_mut().zip(&factors).zip(difference) {
                        *sum += m * factor * d;
                    }
                }
                for (nearest, &square) in nearest.iter_mut().zip(&squares) {
                    *nearest = if square < *nearest { square } else { *nearest };
                }
            }
            let [x, y] = &sums;
            for (slope, (&x, &y)) in slopes.iter_mut().skip(at).zip(x.iter().zip(y)) {
                *slope = [slope[0] + x, slope[1] + y];
            }
            let quarter = T::HALF * T::HALF;
            for (jump, &square) in jumps.iter_mut().skip(at).zip(&nearest) {
                *jump = jump.min(quarter * core.max(square.sqrt()));
            }
        });
    }
}

/// The gradient of many masses at one point.
struct React<'a, T: Real> {
    pull: &'a Pull<'a, T>,
    at: [T; 2],
    /// 2 chi m dt, or zero.
    infall_factor: T,
    positions: &'a [[T; 2]],
    masses: &'a [T],
}

impl<T: Real> Loops for React<'_, T> {
    type Out = [T; 2];

    #[inline(always)]
    fn run(self) -> [T; 2] {
        let Self { pull, at, infall_factor, positions, masses } = self;
        // Short sums are added up to long ones, so that errors grow slowly.
        const SHORT: usize = 128 * WIDTH;
        let mut total = [T::ZERO; 2];
        for (positions, masses) in positions.chunks(SHORT).zip(masses.chunks(SHORT)) {
            let mut sums = [[T::ZERO; WIDTH]; 2];
            in_lanes(positions, |from, here| {
                let (differences, squares) = apart(here, at);
                let mut factors = pull.factors(&squares);
                for factor in &mut factors {
                    // 2 f / (1 + sqrt(1 - q)) does not cancel.
                    let q = infall_factor * *factor;
                    *factor = T::TWO * *factor / (q.max(T::ONE) * (T::ONE + (T::ONE - q).max(T::ZERO).sqrt()));
                }
                // Lanes beyond the last have no mass.
                let mut m = [T::ZERO; WIDTH];
                m.iter_mut().zip(masses.iter().skip(from)).for_each(|(to, &m)| *to = m);
                for (sum, difference) in sums.iter_mut().zip(&differences) {
                    for (((sum, &factor), &d), &m) in sum.iter_mut().zip(&factors).zip(difference).zip(&m) {
                        *sum -= m * factor * d;
                    }
                }
            });
            for (total, sums) in total.iter_mut().zip(sums) {
                *total += sums.into_iter().fold(T::ZERO, |sum, v| sum + v);
            }
        }
        total
    }
}

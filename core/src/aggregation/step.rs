//! Definitions 2.2 and 2.3 in one call: k fixed steps of RK4 on the caller's buffers.
//!
//! Particles have mass and interact. Tracers are advected (the blob method "off the grid"). The right-hand
//! side is one call of [`field::evaluate`], for any kernel and any method:
//!
//! `x' = -grad u(x)`, `rho' = -(div v) rho = Laplacian(u) rho`, `u(x) = sum_j m_j K_delta(x - x_j)`.
//!
//! With [`Options::combination`] (a, b) in the plane, `x' = -(a + b J) grad u` and `rho' = a Laplacian(u) rho`. J turns by a right angle
//! counter-clockwise, and the turned gradient has no divergence. (1, 0), the default, is the aggregation equation. (0, -1) with an attractive Newtonian kernel and
//! circulations as masses is the vortex blob method for the Euler equations (Craig & Bertozzi (1.4)): `x' = J grad u`, counter-clockwise about a positive circulation.
//! What holds for masses m and K even:
//!
//! | quantity                   | (a, b)                                 | (0, b)   |
//! |----------------------------|----------------------------------------|----------|
//! | total mass, centre of mass | constant                               | constant |
//! | energy (2.4)               | rate `-a sum_i m_i \|grad u(x_i)\|^2`   | constant |
//! | `sum_i m_i \|x_i\|^2`       | rate `-a sum_ij m_i m_j r K_delta'(r)` | constant |
//! | density along trajectories | rate `a Laplacian(u) rho`              | constant |
//!
//! A run keeps the mass, the densities for a = 0 and, to the error of the sums, the centre. What else is constant it keeps to RK4's error of order dt^4.
//!
//! With [`Plan::with_diffusion`] particles and tracers have the velocity of [`Diffusion`] besides, and the energy its entropy.
//!
//! Without a mollifier the same call performs the particle method.

use super::diffusion::{Arrays as DiffusionArrays, Diffusion, Entropy, Planned};
use crate::build;
use crate::checked::Present;
use crate::diagnostics::moments;
use crate::diagnostics::sums::sum_of_products;
use crate::error::{Error, Result};
use crate::exec::Run;
use crate::field::{self, Interaction, Options, Outputs, Sources, Wanted as FieldWanted};
use crate::memory::{Carve, Measure, Space};
use crate::real::{Extended, Real, Scalar, length};
use crate::rk4::{self, Stage};

/// The quantities that a run computes besides positions. Others are not computed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Wanted {
    /// Advance densities along the trajectories: one Laplacian sum per evaluation.
    pub density: bool,
    /// The velocity at the end: one more evaluation after the last step.
    pub velocity: bool,
    /// The velocity's divergence at the end, at the same cost.
    pub divergence: bool,
    /// Monitor the regularised energy (2.4): one potential sum per step, and one after the last. A rise beyond rounding
    /// stops the run. The energy decreases if no mass is negative: its rate is `-a sum_i m_i |grad u(x_i)|^2`, with a = 1 or of
    /// [`Options::combination`]. For a <= 0 it is only reported, for masses of any sign: vortices (a = 0) keep it, up to the error of RK4. With [`Diffusion`] the entropy
    /// belongs to it, and a combination other than (1, 0) has it reported only.
    pub energy: bool,
}

/// The methods of a run, determined by [`plan()`] from sizes and options only.
#[derive(Clone, Debug)]
pub struct Plan {
    particles: usize,
    tracers: usize,
    total: usize,
    wanted: Wanted,
    /// The relative error allowed to the field sums; 0 means rounding alone.
    tolerance: f64,
    /// The share a of the gradient in the velocity ([`Options::combination`]): the rest, turned by a right angle, has no divergence and does no work.
    gradient_share: f64,
    /// Whether the velocity is that of a gradient flow, so that diffusion keeps the energy falling.
    whole_gradient: bool,
    diffusion: Option<Planned>,
    /// The field plan of k2 to k4.
    later: field::Plan,
    /// The field plans of k1, with the potential if the energy is monitored, and of the outputs at the end, if any; `None`: all are that of k2 to k4.
    ends: Option<(field::Plan, Option<field::Plan>)>,
}

/// Plans runs of `particles` massive particles and `tracers` massless ones.
///
/// # Errors
/// [`Error::TooLarge`]: a size overflows; [`Error::Unsupported`]: what [`build`] has not, tracers (zero masses are carried
/// along as well), the energy, and velocities and their divergence, which [`field::evaluate`] has; core radii and vector strengths; those of [`field::plan`],
/// such as an [`Options::combination`] other than (1, 0) on the line or in space.
pub fn plan<T: Real, const D: usize>(
    kernel: &dyn Interaction<T, D>,
    particles: usize,
    tracers: usize,
    wanted: Wanted,
    options: &Options,
) -> Result<Plan> {
    let Wanted { density, velocity, divergence, energy } = wanted;
    let at_end = velocity || divergence || energy;
    if (!build::BESIDES && at_end) || (!build::TRACERS && tracers > 0) {
        return Err(Error::Unsupported);
    }
    if options.radii || options.strengths {
        return Err(Error::Unsupported);
    }
    let total = particles.checked_add(tracers).ok_or(Error::TooLarge)?;
    let each = |potential, gradient, laplacian| {
        let outputs = FieldWanted { potential, gradient, laplacian, hessian: false };
        field::plan(kernel, particles, total, outputs, options)
    };
    Ok(Plan {
        particles,
        tracers,
        total,
        wanted,
        tolerance: options.tolerance,
        gradient_share: options.combination.0,
        whole_gradient: options.combination == (1.0, 0.0),
        diffusion: None,
        later: each(false, true, density)?,
        ends: if build::BESIDES {
            Some((each(energy, true, density)?, if at_end { Some(each(energy, velocity, divergence)?) } else { None }))
        } else {
            None
        },
    })
}

impl Plan {
    /// The same run with diffusion. Of `options` the accumulation and the tolerance are for its sums too, and a method if it is [`field::Method::Direct`].
    ///
    /// Masses must not be negative then. Each evaluation takes two more sums over the particles at all points, one for m = 2 ([`Diffusion`]).
    ///
    /// # Errors
    /// [`Error::NotFinite`], [`Error::OutOfDomain`]: exponent or coefficient; [`Error::SignChange`]; those of [`field::Density::new`] and [`field::plan`];
    /// [`Error::Unsupported`]: densities or divergences are wanted, which are those of the kernel's flow (the density of blobs is a sum of [`field::Density`]), or a build without [`build::BESIDES`].
    pub fn with_diffusion<T: Real, const D: usize>(self, diffusion: &Diffusion, options: &Options) -> Result<Self> {
        if !build::BESIDES {
            return Err(Error::Unsupported);
        }
        let planned = Planned::new::<T, D>(diffusion, [self.particles, self.total], self.wanted.energy, options)?;
        if planned.is_some() && (self.wanted.density || self.wanted.divergence) {
            return Err(Error::Unsupported);
        }
        Ok(Self { diffusion: planned, ..self })
    }

    /// How the densities of blobs and their gradients are summed; `None` without diffusion.
    #[must_use]
    pub fn diffusion_field(&self) -> Option<&field::Plan> {
        self.diffusion().map(Planned::field)
    }

    fn diffusion(&self) -> Option<&Planned> {
        self.diffusion.as_ref().filter(|_| build::BESIDES)
    }

    /// Bytes of workspace that [`step`] needs with an executor of `workers` workers.
    ///
    /// # Errors
    /// [`Error::TooLarge`].
    pub fn workspace_bytes<T: Real, const D: usize>(&self, workers: usize) -> Result<usize> {
        Measure::of(|space| Arrays::<T, D>::layout(space, self, workers).map(|_| ()))
    }

    /// How the velocity is evaluated: the method, the reason for it, and what it skips.
    #[must_use]
    pub fn field(&self) -> &field::Plan {
        &self.later
    }

    /// What the run computes.
    #[must_use]
    pub fn wanted(&self) -> Wanted {
        self.wanted
    }

    /// Whether the velocity lowers the energy.
    fn dissipates(&self) -> bool {
        if self.diffusion().is_some() { self.whole_gradient } else { self.gradient_share > 0.0 }
    }

    /// The plan of k1.
    fn first(&self) -> &field::Plan {
        self.ends.as_ref().filter(|_| build::BESIDES).map_or(&self.later, |(first, _)| first)
    }

    /// The plan of the outputs at the end.
    fn last(&self) -> Option<&field::Plan> {
        self.ends.as_ref().filter(|_| build::BESIDES).and_then(|(_, last)| last.as_ref())
    }

    fn field_bytes(&self, workers: usize) -> Result<usize> {
        let later = self.later.workspace_bytes(workers)?;
        if !build::BESIDES {
            return Ok(later);
        }
        let first = self.first().workspace_bytes(workers)?;
        let last = self.last().map_or(Ok(0), |plan| plan.workspace_bytes(workers))?;
        Ok(first.max(later).max(last))
    }
}

/// The workspace: the state as one flat slice (positions, then densities; particles before tracers), the scratch of the
/// stepper, one scalar per point for the energy and the outputs at the end, the scratch of the field, and that of diffusion.
struct Arrays<'w, T, const D: usize> {
    state: &'w mut [T],
    scratch: rk4::Scratch<'w, T>,
    potential: &'w mut [T],
    divergence: &'w mut [T],
    field: &'w mut [u8],
    diffusion: Option<DiffusionArrays<'w, T, D>>,
}

impl<'w, T: Real, const D: usize> Arrays<'w, T, D> {
    fn layout(space: &mut impl Space<'w>, plan: &Plan, workers: usize) -> Result<Self> {
        let each = D + usize::from(plan.wanted.density);
        let flat = plan.total.checked_mul(each).ok_or(Error::TooLarge)?;
        Ok(Self {
            state: space.try_array(flat)?,
            scratch: rk4::Scratch::layout(space, flat)?,
            potential: Self::maybe(space, plan.wanted.energy, plan.total)?,
            divergence: Self::maybe(space, plan.wanted.divergence, plan.total)?,
            field: space.try_array(plan.field_bytes(workers)?)?,
            diffusion: plan.diffusion().map(|plan| DiffusionArrays::layout(space, plan, workers)).transpose()?,
        })
    }

    /// An array that is empty unless wanted.
    fn maybe(space: &mut impl Space<'w>, wanted: bool, n: usize) -> Result<&'w mut [T]> {
        if build::BESIDES { space.try_array(if wanted { n } else { 0 }) } else { Ok(&mut []) }
    }
}

/// Points that follow the flow, with quantities along their trajectories.
#[derive(Debug)]
pub struct Trajectories<'a, T, const D: usize> {
    /// In length units; advanced in place.
    pub positions: &'a mut [[T; D]],
    /// Mass over volume; advanced in place. Must be present if and only if the plan includes densities.
    pub density: Option<&'a mut [T]>,
    /// Length over time, at the end of the run; overwritten.
    pub velocity: Option<&'a mut [[T; D]]>,
    /// One over time, at the end of the run; overwritten.
    pub divergence: Option<&'a mut [T]>,
}

impl<T, const D: usize> Trajectories<'_, T, D> {
    /// No points.
    #[must_use]
    pub fn none() -> Self {
        Self { positions: &mut [], density: None, velocity: None, divergence: None }
    }

    fn check(&self, n: usize, wanted: Wanted) -> Result<()> {
        let fits = |len: Option<usize>, allowed: bool| len.is_none_or(|len| allowed && len == n);
        let density = self.density.as_ref().map(|d| d.len());
        let velocity = self.velocity.as_ref().map(|v| v.len());
        let divergence = self.divergence.as_ref().map(|d| d.len());
        let complete = density.is_some() || !wanted.density || n == 0;
        let same = self.positions.len() == n
            && fits(density, wanted.density)
            && fits(velocity, wanted.velocity)
            && fits(divergence, wanted.divergence);
        if complete && same { Ok(()) } else { Err(Error::LengthMismatch) }
    }
}

/// The state of a run.
#[derive(Debug)]
pub struct State<'a, T, const D: usize> {
    /// Mass of each particle (density times h^d in the blob method), any sign; read-only.
    pub masses: &'a [T],
    /// The particles.
    pub particles: Trajectories<'a, T, D>,
    /// The tracers (Definition 2.3); may be empty.
    pub tracers: Trajectories<'a, T, D>,
}

/// The state passed to a callback between steps.
#[derive(Clone, Copy, Debug)]
pub struct Progress<'a, T, const D: usize> {
    /// Steps completed in this call.
    pub steps: usize,
    /// The particles' positions.
    pub positions: &'a [[T; D]],
    /// The particles' densities, if advanced.
    pub density: Option<&'a [T]>,
}

/// Called after each step; returning `false` stops the run.
pub type AfterStep<'a, T, const D: usize> = &'a mut dyn FnMut(Progress<'_, T, D>) -> bool;

/// The length of a run.
pub struct Advance<'a, T, const D: usize> {
    /// Length of a step; ignored if there are no steps.
    pub dt: T,
    /// Number of steps; 0 computes the outputs of the current state.
    pub steps: usize,
    /// Called after each step.
    pub after_step: Option<AfterStep<'a, T, D>>,
}

/// The report of a run, also of a failed one.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Report {
    /// Steps completed. The caller's buffers hold the state after them.
    pub steps: usize,
    /// With [`Error::NotFinite`]: the index of the first particle with a value that is not finite, tracers counted
    /// after the particles.
    pub first_bad: Option<usize>,
    /// The first and the last computed energy, if monitored.
    pub energy: Option<(f64, f64)>,
}

/// Advances the state by `advance.steps` steps and writes the requested outputs at the end.
///
/// The caller's buffers always hold the state after the last completed step, also during `after_step` and after an
/// error. Masses are not changed. Cost: four field evaluations a step, and one more if the plan has outputs at the end; with diffusion its sums besides, and those of a
/// Newtonian kernel with coefficient 0 are skipped.
/// Scratch: [`Plan::workspace_bytes`], undefined after the call. The bits are the same for any executor.
///
/// # Errors
/// Refused, with only `report` written: [`Error::LengthMismatch`], [`Error::TimeStep`], [`Error::NotFinite`],
/// [`Error::Mass`] (negative with diffusion, or while the energy is monitored and must fall), [`Error::WorkspaceTooSmall`], [`Error::Misaligned`]. Stopped, with the
/// state of the last completed step and no output written: [`Error::BecameNotFinite`] (the state, or an output at its end);
/// [`Error::Stopped`] by `after_step` or by `run.should_stop`;
/// [`Error::EnergyRose`], with the state after the step that raised it; the errors of [`field::evaluate`].
///
/// # Source
/// Craig & Bertozzi, Definitions 2.2 and 2.3, equation (2.4).
pub fn step<T: Real, const D: usize>(
    plan: &Plan,
    kernel: &dyn Interaction<T, D>,
    state: State<'_, T, D>,
    mut advance: Advance<'_, T, D>,
    workspace: &mut [u8],
    run: &mut Run<'_>,
    report: &mut Report,
) -> Result<()> {
    *report = Report::default();
    let State { masses, mut particles, mut tracers } = state;
    let mut wanted = plan.wanted;
    if build::BESIDES {
        tracers.check(plan.tracers, wanted)?;
    } else {
        // The plan has refused all other outputs.
        wanted = Wanted { density: wanted.density, ..Wanted::default() };
        (particles.velocity, particles.divergence) = (None, None);
        tracers = Trajectories::none();
    }
    particles.check(plan.particles, wanted)?;
    if masses.len() != plan.particles {
        return Err(Error::LengthMismatch);
    }
    if advance.steps > 0 && !(advance.dt.is_finite() && advance.dt > T::ZERO) {
        return Err(Error::TimeStep);
    }
    let mut arrays = Arrays::<T, D>::layout(&mut Carve::new(workspace)?, plan, run.executor.workers())?;
    report.first_bad = first_bad(masses, &particles, &tracers);
    if report.first_bad.is_some() {
        return Err(Error::NotFinite);
    }
    let positive = plan.diffusion().is_some() || (wanted.energy && plan.dissipates());
    if build::BESIDES && positive && masses.iter().any(|&m| m < T::ZERO) {
        return Err(Error::Mass);
    }
    let mut diffusion = Diffusing::new(plan, &mut arrays)?;
    let kernel = Forces { kernel, idle: diffusion.is_some() && has_no_force(kernel) };
    load::<T, D>(arrays.state, &particles, &tracers);

    let mut watch = Watch::new(plan, kernel.kernel, particles.positions, masses)?;
    let count = plan.particles;
    let share = if build::BESIDES { T::from_f64(plan.gradient_share) } else { T::ONE };
    while report.steps < advance.steps {
        let Arrays { state, scratch, potential, field: memory, .. } = &mut arrays;
        let result = rk4::step(state, scratch, advance.dt, |stage, y, dy| {
            let watched = build::BESIDES && wanted.energy && stage == Stage::First;
            let (points, densities) = split::<T, D>(y, plan.total)?;
            let (flow, growth) = split_mut::<T, D>(dy, plan.total)?;
            let outputs = Outputs {
                potential: if watched { Some(&mut **potential) } else { None },
                gradient: Some(&mut *flow),
                laplacian: if wanted.density { Some(&mut *growth) } else { None },
                hessian: None,
            };
            let sources = Sources::new(points.get(..count).unwrap_or(points), masses);
            let how = if stage == Stage::First { plan.first() } else { &plan.later };
            kernel.sums(how, sources, points, outputs, memory, run)?;
            flow.as_flattened_mut().iter_mut().for_each(|v| *v = -*v);
            let mut entropy = Entropy::default();
            if build::BESIDES
                && let Some(diffusion) = &mut diffusion
            {
                entropy = diffusion.add((points, masses), Some(flow), watched, run)?;
            }
            if watched {
                watch.record(masses, potential, entropy)?;
            }
            for (rate, &density) in growth.iter_mut().zip(densities) {
                *rate *= share * density;
            }
            Ok(())
        });
        if build::BESIDES {
            report.energy = watch.energies();
        }
        result.map_err(in_run)?;
        store::<T, D>(arrays.state, &mut particles, &mut tracers);
        report.steps += 1;
        if let Some(after_step) = &mut advance.after_step {
            let density = particles.density.as_deref();
            if !after_step(Progress { steps: report.steps, positions: particles.positions, density }) {
                return Err(Error::Stopped);
            }
        }
    }

    let Some(last) = plan.last() else { return Ok(()) };
    let Arrays { state, scratch, potential, divergence, field: memory, .. } = &mut arrays;
    let (points, _) = split::<T, D>(state, plan.total)?;
    let (flow, _) = split_mut::<T, D>(scratch.spare(), plan.total)?;
    let outputs = Outputs {
        potential: wanted.energy.then_some(&mut **potential),
        gradient: wanted.velocity.then_some(&mut *flow),
        laplacian: wanted.divergence.then_some(&mut **divergence),
        hessian: None,
    };
    let sources = Sources::new(points.get(..count).unwrap_or(points), masses);
    kernel.sums(last, sources, points, outputs, memory, run).map_err(in_run)?;
    let mut entropy = Entropy::default();
    if wanted.velocity {
        flow.as_flattened_mut().iter_mut().for_each(|v| *v = -*v);
    }
    if build::BESIDES
        && let Some(diffusion) = &mut diffusion
    {
        let velocity = wanted.velocity.then_some(&mut *flow);
        entropy = diffusion.add((points, masses), velocity, wanted.energy, run).map_err(in_run)?;
    }
    if build::BESIDES && wanted.energy {
        let outcome = watch.record(masses, potential, entropy);
        report.energy = watch.energies();
        outcome?;
    }
    // Velocities and divergences may overflow where positions do not.
    let finite = |wanted: bool, rates: &[T]| !wanted || rates.iter().all(|v| v.is_finite());
    if !(finite(wanted.velocity, flow.as_flattened()) && finite(wanted.divergence, divergence)) {
        return Err(Error::BecameNotFinite);
    }
    let (of_particles, of_tracers) = flow.split_at_checked(count).present()?;
    write(particles.velocity, of_particles, |v| v);
    write(tracers.velocity, of_tracers, |v| v);
    if wanted.divergence {
        let (of_particles, of_tracers) = divergence.split_at_checked(count).present()?;
        write(particles.divergence, of_particles, |c| -(share * c));
        write(tracers.divergence, of_tracers, |c| -(share * c));
    }
    Ok(())
}

fn write<V: Copy>(to: Option<&mut [V]>, from: &[V], what: impl Fn(V) -> V) {
    for (to, &from) in to.unwrap_or_default().iter_mut().zip(from) {
        *to = what(from);
    }
}

/// Whether every sum of the kernel is zero.
fn has_no_force<T: Real, const D: usize>(kernel: &dyn Interaction<T, D>) -> bool {
    kernel.newtonian().is_some_and(|(coefficient, _)| coefficient == T::ZERO)
}

/// The kernel's sums.
struct Forces<'a, T: Real, const D: usize> {
    kernel: &'a dyn Interaction<T, D>,
    /// All are zero, which takes no sum.
    idle: bool,
}

impl<T: Real, const D: usize> Forces<'_, T, D> {
    fn sums(
        &self,
        plan: &field::Plan,
        sources: Sources<'_, T, D>,
        points: &[[T; D]],
        outputs: Outputs<'_, T, D>,
        workspace: &mut [u8],
        run: &mut Run<'_>,
    ) -> Result<()> {
        if !build::BESIDES || !self.idle {
            return field::flow(plan, self.kernel, sources, points, outputs, workspace, run);
        }
        let Outputs { potential, gradient, laplacian, hessian: _ } = outputs;
        potential.unwrap_or_default().fill(T::ZERO);
        gradient.unwrap_or_default().fill([T::ZERO; D]);
        laplacian.unwrap_or_default().fill(T::ZERO);
        Ok(())
    }
}

/// A run's diffusion with its blobs and its workspace.
struct Diffusing<'a, 'w, T: Real, const D: usize> {
    planned: &'a Planned,
    kernel: field::Density<T, D>,
    arrays: DiffusionArrays<'w, T, D>,
}

impl<'a, 'w, T: Real, const D: usize> Diffusing<'a, 'w, T, D> {
    /// `None` without diffusion. Takes its part of the workspace.
    fn new(plan: &'a Plan, arrays: &mut Arrays<'w, T, D>) -> Result<Option<Self>> {
        let (Some(planned), Some(arrays)) = (plan.diffusion(), arrays.diffusion.take()) else { return Ok(None) };
        Ok(Some(Self { planned, kernel: planned.kernel()?, arrays }))
    }

    /// Adds to the velocity; returns the entropy if `watched`.
    fn add(
        &mut self,
        at: (&[[T; D]], &[T]),
        velocity: Option<&mut [[T; D]]>,
        watched: bool,
        run: &mut Run<'_>,
    ) -> Result<Entropy> {
        self.planned.evaluate(&self.kernel, at, velocity, watched, &mut self.arrays, run)
    }
}

/// The inputs were finite, so a value that is not finite arose during the run.
fn in_run(error: Error) -> Error {
    if error == Error::NotFinite { Error::BecameNotFinite } else { error }
}

/// Splits a flat state into positions and densities.
fn split<T: Real, const D: usize>(flat: &[T], total: usize) -> Result<(&[[T; D]], &[T])> {
    let (positions, densities) = flat.split_at_checked(total.saturating_mul(D)).present()?;
    Ok((positions.as_chunks().0, densities))
}

/// As [`split`], mutable.
fn split_mut<T: Real, const D: usize>(flat: &mut [T], total: usize) -> Result<(&mut [[T; D]], &mut [T])> {
    let (positions, densities) = flat.split_at_mut_checked(total.saturating_mul(D)).present()?;
    Ok((positions.as_chunks_mut().0, densities))
}

/// The index of the first particle, then tracer, with a value that is not finite.
fn first_bad<T: Real, const D: usize>(
    masses: &[T],
    particles: &Trajectories<'_, T, D>,
    tracers: &Trajectories<'_, T, D>,
) -> Option<usize> {
    let first = |points: &Trajectories<'_, T, D>, masses: &[T]| {
        let density = points.density.as_deref().unwrap_or_default();
        let finite = |value: Option<&T>| value.is_none_or(|v| v.is_finite());
        let whole = |(k, x): (usize, &[T; D])| {
            x.iter().all(|c| c.is_finite()) && finite(density.get(k)) && finite(masses.get(k))
        };
        points.positions.iter().enumerate().position(|point| !whole(point))
    };
    if !build::TRACERS {
        return first(particles, masses);
    }
    first(particles, masses).or_else(|| first(tracers, &[]).map(|k| masses.len().saturating_add(k)))
}

/// Copies the caller's state into the flat state.
fn load<T: Real, const D: usize>(flat: &mut [T], particles: &Trajectories<'_, T, D>, tracers: &Trajectories<'_, T, D>) {
    let mut to = flat.iter_mut();
    // `part` is the first operand of `zip`, so that its end consumes no element of `to`.
    let mut copy = |part: &[T]| part.iter().zip(to.by_ref()).for_each(|(&from, to)| *to = from);
    copy(particles.positions.as_flattened());
    if build::TRACERS {
        copy(tracers.positions.as_flattened());
    }
    copy(particles.density.as_deref().unwrap_or_default());
    if build::TRACERS {
        copy(tracers.density.as_deref().unwrap_or_default());
    }
}

/// Copies the flat state back into the caller's state.
fn store<T: Real, const D: usize>(
    flat: &[T],
    particles: &mut Trajectories<'_, T, D>,
    tracers: &mut Trajectories<'_, T, D>,
) {
    let mut from = flat.iter();
    let Trajectories { positions: x, density: rho, .. } = particles;
    let Trajectories { positions: x_tracers, density: rho_tracers, .. } = tracers;
    let mut copy = |part: &mut [T]| part.iter_mut().zip(from.by_ref()).for_each(|(to, &from)| *to = from);
    copy(x.as_flattened_mut());
    if build::TRACERS {
        copy(x_tracers.as_flattened_mut());
    }
    copy(rho.as_deref_mut().unwrap_or_default());
    if build::TRACERS {
        copy(rho_tracers.as_deref_mut().unwrap_or_default());
    }
}

/// Monitors the energy of a run, with a tolerance for rounding.
struct Watch {
    /// The rise that is allowed from one step to the next: infinite if the velocity does not lower the energy.
    tolerance: f64,
    /// The same of the entropy for a sensitivity of 1.
    relative: f64,
    first: Option<f64>,
    last: f64,
}

impl Watch {
    /// The rounding error of the energy is that of the potentials: c u sqrt(n) sum_i |m_i| sum_j |m_j| |K_ij|, except in
    /// contrived cases, with the field's tolerance in place of c u sqrt(n) if that is larger. |K_ij| is replaced by its largest value
    /// at a few distances up to the diameter of the set, and up to twice that to allow for growth.
    fn new<T: Real, const D: usize>(
        plan: &Plan,
        kernel: &dyn Interaction<T, D>,
        positions: &[[T; D]],
        masses: &[T],
    ) -> Result<Self> {
        let mut watch = Self { tolerance: 0.0, relative: 0.0, first: None, last: 0.0 };
        if !build::BESIDES || !plan.wanted.energy {
            return Ok(watch);
        }
        if !plan.dissipates() {
            watch.tolerance = f64::INFINITY;
            return Ok(watch);
        }
        let moments = moments(positions, masses)?;
        let from_centre = |x: &[T; D]| {
            let mut apart = *x;
            apart.iter_mut().zip(&moments.centre).for_each(|(a, &c)| *a -= c);
            length(&apart)
        };
        let radius = positions.iter().map(from_centre).fold(T::ZERO, Scalar::max).to_f64();
        let at = |factor: f64| kernel.value(T::from_f64(factor * radius)).to_f64().abs();
        let scale = [0.0, 0.01, 0.1, 0.5, 1.0, 2.0, 4.0].into_iter().map(at).fold(0.0, f64::max);
        let roundings = 8.0 + 2.0 * f64::from_usize(masses.len()).sqrt();
        let relative = (roundings * T::EPSILON.to_f64()).max(2.0 * plan.tolerance);
        watch.relative = 2.0 * relative;
        watch.tolerance = relative * scale * Scalar::powi(moments.absolute_mass.to_f64(), 2);
        Ok(watch)
    }

    /// Computes the energy (2.4) from the potentials, and adds the entropy. Returns an error if it exceeds the last one by more than rounding or is not finite.
    fn record<T: Real>(&mut self, masses: &[T], potential: &[T], entropy: Entropy) -> Result<()> {
        let energy = energy_of(masses, potential) + entropy.value;
        let rose = self.first.is_some() && energy > self.last + self.tolerance + self.relative * entropy.sensitivity;
        self.first.get_or_insert(energy);
        self.last = energy;
        if !energy.is_finite() {
            return Err(Error::BecameNotFinite);
        }
        if rose { Err(Error::EnergyRose) } else { Ok(()) }
    }

    fn energies(&self) -> Option<(f64, f64)> {
        self.first.map(|first| (first, self.last))
    }
}

/// `(1/2) sum_i m_i u(x_i)`: the regularised energy (2.4) of the particle measure, from the potentials at the particles.
///
/// Each term has one rounding. The sum is compensated, in double precision. It is infinite only if the energy is out of range.
#[must_use]
pub fn energy_of<T: Real>(masses: &[T], potential: &[T]) -> f64 {
    let pairs = masses.iter().zip(potential).map(|(m, u)| [m.to_f64(), u.to_f64()]);
    sum_of_products(pairs).times(Extended::new(0.5, 0)).get()
}

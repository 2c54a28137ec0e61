//! Degenerate diffusion by blobs (Carrillo, Craig & Patacchini): the gradient flow of an entropy of the density of blobs.
//!
//! With the blob function phi = psi_eps, `rho_i = sum_j m_j phi(x_i - x_j)` and the entropy `E = nu sum_i m_i f(rho_i)`,
//! `f(s) = log s` for m = 1 and `s^(m-1) / (m-1)` for m > 1, particles have the velocity
//!
//! `v_i = -(1 / m_i) dE/dx_i = -nu sum_j m_j (f'(rho_j) + f'(rho_i)) grad phi(x_i - x_j)`,
//!
//! and tracers that of the same formula at their place. As eps goes to 0 it becomes `rho_t = nu Laplacian(rho^m)`: the heat equation for m = 1, the porous medium equation for m > 1.
//!
//! Two sums of [`Density`]: one over the masses, of the gradient and, for f', of the density; one over `m_j f'(rho_j)`, of the gradient. For m = 2 f' is 1 everywhere, and the first sum's gradient
//! is all that is needed.

use crate::checked::Present;
use crate::diagnostics::sums::sum_of_products;
use crate::error::{Error, Result};
use crate::exec::Run;
use crate::field::{self, Density, Method, Options, Outputs, Sources, Wanted};
use crate::memory::Space;
use crate::mollifier::Mollifier;
use crate::real::{Real, Scalar};

/// Powers up to this are products, so that the density may be negative.
const MAX_WHOLE: f64 = 64.0;

/// Diffusion `rho_t = nu Laplacian(rho^m)` beside the kernel's forces.
///
/// ```
/// use mollis_core::aggregation::{self, Advance, Diffusion, Report, State, Trajectories, Wanted};
/// use mollis_core::exec::Run;
/// use mollis_core::field::Options;
/// use mollis_core::kernel::Kernel;
/// use mollis_core::memory::ALIGN;
/// use mollis_core::mollifier::Mollifier;
///
/// // The heat equation on the line: 200 particles sample a Gaussian of variance 1.
/// let h = 0.05;
/// let mut x: Vec<[f64; 1]> = (0..200).map(|k| [h * (f64::from(k) - 99.5)]).collect();
/// let mass: Vec<f64> = x.iter().map(|[x]| h * (-x * x / 2.0).exp() / std::f64::consts::TAU.sqrt()).collect();
/// let diffusion = Diffusion { exponent: 1.0, coefficient: 1.0, mollifier: Mollifier::Gaussian { order: 2 }, length: 3.0 * h };
///
/// // A kernel with coefficient 0: no forces, and no sum of them.
/// let kernel = Kernel::<f64, 1>::newtonian(0.0, Mollifier::None, 0.0)?;
/// let plan = aggregation::plan(&kernel, x.len(), 0, Wanted::default(), &Options::default())?;
/// let plan = plan.with_diffusion::<f64, 1>(&diffusion, &Options::default())?;
/// let bytes = plan.workspace_bytes::<f64, 1>(1)?;
/// let mut memory = vec![0; bytes + ALIGN];
/// let start = memory.as_ptr().align_offset(ALIGN);
/// let workspace = &mut memory[start..start + bytes];
///
/// let particles = Trajectories { positions: &mut x, ..Trajectories::none() };
/// let state = State { masses: &mass, particles, tracers: Trajectories::none() };
/// let advance = Advance { dt: 0.01, steps: 50, after_step: None };
/// aggregation::step(&plan, &kernel, state, advance, workspace, &mut Run::default(), &mut Report::default())?;
/// // The variance grows by 2 nu t.
/// let second: f64 = x.iter().zip(&mass).map(|([x], m)| m * x * x).sum();
/// assert!((second - 2.0).abs() < 0.01, "{second}");
/// # Ok::<(), mollis_core::Error>(())
/// ```
///
/// The blobs have to overlap: `length` is a few times the distance of neighbours, also where these have moved apart. Particles of equal mass are sparse where the density is low.
///
/// A Gaussian of order 2 is the usual choice. The Fourier transform of a compact polynomial changes sign, and waves of particles at which it is negative grow: particles of well overlapping blobs gather in
/// pairs. None do on a lattice of width h with `length < z h / (pi sqrt(d))`, z the first zero of the Bessel function of order M + d/2: 2.6 h on the line for M = 4, 4.4 h for M = 9.
///
/// The explicit step has to be shorter than about `0.8 w / (nu m p)`, with p the largest `rho^(m-1)`, and w = length^2 for a Gaussian of order 2, `2 length^2 / (2 M + d + 2)` for a compact one: the
/// fastest mode of uniform blobs decays at `nu p k^2 (2 phi^ + (m - 2) phi^^2)`, with phi^ the Fourier transform of phi. For m = 2 [`stable_step`](crate::diagnostics::stable_step) of the
/// [`Density`] with 2 nu times the masses is a bound. A run that monitors the energy stops where a step is too long.
///
/// Source: Carrillo, Craig, Patacchini, *A blob method for diffusion*, Calculus of Variations 58, 2019: the regularised entropies and their particle flow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Diffusion {
    /// m >= 1.
    pub exponent: f64,
    /// nu >= 0, in units of length^(2 + d (m-1)) over time and mass^(m-1); 0: no diffusion, and nothing of it is computed.
    pub coefficient: f64,
    /// phi, Gaussian or compact with M >= 2. For m = 1 and any m that is no whole number up to 64 it has to be positive: of order 2. A compact one serves m = 1 as well, because a particle lies within
    /// its own blob: `rho_i >= m_i phi(0)`.
    pub mollifier: Mollifier,
    /// eps, the length of phi.
    pub length: f64,
}

impl Diffusion {
    /// Whether it may be used in this dimension; the length is looked at by [`Density::new`].
    ///
    /// # Errors
    /// [`Error::NotFinite`]; [`Error::OutOfDomain`]: m < 1 or nu < 0; [`Error::SignChange`]: a mollifier that changes sign, where the density has to be positive.
    fn check(&self) -> Result<()> {
        if !(Scalar::is_finite(self.exponent) && Scalar::is_finite(self.coefficient)) {
            return Err(Error::NotFinite);
        }
        if self.exponent < 1.0 || self.coefficient < 0.0 {
            return Err(Error::OutOfDomain);
        }
        if self.mollifier.order() > 2 && !self.takes_any_sign() { Err(Error::SignChange) } else { Ok(()) }
    }

    /// Whether f is a polynomial.
    fn takes_any_sign(&self) -> bool {
        self.exponent > 1.0 && self.exponent <= MAX_WHOLE && Scalar::floor(self.exponent) == self.exponent
    }

    /// Whether f' is 1.
    fn is_quadratic(&self) -> bool {
        self.exponent == 2.0
    }

    /// s^power; 0 where it is not defined: far from all particles.
    fn power<T: Real>(&self, s: T, power: f64) -> T {
        if self.takes_any_sign() {
            s.powi(power as u32)
        } else if s > T::ZERO {
            s.pow(T::from_f64(power))
        } else {
            T::ZERO
        }
    }

    /// f'(s) = s^(m-2). For m = 1 zero below the range of normal numbers, where no blob of a particle with mass is near.
    fn slope<T: Real>(&self, s: T) -> T {
        match self.exponent {
            1.0 if s >= T::MIN_POSITIVE => T::ONE / s,
            1.0 => T::ZERO,
            m => self.power(s, m - 2.0),
        }
    }

    /// f(s).
    fn of_density(&self, s: f64) -> f64 {
        match self.exponent {
            1.0 if s > 0.0 => Scalar::log(s),
            1.0 => 0.0,
            m => self.power(s, m - 1.0) / (m - 1.0),
        }
    }

    /// |s f'(s)|: how much a relative error of the density changes f.
    fn sensitivity(&self, s: f64) -> f64 {
        if self.exponent == 1.0 { 1.0 } else { Scalar::abs(self.power(s, self.exponent - 1.0)) }
    }
}

/// The sums of a run's diffusion.
#[derive(Clone, Debug)]
pub(super) struct Planned {
    diffusion: Diffusion,
    sizes: [usize; 2],
    energy: bool,
    /// Over the masses.
    first: field::Plan,
    /// Over `m_j f'(rho_j)`; none for m = 2.
    second: Option<field::Plan>,
}

impl Planned {
    /// Of `particles` at all `points`; `None`: there is nothing to do.
    pub fn new<T: Real, const D: usize>(
        diffusion: &Diffusion,
        sizes @ [particles, points]: [usize; 2],
        energy: bool,
        options: &Options,
    ) -> Result<Option<Self>> {
        diffusion.check()?;
        let kernel = Self::kernel_of::<T, D>(diffusion)?;
        if diffusion.coefficient == 0.0 {
            return Ok(None);
        }
        // What the caller forces of the kernel's sums may not serve these.
        let method = options.method.filter(|&method| method == Method::Direct);
        let options =
            Options { accumulation: options.accumulation, tolerance: options.tolerance, method, ..Options::DEFAULT };
        let plan = |potential| {
            let wanted = Wanted { potential, gradient: true, ..Wanted::default() };
            field::plan(&kernel, particles, points, wanted, &options)
        };
        let second = if diffusion.is_quadratic() { None } else { Some(plan(false)?) };
        let first = plan(second.is_some() || energy)?;
        Ok(Some(Self { diffusion: *diffusion, sizes, energy, first, second }))
    }

    fn kernel_of<T: Real, const D: usize>(diffusion: &Diffusion) -> Result<Density<T, D>> {
        Density::new(diffusion.mollifier, T::from_f64(diffusion.length))
    }

    /// The blobs, for the scalar and dimension of the run.
    pub fn kernel<T: Real, const D: usize>(&self) -> Result<Density<T, D>> {
        Self::kernel_of(&self.diffusion)
    }

    /// How the first sum is evaluated.
    pub fn field(&self) -> &field::Plan {
        &self.first
    }

    fn field_bytes(&self, workers: usize) -> Result<usize> {
        let second = self.second.as_ref().map_or(Ok(0), |plan| plan.workspace_bytes(workers))?;
        Ok(self.first.workspace_bytes(workers)?.max(second))
    }
}

/// The workspace of diffusion.
pub(super) struct Arrays<'w, T, const D: usize> {
    density: &'w mut [T],
    weights: &'w mut [T],
    gradient: &'w mut [[T; D]],
    weighted: &'w mut [[T; D]],
    field: &'w mut [u8],
}

impl<'w, T: Real, const D: usize> Arrays<'w, T, D> {
    pub fn layout(space: &mut impl Space<'w>, plan: &Planned, workers: usize) -> Result<Self> {
        let [particles, points] = plan.sizes;
        let if_wanted = |wanted: bool, n: usize| if wanted { n } else { 0 };
        let two = plan.second.is_some();
        Ok(Self {
            density: space.try_array(if_wanted(two || plan.energy, points))?,
            weights: space.try_array(if_wanted(two, particles))?,
            gradient: space.try_array(points)?,
            weighted: space.try_array(if_wanted(two, points))?,
            field: space.try_array(plan.field_bytes(workers)?)?,
        })
    }
}

/// The entropy, and by how much it may be wrong for each unit of the densities' relative error.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Entropy {
    pub value: f64,
    pub sensitivity: f64,
}

impl Planned {
    /// Adds the velocity at `points`, of which the first are the particles, to `velocity`, if there is one. Returns the entropy if `watched`.
    pub fn evaluate<T: Real, const D: usize>(
        &self,
        kernel: &Density<T, D>,
        (points, masses): (&[[T; D]], &[T]),
        velocity: Option<&mut [[T; D]]>,
        watched: bool,
        arrays: &mut Arrays<'_, T, D>,
        run: &mut Run<'_>,
    ) -> Result<Entropy> {
        let Arrays { density, weights, gradient, weighted, field: memory } = arrays;
        let particles = points.get(..masses.len()).present()?;
        let moves = velocity.is_some();
        let both = self.second.as_ref().filter(|_| moves);
        let outputs = Outputs {
            potential: if watched || both.is_some() { Some(&mut **density) } else { None },
            gradient: if moves { Some(&mut **gradient) } else { None },
            ..Outputs::default()
        };
        field::evaluate(&self.first, kernel, Sources::new(particles, masses), points, outputs, memory, run)?;
        if let Some(second) = both {
            for ((weight, &m), &rho) in weights.iter_mut().zip(masses).zip(density.iter()) {
                *weight = if m == T::ZERO { T::ZERO } else { m * self.diffusion.slope(rho) };
            }
            let outputs = Outputs { gradient: Some(&mut **weighted), ..Outputs::default() };
            field::evaluate(second, kernel, Sources::new(particles, weights), points, outputs, memory, run)?;
        }
        self.add(velocity.unwrap_or_default(), gradient, both.map(|_| (&**density, &**weighted)));
        Ok(if watched { self.entropy(masses, density) } else { Entropy::default() })
    }

    /// Adds `-nu (B + f'(rho) A)` to the velocities, A the gradient over the masses and B that over the weights; `-2 nu A` where the latter is not there.
    fn add<T: Real, const D: usize>(
        &self,
        velocity: &mut [[T; D]],
        gradient: &[[T; D]],
        second: Option<(&[T], &[[T; D]])>,
    ) {
        let nu = T::from_f64(self.diffusion.coefficient);
        let Some((density, weighted)) = second else {
            let factor = -(T::TWO * nu);
            let to = velocity.as_flattened_mut().iter_mut().zip(gradient.as_flattened());
            to.for_each(|(v, &a)| *v += factor * a);
            return;
        };
        for (((v, a), b), &rho) in velocity.iter_mut().zip(gradient).zip(weighted).zip(density) {
            let slope = self.diffusion.slope(rho);
            v.iter_mut().zip(a).zip(b).for_each(|((v, &a), &b)| *v += -(nu * (b + slope * a)));
        }
    }

    /// `nu sum_i m_i f(rho_i)`.
    fn entropy<T: Real>(&self, masses: &[T], density: &[T]) -> Entropy {
        let nu = self.diffusion.coefficient;
        let particles = || masses.iter().zip(density).filter(|(m, _)| **m != T::ZERO);
        let terms = particles().map(|(m, rho)| [m.to_f64(), self.diffusion.of_density(rho.to_f64())]);
        let sensitivity =
            particles().map(|(m, rho)| m.to_f64() * self.diffusion.sensitivity(rho.to_f64())).sum::<f64>();
        Entropy { value: nu * sum_of_products(terms).get(), sensitivity: nu * sensitivity }
    }
}

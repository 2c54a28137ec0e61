//! What a sum is of: the kernel, the sources, the outputs.

use crate::kernel::Kernel;
use crate::mollifier::{Blob, Mollifier};
use crate::real::Real;

/// What a sum asks of its kernel.
pub trait Interaction<T: Real, const D: usize>: Sync {
    /// K_delta(r).
    fn value(&self, r: T) -> T;
    /// K_delta'(r) / r, so that the gradient is this times x.
    fn gradient_factor(&self, r: T) -> T;
    /// The Laplacian of K_delta at distance r.
    fn laplacian(&self, r: T) -> T;
    /// The coefficient and the blob, where the kernel is Newtonian: such sums have a loop of their own.
    fn newtonian(&self) -> Option<(T, &Blob<T, D>)> {
        None
    }
    /// The blob, where the kernel is the mollifier itself ([`super::Density`]).
    fn density(&self) -> Option<&Blob<T, D>> {
        None
    }
    /// The kernel as a sum of built-in terms, if it is one: some of these have faster methods.
    fn sum(&self) -> Option<&Kernel<'_, T, D>> {
        None
    }
    /// Value, gradient factor and Laplacian for a pair at distance r; what is not wanted may be anything.
    fn pair(&self, r: T, wanted: Wanted) -> [T; 3] {
        [
            if wanted.potential { self.value(r) } else { T::ZERO },
            if wanted.gradient { self.gradient_factor(r) } else { T::ZERO },
            if wanted.laplacian { self.laplacian(r) } else { T::ZERO },
        ]
    }
    /// [`Interaction::pair`] in double precision, for kernels whose values leave the range of single precision.
    fn pair_wide(&self, r: f64, wanted: Wanted) -> [f64; 3] {
        self.pair(T::from_f64(r), wanted).map(T::to_f64)
    }
    /// Whether the kernel has no mollifier, so that coincident pairs contribute nothing.
    fn is_singular(&self) -> bool;
}

/// The Newtonian kernel with coefficient 1.
impl<T: Real, const D: usize> Interaction<T, D> for Blob<T, D> {
    fn value(&self, r: T) -> T {
        self.potential(r)
    }
    fn gradient_factor(&self, r: T) -> T {
        Blob::gradient_factor(self, r)
    }
    fn laplacian(&self, r: T) -> T {
        self.density(r)
    }
    fn newtonian(&self) -> Option<(T, &Blob<T, D>)> {
        Some((T::ONE, self))
    }
    fn is_singular(&self) -> bool {
        self.mollifier() == Mollifier::None
    }
}

/// The sources: positions `[n][D]`, masses `[n]` of any sign and, if given, core radii `[n]`. A mass is the density times the cell volume h^D.
#[derive(Clone, Copy, Debug)]
pub struct Sources<'a, T, const D: usize> {
    /// Where the sources are.
    pub positions: &'a [[T; D]],
    /// Their masses; those that are zero are dropped before the sum starts.
    pub masses: &'a [T],
    /// The core radius of each, positive: the mollifier's length in place of the kernel's delta. For Newtonian kernels with a mollifier: by the sum
    /// over all pairs, by the fast multipole methods, and by the tree. But for the plane, cells are no narrower than the largest core.
    pub radii: Option<&'a [T]>,
    /// The core radii of the targets `[n_targets]`, where a pair's radius depends on both ([`super::Options::pair_radius`]). Without them targets that are the sources have the sources'.
    pub target_radii: Option<&'a [T]>,
    /// Vector strengths in space, in place of masses, which are then empty: the gradient output is `sum_j grad K_delta(x_i - x_j) x strength_j`, a velocity by the law
    /// of Biot and Savart.
    pub strengths: Option<&'a [[T; D]]>,
}

impl<'a, T: Real, const D: usize> Sources<'a, T, D> {
    /// Sources under the kernel's own delta.
    #[must_use]
    pub fn new(positions: &'a [[T; D]], masses: &'a [T]) -> Self {
        Self { positions, masses, radii: None, target_radii: None, strengths: None }
    }

    /// Elements of vorticity in space: vectors instead of masses.
    #[must_use]
    pub fn vortices(positions: &'a [[T; D]], strengths: &'a [[T; D]]) -> Self {
        Self { positions, masses: &[], radii: None, target_radii: None, strengths: Some(strengths) }
    }

    /// The same sources, each with a core radius of its own.
    #[must_use]
    pub fn with_radii(self, radii: &'a [T]) -> Self {
        Self { radii: Some(radii), ..self }
    }

    /// The same, with core radii of the targets.
    #[must_use]
    pub fn with_target_radii(self, radii: &'a [T]) -> Self {
        Self { target_radii: Some(radii), ..self }
    }

    /// The largest core radius of sources and targets; 0 without any.
    pub(super) fn largest_radius(self) -> T {
        let radii = self.radii.unwrap_or_default().iter().chain(self.target_radii.unwrap_or_default());
        radii.fold(T::ZERO, |most, &r| if r > most { r } else { most })
    }

    /// The largest coordinate and the largest mass of every `stride`-th source.
    pub(super) fn largest(self, stride: usize) -> [T; 2] {
        let larger = |most: T, x: T| if x.abs() > most { x.abs() } else { most };
        let coordinates = self.positions.iter().step_by(stride).flatten();
        let masses = self.masses.iter().step_by(stride);
        let masses = masses.chain(self.strengths.unwrap_or_default().as_flattened());
        [coordinates.fold(T::ZERO, |most, &x| larger(most, x)), masses.fold(T::ZERO, |most, &m| larger(most, m))]
    }
}

/// Where results go, each `[n_targets]`. All are overwritten; `None` is not computed.
#[derive(Debug)]
pub struct Outputs<'a, T, const D: usize> {
    /// `sum_j m_j K_delta(x_i - x_j)`.
    pub potential: Option<&'a mut [T]>,
    /// `sum_j m_j grad K_delta(x_i - x_j)`, or what [`super::Options::combination`] makes of it.
    pub gradient: Option<&'a mut [[T; D]]>,
    /// `sum_j m_j Laplacian K_delta(x_i - x_j)`.
    pub laplacian: Option<&'a mut [T]>,
    /// `sum_j m_j Hess K_delta(x_i - x_j)`, symmetric matrices of second derivatives: the tidal field, or, times -1, the velocity's gradient of the blob method. Not combined.
    pub hessian: Option<&'a mut [[[T; D]; D]]>,
}

impl<T, const D: usize> Default for Outputs<'_, T, D> {
    fn default() -> Self {
        Self { potential: None, gradient: None, laplacian: None, hessian: None }
    }
}

impl<T, const D: usize> Outputs<'_, T, D> {
    /// Which outputs are there.
    #[must_use]
    pub fn wanted(&self) -> Wanted {
        Wanted {
            potential: self.potential.is_some(),
            gradient: self.gradient.is_some(),
            laplacian: self.laplacian.is_some(),
            hessian: self.hessian.is_some(),
        }
    }

    /// Whether every output there has this length.
    pub(super) fn have_length(&self, n: usize) -> bool {
        self.potential.as_ref().is_none_or(|p| p.len() == n)
            && self.gradient.as_ref().is_none_or(|g| g.len() == n)
            && self.laplacian.as_ref().is_none_or(|l| l.len() == n)
            && self.hessian.as_ref().is_none_or(|h| h.len() == n)
    }
}

/// Which outputs a plan is for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Wanted {
    /// The potential.
    pub potential: bool,
    /// The gradient.
    pub gradient: bool,
    /// The Laplacian.
    pub laplacian: bool,
    /// The second derivatives.
    pub hessian: bool,
}

impl Wanted {
    /// The same, where on the line the second derivative is the Laplacian.
    pub(super) fn in_dimension(self, dimension: usize) -> Self {
        if dimension == 1 && self.hessian { Self { laplacian: true, hessian: false, ..self } } else { self }
    }
}

/// The origin of a source that stands for several ([`super::essential`]).
pub const PROXY: u64 = u64::MAX;

/// Where essential sources go ([`super::essential`]), for all boxes one after the other.
#[derive(Debug)]
pub struct Essential<'a, T, const D: usize> {
    /// Where they are.
    pub positions: &'a mut [[T; D]],
    /// Their masses.
    pub masses: &'a mut [T],
    /// Which of the sources each is, or [`PROXY`].
    pub origins: Option<&'a mut [u64]>,
}

//! The mollifier itself as a kernel: the density of blobs and its gradient.

use super::problem::{Interaction, Wanted};
use crate::error::{Error, Result};
use crate::mollifier::{Blob, Mollifier, Polynomials, gaussian_weights};
use crate::real::{Real, Scalar};

/// The kernel psi_delta: a sum's potential is the density `sum_j m_j psi_delta(x - x_j)` of blobs, its gradient that density's.
///
/// ```
/// use mollis_core::exec::Run;
/// use mollis_core::field::{self, Density, Method, Options, Outputs, Sources, Wanted};
/// use mollis_core::memory::ALIGN;
/// use mollis_core::mollifier::Mollifier;
///
/// // Particles of mass h on the line, one each h: of density 1 but near the ends.
/// let h = 0.01;
/// let x: Vec<[f64; 1]> = (0..1000).map(|k| [h * f64::from(k)]).collect();
/// let kernel = Density::<f64, 1>::new(Mollifier::Compact { order: 2, exponent: 4 }, 0.1)?;
/// let wanted = Wanted { potential: true, ..Wanted::default() };
/// let plan = field::plan(&kernel, x.len(), x.len(), wanted, &Options::default())?;
/// assert_eq!(plan.method(), Method::Neighbours);
///
/// let bytes = plan.workspace_bytes(1)?;
/// let mut memory = vec![0; bytes + ALIGN];
/// let start = memory.as_ptr().align_offset(ALIGN);
/// let (mass, mut density) = (vec![h; x.len()], vec![0.0; x.len()]);
/// let outputs = Outputs { potential: Some(&mut density), ..Outputs::default() };
/// let sources = Sources::new(&x, &mass);
/// field::evaluate(&plan, &kernel, sources, &x, outputs, &mut memory[start..start + bytes], &mut Run::default())?;
/// assert!((density[500] - 1.0).abs() < 1e-5);
/// # Ok::<(), mollis_core::Error>(())
/// ```
///
/// | function | value | unit |
/// |---|---|---|
/// | value | psi_delta(r) | length^-D |
/// | gradient factor | psi_delta'(r) / r | length^-(D+2) |
/// | Laplacian | Laplacian(psi_delta)(r) | length^-(D+2) |
///
/// Sums are over near pairs ([`super::Method::Neighbours`]): a time proportional to n. A Gaussian ends there at 6.3 times its width (f32: 4.5), below e^-40 (e^-20) of its largest value. Where a
/// Laplacian is wanted, second derivatives or a combination of the gradient, all pairs are summed by a function that is called, which is slow.
///
/// Accuracy of the three functions: some roundings of `psi_delta(0)`, `psi_delta(0) / delta^2`. They are computed in double precision, where those two have to be in range.
///
/// Source: Carrillo, Craig, Patacchini, *A blob method for diffusion*, Calculus of Variations 58, 2019.
#[derive(Clone, Copy, Debug)]
pub struct Density<T: Real, const D: usize> {
    blob: Blob<T, D>,
    shape: Shape,
}

#[derive(Clone, Copy, Debug)]
#[allow(clippy::large_enum_variant, reason = "there is one, on the stack of a run")]
enum Shape {
    Compact(Polynomials<f64>),
    /// Amplitude and width squared of each.
    Gaussian([(f64, f64); 3]),
}

impl<T: Real, const D: usize> Density<T, D> {
    /// Prepares the kernel.
    ///
    /// # Errors
    /// Those of [`Blob::new`]; [`Error::Exponent`]: a compact mollifier with M = 1, whose gradient jumps at its edge; [`Error::Unsupported`]: no mollifier, an algebraic
    /// one or a combination; [`Error::Delta`]: psi_delta(0) or its quotient by delta^2 is out of the range of double precision.
    pub fn new(mollifier: Mollifier, delta: T) -> Result<Self> {
        let blob = Blob::new(mollifier, delta)?;
        let length = delta.to_f64();
        let shape = match mollifier {
            Mollifier::Compact { exponent: 1, .. } => return Err(Error::Exponent),
            Mollifier::Compact { .. } => {
                let polynomials = Blob::<f64, D>::new(mollifier, length)?.polynomials();
                Shape::Compact(polynomials.ok_or(Error::Unsupported)?)
            }
            Mollifier::Gaussian { order } => Shape::Gaussian(gaussian_weights(D, order).map(|(weight, square)| {
                let width = square.sqrt() * length;
                let per_width = 1.0 / (core::f64::consts::PI.sqrt() * width);
                (weight * Scalar::powi(per_width, D as u32), width * width)
            })),
            _ => return Err(Error::Unsupported),
        };
        let kernel = Self { blob, shape };
        let [value, factor, _] = kernel.at(0.0);
        let in_range = |x: f64| x.is_normal();
        if in_range(value) && in_range(factor) { Ok(kernel) } else { Err(Error::Delta) }
    }

    /// The mollifier with its length.
    #[must_use]
    pub fn blob(&self) -> &Blob<T, D> {
        &self.blob
    }

    /// psi, psi' / r and Laplacian(psi) at a distance.
    fn at(&self, r: f64) -> [f64; 3] {
        let d = D as f64;
        match &self.shape {
            Shape::Compact(p) if r < p.delta => {
                let s = (r / p.delta) * (r / p.delta);
                let t = 1.0 - s;
                let (slope, change) = with_derivative(p.density_slope.coefficients(), t);
                let factor = p.hessian_scale * slope;
                [p.scale * p.density.at(t), factor, d * factor - 2.0 * s * (p.hessian_scale * change)]
            }
            Shape::Compact(_) => [0.0; 3],
            Shape::Gaussian(parts) => {
                parts.iter().fold([0.0; 3], |[value, factor, laplacian], &(amplitude, square)| {
                    let xi = r / square * r;
                    // Of an unused part the amplitude is zero.
                    let part = amplitude * Scalar::exp(-xi);
                    let slope = -2.0 / square * part;
                    [value + part, factor + slope, laplacian + slope * (d - 2.0 * xi)]
                })
            }
        }
    }
}

/// A polynomial's value and derivative, by Horner's rule.
fn with_derivative(coefficients: &[f64], t: f64) -> (f64, f64) {
    coefficients.iter().rev().fold((0.0, 0.0), |(value, change), &c| (value * t + c, change * t + value))
}

impl<T: Real, const D: usize> Interaction<T, D> for Density<T, D> {
    fn value(&self, r: T) -> T {
        T::from_f64(self.at(r.to_f64())[0])
    }
    fn gradient_factor(&self, r: T) -> T {
        T::from_f64(self.at(r.to_f64())[1])
    }
    fn laplacian(&self, r: T) -> T {
        T::from_f64(self.at(r.to_f64())[2])
    }
    fn density(&self) -> Option<&Blob<T, D>> {
        Some(&self.blob)
    }
    fn pair_wide(&self, r: f64, _wanted: Wanted) -> [f64; 3] {
        self.at(r)
    }
    fn is_singular(&self) -> bool {
        false
    }
}

//! How a run of the blob method is done, and what it reports: plain structures.

use core::ffi::c_void;

use mollis_core::aggregation::Diffusion;
use mollis_core::build;
use mollis_core::field;
use mollis_core::{Error, Result, Scalar};

use crate::mollifier::{MOLLIS_MOLLIFIER_GAUSSIAN, mollis_mollifier};
use crate::options;
use crate::status::{mollis_status, status};

/// How a run of the blob method is done. Fill it with `mollis_blob_options_init`; null means the defaults.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct mollis_blob_options {
    /// Bytes of this structure, as `mollis_blob_options_init` sets it.
    pub size: u32,
    /// Nonzero: watch the regularised energy, and stop with `MOLLIS_ERR_ENERGY_ROSE` when it rises beyond rounding. Its rate is -a sum_i m_i
    /// |grad u(x_i)|^2, with a = 1 or of `combination`. So for a > 0 it falls if no mass is negative: one that is is refused with `MOLLIS_ERR_MASS`. For a <= 0 it is
    /// only reported, for masses of any sign; for a = 0 it is constant, up to the error of the steps. Default 0.
    pub watch_energy: i32,
    /// The relative error that field sums may spend for speed; 0 (the default) asks for rounding alone.
    pub tolerance: f64,
    /// Called after each step with the number of steps completed in this call and arrays without gaps (`double (*)[D]`
    /// or `float (*)[D]`; `density` is null if none is advanced), to be read through these pointers and not written.
    /// Nonzero stops the run with `MOLLIS_ERR_STOPPED`. May be null.
    pub after_step: Option<
        unsafe extern "C" fn(
            context: *mut c_void,
            steps: usize,
            positions: *const c_void,
            density: *const c_void,
        ) -> i32,
    >,
    /// Passed to `after_step`.
    pub context: *mut c_void,
    /// (a, b), in 2D: the velocity is -(a grad u + b (grad u rotated by +90 degrees)). The default (1, 0) is the aggregation equation. (0, -1) with a positive Newtonian
    /// kernel and circulations as masses is the vortex blob method: counter-clockwise about a positive circulation. (Sums return a grad u + b (...) without the minus sign, so
    /// there the velocity of vortices is (0, 1).) Divergences and the rates of densities are a times those of (1, 0). In 1D and 3D, and in a library with the feature
    /// `small`, any other value is refused with `MOLLIS_ERR_UNSUPPORTED`; in 2D one that is not finite with `MOLLIS_ERR_NOT_FINITE`. Divide steps of `mollis_stable_step2` by
    /// 1.07 sqrt(a^2 + b^2).
    pub combination: [f64; 2],
    /// nu of the diffusion rho_t = nu Laplacian(rho^m) by blobs (Carrillo, Craig and Patacchini 2019), which is added to the velocity of particles and tracers:
    /// -nu sum_j m_j (f'(rho_j) + f'(rho(x))) grad phi(x - x_j), with the density of blobs rho(x) = sum_j m_j phi(x - x_j) and f'(s) = s^(m-2). The watched energy then has
    /// nu sum_i m_i f(rho_i) besides, and is only reported if `combination` is not (1, 0). Masses must not be negative (`MOLLIS_ERR_MASS`); densities and divergences are refused with
    /// `MOLLIS_ERR_UNSUPPORTED`, as is all diffusion in a library with the feature `small`. The default 0 is none. Not finite: `MOLLIS_ERR_NOT_FINITE`; negative:
    /// `MOLLIS_ERR_OUT_OF_DOMAIN`. The other three members are looked at only if it is not 0. The step has to be shorter than 0.8 w / (nu m p), with p the largest
    /// rho^(m-1), and w = diffusion_length^2 for a Gaussian of order 2, 2 diffusion_length^2 / (2 exponent + D + 2) for a compact one. A kernel of Newtonian terms whose coefficients add up to 0 takes no sum: diffusion alone.
    pub diffusion: f64,
    /// m >= 1, else `MOLLIS_ERR_OUT_OF_DOMAIN`: 1 is the heat equation, above 1 a porous medium. m = 2 takes one sum an evaluation, any other two. Default 1.
    pub diffusion_exponent: f64,
    /// phi: Gaussian, or compact of exponent 2 or more (`MOLLIS_ERR_EXPONENT`). An order above 2 changes sign and is refused with `MOLLIS_ERR_SIGN_CHANGE`, unless m is 2, 3, ... or 64. Default Gaussian of
    /// order 2. Sums of compact ones visit pairs closer than `diffusion_length` alone, but particles gather in pairs where that is several distances of neighbours (for exponent 4 on the line above 2.6, for
    /// 9 above 4.4).
    pub diffusion_mollifier: mollis_mollifier,
    /// The length of phi, some distances of neighbours. It has no default: `MOLLIS_ERR_DELTA`.
    pub diffusion_length: f64,
}

options::options!(mollis_blob_options {
    watch_energy: 0,
    tolerance: 0.0,
    after_step: None,
    context: core::ptr::null_mut(),
    combination: [1.0, 0.0],
    diffusion: 0.0,
    diffusion_exponent: 1.0,
    diffusion_mollifier: mollis_mollifier { kind: MOLLIS_MOLLIFIER_GAUSSIAN, order: 2, exponent: 0 },
    diffusion_length: 0.0
});

/// What a run says about itself. Written by every step that got as far as reading its arrays, also when it then refuses or
/// stops.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct mollis_blob_report {
    /// Steps completed in this call: the state in the arrays is the one after them.
    pub steps: u64,
    /// With `MOLLIS_ERR_NOT_FINITE`: the index of the first particle with a coordinate, mass or density that is not finite
    /// (tracers count after the particles); else `MOLLIS_NONE_BAD`.
    pub first_bad: u64,
    /// The regularised energy before the first step; NaN if not watched.
    pub energy_first: f64,
    /// The last energy computed; NaN if not watched.
    pub energy_last: f64,
}

/// Fills `options` with the defaults. `size` is `sizeof *options`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_blob_options_init(options: *mut mollis_blob_options, size: usize) -> mollis_status {
    // SAFETY: this function's own contract.
    status(unsafe { options::init(options, size) })
}

/// The options, checked.
pub(super) fn read_options(options: *const mollis_blob_options) -> Result<mollis_blob_options> {
    // SAFETY: the callers' contract.
    let options = unsafe { options::read(options) }?;
    if !Scalar::is_finite(options.tolerance) {
        return Err(Error::NotFinite);
    }
    if !build::BESIDES && options.combination.map(f64::to_bits) != [1.0_f64.to_bits(), 0] {
        return Err(Error::Unsupported);
    }
    if !build::BESIDES && options.diffusion.to_bits() != 0 {
        return Err(Error::Unsupported);
    }
    // By its bits, as a comparison of doubles is a function where there are none: negative and not -0.
    if options.tolerance.to_bits() > (-0.0_f64).to_bits() { Err(Error::OutOfDomain) } else { Ok(options) }
}

/// What the sums are told. In a build for firmware the combination is the default, which [`read_options`] has seen to.
pub(super) fn field_options(options: &mollis_blob_options) -> field::Options {
    let [a, b] = options.combination;
    let combination = if build::BESIDES { (a, b) } else { (1.0, 0.0) };
    field::Options { tolerance: options.tolerance, combination, ..field::Options::default() }
}

/// The diffusion that the options ask for.
pub(super) fn diffusion(options: &mollis_blob_options) -> Result<Option<Diffusion>> {
    if !build::BESIDES || options.diffusion == 0.0 {
        return Ok(None);
    }
    Ok(Some(Diffusion {
        exponent: options.diffusion_exponent,
        coefficient: options.diffusion,
        mollifier: options.diffusion_mollifier.to_core()?,
        length: options.diffusion_length,
    }))
}

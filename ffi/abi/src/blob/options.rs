//! How a run of the blob method is done, and what it reports: plain structures.

use core::ffi::c_void;

use mollis_core::build;
use mollis_core::field;
use mollis_core::{Error, Result, Scalar};

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
}

options::options!(mollis_blob_options {
    watch_energy: 0,
    tolerance: 0.0,
    after_step: None,
    context: core::ptr::null_mut(),
    combination: [1.0, 0.0]
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
    // By its bits, as a comparison of doubles is a function where there are none: negative and not -0.
    if options.tolerance.to_bits() > (-0.0_f64).to_bits() { Err(Error::OutOfDomain) } else { Ok(options) }
}

/// What the sums are told. In a build for firmware the combination is the default, which [`read_options`] has seen to.
pub(super) fn field_options(options: &mollis_blob_options) -> field::Options {
    let [a, b] = options.combination;
    let combination = if build::BESIDES { (a, b) } else { (1.0, 0.0) };
    field::Options { tolerance: options.tolerance, combination, ..field::Options::default() }
}

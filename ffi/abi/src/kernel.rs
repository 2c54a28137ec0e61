//! Kernel sums: prepare into a caller's buffer, evaluate at distances.

use core::cell::Cell;
use core::ffi::c_void;

use mollis_core::kernel::{Kernel, Law, MAX_KNOTS, MAX_TERMS, RadialKernel, Supplied, Term};
use mollis_core::memory::Plain;
use mollis_core::{Error, Real, Result};

use crate::buffers::{Input, Output, block, disjoint};
use crate::mollifier::mollis_mollifier;
use crate::status::{mollis_status, status};

/// Laplacian K = +Dirac: |x|/2, log|x|/(2 pi), -1/(4 pi |x|) in 1, 2, 3 dimensions. No parameter.
pub const MOLLIS_KERNEL_NEWTONIAN: i32 = 0;
/// |x|^p/p, log|x| for p = 0; parameter[0] = p > 1 - d (and p = 0 in 1D).
pub const MOLLIS_KERNEL_POWER: i32 = 1;
/// e^{-|x|/l}, a Morse term; parameter[0] = l > 0.
pub const MOLLIS_KERNEL_EXPONENTIAL: i32 = 2;
/// (Laplacian - k^2) K = Dirac: -e^{-k|x|}/(2k), -K0(k|x|)/(2 pi), -e^{-k|x|}/(4 pi |x|); parameter[0] = k > 0.
pub const MOLLIS_KERNEL_SCREENED: i32 = 3;
/// The most terms of a sum, a host's own kernel included.
pub const MOLLIS_KERNEL_MAX_TERMS: usize = 8;
const _: () = assert!(MOLLIS_KERNEL_MAX_TERMS == MAX_TERMS);

/// One term of a kernel sum: coefficient (+1 attracts where K grows, -1 repels) times K.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct mollis_kernel_term {
    /// `MOLLIS_KERNEL_...`.
    pub kind: i32,
    /// 0.
    pub reserved: i32,
    /// The factor.
    pub coefficient: f64,
    /// As the kind says; the others are not looked at.
    pub parameter: [f64; 2],
}

// SAFETY: numbers without padding (two 4-byte and three 8-byte ones), alignment 8.
unsafe impl Plain for mollis_kernel_term {}
const _: () = assert!(size_of::<mollis_kernel_term>() == 32);

impl mollis_kernel_term {
    fn to_core(self) -> Result<Term> {
        let [parameter, _] = self.parameter;
        let law = match self.kind {
            MOLLIS_KERNEL_NEWTONIAN => Law::Newtonian,
            MOLLIS_KERNEL_POWER..=MOLLIS_KERNEL_SCREENED if cfg!(not(feature = "kernels")) => {
                return Err(Error::Unsupported);
            }
            MOLLIS_KERNEL_POWER => Law::Power { exponent: parameter },
            MOLLIS_KERNEL_EXPONENTIAL => Law::Exponential { length: parameter },
            MOLLIS_KERNEL_SCREENED => Law::Screened { k: parameter },
            _ => return Err(Error::UnknownValue),
        };
        Ok(Term { law, coefficient: self.coefficient })
    }
}

/// A host's own radial kernel. Called only while a sum is prepared.
///
/// Its functions are fitted, and the fits compared with them between their nodes. Members after `reach` may be zero.
#[derive(Clone, Copy)]
#[repr(C)]
pub struct mollis_radial_kernel {
    /// Passed to `evaluate`.
    pub context: *mut c_void,
    /// Writes K(r), K'(r)/r and the Laplacian of K to out[0..2], for r > 0; returns 0, or a status that ends the call and
    /// comes back unchanged. r^(d-1) K and r^d K' must be integrable at 0. A value that is not finite is an error. The three must belong together,
    /// and be accurate at every r up to the reach (what is computed as 1 - exp(-r*r) is not at small r, -expm1(-r*r) is).
    pub evaluate: Option<unsafe extern "C" fn(context: *mut c_void, r: f64, out: *mut f64) -> mollis_status>,
    /// The factor.
    pub coefficient: f64,
    /// Pairs further apart get nothing from it, and are counted (`mollis_field_counts.beyond_reach`). Under a mollifier r goes a little further. From 1e-150 to 1e150.
    pub reach: f64,
    /// The largest error with which it is accepted, else MOLLIS_ERR_KERNEL_FIT. 0: 1e-10, in single precision 1e-5. Infinity accepts any.
    pub tolerance: f64,
    /// Without a mollifier: for smaller r, K continues with the power of r that K'/r has here. 0: 2^-52 of the reach, and
    /// the kernel is compared with it; otherwise between that and half the reach, and the kernel is not called for smaller r.
    pub least: f64,
    /// The number of knots, at most MOLLIS_KERNEL_MAX_KNOTS.
    pub n_knots: usize,
    /// Radii at which the kernel is not smooth (where the pieces of a spline meet), increasing by more than a relative 1e-10, between `least` and the reach. K is
    /// continuous there. Null if there are none.
    pub knots: *const f64,
    /// If not null, errors[0..2] get the errors of K, K'/r and the Laplacian when the kernel is prepared, or refused with MOLLIS_ERR_KERNEL_FIT: sums miss
    /// the kernel by no more, relative to the largest |K| (or r^2 |K'/r|), |K'/r|, and |Laplacian| or d |K'/r| over all distances from r/2 to r, and to
    /// delta from 0 where r < delta (to `least` where r is less), but for the sum's own rounding. Within some roundings of a knot either side's value counts.
    pub errors: *mut f64,
}

/// The most knots of a host's own kernel.
pub const MOLLIS_KERNEL_MAX_KNOTS: usize = 8;
const _: () = assert!(MOLLIS_KERNEL_MAX_KNOTS == MAX_KNOTS);

/// The host's kernel, remembering a status that it returned.
struct Host {
    kernel: mollis_radial_kernel,
    refused: Cell<mollis_status>,
    knots: Input<f64>,
    errors: Option<Output<f64>>,
    achieved: Cell<[f64; 3]>,
}

impl RadialKernel for Host {
    fn at(&self, r: f64) -> [f64; 3] {
        let mut out = [f64::NAN; 3];
        if let (Some(evaluate), 0) = (self.kernel.evaluate, self.refused.get()) {
            // SAFETY: the caller promises that the function may be called so, and `out` has room for three.
            self.refused.set(unsafe { evaluate(self.kernel.context, r, out.as_mut_ptr()) });
        }
        if self.refused.get() == 0 { out } else { [f64::NAN; 3] }
    }
}

/// Terms that a kernel of this build may have.
const ROOM: usize = if cfg!(feature = "kernels") { MAX_TERMS } else { 1 };

/// The terms, copied; each checked for its kind alone.
///
/// # Safety
/// The crate's contract.
pub(crate) unsafe fn read_terms(terms: Input<mollis_kernel_term>) -> Result<([Term; ROOM], usize)> {
    // SAFETY: the caller promises the crate's contract.
    let given = unsafe { terms.slice() };
    if given.len() > ROOM {
        return Err(if given.len() > MAX_TERMS { Error::KernelTerms } else { Error::Unsupported });
    }
    let mut all = [Term { law: Law::Newtonian, coefficient: 0.0 }; ROOM];
    for (slot, term) in all.iter_mut().zip(given) {
        *slot = term.to_core()?;
    }
    Ok((all, given.len()))
}

/// The prepared kernel in a caller's buffer.
///
/// # Safety
/// The crate's contract.
pub(crate) unsafe fn open<'a, T: Real, const D: usize>(
    kernel: *const c_void,
    bytes: usize,
) -> Result<Kernel<'a, T, D>> {
    let block = Input::new(kernel.cast::<u8>(), bytes)?;
    // SAFETY: the caller promises the crate's contract.
    Kernel::open(unsafe { block.slice() })
}

pub(crate) unsafe fn size<T: Real, const D: usize>(
    terms: *const mollis_kernel_term,
    n_terms: usize,
    own: *const mollis_radial_kernel,
    mollifier: mollis_mollifier,
    bytes: *mut usize,
) -> Result<()> {
    let (terms, output) = (Input::new(terms, n_terms)?, Output::new(bytes, 1)?);
    disjoint(&[Some(output.range())], &[terms.range()])?;
    // SAFETY: the caller promises the crate's contract.
    let (terms, count) = unsafe { read_terms(terms) }?;
    let terms = terms.get(..count).unwrap_or(&[]);
    let needed = Kernel::<T, D>::workspace_bytes_with(terms, !own.is_null(), mollifier.to_core()?)?;
    // SAFETY: as above.
    for slot in unsafe { output.slice() } {
        *slot = needed;
    }
    Ok(())
}

pub(crate) unsafe fn prepare<T: Real, const D: usize>(
    kernel: *mut c_void,
    bytes: usize,
    terms: *const mollis_kernel_term,
    n_terms: usize,
    own: *const mollis_radial_kernel,
    mollifier: mollis_mollifier,
    delta: T,
) -> mollis_status {
    let refused = Cell::new(0);
    let result = (|| {
        let (block, terms) = (block(kernel, bytes)?, Input::new(terms, n_terms)?);
        disjoint(&[Some(block.range())], &[terms.range()])?;
        let host = if own.is_null() {
            None
        } else if cfg!(not(feature = "kernels")) {
            return Err(Error::Unsupported);
        } else if !own.is_aligned() {
            return Err(Error::Misaligned);
        } else {
            // SAFETY: not null, aligned, and readable by the crate's contract.
            let kernel = unsafe { own.read() };
            if kernel.evaluate.is_none() {
                return Err(Error::NullPointer);
            }
            let (knots, errors) = (Input::new(kernel.knots, kernel.n_knots)?, Output::optional(kernel.errors, 3)?);
            disjoint(&[Some(block.range()), errors.map(Output::range)], &[terms.range(), knots.range()])?;
            Some(Host { kernel, refused: Cell::new(0), knots, errors, achieved: Cell::new([0.0; 3]) })
        };
        // SAFETY: the caller promises the crate's contract.
        let (terms, count) = unsafe { read_terms(terms) }?;
        let terms = terms.get(..count).unwrap_or(&[]);
        let mollifier = mollifier.to_core()?;
        let supplied = host.as_ref().map(|host| Supplied {
            kernel: host,
            coefficient: host.kernel.coefficient,
            reach: host.kernel.reach,
            // SAFETY: as above.
            knots: unsafe { host.knots.slice() },
            tolerance: host.kernel.tolerance,
            least: host.kernel.least,
            achieved: Some(&host.achieved),
        });
        // SAFETY: as above; the block overlaps nothing.
        let memory = unsafe { block.slice() };
        let made = Kernel::<T, D>::write(memory, terms, supplied, mollifier, delta);
        let errors = host.as_ref().and_then(|host| host.errors);
        if let (Some(errors), Some(host), Ok(()) | Err(Error::KernelFit)) = (errors, &host, made) {
            // SAFETY: as above; they overlap nothing.
            unsafe { errors.slice() }.iter_mut().zip(host.achieved.get()).for_each(|(to, error)| *to = error);
        }
        refused.set(host.map_or(0, |host| host.refused.get()));
        made
    })();
    if refused.get() != 0 { refused.get() } else { status(result) }
}

pub(crate) unsafe fn eval<T: Real, const D: usize>(
    kernel: *const c_void,
    bytes: usize,
    n: usize,
    r: *const T,
    outputs: [*mut T; 3],
) -> Result<()> {
    let (block, input) = (Input::new(kernel.cast::<u8>(), bytes)?, Input::new(r, n)?);
    let mut buffers = [None; 3];
    for (buffer, pointer) in buffers.iter_mut().zip(outputs) {
        *buffer = Output::optional(pointer, n)?;
    }
    disjoint(&buffers.map(|b| b.map(Output::range)), &[block.range(), input.range()])?;
    // SAFETY: the caller promises the crate's contract.
    let kernel = unsafe { open::<T, D>(kernel, bytes) }?;
    // SAFETY: as above.
    let r = unsafe { input.slice() };
    if !r.iter().all(|r| r.is_finite()) {
        return Err(Error::NotFinite);
    }
    // SAFETY: as above, and the outputs overlap nothing.
    let [mut u, mut g, mut l] = buffers.map(|b| b.map(|b| unsafe { b.slice() }.iter_mut()));
    for &r in r {
        let values = kernel.at(r.abs());
        for (output, value) in [&mut u, &mut g, &mut l].into_iter().zip(values) {
            if let Some(slot) = output.as_mut().and_then(Iterator::next) {
                *slot = value;
            }
        }
    }
    Ok(())
}

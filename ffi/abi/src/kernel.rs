//! Kernel sums: prepare into a caller's buffer, evaluate at distances.

use core::cell::Cell;
use core::ffi::c_void;

use mollis_core::kernel::{Kernel, Law, MAX_TERMS, RadialKernel, Supplied, Term};
use mollis_core::memory::Plain;
use mollis_core::{Error, Real, Result};

use crate::buffers::{Input, Output, disjoint, workspace};
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
#[derive(Clone, Copy)]
#[repr(C)]
pub struct mollis_radial_kernel {
    /// Passed to `evaluate`.
    pub context: *mut c_void,
    /// Writes K(r), K'(r)/r and the Laplacian of K to out[0..2], for r > 0; returns 0, or a status that ends the call and
    /// comes back unchanged. r^(d-1) K and r^d K' must be integrable at 0. A value that is not finite is an error.
    pub evaluate: Option<unsafe extern "C" fn(context: *mut c_void, r: f64, out: *mut f64) -> mollis_status>,
    /// The factor.
    pub coefficient: f64,
    /// Pairs further apart get nothing from it. Under a mollifier r goes a little further.
    pub reach: f64,
}

/// The host's kernel, remembering a status that it returned.
struct Host {
    kernel: mollis_radial_kernel,
    refused: Cell<mollis_status>,
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
unsafe fn read_terms(terms: Input<mollis_kernel_term>) -> Result<([Term; ROOM], usize)> {
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

unsafe fn size<T: Real, const D: usize>(
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

unsafe fn prepare<T: Real, const D: usize>(
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
        let (block, terms) = (workspace(kernel, bytes)?, Input::new(terms, n_terms)?);
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
            Some(Host { kernel, refused: Cell::new(0) })
        };
        // SAFETY: the caller promises the crate's contract.
        let (terms, count) = unsafe { read_terms(terms) }?;
        let terms = terms.get(..count).unwrap_or(&[]);
        let mollifier = mollifier.to_core()?;
        let supplied = host.as_ref().map(|host| Supplied {
            kernel: host,
            coefficient: host.kernel.coefficient,
            reach: host.kernel.reach,
        });
        // SAFETY: as above; the block overlaps nothing.
        let memory = unsafe { block.slice() };
        let made = Kernel::<T, D>::write(memory, terms, supplied, mollifier, delta);
        refused.set(host.map_or(0, |host| host.refused.get()));
        made
    })();
    if refused.get() != 0 { refused.get() } else { status(result) }
}

unsafe fn eval<T: Real, const D: usize>(
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

/// Writes the exact size in bytes of a prepared kernel in two dimensions: the sum of n_terms terms (at most
/// MOLLIS_KERNEL_MAX_TERMS) and, if not null, a host's own kernel, under a mollifier. It does not depend on delta.
///
/// Refused: MOLLIS_ERR_KERNEL_TERMS (none or too many), MOLLIS_ERR_KERNEL_PARAMETER, MOLLIS_ERR_NOT_FINITE,
/// MOLLIS_ERR_UNKNOWN_VALUE, MOLLIS_ERR_ORDER, MOLLIS_ERR_EXPONENT, MOLLIS_ERR_NULL_POINTER, MOLLIS_ERR_MISALIGNED,
/// MOLLIS_ERR_OVERLAP.
#[cfg(feature = "double")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_kernel2_workspace_bytes(
    terms: *const mollis_kernel_term,
    n_terms: usize,
    own: *const mollis_radial_kernel,
    mollifier: mollis_mollifier,
    bytes: *mut usize,
) -> mollis_status {
    // SAFETY: the crate's contract.
    status(unsafe { size::<f64, 2>(terms, n_terms, own, mollifier, bytes) })
}

/// Prepares the sum of n_terms terms and, if not null, a host's own kernel, mollified over the length delta, in two dimensions.
///
/// `kernel` holds as many `bytes` as the size query asked, aligned to 64; it is overwritten. The prepared block holds no
/// pointers: it may be copied, moved, saved, and read by several threads at a time. Closed forms take microseconds, fits
/// milliseconds to tens of them. delta is not looked at without a mollifier.
///
/// Refused: as by the size query, and MOLLIS_ERR_WORKSPACE_TOO_SMALL, MOLLIS_ERR_DELTA, MOLLIS_ERR_UNSUPPORTED (delta is many times
/// a length l or 1/k: about 600 times, 13 to 26 under a Gaussian mollifier; or exponent M = 1 with a power 0 < p + d - 1 < 0.08, whose
/// Laplacian is all but infinite at delta; or a mollified power above about 20, whose fits do not converge), MOLLIS_ERR_OUT_OF_DOMAIN (the own kernel's reach; or a coefficient leaves the scalar's range, in
/// single precision at some 90 lengths, 4.7 to 13 under a Gaussian mollifier; or K'/r of a kernel that isn't Newtonian leaves double precision at
/// distances of about delta, without a mollifier of about its length), MOLLIS_ERR_NOT_FINITE (the own kernel returned such a value), or the status
/// that the own kernel returned. After an error the block is not prepared, unless it was before and the size query or MOLLIS_ERR_DELTA refused.
#[cfg(feature = "double")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_kernel2_prepare(
    kernel: *mut c_void,
    bytes: usize,
    terms: *const mollis_kernel_term,
    n_terms: usize,
    own: *const mollis_radial_kernel,
    mollifier: mollis_mollifier,
    delta: f64,
) -> mollis_status {
    // SAFETY: the crate's contract.
    unsafe { prepare::<f64, 2>(kernel, bytes, terms, n_terms, own, mollifier, delta) }
}

/// Writes K_delta(r), K_delta'(r)/r and the Laplacian of K_delta at n distances (their magnitudes), of a kernel prepared in
/// two dimensions. Null outputs are not wanted; the others are overwritten. Without a mollifier all are 0 at r = 0.
///
/// Either precision computes in double and rounds once. Errors of a term are below 8 ulp of |value| for closed forms (powers 2, 4, 6, ...;
/// in one and three dimensions and without a Gaussian mollifier 1, 3, 5, ... too), and else below 1e-13 of the larger of |value| and the term's
/// scale at delta: the magnitude that it has there without a mollifier (for a logarithm at least 1; for the Laplacian at least that of the
/// gradient factor). Where delta is more than 5 times a length l or 1/k, the scale is |K| * |psi_delta| at r, if that is larger. (Beyond some 100 lengths, and beyond power 12 under a
/// Gaussian mollifier, errors are up to 2e-12.) Results are
/// infinite or zero only where the true ones leave the range; K_delta'(r)/r may, where the gradient does not.
/// From 10 (closed forms) to some hundred nanoseconds a term and distance.
///
/// Refused, with every output as it was: MOLLIS_ERR_NOT_PREPARED, MOLLIS_ERR_WRONG_VERSION, MOLLIS_ERR_WRONG_SCALAR,
/// MOLLIS_ERR_WRONG_BYTE_ORDER, MOLLIS_ERR_WORKSPACE_TOO_SMALL, MOLLIS_ERR_NOT_FINITE (some r), MOLLIS_ERR_NULL_POINTER,
/// MOLLIS_ERR_MISALIGNED, MOLLIS_ERR_TOO_LARGE, MOLLIS_ERR_OVERLAP.
#[cfg(feature = "double")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_kernel2_eval(
    kernel: *const c_void,
    bytes: usize,
    n: usize,
    r: *const f64,
    value: *mut f64,
    gradient_factor: *mut f64,
    laplacian: *mut f64,
) -> mollis_status {
    // SAFETY: the crate's contract.
    status(unsafe { eval::<f64, 2>(kernel, bytes, n, r, [value, gradient_factor, laplacian]) })
}

/// As `mollis_kernel2_workspace_bytes`, in two dimensions and single precision.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_kernel2_workspace_bytes_f32(
    terms: *const mollis_kernel_term,
    n_terms: usize,
    own: *const mollis_radial_kernel,
    mollifier: mollis_mollifier,
    bytes: *mut usize,
) -> mollis_status {
    // SAFETY: the crate's contract.
    status(unsafe { size::<f32, 2>(terms, n_terms, own, mollifier, bytes) })
}

/// As `mollis_kernel2_prepare`, in two dimensions and single precision.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_kernel2_prepare_f32(
    kernel: *mut c_void,
    bytes: usize,
    terms: *const mollis_kernel_term,
    n_terms: usize,
    own: *const mollis_radial_kernel,
    mollifier: mollis_mollifier,
    delta: f32,
) -> mollis_status {
    // SAFETY: the crate's contract.
    unsafe { prepare::<f32, 2>(kernel, bytes, terms, n_terms, own, mollifier, delta) }
}

/// As `mollis_kernel2_eval`, in two dimensions and single precision.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_kernel2_eval_f32(
    kernel: *const c_void,
    bytes: usize,
    n: usize,
    r: *const f32,
    value: *mut f32,
    gradient_factor: *mut f32,
    laplacian: *mut f32,
) -> mollis_status {
    // SAFETY: the crate's contract.
    status(unsafe { eval::<f32, 2>(kernel, bytes, n, r, [value, gradient_factor, laplacian]) })
}

/// As `mollis_kernel2_workspace_bytes`, in one dimension.
#[cfg(all(feature = "dimensions", feature = "double"))]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_kernel1_workspace_bytes(
    terms: *const mollis_kernel_term,
    n_terms: usize,
    own: *const mollis_radial_kernel,
    mollifier: mollis_mollifier,
    bytes: *mut usize,
) -> mollis_status {
    // SAFETY: the crate's contract.
    status(unsafe { size::<f64, 1>(terms, n_terms, own, mollifier, bytes) })
}

/// As `mollis_kernel2_prepare`, in one dimension.
#[cfg(all(feature = "dimensions", feature = "double"))]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_kernel1_prepare(
    kernel: *mut c_void,
    bytes: usize,
    terms: *const mollis_kernel_term,
    n_terms: usize,
    own: *const mollis_radial_kernel,
    mollifier: mollis_mollifier,
    delta: f64,
) -> mollis_status {
    // SAFETY: the crate's contract.
    unsafe { prepare::<f64, 1>(kernel, bytes, terms, n_terms, own, mollifier, delta) }
}

/// As `mollis_kernel2_eval`, in one dimension.
#[cfg(all(feature = "dimensions", feature = "double"))]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_kernel1_eval(
    kernel: *const c_void,
    bytes: usize,
    n: usize,
    r: *const f64,
    value: *mut f64,
    gradient_factor: *mut f64,
    laplacian: *mut f64,
) -> mollis_status {
    // SAFETY: the crate's contract.
    status(unsafe { eval::<f64, 1>(kernel, bytes, n, r, [value, gradient_factor, laplacian]) })
}

/// As `mollis_kernel2_workspace_bytes`, in one dimension and single precision.
#[cfg(feature = "dimensions")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_kernel1_workspace_bytes_f32(
    terms: *const mollis_kernel_term,
    n_terms: usize,
    own: *const mollis_radial_kernel,
    mollifier: mollis_mollifier,
    bytes: *mut usize,
) -> mollis_status {
    // SAFETY: the crate's contract.
    status(unsafe { size::<f32, 1>(terms, n_terms, own, mollifier, bytes) })
}

/// As `mollis_kernel2_prepare`, in one dimension and single precision.
#[cfg(feature = "dimensions")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_kernel1_prepare_f32(
    kernel: *mut c_void,
    bytes: usize,
    terms: *const mollis_kernel_term,
    n_terms: usize,
    own: *const mollis_radial_kernel,
    mollifier: mollis_mollifier,
    delta: f32,
) -> mollis_status {
    // SAFETY: the crate's contract.
    unsafe { prepare::<f32, 1>(kernel, bytes, terms, n_terms, own, mollifier, delta) }
}

/// As `mollis_kernel2_eval`, in one dimension and single precision.
#[cfg(feature = "dimensions")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_kernel1_eval_f32(
    kernel: *const c_void,
    bytes: usize,
    n: usize,
    r: *const f32,
    value: *mut f32,
    gradient_factor: *mut f32,
    laplacian: *mut f32,
) -> mollis_status {
    // SAFETY: the crate's contract.
    status(unsafe { eval::<f32, 1>(kernel, bytes, n, r, [value, gradient_factor, laplacian]) })
}

/// As `mollis_kernel2_workspace_bytes`, in three dimensions.
#[cfg(all(feature = "dimensions", feature = "double"))]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_kernel3_workspace_bytes(
    terms: *const mollis_kernel_term,
    n_terms: usize,
    own: *const mollis_radial_kernel,
    mollifier: mollis_mollifier,
    bytes: *mut usize,
) -> mollis_status {
    // SAFETY: the crate's contract.
    status(unsafe { size::<f64, 3>(terms, n_terms, own, mollifier, bytes) })
}

/// As `mollis_kernel2_prepare`, in three dimensions.
#[cfg(all(feature = "dimensions", feature = "double"))]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_kernel3_prepare(
    kernel: *mut c_void,
    bytes: usize,
    terms: *const mollis_kernel_term,
    n_terms: usize,
    own: *const mollis_radial_kernel,
    mollifier: mollis_mollifier,
    delta: f64,
) -> mollis_status {
    // SAFETY: the crate's contract.
    unsafe { prepare::<f64, 3>(kernel, bytes, terms, n_terms, own, mollifier, delta) }
}

/// As `mollis_kernel2_eval`, in three dimensions.
#[cfg(all(feature = "dimensions", feature = "double"))]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_kernel3_eval(
    kernel: *const c_void,
    bytes: usize,
    n: usize,
    r: *const f64,
    value: *mut f64,
    gradient_factor: *mut f64,
    laplacian: *mut f64,
) -> mollis_status {
    // SAFETY: the crate's contract.
    status(unsafe { eval::<f64, 3>(kernel, bytes, n, r, [value, gradient_factor, laplacian]) })
}

/// As `mollis_kernel2_workspace_bytes`, in three dimensions and single precision.
#[cfg(feature = "dimensions")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_kernel3_workspace_bytes_f32(
    terms: *const mollis_kernel_term,
    n_terms: usize,
    own: *const mollis_radial_kernel,
    mollifier: mollis_mollifier,
    bytes: *mut usize,
) -> mollis_status {
    // SAFETY: the crate's contract.
    status(unsafe { size::<f32, 3>(terms, n_terms, own, mollifier, bytes) })
}

/// As `mollis_kernel2_prepare`, in three dimensions and single precision.
#[cfg(feature = "dimensions")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_kernel3_prepare_f32(
    kernel: *mut c_void,
    bytes: usize,
    terms: *const mollis_kernel_term,
    n_terms: usize,
    own: *const mollis_radial_kernel,
    mollifier: mollis_mollifier,
    delta: f32,
) -> mollis_status {
    // SAFETY: the crate's contract.
    unsafe { prepare::<f32, 3>(kernel, bytes, terms, n_terms, own, mollifier, delta) }
}

/// As `mollis_kernel2_eval`, in three dimensions and single precision.
#[cfg(feature = "dimensions")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_kernel3_eval_f32(
    kernel: *const c_void,
    bytes: usize,
    n: usize,
    r: *const f32,
    value: *mut f32,
    gradient_factor: *mut f32,
    laplacian: *mut f32,
) -> mollis_status {
    // SAFETY: the crate's contract.
    status(unsafe { eval::<f32, 3>(kernel, bytes, n, r, [value, gradient_factor, laplacian]) })
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::ptr::{null, null_mut};

    const COMPACT: mollis_mollifier = mollis_mollifier { kind: 1, order: 4, exponent: 4 };
    const SUM: [mollis_kernel_term; 2] = [
        mollis_kernel_term { kind: MOLLIS_KERNEL_POWER, reserved: 0, coefficient: 1.0, parameter: [4.0, 0.0] },
        mollis_kernel_term { kind: MOLLIS_KERNEL_POWER, reserved: 0, coefficient: -1.0, parameter: [1.5, 0.0] },
    ];

    #[repr(align(64))]
    struct Memory([u8; 1 << 19]);

    fn bytes_of(terms: &[mollis_kernel_term], own: *const mollis_radial_kernel) -> usize {
        let mut bytes = 0;
        let status = unsafe { mollis_kernel2_workspace_bytes(terms.as_ptr(), terms.len(), own, COMPACT, &mut bytes) };
        assert_eq!(status, 0);
        bytes
    }

    #[test]
    fn a_sum_prepares_moves_and_evaluates_as_in_core() {
        let mut memory = Box::new(Memory([0xA5; 1 << 19]));
        let bytes = bytes_of(&SUM, null());
        let prepare = |memory: &mut Memory, bytes| unsafe {
            let kernel = memory.0.as_mut_ptr().cast();
            mollis_kernel2_prepare(kernel, bytes, SUM.as_ptr(), 2, null(), COMPACT, 0.3)
        };
        assert_eq!(prepare(&mut memory, bytes - 1), Error::WorkspaceTooSmall as i32);
        assert_eq!(prepare(&mut memory, bytes), 0);
        assert!(memory.0[bytes..].iter().all(|&b| b == 0xA5), "written beyond the block");
        // elsewhere
        let mut moved = Box::new(Memory([0; 1 << 19]));
        moved.0[..bytes].copy_from_slice(&memory.0[..bytes]);
        let r = [0.0, 0.1, 0.3, 2.0];
        let (mut u, mut g) = ([7.0; 4], [7.0; 4]);
        let eval = |memory: &Memory, bytes, r: *const f64, u: *mut f64, g: *mut f64| unsafe {
            mollis_kernel2_eval(memory.0.as_ptr().cast(), bytes, 4, r, u, g, null_mut())
        };
        assert_eq!(eval(&moved, bytes, r.as_ptr(), u.as_mut_ptr(), g.as_mut_ptr()), 0);
        let core = Kernel::<f64, 2>::open(&memory.0[..bytes]).unwrap();
        for (k, &r) in r.iter().enumerate() {
            assert_eq!([u[k], g[k]], [core.value(r), core.gradient_factor(r)]);
        }
        // every refusal leaves the outputs alone
        let before = (u, g);
        let bad = [0.0, f64::NAN, 0.3, 2.0];
        let up = u.as_mut_ptr();
        let refusals = [
            (eval(&moved, bytes, bad.as_ptr(), up, null_mut()), Error::NotFinite),
            (eval(&moved, bytes, null(), up, null_mut()), Error::NullPointer),
            (eval(&moved, bytes - 1, r.as_ptr(), up, null_mut()), Error::WorkspaceTooSmall),
            (eval(&moved, 8, r.as_ptr(), up, null_mut()), Error::NotPrepared),
            (eval(&moved, bytes, r.as_ptr(), up, up), Error::Overlap),
        ];
        for (status, error) in refusals {
            assert_eq!(status, error as i32);
        }
        let single = unsafe {
            mollis_kernel2_eval_f32(moved.0.as_ptr().cast(), bytes, 0, null(), null_mut(), null_mut(), null_mut())
        };
        assert_eq!(single, Error::WrongScalar as i32);
        let other = unsafe {
            mollis_kernel3_eval(moved.0.as_ptr().cast(), bytes, 0, null(), null_mut(), null_mut(), null_mut())
        };
        assert_eq!(other, Error::NotPrepared as i32);
        let askew = unsafe {
            mollis_kernel2_eval(moved.0[8..].as_ptr().cast(), bytes, 0, null(), null_mut(), null_mut(), null_mut())
        };
        assert_eq!(askew, Error::Misaligned as i32);
        moved.0[8] ^= 2;
        assert_eq!(eval(&moved, bytes, r.as_ptr(), up, null_mut()), Error::WrongVersion as i32);
        moved.0[..8].reverse();
        assert_eq!(eval(&moved, bytes, r.as_ptr(), up, null_mut()), Error::WrongByteOrder as i32);
        moved.0[..64].fill(0);
        assert_eq!(eval(&moved, bytes, r.as_ptr(), up, null_mut()), Error::NotPrepared as i32);
        assert_eq!((u, g), before);
    }

    #[test]
    fn bad_kernels_are_refused() {
        let term = |kind, coefficient, p| mollis_kernel_term { kind, reserved: 0, coefficient, parameter: [p, 0.0] };
        let mut bytes = 7;
        let mut ask = |terms: &[mollis_kernel_term], mollifier| unsafe {
            mollis_kernel2_workspace_bytes(terms.as_ptr(), terms.len(), null(), mollifier, &mut bytes)
        };
        let nan = f64::NAN;
        for (terms, error) in [
            (vec![term(MOLLIS_KERNEL_POWER, 1.0, -1.0)], Error::KernelParameter),
            (vec![term(MOLLIS_KERNEL_POWER, 1.0, nan)], Error::NotFinite),
            (vec![term(MOLLIS_KERNEL_POWER, f64::INFINITY, 1.0)], Error::NotFinite),
            (vec![term(MOLLIS_KERNEL_SCREENED, 1.0, 0.0)], Error::KernelParameter),
            (vec![term(MOLLIS_KERNEL_EXPONENTIAL, 1.0, -2.0)], Error::KernelParameter),
            (vec![term(4, 1.0, 1.0)], Error::UnknownValue),
            (vec![term(MOLLIS_KERNEL_NEWTONIAN, 1.0, 0.0); 9], Error::KernelTerms),
            (vec![], Error::KernelTerms),
        ] {
            assert_eq!(ask(&terms, COMPACT), error as i32, "{terms:?}");
        }
        let good = [term(MOLLIS_KERNEL_NEWTONIAN, -1.0, 0.0)];
        assert_eq!(ask(&good, mollis_mollifier { kind: 6, ..COMPACT }), Error::UnknownValue as i32);
        assert_eq!(ask(&good, mollis_mollifier { order: 3, ..COMPACT }), Error::Order as i32);
        assert_eq!(ask(&good, mollis_mollifier { exponent: 10, ..COMPACT }), Error::Exponent as i32);
        assert_eq!(bytes, 7);
        let mut memory = Box::new(Memory([0xA5; 1 << 19]));
        for delta in [0.0, -1.0, nan] {
            let kernel = memory.0.as_mut_ptr().cast();
            let status = unsafe { mollis_kernel2_prepare(kernel, 1 << 19, good.as_ptr(), 1, null(), COMPACT, delta) };
            assert_eq!(status, Error::Delta as i32);
        }
        assert!(memory.0.iter().all(|&b| b == 0xA5));
    }

    unsafe extern "C" fn square(context: *mut c_void, r: f64, out: *mut f64) -> mollis_status {
        // |x|^2/2 in 2D; the context says how to misbehave
        let (values, status) = match context.addr() {
            0 => ([0.5 * r * r, 1.0, 2.0], 0),
            1 => ([f64::NAN, 1.0, 2.0], 0),
            _ => ([0.0; 3], 1234),
        };
        unsafe { out.cast::<[f64; 3]>().write(values) };
        status
    }

    #[test]
    fn a_hosts_kernel_is_fitted_and_its_errors_come_back() {
        let mut own =
            mollis_radial_kernel { context: null_mut(), evaluate: Some(square), coefficient: 2.0, reach: 5.0 };
        let bytes = bytes_of(&[], &own);
        let mut memory = vec![0_u8; bytes + 64];
        let start = memory.as_ptr().align_offset(64);
        let mut prepare = |own: &mollis_radial_kernel| unsafe {
            let kernel = memory[start..].as_mut_ptr().cast();
            mollis_kernel2_prepare(kernel, bytes, null(), 0, own, COMPACT, 0.3)
        };
        for (context, status) in [(1, Error::NotFinite as i32), (2, 1234), (0, 0)] {
            own.context = core::ptr::without_provenance_mut(context);
            assert_eq!(prepare(&own), status);
        }
        assert_eq!(prepare(&mollis_radial_kernel { reach: 0.0, ..own }), Error::OutOfDomain as i32);
        assert_eq!(prepare(&mollis_radial_kernel { evaluate: None, ..own }), Error::NullPointer as i32);
        assert_eq!(prepare(&own), 0);
        let r = [0.0, 0.2, 0.31, 4.0, 6.0];
        let mut g = [7.0; 5];
        let kernel = memory[start..].as_ptr().cast();
        let status =
            unsafe { mollis_kernel2_eval(kernel, bytes, 5, r.as_ptr(), null_mut(), g.as_mut_ptr(), null_mut()) };
        assert_eq!(status, 0);
        // an order-4 mollifier leaves |x|^2/2's gradient factor alone; beyond the reach there is nothing
        for (g, want) in g.into_iter().zip([2.0, 2.0, 2.0, 2.0, 0.0]) {
            assert!((g - want).abs() < 1e-13, "{g} {want}");
        }
    }
}

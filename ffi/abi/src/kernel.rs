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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::functions::*;
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
        let status = unsafe { mollis_kernel2_bytes(terms.as_ptr(), terms.len(), own, COMPACT, &mut bytes) };
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
            mollis_kernel2_eval(moved.0[4..].as_ptr().cast(), bytes, 0, null(), null_mut(), null_mut(), null_mut())
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
            mollis_kernel2_bytes(terms.as_ptr(), terms.len(), null(), mollifier, &mut bytes)
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

    const PLAIN: mollis_radial_kernel = mollis_radial_kernel {
        context: null_mut(),
        evaluate: None,
        coefficient: 0.0,
        reach: 0.0,
        tolerance: 0.0,
        least: 0.0,
        n_knots: 0,
        knots: null(),
        errors: null_mut(),
    };

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
            mollis_radial_kernel { context: null_mut(), evaluate: Some(square), coefficient: 2.0, reach: 5.0, ..PLAIN };
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
        assert_eq!(prepare(&mollis_radial_kernel { reach: 0.0, ..own }), Error::KernelReach as i32);
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

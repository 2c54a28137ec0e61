use core::ffi::{c_char, c_void};

use crate::field::call::Ask;
use crate::field::essential::{Boxes, Reduce};
use crate::field::{mollis_field_counts, mollis_field_options};
use crate::run::mollis_run;
use crate::status::{mollis_status, status};

/// The sources of a sum in the plane, and their core radii.
///
/// Coordinates: `positions[k]` points to coordinate k of the first source, and `stride` is the number of doubles from one source to the next. With `positions[1]` (and [2]) null
/// the coordinates of a source follow one another. A stride of 0 is that of arrays without gaps. So `{x}` is an array `double x[n][2]`; `{&p->x}` with the stride
/// `sizeof *p / sizeof(double)` is an array of structures; and `{x, y}` are arrays of their own.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct mollis_sources{d}{f} {
    /// How many.
    pub n: usize,
    /// Their coordinates.
    pub positions: [*const {T}; {d}],
    /// From one to the next.
    pub stride: usize,
    /// Masses of any sign; sources of mass 0 are dropped. Not looked at with vector strengths.
    pub masses: *const {T},
    /// From one to the next; 0: 1. Masses in structures have the stride of their positions.
    pub mass_stride: usize,
    /// Core radii, positive, in place of the kernel's delta: for Newtonian kernels with a mollifier. Null: the kernel's delta.
    pub radii: *const {T},
    /// From one to the next; 0: 1.
    pub radius_stride: usize,
    /// In space: vector strengths instead of masses, or null. The gradient is then sum_j grad K_delta(x_i - x_j) x strength_j, the velocity of vortex elements by the law of Biot
    /// and Savart for the coefficient 1, of Newtonian kernels. Else null.
    pub strengths: [*const {T}; {d}],
    /// From one to the next.
    pub strength_stride: usize,
}

/// Where a sum is evaluated, in the plane: coordinates as in mollis_sources2.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct mollis_targets{d}{f} {
    /// How many.
    pub n: usize,
    /// Their coordinates.
    pub positions: [*const {T}; {d}],
    /// From one to the next.
    pub stride: usize,
    /// Core radii, positive, if the option `pair_radius` asks for them; else null. Null `targets` have the sources'.
    pub radii: *const {T},
    /// From one to the next; 0: 1.
    pub radius_stride: usize,
}

/// Where the results of a sum in the plane go: arrays as in mollis_sources2; null is not computed. All zero but the pointers: overwritten.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct mollis_outputs{d}{f} {
    /// u.
    pub potential: *mut {T},
    /// From one to the next; 0: 1.
    pub potential_stride: usize,
    /// grad u, or what `combination` makes of it.
    pub gradient: [*mut {T}; {d}],
    /// From one to the next.
    pub gradient_stride: usize,
    /// The Laplacian of u: the density of the blobs of a Newtonian kernel of coefficient 1.
    pub laplacian: *mut {T},
    /// From one to the next; 0: 1.
    pub laplacian_stride: usize,
    /// The second derivatives of u, `[2][2]` for each target, symmetric; `combination` makes nothing of them. (On the line the second derivative is the Laplacian.)
    pub hessian: *mut {T},
    /// From one matrix to the next; 0: 4, without gaps.
    pub hessian_stride: usize,
    /// What all results are multiplied by. 0, a member that was left alone, means 1.
    pub factor: f64,
    /// 1: results are added to what is there; 0: overwritten.
    pub add: i32,
    /// 0.
    pub reserved: i32,
}

/// Bytes of workspace that mollis_field2_eval needs for the same arguments, wherever the workspace begins. Only counts, strides and which pointers are null or beside each other are looked
/// at.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_field{d}_workspace_bytes{f}(
    kernel: *const c_void,
    kernel_bytes: usize,
    sources: *const mollis_sources{d}{f},
    targets: *const mollis_targets{d}{f},
    outputs: *const mollis_outputs{d}{f},
    options: *const mollis_field_options,
    run: *const mollis_run,
    bytes: *mut usize,
) -> mollis_status {
    let (sources, targets, outputs) = (sources.cast(), targets.cast(), outputs.cast());
    let ask = Ask::<{T}, {d}> { kernel, kernel_bytes, sources, targets, outputs, options };
    // SAFETY: the caller promises the crate's contract.
    status(unsafe { ask.bytes(run, bytes) })
}

/// Writes a sentence that says which method will run, why, and what is skipped: at most `text_bytes` with the zero at its end. `length` (may be null): the whole
/// sentence's length, without the zero.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_field{d}_text{f}(
    kernel: *const c_void,
    kernel_bytes: usize,
    sources: *const mollis_sources{d}{f},
    targets: *const mollis_targets{d}{f},
    outputs: *const mollis_outputs{d}{f},
    options: *const mollis_field_options,
    text: *mut c_char,
    text_bytes: usize,
    length: *mut usize,
) -> mollis_status {
    let (sources, targets, outputs) = (sources.cast(), targets.cast(), outputs.cast());
    let ask = Ask::<{T}, {d}> { kernel, kernel_bytes, sources, targets, outputs, options };
    // SAFETY: the caller promises the crate's contract.
    status(unsafe { ask.text(text, text_bytes, length) })
}

/// Sums over sources: u(x_i) = sum_j m_j K_delta(x_i - x_j) at every target, its gradient, Laplacian and second derivatives.
///
/// `kernel`: a block that mollis_kernel2_prepare filled. Null `targets`: at the sources. A mollified kernel counts every pair, a target on a source included; without a
/// mollifier coincident pairs contribute nothing. `workspace` is garbage afterwards. `options`, `run`, `counters` may be null. With core radii psi and K_delta are those of
/// each source's radius; the kernel has to be Newtonian with a mollifier (MOLLIS_ERR_UNSUPPORTED).
///
/// Arrays of equal strides may lie within each other like the members of structures. Where they are no arrays without gaps, or results are added or multiplied, the workspace holds a copy of
/// each: some nanoseconds a particle.
///
/// By the fast multipole method and the tree (MOLLIS_METHOD_FMM, MOLLIS_METHOD_TREE, or chosen for a tolerance) the error is the tolerance, see mollis_field_options. Else it
/// is at most (c + 256 + n/256) u S, u the unit roundoff; with MOLLIS_ACCUMULATION_COMPENSATED (c + 12) u S + (n/4) u^2 S. S is the
/// sum of |m_j| s_j, componentwise for gradients. With K the kernel that mollis_kernel2_eval returns, r = |x_i - x_j|:
///
/// * Newtonian, mollifier compact or none: s = |K| (in 2D plus 1/(2 pi)), |grad K|, and the mollifier's largest value for a Laplacian; c = 16,
///   and up to 112 with mollifiers of order 6 or 8, whose coefficients have both signs; for Laplacians 250 at order 6 and 2000 at order 8.
///   By MOLLIS_METHOD_SORTED c is half as much again.
/// * Other kernels, Gaussian mollifiers, and Newtonian terms beside these: s = A, |x_i - x_j| B (the gradient's components: theirs of
///   x_i - x_j), and L for a Laplacian, where A, B, L are the largest |K| and r^2 |K'/r|, |K'/r|, |Laplacian| and d |K'/r| at distances from
///   r/2 to r; where r < delta from 0 to delta; for exponential and screened kernels under Gaussian mollifiers from 0 to r. c = 32 in single
///   precision; in double 128, and 1000 for Laplacians; 400 and 3000 for exponential and screened kernels whose delta is from 5 to 100
///   lengths l or 1/k. Of several terms s is the sum of theirs.
/// * Even powers, by MOLLIS_METHOD_MOMENTS and MOLLIS_METHOD_SPLIT: the same, but s = |x_i - x_j| B for each component of a gradient.
///
/// All of this where neither a result nor K itself is below the normal range. Coordinates below 2^-126 (in double 2^-1022) of the largest
/// one count as zero; by MOLLIS_METHOD_SORTED what is below 2^-120 (2^-1000) of the powers of the largest coordinate may be lost.
///
/// * Algebraic mollifiers (Plummer's and the like): c = 32, and s is the bare kernel's at the distance (r^2 + delta^2)^(1/2), for Laplacians |Laplacian|, where delta^4
///   of the largest coordinate is a normal number (delta above 2^-31 of it in single precision).
///
/// * Second derivatives: s is d |K'/r| and the Laplacian's s together; c = 128, and 1500 in double where a Laplacian's is 1000.
///
/// Results do not depend on the number of threads, bit for bit. At other levels than portable the last bits of a target's may depend on the other targets of its block of 128: two targets in one place may differ there. A refused call writes nothing (but `run->first_bad`, with
/// MOLLIS_ERR_NOT_FINITE: sources, then targets); a stopped one has written some outputs, if these are arrays without gaps that are overwritten. Refused:
/// MOLLIS_ERR_NULL_POINTER, MOLLIS_ERR_MISALIGNED, MOLLIS_ERR_TOO_LARGE, MOLLIS_ERR_OVERLAP, MOLLIS_ERR_NOT_FINITE, MOLLIS_ERR_DELTA (a core radius that is not positive), MOLLIS_ERR_LENGTH_MISMATCH (targets without the core radii that `pair_radius` asks for),
/// MOLLIS_ERR_OUT_OF_DOMAIN (a negative tolerance), MOLLIS_ERR_UNSUPPORTED, MOLLIS_ERR_UNKNOWN_VALUE, MOLLIS_ERR_WORKSPACE_TOO_SMALL, MOLLIS_ERR_NOT_PREPARED and those of an unprepared kernel.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_field{d}_eval{f}(
    kernel: *const c_void,
    kernel_bytes: usize,
    sources: *const mollis_sources{d}{f},
    targets: *const mollis_targets{d}{f},
    outputs: *const mollis_outputs{d}{f},
    options: *const mollis_field_options,
    run: *const mollis_run,
    workspace: *mut c_void,
    workspace_bytes: usize,
    counters: *mut mollis_field_counts,
) -> mollis_status {
    let (sources, targets, outputs) = (sources.cast(), targets.cast(), outputs.cast());
    let ask = Ask::<{T}, {d}> { kernel, kernel_bytes, sources, targets, outputs, options };
    // SAFETY: the caller promises the crate's contract.
    unsafe { ask.evaluate(run, (workspace, workspace_bytes), counters) }
}

/// Bytes of workspace that mollis_field2_essential needs for the same kernel, sources and tolerance, wherever the workspace begins.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_field{d}_essential_bytes{f}(
    kernel: *const c_void,
    kernel_bytes: usize,
    sources: *const mollis_sources{d}{f},
    tolerance: f64,
    bytes: *mut usize,
) -> mollis_status {
    let ask = Reduce::<{T}, {d}> { kernel, kernel_bytes, sources: sources.cast(), tolerance };
    // SAFETY: the caller promises the crate's contract.
    status(unsafe { ask.bytes(bytes) })
}

/// Finds fewer sources that act as these do on all targets in a box: what a process sends to those that own the targets there, which add them to their own sources in any sum of the kernel, by
/// whatever method. A tree's cells that are far from the box become proxies: masses at a few points (of a locally essential tree, Warren & Salmon 1992, the expansions).
/// examples_c/mpi_blob.c exchanges particles so.
///
/// `boxes` [n_boxes]: lower and upper corner. A box whose lower corner is above the upper one along any axis has no targets, and nothing is essential for it. `starts` [n_boxes + 1] is overwritten with where those
/// for each box begin in `positions`, `masses` and `origins` [room], and their number at its end. These are overwritten; `origins` (may be null) says which source each is, 2^64 - 1 for a proxy.
/// With `positions` null and `room` 0 only `starts` is written. Never are there more for a box than sources.
///
/// Sources with core radii: those of a cell whose largest possible core reaches the box are kept. A source that was kept has its own radius (by its origin), a proxy may have any that sources have.
///
/// `tolerance`: of what is left out, in the l2 norm over targets in a box relative to that of sum_j |m_j| |K_j|, and the same of gradients; at least 1e-12, in single precision 1e-5. Whatever sum follows adds its own
/// error.
///
/// Cost: a sort, the moments of the cells that are replaced, each once, and for each box a time proportional to what comes out; on one thread.
///
/// Refused: MOLLIS_ERR_NULL_POINTER, MOLLIS_ERR_MISALIGNED, MOLLIS_ERR_TOO_LARGE, MOLLIS_ERR_OVERLAP, MOLLIS_ERR_NOT_FINITE, MOLLIS_ERR_DELTA (a core radius that is not positive), MOLLIS_ERR_OUT_OF_DOMAIN (the tolerance),
/// MOLLIS_ERR_UNSUPPORTED (vector strengths; a kernel of the host's; core radii under an algebraic mollifier or of another kernel than the Newtonian), MOLLIS_ERR_WORKSPACE_TOO_SMALL, MOLLIS_ERR_NOT_PREPARED and those of an unprepared kernel.
/// MOLLIS_ERR_NO_ROOM: `room` is less than starts[n_boxes]; so much is written. MOLLIS_ERR_STOPPED.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_field{d}_essential{f}(
    kernel: *const c_void,
    kernel_bytes: usize,
    sources: *const mollis_sources{d}{f},
    tolerance: f64,
    n_boxes: usize,
    boxes: *const [[{T}; {d}]; 2],
    starts: *mut u64,
    room: usize,
    positions: *mut [{T}; {d}],
    masses: *mut {T},
    origins: *mut u64,
    run: *const mollis_run,
    workspace: *mut c_void,
    workspace_bytes: usize,
) -> mollis_status {
    let ask = Reduce::<{T}, {d}> { kernel, kernel_bytes, sources: sources.cast(), tolerance };
    let boxes = Boxes { n: n_boxes, corners: boxes, starts, room, positions, masses, origins };
    // SAFETY: the caller promises the crate's contract.
    unsafe { ask.find(boxes, run, (workspace, workspace_bytes)) }
}

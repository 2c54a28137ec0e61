//! Field sums: plan (method, reason, bytes, text) and evaluation.

mod options;

pub use options::*;

use core::ffi::{c_char, c_void};

use mollis_core::exec::{Run, Statistics};
use mollis_core::field::{self, Outputs, Plan, Sources, Wanted};
use mollis_core::{Error, Real, Result};

use crate::buffers::{Input, Output, disjoint, workspace};
use crate::first_bad::first_bad;
use crate::kernel::open;
use crate::options::read;
use crate::run::{CallReport, HostRun, mollis_run, with_run};
use crate::status::{mollis_status, status};

/// The arguments of a plan.
#[derive(Clone, Copy)]
struct PlanArguments {
    kernel: *const c_void,
    kernel_bytes: usize,
    n_sources: usize,
    n_targets: usize,
    wanted: Wanted,
    options: *const mollis_field_options,
}

impl PlanArguments {
    /// # Safety
    /// The crate's contract.
    unsafe fn plan<T: Real, const D: usize>(self) -> Result<Plan> {
        // SAFETY: passed on.
        let (kernel, options) = unsafe { (open::<T, D>(self.kernel, self.kernel_bytes)?, read(self.options)?) };
        field::plan(&kernel, self.n_sources, self.n_targets, self.wanted, &options.to_core()?)
    }

    /// # Safety
    /// The crate's contract.
    unsafe fn bytes<T: Real, const D: usize>(self, run: *const mollis_run, bytes: *mut usize) -> Result<()> {
        let output = Output::new(bytes, 1)?;
        disjoint(&[Some(output.range())], &[Input::new(self.kernel.cast::<u8>(), self.kernel_bytes)?.range()])?;
        // SAFETY: passed on.
        let (run, plan) = unsafe { (HostRun::read(run)?, self.plan::<T, D>()?) };
        let needed = plan.workspace_bytes(run.workers())?;
        // SAFETY: passed on.
        unsafe { output.slice() }.fill(needed);
        Ok(())
    }

    /// # Safety
    /// The crate's contract.
    unsafe fn text<T: Real, const D: usize>(self, text: *mut c_char, size: usize, length: *mut usize) -> Result<()> {
        let (buffer, count) = (Output::new(text.cast::<u8>(), size)?, Output::optional(length, 1)?);
        let kernel = Input::new(self.kernel.cast::<u8>(), self.kernel_bytes)?;
        disjoint(&[Some(buffer.range()), count.map(Output::range)], &[kernel.range()])?;
        // SAFETY: passed on.
        let plan = unsafe { self.plan::<T, D>() }?;
        // SAFETY: passed on.
        let mut writer = Text { left: unsafe { buffer.slice() }, written: 0 };
        plan.describe(|text| writer.add(text));
        let written = writer.written;
        writer.end();
        if let Some(count) = count {
            // SAFETY: passed on.
            unsafe { count.slice() }.fill(written);
        }
        Ok(())
    }
}

/// Text into a caller's buffer: what does not fit is counted and dropped; always ended by a zero.
struct Text<'a> {
    left: &'a mut [u8],
    written: usize,
}

impl Text<'_> {
    fn add(&mut self, s: &str) {
        self.written = self.written.saturating_add(s.len());
        // One byte stays for the end.
        let room = self.left.len().saturating_sub(1).min(s.len());
        let left = core::mem::take(&mut self.left);
        if let Some((here, rest)) = left.split_at_mut_checked(room) {
            here.iter_mut().zip(s.as_bytes()).for_each(|(to, &from)| *to = from);
            self.left = rest;
        }
    }

    fn end(self) {
        if let Some(last) = self.left.first_mut() {
            *last = 0;
        }
    }
}

/// The buffers of an evaluation.
struct Buffers<T, const D: usize> {
    positions: *const [T; D],
    masses: *const T,
    targets: *const [T; D],
    potential: *mut T,
    gradient: *mut [T; D],
    laplacian: *mut T,
    workspace: *mut c_void,
    workspace_bytes: usize,
}

/// # Safety
/// The crate's contract.
unsafe fn evaluate<T: Real, const D: usize>(
    ask: PlanArguments,
    buffers: Buffers<T, D>,
    run: *const mollis_run,
    counters: *mut mollis_counters,
) -> mollis_status {
    // SAFETY: passed on.
    unsafe { with_run(run, |host, told| sum(ask, buffers, host, counters, told)) }
}

/// # Safety
/// The crate's contract.
unsafe fn sum<T: Real, const D: usize>(
    ask: PlanArguments,
    buffers: Buffers<T, D>,
    host: &HostRun,
    counters: *mut mollis_counters,
    told: &mut CallReport,
) -> Result<()> {
    let (n, k) = (ask.n_sources, ask.n_targets);
    let block = Input::new(ask.kernel.cast::<u8>(), ask.kernel_bytes)?;
    let (positions, masses) = (Input::new(buffers.positions, n)?, Input::new(buffers.masses, n)?);
    let targets = Input::new(buffers.targets, k)?;
    let potential = Output::optional(buffers.potential, k)?;
    let gradient = Output::optional(buffers.gradient, k)?;
    let laplacian = Output::optional(buffers.laplacian, k)?;
    let memory = workspace(buffers.workspace, buffers.workspace_bytes)?;
    let counts = Output::optional(counters, 1)?;
    disjoint(
        &[
            potential.map(Output::range),
            gradient.map(Output::range),
            laplacian.map(Output::range),
            Some(memory.range()),
            counts.map(Output::range),
            host.first_bad(),
        ],
        &[block.range(), positions.range(), masses.range(), targets.range()],
    )?;
    let wanted =
        Wanted { potential: potential.is_some(), gradient: gradient.is_some(), laplacian: laplacian.is_some() };
    let ask = PlanArguments { wanted, ..ask };
    // SAFETY: the caller promises the crate's contract.
    let (plan, kernel) = unsafe { (ask.plan::<T, D>()?, open::<T, D>(ask.kernel, ask.kernel_bytes)?) };
    if buffers.workspace_bytes < plan.workspace_bytes(host.workers())? {
        return Err(Error::WorkspaceTooSmall);
    }
    // SAFETY: as above; outputs and workspace overlap nothing.
    let (sources, targets, outputs, memory) = unsafe {
        (
            Sources::new(positions.slice(), masses.slice()),
            targets.slice(),
            Outputs {
                potential: potential.map(|p| p.slice()),
                gradient: gradient.map(|g| g.slice()),
                laplacian: laplacian.map(|l| l.slice()),
            },
            memory.slice(),
        )
    };
    let mut done = Statistics::default();
    let result = host.enter(|run| {
        let (level, executor, should_stop) = (run.level, run.executor, run.should_stop);
        let mut run = Run { level, executor, should_stop, counters: Some(&mut done) };
        field::evaluate(&plan, &kernel, sources, targets, outputs, memory, &mut run)
    });
    if result == Err(Error::NotFinite) {
        let of_sources = first_bad(sources.positions, sources.masses);
        told.first_bad = of_sources.or_else(|| first_bad::<T, D>(targets, &[]).map(|index| n.saturating_add(index)));
    }
    result?;
    if let Some(counts) = counts {
        // SAFETY: as above.
        for to in unsafe { counts.slice() } {
            to.pairs = to.pairs.saturating_add(done.pairs);
            to.near_pairs = to.near_pairs.saturating_add(done.near_pairs);
            to.polynomial_blocks = to.polynomial_blocks.saturating_add(done.polynomial_blocks);
            to.all_near_blocks = to.all_near_blocks.saturating_add(done.all_near_blocks);
            to.scaled_pairs = to.scaled_pairs.saturating_add(done.scaled_pairs);
            to.massless_sources = to.massless_sources.saturating_add(done.massless_sources);
        }
    }
    Ok(())
}

/// The exact number of workspace bytes that `mollis_field1_eval` needs for these sizes, outputs (`wanted`: bits
/// `MOLLIS_WANT_...`), options and number of workers.
///
/// # Safety
/// The contract of this header.
#[cfg(all(feature = "dimensions", feature = "double"))]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_field1_workspace_bytes(
    kernel: *const c_void,
    kernel_bytes: usize,
    n_sources: usize,
    n_targets: usize,
    wanted: u32,
    options: *const mollis_field_options,
    run: *const mollis_run,
    bytes: *mut usize,
) -> mollis_status {
    status(options::wanted(wanted).and_then(|wanted| {
        let ask = PlanArguments { kernel, kernel_bytes, n_sources, n_targets, wanted, options };
        // SAFETY: this function's own contract.
        unsafe { ask.bytes::<f64, 1>(run, bytes) }
    }))
}

/// Writes a sentence that says which method will run, why, and what is skipped: at most `text_bytes` with the zero at its end.
/// `length` (may be null): the whole sentence's length, without the zero.
///
/// # Safety
/// The contract of this header.
#[cfg(all(feature = "dimensions", feature = "double"))]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_field1_text(
    kernel: *const c_void,
    kernel_bytes: usize,
    n_sources: usize,
    n_targets: usize,
    wanted: u32,
    options: *const mollis_field_options,
    text: *mut c_char,
    text_bytes: usize,
    length: *mut usize,
) -> mollis_status {
    status(options::wanted(wanted).and_then(|wanted| {
        let ask = PlanArguments { kernel, kernel_bytes, n_sources, n_targets, wanted, options };
        // SAFETY: this function's own contract.
        unsafe { ask.text::<f64, 1>(text, text_bytes, length) }
    }))
}

/// Sums over sources: u(x_i) = sum_j m_j K_delta(x_i - x_j) at every target, its gradient and its Laplacian.
///
/// `kernel`: a block that `mollis_kernel1_prepare` filled. `positions` [n_sources][1], `masses` [n_sources] of any sign (those that are
/// 0 are dropped), `targets` [n_targets][1], which may be `positions`. `potential` and `laplacian` [n_targets], `gradient` [n_targets][1]:
/// overwritten; null is not computed. A mollified kernel counts every pair, a target on a source included; without a
/// mollifier coincident pairs contribute nothing. `workspace` is garbage afterwards. `options`, `run`, `counters` may be null.
///
/// The error is at most (c + 256 + n/256) u S, u the unit roundoff; with MOLLIS_ACCUMULATION_COMPENSATED (c + 12) u S + (n/4) u^2 S. S is the
/// sum of |m_j| s_j, componentwise for gradients. With K the kernel that `mollis_kernel1_eval` returns, r = |x_i - x_j|:
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
/// Results do not depend on the number of threads, bit for bit. A refused call writes nothing (but `run->first_bad`, with
/// `MOLLIS_ERR_NOT_FINITE`: sources, then targets); a stopped one has written some outputs.
///
/// # Safety
/// The contract of this header.
#[unsafe(no_mangle)]
#[allow(clippy::too_many_arguments, reason = "one function, outputs by pointers")]
pub unsafe extern "C" fn mollis_field1_eval(
    kernel: *const c_void,
    kernel_bytes: usize,
    n_sources: usize,
    positions: *const [f64; 1],
    masses: *const f64,
    n_targets: usize,
    targets: *const [f64; 1],
    potential: *mut f64,
    gradient: *mut [f64; 1],
    laplacian: *mut f64,
    options: *const mollis_field_options,
    workspace: *mut c_void,
    workspace_bytes: usize,
    run: *const mollis_run,
    counters: *mut mollis_counters,
) -> mollis_status {
    let ask = PlanArguments { kernel, kernel_bytes, n_sources, n_targets, wanted: Wanted::default(), options };
    let buffers = Buffers { positions, masses, targets, potential, gradient, laplacian, workspace, workspace_bytes };
    // SAFETY: this function's own contract.
    unsafe { evaluate(ask, buffers, run, counters) }
}

/// As `mollis_field1_workspace_bytes`.
///
/// # Safety
/// The contract of this header.
#[cfg(feature = "dimensions")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_field1_workspace_bytes_f32(
    kernel: *const c_void,
    kernel_bytes: usize,
    n_sources: usize,
    n_targets: usize,
    wanted: u32,
    options: *const mollis_field_options,
    run: *const mollis_run,
    bytes: *mut usize,
) -> mollis_status {
    status(options::wanted(wanted).and_then(|wanted| {
        let ask = PlanArguments { kernel, kernel_bytes, n_sources, n_targets, wanted, options };
        // SAFETY: this function's own contract.
        unsafe { ask.bytes::<f32, 1>(run, bytes) }
    }))
}

/// As `mollis_field1_text`.
///
/// # Safety
/// The contract of this header.
#[cfg(feature = "dimensions")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_field1_text_f32(
    kernel: *const c_void,
    kernel_bytes: usize,
    n_sources: usize,
    n_targets: usize,
    wanted: u32,
    options: *const mollis_field_options,
    text: *mut c_char,
    text_bytes: usize,
    length: *mut usize,
) -> mollis_status {
    status(options::wanted(wanted).and_then(|wanted| {
        let ask = PlanArguments { kernel, kernel_bytes, n_sources, n_targets, wanted, options };
        // SAFETY: this function's own contract.
        unsafe { ask.text::<f32, 1>(text, text_bytes, length) }
    }))
}

/// As `mollis_field1_eval`.
///
/// # Safety
/// The contract of this header.
#[unsafe(no_mangle)]
#[allow(clippy::too_many_arguments, reason = "one function, outputs by pointers")]
pub unsafe extern "C" fn mollis_field1_eval_f32(
    kernel: *const c_void,
    kernel_bytes: usize,
    n_sources: usize,
    positions: *const [f32; 1],
    masses: *const f32,
    n_targets: usize,
    targets: *const [f32; 1],
    potential: *mut f32,
    gradient: *mut [f32; 1],
    laplacian: *mut f32,
    options: *const mollis_field_options,
    workspace: *mut c_void,
    workspace_bytes: usize,
    run: *const mollis_run,
    counters: *mut mollis_counters,
) -> mollis_status {
    let ask = PlanArguments { kernel, kernel_bytes, n_sources, n_targets, wanted: Wanted::default(), options };
    let buffers = Buffers { positions, masses, targets, potential, gradient, laplacian, workspace, workspace_bytes };
    // SAFETY: this function's own contract.
    unsafe { evaluate(ask, buffers, run, counters) }
}

/// As `mollis_field1_workspace_bytes`.
///
/// # Safety
/// The contract of this header.
#[cfg(feature = "double")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_field2_workspace_bytes(
    kernel: *const c_void,
    kernel_bytes: usize,
    n_sources: usize,
    n_targets: usize,
    wanted: u32,
    options: *const mollis_field_options,
    run: *const mollis_run,
    bytes: *mut usize,
) -> mollis_status {
    status(options::wanted(wanted).and_then(|wanted| {
        let ask = PlanArguments { kernel, kernel_bytes, n_sources, n_targets, wanted, options };
        // SAFETY: this function's own contract.
        unsafe { ask.bytes::<f64, 2>(run, bytes) }
    }))
}

/// As `mollis_field1_text`.
///
/// # Safety
/// The contract of this header.
#[cfg(feature = "double")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_field2_text(
    kernel: *const c_void,
    kernel_bytes: usize,
    n_sources: usize,
    n_targets: usize,
    wanted: u32,
    options: *const mollis_field_options,
    text: *mut c_char,
    text_bytes: usize,
    length: *mut usize,
) -> mollis_status {
    status(options::wanted(wanted).and_then(|wanted| {
        let ask = PlanArguments { kernel, kernel_bytes, n_sources, n_targets, wanted, options };
        // SAFETY: this function's own contract.
        unsafe { ask.text::<f64, 2>(text, text_bytes, length) }
    }))
}

/// As `mollis_field1_eval`.
///
/// # Safety
/// The contract of this header.
#[unsafe(no_mangle)]
#[allow(clippy::too_many_arguments, reason = "one function, outputs by pointers")]
pub unsafe extern "C" fn mollis_field2_eval(
    kernel: *const c_void,
    kernel_bytes: usize,
    n_sources: usize,
    positions: *const [f64; 2],
    masses: *const f64,
    n_targets: usize,
    targets: *const [f64; 2],
    potential: *mut f64,
    gradient: *mut [f64; 2],
    laplacian: *mut f64,
    options: *const mollis_field_options,
    workspace: *mut c_void,
    workspace_bytes: usize,
    run: *const mollis_run,
    counters: *mut mollis_counters,
) -> mollis_status {
    let ask = PlanArguments { kernel, kernel_bytes, n_sources, n_targets, wanted: Wanted::default(), options };
    let buffers = Buffers { positions, masses, targets, potential, gradient, laplacian, workspace, workspace_bytes };
    // SAFETY: this function's own contract.
    unsafe { evaluate(ask, buffers, run, counters) }
}

/// As `mollis_field1_workspace_bytes`.
///
/// # Safety
/// The contract of this header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_field2_workspace_bytes_f32(
    kernel: *const c_void,
    kernel_bytes: usize,
    n_sources: usize,
    n_targets: usize,
    wanted: u32,
    options: *const mollis_field_options,
    run: *const mollis_run,
    bytes: *mut usize,
) -> mollis_status {
    status(options::wanted(wanted).and_then(|wanted| {
        let ask = PlanArguments { kernel, kernel_bytes, n_sources, n_targets, wanted, options };
        // SAFETY: this function's own contract.
        unsafe { ask.bytes::<f32, 2>(run, bytes) }
    }))
}

/// As `mollis_field1_text`.
///
/// # Safety
/// The contract of this header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_field2_text_f32(
    kernel: *const c_void,
    kernel_bytes: usize,
    n_sources: usize,
    n_targets: usize,
    wanted: u32,
    options: *const mollis_field_options,
    text: *mut c_char,
    text_bytes: usize,
    length: *mut usize,
) -> mollis_status {
    status(options::wanted(wanted).and_then(|wanted| {
        let ask = PlanArguments { kernel, kernel_bytes, n_sources, n_targets, wanted, options };
        // SAFETY: this function's own contract.
        unsafe { ask.text::<f32, 2>(text, text_bytes, length) }
    }))
}

/// As `mollis_field1_eval`.
///
/// # Safety
/// The contract of this header.
#[unsafe(no_mangle)]
#[allow(clippy::too_many_arguments, reason = "one function, outputs by pointers")]
pub unsafe extern "C" fn mollis_field2_eval_f32(
    kernel: *const c_void,
    kernel_bytes: usize,
    n_sources: usize,
    positions: *const [f32; 2],
    masses: *const f32,
    n_targets: usize,
    targets: *const [f32; 2],
    potential: *mut f32,
    gradient: *mut [f32; 2],
    laplacian: *mut f32,
    options: *const mollis_field_options,
    workspace: *mut c_void,
    workspace_bytes: usize,
    run: *const mollis_run,
    counters: *mut mollis_counters,
) -> mollis_status {
    let ask = PlanArguments { kernel, kernel_bytes, n_sources, n_targets, wanted: Wanted::default(), options };
    let buffers = Buffers { positions, masses, targets, potential, gradient, laplacian, workspace, workspace_bytes };
    // SAFETY: this function's own contract.
    unsafe { evaluate(ask, buffers, run, counters) }
}

/// As `mollis_field1_workspace_bytes`.
///
/// # Safety
/// The contract of this header.
#[cfg(all(feature = "dimensions", feature = "double"))]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_field3_workspace_bytes(
    kernel: *const c_void,
    kernel_bytes: usize,
    n_sources: usize,
    n_targets: usize,
    wanted: u32,
    options: *const mollis_field_options,
    run: *const mollis_run,
    bytes: *mut usize,
) -> mollis_status {
    status(options::wanted(wanted).and_then(|wanted| {
        let ask = PlanArguments { kernel, kernel_bytes, n_sources, n_targets, wanted, options };
        // SAFETY: this function's own contract.
        unsafe { ask.bytes::<f64, 3>(run, bytes) }
    }))
}

/// As `mollis_field1_text`.
///
/// # Safety
/// The contract of this header.
#[cfg(all(feature = "dimensions", feature = "double"))]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_field3_text(
    kernel: *const c_void,
    kernel_bytes: usize,
    n_sources: usize,
    n_targets: usize,
    wanted: u32,
    options: *const mollis_field_options,
    text: *mut c_char,
    text_bytes: usize,
    length: *mut usize,
) -> mollis_status {
    status(options::wanted(wanted).and_then(|wanted| {
        let ask = PlanArguments { kernel, kernel_bytes, n_sources, n_targets, wanted, options };
        // SAFETY: this function's own contract.
        unsafe { ask.text::<f64, 3>(text, text_bytes, length) }
    }))
}

/// As `mollis_field1_eval`.
///
/// # Safety
/// The contract of this header.
#[unsafe(no_mangle)]
#[allow(clippy::too_many_arguments, reason = "one function, outputs by pointers")]
pub unsafe extern "C" fn mollis_field3_eval(
    kernel: *const c_void,
    kernel_bytes: usize,
    n_sources: usize,
    positions: *const [f64; 3],
    masses: *const f64,
    n_targets: usize,
    targets: *const [f64; 3],
    potential: *mut f64,
    gradient: *mut [f64; 3],
    laplacian: *mut f64,
    options: *const mollis_field_options,
    workspace: *mut c_void,
    workspace_bytes: usize,
    run: *const mollis_run,
    counters: *mut mollis_counters,
) -> mollis_status {
    let ask = PlanArguments { kernel, kernel_bytes, n_sources, n_targets, wanted: Wanted::default(), options };
    let buffers = Buffers { positions, masses, targets, potential, gradient, laplacian, workspace, workspace_bytes };
    // SAFETY: this function's own contract.
    unsafe { evaluate(ask, buffers, run, counters) }
}

/// As `mollis_field1_workspace_bytes`.
///
/// # Safety
/// The contract of this header.
#[cfg(feature = "dimensions")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_field3_workspace_bytes_f32(
    kernel: *const c_void,
    kernel_bytes: usize,
    n_sources: usize,
    n_targets: usize,
    wanted: u32,
    options: *const mollis_field_options,
    run: *const mollis_run,
    bytes: *mut usize,
) -> mollis_status {
    status(options::wanted(wanted).and_then(|wanted| {
        let ask = PlanArguments { kernel, kernel_bytes, n_sources, n_targets, wanted, options };
        // SAFETY: this function's own contract.
        unsafe { ask.bytes::<f32, 3>(run, bytes) }
    }))
}

/// As `mollis_field1_text`.
///
/// # Safety
/// The contract of this header.
#[cfg(feature = "dimensions")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_field3_text_f32(
    kernel: *const c_void,
    kernel_bytes: usize,
    n_sources: usize,
    n_targets: usize,
    wanted: u32,
    options: *const mollis_field_options,
    text: *mut c_char,
    text_bytes: usize,
    length: *mut usize,
) -> mollis_status {
    status(options::wanted(wanted).and_then(|wanted| {
        let ask = PlanArguments { kernel, kernel_bytes, n_sources, n_targets, wanted, options };
        // SAFETY: this function's own contract.
        unsafe { ask.text::<f32, 3>(text, text_bytes, length) }
    }))
}

/// As `mollis_field1_eval`.
///
/// # Safety
/// The contract of this header.
#[unsafe(no_mangle)]
#[allow(clippy::too_many_arguments, reason = "one function, outputs by pointers")]
pub unsafe extern "C" fn mollis_field3_eval_f32(
    kernel: *const c_void,
    kernel_bytes: usize,
    n_sources: usize,
    positions: *const [f32; 3],
    masses: *const f32,
    n_targets: usize,
    targets: *const [f32; 3],
    potential: *mut f32,
    gradient: *mut [f32; 3],
    laplacian: *mut f32,
    options: *const mollis_field_options,
    workspace: *mut c_void,
    workspace_bytes: usize,
    run: *const mollis_run,
    counters: *mut mollis_counters,
) -> mollis_status {
    let ask = PlanArguments { kernel, kernel_bytes, n_sources, n_targets, wanted: Wanted::default(), options };
    let buffers = Buffers { positions, masses, targets, potential, gradient, laplacian, workspace, workspace_bytes };
    // SAFETY: this function's own contract.
    unsafe { evaluate(ask, buffers, run, counters) }
}

//! How a call runs: instruction set, executor, request to stop. Arguments of a call, never stored.

#[cfg_attr(feature = "small", path = "no_communicator.rs")]
mod communicator;
#[cfg_attr(feature = "small", path = "no_executor.rs")]
mod executor;

use core::ffi::c_void;

use communicator::HostRanks;
use executor::Host;
use mollis_core::exec::{Executor, Run, Serial};
use mollis_core::simd::Level;
use mollis_core::{Error, Result};

use crate::buffers::{Output, Range};
use crate::diagnostics::put;
use crate::first_bad::MOLLIS_NONE_BAD;
use crate::mollis_status;
use crate::options;
use crate::status::status;

/// The fastest instruction set of the machine.
pub const MOLLIS_LEVEL_BEST: i32 = -1;
/// Only + - * / and sqrt, in one stated order: the same bits on every machine.
pub const MOLLIS_LEVEL_PORTABLE: i32 = 0;
/// 128-bit vectors of every aarch64.
pub const MOLLIS_LEVEL_NEON: i32 = 1;
/// 256-bit vectors with fused multiply-add.
pub const MOLLIS_LEVEL_AVX2: i32 = 2;
/// 512-bit vectors.
pub const MOLLIS_LEVEL_AVX512: i32 = 3;

/// One task of a call: `mollis` passes it to `parallel_for`, which calls it.
pub type mollis_task = Option<unsafe extern "C" fn(data: *mut c_void, index: usize, worker: usize) -> i32>;

/// The host's way to run independent tasks, perhaps on several threads.
///
/// `parallel_for` must call `task(data, index, worker)` once for every `index` in `0 .. tasks`, with `worker < workers` and never two calls
/// with the same `worker` at a time, and return after all have returned: 0, or another status, which ends the call and comes back
/// unchanged (a particle step that is already being written is completed first). Results do not depend on the order or on the
/// number of threads, bit for bit.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct mollis_executor {
    /// Passed to `parallel_for`.
    pub context: *mut c_void,
    /// How many tasks may run at a time: 1 to 256. Workspaces are sized for this number; others are refused (`MOLLIS_ERR_OUT_OF_DOMAIN`).
    pub workers: usize,
    /// Runs the tasks.
    pub parallel_for:
        Option<unsafe extern "C" fn(context: *mut c_void, tasks: usize, task: mollis_task, data: *mut c_void) -> i32>,
}

/// Sums modulo 2^64.
pub const MOLLIS_REDUCE_SUM: i32 = 0;
/// The largest.
pub const MOLLIS_REDUCE_MAX: i32 = 1;

/// The processes ("ranks") over which the host has spread the particles of a step, and its way to exchange words among them, for example by MPI
/// (`examples_c/mpi_pks.c` has it in forty lines). The library sends nothing by itself.
///
/// All ranks make the same call with their own particles; what else they pass is the same, the room of arrays included. In it both functions are called in the same order on all of them, from
/// the thread of the call, and return when the rank has its results: 0, or another status, which ends the call and comes back unchanged. They then
/// have to fail on the other ranks, too, which wait for this one.
///
/// An error of one rank ends the call on all: on the others with its status, or with MOLLIS_ERR_EXECUTOR if it is a status of that rank's executor. But a rank whose arguments are refused (null, size, overlap, an unknown value)
/// calls neither function. MOLLIS_ERR_COMMUNICATOR: ranks have different steps, time steps or room.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct mollis_communicator {
    /// Passed to both functions.
    pub context: *mut c_void,
    /// The number of this rank, below `ranks`.
    pub rank: usize,
    /// How many there are, the same on all of them.
    pub ranks: usize,
    /// Replaces each of the words by the sum (MOLLIS_REDUCE_SUM) or the largest (MOLLIS_REDUCE_MAX) of the words at its place on all ranks, which pass as many: MPI_Allreduce
    /// with MPI_IN_PLACE and MPI_UINT64_T.
    pub reduce:
        Option<unsafe extern "C" fn(context: *mut c_void, operation: i32, words: *mut u64, count: usize) -> i32>,
    /// Sends `outgoing[starts[r]]` up to `outgoing[starts[r + 1]]` to each rank r, itself included, and receives what it sends to this one in `incoming[froms[r]]` up to
    /// `incoming[froms[r + 1]]`: MPI_Alltoallv. Both have ranks + 1 elements.
    pub exchange: Option<
        unsafe extern "C" fn(
            context: *mut c_void,
            outgoing: *const u64,
            starts: *const usize,
            incoming: *mut u64,
            froms: *const usize,
        ) -> i32,
    >,
}

/// How a call runs. Fill it with `mollis_run_init`, then change what you want; null means the defaults.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct mollis_run {
    /// Bytes of this structure, as `mollis_run_init` sets it.
    pub size: u32,
    /// The instruction set: `MOLLIS_LEVEL_*`. Default: the best of the machine.
    pub level: i32,
    /// Who runs the tasks; null (the default): the calling thread.
    pub executor: *const mollis_executor,
    /// Asked between tasks, perhaps from several threads; nonzero stops the call with `MOLLIS_ERR_STOPPED`. May be null.
    pub should_stop: Option<unsafe extern "C" fn(context: *mut c_void) -> i32>,
    /// Passed to `should_stop`.
    pub stop_context: *mut c_void,
    /// Where a step or an evaluation that returns `MOLLIS_ERR_NOT_FINITE` writes the index of the first particle (source) with a
    /// coordinate, mass or density that is not finite; targets, tracers count after them. `MOLLIS_NONE_BAD`: it is a parameter, or a sum
    /// that overflows. Not written otherwise. May be null (the default).
    pub first_bad: *mut u64,
    /// Where a step or an evaluation that returns `MOLLIS_ERR_WORKSPACE_TOO_SMALL` writes the bytes of workspace that it needs; 0: it is a prepared
    /// kernel whose buffer is too short (in builds for firmware also 0 from `mollis_pks_step`). Not written otherwise. May be null (the default).
    pub bytes_needed: *mut usize,
    /// The ranks over which the particles of `mollis_pks_step` are spread; other functions do not ask for it. Null (the default): this process has all.
    pub communicator: *const mollis_communicator,
}

options::options!(mollis_run {
    level: MOLLIS_LEVEL_BEST,
    executor: core::ptr::null(),
    should_stop: None,
    stop_context: core::ptr::null_mut(),
    first_bad: core::ptr::null_mut(),
    bytes_needed: core::ptr::null_mut(),
    communicator: core::ptr::null()
});

/// Fills `run` with the defaults. `size` is `sizeof *run`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_run_init(run: *mut mollis_run, size: usize) -> mollis_status {
    // SAFETY: this function's own contract.
    status(unsafe { options::init(run, size) })
}

/// The level of a C number.
pub(crate) fn level(number: i32) -> Result<Level> {
    match number {
        MOLLIS_LEVEL_BEST => Ok(Level::best()),
        MOLLIS_LEVEL_PORTABLE => Ok(Level::Portable),
        MOLLIS_LEVEL_NEON => Ok(Level::Neon),
        MOLLIS_LEVEL_AVX2 => Ok(Level::Avx2),
        MOLLIS_LEVEL_AVX512 => Ok(Level::Avx512),
        _ => Err(Error::UnknownValue),
    }
}

/// The host's `should_stop` as a closure that threads may share.
struct Stop {
    ask: unsafe extern "C" fn(*mut c_void) -> i32,
    context: *mut c_void,
}

// SAFETY: the documentation says that the host's function is called from several threads.
unsafe impl Sync for Stop {}

impl Stop {
    fn asked(&self) -> bool {
        // SAFETY: the host's function, with its own context.
        unsafe { (self.ask)(self.context) != 0 }
    }
}

/// The caller's `mollis_run`, validated and copied.
pub(crate) struct HostRun {
    level: Level,
    executor: Option<Host>,
    stop: Option<Stop>,
    first_bad: Option<Output<u64>>,
    bytes_needed: Option<Output<usize>>,
    ranks: Option<HostRanks>,
}

/// Additional results of a call.
#[derive(Default)]
pub(crate) struct CallReport {
    /// With [`Error::NotFinite`]: the first element that is bad, if it is one.
    pub first_bad: Option<usize>,
    /// With [`Error::WorkspaceTooSmall`]: the bytes that are needed.
    pub bytes_needed: Option<usize>,
    /// With [`Error::Generator`]: the status that the host's generator returned; 0: the error is the library's.
    pub generator: mollis_status,
}

/// Reads a caller's wishes, calls `body` with them and answers with its status: a host's own comes back as it was given, and the first bad
/// element goes where the caller wants it.
///
/// # Safety
/// The crate's contract for `run` and what it points to.
pub(crate) unsafe fn with_run(
    run: *const mollis_run,
    body: impl FnOnce(&HostRun, &mut CallReport) -> Result<()>,
) -> mollis_status {
    // SAFETY: passed on.
    let run = unsafe { HostRun::read(run) };
    let run = match &run {
        Ok(run) => run,
        Err(error) => return status(Err(*error)),
    };
    let mut told = CallReport::default();
    let result = body(run, &mut told);
    let refused = run.refused();
    match result {
        // The library can go on without the executor where it only copies; the call is over all the same.
        Ok(()) | Err(Error::Executor) if refused != 0 => refused,
        Err(Error::Generator) if told.generator != 0 => told.generator,
        Err(Error::Communicator) if run.unsent() != 0 => run.unsent(),
        Err(Error::NotFinite) => {
            // SAFETY: passed on; the body has checked that nothing overlaps it.
            unsafe { put(run.first_bad, told.first_bad.map_or(MOLLIS_NONE_BAD, |index| index as u64)) };
            status(result)
        }
        Err(Error::WorkspaceTooSmall) => {
            // SAFETY: as above.
            unsafe { put(run.bytes_needed, told.bytes_needed.unwrap_or_default()) };
            status(result)
        }
        _ => status(result),
    }
}

impl CallReport {
    /// Refuses a workspace, and says the bytes that are needed.
    pub(crate) fn too_small(&mut self, needed: usize) -> Result<()> {
        self.bytes_needed = Some(needed);
        Err(Error::WorkspaceTooSmall)
    }
}

impl HostRun {
    /// # Safety
    /// The crate's contract for `run` and what it points to.
    pub(crate) unsafe fn read(run: *const mollis_run) -> Result<Self> {
        // SAFETY: passed on.
        let run = unsafe { options::read(run) }?;
        let level = level(run.level)?;
        if !level.is_available() {
            return Err(Error::Unsupported);
        }
        // SAFETY: the caller promises an executor there.
        let executor = unsafe { Host::read(run.executor) }?;
        let stop = run.should_stop.map(|ask| Stop { ask, context: run.stop_context });
        let (first_bad, bytes_needed) = (Output::optional(run.first_bad, 1)?, Output::optional(run.bytes_needed, 1)?);
        // SAFETY: the caller promises a communicator there.
        let ranks = unsafe { HostRanks::read(run.communicator) }?;
        Ok(Self { level, executor, stop, first_bad, bytes_needed, ranks })
    }

    /// Where the first bad element and the bytes that are needed are told: outputs of every call that gets this run.
    pub(crate) fn outputs(&self) -> [Option<Range>; 2] {
        [self.first_bad.map(Output::range), self.bytes_needed.map(Output::range)]
    }

    /// The status that the host's executor returned; 0: none but success.
    pub(crate) fn refused(&self) -> mollis_status {
        self.executor.as_ref().map_or(0, Host::refused)
    }

    /// The status that the host's communicator returned; 0: none but success.
    fn unsent(&self) -> mollis_status {
        self.ranks.as_ref().map_or(0, HostRanks::refused)
    }

    /// Over how many ranks the particles are spread.
    pub(crate) fn ranks(&self) -> usize {
        self.ranks.as_ref().map_or(1, HostRanks::count)
    }

    /// How many workers a workspace must serve.
    pub(crate) fn workers(&self) -> usize {
        self.executor().workers()
    }

    fn executor(&self) -> &dyn Executor {
        match &self.executor {
            Some(host) => host,
            None => &Serial,
        }
    }

    /// Calls `body` with core's view of these wishes.
    pub(crate) fn enter<R>(&self, body: impl FnOnce(&mut Run<'_>) -> R) -> R {
        let stop = self.stop.as_ref().map(|stop| || stop.asked());
        let should_stop = stop.as_ref().map(|stop| stop as &(dyn Fn() -> bool + Sync));
        let communicator = self.ranks.as_ref().map(HostRanks::as_dyn);
        body(&mut Run { level: self.level, executor: self.executor(), should_stop, counters: None, communicator })
    }
}

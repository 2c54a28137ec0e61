//! How a call runs: instruction set, executor, request to stop. Arguments of a call, never stored.

#[cfg_attr(feature = "small", path = "no_executor.rs")]
mod executor;

use core::ffi::c_void;

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
}

options::options!(mollis_run {
    level: MOLLIS_LEVEL_BEST,
    executor: core::ptr::null(),
    should_stop: None,
    stop_context: core::ptr::null_mut(),
    first_bad: core::ptr::null_mut(),
    bytes_needed: core::ptr::null_mut()
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
        Ok(Self { level, executor, stop, first_bad, bytes_needed })
    }

    /// Where the first bad element and the bytes that are needed are told: outputs of every call that gets this run.
    pub(crate) fn outputs(&self) -> [Option<Range>; 2] {
        [self.first_bad.map(Output::range), self.bytes_needed.map(Output::range)]
    }

    /// The status that the host's executor returned; 0: none but success.
    pub(crate) fn refused(&self) -> mollis_status {
        self.executor.as_ref().map_or(0, Host::refused)
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
        body(&mut Run { level: self.level, executor: self.executor(), should_stop, counters: None })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::options::Options;
    use mollis_core::exec::MAX_WORKERS;

    /// A structure of the caller's size only is written, and an older caller's is completed by defaults.
    #[test]
    fn sizes_are_negotiated() {
        let whole = size_of::<mollis_run>();
        let mut bytes = [0xAA_u64; 16];
        let run = bytes.as_mut_ptr().cast::<mollis_run>();
        // SAFETY: `bytes` is larger than the structure and aligned.
        unsafe {
            assert_eq!(mollis_run_init(run, 8), 0);
            assert_eq!((bytes[0], bytes[1]), (8 | u64::from(u32::MAX) << 32, 0xAA));
            assert!(HostRun::read(run).is_ok());
            for (size, code) in [(3, Error::OptionsSize), (whole + 1, Error::OptionsSize)] {
                assert_eq!(mollis_run_init(run, size), code as i32);
                bytes[0] = size as u64;
                assert_eq!(HostRun::read(run).err(), Some(code));
            }
            (*run).size = 0;
            assert_eq!(HostRun::read(run).err(), Some(Error::NotInitialised));
            assert_eq!(mollis_run_init(run, 0), Error::OptionsSize as i32);
            assert_eq!(mollis_run_init(core::ptr::null_mut(), whole), Error::NullPointer as i32);
            assert_eq!(mollis_run_init(run.byte_add(4), whole), Error::Misaligned as i32);
            assert_eq!(mollis_run_init(run, whole), 0);
            for number in [-2, 4, i32::MAX] {
                (*run).level = number;
                assert_eq!(HostRun::read(run).err(), Some(Error::UnknownValue));
            }
            (*run).level = MOLLIS_LEVEL_PORTABLE;
            let read = HostRun::read(run).unwrap();
            assert_eq!((read.workers(), read.enter(|run| run.level)), (1, Level::Portable));
            assert_eq!(HostRun::read(core::ptr::null()).unwrap().enter(|run| run.level), Level::best());
        }
    }

    unsafe extern "C" fn serial(context: *mut c_void, tasks: usize, task: mollis_task, data: *mut c_void) -> i32 {
        // SAFETY: the test passes its counter.
        unsafe { *context.cast::<usize>() += tasks };
        for index in 0..tasks {
            // SAFETY: as mollis asks.
            if let Some(code) = task.map(|task| unsafe { task(data, index, 0) }).filter(|&code| code != 0) {
                return code;
            }
        }
        // The second call fails, with a number that the library uses too.
        // SAFETY: the test passes its counter.
        if unsafe { *context.cast::<usize>() } > 5 { Error::TooLarge as i32 } else { 0 }
    }

    /// What the body says of itself and what the host's functions returned are kept apart by more than their numbers.
    #[test]
    fn a_hosts_status_is_never_taken_for_the_librarys() {
        let mut asked = 0_usize;
        let executor = mollis_executor { context: (&raw mut asked).cast(), workers: 2, parallel_for: Some(serial) };
        let mut bad = 7_u64;
        let run = mollis_run { executor: &raw const executor, first_bad: &raw mut bad, ..mollis_run::DEFAULT };
        let too_large = Error::TooLarge as i32;
        let call = |tasks: usize, generator: i32, result: Result<()>| {
            let body = |host: &HostRun, told: &mut CallReport| {
                *told = CallReport { first_bad: Some(3), generator, ..CallReport::default() };
                host.enter(|run| run.executor.run(tasks, &|_| ())).and(result)
            };
            // SAFETY: all pointers are to live locals.
            unsafe { with_run(&raw const run, body) }
        };
        assert_eq!(call(5, 0, Ok(())), 0);
        assert_eq!(call(0, 0, Err(Error::Executor)), Error::Executor as i32);
        assert_eq!(call(0, 0, Err(Error::Generator)), Error::Generator as i32);
        assert_eq!(call(0, 3, Err(Error::Generator)), 3);
        assert_eq!(call(0, 3, Err(Error::Executor)), Error::Executor as i32);
        assert_eq!(bad, 7);
        assert_eq!((call(0, 3, Err(Error::NotFinite)), bad), (Error::NotFinite as i32, 3));
        assert_eq!(call(1, 0, Err(Error::Delta)), too_large, "the executor's error came first");
        let swallowed = |host: &HostRun, _: &mut CallReport| {
            assert!(host.enter(|run| run.executor.run(1, &|_| ())).is_err());
            Ok(())
        };
        // SAFETY: as above.
        assert_eq!(unsafe { with_run(&raw const run, swallowed) }, too_large);
        let other = |host: &HostRun, _: &mut CallReport| {
            assert!(host.enter(|run| run.executor.run(1, &|_| ())).is_err());
            Err(Error::EventsFull)
        };
        // SAFETY: as above.
        assert_eq!(unsafe { with_run(&raw const run, other) }, Error::EventsFull as i32);
    }

    #[test]
    fn a_host_executor_runs_every_task_and_its_status_comes_back() {
        let mut asked = 0_usize;
        let mut executor = mollis_executor { context: (&raw mut asked).cast(), workers: 2, parallel_for: Some(serial) };
        let mut run = mollis_run { executor: &raw const executor, ..mollis_run::DEFAULT };
        let count = std::sync::atomic::AtomicUsize::new(0);
        // SAFETY: all pointers are to live locals.
        let host = unsafe { HostRun::read(&raw const run) }.unwrap();
        assert_eq!(host.workers(), 2);
        let again = |tasks| {
            host.enter(|run| {
                run.executor.run(tasks, &|worker| {
                    assert_eq!(worker, 0);
                    count.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
                })
            })
        };
        assert_eq!(again(5), Ok(()));
        assert_eq!((again(3), host.refused()), (Err(Error::Executor), Error::TooLarge as i32));
        assert_eq!(count.into_inner(), 8);
        for (workers, parallel_for, error) in [
            (0, Some(serial as _), Error::OutOfDomain),
            (MAX_WORKERS + 1, Some(serial as _), Error::OutOfDomain),
            (1, None, Error::NullPointer),
        ] {
            executor = mollis_executor { workers, parallel_for, ..executor };
            run.executor = &raw const executor;
            // SAFETY: as above.
            assert_eq!(unsafe { HostRun::read(&raw const run) }.err(), Some(error));
        }
    }
}

//! The host's executor.

use core::ffi::c_void;
use core::sync::atomic::{AtomicI32, Ordering};

use mollis_core::exec::{Executor, MAX_WORKERS};
use mollis_core::{Error, Result};

use super::{mollis_executor, mollis_task};
use crate::status::mollis_status;

/// The host's executor as core's, remembering a status that it returned: that is no error of the library's, whatever its number.
pub(super) struct Host {
    executor: mollis_executor,
    parallel_for: unsafe extern "C" fn(*mut c_void, usize, mollis_task, *mut c_void) -> i32,
    refused: AtomicI32,
}

impl Host {
    /// The host's executor, if there is one.
    ///
    /// # Safety
    /// The crate's contract for `executor`.
    pub unsafe fn read(executor: *const mollis_executor) -> Result<Option<Self>> {
        if executor.is_null() {
            return Ok(None);
        }
        if !executor.is_aligned() {
            return Err(Error::Misaligned);
        }
        // SAFETY: not null, aligned, and the caller promises an executor there.
        let executor = unsafe { *executor };
        let parallel_for = executor.parallel_for.ok_or(Error::NullPointer)?;
        if !(1..=MAX_WORKERS).contains(&executor.workers) {
            return Err(Error::OutOfDomain);
        }
        Ok(Some(Self { executor, parallel_for, refused: AtomicI32::new(0) }))
    }

    /// The status that it returned; 0: none but success.
    pub fn refused(&self) -> mollis_status {
        self.refused.load(Ordering::Relaxed)
    }
}

// SAFETY: the context is only passed on to the host's own function, from the thread that called mollis.
unsafe impl Sync for Host {}

impl Executor for Host {
    fn workers(&self) -> usize {
        self.executor.workers
    }

    fn run(&self, tasks: usize, task: &(dyn Fn(usize) + Sync)) -> Result<()> {
        unsafe extern "C" fn enter(data: *mut c_void, _index: usize, worker: usize) -> i32 {
            // SAFETY: `data` is the pointer to `task` below, alive until `parallel_for` returns.
            let task = unsafe { *data.cast::<&(dyn Fn(usize) + Sync)>() };
            task(worker);
            0
        }
        let data = (&raw const task).cast_mut().cast::<c_void>();
        // SAFETY: the host's function, with what its contract says.
        match unsafe { (self.parallel_for)(self.executor.context, tasks, Some(enter), data) } {
            0 => Ok(()),
            status => {
                self.refused.store(status, Ordering::Relaxed);
                Err(Error::Executor)
            }
        }
    }
}

//! The executor a host passes to a call: parallelism is the host's, never the library's.
//!
//! Work is split into tasks whose number depends on the problem's size alone, never on the executor, so results are bit
//! for bit the same for any number of threads. Tasks are independent and may run in any order.

use crate::error::Result;

/// Runs independent tasks, perhaps on several threads.
///
/// Soundness does not depend on an implementation being right: mollis counts task indices itself, so a task that is
/// started too often does nothing and one that is never started is reported as [`crate::Error::Executor`].
pub trait Executor: Sync {
    /// How many tasks may run at the same time, 1 to [`MAX_WORKERS`](crate::exec::MAX_WORKERS); workers beyond are refused tasks. Scratch
    /// memory is this many times a task's need.
    fn workers(&self) -> usize;

    /// Calls `task(worker)` exactly `tasks` times, with `worker < self.workers()` and never two calls with the same
    /// `worker` at a time; returns when all have returned.
    ///
    /// # Errors
    /// What the host's pool reports; it ends the call and comes back unchanged. (A step of coalescing particles whose result is being copied is
    /// completed without the executor.)
    fn run(&self, tasks: usize, task: &(dyn Fn(usize) + Sync)) -> Result<()>;
}

/// Runs everything in the calling thread, in order.
#[derive(Clone, Copy, Debug, Default)]
pub struct Serial;

impl Executor for Serial {
    fn workers(&self) -> usize {
        1
    }

    fn run(&self, tasks: usize, task: &(dyn Fn(usize) + Sync)) -> Result<()> {
        for _ in 0..tasks {
            task(0);
        }
        Ok(())
    }
}

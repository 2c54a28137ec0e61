//! The executor that a host passes to a call. The library itself starts no threads.
//!
//! Work is split into tasks. Their number depends on the problem's size alone, never on the executor, so results are bit
//! for bit the same for any number of threads. Tasks are independent and may run in any order.

use crate::error::Result;

/// Runs independent tasks, perhaps on several threads.
///
/// Soundness does not depend on the implementation. mollis counts task indices itself: a task that is
/// started too often does nothing, and one that is never started is reported as [`crate::Error::Executor`].
pub trait Executor: Sync {
    /// The number of tasks that may run at the same time, 1 to [`MAX_WORKERS`](crate::exec::MAX_WORKERS). Workers beyond get no tasks.
    /// The scratch memory of a task is allocated once per worker.
    fn workers(&self) -> usize;

    /// Calls `task(worker)` exactly `tasks` times with `worker < self.workers()`, and never two calls with the same
    /// `worker` at the same time. Returns when all calls have returned.
    ///
    /// # Errors
    /// The error of the host's pool. It ends the call and is returned unchanged. (Exception: a step of coalescing particles that is already
    /// copying its result completes without the executor.)
    fn run(&self, tasks: usize, task: &(dyn Fn(usize) + Sync)) -> Result<()>;
}

/// Runs all tasks in the calling thread, in order.
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

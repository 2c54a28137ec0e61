//! An executor over a rayon pool.

use mollis_core::parallel::Executor;
use mollis_core::{Error, Result};

/// Threads that run the tasks of a call.
#[derive(Debug)]
pub struct Pool {
    threads: rayon::ThreadPool,
}

impl Pool {
    /// A pool of so many threads; 0 takes as many as the machine has.
    ///
    /// # Errors
    /// [`Error::Executor`]: the system gives no threads.
    pub fn new(threads: usize) -> Result<Self> {
        let builder = rayon::ThreadPoolBuilder::new().num_threads(threads.min(mollis_core::space::MAX_WORKERS));
        Ok(Self { threads: builder.build().map_err(|_| Error::Executor)? })
    }
}

impl Executor for Pool {
    fn workers(&self) -> usize {
        self.threads.current_num_threads().clamp(1, mollis_core::space::MAX_WORKERS)
    }

    fn run(&self, tasks: usize, task: &(dyn Fn(usize) + Sync)) -> Result<()> {
        let left = std::sync::atomic::AtomicUsize::new(tasks);
        let take = || {
            let step = |n: usize| n.checked_sub(1);
            left.fetch_update(std::sync::atomic::Ordering::Relaxed, std::sync::atomic::Ordering::Relaxed, step).is_ok()
        };
        self.threads.broadcast(|context| {
            while context.index() < self.workers() && take() {
                task(context.index());
            }
        });
        Ok(())
    }
}

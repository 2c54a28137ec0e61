//! Threads as an executor.

use std::sync::atomic::{AtomicUsize, Ordering};

use mollis_core::exec::{Executor, MAX_WORKERS};
use mollis_core::{Error, Result};

/// Threads that run the tasks of a call. Any number of threads may use one pool at a time.
#[derive(Debug)]
pub struct Pool {
    threads: rayon::ThreadPool,
}

impl Pool {
    /// A pool of so many threads; 0 takes as many as the machine has. At most [`MAX_WORKERS`].
    ///
    /// # Errors
    /// [`Error::Executor`]: the system gives no threads.
    pub fn new(threads: usize) -> Result<Self> {
        let wanted = match threads {
            0 => std::thread::available_parallelism().map_or(1, usize::from),
            n => n,
        };
        let builder = rayon::ThreadPoolBuilder::new().num_threads(wanted.min(MAX_WORKERS));
        Ok(Self { threads: builder.build().map_err(|_| Error::Executor)? })
    }

    /// Calls `task(index, worker)` once for every index below `tasks`; each thread takes the next one when it is free. The
    /// calling thread runs a single task itself, and all of them where the pool has one thread.
    pub fn each(&self, tasks: usize, task: &(dyn Fn(usize, usize) + Sync)) {
        if tasks <= 1 || self.workers() == 1 {
            (0..tasks).for_each(|index| task(index, 0));
            return;
        }
        let next = AtomicUsize::new(0);
        self.threads.broadcast(|context| {
            loop {
                let index = next.fetch_add(1, Ordering::Relaxed);
                if index >= tasks {
                    break;
                }
                task(index, context.index());
            }
        });
    }
}

impl Executor for Pool {
    fn workers(&self) -> usize {
        self.threads.current_num_threads()
    }

    fn run(&self, tasks: usize, task: &(dyn Fn(usize) + Sync)) -> Result<()> {
        self.each(tasks, &|_, worker| task(worker));
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_task_once() {
        for threads in [0, 1, 2, 3] {
            let pool = Pool::new(threads).unwrap();
            for tasks in [0, 1, 2, 100] {
                let count: Vec<AtomicUsize> = (0..tasks).map(|_| AtomicUsize::new(0)).collect();
                pool.each(tasks, &|index, worker| {
                    assert!(worker < pool.workers());
                    count[index].fetch_add(1, Ordering::Relaxed);
                });
                assert!(count.iter().all(|c| c.load(Ordering::Relaxed) == 1));
            }
        }
    }

    #[test]
    fn one_task_runs_in_the_calling_thread() {
        let caller = std::thread::current().id();
        for (threads, tasks) in [(1, 1), (1, 100), (2, 1), (3, 1)] {
            let pool = Pool::new(threads).unwrap();
            pool.each(tasks, &|_, worker| assert_eq!((worker, std::thread::current().id()), (0, caller)));
        }
    }

    /// A machine may have more processors than the library uses.
    #[test]
    fn a_pool_has_no_more_threads_than_are_used() {
        assert_eq!(Pool::new(MAX_WORKERS + 1).unwrap().workers(), MAX_WORKERS);
    }
}

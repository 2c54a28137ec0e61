//! What a host gives the library: threads and the wish to stop.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use anyhow::{Context, Result};
use mollis_core::exec::Executor;
use mollis_core::exec::MAX_WORKERS;

/// A pool of threads as an executor.
pub struct Pool {
    pool: rayon::ThreadPool,
}

impl Pool {
    /// A pool of this many threads; 0 takes as many as the machine has. At most [`MAX_WORKERS`]: the library uses no more, and
    /// gives the others no task.
    pub fn new(threads: usize) -> Result<Self> {
        let wanted = match threads {
            0 => std::thread::available_parallelism().map_or(1, usize::from),
            threads => threads,
        };
        let builder = rayon::ThreadPoolBuilder::new().num_threads(wanted.min(MAX_WORKERS));
        Ok(Self { pool: builder.build().context("--threads")? })
    }
}

impl Executor for Pool {
    fn workers(&self) -> usize {
        self.pool.current_num_threads()
    }

    fn run(&self, tasks: usize, task: &(dyn Fn(usize) + Sync)) -> mollis_core::Result<()> {
        if tasks <= 1 || self.workers() == 1 {
            for _ in 0..tasks {
                task(0);
            }
            return Ok(());
        }
        let started = AtomicUsize::new(0);
        self.pool.broadcast(|worker| {
            while started.fetch_add(1, Ordering::Relaxed) < tasks {
                task(worker.index());
            }
        });
        Ok(())
    }
}

/// Set by Ctrl-C and by a request to end.
static STOP: AtomicBool = AtomicBool::new(false);

/// Turns Ctrl-C, SIGTERM and SIGHUP into a wish; the second one ends the program at once.
pub fn listen() -> Result<()> {
    ctrlc::set_handler(|| {
        if STOP.swap(true, Ordering::Relaxed) {
            std::process::exit(130);
        }
    })
    .context("cannot listen for Ctrl-C")
}

/// Whether the run should stop.
pub fn stopped() -> bool {
    STOP.load(Ordering::Relaxed)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A machine may have more processors than the library uses.
    #[test]
    fn a_pool_has_no_more_threads_than_are_used() {
        let pool = Pool::new(MAX_WORKERS + 1).unwrap();
        assert_eq!(pool.workers(), MAX_WORKERS);
    }

    #[test]
    fn every_task_runs_once() {
        for threads in [1, 2, 3] {
            let pool = Pool::new(threads).unwrap();
            for tasks in [0, 1, 2, 100] {
                let counts: Vec<AtomicUsize> = (0..tasks).map(|_| AtomicUsize::new(0)).collect();
                let next = AtomicUsize::new(0);
                pool.run(tasks, &|worker| {
                    assert!(worker < pool.workers());
                    counts[next.fetch_add(1, Ordering::Relaxed)].fetch_add(1, Ordering::Relaxed);
                })
                .unwrap();
                assert!(counts.iter().all(|count| count.load(Ordering::Relaxed) == 1));
            }
        }
    }
}

//! The pool in C.
#![expect(unsafe_code, reason = "the C boundary")]
#![allow(non_camel_case_types, reason = "names in C")]

use core::ffi::c_void;
use std::sync::atomic::{AtomicI32, Ordering};

use mollis_abi::{mollis_executor, mollis_status, mollis_task};
use mollis_core::Error;
use mollis_core::exec::Executor;

use crate::Pool;

/// A pool of threads. Opaque in C.
pub struct mollis_pool(Pool);

/// Starts a pool of `threads` threads (0: as many as the machine has, at most 256) and sets `*pool`.
///
/// # Safety
/// `pool` is null or writable. End the pool with `mollis_pool_free`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_pool_init(threads: usize, pool: *mut *mut mollis_pool) -> mollis_status {
    if pool.is_null() {
        return Error::NullPointer as i32;
    }
    match Pool::new(threads) {
        Ok(made) => {
            // SAFETY: not null, and writable by the contract.
            unsafe { pool.write(Box::into_raw(Box::new(mollis_pool(made)))) };
            0
        }
        Err(error) => error as i32,
    }
}

/// Sets `*executor` to run tasks on the pool: put its address into `mollis_run`. It is valid as long as the pool.
///
/// # Safety
/// `pool` comes from `mollis_pool_init`; `executor` is writable. Either may be null, which is refused.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_pool_executor(
    pool: *const mollis_pool,
    executor: *mut mollis_executor,
) -> mollis_status {
    // SAFETY: null or a pool, by the contract.
    let Some(mollis_pool(inner)) = (unsafe { pool.as_ref() }) else { return Error::NullPointer as i32 };
    if executor.is_null() {
        return Error::NullPointer as i32;
    }
    let made =
        mollis_executor { context: pool.cast_mut().cast(), workers: inner.workers(), parallel_for: Some(parallel_for) };
    // SAFETY: not null, and writable by the contract.
    unsafe { executor.write(made) };
    0
}

/// Ends the pool's threads. Null is ignored.
///
/// # Safety
/// `pool` comes from `mollis_pool_init`, is not used by a running call and is not used again.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_pool_free(pool: *mut mollis_pool) {
    if !pool.is_null() {
        // SAFETY: made by `Box::into_raw`, and freed once.
        drop(unsafe { Box::from_raw(pool) });
    }
}

/// The data of `task`, shared by threads.
struct Tasks {
    task: unsafe extern "C" fn(*mut c_void, usize, usize) -> i32,
    data: *mut c_void,
}

// SAFETY: mollis passes tasks that may run on any thread.
unsafe impl Sync for Tasks {}

impl Tasks {
    fn run(&self, index: usize, worker: usize) -> i32 {
        // SAFETY: the contract of the executor.
        unsafe { (self.task)(self.data, index, worker) }
    }
}

unsafe extern "C" fn parallel_for(context: *mut c_void, tasks: usize, task: mollis_task, data: *mut c_void) -> i32 {
    // SAFETY: the context was set by `mollis_pool_executor`.
    let pool = unsafe { context.cast::<mollis_pool>().as_ref() };
    let (Some(mollis_pool(pool)), Some(task)) = (pool, task) else { return Error::NullPointer as i32 };
    let (all, first) = (Tasks { task, data }, AtomicI32::new(0));
    pool.each(tasks, &|index, worker| {
        let code = all.run(index, worker);
        if code != 0 {
            first.store(code, Ordering::Relaxed);
        }
    });
    first.into_inner()
}

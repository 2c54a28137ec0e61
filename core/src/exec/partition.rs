//! Division of outputs and scratch among tasks.
//!
//! [`par_chunks`] gives every task the piece of the outputs with its index, and a piece of the scratch that no other
//! running task has. Atomics ensure exclusive access to both, whatever the host's executor does.

use core::marker::PhantomData;
use core::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use crate::error::{Error, Result};
use crate::exec::Executor;

/// Data that can be divided into disjoint pieces by index.
///
/// # Safety
/// Pieces with different indices must not overlap.
#[expect(unsafe_code, reason = "implementors promise disjoint pieces")]
pub unsafe trait Partition: Sync {
    /// One piece. Its lifetime ends with the task that receives it.
    type Piece<'p>;

    /// The piece with this index; empty beyond the end.
    ///
    /// # Safety
    /// No two pieces of the same index may exist at the same time, and none when the divided data is used again. The caller guarantees `'p`.
    unsafe fn piece<'p>(&self, index: usize) -> Self::Piece<'p>;
}

/// A slice, divided into chunks of a fixed length (the last may be shorter).
#[derive(Debug)]
pub struct Chunks<'a, T> {
    start: *mut T,
    len: usize,
    each: usize,
    owner: PhantomData<&'a mut [T]>,
}

impl<'a, T> Chunks<'a, T> {
    /// Divides `slice` into chunks of `each` elements.
    pub fn new(slice: &'a mut [T], each: usize) -> Self {
        Self { start: slice.as_mut_ptr(), len: slice.len(), each, owner: PhantomData }
    }
}

// SAFETY: a `Chunks` is the mutable borrow of a slice; pieces reach other threads, so `T: Send`.
#[expect(unsafe_code, reason = "an exclusive borrow, handed out in disjoint pieces")]
unsafe impl<T: Send> Sync for Chunks<'_, T> {}
// SAFETY: as above.
#[expect(unsafe_code, reason = "an exclusive borrow, handed out in disjoint pieces")]
unsafe impl<T: Send> Send for Chunks<'_, T> {}

// SAFETY: chunks of different index are disjoint ranges of one slice.
#[expect(unsafe_code, reason = "disjoint ranges of one slice")]
unsafe impl<T: Send + 'static> Partition for Chunks<'_, T> {
    type Piece<'p> = &'p mut [T];

    unsafe fn piece<'p>(&self, index: usize) -> &'p mut [T] {
        let from = index.saturating_mul(self.each).min(self.len);
        let len = self.each.min(self.len - from);
        // SAFETY: from + len <= self.len, in the slice borrowed here; the caller takes each index once at a time.
        unsafe { core::slice::from_raw_parts_mut(self.start.add(from), len) }
    }
}

/// A slice, divided at positions given by the caller.
#[derive(Debug)]
pub struct Ranges<'a, T> {
    whole: Chunks<'a, T>,
    /// Ascending, none beyond the end of the slice.
    starts: &'a [u32],
}

impl<'a, T> Ranges<'a, T> {
    /// Divides `slice`: piece k is `starts[k]..starts[k + 1]`. Pieces beyond the last start are empty.
    ///
    /// # Errors
    /// [`Error::LengthMismatch`]: the starts are not ascending, or one is beyond the end.
    pub fn new(slice: &'a mut [T], starts: &'a [u32]) -> Result<Self> {
        // Not `is_sorted`, which contains a panic path.
        let ascending = starts.iter().zip(starts.iter().skip(1)).all(|(a, b)| a <= b);
        if ascending && starts.last().is_none_or(|&last| last as usize <= slice.len()) {
            Ok(Self { whole: Chunks::new(slice, 1), starts })
        } else {
            Err(Error::LengthMismatch)
        }
    }
}

// SAFETY: the starts ascend, so ranges of different index are disjoint.
#[expect(unsafe_code, reason = "disjoint ranges of one slice")]
unsafe impl<T: Send + 'static> Partition for Ranges<'_, T> {
    type Piece<'p> = &'p mut [T];

    unsafe fn piece<'p>(&self, index: usize) -> &'p mut [T] {
        let (from, to) = match (self.starts.get(index), self.starts.get(index.saturating_add(1))) {
            (Some(&from), Some(&to)) => (from as usize, to as usize),
            _ => (0, 0),
        };
        // SAFETY: from <= to <= the slice's length, checked by `new`; the caller takes each index once at a time.
        unsafe { core::slice::from_raw_parts_mut(self.whole.start.add(from), to - from) }
    }
}

// SAFETY: as for the inner one.
#[expect(unsafe_code, reason = "passes on the inner promise")]
unsafe impl<D: Partition> Partition for Option<D> {
    type Piece<'p> = Option<D::Piece<'p>>;

    unsafe fn piece<'p>(&self, index: usize) -> Self::Piece<'p> {
        // SAFETY: the caller guarantees it.
        self.as_ref().map(|d| unsafe { d.piece(index) })
    }
}

macro_rules! partition_tuple {
    ($($name:ident)*) => {
        // SAFETY: each part satisfies the contract, and parts are different borrows.
        #[expect(unsafe_code, reason = "passes on the parts' promises")]
        unsafe impl<$($name: Partition),*> Partition for ($($name,)*) {
            type Piece<'p> = ($($name::Piece<'p>,)*);

            #[expect(non_snake_case, reason = "a tuple's parts are named by their types")]
            #[allow(clippy::unused_unit, reason = "the empty tuple is the empty piece")]
            unsafe fn piece<'p>(&self, _index: usize) -> Self::Piece<'p> {
                let ($($name,)*) = self;
                // SAFETY: the caller guarantees it.
                ($(unsafe { $name.piece(_index) },)*)
            }
        }
    };
}
partition_tuple!(A);
partition_tuple!(A B);
partition_tuple!(A B C);
partition_tuple!(A B C D);
partition_tuple!(A B C D E);
partition_tuple!(A B C D E F);

/// No outputs, or no scratch.
// SAFETY: there are no elements that could overlap.
#[expect(unsafe_code, reason = "empty pieces")]
unsafe impl Partition for () {
    type Piece<'p> = ();

    unsafe fn piece<'p>(&self, _index: usize) -> Self::Piece<'p> {}
}

/// The largest number of workers used, whatever an executor reports. Their flags are on the stack.
pub const MAX_WORKERS: usize = 256;

/// The body of a task, called with its index, its piece of the outputs and its worker's piece of the scratch.
pub type Body<'b, O, S> =
    dyn for<'p> Fn(usize, <O as Partition>::Piece<'p>, <S as Partition>::Piece<'p>) -> Result<()> + Sync + 'b;

/// Runs `body(task, piece of the outputs, piece of the scratch)` for every task in `0..tasks`, through the executor.
///
/// `scratch` must hold one piece per worker of the executor. When several tasks fail, the error of the lowest
/// task index is returned. Whether later tasks still ran is then not defined, so the outputs are undefined.
///
/// A piece can't be moved out of its task:
///
/// ```compile_fail,E0521
/// use mollis_core::exec::{Chunks, Serial, par_chunks};
/// use std::sync::Mutex;
/// let (mut out, kept) = (vec![0; 8], Mutex::new(Vec::new()));
/// par_chunks(&Serial, 2, Chunks::new(&mut out, 4), (), &|_, piece, ()| {
///     kept.lock().unwrap().push(piece);
///     Ok(())
/// });
/// ```
///
/// # Errors
/// The first error by task index; [`Error::Executor`] when the executor skipped tasks or ran more at a time than it
/// reported; the executor's own error.
#[expect(unsafe_code, reason = "hands each claimed piece to one task")]
pub fn par_chunks<'b, O: Partition + 'b, S: Partition + 'b>(
    executor: &dyn Executor,
    tasks: usize,
    outputs: O,
    scratch: S,
    body: &'b Body<'b, O, S>,
) -> Result<()> {
    let (outputs, scratch) = (&outputs, &scratch);
    let next = AtomicUsize::new(0);
    let done = AtomicUsize::new(0);
    let broken = AtomicBool::new(false);
    // The lowest index of a failed task and its error code, in one word, so that no lock is needed: the minimum
    // over the tasks of (task, code) is kept. Codes fit in 8 bits.
    let first_error = AtomicUsize::new(usize::MAX);
    let workers = executor.workers().clamp(1, MAX_WORKERS);
    let busy: [AtomicBool; MAX_WORKERS] = [const { AtomicBool::new(false) }; MAX_WORKERS];

    executor.run(tasks, &|worker: usize| {
        let task = next.fetch_add(1, Ordering::Relaxed);
        if task >= tasks {
            return;
        }
        let Some(slot) = busy.get(worker).filter(|_| worker < workers) else {
            broken.store(true, Ordering::Relaxed);
            return;
        };
        if slot.swap(true, Ordering::Acquire) {
            broken.store(true, Ordering::Relaxed);
            return;
        }
        // SAFETY: `next` gives each task index once. `slot` gives the worker's scratch to one running task. The body accepts pieces of any
        // lifetime, so it keeps none, and both arguments are exclusive to this call.
        let (output, scratch) = unsafe { (outputs.piece(task), scratch.piece(worker)) };
        if let Err(error) = body(task, output, scratch) {
            let word = task.saturating_mul(256).saturating_add(error as usize);
            first_error.fetch_min(word, Ordering::Relaxed);
        }
        slot.store(false, Ordering::Release);
        done.fetch_add(1, Ordering::Release);
    })?;

    let word = first_error.load(Ordering::Relaxed);
    if word != usize::MAX {
        return Err(Error::from_code((word % 256) as i32).unwrap_or(Error::Executor));
    }
    if broken.load(Ordering::Relaxed) || done.load(Ordering::Acquire) != tasks {
        return Err(Error::Executor);
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::exec::Serial;
    use std::vec;

    /// Runs tasks on two threads, optionally violating the contract.
    struct Threads {
        repeat: usize,
        same_worker: bool,
    }

    impl Executor for Threads {
        fn workers(&self) -> usize {
            2
        }
        fn run(&self, tasks: usize, task: &(dyn Fn(usize) + Sync)) -> Result<()> {
            std::thread::scope(|scope| {
                for worker in 0..2 {
                    scope.spawn(move || {
                        for _ in 0..(tasks * self.repeat).div_ceil(2) {
                            task(if self.same_worker { 0 } else { worker });
                        }
                    });
                }
            });
            Ok(())
        }
    }

    #[test]
    fn every_piece_once_whatever_the_executor_does() {
        for n in [0, 1, 7, 8, 9, 100] {
            for executor in [Threads { repeat: 1, same_worker: false }, Threads { repeat: 3, same_worker: false }] {
                let mut out = vec![0_u32; n];
                let tasks = n.div_ceil(8);
                par_chunks(&executor, tasks, Chunks::new(&mut out, 8), (), &|task, piece, ()| {
                    piece.iter_mut().for_each(|v| *v += 1 + task as u32);
                    Ok(())
                })
                .unwrap();
                assert!(out.iter().enumerate().all(|(i, &v)| v == 1 + (i / 8) as u32));
            }
        }
    }

    #[test]
    fn ranges_are_where_they_are_told_and_never_overlap() {
        let starts = [0, 0, 3, 4, 4, 9];
        let mut out = vec![0_u32; 10];
        let executor = Threads { repeat: 1, same_worker: false };
        // Pieces beyond the last start are empty.
        par_chunks(&executor, 7, Ranges::new(&mut out, &starts).unwrap(), (), &|task, piece, ()| {
            piece.iter_mut().for_each(|v| *v += 1 + task as u32);
            Ok(())
        })
        .unwrap();
        assert_eq!(out, [2, 2, 2, 3, 5, 5, 5, 5, 5, 0]);
        assert!(Ranges::new(&mut out, &[0, 3, 2]).is_err() && Ranges::new(&mut out, &[0, 11]).is_err());
        assert!(Ranges::new(&mut out, &[]).is_ok());
    }

    #[test]
    fn the_first_error_by_index_wins_and_skipped_tasks_are_reported() {
        let fail = |task: usize, (): (), (): ()| match task {
            3 => Err(Error::Delta),
            5 => Err(Error::Order),
            _ => Ok(()),
        };
        assert_eq!(par_chunks(&Serial, 9, (), (), &fail), Err(Error::Delta));
        struct Lazy;
        impl Executor for Lazy {
            fn workers(&self) -> usize {
                1
            }
            fn run(&self, _: usize, _: &(dyn Fn(usize) + Sync)) -> Result<()> {
                Ok(())
            }
        }
        assert_eq!(par_chunks(&Lazy, 1, (), (), &|_, (), ()| Ok(())), Err(Error::Executor));
    }

    #[test]
    fn a_worker_index_used_twice_at_a_time_never_shares_scratch() {
        let mut scratch = vec![0_u64; 2];
        let executor = Threads { repeat: 1, same_worker: true };
        let result = par_chunks(&executor, 64, (), Chunks::new(&mut scratch, 1), &|_, (), mine: &mut [u64]| {
            let before = mine[0];
            std::thread::yield_now();
            mine[0] = before + 1;
            Ok(())
        });
        assert!(result == Ok(()) && scratch[0] == 64 || result == Err(Error::Executor));
    }
}

//! The communicator that a host passes to a call whose particles are spread over several processes. The library itself sends nothing.

use core::cell::Cell;

use crate::error::{Error, Result};

/// What [`Communicator::reduce`] makes of the words of all ranks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reduction {
    /// Their sum modulo 2^64, which depends on no order.
    Sum,
    /// The largest.
    Max,
}

/// Exchanges words among ranks, perhaps by MPI.
///
/// Every rank makes the same calls in the same order, each of them with the words of its own. A call returns when the rank has its results.
///
/// ```
/// use mollis_core::Result;
/// use mollis_core::exec::{Communicator, Reduction};
///
/// /// One rank alone.
/// struct Alone;
///
/// impl Communicator for Alone {
///     fn rank(&self) -> usize {
///         0
///     }
///     fn ranks(&self) -> usize {
///         1
///     }
///     fn reduce(&self, _: Reduction, _: &mut [u64]) -> Result<()> {
///         Ok(())
///     }
///     fn exchange(&self, outgoing: &[u64], _: &[usize], incoming: &mut [u64], _: &[usize]) -> Result<()> {
///         incoming.copy_from_slice(outgoing);
///         Ok(())
///     }
/// }
/// ```
pub trait Communicator {
    /// The number of the caller, below [`Communicator::ranks`].
    fn rank(&self) -> usize;

    /// How many ranks there are, at least 1; the same on all of them.
    fn ranks(&self) -> usize;

    /// Replaces each word by the reduction of the words at its place on all ranks, which pass as many.
    ///
    /// # Errors
    /// The error of the host, which ends the call and is returned unchanged. The other ranks' calls then have to fail, too: they wait for this one.
    fn reduce(&self, reduction: Reduction, words: &mut [u64]) -> Result<()>;

    /// Sends `outgoing[starts[r]..starts[r + 1]]` to rank r, itself included, and receives `incoming[froms[r]..froms[r + 1]]` from it: what that sends to this one, which is as long.
    /// Both have one start more than there are ranks.
    ///
    /// # Errors
    /// As [`Communicator::reduce`].
    fn exchange(&self, outgoing: &[u64], starts: &[usize], incoming: &mut [u64], froms: &[usize]) -> Result<()>;
}

/// The ranks of a call: an error of one of them ends the call on all.
pub(crate) struct Ranks<'a> {
    communicator: &'a dyn Communicator,
    /// The call has ended on all ranks, and none waits for another.
    ended: Cell<bool>,
}

impl<'a> Ranks<'a> {
    pub fn new(communicator: &'a dyn Communicator) -> Self {
        Self { communicator, ended: Cell::new(false) }
    }

    /// The number of this rank.
    pub fn rank(&self) -> usize {
        self.communicator.rank()
    }

    /// How many there are: one at least, also for the compiler, as what is divided by it would be a way to panic.
    pub fn count(&self) -> usize {
        self.communicator.ranks().max(1)
    }

    /// The result of this rank if all ranks have one. Else its own error, or one of the others'.
    ///
    /// Whatever may have failed on one rank alone is agreed upon before the next exchange.
    pub fn agree<X>(&self, result: Result<X>) -> Result<X> {
        if self.ended.get() {
            return result;
        }
        let mut code = [result.as_ref().err().map_or(0, |&error| error as u64)];
        self.reduce(Reduction::Max, &mut code)?;
        let [code] = code;
        if code == 0 {
            return result;
        }
        self.ended.set(true);
        result.and(Err(i32::try_from(code).ok().and_then(Error::from_code).unwrap_or(Error::Communicator)))
    }

    /// As [`Communicator::reduce`].
    pub fn reduce(&self, reduction: Reduction, words: &mut [u64]) -> Result<()> {
        self.noted(self.communicator.reduce(reduction, words))
    }

    /// As [`Communicator::exchange`].
    pub fn exchange(&self, outgoing: &[u64], starts: &[usize], incoming: &mut [u64], froms: &[usize]) -> Result<()> {
        self.noted(self.communicator.exchange(outgoing, starts, incoming, froms))
    }

    /// Writes the words of all ranks, as many on each, into `all`, in the order of the ranks.
    pub fn gather(&self, mine: &[u64], all: &mut [u64]) -> Result<()> {
        all.fill(0);
        let at = self.rank().saturating_mul(mine.len());
        for (to, word) in all.iter_mut().skip(at).zip(mine) {
            *to = *word;
        }
        self.reduce(Reduction::Sum, all)
    }

    fn noted(&self, result: Result<()>) -> Result<()> {
        self.ended.set(self.ended.get() || result.is_err());
        result
    }
}

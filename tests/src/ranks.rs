//! Ranks as threads of one process.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Barrier, Mutex};

use mollis_core::exec::{Communicator, Reduction};
use mollis_core::{Error, Result};

/// The kind of a call, its words, where those for each rank begin.
type Offer = (u8, Vec<u64>, Vec<usize>);

/// What the ranks have in common.
#[derive(Debug)]
pub struct World {
    barrier: Barrier,
    /// What each rank offers in the call that is under way.
    offers: Vec<Mutex<Offer>>,
    fails_at: usize,
}

impl World {
    /// So many ranks.
    #[must_use]
    pub fn new(ranks: usize) -> Self {
        Self::failing(ranks, usize::MAX)
    }

    /// So many ranks, whose call of this number fails on all of them.
    #[must_use]
    pub fn failing(ranks: usize, fails_at: usize) -> Self {
        Self { barrier: Barrier::new(ranks), offers: (0..ranks).map(|_| Mutex::default()).collect(), fails_at }
    }

    /// Calls the body once for each rank, in threads of their own; the results in the order of the ranks.
    ///
    /// # Panics
    /// If the body does.
    pub fn run<R: Send>(&self, body: impl Fn(&Rank<'_>) -> R + Sync) -> Vec<R> {
        std::thread::scope(|scope| {
            let body = &body;
            let start = |rank| {
                scope.spawn(move || {
                    body(&Rank { world: self, rank, calls: AtomicUsize::new(0), words: AtomicUsize::new(0) })
                })
            };
            let threads: Vec<_> = (0..self.offers.len()).map(start).collect();
            threads.into_iter().map(|thread| thread.join().unwrap()).collect()
        })
    }
}

/// One rank.
#[derive(Debug)]
pub struct Rank<'w> {
    world: &'w World,
    rank: usize,
    calls: AtomicUsize,
    words: AtomicUsize,
}

impl Rank<'_> {
    /// Calls so far.
    pub fn calls(&self) -> usize {
        self.calls.load(Ordering::Relaxed)
    }

    /// Words that it has offered so far.
    pub fn words(&self) -> usize {
        self.words.load(Ordering::Relaxed)
    }

    /// Offers words, and calls the body for what each rank offers, the number of the rank being given.
    fn meet(
        &self,
        kind: u8,
        words: &[u64],
        starts: &[usize],
        mut body: impl FnMut(usize, &[u64], &[usize]),
    ) -> Result<()> {
        self.words.fetch_add(words.len(), Ordering::Relaxed);
        if self.calls.fetch_add(1, Ordering::Relaxed) == self.world.fails_at {
            return Err(Error::Executor);
        }
        *self.world.offers[self.rank].lock().unwrap() = (kind, words.to_vec(), starts.to_vec());
        self.world.barrier.wait();
        for (rank, offer) in self.world.offers.iter().enumerate() {
            let offer = offer.lock().unwrap();
            assert_eq!(offer.0, kind, "ranks make different calls");
            body(rank, &offer.1, &offer.2);
        }
        self.world.barrier.wait();
        Ok(())
    }
}

impl Communicator for Rank<'_> {
    fn rank(&self) -> usize {
        self.rank
    }

    fn ranks(&self) -> usize {
        self.world.offers.len()
    }

    fn reduce(&self, reduction: Reduction, words: &mut [u64]) -> Result<()> {
        let mine = words.to_vec();
        words.fill(0);
        self.meet(reduction as u8, &mine, &[], |_, theirs, _| {
            assert_eq!(theirs.len(), words.len(), "ranks reduce different numbers of words");
            for (word, &other) in words.iter_mut().zip(theirs) {
                *word = if reduction == Reduction::Sum { word.wrapping_add(other) } else { other.max(*word) };
            }
        })
    }

    fn exchange(&self, outgoing: &[u64], starts: &[usize], incoming: &mut [u64], froms: &[usize]) -> Result<()> {
        assert!(starts.len() == self.ranks() + 1 && froms.len() == starts.len());
        self.meet(2, outgoing, starts, |rank, theirs, starts| {
            incoming[froms[rank]..froms[rank + 1]].copy_from_slice(&theirs[starts[self.rank]..starts[self.rank + 1]]);
        })
    }
}

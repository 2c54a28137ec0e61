//! A kernel without its type, as the loops of [`super::passes`] see it, and what these pass to it.
//!
//! What is called for a block of sources or less often goes through these traits, so that only what a kernel does with a block is compiled for each kernel, kind of pass and
//! instruction set.

use core::sync::atomic::{AtomicUsize, Ordering};

use super::close::Close;
use super::lanes::{Deferred, Group, List, Row, Want};
use super::near::Groups;
use super::output::{Contribution, Results, Scales};
use super::packed::{Packed, Units};
use super::{Block, Passes};
use crate::error::Result;
use crate::exec::Statistics;
use crate::field::{Options, Outputs, PairRadius, Sources};
use crate::real::Real;
use crate::simd::{Isa, Level};

/// A [`super::PairKernel`] in the units of a call.
pub(super) trait ErasedKernel<T: Real, const D: usize>: Sync {
    /// [`super::PairKernel::PASSES`].
    fn passes(&self) -> Passes;
    /// [`super::PairKernel::length`].
    fn length(&self) -> T;
    /// [`super::PairKernel::core`].
    fn core(&self, rule: PairRadius, square: T) -> T;
    /// [`super::PairKernel::scales`].
    fn scales(&self, units: Units<T>, class: usize) -> Scales<T>;
    /// [`super::PairKernel::exact`].
    fn exact(&self, x: &[T; D], mass: T, radius: Option<T>, want: Want) -> Contribution<T, D>;
    /// Runs a pass of a kind ([`super::lanes::GRADIENTS`] and so on) that the kernel's passes have.
    ///
    /// # Errors
    /// [`crate::Error::Internal`]: they have not.
    fn run(&self, kind: u8, pass: Pass<'_, T, D>, level: Level) -> Result<()>;
}

/// What a pass calls of a kernel at an instruction set.
pub(super) trait ErasedLanes<T: Real, I: Isa<T>, const D: usize, const NB: usize> {
    /// [`super::PairKernel::add_block`].
    fn add_block(
        &self,
        isa: I,
        block: &Block<'_, T, D>,
        groups: &mut [Group<I::V, D>; NB],
        noted: &mut [Deferred; 2],
        counts: &mut Statistics,
    );

    /// Adds what noted sources give to the lanes that were left out.
    fn add_left_out(&self, isa: I, left_out: LeftOut<'_, T, I::V, D, NB>);
}

/// What a task counts, added up over the tasks.
#[derive(Debug, Default)]
pub(super) struct Tally {
    near: AtomicUsize,
    polynomial: AtomicUsize,
    all_near: AtomicUsize,
    scaled: AtomicUsize,
    beyond: AtomicUsize,
}

impl Tally {
    pub fn add(&self, counts: &Statistics) {
        self.near.fetch_add(counts.near_pairs as usize, Ordering::Relaxed);
        self.polynomial.fetch_add(counts.polynomial_blocks as usize, Ordering::Relaxed);
        self.all_near.fetch_add(counts.all_near_blocks as usize, Ordering::Relaxed);
        self.scaled.fetch_add(counts.scaled_pairs as usize, Ordering::Relaxed);
        self.beyond.fetch_add(counts.beyond_reach as usize, Ordering::Relaxed);
    }

    pub fn counters(&self) -> Statistics {
        let value = |count: &AtomicUsize| count.load(Ordering::Relaxed) as u64;
        Statistics {
            near_pairs: value(&self.near),
            polynomial_blocks: value(&self.polynomial),
            all_near_blocks: value(&self.all_near),
            scaled_pairs: value(&self.scaled),
            beyond_reach: value(&self.beyond),
            ..Statistics::default()
        }
    }
}

/// What all tasks of a sum share.
pub(super) struct Shared<'a, T: Real, const D: usize> {
    pub kernel: &'a dyn ErasedKernel<T, D>,
    pub packed: &'a Packed<'a, T, D>,
    pub units: Units<T>,
    pub options: &'a Options,
    pub sources: Sources<'a, T, D>,
    /// Whether another module has packed the sources, whose masses then need not be the caller's.
    pub ordered: bool,
    pub tally: &'a Tally,
}

/// One pass of a task over the outputs that are there.
pub(super) struct Pass<'a, T: Real, const D: usize> {
    pub shared: &'a Shared<'a, T, D>,
    /// The targets, and their core radii where a pair's depends on them.
    pub targets: (&'a [[T; D]], &'a [T]),
    pub outputs: Outputs<'a, T, D>,
    /// Of second derivatives: of which row.
    pub row: Row,
    /// Which targets meet which sources; `None`: all meet all.
    pub groups: Option<Groups<'a>>,
    /// Whether its pairs are counted: those of a second pass are the same.
    pub counted: bool,
}

/// Noted sources of a block, and where what they give goes.
pub(super) struct LeftOut<'a, T: Real, V: Copy, const D: usize, const NB: usize> {
    pub shared: &'a Shared<'a, T, D>,
    pub want: Want,
    /// The targets of the register block, their core radii if a pair's depends on them, and what pairs one by one give to them.
    pub targets: (&'a [[T; D]], &'a [T], &'a mut Results<T, D>),
    /// The sources of the block, and their numbers among the caller's.
    pub sources: List<'a, T, D>,
    pub cores: &'a [T],
    pub origins: &'a [u32],
    pub noted: &'a mut [Deferred; 2],
    /// Made when it is needed.
    pub close: &'a mut Option<Close<V, D, NB>>,
    pub groups: &'a [Group<V, D>; NB],
    pub valid: &'a [u32; NB],
    pub counts: &'a mut Statistics,
}

//! The options and counters of a call.

use super::{Communicator, Executor, Serial};
use crate::simd::Level;

/// The options of a call: instruction set, executor, stop request, counters, communicator. None of it is stored.
pub struct Run<'a> {
    /// The instruction set.
    pub level: Level,
    /// Runs the tasks.
    pub executor: &'a dyn Executor,
    /// Called between tasks; `true` ends the call with [`crate::Error::Stopped`].
    pub should_stop: Option<&'a (dyn Fn() -> bool + Sync)>,
    /// The counts are added to it when the call succeeds.
    pub counters: Option<&'a mut Statistics>,
    /// The processes over which the particles are spread: [`pks::step`](crate::pks::step) asks for it, other calls do not. `None`: this one has all.
    pub communicator: Option<&'a dyn Communicator>,
}

/// The part of a call's options that every loop needs: where it runs.
#[derive(Clone, Copy)]
pub struct Resources<'a> {
    /// The instruction set.
    pub level: Level,
    /// Runs the tasks.
    pub executor: &'a dyn Executor,
}

impl Default for Resources<'_> {
    fn default() -> Self {
        Self { level: Level::best(), executor: &Serial }
    }
}

impl core::fmt::Debug for Resources<'_> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Resources").field("level", &self.level).field("workers", &self.executor.workers()).finish()
    }
}

impl<'a> Run<'a> {
    /// Its instruction set and executor.
    #[must_use]
    pub fn resources(&self) -> Resources<'a> {
        Resources { level: self.level, executor: self.executor }
    }
}

impl Default for Run<'_> {
    fn default() -> Self {
        Self { level: Level::best(), executor: &Serial, should_stop: None, counters: None, communicator: None }
    }
}

impl core::fmt::Debug for Run<'_> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Run").field("level", &self.level).field("workers", &self.executor.workers()).finish()
    }
}

/// The counters of a sum, so that tests can count skipped work instead of timing it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(C)]
pub struct Statistics {
    /// Pairs of a target and a source of nonzero mass whose distance was computed.
    pub pairs: u64,
    /// Those of these pairs that are closer than delta.
    pub near_pairs: u64,
    /// Blocks (one source against one register block of targets) that evaluated the mollifier's polynomial.
    pub polynomial_blocks: u64,
    /// Blocks in which every lane was near, so that no division was needed.
    pub all_near_blocks: u64,
    /// Pairs outside the range of the fast path. Newtonian ones closer than 2^-28 of the largest coordinate (double: 2^-60) are summed in lanes in
    /// closer units, at about 3 times the usual cost. Those closer than 2^-84 (2^-180), coincident ones, and those of other kernels beyond the
    /// ends of their table are computed one by one: some 200 ns each.
    pub scaled_pairs: u64,
    /// Sources without mass that were dropped.
    pub massless_sources: u64,
    /// Pairs at least as far apart as the reach of a host's own kernel, which gives them nothing.
    pub beyond_reach: u64,
}

impl Statistics {
    /// Adds another count.
    pub fn add(&mut self, other: &Statistics) {
        let Statistics {
            pairs,
            near_pairs,
            polynomial_blocks,
            all_near_blocks,
            scaled_pairs,
            massless_sources,
            beyond_reach,
        } = other;
        self.pairs = self.pairs.saturating_add(*pairs);
        self.near_pairs = self.near_pairs.saturating_add(*near_pairs);
        self.polynomial_blocks = self.polynomial_blocks.saturating_add(*polynomial_blocks);
        self.all_near_blocks = self.all_near_blocks.saturating_add(*all_near_blocks);
        self.scaled_pairs = self.scaled_pairs.saturating_add(*scaled_pairs);
        self.massless_sources = self.massless_sources.saturating_add(*massless_sources);
        self.beyond_reach = self.beyond_reach.saturating_add(*beyond_reach);
    }
}

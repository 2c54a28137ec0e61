//! From a kernel to what [`super::erased`] asks of it: passes of each kind at each instruction set.

use super::erased::{ErasedKernel, ErasedLanes, LeftOut, Pass};
use super::lanes::{Deferred, GRADIENTS, Group, HESSIANS, POTENTIALS, Want};
use super::left_out::AddLeftOut;
use super::output::{Contribution, Scales};
use super::packed::Units;
use super::passes::Drive;
use super::{Block, PairKernel, Passes, close};
use crate::error::{Error, Result};
use crate::exec::Statistics;
use crate::field::PairRadius;
use crate::real::Real;
use crate::simd::{BlockJob, Isa, Job, Level, Part, portable};

/// A kernel, prepared, and for the units of close pairs.
pub(super) struct Ready<'a, T: Real, const D: usize, K: PairKernel<T, D>> {
    pub kernel: &'a K,
    pub prepared: &'a K::Prepared,
    pub closer: &'a [Option<K::Prepared>; close::RESCALINGS],
}

/// Whether passes are compiled for each level. In the crate's unit tests only for one, as the package `tests` runs all.
const ALL_LEVELS: bool = cfg!(not(test));

impl<T: Real, const D: usize, K: PairKernel<T, D>> ErasedKernel<T, D> for Ready<'_, T, D, K> {
    fn passes(&self) -> Passes {
        K::PASSES
    }

    fn length(&self) -> T {
        self.kernel.length()
    }

    fn core(&self, rule: PairRadius, square: T) -> T {
        self.kernel.core(rule, square)
    }

    fn scales(&self, units: Units<T>, class: usize) -> Scales<T> {
        self.kernel.scales(units, class)
    }

    fn exact(&self, x: &[T; D], mass: T, radius: Option<T>, want: Want) -> Contribution<T, D> {
        self.kernel.exact(x, mass, radius, want)
    }

    fn run(&self, kind: u8, pass: Pass<'_, T, D>, level: Level) -> Result<()> {
        // The constant conditions keep passes that the kernel does not have from being compiled.
        match kind {
            GRADIENTS if const { !matches!(K::PASSES, Passes::One) } => {
                OfKernel::<T, D, K, GRADIENTS> { ready: self, pass }.run(level);
            }
            POTENTIALS if const { !matches!(K::PASSES, Passes::None) } => {
                OfKernel::<T, D, K, POTENTIALS> { ready: self, pass }.run(level);
            }
            HESSIANS if const { D > 1 && !matches!(K::PASSES, Passes::None) } => {
                OfKernel::<T, D, K, HESSIANS> { ready: self, pass }.run(level);
            }
            _ => {
                debug_assert!(false, "a pass that the kernel has");
                return Err(Error::Internal);
            }
        }
        Ok(())
    }
}

/// A pass of kind `P` with its kernel.
struct OfKernel<'a, T: Real, const D: usize, K: PairKernel<T, D>, const P: u8> {
    ready: &'a Ready<'a, T, D, K>,
    pass: Pass<'a, T, D>,
}

impl<T: Real, const D: usize, K: PairKernel<T, D>, const P: u8> OfKernel<'_, T, D, K, P> {
    fn run(self, level: Level) {
        // A row of second derivatives needs many registers for a vector of targets, and core radii of pairs some. (Conditions that are known while it is compiled keep the
        // other branch from being compiled.)
        let narrow = self.pass.shared.options.pair_radius != PairRadius::Source && level != Level::Portable;
        if K::SCALAR || !ALL_LEVELS || const { P == HESSIANS } && level == Level::Portable {
            portable(Narrow(self));
        } else if const { P == HESSIANS } || const { K::RADII } && narrow {
            let done = level.run_narrow(Narrow(self));
            debug_assert!(done, "a level that is available");
        } else {
            level.run(self);
        }
    }
}

impl<T: Real, const D: usize, K: PairKernel<T, D>, const P: u8> Job<T> for OfKernel<'_, T, D, K, P> {
    type Out = ();

    #[inline(always)]
    fn run<I: Isa<T>>(self, isa: I) {
        isa.in_blocks(self);
    }
}

/// A pass with one vector of targets at a time.
struct Narrow<J>(J);

impl<T: Real, J: BlockJob<T>> Job<T> for Narrow<J> {
    type Out = J::Out;

    #[inline(always)]
    fn run<I: Isa<T>>(self, isa: I) -> J::Out {
        self.0.run::<I, 1>(isa)
    }
}

impl<T: Real, const D: usize, K: PairKernel<T, D>, const P: u8> BlockJob<T> for OfKernel<'_, T, D, K, P> {
    type Out = ();

    #[inline(always)]
    fn run<I: Isa<T>, const NB: usize>(self, isa: I) {
        let Self { ready, pass } = self;
        let kernel = InLanes::<T, I, D, K, P> { ready, lanes: K::lanes(ready.prepared, isa) };
        isa.apart(Drive::<_, _, D, NB> { kernel: &kernel, pass });
    }
}

/// A kernel at an instruction set, for passes of kind `P`.
struct InLanes<'a, T: Real, I: Isa<T>, const D: usize, K: PairKernel<T, D>, const P: u8> {
    ready: &'a Ready<'a, T, D, K>,
    lanes: K::Lanes<I::V>,
}

impl<T: Real, I: Isa<T>, const D: usize, const NB: usize, K: PairKernel<T, D>, const P: u8> ErasedLanes<T, I, D, NB>
    for InLanes<'_, T, I, D, K, P>
{
    // Functions that are called through a table are compiled without the instruction set: what they do stands in parts.
    fn add_block(
        &self,
        isa: I,
        block: &Block<'_, T, D>,
        groups: &mut [Group<I::V, D>; NB],
        noted: &mut [Deferred; 2],
        counts: &mut Statistics,
    ) {
        isa.apart(AddBlock { kernel: self, block, groups, noted, counts });
    }

    fn add_left_out(&self, isa: I, left_out: LeftOut<'_, T, I::V, D, NB>) {
        let Ready { kernel, prepared, closer } = *self.ready;
        let lanes = &self.lanes;
        isa.apart(AddLeftOut::<_, _, _, _, _, P> { kernel, prepared, closer, lanes, left_out });
    }
}

/// [`PairKernel::add_block`] as a part.
struct AddBlock<'a, T: Real, I: Isa<T>, const D: usize, const NB: usize, K: PairKernel<T, D>, const P: u8> {
    kernel: &'a InLanes<'a, T, I, D, K, P>,
    block: &'a Block<'a, T, D>,
    groups: &'a mut [Group<I::V, D>; NB],
    noted: &'a mut [Deferred; 2],
    counts: &'a mut Statistics,
}

impl<T: Real, I: Isa<T>, const D: usize, const NB: usize, K: PairKernel<T, D>, const P: u8> Part<T, I>
    for AddBlock<'_, T, I, D, NB, K, P>
{
    type Out = ();

    #[inline(always)]
    fn run(self, isa: I) {
        let Self { kernel: InLanes { ready, lanes }, block, groups, noted, counts } = self;
        K::add_block::<I, NB, P>(isa, (ready.prepared, lanes), block, groups, noted, counts);
    }
}

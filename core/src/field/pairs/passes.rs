//! The passes of a task, and the loops over register blocks and blocks of sources.
//!
//! None of it knows the kernel's type: it is compiled once for each scalar, dimension and instruction set.

use super::close::{self, Close, FinishBlock};
use super::erased::{ErasedLanes, LeftOut, Pass, Shared};
use super::lanes::{Deferred, GRADIENTS, Group, HESSIANS, POTENTIALS, Row, Sums, Total, Want, valid_lanes};
use super::near::{self, Groups};
use super::output::{self, Results, Scales, Writer};
use super::packed::{Class, Targets, Units};
use super::{BLOCK, Block, Passes, SHORT_BLOCK};
use crate::checked::Present;
use crate::error::Result;
use crate::exec::Statistics;
use crate::field::{Accumulation, Outputs};
use crate::real::Real;
use crate::simd::{Isa, Level, Part};

/// Computes the outputs that are there, in the passes of the kernel. With the targets come their core radii, where a pair's depends on them.
pub(super) fn passes<T: Real, const D: usize>(
    shared: &Shared<'_, T, D>,
    targets: (&[[T; D]], &[T]),
    outputs: Outputs<'_, T, D>,
    groups: Option<Groups<'_>>,
    level: Level,
) -> Result<()> {
    let Outputs { potential, gradient, laplacian, hessian } = outputs;
    let (kernel, kind) = (shared.kernel, shared.kernel.passes());
    let first = gradient.is_some() || laplacian.is_some();
    let mut counted = potential.is_none() && !first;
    if D > 1
        && kind != Passes::None
        && let Some(hessian) = hessian
    {
        for row in 0..D - 1 {
            let outputs = Outputs { hessian: Some(&mut *hessian), ..Outputs::default() };
            kernel.run(HESSIANS, Pass { shared, targets, outputs, row: Row::new(row), groups, counted }, level)?;
            counted = false;
        }
        if potential.is_none() && !first {
            return Ok(());
        }
    }
    let (row, hessian) = (Row::NONE, None);
    if kind == Passes::One || kind == Passes::Together && potential.is_some() {
        let outputs = Outputs { potential, gradient, laplacian, hessian };
        return kernel.run(POTENTIALS, Pass { shared, targets, outputs, row, groups, counted: true }, level);
    }
    if first {
        let outputs = Outputs { potential: None, gradient, laplacian, hessian };
        kernel.run(GRADIENTS, Pass { shared, targets, outputs, row, groups, counted: true }, level)?;
    }
    if kind != Passes::None && potential.is_some() {
        let outputs = Outputs { potential, ..Outputs::default() };
        kernel.run(POTENTIALS, Pass { shared, targets, outputs, row, groups, counted: !first }, level)?;
    }
    Ok(())
}

/// A pass at an instruction set, with so many vectors of targets in a register block; a function of its own for all kernels.
pub(super) struct Drive<'a, T: Real, I: Isa<T>, const D: usize, const NB: usize> {
    pub kernel: &'a dyn ErasedLanes<T, I, D, NB>,
    pub pass: Pass<'a, T, D>,
}

impl<T: Real, I: Isa<T>, const D: usize, const NB: usize> Part<T, I> for Drive<'_, T, I, D, NB> {
    type Out = ();

    #[inline(always)]
    fn run(self, isa: I) {
        let Self { kernel, pass } = self;
        let Pass { shared, targets: (targets, radii), mut outputs, row, groups, counted } = pass;
        let mut counts = Statistics::default();
        let mut results = Results::ZERO;
        let mut noted = [Deferred::new(), Deferred::new()];
        let want = Want {
            potential: outputs.potential.is_some(),
            gradient: outputs.gradient.is_some() || row.is_some(),
            laplacian: outputs.laplacian.is_some() || row.is_some(),
            row,
        };
        for (range, ranges) in near::each_group(groups, targets.len()) {
            let targets = targets.get(range.clone()).present_or(&[]);
            let mut radii = if radii.is_empty() { &[] } else { radii.get(range.start..).present_or(&[]) };
            let outputs = near::part(&mut outputs, range);
            let mut writer = Writer::new(outputs, shared.options.combination, row.get().unwrap_or(0), groups.is_some());
            for targets in targets.chunks(NB * I::LANES) {
                results.clear(targets.len());
                let (of_block, others) = radii.split_at_checked(targets.len()).unwrap_or((radii, &[]));
                radii = others;
                for (number, class) in shared.packed.classes() {
                    let totals = class_sums(
                        isa,
                        (shared, kernel),
                        want,
                        (targets, of_block, &mut results),
                        (number, &class, ranges),
                        (&mut noted, &mut counts),
                    );
                    let scales = scales(shared, shared.units, number, want);
                    output::add(isa, (&mut results, targets.len()), &totals, &scales);
                }
                writer.write(results.finish(targets.len()));
            }
        }
        if counted {
            shared.tally.add(&counts);
        }
    }
}

/// [`super::PairKernel::scales`] for what is wanted of a pass.
fn scales<T: Real, const D: usize>(shared: &Shared<'_, T, D>, units: Units<T>, class: usize, want: Want) -> Scales<T> {
    let scales = shared.kernel.scales(units, class);
    // Second derivatives are of the Laplacian's size.
    if want.row.is_some() { Scales { gradient: scales.laplacian, ..scales } } else { scales }
}

/// The sums over the sources of a class, or those of some ranges, for one register block of targets, in units. What the kernel leaves out goes to `results`.
#[inline(always)]
fn class_sums<T: Real, I: Isa<T>, const D: usize, const NB: usize>(
    isa: I,
    (shared, kernel): (&Shared<'_, T, D>, &dyn ErasedLanes<T, I, D, NB>),
    want: Want,
    (targets, radii, results): (&[[T; D]], &[T], &mut Results<T, D>),
    (number, class, ranges): (usize, &Class<'_, T, D>, Option<&[[u32; 3]]>),
    (noted, counts): (&mut [Deferred; 2], &mut Statistics),
) -> [Total<I::V, D>; NB] {
    let zero = isa.splat(T::ZERO);
    let mut axis = [zero; D];
    if let Some(axis) = want.row.get().and_then(|row| axis.get_mut(row)) {
        *axis = isa.splat(T::ONE);
    }
    let mut groups = [Group { x: [zero; D], axis, core: zero, sums: Sums::splat(zero) }; NB];
    let mut valid = [0; NB];
    let in_units = Targets::new(shared.units, targets, NB * I::LANES);
    for (v, group) in groups.iter_mut().enumerate() {
        group.x = in_units.vector(isa, v);
    }
    if !radii.is_empty() {
        let rule = shared.options.pair_radius;
        let cores = Targets::<T, D>::cores(shared.units, radii, &|square| shared.kernel.core(rule, square));
        for (v, group) in groups.iter_mut().enumerate() {
            if let Some(lanes) = cores.get(v * I::LANES..).and_then(|lanes| lanes.first_chunk()) {
                group.core = isa.load(lanes);
            }
        }
    }
    for (valid, targets) in valid.iter_mut().zip(targets.chunks(I::LANES)) {
        *valid = valid_lanes(targets.len());
    }
    let compensated = shared.options.accumulation == Accumulation::Compensated;
    let each = if compensated { SHORT_BLOCK } else { BLOCK };
    let mut totals = [Total::splat(zero); NB];
    let mut close = None;
    for (start, (source_bounds, apart), (positions, masses)) in class.blocks(ranges) {
        for (k, sources) in positions.chunks(each).zip(masses.chunks(each)).enumerate() {
            let Want { potential, laplacian, .. } = want;
            let cores = if class.cores.is_empty() { &[] } else { class.cores.get(start + k * each..).present_or(&[]) };
            let strengths =
                if class.strengths.is_empty() { &[] } else { class.strengths.get(start + k * each..).present_or(&[]) };
            let bounds = [&source_bounds, &in_units.bounds];
            let block = Block { sources, cores, strengths, bounds, apart, potential, laplacian, valid: &valid };
            kernel.add_block(isa, &block, &mut groups, noted, counts);
            if noted.iter().any(|list| !list.is_empty()) {
                let left_out = LeftOut {
                    shared,
                    want,
                    targets: (targets, radii, &mut *results),
                    sources,
                    cores,
                    origins: class.origins.get(start + k * each..).present_or(&[]),
                    noted: &mut *noted,
                    close: &mut close,
                    groups: &groups,
                    valid: &valid,
                    counts,
                };
                kernel.add_left_out(isa, left_out);
            }
            for (total, group) in totals.iter_mut().zip(&mut groups) {
                if compensated {
                    total.add_compensated(isa, group.sums);
                } else {
                    total.add(isa, group.sums);
                }
                group.sums = Sums::splat(zero);
            }
            if let Some(close) = &mut close {
                isa.apart(FinishBlock { close, compensated });
            }
        }
    }
    for (level, totals) in close.iter().flat_map(Close::totals).enumerate() {
        let scales = scales(shared, close::units_of(shared.units, level + 1), number, want);
        output::add(isa, (&mut *results, targets.len()), totals, &scales);
    }
    totals
}

//! All pairs of the Newtonian kernel: tasks over targets, each target's sum in blocks of sources.
//!
//! # Error
//! Every term carries c u ([`super::newtonian`]), c = 16. The n terms of a target are added in blocks of 256 and the blocks'
//! sums one after the other, so with u the unit roundoff and to first order
//!
//! `|computed - exact| <= (c + 256 + n / 256) u sum_j |m_j| |K_j|`, componentwise for gradients,
//!
//! and the same with |K_j| + 1/(2 pi) in place of |K_j| for the 2D potential, with max psi_delta for the Laplacian. Compensated
//! sums: c u sum_j |m_j| |K_j| + O(n u^2). Roundings of sums are as good as independent, so errors of a few u are what is seen.
//! The bound supposes that no result underflows. Tests: `field_direct::the_error_bound_holds_in_f64` and `.._f32`.

use super::newtonian::{Group, List, Pending, Softened, Sums, far_run, inside, near_run};
use super::packed::{Bounds, Packed, Units, bounds_of, farthest};
use super::{Accumulation, Counters, Options, Outputs, Run, Sources, Wanted};
use crate::error::{Error, Result};
use crate::isa::{BlockJob, Isa, Job, MAX_LANES};
use crate::kernel::sphere;
use crate::mollifier::{Blob, Mollifier};
use crate::real::Real;
use crate::space::{Carve, Chunks, Measure, Same, each_piece};
use core::sync::atomic::{AtomicUsize, Ordering};

/// Targets of one task: a multiple of every machine's register block, so that blocks, and with them the bits of the
/// results, do not depend on who runs them.
const TASK: usize = 128;

/// Bytes for the compacted sources.
pub(super) fn workspace_bytes<T: Real, const D: usize>(n_sources: usize) -> Result<usize> {
    Measure::of(|space| Packed::<T, D>::lay(space, n_sources).map(|_| ()))
}

/// One Newtonian sum: the kernel is `coefficient` times the blob's potential.
#[derive(Clone, Copy, Debug)]
pub(super) struct Newtonian<'a, T: Real, const D: usize> {
    pub blob: &'a Blob<T, D>,
    pub coefficient: T,
}

/// The arguments of a sum, checked.
pub(super) struct Call<'a, T: Real, const D: usize> {
    pub kernel: Newtonian<'a, T, D>,
    pub options: &'a Options,
    pub sources: Sources<'a, T, D>,
    pub targets: &'a [[T; D]],
    pub outputs: Outputs<'a, T, D>,
}

impl<'a, T: Real, const D: usize> Call<'a, T, D> {
    /// The same call with its types spelt out, where they are these.
    #[inline(always)]
    fn same<U: Real, const E: usize>(self) -> core::result::Result<Call<'a, U, E>, Self> {
        let (Some(number), Some(point), Some(blob)) =
            (Same::<T, U>::proof(), Same::<[T; D], [U; E]>::proof(), Same::<Blob<T, D>, Blob<U, E>>::proof())
        else {
            return Err(self);
        };
        let Self { kernel, options, sources, targets, outputs } = self;
        Ok(Call {
            kernel: Newtonian {
                blob: blob.reference(kernel.blob),
                coefficient: *number.reference(&kernel.coefficient),
            },
            options,
            sources: Sources { positions: point.slice(sources.positions), masses: number.slice(sources.masses) },
            targets: point.slice(targets),
            outputs: Outputs {
                potential: outputs.potential.map(|p| number.slice_mut(p)),
                gradient: outputs.gradient.map(|g| point.slice_mut(g)),
                laplacian: outputs.laplacian.map(|l| number.slice_mut(l)),
            },
        })
    }
}

impl<T: Real, const D: usize> Call<'_, T, D> {
    /// Units in which coordinates, delta and masses are at most about 1.
    #[inline(always)]
    pub(super) fn units(&self) -> Units<T> {
        let largest =
            |start: T, numbers: &[T]| numbers.iter().fold(start, |x, &y| if y.abs() > x { y.abs() } else { x });
        let length = largest(self.kernel.blob.delta(), self.sources.positions.as_flattened());
        let length = largest(length, self.targets.as_flattened());
        Units::new(length, largest(T::ZERO, self.sources.masses))
    }
}

macro_rules! compiled_here {
    ($($name:ident $t:ty, $d:literal;)*) => {
        $(#[inline(never)]
        fn $name(call: Call<'_, $t, $d>, workspace: &mut [u8], run: &mut Run<'_>) -> Result<()> {
            sums(call, workspace, run)
        })*

        /// Overwrites the outputs.
        ///
        /// The loops are compiled with this crate, once for each scalar and dimension, not in every crate that calls them.
        pub(super) fn evaluate<T: Real, const D: usize>(
            call: Call<'_, T, D>,
            workspace: &mut [u8],
            run: &mut Run<'_>,
        ) -> Result<()> {
            if cfg!(feature = "small") {
                return super::single::sums::<T, D, true>(call, workspace, run);
            }
            $(let call = match call.same::<$t, $d>() {
                Ok(call) => return $name(call, workspace, run),
                Err(call) => call,
            };)*
            let _ = call;
            Err(Error::Unsupported)
        }
    };
}
compiled_here! {
    plane_f64 f64, 2;
    plane_f32 f32, 2;
    space_f64 f64, 3;
    space_f32 f32, 3;
    line_f64 f64, 1;
    line_f32 f32, 1;
}

#[inline(always)]
fn sums<T: Real, const D: usize>(call: Call<'_, T, D>, workspace: &mut [u8], run: &mut Run<'_>) -> Result<()> {
    let units = call.units();
    let Call { kernel, options, sources, targets, outputs } = call;
    let mut packed = Packed::<T, D>::lay(&mut Carve::new(workspace)?, sources.positions.len())?;
    packed.fill(units, sources.positions, sources.masses);

    let wanted = outputs.wanted();
    let softened = Softened::new(kernel.blob, units);
    let tally = Tally::default();
    let should_stop = run.should_stop;
    let level = run.level;
    let pieces = (
        outputs.potential.map(|p| Chunks::new(p, TASK)),
        outputs.gradient.map(|g| Chunks::new(g, TASK)),
        outputs.laplacian.map(|l| Chunks::new(l, TASK)),
    );
    let shared = Shared { kernel, softened: &softened, packed: &packed, units, wanted, options, tally: &tally };
    each_piece(
        run.executor,
        targets.len().div_ceil(TASK),
        pieces,
        (),
        &|task, (potential, gradient, laplacian), ()| {
            if should_stop.is_some_and(|stop| stop()) {
                return Err(Error::Stopped);
            }
            let targets = targets.get(task.saturating_mul(TASK)..).unwrap_or(&[]);
            let targets = targets.get(..TASK).unwrap_or(targets);
            let outputs = Outputs { potential, gradient, laplacian };
            let compensated = options.accumulation == Accumulation::Compensated;
            match (wanted.potential, wanted.gradient, compensated) {
                (false, false, false) => {
                    level.run(Sum::<T, D, false, false, false> { shared: &shared, targets, outputs })
                }
                (false, true, false) => {
                    level.run(Sum::<T, D, false, true, false> { shared: &shared, targets, outputs })
                }
                (true, false, false) => {
                    level.run(Sum::<T, D, true, false, false> { shared: &shared, targets, outputs })
                }
                (true, true, false) => level.run(Sum::<T, D, true, true, false> { shared: &shared, targets, outputs }),
                (_, _, true) => level.run(Sum::<T, D, true, true, true> { shared: &shared, targets, outputs }),
            }
            Ok(())
        },
    )?;
    if let Some(counters) = run.counters.as_deref_mut() {
        let pairs = (packed.len() as u64).saturating_mul(targets.len() as u64);
        let massless = sources.masses.len().saturating_sub(packed.len()) as u64;
        counters.add(&Counters { pairs, massless_sources: massless, ..tally.counters() });
    }
    Ok(())
}

/// What tasks count.
#[derive(Debug, Default)]
struct Tally {
    near: AtomicUsize,
    polynomial: AtomicUsize,
    all_near: AtomicUsize,
    scaled: AtomicUsize,
}

impl Tally {
    fn add(&self, counts: &Counters) {
        self.near.fetch_add(counts.near_pairs as usize, Ordering::Relaxed);
        self.polynomial.fetch_add(counts.polynomial_blocks as usize, Ordering::Relaxed);
        self.all_near.fetch_add(counts.all_near_blocks as usize, Ordering::Relaxed);
        self.scaled.fetch_add(counts.scaled_pairs as usize, Ordering::Relaxed);
    }

    fn counters(&self) -> Counters {
        let value = |count: &AtomicUsize| count.load(Ordering::Relaxed) as u64;
        Counters {
            near_pairs: value(&self.near),
            polynomial_blocks: value(&self.polynomial),
            all_near_blocks: value(&self.all_near),
            scaled_pairs: value(&self.scaled),
            ..Counters::default()
        }
    }
}

/// What all tasks of a sum share.
struct Shared<'a, T: Real, const D: usize> {
    kernel: Newtonian<'a, T, D>,
    softened: &'a Softened<T>,
    packed: &'a Packed<'a, T, D>,
    units: Units<T>,
    wanted: Wanted,
    options: &'a Options,
    tally: &'a Tally,
}

/// One task.
struct Sum<'a, T: Real, const D: usize, const P: bool, const G: bool, const C: bool> {
    shared: &'a Shared<'a, T, D>,
    targets: &'a [[T; D]],
    outputs: Outputs<'a, T, D>,
}

impl<T: Real, const D: usize, const P: bool, const G: bool, const C: bool> Job<T> for Sum<'_, T, D, P, G, C> {
    type Out = ();

    #[inline(always)]
    fn run<I: Isa<T>>(self, isa: I) {
        isa.in_blocks(self);
    }
}

impl<T: Real, const D: usize, const P: bool, const G: bool, const C: bool> BlockJob<T> for Sum<'_, T, D, P, G, C> {
    type Out = ();

    #[inline(always)]
    fn run<I: Isa<T>, const NB: usize>(self, isa: I) {
        let Sum { shared, targets, outputs } = self;
        let kernel = shared.softened.lanes(isa);
        let (mut counts, mut exact) = (Counters::default(), Exacts::new());
        let mut writer = Writer::new(shared, outputs);
        for block in targets.chunks(NB * I::LANES) {
            let sums = block_sum::<T, I, D, NB, P, G, C>(isa, shared, &kernel, block, &mut exact, &mut counts);
            writer.block::<I, NB>(isa, block.len(), &sums, &mut exact);
        }
        shared.tally.add(&counts);
    }
}

/// The most vectors of targets in a register block.
const WIDE: usize = 4;

/// The sums over all sources for one register block of targets.
#[inline(always)]
fn block_sum<T: Real, I: Isa<T>, const D: usize, const NB: usize, const P: bool, const G: bool, const C: bool>(
    isa: I,
    shared: &Shared<'_, T, D>,
    kernel: &Softened<I::V>,
    targets: &[[T; D]],
    exact: &mut Exacts<T, D>,
    counts: &mut Counters,
) -> [Group<I::V, D>; NB] {
    let zero = Sums::zero(isa);
    let mut groups = [Group { x: [isa.splat(T::ZERO); D], sums: zero, lost: zero }; NB];
    let mut valid = [0_u32; NB];
    for ((group, valid), targets) in groups.iter_mut().zip(&mut valid).zip(targets.chunks(I::LANES)) {
        group.x = load(isa, shared.units, targets);
        *valid = u32::MAX >> (32 - targets.len().clamp(1, 32) as u32);
    }
    let mut total = groups;
    let laplacian = shared.wanted.laplacian;
    let valid_lanes = valid.iter().map(|valid| u64::from(valid.count_ones())).sum::<u64>();
    let bounds = block_bounds(shared, targets);
    let mut pending = Pending::new();
    for (block, positions, masses) in shared.packed.blocks() {
        let all = (positions, masses);
        let mut left = all;
        let mut near = 0;
        // With five terms (M = 4, order 2: the paper's choice) the polynomial is unrolled, and nothing is tested.
        if kernel.gradient_terms() == 5 && farthest(block, &bounds) < *shared.softened.edge() {
            near = near_run::<T, I, D, NB, P, G, C, 5, false>(isa, kernel, laplacian, left, &mut groups);
            left = (&[], &[]);
        }
        while !left.0.is_empty() {
            let start = positions.len() - left.0.len();
            let far = far_run::<T, I, D, NB, P, G, C>(isa, kernel, left, start, &mut pending, &mut groups);
            left = skip(left, far);
            if I::IN_ORDER {
                let noted = (all, &mut pending, &valid);
                settle::<T, I, D, NB, P, G, C>(isa, shared, kernel, targets, noted, &mut groups, exact, counts);
            }
            let run = near_run::<T, I, D, NB, P, G, C, 0, true>(isa, kernel, laplacian, left, &mut groups);
            left = skip(left, run);
            near += run;
        }
        counts.all_near_blocks += near as u64;
        counts.polynomial_blocks += near as u64;
        counts.near_pairs += near as u64 * valid_lanes;
        let noted = (all, &mut pending, &valid);
        settle::<T, I, D, NB, P, G, C>(isa, shared, kernel, targets, noted, &mut groups, exact, counts);
        // A compensated sum has nothing to gain from blocks.
        if !C {
            for (total, group) in total.iter_mut().zip(&mut groups) {
                total.sums.add(isa, &group.sums);
                group.sums = zero;
            }
        }
    }
    if C {
        for (total, group) in total.iter_mut().zip(&groups) {
            total.sums = group.sums;
            total.sums.add(isa, &group.lost);
        }
    }
    exact.wild(shared, targets, counts);
    total
}

/// Adds the sources that were noted to the lanes inside the support.
#[inline(always)]
#[expect(clippy::too_many_arguments, reason = "a part of the loop above")]
fn settle<T: Real, I: Isa<T>, const D: usize, const NB: usize, const P: bool, const G: bool, const C: bool>(
    isa: I,
    shared: &Shared<'_, T, D>,
    kernel: &Softened<I::V>,
    targets: &[[T; D]],
    ((positions, masses), pending, valid): (List<'_, T, D>, &mut Pending, &[u32; NB]),
    groups: &mut [Group<I::V, D>; NB],
    exact: &mut Exacts<T, D>,
    counts: &mut Counters,
) {
    for at in pending.take() {
        let (Some(x), Some(&m)) = (positions.get(at), masses.get(at)) else { continue };
        let lanes = inside::<T, I, D, NB, P, G, C>(isa, kernel, shared.wanted.laplacian, x, m, groups);
        if kernel.has_polynomials() {
            counts.polynomial_blocks += 1;
            for (lanes, valid) in lanes.iter().zip(valid) {
                counts.near_pairs += u64::from((lanes & valid).count_ones());
            }
        } else {
            exact.pairs::<NB>(shared, I::LANES, targets, x, m, lanes, counts);
        }
    }
}

/// The bounds of targets in units.
#[inline(always)]
fn block_bounds<T: Real, const D: usize>(shared: &Shared<'_, T, D>, targets: &[[T; D]]) -> Bounds<T, D> {
    let mut scaled = [[T::ZERO; D]; WIDE * MAX_LANES];
    scaled.iter_mut().zip(targets).for_each(|(scaled, x)| *scaled = shared.units.point(x).0);
    bounds_of(scaled.get(..targets.len()).unwrap_or(&[]))
}

/// The list without its first `n`.
#[inline(always)]
fn skip<'a, T, const D: usize>((positions, masses): List<'a, T, D>, n: usize) -> List<'a, T, D> {
    (positions.get(n..).unwrap_or(&[]), masses.get(n..).unwrap_or(&[]))
}

/// Targets in units, one a lane; lanes beyond the last repeat it.
#[inline(always)]
fn load<T: Real, I: Isa<T>, const D: usize>(isa: I, units: Units<T>, targets: &[[T; D]]) -> [I::V; D] {
    let mut lanes = [[T::ZERO; MAX_LANES]; D];
    let last = targets.last().copied().unwrap_or([T::ZERO; D]);
    for l in 0..MAX_LANES {
        let (x, _) = units.point(targets.get(l).unwrap_or(&last));
        for (lanes, x) in lanes.iter_mut().zip(x) {
            if let Some(lane) = lanes.get_mut(l) {
                *lane = x;
            }
        }
    }
    lanes.map(|lanes| isa.load(&lanes))
}

/// Sums of the scaled path for one target, in true units and without the coefficient.
#[derive(Clone, Copy, Debug)]
struct Exact<T, const D: usize> {
    potential: T,
    gradient: [T; D],
    laplacian: T,
    /// The target is wild: these are all its pairs, and its lane's sums mean nothing.
    alone: bool,
}

impl<T: Real, const D: usize> Exact<T, D> {
    const ZERO: Self = Self { potential: T::ZERO, gradient: [T::ZERO; D], laplacian: T::ZERO, alone: false };

    /// Adds one pair, whatever its distance: the blob's own functions scale it.
    fn add(&mut self, shared: &Shared<'_, T, D>, target: &[T; D], source: &[T; D], mass: T, counts: &mut Counters) {
        let (blob, wanted) = (shared.kernel.blob, shared.wanted);
        let mut x = *target;
        x.iter_mut().zip(source).for_each(|(x, &s)| *x -= s);
        if blob.mollifier() == Mollifier::None && x.iter().all(|&x| x == T::ZERO) {
            return;
        }
        counts.scaled_pairs += 1;
        if wanted.potential {
            self.potential += mass * blob.potential_at(&x);
        }
        if wanted.gradient {
            self.gradient.iter_mut().zip(blob.gradient_at(&x)).for_each(|(sum, g)| *sum += mass * g);
        }
        if wanted.laplacian {
            self.laplacian += mass * blob.density_at(&x);
        }
    }
}

/// The scaled path's sums of a register block.
struct Exacts<T, const D: usize> {
    of: [Exact<T, D>; WIDE * MAX_LANES],
    used: bool,
}

impl<T: Real, const D: usize> Exacts<T, D> {
    fn new() -> Self {
        Self { of: [Exact::ZERO; WIDE * MAX_LANES], used: false }
    }

    /// Adds a tame source to those targets whose bit is set.
    #[cold]
    #[inline(never)]
    #[expect(clippy::too_many_arguments, reason = "the cold half of the loop")]
    fn pairs<const NB: usize>(
        &mut self,
        shared: &Shared<'_, T, D>,
        each: usize,
        targets: &[[T; D]],
        source: &[T; D],
        mass: T,
        lanes: [u32; NB],
        counts: &mut Counters,
    ) {
        let source = source.map(|x| x.ldexp(-shared.units.position));
        let mass = mass.ldexp(-shared.units.mass);
        let in_block = |i: usize| lanes.get(i / each.max(1)).is_some_and(|l| l >> (i % each.max(1)) & 1 == 1);
        for (i, (target, sums)) in targets.iter().zip(&mut self.of).enumerate() {
            if in_block(i) {
                sums.add(shared, target, &source, mass, counts);
            }
        }
        self.used = true;
    }

    /// Adds wild sources to all targets, and all sources to wild targets.
    #[inline(always)]
    fn wild(&mut self, shared: &Shared<'_, T, D>, targets: &[[T; D]], counts: &mut Counters) {
        if shared.packed.has_wild() || targets.iter().any(|x| shared.units.point(x).1) {
            self.wild_pairs(shared, targets, counts);
        }
    }

    #[cold]
    #[inline(never)]
    fn wild_pairs(&mut self, shared: &Shared<'_, T, D>, targets: &[[T; D]], counts: &mut Counters) {
        self.used = true;
        for (target, sums) in targets.iter().zip(&mut self.of) {
            if shared.units.point(target).1 {
                *sums = Exact { alone: true, ..Exact::ZERO };
                let (positions, masses) = shared.packed.tame();
                for (x, m) in positions.iter().zip(masses) {
                    let x = x.map(|x| x.ldexp(-shared.units.position));
                    sums.add(shared, target, &x, m.ldexp(-shared.units.mass), counts);
                }
            }
            for (x, m) in shared.packed.wild() {
                sums.add(shared, target, x, m, counts);
            }
        }
    }
}

/// The way from sums in units to results.
pub(super) struct Scales<T> {
    coefficient: T,
    combination: Option<(T, T)>,
    /// coefficient / S_D, and the power of two that leads back to true units.
    pub potential: (T, i32),
    pub gradient: (T, i32),
    pub laplacian: (T, i32),
}

impl<T: Real> Scales<T> {
    #[inline(always)]
    pub fn new<const D: usize>(coefficient: T, units: Units<T>, options: &Options) -> Self {
        let factor = coefficient / T::from_f64(sphere(D));
        let (mass, length) = (-units.mass, units.position);
        let d = D as i32;
        let (a, b) = options.combination;
        Self {
            coefficient,
            combination: ((a, b) != (1.0, 0.0)).then(|| (T::from_f64(a), T::from_f64(b))),
            // In 2D the lanes added up log r^2.
            potential: match D {
                2 => (T::HALF * factor, mass),
                _ => (factor, mass + (d - 2) * length),
            },
            // d is source minus target.
            gradient: (-factor, mass + (d - 1) * length),
            laplacian: (factor, mass + d * length),
        }
    }

    /// A sum in units and one of the scaled path, in true units.
    #[inline(always)]
    fn total(&self, sum: T, (factor, exponent): (T, i32), exact: T) -> T {
        (sum * factor).ldexp(exponent) + self.coefficient * exact
    }

    /// A sum that has no pair on the scaled path.
    #[inline(always)]
    pub fn value(&self, sum: T, scale: (T, i32)) -> T {
        self.total(sum, scale, T::ZERO)
    }

    /// [`Options::combination`] of a gradient.
    #[inline(always)]
    pub fn combine<const D: usize>(&self, gradient: &mut [T; D]) {
        if let (Some((a, b)), [x, y, ..]) = (self.combination, gradient.as_mut_slice()) {
            (*x, *y) = (a * *x - b * *y, a * *y + b * *x);
        }
    }
}

/// Turns sums in units into results.
struct Writer<'a, T: Real, const D: usize> {
    potential: Option<core::slice::IterMut<'a, T>>,
    gradient: Option<core::slice::IterMut<'a, [T; D]>>,
    laplacian: Option<core::slice::IterMut<'a, T>>,
    scales: Scales<T>,
}

impl<'a, T: Real, const D: usize> Writer<'a, T, D> {
    #[inline(always)]
    fn new(shared: &Shared<'_, T, D>, outputs: Outputs<'a, T, D>) -> Self {
        Self {
            potential: outputs.potential.map(|p| p.iter_mut()),
            gradient: outputs.gradient.map(|g| g.iter_mut()),
            laplacian: outputs.laplacian.map(|l| l.iter_mut()),
            scales: Scales::new::<D>(shared.kernel.coefficient, shared.units, shared.options),
        }
    }

    #[inline(always)]
    fn block<I: Isa<T>, const NB: usize>(
        &mut self,
        isa: I,
        n: usize,
        groups: &[Group<I::V, D>; NB],
        exact: &mut Exacts<T, D>,
    ) {
        let scales = &self.scales;
        let mut left = n;
        for (group, exact) in groups.iter().zip(exact.of.chunks(I::LANES)) {
            let here = left.min(I::LANES);
            left -= here;
            if let Some(to) = &mut self.potential {
                let sums = isa.store(group.sums.potential);
                for ((to, sum), exact) in to.by_ref().take(here).zip(sums).zip(exact) {
                    let sum = if exact.alone { T::ZERO } else { sum };
                    *to = scales.total(sum, scales.potential, exact.potential);
                }
            }
            if let Some(to) = &mut self.gradient {
                let sums = group.sums.gradient.map(|v| isa.store(v));
                for (lane, (to, exact)) in to.by_ref().take(here).zip(exact).enumerate() {
                    for ((to, sums), &exact_sum) in to.iter_mut().zip(&sums).zip(&exact.gradient) {
                        let sum = sums.get(lane).copied().filter(|_| !exact.alone).unwrap_or(T::ZERO);
                        *to = scales.total(sum, scales.gradient, exact_sum);
                    }
                    scales.combine(to);
                }
            }
            if let Some(to) = &mut self.laplacian {
                let sums = isa.store(group.sums.laplacian);
                for ((to, sum), exact) in to.by_ref().take(here).zip(sums).zip(exact) {
                    let sum = if exact.alone { T::ZERO } else { sum };
                    *to = scales.total(sum, scales.laplacian, exact.laplacian);
                }
            }
        }
        if exact.used {
            *exact = Exacts::new();
        }
    }
}

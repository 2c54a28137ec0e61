//! A kernel as one table: powers, exponentials, screened, a host's own and sums of these, and Gaussian mollifiers and combinations near the source.
//!
//! With u = (r / unit)^2 + shift ([`Table`]), the row of u is found from its bits, and with t = u - (the row's least u)
//!
//! ```text
//! g   = c_0 + c_1 t + ... + c_n t^n                     the gradient factor, grad K = g x
//! K   = k_0 + (c_0 t + c_1 t^2 / 2 + ...) / 2           as dK / d(r^2) = g / 2
//! lap = D g + 2 (u - shift) (c_1 + 2 c_2 t + ...)       as lap K = D g + r g'
//! ```
//!
//! all in the table's units. So one row, a cache line in f64, serves every output, and there is no root, logarithm or division.
//!
//! # Error
//! r2 has 5 u and u one more, which moves g by |d log g / d log u| times as much: a few units for powers, r / l for an exponential of
//! length l, whose size at r/2 is larger by e^(r / 2l). The rows' own errors: module `kernel::table`. So c u s with
//!
//! * s the largest |K|, for gradients r times the largest |K'/r|, for Laplacians the larger of the largest |lap K| and D |K'/r|, over all distances
//!   from r/2 to r, and to delta from 0 where r < delta; of exponential and screened kernels under Gaussian mollifiers over all from 0 to r. (K of a
//!   logarithm is zero somewhere: r^2 |K'/r| counts too.) K is the kernel as [`crate::kernel::Kernel::at`] knows it, and s of a sum of terms is the sum
//!   of theirs;
//! * c = 32 in f32; in f64 128, and 1000 for Laplacians; 400 and 3000 in f64 for exponential and screened kernels whose delta is more
//!   than 5 lengths, which cancel.
//!
//! Tests: `kernel::table::tests`, `field_bounds::single_pairs_of_random_kernels_are_within_the_bound`.

use super::called::{self, Radial};
use super::lanes::{Core, Deferred, GRADIENTS, Group, HESSIANS, POTENTIALS, Want, distances};
use super::output::{Contribution, Scales};
use super::packed::{Units, farthest, least_square_exponent, power_of_two};
use super::{Block, PairKernel, Passes};
use crate::exec::Statistics;
use crate::field::PairRadius;
use crate::kernel::{Table, table_mark, table_terms};
use crate::real::{Real, Scalar};
use crate::simd::{Isa, Part, ROW, Rows};

/// A kernel with its table.
#[derive(Clone, Copy)]
pub(in crate::field) struct Tabulated<'a, T> {
    pub table: Table<'a, T>,
    /// The kernel itself, for distances that the table does not hold.
    pub kernel: &'a dyn Radial,
}

/// The table in the call's units.
#[derive(Clone, Copy)]
pub(in crate::field) struct Prepared<'a, T> {
    rows: &'a Rows<T>,
    numbers: Lanes<T>,
    /// The least r^2, in units, at which the table ends.
    end: T,
    /// Whether the kernel is zero there and beyond.
    ends: bool,
    /// Whether some u below the end is not served: next to zero, or in the gap.
    has_gaps: bool,
    /// Whether the table has ranges without Laplacians.
    is_rough: bool,
    /// Whether rows are marked: their pairs are left out.
    is_marked: bool,
    /// Pairs with r^2 from this on, in units, are counted, if `has_reach`.
    reach: T,
    has_reach: bool,
}

/// Its numbers, in every lane.
#[derive(Clone, Copy, Debug)]
pub(in crate::field) struct Lanes<C> {
    /// u is r^2, in units, times this plus `shift`.
    scale: C,
    shift: C,
    /// The table holds u from `first` to below `last`, but not from `gap[0]` to below `gap[1]`.
    first: C,
    last: C,
    gap: [C; 2],
    /// Where it does not serve Laplacians.
    rough: [C; 2],
    /// An argument inside the table, substituted in lanes that are not served.
    held: C,
    /// The least c_0 of marked rows.
    mark: C,
}

impl<T: Real> Prepared<'_, T> {
    pub fn numbers(&self) -> &Lanes<T> {
        &self.numbers
    }
}

impl<T: Real> Lanes<T> {
    #[inline(always)]
    pub fn lanes<I: Isa<T>>(&self, isa: I) -> Lanes<I::V> {
        let [from, to] = self.gap;
        let [rough_from, rough_to] = self.rough;
        Lanes {
            scale: isa.splat(self.scale),
            shift: isa.splat(self.shift),
            first: isa.splat(self.first),
            last: isa.splat(self.last),
            gap: [isa.splat(from), isa.splat(to)],
            rough: [isa.splat(rough_from), isa.splat(rough_to)],
            held: isa.splat(self.held),
            mark: isa.splat(self.mark),
        }
    }
}

impl<V: Copy> Lanes<V> {
    #[inline(always)]
    fn u<T: Real, I: Isa<T, V = V>>(&self, isa: I, r2: V) -> V {
        isa.mul_add(r2, self.scale, self.shift)
    }

    /// The lanes that the table serves, and one bit for each that it leaves out: where it ends with the kernel, lanes beyond are neither.
    #[inline(always)]
    fn served<T: Real, I: Isa<T, V = V>>(&self, isa: I, u: V, ends: bool) -> (I::M, u32) {
        let [from, to] = self.gap;
        let beyond_gap = isa.select(isa.lt(u, from), u, self.last);
        let checked = isa.select(isa.lt(u, to), beyond_gap, u);
        let served = isa.lt(isa.select(isa.lt(u, self.first), self.last, checked), self.last);
        let all = u32::MAX >> (32 - I::LANES as u32);
        let within = if ends { isa.bits(isa.lt(u, self.last)) } else { all };
        (served, within & !isa.bits(served))
    }

    /// One bit for each lane whose Laplacian is left out, and the other lanes.
    #[inline(always)]
    fn rough<T: Real, I: Isa<T, V = V>>(&self, isa: I, u: V) -> (I::M, u32) {
        let [from, to] = self.rough;
        let smooth = isa.lt(isa.select(isa.lt(u, to), u, isa.splat(T::ZERO)), from);
        let all = u32::MAX >> (32 - I::LANES as u32);
        (smooth, all & !isa.bits(smooth))
    }
}

impl<'a, T: Real, const D: usize> PairKernel<T, D> for Tabulated<'a, T> {
    type Prepared = Prepared<'a, T>;
    type Lanes<V: Copy> = Lanes<V>;

    const PASSES: Passes = Passes::One;

    fn length(&self) -> T {
        T::ZERO
    }

    fn prepare(&self, units: Units<T>, _rule: PairRadius, _potentials: bool) -> Prepared<'a, T> {
        let table = &self.table.head;
        let (unit, exponent) = table.unit.frexp();
        // r / unit = (r in units) 2^-position / unit
        let twice = (units.position + exponent).saturating_mul(-2);
        let scale = T::from_f64(1.0 / (unit * unit)).ldexp(twice);
        let real = T::from_f64;
        let shift = real(table.shift);
        // Where the table's unit is so small beside the coordinates that u leaves the scalar's range, nothing is served but r = 0, and that by the
        // functions too: an empty range.
        let fits = scale.is_finite() && scale < T::MAX * T::from_f64(1.0 / 64.0);
        let (scale, mut first) = if fits { (scale, real(table.first)) } else { (T::ONE, T::MAX) };
        if table.shift == 0.0 {
            // Closer pairs are left out: their r2, in units, may be below the normal range.
            first = first.max(power_of_two::<T>(-least_square_exponent::<T>()) * scale);
        }
        let (gap, rough) = (table.gap.map(real), table.rough.map(real));
        let (held, mark) = (real(table.first), table_mark());
        let numbers = Lanes { scale, shift, first, last: real(table.last), gap, rough, held, mark };
        let has_gaps = !fits || table.first > table.shift || table.gap[0] < table.gap[1];
        let is_rough = table.rough[0] < table.rough[1];
        let has_reach = table.reach < f64::INFINITY;
        let reach = if has_reach { table.reach.ldexp(units.position) } else { 0.0 };
        let end = if fits { (table.last - table.shift) / scale.to_f64() } else { 0.0 };
        Prepared {
            rows: self.table.rows,
            numbers,
            end: real(end.min(T::MAX.to_f64())),
            ends: table.ends,
            has_gaps,
            is_rough,
            is_marked: table.marked,
            reach: real((reach * reach).min(T::MAX.to_f64())).max(T::MIN_POSITIVE),
            has_reach,
        }
    }

    fn scales(&self, units: Units<T>, class: usize) -> Scales<T> {
        let table = &self.table.head;
        let mass = -units.class(class);
        let (unit, exponent) = table.unit.frexp();
        let per_square = T::from_f64(1.0 / (unit * unit));
        let of_gradient = table.exponent - 2 * exponent + mass;
        Scales {
            potential: (T::ONE, table.exponent + mass),
            // d is source minus target, and in units.
            gradient: (-per_square, of_gradient - units.position),
            laplacian: (per_square, of_gradient),
        }
    }

    #[inline(always)]
    fn lanes<I: Isa<T>>(prepared: &Prepared<'a, T>, isa: I) -> Lanes<I::V> {
        prepared.numbers.lanes(isa)
    }

    #[inline(always)]
    fn add_block<I: Isa<T>, const NB: usize, const P: u8>(
        isa: I,
        prepared: (&Prepared<'a, T>, &Lanes<I::V>),
        block: &Block<'_, T, D>,
        groups: &mut [Group<I::V, D>; NB],
        noted: &mut [Deferred; 2],
        counts: &mut Statistics,
    ) {
        if prepared.0.has_reach {
            let [a, b] = block.bounds;
            if farthest(a, b) >= prepared.0.reach {
                counts.beyond_reach += isa.apart(Beyond { reach: prepared.0.reach, block, groups: &*groups });
            }
        }
        match P {
            HESSIANS => isa.apart(AddSources::<_, _, D, NB, HESSIANS> { prepared, block, groups, noted }),
            POTENTIALS if block.potential => {
                isa.apart(AddSources::<_, _, D, NB, POTENTIALS> { prepared, block, groups, noted });
            }
            _ => isa.apart(AddSources::<_, _, D, NB, GRADIENTS> { prepared, block, groups, noted }),
        }
    }

    #[inline(always)]
    fn left_out<I: Isa<T>, const NB: usize, const P: u8>(
        isa: I,
        (prepared, numbers): (&Prepared<'a, T>, &Lanes<I::V>),
        (source, _): (&[T; D], Option<&T>),
        groups: &[Group<I::V, D>; NB],
        laplacian: bool,
    ) -> [u32; NB] {
        let (_, r2) = distances(isa, source, groups);
        let mut all = [0; NB];
        for (lanes, &r2) in all.iter_mut().zip(&r2) {
            let u = numbers.u(isa, r2);
            let (served, left_out) = numbers.served(isa, u, prepared.ends);
            let (mut served, mut left_out) = (isa.bits(served), left_out);
            if prepared.is_marked {
                let row = Row::of(isa, prepared.rows, u);
                let marked = served & !isa.bits(row.is_used(isa, numbers.mark));
                (served, left_out) = (served & !marked, left_out | marked);
            }
            // What is left out as a whole is not left out once more.
            *lanes = if laplacian { numbers.rough(isa, u).1 & served } else { left_out };
        }
        all
    }

    fn exact(&self, x: &[T; D], mass: T, _radius: Option<T>, want: Want) -> Contribution<T, D> {
        called::pair(self.kernel, x, mass, want)
    }
}

/// What the sources of a block give to a register block of targets, with potentials if the pass sums them; a function of its own.
struct AddSources<'a, T: Real, V, const D: usize, const NB: usize, const P: u8> {
    prepared: (&'a Prepared<'a, T>, &'a Lanes<V>),
    block: &'a Block<'a, T, D>,
    groups: &'a mut [Group<V, D>; NB],
    noted: &'a mut [Deferred; 2],
}

impl<T: Real, I: Isa<T>, const D: usize, const NB: usize, const P: u8> Part<T, I>
    for AddSources<'_, T, I::V, D, NB, P>
{
    type Out = ();

    #[inline(always)]
    fn run(self, isa: I) {
        let Self { prepared: (prepared, numbers), block, groups, noted: [noted, noted_rough] } = self;
        let [a, b] = block.bounds;
        let all_served = !prepared.has_gaps && farthest(a, b) < prepared.end;
        let zero = isa.splat(T::ZERO);
        let all = u32::MAX >> (32 - I::LANES as u32);
        let mut local = *groups;
        for (at, (x, &m)) in block.sources.0.iter().zip(block.sources.1).enumerate() {
            let (d, r2) = distances(isa, x, &local);
            let mass = isa.splat(m);
            let (mut left_out, mut rough) = (0, 0);
            for ((group, d), &r2) in local.iter_mut().zip(&d).zip(&r2) {
                let mut u = numbers.u(isa, r2);
                let mut factor = mass;
                if !all_served {
                    let (served, left) = numbers.served(isa, u, prepared.ends);
                    left_out |= left;
                    u = isa.select(served, u, numbers.held);
                    factor = isa.select(served, mass, zero);
                }
                let row = Row::of(isa, prepared.rows, u);
                if prepared.is_marked {
                    let used = row.is_used(isa, numbers.mark);
                    left_out |= all & !isa.bits(used);
                    factor = isa.select(used, factor, zero);
                }
                group.add_gradient::<_, _, P>(isa, isa.mul(factor, row.gradient(isa)), d);
                if P == POTENTIALS {
                    group.add_potential(isa, factor, row.potential(isa));
                }
                if block.laplacian {
                    let mut laplacian = row.laplacian::<D>(isa, isa.sub(u, numbers.shift));
                    if prepared.is_rough {
                        let (smooth, lanes) = numbers.rough(isa, u);
                        rough |= lanes;
                        laplacian = isa.select(smooth, laplacian, zero);
                    }
                    group.add_laplacian::<_, _, P>(isa, factor, laplacian, d);
                }
            }
            if left_out != 0 {
                noted.push(at);
            }
            if rough != 0 {
                noted_rough.push(at);
            }
        }
        *groups = local;
    }
}

/// Counts the pairs of a block that are beyond a host's reach.
struct Beyond<'a, T: Real, V, const D: usize, const NB: usize> {
    reach: T,
    block: &'a Block<'a, T, D>,
    groups: &'a [Group<V, D>; NB],
}

impl<T: Real, I: Isa<T>, const D: usize, const NB: usize> Part<T, I> for Beyond<'_, T, I::V, D, NB> {
    type Out = u64;

    #[inline(always)]
    fn run(self, isa: I) -> u64 {
        let reach = isa.splat(self.reach);
        let mut count = 0;
        for x in self.block.sources.0 {
            let (_, r2) = distances(isa, x, self.groups);
            for (&r2, &valid) in r2.iter().zip(self.block.valid) {
                count += u64::from((valid & !isa.bits(isa.lt(r2, reach))).count_ones());
            }
        }
        count
    }
}

/// Adds what one source gives to the lanes below the edge, and to no other, from a table that serves all of these and from the differences, source
/// minus target, and their squares; its potential and gradient factor are multiplied by `scales`. With core radii of their own pairs come with the numbers of these. Returns one word of lanes a vector.
#[inline(always)]
pub(super) fn add_below<T: Real, I: Isa<T>, const D: usize, const NB: usize, const P: u8, const EACH: bool>(
    isa: I,
    edges: &[I::V; NB],
    (prepared, numbers, [potential, gradient]): (&Prepared<'_, T>, &Lanes<I::V>, [I::V; 2]),
    [wants_potential, laplacian]: [bool; 2],
    (d, r2): (&[[I::V; D]; NB], &[I::V; NB]),
    (mass, core): (T, Option<&[Core<I::V>; NB]>),
    groups: &mut [Group<I::V, D>; NB],
) -> [u32; NB] {
    let zero = isa.splat(T::ZERO);
    let (mass, mut lanes) = (isa.splat(mass), [0; NB]);
    let (potential, gradient) = (isa.mul(mass, potential), isa.mul(mass, gradient));
    let plain = Core { ratio_square: mass, factors: [mass; 2], offset: zero };
    let cores = core.copied().unwrap_or([plain; NB]);
    for (((((group, d), &r2), lanes), &edge), core) in
        groups.iter_mut().zip(d).zip(r2).zip(&mut lanes).zip(edges).zip(&cores)
    {
        let below = isa.lt(r2, edge);
        *lanes = isa.bits(below);
        let r2 = if EACH { isa.mul(r2, core.ratio_square) } else { r2 };
        let u = isa.select(below, numbers.u(isa, r2), numbers.held);
        let row = Row::of(isa, prepared.rows, u);
        if wants_potential {
            let of_core = if EACH { isa.mul(potential, core.factors[1]) } else { potential };
            group.add_potential(isa, isa.select(below, of_core, zero), row.potential(isa));
            if EACH && D == 2 {
                group.add_potential(isa, isa.select(below, mass, zero), core.offset);
            }
        }
        if P != POTENTIALS || D != 2 {
            let of_core = if EACH { isa.mul(gradient, core.factors[0]) } else { gradient };
            let factor = isa.select(below, of_core, zero);
            group.add_gradient::<_, _, P>(isa, isa.mul(factor, row.gradient(isa)), d);
            if laplacian {
                group.add_laplacian::<_, _, P>(isa, factor, row.laplacian::<D>(isa, isa.sub(u, numbers.shift)), d);
            }
        }
    }
    lanes
}

/// The rows of a vector of numbers, and where these lie in their rows.
struct Row<V, T, I> {
    columns: [V; ROW],
    t: V,
    of: core::marker::PhantomData<(T, I)>,
}

impl<T: Real, I: Isa<T>> Row<I::V, T, I> {
    #[inline(always)]
    fn of(isa: I, table: &Rows<T>, u: I::V) -> Self {
        let (rows, least) = isa.rows(u);
        Self { columns: isa.look_up(table, rows), t: isa.sub(u, least), of: core::marker::PhantomData }
    }

    /// The lanes whose rows are not marked.
    #[inline(always)]
    fn is_used(&self, isa: I, mark: I::V) -> I::M {
        let [first, ..] = self.columns;
        isa.lt(first, mark)
    }

    /// Horner's rule over c_0, c_1, ..., each times its factor.
    #[inline(always)]
    fn horner(&self, isa: I, from: usize, factor: impl Fn(usize) -> f64) -> I::V {
        let terms = table_terms::<T>();
        let mut sum = isa.splat(T::ZERO);
        for (k, &c) in self.columns.iter().enumerate().take(terms).skip(from).rev() {
            let c = match factor(k) {
                1.0 => c,
                f => isa.mul(c, isa.splat(T::from_f64(f))),
            };
            sum = if k + 1 == terms { c } else { isa.mul_add(sum, self.t, c) };
        }
        sum
    }

    #[inline(always)]
    fn gradient(&self, isa: I) -> I::V {
        self.horner(isa, 0, |_| 1.0)
    }

    #[inline(always)]
    fn potential(&self, isa: I) -> I::V {
        let constant = self.columns.get(table_terms::<T>()).copied().unwrap_or(self.t);
        isa.mul_add(self.horner(isa, 0, |k| 0.5 / (k as f64 + 1.0)), self.t, constant)
    }

    /// `square` is u - shift.
    #[inline(always)]
    fn laplacian<const D: usize>(&self, isa: I, square: I::V) -> I::V {
        let slope = self.horner(isa, 1, |k| 2.0 * k as f64);
        isa.mul_add(square, slope, isa.mul(isa.splat(T::from_usize(D)), self.gradient(isa)))
    }
}

//! The Newtonian kernel, mollified or not: one source against one register block of targets.
//!
//! Lanes are targets. With d = x_source - x_target and r2 = |d|^2 in the units of [`super::packed`], and S_D = 2, 2 pi, 4 pi:
//!
//! | | outside delta | inside, t = 1 - r2 / delta^2 (powers of t: nothing cancels) |
//! |---|---|---|
//! | S_D g, grad K = g x | r^-D | delta^-D G(t) |
//! | S_D K | \|x\|, log r, -1/r | delta (c + s R(t) / 2), log delta + P(t), P(t) / delta |
//! | S_D Laplacian K | 0 | delta^-D b(t) |
//!
//! A register block of targets meets one source after the other. If no lane is inside, no polynomial is evaluated ([`far_run`]); if all are,
//! nothing is divided ([`near_run`]); a block with some lanes inside adds the others and is noted, and gets its polynomials later
//! ([`inside_pairs`]), so that the common loop keeps its registers. In 2D the mass goes into the numerator, m / r2, with one division for two
//! vectors (four: f64, AVX-512); in 3D m / r^3 comes from the machine's square root and a shared division (AVX2) or from a 14-bit seed y and the series of
//! (1 - e)^(-3/2), e = 1 - r2 y^2 (AVX-512). In one and two dimensions potentials have a pass of their own.
//!
//! A Gaussian mollifier's field is Newtonian to rounding beyond some lengths delta, that of a Richardson combination exactly beyond delta; within them it is read from the
//! kernel's table ([`super::tabulated`]) where it was prepared with one.
//!
//! # Rounding
//! With u the unit roundoff and to first order: a coordinate difference has 1 u, r2 has 5 u. Outside, g has in 1D 2 u, in 2D 10 u (r2, 3 to 5 u
//! of the shared division), in 3D 12 u (1.5 times r2's, square root, product, shared division, or the series and its cut); inside at most
//! 12 u for orders 2 and 4 (`Polynomials`). The products by d and by the coefficient add 4 u: c = 16. At orders 6 and 8 the polynomials have
//! coefficients of both signs: c = 16 + 12 q, q the sum of their magnitudes over the function's maximum (up to 8, at order 8, M = 8, D = 3).
//! The 2D potential is the logarithm of a rounded number, which has a zero at r = 1: its error is relative to |log r| + 1. The density has zeros too:
//! its error is relative to its maximum, and its polynomial in t is steep where t is near 1: order 6 has been seen to lose 119 u, order 8 (M = 9, D = 1)
//! 920 u, for which twice as much is stated (test `field_bounds::laplacians_of_every_mollifier`).

pub(super) mod inside;

use super::close::step;
use super::lanes::{Core, Deferred, Group, List, POTENTIALS, Want, arms, cores, distances, kept, margins};
use super::output::{Contribution, Scales};
use super::packed::{Units, farthest, least_square_exponent, power_of_two};
use super::tabulated::{self, Tabulated};
use super::{Block, PairKernel, Passes};
use crate::checked::Present;
use crate::exec::Statistics;
use crate::field::PairRadius;
use crate::kernel::sphere;
use crate::mollifier::{Blob, Mollifier, gaussian_weights};
use crate::real::Real;
use crate::simd::{Isa, Part, log, log_numerator, log_of};
use inside::Inside;

/// A Newtonian kernel: `coefficient` times the blob's potential; if `EACH`, every source has a core radius of its own in place of the blob's delta.
///
/// Vector strengths (`VECTOR`) have core radii too, all of them delta if the caller has none.
///
/// With core radii the functions inside are those of the blob's delta in units of its own, at distances times delta / radius.
pub(in crate::field) struct Newtonian<'a, T: Real, const D: usize, const EACH: bool, const VECTOR: bool> {
    pub blob: &'a Blob<T, D>,
    pub coefficient: T,
    /// The largest core radius: delta, if it is the only one.
    pub largest: T,
    /// Where the mollifier is Gaussian or a combination: its field near the source.
    pub table: Option<Tabulated<'a, T>>,
}

/// The kernel in units: what the lanes know of it.
pub(in crate::field) struct Prepared<'a, T: Real> {
    softened: Softened<T>,
    /// The table of a Gaussian mollifier or of a combination, and what its potential and gradient factor are multiplied by to be S_D K (twice that in 2D) and S_D g.
    table: Option<(tabulated::Prepared<'a, T>, [T; 2])>,
    /// Whether pairs are left out because they are too close for the fast path.
    has_closer: bool,
    /// Whether the gradient's polynomial inside a compact mollifier has [`UNROLLED`] terms, and delta is not too small for [`Inside::shifted`].
    is_usual: bool,
    each: Each<T>,
}

/// What leads from a core radius to its source's numbers.
#[derive(Clone, Copy)]
struct Each<T> {
    /// delta^2 in its own units.
    square: T,
    /// The square of the support of a Gaussian mollifier of length 1, or 1.
    support_square: T,
    /// log delta in 2D.
    log_delta: T,
    /// A true length is one in units times 2 to minus this.
    position: i32,
    /// How sources' core radii become those of pairs.
    rule: PairRadius,
}

impl<T: Real> Each<T> {
    /// Of a core as [`PairKernel::core`] keeps it, with the potential's offset if the pass sums potentials; `None`: the radius is too small for lanes.
    #[inline(always)]
    fn core<const D: usize, const P: u8>(&self, core: T, has_table: bool) -> Option<Core<T>> {
        if core <= power_of_two::<T>(-least_square_exponent::<T>()) {
            return None;
        }
        let ratio_square = self.square * self.support_square / core;
        if D == 2 && P != POTENTIALS {
            return Some(Core { ratio_square, factors: [ratio_square, T::ONE], offset: T::ZERO });
        }
        let square = core / self.support_square;
        let ratio = ratio_square.sqrt();
        let (factors, offset) = match D {
            1 => ([ratio, T::ONE / ratio], T::ZERO),
            2 => {
                let log = square.sqrt().ldexp(-self.position).log();
                // The table's potential has log delta in it.
                let offset = T::TWO * if has_table { log - self.log_delta } else { log };
                ([ratio_square, T::ONE], offset)
            }
            _ => ([ratio_square * ratio, ratio], T::ZERO),
        };
        Some(Core { ratio_square, factors, offset })
    }

    /// The numbers of a source's pairs with each vector of targets, whose cores are these; `None`: some radius is too small for lanes.
    #[inline(always)]
    fn cores<I: Isa<T>, const D: usize, const NB: usize, const P: u8>(
        &self,
        isa: I,
        of_source: T,
        edges: &[I::V; NB],
        has_table: bool,
    ) -> Option<[Core<I::V>; NB]> {
        if NB > 1 {
            return self.core::<D, P>(of_source, has_table).map(|core| core.splat(isa));
        }
        let least = power_of_two::<T>(1 - least_square_exponent::<T>());
        if isa.any_below(edges, isa.splat(least)) {
            return None;
        }
        let (zero, one) = (isa.splat(T::ZERO), isa.splat(T::ONE));
        let mut cores = [Core { ratio_square: one, factors: [one; 2], offset: zero }; NB];
        for (core, &edge) in cores.iter_mut().zip(edges) {
            core.ratio_square = isa.div(isa.splat(self.square * self.support_square), edge);
            if D == 2 {
                core.factors = [core.ratio_square, one];
                if P == POTENTIALS {
                    let square = isa.mul(edge, isa.splat(T::ONE / self.support_square));
                    let value = log_of(isa, square, isa.splat(T::from_i32(self.position.saturating_mul(-2))));
                    let of_table = if has_table { T::TWO * self.log_delta } else { T::ZERO };
                    core.offset = isa.sub(value, isa.splat(of_table));
                }
                continue;
            }
            let ratio = isa.sqrt(core.ratio_square);
            core.factors =
                if D == 1 { [ratio, isa.div(one, ratio)] } else { [isa.mul(core.ratio_square, ratio), ratio] };
        }
        Some(cores)
    }
}

/// In space the potential needs the gradient's root, in the plane the two share nothing but the distance, on the line neither costs much.
pub(super) const fn passes(dimension: usize, vector: bool) -> Passes {
    match dimension {
        _ if vector => Passes::None,
        1 => Passes::One,
        2 => Passes::Apart,
        _ => Passes::Together,
    }
}

/// Whether a pass computes potentials, known while compiling but on the line.
#[inline(always)]
pub(super) fn wants_potential<const D: usize, const P: u8>(wanted: bool) -> bool {
    P == POTENTIALS && (D > 1 || wanted)
}

/// Terms of the gradient's polynomial that is unrolled: those of M = 4, order 2, the paper's choice.
const UNROLLED: usize = 5;

/// Constants of a Newtonian kernel, mollified or not.
#[derive(Clone, Copy, Debug)]
pub(in crate::field) struct Softened<C> {
    /// Lanes with r2 below this are not plainly Newtonian: inside the support, or too close for the fast path.
    edge: C,
    /// Of a compact mollifier whose delta is not too small for lanes; of others without terms. (Not an `Option`: the compiler tests the number of terms
    /// ahead of whether there are any, which a checker of memory would report.)
    inside: Inside<C>,
    /// Added to the exponent of r2, so that its logarithm is that of true units.
    log_exponent: C,
    /// Of a mollifier with a table.
    table: Option<tabulated::Lanes<C>>,
    table_scales: [C; 2],
}

impl<C> Softened<C> {
    /// The inside of a compact mollifier.
    #[inline(always)]
    fn inside(&self) -> Option<&Inside<C>> {
        if self.inside.gradient.terms > 0 { Some(&self.inside) } else { None }
    }
}

/// Whether a Newtonian kernel may have a table: of a Gaussian mollifier, or of a combination.
const TABLES: bool = cfg!(feature = "kernels");

/// Beyond this many delta a Gaussian mollifier's field is Newtonian to rounding: e^{-(r / w delta)^2} < u / e, w delta being the width of its widest part.
fn gaussian_support<T: Real>(dimension: usize, order: u32) -> T {
    let square = gaussian_weights(dimension, order).iter().fold(1.0, |most, &(_, square)| square.max(most));
    T::from_f64(square).sqrt() * (T::from_f64(f64::from(T::DIGITS) * core::f64::consts::LN_2 + 1.0)).sqrt()
}

/// The radius of a mollifier of length 1 beyond which its field is Newtonian, to rounding; none for algebraic ones.
pub(in crate::field) fn support<T: Real>(dimension: usize, mollifier: Mollifier) -> Option<T> {
    match mollifier {
        Mollifier::None => Some(T::ZERO),
        Mollifier::Compact { .. } | Mollifier::Richardson { .. } => Some(T::ONE),
        Mollifier::Gaussian { order } => Some(gaussian_support(dimension, order)),
        Mollifier::Plummer | Mollifier::Algebraic | Mollifier::Vatistas => None,
    }
}

impl<'a, T: Real, const D: usize, const EACH: bool, const VECTOR: bool> PairKernel<T, D>
    for Newtonian<'a, T, D, EACH, VECTOR>
{
    type Prepared = Prepared<'a, T>;
    type Lanes<V: Copy> = Softened<V>;

    const PASSES: Passes = passes(D, VECTOR);
    const RADII: bool = EACH && !VECTOR;

    fn length(&self) -> T {
        self.largest
    }

    fn is_singular(&self) -> bool {
        self.blob.mollifier() == Mollifier::None
    }

    /// The square below which lanes are not plainly Newtonian: that of the support, and for single sources at least that of the least distance that lanes serve ([`edges`]).
    fn core(&self, rule: PairRadius, square: T) -> T {
        let support = match self.blob.mollifier() {
            Mollifier::Gaussian { order } => gaussian_support::<T>(D, order),
            _ => T::ONE,
        };
        let core = square * (support * support);
        match rule {
            PairRadius::Source => core.max(power_of_two::<T>(-least_square_exponent::<T>())),
            _ => kept(rule, core),
        }
    }

    fn prepare(&self, units: Units<T>, rule: PairRadius, potentials: bool) -> Prepared<'a, T> {
        let blob = self.blob;
        let least = power_of_two::<T>(-least_square_exponent::<T>());
        // With core radii delta is a unit of its own.
        let true_units = units.position;
        let units = if EACH { Units { position: -blob.delta().frexp().1, ..units } } else { units };
        let delta = blob.delta().ldexp(units.position);
        let square = delta * delta;
        let (mut edge, mut inside, mut table, mut support_square) = (least, Inside::NONE, None, T::ONE);
        if square >= least {
            match blob.mollifier() {
                Mollifier::Compact { .. } => (edge, inside) = (square, Inside::new(blob, delta, potentials)),
                Mollifier::Gaussian { .. } | Mollifier::Richardson { .. } => {
                    let support = support(D, blob.mollifier()).unwrap_or(T::ONE);
                    support_square = support * support;
                    edge = square * support_square;
                    table = self.table.as_ref().map(|table| {
                        let prepared = PairKernel::<T, D>::prepare(table, units, rule, potentials);
                        let sphere = T::from_f64(sphere(D));
                        let scales = PairKernel::<T, D>::scales(table, units, 0);
                        let of_units = self.scales(units, 0);
                        // Both scales lead to true units, this one less the coefficient.
                        let ratio = |(a, i): (T, i32), (b, j): (T, i32)| (a / b).ldexp(i - j);
                        let unit = |(_, i): (T, i32), sign: T| (sign / sphere, i);
                        let twice = if D == 2 { T::HALF } else { T::ONE };
                        (
                            prepared,
                            [
                                ratio(scales.potential, unit(of_units.potential, twice)),
                                ratio(scales.gradient, unit(of_units.gradient, -T::ONE)),
                            ],
                        )
                    });
                }
                Mollifier::None | Mollifier::Plummer | Mollifier::Algebraic | Mollifier::Vatistas => {}
            }
        }
        if EACH {
            // The sources have offsets of their own.
            inside.offset = if D == 2 { T::ZERO } else { inside.offset };
        }
        let has_closer = !EACH && (square < least || blob.mollifier() == Mollifier::None);
        if let Mollifier::Gaussian { order } = blob.mollifier()
            && has_closer
        {
            let support = gaussian_support::<T>(D, order);
            edge = edge.max(square * (support * support));
        }
        let softened = Softened {
            edge,
            inside,
            log_exponent: T::from_i32(true_units.saturating_mul(-2)),
            table: table.as_ref().map(|(table, _)| *table.numbers()),
            table_scales: table.as_ref().map_or([T::ZERO; 2], |(_, scales)| *scales),
        };
        // Its loop needs coefficients in powers of r2 - delta^2, the last of which is delta^-(D + 8) times a few hundred.
        let exponent = (1 - delta.frexp().1).saturating_mul(D as i32 + 2 * (UNROLLED as i32 - 1));
        let is_usual = inside.gradient.terms == UNROLLED && exponent < T::MAX_EXPONENT - 24;
        let each = Each {
            square,
            support_square,
            log_delta: if EACH && D == 2 && potentials { blob.delta().log() } else { T::ZERO },
            position: true_units,
            rule,
        };
        Prepared { softened, table, has_closer, is_usual, each }
    }

    fn scales(&self, units: Units<T>, class: usize) -> Scales<T> {
        newtonian_scales::<T, D>(self.coefficient, units, class)
    }

    #[inline(always)]
    fn lanes<I: Isa<T>>(prepared: &Prepared<'a, T>, isa: I) -> Softened<I::V> {
        let softened = &prepared.softened;
        let [potential, gradient] = softened.table_scales;
        let inside = &softened.inside;
        let mut lanes = Softened {
            edge: isa.splat(softened.edge),
            inside: Inside {
                per_square: isa.splat(inside.per_square),
                gradient: inside.gradient.lanes(isa),
                potential: inside.potential.lanes(isa),
                offset: isa.splat(inside.offset),
                density: inside.density.lanes(isa),
            },
            log_exponent: isa.splat(softened.log_exponent),
            table: None,
            table_scales: [isa.splat(potential), isa.splat(gradient)],
        };
        if TABLES && let Some(table) = &softened.table {
            lanes.table = Some(table.lanes(isa));
        }
        lanes
    }

    #[inline(always)]
    fn add_block<I: Isa<T>, const NB: usize, const P: u8>(
        isa: I,
        prepared: (&Prepared<'a, T>, &Softened<I::V>),
        block: &Block<'_, T, D>,
        groups: &mut [Group<I::V, D>; NB],
        [noted, _]: &mut [Deferred; 2],
        counts: &mut Statistics,
    ) {
        let (kernel, rule, n) = (prepared.1, prepared.0.each.rule, block.sources.0.len());
        let (mut start, mut near) = (0, 0);
        let [a, b] = block.bounds;
        if !EACH
            && prepared.0.is_usual
            && farthest(a, b) < prepared.0.softened.edge
            && let Some(inside) = kernel.inside()
        {
            // All pairs are near: nothing is tested.
            near = isa.apart(NearRun::<_, _, D, NB, P, UNROLLED, false> { kernel, inside, block, start, groups });
            start = n;
        }
        while start < n {
            // (Only the plane has a method that knows it.)
            start += if const { D == 2 && !VECTOR } && block.apart {
                isa.apart(FarRun::<_, _, D, NB, P, EACH, VECTOR, false> { kernel, rule, block, start, noted, groups })
            } else {
                isa.apart(FarRun::<_, _, D, NB, P, EACH, VECTOR, true> { kernel, rule, block, start, noted, groups })
            };
            if I::IN_ORDER && !noted.is_empty() {
                add_noted::<T, I, D, NB, P, EACH, VECTOR>(isa, prepared, block, groups, noted, counts);
            }
            if !EACH
                && start < n
                && let Some(inside) = kernel.inside()
            {
                let run = isa.apart(NearRun::<_, _, D, NB, P, 0, true> { kernel, inside, block, start, groups });
                start += run;
                near += run;
            }
        }
        if !noted.is_empty() {
            add_noted::<T, I, D, NB, P, EACH, VECTOR>(isa, prepared, block, groups, noted, counts);
        }
        if near > 0 {
            let valid: u32 = block.valid.iter().map(|valid| valid.count_ones()).sum();
            counts.all_near_blocks += near as u64;
            counts.polynomial_blocks += near as u64;
            counts.near_pairs += near as u64 * u64::from(valid);
        }
    }

    #[inline(always)]
    fn left_out<I: Isa<T>, const NB: usize, const P: u8>(
        isa: I,
        (prepared, kernel): (&Prepared<'a, T>, &Softened<I::V>),
        (source, core): (&[T; D], Option<&T>),
        groups: &[Group<I::V, D>; NB],
        _laplacian: bool,
    ) -> [u32; NB] {
        let (_, r2) = distances(isa, source, groups);
        let mut left_out = [0; NB];
        let mut edges = [kernel.edge; NB];
        if EACH {
            edges = self::edges(isa, prepared.each.rule, core.copied().present_or(T::ZERO), groups);
        }
        for ((lanes, &r2), &edge) in left_out.iter_mut().zip(&r2).zip(&edges) {
            *lanes = isa.bits(isa.lt(r2, edge));
        }
        left_out
    }

    fn has_closer(prepared: &Prepared<'a, T>) -> bool {
        prepared.has_closer
    }

    #[inline(always)]
    fn add_close<I: Isa<T>, const NB: usize, const P: u8>(
        isa: I,
        outer: &Softened<I::V>,
        (prepared, inner): (&Prepared<'a, T>, &Softened<I::V>),
        laplacian: bool,
        (d, r2): &mut ([[I::V; D]; NB], [I::V; NB]),
        mass: T,
        groups: &mut [Group<I::V, D>; NB],
    ) -> [[u32; NB]; 2] {
        if EACH {
            return [[0; NB]; 2];
        }
        // A lane that takes no part has d = 0 and a square that is larger than any other: those are below the outer edge, which is 1 here
        // or the square of a Gaussian mollifier's support, of at most 25 times a delta below 1.
        let (zero, served) = (isa.splat(T::ZERO), isa.splat(power_of_two::<T>(12)));
        let factor = isa.splat(power_of_two::<T>(step::<T>()));
        let (mut before, mut after, mut some) = ([0; NB], [0; NB], 0);
        for ((d, r2), (before, after)) in d.iter_mut().zip(r2.iter_mut()).zip(before.iter_mut().zip(&mut after)) {
            let left = isa.lt(*r2, outer.edge);
            *before = isa.bits(left);
            let mut square = zero;
            for d in d.iter_mut() {
                *d = isa.select(left, isa.mul(*d, factor), zero);
                square = isa.mul_add(*d, *d, square);
            }
            *r2 = isa.select(left, square, served);
            *after = isa.bits(isa.lt(*r2, inner.edge));
            some |= *before & !*after;
        }
        if some != 0 {
            let (mut far, mut squares, mut outside) = (*d, *r2, [isa.lt(zero, zero); NB]);
            for ((far, square), outside) in far.iter_mut().zip(&mut squares).zip(&mut outside) {
                *square = isa.select(isa.lt(*square, inner.edge), served, *square);
                *outside = isa.lt(*square, served);
                far.iter_mut().for_each(|d| *d = isa.select(*outside, *d, zero));
            }
            let lanes_mass = isa.splat(mass);
            if P == POTENTIALS {
                let values = outside_potential::<T, I, D, NB>(isa, inner.log_exponent, &far, &squares);
                for ((group, k), &outside) in groups.iter_mut().zip(values).zip(&outside) {
                    group.add_potential(isa, lanes_mass, isa.select(outside, k, zero));
                }
            }
            if P != POTENTIALS || D != 2 {
                let factors = outside_gradient::<T, I, D, NB>(isa, lanes_mass, &squares);
                for ((group, d), g) in groups.iter_mut().zip(&far).zip(factors) {
                    group.add_gradient::<_, _, P>(isa, g, d);
                }
            }
        }
        if after.iter().any(|&lanes| lanes != 0) {
            let pairs = (&*d, &*r2);
            if let Some(inside) = inner.inside() {
                inside_pairs::<T, I, D, NB, P, false>(
                    isa,
                    &[inner.edge; NB],
                    inside,
                    [P == POTENTIALS, laplacian],
                    pairs,
                    (mass, None),
                    groups,
                );
                after = [0; NB];
            } else if TABLES && let Some(((table, _), numbers)) = prepared.table.as_ref().zip(inner.table.as_ref()) {
                let sums = (table, numbers, inner.table_scales);
                tabulated::add_below::<T, I, D, NB, P, false>(
                    isa,
                    &[inner.edge; NB],
                    sums,
                    [P == POTENTIALS, laplacian],
                    pairs,
                    (mass, None),
                    groups,
                );
                after = [0; NB];
            }
        }
        [before, after]
    }

    fn exact(&self, x: &[T; D], mass: T, radius: Option<T>, want: Want) -> Contribution<T, D> {
        if self.blob.mollifier() == Mollifier::None && x.iter().all(|&x| x == T::ZERO) {
            return Contribution::ZERO;
        }
        let blob = radius.map_or(*self.blob, |radius| self.blob.with_delta(radius));
        exact_pair(&blob, [mass, self.coefficient], x, want)
    }
}

/// The squares below which a source's pairs with each vector of targets are not plainly Newtonian.
#[inline(always)]
fn edges<T: Real, I: Isa<T>, const D: usize, const NB: usize>(
    isa: I,
    rule: PairRadius,
    core: T,
    groups: &[Group<I::V, D>; NB],
) -> [I::V; NB] {
    let mut edges = cores(isa, rule, core, groups);
    if NB == 1 {
        let least = isa.splat(power_of_two::<T>(-least_square_exponent::<T>()));
        for edge in &mut edges {
            *edge = isa.select(isa.lt(*edge, least), least, *edge);
        }
    }
    edges
}

/// A pair of a Newtonian kernel, in true units and at any distance, of a mass that is the product of two numbers.
pub(super) fn exact_pair<T: Real, const D: usize>(
    blob: &Blob<T, D>,
    mass: [T; 2],
    x: &[T; D],
    want: Want,
) -> Contribution<T, D> {
    let mut sums = Contribution::ZERO;
    let which = [want.potential, want.gradient && !want.row.is_some(), want.laplacian];
    (sums.potential, sums.gradient, sums.laplacian) = blob.field_of(mass, x, which);
    // Gradient factor and Laplacian are in it together: [`Want::row`] without the one or the other is not asked for.
    if let Some(row) = want.row.get() {
        sums.gradient = blob.row_of(mass, x, row);
    }
    sums
}

/// [`AddNoted`], where the kernel has lanes for close pairs; else the sources stay noted.
#[inline(always)]
fn add_noted<T: Real, I: Isa<T>, const D: usize, const NB: usize, const P: u8, const EACH: bool, const VECTOR: bool>(
    isa: I,
    prepared: (&Prepared<'_, T>, &Softened<I::V>),
    block: &Block<'_, T, D>,
    groups: &mut [Group<I::V, D>; NB],
    noted: &mut Deferred,
    counts: &mut Statistics,
) {
    if prepared.1.inside().is_some() {
        isa.apart(AddNoted::<_, _, D, NB, P, EACH, VECTOR, false> { prepared, block, groups, noted, counts });
    } else if TABLES && prepared.0.table.is_some() {
        isa.apart(AddNoted::<_, _, D, NB, P, EACH, VECTOR, true> { prepared, block, groups, noted, counts });
    }
}

/// The way from sums of masses times S_D K (in 2D twice that), S_D g and S_D psi to the results of a Newtonian kernel.
pub(super) fn newtonian_scales<T: Real, const D: usize>(coefficient: T, units: Units<T>, class: usize) -> Scales<T> {
    let factor = coefficient / T::from_f64(sphere(D));
    let (mass, length) = (-units.class(class), units.position);
    let d = D as i32;
    Scales {
        potential: match D {
            2 => (T::HALF * factor, mass),
            _ => (factor, mass + (d - 2) * length),
        },
        // d is source minus target.
        gradient: (-factor, mass + (d - 1) * length),
        laplacian: (factor, mass + d * length),
    }
}

/// Adds what noted sources give to the lanes below the edge: by the polynomials inside a compact mollifier or, if `TABLE`, from a Gaussian one's table. Sources with a
/// core radius that is too small for lanes stay noted.
struct AddNoted<
    'a,
    'k,
    T: Real,
    V,
    const D: usize,
    const NB: usize,
    const P: u8,
    const EACH: bool,
    const VECTOR: bool,
    const TABLE: bool,
> {
    prepared: (&'a Prepared<'k, T>, &'a Softened<V>),
    block: &'a Block<'a, T, D>,
    groups: &'a mut [Group<V, D>; NB],
    noted: &'a mut Deferred,
    counts: &'a mut Statistics,
}

impl<
    T: Real,
    I: Isa<T>,
    const D: usize,
    const NB: usize,
    const P: u8,
    const EACH: bool,
    const VECTOR: bool,
    const TABLE: bool,
> Part<T, I> for AddNoted<'_, '_, T, I::V, D, NB, P, EACH, VECTOR, TABLE>
{
    type Out = ();

    #[inline(always)]
    fn run(self, isa: I) {
        let Self { prepared: (prepared, kernel), block, groups, noted, counts } = self;
        let (inside, table) = (&kernel.inside, prepared.table.as_ref().zip(kernel.table.as_ref()));
        let ((positions, masses), of_sources) = (block.sources, block.cores);
        let mut kept = 0;
        for k in 0..noted.len() {
            let at = noted.at(k);
            let (Some(x), Some(&m)) = (positions.get(at), masses.get(at)) else { continue };
            let (mut edges, mut core) = ([kernel.edge; NB], None);
            if EACH {
                let square = of_sources.get(at).copied().present_or(T::ZERO);
                edges = self::edges(isa, prepared.each.rule, square, groups);
                core = prepared.each.cores::<I, D, NB, P>(isa, square, &edges, TABLE);
                if core.is_none() {
                    noted.keep(kept, at);
                    kept += 1;
                    continue;
                }
            }
            let (d, r2) = distances(isa, x, groups);
            let d = arms::<T, I, D, NB, VECTOR>(isa, &d, block.strengths.get(at).unwrap_or(&[T::ZERO; D]));
            let (pairs, source) = ((&d, &r2), (m, core.as_ref()));
            let wanted = [wants_potential::<D, P>(block.potential), block.laplacian];
            let lanes = if TABLE {
                let Some(((table, _), numbers)) = table else { continue };
                let sums = (table, numbers, kernel.table_scales);
                tabulated::add_below::<T, I, D, NB, P, EACH>(isa, &edges, sums, wanted, pairs, source, groups)
            } else {
                inside_pairs::<T, I, D, NB, P, EACH>(isa, &edges, inside, wanted, pairs, source, groups)
            };
            counts.polynomial_blocks += 1;
            for (lanes, valid) in lanes.iter().zip(block.valid) {
                counts.near_pairs += u64::from((lanes & valid).count_ones());
            }
        }
        noted.truncate(kept);
    }
}

/// [`far_run`] as a function of its own, from `start` on.
struct FarRun<
    'a,
    T,
    V,
    const D: usize,
    const NB: usize,
    const P: u8,
    const EACH: bool,
    const VECTOR: bool,
    const TEST: bool,
> {
    kernel: &'a Softened<V>,
    rule: PairRadius,
    block: &'a Block<'a, T, D>,
    start: usize,
    noted: &'a mut Deferred,
    groups: &'a mut [Group<V, D>; NB],
}

impl<
    T: Real,
    I: Isa<T>,
    const D: usize,
    const NB: usize,
    const P: u8,
    const EACH: bool,
    const VECTOR: bool,
    const TEST: bool,
> Part<T, I> for FarRun<'_, T, I::V, D, NB, P, EACH, VECTOR, TEST>
{
    type Out = usize;

    #[inline(always)]
    fn run(self, isa: I) -> usize {
        let Self { kernel, rule, block, start, noted, groups } = self;
        let cores = if EACH { block.cores.get(start..).present_or(&[]) } else { &[] };
        let strengths = if VECTOR { block.strengths.get(start..).present_or(&[]) } else { &[] };
        let sources = (from(block.sources, start), cores, strengths);
        let potential = wants_potential::<D, P>(block.potential);
        far_run::<T, I, D, NB, P, EACH, VECTOR, TEST>(isa, (kernel, rule), sources, potential, start, noted, groups)
    }
}

/// [`near_run`] as a function of its own, from `start` on.
struct NearRun<'a, T, V, const D: usize, const NB: usize, const P: u8, const TERMS: usize, const TEST: bool> {
    kernel: &'a Softened<V>,
    inside: &'a Inside<V>,
    block: &'a Block<'a, T, D>,
    start: usize,
    groups: &'a mut [Group<V, D>; NB],
}

impl<T: Real, I: Isa<T>, const D: usize, const NB: usize, const P: u8, const TERMS: usize, const TEST: bool> Part<T, I>
    for NearRun<'_, T, I::V, D, NB, P, TERMS, TEST>
{
    type Out = usize;

    #[inline(always)]
    fn run(self, isa: I) -> usize {
        let Self { kernel, inside, block, start, groups } = self;
        let sources = from(block.sources, start);
        let wanted = [wants_potential::<D, P>(block.potential), block.laplacian];
        near_run::<T, I, D, NB, P, TERMS, TEST>(isa, kernel, inside, wanted, sources, groups)
    }
}

/// The list without its first `n`.
#[inline(always)]
fn from<T, const D: usize>((positions, masses): List<'_, T, D>, n: usize) -> List<'_, T, D> {
    (positions.get(n..).present_or(&[]), masses.get(n..).present_or(&[]))
}

/// Adds sources, but, unless the caller knows that there is none (`TEST` is false), not where a lane is below the edge: such sources are noted, at their place after `start`. Stops where every lane
/// is inside the support, which [`near_run`] does without dividing, and on machines that add in order behind a source that it noted.
/// Returns how many it did.
///
/// Targets and sums live in registers here: this loop is where a sum without near pairs spends its time.
#[inline(always)]
fn far_run<
    T: Real,
    I: Isa<T>,
    const D: usize,
    const NB: usize,
    const P: u8,
    const EACH: bool,
    const VECTOR: bool,
    const TEST: bool,
>(
    isa: I,
    (kernel, rule): (&Softened<I::V>, PairRadius),
    (sources, of_sources, strengths): (List<'_, T, D>, &[T], &[[T; D]]),
    potential: bool,
    start: usize,
    noted: &mut Deferred,
    groups: &mut [Group<I::V, D>; NB],
) -> usize {
    let (zero, one) = (isa.splat(T::ZERO), isa.splat(T::ONE));
    let mut done = 0;
    let mut local = *groups;
    let (mut of_sources, mut strengths) = (of_sources.iter(), strengths.iter());
    for (x, &m) in sources.0.iter().zip(sources.1) {
        let (mut d, mut r2) = distances(isa, x, &local);
        let mass = isa.splat(m);
        let mut edges = [kernel.edge; NB];
        if EACH && TEST {
            edges = self::edges(isa, rule, of_sources.next().copied().present_or(T::ZERO), &local);
        }
        let mut stop = false;
        let any = if !TEST {
            false
        } else if NB == 1 {
            isa.any_below(&margins(isa, &r2, &edges), zero)
        } else {
            isa.any_below(&r2, edges.first().copied().present_or(kernel.edge))
        };
        if any {
            if !EACH && kernel.inside().is_some() && isa.all_below(&r2, kernel.edge) {
                break;
            }
            noted.push(start + done);
            stop = I::IN_ORDER;
            // Lanes below the edge add nothing: d = 0, and r2 = 1 is harmless. Only the potential, log or -1/r, has no zero there.
            let mut below = [isa.lt(one, zero); NB];
            for ((below, &edge), (d, r2)) in below.iter_mut().zip(&edges).zip(d.iter_mut().zip(&mut r2)) {
                *below = isa.lt(*r2, edge);
                d.iter_mut().for_each(|d| *d = isa.select(*below, zero, *d));
                *r2 = isa.select(*below, one, *r2);
            }
            if P == POTENTIALS && D > 1 {
                let values = outside_potential::<T, I, D, NB>(isa, kernel.log_exponent, &d, &r2);
                for ((group, k), &below) in local.iter_mut().zip(values).zip(&below) {
                    group.add_potential(isa, mass, isa.select(below, zero, k));
                }
                if D == 3 {
                    let factors = outside_gradient::<T, I, D, NB>(isa, mass, &r2);
                    for ((group, d), g) in local.iter_mut().zip(&d).zip(factors) {
                        group.add_gradient::<_, _, P>(isa, g, d);
                    }
                }
                done += 1;
                if stop {
                    break;
                }
                continue;
            }
        }
        if potential {
            let values = outside_potential::<T, I, D, NB>(isa, kernel.log_exponent, &d, &r2);
            local.iter_mut().zip(values).for_each(|(group, k)| group.add_potential(isa, mass, k));
        }
        if P != POTENTIALS || D != 2 {
            let factors = outside_gradient::<T, I, D, NB>(isa, mass, &r2);
            if VECTOR {
                d = arms::<T, I, D, NB, true>(isa, &d, strengths.next().present_or(&[T::ZERO; D]));
            }
            for ((group, d), g) in local.iter_mut().zip(&d).zip(factors) {
                group.add_gradient::<_, _, P>(isa, g, d);
            }
        }
        done += 1;
        if stop {
            break;
        }
    }
    *groups = local;
    done
}

/// Adds sources as long as every lane is inside the support; how many. Nothing is divided.
///
/// `TERMS` unrolls the gradient's polynomial where it has just so many; 0 takes any number. Without `TEST` the caller knows that every
/// lane is inside.
#[inline(always)]
fn near_run<T: Real, I: Isa<T>, const D: usize, const NB: usize, const P: u8, const TERMS: usize, const TEST: bool>(
    isa: I,
    kernel: &Softened<I::V>,
    inside: &Inside<I::V>,
    [potential, laplacian]: [bool; 2],
    sources: List<'_, T, D>,
    groups: &mut [Group<I::V, D>; NB],
) -> usize {
    let mut done = 0;
    let mut local = *groups;
    let (mut positions, mut masses) = sources;
    let gradient = P != POTENTIALS || D != 2;
    if gradient && !(TEST || I::IN_ORDER) {
        // Four sources at a time, stage by stage: the polynomials' long chains of dependent operations then overlap beyond what the
        // processor's window holds of one source after the other. The polynomial is one of r2 - delta^2 here, which the sum of squares
        // begins with, so that t costs nothing. (Level portable keeps the operations of one pair at a time.)
        let (shifted, start) = inside.shifted(isa, kernel.edge);
        let ((four_x, rest_x), (four_m, rest_m)) = (positions.as_chunks::<4>(), masses.as_chunks::<4>());
        for (xs, ms) in four_x.iter().zip(four_m) {
            let mut factors = [[start; NB]; 4];
            for (factors, x) in factors.iter_mut().zip(xs) {
                let (d, _) = distances(isa, x, &local);
                for (factor, d) in factors.iter_mut().zip(&d) {
                    d.iter().for_each(|&d| *factor = isa.mul_add(d, d, *factor));
                }
            }
            for (factors, &m) in factors.iter_mut().zip(ms) {
                let mass = isa.splat(m);
                *factors = shifted.at::<T, I, NB, TERMS>(isa, factors);
                factors.iter_mut().for_each(|factor| *factor = isa.mul(mass, *factor));
            }
            for (factors, x) in factors.iter().zip(xs) {
                let (d, _) = distances(isa, x, &local);
                local
                    .iter_mut()
                    .zip(&d)
                    .zip(factors)
                    .for_each(|((group, d), &g)| group.add_gradient::<_, _, P>(isa, g, d));
            }
            done += 4;
        }
        if laplacian || potential {
            for (x, &m) in four_x.as_flattened().iter().zip(four_m.as_flattened()) {
                let (d, r2) = distances(isa, x, &local);
                let t = inside.t(isa, &r2);
                if laplacian {
                    let b = inside.density.at::<T, I, NB, 0>(isa, &t);
                    for ((group, b), d) in local.iter_mut().zip(b).zip(&d) {
                        group.add_laplacian::<_, _, P>(isa, isa.splat(m), b, d);
                    }
                }
                if potential {
                    let k = inside.potential::<T, I, D, NB>(isa, &t, &r2);
                    local.iter_mut().zip(k).for_each(|(group, k)| group.add_potential(isa, isa.splat(m), k));
                }
            }
        }
        (positions, masses) = (rest_x, rest_m);
    }
    for (x, &m) in positions.iter().zip(masses) {
        let (d, r2) = distances(isa, x, &local);
        if TEST && !isa.all_below(&r2, kernel.edge) {
            break;
        }
        let mass = isa.splat(m);
        let t = inside.t(isa, &r2);
        if potential {
            let k = inside.potential::<T, I, D, NB>(isa, &t, &r2);
            local.iter_mut().zip(k).for_each(|(group, k)| group.add_potential(isa, mass, k));
        }
        if gradient {
            let g = inside.gradient.at::<T, I, NB, TERMS>(isa, &t);
            for ((group, d), g) in local.iter_mut().zip(&d).zip(g) {
                group.add_gradient::<_, _, P>(isa, isa.mul(mass, g), d);
            }
            if laplacian {
                let b = inside.density.at::<T, I, NB, 0>(isa, &t);
                for ((group, b), d) in local.iter_mut().zip(b).zip(&d) {
                    group.add_laplacian::<_, _, P>(isa, mass, b, d);
                }
            }
        }
        done += 1;
    }
    *groups = local;
    done
}

/// Adds what one source gives to the lanes inside a compact support, and to no other, from the differences, source minus target, and their squares; if `EACH`,
/// with the numbers of its core radius. Returns one word of lanes a vector.
#[inline(always)]
fn inside_pairs<T: Real, I: Isa<T>, const D: usize, const NB: usize, const P: u8, const EACH: bool>(
    isa: I,
    edges: &[I::V; NB],
    inside: &Inside<I::V>,
    [potential, laplacian]: [bool; 2],
    (d, r2): (&[[I::V; D]; NB], &[I::V; NB]),
    (mass, core): (T, Option<&[Core<I::V>; NB]>),
    groups: &mut [Group<I::V, D>; NB],
) -> [u32; NB] {
    let zero = isa.splat(T::ZERO);
    let mass = isa.splat(mass);
    let (mut of_gradient, mut of_potential) = ([mass; NB], [mass; NB]);
    if EACH && let Some(cores) = core {
        for ((gradient, potential), core) in of_gradient.iter_mut().zip(&mut of_potential).zip(cores) {
            (*gradient, *potential) = (isa.mul(mass, core.factors[0]), isa.mul(mass, core.factors[1]));
        }
    }
    let (mut below, mut lanes) = ([isa.lt(zero, zero); NB], [0; NB]);
    // Beyond the support powers of t might overflow, which may be trapped.
    let mut within = *r2;
    for (((r2, below), lanes), &edge) in within.iter_mut().zip(&mut below).zip(&mut lanes).zip(edges) {
        *below = isa.lt(*r2, edge);
        *lanes = isa.bits(*below);
        *r2 = isa.select(*below, *r2, edge);
    }
    if EACH && let Some(cores) = core {
        for (r2, core) in within.iter_mut().zip(cores) {
            *r2 = isa.mul(*r2, core.ratio_square);
        }
    }
    let t = inside.t(isa, &within);
    if potential {
        let mut k = inside.potential::<T, I, D, NB>(isa, &t, &within);
        if EACH
            && D == 2
            && let Some(cores) = core
        {
            for (k, core) in k.iter_mut().zip(cores) {
                *k = isa.add(*k, core.offset);
            }
        }
        for (((group, k), &below), &mass) in groups.iter_mut().zip(k).zip(&below).zip(&of_potential) {
            group.add_potential(isa, mass, isa.select(below, k, zero));
        }
    }
    if P != POTENTIALS || D != 2 {
        let g = inside.gradient.at::<T, I, NB, 0>(isa, &t);
        for ((((group, d), g), &below), &mass) in groups.iter_mut().zip(d).zip(g).zip(&below).zip(&of_gradient) {
            group.add_gradient::<_, _, P>(isa, isa.select(below, isa.mul(mass, g), zero), d);
        }
        if laplacian {
            let b = inside.density.at::<T, I, NB, 0>(isa, &t);
            for ((((group, b), &below), d), &mass) in groups.iter_mut().zip(b).zip(&below).zip(d).zip(&of_gradient) {
                group.add_laplacian::<_, _, P>(isa, mass, isa.select(below, b, zero), d);
            }
        }
    }
    lanes
}

/// m S_D g of the bare kernel.
#[inline(always)]
pub(super) fn outside_gradient<T: Real, I: Isa<T>, const D: usize, const NB: usize>(
    isa: I,
    mass: I::V,
    r2: &[I::V; NB],
) -> [I::V; NB] {
    match D {
        1 => {
            // K = |x| / 2; the gradient factor is 1 / |x|, of which only the sign of x remains.
            let mut roots = *r2;
            roots.iter_mut().for_each(|r| *r = isa.sqrt(*r));
            isa.quotients(mass, roots)
        }
        2 => isa.quotients(mass, *r2),
        _ => isa.over_cubed_roots(mass, *r2),
    }
}

/// S_D K of the bare kernel; in 2D log r2, with as few divisions as the gradient.
#[inline(always)]
pub(super) fn outside_potential<T: Real, I: Isa<T>, const D: usize, const NB: usize>(
    isa: I,
    log_exponent: I::V,
    d: &[[I::V; D]; NB],
    r2: &[I::V; NB],
) -> [I::V; NB] {
    let zero = isa.splat(T::ZERO);
    let mut values = [zero; NB];
    match D {
        1 => {
            for (value, d) in values.iter_mut().zip(d) {
                *value = d.first().map_or(zero, |&d| isa.abs(d));
            }
            values
        }
        2 => {
            // Stage by stage for all vectors: their chains of dependent operations then run beside each other.
            let two = isa.splat(T::TWO);
            let mut e = [zero; NB];
            for ((z, e), &r2) in values.iter_mut().zip(&mut e).zip(r2) {
                (*z, *e) = log_numerator(isa, r2);
                *e = isa.add(*e, log_exponent);
            }
            if const { NB > 1 } {
                let mut sums = values;
                sums.iter_mut().for_each(|z| *z = isa.add(two, *z));
                let inverses = isa.quotients(isa.splat(T::ONE), sums);
                values.iter_mut().zip(inverses).for_each(|(z, inverse)| *z = isa.mul(*z, inverse));
            } else {
                values.iter_mut().for_each(|z| *z = isa.div(*z, isa.add(two, *z)));
            }
            log(isa, e, values)
        }
        _ => {
            let roots = isa.inverse_roots(*r2);
            values.iter_mut().zip(roots).for_each(|(value, root)| *value = isa.sub(zero, root));
            values
        }
    }
}

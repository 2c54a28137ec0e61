//! From the expansions of well separated boxes to the local expansion of a target box: where the method spends its time besides the sum over pairs.
//!
//! With the step D = t - c from a source box to the target box, R and R' their radii (Greengard & Rokhlin 1987, Lemma 2.4, for the derivative):
//!
//! beta_l = (1/D) (-R'/D)^l sum_k (k + l)! alpha_k (R/D)^k,    Re f(t) = alpha_0 log |D| - Re sum_(k>0) (k - 1)! alpha_k (R/D)^k.
//!
//! Lanes are pairs of boxes where the numbers of a pair are computed, and coefficients after that. The powers of R/D and R'/D are multiplied before and after, so that the
//! weights between are real and the same for every pair.
//!
//! Boxes that are farther from each other than they must be ([`super::settings`]) need fewer terms: with the larger radius a and the smaller one b, the error after n terms
//! is that of rho^n, rho = a / (|D| - b).

use super::expansions::{Lanes, MAX_BLOCKS, Order, PAIRS, Room, Series, blocks_of, times};
use super::settings::OPENING_LOG;
use super::tree::{Shape, Tree};
use crate::checked::Present;
use crate::real::Real;
use crate::simd::{BlockJob, Isa, Job, MAX_LANES, Row, log_of};

/// Blocks of coefficients whose sums are in registers at a time.
const TOGETHER: usize = 4;

/// Adds what source boxes give to a target box.
pub(super) struct Translate<'a, 'w, T> {
    pub order: Order<'a, T>,
    pub tree: &'a Tree<'w, T>,
    /// The expansions of all source boxes.
    pub from: &'a [T],
    pub list: &'a [u32],
    pub shape: Shape<T>,
    /// Added to the binary logarithm of |D|^2, which is in units; none: no potential is wanted.
    pub log_exponent: Option<T>,
    pub room: &'a mut Room<T>,
    pub to: &'a mut [T],
}

/// The numbers of some pairs of boxes, one a lane.
struct Steps<T> {
    /// 1/D, R/D and -R'/D.
    inverse: [[T; MAX_LANES]; 2],
    source: [[T; MAX_LANES]; 2],
    target: [[T; MAX_LANES]; 2],
    /// How many terms are needed, not rounded.
    terms: [T; MAX_LANES],
    /// log |D|, where a potential is wanted.
    log: [T; MAX_LANES],
}

impl<T: Real> Steps<T> {
    /// Of at most as many source boxes as there are lanes, to a target box; `all`: the terms of an expansion.
    #[inline(always)]
    fn new<I: Isa<T>>(
        isa: I,
        (tree, some): (&Tree<'_, T>, &[u32]),
        shape: &Shape<T>,
        all: usize,
        log_exponent: Option<T>,
    ) -> Self {
        let (zero, one) = (isa.splat(T::ZERO), isa.splat(T::ONE));
        // Lanes beyond the last box are far away.
        let mut lanes = [[T::from_f64(8.0); MAX_LANES], [T::ZERO; MAX_LANES], [T::ZERO; MAX_LANES]];
        let [to_x, to_y, radii] = &mut lanes;
        for (&k, ((to_x, to_y), radius)) in some.iter().zip(to_x.iter_mut().zip(to_y).zip(radii)) {
            let source = tree.shape(k as usize);
            (*to_x, *to_y) = (shape.centre[0] - source.centre[0], shape.centre[1] - source.centre[1]);
            *radius = source.radius;
        }
        let [x, y, radii] = &lanes;
        let (x, y, radius, own) = (isa.load(x), isa.load(y), isa.load(radii), isa.splat(shape.radius));
        let square = isa.mul_add(x, x, isa.mul(y, y));
        let per_square = isa.div(one, square);
        let inverse = [isa.mul(x, per_square), isa.sub(zero, isa.mul(y, per_square))];
        let is_less = isa.lt(radius, own);
        let (large, small) = (isa.select(is_less, own, radius), isa.select(is_less, radius, own));
        let rho = isa.div(large, isa.sub(isa.sqrt(square), small));
        // Its square is not zero for points either.
        let of_rho = log_of(isa, isa.mul_add(rho, rho, isa.splat(T::EPSILON * T::EPSILON)), zero);
        let of_all = isa.splat(T::from_f64(2.0 * OPENING_LOG) * T::from_usize(all));
        let mut log = zero;
        if let Some(exponent) = log_exponent {
            log = isa.mul(log_of(isa, square, isa.splat(exponent)), isa.splat(T::HALF));
        }
        Self {
            inverse: stored(isa, inverse, one),
            source: stored(isa, inverse, radius),
            target: stored(isa, inverse, isa.sub(zero, own)),
            terms: isa.store(isa.div(of_all, of_rho)),
            log: isa.store(log),
        }
    }

    /// The terms of a pair, of so many.
    #[inline(always)]
    fn terms(&self, lane: usize, all: usize) -> usize {
        all.min(self.terms.get(lane).copied().present_or(T::ZERO).to_u32() as usize + 1)
    }
}

/// A complex number of each lane times a real one, in memory.
#[inline(always)]
fn stored<T: Real, I: Isa<T>>(isa: I, [re, im]: [I::V; 2], factor: I::V) -> [[T; MAX_LANES]; 2] {
    [isa.store(isa.mul(re, factor)), isa.store(isa.mul(im, factor))]
}

/// A complex number of a lane, in all lanes.
#[inline(always)]
fn splat<T: Real, I: Isa<T>>(isa: I, [re, im]: &[[T; MAX_LANES]; 2], lane: usize) -> [I::V; 2] {
    let (re, im) = (re.get(lane).copied(), im.get(lane).copied());
    [isa.splat(re.present_or(T::ZERO)), isa.splat(im.present_or(T::ZERO))]
}

impl<T: Real> Job<T> for Translate<'_, '_, T> {
    type Out = ();

    #[inline(always)]
    fn run<I: Isa<T>>(self, isa: I) {
        isa.in_blocks(self);
    }
}

impl<T: Real> BlockJob<T> for Translate<'_, '_, T> {
    type Out = ();

    #[inline(always)]
    fn run<I: Isa<T>, const N: usize>(self, isa: I) {
        // With 32 registers the sums of two pairs are in them, with 16 those of one.
        if const { N > 2 } { self.pairs::<I, PAIRS>(isa) } else { self.pairs::<I, 1>(isa) }
    }
}

/// Powers, and the factor that leads to those of the next block.
type Powers<V> = ([V; 2], [V; 2]);

impl<T: Real> Translate<'_, '_, T> {
    /// The translations of `G` source boxes at a time.
    #[inline(always)]
    fn pairs<I: Isa<T>, const G: usize>(self, isa: I) {
        let Self { order, tree, from, list, shape, log_exponent, room, to } = self;
        let Order { terms, stride, factorials } = order;
        let Some(series) = room.pairs.first_chunk_mut::<G>() else { return };
        let (zero, lanes) = (isa.splat(T::ZERO), Lanes::new(isa));
        let mut sums = [[zero; 2]; MAX_BLOCKS];
        let (mut potential, mut logs) = (zero, T::ZERO);
        for some in list.chunks(I::LANES) {
            let steps = Steps::new(isa, (tree, some), &shape, terms, log_exponent);
            for first in (0..some.len()).step_by(G) {
                let mut powers = [([zero; 2], [zero; 2]); G];
                let mut most = 0;
                for (lane, (series, powers)) in (first..).zip(series.iter_mut().zip(&mut powers)) {
                    // A box that is not there has no mass.
                    let from = some.get(lane).map(|&k| from.get(k as usize * 2 * stride..).present_or(&[]));
                    scale(isa, &lanes, from, (terms, stride), splat(isa, &steps.source, lane), series);
                    if from.is_some() {
                        let (power, factor) = lanes.powers(isa, splat(isa, &steps.target, lane));
                        *powers = (times(isa, power, splat(isa, &steps.inverse, lane)), factor);
                        most = most.max(steps.terms(lane, terms));
                    }
                }
                let blocks = blocks_of::<T, I>(most);
                if log_exponent.is_some() {
                    for (lane, [real, _]) in (first..some.len()).zip(&*series) {
                        let log = steps.log.get(lane).copied().present_or(T::ZERO);
                        logs += real.first().copied().present_or(T::ZERO) * log;
                        let rows = I::Row::of(real.get(1..).present_or(&[])).iter().zip(I::Row::of(&factorials.whole));
                        for (re, weights) in rows.take(blocks) {
                            potential = isa.neg_mul_add(isa.load_row(re), isa.load_row(weights), potential);
                        }
                    }
                }
                let (mut left, mut weights, mut to) = (blocks, &factorials.whole[..], &mut sums[..]);
                while let Some((some, rest)) = to.split_first_chunk_mut::<TOGETHER>().filter(|_| left > 0) {
                    match left {
                        1 => add_weighted::<T, I, G, 1>(isa, (series, most), weights, &mut powers, some),
                        2 => add_weighted::<T, I, G, 2>(isa, (series, most), weights, &mut powers, some),
                        3 => add_weighted::<T, I, G, 3>(isa, (series, most), weights, &mut powers, some),
                        _ => add_weighted::<T, I, G, TOGETHER>(isa, (series, most), weights, &mut powers, some),
                    }
                    left = left.saturating_sub(TOGETHER);
                    (to, weights) = (rest, weights.get(TOGETHER * I::LANES..).unwrap_or_default());
                }
            }
        }
        let (real, rest) = to.split_at_mut_checked(stride).unwrap_or_default();
        let (imaginary, of_potential) = rest.split_at_mut_checked(stride).unwrap_or_default();
        let to = I::Row::of_mut(real).iter_mut().zip(I::Row::of_mut(imaginary));
        for (first, (to, sum)) in (0..terms).step_by(I::LANES).zip(to.zip(&sums)) {
            lanes.add_first(isa, terms - first, to, *sum);
        }
        if let (Some(_), Some(to)) = (log_exponent, of_potential.first_mut()) {
            *to += logs + I::Row::numbers(&[isa.store_row(potential)]).iter().fold(T::ZERO, |sum, &x| sum + x);
        }
    }
}

/// alpha_k (R/D)^k of all terms; zeros where there is no box.
#[inline(always)]
fn scale<T: Real, I: Isa<T>>(
    isa: I,
    lanes: &Lanes<I::V, I::M>,
    from: Option<&[T]>,
    (terms, stride): (usize, usize),
    ratio: [I::V; 2],
    [real, imaginary]: &mut Series<T>,
) {
    let to = I::Row::of_mut(real).iter_mut().zip(I::Row::of_mut(imaginary)).take(blocks_of::<T, I>(terms));
    let Some((of_real, of_imaginary)) = from.and_then(|from| from.split_at_checked(stride)) else {
        let zero = isa.splat(T::ZERO);
        for (re, im) in to {
            (*re, *im) = (isa.store_row(zero), isa.store_row(zero));
        }
        return;
    };
    let (mut power, factor) = lanes.powers(isa, ratio);
    for ((to_re, to_im), (re, im)) in to.zip(I::Row::of(of_real).iter().zip(I::Row::of(of_imaginary))) {
        let [re, im] = times(isa, [isa.load_row(re), isa.load_row(im)], power);
        (*to_re, *to_im) = (isa.store_row(re), isa.store_row(im));
        power = times(isa, power, factor);
    }
}

/// Adds to successive blocks of l the sums over k of (k + l)! x_k, of which the weights are those from the first l on, times the power of each l; of several pairs.
#[inline(always)]
fn add_weighted<T: Real, I: Isa<T>, const G: usize, const B: usize>(
    isa: I,
    (pairs, terms): (&[Series<T>; G], usize),
    weights: &[T],
    powers: &mut [Powers<I::V>; G],
    to: &mut [[I::V; 2]; TOGETHER],
) {
    let zero = isa.splat(T::ZERO);
    let mut sums = [[[zero; 2]; B]; G];
    for (k, weights) in weights.windows(B * I::LANES).take(terms).enumerate() {
        // So many that it is known while this is compiled.
        let Some(rows) = I::Row::of(weights).first_chunk::<B>() else { break };
        for (sums, [real, imaginary]) in sums.iter_mut().zip(pairs) {
            let (Some(&a), Some(&b)) = (real.get(k), imaginary.get(k)) else { break };
            let (a, b) = (isa.splat(a), isa.splat(b));
            for (sum, row) in sums.iter_mut().zip(rows) {
                let weight = isa.load_row(row);
                *sum = [isa.mul_add(weight, a, sum[0]), isa.mul_add(weight, b, sum[1])];
            }
        }
    }
    for ((power, factor), sums) in powers.iter_mut().zip(&sums) {
        for (to, sum) in to.iter_mut().zip(sums) {
            let [a, b] = times(isa, *sum, *power);
            *to = [isa.add(to[0], a), isa.add(to[1], b)];
            *power = times(isa, *power, *factor);
        }
    }
}

//! From the expansions of well separated boxes to the local expansion of a target box: where the method spends its time besides the sum over pairs.
//!
//! With the step D = t - c from a source box to the target box, R and R' their radii (Greengard & Rokhlin 1987, Lemma 2.4, for the derivative):
//!
//! beta_l = (1/D) (-R'/D)^l sum_k (k + l)! alpha_k (R/D)^k,    Re f(t) = alpha_0 log |D| - Re sum_(k>0) (k - 1)! alpha_k (R/D)^k.
//!
//! Lanes are source boxes. The powers of R/D and R'/D are multiplied before and after, so that the weights between are real and the same for every pair.

use super::expansions::{Order, add_across, times};
use super::settings::MAX_TERMS;
use super::tree::{Shape, Tree};
use crate::checked::Present;
use crate::real::Real;
use crate::simd::{Isa, Job, MAX_LANES, ROW, log, log_numerator};

/// Coefficients whose sums are in registers at a time.
const ROWS: usize = 4;

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
    pub to: &'a mut [T],
}

impl<T: Real> Job<T> for Translate<'_, '_, T> {
    type Out = ();

    #[inline(always)]
    fn run<I: Isa<T>>(self, isa: I) {
        match self.order.terms {
            0..=24 => self.with_room::<I, 24>(isa),
            _ => self.with_room::<I, MAX_TERMS>(isa),
        }
    }
}

impl<T: Real> Translate<'_, '_, T> {
    /// The translation, in arrays with room for so many terms: these are filled with zeros at each call.
    #[inline(always)]
    fn with_room<I: Isa<T>, const ROOM: usize>(self, isa: I) {
        let Self { order: Order { terms, stride, factorials }, tree, from, list, shape, log_exponent, to } = self;
        let (zero, one) = (isa.splat(T::ZERO), isa.splat(T::ONE));
        let (mut sums, mut scaled) = ([[zero; 2]; ROOM], [[zero; 2]; ROOM]);
        let mut potential = [[zero; 2]];
        let (rows, none) = (from.as_chunks::<ROW>().0, [T::ZERO; ROW]);
        let each = stride / ROW;
        for some in list.chunks(I::LANES) {
            // Lanes beyond the last box have no mass.
            let mut steps = [[T::ONE; MAX_LANES], [T::ZERO; MAX_LANES], [T::ZERO; MAX_LANES]];
            let [to_x, to_y, radii] = &mut steps;
            let lanes = to_x.iter_mut().zip(to_y.iter_mut()).zip(radii.iter_mut());
            for (&k, ((to_x, to_y), radius)) in some.iter().zip(lanes) {
                let source = tree.shape(k as usize);
                (*to_x, *to_y) = (shape.centre[0] - source.centre[0], shape.centre[1] - source.centre[1]);
                *radius = source.radius;
            }
            let [x, y, radii] = &steps;
            let (x, y, radius) = (isa.load(x), isa.load(y), isa.load(radii));
            let square = isa.mul_add(x, x, isa.mul(y, y));
            let per_square = isa.div(one, square);
            let quotient = [isa.mul(x, per_square), isa.sub(zero, isa.mul(y, per_square))];
            // alpha_k (R/D)^k
            let ratio = [isa.mul(quotient[0], radius), isa.mul(quotient[1], radius)];
            let mut power = [one, zero];
            for (block, to) in scaled.chunks_mut(ROW).enumerate().take(terms.div_ceil(ROW)) {
                let (mut real, mut imaginary) = ([&none; MAX_LANES], [&none; MAX_LANES]);
                for ((re, im), &k) in real.iter_mut().zip(&mut imaginary).zip(some) {
                    let first = k as usize * 2 * each + block;
                    (*re, *im) = (rows.get(first).present_or(&none), rows.get(first + each).present_or(&none));
                }
                let (real, imaginary) = (isa.columns(&real), isa.columns(&imaginary));
                for (to, (&re, &im)) in to.iter_mut().zip(real.iter().zip(&imaginary)) {
                    *to = times(isa, [re, im], power);
                    power = times(isa, power, ratio);
                }
            }
            let scaled = scaled.get(..terms).present_or(&[]);
            if let Some(log_exponent) = log_exponent {
                let (z, e) = log_numerator(isa, square);
                let e = isa.add(e, isa.splat(log_exponent));
                let [value] = log(isa, [e], [isa.div(z, isa.add(isa.splat(T::TWO), z))]);
                let value = isa.mul(value, isa.splat(T::HALF));
                let mut terms = scaled.iter();
                let [first, _] = terms.next().copied().unwrap_or([zero; 2]);
                let [[sum, _]] = &mut potential;
                *sum = isa.mul_add(first, value, *sum);
                for (&[re, _], &weight) in terms.zip(&factorials.whole) {
                    *sum = isa.neg_mul_add(re, isa.splat(weight), *sum);
                }
            }
            // (1/D) (-R'/D)^l
            let own = isa.splat(T::ZERO - shape.radius);
            let ratio = [isa.mul(quotient[0], own), isa.mul(quotient[1], own)];
            let mut power = quotient;
            let (blocks, _) = sums.as_chunks_mut::<ROWS>();
            for (number, rows) in blocks.iter_mut().enumerate().take(terms.div_ceil(ROWS)) {
                let weights = factorials.whole.get(number * ROWS..).unwrap_or_default();
                let products = weighted(isa, scaled, weights);
                for (sum, product) in rows.iter_mut().zip(products) {
                    let [a, b] = times(isa, product, power);
                    *sum = [isa.add(sum[0], a), isa.add(sum[1], b)];
                    power = times(isa, power, ratio);
                }
            }
        }
        let (real, rest) = to.split_at_mut_checked(stride).unwrap_or_default();
        let (imaginary, of_potential) = rest.split_at_mut_checked(stride).unwrap_or_default();
        add_across(isa, sums.get(..terms).present_or(&[]), [real, imaginary], |_| T::ONE);
        if log_exponent.is_some() {
            add_across(isa, &potential, [of_potential, &mut []], |_| T::ONE);
        }
    }
}

/// The sums over k of (k + l)! x_k for [`ROWS`] successive l, of which the weights are those from l on.
#[inline(always)]
fn weighted<T: Real, I: Isa<T>>(isa: I, x: &[[I::V; 2]], weights: &[T]) -> [[I::V; 2]; ROWS] {
    let zero = isa.splat(T::ZERO);
    let mut sums = [[zero; 2]; ROWS];
    for (&[a, b], weights) in x.iter().zip(weights.windows(ROWS)) {
        for (sum, &weight) in sums.iter_mut().zip(weights) {
            let weight = isa.splat(weight);
            *sum = [isa.mul_add(weight, a, sum[0]), isa.mul_add(weight, b, sum[1])];
        }
    }
    sums
}

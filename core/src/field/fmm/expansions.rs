//! Expansions about the centres of boxes, and the operators within a tree.
//!
//! Points are complex numbers. The sum over sources is the real part of f(z) = sum m log(z - s), its gradient the conjugate of f'(z) = sum m / (z - s), and with f''(z) = a + i b the
//! matrix of its second derivatives [[a, -b], [-b, -a]].
//!
//! * Outside the sources of a box with centre c and radius R: f'(z) = sum_k A_k / (z - c)^(k+1), A_k = sum m (s - c)^k (Greengard & Rokhlin 1987, (2.1), (2.2), here
//!   for the derivative). Stored: alpha_k = A_k / (R^k k!).
//! * Inside a box with centre t and radius R, from sources that are well separated from it: f'(z) = sum_l B_l (z - t)^l, and Re f(t). Stored: beta_l = B_l R^l l!.
//!
//! Divided by R^k or times R^l no coefficient is larger than sum |m| (over the distance), whatever the size of a box. With the factorials the operators have simple weights:
//! from box to box (k + l)! (module `translate`), and within a tree products of series, with e_n = (d/R)^n / n! for a step d between centres:
//!
//! * to the larger box, (2.4): alpha_k = sum_j alpha'_j (R'/R)^j e_(k-j);
//! * to the smaller one, Lemma 2.5: beta'_j = (R'/R)^j sum_l beta_l e_(l-j), Re f(t') = Re f(t) + R Re sum_l beta_l e_(l+1).
//!
//! A set of coefficients is stored as all real parts, then all imaginary ones, each padded by zeros to the stride; a local expansion ends in Re f(t).

use super::settings::MAX_TERMS;
use super::tree::Shape;
use crate::checked::Present;
use crate::real::Real;
use crate::simd::{BlockJob, Isa, Job, MAX_LANES, ROW, Row};

/// n! and 1 / n!.
#[derive(Debug)]
pub(super) struct Factorials<T> {
    /// Up to twice the most terms; zero where it is out of range, which no number of terms in use reaches.
    pub whole: [T; 2 * MAX_TERMS],
    pub inverse: [T; ROOM],
}

impl<T: Real> Factorials<T> {
    pub fn new() -> Self {
        let (mut whole, mut inverse) = ([T::ZERO; 2 * MAX_TERMS], [T::ZERO; ROOM]);
        let mut product = 1.0_f64;
        let most = T::MAX.to_f64();
        for (n, to) in whole.iter_mut().enumerate() {
            if n > 0 {
                product *= n as f64;
            }
            *to = if product < most { T::from_f64(product) } else { T::ZERO };
            if let Some(to) = inverse.get_mut(n) {
                *to = if product < most { T::from_f64(1.0 / product) } else { T::ZERO };
            }
        }
        Self { whole, inverse }
    }
}

/// What all operators need to know.
#[derive(Clone, Copy, Debug)]
pub(super) struct Order<'a, T> {
    pub terms: usize,
    pub stride: usize,
    pub factorials: &'a Factorials<T>,
}

/// 1 / R, or zero for a point.
#[inline(always)]
pub(super) fn inverse<T: Real>(radius: T) -> T {
    if radius > T::ZERO { T::ONE / radius } else { T::ZERO }
}

/// Adds the sums over the lanes of each vector, real and imaginary parts, times a weight.
#[inline(always)]
pub(super) fn add_across<T: Real, I: Isa<T>>(
    isa: I,
    vectors: &[[I::V; 2]],
    [to_real, to_imaginary]: [&mut [T]; 2],
    weight: impl Fn(usize) -> T,
) {
    // Rows beyond the last vector of a block are of the block before, and of no use.
    let mut rows = [[T::ZERO; MAX_LANES]; MAX_LANES];
    for (part, to) in [to_real, to_imaginary].into_iter().enumerate() {
        for (block, vectors) in vectors.chunks(I::LANES).enumerate() {
            for (row, vector) in rows.iter_mut().zip(vectors) {
                *row = isa.store(vector.get(part).copied().present_or(isa.splat(T::ZERO)));
            }
            let sums = isa.store(across(isa, &rows));
            let to = to.iter_mut().enumerate().skip(block * I::LANES).zip(&sums);
            to.take(vectors.len()).for_each(|((k, to), &sum)| *to += sum * weight(k));
        }
    }
}

/// The sum of each row, one a lane.
#[inline(always)]
fn across<T: Real, I: Isa<T>>(isa: I, rows: &[[T; MAX_LANES]; MAX_LANES]) -> I::V {
    let (mut sum, none) = (isa.splat(T::ZERO), [T::ZERO; ROW]);
    for first in (0..I::LANES).step_by(ROW) {
        let mut parts = [&none; MAX_LANES];
        for (part, row) in parts.iter_mut().zip(rows) {
            *part = row.get(first..).and_then(|row| row.first_chunk()).present_or(&none);
        }
        for column in isa.columns(&parts) {
            sum = isa.add(sum, column);
        }
    }
    sum
}

/// The product of complex numbers.
#[inline(always)]
pub(super) fn times<T: Real, I: Isa<T>>(isa: I, [a, b]: [I::V; 2], [c, d]: [I::V; 2]) -> [I::V; 2] {
    [isa.neg_mul_add(b, d, isa.mul(a, c)), isa.mul_add(a, d, isa.mul(b, c))]
}

/// The vectors of some points' coordinates relative to a centre, over a radius; lanes beyond the last point hold zeros.
#[inline(always)]
fn load_points<T: Real, I: Isa<T>, const N: usize>(
    isa: I,
    points: &[[T; 2]],
    factor: T,
    shape: &Shape<T>,
) -> [[I::V; 2]; N] {
    let zero = isa.splat(T::ZERO);
    let mut vectors = [[zero; 2]; N];
    let (inverse, [x, y]) = (isa.splat(inverse(shape.radius)), shape.centre);
    let (x, y, factor) = (isa.splat(x), isa.splat(y), isa.splat(factor));
    for (vector, points) in vectors.iter_mut().zip(points.chunks(I::LANES)) {
        let mut lanes = [[T::ZERO; MAX_LANES]; 2];
        let [xs, ys] = &mut lanes;
        for ((to_x, to_y), &[x, y]) in xs.iter_mut().zip(ys.iter_mut()).zip(points) {
            (*to_x, *to_y) = (x, y);
        }
        let [xs, ys] = &lanes;
        *vector = [
            isa.mul(isa.sub(isa.mul(isa.load(xs), factor), x), inverse),
            isa.mul(isa.sub(isa.mul(isa.load(ys), factor), y), inverse),
        ];
    }
    vectors
}

/// The expansion of sources about the centre of their box: lanes are sources.
pub(super) struct Gather<'a, T> {
    pub order: Order<'a, T>,
    pub points: &'a [[T; 2]],
    pub masses: &'a [T],
    pub shape: Shape<T>,
    pub to: &'a mut [T],
}

impl<T: Real> Job<T> for Gather<'_, T> {
    type Out = ();

    #[inline(always)]
    fn run<I: Isa<T>>(self, isa: I) {
        isa.in_blocks(self);
    }
}

impl<T: Real> BlockJob<T> for Gather<'_, T> {
    type Out = ();

    #[inline(always)]
    fn run<I: Isa<T>, const N: usize>(self, isa: I) {
        if self.order.terms <= 24 {
            self.with_room::<I, N, 24>(isa);
        } else {
            self.with_room::<I, N, MAX_TERMS>(isa);
        }
    }
}

impl<T: Real> Gather<'_, T> {
    /// The expansion, in arrays with room for so many terms.
    #[inline(always)]
    fn with_room<I: Isa<T>, const N: usize, const ROOM: usize>(self, isa: I) {
        let Self { order, points, masses, shape, to } = self;
        let zero = isa.splat(T::ZERO);
        let mut sums = [[zero; 2]; ROOM];
        for (points, masses) in points.chunks(N * I::LANES).zip(masses.chunks(N * I::LANES)) {
            let w = load_points::<T, I, N>(isa, points, T::ONE, &shape);
            let mut powers = [[zero; 2]; N];
            for (power, masses) in powers.iter_mut().zip(masses.chunks(I::LANES)) {
                let mut lanes = [T::ZERO; MAX_LANES];
                lanes.iter_mut().zip(masses).for_each(|(to, &m)| *to = m);
                *power = [isa.load(&lanes), zero];
            }
            for [re, im] in sums.iter_mut().take(order.terms) {
                for (power, &w) in powers.iter_mut().zip(&w) {
                    let [a, b] = *power;
                    (*re, *im) = (isa.add(*re, a), isa.add(*im, b));
                    *power = times(isa, [a, b], w);
                }
            }
        }
        let (real, imaginary) = to.split_at_mut_checked(order.stride).unwrap_or_default();
        let inverse = &order.factorials.inverse;
        let sums = sums.get(..order.terms).unwrap_or_default();
        add_across(isa, sums, [real, imaginary], |k| inverse.get(k).copied().present_or(T::ZERO));
    }
}

/// Room for a series, with a vector of zeros on either side.
pub(super) const ROOM: usize = MAX_TERMS + 3 * MAX_LANES;

/// The most vectors of a series: the shortest ones have two lanes.
pub(super) const MAX_BLOCKS: usize = MAX_TERMS / 2;

/// Vectors of so many coefficients.
#[inline(always)]
pub(super) fn blocks_of<T: Real, I: Isa<T>>(terms: usize) -> usize {
    terms.div_ceil(I::LANES)
}

/// The numbers of lanes, and which lanes have each binary digit in their number.
pub(super) struct Lanes<V, M> {
    number: V,
    digits: [M; 4],
}

impl<V: Copy, M: Copy> Lanes<V, M> {
    #[inline(always)]
    pub fn new<T: Real, I: Isa<T, V = V, M = M>>(isa: I) -> Self {
        let (mut number, mut digits) = ([T::ZERO; MAX_LANES], [isa.lt(isa.splat(T::ZERO), isa.splat(T::ZERO)); 4]);
        number.iter_mut().enumerate().for_each(|(lane, to)| *to = T::from_usize(lane));
        for (number, digit) in digits.iter_mut().enumerate() {
            let mut is_set = [T::ZERO; MAX_LANES];
            is_set.iter_mut().enumerate().for_each(|(lane, to)| *to = T::from_usize(lane >> number & 1));
            *digit = isa.lt(isa.splat(T::ZERO), isa.load(&is_set));
        }
        Self { number: isa.load(&number), digits }
    }

    /// The powers of a complex number from 0 on, one a lane, and the power by which the next block of them is larger.
    #[inline(always)]
    pub fn powers<T: Real, I: Isa<T, V = V, M = M>>(&self, isa: I, z: [V; 2]) -> ([V; 2], [V; 2]) {
        let (zero, one) = (isa.splat(T::ZERO), isa.splat(T::ONE));
        let (mut power, mut factor) = ([one, zero], z);
        for (number, &digit) in self.digits.iter().enumerate().take(I::LANES.ilog2() as usize) {
            let next = [isa.select(digit, factor[0], one), isa.select(digit, factor[1], zero)];
            power = if number == 0 { next } else { times(isa, power, next) };
            factor = times(isa, factor, factor);
        }
        (power, factor)
    }

    /// The same of a real number.
    #[inline(always)]
    pub fn real_powers<T: Real, I: Isa<T, V = V, M = M>>(&self, isa: I, x: V) -> (V, V) {
        let one = isa.splat(T::ONE);
        let (mut power, mut factor) = (one, x);
        for &digit in self.digits.iter().take(I::LANES.ilog2() as usize) {
            power = isa.mul(power, isa.select(digit, factor, one));
            factor = isa.mul(factor, factor);
        }
        (power, factor)
    }

    /// Adds the first so many lanes of real and imaginary parts to rows.
    #[inline(always)]
    pub fn add_first<T: Real, I: Isa<T, V = V, M = M>>(
        &self,
        isa: I,
        lanes: usize,
        (to_re, to_im): (&mut I::Row, &mut I::Row),
        [re, im]: [V; 2],
    ) {
        let (zero, is_first) = (isa.splat(T::ZERO), isa.lt(self.number, isa.splat(T::from_usize(lanes))));
        *to_re = isa.store_row(isa.add(isa.load_row(to_re), isa.select(is_first, re, zero)));
        *to_im = isa.store_row(isa.add(isa.load_row(to_im), isa.select(is_first, im, zero)));
    }
}

/// The most pairs of boxes that are translated at a time.
pub(super) const PAIRS: usize = 2;

/// A series, real and imaginary parts.
pub(super) type Series<T> = [[T; ROOM]; 2];

/// Series of a task, where numbers that no operator writes are zero.
pub(super) struct Room<T> {
    /// e_n from place [`MAX_LANES`] on.
    powers: Series<T>,
    /// The coefficients that they are multiplied with.
    factors: Series<T>,
    /// Those of pairs of boxes.
    pub pairs: [Series<T>; PAIRS],
}

impl<T: Real> Room<T> {
    pub fn new() -> Self {
        let none = [[T::ZERO; ROOM]; 2];
        Self { powers: none, factors: none, pairs: [none; PAIRS] }
    }
}

/// e_n = step^n / n!, from place [`MAX_LANES`] on.
#[inline(always)]
fn exponential<T: Real, I: Isa<T>>(
    isa: I,
    lanes: &Lanes<I::V, I::M>,
    step: [T; 2],
    terms: usize,
    inverse: &[T; ROOM],
    [real, imaginary]: &mut Series<T>,
) {
    let (mut power, factor) = lanes.powers(isa, [isa.splat(step[0]), isa.splat(step[1])]);
    let real = I::Row::of_mut(real.get_mut(MAX_LANES..).unwrap_or_default());
    let imaginary = I::Row::of_mut(imaginary.get_mut(MAX_LANES..).unwrap_or_default());
    for ((re, im), inverse) in real.iter_mut().zip(imaginary).zip(I::Row::of(inverse)).take(blocks_of::<T, I>(terms)) {
        let inverse = isa.load_row(inverse);
        (*re, *im) = (isa.store_row(isa.mul(power[0], inverse)), isa.store_row(isa.mul(power[1], inverse)));
        power = times(isa, power, factor);
    }
}

/// A vector of a series from some place on.
#[inline(always)]
fn at<T: Real, I: Isa<T>>(isa: I, series: &[T; ROOM], place: usize) -> I::V {
    match I::Row::of(series.get(place..).present_or(&[])).first() {
        Some(row) => isa.load_row(row),
        None => isa.splat(T::ZERO),
    }
}

/// The sums over j of x_j times a vector of y from place `start` on, going down by one (`DOWN`) or up: complex, in four sums that do not wait for each other.
#[inline(always)]
fn product<T: Real, I: Isa<T>, const DOWN: bool>(isa: I, x: [&[T]; 2], y: &Series<T>, start: usize) -> [I::V; 2] {
    let zero = isa.splat(T::ZERO);
    let (mut rr, mut ii, mut ri, mut ir) = (zero, zero, zero, zero);
    let [real, imaginary] = y;
    let [x_real, x_imaginary] = x;
    for (j, (&a, &b)) in x_real.iter().zip(x_imaginary).enumerate() {
        let place = if DOWN { start - j } else { start + j };
        let (a, b, c, d) = (isa.splat(a), isa.splat(b), at(isa, real, place), at(isa, imaginary, place));
        rr = isa.mul_add(a, c, rr);
        ii = isa.mul_add(b, d, ii);
        ri = isa.mul_add(a, d, ri);
        ir = isa.mul_add(b, c, ir);
    }
    [isa.sub(rr, ii), isa.add(ri, ir)]
}

/// Adds the expansion of a part to that of the larger box.
pub(super) struct Raise<'a, T> {
    pub order: Order<'a, T>,
    pub from: (&'a [T], Shape<T>),
    pub shape: Shape<T>,
    pub room: &'a mut Room<T>,
    pub to: &'a mut [T],
}

/// R'/R and (c' - c)/R.
#[inline(always)]
fn step<T: Real>(small: &Shape<T>, large: &Shape<T>) -> (T, [T; 2]) {
    let inverse = inverse(large.radius);
    let ([x, y], [u, v]) = (small.centre, large.centre);
    (small.radius * inverse, [(x - u) * inverse, (y - v) * inverse])
}

impl<T: Real> Job<T> for Raise<'_, T> {
    type Out = ();

    #[inline(always)]
    fn run<I: Isa<T>>(self, isa: I) {
        let Self { order: Order { terms, stride, factorials }, from: (from, small), shape, room, to } = self;
        let Room { powers, factors: [real, imaginary], .. } = room;
        let (ratio, step) = step(&small, &shape);
        let lanes = Lanes::new(isa);
        exponential(isa, &lanes, step, terms, &factorials.inverse, powers);
        let (from_real, from_imaginary) = from.split_at_checked(stride).unwrap_or_default();
        let (mut scale, factor) = lanes.real_powers(isa, isa.splat(ratio));
        let from = I::Row::of(from_real).iter().zip(I::Row::of(from_imaginary));
        let to_rows = I::Row::of_mut(&mut *real).iter_mut().zip(I::Row::of_mut(&mut *imaginary));
        for ((re, im), (to_re, to_im)) in from.zip(to_rows) {
            *to_re = isa.store_row(isa.mul(isa.load_row(re), scale));
            *to_im = isa.store_row(isa.mul(isa.load_row(im), scale));
            scale = isa.mul(scale, factor);
        }
        let (to_real, to_imaginary) = to.split_at_mut_checked(stride).unwrap_or_default();
        let to = I::Row::of_mut(to_real).iter_mut().zip(I::Row::of_mut(to_imaginary));
        for (first, to) in (0..terms).step_by(I::LANES).zip(to) {
            let some = terms.min(first + I::LANES);
            let x = [real.get(..some).unwrap_or_default(), imaginary.get(..some).unwrap_or_default()];
            lanes.add_first(isa, terms - first, to, product::<T, I, true>(isa, x, powers, MAX_LANES + first));
        }
    }
}

/// Adds the local expansion of a box to that of a part.
pub(super) struct Lower<'a, T> {
    pub order: Order<'a, T>,
    pub from: (&'a [T], Shape<T>),
    pub shape: Shape<T>,
    pub room: &'a mut Room<T>,
    pub to: &'a mut [T],
}

impl<T: Real> Job<T> for Lower<'_, T> {
    type Out = ();

    #[inline(always)]
    fn run<I: Isa<T>>(self, isa: I) {
        let Self { order: Order { terms, stride, factorials }, from: (from, large), shape, room, to } = self;
        let Room { powers, factors, .. } = room;
        let (ratio, step) = step(&shape, &large);
        let lanes = Lanes::new(isa);
        exponential(isa, &lanes, step, terms + 1, &factorials.inverse, powers);
        let (from_real, rest) = from.split_at_checked(stride).unwrap_or_default();
        let (from_imaginary, potential) = rest.split_at_checked(stride).unwrap_or_default();
        let [real, imaginary] = &mut *factors;
        for (to, from) in [(real, from_real), (imaginary, from_imaginary)] {
            I::Row::of_mut(to).iter_mut().zip(I::Row::of(from)).for_each(|(to, row)| *to = *row);
        }
        let [e_real, e_imaginary] = &*powers;
        let e_real = e_real.get(MAX_LANES..).unwrap_or_default();
        let e_imaginary = e_imaginary.get(MAX_LANES..).unwrap_or_default();
        let (to_real, rest) = to.split_at_mut_checked(stride).unwrap_or_default();
        let (to_imaginary, to_potential) = rest.split_at_mut_checked(stride).unwrap_or_default();
        for (to, &value) in to_potential.iter_mut().zip(potential).take(1) {
            let mut sum = T::ZERO;
            let e = e_real.iter().zip(e_imaginary).skip(1);
            for ((&a, &b), (&c, &d)) in from_real.iter().zip(from_imaginary).zip(e).take(terms) {
                sum += a * c - b * d;
            }
            *to += value + large.radius * sum;
        }
        let (mut scale, factor) = lanes.real_powers(isa, isa.splat(ratio));
        let to = I::Row::of_mut(to_real).iter_mut().zip(I::Row::of_mut(to_imaginary));
        for (first, to) in (0..terms).step_by(I::LANES).zip(to) {
            let left = terms - first;
            let e = [e_real.get(..left).unwrap_or_default(), e_imaginary.get(..left).unwrap_or_default()];
            let [a, b] = product::<T, I, false>(isa, e, factors, first);
            lanes.add_first(isa, left, to, [isa.mul(a, scale), isa.mul(b, scale)]);
            scale = isa.mul(scale, factor);
        }
    }
}

/// Coefficients of a polynomial.
type Coefficients<T> = heapless::Vec<[T; 2], MAX_TERMS>;

/// Adds the values of a local expansion at the targets of its box: lanes are targets.
pub(super) struct Scatter<'a, T> {
    pub order: Order<'a, T>,
    pub from: &'a [T],
    pub shape: Shape<T>,
    /// In true units, and the factor that leads to the shape's.
    pub points: (&'a [[T; 2]], T),
    pub potential: Option<&'a mut [T]>,
    pub gradient: Option<&'a mut [[T; 2]]>,
    pub hessian: Option<&'a mut [[[T; 2]; 2]]>,
    /// Factors of the results, multiplied one after the other.
    pub scales: [[T; 3]; 3],
}

impl<T: Real> Job<T> for Scatter<'_, T> {
    type Out = ();

    #[inline(always)]
    fn run<I: Isa<T>>(self, isa: I) {
        isa.in_blocks(self);
    }
}

/// The three factors one after the other.
#[inline(always)]
fn scaled<T: Real>(x: T, [a, b, c]: [T; 3]) -> T {
    x * a * b * c
}

impl<T: Real> BlockJob<T> for Scatter<'_, T> {
    type Out = ();

    #[inline(always)]
    fn run<I: Isa<T>, const N: usize>(self, isa: I) {
        let Self { order, from, shape, points: (points, factor), mut potential, mut gradient, mut hessian, scales } =
            self;
        let Order { terms, stride, factorials } = order;
        let (real, rest) = from.split_at_checked(stride).unwrap_or_default();
        let (imaginary, constant) = rest.split_at_checked(stride).unwrap_or_default();
        let constant = constant.first().copied().unwrap_or(T::ZERO);
        // Of f', of f over the radius, and of R f'', lowest power first; as far as they are wanted.
        let coefficients = |of: bool, first: usize, weights: usize| {
            let weights = factorials.inverse.iter().skip(weights);
            let all = real.iter().zip(imaginary).take(if of { terms } else { 0 }).skip(first).zip(weights);
            let mut list = Coefficients::new();
            for ((&a, &b), &weight) in all {
                // There is room for the most terms. (To collect them would be a way to panic.)
                if list.push([a * weight, b * weight]).is_err() {
                    break;
                }
            }
            list
        };
        let slope = coefficients(gradient.is_some(), 0, 0);
        let value = coefficients(potential.is_some(), 0, 1);
        let curve = coefficients(hessian.is_some(), 1, 0);
        let each = N * I::LANES;
        let [of_potential, of_gradient, of_hessian] = scales;
        for (block, points) in points.chunks(each).enumerate() {
            let u = load_points::<T, I, N>(isa, points, factor, &shape);
            if let Some(gradient) = gradient.as_deref_mut() {
                let sums = horner::<T, I, N>(isa, &slope, &u);
                for ((v, [a, b]), _) in sums.iter().enumerate().zip(points.chunks(I::LANES)) {
                    let (a, b) = (isa.store(*a), isa.store(*b));
                    let to = gradient.iter_mut().skip(block * each + v * I::LANES).take(I::LANES);
                    for ([x, y], (&a, &b)) in to.zip(a.iter().zip(&b)) {
                        *x += scaled(a, of_gradient);
                        *y += scaled(-b, of_gradient);
                    }
                }
            }
            if let Some(hessian) = hessian.as_deref_mut() {
                let sums = horner::<T, I, N>(isa, &curve, &u);
                let inverse = isa.splat(inverse(shape.radius));
                for ((v, [a, b]), _) in sums.iter().enumerate().zip(points.chunks(I::LANES)) {
                    let (a, b) = (isa.store(isa.mul(*a, inverse)), isa.store(isa.mul(*b, inverse)));
                    let to = hessian.iter_mut().skip(block * each + v * I::LANES).take(I::LANES);
                    for ([[xx, xy], [yx, yy]], (&a, &b)) in to.zip(a.iter().zip(&b)) {
                        let (a, b) = (scaled(a, of_hessian), scaled(-b, of_hessian));
                        (*xx, *xy, *yx, *yy) = (*xx + a, *xy + b, *yx + b, *yy - a);
                    }
                }
            }
            if let Some(potential) = potential.as_deref_mut() {
                let sums = horner::<T, I, N>(isa, &value, &u);
                let (radius, constant) = (isa.splat(shape.radius), isa.splat(constant));
                for (((v, &sum), &u), _) in sums.iter().enumerate().zip(&u).zip(points.chunks(I::LANES)) {
                    let [a, _] = times(isa, sum, u);
                    let a = isa.store(isa.mul_add(a, radius, constant));
                    let to = potential.iter_mut().skip(block * each + v * I::LANES).take(I::LANES);
                    to.zip(&a).for_each(|(to, &a)| *to += scaled(a, of_potential));
                }
            }
        }
    }
}

/// A polynomial with complex coefficients, lowest power first.
#[inline(always)]
fn horner<T: Real, I: Isa<T>, const N: usize>(isa: I, coefficients: &[[T; 2]], u: &[[I::V; 2]; N]) -> [[I::V; 2]; N] {
    let zero = isa.splat(T::ZERO);
    let mut sums = [[zero; 2]; N];
    for &[a, b] in coefficients.iter().rev() {
        let (a, b) = (isa.splat(a), isa.splat(b));
        for (sum, &[x, y]) in sums.iter_mut().zip(u) {
            let [re, im] = *sum;
            *sum = [isa.neg_mul_add(im, y, isa.mul_add(re, x, a)), isa.mul_add(im, x, isa.mul_add(re, y, b))];
        }
    }
    sums
}

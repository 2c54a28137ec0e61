//! Close pairs that do not merge: a sub-step moves them so that their mean squared distance is right.
//!
//! Two particles of masses m and m' at distance r approach each other at the speed `c / r`, `c = chi gamma (m + m')`. Explicit steps of any
//! length s fail at distances of sqrt(c s): they throw the two past each other, to a distance of c s / r. Pairs that merge are there once at
//! most. Those that do not, with an index (2.7) above -1 or where nothing merges, come back again and again.
//!
//! For two particles alone (2.3) gives the mean exactly: `|x|^2` grows by `(4 D - 2 c) s`, `D = mu~ (1 / m + 1 / m')`. So the sub-step moves the
//! particles by their noise, and by the attraction of all but their close partners, from x_0 to x_1, where `|x_1|^2` has the mean
//! `rho^2 = |x_0|^2 + 4 D s`, and then takes from the square of the distance of each close pair, about its centre of mass,
//!
//! `q |x_1|^2 - 2 c s (g(rho) - g(|x_1|))`, `q = 2 c s g(rho) / rho^2`,
//!
//! whose mean is that of the work of the attraction, `2 c s g(|x_1|)`. Here g is `r V'(r) / gamma`, 1 for a logarithm, and less within the length of a
//! mollifier. What several pairs take adds up, so (2.3) holds in the mean for every cluster whose pairs are all close: the second moment of
//! (2.2) has the drift alpha of (2.4). Nothing is taken below zero, so pairs of an index below -1 stay together once they have met.
//!
//! A pair is close if, at its distance or at sqrt(D s) / 8 if that is more, its attraction moves it by more than sqrt(D s) / 8, a sixteenth of the
//! noise's root mean square, and reduces the square of its distance by more than 1/64 of it. The first leaves out all pairs of an index above -1/128, so of
//! many light particles none is close.

use super::collision::Merging;
use super::search::particle;
use super::state::Options;
use crate::checked::Present;
use crate::field::Interaction;
use crate::memory::Space;
use crate::mollifier::{Blob, Mollifier, Polynomial};
use crate::real::{Real, normal_exponent, quotient};
use crate::sort::radix::keys_per_width;
use crate::sort::words as sort;

/// The search's memory.
#[derive(Debug)]
pub struct Buffers<'w, T> {
    /// Key of the first coordinate in the high half, the particle in the low half.
    words: &'w mut [u64],
    /// Scratch of the sort.
    spare: &'w mut [u64],
    counts: &'w mut [u32],
    /// Where the particles were at the start of the sub-step.
    before: &'w mut [[T; 2]],
}

impl<'w, T: Real> Buffers<'w, T> {
    /// Lays out the memory for `n` particles under the sum of a kernel.
    pub fn layout(space: &mut impl Space<'w>, n: usize, options: &Options<T>) -> Self {
        let n = if options.merging == Merging::All || options.noise == T::ZERO { 0 } else { n };
        let many = if n <= sort::FEW { 0 } else { n };
        Self {
            words: space.array(n),
            spare: space.array(many),
            counts: space.array(if many > 0 { sort::BUCKETS } else { 0 }),
            before: space.array(n),
        }
    }
}

/// The close pairs of a sub-step.
pub struct Close<'a, T: Real> {
    kernel: &'a dyn Interaction<T, 2>,
    /// The Newtonian kernel's coefficient / (2 pi), and its mollifier.
    newtonian: Option<(T, &'a Blob<T, 2>)>,
    /// The strength of the logarithm near zero.
    gamma: T,
    options: &'a Options<T>,
    masses: &'a [T],
    /// Diffusivity of the lightest particle.
    fastest: T,
    largest: T,
    buffers: Buffers<'a, T>,
    /// Masses are multiplied by 2 to minus this. This and the other units are powers of two, by which squares and products stay in range.
    mass: i32,
    /// That power.
    per_mass: T,
    /// chi gamma and mu~, as far as their ratio goes, for masses in that unit.
    ratio: [T; 2],
    /// Minus the index of two masses as far as it matters for merging, over their product: a pair merges from 1 on.
    merging: T,
    /// Lengths are multiplied by 2 to minus this.
    length: i32,
    /// That power.
    per_length: T,
    /// Times are multiplied by 2 to minus this.
    time: i32,
    /// chi and mu~ in these units, in which the rest is, too.
    chi: T,
    noise: T,
    /// Pairs are close within a time of this.
    within: T,
    /// The lowest first coordinate, and keys per length.
    low: T,
    per: T,
}

/// Two close particles: their indices, and the square of the distance at the start of the sub-step.
type Body<'b, T> = dyn FnMut(usize, usize, T) + 'b;

/// Adds these multiples of `d` to two points.
fn shift<T: Real>(points: &mut [[T; 2]], d: [T; 2], at: [(usize, T); 2]) {
    for (k, by) in at {
        if let Some([x, y]) = points.get_mut(k) {
            (*x, *y) = (*x + by * d[0], *y + by * d[1]);
        }
    }
}

impl<'a, T: Real> Close<'a, T> {
    /// The close pairs of particles of these masses under the sum of this kernel; `None` if no pair ever is.
    pub fn new(
        kernel: &'a dyn Interaction<T, 2>,
        options: &'a Options<T>,
        masses: &'a [T],
        buffers: Buffers<'a, T>,
    ) -> Option<Self> {
        let &Options { chi, noise, gamma, merging, .. } = options;
        if merging == Merging::All {
            return None;
        }
        let newtonian = kernel.newtonian().map(|(coefficient, blob)| (coefficient / (T::TWO * T::PI), blob));
        let (mut smallest, mut largest) = (T::INFINITY, T::ZERO);
        for &m in masses {
            (smallest, largest) = (smallest.min(m), largest.max(m));
        }
        let mass = normal_exponent::<T>(largest.frexp().1);
        let both = (chi.frexp().1 + 2 * mass).max(noise.frexp().1);
        let (pull, push) = (chi.ldexp(2 * mass - both), noise.ldexp(-both));
        let near = newtonian.map_or(gamma, |(strength, _)| strength);
        if !(push > T::ZERO && pull * near > T::ZERO) {
            return None;
        }
        let close = Self {
            kernel,
            newtonian,
            gamma: near,
            options,
            masses,
            fastest: noise / smallest,
            largest: largest.ldexp(-mass),
            buffers,
            mass,
            per_mass: T::ONE.ldexp(-mass),
            ratio: [pull * near, push],
            merging: if merging == Merging::Hard { quotient(pull * gamma, T::TWO * push) } else { T::ZERO },
            length: 0,
            per_length: T::ONE,
            time: 0,
            chi,
            noise,
            within: T::ZERO,
            low: T::ZERO,
            per: T::ZERO,
        };
        let least = T::from_f64(1.0 / 128.0);
        (close.index(close.largest, close.largest) > least).then_some(close)
    }

    /// The diffusivity of the lightest particle.
    pub fn diffusivity(&self) -> T {
        self.fastest
    }

    /// A particle's mass.
    fn mass(&self, i: usize) -> Option<T> {
        self.masses.get(i).map(|&m| m * self.per_mass)
    }

    /// Differences of two points as they are given, and the square of their distance.
    fn apart(&self, points: &[[T; 2]], i: usize, j: usize) -> Option<([T; 2], T)> {
        let ([a, b], [c, d]) = (*points.get(i)?, *points.get(j)?);
        let given = [a - c, b - d];
        let [x, y] = given.map(|d| d * self.per_length);
        Some((given, x * x + y * y))
    }

    /// Minus the index (2.7) of two masses.
    fn index(&self, m: T, other: T) -> T {
        let [pull, push] = self.ratio;
        pull * m / (T::TWO * push) * other
    }

    /// V'(r) / r for this r^2.
    fn factor(&self, square: T) -> T {
        let by_kernel = || self.kernel.gradient_factor(square.sqrt().ldexp(self.length)).ldexp(2 * self.length);
        let Some((strength, blob)) = self.newtonian else { return by_kernel() };
        let delta = blob.delta() * self.per_length;
        let edge = delta * delta;
        match blob.terms(Polynomial::Gradient) {
            Some(terms) if square < edge => {
                let t = T::ONE - square / edge;
                let coefficients = (0..terms).rev().map(|k| blob.coefficient(Polynomial::Gradient, k));
                coefficients.fold(T::ZERO, |sum, c| sum * t + c) * (strength / edge)
            }
            None if blob.mollifier() != Mollifier::None => by_kernel(),
            _ => strength / square,
        }
    }

    /// Whether a mollifier is so long that no pair is close.
    fn is_resolved(&self) -> bool {
        // Inside, the factor is largest at 0 for orders 2 and 4, whose polynomials have coefficients of one sign, and less than twice that for
        // the others.
        let compact = self.newtonian.is_some_and(|(_, blob)| blob.terms(Polynomial::Gradient).is_some());
        compact && T::from_i32(512) * self.chi * self.largest * self.within * self.factor(T::ZERO) <= T::ONE
    }

    /// Whether two particles at this squared distance are close.
    fn holds(&self, square: T, m: T, other: T) -> bool {
        let per_64 = T::from_f64(1.0 / 64.0);
        // D s / 64
        let spread = per_64 * self.within * (quotient(self.noise, m) + quotient(self.noise, other));
        let square = square.max(spread);
        let pull = self.chi * (m + other) * self.within * self.factor(square);
        self.merging * m * other < T::ONE && T::TWO * pull > per_64 && pull * pull * square > spread
    }

    /// The key of a first coordinate: none is above that of a larger one.
    fn key(&self, x: T) -> u32 {
        ((x - self.low) * self.per).to_u32()
    }

    /// Looks for the pairs that are close within a sub-step of this length from these points; whether there are any.
    pub fn seek(&mut self, points: &[[T; 2]], within: T) -> bool {
        let farthest = points.as_flattened().iter().fold(T::ZERO, |most, x| most.max(x.abs()));
        (self.length, self.time) = (normal_exponent::<T>(farthest.frexp().1), normal_exponent::<T>(within.frexp().1));
        let both = self.time - 2 * self.length;
        self.per_length = T::ONE.ldexp(-self.length);
        self.chi = self.options.chi.ldexp(both + self.mass);
        self.noise = self.options.noise.ldexp(both - self.mass);
        self.within = within.ldexp(-self.time);
        if self.is_resolved() {
            return false;
        }
        let (mut low, mut high) = (T::INFINITY, -T::INFINITY);
        for (x, to) in points.iter().zip(self.buffers.before.iter_mut()) {
            *to = x.map(|x| x * self.per_length);
            (low, high) = (low.min(to[0]), high.max(to[0]));
        }
        // Without a width all have the same key.
        (self.low, self.per) = (low, keys_per_width(T::ONE.ldexp(31), high - low).unwrap_or(T::ZERO));
        for (i, [x, _]) in self.buffers.before.iter().take(points.len()).enumerate() {
            let word = u64::from(self.key(*x)) << 32 | i as u64;
            self.buffers.words.get_mut(i).into_iter().for_each(|to| *to = word);
        }
        let Buffers { words, spare, counts, .. } = &mut self.buffers;
        let words = words.get_mut(..points.len()).present_or_default();
        sort::by_high_half(words, spare, counts);
        let mut any = false;
        self.each(false, &mut |_, _, _| any = true);
        any
    }

    /// Calls the body for each close pair, the heavier particle first (of equal ones that with the lower first coordinate), in the order of these, or in
    /// the opposite order.
    fn each(&self, backwards: bool, body: &mut Body<'_, T>) {
        let words = self.buffers.words.get(..self.masses.len()).present_or(&[]);
        let at = |place: usize| {
            let i = words.get(place).map_or(0, |&word| particle(word));
            (i, self.buffers.before.get(i).copied().present_or_default(), self.mass(i).present_or_default())
        };
        let key_at = |place: usize| words.get(place).map(|word| (word >> 32) as u32);
        let turn = |from: usize, step: usize, to: usize| if backwards { to - 1 - step } else { from + step };
        let n = words.len();
        for step in 0..n {
            let place = turn(0, step, n);
            let (i, x, m) = at(place);
            // A logarithm moves two of this mass at r by 2 chi gamma m s / r.
            let square = T::from_i32(256) * (self.chi * self.gamma * m * self.within) * self.index(m, m).min(T::ONE);
            let reach = square.sqrt();
            let (least, most) = (self.key(x[0] - reach), self.key(x[0] + reach));
            let (mut from, mut to) = (place, place + 1);
            while from > 0 && key_at(from - 1).is_some_and(|key| key >= least) {
                from -= 1;
            }
            while key_at(to).is_some_and(|key| key <= most) {
                to += 1;
            }
            for step in 0..to - from {
                let other = turn(from, step, to);
                let (j, y, mass) = at(other);
                let [dx, dy] = [x[0] - y[0], x[1] - y[1]];
                let distance = dx * dx + dy * dy;
                let first = mass < m || mass == m && other > place;
                if first && distance <= square && self.holds(distance, m, mass) {
                    body(i, j, distance);
                }
            }
        }
    }

    /// Takes the attraction of close pairs out of the gradient at these points.
    pub fn leave(&self, points: &[[T; 2]], gradient: &mut [[T; 2]]) {
        self.each(false, &mut |i, j, _| {
            let (Some((d, square)), Some(m), Some(other)) = (self.apart(points, i, j), self.mass(i), self.mass(j))
            else {
                return;
            };
            let factor = if square >= T::MIN_POSITIVE { self.factor(square) } else { T::ZERO };
            // A gradient is of the unit of mass over that of length.
            let d = d.map(|d| d.ldexp(self.mass - 2 * self.length));
            shift(gradient, d, [(i, -(other * factor)), (j, m * factor)]);
        });
    }

    /// Draws close pairs together after a sub-step of length `s` without their attraction; `arrived` is overwritten.
    pub fn draw(&self, s: T, arrived: &mut [[T; 2]], positions: &mut [[T; 2]]) {
        let s = s.ldexp(-self.time);
        arrived.iter_mut().zip(&*positions).for_each(|(to, x)| *to = *x);
        // Half of it in one order, half in the other.
        for backwards in [false, true] {
            self.each(backwards, &mut |i, j, before| {
                let (Some(m), Some(other)) = (self.mass(i), self.mass(j)) else { return };
                let (Some((_, end)), Some((d, now))) = (self.apart(arrived, i, j), self.apart(positions, i, j)) else {
                    return;
                };
                if now < T::MIN_POSITIVE {
                    return;
                }
                let rho = before + T::from_i32(4) * s * (quotient(self.noise, m) + quotient(self.noise, other));
                let twice = T::TWO * self.chi * (m + other) * s;
                let work =
                    |square: T| if square >= T::MIN_POSITIVE { twice * self.factor(square) * square } else { T::ZERO };
                let all = work(rho);
                let taken = all * (end / rho) - (all - work(end));
                let left = (now - T::HALF * taken).max(T::ZERO);
                let less = T::ONE - left.sqrt() / now.sqrt();
                if less.is_finite() {
                    let mass = m + other;
                    shift(positions, d, [(i, -(less * (other / mass))), (j, less * (m / mass))]);
                }
            });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::memory::{ALIGN, Carve, Measure};
    use crate::pks::testing::Uniform;
    use std::vec;
    use std::vec::Vec;

    /// The close pairs found are those of all pairs, whatever the masses, and backwards they come in the opposite order.
    fn found<T: Real>(n: usize, merging: Merging, spread: f64) -> usize {
        let c = T::from_f64;
        let mut numbers = Uniform(n as u64);
        let points: Vec<[T; 2]> = (0..n).map(|_| [0, 1].map(|_| c(numbers.next()))).collect();
        let masses: Vec<T> = (0..n).map(|_| c(10_f64.powf(spread * numbers.next()))).collect();
        let kernel = Blob::<T, 2>::new(Mollifier::Compact { order: 4, exponent: 4 }, c(1e-3)).unwrap();
        let options = Options { merging, ..Options::new(c(3.0), T::ONE) };
        let bytes = Measure::of(|space| {
            Buffers::<T>::layout(space, n, &options);
            space.finish()
        });
        let mut memory = vec![0xAB_u8; bytes.unwrap() + ALIGN];
        let start = memory.as_ptr().align_offset(ALIGN);
        let buffers = Buffers::layout(&mut Carve::reopen(&mut memory[start..]).unwrap(), n, &options);
        let mut close = Close::new(&kernel, &options, &masses, buffers).unwrap();
        let within = c(0.1 / n as f64);
        let any = close.seek(&points, within);
        let mut got = Vec::new();
        close.each(false, &mut |i, j, _| got.push((i, j)));
        let mut back = Vec::new();
        close.each(true, &mut |i, j, _| back.push((i, j)));
        back.reverse();
        assert!(got == back && any != got.is_empty());
        // Of all pairs, by the definition alone.
        let mut want = Vec::new();
        for i in 0..n {
            for j in 0..i {
                let (m, other) = (masses[i].to_f64(), masses[j].to_f64());
                let [dx, dy] = [0, 1].map(|k| (points[i][k] - points[j][k]).to_f64());
                let (d, s) = (1.0 / m + 1.0 / other, within.to_f64());
                let r = dx.hypot(dy).max((d * s).sqrt() / 8.0);
                let pull = 3.0 * (m + other) * s * kernel.gradient_factor(c(r)).to_f64();
                let index = -3.0 * m * other / (2.0 * core::f64::consts::TAU);
                let merges = merging == Merging::Hard && index <= -1.0;
                if !merges && pull * r > (d * s).sqrt() / 8.0 && 2.0 * pull > 1.0 / 64.0 {
                    want.push((i.max(j), i.min(j)));
                }
            }
        }
        let mut sorted: Vec<_> = got.iter().map(|&(i, j)| (i.max(j), i.min(j))).collect();
        sorted.sort_unstable();
        want.sort_unstable();
        assert!(sorted == want, "{n} {merging:?} {spread}: {} {}", sorted.len(), want.len());
        got.len()
    }

    #[test]
    fn all_close_pairs_are_found() {
        for n in [2, 3, 33, 512, 513, 1500] {
            for spread in [0.0, 1.5] {
                for merging in [Merging::Hard, Merging::Never] {
                    let pairs = found::<f64>(n, merging, spread);
                    assert!(pairs >= n / 4, "{n} {spread} {merging:?}: {pairs}");
                    found::<f32>(n, merging, spread);
                }
            }
        }
    }
}

//! Whether an isolated cluster collapses within a step, and when.
//!
//! The second moment Y of an isolated cluster follows `dY = alpha dt + 2 beta sqrt(Y) dW~` (2.3), a squared Bessel process of index nu
//! (2.7) on the clock beta^2 t. For nu < 0 it hits zero at `tau = Y / (2 beta^2 U)`, U ~ Gamma(|nu|, 1) ((2.10) with its constant
//! restored), so within dt with probability `Q(|nu|, Y / (2 beta^2 dt))`.
//!
//! [`CollisionLaw::Exact`] turns the recorded increment into a uniform number `u = Phi(dW~ / sqrt dt)` and merges if u < Q; the time
//! is then the one with `Q(|nu|, Y / (2 beta^2 tau)) = u`. [`CollisionLaw::Printed`] takes one Gaussian step of Y, (3.11) in the reading
//! `Y + dY <= 0`: it merges close pairs, whose nu is barely below zero, far too often.

use super::extent::Extent;
use super::theory::{Constants, Group};
use crate::build;
use crate::error::{Error, Result};
use crate::real::{Real, normal_exponent};
use crate::special::{incomplete_gamma, normal};

/// How a cluster's collision is decided.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum CollisionLaw {
    /// The law of the hitting time of zero.
    #[default]
    Exact,
    /// One Gaussian increment of the second moment, (3.2) and (3.11).
    Printed,
}

/// Which collisions are inelastic.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Merging {
    /// All that can happen: nu < 0.
    #[default]
    All,
    /// Only those that must happen: nu <= -1. The paper's "hard" collisions. Under [`Attraction::Sum`](super::Attraction::Sum) the pairs that
    /// collide and do not merge keep the mean of their squared distance, however close they are.
    Hard,
    /// None: particles never merge and no cluster is searched for. Under [`Attraction::Sum`](super::Attraction::Sum) pairs with nu <= -1 stay together
    /// once they have met, others as with `Hard`.
    Never,
}

/// What masses and lengths are multiplied by, so that squares and products stay in range: powers of two, so that nothing is rounded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Units<T> {
    /// What masses are multiplied by.
    pub mass: T,
    /// What lengths are multiplied by.
    pub length: T,
    /// Times are multiplied by 2 to minus this.
    pub time: i32,
}

/// The decision, prepared for one step.
#[derive(Clone, Copy, Debug)]
pub struct Criterion<T> {
    /// The units of all that follows, and of whatever the decision is given.
    pub units: Units<T>,
    /// chi, mu~, gamma.
    pub constants: Constants<T>,
    /// Exact or printed.
    pub law: CollisionLaw,
    /// Soft and hard, or hard only.
    pub merging: Merging,
    /// p: clusters that collide with a smaller probability are left alone.
    pub probability: T,
    /// Phi^{-1}(p), for the printed law.
    pub quantile: T,
    /// The step.
    pub dt: T,
}

impl<T: Real> Criterion<T> {
    /// Prepares the decision, in the units of the constants and the step.
    #[must_use]
    pub fn new(constants: Constants<T>, law: CollisionLaw, merging: Merging, probability: T, dt: T) -> Self {
        let quantile = match law {
            CollisionLaw::Printed if build::PRINTED_LAW => normal::quantile(probability),
            CollisionLaw::Exact | CollisionLaw::Printed => T::ZERO,
        };
        let units = Units { mass: T::ONE, length: T::ONE, time: 0 };
        Self { units, constants, law, merging, probability, quantile, dt }
    }

    /// Goes over to the attraction of particles of this sensitivity, and to their weights for masses.
    ///
    /// # Errors
    /// [`Error::OutOfDomain`]: a constant leaves the range.
    pub fn respond(&mut self, sensitivity: T) -> Result<()> {
        // Twice, as masses are weights times it.
        for constant in [&mut self.constants.chi, &mut self.constants.gamma] {
            let before = *constant;
            *constant *= sensitivity;
            if !constant.is_finite() || constant.abs() < T::MIN_POSITIVE && before != T::ZERO {
                return Err(Error::OutOfDomain);
            }
        }
        Ok(())
    }

    /// Goes over to units in which the mass of all particles, their farthest coordinate, and the larger one of `gamma chi M^2` and mu~, M being that mass,
    /// are near 1, for a criterion that has none yet.
    ///
    /// The unit of mass has an even exponent, for square roots of masses. Returns whether indices are in range: else there is noise, but too little.
    #[must_use]
    pub fn scale(&mut self, extent: &Extent<T>) -> bool {
        let Extent { low, high, total, .. } = extent;
        let farthest = low.iter().chain(high).fold(T::ZERO, |most, x| most.max(x.abs()));
        let exponent = |x: T| normal_exponent::<T>(x.frexp().1);
        let (mass, length) = (exponent(*total) & !1, exponent(farthest));
        let noiseless = self.constants.noise == T::ZERO;
        let both;
        (self.constants, both) = self.constants.scaled(mass);
        let in_range = noiseless || self.constants.noise >= T::MIN_POSITIVE;
        let time = mass + 2 * length - both;
        // Within these bounds, which no collision that counts goes beyond, products with the step are in range.
        self.dt = self.dt.ldexp(-time).max(T::MIN_POSITIVE).min(T::MAX.ldexp(-16));
        self.units = Units { mass: T::ONE.ldexp(-mass), length: T::ONE.ldexp(-length), time };
        in_range
    }

    /// Whether no group at all can collide, by a bound: then no search is needed.
    ///
    /// Nothing attracts (every index is then N - 2 >= 0); or only hard collisions count and, with k = gamma chi / (4 mu~),
    /// `k m M < 1` for the largest mass m and the total mass M: for a group of N' of mass M' nu <= -1 needs
    /// `N' - 1 <= k (M'^2 - sum m_i^2) <= k M' (M' - M'/N')`, that is `N' <= k M'^2 <= k M N' m`.
    #[must_use]
    pub fn impossible(&self, largest: T, total: T) -> bool {
        let strength = self.constants.gamma * self.constants.chi;
        match self.merging {
            Merging::Never => true,
            _ if strength <= T::ZERO => true,
            Merging::All => false,
            // A margin for the rounding of the sum of the masses.
            Merging::Hard => strength * largest * total < T::from_f64(3.99) * self.constants.noise,
        }
    }

    /// Whether a group of `count` particles of total mass M may have an index below zero, by a bound that needs nothing else:
    /// `M^2 - sum m^2 < M^2`, so nu < 0 needs `4 mu~ (N - 2) < gamma chi M^2`.
    #[inline]
    #[must_use]
    pub fn possible(&self, count: u32, mass: T) -> bool {
        // A margin for the rounding of the sum of the masses.
        let most = T::from_f64(1.001) * (self.constants.gamma * self.constants.chi) * (mass * mass);
        T::from_usize(count.saturating_sub(2) as usize) * (T::from_i32(4) * self.constants.noise) <= most
    }

    /// Whether some three or more out of a set of particles may have an index below zero, by a bound: given are the set's mass and the
    /// largest mass h in it.
    ///
    /// N of them have a mass M of at most `min(N h, total)`, and nu < 0 needs `N - 2 < k M^2`, k = gamma chi / (4 mu~). Up to N = total / h
    /// the difference `k M^2 - (N - 2)` is convex in N and beyond it falls, so it is largest at N = 3 or at N = total / h.
    #[inline]
    #[must_use]
    pub fn grouped(&self, total: T, heaviest: T) -> bool {
        // A margin for the rounding of the sum of the masses.
        let pull = T::from_f64(1.001) * (self.constants.gamma * self.constants.chi);
        let push = T::from_i32(4) * self.constants.noise;
        let three = pull * (T::from_i32(9) * heaviest * heaviest) < push;
        let all = pull * (total * total) * heaviest < push * (total - T::TWO * heaviest);
        !(three && all)
    }

    /// A distance beyond which two particles with masses from `smallest` to `largest` don't collide with a probability that counts; `None` if
    /// such two never do.
    ///
    /// `Q(|nu|, x)` grows with `|nu| = gamma chi m m' / (2 mu~)`, and `x = m m' / (m + m') r^2 / (4 mu~ dt)` is at least what two of
    /// the smallest mass have.
    #[must_use]
    pub fn reach(&self, smallest: T, largest: T) -> Option<T> {
        if self.gaussian_step() {
            return Some(T::INFINITY);
        }
        let pull = T::from_f64(1.001) * (self.constants.gamma * self.constants.chi) * (largest * largest);
        let a = pull / (T::TWO * self.constants.noise);
        if !self.inelastic(-a) {
            return None;
        }
        let x = T::from_f64(1.01) * incomplete_gamma::upper_inverse(a, self.probability);
        let reach = (x * T::from_i32(8) * self.constants.noise * self.dt / smallest).sqrt();
        Some(if reach.is_nan() { T::INFINITY } else { reach })
    }

    /// Whether no group of so many particles, of this mass and with at least this second moment, may collide within the step: by the largest
    /// pull that a group of that mass can have.
    #[must_use]
    pub fn excludes(&self, count: u32, mass: T, moment: T) -> bool {
        // A single Gaussian step with noise may reach zero from a large Y and not from a smaller one.
        if self.gaussian_step() && self.constants.noise > T::ZERO {
            return false;
        }
        let count = T::from_usize(count as usize);
        let pairs = T::from_f64(1.001) * (mass * mass) * (T::ONE - T::ONE / count);
        !self.collidable(&Group { count, mass, pairs }, moment)
    }

    /// Whether a collision at this index merges.
    #[inline]
    fn inelastic(&self, index: T) -> bool {
        match self.merging {
            Merging::All => index < T::ZERO,
            Merging::Hard => index <= -T::ONE,
            Merging::Never => false,
        }
    }

    /// Whether the group with second moment Y may collide within the step, with a probability that counts.
    #[inline]
    #[must_use]
    pub fn collidable(&self, group: &Group<T>, moment: T) -> bool {
        let index = self.constants.index(group);
        if !self.inelastic(index) {
            return false;
        }
        if self.gaussian_step() {
            return self.increment(group, moment, self.quantile) < T::ZERO;
        }
        // Y / (2 beta^2 dt)
        let x = moment * group.mass / (T::from_i32(4) * self.constants.noise * self.dt);
        let a = -index;
        !negligible(a, x, self.probability) && incomplete_gamma::upper(a, x) > self.probability
    }

    /// Whether the second moment takes one gaussian_step step: by the printed law and without noise.
    fn gaussian_step(&self) -> bool {
        (build::PRINTED_LAW && self.law == CollisionLaw::Printed)
            || (build::NOISELESS && self.constants.noise == T::ZERO)
    }

    /// Y + alpha dt + 2 beta sqrt(Y dt) z: one Gaussian step of the second moment (3.2), (3.11).
    fn increment(&self, group: &Group<T>, moment: T, z: T) -> T {
        let spread = if self.constants.noise == T::ZERO {
            T::ZERO
        } else {
            T::TWO * (self.constants.beta_squared(group) * moment * self.dt).sqrt() * z
        };
        moment + self.constants.alpha(group) * self.dt + spread
    }

    /// When, as a time in (0, dt], the group merges if its increment is `z sqrt(dt)`; `None` if it doesn't.
    #[must_use]
    pub fn time(&self, group: &Group<T>, moment: T, z: T) -> Option<T> {
        let clamp = |tau: T| if tau < self.dt { tau.max(T::ZERO) } else { self.dt };
        if moment <= T::ZERO {
            return Some(T::ZERO);
        }
        if self.gaussian_step() {
            let after = self.increment(group, moment, z);
            // The straight line from Y to Y + dY.
            return (after <= T::ZERO).then(|| clamp(self.dt * (moment / (moment - after))));
        }
        let a = -self.constants.index(group);
        let scale = group.mass / (T::from_i32(4) * self.constants.noise);
        let u = normal::distribution(z);
        if u >= incomplete_gamma::upper(a, moment * scale / self.dt) {
            return None;
        }
        Some(clamp(moment * scale / incomplete_gamma::upper_inverse(a, u)))
    }
}

/// A bound without special functions: `true` only if Q(a, x) <= p.
///
/// For a <= 1, Gamma(1 + a) >= 0.88, so with t^a <= max(1, t): x >= 1: Q <= 1.14 a e^{-x} <= 1.14 a / (1 + x + x^2/2 + x^3/6);
/// x < 1: Q <= 1.14 a (-log x + 1/e), and -log x <= (1 - e) log 2 if x >= 2^{e - 1}.
#[inline]
fn negligible<T: Real>(a: T, x: T, p: T) -> bool {
    if a > T::ONE || x <= T::ZERO {
        return false;
    }
    let c = T::from_f64;
    let prefactor = c(1.14) * a;
    if x >= T::ONE {
        prefactor < p * (T::ONE + x * (T::ONE + x * (T::HALF + x * c(1.0 / 6.0))))
    } else {
        prefactor * (T::from_i32(1 - x.frexp().1) * c(core::f64::consts::LN_2) + c(0.37)) < p
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pks::testing::Uniform;
    use std::vec::Vec;

    #[test]
    fn the_bound_is_a_bound() {
        for a in [1e-9, 1e-6, 1e-4, 1e-3, 0.01, 0.3, 0.9, 1.0] {
            for k in -400..60 {
                let x = 10.0_f64.powf(f64::from(k) * 0.05);
                let q = incomplete_gamma::upper(a, x);
                for p in [1e-12, 1e-6, 1e-4, 1e-2, 0.3] {
                    assert!(!negligible(a, x, p) || q <= p, "{a} {x} {p} {q}");
                }
            }
        }
        // And it does cut: a light pair a tenth of the step's length apart.
        assert!(negligible(3e-4, 3.0, 1e-4) && negligible(1e-5, 0.1, 1e-4));
    }

    #[test]
    fn what_is_excluded_cannot_collide() {
        let mut numbers = Uniform(5);
        let mut uniform = || numbers.next();
        let (mut grouped, mut near, mut excluded) = ([0; 2], [0; 3], [0; 2]);
        for round in 0..20_000 {
            let n = 2 + (uniform() * 12.0) as usize;
            let spread = [0.0, 1.0, 3.0][round % 3];
            let masses: Vec<f64> = (0..n).map(|_| 10_f64.powf(spread * uniform())).collect();
            let (total, heaviest) = masses.iter().fold((0.0_f64, 0.0_f64), |(sum, h), &m| (sum + m, h.max(m)));
            let smallest = masses.iter().copied().fold(f64::INFINITY, f64::min);
            let constants =
                Constants { chi: 1.0, noise: heaviest * heaviest * 10_f64.powf(3.0 * uniform() - 1.0), gamma: 1.0 };
            let law = [CollisionLaw::Exact, CollisionLaw::Printed][round % 2];
            let merging = [Merging::All, Merging::Hard][round / 2 % 2];
            let dt = 10_f64.powf(-2.0 * uniform());
            let criterion = Criterion::new(constants, law, merging, 1e-3, dt);
            // Every group of at least three.
            let any = (0..1_u32 << n).any(|set| {
                let members: Vec<f64> = (0..n).filter(|i| set >> i & 1 == 1).map(|i| masses[i]).collect();
                set.count_ones() > 2 && constants.index(&Group::of(&members)) < 0.0
            });
            assert!(criterion.grouped(total, heaviest) || !any, "{masses:?} {constants:?}");
            grouped[usize::from(criterion.grouped(total, heaviest))] += 1;
            // A pair.
            let pair = Group::of(&masses[..2]);
            let reduced = masses[0] * masses[1] / (pair.mass * pair.mass);
            let distance = 10_f64.powf(4.0 * uniform() - 3.0);
            let reach = criterion.reach(smallest, heaviest);
            if reach.is_none_or(|reach| distance > reach) {
                assert!(
                    !criterion.collidable(&pair, reduced * distance * distance),
                    "{criterion:?} {masses:?} {distance}"
                );
                near[usize::from(reach.is_some())] += 1;
            } else {
                near[2] += 1;
            }
            // All of them, farther apart than told.
            let moment = 10_f64.powf(4.0 * uniform() - 3.0);
            if criterion.excludes(n as u32, total, moment) {
                assert!(!criterion.collidable(&Group::of(&masses), moment * (1.0 + uniform())));
                excluded[1] += 1;
            } else {
                excluded[0] += 1;
            }
        }
        assert!(grouped.iter().chain(&near).chain(&excluded).all(|&n| n > 300), "{grouped:?} {near:?} {excluded:?}");
    }

    #[test]
    fn times_follow_the_law() {
        // P(tau <= s) = Q(|nu|, Y / (2 beta^2 s)) for every s in the step, by construction: check the inversion end to end.
        let group = Group::of(&[1.0, 1.0]);
        for nu in [-0.5, -1.5, -4.0] {
            // nu = -gamma chi 2 / (4 mu~), mu~ = 1
            let constants = Constants { chi: -2.0 * nu, noise: 1.0, gamma: 1.0 };
            assert_eq!(constants.index(&group), nu);
            let criterion = Criterion::new(constants, CollisionLaw::Exact, Merging::All, 1e-12, 0.5);
            let moment = 0.3;
            let bound = incomplete_gamma::upper(-nu, moment / (2.0 * constants.beta_squared(&group) * 0.5));
            for k in 1..40 {
                let u = bound * f64::from(k) / 40.0;
                let tau: f64 = criterion.time(&group, moment, normal::quantile(u)).unwrap();
                let back = incomplete_gamma::upper(-nu, moment / (2.0 * constants.beta_squared(&group) * tau));
                assert!((back / u - 1.0).abs() < 1e-11 && tau <= 0.5);
            }
            assert_eq!(criterion.time(&group, moment, normal::quantile(bound + 0.01 * (1.0 - bound))), None);
            assert!(criterion.collidable(&group, moment));
        }
    }

    #[test]
    fn without_noise_the_moment_falls_in_a_straight_line() {
        let constants = Constants { chi: 3.0, noise: 0.0, gamma: 1.0 };
        let group = Group::of(&[1.0, 2.0]);
        let criterion = Criterion::new(constants, CollisionLaw::Exact, Merging::All, 1e-4, 0.5);
        // alpha = -gamma chi 4 / 3 = -4
        assert!(criterion.collidable(&group, 1.9) && !criterion.collidable(&group, 2.1));
        assert_eq!(criterion.time(&group, 1.0, 7.0), Some(0.25));
        assert_eq!(criterion.time(&group, 2.1, 7.0), None);
    }

    #[test]
    fn hard_collisions_are_impossible_below_critical_mass() {
        let (n, mass) = (1000, 20.0);
        let constants = Constants::new(1.0, super::super::theory::noise(mass, 1.0, n));
        let hard = Criterion::new(constants, CollisionLaw::Exact, Merging::Hard, 1e-4, 0.1);
        assert!(hard.impossible(mass / n as f64, mass));
        let soft = Criterion { merging: Merging::All, ..hard };
        assert!(!soft.impossible(mass / n as f64, mass));
        let supercritical =
            Criterion { constants: Constants::new(1.0, super::super::theory::noise(30.0, 1.0, n)), ..hard };
        assert!(!supercritical.impossible(30.0 / n as f64, 30.0));
        let repulsive = Criterion { constants: Constants::new(-1.0, 1.0), ..soft };
        assert!(repulsive.impossible(1.0, 1.0));
    }
}

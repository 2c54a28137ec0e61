//! What the theory predicts: critical mass, indices, rates of the second moment.
//!
//! Throughout, V is `gamma log |x - y|` near the diagonal: gamma = 1 / (2 pi) for the logarithmic and the screened potential of
//! Zhelezov & Fatkullin (1.4), which [`GAMMA`] stands for. Units: masses in mass, `mu` in length^2 / time, `chi` in
//! length^2 / (time mass), `noise` (the paper's mu with a tilde) in mass length^2 / time.

use crate::build;
use crate::real::{Real, quotient};

/// The strength of the logarithm in V of (1.4a) and (1.4b): 1 / (2 pi).
pub const GAMMA: f64 = 0.5 * core::f64::consts::FRAC_1_PI;

/// The critical mass `8 pi mu / chi`: above it a solution blows up in finite time (1.6), below it never does (1.7). Infinite for chi = 0.
#[must_use]
pub fn critical_mass<T: Real>(mu: T, chi: T) -> T {
    // Not `/`: the compiler may divide before it chooses, and a division by zero may be trapped.
    if chi == T::ZERO { T::INFINITY } else { quotient(T::from_i32(8) * T::PI * mu, chi) }
}

/// The bound `T < 2 pi F(0) / ((chi M - 8 pi mu) M)` on the time of blow-up (1.8); infinite for a subcritical mass.
///
/// `second_moment` is F(0), the integral of |x|^2 rho about the centre of mass (not divided by M).
#[must_use]
pub fn blow_up_bound<T: Real>(mass: T, mu: T, chi: T, second_moment: T) -> T {
    let excess = chi * mass - T::from_i32(8) * T::PI * mu;
    if excess <= T::ZERO {
        return T::INFINITY;
    }
    let ((f, a), (x, b), (m, c)) = (second_moment.frexp(), excess.frexp(), mass.frexp());
    // Not `/`, as above.
    quotient(T::TWO * T::PI * f, x * m).ldexp(a - b - c)
}

/// Number, mass and sum of squared masses of a group of particles: all that its index depends on.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Group<T> {
    /// Number of particles.
    pub count: T,
    /// Sum of the masses.
    pub mass: T,
    /// `sum_{i != j} m_i m_j = M^2 - sum m_i^2`, kept as such because the difference would cancel for one heavy particle.
    pub pairs: T,
}

impl<T: Real> Group<T> {
    /// The group of these masses.
    #[must_use]
    pub fn of(masses: &[T]) -> Self {
        masses.iter().fold(Self::default(), |group, &mass| group.with(Self { count: T::ONE, mass, pairs: T::ZERO }))
    }

    /// What is divided by the mass is 0 without any.
    #[inline]
    fn divisor(&self) -> T {
        if self.mass == T::ZERO { T::INFINITY } else { self.mass }
    }

    /// The union with another group.
    #[inline]
    #[must_use]
    pub fn with(self, other: Self) -> Self {
        Self {
            count: self.count + other.count,
            mass: self.mass + other.mass,
            pairs: self.pairs + other.pairs + T::TWO * self.mass * other.mass,
        }
    }
}

/// The constants that an index depends on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Constants<T> {
    /// chi, the chemosensitivity.
    pub chi: T,
    /// mu with a tilde of (1.3): a particle of mass m diffuses with `mu~ / m`.
    pub noise: T,
    /// gamma: V is `gamma log r` at small distance.
    pub gamma: T,
}

impl<T: Real> Constants<T> {
    /// The law of the logarithmic or the screened potential.
    #[must_use]
    pub fn new(chi: T, noise: T) -> Self {
        Self { chi, noise, gamma: T::from_f64(GAMMA) }
    }

    /// The index nu of the squared Bessel process that a group's second moment follows, (2.7), in general (4.30):
    /// `N - 2 - gamma chi (M^2 - sum m^2) / (4 mu~)`. A group may collide if nu < 0, and must if nu <= -1.
    ///
    /// Without noise: -inf if the group attracts itself, +inf if it repels itself, else N - 2 (nothing makes it move).
    #[inline]
    #[must_use]
    pub fn index(&self, group: &Group<T>) -> T {
        let pull = self.gamma * self.chi * group.pairs;
        if pull == T::ZERO {
            return group.count - T::TWO;
        }
        if build::NOISELESS && self.noise == T::ZERO {
            return (-T::INFINITY).copysign(-pull);
        }
        group.count - T::TWO - quotient(pull, T::from_i32(4) * self.noise)
    }

    /// nu of (2.7), alpha and beta^2 of (2.4) of particles of these masses; alpha and beta^2 are 0 without any mass. All is computed with masses and
    /// constants in units by which products stay in range.
    #[must_use]
    pub fn rates(&self, masses: &[T]) -> [T; 3] {
        // The largest products are those with the heaviest, and of these the one with the next.
        let [mut first, mut second] = [T::ZERO; 2];
        for m in masses.iter().map(|m| m.abs()) {
            second = second.max(first.min(m));
            first = first.max(m);
        }
        let second = if second > T::ZERO { second } else { first };
        let mass = (first.frexp().1 + second.frexp().1) >> 1;
        let group = |m: &T| Group { count: T::ONE, mass: m.ldexp(-mass), pairs: T::ZERO };
        let group = masses.iter().map(group).fold(Group::default(), Group::with);
        let (law, both) = self.scaled(mass);
        let (noise, power) = self.noise.frexp();
        let beta_squared = Self { noise, ..law }.beta_squared(&group).ldexp(power - mass);
        [law.index(&group), law.alpha(&group).ldexp(both - mass), beta_squared]
    }

    /// The law for masses that are multiplied by 2 to minus `mass`, the larger one of `gamma chi` and mu~ being near 1; chi and mu~ are then multiplied
    /// by 2 to minus the second, beside that.
    #[must_use]
    pub(super) fn scaled(&self, mass: i32) -> (Self, i32) {
        let Self { chi, noise, gamma } = *self;
        let ((fraction, power), (_, noisy)) = (gamma.frexp(), noise.frexp());
        let pull = power + 2 * mass;
        let both = chi.frexp().1 + pull;
        let none = chi == T::ZERO || gamma == T::ZERO;
        let both = if noise == T::ZERO { both } else { noisy.max(if none { noisy } else { both }) };
        (Self { chi: chi.ldexp(pull - both), noise: noise.ldexp(-both), gamma: fraction }, both)
    }

    /// alpha of (2.4): the drift of the second moment Y of (2.2).
    #[must_use]
    pub fn alpha(&self, group: &Group<T>) -> T {
        (T::from_i32(4) * self.noise * (group.count - T::ONE) - self.gamma * self.chi * group.pairs) / group.divisor()
    }

    /// beta of (2.4), squared: `2 mu~ / M`.
    #[inline]
    #[must_use]
    pub fn beta_squared(&self, group: &Group<T>) -> T {
        T::TWO * self.noise / group.divisor()
    }
}

/// The rate of change of the normalised second moment `(1/M) int |x|^2 rho`, with heavy point masses beside the regular part (4.12):
/// `4 mu Mreg / M - chi M / (2 pi) (1 - sum (M_i / M)^2)`; 0 without mass.
#[must_use]
pub fn second_moment_rate<T: Real>(mass: T, mu: T, chi: T, heavy: &[T]) -> T {
    // In a unit of mass in which products are in range.
    let (whole, exponent) = mass.frexp();
    let divisor = if whole == T::ZERO { T::INFINITY } else { whole };
    let (points, squares) = heavy.iter().map(|m| m.ldexp(-exponent)).fold((T::ZERO, T::ZERO), |(sum, squares), m| {
        let share = m / divisor;
        (sum + m, squares + share * share)
    });
    T::from_i32(4) * mu * (whole - points) / divisor - chi * mass / (T::TWO * T::PI) * (T::ONE - squares)
}

/// One species of the multi-species model (4.24).
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct Species<T> {
    /// Total mass of the species.
    pub mass: T,
    /// Its diffusivity mu_i.
    pub mu: T,
    /// Its sensitivity chi_i in units of chi: it drifts by `chi_i chi` times the attraction. 0 stands for 1.
    pub sensitivity: T,
}

impl<T: Real> Species<T> {
    /// A species of sensitivity 1.
    #[must_use]
    pub fn new(mass: T, mu: T) -> Self {
        Self { mass, mu, sensitivity: T::ONE }
    }

    /// Its diffusivity over its sensitivity.
    fn mobility(&self) -> T {
        if self.sensitivity == T::ZERO { self.mu } else { self.mu / self.sensitivity }
    }
}

/// The rate of change of the second moment `int |x|^2 sum rho_i / chi_i` (not divided by M) of many species (4.28):
/// `sum (4 mu_i / chi_i - chi M / (2 pi)) M_i`.
///
/// The paper says of the moment without weights that (4.28) remains valid for different chi_i. It does not: forces that are not mutual then move the centre, and the rate depends on the origin
/// and on where the masses are. With the weight `1 / chi_i` a pair's force is mutual again. For equal sensitivities both are the same.
#[must_use]
pub fn second_moment_rate_of_species<T: Real>(species: &[Species<T>], chi: T) -> T {
    let mass = species.iter().fold(T::ZERO, |sum, s| sum + s.mass);
    let rate = |s: &Species<T>| (T::from_i32(4) * s.mobility() - chi * mass / (T::TWO * T::PI)) * s.mass;
    species.iter().fold(T::ZERO, |sum, s| sum + rate(s))
}

/// The auxiliary diffusivity of many species: `mu = sum M_i mu_i / (M chi_i)`.
///
/// From (4.25), `mu_i = M eta_i chi_i mu / M_i`, with shares eta_i that add up to one. (The print of (5.3) and (5.4), for chi_i = 1, has the masses
/// upside down; its own numbers (5.8), mu = 5 and shares 1/2, are those of (4.25).)
#[must_use]
pub fn species_mu<T: Real>(species: &[Species<T>]) -> T {
    let exponent = unit_of_species(species);
    let (mass, weighted) = species.iter().fold((T::ZERO, T::ZERO), |(mass, sum), s| {
        let m = s.mass.ldexp(-exponent);
        (mass + m, sum + m * s.mobility())
    });
    weighted / mass
}

/// The share eta_i of the particles that the species gets: `M_i mu_i / (M chi_i mu)`, [`species_mu`] being mu. Its particles have equal masses `M_i / (eta_i N)`
/// and the [weights](super::State::weights) `M_i / (eta_i N chi_i)`.
#[must_use]
pub fn species_share<T: Real>(species: &[Species<T>], one: &Species<T>) -> T {
    let exponent = unit_of_species(species);
    let weight = |s: &Species<T>| s.mass.ldexp(-exponent) * s.mobility();
    let weighted = species.iter().fold(T::ZERO, |sum, s| sum + weight(s));
    weight(one) / weighted
}

/// The exponent of the power of two that masses are divided by so that their products with diffusivities stay in range.
fn unit_of_species<T: Real>(species: &[Species<T>]) -> i32 {
    species.iter().fold(T::ZERO, |largest, s| largest.max(s.mass)).frexp().1
}

/// `mu~ = mu M / N` (4.6), (5.5) of a system of `particles` particles.
#[must_use]
pub fn noise<T: Real>(mass: T, mu: T, particles: usize) -> T {
    let (fraction, exponent) = mass.frexp();
    (mu * fraction / T::from_usize(particles)).ldexp(exponent)
}

/// The point (M1, M2) with the largest M2 on the curve where the second moment of two species neither grows nor shrinks, (5.6):
/// `2 pi (mu_1 - 2 mu_2) mu_1 / (chi (mu_1 - mu_2))` and `2 pi mu_1^2 / (chi (mu_1 - mu_2))`. It needs mu_1 > 2 mu_2.
#[must_use]
pub fn largest_masses<T: Real>(mu: [T; 2], chi: T) -> [T; 2] {
    let [first, second] = mu;
    let factor = T::TWO * T::PI * first / (chi * (first - second));
    [factor * (first - T::TWO * second), factor * first]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pks::testing::Uniform;
    use crate::real::Scalar;

    #[test]
    fn numbers_of_the_paper() {
        // (5.7), (5.8).
        let species = [Species::new(4.0, 17.5), Species::new(24.0, 35.0 / 12.0)];
        assert!((species_mu(&species) - 5.0).abs() < 1e-14);
        assert!(species.iter().all(|s| (species_share(&species, s) - 0.5).abs() < 1e-15));
        // Section 5.2.1: slopes -20 and -12.
        let mass = 48.0 * core::f64::consts::PI;
        assert!((second_moment_rate(mass, 1.0, 1.0, &[]) + 20.0).abs() < 1e-13);
        assert!((second_moment_rate(mass, 1.0, 1.0, &[mass * 2.0 / 3.0]) + 12.0).abs() < 1e-13);
        // Section 5.2.2 in units of 8 pi (critical mass for chi = mu = 1).
        let critical = critical_mass(1.0, 1.0);
        let slope = second_moment_rate(8.0 * critical, 1.0, 1.0, &[2.4 * critical, 5.6 * critical]);
        assert!((slope + 13.44).abs() < 1e-13);
        // One species: F' of (4.28) is M times (4.12).
        let one = [Species::new(mass, 1.0)];
        assert!((second_moment_rate_of_species(&one, 1.0) + 20.0 * mass).abs() < 1e-10);
        // On the curve the rate is zero, and largest in M2.
        let [first, second] = largest_masses([10.0, 1.0], 100.0);
        let rate = |first: f64, second: f64| {
            second_moment_rate_of_species(&[Species::new(first, 10.0), Species::new(second, 1.0)], 100.0)
        };
        assert!(rate(first, second).abs() < 1e-13);
        assert!(rate(first * 1.01, second) < 0.0 && rate(first * 0.99, second) < 0.0);
        // (1.8): F(0) / |F'| for the moment's line.
        let bound: f64 = blow_up_bound(mass, 1.0, 1.0, 7.0);
        assert!((bound - 7.0 / (20.0 * mass)).abs() < 1e-15);
        assert_eq!(blow_up_bound(1.0, 1.0, 1.0, 7.0), f64::INFINITY);
    }

    #[test]
    fn blow_up_and_total_collision_agree() {
        // (4.9): nu = (N - 1)(1 - chi M / (8 pi mu)) - 1.
        for (mass, n) in [(10.0, 1000), (30.0, 1000), (8.0 * core::f64::consts::PI, 7)] {
            let masses = std::vec![mass / n as f64; n];
            let law = Constants::new(1.0, noise(mass, 1.0, n));
            let want = (n as f64 - 1.0) * (1.0 - mass / critical_mass(1.0, 1.0)) - 1.0;
            // N additions of the running sums.
            assert!((law.index(&Group::of(&masses)) - want).abs() < 1e-12 * n as f64);
        }
    }

    #[test]
    fn indices_subtract() {
        // (2.9): merging a cluster changes the whole system's index by -(nu + 1), to rounding.
        let mut numbers = Uniform(1);
        let mut random = || numbers.next();
        for trial in 0..200 {
            let n = 3 + (random() * 60.0) as usize;
            let k = 2 + (random() * (n - 2) as f64) as usize;
            let heavy = 10_f64.powf(6.0 * random());
            let masses: std::vec::Vec<f64> = (0..n).map(|i| if i == 0 { heavy } else { 0.1 + random() }).collect();
            let law = Constants::new(10.0_f64.powf(4.0 * random() - 2.0), 1.0);
            let cluster = law.index(&Group::of(&masses[..k]));
            let merged: std::vec::Vec<f64> =
                core::iter::once(masses[..k].iter().sum()).chain(masses[k..].iter().copied()).collect();
            let (before, after) = (law.index(&Group::of(&masses)), law.index(&Group::of(&merged)));
            // Rounding of the index itself: 3 n additions of terms of one sign.
            let scale = before.abs().max(after.abs()).max(n as f64);
            let error = after - before + (cluster + 1.0);
            assert!(error.abs() <= 3.0 * n as f64 * f64::EPSILON * scale, "{trial}: {error:e} {scale:e}");
        }
    }

    #[test]
    fn alpha_beta_and_the_index_agree() {
        // nu = alpha / (2 beta^2) - 1.
        let law = Constants::new(3.0, 0.7);
        let group = Group::of(&[1.0, 2.5, 0.3]);
        let nu: f64 = law.alpha(&group) / (2.0 * law.beta_squared(&group)) - 1.0;
        assert!((nu - law.index(&group)).abs() < 1e-13);
        assert_eq!(Constants::new(1.0, 0.0).index(&group), f64::NEG_INFINITY);
        assert_eq!(Constants::new(-1.0, 0.0).index(&group), f64::INFINITY);
        assert_eq!(Constants::new(0.0, 0.0).index(&group), 1.0);
        assert_eq!(critical_mass(1.0, 0.0), f64::INFINITY);
        assert_eq!(blow_up_bound(1.0, 1.0, 0.0, 1.0), f64::INFINITY);
    }
}

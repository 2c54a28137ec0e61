//! Particles of different sensitivities (Zhelezov & Fatkullin, Section 4.5).
//!
//! `dX_i = -chi chi_i grad sum_{j != i} m_j V(X_i - X_j) dt + sqrt(2 mu~ / w_i) dW_i` with weights `w_i = m_i / chi_i`: the force `-chi m_i m_j grad V` of a pair acts both ways, and `1 / w_i`
//! is the mobility. So the centre of the weights feels no force, and with W their sum `Y = sum w_i |X_i - c|^2 / W` follows
//!
//! `dY = (4 mu~ (N - 1) - chi gamma sum_{i != j} m_i m_j) / W dt + 2 sqrt(2 mu~ Y / W) dW~`,
//!
//! a squared Bessel process of index `N - 2 - chi gamma sum_{i != j} m_i m_j / (4 mu~)`: the index knows masses alone, beta^2 and Y know weights alone. Clusters are therefore searched for, and decided,
//! by weights, with the largest sensitivity c for all particles, `c w_i >= m_i`, which bounds what attracts from above; the sum over pairs of masses is computed for clusters that
//! this bound lets pass ([`Charges`]).

use super::theory::Group;
use crate::error::{Error, Result};
use crate::real::Real;

/// What attracts in clusters that are found by weights.
#[derive(Clone, Copy, Debug)]
pub struct Charges<'a, T> {
    /// The masses.
    masses: &'a [T],
    /// The largest sensitivity.
    largest: T,
}

impl<'a, T: Real> Charges<'a, T> {
    /// The charges of particles whose sensitivities differ, and the largest sensitivity. With equal ones masses are proportional to weights, which then say all.
    ///
    /// # Errors
    /// [`Error::OutOfDomain`]: a sensitivity is out of the range of normal numbers.
    pub fn of(masses: &'a [T], weights: &[T]) -> Result<(Option<Self>, T)> {
        let sensitivities = masses.iter().zip(weights).map(|(&m, &w)| m / w);
        let none = (T::INFINITY, T::ZERO);
        let (least, largest) = sensitivities.fold(none, |(least, most), s| (least.min(s), most.max(s)));
        if masses.is_empty() {
            return Ok((None, T::ONE));
        }
        if !(least >= T::MIN_POSITIVE && largest.is_finite()) {
            return Err(Error::OutOfDomain);
        }
        Ok(((least < largest).then_some(Self { masses, largest }), largest))
    }

    /// `sum_{i != j} m_i m_j` over these particles, for masses that are divided by the largest sensitivity and multiplied by `unit`.
    pub fn pairs(&self, members: impl Iterator<Item = usize>, unit: T) -> T {
        // Of pieces, so that the sum has few roundings.
        const TOGETHER: usize = 64;
        let (mut all, mut some, mut left) = (Group::default(), Group::default(), TOGETHER);
        for i in members {
            let mass = self.masses.get(i).map_or(T::ZERO, |&m| m / self.largest * unit);
            some = some.with(Group { count: T::ONE, mass, pairs: T::ZERO });
            left -= 1;
            if left == 0 {
                (all, some, left) = (all.with(some), Group::default(), TOGETHER);
            }
        }
        all.with(some).pairs
    }
}

/// Multiplies each slope by the sensitivity of its particle.
pub fn respond<T: Real>(slopes: &mut [[T; 2]], masses: &[T], weights: &[T]) {
    for ([x, y], (&m, &w)) in slopes.iter_mut().zip(masses.iter().zip(weights)) {
        let sensitivity = m / w;
        (*x, *y) = (*x * sensitivity, *y * sensitivity);
    }
}

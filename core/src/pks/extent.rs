//! What one pass over the particles tells: whether they may be stepped, their box, their masses.

use crate::error::{Error, Result};
use crate::isa::{Level, Plain, widest};
use crate::real::Real;

/// Numbers that are looked at side by side: even, so that each belongs to one axis.
const LANES: usize = if cfg!(feature = "small") { 2 } else { 16 };

/// Bounds of the particles' positions and masses.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extent<T> {
    /// The lower corner of their bounding box.
    pub low: [T; 2],
    /// The upper corner.
    pub high: [T; 2],
    /// The smallest mass.
    pub smallest: T,
    /// The largest mass.
    pub largest: T,
    /// The sum of the masses, as rounded by some order of summation.
    pub total: T,
}

impl<T: Real> Extent<T> {
    /// The extent of these particles; without any, the box is empty and the masses are zero.
    ///
    /// # Errors
    /// [`Error::NotFinite`]: a number or the sum of the masses; [`Error::Mass`]: one is not positive.
    #[cfg_attr(feature = "small", inline(never))]
    pub fn of(positions: &[[T; 2]], masses: &[T]) -> Result<Self> {
        let places = widest(Level::best(), Look { numbers: positions.as_flattened(), sum: false });
        let weights = widest(Level::best(), Look { numbers: masses, sum: true });
        let (mut low, mut high) = ([T::INFINITY; 2], [-T::INFINITY; 2]);
        for (l, h) in places.low.as_chunks::<2>().0.iter().zip(places.high.as_chunks::<2>().0) {
            low = [low[0].min(l[0]), low[1].min(l[1])];
            high = [high[0].max(h[0]), high[1].max(h[1])];
        }
        let smallest = weights.low.iter().fold(T::INFINITY, |a, &b| a.min(b));
        let largest = weights.high.iter().fold(T::ZERO, |a, &b| a.max(b));
        let total = weights.sum.iter().fold(T::ZERO, |a, &b| a + b);
        let fine = |poison: [T; LANES]| poison.iter().all(|&p| p == T::ZERO);
        if !(fine(places.poison) && fine(weights.poison) && total.is_finite()) {
            return Err(Error::NotFinite);
        }
        if smallest <= T::ZERO { Err(Error::Mass) } else { Ok(Self { low, high, smallest, largest, total }) }
    }
}

/// Lanes of running bounds.
struct Bounds<T> {
    low: [T; LANES],
    high: [T; LANES],
    /// Zero times each number: NaN once one is not finite.
    poison: [T; LANES],
    sum: [T; LANES],
}

struct Look<'a, T> {
    numbers: &'a [T],
    sum: bool,
}

impl<T: Real> Plain for Look<'_, T> {
    type Out = Bounds<T>;

    #[inline(always)]
    fn run(self) -> Bounds<T> {
        let mut bounds = Bounds {
            low: [T::INFINITY; LANES],
            high: [-T::INFINITY; LANES],
            poison: [T::ZERO; LANES],
            sum: [T::ZERO; LANES],
        };
        let (whole, rest) = self.numbers.as_chunks::<LANES>();
        for chunk in whole {
            bounds.add(chunk, self.sum);
        }
        bounds.add(rest, self.sum);
        bounds
    }
}

impl<T: Real> Bounds<T> {
    /// Adds at most so many numbers as there are lanes.
    #[inline(always)]
    fn add(&mut self, numbers: &[T], sum: bool) {
        for ((&x, low), high) in numbers.iter().zip(&mut self.low).zip(&mut self.high) {
            *low = if x < *low { x } else { *low };
            *high = if x > *high { x } else { *high };
        }
        for (&x, poison) in numbers.iter().zip(&mut self.poison) {
            *poison += x * T::ZERO;
        }
        if sum {
            for (&x, sum) in numbers.iter().zip(&mut self.sum) {
                *sum += x;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec::Vec;

    #[test]
    fn bounds_and_refusals_at_every_size() {
        for n in 1..50_usize {
            let positions: Vec<[f64; 2]> = (0..n).map(|i| [(i * 7 % n) as f64, -((i * 3 % n) as f64)]).collect();
            let masses: Vec<f64> = (0..n).map(|i| 1.0 + (i * 5 % n) as f64).collect();
            let extent = Extent::of(&positions, &masses).unwrap();
            for k in 0..2 {
                let column = || positions.iter().map(|x| x[k]);
                assert_eq!(extent.low[k], column().fold(f64::INFINITY, f64::min));
                assert_eq!(extent.high[k], column().fold(-f64::INFINITY, f64::max));
            }
            assert_eq!(extent.smallest, masses.iter().copied().fold(f64::INFINITY, f64::min));
            assert_eq!(extent.largest, masses.iter().copied().fold(0.0, f64::max));
            assert_eq!(extent.total, masses.iter().sum::<f64>());
            for at in 0..n {
                for bad in [f64::NAN, f64::INFINITY, -f64::INFINITY] {
                    for k in 0..2 {
                        let mut positions = positions.clone();
                        positions[at][k] = bad;
                        assert_eq!(Extent::of(&positions, &masses), Err(Error::NotFinite));
                    }
                    let mut masses = masses.clone();
                    masses[at] = bad;
                    assert_eq!(Extent::of(&positions, &masses), Err(Error::NotFinite));
                }
                for bad in [0.0, -0.0, -1.0] {
                    let mut masses = masses.clone();
                    masses[at] = bad;
                    assert_eq!(Extent::of(&positions, &masses), Err(Error::Mass));
                }
            }
        }
        assert_eq!(Extent::of(&[[0.0_f64; 2]; 2], &[1e308; 2]), Err(Error::NotFinite));
        assert!(Extent::<f32>::of(&[], &[]).unwrap().total == 0.0);
    }
}

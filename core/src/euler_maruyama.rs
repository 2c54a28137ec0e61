//! Adaptive Euler-Maruyama sub-steps (Zhelezov & Fatkullin (3.4), (3.5)).
//!
//! `X(t + s) = X(t) + v s + sqrt(2 D s) N`, with s chosen so that the expected length of the jump is below a given width.

use crate::error::{Error, Result};
use crate::real::{Real, normal_exponent};

/// Parameters of the choice of sub-steps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Control<T> {
    /// The upper bound of the expected jump of a sub-step: the mesh width. Infinity for no bound.
    pub width: T,
    /// The minimum number of sub-steps per step; 0 counts as 1.
    pub at_least: u32,
    /// The maximum number of sub-steps per step. More give [`Error::TooManySubsteps`].
    pub at_most: u32,
}

impl<T: Real> Control<T> {
    /// The next sub-step, with `remaining` of the step `dt` left after `done` sub-steps, at speed |v| and diffusivity D.
    /// Returns `remaining` if one sub-step suffices.
    ///
    /// # Errors
    /// [`Error::TooManySubsteps`]: it would exceed the maximum number.
    #[inline]
    pub fn next(&self, dt: T, remaining: T, done: u32, speed: T, diffusivity: T) -> Result<T> {
        if done >= self.at_most {
            return Err(Error::TooManySubsteps);
        }
        let longest = largest(speed, diffusivity, self.width);
        let longest = if self.at_least > 1 { longest.min(dt / T::from_usize(self.at_least as usize)) } else { longest };
        // `remaining` has a rounding error of dt from each sub-step. A rest of that size is not a separate sub-step.
        if longest >= remaining - dt * T::EPSILON * T::from_usize(done as usize + 1) {
            return Ok(remaining);
        }
        // No progress: the sub-step is negligible relative to the step.
        if longest <= dt * T::EPSILON || longest.is_nan() {
            return Err(Error::TooManySubsteps);
        }
        Ok(longest)
    }
}

/// The longest s with `speed s + E|sqrt(2 D s) N| <= width`, N a standard normal of the plane: `E|N| = sqrt(pi / 2)`.
#[inline]
#[must_use]
pub fn largest<T: Real>(speed: T, diffusivity: T, width: T) -> T {
    if width == T::INFINITY {
        return width;
    }
    // In a unit of length, a power of two, in which squares are in range.
    let unit = T::ONE.ldexp(-normal_exponent::<T>(width.frexp().1));
    let (width, speed, diffusivity) = (width * unit, speed * unit, diffusivity * unit * unit);
    let noise = (T::PI * diffusivity).sqrt();
    // speed r^2 + noise r = width, r = sqrt(s), solved by the formula without cancellation.
    let root = noise + (noise * noise + T::from_i32(4) * speed * width).sqrt();
    if root == T::ZERO {
        return T::INFINITY;
    }
    let r = T::TWO * width / root;
    r * r
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_expected_jump_is_the_width() {
        for (speed, diffusivity) in [(0.0_f64, 1.0_f64), (1.0, 0.0), (3.0, 0.7), (1e6, 1e-3), (1e-6, 1e3)] {
            let s = largest(speed, diffusivity, 0.01);
            let jump = speed * s + (core::f64::consts::PI * diffusivity * s).sqrt();
            assert!((jump / 0.01 - 1.0).abs() < 1e-14);
        }
        assert_eq!(largest(0.0, 0.0, 1.0_f32), f32::INFINITY);
        assert_eq!(largest(3.0, 2.0, f64::INFINITY), f64::INFINITY);
    }

    #[test]
    fn the_least_number_is_exact_and_the_most_is_kept() {
        for (n, dt) in [1, 2, 3, 7, 64, 1000].into_iter().flat_map(|n| [0.3, 0.025, 1.0 / 3.0].map(|dt| (n, dt))) {
            let control = Control { width: f64::INFINITY, at_least: n, at_most: n };
            let (mut left, mut done) = (dt, 0);
            while left > 0.0 {
                let s = control.next(dt, left, done, 1.0, 1.0).unwrap();
                left -= s;
                done += 1;
            }
            assert_eq!(done, n);
            assert_eq!(control.next(dt, 0.1, done, 1.0, 1.0), Err(Error::TooManySubsteps));
        }
        let control = Control { width: 1e-30, at_least: 1, at_most: u32::MAX };
        assert_eq!(control.next(1.0, 1.0, 0, 1.0, 1.0), Err(Error::TooManySubsteps));
    }
}

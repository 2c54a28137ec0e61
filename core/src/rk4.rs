//! The classical Runge-Kutta method of fourth order with a fixed step, for a flat state in the caller's memory.
//!
//! The state is one slice of scalars with a layout chosen by the caller. The stepper uses three more
//! slices of that length ([`Scratch`]), laid out by [`Scratch::layout`]. A step either completes or leaves the state
//! unchanged: if a right-hand side fails or the new state is not finite, nothing is written to the state.
//!
//! Source: Kutta, *Beitrag zur naeherungsweisen Integration totaler Differentialgleichungen*, 1901; Hairer, Norsett,
//! Wanner, *Solving Ordinary Differential Equations I*, section II.1, table 1.2 (left).

use crate::checked::Present;
use crate::error::{Error, Result};
use crate::memory::Space;
use crate::real::Real;

/// The length of the method's interval of stability on the negative real axis. The real root of
/// 1 + z/2 + z^2/6 + z^3/24 = 0, which is R(z) = 1, is -2.785293563...
pub const REAL_STABILITY: f64 = 2.785_293_563;

/// Number of slices of the state's length in a [`Scratch`].
pub const SLICES: usize = 3;

/// The scratch memory of a step; undefined between steps.
#[derive(Debug)]
pub struct Scratch<'w, T> {
    /// The argument of the right-hand side, then the new state.
    stage: &'w mut [T],
    /// The right-hand side's value.
    slope: &'w mut [T],
    /// k1 + 2 k2 + 2 k3.
    sum: &'w mut [T],
}

impl<'w, T: Real> Scratch<'w, T> {
    /// Lays out the scratch of a state of `n` scalars: three arrays of that length.
    ///
    /// # Errors
    /// Those of [`Space::try_array`].
    pub fn layout(space: &mut impl Space<'w>, n: usize) -> Result<Self> {
        Ok(Self { stage: space.try_array(n)?, slope: space.try_array(n)?, sum: space.try_array(n)? })
    }

    /// A slice of the state's length, unused between steps.
    pub fn spare(&mut self) -> &mut [T] {
        self.slope
    }

    /// The scratch for a state of one third of the length of `memory`.
    #[must_use]
    pub fn split(memory: &'w mut [T]) -> Self {
        let n = memory.len() / SLICES;
        let (stage, rest) = memory.split_at_mut_checked(n).present_or_default();
        let (slope, rest) = rest.split_at_mut_checked(n).present_or_default();
        Self { stage, slope, sum: rest.get_mut(..n).present_or_default() }
    }
}

/// The evaluation requested from the right-hand side, one of four per step. The first is at the state itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// k1, at the state.
    First,
    /// k2, at half a step along k1.
    Second,
    /// k3, at half a step along k2.
    Third,
    /// k4, at a whole step along k3.
    Fourth,
}

/// Advances `state` by one step of length `dt`.
///
/// `slope_of(stage, y, dy)` overwrites `dy` with the right-hand side at `y`. It is called four times per step, in order. The step uses only
/// `+` and `*` in a fixed order, so equal right-hand sides give equal bits on every machine.
///
/// # Errors
/// [`Error::LengthMismatch`]: `scratch` was laid out for another length. [`Error::BecameNotFinite`]: the new state
/// would hold a value that is not finite. Any error of `slope_of`. In each case `state` is unchanged.
pub fn step<T: Real>(
    state: &mut [T],
    scratch: &mut Scratch<'_, T>,
    dt: T,
    mut slope_of: impl FnMut(Stage, &[T], &mut [T]) -> Result<()>,
) -> Result<()> {
    let Scratch { stage, slope, sum } = scratch;
    if stage.len() != state.len() || slope.len() != state.len() || sum.len() != state.len() {
        return Err(Error::LengthMismatch);
    }
    let half = dt * T::HALF;
    for (at, to_next) in [(Stage::First, half), (Stage::Second, half), (Stage::Third, dt)] {
        let first = at == Stage::First;
        slope_of(at, if first { state } else { stage }, slope)?;
        for (((y, to), &k), total) in state.iter().zip(stage.iter_mut()).zip(slope.iter()).zip(sum.iter_mut()) {
            *total = if first { k } else { *total + T::TWO * k };
            *to = *y + to_next * k;
        }
    }
    slope_of(Stage::Fourth, stage, slope)?;
    let sixth = dt / T::from_i32(6);
    let mut finite = true;
    for (((y, to), &k), &total) in state.iter().zip(stage.iter_mut()).zip(slope.iter()).zip(sum.iter()) {
        *to = *y + sixth * (total + k);
        finite &= to.is_finite();
    }
    if !finite {
        return Err(Error::BecameNotFinite);
    }
    for (y, &new) in state.iter_mut().zip(stage.iter()) {
        *y = new;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::memory::{ALIGN, Carve, Measure};
    use std::{vec, vec::Vec};

    fn with_scratch<T: Real, R>(n: usize, body: impl FnOnce(&mut Scratch<'_, T>) -> R) -> R {
        let bytes = Measure::of(|space| Scratch::<T>::layout(space, n).map(|_| ())).unwrap();
        let mut memory = vec![0xAA_u8; bytes + ALIGN];
        let start = memory.as_ptr().align_offset(ALIGN);
        body(&mut Scratch::layout(&mut Carve::new(&mut memory[start..start + bytes]).unwrap(), n).unwrap())
    }

    /// y' = lambda y is multiplied by R(z) = 1 + z + z^2/2 + z^3/6 + z^4/24 in each step, z = lambda dt.
    #[test]
    fn the_linear_problem_gives_the_stability_polynomial() {
        for lambda in [-2.0, -0.5, 0.25, 1.0] {
            let z: f64 = lambda * 0.5;
            let factor = 1.0 + z * (1.0 + z / 2.0 * (1.0 + z / 3.0 * (1.0 + z / 4.0)));
            with_scratch(3, |scratch| {
                let mut y = [1.0, -2.0, 0.125];
                let before = y;
                step(&mut y, scratch, 0.5, |_, y, dy| {
                    dy.iter_mut().zip(y).for_each(|(d, y)| *d = lambda * y);
                    Ok(())
                })
                .unwrap();
                for (y, b) in y.iter().zip(before) {
                    // About twenty roundings of values of size |b|.
                    assert!((y - factor * b).abs() <= 20.0 * f64::EPSILON * b.abs(), "{y} {}", factor * b);
                }
            });
        }
        let z = -REAL_STABILITY;
        assert!((1.0 + z / 2.0 + z * z / 6.0 + z * z * z / 24.0).abs() < 1e-9);
    }

    /// |R(z)| is at most 1 for |z| at most 2.615 and a real part of at most 0. (The largest such radius is 2.6156, at an angle of 122 degrees.)
    #[test]
    fn half_disc() {
        for (turn, part) in (0..=180).flat_map(|turn| (1..=20).map(move |part| (turn, part))) {
            let angle = core::f64::consts::FRAC_PI_2 * (1.0 + f64::from(turn) / 180.0);
            let r = 2.615 * f64::from(part) / 20.0;
            let z = [r * angle.cos().min(0.0), r * angle.sin()];
            let times = |[a, b]: [f64; 2]| [z[0] * a - z[1] * b, z[0] * b + z[1] * a];
            // Horner's rule.
            let factor = [4.0, 3.0, 2.0, 1.0].iter().fold([1.0, 0.0], |sum, k| {
                let [a, b] = times(sum);
                [1.0 + a / k, b / k]
            });
            assert!(factor[0].hypot(factor[1]) <= 1.0 + 1e-14, "{z:?}");
        }
    }

    #[test]
    fn a_failed_step_leaves_the_state() {
        let order = core::cell::RefCell::new(Vec::new());
        for fail_at in [Stage::First, Stage::Second, Stage::Third, Stage::Fourth] {
            with_scratch(2, |scratch| {
                let mut y = [1.0_f32, 2.0];
                let result = step(&mut y, scratch, 0.1, |stage, _, dy| {
                    order.borrow_mut().push(stage);
                    dy.fill(1.0);
                    if stage == fail_at { Err(Error::Stopped) } else { Ok(()) }
                });
                assert_eq!((result, y), (Err(Error::Stopped), [1.0, 2.0]));
                let result = step(&mut y, scratch, 0.1, |stage, _, dy| {
                    dy.fill(if stage == fail_at { f32::INFINITY } else { 1.0 });
                    Ok(())
                });
                assert_eq!((result, y), (Err(Error::BecameNotFinite), [1.0, 2.0]));
                assert_eq!(step(&mut [0.0_f32; 3], scratch, 0.1, |_, _, _| Ok(())), Err(Error::LengthMismatch));
            });
        }
        assert_eq!(order.borrow()[6..], [Stage::First, Stage::Second, Stage::Third, Stage::Fourth]);
        with_scratch(0, |scratch| assert_eq!(step(&mut [0.0_f64; 0], scratch, 0.1, |_, _, _| Ok(())), Ok(())));
    }

    /// The pendulum-like y'' = -sin y from rest: halving the step divides the error by 16 (+-1).
    #[test]
    fn fourth_order_on_a_nonlinear_problem() {
        let run = |steps: u32| {
            with_scratch(2, |scratch| {
                let mut y = [1.0_f64, 0.0];
                for _ in 0..steps {
                    step(&mut y, scratch, 2.0 / f64::from(steps), |_, y, dy| {
                        dy.copy_from_slice(&[y[1], -y[0].sin()]);
                        Ok(())
                    })
                    .unwrap();
                }
                y[0]
            })
        };
        // 4096 steps: truncation about (1/4096)^4, below rounding.
        let exact = run(4096);
        let errors: Vec<f64> = [32, 64, 128, 256].iter().map(|&n| (run(n) - exact).abs()).collect();
        for pair in errors.windows(2) {
            let ratio = pair[0] / pair[1];
            assert!((15.0..17.0).contains(&ratio), "{errors:?}");
        }
    }
}

//! Rotations about the y axis, which bring a step in the half plane of x and z into the z axis: Y_n(turned x) = D_n Y_n(x), for cosines and sines by themselves.
//!
//! D_n is made of Wigner's matrix d of 2 n, the N-th symmetric power of the rotation by half the angle,
//!
//! N d^N_kl = sqrt(k) (c sqrt(l) d^(N-1)_(k-1,l-1) + s sqrt(N - l) d^(N-1)_(k-1,l)) + sqrt(N - k) (c sqrt(N - l) d^(N-1)_(k,l) - s sqrt(l) d^(N-1)_(k,l-1)),
//!
//! c and s its cosine and sine (Risbo 1996), which is stable for all angles and orders.

use super::bands::place;
use super::{PART, exists, square_of, terms_of};
use crate::checked::Present;
use crate::error::Result;
use crate::field::tree::levels::{CLASSES, step_of};
use crate::memory::Space;
use crate::real::{Real, Scalar};

/// The angles of all classes of steps.
const ANGLES: usize = 32;
/// No angle: the step is along z.
const NONE: u8 = u8::MAX;

/// The matrices.
pub(super) struct Turns<'w, T> {
    /// Of each class its angle.
    angles: [u8; CLASSES],
    n_angles: usize,
    /// Of each angle a class that has it, the terms that one of its classes needs at most, and where its matrices begin.
    of_angle: [[u32; 3]; ANGLES],
    /// Of each angle the matrices of all n, then the same transposed.
    numbers: &'w mut [T],
    /// d of N and of N - 1.
    wigner: [&'w mut [f64]; 2],
    roots: &'w mut [f64],
}

/// A rotation of so many terms: the matrices of all n, in bands of rows ([`super::bands`]), and the same transposed.
pub(super) type Turn<'a, T> = [&'a [T]; 2];

/// Numbers of the matrices of the terms below n.
pub(super) fn size(n: usize) -> usize {
    // sum of k^2 + (k - 1)^2 for k from 1 to n
    if n == 0 { 0 } else { n * (n + 1) * (2 * n + 1) / 6 + (n - 1) * n * (2 * n - 1) / 6 }
}

/// Whether two classes have the same angle with the z axis.
fn alike(a: usize, b: usize) -> bool {
    let (z, w) = (step_of(a)[2], step_of(b)[2]);
    square_of(a) * w * w == square_of(b) * z * z && (z == 0) == (w == 0)
}

impl<'w, T: Real> Turns<'w, T> {
    /// The layout.
    pub fn layout(space: &mut impl Space<'w>, order: usize) -> Result<Self> {
        let (mut angles, mut of_angle, mut n_angles, mut total) = ([NONE; CLASSES], [[0; 3]; ANGLES], 0, 0);
        for class in (0..CLASSES).filter(|&class| exists(class) && class % 16 > 0) {
            let known = of_angle.iter().take(n_angles).position(|&[of, ..]: &[u32; 3]| alike(of as usize, class));
            let number = known.unwrap_or(n_angles);
            let slot = of_angle.get_mut(number).present()?;
            if known.is_none() {
                *slot = [class as u32, 0, 0];
                n_angles += 1;
            }
            slot[1] = slot[1].max(terms_of(class, order) as u32);
            *angles.get_mut(class).present()? = number as u8;
        }
        for slot in of_angle.iter_mut().take(n_angles) {
            slot[2] = total as u32;
            total += 2 * size(slot[1] as usize);
        }
        let square = (2 * order) * (2 * order);
        Ok(Self {
            angles,
            n_angles,
            of_angle,
            numbers: space.try_array(total)?,
            wigner: [space.try_array(square)?, space.try_array(square)?],
            roots: space.try_array(2 * order)?,
        })
    }

    /// Fills the tables.
    pub fn prepare(&mut self, order: usize) -> Result<()> {
        let side = 2 * order;
        for (k, root) in self.roots.iter_mut().enumerate() {
            *root = Scalar::sqrt(k as f64);
        }
        for &[class, terms, start] in self.of_angle.iter().take(self.n_angles) {
            let (class, terms, start) = (class as usize, terms as usize, start as usize);
            let cos = step_of(class)[2] as f64 / Scalar::sqrt(square_of(class) as f64);
            let half = [Scalar::sqrt(0.5 * (1.0 + cos)), Scalar::sqrt(0.5 * (1.0 - cos))];
            let both = self.numbers.get_mut(start..start + 2 * size(terms)).present()?;
            let (forward, backward) = both.split_at_mut_checked(size(terms)).present()?;
            let [mut now, mut before] = self.wigner.each_mut().map(|table| &mut **table);
            *now.first_mut().present()? = 1.0;
            for n in 0..terms {
                if n > 0 {
                    for of in [2 * n - 1, 2 * n] {
                        core::mem::swap(&mut now, &mut before);
                        raise(of, half, (before, now), side, self.roots);
                    }
                }
                let d = |m: i32, l: i32| {
                    let at = |m: i32| (m + n as i32) as usize;
                    // Harmonics without the factor (-1)^m.
                    let sign = if (m.max(0) + l.max(0)) % 2 == 0 { 1.0 } else { -1.0 };
                    sign * now.get(at(m) * side + at(l)).copied().unwrap_or(0.0)
                };
                let at = size(n);
                for (kind, least) in [(1.0, 0), (-1.0, 1)] {
                    let rows = n + 1 - least;
                    let at = at + if least == 0 { 0 } else { (n + 1) * (n + 1) };
                    for i in 0..rows {
                        for j in 0..rows {
                            let (m, l) = ((i + least) as i32, (j + least) as i32);
                            let value = match (m, l) {
                                (0, 0) => d(0, 0),
                                (0, _) | (_, 0) => core::f64::consts::SQRT_2 * d(m, l),
                                _ => d(m, l) + kind * d(m, -l),
                            };
                            let number = |i: usize, j: usize| at + place((i, j), rows, rows);
                            *forward.get_mut(number(i, j)).present()? = T::from_f64(value);
                            *backward.get_mut(number(j, i)).present()? = T::from_f64(value);
                        }
                    }
                }
            }
        }
        Ok(())
    }

    /// The rotation that a class of steps needs, if any.
    pub fn of(&self, class: usize) -> Option<Turn<'_, T>> {
        let angle = self.angles.get(class).copied().filter(|&angle| angle != NONE)?;
        let &[_, terms, start] = self.of_angle.get(usize::from(angle))?;
        let both = self.numbers.get(start as usize..)?.get(..2 * size(terms as usize))?;
        let (forward, backward) = both.split_at_checked(size(terms as usize))?;
        debug_assert!(class == PART || exists(class), "a class of steps");
        Some([forward, backward])
    }
}

/// d of N from that of N - 1.
fn raise(n: usize, [c, s]: [f64; 2], (from, to): (&[f64], &mut [f64]), side: usize, roots: &[f64]) {
    let root = |k: usize| roots.get(k).copied().unwrap_or(0.0);
    let inverse = 1.0 / n as f64;
    for k in 0..=n {
        for l in 0..=n {
            let at =
                |k: usize, l: usize| if k < n && l < n { from.get(k * side + l).copied().unwrap_or(0.0) } else { 0.0 };
            let (with_u, with_v) = (k.checked_sub(1), l.checked_sub(1));
            let upper =
                with_u.map_or(0.0, |k| with_v.map_or(0.0, |l2| c * root(l) * at(k, l2)) + s * root(n - l) * at(k, l));
            let lower = c * root(n - l) * at(k, l) - with_v.map_or(0.0, |l2| s * root(l) * at(k, l2));
            let value = inverse * (root(k) * upper + root(n - k) * lower);
            to.get_mut(k * side + l).into_iter().for_each(|to| *to = value);
        }
    }
}

//! The second transform, along the columns, and what a mode does in a time step.

use super::super::fft::{Element, half_root};
use super::super::poisson::{Shape, WIDTH, put, take};
use super::super::transform::{Kind, ROWS, Transform};
use crate::checked::Present;
use crate::error::{Error, Result};
use crate::exec::{Block, Chunks, Columns, Resources, par_chunks};
use crate::memory::Space;
use crate::real::Real;
use crate::simd::{Loops, with_simd};

/// Multiplies each mode F of a right-hand side by `(1 - e^(-mu s)) / mu`, where mu is K^2 times its eigenvalue and s the time in units of epsilon K^2.
#[derive(Debug)]
pub struct Spectrum<'w, T> {
    shape: Shape,
    transform: Transform<'w, T>,
    /// The column's part of mu: 4 sin^2(pi j / 2 m).
    across: &'w mut [T],
    /// 1 - e^(-mu s) of the rows' part of mu, padded, and of the columns'.
    fallen: [&'w mut [T]; 2],
    /// Two buffers of the transform for each worker.
    buffers: &'w mut [Element<T>],
}

impl<'w, T: Real> Spectrum<'w, T> {
    pub fn layout(space: &mut impl Space<'w>, shape: Shape, workers: usize) -> Result<Self> {
        let buffers = Transform::<T>::buffer(shape.m).checked_mul(2).and_then(|n| n.checked_mul(workers));
        Ok(Self {
            shape,
            transform: Transform::layout(space, shape.kind, shape.m)?,
            across: space.try_array(shape.m + 1)?,
            fallen: [space.try_array(shape.pitch)?, space.try_array(shape.m + 1)?],
            buffers: space.try_array(buffers.ok_or(Error::TooLarge)?)?,
        })
    }

    pub fn prepare(&mut self) {
        self.transform.prepare();
        let m = self.shape.m;
        for (j, mu) in self.across.iter_mut().enumerate() {
            let [sin, _] = half_root::<T>(j, 2 * m);
            *mu = T::from_i32(4) * sin * sin;
        }
    }

    /// Overwrites `values`, which hold the rows' transforms, by those of the result. `along` is the rows' part of mu, padded.
    pub fn run(&mut self, along: &[T], time: T, values: &mut [T], resources: Resources<'_>) -> Result<()> {
        let Self { shape, transform, across, fallen, buffers } = self;
        for (fallen, mu) in fallen.iter_mut().zip([along, across]) {
            fallen.iter_mut().zip(mu).for_each(|(fallen, &mu)| *fallen = -(-(mu * time)).expm1());
        }
        let (shape, transform, across, [fallen, fallen_across]) = (*shape, &*transform, &**across, &*fallen);
        let columns = Columns::new(values, shape.pitch, WIDTH);
        let buffers = Chunks::new(buffers, 2 * Transform::<T>::buffer(shape.m));
        par_chunks(resources.executor, shape.pitch / WIDTH, columns, buffers, &|task, block, buffers| {
            let along = along.get(task * WIDTH..).present()?;
            let fallen = [fallen.get(task * WIDTH..).present()?, fallen_across];
            let first = task * WIDTH;
            with_simd(
                resources.level,
                Modes { shape, first, transform, mu: [along, across], fallen, time, block, buffers },
            );
            Ok(())
        })
    }
}

/// The work on [`WIDTH`] columns.
struct Modes<'a, T> {
    shape: Shape,
    /// The number of the first column.
    first: usize,
    transform: &'a Transform<'a, T>,
    /// The two parts of mu, from the first column on and from row 0 on.
    mu: [&'a [T]; 2],
    fallen: [&'a [T]; 2],
    time: T,
    block: Block<'a, T>,
    buffers: &'a mut [Element<T>],
}

impl<T: Real> Loops for Modes<'_, T> {
    type Out = ();

    #[inline(always)]
    fn run(self) {
        let Self { shape: Shape { kind, n, m, .. }, first, transform, mu, fallen, time, mut block, buffers } = self;
        let half = buffers.len() / 2;
        let Some((a, b)) = buffers.split_at_mut_checked(half) else { return };
        let norm = T::TWO / T::from_usize(m);
        for group in 0..WIDTH / ROWS {
            for backward in [false, true] {
                for (s, element) in a.iter_mut().enumerate().take(m + 1) {
                    let row = block.row(s).get(group * ROWS..).present_or_default();
                    for (r, &value) in row.iter().enumerate().take(ROWS) {
                        // Two columns share a complex transform; those of the padding are not theirs.
                        put(element, r, if first + group * ROWS + r > n { T::ZERO } else { value });
                    }
                }
                let result = transform.run(a, b);
                for (s, element) in result.iter().enumerate().take(m + 1) {
                    let prescribed = kind == Kind::Sine && (s == 0 || s == m);
                    let at = |line: &[T], k: usize| line.get(k).copied().unwrap_or(T::ZERO);
                    let (mu_of_row, fallen_of_row) = (at(mu[1], s), at(fallen[1], s));
                    let row = block.row(s).get_mut(group * ROWS..).present_or_default();
                    for (r, value) in row.iter_mut().enumerate().take(ROWS) {
                        let k = group * ROWS + r;
                        *value = if prescribed {
                            T::ZERO
                        } else if backward {
                            take(element, r)
                        } else {
                            // 1 - (1 - a) (1 - b) without a difference.
                            let (sum, f) = (at(mu[0], k) + mu_of_row, at(fallen[0], k));
                            let decayed = f + fallen_of_row * (T::ONE - f);
                            let factor = if sum * time < T::EPSILON { time } else { decayed / sum };
                            take(element, r) * (factor * norm)
                        };
                    }
                }
            }
        }
    }
}

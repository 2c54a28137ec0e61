//! The five-point scheme with variable coefficients, and the loops of the iteration.
//!
//! Node i stands for its cell, whose faces lie midway between nodes. With `|f|` the length of face f, d the distance of the two nodes, `V` the area of the
//! cell and `G_f = 2 G G' / (G + G')` from both sides' values,
//!
//! `(A u)_i = sum_f |f| G_f (u_i - u_f) / d + k_i^2 V_i u_i`
//!
//! which is symmetric. Cells at a wall are halves and quarters, and so are their faces. All arrays have the layout of [`super::poisson`]'s values.

use super::super::poisson::Shape;
use super::super::transform::Kind;
use super::Coefficients;
use crate::checked::Present;
use crate::error::Result;
use crate::exec::{Chunks, Resources, par_chunks};
use crate::grid::Mesh;
use crate::memory::Space;
use crate::real::Real;
use crate::simd::{Loops, with_simd};

/// Rows per task.
const ROWS: usize = 16;
/// Partial sums of a row, so that they are added in lanes and always in the same order.
const LANES: usize = 8;

/// The coefficients of A.
#[derive(Debug)]
pub(super) struct Scheme<'w, T> {
    shape: Shape,
    /// `|f| G_f / d` between a node and the next of its row.
    along: &'w mut [T],
    /// The same between a node and that of the next row.
    across: &'w mut [T],
    /// `k^2 V`.
    decay: &'w mut [T],
    /// A sum for each row.
    sums: &'w mut [f64],
}

/// What of the coefficients the preconditioner has.
#[derive(Clone, Copy, Debug)]
pub(super) struct Means<T> {
    /// The mean of G, in units of 2^exponent.
    pub diffusivity: T,
    /// The mean of k^2 times the area of a cell, in the same units.
    pub decay: T,
}

impl<'w, T: Real> Scheme<'w, T> {
    pub(super) fn layout(space: &mut impl Space<'w>, shape: Shape) -> Result<Self> {
        let nodes = shape.pitch.checked_mul(shape.m + 1).ok_or(crate::Error::TooLarge)?;
        Ok(Self {
            shape,
            along: space.try_array(nodes)?,
            across: space.try_array(nodes)?,
            decay: space.try_array(nodes)?,
            sums: space.try_array(shape.m + 1)?,
        })
    }

    /// Takes over the coefficients, in units of 2^`exponent`, which is the largest G's.
    pub(super) fn set(&mut self, mesh: &Mesh<T>, coefficients: &Coefficients<'_, T>, exponent: i32) -> Means<T> {
        let Shape { kind, along_y, n, m, pitch } = self.shape;
        let [h, k] = self.shape.spacing(mesh);
        let row = mesh.cells()[0] + 1;
        let place = |t: usize, s: usize| if along_y { t * row + s } else { s * row + t };
        let diffusivity = |t: usize, s: usize| {
            let value = coefficients.diffusivity.get(place(t, s)).copied();
            value.unwrap_or(T::ONE).ldexp(-exponent)
        };
        let decay = |t: usize, s: usize| {
            let values = coefficients.decay.unwrap_or_default();
            let value = values.get(place(t, s)).copied().unwrap_or(T::ZERO).ldexp(-exponent);
            // Finite for any k^2. Where the bound applies, the field is zero to rounding.
            ((value * h) * k).min(T::MAX.ldexp(-64))
        };
        let share = |at: usize, last: usize| if at == 0 || at == last { T::HALF } else { T::ONE };
        let mean = |a: T, b: T| T::TWO * a * b / (a + b);
        let (mut sum_of_decay, mut sum, mut cells) = (0.0, 0.0, 0.0);
        let rows = self.along.chunks_mut(pitch.max(1)).zip(self.across.chunks_mut(pitch.max(1)));
        for (s, ((along, across), decays)) in rows.zip(self.decay.chunks_mut(pitch.max(1))).enumerate() {
            for (t, ((along, across), held)) in along.iter_mut().zip(across).zip(decays).enumerate().take(n + 1) {
                let here = diffusivity(t, s);
                let next = if t < n { mean(here, diffusivity(t + 1, s)) } else { T::ZERO };
                let above = if s < m { mean(here, diffusivity(t, s + 1)) } else { T::ZERO };
                (*along, *across) = (next * (k / h) * share(s, m), above * (h / k) * share(t, n));
                let area = share(t, n) * share(s, m);
                *held = decay(t, s) * area;
                if kind == Kind::Cosine || self.shape.is_unknown(s) && 0 < t && t < n {
                    let area = area.to_f64();
                    (sum_of_decay, sum) = (sum_of_decay + held.to_f64(), sum + here.to_f64() * area);
                    cells += area;
                }
            }
        }
        Means { diffusivity: T::from_f64(sum / cells), decay: T::from_f64(sum_of_decay / cells) }
    }

    /// Overwrites `out` with `b - A u` if b is given, else with `A u`, at the unknown nodes, and with 0 at others. Returns the product of `u` and `out`.
    pub(super) fn apply(
        &mut self,
        u: &[T],
        right: Option<&[T]>,
        out: &mut [T],
        resources: Resources<'_>,
    ) -> Result<f64> {
        let Self { shape, along, across, decay, sums } = self;
        let (shape, each) = (*shape, ROWS * shape.pitch);
        let (along, across, decay) = (&**along, &**across, &**decay);
        let outputs = (Chunks::new(out, each), Chunks::new(sums, ROWS));
        par_chunks(resources.executor, (shape.m + 1).div_ceil(ROWS), outputs, (), &|task, (out, sums), ()| {
            let first = task * ROWS;
            with_simd(resources.level, Apply { shape, along, across, decay, u, right, first, out, sums });
            Ok(())
        })?;
        Ok(self.total())
    }

    /// The product of two arrays over the nodes.
    pub(super) fn product(&mut self, a: &[T], b: &[T], resources: Resources<'_>) -> Result<f64> {
        let Shape { n, m, pitch, .. } = self.shape;
        par_chunks(resources.executor, (m + 1).div_ceil(ROWS), Chunks::new(self.sums, ROWS), (), &|task, sums, ()| {
            let rows = |of| part(of, task * ROWS * pitch);
            with_simd(resources.level, Products { n, pitch, a: rows(a), b: rows(b), sums });
            Ok(())
        })?;
        Ok(self.total())
    }

    /// Adds `factor` times `p` to `u` and subtracts `factor` times `q` from `r`.
    pub(super) fn step(
        &self,
        factor: T,
        (p, q): (&[T], &[T]),
        (u, r): (&mut [T], &mut [T]),
        resources: Resources<'_>,
    ) -> Result<()> {
        let each = ROWS * self.shape.pitch;
        let outputs = (Chunks::new(u, each), Chunks::new(r, each));
        par_chunks(resources.executor, (self.shape.m + 1).div_ceil(ROWS), outputs, (), &|task, (u, r), ()| {
            with_simd(resources.level, Scaled { factor, of: part(p, task * each), onto: u });
            with_simd(resources.level, Scaled { factor: -factor, of: part(q, task * each), onto: r });
            Ok(())
        })
    }

    /// Overwrites `p` with `z + factor p`.
    pub(super) fn turn(&self, factor: T, z: &[T], p: &mut [T], resources: Resources<'_>) -> Result<()> {
        let each = ROWS * self.shape.pitch;
        let tasks = (self.shape.m + 1).div_ceil(ROWS);
        par_chunks(resources.executor, tasks, Chunks::new(p, each), (), &|task, p, ()| {
            with_simd(resources.level, Turned { factor, z: part(z, task * each), p });
            Ok(())
        })
    }

    fn total(&self) -> f64 {
        self.sums.iter().sum()
    }
}

/// What follows from `from` on.
fn part<T>(values: &[T], from: usize) -> &[T] {
    values.get(from..).present_or_default()
}

/// The sum of products, always in the same order.
#[inline(always)]
fn product<T: Real>(a: &[T], b: &[T]) -> f64 {
    let mut sums = [0.0; LANES];
    let ((a, a_rest), (b, b_rest)) = (a.as_chunks::<LANES>(), b.as_chunks::<LANES>());
    for (a, b) in a.iter().zip(b) {
        for ((sum, a), b) in sums.iter_mut().zip(a).zip(b) {
            *sum += a.to_f64() * b.to_f64();
        }
    }
    for ((sum, a), b) in sums.iter_mut().zip(a_rest).zip(b_rest) {
        *sum += a.to_f64() * b.to_f64();
    }
    let [a, b, c, d, e, f, g, h] = sums;
    ((a + e) + (b + f)) + ((c + g) + (d + h))
}

/// A u, or b - A u, in the rows of a task.
struct Apply<'a, T> {
    shape: Shape,
    along: &'a [T],
    across: &'a [T],
    decay: &'a [T],
    u: &'a [T],
    right: Option<&'a [T]>,
    first: usize,
    out: &'a mut [T],
    sums: &'a mut [f64],
}

impl<T: Real> Loops for Apply<'_, T> {
    type Out = ();

    #[inline(always)]
    fn run(self) {
        let Self { shape, along, across, decay, u, right, first, out, sums } = self;
        let Shape { kind, n, m, pitch, .. } = shape;
        for (s, (out, sum)) in (first..).zip(out.chunks_mut(pitch.max(1)).zip(sums)) {
            let out = out.get_mut(..n + 1).present_or_default();
            if !shape.is_unknown(s) {
                out.fill(T::ZERO);
                *sum = 0.0;
                continue;
            }
            let of = |values, s: usize| rows(values, s, pitch, n);
            let (below, here, above) = (of(u, s.saturating_sub(1)), of(u, s), of(u, (s + 1).min(m)));
            let (under, over) = (of(across, s.saturating_sub(1)), of(across, s));
            let (along, decay) = (of(along, s), of(decay, s));
            // The first row has no face below. That above the last row is 0.
            let lowest = if s == 0 { T::ZERO } else { T::ONE };
            let columns = out.iter_mut().zip(here).zip(decay).zip(below.iter().zip(under)).zip(above.iter().zip(over));
            for ((((out, &u), &k), (&below, &under)), (&above, &over)) in columns {
                *out = (under * lowest) * (u - below) + over * (u - above) + k * u;
            }
            // Faces between nodes of the row.
            let right_of = here.get(1..).present_or_default();
            let inner = out.get_mut(1..n).present_or_default();
            let lefts = along.iter().zip(here);
            let rights = along.iter().zip(here).zip(right_of).skip(1);
            for ((out, (&before, &left)), ((&after, &u), &right)) in inner.iter_mut().zip(lefts).zip(rights) {
                *out += before * (u - left) + after * (u - right);
            }
            let ends = [(0, 1, 0), (n, n.saturating_sub(1), n.saturating_sub(1))];
            for (end, beside, face) in ends {
                let Some(out) = out.get_mut(end) else { continue };
                let get = |of: &[T], t: usize| of.get(t).copied().unwrap_or(T::ZERO);
                *out += get(along, face) * (get(here, end) - get(here, beside));
                if kind == Kind::Sine {
                    *out = T::ZERO;
                }
            }
            if let Some(right) = right {
                for (out, &b) in out.iter_mut().zip(of(right, s)) {
                    *out = b - *out;
                }
                if kind == Kind::Sine {
                    out.first_mut().into_iter().for_each(|out| *out = T::ZERO);
                    out.get_mut(n).into_iter().for_each(|out| *out = T::ZERO);
                }
            }
            *sum = product(here, out);
        }
    }
}

/// Nodes 0 to n of a row.
#[inline(always)]
fn rows<T>(values: &[T], s: usize, pitch: usize, n: usize) -> &[T] {
    let from = s * pitch;
    values.get(from..from + n + 1).present_or_default()
}

/// The products of the rows of a task.
struct Products<'a, T> {
    n: usize,
    pitch: usize,
    a: &'a [T],
    b: &'a [T],
    sums: &'a mut [f64],
}

impl<T: Real> Loops for Products<'_, T> {
    type Out = ();

    #[inline(always)]
    fn run(self) {
        let Self { n, pitch, a, b, sums } = self;
        for ((sum, a), b) in sums.iter_mut().zip(a.chunks(pitch.max(1))).zip(b.chunks(pitch.max(1))) {
            let inside = |row| <[T]>::get(row, ..n + 1).present_or_default();
            *sum = product(inside(a), inside(b));
        }
    }
}

/// Adds multiples.
struct Scaled<'a, T> {
    factor: T,
    of: &'a [T],
    onto: &'a mut [T],
}

impl<T: Real> Loops for Scaled<'_, T> {
    type Out = ();

    #[inline(always)]
    fn run(self) {
        for (onto, &of) in self.onto.iter_mut().zip(self.of) {
            *onto += self.factor * of;
        }
    }
}

/// The next direction.
struct Turned<'a, T> {
    factor: T,
    z: &'a [T],
    p: &'a mut [T],
}

impl<T: Real> Loops for Turned<'_, T> {
    type Out = ();

    #[inline(always)]
    fn run(self) {
        for (p, &z) in self.p.iter_mut().zip(self.z) {
            *p = z + self.factor * *p;
        }
    }
}

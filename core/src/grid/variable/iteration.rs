//! Conjugate gradients with the direct solver as preconditioner.

use super::scheme::Scheme;
use super::{Limits, Report};
use crate::error::Result;
use crate::exec::Resources;
use crate::grid::fixed::{BITS, exact};
use crate::grid::poisson::Shape;
use crate::grid::transform::Kind;
use crate::grid::{Grid, Walls};
use crate::memory::Space;
use crate::real::{Real, quotient};

/// The iteration's arrays, in the layout of the solver's values.
#[derive(Debug)]
pub(super) struct Vectors<'w, T> {
    /// The solution.
    u: &'w mut [T],
    /// The residual b - A u.
    residual: &'w mut [T],
    /// The direction.
    direction: &'w mut [T],
    /// A times the direction; the right-hand side b where that is needed.
    image: &'w mut [T],
}

impl<'w, T: Real> Vectors<'w, T> {
    pub(super) fn layout(space: &mut impl Space<'w>, nodes: usize) -> Result<Self> {
        Ok(Self {
            u: space.try_array(nodes)?,
            residual: space.try_array(nodes)?,
            direction: space.try_array(nodes)?,
            image: space.try_array(nodes)?,
        })
    }

    /// Leaves the solution in the solver's values. Returns whether the tolerance was reached.
    ///
    /// All products are sums in double precision, in an order that depends on the mesh alone.
    pub(super) fn solve(
        &mut self,
        grid: &mut Grid<'_, T>,
        scheme: &mut Scheme<'_, T>,
        limits: &Limits<T>,
        resources: Resources<'_>,
    ) -> Result<(Report<T>, bool)> {
        let Self { u, residual, direction, image } = self;
        let (mesh, equation, far) = (grid.mesh, grid.equation, grid.relative);
        let shape = Shape::of(&mesh, &equation);
        u.fill(T::ZERO);
        let super::super::Arrays { words, solver, .. } = &mut grid.arrays;
        solver.take_border(&mesh, &far, u);
        // The energy of the masses alone.
        let singular = equation.walls == Walls::NoFlux && equation.screening == T::ZERO;
        right_side(&shape, words, singular, residual);
        solver.precondition(&mesh, &equation, residual, resources)?;
        let mut energy = scheme.product(solver.values(), residual, resources)?;
        let whole = energy;
        let enough = limits.tolerance.to_f64() * limits.tolerance.to_f64() * whole;
        if shape.kind == Kind::Sine {
            right_side(&shape, words, singular, image);
            scheme.apply(u, Some(&**image), residual, resources)?;
            solver.precondition(&mesh, &equation, residual, resources)?;
            energy = scheme.product(solver.values(), residual, resources)?;
        }
        let mut iterations = 0;
        // Whether the residual is the computed one and not the recurrence's.
        let mut exact = true;
        let mut factor = T::ZERO;
        let reached = loop {
            let small = energy <= enough;
            if exact && (small || iterations >= limits.iterations) {
                break small;
            }
            if !exact && (small || iterations >= limits.iterations) {
                right_side(&shape, words, singular, image);
                scheme.apply(u, Some(&**image), residual, resources)?;
                solver.precondition(&mesh, &equation, residual, resources)?;
                energy = scheme.product(solver.values(), residual, resources)?;
                (exact, factor) = (true, T::ZERO);
                continue;
            }
            scheme.turn(factor, solver.values(), direction, resources)?;
            let bent = scheme.apply(direction, None, image, resources)?;
            let length = T::from_f64(energy / bent);
            scheme.step(length, (direction, image), (u, residual), resources)?;
            solver.precondition(&mesh, &equation, residual, resources)?;
            let before = energy;
            energy = scheme.product(solver.values(), residual, resources)?;
            factor = T::from_f64(energy / before);
            iterations += 1;
            exact = false;
        };
        let residual = if whole > 0.0 { T::from_f64(quotient(energy, whole)).sqrt() } else { T::ZERO };
        solver.values_mut().iter_mut().zip(u.iter()).for_each(|(value, &u)| *value = u);
        Ok((Report { iterations, residual }, reached))
    }
}

/// Overwrites `right` with b = -masses at the unknown nodes, in units of the masses' bound; less their mean if the equation is `singular`.
fn right_side<T: Real>(shape: &Shape, words: &[i64], singular: bool, right: &mut [T]) {
    let Shape { kind, along_y, n, m, pitch } = *shape;
    let (step, row_step) = if along_y { (m + 1, 1) } else { (1, n + 1) };
    let unit = T::ONE.ldexp(-BITS);
    let share = |at: usize, last: usize| if at == 0 || at == last { T::HALF } else { T::ONE };
    let total: i64 = words.iter().take((n + 1) * (m + 1)).fold(0, |sum, w| sum.wrapping_add(*w));
    let mean =
        if singular { T::from_f64(exact(total)) * unit / (T::from_usize(n) * T::from_usize(m)) } else { T::ZERO };
    for (s, row) in right.chunks_mut(pitch.max(1)).enumerate() {
        if !shape.is_unknown(s) {
            row.fill(T::ZERO);
            continue;
        }
        let words = words.get(s * row_step..).unwrap_or_default();
        for (t, (slot, &word)) in row.iter_mut().zip(words.iter().step_by(step.max(1))).enumerate().take(n + 1) {
            let border = kind == Kind::Sine && (t == 0 || t == n);
            let density = mean * (share(t, n) * share(s, m)) - T::from_f64(exact(word)) * unit;
            *slot = if border { T::ZERO } else { density };
        }
    }
}

//! All pairs of any kernel, one pair at a time through its scalar functions.

use super::{Counters, Interaction, Options, Outputs, Run, Sources};
use crate::error::{Error, Result};
use crate::real::Real;
use crate::space::{Chunks, each_piece};

/// Targets of one task.
const TASK: usize = 128;

pub(super) fn evaluate<T: Real, const D: usize>(
    kernel: &dyn Interaction<T, D>,
    options: &Options,
    sources: Sources<'_, T, D>,
    targets: &[[T; D]],
    outputs: Outputs<'_, T, D>,
    run: &mut Run<'_>,
) -> Result<()> {
    let (a, b) = options.combination;
    let (combine, combination) = ((a, b) != (1.0, 0.0), (T::from_f64(a), T::from_f64(b)));
    let (should_stop, wanted) = (run.should_stop, outputs.wanted());
    let pieces = (
        outputs.potential.map(|p| Chunks::new(p, TASK)),
        outputs.gradient.map(|g| Chunks::new(g, TASK)),
        outputs.laplacian.map(|l| Chunks::new(l, TASK)),
    );
    each_piece(run.executor, targets.len().div_ceil(TASK), &pieces, &(), &|task, (p, g, l), ()| {
        if should_stop.is_some_and(|stop| stop()) {
            return Err(Error::Stopped);
        }
        let (mut p, mut g, mut l) = (p.map(|p| p.iter_mut()), g.map(|g| g.iter_mut()), l.map(|l| l.iter_mut()));
        for target in targets.iter().skip(task.saturating_mul(TASK)).take(TASK) {
            let (mut u, mut du, mut ddu) = (T::ZERO, [T::ZERO; D], T::ZERO);
            for (source, &m) in sources.positions.iter().zip(sources.masses) {
                let mut x = [T::ZERO; D];
                for ((x, &a), &b) in x.iter_mut().zip(target).zip(source) {
                    *x = a - b;
                }
                let r = x.iter().fold(T::ZERO, |sum, &x| sum + x * x).sqrt();
                if m == T::ZERO || kernel.is_singular() && r == T::ZERO {
                    continue;
                }
                let [value, gradient, laplacian] = kernel.pair(r, wanted);
                if wanted.potential {
                    u += m * value;
                }
                if wanted.gradient {
                    let factor = m * gradient;
                    du.iter_mut().zip(&x).for_each(|(du, &x)| *du += factor * x);
                }
                if wanted.laplacian {
                    ddu += m * laplacian;
                }
            }
            if let Some(out) = p.as_mut().and_then(Iterator::next) {
                *out = u;
            }
            if let ((true, [x, y, ..]), (a, b)) = ((combine, du.as_mut_slice()), combination) {
                (*x, *y) = (a * *x - b * *y, a * *y + b * *x);
            }
            if let Some(out) = g.as_mut().and_then(Iterator::next) {
                *out = du;
            }
            if let Some(out) = l.as_mut().and_then(Iterator::next) {
                *out = ddu;
            }
        }
        Ok(())
    })?;
    if let Some(counters) = run.counters.as_deref_mut() {
        let massless = sources.masses.iter().filter(|&&m| m == T::ZERO).count();
        let pairs = (sources.masses.len().saturating_sub(massless) as u64).saturating_mul(targets.len() as u64);
        counters.add(&Counters { pairs, massless_sources: massless as u64, ..Counters::default() });
    }
    Ok(())
}

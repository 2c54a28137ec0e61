//! All pairs of any kernel, lanes of sources at a time.

use super::{Counters, Interaction, LANES, Options, Outputs, Run, Sources};
use crate::error::{Error, Result};
use crate::kernel::add_lanes;
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
    let (should_stop, wanted, singular) = (run.should_stop, outputs.wanted(), kernel.is_singular());
    let pieces = (
        outputs.potential.map(|p| Chunks::new(p, TASK)),
        outputs.gradient.map(|g| Chunks::new(g, TASK)),
        outputs.laplacian.map(|l| Chunks::new(l, TASK)),
    );
    each_piece(run.executor, targets.len().div_ceil(TASK), pieces, (), &|task, (p, g, l), ()| {
        if should_stop.is_some_and(|stop| stop()) {
            return Err(Error::Stopped);
        }
        let (mut p, mut g, mut l) = (p.map(|p| p.iter_mut()), g.map(|g| g.iter_mut()), l.map(|l| l.iter_mut()));
        for target in targets.iter().skip(task.saturating_mul(TASK)).take(TASK) {
            let (mut u, mut du, mut ddu) = ([T::ZERO; LANES], [[T::ZERO; LANES]; D], [T::ZERO; LANES]);
            for (sources, masses) in sources.positions.chunks(LANES).zip(sources.masses.chunks(LANES)) {
                // Lanes beyond the last source have no mass.
                let (mut x, mut m, mut r) = ([[T::ZERO; LANES]; D], [T::ZERO; LANES], [T::ZERO; LANES]);
                m.iter_mut().zip(masses).for_each(|(to, &m)| *to = m);
                for (k, source) in sources.iter().enumerate() {
                    for ((x, &a), &b) in x.iter_mut().zip(target).zip(source) {
                        x.get_mut(k).into_iter().for_each(|x| *x = a - b);
                    }
                }
                for x in &x {
                    r.iter_mut().zip(x).for_each(|(sum, &x)| *sum += x * x);
                }
                r.iter_mut().for_each(|r| *r = r.sqrt());
                let mut counts = [true; LANES];
                for ((counts, &m), &r) in counts.iter_mut().zip(&m).zip(&r) {
                    *counts = m != T::ZERO && !(singular && r == T::ZERO);
                }
                // A lane that does not count stands where one does, so that the kernel is asked for nothing else.
                let Some(one) = r.iter().zip(&counts).find(|(_, counts)| **counts).map(|(r, _)| *r) else { continue };
                r.iter_mut().zip(&counts).for_each(|(r, &counts)| *r = if counts { *r } else { one });
                let [value, gradient, laplacian] = kernel.pairs(&r, sources.len(), wanted);
                let add = |sums: &mut [T; LANES], terms: [T; LANES]| add_lanes(sums, &terms, &counts);
                let times = |mut a: [T; LANES], b: &[T; LANES]| {
                    a.iter_mut().zip(b).for_each(|(a, &b)| *a *= b);
                    a
                };
                if wanted.potential {
                    add(&mut u, times(value, &m));
                }
                if wanted.gradient {
                    let factor = times(gradient, &m);
                    du.iter_mut().zip(&x).for_each(|(du, x)| add(du, times(factor, x)));
                }
                if wanted.laplacian {
                    add(&mut ddu, times(laplacian, &m));
                }
            }
            let all = |lanes: [T; LANES]| lanes.into_iter().fold(T::ZERO, |sum, v| sum + v);
            let (u, mut du, ddu) = (all(u), du.map(all), all(ddu));
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

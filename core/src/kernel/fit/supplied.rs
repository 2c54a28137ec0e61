//! A host's kernel: its fits, and by how much they miss it.
//!
//! Without a mollifier the panels are octaves of r from the reach downwards. They end at the host's knots, and are halved where their series does not converge.
//! Closer than the least distance K continues as the power of r that K'/r has there. All of it is compared with the host's functions between the nodes.

use core::cell::Cell;

use super::builder::{Axis, Builder};
use crate::checked::Present;
use crate::error::{Error, Result};
use crate::kernel::chebyshev::{CAPACITY, Fit, clenshaw, fit_any};
use crate::kernel::convolution::{Convolution, Sample, Target};
use crate::kernel::fitted_term::{FittedTerm, HEADER, Outer, Variable};
use crate::kernel::law::{Law, MAX_KNOTS, Supplied};
use crate::kernel::profile::Profile;
use crate::kernel::sizes::{Sizes, larger, magnitudes, relative_errors};
use crate::real::Scalar;

/// Most octaves of r, upwards from the mollifier's length.
const OCTAVES: usize = 40;
/// Most panels.
pub(crate) const PANELS: usize = 128;
/// Room for their coefficients, in triples: for the panels that there must be, of any length, and many more of the usual 35.
const TRIPLES: usize = 4200;
/// Numbers in the tables of a host's kernel.
pub(crate) const NUMBERS: usize = PANELS * HEADER + 3 * TRIPLES;

/// Panels are halved until they are a 16th of the first.
const NARROWEST: f64 = 0.06;
/// Distances between the nodes of a panel at which its error is measured; under a mollifier, where each is an integral, fewer.
const TRIED: usize = 23;
const TRIED_INTEGRALS: usize = 7;

/// r moved between two distances, so far that a function's branch is that between them.
fn between(r: f64, [from, to]: [f64; 2]) -> f64 {
    const APART: f64 = 4.0 * f64::EPSILON;
    r.max(from * (1.0 + APART)).min(to * (1.0 - APART))
}

/// The panels that are still to come, so that those that must be have room.
struct Room {
    panels: usize,
    /// Panels that must still be made.
    needed: usize,
    /// The error of a panel that is good enough.
    goal: f64,
    /// Distances at which it is measured, and the sizes so far.
    tried: usize,
    sizes: Sizes,
}

impl Room {
    fn serves_another(&self, builder: &Builder<'_>) -> bool {
        let triples = builder.tables.len().saturating_sub(builder.next) / 3;
        self.panels + self.needed + 1 < PANELS && (self.needed + 2) * CAPACITY <= triples
    }
}

/// The input for preparing a host's kernel.
pub(crate) struct Host<'a> {
    pub(crate) own: &'a Supplied<'a>,
    pub(crate) profile: Option<&'a Profile>,
    /// The unit of r: delta, or without a mollifier the reach.
    pub(crate) unit: f64,
    /// The error that is allowed.
    pub(crate) tolerance: f64,
}

impl Host<'_> {
    /// Prepares it, up to its reach. The error is left with the builder.
    pub(crate) fn prepare<const D: usize>(&self, builder: &mut Builder<'_>) -> Result<FittedTerm<f64>> {
        builder.limit = self.own.reach;
        // Single distances are evaluated in double precision for either scalar.
        builder.largest = f64::MAX;
        match self.profile {
            None => self.bare::<D>(builder),
            Some(profile) => self.mollified::<D>(profile, builder),
        }
    }

    /// The tail of a series that is good enough.
    fn goal(&self) -> f64 {
        // Not `clamp`: its check of the bounds is a way to panic.
        let goal = (0.01 * self.tolerance).min(1e-10);
        if goal > 1e-14 { goal } else { 1e-14 }
    }

    /// Fits in r^2 from one distance to another, as many as it takes.
    fn panels<const D: usize>(
        &self,
        [from, to]: [f64; 2],
        factors: [f64; 3],
        sample: &dyn Fn(f64) -> Option<Sample>,
        room: &mut Room,
        builder: &mut Builder<'_>,
    ) -> Result<()> {
        let (mut low, mut high) = (from, to);
        let in_units = |r: f64| (r / self.unit) * (r / self.unit);
        // Samples under a mollifier are in units of delta.
        let scale = if self.profile.is_some() { self.unit } else { 1.0 };
        while low < to {
            let (first, last) = (in_units(low), in_units(high));
            let half = 0.5 * (last - first);
            let at = |x: f64| between(self.unit * (first + half * (x + 1.0)).sqrt(), [low, high]);
            let fit = fit_any(|x| sample(at(x)))?;
            let narrow = high - low < NARROWEST * (to - from);
            // Roundings are relative to the largest size on the panel, which a steep kernel has at one end.
            let mut sizes = room.sizes.clone();
            let mut missed = [0.0; 3];
            for r in tried([low, high], room.tried) {
                let Sample { values, .. } = sample(r).ok_or(Error::NotFinite)?;
                let x = ((in_units(r) - first) / half - 1.0).clamp(-1.0, 1.0);
                let got = clenshaw(fit.coefficients.get(..fit.len).present_or(&[]), x);
                missed = relative_errors(missed, got, values, sizes.at(r / scale, magnitudes::<D>(r / scale, values)));
            }
            let error = missed.iter().fold(fit.error, |most, &e| most.max(e));
            if error > room.goal && !narrow && room.serves_another(builder) {
                high = 0.5 * (low + high);
                continue;
            }
            builder.fitted(high, Axis::between(Variable::Square, 1.0, first, last), &fit, factors)?;
            room.panels += 1;
            room.sizes = sizes;
            (low, high) = (high, to);
        }
        room.needed = room.needed.saturating_sub(1);
        Ok(())
    }

    /// Without a mollifier.
    fn bare<const D: usize>(&self, builder: &mut Builder<'_>) -> Result<FittedTerm<f64>> {
        let &Supplied { kernel, coefficient, reach, knots, .. } = self.own;
        let least = self.own.least();
        let sample = |r: f64| {
            let values = kernel.at(r);
            values.iter().all(|v| v.is_finite()).then(|| Sample { values, sizes: magnitudes::<D>(r, values) })
        };
        let first = builder.begin(PANELS);
        let needed = borders(least, reach, knots).count();
        let mut room = Room {
            panels: 0,
            needed,
            goal: self.goal(),
            tried: TRIED,
            sizes: Sizes::new((0.0, [0.0; 3]), [1e-280; 3]),
        };
        let mut low = least;
        for high in borders(least, reach, knots) {
            self.panels::<D>([low, high], [coefficient; 3], &sample, &mut room, builder)?;
            low = high;
        }
        let [value, factor, laplacian] = sample(least * (1.0 + 4.0 * f64::EPSILON)).ok_or(Error::NotFinite)?.values;
        // r g' = Laplacian - D g
        let power = if factor == 0.0 { 0.0 } else { laplacian / factor - D as f64 };
        let power = if power.abs() <= 40.0 { power } else { 0.0 };
        // Next to a half-integer it is that of the limit.
        let half_integer = 0.5 * Scalar::round(2.0 * power);
        let power = if (power - half_integer).abs() < 1e-8 { half_integer } else { power };
        let outer = Outer::Continued { least, power };
        let (law, panels) = (Law::Newtonian, room.panels);
        let part = FittedTerm { law, radius: reach, panels, plain: panels, first, outer };
        let scaled = |values: [f64; 3]| values.map(|v| coefficient * v);
        let reference = |r: f64| sample(r).map(|sample| scaled(sample.values));
        let floor = [1e-280; 3];
        let at_least = larger(magnitudes::<D>(least, scaled([value, factor, laplacian])), floor);
        builder.errors =
            misses::<D>(&part, builder.tables, &reference, (least, Sizes::new((0.0, floor), floor)), TRIED)?;
        if self.own.least <= 0.0 {
            for step in 0..7 {
                // From half the least distance to 2^-64 of it. What is not finite any more has no continuation to compare with.
                let r = least / power_of_two(1 << step);
                let Some(want) = Some(kernel.at(r)).filter(|v| v.iter().all(|v| v.is_finite())) else { break };
                let (got, want) = (part.alone::<D>(builder.tables, r), scaled(want));
                builder.errors = relative_errors(builder.errors, got, want, larger(magnitudes::<D>(r, want), at_least));
            }
        }
        Ok(part)
    }

    /// Under a mollifier.
    fn mollified<const D: usize>(&self, profile: &Profile, builder: &mut Builder<'_>) -> Result<FittedTerm<f64>> {
        let &Supplied { kernel, coefficient, reach, .. } = self.own;
        let delta = self.unit;
        let mut knots = [f64::INFINITY; MAX_KNOTS];
        knots.iter_mut().zip(self.own.knots).for_each(|(to, knot)| *to = knot / delta);
        // Where K' jumps the Laplacian alone would miss what is there.
        let weakly = |inside: bool| inside || !self.own.knots.is_empty();
        let convolution = Convolution::with_knots(D, *profile, 0.0, knots);
        let square = delta * delta;
        // the integrals may skip values, but a kernel that is not finite anywhere it is called is refused
        let finite = Cell::new(true);
        let call = |q: f64| {
            let [u, g, l] = kernel.at(delta * q);
            finite.set(finite.get() && u.is_finite() && g.is_finite() && l.is_finite());
            let volume = Scalar::powi(q, D.saturating_sub(1) as u32);
            [volume * u, volume * square * g * q, volume * square * l]
        };
        let at = |target: Target, inside: bool| {
            let values = convolution.at(target, weakly(inside), &mut |q, _| call(q))?.values;
            let sizes = magnitudes::<D>(target.r(), values);
            Some(Sample { values, sizes })
        };
        let inside_at = |r: f64| Target::inside((delta - r) / delta * (1.0 + r / delta));
        let factors = [coefficient, coefficient / delta / delta, coefficient / delta / delta];
        let compact = matches!(profile, Profile::Compact { .. });
        let octaves = octaves_to((reach / delta).max(1.0));
        if octaves > OCTAVES {
            return Err(Error::Unsupported);
        }
        let first = builder.begin(PANELS);
        // K_delta is less smooth a delta away from a knot of K.
        let mut beside = [f64::INFINITY; 2 * MAX_KNOTS];
        for (pair, knot) in beside.as_chunks_mut::<2>().0.iter_mut().zip(self.own.knots) {
            *pair = if compact { [(knot - delta).abs(), knot + delta] } else { [*knot, f64::INFINITY] };
        }
        let end = delta * power_of_two(octaves);
        let mut inside = [0.0; 3];
        for k in 0..=16 {
            let target = inside_at(delta * f64::from(k) / 16.0);
            inside = larger(inside, at(target, true).ok_or(Error::NotFinite)?.sizes);
        }
        let mut room = Room {
            panels: 0,
            needed: octaves + 2 * MAX_KNOTS,
            goal: self.goal(),
            tried: TRIED_INTEGRALS,
            sizes: Sizes::new((1.0, inside), [1e-280; 3]),
        };
        if compact {
            // The kernel's singularity at 0 is not known, so the root with the smaller error is used.
            let mut low = 0.0;
            loop {
                let high = next(low, delta, &beside);
                if high * SLIGHTLY >= delta {
                    break;
                }
                self.panels::<D>([low, high], factors, &|r| at(inside_at(r), true), &mut room, builder)?;
                low = high;
            }
            let whole = inside_at(low).t();
            let edge = |root: f64| -> Result<(Axis, Fit)> {
                let axis = Axis::edge(Variable::Edge, root, whole);
                fit_any(|x| at(Target::inside(axis.t(x).min(whole)), true)).map(|fit| (axis, fit))
            };
            let mut best = edge(0.5)?;
            if best.1.error > 1e-14 {
                let other = edge(0.25)?;
                best = if other.1.error < best.1.error { other } else { best };
            }
            builder.fitted(delta, best.0, &best.1, factors)?;
            room.panels += 1;
        } else {
            self.panels::<D>([0.0, delta], factors, &|r| at(Target::at(r / delta), true), &mut room, builder)?;
        }
        let mut low = delta;
        for high in borders_between(delta, end, &beside) {
            if low == delta && compact {
                // v = sqrt(rho^2 - 1) from 0: the edge from outside
                let ratio = high / delta;
                let span = ((ratio - 1.0) * (ratio + 1.0)).sqrt();
                let fit = fit_any(|x| {
                    let v = 0.5 * span * (x + 1.0);
                    at(Target::at((1.0 + v * v).sqrt()), false)
                })?;
                builder.fitted(high, Axis::between(Variable::Outside, 0.5, 0.0, span), &fit, factors)?;
                room.panels += 1;
            } else {
                let sample = |r: f64| at(Target::at(r / delta), !compact);
                self.panels::<D>([low, high], factors, &sample, &mut room, builder)?;
            }
            low = high;
            if low >= reach {
                break;
            }
        }
        let (law, panels) = (Law::Newtonian, room.panels);
        let part = FittedTerm { law, radius: delta, panels, plain: panels, first, outer: Outer::Zero };
        let reference = |r: f64| {
            let target = if r < delta { inside_at(r) } else { Target::at(r / delta) };
            let [f, g, h] = factors;
            at(target, r < delta || !compact).map(|Sample { values: [u, v, w], .. }| [f * u, g * v, h * w])
        };
        let [value, factor, laplacian] = inside;
        let [f, g, h] = factors.map(f64::abs);
        let inside = [f * value, g * factor, h * laplacian];
        let sizes = Sizes::new((delta, inside), [1e-280; 3]);
        builder.errors = misses::<D>(&part, builder.tables, &reference, (0.0, sizes), TRIED_INTEGRALS)?;
        if finite.get() { Ok(part) } else { Err(Error::NotFinite) }
    }
}

/// So many distances in a panel, ascending, denser at its ends and between the nodes of its fit.
fn tried([low, high]: [f64; 2], count: usize) -> impl Iterator<Item = f64> {
    (0..count).map(move |k| {
        let angle = core::f64::consts::PI * (k as f64 + 0.7) / count as f64;
        between(low + 0.5 * (high - low) * (1.0 - Scalar::cos(angle)), [low, high])
    })
}

/// The largest errors between the nodes of a part's panels, relative to the sizes.
fn misses<const D: usize>(
    part: &FittedTerm<f64>,
    tables: &[f64],
    reference: &dyn Fn(f64) -> Option<[f64; 3]>,
    (start, mut sizes): (f64, Sizes),
    count: usize,
) -> Result<[f64; 3]> {
    let (mut worst, mut low) = ([0.0; 3], start);
    for index in 0..part.panels {
        let Some(panel) = part.panel(tables, index) else { break };
        for r in tried([low, panel.end], count) {
            let want = reference(r).ok_or(Error::NotFinite)?;
            let size = sizes.at(r, magnitudes::<D>(r, want));
            worst = relative_errors(worst, part.alone::<D>(tables, r), want, size);
        }
        low = panel.end;
    }
    Ok(worst)
}

/// 2^n.
fn power_of_two(n: usize) -> f64 {
    Scalar::ldexp(1.0_f64, n as i32)
}

/// The smallest n >= 0 with 2^n >= x.
fn octaves_to(x: f64) -> usize {
    let (m, e) = Scalar::frexp(x);
    (if m == 0.5 { e - 1 } else { e }).max(0) as usize
}

/// Where panels end: at the octaves below the reach, and at the knots.
fn borders(least: f64, reach: f64, knots: &[f64]) -> impl Iterator<Item = f64> + '_ {
    let octaves = octaves_to(reach / least);
    let mut low = least;
    core::iter::from_fn(move || {
        if low >= reach {
            return None;
        }
        // The first octave border above.
        let mut high = reach;
        for n in 1..octaves {
            let border = reach / power_of_two(n);
            high = if border > low * SLIGHTLY { border } else { break };
        }
        low = next(low, high, knots);
        Some(low)
    })
}

/// As [`borders`], upwards from a distance.
fn borders_between(from: f64, to: f64, knots: &[f64]) -> impl Iterator<Item = f64> + '_ {
    let (mut low, mut octave) = (from, from);
    core::iter::from_fn(move || {
        if low >= to {
            return None;
        }
        while octave <= low * SLIGHTLY {
            octave *= 2.0;
        }
        low = next(low, octave.min(to), knots);
        Some(low)
    })
}

/// More than the rounding of a distance.
const SLIGHTLY: f64 = 1.0 + 1e-12;

/// The first knot above `low`, if it is not above `high`, or `high`.
fn next(low: f64, high: f64, knots: &[f64]) -> f64 {
    let above = knots.iter().filter(|&&knot| knot > low * SLIGHTLY && knot <= high * SLIGHTLY);
    above.fold(high, |least, &knot| if least == high || knot < least { knot } else { least })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec::Vec;

    #[test]
    fn panels_end_at_octaves_and_knots() {
        let of = |knots: &[f64]| borders(0.0625, 1.0, knots).collect::<Vec<_>>();
        assert_eq!(of(&[]), [0.125, 0.25, 0.5, 1.0]);
        // A knot on an octave's border, or next to it, replaces it.
        assert_eq!(of(&[0.25, 0.3]), [0.125, 0.25, 0.3, 0.5, 1.0]);
        let close = 0.5 * (1.0 + 1e-14);
        assert_eq!(of(&[0.07, close]), [0.07, 0.125, 0.25, close, 1.0]);
        assert_eq!(borders(0.3, 1.0, &[]).collect::<Vec<_>>(), [0.5, 1.0]);
        assert_eq!(borders_between(1.0, 8.0, &[0.5, 3.0]).collect::<Vec<_>>(), [2.0, 3.0, 4.0, 8.0]);
    }
}

//! Preparation of one term: the choice of its closed form or fit, and its tables.
//!
//! A fit is divided into panels. On each, no function's size changes by more than a factor of 64, because roundings are relative to the
//! largest size on the panel. Sizes are those of the convolution ([`Sample`]) or of the bare kernel at the mollifier's length, whichever is larger.

mod builder;
mod supplied;
mod unit;

pub(crate) use builder::Builder;
pub(crate) use supplied::{Host, PANELS as HOST_PANELS};

use builder::Axis;
use unit::Unit;

use super::chebyshev::fit;
use super::convolution::{REACH, Target};
use super::edge_series::{LENGTH, exact, exterior_factor, laurent, odd_power, screened_edge, series};
use super::fitted_term::{FittedTerm, HEADER, Outer, Variable};
use super::law::{Law, is_multiple};
use super::profile::{Profile, TERMS};
use crate::checked::Present;
use crate::error::{Error, Result};
use crate::real::{DoubleWord, Scalar};

/// Most panels of a fit: inside (for a Gaussian mollifier up to where its field is the exterior one), and outside.
const INNER: usize = 24;
const OUTER: usize = 8;
/// Capacity for the coefficients of both, in triples. Most panels need 20 to 30.
const TRIPLES: usize = 560;
/// Up to this kappa the series from the edge loses less than one digit.
const SERIES_KAPPA: f64 = 3.0;

/// The least p + d - 1 of a power law with M = 1. For smaller values the Laplacian at the edge grows like 1/(p + d - 1), and the part that
/// the integrals omit next to the singularity, 1e-250^(p + d - 1), is not negligible.
const ROUGHEST: f64 = 0.08;

/// The representation of a term. It depends on the law, the mollifier's kind and the dimension alone, so that sizes are
/// known before delta is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Form {
    /// The bare law: no tables.
    Bare,
    /// Powers inside and outside.
    Closed,
    /// Fits inside and outside.
    Fitted,
    /// Fits on octaves from a user's callback.
    Supplied,
}

fn form(law: Law, profile: Option<&Profile>, dimension: usize) -> Form {
    let Some(profile) = profile else { return Form::Bare };
    if let Law::Power { exponent: p } = law
        && laurent(p, dimension, profile).is_some()
        && (p > 0.0 && is_multiple(p, 2.0)
            || p > 2.0 - dimension as f64 && !is_multiple(p, 2.0) && odd_power(p, dimension, profile).is_some())
    {
        return Form::Closed;
    }
    Form::Fitted
}

/// Most numbers in the tables of a term.
pub(crate) fn capacity(law: Option<Law>, profile: Option<&Profile>, dimension: usize) -> usize {
    match law.map_or(Form::Supplied, |law| form(law, profile, dimension)) {
        Form::Bare => 0,
        Form::Closed => 2 * (HEADER + 6 * LENGTH),
        Form::Fitted => (INNER + OUTER) * HEADER + 3 * TRIPLES,
        Form::Supplied => supplied::NUMBERS,
    }
}

/// The input for preparing one term.
pub(crate) struct Task<'a> {
    pub(crate) dimension: usize,
    pub(crate) profile: Option<&'a Profile>,
    pub(crate) delta: f64,
    pub(crate) coefficient: f64,
}

impl Task<'_> {
    /// delta^a, times the coefficient.
    fn power(&self, a: f64) -> f64 {
        self.coefficient * self.delta.pow(a)
    }

    /// The factors that convert value, gradient factor and Laplacian from units of delta, where the value scales as delta^a.
    fn factors(&self, a: f64) -> [f64; 3] {
        [self.power(a), self.power(a - 2.0), self.power(a - 2.0)]
    }

    /// Prepares a known law in canonical form that is not Newtonian.
    pub(crate) fn prepare<const D: usize>(&self, law: Law, builder: &mut Builder<'_>) -> Result<FittedTerm<f64>> {
        let outer = Outer::Bare { factor: self.coefficient };
        let mut part = FittedTerm { law, radius: self.delta, panels: 1, plain: 1, first: 0, outer };
        let Some(profile) = self.profile else {
            return Ok(FittedTerm { radius: 0.0, panels: 0, plain: 0, ..part });
        };
        match (form(law, Some(profile), D), law) {
            (Form::Closed, Law::Power { exponent }) => {
                part.first = builder.begin(2);
                part.outer = Outer::Power { exponent };
                self.closed_power(exponent, profile, builder)?;
            }
            (_, Law::Power { exponent }) => {
                part.outer = if exponent == 0.0 {
                    Outer::Log { coefficient: self.coefficient }
                } else {
                    Outer::Power { exponent }
                };
                self.fitted(law, &mut part, profile, builder)?;
            }
            (_, Law::Exponential { length }) => {
                let k = 1.0 / length;
                part.outer = Outer::Exponential { k };
                if D == 3 && matches!(profile, Profile::Compact { .. }) {
                    let (f, slope) = exterior_factor(self.delta / length, D, profile).ok_or(Error::Unsupported)?;
                    let plain = builder.hold(self.coefficient * f.hi)?;
                    let over_r = builder.hold(self.coefficient * self.delta * slope)?;
                    part.outer = Outer::Yukawa { k, plain, over_r };
                }
                self.fitted(law, &mut part, profile, builder)?;
            }
            (_, Law::Screened { k }) => {
                let kappa = self.delta * k;
                let (f, _) = exterior_factor(kappa, D, profile).ok_or(Error::Unsupported)?;
                part.outer = Outer::Bare { factor: builder.hold(self.coefficient * f.hi)? };
                match *profile {
                    Profile::Compact { b, .. } if kappa <= SERIES_KAPPA => {
                        part.first = builder.begin(1);
                        self.screened_series(kappa, f, &b, builder)?;
                    }
                    _ => self.fitted(law, &mut part, profile, builder)?,
                }
            }
            (_, Law::Newtonian) => return Err(Error::Unsupported),
        }
        Ok(part)
    }

    /// Even powers, and odd ones in 1D and 3D: polynomials inside, finite Laurent sums outside.
    fn closed_power(&self, p: f64, profile: &Profile, builder: &mut Builder<'_>) -> Result<()> {
        let d = self.dimension as f64;
        let zero = [DoubleWord::ZERO; 3];
        let (c, terms) = laurent(p, self.dimension, profile).ok_or(Error::Unsupported)?;
        let (less, _) = laurent(p - 2.0, self.dimension, profile).unwrap_or(([DoubleWord::ZERO; LENGTH], 0));
        let mut outside = [zero; LENGTH];
        for (n, ((slot, &c), &l)) in outside.iter_mut().zip(&c).zip(&less).take(terms).enumerate() {
            // grad r^{p-2n} = (p-2n) r^{p-2n-2} x; Laplacian(|x|^p/p) = (p+d-2) |x|^{p-2}
            *slot = [c / p, c * (p - 2.0 * n as f64) / p, l * (p + d - 2.0)];
        }
        let outside = outside.get_mut(..terms).present()?;
        let mut inside = [zero; LENGTH];
        let (variable, len) = if is_multiple(p, 2.0) {
            // the same polynomial in s: z^n s^{p/2} = s^{p/2-n}; the derivatives have one power less
            for (n, &[u, g, l]) in outside.iter().enumerate() {
                let place = terms - 1 - n;
                if let Some(slot) = inside.get_mut(place) {
                    slot[0] = u;
                }
                if let Some(slot) = place.checked_sub(1).and_then(|k| inside.get_mut(k)) {
                    (slot[1], slot[2]) = (g, l);
                }
            }
            (Variable::SquarePowers, terms)
        } else {
            let (w, laplacian, len) = odd_power(p, self.dimension, profile).ok_or(Error::Unsupported)?;
            let slopes = w.iter().skip(1).zip(1_u32..).map(|(&w, n)| w * (-2.0 * f64::from(n)));
            for (((slot, &u), g), &l) in inside.iter_mut().zip(&w).zip(slopes).zip(&laplacian) {
                *slot = [u, g, l];
            }
            (Variable::EdgePowers, len)
        };
        builder.powers(self.delta, variable, inside.get(..len).present()?, self.factors(p))?;
        // trailing exact zeros of high orders are not stored
        let used = outside.iter().rposition(|c| c.iter().any(|v| v.hi != 0.0)).map_or(0, |last| last + 1);
        let factors = [self.coefficient; 3];
        builder.powers(0.0, Variable::InversePowers, outside.get(..used).present()?, factors)
    }

    /// The screened kernel inside a compact mollifier: adds the series from the edge to the sum of such terms.
    fn screened_series(
        &self,
        kappa: f64,
        factor: DoubleWord<f64>,
        b: &[f64; TERMS],
        builder: &mut Builder<'_>,
    ) -> Result<()> {
        let source = exact(b);
        let (value, slope) = screened_edge(kappa, self.dimension, factor);
        let w = series(self.dimension, kappa, value, slope, &source, LENGTH);
        let square = DoubleWord::product(kappa, kappa);
        for (n, slot) in builder.screened.iter_mut().enumerate() {
            let at = |series: &[DoubleWord<f64>], n: usize| series.get(n).copied().unwrap_or(DoubleWord::ZERO);
            let u = at(&w, n);
            // Laplacian u = psi + k^2 u
            let laplacian = square * u + at(&source, n);
            let slope = at(&w, n + 1) * (-2.0 * (n as f64 + 1.0));
            for (sum, v) in slot.iter_mut().zip([u, slope, laplacian]) {
                *sum = *sum + v * self.coefficient;
            }
        }
        // The panel of the first term will hold the sum. Those of the others are empty.
        if builder.reserved.is_none() {
            builder.reserved = Some((builder.headers, builder.next));
            builder.next += 6 * LENGTH;
            return Ok(());
        }
        builder.powers(self.delta, Variable::EdgePowers, &[], [0.0; 3])
    }

    /// Fits inside, and outside where there is no closed form.
    fn fitted(&self, law: Law, part: &mut FittedTerm<f64>, profile: &Profile, builder: &mut Builder<'_>) -> Result<()> {
        let unit = Unit::new(law, self.dimension, self.delta, *profile);
        if unit.root > 0.0 && unit.root < ROUGHEST {
            return Err(Error::Unsupported);
        }
        part.first = builder.begin(INNER + OUTER);
        // Only e^{kappa} can be not finite here.
        let refuse = |error| if error == Error::NotFinite { Error::Unsupported } else { error };
        match profile {
            Profile::Compact { .. } => {
                part.panels = self.inside(&unit, builder).map_err(refuse)?;
                part.plain = part.panels;
                if matches!(part.outer, Outer::Power { .. } | Outer::Log { .. } | Outer::Exponential { .. }) {
                    part.panels += self.outside(&unit, builder).map_err(refuse)?;
                }
            }
            Profile::Gaussian { parts, .. } => {
                // Beyond this distance the field is the exterior solution up to e^{-43}.
                let width = |&(w, c): &(f64, f64)| if w == 0.0 { 0.0 } else { c * (REACH + 0.5 * unit.kappa * c) };
                let end = parts.iter().map(width).fold(0.0, f64::max);
                (part.panels, part.plain) = self.octaves(&unit, end, builder).map_err(refuse)?;
            }
        }
        Ok(())
    }

    /// The factors from units of delta: powers scale as delta^p, exponentials as delta^0, screened kernels as delta^(2-d).
    fn law_factors(&self, law: Law) -> [f64; 3] {
        match law {
            Law::Power { exponent } => self.factors(exponent),
            Law::Exponential { .. } => self.factors(0.0),
            Law::Screened { .. } | Law::Newtonian => self.factors(2.0 - self.dimension as f64),
        }
    }

    /// As [`Task::law_factors`], for functions relative to the bare kernel.
    fn outer_factors(&self, law: Law) -> [f64; 3] {
        match law {
            Law::Exponential { .. } => [self.power(0.0), self.power(-1.0), self.power(-2.0)],
            _ => [self.coefficient; 3],
        }
    }

    /// Fits panels inside a compact mollifier, from the centre to the edge, and returns their number.
    fn inside(&self, unit: &Unit, builder: &mut Builder<'_>) -> Result<usize> {
        // The start of a panel that ends at t = `high`, as a fraction of `high`. Longer panels are tried first.
        const STEPS: [f64; 7] = [0.0, 0.25, 0.5, 0.7, 0.84, 0.92, 0.96];
        let factors = self.law_factors(unit.law);
        let (mut high, mut first) = (1.0, 0);
        for panel in 1..=INNER {
            // the last panel must reach the end
            let steps = if panel == INNER { 0..1 } else { first..STEPS.len() };
            let mut found = None;
            for (index, &step) in STEPS.iter().enumerate().skip(steps.start).take(steps.len()) {
                let low = step * high;
                let (axis, fit) = if index == 0 {
                    let axis = Axis::edge(Variable::Edge, unit.root, high);
                    (axis, fit(|x| unit.inside(Target::inside(axis.t(x).min(high)), self.delta))?)
                } else {
                    let axis = Axis::between(Variable::Edge, 1.0, low, high);
                    (axis, fit(|x| unit.inside(Target::inside(low + 0.5 * (high - low) * (x + 1.0)), self.delta))?)
                };
                if fit.good || panel == INNER && fit.len > 0 {
                    found = Some((index, low, axis, fit));
                    break;
                }
            }
            let (index, low, axis, fit) = found.ok_or(Error::Unsupported)?;
            builder.fitted(self.delta * (1.0 - low).sqrt(), axis, &fit, factors)?;
            if index == 0 {
                return Ok(panel);
            }
            (high, first) = (low, index - 1);
        }
        Err(Error::Unsupported)
    }

    /// Fits panels outside, of functions relative to the bare kernel, from the edge to infinity. Returns the number of bounded panels.
    fn outside(&self, unit: &Unit, builder: &mut Builder<'_>) -> Result<usize> {
        // The end of a panel from the edge, and of one that begins at t = `low` in units of `low`.
        const EDGE: [f64; 5] = [1.0, 0.25, 0.0625, 0.015_625, 0.003_906_25];
        const STEPS: [f64; 4] = [f64::INFINITY, 4.0, 2.0, 1.4];
        let reciprocal = matches!(unit.law, Law::Exponential { .. });
        let target = |t: f64| if reciprocal { Target::reciprocal(t) } else { Target::outside(t) };
        let (edge, inner) = if reciprocal {
            (Variable::ReciprocalEdge, Variable::Reciprocal)
        } else {
            (Variable::InverseEdge, Variable::Inverse)
        };
        let factors = self.outer_factors(unit.law);
        let mut low = 0.0;
        for panel in 0..OUTER {
            let mut found = None;
            for index in 0..EDGE.len() {
                let (high, axis, fit) = if low == 0.0 {
                    let high = EDGE.get(index).copied().unwrap_or(1.0);
                    let axis = Axis::edge(edge, unit.root, high);
                    (high, axis, fit(|x| unit.outside(target(axis.t(x).min(high))))?)
                } else {
                    let Some(step) = STEPS.get(index) else { break };
                    let high = (step * low).min(1.0);
                    let axis = Axis::between(inner, 1.0, 1.0 - low, 1.0 - high);
                    (high, axis, fit(|x| unit.outside(target(low + 0.5 * (high - low) * (x + 1.0))))?)
                };
                if fit.good {
                    found = Some((high, axis, fit));
                    break;
                }
            }
            let (high, axis, fit) = found.ok_or(Error::Unsupported)?;
            builder.fitted(self.delta * target(high).r(), axis, &fit, factors)?;
            if high == 1.0 {
                return Ok(panel);
            }
            low = high;
        }
        Err(Error::Unsupported)
    }

    /// Fits panels of at most an octave under a Gaussian mollifier, up to `end` in units of delta, and one outside where there is no closed
    /// form. Returns the number of bounded panels, and of those that hold the function itself.
    fn octaves(&self, unit: &Unit, end: f64, builder: &mut Builder<'_>) -> Result<(usize, usize)> {
        const STEPS: [f64; 5] = [2.0, 1.42, 1.2, 1.1, 1.05];
        // Beyond the first panels powers are fitted relative to the bare ones, whatever their size.
        let relative = matches!(unit.law, Law::Power { .. });
        let (factors, outer_factors) = (self.law_factors(unit.law), self.outer_factors(unit.law));
        let (mut from, mut plain) = (0.0, 0);
        for panel in 0..=INNER {
            let outer = relative && from >= 1.0;
            if from >= end {
                let axis = match unit.law {
                    Law::Screened { .. } => return Ok((panel, panel)),
                    Law::Exponential { .. } => Axis::between(Variable::Reciprocal, 1.0, 0.0, 1.0 / from),
                    _ => Axis::between(Variable::Inverse, 1.0, 0.0, 1.0 / (from * from)),
                };
                let exponential = axis.variable == Variable::Reciprocal;
                let fit = fit(|x| {
                    let v = (0.5 * (x + 1.0)).max(1e-16);
                    unit.outside(Target::at(from / if exponential { v } else { v.sqrt() }))
                })?;
                builder.fitted(0.0, axis, &fit, outer_factors)?;
                return Ok((panel, if relative { plain } else { panel }));
            }
            let mut found = None;
            for step in STEPS {
                let to = if from == 0.0 { 0.5 * step } else { step * from };
                // the relative functions begin at 1
                let to: f64 = if relative && from < 1.0 { to.min(1.0) } else { to };
                let (low, high) = (from * from, to * to);
                let fit = fit(|x| {
                    let target = Target::at((low + 0.5 * (high - low) * (x + 1.0)).sqrt());
                    if outer { unit.outside(target) } else { unit.inside(target, self.delta) }
                })?;
                if fit.good {
                    found = Some((to, Axis::between(Variable::Square, 1.0, low, high), fit));
                    break;
                }
            }
            let (to, axis, fit) = found.ok_or(Error::Unsupported)?;
            builder.fitted(to * self.delta, axis, &fit, if outer { outer_factors } else { factors })?;
            from = to;
            plain += usize::from(!outer);
        }
        Err(Error::Unsupported)
    }
}

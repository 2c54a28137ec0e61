//! Preparation of one term: the choice of its closed form or fit, and its tables.
//!
//! A fit is divided into panels. On each, no function's size changes by more than a factor of 64, because roundings are relative to the
//! largest size on the panel. Sizes are those of the convolution ([`Sample`]) or of the bare kernel at the mollifier's length, whichever is larger.

use core::cell::Cell;

use super::chebyshev::{CAPACITY, Fit, fit};
use super::convolution::{Convolution, REACH, Sample, Target};
use super::edge_series::{LENGTH, exact, exterior_factor, laurent, odd_power, screened_edge, series};
use super::law::{Law, RadialKernel, is_multiple};
use super::part::{HEADER, Outer, Panel, Part, Variable, rooted};
use super::profile::{Profile, TERMS, sphere};
use crate::checked::Present;
use crate::error::{Error, Result};
use crate::real::{DoubleWord, Scalar};

/// Most panels of a fit: inside (for a Gaussian mollifier up to where its field is the exterior one), and outside.
const INNER: usize = 24;
const OUTER: usize = 8;
/// Capacity for the coefficients of both, in triples. Most panels need 20 to 30.
const TRIPLES: usize = 560;
/// Most octaves of a user's kernel.
pub(crate) const USER_OCTAVES: usize = 40;
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
        Form::Supplied => (USER_OCTAVES + 2) * (HEADER + 3 * CAPACITY),
    }
}

/// The variable of a Chebyshev series: `scale` and `shift` map it to [-1, 1] after its power `root` is taken.
#[derive(Clone, Copy)]
struct Axis {
    variable: Variable,
    scale: f64,
    shift: f64,
    root: f64,
}

impl Axis {
    /// From v = `from` to v = `to`.
    fn between(variable: Variable, root: f64, from: f64, to: f64) -> Self {
        let scale = 2.0 / (to - from);
        Self { variable, scale, shift: -1.0 - from * scale, root }
    }

    /// From t = 0, at the edge, to t = `to`.
    fn edge(variable: Variable, root: f64, to: f64) -> Self {
        Self::between(variable, root, if root == 0.0 { rooted(0.0, root) } else { 0.0 }, rooted(to, root))
    }

    fn powers(variable: Variable) -> Self {
        Self { variable, scale: 0.0, shift: 0.0, root: 1.0 }
    }

    /// t at x on an axis from the edge.
    fn t(&self, x: f64) -> f64 {
        let v = ((x - self.shift) / self.scale).max(if self.root == 0.0 { f64::NEG_INFINITY } else { 0.0 });
        if self.root == 0.0 {
            Scalar::exp(v)
        } else if self.root == 0.5 {
            v * v
        } else if self.root == 0.25 {
            (v * v) * (v * v)
        } else {
            Scalar::pow(v, 1.0 / self.root)
        }
    }
}

/// Writes the tables of successive parts.
pub(crate) struct Builder<'a> {
    tables: &'a mut [f64],
    headers: usize,
    next: usize,
    /// The largest error of a fit, relative to the function's size on its panel.
    pub(crate) error: f64,
    /// An upper bound of the panels' ends.
    limit: f64,
    /// The largest coefficient that the sum's scalar can hold.
    largest: f64,
    /// The sum of all screened terms inside a compact mollifier, in powers of t and units of delta, and its reserved place in the tables. For
    /// small delta psi and the Newtonian parts of the terms are large and cancel in a Morse potential, so they are added before rounding.
    screened: [[DoubleWord<f64>; 3]; LENGTH],
    reserved: Option<(usize, usize)>,
}

impl<'a> Builder<'a> {
    pub(crate) fn new(tables: &'a mut [f64], largest: f64) -> Self {
        Self {
            tables,
            headers: 0,
            next: 0,
            error: 0.0,
            limit: f64::INFINITY,
            largest,
            screened: [[DoubleWord::ZERO; 3]; LENGTH],
            reserved: None,
        }
    }

    /// Reserves headers for a part and returns the position of the first.
    fn begin(&mut self, panels: usize) -> usize {
        self.headers = self.next;
        self.next += panels * HEADER;
        self.headers
    }

    /// Returns an error for a number that the sum's scalar cannot hold.
    fn hold(&self, value: f64) -> Result<f64> {
        if value.abs() <= self.largest { Ok(value) } else { Err(Error::OutOfDomain) }
    }

    /// Stores a panel's header.
    fn header(&mut self, end: f64, axis: Axis, start: usize, len: usize) -> Result<()> {
        let Axis { variable, scale, shift, root } = axis;
        let header = Panel { end: end.min(self.limit), variable, start, len, scale, shift, root };
        let place = self.tables.get_mut(self.headers..).and_then(|t| t.first_chunk_mut::<HEADER>());
        *place.ok_or(Error::Unsupported)? = header.to_header();
        self.headers += HEADER;
        Ok(())
    }

    /// Reserves the next triples of the tables.
    fn triples(&mut self, len: usize) -> Result<&mut [[f64; 3]]> {
        let free = self.tables.get_mut(self.next..).ok_or(Error::Unsupported)?;
        self.next += 3 * len;
        free.as_chunks_mut::<3>().0.get_mut(..len).ok_or(Error::Unsupported)
    }

    /// Stores a panel of powers in two words: coefficients times `factors`.
    fn powers(
        &mut self,
        end: f64,
        variable: Variable,
        coefficients: &[[DoubleWord<f64>; 3]],
        factors: [f64; 3],
    ) -> Result<()> {
        let (len, start) = (coefficients.len(), self.next);
        let mut low = [[0.0; 3]; LENGTH];
        for (k, c) in coefficients.iter().enumerate() {
            let mut high = [0.0; 3];
            for (n, (slot, (&c, factor))) in high.iter_mut().zip(c.iter().zip(factors)).enumerate() {
                let product = c * factor;
                *slot = self.hold(product.hi)?;
                if let Some(low) = low.get_mut(k).and_then(|low| low.get_mut(n)) {
                    // the second word is invalid where the product leaves the normal range
                    *low = if product.lo.is_finite() { product.lo } else { 0.0 };
                }
            }
            for slot in self.triples(1)? {
                *slot = high;
            }
        }
        self.triples(len)?.iter_mut().zip(low).for_each(|(slot, low)| *slot = low);
        self.header(end, Axis::powers(variable), start, len)
    }

    /// Stores a fit: coefficients times `factors`.
    fn fitted(&mut self, end: f64, axis: Axis, fit: &Fit, factors: [f64; 3]) -> Result<()> {
        let (len, start) = (fit.len, self.next);
        for c in fit.coefficients.iter().take(len) {
            let [u, g, l] = factors;
            let c = [self.hold(c[0] * u)?, self.hold(c[1] * g)?, self.hold(c[2] * l)?];
            self.triples(1)?.iter_mut().for_each(|slot| *slot = c);
        }
        self.error = self.error.max(fit.error);
        self.header(end, axis, start, len)
    }

    /// Writes the sum of the screened terms to its reserved place. Must be called once, after all terms.
    pub(crate) fn finish(&mut self, dimension: usize, delta: f64) -> Result<()> {
        let Some((headers, start)) = self.reserved else { return Ok(()) };
        let a = 2.0 - dimension as f64;
        let s = sphere(dimension);
        let factors = [Scalar::pow(delta, a) / s, Scalar::pow(delta, a - 2.0) / s, Scalar::pow(delta, a - 2.0) / s];
        let screened = self.screened;
        let size = screened
            .iter()
            .fold([0.0_f64; 3], |m, c| [m[0].max(c[0].hi.abs()), m[1].max(c[1].hi.abs()), m[2].max(c[2].hi.abs())]);
        let matters = |c: &[DoubleWord<f64>; 3]| c.iter().zip(size).any(|(v, s)| v.hi.abs() > 1e-18 * s);
        let len = screened.iter().rposition(matters).map_or(1, |last| last + 1);
        let (keep_headers, keep_next) = (self.headers, self.next);
        (self.headers, self.next) = (headers, start);
        self.powers(delta, Variable::EdgePowers, screened.get(..len).present()?, factors)?;
        (self.headers, self.next) = (keep_headers, keep_next);
        Ok(())
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
    pub(crate) fn prepare<const D: usize>(&self, law: Law, builder: &mut Builder<'_>) -> Result<Part<f64>> {
        let outer = Outer::Bare { factor: self.coefficient };
        let mut part = Part { law, radius: self.delta, panels: 1, plain: 1, first: 0, outer };
        let Some(profile) = self.profile else {
            return Ok(Part { radius: 0.0, panels: 0, plain: 0, ..part });
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
    fn fitted(&self, law: Law, part: &mut Part<f64>, profile: &Profile, builder: &mut Builder<'_>) -> Result<()> {
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

    /// A fit in r^2 on [from, to], in units of delta, for a user's kernel.
    fn square_panel(
        &self,
        from: f64,
        to: f64,
        factors: [f64; 3],
        sample: &dyn Fn(Target) -> Option<Sample>,
        builder: &mut Builder<'_>,
    ) -> Result<()> {
        let (low, high) = (from * from, to * to);
        let half = 0.5 * (high - low);
        let fit = fit(|x| sample(Target::at((low + half * (x + 1.0)).sqrt())))?;
        builder.fitted(to * self.delta, Axis::between(Variable::Square, 1.0, low, high), &fit, factors)
    }

    /// Prepares a user's kernel, up to `reach`.
    pub(crate) fn supplied(
        &self,
        kernel: &dyn RadialKernel,
        reach: f64,
        builder: &mut Builder<'_>,
    ) -> Result<Part<f64>> {
        let law = Law::Newtonian;
        builder.limit = reach;
        let Some(profile) = self.profile else {
            // octaves from the reach downwards, in units of the reach
            let unit = Task { delta: reach, ..*self };
            let first = builder.begin(USER_OCTAVES);
            let factors = [self.coefficient; 3];
            let mut to = 1.0 / power_of_two(USER_OCTAVES);
            let least = to * reach;
            let sample = |target: Target| even(kernel.at(reach * target.r()));
            for _ in 0..USER_OCTAVES {
                unit.square_panel(to, 2.0 * to, factors, &sample, builder)?;
                to *= 2.0;
            }
            let outer = Outer::Clamped { least };
            return Ok(Part { law, radius: reach, panels: USER_OCTAVES, plain: USER_OCTAVES, first, outer });
        };
        let convolution = Convolution::new(self.dimension, *profile, 0.0);
        let square = self.delta * self.delta;
        // the integrals may skip values, but a kernel that is not finite anywhere it is called is refused
        let finite = Cell::new(true);
        let call = |q: f64| {
            let [u, g, l] = kernel.at(self.delta * q);
            finite.set(finite.get() && u.is_finite() && g.is_finite() && l.is_finite());
            let volume = Scalar::powi(q, self.dimension.saturating_sub(1) as u32);
            [volume * u, volume * square * g * q, volume * square * l]
        };
        let inside = |target| even(convolution.at(target, true, &mut |q, _| call(q))?.values);
        let outside = |target| even(convolution.at(target, false, &mut |q, _| call(q))?.values);
        let factors = self.factors(0.0);
        let span = reach / self.delta;
        let compact = matches!(profile, Profile::Compact { .. });
        let mut to: f64 = 1.0;
        let panels = 1 + octaves_to((span / to).max(1.0));
        if panels > USER_OCTAVES + 1 {
            return Err(Error::Unsupported);
        }
        let first = builder.begin(panels);
        if compact {
            // The kernel's singularity at 0 is not known, so the root with the smaller error is used.
            let edge = |root: f64| {
                let axis = Axis::edge(Variable::Edge, root, 1.0);
                fit(|x| inside(Target::inside(axis.t(x).min(1.0)))).map(|fit| (axis, fit))
            };
            let mut best = edge(0.5)?;
            if best.1.error > 1e-14 {
                let other = edge(0.25)?;
                best = if other.1.error < best.1.error { other } else { best };
            }
            builder.fitted(self.delta, best.0, &best.1, factors)?;
        } else {
            self.square_panel(0.0, to, factors, &inside, builder)?;
        }
        for index in 1..panels {
            if compact && index == 1 {
                // v = sqrt(rho^2 - 1) in [0, sqrt 3]: the edge from outside
                let span = 3.0_f64.sqrt();
                let fit = fit(|x| {
                    let v = 0.5 * span * (x + 1.0);
                    outside(Target::at((1.0 + v * v).sqrt()))
                })?;
                builder.fitted(2.0 * self.delta, Axis::between(Variable::Outside, 0.5, 0.0, span), &fit, factors)?;
            } else if compact {
                self.square_panel(to, 2.0 * to, factors, &outside, builder)?;
            } else {
                self.square_panel(to, 2.0 * to, factors, &inside, builder)?;
            }
            to *= 2.0;
        }
        if !finite.get() {
            return Err(Error::NotFinite);
        }
        Ok(Part { law, radius: self.delta, panels, plain: panels, first, outer: Outer::Zero })
    }
}

/// A sample with sizes 1, which disables the test of sizes.
fn even(values: [f64; 3]) -> Option<Sample> {
    values.iter().all(|v| v.is_finite()).then_some(Sample { values, sizes: [1.0; 3] })
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

/// A law and a mollifier in units of delta.
struct Unit {
    law: Law,
    dimension: usize,
    profile: Profile,
    convolution: Convolution,
    /// delta / length, or k delta.
    kappa: f64,
    /// Whether the Laplacian is too singular to convolve.
    weak: bool,
    /// The power of t in which the functions are smooth at a compact mollifier's edge; 0 means log t.
    root: f64,
    /// Magnitudes at delta: of the bare kernel, and of the functions outside.
    least: [f64; 3],
    least_outside: [f64; 3],
}

impl Unit {
    fn new(law: Law, dimension: usize, delta: f64, profile: Profile) -> Self {
        let d = dimension as f64;
        let (kappa, weak) = match law {
            Law::Exponential { length } => (delta / length, false),
            Law::Screened { k } => (delta * k, false),
            Law::Power { exponent } => (0.0, exponent < 2.5 - d),
            Law::Newtonian => (0.0, true),
        };
        let convolution = Convolution::new(dimension, profile, kappa);
        let (root, least) = (edge_root(law, d, profile), [0.0; 3]);
        let mut unit = Self { law, dimension, profile, convolution, kappa, weak, root, least, least_outside: least };
        unit.least = magnitudes(unit.bare(1.0));
        unit.least_outside = magnitudes(unit.relative(1.0, 0.0, 1.0, false));
        if law == (Law::Power { exponent: 0.0 }) {
            (unit.least[0], unit.least_outside[0]) = (1.0, 1.0);
        }
        unit
    }

    /// K, K' and the Laplacian at q, times q^(d-1).
    fn bare(&self, q: f64) -> [f64; 3] {
        let d = self.dimension as f64;
        if let Law::Power { exponent: p } = self.law {
            let slope = Scalar::pow(q, p + d - 2.0);
            let value =
                if p == 0.0 { Scalar::powi(q, self.dimension as u32 - 1) * Scalar::log(q) } else { slope * q / p };
            // the Laplacian is not used where it is too singular
            return [value, slope, if self.weak { 0.0 } else { (p + d - 2.0) * slope / q }];
        }
        let law = match self.law {
            Law::Exponential { .. } => Law::Exponential { length: 1.0 / self.kappa },
            Law::Screened { .. } => Law::Screened { k: self.kappa },
            law @ (Law::Newtonian | Law::Power { .. }) => law,
        };
        let [value, gradient, laplacian] = match self.dimension {
            1 => law.bare::<f64, 1>(q),
            2 => law.bare::<f64, 2>(q),
            _ => law.bare::<f64, 3>(q),
        };
        let volume = Scalar::powi(q, self.dimension as u32 - 1);
        [value * volume, gradient * q * volume, laplacian * volume]
    }

    /// The function itself.
    fn inside(&self, target: Target, delta: f64) -> Option<Sample> {
        let mut sample = self.convolution.at(target, self.weak, &mut |q, _| self.bare(q))?;
        match self.law {
            Law::Power { exponent: 0.0 } => sample.values[0] += Scalar::log(delta),
            Law::Screened { .. } => {
                // Laplacian u = psi + k^2 u
                let psi = self.profile.density(self.dimension, target.r(), target.t());
                let square = self.kappa * self.kappa;
                sample.values[2] = psi + square * sample.values[0];
                sample.sizes[2] = psi.abs() + square * sample.sizes[0];
            }
            _ => {}
        }
        sample.sizes.iter_mut().zip(self.least).for_each(|(size, least)| *size = size.max(least));
        Some(sample)
    }

    /// The function relative to the bare kernel at the target: divided by r^p, r^(p-2), r^(p-2) for powers (minus log r for the logarithm), by
    /// e^{-kappa r} (1, 1/r, 1) for exponentials.
    fn outside(&self, target: Target) -> Option<Sample> {
        let rho = target.r();
        // Next to the edge q still reaches 0. Further out grad psi would only add cancellation.
        let near = match self.profile {
            Profile::Compact { .. } => rho < 1.5,
            Profile::Gaussian { parts, .. } => {
                rho < parts.iter().fold(0.0, |most: f64, &(w, c)| if w == 0.0 { most } else { most.max(c) }) * REACH
            }
        };
        let weak = self.weak && near;
        let mut sample = self.convolution.at(target, weak, &mut |q, y| self.relative(q, y, rho, weak))?;
        sample.sizes.iter_mut().zip(self.least_outside).for_each(|(size, least)| *size = size.max(least));
        Some(sample)
    }

    /// The bare kernel K, K' and its Laplacian at q = rho + y, times q^(d-1), scaled as in [`Unit::outside`].
    fn relative(&self, q: f64, y: f64, rho: f64, weak: bool) -> [f64; 3] {
        let d = self.dimension as f64;
        let volume = |x: f64| Scalar::powi(x, self.dimension as u32 - 1);
        match self.law {
            Law::Power { exponent: p } => {
                // next to the edge 1 + y/rho would be 0 for tiny q
                let near = y < -0.5 * rho;
                let ratio = if near { q / rho } else { 1.0 + y / rho };
                // K'/rho^(p-2) q^(d-1) = ratio^(p+d-2) rho^d
                let power = Scalar::pow(ratio, p + d - 2.0) * volume(rho);
                let value = match (p == 0.0, near) {
                    (true, true) => volume(q) * Scalar::log(ratio),
                    (true, false) => volume(q) * (y / rho).log1p(),
                    _ => power * ratio / p,
                };
                [value, power * rho, if weak { 0.0 } else { (p + d - 2.0) * power / ratio }]
            }
            _ => {
                let e = Scalar::exp(-(self.kappa * y)) * volume(q);
                let slope = -self.kappa * e;
                [e, slope * rho, self.kappa * self.kappa * e + (d - 1.0) * slope / q]
            }
        }
    }
}

/// Magnitudes of value, gradient factor and Laplacian. The Laplacian's is at least the gradient factor's, as it may vanish.
fn magnitudes([value, gradient, laplacian]: [f64; 3]) -> [f64; 3] {
    [value.abs(), gradient.abs(), laplacian.abs().max(gradient.abs())]
}

/// The power of t in which K_delta is smooth enough at the edge for a Chebyshev series. In t it is smooth except for terms t^(a + j),
/// j = 0, 1, ..., times log t for integer a. a = M + p + d - 2 in the Laplacian and one more in each integral of it; for exponentials p = 1,
/// or no such terms in 1D and 3D. v = t^(1/2) leaves coefficients like n^-(4 a + 1), v = t^(a/m) gives powers v^m and v^(m/a).
fn edge_root(law: Law, d: f64, profile: Profile) -> f64 {
    let Profile::Compact { exponent, .. } = profile else { return 1.0 };
    let a = f64::from(exponent) - 2.0
        + match law {
            Law::Power { exponent: p } => p + d,
            Law::Exponential { .. } if d == 2.0 => 1.0 + d,
            _ => return 1.0,
        };
    if a >= 2.5 {
        0.5
    } else if a >= 1.0 {
        0.25
    } else if a > 0.0 {
        a / (5.0 * a).ceil()
    } else {
        0.0
    }
}

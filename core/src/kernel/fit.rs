//! Preparing one term: which closed form or fit serves it, and its tables.

use core::cell::Cell;

use super::chebyshev::{CAPACITY, Fit, fit};
use super::convolution::{Convolution, REACH};
use super::edge_series::{LENGTH, exact, exterior_factor, laurent, odd_power, series};
use super::law::{Law, RadialKernel, is_multiple};
use super::part::{HEADER, Outer, Panel, Part, Variable};
use super::profile::{Profile, TERMS, horner, sphere};
use crate::error::{Error, Result};
use crate::real::{DoubleWord, Real};

/// Most panels inside for a Gaussian: [0, 1], [1, 2], [2, 4], ... [256, 512] in units of delta.
const GAUSSIAN_PANELS: usize = 10;
/// Most coefficients of each.
const GAUSSIAN_CAPACITY: usize = 64;
/// Most octaves of a user's kernel.
pub(crate) const USER_OCTAVES: usize = 40;
/// Up to this kappa the series from the edge loses less than a digit.
const SERIES_KAPPA: f64 = 3.0;

/// How a term will be represented: decided by the law, the mollifier's kind and the dimension alone, so that sizes are
/// known before delta is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Form {
    /// The bare law: no tables.
    Bare,
    /// Powers inside and outside.
    Closed,
    /// One fit inside and one outside.
    Fitted,
    /// Fits on octaves and one outside.
    Gaussian,
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
    match profile {
        Profile::Compact { .. } => Form::Fitted,
        Profile::Gaussian { .. } => Form::Gaussian,
    }
}

/// Numbers that a term's tables may take.
pub(crate) fn capacity(law: Option<Law>, profile: Option<&Profile>, dimension: usize) -> usize {
    let (panels, each) = match law.map_or(Form::Supplied, |law| form(law, profile, dimension)) {
        Form::Bare => return 0,
        Form::Closed => (2, LENGTH),
        Form::Fitted => (2, CAPACITY),
        Form::Gaussian => (GAUSSIAN_PANELS + 1, GAUSSIAN_CAPACITY),
        Form::Supplied => (USER_OCTAVES + 2, GAUSSIAN_CAPACITY),
    };
    panels * (HEADER + 3 * each)
}

/// Writes the tables of one part after another.
pub(crate) struct Builder<'a, T> {
    tables: &'a mut [T],
    headers: usize,
    next: usize,
    /// The largest part that a fit misses, relative to the largest coefficient of this and the panels inside of it.
    pub(crate) error: f64,
    size: [f64; 3],
    /// No panel reaches further.
    limit: f64,
    /// The sum of all screened terms inside a compact mollifier, in powers of t and units of delta, and the place reserved
    /// for it: psi and the Newtonian part of each, large at small delta, cancel in a Morse potential before they round.
    screened: [[DoubleWord<f64>; 3]; LENGTH],
    reserved: Option<(usize, usize)>,
}

impl<'a, T: Real> Builder<'a, T> {
    pub(crate) fn new(tables: &'a mut [T]) -> Self {
        Self {
            tables,
            headers: 0,
            next: 0,
            error: 0.0,
            size: [0.0; 3],
            limit: f64::INFINITY,
            screened: [[DoubleWord::ZERO; 3]; LENGTH],
            reserved: None,
        }
    }

    /// Reserves headers for a part; answers with the place of the first.
    fn begin(&mut self, panels: usize) -> usize {
        self.headers = self.next;
        self.size = [0.0; 3];
        self.next += panels * HEADER;
        self.headers
    }

    /// Stores a panel: coefficients times `factors`, `scale` and `shift` of its variable.
    fn panel(
        &mut self,
        end: f64,
        (variable, scale, shift): (Variable, f64, f64),
        coefficients: &[[f64; 3]],
        factors: [f64; 3],
    ) -> Result<()> {
        let real = |x: f64| T::from_f64(x);
        let len = coefficients.len();
        let start = self.next;
        let room = self.tables.get_mut(start..).ok_or(Error::WorkspaceTooSmall)?;
        let (triples, _) = room.as_chunks_mut::<3>();
        let slots = triples.get_mut(..len).ok_or(Error::WorkspaceTooSmall)?;
        for (slot, c) in slots.iter_mut().zip(coefficients) {
            *slot = [real(c[0] * factors[0]), real(c[1] * factors[1]), real(c[2] * factors[2])];
            if slot.iter().any(|v| !v.is_finite()) {
                return Err(Error::OutOfDomain);
            }
        }
        self.next += 3 * len;
        let header =
            Panel { end: real(end.min(self.limit)), variable, start, len, scale: real(scale), shift: real(shift) };
        let place = self.tables.get_mut(self.headers..).and_then(|t| t.first_chunk_mut::<HEADER>());
        *place.ok_or(Error::WorkspaceTooSmall)? = header.to_header();
        self.headers += HEADER;
        Ok(())
    }

    /// Writes the sum of the screened terms into its reserved place. Call once, after all terms.
    pub(crate) fn finish(&mut self, dimension: usize, delta: f64) -> Result<()> {
        let Some((headers, start)) = self.reserved else { return Ok(()) };
        let a = 2.0 - dimension as f64;
        let s = sphere(dimension);
        let factors = [Real::pow(delta, a) / s, Real::pow(delta, a - 2.0) / s, Real::pow(delta, a - 2.0) / s];
        let rounded = self.screened.map(|c| c.map(|v| v.hi));
        let size = rounded
            .iter()
            .fold([0.0_f64; 3], |m, c| [m[0].max(c[0].abs()), m[1].max(c[1].abs()), m[2].max(c[2].abs())]);
        let matters = |c: &[f64; 3]| c.iter().zip(size).any(|(v, s)| v.abs() > 1e-18 * s);
        let len = rounded.iter().rposition(matters).map_or(1, |last| last + 1);
        let (keep_headers, keep_next) = (self.headers, self.next);
        (self.headers, self.next) = (headers, start);
        self.panel(delta, (Variable::EdgePowers, 0.0, 0.0), rounded.get(..len).unwrap_or(&[]), factors)?;
        (self.headers, self.next) = (keep_headers, keep_next);
        Ok(())
    }

    fn fitted(&mut self, end: f64, variable: (Variable, f64, f64), fit: &Fit, factors: [f64; 3]) -> Result<()> {
        for (k, (size, (&largest, factor))) in self.size.iter_mut().zip(fit.size.iter().zip(factors)).enumerate() {
            *size = size.max(largest * factor.abs());
            let missed = fit.missed.get(k).copied().unwrap_or(0.0) * factor.abs();
            if *size > 0.0 {
                self.error = self.error.max(missed / *size);
            }
        }
        self.panel(end, variable, fit.coefficients.get(..fit.len).unwrap_or(&[]), factors)
    }
}

/// Everything that preparing one term needs.
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

    /// The factors that bring value, gradient factor and Laplacian from units of delta, where the value scales as delta^a.
    fn factors(&self, a: f64) -> [f64; 3] {
        [self.power(a), self.power(a - 2.0), self.power(a - 2.0)]
    }

    /// Prepares a known law, which is canonical and not Newtonian.
    pub(crate) fn prepare<T: Real, const D: usize>(&self, law: Law, builder: &mut Builder<'_, T>) -> Result<Part<T>> {
        let Some(profile) = self.profile else {
            let outer = Outer::Bare { factor: T::from_f64(self.coefficient) };
            return Ok(Part { law, radius: T::ZERO, panels: 0, first: 0, outer });
        };
        let mut part = Part {
            law,
            radius: T::from_f64(self.delta),
            panels: 1,
            first: 0,
            outer: Outer::Bare { factor: T::from_f64(self.coefficient) },
        };
        match (form(law, Some(profile), D), law) {
            (Form::Closed, Law::Power { exponent }) => {
                part.first = builder.begin(2);
                part.outer = Outer::Power { exponent };
                self.closed_power(exponent, profile, builder)?;
            }
            (_, Law::Power { exponent }) => {
                part.outer = if exponent == 0.0 {
                    Outer::Log { coefficient: T::from_f64(self.coefficient) }
                } else {
                    Outer::Power { exponent }
                };
                self.fitted(law, &mut part, profile, builder)?;
            }
            (_, Law::Exponential { length }) => {
                let kappa = self.delta / length;
                let k = 1.0 / length;
                part.outer = Outer::Exponential { k: T::from_f64(k) };
                if D == 3 && matches!(profile, Profile::Compact { .. }) {
                    let (f, slope) = exterior_factor(kappa, D, profile).ok_or(Error::Unsupported)?;
                    let real = |x: f64| T::from_f64(self.coefficient * x);
                    part.outer = Outer::Yukawa { k: T::from_f64(k), plain: real(f), over_r: real(self.delta * slope) };
                }
                self.fitted(law, &mut part, profile, builder)?;
            }
            (_, Law::Screened { k }) => {
                let kappa = self.delta * k;
                let (f, _) = exterior_factor(kappa, D, profile).ok_or(Error::Unsupported)?;
                part.outer = Outer::Bare { factor: T::from_f64(self.coefficient * f) };
                match *profile {
                    Profile::Compact { b, .. } if kappa <= SERIES_KAPPA => {
                        part.first = builder.begin(1);
                        self.screened_series::<T, D>(kappa, f, &b, builder)?;
                    }
                    _ => self.fitted(law, &mut part, profile, builder)?,
                }
            }
            (_, Law::Newtonian) => return Err(Error::Unsupported),
        }
        Ok(part)
    }

    /// Even powers, and odd ones in 1D and 3D: polynomials inside, finite Laurent sums outside.
    fn closed_power<T: Real>(&self, p: f64, profile: &Profile, builder: &mut Builder<'_, T>) -> Result<()> {
        let d = self.dimension as f64;
        let (c, terms) = laurent(p, self.dimension, profile).ok_or(Error::Unsupported)?;
        let (less, _) = laurent(p - 2.0, self.dimension, profile).unwrap_or(([DoubleWord::ZERO; LENGTH], 0));
        let mut outside = [[0.0; 3]; LENGTH];
        for (n, ((slot, &c), &l)) in outside.iter_mut().zip(&c).zip(&less).take(terms).enumerate() {
            // grad r^{p-2n} = (p-2n) r^{p-2n-2} x; Laplacian(|x|^p/p) = (p+d-2) |x|^{p-2}
            *slot = [(c / p).hi, (c * (p - 2.0 * n as f64) / p).hi, (l * (p + d - 2.0)).hi];
        }
        let outside = outside.get_mut(..terms).unwrap_or(&mut []);
        let mut inside = [[0.0; 3]; LENGTH];
        let (variable, len) = if is_multiple(p, 2.0) {
            // the same polynomial in s: z^n s^{p/2} = s^{p/2-n}, one power less for the derivatives
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
            let slopes = w.iter().skip(1).zip(1_u32..).map(|(&w, n)| -2.0 * f64::from(n) * w.hi);
            for (((slot, &u), g), &l) in inside.iter_mut().zip(&w).zip(slopes).zip(&laplacian) {
                *slot = [u.hi, g, l.hi];
            }
            (Variable::EdgePowers, len)
        };
        builder.panel(self.delta, (variable, 0.0, 0.0), inside.get(..len).unwrap_or(&[]), self.factors(p))?;
        // the exact zeros of high orders need no multiplications
        let used = outside.iter().rposition(|c| c.iter().any(|&v| v != 0.0)).map_or(0, |last| last + 1);
        let factors = [self.coefficient; 3];
        builder.panel(0.0, (Variable::InversePowers, 0.0, 0.0), outside.get(..used).unwrap_or(&[]), factors)
    }

    /// The screened kernel inside a compact mollifier: the series from the edge, added to the sum of such terms.
    fn screened_series<T: Real, const D: usize>(
        &self,
        kappa: f64,
        f: f64,
        b: &[f64; TERMS],
        builder: &mut Builder<'_, T>,
    ) -> Result<()> {
        let s = sphere(D);
        let [value, gradient, _] = Law::Screened { k: kappa }.bare::<f64, D>(1.0);
        let source = exact(b);
        let edge = |v: f64| DoubleWord::from(s * f * v);
        let w = series(D, kappa, edge(value), edge(-0.5 * gradient), &source, LENGTH);
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
        // The first term's panel will hold the sum; the others' are empty.
        if builder.reserved.is_none() {
            builder.reserved = Some((builder.headers, builder.next));
            builder.next += 3 * LENGTH;
            return Ok(());
        }
        builder.panel(self.delta, (Variable::EdgePowers, 0.0, 0.0), &[], [0.0; 3])
    }

    /// Fits inside, and outside where there is no closed form.
    fn fitted<T: Real>(
        &self,
        law: Law,
        part: &mut Part<T>,
        profile: &Profile,
        builder: &mut Builder<'_, T>,
    ) -> Result<()> {
        let d = self.dimension as f64;
        let unit = Unit::new(law, self.dimension, self.delta);
        let convolution = Convolution::new(self.dimension, *profile, unit.kappa);
        // from units of delta: powers delta^p, exponentials delta^0, screened ones delta^(2-d)
        let factors = match law {
            Law::Power { exponent } => self.factors(exponent),
            Law::Exponential { .. } => self.factors(0.0),
            Law::Screened { .. } | Law::Newtonian => self.factors(2.0 - d),
        };
        let logarithm = if law == (Law::Power { exponent: 0.0 }) { Real::log(self.delta) } else { 0.0 };
        let inside = |rho: f64| {
            let mut values = convolution.at(rho, unit.weak, &mut |q, _| unit.inside(q))?;
            values[0] += logarithm;
            if let Law::Screened { .. } = law {
                values[2] = density(profile, self.dimension, rho) + unit.kappa * unit.kappa * values[0];
            }
            Some(values)
        };
        // Outside, the kernel relative to its size at the target. Next to the edge q still reaches 0, further out grad psi
        // would only cancel.
        let outside = |rho: f64| convolution.at(rho, unit.weak && rho < 1.5, &mut |q, y| unit.outside(q, y, rho));
        let outer_factors = match law {
            Law::Exponential { .. } => self.factors(0.0),
            _ => [self.coefficient; 3],
        };
        match profile {
            Profile::Compact { .. } => {
                let needs_outer =
                    matches!(part.outer, Outer::Power { .. } | Outer::Log { .. } | Outer::Exponential { .. });
                part.first = builder.begin(if needs_outer { 2 } else { 1 });
                let (fit, variable) = edge_fit(
                    |v| (1.0 - v * v).max(0.0).sqrt(),
                    |v| (1.0 - (v * v) * (v * v)).max(0.0).sqrt(),
                    (Variable::RootEdge, Variable::FourthRootEdge),
                    &inside,
                )?;
                builder.fitted(self.delta, (variable, 2.0, -1.0), &fit, factors)?;
                if needs_outer {
                    let reciprocal = matches!(part.outer, Outer::Exponential { .. });
                    let (fit, variable) = if reciprocal {
                        let fit = fit_unit(|v| outside(1.0 / (1.0 - v * v)))?;
                        (fit, Variable::RootReciprocal)
                    } else {
                        edge_fit(
                            |v| 1.0 / (1.0 - v * v).sqrt(),
                            |v| 1.0 / (1.0 - (v * v) * (v * v)).sqrt(),
                            (Variable::RootInverse, Variable::FourthRootInverse),
                            &outside,
                        )?
                    };
                    builder.fitted(0.0, (variable, 2.0, -1.0), &fit, outer_factors)?;
                }
            }
            Profile::Gaussian { parts, .. } => {
                // Beyond this the field is the exterior solution up to e^{-43}.
                let width = |&(w, c): &(f64, f64)| if w == 0.0 { 0.0 } else { c * (REACH + 0.5 * unit.kappa * c) };
                let end = parts.iter().map(width).fold(0.0, f64::max);
                let panels = octaves(end).ok_or(Error::Unsupported)?;
                part.first = builder.begin(panels + 1);
                part.panels = panels;
                let (mut from, mut to) = (0.0, 1.0);
                for _ in 0..panels {
                    self.square_panel(from, to, factors, GAUSSIAN_CAPACITY, &inside, builder)?;
                    (from, to) = (to, 2.0 * to);
                }
                match part.outer {
                    Outer::Bare { .. } => {}
                    Outer::Exponential { .. } => {
                        let fit = fit_unit(|v| outside(from / v.max(1e-9)))?;
                        builder.fitted(0.0, (Variable::Reciprocal, 2.0 * from, -1.0), &fit, outer_factors)?;
                    }
                    _ => {
                        let fit = fit_unit(|v| outside(from / v.max(1e-18).sqrt()))?;
                        builder.fitted(0.0, (Variable::Inverse, 2.0 * from * from, -1.0), &fit, outer_factors)?;
                    }
                }
            }
        }
        Ok(())
    }

    /// A fit in r^2 on [from, to], in units of delta.
    fn square_panel<T: Real>(
        &self,
        from: f64,
        to: f64,
        factors: [f64; 3],
        most: usize,
        sample: &dyn Fn(f64) -> Option<[f64; 3]>,
        builder: &mut Builder<'_, T>,
    ) -> Result<()> {
        let (low, high) = (from * from, to * to);
        let half = 0.5 * (high - low);
        let fit = fit(most, |x| sample((low + half * (x + 1.0)).sqrt()))?;
        builder.fitted(to * self.delta, (Variable::Square, 1.0 / half, -1.0 - low / half), &fit, factors)
    }

    /// A user's kernel, up to `reach`.
    pub(crate) fn supplied<T: Real>(
        &self,
        kernel: &dyn RadialKernel,
        reach: f64,
        builder: &mut Builder<'_, T>,
    ) -> Result<Part<T>> {
        let law = Law::Newtonian;
        builder.limit = reach;
        let Some(profile) = self.profile else {
            // octaves downwards from the reach, in units of it
            let unit = Task { delta: reach, ..*self };
            let first = builder.begin(USER_OCTAVES);
            let factors = [self.coefficient; 3];
            let mut to = 1.0 / power_of_two(USER_OCTAVES);
            let least = to * reach;
            let sample = |rho: f64| {
                let values = kernel.at(reach * rho);
                values.iter().all(|v| v.is_finite()).then_some(values)
            };
            for _ in 0..USER_OCTAVES {
                unit.square_panel(to, 2.0 * to, factors, GAUSSIAN_CAPACITY, &sample, builder)?;
                to *= 2.0;
            }
            let (radius, outer) = (T::from_f64(reach), Outer::Clamped { least: T::from_f64(least) });
            return Ok(Part { law, radius, panels: USER_OCTAVES, first, outer });
        };
        let convolution = Convolution::new(self.dimension, *profile, 0.0);
        let square = self.delta * self.delta;
        // the integrals may not look at each value, but a kernel that is not finite somewhere is refused
        let finite = Cell::new(true);
        let call = |q: f64| {
            let [u, g, l] = kernel.at(self.delta * q);
            finite.set(finite.get() && u.is_finite() && g.is_finite() && l.is_finite());
            [u, square * g, square * l]
        };
        let inside = |rho: f64| convolution.at(rho, true, &mut |q, _| call(q));
        let outside = |rho: f64| convolution.at(rho, false, &mut |q, _| call(q));
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
            let (fit, variable) = edge_fit(
                |v| (1.0 - v * v).max(0.0).sqrt(),
                |v| (1.0 - (v * v) * (v * v)).max(0.0).sqrt(),
                (Variable::RootEdge, Variable::FourthRootEdge),
                &inside,
            )?;
            builder.fitted(self.delta, (variable, 2.0, -1.0), &fit, factors)?;
        } else {
            self.square_panel(0.0, to, factors, GAUSSIAN_CAPACITY, &inside, builder)?;
        }
        for index in 1..panels {
            if compact && index == 1 {
                // v = sqrt(rho^2 - 1) in [0, sqrt 3]: the edge seen from outside
                let span = 3.0_f64.sqrt();
                let fit = fit(GAUSSIAN_CAPACITY, |x| {
                    let v = 0.5 * span * (x + 1.0);
                    outside((1.0 + v * v).sqrt())
                })?;
                builder.fitted(2.0 * self.delta, (Variable::RootOutside, 2.0 / span, -1.0), &fit, factors)?;
            } else if compact {
                self.square_panel(to, 2.0 * to, factors, GAUSSIAN_CAPACITY, &outside, builder)?;
            } else {
                self.square_panel(to, 2.0 * to, factors, GAUSSIAN_CAPACITY, &inside, builder)?;
            }
            to *= 2.0;
        }
        if !finite.get() {
            return Err(Error::NotFinite);
        }
        Ok(Part { law, radius: T::from_f64(self.delta), panels, first, outer: Outer::Zero })
    }
}

/// Panels [0, 1], [1, 2], ... that reach `end`; None if too many.
fn octaves(end: f64) -> Option<usize> {
    (1..=GAUSSIAN_PANELS).find(|&n| power_of_two(n - 1) >= end)
}

/// 2^n.
fn power_of_two(n: usize) -> f64 {
    Real::ldexp(1.0_f64, n as i32)
}

/// The smallest n >= 0 with 2^n >= x.
fn octaves_to(x: f64) -> usize {
    let (m, e) = Real::frexp(x);
    (if m == 0.5 { e - 1 } else { e }).max(0) as usize
}

/// A fit over v in [0, 1].
fn fit_unit(sample: impl Fn(f64) -> Option<[f64; 3]>) -> Result<Fit> {
    fit(CAPACITY, |x| sample(0.5 * (x + 1.0)))
}

/// A fit over v in [0, 1] where t = v^2, or t = v^4 if that leaves a smaller rest: K_delta is smooth in t but for a power
/// t^(M + p + d) of lower and lower degree in its derivatives.
fn edge_fit(
    second: impl Fn(f64) -> f64,
    fourth: impl Fn(f64) -> f64,
    (two, four): (Variable, Variable),
    sample: &dyn Fn(f64) -> Option<[f64; 3]>,
) -> Result<(Fit, Variable)> {
    let first = fit_unit(|v| sample(second(v)))?;
    if first.error < 1e-14 {
        return Ok((first, two));
    }
    let other = fit_unit(|v| sample(fourth(v)))?;
    Ok(if other.error < first.error { (other, four) } else { (first, two) })
}

/// psi in units of delta.
pub(crate) fn density(profile: &Profile, dimension: usize, rho: f64) -> f64 {
    match *profile {
        Profile::Compact { b, .. } => horner(&b, ((1.0 - rho) * (1.0 + rho)).max(0.0)) / sphere(dimension),
        Profile::Gaussian { parts, .. } => {
            let root = core::f64::consts::PI.sqrt();
            let one =
                |&(w, c): &(f64, f64)| w * (-(rho / c) * (rho / c)).exp() / Real::powi(root * c, dimension as u32);
            parts.iter().map(one).sum()
        }
    }
}

/// A law in units of delta.
struct Unit {
    law: Law,
    dimension: usize,
    /// delta / length, or k delta.
    kappa: f64,
    /// Whether the Laplacian is too singular to convolve.
    weak: bool,
}

impl Unit {
    fn new(law: Law, dimension: usize, delta: f64) -> Self {
        let (kappa, weak) = match law {
            Law::Exponential { length } => (delta / length, false),
            Law::Screened { k } => (delta * k, false),
            Law::Power { exponent } => (0.0, exponent < 2.5 - dimension as f64),
            Law::Newtonian => (0.0, true),
        };
        Self { law, dimension, kappa, weak }
    }

    fn inside(&self, q: f64) -> [f64; 3] {
        let law = match self.law {
            Law::Exponential { .. } => Law::Exponential { length: 1.0 / self.kappa },
            Law::Screened { .. } => Law::Screened { k: self.kappa },
            law => law,
        };
        match self.dimension {
            1 => law.bare::<f64, 1>(q),
            2 => law.bare::<f64, 2>(q),
            _ => law.bare::<f64, 3>(q),
        }
    }

    /// At q = rho + y, divided by rho^p, rho^(p-2), rho^(p-2) for powers (less log rho for the logarithm), by e^{-kappa rho}
    /// for exponentials.
    fn outside(&self, q: f64, y: f64, rho: f64) -> [f64; 3] {
        let d = self.dimension as f64;
        match self.law {
            Law::Power { exponent: p } => {
                // 1 + y/rho would be 0 where q is tiny, next to the edge
                let near = y < -0.5 * rho;
                let ratio = if near { q / rho } else { 1.0 + y / rho };
                let power = ratio.pow(p);
                let less = power / (ratio * ratio);
                let value = match (p == 0.0, near) {
                    (true, true) => Real::log(ratio),
                    (true, false) => (y / rho).log1p(),
                    _ => power / p,
                };
                [value, less, (p + d - 2.0) * less]
            }
            _ => {
                let e = (-(self.kappa * y)).exp();
                let gradient = -self.kappa * e / q;
                [e, gradient, self.kappa * self.kappa * e + (d - 1.0) * gradient]
            }
        }
    }
}

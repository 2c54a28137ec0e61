//! One prepared term: the position of its series in the tables, and the factors that multiply them.
//!
//! Tables are in double precision for both scalars and hold no pointers. A part stores the number of its panels and the position of its first
//! header. A header holds the panel's outer radius, its variable and the position of its coefficients. Coefficients include the term's
//! coefficient and all powers of delta, so evaluation consists of a search, a variable and three series.
//!
//! There are two evaluations. [`FittedTerm::alone`] takes one distance in double precision and is as accurate as the tables.
//! [`FittedTerm::at`] is for sums over pairs and uses the sum's scalar.

use super::chebyshev::{clenshaw, horner_words, horner3};
use super::law::{Law, decay, extended_power, power, real_power};
use crate::checked::Present;
use crate::real::{DoubleWord, Extended, Real, Scalar};

/// Numbers in a panel's header.
pub(crate) const HEADER: usize = 7;

/// Numbers in a part's record.
pub(crate) const RECORD: usize = 12;

/// The variable of a series, as a function of r and the part's radius R.
///
/// Series of powers use the variable itself. Chebyshev series use `x = scale * v + shift`, where v is the variable or, at the edge,
/// its power [`Panel::root`]. K_delta is smooth there except for powers t^(a + j) with one a.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub(crate) enum Variable {
    /// Powers of t = 1 - (r/R)^2.
    EdgePowers = 0,
    /// Powers of s = (r/R)^2.
    SquarePowers = 1,
    /// Powers of z = (R/r)^2.
    InversePowers = 2,
    /// Chebyshev in s.
    Square = 3,
    /// Chebyshev in t^root.
    Edge = 4,
    /// Chebyshev in ((r/R)^2 - 1)^root, outside.
    Outside = 5,
    /// Chebyshev in z.
    Inverse = 6,
    /// Chebyshev in (1 - z)^root.
    InverseEdge = 7,
    /// Chebyshev in R/r.
    Reciprocal = 8,
    /// Chebyshev in (1 - R/r)^root.
    ReciprocalEdge = 9,
}

impl Variable {
    const ALL: [Self; 10] = [
        Self::EdgePowers,
        Self::SquarePowers,
        Self::InversePowers,
        Self::Square,
        Self::Edge,
        Self::Outside,
        Self::Inverse,
        Self::InverseEdge,
        Self::Reciprocal,
        Self::ReciprocalEdge,
    ];

    /// Whether the series is a power series in the variable itself.
    pub(crate) fn is_power(self) -> bool {
        matches!(self, Self::EdgePowers | Self::SquarePowers | Self::InversePowers)
    }

    /// The variable's value.
    #[inline(always)]
    pub(crate) fn at<T: Real>(self, radius: T, r: T, root: T) -> T {
        // Differences of r and R are exact within a factor of two, so a variable that vanishes at the edge has a small relative error.
        // The divisor is replaced at r = 0: the compiler may divide before it knows that the quotient is not used.
        let divisor = if r > T::ZERO { r } else { T::ONE };
        match self {
            Self::EdgePowers | Self::Edge => {
                let t = ((radius - r) / radius * (T::ONE + r / radius)).max(T::ZERO);
                if self == Self::Edge { rooted(t, root) } else { t }
            }
            Self::SquarePowers | Self::Square => {
                let q = r / radius;
                q * q
            }
            Self::InversePowers | Self::Inverse => {
                let w = radius / divisor;
                w * w
            }
            Self::Outside => rooted(((r - radius) / radius * (T::ONE + r / radius)).max(T::ZERO), root),
            Self::InverseEdge => rooted(((r - radius) / divisor * (T::ONE + radius / divisor)).max(T::ZERO), root),
            Self::Reciprocal => radius / divisor,
            Self::ReciprocalEdge => rooted(((r - radius) / divisor).max(T::ZERO), root),
        }
    }

    /// The value of the variable of a power series, in two words.
    fn words(self, radius: f64, r: f64) -> DoubleWord<f64> {
        // Scaled, so that the products of the words stay in range.
        let (radius, exponent) = Scalar::frexp(radius);
        let scaled = Scalar::ldexp(r, -exponent);
        match self {
            Self::InversePowers => {
                // Farther away all powers but the constant are zero to rounding, and the quotient's products would overflow.
                let scaled = scaled.min(Scalar::ldexp(1.0, 500));
                let w = DoubleWord::quotient(radius, if scaled > 0.0 { scaled } else { 1.0 });
                w * w
            }
            Self::SquarePowers => {
                let q = DoubleWord::quotient(scaled, radius);
                q * q
            }
            _ => {
                let difference = DoubleWord::sum(radius, -scaled) / radius;
                difference * (DoubleWord::sum(radius, scaled) / radius)
            }
        }
    }

    fn from_number(n: f64) -> Self {
        Self::ALL.into_iter().find(|&v| f64::from(v as u8) == n).unwrap_or(Self::EdgePowers)
    }
}

/// The smallest positive argument of the logarithm. No representable t lies between 0 and this value.
pub(crate) const LEAST: f64 = 1e-17;

/// t^root; log t for root = 0.
#[inline(always)]
pub(crate) fn rooted<T: Real>(t: T, root: T) -> T {
    if root == T::ONE {
        t
    } else if root == T::HALF {
        t.sqrt()
    } else if root == T::from_f64(0.25) {
        t.sqrt().sqrt()
    } else if root == T::ZERO {
        t.max(T::from_f64(LEAST)).log()
    } else {
        t.pow(root)
    }
}

/// The factors of the series of panels beyond the first `plain`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Outer<T> {
    /// The bare law times a constant, without series.
    Bare {
        /// coefficient times F.
        factor: T,
    },
    /// r^p, r^(p-2), r^(p-2).
    Power {
        /// p.
        exponent: f64,
    },
    /// As `Power` with p = 0, and coefficient * log r added to the value.
    Log {
        /// The coefficient.
        coefficient: T,
    },
    /// e^{-kr}, e^{-kr}/r, e^{-kr}.
    Exponential {
        /// k.
        k: T,
    },
    /// 3D exponential: (F - delta F'/r) e^{-kr}, times the coefficient.
    Yukawa {
        /// k.
        k: T,
        /// coefficient F.
        plain: T,
        /// coefficient delta F'.
        over_r: T,
    },
    /// Nothing: beyond the reach of a user's kernel.
    Zero,
    /// Nothing outside. For smaller r than the panels' K'/r and the Laplacian continue as a power of r (a user's kernel without a mollifier).
    Continued {
        /// The smallest r of the fit.
        least: T,
        /// The power.
        power: f64,
    },
}

/// What continues below the least distance l of a fit, x = r/l: x^p, and l^2 times the integral of x^(p+1) from 1 to x.
fn continued<T: Real>(least: T, power: f64, r: T) -> (T, T) {
    let x = r.max(T::MIN_POSITIVE) / least;
    let (log, q) = (x.log(), T::from_f64(power + 2.0));
    let exponent = q * log;
    let integral = if q == T::ZERO { log } else { exponent.expm1() / q };
    (x.pow(T::from_f64(power)), least * least * integral)
}

/// A prepared term.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct FittedTerm<T> {
    pub(crate) law: Law,
    pub(crate) radius: T,
    /// Number of bounded panels. If the outer form has a series, one more panel reaches to infinity.
    pub(crate) panels: usize,
    /// Number of these, from the innermost on, that hold the function itself.
    pub(crate) plain: usize,
    pub(crate) first: usize,
    pub(crate) outer: Outer<T>,
}

/// A panel, as decoded from its header.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Panel<T> {
    pub(crate) end: T,
    pub(crate) variable: Variable,
    pub(crate) start: usize,
    pub(crate) len: usize,
    pub(crate) scale: T,
    pub(crate) shift: T,
    pub(crate) root: T,
}

impl Panel<f64> {
    pub(crate) fn to_header(self) -> [f64; HEADER] {
        let variable = f64::from(self.variable as u8);
        [self.end, variable, self.start as f64, self.len as f64, self.scale, self.shift, self.root]
    }

    /// The series at full accuracy. Power series use two words; the second words are stored after the first.
    fn alone(&self, tables: &[f64], radius: f64, r: f64) -> [f64; 3] {
        if !self.variable.is_power() {
            return self.series(tables, radius, r);
        }
        let all = tables.get(self.start..).present_or(&[]).as_chunks::<3>().0;
        let (high, low) = all.split_at_checked(self.len).unwrap_or((all, &[]));
        horner_words(high, low.get(..self.len).present_or(&[]), self.variable.words(radius, r))
    }
}

impl<T: Real> Panel<T> {
    fn from_header(h: [f64; HEADER]) -> Self {
        Self {
            end: T::from_f64(h[0]),
            variable: Variable::from_number(h[1]),
            start: h[2] as usize,
            len: h[3] as usize,
            scale: T::from_f64(h[4]),
            shift: T::from_f64(h[5]),
            root: T::from_f64(h[6]),
        }
    }

    /// The coefficients.
    pub(crate) fn coefficients<'t>(&self, tables: &'t [f64]) -> &'t [[f64; 3]] {
        tables.get(self.start..).present_or(&[]).as_chunks::<3>().0.get(..self.len).present_or(&[])
    }

    fn series(&self, tables: &[f64], radius: T, r: T) -> [T; 3] {
        let coefficients = self.coefficients(tables);
        let v = self.variable.at(radius, r, self.root);
        if self.variable.is_power() {
            return horner3(coefficients, v);
        }
        let x = (self.scale * v + self.shift).min(T::ONE).max(-T::ONE);
        clenshaw(coefficients, x)
    }
}

impl<T: Real> FittedTerm<T> {
    /// The panel with this index. The index after the last is the series outside.
    pub(crate) fn panel(&self, tables: &[f64], index: usize) -> Option<Panel<T>> {
        let start = self.first + index * HEADER;
        let header = tables.get(start..)?.first_chunk::<HEADER>()?;
        Some(Panel::from_header(*header))
    }

    /// The index of the panel at r, and the distance at which its series are evaluated; NaN where a header is missing.
    fn place(&self, tables: &[f64], r: T) -> (usize, T) {
        let from = if let Outer::Continued { least, .. } = self.outer { r.max(least) } else { r };
        let (mut index, mut above) = (0, self.panels);
        while index < above {
            let middle = index.midpoint(above);
            match self.panel(tables, middle) {
                Some(panel) if from <= panel.end => above = middle,
                Some(_) => index = middle + 1,
                None => return (middle, T::NAN),
            }
        }
        (index, if index < self.panels { from } else { r })
    }

    /// Value, gradient factor and Laplacian at r >= 0 of the mollified term, including its coefficient. For sums over pairs.
    pub(crate) fn at<const D: usize>(&self, tables: &[f64], r: T) -> [T; 3] {
        let (index, from) = self.place(tables, r);
        let series = || self.panel(tables, index).map_or([T::NAN; 3], |p| p.series(tables, self.radius, from));
        if index < self.plain {
            let [u, g, l] = series();
            return match self.outer {
                Outer::Continued { least, power } if r < least => {
                    let (factor, integral) = continued(least, power, r);
                    [u + g * integral, g * factor, l * factor]
                }
                _ => [u, g, l],
            };
        }
        // Not zero here, but the compiler may divide before it knows.
        let r = if r > T::ZERO { r } else { T::ONE };
        match self.outer {
            Outer::Bare { factor } => self.law.bare::<T, D>(r).map(|v| factor * v),
            Outer::Power { exponent } => {
                let [u, g, l] = series();
                let power = power(r, exponent);
                let less = power / r / r;
                [power * u, less * g, less * l]
            }
            Outer::Log { coefficient } => {
                let [u, g, l] = series();
                [coefficient * r.log() + u, g / r / r, l / r / r]
            }
            Outer::Exponential { k } => {
                let (e, [u, g, l]) = ((-(k * r)).exp(), series());
                [e * u, e / r * g, e * l]
            }
            Outer::Yukawa { .. } | Outer::Zero | Outer::Continued { .. } => self.without_series(r),
        }
    }

    /// The outer forms that need no series.
    pub(crate) fn without_series(&self, r: T) -> [T; 3] {
        match self.outer {
            Outer::Yukawa { k, plain, over_r } => {
                let e = (-(k * r)).exp();
                let per_r = T::ONE / r;
                let x = k * r;
                [
                    (plain - over_r * per_r) * e,
                    (over_r * (T::ONE + x) * per_r * per_r - k * plain) * per_r * e,
                    (k * plain - (T::TWO * plain + over_r * k) * per_r) * k * e,
                ]
            }
            _ => [T::ZERO; 3],
        }
    }
}

impl FittedTerm<f64> {
    /// As [`FittedTerm::at`], at full accuracy. Results overflow and underflow only where the true values do.
    pub(crate) fn alone<const D: usize>(&self, tables: &[f64], r: f64) -> [f64; 3] {
        let (index, from) = self.place(tables, r);
        let series = || self.panel(tables, index).map_or([f64::NAN; 3], |p| p.alone(tables, self.radius, from));
        if index < self.plain {
            return match self.outer {
                Outer::Continued { least, .. } if r < least => self.scaled::<D>(tables, r).map(Extended::get),
                _ => series(),
            };
        }
        let r = if r > 0.0 { r } else { 1.0 };
        match self.outer {
            Outer::Bare { factor } => self.law.alone::<D>(r).map(|v| factor * v),
            Outer::Power { exponent } => {
                let [u, g, l] = series();
                let less = real_power(r, exponent - 2.0);
                [real_power(r, exponent) * u, less * g, less * l]
            }
            Outer::Log { coefficient } => {
                let [u, g, l] = series();
                [coefficient * Scalar::log(r) + u, g / r / r, l / r / r]
            }
            Outer::Exponential { k } => {
                let (e, [u, g, l]) = (decay(k, r), series());
                [e * u, e / r * g, e * l]
            }
            Outer::Yukawa { k, plain, over_r } => {
                let (e, a) = (decay(k, r), over_r / r);
                [
                    (plain - a) * e,
                    (a * (1.0 + k * r) / r - k * plain) / r * e,
                    (k * plain - (2.0 * plain / r + a * k)) * k * e,
                ]
            }
            Outer::Zero | Outer::Continued { .. } => [0.0; 3],
        }
    }

    /// [`FittedTerm::alone`] with exponents: powers of r need not be in range, the series' own numbers must.
    pub(crate) fn scaled<const D: usize>(&self, tables: &[f64], r: f64) -> [Extended; 3] {
        let (index, from) = self.place(tables, r);
        match self.outer {
            Outer::Bare { factor } if index >= self.plain => self.law.scaled::<D>(r).map(|v| v.scale(factor)),
            Outer::Power { exponent } if index >= self.plain => {
                let [u, g, l] = self.panel(tables, index).map_or([f64::NAN; 3], |p| p.alone(tables, self.radius, from));
                let less = extended_power(r, exponent - 2.0);
                [extended_power(r, exponent).scale(u), less.scale(g), less.scale(l)]
            }
            Outer::Continued { least, power } if index < self.plain && r < least => {
                let [u, g, l] = self.panel(tables, index).map_or([f64::NAN; 3], |p| p.alone(tables, self.radius, from));
                let (x, q) = (r.max(f64::MIN_POSITIVE) / least, power + 2.0);
                let exponent = q * Scalar::log(x);
                let integral = if exponent.abs() < 1.0 {
                    Extended::new(if q == 0.0 { Scalar::log(x) } else { exponent.expm1() / q }, 0)
                } else {
                    extended_power(x, q).plus(Extended::new(-1.0, 0)).scale(1.0 / q)
                };
                let factor = extended_power(x, power);
                let square = Extended::new(g, 0).scale(least).scale(least);
                [Extended::new(u, 0).plus(integral.times(square)), factor.scale(g), factor.scale(l)]
            }
            _ => self.alone::<D>(tables, r).map(|v| Extended::new(v, 0)),
        }
    }

    /// The derivative at r > 0, the gradient factor times r. It is finite where the gradient factor may overflow.
    pub(crate) fn slope<const D: usize>(&self, tables: &[f64], r: f64) -> f64 {
        let (index, from) = self.place(tables, r);
        let series = || self.panel(tables, index).map_or(f64::NAN, |p| p.alone(tables, self.radius, from)[1]);
        match self.outer {
            Outer::Continued { least, .. } if r < least => self.scaled::<D>(tables, r)[1].scale(r).get(),
            _ if index < self.plain => r * series(),
            Outer::Bare { factor } => factor * self.law.slope::<D>(r),
            Outer::Power { exponent } => real_power(r, exponent - 1.0) * series(),
            Outer::Log { .. } => series() / r,
            Outer::Exponential { k } => decay(k, r) * series(),
            _ => r * self.alone::<D>(tables, r)[1],
        }
    }

    /// The same part in a sum's scalar.
    pub(crate) fn narrow<T: Real>(&self) -> FittedTerm<T> {
        let real = T::from_f64;
        let outer = match self.outer {
            Outer::Bare { factor } => Outer::Bare { factor: real(factor) },
            Outer::Power { exponent } => Outer::Power { exponent },
            Outer::Log { coefficient } => Outer::Log { coefficient: real(coefficient) },
            Outer::Exponential { k } => Outer::Exponential { k: real(k) },
            Outer::Yukawa { k, plain, over_r } => {
                Outer::Yukawa { k: real(k), plain: real(plain), over_r: real(over_r) }
            }
            Outer::Zero => Outer::Zero,
            Outer::Continued { least, power } => Outer::Continued { least: real(least), power },
        };
        let &Self { law, radius, panels, plain, first, .. } = self;
        FittedTerm { law, radius: real(radius), panels, plain, first, outer }
    }

    /// The record stored in a prepared block.
    pub(crate) fn to_record(self) -> [f64; RECORD] {
        let (law, parameter) = self.law.to_numbers();
        let (outer, a, b, c) = match self.outer {
            Outer::Bare { factor } => (0.0, factor, 0.0, 0.0),
            Outer::Power { exponent } => (1.0, exponent, 0.0, 0.0),
            Outer::Log { coefficient } => (2.0, coefficient, 0.0, 0.0),
            Outer::Exponential { k } => (3.0, k, 0.0, 0.0),
            Outer::Yukawa { k, plain, over_r } => (4.0, k, plain, over_r),
            Outer::Zero => (5.0, 0.0, 0.0, 0.0),
            Outer::Continued { least, power } => (6.0, least, power, 0.0),
        };
        let (panels, plain, first) = (self.panels as f64, self.plain as f64, self.first as f64);
        [law, parameter, self.radius, panels, first, outer, a, b, c, plain, 0.0, 0.0]
    }

    /// The part of a record; `None`: the record is of none.
    pub(crate) fn from_record(r: &[f64; RECORD]) -> Option<Self> {
        let outer = match r[5] as u32 {
            0 => Outer::Bare { factor: r[6] },
            1 => Outer::Power { exponent: r[6] },
            2 => Outer::Log { coefficient: r[6] },
            3 => Outer::Exponential { k: r[6] },
            4 => Outer::Yukawa { k: r[6], plain: r[7], over_r: r[8] },
            5 => Outer::Zero,
            6 => Outer::Continued { least: r[6], power: r[7] },
            _ => return None,
        };
        let law = Law::from_numbers(r[0], r[1])?;
        Some(Self { law, radius: r[2], panels: r[3] as usize, plain: r[9] as usize, first: r[4] as usize, outer })
    }
}

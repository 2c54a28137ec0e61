//! One prepared term: where its series are and what they multiply.
//!
//! Tables hold no pointers: a part counts its panels and knows where its first header starts; a header holds the panel's
//! outer radius, its variable and where its coefficients stand. Coefficients carry the term's coefficient and all powers of
//! delta, so that evaluating is a search, a variable and three series side by side.

use super::chebyshev::{clenshaw, horner3};
use super::law::{Law, power};
use crate::real::Real;

/// Numbers in a panel's header.
pub(crate) const HEADER: usize = 6;

/// Numbers in a part's record.
pub(crate) const RECORD: usize = 12;

/// The variable of a series, as a function of r and the part's radius R. With `x = scale * v + shift`:
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub(crate) enum Variable {
    /// Powers of t = 1 - (r/R)^2.
    EdgePowers = 0,
    /// Powers of s = (r/R)^2.
    SquarePowers = 1,
    /// Powers of z = (R/r)^2.
    InversePowers = 2,
    /// Chebyshev in v = (r/R)^2.
    Square = 3,
    /// Chebyshev in v = sqrt t: the solution is smooth in t but for a power of t at the edge.
    RootEdge = 4,
    /// Chebyshev in v = t^(1/4), for mollifiers with a rougher edge.
    FourthRootEdge = 5,
    /// Chebyshev in v = sqrt((r/R)^2 - 1), outside.
    RootOutside = 6,
    /// Chebyshev in v = (R/r)^2.
    Inverse = 7,
    /// Chebyshev in v = sqrt(1 - (R/r)^2).
    RootInverse = 8,
    /// Chebyshev in v = (1 - (R/r)^2)^(1/4).
    FourthRootInverse = 9,
    /// Chebyshev in v = R/r.
    Reciprocal = 10,
    /// Chebyshev in v = sqrt(1 - R/r).
    RootReciprocal = 11,
}

impl Variable {
    const ALL: [Self; 12] = [
        Self::EdgePowers,
        Self::SquarePowers,
        Self::InversePowers,
        Self::Square,
        Self::RootEdge,
        Self::FourthRootEdge,
        Self::RootOutside,
        Self::Inverse,
        Self::RootInverse,
        Self::FourthRootInverse,
        Self::Reciprocal,
        Self::RootReciprocal,
    ];

    /// Whether the series is one of powers, of the variable itself.
    pub(crate) fn is_power(self) -> bool {
        matches!(self, Self::EdgePowers | Self::SquarePowers | Self::InversePowers)
    }

    /// The variable's value.
    #[inline(always)]
    pub(crate) fn at<T: Real>(self, radius: T, r: T) -> T {
        let q = r / radius;
        // exact where r and R are within a factor of two, so relatively accurate up to the edge
        let t = ((radius - r) / radius * (T::ONE + q)).max(T::ZERO);
        // Those that divide by r are for panels outside, where it is not zero.
        match self {
            Self::EdgePowers => t,
            Self::SquarePowers | Self::Square => q * q,
            Self::InversePowers | Self::Inverse => (radius / r) * (radius / r),
            Self::RootEdge => t.sqrt(),
            Self::FourthRootEdge => t.sqrt().sqrt(),
            Self::RootOutside => ((r - radius) / radius * (T::ONE + q)).max(T::ZERO).sqrt(),
            Self::RootInverse => outside(radius, r).sqrt(),
            Self::FourthRootInverse => outside(radius, r).sqrt().sqrt(),
            Self::Reciprocal => radius / r,
            Self::RootReciprocal => ((r - radius) / r).max(T::ZERO).sqrt(),
        }
    }

    fn from_number(n: f64) -> Self {
        Self::ALL.into_iter().find(|&v| f64::from(v as u8) == n).unwrap_or(Self::EdgePowers)
    }
}

/// What the series outside the last panel multiply.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Outer<T> {
    /// The bare law times a constant, no series.
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
    /// e^{-kr} times all three.
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
    /// The innermost panel also serves smaller r, and nothing lies outside (a user's kernel without a mollifier).
    Clamped {
        /// The smallest r of the fit.
        least: T,
    },
}

/// A prepared term.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Part<T> {
    pub(crate) law: Law,
    pub(crate) radius: T,
    pub(crate) panels: usize,
    pub(crate) first: usize,
    pub(crate) outer: Outer<T>,
}

/// A panel as its header says.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Panel<T> {
    pub(crate) end: T,
    pub(crate) variable: Variable,
    pub(crate) start: usize,
    pub(crate) len: usize,
    pub(crate) scale: T,
    pub(crate) shift: T,
}

impl<T: Real> Panel<T> {
    pub(crate) fn to_header(self) -> [T; HEADER] {
        let number = |n: usize| T::from_usize(n);
        let variable = T::from_usize(self.variable as usize);
        [self.end, variable, number(self.start), number(self.len), self.scale, self.shift]
    }

    fn from_header(h: [T; HEADER]) -> Self {
        Self {
            end: h[0],
            variable: Variable::from_number(h[1].to_f64()),
            start: h[2].to_f64() as usize,
            len: h[3].to_f64() as usize,
            scale: h[4],
            shift: h[5],
        }
    }

    fn series(&self, tables: &[T], radius: T, r: T) -> [T; 3] {
        let all = tables.get(self.start..).unwrap_or(&[]).as_chunks::<3>().0;
        let coefficients = all.get(..self.len).unwrap_or(&[]);
        let v = self.variable.at(radius, r);
        if self.variable.is_power() {
            return horner3(coefficients, v);
        }
        let x = (self.scale * v + self.shift).min(T::ONE).max(-T::ONE);
        clenshaw(coefficients, x)
    }
}

/// 1 - (R/r)^2, accurate at the edge.
fn outside<T: Real>(radius: T, r: T) -> T {
    ((r - radius) / r * (T::ONE + radius / r)).max(T::ZERO)
}

impl<T: Real> Part<T> {
    /// The panel with this number; one beyond the last belongs to the series outside.
    pub(crate) fn panel(&self, tables: &[T], index: usize) -> Option<Panel<T>> {
        let start = self.first + index * HEADER;
        let header = tables.get(start..)?.first_chunk::<HEADER>()?;
        Some(Panel::from_header(*header))
    }

    /// Value, gradient factor and Laplacian at r >= 0 of the mollified term, its coefficient included.
    pub(crate) fn at<const D: usize>(&self, tables: &[T], r: T) -> [T; 3] {
        let mut from = r;
        if let Outer::Clamped { least } = self.outer {
            from = r.max(least);
        }
        for index in 0..self.panels {
            match self.panel(tables, index) {
                Some(panel) if from <= panel.end => return panel.series(tables, self.radius, from),
                Some(_) => {}
                None => return [T::NAN; 3],
            }
        }
        let series = || self.panel(tables, self.panels).map_or([T::NAN; 3], |p| p.series(tables, self.radius, r));
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
                let e = (-(k * r)).exp();
                series().map(|v| v * e)
            }
            Outer::Yukawa { .. } | Outer::Zero | Outer::Clamped { .. } => self.without_series(r),
        }
    }

    /// What needs no series outside.
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

    /// The record that a prepared block keeps.
    pub(crate) fn to_record(self) -> [f64; RECORD] {
        let (law, parameter) = self.law.to_numbers();
        let (outer, a, b, c) = match self.outer {
            Outer::Bare { factor } => (0.0, factor.to_f64(), 0.0, 0.0),
            Outer::Power { exponent } => (1.0, exponent, 0.0, 0.0),
            Outer::Log { coefficient } => (2.0, coefficient.to_f64(), 0.0, 0.0),
            Outer::Exponential { k } => (3.0, k.to_f64(), 0.0, 0.0),
            Outer::Yukawa { k, plain, over_r } => (4.0, k.to_f64(), plain.to_f64(), over_r.to_f64()),
            Outer::Zero => (5.0, 0.0, 0.0, 0.0),
            Outer::Clamped { least } => (6.0, least.to_f64(), 0.0, 0.0),
        };
        let radius = self.radius.to_f64();
        [law, parameter, radius, self.panels as f64, self.first as f64, outer, a, b, c, 0.0, 0.0, 0.0]
    }

    pub(crate) fn from_record(r: &[f64; RECORD]) -> Self {
        let real = T::from_f64;
        let outer = match r[5] as u32 {
            0 => Outer::Bare { factor: real(r[6]) },
            1 => Outer::Power { exponent: r[6] },
            2 => Outer::Log { coefficient: real(r[6]) },
            3 => Outer::Exponential { k: real(r[6]) },
            4 => Outer::Yukawa { k: real(r[6]), plain: real(r[7]), over_r: real(r[8]) },
            5 => Outer::Zero,
            _ => Outer::Clamped { least: real(r[6]) },
        };
        let law = Law::from_numbers(r[0], r[1]);
        Self { law, radius: real(r[2]), panels: r[3] as usize, first: r[4] as usize, outer }
    }
}

//! Mollifiers that are sums of Gaussians, and their Newtonian fields: one Gaussian (order 2: Lamb and Oseen's vortex in 2D), Craig & Bertozzi (4.1) in 1D and
//! (4.2) in 2D, and the same construction for order 6 in 2D and in 3D. Weights w_i and widths c_i satisfy sum w_i = 1, sum w_i c_i^(2k) = 0 for 0 < 2k < order.
//!
//! psi = sum of w_i exp(-xi_i) / (pi^(N/2) L_i^N) with L_i = c_i delta and xi_i = (r/L_i)^2. With a = N/2 and Kummer's
//! M_a(xi) = 1F1(a; a+1; -xi) the field of one unit Gaussian of width L is
//!
//! * g = M_a(xi) / (pi^a L^N N),
//! * h = -2 M_(a+1)(xi) / ((N+2) pi^a L^(N+2)),
//! * phi = L (e^-xi + 2 xi M_(1/2)(xi)) / (2 sqrt(pi)) in 1D,
//!   (log L - gamma/2 + Ein(xi)/2) / (2 pi) in 2D, -M_(1/2)(xi) / (2 pi^(3/2) L) in 3D.
//!
//! None of these cancels: M_(a+1) = e^-xi sum of xi^k / (a+2)_k and M_a = e^-xi + xi M_(a+1) / (a+1) (DLMF 13.2.39, 13.3.4)
//! are sums of positive terms. Only the Gaussians of one mollifier cancel with each other, by a factor of 2 to 4, in
//! double-word arithmetic. From xi = 24 (f32), 53 (f64) on, the field of a Gaussian is Newtonian to u/17.

use super::Quantity;
use super::distance::{Distance, sphere};
use super::newtonian::Newtonian;
use super::scaled::Scaled;
use crate::real::{DoubleWord, Real};
use crate::special::elementary::{euler, exp, log_2};
use crate::special::exponential_integral::entire_exponential_integral;

/// One Gaussian: weight `numerator / denominator` of the whole sum, c^2 = 2^`log_square`.
#[derive(Clone, Copy, Debug)]
struct Component {
    numerator: i32,
    log_square: i32,
}

/// A sum of Gaussians, without a length.
#[derive(Clone, Copy, Debug)]
pub(super) struct Gaussian {
    denominator: i32,
    components: &'static [Component],
}

const fn component(numerator: i32, log_square: i32) -> Component {
    Component { numerator, log_square }
}

/// Order 2.
const ONE: Gaussian = Gaussian { denominator: 1, components: &[component(1, 0)] };
/// 1D and 3D, order 4: (4/3, c = 1), (-1/3, 2).
const LINE_4: Gaussian = Gaussian { denominator: 3, components: &[component(4, 0), component(-1, 2)] };
/// 1D and 3D, order 6: (64/45, 1), (-4/9, 2), (1/45, 4).
const LINE_6: Gaussian =
    Gaussian { denominator: 45, components: &[component(64, 0), component(-20, 2), component(1, 4)] };
/// 2D, order 4: (2, 1), (-1, sqrt 2).
const PLANE_4: Gaussian = Gaussian { denominator: 1, components: &[component(2, 0), component(-1, 1)] };

/// 2D, order 6: (8/3, 1), (-2, sqrt 2), (1/3, 2).
const PLANE_6: Gaussian =
    Gaussian { denominator: 3, components: &[component(8, 0), component(-6, 1), component(1, 2)] };

impl Gaussian {
    /// The sum that [`Mollifier::check`](super::Mollifier::check) accepts in this dimension.
    pub fn new(dimension: usize, order: u32) -> Self {
        match (dimension, order) {
            (_, 2) => ONE,
            (2, 4) => PLANE_4,
            (2, _) => PLANE_6,
            (_, 4) => LINE_4,
            _ => LINE_6,
        }
    }

    /// 2, 4 or 6: twice the number of Gaussians.
    pub fn order(self) -> u32 {
        2 * self.components.len() as u32
    }

    /// (w_i, c_i) in 1D, where every c_i is a power of two.
    pub fn terms<T: Real>(self) -> impl Iterator<Item = (T, T)> {
        let denominator = T::from_i32(self.denominator);
        self.components.iter().map(move |c| (T::from_i32(c.numerator) / denominator, T::ONE.ldexp(c.log_square / 2)))
    }

    /// (w_i, c_i^2) of up to three, and zeros.
    pub fn weights(self) -> [(f64, f64); 3] {
        let mut weights = [(0.0, 1.0); 3];
        for (to, c) in weights.iter_mut().zip(self.components) {
            *to = (f64::from(c.numerator) / f64::from(self.denominator), f64::from(1 << c.log_square));
        }
        weights
    }

    /// Moment k >= 0 in units of delta^k: the integral of |x|^k psi(x).
    ///
    /// It is the sum of w_i c_i^k Gamma((N+k)/2) / Gamma(N/2). For even k the first factor is a sum of integers, and exactly zero
    /// where a moment vanishes.
    pub fn moment<T: Real>(self, dimension: usize, k: u32) -> DoubleWord<T> {
        let power = |c: &Component| {
            // c^k = 2^(k log_square / 2)
            let twice = c.log_square.saturating_mul(k as i32);
            let whole = DoubleWord::from(T::from_i32(c.numerator)).ldexp(twice / 2);
            if twice % 2 == 0 { whole } else { whole * DoubleWord::from(T::TWO).sqrt() }
        };
        let sum = self.components.iter().map(power).fold(DoubleWord::ZERO, |sum, c| sum + c);
        // Gamma((N+k)/2) / Gamma(N/2), by steps of two down to Gamma(1/2) = sqrt(pi), Gamma(1) = 1
        let mut gamma = DoubleWord::ONE;
        let mut twice = dimension as u32 + k;
        while twice > 2 {
            twice -= 2;
            gamma = gamma * T::from_i32(twice as i32) * T::HALF;
        }
        let root = DoubleWord::pi().sqrt();
        match (dimension % 2, twice % 2) {
            (1, 0) => gamma = gamma / root,
            (0, 1) => gamma = gamma * root,
            _ => {}
        }
        if dimension == 3 {
            // Gamma(3/2) is half of Gamma(1/2).
            gamma = gamma * T::TWO;
        }
        sum * gamma / T::from_i32(self.denominator)
    }

    pub fn place<T: Real, const D: usize>(self, delta: Distance<T>, r: Distance<T>) -> Around<T, D> {
        Around { shape: self, delta, r, ratio: r.squared().over(delta.squared()) }
    }
}

/// A point at some distance.
#[derive(Clone, Copy, Debug)]
pub(super) struct Around<T, const D: usize> {
    shape: Gaussian,
    delta: Distance<T>,
    r: Distance<T>,
    /// (r/delta)^2
    ratio: Scaled<T>,
}

/// e^-xi, M_a(xi), M_(a+1)(xi).
struct Kummer<T> {
    xi: DoubleWord<T>,
    decay: DoubleWord<T>,
    lower: DoubleWord<T>,
    upper: DoubleWord<T>,
}

impl<T: Real> Kummer<T> {
    /// For 0 <= xi <= `DIGITS`, a = `dimension` / 2.
    fn new(dimension: usize, xi: DoubleWord<T>) -> Self {
        let (m, n) = exp(-xi);
        let decay = m.ldexp(n);
        let half_odd = |k: usize| T::from_usize(dimension + 2 * k) * T::HALF;
        let (mut sum, mut term) = (DoubleWord::ONE, DoubleWord::ONE);
        // Terms decrease once k > xi; at k = 200 by more than a factor 3 each.
        for k in 0..200 {
            term = term * xi / half_odd(k + 2);
            sum = sum + term;
            if term.hi <= sum.hi * T::EPSILON * T::EPSILON {
                break;
            }
        }
        let upper = decay * sum;
        Self { xi, decay, upper, lower: decay + xi * upper / half_odd(1) }
    }
}

impl<T: Real, const D: usize> Around<T, D> {
    pub fn value(&self, quantity: Quantity) -> Scaled<T> {
        match quantity {
            Quantity::Density => self.density(),
            Quantity::DensitySlope => self.density_slope(),
            Quantity::Potential => self.potential(),
            Quantity::GradientFactor => self.gradient(),
            Quantity::HessianFactor => self.hessian(),
            Quantity::EnclosedMass => self.enclosed_mass(),
        }
    }

    /// The sum over the Gaussians of weight times `near(kummer, log_square)`, or times `far` where the field is Newtonian.
    fn sum(&self, near: impl Fn(&Kummer<T>, i32) -> Scaled<T>, far: impl Fn() -> Scaled<T>) -> Scaled<T> {
        self.weighted(|c| {
            let xi = self.ratio.shift(-c).double_word();
            if xi.hi > T::from_i32(T::DIGITS as i32) { far() } else { near(&Kummer::new(D, xi), c) }
        })
    }

    fn weighted(&self, term: impl Fn(i32) -> Scaled<T>) -> Scaled<T> {
        let sum =
            self.shape.components.iter().fold(Scaled::ZERO, |sum, c| {
                sum.plus(term(c.log_square).times(Scaled::from(T::from_i32(c.numerator))))
            });
        sum.over(Scaled::from(T::from_i32(self.shape.denominator)))
    }

    /// pi^(N/2) L^power for L^2 = 2^log_square delta^2.
    fn norm(&self, log_square: i32, power: u32) -> Scaled<T> {
        let pi = DoubleWord::pi();
        let pi = match D {
            1 => pi.sqrt(),
            2 => pi,
            _ => pi * pi.sqrt(),
        };
        // An integer: in 1D and 3D log_square is even, in 2D the power is.
        self.delta.power(power).scale(pi).shift(log_square * power as i32 / 2)
    }

    /// The sum of w_i e^-xi_i / (pi^(N/2) L_i^power).
    fn decaying(&self, power: u32) -> Scaled<T> {
        self.weighted(|c| {
            let xi = self.ratio.shift(-c).double_word();
            // At this distance nothing is representable, even divided by delta^5 for any delta of T.
            if xi.hi > T::from_i32(8192) {
                return Scaled::ZERO;
            }
            let (m, n) = exp(-xi);
            Scaled::new(m, n).over(self.norm(c, power))
        })
    }

    fn density(&self) -> Scaled<T> {
        self.decaying(D as u32)
    }

    fn density_slope(&self) -> Scaled<T> {
        self.decaying(D as u32 + 2).times(Scaled::from(-T::TWO))
    }

    fn gradient(&self) -> Scaled<T> {
        let n = D as u32;
        let near = |kummer: &Kummer<T>, c: i32| {
            Scaled::new(kummer.lower, 0).over(self.norm(c, n)).over(Scaled::from(T::from_i32(n as i32)))
        };
        self.sum(near, || self.newtonian().gradient())
    }

    fn hessian(&self) -> Scaled<T> {
        let n = D as u32;
        let near = |kummer: &Kummer<T>, c: i32| {
            let factor = Scaled::from(-T::TWO).over(Scaled::from(T::from_i32(n as i32 + 2)));
            Scaled::new(kummer.upper, 0).times(factor).over(self.norm(c, n + 2))
        };
        self.sum(near, || self.newtonian().hessian())
    }

    fn potential(&self) -> Scaled<T> {
        if D == 3 {
            let near = |kummer: &Kummer<T>, c: i32| {
                let fall = kummer.decay + kummer.xi * kummer.lower / (T::ONE + T::HALF);
                Scaled::new(-fall, -1).over(self.norm(c, 1))
            };
            return self.sum(near, || self.newtonian().potential());
        }
        if D == 1 {
            let near = |kummer: &Kummer<T>, c: i32| {
                let rise = kummer.decay + kummer.xi * kummer.lower * T::TWO;
                // L / (2 sqrt(pi)) = L^2 / (2 sqrt(pi) L)
                let square = self.delta.squared().shift(c);
                Scaled::new(rise, -1).times(square).over(self.norm(c, 1))
            };
            return self.sum(near, || self.newtonian().potential());
        }
        let log_delta = self.delta.log();
        let near = |kummer: &Kummer<T>, c: i32| {
            let log_width = log_delta + log_2() * T::from_i32(c) * T::HALF;
            Scaled::new(log_width + (entire_exponential_integral(kummer.xi) - euler()) * T::HALF, 0).over(sphere(2))
        };
        self.sum(near, || self.newtonian().potential())
    }

    /// S_N r^N g.
    fn enclosed_mass(&self) -> Scaled<T> {
        self.gradient().times(sphere(D)).times(self.r.power(D as u32))
    }

    fn newtonian(&self) -> Newtonian<T, D> {
        Newtonian { r: self.r }
    }
}

//! Sums over sources of the Newtonian kernel with a compact mollifier, pair by pair in double-double arithmetic.
//!
//! Distances are scaled by a power of two before they are squared, so 1e-300 and 1e+150 are computed as accurately as 1. Inside the
//! support the formulas follow from the definition: G is the Taylor series of (1-t)^(-N/2), cut after t^M, plus for order 4 the
//! term (M + 2 + N/2) a_(M+1) t^(M+1). The potential is that of the edge plus the integral of the gradient.

/// A sum of two numbers, the second below half an ulp of the first.
#[derive(Clone, Copy, Debug, Default)]
pub struct Dd(pub f64, pub f64);

impl Dd {
    fn sum(a: f64, b: f64) -> Self {
        let s = a + b;
        let bb = s - a;
        Dd(s, (a - (s - bb)) + (b - bb))
    }
    fn product(a: f64, b: f64) -> Self {
        let p = a * b;
        Dd(p, a.mul_add(b, -p))
    }
    /// Nearest f64.
    pub fn value(self) -> f64 {
        self.0 + self.1
    }
    fn scale(self, two_to: i32) -> Self {
        let half = two_to / 2;
        let (a, b) = (2_f64.powi(half), 2_f64.powi(two_to - half));
        Dd(self.0 * a * b, self.1 * a * b)
    }
    fn sqrt(self) -> Self {
        let s = self.0.sqrt();
        let rest = self - Dd::product(s, s);
        Dd::sum(s, rest.0 / (2.0 * s))
    }
    /// e^x for |x| < 750, to about 1e-30.
    fn exp(self) -> Self {
        let k = (self.0 / std::f64::consts::LN_2).round();
        let r = (self - LN_2 * Dd(k, 0.0)) * Dd(1.0 / 256.0, 0.0);
        let (mut term, mut sum) = (Dd(1.0, 0.0), Dd(1.0, 0.0));
        for n in 1..14 {
            term = term * r / Dd(f64::from(n), 0.0);
            sum = sum + term;
        }
        for _ in 0..8 {
            sum = sum * sum;
        }
        sum.scale(k as i32)
    }
    /// log x: one Newton step on e^y = x from the f64 logarithm.
    fn ln(self) -> Self {
        let y = Dd(self.0.ln(), 0.0);
        let rest = self * (Dd(0.0, 0.0) - y).exp() - Dd(1.0, 0.0);
        y + rest - rest * rest * Dd(0.5, 0.0)
    }
}

impl std::ops::Add for Dd {
    type Output = Dd;
    fn add(self, o: Dd) -> Dd {
        let s = Dd::sum(self.0, o.0);
        let t = Dd::sum(self.1, o.1);
        let r = Dd::sum(s.0, s.1 + t.0);
        Dd::sum(r.0, r.1 + t.1)
    }
}
impl std::ops::Sub for Dd {
    type Output = Dd;
    fn sub(self, o: Dd) -> Dd {
        self + Dd(-o.0, -o.1)
    }
}
impl std::ops::Mul for Dd {
    type Output = Dd;
    fn mul(self, o: Dd) -> Dd {
        let p = Dd::product(self.0, o.0);
        Dd::sum(p.0, p.1 + (self.0 * o.1 + self.1 * o.0))
    }
}
impl std::ops::Div for Dd {
    type Output = Dd;
    fn div(self, o: Dd) -> Dd {
        let q = self.0 / o.0;
        let r = self - o * Dd(q, 0.0);
        let q2 = r.0 / o.0;
        let r = r - o * Dd(q2, 0.0);
        Dd::sum(q, q2) + Dd(r.0 / o.0, 0.0)
    }
}

const LN_2: Dd = Dd(std::f64::consts::LN_2, 2.319_046_813_846_299_6e-17);
const PI: Dd = Dd(std::f64::consts::PI, 1.224_646_799_147_353_2e-16);

/// A compact mollifier of order 2 or 4, with its length.
#[derive(Clone, Copy, Debug)]
pub struct Soft {
    /// 2 or 4.
    pub order: u32,
    /// M.
    pub exponent: u32,
    /// delta.
    pub delta: f64,
}

/// The sums at one target, and the same sums of magnitudes, which errors are measured against.
#[derive(Clone, Copy, Debug, Default)]
pub struct Sums {
    /// sum m K.
    pub potential: Dd,
    /// sum m grad K.
    pub gradient: [Dd; 3],
    /// sum m psi.
    pub laplacian: Dd,
    /// sum |m K|.
    pub potential_size: f64,
    /// sum |m grad K|, by component.
    pub gradient_size: [f64; 3],
    /// sum |m| max psi over pairs inside the support.
    pub laplacian_size: f64,
    /// sum |m|.
    pub mass: f64,
}

/// The sums at `target` in dimension `D`; unmollified, coincident pairs add nothing.
pub fn newtonian<const D: usize>(
    soft: Option<Soft>,
    positions: &[[f64; D]],
    masses: &[f64],
    target: &[f64; D],
) -> Sums {
    let mut sums = Sums::default();
    let measure = match D {
        1 => Dd(2.0, 0.0),
        2 => PI * Dd(2.0, 0.0),
        _ => PI * Dd(4.0, 0.0),
    };
    let n = D as i32;
    for (x, &m) in positions.iter().zip(masses) {
        let d: [Dd; D] = std::array::from_fn(|k| Dd::sum(target[k], -x[k]));
        let largest = d.iter().map(|d| d.0.abs()).fold(0.0, f64::max);
        if (largest == 0.0 && soft.is_none()) || m == 0.0 {
            continue;
        }
        // In units of 2^e every coordinate is below 2, and the largest coordinate, or delta, is at least 1/2.
        let unit = soft.map_or(largest, |s| largest.max(s.delta));
        let e = exponent(unit);
        let d = d.map(|d| d.scale(-e));
        let r2 = d.iter().fold(Dd::default(), |s, &d| s + d * d);
        let delta = soft.map(|s| Dd(s.delta, 0.0).scale(-e));
        let one = Dd(1.0, 0.0);
        // K, g and psi in these units: K_true = K 2^(e (2 - n)) (+ e log 2 in 2D), g and psi 2^(-n e).
        let (k, g, psi, psi_size) = match (soft, delta) {
            (Some(s), Some(delta)) if r2.0 < (delta * delta).0 => inside(n, s, r2 / (delta * delta), delta),
            _ => {
                let r = r2.sqrt();
                match D {
                    1 => (r, one / r, Dd::default(), 0.0),
                    2 => (r2.ln() * Dd(0.5, 0.0), one / r2, Dd::default(), 0.0),
                    _ => (Dd(-1.0, 0.0) / r, one / (r2 * r), Dd::default(), 0.0),
                }
            }
        };
        let m = Dd(m, 0.0);
        let k = if D == 2 { k + LN_2 * Dd(f64::from(e), 0.0) } else { k.scale(e * (2 - n)) };
        let term = m * k / measure;
        sums.potential = sums.potential + term;
        sums.potential_size += term.0.abs();
        for (&d, (sum, size)) in d.iter().zip(sums.gradient.iter_mut().zip(&mut sums.gradient_size)) {
            // g d scales by 2^(e (1 - n)).
            let term = (m * g * d / measure).scale(e * (1 - n));
            *sum = *sum + term;
            *size += term.0.abs();
        }
        let term = (m * psi / measure).scale(-n * e);
        sums.laplacian = sums.laplacian + term;
        sums.laplacian_size += (Dd(m.0.abs() * psi_size, 0.0) / measure).scale(-n * e).0;
        sums.mass += m.0.abs();
    }
    sums
}

/// (K, g, psi, max psi) times S_D at s = (r/delta)^2 < 1.
fn inside(n: i32, soft: Soft, s: Dd, delta: Dd) -> (Dd, Dd, Dd, f64) {
    let one = Dd(1.0, 0.0);
    let number = |x: f64| Dd(x, 0.0);
    let t = one - s;
    let half_n = f64::from(n) / 2.0;
    // a_k = (n/2)_k / k!
    let mut a = vec![one];
    for k in 0..=soft.exponent {
        let k = f64::from(k);
        let last = a[a.len() - 1];
        a.push(last * number(half_n + k) / number(k + 1.0));
    }
    let m = soft.exponent as usize;
    let mut coefficients = a[..=m].to_vec();
    if soft.order == 4 {
        coefficients.push(a[m + 1] * number(m as f64 + 2.0 + half_n));
    }
    // phi' = G r / delta^n and r dr = -delta^2 dt / 2: phi(t) = phi(edge) - delta^(2-n) / 2 * integral of G from 0 to t.
    let (mut g, mut integral, mut slope, mut power) = (Dd::default(), Dd::default(), Dd::default(), one);
    let mut before = Dd::default();
    for (k, &c) in coefficients.iter().enumerate() {
        g = g + c * power;
        slope = slope + c * number(k as f64) * before;
        before = power;
        power = power * t;
        integral = integral + c * power / number(k as f64 + 1.0);
    }
    let length = |p: i32| (0..p.abs()).fold(one, |x, _| if p < 0 { x / delta } else { x * delta });
    let edge = match n {
        1 => delta,
        2 => delta.ln(),
        _ => number(-1.0) / delta,
    };
    let k = edge - length(2 - n) * integral * number(0.5);
    // Laplacian: n g + r g' with g' = dG/dt dt/dr: b = n G - 2 s G'.
    let b = (g * number(f64::from(n)) - s * slope * number(2.0)) * length(-n);
    // |b| <= n G(1) + 2 G'(1): a rough maximum for measuring rounding errors.
    let size: f64 = coefficients.iter().enumerate().map(|(k, c)| c.0 * (f64::from(n) + 2.0 * k as f64)).sum();
    (k, g * length(-n), b, size * length(-n).0)
}

/// e with 1/2 <= x / 2^e < 1.
fn exponent(x: f64) -> i32 {
    if x == 0.0 {
        return 0;
    }
    let (x, extra) = if x < 1e-290 { (x * 2_f64.powi(200), -200) } else { (x, 0) };
    ((x.to_bits() >> 52) & 0x7FF) as i32 - 1022 + extra
}

#[cfg(test)]
mod tests {
    use super::*;

    /// log 2 and log 10 to 30 digits. The two formulas agree at the edge of the support.
    #[test]
    fn the_twin_itself() {
        let ln_10 = Dd(10.0, 0.0).ln();
        assert!((ln_10.0 - std::f64::consts::LN_10).abs() < 1e-15);
        let back = ln_10.exp() - Dd(10.0, 0.0);
        assert!(back.value().abs() < 1e-28, "{back:?}");
        let soft = Some(Soft { order: 4, exponent: 3, delta: 0.5 });
        for x in [0.5 * (1.0 - 1e-15), 0.5] {
            let s = newtonian::<3>(soft, &[[0.0; 3]], &[1.0], &[x, 0.0, 0.0]);
            let want = -1.0 / (4.0 * std::f64::consts::PI * x);
            assert!((s.potential.value() / want - 1.0).abs() < 1e-14);
        }
    }
}

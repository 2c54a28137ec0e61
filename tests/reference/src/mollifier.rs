//! Compact mollifiers from their definition: (1 - s)^M times a polynomial whose coefficients solve the moment conditions; fields
//! by quadrature. Accurate to about 1e-11.

/// Composite Gauss-Legendre of 5 points: the integral of f over [a, b].
fn integral(a: f64, b: f64, f: impl Fn(f64) -> f64) -> f64 {
    const NODES: [(f64, f64); 3] = [
        (0.0, 128.0 / 225.0),
        (0.538_469_310_105_683_1, 0.478_628_670_499_366_47),
        (0.906_179_845_938_664, 0.236_926_885_056_189_08),
    ];
    let pieces = 64;
    let half = (b - a) / (2.0 * f64::from(pieces));
    let mut sum = 0.0;
    for i in 0..pieces {
        let middle = a + half * f64::from(2 * i + 1);
        for (x, w) in NODES {
            let pair = if x == 0.0 { f(middle) } else { f(middle - half * x) + f(middle + half * x) };
            sum += w * half * pair;
        }
    }
    sum
}

/// The measure of the unit sphere.
fn sphere(dimension: u32) -> f64 {
    [2.0, 2.0 * std::f64::consts::PI, 4.0 * std::f64::consts::PI][dimension as usize - 1]
}

/// The solution of linear equations whose right sides are the last column, by Gauss elimination with partial pivoting.
fn solved(mut matrix: Vec<Vec<f64>>) -> Vec<f64> {
    let k = matrix.len();
    for c in 0..k {
        let pivot = (c..k).max_by(|&a, &b| matrix[a][c].abs().total_cmp(&matrix[b][c].abs())).unwrap();
        matrix.swap(c, pivot);
        for r in 0..k {
            if r != c {
                let factor = matrix[r][c] / matrix[c][c];
                let row = matrix[c].clone();
                for (entry, from) in matrix[r].iter_mut().zip(row) {
                    *entry -= factor * from;
                }
            }
        }
    }
    (0..k).map(|i| matrix[i][k] / matrix[i][i]).collect()
}

/// A compact mollifier with radius 1.
pub struct Compact {
    dimension: u32,
    exponent: u32,
    coefficients: Vec<f64>,
}

impl Compact {
    /// Solves for unit mass and vanishing moments 2, 4, ..., order - 2.
    pub fn new(dimension: u32, order: u32, exponent: u32) -> Self {
        let k = order as usize / 2;
        let mut matrix = vec![vec![0.0; k + 1]; k];
        for (i, row) in matrix.iter_mut().enumerate() {
            for (j, entry) in row.iter_mut().take(k).enumerate() {
                let power = (exponent as usize + j) as i32;
                let moment = (2 * i) as i32 + dimension as i32 - 1;
                *entry = sphere(dimension) * integral(0.0, 1.0, |r| (1.0 - r * r).powi(power) * r.powi(moment));
            }
            row[k] = if i == 0 { 1.0 } else { 0.0 };
        }
        Self { dimension, exponent, coefficients: solved(matrix) }
    }

    /// B(r).
    pub fn density(&self, r: f64) -> f64 {
        if r > 1.0 {
            return 0.0;
        }
        let t = 1.0 - r * r;
        self.coefficients.iter().enumerate().map(|(j, c)| c * t.powi((self.exponent as usize + j) as i32)).sum()
    }

    /// The mass within r.
    pub fn mass(&self, r: f64) -> f64 {
        sphere(self.dimension) * integral(0.0, r.min(1.0), |s| s.powi(self.dimension as i32 - 1) * self.density(s))
    }

    /// phi'(r)/r.
    pub fn gradient_factor(&self, r: f64) -> f64 {
        self.mass(r) / (sphere(self.dimension) * r.powi(self.dimension as i32))
    }

    /// phi(r), by integration from its value at the edge.
    pub fn potential(&self, r: f64) -> f64 {
        let edge = match self.dimension {
            1 => 0.5,
            2 => 0.0,
            _ => -1.0 / (4.0 * std::f64::consts::PI),
        };
        edge - integral(r, 1.0, |s| s * self.gradient_factor(s))
    }
}

/// A Richardson combination of compact mollifiers of order 2, with radius 1.
pub struct Combination {
    part: Compact,
    /// Weights and radii.
    pub parts: Vec<(f64, f64)>,
}

impl Combination {
    /// Solves for unit mass and vanishing moments 2, 4, ...: one condition for each radius.
    pub fn new(dimension: u32, exponent: u32, radii: &[f64]) -> Self {
        let equation = |i: usize| {
            let powers = radii.iter().map(|radius| radius.powi(2 * i as i32));
            powers.chain([if i == 0 { 1.0 } else { 0.0 }]).collect()
        };
        let weights = solved((0..radii.len()).map(equation).collect());
        let parts = weights.into_iter().zip(radii.iter().copied()).collect();
        Self { part: Compact::new(dimension, 2, exponent), parts }
    }

    fn sum(&self, f: impl Fn(&Compact, f64) -> f64) -> f64 {
        self.parts.iter().map(|&(weight, radius)| weight * f(&self.part, radius)).sum()
    }

    /// B(r).
    pub fn density(&self, r: f64) -> f64 {
        self.sum(|part, radius| part.density(r / radius) / radius.powi(part.dimension as i32))
    }

    /// The mass within r.
    pub fn mass(&self, r: f64) -> f64 {
        self.sum(|part, radius| part.mass(r / radius))
    }

    /// phi'(r)/r.
    pub fn gradient_factor(&self, r: f64) -> f64 {
        self.mass(r) / (sphere(self.part.dimension) * r.powi(self.part.dimension as i32))
    }

    /// phi(r).
    pub fn potential(&self, r: f64) -> f64 {
        self.sum(|part, radius| {
            let unit = part.potential(r / radius);
            match part.dimension {
                1 => radius * unit,
                2 => unit + radius.ln() / (2.0 * std::f64::consts::PI),
                _ => unit / radius,
            }
        })
    }
}

//! Reference implementation of the mesh field: deposit in floating point, the five-point matrix, dense elimination, interpolation.

/// A mesh of `cells` on `[lower, upper]` with screening k. Free space, or walls without flux.
#[derive(Clone, Copy, Debug)]
pub struct Case {
    /// The lower left corner.
    pub lower: [f64; 2],
    /// The upper right corner.
    pub upper: [f64; 2],
    /// Cells along x and y.
    pub cells: [usize; 2],
    /// k of Laplacian(u) - k^2 u.
    pub screening: f64,
    /// Walls without flux instead of free space.
    pub no_flux: bool,
}

/// Results: masses and potential at the nodes, and the gradient at the targets.
#[derive(Clone, Debug)]
pub struct Field {
    /// Node (i, j) at j (nx + 1) + i.
    pub masses: Vec<f64>,
    /// In the order of `masses`.
    pub potential: Vec<f64>,
    /// One for each target.
    pub gradient: Vec<[f64; 2]>,
}

/// K0(x), K1(x) by the trapezoidal rule on int_0^inf exp(-x cosh t) cosh(n t) dt, which converges geometrically.
fn bessel(x: f64) -> [f64; 2] {
    let h = 1.0 / 64.0;
    let mut sums = [0.5 * (-x).exp(); 2];
    for n in 1..2000 {
        let t = h * f64::from(n);
        let e = (-x * t.cosh()).exp();
        sums[0] += e;
        sums[1] += e * t.cosh();
        if e == 0.0 {
            break;
        }
    }
    sums.map(|s| s * h)
}

fn monopole(case: &Case, mass: f64, centre: [f64; 2], x: [f64; 2]) -> (f64, [f64; 2]) {
    let d = [x[0] - centre[0], x[1] - centre[1]];
    let r = d[0].hypot(d[1]);
    let two_pi = 2.0 * std::f64::consts::PI;
    let (v, slope) = if case.screening == 0.0 {
        (r.ln(), 1.0 / r)
    } else {
        let [k0, k1] = bessel(case.screening * r);
        (-k0, case.screening * k1)
    };
    (mass * v / two_pi, d.map(|d| mass * slope / two_pi * d / r))
}

/// The whole computation. Sources outside a free mesh count in the monopole only; with walls positions must lie inside.
#[must_use]
pub fn field(case: &Case, sources: &[[f64; 2]], masses: &[f64], targets: &[[f64; 2]]) -> Field {
    let [nx, ny] = case.cells;
    let h = (case.upper[0] - case.lower[0]) / nx as f64;
    let k = (case.upper[1] - case.lower[1]) / ny as f64;
    let at = |i: usize, j: usize| j * (nx + 1) + i;
    let nodes = (nx + 1) * (ny + 1);
    let node = |i: i64, j: i64| [case.lower[0] + i as f64 * h, case.lower[1] + j as f64 * k];
    let inside = |x: [f64; 2]| (0..2).all(|a| case.lower[a] <= x[a] && x[a] <= case.upper[a]);
    let place = |x: [f64; 2]| {
        let g = [(x[0] - case.lower[0]) / h, (x[1] - case.lower[1]) / k];
        let c = [(g[0].floor() as usize).min(nx - 1), (g[1].floor() as usize).min(ny - 1)];
        (c, [g[0] - c[0] as f64, g[1] - c[1] as f64])
    };

    let mut mass = vec![0.0; nodes];
    let (mut total, mut centre) = (0.0, [0.0; 2]);
    for (&x, &m) in sources.iter().zip(masses) {
        total += m;
        centre[0] += m * x[0];
        centre[1] += m * x[1];
        if inside(x) {
            let ([i, j], [fx, fy]) = place(x);
            mass[at(i, j)] += m * (1.0 - fx) * (1.0 - fy);
            mass[at(i + 1, j)] += m * fx * (1.0 - fy);
            mass[at(i, j + 1)] += m * (1.0 - fx) * fy;
            mass[at(i + 1, j + 1)] += m * fx * fy;
        }
    }
    let centre = centre.map(|c| c / total);

    // The dense system, one equation for each node.
    let mut a = vec![vec![0.0; nodes + 1]; nodes];
    let singular = case.no_flux && case.screening == 0.0;
    let mean = total / ((case.upper[0] - case.lower[0]) * (case.upper[1] - case.lower[1]));
    for j in 0..=ny {
        for i in 0..=nx {
            let row = &mut a[at(i, j)];
            let (ex, ey) = (i == 0 || i == nx, j == 0 || j == ny);
            if !case.no_flux && (ex || ey) {
                row[at(i, j)] = 1.0;
                row[nodes] = monopole(case, total, centre, node(i as i64, j as i64)).0;
                continue;
            }
            let mirror = |i: i64, n: usize| {
                if i < 0 {
                    1
                } else if i as usize > n {
                    n - 1
                } else {
                    i as usize
                }
            };
            for (di, dj, w) in [(-1, 0, h), (1, 0, h), (0, -1, k), (0, 1, k)] {
                row[at(mirror(i as i64 + di, nx), mirror(j as i64 + dj, ny))] += 1.0 / (w * w);
                row[at(i, j)] -= 1.0 / (w * w);
            }
            row[at(i, j)] -= case.screening * case.screening;
            let area = h * k * if ex { 0.5 } else { 1.0 } * if ey { 0.5 } else { 1.0 };
            row[nodes] = mass[at(i, j)] / area - if singular { mean } else { 0.0 };
        }
    }
    if singular {
        // One equation follows from the others. It is replaced by: the mean is zero.
        a[0].fill(0.0);
        for j in 0..=ny {
            for i in 0..=nx {
                let share = |i: usize, n: usize| if i == 0 || i == n { 0.5 } else { 1.0 };
                a[0][at(i, j)] = share(i, nx) * share(j, ny);
            }
        }
    }
    let u = eliminate(a);

    // Centred differences, interpolated bilinearly.
    let value = |i: i64, j: i64| {
        let (n, m) = (nx as i64, ny as i64);
        if case.no_flux {
            let fold = |i: i64, n: i64| {
                if i < 0 {
                    -i
                } else if i > n {
                    2 * n - i
                } else {
                    i
                }
            };
            u[at(fold(i, n) as usize, fold(j, m) as usize)]
        } else if i < 0 || j < 0 || i > n || j > m {
            monopole(case, total, centre, node(i, j)).0
        } else {
            u[at(i as usize, j as usize)]
        }
    };
    let slope = |i: usize, j: usize| {
        let (i, j) = (i as i64, j as i64);
        [(value(i + 1, j) - value(i - 1, j)) / (2.0 * h), (value(i, j + 1) - value(i, j - 1)) / (2.0 * k)]
    };
    let gradient = targets
        .iter()
        .map(|&x| {
            if !inside(x) {
                return monopole(case, total, centre, x).1;
            }
            let ([i, j], [fx, fy]) = place(x);
            let corners = [
                (slope(i, j), (1.0 - fx) * (1.0 - fy)),
                (slope(i + 1, j), fx * (1.0 - fy)),
                (slope(i, j + 1), (1.0 - fx) * fy),
                (slope(i + 1, j + 1), fx * fy),
            ];
            [0, 1].map(|a: usize| corners.iter().map(|(g, w)| g[a] * w).sum())
        })
        .collect();
    Field { masses: mass, potential: u, gradient }
}

/// Gauss with partial pivoting; each row ends with its right-hand side.
fn eliminate(mut a: Vec<Vec<f64>>) -> Vec<f64> {
    let n = a.len();
    for c in 0..n {
        let pivot = (c..n).max_by(|&p, &q| a[p][c].abs().total_cmp(&a[q][c].abs())).unwrap_or(c);
        a.swap(c, pivot);
        let (top, below) = a.split_at_mut(c + 1);
        let top = &top[c];
        for row in below {
            let f = row[c] / top[c];
            if f != 0.0 {
                for (x, t) in row.iter_mut().zip(top).skip(c) {
                    *x -= f * t;
                }
            }
        }
    }
    let mut x = vec![0.0; n];
    for r in (0..n).rev() {
        let sum: f64 = (r + 1..n).map(|c| a[r][c] * x[c]).sum();
        x[r] = (a[r][n] - sum) / a[r][r];
    }
    x
}

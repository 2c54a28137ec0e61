//! Properties of the whole: conservation, adjointness, the scheme itself, free-space fields.

use super::*;
use crate::parallel::Serial;
use crate::space::ALIGN;
use std::vec;
use std::vec::Vec;

pub(super) fn unit(seed: &mut u64) -> f64 {
    *seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
    ((*seed >> 11) as f64 + 0.5) / 2.0_f64.powi(53)
}

pub(super) fn aligned(memory: &mut [u8], bytes: usize) -> &mut [u8] {
    let start = memory.as_ptr().align_offset(ALIGN);
    &mut memory[start..start + bytes]
}

/// Runs `body` with a grid in dirty memory ringed by canaries.
pub(super) fn with_grid<T: Real, R>(
    mesh: Mesh<T>,
    equation: Equation<T>,
    workers: usize,
    body: impl FnOnce(&mut Grid<'_, T>) -> R,
) -> R {
    let bytes = Grid::workspace_bytes(&mesh, &equation, workers).unwrap();
    let mut memory = vec![0xA5_u8; bytes + 4 * ALIGN];
    let whole = aligned(&mut memory, bytes + 2 * ALIGN);
    let result = body(&mut Grid::prepare(&mut whole[ALIGN..ALIGN + bytes], mesh, equation, workers).unwrap());
    assert!(whole[..ALIGN].iter().chain(&whole[ALIGN + bytes..]).all(|&b| b == 0xA5), "a canary is dead");
    result
}

fn cloud(n: usize, lower: [f64; 2], upper: [f64; 2], seed: u64) -> (Vec<[f64; 2]>, Vec<f64>) {
    let mut s = seed;
    let x = (0..n).map(|_| [0, 1].map(|k: usize| lower[k] + (upper[k] - lower[k]) * unit(&mut s))).collect();
    (x, (0..n).map(|_| 0.1 + unit(&mut s)).collect())
}

/// |Laplacian(u) - k^2 u - f|, with the operators of the scheme's order, at the nodes it holds at, relative to the largest term of its sum.
fn residual(grid: &Grid<'_, f64>) -> f64 {
    let [n, m] = grid.mesh().cells();
    let [h, k] = grid.mesh().spacing();
    let mut u = vec![0.0; grid.mesh().nodes()];
    grid.potential(&mut u).unwrap();
    let words = grid.words();
    let at = |i: usize, j: usize| j * (n + 1) + i;
    let no_flux = grid.equation().walls == Walls::NoFlux;
    let kappa = grid.equation().screening;
    let per_unit = grid.scale().unit() / (h * k);
    let mut mean = 0.0;
    if no_flux && kappa == 0.0 {
        mean = words[..(n + 1) * (m + 1)].iter().sum::<i64>() as f64 * per_unit / (n * m) as f64;
    }
    let largest = u.iter().fold(0.0_f64, |a, b| a.max(b.abs()));
    let mut worst = 0.0_f64;
    let range = |n: usize| if no_flux { 0..n + 1 } else { 1..n };
    // Mirrored at walls.
    let before = |i: usize| if i == 0 { 1 } else { i - 1 };
    let after = |i: usize, n: usize| if i == n { n - 1 } else { i + 1 };
    let share = |i: usize, n: usize| if no_flux && (i == 0 || i == n) { 2.0 } else { 1.0 };
    let f = |i: usize, j: usize| words[at(i, j)] as f64 * per_unit * share(i, n) * share(j, m) - mean;
    let u = |i: usize, j: usize| u[at(i, j)];
    // Unscaled second differences.
    let bend_x = |of: &dyn Fn(usize, usize) -> f64, i, j| of(before(i), j) - 2.0 * of(i, j) + of(after(i, n), j);
    let bend_y = |of: &dyn Fn(usize, usize) -> f64, i, j| of(i, before(j)) - 2.0 * of(i, j) + of(i, after(j, m));
    for j in range(m) {
        for i in range(n) {
            let (x, y) = (bend_x(&u, i, j), bend_y(&u, i, j));
            let mut r = x / (h * h) + y / (k * k) - kappa * kappa * u(i, j) - f(i, j);
            if grid.equation().order == Order::Fourth {
                let both = bend_y(&|i, j| bend_x(&u, i, j), i, j);
                r += (h * h + k * k) / (12.0 * h * h * k * k) * both - kappa * kappa / 12.0 * (x + y)
                    + (bend_x(&f, i, j) + bend_y(&f, i, j)) / 12.0;
            }
            worst = worst.max(r.abs());
        }
    }
    worst / (largest * (4.0 / (h * h) + 4.0 / (k * k)))
}

#[test]
fn the_scheme_holds_in_every_setting() {
    for cells in [[2, 2], [3, 5], [7, 4], [4, 3], [16, 16], [16, 12], [12, 10], [13, 30], [31, 17], [31, 23], [64, 47]]
    {
        let mesh = Mesh::new([-1.0, 0.0], [1.0, 1.5], cells).unwrap();
        for screening in [0.0, 3.0] {
            for walls in [Walls::Free, Walls::FreeQuadrupole, Walls::NoFlux] {
                if walls == Walls::FreeQuadrupole && screening > 0.0 {
                    continue;
                }
                let (x, m) = cloud(200, [-1.1, -0.1], [1.1, 1.6], 5);
                let worst = with_grid(mesh, Equation { screening, walls, order: Order::Second }, 1, |grid| {
                    grid.deposit(&x, &m, &Serial).unwrap();
                    grid.solve(&Serial).unwrap();
                    residual(grid)
                });
                assert!(worst < 1e-14, "{cells:?} {screening} {walls:?}: {worst:e}");
                // Nearly square cells that resolve the screening.
                let h = 2.0 / cells[0] as f64;
                let mesh = Mesh::new([-1.0, 0.0], [1.0, 1.1 * h * cells[1] as f64], cells).unwrap();
                let equation = Equation { screening: screening.min(0.9 / h), walls, order: Order::Fourth };
                let worst = with_grid(mesh, equation, 1, |grid| {
                    grid.deposit(&x, &m, &Serial).unwrap();
                    grid.solve(&Serial).unwrap();
                    residual(grid)
                });
                assert!(worst < 1e-14, "{cells:?} {equation:?}: {worst:e}");
            }
        }
    }
}

#[test]
fn mass_and_centre_are_kept() {
    let mesh = Mesh::new([-1.0, -2.0], [3.0, 1.0], [40, 30]).unwrap();
    let (x, m) = cloud(1000, [-1.5, -2.5], [3.5, 1.5], 9);
    with_grid(mesh, Equation::POISSON, 1, |grid| {
        grid.deposit(&x, &m, &Serial).unwrap();
        grid.solve(&Serial).unwrap();
        let units: i64 = grid.words()[..mesh.nodes()].iter().sum::<i64>() + grid.words()[mesh.nodes() + 1];
        let exact: i64 = m.iter().map(|m| fixed::nearest(m * grid.scale().per_mass())).sum();
        assert_eq!(units, exact);
        let outside = x.iter().filter(|x| !mesh.contains(**x)).count() as u64;
        assert!(outside > 100);
        assert_eq!(grid.outside(), outside);
        let total: f64 = m.iter().sum();
        for k in 0..2 {
            let centre = x.iter().zip(&m).map(|(x, m)| x[k] * m).sum::<f64>() / total;
            // A few units of 2^-49 M each for 1000 particles, times the mesh's width; the tail's units are 2^10 larger.
            assert!((grid.monopole().centre[k] - centre).abs() < 4.0 * 1000.0 * 2.0_f64.powi(-39), "{k}");
        }
        assert!((grid.monopole().mass / total - 1.0).abs() < 1000.0 * 2.0_f64.powi(-49));
    });
}

#[test]
fn a_far_particle_sees_the_monopole_and_a_near_one_the_logarithm() {
    let mesh = Mesh::new([-1.0, -1.0], [1.0, 1.0], [128, 128]).unwrap();
    with_grid(mesh, Equation::POISSON, 1, |grid| {
        grid.deposit(&[[0.0, 0.0]], &[2.0], &Serial).unwrap();
        grid.solve(&Serial).unwrap();
        for x in [[0.4, 0.3], [0.9, -0.9], [-0.99, 0.995], [5.0, 6.0]] {
            let g = grid.gradient_at(x);
            let r2 = x[0] * x[0] + x[1] * x[1];
            for k in 0..2 {
                let exact = 2.0 * x[k] / (2.0 * core::f64::consts::PI * r2);
                assert!((g[k] - exact).abs() < 2e-3 / r2.sqrt(), "{x:?} {g:?} {exact}");
            }
        }
    });
}

#[test]
fn interpolation_is_the_adjoint_of_the_deposit() {
    let mesh = Mesh::new([0.0, 0.0], [1.0, 2.0], [19, 24]).unwrap();
    for walls in [Walls::Free, Walls::FreeQuadrupole, Walls::NoFlux] {
        let (x, m) = match walls {
            Walls::Free | Walls::FreeQuadrupole => cloud(500, [0.0, 0.0], [1.0, 2.0], 3),
            Walls::NoFlux => cloud(500, [-0.5, -0.7], [1.5, 2.7], 3),
        };
        with_grid(mesh, Equation { screening: 0.0, walls, ..Equation::POISSON }, 1, |grid| {
            grid.deposit(&x, &m, &Serial).unwrap();
            grid.solve(&Serial).unwrap();
            let nodes: [f64; 2] = [0, 1].map(|k: usize| {
                grid.words().iter().zip(grid.gradient()).map(|(&w, g)| w as f64 * grid.scale().unit() * g[k]).sum()
            });
            let mut at = vec![[0.0; 2]; x.len()];
            grid.interpolate(&x, &mut at, &Serial).unwrap();
            let mut size = 0.0;
            let mut particles = [0.0; 2];
            for ((x, m), g) in x.iter().zip(&m).zip(&at) {
                let odd = mesh.reflect(*x).1;
                for k in 0..2 {
                    particles[k] += m * if odd[k] && walls == Walls::NoFlux { -g[k] } else { g[k] };
                    size += (m * g[k]).abs();
                }
            }
            for k in 0..2 {
                // Weights and sums round; a unit is 2^-49 of the mass.
                assert!((nodes[k] - particles[k]).abs() < 1e-13 * size);
            }
        });
    }
}

#[test]
fn what_is_removed_was_never_there() {
    for walls in [Walls::Free, Walls::NoFlux] {
        let mesh = Mesh::new([-1.0, -0.5], [1.0, 1.5], [12, 17]).unwrap();
        // Some of them outside.
        let (positions, masses) = cloud(500, [-1.2, -0.6], [1.3, 1.7], 5);
        let ((kept, gone), (kept_masses, gone_masses)) = (positions.split_at(300), masses.split_at(300));
        let scale = MassScale::of(&masses).unwrap();
        with_grid(mesh, Equation { walls, ..Equation::POISSON }, 1, |grid| {
            grid.begin(scale);
            grid.add(kept, kept_masses, &Serial).unwrap();
            let words = grid.words().to_vec();
            grid.begin(scale);
            grid.add(&positions, &masses, &Serial).unwrap();
            assert!(grid.words() != words);
            grid.remove(gone, gone_masses, &Serial).unwrap();
            assert_eq!(grid.words(), words);
        });
    }
}

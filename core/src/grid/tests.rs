//! Properties of the whole grid solver: conservation, adjointness, the equations of the scheme, free-space fields.

use super::*;
use crate::exec::Resources;
use crate::memory::ALIGN;
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

/// Runs `body` with a grid in dirty memory between canaries.
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

/// |Laplacian(u) - k^2 u - f| with the operators of the scheme's order, at the nodes of the scheme, relative to the largest term of the sum.
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
    // Indices mirrored at walls.
    let before = |i: usize| if i == 0 { 1 } else { i - 1 };
    let after = |i: usize, n: usize| if i == n { n - 1 } else { i + 1 };
    let share = |i: usize, n: usize| if no_flux && (i == 0 || i == n) { 2.0 } else { 1.0 };
    let f = |i: usize, j: usize| words[at(i, j)] as f64 * per_unit * share(i, n) * share(j, m) - mean;
    let u = |i: usize, j: usize| u[at(i, j)];
    // Second differences, not divided by the widths.
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
                    grid.deposit(&x, &m, Resources::default()).unwrap();
                    grid.solve(Resources::default()).unwrap();
                    residual(grid)
                });
                assert!(worst < 1e-14, "{cells:?} {screening} {walls:?}: {worst:e}");
                // Nearly square cells that resolve the screening.
                let h = 2.0 / cells[0] as f64;
                let mesh = Mesh::new([-1.0, 0.0], [1.0, 1.1 * h * cells[1] as f64], cells).unwrap();
                let equation = Equation { screening: screening.min(0.9 / h), walls, order: Order::Fourth };
                let worst = with_grid(mesh, equation, 1, |grid| {
                    grid.deposit(&x, &m, Resources::default()).unwrap();
                    grid.solve(Resources::default()).unwrap();
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
        grid.deposit(&x, &m, Resources::default()).unwrap();
        grid.solve(Resources::default()).unwrap();
        let units: i64 = grid.words()[..mesh.nodes()].iter().sum::<i64>() + grid.words()[mesh.nodes() + 1];
        let per_mass: f64 = grid.scale().per_mass().into_iter().product();
        let exact: i64 = m.iter().map(|m| fixed::nearest(m * per_mass)).sum();
        assert_eq!(units, exact);
        let outside = x.iter().filter(|x| !mesh.contains(**x)).count() as u64;
        assert!(outside > 100);
        assert_eq!(grid.outside(), outside);
        let total: f64 = m.iter().sum();
        for k in 0..2 {
            let centre = x.iter().zip(&m).map(|(x, m)| x[k] * m).sum::<f64>() / total;
            // A few units of 2^-49 M each for 1000 particles, times the width of the mesh. The units of the tail are 2^10 larger.
            assert!((grid.monopole().centre[k] - centre).abs() < 4.0 * 1000.0 * 2.0_f64.powi(-39), "{k}");
        }
        assert!((grid.monopole().mass / total - 1.0).abs() < 1000.0 * 2.0_f64.powi(-49));
    });
}

#[test]
fn far_gradient_is_the_monopoles_and_near_gradient_the_logarithms() {
    let mesh = Mesh::new([-1.0, -1.0], [1.0, 1.0], [128, 128]).unwrap();
    with_grid(mesh, Equation::POISSON, 1, |grid| {
        grid.deposit(&[[0.0, 0.0]], &[2.0], Resources::default()).unwrap();
        grid.solve(Resources::default()).unwrap();
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
            grid.deposit(&x, &m, Resources::default()).unwrap();
            grid.solve(Resources::default()).unwrap();
            let nodes: [f64; 2] = [0, 1].map(|k: usize| {
                grid.words().iter().zip(grid.gradient()).map(|(&w, g)| w as f64 * grid.scale().unit() * g[k]).sum()
            });
            let mut at = vec![[0.0; 2]; x.len()];
            grid.interpolate(&x, &mut at, Resources::default()).unwrap();
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
                // Weights and sums are rounded. A unit is 2^-49 of the mass.
                assert!((nodes[k] - particles[k]).abs() < 1e-13 * size);
            }
        });
    }
}

#[test]
fn removal_restores_the_words() {
    for walls in [Walls::Free, Walls::NoFlux] {
        let mesh = Mesh::new([-1.0, -0.5], [1.0, 1.5], [12, 17]).unwrap();
        // Some particles are outside.
        let (positions, masses) = cloud(500, [-1.2, -0.6], [1.3, 1.7], 5);
        let ((kept, gone), (kept_masses, gone_masses)) = (positions.split_at(300), masses.split_at(300));
        let scale = MassScale::of(&masses).unwrap();
        with_grid(mesh, Equation { walls, ..Equation::POISSON }, 1, |grid| {
            grid.begin(scale);
            grid.add(kept, kept_masses, Resources::default()).unwrap();
            let words = grid.words().to_vec();
            grid.begin(scale);
            grid.add(&positions, &masses, Resources::default()).unwrap();
            assert!(grid.words() != words);
            grid.remove(gone, gone_masses, Resources::default()).unwrap();
            assert_eq!(grid.words(), words);
        });
    }
}

/// The next number towards zero or, for `away`, away from it.
fn beside<T: Real>(x: T, away: bool) -> T {
    T::from_bits(if away { x.bits() + 1 } else { x.bits() - 1 })
}

/// One particle on the border or one ulp within it counts as inside, however the quotient by the mesh width is rounded.
fn at_the_border<T: Real>(mesh: Mesh<T>, walls: Walls, places: &[[T; 2]]) {
    let (mass, [n, m]) = (T::from_f64(0.75), mesh.cells());
    let units = fixed::nearest(mass.to_f64() * MassScale::of(&[mass]).unwrap().per_mass().into_iter().product::<f64>());
    with_grid(mesh, Equation { screening: T::ZERO, walls, order: Order::Second }, 1, |grid| {
        for &x in places {
            assert!(mesh.contains(x));
            grid.deposit(&[x], &[mass], Resources::default()).unwrap();
            let resources = std::format!("{mesh:?} {walls:?} {x:?}");
            let nodes = &grid.words()[..mesh.nodes()];
            assert_eq!(nodes.iter().sum::<i64>(), units, "{resources}");
            assert!(grid.words()[mesh.nodes()..].iter().all(|&w| w == 0), "{resources}");
            // At a corner all mass is on the corner node, except for the rounding of the coordinates relative to a mesh width, 1/n of the side.
            if x == mesh.upper() {
                let lost = units - nodes[mesh.nodes() - 1];
                assert!(lost as f64 <= 4.0 * (n + m) as f64 * f64::EPSILON * units as f64, "{resources}: {lost}");
            }
            grid.solve(Resources::default()).unwrap();
            assert_eq!(grid.outside(), 0);
            assert_eq!(grid.monopole().mass, mass, "{resources}");
            assert!(grid.gradient_at(x).iter().all(|g| g.is_finite()), "{resources}");
            grid.remove(&[x], &[mass], Resources::default()).unwrap();
            assert!(grid.words().iter().all(|&w| w == 0), "{resources}");
        }
    });
}

fn borders<T: Real>() {
    let c = T::from_f64;
    let mut seed = 11;
    let mut random = |from: f64, to: f64| from + (to - from) * unit(&mut seed);
    let mut rounded_up = 0;
    for round in 0..600 {
        // Meshes of all sizes, some far from the origin.
        let side = 10.0_f64.powf(random(-3.0, 3.0));
        let corner = side * random(-1.0, 1.0) * if round % 4 == 0 { 30.0 } else { 1.0 };
        let cells = [0, 1].map(|_| 2 + random(0.0, 30.0) as usize);
        let lower = [c(corner), c(-side * random(0.1, 0.9))];
        let upper = [c(corner + side), c(side * random(0.1, 0.9))];
        let Ok(mesh) = Mesh::new(lower, upper, cells) else { continue };
        let [l, u] = [lower, upper].map(|x| x.map(T::to_f64));
        rounded_up +=
            [0, 1].iter().filter(|&&k| (u[k] - l[k]) * (cells[k] as f64 / (u[k] - l[k])) > cells[k] as f64).count();
        let within = [0, 1].map(|k: usize| beside(upper[k], upper[k] < T::ZERO));
        let middle = [0, 1].map(|k: usize| lower[k] + (upper[k] - lower[k]) * c(random(0.0, 1.0)));
        let places = [upper, lower, within, [upper[0], middle[1]], [middle[0], within[1]], [lower[0], upper[1]]];
        for walls in [Walls::Free, Walls::FreeQuadrupole, Walls::NoFlux] {
            at_the_border(mesh, walls, &places);
        }
    }
    // The rounding case under test occurs.
    assert!(rounded_up > 20, "{rounded_up}");
}

#[test]
fn the_border_is_inside() {
    borders::<f64>();
    borders::<f32>();
    // A quotient by the width that rounds above the number of cells.
    let mesh = Mesh::new([-15.0; 2], [15.0; 2], [250, 250]).unwrap();
    for walls in [Walls::Free, Walls::FreeQuadrupole, Walls::NoFlux] {
        at_the_border(mesh, walls, &[[15.0, 3.75], [3.75, 15.0], [15.0, 15.0]]);
    }
    let mesh = Mesh::new([0.0; 2], [0.3; 2], [100, 100]).unwrap();
    at_the_border(mesh, Walls::NoFlux, &[[0.3, 0.1], [0.3, 0.3], [beside(0.3, false), 0.2]]);
    let mesh = Mesh::new([0.0_f32; 2], [0.3; 2], [100, 100]).unwrap();
    at_the_border(mesh, Walls::Free, &[[0.3, 0.1], [0.3, 0.3], [beside(0.3, false), 0.2]]);
    // A position one ulp outside is outside.
    let mesh = Mesh::new([-15.0; 2], [15.0; 2], [250, 250]).unwrap();
    with_grid(mesh, Equation::POISSON, 1, |grid| {
        let beyond = beside(15.0_f64, true);
        grid.deposit(&[[beyond, 0.0], [0.0, -beyond], [15.0, -15.0]], &[1.0; 3], Resources::default()).unwrap();
        grid.locate_mass();
        assert_eq!(grid.outside(), 2);
    });
}

#[test]
fn a_position_that_is_not_finite_has_no_gradient() {
    let mesh = Mesh::new([-1.0; 2], [1.0; 2], [4, 4]).unwrap();
    for walls in [Walls::Free, Walls::NoFlux] {
        with_grid(mesh, Equation { walls, ..Equation::POISSON }, 1, |grid| {
            grid.deposit(&[[0.1, 0.2]], &[1.0], Resources::default()).unwrap();
            grid.solve(Resources::default()).unwrap();
            for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
                assert!(grid.gradient_at([bad, 0.0]).iter().all(|g| g.is_nan()));
                assert!(grid.gradient_at([0.0, bad]).iter().all(|g| g.is_nan()));
            }
        });
    }
}

/// Potential and gradient of a grid whose units are 2^mass for masses and 2^length for lengths.
fn field<T: Real>(walls: Walls, order: Order, screening: f64, mass: i32, length: i32) -> (Vec<T>, Vec<[T; 2]>) {
    let of = |x: f64, e: i32| T::from_f64(x).ldexp(e);
    let corner = |x: [f64; 2]| x.map(|x| of(x, length));
    let mesh = Mesh::new(corner([-1.0, -1.5]), corner([1.0, 1.0]), [12, 15]).unwrap();
    let equation = Equation { screening: of(screening, -length), walls, order };
    let (x, m) = cloud(40, [-1.1, -1.6], [1.1, 1.1], 3);
    let x: Vec<[T; 2]> = x.iter().map(|x| corner(*x)).collect();
    let m: Vec<T> = m.iter().map(|m| of(*m, mass)).collect();
    with_grid(mesh, equation, 1, |grid| {
        grid.deposit(&x, &m, Resources::default()).unwrap();
        grid.solve(Resources::default()).unwrap();
        let mut u = vec![T::NAN; mesh.nodes()];
        grid.potential(&mut u).unwrap();
        let mut gradient = grid.gradient().to_vec();
        gradient.extend(x.iter().map(|x| grid.gradient_at(*x)));
        (u, gradient)
    })
}

/// The equations have no scale: in other units of mass and length the field has the same values in those units, except for a
/// constant from the logarithm in free space.
fn units<T: Real>(mass: &[i32], length: &[i32]) {
    let e = T::EPSILON.to_f64();
    for (walls, screening) in [
        (Walls::Free, 0.0),
        (Walls::FreeQuadrupole, 0.0),
        (Walls::NoFlux, 0.0),
        (Walls::Free, 0.5),
        (Walls::NoFlux, 0.5),
    ] {
        for order in [Order::Second, Order::Fourth] {
            let (u, g) = field::<T>(walls, order, screening, 0, 0);
            let total: f64 = cloud(40, [0.0; 2], [1.0; 2], 3).1.iter().sum();
            let free = walls != Walls::NoFlux && screening == 0.0;
            for (&mass, &length) in mass.iter().zip(length) {
                let resources = std::format!("{walls:?} {order:?} {screening} {mass} {length}");
                let (other_u, other_g) = field::<T>(walls, order, screening, mass, length);
                let log = f64::from(length) * core::f64::consts::LN_2 / (2.0 * core::f64::consts::PI);
                let shift = if free { total * log } else { 0.0 };
                // Each border value is rounded by u of itself. The solve amplifies roundings by the condition number, at most 8 / (pi / 15)^2.
                let bound = 200.0 * e * (total + shift.abs());
                for (u, other) in u.iter().zip(&other_u) {
                    let other = other.ldexp(-mass).to_f64();
                    assert!((other - u.to_f64() - shift).abs() <= bound, "{resources}: {other} {u} {shift}");
                }
                // Differences over a mesh width of 1/6.
                for (g, other) in g.iter().zip(&other_g) {
                    for k in 0..2 {
                        let other = other[k].ldexp(length).ldexp(-mass).to_f64();
                        assert!((other - g[k].to_f64()).abs() <= 12.0 * bound, "{resources}: {other} {}", g[k]);
                    }
                }
            }
        }
    }
}

#[test]
fn no_unit_of_mass_or_length_is_too_large_or_too_small() {
    // Results of 2^mass log, 2^(mass - length) are in range; lengths to 1e160; in single precision masses of 1e-27 kg and lengths of 1e20.
    units::<f64>(&[0, 0, 0, 900, -900, -1000, 1000], &[532, -532, 1000, 900, -800, -400, 100]);
    units::<f32>(&[0, 0, -90, 100, -60], &[66, -66, -40, 80, 60]);
}

#[test]
fn meshes_that_are_refused() {
    let out = Err(Error::OutOfDomain);
    assert_eq!(Mesh::new([0.0; 2], [1e305; 2], [4, 4]).map(|_| ()), out);
    assert_eq!(Mesh::new([-1e305, 0.0], [1.0; 2], [4, 4]).map(|_| ()), out);
    assert_eq!(Mesh::new([0.0; 2], [1.0, 1e-13], [4, 4]).map(|_| ()), out);
    assert_eq!(Mesh::new([0.0; 2], [1e-307, 1e-307], [40, 40]).map(|_| ()), out);
    assert!(Mesh::new([-1e304; 2], [1e304; 2], [4, 4]).is_ok() && Mesh::new([0.0; 2], [1.0, 1e-11], [4, 4]).is_ok());
}

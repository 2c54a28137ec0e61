//! Mesh fields in a medium: orders by manufactured solutions with jumps, agreement with the direct solver, refusals, bits.

use std::f64::consts::PI;

use mollis_core::exec::Resources;
use mollis_core::grid::{Coefficients, Equation, Grid, Limits, MassScale, Mesh, Variable, Walls};
use mollis_core::memory::ALIGN;
use mollis_core::simd::Level;
use mollis_core::{Error, Real};
use mollis_tests::Threads;

/// Calls `body` with a field in a block of exactly the stated size with arbitrary contents, between canaries.
fn with_field<T: Real, R>(
    mesh: Mesh<T>,
    walls: Walls,
    medium: &Coefficients<'_, T>,
    workers: usize,
    body: impl FnOnce(&mut Variable<'_, T>) -> R,
) -> R {
    let bytes = Variable::workspace_bytes(&mesh, walls, workers).unwrap();
    let mut memory = vec![0xC5_u8; bytes + 3 * ALIGN];
    let start = ALIGN + memory[ALIGN..].as_ptr().align_offset(ALIGN);
    let short = Variable::prepare(&mut memory[start..start + bytes - 1], mesh, walls, medium, workers);
    assert_eq!(short.err(), Some(Error::WorkspaceTooSmall));
    let odd = Variable::prepare(&mut memory[start + 1..start + 1 + bytes], mesh, walls, medium, workers);
    assert_eq!(odd.err(), Some(Error::Misaligned));
    let field = Variable::prepare(&mut memory[start..start + bytes], mesh, walls, medium, workers);
    let result = body(&mut field.unwrap());
    assert!(memory[..start].iter().chain(&memory[start + bytes..]).all(|&b| b == 0xC5), "a write outside");
    result
}

/// Values of a function at the nodes.
fn at_nodes(mesh: &Mesh<f64>, f: impl Fn(f64, f64) -> f64) -> Vec<f64> {
    let pitch = mesh.cells()[0] + 1;
    (0..mesh.nodes()).map(|k| mesh.node((k % pitch) as isize, (k / pitch) as isize)).map(|[x, y]| f(x, y)).collect()
}

/// Replaces the masses of the nodes by the integrals of a density over their cells.
fn set_density(field: &mut Variable<'_, f64>, density: &[f64]) {
    let mesh = *field.grid().mesh();
    let ([n, m], [h, k]) = (mesh.cells(), mesh.spacing());
    let scale = MassScale::for_total(density.iter().map(|f| f.abs()).sum::<f64>() * h * k).unwrap();
    field.begin(scale);
    let share = |at: usize, last: usize| if at == 0 || at == last { 0.5 } else { 1.0 };
    for (at, (word, f)) in field.words_mut().iter_mut().zip(density).enumerate() {
        let area = h * k * share(at % (n + 1), n) * share(at / (n + 1), m);
        *word = (f * area / scale.unit()).round() as i64;
    }
}

fn largest(values: impl IntoIterator<Item = f64>) -> f64 {
    values.into_iter().fold(0.0, |a, b| a.max(b.abs()))
}

const LIMITS: Limits<f64> = Limits { tolerance: 1e-11, iterations: 100 };

/// The largest errors of u and, beyond 1.6 widths from the jump, of its differences, and the iterations, in the unit square with
/// `G = a(x) (1 + y / 2)`, a jumping from 1 to `jump` at x = 1/2. The solution is cos(pi x) cos(pi y) / a, whose flux is continuous there.
fn errors(cells: [usize; 2], jump: f64, decays: bool) -> ([f64; 2], u32) {
    let mesh = Mesh::new([0.0; 2], [1.0; 2], cells).unwrap();
    let a = |x: f64| if x < 0.5 { 1.0 } else { jump };
    let decay = |x: f64, y: f64| if decays { (if x < 0.5 { 3.0 } else { 20.0 }) * (1.0 + y) } else { 0.0 };
    let u = |x: f64, y: f64| (PI * x).cos() * (PI * y).cos() / a(x);
    let f = |x: f64, y: f64| {
        let bend = -PI * PI * (2.0 + y) * (PI * y).cos() - 0.5 * PI * (PI * y).sin();
        (PI * x).cos() * bend - decay(x, y) * u(x, y)
    };
    let diffusivity = at_nodes(&mesh, |x, y| a(x) * (1.0 + 0.5 * y));
    let decay = at_nodes(&mesh, decay);
    let medium = Coefficients { diffusivity: &diffusivity, decay: decays.then_some(&decay) };
    with_field(mesh, Walls::NoFlux, &medium, 1, |field| {
        set_density(field, &at_nodes(&mesh, f));
        let report = field.solve(&LIMITS, Resources::default()).unwrap();
        assert!(report.residual <= LIMITS.tolerance && report == field.report());
        let mut got = vec![f64::NAN; mesh.nodes()];
        field.grid().potential(&mut got).unwrap();
        let of_u = largest(got.iter().zip(at_nodes(&mesh, u)).map(|(a, b)| a - b));
        let x_slope = at_nodes(&mesh, |x, y| -PI * (PI * x).sin() * (PI * y).cos() / a(x));
        let y_slope = at_nodes(&mesh, |x, y| -PI * (PI * x).cos() * (PI * y).sin() / a(x));
        let near = at_nodes(&mesh, |x, _| if (x - 0.5).abs() < 1.6 * mesh.spacing()[0] { 0.0 } else { 1.0 });
        let slopes = field.grid().gradient().iter().zip(x_slope.iter().zip(&y_slope)).zip(&near);
        let of_slope = largest(slopes.map(|((g, (x, y)), near)| near * (g[0] - x).abs().max((g[1] - y).abs())));
        ([of_u, of_slope], report.iterations)
    })
}

#[test]
fn the_error_is_of_second_order_across_a_jump() {
    for (jump, decays, most) in [(10.0, false, 50), (10.0, true, 50), (0.1, false, 50)] {
        // Odd numbers of cells: x = 1/2 is midway between nodes.
        let meshes = [33, 65, 129, 257].map(|n| (n, errors([n, n - 1], jump, decays)));
        for pair in meshes.windows(2) {
            let ((n, (coarse, _)), (m, (fine, iterations))) = (pair[0], pair[1]);
            for k in 0..2 {
                let order = (coarse[k] / fine[k]).ln() / (m as f64 / n as f64).ln();
                assert!((1.9..2.1).contains(&order), "{jump} {decays} {m} {k}: {coarse:?} {fine:?} {order}");
            }
            // By the condition number, 10 times the variation along y: log(2 / tolerance) sqrt(15) / 2 = 50. Independent of the mesh.
            assert!(iterations <= most, "{jump} {decays} {m}: {iterations}");
        }
        for (n, ([u, slope], iterations)) in meshes {
            println!("jump {jump}, decay {decays}, {n} cells: errors {u:.2e} {slope:.2e}, {iterations} iterations");
        }
    }
}

fn cloud(n: usize, lower: [f64; 2], upper: [f64; 2], seed: u64) -> (Vec<[f64; 2]>, Vec<f64>) {
    let mut numbers = mollis_tests::Split(seed);
    let mut at = |k: usize| lower[k] + (upper[k] - lower[k]) * numbers.uniform();
    let x = (0..n).map(|_| [at(0), at(1)]).collect();
    (x, (0..n).map(|k| 0.1 + (k % 7) as f64).collect())
}

/// With equal coefficients: the field of the direct solver, over G.
fn equals_the_direct_solver<T: Real>(cells: [usize; 2], walls: Walls, g: f64, k2: f64, bound: f64) {
    let of = T::from_f64;
    let mesh = Mesh::new([of(-1.0), of(0.0)], [of(1.0), of(1.5)], cells).unwrap();
    let (x, m) = cloud(300, [-0.7, 0.1], [0.9, 1.4], 3);
    let (mut x, m): (Vec<_>, Vec<_>) = (x.iter().map(|x| x.map(of)).collect(), m.iter().map(|&m| of(m)).collect());
    // Two are outside.
    (x[0], x[1]) = ([of(1.2), of(0.4)], [of(0.1), of(-2.0)]);
    let equation = Equation { screening: of((k2 / g).sqrt()), walls, ..Equation::POISSON };
    let bytes = Grid::workspace_bytes(&mesh, &equation, 1).unwrap();
    let mut memory = vec![0; bytes + ALIGN];
    let start = memory.as_ptr().align_offset(ALIGN);
    let mut grid = Grid::prepare(&mut memory[start..start + bytes], mesh, equation, 1).unwrap();
    grid.deposit(&x, &m, Resources::default()).unwrap();
    grid.solve(Resources::default()).unwrap();
    let (diffusivity, decay) = (vec![of(g); mesh.nodes()], vec![of(k2); mesh.nodes()]);
    let medium = Coefficients { diffusivity: &diffusivity, decay: Some(&decay) };
    with_field(mesh, walls, &medium, 1, |field| {
        field.deposit(&x, &m, Resources::default()).unwrap();
        assert_eq!(field.grid().words(), grid.words());
        let report = field.solve(&Limits { tolerance: of(bound), iterations: 3 }, Resources::default()).unwrap();
        assert!(report.iterations <= 2, "{cells:?} {walls:?}: {report:?}");
        let (mut got, mut want) = (vec![T::NAN; mesh.nodes()], vec![T::NAN; mesh.nodes()]);
        field.grid().potential(&mut got).unwrap();
        grid.potential(&mut want).unwrap();
        let size = largest(want.iter().map(|u| u.to_f64()));
        let apart = largest(got.iter().zip(&want).map(|(a, b)| a.to_f64() * g - b.to_f64()));
        assert!(apart < 10.0 * bound * size, "{cells:?} {walls:?} {g} {k2}: {apart:e} of {size}");
        // At the particles, among them those outside.
        let (mut got, mut want) = (vec![[T::NAN; 2]; x.len()], vec![[T::NAN; 2]; x.len()]);
        field.grid().interpolate(&x, &mut got, Resources::default()).unwrap();
        grid.interpolate(&x, &mut want, Resources::default()).unwrap();
        let per_width = cells[0].max(cells[1]) as f64;
        for (a, b) in got.iter().flatten().zip(want.iter().flatten()) {
            assert!(
                (a.to_f64() * g - b.to_f64()).abs() < 10.0 * bound * size * per_width,
                "{cells:?} {walls:?}: {a} {b}"
            );
        }
        assert_eq!((field.grid().outside(), field.grid().monopole().mass), (grid.outside(), grid.monopole().mass));
        let gamma = field.gamma_at([of(0.123), of(0.456)]).to_f64();
        assert!((gamma * 2.0 * PI * g - 1.0).abs() < 1e-6);
    });
}

#[test]
fn equal_coefficients_are_the_direct_solvers() {
    for cells in [[2, 2], [3, 2], [2, 9], [24, 17], [16, 37], [64, 48]] {
        for walls in [Walls::Free, Walls::NoFlux] {
            for (g, k2) in [(1.0, 0.0), (0.037, 0.0), (12.0, 5.0), (1e-200, 3e-200), (1e150, 0.0)] {
                equals_the_direct_solver::<f64>(cells, walls, g, k2, 1e-11);
                if (1e-3..1e3).contains(&g) {
                    equals_the_direct_solver::<f32>(cells, walls, g, k2, 1e-4);
                }
            }
        }
    }
}

/// G of a disc in free space.
fn disc(mesh: &Mesh<f64>, inside: f64) -> Vec<f64> {
    at_nodes(mesh, |x, y| if x * x + y * y < 0.25 { inside } else { 1.0 })
}

#[test]
fn a_disc_has_the_field_of_its_image() {
    // A mass at distance d from the centre of a disc of radius a and G = g: outside it u is that of the mass, and of the image q = (1 - g) / (1 + g) times it at
    // a^2 / d and -q at the centre (u log r / 2 pi with G = 1).
    let (g, a, d) = (10.0, 0.5, 0.9);
    let mesh = Mesh::new([-3.0; 2], [3.0; 2], [384, 384]).unwrap();
    let diffusivity = disc(&mesh, g);
    let medium = Coefficients { diffusivity: &diffusivity, decay: None };
    with_field(mesh, Walls::Free, &medium, 1, |field| {
        field.deposit(&[[d, 0.0]], &[1.0], Resources::default()).unwrap();
        let report = field.solve(&LIMITS, Resources::default()).unwrap();
        assert!(report.iterations < 40, "{report:?}");
        let q = (1.0 - g) / (1.0 + g);
        let exact = |x: [f64; 2]| {
            let mut sum = [0.0; 2];
            for (m, at) in [(1.0, d), (q, a * a / d), (-q, 0.0)] {
                let r = [x[0] - at, x[1]];
                let r2 = r[0] * r[0] + r[1] * r[1];
                sum = [0, 1].map(|k| sum[k] + m * r[k] / r2 / (2.0 * PI));
            }
            sum
        };
        let plain = |x: [f64; 2]| (x[0] - d) / ((x[0] - d).powi(2) + x[1] * x[1]) / (2.0 * PI);
        for x in [[-0.7, 0.1], [0.0, 0.8], [0.3, -0.7], [1.3, 0.2], [0.62, 0.0]] {
            let (got, want) = (field.grid().gradient_at(x), exact(x));
            let size = want[0].hypot(want[1]);
            // A curved jump costs an error of the first order, half a width of 1/64 in the radius; the border lacks the image's dipole, 0.28 / 3.
            assert!((got[0] - want[0]).hypot(got[1] - want[1]) < 0.05 * size, "{x:?}: {got:?} {want:?}");
            assert!((plain(x) - want[0]).abs() > 0.1 * size || x[1].abs() > 0.15);
        }
        // Far outside the mesh: all mass at its centre.
        let far = field.grid().gradient_at([100.0, 0.0]);
        assert!((far[0] * 2.0 * PI * 99.1 - 1.0).abs() < 1e-9);
    });
}

#[test]
fn bits_depend_on_nothing_but_the_arguments() {
    let mesh = Mesh::new([-1.0, -1.2], [1.0, 1.3], [61, 47]).unwrap();
    let diffusivity = disc(&mesh, 7.0);
    let decay = at_nodes(&mesh, |x, y| 0.3 + (x * y).max(0.0) * if x.abs() < 0.9 && y.abs() < 1.1 { 1.0 } else { 0.0 });
    let medium = Coefficients { diffusivity: &diffusivity, decay: Some(&decay) };
    for walls in [Walls::Free, Walls::NoFlux] {
        let (x, m) = cloud(20_000, [-1.0, -1.2], [1.1, 1.3], 8);
        let run = |workers: usize, level: Level| {
            with_field(mesh, walls, &medium, workers, |field| {
                let executor = Threads(workers);
                let resources = Resources { level, executor: &executor };
                // Something else before.
                field.deposit(&x[..50], &m[..50], resources).unwrap();
                field.solve(&LIMITS, resources).unwrap();
                field.deposit(&x, &m, resources).unwrap();
                let report = field.solve(&LIMITS, resources).unwrap();
                let mut u = vec![f64::NAN; mesh.nodes()];
                field.grid().potential(&mut u).unwrap();
                (report, u, field.grid().gradient().to_vec())
            })
        };
        let first = run(1, Level::best());
        assert!(first.0.iterations > 5);
        for (workers, level) in [(2, Level::best()), (5, Level::best()), (1, Level::Portable), (3, Level::Portable)] {
            assert!(run(workers, level) == first, "{walls:?} {workers} {level:?}");
        }
    }
}

#[test]
fn a_box_has_no_net_mass_and_a_mean_of_zero() {
    let mesh = Mesh::new([0.0, 0.0], [1.0, 2.0], [30, 41]).unwrap();
    let diffusivity = at_nodes(&mesh, |x, y| if (x - 0.4).abs() + (y - 0.9).abs() < 0.3 { 0.1 } else { 1.0 });
    let medium = Coefficients { diffusivity: &diffusivity, decay: None };
    with_field(mesh, Walls::NoFlux, &medium, 1, |field| {
        let (x, m) = cloud(100, [-0.3, 0.0], [1.0, 2.0], 5);
        field.deposit(&x, &m, Resources::default()).unwrap();
        field.solve(&LIMITS, Resources::default()).unwrap();
        let mut u = vec![f64::NAN; mesh.nodes()];
        field.grid().potential(&mut u).unwrap();
        let share = |at: usize, last: usize| if at == 0 || at == last { 0.5 } else { 1.0 };
        let mean =
            u.iter().enumerate().map(|(k, u)| u * share(k % 31, 30) * share(k / 31, 41)).sum::<f64>() / (30.0 * 41.0);
        let size = largest(u.iter().copied());
        assert!(mean.abs() < 1e-12 * size, "{mean:e} of {size}");
        // Outside: the mirrored gradient of the mirror image.
        let (a, b) = (field.grid().gradient_at([-0.2, 0.7]), field.grid().gradient_at([0.2, 0.7]));
        assert!((a[0] + b[0]).abs() + (a[1] - b[1]).abs() < 1e-12 * b[0].hypot(b[1]));
        // The mirror image's G as well.
        assert_eq!(field.diffusivity_at([-0.4, 0.9]), field.diffusivity_at([0.4, 0.9]));
        // Without mass there is no field, and nothing to iterate.
        field.deposit(&[], &[], Resources::default()).unwrap();
        let report = field.solve(&LIMITS, Resources::default()).unwrap();
        assert_eq!((report.iterations, report.residual), (0, 0.0));
        assert!(field.grid().gradient().iter().flatten().all(|&g| g == 0.0));
    });
}

#[test]
fn a_particle_feels_itself_as_documented() {
    // (m grad G / (4 pi G^2)) log(1/h) and a constant, so log 2 / (4 pi) more on a mesh of half the width.
    let own = [64, 128].map(|n| {
        let mesh = Mesh::new([-1.0; 2], [1.0; 2], [n, n]).unwrap();
        let diffusivity = at_nodes(&mesh, |x, _| x.exp());
        let medium = Coefficients { diffusivity: &diffusivity, decay: None };
        with_field(mesh, Walls::NoFlux, &medium, 1, |field| {
            field.deposit(&[[0.0, 0.0]], &[1.0], Resources::default()).unwrap();
            field.solve(&LIMITS, Resources::default()).unwrap();
            field.grid().gradient_at([0.0, 0.0])
        })
    });
    let more = own[1][0] - own[0][0];
    assert!((more * 4.0 * PI / 2.0_f64.ln() - 1.0).abs() < 2e-3 && own[1][1].abs() < 1e-9, "{own:?}");
}

#[test]
fn an_absorbing_medium_has_the_balance_of_its_mass() {
    // Summed over a box, div(G grad u) is 0: what the masses are is minus what k^2 u is.
    let mesh = Mesh::new([0.0; 2], [1.0; 2], [40, 40]).unwrap();
    let diffusivity = at_nodes(&mesh, |x, _| if x < 0.31 { 10.0 } else { 1.0 });
    let decay = at_nodes(&mesh, |x, y| if x + y < 0.8 { 100.0 } else { 0.0 });
    let medium = Coefficients { diffusivity: &diffusivity, decay: Some(&decay) };
    with_field(mesh, Walls::NoFlux, &medium, 1, |field| {
        let (x, m) = cloud(100, [0.0; 2], [1.0; 2], 5);
        field.deposit(&x, &m, Resources::default()).unwrap();
        field.solve(&LIMITS, Resources::default()).unwrap();
        let mut u = vec![f64::NAN; mesh.nodes()];
        field.grid().potential(&mut u).unwrap();
        let share = |at: usize| if at == 0 || at == 40 { 0.5 } else { 1.0 };
        let absorbed =
            u.iter().zip(&decay).enumerate().map(|(k, (u, k2))| k2 * u * share(k % 41) * share(k / 41) / 1600.0);
        let (absorbed, total) = (absorbed.sum::<f64>(), m.iter().sum::<f64>());
        // The residual's sum is its product with 1, an energy of the size of sqrt(k^2) = 10.
        assert!((absorbed + total).abs() < 1e-9 * total, "{absorbed} {total}");
        assert!(u.iter().all(|&u| u < 0.0));
    });
}

#[test]
fn what_is_refused() {
    let mesh = Mesh::new([0.0; 2], [1.0; 2], [6, 5]).unwrap();
    let one = vec![1.0; mesh.nodes()];
    let zero = vec![0.0; mesh.nodes()];
    let with = |values: &[f64], at: usize, value: f64| {
        let mut values = values.to_vec();
        values[at] = value;
        values
    };
    let bytes = Variable::workspace_bytes(&mesh, Walls::NoFlux, 1).unwrap();
    let mut memory = vec![0; bytes + ALIGN];
    let start = memory.as_ptr().align_offset(ALIGN);
    let mut prepare = |walls: Walls, g: &[f64], k2: &[f64]| {
        let medium = Coefficients { diffusivity: g, decay: Some(k2) };
        let bytes = Variable::workspace_bytes(&mesh, walls, 1).unwrap();
        Variable::prepare(&mut memory[start..start + bytes], mesh, walls, &medium, 1).err()
    };
    // Node (1, 1) is inside.
    let inner = 8;
    for (error, g, k2) in [
        (Error::LengthMismatch, one[1..].to_vec(), zero.clone()),
        (Error::LengthMismatch, one.clone(), zero[1..].to_vec()),
        (Error::NotFinite, with(&one, inner, f64::NAN), zero.clone()),
        (Error::NotFinite, with(&one, inner, f64::INFINITY), zero.clone()),
        (Error::NotFinite, one.clone(), with(&zero, inner, f64::NAN)),
        (Error::OutOfDomain, with(&one, inner, 0.0), zero.clone()),
        (Error::OutOfDomain, with(&one, inner, -1.0), zero.clone()),
        (Error::OutOfDomain, with(&one, inner, 1e-17), zero.clone()),
        (Error::OutOfDomain, one.clone(), with(&zero, inner, -1e-9)),
    ] {
        for walls in [Walls::Free, Walls::NoFlux] {
            assert_eq!(prepare(walls, &g, &k2), Some(error), "{walls:?} {g:?} {k2:?}");
        }
    }
    // In free space the field far away has to be known.
    for at in [0, 3, 6, 7, 13, 41] {
        assert_eq!(prepare(Walls::Free, &with(&one, at, 2.0), &zero), Some(Error::Unsupported));
        assert_eq!(prepare(Walls::Free, &one, &with(&one, at, 2.0)), Some(Error::Unsupported));
        assert_eq!(prepare(Walls::NoFlux, &with(&one, at, 2.0), &with(&zero, at, 2.0)), None);
    }
    assert_eq!(prepare(Walls::Free, &one, &with(&zero, inner, 1.0)), Some(Error::Unsupported));
    assert_eq!(prepare(Walls::Free, &with(&one, inner, 2.0), &with(&one, inner, 0.0)), None);
    assert_eq!(prepare(Walls::FreeQuadrupole, &one, &zero), Some(Error::Unsupported));
}

#[test]
fn too_few_iterations_are_an_error_and_leave_the_last_iterate() {
    let mesh = Mesh::new([-1.0; 2], [1.0; 2], [40, 40]).unwrap();
    let diffusivity = disc(&mesh, 10.0);
    let medium = Coefficients { diffusivity: &diffusivity, decay: None };
    for walls in [Walls::Free, Walls::NoFlux] {
        with_field(mesh, walls, &medium, 1, |field| {
            let resources = Resources::default();
            field.deposit(&[[0.1, 0.3], [0.7, 0.2]], &[1.0, 2.0], resources).unwrap();
            let full = field.solve(&LIMITS, resources).unwrap();
            let mut exact = vec![0.0; mesh.nodes()];
            field.grid().potential(&mut exact).unwrap();
            for bad in [0.0, -1e-3] {
                assert_eq!(field.solve(&Limits { tolerance: bad, ..LIMITS }, resources), Err(Error::OutOfDomain));
            }
            assert_eq!(field.solve(&Limits { tolerance: f64::NAN, ..LIMITS }, resources), Err(Error::NotFinite));
            let two = Threads(2);
            let more = Resources { executor: &two, ..resources };
            assert_eq!(field.solve(&LIMITS, more), Err(Error::WorkspaceTooSmall));
            // Refused calls leave the field and the report as they were.
            let mut u = vec![0.0; mesh.nodes()];
            field.grid().potential(&mut u).unwrap();
            assert!(u == exact && field.report() == full);
            let mut last = f64::INFINITY;
            for iterations in [0, 3, 8, 15] {
                let short = Limits { iterations, ..LIMITS };
                assert_eq!(field.solve(&short, resources), Err(Error::NotConverged));
                let report = field.report();
                assert!(report.iterations == iterations && report.residual > LIMITS.tolerance, "{report:?}");
                field.grid().potential(&mut u).unwrap();
                let error = largest(u.iter().zip(&exact).map(|(a, b)| a - b));
                assert!(error < last && (iterations == 0 || error < 100.0 * report.residual), "{report:?} {error}");
                last = error;
            }
            // Below what rounding allows.
            let below = Limits { tolerance: 1e-18, iterations: 60 };
            assert_eq!(field.solve(&below, resources), Err(Error::NotConverged));
            assert!(field.report().residual < 1e-13, "{:?}", field.report());
            assert_eq!(field.solve(&LIMITS, resources), Ok(full));
        });
    }
}

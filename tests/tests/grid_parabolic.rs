//! An attractant with a memory: a slow twin in time, modes, the elliptic limit, balance of mass, bits, checkpoints, refusals.

use std::f64::consts::{PI, TAU};

use mollis_core::exec::Resources;
use mollis_core::grid::{Equation, Grid, Mesh, Order, Parabolic, Walls};
use mollis_core::memory::ALIGN;
use mollis_core::simd::Level;
use mollis_core::{Error, Real};
use mollis_tests::{Aligned, Split, Threads};

/// Calls `body` with a field in a block of exactly the stated size with arbitrary contents, between canaries.
fn with_field<T: Real, R>(
    mesh: Mesh<T>,
    equation: Equation<T>,
    time_scale: f64,
    workers: usize,
    body: impl FnOnce(&mut Parabolic<'_, T>) -> R,
) -> R {
    let time_scale = T::from_f64(time_scale);
    let bytes = Parabolic::workspace_bytes(&mesh, &equation, workers).unwrap();
    let mut memory = vec![0xC5_u8; bytes + 3 * ALIGN];
    let start = ALIGN + memory[ALIGN..].as_ptr().align_offset(ALIGN);
    let short = Parabolic::prepare(&mut memory[start..start + bytes - 1], mesh, equation, time_scale, workers);
    assert_eq!(short.err(), Some(Error::WorkspaceTooSmall));
    let odd = Parabolic::prepare(&mut memory[start + 1..start + 1 + bytes], mesh, equation, time_scale, workers);
    assert_eq!(odd.err(), Some(Error::Misaligned));
    let field = Parabolic::prepare(&mut memory[start..start + bytes], mesh, equation, time_scale, workers);
    let result = body(&mut field.unwrap());
    assert!(memory[..start].iter().chain(&memory[start + bytes..]).all(|&b| b == 0xC5), "a write outside");
    result
}

fn equation<T: Real>(walls: Walls, screening: f64) -> Equation<T> {
    Equation { screening: T::from_f64(screening), walls, order: Order::Second }
}

fn values<T: Real>(field: &Parabolic<'_, T>) -> Vec<T> {
    let mut c = vec![T::NAN; field.grid().mesh().nodes()];
    field.attractant(&mut c).unwrap();
    c
}

fn cloud<T: Real>(n: usize, mesh: &Mesh<T>, seed: u64) -> (Vec<[T; 2]>, Vec<T>) {
    let mut numbers = Split(seed);
    let (lower, upper) = (mesh.lower(), mesh.upper());
    let mut at = |k: usize| lower[k] + (upper[k] - lower[k]) * T::from_f64(numbers.uniform());
    let x = (0..n).map(|_| [at(0), at(1)]).collect();
    (x, (0..n).map(|k| T::from_f64(0.1 + (k % 7) as f64)).collect())
}

fn largest(values: impl IntoIterator<Item = f64>) -> f64 {
    values.into_iter().fold(0.0, |a, b| a.max(b.abs()))
}

/// d c / dt, node by node.
fn rate(mesh: &Mesh<f64>, walls: Walls, k: f64, time_scale: f64, c: &[f64], masses: &[f64]) -> Vec<f64> {
    let ([nx, ny], [h, l]) = (mesh.cells(), mesh.spacing());
    let at = |i: usize, j: usize| c[j * (nx + 1) + i];
    let mirrored = |i: usize, n: usize| if i == n { n - 1 } else { i + 1 };
    let mut out = vec![0.0; c.len()];
    for j in 0..=ny {
        for i in 0..=nx {
            let (wall_x, wall_y) = (i == 0 || i == nx, j == 0 || j == ny);
            if walls == Walls::Free && (wall_x || wall_y) {
                continue;
            }
            let here = at(i, j);
            let bend_x = (at(i.abs_diff(1), j) + at(mirrored(i, nx), j) - 2.0 * here) / (h * h);
            let bend_y = (at(i, j.abs_diff(1)) + at(i, mirrored(j, ny)) - 2.0 * here) / (l * l);
            let area = h * l * if wall_x { 0.5 } else { 1.0 } * if wall_y { 0.5 } else { 1.0 };
            let density = masses[j * (nx + 1) + i] / area;
            out[j * (nx + 1) + i] = (bend_x + bend_y - k * k * here + density) / time_scale;
        }
    }
    out
}

/// Classical Runge-Kutta steps. With 2,000 of them, of 0.004 over the largest eigenvalue each, what they lose is below rounding.
fn slowly(mesh: &Mesh<f64>, walls: Walls, k: f64, scale: f64, c: &mut [f64], masses: &[f64], time: f64) {
    const STEPS: usize = 2000;
    let dt = time / STEPS as f64;
    for _ in 0..STEPS {
        let moved =
            |c: &[f64], by: f64, rate: &[f64]| -> Vec<f64> { c.iter().zip(rate).map(|(c, r)| c + by * r).collect() };
        let of = |c: &[f64]| rate(mesh, walls, k, scale, c, masses);
        let a = of(c);
        let b = of(&moved(c, 0.5 * dt, &a));
        let d = of(&moved(c, 0.5 * dt, &b));
        let e = of(&moved(c, dt, &d));
        for (i, c) in c.iter_mut().enumerate() {
            *c += dt / 6.0 * (a[i] + 2.0 * b[i] + 2.0 * d[i] + e[i]);
        }
    }
}

fn is_the_solution_in_time<T: Real>(bound: f64) {
    // In the last the rows run along y.
    for cells in [[8, 6], [5, 9], [37, 4]] {
        for walls in [Walls::Free, Walls::NoFlux] {
            for k in [0.0, 1.3] {
                let wide =
                    Mesh::new([-1.0, 0.5], [-1.0 + cells[0] as f64, 0.5 + 0.8 * cells[1] as f64], cells).unwrap();
                let mesh = Mesh::new(wide.lower().map(T::from_f64), wide.upper().map(T::from_f64), cells).unwrap();
                let mut want = vec![0.0; mesh.nodes()];
                with_field(mesh, equation(walls, k), 0.7, 1, |field| {
                    for (round, dt) in [0.02, 0.8, 0.3].into_iter().enumerate() {
                        let (x, m) = cloud::<T>(9, &mesh, round as u64);
                        field.advance(&x, &m, T::from_f64(dt), Resources::default()).unwrap();
                        let mut masses = vec![T::ZERO; mesh.nodes()];
                        field.grid().masses(&mut masses).unwrap();
                        let masses: Vec<f64> = masses.iter().map(|m| m.to_f64()).collect();
                        slowly(&wide, walls, k, 0.7, &mut want, &masses, dt);
                        let got = values(field);
                        let size = largest(want.iter().copied());
                        let apart = largest(got.iter().zip(&want).map(|(a, b)| a.to_f64() - b));
                        assert!(apart < bound * size, "{cells:?} {walls:?} {k} {round}: {apart:e} of {size}");
                        // u = -c, and its differences.
                        let mut u = vec![T::NAN; mesh.nodes()];
                        field.grid().potential(&mut u).unwrap();
                        assert!(u.iter().zip(&got).all(|(u, c)| *u == -*c));
                        let (row, h) = (cells[0] + 1, mesh.spacing()[0]);
                        let slope = field.grid().gradient()[2 * row + 2][0];
                        let difference = (got[2 * row + 1] - got[2 * row + 3]) / (T::TWO * h);
                        assert!((slope - difference).abs().to_f64() <= 1e-6_f64.min(bound) * size);
                        // At the border the field goes on with the other sign, or as in a mirror.
                        let at_wall = field.grid().gradient()[2 * row][0];
                        let want = if walls == Walls::Free { -got[2 * row + 1] / h } else { T::ZERO };
                        assert!((at_wall - want).abs().to_f64() <= 1e-6_f64.min(bound) * size);
                    }
                });
            }
        }
    }
}

#[test]
fn a_step_is_the_solution_in_time() {
    // Each of three steps rounds some ten times, in transforms of up to 37 nodes.
    is_the_solution_in_time::<f64>(1e-12);
    is_the_solution_in_time::<f32>(1e-4);
}

#[test]
fn a_mode_falls_by_its_eigenvalue() {
    let cells = [12, 10];
    let mesh = Mesh::new([0.0; 2], [1.2, 2.0], cells).unwrap();
    let [h, l] = mesh.spacing();
    for (walls, p, q) in [(Walls::Free, 1, 1), (Walls::Free, 11, 9), (Walls::NoFlux, 0, 0), (Walls::NoFlux, 3, 10)] {
        for k in [0.0, 2.0] {
            let wave = |p: usize, n: usize, h: f64| (2.0 * (PI * p as f64 / (2 * n) as f64).sin() / h).powi(2);
            let lambda = wave(p, cells[0], h) + wave(q, cells[1], l) + k * k;
            let shape = |p: usize, i: usize, n: usize| {
                let angle = PI * (p * i % (2 * n)) as f64 / n as f64;
                if walls == Walls::NoFlux {
                    angle.cos()
                } else if i == 0 || i == n {
                    0.0
                } else {
                    angle.sin()
                }
            };
            let start: Vec<f64> =
                (0..mesh.nodes()).map(|at| shape(p, at % 13, cells[0]) * shape(q, at / 13, cells[1])).collect();
            with_field(mesh, equation(walls, k), 0.3, 1, |field| {
                field.set_attractant(&start, Resources::default()).unwrap();
                for (n, dt) in [1e-6, 1e-3, 0.02, 5.0].into_iter().enumerate() {
                    let before = values(field);
                    field.advance(&[], &[], dt, Resources::default()).unwrap();
                    let factor = (-lambda * dt / 0.3).exp();
                    let apart = largest(values(field).iter().zip(&before).map(|(a, b)| a - b * factor));
                    assert!(apart < 1e-13, "{walls:?} {p} {q} {k} {n}: {apart:e}");
                }
            });
        }
    }
}

#[test]
fn the_limit_is_the_elliptic_law() {
    let mesh = Mesh::new([0.0; 2], [1.0, 1.2], [24, 27]).unwrap();
    let (x, m) = cloud(200, &mesh, 4);
    for (walls, k) in [(Walls::NoFlux, 0.0), (Walls::NoFlux, 3.0), (Walls::Free, 0.0), (Walls::Free, 90.0)] {
        with_field(mesh, equation(walls, k), 1e-9, 1, |field| {
            field.deposit(&x, &m, Resources::default()).unwrap();
            field.settle(Resources::default()).unwrap();
            let settled = field.grid().gradient().to_vec();
            let size = largest(settled.iter().flatten().copied());
            // One step of 1 is 1e9 time scales.
            field.set_attractant(&vec![0.0; mesh.nodes()], Resources::default()).unwrap();
            field.advance(&x, &m, 1.0, Resources::default()).unwrap();
            let apart =
                |a: &[[f64; 2]], b: &[[f64; 2]]| largest(a.iter().zip(b).flat_map(|(a, b)| [a[0] - b[0], a[1] - b[1]]));
            // In a box without decay c is 1e9 times the field, and its rounding is in the differences.
            let bound = if walls == Walls::NoFlux && k == 0.0 { 1e-4 } else { 1e-11 };
            let difference = apart(field.grid().gradient(), &settled);
            assert!(difference < bound * size, "{walls:?} {k}: {difference:e} of {size}");
            if walls == Walls::NoFlux {
                let mut memory = Aligned::new(Grid::workspace_bytes(&mesh, &equation(walls, k), 1).unwrap());
                let mut grid = Grid::prepare(memory.bytes(), mesh, equation(walls, k), 1).unwrap();
                grid.deposit(&x, &m, Resources::default()).unwrap();
                grid.solve(Resources::default()).unwrap();
                assert!(apart(grid.gradient(), &settled) < 1e-11 * size);
            } else {
                // What is produced decays or leaves: sum of c next to the border is the flux.
                let (c, row) = (values(field), 25);
                let inner = |i: usize, j: usize| c[j * row + i];
                let [h, l] = mesh.spacing();
                let out = (1..27).map(|j| (inner(1, j) + inner(23, j)) * l / h).sum::<f64>()
                    + (1..24).map(|i| (inner(i, 1) + inner(i, 26)) * h / l).sum::<f64>();
                let mut masses = vec![0.0; mesh.nodes()];
                field.grid().masses(&mut masses).unwrap();
                let inside = (1..27).flat_map(|j| (1..24).map(move |i| j * row + i)).map(|at| masses[at]).sum::<f64>();
                assert!((out + k * k * field.amount() - inside).abs() < 1e-10 * inside, "{k}");
            }
        });
    }
}

#[test]
fn the_field_lags_behind_by_the_time_scale() {
    // A mass on a circle: c is the elliptic one of an earlier place, up to the first order of epsilon. Steps of 1/100 of the slowest mode's time.
    let mesh = Mesh::new([0.0; 2], [1.0; 2], [24, 24]).unwrap();
    let at = |t: f64| [[0.5 + 0.2 * (PI * t).cos(), 0.5 + 0.2 * (PI * t).sin()]];
    let (dt, steps) = (0.002, 400);
    let lag = |time_scale: f64| {
        with_field(mesh, equation(Walls::Free, 0.0), time_scale, 1, |field| {
            field.deposit(&at(0.0), &[1.0], Resources::default()).unwrap();
            field.settle(Resources::default()).unwrap();
            for n in 1..=steps {
                // The place at the middle of the step.
                field.advance(&at((f64::from(n) - 0.5) * dt), &[1.0], dt, Resources::default()).unwrap();
            }
            let c = values(field);
            field.deposit(&at(f64::from(steps) * dt), &[1.0], Resources::default()).unwrap();
            field.settle(Resources::default()).unwrap();
            // Away from the place itself, where the lag is that of the mesh.
            let apart: Vec<f64> = c.iter().zip(values(field)).map(|(a, b)| a - b).collect();
            (apart.iter().map(|a| a * a).sum::<f64>() / apart.len() as f64).sqrt()
        })
    };
    let lags = [0.8, 0.4, 0.2].map(lag);
    println!("difference from the elliptic law for epsilon = 0.8, 0.4, 0.2: {lags:?}");
    for pair in lags.windows(2) {
        let order = (pair[0] / pair[1]).log2();
        assert!((0.85..1.15).contains(&order), "{lags:?}: {order}");
    }
}

#[test]
fn free_space_has_the_field_in_closed_form() {
    // A mass that rests since time 0: slope m / (2 pi r) e^(-epsilon r^2 / 4 t).
    let (time_scale, t, r) = (0.5, 0.1, 0.75);
    let error = |cells: usize| {
        let mesh = Mesh::new([-3.0; 2], [3.0; 2], [cells, cells]).unwrap();
        with_field(mesh, Equation::POISSON, time_scale, 1, |field| {
            for _ in 0..4 {
                field.advance(&[[0.0; 2]], &[2.0], 0.25 * t, Resources::default()).unwrap();
            }
            assert_eq!(field.grid().gradient_at([5.0, 1.0]), [0.0; 2]);
            let want = 2.0 / (TAU * r) * (-time_scale * r * r / (4.0 * t)).exp();
            (field.grid().gradient_at([r, 0.0])[0] / want - 1.0).abs()
        })
    };
    // r is at a node of each.
    let errors = [32, 64, 128].map(error);
    println!("relative errors of the slope on 32, 64, 128 cells: {errors:?}");
    for pair in errors.windows(2) {
        let order = (pair[0] / pair[1]).log2();
        assert!((1.7..2.4).contains(&order), "{errors:?}");
    }
}

#[test]
fn what_is_produced_decays_or_stays() {
    let mesh = Mesh::new([-1.0; 2], [1.0, 2.0], [20, 33]).unwrap();
    let (x, m) = cloud(500, &mesh, 2);
    let mass: f64 = m.iter().sum();
    for k in [0.0, 0.8] {
        with_field(mesh, equation(Walls::NoFlux, k), 0.6, 1, |field| {
            let mut want = 0.0;
            for (n, dt) in [0.1, 0.003, 2.0, 1e-7, 0.4].into_iter().cycle().take(50).enumerate() {
                field.advance(&x, &m, dt, Resources::default()).unwrap();
                let s = dt / 0.6;
                let kept = (-k * k * s).exp();
                want = want * kept + mass * if k == 0.0 { s } else { (1.0 - kept) / (k * k) };
                assert!((field.amount() / want - 1.0).abs() < 1e-12, "{k} {n}: {} {want}", field.amount());
            }
        });
    }
}

#[test]
fn bits_depend_on_nothing_but_the_arguments() {
    let mesh = Mesh::new([-1.0, -1.2], [1.0, 1.3], [61, 47]).unwrap();
    let (x, m) = cloud(20_000, &mesh, 8);
    for walls in [Walls::Free, Walls::NoFlux] {
        let run = |workers: usize, level: Level| {
            with_field(mesh, equation(walls, 0.4), 0.2, workers, |field| {
                let executor = Threads(workers);
                let resources = Resources { level, executor: &executor };
                for n in 0..3 {
                    field.advance(&x[n..], &m[n..], 0.01, resources).unwrap();
                }
                (values(field), field.grid().gradient().to_vec())
            })
        };
        let first = run(1, Level::best());
        for (workers, level) in [(3, Level::best()), (1, Level::Portable), (2, Level::Portable)] {
            assert!(run(workers, level) == first, "{walls:?} {workers} {level:?}");
        }
    }
}

fn continues<T: Real>() {
    let mesh = Mesh::new([T::ZERO; 2], [T::ONE, T::TWO], [19, 22]).unwrap();
    let (x, m) = cloud(60, &mesh, 5);
    for walls in [Walls::Free, Walls::NoFlux] {
        let step = |field: &mut Parabolic<'_, T>, n: usize| {
            field.advance(&x[n..], &m[n..], T::from_f64(0.02), Resources::default()).unwrap();
        };
        let (saved, want, slopes) = with_field(mesh, equation(walls, 0.5), 0.9, 1, |field| {
            (0..3).for_each(|n| step(field, n));
            let saved = values(field);
            // Looking ahead changes nothing.
            field.look_ahead(T::from_f64(0.3), Resources::default()).unwrap();
            assert!(values(field) == saved);
            (3..6).for_each(|n| step(field, n));
            (saved, values(field), field.grid().gradient().to_vec())
        });
        with_field(mesh, equation(walls, 0.5), 0.9, 1, |field| {
            field.set_attractant(&saved, Resources::default()).unwrap();
            let bits = |values: &[T]| values.iter().map(|c| c.to_f64().to_bits()).collect::<Vec<_>>();
            assert_eq!(bits(&values(field)), bits(&saved));
            (3..6).for_each(|n| step(field, n));
            assert!(values(field) == want && field.grid().gradient() == slopes);
        });
    }
}

#[test]
fn a_checkpoint_goes_on_bit_for_bit() {
    continues::<f64>();
    continues::<f32>();
}

#[test]
fn refusals_change_nothing() {
    let mesh = Mesh::new([0.0; 2], [1.0; 2], [8, 8]).unwrap();
    let mut none = [];
    for (scale, error) in [
        (0.0, Error::OutOfDomain),
        (-1.0, Error::OutOfDomain),
        (f64::NAN, Error::NotFinite),
        (f64::INFINITY, Error::NotFinite),
    ] {
        assert_eq!(Parabolic::prepare(&mut none, mesh, Equation::POISSON, scale, 1).err(), Some(error));
    }
    let fourth = Equation { order: Order::Fourth, ..Equation::POISSON };
    for (equation, error) in [
        (fourth, Error::Unsupported),
        (equation(Walls::FreeQuadrupole, 0.0), Error::Unsupported),
        (equation(Walls::Free, -1.0), Error::KernelParameter),
        (equation(Walls::Free, f64::NAN), Error::NotFinite),
    ] {
        assert_eq!(Parabolic::workspace_bytes(&mesh, &equation, 1), Err(error));
    }
    with_field(mesh, Equation::POISSON, 1.0, 1, |field| {
        let x = [[0.4, 0.3]];
        field.advance(&x, &[1.0], 0.1, Resources::default()).unwrap();
        let before = values(field);
        for dt in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert_eq!(field.advance(&x, &[1.0], dt, Resources::default()), Err(Error::TimeStep));
            assert_eq!(field.look_ahead(dt, Resources::default()), Err(Error::TimeStep));
        }
        assert_eq!(field.advance(&x, &[1.0, 2.0], 0.1, Resources::default()), Err(Error::LengthMismatch));
        assert_eq!(field.advance(&x, &[f64::NAN], 0.1, Resources::default()), Err(Error::NotFinite));
        assert_eq!(field.advance(&[[f64::NAN, 0.0]], &[1.0], 0.1, Resources::default()), Err(Error::NotFinite));
        let two = Threads(2);
        let two = Resources { executor: &two, ..Resources::default() };
        assert_eq!(field.advance(&x, &[1.0], 0.1, two), Err(Error::WorkspaceTooSmall));
        assert_eq!(field.settle(two), Err(Error::WorkspaceTooSmall));
        assert_eq!(field.set_attractant(&before, two), Err(Error::WorkspaceTooSmall));
        assert_eq!(field.set_attractant(&before[1..], Resources::default()), Err(Error::LengthMismatch));
        let with = |at: usize, c: f64| {
            let mut values = before.clone();
            values[at] = c;
            values
        };
        assert_eq!(field.set_attractant(&with(40, f64::NAN), Resources::default()), Err(Error::NotFinite));
        for border in [0, 5, 9, 17, 76] {
            assert_eq!(field.set_attractant(&with(border, 1.0), Resources::default()), Err(Error::OutOfDomain));
        }
        assert_eq!(field.attractant(&mut [0.0; 80]), Err(Error::LengthMismatch));
        assert!(values(field) == before && field.time_scale() == 1.0);
    });
    // In a box without decay all that is produced stays.
    with_field(mesh, equation(Walls::NoFlux, 0.0), 1.0, 1, |field| {
        field.advance(&[[0.4, 0.3]], &[1e300], 1e7, Resources::default()).unwrap();
        let before = values(field);
        assert_eq!(field.advance(&[], &[1e300], 1e7, Resources::default()), Err(Error::LengthMismatch));
        assert_eq!(field.advance(&[[0.4, 0.3]], &[1e300], 1e9, Resources::default()), Err(Error::BecameNotFinite));
        assert!(values(field) == before);
    });
}

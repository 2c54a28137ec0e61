//! Mesh fields through `mollis-core`: against the dense reference implementation and against manufactured solutions for all sizes. Results do
//! not depend on the order of the particles or the number of threads.

use std::sync::atomic::{AtomicUsize, Ordering};

use mollis_core::exec::{Executor, Resources, Serial};
use mollis_core::grid::{Equation, Grid, MassScale, Mesh, Order, Walls};
use mollis_core::memory::ALIGN;
use mollis_core::{Error, Real, Result, Scalar};
use mollis_reference::grid as twin;
use mollis_tests::Threads;

/// Deterministic numbers in (0, 1).
fn random(seed: u64) -> impl FnMut() -> f64 {
    let mut state = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1;
    move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((state >> 11) as f64 + 0.5) / (1_u64 << 53) as f64
    }
}

/// Calls `body` with a grid in a block of exactly the stated size with arbitrary contents, between canaries.
fn with_grid<T: Real, R>(
    mesh: Mesh<T>,
    equation: Equation<T>,
    workers: usize,
    body: impl FnOnce(&mut Grid<'_, T>) -> R,
) -> R {
    let bytes = Grid::workspace_bytes(&mesh, &equation, workers).unwrap();
    let mut memory = vec![0xC5_u8; bytes + 3 * ALIGN];
    let start = ALIGN + memory[ALIGN..].as_ptr().align_offset(ALIGN);
    let short = Grid::prepare(&mut memory[start..start + bytes - 1], mesh, equation, workers);
    assert_eq!(short.err(), Some(Error::WorkspaceTooSmall));
    let result = body(&mut Grid::prepare(&mut memory[start..start + bytes], mesh, equation, workers).unwrap());
    assert!(memory[..start].iter().chain(&memory[start + bytes..]).all(|&b| b == 0xC5), "a write outside");
    result
}

/// Gives all tasks of a call to one worker, and those of the next call to the next worker. Results must not depend on what a worker's scratch
/// contained before, from another phase or uninitialised.
struct Turns(usize, AtomicUsize);

impl Executor for Turns {
    fn workers(&self) -> usize {
        self.0
    }
    fn run(&self, tasks: usize, task: &(dyn Fn(usize) + Sync)) -> Result<()> {
        let worker = self.1.fetch_add(1, Ordering::Relaxed) % self.0;
        (0..tasks).for_each(|_| task(worker));
        Ok(())
    }
}

fn cloud(n: usize, case: &twin::Case, margin: f64, seed: u64) -> (Vec<[f64; 2]>, Vec<f64>) {
    let mut next = random(seed);
    let mut at = |k: usize| {
        let width = case.upper[k] - case.lower[k];
        case.lower[k] + width * (next() * (1.0 + 2.0 * margin) - margin)
    };
    let x = (0..n).map(|_| [at(0), at(1)]).collect();
    let mut next = random(seed + 1);
    (x, (0..n).map(|_| 0.1 + next()).collect())
}

fn largest(values: impl IntoIterator<Item = f64>) -> f64 {
    values.into_iter().fold(0.0, |a, b| a.max(b.abs()))
}

#[test]
fn agrees_with_the_dense_twin() {
    for (cells, seed) in [([2, 2], 1), ([2, 9], 2), ([9, 2], 3), ([3, 4], 4), ([8, 8], 5), ([16, 11], 6), ([13, 17], 7)]
    {
        for screening in [0.0, 0.5, 6.0] {
            for no_flux in [false, true] {
                let case = twin::Case { lower: [-1.0, 2.0], upper: [1.5, 3.0], cells, screening, no_flux };
                let (x, m) = cloud(60, &case, if no_flux { 0.0 } else { 0.1 }, seed);
                let mut targets = x.clone();
                targets.extend([case.lower, case.upper, [-1.0, 3.0], [0.1, 2.0], [-1.0, 2.2]]);
                if !no_flux {
                    targets.extend([[10.0, -7.0], [1.6, 2.5]]);
                }
                let want = twin::field(&case, &x, &m, &targets);
                let walls = if no_flux { Walls::NoFlux } else { Walls::Free };
                let mesh = Mesh::new(case.lower, case.upper, cells).unwrap();
                with_grid(mesh, Equation { screening, walls, ..Equation::POISSON }, 1, |grid| {
                    grid.deposit(&x, &m, Resources::default()).unwrap();
                    grid.solve(Resources::default()).unwrap();
                    let (mut masses, mut u) = (vec![f64::NAN; mesh.nodes()], vec![f64::NAN; mesh.nodes()]);
                    grid.masses(&mut masses).unwrap();
                    grid.potential(&mut u).unwrap();
                    let mut gradient = vec![[f64::NAN; 2]; targets.len()];
                    grid.interpolate(&targets, &mut gradient, Resources::default()).unwrap();
                    // Masses: an error of half a unit, 2^-50 of at most twice the total, for each share of 60 particles.
                    let total: f64 = m.iter().sum();
                    for (a, b) in masses.iter().zip(&want.masses) {
                        assert!((a - b).abs() < 120.0 * 2.0_f64.powi(-50) * total);
                    }
                    // The condition number of the system is at most 8 / (pi / 17)^2 = 234 for these sizes. Both solvers lose a few
                    // times that in u, and the moments of the outside particles have units of 2^-40.
                    let size = largest(want.potential.iter().copied()) + total;
                    for (a, b) in u.iter().zip(&want.potential) {
                        assert!((a - b).abs() < 1e-11 * size, "{case:?}: {a} {b}");
                    }
                    // The error is divided by the mesh width, at least 1 / 17.
                    let size = largest(want.gradient.iter().flatten().copied()) + 17.0 * size;
                    for ((a, b), x) in gradient.iter().zip(&want.gradient).zip(&targets) {
                        for (a, b) in a.iter().zip(b) {
                            assert!((a - b).abs() < 1e-11 * size, "{case:?} {x:?}: {a} {b}");
                        }
                    }
                });
            }
        }
    }
}

/// The error of the solve against a manufactured solution: integers u (zero on the border of free space) whose five-point
/// Laplacian is exactly an integer number of mass units. Mesh widths 1 and `ratio`.
fn manufactured_error(cells: [usize; 2], ratio: usize, walls: Walls) -> f64 {
    let [n, m] = cells;
    let mesh = Mesh::new([0.0, 0.0], [n as f64, (m * ratio) as f64], cells).unwrap();
    let at = |i: usize, j: usize| j * (n + 1) + i;
    let free = walls == Walls::Free;
    // The lowest mode, which the solve amplifies most, and noise, in multiples of 4 ratio so that all shares are integers.
    let mut next = random((n * 1000 + m) as u64);
    let step = (4 * ratio) as f64;
    let mut u = vec![0_i64; mesh.nodes()];
    for j in 0..=m {
        for i in 0..=n {
            if free && (i == 0 || i == n || j == 0 || j == m) {
                continue;
            }
            let (x, y) = (i as f64 / n as f64 * std::f64::consts::PI, j as f64 / m as f64 * std::f64::consts::PI);
            let smooth = if free { x.sin() * y.sin() } else { x.cos() + y.cos() };
            u[at(i, j)] = ((smooth + 0.1 * (next() - 0.5)) * 1e6 / step).round() as i64 * (4 * ratio as i64);
        }
    }
    with_grid(mesh, Equation { screening: 0.0, walls, ..Equation::POISSON }, 1, |grid| {
        // The mass unit is 1.
        grid.begin(MassScale::for_total(2.0_f64.powi(49)).unwrap());
        assert_eq!(grid.scale().exponent(), 0);
        let words = grid.words_mut();
        let mirror = |i: isize, n: usize| {
            if i < 0 {
                1
            } else if i as usize > n {
                n - 1
            } else {
                i as usize
            }
        };
        let mut total = 0;
        for j in 0..=m {
            for i in 0..=n {
                let (ex, ey) = (i == 0 || i == n, j == 0 || j == m);
                if free && (ex || ey) {
                    continue;
                }
                let u_at = |di: isize, dj: isize| u[at(mirror(i as isize + di, n), mirror(j as isize + dj, m))];
                let c = 2 * u[at(i, j)];
                // Laplacian times the cell's area, ratio, halved at walls.
                let area = if ex { 1 } else { 2 } * if ey { 1 } else { 2 };
                let r = ratio as i64;
                let along = (u_at(-1, 0) + u_at(1, 0) - c) * r;
                let across = (u_at(0, -1) + u_at(0, 1) - c) / r;
                let w = (along + across) * area / 4;
                words[at(i, j)] = w;
                total += w;
            }
        }
        if free {
            // The net mass is zero, so the monopole is zero: the difference is counted as outside.
            words[mesh.nodes() + 1] = -total;
        } else {
            assert_eq!(total, 0);
        }
        grid.solve(Resources::default()).unwrap();
        let mut got = vec![f64::NAN; mesh.nodes()];
        grid.potential(&mut got).unwrap();
        let share = |i: usize, n: usize| if i == 0 || i == n { 0.5 } else { 1.0 };
        let mut mean = 0.0;
        if !free {
            for j in 0..=m {
                mean += (0..=n).map(|i| share(i, n) * share(j, m) * u[at(i, j)] as f64).sum::<f64>();
            }
            mean /= (n * m) as f64;
        }
        let size = largest(u.iter().map(|&u| u as f64));
        largest(got.iter().zip(&u).map(|(a, &b)| a - (b as f64 - mean))) / size
    })
}

#[test]
fn every_size_against_a_manufactured_solution() {
    let mut worst = 0.0_f64;
    for n in 3..=257 {
        // A square (primes are transformed along one axis), and partners along which the transform runs, or does not.
        for (cells, ratio) in [([n, n], 1), ([n, 16], 2), ([16, n], 1), ([n, 59], 1)] {
            worst = worst.max(manufactured_error(cells, ratio, Walls::Free));
        }
        if n % 8 == 1 || n > 250 {
            worst = worst.max(manufactured_error([n, n], 1, Walls::NoFlux));
        }
    }
    for cells in [[511, 511], [1000, 1000], [1000, 511], [509, 521], [257, 1000], [3, 1000], [1000, 3]] {
        for walls in [Walls::Free, Walls::NoFlux] {
            worst = worst.max(manufactured_error(cells, 1, walls));
        }
    }
    println!("largest error {worst:.2e}");
    assert!(worst <= 1e-12, "{worst:e}");
}

#[test]
fn any_order_any_number_of_threads_any_split_the_same_bits() {
    let case = twin::Case { lower: [-1.0, -1.0], upper: [1.0, 1.0], cells: [48, 33], screening: 0.0, no_flux: false };
    let (x, mut m) = cloud(50_000, &case, 0.02, 11);
    // One heavy particle.
    m[777] = 1e6;
    let mesh = Mesh::new(case.lower, case.upper, case.cells).unwrap();
    let run = |x: &[[f64; 2]], m: &[f64], executor: &dyn Executor| {
        let resources = Resources { executor, ..Resources::default() };
        with_grid(mesh, Equation::POISSON, executor.workers(), |grid| {
            grid.deposit(x, m, resources).unwrap();
            grid.solve(resources).unwrap();
            let mut gradient = vec![[0.0; 2]; x.len()];
            grid.interpolate(x, &mut gradient, resources).unwrap();
            let bits: Vec<[u64; 2]> = gradient.iter().map(|g| g.map(f64::to_bits)).collect();
            (grid.words().to_vec(), grid.outside(), *grid.monopole(), bits)
        })
    };
    let want = run(&x, &m, &Serial);
    assert!(want.1 > 0);
    for threads in [1, 2, 3, 7] {
        assert!(run(&x, &m, &Threads(threads)) == want, "{threads} threads");
    }
    for workers in [2, 3, 7] {
        assert!(run(&x, &m, &Turns(workers, AtomicUsize::new(0))) == want, "{workers} workers in turn");
    }
    let (backwards_x, backwards_m): (Vec<_>, Vec<_>) =
        (x.iter().rev().copied().collect(), m.iter().rev().copied().collect());
    let mut backwards = run(&backwards_x, &backwards_m, &Threads(2));
    backwards.3.reverse();
    assert!(backwards == want);

    // Several ranks: each deposits a part with the common scale, and the integers are added.
    let scale = MassScale::of(&m).unwrap();
    let mut sum = vec![0_i64; want.0.len()];
    for (x, m) in x.chunks(12_345).zip(m.chunks(12_345)) {
        with_grid(mesh, Equation::POISSON, 1, |grid| {
            grid.begin(scale);
            grid.add(x, m, Resources::default()).unwrap();
            sum.iter_mut().zip(grid.words()).for_each(|(s, w)| *s += w);
        });
    }
    assert!(sum == want.0);
    let square = Mesh::new(case.lower, case.upper, [48, 41]).unwrap();
    let fourth = |executor: &dyn Executor| {
        let resources = Resources { executor, ..Resources::default() };
        with_grid(square, Equation { order: Order::Fourth, ..Equation::POISSON }, executor.workers(), |grid| {
            grid.deposit(&x, &m, resources).unwrap();
            grid.solve(resources).unwrap();
            grid.gradient().iter().map(|g| g.map(f64::to_bits)).collect::<Vec<_>>()
        })
    };
    assert!(fourth(&Threads(3)) == fourth(&Serial));
    // A single target gives the same bits as all targets together.
    with_grid(mesh, Equation::POISSON, 1, |grid| {
        grid.deposit(&x, &m, Resources::default()).unwrap();
        grid.solve(Resources::default()).unwrap();
        for (x, bits) in x.iter().zip(&want.3).step_by(97) {
            assert_eq!(grid.gradient_at(*x).map(f64::to_bits), *bits);
        }
    });
}

#[test]
fn a_lone_particle_is_hardly_moved_by_itself() {
    // In infinite free space a particle's own field vanishes at it by symmetry: deposit and interpolation are adjoint
    // and the centred difference is antisymmetric. What remains is the error of the border data. The border has the value of
    // the monopole instead of the lattice Green's function: O((h / distance)^2) relative, a small smooth field.
    let mesh = Mesh::new([-1.0, -1.0], [1.0, 1.0], [64, 64]).unwrap();
    for order in [Order::Second, Order::Fourth] {
        with_grid(mesh, Equation { order, ..Equation::POISSON }, 1, |grid| {
            let mut next = random(4);
            for _ in 0..50 {
                let x = [next() - 0.5, next() - 0.5];
                grid.deposit(&[x], &[1.0], Resources::default()).unwrap();
                grid.solve(Resources::default()).unwrap();
                let own = grid.gradient_at(x);
                // The field one mesh width away is 1 / (2 pi h) = 5.
                assert!(own[0].hypot(own[1]) < 1e-3, "{order:?} {x:?} {own:?}");
            }
        });
    }
}

#[test]
fn no_flux_mirrors_what_is_outside() {
    let mesh = Mesh::new([0.0, 0.0], [2.0, 1.0], [20, 14]).unwrap();
    let equation = Equation { screening: 2.0, walls: Walls::NoFlux, ..Equation::POISSON };
    let inside = [[0.3, 0.2], [1.9, 0.6], [0.25, 0.875]];
    // The same positions after one or several reflections (exact in binary where the sums are).
    let outside = [[-0.3, 0.2], [2.1, 1.4], [4.25, -0.875]];
    let m = [1.0, 2.0, 3.0];
    let run = |x: &[[f64; 2]]| {
        with_grid(mesh, equation, 1, |grid| {
            grid.deposit(x, &m, Resources::default()).unwrap();
            grid.solve(Resources::default()).unwrap();
            assert_eq!(grid.outside(), 0);
            let mut u = vec![0.0; mesh.nodes()];
            grid.potential(&mut u).unwrap();
            (u, [inside, outside].map(|x| x.map(|x| grid.gradient_at(x))))
        })
    };
    let (a, b) = (run(&inside), run(&outside));
    let size = largest(a.0.iter().copied());
    assert!(a.0.iter().zip(&b.0).all(|(a, b)| (a - b).abs() < 1e-13 * size));
    let signs = [[-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]];
    for ((inside, outside), sign) in a.1[0].iter().zip(&a.1[1]).zip(signs) {
        for k in 0..2 {
            assert!((inside[k] - sign[k] * outside[k]).abs() < 1e-12 * size * 20.0);
        }
    }
}

#[test]
fn single_precision_agrees_with_double() {
    let case = twin::Case { lower: [-1.0, -1.0], upper: [1.0, 1.0], cells: [40, 30], screening: 0.0, no_flux: false };
    let (x, m) = cloud(2000, &case, 0.0, 21);
    let (x32, m32): (Vec<[f32; 2]>, Vec<f32>) =
        (x.iter().map(|x| x.map(|v| v as f32)).collect(), m.iter().map(|&m| m as f32).collect());
    let (x, m): (Vec<[f64; 2]>, Vec<f64>) =
        (x32.iter().map(|x| x.map(f64::from)).collect(), m32.iter().map(|&m| f64::from(m)).collect());
    let mut want = vec![[0.0; 2]; x.len()];
    let mut got = vec![[0.0_f32; 2]; x.len()];
    with_grid(Mesh::new([-1.0, -1.0], [1.0, 1.0], case.cells).unwrap(), Equation::POISSON, 1, |grid| {
        grid.deposit(&x, &m, Resources::default()).unwrap();
        grid.solve(Resources::default()).unwrap();
        grid.interpolate(&x, &mut want, Resources::default()).unwrap();
    });
    with_grid(Mesh::new([-1.0_f32, -1.0], [1.0, 1.0], case.cells).unwrap(), Equation::POISSON, 1, |grid| {
        grid.deposit(&x32, &m32, Resources::default()).unwrap();
        grid.solve(Resources::default()).unwrap();
        grid.interpolate(&x32, &mut got, Resources::default()).unwrap();
    });
    let size = largest(want.iter().flatten().copied());
    for (a, b) in got.iter().flatten().zip(want.iter().flatten()) {
        // u of the potential, a few times 2e-7, over the width 1 / 20 of a difference.
        assert!((f64::from(*a) - b).abs() < 1e-4 * size, "{a} {b}");
    }
}

#[test]
fn refuses_what_it_must_and_leaves_the_rest() {
    let mesh = Mesh::new([0.0, 0.0], [1.0, 1.0], [8, 8]).unwrap();
    assert_eq!(Mesh::new([0.0, 0.0], [1.0, f64::NAN], [8, 8]).err(), Some(Error::NotFinite));
    assert_eq!(Mesh::new([0.0, 0.0], [1.0, 0.0], [8, 8]).err(), Some(Error::OutOfDomain));
    assert_eq!(Mesh::new([0.0, 0.0], [1.0, 1.0], [8, 1]).err(), Some(Error::OutOfDomain));
    assert_eq!(Mesh::new([0.0, 0.0], [1.0, 1.0], [8, usize::MAX]).err(), Some(Error::TooLarge));
    let negative = Equation { screening: -1.0, walls: Walls::Free, ..Equation::POISSON };
    assert_eq!(Grid::workspace_bytes(&mesh, &negative, 1), Err(Error::KernelParameter));
    let infinite = Equation { screening: f64::INFINITY, walls: Walls::Free, ..Equation::POISSON };
    assert_eq!(Grid::workspace_bytes(&mesh, &infinite, 1), Err(Error::NotFinite));
    let screened = Equation { screening: 1.0, walls: Walls::FreeQuadrupole, ..Equation::POISSON };
    let fourth = Equation { order: Order::Fourth, ..Equation::POISSON };
    let long = Mesh::new([0.0, 0.0], [1.0, 1.26], [8, 8]).unwrap();
    assert_eq!(Grid::workspace_bytes(&long, &fourth, 1), Err(Error::Unsupported));
    assert!(Grid::workspace_bytes(&Mesh::new([0.0, 0.0], [1.0, 1.24], [8, 8]).unwrap(), &fourth, 1).is_ok());
    let coarse = Equation { screening: 8.1, ..fourth };
    assert_eq!(Grid::workspace_bytes(&mesh, &coarse, 1), Err(Error::Unsupported));
    assert_eq!(Grid::workspace_bytes(&mesh, &screened, 1), Err(Error::Unsupported));
    with_grid(mesh, Equation::POISSON, 1, |grid| {
        grid.deposit(&[[0.5, 0.5]], &[1.0], Resources::default()).unwrap();
        let before = grid.words().to_vec();
        assert_eq!(grid.deposit(&[[0.5, 0.5]], &[], Resources::default()), Err(Error::LengthMismatch));
        assert_eq!(grid.deposit(&[[0.5, 0.5]], &[f64::NAN], Resources::default()), Err(Error::NotFinite));
        let two = Resources { executor: &Threads(2), ..Resources::default() };
        assert_eq!(grid.deposit(&[[0.5, 0.5]], &[1.0], two), Err(Error::WorkspaceTooSmall));
        assert_eq!(grid.solve(two), Err(Error::WorkspaceTooSmall));
        assert_eq!(grid.interpolate(&[[0.5, 0.5]], &mut [], Resources::default()), Err(Error::LengthMismatch));
        assert_eq!(grid.potential(&mut [0.0; 3]), Err(Error::LengthMismatch));
        assert_eq!(grid.masses(&mut [0.0; 3]), Err(Error::LengthMismatch));
        assert!(grid.words() == before);
        assert_eq!(grid.add(&[[f64::NAN, 0.5]], &[1.0], Resources::default()), Err(Error::NotFinite));
        // Zero mass, and masses that cancel.
        grid.deposit(&[], &[], Resources::default()).unwrap();
        grid.solve(Resources::default()).unwrap();
        assert!(grid.gradient().iter().flatten().all(|&g| g == 0.0));
        grid.deposit(&[[0.25, 0.5], [0.75, 0.5]], &[1.0, -1.0], Resources::default()).unwrap();
        grid.solve(Resources::default()).unwrap();
        assert_eq!(grid.monopole().mass, 0.0);
        assert!(grid.gradient_at([0.5, 0.5])[0] > 0.0 && grid.gradient_at([9.0, 9.0]) == [0.0, 0.0]);
    });
}

#[test]
fn mass_far_outside_or_at_the_border_gives_finite_fields() {
    let mesh = Mesh::new([0.0, 0.0], [1.0, 1.0], [12, 10]).unwrap();
    for screening in [0.0, 1e-3, 1e3, 1e300] {
        for walls in [Walls::Free, Walls::FreeQuadrupole] {
            if walls == Walls::FreeQuadrupole && screening > 0.0 {
                continue;
            }
            for x in [[1e300, -1e300], [0.0, 0.0], [1.0, 0.5], [-0.1, 0.5], [1e-300, 1.0], [0.5, -1e4]] {
                with_grid(mesh, Equation { screening, walls, ..Equation::POISSON }, 1, |grid| {
                    grid.deposit(&[x, x], &[1.0, 1e-9], Resources::default()).unwrap();
                    grid.solve(Resources::default()).unwrap();
                    assert!(grid.gradient().iter().flatten().all(|g| g.is_finite()), "{screening} {x:?}");
                    assert!(grid.gradient_at([2.0, 2.0]).iter().all(|g| g.is_finite()));
                });
            }
        }
    }
}

/// Two discs side by side, as in Section 5.3. The monopole on the border leaves out (0.5 / 1.5)^2 = 11% of the field there. The second moments
/// leave out 1% (third moments vanish by symmetry).
#[test]
fn second_moments_on_the_border_bring_the_field_of_divided_mass() {
    let mesh = Mesh::new([-1.5; 2], [1.5; 2], [150; 2]).unwrap();
    let disc = |centre: [f64; 2]| {
        (1..=6).flat_map(move |ring| {
            (0..6 * ring).map(move |k| {
                let (sin, cos) = (std::f64::consts::TAU * f64::from(k) / f64::from(6 * ring)).sin_cos();
                let r = 0.05 * f64::from(ring);
                [centre[0] + r * cos, centre[1] + r * sin]
            })
        })
    };
    let x: Vec<[f64; 2]> = disc([0.35, -0.35]).chain(disc([-0.35, 0.35])).collect();
    let m = vec![1.0 / x.len() as f64; x.len()];
    let error = |walls| {
        with_grid(mesh, Equation { screening: 0.0, walls, ..Equation::POISSON }, 1, |grid| {
            grid.deposit(&x, &m, Resources::default()).unwrap();
            grid.solve(Resources::default()).unwrap();
            let (mut worst, mut largest) = (0.0_f64, 0.0_f64);
            for k in 0..40 {
                let (sin, cos) = (std::f64::consts::TAU * f64::from(k) / 40.0).sin_cos();
                for r in [1.2, 1.4, 2.4] {
                    let at = [r * cos, r * sin];
                    let mut exact = [0.0; 2];
                    for (y, m) in x.iter().zip(&m) {
                        let d = [at[0] - y[0], at[1] - y[1]];
                        let factor = m / (std::f64::consts::TAU * (d[0] * d[0] + d[1] * d[1]));
                        exact = [exact[0] + factor * d[0], exact[1] + factor * d[1]];
                    }
                    let got = grid.gradient_at(at);
                    worst = worst.max((got[0] - exact[0]).hypot(got[1] - exact[1]));
                    largest = largest.max(exact[0].hypot(exact[1]));
                }
            }
            worst / largest
        })
    };
    let (monopole, quadrupole) = (error(Walls::Free), error(Walls::FreeQuadrupole));
    assert!(monopole > 0.05 && quadrupole < 0.02 && quadrupole < monopole / 5.0, "{monopole} {quadrupole}");
}

/// (3 / pi R^2) (1 - r^2 / R^2)^2, of mass 1, on a lattice. The sum of m x . grad u over all of it is 1 / (4 pi) for any shape: it is half of
/// the sum over pairs of m m x . x / (2 pi r^2). What a mesh loses of it is the error of the rate of the second moment.
#[test]
fn what_the_mesh_loses_of_the_attraction_falls_as_the_order_says() {
    let radius: f64 = 0.5;
    let fine = 1.0 / 1024.0;
    let (mut x, mut m) = (Vec::new(), Vec::new());
    for (i, j) in (-512..512).flat_map(|i| (-512..512).map(move |j| (i, j))) {
        let at = [(f64::from(i) + 0.5) * fine, (f64::from(j) + 0.5) * fine];
        let t = 1.0 - (at[0] * at[0] + at[1] * at[1]) / (radius * radius);
        if t > 0.0 {
            x.push(at);
            m.push(3.0 / (std::f64::consts::PI * radius * radius) * t * t * fine * fine);
        }
    }
    let total: f64 = m.iter().sum();
    m.iter_mut().for_each(|m| *m /= total);
    let lost = |order, cells: [usize; 2]| {
        let mesh = Mesh::new([-1.0, -1.1], [1.0, 0.9], cells).unwrap();
        with_grid(mesh, Equation { order, ..Equation::POISSON }, 1, |grid| {
            grid.deposit(&x, &m, Resources::default()).unwrap();
            grid.solve(Resources::default()).unwrap();
            let mut g = vec![[0.0; 2]; x.len()];
            grid.interpolate(&x, &mut g, Resources::default()).unwrap();
            let virial: f64 = x.iter().zip(&m).zip(&g).map(|((x, m), g)| m * (x[0] * g[0] + x[1] * g[1])).sum();
            (1.0 - virial * 4.0 * std::f64::consts::PI).abs()
        })
    };
    // In the second case the transform runs along y.
    for coarse in [[32, 32], [36, 32]] {
        let fine = coarse.map(|n| 2 * n);
        let [a, b] = [coarse, fine].map(|cells| lost(Order::Second, cells));
        let [c, d] = [coarse, fine].map(|cells| lost(Order::Fourth, cells));
        // The root mean square radius is R / 2: 0.4 (h / a)^2, 2.5% and 0.6% for the square cells.
        assert!((3.6..4.4).contains(&(a / b)) && (0.005..0.007).contains(&b), "{a:e} {b:e}");
        assert!(c / d > 12.0 && d < b / 100.0, "{c:e} {d:e}");
    }
}

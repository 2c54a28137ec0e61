//! Field sums whose units, distances or numbers are at the ends of the scalar's range.

use mollis_core::exec::{Executor, Run};
use mollis_core::field::{self, Method, Options, Outputs, Sources, Wanted};
use mollis_core::kernel::{Kernel, Law, Term};
use mollis_core::mollifier::Mollifier;
use mollis_core::simd::Level;
use mollis_core::{Error, Real};
use mollis_tests::Aligned;

use crate::field_bounds::{ALL, COMPACT, LAPLACIAN, POTENTIAL, power, sums_of, term, with_kernel};

/// A result in range is computed for any units of the input.
#[test]
fn results_in_range_are_computed() {
    fn one<T: Real, const D: usize>(
        terms: &[Term],
        shape: (Mollifier, f64),
        (r, mass): (f64, f64),
        options: &Options,
    ) -> [f64; 3] {
        let mut x = [T::ZERO; D];
        x[0] = T::from_f64(r);
        with_kernel::<T, D, _>(terms, shape, |kernel| {
            let got = sums_of(kernel, (&[[T::ZERO; D]], &[T::from_f64(mass)], &[x]), ALL, options, Level::best());
            [got.potential[0], got.gradient[0][0], got.laplacian[0]].map(T::to_f64)
        })
    }
    let near = |got: f64, want: f64, eps: f64| (got - want).abs() <= 100.0 * eps * want.abs();
    let (single, double) = (f64::from(f32::EPSILON), f64::EPSILON);
    let none = (Mollifier::None, 0.0);
    let auto = Options::default();
    let direct = Options { method: Some(Method::Direct), ..auto };
    for options in [&auto, &direct] {
        // |x|^8 / 8 in f32: the gradient of 1e-5 at 1e5 is 1e30, of 1 at 1e-4 is 1e-28.
        assert!(near(one::<f32, 2>(&[term(power(8.0), 1.0)], none, (1e5, 1e-5), options)[1], 1e30, 20.0 * single));
        assert!(near(one::<f32, 2>(&[term(power(8.0), 1.0)], none, (1e-4, 1.0), options)[1], 1e-28, 20.0 * single));
        // |x|^3 / 3: the potential of 1e-10 at 1e15, whose cube is beyond f32.
        assert!(near(
            one::<f32, 2>(&[term(power(3.0), 1.0)], none, (1e15, 1e-10), options)[0],
            1e35 / 3.0,
            20.0 * single
        ));
        assert!(near(
            one::<f32, 1>(&[term(power(3.0), 1.0)], none, (1e15, 1e-10), options)[0],
            1e35 / 3.0,
            20.0 * single
        ));
        // |x|^2 / 2 at 1e-200: the gradient is x, the Laplacian the dimension.
        let [_, g, l] = one::<f64, 2>(&[term(power(2.0), 1.0)], (COMPACT, 1.0), (1e-200, 1.0), options);
        assert!(near(g, 1e-200, double) && near(l, 2.0, double));
    }
    // Powers of coordinates overflow where results do not: |x|^4 / 4 of mass 1e-200 at 1e100. (Over pairs the kernel itself must be in the
    // range of f64.)
    assert!(near(one::<f64, 2>(&[term(power(4.0), 1.0)], none, (1e100, 1e-200), &auto)[0], 0.25e200, double));
    // Distances whose squares overflow or underflow.
    for r in [2e19, 1e25, 1e-22, 1e-24, 1e-30] {
        let got = one::<f32, 2>(&[term(power(-0.5), 1.0)], none, (r, 1.0), &auto)[0];
        assert!(near(got, -2.0 / f64::from(r as f32).sqrt(), single), "{r} {got}");
    }
    for r in [1e-158, 1e-170, 1e160] {
        let got = one::<f64, 2>(&[term(power(-0.5), 1.0)], none, (r, 1.0), &auto)[0];
        assert!(near(got, -2.0 / r.sqrt(), double), "{r} {got}");
    }
    // In one dimension sums by sorting and by pairs agree for a tiny mollifier and a large mass.
    let scene = |options: &Options| {
        let x: Vec<[f32; 1]> = (0..60).map(|k| [k as f32 * 2e-32]).collect();
        let masses = vec![1e9_f32; 60];
        with_kernel::<f32, 1, _>(&[term(Law::Newtonian, 1.0)], (COMPACT, 1e-30), |kernel| {
            sums_of(kernel, (&x, &masses, &x), Wanted { laplacian: false, ..ALL }, options, Level::best()).gradient
        })
    };
    for (sorted, paired) in scene(&auto).iter().zip(scene(&direct)) {
        assert!(sorted[0].is_finite() && (sorted[0] - paired[0]).abs() <= 60e9 * 100.0 * f32::EPSILON);
    }
}

/// The sums at one target of sources in a row along the first axis.
pub(crate) fn row<T: Real, const D: usize>(
    terms: &[Term],
    shape: (Mollifier, f64),
    (sources, target): (&[(f64, f64)], f64),
    (wanted, method): (Wanted, Method),
) -> [f64; 3] {
    let point = |r: f64| {
        let mut x = [T::ZERO; D];
        x[0] = T::from_f64(r);
        x
    };
    let positions: Vec<[T; D]> = sources.iter().map(|&(r, _)| point(r)).collect();
    let masses: Vec<T> = sources.iter().map(|&(_, m)| T::from_f64(m)).collect();
    let options = Options { method: Some(method), ..Options::default() };
    with_kernel::<T, D, _>(terms, shape, |kernel| {
        let scene = (&positions[..], &masses[..], &[point(target)][..]);
        let got = sums_of(kernel, scene, wanted, &options, Level::best());
        [got.potential[0], got.gradient[0][0], got.laplacian[0]].map(T::to_f64)
    })
}

/// In single precision, where the reference in double precision is in range.
fn row_is_right<const D: usize>(terms: &[Term], shape: (Mollifier, f64), scene: (&[(f64, f64)], f64), method: Method) {
    let single = |x: f64| f64::from(x as f32);
    let shape = (shape.0, single(shape.1));
    let (mut want, mut scale) = ([0.0; 3], [0.0; 3]);
    with_kernel::<f64, D, _>(terms, shape, |kernel| {
        for &(y, m) in scene.0 {
            let x = single(scene.1) - single(y);
            let [u, g, l] = kernel.at(x.abs());
            for (k, v) in [u, g * x, l].into_iter().enumerate() {
                want[k] += single(m) * v;
                scale[k] += (single(m) * v).abs();
            }
            scale[0] += if D == 2 { m.abs() } else { 0.0 };
            scale[2] += 2.0 * D as f64 * (m * g).abs();
        }
    });
    let wanted = if method == Method::Neighbours { LAPLACIAN } else { ALL };
    let got = row::<f32, D>(terms, shape, scene, (wanted, method));
    for k in 0..3 {
        if (k == 2 || method != Method::Neighbours) && scale[k] < 1e38 {
            let bound = 512.0 * f64::from(f32::EPSILON) * scale[k] + 2e-45;
            assert!(
                (got[k] - want[k]).abs() <= bound,
                "{D}D {terms:?} {shape:?} {scene:?} {method:?} {k}: {got:?} {want:?}"
            );
        }
    }
}

/// Mollified powers whose values, but not whose gradients and Laplacians, are below the range.
#[test]
fn powers_of_tiny_lengths() {
    fn check<const D: usize>(exponent: f64, shape: (Mollifier, f64), r: f64, [gradient, laplacian]: [f64; 2]) {
        let mut target = [0.0; D];
        target[0] = r;
        with_kernel::<f64, D, _>(&[term(power(exponent), 1.0)], shape, |kernel| {
            let options = Options { method: Some(Method::Direct), ..Options::default() };
            let got = sums_of(kernel, (&[[0.0; D]], &[1.0], &[target]), ALL, &options, Level::best());
            let close = |got: f64, want: f64| (got / want - 1.0).abs() < 1e-12;
            assert!(close(got.gradient[0][0], gradient), "{exponent} {shape:?}: {} {gradient}", got.gradient[0][0]);
            assert!(close(got.laplacian[0], laplacian), "{exponent} {shape:?}: {} {laplacian}", got.laplacian[0]);
        });
    }
    let gaussian = Mollifier::Gaussian { order: 4 };
    for delta in [1e-150, 1e-157, 1e-160, 1e-170] {
        // A mollifier only shifts |x|^2 / 2.
        check::<2>(2.0, (gaussian, delta), 0.8 * delta, [0.8 * delta, 2.0]);
    }
    let eighth = Mollifier::Compact { order: 8, exponent: 3 };
    for delta in [1e-100, 1e-104, 1e-106, 1e-108, 1e-110, 1e-120] {
        let r: f64 = 100.0 * delta;
        check::<1>(3.0, (eighth, delta), r, [r * r, 2.0 * r]);
    }
}

/// Even powers of distances that are small beside the coordinates.
#[test]
fn moments_of_a_small_cloud_far_away() {
    let (x, y) = ([75.0_f32], [75.0 + 3.05e-5_f32]);
    let r = f64::from(y[0]) - f64::from(x[0]);
    with_kernel::<f32, 1, _>(&[term(power(8.0), 1.0)], (Mollifier::None, 0.0), |kernel| {
        let got = sums_of(kernel, (&[x], &[1.0], &[y]), ALL, &Options::default(), Level::best());
        let close = |got: f32, want: f64| (f64::from(got) / want - 1.0).abs() < 1e-5;
        assert!(close(got.gradient[0][0], r.powi(7)), "{:e} {:e}", got.gradient[0][0], r.powi(7));
        assert!(close(got.potential[0], r.powi(8) / 8.0), "{:e}", got.potential[0]);
        assert!(close(got.laplacian[0], 7.0 * r.powi(6)), "{:e}", got.laplacian[0]);
    });
}

/// Even powers at targets of very different distances.
#[test]
fn moments_near_and_far() {
    fn check<T: Real>(p: f64, sources: &[(f64, f64)], targets: &[f64]) {
        let x: Vec<[T; 1]> = sources.iter().map(|&(x, _)| [T::from_f64(x)]).collect();
        let m: Vec<T> = sources.iter().map(|&(_, m)| T::from_f64(m)).collect();
        let y: Vec<[T; 1]> = targets.iter().map(|&y| [T::from_f64(y)]).collect();
        let moments = Options { method: Some(Method::Moments), ..Options::default() };
        with_kernel::<T, 1, _>(&[term(power(p), 1.0)], (Mollifier::None, 0.0), |kernel| {
            let wanted = Wanted { laplacian: p > 2.0, ..ALL };
            let got = sums_of(kernel, (&x, &m, &y), wanted, &moments, Level::best());
            for (i, y) in y.iter().enumerate() {
                // The sums, and those of magnitudes.
                let mut want = [0.0; 3];
                let mut size = 0.0;
                for (x, m) in x.iter().zip(&m) {
                    let (d, m) = (y[0].to_f64() - x[0].to_f64(), m.to_f64());
                    if m != 0.0 {
                        want[0] += m * d.abs().powf(p) / p;
                        want[1] += m * d.abs().powf(p - 1.0) * d.signum();
                        size += m * d.abs().powf(p - 1.0);
                        want[2] += m * (p - 1.0) * d.abs().powf(p - 2.0);
                    }
                }
                let laplacian = if wanted.laplacian { got.laplacian[i] } else { T::from_f64(want[2]) };
                let sizes = [want[0], size, want[2]];
                for ((got, want), size) in
                    [got.potential[i], got.gradient[i][0], laplacian].into_iter().zip(want).zip(sizes)
                {
                    let (got, want) = (got.to_f64(), T::from_f64(want).to_f64());
                    // Results below the normal range are rounded more coarsely.
                    let allowed =
                        300.0 * T::EPSILON.to_f64() * size + 4.0 * T::MIN_POSITIVE.to_f64() * T::EPSILON.to_f64();
                    assert!(got == want || (got - want).abs() <= allowed, "|x|^{p} at {}: {got:e} {want:e}", y[0]);
                }
            }
        });
    }
    check::<f32>(8.0, &[(0.0, 1e20)], &[1.0, 1e-6]);
    check::<f32>(8.0, &[(0.0, 1.0)], &[6e4, 5e-5, 1.0]);
    check::<f32>(8.0, &[(0.0, 1.0)], &[1e18, 1e4, 0.0]);
    check::<f32>(4.0, &[(0.0, 1.0)], &[1e9, 1e-9]);
    check::<f32>(2.0, &[(0.0, 1.0)], &[1e18, 1e-18]);
    check::<f64>(8.0, &[(0.0, 1.0)], &[1e30, 1e-38, 1e60]);
    // Particles without mass that are parked far away.
    let cloud = |parked: f64| -> Vec<(f64, f64)> {
        (0..40).map(|k| (f64::from(k) / 64.0, 1.0)).chain([(parked, 0.0)]).collect()
    };
    for (p, parked) in [(8.0, 1e9), (6.0, 1e12), (4.0, 1e20), (2.0, 1e30), (2.0, 1e35)] {
        check::<f32>(p, &cloud(parked), &[0.25, 0.75, 40.0, parked]);
    }
    check::<f64>(8.0, &cloud(1e60), &[0.25, 0.75, 40.0, 1e60]);
}

/// Kernels whose K'/r leaves double precision are refused.
#[test]
fn kernels_out_of_range_are_refused() {
    fn prepare(law: Law, coefficient: f64, shape: (Mollifier, f64)) -> mollis_core::Result<()> {
        let terms = [term(law, coefficient)];
        let before = [term(power(1.5), 1.0)];
        let bytes = Kernel::<f64, 3>::workspace_bytes(&before, COMPACT)?;
        let mut block = Aligned::new(bytes.max(Kernel::<f64, 3>::workspace_bytes(&terms, shape.0)?));
        // Whatever was prepared there before is no block after an error.
        Kernel::<f64, 3>::prepare(block.bytes(), &before, COMPACT, 1.0)?;
        let made = Kernel::<f64, 3>::prepare(block.bytes(), &terms, shape.0, shape.1).map(|_| ());
        assert_eq!(Kernel::<f64, 3>::open(block.bytes()).map(|_| ()), made.map_err(|_| Error::NotPrepared));
        made
    }
    let none = (Mollifier::None, 0.0);
    let refused = Err(Error::OutOfDomain);
    for length in [1e-196, 1e196] {
        assert_eq!(prepare(Law::Exponential { length }, 1.0, none), refused);
        assert_eq!(prepare(Law::Screened { k: 1.0 / length }, 1.0, none), refused);
        assert_eq!(prepare(Law::Exponential { length }, 1.0, (COMPACT, length)), refused);
        assert_eq!(prepare(power(1.5), 1.0, (COMPACT, length)), Ok(()));
    }
    assert_eq!(prepare(Law::Exponential { length: 1e150 }, 1.0, none), Ok(()));
    assert_eq!(prepare(Law::Screened { k: 5.9e-125 }, 1.0, none), refused);
    assert_eq!(prepare(power(9.0), 1.0, (COMPACT, 4.5e-58)), refused);
    // A kernel of numbers too small for double precision is refused, one that is zero is not.
    assert_eq!(prepare(Law::Exponential { length: 1.0 }, 1e-320, (COMPACT, 100.0)), refused);
    assert_eq!(prepare(Law::Exponential { length: 1.0 }, 0.0, none), Ok(()));
    assert_eq!(prepare(Law::Screened { k: 1.95e150 }, 1.0, none), refused);
    // Tables for very high powers do not fit into a block.
    assert_eq!(prepare(power(73.0), 1.0, (Mollifier::Compact { order: 4, exponent: 8 }, 1.0)), Err(Error::Unsupported));
    // Of two terms whose numbers are too small as well; terms that cancel are served.
    let both = |a: (f64, f64), b: (f64, f64), delta: f64| {
        let terms = [term(power(a.0), a.1), term(power(b.0), b.1)];
        let mut block = Aligned::new(Kernel::<f64, 2>::workspace_bytes(&terms, COMPACT).unwrap());
        Kernel::<f64, 2>::prepare(block.bytes(), &terms, COMPACT, delta).map(|_| ())
    };
    assert_eq!(both((6.0, 1.0), (8.0, 1.0), 1e-86), refused);
    assert_eq!(both((6.0, 1.0), (6.0, -1.0), 1.0), Ok(()));
    // A coefficient that the scalar cannot hold.
    let tiny = [term(Law::Newtonian, 1e-46)];
    let mut block = Aligned::new(Kernel::<f32, 3>::workspace_bytes(&tiny, COMPACT).unwrap());
    assert_eq!(Kernel::<f32, 3>::prepare(block.bytes(), &tiny, COMPACT, 1.0).map(|_| ()), refused);
}

/// Clouds within delta of one another whose delta is small beside the coordinates, in single precision at every level.
#[test]
fn tight_clouds_far_from_the_origin() {
    fn check<const D: usize>(shape: Mollifier, binary: i32) {
        let delta = 2.0_f32.powi(binary);
        let places =
            [[0.0; 3], [0.25, 0.0, 0.0], [0.0, 0.25, 0.0], [0.0, 0.0, 0.25], [0.25, 0.25, 0.0], [0.0, 0.25, 0.25]];
        let x = places.map(|p| std::array::from_fn(|k| 1.0 + p[k] as f32 * delta));
        let wide = x.map(|x: [f32; D]| x.map(f64::from));
        let newtonian = [term(Law::Newtonian, 1.0)];
        let want = with_kernel::<f64, D, _>(&newtonian, (shape, f64::from(delta)), |kernel| {
            sums_of(kernel, (&wide, &[1.0; 6], &wide), ALL, &Options::default(), Level::Portable)
        });
        // Each of six pairs is at most the field at delta's edge times a few.
        let size = want.gradient.iter().flatten().fold(0.0, |most: f64, g| most.max(g.abs()));
        for level in Level::available() {
            let got = with_kernel::<f32, D, _>(&newtonian, (shape, f64::from(delta)), |kernel| {
                sums_of(kernel, (&x, &[1.0; 6], &x), ALL, &Options::default(), level)
            });
            for (got, want) in got.gradient.iter().flatten().zip(want.gradient.iter().flatten()) {
                let error = (f64::from(*got) - want).abs();
                assert!(error <= 1e-4 * size, "{D}D {shape:?} delta 2^{binary} {level:?}: {got} {want}");
            }
        }
    }
    for (order, exponent) in [(2, 4), (4, 3), (6, 2), (8, 1)] {
        let shape = Mollifier::Compact { order, exponent };
        for binary in (-20..=-6).step_by(2) {
            check::<1>(shape, binary);
            check::<2>(shape, binary);
            check::<3>(shape, binary);
        }
    }
}

/// The workspace that a plan asks for is enough for any number of workers.
#[test]
fn workspaces_for_several_workers() {
    struct Several(usize);
    impl Executor for Several {
        fn workers(&self) -> usize {
            self.0
        }
        fn run(&self, tasks: usize, task: &(dyn Fn(usize) + Sync)) -> mollis_core::Result<()> {
            (0..tasks).for_each(|index| task(index % self.0));
            Ok(())
        }
    }
    fn check<T: Real, const D: usize>(terms: &[Term]) {
        let (x, m) = ([[T::ONE; D], [T::TWO; D], [T::HALF; D]], [T::ONE; 3]);
        with_kernel::<T, D, _>(terms, (COMPACT, 0.25), |kernel| {
            for workers in 1..9 {
                let plan = field::plan(kernel, 3, 3, ALL, &Options::default()).unwrap();
                let mut memory = Aligned::new(plan.workspace_bytes(workers).unwrap());
                let (mut potential, mut gradient, mut laplacian) = ([T::NAN; 3], [[T::NAN; D]; 3], [T::NAN; 3]);
                let outputs = Outputs {
                    potential: Some(&mut potential),
                    gradient: Some(&mut gradient),
                    laplacian: Some(&mut laplacian),
                    hessian: None,
                };
                let executor = Several(workers);
                let mut run = Run { executor: &executor, ..Run::default() };
                let sources = Sources::new(&x, &m);
                let done = field::evaluate(&plan, kernel, sources, &x, outputs, memory.bytes(), &mut run);
                assert_eq!(done, Ok(()), "{D}D, {} workers, {terms:?}", workers);
            }
        });
    }
    for p in [2.0, 4.0, 6.0, 8.0, 1.5] {
        for terms in [vec![term(power(p), 1.0)], vec![term(power(p), 1.0), term(Law::Newtonian, 1.0)]] {
            check::<f32, 1>(&terms);
            check::<f32, 2>(&terms);
            check::<f32, 3>(&terms);
            check::<f64, 1>(&terms);
            check::<f64, 2>(&terms);
            check::<f64, 3>(&terms);
        }
    }
}

/// Results beyond the range are infinite, and take nothing else with them.
#[test]
fn results_beyond_the_range_are_infinite() {
    let direct = Options { method: Some(Method::Direct), ..Options::default() };
    with_kernel::<f64, 2, _>(&[term(power(2.0), 1.0)], (COMPACT, 1.0), |kernel| {
        let got = sums_of(kernel, (&[[0.0; 2]], &[1.0], &[[1e170, 3e169]]), ALL, &direct, Level::best());
        assert_eq!((got.potential[0], got.gradient[0]), (f64::INFINITY, [1e170, 3e169]));
        assert_eq!(
            [kernel.value(1e305), kernel.gradient_factor(1e305), kernel.laplacian(1e305)],
            [f64::INFINITY, 1.0, 2.0]
        );
    });
    // The rotated gradient of a source on the first axis: the component that overflows is multiplied by zero.
    with_kernel::<f64, 2, _>(&[term(power(3.0), 1.0)], (Mollifier::None, 0.0), |kernel| {
        let options = Options { combination: (0.0, 0.5), ..direct };
        let got = sums_of(kernel, (&[[0.0; 2]], &[1e300], &[[1e10, 0.0]]), ALL, &options, Level::best());
        assert_eq!(got.gradient[0], [0.0, f64::INFINITY]);
    });
}

/// Powers beyond the range, times masses that bring them back: p log2 r is not rounded.
#[test]
fn fractional_powers_beyond_the_range() {
    let (r, mass) = (4e280_f64, 1e-300_f64);
    with_kernel::<f64, 3, _>(&[term(power(1.1), 1.0)], (Mollifier::None, 0.0), |kernel| {
        let got = sums_of(kernel, (&[[0.0; 3]], &[mass], &[[r, 0.0, 0.0]]), ALL, &Options::default(), Level::best());
        let want = (r / 1e140).powf(1.1) * (1e140_f64.powf(1.1) * mass) / 1.1;
        assert!((got.potential[0] / want - 1.0).abs() < 100.0 * f64::EPSILON, "{:e} {want:e}", got.potential[0]);
    });
}

/// A pair whose square is subnormal in the units of a far target.
#[test]
fn tables_beside_far_targets() {
    let (length, r) = (13.567_f32, 0.161_4_f32);
    with_kernel::<f32, 2, _>(
        &[term(Law::Exponential { length: f64::from(length) }, 1.0)],
        (Mollifier::None, 0.0),
        |kernel| {
            let gradient = |targets: &[[f32; 2]]| {
                sums_of(kernel, (&[[0.0; 2]], &[1.0], targets), ALL, &Options::default(), Level::best()).gradient[0][0]
            };
            let (alone, beside) = (gradient(&[[r, 0.0]]), gradient(&[[r, 0.0], [3e19, 0.0]]));
            assert!((beside / alone - 1.0).abs() < 100.0 * f32::EPSILON, "{alone} {beside}");
        },
    );
}

/// The Newtonian Laplacian by neighbours at any length.
#[test]
fn neighbours_at_any_length() {
    let newtonian = [term(Law::Newtonian, 1.0)];
    for (delta, mass) in [(1e-15, 1e-20), (1e15, 1e30), (1e-3, 1.0), (1e-12, 1e-38), (3e12, 3e38)] {
        let scene: &[(f64, f64)] = &[(0.0, mass), (0.5 * delta, mass), (0.1 * delta, 1e-3 * mass), (1e3 * delta, mass)];
        row_is_right::<3>(&newtonian, (COMPACT, delta), (scene, 0.2 * delta), Method::Neighbours);
        row_is_right::<2>(&newtonian, (COMPACT, delta), (scene, 0.2 * delta), Method::Neighbours);
        row_is_right::<1>(&newtonian, (COMPACT, delta), (scene, 0.2 * delta), Method::Neighbours);
    }
    // The whole range of coordinates, delta not normal or its inverse not, masses of every class.
    row_is_right::<2>(&newtonian, (COMPACT, 1e30), (&[(3e38, 1e30), (-3e38, 1e30)], 3e38), Method::Neighbours);
    row_is_right::<1>(&newtonian, (COMPACT, 3e38), (&[(1e38, 1e30), (-3e38, 1e20)], -1e38), Method::Neighbours);
    row_is_right::<1>(&newtonian, (COMPACT, 1e-41), (&[(3e-42, 1e-35), (1e30, 1e20)], -2e-42), Method::Neighbours);
    row_is_right::<1>(&newtonian, (COMPACT, 1e-20), (&[(3e-21, 1e-20), (1e30, 1e20)], -2e-21), Method::Neighbours);
    let scene: &[(f64, f64)] = &[(0.0, 1e-40), (3.0, 1e38), (-3.0, 1.0), (0.25, 1e-44)];
    row_is_right::<2>(&newtonian, (COMPACT, 1.0), (scene, 0.125), Method::Neighbours);
    // In double precision: psi is 5 / pi there, divided by delta^2.
    let five = |delta: f64, mass: f64, far: f64| {
        row::<f64, 2>(
            &newtonian,
            (COMPACT, delta),
            (&[(far, mass), (-far, mass)], far),
            (LAPLACIAN, Method::Neighbours),
        )[2]
    };
    for (delta, mass, far, want) in [
        (1e300, 1e300, 1e308, 5e-300),
        (1e-200, 1e-200, 1e-180, 5e200),
        (1e-200, 1e-100, 1e-180, 5e300),
        (1e200, 1e300, 1e308, 5e-100),
    ] {
        let want = want / std::f64::consts::PI;
        let got = five(delta, mass, far);
        assert!((got / want - 1.0).abs() < 1e-14, "{delta} {got} {want}");
    }
}

/// Moments and sorted sums whose coefficients, or near kernels, leave the range of the scalar where the results do not.
#[test]
fn coefficients_of_any_size() {
    let one = |p: f64| [term(power(p), 1.0)];
    let moments: &[(f64, f64, f64)] = &[
        (6.0, 1e-16, 1e34),
        (6.0, 1e-16, 6e24),
        (4.0, 4e-13, 1e20),
        (8.0, 1e-9, 1e35),
        (8.0, 1e4, 1e-20),
        (2.0, 1e-25, 1e20),
    ];
    for &(p, delta, mass) in moments {
        let scene: (&[(f64, f64)], f64) = (&[(1e-2 * delta, mass), (0.5 * delta, -0.2 * mass)], 0.0);
        row_is_right::<1>(&one(p), (COMPACT, delta), scene, Method::Moments);
        row_is_right::<2>(&one(p), (COMPACT, delta), scene, Method::Moments);
        row_is_right::<3>(&one(p), (COMPACT, delta), scene, Method::Moments);
    }
    let gaussian = Mollifier::Gaussian { order: 4 };
    let sorted: &[(&[f64], f64, f64)] = &[
        (&[5.0], 1.5e-9, 1e36),
        (&[5.0], 1.5e-9, 1.4e30),
        (&[3.0], 1e-14, 1e34),
        (&[1.0], 1e-39, 1e-30),
        (&[1.0], 1e-30, 1e9),
        (&[1.0, 3.0], 1e-10, 1e25),
        (&[1.0, 4.0], 1e-12, 1e30),
        (&[1.0, 9.0], 1e2, 1e-30),
        (&[1.0], 1e35, 1e-3),
    ];
    for &(powers, delta, mass) in sorted {
        let terms: Vec<Term> = powers.iter().map(|&p| term(power(p), 1.0)).collect();
        for mollifier in [COMPACT, gaussian, Mollifier::None] {
            for far in [0.5, 30.0] {
                let scene: (&[(f64, f64)], f64) = (
                    &[(1e-2 * delta, mass), (far * delta, 0.3 * mass), (-0.75 * delta, mass), (0.0, 0.1 * mass)],
                    0.25 * delta,
                );
                row_is_right::<1>(&terms, (mollifier, delta), scene, Method::Sorted);
            }
        }
    }
    // A mollifier far below the coordinates: its centre is seen where source and target are one.
    row_is_right::<1>(&one(1.0), (COMPACT, 1e-36), (&[(1e10, 1.0), (-1e10, 2.0)], 1e10), Method::Sorted);
    row_is_right::<1>(&one(1.0), (gaussian, 1e-36), (&[(1e10, 1.0), (-1e10, 2.0)], 1e10), Method::Sorted);
    // And in double precision: |x|^4/4 of mass 1e300 at 1e-75 under a mollifier of that length. K is delta^4 times that of delta = 1.
    let unit = row::<f64, 1>(&one(4.0), (COMPACT, 1.0), (&[(0.5, 1.0)], 0.0), (POTENTIAL, Method::Moments))[0];
    let got = row::<f64, 1>(&one(4.0), (COMPACT, 1e-75), (&[(0.5e-75, 1e300)], 0.0), (POTENTIAL, Method::Moments))[0];
    assert!((got / unit - 1.0).abs() < 1e-13, "{got} {unit}");
}

/// Kernels without a table, called for each pair: a Newtonian term beside powers, without a mollifier.
#[test]
fn newtonian_beside_powers_at_any_length() {
    for p in [2.0, 8.0, 2.5, 0.5, 1.0] {
        let terms = [term(Law::Newtonian, 1.0), term(power(p), 1.0)];
        for exponent in [-35, -30, -20, -18, -16, -14, -10, -4, 0, 2, 10] {
            let length = 10.0_f64.powi(exponent);
            for mass in [1e-3, 1e-16, 1e10] {
                let scene: (&[(f64, f64)], f64) =
                    (&[(0.0, mass), (length, mass), (2.0 * length, 1e-3 * mass)], 3.0 * length);
                row_is_right::<1>(&terms, (Mollifier::None, 0.0), scene, Method::Direct);
                row_is_right::<2>(&terms, (Mollifier::None, 0.0), scene, Method::Direct);
                row_is_right::<3>(&terms, (Mollifier::None, 0.0), scene, Method::Direct);
                // A pair much closer than the others.
                let scene: (&[(f64, f64)], f64) = (&[(1e-7 * length, mass), (length, 1e-9 * mass)], 0.0);
                row_is_right::<1>(&terms, (Mollifier::None, 0.0), scene, Method::Direct);
                row_is_right::<3>(&terms, (Mollifier::None, 0.0), scene, Method::Direct);
            }
        }
    }
    // In double precision, masses like the square of the lengths: the gradient is that of lengths and masses 1 without the power.
    let terms = [term(Law::Newtonian, 1.0), term(power(4.0), 1.0)];
    for exponent in [-40, -100, -120, -140, -160] {
        let length = 10.0_f64.powi(exponent);
        let mass = if exponent < -150 { 1e-300 } else { length * length };
        let scene: (&[(f64, f64)], f64) = (&[(0.0, mass), (length, mass)], 2.0 * length);
        let [u, g, _] = row::<f64, 3>(&terms, (Mollifier::None, 0.0), scene, (ALL, Method::Direct));
        let per = mass / length / length / (4.0 * std::f64::consts::PI);
        assert!(
            (g / (1.25 * per) - 1.0).abs() < 1e-13 && (u / length / (-1.5 * per) - 1.0).abs() < 1e-13,
            "{length} {u} {g}"
        );
    }
}

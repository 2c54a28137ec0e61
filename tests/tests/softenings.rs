//! Algebraic and Gaussian mollifiers against their definition, integrated with 60 digits by `data/softenings.py`: functions of a distance, and sums over pairs with one
//! delta and with a core radius for each source.

#![allow(clippy::excessive_precision, reason = "reference values keep the digits that they were computed with")]

use mollis_core::exec::Run;
use mollis_core::field::{self, Accumulation, Options, Outputs, Sources, Wanted};
use mollis_core::kernel::{Kernel, Law, Term};
use mollis_core::mollifier::{Blob, Mollifier, Quantity};
use mollis_core::simd::Level;
use mollis_core::{Error, Real};
use mollis_tests::Aligned;

const TABLE: &str = include_str!("../data/softenings.csv");

struct Row {
    mollifier: Mollifier,
    dimension: usize,
    delta: f64,
    r: f64,
    /// psi, psi'/r, phi, g, h, mass.
    want: [f64; 6],
}

fn rows() -> impl Iterator<Item = Row> {
    TABLE.lines().skip(1).map(|line| {
        let f: Vec<&str> = line.split(',').collect();
        let number = |k: usize| f[k].parse::<f64>().unwrap();
        let mollifier = match f[0] {
            "plummer" => Mollifier::Plummer,
            "algebraic" => Mollifier::Algebraic,
            "vatistas" => Mollifier::Vatistas,
            gaussian => Mollifier::Gaussian { order: gaussian.strip_prefix("gaussian").unwrap().parse().unwrap() },
        };
        Row {
            mollifier,
            dimension: f[1].parse().unwrap(),
            delta: number(2),
            r: number(3),
            want: [4, 5, 6, 7, 8, 9].map(number),
        }
    })
}

const QUANTITIES: [Quantity; 6] = [
    Quantity::Density,
    Quantity::DensitySlope,
    Quantity::Potential,
    Quantity::GradientFactor,
    Quantity::HessianFactor,
    Quantity::EnclosedMass,
];

/// The largest error of a row in units of u times its bound: 2 ulp, of the terms of a potential that is a logarithm, of the Gaussians of a sum (a factor of 4), and what
/// underflows.
fn scalar_error<T: Real, const D: usize>(row: &Row) -> f64 {
    let blob = Blob::<T, D>::new(row.mollifier, T::from_f64(row.delta)).unwrap();
    assert_eq!(T::from_f64(row.r).to_f64().to_bits(), row.r.to_bits());
    let u = 0.5 * T::EPSILON.to_f64();
    QUANTITIES.iter().zip(row.want).fold(0.0, |worst, (&quantity, want)| {
        let got = blob.evaluate(quantity, T::from_f64(row.r)).to_f64();
        let log =
            if D == 2 && quantity == Quantity::Potential { row.delta.ln().abs() / std::f64::consts::TAU } else { 0.0 };
        let bound = 2.0 * u * (want.abs() + u * log) + T::MIN_POSITIVE.to_f64().max(1e-45);
        worst.max((got - want).abs() / bound)
    })
}

fn with_dimension(row: &Row, f: [fn(&Row) -> f64; 3]) -> f64 {
    f[row.dimension - 1](row)
}

#[test]
fn functions_of_the_distance() {
    let mut count = 0;
    for row in rows() {
        let double = with_dimension(&row, [scalar_error::<f64, 1>, scalar_error::<f64, 2>, scalar_error::<f64, 3>]);
        assert!(double <= 1.0, "{:?} {}D delta {} r {:e}: {double}", row.mollifier, row.dimension, row.delta, row.r);
        if f64::from(row.r as f32) == row.r {
            let single = with_dimension(&row, [scalar_error::<f32, 1>, scalar_error::<f32, 2>, scalar_error::<f32, 3>]);
            assert!(single <= 1.0, "{:?} {}D r {:e} f32: {single}", row.mollifier, row.dimension, row.r);
        }
        count += 1;
    }
    assert_eq!(count, 13 * 13 * 3);
}

/// Beyond about 9 delta a Gaussian's field is Newtonian, and an algebraic one's is that to (delta / r)^2 or (delta / r)^4.
#[test]
fn moments_where_they_exist() {
    let moment = |mollifier, k| Blob::<f64, 3>::new(mollifier, 2.0).unwrap().moment(k).unwrap();
    let close = |got: f64, want: f64| assert!((got - want).abs() <= 1e-14 * want, "{got} {want}");
    assert_eq!(moment(Mollifier::Plummer, 0), 1.0);
    close(moment(Mollifier::Plummer, 1), 4.0);
    assert_eq!(moment(Mollifier::Plummer, 2), f64::INFINITY);
    // N / 2 delta^2
    close(moment(Mollifier::Algebraic, 2), 6.0);
    assert_eq!(moment(Mollifier::Algebraic, 4), f64::INFINITY);
    close(moment(Mollifier::Gaussian { order: 2 }, 2), 6.0);
    assert_eq!(moment(Mollifier::Gaussian { order: 4 }, 2), 0.0);
    assert_eq!((moment(Mollifier::Gaussian { order: 6 }, 2), moment(Mollifier::Gaussian { order: 6 }, 4)), (0.0, 0.0));
    let plane = Blob::<f64, 2>::new(Mollifier::Vatistas, 2.0).unwrap();
    // B(1, 1/2) / 2 delta^2
    close(plane.moment(2).unwrap(), 4.0);
    assert_eq!(plane.moment(4).unwrap(), f64::INFINITY);
}

#[test]
fn refusals() {
    let newtonian = [Term { law: Law::Newtonian, coefficient: 1.0 }];
    let power = [Term { law: Law::Power { exponent: 1.5 }, coefficient: 1.0 }];
    for mollifier in [Mollifier::Plummer, Mollifier::Algebraic, Mollifier::Vatistas] {
        assert!(Kernel::<f64, 2>::workspace_bytes(&newtonian, mollifier).is_ok());
        assert_eq!(Kernel::<f64, 2>::workspace_bytes(&power, mollifier), Err(Error::Unsupported));
        assert_eq!(Kernel::<f64, 2>::workspace_bytes_with(&newtonian, true, mollifier), Err(Error::Unsupported));
    }
    assert_eq!(Blob::<f64, 3>::new(Mollifier::Vatistas, 1.0).err(), Some(Error::Dimension));
    assert_eq!(Blob::<f64, 1>::new(Mollifier::Vatistas, 1.0).err(), Some(Error::Dimension));
    assert_eq!(Blob::<f64, 3>::new(Mollifier::Plummer, 0.0).err(), Some(Error::Delta));
    let plan = |kernel: &dyn field::Interaction<f64, 2>, radii| {
        let options = Options { radii, ..Options::default() };
        field::plan(kernel, 3, 3, Wanted { gradient: true, ..Wanted::default() }, &options)
    };
    let none = Blob::<f64, 2>::new(Mollifier::None, 0.0).unwrap();
    assert_eq!(plan(&none, true).err(), Some(Error::Unsupported));
    let blob = Blob::<f64, 2>::new(Mollifier::Plummer, 1.0).unwrap();
    let plan = plan(&blob, true).unwrap();
    let mut memory = Aligned::new(plan.workspace_bytes(1).unwrap());
    let x = [[0.0, 0.0], [1.0, 0.0], [0.0, 2.0]];
    let mut run = |sources: Sources<'_, f64, 2>| {
        let mut gradient = [[7.0; 2]; 3];
        let outputs = Outputs { gradient: Some(&mut gradient), ..Outputs::default() };
        let result = field::evaluate(&plan, &blob, sources, &x, outputs, memory.bytes(), &mut Run::default());
        assert!(result.is_ok() || gradient == [[7.0; 2]; 3]);
        result
    };
    let sources = Sources::new(&x, &[1.0; 3]);
    assert_eq!(run(sources), Err(Error::Unsupported));
    assert_eq!(run(sources.with_radii(&[1.0; 2])), Err(Error::LengthMismatch));
    assert_eq!(run(sources.with_radii(&[1.0, f64::NAN, 1.0])), Err(Error::NotFinite));
    assert_eq!(run(sources.with_radii(&[1.0, 0.0, 1.0])), Err(Error::Delta));
    assert_eq!(run(sources.with_radii(&[1.0, -1.0, 1.0])), Err(Error::Delta));
    assert_eq!(run(sources.with_radii(&[1.0, 2.0, 1.0])), Ok(()));
}

/// Deterministic numbers in [0, 1).
pub(crate) fn random(seed: u64) -> impl FnMut() -> f64 {
    let mut state = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1;
    move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64
    }
}

/// Sums of pairs by the accurate functions of the distance, in f64, and the sums of scales: the larger of K and the bare kernel's at (r^2 + delta^2)^(1/2), as it is
/// stated for algebraic mollifiers, is at most the sum of both here.
pub(crate) struct Twin {
    pub(crate) potential: [f64; 2],
    pub(crate) gradient: [[f64; 3]; 2],
    pub(crate) laplacian: [f64; 2],
}

pub(crate) fn twin<const D: usize>(mollifier: Mollifier, x: &[f64; D], sources: &[([f64; D], f64, f64)]) -> Twin {
    let mut sums = Twin { potential: [0.0; 2], gradient: [[0.0; 3]; 2], laplacian: [0.0; 2] };
    for &(y, m, radius) in sources {
        let blob = Blob::<f64, D>::new(mollifier, radius).unwrap();
        let d: [f64; D] = std::array::from_fn(|k| x[k] - y[k]);
        let (k, g, b) = (blob.potential_at(&d), blob.gradient_at(&d), blob.density_at(&d));
        let log = if D == 2 { 1.0 / std::f64::consts::TAU + radius.ln().abs() } else { 0.0 };
        sums.potential[0] += m * k;
        sums.potential[1] += m.abs() * (k.abs() + log);
        for (k, g) in g.into_iter().enumerate() {
            sums.gradient[0][k] += m * g;
            sums.gradient[1][k] += m.abs() * g.abs();
        }
        sums.laplacian[0] += m * b;
        let most = if mollifier.is_compact() { blob.density(0.0).abs() } else { 0.0 };
        sums.laplacian[1] += m.abs() * (b.abs() + most);
    }
    sums
}

pub(crate) fn mollifiers(dimension: usize) -> Vec<Mollifier> {
    let mut all = vec![
        Mollifier::Compact { order: 2, exponent: 4 },
        Mollifier::Compact { order: 4, exponent: 2 },
        Mollifier::Richardson { order: 6, exponent: 4 },
        Mollifier::Gaussian { order: 2 },
        Mollifier::Gaussian { order: 4 },
        Mollifier::Plummer,
        Mollifier::Algebraic,
    ];
    if dimension == 2 {
        all.push(Mollifier::Vatistas);
    }
    all
}

/// What a scene's core radii are.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Radii {
    One,
    /// Within a factor of two.
    Alike,
    /// From far below to far above the spacing, some beyond the range of lanes.
    Wild,
}

fn sums_agree<T: Real, const D: usize>() {
    let u = 0.5 * T::EPSILON.to_f64();
    for mollifier in mollifiers(D) {
        for (seed, n) in [0, 1, 7, 33, 257].into_iter().enumerate() {
            for radii in [Radii::One, Radii::Alike, Radii::Wild] {
                let mut next = random(seed as u64 + 31 * n as u64);
                let narrow = |x: f64| T::from_f64(x);
                let x: Vec<[T; D]> = (0..n).map(|_| std::array::from_fn(|_| narrow(2.0 * next() - 1.0))).collect();
                let mass: Vec<T> = (0..n).map(|_| narrow(next() - 0.3)).collect();
                let delta = narrow(0.25);
                let radius: Vec<T> = (0..n)
                    .map(|_| match radii {
                        Radii::One => delta,
                        Radii::Alike => narrow(0.1 + 0.1 * next()),
                        Radii::Wild => narrow(10.0_f64.powf(14.0 * next() - 12.0)),
                    })
                    .collect();
                // Targets: the sources, and some that are close to them.
                let mut targets: Vec<[T; D]> = x.iter().take(36).copied().collect();
                targets.extend(x.iter().take(9).map(|x| x.map(|c| c + narrow(1e-9) * c)));
                let newtonian = [Term { law: Law::Newtonian, coefficient: -1.5 }];
                let mut block = Aligned::new(Kernel::<T, D>::workspace_bytes(&newtonian, mollifier).unwrap());
                let kernel = Kernel::<T, D>::prepare(block.bytes(), &newtonian, mollifier, delta).unwrap();
                let each = radii != Radii::One;
                let options = Options { radii: each, accumulation: Accumulation::Compensated, ..Options::default() };
                let wanted = Wanted { potential: true, gradient: true, laplacian: true, hessian: false };
                let plan = field::plan(&kernel, n, targets.len(), wanted, &options).unwrap();
                let mut memory = Aligned::new(plan.workspace_bytes(1).unwrap());
                let wide: Vec<([f64; D], f64, f64)> =
                    (0..n).map(|j| (x[j].map(T::to_f64), -1.5 * mass[j].to_f64(), radius[j].to_f64())).collect();
                // c of the header: tables 128, in double, and of Laplacians 1000.
                let is_table = matches!(mollifier, Mollifier::Gaussian { .. } | Mollifier::Richardson { .. });
                let c = if is_table && u < 1e-10 { 1000.0 } else { 64.0 };
                let wants: Vec<Twin> =
                    targets.iter().map(|target| twin(mollifier, &target.map(T::to_f64), &wide)).collect();
                for level in Level::available() {
                    let (mut potential, mut gradient, mut laplacian) =
                        (vec![T::NAN; targets.len()], vec![[T::NAN; D]; targets.len()], vec![T::NAN; targets.len()]);
                    let outputs = Outputs {
                        potential: Some(&mut potential),
                        gradient: Some(&mut gradient),
                        laplacian: Some(&mut laplacian),
                        hessian: None,
                    };
                    let sources = Sources::new(&x, &mass);
                    let sources = if each { sources.with_radii(&radius) } else { sources };
                    let mut run = Run { level, ..Run::default() };
                    field::evaluate(&plan, &kernel, sources, &targets, outputs, memory.bytes(), &mut run).unwrap();
                    for (i, want) in wants.iter().enumerate() {
                        let what = format!("{mollifier:?} {D}D n {n} {radii:?} {level:?} target {i}");
                        let check = |got: T, [want, scale]: [f64; 2], which: &str| {
                            let error = (got.to_f64() - want).abs();
                            let bound = c * u * scale + T::MIN_POSITIVE.to_f64();
                            assert!(error <= bound, "{what}: {which} {got:?} {want:e}, {} u S", error / (u * scale));
                        };
                        check(potential[i], want.potential, "potential");
                        // Components of a difference are rounded, so the scale of each is the vector's.
                        let size = want.gradient[1].iter().fold(0.0, |sum: f64, x| sum + x);
                        for (&got, &want) in gradient[i].iter().zip(&want.gradient[0]) {
                            check(got, [want, size], "gradient");
                        }
                        if !is_table {
                            check(laplacian[i], want.laplacian, "laplacian");
                        }
                    }
                }
            }
        }
    }
}

#[test]
fn sums_1d() {
    sums_agree::<f64, 1>();
    sums_agree::<f32, 1>();
}

#[test]
fn sums_2d() {
    sums_agree::<f64, 2>();
    sums_agree::<f32, 2>();
}

#[test]
fn sums_3d() {
    sums_agree::<f64, 3>();
    sums_agree::<f32, 3>();
}

/// Velocities of vortex elements in space, with one delta and a core radius each: three scalar gradients, component by component, make the same. Every level, sizes around
/// blocks, elements at one place, zero ones, and radii beyond the range of lanes.
fn biot_and_savart<T: Real>() {
    let u = 0.5 * T::EPSILON.to_f64();
    let narrow = T::from_f64;
    for mollifier in mollifiers(3).into_iter().chain([Mollifier::None]) {
        for (n, each) in [(0, false), (1, false), (5, true), (40, false), (40, true), (300, true)] {
            if each && mollifier == Mollifier::None {
                continue;
            }
            let mut next = random(n as u64 + 7);
            let mut x: Vec<[T; 3]> = (0..n).map(|_| std::array::from_fn(|_| narrow(2.0 * next() - 1.0))).collect();
            let mut strength: Vec<[T; 3]> =
                (0..n).map(|_| std::array::from_fn(|_| narrow(1e3 * (next() - 0.4)))).collect();
            if n > 4 {
                (x[3], strength[2]) = (x[1], [T::ZERO; 3]);
            }
            let radius: Vec<T> = (0..n).map(|k| narrow(if k % 9 == 8 { 1e-11 } else { 0.1 + 0.3 * next() })).collect();
            let newtonian = [Term { law: Law::Newtonian, coefficient: 0.75 }];
            let mut block = Aligned::new(Kernel::<T, 3>::workspace_bytes(&newtonian, mollifier).unwrap());
            let delta = narrow(0.25);
            let kernel = Kernel::<T, 3>::prepare(block.bytes(), &newtonian, mollifier, delta).unwrap();
            let options = Options { radii: each, strengths: true, ..Options::default() };
            let wanted = Wanted { gradient: true, ..Wanted::default() };
            let plan = field::plan(&kernel, n, n, wanted, &options).unwrap();
            let mut memory = Aligned::new(plan.workspace_bytes(1).unwrap());
            let sources = Sources::vortices(&x, &strength);
            let sources = if each { sources.with_radii(&radius) } else { sources };
            for level in Level::available() {
                let mut got = vec![[T::NAN; 3]; n];
                let outputs = Outputs { gradient: Some(&mut got), ..Outputs::default() };
                let mut run = Run { level, ..Run::default() };
                field::evaluate(&plan, &kernel, sources, &x, outputs, memory.bytes(), &mut run).unwrap();
                for (i, got) in got.iter().enumerate() {
                    let (mut want, mut size) = ([0.0; 3], 0.0);
                    for j in 0..n {
                        let length = if each { radius[j] } else { delta };
                        let blob = Blob::<f64, 3>::new(mollifier, length.to_f64()).unwrap();
                        let d: [f64; 3] = std::array::from_fn(|k| x[i][k].to_f64() - x[j][k].to_f64());
                        let (g, s) = (blob.gradient_at(&d).map(|g| 0.75 * g), strength[j].map(T::to_f64));
                        let turned = [g[1] * s[2] - g[2] * s[1], g[2] * s[0] - g[0] * s[2], g[0] * s[1] - g[1] * s[0]];
                        want.iter_mut().zip(turned).for_each(|(sum, v)| *sum += v);
                        let norm = |v: [f64; 3]| v.iter().map(|v| v * v).sum::<f64>().sqrt();
                        size += norm(g) * norm(s);
                    }
                    let c = if matches!(mollifier, Mollifier::Gaussian { .. }) && u < 1e-10 { 300.0 } else { 64.0 };
                    for (&got, want) in got.iter().zip(want) {
                        let error = (got.to_f64() - want).abs();
                        let what = format!("{mollifier:?} n {n} each {each} {level:?} target {i}");
                        assert!(error <= c * u * size, "{what}: {got:?} {want:e}, {} u S", error / (u * size));
                    }
                }
            }
        }
    }
}

#[test]
fn velocities_of_vortex_elements() {
    biot_and_savart::<f64>();
    biot_and_savart::<f32>();
}

#[test]
fn vector_strengths_are_for_gradients_in_space() {
    let options = Options { strengths: true, ..Options::default() };
    let gradient = Wanted { gradient: true, ..Wanted::default() };
    let space = Blob::<f64, 3>::new(Mollifier::Plummer, 1.0).unwrap();
    let plane = Blob::<f64, 2>::new(Mollifier::Plummer, 1.0).unwrap();
    assert_eq!(field::plan(&plane, 2, 2, gradient, &options).err(), Some(Error::Unsupported));
    let all = Wanted { potential: true, ..gradient };
    assert_eq!(field::plan(&space, 2, 2, all, &options).err(), Some(Error::Unsupported));
    let plan = field::plan(&space, 2, 2, gradient, &options).unwrap();
    let mut memory = Aligned::new(plan.workspace_bytes(1).unwrap());
    let x = [[0.0; 3], [1.0; 3]];
    let mut run = |kernel: &dyn field::Interaction<f64, 3>, sources: Sources<'_, f64, 3>| {
        let mut out = [[7.0; 3]; 2];
        let outputs = Outputs { gradient: Some(&mut out), ..Outputs::default() };
        let result = field::evaluate(&plan, kernel, sources, &x, outputs, memory.bytes(), &mut Run::default());
        assert!(result.is_ok() || out == [[7.0; 3]; 2]);
        result
    };
    assert_eq!(run(&space, Sources::vortices(&x, &x)), Ok(()));
    assert_eq!(run(&space, Sources::vortices(&x, &x[..1])), Err(Error::LengthMismatch));
    assert_eq!(run(&space, Sources::new(&x, &[1.0; 2])), Err(Error::Unsupported));
    assert_eq!(run(&space, Sources::vortices(&x, &[[0.0; 3], [f64::NAN; 3]])), Err(Error::NotFinite));
    // A plan for one kernel does not serve another that has no vectors or radii.
    let power = [Term { law: Law::Power { exponent: 1.5 }, coefficient: 1.0 }];
    let mut block = Aligned::new(Kernel::<f64, 3>::workspace_bytes(&power, Mollifier::None).unwrap());
    let other = Kernel::<f64, 3>::prepare(block.bytes(), &power, Mollifier::None, 1.0).unwrap();
    assert_eq!(run(&other, Sources::vortices(&x, &x)), Err(Error::Unsupported));
}

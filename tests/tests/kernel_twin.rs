//! Kernels with arbitrary parameters, mollifiers and lengths against the convolution itself.

use mollis_core::kernel::{Kernel, Law, Term};
use mollis_core::mollifier::Mollifier;
use mollis_reference::kernel::mollified;
use mollis_reference::mollifier::Compact;
use mollis_tests::Aligned;

/// Numbers in [0, 1), the same sequence every time (splitmix).
fn numbers() -> impl FnMut() -> f64 {
    let mut state = 17_u64;
    move || {
        state = state.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = state;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }
}

/// K0(z) and K1(z) as integrals of e^(-z cosh t), by the trapezium rule, which converges geometrically here, up to where
/// z cosh t > 40.
fn bessel(z: f64) -> [f64; 2] {
    let h = 0.05;
    let terms = ((80.0 / z + 2.0).ln() / h).ceil() as i32;
    let term = |k: i32| (-z * (h * f64::from(k)).cosh()).exp();
    let sum = |factor: &dyn Fn(f64) -> f64| {
        h * (0.5 * term(0) * factor(0.0) + (1..=terms).map(|k| term(k) * factor(h * f64::from(k))).sum::<f64>())
    };
    [sum(&|_| 1.0), sum(&f64::cosh)]
}

/// K and K' in the form of the papers.
fn bare(dimension: u32, law: Law, s: f64) -> [f64; 2] {
    use std::f64::consts::PI;
    match law {
        Law::Power { exponent: 0.0 } => [s.ln(), 1.0 / s],
        Law::Power { exponent: p } => [s.powf(p) / p, s.powf(p - 1.0)],
        Law::Exponential { length: l } => [(-s / l).exp(), -(-s / l).exp() / l],
        Law::Screened { k } => match dimension {
            1 => [-(-k * s).exp() / (2.0 * k), 0.5 * (-k * s).exp()],
            2 => {
                let [k0, k1] = bessel(k * s);
                [-k0 / (2.0 * PI), k * k1 / (2.0 * PI)]
            }
            _ => {
                let e = (-k * s).exp() / (4.0 * PI * s);
                [-e, e * (k + 1.0 / s)]
            }
        },
        Law::Newtonian => match dimension {
            1 => [0.5 * s, 0.5],
            2 => [s.ln() / (2.0 * PI), 1.0 / (2.0 * PI * s)],
            _ => [-1.0 / (4.0 * PI * s), 1.0 / (4.0 * PI * s * s)],
        },
    }
}

fn check<const D: usize>(laws: &[Law], next: &mut impl FnMut() -> f64) {
    for &law in laws {
        let (order, exponent) = (2 + 2 * (next() * 4.0) as u32, 2 + (next() * 7.0) as u32);
        let delta = 0.1 + 1.5 * next();
        let (mollifier, terms) = (Mollifier::Compact { order, exponent }, [Term { law, coefficient: 1.0 }]);
        let bytes = Kernel::<f64, D>::workspace_bytes(&terms, mollifier).unwrap();
        let mut memory = Aligned::new(bytes);
        let kernel = match Kernel::<f64, D>::prepare(memory.bytes(), &terms, mollifier, delta) {
            Ok(kernel) => kernel,
            Err(error) => panic!("{D} {law:?} {mollifier:?} delta {delta}: {error:?}"),
        };
        let psi = Compact::new(D as u32, order, exponent);
        let scale = bare(D as u32, law, delta);
        for place in [0.3, 0.8, 1.05, 2.5] {
            let r = delta * (place + 0.1 * next());
            let [value, slope] = mollified(D as u32, &psi, delta, |s| bare(D as u32, law, s), r);
            for (got, want, scale) in
                [(kernel.value(r), value, scale[0]), (r * kernel.gradient_factor(r), slope, scale[1])]
            {
                // The quadrature of the reference implementation: 600 nodes on each smooth piece. Singularities are at the ends of the pieces.
                let error = (got - want).abs() / want.abs().max(scale.abs());
                assert!(error < 1e-7, "{D} {law:?} {mollifier:?} delta {delta} r {r}: {got} {want} {error:e}");
            }
        }
    }
}

#[test]
fn kernels_are_the_convolutions_they_stand_for() {
    let mut next = numbers();
    let power = |exponent| Law::Power { exponent };
    let others = [
        Law::Newtonian,
        Law::Exponential { length: 0.4 },
        Law::Exponential { length: 3.0 },
        Law::Screened { k: 0.2 },
        Law::Screened { k: 4.5 },
    ];
    check::<1>(&[power(0.0), power(0.4), power(1.7), power(3.0), power(6.0)], &mut next);
    check::<1>(&others, &mut next);
    check::<2>(&[power(-0.5), power(0.0), power(1.3), power(2.0), power(5.0), power(6.5)], &mut next);
    check::<2>(&others, &mut next);
    check::<3>(&[power(-1.5), power(-1.0), power(0.0), power(0.9), power(3.0), power(4.0)], &mut next);
    check::<3>(&others, &mut next);
}

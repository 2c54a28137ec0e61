//! Every row of the kernel tables (25 digits, from closed forms in ball arithmetic), computed through the public interface.

use mollis_core::Real;
use mollis_core::kernel::{Kernel, Law, Term};
use mollis_core::mollifier::Mollifier;

const TABLES: [&str; 2] = [include_str!("../data/kernels.csv"), include_str!("../data/kernels3.csv")];

fn one(law: Law) -> Vec<Term> {
    vec![Term { law, coefficient: 1.0 }]
}

fn terms(name: &str) -> Vec<Term> {
    if name == "morse" {
        return vec![
            Term { law: Law::Exponential { length: 1.0 }, coefficient: 1.0 },
            Term { law: Law::Exponential { length: 2.0 }, coefficient: -2.0 },
        ];
    }
    if name == "log" {
        return one(Law::Power { exponent: 0.0 });
    }
    if let Some(k) = name.strip_prefix("k0_").or_else(|| name.strip_prefix("screened_")) {
        return one(Law::Screened { k: k.parse().unwrap() });
    }
    one(Law::Power { exponent: name.strip_prefix('p').unwrap().parse().unwrap() })
}

fn mollifier(name: &str) -> Mollifier {
    match name {
        "poly2_M4" => Mollifier::Compact { order: 2, exponent: 4 },
        "poly4_M4" => Mollifier::Compact { order: 4, exponent: 4 },
        "poly4_M9" => Mollifier::Compact { order: 4, exponent: 9 },
        "gauss4" => Mollifier::Gaussian { order: 4 },
        _ => panic!("unknown mollifier {name}"),
    }
}

/// A kernel in a buffer of exactly the stated size.
fn with_kernel<const D: usize, R>(
    terms: &[Term],
    m: Mollifier,
    delta: f64,
    f: impl FnOnce(&Kernel<'_, f64, D>) -> R,
) -> R {
    with_scalar::<f64, D, R>(terms, m, delta, f)
}

fn with_scalar<T: Real, const D: usize, R>(
    terms: &[Term],
    m: Mollifier,
    delta: T,
    f: impl FnOnce(&Kernel<'_, T, D>) -> R,
) -> R {
    let bytes = Kernel::<T, D>::workspace_bytes(terms, m).unwrap();
    let mut memory = vec![0xA5_u8; bytes + 64];
    let start = memory.as_ptr().align_offset(64);
    let kernel = Kernel::<T, D>::prepare(&mut memory[start..start + bytes], terms, m, delta).unwrap();
    f(&kernel)
}

struct Row {
    r: f64,
    want: [f64; 3],
}

/// Closed forms have errors of at most 8 ulp: |x|^4/4, |x|^3/3 in 1D under compact mollifiers, K0 outside the support.
fn is_closed(dimension: usize, kernel: &str, psi: &str, outside: bool) -> bool {
    kernel == "p4"
        || (dimension == 1 && kernel == "p3" && psi != "gauss4")
        || (kernel.starts_with("k0") && outside && psi != "gauss4")
}

/// The largest errors relative to the larger of |value| and the kernel's scale at delta, in units of the tolerance. The tolerance is 1e-13, a
/// hundred times what quadrature (sums of about 2000 terms of either sign) and Clenshaw's recurrence (30 steps) lose for one
/// term, because a Morse potential at delta = 0.1 is 20 times smaller than the gradient factors of its two terms. For closed forms it
/// is 8 ulp.
fn check<const D: usize>(kernel: &str, psi: &str, delta: f64, rows: &[Row]) -> [f64; 3] {
    let bare: [f64; 3] = with_kernel::<D, _>(&terms(kernel), Mollifier::None, delta, |k| k.at(delta));
    with_kernel::<D, _>(&terms(kernel), mollifier(psi), delta, |k| {
        let mut worst = [0.0_f64; 3];
        for row in rows {
            for (n, (got, want)) in k.at(row.r).into_iter().zip(row.want).enumerate() {
                // the kernel's own scale at delta; if its Laplacian vanishes there, that of its gradient
                let scale = bare[n].abs().max(if n == 2 { bare[1].abs() } else { 0.0 });
                let closed = is_closed(D, kernel, psi, row.r >= delta);
                let tolerance = if closed { 8.0 * f64::EPSILON } else { 1e-13 };
                let error = (got - want).abs() / want.abs().max(scale) / tolerance;
                if std::env::var_os("MOLLIS_SHOW").is_some() && error > 1.0 {
                    println!("  {D} {kernel} {psi} {delta} r={} fn {n}: {got:e} {want:e} {error:e}", row.r);
                }
                worst[n] = worst[n].max(if error.is_nan() { f64::INFINITY } else { error });
            }
        }
        if std::env::var_os("MOLLIS_SHOW").is_some() {
            println!("{D} {kernel:10} {psi:9} {delta:5} {worst:?} fit {:.1e}", k.fit_error());
        }
        worst
    })
}

type Key = (String, String, String, f64);

/// The rows of all tables, by dimension, kernel, mollifier and delta.
fn groups() -> Vec<(Key, Vec<Row>)> {
    let mut groups: Vec<(Key, Vec<Row>)> = Vec::new();
    let mut count = 0;
    for table in TABLES {
        for line in table.lines().filter(|l| !l.starts_with('#') && !l.starts_with("dim")) {
            let f: Vec<&str> = line.split(',').collect();
            let delta: f64 = f[3].parse().unwrap();
            let key = (f[0].to_string(), f[1].to_string(), f[2].to_string(), delta);
            let number = |k: usize| f[k].parse::<f64>().unwrap();
            let row = Row { r: number(4), want: [number(5), number(6), number(7)] };
            match groups.iter_mut().find(|(k, _)| *k == key) {
                Some((_, rows)) => rows.push(row),
                None => groups.push((key, vec![row])),
            }
            count += 1;
        }
    }
    assert_eq!(count, 624 + 1738, "no row is skipped");
    groups
}

#[test]
fn every_row_of_the_tables() {
    let groups = groups();
    let mut failed = 0;
    for ((dimension, kernel, psi, delta), rows) in &groups {
        let worst = match dimension.as_str() {
            "1" => check::<1>(kernel, psi, *delta, rows),
            "2" => check::<2>(kernel, psi, *delta, rows),
            _ => check::<3>(kernel, psi, *delta, rows),
        };
        if worst.iter().any(|&w| w > 1.0) {
            println!("FAILED {dimension} {kernel} {psi} {delta}: {worst:?}");
            failed += 1;
        }
    }
    assert_eq!(failed, 0);
}

/// Single precision against double precision for every row, at the same delta and r, which single precision holds exactly. The error is at
/// most 90 u of the larger of |value| and the sum over the terms of the larger of the bare term's size at delta and the mollified one's at
/// 0: three roundings in each of some 30 steps of Clenshaw's recurrence, relative to the largest value of its function.
fn single<const D: usize>(kernel: &str, psi: &str, delta: f64, rows: &[Row]) -> [f64; 3] {
    let (terms, psi, delta) = (terms(kernel), mollifier(psi), delta as f32);
    let mut scale = [0.0; 3];
    for term in &terms {
        let bare: [f64; 3] = with_kernel::<D, _>(&[*term], Mollifier::None, delta.into(), |k| k.at(delta.into()));
        let central = with_kernel::<D, _>(&[*term], psi, delta.into(), |k| k.at(0.0));
        for ((scale, bare), central) in scale.iter_mut().zip(bare).zip(central) {
            *scale += bare.abs().max(central.abs());
        }
    }
    with_kernel::<D, _>(&terms, psi, delta.into(), |double| {
        with_scalar::<f32, D, _>(&terms, psi, delta, |single| {
            let mut worst = [0.0_f64; 3];
            for r in rows.iter().map(|row| row.r as f32) {
                let values = single.at(r).into_iter().zip(double.at(r.into())).zip(scale);
                for (worst, ((got, want), scale)) in worst.iter_mut().zip(values) {
                    let error = (f64::from(got) - want).abs() / want.abs().max(scale);
                    *worst = worst.max(if error.is_nan() { f64::INFINITY } else { error });
                }
            }
            worst
        })
    })
}

#[test]
fn every_row_in_single_precision() {
    let mut failed = 0;
    for ((dimension, kernel, psi, delta), rows) in &groups() {
        let worst = match dimension.as_str() {
            "1" => single::<1>(kernel, psi, *delta, rows),
            "2" => single::<2>(kernel, psi, *delta, rows),
            _ => single::<3>(kernel, psi, *delta, rows),
        };
        if worst.iter().any(|&w| w > 90.0 * f64::from(f32::EPSILON / 2.0)) {
            println!("FAILED {dimension} {kernel} {psi} {delta}: {worst:?}");
            failed += 1;
        }
    }
    assert_eq!(failed, 0);
}

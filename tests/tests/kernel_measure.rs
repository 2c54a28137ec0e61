//! Temporary measuring.
use mollis_core::Real;
use mollis_core::kernel::{Kernel, Law, Term};
use mollis_core::mollifier::Mollifier;
use mollis_tests::Aligned;

const TABLE: &str = include_str!("../data/kernels_random.csv");

fn with<T: Real, const D: usize, R>(
    law: Law,
    m: Mollifier,
    delta: f64,
    f: impl FnOnce(&Kernel<'_, T, D>) -> R,
) -> Option<R> {
    let terms = [Term { law, coefficient: 1.0 }];
    let bytes = Kernel::<T, D>::workspace_bytes(&terms, m).unwrap();
    let mut memory = Aligned::new(bytes);
    match Kernel::<T, D>::prepare(memory.bytes(), &terms, m, T::from_f64(delta)) {
        Ok(k) => Some(f(&k)),
        Err(e) => {
            println!("REFUSED {law:?} {D} {m:?} {delta} {e:?}");
            None
        }
    }
}

fn measure<const D: usize>(law: Law, m: Mollifier, delta: f64, r: f64) -> ([f64; 3], [f64; 3], [f64; 3], f64) {
    let bare = with::<f64, D, _>(law, Mollifier::None, delta, |k| k.at(delta)).unwrap();
    let (double, fit) = with::<f64, D, _>(law, m, delta, |k| (k.at(r), k.fit_error())).unwrap_or(([f64::NAN; 3], 9.0));
    let single = with::<f32, D, _>(law, m, delta, |k| k.at(r as f32)).unwrap_or([f32::NAN; 3]).map(f64::from);
    (bare, double, single, fit)
}

#[test]
fn measure_all() {
    let table = std::env::var("TABLE").map_or(TABLE.to_string(), |p| std::fs::read_to_string(p).unwrap());
    for line in table.lines().skip(1) {
        let f: Vec<&str> = line.split(',').collect();
        let n = |k: usize| f[k].parse::<f64>().unwrap();
        let law = match f[1] {
            "power" => Law::Power { exponent: n(2) },
            "exponential" => Law::Exponential { length: n(2) },
            _ => Law::Screened { k: n(2) },
        };
        let m = if f[3] == "compact" {
            Mollifier::Compact { order: f[4].parse().unwrap(), exponent: f[5].parse().unwrap() }
        } else {
            Mollifier::Gaussian { order: f[4].parse().unwrap() }
        };
        let start = std::time::Instant::now();
        let (bare, double, single, fit) = match f[0] {
            "1" => measure::<1>(law, m, n(6), n(7)),
            "2" => measure::<2>(law, m, n(6), n(7)),
            _ => measure::<3>(law, m, n(6), n(7)),
        };
        println!("ROW {line};{bare:?};{double:?};{single:?};{fit:e};{:e}", start.elapsed().as_secs_f64());
    }
}

//! The operations of each level, lane by lane, against scalar arithmetic.

use mollis_core::Real;
use mollis_core::simd::{Isa, Job, MAX_LANES, PANEL_BITS, ROW, ROWS, Rows};

use super::{Random, levels};

impl Random {
    /// Of either sign, with an exponent up to `range` in magnitude: every fifth a power of two, every fifth next to one.
    fn spread(&mut self, kind: usize, range: i32) -> f64 {
        let exponent = (self.bits() % (2 * range as u64 + 1)) as i32 - range;
        let significand = match kind % 5 {
            0 => 1.0,
            1 => 1.0 + f64::from(f32::EPSILON) * (self.bits() % 3) as f64,
            _ => 1.0 + (self.bits() >> 41) as f64 / f64::from(1_u32 << 23),
        };
        let sign = if self.bits() & 1 == 0 { 1.0 } else { -1.0 };
        sign * significand * 2.0_f64.powi(exponent)
    }
}

/// All operations of a level on three vectors.
struct Operations<'a, T: Real> {
    lanes: [[T; MAX_LANES]; 3],
    table: &'a Rows<T>,
}

struct Answers<T> {
    lanes: usize,
    bits: u32,
    any_below: bool,
    all_below: bool,
    /// In the order of [`Operations::run`].
    rows: Vec<[T; MAX_LANES]>,
    least: [T; MAX_LANES],
    looked_up: Vec<[T; MAX_LANES]>,
}

impl<T: Real> Job<T> for Operations<'_, T> {
    type Out = Answers<T>;

    #[inline(always)]
    fn run<I: Isa<T>>(self, isa: I) -> Answers<T> {
        let [a, b, c] = [isa.load(&self.lanes[0]), isa.load(&self.lanes[1]), isa.load(&self.lanes[2])];
        let less = isa.lt(a, b);
        let [x, y, z] = [isa.abs(a), isa.abs(b), isa.abs(c)];
        let roots = isa.inverse_roots([x, y, z]);
        let over = isa.over_cubed_roots(c, [x, y, z]);
        let quotients = isa.quotients(c, [a, b, x]);
        let (fraction, exponent) = isa.split(x);
        let (places, least) = isa.rows(x);
        let rows = [
            isa.add(a, b),
            isa.sub(a, b),
            isa.mul(a, b),
            isa.div(a, b),
            isa.sqrt(x),
            isa.abs(a),
            isa.select(less, a, b),
            isa.splat(self.lanes[0][0]),
            exponent,
            fraction,
            isa.mul_add(a, b, c),
            isa.neg_mul_add(a, b, c),
            roots[0],
            roots[1],
            roots[2],
            over[0],
            over[1],
            over[2],
            quotients[0],
            quotients[1],
            quotients[2],
        ];
        Answers {
            lanes: I::LANES,
            bits: isa.bits(less),
            any_below: isa.any_below(&[a, b], c),
            all_below: isa.all_below(&[a, b], c),
            rows: rows.iter().map(|&v| isa.store(v)).collect(),
            least: isa.store(least),
            looked_up: isa.look_up(self.table, places).iter().map(|&v| isa.store(v)).collect(),
        }
    }
}

/// Where the number's row is, by its definition: exponent and leading bits, modulo the number of rows.
fn row_of<T: Real>(x: T) -> (usize, T) {
    let cut = T::DIGITS - 1 - PANEL_BITS;
    let place = x.bits() >> cut;
    (place as usize % ROWS, T::from_bits(place << cut))
}

/// `cases` times three vectors of numbers up to 2^`range`.
fn operations<T: Real>(cases: usize, range: i32) {
    let u = T::EPSILON.to_f64() / 2.0;
    let table: Vec<[T; ROW]> = (0..ROWS).map(|row| std::array::from_fn(|n| T::from_usize(row * ROW + n))).collect();
    let table: &Rows<T> = table.as_slice().try_into().unwrap();
    for level in levels() {
        let mut random = Random::new(7);
        for case in 0..cases {
            let range = if case % 2 == 0 { 3 } else { range };
            let mut lanes = [[T::ZERO; MAX_LANES]; 3];
            lanes.as_flattened_mut().iter_mut().for_each(|x| *x = T::from_f64(random.spread(case, range)));
            if case % 3 == 0 {
                lanes[1][case % MAX_LANES] = lanes[0][case % MAX_LANES];
            }
            if case % 4 == 0 {
                // All below, or all but one.
                lanes[2] = [T::from_f64(2.0_f64.powi(range + 3)); MAX_LANES];
                if case % 8 == 0 {
                    lanes[2][(case / 8) % MAX_LANES] = -lanes[2][0];
                }
            }
            let answers = level.run(Operations { lanes, table });
            let (mut bits, mut any, mut all) = (0, false, true);
            for l in 0..answers.lanes {
                let [a, b, c] = [0, 1, 2].map(|k| lanes[k][l].to_f64());
                bits |= u32::from(a < b) << l;
                any |= a < c || b < c;
                all &= a < c && b < c;
                let [x, y, z] = [a.abs(), b.abs(), c.abs()];
                let rounded = |x: f64| T::from_f64(x).to_f64();
                let exponent = (x * std::f64::consts::SQRT_2).log2().floor();
                let exact = [
                    rounded(a + b),
                    rounded(a - b),
                    rounded(a * b),
                    rounded(a / b),
                    rounded(x.sqrt()),
                    x,
                    if a < b { a } else { b },
                    lanes[0][0].to_f64(),
                ];
                let got = |k: usize| answers.rows[k][l].to_f64();
                for (k, want) in exact.into_iter().enumerate() {
                    assert!(
                        got(k) == want,
                        "{} operation {k} of {a:e}, {b:e}: {:e}, not {want:e}",
                        level.name(),
                        got(k)
                    );
                }
                // The powers of two next to sqrt(1/2) and sqrt(2) may go either way by a rounding.
                assert_eq!(got(9) * got(8).exp2(), x, "{} split of {x:e}", level.name());
                assert!(
                    (got(8) - exponent).abs() <= 1.0 && (0.707 * (1.0 - u)..1.4143).contains(&got(9)),
                    "{} split of {x:e}",
                    level.name()
                );
                let root = |x: f64| 1.0 / x.sqrt();
                let over = |x: f64| z / (x * x.sqrt());
                // Want, scale, units in the last place that are documented; the fused operations round once, the others twice.
                let within = [
                    (a.mul_add(b, c), x * y + z, 2.0),
                    ((-a).mul_add(b, c), x * y + z, 2.0),
                    (root(x), root(x), 4.0),
                    (root(y), root(y), 4.0),
                    (root(z), root(z), 4.0),
                    (over(x).copysign(c), over(x), 12.0),
                    (over(y).copysign(c), over(y), 12.0),
                    (over(z).copysign(c), over(z), 12.0),
                    (c / a, z / x, 6.0),
                    (c / b, z / y, 6.0),
                    (c / x, z / x, 6.0),
                ];
                for (k, (want, scale, most)) in within.into_iter().enumerate() {
                    let error = (got(k + 10) - want).abs() / scale / u;
                    // Not `error > most`: it may be NaN.
                    assert!(error <= most, "{} operation {} of {a:e}, {b:e}, {c:e}: {error} u", level.name(), k + 10);
                }
                let (row, least) = row_of(lanes[0][l].abs());
                assert!(answers.least[l] == least, "{} row of {x:e}", level.name());
                for (n, numbers) in answers.looked_up.iter().enumerate() {
                    assert!(numbers[l] == T::from_usize(row * ROW + n), "{} row {row} of {x:e}", level.name());
                }
            }
            let asked = (answers.bits, answers.any_below, answers.all_below);
            assert_eq!(asked, (bits, any, all), "{} case {case}", level.name());
            let rest = |row: &[T; MAX_LANES]| row[answers.lanes..].iter().all(|&x| x == T::ZERO);
            assert!(answers.rows.iter().all(rest), "{} store", level.name());
        }
    }
}

#[test]
fn operations_in_f64() {
    operations::<f64>(400, 70);
}

#[test]
fn operations_in_f32() {
    operations::<f32>(400, 30);
}

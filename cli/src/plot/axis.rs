//! Axes: ranges, ticks at round numbers and at both ends, and their labels.

/// An axis over a range of values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Axis {
    /// Smallest value.
    pub low: f64,
    /// Largest value.
    pub high: f64,
    /// Logarithmic.
    pub log: bool,
}

/// Ticks on an axis whose length is not known yet.
const USUAL: usize = 6;

/// The first digits of the ticks of a linear axis, with one digit after them.
const STEPS: [i64; 3] = [10, 20, 50];

/// Labels of an axis stay in plain digits if its largest value has an exponent from .. to ..
const PLAIN: std::ops::RangeInclusive<i32> = -3..=5;

impl Axis {
    /// The axis between round numbers that holds all finite values; `log` leaves out what is not positive.
    pub fn around(values: impl Iterator<Item = f64>, log: bool) -> Self {
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for value in values.filter(|value| value.is_finite() && (!log || *value > 0.0)) {
            (low, high) = (low.min(value), high.max(value));
        }
        if low > high {
            (low, high) = if log { (0.1, 1.0) } else { (0.0, 1.0) };
        }
        // A constant still gets a visible range.
        if low == high && !log {
            let room = 0.5 * high.abs().max(1.0);
            (low, high) = (low - room, high + room);
        }
        Self { low, high, log }.rounded()
    }

    /// A fixed linear range.
    pub fn fixed([low, high]: [f64; 2]) -> Self {
        Self { low, high, log: false }
    }

    /// The smallest range that holds this one and has ticks at its ends.
    pub fn rounded(self) -> Self {
        if self.log {
            let (mut low, mut high) = (Decimal::below(self.low), Decimal::below(self.high));
            if high.value() < self.high * (1.0 - 1e-12) {
                high = high.next();
            }
            if low == high {
                (low, high) = (low.previous(), high.next());
            }
            return Self { low: low.value(), high: high.value(), log: true };
        }
        let Some(step) = self.step(USUAL) else { return self };
        let unit = step.value();
        let (low, high) = ((self.low / unit + 1e-9).floor(), (self.high / unit - 1e-9).ceil());
        Self { low: step.times(low as i64).value(), high: step.times(high as i64).value(), log: false }
    }

    /// Where a value lies, 0 at the low end and 1 at the high one.
    pub fn place(&self, value: f64) -> f64 {
        if self.low == self.high {
            0.5
        } else if self.log {
            (value / self.low).ln() / (self.high / self.low).ln()
        } else {
            (value - self.low) / (self.high - self.low)
        }
    }

    /// Ticks that carry labels, in order, about `wanted` of them and one at each end, and those that carry none.
    pub fn ticks(&self, wanted: usize) -> (Vec<(f64, String)>, Vec<f64>) {
        let (inner, minor) = if self.log { self.log_ticks() } else { (self.linear_ticks(wanted), Vec::new()) };
        // Near means one place: a rounded end and its tick.
        let near = |a: f64, b: f64| (self.place(a) - self.place(b)).abs() < 1e-6;
        let sample: Vec<Decimal> = inner.iter().map(|tick| tick.0).collect();
        let mut labels = Vec::new();
        for end in [self.low, self.high] {
            let tick = inner.iter().find(|tick| near(tick.0.value(), end));
            let label = tick.map_or_else(|| self.label(self.end(end), &sample), |tick| tick.1.clone());
            labels.push((end, label));
        }
        let inside = |tick: &&(Decimal, String)| {
            let place = self.place(tick.0.value());
            place > 1e-6 && place < 1.0 - 1e-6
        };
        labels.splice(1..1, inner.iter().filter(inside).map(|(tick, label)| (tick.value(), label.clone())));
        if self.low == self.high {
            labels.truncate(1);
        }
        (labels, minor)
    }

    /// The step of about `wanted` ticks; nothing for a range so small beside its values that no decimal tells its ticks apart.
    fn step(&self, wanted: usize) -> Option<Decimal> {
        let raw = (self.high - self.low) / wanted.max(2) as f64;
        let top = self.low.abs().max(self.high.abs());
        if !(raw.is_finite() && raw > 1e-13 * top) {
            return None;
        }
        let power = raw.log10().floor() as i32 - 1;
        // Beyond the largest first digit comes the next power's smallest.
        let steps = STEPS.into_iter().map(|digits| Decimal { digits, power });
        let next = Decimal { digits: STEPS[0], power: power + 1 };
        Some(steps.into_iter().find(|step| step.value() >= raw * (1.0 - 1e-9)).unwrap_or(next))
    }

    fn linear_ticks(&self, wanted: usize) -> Vec<(Decimal, String)> {
        let Some(step) = self.step(wanted) else { return Vec::new() };
        let unit = step.value();
        let (first, last) = ((self.low / unit - 1e-9).ceil() as i64, (self.high / unit + 1e-9).floor() as i64);
        let ticks: Vec<Decimal> = (first..=last).map(|n| step.times(n)).collect();
        ticks.iter().map(|&tick| (tick, self.label(tick, &[step]))).collect()
    }

    fn log_ticks(&self) -> (Vec<(Decimal, String)>, Vec<f64>) {
        if !(self.low > 0.0 && self.high.is_finite()) {
            return (Vec::new(), Vec::new());
        }
        let (first, last) = (self.low.log10().floor() as i32, self.high.log10().ceil() as i32);
        let inside = |tick: &Decimal| {
            let value = tick.value();
            value >= self.low * (1.0 - 1e-9) && value <= self.high * (1.0 + 1e-9)
        };
        let of = |digits: &[i64]| -> Vec<Decimal> {
            let all = (first..=last).flat_map(|power| digits.iter().map(move |&digits| Decimal { digits, power }));
            all.filter(inside).collect()
        };
        let decades = of(&[1]);
        let minor = of(&[2, 3, 4, 5, 6, 7, 8, 9]).iter().map(|tick| tick.value()).collect();
        let chosen = if self.high / self.low >= 99.0 {
            let stride = decades.len().div_ceil(8);
            decades.into_iter().step_by(stride).collect()
        } else if self.high / self.low < 8.0 {
            // Less than two decades: other digits carry labels too.
            of(&[1, 2, 3, 4, 5, 6, 7, 8, 9])
        } else {
            of(&[1, 2, 5])
        };
        (chosen.into_iter().map(|tick| (tick, tick.alone())).collect(), minor)
    }

    /// An end as a decimal: as few digits as place it to a five-hundredth of the axis, and to half a percent on a logarithmic one.
    fn end(&self, value: f64) -> Decimal {
        let good = |rounded: f64| {
            if self.log {
                (rounded / value - 1.0).abs() <= 2e-3 * (self.high / self.low).ln().min(2.5)
            } else {
                (rounded - value).abs() <= 2e-3 * (self.high - self.low)
            }
        };
        let digits = (0..17).map(|digits| Decimal::rounded(value, digits));
        digits.into_iter().find(|decimal| good(decimal.value())).unwrap_or_else(|| Decimal::rounded(value, 17))
    }

    /// A label beside those of `others`: in the same notation, with as many digits as the finest needs.
    fn label(&self, tick: Decimal, others: &[Decimal]) -> String {
        let top = self.low.abs().max(self.high.abs());
        let exponent = top.log10().floor().clamp(-400.0, 400.0) as i32;
        if self.log {
            return tick.alone();
        }
        if tick.digits == 0 {
            return "0".to_owned();
        }
        if PLAIN.contains(&exponent) {
            let finest = others.iter().chain([&tick]).map(|decimal| decimal.trimmed().power).min().unwrap_or(0);
            return tick.plain((-finest).max(0) as usize);
        }
        tick.scientific()
    }
}

/// digits 10^power.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Decimal {
    digits: i64,
    power: i32,
}

impl Decimal {
    /// The number nearest to it.
    fn value(self) -> f64 {
        format!("{}e{}", self.digits, self.power).parse().unwrap_or(f64::NAN)
    }

    /// A value with this many digits after the first.
    fn rounded(value: f64, digits: usize) -> Self {
        let text = format!("{value:.digits$e}");
        let (mantissa, exponent) = text.split_once('e').unwrap_or(("0", "0"));
        let power: i32 = exponent.parse().unwrap_or(0);
        Self { digits: mantissa.replace('.', "").parse().unwrap_or(0), power: power - digits as i32 }.trimmed()
    }

    /// The largest one-digit number that is not above a positive value.
    fn below(value: f64) -> Self {
        let power = value.log10().floor() as i32;
        let from_above = (power - 1..=power + 1).rev();
        let mut candidates = from_above.flat_map(|power| (1..10).rev().map(move |digits| Self { digits, power }));
        let held = candidates.find(|decimal| decimal.value() <= value * (1.0 + 1e-12));
        held.unwrap_or(Self { digits: 1, power })
    }

    /// The next one-digit number.
    fn next(self) -> Self {
        if self.digits == 9 {
            Self { digits: 1, power: self.power + 1 }
        } else {
            Self { digits: self.digits + 1, ..self }
        }
    }

    /// The one-digit number before.
    fn previous(self) -> Self {
        if self.digits == 1 {
            Self { digits: 9, power: self.power - 1 }
        } else {
            Self { digits: self.digits - 1, ..self }
        }
    }

    fn times(self, n: i64) -> Self {
        Self { digits: self.digits.saturating_mul(n), ..self }
    }

    /// Without zeros at the end.
    fn trimmed(mut self) -> Self {
        while self.digits != 0 && self.digits % 10 == 0 {
            self = Self { digits: self.digits / 10, power: self.power + 1 };
        }
        if self.digits == 0 { Self { digits: 0, power: 0 } } else { self }
    }

    fn exponent(self) -> i32 {
        self.digits.unsigned_abs().checked_ilog10().map_or(0, |digits| digits as i32 + self.power)
    }

    /// In the notation of its own size.
    fn alone(self) -> String {
        let trimmed = self.trimmed();
        if PLAIN.contains(&trimmed.exponent()) {
            trimmed.plain((-trimmed.power).max(0) as usize)
        } else {
            trimmed.scientific()
        }
    }

    fn plain(self, decimals: usize) -> String {
        sign(format!("{:.decimals$}", self.value()))
    }

    fn scientific(self) -> String {
        let trimmed = self.trimmed();
        let exponent = trimmed.exponent();
        let digits = (exponent - trimmed.power).max(0) as usize;
        sign(format!("{:.digits$e}", trimmed.value()))
    }
}

/// With the minus sign of print.
fn sign(text: String) -> String {
    text.replace('-', "\u{2212}")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(axis: Axis) -> Vec<String> {
        axis.ticks(6).0.into_iter().map(|(_, label)| label).collect()
    }

    fn parsed(label: &str) -> f64 {
        label.replace('\u{2212}', "-").parse().unwrap_or_else(|_| panic!("{label:?}"))
    }

    #[test]
    fn ticks_are_round() {
        assert_eq!(labels(Axis::fixed([0.0, 1.0])), ["0", "0.2", "0.4", "0.6", "0.8", "1.0"]);
        assert_eq!(
            labels(Axis::fixed([-0.3, 0.3])),
            ["\u{2212}0.3", "\u{2212}0.2", "\u{2212}0.1", "0", "0.1", "0.2", "0.3"]
        );
        assert_eq!(
            labels(Axis::fixed([0.0, 2e-7])),
            ["0", "5e\u{2212}8", "1e\u{2212}7", "1.5e\u{2212}7", "2e\u{2212}7"]
        );
        assert_eq!(labels(Axis::fixed([1.0, 1.000_02])), ["1.000000", "1.000005", "1.000010", "1.000015", "1.000020"]);
        assert_eq!(labels(Axis::fixed([0.0, 4e6])), ["0", "1e6", "2e6", "3e6", "4e6"]);
        assert_eq!(
            labels(Axis { low: 1e-4, high: 1.5, log: true }),
            ["1e\u{2212}4", "0.001", "0.01", "0.1", "1", "1.5"]
        );
    }

    /// Counts of particles: plain digits at every tick, no product of a digit and a power.
    #[test]
    fn counts_are_whole_numbers() {
        let counts = Axis::around([40_000.0, 13_020.0].into_iter(), true);
        assert_eq!(labels(counts), ["10000", "20000", "30000", "40000"]);
        let few = Axis::around([39_990.0, 40_000.0].into_iter(), true);
        assert_eq!(labels(few), ["30000", "40000"]);
        let many = Axis::around([1e6, 350_000.0].into_iter(), true);
        assert_eq!(labels(many), ["300000", "400000", "500000", "600000", "700000", "800000", "900000", "1e6"]);
        let wide = Axis::around([400_000.0, 2.0].into_iter(), true);
        assert_eq!(labels(wide), ["2", "10", "100", "1000", "10000", "100000", "400000"]);
        let one = Axis::around([1.0, 1.0].into_iter(), true);
        assert_eq!(labels(one), ["0.9", "1", "2"]);
    }

    /// Both ends carry a label that says where they are, whatever the range; labels differ and rise.
    #[test]
    fn every_end_has_its_label() {
        let mut state = 7_u64;
        let mut random = move || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64
        };
        for index in 0..20_000 {
            let log = index % 2 == 0;
            let scale = 10_f64.powf(24.0 * random() - 12.0);
            let axis = if log {
                Axis { low: scale, high: scale * 10_f64.powf(1e-2 + 8.0 * random()), log }
            } else {
                let low = scale * (2.0 * random() - 1.0);
                Axis { low, high: low + scale * 10_f64.powf(-3.0 * random()), log }
            };
            for axis in [axis, axis.rounded()] {
                let wanted = 2 + index % 7;
                let (ticks, _) = axis.ticks(wanted);
                let slack = |value: f64| if log { 0.006 * value } else { 0.003 * (axis.high - axis.low) };
                assert!(ticks.len() >= 2 && ticks.len() < 30, "{axis:?}: {ticks:?}");
                assert_eq!((ticks[0].0, ticks[ticks.len() - 1].0), (axis.low, axis.high), "{ticks:?}");
                for (value, label) in &ticks {
                    assert!((parsed(label) - value).abs() <= slack(*value), "{axis:?}: {value} {label}");
                }
                for pair in ticks.windows(2) {
                    assert!(pair[0].0 < pair[1].0, "{axis:?}: {ticks:?}");
                    let (a, b) = (axis.place(pair[0].0), axis.place(pair[1].0));
                    assert!(b - a < 1e-2 || parsed(&pair[0].1) < parsed(&pair[1].1), "{axis:?}: {ticks:?}");
                }
            }
            let round = axis.rounded();
            assert!(round.low <= axis.low * (1.0 + 1e-9) + 1e-9 * (axis.high - axis.low), "{axis:?} {round:?}");
            assert!(round.high >= axis.high * (1.0 - 1e-9) - 1e-9 * (axis.high - axis.low), "{axis:?} {round:?}");
        }
    }

    #[test]
    fn a_range_holds_its_values() {
        for log in [false, true] {
            let axis = Axis::around([1.0, f64::NAN, 3.0, -1.0].into_iter(), log);
            assert!(axis.place(3.0) <= 1.0 && axis.place(1.0) >= 0.0);
        }
        let constant = Axis::around([2.0, 2.0].into_iter(), false);
        assert!(constant.low < 2.0 && constant.high > 2.0);
        assert_eq!(labels(Axis::around([-0.25, 0.93].into_iter(), false)).first().unwrap(), "\u{2212}0.4");
    }

    /// Ranges that no decimal divides: the ends alone, or the one value.
    #[test]
    fn degenerate_ranges_have_labels_too() {
        assert_eq!(labels(Axis::fixed([2.5, 2.5])), ["2.5"]);
        assert_eq!(labels(Axis::fixed([0.0, 0.0])), ["0"]);
        let next = f64::from_bits(1.0_f64.to_bits() + 1);
        assert_eq!(labels(Axis::fixed([1.0, next])).len(), 2);
        for axis in [Axis::around(std::iter::empty(), true), Axis::around(std::iter::empty(), false)] {
            assert!(labels(axis).len() > 2, "{:?}", labels(axis));
        }
        assert!(!labels(Axis { low: 0.0, high: 1.0, log: true }).is_empty());
    }
}

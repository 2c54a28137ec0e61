//! Axes: ranges, ticks at round numbers, and their labels.

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

impl Axis {
    /// An axis that holds all finite values, with a little room; `log` leaves out what is not positive.
    pub fn around(values: impl Iterator<Item = f64>, log: bool) -> Self {
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for value in values.filter(|value| value.is_finite() && (!log || *value > 0.0)) {
            (low, high) = (low.min(value), high.max(value));
        }
        if low > high {
            (low, high) = if log { (0.1, 1.0) } else { (0.0, 1.0) };
        }
        if log {
            let room = (high / low).powf(0.06).max(1.15);
            return Self { low: low / room, high: high * room, log };
        }
        // A constant still gets a visible range.
        let room = if high > low { 0.04 * (high - low) } else { 0.5 * high.abs().max(1.0) };
        Self { low: low - room, high: high + room, log }
    }

    /// A fixed linear range.
    pub fn fixed([low, high]: [f64; 2]) -> Self {
        Self { low, high, log: false }
    }

    /// Where a value lies, 0 at the low end and 1 at the high one.
    pub fn place(&self, value: f64) -> f64 {
        if self.log {
            (value / self.low).ln() / (self.high / self.low).ln()
        } else {
            (value - self.low) / (self.high - self.low)
        }
    }

    /// Ticks that carry labels, about `wanted` of them, and those that don't.
    pub fn ticks(&self, wanted: usize) -> (Vec<(f64, String)>, Vec<f64>) {
        if self.log { self.log_ticks() } else { (self.linear_ticks(wanted), Vec::new()) }
    }

    fn linear_ticks(&self, wanted: usize) -> Vec<(f64, String)> {
        let raw = (self.high - self.low) / wanted.max(2) as f64;
        let power = 10_f64.powf(raw.log10().floor());
        let step = [1.0, 2.0, 2.5, 5.0, 10.0].into_iter().map(|m| m * power).find(|step| *step >= raw).unwrap_or(raw);
        // Digits after the point that tell one tick from the next.
        let digits = (0..12).find(|&digits| {
            let scaled = step * 10_f64.powi(digits);
            (scaled - scaled.round()).abs() < 1e-6 * scaled
        });
        let first = (self.low / step - 1e-9).ceil() as i64;
        let last = (self.high / step + 1e-9).floor() as i64;
        let label = |value: f64| match digits {
            _ if value == 0.0 => "0".to_owned(),
            Some(digits) if digits <= 5 && value.abs() < 1e6 => {
                format!("{value:.*}", digits as usize).replace('-', "\u{2212}")
            }
            _ => format!("{value:.2e}").replace('-', "\u{2212}"),
        };
        (first..=last.min(first + 40)).map(|i| i as f64 * step).map(|value| (value, label(value))).collect()
    }

    fn log_ticks(&self) -> (Vec<(f64, String)>, Vec<f64>) {
        let (first, last) = (self.low.log10().floor() as i32, self.high.log10().ceil() as i32);
        let inside = |value: &f64| *value >= self.low * (1.0 - 1e-9) && *value <= self.high * (1.0 + 1e-9);
        let decades: Vec<i32> = (first..=last).filter(|&e| inside(&10_f64.powi(e))).collect();
        let minor: Vec<f64> =
            (first..=last).flat_map(|e| (2..10).map(move |m| f64::from(m) * 10_f64.powi(e))).filter(inside).collect();
        if decades.len() >= 2 {
            let stride = decades.len().div_ceil(8);
            let labels = decades.iter().step_by(stride).map(|&e| (10_f64.powi(e), power_of_ten(e))).collect();
            return (labels, minor);
        }
        // Less than two decades: 1, 2, 5 carry labels too.
        let chosen: &[i32] = if self.high / self.low < 8.0 { &[1, 2, 3, 5, 7] } else { &[1, 2, 5] };
        let labels = (first..=last)
            .flat_map(|e| chosen.iter().map(move |&m| (m, e)))
            .map(|(m, e)| (f64::from(m) * 10_f64.powi(e), plain(m, e)))
            .filter(|(value, _)| inside(value))
            .collect();
        (labels, minor)
    }
}

fn plain(m: i32, e: i32) -> String {
    match e {
        0..=3 => format!("{}", m * 10_i32.pow(e as u32)),
        -4..=-1 => format!("{:.*}", e.unsigned_abs() as usize, f64::from(m) * 10_f64.powi(e)),
        _ => format!("{m}\u{b7}{}", power_of_ten(e)),
    }
}

/// 10 with raised digits, which the font has only for 1 to 3 in one block and the rest in another: so by e-notation.
fn power_of_ten(e: i32) -> String {
    match e {
        0 => "1".to_owned(),
        1 => "10".to_owned(),
        2 => "100".to_owned(),
        -1 => "0.1".to_owned(),
        -2 => "0.01".to_owned(),
        _ => format!("1e{e}").replace('-', "\u{2212}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(axis: Axis) -> Vec<String> {
        axis.ticks(6).0.into_iter().map(|(_, label)| label).collect()
    }

    #[test]
    fn ticks_are_round() {
        assert_eq!(labels(Axis::fixed([0.0, 1.0])), ["0", "0.2", "0.4", "0.6", "0.8", "1.0"]);
        assert_eq!(
            labels(Axis::fixed([-0.3, 0.3])),
            ["\u{2212}0.3", "\u{2212}0.2", "\u{2212}0.1", "0", "0.1", "0.2", "0.3"]
        );
        assert_eq!(
            labels(Axis { low: 1e-4, high: 1.5, log: true }),
            ["1e\u{2212}4", "1e\u{2212}3", "0.01", "0.1", "1"]
        );
        assert_eq!(labels(Axis { low: 0.03, high: 0.11, log: true }), ["0.03", "0.05", "0.07", "0.1"]);
    }

    #[test]
    fn a_range_holds_its_values() {
        for log in [false, true] {
            let axis = Axis::around([1.0, f64::NAN, 3.0, -1.0].into_iter(), log);
            assert!(axis.place(3.0) < 1.0 && axis.place(1.0) > 0.0);
        }
        let constant = Axis::around([2.0, 2.0].into_iter(), false);
        assert!(constant.low < 2.0 && constant.high > 2.0);
    }
}

//! Errors gathered by quantity and order, as JSON, and by mollifier, as lines of a table.

use std::collections::BTreeMap;

use anyhow::{Context, Result};
use mollis_core::mollifier::Mollifier;
use serde_json::{Map, Value, json};

use super::api::{Api, Evaluator, Values};
use super::decimal::{Decimal, Scalar};
use super::reference::Row;
use super::tolerance::{Tolerance, Unit, tolerance};

/// One value against its reference.
struct Measured {
    /// Units in the last place of the reference.
    ulp: f64,
    /// Units in the last place of the scale that the tolerance names (the reference itself for `Unit::Ulp`).
    judged: f64,
    /// |error| / scale.
    relative: f64,
}

/// What is known of one quantity and order.
#[derive(Default)]
pub struct Summary {
    rows: usize,
    skipped: usize,
    max_ulp: f64,
    max_judged: f64,
    max_relative: f64,
    non_finite: usize,
    limit: Option<&'static Tolerance>,
    /// The row that uses most of its tolerance, and that share.
    worst: Option<(f64, Map<String, Value>)>,
    failed: bool,
}

impl Summary {
    fn add(&mut self, measured: &Measured, tolerance: &'static Tolerance, row: &Row, reference: Decimal, got: f64) {
        self.rows += 1;
        self.limit = Some(self.limit.map_or(tolerance, |t| if t.limit > tolerance.limit { t } else { tolerance }));
        self.max_ulp = self.max_ulp.max(measured.ulp);
        self.max_judged = self.max_judged.max(measured.judged);
        self.max_relative = self.max_relative.max(measured.relative);
        // Not `>`: what is not a number fails.
        self.failed |= !matches!(
            measured.judged.partial_cmp(&tolerance.limit),
            Some(std::cmp::Ordering::Less | std::cmp::Ordering::Equal)
        );
        self.non_finite += usize::from(measured.judged == f64::INFINITY);
        let share = measured.judged / tolerance.limit;
        if self.worst.as_ref().is_none_or(|&(worst, _)| share > worst) {
            let mut text = row.text.clone();
            text.insert("reference".into(), reference.to_f64().into());
            text.insert("got".into(), if got.is_finite() { got.into() } else { got.to_string().into() });
            self.worst = Some((share, text));
        }
    }

    /// The object that is printed. Errors in units in the last place; `null` where infinite.
    fn json(&self, quantity: &str, order: u32, file: &str) -> Value {
        json!({
            "file": file,
            "quantity": quantity,
            "order": order,
            "rows": self.rows,
            "skipped": self.skipped,
            "max_ulp": self.max_ulp,
            "max_ulp_of_max": self.max_judged,
            "max_rel_scale": self.max_relative,
            "unit": self.limit.map(|t| t.unit.name()),
            "limit": self.limit.map(|t| t.limit),
            "reason": self.limit.map(|t| t.reason),
            "non_finite": self.non_finite,
            "passed": !self.failed,
            "worst": self.worst.as_ref().map(|(_, text)| text),
        })
    }
}

/// (N, M, order).
type Shape = (u32, Option<u32>, u32);

/// The errors of one file.
#[derive(Default)]
pub struct Report {
    by_order: BTreeMap<(usize, u32), (&'static str, Summary)>,
    by_shape: BTreeMap<Shape, BTreeMap<usize, (&'static str, f64)>>,
}

impl Report {
    /// Evaluates every row.
    pub fn new(rows: &[Row], api: Api, scalar: Scalar) -> Result<Self> {
        let mut report = Self::default();
        let mut evaluator = Evaluator::new(api, scalar);
        for row in rows {
            // A scalar that cannot hold the inputs is asked about another place.
            let exact = scalar.holds(row.delta) && scalar.holds(row.r);
            let results = exact.then(|| Results::new(&mut evaluator, row)).transpose()?;
            for (place, &(quantity, reference)) in row.values.iter().enumerate() {
                let entry = report.by_order.entry((place, row.order()));
                let (_, summary) = entry.or_insert_with(|| (quantity, Summary::default()));
                let Some(results) = &results else {
                    summary.skipped += 1;
                    continue;
                };
                let got = value(&results.here, quantity)?;
                let entry = tolerance(row, quantity);
                let entry = entry.with_context(|| format!("no tolerance for {quantity} of order {}", row.order()))?;
                let scale = results.scale(entry.unit, row, quantity, reference)?;
                let measured = measure(reference, got, scale, scalar);
                summary.add(&measured, entry, row, reference, got);
                let shape = report.by_shape.entry((row.dimension, row.exponent(), row.order())).or_default();
                let (_, worst) = shape.entry(place).or_insert((quantity, 0.0));
                *worst = worst.max(measured.judged);
            }
        }
        Ok(report)
    }

    /// Whether every row that was evaluated is within its tolerance.
    pub fn passed(&self) -> bool {
        self.by_order.values().all(|(_, summary)| !summary.failed)
    }

    /// One object a quantity and order.
    pub fn json<'a>(&'a self, file: &'a str) -> impl Iterator<Item = Value> + 'a {
        self.by_order.iter().map(move |(&(_, order), (quantity, summary))| summary.json(quantity, order, file))
    }

    /// Largest errors by dimension, exponent and order: lines of `file,scalar,dimension,exponent,order,quantity,error`.
    pub fn lines<'a>(&'a self, file: &'a str, scalar: &'a str) -> impl Iterator<Item = String> + 'a {
        self.by_shape.iter().flat_map(move |(&(dimension, exponent, order), errors)| {
            let exponent = exponent.map_or(String::new(), |m| m.to_string());
            errors.values().map(move |(quantity, error)| {
                format!("{file},{scalar},{dimension},{exponent},{order},{quantity},{error:.2}")
            })
        })
    }
}

/// What the interface returns for a row.
struct Results {
    /// At the row's place.
    here: Values,
    /// At r = 0, of mollifiers; the bare kernel at r = delta, of kernels.
    scale: Values,
}

impl Results {
    fn new(evaluator: &mut Evaluator, row: &Row) -> Result<Self> {
        let (mollifier, r) = match row.kernel {
            Some(_) => (Mollifier::None, row.delta),
            None => (row.mollifier, 0.0),
        };
        Ok(Self { here: evaluator.evaluate(row, row.mollifier, row.r)?, scale: evaluator.evaluate(row, mollifier, r)? })
    }

    /// The magnitude beside the reference itself at which a unit in the last place is taken; 0: none.
    fn scale(&self, unit: Unit, row: &Row, quantity: &str, reference: Decimal) -> Result<f64> {
        let magnitude = |quantity| Ok::<f64, anyhow::Error>(value(&self.scale, quantity)?.abs());
        Ok(match unit {
            Unit::Ulp => 0.0,
            Unit::UlpOfMax => magnitude(quantity)?,
            Unit::UlpOfKernel if quantity == "laplacian" => magnitude(quantity)?.max(magnitude("grad_factor")?),
            Unit::UlpOfKernel => magnitude(quantity)?,
            Unit::UlpOfTerms => {
                let (phi, log) = (reference.to_f64(), row.delta.ln());
                (2.0 * std::f64::consts::PI * phi - log).abs().max(log.abs()) / (2.0 * std::f64::consts::PI)
            }
        })
    }
}

fn value(list: &Values, quantity: &str) -> Result<f64> {
    let found = list.iter().find(|&&(column, _)| column == quantity);
    found.map(|&(_, value)| value).with_context(|| format!("no result for {quantity}"))
}

fn measure(reference: Decimal, got: f64, scale: f64, scalar: Scalar) -> Measured {
    let magnitude = scale.abs().max(reference.to_f64().abs());
    let relative = if magnitude > 0.0 { reference.error(got) / magnitude } else { 0.0 };
    Measured {
        ulp: reference.ulps(got, 0.0, scalar),
        judged: reference.ulps(got, scale, scalar),
        relative: if relative.is_nan() { 0.0 } else { relative },
    }
}

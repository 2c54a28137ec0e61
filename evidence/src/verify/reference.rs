//! Reading reference files: comments, a header line, then a row a place. The column names tell what a file holds.

use std::collections::HashMap;
use std::path::Path;

use anyhow::{Context, Result, bail};
use mollis_core::mollifier::Mollifier;

use super::decimal::Decimal;

/// The columns that may hold a value to compare.
pub const QUANTITIES: [&str; 10] =
    ["B", "psi", "phi", "value", "grad_factor", "hess_factor", "laplacian", "Bprime_over_r", "psiprime_over_r", "mass"];

/// What a row of a reference file is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Family {
    Compact,
    Gaussian,
    Kernel,
}

/// One place.
#[derive(Clone, Debug)]
pub struct Row {
    pub family: Family,
    pub dimension: u32,
    pub mollifier: Mollifier,
    /// The kernel's name, of kernel files.
    pub kernel: Option<String>,
    pub delta: f64,
    pub r: f64,
    pub values: Vec<(&'static str, Decimal)>,
    /// The row as it stands, by column.
    pub text: serde_json::Map<String, serde_json::Value>,
}

impl Row {
    /// 0 for the singular kernel.
    pub fn order(&self) -> u32 {
        self.mollifier.order()
    }

    /// M, of compact mollifiers.
    pub fn exponent(&self) -> Option<u32> {
        match self.mollifier {
            Mollifier::Compact { exponent, .. } => Some(exponent),
            _ => None,
        }
    }
}

/// All rows of a file.
pub fn read(path: &Path) -> Result<Vec<Row>> {
    let mut reader = csv::ReaderBuilder::new()
        .comment(Some(b'#'))
        .from_path(path)
        .with_context(|| format!("cannot read {}", path.display()))?;
    let columns: Vec<String> = reader.headers()?.iter().map(str::to_owned).collect();
    let has = |name: &str| columns.iter().any(|c| c == name);
    let family = match (has("kernel"), has("M")) {
        (true, _) => Family::Kernel,
        (false, true) => Family::Compact,
        (false, false) => Family::Gaussian,
    };
    if !["dim", "delta", "r"].into_iter().all(has) || !(has("order") || has("kernel")) {
        bail!("{}: not a reference file (columns {})", path.display(), columns.join(", "));
    }
    let mut rows = Vec::new();
    for (number, record) in reader.records().enumerate() {
        let record = record?;
        let fields: HashMap<&str, &str> = columns.iter().map(String::as_str).zip(record.iter()).collect();
        rows.push(row(family, &fields).with_context(|| format!("{}: row {}", path.display(), number + 1))?);
    }
    if rows.is_empty() {
        bail!("{}: no rows", path.display());
    }
    Ok(rows)
}

fn row(family: Family, fields: &HashMap<&str, &str>) -> Result<Row> {
    let field = |name: &str| fields.get(name).copied().with_context(|| format!("no column {name}"));
    let mollifier = match family {
        Family::Compact => Mollifier::Compact { order: field("order")?.parse()?, exponent: field("M")?.parse()? },
        Family::Gaussian => Mollifier::Gaussian { order: field("order")?.parse()? },
        Family::Kernel => named(field("psi")?)?,
    };
    let mut values = Vec::new();
    for name in QUANTITIES {
        // In kernel files `psi` names the mollifier.
        if family == Family::Kernel && name == "psi" {
            continue;
        }
        if let Some(text) = fields.get(name) {
            values.push((name, Decimal::parse(text)?));
        }
    }
    let text = fields.iter().map(|(&k, &v)| (k.to_owned(), v.into())).collect();
    Ok(Row {
        family,
        dimension: field("dim")?.parse()?,
        mollifier,
        kernel: fields.get("kernel").map(|&k| k.to_owned()),
        // The shortest decimal of a binary number, so read back exactly.
        delta: field("delta")?.parse()?,
        r: field("r")?.parse()?,
        values,
        text,
    })
}

/// `poly<order>_M<exponent>`, `gauss<order>`, `none`.
fn named(psi: &str) -> Result<Mollifier> {
    if psi == "none" {
        return Ok(Mollifier::None);
    }
    if let Some(order) = psi.strip_prefix("gauss") {
        return Ok(Mollifier::Gaussian { order: order.parse()? });
    }
    let parts = psi.strip_prefix("poly").and_then(|rest| rest.split_once("_M"));
    let (order, exponent) = parts.with_context(|| format!("unknown mollifier {psi}"))?;
    Ok(Mollifier::Compact { order: order.parse()?, exponent: exponent.parse()? })
}

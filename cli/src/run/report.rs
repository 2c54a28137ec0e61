//! What a run tells on standard output.

use std::path::Path;

use anyhow::Result;
use mollis_host::say;

use crate::measure;
use crate::results::{CaseResult, study_rows};
use crate::scene::SceneFile;

/// A number as short as it is readable.
fn short(value: f64) -> String {
    if value != 0.0 && value.abs() < 1e-2 { format!("{value:.4e}") } else { format!("{value:.5}") }
}

/// An expectation, and what came of it.
pub fn described(check: &measure::Check) -> String {
    let expectation = &check.expectation;
    let case = expectation.case.as_ref().map_or(String::new(), |case| format!(" [{case}]"));
    let place = match (expectation.at, expectation.from, expectation.to) {
        (Some(at), _, _) => format!(" at {at}"),
        (None, None, None) => String::new(),
        (None, from, to) => {
            format!(" from {} to {}", from.unwrap_or(0.0), to.map_or("the end".to_owned(), |to| to.to_string()))
        }
    };
    let bounds = match (expectation.least.is_finite(), expectation.most.is_finite()) {
        (true, true) => format!("{} to {}", short(expectation.least), short(expectation.most)),
        (true, false) => format!("at least {}", short(expectation.least)),
        _ => format!("at most {}", short(expectation.most)),
    };
    let verdict = if check.passed { "met" } else { "NOT MET" };
    let value = check.error.clone().unwrap_or_else(|| short(check.value));
    format!("  {}{case}{place}: {value} (expected {bounds}): {verdict}", expectation.quantity)
}

/// Writes title, cases and expectations.
pub fn report(out: &Path, file: &SceneFile, results: &[CaseResult<'_>], checks: &[measure::Check]) -> Result<()> {
    say!("{}", file.title)?;
    for result in results {
        let name = if result.scene.name.is_empty() { String::new() } else { format!("{}: ", result.scene.name) };
        let steps = result.main.seconds.iter().find(|(phase, _)| phase == "steps").map_or(0.0, |(_, seconds)| *seconds);
        say!("  {name}{} particles, {} steps in {steps:.2} s", result.main.start.len(), result.scene.steps)?;
        for line in &result.main.plan {
            say!("    {line}")?;
        }
        for (row, point) in study_rows(&result.study).iter().zip(&result.study) {
            say!(
                "    h = {:<8.5} {:>7} particles  positions {:.3e} (rate {:.2})  density {:.3e} (rate {:.2})",
                point.h,
                point.particles,
                row[2],
                row[3],
                row[4],
                row[5]
            )?;
        }
    }
    for check in checks {
        say!("{}", described(check))?;
    }
    say!("  written to {}", out.display())
}

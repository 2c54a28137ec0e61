//! `summary.json`: what ran, how long it took, and what came of the expectations.

use std::path::Path;

use anyhow::Result;

use super::Args;
use crate::files;
use crate::measure;
use crate::results::{CaseResult, STUDY_COLUMNS, study_rows};
use crate::scene::{self, SceneFile};

/// Writes the file into `out`; a picture has an error or none.
pub fn write(
    out: &Path,
    args: &Args,
    file: &SceneFile,
    results: &[CaseResult<'_>],
    checks: &[measure::Check],
    pictures: &[Option<String>],
    seconds: &[(&str, f64)],
) -> Result<()> {
    use serde_json::{Map, Value, json};
    // JSON knows no infinity and no NaN: they become null.
    let number = |value: f64| serde_json::Number::from_f64(value).map_or(Value::Null, Value::Number);
    let phases = |list: &[(String, f64)]| -> Map<String, Value> {
        list.iter().map(|(phase, seconds)| (phase.clone(), number(*seconds))).collect()
    };
    let cases: Vec<Value> = results
        .iter()
        .map(|result| {
            let last = result.main.rows.last().map_or(&[][..], Vec::as_slice);
            let diagnostics: Map<String, Value> =
                result.main.columns.iter().zip(last).map(|(name, value)| (name.clone(), number(*value))).collect();
            let study: Vec<Map<String, Value>> = study_rows(&result.study)
                .iter()
                .map(|row| {
                    STUDY_COLUMNS.iter().zip(row).map(|(name, value)| ((*name).to_owned(), number(*value))).collect()
                })
                .collect();
            let (skipped, plan): (Vec<&String>, Vec<&String>) =
                result.main.plan.iter().partition(|line| line.starts_with("skipped: "));
            let h = (result.main.h > 0.0).then_some(result.main.h);
            json!({
                "name": result.scene.name,
                "folder": if results.len() == 1 { "." } else { result.scene.folder.as_str() },
                "model": format!("{:?}", result.scene.model).to_lowercase(),
                "dimension": result.scene.dimension,
                "seed": result.scene.seed,
                "h": h,
                "delta": result.scene.mollifier.map(|softening| number(softening.delta(h))),
                "dt": result.scene.dt,
                "steps": result.scene.steps,
                "particles_at_start": result.main.start.len(),
                "particles_at_end": result.main.end.len(),
                "coalescences": result.main.events.len(),
                "diagnostics_at_end": diagnostics,
                "study": study,
                "plan": plan,
                "skipped": skipped.iter().map(|line| line.trim_start_matches("skipped: ")).collect::<Vec<_>>(),
                "seconds": phases(&result.main.seconds),
            })
        })
        .collect();
    let expectations: Vec<Value> = checks
        .iter()
        .map(|check| {
            let expectation = &check.expectation;
            json!({
                "quantity": expectation.quantity,
                "case": expectation.case,
                "at": expectation.at,
                "from": expectation.from,
                "to": expectation.to,
                "part": expectation.part,
                "expected": expectation.value,
                "least": number(expectation.least),
                "most": number(expectation.most),
                "paper": expectation.paper,
                "reason": expectation.reason,
                "value": number(check.value),
                "error": check.error,
                "passed": check.passed,
            })
        })
        .collect();
    let drawn: Vec<Value> = file
        .pictures
        .iter()
        .zip(pictures)
        .map(|(picture, error)| json!({"name": picture.name, "title": picture.title, "error": error}))
        .collect();
    let whole: Map<String, Value> =
        seconds.iter().map(|(phase, seconds)| ((*phase).to_owned(), number(*seconds))).collect();
    let summary = json!({
        "title": file.title,
        "source": file.source,
        "note": file.note,
        "scene": args.scene.display().to_string(),
        "quick": args.quick,
        "version": env!("CARGO_PKG_VERSION"),
        "level": format!("{:?}", mollis_core::simd::Level::best()),
        "threads": args.threads,
        "cases": cases,
        "expectations": expectations,
        "pictures": drawn,
        "seconds": whole,
    });
    files::write(&out.join(scene::SUMMARY), |file| Ok(serde_json::to_writer_pretty(file, &summary)?))
}

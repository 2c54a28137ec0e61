//! A study's picture and numbers, its part of the page, and the page.

use std::fmt::Write;
use std::path::Path;

use anyhow::{Context, Result};
use mollis_cli::plot::axis::Axis;
use mollis_cli::plot::chart::{COLORS, Chart, Curve as Line, MARKS, sheet};

use super::{Curve, Study, fastest};

/// Writes `NAME.json`, `NAME.svg` and `NAME.md`.
pub fn write(folder: &Path, study: &Study) -> Result<()> {
    let file = |extension: &str| folder.join(study.name).with_extension(extension);
    std::fs::write(file("json"), serde_json::to_string_pretty(study)? + "\n")?;
    std::fs::write(file("svg"), picture(study).svg()?)?;
    std::fs::write(file("md"), text(study, &machine())?).with_context(|| format!("cannot write {}", study.name))
}

/// The page of all studies whose parts are there.
pub fn join(folder: &Path, names: &[&str]) -> Result<()> {
    let (mut page, mut end) = (HEAD.to_owned(), "\n## In short\n".to_owned());
    for name in names {
        if let Ok(part) = std::fs::read_to_string(folder.join(name).with_extension("md")) {
            write!(page, "\n{part}")?;
            let answers: Vec<&str> = part.lines().filter(|line| line.starts_with(ANSWER)).collect();
            if let (Some(question), false) = (part.lines().next(), answers.is_empty()) {
                write!(end, "\n{}\n\n{}\n", question.trim_start_matches(['#', ' ']), answers.join("\n"))?;
            }
        }
    }
    page.push_str(&end);
    std::fs::write(folder.join("README.md"), page).context("cannot write the page")
}

/// How the lines begin that say what is fastest.
const ANSWER: &str = "* For ";

const HEAD: &str = "# Run time against error

    cargo xtask bench

measures everything on this page again, on one thread, and writes it. Numbers are in the `.json` file beside each picture; each study's text is in the `.md` file of
its name. Times are CPU times: those of sums and of mollifiers the least of a few calls, those of runs of one.
";

fn picture(study: &Study) -> mollis_cli::plot::canvas::Canvas {
    let all = || study.curves.iter().flat_map(|curve| &curve.rows);
    let axes = [Axis::around(all().map(|row| row.error), true), Axis::around(all().map(|row| row.time), true)];
    let [x, y] = axes;
    let mut chart = Chart::new("", study.error, study.unit, x, y);
    for (index, Curve { name, rows }) in study.curves.iter().enumerate() {
        let color = COLORS[index % COLORS.len()];
        // Rounding errors below the axis are drawn nowhere.
        let points: Vec<[f64; 2]> =
            rows.iter().filter(|row| row.error > 0.0).map(|row| [row.error, row.time]).collect();
        chart.curves.push(Line { mark: Some((MARKS[index % MARKS.len()], 4.0)), ..Line::line(name, points, color) });
        for row in rows {
            if let Some(spread) = row.spread {
                let ends = [(row.error - spread).max(x.low), row.error + spread].map(|error| [error, row.time]);
                chart.curves.push(Line::line("", ends.to_vec(), color));
            }
        }
    }
    sheet(study.question, &[chart], 1, 1000, 640)
}

fn text(study: &Study, machine: &str) -> Result<String> {
    let mut text = String::new();
    writeln!(text, "## {}\n\n{} {machine}\n", study.question, study.about)?;
    writeln!(text, "![{} against {}]({}.svg)\n", study.unit, study.error, study.name)?;
    for &digits in study.digits {
        match fastest(&study.curves, 10_f64.powi(-digits)) {
            Some((curve, row)) => writeln!(
                text,
                "{ANSWER}{digits} digit{}: **{curve}, {}** ({} {}, error {:.1e}).",
                if digits == 1 { "" } else { "s" },
                row.setting,
                number(row.time),
                study.unit,
                row.error
            )?,
            None => writeln!(text, "{ANSWER}{digits} digits: none of these.")?,
        }
    }
    for note in &study.notes {
        writeln!(text, "* {note}")?;
    }
    writeln!(text, "\n| | setting | {} | error |\n|---|---|---|---|", study.unit)?;
    for Curve { name, rows } in &study.curves {
        for row in rows {
            let spread = row.spread.map_or(String::new(), |spread| format!(" +- {spread:.1e}"));
            writeln!(text, "| {name} | {} | {} | {:.1e}{spread} |", row.setting, number(row.time), row.error)?;
        }
    }
    Ok(text)
}

/// When and where, in a sentence.
fn machine() -> String {
    let cpus = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let model = cpus.lines().find_map(|line| line.strip_prefix("model name")?.split_once(": "));
    let model = model.map_or("an unknown processor", |(_, model)| model);
    let date = std::process::Command::new("date").arg("+%F").output();
    let date = date.map_or(String::new(), |date| String::from_utf8_lossy(&date.stdout).trim().to_owned());
    format!("Measured {date} on {model}, level {:?}.", mollis_core::simd::Level::best())
}

/// Three digits.
fn number(x: f64) -> String {
    if x == 0.0 {
        return "0".to_owned();
    }
    let digits = (2 - x.abs().log10().floor() as i32).clamp(0, 9) as usize;
    format!("{x:.digits$}")
}

#[cfg(test)]
mod tests {
    use super::super::Row;
    use super::*;

    fn row(time: f64, error: f64) -> Row {
        Row { setting: format!("{time}"), time, error, spread: None }
    }

    #[test]
    fn three_digits() {
        assert_eq!([1234.5, 12.345, 0.012_345, 0.0].map(number), ["1234", "12.3", "0.0123", "0"]);
    }

    /// The fastest setting is the one that is asked for; digits that nothing reaches are said to be so.
    #[test]
    fn the_page_says_what_is_fastest() {
        let curves = vec![
            Curve { name: "a".to_owned(), rows: vec![row(1.0, 1e-2), row(3.0, 1e-7)] },
            Curve { name: "b".to_owned(), rows: vec![row(2.0, 1e-4)] },
        ];
        let (name, question, unit, error) = ("none", "Which?", "s", "error");
        let study = Study {
            name,
            question,
            about: "About.".to_owned(),
            unit,
            error,
            digits: &[3, 6, 10],
            curves,
            notes: vec![],
        };
        let text = text(&study, "").expect("a text");
        assert!(text.contains("For 3 digits: **b, 2**") && text.contains("For 6 digits: **a, 3**"), "{text}");
        assert!(text.contains("For 10 digits: none"), "{text}");
    }
}

//! Runs every scene and writes a gallery: each picture beside the paper's numbers and the measured ones.
//!
//! The page is static HTML in `target/figures/` (`target/figures-quick/` with `--quick`). A scene that misses an expectation fails the
//! command after all scenes have run.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::{Context, Result, ensure};
use serde_json::Value;

use crate::shell;

/// The results of one scene.
struct Entry {
    name: String,
    folder: PathBuf,
    summary: Option<Value>,
    seconds: f64,
    failed: bool,
}

/// Runs the scenes named (file names without ending), or all, and writes the gallery.
pub fn run(quick: bool, threads: usize, names: &[String]) -> Result<()> {
    let scenes = list(names)?;
    shell::run(shell::cargo().args(["build", "--quiet", "--release", "-p", "mollis-cli"]))?;
    let program = shell::target().join("release").join("mollis");
    let gallery = shell::target().join(if quick { "figures-quick" } else { "figures" });
    std::fs::create_dir_all(&gallery).with_context(|| format!("{}", gallery.display()))?;
    let mut entries = Vec::new();
    for scene in &scenes {
        let name = scene.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
        let folder = gallery.join(&name);
        // Results of an earlier run must not be taken for those of this run.
        let _ = std::fs::remove_file(folder.join("summary.json"));
        let mut command = shell::program(&program);
        command.arg("run").arg(scene).arg("--out").arg(&folder).args(["--threads", &threads.to_string(), "--quiet"]);
        if quick {
            command.arg("--quick");
        }
        let clock = Instant::now();
        let status = command.status().with_context(|| format!("{}", program.display()))?;
        let summary = std::fs::read_to_string(folder.join("summary.json")).ok();
        let summary = summary.map(|text| serde_json::from_str(&text)).transpose().context("summary.json")?;
        let seconds = clock.elapsed().as_secs_f64();
        println!("{:<8} {seconds:7.1} s  {name}", if status.success() { "met" } else { "NOT MET" });
        entries.push(Entry { name, folder, summary, seconds, failed: !status.success() });
    }
    let page = gallery.join("index.html");
    std::fs::write(&page, html(&entries, quick, &gallery)).with_context(|| format!("{}", page.display()))?;
    println!(
        "{} scenes in {:.1} min; {}",
        entries.len(),
        entries.iter().map(|e| e.seconds).sum::<f64>() / 60.0,
        page.display()
    );
    let failed: Vec<&str> = entries.iter().filter(|entry| entry.failed).map(|entry| entry.name.as_str()).collect();
    ensure!(failed.is_empty(), "{} of {} scenes failed: {}", failed.len(), entries.len(), failed.join(", "));
    Ok(())
}

fn list(names: &[String]) -> Result<Vec<PathBuf>> {
    let folder = shell::root().join("scenes");
    let mut scenes: Vec<PathBuf> = std::fs::read_dir(&folder)
        .with_context(|| format!("{}", folder.display()))?
        .map(|entry| Ok(entry?.path()))
        .collect::<Result<_>>()?;
    scenes.retain(|path| path.extension().is_some_and(|ending| ending == "toml"));
    scenes.sort();
    if !names.is_empty() {
        let stem = |path: &Path| path.file_stem().map(|stem| stem.to_string_lossy().into_owned());
        for name in names {
            ensure!(scenes.iter().any(|path| stem(path).as_ref() == Some(name)), "no scene {name}");
        }
        scenes.retain(|path| stem(path).is_some_and(|stem| names.contains(&stem)));
    }
    ensure!(!scenes.is_empty(), "no scene in {}", folder.display());
    Ok(scenes)
}

const HEAD: &str = "<!doctype html><html lang=\"en\"><meta charset=\"utf-8\"><title>mollis: the papers' figures</title><style>\
body{font:16px/1.5 system-ui,sans-serif;max-width:1500px;margin:2em auto;padding:0 1em;color:#222}\
section{border-top:1px solid #ccc;margin-top:2.5em}img{max-width:100%;border:1px solid #eee}\
.pictures{display:flex;flex-wrap:wrap;gap:1em}.pictures figure{margin:0;flex:0 1 460px}figcaption{font-size:14px}\
table{border-collapse:collapse;margin:1em 0;font-size:14px}td,th{padding:.2em .7em;text-align:left;border-bottom:1px solid #ddd}\
.no{background:#222;color:#fff;font-weight:bold}p.source{color:#555}</style>\n";

fn html(entries: &[Entry], quick: bool, gallery: &Path) -> String {
    let mut page = String::from(HEAD);
    let size = if quick { " (quick sizes)" } else { "" };
    let _ = writeln!(page, "<h1>The papers' figures{size}</h1>");
    let _ = writeln!(
        page,
        "<p>Made by <code>cargo xtask figures</code>. Each table holds what the paper states, what is expected, and what the run gave.</p><ul>"
    );
    for entry in entries {
        let verdict = if entry.failed { " <span class=\"no\">not met</span>" } else { "" };
        let _ = writeln!(page, "<li><a href=\"#{0}\">{1}</a>{verdict}</li>", entry.name, title(entry));
    }
    page.push_str("</ul>\n");
    for entry in entries {
        section(&mut page, entry, gallery);
    }
    page.push_str("</html>\n");
    page
}

fn text<'a>(value: &'a Value, key: &str) -> &'a str {
    value.get(key).and_then(Value::as_str).unwrap_or("")
}

fn title(entry: &Entry) -> String {
    let title = entry.summary.as_ref().map_or("", |summary| text(summary, "title"));
    escaped(if title.is_empty() { &entry.name } else { title })
}

fn section(page: &mut String, entry: &Entry, gallery: &Path) {
    let _ = writeln!(page, "<section id=\"{}\"><h2>{}</h2>", entry.name, title(entry));
    let Some(summary) = &entry.summary else {
        let _ = writeln!(page, "<p class=\"no\">The scene did not run to its end.</p></section>");
        return;
    };
    let _ = writeln!(
        page,
        "<p class=\"source\">{}; <code>scenes/{}.toml</code>, {:.1} s</p><p>{}</p><div class=\"pictures\">",
        escaped(text(summary, "source")),
        entry.name,
        entry.seconds,
        escaped(text(summary, "note"))
    );
    let folder = entry.folder.strip_prefix(gallery).unwrap_or(&entry.folder).display().to_string();
    for picture in list_of(summary, "pictures") {
        let (name, title) = (text(picture, "name"), escaped(text(picture, "title")));
        let _ = writeln!(
            page,
            "<figure><a href=\"{folder}/{name}.svg\"><img src=\"{folder}/{name}.png\" alt=\"{title}\"></a><figcaption>{title}</figcaption></figure>"
        );
    }
    page.push_str("</div>\n");
    study(page, summary);
    let rows = list_of(summary, "expectations");
    if !rows.is_empty() {
        page.push_str("<table><tr><th>quantity</th><th>the paper states</th><th>expected</th><th>ours</th><th></th><th>why</th></tr>\n");
    }
    for row in rows {
        let number = |key: &str| row.get(key).and_then(Value::as_f64);
        let expected = match (number("least"), number("most")) {
            (Some(low), Some(high)) => format!("{low:.5} to {high:.5}"),
            (Some(low), None) => format!("at least {low:.5}"),
            (None, Some(high)) => format!("at most {}", short(high)),
            (None, None) => String::new(),
        };
        let expected = if expected.starts_with("0.000") {
            format!("{} to {}", short(number("least").unwrap_or(0.0)), short(number("most").unwrap_or(0.0)))
        } else {
            expected
        };
        let passed = row.get("passed").and_then(Value::as_bool).unwrap_or(false);
        let place = ["case", "part", "at", "from", "to"].iter().filter_map(|key| match row.get(*key) {
            Some(Value::String(name)) => Some(name.clone()),
            Some(Value::Number(number)) if *key != "part" || number.as_u64() != Some(0) => {
                Some(format!("{key} {number}"))
            }
            _ => None,
        });
        let _ = writeln!(
            page,
            "<tr><td>{} {}</td><td>{}</td><td>{expected}</td><td>{}</td><td{}</td><td>{}</td></tr>",
            escaped(text(row, "quantity")),
            escaped(&place.collect::<Vec<_>>().join(", ")),
            escaped(text(row, "paper")),
            number("value").map_or("not a number".to_owned(), short),
            if passed { ">met" } else { " class=\"no\">NOT MET" },
            escaped(text(row, "reason"))
        );
    }
    page.push_str(if rows.is_empty() { "</section>\n" } else { "</table></section>\n" });
}

/// The table of a convergence study.
fn study(page: &mut String, summary: &Value) {
    for case in list_of(summary, "cases") {
        let rows = list_of(case, "study");
        if rows.is_empty() {
            continue;
        }
        let _ = writeln!(
            page,
            "<table><tr><th>{} h</th><th>particles</th><th>positions</th><th>rate</th><th>density</th><th>rate</th></tr>",
            escaped(text(case, "name"))
        );
        for row in rows {
            let number = |key: &str| row.get(key).and_then(Value::as_f64).map_or(String::new(), short);
            let keys = ["h", "particles", "error_positions", "rate_positions", "error_density", "rate_density"];
            let cells: Vec<String> = keys.iter().map(|key| format!("<td>{}</td>", number(key))).collect();
            let _ = writeln!(page, "<tr>{}</tr>", cells.concat());
        }
        page.push_str("</table>\n");
    }
}

fn list_of<'a>(value: &'a Value, key: &str) -> &'a [Value] {
    value.get(key).and_then(Value::as_array).map_or(&[], Vec::as_slice)
}

/// A number in its shorter readable form.
fn short(value: f64) -> String {
    if value != 0.0 && (value.abs() < 1e-3 || value.abs() >= 1e6) {
        format!("{value:.3e}")
    } else {
        format!("{}", (value * 1e4).round() / 1e4)
    }
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

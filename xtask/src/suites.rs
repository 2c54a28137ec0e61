//! Runs all suites, the cheapest first, and prints a table of minutes and one line with the sums.

use std::fs::File;
use std::sync::Mutex;
use std::time::Instant;

use anyhow::{Context, Result, bail};

use crate::{avx512, coverage, examples, features, firmware, header, install, layers, python, shell, symbols};

/// Numbers of passed and failed tests.
#[derive(Clone, Copy, Default)]
struct Count {
    passed: usize,
    failed: usize,
}

/// Name, description, function.
type Suite = (&'static str, &'static str, fn() -> Result<Count>);

/// These keep all processors busy.
const SUITES: &[Suite] = &[
    ("format", "the source is as rustfmt leaves it", || {
        checked(shell::run(shell::cargo().args(["fmt", "--all", "--check"])))
    }),
    ("layers", "uses point down and close no circle, unsafe stays in its modules", || checked(layers::run())),
    ("header", "the header is what the source makes", || checked(header::run(true))),
    ("coverage", "each function of the header is called by a test", || checked(coverage::run())),
    ("lints", "clippy finds nothing, the libraries' documentation builds without a warning", || {
        counted(lints_and_docs())
    }),
    ("unit", "cargo test", cargo_test),
    ("avx512", "the widest instructions compute what they should, if this processor has them", || {
        counted(avx512::here())
    }),
    ("features", "each combination of features builds", || checked(features::run())),
    ("symbols", "nothing but memory functions is needed", || checked(symbols::run())),
];

/// These wait for one compiler, linker or program after the other, once `symbols` has built the libraries: two run at a time.
const PAIRED: &[Suite] = &[
    ("install", "programs find the libraries where they are installed", || counted(install::check())),
    ("python", "the wheel builds, installs and passes its tests", || counted(python::check())),
    ("languages", "the header and programs in C, C++ and Fortran", || counted(languages())),
    ("firmware", "bare machines give the host's bits, hold no panic and keep to their flash and stack", || {
        counted(firmware::run())
    }),
    ("valgrind", "the C programs touch no memory that is not theirs", || counted(examples::all(true))),
];

/// A line of the table: name, result, minutes.
type Row = (&'static str, Count, f64);

/// Runs the suites named, or all.
pub fn run(names: &[String]) -> Result<()> {
    if let Some(unknown) = names.iter().find(|n| !SUITES.iter().chain(PAIRED).any(|(name, ..)| name == n)) {
        let known: Vec<_> = SUITES.iter().chain(PAIRED).map(|(name, ..)| *name).collect();
        bail!("no suite `{unknown}`; there are {}", known.join(", "));
    }
    let chosen = |(name, ..): &&Suite| names.is_empty() || names.iter().any(|n| n == name);
    let mut rows: Vec<Row> = SUITES.iter().filter(chosen).map(|suite| timed(suite, here)).collect();
    match PAIRED.iter().filter(chosen).collect::<Vec<_>>()[..] {
        [one] => rows.push(timed(one, here)),
        ref several => rows.extend(two_at_a_time(several)),
    }
    print!("\n{TABLE}");
    let mut sum = Count::default();
    for (name, count, minutes) in &rows {
        println!("{name:<12} {:>7} {:>7} {minutes:>8.2}", count.passed, count.failed);
        sum = Count { passed: sum.passed + count.passed, failed: sum.failed + count.failed };
    }
    println!("\n{} passed, {} failed", sum.passed, sum.failed);
    if sum.failed > 0 {
        std::process::exit(1);
    }
    Ok(())
}

const TABLE: &str = "suite         passed  failed  minutes\n";

fn timed(suite: &Suite, run: fn(&Suite) -> Result<Count>) -> Row {
    let start = Instant::now();
    let count = run(suite).unwrap_or_else(|error| {
        println!("{} failed: {error:#}", suite.0);
        Count { passed: 0, failed: 1 }
    });
    (suite.0, count, start.elapsed().as_secs_f64() / 60.0)
}

fn here(&(name, about, suite): &Suite) -> Result<Count> {
    println!("\n== {name}: {about}");
    suite()
}

fn two_at_a_time(suites: &[&Suite]) -> Vec<Row> {
    let (next, rows) = (Mutex::new(suites.iter()), Mutex::new(Vec::new()));
    let take = || next.lock().expect("no thread panics").next();
    std::thread::scope(|scope| {
        for _ in 0..2 {
            scope.spawn(|| {
                while let Some(suite) = take() {
                    let row = timed(suite, by_itself);
                    rows.lock().expect("no thread panics").push(row);
                }
            });
        }
    });
    rows.into_inner().expect("no thread panics")
}

/// Runs a suite by a program of its own, and prints what that wrote when it ends.
fn by_itself(&(name, ..): &Suite) -> Result<Count> {
    let log = shell::scratch("suites")?.join(name).with_extension("log");
    let file = File::create(&log)?;
    let mut program = shell::program(std::env::current_exe()?);
    program.args(["test", name]).stdout(file.try_clone()?).stderr(file);
    program.status()?;
    let text = shell::read(&log)?;
    let (output, table) = text.rsplit_once(TABLE).with_context(|| format!("it ended early:\n{text}"))?;
    print!("{output}");
    let numbers: Vec<_> = table.lines().last().unwrap_or_default().split(' ').map(str::parse).collect();
    let [Ok(passed), _, Ok(failed), _] = numbers[..] else { bail!("its last line has changed") };
    Ok(Count { passed, failed })
}

fn checked(result: Result<()>) -> Result<Count> {
    counted(result.map(|()| 1))
}

fn counted(result: Result<usize>) -> Result<Count> {
    result.map(|passed| Count { passed, failed: 0 })
}

/// Each keeps one core busy, so they run at the same time, in folders of their own.
fn lints_and_docs() -> Result<usize> {
    std::thread::scope(|scope| {
        let docs = scope.spawn(docs);
        lints()?;
        docs.join().ok().context("a thread failed")?
    })?;
    Ok(2)
}

fn lints() -> Result<()> {
    shell::run(shell::cargo().args(["clippy", "--quiet", "--workspace", "--all-targets", "--", "-Dwarnings"]))
}

/// Of what other programs link. (`ffi` has no items of its own.)
fn docs() -> Result<()> {
    let mut cargo = shell::cargo();
    cargo.args([
        "doc",
        "--quiet",
        "--no-deps",
        "-p",
        "mollis-core",
        "-p",
        "mollis-abi",
        "-p",
        "mollis-mt",
        "-p",
        "mollis-host",
    ]);
    cargo.arg("--target-dir").arg(shell::target().join("docs"));
    shell::run(cargo.env("RUSTDOCFLAGS", "-Dwarnings"))
}

/// Runs `cargo test` and adds up its results.
fn cargo_test() -> Result<Count> {
    let (succeeded, text) = shell::tee(shell::cargo().args(["test", "--no-fail-fast"]))?;
    let mut count = Count::default();
    for line in text.lines().filter_map(|line| line.strip_prefix("test result: ")) {
        let number = |word: &str| -> Result<usize> {
            let part = line.split([';', '.']).find_map(|part| part.trim().strip_suffix(word));
            part.context("cargo test's summary has changed")?.trim().parse().context("not a number")
        };
        count.passed += number("passed")?;
        count.failed += number("failed")?;
    }
    // A test program that crashes or does not compile prints no summary.
    if !succeeded && count.failed == 0 {
        count.failed = 1;
    }
    if count.passed == 0 && count.failed == 0 {
        bail!("cargo test ran nothing");
    }
    Ok(count)
}

fn languages() -> Result<usize> {
    Ok(examples::header()? + examples::all(false)?)
}

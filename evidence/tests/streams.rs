//! Closed pipes, full disks and options out of range: a study says so, or ends quietly, and never panics.
#![cfg(unix)]

use std::process::{Command, Output, Stdio};

fn evidence(arguments: &[&str], standard_output: impl Into<Stdio>) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_mollis-evidence"));
    command.args(arguments).stdout(standard_output).output().unwrap()
}

fn errors(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

const DATA: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../tests/data/gaussian.csv");

#[test]
fn a_closed_pipe_ends_quietly() {
    for arguments in
        [&["--help"][..], &["converge", "--list"], &["verify", DATA], &["pks-check", "hitting", "--particles", "2"]]
    {
        let (reader, writer) = std::io::pipe().unwrap();
        drop(reader);
        let output = evidence(arguments, writer);
        assert_eq!((output.status.code(), errors(&output).as_str()), (Some(141), ""), "{arguments:?}");
    }
}

#[test]
#[cfg(target_os = "linux")]
fn a_full_device_is_an_error_that_is_named() {
    let output = evidence(&["steady", "--list"], std::fs::File::create("/dev/full").unwrap());
    assert_eq!(output.status.code(), Some(1));
    assert!(errors(&output).starts_with("evidence: standard output: No space left"), "{}", errors(&output));
}

#[test]
fn options_out_of_range_are_refused() {
    for threads in ["0", "257"] {
        let output = evidence(&["pks-check", "hitting", "--threads", threads], Stdio::null());
        assert_eq!(output.status.code(), Some(2), "{threads}");
    }
}

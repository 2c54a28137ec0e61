//! Closed pipes, full disks and numbers out of range: the command says so, or ends quietly, and never panics.
#![cfg(unix)]

use std::fs::File;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

mod common;

use common::{folder, mollis, succeeded, text};

/// A short scene of particles that need no merging, written into a folder.
fn scene(folder: &Path) -> PathBuf {
    let path = folder.join("scene.toml");
    let text = r#"
title = "streams"
model = "blob"
dimension = 2
[[kernel]]
kind = "power"
p = 3
[mollifier]
kind = "compact"
order = 4
[[initial]]
shape = "polynomial"
k = 2
[sampling]
kind = "grid"
h = 0.1
[time]
end = 0.04
dt = 0.01
[[expect]]
quantity = "centre_drift"
most = 1e-12
reason = "conserved"
"#;
    std::fs::write(&path, text).unwrap();
    path
}

fn errors(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// Standard output whose reader has gone already.
fn closed() -> Stdio {
    let (reader, writer) = std::io::pipe().unwrap();
    drop(reader);
    writer.into()
}

/// Everything that is in a folder, below it too.
fn files(folder: &Path) -> Vec<String> {
    let mut names = Vec::new();
    for entry in std::fs::read_dir(folder).unwrap() {
        let entry = entry.unwrap();
        names.push(entry.file_name().into_string().unwrap());
        if entry.path().is_dir() {
            names.extend(files(&entry.path()));
        }
    }
    names.sort();
    names
}

#[test]
fn a_closed_pipe_ends_quietly() {
    let folder = folder("closed");
    let scene = scene(&folder);
    for arguments in
        [&["--help"][..], &["--version"], &["scene", "--schema"], &["scene", text(&scene)], &["plan", text(&scene)]]
    {
        let output = mollis(arguments).stdout(closed()).output().unwrap();
        assert_eq!((output.status.code(), errors(&output).as_str()), (Some(141), ""), "{arguments:?}");
    }
    // A run ends as it would with a reader: everything is written by then.
    let out = folder.join("out");
    let output = mollis(&["run", text(&scene), "--out", text(&out)]).stdout(closed()).output().unwrap();
    assert_eq!((output.status.code(), errors(&output).as_str()), (Some(0), ""));
    assert!(out.join("summary.json").exists() && out.join("particles.npy").exists());
    let missed = std::fs::read_to_string(&scene).unwrap().replace("most = 1e-12", "least = 1");
    std::fs::write(&scene, missed).unwrap();
    let output = mollis(&["run", text(&scene), "--out", text(&out)]).stdout(closed()).output().unwrap();
    assert!(output.status.code() == Some(1) && errors(&output).contains("1 of 1 expectations not met"));
}

#[test]
#[cfg(target_os = "linux")]
fn a_full_device_is_an_error_that_is_named() {
    let folder = folder("full");
    let scene = scene(&folder);
    let full = || Stdio::from(File::create("/dev/full").unwrap());
    let out = folder.join("out");
    for arguments in
        [&["--help"][..], &["scene", "--schema"], &["plan", text(&scene)], &["run", text(&scene), "--out", text(&out)]]
    {
        let output = mollis(arguments).stdout(full()).output().unwrap();
        assert_eq!(output.status.code(), Some(1), "{arguments:?}");
        assert!(errors(&output).starts_with("mollis: standard output: No space left"), "{}", errors(&output));
    }
    assert!(out.join("summary.json").exists());
    // Where errors can't be written either, the status says it.
    for (arguments, code) in [(&["scene", "/nowhere.toml"][..], 1), (&["run"], 2), (&["run", "/nowhere.toml"], 1)] {
        let output = mollis(arguments).stdout(full()).stderr(full()).output().unwrap();
        assert_eq!(output.status.code(), Some(code), "{arguments:?}");
    }
}

/// The command where no file may grow beyond `blocks` of 512 or 1024 bytes: a write fails as on a full disk.
fn limited(blocks: u32, arguments: &[&str]) -> Output {
    let shell = format!("trap '' XFSZ; ulimit -f {blocks}; exec \"$0\" \"$@\"");
    let mut command = Command::new("sh");
    command.args(["-c", &shell, env!("CARGO_BIN_EXE_mollis")]).args(arguments);
    command.output().unwrap()
}

#[test]
fn a_full_disk_names_the_file_and_leaves_no_part_of_it() {
    let folder = folder("disk");
    let scene = scene(&folder);
    // 317 particles: 7.6 kB of coordinates and masses, more than 15 kB of a checkpoint.
    let out = folder.join("checkpoint");
    let arguments = ["run", text(&scene), "--quiet", "--checkpoint-every", "1e-9", "--out", text(&out)];
    let output = limited(12, &arguments);
    assert_eq!(output.status.code(), Some(1), "{}", errors(&output));
    assert!(errors(&output).contains("checkpoint.mollis: File too large"), "{}", errors(&output));
    assert_eq!(files(&out), [""; 0]);
    // A good checkpoint stays when the next can't be written.
    std::fs::write(out.join("checkpoint.mollis"), b"former").unwrap();
    assert_eq!(limited(12, &arguments).status.code(), Some(1));
    assert_eq!(files(&out), ["checkpoint.mollis"]);
    assert_eq!(std::fs::read(out.join("checkpoint.mollis")).unwrap(), b"former");
    let out = folder.join("particles");
    let output = limited(4, &["run", text(&scene), "--quiet", "--checkpoint-every", "inf", "--out", text(&out)]);
    assert_eq!(output.status.code(), Some(1), "{}", errors(&output));
    assert!(errors(&output).contains("particles.npy: File too large"), "{}", errors(&output));
    assert!(files(&out).contains(&"diagnostics.csv".to_owned()));
    assert!(files(&out).iter().all(|name| name != "particles.npy" && !name.ends_with(".new")), "{:?}", files(&out));
}

#[test]
fn options_out_of_range_are_refused() {
    let folder = folder("options");
    let scene = scene(&folder);
    let out = folder.join("out");
    let run = |options: &[&str]| {
        let mut arguments = vec!["run", text(&scene), "--quiet", "--out", text(&out)];
        arguments.extend(options);
        mollis(&arguments).output().unwrap()
    };
    for options in [
        ["--checkpoint-every", "inf"],
        ["--checkpoint-every", "1e300"],
        ["--checkpoint-every", "1e-300"],
        ["--threads", "64"],
    ] {
        succeeded(&run(&options));
    }
    for options in [
        ["--checkpoint-every", "0"],
        ["--checkpoint-every", "nan"],
        ["--checkpoint-every=-1", "--quick"],
        ["--threads", "100000"],
        ["--threads", "257"],
        ["--threads=-1", "--quick"],
        ["--seed=-1", "--quick"],
    ] {
        let output = run(&options);
        assert!(output.status.code() == Some(2) && errors(&output).contains("error: invalid value"), "{options:?}");
    }
    assert_eq!(mollis(&["plan", text(&scene), "--threads", "100000"]).output().unwrap().status.code(), Some(2));
}

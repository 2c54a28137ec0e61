//! Static libraries whose only global names are those of their headers.
//!
//! The archive that Rust writes also defines the functions that its compiler calls, and those of std, as globals. A program that links it with all its
//! members (`--whole-archive`) beside another Rust library would have them twice. The members are therefore linked into one relocatable object, whose
//! other names are made local.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result};

use crate::shell;

/// Makes an archive of the same name that holds `functions` and what they need.
pub fn closed(archive: &Path, functions: &[String]) -> Result<PathBuf> {
    let folder = shell::scratch("archive")?;
    let name = archive.file_name().context("no name")?;
    let (machine, linked) = (folder.join("machine.a"), folder.join("linked.o"));
    let (list, undefined) = (folder.join("functions.txt"), folder.join("undefined.txt"));
    let (object, out) = (folder.join(name).with_extension("o"), folder.join(name));
    std::fs::write(&list, functions.join("\n"))?;
    // Rust's run-time library also holds LLVM's bitcode. With a plugin for it, binutils would read that instead of the machine's code.
    let mut objcopy = shell::program("objcopy");
    objcopy.args(["--remove-section=.llvmbc", "--remove-section=.llvmcmd"]);
    shell::run(objcopy.arg(archive).arg(&machine))?;
    // `--gc-sections` keeps what the functions reach, so that no part of std that nothing uses asks the program for further libraries.
    // Section groups are dissolved: linkers keep one group of each name, and would take another library's in place of the one that local names refer to.
    let mut ld = shell::program("ld");
    ld.args(["--relocatable", "--gc-sections", "--force-group-allocation", "-o"]).arg(&linked);
    shell::run(ld.args(functions.iter().map(|name| format!("--undefined={name}"))).arg(&machine))?;
    // What only discarded sections needed is still named, and no longer as weak: a program would have to offer it.
    let listed = shell::output(shell::program("nm").args(["--undefined-only", "--format=posix"]).arg(&linked))?;
    let names: Vec<_> = listed.lines().filter_map(|line| line.split(' ').next()).collect();
    // objcopy refuses an empty file.
    std::fs::write(&undefined, names.join("\n") + "\n")?;
    let mut objcopy = shell::program("objcopy");
    objcopy.arg(format!("--keep-global-symbols={}", list.display()));
    objcopy.arg(format!("--strip-unneeded-symbols={}", undefined.display()));
    shell::run(objcopy.arg(&linked).arg(&object))?;
    // `ar` adds to an archive that exists.
    if out.exists() {
        std::fs::remove_file(&out)?;
    }
    shell::run(shell::program("ar").arg("rcsD").arg(&out).arg(&object))?;
    for file in [machine, linked, object] {
        std::fs::remove_file(file)?;
    }
    Ok(out)
}

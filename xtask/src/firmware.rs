//! Runs the programs of `tests/firmware/` on bare machines in QEMU. They must give the same bits as on the host; their size and stack are measured.

use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, bail, ensure};

use crate::{shell, symbols, tools};

/// A bare machine.
struct Machine {
    name: &'static str,
    target: &'static str,
    /// Prefix of the cross tools.
    tools: &'static str,
    flags: &'static [&'static str],
    qemu: &'static [&'static str],
    needs: &'static [(&'static str, &'static str)],
    /// Whether the limits of flash and stack apply to this machine.
    limited: bool,
}

const MACHINES: [Machine; 2] = [
    Machine {
        name: "cortex_m4f",
        target: "thumbv7em-none-eabihf",
        tools: "arm-none-eabi-",
        flags: &["-mcpu=cortex-m4", "-mthumb", "-mfpu=fpv4-sp-d16", "-mfloat-abi=hard"],
        qemu: &["qemu-system-arm", "-machine", "mps2-an386"],
        needs: &[("arm-none-eabi-gcc", "gcc-arm-none-eabi"), ("qemu-system-arm", "qemu-system-arm")],
        limited: true,
    },
    Machine {
        name: "rv32imafc",
        target: "riscv32imafc-unknown-none-elf",
        tools: "riscv64-unknown-elf-",
        flags: &["-march=rv32imafc_zicsr", "-mabi=ilp32f", "-mcmodel=medany"],
        qemu: &["qemu-system-riscv32", "-machine", "virt", "-bios", "none"],
        needs: &[("riscv64-unknown-elf-gcc", "gcc-riscv64-unknown-elf"), ("qemu-system-riscv32", "qemu-system-misc")],
        limited: false,
    },
];

/// A program and its limit of flash in bytes on the Cortex-M4F, startup included. `refusals` has no limit: it links the functions of all
/// other programs, as no firmware does.
const PROGRAMS: &[(&str, u64)] =
    &[("mollifier", 8 * 1024), ("blob", 16 * 1024), ("pks", 32 * 1024), ("refusals", u64::MAX)];
/// The deepest stack that a program may use there, in bytes.
const STACK: u64 = 3072;
/// The features of the library for firmware.
const FEATURES: &str = "small";

/// When it optimises for size, the compiler inlines too few short functions: each step of an iterator becomes a call.
const INLINING: &str = "-Cllvm-args=--inline-threshold=55";

/// Builds, runs, compares and measures all programs on all machines, and compares sizes. Returns the number of checks.
pub fn run() -> Result<usize> {
    tools::need(&[("gcc", "gcc")])?;
    let host = symbols::build()?.join("libmollis.a");
    let (mut rows, mut faults) = (Vec::new(), Vec::new());
    sizes_agree(&host)?;
    for machine in &MACHINES {
        tools::need(machine.needs)?;
        let library = library(machine.target)?;
        for &(program, limit) in PROGRAMS {
            let want = host_output(program, &host)?;
            let image = link(machine, program, &library)?;
            let got = output(Command::new("timeout").arg("60").args(machine.qemu).args(QEMU).arg(&image))?;
            let (values, measures) = split(&got);
            let same = values == split(&want).0;
            if !same {
                faults.push(format!(
                    "{program} on {} prints other bits than on the host: see {}",
                    machine.name,
                    image.display()
                ));
            }
            let [text, data, bss] = sizes(machine, &image)?;
            let flash = text + data;
            let stack = measures.iter().find(|(name, _)| name == "stack").context("no line `#stack`")?.1;
            if machine.limited && flash > limit {
                faults.push(format!("{program} on {} takes {flash} bytes of flash, more than {limit}", machine.name));
            }
            if machine.limited && stack > STACK {
                faults.push(format!("{program} on {} takes {stack} bytes of stack, more than {STACK}", machine.name));
            }
            faults.extend(
                held(machine, &image)?.into_iter().map(|name| format!("{program} on {} holds {name}", machine.name)),
            );
            let counts = measures.iter().filter(|(name, _)| name != "stack").map(|(name, n)| format!("{name} {n}"));
            let lines = values.lines().count();
            rows.push((
                program,
                machine.name,
                lines,
                same,
                flash,
                data + bss,
                stack,
                counts.collect::<Vec<_>>().join(", "),
            ));
        }
    }
    println!(
        "{:<10} {:<10} {:>6} {:>5} {:>6} {:>6} {:>6}  instructions",
        "program", "machine", "lines", "same", "flash", "RAM", "stack"
    );
    for (program, machine, lines, same, flash, ram, stack, counts) in &rows {
        let same = if *same { "yes" } else { "NO" };
        println!("{program:<10} {machine:<10} {lines:>6} {same:>5} {flash:>6} {ram:>6} {stack:>6}  {counts}");
    }
    ensure!(faults.is_empty(), "{}", faults.join("\n"));
    Ok(rows.len() + 1)
}

/// With these options an instruction takes one nanosecond of virtual time, so the clocks of the machines count instructions.
const QEMU: &[&str] = &[
    "-icount",
    "shift=0",
    "-display",
    "none",
    "-serial",
    "none",
    "-monitor",
    "none",
    "-semihosting-config",
    "enable=on,target=native",
    "-kernel",
];

/// Builds the static library for a bare target. Uses rustup if it has the target, otherwise Debian's compiler with the source
/// of `core`.
fn library(target: &str) -> Result<PathBuf> {
    let folder = shell::target().join("firmware");
    let sysroot = shell::output(shell::program("rustc").args(["--print", "sysroot"]))?;
    let by_rustup = Path::new(sysroot.trim()).join("lib/rustlib").join(target).is_dir();
    let mut cargo = if by_rustup {
        shell::cargo()
    } else {
        tools::need(&[
            ("/usr/bin/rustc", "rustc-web"),
            ("/usr/bin/cargo", "cargo-web"),
            ("/usr/lib/rustlib/src/rust/library/core/Cargo.toml", "rust-web-src"),
        ])?;
        let mut cargo = shell::program("/usr/bin/cargo");
        // Building `core` needs unstable options. This variable enables them, for the compiler that built this source.
        cargo.env("RUSTC_BOOTSTRAP", "1").env("RUSTC", "/usr/bin/rustc").env_remove("RUSTUP_TOOLCHAIN");
        cargo
    };
    cargo.args(["rustc", "--quiet", "--package", "mollis", "--crate-type", "staticlib", "--profile", "embedded"]);
    cargo.args(["--no-default-features", "--features", FEATURES, "--target", target, "--target-dir"]).arg(&folder);
    // Code that only other features use would be reported as dead.
    cargo.env("RUSTFLAGS", "-Adead_code");
    if !by_rustup {
        cargo.args(["-Z", "build-std=core"]);
    }
    cargo.args(["--", INLINING]);
    shell::run(&mut cargo).with_context(|| format!("cannot build for {target}"))?;
    Ok(folder.join(target).join("embedded/libmollis.a"))
}

/// Compares the header's macros for static buffers with the size queries.
fn sizes_agree(library: &Path) -> Result<()> {
    let image = shell::scratch("firmware")?.join("sizes");
    let mut gcc = shell::program("gcc");
    gcc.args(["-std=c11", "-Wall", "-Wextra", "-Werror", "-O1", "-Iinclude"]).args(sources(&["sizes"]));
    shell::run(gcc.arg(library).arg("-o").arg(&image))?;
    print!("{}", output(&mut shell::program(image)).context("a macro for static buffers differs from its size query")?);
    Ok(())
}

/// The output of the program on this machine.
fn host_output(program: &str, library: &Path) -> Result<String> {
    let image = shell::scratch("firmware")?.join(format!("{program}_host"));
    let mut gcc = shell::program("gcc");
    gcc.args(["-std=c11", "-Wall", "-Wextra", "-Werror", "-O1", "-Iinclude"])
        .args(sources(&[program, "report", "host"]));
    shell::run(gcc.arg(library).arg("-o").arg(&image))?;
    output(&mut shell::program(image))
}

fn sources(names: &[&str]) -> Vec<String> {
    names.iter().map(|name| format!("tests/firmware/{name}.c")).collect()
}

/// Links a program for a machine.
fn link(machine: &Machine, program: &str, library: &Path) -> Result<PathBuf> {
    let image = shell::scratch("firmware")?.join(format!("{program}_{}.elf", machine.name));
    let mut gcc = shell::program(format!("{}gcc", machine.tools));
    gcc.args(machine.flags);
    gcc.args(["-Os", "-g", "-std=c11", "-Wall", "-Wextra", "-Werror", "-ffreestanding", "-ffunction-sections"]);
    gcc.args(["-fdata-sections", "-fno-tree-loop-distribute-patterns", "-Iinclude"]);
    gcc.args(sources(&[program, "report", "machine", machine.name])).arg(library);
    gcc.args(["-nostartfiles", "-nostdlib", "-Wl,--gc-sections", "-Wl,-z,noexecstack", "-Wl,--no-warn-rwx-segments"]);
    gcc.arg("-T").arg(format!("tests/firmware/{}.ld", machine.name)).arg("-o").arg(&image);
    shell::run(&mut gcc)?;
    Ok(image)
}

/// Standard output and standard error together: QEMU writes the console of a program to the latter.
fn output(command: &mut Command) -> Result<String> {
    let output = command.output().with_context(|| format!("cannot start {:?}", command.get_program()))?;
    let text = [output.stdout, output.stderr].concat();
    let text = String::from_utf8_lossy(&text).into_owned();
    ensure!(output.status.success(), "{:?} failed ({}):\n{text}", command.get_program(), output.status);
    Ok(text)
}

/// Separates values, which must be equal on all machines, from measurements, which are lines `#name number`.
fn split(text: &str) -> (String, Vec<(String, u64)>) {
    let (mut values, mut measures) = (String::new(), Vec::new());
    for line in text.lines() {
        match line.strip_prefix('#').and_then(|rest| rest.rsplit_once(' ')) {
            Some((name, number)) => measures.push((name.to_owned(), number.parse().unwrap_or(u64::MAX))),
            None => {
                values.push_str(line);
                values.push('\n');
            }
        }
    }
    (values, measures)
}

/// Bytes of text, data and bss.
fn sizes(machine: &Machine, image: &Path) -> Result<[u64; 3]> {
    let listed = shell::output(shell::program(format!("{}size", machine.tools)).arg(image))?;
    let row = listed.lines().nth(1).context("size prints no row")?;
    let mut columns = row.split_whitespace().map(|word| word.parse::<u64>());
    let mut next = || columns.next().context("size prints too few columns")?.context("size prints no number");
    Ok([next()?, next()?, next()?])
}

/// Symbols that must not be in an image.
fn held(machine: &Machine, image: &Path) -> Result<Vec<String>> {
    let listed = shell::output(shell::program(format!("{}nm", machine.tools)).arg("--demangle").arg(image))?;
    let names: Vec<_> = listed.lines().filter_map(|line| line.splitn(3, ' ').nth(2)).collect();
    if names.len() < 10 {
        bail!("{} has no symbol table", image.display());
    }
    Ok(names.into_iter().filter(|name| symbols::forbidden(name)).map(str::to_owned).collect())
}

#[cfg(test)]
mod tests {
    #[test]
    fn measures_are_told_from_values() {
        let (values, measures) = super::split("a 1\n#stack 12\n# note 3\nb\n");
        assert_eq!(values, "a 1\nb\n");
        assert_eq!(measures, [("stack".to_owned(), 12), (" note".to_owned(), 3)]);
    }
}

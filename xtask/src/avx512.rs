//! The tests of `tests/tests/levels` at level `avx512`, on this processor if it has the instructions, otherwise in an emulator.
//!
//! The emulator is Debian's Bochs, which emulates a whole machine. It boots a Linux kernel from Debian, whose first program is the statically
//! linked test program. Bochs has these faults:
//!
//! * It reports a wrong size of the saved registers, and Linux then disables AVX. Linux is told to ignore the compact form (`clearcpuid`).
//! * The approximate reciprocal square root of some powers of two is wrong: `xtask/avx512/rsqrt14.c` corrects it.
//! * Gathers and scatters with a high register fail: the compiler is told to emit none.
//!
//! Its exit status carries no information. The result is the text of the serial port.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail, ensure};
use mollis_core::simd::Level;

use crate::{shell, tools};

const TARGET: &str = "x86_64-unknown-linux-musl";
const LAST_LINE: &str = "machine stops with status";

/// Runs the tests if this processor has the instructions, and returns how many passed. In the emulator they take minutes more than the suites have.
pub fn here() -> Result<usize> {
    if Level::Avx512.is_available() {
        return run(false);
    }
    println!("NOT RUN: this processor lacks the instructions. `cargo xtask avx512` runs the tests in an emulator.");
    Ok(0)
}

/// Runs the tests and returns how many passed.
pub fn run(emulate: bool) -> Result<usize> {
    let text = if Level::Avx512.is_available() && !emulate {
        println!("on this processor");
        let mut cargo = shell::cargo();
        // Without naming the package: its features, and so its compiled form, are then those of `cargo test`.
        cargo.env("MOLLIS_LEVEL", Level::Avx512.name()).args(["test", "--test", "all", "levels::"]);
        let (succeeded, text) = shell::tee(&mut cargo)?;
        ensure!(succeeded, "the tests failed");
        text
    } else {
        println!("in an emulator");
        emulated()?
    };
    let results = text.lines().filter_map(|line| line.trim().strip_prefix("test result: ok. "));
    let passed = results.filter_map(|line| line.split(' ').next()?.parse::<usize>().ok()).sum();
    ensure!(passed > 0, "no test ran");
    Ok(passed)
}

fn emulated() -> Result<String> {
    if !cfg!(target_arch = "x86_64") {
        bail!("the emulator's test programs are built on x86_64 only");
    }
    tools::need(&[
        ("bochs-bin", "bochs"),
        ("/usr/share/doc/bochs-term", "bochs-term"),
        ("/usr/share/bochs/BIOS-bochs-latest", "bochsbios"),
        ("/usr/share/bochs/VGABIOS-lgpl-latest", "vgabios"),
        ("xorriso", "xorriso"),
        ("/usr/lib/ISOLINUX/isolinux.bin", "isolinux"),
        ("/usr/lib/syslinux/modules/bios/ldlinux.c32", "syslinux-common"),
        ("/bin/busybox", "busybox-static"),
        ("cc", "gcc"),
    ])?;
    let folder = shell::scratch("avx512")?;
    let program = build()?;
    let image = image(&folder, &program)?;
    boot(&folder, &image)
}

/// Builds the test program for a machine without shared libraries.
fn build() -> Result<PathBuf> {
    shell::run(shell::program("rustup").args(["target", "add", TARGET]))?;
    let mut cargo = shell::cargo();
    // The emulated machine reads it byte by byte: without symbols it is a fifth as long.
    cargo.env("RUSTFLAGS", "-C target-feature=+prefer-no-gather,+prefer-no-scatter -C strip=symbols");
    cargo.args(["test", "--target", TARGET, "-p", "mollis-tests", "--test", "all", "--no-run"]);
    shell::programs(&mut cargo)?.remove("all").context("cargo names no test program")
}

/// Debian's kernel for virtual machines, unpacked but not installed.
fn kernel(folder: &Path) -> Result<PathBuf> {
    let find = || -> Option<PathBuf> {
        let files = fs::read_dir(folder.join("kernel/boot")).ok()?.flatten().map(|entry| entry.path());
        files
            .into_iter()
            .find(|path| path.file_name().is_some_and(|name| name.to_string_lossy().starts_with("vmlinuz")))
    };
    if let Some(found) = find() {
        return Ok(found);
    }
    let depends = || shell::output(shell::program("apt-cache").args(["depends", "linux-image-cloud-amd64"]));
    let name = |text: &str| text.lines().find_map(|line| line.trim().strip_prefix("Depends: ").map(str::to_owned));
    let package = match depends().ok().as_deref().and_then(name) {
        Some(package) => package,
        None => {
            shell::run(shell::program("apt-get").args(["update", "-q"]))?;
            name(&depends()?).context("no kernel package: linux-image-cloud-amd64")?
        }
    };
    let packages = folder.join("packages");
    fs::create_dir_all(&packages)?;
    // Without the user of apt's sandbox, which may not write to this folder.
    let mut apt = shell::program("apt-get");
    apt.args(["download", "-q", "-o", "APT::Sandbox::User=root", &package]).current_dir(&packages);
    shell::run(&mut apt)?;
    let file = fs::read_dir(&packages)?.flatten().last().context("apt-get has brought no package")?.path();
    shell::run(shell::program("dpkg").arg("-x").arg(file).arg(folder.join("kernel")))?;
    find().context("the kernel package holds no kernel")
}

/// A bootable disk whose first program runs the tests and turns the machine off.
fn image(folder: &Path, program: &Path) -> Result<PathBuf> {
    let kernel = kernel(folder)?;
    let (root, disk) = (folder.join("root"), folder.join("disk"));
    for path in [&root, &disk] {
        // Remove files of an earlier run.
        if path.exists() {
            fs::remove_dir_all(path)?;
        }
    }
    for path in ["bin", "proc", "dev", "tmp"].map(|name| root.join(name)).iter().chain([&disk]) {
        fs::create_dir_all(path)?;
    }
    fs::copy("/bin/busybox", root.join("bin/busybox"))?;
    fs::copy(program, root.join("tests"))?;
    let init = root.join("init");
    let script = format!(
        "#!/bin/busybox sh\n\
         busybox mount -t proc proc /proc\n\
         busybox mount -t devtmpfs dev /dev\n\
         export MOLLIS_LEVEL={} MOLLIS_THIN=1\n\
         /tests levels:: --test-threads 1 </dev/null\n\
         echo \"{LAST_LINE} $?\"\n\
         busybox sleep 1\n\
         busybox poweroff -f\n",
        Level::Avx512.name()
    );
    fs::write(&init, script)?;
    shell::run(shell::program("chmod").arg("755").arg(&init))?;
    let archive = format!(
        "cd {} && /bin/busybox find . | /bin/busybox cpio -o -H newc >{} 2>/dev/null",
        quoted(&root)?,
        quoted(&disk.join("initrd"))?
    );
    shell::run(shell::program("sh").args(["-c", &archive]))?;
    fs::copy(kernel, disk.join("linux"))?;
    fs::copy("/usr/lib/ISOLINUX/isolinux.bin", disk.join("isolinux.bin"))?;
    fs::copy("/usr/lib/syslinux/modules/bios/ldlinux.c32", disk.join("ldlinux.c32"))?;
    let menu = "DEFAULT tests\nPROMPT 0\nTIMEOUT 0\nLABEL tests\n KERNEL /linux\n INITRD /initrd\n APPEND quiet console=ttyS0,115200 \
                panic=-1 mitigations=off nokaslr clearcpuid=321,323 random.trust_cpu=on\n";
    fs::write(disk.join("isolinux.cfg"), menu)?;
    let image = folder.join("disk.iso");
    let mut xorriso = shell::program("xorriso");
    xorriso.args(["-as", "mkisofs", "-quiet", "-o"]).arg(&image).args(["-b", "isolinux.bin", "-c", "boot.cat"]);
    xorriso.args(["-no-emul-boot", "-boot-load-size", "4", "-boot-info-table"]).arg(&disk);
    shell::run(&mut xorriso)?;
    Ok(image)
}

/// Runs the machine until it turns itself off, and returns what it wrote to its serial port.
fn boot(folder: &Path, image: &Path) -> Result<String> {
    let (settings, serial, log) = (folder.join("bochsrc"), folder.join("serial.txt"), folder.join("bochs.log"));
    let patch = folder.join("rsqrt14.so");
    let mut cc = shell::program("cc");
    cc.args(["-O1", "-shared", "-fPIC", "-Wall", "-Wextra", "-Werror", "xtask/avx512/rsqrt14.c", "-ldl", "-o"]);
    shell::run(cc.arg(&patch))?;
    let machine = format!(
        "config_interface: textconfig\n\
         display_library: rfb, options=\"timeout=0\"\n\
         cpu: model=corei7_skylake_x, count=1, ips=100000000, reset_on_triple_fault=0\n\
         memory: guest=512, host=512\n\
         romimage: file=/usr/share/bochs/BIOS-bochs-latest\n\
         vgaromimage: file=/usr/share/bochs/VGABIOS-lgpl-latest\n\
         ata0-master: type=cdrom, path={}, status=inserted\n\
         boot: cdrom\n\
         clock: sync=none\n\
         com1: enabled=1, mode=file, dev={}\n\
         log: {}\n\
         panic: action=fatal\n\
         error: action=report\n\
         info: action=ignore\n\
         debug: action=ignore\n",
        quoted(image)?,
        quoted(&serial)?,
        quoted(&log)?
    );
    fs::write(&settings, machine)?;
    // Debian's build stops in its debugger first.
    let commands = folder.join("commands");
    fs::write(&commands, "c\n")?;
    fs::write(&serial, "")?;
    let mut bochs = shell::program("timeout");
    bochs.args(["1500", "bochs-bin", "-q", "-f"]).arg(&settings).arg("-rc").arg(&commands);
    bochs.env("LD_PRELOAD", &patch).stdin(std::process::Stdio::null());
    bochs.stdout(std::process::Stdio::null()).stderr(std::process::Stdio::null());
    // The status is also 1 after the machine has turned itself off.
    bochs.status().context("cannot start bochs-bin")?;
    let text = String::from_utf8_lossy(&fs::read(&serial)?).replace('\r', "");
    print!("{text}");
    let status = text.lines().find_map(|line| line.trim().strip_prefix(LAST_LINE));
    match status.map(str::trim) {
        Some("0") => Ok(text),
        Some(status) => bail!("the tests failed in the emulator (status {status})"),
        None => bail!("the emulated machine did not come to its end; see {} and {}", serial.display(), log.display()),
    }
}

/// Refuses a path with characters that a shell or Bochs would interpret.
fn quoted(path: &Path) -> Result<&str> {
    let text = path.to_str().context("a path that is no text")?;
    let plain = |c: char| c.is_ascii_alphanumeric() || "/._-+".contains(c);
    ensure!(text.chars().all(plain), "the emulator needs a path of plain characters, not {text}");
    Ok(text)
}

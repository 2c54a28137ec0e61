//! Makes `include/mollis.h` from `ffi/abi` with cbindgen, or compares it with the committed file.

mod fortran;
mod layout;

use std::fmt::Write as _;

use anyhow::{Context, Result, bail, ensure};
use mollis_core::Error;
use mollis_core::kernel::{Kernel, Law, Term};
use mollis_core::mollifier::Mollifier;

use crate::{shell, templates, text};

const HEADER: &str = "include/mollis.h";

/// As in `ffi/abi/src/status.rs`; a test compares them.
const ABI_VERSION: u32 = 1;

/// Writes the header, or checks that the file is up to date.
pub fn run(check: bool) -> Result<()> {
    templates::run(check)?;
    let fresh = generate()?;
    complete(&fresh)?;
    bring(HEADER, &fresh, check)?;
    bring("include/mollis.f90", &fortran::module(&fresh)?, check)
}

/// Writes a file, or checks that it is up to date.
fn bring(name: &str, fresh: &str, check: bool) -> Result<()> {
    let path = shell::root().join(name);
    let committed = std::fs::read_to_string(&path).unwrap_or_default();
    if committed == fresh {
        println!("{name} is up to date");
    } else if check {
        bail!("{name} is not what the source makes: run `cargo xtask header`");
    } else {
        std::fs::create_dir_all(path.parent().context("no folder")?)?;
        std::fs::write(&path, fresh)?;
        println!("{name} written");
    }
    Ok(())
}

/// All functions of the header, in order.
pub fn functions() -> Result<Vec<String>> {
    let header = shell::read(&shell::root().join(HEADER))?;
    let code = text::code_only(&header);
    // A pointer to a function, `mollis_status (*evaluate)(...)`, does not count.
    let called = |end: usize| code[end..].trim_start().strip_prefix('(').is_some_and(|rest| !rest.starts_with('*'));
    let names = text::identifiers(&code)
        .filter(|&(at, word)| word.starts_with("mollis_") && called(at + word.len()))
        .map(|(_, word)| word.to_owned());
    Ok(names.collect())
}

fn generate() -> Result<String> {
    let config = cbindgen::Config {
        language: cbindgen::Language::C,
        cpp_compat: true,
        style: cbindgen::Style::Both,
        usize_is_size_t: true,
        no_includes: true,
        sys_includes: vec!["stddef.h".into(), "stdint.h".into()],
        documentation: true,
        documentation_style: cbindgen::DocumentationStyle::Doxy,
        include_guard: Some("MOLLIS_H".into()),
        header: Some(HEAD.into()),
        after_includes: Some(constants()?),
        line_length: 110,
        tab_width: 2,
        ..cbindgen::Config::default()
    };
    let bindings = cbindgen::Builder::new()
        .with_crate(shell::root().join("ffi/abi"))
        .with_config(config)
        .generate()
        .context("cbindgen cannot read ffi/abi")?;
    let mut bytes = Vec::new();
    bindings.write(&mut bytes);
    Ok(layout::lay_out(&String::from_utf8(bytes)?))
}

const HEAD: &str = "/*
 * mollis: particles that interact through softened (\"mollified\") potentials.
 *
 * The caller owns all memory. Every function returns a status, MOLLIS_OK or one of MOLLIS_ERR_*, and hands results
 * back through pointers; a call that is refused leaves every output as it was, but for what tells why (a report, first_bad).
 * A null output means \"not wanted\". Outputs must overlap nothing else of the call. A pointer with a length may be null when the length is 0.
 * Coordinates of n points in D dimensions are an array `double x[n][D]`.
 * Functions with the suffix _f32 compute in float, those without one in double. What exists in several dimensions is documented for the plane and
 * double; below it stand the forms for float and for one and three dimensions, 1 and 3 in place of 2.
 *
 * Structures with a member `size` are filled by their _init function, which is told their sizeof: then a program built with
 * an older header gets the defaults of what it does not know. A size of 0 is refused with MOLLIS_ERR_NOT_INITIALISED,
 * one at which no member ends with MOLLIS_ERR_OPTIONS_SIZE.
 *
 * MOLLIS_ERR_NOT_FINITE: the first bad element is told through mollis_run.first_bad by functions that take a run, and found
 * by mollis_first_bad for the others.
 *
 * Functions of the host that the library calls (fill, evaluate, parallel_for, should_stop, after_step) must return. A C++
 * exception that leaves one, or a longjmp across a call of the library, is undefined behaviour: catch it, keep it, return a
 * status, and throw it again after the call, as examples_c/exceptions.cpp does. A status other than 0 that fill, evaluate or
 * parallel_for returns ends the call and comes back unchanged, whatever its number. Those of the library are 1 to 255.
 *
 * Made from the library's source by `cargo xtask header`: do not edit.
 */";

/// The status codes from the table of errors, and the other numbers that a C program needs at compile time.
fn constants() -> Result<String> {
    let version = env!("CARGO_PKG_VERSION");
    let mut out = format!(
        "
/** The version of the library that this header belongs to. */
#define MOLLIS_VERSION \"{version}\"
/** The version of the binary interface: mollis_abi_version() of a library that programs with this header may use. */
#define MOLLIS_ABI_VERSION {ABI_VERSION}

"
    );
    out.push_str("/** Success. */\n#define MOLLIS_OK 0\n");
    for &error in Error::ALL {
        let text = error.text().to_str()?;
        write!(out, "/** {}. */\n#define MOLLIS_ERR_{} {}\n", text, screaming(error.name()), error as i32)?;
    }
    let newtonian = [Term { law: Law::Newtonian, coefficient: 1.0 }];
    let kernel = Kernel::<f32, 2>::workspace_bytes(&newtonian, Mollifier::None)?;
    write!(
        out,
        "
/** How arrays in a workspace are aligned, and best prepared kernels. */
#define MOLLIS_ALIGN {}
/** `bytes`, rounded up to the alignment: what an array takes in a workspace. */
#define MOLLIS_PADDED(bytes) (((size_t)(bytes) + MOLLIS_ALIGN - 1) / MOLLIS_ALIGN * MOLLIS_ALIGN)
/** For static buffers: what `mollis_kernel2_bytes_f32` answers for one Newtonian term. */
#define MOLLIS_KERNEL2_NEWTONIAN_BYTES_F32 {kernel}
/** For static buffers: a field sum over n sources in the plane, a part of the workspaces below. */
#define MOLLIS_SUM2_PART_F32(n) \\
  (MOLLIS_PADDED(8 * (size_t)(n)) + 2 * MOLLIS_PADDED(4 * (size_t)(n)) + MOLLIS_PADDED(16 * ((size_t)(n) / 256 + 3)))
/**
 * For static buffers: what `mollis_blob2_workspace_bytes_f32` answers for n particles without gaps, with densities, no tracers, a
 * Newtonian kernel and default options.
 */
#define MOLLIS_BLOB2_WORKSPACE_BYTES_F32(n) \\
  (4 * MOLLIS_PADDED(12 * (size_t)(n)) + MOLLIS_SUM2_PART_F32(n) + MOLLIS_ALIGN - 1)
/**
 * For static buffers: what `mollis_pks_workspace_bytes_f32` answers for n particles, a Newtonian kernel's sum as attraction
 * and default options.
 */
#define MOLLIS_PKS_WORKSPACE_BYTES_F32(n) \\
  (4 * MOLLIS_PADDED(8 * ((size_t)(n) / 2)) + ((n) > 0 ? 1600 : 0) + MOLLIS_PADDED(20 * ((size_t)(n) / 2)) + \\
   4 * MOLLIS_PADDED(8 * (size_t)(n)) + 2 * MOLLIS_PADDED(n) + MOLLIS_PADDED(4 * (((size_t)(n) + 255) / 256)) + \\
   MOLLIS_PADDED(48) + \\
   ((n) > 512 ? 2 * MOLLIS_PADDED(8 * (size_t)(n)) + 73792 * (((size_t)(n) + 32767) / 32768) + 204928 : 0) + \\
   MOLLIS_SUM2_PART_F32(n) + MOLLIS_ALIGN - 1)
",
        mollis_core::memory::ALIGN
    )?;
    Ok(out)
}

fn screaming(name: &str) -> String {
    let mut out = String::new();
    for (k, c) in name.char_indices() {
        if c.is_ascii_uppercase() && k > 0 {
            out.push('_');
        }
        out.push(c.to_ascii_uppercase());
    }
    out
}

/// cbindgen silently skips what it cannot read, such as functions made by a macro. This checks that each function of the source is in the header.
fn complete(header: &str) -> Result<()> {
    let header = text::code_only(header);
    for path in shell::files("ffi/abi/src", &["rs"])? {
        let code = text::code_only(&shell::read(&path)?);
        let words: Vec<_> = text::identifiers(&code).map(|(_, word)| word).collect();
        for name in words.windows(2).filter(|w| w[0] == "fn" && w[1].starts_with("mollis_")).map(|w| w[1]) {
            let here = text::identifiers(&header).any(|(_, word)| word == name);
            ensure!(here, "{}: {name} is not in {HEADER}; is it made by a macro?", shell::short(&path));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    #[test]
    fn constant_names() {
        assert_eq!(super::screaming("NullPointer"), "NULL_POINTER");
        assert_eq!(super::screaming("Delta"), "DELTA");
    }
}

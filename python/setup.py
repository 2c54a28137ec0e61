"""Builds the wheel, of the shared library by cargo and cffi's declarations from the C headers, and the source distribution,
which holds the sources of both.

The wheel holds `libmollis_mt` as a file that the package loads, so it is the same for every version of Python
(py3-none-PLATFORM). maturin builds with `cargo rustc --crate-type cdylib`, other options than those of `cargo build`,
and compiles the library a second time; its cffi mode reads no header with `#include` or macros. This file uses the
command that `cargo xtask install` uses.
"""

import json
import os
import re
import shutil
import subprocess
from pathlib import Path

from cffi import FFI, recompiler
from setuptools import Distribution, setup
from setuptools.command.bdist_wheel import bdist_wheel
from setuptools.command.build_py import build_py
from setuptools.command.sdist import sdist

HERE = Path(__file__).resolve().parent
# The sources of the library: those that a source distribution holds, else the checkout.
ROOT = HERE / "library" if (HERE / "library").exists() else HERE.parent
# What of them the library is built from: packages of Rust, and other files.
PACKAGES = ("core", "host", "ffi/abi", "ffi/mt", "tests/reference")
FILES = ("Cargo.lock", "LICENSE-APACHE", "LICENSE-MIT", "ffi/soname.rs", "include/mollis.h", "include/mollis_mt.h")
HEADERS = [ROOT / "include" / name for name in ("mollis.h", "mollis_mt.h")]
NUMBER = r"#define\s+(MOLLIS_\w+)[ \t]+(-?\d+|UINT64_MAX)[ \t]*$"


def header(path):
    """The text of a header without comments."""
    if not path.exists():
        raise SystemExit(f"{path} is missing: build in a checkout of mollis (pip 21.3 or newer builds in place)")
    return re.sub(r"/\*.*?\*/|//[^\n]*", "", path.read_text(), flags=re.DOTALL)


def declarations():
    """What cffi reads of the headers: numbers, types, functions."""
    parts = ["int atoi(const char *text);"]
    for text in map(header, HEADERS):
        numbers = re.findall(NUMBER, text, flags=re.MULTILINE)
        parts += [f"#define {name} {value.replace('UINT64_MAX', hex(2**64 - 1))}" for name, value in numbers]
        text = re.sub(r"^#ifdef __cplusplus\n.*?^#endif.*?$", "", text, flags=re.DOTALL | re.MULTILINE)
        parts.append(re.sub(r"^#(?:.*\\\n)*.*$", "", text, flags=re.MULTILINE))
    return "\n".join(parts)


def library():
    """Builds the shared library and returns its path."""
    cargo = os.environ.get("CARGO", "cargo")
    options = ["--profile", "library", "--package", "mollis-mt", "--message-format", "json-render-diagnostics"]
    try:
        built = subprocess.run([cargo, "build", "--quiet", *options], cwd=ROOT, stdout=subprocess.PIPE, check=True)
    except FileNotFoundError:
        raise SystemExit("cargo is missing: the wheel is built with rustup's stable Rust") from None
    messages = [json.loads(line) for line in built.stdout.decode().splitlines()]
    artifacts = [m for m in messages if m["reason"] == "compiler-artifact" and m["target"]["name"] == "mollis_mt"]
    [file] = [file for m in artifacts for file in m["filenames"] if file.endswith((".so", ".dylib", ".dll"))]
    return Path(file)


class BuildPackage(build_py):
    """Puts the library and the declarations beside the modules."""

    def run(self):
        # Nothing is left of an older build.
        shutil.rmtree(Path(self.build_lib, "mollis"), ignore_errors=True)
        super().run()
        folder = Path("." if self.editable_mode else self.build_lib, "mollis")
        if not self.editable_mode:
            for name in ("LICENSE-APACHE", "LICENSE-MIT"):
                shutil.copy(ROOT / name, folder)
        built = library()
        shutil.copy(built, folder / built.name)
        ffi = FFI()
        ffi.cdef(declarations())
        ffi.set_source("mollis._declarations", None)
        file = folder / "_declarations.py"
        recompiler.make_py_source(ffi, "mollis._declarations", str(file))
        with file.open("a") as more:
            more.write(f'VERSION = "{VERSION}"\n')


class BuildWheel(bdist_wheel):
    """Names the wheel for the platform and any Python 3. A platform with glibc is named by the oldest one that has all functions
    (PEP 600): those that the library needs say from which version on they are there.
    """

    def get_tag(self):
        platform = super().get_tag()[2]
        build = Path(self.get_finalized_command("build_py").build_lib)
        texts = [file.read_bytes() for file in build.glob("mollis/*.so")]
        versions = [tuple(map(int, found)) for text in texts for found in re.findall(rb"GLIBC_(\d+)\.(\d+)", text)]
        if versions and platform.startswith("linux_"):
            platform = platform.replace("linux_", "manylinux_{}_{}_".format(*max(versions)), 1)
        return "py3", "none", platform


class SourceDistribution(sdist):
    """Adds the sources of the library, as a workspace of what it is built from."""

    def make_release_tree(self, base_dir, files):
        super().make_release_tree(base_dir, files)
        folder = Path(base_dir, "library")
        for name in PACKAGES:
            # Programs of tests need other packages.
            shutil.copytree(ROOT / name, folder / name, ignore=shutil.ignore_patterns("tests", "target", "*.pyc"))
        for name in FILES:
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(ROOT / name, folder / name)
        text = (ROOT / "Cargo.toml").read_text()
        for key, members in {"members": list(PACKAGES), "exclude": [], "default-members": ["ffi/mt"]}.items():
            text = re.sub(rf"^{key} = .*$", f"{key} = {json.dumps(members)}", text, flags=re.MULTILINE)
        (folder / "Cargo.toml").write_text(text)


class Binary(Distribution):
    """A package that depends on the platform."""

    def has_ext_modules(self):
        return True


[VERSION] = re.findall(r'#define MOLLIS_VERSION "(.*)"', header(HEADERS[0]))
COMMANDS = {"build_py": BuildPackage, "bdist_wheel": BuildWheel, "sdist": SourceDistribution}
setup(version=VERSION, distclass=Binary, cmdclass=COMMANDS)

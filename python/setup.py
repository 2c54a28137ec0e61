"""Builds the wheel: the shared library by cargo, and cffi's declarations from the C headers.

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

ROOT = Path(__file__).resolve().parent.parent
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
    """Names the wheel for the platform and any Python 3."""

    def get_tag(self):
        return "py3", "none", super().get_tag()[2]


class Binary(Distribution):
    """A package that depends on the platform."""

    def has_ext_modules(self):
        return True


[VERSION] = re.findall(r'#define MOLLIS_VERSION "(.*)"', header(HEADERS[0]))
setup(version=VERSION, distclass=Binary, cmdclass={"build_py": BuildPackage, "bdist_wheel": BuildWheel})

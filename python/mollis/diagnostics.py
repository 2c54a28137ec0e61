"""Moments, energy, overlap and norms.

    >>> mollis.diagnostics.moments(x, m).centre
    >>> mollis.diagnostics.norm(rho - exact, cell=h**2, p=1)

Arrays are float64 unless the first one given is float32; those with gaps are copied.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _library
from ._library import ffi
from .kernels import Kernel


class Moments(NamedTuple):
    """Sums over particles."""

    mass: float
    """sum m."""
    absolute_mass: float
    """sum |m|."""
    centre: NDArray[Any]
    """The centre of mass, (D,); 0 where the mass is 0."""
    second: float
    """sum m |x - centre|^2."""


def _points(values: ArrayLike) -> tuple[_library.Api, NDArray[Any], Any]:
    """Points (n, D), the functions for them, and a C pointer."""
    array = np.require(values, np.float32 if getattr(values, "dtype", None) == np.float32 else np.float64, ["C", "A"])
    if array.ndim != 2:
        raise ValueError(f"points have shape {array.shape}, not (n, D)")
    api = _library.api(array.shape[1], array.dtype)
    return api, array, ffi.cast(f"const {api.real} (*)[{api.dimension}]", _library.pointer(api, array))


def _numbers(
    values: ArrayLike, shape: tuple[int, ...] | None = None, dtype: Any = None
) -> tuple[_library.Api, NDArray[Any], Any]:
    """Numbers without gaps, the functions for their type, and a C pointer."""
    if dtype is None:
        dtype = np.float32 if getattr(values, "dtype", None) == np.float32 else np.float64
    array = np.require(values, dtype, ["C", "A"])
    if shape is not None and array.shape != shape:
        raise ValueError(f"numbers have shape {array.shape}, not {shape}")
    api = _library.api(1, array.dtype)
    return api, array, _library.pointer(api, array)


def moments(positions: ArrayLike, masses: ArrayLike) -> Moments:
    """Mass, sum of |m|, centre of mass and second moment about it of n particles in D dimensions, to a few roundings
    whatever n.
    """
    api, x, at = _points(positions)
    _, m, weights = _numbers(masses, (len(x),), api.dtype)
    out, centre = [ffi.new(api.array, 1) for _ in range(3)], np.empty(api.dimension, api.dtype)
    centred = ffi.cast(f"{api.real} (*)[{api.dimension}]", _library.pointer(api, centre))
    _library.check(api["moments#"](len(x), at, weights, out[0], out[1], centred, out[2]))
    return Moments(out[0][0], out[1][0], centre, out[2][0])


def energy(kernel: Kernel, positions: ArrayLike, masses: ArrayLike, *, threads: int | None = None) -> float:
    """The regularised energy 1/2 sum m_i m_j K_delta(x_i - x_j)."""
    from ._field import field

    m = np.asarray(masses, kernel.dtype)
    u = field(kernel, positions, m, potential=True, threads=threads).potential
    assert u is not None
    return 0.5 * float(np.dot(m.astype(np.float64), u.astype(np.float64)))


def overlap(delta: float, masses: ArrayLike, densities: ArrayLike, dimension: int = 2) -> float:
    """The smallest overlap of blobs: delta over the spacing (m / density)^(1/D). A Gaussian's sampling error is
    exp(-(pi overlap)^2) of the density.
    """
    _, m, mass = _numbers(masses)
    _, _rho, density = _numbers(densities, m.shape, m.dtype)
    api = _library.api(dimension, m.dtype)
    out = ffi.new(api.array, 1)
    _library.check(api["overlap#"](m.size, delta, mass, density, out))
    return out[0]


def norm(values: ArrayLike, cell: float = 1.0, p: float = 1.0) -> float:
    """The norm (sum |v|^p cell)^(1/p) of numbers of any shape, cell = h^D; the largest |v| for infinite p."""
    api, v, at = _numbers(values)
    out = ffi.new(api.array, 1)
    _library.check(api["norm"](v.size, at, cell, p, out))
    return out[0]


def distance_norm(a: ArrayLike, b: ArrayLike, cell: float = 1.0, p: float = 1.0) -> float:
    """The norm of the distances |a_i - b_i| of points (n, D): the error of trajectories."""
    api, first, at = _points(a)
    second = np.ascontiguousarray(b, api.dtype)
    if second.shape != first.shape:
        raise ValueError(f"points have shapes {first.shape} and {second.shape}")
    other = ffi.cast(f"const {api.real} (*)[{api.dimension}]", _library.pointer(api, second))
    out = ffi.new(api.array, 1)
    _library.check(api["distance_norm#"](len(first), at, other, cell, p, out))
    return out[0]


def sobolev_norm(values: ArrayLike, spacing: float, p: float = 2.0) -> float:
    """The W^{1,p}_h norm of a function on a box of the lattice h Z^D: (|v|^p + sum_j |D_j v|^p)^(1/p), forward
    differences over h; for infinite p the largest of all. Outside the box the function is zero.

    `values` has one axis a dimension, x along the last; `spacing` is h. Raises `mollis.Error`: OUT_OF_DOMAIN.
    """
    _, v, at = _numbers(values)
    api = _library.api(v.ndim, v.dtype)
    counts, out = np.array(v.shape[::-1], np.uintp), ffi.new(api.array, 1)
    sizes = ffi.cast(f"const size_t (*)[{v.ndim}]", ffi.from_buffer(counts))
    _library.check(api["sobolev_norm#"](sizes, spacing, p, at, out))
    return out[0]


def dual_norm(values: ArrayLike, spacing: float, margin: int) -> float:
    """The W^{-1,2}_h norm of a function on a box of the lattice h Z^D, in which the density of the blob method
    converges.

    `values` has one axis a dimension, x along the last; `spacing` is h, and `margin` points of zeros on each side
    stand for the rest of the lattice, which cuts off about e^(-2 margin h) of the norm. Raises `mollis.Error`:
    NOT_FINITE, OUT_OF_DOMAIN, TOO_LARGE.
    """
    _, v, at = _numbers(values)
    api = _library.api(v.ndim, v.dtype)
    counts = np.array(v.shape[::-1], np.uintp)
    sizes = ffi.cast(f"const size_t (*)[{v.ndim}]", ffi.from_buffer(counts))
    size, out = ffi.new("size_t *"), ffi.new(api.array, 1)
    _library.check(api["dual_norm#_workspace_bytes"](sizes, margin, size))
    workspace = _library.aligned(size[0])
    _library.check(api["dual_norm#"](sizes, spacing, margin, at, out, ffi.from_buffer(workspace), size[0]), v.ravel())
    return out[0]


def first_bad(values: ArrayLike) -> int | None:
    """The index of the first element (of n numbers, or of n points) that is not finite, or None."""
    api, v, at = _numbers(values)
    out = ffi.new("uint64_t *")
    n = len(v)
    _library.check(api["first_bad"](n, v.size // n if n else 1, at, out))
    return None if out[0] == _library.lib.MOLLIS_NONE_BAD else out[0]

"""The built-in random streams: Philox4x32-10 (Salmon et al. 2011) and normal numbers. They have no state.

>>> mollis.random.philox_normals(seed=1, labels=np.arange(4, dtype=np.uint64), step=0)
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, DTypeLike, NDArray

from . import _library
from ._library import ffi, lib


def philox_words(seed: int, label: int, step: int, substep: int = 0, n: int = 2) -> NDArray[np.uint64]:
    """n uniform 64-bit words for the particle `label` at this step and sub-step."""
    out = np.empty(n, np.uint64)
    _library.check(lib.mollis_philox_words(seed, label, step, substep, n, ffi.from_buffer("uint64_t[]", out)))
    return out


def philox_normals(
    seed: int, labels: ArrayLike, step: int, substep: int = 0, dtype: DTypeLike = np.float64
) -> NDArray[Any]:
    """Two independent standard normal numbers for each label, (n, 2). The bits are the same on every machine."""
    api = _library.api(2, dtype)
    names = np.ascontiguousarray(labels, np.uint64)
    out = np.empty((names.size, 2), api.dtype)
    at = ffi.cast(f"{api.real} (*)[2]", _library.pointer(api, out))
    _library.check(api["philox_normals"](seed, names.size, ffi.from_buffer("uint64_t[]", names), step, substep, at))
    return out


def normals(words: ArrayLike, dtype: DTypeLike = np.float64) -> NDArray[Any]:
    """As many standard normal numbers as uniform 64-bit words, an even number (Box and Muller 1958)."""
    api = _library.api(1, dtype)
    bits = np.ascontiguousarray(words, np.uint64)
    if bits.size % 2:
        raise ValueError("an even number of words is needed")
    out = np.empty(bits.size, api.dtype)
    _library.check(api["normals"](bits.size, ffi.from_buffer("uint64_t[]", bits), _library.pointer(api, out)))
    return out

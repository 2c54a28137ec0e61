"""Sums over sources."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _library
from ._library import executor, ffi, give, output, points, put_matrices, put_points, put_vector, take, vector
from .kernels import Kernel

NULL = ffi.NULL
_GRADIENT = (1.0, 0.0)

_Asked = bool | NDArray[Any] | None


class Counts(NamedTuple):
    """What a sum did; see `mollis_field_counts` in the header."""

    pairs: int
    near_pairs: int
    polynomial_blocks: int
    all_near_blocks: int
    scaled_pairs: int
    massless_sources: int
    beyond_reach: int


class Field(NamedTuple):
    """The results of a sum; None where not asked for."""

    potential: NDArray[Any] | None
    """u, (n,)."""
    gradient: NDArray[Any] | None
    """grad u, (n, D), or what `combination` makes of it."""
    laplacian: NDArray[Any] | None
    """The Laplacian of u, (n,)."""
    hessian: NDArray[Any] | None
    """The second derivatives of u, (n, D, D), symmetric; `combination` makes nothing of them."""
    counts: Counts | None
    """What the sum did."""


# A sum of fewer pairs is over before other threads have started, and before anyone presses Ctrl-C.
_FEW, _MANY = 20_000, 50_000_000


def _options(
    frame: _library.Frame,
    method: str,
    accumulation: str,
    combination: tuple[float, float],
    tolerance: float,
    pair_radius: str = "source",
) -> Any:
    plain = method == "auto" and accumulation == "blocked" and pair_radius == "source"
    if plain and combination is _GRADIENT and tolerance == 0.0:
        return NULL
    options = frame.options("mollis_field_options")
    options.method, options.accumulation = (
        _library.number("METHOD", method),
        _library.number("ACCUMULATION", accumulation),
    )
    options.combination[0], options.combination[1] = combination
    options.tolerance = tolerance
    options.pair_radius = _library.number("PAIR_RADIUS", pair_radius)
    return options


def _put_outputs(api: _library.Api, outputs: Any, potential: Any, gradient: Any, laplacian: Any, hessian: Any) -> None:
    if potential is not None:
        put_vector(api, outputs, "potential", potential, "potential_stride")
    if gradient is not None:
        put_points(api, outputs, "gradient", gradient, "gradient_stride")
    if laplacian is not None:
        put_vector(api, outputs, "laplacian", laplacian, "laplacian_stride")
    if hessian is not None:
        put_matrices(api, outputs, "hessian", hessian, "hessian_stride")


def field(
    kernel: Kernel, positions: ArrayLike, masses: ArrayLike | None = None, targets: ArrayLike | None = None, *,
    radii: ArrayLike | None = None, target_radii: ArrayLike | None = None, pair_radius: str = "source",
    strengths: ArrayLike | None = None,
    potential: _Asked = False, gradient: _Asked = False, laplacian: _Asked = False, hessian: _Asked = False,
    factor: float = 1.0, add: bool = False, combination: tuple[float, float] = _GRADIENT,
    method: str = "auto", accumulation: str = "blocked", tolerance: float = 0.0,
    threads: int | None = None, level: str = "best", counts: bool = False,
) -> Field:  # fmt: skip
    """Sums over sources: u(x_i) = sum_j m_j K_delta(x_i - x_j) at every target, its gradient, Laplacian and second derivatives.

        >>> kernel = mollis.Kernel(kernels.newtonian(), mollifiers.compact(2, 4), delta=0.05)
        >>> attraction = mollis.field(kernel, x, m, gradient=True).gradient     # x (n, 2), m (n,)
        >>> mollis.field(kernel, x, m, targets, gradient=velocity, factor=-1.0)   # overwrites the array `velocity`

    Inputs, read where they are: `positions` (n, D), `masses` (n,) or one number, `targets` (k, D), by default the
    sources themselves, `radii` (n,), core radii in place of the kernel's delta (Newtonian kernels with a mollifier),
    `target_radii` (k,), those of the targets, if `pair_radius` is "maximum", "mean" or "rms" of both (targets that are
    the sources have the sources'; forces between two particles are then equal and opposite),
    `strengths` (n, 3), vector strengths in place of the masses: the gradient is then the velocity of vortex elements
    by the law of Biot and Savart. Lists, arrays of another type, and arrays whose strides are negative, zero or no
    multiples of the item are copied.

    Outputs: `potential`, `gradient`, `laplacian`, `hessian` are True, for a new array, or an array of the kernel's dtype and of
    any positive stride, which is overwritten; with `add`, results are added to what is there. `factor` multiplies
    all. An output must overlap nothing else. In the plane the gradient output is a grad u + b (grad u rotated by +90
    degrees) for `combination` = (a, b): (0, 1) are velocities of vortices.

    `tolerance` is the error that may be spent for speed, relative in the l2 norm (Newtonian kernels: fast multipole
    method, from 1e-13 on in the plane, from 1e-12 on in space; other kernels and the line: tree, from 1e-12 on;
    float32: 1e-5); 0 asks for rounding alone. `method` is "auto", "direct", "moments", "sorted", "neighbours", "split", "fmm" or "tree";
    `mollis.plan` tells what runs. `accumulation` is "blocked" or "compensated".
    `threads` is the number of threads (None: that of `mollis.set_threads`; 1: the calling one); results do not depend
    on it, bit for bit. `level` "portable" gives the same bits on every machine. `counts` asks for the numbers of
    pairs.

    A mollified kernel counts every pair, a target on a source included; without a mollifier coincident pairs
    contribute nothing. Ctrl-C ends a long sum; what its outputs hold is then undefined. Raises `mollis.Error`:
    NOT_FINITE (`first_bad`: sources, then targets), OVERLAP, UNSUPPORTED, DELTA (a core radius).
    """
    api = kernel._api
    dimension = api.dimension
    x = points(api, positions, "positions")
    n = x.shape[0]
    at = x if targets is None else points(api, targets, "targets")
    k = at.shape[0]
    shape, flat = (k, dimension), (k,)
    u = None if potential is False else output(api, potential, flat, "potential")
    g = None if gradient is False else output(api, gradient, shape, "gradient")
    v = None if laplacian is False else output(api, laplacian, flat, "laplacian")
    h = None if hessian is False else output(api, hessian, (k, dimension, dimension), "hessian")
    if u is None and g is None and v is None and h is None:
        raise ValueError("nothing is asked for: potential, gradient, laplacian or hessian")
    if factor == 0.0:
        raise ValueError("the factor must not be 0")
    if add and True in (asked is True for asked in (potential, gradient, laplacian, hessian)):
        raise ValueError("add needs the arrays to which results are added")
    if strengths is None:
        if masses is None:
            raise TypeError("masses (or strengths) are missing")
        m, s = vector(api, masses, n, "masses"), None
    else:
        if masses is not None:
            raise TypeError("masses and strengths exclude each other")
        m, s = None, points(api, strengths, "strengths", n)
    radius = None if radii is None else vector(api, radii, n, "radii")
    if target_radii is not None and targets is None:
        raise TypeError("target_radii without targets")
    of_targets = None if target_radii is None else vector(api, target_radii, k, "target_radii")
    few = n * k < _FEW
    frame = take(NULL if few else executor(threads), level)
    try:
        sources, where, outputs = frame.sums(api)
        sources.n = n
        put_points(api, sources, "positions", x, "stride")
        put_vector(api, sources, "masses", m, "mass_stride")
        if radius is not None:
            put_vector(api, sources, "radii", radius, "radius_stride")
        if s is not None:
            put_points(api, sources, "strengths", s, "strength_stride")
        if targets is None:
            where = NULL
        else:
            where.n = k
            put_points(api, where, "positions", at, "stride")
            put_vector(api, where, "radii", of_targets, "radius_stride")
        _put_outputs(api, outputs, u, g, v, h)
        if add or factor != 1.0:
            outputs.factor, outputs.add = factor, add
        options = _options(frame, method, accumulation, combination, tolerance, pair_radius)
        counters = frame.new("mollis_field_counts") if counts else NULL
        function, before = api["field#_eval"], (kernel._pointer, kernel._bytes, sources, where, outputs, options)
        if n * k < _MANY:
            status = frame.call(function, before, counters)
        else:
            status = _library.Callbacks(frame).run(lambda: frame.call(function, before, counters))
        if status != 0:
            raise frame.error(status)
        counted = Counts(*(getattr(counters, name) for name in Counts._fields)) if counts else None
    finally:
        give(frame)
    return Field(u, g, v, h, counted)


def plan(
    kernel: Kernel, sources: int, targets: int | None = None, *,
    potential: bool = False, gradient: bool = False, laplacian: bool = False, hessian: bool = False,
    radii: bool = False, combination: tuple[float, float] = _GRADIENT,
    method: str = "auto", accumulation: str = "blocked", tolerance: float = 0.0,
) -> str:  # fmt: skip
    """A sentence that says which method `field` will use for so many sources and targets, why, and what is skipped.

        >>> print(mollis.plan(kernel, 100_000, gradient=True, tolerance=1e-6))

    Without `targets`: at the sources. The other arguments are those of `field`.
    """
    api = kernel._api
    dimension, k = api.dimension, sources if targets is None else targets
    x, y = np.empty((sources, dimension), api.dtype), np.empty((k, dimension), api.dtype)
    flat = np.empty(max(sources, k), api.dtype)
    with _library.frame(NULL) as frame:
        about, where, outputs = frame.sums(api)
        about.n, about.masses = sources, _library.pointer(api, flat[:sources])
        put_points(api, about, "positions", x, "stride")
        if radii:
            about.radii = about.masses
        if targets is None:
            where = NULL
        else:
            where.n = k
            put_points(api, where, "positions", y, "stride")
        first, second = np.empty(k, api.dtype), np.empty(k, api.dtype)
        grad, matrices = np.empty((k, dimension), api.dtype), np.empty((k, dimension, dimension), api.dtype)
        kept = zip((potential, gradient, laplacian, hessian), (first, grad, second, matrices))
        _put_outputs(api, outputs, *(array if asked else None for asked, array in kept))
        options = _options(frame, method, accumulation, combination, tolerance)
        text = ffi.new("char[]", 4096)
        _library.check(
            api["field#_text"](kernel._pointer, kernel._bytes, about, where, outputs, options, text, len(text), NULL)
        )
        return ffi.string(text).decode()


class Essential(NamedTuple):
    """What is essential for a box."""

    positions: NDArray[Any]
    """(k, D)."""
    masses: NDArray[Any]
    """(k,)."""
    origins: NDArray[np.int64]
    """(k,): which of the sources each is; -1 for one that stands for several."""


def essential(
    kernel: Kernel, positions: ArrayLike, masses: ArrayLike, boxes: ArrayLike, tolerance: float, *,
    radii: ArrayLike | None = None, level: str = "best",
) -> list[Essential]:  # fmt: skip
    """Fewer sources that act as these do on all targets in a box: what a process sends to those that own the targets.

        >>> there = [[[1.0, 0.0], [2.0, 1.0]]]                    # lower and upper corner of each box
        >>> sent, = mollis.essential(kernel, x, m, there, 1e-6)
        >>> mollis.field(kernel, sent.positions, sent.masses, targets, gradient=True)

    Inputs: `positions` (n, D), `masses` (n,) or one number, `boxes` (b, 2, D), `radii` (n,), core radii. A box whose lower
    corner is above the upper one along any axis has no targets. `tolerance`: as in `field`, at least 1e-12 (float32: 1e-5).
    Sources with core radii that were kept have their own (`radii[origins]`), others may have any that sources have.

    Under MPI a rank gathers the bounding boxes of all others and sends each what is essential there; each then sums over its own
    particles and those that it has received. Raises `mollis.Error`:
    NOT_FINITE, OUT_OF_DOMAIN (the tolerance), UNSUPPORTED (a kernel of the host's; radii under an algebraic mollifier), DELTA.
    """
    api = kernel._api
    x = points(api, positions, "positions")
    n, dimension = x.shape
    m = vector(api, masses, n, "masses")
    radius = None if radii is None else vector(api, radii, n, "radii")
    corners = np.ascontiguousarray(boxes, api.dtype)
    if corners.ndim != 3 or corners.shape[1:] != (2, dimension):
        raise ValueError(f"boxes have the shape (b, 2, {dimension}), not {corners.shape}")
    starts = np.empty(len(corners) + 1, np.uint64)
    frame = take(NULL, level)
    try:
        sources, _, _ = frame.sums(api)
        sources.n = n
        put_points(api, sources, "positions", x, "stride")
        put_vector(api, sources, "masses", m, "mass_stride")
        if radius is not None:
            put_vector(api, sources, "radii", radius, "radius_stride")
        before = (kernel._pointer, kernel._bytes, sources, tolerance)
        _library.check(api["field#_essential_bytes"](*before, frame.needed))
        if frame.needed[0] > frame.size:
            frame.resize(frame.needed[0])
        box, words = f"{api.real}(*)[2][{dimension}]", "uint64_t *"
        room, status = n // 2 + 1024, _library.lib.MOLLIS_ERR_NO_ROOM
        while status == _library.lib.MOLLIS_ERR_NO_ROOM:
            found = np.empty((room, dimension), api.dtype), np.empty(room, api.dtype), np.empty(room, np.int64)
            kinds = f"{api.real}(*)[{dimension}]", f"{api.real} *", words
            to = (ffi.cast(kind, _library.address(array)) for kind, array in zip(kinds, found))
            about = ffi.cast(box, _library.address(corners)), ffi.cast(words, _library.address(starts))
            status = api["field#_essential"](
                *before, len(corners), *about, room, *to, frame.run, frame.workspace, frame.size
            )
            room = int(starts[-1])
        if status != 0:
            raise frame.error(status)
    finally:
        give(frame)
    ends = starts.astype(np.int64)
    return [Essential(*(array[a:b] for array in found)) for a, b in zip(ends[:-1], ends[1:])]

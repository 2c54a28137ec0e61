"""Kernels K and their sums.

    >>> from mollis import kernels, mollifiers
    >>> kernel = kernels.Kernel(kernels.newtonian(), mollifiers.compact(2, 4), delta=0.05)
    >>> kernel.radial([0.0, 0.02, 1.0]).gradient_factor

A term's coefficient multiplies it. Velocities of the blob method are -grad u, so a positive coefficient of a kernel
that grows with the distance attracts.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Callable, NamedTuple, Sequence

import numpy as np
from numpy.typing import ArrayLike, DTypeLike, NDArray

from . import _library, mollifiers
from ._library import ffi


class Radial(NamedTuple):
    """A prepared kernel as functions of the distance r."""

    value: NDArray[Any]
    """K_delta(r)."""
    gradient_factor: NDArray[Any]
    """K_delta'(r) / r: grad K_delta = gradient_factor x."""
    laplacian: NDArray[Any]
    """The Laplacian of K_delta."""


@dataclass(frozen=True)
class Term:
    """One term of a kernel sum. Made by the functions of this module."""

    kind: str
    coefficient: float = 1.0
    parameter: float = 0.0


@dataclass(frozen=True)
class Own:
    """A kernel of the caller's own. Made by `own`."""

    function: Callable[[Any], Any]
    reach: float
    coefficient: float = 1.0
    tolerance: float = 0.0
    least: float = 0.0
    knots: tuple[float, ...] = ()
    vectorized: bool = False


def newtonian(coefficient: float = 1.0) -> Term:
    """Laplacian(K) = +Dirac: |x|/2, log|x|/(2 pi), -1/(4 pi |x|) in one, two, three dimensions."""
    return Term("newtonian", coefficient)


def power(p: float, coefficient: float = 1.0) -> Term:
    """|x|^p / p, and log|x| for p = 0; p > 1 - D (and p = 0 in one dimension)."""
    return Term("power", coefficient, p)


def exponential(length: float, coefficient: float = 1.0) -> Term:
    """e^(-|x| / length), a term of a Morse potential."""
    return Term("exponential", coefficient, length)


def screened(k: float, coefficient: float = 1.0) -> Term:
    """(Laplacian - k^2) K = Dirac: -e^(-k|x|)/(2k), -K0(k|x|)/(2 pi), -e^(-k|x|)/(4 pi |x|)."""
    return Term("screened", coefficient, k)


def own(
    function: Callable[[Any], Any], reach: float, coefficient: float = 1.0, *,
    tolerance: float = 0.0, least: float = 0.0, knots: Sequence[float] = (), vectorized: bool = False,
) -> Own:  # fmt: skip
    """A radial function of your own.

        >>> def yukawa(r):
        ...     e = math.exp(-r)
        ...     return -e / r, e * (1 + r) / r**3, -e / r
        >>> kernel = mollis.Kernel(kernels.own(yukawa, reach=40.0), dimension=3)

    `function(r)` returns K(r), K'(r)/r and the Laplacian of K for a distance r > 0, a float, or with `vectorized` an
    array of one. It is called some ten thousand times while the kernel is prepared and never afterwards, and has to
    be accurate at every r up to the reach: -expm1(-x), not 1 - exp(-x). An exception that it raises is raised again
    by `Kernel`.

    `reach` is the largest distance that matters; pairs beyond get nothing. `knots` are radii where the kernel is not
    smooth, increasing. `tolerance` is the error with which the fit is accepted (0: 1e-10, float32 1e-5; else
    KERNEL_FIT); `Kernel.fit_errors` tells what was reached. Below `least` K continues as a power of r.
    """
    return Own(function, reach, coefficient, tolerance, least, tuple(knots), vectorized)


class Kernel:
    """A prepared kernel: a sum of terms under a mollifier of length delta.

        >>> gravity = Kernel(kernels.newtonian(4 * math.pi), mollifiers.plummer(), delta=0.01, dimension=3)
        >>> morse = Kernel([kernels.exponential(0.5, 2.0), kernels.exponential(1.0, -1.0)])

    `terms` is one term or several, at most one of them `kernels.own`. Without a mollifier the kernel is singular, and
    coincident pairs contribute nothing. `dtype` is the type in which sums with this kernel compute, float64 or
    float32: arrays that are only read are converted to it, those that are written have to have it.

    Preparing takes microseconds (Newtonian) to tens of milliseconds. A kernel is immutable, may be used by several
    threads at a time, and can be pickled. Raises `mollis.Error`: DELTA, ORDER, EXPONENT, KERNEL_PARAMETER,
    KERNEL_TERMS, UNSUPPORTED, KERNEL_FIT and others of the header.
    """

    __slots__ = ("dimension", "dtype", "delta", "mollifier", "fit_errors", "_api", "_block", "_pointer", "_bytes")

    dimension: int
    dtype: np.dtype[Any]
    delta: float
    mollifier: mollifiers.Mollifier
    fit_errors: tuple[float, float, float] | None
    """Of a kernel of your own: the largest errors of K, K'/r and the Laplacian. Else None."""

    def __init__(
        self, terms: Term | Own | Sequence[Term | Own], mollifier: mollifiers.Mollifier | None = None,
        delta: float | None = None, dimension: int = 2, dtype: DTypeLike = np.float64,
    ) -> None:  # fmt: skip
        all_terms = [terms] if isinstance(terms, (Term, Own)) else list(terms)
        owns = [term for term in all_terms if isinstance(term, Own)]
        plain = [term for term in all_terms if not isinstance(term, Own)]
        if len(owns) > 1:
            raise ValueError("a sum holds at most one kernel of your own")
        if mollifier is not None and mollifier.kind != "none" and delta is None:
            raise ValueError("a mollifier needs its length delta")
        self._api = api = _library.api(dimension, dtype)
        self.dimension, self.dtype, self.delta = dimension, api.dtype, 0.0 if delta is None else float(delta)
        self.mollifier = mollifier or mollifiers.none()
        array = ffi.new("mollis_kernel_term[]", max(len(plain), 1))
        for slot, term in zip(array, plain):
            slot.kind, slot.coefficient = _library.number("KERNEL", term.kind), term.coefficient
            slot.parameter[0] = term.parameter
        failures: list[BaseException] = []
        radial, errors, kept = _radial(owns[0], failures) if owns else (ffi.NULL, None, ())
        shape, size = self.mollifier._struct(), ffi.new("size_t *")
        _library.check(api["kernel#_bytes"](array, len(plain), radial, shape, size))
        self._adopt(_library.aligned(size[0]))
        status = api["kernel#_prepare"](self._pointer, self._bytes, array, len(plain), radial, shape, self.delta)
        del kept
        if failures:
            raise failures[0]
        _library.check(status)
        self.fit_errors = None if errors is None else tuple(errors)

    def _adopt(self, block: NDArray[np.uint8]) -> None:
        self._block, self._bytes = block, len(block)
        self._pointer = ffi.from_buffer("char[]", block)

    def __repr__(self) -> str:
        return f"Kernel({self.mollifier}, delta={self.delta}, dimension={self.dimension}, dtype={self.dtype})"

    def __getstate__(self) -> tuple[Any, ...]:
        return self.dimension, self.dtype, self.delta, self.mollifier, self.fit_errors, self._block.tobytes()

    def __setstate__(self, state: tuple[Any, ...]) -> None:
        self.dimension, self.dtype, self.delta, self.mollifier, self.fit_errors, data = state
        self._api = _library.api(self.dimension, self.dtype)
        block = _library.aligned(len(data))
        block[:] = np.frombuffer(data, np.uint8)
        self._adopt(block)

    def radial(self, r: ArrayLike) -> Radial:
        """K_delta(r), K_delta'(r)/r and the Laplacian of K_delta at distances of any shape.

            >>> kernel.radial(np.linspace(0, 1, 101)).value

        Values are within some roundings, see `mollis_kernel2_eval` in the header. Without a mollifier all are 0 at r
        = 0.
        """
        api = self._api
        distances = np.ascontiguousarray(r, api.dtype).reshape(np.shape(r))
        results = [np.empty_like(distances) for _ in Radial._fields]
        pointers = [_library.pointer(api, a) for a in (distances, *results)]
        status = api["kernel#_eval"](self._pointer, self._bytes, distances.size, *pointers)
        _library.check(status, distances.ravel())
        return Radial(*results)

    def stable_step(self, positions: ArrayLike, masses: ArrayLike) -> float:
        """A time step with which the blob method is stable at this state; infinity where nothing moves. Cost: n (n -
        1) evaluations. With `combination` (a, b) divide it by 1.07 sqrt(a^2 + b^2).
        """
        api = self._api
        x = _library.contiguous(api, positions, "positions")
        m = np.ascontiguousarray(_library.vector(api, masses, len(x), "masses"))
        step = ffi.new(api.array, 1)
        at = ffi.cast(f"{api.real} (*)[{self.dimension}]", _library.pointer(api, x))
        function = api["stable_step#"]
        _library.check(function(self._pointer, self._bytes, len(x), at, _library.pointer(api, m), step), np.c_[x, m])
        return step[0]

    def stable_step_anywhere(self, absolute_mass: float, diameter: float) -> float:
        """A time step with which the blob method is stable at every state of this total |mass| and diameter. With
        `combination` (a, b) divide it by 1.07 sqrt(a^2 + b^2).
        """
        step = ffi.new(self._api.array, 1)
        function = self._api["stable_step#_anywhere"]
        _library.check(function(self._pointer, self._bytes, absolute_mass, diameter, step))
        return step[0]


def _radial(term: Own, failures: list[BaseException]) -> tuple[Any, Any, tuple[Any, ...]]:
    """The structure for a function of the caller's own, its errors, and what has to live as long."""

    @ffi.callback("int32_t(void *, double, double *)")
    def evaluate(_context: Any, r: float, out: Any) -> int:
        try:
            k, factor, laplacian = term.function(np.array([r]) if term.vectorized else r)
            for i, value in enumerate((k, factor, laplacian)):
                out[i] = np.asarray(value).item()
            return 0
        except BaseException as failure:
            failures.append(failure)
            return _library.HOST_FAILED

    radial, errors = ffi.new("mollis_radial_kernel *"), ffi.new("double[3]")
    knots = ffi.new("double[]", list(term.knots)) if term.knots else ffi.NULL
    radial.evaluate, radial.coefficient, radial.reach = evaluate, term.coefficient, term.reach
    radial.tolerance, radial.least = term.tolerance, term.least
    radial.n_knots, radial.knots, radial.errors = len(term.knots), knots, errors
    return radial, errors, (evaluate, knots)

"""Mollifiers psi and their Newtonian fields.

    >>> from mollis import mollifiers
    >>> psi = mollifiers.compact(order=4, exponent=4)
    >>> psi.radial([0.0, 0.5, 2.0], delta=1.0, density=True).density
    array([3.81971863, 0.15107286, 0.        ])

A mollifier has integral 1 and is scaled to psi_delta(x) = delta^-D psi(x / delta) in D dimensions. Its Newtonian
field is phi = K * psi_delta with Laplacian(phi) = psi_delta. Arrays are float64 unless `dtype` or the arrays given
say float32.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, DTypeLike, NDArray

from . import _library
from ._library import ffi


class Radial(NamedTuple):
    """Functions of the distance r; None where not asked for."""

    density: NDArray[Any] | None
    """psi_delta(r)."""
    density_slope: NDArray[Any] | None
    """psi_delta'(r) / r."""
    potential: NDArray[Any] | None
    """phi(r)."""
    gradient_factor: NDArray[Any] | None
    """g = phi'(r) / r: grad phi = g x."""
    hessian_factor: NDArray[Any] | None
    """h = g'(r) / r: Hess phi = g I + h x x^T."""
    enclosed_mass: NDArray[Any] | None
    """The integral of psi_delta over |x| < r."""


class Points(NamedTuple):
    """Functions of n points in D dimensions; None where not asked for."""

    density: NDArray[Any] | None
    """psi_delta, (n,)."""
    potential: NDArray[Any] | None
    """phi, (n,)."""
    gradient: NDArray[Any] | None
    """grad phi, (n, D)."""
    hessian: NDArray[Any] | None
    """The second derivatives of phi, (n, D, D)."""


def _dtype(values: ArrayLike, dtype: DTypeLike | None) -> np.dtype[Any]:
    if dtype is None:
        dtype = values.dtype if isinstance(values, np.ndarray) and values.dtype == np.float32 else np.float64
    return np.dtype(dtype)


def _wanted(fields: tuple[str, ...], asked: dict[str, bool]) -> dict[str, bool]:
    """All fields if none is asked for."""
    return asked if any(asked.values()) else dict.fromkeys(fields, True)


@dataclass(frozen=True)
class Mollifier:
    """A mollifier without its length. Made by the functions of this module."""

    kind: str
    order: int = 0
    exponent: int = 0

    def _struct(self) -> Any:
        return ffi.new("mollis_mollifier *", (_library.number("MOLLIFIER", self.kind), self.order, self.exponent))[0]

    def radial(
        self, r: ArrayLike, delta: float, dimension: int = 2, *, dtype: DTypeLike | None = None, **wanted: bool
    ) -> Radial:
        """psi_delta and its Newtonian field as functions of distances.

            >>> psi.radial(r, delta=0.1, gradient_factor=True).gradient_factor

        `r` has any shape; signs are not looked at. Each result has that shape. Keywords with the names of `Radial`
        say what is computed; without one, all is. Values are within 1 ulp. Raises `mollis.Error`: DELTA, ORDER,
        EXPONENT, NOT_FINITE (`first_bad`).
        """
        return self._functions("mollifier#_eval", r, dimension, dtype, wanted, lambda api: (delta,))

    def richardson(
        self,
        r: ArrayLike,
        delta: float,
        radii: ArrayLike,
        dimension: int = 2,
        *,
        dtype: DTypeLike | None = None,
        **wanted: bool,
    ) -> tuple[NDArray[Any], Radial]:
        """A Richardson combination (Anderson (8) to (10)): the sum over j of weight[j] times this mollifier of length
        radii[j] delta.

        `radii` are one to four different numbers in (0, 1]; p + 2 (len(radii) - 1) is the order, for a mollifier of
        order p. Returns the weights and the functions, as `radial` does.
        """
        weights: list[NDArray[Any]] = []

        def before(api: _library.Api) -> tuple[Any, ...]:
            lengths = np.ascontiguousarray(radii, api.dtype).ravel()
            weights.extend((np.empty(len(lengths), api.dtype), lengths))
            return delta, len(lengths), _library.pointer(api, lengths), _library.pointer(api, weights[0])

        functions = self._functions("mollifier#_richardson", r, dimension, dtype, wanted, before)
        return weights[0], functions

    def _functions(
        self, name: str, r: ArrayLike, dimension: int, dtype: Any, wanted: dict[str, bool], before: Any
    ) -> Radial:
        if unknown := wanted.keys() - set(Radial._fields):
            raise TypeError(f"unknown: {', '.join(unknown)}; there are {', '.join(Radial._fields)}")
        api = _library.api(dimension, _dtype(r, dtype))
        distances = np.ascontiguousarray(r, api.dtype).reshape(np.shape(r))
        chosen = _wanted(Radial._fields, wanted)
        results = [np.empty_like(distances) if chosen.get(f) else None for f in Radial._fields]
        pointers = [ffi.NULL if a is None else _library.pointer(api, a) for a in results]
        arguments = (*before(api), distances.size, _library.pointer(api, distances), *pointers)
        _library.check(api[name](self._struct(), *arguments), distances.ravel())
        return Radial(*results)

    def at(
        self, x: ArrayLike, delta: float, *, dtype: DTypeLike | None = None,
        density: bool = False, potential: bool = False, gradient: bool = False, hessian: bool = False,
    ) -> Points:  # fmt: skip
        """psi_delta and its Newtonian field about a unit mass at the origin, at points.

            >>> psi.at([[0.1, 0.2]], delta=0.5, gradient=True).gradient

        `x` is (n, D). Keywords say what is computed; without one, all is.
        """
        points = np.ascontiguousarray(x, _dtype(x, dtype))
        if points.ndim != 2:
            raise ValueError(f"x has shape {points.shape}, not (n, D)")
        n, dimension = points.shape
        api = _library.api(dimension, points.dtype)
        asked = dict(density=density, potential=potential, gradient=gradient, hessian=hessian)
        chosen = _wanted(Points._fields, asked)
        shapes = ((n,), (n,), (n, dimension), (n, dimension, dimension))
        types = ("", "", f"(*)[{dimension}]", f"(*)[{dimension}][{dimension}]")
        results = [np.empty(s, api.dtype) if chosen[f] else None for f, s in zip(Points._fields, shapes)]
        pointers = [
            ffi.NULL if a is None else ffi.cast(f"{api.real} {t or '*'}", _library.pointer(api, a))
            for a, t in zip(results, types)
        ]
        function, at = api["mollifier#_field"], ffi.cast(f"{api.real} (*)[{dimension}]", _library.pointer(api, points))
        _library.check(function(self._struct(), delta, n, at, *pointers), points)
        return Points(*results)

    def moment(self, k: int, delta: float = 1.0, dimension: int = 2) -> float:
        """The integral of |x|^k psi_delta(x) over D dimensions; exactly 0 for even k above 0 and below the order."""
        value = ffi.new("double *")
        _library.check(_library.api(dimension, np.float64)["mollifier#_moment"](self._struct(), delta, k, value))
        return value[0]

    def heaviside(self, x: ArrayLike, delta: float, *, dtype: DTypeLike | None = None) -> NDArray[Any]:
        """The smooth Heaviside function in one dimension: the integral of psi_delta from -infinity to x, for x of any
        shape.
        """
        api = _library.api(1, _dtype(x, dtype))
        places = np.ascontiguousarray(x, api.dtype).reshape(np.shape(x))
        values = np.empty_like(places)
        function = api["mollifier#_heaviside"]
        status = function(
            self._struct(), delta, places.size, _library.pointer(api, places), _library.pointer(api, values)
        )
        _library.check(status, places.ravel())
        return values


def none() -> Mollifier:
    """No mollifier: the singular kernel. A coincident pair contributes nothing."""
    return Mollifier("none")


def compact(order: int = 2, exponent: int = 4) -> Mollifier:
    """A polynomial of r^2 inside r < delta (Anderson 2014): order 2, 4, 6 or 8, exponent 1 to 9. Outside the field is
    exactly Newtonian.
    """
    return Mollifier("compact", order, exponent)


def gaussian(order: int = 2) -> Mollifier:
    """A sum of Gaussians: order 2 is exp(-r^2 / delta^2) (in the plane Lamb and Oseen's vortex); 4 and 6 are Craig
    and Bertozzi's and alike.
    """
    return Mollifier("gaussian", order)


def plummer() -> Mollifier:
    """Plummer's softening, in vortex methods that of Rosenhead and Moore: the Newtonian kernel at the distance (r^2 +
    delta^2)^(1/2).
    """
    return Mollifier("plummer")


def algebraic() -> Mollifier:
    """The high-order algebraic kernel of vortex methods (Winckelmans and Leonard), of Newtonian kernels."""
    return Mollifier("algebraic")


def vatistas() -> Mollifier:
    """Vatistas' vortex with n = 2, of Newtonian kernels in the plane: K'/r = 1 / (2 pi (r^4 + delta^4)^(1/2))."""
    return Mollifier("vatistas")


def richardson(order: int = 4, exponent: int = 4) -> Mollifier:
    """A Richardson combination of order / 2 compact mollifiers of order 2 (Anderson (8) to (10)): order 4 of the radii
    delta and delta / 2, order 6 of delta, 2/3 delta and delta / 3, order 8 of delta times 1, 3/4, 1/2 and 1/4. Outside
    the field is exactly Newtonian. `Mollifier.richardson` has other radii, for functions of the distance.
    """
    return Mollifier("richardson", order, exponent)

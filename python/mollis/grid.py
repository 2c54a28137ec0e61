"""Fields of particles on a mesh in the plane.

>>> mesh = mollis.Mesh((-3, -3), (3, 3), (128, 128))
>>> mesh.field(x, m, gradient=True).gradient
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _library
from ._library import ffi

_Asked = bool | NDArray[Any] | None


class MeshField(NamedTuple):
    """The results of a field on a mesh; None where not asked for. Arrays over the nodes are (ny + 1, nx + 1): x runs
    along the last axis.
    """

    gradient: NDArray[Any] | None
    """grad u at the targets, (k, 2)."""
    node_mass: NDArray[Any] | None
    """The mass at each node, (ny + 1, nx + 1)."""
    node_potential: NDArray[Any] | None
    """u at the nodes, (ny + 1, nx + 1); with order 4 sharpened for interpolation."""
    node_gradient: NDArray[Any] | None
    """Its differences, (ny + 1, nx + 1, 2)."""
    total: NDArray[Any]
    """The total mass and its centre: three numbers."""
    outside: int
    """Sources outside the mesh; they act through the total mass only."""


@dataclass(frozen=True, eq=False)
class Medium:
    """Coefficients that depend on the place: div(G grad u) - k^2 u = density, with G > 0 and k^2 >= 0 at the nodes of
    a mesh, arrays (ny + 1, nx + 1).

        >>> medium = mollis.Medium(np.where(x**2 + y**2 < 1, 10.0, 1.0))
        >>> mollis.Mesh((-3, -3), (3, 3), (128, 128), medium=medium)

    The solve ends at the relative residual `tolerance` (choose 1e-4 for float32) or, with `mollis.Error`
    NOT_CONVERGED, after so many `iterations`; then `report` holds the iterations made and the residual reached. Without
    walls G and k^2 have to be the same everywhere on the border.
    """

    diffusivity: ArrayLike
    decay: ArrayLike | None = None
    tolerance: float = 1e-10
    iterations: int = 100
    report: NDArray[np.float64] = field(default_factory=lambda: np.zeros(2), init=False)

    def _struct(self, shape: tuple[int, int]) -> tuple[Any, ...]:
        """The structure, and the arrays that have to live as long."""
        to, kept = ffi.new("mollis_medium2 *"), []
        for name, values in (("diffusivity", self.diffusivity), ("decay", self.decay)):
            if values is not None:
                array = np.ascontiguousarray(values, np.float64)
                if array.shape != shape:
                    raise ValueError(f"{name} has shape {array.shape}, not {shape}")
                kept.append(ffi.from_buffer("double[]", array))
                setattr(to, name, kept[-1])
        to.tolerance, to.iterations = self.tolerance, self.iterations
        to.report = ffi.cast("double (*)[2]", ffi.from_buffer("double[]", self.report))
        return to, *kept


@dataclass(frozen=True)
class Mesh:
    """A rectangle cut into equal cells, and the equation that is solved on it: Laplacian(u) - screening^2 u =
    density.

        >>> mollis.Mesh(lower=(-1, -1), upper=(1, 1), cells=(64, 64), walls="no-flux")

    `walls` is "free", "free-quadrupole" (free space with the second moments of the mass) or "no-flux"; `order` 2 or 4
    is how fast the error falls with the mesh width. With a `medium` the equation is its own: no screening, order 2.
    """

    lower: tuple[float, float]
    upper: tuple[float, float]
    cells: tuple[int, int]
    walls: str = "free"
    screening: float = 0.0
    order: int = 2
    medium: Medium | None = None

    def _structs(self) -> tuple[Any, ...]:
        """Mesh and options, and what has to live as long."""
        mesh, options = ffi.new("mollis_mesh2 *"), ffi.new("mollis_grid2_options *")
        mesh.lower, mesh.upper, mesh.cells = tuple(self.lower), tuple(self.upper), tuple(self.cells)
        _library.check(_library.lib.mollis_grid2_options_init(options, ffi.sizeof("mollis_grid2_options")))
        options.walls, options.screening, options.order = (
            _library.number("WALLS", self.walls),
            self.screening,
            self.order,
        )
        kept: tuple[Any, ...] = ()
        if self.medium is not None:
            kept = self.medium._struct((self.cells[1] + 1, self.cells[0] + 1))
            options.medium = kept[0]
        return mesh, options, *kept

    def field(
        self, positions: ArrayLike, masses: ArrayLike, targets: ArrayLike | None = None, *,
        gradient: _Asked = False, node_mass: _Asked = False, node_potential: _Asked = False,
        node_gradient: _Asked = False, dtype: Any = np.float64, threads: int | None = None,
    ) -> MeshField:  # fmt: skip
        """The field of masses: u(x) = sum_j m_j V(x - x_j), V = log r / (2 pi), or -K0(k r) / (2 pi) with screening
        k, and its gradient at `targets`.

            >>> mesh.field(x, m, node_potential=True).node_potential

        Cloud-in-cell deposit, five or nine points solved exactly, bilinear interpolation. `positions` (n, 2),
        `masses` (n,) and `targets` (k, 2), by default the sources, are read where they are; outputs are True, for a
        new array, or an array of `dtype` that is overwritten. A mass below 4.4e-16 of the sum of |masses| adds
        nothing. Raises `mollis.Error`: OUT_OF_DOMAIN, NOT_FINITE (`first_bad`: sources, then targets), UNSUPPORTED.
        """
        api = _library.api(2, dtype)
        x = _library.points(api, positions, "positions")
        m = _library.vector(api, masses, len(x), "masses")
        at = x if targets is None else _library.points(api, targets, "targets")
        nodes = (self.cells[1] + 1, self.cells[0] + 1)
        g = _library.output(api, gradient, (len(at), 2), "gradient")
        shapes = {"node_mass": nodes, "node_potential": nodes, "node_gradient": (*nodes, 2)}
        asked = {"node_mass": node_mass, "node_potential": node_potential, "node_gradient": node_gradient}
        arrays = {name: _library.output(api, asked[name], shape, name) for name, shape in shapes.items()}
        for name, array in arrays.items():
            if array is not None and not array.flags.c_contiguous:
                raise ValueError(f"{name} has to be without gaps")
        total, outside = np.empty(3, api.dtype), ffi.new("uint64_t *")
        mesh, options, *_medium = self._structs()
        with _library.frame(_library.executor(threads)) as frame:
            (sources, where, _), outputs = frame.sums(api), frame.new(api.name("grid#_outputs"))
            sources.n = len(x)
            _library.put_points(api, sources, "positions", x, "stride")
            _library.put_vector(api, sources, "masses", m, "mass_stride")
            if targets is None:
                where = ffi.NULL
            else:
                where.n = len(at)
                _library.put_points(api, where, "positions", at, "stride")
            _library.put_points(api, outputs, "gradient", g, "gradient_stride")
            for name, array in arrays.items():
                if array is not None:
                    kind = f"{api.real} (*)[2]" if name == "node_gradient" else api.pointer
                    setattr(outputs, name, ffi.cast(kind, _library.pointer(api, array)))
            outputs.total = ffi.cast(f"{api.real} (*)[3]", _library.pointer(api, total))
            outputs.outside = outside
            function, before = api["grid#_eval"], (mesh, sources, where, outputs, options)
            status = _library.Callbacks(frame).run(lambda: frame.call(function, before), nodes[0] * nodes[1] > 100_000)
            if status != 0:
                raise frame.error(status)
        return MeshField(g, **arrays, total=total, outside=outside[0])

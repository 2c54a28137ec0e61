"""The blob method for the aggregation equation."""

from __future__ import annotations

from typing import Any, Callable, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _library
from ._library import ffi
from .kernels import Kernel
from .mollifiers import Mollifier, gaussian

_Asked = bool | NDArray[Any] | None


class BlobRun(NamedTuple):
    """What a run of the blob method says about itself."""

    steps: int
    """Steps completed: the state in the arrays is the one after them."""
    energy_first: float
    """The regularised energy 1/2 sum m_i m_j K_delta(x_i - x_j) before the first step; NaN if not watched."""
    energy_last: float
    """The last energy computed; NaN if not watched."""
    velocity: NDArray[Any] | None
    """(n, D), at the end; None if not asked for or if the run ended early."""
    divergence: NDArray[Any] | None
    """(n,), at the end."""
    tracer_velocity: NDArray[Any] | None
    """(k, D), at the end."""


class Diffusion(NamedTuple):
    """rho_t = nu Laplacian(rho^m) by blobs (Carrillo, Craig & Patacchini 2019), for `blob`: the velocity
    -nu sum_j m_j (f'(rho_j) + f'(rho(x))) grad phi(x - x_j), rho(x) = sum_j m_j phi(x - x_j), f'(s) = s^(m-2).

        >>> mollis.blob(kernel, x, m, dt, steps, diffusion=mollis.Diffusion(1.0, length=3 * h))

    Steps have to be shorter than 0.8 w / (nu m p), p the largest rho^(m-1), w = length^2 for a Gaussian of order 2 and
    2 length^2 / (2 exponent + D + 2) for a compact mollifier.
    """

    coefficient: float
    """nu >= 0."""
    exponent: float = 1.0
    """m >= 1: 1 is the heat equation."""
    mollifier: Mollifier = gaussian(2)
    """phi: Gaussian, or compact of exponent 2 or more; of order 2, or m is 2, 3, ... or 64 (SIGN_CHANGE). Particles of
    compact blobs gather in pairs where `length` is several distances of neighbours."""
    length: float = 0.0
    """Of phi, some distances of neighbours; it has no default (DELTA)."""


def _put_particles(
    api: _library.Api, struct: Any, x: Any, m: Any, density: Any, velocity: Any, divergence: Any
) -> None:
    struct.n = len(x)
    _library.put_points(api, struct, "positions", x, "stride")
    _library.put_vector(api, struct, "masses", m, "mass_stride")
    _library.put_vector(api, struct, "density", density, "density_stride")
    _library.put_points(api, struct, "velocity", velocity, "velocity_stride")
    _library.put_vector(api, struct, "divergence", divergence, "divergence_stride")


def _advanced(api: _library.Api, array: Any, name: str) -> NDArray[Any]:
    """Positions that are advanced in place."""
    shape = np.shape(array)
    return _library.writable(api, array, (shape[0] if shape else 0, api.dimension), name)


def blob(
    kernel: Kernel, positions: NDArray[Any], masses: ArrayLike, dt: float, steps: int, *,
    density: NDArray[Any] | None = None, velocity: _Asked = False, divergence: _Asked = False,
    tracers: NDArray[Any] | None = None, tracer_density: NDArray[Any] | None = None, tracer_velocity: _Asked = False,
    watch_energy: bool = False, tolerance: float = 0.0, combination: tuple[float, float] = (1.0, 0.0),
    diffusion: Diffusion | None = None,
    progress: Callable[[int, NDArray[Any], NDArray[Any] | None], object] | None = None,
    threads: int | None = None, level: str = "best",
) -> BlobRun:  # fmt: skip
    """Advances particles by `steps` steps of length `dt` of the classical Runge-Kutta method: x_i' = -sum_j m_j grad
    K_delta(x_i - x_j).

        >>> x, m = lattice.copy(), density * h**2
        >>> run = mollis.blob(kernel, x, m, dt=0.025, steps=20, density=density, velocity=True)

    Advanced in place: `positions` (n, D), `density` (n,) along the trajectories, `tracers` (k, D), massless points
    that follow the flow, and `tracer_density` (k,), given if and only if `density` is. They have the kernel's dtype
    and any positive stride. `masses` (n,), the density times h^D, of any sign, are only read. `velocity`,
    `divergence` and `tracer_velocity` are True, for a new array, or an array that is overwritten with the values at
    the end. `steps` may be 0: the velocities of the state as it is.

    In 2D velocities are -(a grad u + b (grad u rotated by +90 degrees)) for `combination` = (a, b), with u = sum_j m_j
    K_delta(x - x_j). (0, -1) with a Newtonian kernel and circulations as masses is the vortex blob method:
    counter-clockwise about a positive circulation. (`field` returns a grad u + b (...), without the minus sign.)
    Divergences and the rates of densities are a times those of (1, 0).

    `diffusion` adds the velocity of `Diffusion`, and its entropy nu sum_i m_i f(rho_i) to the energy. Masses must not
    be negative then, and densities and divergences are not offered (UNSUPPORTED). A Newtonian kernel of coefficient 0
    leaves diffusion alone, and takes no sum.

    `progress(steps, positions, density)` is called after each step with views of the state at that step, which are
    valid until it returns: copy what you keep, write nothing. If it returns True the run ends, without an exception;
    an exception that it raises ends the run and is raised again. `watch_energy` ends a run whose energy rises beyond
    rounding (masses must not be negative); for a <= 0 it only reports the energy, which is constant for a = 0, up to
    the error of the steps. `tolerance` and `threads` are those of `field`.

    However a run ends, the arrays hold the state after the last completed step. Ctrl-C raises KeyboardInterrupt, and
    errors raise `mollis.Error` (BECAME_NOT_FINITE, ENERGY_ROSE, NOT_FINITE with `first_bad`: particles, then tracers;
    TIME_STEP, MASS); both have the `BlobRun` as attribute `report`.
    """
    api = kernel._api
    dimension = api.dimension
    x = _advanced(api, positions, "positions")
    n = len(x)
    m = _library.vector(api, masses, n, "masses")
    rho = None if density is None else _library.writable(api, density, (n,), "density")
    v = _library.output(api, velocity, (n, dimension), "velocity")
    div = _library.output(api, divergence, (n,), "divergence")
    k, points, points_rho, points_v = 0, None, None, None
    if tracers is None:
        if tracer_density is not None or (tracer_velocity is not None and tracer_velocity is not False):
            raise TypeError("tracer_density and tracer_velocity need tracers")
    else:
        points = _advanced(api, tracers, "tracers")
        k = len(points)
        if tracer_density is not None:
            points_rho = _library.writable(api, tracer_density, (k,), "tracer_density")
        points_v = _library.output(api, tracer_velocity, (k, dimension), "tracer_velocity")
        if (points_rho is None) != (rho is None):
            raise TypeError("tracer_density is given if and only if density is")
    few = n * (n + k) < 20_000
    long = max(steps, 1) * n * (n + k) > 1_000_000 or progress is not None
    stopped: list[bool] = []
    with _library.frame(ffi.NULL if few else _library.executor(threads), level) as frame:
        particles = frame.new(api.name("particles#"))
        _put_particles(api, particles, x, m, rho, v, div)
        others = ffi.NULL
        if points is not None:
            others = frame.new(api.name("particles#"), 1)
            _put_particles(api, others, points, None, points_rho, points_v, None)
        options = frame.options("mollis_blob_options")
        options.watch_energy, options.tolerance = watch_energy, tolerance
        options.combination[0], options.combination[1] = combination
        if diffusion is not None:
            options.diffusion, options.diffusion_exponent = diffusion.coefficient, diffusion.exponent
            options.diffusion_mollifier = diffusion.mollifier._struct()
            options.diffusion_length = diffusion.length
        callbacks = _library.Callbacks(frame)
        after_step = None
        if progress is not None:

            def report_step(completed: int, at: int, at_density: int) -> int:
                seen = (_view(frame, api, x, at, (n, dimension)), _view(frame, api, rho, at_density, (n,)))
                if _library.ends(progress(completed, *seen)):  # type: ignore[arg-type]
                    stopped.append(True)
                    return 1
                return 0

            asked = callbacks.here(report_step)

            @ffi.callback("int32_t(void *, size_t, const void *, const void *)")
            def after_step(_context: Any, completed: int, at: Any, at_density: Any) -> int:
                return asked(completed, int(ffi.cast("intptr_t", at)), int(ffi.cast("intptr_t", at_density)))

            options.after_step = after_step
        report = frame.new("mollis_blob_report")
        report.steps, report.energy_first, report.energy_last = 0, np.nan, np.nan
        function = api["blob#_step"]
        before = (kernel._pointer, kernel._bytes, particles, others, dt, steps, options)
        failure: BaseException | None = None
        try:
            status = callbacks.run(lambda: frame.call(function, before, report), long)
            if status != 0 and not stopped:
                failure = frame.error(status)
        except BaseException as other:
            failure = other
        finally:
            options.after_step = ffi.NULL
        ended = failure is None and not stopped
        run = BlobRun(
            report.steps,
            report.energy_first,
            report.energy_last,
            v if ended else None,
            div if ended else None,
            points_v if ended else None,
        )
    if failure is not None:
        failure.report = run  # type: ignore[attr-defined]
        raise failure
    return run


def _view(frame: _library.Frame, api: _library.Api, own: Any, at: int, shape: tuple[int, ...]) -> NDArray[Any] | None:
    """The array at an address, which lies in the workspace or is the caller's own."""
    if at == 0:
        return None
    start = at - _library.address(frame.block)
    if 0 <= start < frame.size:
        size = int(np.prod(shape)) * api.item
        view = frame.block[start : start + size].view(api.dtype).reshape(shape)
    else:
        view = own.view()
    view.flags.writeable = False
    return view

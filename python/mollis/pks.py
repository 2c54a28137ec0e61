"""Coalescing particles for Patlak-Keller-Segel equations in the plane (Zhelezov & Fatkullin 2016).

>>> kernel = mollis.Kernel(kernels.newtonian(), mollifiers.compact(2, 4), delta=1e-3)
>>> run = mollis.pks.Particles(x, m, chi=1.0, noise=0.01, attraction=kernel, random=np.random.default_rng(1))
>>> events = run.step(dt=1e-3, steps=100)
>>> len(run.masses), run.time, events.table["mass"]
"""

from __future__ import annotations

from typing import Any, Callable, NamedTuple, Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _communicator, _library
from ._communicator import Communicator as Communicator, Mpi as Mpi
from ._library import ffi, lib
from .grid import Mesh
from .kernels import Kernel

_FIELDS = ffi.typeof("mollis_pks_event").fields
_EVENT = np.dtype(
    {
        "names": [name for name, _ in _FIELDS],
        "formats": [{"double": "f8", "uint64_t": "u8"}[field.type.cname] for _, field in _FIELDS],
        "offsets": [field.offset for _, field in _FIELDS],
        "itemsize": ffi.sizeof("mollis_pks_event"),
    }
)


class Events(NamedTuple):
    """The merges of a call, in order."""

    table: NDArray[Any]
    """A structured array: time, label (the lowest, which goes on), mass (of the merged particle), index (nu of the
    cluster), first and absorbed.
    """
    labels: NDArray[np.uint64]
    """The absorbed labels: those of an event are labels[first : first + absorbed], ascending."""

    def absorbed(self, i: int) -> NDArray[np.uint64]:
        """The labels that event i absorbed."""
        event = self.table[i]
        return self.labels[int(event["first"]) : int(event["first"] + event["absorbed"])]


class Report(NamedTuple):
    """What the steps did, summed over all calls; see `mollis_pks_report` in the header."""

    substeps: int
    normals: int
    fields: int
    searches: int
    clusters: int
    merges: int
    absorbed: int


class Particles:
    """Coalescing particles: dX_n = -chi grad sum_i m_i V(X_n - X_i) dt + sqrt(2 noise / m_n) dW_n, which merge where
    they collide.

        >>> mesh = mollis.Mesh((-3, -3), (3, 3), (128, 128))
        >>> run = mollis.pks.Particles(x, m, chi=1.0, noise=1.0 / len(x), attraction=mesh, random=7)

    `positions` (n, 2) and `masses` (n,), positive, are copied; with `copy=False` the arrays given, which have to be
    without gaps and of the dtype, are advanced in place. `labels` (n,) are different integers, by default 0 to n - 1,
    `species` (n,) integers that travel with the particles. They compute in float32 if `positions` are float32. A run
    continues bit for bit from its `positions`, `masses`, `labels`, `species`, `weights`, `time` and `steps` (and the
    generator).

    `weights` (n,), positive, are for particles of different sensitivities, m_n / chi_n: particle n drifts by chi_n times
    the attraction and diffuses with noise / weight; a merged one has the sum, at the centre of the weights. They are
    copied with `copy=True`; without them every chi_n is 1. Not with heavy particles or on ranks.

    `attraction` is a `Mesh` (solved once a step), a `Kernel` in the plane (its sum over all particles in every
    sub-step) or None. With a mesh, particles of at least the mass `heavy` act pair by pair by `heavy_kernel`.
    `random` is the seed of the built-in generator, a stream a label, with which results do not depend on the number
    of threads; or a numpy.random.Generator, drawn in array order.

    `law` is "exact" or "printed", `merging` "all", "hard" (for the limit equation below the critical mass) or
    "never", `scheme` "euler-maruyama" or "strang-rk4"; the other keywords are those of `mollis_pks_options` in the
    header; `search_cells` is its `mesh`, `search_box` its `domain`.

    `communicator`, a `Communicator` such as `Mpi`, spreads the particles over ranks: each passes its own, and all make
    this object, and every step, together and with equal arguments. The ranks' arrays, one after the other, are then bit
    for bit those of one process, and all ranks get all events. The default labels go on from rank to rank. Arrays are
    copied, and `attraction` is a `Mesh` without medium or None, without heavy particles, `random` a seed.
    """

    def __init__(
        self, positions: ArrayLike, masses: ArrayLike, *, chi: float = 0.0, noise: float = 0.0,
        attraction: Mesh | Kernel | None = None, random: int | np.random.Generator = 0,
        labels: ArrayLike | None = None, species: ArrayLike | None = None,
        weights: ArrayLike | None = None, copy: bool = True,
        time: float = 0.0, steps: int = 0,
        law: str = "exact", merging: str = "all", scheme: str = "euler-maruyama", gamma: float | None = None,
        separation: float | None = None, probability: float | None = None, width: float | None = None,
        at_least: int | None = None, at_most: int | None = None, search_cells: tuple[int, int] | None = None,
        search_box: Sequence[float] | None = None, shifted: bool = True,
        heavy: float = 0.0, heavy_kernel: Kernel | None = None, tolerance: float = 0.0,
        communicator: Communicator | None = None, threads: int | None = None, level: str = "best",
    ) -> None:  # fmt: skip
        dtype = np.float32 if getattr(positions, "dtype", None) == np.float32 else np.float64
        self._api = api = _library.api(2, dtype)
        self._weights: NDArray[Any] | None = None
        if copy:
            self._positions = np.array(_library.points(api, positions, "positions"), api.dtype, order="C")
            self._masses = np.array(_library.vector(api, masses, len(self._positions), "masses"))
            if weights is not None:
                self._weights = np.array(_library.vector(api, weights, len(self._positions), "weights"))
        else:
            n = np.shape(positions)[0]
            self._positions = _library.writable(api, positions, (n, 2), "positions")
            self._masses = _library.writable(api, masses, (n,), "masses")
            if weights is not None:
                self._weights = _library.writable(api, weights, (n,), "weights")
            arrays = (self._positions, self._masses, self._weights)
            if not all(array is None or array.flags.c_contiguous for array in arrays):
                raise ValueError("arrays that are advanced in place have to be without gaps")
        n = room = self._all = len(self._positions)
        self._labels = np.arange(n, dtype=np.uint64) if labels is None else np.array(labels, np.uint64)
        self._species = None if species is None else np.array(species, np.uint32)
        for name, array in (("labels", self._labels), ("species", self._species)):
            if array is not None and array.shape != (n,):
                raise ValueError(f"{name} has shape {array.shape}, not ({n},)")
        self._communicator = communicator
        if communicator is not None:
            if not copy:
                raise ValueError("on ranks arrays are copied: all ranks need equal room")
            lower, room, self._all = _communicator.shares(communicator, n)
            if labels is None:
                self._labels += np.uint64(lower)
            self._make_room(room)
        self._threads, self._level = threads, level
        self._progress = ffi.new("mollis_pks_progress *", {"count": n, "time": time, "step": steps})
        self._report = ffi.new("mollis_pks_report *")
        self._particles = particles = ffi.new(f"{api.name('pks_particles')} *")
        particles.room = room
        particles.positions = ffi.cast(f"{api.real} (*)[2]", _library.pointer(api, self._positions))
        particles.masses = _library.pointer(api, self._masses)
        particles.labels = ffi.from_buffer("uint64_t[]", self._labels)
        if self._species is not None:
            particles.species = ffi.from_buffer("uint32_t[]", self._species)
        if self._weights is not None:
            particles.weights = _library.pointer(api, self._weights)
        self._options = options = ffi.new("mollis_pks_options *")
        _library.check(lib.mollis_pks_options_init(options, ffi.sizeof("mollis_pks_options")))
        options.law, options.merging = _library.number("PKS_LAW", law), _library.number("PKS_MERGE", merging)
        options.scheme = _library.number("PKS_SCHEME", scheme)
        options.chi, options.noise, options.shifted = chi, noise, shifted
        given: dict[str, Any] = dict(
            gamma=gamma, separation=separation, probability=probability, width=width, at_least=at_least,
            at_most=at_most, mesh=search_cells, domain=search_box,
        )  # fmt: skip
        for name, value in given.items():
            if value is not None:
                setattr(options, name, tuple(value) if name in ("mesh", "domain") else value)
        self.random = random
        if not isinstance(random, np.random.Generator):
            options.seed = int(random)
        self._attraction = ffi.new("mollis_pks_attraction *")
        self._kept = self._attract(attraction, heavy, heavy_kernel, tolerance)

    def _make_room(self, room: int) -> None:
        """Puts zeros behind the particles' arrays."""

        def longer(array: NDArray[Any]) -> NDArray[Any]:
            return np.concatenate([array, np.zeros((room - len(array), *array.shape[1:]), array.dtype)])

        self._positions, self._masses = longer(self._positions), longer(self._masses)
        self._labels = longer(self._labels)
        self._species = None if self._species is None else longer(self._species)
        self._weights = None if self._weights is None else longer(self._weights)

    def _attract(
        self, attraction: Mesh | Kernel | None, heavy: float, heavy_kernel: Kernel | None, tolerance: float
    ) -> tuple[Any, ...]:
        """Fills the structure; returns what has to live as long."""
        to = self._attraction
        kernel = heavy_kernel
        kept: tuple[Any, ...] = ()
        if attraction is None:
            to.kind = lib.MOLLIS_PKS_ATTRACTION_NONE
        elif isinstance(attraction, Mesh):
            to.kind, to.heavy = lib.MOLLIS_PKS_ATTRACTION_MESH, heavy
            kept = attraction._structs()
            to.mesh, to.grid, *_ = kept
        elif isinstance(attraction, Kernel):
            to.kind, to.tolerance, kernel = lib.MOLLIS_PKS_ATTRACTION_SUM, tolerance, attraction
        else:
            raise TypeError(f"attraction is a Mesh, a Kernel or None, not {type(attraction).__name__}")
        if kernel is not None:
            if kernel._api is not self._api:
                raise ValueError(f"the kernel is {kernel}, the particles need dimension=2, dtype={self._api.dtype}")
            to.kernel, to.kernel_bytes = kernel._pointer, kernel._bytes
        return (*kept, kernel)

    @property
    def positions(self) -> NDArray[Any]:
        """Positions of the particles alive, (count, 2): a view, valid until the next step."""
        return self._positions[: self._progress.count]

    @property
    def masses(self) -> NDArray[Any]:
        """Masses of the particles alive, (count,): a view."""
        return self._masses[: self._progress.count]

    @property
    def labels(self) -> NDArray[np.uint64]:
        """Labels of the particles alive, (count,): a view. A merged particle keeps its lowest."""
        return self._labels[: self._progress.count]

    @property
    def species(self) -> NDArray[np.uint32] | None:
        """Species of the particles alive, (count,): a view; None if none were given."""
        return None if self._species is None else self._species[: self._progress.count]

    @property
    def weights(self) -> NDArray[Any] | None:
        """Weights of the particles alive, (count,): a view; None if none were given."""
        return None if self._weights is None else self._weights[: self._progress.count]

    @property
    def time(self) -> float:
        """The time reached."""
        return self._progress.time

    @property
    def steps(self) -> int:
        """Steps made."""
        return self._progress.step

    @property
    def report(self) -> Report:
        """What the steps did, summed over all calls. On ranks, sub-steps and normals are this rank's own."""
        return Report(*(getattr(self._report, name) for name in Report._fields))

    def __len__(self) -> int:
        return self._progress.count

    def step(self, dt: float, steps: int = 1, progress: Callable[[Particles], object] | None = None) -> Events:
        """Advances by `steps` steps of length `dt` and returns the merges.

            >>> run.step(dt=1e-3, steps=1000, progress=lambda run: print(run.time, len(run)))

        `progress(run)` is called after each step; the run ends if it returns True, on ranks on all of them. Ctrl-C
        raises KeyboardInterrupt, and errors raise `mollis.Error` (NOT_FINITE with `first_bad`, MASS, TIME_STEP, OUT_OF_DOMAIN,
        TOO_MANY_SUBSTEPS, BECAME_NOT_FINITE, UNSUPPORTED) or what the generator raised: the state is then that of the
        last completed step, and the exception's attribute `report` holds the `Events` up to it.
        """
        # As many merges as can happen. Memory that is not touched costs nothing.
        room = max(self._all - 1, 0)
        table, labels = np.empty(room, _EVENT), np.empty(room, np.uint64)
        events = ffi.new("mollis_pks_events *")
        events.room, events.labels_room = room, room
        if room:
            events.events = ffi.cast("mollis_pks_event *", ffi.from_buffer(table))
            events.labels = ffi.from_buffer("uint64_t[]", labels)
        try:
            if progress is None:
                self._call(dt, steps, events)
            else:
                for _ in range(steps):
                    self._call(dt, 1, events)
                    if _library.ends(progress(self)):
                        break
        except BaseException as failure:
            failure.report = _written(table, labels, events)  # type: ignore[attr-defined]
            raise
        return _written(table, labels, events)

    def _call(self, dt: float, steps: int, events: Any) -> None:
        with _library.frame(_library.executor(self._threads), self._level) as frame:
            callbacks = _library.Callbacks(frame)
            generator = ffi.NULL
            if isinstance(self.random, np.random.Generator):
                source = self.random

                def draw(_state: Any, out: Any, n: int) -> int:
                    words = source.integers(0, 2**64 - 1, n, dtype=np.uint64, endpoint=True)
                    ffi.memmove(out, ffi.from_buffer(words), 8 * n)
                    return 0

                fill = ffi.callback("int32_t(void *, uint64_t *, size_t)", callbacks.guard(draw))
                generator = ffi.new("mollis_generator *", {"fill": fill})
            function = self._api["pks_step"]
            before = (self._particles, self._progress, self._attraction, generator, dt, steps, events, self._options)
            n = len(self)
            work = steps * n * (n if self._attraction.kind == lib.MOLLIS_PKS_ATTRACTION_SUM else 10)
            with _communicator.lent(self._communicator, frame, callbacks):
                status = callbacks.run(lambda: frame.call(function, before, self._report), work > 1_000_000)
            if status != 0:
                raise frame.error(status)


def _written(table: NDArray[Any], labels: NDArray[np.uint64], events: Any) -> Events:
    """Copies, as the arrays have room for all merges."""
    return Events(table[: events.written].copy(), labels[: events.labels_written].copy())


class Prediction(NamedTuple):
    """What is known of a mass in closed form."""

    critical_mass: float
    """8 pi mu / chi; infinite for chi = 0."""
    blow_up_bound: float
    """The bound on the time of blow-up (1.8), infinite for a subcritical mass."""
    second_moment_rate: float
    """The rate of the second moment divided by the mass, heavy point masses beside the regular part (4.12)."""


def predict(mass: float, mu: float, chi: float, second_moment: float, heavy: ArrayLike = ()) -> Prediction:
    """What is known of a mass: `second_moment` is the integral of |x|^2 rho about its centre, `heavy` the masses that
    have become points.
    """
    points, out = np.ascontiguousarray(heavy, np.float64), ffi.new("mollis_pks_prediction *")
    _library.check(
        lib.mollis_pks_predict(mass, mu, chi, second_moment, points.size, ffi.from_buffer("double[]", points), out)
    )
    return Prediction(out.critical_mass, out.blow_up_bound, out.second_moment_rate)


class Index(NamedTuple):
    """The index of a cluster."""

    nu: float
    """The index (2.7): below zero the cluster may collide, at -1 and below it must."""
    alpha: float
    """alpha of (2.4)."""
    beta2: float
    """beta^2 of (2.4)."""


def index(masses: ArrayLike, chi: float, noise: float, gamma: float = 1 / (2 * np.pi)) -> Index:
    """The index of particles of these masses, with the potential gamma log r near zero."""
    m, out = np.ascontiguousarray(masses, np.float64), ffi.new("double[3]")
    _library.check(lib.mollis_pks_index(m.size, ffi.from_buffer("double[]", m), chi, noise, gamma, out))
    return Index(*out)


class Representation(NamedTuple):
    """Several species as particles with one noise."""

    share: NDArray[np.float64]
    """The share of the particles that each species gets."""
    noise: float
    """mu~ for `Particles`."""
    rate: float
    """The rate of the second moment of all species together (4.28): of the integral of |x|^2 sum rho_i / chi_i."""


def represent_species(
    masses: ArrayLike, mus: ArrayLike, chi: float, particles: int, sensitivities: ArrayLike = 1.0
) -> Representation:
    """What represents species of these total masses, diffusivities and sensitivities (in units of chi) by so many
    particles with one noise. Particles of a species weigh their mass over its sensitivity."""
    m, mu, s = np.broadcast_arrays(*(np.asarray(a, np.float64) for a in (masses, mus, sensitivities)))
    rows = list(zip(m.ravel().tolist(), mu.ravel().tolist(), s.ravel().tolist()))
    species = ffi.new("mollis_pks_species[]", rows)
    share, noise, rate = np.empty(m.size), ffi.new("double *"), ffi.new("double *")
    status = lib.mollis_pks_represent_species(
        m.size, species, chi, particles, ffi.from_buffer("double[]", share), noise, rate
    )
    _library.check(status)
    return Representation(share, noise[0], rate[0])

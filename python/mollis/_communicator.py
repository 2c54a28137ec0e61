"""What a run of particles on several ranks lends the library: a reduction and an exchange of words."""

from __future__ import annotations

import contextlib
from typing import Any, Iterator, Protocol

import numpy as np
from numpy.typing import NDArray

from . import _library
from ._library import ffi, lib


class Communicator(Protocol):
    """How ranks exchange words of 64 bits, for `Particles`; `Mpi` is one. Any object with these members will do.

        >>> class Alone:
        ...     rank, ranks = 0, 1
        ...     def reduce(self, operation, words):
        ...         pass
        ...     def exchange(self, outgoing, starts, incoming, froms):
        ...         incoming[:] = outgoing

    All ranks make the same calls in the same order, each with words of its own; a call returns when this rank has its
    results. An exception ends the step and is raised by it. The other ranks' calls then have to raise, too: they wait
    for this one. The arrays are the library's: none may be kept.
    """

    rank: int
    """The number of this rank, below `ranks`."""
    ranks: int
    """How many there are."""

    def reduce(self, operation: str, words: NDArray[np.uint64]) -> object:
        """Overwrites each word with the "sum" (modulo 2^64) or "max" of the words at its place on all ranks."""

    def exchange(
        self,
        outgoing: NDArray[np.uint64],
        starts: NDArray[np.intp],
        incoming: NDArray[np.uint64],
        froms: NDArray[np.intp],
    ) -> object:
        """Sends `outgoing[starts[r]:starts[r + 1]]` to each rank r, this one included, and overwrites
        `incoming[froms[r]:froms[r + 1]]` with what it sends to this one.
        """


class Mpi:
    """The ranks of a communicator of mpi4py.

        >>> from mpi4py import MPI
        >>> run = mollis.pks.Particles(x, m, attraction=mesh, random=7, communicator=mollis.pks.Mpi(MPI.COMM_WORLD))

    An exception on one rank leaves the others waiting: `mpirun -n 4 python -m mpi4py program.py` ends them all.
    """

    # MPI counts in 32 bits.
    _MOST = 1 << 30

    def __init__(self, communicator: Any) -> None:
        from mpi4py import MPI

        self._mpi, self._communicator = MPI, communicator
        self.rank: int = communicator.Get_rank()
        self.ranks: int = communicator.Get_size()

    def reduce(self, operation: str, words: NDArray[np.uint64]) -> None:
        mpi = self._mpi
        for first in range(0, len(words), self._MOST):
            part = [words[first : first + self._MOST], mpi.UINT64_T]
            self._communicator.Allreduce(mpi.IN_PLACE, part, {"sum": mpi.SUM, "max": mpi.MAX}[operation])

    def exchange(
        self,
        outgoing: NDArray[np.uint64],
        starts: NDArray[np.intp],
        incoming: NDArray[np.uint64],
        froms: NDArray[np.intp],
    ) -> None:
        sent, received = (
            [words, (np.diff(begins), begins[:-1]), self._mpi.UINT64_T]
            for words, begins in ((outgoing, starts), (incoming, froms))
        )
        self._communicator.Alltoallv(sent, received)


def shares(communicator: Communicator, n: int) -> tuple[int, int, int]:
    """How many particles lower ranks have, the most that a rank has, and all, `n` being this rank's: a reduction."""
    counts = np.zeros(communicator.ranks, np.uint64)
    counts[communicator.rank] = n
    communicator.reduce("sum", counts)
    return int(counts[: communicator.rank].sum()), int(counts.max()), int(counts.sum())


@contextlib.contextmanager
def lent(communicator: Communicator | None, frame: _library.Frame, callbacks: _library.Callbacks) -> Iterator[None]:
    """Lends the communicator to the call that is made in the block. Its methods run in the thread that makes it."""
    if communicator is None:
        yield
        return
    ranks = communicator.ranks
    operations = {lib.MOLLIS_REDUCE_SUM: "sum", lib.MOLLIS_REDUCE_MAX: "max"}

    def reduce(_context: Any, operation: int, words: Any, count: int) -> int:
        communicator.reduce(operations[operation], _words(words, count))
        return 0

    def exchange(_context: Any, outgoing: Any, starts: Any, incoming: Any, froms: Any) -> int:
        begins, others = (np.array(ffi.unpack(at, ranks + 1), np.intp) for at in (starts, froms))
        sent = _words(outgoing, begins[-1])
        sent.flags.writeable = False
        communicator.exchange(sent, begins, _words(incoming, others[-1]), others)
        return 0

    functions = {
        "reduce": ffi.callback("int32_t(void *, int32_t, uint64_t *, size_t)", callbacks.here(reduce)),
        "exchange": ffi.callback(
            "int32_t(void *, const uint64_t *, const size_t *, uint64_t *, const size_t *)", callbacks.here(exchange)
        ),
    }
    struct = ffi.new("mollis_communicator *", {"rank": communicator.rank, "ranks": ranks, **functions})
    frame.run.communicator = struct
    try:
        yield
    finally:
        frame.run.communicator = ffi.NULL


def _words(at: Any, count: int) -> NDArray[np.uint64]:
    """The words at an address, where they are."""
    if count == 0:
        return np.empty(0, np.uint64)
    return np.frombuffer(ffi.buffer(at, 8 * int(count)), np.uint64)

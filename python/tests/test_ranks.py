"""Coalescing particles spread over ranks, which are threads here: bit for bit what one process computes."""

import sys
import threading
import types

import numpy as np
import pytest

import mollis
from mollis import pks

N = 2000


class World:
    """What the ranks have in common. The call number `fails_at` of rank `fails_on` raises."""

    def __init__(self, ranks, fails_on=0, fails_at=None):
        self.barrier = threading.Barrier(ranks, timeout=60)
        self.offers = [None] * ranks
        self.fails_on, self.fails_at = fails_on, fails_at

    def run(self, body):
        """Calls the body with each rank; what it returns or raises, in the order of the ranks."""
        outcomes = [None] * len(self.offers)

        def work(rank):
            try:
                outcomes[rank] = body(Rank(self, rank))
            except BaseException as failure:
                outcomes[rank] = failure

        threads = [threading.Thread(target=work, args=(rank,)) for rank in range(len(outcomes))]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        return outcomes


class Rank:
    """A communicator."""

    def __init__(self, world, rank):
        self.world, self.rank, self.ranks = world, rank, len(world.offers)
        self.calls = 0

    def meet(self, offer):
        """What each rank offers, until all have looked at it."""
        if self.rank == self.world.fails_on and self.calls == self.world.fails_at:
            self.world.barrier.abort()
            raise OSError("the cable is cut")
        self.calls += 1
        self.world.offers[self.rank] = offer
        self.world.barrier.wait()
        yield from self.world.offers
        self.world.barrier.wait()

    def reduce(self, operation, words):
        reduction = {"sum": np.add, "max": np.maximum}[operation]
        total = np.zeros_like(words)
        for theirs in self.meet(words.copy()):
            reduction(total, theirs, out=total)
        words[:] = total

    def exchange(self, outgoing, starts, incoming, froms):
        assert not outgoing.flags.writeable
        for rank, (theirs, begins) in enumerate(self.meet((outgoing.copy(), starts))):
            incoming[froms[rank] : froms[rank + 1]] = theirs[begins[self.rank] : begins[self.rank + 1]]


@pytest.fixture
def crowd(rng):
    """A supercritical disc."""
    r, angle = np.sqrt(rng.random(N)), rng.uniform(0, 2 * np.pi, N)
    return np.c_[r * np.cos(angle), r * np.sin(angle)]


def particles(crowd, ends=(0, N), rank=0, **keywords):
    """Those of one rank."""
    mine = slice(ends[rank], ends[rank + 1])
    mesh = mollis.Mesh((-1.5, -1.5), (1.5, 1.5), (24, 24))
    species = np.arange(N)[mine] % 5
    how = dict(chi=1.0, noise=75.0 / N, attraction=mesh, random=7, species=species, threads=1) | keywords
    return pks.Particles(crowd[mine], np.full(len(species), 75.0 / N), **how)


@pytest.mark.parametrize("dtype", [np.float64, np.float32])
@pytest.mark.parametrize("ends", [(0, N), (0, 700, N), (0, 500, 1000, 1500, N), (0, 0, N)])
def test_ranks_do_what_one_process_does(crowd, ends, dtype):
    crowd = crowd.astype(dtype)
    one = particles(crowd)
    events = [one.step(1e-3, steps) for steps in (4, 2)]
    assert len(events[0].table) > 0

    def body(rank):
        run = particles(crowd, ends, rank.rank, communicator=rank)
        return run, [run.step(1e-3, 4), run.step(1e-3, 2, progress=lambda run: None)]

    outcomes = World(len(ends) - 1).run(body)
    for name in ("positions", "masses", "labels", "species"):
        together = np.concatenate([getattr(run, name) for run, _ in outcomes])
        np.testing.assert_array_equal(together, getattr(one, name))
    for run, told in outcomes:
        assert (run.time, run.steps, run.report.merges) == (one.time, one.steps, one.report.merges)
        for got, want in zip(told, events):
            np.testing.assert_array_equal(got.table, want.table)
            np.testing.assert_array_equal(got.labels, want.labels)
    assert sum(run.report.substeps for run, _ in outcomes) == one.report.substeps


@pytest.mark.parametrize("fails_at", [2, 3, 8])
def test_a_failing_call_raises_its_own_exception(crowd, fails_at):
    ends = (0, 700, N)
    before = [crowd[:700], crowd[700:]]
    made = [None, None]

    def body(rank):
        made[rank.rank] = particles(crowd, ends, rank.rank, communicator=rank)
        made[rank.rank].step(1e-3)

    first, second = World(2, 1, fails_at).run(body)
    assert isinstance(second, OSError) and isinstance(first, threading.BrokenBarrierError)
    for run, x in zip(made, before):
        assert run.steps == 0
        np.testing.assert_array_equal(run.positions, x)
    # A later call of the thread knows nothing of the ranks.
    particles(crowd).step(1e-3)


def test_an_error_of_one_rank_is_that_of_all(crowd):
    crowd[900, 1] = np.nan

    def body(rank):
        particles(crowd, (0, 700, N), rank.rank, communicator=rank).step(1e-3)

    first, second = World(2).run(body)
    assert first.status == second.status == mollis.Status.NOT_FINITE
    assert (first.first_bad, second.first_bad) == (None, 200)


def test_what_ranks_refuse(crowd):
    def with_a_stream(rank):
        particles(crowd, (0, 700, N), rank.rank, communicator=rank, random=np.random.default_rng(1)).step(1e-3)

    def other_steps(rank):
        particles(crowd, (0, 700, N), rank.rank, communicator=rank).step(1e-3 * (1 + rank.rank))

    for body, status in [(with_a_stream, mollis.Status.UNSUPPORTED), (other_steps, mollis.Status.COMMUNICATOR)]:
        assert [failure.status for failure in World(2).run(body)] == [status] * 2
    with pytest.raises(ValueError, match="copied"):
        pks.Particles(crowd, np.ones(N), copy=False, communicator=Rank(World(1), 0))


def test_the_adapter_for_mpi4py(crowd, monkeypatch):
    """Calls by mpi4py's names come out as those of its ranks."""
    names = types.SimpleNamespace(UINT64_T="words", SUM="sum", MAX="max", IN_PLACE="in place")
    package = types.ModuleType("mpi4py")
    package.MPI = names
    monkeypatch.setitem(sys.modules, "mpi4py", package)

    class Comm:
        def __init__(self, rank):
            self.rank = rank
            self.Get_rank, self.Get_size = lambda: rank.rank, lambda: rank.ranks

        def Allreduce(self, sent, received, op):
            words, kind = received
            assert (sent, kind) == ("in place", "words")
            self.rank.reduce(op, words)

        def Alltoallv(self, sent, received):
            (outgoing, sent_at, kind), (incoming, received_at, _) = sent, received
            assert kind == "words"
            begins, froms = ([*at, at[-1] + counts[-1]] for counts, at in (sent_at, received_at))
            self.rank.exchange(outgoing, begins, incoming, froms)

    ends, one = (0, 700, N), particles(crowd)
    one.step(1e-3, 2)

    def body(rank):
        run = particles(crowd, ends, rank.rank, communicator=pks.Mpi(Comm(rank)))
        run.step(1e-3, 2)
        return run.positions

    np.testing.assert_array_equal(np.concatenate(World(2).run(body)), one.positions)

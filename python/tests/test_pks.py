"""Coalescing particles: conservation, generators, interruption, and fields on a mesh."""

import os
import signal
import threading

import numpy as np
import pytest
import reference

import mollis
from mollis import kernels, mollifiers, pks


@pytest.fixture
def disc(rng):
    """400 particles of a supercritical mass: they collapse."""
    r, angle = np.sqrt(rng.random(400)), rng.uniform(0, 2 * np.pi, 400)
    return np.c_[r * np.cos(angle), r * np.sin(angle)], np.full(400, 32 * np.pi / 400)


@pytest.fixture
def attraction():
    return mollis.Kernel(kernels.newtonian(), mollifiers.compact(2, 4), 1e-3)


def system(disc, attraction, **keywords):
    x, m = disc
    return pks.Particles(x, m, chi=1.0, noise=32 * np.pi / 400, attraction=attraction, **keywords)


def test_mass_is_kept_and_events_tell_who_merged(disc, attraction):
    run = system(disc, attraction, random=1, species=np.arange(400) % 3)
    events = run.step(1e-3, 100)
    assert 0 < len(events.table) == run.report.merges
    assert len(run) == 400 - run.report.absorbed == len(run.masses) == len(run.labels) == len(run.species)
    assert run.masses.sum() == pytest.approx(32 * np.pi, rel=1e-14)
    assert run.steps == 100 and run.time == pytest.approx(0.1)
    mass = dict(enumerate(disc[1]))
    for i, event in enumerate(events.table):
        absorbed = events.absorbed(i)
        assert len(absorbed) == event["absorbed"] and (absorbed > event["label"]).all()
        mass[event["label"]] += sum(mass.pop(label) for label in absorbed)
        assert mass[event["label"]] == pytest.approx(event["mass"], rel=1e-14)
    assert sorted(mass) == run.labels.tolist()
    np.testing.assert_allclose([mass[label] for label in run.labels], run.masses, rtol=1e-14)
    np.testing.assert_array_equal(run.species, run.labels % 3)


def test_sensitivities(disc, attraction):
    """Weights of m / chi_i: merging adds them, equal ones change no bit, the noise is that of the weight."""
    plain = system(disc, attraction, random=1)
    plain.step(1e-3, 20)
    equal = system(disc, attraction, random=1, weights=disc[1])
    equal.step(1e-3, 20)
    np.testing.assert_array_equal(equal.positions, plain.positions)
    np.testing.assert_array_equal(equal.weights, plain.masses)
    assert plain.weights is None
    weights = disc[1] / np.where(np.arange(400) % 2, 0.5, 2.0)
    run = system(disc, attraction, random=1, weights=weights)
    run.step(1e-3, 40)
    assert len(run) < 400 and run.weights.sum() == pytest.approx(weights.sum(), rel=1e-14)
    with pytest.raises(ValueError, match="weights"):
        system(disc, attraction, weights=weights[1:])
    with pytest.raises(mollis.Error):
        system(disc, attraction, weights=0 * weights).step(1e-3)


@pytest.mark.parametrize("mesh", [False, True])
def test_threads_and_pieces_change_no_bit(disc, attraction, mesh):
    how = mollis.Mesh((-2, -2), (2, 2), (32, 32)) if mesh else attraction
    one = system(disc, how, random=5, threads=1)
    one.step(1e-3, 40)
    for threads in (2, 3):
        other = system(disc, how, random=5, threads=threads)
        for steps in (1, 9, 30):
            other.step(1e-3, steps)
        np.testing.assert_array_equal(one.positions, other.positions)
        np.testing.assert_array_equal(one.labels, other.labels)
    half = system(disc, how, random=5)
    half.step(1e-3, 20)
    state = (half.positions, half.masses)
    rest = system(state, how, random=5, labels=half.labels, time=half.time, steps=half.steps)
    rest.step(1e-3, 20)
    np.testing.assert_array_equal(one.positions, rest.positions)
    assert (rest.time, rest.steps) == (one.time, one.steps)
    other = system(disc, how, random=6)
    other.step(1e-3, 40)
    assert one.positions[0, 0] != other.positions[0, 0]


@pytest.mark.parametrize("bits", [np.random.PCG64, np.random.MT19937, np.random.Philox])
def test_generators_of_numpy(disc, attraction, bits):
    runs = [system(disc, attraction, random=np.random.Generator(bits(3))) for _ in range(2)]
    for run in runs:
        run.step(1e-3, 20)
    np.testing.assert_array_equal(runs[0].positions, runs[1].positions)
    other = system(disc, attraction, random=np.random.Generator(bits(4)))
    other.step(1e-3, 20)
    assert runs[0].positions[0, 0] != other.positions[0, 0]


@pytest.mark.parametrize("source", [3, np.random.default_rng(3), np.random.Generator(np.random.MT19937(3))])
def test_diffusion(source):
    """Without attraction a particle of mass m moves by a normal number of variance 2 noise dt / m along each axis."""
    run = pks.Particles(np.zeros((20_000, 2)), np.full(20_000, 0.5), noise=0.1, merging="never", random=source)
    run.step(0.01, 4)
    normal = run.positions.ravel() / np.sqrt(2 * 0.1 * 0.04 / 0.5)
    n = normal.size
    assert abs(normal.mean()) < 4 / np.sqrt(n) and abs((normal**2).mean() - 1) < 4 * np.sqrt(2 / n)
    assert abs((normal**4).mean() - 3) < 4 * np.sqrt(96 / n)
    assert abs(np.corrcoef(run.positions.T)[0, 1]) < 4 / np.sqrt(n / 2)


def test_an_exception_of_a_generator(disc, attraction):
    class Broken(np.random.Generator):
        def integers(self, *arguments, **keywords):
            raise OSError("no entropy")

    run = system(disc, attraction, random=Broken(np.random.PCG64(1)))
    with pytest.raises(OSError, match="no entropy"):
        run.step(1e-3, 5)
    assert run.steps == 0
    np.testing.assert_array_equal(run.positions, disc[0])


def test_drift_without_noise(rng, attraction):
    """A step of Euler's method: x - chi dt sum m g (x - x_i)."""
    x, m = rng.random((50, 2)), rng.random(50)
    run = pks.Particles(x, m, chi=0.5, attraction=attraction, merging="never")
    run.step(1e-6, 1)
    g = reference.gradient(x, x, m, lambda r: reference.compact(r, 1e-3, 4, 2, 2)[1])
    np.testing.assert_allclose((run.positions - x) / 1e-6, -0.5 * g, rtol=0, atol=1e-3 * np.abs(g).max())


def test_in_place(disc, attraction):
    x, m = (a.copy() for a in disc)
    run = system((x, m), attraction, copy=False)
    assert np.shares_memory(run.positions, x) and np.shares_memory(run.masses, m)
    run.step(1e-3, 1)
    assert (x != disc[0]).any()
    kept = system(disc, attraction)
    assert not np.shares_memory(kept.positions, disc[0])
    with pytest.raises(ValueError, match="gaps"):
        system((np.zeros((400, 3))[:, :2], m), attraction, copy=False)


def test_float32(disc):
    x, m = (a.astype(np.float32) for a in disc)
    kernel = mollis.Kernel(kernels.newtonian(), mollifiers.compact(2, 4), 1e-3, dtype=np.float32)
    run = system((x, m), kernel, random=1)
    assert run.positions.dtype == run.masses.dtype == np.float32
    assert len(run.step(1e-3, 50).table) > 0
    with pytest.raises(ValueError, match="float64"):
        system(disc, kernel)


def test_progress_and_ctrl_c(disc, attraction):
    run, times = system(disc, attraction), []
    run.step(1e-3, 5, progress=lambda r: times.append(r.time))
    np.testing.assert_allclose(times, np.arange(1, 6) * 1e-3)
    run.step(1e-3, 50, progress=lambda r: r.steps == 8)
    assert run.steps == 8
    timer = threading.Timer(0.5, os.kill, (os.getpid(), signal.SIGINT))
    timer.start()
    with pytest.raises(KeyboardInterrupt) as caught:
        run.step(1e-9, 10**8)
    timer.join()
    assert 8 < run.steps < 10**8 and isinstance(caught.value.report, pks.Events)
    again = system(disc, attraction)
    again.step(1e-3, 8)
    again.step(1e-9, run.steps - 8)
    np.testing.assert_array_equal(run.positions, again.positions)


def test_errors(disc, attraction):
    x, m = disc
    with pytest.raises(mollis.Error) as caught:
        system((x, -m), attraction).step(1e-3)
    assert caught.value.status is mollis.Status.MASS
    bad = x.copy()
    bad[9, 1] = np.nan
    with pytest.raises(mollis.Error) as caught:
        system((bad, m), attraction).step(1e-3)
    assert caught.value.first_bad == 9
    with pytest.raises(mollis.Error) as caught:
        system(disc, attraction).step(0.0)
    assert caught.value.status is mollis.Status.TIME_STEP
    with pytest.raises(ValueError, match="exact, printed"):
        system(disc, attraction, law="other")
    with pytest.raises(TypeError, match="attraction"):
        system(disc, "mesh")
    with pytest.raises(ValueError, match="labels"):
        system(disc, attraction, labels=[1, 2])
    run = system(disc, attraction, at_most=1, at_least=2)
    with pytest.raises(mollis.Error):
        run.step(1e-3)


def test_heavy_particles_beside_a_mesh(disc, attraction):
    """Two particles, one of them heavy: the pair's attraction, which a coarse mesh cannot show."""
    mesh = mollis.Mesh((-2, -2), (2, 2), (16, 16))
    x, m = np.array([[0.0, 0.0], [0.1, 0.0]]), np.array([1.0, 1e-3])
    kernel = mollis.Kernel(kernels.newtonian(), mollifiers.compact(2, 4), 0.05)
    moved = []
    for keywords in ({}, {"heavy": 0.5, "heavy_kernel": kernel}):
        run = pks.Particles(x, m, chi=1.0, attraction=mesh, merging="never", **keywords)
        run.step(1e-6, 1)
        moved.append((run.positions[1, 0] - 0.1) / 1e-6)
    exact = -1 / (2 * np.pi * 0.1)
    assert moved[1] == pytest.approx(exact, rel=1e-3) and abs(moved[0] / exact - 1) > 0.2


@pytest.mark.parametrize("order", [2, 4])
def test_field_on_a_mesh(rng, order):
    """Far from the sources the field of the mesh is that of the pairs."""
    x, m = 0.2 * rng.standard_normal((500, 2)), rng.random(500)
    mesh = (
        mollis.Mesh((-2, -2), (2, 2), (64, 48), walls="free-quadrupole", order=order)
        if order == 2
        else (mollis.Mesh((-2, -2), (2, 2), (64, 64), walls="free-quadrupole", order=order))
    )
    at = np.array([[1.1, 0.3], [-0.9, -1.0], [0.4, 1.5]])
    result = mesh.field(x, m, at, gradient=True, node_mass=True, node_potential=True, node_gradient=True)
    exact = reference.gradient(at, x, m, lambda r: 1 / (2 * np.pi * r**2))
    np.testing.assert_allclose(result.gradient, exact, rtol=0, atol=5e-3 * np.abs(exact).max())
    shape = (mesh.cells[1] + 1, mesh.cells[0] + 1)
    assert result.node_mass.shape == result.node_potential.shape == shape and result.node_gradient.shape == (*shape, 2)
    assert result.node_mass.sum() == pytest.approx(m.sum(), rel=1e-12) and result.outside == 0
    np.testing.assert_allclose(result.total, [m.sum(), *(m @ x / m.sum())], rtol=1e-12)
    # Differences along x run along the last axis.
    middle = result.node_potential[5, 8], result.node_potential[5, 10]
    assert (middle[1] - middle[0]) / (8 / 64) == pytest.approx(result.node_gradient[5, 9, 0], rel=0.05)
    strided = np.zeros((3, 4))
    mesh.field(x, m, at, gradient=strided[:, 1:3])
    np.testing.assert_array_equal(strided[:, 1:3], result.gradient)
    with pytest.raises(mollis.Error) as caught:
        mesh.field(np.r_[x, [[np.nan, 0]]], 1.0, gradient=True)
    assert caught.value.first_bad == 500
    assert mesh.field([[5.0, 0.0]], 1.0).outside == 1


def test_screening_and_walls(rng):
    x, m = 0.3 * rng.standard_normal((200, 2)), rng.random(200)
    free = mollis.Mesh((-2, -2), (2, 2), (64, 64)).field(x, m, [[1.0, 0.5]], gradient=True).gradient
    screened = mollis.Mesh((-2, -2), (2, 2), (64, 64), screening=3.0).field(x, m, [[1.0, 0.5]], gradient=True).gradient
    assert np.linalg.norm(screened) < 0.6 * np.linalg.norm(free)
    walls = mollis.Mesh((-2, -2), (2, 2), (64, 64), walls="no-flux").field(x, m, [[1.999, 0.5]], gradient=True).gradient
    assert abs(walls[0, 0]) < 0.05 * np.linalg.norm(free)
    with pytest.raises(ValueError, match="no-flux"):
        mollis.Mesh((-2, -2), (2, 2), (64, 64), walls="periodic").field(x, m)


def test_a_medium(rng):
    """An even medium of G = 4 has a quarter of the field; the index of a pair has the gamma of its place."""
    x, m = 0.3 * rng.standard_normal((200, 2)), rng.random(200)
    rectangle = ((-2, -2), (2, 2), (40, 48))
    plain = mollis.Mesh(*rectangle).field(x, m, gradient=True).gradient
    even = mollis.Medium(np.full((49, 41), 4.0))
    field = mollis.Mesh(*rectangle, medium=even).field(x, m, gradient=True).gradient
    np.testing.assert_allclose(4 * field, plain, rtol=0, atol=1e-9 * np.abs(plain).max())
    assert even.report[0] <= 2 and even.report[1] <= 1e-10
    g = np.ones((49, 41))
    g[20:30, 10:20] = 10.0
    short = mollis.Medium(g, np.ones((49, 41)), iterations=2)
    with pytest.raises(mollis.Error) as caught:
        mollis.Mesh(*rectangle, medium=short).field(x, m, gradient=True)
    assert caught.value.status == mollis.Status.NOT_CONVERGED and short.report[0] == 2
    with pytest.raises(ValueError, match="diffusivity"):
        mollis.Mesh(*rectangle, medium=mollis.Medium(np.ones((41, 49)))).field(x, m, gradient=True)
    pair = np.array([[0.5, 0.5], [0.5 + 1e-9, 0.5]])
    run = pks.Particles(pair, [1.0, 2.0], chi=1.0, noise=1e-3, attraction=mollis.Mesh(*rectangle, medium=even))
    events = run.step(1e-6)
    assert events.table["index"][0] == pytest.approx(-4 / (2 * np.pi * 4) / (4 * 1e-3), rel=1e-9)


def test_closed_forms():
    """The critical mass, rates and shares of docs/pks.md, and the index of a pair."""
    known = pks.predict(mass=16 * np.pi, mu=1.0, chi=1.0, second_moment=3.0)
    assert known.critical_mass == pytest.approx(8 * np.pi)
    # d/dt of the second moment: 4 mu M - chi M^2 / (2 pi), and the bound is the moment over its rate.
    assert known.second_moment_rate == pytest.approx(4 - 16 * np.pi / (2 * np.pi))
    assert known.blow_up_bound == pytest.approx(3.0 / (16 * np.pi) / 4)
    assert pks.predict(1.0, 1.0, 0.0, 1.0).critical_mass == np.inf
    # Between masses M and m the squared distance is a Bessel process of index nu = -chi gamma (m_1 m_2) / (2 mu~).
    assert pks.index([2.0, 3.0], chi=1.5, noise=0.1, gamma=0.2).nu == pytest.approx(-1.5 * 0.2 * 6 / (2 * 0.1))
    shared = pks.represent_species([1.0, 3.0], [2.0, 0.5], chi=1.0, particles=1000)
    # eta_i = M_i mu_i / sum, docs/pks.md.
    np.testing.assert_allclose(shared.share, np.array([2.0, 1.5]) / 3.5)
    # With sensitivities mu_i / chi_i stands for mu_i, docs/pks.md.
    shared = pks.represent_species([1.0, 3.0], [2.0, 0.5], chi=1.0, particles=1000, sensitivities=[0.5, 2.0])
    np.testing.assert_allclose(shared.share, np.array([4.0, 0.75]) / 4.75)
    assert shared.rate == pytest.approx(4 * 4.75 - 16 / (2 * np.pi))
    with pytest.raises(mollis.Error):
        pks.predict(np.nan, 1.0, 1.0, 1.0)

"""The blob method against NumPy's Runge-Kutta, and how runs end."""

import os
import signal
import threading

import numpy as np
import pytest
import reference

import mollis
from mollis import kernels, mollifiers


@pytest.fixture
def particles(rng):
    return rng.random((120, 2)), rng.random(120) / 120


# Steps add 16 sums of 120 terms, of masses that sum to at most 1: errors are some u of the coordinates, which are
# below 1.


def velocity_of(m, delta=0.3):
    return lambda x: -reference.gradient(x, x, m, lambda r: reference.compact(r, delta, 4, 2, 2)[1])


def test_steps_are_those_of_runge_and_kutta(particles, soft):
    x, m = particles
    moved = x.copy()
    run = mollis.blob(soft, moved, m, dt=0.05, steps=4, velocity=True)
    expected = reference.runge_kutta(x, 0.05, 4, velocity_of(m))
    np.testing.assert_allclose(moved, expected, rtol=0, atol=1e-14)
    np.testing.assert_allclose(run.velocity, velocity_of(m)(expected), rtol=0, atol=1e-14)
    assert run.steps == 4 and np.isnan(run.energy_first) and run.divergence is None


def test_density_tracers_and_divergence(particles, soft):
    """rho' = (Laplacian u) rho along the trajectories; a tracer at a particle's place moves as it does."""
    x, m = particles
    moved, rho, tracers, tracer_rho = x.copy(), np.ones(120), x[:7].copy(), np.ones(7)
    run = mollis.blob(
        soft,
        moved,
        m,
        0.05,
        4,
        density=rho,
        divergence=True,
        tracers=tracers,
        tracer_density=tracer_rho,
        tracer_velocity=True,
    )

    def laplacian(x):
        return reference.potential(x, x, m, lambda r: reference.compact(r, 0.3, 4, 2, 2)[0])

    joint = reference.runge_kutta(
        np.c_[x, np.ones(120)], 0.05, 4, lambda y: np.c_[velocity_of(m)(y[:, :2]), laplacian(y[:, :2]) * y[:, 2]]
    )
    np.testing.assert_allclose(rho, joint[:, 2], rtol=1e-13)
    np.testing.assert_allclose(tracers, moved[:7], rtol=0, atol=1e-15)
    np.testing.assert_allclose(tracer_rho, rho[:7], rtol=1e-14)
    np.testing.assert_allclose(run.divergence, -laplacian(joint[:, :2]), rtol=1e-12)
    assert run.tracer_velocity.shape == (7, 2)


@pytest.mark.parametrize("dtype", [np.float64, np.float32])
def test_arrays_with_gaps(particles, dtype):
    x, m = (a.astype(dtype) for a in particles)
    kernel = mollis.Kernel(kernels.newtonian(), mollifiers.compact(2, 4), 0.3, dtype=dtype)
    plain, rho = x.copy(), np.ones(120, dtype)
    mollis.blob(kernel, plain, m, 0.05, 3, density=rho)
    vortex = np.zeros(120, [("x", dtype, 2), ("rho", dtype), ("m", dtype), ("v", dtype, 2)])
    vortex["x"], vortex["m"], vortex["rho"] = x, m, 1
    mollis.blob(kernel, vortex["x"], vortex["m"], 0.05, 3, density=vortex["rho"], velocity=vortex["v"])
    np.testing.assert_array_equal(vortex["x"], plain)
    np.testing.assert_array_equal(vortex["rho"], rho)
    assert (vortex["v"] != 0).all()
    with pytest.raises(TypeError, match="positions"):
        mollis.blob(kernel, x.astype(np.float16), m, 0.05, 3)


def test_threads_change_no_bit(rng, soft):
    x, m = rng.random((2000, 2)), rng.random(2000) / 2000
    results = []
    for threads in (1, 2, 3, None):
        moved = x.copy()
        mollis.blob(soft, moved, m, 0.01, 2, threads=threads)
        results.append(moved)
    for other in results[1:]:
        np.testing.assert_array_equal(results[0], other)


def test_energy(particles, soft):
    x, m = particles
    before = 0.5 * m @ mollis.field(soft, x, m, potential=True).potential
    run = mollis.blob(soft, x.copy(), m, 0.05, 5, watch_energy=True)
    assert run.energy_first == pytest.approx(before, rel=1e-13) and run.energy_last < run.energy_first
    assert mollis.diagnostics.energy(soft, x, m) == pytest.approx(before, rel=1e-13)
    with pytest.raises(mollis.Error) as caught:
        mollis.blob(soft, x.copy(), -m, 0.05, 5, watch_energy=True)
    assert caught.value.status is mollis.Status.MASS


def test_vortices_turn(particles, soft):
    """Velocities are minus the gradient output of a sum; a pair turns at (m + m') / (2 pi r^2), counter-clockwise."""
    x, m = particles
    run = mollis.blob(soft, x.copy(), m, 0.05, 0, velocity=True, divergence=True, combination=(0.5, -2))
    mixed = mollis.field(soft, x, m, gradient=True, laplacian=True, combination=(0.5, -2))
    np.testing.assert_array_equal(run.velocity, -mixed.gradient)
    np.testing.assert_array_equal(run.divergence, -0.5 * mixed.laplacian)
    pair = np.array([[0.5, 0.0], [-0.5, 0.0]])
    time = np.pi**2  # a quarter of a turn
    run = mollis.blob(soft, pair, [0.5, 0.5], time / 100, 100, combination=(0, -1), watch_energy=True)
    np.testing.assert_allclose(pair, [[0, 0.5], [0, -0.5]], atol=1e-8)
    assert run.energy_last == pytest.approx(run.energy_first, rel=1e-8)
    line = mollis.Kernel(kernels.newtonian(), mollifiers.compact(2, 4), 0.3, dimension=1)
    with pytest.raises(mollis.Error) as caught:
        mollis.blob(line, np.zeros((1, 1)), [1.0], 0.1, 1, combination=(0, -1))
    assert caught.value.status is mollis.Status.UNSUPPORTED


def test_diffusion():
    """The heat equation widens a Gaussian's variance by 2 nu t; m = 2 is minus twice the gradient of the density."""
    h = 0.05
    x = np.arange(-5, 5, h)[:, None] + h / 2
    m = h * np.exp(-x[:, 0] ** 2 / 2) / np.sqrt(2 * np.pi)
    still = mollis.Kernel(kernels.newtonian(0.0), mollifiers.compact(2, 4), 1.0, dimension=1)
    heat = mollis.Diffusion(1.0, mollifier=mollifiers.gaussian(2), length=3 * h)
    run = mollis.blob(still, x, m, 0.01, 50, diffusion=heat, watch_energy=True)
    assert (m * x[:, 0] ** 2).sum() == pytest.approx(2, rel=5e-3)
    assert run.energy_last < run.energy_first
    two, masses = np.array([[0.0], [0.5]]), [1.0, 1.0]
    run = mollis.blob(still, two, masses, 0.1, 0, velocity=True, diffusion=mollis.Diffusion(0.5, 2.0, mollifiers.compact(2, 4), 1.0))
    speed = 315 / 256 * 4 * (3 / 4) ** 3
    np.testing.assert_allclose(run.velocity, [[-speed], [speed]], rtol=1e-13)
    for wrong, status in [
        (mollis.Diffusion(1.0), mollis.Status.DELTA),
        (mollis.Diffusion(1.0, 0.5, length=1.0), mollis.Status.OUT_OF_DOMAIN),
        (mollis.Diffusion(1.0, 1.0, mollifiers.compact(4, 4), 1.0), mollis.Status.SIGN_CHANGE),
    ]:
        with pytest.raises(mollis.Error) as caught:
            mollis.blob(still, two, masses, 0.1, 1, diffusion=wrong)
        assert caught.value.status is status


def test_progress_sees_every_step(particles, soft):
    x, m = particles
    seen, caller = [], threading.current_thread()

    def progress(steps, positions, density):
        assert threading.current_thread() is caller
        assert not positions.flags.writeable and density is None
        # A call inside a call has structures and a workspace of its own.
        mollis.field(soft, np.random.rand(300, 2), 1.0, gradient=True)
        seen.append((steps, positions.copy()))

    moved = x.copy()
    mollis.blob(soft, moved, m, 0.05, 4, progress=progress)
    plain = x.copy()
    for steps, positions in seen:
        mollis.blob(soft, plain, m, 0.05, 1)
        np.testing.assert_allclose(positions, plain, rtol=0, atol=1e-15)
    assert [s for s, _ in seen] == [1, 2, 3, 4]
    np.testing.assert_array_equal(seen[-1][1], moved)


def test_progress_ends_the_run(particles, soft):
    x, m = particles
    three = x.copy()
    mollis.blob(soft, three, m, 0.05, 3)
    moved = x.copy()
    run = mollis.blob(
        soft, moved, m, 0.05, 9, velocity=True, progress=lambda steps, *_: np.bool_(steps == 3) or [steps]
    )
    assert run.steps == 3 and run.velocity is None
    np.testing.assert_array_equal(moved, three)

    def failing(steps, positions, density):
        if steps == 3:
            raise KeyError("mine")

    moved = x.copy()
    with pytest.raises(KeyError, match="mine") as caught:
        mollis.blob(soft, moved, m, 0.05, 9, progress=failing)
    assert caught.value.report.steps == 3
    np.testing.assert_array_equal(moved, three)


@pytest.mark.parametrize("threads", [1, 2])
@pytest.mark.parametrize("with_progress", [False, True])
def test_ctrl_c(rng, soft, threads, with_progress):
    """SIGINT ends a run that would take hours; the arrays hold the state after `report.steps` steps."""
    x, m = rng.random((3000, 2)), rng.random(3000) / 3000
    moved, forever = x.copy(), 10**7
    timer = threading.Timer(0.7, os.kill, (os.getpid(), signal.SIGINT))
    timer.start()
    with pytest.raises(KeyboardInterrupt) as caught:
        mollis.blob(
            soft, moved, m, 1e-3, forever, threads=threads, progress=(lambda *_: None) if with_progress else None
        )
    timer.join()
    steps = caught.value.report.steps
    assert 0 < steps < forever
    again = x.copy()
    mollis.blob(soft, again, m, 1e-3, steps)
    np.testing.assert_array_equal(moved, again)
    assert not [t for t in threading.enumerate() if t.name == "mollis"]


def test_ctrl_c_in_a_long_sum(rng, soft):
    """All pairs of these particles would take hours."""
    x = rng.random((5_000_000, 2))
    timer = threading.Timer(0.5, os.kill, (os.getpid(), signal.SIGINT))
    timer.start()
    with pytest.raises(KeyboardInterrupt):
        mollis.field(soft, x, 1.0, potential=True, method="direct")
    timer.join()


def test_no_call_outlives_an_interrupt(rng, soft):
    """Wherever in its beginning an interrupt finds a long sum, the sum has ended when the exception arrives."""
    x = rng.random((100_000, 2))

    def interrupt(*_):
        raise KeyboardInterrupt

    before = signal.signal(signal.SIGALRM, interrupt)
    try:
        for delay in np.linspace(1e-4, 4e-3, 40):
            with pytest.raises(KeyboardInterrupt):
                signal.setitimer(signal.ITIMER_REAL, delay)
                mollis.field(soft, x, 1.0, potential=True, method="direct")
            assert not [t for t in threading.enumerate() if t.name == "mollis"]
            assert signal.getsignal(signal.SIGALRM) is interrupt
    finally:
        signal.signal(signal.SIGALRM, before)


def test_ctrl_c_in_the_hosts_own_function(rng, soft):
    """A function of the host that does not come back is interrupted as it would be outside a run."""
    x, m = rng.random((300, 2)), rng.random(300) / 300
    timer = threading.Timer(0.3, os.kill, (os.getpid(), signal.SIGINT))
    timer.start()
    with pytest.raises(KeyboardInterrupt) as caught:
        mollis.blob(soft, x, m, 1e-3, 10, progress=lambda *_: threading.Event().wait(3600))
    timer.join()
    assert caught.value.report.steps == 1


def test_in_another_thread_of_the_host(particles, soft):
    """Calls from other threads than the main one run there, callbacks too."""
    x, m = particles
    moved, plain, seen = x.copy(), x.copy(), []
    worker = threading.Thread(
        target=lambda: mollis.blob(soft, moved, m, 0.05, 3, progress=lambda *_: seen.append(threading.current_thread()))
    )
    worker.start()
    worker.join()
    mollis.blob(soft, plain, m, 0.05, 3)
    np.testing.assert_array_equal(moved, plain)
    assert seen == [worker] * 3


def test_errors(particles, soft):
    x, m = particles
    for dt in (0.0, -1.0, np.nan):
        with pytest.raises(mollis.Error) as caught:
            mollis.blob(soft, x.copy(), m, dt, 1)
        assert caught.value.status is mollis.Status.TIME_STEP
    bad = x.copy()
    bad[5, 0] = np.inf
    with pytest.raises(mollis.Error) as caught:
        mollis.blob(soft, bad, m, 0.1, 1)
    assert caught.value.first_bad == 5 and caught.value.report.steps == 0
    tracers = x[:3].copy()
    tracers[2, 1] = np.nan
    with pytest.raises(mollis.Error) as caught:
        mollis.blob(soft, x.copy(), m, 0.1, 1, tracers=tracers)
    assert caught.value.first_bad == 122
    with pytest.raises(TypeError, match="tracers"):
        mollis.blob(soft, x.copy(), m, 0.1, 1, tracer_density=np.ones(3))
    with pytest.raises(TypeError, match="density"):
        mollis.blob(soft, x.copy(), m, 0.1, 1, density=np.ones(120), tracers=x[:3].copy())
    with pytest.raises(TypeError, match="density is written"):
        mollis.blob(soft, x.copy(), m, 0.1, 1, density=True)
    with pytest.raises(mollis.Error) as caught:
        mollis.blob(soft, x.copy(), np.full(120, 1e300), 1e10, 3)
    assert caught.value.status is mollis.Status.BECAME_NOT_FINITE


def test_steps_may_be_none(particles, soft):
    x, m = particles
    moved = x.copy()
    run = mollis.blob(soft, moved, m, 0.0, 0, velocity=True)
    np.testing.assert_array_equal(moved, x)
    np.testing.assert_allclose(run.velocity, velocity_of(m)(x), rtol=0, atol=1e-14)

"""Mollifiers, norms, moments and random numbers."""

import numpy as np
import pytest
import reference

import mollis
from mollis import diagnostics, kernels, mollifiers


@pytest.mark.parametrize("dimension", [1, 2, 3])
@pytest.mark.parametrize("dtype, error", [(np.float64, 1e-13), (np.float32, 1e-6)])
def test_compact_mollifiers(dimension, dtype, error):
    r = np.linspace(0.05, 1.5, 30).astype(dtype).reshape(5, 6)
    f = mollifiers.compact(4, 3).radial(r, 1.0, dimension)
    psi, g = reference.compact(r, 1.0, 3, 4, dimension)
    np.testing.assert_allclose(f.density, psi, rtol=0, atol=error * 10)
    np.testing.assert_allclose(f.gradient_factor, g, rtol=error * 10)
    assert all(a.shape == (5, 6) and a.dtype == dtype for a in f)
    # The mass inside r is the flux S_N r^N g.
    np.testing.assert_allclose(f.enclosed_mass, reference.SPHERE[dimension] * r**dimension * g, rtol=error * 10)


def test_only_what_is_asked_for():
    f = mollifiers.gaussian(2).radial([0.0, 1.0], 0.5, density=True)
    np.testing.assert_allclose(f.density, np.exp([0.0, -4.0]) / (np.pi * 0.25))
    assert f.potential is None and f.enclosed_mass is None
    with pytest.raises(TypeError, match="densty"):
        mollifiers.gaussian(2).radial([0.0], 0.5, densty=True)


@pytest.mark.parametrize("dimension", [1, 2, 3])
def test_at_points(rng, dimension):
    x = rng.random((20, dimension))
    psi = mollifiers.compact(2, 4)
    f = psi.at(x, 0.8)
    r = np.sqrt((x**2).sum(axis=1))
    density, g = reference.compact(r, 0.8, 4, 2, dimension)
    np.testing.assert_allclose(f.density, density, atol=1e-13)
    np.testing.assert_allclose(f.gradient, g[:, None] * x, rtol=1e-13)
    assert f.hessian.shape == (20, dimension, dimension)
    np.testing.assert_allclose(np.trace(f.hessian, axis1=1, axis2=2), f.density, atol=1e-13)
    step = 1e-6 * np.eye(dimension)[0]
    slope = (psi.at(x + step, 0.8).gradient - psi.at(x - step, 0.8).gradient) / 2e-6
    np.testing.assert_allclose(f.hessian[:, 0], slope, atol=1e-7)
    assert psi.at(x, 0.8, potential=True).gradient is None


def test_moments_of_mollifiers():
    assert mollifiers.compact(4, 4).moment(2) == 0.0 and mollifiers.compact(4, 4).moment(0) == pytest.approx(1.0)
    assert mollifiers.gaussian(2).moment(2, delta=0.5) == pytest.approx(0.25)
    with pytest.raises(mollis.Error):
        mollifiers.compact(2, 4).moment(65)


def test_heaviside_and_richardson():
    x = np.array([-2.0, -0.3, 0.0, 0.3, 2.0])
    h = mollifiers.compact(2, 4).heaviside(x, 1.0)
    np.testing.assert_allclose(h + h[::-1], 1.0)
    np.testing.assert_array_equal(h[[0, 4]], [0.0, 1.0])
    weights, f = mollifiers.compact(2, 4).richardson([0.2], 1.0, [0.5, 1.0], density=True)
    assert weights.sum() == pytest.approx(1.0)
    parts = [mollifiers.compact(2, 4).radial([0.2], delta, density=True).density[0] for delta in (0.5, 1.0)]
    assert f.density[0] == pytest.approx(weights @ parts)
    # The second moments cancel: weights times delta^2.
    assert weights @ [0.25, 1.0] == pytest.approx(0.0, abs=1e-15)


def test_stable_steps():
    """Two particles of a quadratic attraction: every rate is the total mass."""
    kernel = mollis.Kernel(kernels.power(2.0))
    step = kernel.stable_step([[0.0, 0.0], [1.0, 0.0]], [0.5, 0.5])
    assert 2.785 / 2.1 < step <= 2.7854 / 0.9
    assert kernel.stable_step_anywhere(1.0, 1.0) <= step * 1.0001
    soft = mollis.Kernel(kernels.newtonian(), mollifiers.compact(2, 4), 0.3)
    with pytest.raises(mollis.Error) as caught:
        soft.stable_step([[0.0, 0.0], [np.nan, 0.0]], 1.0)
    assert caught.value.first_bad == 1


@pytest.mark.parametrize("dtype, error", [(np.float64, 1e-14), (np.float32, 1e-6)])
@pytest.mark.parametrize("dimension", [1, 2, 3])
def test_sums_over_particles(rng, dtype, error, dimension):
    x, m = rng.random((50, dimension)).astype(dtype), rng.standard_normal(50).astype(dtype)
    result = diagnostics.moments(x, m)
    mass = m.astype(float).sum()
    centre = m.astype(float) @ x / mass
    np.testing.assert_allclose(result.mass, mass, rtol=10 * error)
    np.testing.assert_allclose(result.absolute_mass, np.abs(m.astype(float)).sum(), rtol=10 * error)
    np.testing.assert_allclose(result.centre, centre, rtol=100 * error)
    np.testing.assert_allclose(result.second, m.astype(float) @ ((x - centre) ** 2).sum(axis=1), rtol=100 * error)
    y = x + dtype(0.5)
    expected = (0.1 * (np.linalg.norm(x.astype(float) - y, axis=1) ** 3).sum()) ** (1 / 3)
    assert diagnostics.distance_norm(x, y, cell=0.1, p=3) == pytest.approx(expected, rel=100 * error)
    density = np.full(50, 2.0, dtype)
    positive = np.abs(m)
    expected = 0.3 / ((positive.max() / 2.0) ** (1 / dimension))
    assert diagnostics.overlap(0.3, positive, density, dimension) == pytest.approx(expected, rel=100 * error)


def test_norms(rng):
    v = rng.standard_normal((7, 9))
    assert diagnostics.norm(v, 0.5, 2) == pytest.approx(np.sqrt(0.5 * (v**2).sum()))
    assert diagnostics.norm(v[::2, ::-1], p=np.inf) == np.abs(v[::2]).max()
    with pytest.raises(mollis.Error):
        diagnostics.norm(v, p=0.5)
    assert diagnostics.first_bad([[0.0, 1.0], [2.0, np.inf]]) == 1 and diagnostics.first_bad(v) is None


def test_the_sobolev_norm(rng):
    v, h = rng.standard_normal((3, 5)), 0.8
    padded = np.pad(v, 1)
    slopes = [np.diff(padded, axis=axis) / h for axis in (0, 1)]
    for p in (1.0, 2.0, 3.5):
        expected = h**2 * sum((np.abs(part) ** p).sum() for part in (v, *slopes))
        assert diagnostics.sobolev_norm(v, h, p) == pytest.approx(expected ** (1 / p))
    largest = max(np.abs(part).max() for part in (v, *slopes))
    assert diagnostics.sobolev_norm(v, h, np.inf) == pytest.approx(largest)
    # The duality of W^{1,2} and W^{-1,2}.
    w = rng.standard_normal((3, 5))
    assert h**2 * (v * w).sum() <= diagnostics.dual_norm(v, h, 12) * diagnostics.sobolev_norm(w, h)


def test_the_dual_norm(rng):
    """The norm is sqrt(h^2 v (I - Laplacian_h)^-1 v) on the lattice: a dense solution; the last axis is x."""
    v, h, margin = rng.standard_normal((3, 5)), 0.8, 12
    shape = tuple(s + 2 * margin for s in v.shape)
    padded = np.zeros(shape)
    padded[margin : margin + 3, margin : margin + 5] = v

    def second(n):
        return (np.eye(n, k=1) + np.eye(n, k=-1) - 2 * np.eye(n)) / h**2

    laplacian = np.kron(second(shape[0]), np.eye(shape[1])) + np.kron(np.eye(shape[0]), second(shape[1]))
    w = padded.ravel()
    expected = np.sqrt(h**2 * w @ np.linalg.solve(np.eye(w.size) - laplacian, w))
    assert diagnostics.dual_norm(v, h, margin) == pytest.approx(expected, rel=1e-6)


def test_random_numbers():
    """Words of the published Philox4x32-10 through NumPy's own, and the transform of Box and Muller."""
    words = mollis.random.philox_words(seed=0, label=0, step=0, substep=0)
    # The known answer of Random123 for a zero key and counter: 6627e8d5 e169c58d bc57ac4c 9b00dbd8.
    assert [hex(w) for w in words.tolist()] == ["0xe169c58d6627e8d5", "0x9b00dbd8bc57ac4c"]
    normals = mollis.random.philox_normals(7, np.arange(50_000), step=3)
    assert normals.shape == (50_000, 2) and abs(normals.std() - 1) < 0.02 and abs(normals.mean()) < 0.02
    first = mollis.random.normals(mollis.random.philox_words(7, 11, 3))
    np.testing.assert_array_equal(normals[11], first)
    assert mollis.random.philox_normals(7, [1], 0, dtype=np.float32).dtype == np.float32

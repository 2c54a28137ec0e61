"""Sums against NumPy, and the ways in which arrays lie."""

import math
import pickle
import threading

import numpy as np
import pytest
import reference

import mollis
from mollis import _library, kernels, mollifiers


def close(a, b, relative=1e-12):
    """Compares sums of at most 200 terms, relative to the largest result.

    The library's bound is (16 + 256 + n / 256) u of S = sum |m_j| |K_j|: 6e-14 S, in float32 1.6e-5 S. S is below 15
    times the largest result here, so 1e-12 and 2.5e-4. A kernel of one's own is fitted to 1e-10.
    """
    np.testing.assert_allclose(a, b, rtol=0, atol=relative * np.abs(b).max())


@pytest.mark.parametrize("dimension", [1, 2, 3])
@pytest.mark.parametrize("order", [2, 4])
@pytest.mark.parametrize("exponent", [1, 4, 9])
def test_compact(rng, dimension, order, exponent):
    x, m, delta = rng.random((60, dimension)), rng.standard_normal(60), 0.3
    kernel = mollis.Kernel(kernels.newtonian(), mollifiers.compact(order, exponent), delta, dimension)
    result = mollis.field(kernel, x, m, gradient=True, laplacian=True)
    assert result.potential is None
    close(
        result.gradient,
        reference.gradient(x, x, m, lambda r: reference.compact(r, delta, exponent, order, dimension)[1]),
    )
    density = reference.potential(x, x, m, lambda r: reference.compact(r, delta, exponent, order, dimension)[0])
    close(result.laplacian, density)


@pytest.mark.parametrize("dimension", [1, 2, 3])
@pytest.mark.parametrize("dtype, error", [(np.float64, 1e-13), (np.float32, 2.5e-4)])
def test_plummer_at_targets(rng, dimension, dtype, error):
    x, m, at = (
        rng.random((50, dimension)).astype(dtype),
        rng.random(50).astype(dtype),
        rng.random((70, dimension)).astype(dtype),
    )
    kernel = mollis.Kernel(kernels.newtonian(2.0), mollifiers.plummer(), 0.1, dimension, dtype)
    result = mollis.field(kernel, x, m, at, potential=True, gradient=True)
    assert result.potential.dtype == result.gradient.dtype == dtype
    assert result.potential.shape == (70,) and result.gradient.shape == (70, dimension)
    close(result.potential, reference.potential(at, x, 2 * m, lambda r: reference.plummer(r, 0.1, dimension)[0]), error)
    close(result.gradient, reference.gradient(at, x, 2 * m, lambda r: reference.plummer(r, 0.1, dimension)[1]), error)


@pytest.mark.parametrize("dimension", [1, 2, 3])
@pytest.mark.parametrize("dtype, error", [(np.float64, 1e-13), (np.float32, 2.5e-4)])
def test_second_derivatives(rng, dimension, dtype, error):
    x, m = rng.random((50, dimension)).astype(dtype), rng.random(50).astype(dtype)
    kernel = mollis.Kernel(kernels.newtonian(2.0), mollifiers.plummer(), 0.3, dimension, dtype)
    expected = reference.plummer_hessian(x, x, 2 * m, 0.3)
    result = mollis.field(kernel, x, m, hessian=True)
    assert result.gradient is None and result.hessian.dtype == dtype
    close(result.hessian, expected, error)
    # Fields of a structured array, and added to.
    table = np.zeros(50, [("name", np.int64), ("tide", dtype, (dimension, dimension)), ("end", dtype, (2,))])
    mollis.field(kernel, x, m, hessian=table["tide"])
    np.testing.assert_array_equal(table["tide"], result.hessian)
    mollis.field(kernel, x, m, hessian=table["tide"], add=True, factor=-1.0)
    assert not table["tide"].any() and not table["name"].any() and not table["end"].any()
    with pytest.raises(ValueError):
        mollis.field(kernel, x, m, hessian=np.empty((50, dimension, 2 * dimension), dtype)[:, :, ::2])
    assert "second derivatives computed" in mollis.plan(kernel, 50, hessian=True)


@pytest.mark.parametrize(
    "rule, of",
    [
        ("maximum", np.maximum),
        ("mean", lambda a, b: (a + b) / 2),
        ("rms", lambda a, b: np.sqrt((a**2 + b**2) / 2)),
    ],
)
def test_radii_of_pairs(rng, rule, of):
    x, m, radii = rng.random((40, 2)), rng.random(40), 0.1 + 0.3 * rng.random(40)
    at, of_targets = rng.random((9, 2)), 0.1 + 0.3 * rng.random(9)
    kernel = mollis.Kernel(kernels.newtonian(), mollifiers.plummer(), 0.1)

    def expected(targets, target_radii):
        return np.array([
            sum(reference.gradient([a], [y], [w], lambda r, e=of(s, b): reference.plummer(r, e, 2)[1])[0]
                for y, w, s in zip(x, m, radii))
            for a, b in zip(targets, target_radii)
        ])  # fmt: skip

    result = mollis.field(kernel, x, m, radii=radii, pair_radius=rule, gradient=True).gradient
    close(result, expected(x, radii))
    assert np.abs(m @ result).max() < 1e-12
    result = mollis.field(kernel, x, m, at, radii=radii, target_radii=of_targets, pair_radius=rule, gradient=True)
    close(result.gradient, expected(at, of_targets))
    with pytest.raises(mollis.Error):
        mollis.field(kernel, x, m, at, radii=radii, pair_radius=rule, gradient=True)


def test_second_derivatives_by_tolerance(rng):
    x, m = rng.random((8000, 2)), rng.random(8000)
    kernel = mollis.Kernel(kernels.newtonian(), mollifiers.compact(2, 4), 1e-3)
    result = mollis.field(kernel, x, m, hessian=True, method="fmm", tolerance=1e-8)
    expected = mollis.field(kernel, x, m, x[:80], hessian=True, method="direct").hessian
    assert np.linalg.norm(result.hessian[:80] - expected) < 1e-8 * np.linalg.norm(expected)


def test_kernels_without_a_mollifier(rng):
    x, m = rng.random((40, 2)), rng.standard_normal(40)

    def singular(value):
        return lambda r: np.where(r > 0, value(np.where(r > 0, r, 1.0)), 0.0)

    for terms, value in [
        (kernels.newtonian(), lambda r: np.log(r) / (2 * np.pi)),
        (kernels.power(3.0, 0.5), lambda r: 0.5 * r**3 / 3),
        (kernels.power(0.0), np.log),
        ([kernels.exponential(0.5, 2.0), kernels.exponential(1.0, -1.0)], lambda r: 2 * np.exp(-r / 0.5) - np.exp(-r)),
    ]:
        kernel = mollis.Kernel(terms)
        close(mollis.field(kernel, x, m, potential=True).potential, reference.potential(x, x, m, singular(value)))


def test_screened_in_space(rng):
    x, m, at, k = rng.random((40, 3)), rng.standard_normal(40), 2 + rng.random((30, 3)), 1.5
    kernel = mollis.Kernel(kernels.screened(k), dimension=3)
    expected = reference.potential(at, x, m, lambda r: -np.exp(-k * r) / (4 * np.pi * r))
    close(mollis.field(kernel, x, m, at, potential=True).potential, expected)


def test_vortices_in_the_plane(rng):
    """v = sum Gamma (-y, x) / (2 pi) (1 - exp(-r^2 / r_c^2)) / r^2, docs/in-your-code.md."""
    x, circulation, core = rng.random((50, 2)), rng.standard_normal(50), 0.2
    kernel = mollis.Kernel(kernels.newtonian(), mollifiers.gaussian(2), core)
    v = mollis.field(kernel, x, circulation, gradient=True, combination=(0.0, 1.0)).gradient
    with np.errstate(invalid="ignore"):
        factor = lambda r: np.where(
            r > 0, -np.expm1(-((r / core) ** 2)) / (2 * np.pi * r**2), 1 / (2 * np.pi * core**2)
        )
        g = reference.gradient(x, x, circulation, factor)
    close(v, np.c_[-g[:, 1], g[:, 0]])


def test_richardson_combinations(rng):
    x, m, d = rng.random((50, 2)), rng.random(50), 0.3

    def gradient(mollifier, delta):
        return mollis.field(mollis.Kernel(kernels.newtonian(), mollifier, delta), x, m, gradient=True).gradient

    for order, parts in [(4, [(4 / 3, 1 / 2), (-1 / 3, 1)]), (6, [(3 / 2, 1 / 3), (-3 / 5, 2 / 3), (1 / 10, 1)])]:
        want = sum(weight * gradient(mollifiers.compact(2, 4), d * radius) for weight, radius in parts)
        close(gradient(mollifiers.richardson(order, 4), d), want)


def test_vatistas_and_algebraic(rng):
    x, m, d = rng.random((50, 2)), rng.standard_normal(50), 0.2
    for mollifier, factor in [
        (mollifiers.vatistas(), lambda r: 1 / (2 * np.pi * np.sqrt(r**4 + d**4))),
        (mollifiers.algebraic(), lambda r: (r**2 + 2 * d**2) / (2 * np.pi * (r**2 + d**2) ** 2)),
    ]:
        kernel = mollis.Kernel(kernels.newtonian(), mollifier, d)
        close(mollis.field(kernel, x, m, gradient=True).gradient, reference.gradient(x, x, m, factor))


def test_biot_and_savart(rng):
    """sum_j grad K_delta(x_i - x_j) x strength_j."""
    x, strength = rng.random((40, 3)), rng.standard_normal((40, 3))
    kernel = mollis.Kernel(kernels.newtonian(), mollifiers.plummer(), 0.2, dimension=3)
    v = mollis.field(kernel, x, strengths=strength, gradient=True).gradient
    d, r = reference.pairs(x, x)
    close(v, np.cross(reference.plummer(r, 0.2, 3)[1][:, :, None] * d, strength[None]).sum(axis=1))


def test_radii(rng, soft):
    x, m, radii = rng.random((40, 2)), rng.standard_normal(40), rng.uniform(0.1, 0.5, 40)
    g = mollis.field(soft, x, m, radii=radii, gradient=True).gradient
    expected = sum(
        reference.gradient(x, x[j : j + 1], m[j : j + 1], lambda r: reference.compact(r, radii[j], 4, 2, 2)[1])
        for j in range(40)
    )
    close(g, expected)


def test_a_kernel_of_one_s_own(rng):
    x, m = rng.random((40, 3)), rng.standard_normal(40)

    def scalar(r):
        return -math.exp(-r) / r, math.exp(-r) * (1 + r) / r**3, -math.exp(-r) / r

    def vector(r):
        e = np.exp(-r)
        return -e / r, e * (1 + r) / r**3, -e / r

    one = mollis.Kernel(kernels.own(scalar, reach=5.0), dimension=3)
    two = mollis.Kernel(kernels.own(vector, reach=5.0, vectorized=True), dimension=3)
    assert one.fit_errors is not None and max(one.fit_errors) < 1e-10
    with np.errstate(divide="ignore", invalid="ignore"):
        expected = reference.potential(x, x, m, lambda r: np.where(r > 0, -np.exp(-r) / r, 0.0))
    for kernel in (one, two):
        close(mollis.field(kernel, x, m, potential=True).potential, expected, 1e-10)
    far = mollis.field(one, [[0.0, 0.0, 0.0]], [1.0], [[9.0, 0.0, 0.0]], potential=True, counts=True)
    assert far.potential[0] == 0 and far.counts.beyond_reach == 1 and far.counts.pairs == 1


def test_exceptions_of_one_s_own_kernel_are_raised():
    class Mine(Exception):
        pass

    def failing(r):
        raise Mine("here")

    with pytest.raises(Mine, match="here"):
        mollis.Kernel(kernels.own(failing, reach=1.0))
    with pytest.raises(TypeError):
        mollis.Kernel(kernels.own(lambda r: 1.0, reach=1.0))
    with pytest.raises(mollis.Error) as caught:
        mollis.Kernel(kernels.own(lambda r: (abs(r - 0.5), (1 if r > 0.5 else -1) / r, 1 / r), reach=1.0))
    assert caught.value.status is mollis.Status.KERNEL_FIT


def layouts(values):
    """The same numbers in memory of other shapes: columns of a wider array, Fortran order, every second row, a field
    of a structure.
    """
    n, dimension = values.shape
    wide = np.full((n, dimension + 2), np.nan, values.dtype)
    wide[:, 1 : 1 + dimension] = values
    gaps = np.full((2 * n, dimension), np.nan, values.dtype)
    gaps[::2] = values
    mixed = np.zeros(n, [("id", values.dtype), ("x", values.dtype, (dimension,)), ("m", values.dtype)])
    mixed["x"] = values
    rows = np.full((dimension + 3, n), np.nan, values.dtype)
    rows[:dimension] = values.T
    return {
        "columns": wide[:, 1 : 1 + dimension], "fortran": np.asfortranarray(values), "rows": gaps[::2],
        "field": mixed["x"],
        "transposed": rows[:dimension].T, "mirrored": np.ascontiguousarray(values[:, ::-1])[:, ::-1],
    }  # fmt: skip


@pytest.mark.parametrize("dtype", [np.float64, np.float32])
@pytest.mark.parametrize("name", ["columns", "fortran", "rows", "field", "transposed", "mirrored"])
@pytest.mark.parametrize("dimension", [1, 2, 3])
def test_layouts_are_read_and_written_where_they_are(rng, dtype, name, dimension, monkeypatch):
    kernel = mollis.Kernel(kernels.newtonian(), mollifiers.compact(2, 4), 0.3, dimension, dtype)
    x, m = rng.random((150, dimension)).astype(dtype), rng.standard_normal(150).astype(dtype)
    at = rng.random((170, dimension)).astype(dtype)
    plain = mollis.field(kernel, x, m, at, potential=True, gradient=True)
    out, flat = layouts(np.zeros_like(at))[name], layouts(np.zeros((170, 2), dtype))[name][:, 0]
    masses = layouts(np.c_[m, m])[name][:, 1]
    in_place = _library.in_place
    sources, targets = layouts(x)[name], layouts(at)[name]

    def copied(*_):
        raise AssertionError("an array was copied")

    monkeypatch.setattr("mollis._library.in_place", lambda *_: in_place(*_) or copied())
    given = mollis.field(kernel, sources, masses, targets, potential=flat, gradient=out)
    monkeypatch.undo()
    assert given.potential is flat and given.gradient is out
    np.testing.assert_array_equal(flat, plain.potential)
    np.testing.assert_array_equal(out, plain.gradient)
    if name in ("columns", "rows"):
        untouched = out.base[1::2] if name == "rows" else out.base[:, [0, -1]]
        assert np.isnan(untouched).all()


def test_no_copies(rng, soft):
    """The pointers that the library gets are those of the arrays."""
    x, m, g = rng.random((30, 4))[:, :2], rng.random((30, 3))[:, 1], np.zeros((30, 5))[:, 2:4]
    seen = []
    api = soft._api
    real = api["field#_eval"]

    def spy(kernel, size, sources, targets, outputs, *rest):
        address = lambda p: int(_library.ffi.cast("intptr_t", p))
        seen.append((address(sources.positions[0]), address(sources.masses), address(outputs.gradient[0])))
        assert (sources.stride, sources.mass_stride, outputs.gradient_stride) == (4, 3, 5)
        return real(kernel, size, sources, targets, outputs, *rest)

    api["field#_eval"] = spy
    try:
        mollis.field(soft, x, m, gradient=g)
    finally:
        api["field#_eval"] = real
    assert seen[-1] == (x.ctypes.data, m.ctypes.data, g.ctypes.data)


def test_no_memory_is_allocated_again(rng, soft):
    import tracemalloc

    x, m, g = rng.random((5000, 4))[:, :2], rng.random(5000), np.empty((5000, 2))
    for _ in range(3):
        mollis.field(soft, x, m, gradient=g)
    tracemalloc.start()
    mollis.field(soft, x, m, gradient=g)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert peak < 20_000, peak


def test_what_cannot_be_read_in_place_is_copied(rng, soft):
    x, m = rng.random((50, 2)), rng.random(50)
    plain = mollis.field(soft, x, m, gradient=True).gradient
    packed = np.zeros(50, np.dtype([("tag", "u1"), ("x", "f8", 2)]))
    packed["x"] = x
    askew = np.ndarray((50, 2), buffer=bytearray(1 + x.nbytes), offset=1)
    askew[:] = x
    for same in (x[::-1][::-1], x.tolist(), packed["x"], askew, x.astype(">f8"), x.astype(object)):
        np.testing.assert_array_equal(mollis.field(soft, same, m, gradient=True).gradient, plain)
    reverse = mollis.field(soft, x[::-1], m[::-1], x[::-1], gradient=True).gradient
    close(reverse[::-1], plain)
    equal = mollis.field(soft, x, 2.0, gradient=True).gradient
    np.testing.assert_array_equal(equal, mollis.field(soft, x, np.full(50, 2.0), gradient=True).gradient)
    np.testing.assert_array_equal(equal, mollis.field(soft, x, np.broadcast_to(2.0, 50), gradient=True).gradient)


def test_one_dimension_takes_flat_arrays(rng):
    kernel = mollis.Kernel(kernels.newtonian(), mollifiers.compact(2, 4), 0.1, dimension=1)
    x, m, g = rng.random(30), rng.random(30), np.empty(30)
    expected = mollis.field(kernel, x[:, None], m, gradient=True).gradient
    assert expected.shape == (30, 1)
    result = mollis.field(kernel, x, m, gradient=g)
    np.testing.assert_array_equal(g, expected[:, 0])
    assert np.shares_memory(result.gradient, g)


def test_factor_and_add(cloud, soft):
    x, m = cloud
    g = mollis.field(soft, x, m, gradient=True).gradient
    out = np.ones_like(x)
    mollis.field(soft, x, m, gradient=out, factor=-2.0, add=True)
    close(out, 1 - 2 * g)
    with pytest.raises(ValueError, match="add"):
        mollis.field(soft, x, m, gradient=True, add=True)
    with pytest.raises(ValueError, match="factor"):
        mollis.field(soft, x, m, gradient=True, factor=0.0)


def test_tolerance_and_plan(rng):
    soft = mollis.Kernel(kernels.newtonian(), mollifiers.compact(2, 4), delta=0.01)
    x, m = rng.random((20_000, 2)), rng.random(20_000)
    exact = mollis.field(soft, x, m, gradient=True).gradient
    fast = mollis.field(soft, x, m, gradient=True, tolerance=1e-6, counts=True)
    assert 0 < np.linalg.norm(fast.gradient - exact) < 1e-6 * np.linalg.norm(exact)
    assert fast.counts.pairs < 20_000**2 / 4
    assert "multipole" in mollis.plan(soft, 20_000, gradient=True, tolerance=1e-6)
    assert "all pairs" in mollis.plan(soft, 20_000, 10, gradient=True).split(":")[0]
    np.testing.assert_array_equal(mollis.field(soft, x, m, gradient=True, method="direct").gradient, exact)
    with pytest.raises(ValueError, match="fmm"):
        mollis.field(soft, x, m, gradient=True, method="fast")
    # Another kernel, in space.
    smooth = mollis.Kernel(kernels.exponential(0.2), mollifiers.compact(4, 4), 0.05, 3)
    x, m = rng.random((3000, 3)), rng.random(3000)
    exact = mollis.field(smooth, x, m, gradient=True).gradient
    fast = mollis.field(smooth, x, m, gradient=True, tolerance=1e-3, method="tree").gradient
    assert 0 < np.linalg.norm(fast - exact) < 1e-3 * np.linalg.norm(exact)
    assert "tree" in mollis.plan(smooth, 100_000, gradient=True, tolerance=1e-3)


def test_threads_change_no_bit(rng, soft):
    x, m = rng.random((3000, 2)), rng.standard_normal(3000)
    one = mollis.field(soft, x, m, potential=True, gradient=True, threads=1)
    for threads in (None, 0, 2, 3):
        other = mollis.field(soft, x, m, potential=True, gradient=True, threads=threads)
        np.testing.assert_array_equal(one.potential, other.potential)
        np.testing.assert_array_equal(one.gradient, other.gradient)
    mollis.set_threads(2)
    try:
        np.testing.assert_array_equal(mollis.field(soft, x, m, gradient=True).gradient, one.gradient)
    finally:
        mollis.set_threads(0)
    with pytest.raises(ValueError, match="negative"):
        mollis.field(soft, x, m, gradient=True, threads=-1)


def test_several_threads_of_the_host(rng, soft):
    x, m = rng.random((2000, 2)), rng.random(2000)
    expected = mollis.field(soft, x, m, gradient=True).gradient
    results = [None] * 6

    def work(i):
        for _ in range(5):
            results[i] = mollis.field(soft, x, m, gradient=True).gradient

    workers = [threading.Thread(target=work, args=(i,)) for i in range(6)]
    [w.start() for w in workers]
    [w.join() for w in workers]
    for result in results:
        np.testing.assert_array_equal(result, expected)


def test_errors_tell_the_element(cloud, soft):
    x, m = cloud
    x = x.copy()
    x[17, 1] = np.nan
    with pytest.raises(mollis.Error, match="not finite") as caught:
        mollis.field(soft, x, m, gradient=True)
    assert caught.value.status is mollis.Status.NOT_FINITE == 20 and caught.value.first_bad == 17
    with pytest.raises(mollis.Error) as caught:
        mollis.field(soft, cloud[0], m, [[0.0, 0.0], [np.inf, 0.0]], gradient=True)
    assert caught.value.first_bad == 201
    again = pickle.loads(pickle.dumps(caught.value))
    assert (again.status, again.first_bad, str(again)) == (20, 201, str(caught.value))
    with pytest.raises(mollis.Error) as caught:
        soft.radial([0.0, np.nan])
    assert caught.value.first_bad == 1


def test_refusals(cloud, soft):
    x, m = cloud
    with pytest.raises(ValueError, match="nothing"):
        mollis.field(soft, x, m)
    with pytest.raises(ValueError, match=r"\(200,\)"):
        mollis.field(soft, x, m[:-1], gradient=True)
    with pytest.raises(ValueError, match=r"\(n, 2\)"):
        mollis.field(soft, np.zeros((5, 3)), 1.0, gradient=True)
    with pytest.raises(TypeError, match="masses"):
        mollis.field(soft, x, gradient=True)
    with pytest.raises(TypeError, match="float64"):
        mollis.field(soft, x, m, gradient=np.zeros((200, 2), np.float32))
    with pytest.raises(TypeError, match="float64"):
        mollis.field(soft, x, m, gradient=x.tolist())
    with pytest.raises(ValueError, match="shape"):
        mollis.field(soft, x, m, gradient=np.zeros((199, 2)))
    frozen = np.zeros((200, 2))
    frozen.flags.writeable = False
    with pytest.raises(ValueError, match="read-only"):
        mollis.field(soft, x, m, gradient=frozen)
    askew = np.ndarray((200, 2), buffer=bytearray(1 + x.nbytes), offset=1)
    for bad in (np.zeros((200, 2))[::-1], askew):
        with pytest.raises(ValueError, match="multiple"):
            mollis.field(soft, x, m, gradient=bad)
    with pytest.raises(mollis.Error) as caught:
        mollis.field(soft, x, m, gradient=x)
    assert caught.value.status is mollis.Status.OVERLAP
    with pytest.raises(mollis.Error) as caught:
        mollis.field(soft, x, m, radii=-np.ones(200), gradient=True)
    assert caught.value.status is mollis.Status.DELTA
    for arguments, status in [
        ((kernels.newtonian(), mollifiers.compact(3, 4), 0.1), "ORDER"),
        ((kernels.newtonian(), mollifiers.compact(2, 10), 0.1), "EXPONENT"),
        ((kernels.newtonian(), mollifiers.compact(2, 4), 0.0), "DELTA"),
        (([],), "KERNEL_TERMS"),
    ]:
        with pytest.raises(mollis.Error) as caught:
            mollis.Kernel(*arguments)
        assert caught.value.status is mollis.Status[status]
    with pytest.raises(ValueError, match="delta"):
        mollis.Kernel(kernels.newtonian(), mollifiers.compact(2, 4))
    for dimension, dtype in [(4, np.float64), (2, np.int64)]:
        with pytest.raises(ValueError, match="dimension"):
            mollis.Kernel(kernels.newtonian(), dimension=dimension, dtype=dtype)


def test_no_points(soft):
    result = mollis.field(soft, np.zeros((0, 2)), np.zeros(0), [[0.0, 0.0]], gradient=True)
    assert result.gradient.tolist() == [[0.0, 0.0]]
    assert mollis.field(soft, np.zeros((0, 2)), np.zeros(0), gradient=True).gradient.shape == (0, 2)


def test_kernels_are_values(cloud, soft):
    x, m = cloud
    again = pickle.loads(pickle.dumps(soft))
    expected = mollis.field(soft, x, m, gradient=True).gradient
    np.testing.assert_array_equal(mollis.field(again, x, m, gradient=True).gradient, expected)
    value, factor, laplacian = soft.radial(np.array([[0.1, 0.2], [0.5, 1.0]]))
    psi, g = reference.compact([[0.1, 0.2], [0.5, 1.0]], 0.3, 4, 2, 2)
    close(factor, g, 1e-14)
    close(laplacian, psi, 1e-14)
    assert value.shape == (2, 2) and value[1, 1] == pytest.approx(0.0, abs=1e-16)


def test_a_forked_process_has_its_own_threads(rng, soft):
    """Threads do not survive a fork: the child starts a pool of its own."""
    import multiprocessing

    if "fork" not in multiprocessing.get_all_start_methods():
        return
    x, m = rng.random((2000, 2)), rng.random(2000)
    expected = mollis.field(soft, x, m, gradient=True, threads=2).gradient
    with multiprocessing.get_context("fork").Pool(1) as pool:
        result = pool.apply_async(_in_child, (soft, x, m)).get(timeout=60)
    np.testing.assert_array_equal(result, expected)


def _in_child(kernel, x, m):
    return mollis.field(kernel, x, m, gradient=True, threads=2).gradient


@pytest.mark.parametrize("dtype", [np.float64, np.float32])
@pytest.mark.parametrize("dimension", [1, 2, 3])
def test_essential(rng, dimension, dtype):
    # In space so few sources are replaced for a few digits only.
    n, tolerance = 4000, 1e-4 if dimension < 3 else 1e-2
    x, m = rng.random((n, dimension)).astype(dtype), rng.random(n).astype(dtype)
    kernel = mollis.Kernel(kernels.newtonian(), mollifiers.compact(2, 4), 0.01, dimension, dtype=dtype)
    lower = np.array([[3.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 0.0, 0.0]])[:, :dimension]
    upper = np.array([[4.0, 1.0, 1.0], [1.5, 1.0, 1.0], [0.0, 1.0, 1.0]])[:, :dimension]
    far, near, none = mollis.essential(kernel, x, m, np.stack([lower, upper], axis=1), tolerance)
    assert len(none.masses) == 0 and len(far.masses) < len(near.masses) < n
    kept = near.origins >= 0
    np.testing.assert_array_equal(near.positions[kept], x[near.origins[kept]])
    for found, a, b in zip((far, near), lower, upper):
        targets = (a + (b - a) * rng.random((50, dimension))).astype(dtype)
        got = mollis.field(kernel, found.positions, found.masses, targets, gradient=True).gradient
        want = mollis.field(kernel, x, m, targets, gradient=True).gradient
        assert np.linalg.norm(got - want) < 2 * tolerance * np.linalg.norm(want)
    radii = np.full(n, 0.01, dtype)
    radii[7] = 5.0
    (whole,) = mollis.essential(kernel, x, m, [[lower[0], upper[0]]], tolerance, radii=radii)
    assert len(whole.masses) == n
    with pytest.raises(mollis.Error, match="range"):
        mollis.essential(kernel, x, m, [[lower[0], upper[0]]], 0.0)
    with pytest.raises(ValueError, match="shape"):
        mollis.essential(kernel, x, m, [lower[0], upper[0]], tolerance)

#!/usr/bin/env python3
"""The blob method for the aggregation equation in NumPy and SciPy, the way its authors describe it (Craig & Bertozzi, Section 4).

The problem is fixed: the plane, attractive Newtonian kernel K = log|x| / (2 pi), dx_i/dt = -sum_j m_j grad K_delta(x_i - x_j),
initial density rho0(x) = (1 - |x|^2)^2 on the unit disc, particles of mass rho0 h^2 on the lattice h Z^2 with |x| < 1, the Gaussian
mollifier of order 4, psi(x) = (2 exp(-|x|^2) - exp(-|x|^2/2) / 2) / pi (mass 1, second moment 0), delta = h^0.9.

* Time: VODE (scipy.integrate.ode), Adams or BDF, functional iteration (no Jacobian of n^2 numbers). With the default tolerances of
  1e-8, Adams takes about 40 right-hand sides to t = 0.5; its positions are on average 5e-8 from those with 1e-12.
* Kernel, grad K_delta(x) = g(|x|) x, in one of two ways. `table`: g on a uniform grid over r, linear interpolation by computed index
  (np.interp searches and is several times slower); its largest error, measured, is 8.2e-10 g(0). `exact`: the closed form, which
  the paper takes where there is one (its Section 4.1): one exponential per pair. Either way Newtonian beyond 9 delta.
* Sums over j: all pairs, blocks of 128 by 128 (128 KiB an array), each pair once (the kernel is even), distances by
  scipy.spatial.distance.cdist, sums as matrix products, sum_j m_j g_ij (x_i - x_j) = x_i (G m)_i - (G (m x))_i.

The error is the mean distance from the exact positions, weighted with mass: r(t)^2 = r0^2 - M(r0) t / pi, M(r) the mass of rho0 within r.

Prints one JSON object; times are CPU times of the process, making the table included, on one thread.

    python3 numpy_blob.py --h 0.1 0.05
"""

import os

for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[variable] = "1"

import argparse
import json
import time

import numpy as np
import scipy
import scipy.integrate
from scipy.spatial.distance import cdist

BLOCK = 128
INTERVALS, REACH = 120_000, 9.0


def lattice(h):
    """Positions and masses. A lattice point on the circle itself would have no mass, so rounding there does not matter."""
    k = h * np.arange(-int(1 / h) - 1, int(1 / h) + 2)
    position = np.stack(np.meshgrid(k, k, indexing="ij"), axis=-1).reshape(-1, 2)
    s = (position**2).sum(axis=1)
    inside = s < 1 - 1e-12
    return position[inside], (1 - s[inside]) ** 2 * h * h


def exact_kernel(delta):
    """The function from squared distances to g: 2 pi r^2 g = 2 (1 - q^2) - (1 - q) with q = exp(-r^2 / (2 delta^2))."""

    def kernel(r2):
        q = r2 * (-0.5 / delta**2)
        np.maximum(q, -50, out=q)  # NumPy's exp is slow where it underflows
        np.exp(q, out=q)
        g = 1 - q
        q += 0.5
        g *= q
        g /= r2
        g *= 1 / np.pi
        return g

    return kernel


def table_kernel(delta):
    """The same function by linear interpolation over r."""
    end = REACH * delta
    r2 = np.linspace(0, end, INTERVALS + 1)[1:] ** 2
    p = -np.expm1(-0.5 * r2 / delta**2)
    value = np.concatenate(([1.5 / delta**2], p * (3 - 2 * p) / r2)) / (2 * np.pi)
    difference = np.diff(value)

    def kernel(r2):
        g = np.sqrt(r2)
        g *= INTERVALS / end
        k = g.astype(np.intp)
        g -= k
        g *= np.take(difference, k, mode="clip")
        g += np.take(value, k, mode="clip")
        np.copyto(g, 0.5 / np.pi / r2, where=r2 >= end**2)
        return g

    return kernel


def velocity(position, mass, kernel, far):
    n = len(mass)
    weight = np.column_stack((mass, mass[:, None] * position))
    total = np.zeros((n, 3))
    for i in range(0, n, BLOCK):
        rows = slice(i, i + BLOCK)
        for j in range(i, n, BLOCK):
            columns = slice(j, j + BLOCK)
            r2 = cdist(position[rows], position[columns], "sqeuclidean")
            if i == j:
                np.fill_diagonal(r2, 1)  # any positive number: the term is multiplied by x_i - x_i
            g = kernel(r2) if r2.min() < far**2 else 0.5 / np.pi / r2
            total[rows] += g @ weight[columns]
            if i != j:
                total[columns] += g.T @ weight[rows]
    return total[:, 1:] - total[:, :1] * position


def run(h, arguments):
    start = time.process_time()
    initial, mass = lattice(h)
    kernel = {"table": table_kernel, "exact": exact_kernel}[arguments.kernel](h**0.9)
    evaluations, far = 0, REACH * h**0.9

    def right_hand_side(_, y):
        nonlocal evaluations
        evaluations += 1
        return velocity(y.reshape(-1, 2), mass, kernel, far).ravel()

    solver = scipy.integrate.ode(right_hand_side)
    solver.set_integrator("vode", method=arguments.method, rtol=arguments.rtol, atol=arguments.atol, nsteps=100_000)
    solver.set_initial_value(initial.ravel(), 0.0)
    position = solver.integrate(arguments.time).reshape(-1, 2)
    seconds = time.process_time() - start
    if not solver.successful():
        raise RuntimeError(f"VODE stopped before the final time, h = {h}")
    s = (initial**2).sum(axis=1)
    now = np.sqrt(np.maximum(s - arguments.time / 3 * (1 - (1 - s) ** 3), 0))
    exact = initial * (now / np.sqrt(np.where(s > 0, s, 1)))[:, None]
    error = (mass * np.hypot(*(position - exact).T)).sum() / mass.sum()
    return {"h": h, "particles": len(mass), "seconds": seconds, "error": error, "evaluations": evaluations}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--h", type=float, nargs="+", default=[0.1, 0.0707, 0.05, 0.0354])
    parser.add_argument("--rtol", type=float, default=1e-8)
    parser.add_argument("--atol", type=float, default=1e-8)
    parser.add_argument("--method", choices=("adams", "bdf"), default="adams")
    parser.add_argument("--kernel", choices=("table", "exact"), default="table")
    parser.add_argument("--time", type=float, default=0.5, help="below 1, when the exact solution blows up")
    arguments = parser.parse_args()
    if min(arguments.h) <= 0 or not 0 < arguments.time < 1:
        parser.error("--h must be positive and --time between 0 and 1")
    rows = [run(h, arguments) for h in arguments.h]
    print(json.dumps({"numpy": np.__version__, "scipy": scipy.__version__, "kernel": arguments.kernel, "rows": rows}))


if __name__ == "__main__":
    main()

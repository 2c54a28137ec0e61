#!/usr/bin/env python3
"""One sub-step of the Patlak-Keller-Segel particle method in NumPy and SciPy: the peer of `mollis-bench pks`.

The same method as mollis' (Zhelezov & Fatkullin, Section 3.4): cloud-in-cell deposit (np.bincount), the five-point scheme with the
monopole on the border (scipy.fft.dst along both axes), centred differences, bilinear interpolation, Euler-Maruyama move with
NumPy's default generator. Prints one JSON object; times are CPU times of the process, minima over the repetitions.

    python3 numpy_pks.py --n 1000000 --grid 320 --repetitions 5
"""

import argparse
import json
import time

import numpy as np
import scipy
import scipy.fft


def potential(mass, centre, x, y):
    return mass * np.log(np.hypot(x - centre[0], y - centre[1])) / (2 * np.pi)


def deposit(position, mass, lower, h, cells):
    g = (position - lower) / h
    c = np.minimum(g.astype(np.int64), cells - 1)
    f = g - c
    pitch = cells[0] + 1
    node = c[:, 1] * pitch + c[:, 0]
    size = pitch * (cells[1] + 1)
    wx, wy = (1 - f[:, 0], f[:, 0]), (1 - f[:, 1], f[:, 1])
    rho = np.zeros(size)
    for j in (0, 1):
        for i in (0, 1):
            rho += np.bincount(node + j * pitch + i, mass * wx[i] * wy[j], minlength=size)
    return rho.reshape(cells[1] + 1, pitch), node, wx, wy


def solve(rho, mass, centre, lower, h, cells):
    nx, ny = cells
    x = lower[0] + h[0] * np.arange(-1, nx + 2)
    y = lower[1] + h[1] * np.arange(-1, ny + 2)
    # The border and one ghost ring outside it.
    u = np.zeros((ny + 3, nx + 3))
    for row in (0, 1, -2, -1):
        u[row, :] = potential(mass, centre, x, y[row])
    for column in (0, 1, -2, -1):
        u[:, column] = potential(mass, centre, x[column], y)
    f = rho[1:-1, 1:-1] / (h[0] * h[1])
    f[:, 0] -= u[2:-2, 1] / h[0] ** 2
    f[:, -1] -= u[2:-2, -2] / h[0] ** 2
    f[0, :] -= u[1, 2:-2] / h[1] ** 2
    f[-1, :] -= u[-2, 2:-2] / h[1] ** 2
    s = -4 / h[0] ** 2 * np.sin(np.pi * np.arange(1, nx) / (2 * nx)) ** 2
    t = -4 / h[1] ** 2 * np.sin(np.pi * np.arange(1, ny) / (2 * ny)) ** 2
    modes = scipy.fft.dstn(f, type=1) / (s[None, :] + t[:, None])
    u[2:-2, 2:-2] = scipy.fft.idstn(modes, type=1)
    gx = (u[1:-1, 2:] - u[1:-1, :-2]) / (2 * h[0])
    gy = (u[2:, 1:-1] - u[:-2, 1:-1]) / (2 * h[1])
    return np.stack((gx.ravel(), gy.ravel()), axis=1)


def gather(gradient, node, wx, wy, pitch):
    out = np.zeros((node.size, 2))
    for j in (0, 1):
        for i in (0, 1):
            out += (wx[i] * wy[j])[:, None] * gradient[node + j * pitch + i]
    return out


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--n", type=int, default=1_000_000)
    parser.add_argument("--grid", type=int, default=320)
    parser.add_argument("--repetitions", type=int, default=5)
    arguments = parser.parse_args()
    n, cells = arguments.n, np.array([arguments.grid] * 2)
    lower, upper = np.array([-1.5, -1.5]), np.array([1.5, 1.5])
    h = (upper - lower) / cells
    generator = np.random.default_rng(1)
    # A bump well inside, as mollis-bench's.
    position = 0.25 * generator.standard_normal((n, 2))
    position = np.clip(position, -1.4, 1.4)
    mass = np.full(n, 16 * np.pi / n)
    chi, noise, dt = 1.0, 0.02, 1e-6

    best = {}
    for _ in range(arguments.repetitions):
        times = [time.process_time()]
        rho, node, wx, wy = deposit(position, mass, lower, h, cells)
        times.append(time.process_time())
        total = mass.sum()
        centre = (mass[:, None] * position).sum(axis=0) / total
        gradient = solve(rho, total, centre, lower, h, cells)
        times.append(time.process_time())
        drift = gather(gradient, node, wx, wy, cells[0] + 1)
        times.append(time.process_time())
        normals = generator.standard_normal((n, 2))
        times.append(time.process_time())
        position = position - chi * dt * drift + noise * np.sqrt(dt) * normals
        np.clip(position, lower, upper, out=position)
        times.append(time.process_time())
        for name, a, b in zip(("deposit", "solve", "gather", "noise", "move"), times, times[1:]):
            best[name] = min(best.get(name, np.inf), b - a)
        best["step"] = min(best.get("step", np.inf), times[-1] - times[0])
    print(
        json.dumps(
            {
                "n": n,
                "grid": arguments.grid,
                "numpy": np.__version__,
                "scipy": scipy.__version__,
                "seconds": best,
                "nanoseconds_per_particle": 1e9 * best["step"] / n,
            }
        )
    )


if __name__ == "__main__":
    main()

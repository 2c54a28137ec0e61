#!/usr/bin/env python3
"""One step of the Patlak-Keller-Segel particle method in NumPy and SciPy: the peer of `mollis-bench pks`.

The same method as mollis' (Zhelezov & Fatkullin, Section 3): the search for clusters that may collide, cloud-in-cell deposit
(np.bincount), the five-point scheme with the monopole on the border (scipy.fft.dst along both axes), centred differences, bilinear
interpolation, Euler-Maruyama move with NumPy's default generator. The search is written in the two ways a SciPy user would take:

* quadtree: the paper's, all cells of a level at once, over particles sorted by their Morton keys (np.argsort, np.add.reduceat);
* kdtree: scipy.spatial.cKDTree, the pairs within the distance where a collision is likely enough, and their connected components.
  It sees pairs and what hangs together by pairs, not the cells of many particles that only together are heavy enough.

Prints one JSON object; times are CPU times of the process, minima over the repetitions.

    python3 numpy_pks.py --n 1000000 --grid 320 --repetitions 5
"""

import argparse
import json
import time

import numpy as np
import scipy
import scipy.fft
import scipy.optimize
import scipy.sparse
import scipy.sparse.csgraph
import scipy.spatial
import scipy.special

LEVELS = 26
ETA, PROBABILITY = 0.1, 1e-4


def spread_bits(v):
    """Puts a zero between the bits of 26-bit numbers."""
    v = v.astype(np.uint64)
    for shift, mask in (
        (16, 0x0000FFFF0000FFFF),
        (8, 0x00FF00FF00FF00FF),
        (4, 0x0F0F0F0F0F0F0F0F),
        (2, 0x3333333333333333),
        (1, 0x5555555555555555),
    ):
        v = (v | (v << np.uint64(shift))) & np.uint64(mask)
    return v


def collidable(count, mass, pairs, moment, chi, noise, dt):
    """nu < 0 and P(collision within dt) > p, by the law of the hitting time of zero."""
    nu = count - 2 - chi * pairs / (8 * np.pi * noise)
    out = nu < 0
    some = np.flatnonzero(out)
    x = moment[some] * mass[some] / (4 * noise * dt)
    out[some] = scipy.special.gammaincc(-nu[some], x) > PROBABILITY
    return out


def search_quadtree(position, mass, lower, side, chi, noise, dt):
    """Clusters as arrays of particles."""
    cells = (position - lower) * (2.0**LEVELS / side)
    key = spread_bits(cells[:, 0]) | (spread_bits(cells[:, 1]) << np.uint64(1))
    order = np.argsort(key)
    key, m, x = key[order], mass[order], position[order]
    found = []
    for level in range(LEVELS + 1):
        if key.size < 2:
            break
        cell = key >> np.uint64(2 * (LEVELS - level))
        first = np.flatnonzero(np.concatenate(([True], cell[1:] != cell[:-1])))
        count = np.diff(np.append(first, cell.size))
        total = np.add.reduceat(m, first)
        pairs = total**2 - np.add.reduceat(m * m, first)
        # Few cells can have a negative index; only their moments are needed.
        likely = (count > 1) & (count - 2 - chi * pairs / (8 * np.pi * noise) < 0)
        accepted = np.zeros(first.size, dtype=bool)
        which = np.flatnonzero(likely)
        if which.size:
            inside = np.repeat(likely, count)
            mi, xi = m[inside], x[inside]
            begin = np.concatenate(([0], np.cumsum(count[which])[:-1]))
            centre = np.add.reduceat(mi[:, None] * xi, begin) / total[which, None]
            away = xi - np.repeat(centre, count[which], axis=0)
            moment = np.add.reduceat(mi * (away**2).sum(axis=1), begin) / total[which]
            apart = moment < ETA * 2 * (side / 2**level) ** 2
            good = apart & collidable(count[which], total[which], pairs[which], moment, chi, noise, dt)
            accepted[which] = good
            for k in which[good]:
                found.append(order[first[k] : first[k] + count[k]])
        keep = np.repeat((count > 1) & ~accepted, count)
        key, m, x, order = key[keep], m[keep], x[keep], order[keep]
    return found


def search_kdtree(position, mass, chi, noise, dt):
    """Clusters as arrays of particles."""
    heavy = mass.max()
    nu = chi * 2 * heavy * heavy / (8 * np.pi * noise)
    # The value of Y M / (4 mu~ dt) above which a pair of the heaviest particles collides with a smaller probability, and its distance.
    if scipy.special.gammaincc(nu, 1e-300) <= PROBABILITY:
        return []
    x = np.exp(scipy.optimize.brentq(lambda s: scipy.special.gammaincc(nu, np.exp(s)) - PROBABILITY, -600, 30))
    reach = np.sqrt(x * 4 * noise * dt * 2 / heavy)
    tree = scipy.spatial.cKDTree(position, balanced_tree=False, compact_nodes=False)
    pairs = tree.query_pairs(reach, output_type="ndarray")
    if len(pairs) == 0:
        return []
    members, index = np.unique(pairs, return_inverse=True)
    index = index.reshape(pairs.shape)
    graph = scipy.sparse.coo_array((np.ones(len(index)), (index[:, 0], index[:, 1])), shape=(len(members),) * 2)
    n, label = scipy.sparse.csgraph.connected_components(graph, directed=False)
    count = np.bincount(label, minlength=n)
    m, xi = mass[members], position[members]
    total = np.bincount(label, m, minlength=n)
    square = np.bincount(label, m * m, minlength=n)
    centre = np.stack([np.bincount(label, m * xi[:, k], minlength=n) / total for k in (0, 1)], axis=1)
    moment = np.bincount(label, m * ((xi - centre[label]) ** 2).sum(axis=1), minlength=n) / total
    good = collidable(count, total, total**2 - square, moment, chi, noise, dt)
    by_cluster = np.argsort(label, kind="stable")
    ends = np.cumsum(count)
    return [members[by_cluster[e - c : e]] for e, c, g in zip(ends, count, good) if g]


def potential(mass, centre, x, y):
    return mass * np.log(np.hypot(x - centre[0], y - centre[1])) / (2 * np.pi)


def deposit(position, mass, lower, h, cells):
    g = (position - lower) / h
    c = np.minimum(g.astype(np.int64), cells - 1)
    f = g - c
    pitch = cells[0] + 1
    node = c[:, 1] * pitch + c[:, 0]
    size = pitch * (cells[1] + 1)
    fx, fy = np.ascontiguousarray(f[:, 0]), np.ascontiguousarray(f[:, 1])
    wx, wy = (1 - fx, fx), (1 - fy, fy)
    rho = np.zeros(size)
    for j in (0, 1):
        for i in (0, 1):
            rho += np.bincount(node + (j * pitch + i), mass * wx[i] * wy[j], minlength=size)
    return rho.reshape(cells[1] + 1, pitch), node, wx, wy


def solve(rho, mass, centre, lower, h, cells):
    nx, ny = cells
    x = lower[0] + h[0] * np.arange(-1, nx + 2)
    y = lower[1] + h[1] * np.arange(-1, ny + 2)
    # The border and one ring of ghost nodes outside it.
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
            out += (wx[i] * wy[j])[:, None] * np.take(gradient, node + (j * pitch + i), axis=0)
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
    # A normal distribution well inside the mesh, the same as that of mollis-bench.
    position = 0.25 * generator.standard_normal((n, 2))
    position = np.clip(position, -1.4, 1.4)
    total = 16 * np.pi
    mass = np.full(n, total / n)
    chi, noise, dt = 1.0, total / n, 1e-5
    spread = np.sqrt(2 * noise / mass[:, None] * dt)

    best = {}
    found = {}
    for _ in range(arguments.repetitions):
        times = [time.process_time()]
        found["quadtree"] = len(search_quadtree(position, mass, lower - 1.5, 6.0, chi, noise, dt))
        times.append(time.process_time())
        found["kdtree"] = len(search_kdtree(position, mass, chi, noise, dt))
        times.append(time.process_time())
        rho, node, wx, wy = deposit(position, mass, lower, h, cells)
        times.append(time.process_time())
        centre = (mass[:, None] * position).sum(axis=0) / total
        gradient = solve(rho, total, centre, lower, h, cells)
        times.append(time.process_time())
        drift = gather(gradient, node, wx, wy, cells[0] + 1)
        times.append(time.process_time())
        normals = generator.standard_normal((n, 2))
        times.append(time.process_time())
        position = position - chi * dt * drift + spread * normals
        np.clip(position, lower, upper, out=position)
        times.append(time.process_time())
        for name, a, b in zip(("quadtree", "kdtree", "deposit", "solve", "gather", "noise", "move"), times, times[1:]):
            best[name] = min(best.get(name, np.inf), b - a)
        best["step"] = min(best.get("step", np.inf), times[-1] - times[2])
    per = {name: 1e9 * seconds / n for name, seconds in best.items()}
    print(
        json.dumps(
            {
                "n": n,
                "grid": arguments.grid,
                "numpy": np.__version__,
                "scipy": scipy.__version__,
                "seconds": best,
                "clusters": found,
                "nanoseconds_per_particle": per["step"],
                "with_quadtree": per["step"] + per["quadtree"],
                "with_kdtree": per["step"] + per["kdtree"],
            }
        )
    )


if __name__ == "__main__":
    main()

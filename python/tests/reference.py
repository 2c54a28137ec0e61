"""The formulas of docs/theory.md and docs/in-your-code.md, written with NumPy and independent of the library."""

import math

import numpy as np

SPHERE = {1: 2.0, 2: 2 * math.pi, 3: 4 * math.pi}


def compact(r, delta, exponent, order, dimension):
    """psi_delta and g = phi'/r of the compact mollifier, from the series in t = 1 - (r/delta)^2 of docs/theory.md;
    orders 2 and 4.
    """
    n, m, k_max = dimension, exponent, order // 2
    r = np.asarray(r, np.float64)
    t = 1 - (r / delta) ** 2
    inside = r < delta
    g, slope, pochhammer = 0.0, 0.0, 1.0
    for k in range(m + k_max):
        weight = 1.0 if k <= m else m + 2 + n / 2
        g = g + weight * pochhammer * t**k
        if k > 0:
            slope = slope + weight * pochhammer * k * t ** (k - 1)
        pochhammer *= (n / 2 + k) / (k + 1)
    # N G + s H = b with H = -2 G'.
    density = n * g + (1 - t) * -2 * slope
    with np.errstate(divide="ignore"):
        outside = r ** -float(n)
    g = np.where(inside, g / delta**n, outside) / SPHERE[n]
    return np.where(inside, density / delta**n, 0.0) / SPHERE[n], g


def plummer(r, delta, dimension):
    """K and K'/r of Plummer's softening: the Newtonian kernel at the distance (r^2 + delta^2)^(1/2)."""
    q = np.asarray(r, np.float64) ** 2 + delta**2
    value = {1: np.sqrt(q) / 2, 2: np.log(q) / (4 * np.pi), 3: -1 / (4 * np.pi * np.sqrt(q))}[dimension]
    return value, q ** (-dimension / 2) / SPHERE[dimension]


def pairs(targets, sources):
    """Differences x_i - x_j and their lengths."""
    d = np.asarray(targets, np.float64)[:, None] - np.asarray(sources, np.float64)[None]
    return d, np.sqrt((d**2).sum(axis=2))


def gradient(targets, sources, masses, factor):
    """sum_j m_j K'(r)/r (x_i - x_j) for K'/r = factor(r)."""
    d, r = pairs(targets, sources)
    return np.einsum("ij,j,ijk->ik", factor(r), np.asarray(masses, np.float64), d)


def plummer_hessian(targets, sources, masses, delta):
    """sum_j m_j (I - D x x^T / q) q^(-D/2) / S_D, x = x_i - x_j, q = |x|^2 + delta^2."""
    d, r = pairs(targets, sources)
    n = d.shape[2]
    q = r**2 + delta**2
    weight = q ** (-n / 2) / SPHERE[n] * np.asarray(masses, np.float64)
    return np.einsum("ij,kl->ikl", weight, np.eye(n)) - n * np.einsum("ij,ijk,ijl->ikl", weight / q, d, d)


def potential(targets, sources, masses, value):
    """sum_j m_j K(r)."""
    return value(pairs(targets, sources)[1]) @ np.asarray(masses, np.float64)


def runge_kutta(x, dt, steps, velocity):
    """The classical method of order 4."""
    x = np.array(x, np.float64)
    for _ in range(steps):
        a = velocity(x)
        b = velocity(x + dt / 2 * a)
        c = velocity(x + dt / 2 * b)
        x = x + dt / 6 * (a + 2 * b + 2 * c + velocity(x + dt * c))
    return x

"""Writes softenings.csv beside itself: algebraic and Gaussian mollifiers and their Newtonian fields, from the definition of psi.

Needs mpmath (60 digits). Takes a minute.

psi is given; with N the dimension, S the measure of the unit sphere and K the Newtonian kernel,

    mass(r) = S int_0^r s^(N-1) psi(s) ds,   g = mass / (S r^N),   h = g' / r = (psi - N g) / r^2
    phi(r) = K(r) - int_r^inf (s g(s) - K'(s)) ds

by numerical integration, so that the closed forms under test are not used. At r = 0 g = psi(0) / N and h = psi''(0) / (N + 2).
"""
from pathlib import Path

from mpmath import diff, exp, inf, log, mp, mpf, pi, quad, sqrt

mp.dps = 60


def sphere(n):
    return {1: mpf(2), 2: 2 * pi, 3: 4 * pi}[n]


def plummer(n, s):
    return n / sphere(n) * (1 + s) ** (-mpf(n) / 2 - 1)


def algebraic(n, s):
    return mpf(n * (n + 2)) / 2 / sphere(n) * (1 + s) ** (-mpf(n) / 2 - 2)


def vatistas(n, s):
    return 2 / sphere(n) * (1 + s * s) ** (-mpf(3) / 2)


def gaussian(order):
    # Weights whose sums with the powers 0 < k < order / 2 of the squared widths vanish.
    def widths(n):
        return [mpf(2 if n == 2 else 4) ** k for k in range(order // 2)]

    def psi(n, s):
        total, all_widths = mpf(0), widths(n)
        for c in all_widths:
            weight = mpf(1)
            for other in all_widths:
                if other != c:
                    weight *= other / (other - c)
            total += weight * exp(-s / c) / sqrt(pi * c) ** n
        return total

    return psi


CASES = (
    [("plummer", plummer, n) for n in (1, 2, 3)]
    + [("algebraic", algebraic, n) for n in (1, 2, 3)]
    + [("vatistas", vatistas, 2)]
    + [(f"gaussian{order}", gaussian(order), n) for order, n in ((2, 1), (2, 2), (2, 3), (4, 3), (6, 2), (6, 3))]
)
RATIOS = [0.0, 1e-9, 1e-3, 0.07, 0.4, 0.9, 1.0, 1.7, 3.3, 6.0, 11.0, 100.0, 3e5]
DELTAS = [1.0, 0.0625, 768.0]


def field(psi, n, x):
    """psi, psi'/x, phi, g, h, mass in units of delta."""
    of = lambda y: psi(n, y * y)
    area = sphere(n)
    pieces = [mpf(k) for k in ("0.25", "0.5", "1", "2", "4", "8", "16", "64", "1e3", "1e5")]

    def mass(y):
        cuts = [mpf(0)] + [p for p in pieces if p < y] + [y]
        return area * quad(lambda s: s ** (n - 1) * of(s), cuts)

    # int_x^inf (s g - K') ds, by parts one integral of psi.
    def difference(y):
        cuts = [y] + [p for p in pieces if p > y] + [inf]
        if n == 1:
            return -quad(lambda s: (s - y) * of(s), cuts)
        if n == 2:
            return -quad(lambda s: s * log(s / y) * of(s), cuts) if y > 0 else None
        return -quad(lambda s: s * s * (1 / y - 1 / s) * of(s), cuts) if y > 0 else None

    if x == 0:
        g = of(0) / n
        curvature = diff(lambda s: psi(n, s), mpf(0), h=mpf("1e-18")) * 2
        # phi(0) = int K psi.
        cuts = [mpf(0)] + pieces + [inf]
        kernel = {1: lambda s: s / 2, 2: lambda s: log(s) / (2 * pi), 3: lambda s: -1 / (4 * pi * s)}[n]
        phi = area * quad(lambda s: s ** (n - 1) * kernel(s) * of(s), cuts)
        return of(0), curvature, phi, g, curvature / (n + 2), mpf(0)
    m = mass(x)
    g = m / (area * x**n)
    kernel = {1: x / 2, 2: log(x) / (2 * pi), 3: -1 / (4 * pi * x)}[n]
    slope = diff(lambda s: psi(n, s), x * x, h=(1 + x * x) * mpf("1e-18")) * 2
    h = (of(x) - n * g) / x**2
    return of(x), slope, kernel - difference(x), g, h, m


def main():
    lines = ["mollifier,dim,delta,r,psi,slope,phi,g,h,mass"]
    for name, psi, n in CASES:
        for ratio in RATIOS:
            for delta in DELTAS:
                r = ratio * delta
                d, x = mpf(delta), mpf(r) / mpf(delta)
                value, slope, phi, g, h, mass = field(psi, n, x)
                phi = phi * d ** (2 - n) + (log(d) / (2 * pi) if n == 2 else 0)
                row = [value / d**n, slope / d ** (n + 2), phi, g / d**n, h / d ** (n + 2), mass]
                lines.append(",".join([name, str(n), repr(delta), repr(r)] + [mp.nstr(v, 30) for v in row]))
    (Path(__file__).parent / "softenings.csv").write_text("\n".join(lines) + "\n")


main()

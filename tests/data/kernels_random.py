"""Writes kernels_random.csv beside itself: mollified kernels at random parameters, from their definition.

Needs python-flint (ball arithmetic, 200 bits). Takes some ten minutes.

Each row is K_delta(r) = (K * psi_delta)(r), K_delta'(r)/r and the Laplacian of K_delta at r, for a kernel K of coefficient 1.
With w the directions, x = r e and y = x - q w, in units of delta:

    u(r)       = int K(q)  q^(d-1) int psi(|y|) dw dq
    u'(r)      = int K'(q) q^(d-1) int (w . e) psi(|y|) dw dq
    (Lap u)(r) = int K'(q) q^(d-1) int w . grad psi(y) dw dq

The outer integrals are taken by the tanh-sinh rule of Takahasi and Mori between the points where the integrand is not
analytic, the inner ones by Gauss-Legendre rules. The results of the steps h and h/2 agree to 18 digits of their size, so that those
of h/2, whose error is about the square, have more than the 22 that are written. Values are also compared with closed forms where
there are some: 2F1 for powers under compact mollifiers, 1F1 under Gaussians, F(kappa) V outside the support for screened kernels.

The columns `size` are the outer integrals with absolute values of K, K' and of psi, - psi'(y)/y in two more dimensions for the gradient
factor, and so on (see `sizes`): what the roundings of any quadrature are relative to.
"""
import random
import sys
from fractions import Fraction
from functools import lru_cache
from pathlib import Path

from flint import arb, ctx

ctx.prec = 200
PI = arb.pi()
NODES = 36


def number(x):
    return arb(x.numerator) / x.denominator if isinstance(x, Fraction) else arb(x)


def pochhammer(a, n):
    product = Fraction(1)
    for k in range(n):
        product *= a + k
    return product


def polynomial(coefficients, x):
    total = arb(0)
    for c in reversed(coefficients):
        total = total * x + c
    return total


class Compact:
    """psi = b(t) / S, t = 1 - |y|^2; Anderson's polynomials of order 2K with exponent M, normalised to mass 1."""

    def __init__(self, d, order, m):
        self.d, self.m, self.name = d, m, f"compact,{order},{m}"
        half, k = Fraction(d, 2), order // 2
        front = (-1) ** (k - 1) * 2 * pochhammer(half, m + k) / (pochhammer(Fraction(1), m) * pochhammer(Fraction(1), k - 1))
        rest = []
        for j in range(k):
            choose = pochhammer(Fraction(1), k - 1) / (pochhammer(Fraction(1), j) * pochhammer(Fraction(1), k - 1 - j))
            rest.append(front * (-1) ** j * choose * pochhammer(half + m + k, j) / pochhammer(Fraction(m + 1), j))
        self.exact = [Fraction(0)] * m + rest
        sphere = (arb(2), 2 * PI, 4 * PI)[d - 1]
        self.rest = [number(c) / sphere for c in rest]
        # b' = t^(M-1) times this; psi'(y)/y = -2 b'(t)/S
        self.slope = [-2 * (m + j) * c for j, c in enumerate(self.rest)]

    def pieces(self, r, kappa):
        if r == 0:
            return [(arb(0), arb(1))]
        if r < 1:
            return [(arb(0), 1 - r), (1 - r, 1 + r)]
        return [(r - 1, r + 1)]

    def at(self, y):
        t = 1 - y * y
        return t**self.m * polynomial(self.rest, t) if t > 0 else arb(0)

    def directions(self, r, q):
        """int psi, int (w.e) psi, int w.grad psi over directions; int |psi|, int |w.grad psi|, |psi'(y)/(2 pi y)| two dimensions up."""
        out = [arb(0)] * 6

        def add(weight, c, up):
            t = (1 - r) * (1 + r) - q * q + 2 * r * q * c
            if not t > 0:
                return
            power = t ** (self.m - 1)
            p, s = power * t * polynomial(self.rest, t), power * polynomial(self.slope, t)
            out[0] += weight * p
            out[1] += weight * c * p
            out[2] += weight * (r * c - q) * s
            out[3] += weight * abs(p)
            out[4] += weight * abs((r * c - q) * s)
            out[5] += up * abs(s) / (2 * PI)

        d = self.d
        least = arb(-1)
        if r != 0:
            cosine = ((r - 1) * (r + 1) + q * q) / (2 * r * q)
            if cosine > 1:
                return out
            if cosine > -1:
                least = cosine
        if d == 1:
            add(arb(1), arb(1), arb(0))
            add(arb(1), arb(-1), arb(0))
        half = (1 - least) / 2 if d != 2 else least.acos() / 2
        for x, w in legendre():
            c = least + half * (1 + x) if d != 2 else (half * (1 + x)).cos()
            if d == 1:
                add(arb(0), c, 2 * PI * half * w)
            elif d == 2:
                add(2 * half * w, c, 4 * PI * half * w * (1 - c * c))
            else:
                add(2 * PI * half * w, c, 2 * PI * PI * half * w * (1 - c * c))
        return out


class Gaussian:
    """Craig & Bertozzi's mollifiers as sums of weights and widths."""

    def __init__(self, d, order):
        self.d, self.order, self.name = d, order, f"gaussian,{order},0"
        parts = {
            (1, 4): [(4, 3, 1), (-1, 3, 4)],
            (1, 6): [(64, 45, 1), (-4, 9, 4), (1, 45, 16)],
            (2, 4): [(2, 1, 1), (-1, 1, 2)],
        }[(d, order)]
        self.parts = [(arb(n) / m, arb(square).sqrt()) for n, m, square in parts]

    def pieces(self, r, kappa):
        ends = {0.0, r}
        for _, c in self.parts:
            c = float(c)
            for centre in (r, max(r - kappa * c * c / 2, 0.0)):
                for steps in (1.5, 4, 10):
                    ends.update((max(centre - steps * c, 0.0), centre + steps * c))
        ends = sorted(ends)
        return [(arb(a), arb(b)) for a, b in zip(ends, ends[1:]) if b > a]

    def at(self, y):
        return sum(w * (-((y / c) ** 2)).exp() / (PI.sqrt() * c) ** self.d for w, c in self.parts)

    def directions(self, r, q):
        out = [arb(0)] * 6
        for weight, c in self.parts:
            e = (-(((r - q) / c) ** 2)).exp()
            if e < 1e-60:
                continue
            front = weight * e / (PI.sqrt() * c) ** self.d
            x = 2 * r * q / c**2
            # means of 1 and of the cosine over directions, of 1 two dimensions up
            if self.d == 1:
                far = (-2 * x).exp()
                plain, cosine = 1 + far, 1 - far
                up = 4 * PI * ((1 - far) / (2 * x) if x > 1e-30 else 1)
            else:
                i0, i1 = (x.bessel_i(n) * (-x).exp() for n in (0, 1))
                plain, cosine = 2 * PI * i0, 2 * PI * i1
                up = 2 * PI * PI * (2 * i1 / x if x > 1e-30 else 1)
            inward = -2 / c**2 * (r * cosine - q * plain)
            out[0] += front * plain
            out[1] += front * cosine
            out[2] += front * inward
            out[3] += abs(front) * plain
            out[4] += abs(front * inward)
            out[5] += abs(front) * up / (PI * c * c)
        return out


@lru_cache(maxsize=None)
def legendre():
    rule = []
    for k in range(NODES):
        x = (PI * (k + arb(3) / 4) / (NODES + arb(1) / 2)).cos().mid()
        for _ in range(8):
            p, before = arb(1), arb(0)
            for j in range(NODES):
                p, before = ((2 * j + 1) * x * p - j * before) / (j + 1), p
            slope = NODES * (x * p - before) / (x * x - 1)
            x = (x - p / slope).mid()
        rule.append((x, 2 / ((1 - x * x) * slope * slope)))
    return rule


@lru_cache(maxsize=None)
def tanh_sinh():
    """(distance from the nearer end, weight) on [0, 1], step 1/48, the middle first."""
    h = arb(1) / 48
    rule = []
    k = 0
    while True:
        x = 1 / (1 + (PI * (k * h).sinh()).exp())
        weight = h * PI * (k * h).cosh() * x * (1 - x)
        if weight < arb(10) ** -1000:
            return rule
        rule.append((x.mid(), weight.mid()))
        k += 1


def bare(law, parameter, d, q):
    """K, K' and the Laplacian of K at q, in units of delta."""
    if law == "power":
        p = parameter
        slope = q ** (p - 1)
        return q.log() if p == 0 else q**p / p, slope, (p + d - 2) * slope / q
    if law == "exponential":
        e = (-parameter * q).exp()
        return e, -parameter * e, parameter * e * (parameter - (d - 1) / q)
    k = parameter
    if d == 1:
        e = (-k * q).exp()
        value, slope = -e / (2 * k), e / 2
    elif d == 2:
        value, slope = -(k * q).bessel_k(0) / (2 * PI), k * (k * q).bessel_k(1) / (2 * PI)
    else:
        e = (-k * q).exp() / (4 * PI * q)
        value, slope = -e, e * (k + 1 / q)
    return value, slope, k * k * value


def convolve(law, parameter, psi, r):
    """Value, derivative and Laplacian at r in units of delta, with steps h/2 and h, and their sizes."""
    d = psi.d
    kappa = 0.0 if law == "power" else float(parameter)
    fine, coarse, size = [arb(0)] * 3, [arb(0)] * 3, [arb(0)] * 4
    for a, b in psi.pieces(r, kappa):
        length = b - a
        here = [arb(0)] * 3
        for left in (True, False):
            idle = 0
            for k, (x, weight) in enumerate(tanh_sinh()):
                if k == 0 and not left:
                    continue
                q = a + length * x if left else b - length * x
                at = psi.directions(r, q)
                value, slope, laplacian = bare(law, parameter, d, q)
                volume = weight * length * q ** (d - 1)
                terms = (volume * value * at[0], volume * slope * at[1], volume * slope * at[2])
                small = True
                for n, term in enumerate(terms):
                    fine[n] += term
                    here[n] += term
                    if k % 2 == 0:
                        coarse[n] += 2 * term
                    small = small and abs(term) <= 1e-40 * abs(here[n])
                slope, laplacian = abs(volume * slope), abs(volume * laplacian)
                for n, term in enumerate((abs(volume * value) * at[3], slope * q * at[5], laplacian * at[3], slope * at[4])):
                    size[n] += term
                idle = idle + 1 if small else 0
                if idle == 8:
                    break
    return fine, coarse, size


def closed(law, parameter, psi, r):
    """The value by another way, where there is one."""
    half = arb(psi.d) / 2
    if law == "power" and parameter != 0:
        p, total = parameter, arb(0)
        if isinstance(psi, Gaussian):
            for w, c in psi.parts:
                total += w * c**p * ((p + psi.d) / 2).gamma() / half.gamma() * (-((r / c) ** 2)).hypgeom_1f1(-p / 2, half)
        elif r != 1:
            for g, c in enumerate(psi.exact):
                if c == 0:
                    continue
                beta = lambda a: a.gamma() * arb(g + 1).gamma() / (a + g + 1).gamma()
                if r < 1:
                    total += number(c) / 2 * beta((p + psi.d) / 2) * (r * r).hypgeom_2f1(-p / 2, -g - (p + psi.d) / 2, half)
                else:
                    term = (1 / r**2).hypgeom_2f1(-p / 2, 1 - (p + psi.d) / 2, g + 1 + half)
                    total += number(c) / 2 * beta(half) * term * r**p
        else:
            return None
        return total / p
    if (law == "screened" or law == "exponential" and psi.d == 1) and isinstance(psi, Compact) and r >= 1:
        total = arb(0)
        for g, c in enumerate(psi.exact):
            gammas = arb(g + 1).gamma() * half.gamma() / (half + g + 1).gamma()
            total += number(c) / 2 * gammas * (parameter**2 / 4).hypgeom_0f1(half + g + 1)
        return total * bare(law, parameter, psi.d, r)[0]
    return None


def row(law, parameter, psi, delta, r):
    """Value, gradient factor, Laplacian and their sizes, in the caller's units. `parameter` is p, l or k."""
    d = psi.d
    delta, r, parameter = arb(delta), arb(r), arb(parameter)
    rho = r / delta
    unit = parameter if law == "power" else delta / parameter if law == "exponential" else delta * parameter
    if rho.mid() < 1 < rho.upper() or rho.lower() < 1 < rho.mid():
        rho = arb(1)
    rho = rho.mid()
    fine, coarse, size = convolve(law, unit, psi, rho)
    scales = [size[0], size[1], size[3]]
    for n, (a, b, s) in enumerate(zip(fine, coarse, scales)):
        if not (abs(a - b) < 1e-18 * s + 1e-12 * abs(a) and a.rad() < 1e-30 * s):
            sys.exit(f"{law} {parameter} {psi.name} {delta} {r}: {n} by two steps {a} {b} {s}")
    other = closed(law, unit, psi, rho)
    if other is not None and not abs(other - fine[0]) < 1e-26 * size[0]:
        sys.exit(f"{law} {parameter} {psi.name} {delta} {r}: {fine[0]} and {other} in closed form")
    value, slope, laplacian = fine
    factor = laplacian / d if rho == 0 else slope / rho
    sizes = [size[0], size[1], size[2]]
    if law == "screened":
        # the Laplacian is psi + k^2 K * psi
        sizes[2] += abs(psi.at(rho))
    power = parameter if law == "power" else arb(0) if law == "exponential" else arb(2 - d)
    scale = [delta**power, delta ** (power - 2), delta ** (power - 2)]
    values = [v * s for v, s in zip((value, factor, laplacian), scale)]
    if law == "power" and parameter == 0:
        values[0] += delta.log()
    return values, [float((v * s).mid()) for v, s in zip(sizes, scale)], float((size[3] * scale[2]).mid())


def short(x, digits):
    """x rounded to so many bits, so that single precision holds it too."""
    if x == 0:
        return 0.0
    scale = 1.0
    while x * scale >= 2**digits:
        scale /= 2
    while x * scale < 2 ** (digits - 1):
        scale *= 2
    return round(x * scale) / scale


def distances(delta, reach, count):
    for _ in range(count):
        kind, k = random.random(), random.randint(1, 12)
        if kind < 0.08:
            rho = 0.0
        elif kind < 0.16:
            rho = 1.0
        elif kind < 0.30:
            rho = 1 - 2.0**-k
        elif kind < 0.42:
            rho = 1 + 2.0**-k
        elif kind < 0.75:
            rho = short(random.random(), 12)
        elif kind < 0.82:
            rho = short(10 ** random.uniform(-4, -1), 12)
        elif kind < 0.92:
            rho = short(random.uniform(1, min(3, reach)), 12)
        else:
            rho = short(10 ** random.uniform(0, 1.7), 12)
        yield delta * min(rho, short(reach, 12))


def choose_law(d, widest):
    """A law with its parameter as the library takes it; `widest` bounds kappa, so that the exterior factor is finite."""
    delta = short(10 ** random.uniform(-3, 2), 10)
    kind = random.choice(["integer", "half", "real", "real", "log", "exponential", "exponential", "screened", "screened"])
    if kind == "log":
        return "power", 0.0, delta, 50.0
    if kind in ("integer", "half", "real"):
        low = 1 - d
        if kind == "integer":
            p = float(random.randint(low + 1, 9))
        elif kind == "half":
            p = random.randint(low, 7) + 0.5
        else:
            p = round(low + 10 ** random.uniform(-1.3, 1.0), 3)
        return "power", p, delta, 50.0
    kappa = min(10 ** random.uniform(-2, 1.477), widest)
    reach = min(50.0, 500 / kappa)
    if kind == "exponential":
        return "exponential", float(f"{delta / kappa:.4g}"), delta, reach
    return "screened", float(f"{kappa / delta:.4g}"), delta, reach


def is_newtonian(law, p, d):
    return law == "power" and p == 2 - d


def main():
    random.seed(20)
    mollifiers = [(Compact(d, order, m), 30.0) for d in (1, 2, 3) for order in (2, 4, 6, 8) for m in range(1, 10)] * 2
    mollifiers += [(Gaussian(1, 4), 20.0), (Gaussian(1, 6), 10.0), (Gaussian(2, 4), 25.0)] * 14
    lines = []
    for psi, widest in mollifiers:
        law, parameter, delta, reach = choose_law(psi.d, widest)
        while is_newtonian(law, parameter, psi.d):
            law, parameter, delta, reach = choose_law(psi.d, widest)
        for r in distances(delta, reach, 3):
            values, sizes, weak = row(law, parameter, psi, delta, r)
            # the Laplacian's size by the better of its two integrals
            sizes[2] = min(sizes[2], weak)
            texts = [v.str(22, radius=False) for v in values] + [f"{s:.3g}" for s in sizes]
            lines.append(f"{psi.d},{law},{parameter!r},{psi.name},{delta!r},{r!r}," + ",".join(texts))
            print(len(lines), lines[-1], flush=True)
    head = "dimension,law,parameter,mollifier,order,exponent,delta,r,value,gradient_factor,laplacian,value_size,gradient_size,laplacian_size"
    Path(__file__).with_suffix(".csv").write_text("\n".join([head, *lines]) + "\n")


if __name__ == "__main__":
    main()

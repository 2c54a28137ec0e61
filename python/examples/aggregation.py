"""Draws Figure 5 of Craig & Bertozzi (2016): L1 errors at t = 0.5 for the aggregation equation in the plane,
K = log|x| / (2 pi).

python aggregation.py [figure5.png]
"""

import sys

import numpy as np

import mollis
from mollis import kernels, mollifiers
from mollis.diagnostics import distance_norm, norm

# Density and mass within r, as functions of r^2.
BUMP = (lambda r2: (1 - r2) ** 2, lambda r2: np.pi * r2 * (1 - r2 + r2**2 / 3))
DISC = (lambda r2: np.ones_like(r2), lambda r2: np.pi * r2)


def errors(h, initial, mollifier, t=0.5, steps=20):
    """Errors of positions and densities. Exactly, r(t)^2 = r^2 - mass(r) t / pi and rho(t) = rho / (1 - t rho)."""
    axis = h * np.arange(-int(1 / h), int(1 / h) + 1)
    x = np.stack(np.meshgrid(axis, axis), axis=-1).reshape(-1, 2)
    x = x[(x**2).sum(axis=1) < 1 - 1e-12]
    r2 = np.maximum((x**2).sum(axis=1), 1e-300)
    rho, mass = (function(r2) for function in initial)
    exact, exact_rho = x * np.sqrt(1 - mass * t / (np.pi * r2))[:, None], rho / (1 - t * rho)
    kernel = mollis.Kernel(kernels.newtonian(), mollifier, delta=h**0.9)
    mollis.blob(kernel, x, rho * h**2, t / steps, steps, density=rho)
    return distance_norm(x, exact, cell=h**2), norm(rho - exact_rho, cell=h**2)


def main(file="figure5.png"):
    import matplotlib.pyplot as plt

    gaussian, figure = mollifiers.gaussian(4), plt.figure(figsize=(12, 4), layout="constrained")
    cases = [
        ("regular, m = 4", BUMP, gaussian),
        ("regular, particle method", BUMP, None),
        ("disc, m = 4", DISC, gaussian),
    ]
    widths = np.array([0.1, 0.0707, 0.05, 0.0354, 0.025])
    for i, (title, initial, mollifier) in enumerate(cases):
        axes = figure.add_subplot(1, 3, i + 1, title=title, xlabel="h", ylabel="L1 error at t = 0.5")
        found = np.array([errors(h, initial, mollifier) for h in widths])
        for values, label in zip(found.T, ("positions", "density")):
            if label == "positions" or mollifier is not None:
                rate = np.polyfit(np.log(widths), np.log(values), 1)[0]
                axes.loglog(widths, values, "o-", label=f"{label}, slope {rate:.2f}")
        axes.legend()
        axes.set_xticks(widths, [str(h) for h in widths])
        axes.set_xticks([], minor=True)
    figure.savefig(file, bbox_inches="tight")


if __name__ == "__main__":
    main(*sys.argv[1:])

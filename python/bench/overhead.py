"""What a call costs: the time of `mollis.field` for few particles, the C function's share of it, and what Python adds.

python overhead.py
"""

import time
import timeit

import numpy as np

import mollis
from mollis import kernels, mollifiers


def least(function, calls=20_000, repeats=7):
    """The least processor time of a call in microseconds."""
    return min(timeit.repeat(function, number=calls, repeat=repeats, timer=time.process_time)) / calls * 1e6


def main():
    kernel = mollis.Kernel(kernels.newtonian(), mollifiers.compact(2, 4), 0.05)
    print("particles   mollis.field   in C   Python adds   (microseconds)")
    for n in (1, 8, 64):
        x, m, g = np.random.rand(n, 2), np.ones(n), np.empty((n, 2))
        call = lambda: mollis.field(kernel, x, m, gradient=g)
        function, seen = kernel._api["field#_eval"], []
        kernel._api["field#_eval"] = lambda *arguments: seen.append(arguments) or function(*arguments)
        call()
        kernel._api["field#_eval"] = function
        whole, inside = least(call), least(lambda: function(*seen[-1]))
        print(f"{n:9} {whole:14.2f} {inside:6.2f} {whole - inside:13.2f}")


if __name__ == "__main__":
    main()

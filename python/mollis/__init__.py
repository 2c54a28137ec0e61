"""Sums over softened potentials, the blob method and coalescing particles.

    import numpy as np, mollis
    from mollis import kernels, mollifiers

    kernel = mollis.Kernel(kernels.newtonian(), mollifiers.compact(2, 4), delta=0.05)
    x, m = np.random.rand(1000, 2), np.full(1000, 1e-3)
    print(mollis.field(kernel, x, m, gradient=True).gradient)

Arrays are (n, D) in C order; float64, or float32 with a kernel of that dtype. They are read and written where they
are, also with strides. The sign convention is Laplacian(K) = +Dirac for the Newtonian kernel; positive coefficients
attract. Calls run on all cores and release Python's lock.
"""

from . import diagnostics, kernels, mollifiers, pks, random
from ._blob import BlobRun, Diffusion, blob
from ._declarations import VERSION as __version__
from ._field import Counts, Essential, Field, essential, field, plan
from ._library import Error, Status, set_threads
from .grid import Medium, Mesh, MeshField
from .kernels import Kernel
from .mollifiers import Mollifier


__all__ = [
    "__version__",
    "BlobRun", "Counts", "Diffusion", "Error", "Essential", "Field", "Kernel", "Medium", "Mesh", "MeshField", "Mollifier", "Status",
    "blob", "diagnostics", "essential", "field", "kernels", "mollifiers", "pks", "plan", "random", "set_threads",
]  # fmt: skip

import signal

import numpy as np
import pytest

import mollis
from mollis import kernels, mollifiers

# Programs that a shell starts in the background ignore Ctrl-C, and tests that press it would wait forever.
signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.fixture
def rng():
    return np.random.default_rng(20)


@pytest.fixture
def soft():
    """The Newtonian kernel in the plane under a compact mollifier of length 0.3."""
    return mollis.Kernel(kernels.newtonian(), mollifiers.compact(2, 4), delta=0.3)


@pytest.fixture
def cloud(rng):
    """200 points in the plane and masses of both signs."""
    return rng.random((200, 2)), rng.standard_normal(200)

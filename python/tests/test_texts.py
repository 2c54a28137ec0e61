"""What the documentation shows runs; examples reach known numbers."""

import runpy
from pathlib import Path

import numpy as np
import pytest

from mollis import mollifiers

ROOT = Path(__file__).resolve().parents[2]


@pytest.mark.parametrize("file", ["README.md", "docs/python.md", "docs/first-hour.md", "python/README.md"])
def test_programs_in_pages(file):
    text = (ROOT / file).read_text()
    programs = [part.split("```")[0] for part in text.split("```python\n")[1:]]
    assert programs, f"{file} shows no program"
    names: dict = {}
    for program in programs:
        exec(compile(program, file, "exec"), names)


def test_figure_5():
    """Errors of an independent implementation, within 2%; rates of the particle method and of discontinuous data."""
    example = runpy.run_path(str(ROOT / "python/examples/aggregation.py"))
    errors, gaussian = example["errors"], mollifiers.gaussian(4)
    known = {0.1: (6.02e-4, 2.41e-3), 0.0707: (1.98e-4, 7.58e-4), 0.05: (5.97e-5, 2.29e-4), 0.0354: (1.85e-5, 6.78e-5)}
    for h, values in known.items():
        np.testing.assert_allclose(errors(h, example["BUMP"], gaussian), values, rtol=0.02)
    for initial, mollifier, least, most in [("BUMP", None, 1.9, 2.1), ("DISC", gaussian, 0.8, 2.5)]:
        coarse, fine = (errors(h, example[initial], mollifier)[0] for h in (0.1, 0.025))
        assert least < np.log(coarse / fine) / np.log(4) < most

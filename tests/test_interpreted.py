"""The kernels as the interpreter runs them: what they compute does not hang on how they are compiled.

There numpy warns where a kernel goes on with infinity or NaN.
"""

import os
import subprocess
import sys
from pathlib import Path

TESTS = Path(__file__).parent
SMALL = (
    "test_elementary.py",
    "arms/test_boxes.py",
    "arms/test_motion_kernels.py",
    "certificate/test_tube.py",
    "certificate/test_values.py",
    "optimizers/test_optimizers.py",
    "planners/test_candidates.py::test_the_chord_sum_is_that_of_numpy",
    "planners/test_candidates.py::test_what_is_not_exact_lies_between_its_threshold_and_the_truth",
)


def test_kernels_pass_their_tests_uncompiled():
    run = subprocess.run(
        [
            sys.executable,
            "-m",
            "pytest",
            "-q",
            "-p",
            "no:cacheprovider",
            "-p",
            "no:xdist",
            "-W",
            "ignore::RuntimeWarning",
            *(TESTS / name for name in SMALL),
        ],
        env={**os.environ, "NUMBA_DISABLE_JIT": "1"},
        cwd=TESTS.parent,
        capture_output=True,
        text=True,
        check=False,
    )
    assert run.returncode == 0, run.stdout[-3000:]

"""Files of compiled code that cannot be written or read: everything works, slower."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

MODULE = """
import resource, sys
from selfmotion._compiled import kernel

@kernel
def twice(x):
    return 2.0 * x

if len(sys.argv) > 1:
    resource.setrlimit(resource.RLIMIT_FSIZE, (int(sys.argv[1]), int(sys.argv[1])))
print(twice(2.0), sum(twice.stats.cache_hits.values()))
"""

SUMS = """
import sys
import numpy as np
from selfmotion._compiled import fast_kernel
from selfmotion._objective_kernels import chord_sum

@fast_kernel
def twice_summed(runs, weights, sheet, costs):
    for i in range(len(costs)):
        k = len(runs) - i % 5
        costs[i] = chord_sum(0, runs, weights, k, sheet, 1, 0) + chord_sum(1, runs, weights, k, sheet, 1, 0)

rng, costs = np.random.default_rng(0), np.empty((20, 20))
if len(sys.argv) > 1:
    chord_sum(0, rng.random(200), rng.random(3), 200, rng.random((4, 201)), 1, 0)
    rng = np.random.default_rng(0)
for row in costs:
    twice_summed(rng.random(200), rng.random(3), 7.0 * rng.random((4, 201)), row)
print(costs.tobytes().hex(), sum(twice_summed.stats.cache_hits.values()))
"""


@pytest.fixture
def compiled(tmp_path):
    """Runs a module in a process of its own; what it printed."""
    file = tmp_path / "kernels_of_a_test.py"

    def call(*arguments, module=MODULE, cache=tmp_path / "cache"):
        if not file.exists():
            file.write_text(module)
        environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path), "NUMBA_CACHE_DIR": str(cache)}
        environment |= {"HOME": "/dev/null", "XDG_CACHE_HOME": "/dev/null"} if str(cache).startswith("/dev") else {}
        command = [sys.executable, str(file), *arguments]
        done = subprocess.run(command, capture_output=True, text=True, check=False, env=environment)
        assert done.returncode == 0, done.stderr
        return done.stdout.split()

    return call


def test_compiled_code_is_found_again(compiled):
    assert compiled() == ["4.0", "0"]
    assert compiled()[-1] == "1"


@pytest.mark.parametrize("size", ["0", "3000"])
def test_a_disk_that_is_full(compiled, size):
    assert compiled(size)[:1] == ["4.0"]
    assert compiled()[:1] == ["4.0"]
    assert compiled()[-1] == "1"


def test_the_first_run_gives_the_bits_of_the_second(compiled, tmp_path):
    first, second = compiled(module=SUMS), compiled(module=SUMS)
    assert (first[1], second[1]) == ("0", "1")
    assert first[0] == second[0]
    # Nor does it matter whether what is called has run by itself, or that nothing is kept.
    assert compiled("before", module=SUMS)[0] == first[0]
    (tmp_path / "__pycache__").touch()  # in place of the folder
    assert compiled(module=SUMS, cache="/dev/null/cache") == first


def test_no_place_for_files(compiled, tmp_path):
    (tmp_path / "__pycache__").touch()  # in place of the folder
    for _ in range(2):
        assert compiled(cache="/dev/null/cache") == ["4.0", "0"]


@pytest.mark.parametrize(("suffix", "left"), [("nbi", 30), ("nbc", 2000)])
def test_files_torn_by_what_ended_their_writer(compiled, tmp_path, suffix, left):
    compiled()
    files = list(Path(tmp_path / "cache").rglob(f"*.{suffix}"))
    assert files
    for file in files:
        file.write_bytes(file.read_bytes()[:left])
    assert compiled() == ["4.0", "0"]
    assert compiled()[-1] == "1"  # and they are mended


def test_every_kernel_does_without_a_place_for_files():
    code = (
        "import pkgutil, importlib, selfmotion\n"
        "from numba.core.caching import CacheImpl\n"
        "CacheImpl._locator_classes = []\n"
        "names = [m.name for m in pkgutil.walk_packages(selfmotion.__path__, 'selfmotion.') if 'kernels' in m.name]\n"
        "for name in names: importlib.import_module(name)\n"
        "print(len(names))"
    )
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False, env=environment)
    assert done.returncode == 0, done.stderr
    assert int(done.stdout) > 20

"""The seed's 3R case, how much of random batteries is run, and how hypothesis runs here."""

import numpy as np
import pytest
from hypothesis import settings

import selfmotion as sm

settings.register_profile("selfmotion", deadline=None, derandomize=True, print_blob=False)
settings.load_profile("selfmotion")

SEED_POINTS = [[50, -10], [85, 30], [50, 50], [60, -10], [58, 30], [70, -10]]


def pytest_addoption(parser):
    parser.addoption("--full", action="store_true", help="random batteries as large as the docs say, not a fifth of it")


@pytest.fixture(scope="session")
def share(pytestconfig):
    """How much of a random battery is run: its first cases, or with --full all of them."""
    return 1.0 if pytestconfig.getoption("full") else 0.2


@pytest.fixture(scope="session")
def seed_arm():
    return sm.PlanarArm([30, 30, 20], [None, (0, np.pi), None])


@pytest.fixture(scope="session")
def seed_path():
    return sm.Bezier(SEED_POINTS)


@pytest.fixture(scope="session")
def seed_problem(seed_arm, seed_path):
    return sm.Problem(seed_arm, seed_path)


@pytest.fixture(scope="session")
def seed_plan(seed_problem):
    planner = sm.Sinusoid([0.3], amplitude=[0.4], optimizer=sm.PSO(seed=1))
    return sm.plan(seed_problem, planner)


@pytest.fixture
def seed_file(tmp_path):
    """A problem file of the seed's case with a small budget, and a way to change it."""
    import json

    def write(name="problem.json", **changes):
        data = {
            "arm": {"kind": "planar", "links": [30, 30, 20], "limits": [None, [0, np.pi], None]},
            "path": {"kind": "bezier", "control_points": SEED_POINTS},
            "planner": {
                "kind": "sinusoid",
                "offset": [0.3],
                "amplitude": [0.4],
                "optimizer": {"kind": "pso", "population": 8, "iterations": 5, "bounds": [0, 2], "seed": 1},
            },
        }
        for key, value in changes.items():
            if value is None:
                data.pop(key, None)
            else:
                data[key] = value
        file = tmp_path / name
        file.write_text(json.dumps(data))
        return str(file)

    return write


@pytest.fixture
def run(capsys):
    """The command line: arguments to exit code, stdout and stderr."""
    from selfmotion.cli import _run

    def call(*arguments):
        code = _run(list(arguments))
        captured = capsys.readouterr()
        return code, captured.out, captured.err

    return call

"""Which cells of two slices motions join: a flood of samples never leaves its group, and a wall makes two of them."""

import numpy as np
import pytest
from scipy.ndimage import label

import selfmotion as sm
from selfmotion.certificate.connected import groups
from selfmotion.deadline import OutOfTimeError
from selfmotion.report import seed_3r

LOOKS = np.linspace(-np.pi, np.pi, 3001)


@pytest.fixture(scope="module")
def problem():
    """The paper's arm with a disc that parts its self-motion for a while."""
    given = seed_3r.problem()
    return sm.Problem(given.arm, given.path, obstacles=[sm.CircleObstacle([28.0, 8.0], 2.0)], clearance=0.5)


def parted(problem, low, high):
    cover = problem.arm.cover()
    one, two = (cover.cells(problem.path(r), 0.05) for r in (low, high))
    of_one, of_two = groups(problem.arm.slabs(problem.path), low, high, one, two, np.inf)
    return one, two, of_one, of_two


def at(cells, q):
    """Return which cells hold a posture."""
    away = np.abs(q - 0.5 * (cells.a + cells.b))
    away = np.minimum(away, np.abs(away - 2 * np.pi) * np.array([1.0, np.inf, 1.0]))
    return (away <= 0.5 * np.abs(cells.b - cells.a) + cells.dev + 1e-9).all(axis=1)


@pytest.mark.parametrize("low", [0.1, 0.4, 0.55, 0.8])
def test_floods_stay_in_their_groups(problem, low):
    high = low + 0.06
    one, two, of_one, of_two = parted(problem, low, high)
    r = np.linspace(low, high, 61)
    q, ok = problem.arm.bare.solve(problem.path(r)[:, None], LOOKS[None, :, None], 0)
    free = ok & (problem.arm.limits.excess(q).max(axis=-1) <= 0.0) & (problem.arm.least(q)[..., 0] >= 0.0)
    parts, count = label(free)
    joined = 0
    for part in range(1, count + 1):
        first, last = np.flatnonzero(parts[0] == part), np.flatnonzero(parts[-1] == part)
        if not len(first) or not len(last):
            continue
        joined += 1
        seen = [of[at(cells, posture)] for cells, of, row, where in ((one, of_one, 0, first), (two, of_two, -1, last))
                for posture in q[row, where[:: max(1, len(where) // 20)]]]  # fmt: skip
        assert all((numbers >= 0).any() for numbers in seen)
        shared = set.intersection(*(set(numbers.tolist()) for numbers in seen))
        assert shared
    assert joined


def test_a_wall_makes_two_groups(problem):
    _, _, of_one, of_two = parted(problem, 0.4, 0.46)
    assert len(set(of_one.tolist()) - {-1}) == 2
    assert set(of_one.tolist()) - {-1} == set(of_two.tolist()) - {-1}


def test_without_time_nothing_is_told(problem):
    cover = problem.arm.cover()
    cells = cover.cells(problem.path(0.4), 0.3)
    with pytest.raises(OutOfTimeError):
        groups(problem.arm.slabs(problem.path), 0.4, 0.5, cells, cells, 0.0)

"""What a problem accepts, and how it refuses the rest."""

import numpy as np
import pytest

import selfmotion as sm
from selfmotion.paths import Path

ARM = sm.PlanarArm([30, 30, 20], [None, (0, np.pi), None])
PATH = sm.Bezier([[50, -10], [85, 30], [50, 50], [60, -10], [58, 30], [70, -10]])


def test_rows_are_the_grid_and_every_waypoint():
    path = sm.Waypoints([[50, 0], [55, 0], [55, 7]])
    problem = sm.Problem(ARM, path, samples=11)
    assert set(path.waypoints) <= set(problem.rows)
    assert set(problem.grid) <= set(problem.rows)
    assert len(problem.rows) == 12


def test_start_may_be_given_three_ways():
    by_list = sm.Problem(ARM, PATH, start=[0.3]).start
    by_u = sm.Problem(ARM, PATH, start={"u": [0.3]}).start
    q = ARM.solve(PATH(0.0), [0.3], 0)[0]
    by_q = sm.Problem(ARM, PATH, start={"q": q}).start
    assert by_list.u == by_u.u
    assert by_q.u[0] == pytest.approx(0.3)
    assert by_q.branches == (0,)


REFUSED = {
    "path": lambda: sm.Problem(ARM, sm.Line([500, 0], [600, 0])),
    "path (too near)": lambda: sm.Problem(sm.PlanarArm([10, 1, 1]), sm.Line([1, 0], [0, 1])),
    "samples": lambda: sm.Problem(ARM, PATH, samples=1),
    "samples (huge)": lambda: sm.Problem(ARM, PATH, samples=10**12),
    "samples (text)": lambda: sm.Problem(ARM, PATH, samples="many"),
    "elbow": lambda: sm.Problem(ARM, PATH, elbow="left"),
    "cyclic": lambda: sm.Problem(ARM, PATH, cyclic="exact"),
    "cyclic (unknown)": lambda: sm.Problem(ARM, sm.Circle([50, 0], 5), cyclic="yes"),
    "weights": lambda: sm.Problem(ARM, PATH, weights=[1, 2]),
    "objective": lambda: sm.Problem(ARM, PATH, objective="l3"),
    "start": lambda: sm.Problem(ARM, PATH, start={"x": [1]}),
    "start (both)": lambda: sm.Problem(ARM, PATH, start={"u": [0.3], "q": [0, 0, 0]}),
    "start.u": lambda: sm.Problem(ARM, PATH, start=[0.3, 0.4]),
    "start.u (outside)": lambda: sm.Problem(ARM, PATH, start=[3.0]),
    "start.q": lambda: sm.Problem(ARM, PATH, start={"q": [0.0, 0.1, 0.2]}),
    "start.q (elbow)": lambda: sm.Problem(
        sm.PlanarArm([30, 30, 20]),
        PATH,
        start={"q": sm.PlanarArm([30, 30, 20]).solve(PATH(0.0), [0.3], 1)[0]},
        elbow="positive",
    ),
    "end.u": lambda: sm.Problem(ARM, PATH, end=[3.0]),
    "obstacles (none)": lambda: sm.Problem(ARM, PATH, obstacles=None),
    "obstacles (one)": lambda: sm.Problem(ARM, PATH, obstacles=sm.CircleObstacle([1, 2], 1)),
    "obstacles (text)": lambda: sm.Problem(ARM, PATH, obstacles="circle"),
    "obstacles.0": lambda: sm.Problem(ARM, PATH, obstacles=[{"circle": {"center": [1, 2], "radius": 1}}]),
    "self_collision": lambda: sm.Problem(ARM, PATH, self_collision="no"),
    "clearance": lambda: sm.Problem(ARM, PATH, clearance=None),
}


@pytest.mark.parametrize("case", REFUSED)
def test_bad_problems_are_refused_by_field(case):
    with pytest.raises(sm.InvalidInputError) as caught:
        REFUSED[case]()
    assert caught.value.field == case.split(" ")[0]
    assert caught.value.remedy


def test_a_start_beyond_a_limit_names_joint_and_amount():
    q = ARM.solve(PATH(0.0), [0.3], 1)[0]
    with pytest.raises(sm.InvalidInputError, match=r"joint 2 .* outside its limits"):
        sm.Problem(ARM, PATH, start={"q": q})


def test_a_start_out_of_reach_says_where_u_may_lie():
    with pytest.raises(sm.InvalidInputError, match=r"-2\.06678, 1\.67199.* with a positive elbow"):
        sm.Problem(ARM, PATH, start=[3.0])


def test_units_are_suspected_when_nothing_is_in_reach():
    with pytest.raises(sm.InvalidInputError, match="units"):
        sm.Problem(sm.PlanarArm([0.3, 0.3, 0.2]), PATH)


class Broken(sm.PlanarArm):
    """An arm one of whose methods gives no numbers."""

    method = ""

    def solve(self, x, u, branch=0):
        q, ok = super().solve(x, u, branch)
        return (q * np.nan if self.method == "solve" else q), ok

    def task_residual(self, q, x):
        return super().task_residual(q, x) * (np.nan if self.method == "task_residual" else 1.0)

    def task_error(self, q, x):
        return super().task_error(q, x) * (np.nan if self.method == "task_error" else 1.0)

    def jacobian(self, q):
        return super().jacobian(q) * (np.nan if self.method == "jacobian" else 1.0)


@pytest.mark.parametrize("links", [[30, 30, 20], [20, 20, 20, 20]])
@pytest.mark.parametrize("method", ["solve", "task_residual", "task_error", "jacobian"])
def test_an_arm_that_gives_no_numbers_is_refused_by_its_method(links, method):
    arm = Broken(links)
    sm.Problem(arm, PATH)
    arm.method = method
    with pytest.raises(sm.InvalidInputError, match=f"arm: gives no finite numbers at r = .*mend Broken.{method}"):
        sm.Problem(arm, PATH)


class Hole(Path):
    """A line on which one point is no number."""

    kind = "hole"

    def __init__(self, r, order=0):
        self.r, self.order = r, order

    def _evaluate(self, r, order):
        values = sm.Line([50, -10], [60, 10])(r, order)
        return np.where(((r == self.r) & (order == self.order))[:, None], np.nan, values)


@pytest.mark.parametrize("order", [0, 1])
@pytest.mark.parametrize("r", [0.0, 0.25, 1.0])
def test_a_path_with_a_point_that_is_no_number_is_bad_input_and_no_proof(r, order):
    with pytest.raises(sm.InvalidInputError, match=f"path: has no finite .* at r = {r:g}"):
        sm.Problem(ARM, Hole(r, order))

"""The scene as plain data: path, reach, what is blocked."""

import numpy as np
import pytest

import selfmotion as sm
from selfmotion.studio.cases import CASES
from selfmotion.studio.problems import problem_of
from selfmotion.studio.scene import scene
from selfmotion.studio.wire import unpacked

BY_NAME = {case.name: case.problem for case in CASES}


def seen(data, settled=True):
    return scene(problem_of(data, None).problem, data, settled)


def with_path(path, **changes):
    return {"arm": {"kind": "planar", "links": [30, 30, 20]}, "path": path, **changes}


def test_points_are_the_paths_and_close_together_at_breaks():
    corner = with_path({"kind": "waypoints", "points": [[50, 0], [60, 30], [20, 30]]})
    found, path = seen(corner)["path"], problem_of(corner, None).problem.path
    r, x = unpacked("r", found["r"]), unpacked("x", found["x"])
    np.testing.assert_array_equal(x, path(r))
    assert found["length"] == pytest.approx(np.hypot(10, 30) + 40)
    assert 400 <= len(r) <= 410
    (corner_r,) = path.breaks
    assert corner_r in r
    assert np.sort(np.abs(r - corner_r))[2] < 2e-4
    assert not found["closed"]
    assert seen(BY_NAME["circle-4r"])["path"]["closed"]


@pytest.mark.parametrize(
    ("path", "handles"),
    [
        ({"kind": "line", "start": [60, 0], "end": [20, 45]}, [[60, 0], [20, 45]]),
        (BY_NAME["seed-3r"]["path"], BY_NAME["seed-3r"]["path"]["control_points"]),
        ({"kind": "waypoints", "points": [[50, 0], [60, 30], [20, 30]]}, [[50, 0], [60, 30], [20, 30]]),
        ({"kind": "waypoints", "points": [[50, k / 10] for k in range(61)]}, None),
        ({"kind": "circle", "center": [40, 10], "radius": 5}, None),
        ({"kind": "transformed", "path": {"kind": "line", "start": [60, 0], "end": [20, 45]}}, None),
    ],
)
def test_handles_are_the_points_of_the_file(path, handles):
    assert seen(with_path(path))["path"]["handles"] == handles


def test_circles_of_reach_are_those_of_the_paper():
    found = seen(BY_NAME["seed-3r"])["reach"]
    radii = problem_of(BY_NAME["seed-3r"], None).problem.arm.radii()
    assert (found["inner"], found["outer"]) == (0.0, 80.0)
    by_radius = {circle["radius"]: circle["name"] for circle in found["circles"]}
    assert by_radius[80.0] == "R_max (9) = 80"
    assert by_radius[radii.nearest].startswith("R*_min (10)")
    assert by_radius[radii.coregular[1]] == "co-regular ρ2 = co-regular ρ3 = 20"
    assert seen(BY_NAME["circle-4r"])["reach"]["circles"] == []


def test_a_kept_direction_moves_the_reach():
    data = with_path({"kind": "line", "start": [40, 10], "end": [30, 20]})
    data["arm"] = {"kind": "planar", "links": [30, 30, 20, 10], "direction": 0.5}
    found = seen(data)
    np.testing.assert_allclose(found["reach"]["center"], [10 * np.cos(0.5), 10 * np.sin(0.5)])
    assert found["direction"] == 0.5
    assert found["n_u"] == 1


@pytest.mark.parametrize("settled", [True, False])
def test_what_is_blocked_is_said_in_words(settled):
    found = seen(with_path({"kind": "line", "start": [60, 0], "end": [100, 0]}), settled)["blocked"]
    (part,) = found
    np.testing.assert_allclose(part["r"], [0.5, 1.0], atol=1e-9)
    assert part["cause"] == "out of reach"
    assert part["text"] == "out of reach by up to 20 for r from 0.5 to 1"
    limited = with_path({"kind": "line", "start": [60, 0], "end": [5, 0]})
    limited["arm"]["limits"] = [None, [-1.0, 1.0], [-1.0, 1.0]]
    problem = problem_of(limited, None).problem
    (part,) = seen(limited, settled)["blocked"]
    assert part["cause"] == "joint limits"
    domain = sm.angle_domain(problem.arm, problem.path)
    begins, ends = part["r"]
    assert 0 < begins < ends == 1
    for r, empty in ((begins - 1e-3, False), (begins + 1e-3, True), (1.0, True)):
        assert (max(domain(r, 0).measure, domain(r, 1).measure) == 0) == empty


def test_limits_names_and_what_is_asked_are_told():
    data = {**BY_NAME["seed-3r"], "elbow": "positive", "start": {"u": [0.3]}, "objective": "l2", "samples": 321}
    found = seen(data)
    assert found["limits"] == [[None, None], [0.0, np.pi], [None, None]]
    assert found["joints"] == ["θ1", "θ2", "θ3"]
    assert (found["branches"], found["allowed"]) == (["positive", "negative"], [0])
    assert (found["start"], found["samples"], found["objective"]) == ([0.3], 321, "l2")
    assert (found["unit"], found["length_unit"], found["dimension"]) == ("rad", None, 2)
    assert "‖w θ′‖" in found["objective_name"]


def test_doubts_about_units_are_passed_on():
    data = {**BY_NAME["seed-3r"], "arm": {"kind": "planar", "links": [30, 30, 20], "limits": [None, [0, 180], None]}}
    (warning,) = seen(data)["warnings"]
    assert "degrees" in warning


def test_an_arm_in_space_has_its_own_joints_and_no_circles():
    found = seen(BY_NAME["panda-circle"], settled=False)
    assert (found["dimension"], found["n"], found["length_unit"], found["reach"]) == (3, 7, "m", None)
    assert found["joints"][0] == "panda_joint1"
    assert unpacked("x", found["path"]["x"]).shape[1] == 3
    assert len(found["branches"]) == len(found["allowed"])

"""What a problem asks beyond joint limits, in problem files, plan files and studies."""

import json

import numpy as np
import pytest

import selfmotion as sm
from selfmotion.constrained import constraints_of
from selfmotion.exchange import load_problem
from selfmotion.exchange.plan_file import plan_bytes, plan_from_text
from selfmotion.exchange.plan_parts import problem_from_object, problem_object
from selfmotion.study.specification import read_study
from selfmotion.study.tasks import plan as planned

THICK = {"kind": "planar", "links": [30, 30, 20], "limits": [None, [0, np.pi], None], "thickness": [2, 1.5, 0.1]}
ASKED = {
    "obstacles": [
        {"name": "post", "circle": {"center": [28.1, -22.3], "radius": 4}},
        {"polygon": [[-20, 20], [-10, 20], [-10, 24.7], [-16, 24], [-16, 30], [-20, 30]]},
        {"half_plane": {"point": [0, -65], "normal": [0.1, 1]}},
    ],
    "clearance": 0.1,
    "self_collision": True,
    "least_singular_value": 0.01,
}
R = np.linspace(0, 1, 301)
"""Path parameters at which motions are compared."""


@pytest.fixture
def case(seed_file):
    return load_problem(seed_file(arm=THICK, samples=200, **ASKED)).problem


def through_json(problem):
    return problem_from_object(json.loads(json.dumps(problem_object(problem), default=lambda array: array.tolist())))


def test_a_problem_file_is_read_whole(case):
    assert case.arm.thickness.tolist() == [2, 1.5, 0.1]
    assert [obstacle.kind for obstacle in case.scene.obstacles] == ["circle", "polygon", "half_plane"]
    assert (case.scene.clearance, case.scene.self_collision, case.least_singular_value) == (0.1, True, 0.01)
    assert [constraint.check for constraint in constraints_of(case.arm)] == ["clearance", "singularity"]


def test_problems_come_back_to_the_bit(case):
    again = through_json(case)
    assert again.arm.thickness.tolist() == case.arm.thickness.tolist()
    q = np.random.default_rng(0).uniform(-3, 3, (200, 3))
    for one, other in zip(constraints_of(case.arm), constraints_of(again.arm), strict=True):
        assert (one.margins(q) == other.margins(q)).all()
        assert [one.cause(k) for k in range(one.margins(q).shape[1])] == [
            other.cause(k) for k in range(other.margins(q).shape[1])
        ]
    assert problem_object(again)["obstacles"] == problem_object(case)["obstacles"]


def test_clearance_and_thickness_alone_come_back(seed_file):
    case = load_problem(seed_file(arm=THICK, clearance=0.25)).problem
    again = through_json(case)
    assert again.scene.clearance == 0.25
    assert again.arm.thickness.tolist() == case.arm.thickness.tolist()
    assert not constraints_of(case.arm)


def test_a_plain_problem_s_file_is_as_before(seed_problem):
    data = problem_object(seed_problem)
    assert set(data) == {"arm", "path", "start", "end", "elbow", "cyclic", "weights", "objective", "samples"}
    assert "thickness" not in data["arm"]
    again = through_json(seed_problem)
    assert again.scene is None
    assert again.least_singular_value is None


def test_the_arm_of_a_problem_takes_its_constraints_along(case):
    other = sm.Problem(case.arm, case.path, samples=100)
    assert other.scene is case.scene
    assert other.least_singular_value == 0.01
    assert problem_object(other)["obstacles"] == problem_object(case)["obstacles"]
    with pytest.raises(sm.InvalidInputError, match="has constraints of its own"):
        sm.Problem(case.arm, case.path, self_collision=True)


def test_a_plan_comes_back_equal(case):
    plan = sm.plan(case, sm.Global(gap=0.05))
    again = plan_from_text(plan_bytes(plan).decode())
    assert (again(R) == plan(R)).all()
    assert again.cost == plan.cost
    assert again.verification == plan.verification
    assert plan_bytes(again) == plan_bytes(plan)


def test_a_plan_in_space_comes_back_equal():
    line = sm.PosePath(sm.Line([0.45, -0.1, 0.4], [0.5, 0.1, 0.45]), orientation=[0, 1, 0, 0])
    crate = sm.BoxObstacle([0.5, 0.4, 0.4], [0.1, 0.3, 0.2], [0.1, 0.2, 0.3], name="crate")
    case = sm.Problem(sm.named_arm("panda"), line, samples=100, obstacles=[crate], self_collision=True)
    plan = sm.plan(case, sm.Global(gap=0.5, time_limit=10))
    again = plan_from_text(plan_bytes(plan).decode())
    assert (again(R) == plan(R)).all()
    assert again.problem.scene.self_collision
    assert again.verification == plan.verification


def test_a_study_s_runs_keep_clear(seed_file, tmp_path):
    planner = {"kind": "global", "gap": 0.05}
    seed_file("case.json", arm=THICK, planner=planner, **ASKED)
    (tmp_path / "study.yaml").write_text("study: clear\nproblems: {files: [case.json]}\n")
    _, (run,), _ = read_study(str(tmp_path / "study.yaml"))
    result = planned(run.specification)
    assert result["status"] == "solved"
    assert result["margins"].keys() == {"clearance", "singularity"}
    assert min(result["margins"].values()) >= -1e-9

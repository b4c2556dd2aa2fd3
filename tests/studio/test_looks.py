"""What is asked at every move of the mouse."""

import json
import time

import numpy as np
import pytest

from selfmotion.errors import InvalidInputError
from selfmotion.studio import problems
from selfmotion.studio.answers import ANSWERS
from selfmotion.studio.cases import CASES
from selfmotion.studio.place import Place
from selfmotion.studio.wire import unpacked

BY_NAME = {case.name: case.problem for case in CASES}
SEED = BY_NAME["seed-3r"]
HAND = {"branch": "positive", "coefficients": [[0.3] * 12]}


def look(problem, folder=None, **more):
    found = ANSWERS["look"]({"problem": problem, **more}, lambda *_: None, Place(folder))
    json.dumps(found, allow_nan=False)
    return found


def test_only_what_is_wanted_is_made():
    assert set(look(SEED, want=["motion"], hand=HAND)) == {"motion"}
    assert look(SEED, want=["motion"])["motion"] is None
    found = look(SEED, want=["scene", "domain", "motion"], frequency=[2.0])
    assert set(found) == {"scene", "domain", "motion"}
    assert found["motion"]["kind"] == "sinusoid"
    assert look(SEED, want=["motion"], hand=HAND, frequency=[2.0])["motion"]["kind"] == "hand"


def test_components_are_varied_about_the_hand_else_about_what_is_given():
    four = BY_NAME["circle-4r"]
    hand = {"branch": "negative", "coefficients": [[0.4] * 8, [-0.7] * 8]}
    by_hand = look(four, want=["domain"], hand=hand)["domain"]
    given = {"r": [0.0, 1.0], "u": [[0.4, -0.7]] * 2, "branch": 1}
    around = look(four, want=["domain"], around=given)["domain"]
    for one, other in zip(by_hand["panels"], around["panels"], strict=True):
        a, b = (unpacked("m", panel["field"]["margin"]) for panel in (one, other))
        np.testing.assert_allclose(a, b, atol=1e-6)
        assert one["branch"] == other["branch"] == 1
    along = look(four, want=["domain"], around={**given, "branch": [1, 1]})["domain"]
    assert along == around
    assert look(four, want=["domain"])["domain"] != around


@pytest.mark.parametrize(
    "around",
    [[], {"r": [0, 1]}, {"r": [1, 0], "u": [[0, 0]] * 2, "branch": 0}, {"r": [0], "u": [[0, 0]], "branch": 7}],
)
def test_what_is_no_curve_to_stand_on_is_refused(around):
    with pytest.raises(InvalidInputError, match="around"):
        look(BY_NAME["circle-4r"], want=["domain"], around=around)


def test_what_was_looked_at_is_remembered_until_a_file_changes(tmp_path):
    file = tmp_path / "points.csv"
    file.write_text("x,y\n50,0\n60,20\n")
    data = {**SEED, "path": {"kind": "file", "file": "points.csv"}}
    folder = str(tmp_path)
    first = problems.problem_of(data, folder)
    assert problems.problem_of(json.loads(json.dumps(data)), folder) is first
    assert problems.problem_of({**data, "samples": 999}, folder) is not first
    file.write_text("x,y\n50,0\n60,25\n")
    again = problems.problem_of(data, folder)
    np.testing.assert_allclose(again.problem.path(1.0), [60, 25])


def test_problems_are_not_confused_by_numbers_that_are_equal_in_python():
    one = problems.problem_of({**SEED, "samples": 1000}, None)
    with pytest.raises(InvalidInputError, match="samples"):
        problems.problem_of({**SEED, "samples": 1000.0}, None)
    assert problems.problem_of({**SEED, "samples": 1000}, None) is one


def test_a_look_is_quick_enough_to_drag_by():
    """Five times what it takes, 12 ms: of the processor's time, of which a busy machine takes nothing away."""
    took = []
    for k in range(12):
        data = {**SEED, "path": {"kind": "line", "start": [60, 0.01 * k], "end": [40, 40]}}
        began = time.process_time()
        look(data, want=["scene", "domain", "motion"], hand=HAND, settled=False)
        took.append(time.process_time() - began)
    assert min(took) < 0.06


def test_a_path_of_very_many_points_is_answered_with_thinned_pictures():
    t = np.linspace(0, 6, 100_001)
    points = np.stack([50 + 10 * np.cos(t) + 0.3 * np.sin(40 * t), 20 + 10 * np.sin(t)], axis=1)
    data = {**SEED, "path": {"kind": "waypoints", "points": points.tolist()}}
    began = time.process_time()
    found = look(data, want=["scene", "domain", "motion"], hand=HAND, settled=False)
    assert time.process_time() - began < 20
    assert len(json.dumps(found)) < 1e6
    assert len(unpacked("r", found["scene"]["path"]["r"])) <= 4000
    assert len(unpacked("r", found["motion"]["r"])) <= 2001
    assert found["scene"]["path"]["length"] == pytest.approx(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())
    assert found["scene"]["path"]["handles"] is None
    assert found["motion"]["holds"]


@pytest.mark.parametrize(
    "problem", [None, [], {}, {"arm": 3, "path": 4}, {"arm": {}, "path": {}}, {**SEED, "smaples": 3}]
)
def test_what_is_no_problem_is_refused(problem):
    with pytest.raises(InvalidInputError):
        look(problem)

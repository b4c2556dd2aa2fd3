"""The examples that the page offers open, and are planned."""

import json

import numpy as np
import pytest

from selfmotion.studio.answers import ANSWERS
from selfmotion.studio.cases import CASES
from selfmotion.studio.place import Place
from selfmotion.studio.wire import unpacked

QUICK = [case for case in CASES if case.name != "panda-circle"]


def ask(task, **payload):
    found = ANSWERS[task](payload, lambda *_: None, Place())
    json.dumps(found, allow_nan=False)
    return found


def test_examples_are_plain_data_that_nobody_shares():
    found = ask("examples")
    assert [(case["name"], case["title"]) for case in found] == [(case.name, case.title) for case in CASES]
    found[0]["problem"]["arm"]["links"][0] = -1
    assert ask("examples")[0]["problem"]["arm"]["links"] == [30, 30, 20]


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_every_example_opens(case):
    found = ask("look", problem=case.problem, want=["scene", "domain"], settled=False)
    assert found["scene"]["blocked"] == []
    assert found["scene"]["warnings"] == []
    if case in QUICK:
        assert found["domain"]["panels"]


@pytest.mark.parametrize("case", QUICK, ids=lambda case: case.name)
def test_every_quick_example_is_planned_and_holds(case):
    found = ask("plan", problem=case.problem)
    assert found["motion"]["holds"]
    assert found["summary"]["status"] == "solved"
    assert len(found["plan"]) > 1000
    assert bool(found["tube"]) == bool(found["verdict"]) == (case.problem["planner"]["kind"] == "global")
    if case.name == "both-elbows":
        assert set(unpacked("branch", found["motion"]["branch"])) == {0.0, 1.0}
    if case.name == "seed-3r":
        best = np.array(found["history"][0]["best"], dtype=float)
        assert (np.diff(best) <= 0).all()
        assert best[-1] == pytest.approx(found["motion"]["cost"], rel=1e-6)

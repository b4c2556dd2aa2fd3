"""Stored plans and result objects are no problem files, and that is said at once, with what reads them."""

import json
import time

import pytest

import selfmotion as sm
from selfmotion.exchange import problem_file
from selfmotion.exchange.problem_file import arm_of
from selfmotion.plans import RESULT_FIELDS

RESULT = {**dict.fromkeys(RESULT_FIELDS), "status": "solved", "cost": 1.0, "planner": "global", "l2_waypoints": 2.0}
PLAN = {"selfmotion_plan": 1, "version": "0.1", "problem": {"samples": list(range(300))}}


@pytest.fixture(autouse=True)
def no_yaml(monkeypatch):
    """The YAML reader takes seconds for a plan."""

    def parse(*_):
        raise AssertionError("was read as YAML")

    monkeypatch.setattr(problem_file, "parse_yaml", parse)


@pytest.mark.parametrize("read", [sm.load_problem, arm_of])
@pytest.mark.parametrize(
    "text", [json.dumps(PLAN), json.dumps(PLAN)[:-100], json.dumps(dict(reversed(PLAN.items())), indent=1)]
)
def test_a_stored_plan_is_no_problem_file(read, text, tmp_path):
    file = tmp_path / "stored.json"
    file.write_text(text)
    with pytest.raises(sm.InvalidInputError, match=r"stored.json: is a stored plan.*time and sm.load_plan read it"):
        read(str(file))


@pytest.mark.parametrize("read", [sm.load_problem, arm_of, sm.load_plan])
def test_the_result_object_of_a_run_is_neither_problem_nor_plan(read, tmp_path):
    file = tmp_path / "plan.json"
    file.write_text(json.dumps(RESULT, indent=1))
    with pytest.raises(
        sm.InvalidInputError, match=r"plan.json: is the result object of a run.*plan --save FILE stores"
    ):
        read(str(file))


def test_what_a_large_plan_is_shows_at_once(tmp_path):
    file = tmp_path / "stored.json"
    file.write_text(json.dumps({**PLAN, "tube": [0.1] * 2_000_000}))
    begin = time.perf_counter()
    with pytest.raises(sm.InvalidInputError, match="stored plan"):
        sm.load_problem(file)
    assert time.perf_counter() - begin < 1.0

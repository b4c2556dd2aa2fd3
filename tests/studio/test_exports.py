"""What is taken away is what was seen."""

import base64
import io
import json

import numpy as np
import pytest
from PIL import Image

from selfmotion import load_plan
from selfmotion.errors import InvalidInputError
from selfmotion.exchange import read_trajectory
from selfmotion.exchange.plan_file import plan_bytes
from selfmotion.studio.answers import ANSWERS
from selfmotion.studio.cases import CASES
from selfmotion.studio.hand import hand_of
from selfmotion.studio.motions import curve_object
from selfmotion.studio.place import Place
from selfmotion.studio.problems import problem_of

SEED = CASES[0].problem
HAND = {"branch": "positive", "coefficients": [[0.3, 0.3, 0.35, 0.4, 0.4, 0.35, 0.3, 0.2, 0.2]]}


def export(form, **what):
    found = ANSWERS["export"]({"format": form, "problem": SEED, **what}, lambda *_: None, Place())
    return found, base64.b64decode(found["data"])


def told():
    problem = problem_of(SEED, None).problem
    return curve_object(problem, hand_of(problem.arm, HAND), "hand")


def test_a_plan_of_a_motion_by_hand_loads_and_costs_the_same(tmp_path):
    found, data = export("plan", hand=HAND)
    (tmp_path / found["name"]).write_bytes(data)
    plan = load_plan(tmp_path / found["name"])
    assert plan.cost == told()["cost"]
    assert plan.verification.holds
    assert plan.planner == "hand"


def test_a_trajectory_reads_back_and_costs_the_same(tmp_path):
    found, data = export("csv", hand=HAND)
    (tmp_path / found["name"]).write_bytes(data)
    motion = read_trajectory(tmp_path / found["name"], 3)
    problem = problem_of(SEED, None).problem
    assert float(problem.objective.sampled(motion.q, motion.r, problem.weights)) == told()["cost_sampled"]
    np.testing.assert_allclose(problem.arm.forward(motion.q), problem.path(motion.r), atol=1e-9)


def test_a_plan_comes_out_as_it_went_in(seed_plan, tmp_path):
    text = plan_bytes(seed_plan).decode()
    (tmp_path / "plan.json").write_bytes(export("plan", plan=text)[1])
    again = load_plan(tmp_path / "plan.json")
    r = np.linspace(0, 1, 99)
    np.testing.assert_array_equal(again(r), seed_plan(r))
    summary = json.loads(export("json", plan=text)[1])
    assert summary["cost"] == seed_plan.cost
    assert summary["status"] == "solved"
    (tmp_path / "t.csv").write_bytes(export("csv", plan=text)[1])
    np.testing.assert_array_equal(read_trajectory(tmp_path / "t.csv", 3).q, seed_plan(seed_plan.problem.rows))


def test_pictures_are_pictures(seed_plan):
    found, data = export("png", plan=plan_bytes(seed_plan).decode())
    assert found["type"] == "image/png"
    with Image.open(io.BytesIO(data)) as picture:
        assert picture.width > 2 * picture.height
        assert len(picture.convert("RGB").getcolors(1 << 24)) > 50


def test_an_animation_moves(seed_plan):
    found, data = export("gif", plan=plan_bytes(seed_plan).decode())
    assert found["name"].endswith(".gif")
    with Image.open(io.BytesIO(data)) as picture:
        assert picture.n_frames == 150


def test_a_motion_that_does_not_hold_is_not_exported():
    bad = {"branch": "positive", "coefficients": [[0.3, 0.3, 3.0, 3.0, 3.0, 3.0, 0.3, 0.3]]}
    with pytest.raises(InvalidInputError, match=r"does not hold: .* at r") as found:
        export("csv", hand=bad)
    assert found.value.field == "hand"


@pytest.mark.parametrize(
    ("form", "what", "field"),
    [("pdf", {"hand": HAND}, "format"), ("csv", {}, "plan"), ("csv", {"plan": 3}, "plan"), ("csv", {"plan": "{}"}, "")],
)
def test_what_cannot_be_exported_is_refused(form, what, field):
    with pytest.raises(InvalidInputError) as found:
        export(form, **what)
    assert found.value.field == field


def forged(plan, change):
    """A plan file that somebody has changed, checksum and all."""
    from selfmotion.exchange.plan_file import _checksum

    data = json.loads(plan_bytes(plan))
    data.pop("checksum")
    change(data)
    return json.dumps({**data, "checksum": _checksum(data)})


def test_a_forged_plan_cannot_have_files_read(seed_plan, tmp_path):
    secret = tmp_path / "secret.csv"
    secret.write_text("x,y\n50,-10\n70,-10\n")
    path = {"kind": "file", "file": str(secret)}
    for change in (
        lambda data: data["problem"].update(path=path),
        lambda data: data["problem"].update(path={"kind": "section", "path": path, "r_range": [0.0, 1.0]}),
        lambda data: data["problem"].update(arm={"kind": "urdf", "file": str(secret)}),
        lambda data: data["motion"].update(curve={"kind": "modules", "moving_bases": [path], "motions": []}),
    ):
        with pytest.raises(InvalidInputError, match="names a file"):
            export("csv", plan=forged(seed_plan, change))

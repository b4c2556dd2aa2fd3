"""Obstacles on the command line: what is refused, what is impossible, and that no command passes over them."""

import json
import re

import numpy as np
import pytest

import selfmotion as sm
from selfmotion.exchange import load_plan

THICK = {"kind": "planar", "links": [30, 30, 20], "limits": [None, [0, np.pi], None], "thickness": 2}
PANDA = {"kind": "named", "name": "panda"}
LINE = {
    "kind": "pose",
    "position": {"kind": "line", "start": [0.45, -0.1, 0.4], "end": [0.5, 0.1, 0.45]},
    "orientation": [0, 1, 0, 0],
}
SEED_POINTS = [[50, -10], [85, 30], [50, 50], [60, -10], [58, 30], [70, -10]]
BOWTIE = {"polygon": [[0, 40], [10, 50], [10, 40], [0, 50]]}
FAST = {"kind": "global", "gap": 0.05, "time_limit": 30}
POST = {"name": "post", "circle": {"center": [28, -22], "radius": 4}}
ON_PATH = {"name": "post", "circle": {"center": [62, 15], "radius": 5}}


@pytest.fixture
def scene_file(seed_file):
    """A problem file of the seed's arm with thick links among obstacles."""

    def write(**changes):
        return seed_file(**{"arm": THICK, "planner": FAST, "obstacles": [POST], "clearance": 1, **changes})

    return write


@pytest.fixture
def free_rows(scene_file, run, tmp_path):
    """The shortest motion as if there were nothing in its way, 200 rows of it, as a file."""
    free = sm.Problem(sm.PlanarArm([30, 30, 20], [None, (0, np.pi), None]), sm.Bezier(SEED_POINTS), samples=200)
    plan = sm.plan(free, sm.Global(gap=0.05))
    file = tmp_path / "free.csv"
    table = np.column_stack([free.grid, plan(free.grid)])
    np.savetxt(file, table, delimiter=",", header="r,q1,q2,q3", comments="", fmt="%.17g")
    return str(file)


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"obstacles": [BOWTIE]}, r"obstacles\.0\.polygon: meets itself: .*\(5, 45\)"),
        ({"obstacles": [{"polygon": [[0, 40], [10, 50]]}]}, r"obstacles\.0\.polygon: "),
        ({"obstacles": [{"cylinder": {"center": [0, 1]}}]}, r"\.0\.cylinder: is not known .*choose one of circle"),
        ({"obstacles": [{"circle": {"center": [20, 30]}}]}, r"obstacles\.0\.circle\.radius: is missing"),
        ({"obstacles": [{"circle": {"center": [20, 30], "radius": -5}}]}, r"obstacles\.0\.circle\.radius: "),
        ({"obstacles": [POST, {"name": "no kind"}]}, r"obstacles\.1: says no kind"),
        ({"obstacles": [{"sphere": {"center": [20, 30, 0], "radius": 5}}]}, r"obstacles\.0: is a sphere of space"),
        ({"arm": PANDA, "path": LINE, "obstacles": [POST]}, r"obstacles\.0: is a circle of the plane"),
        ({"clearance": -1}, r"clearance: must not be negative"),
        ({"clearance": "1 mm"}, r"clearance: is not a number"),
        ({"self_collision": "yes"}, r"self_collision: is neither true nor false"),
        ({"least_singular_value": 0}, r"least_singular_value: must be greater than zero"),
        ({"arm": {**THICK, "thickness": -1}}, r"arm\.thickness: must not be negative"),
        ({"arm": {**THICK, "thickness": [1, 2]}}, r"arm\.thickness: has shape"),
        ({"start": {"u": [0.3]}}, r"start\.u: .* clearance .*link 2 against obstacle 1 \(post\) lacks .*u may lie in"),
    ],
)  # fmt: skip
def test_bad_input_is_one_line_that_names_the_field(run, scene_file, changes, says):
    code, text, err = run("plan", scene_file(**changes))
    assert code == 2
    assert not text
    assert err.count("\n") == 1
    assert re.search(says, err), err


def test_an_arm_without_shapes_of_links_is_refused(run, scene_file, tmp_path):
    file = tmp_path / "bare.urdf"
    sm.save_urdf(sm.named_arm("panda"), file)
    file.write_text(re.sub(r"<collision>.*?</collision>", "", file.read_text(), flags=re.DOTALL))
    arm = {"kind": "urdf", "file": "bare.urdf"}
    ball = {"sphere": {"center": [0, 1, 0], "radius": 0.1}}
    code, _, err = run("plan", scene_file(arm=arm, path=LINE, obstacles=[ball], clearance=0))
    assert code == 2
    assert "arm: has no links with a shape" in err


@pytest.mark.parametrize("planner", ["sinusoid", "global", "refine"])
def test_an_obstacle_on_the_path_is_infeasible_and_says_where_and_what(run, scene_file, planner):
    kinds = {"sinusoid": {}, "global": {"planner": FAST}, "refine": {"planner": {"kind": "refine"}}}
    file = scene_file(obstacles=[ON_PATH], **kinds[planner])
    code, text, err = run("plan", file, "--json")
    assert code == 3
    assert "link 3 against obstacle 1 (post)" in err
    (part, *_) = json.loads(text)["blocked"]
    assert part["cause"] == "obstacles"
    assert "link 3 against obstacle 1 (post)" in part["limits"]
    assert 0.0 < part["r"][0] < part["r"][1] < 1.0


def test_a_tool_inside_an_obstacle_at_the_start_is_infeasible_there(run, scene_file):
    clamp = {"name": "clamp", "circle": {"center": [50, -10], "radius": 3}}
    code, text, err = run("plan", scene_file(obstacles=[clamp], start={"u": [0.3]}), "--json")
    assert code == 3
    assert "obstacle 1 (clamp)" in err
    assert json.loads(text)["blocked"][0]["r"][0] == 0.0


def test_obstacles_in_another_unit_are_a_warning(run, scene_file):
    box = {"box": {"center": [0, 200, 700], "size": [250, 250, 250]}}
    file = scene_file(arm=PANDA, path=LINE, obstacles=[box], clearance=0, planner={"kind": "global", "gap": 0.5})
    code, text, err = run("plan", file, "--json")
    assert code == 0
    assert "no obstacle is in reach" in err
    assert "no obstacle is in reach" in json.loads(text)["warnings"][0]


def test_a_clearance_from_nothing_is_a_warning(run, scene_file):
    code, _, err = run("plan", scene_file(obstacles=[]))
    assert code == 0
    assert "no obstacle is given" in err


@pytest.mark.parametrize("name", ["post $\\frac{a$", "$a_{$", "a bracket that the welder of the night shift left " * 3])
def test_names_are_drawn_letter_by_letter(run, scene_file, tmp_path, name, recwarn):
    """Not as formulas, which most are none of, and no longer than there is room."""
    out = tmp_path / "out"
    code, _, err = run("plan", scene_file(obstacles=[{**POST, "name": name}]), "--out", str(out))
    assert code == 0, err
    assert (out / "postures.png").exists()
    assert not [warning for warning in recwarn if "layout" in str(warning.message)]


def test_a_plan_keeps_clear_and_says_so_and_so_does_its_file(run, scene_file, tmp_path):
    stored = str(tmp_path / "plan.json")
    code, text, err = run("plan", scene_file(), "--save", stored)
    assert code == 0, err
    assert "left beyond what is asked for: clearance " in text
    plan = load_plan(stored)
    assert plan.verification.holds
    assert plan.problem.scene.clearance == 1
    assert plan.verification.margins["clearance"] >= 0.0
    out = str(tmp_path / "motion.csv")
    pytest.importorskip("toppra")
    assert run("time", stored, "--max-acceleration", "10", "--out", out)[0] == 0


def test_verify_reports_clearance(run, scene_file, free_rows):
    file = scene_file()
    code, text, _ = run("verify", file, free_rows)
    assert code == 1
    assert re.search(r"clearance \(link 2 against obstacle 1 \(post\)\) at r = .*, data row \d+: -", text)
    code, text, _ = run("verify", file, free_rows, "--json")
    result = json.loads(text)
    assert code == 1
    assert result["margins"]["clearance"] < -1
    assert result["failures"][0]["cause"] == "link 2 against obstacle 1 (post)"
    away = scene_file(obstacles=[{"circle": {"center": [-50, 0], "radius": 4}}])
    code, text, _ = run("verify", away, free_rows, "--no-optimum")
    assert code == 0
    assert "left beyond what is asked for: clearance 44" in text


def test_repair_leads_round_obstacles(run, scene_file, free_rows, tmp_path):
    file, out = scene_file(), tmp_path / "out"
    code, text, err = run("repair", file, free_rows, "--out", str(out))
    assert code == 0, err
    assert "data row 1, r = 0: link 2 against obstacle 1 (post) lacks" in text
    assert json.loads((out / "repair.json").read_text())["margins"]["clearance"] >= -1e-7
    assert run("verify", file, str(out / "repaired.csv"), "--no-optimum")[0] == 0


def test_compare_has_no_ladder_through_obstacles(run, scene_file, free_rows):
    code, text, err = run("compare", scene_file(), free_rows, "--ladder", "40", "--json")
    assert code == 0, err
    ours, ladder, theirs = json.loads(text)["motions"]
    assert ours["holds"]
    assert not theirs["holds"]
    assert "link 2 against obstacle 1 (post)" in theirs["why_not"]
    assert theirs["gap"] is None
    assert ladder["holds"] or "link 2" not in ladder["why_not"]


@pytest.mark.parametrize(
    ("asked", "field"),
    [
        ({}, "obstacles"),
        ({"obstacles": [], "clearance": 0, "self_collision": True}, "self_collision"),
        ({"obstacles": [], "clearance": 0, "least_singular_value": 0.1}, "least_singular_value"),
    ],
)
@pytest.mark.parametrize("kind", ["modules", "moving_base"])
def test_planners_of_modules_refuse_what_they_cannot_keep(run, scene_file, asked, field, kind):
    optimizer = {"kind": "pso", "population": 5, "iterations": 2, "seed": 1}
    more = {
        "modules": {
            "moving_bases": [{"kind": "line", "start": [55, 5], "end": [50, 20]}],
            "offset": [0.4, 0.5],
            "amplitude": [0.1, 0.1],
            "optimizer": {**optimizer, "bounds": [0, 2]},
        },
        "moving_base": {"optimizer": optimizer},
    }
    file = scene_file(
        arm={"kind": "planar", "links": [30, 30, 20, 15, 15, 10], "thickness": 1},
        path={"kind": "line", "start": [75, 10], "end": [70, 30]},
        planner={"kind": kind, **more[kind]},
        **asked,
    )
    code, _, err = run("plan", file)
    assert code == 2
    assert f"{field}: cannot be kept by planners of modules; leave it out, or use planner: refine" in err


def test_urdf_is_of_the_arm_alone(run, scene_file, tmp_path):
    arm = {**THICK, "placement": {"unit": "mm"}}
    texts = []
    for name, changes in (("a", {}), ("b", {"obstacles": [], "clearance": 0})):
        out = tmp_path / f"{name}.urdf"
        code, text, err = run("urdf", scene_file(arm=arm, **changes), "--out", str(out))
        assert code == 0, err
        texts.append((text.replace(str(out), ""), out.read_text()))
    assert texts[0] == texts[1]


def test_the_schema_has_the_fields(run):
    found = json.loads(run("schema")[1])
    assert {"obstacles", "clearance", "self_collision", "least_singular_value"} <= set(found["properties"])
    assert "thickness" in found["$defs"]["arm_planar"]["properties"]
    assert found["properties"]["obstacles"]["items"] == {"$ref": "#/$defs/obstacle"}

"""Problem files: the contract's example, every kind, and every way to get one wrong."""

import json

import jsonschema
import numpy as np
import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

import selfmotion as sm
from selfmotion.exchange import problem_from
from selfmotion.exchange import schema as registry
from selfmotion.exchange.schema import json_schema
from selfmotion.exchange.yaml_text import parse_yaml

CONTRACT = """
arm:   {kind: planar, links: [30, 30, 20], limits: [null, [0, 3.141592653589793], null]}
path:  {kind: bezier, control_points: [[50, -10], [85, 30], [50, 50], [60, -10], [58, 30], [70, -10]]}
start: {u: [0.3]}
elbow: positive
cyclic: false
weights: null
planner: {kind: sinusoid, offset: [0.3], amplitude: [0.4],
          optimizer: {kind: pso, variant: seed, population: 20, iterations: 100, bounds: [0, 15], seed: 1}}
objective: joint_travel
samples: 1000
obstacles: []
"""


def test_the_contract_s_example(tmp_path):
    file = tmp_path / "problem.yaml"
    file.write_text(CONTRACT)
    problem, planner = sm.load_problem(file)
    assert problem.arm.n == 3
    assert problem.elbow == "positive"
    assert problem.start.u[0] == 0.3
    assert planner.optimizer.settings() == {
        "population": 20, "iterations": 100, "bounds": [0.0, 15.0], "seed": 1, "variant": "seed", "walls": "absorb",
    }  # fmt: skip


def test_json_is_yaml(seed_file):
    problem, planner = sm.load_problem(seed_file(samples=123))
    assert problem.samples == 123
    assert planner.optimizer.population == 8


PATHS = {
    "bezier": {"control_points": [[50, 0], [60, 10]]},
    "clothoid": {"center": [60, 0], "scale": 5, "coefficients": [0, -4, 0, 0.33], "t_range": [-4.712, 0]},
    "line": {"start": [50, 0], "end": [60, 0]},
    "arc": {"center": [50, 0], "radius": 5, "start_angle": 0, "sweep": 1},
    "circle": {"center": [50, 0], "radius": 5},
    "ellipse": {"center": [50, 0], "radii": [5, 3]},
    "lissajous": {"center": [50, 0], "radii": [5, 3], "frequencies": [3, 2]},
    "rose": {"center": [50, 0], "radius": 5, "petals": 3},
    "waypoints": {"points": [[50, 0], [60, 0], [60, 5]], "interpolation": "spline"},
    "reversed": {"path": {"kind": "line", "start": [50, 0], "end": [60, 0]}},
    "arc_length": {"path": {"kind": "line", "start": [50, 0], "end": [60, 0]}},
    "concatenation": {"parts": [{"kind": "line", "start": [50, 0], "end": [60, 0]}]},
    "transformed": {"path": {"kind": "line", "start": [5, 0], "end": [6, 0]}, "scale": 10, "translation": [1, 2]},
    "placed": {
        "path": {"kind": "circle", "center": [0, 0], "radius": 5},
        "frame": {"normal": [1, 0, 0], "x_axis": [0, 1, 0]},
    },
    "pose": {"position": {"kind": "line", "start": [1, 0, 0], "end": [1, 1, 0]}, "orientation": [1, 0, 0, 0]},
    "pose_waypoints": {"poses": [[1, 0, 0, 1, 0, 0, 0], [1, 1, 0, 1, 0, 0, 0]], "interpolation": "spline"},
}
IN_SPACE = ("placed", "pose", "pose_waypoints")
ARM = {"kind": "planar", "links": [30, 30, 20]}


@pytest.mark.parametrize("kind", registry.PATHS)
def test_every_path_of_the_registry_can_be_written_down(kind):
    data = {"arm": ARM, "path": {"kind": kind, **PATHS[kind]}}
    jsonschema.validate(data, json_schema())
    if kind in IN_SPACE:
        assert registry.build("path", data["path"]).kind == kind
        with pytest.raises(sm.InvalidInputError, match="path: leaves the plane"):
            problem_from(data)
    else:
        assert problem_from(data).problem.path.kind == kind


POSE_FORMS = {
    "matrix": {"orientation": [[1, 0, 0], [0, -1, 0], [0, 0, -1]]},
    "several": {"orientations": [[1, 0, 0, 0], [0, 1, 0, 0]], "at": [0, 1], "interpolation": "spline"},
    "follow": {"follow": {"axis": "x", "up": [0, 0, -1]}},
}


@pytest.mark.parametrize("name", POSE_FORMS)
def test_every_orientation_can_be_written_down(name):
    path = {"kind": "pose", "position": PATHS["pose"]["position"], **POSE_FORMS[name]}
    moved = {"kind": "placed", "path": path, "frame": {"rpy": [0, 0, 1]}, "tool": {"translation": [0, 0, 0.1]}}
    for data in (path, moved):
        jsonschema.validate({"arm": ARM, "path": data}, json_schema())
        assert registry.build("path", data).dimension == 7


BAD_FORMS = {
    "frame.rotation": {"kind": "placed", "path": {"kind": "line", **PATHS["line"]}, "frame": {"rotation": [1, 0, 0]}},
    "frame.rpy": {"kind": "placed", "path": {"kind": "line", **PATHS["line"]}, "frame": {"rpy": [1, 0]}},
    "follow.up": {"kind": "pose", "position": PATHS["pose"]["position"], "follow": {"axis": "x"}},
    "follow.axis": {"kind": "pose", "position": PATHS["pose"]["position"], "follow": {"axis": "w", "up": [0, 0, 1]}},
    "position.end": {"kind": "pose", "position": {"kind": "line", "start": [0, 0, 0]}, "orientation": [1, 0, 0, 0]},
    "poses.0": {"kind": "pose_waypoints", "poses": [[1, 2, 3], [4, 5, 6]]},
}


@pytest.mark.parametrize("field", BAD_FORMS)
def test_bad_forms_of_poses_name_their_field(field):
    with pytest.raises(sm.InvalidInputError) as caught:
        registry.build("path", BAD_FORMS[field])
    assert caught.value.field == field
    if field == "frame.rotation":
        assert "the fields are translation, quaternion" in caught.value.remedy


@pytest.mark.parametrize("kind", registry.OPTIMIZERS)
def test_every_optimizer_of_the_registry_can_be_written_down(kind):
    planner = {"kind": "sinusoid", "offset": [0.3], "amplitude": [0.4], "optimizer": {"kind": kind, "seed": 3}}
    data = {"arm": ARM, "path": {"kind": "line", **PATHS["line"]}, "planner": planner}
    jsonschema.validate(data, json_schema())
    assert problem_from(data).planner.optimizer.kind == kind


def test_the_global_planner_can_be_written_down_with_or_without_its_fields():
    for fields in ({}, {"gap": 1e-6}, {"time_limit": 5}, {"gap": 1, "time_limit": 0.5}):
        data = {"arm": ARM, "path": {"kind": "line", **PATHS["line"]}, "planner": {"kind": "global", **fields}}
        jsonschema.validate(data, json_schema())
        planner = problem_from(data).planner
        assert isinstance(planner, sm.Global)
        assert (planner.gap, planner.time_limit) == (fields.get("gap", 1e-4), fields.get("time_limit", 60.0))


def test_the_schema_knows_the_fields_of_the_global_planner():
    fields = json_schema()["$defs"]["planner_global"]["properties"]
    assert {name: field.get("default") for name, field in fields.items()} == {
        "kind": None, "gap": 1e-4, "time_limit": 60.0,
    }  # fmt: skip
    for wrong in ({"gap": "1e-4"}, {"time_limit": None}, {"seed": 1}):
        data = {"arm": ARM, "path": {"kind": "line", **PATHS["line"]}, "planner": {"kind": "global", **wrong}}
        with pytest.raises(jsonschema.ValidationError):
            jsonschema.validate(data, json_schema())


def test_direction_belongs_to_the_path_section():
    arm = {"kind": "planar", "links": [7, 7, 4, 1.5]}
    path = {"kind": "circle", "center": [6, 4], "radius": 4, "direction": -1.0}
    assert problem_from({"arm": arm, "path": path}).problem.arm.direction == -1.0
    with pytest.raises(sm.InvalidInputError, match=r"path\.direction"):
        problem_from({"arm": {**arm, "direction": 1.0}, "path": path})
    with pytest.raises(sm.InvalidInputError, match=r"path\.path\.direction"):
        problem_from({"arm": arm, "path": {"kind": "reversed", "path": path}})
    jsonschema.validate({"arm": arm, "path": path}, json_schema())
    assert path["direction"] == -1.0  # what was given is not changed


def test_the_schema_accepts_the_contract_and_refuses_what_lacks_a_path():
    published = json_schema()
    jsonschema.Draft202012Validator.check_schema(published)
    jsonschema.validate(yaml.safe_load(CONTRACT), published)
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate({"arm": ARM}, published)


PLANNER = {"kind": "sinusoid", "offset": [0.3], "amplitude": [0.4], "optimizer": {"kind": "pso"}}
LINE = {"kind": "line", **PATHS["line"]}
BAD = {
    "arm": {"path": LINE},
    "path": {"arm": ARM},
    "arm.links": {"arm": {"kind": "planar"}, "path": LINE},
    "arm.kind": {"arm": {"links": [1, 1, 1]}, "path": LINE},
    "arm.kind (unknown)": {"arm": {"kind": "planer", "links": [1, 1, 1]}, "path": LINE},
    "arm.kind (a list)": {"arm": {"kind": ["planar"], "links": [1, 1, 1]}, "path": LINE},
    "arm.links.1": {"arm": {"kind": "planar", "links": [30, 0, 20]}, "path": LINE},
    "arm.links.2": {"arm": {"kind": "planar", "links": [30, 30, -20]}, "path": LINE},
    "arm.links.0": {"arm": {"kind": "planar", "links": ["30", 30, 20]}, "path": LINE},
    "arm.links.0 (boolean)": {"arm": {"kind": "planar", "links": [True, 30, 20]}, "path": LINE},
    "arm.links.0 (NaN)": {"arm": {"kind": "planar", "links": [float("nan"), 30, 20]}, "path": LINE},
    "arm.links.0 (infinite)": {"arm": {"kind": "planar", "links": [float("inf"), 30, 20]}, "path": LINE},
    "arm.links (huge)": {"arm": {"kind": "planar", "links": [1e300, 30, 20]}, "path": LINE},
    "arm.links.0 (an enormous integer)": {"arm": {"kind": "planar", "links": [10**400, 30, 20]}, "path": LINE},
    "arm.limits.1": {"arm": {**ARM, "limits": [None, [3, 0], None]}, "path": LINE},
    "arm.limits": {"arm": {**ARM, "limits": [None, [0, 3]]}, "path": LINE},
    "arm.speed": {"arm": {**ARM, "speed": 3}, "path": LINE},
    "path.control_points": {"arm": ARM, "path": {"kind": "bezier", "control_points": [[50, 0]]}},
    "path.control_points.0": {"arm": ARM, "path": {"kind": "bezier", "control_points": [[50], [60, 0]]}},
    "path.control_points.1.0": {"arm": ARM, "path": {"kind": "bezier", "control_points": [[50, 0], [None, 0]]}},
    "path (out of reach)": {"arm": ARM, "path": {"kind": "line", "start": [500, 0], "end": [600, 0]}},
    "path.kind": {"arm": ARM, "path": {"kind": "Line", **PATHS["line"]}},
    "path.radius": {"arm": ARM, "path": {"kind": "circle", "center": [50, 0], "radius": 0}},
    "path.path.start": {"arm": ARM, "path": {"kind": "reversed", "path": {"kind": "line", "end": [60, 0]}}},
    "path.parts.1.end": {
        "arm": ARM,
        "path": {"kind": "concatenation", "parts": [LINE, {"kind": "line", "start": [0, 0]}]},
    },
    "planner.kind": {"arm": ARM, "path": LINE, "planner": {"kind": "magic"}},
    "planner.amplitude": {"arm": ARM, "path": LINE, "planner": {"kind": "sinusoid", "optimizer": {"kind": "pso"}}},
    "planner.optimizer.kind": {"arm": ARM, "path": LINE, "planner": {**PLANNER, "optimizer": {"kind": "psoo"}}},
    "planner.optimizer.seed": {
        "arm": ARM,
        "path": LINE,
        "planner": {**PLANNER, "optimizer": {"kind": "ga", "seed": -1}},
    },
    "planner.optimizer.bounds": {
        "arm": ARM,
        "path": LINE,
        "planner": {**PLANNER, "optimizer": {"kind": "ga", "bounds": [5, 1]}},
    },
    "planner.optimizer.population": {
        "arm": ARM,
        "path": LINE,
        "planner": {**PLANNER, "optimizer": {"kind": "ga", "population": 2.5}},
    },
    "planner.optimizer.swarm": {
        "arm": ARM,
        "path": LINE,
        "planner": {**PLANNER, "optimizer": {"kind": "ga", "swarm": 2}},
    },
    "planner.gap": {"arm": ARM, "path": LINE, "planner": {"kind": "global", "gap": 0.0}},
    "planner.gap (above 1)": {"arm": ARM, "path": LINE, "planner": {"kind": "global", "gap": 2}},
    "planner.gap (text)": {"arm": ARM, "path": LINE, "planner": {"kind": "global", "gap": "1e-4"}},
    "planner.time_limit": {"arm": ARM, "path": LINE, "planner": {"kind": "global", "time_limit": -1}},
    "planner.time_limit (null)": {"arm": ARM, "path": LINE, "planner": {"kind": "global", "time_limit": None}},
    "planner.seed": {"arm": ARM, "path": LINE, "planner": {"kind": "global", "seed": 1}},
    "samples": {"arm": ARM, "path": LINE, "samples": 10**30},
    "samples (text)": {"arm": ARM, "path": LINE, "samples": "1000"},
    "objective": {"arm": ARM, "path": LINE, "objective": "fast"},
    "elbow": {"arm": ARM, "path": LINE, "elbow": "up"},
    "weights": {"arm": ARM, "path": LINE, "weights": [1, 2]},
    "start": {"arm": ARM, "path": LINE, "start": {}},
    "start.v": {"arm": ARM, "path": LINE, "start": {"v": [1]}},
    "obstacles": {"arm": ARM, "path": LINE, "obstacles": {"circle": {"center": [0, 0], "radius": 1}}},
    "obstacles.0": {"arm": ARM, "path": LINE, "obstacles": ["wall"]},
    "obstacles.0.circle.center": {"arm": ARM, "path": LINE, "obstacles": [{"circle": {}}]},
    "obstacles.1.polygon": {
        "arm": ARM,
        "path": LINE,
        "obstacles": [{"circle": {"center": [90, 90], "radius": 1}}, {"polygon": [[0, 0], [2, 2], [2, 0], [0, 3]]}],
    },
    "thickness": {"arm": ARM, "path": LINE, "thickness": 1},
    "": [1, 2, 3],
    " (text)": "hello",
    " (nothing)": None,
    "arm (text)": {"arm": "planar", "path": LINE},
    "path (a list)": {"arm": ARM, "path": [1]},
}


@pytest.mark.parametrize("case", BAD)
def test_bad_data_names_its_field_and_a_remedy(case):
    with pytest.raises(sm.InvalidInputError) as caught:
        problem_from(BAD[case])
    assert caught.value.field == case.split(" (")[0].strip()
    assert caught.value.remedy
    assert "\n" not in str(caught.value)
    assert len(str(caught.value)) < 400


def test_a_near_miss_is_suggested():
    with pytest.raises(sm.InvalidInputError, match="did you mean 'planar'"):
        problem_from(BAD["arm.kind (unknown)"])
    with pytest.raises(sm.InvalidInputError, match="did you mean 'samples'"):
        problem_from({"arm": ARM, "path": LINE, "sample": 3})


TEXTS = {
    "code": "!!python/object/apply:os.system ['touch pwned']",
    "code in a field": "arm: !!python/name:os.system\npath: 1",
    "not YAML": "arm: [1, 2",
    "tab": "arm:\n\t- 1",
    "alias": "a: &x [1]\nb: *x",
    "bomb": "a: &a [x,x]\nb: &b [*a,*a]\nc: [*b,*b]",
    "repeated key": "arm: 1\narm: 2",
    "two documents": "a: 1\n---\nb: 2",
    "control character": "a: \x01",
    "deep": "[" * 20_000,
    "merge key": "a: {<<: {b: 1}}",
    "binary tag": "a: !!binary abc=",
    "complex key": "? [1, 2]\n: 3",
    "date": "2020-01-01: 1",
}


@pytest.mark.parametrize("case", TEXTS)
def test_text_that_is_not_plain_data_is_refused(tmp_path, monkeypatch, case):
    monkeypatch.chdir(tmp_path)
    file = tmp_path / "problem.yaml"
    file.write_text(TEXTS[case])
    with pytest.raises(sm.InvalidInputError) as caught:
        sm.load_problem(file)
    assert str(file) in str(caught.value)
    assert "\n" not in str(caught.value)
    assert list(tmp_path.iterdir()) == [file]


def test_the_second_of_two_equal_keys_is_not_taken_silently():
    with pytest.raises(sm.InvalidInputError, match="'arm' appears twice, line 2"):
        parse_yaml("arm: 1\narm: 2", "t")
    assert parse_yaml("arm: {a: 1}\npath: {a: 2}", "t") == {"arm": {"a": 1}, "path": {"a": 2}}


def test_numbers_are_read_as_json_reads_them():
    text = "[1e-4, 1E5, -.5, 1., 0x10, 010, 1_000, yes, no, on, ~, null, true, 12:30, .nan, '1']"
    values = parse_yaml(text, "t")
    assert values[:4] == [1e-4, 1e5, -0.5, 1.0]
    assert values[4:10] == ["0x10", 10, "1_000", "yes", "no", "on"]
    assert values[10:14] == [None, None, True, "12:30"]
    assert np.isnan(values[14])
    assert values[15] == "1"


words = st.text(st.characters(max_codepoint=0xFFFF, exclude_categories=["Cs"]), max_size=8)
numbers = st.integers(-(10**20), 10**20) | st.floats(allow_nan=False, allow_infinity=False)
json_values = st.recursive(
    st.none() | st.booleans() | numbers | words,
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(words, inner, max_size=3),
    max_leaves=8,
)


@given(json_values)
def test_any_json_is_read_back_unchanged(value):
    assert parse_yaml(json.dumps(value, ensure_ascii=True), "t") == value


junk = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5) | st.sampled_from(["planar", "line"]),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=4), inner, max_size=3),
    max_leaves=6,
)


@given(st.data())
def test_junk_anywhere_is_an_input_error_or_a_problem(data):
    """Replace one value of a good problem, at any depth, by junk."""
    good = yaml.safe_load(CONTRACT)
    section = data.draw(st.sampled_from(sorted(good)))
    node, key = good, section
    while isinstance(node[key], dict) and data.draw(st.booleans()):
        node = node[key]
        key = data.draw(st.sampled_from(sorted(node)))
    node[key] = data.draw(junk)
    try:
        problem_from(good)
    except sm.InvalidInputError as error:
        assert "\n" not in str(error)  # noqa: PT017

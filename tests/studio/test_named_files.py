"""Problems name files inside one folder only, however deep the name is, and wherever links lead."""

import os

import pytest

from selfmotion.errors import InvalidInputError
from selfmotion.exchange.named_files import check_inside, is_inside, named_files
from selfmotion.exchange.schema import SECTIONS, hints_of
from selfmotion.scene import OBSTACLES
from selfmotion.studio.answers import ANSWERS
from selfmotion.studio.cases import CASES
from selfmotion.studio.place import Place
from selfmotion.studio.problems import problem_of

LINE = {"kind": "line", "start": [60, 0], "end": [40, 20]}
SEED = CASES[0].problem


def csv(name):
    return {"kind": "file", "file": name}


def problem(path=None, arm=None, planner=None):
    data = {"arm": arm or {"kind": "planar", "links": [30, 30, 20]}, "path": path or LINE}
    return data if planner is None else {**data, "planner": planner}


OPTIMIZER = {"kind": "pso"}


def modules(*paths):
    return {
        "kind": "modules",
        "moving_bases": list(paths),
        "offset": [0, 0],
        "amplitude": [0, 0.1],
        "optimizer": OPTIMIZER,
    }


PLACES = {
    "path.file": lambda name: problem(csv(name)),
    "arm.file": lambda name: problem(arm={"kind": "urdf", "file": name}),
    "path.path.file": lambda name: problem({"kind": "reversed", "path": csv(name)}),
    "path.parts.1.file": lambda name: problem({"kind": "concatenation", "parts": [LINE, csv(name)]}),
    "path.parts.0.path.path.file": lambda name: problem(
        {
            "kind": "concatenation",
            "parts": [{"kind": "placed", "path": {"kind": "arc_length", "path": csv(name)}}, LINE],
        }
    ),
    "path.position.file": lambda name: problem({"kind": "pose", "position": csv(name), "orientation": [1, 0, 0, 0]}),
    "planner.moving_bases.1.file": lambda name: problem(planner=modules(LINE, csv(name))),
    "planner.initial.moving_bases.0.path.file": lambda name: problem(
        planner={"kind": "refine", "initial": modules({"kind": "reversed", "path": csv(name)})}
    ),
    "obstacles.1.mesh.file": lambda name: {
        **problem(),
        "obstacles": [{"sphere": {"center": [0, 0, 0], "radius": 1}}, {"name": "part", "mesh": {"file": name}}],
    },
}
KINDS = {"svg", "dxf", "gcode", "file"}


@pytest.mark.parametrize("field", PLACES)
def test_every_place_that_may_name_a_file_is_found(field):
    (found,) = named_files(PLACES[field]("a.csv"))
    assert found == (field, "a.csv")


@pytest.mark.parametrize("kind", sorted(KINDS))
def test_every_kind_of_file_is_found(kind):
    assert named_files(problem({"kind": kind, "file": "x"})) == [("path.file", "x")]


def test_every_parameter_that_is_a_file_is_found():
    """Whatever kinds there are: each of their parameters whose type says so."""
    seen = 0
    for section in ("arm", "path", "planner"):
        for kind, part in SECTIONS[section].items():
            files = {name for name, hint in hints_of(part).items() if "'file'" in str(hint)}
            given = {"kind": kind, **dict.fromkeys(files, "x.y")}
            assert {field for field, _ in named_files({section: given})} == {f"{section}.{name}" for name in files}
            seen += len(files)
    for kind, part in OBSTACLES.items():
        files = {name for name, hint in hints_of(part).items() if "'file'" in str(hint)}
        found = named_files({"obstacles": [{kind: dict.fromkeys(files, "x.y")}]})
        assert {field for field, _ in found} == {f"obstacles.0.{kind}.{name}" for name in files}
    assert seen >= 5


@pytest.fixture
def folder(tmp_path):
    inner = tmp_path / "chosen"
    inner.mkdir()
    (tmp_path / "chosen-not").mkdir()
    for place in (inner, tmp_path, tmp_path / "chosen-not"):
        (place / "points.csv").write_text("x,y\n50,0\n60,20\n")
    (inner / "deep").mkdir()
    (inner / "deep" / "points.csv").write_text("x,y\n50,0\n60,20\n")
    os.symlink(tmp_path / "points.csv", inner / "link.csv")
    os.symlink(tmp_path, inner / "up")
    os.symlink(inner / "points.csv", inner / "fine.csv")
    os.symlink(inner / "loop", inner / "loop")
    return inner


@pytest.mark.parametrize("name", ["points.csv", "deep/points.csv", "deep/../points.csv", "fine.csv", "./points.csv"])
def test_what_is_inside_is_read(folder, name):
    found = problem_of(problem(csv(name)), str(folder))
    assert found.problem.path(0.0).tolist() == [50.0, 0.0]
    assert is_inside(str(folder / name), str(folder))


@pytest.mark.parametrize("field", PLACES)
@pytest.mark.parametrize(
    "name",
    ["../points.csv", "link.csv", "up/points.csv", "up/chosen-not/points.csv", "../chosen-not/points.csv",
     "deep/../../points.csv", "/etc/passwd", "/dev/zero", "a\0b", "up/nothing.csv"],
)  # fmt: skip
def test_what_is_outside_is_refused_wherever_it_is_named(folder, field, name):
    with pytest.raises(InvalidInputError) as found:
        problem_of(PLACES[field](name), str(folder))
    assert found.value.field == field
    assert "outside of the folder" in found.value.reason


def test_a_link_that_leads_nowhere_is_not_followed(folder):
    with pytest.raises(InvalidInputError):
        problem_of(problem(csv("loop")), str(folder))


def test_the_absolute_name_of_another_folders_file_is_refused(folder):
    with pytest.raises(InvalidInputError, match="outside"):
        check_inside(problem(csv(str(folder.parent / "points.csv"))), str(folder))
    assert check_inside(problem(csv(str(folder / "points.csv"))), str(folder))


def test_without_a_folder_no_file_may_be_named(folder):
    with pytest.raises(InvalidInputError, match="no folder") as found:
        problem_of(problem(csv(str(folder / "points.csv"))), None)
    assert found.value.field == "path.file"


@pytest.mark.parametrize("task", ["look", "plan", "fit", "export"])
def test_no_task_reads_outside(folder, task):
    payload = {"problem": {**SEED, "path": csv("link.csv")}, "want": ["scene"], "branch": "positive"}
    payload |= {"r": [0, 1], "u": [[0.3], [0.3]], "format": "csv"}
    payload["hand"] = {"branch": "positive", "coefficients": [[0.3] * 8]}
    with pytest.raises(InvalidInputError, match="outside of the folder"):
        ANSWERS[task](payload, lambda *_: None, Place(str(folder)))


@pytest.mark.parametrize(
    "data", [None, [], {"path": []}, {"path": {"kind": []}}, {"path": {"kind": "file", "file": 3}},
             {"path": {"kind": "concatenation", "parts": 3}}, {"path": {"kind": "nothing", "file": "x"}}],
)  # fmt: skip
def test_what_is_no_problem_names_no_file(data):
    assert named_files(data) == []

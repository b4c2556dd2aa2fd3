"""Problem files inside the studio's folder, and nothing outside of it."""

import json
import os
import socket

import pytest

from selfmotion.errors import InvalidInputError
from selfmotion.studio.folder import MOST_FILES, Folder, moved
from selfmotion.studio.tasks import TASKS, answer

PROBLEM = {
    "arm": {"kind": "planar", "links": [3, 2, 1]},
    "path": {"kind": "line", "start": [3, 0], "end": [3, 2]},
}
TEXT = json.dumps(PROBLEM)


@pytest.fixture
def place(tmp_path):
    """A folder with a secret beside it."""
    (tmp_path / "secret.yaml").write_text("arm: secret\npath: secret\n")
    (tmp_path / "studio").mkdir()
    (tmp_path / "studio" / "good.yaml").write_text(TEXT)
    return tmp_path / "studio"


@pytest.fixture
def folder(place):
    return Folder.chosen(None, str(place))


def ask(folder, name, **payload):
    return answer(name, payload, folder, lambda done, total, best: None)


def test_problem_files_are_listed_and_nothing_else(place, folder):
    for name in (
        "b.yml",
        "C.JSON",
        "ü <script>.yaml",
        "sub/d.yaml",
        "sub/deeper/e.yaml",
        ".hidden.yaml",
        ".git/f.yaml",
    ):
        (place / name).parent.mkdir(parents=True, exist_ok=True)
        (place / name).write_text(TEXT)
    (place / "notes.txt").write_text(TEXT)
    (place / "package.json").write_text('{"name": "something else"}')
    (place / "plan.json").write_text('{"selfmotion_plan": 1, "arm": 1, "path": 1}')
    (place / "result.json").write_text('{"status": "solved", "arm": 1, "path": 1, "wall_time_s": 1}')
    (place / "folder.yaml").mkdir()
    (place / "out.yaml").symlink_to(place.parent / "secret.yaml")
    (place / "in.yaml").symlink_to(place / "good.yaml")
    (place / "away").symlink_to(place.parent)
    os.mkfifo(place / "pipe.yaml")
    found = ask(folder, "files")
    assert found["files"] == ["b.yml", "C.JSON", "good.yaml", "in.yaml", "ü <script>.yaml", "sub/d.yaml"]
    assert found["folder"] == "studio"
    assert found["may_write"] is True


def test_at_most_500_files_are_listed(place, folder):
    for k in range(MOST_FILES + 20):
        (place / f"{k}.yaml").write_text(TEXT)
    assert len(ask(folder, "files")["files"]) == MOST_FILES


def test_a_folder_that_is_gone_is_empty(place, folder):
    (place / "good.yaml").unlink()
    place.rmdir()
    assert ask(folder, "files")["files"] == []


def test_a_file_is_opened(place, folder):
    assert ask(folder, "open", file="good.yaml") == {"problem": PROBLEM, "text": TEXT}


OUTSIDE = [
    "../secret.yaml", "/etc/passwd.yaml", "sub/../../secret.yaml", "./good.yaml", "out.yaml", "away/secret.yaml",
    "..", "", "/", "good.yaml/", "sub//good.yaml", ".hidden.yaml", "~/.yaml", "a\0.yaml", "a\n.yaml", "..\\secret.yaml",
    "C:good.yaml", "good.yaml:stream.yaml", "//server/share.yaml", "x" * 300 + ".yaml", "x" * 5000 + ".yaml",
    "\ud800.yaml", "con.yaml", "NUL.json", "sub/com1.yaml", "lpt9.tar.yaml", "pipe.yaml",
    "folder.yaml", "socket.yaml",
    "zero.yaml", " good.yaml", "sub /x.yaml", "sub./x.yaml", "a/b/c.yaml", "<script>/../../../secret.yaml",
]  # fmt: skip


@pytest.mark.parametrize("name", OUTSIDE, ids=[ascii(name)[:40] for name in OUTSIDE])
def test_nothing_outside_is_opened_or_written(name, place, folder):
    (place / "out.yaml").symlink_to(place.parent / "secret.yaml")
    (place / "zero.yaml").symlink_to("/dev/zero")
    (place / "away").symlink_to(place.parent)
    (place / "sub").mkdir()
    (place / "folder.yaml").mkdir()
    os.mkfifo(place / "pipe.yaml")
    with socket.socket(socket.AF_UNIX) as unix:
        here = os.open(place, os.O_RDONLY)
        unix.bind(f"/proc/self/fd/{here}/socket.yaml")
        os.close(here)
        before = sorted(os.listdir(place.parent)), sorted(os.listdir(place))
        for task, payload in (("open", {}), ("save", {"problem": PROBLEM, "force": True})):
            with pytest.raises(InvalidInputError) as caught:
                ask(folder, task, file=name, **payload)
            assert caught.value.field == "file"
            assert str(place) not in str(caught.value)
            assert "\n" not in str(caught.value)
    assert (sorted(os.listdir(place.parent)), sorted(os.listdir(place))) == before
    assert (place.parent / "secret.yaml").read_text() == "arm: secret\npath: secret\n"


@pytest.mark.parametrize("name", ["notes.txt", "good", "good.yaml.exe", ".bashrc", "run.py", "x.yaml\0.py"])
def test_only_problem_files_are_written(name, place, folder):
    with pytest.raises(InvalidInputError, match="name of a"):
        ask(folder, "save", file=name, problem=PROBLEM, force=True)
    assert os.listdir(place) == ["good.yaml"]


@pytest.mark.parametrize(
    "name", ["new.yaml", "new.json", "sub/new.yml", "<script>alert(1).yaml", "größe 1.yaml", "'$(x)'.yaml"]
)
def test_a_problem_is_saved_and_reads_back(name, place, folder):
    (place / "sub").mkdir()
    assert ask(folder, "save", file=name, problem=PROBLEM) == {"file": name}
    assert ask(folder, "open", file=name)["problem"] == PROBLEM
    assert name in ask(folder, "files")["files"]
    assert (place / name).read_text().startswith("{") == name.endswith(".json")
    changed = {**PROBLEM, "samples": 7}
    ask(folder, "save", file=name, problem=changed)  # its own file it replaces
    assert ask(folder, "open", file=name)["problem"] == changed


def test_somebody_else_s_file_is_replaced_only_by_force(place, folder):
    with pytest.raises(InvalidInputError, match="not what selfmotion wrote") as caught:
        ask(folder, "save", file="good.yaml", problem=PROBLEM)
    assert caught.value.field == "force"
    assert (place / "good.yaml").read_text() == TEXT
    ask(folder, "save", file="good.yaml", problem=PROBLEM, force=True)
    assert (place / "good.yaml").read_text() != TEXT


def test_a_link_inside_is_followed_and_stays(place, folder):
    (place / "in.yaml").symlink_to(place / "good.yaml")
    ask(folder, "save", file="in.yaml", problem={**PROBLEM, "samples": 9}, force=True)
    assert (place / "in.yaml").is_symlink()
    assert ask(folder, "open", file="good.yaml")["problem"]["samples"] == 9


def test_a_folder_that_cannot_be_written_to_says_so(place, folder, monkeypatch):
    monkeypatch.setattr(os, "access", lambda path, mode: not mode & os.W_OK)
    assert ask(folder, "files")["may_write"] is False
    with pytest.raises(InvalidInputError, match="read-only"):
        ask(folder, "save", file="new.yaml", problem=PROBLEM)
    assert os.listdir(place) == ["good.yaml"]


def test_a_missing_folder_is_not_made(place, folder):
    with pytest.raises(InvalidInputError, match="a folder that is not there"):
        ask(folder, "save", file="absent/new.yaml", problem=PROBLEM)


@pytest.mark.parametrize(("text", "says"), [
    (b"\xff\xfe", "UTF-8"), (b"arm: [", "line 1"), (b"- 1", "mapping"), (b"arm: {kind: planar}", "path"),
    (b'{"selfmotion_plan": 1}', "stored plan"), (b"arm: &a {}\npath: *a", "aliases"),
    (b"arm: !!python/object:os.system {}\npath: {}", "YAML"),
])  # fmt: skip
def test_what_is_no_problem_file_is_said(text, says, place, folder):
    (place / "bad.yaml").write_bytes(text)
    with pytest.raises(InvalidInputError, match=says) as caught:
        ask(folder, "open", file="bad.yaml")
    assert "bad.yaml" in str(caught.value)
    assert str(place) not in str(caught.value)


def test_a_file_that_is_too_large_is_refused(place, folder):
    with open(place / "large.yaml", "wb") as file:
        file.truncate(16_000_001)
    with pytest.raises(InvalidInputError, match="larger"):
        ask(folder, "open", file="large.yaml")


def test_files_that_a_problem_names_keep_their_place(place, folder):
    (place / "sub").mkdir()
    (place / "sub" / "p.csv").write_text("x,y\n3,0\n3,2\n")
    problem = {"arm": PROBLEM["arm"], "path": {"kind": "file", "file": "p.csv"}}
    (place / "sub" / "named.yaml").write_text(json.dumps(problem))
    opened = ask(folder, "open", file="sub/named.yaml")["problem"]
    assert opened["path"]["file"] == "sub/p.csv"
    ask(folder, "save", file="sub/other.yaml", problem=opened)
    assert json.loads((place / "sub" / "named.yaml").read_text()) == problem
    assert "file: p.csv" in (place / "sub" / "other.yaml").read_text()
    ask(folder, "save", file="above.yaml", problem=opened)
    assert "file: sub/p.csv" in (place / "above.yaml").read_text()
    assert moved({"a": [{"file": "../x"}], "file": "/x"}, "s", "") == {"a": [{"file": "x"}], "file": "/x"}


@pytest.mark.parametrize("file", ["../secret.csv", "/etc/passwd", "out.csv", "away/secret.csv", "sub/../../secret.csv"])
@pytest.mark.parametrize("task", ["look", "plan", "fit", "export"])
def test_files_that_a_problem_names_are_inside(file, task, place, folder):
    (place.parent / "secret.csv").write_text("x,y\n3,0\n3,2\n")
    (place / "out.csv").symlink_to(place.parent / "secret.csv")
    (place / "away").symlink_to(place.parent)
    (place / "sub").mkdir()
    hand = {"branch": "positive", "coefficients": [[0.0] * 8]}
    more = {
        "plan": {},
        "look": {"want": ["scene"]},
        "fit": {"r": [0, 1], "u": [[0], [0]], "branch": "positive"},
        "export": {"format": "csv", "hand": hand},
    }[task]
    for field, part in (("path", {"kind": "file"}), ("arm", {"kind": "urdf"})):
        problem = {**PROBLEM, field: {**part, "file": file}}
        with pytest.raises(InvalidInputError, match="outside") as caught:
            ask(folder, task, problem=problem, **more)
        assert caught.value.field == f"{field}.file"


def test_the_folder_is_that_of_the_problem_file_or_the_working_folder(place, monkeypatch):
    monkeypatch.chdir(place.parent)
    assert Folder.chosen(None, None).path == str(place.parent)
    assert Folder.chosen("studio/good.yaml", None).path == str(place)
    assert Folder.chosen("secret.yaml", "studio").path == str(place)
    (place.parent / "link").symlink_to(place)
    assert Folder.chosen("link/good.yaml", None).path == str(place)
    for folder in ("absent", "secret.yaml", "", "a\0"):
        with pytest.raises(InvalidInputError, match="--folder"):
            Folder.chosen(None, folder)
    with pytest.raises(InvalidInputError, match=r"absent/x\.yaml: does not exist"):
        Folder.chosen("absent/x.yaml", None)


@pytest.mark.parametrize("task", TASKS)
def test_an_unknown_field_is_named(task, folder):
    with pytest.raises(InvalidInputError, match="not a known field") as caught:
        ask(folder, task, nonsense=1)
    assert caught.value.field == "nonsense"


@pytest.mark.parametrize(("task", "payload", "field"), [
    ("look", {}, "problem"),
    ("look", {"problem": []}, "problem"),
    ("look", {"problem": {}, "want": "scene"}, "want"),
    ("look", {"problem": {}, "want": ["scene", "all"]}, "want.1"),
    ("look", {"problem": {}, "settled": 1}, "settled"),
    ("look", {"problem": {}, "hand": {"branch": 1, "coefficients": []}}, "hand.branch"),
    ("look", {"problem": {}, "frequency": ["1"]}, "frequency.0"),
    ("plan", {"problem": "x"}, "problem"),
    ("fit", {"problem": {}, "r": "x", "u": [], "branch": "b"}, "r"),
    ("fit", {"problem": {}, "r": [], "u": []}, "branch"),
    ("export", {"problem": {}, "format": "exe"}, "format"),
    ("export", {"problem": {}, "format": "csv", "plan": {}}, "plan"),
    ("read", {"text": 1}, "text"),
    ("write", {"problem": 1}, "problem"),
    ("open", {"file": ["a.yaml"]}, "file"),
    ("save", {"file": "a.yaml", "problem": {}, "force": "yes"}, "force"),
    ("save", {"file": "a.yaml"}, "problem"),
])  # fmt: skip
def test_a_field_of_the_wrong_type_is_named(task, payload, field, folder):
    with pytest.raises(InvalidInputError) as caught:
        ask(folder, task, **payload)
    assert caught.value.field == field

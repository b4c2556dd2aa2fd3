"""``selfmotion reproduce`` as a user types it; the whole run is tested on its function."""

import json

import pytest

from selfmotion.cli import _run
from selfmotion.report import file_names


def test_only_writes_the_figures_named_and_runs_again(tmp_path, capsys):
    out = tmp_path / "out"
    arguments = ["reproduce", "--out", str(out), "--only", "fig10a_path", "--only", "fig12a_joints"]
    assert _run(arguments) == 0
    printed = capsys.readouterr().out.split()
    names = file_names(["fig10a_path", "fig12a_joints"])
    assert printed == [str(out / name) for name in names]
    first = {name: (out / name).read_bytes() for name in names}
    assert {file.name for file in out.iterdir()} == {*names, ".selfmotion.json"}
    assert json.loads(first["fig10a_path.json"])["axes"][0]["lines"]
    assert _run(arguments) == 0
    assert {name: (out / name).read_bytes() for name in names} == first


@pytest.mark.parametrize(
    ("options", "names"),
    [(["--only", "fig99"], "--only 'fig99'"), (["--seeds", "0"], "--seeds"), (["--seed", "-1"], "--seed")],
)
def test_bad_options_are_one_line_and_write_nothing(tmp_path, capsys, options, names):
    out = tmp_path / "out"
    assert _run(["reproduce", "--out", str(out), *options]) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert len(captured.err.splitlines()) == 1
    assert names.split()[0] in captured.err
    assert names.split()[-1] in captured.err
    assert not out.exists()


def test_a_foreign_file_is_refused_before_anything_runs(tmp_path, capsys):
    (tmp_path / "report.html").write_text("mine")
    assert _run(["reproduce", "--out", str(tmp_path)]) == 2
    assert "report.html is not what selfmotion wrote" in capsys.readouterr().err
    assert (tmp_path / "report.html").read_text() == "mine"

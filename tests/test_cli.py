"""The command line as a user and as a script meet it."""

import json
import os
import subprocess
import sys
import time

import numpy as np
import pytest

import selfmotion


def read(out):
    return json.loads(out, parse_constant=lambda name: pytest.fail(f"{name} is not JSON"))


def test_plan_prints_a_verdict(run, seed_file):
    code, out, err = run("plan", seed_file())
    assert code == 0
    assert err == ""
    assert out.startswith("solved: cost 5.")
    assert "positive elbow" in out


def test_plan_as_json_is_one_object(run, seed_file):
    code, out, err = run("plan", seed_file(), "--json")
    assert code == 0
    assert err == ""
    result = read(out)
    assert result["status"] == "solved"
    assert result["parameters"]["optimizer"]["seed"] == 1
    assert result["evaluations"] == 40
    other = read(run("plan", seed_file(), "--json", "--seed", "2")[1])
    assert other["parameters"]["optimizer"]["seed"] == 2
    assert other["cost"] != result["cost"]


def test_plan_writes_its_folder_and_verify_accepts_it(run, seed_file, tmp_path):
    out_dir = tmp_path / "out dir ü"
    problem = seed_file(samples=120)
    assert run("plan", problem, "--out", str(out_dir))[0] == 0
    assert {
        "plan.json",
        "trajectory.csv",
        "motion_in_domain.png",
        "motion_in_domain.svg",
        "joints.png",
        "postures.svg",
    } <= set(os.listdir(out_dir))
    assert read((out_dir / "plan.json").read_text())["status"] == "solved"
    assert run("plan", problem, "--out", str(out_dir))[0] == 0  # its own files it replaces
    code, out, _ = run("verify", problem, str(out_dir / "trajectory.csv"), "--json")
    assert code == 0
    assert read(out)["status"] == "holds"
    table = np.genfromtxt(out_dir / "trajectory.csv", delimiter=",", names=True)
    assert table.dtype.names == ("r", "q1", "q2", "q3", "u1")
    assert len(table) == 120


def test_plan_does_not_touch_a_foreign_file(run, seed_file, tmp_path):
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "trajectory.csv").write_text("mine")
    code, out, err = run("plan", seed_file(), "--out", str(tmp_path / "out"))
    assert code == 2
    assert out == ""
    assert "--force" in err
    assert os.listdir(tmp_path / "out") == ["trajectory.csv"]
    assert run("plan", seed_file(), "--out", str(tmp_path / "out"), "--force")[0] == 0


def test_verify_says_where_and_why(run, seed_file, tmp_path, seed_plan):
    r = np.linspace(0, 1, 300)
    q = seed_plan(r)
    q[150, 0] += 1e-3
    file = tmp_path / "t.csv"
    np.savetxt(file, np.column_stack([r, q]), delimiter=",", header="r,q1,q2,q3", comments="", fmt="%.17g")
    code, out, err = run("verify", seed_file(), str(file), "--json")
    assert code == 1
    assert err == ""
    result = read(out)
    assert result["status"] == "broken"
    assert result["failures"][0]["check"] == "tracking"
    assert result["failures"][0]["row"] == 151
    assert "tracking at r = 0.501672, data row 151" in run("verify", seed_file(), str(file))[1]
    assert run("verify", seed_file(), str(file), "--tolerance", "1e-2")[0] == 0


def test_domain_writes_the_picture_and_its_data(run, seed_file, tmp_path):
    code, out, _ = run("domain", seed_file(samples=50, planner=None), "--out", str(tmp_path / "d"))
    assert code == 0
    assert "positive and negative elbow" in out
    data = read((tmp_path / "d" / "domain.json").read_text())
    assert len(data["r"]) == len(data["u"]["positive"]) == 50
    np.testing.assert_allclose(data["u"]["positive"][0], [[-2.06678, 1.67199]], atol=1e-5)


PARTED = {
    "arm": {"kind": "planar", "links": [1, 1, 1], "limits": [[-1.45, 1.45]] * 3},
    "path": {"kind": "line", "start": [1.5, -2.5], "end": [1.5, 2.5]},
    "samples": 20,
    "planner": None,
}


def test_domain_says_what_happens_along_the_path(run, seed_file, tmp_path):
    code, out, _ = run("domain", seed_file(**PARTED), "--out", str(tmp_path / "d"))
    assert code == 0
    lines = out.splitlines()
    data = read((tmp_path / "d" / "domain.json").read_text())
    assert f"{len(data['events'])} events, 2 connected parts" in lines
    assert sum(line.startswith("r = ") for line in lines) == len(data["events"]) == 38
    assert "radii: R_max = 3 (9), R*_min = 1.73205 (10), co-regular 1, 1, 1" in lines
    assert lines[-1].startswith(
        "a continuous motion from r = 0 to r = 1 exists: no, the last connected part dies at r = "
    )
    assert lines[-1].endswith(f"{data['dead_end']['r']:.10f}, because of upper limit of θ1 and lower limit of θ3")
    assert data["components"] == len({sheet["component"] for sheet in data["sheets"]}) == 2
    assert data["connected"] is False
    for event in data["events"]:
        assert event["branch"] in ("positive", "negative", None)
        assert all(cause["joint"] in (1, 2, 3) for cause in event["causes"] + event["instead_of"])
        assert all(cause["value"] in (-1.45, 1.45) for cause in event["causes"] if cause["kind"] != "fold")
    dying = [event for event in data["events"] if event["kind"] == "component dies"]
    assert max(event["r"] for event in dying) == data["dead_end"]["r"]
    code, out, _ = run("domain", seed_file(**PARTED), "--out", str(tmp_path / "d"), "--json")
    assert code == 0
    assert read(out)["events"] == data["events"]


def test_domain_of_one_elbow_tells_of_that_elbow_only(run, seed_file, tmp_path):
    assert run("domain", seed_file(**PARTED, elbow="positive"), "--out", str(tmp_path / "d"))[0] == 0
    events = read((tmp_path / "d" / "domain.json").read_text())["events"]
    assert {event["branch"] for event in events} == {"positive", None}


def test_domain_prints_forty_events_and_where_the_others_are(run, seed_file, tmp_path):
    limits = [[-0.6, 1.2], [-1.5, 1.5], [-1.5, 1.5]]
    arm = {"kind": "planar", "links": [30, 30, 20], "limits": limits}
    _, out, _ = run("domain", seed_file(arm=arm, samples=20, planner=None), "--out", str(tmp_path / "d"))
    total = len(read((tmp_path / "d" / "domain.json").read_text())["events"])
    assert sum(line.startswith("r = ") for line in out.splitlines()) == 40
    assert f"… and {total - 40} more, see domain.json" in out
    assert out.splitlines()[-1] == "a continuous motion from r = 0 to r = 1 exists: yes"


def test_domain_of_a_path_that_starts_where_nothing_is_feasible(run, seed_file, tmp_path):
    path = {"kind": "line", "start": [90, 0], "end": [50, 10]}
    _, out, _ = run("domain", seed_file(path=path, samples=20, planner=None), "--out", str(tmp_path / "d"))
    assert out.splitlines()[-1].endswith("exists: no, nothing is feasible at r = 0")


def test_a_partly_unreachable_path_is_3_with_the_intervals(run, seed_file):
    arm = {"kind": "planar", "links": [1, 1, 1], "limits": [[-2, 2]] * 3}
    path = {"kind": "line", "start": [1.5, -3], "end": [1.5, 3.5]}
    code, out, err = run("plan", seed_file(arm=arm, path=path), "--json")
    assert code == 3
    result = read(out)
    assert result["status"] == "infeasible"
    assert [part["cause"] for part in result["blocked"]] == ["out of reach"] * 2
    assert result["blocked"][0]["r"][1] == pytest.approx((3 - np.sqrt(6.75)) / 6.5)
    assert err.count("\n") == 1


def test_nothing_feasible_is_4(run, seed_file):
    planner = {"kind": "sinusoid", "offset": [0.3], "amplitude": [3.0]}
    planner["optimizer"] = {"kind": "ga", "population": 4, "iterations": 2, "bounds": [2, 9]}
    code, out, err = run("plan", seed_file(planner=planner), "--json")
    assert code == 4
    assert read(out)["status"] == "unknown"
    assert "angle domain" in err


@pytest.mark.parametrize(("arguments", "names"), [
    (["plan", "absent.yaml"], ["absent.yaml", "does not exist"]),
    (["plan", "."], ["is a folder"]),
    (["plan"], ["Missing argument"]),
    (["plan", "x", "--colour"], ["--colour"]),
    (["frobnicate"], ["frobnicate"]),
    (["verify", "{good}", "absent.csv"], ["absent.csv", "does not exist"]),
    (["verify", "{good}", "{good}", "--max-step", "-1"], ["--max-step"]),
    (["plan", "{good}", "--seed", "-3"], ["seed"]),
    (["plan", "{good}", "--seed", "x"], ["--seed"]),
    (["plan", "{good}", "--out", "{good}"], ["--out", "not a folder"]),
    (["plan", "{no_planner}"], ["planner", "is missing"]),
    (["domain", "{many}", "--out", "d"], ["arm", "redundant degrees"]),
    (["plan", "{binary}"], ["{binary}", "not a UTF-8 text file"]),
    (["plan", "{one_point}"], ["{one_point}", "path.control_points", "at least two"]),
    (["plan", "{units}"], ["path", "units"]),
])  # fmt: skip
@pytest.mark.parametrize("as_json", [False, True])
def test_bad_input_is_2_in_one_line(run, seed_file, tmp_path, monkeypatch, arguments, names, as_json):
    monkeypatch.chdir(tmp_path)
    files = {
        "good": seed_file("good.json"),
        "no_planner": seed_file("no_planner.json", planner=None),
        "many": seed_file("many.json", arm={"kind": "planar", "links": [20, 20, 20, 20]}, planner=None),
        "one_point": seed_file("one.json", path={"kind": "bezier", "control_points": [[50, 0]]}),
        "units": seed_file("units.json", arm={"kind": "planar", "links": [0.3, 0.3, 0.2]}),
        "binary": str(tmp_path / "binary.yaml"),
    }
    (tmp_path / "binary.yaml").write_bytes(bytes(range(256)))
    before = sorted(os.listdir(tmp_path))
    arguments = [argument.format(**files) for argument in arguments]
    code, out, err = run(*arguments, *(["--json"] if as_json else []))
    assert code == 2
    assert err.startswith("selfmotion: ")
    assert err.count("\n") == 1
    assert all(name.format(**files) in err for name in names), err
    if as_json:
        assert read(out)["status"] == "error"
    else:
        assert out == ""
    assert sorted(os.listdir(tmp_path)) == before


def test_a_failed_plan_leaves_no_earlier_motion_behind(run, seed_file, tmp_path):
    out = tmp_path / "out"
    assert run("plan", seed_file(), "--out", str(out))[0] == 0
    (out / "joints.png").write_bytes(b"retouched by hand")
    arm = {"kind": "planar", "links": [1, 1, 1], "limits": [[-2, 2]] * 3}
    path = {"kind": "line", "start": [1.5, -3], "end": [1.5, 3.5]}
    assert run("plan", seed_file(arm=arm, path=path), "--out", str(out))[0] == 2  # the retouched file is in the way
    (out / "joints.png").unlink()
    assert run("plan", seed_file(arm=arm, path=path), "--out", str(out))[0] == 3
    assert {name for name in os.listdir(out) if not name.startswith(".")} == {"plan.json"}
    assert read((out / "plan.json").read_text())["status"] == "infeasible"


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="needs /dev/full")
@pytest.mark.parametrize(("end", "code"), [(">/dev/full", 2), (">&-", 0), ("| true", 0)])
def test_a_reader_that_fails_is_no_traceback_and_no_other_verdict(end, code):
    command = f"set -o pipefail; {sys.executable} -m selfmotion schema {end}"
    done = subprocess.run(["bash", "-c", command], capture_output=True, text=True, check=False)
    assert done.returncode == code
    assert "Traceback" not in done.stderr


def test_schema_and_version(run):
    assert read(run("schema")[1])["title"] == "selfmotion problem"
    assert run("--version")[1].strip() == selfmotion.__version__


def test_a_closed_pipe_is_no_traceback(seed_file):
    command = f"{sys.executable} -m selfmotion schema | head -c 1"
    done = subprocess.run(command, shell=True, capture_output=True, text=True, check=False)
    assert done.stderr == ""
    assert done.stdout == "{"


def test_help_is_quick_and_imports_nothing_heavy():
    code = (
        "import sys; from selfmotion.cli import _run; _run(['--help']);"
        "heavy = {'numpy', 'scipy', 'matplotlib', 'yaml', 'cma', 'rich.progress'} & set(sys.modules);"
        "sys.exit(f'imported {heavy}' if heavy else 0)"
    )
    best = np.inf
    # As users have it: with compiled modules beside the sources, which the first of these runs writes.
    kept = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
    for _ in range(5):
        began = time.perf_counter()
        done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False, env=kept)
        best = min(best, time.perf_counter() - began)
        assert done.returncode == 0, done.stderr
    bare = min(_time_bare() for _ in range(5))
    assert best < 30 * bare  # a ratio, not a clock: bare Python starts in about a twentieth of that


def _time_bare():
    began = time.perf_counter()
    subprocess.run([sys.executable, "-c", "pass"], check=True)
    return time.perf_counter() - began


DRAWINGS = os.path.join(os.path.dirname(__file__), "..", "examples", "drawings")


def test_path_says_what_a_drawing_is_understood_as(run, tmp_path):
    code, out, err = run("path", os.path.join(DRAWINGS, "letter.svg"), "--info", "--arm-unit", "mm")
    assert code == 0
    assert err == ""
    assert out.startswith("SVG: 2 subpaths of 3 lines, 1 arc, 1 Bezier curve\n")
    assert "gap of 30: not bridged" in out
    code, out, err = run("path", os.path.join(DRAWINGS, "pocket.nc"), "--json", "--tolerance", "1e-5")
    assert code == 0
    assert err == ""
    result = read(out)
    assert result["status"] == "read"
    assert result["tolerance"] == 1e-5
    assert result["spindle"] == "S12000 (line 4)"
    assert {"what": "M5", "count": 1, "lines": [22]} in result["ignored"]


def test_path_draws_a_picture_and_spares_those_of_others(run, tmp_path):
    file = str(tmp_path / "Bild 画 1.png")
    for _ in range(2):  # its own it replaces
        code, out, _ = run("path", os.path.join(DRAWINGS, "bracket.dxf"), "--out", file)
        assert code == 0
        assert out.endswith(f"written to {file}\n")
    with open(file, "rb") as picture:
        assert picture.read().startswith(b"\x89PNG")
    (tmp_path / "mine.svg").write_text("mine")
    code, _, err = run("path", os.path.join(DRAWINGS, "bracket.dxf"), "--out", str(tmp_path / "mine.svg"))
    assert code == 2
    assert "--force" in err
    for name in ("picture.pdf", ".png", "folder/"):
        code, _, err = run("path", os.path.join(DRAWINGS, "bracket.dxf"), "--out", str(tmp_path / name))
        assert code == 2
        assert "name one that ends in .png or .svg" in err


def test_path_takes_what_problem_files_take(run, tmp_path):
    """Gaps, lifts, subpaths and the like: the path of the command is that of the problem file and of Python."""
    from selfmotion.exchange import read_drawing
    from selfmotion.exchange.schema import build

    for name, options in (
        ("letter.svg", {"gaps": "line", "arm_unit": "mm"}),
        ("letter.svg", {"lift": 5.0, "arm_unit": "mm", "scale": 2.0}),
        ("letter.svg", {"subpath": 1, "tolerance": 0.01}),
        ("pocket.nc", {"dimension": 2, "arm_unit": "inch"}),
        ("bracket.dxf", {"gaps": "line", "arm_unit": "cm"}),
    ):
        file = os.path.join(DRAWINGS, name)
        words = [word for key, value in options.items() for word in (f"--{key.replace('_', '-')}", str(value))]
        code, out, err = run("path", file, *words, "--json")
        assert (code, err) == (0, "")
        kind = {"svg": "svg", "dxf": "dxf", "nc": "gcode"}[name.split(".")[1]]
        drawing = read_drawing(file, **options)
        assert read(out) | {"status": "read"} == {
            "status": "read",
            **drawing.summary(),
            "version": selfmotion.__version__,
        }
        path = build("path", {"kind": kind, "file": file, **options})
        r = np.linspace(0, 1, 50)
        np.testing.assert_array_equal(path(r), drawing.path(r))
    assert "crossed above" in run("path", os.path.join(DRAWINGS, "letter.svg"), "--lift", "0.02")[1]
    assert "joined by a straight line" in run("path", os.path.join(DRAWINGS, "letter.svg"), "--gaps", "line")[1]
    for words in (
        ["--gaps", "jump"],
        ["--lift", "0"],
        ["--lift", "1", "--gaps", "line"],
        ["--subpath", "9"],
        ["--dimension", "2"],
    ):
        code, _, err = run("path", os.path.join(DRAWINGS, "letter.svg"), *words)
        assert code == 2
        assert err.count("\n") == 1


def test_a_path_too_small_for_the_arm_is_planned_with_a_warning(run, tmp_path):
    letter = os.path.join(DRAWINGS, "letter.svg")
    arm = {"kind": "planar", "links": [120, 120, 80]}
    inner = {"kind": "svg", "file": letter, "subpath": 0}
    path = {"kind": "transformed", "path": inner, "translation": [130, -60]}
    problem = tmp_path / "small.json"
    problem.write_text(json.dumps({"arm": arm, "path": path, "planner": {"kind": "global", "gap": 0.1}}))
    code, out, err = run("plan", str(problem), "--json")
    assert code == 0
    assert err.startswith("selfmotion: warning: the path extends over 0.08 (length ")
    assert read(out)["warnings"] == [err.removeprefix("selfmotion: warning: ").strip()]
    code, out, _ = run("path", letter, "--arm", str(problem))
    assert code == 0
    assert "warning: the path extends over 0.08 m (length 0.254 m), the arm reaches 320 m" in out
    assert "warning" not in run("path", letter, "--arm", str(problem), "--arm-unit", "mm")[1]
    assert "warning" not in run("path", letter, "--arm", "panda")[1]
    assert "the arm reaches 0.986" in run("path", letter, "--arm", "panda", "--scale", "0.01")[1]
    code, _, err = run("path", letter, "--arm", "pandda")
    assert code == 2
    assert "is neither an arm's name nor a file" in err


def test_path_names_what_is_wrong_in_one_line(run, tmp_path):
    bad = tmp_path / "arc 圆.nc"
    bad.write_text("G21\nG2 X11 Y0 I5 J0\n")
    code, out, err = run("path", str(bad), "--json")
    assert code == 2
    assert read(out)["error"]["field"] == "line 2"
    assert err.count("\n") == 1
    assert str(bad) in err
    csv = tmp_path / "a.csv"
    csv.write_text("x,y\n0,0\n3,4\n")
    assert "length 0.005 m" in run("path", str(csv), "--unit", "mm")[1]
    assert run("path", str(tmp_path / "none.svg"))[0] == 2
    assert run("path", str(tmp_path / "none.pdf"))[0] == 2
    assert run("path", os.path.join(DRAWINGS, "letter.svg"), "--unit", "inch")[0] == 2
    assert run("path", os.path.join(DRAWINGS, "letter.svg"), "--tolerance", "nan")[0] == 2

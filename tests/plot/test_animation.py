"""The animation: what moves is the motion, in time and size, and the same bytes every time."""

import io
import re
import subprocess
import sys

import numpy as np
import pytest
from PIL import Image

import selfmotion as sm
from selfmotion.cli import _run
from selfmotion.plot.animation import _DPI, Animation, _Arm, _Dot, encoder
from selfmotion.plot.style import figure


@pytest.fixture(scope="module")
def animation(seed_plan):
    r = seed_plan.problem.rows
    return Animation(seed_plan.problem, r, seed_plan(r), seconds=1.0, fps=30)


@pytest.fixture(scope="module")
def gif(animation):
    return animation.gif()


def test_the_gif_takes_its_time_and_repeats_bit_by_bit(animation, gif):
    picture = Image.open(io.BytesIO(gif))
    assert picture.size == (700, 340)
    durations = []
    for k in range(picture.n_frames):
        picture.seek(k)
        durations.append(picture.info["duration"])
    assert sum(durations) == 1000
    assert picture.n_frames == animation.count == 30
    assert picture.convert("RGB").getpixel((2, 2)) == (255, 255, 255)
    assert animation.gif() == gif


def test_six_seconds_stay_small(seed_plan):
    r = seed_plan.problem.rows
    assert len(Animation(seed_plan.problem, r, seed_plan(r)).gif()) < 3e6


def test_the_mp4_has_every_frame_and_repeats_bit_by_bit(animation, tmp_path):
    movie = animation.mp4()
    assert animation.mp4() == movie
    (tmp_path / "a.mp4").write_bytes(movie)
    command = [encoder(), "-hide_banner", "-i", str(tmp_path / "a.mp4"), "-f", "null", "-"]
    said = subprocess.run(command, capture_output=True, text=True, check=True).stderr
    assert "700x340" in said
    assert "yuv420p" in said
    assert re.findall(r"frame= *(\d+)", said)[-1] == "30"
    assert "creation_time" not in said


def test_tool_and_dot_are_where_the_plan_says_and_r_is_linear_in_time(seed_plan, animation):
    r = np.linspace(0, 1, 11)
    with figure(columns=2) as (canvas, axes):
        arm = _Arm(axes[0], seed_plan.problem, animation.motion, r)
        dot = _Dot(axes[1], seed_plan.problem, animation.motion, r)
        canvas.canvas.draw()
        for k, value in enumerate(r):
            arm.move(k)
            dot.move(k)
            np.testing.assert_allclose(np.ravel(arm.tool.get_data()), seed_plan.problem.path(value), atol=1e-2)
            np.testing.assert_allclose(np.ravel(dot.dot.get_data()), [value, seed_plan.u(value)[0]], atol=1e-3)
            assert arm.label.get_text() == f"r = {value:.2f}"
            ends = arm.trace.get_segments()
            np.testing.assert_allclose(ends[-1][-1], seed_plan.problem.path(value), atol=1e-2)
            np.testing.assert_allclose(ends[0][0], seed_plan.problem.path(max(value - 0.25, 0)), atol=1e-2)


def test_frames_differ_only_where_something_moves(animation):
    first, last = animation.frames((0, 29))
    changed = (first != last).any(axis=-1)
    assert 0.002 < changed.mean() < 0.2
    margin = int(0.1 * _DPI)
    assert not changed[:margin].any()
    assert not changed[-margin:].any()


def test_a_free_joint_takes_the_short_way(seed_path):
    arm = sm.PlanarArm([30, 30, 20])
    turned = Animation(sm.Problem(arm, seed_path), np.array([0.0, 1.0]), np.array([[3.1, 0, 0], [-3.1, 0, 0]]))
    assert turned.motion.at(np.array([0.5]))[0, 0] == pytest.approx(np.pi)


def test_more_redundancy_has_no_domain_beside_it():
    arm = sm.PlanarArm([1, 1, 1, 1])
    problem = sm.Problem(arm, sm.Line([2, 0], [2, 1]))
    u = np.zeros((5, 2))
    q, _ = arm.solve(problem.path(np.linspace(0, 1, 5)), u, 0)
    (frame,) = Animation(problem, np.linspace(0, 1, 5), q).frames((3,))
    assert frame.shape == (440, 460, 3)


@pytest.mark.parametrize(
    ("seconds", "fps", "field"), [(0, 25, "--seconds"), (6, 0, "--fps"), (6, 99, "--fps"), (500, 25, "--seconds")]
)
def test_bad_times_are_refused(seed_plan, seconds, fps, field):
    r = seed_plan.problem.rows
    with pytest.raises(sm.InvalidInputError, match=field):
        Animation(seed_plan.problem, r, seed_plan(r), seconds, fps)


@pytest.fixture
def planned(seed_file, tmp_path):
    problem, out = seed_file(samples=60), tmp_path / "out"
    assert _run(["plan", problem, "--out", str(out)]) == 0
    return problem, str(out / "trajectory.csv"), out


SHORT = ("--seconds", "0.2", "--fps", "10")


def test_the_command_writes_both(planned, capsys):
    problem, motion, out = planned
    capsys.readouterr()
    assert _run(["animate", problem, motion, "--out", str(out), *SHORT]) == 0
    assert "2 frames, animation.gif and animation.mp4" in capsys.readouterr().out
    assert (out / "animation.gif").read_bytes()[:6] == b"GIF89a"
    assert b"ftyp" in (out / "animation.mp4").read_bytes()[:16]


def test_without_an_encoder_there_is_a_gif_and_a_note(planned, capsys, monkeypatch):
    problem, motion, out = planned
    assert _run(["animate", problem, motion, "--out", str(out), *SHORT]) == 0
    capsys.readouterr()
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    monkeypatch.setenv("PATH", "")
    assert _run(["animate", problem, motion, "--out", str(out), *SHORT]) == 0
    assert "no mp4: it needs the package imageio-ffmpeg" in capsys.readouterr().out
    assert not (out / "animation.mp4").exists()  # the one of before may show another motion
    assert _run(["animate", problem, motion, "--out", str(out), *SHORT, "--format", "mp4"]) == 2
    assert "selfmotion[animation]" in capsys.readouterr().err


def test_an_encoder_that_fails_is_quoted(animation, tmp_path, monkeypatch):
    broken = tmp_path / "ffmpeg"
    broken.write_text("#!/bin/sh\necho no such coder >&2\nexit 1\n")
    broken.chmod(0o755)
    monkeypatch.setattr("selfmotion.plot.animation.encoder", lambda: str(broken))
    with pytest.raises(sm.InvalidInputError, match="no such coder"):
        animation.mp4()


def test_bad_input_names_row_and_column(planned, capsys, tmp_path):
    problem, motion, out = planned
    lines = (out / "trajectory.csv").read_text(encoding="utf-8").splitlines()
    lines[3] = lines[3].replace(lines[3].split(",")[2], "nan")
    (tmp_path / "bad.csv").write_text("\n".join(lines))
    capsys.readouterr()
    assert _run(["animate", problem, str(tmp_path / "bad.csv"), "--out", str(out)]) == 2
    assert "row 3, column q2" in capsys.readouterr().err
    assert not (out / "animation.gif").exists()
    assert _run(["animate", problem, motion, "--out", str(out), "--format", "avi"]) == 2
    assert "gif, mp4" in capsys.readouterr().err

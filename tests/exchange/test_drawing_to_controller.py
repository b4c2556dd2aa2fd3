"""The whole way: a drawing becomes a path, a plan, a timed trajectory, and a message that is read back.

What it is held against is written here by hand, point by point, as the drawings are: nothing of the way is in it.
"""

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial import cKDTree

import selfmotion as sm

pytest.importorskip("toppra")
pytest.importorskip("rosbags")
pytest.importorskip("svgpathtools")
pytest.importorskip("ezdxf")

DRAWINGS = Path(__file__).parents[2] / "examples" / "drawings"
HELIX = """\
G21 G17 G90
G0 X20 Y0 Z5
G1 Z0 F100
G3 X20 Y0 Z-6 I-20 J0
G1 X0 Y0 (to the middle)
M30
"""
ELBOW = [None, (0.0, np.pi), None]
POINTS = 50001  # of a curve: its chords are within 1e-7 mm of it
ACCELERATION, VELOCITY = 8.0, 2.0


def lines(*points):
    return [np.array(pair, dtype=float) for pair in pairwise(points)]


def arc(center, radius, start, end, sink=None):
    """Degrees; with `sink` a helix that goes down by so much."""
    t = np.radians(np.linspace(start, end, POINTS))
    plane = np.array(center) + radius * np.stack([np.cos(t), np.sin(t)], axis=1)
    return plane if sink is None else np.column_stack([plane, np.linspace(0, -sink, POINTS)])


def bezier(a, b, c, d):
    t = np.linspace(0, 1, POINTS)[:, None]
    points = map(np.array, (a, b, c, d))
    weights = ((1 - t) ** 3, 3 * t * (1 - t) ** 2, 3 * t**2 * (1 - t), t**3)
    return sum(weight * point for weight, point in zip(weights, points, strict=True))


# Millimetres, in the order of the drawing; y of the SVG counted upwards from the foot of its page.
OUTLINES = {
    "letter": [
        *lines((30, 20), (30, 100), (60, 100)),
        arc((60, 80), 20, 90, -90),
        *lines((60, 60), (30, 60), (60, 60)),
        bezier((60, 60), (75, 55), (78, 35), (90, 20)),
    ],
    "bracket": [
        *lines((0, 0), (90, 0)),
        arc((90, 10), 10, -90, 0),
        *lines((100, 10), (100, 20), (40, 20)),
        arc((40, 40), 20, -90, -180),
        *lines((20, 40), (20, 100), (0, 100), (0, 0)),
    ],
    "pocket": [
        *lines((10, 0), (70, 0)),
        arc((70, 10), 10, -90, 0),
        *lines((80, 10), (80, 40)),
        arc((70, 40), 10, 0, 90),
        *lines((70, 50), (10, 50)),
        arc((10, 40), 10, 90, 180),
        *lines((0, 40), (0, 10)),
        arc((10, 10), 10, 180, 270),
        *lines((10, 0), (15, 15), (65, 15), (65, 35), (15, 35), (15, 15)),
    ],
    "helix": [*lines((20, 0, 5), (20, 0, 0)), arc((0, 0), 20, 0, 360, sink=6), *lines((20, 0, -6), (0, 0, -6))],
}


def off(points, part):
    """Distance of each point from a line, or from a curve by its chords."""
    nearest = cKDTree(part).query(points)[1]
    best = np.full(len(points), np.inf)
    for side in (-1, 0):
        k = np.clip(nearest + side, 0, len(part) - 2)
        chord, since = part[k + 1] - part[k], points - part[k]
        t = np.clip((since * chord).sum(axis=1) / (chord**2).sum(axis=1), 0, 1)
        best = np.minimum(best, np.linalg.norm(since - t[:, None] * chord, axis=1))
    return best


def read(name, arm_unit, folder):
    if name == "letter":
        return sm.read_svg(DRAWINGS / "letter.svg", arm_unit=arm_unit, gaps="line")
    if name == "bracket":
        return sm.read_dxf(DRAWINGS / "bracket.dxf", arm_unit=arm_unit, subpath=0)
    if name == "pocket":
        return sm.read_gcode(DRAWINGS / "pocket.nc", arm_unit=arm_unit, dimension=2)
    (folder / "helix.nc").write_text(HELIX)
    return sm.read_gcode(folder / "helix.nc", arm_unit=arm_unit)


def planar(arm, planner, scale, shift):
    """A planar arm in millimetres, with a drawing scaled and moved in front of it."""

    def placed(drawing):
        return sm.Problem(arm, sm.Transformed(drawing.path, scale=scale, translation=shift), samples=200)

    def tool(q):  # of the chain of links, in millimetres of the drawing
        phi = np.cumsum(q, axis=1)
        at = np.stack([np.cos(phi) @ arm.links, np.sin(phi) @ arm.links], axis=1)
        return (at - shift) / scale

    return arm, planner, placed, tool, "mm", scale


def panda():
    """A Panda whose hand points down onto the drawing."""
    arm, corner = sm.named_arm("panda"), np.array([0.42, -0.06, 0.3])

    def placed(drawing):
        on_table = sm.Placed(drawing.path, {"translation": corner})
        return sm.Problem(arm, sm.PosePath(on_table, orientation=[0, 1, 0, 0]), samples=200)

    def tool(q):  # by the URDF's transforms
        pose = arm.chain.forward(q)
        assert np.abs(pose[:, :3, :3] - np.diag([1, -1, -1])).max() < 1e-9
        return 1e3 * (pose[:, :3, 3] - corner)

    return arm, sm.Global(gap=1e-2), placed, tool, "m", 1e-3


ARMS = {
    "3R": lambda: planar(sm.PlanarArm([120, 120, 80], ELBOW), sm.Global(gap=1e-2), 1.0, np.array([130, -60])),
    "6R": lambda: planar(sm.PlanarArm([30] * 6, ELBOW * 2), sm.Refine(starts=2, seed=0), 0.5, np.array([70, -25])),
    "panda": panda,
}
CASES = [(arm, name) for arm in ARMS for name in OUTLINES if name != "helix" or arm == "panda"]


@pytest.fixture(scope="module", params=CASES, ids="-".join)
def case(request, tmp_path_factory):
    """A case gone through: arm, drawing, its outline, timed trajectory, and how to find the tool."""
    which, name = request.param
    _, planner, placed, tool, unit, size = ARMS[which]()
    drawing = read(name, unit, tmp_path_factory.mktemp("drawing"))
    plan = sm.plan(placed(drawing), planner)
    velocity = None if which == "panda" else VELOCITY  # whose URDF has them
    timed = sm.time_law(plan, ACCELERATION, velocity, rate=250.0)
    # Millimetres of the drawing: what flattening may take, and what the plan says of its tracking.
    allowed = drawing.chord_error * (1e3 if unit == "m" else 1.0) + plan.verification.max_tracking_error / size + 1e-6
    return plan, timed, name, tool, allowed


def test_the_tool_goes_along_the_drawing_and_leaves_none_of_it_out(case):
    _, timed, name, tool, allowed = case
    drawn = np.concatenate(OUTLINES[name])
    x = tool(timed(np.linspace(0.0, timed.duration, 20001)))
    flat = x[:, : drawn.shape[1]]
    if drawn.shape[1] < x.shape[1]:
        assert np.abs(x[:, 2]).max() < 1e-6
    assert allowed < 0.11  # the tolerance of drawings, if nothing else is said
    assert np.min([off(flat, part) for part in OUTLINES[name]], axis=0).max() <= allowed
    steps = np.linalg.norm(np.diff(flat, axis=0), axis=1)
    assert cKDTree(flat).query(drawn)[0].max() <= allowed + steps.max()
    length = np.linalg.norm(np.diff(drawn, axis=0), axis=1).sum()
    assert steps.sum() == pytest.approx(length, rel=1e-6 + 0.015 * allowed)
    assert np.linalg.norm(flat[[0, -1]] - drawn[[0, -1]], axis=1).max() <= allowed


@pytest.mark.parametrize("form", ["ros", "mcap"])
def test_what_is_read_back_keeps_every_limit(case, form, tmp_path):
    """Mean values over the rows' steps are no larger than what holds at all times, whatever is in between."""
    plan, timed, *_ = case
    arm = plan.problem.arm
    sm.save_trajectory(timed, tmp_path / "trajectory", form)
    rows = sm.load_trajectory(tmp_path / "trajectory")
    names = (
        tuple(f"panda_joint{j}" for j in range(1, 8)) if arm.n == 7 else tuple(f"joint{j + 1}" for j in range(arm.n))
    )
    assert rows.joint_names == names
    assert rows.frame_id == ("panda_link0" if arm.n == 7 else "")
    steps = np.diff(rows.t)[:, None]
    assert (steps > 0).all()
    assert rows.t[0] == 0.0
    assert rows.t[-1] == pytest.approx(timed.duration, abs=1e-9)
    fast = arm.chain.velocity if arm.n == 7 else np.full(arm.n, VELOCITY)
    assert np.isfinite(fast).all()
    slack = 1e-12
    for angles in (rows.q, timed(np.linspace(0.0, timed.duration, 20001))):
        assert (angles >= arm.limits.lower - slack).all()
        assert (angles <= arm.limits.upper + slack).all()
    for speed, bend in ((rows.dq, rows.ddq), timed.states(np.linspace(0.0, timed.duration, 50001))[1:]):
        assert (np.abs(speed) <= 1.001 * fast).all()
        assert (np.abs(bend) <= 1.001 * ACCELERATION).all()
    mean = np.diff(rows.q, axis=0) / steps
    assert (np.abs(mean) <= 1.001 * fast).all()
    even = np.abs(steps[1:] - steps[:-1])[:, 0] < 2e-9  # all but the last
    bend = (np.diff(mean, axis=0) / steps[1:])[even]
    assert (np.abs(bend) <= 1.001 * ACCELERATION + 1e-4).all()
    assert np.abs(bend).max() > 0.5 * ACCELERATION  # it is as fast as it may be


def test_it_begins_and_ends_at_rest_where_the_plan_does(case):
    plan, timed, *_ = case
    assert timed.q[[0, -1]] == pytest.approx(plan([0.0, 1.0]), abs=1e-12)
    assert not timed.dq[[0, -1]].any()
    assert plan.verification.holds
    assert plan.gap is None or plan.gap <= 1e-2

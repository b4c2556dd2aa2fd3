"""Figures of the docs, drawn by the code that they describe."""

from pathlib import Path

import numpy as np
from digest import digest

import selfmotion as sm
from selfmotion.optimizers import OPTIMIZERS, AskTell
from selfmotion.plot import (
    draw_domain,
    draw_flow,
    draw_postures,
    draw_sampled_joints,
    draw_samples,
    draw_sweep,
    figure,
    flow_height,
    image_files,
)

PATH = sm.Bezier([[50, -10], [85, 30], [50, 50], [60, -10], [58, 30], [70, -10]])
FREE = sm.Problem(sm.PlanarArm([30, 30, 20]), PATH)


def write_flows(folder: Path):
    """Write the flow chart of every ask/tell optimizer; untouched files keep their time, so builds stay incremental."""
    folder.mkdir(exist_ok=True)
    for kind, optimizer in OPTIMIZERS.items():
        if not issubclass(optimizer, AskTell):
            continue
        with figure(height=flow_height(optimizer)) as (canvas, (axes,)):
            draw_flow(axes, optimizer)
            _write(folder, f"flow_{kind}.svg", canvas)


def write_ten_minutes(folder: Path):
    """Write the pictures of the pages on the domain and on obstacles, unless neither they nor the package changed."""
    folder.mkdir(exist_ok=True)
    key = folder / "ten-minutes.key"
    if key.exists() and key.read_text() == digest(Path(__file__)):
        return
    for name, (draw, size) in TEN_MINUTES.items():
        with figure(**size) as (canvas, axes):
            draw(*axes)
            _write(folder, f"{name}.png", canvas)
    key.write_text(digest(Path(__file__)))


def _postures(*panels):
    for branch, axes in enumerate(panels):
        draw_sweep(axes, FREE, 0.5, branch)
        axes.set_xlim(-5, 70)
        axes.set_ylim(-18, 42)


def _free(axes):
    draw_domain(axes, sm.angle_domain(FREE.arm, PATH), 0, causes=True)


def _events(*panels):
    arm = sm.PlanarArm([1, 1, 1], limits=[(-1.45, 1.45)] * 3)
    domain = sm.angle_domain(arm, sm.Line([1.5, -2.5], [1.5, 2.5]))
    for branch, axes in enumerate(panels):
        draw_domain(axes, domain, branch, causes=True)
        axes.set_title(f"{arm.branches[branch]} elbow")


def _repair(*panels):
    r = np.linspace(0, 1, 81)
    up, down = (FREE.arm.solve(PATH(r), np.full((81, 1), 0.3), elbow)[0] for elbow in FREE.arm.branches)
    q = np.where(np.abs(r - 0.5)[:, None] < 0.06, down, up)
    mended = sm.repair(FREE, r, q)
    for (left, right), motion in zip(
        (panels[:2], panels[2:]), ((r, q, mended.breaks), (mended.r, mended.q)), strict=True
    ):
        draw_samples(left, FREE, *motion)
        draw_sampled_joints(right, FREE, *motion)


def _plan(axes):
    arm = sm.PlanarArm([30, 30, 20], limits=[None, (0, np.pi), None])
    planner = sm.Sinusoid([0.3], amplitude=[0.4], optimizer=sm.PSO(bounds=(0, 15), seed=1))
    plan = sm.plan(sm.Problem(arm, PATH), planner)
    r = PATH.grid(400)
    draw_domain(axes, sm.angle_domain(arm, PATH), 0, {"the plan": (r, plan.u(r)[:, 0])}, causes=True)


def _around(*panels):
    arm = sm.PlanarArm([30, 30, 20], [None, (0, np.pi), None], thickness=2)
    posts = [sm.CircleObstacle([28, -22], 4), sm.CircleObstacle([20, 30], 5), sm.CircleObstacle([40, 24], 4)]
    among = sm.Problem(arm, PATH, obstacles=posts, clearance=1.0)
    for axes, problem in zip(panels, (sm.Problem(arm, PATH), among), strict=True):
        plan = sm.plan(problem, sm.Global(gap=1e-2))
        draw_postures(axes, sm.Plan(among, plan.motion, plan.planner, {}))
        axes.set_title(f"cost {plan.cost:.4f}")


TEN_MINUTES = {
    "postures_at_a_point": (_postures, {"width": 7.0, "height": 3.0, "columns": 2}),
    "domain_free": (_free, {"width": 7.0, "height": 3.0}),
    "domain_events": (_events, {"width": 7.0, "height": 3.8, "columns": 2}),
    "repair": (_repair, {"width": 7.0, "height": 5.6, "columns": 2, "rows": 2}),
    "domain_with_plan": (_plan, {"width": 7.0, "height": 3.0}),
    "around_obstacles": (_around, {"width": 7.0, "height": 3.6, "columns": 2}),
}
"""Name to what draws it, on as many Axes as its size says."""


def _write(folder, name, canvas):
    stem, suffix = name.split(".")
    picture = image_files(stem, canvas)[f"{stem}.{suffix}"]
    file = folder / name
    if not file.exists() or file.read_bytes() != picture:
        file.write_bytes(picture)

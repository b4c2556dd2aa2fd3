"""The self-motion at one point of the path: its extreme postures, its joint angles, all its postures."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from selfmotion._checks import branch_index
from selfmotion._types import BoolArray, FloatArray
from selfmotion.angles import nearest_turn
from selfmotion.domain import Sweep, angle_domain
from selfmotion.errors import InvalidInputError
from selfmotion.plot.obstacles import draw_links, draw_obstacles, in_view
from selfmotion.plot.plane import draw_angle, draw_base, draw_chain, draw_label, frame, whole_turn
from selfmotion.plot.style import COLORS, DASHES, GREY, INK, REGION, shades
from selfmotion.problem import Problem

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_CURVE = 401
# A posture with a smaller θ2 is stretched [rad].
_STRETCHED = 1e-6
_ELBOW_WIDTHS = (1.8, 0.8)


def draw_extreme_postures(axes: Axes, problem: Problem, r: float = 0.0, branch: int | str = 0) -> None:
    """Draw the maximum posture A and the minimum posture B at one point of the path (Fig. 4).

    Parameters
    ----------
    axes : Axes
    problem : Problem
        Arm with one redundant degree, and path.
    r : float
        Path parameter.
    branch : int or str
        IK branch; without joint limits in the way both have the same extreme postures.

    Raises
    ------
    InvalidInputError
        If the arm has another degree of redundancy, or the point has no minimum and maximum.

    Notes
    -----
    Of several feasible intervals the widest is shown. ψ and θ_g are marked, and, where the posture is stretched
    (θ2 = 0), Δ1 and Δ3 of (12) and (13).
    """
    parts = angle_domain(problem.arm, problem.path).sweep(r, branch, 2).parts()
    part = max(parts, key=lambda one: one.u[-1] - one.u[0], default=None)
    if part is None or len(part.u) < 2 or part.u[-1] - part.u[0] > 2 * np.pi - 1e-9:
        what = "nothing is feasible" if part is None else "the postures have no minimum and maximum"
        raise InvalidInputError("r", f"{what} there", "choose another point of the path", r)
    center = problem.arm.annulus[0] if hasattr(problem.arm, "annulus") else np.zeros(2)
    target = problem.path(float(r)) - center
    psi, size = float(np.arctan2(target[1], target[0])), problem.arm.reach
    chains = problem.arm.joint_positions(part.q)
    for chain, q, u, name, look in zip(
        chains, part.q, part.u, ("min", "max"), ((COLORS[1], DASHES[1]), (COLORS[0], DASHES[0])), strict=True
    ):
        draw_chain(axes, chain, color=look[0], linestyle=look[1], linewidth=1.8, markersize=3.5, zorder=4)
        wrist = chain[2]
        axes.plot(*np.stack([wrist, wrist + np.array([0.16 * size, 0.0])]).T, color=GREY, linewidth=0.6)
        draw_angle(axes, wrist, 0.0, whole_turn(u), 0.1 * size, f"$θ_{{g,{name}}}$", width=28.0)
        if abs(q[1]) <= _STRETCHED:
            _draw_triangle(axes, wrist, target, size, name == "max")
    axes.plot(*np.stack([np.zeros(2), target]).T, color=GREY, linewidth=0.7)
    axes.plot([0, 0.5 * size], [0, 0], color=GREY, linewidth=0.6)
    draw_angle(axes, np.zeros(2), 0.0, psi, 0.42 * size, "ψ")
    for chain, name in zip(chains, ("B: minimum", "A: maximum"), strict=True):
        draw_label(axes, name, 0.3 * chain[1] + 0.7 * chain[2], _aside(chain[2] - chain[1], target), width=48.0)
    _point(axes, problem, r)
    draw_obstacles(axes, problem.arm)
    draw_base(axes)
    frame(axes, np.vstack([*chains, [[0.5 * size, 0]], chains[:, 2] + [0.24 * size, 0]]), margin=0.16)
    axes.set_title("maximum and minimum posture")


def draw_posture_interval(axes: Axes, problem: Problem, r: float = 0.0) -> None:
    """Draw the joint angles against the redundancy parameter, both elbows, at one point of the path (Fig. 5a).

    Parameters
    ----------
    axes : Axes
    problem : Problem
        Arm with one redundant degree, and path.
    r : float
        Path parameter.

    Raises
    ------
    InvalidInputError
        If the arm has another degree of redundancy.
    """
    domain = angle_domain(problem.arm, problem.path)
    middles: dict[int, FloatArray] = {}
    for branch, width in zip(range(len(problem.arm.branches)), _ELBOW_WIDTHS, strict=True):
        for k, part in enumerate(domain.sweep(r, branch, _CURVE).parts()):
            axes.axvspan(part.u[0], part.u[-1], color=REGION, linewidth=0)
            q = _continuous(part, ~problem.arm.limits.limited, middles.get(k))
            middles.setdefault(k, q.mean(axis=0))
            for joint, series in enumerate(q.T):
                axes.plot(part.u, series, linewidth=width, **_look(joint))
                ends = part.u[[0, -1]], series[[0, -1]]
                axes.plot(*ends, "o", color=_look(joint)["color"], markersize=2.5 if width < 1 else 3.5)
    if not middles:
        axes.set_title("nothing is feasible here")
    else:
        for joint in range(problem.arm.n):
            axes.plot([], [], label=f"θ{joint + 1}", **_look(joint))
        for sign, width in zip("+−", _ELBOW_WIDTHS, strict=True):
            axes.plot([], [], color=INK, linewidth=width, label=f"elbow {sign}")
        place: dict[str, Any] = {"loc": "lower left", "bbox_to_anchor": (-0.05, 1.0), "ncols": 5, "borderaxespad": 0.2}
        axes.legend(**place, handlelength=2.2, columnspacing=1.0, handletextpad=0.5)
    axes.margins(x=0.04, y=0.06)
    axes.set_xlabel("$θ_g$ [rad]" if problem.arm.n == 3 else "redundancy parameter u [rad]")
    axes.set_ylabel("joint angle [rad]")


def draw_sweep(axes: Axes, problem: Problem, r: float = 0.0, branch: int | str = 0, count: int = 21) -> None:
    """Draw all postures at one point of the path, light at the minimum and dark at the maximum (Fig. 5b and c).

    Parameters
    ----------
    axes : Axes
    problem : Problem
        Arm with one redundant degree, and path.
    r : float
        Path parameter.
    branch : int or str
        IK branch.
    count : int
        Number of postures per feasible interval.

    Raises
    ------
    InvalidInputError
        If the arm has another degree of redundancy.
    """
    parts = angle_domain(problem.arm, problem.path).sweep(r, branch, count).parts()
    everything = [np.zeros((1, 2)), problem.path(float(r))[None]]
    for part in parts:
        chains = problem.arm.joint_positions(part.q)
        everything.append(chains.reshape(-1, 2))
        for k, (chain, color) in enumerate(zip(chains, shades(len(chains)), strict=True)):
            extreme = k in (0, len(chains) - 1)
            draw_links(axes, problem.arm, chain, color=color)
            draw_chain(axes, chain, color=color, linewidth=1.6 if extreme else 0.8)
    _point(axes, problem, r)
    draw_obstacles(axes, problem.arm)
    draw_base(axes)
    frame(axes, np.vstack([*everything, in_view(problem.arm)]))
    name = problem.arm.branches[branch_index(problem.arm.branches, branch)]
    axes.set_title(f"{name} elbow" if parts else f"{name} elbow: nothing is feasible here")


def _look(joint: int) -> dict[str, Any]:
    """Return colour and dashes of a joint's curve."""
    return {"color": COLORS[joint % len(COLORS)], "linestyle": DASHES[joint % len(DASHES)]}


def _continuous(part: Sweep, free: BoolArray, middle: FloatArray | None) -> FloatArray:
    """Return the joint angles as curves without jumps of a whole turn, free joints around `middle`, or else 0."""
    q = np.unwrap(part.q, axis=0)
    mean = q.mean(axis=0)
    turned = nearest_turn(mean, np.zeros_like(mean) if middle is None else middle) - mean
    return np.asarray(q + np.where(free, turned, 0.0))


def _draw_triangle(axes: Axes, wrist: FloatArray, target: FloatArray, size: float, is_maximum: bool) -> None:
    """Mark Δ1 at the base and Δ3 at the wrist of a stretched posture."""
    psi, along = np.arctan2(target[1], target[0]), np.arctan2(wrist[1], wrist[0])
    draw_angle(axes, np.zeros(2), psi, whole_turn(along - psi), (0.3 if is_maximum else 0.24) * size, "$Δ_1$")
    back, last = np.arctan2(*-wrist[::-1]), np.arctan2(*(target - wrist)[::-1])
    draw_angle(axes, wrist, back, whole_turn(last - back), 0.07 * size, "$Δ_3$")


def _aside(link: FloatArray, target: FloatArray) -> FloatArray:
    """Return the direction square to a link, away from the target."""
    normal = np.array([-link[1], link[0]]) / float(np.hypot(*link))
    return np.asarray(-normal if normal @ target >= 0 else normal)


def _point(axes: Axes, problem: Problem, r: float) -> None:
    """Mark the task point."""
    point = problem.path(float(r))
    axes.plot(*point, "s", color=COLORS[0], markersize=4.5, zorder=7)
    draw_label(axes, "P", point, np.array([1.0, 0.0]), gap=4.0)

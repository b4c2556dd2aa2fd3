"""The angle domain of an arm in space: u against r on each of its branches, and what ends the feasible intervals."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from selfmotion._types import BoolArray, FloatArray, IntArray
from selfmotion.arms import Cause, RedundantArm
from selfmotion.domain import SampledDomain
from selfmotion.domain.holes import is_contact
from selfmotion.plot.domain import legend_below
from selfmotion.plot.holes import fill_holes, in_window
from selfmotion.plot.style import COLORS, COLUMN, GREY, INK, REGION, figure, image_files
from selfmotion.plot.window import Window

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_JOINTS = (*COLORS, GREY)
_ONE_ROW = 4  # of at most so many panels
_SEEN = 0.02  # part of the path on which a branch must be feasible to have a panel
_MARGIN = 0.04
_LEGEND_COLUMNS = 6


def draw_sampled_domain(
    axes: Axes,
    sampled: SampledDomain,
    branch: int,
    motion: tuple[FloatArray, FloatArray, BoolArray] | None = None,
    window: Window | None = None,
    named: bool = True,
    extent: tuple[float, float] | None = None,
) -> None:
    """Draw the angle domain of one branch of an arm in space.

    A limit has its joint's colour, an upper one is solid and a lower one dashed. Folds, where the motion may go on on
    another branch, are black: solid where wrists meet, dotted where the elbow is stretched or folded. Holes that
    obstacles make are filled in the obstacle's colour.

    Parameters
    ----------
    axes : Axes
    sampled : SampledDomain
    branch : int
    motion : tuple of array, optional
        r, u and whether it is on this branch, each of shape (k,).
    window : Window, optional
        The turn of u that is shown, from −π to π by default.
    named : bool
        Whether to name limits and folds below the axes.
    extent : tuple of float, optional
        The range of u that is shown, by default what is feasible.
    """
    strips, holes = sampled.strips(branch), sampled.holes(branch)
    shown = Window(0.0) if window is None else window
    for strip in strips:
        for low, high in shown.copies(strip):
            axes.fill_between(strip.r, low, high, where=high > low, color=REGION, linewidth=0.3)
    curves: dict[Cause, list[tuple[FloatArray, FloatArray]]] = {}
    for causes, r, u in shown.boundary([strip for strip in strips if any(strip.causes)]):
        curves.setdefault(min(causes, key=order), []).append((r, u))
    seen: set[str] = set()
    for cause in sorted(filter(lambda one: not is_contact(one), curves), key=order):
        name = name_of(cause)
        for r, u in curves[cause]:
            axes.plot(r, u, label=None if name in seen else name, **_look(cause))
            seen.add(name)
    if motion is not None:
        _draw_motion(axes, shown, *motion)
    axes.set_xlim(0.0, 1.0)
    axes.set_ylim(*extent or _extent([*strips, *(part for hole in holes for part in hole.strips)], shown))
    fill_holes(axes, [(hole, *in_window(hole, shown)) for hole in holes])
    axes.set_xlabel("path parameter r")
    axes.set_ylabel(parameter_name(sampled))
    axes.set_title(sampled.domain.self_motion.branches[branch] + ("" if strips else ": nothing is feasible"))
    if named:
        legend_below(axes, 2 if holes else 3)


def sampled_domain_figure(
    sampled: SampledDomain, motion: tuple[FloatArray, FloatArray, IntArray] | None = None, name: str = "domain"
) -> dict[str, bytes]:
    """Return the angle domains of all branches on which anything is feasible side by side, as file name to bytes.

    Parameters
    ----------
    sampled : SampledDomain
    motion : tuple of array, optional
        r, u and branch of a motion, each of shape (k,); drawn where it is.
    name : str
        Of the files, without their endings.

    Returns
    -------
    dict
    """
    seen = {branch: sum(b - a for a, b in sampled.stretches(branch)) for branch in sampled.branches}
    used = set() if motion is None else set(np.unique(motion[2]).tolist())
    branches = [branch for branch in sampled.branches if seen[branch] >= _SEEN or branch in used]
    hidden = [branch for branch in sampled.branches if sampled.stretches(branch) and branch not in branches]
    if not branches:
        branches, hidden = hidden or list(sampled.branches[:1]), []
    rows = 1 if len(branches) <= _ONE_ROW else 2
    columns = -(-len(branches) // rows)
    strips = [strip for branch in branches for strip in sampled.strips(branch)]
    strips += [strip for branch in branches for hole in sampled.holes(branch) for strip in hole.strips]
    window = Window(0.0)
    remark = _remark(sampled, hidden)
    size = {"width": max(COLUMN, 0.6 + 1.75 * columns), "height": 0.9 + 1.75 * rows + 0.15 * len(remark.splitlines())}
    with figure(**size, columns=columns, rows=rows) as (canvas, panels):
        for number, (branch, axes) in enumerate(zip(branches, panels, strict=False)):
            mine = None if motion is None else (motion[0], motion[1], motion[2] == branch)
            draw_sampled_domain(axes, sampled, branch, mine, window, named=False, extent=_extent(strips, window))
            axes.set_xticks([0, 0.5, 1], ["0", "0.5", "1"])
            if number % columns:
                axes.set_ylabel("")
            if number + columns < len(branches):
                axes.set_xlabel("")
        for spare in panels[len(branches) :]:
            spare.set_axis_off()
        _legend(canvas, panels, remark)
        return image_files(name, canvas)


def name_of(cause: Cause) -> str:
    """Return what a limit or fold is called in a legend."""
    if cause.kind == "fold" and cause.joint >= 0:
        return f"fold θ{cause.joint + 1} = ±π/2" if _is_wrist(cause) else f"fold θ{cause.joint + 1} = {cause.value:.3g}"
    if cause.kind in ("fold", "free", "marker"):
        return str(cause)
    return f"θ{cause.joint + 1} {cause.kind.split()[0]}"


def parameter_name(sampled: SampledDomain) -> str:
    """Return what u is called on an axis."""
    arm: RedundantArm | None = getattr(sampled.domain.self_motion, "arm", None)
    form = getattr(arm, "closed_form", None)
    return "u [rad]" if form is None else f"u = {form.family.parameter.replace('q', 'θ')} [rad]"


def _is_wrist(cause: Cause) -> bool:
    return abs(abs(cause.value) - 0.5 * np.pi) < 1e-9


def order(cause: Cause) -> tuple[int, int, bool, float]:
    """Return what is shown first: limits before contacts and folds, which they cover where they coincide."""
    kinds = {"upper limit": 0, "lower limit": 0, "fold": 2, "free": 3, "marker": 4}
    return kinds.get(cause.kind, 1), cause.joint, cause.kind == "lower limit", cause.value


def _look(cause: Cause) -> dict[str, Any]:
    if cause.kind == "fold":
        return {"color": INK, "linewidth": 0.8, "linestyle": "-" if _is_wrist(cause) else (0, (1.0, 1.0))}
    if cause.kind in ("free", "marker"):
        return {"color": GREY, "linewidth": 0.6}
    dashes: Any = "-" if cause.kind == "upper limit" else (0, (3.0, 1.2))
    return {"color": _JOINTS[cause.joint % len(_JOINTS)], "linewidth": 1.2, "linestyle": dashes}


def _draw_motion(axes: Axes, window: Window, r: FloatArray, u: FloatArray, here: BoolArray) -> None:
    """Draw the parts of a motion that are on the branch, interrupted where it leaves the window on one side."""
    from matplotlib.patheffects import Normal, withStroke

    near = np.where(here, window.wrapped(u), np.nan)
    leaps = np.flatnonzero(np.abs(np.diff(near)) > np.pi) + 1
    r, near = np.insert(r, leaps, np.nan), np.insert(near, leaps, np.nan)
    if np.isfinite(near).any():
        halo = [withStroke(linewidth=3.6, foreground="white"), Normal()]
        axes.plot(r, near, color=INK, linewidth=2.0, label="motion", path_effects=halo, zorder=4)


def _extent(strips: Sequence[Any], window: Window) -> tuple[float, float]:
    """Return the range of u that holds the strips, with a margin."""
    values = [part for strip in strips for pair in window.copies(strip) if (pair[1] > pair[0]).any() for part in pair]
    both = np.concatenate(values) if values else np.array([window.center - np.pi, window.center + np.pi])
    margin = _MARGIN * max(float(np.ptp(both)), 0.1)
    return float(both.min()) - margin, float(both.max()) + margin


def _remark(sampled: SampledDomain, hidden: Sequence[int]) -> str:
    """Return in words where the branches that have no panel are feasible."""
    names = sampled.domain.self_motion.branches
    where: dict[str, list[str]] = {}
    for branch in hidden:
        parts = [f"{a:.3g}" if a == b else f"{a:.3g} … {b:.3g}" for a, b in sampled.stretches(branch)]
        where.setdefault(" and ".join(parts), []).append(names[branch])
    return "\n".join(f"feasible at r = {at} only: {', '.join(branches)}" for at, branches in where.items())


def _legend(canvas: Figure, panels: Sequence[Axes], remark: str) -> None:
    """Name every look once, below the panels, and say what is not shown."""
    named: dict[str, Any] = {}
    for axes in panels:
        for handle, label in zip(*axes.get_legend_handles_labels(), strict=True):
            named.setdefault(label, handle)
    labels = sorted(named, key=lambda label: (not label.startswith("θ"), label))
    if labels:
        columns = min(_LEGEND_COLUMNS, max(2, int(canvas.get_figwidth() / 1.15)))
        canvas.legend(
            [named[label] for label in labels], labels, loc="outside lower center", ncols=columns,
            title=remark or None, title_fontsize=7.0,
        )  # fmt: skip

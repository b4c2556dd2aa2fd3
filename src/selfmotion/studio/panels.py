"""The angle domain as panels of plain data: what is feasible of u along the path, and what bounds it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple
from weakref import WeakKeyDictionary

import numpy as np

from selfmotion._types import FloatArray, IntArray
from selfmotion.angles import TAU, nearest_turn
from selfmotion.arms import Cause, PlanarArm
from selfmotion.arms.protocols import u_period
from selfmotion.constrained import unconstrained
from selfmotion.domain import Event, Run, SampledDomain, angle_domain
from selfmotion.domain.holes import Hole, is_contact
from selfmotion.domain.sampled import LOOKS
from selfmotion.domain.strands import followed
from selfmotion.domain.strips import Strip, strips
from selfmotion.exchange.structure import sampled_lines, structure_lines
from selfmotion.paths.base import PLANE
from selfmotion.plot.curve_domain import order
from selfmotion.plot.domain import events_on
from selfmotion.plot.holes import contact_name, in_window, number_of
from selfmotion.plot.window import Window
from selfmotion.problem import Problem
from selfmotion.studio.problems import MOST_BREAKS
from selfmotion.studio.wire import finite, packed

_MARGIN = 0.06
_EVERYTHING = "domain.json of the command selfmotion domain"
_QUARTER = 0.5 * np.pi
_FINE, _COARSE = (160, 180), (96, 108)  # rows of u and columns of r of a field
_FEW_LOOKS, _FEW_ROUNDS = 48, 2  # along the path while something is dragged
_known: WeakKeyDictionary[Problem, dict[str, Any]] = WeakKeyDictionary()
_windows: WeakKeyDictionary[Problem, dict[int, Window]] = WeakKeyDictionary()


class Around(NamedTuple):
    """The curve about which the components of u are varied, one at a time.

    Attributes
    ----------
    r : array, shape (k,)
        Ascending.
    u : array, shape (k, n_u)
    branch : int
    """

    r: FloatArray
    u: FloatArray
    branch: int

    def at(self, r: FloatArray) -> FloatArray:
        """Return u at r (m,), shape (m, n_u)."""
        return np.stack([np.interp(r, self.r, column) for column in self.u.T], axis=-1)


def domain(problem: Problem, around: Around | None = None, settled: bool = True) -> dict[str, Any] | None:
    """Return the angle domain as panels.

    Parameters
    ----------
    problem : Problem
    around : Around, optional
        For more than one redundant degree: the curve about which one component at a time is varied; by default zeros on
        the first branch.
    settled : bool
        False while something is dragged: then fields are coarser.

    Returns
    -------
    dict or None
        None of an arm in space that is not settled: it would take too long.
    """
    if problem.arm.n_u > 1:
        return _by_component(problem, around, settled)
    if problem in _known:
        return _known[problem]
    if problem.arm.has_structure and len(problem.path.breaks) <= MOST_BREAKS:
        found = _exact(problem)
    elif problem.arm.has_structure or settled:
        found = _sampled(problem)
    else:
        return _sampled(problem, settled) if problem.arm.dimension == PLANE else None
    _known[problem] = found
    return found


def branch_window(problem: Problem, branch: int) -> Window:
    """Return the turn of u that the panel of a branch shows, for one redundant degree."""
    if problem.arm.has_structure and len(problem.path.breaks) <= MOST_BREAKS:
        return Window.around(strips(problem.structure, branch))
    if problem not in _windows:
        domain(problem)
    return _windows[problem].get(branch, Window(0.0))


def _exact(problem: Problem) -> dict[str, Any]:
    structure = problem.structure
    radii = problem.arm.radii() if isinstance(problem.arm, PlanarArm) else None
    shown = {branch: strips(structure, branch) for branch in problem.elbow_branches}
    if any(shown.values()):
        shown = {branch: found for branch, found in shown.items() if found}
    panels = [
        _panel(problem, branch, found, Window.around(found), events_on(structure.events, branch))
        for branch, found in shown.items()
    ]
    return {
        "kind": "exact",
        "panels": panels,
        "connected": structure.is_connected,
        "structure": structure_lines(structure, radii, _EVERYTHING),
    }


def _sampled(problem: Problem, settled: bool = True) -> dict[str, Any]:
    untold = _untold(problem)
    windows = _windows[problem] = {}
    if untold is not None:
        return {"kind": "sampled", "panels": [], "structure": [untold]}
    looked = (LOOKS,) if settled else (_FEW_LOOKS, _FEW_ROUNDS)
    found = SampledDomain(angle_domain(problem.arm, problem.path), problem.elbow_branches, *looked)
    panels = []
    for branch in problem.elbow_branches:
        shown, holes = found.strips(branch), found.holes(branch)
        if not (found.stretches(branch) or holes):
            continue
        if unconstrained(problem.arm).has_structure:  # where the window is does not depend on what stands around
            windows[branch] = Window.around([*shown, *(strip for hole in holes for strip in hole.strips)])
        panels.append(_panel(problem, branch, shown, windows.get(branch, Window(0.0)), holes=holes))
    # Without those of single postures only.
    panels = [panel for panel in panels if panel["strips"] or panel["holes"]] or panels
    return {"kind": "sampled", "panels": panels, "structure": sampled_lines(found)}


def _untold(problem: Problem) -> str | None:
    """Return why the angle domain of an arm with one redundant degree is not told, None if it is."""
    if u_period(problem.arm) != TAU:
        return "no angle domain: the redundancy parameter of this arm is a length"
    if not problem.arm.rigorous:
        return "no angle domain: the postures of this arm are sampled, which does not tell where there are none"
    return None


def _panel(
    problem: Problem, branch: int, shown: Sequence[Strip], window: Window, events: Sequence[Event] = (),
    component: int = 0, title: str | None = None, field: dict[str, Any] | None = None, holes: Sequence[Hole] = (),
) -> dict[str, Any]:  # fmt: skip
    """Return one panel of strips in their window."""
    names = problem.arm.branches
    parts = [(strip.r, low, high) for strip in shown for low, high in window.copies(strip) if (high > low).any()]
    edges = [(min(causes, key=order), r, u) for causes, r, u in window.boundary([s for s in shown if any(s.causes)])]
    edges = [edge for edge in edges if not is_contact(edge[0])]  # those are edges of holes
    values = [column for _, low, high in parts for column in (low, high)] + [u[np.isfinite(u)] for _, _, u in edges]
    told = [_hole(hole, window) for hole in holes]
    values += [column for hole in told for part in hole["strips"] for column in (part["low"], part["high"])]
    named = f"{names[branch]} elbow" if isinstance(unconstrained(problem.arm), PlanarArm) else names[branch]
    period = window.center - np.pi, window.center + np.pi
    return {
        "branch": branch,
        "component": component,
        "title": named if title is None else title,
        "range": _range(values, period),
        "period": list(period),
        "strips": [_strip(r, low, high) for r, low, high in parts],
        "holes": [{**hole, "strips": [_strip(**part) for part in hole["strips"]]} for hole in told],
        "edges": [{"r": packed(r), "u": packed(u), "cause": cause_object(cause)} for cause, r, u in edges],
        "events": [
            {"r": e.r, "u": float(window.wrapped(np.asarray(e.u))), "kind": e.kind, "text": e.text(names)}
            for e in events
        ],
        "field": field,
    }


def _strip(r: FloatArray, low: FloatArray, high: FloatArray, **more: Any) -> dict[str, Any]:
    return {"r": packed(r), "low": packed(low), "high": packed(high), **more}


def _hole(hole: Hole, window: Window) -> dict[str, Any]:
    """Return what an obstacle takes, with arrays: its number from 0, None if it is none, and how it is called."""
    pieces, at = in_window(hole, window)
    return {
        "by": hole.by,
        "number": number_of(hole.by),
        "text": hole.cause,
        "short": contact_name(hole.cause),
        "at": list(at),
        "size": hole.size,
        "strips": [{"r": r, "low": low, "high": high, "ends": ends} for r, low, high, ends in pieces],
    }


def _range(values: list[FloatArray], period: tuple[float, float]) -> list[float]:
    """Return what holds all values, with a margin."""
    known = np.concatenate(values) if values else np.empty(0)
    if not len(known):
        return list(period)
    margin = _MARGIN * max(float(np.ptp(known)), 1e-3)
    return [float(known.min()) - margin, float(known.max()) + margin]


def cause_object(cause: Cause) -> dict[str, Any]:
    """Return why an edge is one as plain data; joints from 0, −1 for none."""
    return {"kind": cause.kind, "joint": cause.joint, "value": finite(cause.value), "text": str(cause)}


def _by_component(problem: Problem, around: Around | None, settled: bool) -> dict[str, Any]:
    arm = problem.arm
    if around is None:
        around = Around(np.array([0.0, 1.0]), np.zeros((2, arm.n_u)), problem.elbow_branches[0])
    if not isinstance(arm, PlanarArm):
        return {"kind": "component", "panels": [], "structure": []}
    rows, columns = _FINE if settled else _COARSE
    r = np.linspace(0.0, 1.0, columns)
    x, u = problem.path(r), around.at(r)
    panels = []
    for j in range(arm.n_u):
        window = Window(_QUARTER * float(np.rint(np.mean(u[:, j]) / _QUARTER)))
        field = component_field(arm, x, u, around.branch, j, window, rows)
        shown = followed(r, field.runs())
        told = {
            "r": [0.0, 1.0],
            "u": [float(field.u[0]), float(field.u[-1])],
            "margin": packed(field.margin, "f4"),
        }
        title = f"u{j + 1}: direction of link {j + 3}"
        panel = _panel(problem, around.branch, shown, window, component=j, title=title, field=told)
        panel["range"] = list(panel["period"])
        panels.append(panel)
    return {"kind": "component", "panels": panels, "structure": []}


class Field(NamedTuple):
    """How far one component of u is from the nearest constraint, along the path.

    Attributes
    ----------
    u : array, shape (m,)
        Over one turn, both ends of it included.
    margin : array, shape (m, k)
        Least margin [rad]; that of reach in parts of what the arm reaches. Negative where infeasible.
    least : array of int, shape (m, k)
        Which constraint has it.
    causes : tuple of Cause
        What constraints are.
    """

    u: FloatArray
    margin: FloatArray
    least: IntArray
    causes: tuple[Cause, ...]

    def runs(self) -> list[list[Run]]:
        """Return the feasible intervals of each column, ends interpolated, with the constraint that is least there."""
        return [self._column(self.margin[:-1, k], self.least[:-1, k]) for k in range(self.margin.shape[1])]

    def _column(self, margin: FloatArray, least: IntArray) -> list[Run]:
        inside, step = margin >= 0.0, self.u[1] - self.u[0]
        if inside.all():
            return [Run(float(self.u[0]), float(self.u[0]) + TAU, ((), ()))]
        following, count = np.roll(inside, -1), len(margin)
        starts, ends = np.flatnonzero(~inside & following), np.flatnonzero(inside & ~following)
        if len(ends) and len(starts) and ends[0] <= starts[0]:
            ends = np.roll(ends, -1)
        found = []
        for a, b in zip(starts.tolist(), ends.tolist(), strict=True):
            low, high = self._crossing(margin, a, step), self._crossing(margin, b, step)
            causes = (self.causes[least[a]],), (self.causes[least[(b + 1) % count]],)
            found.append(Run(low, high if high >= low else high + TAU, causes))
        return found

    def _crossing(self, margin: FloatArray, k: int, step: float) -> float:
        """Return where the margin is zero between row k and the next."""
        one, other = float(margin[k]), float(margin[(k + 1) % len(margin)])
        return float(self.u[k]) + step * (one / (one - other) if one != other else 0.5)


def component_field(
    arm: PlanarArm, x: FloatArray, u: FloatArray, branch: int, component: int, window: Window, rows: int
) -> Field:
    """Return how far postures are from their constraints where one component of u is varied and the others stay.

    Parameters
    ----------
    arm : PlanarArm
    x : array, shape (k, 2)
        Points along the path.
    u : array, shape (k, n_u)
        The redundancy vector there.
    branch, component : int
    window : Window
        The turn of the component that is looked at.
    rows : int
        How many values of it.
    """
    values = np.linspace(window.center - np.pi, window.center + np.pi, rows)
    every = np.repeat(u[None], rows, axis=0)
    every[..., component] = values[:, None]
    q, reach = arm.solve_with_margin(x, every, branch)
    limited = np.flatnonzero(np.isfinite(arm.limits.lower) & np.isfinite(arm.limits.upper))
    lower, upper = arm.limits.lower[limited], arm.limits.upper[limited]
    near = nearest_turn(q[..., limited], 0.5 * (lower + upper))
    stretched = np.abs(q[..., 1]) < _QUARTER
    scaled = reach / arm.reach
    parts = [np.where(stretched, scaled, np.inf), np.where(stretched, np.inf, scaled)]
    margins = np.concatenate([np.stack(parts, axis=-1), near - lower, upper - near], axis=-1)
    causes = [Cause("fold", 1, 0.0), Cause("fold", 1, np.pi)]
    causes += [Cause("lower limit", int(j), float(arm.limits.lower[j])) for j in limited]
    causes += [Cause("upper limit", int(j), float(arm.limits.upper[j])) for j in limited]
    least = margins.argmin(axis=-1)
    margin = np.take_along_axis(margins, least[..., None], axis=-1)[..., 0]
    return Field(values, margin, least, tuple(causes))


class PanelChart:
    """The u of one panel as ordinates of a tube, cut where its window ends."""

    def __init__(self, window: Window) -> None:
        self.window = window

    def ordinate(self, r: FloatArray, u: FloatArray, branch: IntArray) -> FloatArray:
        """Return u in the window, shape (k,)."""
        return self.window.wrapped(u)

    def cut(self, ends: FloatArray) -> FloatArray:
        """Return intervals (k, 2) the short way round, in two where that leads over the window's end."""
        low, high = ends.min(axis=1), ends.max(axis=1)
        torn = high - low > np.pi
        bottom, top = self.window.center - np.pi, self.window.center + np.pi
        pieces = [np.stack([low, high], axis=1)[~torn]]
        pieces.append(np.stack([np.full(torn.sum(), bottom), low[torn]], axis=1))
        pieces.append(np.stack([high[torn], np.full(torn.sum(), top)], axis=1))
        return np.vstack(pieces)

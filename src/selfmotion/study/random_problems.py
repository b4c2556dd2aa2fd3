"""Random planar problems, each from its seed alone: to compare planners on, and to try to refute lower bounds with.

Limits are laid around a posture that reaches the middle of the path, and paths are shrunk into reach, so that most of
the problems have motions; some have none, and nothing says which, but for what `reachable_problem` draws.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.random import Generator

from selfmotion.angles import TAU
from selfmotion.arms import PlanarArm
from selfmotion.domain import AngleDomain, angle_domain
from selfmotion.errors import InvalidInputError
from selfmotion.optimizers import INFEASIBLE
from selfmotion.optimizers.base import DEFAULT_BOUNDS
from selfmotion.paths import Bezier, Circle, Line, Path, Waypoints
from selfmotion.planners import PlanarCandidates
from selfmotion.problem import Problem
from selfmotion.profiles import SinusoidProfile

OBJECTIVES = ("joint_travel",) * 7 + ("l1", "l2", "l2")
ELBOWS = ("any", "any", "positive", "negative")
PATHS = ("line", "bezier", "bezier", "circle", "linear", "spline")
_TRIES = 30
_MOST_DRAWN = 200  # problems, until one is reachable
_LOOKS = np.linspace(0.0, 1.0, 49)
_LEAST_LINKS, _MOST_LINKS = 3, 12
_SEED_AMPLITUDE = 0.4
_FREQUENCIES = 1501  # that are tried
_SAMPLES = 240  # 16 per cycle of the fastest


def random_problem(seed: int) -> Problem | None:
    """Return a problem with one redundant degree and anything else; None where nothing reachable was drawn.

    Three links, or four of which the last keeps its direction; equal, similar and extreme lengths; limits, starts and
    ends, weights, closed motions; any objective.
    """
    rng = np.random.default_rng([seed, 4711])
    for _ in range(_TRIES):
        arm = _arm(rng)
        path = _path(rng, arm)
        limited = _limited(rng, arm, path)
        if limited is None:
            continue
        try:
            problem = _problem(rng, limited, path)
        except InvalidInputError:
            continue
        if problem is not None:
            return problem
    return None


def reachable_problem(seed: int) -> Problem:
    """Return a problem in joint travel, not cyclic, of which the structure of its domain says that a motion exists."""
    for k in range(_MOST_DRAWN):
        problem = random_problem(1_000_000 + _MOST_DRAWN * seed + k)
        if problem is None or problem.cyclic or problem.objective.kind != "joint_travel":
            continue
        if leads_on(problem):
            return problem
    raise AssertionError("no such problem was drawn")


def sinusoid_problem(seed: int) -> Problem:
    """Return a reachable problem with a start and without an end that a sinusoid of the seed's family solves."""
    for k in range(_MOST_DRAWN):
        drawn = reachable_problem(_MOST_DRAWN * seed + k)
        if drawn.start is None or drawn.end is not None:
            continue
        start = {"u": drawn.start.u.tolist()}
        problem = Problem(
            drawn.arm, drawn.path, start=start, elbow=drawn.elbow, weights=drawn.weights, samples=_SAMPLES
        )
        if follows_a_sinusoid(problem):
            return problem
    raise AssertionError("no such problem was drawn")


def follows_a_sinusoid(problem: Problem) -> bool:
    """Return whether a sinusoid (22) from the problem's start stays inside the angle domain at every sample.

    Of those with the seed's amplitude 0.4 and frequencies in its box [0, 15] some thousand are tried.
    """
    assert problem.start is not None
    profile = SinusoidProfile(problem.start.u, [_SEED_AMPLITUDE])
    frequencies = np.linspace(*DEFAULT_BOUNDS, _FREQUENCIES)[:, None]
    judges = (PlanarCandidates(problem, profile, branch) for branch in problem.start_branches)
    return any((judge(frequencies) < INFEASIBLE).any() for judge in judges)


def many_link_problem(seed: int) -> Problem:
    """Return a problem of an arm with 3 to 12 links, from a posture given at the start, limits around it.

    A path that is short for the arm begins where that posture has its tool. Whether a motion exists is not known.
    """
    rng = np.random.default_rng([seed, 4712])
    while True:
        links = rng.uniform(0.3, 2.0, int(rng.integers(_LEAST_LINKS, _MOST_LINKS + 1)))
        q = rng.uniform(-0.9, 0.9, len(links)) * np.pi * np.array([1.0, *[0.6] * (len(links) - 1)])
        spans = rng.uniform(1.5, 6.0, len(links))
        low = q - spans * rng.uniform(0.25, 0.75, len(links))
        limits = [None if rng.random() < 0.3 else (a, a + span) for a, span in zip(low, spans, strict=True)]
        arm = PlanarArm(links, limits)
        first = arm.forward(q)
        points = first + np.cumsum(rng.uniform(-0.15, 0.15, (5, 2)), axis=0) * arm.reach
        path = Bezier(np.vstack([first, points]))
        if arm.shortfall(path(_LOOKS)).max() < -1e-2 * arm.reach:
            return Problem(arm, path, start={"q": q.tolist()})


KINDS: dict[str, Callable[[int], Problem | None]] = {
    "random": random_problem,
    "reachable": reachable_problem,
    "sinusoid": sinusoid_problem,
    "nR": many_link_problem,
}
"""Every generator by the ``kind`` of a study file."""


def leads_on(problem: Problem) -> bool:
    """Return whether the structure says that a motion leads from the start, if one is given, to the end."""
    structure = problem.structure
    first = {k for k, sheet in enumerate(structure.sheets) if sheet.r[0] <= 0.0} & _sheets_of(problem, "start", 0.0)
    last = {k for k, sheet in enumerate(structure.sheets) if sheet.r[1] >= 1.0} & _sheets_of(problem, "end", 1.0)
    return structure.is_connected and any(last & structure.reachable[k] for k in first)


def _sheets_of(problem: Problem, name: str, r: float) -> set[int]:
    structure, posture = problem.structure, getattr(problem, name)
    if posture is None:
        return set(range(len(structure.sheets)))
    branches = problem.elbow_branches
    return {sheet for branch in branches for sheet in structure.sheet_at(r, float(posture.u[0]), branch)}


def _arm(rng: Generator) -> PlanarArm:
    """Return an arm without limits, of equal, similar, common or extreme lengths, sometimes with a fourth link."""
    kind = rng.choice(["equal", "two equal", "similar", "common", "extreme"], p=[0.15, 0.15, 0.2, 0.35, 0.15])
    links = {
        "equal": np.ones(3),
        "two equal": rng.permutation(np.array([1.0, 1.0, rng.uniform(0.2, 1.8)])),
        "similar": rng.uniform(0.9, 1.1, 3),
        "common": rng.uniform(0.3, 2.0, 3),
        "extreme": 10.0 ** rng.uniform(-1.0, 1.0, 3),
    }[str(kind)]
    links = links * 10.0 ** rng.uniform(-1.0, 2.0)
    if rng.random() < 0.2:
        return PlanarArm([*links, links.mean() * rng.uniform(0.1, 1.0)], direction=rng.uniform(-np.pi, np.pi))
    return PlanarArm(links)


def _path(rng: Generator, arm: PlanarArm) -> Path:
    """Return a path about a point in reach, made smaller until most of the time it is in reach altogether."""
    center, inner, outer = arm.annulus
    angle, radius = rng.uniform(0, TAU), inner + (outer - inner) * np.sqrt(rng.uniform(0.03, 0.85))
    middle = center + radius * np.array([np.cos(angle), np.sin(angle)])
    size, kind = outer * rng.uniform(0.1, 0.9), str(rng.choice(PATHS))
    offsets = rng.uniform(-1.0, 1.0, (int(rng.integers(3, 7)), 2))
    turn, forgive = rng.uniform(0, TAU), rng.random() < 0.07
    while True:
        points = middle + size * offsets
        makers: dict[str, Callable[[], Path]] = {
            "line": lambda: Line(points[0], points[1]),  # noqa: B023
            "bezier": lambda: Bezier(points),  # noqa: B023
            "circle": lambda: Circle(middle, 0.6 * size, start_angle=turn),  # noqa: B023
            "linear": lambda: Waypoints(points, "linear"),  # noqa: B023
            "spline": lambda: Waypoints(points, "spline"),  # noqa: B023
        }
        path = makers[kind]()
        if forgive or arm.shortfall(path(_LOOKS)).max() < -1e-3 * outer or size < 0.02 * outer:
            return path
        size *= 0.75


def _limited(rng: Generator, arm: PlanarArm, path: Path) -> PlanarArm | None:
    """Return the arm with limits about a posture that reaches the middle of the path; None if none was found."""
    x = path(0.5)
    for _ in range(40):
        q, ok = arm.solve(x, [rng.uniform(-np.pi, np.pi)], int(rng.integers(0, 2)))
        if ok:
            break
    else:
        return None
    if rng.random() < 0.25:
        return arm
    spans = {"tight": (0.6, 2.0), "common": (2.0, 5.5), "wide": (6.4, 9.0)}
    limits: list[Any] = []
    for angle in q:
        kind = str(rng.choice(["none", "tight", "common", "wide", "one-sided"], p=[0.2, 0.2, 0.38, 0.17, 0.05]))
        if kind == "none":
            limits.append(None)
            continue
        span = rng.uniform(*spans.get(kind, (2.0, 6.0)))
        low = angle - span * rng.uniform(0.15, 0.85)
        limits.append((low, None if kind == "one-sided" else low + span))
    return PlanarArm(arm.links, limits, arm.direction)


def _problem(rng: Generator, arm: PlanarArm, path: Path) -> Problem | None:
    """Return the problem with everything else; None if it is clear from some looks that a posture is missing."""
    elbow = str(rng.choice(ELBOWS))
    branches = [0, 1] if elbow == "any" else [["positive", "negative"].index(elbow)]
    domain = angle_domain(arm, path)
    empty = domain.is_empty(_LOOKS, branches)
    if empty.any() and not (rng.random() < 0.03 and not empty[[0, -1]].any()):
        return None
    options: dict[str, Any] = {"elbow": elbow, "objective": str(rng.choice(OBJECTIVES))}
    if rng.random() < 0.45:
        options["start"] = {"u": _some_u(rng, domain, 0.0, branches)}
    if rng.random() < 0.12:
        options["end"] = {"u": _some_u(rng, domain, 1.0, branches)}
    if rng.random() < 0.25:
        options["weights"] = rng.uniform(0.2, 3.0, arm.n)
    if path.is_closed and rng.random() < 0.3:
        options["cyclic"] = str(rng.choice(["exact", "modulo"]))
        options.pop("end", None)
    return Problem(arm, path, **options)


def _some_u(rng: Generator, domain: AngleDomain, r: float, branches: list[int]) -> list[float]:
    """Return a feasible redundancy parameter of one of the branches, away from the ends of its interval."""
    intervals = [(low, high) for branch in branches for low, high in domain(r, branch) if high > low]
    low, high = intervals[int(rng.integers(0, len(intervals)))]
    return [low + (high - low) * rng.uniform(0.03, 0.97)]

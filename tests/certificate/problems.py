"""Random planar problems with one redundant degree, each from its seed alone, to try to refute lower bounds on.

Limits are laid around a posture that reaches the middle of the path, and paths are shrunk into reach, so that most of
the problems have motions; some have none, and nothing says which.
"""

import numpy as np

import selfmotion as sm
from selfmotion.errors import InvalidInputError

TAU = 2 * np.pi
OBJECTIVES = ("joint_travel",) * 7 + ("l1", "l2", "l2")
ELBOWS = ("any", "any", "positive", "negative")
PATHS = ("line", "bezier", "bezier", "circle", "linear", "spline")
SEED_PATH = [[50, -10], [85, 30], [50, 50], [60, -10], [58, 30], [70, -10]]
_TRIES = 30
_LOOKS = np.linspace(0.0, 1.0, 49)


def seed_problem(elbow="positive", start=0.3):
    """The 3R case of the paper, whose best costs are known: 4.88945, free start 4.65015581, negative 4.31504555."""
    arm = sm.PlanarArm([30, 30, 20], [None, (0, np.pi) if elbow == "positive" else None, None])
    return sm.Problem(arm, sm.Bezier(SEED_PATH), start=None if start is None else {"u": [start]}, elbow=elbow)


def random_problem(seed):
    """A problem, or None where nothing reachable was drawn."""
    rng = np.random.default_rng([seed, 4711])
    for _ in range(_TRIES):
        arm = _arm(rng)
        path = _path(rng, arm)
        arm = _limited(rng, arm, path)
        if arm is None:
            continue
        try:
            problem = _problem(rng, arm, path)
        except InvalidInputError:
            continue
        if problem is not None:
            return problem
    return None


def reachable_problem(seed):
    """A problem in joint travel of which the structure of its angle domain says that a motion exists."""
    for k in range(200):
        problem = random_problem(1_000_000 + 200 * seed + k)
        if problem is None or problem.cyclic or problem.objective.kind != "joint_travel":
            continue
        if leads_on(problem):
            return problem
    raise AssertionError("no such problem was drawn")


def leads_on(problem):
    """Whether the structure says that a motion leads from the start, if one is given, to the end."""
    structure = problem.structure
    first = {k for k, sheet in enumerate(structure.sheets) if sheet.r[0] <= 0.0} & _sheets_of(problem, "start", 0.0)
    last = {k for k, sheet in enumerate(structure.sheets) if sheet.r[1] >= 1.0} & _sheets_of(problem, "end", 1.0)
    return structure.is_connected and any(last & structure.reachable[k] for k in first)


def _sheets_of(problem, name, r):
    structure, posture = problem.structure, getattr(problem, name)
    if posture is None:
        return set(range(len(structure.sheets)))
    branches = problem.elbow_branches
    return {sheet for branch in branches for sheet in structure.sheet_at(r, float(posture.u[0]), branch)}


def _arm(rng):
    """An arm without limits, of equal, similar, common or extreme lengths, sometimes with a fourth link."""
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
        return sm.PlanarArm([*links, links.mean() * rng.uniform(0.1, 1.0)], direction=rng.uniform(-np.pi, np.pi))
    return sm.PlanarArm(links)


def _path(rng, arm):
    """A path about a point in reach, made smaller until most of the time it is in reach altogether."""
    center, inner, outer = arm.annulus
    angle, radius = rng.uniform(0, TAU), inner + (outer - inner) * np.sqrt(rng.uniform(0.03, 0.85))
    middle = center + radius * np.array([np.cos(angle), np.sin(angle)])
    size, kind = outer * rng.uniform(0.1, 0.9), str(rng.choice(PATHS))
    offsets = rng.uniform(-1.0, 1.0, (int(rng.integers(3, 7)), 2))
    turn, forgive = rng.uniform(0, TAU), rng.random() < 0.07
    while True:
        points = middle + size * offsets
        path = {
            "line": lambda: sm.Line(points[0], points[1]),  # noqa: B023
            "bezier": lambda: sm.Bezier(points),  # noqa: B023
            "circle": lambda: sm.Circle(middle, 0.6 * size, start_angle=turn),  # noqa: B023
            "linear": lambda: sm.Waypoints(points, "linear"),  # noqa: B023
            "spline": lambda: sm.Waypoints(points, "spline"),  # noqa: B023
        }[kind]()
        if forgive or arm.shortfall(path(_LOOKS)).max() < -1e-3 * outer or size < 0.02 * outer:
            return path
        size *= 0.75


def _limited(rng, arm, path):
    """The arm with limits about a posture that reaches the middle of the path; None if none was found."""
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
    limits = []
    for angle in q:
        kind = str(rng.choice(["none", "tight", "common", "wide", "one-sided"], p=[0.2, 0.2, 0.38, 0.17, 0.05]))
        if kind == "none":
            limits.append(None)
            continue
        span = rng.uniform(*spans.get(kind, (2.0, 6.0)))
        low = angle - span * rng.uniform(0.15, 0.85)
        limits.append((low, None if kind == "one-sided" else low + span))
    return sm.PlanarArm(arm.links, limits, arm.direction)


def _problem(rng, arm, path):
    """The problem with everything else; None if it is clear from some looks that a posture is missing."""
    elbow = str(rng.choice(ELBOWS))
    branches = [0, 1] if elbow == "any" else [["positive", "negative"].index(elbow)]
    domain = sm.angle_domain(arm, path)
    empty = domain.is_empty(_LOOKS, branches)
    if empty.any() and not (rng.random() < 0.03 and not empty[[0, -1]].any()):
        return None
    options = {"elbow": elbow, "objective": str(rng.choice(OBJECTIVES))}
    if rng.random() < 0.45:
        options["start"] = {"u": _some_u(rng, domain, 0.0, branches)}
    if rng.random() < 0.12:
        options["end"] = {"u": _some_u(rng, domain, 1.0, branches)}
    if rng.random() < 0.25:
        options["weights"] = rng.uniform(0.2, 3.0, arm.n)
    if path.is_closed and rng.random() < 0.3:
        options["cyclic"] = str(rng.choice(["exact", "modulo"]))
        options.pop("end", None)
    return sm.Problem(arm, path, **options)


def _some_u(rng, domain, r, branches):
    """A feasible redundancy parameter of one of the branches, away from the ends of its interval."""
    intervals = [(low, high) for branch in branches for low, high in domain(r, branch) if high > low]
    low, high = intervals[int(rng.integers(0, len(intervals)))]
    return [low + (high - low) * rng.uniform(0.03, 0.97)]

"""Whether a continuous motion exists, by dense sampling: the oracle for proofs that there is none.

At many poses the self-motion is sampled along its loops, by inverse kinematics that shares no formula with the
package; samples inside the limits that follow each other are joined, and so are samples of neighbouring poses. What
can be reached without going back along the path is then flooded. Where parts begin, end, join or move too fast, poses
are put in between.

A sampled answer is no proof: gaps narrower than the sampling are jumped and passages narrower than it are missed. The
line of postures whose wrist is on the base, which equal links l1 = l2 have, is not sampled.
"""

from dataclasses import dataclass
from itertools import pairwise, product

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

import selfmotion as sm
from oracle import Arms, as_complex

TAU = 2 * np.pi
# Neighbouring samples are less than this apart unless their turns differ [rad].
_NEIGHBOURS = 1.5
# Where the number of loops changes samples this near to each other are joined, in parts of a loop's largest step.
_NEAR = 2.0
# The sample of a given posture is not farther from it than this [rad].
_GIVEN = 0.1
# How many places between two poses are asked how their loops are made.
_BETWEEN = 9
# How often the way between two poses is halved where parts seem to begin or end.
_DEPTH = 6


@dataclass
class Pose:
    """The self-motion at one pose, sampled: two loops of m samples, each with c numbers of turns.

    Attributes
    ----------
    q : array, shape (2, m, c, n)
    ok : array of bool, shape (2, m, c)
        Which postures are allowed.
    part : array of int, shape (2, m, c)
        The connected part that each allowed posture is in; −1 for others.
    kind : int
        How the loops are made.
    real : array of bool, shape (n,)
        Joints that are real numbers; the others are angles modulo 2π.
    """

    r: float
    q: np.ndarray
    ok: np.ndarray
    part: np.ndarray
    kind: int
    real: np.ndarray

    @property
    def parts(self):
        return set(self.part[self.ok].tolist())

    def embedded(self):
        """The allowed postures as points whose distance is that of the postures when they are near."""
        q = self.q[self.ok]
        return np.concatenate([q[:, self.real], np.cos(q[:, ~self.real]), np.sin(q[:, ~self.real])], axis=-1)

    @property
    def largest_step(self):
        """A step between neighbouring samples that most do not exceed."""
        steps = _apart(self.q[:, :, 0], np.roll(self.q[:, :, 0], -1, axis=1), self.real)
        return float(np.quantile(steps[self.ok.any(axis=-1)], 0.95))


def _apart(p, q, real):
    """The largest joint step between postures; limited joints are real numbers, free ones angles."""
    off = np.abs(p - q)
    return np.where(real, off, np.abs(off - TAU * np.rint(off / TAU))).max(axis=-1)


def sample(problem, r, n_u, slack=0.0, allowed=None):
    """Sample the self-motion at poses r, loop by loop, folds approached as sines do so that steps stay even.

    In v = u − ψ the wrist is in reach for va ≤ |v| ≤ vb. Where neither 0 nor π is cut off each elbow is a loop of its
    own; else both elbows are two sides of the same loop, v = mid + half·sin t with the elbow's sign that of cos t.
    Limits give by `slack` [rad]; so does `allowed`, which says of postures (k, n) whether anything else forbids them.
    """
    arm, r = problem.arm, np.asarray(r)
    x = as_complex(problem.path(r))
    ik = [Arms([arm], [sign]) for sign in (1, -1)]
    target = x - ik[0].shift
    inner, outer, kind = _cut_off(arm, target)
    va, vb = np.arccos(np.clip([inner, outer], -1, 1))
    t = (np.arange(n_u) + 0.5) * TAU / n_u
    v, sign = np.empty((2, len(r), 2, n_u))
    v[:], sign[:] = t - np.pi, np.array([[1], [-1]])
    for loop, side in enumerate((1, -1)):
        middle = np.choose(kind, [0 * va, 0 * va, np.pi + 0 * va, side * 0.5 * (va + vb)])
        half = np.choose(kind, [vb, vb, np.pi - va, 0.5 * (vb - va)])
        v[kind > 0, loop] = (middle[:, None] + half[:, None] * np.sin(t))[kind > 0]
        sign[kind > 0, loop] = np.sign(np.cos(t))
    u = (v + np.angle(target)[:, None, None]).reshape(len(r), -1)
    both = [arms.joints(x, u)[0] for arms in ik]
    q = np.where(sign.reshape(len(r), -1, 1) > 0, *both).reshape(len(r), 2, n_u, 4)[..., : arm.n]
    exists = ((outer <= 1) & (inner >= -1))[:, None, None] & np.ones((2, n_u), bool)
    exists[(kind == 1) | (kind == 2), 1] = False
    exists &= np.isin(sign, [1 - 2 * branch for branch in problem.elbow_branches])
    q, ok, real = _with_turns(arm.limits, slack, q, exists)
    if allowed is not None:
        ok[ok] = allowed(q[ok], slack)
    part = _parts(q, ok, real)
    return [Pose(*pose, real) for pose in zip(r, q, ok, part, kind, strict=True)]


def _cut_off(arm, target):
    """The cosines of va and vb, out of [−1, 1] where the wrist is in reach; and which of v = 0 and π is cut off."""
    l1, l2, l3 = arm.links[:3]
    radius = np.maximum(np.abs(target), 1e-12)
    inner, outer = [(radius**2 + l3**2 - wrist**2) / (2 * radius * l3) for wrist in (abs(l1 - l2), l1 + l2)]
    return inner, outer, 2 * (inner < 1) + (outer > -1)


def _with_turns(limits, slack, q, exists):
    """Add every number of turns that the limits allow; a joint limited on one side only is taken as free."""
    real = np.isfinite(limits.lower) & np.isfinite(limits.upper)
    low, high = np.where(real, limits.lower - slack, -np.pi), np.where(real, limits.upper + slack, np.pi)
    turns = [
        range(int(np.ceil((a - np.pi) / TAU)), int(np.floor((b + np.pi) / TAU)) + 1) if counted else (0,)
        for a, b, counted in zip(low, high, real, strict=True)
    ]
    q = np.where(real, np.angle(np.exp(1j * q)), q)
    lifted = q[..., None, :] + TAU * np.array(list(product(*turns))).reshape(-1, len(real))
    ok = exists[..., None] & ((lifted >= low) & (lifted <= high) | ~real).all(axis=-1)
    return lifted, ok, real


def _parts(q, ok, real):
    """Number the connected parts of all poses, (k, 2, m, c); −1 where a posture is not allowed."""
    number = np.arange(ok.size).reshape(ok.shape)
    following, next_q, next_ok = (np.roll(array, -1, axis=2) for array in (number, q, ok))
    rows, columns = _linked(q, next_q, ok, next_ok, number, following, real)
    graph = coo_matrix((np.ones(len(rows), bool), (rows, columns)), shape=(ok.size, ok.size))
    return np.where(ok, connected_components(graph, directed=False)[1].reshape(ok.shape), -1)


def _linked(p, q, ok_p, ok_q, name_p, name_q, real):
    """Pairs of names of allowed postures, sample by sample, whose turns fit."""
    pairs = [(np.empty(0, int), np.empty(0, int))]
    for one, two in product(range(ok_p.shape[-1]), repeat=2):
        linked = ok_p[..., one] & ok_q[..., two]
        linked &= _apart(p[..., one, :], q[..., two, :], real) < _NEIGHBOURS
        pairs.append((name_p[..., one][linked], name_q[..., two][linked]))
    return tuple(np.concatenate(ends) for ends in zip(*pairs, strict=True))


def _steps(one, two):
    """Pairs of parts of neighbouring poses that a short step joins."""
    if one.kind == two.kind:
        return _linked(one.q, two.q, one.ok, two.ok, one.part, two.part, one.real)
    if not (one.ok.any() and two.ok.any()):
        return np.empty(0, int), np.empty(0, int)
    # The loops join or part in between: nearness in joint space decides.
    near = _NEAR * max(one.largest_step, two.largest_step)
    pairs = []
    for here, there, order in ((one, two, 1), (two, one, -1)):
        distance, nearest = cKDTree(there.embedded()).query(here.embedded())
        pairs.append((here.part[here.ok][distance < near], there.part[there.ok][nearest[distance < near]])[::order])
    return tuple(np.concatenate(ends) for ends in zip(*pairs, strict=True))


class _Blocked(Exception):
    """Nothing that was reached goes on from here."""


class _Flood:
    """What can be reached along the path, pose by pose."""

    def __init__(self, problem, poses_at):
        self.problem, self.poses_at = problem, poses_at

    def onward(self, one, two, reached, depth=_DEPTH):
        """The parts of pose `two` that a motion gets to from the `reached` ones of pose `one`."""
        before, after = _steps(one, two)
        settled = self._of_one_kind(one, two) and reached <= set(before.tolist()) and two.parts <= set(after.tolist())
        if not settled and depth > 0:
            (middle,) = self.poses_at([0.5 * (one.r + two.r)])
            return self.onward(middle, two, self.onward(one, middle, reached, depth - 1), depth - 1)
        found = set(after[np.isin(before, list(reached))].tolist())
        if not found:
            raise _Blocked(0.5 * (one.r + two.r))
        return found

    def _of_one_kind(self, one, two):
        """Whether the loops are made alike all the way; where not, samples of the same number do not correspond."""
        arm, x = self.problem.arm, as_complex(self.problem.path(np.linspace(one.r, two.r, _BETWEEN)))
        return bool((_cut_off(arm, x - Arms([arm], [1]).shift)[2] == one.kind).all())


def brute_force_connected(problem, n_r=200, n_u=400, slack=0.0):
    """Whether a motion leads from r = 0 to r = 1 inside the limits, r never decreasing, as far as samples tell.

    Parameters
    ----------
    problem : Problem
        Of a planar arm with one redundant degree. Given ends are the samples nearest to them.
    n_r, n_u : int
        Parts of the path and of each loop of the self-motion.
    slack : float
        By how much joint limits give [rad]. An answer that slack of both signs leaves as it is does not hang on the
        sampling.

    Returns
    -------
    connected : bool
    r_blocked : float or None
        Where the motions that get farthest end.
    """
    return flood(problem, sample(problem, np.linspace(0.0, 1.0, n_r + 1), n_u, slack), n_u, slack)


def flood(problem, poses, n_u, slack=0.0, poses_at=None, allowed=None):
    """Flood what can be reached through sampled poses; see `brute_force_connected`.

    What is in between is sampled by `poses_at` if it is given; `allowed` is that of `sample`.
    """
    reached = given_parts(problem, problem.start, poses[0], slack, allowed)
    if not reached:
        return False, 0.0
    search = _Flood(problem, poses_at or (lambda r: sample(problem, r, n_u, slack)))
    try:
        for one, two in pairwise(poses):
            reached = search.onward(one, two, reached)
    except _Blocked as place:
        return False, float(place.args[0])
    return (True, None) if reached & given_parts(problem, problem.end, poses[-1], slack, allowed) else (False, 1.0)


def given_parts(problem, posture, pose, slack, allowed):
    """The parts that a motion may start from or end in: those of the samples nearest to what is given and allowed."""
    if posture is None:
        return pose.parts
    found = set()
    for exact in _exactly(problem, posture, pose.r, slack, allowed):
        off = _apart(pose.q, exact, pose.real)
        found |= set(pose.part[pose.ok & (off <= off[pose.ok].min(initial=_GIVEN) + 1e-9)].tolist())
    return found


def _exactly(problem, posture, r, slack, allowed):
    """The postures (k, n) that are given, u with both elbows and every number of turns, and allowed."""
    limits = problem.arm.limits
    if posture.q is not None:
        q, ok = posture.q[None], (limits.excess(posture.q) <= slack).all(keepdims=True)
    else:
        both = Arms([problem.arm] * 2, [1, -1])
        x = as_complex(problem.path(np.full(2, r)))
        q, reach = both.joints(x, np.broadcast_to(posture.u, (2, 1)))
        q, ok, _ = _with_turns(limits, slack, q[:, 0, : problem.arm.n], (reach[:, 0] >= 0).all(axis=-1))
        q, ok = q[ok], ok[ok]
    if allowed is not None:
        ok[ok] = allowed(q[ok], slack)
    return q[ok]


def limit_cut_problem(seed):
    """A 3R problem whose tight limits cut the self-motion: reachable everywhere, yet blocked if the seed is odd.

    So a coarse sampling says, at least; it errs about once in three hundred problems. The path leads from near one
    corner of the limits to near the opposite one, and sometimes back.
    """
    rng = np.random.default_rng(seed)
    while True:
        middle, half = rng.uniform(-0.2, 0.2, 3), rng.uniform(1.1, 2.3, 3)
        limits = [*zip(middle - half, middle + half, strict=True)]
        joint, special = rng.integers(0, 3), rng.integers(0, 8)
        if special == 0:
            middle[joint], half[joint], limits[joint] = 0.0, np.pi, None
        elif special == 1:
            half[joint] = rng.uniform(np.pi, 5.0)
            limits[joint] = (middle[joint] - half[joint], middle[joint] + half[joint])
        arm = sm.PlanarArm(rng.uniform(0.5, 1.5, 3), limits)
        side = np.array([[1], [-1], [1]])[: rng.choice([2, 2, 3])]
        points = arm.forward(middle + half * side * rng.uniform(0.4, 1.0, (len(side), 3)))
        problem = sm.Problem(arm, sm.Line(*points) if len(points) == 2 else sm.Bezier(points))
        poses = sample(problem, np.linspace(0.0, 1.0, 61), 240)
        if all(pose.ok.any() for pose in poses) and flood(problem, poses, 240)[0] == (seed % 2 == 0):
            return problem

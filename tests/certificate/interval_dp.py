"""A lower bound on the cost of every motion by a road so plain that it can be believed: boxes of joints, and gaps.

The path is cut into slices. At each slice boxes of joint angles hold every posture that the joint limits allow: the
circle of u is cut into small arcs, and interval arithmetic encloses the joints over each arc, outward rounded. A motion
passes one box per slice, and between two slices it turns joint i by at least the gap between its two boxes, so it
costs at least the chord of that gap. The shortest chain of boxes is found by dynamic programming.

Nothing here is shared with the package but the problem itself: its numbers and the points of its path. The bound is of
first order: each slice loses about the width of a box.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

TAU = 2 * np.pi
# Relative error that is granted to numpy's cos, arctan2 and arccos; they err by a few units of 1e-16.
_FUNCTION = 4e-15
# Absolute error granted to sums of angles of a few turns [rad].
_ANGLE = 1e-13
# Relative error of a chord's few roundings, and of a point of the path, in parts of the lengths it is made of.
_CHORD = 1e-14
_POINT = 1e-12
# A given posture is known to this [rad].
_GIVEN = 1e-9
_ROUNDING = 1e-11  # of costs, where it decides only what is halved
_FEWEST_ARCS = 64
_MOST_TURNS = 4  # a joint with wider limits than this many turns is treated as free, which only lowers the bound
# The wrist's direction may turn by so many times an arc of u before it is parted, into so many parts at most.
_SWING, _MOST_PARTS = 16.0, 1024
_PAIRS = 1 << 20  # pairs of boxes looked at together


@dataclass
class Interval:
    """Real intervals [lo, hi], arrays of them; every operation encloses the exact result."""

    lo: np.ndarray
    hi: np.ndarray

    __array_ufunc__ = None  # so that array * interval is left to the interval

    @staticmethod
    def of(value):
        """The interval that holds one number, or the interval itself."""
        return value if isinstance(value, Interval) else Interval(np.asarray(value, float), np.asarray(value, float))

    @staticmethod
    def around(value, error):
        """The interval value ± error."""
        return Interval(_down(value - error), _up(value + error))

    def __neg__(self):
        return Interval(-self.hi, -self.lo)

    def __add__(self, other):
        other = Interval.of(other)
        return Interval(_down(self.lo + other.lo), _up(self.hi + other.hi))

    __radd__ = __add__

    def __sub__(self, other):
        return self + -Interval.of(other)

    def __rsub__(self, other):
        return -self + other

    def __mul__(self, other):
        other = Interval.of(other)
        products = [a * b for a in (self.lo, self.hi) for b in (other.lo, other.hi)]
        return Interval(_down(np.minimum.reduce(products)), _up(np.maximum.reduce(products)))

    __rmul__ = __mul__

    def __truediv__(self, other):
        """The quotient by an interval of positive numbers."""
        other = Interval.of(other)
        quotients = [a / b for a in (self.lo, self.hi) for b in (other.lo, other.hi)]
        return Interval(_down(np.minimum.reduce(quotients)), _up(np.maximum.reduce(quotients)))

    def hull(self, other):
        return Interval(np.minimum(self.lo, other.lo), np.maximum(self.hi, other.hi))

    def within(self, lo, hi):
        """The part inside [lo, hi]; empty, lo > hi, where there is none."""
        return Interval(np.maximum(self.lo, lo), np.minimum(self.hi, hi))

    @property
    def is_empty(self):
        return self.lo > self.hi

    def square(self):
        a, b = self.lo * self.lo, self.hi * self.hi
        least = np.where((self.lo <= 0) & (self.hi >= 0), 0.0, np.minimum(a, b))
        return Interval(np.maximum(_down(least), 0.0), _up(np.maximum(a, b)))

    def sqrt(self):
        """The roots of what is not negative."""
        return Interval(np.maximum(_down(np.sqrt(np.maximum(self.lo, 0))), 0.0), _up(np.sqrt(np.maximum(self.hi, 0))))

    def cos(self):
        return self._wave(np.cos, 0.0)

    def sin(self):
        return self._wave(np.sin, 0.5 * np.pi)

    def arccos(self):
        """The angles in [0, π] of what lies in [−1, 1]."""
        least, most = np.arccos(np.clip(self.hi, -1, 1)), np.arccos(np.clip(self.lo, -1, 1))
        return Interval(np.maximum(least * (1 - _FUNCTION), 0.0), most * (1 + _FUNCTION))

    def _wave(self, function, crest):
        """A function that rises to 1 at `crest` and falls to −1 half a turn later, and so on."""
        ends = np.stack([function(self.lo), function(self.hi)])
        lo, hi = ends.min(axis=0), ends.max(axis=0)
        lo, hi = lo - _FUNCTION * np.abs(lo), hi + _FUNCTION * np.abs(hi)
        lo = np.where(self._meets(crest + np.pi), -1.0, lo)
        hi = np.where(self._meets(crest), 1.0, hi)
        return Interval(np.maximum(lo, -1.0), np.minimum(hi, 1.0))

    def _meets(self, angle):
        """Whether the interval holds `angle` plus whole turns, or comes so near that rounding cannot tell."""
        turns = np.ceil((self.lo - angle) / TAU - _ANGLE)
        return angle + TAU * turns <= self.hi + 10 * _ANGLE


def _down(x):
    return np.nextafter(x, -np.inf)


def _up(x):
    return np.nextafter(x, np.inf)


def direction(x, y):
    """The directions of the points of boxes x × y: connected intervals, all the circle where a box holds the origin.

    A box that misses the origin is turned by quarters until it lies to the right of it; there the direction is a
    continuous function without critical points, so its extremes are at corners.
    """
    lo = np.full(np.broadcast(x.lo, y.lo).shape, -np.pi - _ANGLE)
    hi = -lo
    for turn, along, across in ((0.0, x, y), (np.pi, -x, -y), (0.5 * np.pi, y, -x), (-0.5 * np.pi, -y, x)):
        corners = [np.arctan2(b, a) for a in (along.lo, along.hi) for b in (across.lo, across.hi)]
        right = along.lo > 0
        lo = np.where(right, turn + np.minimum.reduce(corners) - _ANGLE, lo)
        hi = np.where(right, turn + np.maximum.reduce(corners) + _ANGLE, hi)
    return Interval(lo, hi)


def corner(side, opposite, d):
    """The angle between the sides `side` and `d` of a triangle, opposite to the side `opposite`, over intervals of d.

    Its cosine ``(d + A/d)/(2 side)``, ``A = side² − opposite²``, rises with d where A ≤ 0; else it has one valley, at
    d = √A, of depth √A/side. Where both sides are equal and d = 0 it is a right angle: any direction of d will then do.
    """
    if side == opposite:
        return (d / (2 * Interval.of(side))).arccos()
    a = Interval.of(side).square() - Interval.of(opposite).square()

    def cosine(at):
        return (Interval.of(at) + a / Interval.of(at)) / (2 * Interval.of(side))

    found = cosine(d.lo).hull(cosine(d.hi))
    valley = a.sqrt()
    inside = (a.hi > 0) & (d.lo <= valley.hi) & (d.hi >= valley.lo)
    return Interval(np.where(inside, np.minimum(found.lo, (valley / side).lo), found.lo), found.hi).arccos()


def enclose(arm, x, u, sign):
    """Enclose the joint angles of all postures with u in given intervals and sin θ2 of given sign.

    Where the wrist comes near the base its direction swings fast, and is any if it meets it. There θ1 and θ3 may turn
    far, against each other, so that one box would let chains jump: its directions are parted among several.

    Returns
    -------
    joints : list of Interval
        Per joint, some turns of them.
    arc : array of int
        The number of the interval of u that each enclosure belongs to; none where no posture exists.
    """
    l1, l2, l3 = (float(length) for length in arm.links[:3])
    target = [Interval.around(value, _POINT * (abs(value) + arm.links.sum())) for value in x]
    if arm.direction is not None:
        last, delta = Interval.of(float(arm.links[3])), Interval.of(float(arm.direction))
        target = [target[0] - last * delta.cos(), target[1] - last * delta.sin()]
    # The wrist's distance d from the base, a side of the triangle base, wrist, tool; then the wrist's direction.
    distance = (target[0].square() + target[1].square()).sqrt()
    half = (u - direction(*target)) * 0.5
    d = ((distance - l3).square() + 4 * l3 * distance * half.sin().square()).sqrt()
    d = d.within(_down(abs(l1 - l2)), _up(l1 + l2))
    phi = direction(target[0] - l3 * u.cos(), target[1] - l3 * u.sin())
    parts = np.minimum(np.ceil((phi.hi - phi.lo) / (_SWING * (u.hi - u.lo))), _MOST_PARTS)
    arc, phi = _parted(phi, np.where(d.is_empty, 0, parts).astype(int))
    d, u, sign = Interval(d.lo[arc], d.hi[arc]), Interval(u.lo[arc], u.hi[arc]), sign[arc]
    # The triangle base, elbow, wrist has the sides l1, l2, d.
    at_base, at_wrist = corner(l1, l2, d), corner(l2, l1, d)
    bend = ((d.square() - Interval.of(l1).square() - Interval.of(l2).square()) / (2 * Interval.of(l1) * l2)).arccos()
    joints = [phi - sign * at_base, sign * bend, u - phi - sign * at_wrist]
    if arm.direction is not None:
        joints.append(arm.direction - u)
    return joints, arc


def _parted(whole, parts):
    """Part each interval into so many; return the number of the one that each part is of, and the parts."""
    number = np.repeat(np.arange(len(parts)), parts)
    k = np.arange(len(number)) - np.repeat(np.cumsum(parts) - parts, parts)
    lo, step = whole.lo[number], ((whole.hi - whole.lo) / np.maximum(parts, 1))[number]
    return number, Interval(lo + k * step - _ANGLE, lo + (k + 1) * step + _ANGLE)


@dataclass
class Boxes:
    """Boxes of joint angles, shape (m, n), and the number of the arc that each came from, shape (m,)."""

    lo: np.ndarray
    hi: np.ndarray
    arc: np.ndarray

    def __len__(self):
        return len(self.arc)


def real_joints(arm):
    """Which joints are real numbers with counted turns, (n,); the others are taken modulo 2π.

    A joint with a limit on one side, or with very wide ones, can be given any number of turns; taking it modulo 2π
    lowers the bound at most.
    """
    return np.asarray(arm.limits.upper - arm.limits.lower <= _MOST_TURNS * TAU)


def cover(arm, x, u, sign):
    """Boxes that hold every posture with tool at x, u in the intervals and the given sign of sin θ2, within limits."""
    joints, arc = enclose(arm, x, u, sign)
    boxes = Boxes(np.stack([joint.lo for joint in joints], -1), np.stack([joint.hi for joint in joints], -1), arc)
    for j in np.flatnonzero(real_joints(arm)):
        boxes = _with_turns(boxes, j, arm.limits.lower[j], arm.limits.upper[j])
    return boxes


def _with_turns(boxes, j, lower, upper):
    """Replace angle j by every number of turns that the limits allow, cut to them."""
    low, high = boxes.lo[:, j], boxes.hi[:, j]
    anywhere = high - low >= TAU
    pieces = []
    first, last = np.ceil((lower - high) / TAU - _ANGLE), np.floor((upper - low) / TAU + _ANGLE)
    for turn in range(int(first.min(initial=0)), int(last.max(initial=-1)) + 1):
        a = np.maximum(low + TAU * turn - _ANGLE, lower)
        b = np.minimum(high + TAU * turn + _ANGLE, upper)
        pieces.append((np.flatnonzero(~anywhere & (a <= b)), a, b))
    pieces.append((np.flatnonzero(anywhere), np.full(len(low), lower), np.full(len(low), upper)))
    rows = np.concatenate([rows for rows, _, _ in pieces])
    lo, hi = boxes.lo[rows], boxes.hi[rows]
    lo[:, j] = np.concatenate([a[rows] for rows, a, _ in pieces])
    hi[:, j] = np.concatenate([b[rows] for rows, _, b in pieces])
    return Boxes(lo, hi, boxes.arc[rows])


def _gaps(one, two, real):
    """Per joint the distances between two lists of intervals, (m, k) each, never more than the true ones."""
    for j, counted in enumerate(real):
        if counted:
            gap = np.maximum(two.lo[:, j] - one.hi[:, j, None], one.lo[:, j, None] - two.hi[:, j])
        else:
            off = 0.5 * np.abs((two.lo[:, j] + two.hi[:, j]) - (one.lo[:, j] + one.hi[:, j])[:, None])
            off = np.abs(off - TAU * np.rint(off / TAU))
            gap = off - 0.5 * ((two.hi[:, j] - two.lo[:, j]) + (one.hi[:, j] - one.lo[:, j])[:, None]) - _ANGLE
        yield np.maximum(gap, 0.0, out=gap)


def chords(one, two, h, problem):
    """The least cost from each box of `one` to each of `two`, h further along the path, rounded down."""
    weights, kind = problem.weights, problem.objective.kind
    total = np.zeros((len(one), len(two)))
    for gap, weight in zip(_gaps(one, two, real_joints(problem.arm)), weights, strict=True):
        if kind == "joint_travel":
            total += weight * np.sqrt(h * h + gap * gap)
        elif kind == "l1":
            total += weight * gap
        else:
            total += (weight * gap) ** 2
    return (np.sqrt(total) if kind == "l2" else total) * (1 - _CHORD)


def _cheapest(value, one, two, h, problem, axis):
    """Step a value function from slice `one` on to `two` (axis 0) or from `two` back to `one` (axis 1)."""
    rows = max(1, _PAIRS // max(len(two), 1))
    parts = []
    for k in range(0, len(one), rows):
        part = Boxes(one.lo[k : k + rows], one.hi[k : k + rows], one.arc[k : k + rows])
        cost = chords(part, two, h, problem)
        cost += value[k : k + rows, None] if axis == 0 else value
        parts.append(cost.min(axis=axis))
    return _down(np.minimum.reduce(parts) if axis == 0 else np.concatenate(parts))


class Slice:
    """One pose of the path, the arcs that u's circle is cut into there, per elbow, and their boxes.

    Arcs are numbered in units of the finest ones, so that halving them is exact.
    """

    def __init__(self, problem, r, arcs, coarse):
        self.arm, self.x, self.arcs = problem.arm, problem.path(r), arcs
        signs = [1 - 2 * branch for branch in problem.elbow_branches]
        edges = np.arange(0, arcs + 1, arcs // coarse)
        first, sign = (grid.ravel() for grid in np.meshgrid(edges[:-1], signs))
        self._set(first, first + arcs // coarse, sign)

    def _set(self, first, last, sign):
        self.first, self.last, self.sign = first, last, sign
        ends = np.stack([first, last]) * (TAU / self.arcs) - np.pi
        # A hair more than the circle, so that no posture is between the last arc and the first.
        self.boxes = cover(self.arm, self.x, Interval(ends[0] - _ANGLE, ends[1] + _ANGLE), sign)

    def halve(self, boxes):
        """Halve the arcs of some boxes; return whether there was any arc to halve."""
        wanted = np.zeros(len(self.first), bool)
        wanted[self.boxes.arc[boxes]] = True
        wanted &= self.last - self.first > 1
        if wanted.any():
            middle = (self.first + self.last) // 2
            self._set(
                np.concatenate([self.first[~wanted], self.first[wanted], middle[wanted]]),
                np.concatenate([self.last[~wanted], middle[wanted], self.last[wanted]]),
                np.concatenate([self.sign[~wanted], self.sign[wanted], self.sign[wanted]]),
            )
        return bool(wanted.any())


class GivenEnd:
    """The first or last pose, where the posture is given: nothing to halve."""

    def __init__(self, problem, r, posture):
        arm = problem.arm
        if posture.q is not None:
            self.boxes = Boxes(posture.q[None] - _GIVEN, posture.q[None] + _GIVEN, np.zeros(1, int))
            return
        branches = problem.elbow_branches if posture.branches is None else posture.branches
        signs = np.array([1 - 2 * branch for branch in branches])
        u = Interval.around(np.full(len(signs), posture.u[0]), _GIVEN)
        self.boxes = cover(arm, problem.path(r), u, signs)

    def halve(self, boxes):
        return False


def poses(problem, slices, arcs, coarse):
    """The covers of all slices, and the path parameters they are at."""
    r = np.linspace(0.0, 1.0, slices + 1)
    covers = [Slice(problem, value, arcs, coarse) for value in r]
    for k, posture in ((0, problem.start), (-1, problem.end)):
        if posture is not None:
            covers[k] = GivenEnd(problem, r[k], posture)
    return covers, r


def uniform_bound(problem, slices, arcs):
    """A lower bound on the cost of every motion, all arcs of the circle of one size; infinite if there is none."""
    covers, r = poses(problem, slices, arcs, arcs)
    return np.inf if _is_blocked(covers) else float(_forward(problem, covers, r)[-1].min())


def interval_bound(problem, slices, arcs):
    """The same bound sooner: coarse arcs first, halved only where cheap chains pass.

    A chain of coarse boxes costs no more than the chains of finer ones inside them, so once the cheapest chain is all
    of finest boxes no other is cheaper, however coarse the arcs it stayed away from.

    Parameters
    ----------
    problem : Problem
        Of a planar arm with one redundant degree; a cyclic motion's closure is not asked for.
    slices, arcs : int
        Parts of the path and, at most, of the circle of u.

    Returns
    -------
    float
        No motion costs less; ``inf`` proves that there is no motion, a pose having no posture inside the limits.
    """
    coarse = arcs
    while coarse % 2 == 0 and coarse > _FEWEST_ARCS:
        coarse //= 2
    covers, r = poses(problem, slices, arcs, coarse)
    bound, slack = 0.0, 0.0
    while not _is_blocked(covers):
        values = _forward(problem, covers, r)
        best = float(values[-1].min())
        bound, rise = max(bound, best), best - bound
        chains = [ahead + behind for ahead, behind in zip(values, _backward(problem, covers, r), strict=True)]
        # Halving arcs halves what is lost, so the bound will rise by about as much as it just did; it may also rest
        # for a while, until the last of many equal chains is halved.
        slack = max(rise, 0.3 * slack, _ROUNDING)
        halved = [cover.halve(chain <= best + slack) for cover, chain in zip(covers, chains, strict=True)]
        if not any(halved):
            return bound
    return np.inf


def _is_blocked(covers):
    """Whether some pose has no posture inside the limits, which proves that there is no motion."""
    return any(len(cover.boxes) == 0 for cover in covers)


def _forward(problem, covers, r):
    """Per slice the least cost of a chain from r = 0 to each box."""
    values = [np.zeros(len(covers[0].boxes))]
    for (one, two), h in zip(pairwise(covers), np.diff(r), strict=True):
        values.append(_cheapest(values[-1], one.boxes, two.boxes, _down(h), problem, 0))
    return values


def _backward(problem, covers, r):
    """Per slice the least cost of a chain from each box to r = 1."""
    values = [np.zeros(len(covers[-1].boxes))]
    for (one, two), h in reversed(list(zip(pairwise(covers), np.diff(r), strict=True))):
        values.append(_cheapest(values[-1], one.boxes, two.boxes, _down(h), problem, 1))
    return values[::-1]

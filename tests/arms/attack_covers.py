"""Tries to find postures that covers of spatial arms leave out: self-motions walked along the null space.

    python tests/arms/attack_covers.py ARM COUNT SEED [--dense] [--torch]

Nothing here shares code with closed forms or covers: poses come from products of transforms, self-motions from steps of
Newton's method, started at random and at the posture that a pose was made from. With --dense, which is a hundred times
faster, postures are the closed form's at many values of its parameter; that each is at its pose is still checked here.
"""

import argparse
import sys
import time
from typing import NamedTuple

import numba
import numpy as np
from scipy.optimize import brentq

from selfmotion.arms.catalogue import CATALOGUE, named_arm

ARMS = ("panda", "fr3", "iiwa7", "iiwa14")
ON_RAILS = ("irb120 on a rail", "kr6r900 on a rail", "ur5e on a rail")
RAIL = {"axis": [0.2, 1.0, 0.1], "limits": [-0.4, 0.7]}
TOOL = {"translation": [0.05, 0.02, 0.15], "rpy": [0.3, 0.6, -0.2]}
OVERRUN = 1e-9
EXACT = 3e-14  # what a sampled posture may miss its pose by
KINDS = (
    "any", "shoulder", "shoulder ±1e-3", "shoulder ±1e-6", "elbow", "elbow ±1e-3", "wrist", "wrist ±1e-3",
    "wrist ±1e-6", "limit", "rim", "shoulder and wrist", "shoulder and elbow", "limit and wrist",
)  # fmt: skip
COSTLY = ("shoulder", "shoulder and wrist", "shoulder and elbow", "elbow")
"""Kinds of poses whose covers take seconds, or minutes, each."""
ROLL_KINDS = (*KINDS, "up ±1e-3", "up ±1e-6")
"""Of arms whose tool rolls: also near where it points straight up, and the rolls' frame is at a loss."""
TORCH = {"translation": [0.05, 0.02, 0.15], "rpy": [0.0, 0.6, 0.0]}
"""A tool off the last axis: without one the roll of six joints is that axis, and their self-motions straight lines."""
TURN = 2 * np.pi


def load(name, slack=None, tool=None):
    """An arm by its name, joint limits wider by `slack`."""
    arm = named_arm(name.split()[0], tool=TOOL, rail=RAIL) if name in ON_RAILS else named_arm(name, tool=tool)
    return arm if slack is None else arm.relaxed(np.full(arm.n, slack))


@numba.njit(cache=True, error_model="numpy")
def pose_error(offsets, first, q, rotation, position, error, jacobian):
    """Fill in by how much a posture misses a pose (n − 1,), and the Jacobian (n − 1, n) of that.

    Joints before `first` slide. Six joints keep the position and the z-axis of a pose: turns count about its x- and
    y-axis only.
    """
    n = len(q)
    frame = offsets[0].copy()
    axes, centers = np.empty((n, 3)), np.empty((n, 3))
    turn = np.eye(4)
    for j in range(n):
        axes[j], centers[j] = frame[:3, 2], frame[:3, 3]
        if j < first:
            frame[:3, 3] += q[j] * axes[j]
            frame = frame @ offsets[j + 1]
            continue
        turn[0, 0], turn[0, 1], turn[1, 0], turn[1, 1] = np.cos(q[j]), -np.sin(q[j]), np.sin(q[j]), np.cos(q[j])
        frame = frame @ turn @ offsets[j + 1]
    error[:] = 0.0
    for j in range(n):
        if j < first:
            jacobian[:3, j] = axes[j]
        else:
            jacobian[:3, j] = np.cross(axes[j], frame[:3, 3] - centers[j])
    for i in range(3):
        error[i] = frame[i, 3] - position[i]
    if n == 6:
        turned = np.cross(np.ascontiguousarray(rotation[:, 2]), np.ascontiguousarray(frame[:3, 2]))
        for i in range(3):
            for k in range(2):
                error[3 + k] += turned[i] * rotation[i, k]
        for k in range(2):
            for j in range(n):
                jacobian[3 + k, j] = (axes[j] * rotation[:, k]).sum()
        return (frame[:3, 2] * rotation[:, 2]).sum() > 0.0
    for j in range(n):
        if j < first:
            jacobian[3:, j] = 0.0
        else:
            jacobian[3:, j] = axes[j]
    for i in range(3):
        for k in range(3):  # half the sum of the columns' vector products: the sine of the angle, about the axis
            a, b = (k + 1) % 3, (k + 2) % 3
            error[3 + k] -= 0.5 * (frame[a, i] * rotation[b, i] - frame[b, i] * rotation[a, i])
    cosine = 0.0
    for i in range(3):
        for k in range(3):
            cosine += frame[i, k] * rotation[i, k]
    return cosine > 1.0


@numba.njit(cache=True, error_model="numpy")
def settled(offsets, first, q, rotation, position, steps, most):
    """Move q onto a pose by the shortest Newton steps; return the error left, infinite if it does not get there."""
    tasks = len(q) - 1
    error, jacobian = np.empty(tasks), np.empty((tasks, len(q)))
    best = np.inf
    for _ in range(steps):
        ahead = pose_error(offsets, first, q, rotation, position, error, jacobian)
        size = np.abs(error).max()
        if size < 1e-15 or (best < 1e-14 and size >= best):
            return size if ahead else np.inf
        best = min(best, size)
        u, s, vt = np.linalg.svd(jacobian, full_matrices=False)
        step = np.zeros(len(q))
        for k in range(tasks):
            if s[k] > 1e-9 * s[0]:
                step -= vt[k] * (u[:, k] @ error) / s[k]
        length = np.abs(step).max()
        if not length < 1e6:
            return np.inf
        q += step * min(1.0, most / max(length, 1e-300))
    ahead = pose_error(offsets, first, q, rotation, position, error, jacobian)
    return np.abs(error).max() if ahead else np.inf


@numba.njit(cache=True, error_model="numpy")
def overrun(q, lower, upper):
    """Return how far a posture is outside its limits; negative inside."""
    most = -np.inf
    for j in range(len(q)):
        most = max(most, lower[j] - q[j], q[j] - upper[j])
    return most


@numba.njit(cache=True, error_model="numpy")
def walk(offsets, first, start, rotation, position, lower, upper, steps, found, steep):
    """Walk along the self-motion both ways as far as limits go; fill in postures and least singular values.

    Lengths of steps are repeated; where limits end the walk its last posture overruns them by all but what may be.
    """
    n, count = len(start), 0
    error, jacobian = np.empty(n - 1), np.empty((n - 1, n))
    for way in (1.0, -1.0):
        q, before = start.copy(), np.zeros(n)
        for k in range(len(found) // 2):
            if count >= len(found):
                return count
            pose_error(offsets, first, q, rotation, position, error, jacobian)
            _, s, vt = np.linalg.svd(jacobian, full_matrices=True)
            found[count], steep[count] = q, s[-1]
            count += 1
            tangent = vt[-1] * (way if k == 0 else 1.0)
            if k == 0 and tangent[np.argmax(np.abs(vt[-1]))] * way < 0:
                tangent = -tangent
            if k > 0:
                if s[-1] < 1e-4:  # at a crossing: straight on
                    tangent = before
                elif tangent @ before < 0:
                    tangent = -tangent
            long = steps[k % len(steps)]
            low, far, at, inside = 0.0, long, long, q.copy()
            for _ in range(60):
                ahead = q + at * tangent
                left = settled(offsets, first, ahead, rotation, position, 12, 0.1)
                if left > EXACT or np.abs(ahead - q).max() > 3 * long:
                    break
                if overrun(ahead, lower, upper) <= 0.999 * OVERRUN:
                    low, inside = at, ahead
                else:
                    far = at
                if low == long or far - low < 1e-13:
                    break
                at = 0.5 * (low + far)
            if low == 0.0:
                break
            before = inside - q
            before /= np.sqrt(before @ before)
            q = inside.copy()
            if low < long:
                if count < len(found):
                    found[count], steep[count] = q, s[-1]
                    count += 1
                break
            if k > 3 and np.abs(q - start).max() < 0.3 * steps.max():
                break
    return count


@numba.njit(cache=True, error_model="numpy")
def excess(q, a, b, bow, dev, rest, wraps):
    """Return by how much a posture is outside the cell that holds it best, and that cell."""
    m, n = a.shape
    least, which = np.inf, -1
    d = np.empty(n)
    for k in range(m):
        outside = 0.0
        for j in range(n):
            d[j] = q[j] - a[k, j]
            if wraps[j]:
                d[j] -= 2 * np.pi * np.rint((q[j] - 0.5 * (a[k, j] + b[k, j])) / (2 * np.pi))
            step = b[k, j] - a[k, j]
            outside = max(outside, min(step, 0.0) - dev[k, j] - d[j], d[j] - max(step, 0.0) - dev[k, j])
        if outside >= least:
            continue
        # Where along the cell: everywhere first, then around the best place.
        low, high = 0.0, 1.0
        for _ in range(40):
            best, place = np.inf, low
            for i in range(9):
                s = low + (high - low) * i / 8
                away = off(d, s, a[k], b[k], bow[k], dev[k], rest[k])
                if away < best:
                    best, place = away, s
            if best < least:
                least, which = best, k
            width = high - low
            low, high = max(low, place - 0.2 * width), min(high, place + 0.2 * width)
            if best <= 0.0 or best > 0.1 or width < 1e-15:
                break
        if least <= 0.0:
            break
    return least, which


@numba.njit(cache=True, error_model="numpy")
def off(d, s, a, b, bow, dev, rest):
    """Return by how much a posture, d from end a, is outside a cell at s."""
    most = 0.0
    for j in range(len(d)):
        chord = d[j] - s * (b[j] - a[j])
        most = max(most, abs(chord) - dev[j], abs(chord - 0.5 * s * (1.0 - s) * bow[j]) - rest[j])
    return most


@numba.njit(cache=True, error_model="numpy")
def all_excess(q, a, b, bow, dev, rest, wraps, found):
    """Fill in the excess of every posture."""
    for i in range(len(q)):
        found[i], _ = excess(q[i], a, b, bow, dev, rest, wraps)


@numba.njit(cache=True, error_model="numpy")
def is_held(q, a, b, bow, dev, rest, wraps, d):
    """Whether a posture is inside a cell where its longest joint says: a yes is one, a no need not be."""
    longest = 0
    for j in range(len(q)):
        d[j] = q[j] - a[j]
        if wraps[j]:
            d[j] -= 2 * np.pi * np.rint((q[j] - 0.5 * (a[j] + b[j])) / (2 * np.pi))
        step = b[j] - a[j]
        if d[j] < min(step, 0.0) - dev[j] or d[j] > max(step, 0.0) + dev[j]:
            return False
        if abs(step) > abs(b[longest] - a[longest]):
            longest = j
    step, s = b[longest] - a[longest], 0.0
    if step != 0.0:
        s = min(max(d[longest] / step, 0.0), 1.0)
        if off(d, s, a, b, bow, dev, rest) <= 0.0:
            return True
        for _ in range(4):
            left = d[longest] - s * step - 0.5 * s * (1.0 - s) * bow[longest]
            s = min(max(s + left / (step + (0.5 - s) * bow[longest]), 0.0), 1.0)
    return off(d, s, a, b, bow, dev, rest) <= 0.0


@numba.njit(cache=True, error_model="numpy")
def all_held(q, a, b, bow, dev, rest, wraps, found):
    """Like `all_excess`, faster for postures in order along curves: zero is all that is told of those inside."""
    m, last = len(a), 0
    d = np.empty(q.shape[1])
    for i in range(len(q)):
        found[i] = -1.0
        for t in range(m):  # from the cell that held the one before outwards: neighbours in the list are neighbours
            k = (last + (t + 1) // 2 * (1 if t % 2 else -1)) % m
            if is_held(q[i], a[k], b[k], bow[k], dev[k], rest[k], wraps, d):
                found[i], last = 0.0, k
                break
        if found[i] < 0.0:
            found[i], k = excess(q[i], a, b, bow, dev, rest, wraps)
            last = max(k, 0)


@numba.njit(cache=True, error_model="numpy")
def all_misses(offsets, first, q, rotation, position, found):
    """Fill in by how much postures (k, n) miss a pose: distance, and sine of the angle, the larger of both.

    Joints before `first` slide.
    """
    n = q.shape[1]
    frame, moved = np.empty((3, 4)), np.empty((3, 4))
    for i in range(len(q)):
        frame[:] = offsets[0, :3]
        for j in range(n):
            if j < first:
                for r in range(3):
                    frame[r, 3] += q[i, j] * frame[r, 2]
            else:
                c, s = np.cos(q[i, j]), np.sin(q[i, j])
                for r in range(3):
                    x, y = frame[r, 0], frame[r, 1]
                    frame[r, 0], frame[r, 1] = c * x + s * y, c * y - s * x
            for r in range(3):
                for k in range(4):
                    moved[r, k] = frame[r, 3] if k == 3 else 0.0
                    for across in range(3):
                        moved[r, k] += frame[r, across] * offsets[j + 1, across, k]
            frame[:] = moved
        most = 0.0
        for r in range(3):
            most = max(most, abs(frame[r, 3] - position[r]))
            for k in range(2 if n == 6 else 0, 3):
                most = max(most, abs(frame[r, k] - rotation[r, k]))
        found[i] = most


def sliding(arm):
    """How many joints slide, all before those that turn."""
    return int(arm.limits.slides.sum())


def target(x):
    """Rotation matrix and position of a pose (7,)."""
    w, v = x[3], x[4:]
    cross = np.array([[0.0, -v[2], v[1]], [v[2], 0.0, -v[0]], [-v[1], v[0], 0.0]])
    return np.eye(3) + 2 * w * cross + 2 * cross @ cross, np.ascontiguousarray(x[:3])


def misses(arm, x, q):
    """By how much postures (k, n) miss a pose."""
    found = np.empty(len(q))
    all_misses(arm.chain.offsets, sliding(arm), np.ascontiguousarray(q), *target(x), found)
    return found


def outside(cells, q, wraps):
    """By how much postures (k, n) are outside of the cells."""
    found = np.empty(len(q))
    all_excess(q, cells.a, cells.b, cells.bow, cells.dev, cells.rest, wraps, found)
    return found


def axes(arm, q):
    """The joints' axes and points on them, each (n, 3)."""
    frame, found = arm.chain.offsets[0], []
    for angle, offset in zip(q, arm.chain.offsets[1:], strict=True):
        found.append(frame[:3, 2:].T)
        c, s = np.cos(angle), np.sin(angle)
        frame = frame @ np.array([[c, -s, 0, 0], [s, c, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]) @ offset
    return np.array(found)[:, 0], np.array(found)[:, 1]


def wrist(arm, q):
    """The point where the last two of six axes meet."""
    axis, center = axes(arm, q)
    along = np.linalg.lstsq(np.column_stack([axis[4], -axis[5]]), center[5] - center[4], rcond=None)[0][0]
    return center[4] + along * axis[4]


def roll_fold(arm):
    """The stretched elbow's angle of six joints: where the third takes what it carries farthest from axis 2."""
    away, at = [], np.linspace(0.0, TURN, 4)[:3]
    for angle in at:
        q = np.zeros(6)
        q[2] = angle
        axis, center = axes(arm, q)
        tip = center[3] if is_ur(arm) else wrist(arm, q)
        across = tip - center[1] - axis[1] * (axis[1] @ (tip - center[1]))
        away.append(across @ across)
    wave = np.array(away) @ np.exp(1j * at)
    return float(np.clip(wrap(np.angle(wave)), arm.limits.lower[2], arm.limits.upper[2]))


def is_ur(arm):
    """Whether joints 2, 3 and 4 are parallel."""
    axis, _ = axes(arm, np.zeros(6))
    return abs(axis[2] @ axis[3]) > 0.5


def wrap(angle):
    """The same angle in [−π, π]."""
    return angle - TURN * np.rint(angle / TURN)


def roll_posture(arm, kind, rng):
    """A random posture of six joints within limits, of a kind."""
    lower, upper = arm.limits.lower, arm.limits.upper
    near = 10.0 ** -float(kind[-1]) * rng.choice([-1, 1]) if kind[-1].isdigit() else 0.0
    for _ in range(100):
        q = rng.uniform(lower, upper)
        if "limit" in kind:
            j = rng.integers(arm.n)
            q[j] = rng.choice([lower[j], upper[j]])
        if "elbow" in kind or "rim" in kind:
            q[2] = roll_fold(arm) + (near or (rng.choice([-1, 1]) * 0.02 if "rim" in kind else 0.0))
        if "wrist" in kind:
            q[4] = near
        if "shoulder" in kind:  # the second joint takes the wrist above the first, in the plane of both

            def sideways(angle, q=q):
                axis, center = axes(arm, np.array([q[0], angle, *q[2:]]))
                return np.cross(axis[1], axis[0]) @ (wrist(arm, [q[0], angle, *q[2:]]) - center[0])

            grid = np.linspace(lower[1], upper[1], 41)
            values = np.array([sideways(angle) for angle in grid])
            turns = np.flatnonzero(values[1:] * values[:-1] < 0)
            if not len(turns):
                continue
            low, high = grid[(k := rng.choice(turns))], grid[k + 1]
            for _ in range(60):
                middle = 0.5 * (low + high)
                low, high = (middle, high) if sideways(middle) * values[k] > 0 else (low, middle)
            q[1] = low + near
        if "up" in kind:
            turn = rng.uniform(-np.pi, np.pi)
            wanted = np.array([abs(near) * np.cos(turn), abs(near) * np.sin(turn), np.sqrt(1 - near**2)])
            if not points(arm, q, wanted):
                continue
        q = np.clip(q, lower, upper)
        if "up" not in kind or axes_end(arm, q) @ wanted > 1 - 1e-15:
            return q
    raise RuntimeError(kind)


def axes_end(arm, q):
    """The tool's z-axis."""
    rotation, _ = target(arm.forward(q))
    return rotation[:, 2]


def points(arm, q, wanted):
    """Turn joints until the tool's z-axis is the one wanted; whether it is."""
    for _ in range(60):
        axis, _ = axes(arm, q)
        now = axes_end(arm, q)
        turn = np.cross(now, wanted) + 0.1 * (now @ wanted < -0.5)
        if now @ wanted > 0 and np.abs(turn).max() < 1e-15:
            break
        q += np.clip(np.linalg.pinv(np.cross(axis[3:], now).T, 1e-6) @ (wanted - now), -0.5, 0.5) @ np.eye(6)[3:]
    return bool(np.abs(axes_end(arm, q) - wanted).max() < 1e-14)


def fold(arm):
    """The stretched elbow's angle, as near as limits allow."""
    stretched = 0.0
    if arm.closed_form.family.parameter == "q7":
        _, d3, a4, d5, a5, _ = arm.geometry
        stretched = (np.arctan2(d3, a4) - np.arctan2(d5, a5) + np.pi) % (2 * np.pi) - np.pi
    return float(np.clip(stretched - arm.closed_form.shift[3], arm.limits.lower[3], arm.limits.upper[3]))


def posture(arm, kind, rng):
    """A random posture within limits, of a kind."""
    if arm.n == 6:
        return roll_posture(arm, kind, rng)
    lower, upper = arm.limits.lower, arm.limits.upper
    q = rng.uniform(lower, upper)
    near = 10.0 ** -float(kind[-1]) * rng.choice([-1, 1]) if kind[-1].isdigit() else 0.0
    if "rim" in kind and not arm.limits.slides.any():
        many = rng.uniform(lower, upper, (400, arm.n))
        many[:, 3] = fold(arm) + 0.02 * np.sign(0.5 * (lower[3] + upper[3]) or rng.choice([-1, 1]))
        if arm.closed_form.family.parameter == "q7":
            many[:200, 5] = np.clip(0.0, lower[5], upper[5])
        q = many[np.linalg.norm(arm.forward(many)[:, :3] - arm.chain.offsets[0][:3, 3], axis=1).argmax()]
    if arm.limits.slides.any():
        return on_rail(arm, kind, q, near, rng)
    if "limit" in kind:
        j = rng.integers(arm.n)
        q[j] = rng.choice([lower[j], upper[j]])
    if "shoulder" in kind:
        q[1] = near
    if "elbow" in kind:
        q[3] = fold(arm) + near
    if "wrist" in kind and arm.closed_form.family.parameter == "q7":
        q[4] = rng.choice([-1, 1]) * np.pi / 2 + near
    elif "wrist" in kind:
        q[5] = near
    return np.clip(q, lower, upper)


def on_rail(arm, kind, q, near, rng):
    """A posture of a kind of an arm on a rail: as singular as its signs, which tell its branches apart, can be made."""
    lower, upper, shift, lengths = arm.limits.lower, arm.limits.upper, arm.shift, arm.geometry
    spherical = arm.closed_form.family.number == 4
    if "limit" in kind:
        j = rng.integers(arm.n)
        q[j] = rng.choice([lower[j], upper[j]])
    if "elbow" in kind:
        q[3] = near - shift[3] - (np.arctan2(lengths[1], lengths[4]) if spherical else 0.0)
    if "wrist" in kind:
        q[5] = near - shift[5]
    if "shoulder" in kind:  # the wrist above the first axis, or as near to it as its offset lets it be

        def m(q2):
            a, b, c = q2 + shift[2], q2 + shift[2] + q[3] + shift[3], q[4] + shift[4]
            if spherical:
                return lengths[0] + lengths[3] * np.sin(a) + lengths[1] * np.cos(b) + lengths[4] * np.sin(b) - near
            return lengths[0] * np.cos(a) + lengths[1] * np.cos(b) + lengths[3] * np.sin(b + c) - near

        grid = np.linspace(max(lower[2], -np.pi), min(upper[2], np.pi), 400)
        values = np.array([m(a) for a in grid])
        change = np.flatnonzero(values[1:] * values[:-1] < 0)
        if len(change):
            k = rng.choice(change)
            q[2] = brentq(m, grid[k], grid[k + 1], xtol=1e-15)
    return np.clip(q, lower, upper)


class Sample(NamedTuple):
    """Feasible postures (k, n) at a pose, and the least singular value at each."""

    q: np.ndarray
    steep: np.ndarray


def sampled(arm, x, first, rng, starts=12, step=0.02, most=1500):
    """Feasible postures of the self-motions that random starts, and the first one, lead to."""
    offsets, (rotation, position) = arm.chain.offsets, target(x)
    lower, upper, slides = arm.limits.lower, arm.limits.upper, sliding(arm)
    all_q, all_steep = [], []
    tries = [first, *rng.uniform(np.maximum(lower, -4), np.minimum(upper, 4), (starts, arm.n))]
    for k, start in enumerate(tries):
        q = np.array(start)
        if settled(offsets, slides, q, rotation, position, 60 if k else 12, 0.3) > EXACT:
            continue
        turns = np.rint((0.5 * (np.maximum(lower, -9) + np.minimum(upper, 9)) - q) / (2 * np.pi))
        q = q + 2 * np.pi * np.where(arm.limits.slides, 0.0, turns)
        if overrun(q, lower, upper) > 0.999 * OVERRUN:
            continue
        if all_q and np.abs(np.concatenate(all_q) - q).max(axis=1).min() < step:
            continue
        found, steep = np.empty((most, arm.n)), np.empty(most)
        steps = step * rng.uniform(0.3, 1.0, 97)
        count = walk(offsets, slides, q, rotation, position, lower, upper, steps, found, steep)
        all_q.append(found[:count])
        all_steep.append(steep[:count])
    if not all_q:
        return Sample(np.empty((0, arm.n)), np.empty(0))
    return Sample(np.concatenate(all_q), np.concatenate(all_steep))


def faults(arm, x, cells):
    """What is wrong with cells, whatever they hold: words."""
    found = []
    if (cells.dev < (1 - 1e-12) * (0.125 * np.abs(cells.bow) + cells.rest)).any():
        found.append("dev is less than |bow|/8 + rest")
    curves = cells.pieces[:, 1] == 0.0
    for ends in (cells.a[curves], cells.b[curves]):
        miss = misses(arm, x, ends).max(initial=0.0)
        if miss > 1e-9:
            found.append(f"ends miss the pose by {miss:.1e}")
    along = (cells.pieces[1:, :2] == cells.pieces[:-1, :2]).all(axis=1) & (cells.pieces[1:, 2] == cells.pieces[:-1, 3])
    apart = cells.a[1:] - cells.b[:-1]
    apart -= 2 * np.pi * np.rint(apart / (2 * np.pi)) * arm.cover().wraps
    if (np.abs(apart[along & curves[1:]]) > 1e-9).any():
        found.append("cells that follow each other do not meet")
    return found


class Verdict(NamedTuple):
    """Of one pose: postures looked at, those missed, the worst excess, cells and seconds, what else is wrong."""

    checked: int
    missed: int
    worst: float
    cells: int
    seconds: float
    faults: list


def verdict(arm, cover, q, rng, spacings=(0.3, 0.1, 0.02), splits=(0.5, 0.2), room=1e-10, most=1500):
    """Attack the cover at one posture's pose: its cells at several spacings, and what is split from each."""
    x = arm.forward(q)
    sample = sampled(arm, x, q, rng, most=most)
    checked = missed = cells_most = 0
    worst, wrong = 0.0, []
    seconds = 0.0
    # Rounding of the pose moves the self-motion by the more the nearer it is to a singularity.
    allowed = room + 20 * EXACT / np.maximum(sample.steep, 1e-12)
    for spacing in spacings:
        began = time.perf_counter()
        cells = cover.cells(x, spacing)
        if spacing == spacings[0]:
            seconds = time.perf_counter() - began
        cells_most = max(cells_most, len(cells))
        looked = [(cells, "cells")]
        for part in splits:
            looked.append((cover.split(x, looked[-1][0], np.full(len(looked[-1][0]), spacing * part)), "split"))
        for there, name in looked:
            away = outside(there, sample.q, cover.wraps)
            checked += len(away)
            lost = away > allowed
            missed += int(lost.sum())
            worst = max(worst, float(away.max(initial=0.0)))
            if lost.any():
                wrong.append(f"{name} at {spacing}: {int(lost.sum())} missed, by {away[lost].max():.1e}")
            wrong += [f"{name} at {spacing}: {fault}" for fault in faults(arm, x, there)]
    return Verdict(checked, missed, worst, cells_most, seconds, wrong)


class Drawn(NamedTuple):
    """Feasible postures (k, n) of the closed form at a pose, and what it misses that pose by at the worst of them."""

    q: np.ndarray
    miss: float


def drawn(arm, x, first, rng, wraps, even=200):
    """Feasible postures at even values of u, random ones, and ever nearer to the posture that the pose is of."""
    low, high = arm.parameter_range
    mine = arm.u_of(first)[0] + 10.0 ** rng.uniform(-9, -1, 20) * rng.choice([-1, 1], 20)
    u = np.concatenate([np.linspace(low, high, even), rng.uniform(low, high, 40), mine])
    rotation, position = arm._root(x)
    every, there = np.empty((len(u), 8, arm.n)), np.empty((len(u), 8), bool)
    for k in np.argsort(u):
        arm.closed.solve(arm.geometry, rotation, position, u[k], every[k], there[k])
    order = np.argsort(u)
    every, there = every[order].swapaxes(0, 1), there[order].swapaxes(0, 1)
    q = every[there] - arm.shift
    miss = misses(arm, x, q)
    rough = np.flatnonzero(miss > EXACT)
    exact = np.ones(len(q), bool)
    rotation, position = target(x)
    for k in rough:
        exact[k] = settled(arm.chain.offsets, sliding(arm), q[k], rotation, position, 12, 0.1) <= EXACT
    return Drawn(with_turns(arm, np.concatenate([first[None], q[exact]]), wraps), miss.max(initial=0.0))


def with_turns(arm, q, wraps):
    """Postures (k, n) in every turn within limits; joints that wrap or slide as they are, those inside their limits."""
    lower, upper = arm.limits.lower - 0.999 * OVERRUN, arm.limits.upper + 0.999 * OVERRUN
    slides = arm.limits.slides
    q = q[((q >= lower) & (q <= upper))[:, slides].all(axis=1)]
    for j in np.flatnonzero(~wraps & ~slides):
        q = q.copy()
        q[:, j] += TURN * np.ceil((lower[j] - q[:, j]) / TURN)
        turns = []
        while len(q := q[q[:, j] <= upper[j]]):
            turns.append(q)
            q = q + TURN * np.eye(arm.n)[j]
        q = np.concatenate(turns) if turns else q
    return q


def allowance(arm, x, q, room=1e-10):
    """By how much postures (k, n) may be outside: what rounding of the pose moves the self-motion by there."""
    rotation, position = target(x)
    error, jacobian = np.empty(arm.n - 1), np.empty((arm.n - 1, arm.n))
    found = []
    for posture in q:
        pose_error(arm.chain.offsets, sliding(arm), posture, rotation, position, error, jacobian)
        found.append(room + 20 * EXACT / max(np.linalg.svd(jacobian, compute_uv=False)[-1], 1e-12))
    return np.array(found)


def dense_verdict(arm, cover, q, rng, spacing, part=None, even=200):
    """Hold the cells at one posture's pose against the closed form's postures, and what is split from the cells too."""
    x = arm.forward(q)
    sample = drawn(arm, x, q, rng, cover.wraps, even)
    began = time.perf_counter()
    cells = cover.cells(x, spacing)
    seconds = time.perf_counter() - began
    looked = [(cells, "cells")]
    if part is not None:
        looked.append((cover.split(x, cells, np.full(len(cells), spacing * part)), "split"))
    missed, worst, wrong = 0, 0.0, []
    if sample.miss > 1e-9:
        wrong.append(f"the closed form misses the pose by {sample.miss:.1e}")
    for there, name in looked:
        away = np.empty(len(sample.q))
        all_held(sample.q, there.a, there.b, there.bow, there.dev, there.rest, cover.wraps, away)
        worst = max(worst, float(away.max(initial=0.0)))
        doubtful = np.flatnonzero(away > 1e-10)
        lost = doubtful[away[doubtful] > allowance(arm, x, sample.q[doubtful])]
        missed += len(lost)
        if len(lost):
            which = lost[away[lost].argmax()]
            wrong.append(
                f"{name} at {spacing}: {len(lost)} missed, by {away[lost].max():.1e}, "
                f"such as {sample.q[which].tolist()}"
            )
        wrong += [f"{name} at {spacing}: {fault}" for fault in faults(arm, x, there)]
    return Verdict(len(sample.q) * len(looked), missed, worst, len(cells), seconds, wrong)


def one_pose(arm, cover, name, seed, k, costly, dense):
    """The kind of pose k, its posture, and what comes of it."""
    rng = np.random.default_rng([seed, k])
    cheap = [kind for kind in (KINDS if arm.n == 7 else ROLL_KINDS) if kind not in COSTLY]
    if k % costly == costly - 1:
        kind = COSTLY[(k // costly) % len(COSTLY)]
    elif not dense:
        kind = cheap[k % len(cheap)]
    else:  # covers at other kinds of poses take ten times as long, and those of an iiwa are slow to begin with
        rare = 50 if name.startswith("iiwa") else 10
        kind = cheap[k // rare % len(cheap)] if k % rare == 0 else ("any", "limit")[k % 10 == 1]
    q = posture(arm, kind, rng)
    if not dense:
        return kind, q, verdict(arm, cover, q, rng, spacings=(float(rng.choice([0.3, 0.1, 0.02])),))
    spacing = float(rng.choice([0.3, 0.1, 0.02], p=[0.6, 0.3, 0.1]))
    return kind, q, dense_verdict(arm, cover, q, rng, spacing, 0.4 if k % 4 == 0 else None)


def main():
    """Attack an arm's cover at random poses of all kinds but the costly ones, which come once in so many."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("arm", choices=[*CATALOGUE, *ON_RAILS])
    parser.add_argument("count", type=int)
    parser.add_argument("seed", type=int)
    parser.add_argument("--dense", action="store_true", help="postures of the closed form, instead of walked ones")
    parser.add_argument("--first", type=int, default=0, help="the pose to begin at")
    parser.add_argument("--costly", type=int, help="once in how many poses a costly kind comes")
    parser.add_argument("--seconds", type=float, default=np.inf, help="after which no more poses are begun")
    parser.add_argument("--torch", action="store_true", help="with a tool off the last axis")
    given = parser.parse_args()
    arm = load(given.arm, tool=TORCH if given.torch else None)
    cover, costly = arm.cover(), given.costly or (500 if given.dense else 200)
    one_pose(arm, cover, given.arm, given.seed, 4, costly, given.dense)  # compiles
    totals, cells, seconds, began, done = {}, {}, {}, time.perf_counter(), 0
    for k in range(given.first, given.first + given.count):
        if time.perf_counter() - began > given.seconds:
            break
        kind, q, found = one_pose(arm, cover, given.arm, given.seed, k, costly, given.dense)
        done += 1
        total = totals.setdefault(kind, [0, 0, 0, 0.0])
        for i, value in enumerate((1, found.checked, found.missed)):
            total[i] += value
        total[3] = max(total[3], found.worst)
        cells.setdefault(kind, []).append(found.cells)
        seconds.setdefault(kind, []).append(found.seconds)
        for words in found.faults:
            print(f"{kind}, pose {k}, q = {q.tolist()}: {words}", flush=True)
        if found.seconds > 5.0:
            print(f"{kind}, pose {k}, q = {q.tolist()}: cover took {found.seconds:.1f} s", flush=True)
        if done % (100 if given.dense else 20) == 0:
            postures, missed = (sum(t[i] for t in totals.values()) for i in (1, 2))
            worst, slowest = max(t[3] for t in totals.values()), max(max(s) for s in seconds.values())
            print(
                f"{done} of {given.count}, {postures} postures, {missed} missed, worst excess {worst:.1e}, "
                f"most {slowest:.2f} s",
                file=sys.stderr, flush=True,
            )  # fmt: skip
    for kind, (poses, checked, missed, worst) in totals.items():
        print(
            f"{given.arm} {kind}: {poses} poses, {checked} postures, {missed} missed, worst excess {worst:.1e}, "
            f"cells median {np.median(cells[kind]):.0f} most {max(cells[kind])}, "
            f"seconds median {np.median(seconds[kind]):.3f} most {max(seconds[kind]):.2f}"
        )
    print(
        f"{given.arm}: {done} poses, {sum(t[1] for t in totals.values())} postures, "
        f"{sum(t[2] for t in totals.values())} missed, worst excess {max(t[3] for t in totals.values()):.1e}, "
        f"cover most {max(max(s) for s in seconds.values()):.2f} s, "
        f"{(time.perf_counter() - began) / done:.3f} s per pose in all"
    )
    return 1 if any(t[2] for t in totals.values()) else 0


if __name__ == "__main__":
    sys.exit(main())

"""Tries to find postures that covers of spatial arms leave out: self-motions walked along the null space.

    python tests/arms/attack_covers.py ARM COUNT SEED

Nothing here shares code with closed forms or covers: poses come from products of transforms, self-motions from steps of
Newton's method, started at random and at the posture that a pose was made from.
"""

import importlib.resources
import sys
import time
from typing import NamedTuple

import numba
import numpy as np
from scipy.optimize import brentq

from selfmotion.arms.catalogue import named_arm
from selfmotion.arms.spatial import SpatialArm
from selfmotion.arms.urdf import read_chain

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


def load(name, slack=None):
    """An arm by its name, joint limits wider by `slack`."""
    if name in ON_RAILS:
        arm = named_arm(name.split()[0], tool=TOOL, rail=RAIL)
        return arm if slack is None else arm.relaxed(np.full(arm.n, slack))
    text = (importlib.resources.files("selfmotion.arms") / "data" / f"{name}.urdf").read_text(encoding="utf-8")
    arm = SpatialArm(read_chain(text))
    return arm if slack is None else arm.relaxed(np.full(arm.n, slack))


@numba.njit(cache=True, error_model="numpy")
def pose_error(offsets, first, q, rotation, position, error, jacobian):
    """Fill in by how much a posture misses a pose (6,), and the Jacobian (6, n); joints before `first` slide."""
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
    for j in range(n):
        if j < first:
            jacobian[:3, j], jacobian[3:, j] = axes[j], 0.0
        else:
            jacobian[:3, j], jacobian[3:, j] = np.cross(axes[j], frame[:3, 3] - centers[j]), axes[j]
    error[:] = 0.0
    for i in range(3):
        error[i] = frame[i, 3] - position[i]
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
    error, jacobian = np.empty(6), np.empty((6, len(q)))
    best = np.inf
    for _ in range(steps):
        ahead = pose_error(offsets, first, q, rotation, position, error, jacobian)
        size = np.abs(error).max()
        if size < 1e-15 or (best < 1e-14 and size >= best):
            return size if ahead else np.inf
        best = min(best, size)
        u, s, vt = np.linalg.svd(jacobian, full_matrices=False)
        step = np.zeros(len(q))
        for k in range(6):
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
    error, jacobian = np.empty(6), np.empty((6, n))
    for way in (1.0, -1.0):
        q, before = start.copy(), np.zeros(n)
        for k in range(len(found) // 2):
            if count >= len(found):
                return count
            pose_error(offsets, first, q, rotation, position, error, jacobian)
            _, s, vt = np.linalg.svd(jacobian, full_matrices=True)
            found[count], steep[count] = q, s[5]
            count += 1
            tangent = vt[6] * (way if k == 0 else 1.0)
            if k == 0 and tangent[np.argmax(np.abs(vt[6]))] * way < 0:
                tangent = -tangent
            if k > 0:
                if s[5] < 1e-4:  # at a crossing: straight on
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
                    found[count], steep[count] = q, s[5]
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


def outside(cells, q, wraps):
    """By how much postures (k, n) are outside of the cells."""
    found = np.empty(len(q))
    all_excess(q, cells.a, cells.b, cells.bow, cells.dev, cells.rest, wraps, found)
    return found


def fold(arm):
    """The stretched elbow's angle, as near as limits allow."""
    stretched = 0.0
    if arm.closed_form.family.parameter == "q7":
        _, d3, a4, d5, a5, _ = arm.geometry
        stretched = (np.arctan2(d3, a4) - np.arctan2(d5, a5) + np.pi) % (2 * np.pi) - np.pi
    return float(np.clip(stretched - arm.closed_form.shift[3], arm.limits.lower[3], arm.limits.upper[3]))


def posture(arm, kind, rng):
    """A random posture within limits, of a kind."""
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
    offsets, rotation, position = arm.chain.offsets, arm.task(x).rotation, arm.task(x).position
    lower, upper, slides = arm.limits.lower, arm.limits.upper, int(arm.limits.slides.sum())
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
        count = walk(
            offsets, slides, q, rotation, position, lower, upper, step * rng.uniform(0.3, 1.0, 97), found, steep
        )
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
        pose = arm.forward(ends)
        turned = np.minimum(np.abs(pose[:, 3:] - x[3:]).max(axis=1), np.abs(pose[:, 3:] + x[3:]).max(axis=1))
        miss = np.maximum(np.abs(pose[:, :3] - x[:3]).max(axis=1), turned).max(initial=0.0)
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


def main(name, count, seed):
    """Attack an arm's cover at random poses of all kinds but the costly ones, which come once in two hundred."""
    arm = load(name)
    cover = arm.cover()
    rng = np.random.default_rng(seed)
    verdict(arm, cover, rng.uniform(arm.limits.lower, arm.limits.upper), rng)
    cheap = [kind for kind in KINDS if kind not in COSTLY]
    totals, cells, seconds = {}, {}, {}
    for k in range(count):
        kind = COSTLY[(k // 200) % len(COSTLY)] if k % 200 == 199 else cheap[k % len(cheap)]
        one = np.random.default_rng([seed, k])
        q = posture(arm, kind, one)
        found = verdict(arm, cover, q, one, spacings=(float(one.choice([0.3, 0.1, 0.02])),))
        total = totals.setdefault(kind, [0, 0, 0, 0.0])
        for i, value in enumerate((1, found.checked, found.missed)):
            total[i] += value
        total[3] = max(total[3], found.worst)
        cells.setdefault(kind, []).append(found.cells)
        seconds.setdefault(kind, []).append(found.seconds)
        for words in found.faults:
            print(f"{kind}, pose {k}, q = {q.tolist()}: {words}", flush=True)
        if k % 20 == 19:
            print(f"{k + 1} of {count}, {sum(t[1] for t in totals.values())} postures", file=sys.stderr, flush=True)
    for kind, (poses, checked, missed, worst) in totals.items():
        print(
            f"{name} {kind}: {poses} poses, {checked} postures, {missed} missed, worst excess {worst:.1e}, "
            f"cells median {np.median(cells[kind]):.0f} most {max(cells[kind])}, "
            f"seconds median {np.median(seconds[kind]):.3f} most {max(seconds[kind]):.2f}"
        )
    print(f"{name}: {sum(t[1] for t in totals.values())} postures, {sum(t[2] for t in totals.values())} missed")
    return 1 if any(t[2] for t in totals.values()) else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1], int(sys.argv[2]), int(sys.argv[3])))

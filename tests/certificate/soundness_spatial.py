"""Tries to refute proved lower bounds of spatial arms: random reachable lines, and motions found without any bound.

    python tests/certificate/soundness_spatial.py --arm panda --count 20 --seed 0 --kind turning --objective l2

Each path is followed by differential inverse kinematics from a random posture inside the limits, so that a motion is
there by construction. Rivals: that motion; shortest ways through ladders of its redundancy parameter; and, if asked
for, local refinement; and the motion planned, followed here. A bound above a rival's cost, or a claim that nothing
moves, is a violation; then the exit is 1.

With `--parameters 100 --finer 1` rivals cost about as much time as the planner, and are a little longer.
"""

import argparse
import itertools
import json
import os
import sys
import time
import traceback
from functools import lru_cache
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numba
import numpy as np

import selfmotion as sm
from selfmotion.arms.catalogue import CATALOGUE
from selfmotion.errors import InfeasibleError, SelfMotionError
from selfmotion.study import InProcess, Run

sys.path.insert(0, str(Path(__file__).parents[1] / "arms"))
from attack_covers import ON_RAILS, TORCH, load, pose_error, settled, target, with_turns, wrap

ROUNDING = 1e-9
SLABS = 160
WIDEST = 0.35  # step of a ladder, joint by joint [rad]
EXACT = 1e-12
ITSELF = 1e-3  # by which the cost of a plan may differ from what it is found to be here
ALONG = 1e-4  # of limits, where a plan moves along one of them [rad]
LATE = 1.2  # of its time limit, after which the planner is called late


def turned(rotation, vector):
    """A unit quaternion turned about an axis by the axis's length."""
    angle = np.linalg.norm(vector)
    w, v = np.cos(angle / 2), np.sin(angle / 2) * vector / max(angle, 1e-300)
    a, b = rotation[0], rotation[1:]
    return np.concatenate([[w * a - v @ b], w * b + a * v + np.cross(v, b)])


def corrected(arm, q, x, pull=None):
    """A posture near q at a pose, drawn along the self-motion towards `pull`; None if there is none."""
    offsets, slides, (rotation, position) = arm.chain.offsets, int(arm.chain.prismatic.sum()), target(x)
    q = np.array(q)
    if pull is not None:
        error, jacobian = np.empty(arm.n - 1), np.empty((arm.n - 1, arm.n))
        pose_error(offsets, slides, q, rotation, position, error, jacobian)
        null = np.linalg.svd(jacobian)[2][-1]
        q += null * np.clip(null @ pull, -0.02, 0.02)
    return q if settled(offsets, slides, q, rotation, position, 12, np.inf) < EXACT else None


def inside(arm, q, slack=0.0):
    """Whether postures are within limits."""
    return bool(((q >= arm.limits.lower - slack) & (q <= arm.limits.upper + slack)).all())


def followed(arm, path, q, steps=SLABS):
    """Postures (steps + 1, n) along a path from a posture, away from limits as far as may be; None if it ends early."""
    middle = 0.5 * (arm.limits.lower + arm.limits.upper)
    half = 0.5 * (arm.limits.upper - arm.limits.lower)
    found = []
    for r in np.linspace(0.0, 1.0, steps + 1):
        now = corrected(arm, q, path(r), 0.02 * (middle - q) / half**2)
        if now is None or not inside(arm, now) or (found and np.abs(now - q).max() > 0.2):
            return None
        found.append(now)
        q = now
    return np.array(found)


def reachable(arm, kind, rng):
    """A random line that some motion follows, and that motion."""
    while True:
        q = rng.uniform(arm.limits.lower, arm.limits.upper)
        x = arm.forward(q)
        way = rng.normal(size=3)
        way *= rng.uniform(0.1, 0.6) / np.linalg.norm(way)
        line = sm.Line(x[:3], x[:3] + way)
        if kind == "turning":
            axis = rng.normal(size=3)
            axis *= rng.uniform(0.1, 1.5) / np.linalg.norm(axis)
            path = sm.PosePath(line, orientations=[x[3:], turned(x[3:], axis)])
        else:
            path = sm.PosePath(line, orientation=x[3:])
        motion = followed(arm, path, q)
        if motion is not None:
            return path, motion


def dense(arm, path, r, q, slack, parts=4):
    """Postures between those of a motion, put onto the path one by one; None if the motion does not hold."""
    for _ in range(int(np.log2(parts))):
        between = []
        for k in range(len(r) - 1):
            at = 0.5 * (r[k] + r[k + 1])
            now = corrected(arm, 0.5 * (q[k] + q[k + 1]), path(at))
            if now is None or not inside(arm, now, slack) or np.abs(now - 0.5 * (q[k] + q[k + 1])).max() > 0.1:
                return None
            between.append(now)
        r = np.insert(r, np.arange(1, len(r)), 0.5 * (r[1:] + r[:-1]))
        q = np.insert(q, np.arange(1, len(q)), between, axis=0)
    return r, q


def cost_of(problem, r, q):
    """The cost of a motion by chords, and by how much finer chords may add: their sums grow by a quarter each time."""

    def chords(step):
        return float(problem.objective.chord(np.diff(q[::step], axis=0), np.diff(r[::step]), problem.weights).sum())

    fine, coarse = chords(1), chords(2)
    return fine, max(fine - coarse, 0.0)


def verified(problem, r, q, slack=0.0):
    """The cost (with what chords may miss) of a motion through postures; infinite if it does not hold."""
    found = dense(problem.arm, problem.path, r, q, slack)
    if found is None:
        return np.inf
    cost, more = cost_of(problem, *found)
    return cost + more


def wide(arm):
    """Joints that may turn two whole turns: where a motion is, a whole turn aside, does not matter."""
    return arm.limits.upper - arm.limits.lower >= 4 * np.pi - 1e-9


def rung(arm, x, parameters):
    """All feasible postures (k, n) at a pose, for many parameters."""
    found = []
    for branch in range(len(arm.branches)):
        q, ok = arm.solve(np.broadcast_to(x, (len(parameters), 7)), parameters[:, None], branch)
        q = with_turns(arm, q[ok], wide(arm))
        found.append(q[((q >= arm.limits.lower) & (q <= arm.limits.upper)).all(axis=1)])
    return np.concatenate(found)


@numba.njit(cache=True)
def neighbours(before, after, modulo):
    """Pairs of rows of postures of one rung and the next that are near to each other."""
    found = [(0, 0)]
    for i in range(len(after)):
        for k in range(len(before)):
            near = True
            for j in range(before.shape[1]):
                step = after[i, j] - before[k, j]
                if modulo[j]:
                    step -= 2 * np.pi * np.rint(step / (2 * np.pi))
                if abs(step) > WIDEST:
                    near = False
                    break
            if near:
                found.append((k, i))
    return np.array(found)[1:]


@numba.njit(cache=True)
def choose(pairs, total, best, where):
    """Fill in the least total of every posture of a rung, and of which it is in the one before."""
    for k in range(len(pairs)):
        i = pairs[k, 1]
        if total[k] < best[i]:
            best[i], where[i] = total[k], pairs[k, 0]


def ladder(problem, r, rungs):
    """The cheapest way through rungs of postures, or None."""
    costs, back = np.zeros(len(rungs[0])), []
    modulo = wide(problem.arm)
    for k in range(1, len(rungs)):
        if not len(rungs[k]) or not len(rungs[k - 1]):
            return None
        best, where = np.full(len(rungs[k]), np.inf), np.zeros(len(rungs[k]), int)
        pairs = neighbours(rungs[k - 1], rungs[k], modulo)
        if len(pairs):
            step = rungs[k][pairs[:, 1]] - rungs[k - 1][pairs[:, 0]]
            step[:, modulo] = wrap(step[:, modulo])
            total = problem.objective.chord(step, np.full(len(step), r[k] - r[k - 1]), problem.weights)
            choose(pairs, costs[pairs[:, 0]] + total, best, where)
        costs = best
        back.append(where)
    if not np.isfinite(costs).any():
        return None
    at = int(costs.argmin())
    way = [rungs[-1][at]]
    for k in range(len(back) - 1, -1, -1):
        at = int(back[k][at])
        way.append(rungs[k][at])
    return unwound(problem.arm, np.array(way[::-1]))


def unwound(arm, way):
    """A motion of postures (k, n) without jumps by whole turns, those of wide joints inside their limits."""
    way = way.copy()
    for j in np.flatnonzero(wide(arm)):
        way[:, j] = np.unwrap(way[:, j])
        way[:, j] += 2 * np.pi * np.ceil((arm.limits.lower[j] - way[:, j].min()) / (2 * np.pi))
    return way


def climbed(problem, parameters, finer):
    """Cost of the best motion along a ladder of the parameter, made finer around itself a few times."""
    arm, path = problem.arm, problem.path
    r = np.linspace(0.0, 1.0, 41)
    low, high = arm.parameter_range
    way = ladder(problem, r, [rung(arm, path(at), np.linspace(low, high, parameters)) for at in r])
    best = np.inf
    width = 2 * (high - low) / parameters
    for _ in range(finer):
        if way is None:
            break
        best = min(best, verified(problem, r, way))
        u = arm.u_of(way)[:, 0]
        rungs = []
        for k, at in enumerate(r):
            near = rung(arm, path(at), u[k] + np.linspace(-width, width, 21))
            apart = near - way[k]
            apart[:, wide(arm)] = wrap(apart[:, wide(arm)])
            rungs.append(np.concatenate([near[np.abs(apart).max(axis=1) < 0.5], way[k : k + 1]]))
        way = ladder(problem, r, rungs)
        width /= 6
    return best if way is None else min(best, verified(problem, r, way))


def refined(problem, seed, seconds):
    """Cost of the package's local planner."""
    try:
        plan = sm.plan(problem, sm.Refine(starts=4, seed=seed, time_limit=seconds))
    except (SelfMotionError, NotImplementedError):
        return np.inf
    r = np.linspace(0.0, 1.0, 401)
    return verified(problem, r, plan(r))


@lru_cache
def arm_of(name, torch):
    return load(name, tool=TORCH if torch else None)


def task(specification):
    """A case as a run of a study; numbers as text, for JSON knows no infinity."""
    given = argparse.Namespace(**specification)
    status, cost, bound, seconds, who, best, wrong = row_of(arm_of(given.arm, given.torch), given, given.case)
    return {"row": [status, repr(float(cost)), repr(float(bound)), seconds, who, repr(float(best)), bool(wrong)]}


def told(outcome):
    """The row of a case again."""
    if outcome.failure is not None:
        raise RuntimeError(json.loads(outcome.failure)["traceback"])
    status, cost, bound, seconds, who, best, wrong = json.loads(outcome.result)["row"]
    return status, float(cost), float(bound), seconds, who, float(best), wrong


def row_of(arm, given, k):
    """One case: what is proved, and what rivals do."""
    rng = np.random.default_rng([given.seed, k])
    path, motion = reachable(arm, given.kind, rng)
    problem = sm.Problem(arm, path, objective=given.objective)
    motions = {
        "followed": lambda: verified(problem, np.linspace(0.0, 1.0, len(motion)), motion),
        "ladder": lambda: climbed(problem, given.parameters, given.finer),
        "refined": lambda: refined(problem, k, given.time_limit),
    }
    rivals = {name: motions[name]() for name in given.rivals}
    began, cost, bound = time.perf_counter(), np.nan, np.nan
    try:
        plan = sm.plan(problem, sm.Global(gap=given.gap, time_limit=given.time_limit))
        status, cost, bound = "solved", plan.cost, plan.lower_bound
    except InfeasibleError:
        status = "infeasible"
    except SelfMotionError as error:
        status = type(error).__name__
    except Exception as error:  # a harness tells of it, and goes on
        traceback.print_exc()
        status = f"BROKEN {type(error).__name__}"
    seconds = time.perf_counter() - began
    if status == "solved":  # the planner's own motion, followed here: that it holds, and what it costs
        r = np.linspace(0.0, 1.0, SLABS + 1)
        rivals["itself"] = found = verified(problem, r, plan(r))
        if not np.isfinite(found):  # along a limit, which postures put onto the path in between may leave
            found = verified(problem, r, plan(r), ALONG)
        if not abs(found - cost) < ITSELF * cost:
            status = f"solved? {found:.5f}"
    best = min(rivals.values())
    wrong = status.startswith(("infeasible", "BROKEN")) or (np.isfinite(bound) and bound > best * (1 + ROUNDING))
    wrong = wrong or (np.isfinite(bound) and bound > cost * (1 + ROUNDING))
    return status, cost, bound, seconds, min(rivals, key=rivals.get), best, wrong


def main(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--arm", default="panda", choices=[*CATALOGUE, *ON_RAILS])
    parser.add_argument("--torch", action="store_true", help="with a tool off the last axis")
    parser.add_argument("--count", type=int, default=20)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--gap", type=float, default=2e-3)
    parser.add_argument("--time-limit", type=float, default=10.0)
    parser.add_argument("--objective", choices=("l2", "joint_travel", "l1"), default="l2")
    parser.add_argument("--kind", choices=("constant", "turning"), default="constant")
    parser.add_argument("--first", type=int, default=0, help="the case to begin at")
    parser.add_argument(
        "--rivals", type=lambda text: text.split(","), default=["followed", "ladder"], help="of followed,ladder,refined"
    )
    parser.add_argument("--parameters", type=int, default=400, help="of a rung of the first ladder")
    parser.add_argument("--finer", type=int, default=3, help="how often ladders are made finer")
    parser.add_argument("--seconds", type=float, default=np.inf, help="after which no more cases are begun")
    given = parser.parse_args(arguments)
    settings = {name: value for name, value in vars(given).items() if name not in ("first", "count", "seconds")}
    rows, began = [], time.perf_counter()
    print("case status       cost     bound      gap  seconds  best rival")
    cases = itertools.takewhile(
        lambda _: time.perf_counter() - began <= given.seconds, range(given.first, given.first + given.count)
    )
    work = (Run("soundness_spatial:task", {**settings, "case": k}).work() for k in cases)
    for k, outcome in enumerate(InProcess().outcomes(work), given.first):
        row = told(outcome)
        rows.append(row)
        status, cost, bound, seconds, who, best, wrong = row
        print(
            f"{k:4d} {status:10s} {cost:8.5f} {bound:8.5f} {(cost - bound) / cost:9.2e} {seconds:7.1f}  "
            f"{best:8.5f} {who}{'  VIOLATION' if wrong else ''}"
            f"{'  LATE' if seconds > LATE * given.time_limit else ''}",
            flush=True,
        )
    solved = [row for row in rows if row[0].startswith("solved")]
    gaps = np.array([(row[1] - row[2]) / row[1] for row in solved])
    wrong = sum(row[6] for row in rows)
    beaten = sum(row[5] < row[1] * (1 - 1e-4) for row in solved)
    name = f"{given.arm}{' with torch' if given.torch else ''}"
    print(
        f"{name}, {given.kind}, {given.objective}: {len(solved)} of {len(rows)} solved, "
        f"{int((gaps <= given.gap).sum())} to the gap, {wrong} violations, planner beaten by 1e-4 {beaten} times, "
        f"{sum(row[3] > LATE * given.time_limit for row in rows)} late, "
        f"{sum(not np.isfinite(row[5]) for row in rows)} without a rival, "
        f"{(time.perf_counter() - began) / max(len(rows), 1):.1f} s per case in all"
    )
    if solved:
        print(
            f"gap median {np.median(gaps):.1e} most {gaps.max():.1e}; "
            f"seconds median {np.median([row[3] for row in solved]):.1f} most {max(row[3] for row in rows):.1f}"
        )
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())

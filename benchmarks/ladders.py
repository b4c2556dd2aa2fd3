"""The global planner beside ladders: dynamic programming over a grid of postures, as planners in use do it."""

import importlib.util
import json
import subprocess
import sys
import time
from pathlib import Path

import numba
import numpy as np
from measuring import by_turns, peak_memory

import selfmotion as sm

GRIDS = (60, 240, 960, 3840)
PLACES = 200
GAP = 1e-3
CASES = {
    "seed's Bezier, start 0.3": sm.Problem(
        sm.PlanarArm([30, 30, 20], [None, (0, np.pi), None]),
        sm.Bezier([[50, -10], [85, 30], [50, 50], [60, -10], [58, 30], [70, -10]]),
        start=[0.3],
        elbow="positive",
    ),
    "Kazerounian–Wang circle, free start": sm.Problem(
        sm.PlanarArm([7, 7, 4, 1.5], direction=np.radians(-60)), sm.Circle([6, 4], 4), elbow="positive"
    ),
}
"""On one elbow each, which is all that a plain ladder knows of."""


@numba.njit(cache=True, error_model="numpy", fastmath={"reassoc", "contract", "nsz", "arcp"}, nogil=True)
def _climb(before, here, value, run, wraps, out, source):
    """Fill `out` and `source`: the least value of each posture of a rung, and where it comes from."""
    n = before.shape[0]
    turn, over = 2.0 * np.pi, 0.5 / np.pi
    cost = np.empty(before.shape[1])
    for j in range(here.shape[1]):
        for i in range(len(cost)):
            cost[i] = value[i]
        for joint in range(n):
            at, row = here[joint, j], before[joint]
            if wraps[joint]:
                for i in range(len(cost)):
                    step = at - row[i]
                    step -= turn * np.rint(step * over)
                    cost[i] += np.sqrt(run * run + step * step)
            else:
                for i in range(len(cost)):
                    step = at - row[i]
                    cost[i] += np.sqrt(run * run + step * step)
        best = 0
        for i in range(len(cost)):
            if cost[i] < cost[best]:
                best = i
        out[j], source[j] = cost[best], best


def ladder(problem, grid, places=PLACES):
    """Return the u (places,) of the best polygon over a uniform grid of u, and its chord sum in joint travel."""
    arm, r = problem.arm, np.linspace(0.0, 1.0, places)
    x, u = problem.path(r), np.linspace(-np.pi, np.pi, grid, endpoint=False)
    branch = problem.elbow_branches[0]
    rungs, directions, value, sources = [], [], None, []
    for k in range(places):
        at = u if k or problem.start is None else problem.start.u
        q, ok = arm.solve(x[k], at[:, None], branch)
        ok &= (arm.limits.excess(q) <= 1e-9).all(axis=1)
        rungs.append(np.ascontiguousarray(q[ok].T))
        directions.append(at[ok])
        if k == 0:
            value = np.zeros(ok.sum())
            continue
        out, source = np.empty(ok.sum()), np.empty(ok.sum(), dtype=np.int64)
        _climb(rungs[-2], rungs[-1], value, r[k] - r[k - 1], ~arm.limits.limited, out, source)
        value = out
        sources.append(source)
    at = int(np.argmin(value))
    chosen, chords = [directions[-1][at]], float(value[at])
    for k in range(places - 1, 0, -1):
        at = sources[k - 1][at]
        chosen.append(directions[k - 1][at])
    return np.array(chosen[::-1]), chords


def travel(problem, u):
    """Return what the motion that turns u evenly between a ladder's postures costs, inf where it leaves reach."""
    r, branch = np.linspace(0.0, 1.0, len(u)), problem.elbow_branches[0]
    u = np.unwrap(u)
    slope = np.diff(u) / np.diff(r)

    def rates(at):
        piece = np.clip(np.searchsorted(r, at, side="right") - 1, 0, len(slope) - 1)
        here = u[piece] + slope[piece] * (at - r[piece])
        found = problem.arm.rates(
            problem.path(at), problem.path(at, 1), here[:, None], slope[piece][:, None], branch
        )  # fmt: skip
        return np.nan_to_num(found, nan=1e9, posinf=1e9, neginf=-1e9)

    value = problem.objective.integral(rates, r, problem.weights).value
    return value if value < 1e6 else np.inf


def _memory(name, grid):
    """Return the peak of a fresh interpreter that plans once, in MB."""
    head = f"import ladders\nproblem = ladders.CASES[{name!r}]\n"
    if grid is None:
        return peak_memory(head + f"ladders.sm.plan(problem, ladders.sm.Global({GAP}))")
    return peak_memory(head + f"ladders.ladder(problem, {grid})")


def run(quick):
    """Return a table per case, and Descartes where it is installed."""
    rounds, grids = (1, GRIDS[:2]) if quick else (5, GRIDS)
    cases = {}
    for name, problem in CASES.items():
        contenders = {grid: lambda _, grid=grid, problem=problem: ladder(problem, grid) for grid in grids}
        contenders["global"] = lambda _, problem=problem: sm.plan(problem, sm.Global(GAP))
        times = by_turns(contenders, rounds)
        plan = times["global"].results[-1]
        rows = []
        for grid in grids:
            u, chords = times[grid].results[-1]
            rows.append(
                {
                    "grid": grid, "seconds": times[grid].median, "ratio": times[grid].over(times["global"]),
                    "chords": chords, "travel": travel(problem, u), "memory_mb": _memory(name, grid),
                }
            )  # fmt: skip
        cases[name] = {
            "ladders": rows,
            "global": {
                "seconds": times["global"].median, "cost": plan.cost, "cost_error": plan.cost_error,
                "bound": plan.lower_bound, "gap": plan.gap, "memory_mb": _memory(name, None),
            },
        }  # fmt: skip
    return {"cases": cases, "places": PLACES, "rounds": rounds, "gap": GAP, "descartes": descartes(quick)}


def descartes(quick):
    """Return what Descartes, from the Tesseract packages, makes of the seed's case; None where it is not installed."""
    if importlib.util.find_spec("tesseract_robotics") is None:
        return None
    command = [sys.executable, str(Path(__file__).with_name("descartes.py")), *(["--quick"] if quick else [])]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=600)
    if done.returncode:
        return {"failed": (done.stderr.strip().splitlines() or ["no message"])[-1]}
    return json.loads(done.stdout.splitlines()[-1])


def text(result):
    """Return the section of the report."""
    lines = []
    for name, case in result["cases"].items():
        best = case["global"]
        lines += [
            f"**{name}.** A ladder over {result['places']} places, every posture of a rung tried from every one of the "
            "rung before. *Chords* is what it minimises, the chord sum over its places, below its motion's cost; "
            "*travel* is the integral of the motion that turns u evenly between postures, ∞ where that leaves reach.",
            "",
            "| planner | s | × global | quartiles | chords | travel | bound | MB |",
            "|---|---|---|---|---|---|---|---|",
        ]
        for row in case["ladders"]:
            ratio, low, high = row["ratio"]
            shown = f"{row['travel']:.6f}" if np.isfinite(row["travel"]) else "∞"
            lines.append(
                f"| ladder, {row['grid']} | {row['seconds']:.3f} | {ratio:.2f} | {low:.2f}–{high:.2f} | "
                f"{row['chords']:.6f} | {shown} | none | {row['memory_mb']} |"
            )
        lines += [
            f"| **global, gap {result['gap']:g}** | {best['seconds']:.3f} | 1.00 | | | **{best['cost']:.6f}** | "
            f"{best['bound']:.6f} | {best['memory_mb']} |",
            "",
        ]
    found = result["descartes"]
    if found is None:
        lines.append("Descartes (Tesseract, `pip install tesseract-robotics`) is missing here.")
    elif "failed" in found:
        lines.append(f"Descartes is installed and failed: {found['failed']}")
    else:
        lines.append(found["text"])
    return lines


def main():
    """Print the section."""
    began = time.perf_counter()
    print("\n".join(text(run("--quick" in sys.argv))))
    print(f"{time.perf_counter() - began:.0f} s")


if __name__ == "__main__":
    main()

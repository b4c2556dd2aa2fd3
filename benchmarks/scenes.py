"""Obstacles: what each costs, that none costs nothing, and two named cases with what is proved of them.

Run as ``python benchmarks/scenes.py``; with ``--quick`` few sizes and rounds. Seconds are the processor's, of calls
that are warm. The named cases:

- three discs, the paper's 3R arm and Bezier path: disc A stands in the way of the first link, which has to pass on one
  side of it all along, and so divides all motions into two classes. Without disc B the cheapest motion is on the side
  of the optimum without obstacles, and the other side is proved to cost more; B closes that side, which is proved too,
  and the cheapest motion is on the other one.
- Panda line with a box: ``examples/panda_line.yaml`` with a box of 0.25 m beside the base.
"""

import argparse
import time
from pathlib import Path

import numpy as np
from measuring import exponent

import selfmotion as sm
from selfmotion.errors import InfeasibleError
from selfmotion.exchange import load_problem
from selfmotion.report import seed_3r
from selfmotion.scene import BoxObstacle, CircleObstacle

COUNTS = (1, 2, 4, 8, 16, 32, 64)
GAP, ROUGH = 1e-3, 1e-2
GOLDEN = 0.5 * (np.sqrt(5.0) - 1.0)
DIVIDES, LIMIT = -0.1, 60.0
A, B, C = (
    CircleObstacle((radius * np.cos(angle), radius * np.sin(angle)), size)
    for radius, angle, size in ((16.0, DIVIDES, 2.5), (20.0, -0.42, 4.0), (24.0, 0.75, 2.0))
)
SIDES = {"below": (DIVIDES - np.pi, DIVIDES), "above": (DIVIDES, DIVIDES + np.pi)}
"""Limits of joint 1 that hold motions on one side of disc A, whose centre link 1 cannot pass."""
BOX = BoxObstacle((0.0, 0.2, 0.7), (0.25, 0.25, 0.25))
PANDA = Path(__file__).parents[1] / "examples" / "panda_line.yaml"


def planned(problem, gap):
    """Return what is found of a problem, with the processor's seconds."""
    began = time.process_time()
    try:
        plan = sm.plan(problem, sm.Global(gap=gap, time_limit=LIMIT))
        found = {"cost": plan.cost, "bound": plan.lower_bound, "gap": plan.gap, **plan.verification.margins}
    except InfeasibleError as error:
        found = {"cost": None, "bound": None, "gap": None, "why": str(error)}
    return {**found, "seconds": time.process_time() - began}


def seed_problem(obstacles, side=None):
    """Return the paper's 3R problem among obstacles; on one side of disc A, if one is given."""
    case = seed_3r.problem()
    limits = [SIDES.get(side), (0.0, np.pi), None]
    return sm.Problem(sm.PlanarArm(case.arm.links, limits), case.path, obstacles=obstacles)


def ring(count):
    """Return so many discs behind the arm, the same ones first."""
    angles = np.pi * (0.45 + 1.1 * ((np.arange(count) + 0.5) * GOLDEN % 1.0))
    return [CircleObstacle((45.0 * np.cos(angle), 45.0 * np.sin(angle)), 0.5) for angle in angles]


def three_discs():
    """Return what is found with and without disc B, on both sides and on either alone."""
    cases = {
        "no obstacle": ((), None), "A and C": ((A, C), None), "A and C, above": ((A, C), "above"),
        "A, B and C": ((A, B, C), None), "A, B and C, below": ((A, B, C), "below"),
    }  # fmt: skip
    planned(seed_problem([A]), GAP)  # kernels are loaded
    return {name: planned(seed_problem(obstacles, side), GAP) for name, (obstacles, side) in cases.items()}


def panda():
    """Return what is found of the Panda's line with and without the box."""
    free = load_problem(PANDA).problem
    boxed = sm.Problem(free.arm, free.path, objective="l2", obstacles=[BOX])
    planned(boxed, 0.5)
    return {"no obstacle": planned(free, ROUGH), "the box": planned(boxed, ROUGH)}


def by_count(counts, rounds):
    """Return the least seconds with so many discs, and per added disc, the exponent fitted."""
    seconds = dict.fromkeys(counts, np.inf)
    for _ in range(rounds + 1):
        for count in counts:
            seconds[count] = min(seconds[count], planned(seed_problem(ring(count)), GAP)["seconds"])
    return {"seconds": seconds, "exponent": exponent(list(counts), list(seconds.values())) if len(counts) > 3 else None}


def empty(rounds):
    """Return median and quartiles of how many times as long an empty scene takes, round by round in turns."""
    case, times = seed_3r.problem(), []
    for k in range(rounds + 1):
        both = {}
        for name in ("with", "without")[:: 1 if k % 2 else -1]:
            given = {"obstacles": ()} if name == "with" else {}
            both[name] = planned(sm.Problem(case.arm, case.path, **given), GAP)["seconds"]
        times.append(both["with"] / both["without"])
    return [float(q) for q in np.quantile(times[1:], (0.5, 0.25, 0.75))]


def run(quick):
    """Return everything."""
    counts, rounds = (COUNTS[:3], 1) if quick else (COUNTS, 3)
    found = {"by count": by_count(counts, rounds), "empty": empty(3 if quick else 15), "three discs": three_discs()}
    return found if quick else {**found, "panda": panda()}


def text(found):
    """Return it as lines."""
    seconds = found["by count"]["seconds"]
    lines = ["| discs | s | s per disc added to one |", "|---:|---:|---:|"]
    first = min(seconds)
    for count, each in seconds.items():
        added = "" if count == first else f"{(each - seconds[first]) / (count - first):.4f}"
        lines.append(f"| {count} | {each:.3f} | {added} |")
    if found["by count"]["exponent"] is not None:
        lines += ["", f"Seconds grow as discs to the power {found['by count']['exponent']:.2f}."]
    median, low, high = found["empty"]
    lines += ["", f"An empty scene takes {median:.3f} times as long as none (quartiles {low:.3f} to {high:.3f})."]
    for name in ("three discs", "panda"):
        if name not in found:
            continue
        lines += ["", f"| {name} | cost | proved | gap | clearance | s |", "|---|---:|---:|---:|---:|---:|"]
        for case, row in found[name].items():
            if row["cost"] is None:
                lines.append(f"| {case} | proved that there is no motion | | | | {row['seconds']:.2f} |")
                continue
            clearance = f"{row['clearance']:.3g}" if "clearance" in row else ""
            figures = f"{row['cost']:.5f} | {row['bound']:.5f} | {row['gap']:.1e}"
            lines.append(f"| {case} | {figures} | {clearance} | {row['seconds']:.2f} |")
    return lines


def main():
    """Print it all."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="few sizes and rounds")
    print("\n".join(text(run(parser.parse_args().quick))))


if __name__ == "__main__":
    main()

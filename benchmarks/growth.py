"""How time and memory grow: with samples, links, and pieces of the path; exponents of time ~ sizeᵖ."""

import time

import numpy as np
from measuring import exponent, peak_memory

import selfmotion as sm
from selfmotion.planners import PlanarCandidates
from selfmotion.profiles import SinusoidProfile

SAMPLES = (100, 1_000, 10_000, 100_000, 1_000_000)
LINKS = (3, 4, 6, 8, 12, 16, 22, 30)
PIECES = (1, 3, 10, 30, 100, 300, 1_000)
BEZIER = sm.Bezier([[50, -10], [85, 30], [50, 50], [60, -10], [58, 30], [70, -10]])
SEARCH = {"population": 10, "iterations": 10, "bounds": (0.0, 3.0), "seed": 1}


def by_samples(samples):
    """Return a problem and its profile, with so many samples."""
    problem = sm.Problem(
        sm.PlanarArm([30, 30, 20], [None, (0, np.pi), None]), BEZIER, elbow="positive", samples=samples
    )
    return problem, SinusoidProfile([0.3], [0.4])


def by_links(links):
    """Return the same for an arm of so many links: the third one of the seed's arm, divided."""
    arm = sm.PlanarArm([30, 30, *[20 / (links - 2)] * (links - 2)])
    problem = sm.Problem(arm, BEZIER, elbow="positive", samples=1000)
    return problem, SinusoidProfile(np.full(links - 2, 0.3), np.full(links - 2, 0.1))


def by_pieces(pieces):
    """Return the same for a path of so many straight pieces along the Bezier curve, eight samples on each."""
    path = sm.Waypoints(BEZIER(np.linspace(0.0, 1.0, pieces + 1)), "linear")
    problem = sm.Problem(
        sm.PlanarArm([30, 30, 20], [None, (0, np.pi), None]), path, elbow="positive", samples=max(1000, 8 * pieces)
    )
    return problem, SinusoidProfile([0.3], [0.4])


AXES = {"samples": (SAMPLES, by_samples), "links": (LINKS, by_links), "path pieces": (PIECES, by_pieces)}


def _least(run, least_time):
    """Return the least of the seconds that repeated calls take, one call at least."""
    run()
    found, began = [], time.perf_counter()
    while not found or time.perf_counter() - began < least_time:
        started = time.perf_counter()
        run()
        found.append(time.perf_counter() - started)
    return min(found)


def row(make, size, least_time):
    """Return the seconds of one candidate in both rankings, of a search's plan, and of the proof where there is one."""
    problem, profile = make(size)
    dimension = len(profile.parameter_names)
    candidate = np.full((1, dimension), 0.5)
    chords, integral = (PlanarCandidates(problem, profile, 0, ranking=ranking) for ranking in ("samples", "integral"))
    planner = sm.Sinusoid(profile.offset, amplitude=profile.amplitude, optimizer=sm.PSO(**SEARCH))
    found = {
        "size": size,
        "chord sum": _least(lambda: chords(candidate), least_time),
        "integral": _least(lambda: integral(candidate), least_time),
        "whole plan": _least(lambda: sm.plan(make(size)[0], planner), least_time),
    }
    return found


def run(quick):
    """Return a table per axis with fitted exponents, and the peak memory of the largest plan."""
    least_time, found = (0.02, {}) if quick else (0.3, {})
    for axis, (every, make) in AXES.items():
        sizes = every[:3] if quick else every
        rows = [row(make, size, least_time) for size in sizes]
        columns = [name for name in rows[0] if name != "size"]
        found[axis] = {
            "rows": rows,
            "exponents": {name: exponent(np.array(sizes), np.array([r[name] for r in rows])) for name in columns},
            "memory_mb": _memory(axis, sizes[-1]),
        }
    return found


def _memory(axis, size):
    """Return the peak of a fresh interpreter that makes one plan, in MB."""
    return peak_memory(
        f"import growth\nproblem, profile = growth.AXES[{axis!r}][1]({size})\n"
        "pso = growth.sm.PSO(**growth.SEARCH)\n"
        "growth.sm.plan(problem, growth.sm.Sinusoid(profile.offset, amplitude=profile.amplitude, optimizer=pso))"
    )


def text(result):
    """Return the section of the report."""
    lines = []
    for axis, table in result.items():
        columns = list(table["exponents"])
        lines += [
            f"**{axis}**, seconds:",
            "",
            f"| {axis} | " + " | ".join(columns) + " |",
            "|---" * (len(columns) + 1) + "|",
            *(f"| {r['size']:,} | " + " | ".join(f"{r[name]:.3g}" for name in columns) + " |" for r in table["rows"]),
            "| exponent | " + " | ".join(f"**{table['exponents'][name]:.2f}**" for name in columns) + " |",
            "",
            f"The largest plan takes {table['memory_mb']} MB, imports included.",
            "",
        ]
    lines.append(
        "One candidate by its chord sum and by its integral (to 1e-8); a whole plan is the check of the path, "
        f"{SEARCH['population']} × {SEARCH['iterations']} candidates and the verification. Exponents are fitted to the "
        "larger half of the sizes. A candidate of n links has n − 2 frequencies; a path of many pieces has eight "
        "samples on each, 1000 at least, so its last exponents are those of samples and pieces together."
    )
    return lines

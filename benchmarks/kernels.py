"""The objective alone: in numpy, in numba with libm, ours, and what the machine's arithmetic allows."""

import json
import math
import os
import subprocess
import sys
from pathlib import Path

import numba
import numpy as np
from measuring import by_turns
from seed_case import AMPLITUDE, LINKS, OFFSET, PATH, SAMPLES, candidates, in_numpy

POPULATION = 200
KINDS = ("add", "multiply", "root", "divide")
FAST = {"reassoc", "contract", "nsz", "arcp"}

_R = np.linspace(0.0, 1.0, SAMPLES)
_X, _Y = np.ascontiguousarray(PATH(_R).T)


@numba.njit(fastmath=FAST, error_model="numpy", nogil=True)
def with_libm(f, r, x, y, l1, l2, l3, offset, amplitude):
    """Return the chord sum as a user of numba would write it: one loop, functions of libm, steps wrapped."""
    total, before1, before2, before_u = 0.0, 0.0, 0.0, 0.0
    turn, run = 2.0 * math.pi, (r[1] - r[0]) ** 2
    for i in range(len(r)):
        u = offset + amplitude * math.sin(2.0 * math.pi * f * r[i])
        wx, wy = x[i] - l3 * math.cos(u), y[i] - l3 * math.sin(u)
        cosine = (wx * wx + wy * wy - l1 * l1 - l2 * l2) / (2.0 * l1 * l2)
        if abs(cosine) > 1.0:
            return 1e3
        second = math.acos(cosine)
        first = math.atan2(wy, wx) - math.atan2(l2 * math.sqrt(1.0 - cosine * cosine), l1 + l2 * cosine)
        if i > 0:
            a, b = first - before1, second - before2
            c = u - before_u - a - b
            a -= turn * np.rint(a / turn)
            c -= turn * np.rint(c / turn)
            total += math.sqrt(run + a * a) + math.sqrt(run + b * b) + math.sqrt(run + c * c)
        before1, before2, before_u = first, second, u
    return total


@numba.njit(fastmath=FAST, nogil=True)
def _multiply_add(x, out, repeats):
    for _ in range(repeats):
        for i in range(len(x)):
            a, b, c, d = x[i], x[i] + 1.0, x[i] + 2.0, x[i] + 3.0
            for _ in range(8):
                a, b = a * 0.5 + c, b * 0.25 + d
                c, d = c * 0.125 + a, d * 0.75 + b
            out[i] = a + b + c + d


@numba.njit(fastmath=FAST, nogil=True)
def _root(x, out, repeats):
    for k in range(repeats):
        for i in range(len(x)):
            out[i] = math.sqrt(x[i] + k)


@numba.njit(fastmath=FAST, error_model="numpy", nogil=True)
def _divide(x, out, repeats):
    for k in range(repeats):
        for i in range(len(x)):
            out[i] = x[i] / (x[i] + k)


def throughput(rounds):
    """Return the ns that one operation takes in vector loops over what stays in the first cache."""
    x, out, repeats = np.linspace(1.0, 2.0, 512), np.empty(512), 40
    loops = {"multiply-add": (_multiply_add, 32), "root": (_root, 1), "divide": (_divide, 1)}
    times = by_turns(
        {name: lambda _, loop=loop: loop(x, out, repeats) for name, (loop, _) in loops.items()}, 5 * rounds
    )
    return {
        name: 1e9 * float(times[name].seconds.min()) / (repeats * len(x) * each) for name, (_, each) in loops.items()
    }


def operations():
    """Return the operations per sample and node, counted where nothing is compiled."""
    run = subprocess.run(
        [sys.executable, "operations.py"], cwd=Path(__file__).parent, capture_output=True, text=True, check=True,
        env={**os.environ, "NUMBA_DISABLE_JIT": "1"},
    )  # fmt: skip
    return json.loads(run.stdout)


def ceiling(counted, each):
    """Return the least ns per place: every product fused with a sum, divider and multipliers never waiting."""
    fused = 0.5 * (counted["add"] + counted["multiply"]) * each["multiply-add"]
    divider = counted["root"] * each["root"] + counted["divide"] * each["divide"]
    return max(fused, divider)


def run(quick):
    """Return times per evaluation of 1000 samples, or of one integral, in ns."""
    rounds = 3 if quick else 25
    frequencies = np.random.default_rng(0).uniform(0.0, 15.0, POPULATION)
    samples, integral = candidates("samples"), candidates("integral")
    near = np.full((POPULATION, 1), 0.5385)
    contenders = {
        "numpy": lambda _: [in_numpy(f) for f in frequencies],
        "numba with libm": lambda _: [
            with_libm(f, _R, _X, _Y, *LINKS, OFFSET, AMPLITUDE) for f in frequencies
        ],
        "ours, 1000 chords": lambda _: samples(frequencies[:, None]),
        "ours, integral to 1e-8, any f": lambda _: integral(frequencies[:, None]),
        "ours, integral to 1e-8, near the best f": lambda _: integral(near),
    }  # fmt: skip
    times = by_turns(contenders, rounds, together=3)
    wanted = times["numpy"].results[-1]
    for name in ("numba with libm", "ours, 1000 chords"):
        np.testing.assert_allclose(times[name].results[-1], wanted, rtol=1e-11)
    counted, each = operations(), throughput(rounds)
    return {
        "rows": [
            {"name": name, "ns": 1e9 * t.median / POPULATION, "ratio": times["numpy"].over(t)}
            for name, t in times.items()
        ],
        "rounds": rounds,
        "operations": counted,
        "ns_per_operation": each,
        "ceiling_ns": {"chord": ceiling(counted["chord"], each), "node": ceiling(counted["node"], each)},
    }


def text(result):
    """Return the section of the report."""
    lines = [
        f"One evaluation of the seed's 3R objective, {POPULATION} random frequencies in 0…15, medians of "
        f"{result['rounds']} rounds. *Faster* is numpy's time over the row's, with quartiles; all chord sums agree to "
        "1e-11.",
        "",
        "| objective | ns per evaluation | × faster than numpy | quartiles |",
        "|---|---|---|---|",
    ]
    for row in result["rows"]:
        ratio, low, high = row["ratio"]
        lines.append(f"| {row['name']} | {row['ns']:,.0f} | {ratio:.1f} | {low:.1f}–{high:.1f} |")
    each, counted = result["ns_per_operation"], result["operations"]
    chord, node = result["ceiling_ns"]["chord"], result["ceiling_ns"]["node"]
    lines += [
        "",
        "The arithmetic limit, operations counted by running the kernels on numbers that count:",
        "",
        "| per | additions | products | roots | divisions | least ns | per evaluation |",
        "|---|---|---|---|---|---|---|",
        *(
            f"| {name} | " + " | ".join(f"{c[kind]:.0f}" for kind in KINDS) + f" | {least:.2f} | {whole} |"
            for name, c, least, whole in (
                ("sample and chord", counted["chord"], chord, f"{1000 * chord:,.0f} ns for 1000"),
                ("node of the integral", counted["node"], node, f"{192 * node:,.0f} ns for 192"),
            )
        ),
        "",
        f"On this machine a fused product and sum takes {each['multiply-add']:.3f} ns in a vector loop, a root "
        f"{each['root']:.2f}, a division {each['divide']:.2f}. *Least* lets multipliers and divider work at once and "
        "never wait, every product be fused with a sum, and loads, stores, selections and rounding cost nothing.",
    ]
    return lines

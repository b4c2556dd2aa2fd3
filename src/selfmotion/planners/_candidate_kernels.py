"""What one candidate costs, on plain arrays: profile, inverse kinematics, limits and objective in one compiled call.

Two values are at hand: the seed's chord sum over the samples, and the integral by Gauss panels that are halved where
they must be. The integral is computed as far as its rank needs: a chord sum over a few samples is a lower bound on it,
since an arc costs at least its chord, and most candidates are known by it not to matter.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from selfmotion._compiled import fast_kernel, kernel
from selfmotion._elementary_kernels import sincos, sine
from selfmotion._objective_kernels import chord_sum, densities
from selfmotion._types import FloatArray, IntArray
from selfmotion.arms._lift_kernels import extend, least_overrun, overrun
from selfmotion.arms._motion_kernels import (
    LENGTH,
    MARGIN,
    WX,
    U,
    joints_row,
    margins,
    postures,
    rates,
    shortfall,
    turns_row,
)

_TAU = 2.0 * np.pi
_SOME, _ALL = 0, 1  # of the samples
# A value need not be known better once it lies so many error estimates above its threshold: more than one, since at a
# kink two rules may agree by chance.
_SAFETY = 4.0


class Family(NamedTuple):
    """What all candidates of a search share.

    Attributes
    ----------
    objective : int
        See :data:`selfmotion._objective_kernels.KINDS`.
    sign : float
        Of the arm's elbow.
    joints : array, shape (5, n)
        Links, weights, lower limits, upper limits, and the joint angles at r = 0 that fix the turns, NaN where free.
    limited : array of int
        Joints with limits that may be met.
    amplitude : array, shape (n_u,)
        Of sinusoids (22); empty for a family that is linear in its coefficients.
    origin : array, shape (d,)
        What is added to the coefficients that an optimizer gives.
    n_u, functions : int
        Rows of u that coefficients of a linear family choose, and how many each; 0 functions for sinusoids.
    carried, absolute : bool
        Whether what the arm stands on turns, and whether the first joint's cost leaves that out.
    rounding : float
        Violations that are none, in parts of the reach and [rad].
    reach : float
    speed : float
        Bound on the speed of the path, infinite if none is known.
    """

    objective: int
    sign: float
    joints: FloatArray
    limited: IntArray
    amplitude: FloatArray
    origin: FloatArray
    n_u: int
    functions: int
    carried: bool
    absolute: bool
    rounding: float
    reach: float
    speed: float


LINKS, WEIGHTS, LOWER, UPPER, START = range(5)
"""Rows of `Family.joints`."""

R, RUNS, X, Y, DX, DY, BEHIND, TURNING, GIVEN = range(9)
"""Rows of a table of places: r; the steps that lead to it, 0 to the first; the path and its derivative; the direction
of what carries the arm and its derivative, 0 on a fixed base. From GIVEN on: the n − 2 rows of u as far as no
coefficient changes them, as many of du/dr, then what the coefficients of a linear family multiply, and its slopes."""


class Panels(NamedTuple):
    """How the places of a quadrature are ordered: all panels, then all of their halves, then their quarters, …

    Attributes
    ----------
    half : array, shape (p,)
        Half the width of each whole panel.
    depth : int
        How often a panel may be halved, at least once.
    weights : array, shape (16,)
        Of the Gauss rule of a panel.
    """

    half: FloatArray
    depth: int
    weights: FloatArray


class Accuracy(NamedTuple):
    """How accurately candidates are judged.

    Attributes
    ----------
    sampled : bool
        Whether the chord sum over the samples is the value, not the integral.
    tolerance : float
        Relative error at which the halving of panels ends.
    infeasible : float
        Values from here on mean infeasible, by value / infeasible − 1.
    between : float
        Violation of what holds at the samples and breaks at a node between them.
    """

    sampled: bool
    tolerance: float
    infeasible: float
    between: float


class Search(NamedTuple):
    """All that judging a candidate takes.

    Attributes
    ----------
    family : Family
    samples, few, nodes : array
        Tables of places: the samples, some of them, and the nodes of the panels.
    number : array of int
        Which of the samples the few are.
    panels : Panels
    accuracy : Accuracy
    """

    family: Family
    samples: FloatArray
    few: FloatArray
    nodes: FloatArray
    number: IntArray
    panels: Panels
    accuracy: Accuracy


@fast_kernel
def _directions(family: Family, a: FloatArray, places: FloatArray, low: int, k: int, sheet: FloatArray) -> None:
    """Fill u at the k places from `low` on."""
    rows, r = family.joints.shape[1] - 2, places[R][low:]
    for j in range(rows):
        row, given = sheet[U + j], places[GIVEN + j][low:]
        for i in range(k):
            row[i] = given[i]
    for j in range(len(family.amplitude)):
        row, amplitude, rate = sheet[U + j], family.amplitude[j], _TAU * (a[j] + family.origin[j])
        for i in range(k):
            row[i] += amplitude * sine(rate * r[i])
    if family.functions:
        for j in range(family.n_u):
            row = sheet[U + j]
            for m in range(family.functions):
                number = j * family.functions + m
                coefficient, function = a[number] + family.origin[number], places[GIVEN + 2 * rows + m][low:]
                for i in range(k):
                    row[i] += coefficient * function[i]


@fast_kernel
def _turnings(family: Family, a: FloatArray, places: FloatArray, low: int, k: int, sheet: FloatArray) -> None:
    """Fill u and du/dr at the k places from `low` on."""
    rows, r, turns = family.joints.shape[1] - 2, places[R][low:], turns_row(family.joints.shape[1])
    for j in range(rows):
        row, given = sheet[U + j], places[GIVEN + j][low:]
        turn, known = sheet[turns + j], places[GIVEN + rows + j][low:]
        for i in range(k):
            row[i], turn[i] = given[i], known[i]
    for j in range(len(family.amplitude)):
        row, turn = sheet[U + j], sheet[turns + j]
        amplitude, rate = family.amplitude[j], _TAU * (a[j] + family.origin[j])
        for i in range(k):
            s, c = sincos(rate * r[i])
            row[i] += amplitude * s
            turn[i] += amplitude * rate * c
    if family.functions:
        for j in range(family.n_u):
            row, turn = sheet[U + j], sheet[turns + j]
            for m in range(family.functions):
                number, at = j * family.functions + m, GIVEN + 2 * rows + m
                coefficient = a[number] + family.origin[number]
                function, slope = places[at][low:], places[at + family.functions][low:]
                for i in range(k):
                    row[i] += coefficient * function[i]
                    turn[i] += coefficient * slope[i]


@fast_kernel
def sampled(family: Family, a: FloatArray, places: FloatArray, which: int, sheet: FloatArray) -> tuple[float, float]:
    """Return the chord sum over `places`, joints modulo 2π, and how far the candidate leaves the angle domain there.

    If these are not all samples but so few that a sheet holds them, both are lower bounds on what they are at all.
    """
    count, n, limited = places.shape[1], family.joints.shape[1], family.limited
    joints, links = joints_row(n), family.joints[LINKS]
    extents = np.empty((len(limited), 4))
    cost = short = 0.0
    for low in range(0, count, LENGTH):
        k, first, behind = min(count - low, LENGTH), sheet[joints][1:], places[BEHIND][low:]
        _directions(family, a, places, low, k, sheet)
        postures(links, family.sign, places[X][low:], places[Y][low:], k, sheet)
        short = max(short, shortfall(links, k, sheet))
        if family.carried:
            for i in range(k):
                first[i] -= behind[i]
        for m in range(len(limited)):
            angles = sheet[joints + limited[m]][1:]
            if which == _ALL:
                extend(angles, k, extents[m], low == 0)
            else:
                extents[m, 0] = least_overrun(
                    angles, k, family.joints[LOWER, limited[m]], family.joints[UPPER, limited[m]]
                )
        if family.absolute:
            for i in range(k):
                first[i] += behind[i]
        if low == 0:
            for j in range(joints, joints + n):
                sheet[j, 0] = sheet[j, 1]
        cost += chord_sum(family.objective, places[RUNS][low:], family.joints[WEIGHTS], k, sheet, joints, WX)
        for j in range(joints, joints + n):
            sheet[j, 0] = sheet[j, k]
    violation = _unless_rounding(family, short / family.reach)
    for m in range(len(limited)):
        j, excess = limited[m], extents[m, 0]
        if which == _ALL:
            excess = overrun(extents[m], family.joints[LOWER, j], family.joints[UPPER, j], family.joints[START, j])
        violation += _unless_rounding(family, excess)
    return cost, violation


@fast_kernel
def _unless_rounding(family: Family, violation: float) -> float:
    """Return a violation, zero if rounding explains it."""
    return violation if violation > family.rounding else 0.0


@fast_kernel
def _out_of_reach(family: Family, a: FloatArray, places: FloatArray, low: int, end: int, sheet: FloatArray) -> float:
    """Return how far out of reach the candidate is at the places low…end − 1, in parts of the reach."""
    links, short = family.joints[LINKS], 0.0
    for first in range(low, end, LENGTH):
        k = min(end - first, LENGTH)
        _directions(family, a, places, first, k, sheet)
        margins(links, places[X][first:], places[Y][first:], k, sheet)
        short = max(short, shortfall(links, k, sheet))
    return _unless_rounding(family, short / family.reach)


@fast_kernel
def _violation(family: Family, a: FloatArray, samples: FloatArray, sheet: FloatArray) -> float:
    """Return how far the candidate leaves the angle domain at all samples, as `sampled` does."""
    if len(family.limited):
        return sampled(family, a, samples, _ALL, sheet)[1]
    return _out_of_reach(family, a, samples, 0, samples.shape[1], sheet)


@fast_kernel
def _is_inside(search: Search, a: FloatArray, near: FloatArray, sheet: FloatArray) -> bool:
    """Return whether a candidate that is inside at the few samples, with margins `near`, is so at all of them.

    Between two of them a target moves by no more than its speed allows: most stretches need not be looked at.
    """
    family, samples, number = search.family, search.samples, search.number
    if len(family.limited) or family.functions:
        return _violation(family, a, samples, sheet) == 0.0
    links, speed = family.joints[LINKS], family.speed
    for j in range(len(family.amplitude)):
        speed += links[j + 2] * abs(family.amplitude[j] * _TAU * (a[j] + family.origin[j]))
    bar = 2.0 * (links[0] + links[1]) * speed
    for i in range(len(number) - 1):
        is_clear = near[i] + near[i + 1] > bar * search.few[RUNS, i + 1]
        if not is_clear and _out_of_reach(family, a, samples, number[i] + 1, number[i + 1], sheet) > 0.0:
            return False
    return True


@fast_kernel
def _panel_sums(
    family: Family, a: FloatArray, places: FloatArray, panels: Panels, start: int, sums: FloatArray, sheet: FloatArray
) -> None:
    """Fill `sums` with the weighted sums of as many panels, whose nodes begin at place `start`."""
    joints, weights = joints_row(family.joints.shape[1]), panels.weights
    size = len(weights)
    at_once = LENGTH // size
    for first in range(0, len(sums), at_once):
        count, low = min(len(sums) - first, at_once), start + size * first
        k = size * count
        _turnings(family, a, places, low, k, sheet)
        rates(
            family.joints[LINKS], family.sign, places[X][low:], places[Y][low:], places[DX][low:], places[DY][low:],
            k, sheet,
        )  # fmt: skip
        if family.carried and not family.absolute:
            rate, turning = sheet[joints][1:], places[TURNING][low:]
            for i in range(k):
                rate[i] -= turning[i]
        densities(family.objective, family.joints[WEIGHTS], k, sheet, joints, MARGIN)
        for p in range(count):
            total, density = 0.0, sheet[MARGIN][p * size :]
            for i in range(size):
                total += weights[i] * density[i]
            sums[first + p] = total


@fast_kernel
def integral(
    family: Family,
    a: FloatArray,
    places: FloatArray,
    panels: Panels,
    tolerance: float,
    threshold: float,
    sheet: FloatArray,
) -> tuple[float, float]:
    """Return the cost as an integral and the estimate of its error, NaN where a node is out of reach.

    A panel's error is what its halves change. It is that of the panel, far above that of the halves, which are what is
    kept. The work ends where the error is `tolerance` of the value, or the value surely above `threshold`.
    """
    count, half = len(panels.half), panels.half
    sums = np.empty(3 * count)
    _panel_sums(family, a, places, panels, 0, sums, sheet)
    value = error = 0.0
    for p in range(count):
        halves = 0.5 * half[p] * (sums[count + 2 * p] + sums[count + 2 * p + 1])
        value += halves
        error += abs(half[p] * sums[p] - halves)
    if not np.isfinite(value):
        return np.nan, np.nan
    if error <= tolerance * value or value - _SAFETY * error > threshold or panels.depth == 1:
        return value, error
    return _halved(family, a, places, panels, tolerance, threshold, value, error, sums, sheet)


@fast_kernel
def _halved(
    family: Family,
    a: FloatArray,
    places: FloatArray,
    panels: Panels,
    tolerance: float,
    threshold: float,
    value: float,
    error: float,
    sums: FloatArray,
    sheet: FloatArray,
) -> tuple[float, float]:
    """Go on with :func:`integral` from the sums of all panels and their halves, level by level, where the error is."""
    size, count, half = len(panels.weights), len(panels.half), panels.half
    most = count << panels.depth
    # Of the level reached: the panels' costs, and what halving their parents changed, which each half has half of.
    costs, lost = np.empty(most), np.empty(most)
    finer, finer_lost = np.empty(most), np.empty(most)
    for p in range(2 * count):
        costs[p] = 0.5 * half[p >> 1] * sums[count + p]
        lost[p] = 0.5 * abs(half[p >> 1] * (sums[p >> 1] - 0.5 * (sums[count + (p & -2)] + sums[count + (p | 1)])))
    sums = np.empty(most)
    for level in range(1, panels.depth):
        first = size * count * ((2 << level) - 1)  # node of the next level
        for p in range(2 * count << level):
            finer_lost[p] = 0.0
        p, end = 0, count << level
        while p < end:
            width = half[p >> level] / (1 << level)
            if lost[p] <= tolerance * value * width:
                p += 1
                continue
            run = 1
            while p + run < end and lost[p + run] > tolerance * value * width:
                run += 1
            _panel_sums(family, a, places, panels, first + 2 * size * p, sums[: 2 * run], sheet)
            for i in range(run):
                width = 0.5 * half[(p + i) >> level] / (1 << level)
                left, right = width * sums[2 * i], width * sums[2 * i + 1]
                change = abs(costs[p + i] - (left + right))
                value += left + right - costs[p + i]
                error += change - lost[p + i]
                child = 2 * (p + i)
                finer[child], finer[child + 1] = left, right
                finer_lost[child] = finer_lost[child + 1] = 0.5 * change
            p += run
        if not np.isfinite(value):
            return np.nan, np.nan
        if error <= tolerance * value or value - _SAFETY * error > threshold:
            break
        costs, finer = finer, costs
        lost, finer_lost = finer_lost, lost
    return value, max(error, 0.0)


@kernel
def judge(search: Search, a: FloatArray, threshold: float, sheet: FloatArray) -> tuple[float, bool]:
    """Return a candidate's value as optimizers rank it, and whether it is more than a lower bound on it.

    Only a value that may be below `threshold` is computed to the end.
    """
    family, accuracy, infeasible = search.family, search.accuracy, search.accuracy.infeasible
    if accuracy.sampled:
        cost, violation = sampled(family, a, search.samples, _ALL, sheet)
        return (infeasible * (1.0 + violation) if violation > 0.0 else cost), True
    chords, violation = sampled(family, a, search.few, _SOME, sheet)
    if violation > 0.0:
        if infeasible * (1.0 + violation) > threshold:
            return infeasible * (1.0 + violation), False
        return infeasible * (1.0 + _violation(family, a, search.samples, sheet)), True
    if chords > threshold:
        return chords, False
    near = np.empty(len(search.number))
    for i in range(len(near)):
        near[i] = sheet[MARGIN, i]
    cost, error = integral(family, a, search.nodes, search.panels, accuracy.tolerance, threshold, sheet)
    if cost - _SAFETY * error > threshold:
        return max(cost - _SAFETY * error, chords), False
    if not _is_inside(search, a, near, sheet):
        return infeasible * (1.0 + _violation(family, a, search.samples, sheet)), True
    if np.isnan(cost):
        return infeasible * (1.0 + accuracy.between), True
    return cost, True

"""Boxes of joint angles that hold the self-motion of three links for all task points in a disc, on plain arrays.

Charts and pieces are those of :mod:`selfmotion.arms._cover_kernels`. A piece is enclosed in three ways, the narrowest
of which counts: link by link; by the mean value theorem from the posture in the middle, with

    dφ_m = t_m/t_i dφ_i  along the self-motion,   |∂φ_m/∂x| = 1/(l_m l_i |t_i|)  while φ_i stands still;

and the joint between the two links that are not the chart's from the distance that they bridge alone.
"""

from __future__ import annotations

import numpy as np

from selfmotion._compiled import kernel
from selfmotion._types import BoolArray, FloatArray, IntArray
from selfmotion.arms._cover_kernels import (
    DROP,
    PAD,
    REGULAR,
    ROUGH,
    TAU,
    cosine_range,
    enclose,
    is_led,
    others,
    solve,
    speeds,
)

# No joint moves more than twice as fast as the direction of the right chart: a piece that is thinner than this part of
# its box's radius, or where nothing is known of the radius wanted, has a large box because of the disc.
_THIN, _THINNEST = 0.5, 0.3
_ONCE = 0.6  # but a piece with too large a box has been halved once
_DEEPEST = 512  # pieces that wait to be looked at
_OPTIONS = 32  # turns of a joint that are told apart


@kernel
def bridged(
    links: FloatArray, x: float, y: float, rho: float, chart: int, low: float, high: float
) -> tuple[float, float]:
    """Return the range of the distance that the two links other than the chart's bridge."""
    own = links[chart]
    r, psi = np.hypot(x, y), np.arctan2(y, x)
    pad = PAD * (r + links.sum())
    least, most = cosine_range(low - psi - PAD, high - psi + PAD)
    shortest = np.sqrt((r - own) ** 2 + 2 * r * own * max(1.0 - most - PAD, 0.0)) - rho - pad
    longest = np.sqrt((r - own) ** 2 + 2 * r * own * (1.0 - least + PAD)) + rho + pad
    return shortest, longest


@kernel
def angle_between(one: float, two: float, d: float) -> float:
    """Return the angle in [0, π] between the directions of two links that bridge the distance d together."""
    top = max((one + two - d) * (one + two + d), 0.0)
    bottom = max((d - abs(one - two)) * (d + abs(one - two)), 0.0)
    return 2.0 * np.arctan2(np.sqrt(top), np.sqrt(bottom))


@kernel
def joint_box(
    links: FloatArray, x: float, y: float, rho: float, direction: float, chart: int, sign: float, low: float,
    high: float, middle: FloatArray, radius: FloatArray, t: FloatArray, dt: FloatArray, box: FloatArray,
) -> int:  # fmt: skip
    """Enclose the joint angles of a piece in `box` (n, 2); return DROP if no posture is in it or another chart serves.

    REGULAR if all of it reaches and moves with its chart's direction, else ROUGH.
    """
    n = len(box)
    kind = enclose(links, x, y, rho, chart, sign, low, high, middle, radius)
    if kind == DROP:
        return DROP
    speeds(links, middle, radius, t, dt)
    if is_led(t, chart):
        return DROP
    for m in range(n):
        # Joint m is φ_m − φ_{m−1}, the fourth is direction − φ_3.
        angle, room = (middle[m], radius[m]) if m < 3 else (direction, 0.0)
        if m > 0:
            angle, room = angle - middle[m - 1], room + radius[m - 1]
        room += PAD * (1.0 + abs(angle) + abs(middle[m - 1]))
        box[m, 0], box[m, 1] = angle - room, angle + room
    if kind == REGULAR and abs(t[chart, 0]) > 1.01 * t[chart, 1]:
        narrow(links, x, y, rho, direction, chart, sign, low, high, t, box, middle, radius)
    else:
        kind = ROUGH
    j, k = others(chart)
    if k == j + 1:  # a joint lies between the two
        shortest, longest = bridged(links, x, y, rho, chart, low, high)
        least = angle_between(links[j], links[k], longest) - 4 * PAD
        most = angle_between(links[j], links[k], shortest) + 4 * PAD
        if sign < 0:
            least, most = -most, -least
        box[k, 0], box[k, 1] = max(box[k, 0], least), min(box[k, 1], most)
    return kind


@kernel
def narrow(
    links: FloatArray, x: float, y: float, rho: float, direction: float, chart: int, sign: float, low: float,
    high: float, t: FloatArray, box: FloatArray, directions: FloatArray, radius: FloatArray,
) -> None:  # fmt: skip
    """Narrow the box and the directions of a piece by the mean value theorem, from the posture in its middle."""
    half, middle = 0.5 * (high - low) * (1.0 + PAD), 0.5 * (low + high)
    size = np.hypot(x, y) + links.sum()
    slowest = abs(t[chart, 0]) - t[chart, 1]
    lever = 1.0 / (links[chart] * slowest)
    exact = np.empty(3)
    solve(links, x, y, chart, sign, middle, exact)
    for m in range(len(box)):
        angle, rate, room, shift = direction, 0.0, 0.0, 0.0
        if m < 3:
            angle, rate, room, shift = exact[m], t[m, 0], t[m, 1], 1.0 / links[m] if m != chart else 0.0
        if m > 0:
            angle, rate, room = angle - exact[m - 1], rate - t[m - 1, 0], room + t[m - 1, 1]
            shift += 1.0 / links[m - 1] if m - 1 != chart else 0.0
        spread = (abs(rate) + room) / slowest * half + shift * lever * rho * (1.0 + PAD)
        spread += PAD * (2.0 + abs(angle) + abs(direction) + size * lever * (shift + 1.0 / links.min()))
        box[m, 0], box[m, 1] = max(box[m, 0], angle - spread), min(box[m, 1], angle + spread)
    for m in range(3):
        if m != chart:
            spread = (abs(t[m, 0]) + t[m, 1]) / slowest * half + lever * rho * (1.0 + PAD) / links[m]
            spread += PAD * (2.0 + abs(exact[m]) + size * lever * (1.0 / links[m] + 1.0 / links.min()))
            least = max(directions[m] - radius[m], exact[m] - spread)
            most = min(directions[m] + radius[m], exact[m] + spread)
            if least < most:
                directions[m], radius[m] = 0.5 * (least + most), 0.5 * (most - least) + PAD


@kernel
def place_joints(
    links: FloatArray, x: float, y: float, rho: float, middle: FloatArray, radius: FloatArray, places: FloatArray
) -> None:  # fmt: skip
    """Enclose where the ends of the three links are whose directions are within `radius` of `middle`, tool in the disc.

    Row m of `places` (4, 5) is of the base or of the end of link m: it is within `rest` of a line, (x, y, Δx, Δy, rest)
    with the line from (x, y) − Δ to (x, y) + Δ. The second link ends where it is led to from the base or from the tool,
    whichever is known better.
    """
    pad = 10.0 * PAD * (np.hypot(x, y) + links.sum())
    places[0] = 0.0
    places[3, 0], places[3, 1], places[3, 2], places[3, 3], places[3, 4] = x, y, 0.0, 0.0, rho + pad
    turn_about(0.0, 0.0, links[0], middle[0], radius[0], pad, places[1])
    if rho + links[2] * radius[2] < links[0] * radius[0] + links[1] * radius[1]:
        turn_about(x, y, -links[2], middle[2], radius[2], rho + pad, places[2])
    else:
        moved = min(radius[0], 2.0) * links[0]
        ahead, beside = links[0] * np.cos(middle[0]), links[0] * np.sin(middle[0])
        turn_about(ahead, beside, links[1], middle[1], radius[1], moved + pad, places[2])


@kernel
def turn_about(
    x: float, y: float, length: float, angle: float, radius: float, rest: float, place: FloatArray
) -> None:  # fmt: skip
    """Fill in where a link ends that turns by ± `radius` about (x, y), known within `rest`: r²/2 from a tangent."""
    cosine, sine = np.cos(angle), np.sin(angle)
    place[0], place[1] = x + length * cosine, y + length * sine
    if radius < 1.0:
        place[2], place[3] = -length * radius * sine, length * radius * cosine
        place[4] = rest + 0.5 * abs(length) * radius * radius
    else:
        place[2], place[3], place[4] = 0.0, 0.0, rest + abs(length) * min(radius, 2.0)


@kernel
def options(
    low: float, high: float, windows: FloatArray, inside_low: float, inside_high: float, period: float,
    found: FloatArray,
) -> int:  # fmt: skip
    """List where [low, high], moved by whole periods, meets a window and [inside_low, inside_high]; return how many."""
    count = 0
    for w in range(len(windows)):
        floor, ceiling = max(windows[w, 0], inside_low), min(windows[w, 1], inside_high)
        if high - low >= period and floor <= ceiling and count < len(found):  # anything is possible
            found[count, 0], found[count, 1], found[count, 2] = floor, ceiling, 0.0
            count += 1
            continue
        turn, last = np.ceil((floor - high) / period - PAD), np.floor((ceiling - low) / period + PAD)
        while turn <= last:
            one, two = low + period * turn, high + period * turn
            start, stop = max(one, floor), max(min(two, ceiling), one, floor)
            if count < len(found):
                found[count, 0], found[count, 1] = start, stop
                found[count, 2] = 1.0 if one >= windows[w, 0] and two <= windows[w, 1] else 0.0
                count += 1
            else:  # the last one takes in all that are too many
                found[count - 1, 0], found[count - 1, 1] = (
                    min(found[count - 1, 0], start),
                    max(found[count - 1, 1], stop),
                )
                found[count - 1, 2] = 0.0
            turn += 1.0
    return count


@kernel
def all_options(
    box: FloatArray, wraps: BoolArray, windows: FloatArray, first: IntArray, period: FloatArray,
    inside_low: FloatArray, inside_high: FloatArray, ways: FloatArray, many: IntArray,
) -> bool:  # fmt: skip
    """List the options of each joint; return whether every joint has one."""
    for j in range(len(box)):
        if wraps[j]:
            center, half = 0.5 * (box[j, 0] + box[j, 1]), min(0.5 * (box[j, 1] - box[j, 0]), np.pi)
            center -= TAU * np.rint(center / TAU)
            ways[j, 0, 0], ways[j, 0, 1], ways[j, 0, 2] = center - half, center + half, 1.0
            many[j] = 1
        else:
            mine = windows[first[j] : first[j + 1]]
            many[j] = options(box[j, 0], box[j, 1], mine, inside_low[j], inside_high[j], period[j], ways[j])
        if many[j] == 0:
            return False
    return True


@kernel
def is_last(pick: IntArray, many: IntArray) -> bool:
    """Go on to the next combination of options; return whether there is none."""
    for j in range(len(pick)):
        pick[j] += 1
        if pick[j] < many[j]:
            return False
        pick[j] = 0
    return True


@kernel
def slab_boxes(
    links: FloatArray, x: float, y: float, rho: float, direction: float, wraps: BoolArray, windows: FloatArray,
    first: IntArray, pieces: FloatArray, inside_low: FloatArray, inside_high: FloatArray, size: FloatArray,
    narrowest: float,
    low: FloatArray, high: FloatArray, clean: BoolArray, found: FloatArray, origin: IntArray, places: FloatArray,
) -> int:  # fmt: skip
    """Cover pieces (p, 4) of the self-motion of a disc by boxes; return how many there are, as :func:`cover` does.

    Limited joints stay in [inside_low, inside_high] (p, n) as well. Of each box `places` (m, 4, 5) are where the links'
    ends are, see :func:`place_joints`.
    """
    n, capacity, count = low.shape[1], len(low), 0
    stack, t, dt = np.empty((_DEEPEST, 2)), np.empty((3, 2)), np.empty((3, 2))
    middle, radius, box = np.empty(3), np.empty(3), np.empty((n, 2))
    many, pick, ways = np.ones(n, np.int64), np.zeros(n, np.int64), np.empty((n, _OPTIONS, 3))
    period = np.full(n, TAU)
    for p in range(len(pieces)):
        chart, sign = int(pieces[p, 0]), pieces[p, 1]
        stack[0, 0], stack[0, 1] = pieces[p, 2], pieces[p, 3]
        once = _ONCE * (pieces[p, 3] - pieces[p, 2])
        depth = 1
        while depth > 0:
            depth -= 1
            start, stop = stack[depth, 0], stack[depth, 1]
            kind = joint_box(links, x, y, rho, direction, chart, sign, start, stop, middle, radius, t, dt, box)
            if kind == DROP or not all_options(
                box, wraps, windows, first, period, inside_low[p], inside_high[p], ways, many
            ):
                continue
            longest = 0.5 * (box[:, 1] - box[:, 0]).max()
            thin = min(_THIN * longest, once) if kind == REGULAR else min(_THINNEST * size[p], once)
            if longest > size[p] and stop - start > max(thin, narrowest) and depth + 2 <= _DEEPEST:
                cut = 0.5 * (start + stop)
                stack[depth, 0], stack[depth, 1] = cut, stop
                stack[depth + 1, 0], stack[depth + 1, 1] = start, cut
                depth += 2
                continue
            pick[:] = 0
            while True:
                if count < capacity:
                    clean[count], origin[count] = kind == REGULAR, p
                    for j in range(n):
                        low[count, j], high[count, j] = ways[j, pick[j], 0], ways[j, pick[j], 1]
                        clean[count] = clean[count] and ways[j, pick[j], 2] > 0.0
                    found[count, 0], found[count, 1], found[count, 2], found[count, 3] = chart, sign, start, stop
                    place_joints(links, x, y, rho, middle, radius, places[count])
                count += 1
                if is_last(pick, many):
                    break
    return count

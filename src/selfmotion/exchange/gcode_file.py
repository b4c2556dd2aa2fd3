"""G-code: what a program cuts, as a path; rapid moves lift the tool from one cut to the next."""

from __future__ import annotations

import os
from itertools import pairwise
from typing import Literal, Unpack

import numpy as np
from numpy.typing import NDArray

from selfmotion._checks import choice
from selfmotion._types import FloatArray
from selfmotion.errors import InvalidInputError
from selfmotion.exchange.drawing import Drawing, drawing
from selfmotion.exchange.gcode_machine import RAPID, Program, Turn
from selfmotion.exchange.gcode_words import blocks
from selfmotion.exchange.pieces import Piece, elliptic, line
from selfmotion.exchange.reading import Options, Reading, about, read_checked, settled_unit, spelled_out
from selfmotion.paths import Arc, Placed
from selfmotion.paths.base import PLANE, SPACE
from selfmotion.units import UNITS


@spelled_out
def read_gcode(
    file: str | os.PathLike[str],
    unit: Literal["mm", "inch"] | None = None,
    *,
    dimension: Literal[2, 3] | None = None,
    **options: Unpack[Reading],
) -> Drawing:
    """Read what a G-code program cuts.

    Parameters
    ----------
    file : path-like
    unit : {"mm", "inch"}, optional
        Of the program's numbers; needed if it has neither G20 nor G21.
    dimension : {2, 3}, optional
        2 drops Z. By default 3 if the program moves in Z at all.
    **options
        `arm_unit`, `scale`, `tolerance`, `gaps`, `lift` and `subpath`: see :class:`~.reading.Options`.
        In space the path follows the program's own rapid moves from cut to cut; `gaps` and `lift` are for the plane.

    Returns
    -------
    Drawing

    Raises
    ------
    InvalidInputError
        Naming file and line.

    Notes
    -----
    Read are G0–G3, arcs by I, J, K or R, G17–G19, G20, G21, G90, G91, G90.1 and G91.1. The path begins with the first
    cutting move and ends with the last. Arcs in a plane are exact, helices are flattened. Words without meaning for the
    path are reported; words that would change it, such as cutter compensation and drilling cycles, are errors.
    """
    chosen = Options(**options)
    if unit is not None:
        choice("unit", unit, ("mm", "inch"))
    if dimension is not None and dimension not in (PLANE, SPACE):
        raise InvalidInputError("dimension", "is neither 2 nor 3", "give one of them, or leave it out", dimension)
    with about(file):
        return _read(_text(read_checked(file)), os.fspath(file), unit, chosen, dimension)


def _text(data: bytes) -> str:
    if b"\0" in data:
        raise InvalidInputError("", "is not a text file", "is it the right file?")
    # Words are ASCII; comments may be in whatever the machine's maker wrote.
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError:
        return data.decode("latin-1")


def _read(text: str, source: str, unit: str | None, options: Options, dimension: int | None) -> Drawing:
    program = Program(unit, options)
    for block in blocks(text):
        if not program.take(block):
            break
    if not program.kinds:
        raise InvalidInputError("", "moves nowhere", "is it a G-code program?")
    stated = program.unit
    named, words = settled_unit(unit, stated, "G20 or G21" if stated is None else "G20" if stated == "inch" else "G21")
    factor = options.factor(UNITS[named])
    points = np.frombuffer(program.points).reshape(-1, SPACE) * factor
    kinds = np.frombuffer(program.kinds, dtype=np.uint8)
    turns = {k: _scaled(turn, factor) for k, turn in program.turns.items()}
    heights = points[1:][np.isfinite(points[1:, 2]), 2]
    in_space = len(heights) > 0 and np.ptp(heights) > 0
    if dimension is None:
        dimension = SPACE if in_space else PLANE
    if dimension == SPACE:
        why = "is for the plane; in space the program's own rapid moves lead from cut to cut"
        options.no_bridges(why, "leave it out, or add dimension: 2")
    strokes, travels, error = _strokes(points, kinds, turns, dimension, options.within)
    if not strokes:
        raise InvalidInputError("", "makes no cutting move (G1, G2 or G3)", "is it the right file?")
    more = {"feeds": program.listed("F"), "spindle": program.listed("S")}
    notes = list(program.notes)
    if dimension == PLANE and in_space:
        depths = points[1:][kinds != RAPID, 2]
        notes.append(f"Z was dropped; the cuts end at heights from {depths.min():.6g} to {depths.max():.6g}")
    if axes := program.assumed(dimension):
        notes.append(f"nothing says where the tool is when it first cuts: it was taken to be at 0 in {axes}")
    return drawing(
        source, "G-code", words, UNITS[named], strokes, options, travels if dimension == SPACE else None, close=False,
        ignored=program.ledger.entries(), notes=notes, chord_error=error,
        more={name: values for name, values in more.items() if values},
    )  # fmt: skip


def _scaled(turn: Turn, factor: float) -> Turn:
    center = (turn.center[0] * factor, turn.center[1] * factor)
    return Turn(turn.axes, center, turn.radius * factor, turn.start, turn.sweep)


def _strokes(
    points: FloatArray, kinds: NDArray[np.uint8], turns: dict[int, Turn], dimension: int, within: float
) -> tuple[list[list[Piece]], list[tuple[Piece, ...]], float]:
    """Return the cuts, what goes on between them, and how far flattened arcs stray."""
    edges = np.flatnonzero(np.diff((kinds == RAPID).astype(int))) + 1
    strokes: list[list[Piece]] = []
    travels: list[tuple[Piece, ...]] = []
    waiting: list[Piece] = []
    worst = 0.0
    for begin, stop in pairwise([0, *edges.tolist(), len(kinds)]):
        if kinds[begin] == RAPID:
            # Where the tool was at home in between, only where it went on is known.
            known = points[begin : stop + 1, :dimension]
            way = line(known[np.isfinite(known).all(axis=1)], "gap") if strokes else None
            waiting += [] if way is None else [way]
            continue
        pieces: list[Piece] = []
        at = begin
        for k in [k for k in range(begin, stop) if k in turns] + [stop]:
            if k > at and (cut := line(points[at : k + 1, :dimension])) is not None:
                pieces.append(cut)
            if k < stop:
                arc, error = _arc(points[k], points[k + 1], turns[k], dimension, within)
                pieces += [] if arc is None else [arc]
                worst = max(worst, error)
            at = k + 1
        if not pieces:
            continue
        if strokes:
            travels.append(tuple(waiting))
            waiting = []
        strokes.append(pieces)
    return strokes, travels, worst


def _arc(start: FloatArray, end: FloatArray, turn: Turn, dimension: int, within: float) -> tuple[Piece | None, float]:
    """Return an arc as a piece, and how far it strays if it had to be flattened."""
    a, b, across = turn.axes
    flat = across == 2 and (dimension == PLANE or start[2] == end[2])
    if flat and dimension == PLANE:
        radius = turn.radius * np.eye(2)
        return elliptic(np.array(turn.center), radius, turn.start, turn.sweep), 0.0
    arc = Arc(turn.center, turn.radius, turn.start, turn.sweep)
    if dimension == SPACE and start[across] == end[across]:
        # The frame's x- and y-axes are the plane's two axes.
        matrix = np.zeros((3, 3))
        matrix[a, 0] = matrix[b, 1] = matrix[across, 2] = 1.0
        shift = np.zeros(3)
        shift[across] = start[across]
        placed = Placed(arc, {"translation": shift.tolist(), "matrix": matrix.tolist()})
        return Piece("arc", placed([0.0, 1.0]), placed), 0.0
    bending = turn.radius * turn.sweep**2 / 8
    count = int(np.clip(np.ceil(np.sqrt(bending / within)), 1, 1_000_000))
    r = np.linspace(0.0, 1.0, count + 1)
    points = np.empty((count + 1, SPACE))
    points[:, [a, b]] = arc(r)
    points[:, across] = (1 - r) * start[across] + r * end[across]
    return line(points[:, :dimension], "flattened"), bending / count**2

"""A drawing as it was understood: its strokes, its unit, its gaps, what was ignored, and the path along it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import pairwise
from typing import Any

import numpy as np

from selfmotion._types import FloatArray
from selfmotion.errors import InvalidInputError
from selfmotion.exchange.ledger import Ignored
from selfmotion.exchange.pieces import (
    MOST_CURVES,
    Piece,
    bounds_of,
    fitted,
    line,
    path_of,
    without_curves,
)
from selfmotion.exchange.reading import Options
from selfmotion.paths import Path
from selfmotion.paths.base import distance
from selfmotion.units import UNITS, contradiction, point_text, too_large, too_small, unlikely


@dataclass(frozen=True)
class Gap:
    """Where the drawing has nothing between two subpaths.

    Attributes
    ----------
    after : int
        The subpath that it follows.
    length : float
    bridged : {"line", "lift", "rapid"} or None
        How the path gets across; None if nobody has said, and then there is no path.
    """

    after: int
    length: float
    bridged: str | None


@dataclass(frozen=True)
class Subpath:
    """A connected run of lines and curves.

    Attributes
    ----------
    pieces : tuple of Piece
    """

    pieces: tuple[Piece, ...]

    @cached_property
    def path(self) -> Path:
        """It alone, as a path."""
        return path_of(self.pieces)

    @property
    def segments(self) -> dict[str, int]:
        """How many there are of each kind."""
        return _counted(self.pieces)

    @cached_property
    def length(self) -> float:
        """Its arc length."""
        return sum(piece.length for piece in self.pieces)

    @property
    def start(self) -> FloatArray:
        """Its first point."""
        return self.pieces[0].start

    @property
    def end(self) -> FloatArray:
        """Its last point."""
        return self.pieces[-1].end

    @property
    def closed(self) -> bool:
        """Whether it ends where it starts."""
        return bool(distance(self.end - self.start) <= 1e-9 * self.length)

    @cached_property
    def bounds(self) -> FloatArray:
        """Least and largest coordinates, shape (2, d)."""
        return bounds_of(self.pieces)


@dataclass(frozen=True)
class Drawing:
    """What a file was understood as.

    Lengths are in `arm_unit`.

    Attributes
    ----------
    file : str
    form : str
        ``"SVG"``, ``"DXF"``, ``"G-code"``, ``"CSV"``, ``"JSON"`` or ``"NPY"``.
    unit : str
        Of the file's numbers, and who says so.
    arm_unit : str
        That of the path.
    subpaths : tuple of Subpath
        In the order of the file.
    gaps : tuple of Gap
        Between them, one less.
    travels : tuple of Piece or None
        What the path does in the gaps; None where nobody has said.
    tolerance, chord_error : float
        What was asked for, and how far the path is from the drawing at most where it was flattened.
    joints : tuple of float
        How far joints were open that were closed.
    ignored : tuple of Ignored
    notes : tuple of str
        What else was assumed.
    warnings : tuple of str
        What in the file contradicts itself, or is unlikely.
    more : mapping
        What only this format says.
    poses : Path or None
        The path, if the file gave orientations too.
    """

    file: str
    form: str
    unit: str
    arm_unit: str
    subpaths: tuple[Subpath, ...]
    gaps: tuple[Gap, ...]
    travels: tuple[tuple[Piece, ...] | None, ...]
    tolerance: float
    chord_error: float
    joints: tuple[float, ...] = ()
    ignored: tuple[Ignored, ...] = ()
    notes: tuple[str, ...] = ()
    warnings: tuple[str, ...] = ()
    more: Mapping[str, Any] = field(default_factory=dict)
    poses: Path | None = None

    @cached_property
    def path(self) -> Path:
        """The path along all subpaths.

        Raises
        ------
        InvalidInputError
            If there are gaps of which nobody has said how to get across.
        """
        if self.poses is not None:
            return self.poses
        pieces: list[Piece] = list(self.subpaths[0].pieces)
        for gap, travel, after in zip(self.gaps, self.travels, self.subpaths[1:], strict=True):
            if travel is None:
                open_gaps = sum(other is None for other in self.travels)
                where = f"subpath {gap.after} ends at {point_text(self.subpaths[gap.after].end)}, the next starts at"
                raise InvalidInputError(
                    "",
                    f"has {open_gaps} gap{'s' * (open_gaps > 1)} between its {len(self.subpaths)} subpaths: {where} "
                    f"{point_text(after.start)}, {gap.length:.6g} {self.arm_unit} away",
                    "take one by subpath, join them by gaps: line, in space by lift, or give a larger tolerance",
                    source=self.file,
                )
            pieces += [*travel, *after.pieces]
        return path_of(pieces)

    @property
    def segments(self) -> dict[str, int]:
        """How many lines and curves of each kind were drawn."""
        return _counted(piece for part in self.subpaths for piece in part.pieces)

    @cached_property
    def length(self) -> float:
        """The arc length of what was drawn, gaps not counted."""
        return sum(part.length for part in self.subpaths)

    @cached_property
    def bounds(self) -> FloatArray:
        """Least and largest coordinates of what was drawn, shape (2, d)."""
        return bounds_of([piece for part in self.subpaths for piece in part.pieces])

    @property
    def extent(self) -> float:
        """The largest side of the box around what was drawn."""
        low, high = self.bounds
        return float((high - low).max())

    def for_arm(self, reach: float, unit: str | None = None) -> Drawing:
        """Return the drawing with a warning if its size, or its unit, does not fit an arm.

        Parameters
        ----------
        reach : float
            Of the arm, in its unit.
        unit : str, optional
            That unit, if it is known: m of arms in space, of planar ones that of their placement.
        """
        against = None if unit is None else contradiction(self.arm_unit, unit)
        if unit is not None and against is not None:
            size, metres = f"{self.extent:.3g}", self.extent * UNITS[self.arm_unit] / UNITS[unit]
            doubt: str | None = (
                f"{against}: its {size} {self.arm_unit} are taken for {size} {unit} by the arm, which reaches "
                f"{reach:.3g} {unit}; give --arm-unit {unit} (arm_unit: {unit} in a problem file), "
                f"which makes them {metres:.3g} {unit}"
            )
        else:
            doubt = too_small(self.extent, self.length, reach, self.arm_unit) or too_large(
                self.extent, reach, self.arm_unit
            )
        return self if doubt is None else replace(self, warnings=(*self.warnings, doubt))

    def summary(self) -> dict[str, Any]:
        """Return all of it as plain data."""
        return {
            "file": self.file,
            "format": self.form,
            "unit": self.unit,
            "arm_unit": self.arm_unit,
            "dimension": self.bounds.shape[1],
            "segments": self.segments,
            "length": self.length,
            "bounds": self.bounds.tolist(),
            "subpaths": [
                {
                    "segments": part.segments,
                    "length": part.length,
                    "start": part.start.tolist(),
                    "end": part.end.tolist(),
                    "closed": part.closed,
                }
                for part in self.subpaths
            ],
            "gaps": [{"after": gap.after, "length": gap.length, "bridged": gap.bridged} for gap in self.gaps],
            "tolerance": self.tolerance,
            "chord_error": self.chord_error,
            "joined": {"count": len(self.joints), "largest": max(self.joints, default=0.0)},
            "ignored": [{"what": e.what, "count": e.count, "lines": list(e.lines)} for e in self.ignored],
            "notes": list(self.notes),
            "warnings": list(self.warnings),
            **self.more,
        }

    def lines(self) -> list[str]:
        """Return all of it as lines of text."""
        low, high = self.bounds
        size = " × ".join(f"{extent:.6g}" for extent in high - low)
        kinds = ", ".join(_plural(kind, count) for kind, count in self.segments.items())
        lines = [
            f"{self.form}: {_plural('subpath', len(self.subpaths))} of {kinds}",
            f"unit {self.unit}; the path is in {self.arm_unit}",
            f"length {self.length:.9g} {self.arm_unit}, {size} {self.arm_unit}, "
            f"from {point_text(low)} to {point_text(high)}",
            f"tolerance {self.tolerance:.3g} {self.arm_unit}: {self._closeness()}",
        ]
        lines += [f"warning: {warning}" for warning in self.warnings]
        for k, part in enumerate(self.subpaths[:40]):
            kinds = ", ".join(_plural(kind, count) for kind, count in part.segments.items())
            ends = "closed" if part.closed else f"to {point_text(part.end)}"
            lines.append(f"  subpath {k}: {kinds}, length {part.length:.6g}, from {point_text(part.start)} {ends}")
            if k < len(self.gaps):
                lines.append(f"  gap of {self.gaps[k].length:.6g}: {_BRIDGES[self.gaps[k].bridged]}")
        if len(self.subpaths) > 40:
            lines.append(f"  … and {len(self.subpaths) - 40} more, see --json")
        lines += [f"{name}: {value}" for name, value in self.more.items()]
        lines += [f"note: {note}" for note in self.notes]
        return lines + [f"ignored: {entry}" for entry in self.ignored]

    def _closeness(self) -> str:
        flat = f"flattened within {self.chord_error:.2g}" if self.chord_error else "nothing was flattened"
        if not self.joints:
            return f"{flat}, no joint had to be closed"
        return f"{flat}, {_plural('joint', len(self.joints))} closed, the widest {max(self.joints):.2g}"


_BRIDGES = {
    None: "not bridged; say gaps: line, lift or subpath",
    "line": "joined by a straight line",
    "lift": "crossed above",
    "rapid": "crossed by the rapid moves of the file",
}


def drawing(
    file: str,
    form: str,
    unit: str,
    metres: float,
    strokes: Iterable[Sequence[Piece]],
    options: Options,
    travels: Sequence[tuple[Piece, ...]] | None = None,
    close: bool = True,
    **more: Any,
) -> Drawing:
    """Return the drawing that a reader's strokes make.

    Parameters
    ----------
    file, form, unit : str
    metres : float
        In one of the file's numbers.
    strokes : iterable of pieces
        Those that follow on each other within the tolerance become one subpath.
    options : Options
    travels : sequence of tuple of Piece, optional
        What the file itself does between strokes; they are then kept apart.
    close : bool
        Whether a stroke that ends within the tolerance of its start is meant to be closed.
    **more
        Further fields.

    Raises
    ------
    InvalidInputError
        If nothing is left to follow.
    """
    within = options.within
    given = [list(stroke) for stroke in strokes if stroke]
    if not given:
        raise InvalidInputError("", "draws nothing that could be followed", "is it the right file?", source=file)
    if travels is None:
        given = _connected(given, within)
    curves = sum(piece.curve is not None for stroke in given for piece in stroke)
    notes, warnings = list(more.pop("notes", ())), list(more.pop("warnings", ()))
    chord_error = float(more.pop("chord_error", 0.0))
    if options.subpath is not None:
        if options.subpath >= len(given):
            reason = f"is {options.subpath}, and there are {len(given)} subpaths, counted from 0"
            raise InvalidInputError("subpath", reason, "give one that is there", source=file)
        given, travels = [given[options.subpath]], None if travels is None else []
        notes.append(f"only subpath {options.subpath} was taken")
    parts = [fitted(stroke, within if close else 0.0) for stroke in given]
    if curves > MOST_CURVES:
        parts = [without_curves(part, within) for part in parts]
        notes.append(f"its {curves} curves are more than {MOST_CURVES} and were flattened")
    subpaths = [Subpath(part.pieces) for part in parts]
    if options.lift is not None:
        subpaths = [Subpath(tuple(piece.raised() for piece in part.pieces)) for part in subpaths]
    gaps, ways = [], []
    for k, (before, after) in enumerate(pairwise(subpaths)):
        length = float(distance(after.start - before.end))
        way = _travel(before.end, after.start, options) if travels is None else travels[k]
        named = ("line" if options.lift is None else "lift") if travels is None else "rapid"
        gaps.append(Gap(k, length, None if way is None else named))
        ways.append(way)
    made = Drawing(
        file, form, unit, options.arm_unit, tuple(subpaths), tuple(gaps), tuple(ways), within,
        max([chord_error, *(part.chord_error for part in parts)]),
        tuple(joint for part in parts for joint in part.joints), notes=tuple(notes), warnings=tuple(warnings), **more,
    )  # fmt: skip
    doubt = unlikely(made.extent * UNITS[options.arm_unit], metres * options.scale, unit)
    return made if doubt is None else replace(made, warnings=(*made.warnings, doubt))


def _connected(strokes: list[list[Piece]], within: float) -> list[list[Piece]]:
    """Return strokes of which none starts where the one before it ends."""
    done: list[list[Piece]] = []
    for stroke in strokes:
        if done and distance(stroke[0].start - done[-1][-1].end) <= within:
            done[-1] += stroke
        else:
            done.append(stroke)
    return done


def _travel(start: FloatArray, end: FloatArray, options: Options) -> tuple[Piece, ...] | None:
    """Return the pieces from one subpath to the next, None if nobody has said which."""
    if options.lift is not None:
        up = np.array([0.0, 0.0, options.lift])
        way = line(np.stack([start, start + up, end + up, end]), "gap")
    elif options.gaps == "line":
        way = line(np.stack([start, end]), "gap")
    else:
        return None
    return () if way is None else (way,)


def _plural(name: str, count: int) -> str:
    special = {"flattened": "flattened curve", "bezier": "Bezier curve"}
    name = special.get(name, name)
    return f"{count} {name}{'s' * (count != 1)}"


def _counted(pieces: Iterable[Piece]) -> dict[str, int]:
    counts: Counter[str] = Counter()
    for piece in pieces:
        counts[piece.kind] += piece.count
    return dict(counts)

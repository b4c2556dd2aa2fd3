"""The machine that a G-code program drives: its modes, where its tool is, and the moves that it has made."""

from __future__ import annotations

import math
from array import array
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from selfmotion._types import FloatArray
from selfmotion.errors import InvalidInputError
from selfmotion.exchange.gcode_words import Block, Word
from selfmotion.exchange.ledger import Ledger
from selfmotion.exchange.reading import CURVE_WEIGHT, Budget, Options, settled_unit
from selfmotion.paths.base import SPACE
from selfmotion.units import UNITS

RAPID, _LINE, _CLOCKWISE, _COUNTER = 0, 1, 2, 3
# The axes of a plane, in the order in which counter-clockwise turns the first to the second, and the offsets' letters.
_PLANES = {17: (0, 1, 2), 18: (2, 0, 1), 19: (1, 2, 0)}
_OFFSETS = "IJK"
_UNIT_WORDS = {20: "inch", 21: "mm"}
# G words of which a block may hold one: they contradict each other.
_GROUPS = ({0, 1, 2, 3}, set(_PLANES), set(_UNIT_WORDS), {90, 91}, {90.1, 91.1}, {93, 94, 95}, {54, 55, 56, 57, 58, 59})
# G words without meaning for a path that is given in numbers; they are reported.
_HARMLESS = {4, 9, 40, 43, 49, 61, 61.1, 64, 80, 93, 94, 95, 96, 97, 98, 99}
# G words that move the path even where they stand alone: coordinates of another kind (polar, cylindrical, diameters);
# compensation; scale, mirror and rotation; macros; and motions that go on in the blocks after it.
_HARMFUL = {
    7, 7.1, 12.1, 16, 107, 112, 41, 41.1, 42, 42.1, 43.4, 43.5, 51, 51.1, 68, 68.2, 65, 66,
    5, 5.2, 33, 34, 35, 38.2, 38.3, 38.4, 38.5, 73, 74, 76, 81, 82, 83, 84, 85, 86, 87, 88, 89,
}  # fmt: skip
# Systems of coordinates: G54.1 and G154 have as many as P says.
_SYSTEMS = {54, 55, 56, 57, 58, 59, 54.1, 59.1, 59.2, 59.3, 154}
_HOME = {28, 30, 53}
# An arc whose ends are nearer than this part of its radius is a full circle.
_SAME = 1e-9
_FEW = 12  # feeds and speeds that are shown


@dataclass(frozen=True)
class Turn:
    """An arc: in which axes, about which centre, from which angle, how far [rad]."""

    axes: tuple[int, int, int]
    center: tuple[float, float]
    radius: float
    start: float
    sweep: float


class Program:
    """The state of the machine, and the moves that it has made.

    Attributes
    ----------
    points : array of float
        Where it began, and where the tool was after each move, three numbers each, in the unit first named.
    kinds : bytearray
        0 to 3 of each move.
    turns : dict of int to Turn
        Of the moves that are arcs.
    """

    def __init__(self, unit: str | None, options: Options) -> None:
        self.points = array("d", [0.0] * SPACE)
        self.kinds = bytearray()
        self.turns: dict[int, Turn] = {}
        self.ledger = Ledger()
        self.notes: list[str] = []
        self.unit: str | None = None
        self._asked, self._options = unit, options
        self._at = [0.0] * SPACE
        self._motion: int | None = None
        self._axes = _PLANES[17]
        self._factor = 1.0
        self._absolute, self._absolute_arcs = True, False
        self._system: tuple[float, float] | None = None
        self._named = [False] * SPACE
        self._assumed: set[int] = set()
        self._budget = Budget()
        self._values: dict[str, dict[float, int]] = {"F": {}, "S": {}}

    def listed(self, letter: str) -> str:
        """Return the values that a letter had, each with the line in which it first did."""
        found = [f"{letter}{value:g} (line {at})" for value, at in self._values[letter].items()]
        return ", ".join(found[:_FEW]) + (f" and {len(found) - _FEW} more" if len(found) > _FEW else "")

    def assumed(self, dimension: int) -> str:
        """Return the axes of which a cut begins where nobody has said: there the tool was taken to be at 0."""
        return ", ".join("XYZ"[axis] for axis in sorted(self._assumed) if axis < dimension)

    def take(self, block: Block) -> bool:
        """Carry out one block; return whether the program goes on."""
        if block.aside:
            self.ledger.note(block.aside, block.line)
        if block.last:
            return False
        codes, numbers, goes_on = self._sorted(block)
        turns = numbers.pop("P", None)
        motion = self._modes(codes, numbers, turns, block)
        if motion is None and numbers:
            if self._motion is None:
                raise _wrong(block, "moves before any G0, G1, G2 or G3", "say which it is")
            motion = self._motion
        elif motion is not None:
            self._motion = motion
        if turns is not None:
            if motion in (_CLOCKWISE, _COUNTER) and turns != 1:
                raise _wrong(block, f"makes {turns:g} turns in one arc", "write one block per turn", f"P{turns:g}")
            self.ledger.note("P", block.line)
        if motion is not None and numbers:
            self._move(motion, numbers, block)
        return goes_on

    def _sorted(self, block: Block) -> tuple[list[float], dict[str, float], bool]:
        """Return a block's G words and its coordinates, and whether the program goes on after it."""
        numbers: dict[str, float] = {}
        codes: list[float] = []
        goes_on, seen = True, set()
        for word in block.words:
            letter, value = word
            if letter not in "GM" and letter in seen:
                raise _wrong(block, f"has the word {letter} twice", "leave one of them")
            seen.add(letter)
            if letter == "G":
                codes.append(value)
            elif letter in "XYZIJKRP":
                numbers[letter] = value
            else:
                goes_on = self._other(word, block) and goes_on
        return codes, numbers, goes_on

    def _other(self, word: Word, block: Block) -> bool:
        """Note a word that is neither G nor a coordinate."""
        letter, value = word
        if letter in "FS":
            self._values[letter].setdefault(value, block.line)
        elif letter in "ABCUVW":
            raise _wrong(block, f"moves the axis {letter}, which is not read", "post-process for three axes", str(word))
        elif letter == "M" and value in (98, 99, 97):
            reason, remedy = f"calls a subprogram ({word})", "write the program out in one piece"
            raise _wrong(block, reason, remedy)
        elif letter == "M" and value in (2, 30):
            return False
        elif letter not in "NO":
            self.ledger.note(str(word) if letter in "MT" else letter, block.line)
        return True

    def _modes(
        self, codes: Sequence[float], numbers: dict[str, float], parameter: float | None, block: Block
    ) -> int | None:
        """Obey the G words of a block; return the motion among them."""
        for group in _GROUPS:
            asked = [code for code in codes if code in group]
            if len(asked) > 1:
                raise _wrong(block, f"asks for both G{asked[0]:g} and G{asked[1]:g}", "leave one of them")
        motion = next((int(code) for code in codes if code in _GROUPS[0]), None)
        for code in codes:
            if code in _PLANES:
                self._axes = _PLANES[int(code)]
            elif code in _UNIT_WORDS:
                self._use(_UNIT_WORDS[int(code)], block)
            elif code in (90, 91):
                self._absolute = code == 90
            elif code in (90.1, 91.1):
                self._absolute_arcs = code == 90.1
            elif code in _HOME:
                self._go_home(code, motion, numbers, block)
            elif code in _SYSTEMS:
                self._place(code, parameter, block)
            elif code not in _GROUPS[0]:
                self._aside(code, motion, numbers, block)
        return motion

    def _go_home(self, code: float, motion: int | None, numbers: dict[str, float], block: Block) -> None:
        """Report a move to a place of the machine, after which nobody knows where the tool is."""
        if code == 53 and (self._motion if motion is None else motion) in (_LINE, _CLOCKWISE, _COUNTER):
            raise _wrong(block, "cuts in the machine's own coordinates (G53)", "use the workpiece's")
        self.ledger.note(f"G{code:g} (to a place of the machine)", block.line)
        self._lose(numbers)

    def _place(self, code: float, parameter: float | None, block: Block) -> None:
        """Report a system of coordinates; refuse another than the one before."""
        system = (code, parameter or 0.0)
        if self._system is not None and self._system != system:
            names = [f"G{c:g}" + (f" P{p:g}" if p else "") for c, p in (self._system, system)]
            reason = f"changes from {names[0]} to {names[1]}, whose distance only the machine knows"
            raise _wrong(block, reason, "keep to one of them")
        self._system = system
        self.ledger.note(f"G{code:g}", block.line)

    def _aside(self, code: float, motion: int | None, numbers: dict[str, float], block: Block) -> None:
        """Report a G word without meaning for the path; refuse one that would change it."""
        if code in _HARMFUL or (code not in _HARMLESS and numbers):
            raise _wrong(block, f"asks for G{code:g}, which is not read", "post-process without it")
        if code == 80:
            self._motion = None
        elif code == 4:  # a dwell, for as many seconds as X says
            if motion is not None and numbers:
                raise _wrong(block, f"asks for a dwell (G4) and a move (G{motion}) at once", "write two blocks")
            numbers.clear()
        self.ledger.note(f"G{code:g}", block.line)

    def _use(self, unit: str, block: Block) -> None:
        """Count in another unit from here on; points stay in the first that was named."""
        if self._asked is not None and self._asked != unit:
            by = f"G{20 if unit == 'inch' else 21} in line {block.line}"
            settled_unit(self._asked, unit, by)
        if self.unit is None:
            if self.kinds:
                raise _wrong(block, "says its unit after the first move", "say G20 or G21 before it")
            self.unit = unit
        elif unit != self.unit and (note := "the unit changes within the program") not in self.notes:
            self.notes.append(note)
        self._factor = UNITS[unit] / UNITS[self.unit]

    def _lose(self, numbers: dict[str, float]) -> None:
        """Forget where the tool is, in the axes that are named, or in all of them."""
        for axis, letter in enumerate("XYZ"):
            if letter in numbers or not any(name in numbers for name in "XYZ"):
                self._at[axis], self._named[axis] = np.nan, True
        numbers.clear()
        self._record(RAPID)

    def _record(self, kind: int) -> None:
        self._budget.spend(1 if kind in (RAPID, _LINE) else CURVE_WEIGHT)
        self.points.extend(self._at)
        self.kinds.append(kind)

    def _move(self, motion: int, numbers: dict[str, float], block: Block) -> None:
        start, end = list(self._at), list(self._at)
        for axis, letter in enumerate("XYZ"):
            if letter in numbers:
                value = numbers[letter] * self._factor
                end[axis] = value if self._absolute else start[axis] + value
            if not self._named[axis] and (motion != RAPID or (letter in numbers and not self._absolute)):
                self._assumed.add(axis)
            if letter in numbers and (self._absolute or motion != RAPID):
                self._named[axis] = True
        arc_words = [letter for letter in "IJKR" if letter in numbers]
        if motion in (RAPID, _LINE) and arc_words:
            reason = f"has {', '.join(arc_words)} in a straight move"
            raise _wrong(block, reason, "use G2 or G3 for an arc")
        if motion != RAPID and not all(math.isfinite(x) for x in (*start, *end)):
            reason = "cuts from where the machine's own place (G28, G30, G53) has left the tool"
            raise _wrong(block, reason, "add a G0 to a known point before it")
        if motion in (_CLOCKWISE, _COUNTER):
            self.turns[len(self.kinds)] = self._turn(motion, start, end, numbers, block)
        self._at = end
        self._record(motion)

    def _turn(
        self, motion: int, start: Sequence[float], end: Sequence[float], numbers: dict[str, float], block: Block
    ) -> Turn:
        """Return the arc that a block describes, contradictions refused."""
        a, b, across = self._axes
        if _OFFSETS[across] in numbers:
            plane = {2: "G17", 1: "G18", 0: "G19"}[across]
            raise _wrong(block, f"has {_OFFSETS[across]} in an arc in the plane {plane}", "correct it, or the plane")
        first, last = np.array([start[a], start[b]]), np.array([end[a], end[b]])
        given = [letter for letter in (_OFFSETS[a], _OFFSETS[b]) if letter in numbers]
        clockwise = motion == _CLOCKWISE
        slack = self._slack
        if "R" in numbers:
            if given:
                raise _wrong(block, f"gives both R and {' and '.join(given)}", "leave one of the two out")
            center = _by_radius(first, last, numbers["R"] * self._factor, clockwise, slack, block)
        elif given:
            offset = np.array([numbers.get(_OFFSETS[axis], 0.0) * self._factor for axis in (a, b)])
            center = offset if self._absolute_arcs else first + offset
            if self._absolute_arcs and len(given) < 2:
                raise _wrong(block, "gives one coordinate of an absolute centre (G90.1)", "give both")
            center = _by_center(first, last, center, clockwise, slack, block)
        else:
            raise _wrong(block, "is an arc without centre or radius", "add I and J, or R")
        radius = float(np.hypot(*(first - center)))
        begin = float(np.arctan2(*(first - center)[::-1]))
        sweep = _sweep(first, last, center, clockwise)
        if np.hypot(*(last - first)) <= _SAME * radius:
            sweep = 2 * np.pi
        return Turn((a, b, across), (center[0], center[1]), radius, begin, -sweep if clockwise else sweep)

    @property
    def _slack(self) -> float:
        """The tolerance, in the program's unit."""
        unit = self.unit or self._asked
        return self._options.within / self._options.factor(UNITS[unit]) if unit else 0.1


def _by_radius(
    first: FloatArray, last: FloatArray, radius: float, clockwise: bool, slack: float, block: Block
) -> FloatArray:
    """Return the centre of an arc of given radius: the short way round, for a negative one the long way."""
    chord = last - first
    size = float(np.hypot(*chord))
    if size == 0:
        raise _wrong(block, "ends where it starts, and R does not say about which centre", "use I and J")
    if size > 2 * abs(radius) + slack:
        reason = f"has ends {size:.6g} apart, more than twice its radius {abs(radius):g}"
        raise _wrong(block, reason, "correct R or the end")
    height = np.sqrt(max(radius * radius - 0.25 * size * size, 0.0))
    side = np.array([-chord[1], chord[0]]) / size
    return 0.5 * (first + last) + side * height * (1.0 if clockwise == (radius < 0) else -1.0)


def _by_center(
    first: FloatArray, last: FloatArray, center: FloatArray, clockwise: bool, slack: float, block: Block
) -> FloatArray:
    """Return the centre as far from the end as from the start: digits that were rounded off are put right."""
    radii = np.hypot(*(first - center)), np.hypot(*(last - center))
    if not radii[0] > 0:
        raise _wrong(block, "is an arc of radius zero", "correct I, J and K")
    if abs(radii[0] - radii[1]) > slack:
        reason = f"has its start {radii[0]:.6g} and its end {radii[1]:.6g} from its centre"
        raise _wrong(block, reason, f"correct I, J, K or the end; up to {slack:.3g} are put right")
    chord = last - first
    size = float(chord @ chord)
    if size == 0:
        return center
    middle = 0.5 * (first + last)
    moved = center - chord * float((center - middle) @ chord) / size
    if np.hypot(*(moved - center)) > slack and _strays(first, last, (center, moved), clockwise) > 2 * slack:
        reason = f"has ends {np.sqrt(size):.3g} apart that lie nearly on a line with its centre"
        raise _wrong(block, reason, "correct I, J, K or the end; a full circle ends where it starts")
    return moved


def _strays(first: FloatArray, last: FloatArray, centers: tuple[FloatArray, FloatArray], clockwise: bool) -> float:
    """Return how far apart arcs about two centres are: a short one hardly strays, a full turn may become a short arc.

    About a centre with two radii the arc goes from one to the other.
    """
    parts = np.array([0.25, 0.5, 0.75])
    ways = []
    for center in centers:
        radii = np.hypot(*(first - center)), np.hypot(*(last - center))
        sweep = _sweep(first, last, center, clockwise)
        angle = np.arctan2(*(first - center)[::-1]) + parts * (-sweep if clockwise else sweep)
        radius = radii[0] + parts * (radii[1] - radii[0])
        ways.append(center[:, None] + radius * np.stack([np.cos(angle), np.sin(angle)]))
    return float(np.hypot(*(ways[1] - ways[0])).max())


def _sweep(first: FloatArray, last: FloatArray, center: FloatArray, clockwise: bool) -> float:
    """Return how far an arc turns [rad], from nearly 0 to a full turn."""
    begin, finish = (float(np.arctan2(*(end - center)[::-1])) for end in (first, last))
    return float((begin - finish if clockwise else finish - begin) % (2 * np.pi)) or 2 * np.pi


def _wrong(block: Block, reason: str, remedy: str, value: str | None = None) -> InvalidInputError:
    return InvalidInputError(f"line {block.line}", reason, remedy, value)

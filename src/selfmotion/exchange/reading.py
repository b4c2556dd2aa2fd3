"""How a drawing is read: the options that readers, problem files and the command line share, units, bounds."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, fields
from inspect import Parameter, signature
from typing import Any, Literal, TypedDict, TypeVar, get_type_hints

from selfmotion._checks import choice, integer, number, positive
from selfmotion.errors import InvalidInputError, MissingExtraError
from selfmotion.exchange.files import read_bytes
from selfmotion.units import UNITS

Unit = Literal["m", "mm", "cm", "inch"]
LARGEST_FILE = 100_000_000
"""Size [bytes] from which a drawing is refused."""
MOST_SEGMENTS = 2_000_000
"""Number of lines from which a drawing is refused; a curve counts for 20."""
CURVE_WEIGHT = 20
"""How many lines a curve counts for where too many are refused."""
_FINE = 1e-4  # the tolerance by default [m], on the drawing

Function = TypeVar("Function", bound=Callable[..., Any])


class Reading(TypedDict, total=False):
    """The options of every reader of drawings by name; :class:`Options` says what they mean."""

    arm_unit: Unit
    scale: float
    tolerance: float | None
    gaps: Literal["error", "line"]
    lift: float | None
    subpath: int | None


@dataclass(frozen=True)
class Options:
    """How a drawing is to be read.

    Parameters
    ----------
    arm_unit : {"m", "mm", "cm", "inch"}
        Of the arm's lengths, and so of the path.
    scale : float
        A further factor, on the drawing about its origin.
    tolerance : float, optional
        How far apart ends may be that are meant to meet, how far what is flattened may stray, and by how much the two
        radii of a G-code arc may differ; in `arm_unit`. By default 0.1 mm on the drawing.
    gaps : {"error", "line"}
        Whether straight lines join subpaths that do not meet.
    lift : float, optional
        Makes a space curve in the plane z = 0 of it, which rises by this much, crosses and comes down between subpaths;
        in `arm_unit`.
    subpath : int, optional
        Only this one, counted from 0.

    Raises
    ------
    InvalidInputError
        If one has no meaning, or two contradict each other.
    """

    arm_unit: str = "m"
    scale: float = 1.0
    tolerance: float | None = None
    gaps: str = "error"
    lift: float | None = None
    subpath: int | None = None

    def __post_init__(self) -> None:
        choice("arm_unit", self.arm_unit, UNITS)
        choice("gaps", self.gaps, ("error", "line"))
        positive("scale", self.scale)
        if self.tolerance is not None:
            positive("tolerance", self.tolerance)
        if self.lift is not None:
            number("lift", self.lift)
            if self.lift == 0:
                raise InvalidInputError("lift", "is zero", "give the height, or gaps: line to stay in the plane")
            if self.gaps == "line":
                raise InvalidInputError("gaps", "is given beside lift", "leave one of the two out", self.gaps)
        if self.subpath is not None:
            integer("subpath", self.subpath, 0, MOST_SEGMENTS)

    def factor(self, metres: float) -> float:
        """Return what a coordinate is multiplied by, of which one is `metres`."""
        return metres / UNITS[self.arm_unit] * self.scale

    @property
    def within(self) -> float:
        """The tolerance, in the unit of the path."""
        return self.factor(_FINE) if self.tolerance is None else float(self.tolerance)

    def no_bridges(self, why: str, remedy: str) -> None:
        """Refuse `gaps` and `lift` where something else says how the path gets across."""
        for name, given in (("gaps", self.gaps != "error"), ("lift", self.lift is not None)):
            if given:
                raise InvalidInputError(name, why, remedy, getattr(self, name))


class Budget:
    """Counts lines and curves, and refuses too many of them."""

    def __init__(self) -> None:
        self._spent = 0

    def spend(self, weight: int) -> None:
        """Count what is as much work to read as `weight` lines."""
        self._spent += weight
        if self._spent > MOST_SEGMENTS:
            reason = f"has more than {MOST_SEGMENTS} lines, each curve counted as {CURVE_WEIGHT}"
            raise InvalidInputError("", reason, "cut it into several files")


def spelled_out(function: Function) -> Function:
    """Write the options out in the signature of a function that takes ``**options: Unpack[Reading]``.

    For help, and for the problem file's schema, which is derived from signatures.
    """
    own = [part for part in signature(function).parameters.values() if part.kind is not Parameter.VAR_KEYWORD]
    types = get_type_hints(Reading)
    options = [
        Parameter(field.name, Parameter.KEYWORD_ONLY, default=field.default, annotation=types[field.name])
        for field in fields(Options)
    ]
    annotations = {name: hint for name, hint in function.__annotations__.items() if name != "options"}
    function.__annotations__ = annotations | types
    function.__signature__ = signature(function).replace(parameters=own + options)  # type: ignore[attr-defined]
    return function


@contextmanager
def about(file: str | os.PathLike[str]) -> Iterator[None]:
    """Let every InvalidInputError inside name the file."""
    try:
        yield
    except InvalidInputError as error:
        raise error if error.source else error.inside(source=os.fspath(file)) from None


def settled_unit(unit: str | None, stated: str | None, by: str) -> tuple[str, str]:
    """Return the unit of a file's numbers, and the words that say who stated it.

    Parameters
    ----------
    unit, stated : str or None
        What the caller says and what the file says.
    by : str
        How the file says it, or would.

    Raises
    ------
    InvalidInputError
        If neither says it, or they contradict each other.
    """
    if stated is not None and unit not in (None, stated):
        remedy = "leave unit out to take the file's word; if that is wrong, correct the file or use scale"
        raise InvalidInputError("unit", f"is {unit}, and the file says {stated} by {by}", remedy)
    if stated is not None:
        return stated, f"{stated} by {by}"
    if unit is not None:
        return unit, f"{unit}, as asked for"
    raise InvalidInputError(
        "unit", f"is stated nowhere; the file would say it by {by}", "give unit: mm, or whichever it is"
    )


def read_checked(file: str | os.PathLike[str]) -> bytes:
    """Return the bytes of a drawing; too many of them are an InvalidInputError."""
    return read_bytes(file, LARGEST_FILE)


def needs_extra(package: str) -> MissingExtraError:
    """Return the error of a drawing whose reader is not installed."""
    return MissingExtraError("", f"needs the package {package}", "pip install 'selfmotion[io]'")

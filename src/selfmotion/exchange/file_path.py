"""What the paths of all files have in common: inside is another path, and what is wrong with it names the file."""

from __future__ import annotations

from collections.abc import Callable
from typing import ClassVar, TypeVar

from selfmotion._types import FloatArray
from selfmotion.errors import InvalidInputError
from selfmotion.paths import Path

Result = TypeVar("Result")


class PathFromFile(Path):
    """A path that a file describes.

    Attributes
    ----------
    file : str
    path : Path
        What was read.
    """

    kind: ClassVar[str]

    def __init__(self, file: str, path: Path) -> None:
        self.file = file
        self.path = path
        self.dimension, self.highest_order = path.dimension, path.highest_order

    def __repr__(self) -> str:
        return f"{type(self).__name__}({self.file!r}, {self.path!r})"

    @property
    def breaks(self) -> FloatArray:
        """Those of the path inside."""
        return self.path.breaks

    @property
    def waypoints(self) -> FloatArray:
        """Path parameters of the file's rows, if it has rows."""
        return self.path.waypoints

    def _evaluate(self, r: FloatArray, order: int) -> FloatArray:
        return self.path(r, order)

    def _fastest(self, low: float, high: float) -> float:
        return self.path.fastest(low, high)

    def _bending(self, low: float, high: float) -> float:
        return self.path.bending(low, high)

    def _turning(self, low: float, high: float) -> float:
        return self.path.turning(low, high)


def about_file(file: str, read: Callable[[], Result]) -> Result:
    """Return what `read` does; its InvalidInputError becomes one of the field ``file``.

    The source of what is wrong further out is the problem file, so the name of this file goes into the reason.
    """
    try:
        return read()
    except InvalidInputError as error:
        where = ", ".join(part for part in (file, error.field) if part)
        raise type(error)("file", f"{where}: {error.reason}", error.remedy, error.value) from None

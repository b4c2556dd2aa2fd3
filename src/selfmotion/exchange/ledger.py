"""What stands in a file and is not part of the path, counted: nothing is ignored silently."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass

_MOST_LINES = 1000  # of the lines named for one ignored word


@dataclass(frozen=True)
class Ignored:
    """What stands in a file and is not part of the path.

    Attributes
    ----------
    what : str
    count : int
        How often.
    lines : tuple of int
        Where, as far as the format has lines; at most the first thousand.
    """

    what: str
    count: int
    lines: tuple[int, ...] = ()

    def __str__(self) -> str:
        shown = ", ".join(map(str, self.lines[:8])) + (", …" if len(self.lines) > 8 else "")
        where = f" (line{'s' * (len(self.lines) > 1)} {shown})" if self.lines else ""
        times = f", {self.count} times" if self.count > 1 else ""
        return f"{self.what}{times}{where}"


class Ledger:
    """Counts what is ignored, in the order in which it first appears."""

    def __init__(self) -> None:
        self._counts: Counter[str] = Counter()
        self._lines: dict[str, list[int]] = {}

    def note(self, what: str, line_number: int | None = None) -> None:
        """Count one more."""
        self._counts[what] += 1
        lines = self._lines.setdefault(what, [])
        if line_number is not None and len(lines) < _MOST_LINES and line_number not in lines[-1:]:
            lines.append(line_number)

    def entries(self) -> tuple[Ignored, ...]:
        """Return all that was counted."""
        return tuple(Ignored(what, count, tuple(self._lines[what])) for what, count in self._counts.items())

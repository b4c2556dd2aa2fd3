"""What an answer may know besides what it was asked: where files are, and whom to tell how far it is."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

Tell = Callable[[int, int, float | None], None]
"""Called with what is done, the total, 0 where it is not known, and the best cost so far, None where there is none."""


class Place(NamedTuple):
    """The one folder that problems may name files in.

    Attributes
    ----------
    folder : str or None
        None where problems may name no files at all.
    """

    folder: str | None = None


Answer = Callable[[dict[str, Any], Tell, Place], Any]
"""What a task does: takes what is asked, whom to tell of progress, and the place; returns what JSON knows."""

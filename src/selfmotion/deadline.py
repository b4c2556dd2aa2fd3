"""When a computation has to end: what takes long looks at the clock in between."""

from __future__ import annotations

import time


class OutOfTimeError(Exception):
    """The deadline passed before a computation ended; what was known before still holds."""


def in_time(deadline: float) -> None:
    """Go on, unless `deadline` has passed, as :func:`time.perf_counter` tells it.

    Raises
    ------
    OutOfTimeError
    """
    if time.perf_counter() > deadline:
        raise OutOfTimeError

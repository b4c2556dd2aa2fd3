"""The one place that makes problems of what the page sends, and remembers the last few."""

from __future__ import annotations

import json
import os
from collections import OrderedDict
from collections.abc import Sequence
from threading import Lock
from typing import Any

from selfmotion.errors import InvalidInputError
from selfmotion.exchange import ProblemFile, problem_from
from selfmotion.exchange.named_files import NamedFile, check_inside

MOST_BREAKS = 2000
"""Of paths with more breaks than this only samples are looked at."""
_REMEMBERED = 4
_known: OrderedDict[Any, ProblemFile] = OrderedDict()
_lock = Lock()


def problem_of(data: Any, folder: str | None) -> ProblemFile:
    """Return the problem and planner that data describes, once it is sure to name no file outside of the folder.

    Parameters
    ----------
    data : object
        Parsed data of a problem file. Asked for again, and with files that have not changed, the same objects return.
    folder : str or None
        None where it may name no files.

    Raises
    ------
    InvalidInputError
        If it is no problem, or names a file that it must not.
    """
    if not isinstance(data, dict):
        raise InvalidInputError("problem", "is not a mapping", "give the data of a problem file")
    files = check_inside(data, folder)
    for name in ("arm", "path"):
        if name in data and not isinstance(data[name], dict):
            raise InvalidInputError(name, "is not a mapping", f"write {name}: {{kind: …}}", data[name])
    key = _key(data, folder, files)
    with _lock:
        made = _known.pop(key, None)
    if made is None:
        made = problem_from(data, folder or "")
    with _lock:
        _known[key] = made
        while len(_known) > _REMEMBERED:
            _known.popitem(last=False)
    return made


def _key(data: Any, folder: str | None, files: Sequence[NamedFile]) -> Any:
    """Return what is the same only for the same problem: its text, and how its files stand."""
    try:
        text = json.dumps(data)
    except (TypeError, ValueError, RecursionError):
        raise InvalidInputError("problem", "is not plain data", "give what JSON knows") from None
    marks = []
    for _, name in files:
        try:
            found = os.stat(os.path.join(folder or "", name))
            marks.append((found.st_mtime_ns, found.st_size, found.st_ino))
        except OSError:
            marks.append((0, 0, 0))
    return text, folder, tuple(marks)

"""What a worker can be asked: the names, which the server knows, and the functions, which only a worker loads.

A function takes what a page sent, already checked by its form.
"""

from __future__ import annotations

import json
import os
from collections.abc import Callable
from typing import Any, NamedTuple

from selfmotion.studio.folder import Folder, moved
from selfmotion.studio.place import Place, Tell


class Task(NamedTuple):
    """What the server allows a task.

    Attributes
    ----------
    seconds : float or None
        After which it is given up.
    largest : int
        Bytes that a page may send.
    """

    seconds: float | None = 120.0
    largest: int = 16_000_000


TASKS: dict[str, Task] = {
    "look": Task(),
    "plan": Task(seconds=None),  # the planner has its own limit
    "fit": Task(),
    "export": Task(largest=64_000_000),  # the text of a plan goes along
    "read": Task(),
    "write": Task(),
    "files": Task(),
    "open": Task(),
    "save": Task(),
    "schema": Task(),
    "examples": Task(),
}


def answer(name: str, payload: dict[str, Any], folder: Folder, tell: Tell) -> Any:
    """Do a task and return its result.

    Raises
    ------
    SelfMotionError
        If the payload is not what the task takes, or the task refuses.
    """
    from selfmotion.exchange.schema import checked
    from selfmotion.studio.forms import FORMS

    checked(FORMS[name], payload)
    if name == "check":
        return _check(folder, payload)
    if name in _FILE_TASKS:
        return _FILE_TASKS[name](folder, payload)
    from selfmotion.studio.answers import ANSWERS

    return ANSWERS[name](payload, tell, Place(folder.path))


def _files(folder: Folder, payload: dict[str, Any]) -> dict[str, Any]:
    return {"folder": folder.name, "files": folder.listed(), "may_write": folder.may_write}


def _open(folder: Folder, payload: dict[str, Any]) -> dict[str, Any]:
    from selfmotion.studio.texts import problem_in

    file = payload["file"]
    text = folder.open(file)
    return {"problem": moved(problem_in(text, file), os.path.dirname(file), ""), "text": text}


def _save(folder: Folder, payload: dict[str, Any]) -> dict[str, Any]:
    from selfmotion.exchange.yaml_text import yaml_text

    file = payload["file"]
    problem = moved(payload["problem"], "", os.path.dirname(file))
    text = json.dumps(problem, indent=2) + "\n" if file.lower().endswith(".json") else yaml_text(problem)
    folder.save(file, text, payload.get("force", False))
    return {"file": file}


_FILE_TASKS: dict[str, Callable[[Folder, dict[str, Any]], Any]] = {"files": _files, "open": _open, "save": _save}


def _check(folder: Folder, payload: dict[str, Any]) -> dict[str, Any]:
    """Refuse a problem file as `plan` would, and one that no page can open; only the server asks for this."""
    from selfmotion.exchange import load_problem

    load_problem(payload["path"])
    folder.open(payload["file"])
    return {}


__all__ = ["TASKS", "Task", "answer"]

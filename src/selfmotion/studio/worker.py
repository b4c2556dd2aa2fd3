"""A worker: ``python -m selfmotion.studio.worker FOLDER``, asked on its stdin and answering on its stdout, a line each.

A line in is ``{"task": name, "payload": {…}}``. Lines out are ``{"progress": {…}}``, any number of times, and then one
``{"result": …}`` or ``{"error": {…}}``. A thread reads stdin: when the server is gone, so is the worker, however busy.
"""

from __future__ import annotations

import ctypes
import importlib
import json
import math
import os
import queue
import sys
import threading
import time
import traceback
from collections.abc import Callable
from contextlib import suppress
from typing import Any, BinaryIO

from selfmotion.errors import InfeasibleError, SelfMotionError
from selfmotion.studio.folder import Folder
from selfmotion.studio.tasks import answer

_BETWEEN = 1 / 30  # seconds between two words of progress
_PATIENCE = 0.02  # seconds without a question after which a worker uses its time to get warm
_WARM = ("selfmotion.exchange", "numba", "selfmotion.studio.answers")


class Progress:
    """Says how far a task is, not too often, and the last word always.

    Parameters
    ----------
    say : callable
        Takes a line.
    """

    def __init__(self, say: Callable[[dict[str, Any]], None]) -> None:
        self._say = say
        self._said = -math.inf
        self._kept: dict[str, Any] | None = None

    def __call__(self, done: int, total: int, best: float | None) -> None:
        """Hear how far it is."""
        known = best is not None and math.isfinite(best)
        self._kept = {"done": int(done), "total": int(total), "best": float(best or 0.0) if known else None}
        if time.monotonic() - self._said >= _BETWEEN:
            self.flush()

    def flush(self) -> None:
        """Say what was kept back."""
        if self._kept is not None:
            self._say({"progress": self._kept})
            self._said, self._kept = time.monotonic(), None


class Worker:
    """Answers one question after another.

    Parameters
    ----------
    folder : Folder
    questions : BinaryIO
    answers : BinaryIO
    """

    def __init__(self, folder: Folder, questions: BinaryIO, answers: BinaryIO) -> None:
        self._folder, self._questions, self._answers = folder, questions, answers
        self._waiting: queue.SimpleQueue[bytes] = queue.SimpleQueue()

    def run(self) -> None:
        """Answer until stdin ends, which ends the process; get warm when there is nothing to answer."""
        threading.Thread(target=self._listen, daemon=True).start()
        for module in _WARM:
            with suppress(queue.Empty):
                self._answer(self._waiting.get(timeout=_PATIENCE))
            with suppress(Exception):  # what cannot be loaded is said when it is asked for
                importlib.import_module(module)
        # The very first look compiles for a while; files can be opened meanwhile.
        threading.Thread(target=_look_once, args=(self._folder,), daemon=True).start()
        while True:
            self._answer(self._waiting.get())

    def _listen(self) -> None:
        for line in self._questions:
            self._waiting.put(line)
        os._exit(0)

    def _answer(self, line: bytes) -> None:
        tell = Progress(self._say)
        try:
            question = json.loads(line)
            result = answer(question["task"], question["payload"], self._folder, tell)
            said = _line({"result": result})
        except Exception as error:
            said = _line({"error": refusal(error)})
        tell.flush()
        self._write(said)

    def _say(self, message: dict[str, Any]) -> None:
        self._write(_line(message))

    def _write(self, line: bytes) -> None:
        try:
            self._answers.write(line)
            self._answers.flush()
        except OSError:  # nobody listens
            os._exit(0)


def refusal(error: Exception) -> dict[str, Any]:
    """Return an error as a page hears it: never a traceback, which goes to the terminal if the mistake is ours."""
    if isinstance(error, SelfMotionError):
        from selfmotion.failures import blocked_object, error_object

        said = error_object(error)
        known = error if isinstance(error, InfeasibleError) else None
        return {
            "status": error.status,
            "message": said["message"],
            "remedy": said["remedy"],
            "field": said["field"],
            "blocked": None if known is None else [blocked_object(part) for part in known.blocked],
            "needs": None if known is None else [str(need) for need in known.needs],
        }
    if isinstance(error, MemoryError):
        message, remedy = "this needs more memory than there is", "lower samples or population"
    elif isinstance(error, RecursionError):
        message, remedy = "this is nested too deeply", "write plain data"
    else:
        traceback.print_exception(error)
        name = type(error).__name__
        message, remedy = f"a mistake in selfmotion: {name}: {str(error)[:200]}", "please report it, with the problem"
    return {"status": "error", "message": message, "remedy": remedy, "field": None, "blocked": None, "needs": None}


def _line(message: dict[str, Any]) -> bytes:
    try:
        text = json.dumps(message, allow_nan=False, default=_plain, separators=(",", ":"))
    except ValueError:  # a number that is not finite, which JSON has not
        text = json.dumps(_finite(message), allow_nan=False, default=_plain, separators=(",", ":"))
    return text.encode() + b"\n"


def _plain(value: Any) -> Any:
    """Return numpy's numbers and arrays as JSON knows them."""
    if hasattr(value, "tolist"):
        return _finite(value.tolist())
    raise TypeError(f"{type(value).__name__} is no plain data")


def _finite(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _finite(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def _look_once(folder: Folder) -> None:
    """Look at the first example, which loads and compiles what the first look of a page needs."""

    def silent(done: int, total: int, best: float | None) -> None:
        pass

    with suppress(Exception):  # what is wrong is said when it is asked for
        problem = answer("examples", {}, folder, silent)[0]["problem"]
        answer("look", {"problem": problem, "want": ["scene", "domain", "motion"], "settled": True}, folder, silent)


def _die_with_parent() -> None:
    """Ask Linux to end this process with its parent, even while a compiled loop keeps the thread above from running."""
    parent = os.getppid()
    with suppress(OSError, AttributeError, TypeError):
        ctypes.CDLL(None).prctl(1, 9, 0, 0, 0)
    if os.getppid() != parent:
        os._exit(0)


def main() -> None:
    """Keep the real stdout for answers, so that nothing that prints can spoil them, and answer."""
    _die_with_parent()
    folder = Folder(sys.argv[1])
    answers = os.fdopen(os.dup(sys.stdout.fileno()), "wb")
    os.dup2(sys.stderr.fileno(), sys.stdout.fileno())
    sys.stdout = sys.stderr
    os.chdir(folder.path)
    Worker(folder, sys.stdin.buffer, answers).run()


if __name__ == "__main__":
    main()

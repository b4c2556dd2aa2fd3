"""Problem files inside one chosen folder: nothing outside of it is read or written, whatever a page asks for."""

from __future__ import annotations

import os
import re
import stat
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from selfmotion.errors import InvalidInputError

SUFFIXES = (".yaml", ".yml", ".json")
MOST_FILES = 500
_MOST_ENTRIES = 20_000  # that are looked at: the folder may be somebody's home
_LONGEST_NAME = 200
_LARGEST = 16_000_000
_HEAD = 65_536  # bytes of a file that say what it is
_DEVICES = re.compile(r"(?:con|prn|aux|nul|conin\$|conout\$|com[0-9¹²³]|lpt[0-9¹²³])(?:\.|$)", re.IGNORECASE)
_CONTROL = re.compile(r"[\0-\x1f\x7f]")


@dataclass(frozen=True)
class Folder:
    """The folder that a studio works in.

    Parameters
    ----------
    path : str
        Its full name, without symbolic links.
    """

    path: str

    @classmethod
    def chosen(cls, problem: str | None, folder: str | None) -> Folder:
        """Return the folder asked for, else that of a problem file, else the working folder.

        Raises
        ------
        InvalidInputError
            If it is none.
        """
        asked = folder if folder is not None else os.path.dirname(problem or "")
        if "\0" in asked or (folder is not None and not folder):
            raise InvalidInputError("--folder", "is no name of a folder", "name one", folder)
        path = os.path.realpath(asked or ".")
        if not os.path.isdir(path):
            if folder is None:
                raise InvalidInputError("", "does not exist", "check the name", source=problem)
            raise InvalidInputError("--folder", "is not a folder", "name one that is there", folder)
        return cls(path)

    @property
    def name(self) -> str:
        """The last part of its name, which is all that a page is told."""
        return os.path.basename(self.path) or self.path

    @property
    def may_write(self) -> bool:
        """Whether files can be saved in it."""
        return os.access(self.path, os.W_OK | os.X_OK)

    def listed(self) -> list[str]:
        """Return the names of its problem files, and of those one folder below, at most 500."""
        names = [name for name in self._names() if self._holds_problem(name)]
        return sorted(names, key=lambda name: (name.count("/"), name.casefold(), name))

    def _names(self) -> Iterator[str]:
        left = _MOST_ENTRIES
        found = 0
        folders = [""]
        while folders:
            below = folders.pop(0)
            try:
                entries = os.scandir(os.path.join(self.path, below))
            except OSError:
                continue
            with entries:
                for entry in entries:
                    left -= 1
                    if not left or found == MOST_FILES:
                        return
                    name = f"{below}/{entry.name}" if below else entry.name
                    if not below and not entry.name.startswith(".") and entry.is_dir(follow_symlinks=False):
                        folders.append(name)
                    elif name.lower().endswith(SUFFIXES) and not _unfit(name):
                        found += 1
                        yield name

    def _holds_problem(self, name: str) -> bool:
        """Return whether a file reads like a problem file: not like a plan, a result, or something else altogether."""
        from selfmotion.exchange.telling import PLAN_FORMAT

        try:
            with open(self.inside("file", name), "rb") as file:
                head = file.read(_HEAD).decode("utf-8", "replace")
        except (InvalidInputError, OSError):
            return False
        if f'"{PLAN_FORMAT}"' in head[:200] or ('"status"' in head and '"wall_time_s"' in head):
            return False
        return len(head) >= _HEAD // 4 or ("arm" in head and "path" in head)

    def inside(self, field: str, name: str, there: bool = True) -> str:
        """Return the full name of a file in this folder.

        Parameters
        ----------
        field : str
            What an error calls the name.
        name : str
            Relative to the folder, with ``/`` between its parts.
        there : bool
            Whether there must be such a file.

        Raises
        ------
        InvalidInputError
            If the name is none of a file in here, wherever links lead, or there is no such file.
        """
        why = _unfit(name)
        if why:
            raise InvalidInputError(field, why, "name a file inside the studio's folder", name)
        path = os.path.realpath(os.path.join(self.path, *name.split("/")))
        if os.path.commonpath([self.path, path]) != self.path:
            raise InvalidInputError(field, "leads out of the studio's folder", "name a file inside of it", name)
        try:
            ordinary = stat.S_ISREG(os.stat(path).st_mode)
        except FileNotFoundError:
            if there:
                raise InvalidInputError(field, "does not exist", "check the name", name) from None
            return path
        except OSError as error:
            raise InvalidInputError(field, f"cannot be read ({error.strerror})", "check the name", name) from None
        if not ordinary:
            raise InvalidInputError(field, "is no ordinary file", "name a problem file", name)
        return path

    def open(self, file: str) -> str:
        """Return the text of a problem file.

        Raises
        ------
        InvalidInputError
            If it is not in here, no text, too large, or a plan or a result.
        """
        from selfmotion.exchange.files import read_bytes
        from selfmotion.exchange.telling import refuse_no_problem

        path = self.inside("file", _problem_name(file))
        try:
            text = read_bytes(path, _LARGEST).decode("utf-8-sig")
            refuse_no_problem(text)
        except UnicodeDecodeError:
            raise InvalidInputError("file", "is not a UTF-8 text file", "is it the right file?", file) from None
        except InvalidInputError as error:
            raise InvalidInputError("file", error.reason, error.remedy, file) from None
        return text

    def save(self, file: str, text: str, force: bool) -> None:
        """Write a problem file, whole or not at all.

        Raises
        ------
        InvalidInputError
            If it cannot be in here, or, of field ``force``, is there and not what selfmotion wrote.
        """
        from selfmotion.exchange.files import OutputFolder

        path = self.inside("file", _problem_name(file), there=False)
        if not self.may_write:
            raise InvalidInputError("file", "cannot be saved: the studio's folder is read-only", "copy the text", file)
        if not os.path.isdir(os.path.dirname(path)):
            raise InvalidInputError("file", "is in a folder that is not there", "save it beside the others", file)
        target = OutputFolder(os.path.dirname(path), force)
        try:
            target.write({os.path.basename(path): text.encode()})
        except InvalidInputError as error:
            if not force and "is not what selfmotion wrote" in error.reason:
                reason, remedy = "is there and not what selfmotion wrote", "save it anyway, or under another name"
                raise InvalidInputError("force", f"{file} {reason}", remedy) from None
            reason = error.reason.replace(path, "it").replace(os.path.dirname(path), "the folder")
            raise InvalidInputError("file", reason, "save it under another name", file) from None


def moved(problem: Any, start: str, end: str) -> Any:
    """Return a problem whose files, named relative to the folder `start`, are named relative to the folder `end`.

    Both are relative to the studio's folder, as the names that a page sees.
    """
    if isinstance(problem, dict):
        return {
            key: _moved(value, start, end) if key == "file" and isinstance(value, str) else moved(value, start, end)
            for key, value in problem.items()
        }
    return [moved(value, start, end) for value in problem] if isinstance(problem, list) else problem


def _moved(name: str, start: str, end: str) -> str:
    if start == end or not name or os.path.isabs(name) or "\0" in name:
        return name
    return os.path.relpath(os.path.join("/", start, name), os.path.join("/", end)).replace(os.sep, "/")


def _problem_name(file: str) -> str:
    if not file.lower().endswith(SUFFIXES):
        raise InvalidInputError("file", "is no name of a problem file", "end it in .yaml, .yml or .json", file)
    if file.count("/") > 1:
        raise InvalidInputError("file", "is too deep inside", "name a file in the folder or one folder below", file)
    return file


def _unfit(name: str) -> str:
    """Return why a name cannot be that of a file below a folder; nothing if it can."""
    parts = name.split("/")
    if not name or "" in parts or _CONTROL.search(name) or "\\" in name or ":" in name:
        return "is no name of a file in the studio's folder"
    if any(part.startswith(".") or part != part.strip() or part.endswith(".") for part in parts):
        return "is a hidden file, or leads out of the studio's folder"
    if any(_DEVICES.match(part) for part in parts):
        return "is the name of a device"
    try:
        too_long = len(name.encode()) > _LONGEST_NAME
    except UnicodeEncodeError:
        return "is no text"
    return "is too long a name" if too_long else ""


__all__ = ["MOST_FILES", "SUFFIXES", "Folder", "moved"]

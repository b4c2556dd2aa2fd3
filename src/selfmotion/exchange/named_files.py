"""The files that a problem's data names, found as the builder finds them, and their confinement to one folder."""

from __future__ import annotations

import os
from collections.abc import Iterator
from typing import Any, NamedTuple, get_args

from selfmotion._checks import is_file_name
from selfmotion._types import FileName
from selfmotion.errors import InvalidInputError
from selfmotion.exchange.schema import NESTED, SECTIONS, hints_of
from selfmotion.scene.obstacles import OBSTACLES

_OUTSIDE = "put the file into the folder, and name it from there"


class NamedFile(NamedTuple):
    """A file that a problem names.

    Attributes
    ----------
    field : str
        Dotted name of the field, such as ``path.position.file``.
    name : str
        As the problem writes it.
    """

    field: str
    name: str


def named_files(data: Any) -> list[NamedFile]:
    """Return every file that a problem's data names, in any section, however deep.

    Parameters
    ----------
    data : object
        Parsed data of a problem file. What is no problem names nothing: building it fails.
    """
    if not isinstance(data, dict):
        return []
    return [
        found for section in ("arm", "path", "planner") for found in _in_section(section, section, data.get(section))
    ] + list(_in_obstacles(data.get("obstacles")))


def _in_obstacles(data: Any) -> Iterator[NamedFile]:
    """Give the files that obstacles name, such as meshes."""
    for k, entry in enumerate(data if isinstance(data, list) else []):
        for kind in OBSTACLES.keys() & (entry if isinstance(entry, dict) else {}).keys():
            hints, fields = hints_of(OBSTACLES[kind]), entry[kind]
            for name, value in fields.items() if isinstance(fields, dict) else ():
                if name in hints:
                    yield from _in_field(f"obstacles.{k}.{kind}.{name}", hints[name], value)


def _in_section(field: str, section: str, data: Any) -> Iterator[NamedFile]:
    """Give the files that a section names; `section` says which registry its kinds are in."""
    if not isinstance(data, dict) or not isinstance(data.get("kind"), str):
        return
    part = SECTIONS[section].get(data["kind"])
    if part is None:
        return
    hints = hints_of(part)
    for name, value in data.items():
        if name in hints and _may_name(hints[name]):
            yield from _in_field(f"{field}.{name}", hints[name], value)


def _may_name(hint: Any) -> bool:
    """Return whether a type has a file name or a section somewhere: of long lists of numbers none is looked at."""
    return hint == FileName or hint in NESTED or any(map(_may_name, get_args(hint)))


def _in_field(field: str, hint: Any, value: Any) -> Iterator[NamedFile]:
    """Give the files in the value of a field, wherever its type has a file name or another section."""
    if hint == FileName:
        if isinstance(value, str):
            yield NamedFile(field, value)
        return
    if hint in NESTED:
        yield from _in_section(field, NESTED[hint], value)
        return
    inner = get_args(hint)
    if isinstance(value, list):
        for k, item in enumerate(value):
            for one in inner:
                yield from _in_field(f"{field}.{k}", one, item)
    else:
        for one in inner:
            yield from _in_field(field, one, value)


def check_inside(data: Any, folder: str | None) -> list[NamedFile]:
    """Refuse a problem that names a file outside of a folder, also by way of links.

    Parameters
    ----------
    data : object
        Parsed data of a problem file.
    folder : str or None
        Relative names are relative to it. None for no folder: then a problem may name no file.

    Returns
    -------
    list of NamedFile
        All that it names.

    Raises
    ------
    InvalidInputError
        Naming the field.
    """
    files = named_files(data)
    for field, name in files:
        if folder is None:
            raise InvalidInputError(field, "names a file, and there is no folder", "give what is in it instead", name)
        if not is_inside(name, folder):
            raise InvalidInputError(field, "names a file outside of the folder", _OUTSIDE, name)
    return files


def is_inside(name: str, folder: str) -> bool:
    """Return whether a file name, relative to a folder, leads to a place in it once all links are followed."""
    if not is_file_name(name):
        return False
    root, target = os.path.realpath(folder), os.path.realpath(os.path.join(folder, name))
    try:
        return os.path.commonpath([root, target]) == root
    except ValueError:  # on another drive
        return False

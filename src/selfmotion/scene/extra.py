"""The packages of the extra ``scene``, imported when they are first needed."""

from __future__ import annotations

from importlib import import_module
from typing import Any

from selfmotion.errors import MissingExtraError


def shapely() -> Any:
    """Return shapely, which reads and offsets polygons.

    Raises
    ------
    MissingExtraError
        If it is not installed.
    """
    return _needed("shapely", "polygons from files, and their offsets, need")


def coal() -> Any:
    """Return coal, which measures distances from meshes.

    Raises
    ------
    MissingExtraError
        If it is not installed.
    """
    return _needed("coal", "distances from meshes need")


def _needed(package: str, what: str) -> Any:
    try:
        return import_module(package)
    except ImportError:
        raise MissingExtraError("", f"{what} the package {package}", "pip install 'selfmotion[scene]'") from None

"""Checks of user input, each said once; all of them raise :class:`InvalidInputError`."""

from __future__ import annotations

import operator
import os
from collections.abc import Iterable
from difflib import get_close_matches
from typing import Any

import numpy as np

from selfmotion._types import FloatArray
from selfmotion.errors import InvalidInputError

LARGEST = 1e100
"""Magnitude beyond which squares overflow; no length or angle in use comes near it."""


def finite_array(field: str, value: Any, ndim: int, columns: int | None = None) -> FloatArray:
    """Return `value` as a new float array of `ndim` dimensions with `columns` in the last one."""
    shape = ", ".join(["k"] * (ndim - 1) + [str(columns) if columns else "k"]) if ndim else ""
    want = f"give finite numbers of shape ({shape})" if ndim else "give one finite number"
    if contains_text(value):
        raise InvalidInputError(field, "is not made of numbers", want, value)
    try:
        array = np.array(value, dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        raise InvalidInputError(field, "is not an array of numbers of equal length", want, value) from None
    if array.ndim != ndim or (columns is not None and array.shape[-1] != columns):
        raise InvalidInputError(field, f"has shape {array.shape}", want, value)
    if not np.isfinite(array).all():
        raise InvalidInputError(field, "contains NaN or infinity", want, value)
    if array.size and np.abs(array).max() > LARGEST:
        remedy = "give smaller numbers, or change their unit"
        raise InvalidInputError(field, f"exceeds {LARGEST:g} in magnitude", remedy, value)
    return array


def contains_text(value: Any) -> bool:
    """Return whether `value` holds strings or booleans, which numpy would quietly turn into numbers."""
    if isinstance(value, str | bytes | bool | np.bool_):
        return True
    if isinstance(value, np.ndarray):
        return value.dtype.kind not in "iuf"
    return isinstance(value, list | tuple) and any(contains_text(item) for item in value)


def number(field: str, value: Any, low: float = -LARGEST, high: float = LARGEST) -> float:
    """Return `value` as a finite float inside [low, high]."""
    result = float(finite_array(field, value, 0))
    if not low <= result <= high:
        raise InvalidInputError(field, f"is outside [{low:g}, {high:g}]", "give a number inside", value)
    return result


def positive(field: str, value: Any) -> float:
    """Return `value` as a finite float greater than zero."""
    result = number(field, value)
    if not result > 0:
        raise InvalidInputError(field, "must be greater than zero", "give a positive number", value)
    return result


def integer(field: str, value: Any, low: int, high: int) -> int:
    """Return `value` as an int inside [low, high]."""
    want = f"give a whole number from {low} to {high}"
    if isinstance(value, bool):
        raise InvalidInputError(field, "is not a whole number", want, value)
    try:
        result = operator.index(value)
    except TypeError:
        raise InvalidInputError(field, "is not a whole number", want, value) from None
    if not low <= result <= high:
        raise InvalidInputError(field, f"is outside [{low}, {high}]", want, value)
    return result


def choice(field: str, value: Any, options: Iterable[str]) -> str:
    """Return `value` if it is one of `options`; else say which are, the nearest first."""
    known = list(options)
    if isinstance(value, str) and value in known:
        return value
    near = get_close_matches(str(value), known, 1) if isinstance(value, str) else []
    hint = f"did you mean {near[0]!r}? " if near else ""
    raise InvalidInputError(field, "is not known", f"{hint}choose one of {', '.join(known)}", value)


def angles(field: str, value: Any, count: int | None = None) -> FloatArray:
    """Return `value` as angles of at most 1000 rad: beyond, their directions are lost in rounding."""
    array = finite_array(field, value, 1, count)
    if array.size and np.abs(array).max() > 1e3:
        raise InvalidInputError(field, "exceeds 1000 rad", "give angles in radians, modulo 2π", value)
    return array


def positive_pair(field: str, value: Any) -> FloatArray:
    """Return `value` as two finite numbers greater than zero."""
    pair = finite_array(field, value, 1, 2)
    if not (pair > 0).all():
        raise InvalidInputError(field, "must be greater than zero", "give two positive numbers", value)
    return pair


def sweep_angle(field: str, value: Any) -> float:
    """Return `value` as an angle that is not zero, of at most 1e4 rad."""
    result = number(field, value, -1e4, 1e4)
    if result == 0:
        raise InvalidInputError(field, "is zero: the path has no length", "give an angle in radians", value)
    return result


def is_file_name(name: str) -> bool:
    """Return whether a file may have this name: it holds no NUL, and nothing that no file system writes."""
    try:
        return b"\0" not in os.fsencode(name)
    except UnicodeEncodeError:  # half a character
        return False


def branch_index(branches: tuple[str, ...], branch: Any) -> int:
    """Return the index of an IK branch given by its name or index."""
    if isinstance(branch, str):
        return branches.index(choice("branch", branch, branches))
    return integer("branch", branch, 0, len(branches) - 1)


def read_only(array: FloatArray) -> FloatArray:
    """Return `array`, locked, so that a finished object cannot be changed by accident."""
    array.flags.writeable = False
    return array

"""Trajectory files: CSV with the header ``r,q1,…,qn,u1,…``."""

from __future__ import annotations

import csv
import io
import os
import re
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from selfmotion._types import FloatArray
from selfmotion.arms import RedundantArm
from selfmotion.errors import InvalidInputError
from selfmotion.exchange.files import read_text
from selfmotion.exchange.telling import is_plan_file
from selfmotion.plans import Plan

_JOINT = re.compile("q0*([1-9][0-9]*)")


class Trajectory(NamedTuple):
    """A sampled motion.

    Attributes
    ----------
    r : array, shape (k,)
    q : array, shape (k, n)
    """

    r: FloatArray
    q: FloatArray


def trajectory_csv(plan: Plan) -> bytes:
    """Return a plan's trajectory as CSV, 17 digits: rows at the sample grid and at every given waypoint."""
    r = plan.problem.rows
    return motion_csv(plan.problem.arm, r, plan(r), plan.u(r))


def motion_csv(arm: RedundantArm, r: FloatArray, q: FloatArray, u: FloatArray) -> bytes:
    """Return a sampled motion as CSV, 17 digits.

    Parameters
    ----------
    arm : RedundantArm
    r : array, shape (k,)
    q : array, shape (k, n)
    u : array, shape (k, n_u)
    """
    table = np.column_stack([r, q, u])
    header = ["r", *(f"q{j + 1}" for j in range(arm.n)), *(f"u{j + 1}" for j in range(arm.n_u))]
    return csv_bytes(header, table)


def csv_bytes(header: Sequence[str], table: FloatArray) -> bytes:
    """Return a table as CSV, 17 digits, which give every number back."""
    lines = [",".join(header), *(",".join(f"{value:.17g}" for value in row) for row in table)]
    return ("\n".join(lines) + "\n").encode()


def read_trajectory(file: str | os.PathLike[str], n: int) -> Trajectory:
    """Read a trajectory for an arm of n joints.

    Parameters
    ----------
    file : path-like
        CSV with columns r and q1…qn in any order; others are ignored.
    n : int

    Returns
    -------
    Trajectory

    Raises
    ------
    InvalidInputError
        Naming row and column: if columns are missing, a value is no finite number, r descends or leaves [0, 1], or
        there are fewer than two rows.
    """
    source = os.fspath(file)
    try:
        text = read_text(file)
        rows = [row for row in csv.reader(io.StringIO(text), strict=True) if row]
    except csv.Error as error:
        raise InvalidInputError("", f"is not CSV ({error})", "write comma-separated numbers", source=source) from None
    header = [name.strip() for name in rows[0]] if rows else []
    wanted = ["r", *(f"q{j + 1}" for j in range(n))]
    missing = [name for name in wanted if name not in header]
    if missing:
        if is_plan_file(text):
            remedy = "give its trajectory: plan --out writes trajectory.csv"
            raise InvalidInputError("", "is a stored plan, not a trajectory", remedy, source=source)
        raise InvalidInputError(
            "row 1", f"lacks the columns {', '.join(missing)}", f"start with {','.join(wanted)}", header, source
        )
    extra = [name for name in header if (of := _JOINT.fullmatch(name)) and f"q{of[1]}" not in wanted]
    if extra or len(set(header)) != len(header):
        raise InvalidInputError(
            "row 1", f"does not fit an arm of {n} joints", f"start with {','.join(wanted)}", header, source
        )
    if len(rows) < 3:
        raise InvalidInputError("", f"has {len(rows) - 1} data rows", "give at least two", source=source)
    columns = [header.index(name) for name in wanted]
    table = np.empty((len(rows) - 1, n + 1))
    for k, row in enumerate(rows[1:]):
        if len(row) != len(header):
            raise InvalidInputError(
                f"row {k + 1}", f"has {len(row)} columns", f"the header has {len(header)}", row, source
            )
        for j, column in enumerate(columns):
            table[k, j] = _number(row[column], k, wanted[j], source)
    r = table[:, 0]
    if r.min() < -1e-9 or r.max() > 1 + 1e-9:
        k = int(np.flatnonzero((r < -1e-9) | (r > 1 + 1e-9))[0])
        raise InvalidInputError(f"row {k + 1}, column r", "leaves [0, 1]", "scale r to the path", float(r[k]), source)
    if (np.diff(r) < 0).any():
        k = int(np.flatnonzero(np.diff(r) < 0)[0]) + 1
        raise InvalidInputError(
            f"row {k + 1}, column r", "is smaller than in the row before", "sort the rows", float(r[k]), source
        )
    return Trajectory(np.clip(r, 0.0, 1.0), table[:, 1:])


def _number(text: str, k: int, column: str, source: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = np.nan
    if not np.isfinite(value) or abs(value) > 1e9:
        reason = "is not a number of at most 1e9 in magnitude"
        raise InvalidInputError(f"row {k + 1}, column {column}", reason, "correct it", text, source)
    return value

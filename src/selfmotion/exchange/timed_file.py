"""Timed trajectories as files: CSV, JSON, ROS messages as YAML, NPZ and MCAP."""

from __future__ import annotations

import io
import json
import os
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from selfmotion._checks import choice
from selfmotion._types import FloatArray
from selfmotion._version import __version__
from selfmotion.errors import InvalidInputError
from selfmotion.exchange import ros_message
from selfmotion.exchange.files import as_text, read_bytes, write_file
from selfmotion.exchange.trajectory import csv_bytes
from selfmotion.timing import TimedTrajectory

FORMAT = "selfmotion_trajectory"
"""The key of JSON and NPZ files that holds the version of their form."""
VERSION = 1

_COLUMNS = ("q", "dq", "ddq")
_BAG, _ZIP = b"\x89MCAP", b"PK"  # how MCAP and NPZ begin
_REMEDY = "load a file that selfmotion wrote"


class TimedRows(NamedTuple):
    """What a trajectory file holds.

    Attributes
    ----------
    t : array, shape (k,)
        Times [s].
    r : array, shape (k,), or None
        Path parameters; None of messages of ROS, which have no place for them.
    q, dq, ddq : array, shape (k, n)
        Joint angles [rad], velocities [rad/s], accelerations [rad/s²]; with m for rad of a joint that slides.
    joint_names : tuple of str
        Empty of CSV, which numbers its columns.
    frame_id : str
        The frame that the arm stands in, empty if that is not said.
    """

    t: FloatArray
    r: FloatArray | None
    q: FloatArray
    dq: FloatArray
    ddq: FloatArray
    joint_names: tuple[str, ...]
    frame_id: str


def save_trajectory(
    trajectory: TimedTrajectory, file: str | os.PathLike[str], form: str | None = None, force: bool = False
) -> None:
    """Write a timed trajectory to a file, whole or not at all.

    Parameters
    ----------
    trajectory : TimedTrajectory
    file : path-like
    form : {"csv", "json", "ros", "npz", "mcap"}, optional
        Table; object; ``trajectory_msgs/JointTrajectory`` as YAML; numpy's arrays; the same message in a bag. By
        default what the file's suffix says, ``.csv``, ``.json``, ``.yaml``, ``.yml``, ``.npz`` or ``.mcap``, and a
        table where there is no suffix. One of these suffixes on a file of another form is refused.
    force : bool
        Whether a file that selfmotion did not write may be replaced.

    Raises
    ------
    InvalidInputError
        If the form is not known, or the suffix says none or another one; if the file cannot be written, or is
        somebody else's.
    MissingExtraError
        If a bag is asked for and rosbags is not installed: ``pip install 'selfmotion[ros]'``.
    """
    write_file(file, FORMS[form_of("form", form, file)](trajectory), force)


def form_of(field: str, form: str | None, file: str | os.PathLike[str]) -> str:
    """Return the form of a file that is to be written; refuse early what is not known or lacks its extra.

    A suffix says it where `form` is None. Other programs go by suffixes, so that none may belie what is in the file.
    """
    suffix = os.path.splitext(os.fspath(file))[1]
    said = SUFFIXES.get(suffix.lower())
    if form is None:
        if suffix and said is None:
            remedy = f"name it {', '.join(SUFFIXES)}, or give {field}: {', '.join(FORMS)}"
            raise InvalidInputError(field, f"is not given, and {suffix} says none", remedy)
        form = said or "csv"
    choice(field, form, FORMS)
    if said not in (None, form):
        raise InvalidInputError(field, f"is {form}, and a file {suffix} holds {said}", "leave it out, or name another")
    if form == "mcap":
        ros_message.rosbags()
    return form


def load_trajectory(file: str | os.PathLike[str]) -> TimedRows:
    """Read a timed trajectory in any of the forms that :func:`save_trajectory` writes, whatever the file's name.

    Parameters
    ----------
    file : path-like

    Returns
    -------
    TimedRows

    Raises
    ------
    InvalidInputError
        If the file is no such file, is damaged, or is of a later version.
    MissingExtraError
        If it is a bag and rosbags is not installed: ``pip install 'selfmotion[ros]'``.
    """
    source = os.fspath(file)
    data = read_bytes(file)
    try:
        if data.startswith(_BAG):
            return _rows(ros_message.from_mcap(data))
        if data.startswith(_ZIP):
            return _versioned(_from_npz(data))
        text = as_text(data, source)
        if text.lstrip()[:1] == "{":
            return _versioned(_from_json(text))
        return _rows(ros_message.from_yaml(text) if text.startswith("header:") else _from_csv(text))
    except InvalidInputError as error:
        raise error if error.source else error.inside(source=source) from None


def timed_csv(trajectory: TimedTrajectory) -> bytes:
    """Return t, r, q1…qn, dq1…dqn, ddq1…ddqn as CSV, 17 digits; ``selfmotion verify`` reads it too."""
    table = np.column_stack([trajectory.t, trajectory.r, trajectory.q, trajectory.dq, trajectory.ddq])
    return csv_bytes(_csv_header(trajectory.q.shape[1]), table)


def timed_json(trajectory: TimedTrajectory) -> bytes:
    """Return a versioned JSON object."""
    return (json.dumps({**_head(trajectory), **_arrays(trajectory, list)}, allow_nan=False) + "\n").encode()


def timed_npz(trajectory: TimedTrajectory) -> bytes:
    """Return numpy's NPZ, the arrays bit by bit."""
    head: dict[str, Any] = {name: np.array(value) for name, value in _head(trajectory).items()}
    buffer = io.BytesIO()
    np.savez(buffer, **head, **_arrays(trajectory, np.asarray))
    return buffer.getvalue()


FORMS: dict[str, Callable[[TimedTrajectory], bytes]] = {
    "csv": timed_csv,
    "json": timed_json,
    "ros": ros_message.to_yaml,
    "npz": timed_npz,
    "mcap": ros_message.to_mcap,
}
"""Every form of a timed trajectory's file."""
SUFFIXES = {".csv": "csv", ".json": "json", ".yaml": "ros", ".yml": "ros", ".npz": "npz", ".mcap": "mcap"}
"""The form that a file's suffix says."""


def _head(trajectory: TimedTrajectory) -> dict[str, Any]:
    return {
        FORMAT: VERSION,
        "version": __version__,
        "joint_names": list(trajectory.joint_names),
        "frame_id": trajectory.frame_id,
    }


def _arrays(trajectory: TimedTrajectory, made: Callable[[Any], Any]) -> dict[str, Any]:
    def plain(name: str) -> Any:
        array = getattr(trajectory, name)
        return array.tolist() if made is list else made(array)

    return {name: plain(name) for name in ("t", "r", *_COLUMNS)}


def _from_json(text: str) -> dict[str, Any]:
    try:
        data = json.loads(text)
    except (ValueError, RecursionError):
        raise InvalidInputError("", "is not JSON: it is incomplete or damaged", _REMEDY) from None
    if not isinstance(data, dict) or FORMAT not in data:
        raise InvalidInputError("", f"is not a trajectory file: it has no {FORMAT}", _REMEDY)
    return data


def _from_npz(data: bytes) -> dict[str, Any]:
    try:
        with np.load(io.BytesIO(data), allow_pickle=False) as archive:
            return {name: archive[name].tolist() for name in archive.files}
    except Exception as error:  # zipfile and numpy raise what they like on damaged files
        raise InvalidInputError("", f"is not a whole NPZ file ({error})", _REMEDY) from None


def _from_csv(text: str) -> dict[str, Any]:
    lines = [line.split(",") for line in text.splitlines()]
    n = (len(lines[0]) - 2) // len(_COLUMNS) if lines else 0
    if n < 1 or lines[0] != _csv_header(n):
        raise InvalidInputError("", "has no header t,r,q1,…,dq1,…,ddq1,…", _REMEDY)
    for k, line in enumerate(lines[1:]):
        if len(line) != len(lines[0]):
            reason = f"has {len(line)} columns: it is incomplete or damaged"
            raise InvalidInputError(f"row {k + 1}", reason, f"the header has {len(lines[0])}")
    columns = list(zip(*lines[1:], strict=True)) or [()] * len(lines[0])
    joints = {name: list(zip(*columns[2 + k * n : 2 + k * n + n], strict=True)) for k, name in enumerate(_COLUMNS)}
    return {"t": columns[0], "r": columns[1], **joints}


def _csv_header(n: int) -> list[str]:
    return ["t", "r", *(f"{name}{j}" for name in _COLUMNS for j in range(1, n + 1))]


def _versioned(data: dict[str, Any]) -> TimedRows:
    """Return the rows of a form that says its version."""
    version = data.get(FORMAT)
    if not isinstance(version, int) or isinstance(version, bool) or version < 1:
        raise InvalidInputError(FORMAT, "is not the number of a version", _REMEDY, version)
    if version > VERSION:
        reason = f"is {version}, and this version of selfmotion, {__version__}, reads up to {VERSION}"
        raise InvalidInputError(FORMAT, reason, f"use selfmotion {data.get('version')} or later")
    for name in ("joint_names", "r"):
        if name not in data:
            raise InvalidInputError(name, "is missing", _REMEDY)
    return _rows(data)


def _rows(data: dict[str, Any]) -> TimedRows:
    """Return the rows, the arrays checked against each other."""
    names, frame = data.get("joint_names"), data.get("frame_id", "")
    if names is not None and not (isinstance(names, list) and all(isinstance(name, str) for name in names)):
        raise InvalidInputError("joint_names", "are not names", _REMEDY)
    if not isinstance(frame, str):
        raise InvalidInputError("frame_id", "is not a name", _REMEDY)
    arrays = {name: _array(name, data.get(name)) for name in ("t", "r", *_COLUMNS) if name != "r" or "r" in data}
    k, n = arrays["t"].size, arrays["q"].shape[-1] if names is None else len(names)
    for name, array in arrays.items():
        shape = (k, n) if name in _COLUMNS else (k,)
        if array.shape != shape or k == 0:
            raise InvalidInputError(name, f"has shape {array.shape} for {k} times and {n} joints", _REMEDY)
    t, (q, dq, ddq) = arrays["t"], (arrays[name] for name in _COLUMNS)
    if not (np.diff(t) > 0.0).all():
        raise InvalidInputError("t", "does not increase from row to row", _REMEDY)
    return TimedRows(t, arrays.get("r"), q, dq, ddq, tuple(names or ()), frame)


def _array(name: str, value: Any) -> FloatArray:
    try:
        array = np.array(value, dtype=float, ndmin=1)
    except (TypeError, ValueError, OverflowError):
        raise InvalidInputError(name, "is missing or not made of numbers", _REMEDY) from None
    if not np.isfinite(array).all():
        raise InvalidInputError(name, "is missing or not finite", _REMEDY)
    return array

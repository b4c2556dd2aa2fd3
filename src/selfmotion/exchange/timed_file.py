"""Timed trajectories as files: CSV, JSON, ROS messages as YAML, NPZ and MCAP."""

from __future__ import annotations

import csv
import io
import json
import os
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from selfmotion._checks import choice
from selfmotion._types import FloatArray
from selfmotion._version import __version__
from selfmotion.errors import InvalidInputError, MissingExtraError
from selfmotion.exchange.files import read_text, write_file
from selfmotion.timing import TimedTrajectory

FORMAT = "selfmotion_trajectory"
"""The key of JSON and NPZ files that holds the version of their form."""
VERSION = 1
TOPIC = "/joint_trajectory"
"""The topic of a bag's one message."""

_COLUMNS = ("q", "dq", "ddq")
_MESSAGE = "trajectory_msgs/msg/JointTrajectory"
_REMEDY = "load a file that selfmotion wrote"
_NANO = 1_000_000_000


class TimedRows(NamedTuple):
    """What a trajectory file holds.

    Attributes
    ----------
    t, r : array, shape (k,)
        Times [s] and path parameters.
    q, dq, ddq : array, shape (k, n)
        Joint angles [rad], velocities [rad/s], accelerations [rad/s²]; with m for rad of a joint that slides.
    joint_names : tuple of str
    """

    t: FloatArray
    r: FloatArray
    q: FloatArray
    dq: FloatArray
    ddq: FloatArray
    joint_names: tuple[str, ...]


def save_trajectory(
    trajectory: TimedTrajectory, file: str | os.PathLike[str], form: str = "csv", force: bool = False
) -> None:
    """Write a timed trajectory to a file, whole or not at all.

    Parameters
    ----------
    trajectory : TimedTrajectory
    file : path-like
    form : {"csv", "json", "ros", "npz", "mcap"}
        Table; object; ``trajectory_msgs/JointTrajectory`` as YAML; numpy's arrays; the same message in a bag.
    force : bool
        Whether a file that selfmotion did not write may be replaced.

    Raises
    ------
    InvalidInputError
        If the form is not known, the file cannot be written, or is somebody else's.
    MissingExtraError
        If a bag is asked for and rosbags is not installed: ``pip install selfmotion[ros]``.
    """
    write_file(file, FORMS[choice("form", form, FORMS)](trajectory), force)


def load_trajectory(file: str | os.PathLike[str]) -> TimedRows:
    """Read a timed trajectory that was written as JSON or NPZ.

    Raises
    ------
    InvalidInputError
        If the file is no such file, is damaged, or is of a later version.
    """
    source = os.fspath(file)
    try:
        if source.endswith(".npz"):
            return _rows(_from_npz(source))
        return _rows(_from_json(read_text(file)))
    except InvalidInputError as error:
        raise error if error.source else error.inside(source=source) from None


def timed_csv(trajectory: TimedTrajectory) -> bytes:
    """Return t, r, q1…qn, dq1…dqn, ddq1…ddqn as CSV, 17 digits; ``selfmotion verify`` reads it too."""
    n = trajectory.q.shape[1]
    names = ["t", "r", *(f"{name}{j}" for name in _COLUMNS for j in range(1, n + 1))]
    table = np.column_stack([trajectory.t, trajectory.r, trajectory.q, trajectory.dq, trajectory.ddq])
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(names)
    writer.writerows([f"{value:.17g}" for value in row] for row in table)
    return text.getvalue().encode()


def timed_json(trajectory: TimedTrajectory) -> bytes:
    """Return a versioned JSON object."""
    return (json.dumps({**_head(trajectory), **_arrays(trajectory, list)}, allow_nan=False) + "\n").encode()


def timed_npz(trajectory: TimedTrajectory) -> bytes:
    """Return numpy's NPZ, the arrays bit by bit."""
    head: dict[str, Any] = {name: np.array(value) for name, value in _head(trajectory).items()}
    buffer = io.BytesIO()
    np.savez(buffer, **head, **_arrays(trajectory, np.asarray))
    return buffer.getvalue()


def timed_yaml(trajectory: TimedTrajectory) -> bytes:
    """Return a ``trajectory_msgs/JointTrajectory`` message as YAML."""
    lines = ["header:", "  stamp: {sec: 0, nanosec: 0}", "  frame_id: ''", "joint_names:"]
    lines += [f"- {json.dumps(name)}" for name in trajectory.joint_names]
    lines.append("points:")
    for k, t in enumerate(trajectory.t):
        sec, nanosec = _clock(float(t))
        lines.append(f"- positions: {_listed(trajectory.q[k])}")
        lines.append(f"  velocities: {_listed(trajectory.dq[k])}")
        lines.append(f"  accelerations: {_listed(trajectory.ddq[k])}")
        lines.append("  effort: []")
        lines.append(f"  time_from_start: {{sec: {sec}, nanosec: {nanosec}}}")
    return ("\n".join(lines) + "\n").encode()


def timed_mcap(trajectory: TimedTrajectory) -> bytes:
    """Return a bag of ROS 2 in the MCAP format that holds one ``trajectory_msgs/JointTrajectory``.

    Raises
    ------
    MissingExtraError
        If rosbags is not installed.
    """
    try:
        from rosbags.rosbag2 import StoragePlugin, Writer
        from rosbags.typesys import Stores, get_typestore
    except ImportError:
        raise MissingExtraError("format", "needs the package rosbags", "pip install selfmotion[ros]", "mcap") from None

    store = get_typestore(Stores.ROS2_HUMBLE)
    made = store.types
    duration = made["builtin_interfaces/msg/Duration"]
    points = [
        made["trajectory_msgs/msg/JointTrajectoryPoint"](q, dq, ddq, np.empty(0), duration(*_clock(float(t))))
        for t, q, dq, ddq in zip(trajectory.t, trajectory.q, trajectory.dq, trajectory.ddq, strict=True)
    ]
    header = made["std_msgs/msg/Header"](made["builtin_interfaces/msg/Time"](0, 0), "")
    message = made[_MESSAGE](header, list(trajectory.joint_names), points)
    with tempfile.TemporaryDirectory() as folder:
        bag = Path(folder) / "bag"
        with Writer(bag, version=9, storage_plugin=StoragePlugin.MCAP) as writer:
            connection = writer.add_connection(TOPIC, _MESSAGE, typestore=store)
            writer.write(connection, 0, store.serialize_cdr(message, _MESSAGE))
        return next(bag.glob("*.mcap")).read_bytes()


FORMS: dict[str, Callable[[TimedTrajectory], bytes]] = {
    "csv": timed_csv,
    "json": timed_json,
    "ros": timed_yaml,
    "npz": timed_npz,
    "mcap": timed_mcap,
}
"""Every form of a timed trajectory's file."""


def _head(trajectory: TimedTrajectory) -> dict[str, Any]:
    return {FORMAT: VERSION, "version": __version__, "joint_names": list(trajectory.joint_names)}


def _arrays(trajectory: TimedTrajectory, made: Callable[[Any], Any]) -> dict[str, Any]:
    def plain(name: str) -> Any:
        array = getattr(trajectory, name)
        return array.tolist() if made is list else made(array)

    return {name: plain(name) for name in ("t", "r", *_COLUMNS)}


def _clock(t: float) -> tuple[int, int]:
    """Return a time as whole seconds and nanoseconds."""
    return divmod(round(t * _NANO), _NANO)


def _listed(values: FloatArray) -> str:
    """Return numbers as YAML of any version reads them: 1e-05 is text in YAML 1.1, 1.0e-05 is not."""
    texts = (repr(value) for value in values.tolist())
    return f"[{', '.join(t if '.' in t or 'e' not in t else t.replace('e', '.0e') for t in texts)}]"


def _from_json(text: str) -> dict[str, Any]:
    try:
        data = json.loads(text)
    except (ValueError, RecursionError):
        raise InvalidInputError("", "is not JSON: it is incomplete or damaged", _REMEDY) from None
    if not isinstance(data, dict) or FORMAT not in data:
        raise InvalidInputError("", f"is not a trajectory file: it has no {FORMAT}", _REMEDY)
    return data


def _from_npz(source: str) -> dict[str, Any]:
    try:
        # Opened here: numpy leaves a file open that it cannot read.
        with open(source, "rb") as file, np.load(file, allow_pickle=False) as archive:
            return {name: archive[name].tolist() for name in archive.files}
    except FileNotFoundError:
        raise InvalidInputError("", "does not exist", "check the name") from None
    except Exception as error:  # zipfile and numpy raise what they like on damaged files
        raise InvalidInputError("", f"is not a whole NPZ file ({error})", _REMEDY) from None


def _rows(data: dict[str, Any]) -> TimedRows:
    version = data.get(FORMAT)
    if not isinstance(version, int) or isinstance(version, bool) or version < 1:
        raise InvalidInputError(FORMAT, "is not the number of a version", _REMEDY, version)
    if version > VERSION:
        reason = f"is {version}, and this version of selfmotion, {__version__}, reads up to {VERSION}"
        raise InvalidInputError(FORMAT, reason, f"use selfmotion {data.get('version')} or later")
    names = data.get("joint_names")
    if not isinstance(names, list) or not all(isinstance(name, str) for name in names):
        raise InvalidInputError("joint_names", "are not names", _REMEDY)
    arrays: list[FloatArray] = []
    for name in ("t", "r", *_COLUMNS):
        try:
            array = np.array(data[name], dtype=float)
        except (KeyError, TypeError, ValueError):
            raise InvalidInputError(name, "is missing or not made of numbers", _REMEDY) from None
        shape = arrays[0].shape[:1] if arrays else array.shape
        if array.ndim != (2 if name in _COLUMNS else 1) or array.shape != (*shape, len(names))[: array.ndim]:
            raise InvalidInputError(name, f"has shape {array.shape} for {len(names)} joints", _REMEDY)
        if not np.isfinite(array).all():
            raise InvalidInputError(name, "is not finite", _REMEDY)
        arrays.append(array)
    t, r, q, dq, ddq = arrays
    return TimedRows(t, r, q, dq, ddq, tuple(names))

"""Timed trajectories as ``trajectory_msgs/JointTrajectory`` of ROS 2: as YAML, and as one message in an MCAP bag."""

from __future__ import annotations

import importlib
import json
import tempfile
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from selfmotion._types import FloatArray
from selfmotion.errors import InvalidInputError, MissingExtraError
from selfmotion.exchange.yaml_text import parse_yaml
from selfmotion.timing import TimedTrajectory

TOPIC = "/joint_trajectory"
"""The topic of a bag's one message."""
MESSAGE = "trajectory_msgs/msg/JointTrajectory"

_FIELDS = {"q": "positions", "dq": "velocities", "ddq": "accelerations"}
_REMEDY = "load a file that selfmotion wrote"
_NANO = 1_000_000_000
_LATEST = 2**32 - 1


def to_yaml(trajectory: TimedTrajectory) -> bytes:
    """Return a trajectory as YAML.

    Raises
    ------
    InvalidInputError
        If rows are nearer than the nanosecond that ROS counts in.
    """
    lines = ["header:", "  stamp: {sec: 0, nanosec: 0}", f"  frame_id: {json.dumps(trajectory.frame_id)}"]
    lines += ["joint_names:", *(f"- {json.dumps(name)}" for name in trajectory.joint_names), "points:"]
    for k, (sec, nanosec) in enumerate(_clocks(trajectory.t)):
        lead = "-"
        for name, field in _FIELDS.items():
            lines.append(f"{lead} {field}: {listed(getattr(trajectory, name)[k])}")
            lead = " "
        lines.append("  effort: []")
        lines.append(f"  time_from_start: {{sec: {sec}, nanosec: {nanosec}}}")
    return ("\n".join(lines) + "\n").encode()


def from_yaml(text: str) -> dict[str, Any]:
    """Return what :func:`to_yaml` wrote, without the path parameters, which the message has no place for.

    Raises
    ------
    InvalidInputError
        If it is no such message.
    """
    try:
        message = parse_yaml(text, "")
        points = message["points"]
        found: dict[str, Any] = {name: [point[field] for point in points] for name, field in _FIELDS.items()}
        clocks = [(point["time_from_start"]["sec"], point["time_from_start"]["nanosec"]) for point in points]
        found["t"] = [_seconds(*clock) for clock in clocks]
        return {**found, "joint_names": message["joint_names"], "frame_id": message["header"]["frame_id"]}
    except InvalidInputError as error:
        raise InvalidInputError(error.field, error.reason, error.remedy, error.value) from None
    except (KeyError, TypeError, IndexError):
        raise InvalidInputError("", f"is not a whole {MESSAGE} as YAML", _REMEDY) from None


def to_mcap(trajectory: TimedTrajectory) -> bytes:
    """Return a bag with one message.

    Raises
    ------
    MissingExtraError
        If rosbags is not installed.
    InvalidInputError
        As for :func:`to_yaml`.
    """
    bags, store = rosbags()
    made = store.types
    duration, point = (made[name] for name in ("builtin_interfaces/msg/Duration", f"{MESSAGE}Point"))
    rows = zip(_clocks(trajectory.t), trajectory.q, trajectory.dq, trajectory.ddq, strict=True)
    points = [point(q, dq, ddq, np.empty(0), duration(*clock)) for clock, q, dq, ddq in rows]
    header = made["std_msgs/msg/Header"](made["builtin_interfaces/msg/Time"](0, 0), trajectory.frame_id)
    message = made[MESSAGE](header, list(trajectory.joint_names), points)
    with tempfile.TemporaryDirectory() as folder:
        bag = Path(folder) / "bag"
        with bags.Writer(bag, version=9, storage_plugin=bags.StoragePlugin.MCAP) as writer:
            connection = writer.add_connection(TOPIC, MESSAGE, typestore=store)
            writer.write(connection, 0, store.serialize_cdr(message, MESSAGE))
        return next(bag.glob("*.mcap")).read_bytes()


def from_mcap(data: bytes) -> dict[str, Any]:
    """Return what :func:`to_mcap` wrote, without the path parameters, which the message has no place for.

    Raises
    ------
    MissingExtraError
        If rosbags is not installed.
    InvalidInputError
        If the bag is damaged, or holds another number of such messages than one.
    """
    bags, store = rosbags()
    try:
        with tempfile.TemporaryDirectory() as folder:
            bag = Path(folder) / "bag.mcap"  # the reader goes by the name
            bag.write_bytes(data)
            with bags.Reader(bag) as reader:
                connections = [connection for connection in reader.connections if connection.msgtype == MESSAGE]
                messages = [raw for _, _, raw in reader.messages(connections)] if connections else []
            message = store.deserialize_cdr(messages[0], MESSAGE) if len(messages) == 1 else None
    except Exception as error:  # rosbags and what it decompresses with raise what they like on damaged files
        reason = " ".join(str(error).split())[:120]
        raise InvalidInputError("", f"is not a whole bag ({reason})", _REMEDY) from None
    if message is None:
        raise InvalidInputError("", f"holds {len(messages)} messages {MESSAGE}, not one", _REMEDY)
    found: dict[str, Any] = {
        name: [getattr(point, field) for point in message.points] for name, field in _FIELDS.items()
    }
    clocks = [(point.time_from_start.sec, point.time_from_start.nanosec) for point in message.points]
    found["t"] = [_seconds(*clock) for clock in clocks]
    return {**found, "joint_names": message.joint_names, "frame_id": message.header.frame_id}


def rosbags() -> tuple[Any, Any]:
    """Return the module ``rosbags.rosbag2`` and the types of ROS 2's messages.

    Raises
    ------
    MissingExtraError
        If rosbags is not installed.
    """
    try:
        bags, types = (importlib.import_module(f"rosbags.{part}") for part in ("rosbag2", "typesys"))
    except ImportError:
        raise MissingExtraError(
            "format", "needs the package rosbags", "pip install 'selfmotion[ros]'", "mcap"
        ) from None
    return bags, types.get_typestore(types.Stores.ROS2_HUMBLE)


def listed(values: FloatArray) -> str:
    """Return numbers as YAML of any version reads them: 1e-05 is text in YAML 1.1, 1.0e-05 is not."""
    texts = (repr(value) for value in values.tolist())
    return f"[{', '.join(t if '.' in t or 'e' not in t else t.replace('e', '.0e') for t in texts)}]"


def _clocks(t: FloatArray) -> list[tuple[int, int]]:
    """Return times as whole seconds and nanoseconds; controllers refuse points of the same time."""
    whole = [round(time * _NANO) for time in t.tolist()]
    if any(after <= before for before, after in pairwise(whole)):
        raise InvalidInputError("rate", "puts rows nearer together than the nanosecond of ROS", "give a lower one")
    return [divmod(time, _NANO) for time in whole]


def _seconds(sec: Any, nanosec: Any) -> float:
    for given in (sec, nanosec):  # of text a billion times as much would be made
        if isinstance(given, bool) or not isinstance(given, int) or abs(given) > _LATEST:
            raise InvalidInputError("time_from_start", "is not made of whole numbers of 32 bits", _REMEDY, given)
    return (sec * _NANO + nanosec) / _NANO

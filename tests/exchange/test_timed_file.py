"""Timed trajectories as files: what is read back is what was written."""

import csv
import io
import json
import os
import sys

import numpy as np
import pytest
import yaml

import selfmotion as sm
from selfmotion.exchange import read_trajectory, ros_message, timed_file
from selfmotion.exchange.timed_file import FORMS

pytest.importorskip("toppra")
ARRAYS = ("t", "r", "q", "dq", "ddq")


@pytest.fixture(scope="module")
def plan():
    arm = sm.PlanarArm([0.5, 0.4, 0.3])
    problem = sm.Problem(arm, sm.Bezier([[0.7, -0.3], [0.9, 0.2], [0.4, 0.5], [0.2, 0.7]]), samples=100)
    return sm.plan(problem, sm.Refine(starts=1, time_limit=10))


@pytest.fixture(scope="module")
def timed(plan):
    return sm.time_law(plan, 5.0, 1.0, rate=40.0)


def test_csv_has_17_digits_and_is_a_trajectory_that_verify_reads(timed, tmp_path):
    file = tmp_path / "t.csv"
    sm.save_trajectory(timed, file)
    header, *rows = csv.reader(io.StringIO(file.read_text()))
    assert header == ["t", "r", *(f"{name}{j}" for name in ("q", "dq", "ddq") for j in (1, 2, 3))]
    table = np.array(rows, dtype=float)
    assert np.array_equal(table, np.column_stack([getattr(timed, name) for name in ARRAYS]))
    assert np.array_equal(read_trajectory(file, 3).q, timed.q)


@pytest.mark.parametrize("form", FORMS)
def test_every_form_comes_back_bit_by_bit_whatever_the_file_is_called(timed, form, tmp_path):
    if form == "mcap":
        pytest.importorskip("rosbags")
    file = tmp_path / "Brücke 1, 経路.dat"
    sm.save_trajectory(timed, file, form)
    again = sm.load_trajectory(file)
    of_ros = form in ("ros", "mcap")  # without r, and to the nanosecond of its clocks
    for name in ("q", "dq", "ddq") if of_ros else ARRAYS:
        assert getattr(again, name).tobytes() == getattr(timed, name).tobytes()
    if of_ros:
        assert again.r is None
        assert np.abs(again.t - timed.t).max() <= 0.5e-9 * (1 + 1e-6)
    assert again.joint_names == (() if form == "csv" else timed.joint_names)
    assert again.frame_id == timed.frame_id == ""
    before = file.read_bytes()
    if form == "mcap":  # bags say when they were written
        return
    sm.save_trajectory(timed, file, form)
    assert file.read_bytes() == before


def test_a_ros_message_as_yaml_is_read_by_any_yaml(timed, tmp_path):
    sm.save_trajectory(timed, tmp_path / "t.yaml", "ros")
    message = yaml.safe_load((tmp_path / "t.yaml").read_text())
    assert list(message) == ["header", "joint_names", "points"]
    assert message["joint_names"] == list(timed.joint_names)
    for name, field in (("q", "positions"), ("dq", "velocities"), ("ddq", "accelerations")):
        assert np.array_equal([point[field] for point in message["points"]], getattr(timed, name))
    clock = [p["time_from_start"]["sec"] + 1e-9 * p["time_from_start"]["nanosec"] for p in message["points"]]
    assert clock == pytest.approx(timed.t, abs=1e-9)
    assert ros_message.listed(np.array([1e-5, 1.5e-7, -2.0, 1e22])) == "[1.0e-05, 1.5e-07, -2.0, 1.0e+22]"
    assert yaml.safe_load(ros_message.listed(np.array([1e-5, 1e22]))) == [1e-5, 1e22]


def test_a_bag_is_read_by_rosbags_own_reader(timed, tmp_path):
    pytest.importorskip("rosbags")
    from rosbags.rosbag2 import Reader
    from rosbags.typesys import Stores, get_typestore

    sm.save_trajectory(timed, tmp_path / "t.mcap", "mcap")
    store = get_typestore(Stores.ROS2_HUMBLE)
    with Reader(tmp_path / "t.mcap") as reader:
        ((connection, _, raw),) = reader.messages()
        assert connection.topic == ros_message.TOPIC
        message = store.deserialize_cdr(raw, connection.msgtype)
    assert message.joint_names == list(timed.joint_names)
    for name, field in (("q", "positions"), ("dq", "velocities"), ("ddq", "accelerations")):
        read = np.array([getattr(point, field) for point in message.points])
        assert read.tobytes() == getattr(timed, name).tobytes()
    clock = [p.time_from_start.sec + 1e-9 * p.time_from_start.nanosec for p in message.points]
    assert clock == pytest.approx(timed.t, abs=1e-9)


@pytest.mark.parametrize("form", FORMS)
def test_somebody_s_file_is_kept_and_no_half_file_is_left(timed, form, tmp_path):
    if form == "mcap":
        pytest.importorskip("rosbags")
    file = tmp_path / "out"
    file.write_text("mine")
    with pytest.raises(sm.InvalidInputError, match="--force"):
        sm.save_trajectory(timed, file, form)
    assert file.read_text() == "mine"
    sm.save_trajectory(timed, file, form, force=True)
    assert not list(tmp_path.glob("*.tmp"))
    with pytest.raises(sm.InvalidInputError, match="form: is not known"):
        sm.save_trajectory(timed, file, "xls")


def test_files_that_are_none_are_refused(timed, tmp_path):
    sm.save_trajectory(timed, tmp_path / "t.json", "json")
    sm.save_trajectory(timed, tmp_path / "t.npz", "npz")
    data = json.loads((tmp_path / "t.json").read_text())
    cases = {
        "": "has no header t,r,q1",
        "{": "is not JSON",
        "t,r,q1,dq1,ddq1": "has shape",
        "t,r,q1,dq1,ddq1\n0,0,0,0": "row 1: has 4 columns",
        "t,r,q1,dq1,ddq1\n0,0,0,0,x": "ddq: is missing or not made of numbers",
        "header: {frame_id: ''}\npoints: 3": "is not a whole trajectory_msgs/msg/JointTrajectory",
        "header: [": "is not plain YAML",
        "{}": "is not a trajectory file",
        json.dumps({**data, timed_file.FORMAT: 2}): "reads up to 1",
        json.dumps({**data, timed_file.FORMAT: "x"}): "not the number of a version",
        json.dumps({**data, "joint_names": [1]}): "joint_names: are not names",
        json.dumps({**data, "q": "x"}): "q: is missing or not made of numbers",
        json.dumps({**data, "dq": [[1.0]]}): "dq: has shape",
        json.dumps({**data, "r": [float("nan")] * len(data["r"])}): "r: is missing or not finite",
        json.dumps({**data, "t": data["t"][::-1]}): "t: does not increase",
        json.dumps({**data, "frame_id": 3}): "frame_id: is not a name",
        json.dumps({key: value for key, value in data.items() if key != "r"}): "r: is missing",
        json.dumps({**data, **{name: [] for name in ARRAYS}}): "has shape",
        json.dumps({key: value for key, value in data.items() if key != "ddq"}): "ddq: is missing",
    }
    for text, says in cases.items():
        (tmp_path / "bad.json").write_text(text)
        with pytest.raises(sm.InvalidInputError, match=says):
            sm.load_trajectory(tmp_path / "bad.json")
    (tmp_path / "bad.npz").write_bytes((tmp_path / "t.npz").read_bytes()[:300])
    (tmp_path / "bad.bin").write_bytes(b"\xff\xfe\x00")
    for name, says in (("bad.npz", "is not a whole NPZ"), ("no.npz", "does not exist"), ("bad.bin", "not a UTF-8")):
        with pytest.raises(sm.InvalidInputError, match=says):
            sm.load_trajectory(tmp_path / name)


def test_bags_that_are_damaged_or_hold_other_messages_are_refused(timed, tmp_path):
    pytest.importorskip("rosbags")
    sm.save_trajectory(timed, tmp_path / "t.mcap", "mcap")
    whole = (tmp_path / "t.mcap").read_bytes()
    for data, says in (
        (whole[: len(whole) // 2], "is not a whole bag"),
        (whole[:8], "is not a whole bag"),
        (whole.replace(b"trajectory_msgs/msg/JointTrajectory", b"trajectory_msgs/msg/TointTrajectory"), "holds 0"),
    ):
        (tmp_path / "bad.mcap").write_bytes(data)
        with pytest.raises(sm.InvalidInputError, match=says):
            sm.load_trajectory(tmp_path / "bad.mcap")


def test_rows_that_ros_s_clocks_cannot_tell_apart_are_refused_and_none_is_made_by_the_end(plan, timed, tmp_path):
    for steps in (40.0, 40.0 + 1e-8, 40.0 + 1e-4, 40.5):  # the last row is where the motion ends
        again = timed.at_rate(steps / timed.duration)
        assert len(again.t) == np.ceil(steps - 1e-3) + 1
        assert np.diff(again.t).min() > 1e-4 / again.rate
        assert again.t[-1] == timed.duration
    near = timed.at_rate(40.0)
    near.t = near.t * 1e-9
    for form in ("ros", "mcap"):
        with pytest.raises(sm.InvalidInputError, match="rate: puts rows nearer together"):
            sm.save_trajectory(near, tmp_path / "t", form)
    assert not list(tmp_path.iterdir())


def test_without_rosbags_it_says_what_to_install(timed, tmp_path, monkeypatch):
    for name in [name for name in sys.modules if name.split(".")[0] == "rosbags"]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "rosbags", None)
    with pytest.raises(sm.InvalidInputError, match=r"pip install 'selfmotion\[ros\]'"):
        sm.save_trajectory(timed, tmp_path / "t.mcap", "mcap")
    assert not os.listdir(tmp_path)

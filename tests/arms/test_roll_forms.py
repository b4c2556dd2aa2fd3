"""Six-axis arms are recognised whatever frames a file chose, and what is recognised is the chain."""

from importlib.resources import files

import numpy as np
import pytest
import test_ur_kernels
import test_wrist_kernels
from roll_checks import about, along, halves, wrapped

from selfmotion.arms import _ur_kernels, _wrist_kernels
from selfmotion.arms.chain import Chain
from selfmotion.arms.roll_forms import ROLL_FAMILIES, UR, WRIST, roll_form_of
from selfmotion.arms.urdf import read_chain

DATA = files("selfmotion.arms") / "data"
KERNELS = {WRIST: _wrist_kernels, UR: _ur_kernels}
FORWARD = {WRIST: test_wrist_kernels.forward, UR: test_ur_kernels.forward}


def shipped(name):
    return read_chain((DATA / f"{name}.urdf").read_text())


def difference(chain, form, q):
    pose = form.base @ FORWARD[form.family.number](form.geometry[:-12], q + form.shift) @ form.tool
    return abs(pose - chain.forward(q)).max()


@pytest.mark.parametrize(
    ("name", "family", "lengths"),
    [
        ("irb120", "spherical wrist", test_wrist_kernels.IRB120),
        ("kr6r900", "spherical wrist", test_wrist_kernels.KR6),
        ("ur5e", "ur", test_ur_kernels.UR5E),
        ("ur10e", "ur", test_ur_kernels.UR10E),
    ],
)
def test_shipped_arms_are_recognised(name, family, lengths):
    rng, chain = np.random.default_rng(0), shipped(name)
    form = roll_form_of(chain)
    assert form.family.name == family
    assert form.geometry[:-12] == pytest.approx(lengths, abs=1e-15)
    assert (form.geometry[:-12][lengths == 0.0] == 0.0).all()
    assert abs(form.shift).max() <= np.pi
    for _ in range(100):
        assert difference(chain, form, rng.uniform(-np.pi, np.pi, 6)) < 1e-14
    kernels = KERNELS[form.family.number]
    assert len(form.geometry) == kernels.LENGTHS + 12
    found, ok = np.empty((8, 6)), np.empty(8, bool)
    for _ in range(100):
        q, u = rng.uniform(-np.pi, np.pi, 6), rng.uniform(-np.pi, np.pi)
        pose = chain.forward(q) @ about(2, -u)
        root = np.linalg.inv(form.base) @ pose
        kernels.solve(form.geometry, *halves(root), u, found, ok)
        for b in np.flatnonzero(ok):
            assert abs(chain.forward(found[b] - form.shift) - pose @ about(2, u)).max() < 1e-13
        branch = kernels.branch_of(form.geometry, q + form.shift)
        assert abs(wrapped(found[branch] - form.shift - q)).max() < 1e-9
        assert abs(wrapped(kernels.roll(form.geometry, halves(root)[0], q + form.shift) - u)) < 1e-13


@pytest.mark.parametrize("name", ["irb120", "kr6r900", "ur5e", "ur10e"])
def test_frames_may_lie_anywhere_on_their_axes(name):
    """Joint frames turned about and moved along their own axes: another file of the same arm."""
    rng, chain = np.random.default_rng(1), shipped(name)
    for _ in range(50):
        offsets = chain.offsets.copy()
        for j in range(6):
            move = about(2, rng.uniform(-3, 3)) @ along(0, 0, rng.uniform(-0.5, 0.5))
            offsets[j], offsets[j + 1] = offsets[j] @ move, np.linalg.inv(move) @ offsets[j + 1]
        offsets[6] = offsets[6] @ about(0, rng.uniform(-3, 3)) @ along(*rng.uniform(-0.3, 0.3, 3))
        other = Chain(chain.names, offsets)
        form = roll_form_of(other)
        assert form.family == roll_form_of(chain).family
        assert abs(form.geometry[:-12]) == pytest.approx(abs(roll_form_of(chain).geometry[:-12]), abs=1e-12)
        for _ in range(5):
            assert difference(other, form, rng.uniform(-np.pi, np.pi, 6)) < 1e-13


@pytest.mark.parametrize("family", ROLL_FAMILIES)
def test_random_arms_of_a_family_are_recognised(family):
    rng = np.random.default_rng(2)
    tests = test_wrist_kernels if family.number == WRIST else test_ur_kernels
    for _ in range(50):
        lengths = tests.random_lengths(rng)
        offsets = [along(*rng.uniform(-1, 1, 3)) @ about(1, rng.uniform(-3, 3))]
        if family.number == WRIST:
            a1, a2, b, c2, c3 = lengths
            y, back = about(0, -np.pi / 2), about(0, np.pi / 2)
            offsets += [along(a1, 0, 0) @ y, back @ along(0, 0, c2) @ y, back @ along(a2, b, c3), y, back]
        else:
            a2, a3, d4, d5 = lengths
            quarter = about(0, np.pi / 2)
            offsets += [quarter, along(a2, 0, 0.7 * d4), along(a3, 0, 0.3 * d4)]
            offsets += [quarter, along(0, 0, d5) @ quarter.T]
        offsets.append(along(*rng.uniform(-1, 1, 3)))
        chain = Chain(list("abcdef"), offsets)
        form = roll_form_of(chain)
        assert form.family == family
        assert len(family.branches) == len(set(family.branches)) == 8
        assert difference(chain, form, rng.uniform(-np.pi, np.pi, 6)) < 1e-13


def test_what_is_not_of_a_family_is_left_alone():
    for name in ("panda", "iiwa7", "iiwa14", "fr3"):
        assert roll_form_of(shipped(name)) is None
    chain = shipped("irb120")
    for joint, move in (
        (1, about(0, 1e-3)),  # axes 1 and 2 not perpendicular
        (2, about(1, np.pi)),  # axis 3 against axis 2
        (5, along(0, 0, 0.05)),  # no spherical wrist
        (5, about(0, 0.1)),
    ):
        offsets = chain.offsets.copy()
        offsets[joint] = offsets[joint] @ move
        assert roll_form_of(Chain(chain.names, offsets)) is None or joint == 5
    chain = shipped("ur5e")
    for joint, move in ((1, along(0.05, 0, 0)), (5, along(0.05, 0, 0)), (4, about(0, 0.01))):
        offsets = chain.offsets.copy()
        offsets[joint] = move @ offsets[joint]
        assert roll_form_of(Chain(chain.names, offsets)) is None
    assert roll_form_of(Chain(chain.names, chain.offsets, prismatic=np.arange(6) == 2)) is None

"""The arm's picture: a path drawn freehand, links and limits dragged."""

from itertools import pairwise

import numpy as np
import pytest
from browser import as_shown, by_sinusoid
from test_page_domain import assert_is_domain

import selfmotion as sm
from selfmotion.exchange import problem_from


def assert_domain_shown(tab, data):
    problem = problem_from(data).problem
    assert_is_domain(tab.drawn("path.region"), sm.angle_domain(problem.arm, problem.path), 0, 8e-3)


def test_a_path_drawn_freehand_goes_where_the_mouse_was(tab, seed):
    tab.open(seed, frequency=[1])
    scale = tab.arm_scale()
    tab.page.click("#arm-modes [data-mode=draw]")
    box = tab.page.locator("#arm-view svg").bounding_box()
    corners = [scale.pixel(*at) for at in ([45, -15], [62, 0], [60, 25], [48, 30])]
    assert all(box["x"] < x < box["x"] + box["width"] and box["y"] < y < box["y"] + box["height"] for x, y in corners)
    mouse = [corners[0]]
    for a, b in pairwise(corners):
        mouse += [tuple(np.array(a) + (np.array(b) - a) * k / 8) for k in range(1, 9)]
    tab.drag(corners[0], *corners[1:])
    path = tab.problem["path"]
    assert path["kind"] == "waypoints"
    points = np.array(path["points"])
    was = np.array([scale.value(*at) for at in mouse])
    away = np.linalg.norm(points[:, None] - was[None], axis=-1)
    assert away.min(axis=1).max() < 0.02
    assert np.linalg.norm(points[[0, -1]] - was[[0, -1]], axis=-1).max() < 0.02
    for corner in corners:
        assert np.linalg.norm(points - scale.value(*corner), axis=-1).min() < 0.02
    assert 4 <= len(points) < 15
    data = {**seed, "path": path}
    assert tab.problem == data
    assert_domain_shown(tab, data)
    assert tab.page.locator("#arm-modes [data-mode=path]").get_attribute("aria-pressed") == "true"
    assert tab.page.locator("#arm-view .handle").count() == len(points)
    # The path that is drawn is the library's spline through these points.
    drawn = tab.value("selfmotion.live.scene.path")
    assert np.allclose(drawn["x"], problem_from(data).problem.path(drawn["r"]), rtol=0, atol=1e-9)


def test_a_link_is_dragged_longer(tab, seed):
    tab.open(seed, frequency=[1])
    tab.page.click("#arm-modes [data-mode=arm]")
    points = tab.motion["points"][0]
    along = (points[1] - points[0]) / 30
    scale = tab.arm_scale()
    start = tab.handle("link-0")
    wanted = np.array(scale.value(*start)) + 3 * along
    end = scale.pixel(*wanted)
    tab.drag(start, end)
    arm = tab.problem["arm"]
    assert arm["links"][0] == pytest.approx(36, abs=0.05)
    assert arm["links"][1:] == [30, 20]
    data = {**seed, "arm": arm}
    assert tab.problem == data
    assert_domain_shown(tab, data)
    assert tab.motion["cost"] == pytest.approx(by_sinusoid(data, [1.0]).cost, rel=1e-12)
    assert tab.figures["cost"] == as_shown(by_sinusoid(data, [1.0]).cost)
    radii = problem_from(data).problem.arm.radii()
    names = tab.page.locator("#arm-view circle.radius title").all_text_contents()
    assert any(name.endswith(f"= {radii.outer:.4g}") and "R_max" in name for name in names)
    tab.press("Control+z")
    assert tab.problem == seed
    assert tab.page.get_by_label("link length of joint 1").input_value() == "30"


@pytest.mark.parametrize("side", ["lower", "upper"])
def test_a_joint_limit_is_dragged(tab, seed, side):
    seed["arm"]["limits"][1] = [0.2, 2.9]
    tab.open(seed, frequency=[1])
    tab.page.click("#arm-modes [data-mode=arm]")
    name, old = f"limit-1-{side}", {"lower": 0.2, "upper": 2.9}[side]
    tab.page.evaluate("selfmotion.player.seek(0.5)")
    motion, scale = tab.motion, tab.arm_scale()
    row = int(np.argmin(np.abs(motion["r"] - 0.5)))
    joint = np.array(scale.pixel(*motion["points"][row, 1]))
    before = motion["q"][row, 0]
    start = np.array(tab.handle(name))
    radius = np.linalg.norm(start - joint)
    assert radius == pytest.approx(34, abs=1)
    wanted = old + (0.5 if side == "lower" else -0.7)
    turns = [before + old + (wanted - old) * k / 6 for k in range(1, 7)]
    tab.drag(tuple(start), *[tuple(joint + radius * np.array([np.cos(a), -np.sin(a)])) for a in turns])
    limits = tab.problem["arm"]["limits"]
    assert limits[1][side == "upper"] == pytest.approx(wanted, abs=0.02)
    data = {**seed, "arm": {**seed["arm"], "limits": limits}}
    assert limits[1][side == "lower"] == seed["arm"]["limits"][1][side == "lower"]
    assert tab.problem == data
    assert_domain_shown(tab, data)
    plan = by_sinusoid(data, [1.0])
    motion = tab.motion
    assert motion["holds"] == plan.verification.holds
    if motion["holds"]:
        assert motion["cost"] == pytest.approx(plan.cost, rel=1e-12)
    tab.press("Control+z")
    assert tab.problem == seed


def test_a_limit_is_moved_with_keys_and_typed(tab, seed):
    tab.open(seed, frequency=[1])
    tab.page.click("#arm-modes [data-mode=arm]")
    tab.page.locator('[data-handle="limit-1-upper"]').focus()
    tab.press("ArrowUp")
    (low, high) = tab.problem["arm"]["limits"][1]
    assert low == 0
    assert high != pytest.approx(np.pi)
    tab.page.get_by_label("upper limit of joint 2").fill("2.5")
    tab.press("Tab")
    assert tab.problem["arm"]["limits"] == [None, [0, 2.5], None]
    assert_domain_shown(tab, tab.problem)
    tab.page.get_by_label("link length of joint 3").fill("22")
    tab.press("Enter")
    assert tab.problem["arm"]["links"] == [30, 30, 22]
    tab.page.get_by_role("button", name="add a link").click()
    tab.settle()
    assert tab.problem["arm"]["links"] == [30, 30, 22, 22]


def test_ghosts_and_reach_are_shown_and_hidden(tab, seed):
    tab.open(seed, frequency=[1])
    ghosts = tab.page.locator("#arm-view .ghost")
    assert ghosts.count() == 13
    before = tab.arm_scale()
    tab.page.get_by_label("ghosts").uncheck()
    assert ghosts.count() == 0
    tab.page.get_by_label("reach").check()
    after = tab.arm_scale()
    assert after.x[0] < before.x[0]
    box = tab.page.locator("#arm-view svg").bounding_box()
    for place in ([-80, 0], [80, 0], [0, -80], [0, 80]):
        x, y = after.pixel(*place)
        assert box["x"] < x < box["x"] + box["width"]
        assert box["y"] < y < box["y"] + box["height"]


def test_space_plays_and_the_scrubber_seeks(tab, seed):
    tab.open(seed, frequency=[1])
    tab.page.keyboard.press("Space")
    tab.until("selfmotion.player.isPlaying && selfmotion.player.r > 0.02")
    tab.page.keyboard.press("Space")
    tab.until("!selfmotion.player.isPlaying")
    tab.page.locator("#scrub").focus()
    tab.page.keyboard.press("End")
    assert tab.value("selfmotion.player.r") == 1
    assert tab.page.locator("#place").inner_text() == "r = 1.000"
    tool = tab.page.locator("#arm-view .tool").bounding_box()
    seen = tab.arm_scale().value(tool["x"] + tool["width"] / 2, tool["y"] + tool["height"] / 2)
    assert np.allclose(seen, problem_from(seed).problem.path(1.0), rtol=0, atol=0.1)

"""The angle domain on the page, and the curve in it that is taken in hand, against the library."""

import numpy as np
import pytest
from browser import as_shown, by_hand, by_sinusoid

import selfmotion as sm
from selfmotion.exchange import problem_from
from selfmotion.profiles import BSplineProfile, ProfileCurve

TAU = 2 * np.pi
PLACES = [0.05, 0.31, 0.5, 0.77, 0.96]
ANGLES = np.linspace(0, TAU, 1441)
TWO_BRANCHES = {
    "arm": {"kind": "planar", "links": [30, 30, 20]},
    "path": {"kind": "bezier", "control_points": [[20, 50], [-35, 15], [-25, 30], [25, -35]]},
}


def assert_is_domain(lines, domain, branch, within):
    """Regions given as their outlines (low from left to right, high back) are the angle domain at several places."""
    for r in PLACES:
        shown = np.zeros(len(ANGLES), dtype=bool)
        near = np.zeros(len(ANGLES), dtype=bool)
        for line in lines:
            half = len(line) // 2
            if not line[0, 0] <= r <= line[half - 1, 0]:
                continue
            ends = [np.interp(r, part[:, 0], part[:, 1]) for part in (line[:half], line[half:][::-1])]
            for turn in range(-3, 4):
                low, high = (end + turn * TAU for end in ends)
                shown |= (low <= ANGLES) & (high >= ANGLES)
                near |= (np.abs(low - ANGLES) < within) | (np.abs(high - ANGLES) < within)
        expected = domain(r, branch)
        clear = ~near & (expected.distance_to_ends(ANGLES) > within) if len(expected.intervals) else ~near
        assert clear.sum() > 1400
        assert (shown == expected.contains(ANGLES))[clear].all(), (r, branch)


@pytest.mark.parametrize("case", ["seed", "two branches"])
def test_the_domain_that_is_known_and_drawn_is_the_library_s(tab, seed, case):
    data = seed if case == "seed" else TWO_BRANCHES
    tab.open(data)
    problem = problem_from(data).problem
    domain = sm.angle_domain(problem.arm, problem.path)
    panels = tab.value("selfmotion.live.domain.panels")
    assert [panel["branch"] for panel in panels] == ([0] if case == "seed" else [0, 1])
    for number, panel in enumerate(panels):
        known = [
            np.concatenate([np.stack([s["r"], s["low"]], -1), np.stack([s["r"], s["high"]], -1)[::-1]])
            for s in panel["strips"]
        ]
        assert_is_domain(known, domain, panel["branch"], 2e-3)
        assert_is_domain(tab.drawn("path.region", number), domain, panel["branch"], 6e-3)
        edges = tab.drawn("path.edge", number)
        assert edges
        for line in (edge for edge in edges if np.ptp(edge[:, 0]) > 0.02):  # not what the seam of the window cuts off
            # Halfway along, not at an end, where it meets another and pixels are too coarse for what is beside it.
            at = (
                0.5 * (line[0, 0] + line[-1, 0]),
                np.interp(0.5 * (line[0, 0] + line[-1, 0]), *line[line[:, 0].argsort()].T),
            )
            assert domain(at[0], panel["branch"]).distance_to_ends(at[1]) < 2e-2


def test_the_curve_drawn_is_the_sinusoid_and_its_figures_are_the_library_s(tab, seed):
    tab.open(seed, frequency=[0.75])
    plan = by_sinusoid(seed, [0.75])
    (line,) = tab.drawn("path.curve:not(.grip)")
    assert np.abs(line[:, 1] - (0.3 + 0.4 * np.sin(TAU * 0.75 * line[:, 0]))).max() < 2e-3
    assert tab.motion["cost"] == pytest.approx(plan.cost, rel=1e-12)
    assert tab.figures == pytest.approx(
        {
            "cost": as_shown(plan.cost), "chord sum": as_shown(plan.cost_sampled),
            "nearest limit": as_shown(plan.verification.min_limit_margin, 4),
        },
        rel=1e-12,
    )  # fmt: skip
    rows = tab.motion
    assert np.allclose(rows["q"], plan(rows["r"]), rtol=0, atol=1e-12)
    tab.page.locator("#frequency").focus()
    tab.press("ArrowRight")
    assert tab.value("selfmotion.model.state.frequency") == [0.76]
    assert tab.motion["cost"] == pytest.approx(by_sinusoid(seed, [0.76]).cost, rel=1e-12)


def test_a_control_point_is_dragged_with_the_mouse(tab, seed):
    tab.open(seed, frequency=[1])
    x, y = tab.handle("path-2")
    end = x - 24, y + 31
    expected = tab.arm_scale().value(*end)
    tab.drag((x, y), end)
    points = tab.problem["path"]["control_points"]
    assert points[2] == pytest.approx(expected, abs=0.02)
    changed = {**seed, "path": {"kind": "bezier", "control_points": points}}
    old = seed["path"]["control_points"]
    assert [*points[:2], *points[3:]] == [*old[:2], *old[3:]]
    assert tab.problem == changed
    assert tab.motion["cost"] == pytest.approx(by_sinusoid(changed, [1.0]).cost, rel=1e-12)
    assert tab.figures["cost"] == as_shown(by_sinusoid(changed, [1.0]).cost)
    problem = problem_from(changed).problem
    assert_is_domain(tab.drawn("path.region"), sm.angle_domain(problem.arm, problem.path), 0, 6e-3)
    tab.page.click("#undo")
    tab.settle()
    assert tab.problem == seed


def test_a_control_point_is_moved_with_keys(tab, seed):
    tab.open(seed, frequency=[1])
    tab.page.locator('[data-handle="path-1"]').focus()
    tab.press("ArrowRight", 3)
    tab.press("Shift+ArrowDown")
    assert tab.page.evaluate("document.activeElement.dataset.handle") == "path-1"
    points = tab.problem["path"]["control_points"]
    assert points[1] == pytest.approx([85 + 3 * 0.4, 30 - 4.0])
    assert tab.motion["cost"] == pytest.approx(by_sinusoid(tab.problem, [1.0]).cost, rel=1e-12)
    tab.press("Control+z", 4)
    assert tab.problem == seed
    assert tab.page.locator("#undo").is_disabled()
    tab.press("Control+Shift+z", 4)
    assert tab.problem["path"]["control_points"] == points


def test_keys_that_come_faster_than_pictures_all_count(tab, seed):
    tab.open(seed, frequency=[1])
    tab.page.locator('[data-handle="path-1"]').evaluate(
        """(handle) => {
          const press = () => new KeyboardEvent("keydown", { key: "ArrowRight", bubbles: true });
          for (let k = 0; k < 3; k += 1) handle.dispatchEvent(press());
        }"""
    )
    tab.settle()
    assert tab.problem["path"]["control_points"][1] == pytest.approx([85 + 3 * 0.4, 30])


def test_the_curve_is_dragged_and_is_one_by_hand(tab, seed):
    tab.page.set_viewport_size({"width": 1700, "height": 900})
    tab.open(seed, frequency=[0.5])
    start, scale = tab.grip(0.5), tab.scale()
    end = start[0], start[1] - 40
    at, wanted = scale.value(*start)[0], scale.value(*end)[1]
    tab.drag(start, end)
    hand = tab.hand
    assert hand["branch"] == "positive"
    plan = by_hand(seed, hand)
    r = np.linspace(0, 1, 501)
    away = plan.u(r)[:, 0] - (0.3 + 0.4 * np.sin(TAU * 0.5 * r))
    assert wanted - 0.7 > 0.3
    assert plan.u(at)[0] == pytest.approx(wanted, abs=8e-3)
    assert np.abs(away[np.abs(r - 0.5) > 0.48]).max() < 8e-3
    motion = tab.motion
    assert motion["holds"]
    assert motion["cost"] == pytest.approx(plan.cost, rel=1e-12)
    assert np.allclose(motion["q"], plan(motion["r"]), rtol=0, atol=1e-12)
    assert tab.chip == "by hand"
    assert tab.figures["cost"] == as_shown(plan.cost)
    (line,) = tab.drawn("path.curve:not(.grip):not(.rival)")
    assert np.abs(line[:, 1] - plan.u(line[:, 0].clip(0, 1))[:, 0]).max() < 5e-3


def test_the_diagram_stays_where_it_is_when_the_curve_is_taken_in_hand(tab, seed):
    tab.open(seed, frequency=[0.5])
    frame = tab.page.locator("#domain-view .frame")
    before, start = frame.bounding_box(), tab.grip(0.5)
    tab.drag(start, (start[0], start[1] - 30))
    assert frame.bounding_box() == before


def test_a_curve_out_of_the_domain_is_marked_with_reason_and_place(tab, seed):
    seed["arm"]["limits"] = [None, [0.3, 2.6], [-2.8, 2.2]]
    tab.open(seed, frequency=[0.5])
    assert tab.motion["holds"]
    start = tab.grip(0.5)
    frame = tab.page.locator("#domain-view .frame").bounding_box()
    tab.drag(start, (start[0], frame["y"] + 3), release=False)
    assert tab.chip == "not a motion"
    tab.page.mouse.up()
    tab.settle()
    motion, hand = tab.motion, tab.hand
    problem = problem_from(seed).problem
    r = np.linspace(0, 1, 20001)
    rows = np.array(hand["coefficients"])
    u = ProfileCurve(BSplineProfile(*rows.shape), rows.ravel())(r, 0)
    q, ok = problem.arm.solve(problem.path(r), u, 0)
    with np.errstate(invalid="ignore"):
        amounts = {
            (joint, side): np.where(ok, (limit - q[:, joint]) * side, 0)
            for joint, limits in ((1, [0.3, 2.6]), (2, [-2.8, 2.2]))
            for side, limit in ((1, limits[0]), (-1, limits[1]))
        }
    expected = stretches(r, ~ok)
    for amount in amounts.values():
        expected += stretches(r, amount > 0)
    assert expected
    found = sorted(part["r"] for part in motion["wrong"])
    assert np.allclose(found, sorted(expected), rtol=0, atol=2e-3)
    for part in motion["wrong"]:
        if part["kind"] == "limit":
            side = 1 if "below its lower" in part["text"] else -1
            assert f"θ{part['joint'] + 1} " in part["text"]
            # By how much is told of the rows; near a fold it changes fast between them.
            amount = np.interp(problem.rows, r, amounts[part["joint"], side])
            there = (problem.rows >= part["r"][0]) & (problem.rows <= part["r"][1])
            assert part["by"] == pytest.approx(amount[there].max(), abs=5e-3)
        else:
            assert "do not reach" in part["text"]
    assert motion["cost"] is None
    assert "cost" not in tab.figures
    longest = sorted(motion["wrong"], key=lambda part: part["r"][0] - part["r"][1])
    worst = longest[0]
    assert worst["text"] in tab.verdict
    assert f"r from {as_shown(worst['r'][0], 3):g} to {as_shown(worst['r'][1], 3):g}" in tab.verdict
    marked = np.concatenate(tab.drawn("path.wrong"))[:, 0]
    assert marked.min() == pytest.approx(min(found)[0], abs=5e-3)
    said = tab.page.locator("#domain-view .why").all_text_contents()
    assert said == [f"✕ {part['text']}" for part in longest[:2]]
    assert tab.page.locator("#joints-view .wrong-band").count() == len(found)
    tab.press("Control+z")
    assert tab.hand is None
    assert tab.motion["holds"]
    assert tab.chip == "sinusoid"
    tab.press("Control+Shift+z")
    assert tab.hand == hand
    tab.page.locator('#curves [data-curve="hand"]').click()
    tab.settle()
    assert tab.chip == "not a motion"
    assert tab.motion["wrong"] == motion["wrong"]


def test_what_is_redone_is_shown(tab, seed):
    tab.open(seed, frequency=[0.5])
    start = tab.grip(0.5)
    tab.drag(start, (start[0], start[1] - 20))
    tab.press("Control+z")
    tab.press("Control+Shift+z")
    assert tab.hand is not None
    assert tab.chip == "by hand"


def stretches(r, bad):
    edges = np.flatnonzero(np.diff(np.concatenate([[0], bad.astype(int), [0]])))
    return [[r[a], r[b - 1]] for a, b in zip(edges[::2], edges[1::2], strict=True)]


def test_a_curve_drawn_freehand_is_followed(tab, seed):
    tab.open(seed, frequency=[1])
    scale = tab.scale()
    tab.page.click("#draw-curve")
    wanted = [(0.0, 0.3), (0.2, 0.5), (0.5, 0.2), (0.8, -0.1), (1.0, 0.1)]
    tab.drag(scale.pixel(*wanted[0]), *[scale.pixel(*at) for at in wanted[1:]])
    tab.until("selfmotion.model.state.hand")
    tab.settle()
    plan = by_hand(seed, tab.hand)
    for r, u in wanted:
        assert plan.u(r)[0] == pytest.approx(u, abs=0.03)
    assert tab.motion["cost"] == pytest.approx(plan.cost, rel=1e-12)
    assert tab.page.locator("#draw-curve").get_attribute("aria-pressed") == "false"
    tab.page.get_by_role("button", name="drop the curve by hand").click()
    tab.settle()
    assert tab.hand is None


def test_the_curve_by_hand_is_moved_with_keys(tab, seed):
    hand = {"branch": "positive", "coefficients": [[0.2] * 12]}
    tab.open(seed, hand=hand)
    handles = tab.page.locator("#domain-view .handle")
    for _ in range(2):
        handles.nth(5).focus()
        tab.press("Shift+ArrowUp")
    r = float(handles.nth(5).get_attribute("aria-label").removeprefix("curve at r = "))
    plan = by_hand(seed, tab.hand)
    assert plan.u(r)[0] == pytest.approx(0.4, abs=2e-3)
    assert tab.motion["cost"] == pytest.approx(plan.cost, rel=1e-12)
    handles.nth(5).focus()
    tab.press("ArrowRight")
    assert tab.page.evaluate("document.activeElement.dataset.index") == "6"
    tab.press("Control+z", 2)
    assert tab.hand == hand


def test_a_handle_of_the_curve_that_keys_move_keeps_the_focus(tab, seed):
    tab.open(seed, hand={"branch": "positive", "coefficients": [[0.2] * 12]})
    tab.page.locator("#domain-view .handle").nth(5).focus()
    tab.press("ArrowUp")
    assert tab.page.evaluate("document.activeElement.dataset.index") == "5"


def test_a_place_is_sought_by_a_click_and_told_exactly_under_the_pointer(tab, seed):
    tab.open(seed, frequency=[1])
    scale, plan = tab.scale(), by_sinusoid(seed, [1.0])
    at = scale.pixel(0.25, tab.value("selfmotion.live.domain.panels[0].range[0]") + 0.05)
    tab.page.mouse.click(*at)
    assert tab.value("selfmotion.player.r") == pytest.approx(0.25, abs=2e-3)
    said = tab.page.locator("#domain-readout").inner_text().replace("−", "-")
    k = int(np.argmin(np.abs(tab.motion["r"] - 0.25)))
    r = tab.motion["r"][k]
    for name, value in zip(("θ1", "θ2", "θ3"), plan(r), strict=True):
        assert float(said.split(f"{name} = ")[1].split(",")[0].split(" ")[0]) == pytest.approx(value, abs=6e-3)
    tool = tab.page.locator("#arm-view .tool")
    pixel = [float(tool.get_attribute(name)) for name in ("cx", "cy")]
    box = tab.page.locator("#arm-view svg").bounding_box()
    seen = tab.arm_scale().value(pixel[0] + box["x"], pixel[1] + box["y"])
    place = problem_from(seed).problem.path(tab.value("selfmotion.player.r"))
    assert np.allclose(seen, place, rtol=0, atol=0.2)

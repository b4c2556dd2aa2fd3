"""Arms in space and of many links on the page."""

import numpy as np
import pytest
from browser import as_shown, by_curve, by_hand, planned

import selfmotion as sm
from selfmotion.exchange import problem_from
from selfmotion.plot.window import Window
from selfmotion.profiles import BSplineProfile
from selfmotion.studio.cases import CASES
from selfmotion.studio.panels import component_field

PANDA = {case.name: case.problem for case in CASES}["panda-circle"]
SIX = {case.name: case.problem for case in CASES}["seed-6r"]


def test_the_panda_s_domain_plan_and_view(tab):
    tab.open(PANDA)
    problem = problem_from(PANDA).problem
    domain = sm.angle_domain(problem.arm, problem.path)
    panels = tab.value("selfmotion.live.domain.panels")
    assert len(panels) > 1
    assert tab.page.locator("#domain-view svg.plot").count() == len(panels)
    assert tab.value("selfmotion.live.domain.kind") == "sampled"
    for panel in panels:
        assert panel["title"] == problem.arm.branches[panel["branch"]]
        for strip in panel["strips"][:2]:
            k = len(strip["r"]) // 2
            found = domain(strip["r"][k], panel["branch"])
            for end in (strip["low"][k], strip["high"][k]):
                assert found.is_full or found.distance_to_ends(end) < 1e-6
    for branch in set(range(len(problem.arm.branches))) - {panel["branch"] for panel in panels}:
        assert not domain(0.5, branch)

    tab.plan(90)
    plan = planned(PANDA)
    summary = tab.found["summary"]
    assert {name: summary[name] for name in ("cost", "lower_bound", "gap")} == {
        "cost": plan.cost, "lower_bound": plan.lower_bound, "gap": plan.gap,
    }  # fmt: skip
    assert tab.figures["cost"] == as_shown(plan.cost)
    assert tab.figures["lower bound"] == as_shown(plan.lower_bound)
    motion = tab.motion
    assert motion["points"].shape[1:] == (8, 3)
    assert np.allclose(motion["q"], plan(motion["r"]), rtol=0, atol=1e-12)

    view = tab.page.locator("#arm-view svg.space")
    assert tab.page.locator("#arm-modes").is_hidden()
    box = view.bounding_box()
    before = drawn(tab)
    middle = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    tab.drag(middle, (middle[0] + 60, middle[1] + 25))
    turned = drawn(tab)
    assert np.abs(turned - before).max() > 10
    assert tab.page.evaluate("document.activeElement.classList.contains('space')")
    tab.press("ArrowLeft", 4)
    assert np.abs(drawn(tab) - turned).max() > 10
    tab.page.evaluate("selfmotion.player.seek(0.3)")
    x, y, z = (
        float(part) for part in tab.page.locator("#arm-view .readout").inner_text().replace("−", "-")[8:-2].split(",")
    )
    row = int(np.argmin(np.abs(motion["r"] - 0.3)))
    assert [x, y, z] == pytest.approx(problem.path(motion["r"][row])[:3], abs=2e-4)
    assert [x, y, z] == pytest.approx(problem.arm.forward(plan(motion["r"][row]))[:3], abs=2e-4)
    tab.screenshot("panda")


def drawn(tab):
    text = tab.page.locator("#arm-view path.path").get_attribute("d")
    return np.array([[float(x) for x in pair.split()] for pair in text.removeprefix("M").split("L")])


def test_many_links_have_a_panel_per_component(tab):
    tab.open(SIX)
    panels = tab.value("selfmotion.live.domain.panels")
    assert [panel["component"] for panel in panels] == [0, 1, 2, 3]
    assert tab.page.locator("#domain-view svg.plot").count() == 4
    tab.plan()
    plan = planned(SIX)
    assert tab.found["summary"]["cost"] == plan.cost
    assert tab.figures["cost"] == as_shown(plan.cost)
    motion = tab.motion
    assert np.allclose(motion["q"], plan(motion["r"]), rtol=0, atol=1e-12)
    panels = tab.value("selfmotion.live.domain.panels")
    problem = problem_from(SIX).problem
    for number, panel in enumerate(panels):
        # The motion is feasible, so where the others stay as they are each component is inside of what is drawn.
        (line, *_) = tab.drawn("path.curve:not(.grip)", number)
        r = line[:, 0].clip(0, 1)
        away = (line[:, 1] - plan.u(r)[:, panel["component"]] + np.pi) % (2 * np.pi) - np.pi
        assert np.abs(away).max() < 3e-2
        field = panel["field"]["margin"]
        columns = np.linspace(0, 1, field.shape[1])
        u = plan.u(columns)
        middle = sum(panel["field"]["u"]) / 2
        expected = component_field(
            problem.arm, problem.path(columns), u, 0, panel["component"], Window(middle), field.shape[0]
        ).margin
        assert np.quantile(np.abs(field - expected), 0.95) < 0.05


def test_a_component_of_many_is_dragged(tab):
    data = {name: value for name, value in SIX.items() if name != "planner"}
    data["planner"] = {"kind": "refine", "starts": 1, "seed": 0}
    data["samples"] = 200
    hand = {"branch": "positive/positive", "coefficients": np.full((4, 10), 0.3).tolist()}
    problem = problem_from(data).problem
    hand["branch"] = problem.arm.branches[0]
    hand["coefficients"] = [[level] * 10 for level in (0.3, 0.2, 0.1, -0.1)]
    tab.page.set_viewport_size({"width": 1700, "height": 900})
    tab.open(data, hand=hand)
    scale = tab.scale(1)
    start = scale.pixel(0.5, 0.2)
    end = start[0], start[1] - 12
    tab.drag(start, end)
    changed = tab.hand["coefficients"]
    assert [changed[k] for k in (0, 2, 3)] == [hand["coefficients"][k] for k in (0, 2, 3)]
    plan = by_hand(data, tab.hand)
    assert plan.u(0.5)[1] == pytest.approx(scale.value(*end)[1], abs=2e-2)
    motion = tab.motion
    if motion["holds"]:
        assert motion["cost"] == pytest.approx(plan.cost, rel=1e-12)
    else:
        assert motion["cost"] is None
        assert not by_curve(data, BSplineProfile(4, 10), np.ravel(changed)).verification.holds

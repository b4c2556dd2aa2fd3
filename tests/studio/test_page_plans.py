"""Planning from the page: what comes out is the library's to the last bit; cancelling; several tabs at once."""

import math
from itertools import pairwise

import browser
import numpy as np
import pytest
from browser import as_shown, by_hand, planned, until
from served import is_there, ticks

from selfmotion.certificate.verdict import percent
from selfmotion.exchange import problem_from

TAU = 2 * np.pi
TWO_ELBOWS = {
    "arm": {"kind": "planar", "links": [30, 30, 20]},
    "path": {"kind": "bezier", "control_points": [[20, 50], [-35, 15], [-25, 30], [25, -35]]},
}
ENDLESS = {**TWO_ELBOWS, "planner": {"kind": "global", "gap": 1e-9, "time_limit": 60}}
LISTEN = """
() => {
  globalThis.heard = [];
  selfmotion.planning.addEventListener("step", ({ detail }) => heard.push({
    ...detail, said: document.querySelector("#evolution-said").textContent,
    shown: !document.querySelector("#progress").hidden, chip: document.querySelector("#verdict .chip").textContent,
  }));
}
"""


def test_a_search_is_seen_and_its_result_is_the_library_s(tab, seed):
    seed["planner"]["optimizer"] |= {"population": 60, "iterations": 150, "bounds": [0, 15]}
    tab.open(seed, frequency=[1])
    tab.page.evaluate(LISTEN)
    tab.plan()
    plan = planned(seed)
    found = tab.found
    summary = plan.summary()
    same = ("cost", "cost_error", "cost_sampled", "l1_travel", "max_tracking_error", "min_limit_margin", "evaluations")
    assert {name: found["summary"][name] for name in same} == {name: summary[name] for name in same}
    assert found["summary"]["parameters"] == summary["parameters"]
    assert "f" in summary["parameters"]
    assert tab.figures["cost"] == as_shown(plan.cost)
    assert tab.figures["chord sum"] == as_shown(plan.cost_sampled)
    assert tab.figures["nearest limit"] == as_shown(plan.verification.min_limit_margin, 4)
    assert tab.chip.startswith("solved by ")
    motion = tab.motion
    assert np.array_equal(motion["q"], plan(motion["r"]))
    history = found["history"][0]
    assert history["best"] == list(plan.history[0].best)
    heard = tab.value("heard")
    assert heard
    assert [step["done"] for step in heard] == sorted({step["done"] for step in heard})
    assert heard[-1]["done"] == heard[-1]["total"]
    assert all(step["shown"] and step["chip"] == "planning" for step in heard)
    assert all(a["best"] >= b["best"] for a, b in pairwise(heard))
    assert len({step["said"] for step in heard}) >= min(len(heard), 2)
    assert tab.page.locator("#evolution-view path.evolution.best").count() == 2  # the line, and in the key
    assert tab.page.locator("#plan").is_visible()
    assert tab.page.locator("#progress").is_hidden()


def test_the_shortest_motion_its_proof_and_how_far_a_curve_by_hand_is_from_it(tab, seed):
    seed["planner"] = {"kind": "global", "gap": 1e-3, "time_limit": 60}
    tab.page.set_viewport_size({"width": 1700, "height": 900})
    tab.open(seed)
    tab.plan()
    plan, found = planned(seed), tab.found
    for name in ("cost", "lower_bound", "gap"):
        assert found["summary"][name] == getattr(plan, name)
    assert tab.figures["cost"] == as_shown(plan.cost)
    assert tab.figures["lower bound"] == as_shown(plan.lower_bound)
    assert "proved within" in tab.verdict
    assert [level["bound"] for level in found["levels"]] == [level.bound for level in plan.certificate.levels]
    assert tab.page.locator("#evolution-view path.evolution.bound").count() == 2
    assert_tube_holds(tab, plan)

    start = tab.grip(0.4)
    tab.drag(start, (start[0], start[1] + 20))
    hand = by_hand(seed, tab.hand)
    assert tab.chip == "by hand", tab.verdict
    assert tab.motion["cost"] == pytest.approx(hand.cost, rel=1e-12)
    off = (hand.cost - plan.lower_bound) / plan.lower_bound
    assert f"at most {percent(off)} above" in tab.verdict.replace("\u202f", " ")
    assert tab.figures["lower bound"] == as_shown(plan.lower_bound)
    assert off > plan.gap
    rival = tab.drawn("path.curve.rival")
    assert np.abs(np.concatenate(rival)[:, 1] - on_panel(tab, plan, np.concatenate(rival)[:, 0])).max() < 2e-2


def test_a_curve_bent_in_the_middle_keeps_the_given_start(tab, seed):
    seed["start"] = {"u": [0.3]}
    seed["planner"] = {"kind": "global", "gap": 1e-2, "time_limit": 60}
    tab.open(seed)
    tab.plan()
    start = tab.grip(0.5)
    tab.drag(start, (start[0], start[1] - 20))
    assert tab.chip == "by hand", tab.verdict


def on_panel(tab, plan, r):
    low, high = tab.value("selfmotion.live.domain.panels[0].period")
    return (plan.u(r.clip(0, 1))[:, 0] - low) % (high - low) + low


def assert_tube_holds(tab, plan):
    """At every slice of the tube the curve is inside of what is known of it and of what is drawn."""
    (known,) = tab.value("selfmotion.planning.planFor(selfmotion.model.state.problem).tube")
    assert known["branch"] == 0
    polygons = known["polygons"]
    drawn = np.array(tab.drawn("path.tube"))
    assert drawn.shape == polygons.shape
    assert np.abs(drawn - polygons).max() < 5e-3
    for r in (0.1, 0.37, 0.5, 0.81):
        u = on_panel(tab, plan, np.array([r]))[0]
        inside = False
        for corners in polygons:
            left, right = corners[:, 0].min(), corners[:, 0].max()
            if not left <= r <= right:
                continue
            ends = []
            for a, b in zip(corners, np.roll(corners, -1, axis=0), strict=True):
                if min(a[0], b[0]) <= r <= max(a[0], b[0]) and a[0] != b[0]:
                    ends.append(a[1] + (r - a[0]) / (b[0] - a[0]) * (b[1] - a[1]))
            inside |= bool(ends) and min(ends) - 2e-2 <= u <= max(ends) + 2e-2
        assert inside, r


def test_a_motion_through_a_fold_is_on_both_panels(tab):
    data = {**TWO_ELBOWS, "planner": {"kind": "global", "gap": 1e-2, "time_limit": 60}}
    tab.open(data)
    tab.plan()
    plan = planned(data)
    assert tab.found["summary"]["cost"] == plan.cost
    problem = problem_from(data).problem
    for panel, branch in enumerate(tab.value("selfmotion.live.domain.panels.map((panel) => panel.branch)")):
        on = problem.arm.branch_of(plan(problem.rows)) == branch
        lines = tab.drawn("path.curve:not(.grip)", panel)
        assert bool(lines) == bool(on.any())
        for line in lines:
            r = line[:, 0].clip(0, 1)
            away = (line[:, 1] - plan.u(r)[:, 0] + math.pi) % TAU - math.pi
            assert np.quantile(np.abs(away), 0.98) < 2e-2


def test_a_plan_is_forgotten_when_the_problem_changes_and_known_again_after_undo(tab, seed):
    tab.open(seed, frequency=[1])
    tab.plan()
    cost = tab.figures["cost"]
    tab.page.locator('[data-handle="path-2"]').focus()
    tab.press("ArrowUp")
    assert tab.chip == "sinusoid"
    assert tab.found is None
    tab.press("Control+z")
    tab.page.locator('#curves [data-curve="plan"]').click()
    tab.settle()
    assert tab.figures["cost"] == cost
    assert tab.chip.startswith("solved by ")


def test_cancelling_ends_the_worker_and_the_page_goes_on(tab, server, seed):
    tab.open(ENDLESS)
    tab.page.click("#plan")
    tab.until("document.querySelector('#cancel').offsetParent")
    worker = until(lambda: busy(server))
    assert tab.chip == "planning"
    tab.page.click("#cancel")
    until(lambda: not is_there(worker), 2.0, "the worker is still there")
    tab.until("!selfmotion.planning.isRunning")
    assert tab.page.locator("#evolution-said").inner_text() == "cancelled"
    assert tab.page.locator("#plan").is_visible()
    tab.open(seed, frequency=[1])
    tab.plan()
    assert tab.found["summary"]["cost"] == planned(seed).cost


def busy(server):
    """Return the worker that has computed for a while, None if none has."""
    before = {pid: ticks(pid) for pid in server.workers()}
    worker = server.working()
    return worker if worker in before and ticks(worker) - before[worker] >= 15 else None


def test_the_page_answers_while_a_plan_runs(tab, seed):
    tab.open(ENDLESS)
    tab.page.click("#plan")
    tab.until("asked.plans === 1 && selfmotion.planning.isRunning")
    tab.page.locator('[data-handle="path-1"]').focus()
    tab.press("ArrowRight")
    assert tab.problem["path"]["control_points"][1] != TWO_ELBOWS["path"]["control_points"][1]
    assert tab.value("selfmotion.planning.isRunning")
    tab.page.click("#cancel")
    tab.planned()


def test_two_tabs_plan_different_problems_at_once(tab, seed):
    other = {**seed, "path": {"kind": "circle", "center": [50, 10], "radius": 12}}
    tab.open(seed, frequency=[1])
    second = browser.Tab(tab.page.context.new_page(), tab.address).open(other, frequency=[1])
    tab.page.click("#plan")
    second.page.click("#plan")
    tab.planned()
    second.planned()
    for one, data in ((tab, seed), (second, other)):
        assert one.problem == data
        assert one.found["summary"]["cost"] == planned(data).cost
        assert one.figures["cost"] == as_shown(planned(data).cost)


def test_a_tab_closed_in_mid_plan_leaves_no_worker_and_the_other_goes_on(tab, server, seed):
    second = browser.Tab(tab.page.context.new_page(), tab.address).open(ENDLESS)
    second.page.click("#plan")
    worker = until(lambda: busy(server))
    second.page.close()
    until(lambda: not is_there(worker), 2.0, "the worker is still there")
    tab.open(seed, frequency=[1])
    tab.plan()
    assert tab.found["summary"]["cost"] == planned(seed).cost

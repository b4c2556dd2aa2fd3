"""What is wrong with a problem is said where it is seen, and the pictures stay."""

import json

import browser
import pytest
import served
from browser import as_shown
from test_page_plans import TWO_ELBOWS

import selfmotion as sm
from selfmotion.exchange import problem_from

LINE = {"kind": "line", "start": [60, 0], "end": [95, 0]}


def with_text(tab, text):
    if not tab.page.locator("#source").evaluate("(details) => details.open"):
        tab.page.locator("#source summary").click()
    tab.until("document.querySelector('#text').value && asked.looks === 0")
    tab.page.locator("#text").fill(text)
    tab.page.locator("#apply").click()
    tab.until("asked.looks === 0")


GOOD = "arm: {kind: planar, links: [30, 30, 20]}\npath: {kind: line, start: [50, 0], end: [60, 10]}\n"
BAD = {
    "arm.links.1": GOOD.replace("30, 20", "-1, 20"),
    "arm.links": GOOD.replace("[30, 30, 20]", "3"),
    "path.end": GOOD.replace(", end: [60, 10]", ""),
    "samples": GOOD + "samples: many\n",
    "planner.gap": GOOD + "planner: {kind: global, gap: -1}\n",
    "arm.link": GOOD.replace("links", "link"),
}


@pytest.mark.parametrize("field", BAD)
def test_bad_input_is_said_by_its_field_and_the_pictures_stay(tab, seed, field):
    tab.open(seed, frequency=[1])
    with_text(tab, BAD[field])
    tab.until("document.querySelector('#verdict .chip').textContent === 'cannot be'")
    assert field in tab.verdict or field.removesuffix(".1") in tab.verdict
    assert "mistake" not in tab.verdict
    assert tab.page.locator("#domain-view path.region").count() >= 1
    assert tab.page.locator("#arm-view path.path").count() >= 1
    assert tab.page.locator("#joints-view path.series").count() == 3
    with_text(tab, GOOD)
    assert tab.chip == "ready"
    tab.press("Control+z", 2)
    tab.watch.check()


def test_text_that_is_no_problem_is_said_at_the_text(tab, seed):
    tab.open(seed, frequency=[1])
    for text, said in (("arm: [", "line"), ("arm: {kind: planar}\n", "path"), ("[1, 2]", "mapping")):
        with_text(tab, text)
        assert said in tab.page.locator("#text").evaluate("(area) => area.validationMessage")
        assert tab.problem == seed
        assert tab.chip == "sinusoid"


def test_the_text_is_the_problem(tab, seed):
    tab.open(seed, frequency=[1])
    with_text(tab, GOOD)
    assert tab.problem == {
        "arm": {"kind": "planar", "links": [30, 30, 20]}, "path": {"kind": "line", "start": [50, 0], "end": [60, 10]},
    }  # fmt: skip
    tab.page.get_by_label("link length of joint 1").fill("31")
    tab.press("Enter")
    assert "links: [31, 30, 20]" in tab.page.locator("#text").input_value()


def assert_blocked_as(tab, data):
    problem = problem_from(data).problem
    (part, *_) = problem.blocked
    assert tab.chip == "no motion exists"
    assert tab.value("selfmotion.live.scene.blocked[0].r") == pytest.approx(list(part.r), abs=1e-12)
    assert f"for r from {part.r[0]:.4g} to {part.r[1]:.4g}" in tab.verdict
    assert part.cause in tab.verdict
    assert tab.page.locator("#arm-view path.blocked").count() == len(problem.blocked)
    return part


def test_a_path_out_of_reach_is_said_with_the_stretch(tab):
    data = {"arm": {"kind": "planar", "links": [30, 30, 20]}, "path": LINE}
    tab.open(data)
    part = assert_blocked_as(tab, data)
    assert part.r == pytest.approx((20 / 35, 1), abs=1e-3)
    assert part.short_by == pytest.approx(15, abs=1e-6)
    tab.plan()
    assert tab.chip == "no motion exists"
    assert f"{as_shown(part.r[0], 3):g}"[:4] in tab.verdict
    assert tab.page.locator("#plan").is_visible()
    tab.page.locator('[data-handle="path-1"]').focus()
    tab.press("Shift+ArrowLeft", 4)
    assert tab.problem["path"]["end"] == [79, 0]
    assert tab.chip != "no motion exists"


def test_limits_that_block_are_said_with_the_stretch(tab, seed):
    seed["arm"]["limits"] = [[0.2, 0.5], [0, 3.141592653589793], [-0.2, 0.2]]
    tab.open(seed, frequency=[1])
    problem = problem_from(seed).problem
    assert problem.blocked
    assert tab.value("selfmotion.live.scene.blocked[0].r") == pytest.approx(list(problem.blocked[0].r), abs=1e-12)
    assert tab.page.locator("#arm-view path.blocked").count() == len(problem.blocked)
    seed["planner"] = {"kind": "global"}
    tab.open(seed)
    part = assert_blocked_as(tab, seed)
    tab.plan()
    assert tab.chip == "no motion exists"
    assert f"{part.r[1]:.3g}"[:4] in tab.verdict


def test_a_search_that_finds_nothing_is_said_and_what_would_help(tab):
    data = {**TWO_ELBOWS, "elbow": "positive", "planner": {"kind": "global", "gap": 1e-2, "time_limit": 60}}
    data["arm"] = {"kind": "planar", "links": [30, 30, 20], "limits": [None, [0.4, 2.2], [-1.0, 1.0]]}
    problem = problem_from(data)
    with pytest.raises(sm.InfeasibleError) as caught:
        problem.planner.plan(problem.problem)
    tab.open(data)
    tab.plan()
    assert tab.chip == "no motion exists"
    assert str(caught.value).split(";")[0].split(":")[0][:30] in tab.verdict


def test_a_studio_that_has_ended_is_said(contexts, tmp_path, seed):
    with served.Studio("--folder", str(tmp_path)) as other:
        context, watch = contexts([other.home])
        watch.allow("ERR_CONNECTION_REFUSED|ERR_EMPTY_RESPONSE|ERR_CONNECTION_RESET|ERR_INCOMPLETE")
        tab = browser.Tab(context.new_page(), other.address, watch).open(seed, frequency=[1])
        other.end()
        tab.page.locator("#frequency").focus()
        tab.page.keyboard.press("ArrowRight")
        tab.until("document.querySelector('#verdict .chip').textContent === 'cannot be'")
        assert "the studio does not answer" in tab.verdict
        assert tab.page.locator("#domain-view path.region").count() >= 1


def test_a_plan_that_fails_is_said_though_there_is_an_older_one(tab, seed):
    tab.open(seed)
    tab.plan()
    assert tab.chip == "solved by sinusoid"
    other = {**seed, "planner": {**seed["planner"], "optimizer": {"kind": "pso", "bounds": [0, 900]}}}
    tab.value(f"selfmotion.model.change({{problem: {json.dumps(other)}}})")
    tab.plan()
    tab.until("document.querySelector('#verdict .chip').textContent === 'cannot be'")
    assert "cannot resolve the fastest profile" in tab.verdict
    tab.value(f"selfmotion.model.change({{problem: {json.dumps(seed)}}})")  # the failure was that of another question
    tab.until("document.querySelector('#verdict .chip').textContent === 'solved by sinusoid'")


def test_another_link_keeps_the_problem_one(tab, seed):
    hand = {"branch": "positive", "coefficients": [[0.3] * 8]}
    tab.open(seed, hand=hand, frequency=[0.8])
    tab.page.get_by_text("add a link").click()
    tab.until("selfmotion.live.scene.n === 4 && asked.looks === 0")
    assert tab.hand is None
    assert tab.problem["planner"]["offset"] == [*seed["planner"]["offset"], 0]
    assert len(tab.problem["planner"]["amplitude"]) == 2
    assert tab.value("selfmotion.live.failure") is None
    tab.press("Control+z")
    tab.until("selfmotion.live.scene.n === 3 && asked.looks === 0")
    assert tab.hand == hand  # one step


def test_an_arm_without_an_angle_domain_says_why(tab, seed):
    tab.open(seed)
    case = {
        "arm": {"kind": "named", "name": "kr6r900", "rail": {"axis": [0, 1, 0], "limits": [-1.2, 1.2]}},
        "path": {
            "kind": "pose", "position": {"kind": "line", "start": [0.6, -0.2, 0.3], "end": [0.6, 0.2, 0.3]},
            "orientation": [0, 1, 0, 0],
        },
    }  # fmt: skip
    tab.value(f"selfmotion.model.change({{problem: {json.dumps(case)}, hand: null, frequency: null}})")
    tab.page.locator("#domain-view .nothing").wait_for(timeout=90_000)
    assert "the redundancy parameter of this arm is a length" in tab.page.locator("#domain-view .nothing").inner_text()


def test_a_posture_that_does_not_reach_leaves_handles_to_drag_it_back(tab, seed):
    tab.open(seed, frequency=[0.8])
    tab.page.click('#arm-modes [data-mode="arm"]')
    tab.value("selfmotion.player.seek(0.7)")
    short = {**seed, "arm": {**seed["arm"], "links": [8, 30, 20]}}
    tab.value(f"selfmotion.model.change({{problem: {json.dumps(short)}}})")
    tab.until("selfmotion.live.scene.links[0] === 8 && asked.looks === 0")
    boxes = [handle.bounding_box() for handle in tab.page.locator("#arm-view .handle").all()]
    if tab.value("selfmotion.motion().q.some((angle) => Number.isFinite(angle))"):
        assert len(boxes) >= 3
    assert all(box["x"] > 0 and box["y"] > 0 for box in boxes)

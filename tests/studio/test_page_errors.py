"""What is wrong with a problem is said where it is seen, and the pictures stay."""

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

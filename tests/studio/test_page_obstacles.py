"""Obstacles in the page: drawn, dragged, added and removed; the domain's holes, plans and figures go with them."""

import numpy as np
import pytest
from browser import as_shown
from test_page_domain import assert_is_domain

import selfmotion as sm
from selfmotion.domain import AngleDomain, SampledDomain
from selfmotion.exchange import problem_from

POST = {"name": "post", "circle": {"center": [30, 24], "radius": 4}}


@pytest.fixture
def between(seed):
    """The seed's problem between two obstacles."""
    corners = [[36, -20], [44, -20], [44, -12], [36, -12]]
    return {
        **seed,
        "obstacles": [{"name": "post", "circle": {"center": [30, 24], "radius": 4}}, {"polygon": corners}],
        "clearance": 0.5,
        "planner": {"kind": "refine", "starts": 4, "seed": 0},
    }


def holes(tab):
    """Return what the page draws holes of: the names written, and outlines by what takes them."""
    found = tab.value("selfmotion.live.domain.panels[0].holes")
    return {hole["by"]: hole for hole in found}


def assert_shown(tab, data):
    """The domain drawn, and its holes, are the library's."""
    problem = problem_from(data).problem
    domain = AngleDomain(problem.arm.self_motion(), problem.path)
    assert_is_domain(tab.drawn("path.region"), domain, 0, 2e-2)
    free, shown = domain.unconstrained, holes(tab)
    names = {hole.by for hole in SampledDomain(domain, [0]).holes(0)}
    assert set(shown) == names
    # In the middle of each hole limits allow what the obstacle does not, by the link that is named.
    for by, hole in shown.items():
        r, u = hole["at"]
        assert free(r, 0).contains(u), by
        assert not domain(r, 0).contains(u), by
        q = problem.arm.solve(problem.path(r)[None], [[u]], 0)[0]
        assert problem.scene.cause(int(problem.scene.least_margins(q)[1][0])) == hole["text"]
        assert hole["text"].endswith(by)
    assert tab.page.locator("#domain-view .hole").count() == len(names)


def test_holes_are_drawn_and_named_as_the_library_has_them(tab, between):
    tab.open(between)
    assert_shown(tab, between)
    texts = tab.page.locator("#domain-view .hole-name").all_text_contents()
    assert "post × link 2" in texts or "post × link 3" in texts
    assert tab.page.locator("#arm-view .obstacle").count() == 2
    assert tab.page.locator("#arm-view .obstacle-name").all_text_contents() == ["post", "2"]
    # What limits is named as without obstacles.
    assert "lower limit of θ2" in tab.page.locator("#domain-view .cause").all_text_contents()


def test_hovering_a_hole_names_link_and_obstacle(tab, between):
    tab.open(between)
    hole = holes(tab)["obstacle 1 (post)"]
    tab.page.mouse.move(*tab.scale().pixel(*hole["at"]))
    tab.until(f"document.querySelector('#domain-readout').textContent.includes('taken: {hole['short']}')")
    # Beside the holes nothing is taken.
    problem = problem_from(between).problem
    free = sm.angle_domain(problem.arm, problem.path)(0.5, 0).intervals[0].mean()
    tab.page.mouse.move(*tab.scale().pixel(0.5, free))
    tab.until("!document.querySelector('#domain-readout').textContent.includes('taken')")


@pytest.mark.parametrize("by", ["handle", "body"])
def test_an_obstacle_dragged_changes_the_holes_and_one_undo_takes_it_back(tab, between, by):
    tab.open(between)
    scale = tab.arm_scale()
    was = holes(tab)
    wanted = scale.pixel(38, 30)
    if by == "handle":
        tab.page.click("#arm-modes [data-mode=obstacles]")
        scale = tab.arm_scale()
        wanted = scale.pixel(38, 30)
        tab.drag(tab.handle("center-0"), wanted)
    else:
        tab.drag(scale.pixel(29, 22), scale.pixel(37, 28))
    center = tab.problem["obstacles"][0]["circle"]["center"]
    assert np.allclose(center, [38, 30], atol=0.3)
    data = {
        **between,
        "obstacles": [{"name": "post", "circle": {"center": center, "radius": 4}}, between["obstacles"][1]],
    }
    assert tab.problem == data
    assert_shown(tab, data)
    assert holes(tab)["obstacle 1 (post)"]["at"] != was["obstacle 1 (post)"]["at"]
    link = tab.page.evaluate("() => selfmotion.model.link()")
    tab.press("Control+z")
    assert tab.problem == between
    assert_shown(tab, between)
    tab.page.goto(tab.address + "#" + link.partition("#")[2])
    tab.page.reload()
    tab.settle()
    assert tab.problem == data


def test_radius_and_corners_are_dragged_and_moved_by_keys(tab, between):
    tab.open(between)
    tab.page.click("#arm-modes [data-mode=obstacles]")
    scale = tab.arm_scale()
    tab.drag(tab.handle("radius-0"), scale.pixel(30, 29))
    assert tab.problem["obstacles"][0]["circle"]["radius"] == pytest.approx(5, abs=0.2)
    tab.drag(tab.handle("corner-1-2"), tab.arm_scale().pixel(48, -10))
    assert np.allclose(tab.problem["obstacles"][1]["polygon"][2], [48, -10], atol=0.3)
    assert_shown(tab, tab.problem)
    before = tab.problem["obstacles"][0]["circle"]["center"]
    tab.page.locator('[data-handle="center-0"]').focus()
    tab.press("ArrowRight")
    assert tab.problem["obstacles"][0]["circle"]["center"] == pytest.approx([before[0] + 0.4, before[1]])


def test_a_plan_avoids_them_and_says_what_is_left(tab, between):
    tab.open(between).plan()
    assert tab.chip == "solved by refine"
    problem = problem_from(between).problem
    stored = tab.found
    left = stored["summary"]["margins"]["clearance"]
    assert left > -1e-6
    assert tab.figures["clearance left"] == as_shown(left, 3)
    q = stored["motion"]["q"]
    assert problem.scene.least_margins(q)[0].min() == pytest.approx(left, abs=2e-3)
    tab.screenshot("obstacles")


def test_a_curve_by_hand_through_a_hole_says_what_is_in_the_way(tab, between):
    between["planner"] = {**between["planner"], "kind": "sinusoid", "offset": [0.3], "amplitude": [0.4]}
    between["planner"].pop("starts"), between["planner"].pop("seed")
    between["planner"]["optimizer"] = {"kind": "pso", "population": 8, "iterations": 5, "bounds": [0, 2], "seed": 1}
    tab.open(between, frequency=[1])
    problem = problem_from(between).problem
    wrong = [part for part in tab.motion["wrong"] if part["kind"] == "clearance"]
    assert wrong
    least, _ = problem.scene.least_margins(tab.motion["q"])
    assert max(part["by"] for part in wrong) == pytest.approx(-least.min(), rel=1e-6)
    worst = max(wrong, key=lambda part: part["r"][1] - part["r"][0])
    assert " against obstacle " in worst["text"]
    assert worst["text"] in tab.verdict
    assert tab.chip == "not a motion"


def test_obstacles_are_added_named_and_removed_in_the_form(tab, seed):
    tab.open(seed, frequency=[1])
    tab.page.click("#obstacles summary")
    tab.page.click("[data-add=circle]")
    tab.settle()
    (added,) = tab.problem["obstacles"]
    assert set(added) == {"circle"}
    tab.page.locator('[data-field="obstacles.0.name"] input').fill("post")
    tab.page.locator('[data-field="obstacles.0.name"] input').press("Enter")
    tab.settle()
    tab.page.locator('[data-field="clearance"] input').fill("1.5")
    tab.page.locator('[data-field="clearance"] input').press("Enter")
    tab.settle()
    tab.page.locator('[data-field="arm.thickness"] input').fill("2")
    tab.page.locator('[data-field="arm.thickness"] input').press("Enter")
    tab.settle()
    tab.page.get_by_label("self collision").check()
    tab.settle()
    assert tab.problem["obstacles"][0]["name"] == "post"
    assert (tab.problem["clearance"], tab.problem["self_collision"], tab.problem["arm"]["thickness"]) == (1.5, True, 2)
    assert_shown(tab, tab.problem)
    tab.page.get_by_label("remove obstacle 1").click()
    tab.settle()
    assert "obstacles" not in tab.problem
    tab.press("Control+z")
    assert tab.problem["obstacles"][0]["name"] == "post"


@pytest.mark.parametrize(
    ("entry", "said"),
    [
        ({"circle": {"center": [30, 24], "radius": -1}}, "radius"),
        ({"polygon": [[0, 0], [10, 10], [10, 0], [0, 10]]}, "polygon"),
        ({"sphere": {"center": [1, 2, 3], "radius": 1}}, "planar"),
        ({"circle": {"center": [30, 24]}}, "radius"),
    ],
)
def test_a_malformed_obstacle_is_a_clear_message_and_the_form_mends_it(tab, seed, entry, said):
    tab.open({**seed, "obstacles": [POST]}, frequency=[1])
    tab.page.evaluate("(entry) => selfmotion.model.changeProblem({ obstacles: [entry] })", entry)
    tab.until("document.querySelector('#verdict .chip').textContent === 'cannot be'")
    assert "obstacles.0" in tab.verdict
    assert said in tab.verdict
    assert "mistake" not in tab.verdict
    tab.press("Control+z")
    assert tab.chip == "sinusoid" or tab.chip == "not a motion"
    tab.watch.check()


def test_obstacles_in_space_are_drawn_in_space(tab):
    data = {
        "arm": {"kind": "named", "name": "panda"},
        "path": {
            "kind": "pose", "orientation": [0, 1, 0, 0],
            "position": {"kind": "line", "start": [0.5, -0.2, 0.4], "end": [0.5, 0.2, 0.4]},
        },
        "obstacles": [
            {"name": "table", "box": {"center": [0.4, 0, 0.1], "size": [0.3, 0.3, 0.1]}},
            {"sphere": {"center": [0, 0.6, 0.5], "radius": 0.1}},
            {"capsule": {"from": [0, -0.6, 0], "to": [0, -0.6, 0.5], "radius": 0.05}},
            {"half_space": {"point": [0, 0, -0.1], "normal": [0, 0, 1]}},
        ],
    }  # fmt: skip
    tab.open(data)
    counts = [tab.page.locator(f"#arm-view .obstacle-{k} .obstacle").count() for k in range(4)]
    assert counts == [12, 3, 4, 18]
    assert tab.page.locator("#arm-view .obstacle-0 title").text_content() == "table"
    tab.screenshot("obstacles_in_space")

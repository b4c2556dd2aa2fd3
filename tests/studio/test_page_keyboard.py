"""The page without a mouse, and for readers of screens."""

import re

import pytest
from browser import planned

CONTROLS = "a[href], button, input, select, textarea, summary, [tabindex]"
MARK = f"""
() => {{
  const seen = [...document.querySelectorAll("{CONTROLS}")].filter((element) =>
    !element.disabled && element.tabIndex >= 0 && element.checkVisibility({{ visibilityProperty: true }}));
  seen.forEach((element, k) => {{ element.dataset.reached = k; }});
  return seen.map((element) => element.id || element.dataset.handle || element.outerHTML.slice(0, 90));
}}
"""
ROLES = {
    "button", "textbox", "slider", "checkbox", "combobox", "spinbutton", "link", "DisclosureTriangle", "application",
    "searchbox", "radio", "switch", "progressbar", "dialog",
}  # fmt: skip


def reach(tab, count):
    """Press Tab often enough to have been everywhere; return what was reached."""
    reached = set()
    for _ in range(count + 5):
        tab.page.keyboard.press("Tab")
        reached.add(tab.page.evaluate("document.activeElement?.dataset?.reached ?? null"))
    return reached - {None}


@pytest.mark.parametrize("mode", ["path", "arm"])
def test_tab_reaches_every_control(tab, seed, mode):
    tab.open(seed, hand={"branch": "positive", "coefficients": [[0.2] * 10]}, frequency=[1])
    if mode == "arm":
        tab.page.click("#arm-modes [data-mode=arm]")
        tab.page.locator("aside summary").evaluate_all(
            "(all) => all.forEach((one) => { one.parentElement.open = true; })"
        )
        tab.settle()
    tab.page.evaluate("document.activeElement.blur()")
    controls = tab.page.evaluate(MARK)
    assert len(controls) > 30
    reached = reach(tab, len(controls))
    missed = [name for k, name in enumerate(controls) if str(k) not in reached]
    assert not missed


def assert_all_named(tab):
    session = tab.page.context.new_cdp_session(tab.page)
    nodes = session.send("Accessibility.getFullAXTree")["nodes"]
    session.detach()
    controls = [node for node in nodes if not node["ignored"] and node.get("role", {}).get("value") in ROLES]
    assert len(controls) > 3
    unnamed = [node["role"]["value"] for node in controls if not node.get("name", {}).get("value", "").strip()]
    assert not unnamed, unnamed
    return {node["role"]["value"] for node in controls}


def test_every_control_has_a_name(tab, seed):
    tab.open(seed, hand={"branch": "positive", "coefficients": [[0.2] * 10]}, frequency=[1])
    tab.page.locator("aside summary").evaluate_all("(all) => all.forEach((one) => { one.parentElement.open = true; })")
    tab.settle()
    roles = assert_all_named(tab)
    assert {"button", "slider", "checkbox", "combobox", "textbox", "spinbutton"} <= roles
    tab.page.click("#arm-modes [data-mode=arm]")
    assert_all_named(tab)
    for opener in ("#open", "#save", "#export"):
        tab.page.click(opener)
        tab.settle()
        assert "dialog" in assert_all_named(tab)
        tab.page.keyboard.press("Escape")
        assert tab.page.locator("#dialog").is_hidden()
        assert tab.page.evaluate("document.activeElement.id") == opener[1:]


def test_the_status_says_the_verdict(tab, seed):
    tab.open(seed, frequency=[1])
    status = tab.page.locator("#verdict")
    assert status.get_attribute("role") == "status"
    assert status.get_attribute("aria-live") == "polite"
    session = tab.page.context.new_cdp_session(tab.page)
    tab.plan()
    nodes = session.send("Accessibility.getFullAXTree")["nodes"]
    (said,) = [node for node in nodes if node.get("role", {}).get("value") == "status" and not node["ignored"]][:1]
    by_id = {node["nodeId"]: node for node in nodes}

    def texts(node):
        if node.get("role", {}).get("value") == "StaticText":
            yield node["name"]["value"]
        for child in node.get("childIds", []):
            yield from texts(by_id[child])

    text = " ".join(texts(said))
    assert "solved" in text
    assert f"{planned(seed).cost:.9g}" in text


def test_everything_is_done_by_keys(tab, seed):
    tab.open(seed, frequency=[1])
    keys = tab.page.keyboard
    tab.page.evaluate("document.activeElement.blur()")
    while tab.page.evaluate("document.activeElement.dataset.mode") != "draw":
        keys.press("Tab")
    for _ in range(12):
        keys.press("Tab")
        if tab.page.evaluate("document.activeElement.dataset.handle") == "path-2":
            break
    tab.press("ArrowUp")
    assert tab.problem["path"]["control_points"][2] == pytest.approx([50, 50.4])
    tab.press("Control+z")
    assert tab.problem == seed
    tab.press("Control+Shift+z")
    assert tab.problem["path"]["control_points"][2] == pytest.approx([50, 50.4])
    tab.press("Control+z")
    tab.page.evaluate("document.activeElement.blur()")
    tab.page.locator("#plan").focus()
    keys.press("Enter")
    tab.until("selfmotion.planning.isRunning || selfmotion.planning.planFor(selfmotion.model.state.problem)")
    tab.planned()
    assert tab.found["summary"]["cost"] == planned(seed).cost
    tab.page.evaluate("document.activeElement.blur()")
    keys.press("Space")
    tab.until("selfmotion.player.isPlaying && selfmotion.player.r > 0.01")
    keys.press("Space")
    tab.until("!selfmotion.player.isPlaying")
    assert re.fullmatch(r"r = 0\.\d{3}", tab.page.locator("#place").inner_text())


def test_the_focus_stays_in_a_field_that_was_edited(tab, seed):
    tab.open(seed, frequency=[1])
    field = tab.page.locator('[data-field="optimizer.population"] input')
    field.fill("9")
    tab.press("Enter")
    assert tab.problem["planner"]["optimizer"]["population"] == 9
    assert tab.page.evaluate("document.activeElement.closest('[data-field]')?.dataset.field") == "optimizer.population"
    tab.press("Control+z")  # undoes typing only
    assert tab.page.locator("#undo").is_enabled()

"""The page on large and small screens, light and dark: all of it is seen, nothing runs over."""

import pytest
from browser import Tab

SIZES = {"desk": (1280, 800), "phone": (390, 844), "tablet": (820, 1180)}
PARTS = (
    "header",
    "#verdict",
    "#arm",
    "#domain",
    "#joints",
    "#evolution",
    "#problem",
    "#plan",
    "#arm-view svg",
    "#scrub",
)
OVER = """
() => [...document.querySelectorAll("body *")].filter((element) => {
  const box = element.getBoundingClientRect();
  if (!box.width || !box.height || element.closest("svg, dialog, #text, .legend, .panels, nav, [hidden]")) return false;
  return box.right > innerWidth + 1 || box.left < -1;
}).map((element) => `${element.tagName} ${element.id} ${element.className}`)
"""


@pytest.mark.parametrize("colours", ["light", "dark"])
@pytest.mark.parametrize("size", SIZES)
def test_all_parts_are_seen_and_nothing_runs_over(contexts, server, seed, size, colours):
    width, height = SIZES[size]
    context, watch = contexts([server.home], viewport={"width": width, "height": height}, color_scheme=colours)
    tab = Tab(context.new_page(), server.address, watch).open(seed, frequency=[1])
    tab.plan()
    assert tab.page.evaluate("document.documentElement.scrollWidth <= innerWidth")
    assert tab.page.evaluate(OVER) == []
    for part in PARTS:
        element = tab.page.locator(part)
        element.scroll_into_view_if_needed()
        assert element.is_visible(), part
        box = element.bounding_box()
        assert box["width"] >= 60, part
        assert box["height"] >= 16, part
    for plot in tab.page.locator("svg.plot, svg.arm-view").all():
        box = plot.bounding_box()
        assert box["width"] > 150
        assert box["height"] > 100
    assert tab.page.locator("#domain-view path.region").count() >= 1
    ground = tab.page.evaluate("getComputedStyle(document.querySelector('#arm')).backgroundColor")
    levels = [int(part) for part in ground.removeprefix("rgb(").removesuffix(")").split(",")]
    assert (min(levels) > 200) == (colours == "light")
    tab.page.evaluate("scrollTo(0, 0)")
    tab.screenshot(f"{size}-{colours}")
    tab.page.click("#open")
    tab.settle()
    box = tab.page.locator("#dialog").bounding_box()
    assert box["x"] >= 0
    assert box["x"] + box["width"] <= width
    assert tab.page.evaluate("document.documentElement.scrollWidth <= innerWidth")


def test_on_a_desk_nothing_is_scrolled_to(tab, seed):
    tab.open(seed, frequency=[1])
    assert tab.page.evaluate("document.documentElement.scrollHeight <= innerHeight")
    for part in ("#arm", "#domain", "#joints", "#evolution", "#problem"):
        box = tab.page.locator(part).bounding_box()
        assert box["y"] + box["height"] <= 800


def test_what_is_dragged_by_touch_does_not_scroll_and_the_rest_does(contexts, server, seed):
    context, watch = contexts([server.home], viewport={"width": 390, "height": 844}, has_touch=True, is_mobile=True)
    tab = Tab(context.new_page(), server.address, watch).open(seed, frequency=[1])
    for selector in ("#arm-view .handle", "#domain-view .grip"):
        found = tab.page.locator(selector).evaluate_all("(all) => all.map((one) => getComputedStyle(one).touchAction)")
        assert set(found) == {"none"}, selector
    for plot in ("#arm-view svg", "#domain-view svg.plot"):
        assert tab.page.locator(plot).first.evaluate("(plot) => getComputedStyle(plot).touchAction") == "pan-y"
    assert tab.page.evaluate("document.documentElement.scrollWidth <= innerWidth")

"""What goes in and comes out of the page: files opened, saved and exported, links; none of it can run in the page."""

import base64
import io
import json
import zlib
from xml.etree import ElementTree

import browser
import numpy as np
import pytest
import yaml
from browser import as_shown, by_hand, link_to, planned
from PIL import Image

import robots
import selfmotion as sm
from selfmotion.exchange import problem_from, read_trajectory
from selfmotion.studio.cases import CASES

SVG = "{http://www.w3.org/2000/svg}"
BAD = "<img src=x onerror=window.pwned=1>"
FOREIGN = "# written by hand\narm: {kind: planar, links: [3, 2, 1]}\npath: {kind: line, start: [1, 1], end: [2, 2]}\n"
REFUSED = "Failed to load resource: the server responded with a status of 403"


def downloaded(tab, form, tmp_path):
    with tab.page.expect_download() as waiting:
        tab.page.locator(f'#dialog [data-format="{form}"]').click()
    download = waiting.value
    file = tmp_path / download.suggested_filename
    download.save_as(file)
    return file


def test_a_plan_is_exported_in_all_forms(tab, seed, tmp_path):
    seed["samples"] = 200
    tab.open(seed, frequency=[1])
    tab.plan()
    plan = planned(seed)
    tab.page.click("#export")
    assert "Of the plan." in tab.page.locator("#dialog").inner_text()
    csv = downloaded(tab, "csv", tmp_path)
    assert csv.name == "trajectory.csv"
    rows = read_trajectory(csv, 3)
    assert np.allclose(rows.q, plan(rows.r), rtol=0, atol=1e-9)
    stored = downloaded(tab, "plan", tmp_path)
    assert stored.name == "plan.selfmotion.json"
    assert sm.load_plan(stored).cost == plan.cost
    png = downloaded(tab, "png", tmp_path)
    assert (png.name, png.read_bytes()[:8]) == ("motion.png", b"\x89PNG\r\n\x1a\n")
    with Image.open(png) as image:
        assert min(image.size) > 300
    result = downloaded(tab, "json", tmp_path)
    assert json.loads(result.read_text())["cost"] == plan.cost
    svg = downloaded(tab, "svg", tmp_path)
    assert svg.name == "angle-domain.svg"
    root = ElementTree.parse(svg).getroot()
    assert root.tag == f"{SVG}svg"
    regions = [path for path in root.iter(f"{SVG}path") if path.get("class") == "region"]
    assert regions
    assert all(path.get("fill").startswith("rgb(") for path in regions)
    assert not list(root.iter(f"{SVG}script"))
    tab.page.get_by_role("button", name="close").click()
    assert tab.page.locator("#dialog").is_hidden()


def test_a_curve_by_hand_is_exported_and_animated(tab, seed, tmp_path):
    seed["samples"] = 100
    hand = {"branch": "positive", "coefficients": [[0.3, 0.4, 0.5, 0.5, 0.4, 0.3, 0.2, 0.1]]}
    tab.open(seed, hand=hand)
    plan = by_hand(seed, hand)
    tab.page.click("#export")
    assert "Of the curve moved by hand." in tab.page.locator("#dialog").inner_text()
    rows = read_trajectory(downloaded(tab, "csv", tmp_path), 3)
    assert np.allclose(rows.q, plan(rows.r), rtol=0, atol=1e-9)
    assert sm.load_plan(downloaded(tab, "plan", tmp_path)).cost == pytest.approx(plan.cost, rel=1e-12)
    gif = downloaded(tab, "gif", tmp_path)
    assert (gif.name, gif.read_bytes()[:6]) == ("motion.gif", b"GIF89a")
    with Image.open(gif) as image:
        assert image.n_frames > 10


def test_there_is_nothing_to_export_before_there_is_a_motion(tab, seed):
    seed["planner"] = {"kind": "global"}
    tab.open(seed)
    tab.page.click("#export")
    assert "Plan first" in tab.page.locator("#dialog").inner_text()
    buttons = tab.page.locator("#dialog [data-format]:not([data-format=svg])")
    assert buttons.count() == 5
    assert all(button.is_disabled() for button in buttons.all())


def test_a_copied_link_opens_the_same_state_in_this_browser(tab, seed):
    hand = {"branch": "positive", "coefficients": [[0.3, 0.4, 0.5, 0.5, 0.4, 0.3, 0.2, 0.1]]}
    tab.watch.allow(REFUSED)
    tab.open(seed, hand=hand, frequency=[0.8])
    copied = copied_link(tab)
    assert copied.startswith(tab.address.split("?")[0] + "#s=")
    assert "token" not in copied
    second = browser.Tab(tab.page.context.new_page(), copied)
    second.page.goto(copied)
    second.settle(10)
    assert second.value("selfmotion.model.state") == tab.value("selfmotion.model.state")
    assert second.hand == hand
    assert second.motion["cost"] == pytest.approx(by_hand(seed, hand).cost, rel=1e-12)
    assert second.verdict == tab.verdict


def copied_link(tab):
    tab.page.context.grant_permissions(["clipboard-read", "clipboard-write"])
    tab.page.click("#link")
    tab.page.locator("#link", has_text="Link copied").wait_for()
    return tab.page.evaluate("navigator.clipboard.readText()")


def test_a_link_is_shown_where_the_clipboard_is_closed_and_says_the_state(tab, seed):
    tab.open(seed, frequency=[0.8])
    tab.page.evaluate("() => { navigator.clipboard.writeText = () => Promise.reject(new Error('closed')); }")
    tab.page.click("#link")
    shown = tab.page.get_by_label("link", exact=True).input_value()
    packed = shown.partition("#s=")[2]
    text = zlib.decompress(base64.urlsafe_b64decode(packed + "=" * (-len(packed) % 4)), -15)
    assert json.loads(text) == {"problem": seed, "hand": None, "frequency": [0.8], "file": None}


def test_a_link_without_the_token_is_refused_elsewhere(tab, seed, contexts, server):
    tab.open(seed)
    copied = tab.address.split("?")[0] + link_to(problem=seed)
    context, watch = contexts([server.home])
    watch.allow(REFUSED)
    watch.allow(r"404 \(Not Found\)")  # this page has no icon
    page = context.new_page()
    answer = page.goto(copied)
    assert answer.status == 403
    said = page.locator("body").inner_text()
    assert "selfmotion studio" in said
    assert "?token=" in said
    assert server.token not in page.content()


DAMAGED = {
    "letters": "#s=x%&", "nonsense": "#s=AAAA", "cut": None, "no problem": link_to(problem=None),
    "text": link_to(problem="x"), "no mappings": link_to(problem={"arm": 1, "path": 2}),
}  # fmt: skip


@pytest.mark.parametrize("how", DAMAGED)
def test_a_damaged_link_is_said(tab, seed, how):
    link = DAMAGED[how] or link_to(problem=seed)[:90]
    tab.page.goto(tab.address + link)
    if how == "letters":  # not a link of ours at all
        tab.settle()
        assert tab.chip == "sinusoid"
        return
    if how == "no mappings":
        tab.settle()
        assert "arm: is not a mapping" in tab.verdict
        return
    tab.settle()
    assert tab.page.locator("#dialog-title").inner_text() == "This link cannot be read"
    assert tab.page.locator("#dialog [role=alert]").inner_text()
    tab.page.get_by_role("button", name="close").click()
    assert tab.chip == "sinusoid"  # the first example is there
    assert tab.page.locator("#domain-view path.region").count() >= 1


def test_an_example_is_opened(tab):
    tab.open()
    tab.page.click("#open")
    choices = tab.page.locator("#dialog .choices button:not(.file)")
    number = [case.name for case in CASES].index("both-elbows")
    choices.nth(number).wait_for()
    assert choices.count() == len(CASES)
    choices.nth(number).click()
    tab.page.locator("#dialog").wait_for(state="hidden")
    tab.settle()
    assert tab.problem["planner"]["kind"] == "global"
    assert tab.page.locator("#domain-view svg.plot").count() == 2
    tab.press("Control+z")
    assert tab.problem["planner"]["kind"] == "sinusoid"


def test_a_file_is_opened_changed_and_saved_under_a_new_name(tab, seed, folder):
    (folder / "given.yaml").write_text(yaml.safe_dump(seed))
    tab.open()
    tab.page.click("#open")
    tab.page.locator("#dialog .file", has_text="given.yaml").click()
    tab.page.locator("#dialog").wait_for(state="hidden")
    tab.settle()
    assert tab.problem == seed
    assert tab.page.locator("#file").inner_text() == "given.yaml"
    tab.page.get_by_label("link length of joint 1").fill("33")
    tab.press("Enter")
    save_as(tab, "new.yaml")
    tab.page.locator("#dialog").wait_for(state="hidden")
    assert tab.page.locator("#file").inner_text() == "new.yaml"
    changed = {**seed, "arm": {**seed["arm"], "links": [33, 30, 20]}}
    assert yaml.safe_load((folder / "new.yaml").read_text()) == changed
    assert planned(changed).cost == sm.plan(*_loaded(folder / "new.yaml")).cost
    assert yaml.safe_load((folder / "given.yaml").read_text()) == seed


def _loaded(file):
    made = sm.load_problem(file)
    return made.problem, made.planner


def save_as(tab, name):
    tab.page.click("#save")
    tab.page.get_by_label("file", exact=True).fill(name)
    tab.page.get_by_role("button", name="Save", exact=True).last.click()


def test_a_foreign_file_is_replaced_only_when_that_is_said(tab, seed, folder):
    file = folder / "foreign.yaml"
    file.write_text(FOREIGN)
    tab.open(seed, frequency=[1])
    save_as(tab, "foreign.yaml")
    tab.page.locator("#dialog [role=alert]").wait_for()
    assert "foreign.yaml is there and not what selfmotion wrote" in tab.page.locator("#dialog").inner_text()
    assert file.read_text() == FOREIGN
    tab.page.get_by_role("button", name="Replace it").click(timeout=5000)
    tab.page.locator("#dialog").wait_for(state="hidden")
    assert yaml.safe_load(file.read_text()) == seed


@pytest.mark.parametrize("name", ["../out.yaml", "a/b/c.yaml", "no-problem.txt", "", f"{BAD}/../../x.yaml"])
def test_names_that_lead_elsewhere_are_refused(tab, seed, folder, name):
    before = sorted(path.name for path in folder.parent.rglob("*"))
    tab.open(seed, frequency=[1])
    save_as(tab, name)
    tab.page.locator("#dialog [role=alert]").wait_for()
    assert tab.page.locator("#dialog [role=alert]").inner_text().startswith("file")
    assert tab.page.locator("#dialog img").count() == 0
    assert sorted(path.name for path in folder.parent.rglob("*")) == before


def assert_unharmed(tab):
    assert tab.page.evaluate("typeof globalThis.pwned") == "undefined"
    assert tab.page.locator("img, iframe, object, embed").count() == 0
    assert tab.page.locator("script").count() == 2


def test_hostile_names_of_files_are_text(tab, seed, folder):
    names = ['"><img src=x onerror=window.pwned=1>.yaml', "<script>window.pwned=1</script>.yaml", "'+alert(1)+'.yaml"]
    for name in names:
        (folder / name).parent.mkdir(exist_ok=True)
        (folder / name).write_text(yaml.safe_dump(seed))
    tab.open()
    for name in names:
        tab.page.click("#open")
        tab.page.locator("#dialog .file", has_text=name).click()
        tab.page.locator("#dialog").wait_for(state="hidden")
        tab.settle()
        assert tab.page.locator("#file").inner_text() == name
        assert tab.problem == seed
        assert_unharmed(tab)
    tab.page.click("#save")
    assert tab.page.get_by_label("file", exact=True).input_value() == names[-1]
    tab.page.keyboard.press("Escape")
    tab.page.click("#open")
    hostile = {"name": f"{BAD}.yaml", "mimeType": "text/yaml", "buffer": yaml.safe_dump(seed).encode()}
    tab.page.get_by_label("problem file on this machine").set_input_files(hostile)
    tab.page.locator("#dialog").wait_for(state="hidden")
    tab.settle()
    assert tab.page.locator("#file").inner_text() == f"{BAD}.yaml"
    assert_unharmed(tab)


def test_a_file_from_elsewhere_is_opened_and_a_bad_one_is_said(tab, seed):
    tab.open()
    tab.page.click("#open")
    chooser = tab.page.get_by_label("problem file on this machine")
    bad = {"name": "bad.yaml", "mimeType": "text/yaml", "buffer": b"arm: {kind: planar\npath: [" + BAD.encode()}
    chooser.set_input_files(bad)
    said = tab.page.locator("#dialog [role=alert]")
    said.wait_for()
    assert "line" in said.inner_text()
    assert_unharmed(tab)
    good = {"name": "good.yaml", "mimeType": "text/yaml", "buffer": yaml.safe_dump(seed).encode()}
    chooser.set_input_files(good)
    tab.page.locator("#dialog").wait_for(state="hidden")
    tab.settle()
    assert tab.problem == seed
    assert tab.page.locator("#file").inner_text() == "good.yaml"


HOSTILE = {
    "kind of arm": {"arm": {"kind": BAD, "links": [1]}},
    "kind of path": {"path": {"kind": BAD}},
    "kind of planner": {"planner": {"kind": BAD}},
    "field": {BAD: 1},
    "branch": {"elbow": BAD},
    "objective": {"objective": BAD},
    "file": {"path": {"kind": "file", "file": f"{BAD}.csv"}},
    "links": {"arm": {"kind": "planar", "links": [BAD, 1, 2]}},
    "structure": {"arm": {"kind": "planar", "links": {BAD: BAD}, "limits": BAD}},
}


@pytest.mark.parametrize("where", HOSTILE)
def test_hostile_words_in_problems_are_text(tab, seed, where):
    problem = {**seed, **HOSTILE[where]}
    tab.page.goto(tab.address + link_to(problem=problem, file=BAD))
    tab.until("document.querySelector('#verdict .chip') && asked.looks === 0")
    tab.until("document.querySelector('#file').textContent")
    assert tab.page.locator("#file").inner_text() == BAD
    assert tab.chip == "cannot be"
    assert "mistake" not in tab.verdict
    assert "Error" not in tab.verdict
    assert_unharmed(tab)


def test_hostile_names_of_joints_are_text(tab, folder):
    text = robots.XARM7.replace('"joint2"', '"&lt;img src=x onerror=window.pwned=1&gt;"')
    (folder / "arm.urdf").write_text(text)
    problem = {
        "arm": {"kind": "urdf", "file": "arm.urdf"},
        "path": {
            "kind": "pose",
            "position": {"kind": "line", "start": [0.4, -0.1, 0.3], "end": [0.4, 0.1, 0.3]},
            "orientation": [0, 1, 0, 0],
        },
        "samples": 50,
    }
    problem_from(problem, str(folder))
    tab.open(problem)
    tab.page.locator("#joints-view .legend button").nth(1).wait_for()
    assert tab.value("selfmotion.live.scene.joints")[1] == BAD
    assert tab.page.locator("#joints-view .legend button").nth(1).get_attribute("title").startswith(BAD)
    assert_unharmed(tab)


def test_a_path_of_very_many_points_opens_and_the_page_answers(tab, seed, folder):
    r = np.linspace(0, 1, 100_000)
    points = np.stack([55 + 8 * np.cos(7 * r), 10 + 8 * np.sin(7 * r)], axis=-1)
    text = io.StringIO()
    np.savetxt(text, points, delimiter=",", header="x,y", comments="")
    (folder / "many.csv").write_text(text.getvalue())
    data = {**seed, "path": {"kind": "file", "file": "many.csv"}}
    tab.page.goto(tab.address + link_to(problem=data, frequency=[1]))
    tab.settle(20)
    assert tab.motion["holds"]
    assert tab.value("selfmotion.live.scene.path.x").shape[0] < 5000
    tab.page.locator("#frequency").focus()
    tab.press("ArrowRight")
    assert tab.value("selfmotion.model.state.frequency") == [1.01]
    assert tab.figures["cost"] == as_shown(tab.motion["cost"])

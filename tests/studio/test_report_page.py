"""Pages that `selfmotion plan --report` writes: whole in themselves, and what is on them is the library's."""

import json
import re
from pathlib import Path

import numpy as np
import pytest
import yaml
from browser import PATIENCE, Scale, Tab, as_shown, until

import selfmotion as sm
from selfmotion.certificate.verdict import verdict

EXAMPLES = Path(__file__).parents[2] / "examples"
BAD = "<img src=x onerror=window.pwned=1>"
CASES = ["seed_3r", "seed_3r_global", "seed_6r", "panda_circle"]
FOREIGN = b"<p>mine</p>"
TIMES = ("seconds", "time", "wall_time_s")


class Report(Tab):
    """A report in the browser, whose numbers are read from what is drawn and written on it."""

    def open(self, file):
        self.page.goto(file.as_uri())
        until(lambda: self.page.locator("#verdict .chip").count(), PATIENCE)
        return self

    @property
    def table(self):
        rows = self.page.locator("#figures tr").evaluate_all(
            "(all) => all.map((row) => [row.children[0].textContent, row.children[1].textContent])"
        )
        return {name: text.replace("−", "-") for name, text in rows}

    def seek(self, r):
        self.page.locator("#scrub").evaluate(
            "(scrub, r) => { scrub.value = r; scrub.dispatchEvent(new Event('input', { bubbles: true })); }", r
        )


@pytest.fixture
def report(contexts):
    """Open a report where no network can be reached, and nothing but the file itself may be asked for."""

    def make(file, **settings):
        context, watch = contexts([file.as_uri()], **settings)
        context.set_offline(True)
        return Report(context.new_page(), "", watch)

    return make


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    """Write a report of an example once; return the file, the plan, and the text of the problem."""
    known = {}

    def make(name):
        if name not in known:
            from selfmotion.cli import _run

            file = tmp_path_factory.mktemp(name) / "out.html"
            assert _run(["plan", str(EXAMPLES / f"{name}.yaml"), "--report", str(file)]) == 0
            loaded = sm.load_problem(EXAMPLES / f"{name}.yaml")
            known[name] = file, sm.plan(loaded.problem, loaded.planner), (EXAMPLES / f"{name}.yaml").read_text("utf-8")
        return known[name]

    return make


@pytest.mark.parametrize("name", CASES)
def test_a_report_shows_what_the_library_found(report, written, name):
    file, plan, text = written(name)
    assert file.stat().st_size < 3_000_000
    page = report(file).open(file)
    figures, summary = page.figures, plan.summary()
    assert page.chip.startswith("solved by ")
    assert figures["cost"] == as_shown(plan.cost)
    assert figures["chord sum"] == as_shown(plan.cost_sampled)
    if plan.lower_bound is not None:
        assert figures["lower bound"] == as_shown(plan.lower_bound)
        said = verdict(plan.cost, plan.cost_error, plan.certificate.bound, rigorous=plan.certificate.rigorous)
        assert said in page.verdict
    table = page.table
    assert float(table["cost, the objective as an integral"]) == as_shown(summary["cost"], 10)
    assert table["planner"] == summary["planner"]
    assert page.page.locator("#source").text_content() == text
    told, expected = page.page.locator("#settings").text_content(), json.dumps(summary["parameters"])
    assert without_times(json.loads(told)) == without_times(json.loads(expected))
    assert page.page.locator("#joints-view path.series").count() == plan.problem.arm.n
    assert page.page.locator("#domain-view path.region").count() >= 1
    assert page.page.locator("#evolution-view path.evolution").count() >= 2
    assert page.page.evaluate("document.documentElement.scrollWidth <= innerWidth")
    for r in (0.25, 0.8):
        page.seek(r)
        assert page.page.locator("#place").inner_text() == f"r = {r:.3f}"
        assert np.allclose(*tools(page, plan, r), rtol=0, atol=0.004 * plan.problem.arm.reach)
        angles = page.page.locator("#joints-view .legend output").all_inner_texts()
        shown = [float(angle.replace("−", "-")) for angle in angles]
        assert shown == pytest.approx(list(plan(r)), abs=2e-3)
    page.screenshot(f"report-{name}")
    stored = page.page.locator("#stored a")
    with page.page.expect_download() as waiting:
        stored.click()
    assert sm.load_plan(waiting.value.path()).cost == plan.cost


def without_times(data):
    if isinstance(data, list):
        return [without_times(part) for part in data]
    if isinstance(data, dict):
        return {name: without_times(part) for name, part in data.items() if name not in TIMES}
    return data


def tools(page, plan, r):
    """Return where the tool is drawn, and where the library has it."""
    place = plan.problem.arm.forward(plan(r))
    if plan.problem.arm.dimension != 2:
        said = page.page.locator("#arm-view .readout").inner_text().replace("−", "-")
        return [float(part) for part in said.removeprefix("tool at ").removesuffix(" m").split(",")], place[:3]
    tool = page.page.locator("#arm-view .tool").bounding_box()
    center = tool["x"] + tool["width"] / 2, tool["y"] + tool["height"] / 2
    return scale_of_arm(page, plan).value(*center), place


def scale_of_arm(page, plan):
    box = page.page.locator("#arm-view svg").bounding_box()
    circles = page.page.locator("#arm-view circle.path-start, #arm-view circle.base").evaluate_all(
        "(all) => all.map((one) => [one.getAttribute('cx'), one.getAttribute('cy')].map(Number))"
    )
    values = [plan.problem.path(0.0), plan.problem.arm.joint_positions(plan(0.0))[0]]
    return Scale.through(values, np.array(circles) + np.array([box["x"], box["y"]]))


def test_hovering_and_playing(report, written):
    file, plan, _ = written("seed_3r")
    page = report(file).open(file)
    x, y = page.scale().pixel(0.5, plan.u(0.5)[0])
    page.page.mouse.move(x, y)
    said = page.page.locator("#domain-readout").inner_text().replace("−", "-")
    assert float(re.search(r"θ1 = ([-\d.]+)", said)[1]) == pytest.approx(plan(0.5)[0], abs=1e-2)
    page.page.mouse.click(x, y - 40)
    assert page.page.locator("#place").inner_text().startswith("r = 0.5")
    page.page.locator("#play").click()
    until(lambda: page.page.locator("#place").inner_text() > "r = 0.52")
    page.page.locator("#play").click()


def test_a_press_on_the_curve_of_a_report_seeks_too(report, written):
    file, plan, _ = written("seed_3r")
    page = report(file).open(file)
    page.page.mouse.click(*page.scale().pixel(0.5, plan.u(0.5)[0]))
    page.watch.check()
    assert page.page.locator("#place").inner_text().startswith("r = 0.5")


def test_without_scripts_the_pictures_are_shown(report, written):
    file, *_ = written("seed_3r")
    page = report(file, java_script_enabled=False).page
    page.goto(file.as_uri())
    pictures = page.locator("img")
    assert pictures.count() >= 2
    for picture in pictures.all():
        box = picture.bounding_box()
        assert box["width"] > 200
        assert box["height"] > 100
        assert picture.get_attribute("src").startswith("data:image/png;base64,")
        assert picture.get_attribute("alt")


def test_on_a_small_screen_and_in_the_dark(report, written):
    file, *_ = written("seed_3r_global")
    page = report(file, viewport={"width": 390, "height": 844}, color_scheme="dark").open(file)
    assert page.page.evaluate("document.documentElement.scrollWidth <= innerWidth")
    page.screenshot("report-phone-dark")


def test_hostile_words_are_text(report, tmp_path, seed_file, run):
    seed_file()
    data = json.loads(Path(seed_file()).read_text())
    text = f"# {BAD} </script><script>window.pwned=1</script> {{{{title}}}} <!--\n{yaml.safe_dump(data)}"
    problem = tmp_path / f"{BAD}.yaml"
    problem.write_text(text)
    target = tmp_path / "out.html"
    assert run("plan", str(problem), "--report", str(target))[0] == 0
    page = report(target).open(target)
    assert page.page.evaluate("typeof globalThis.pwned") == "undefined"
    assert page.page.locator("img").count() == 0
    assert BAD in page.page.locator("h1").inner_text()
    assert BAD in page.page.title()
    assert page.page.locator("#source").text_content() == text


def test_a_foreign_file_is_replaced_with_force_only(tmp_path, seed_file, run):
    target = tmp_path / "out.html"
    target.write_bytes(FOREIGN)
    code, _, said = run("plan", seed_file(), "--report", str(target))
    assert code == 2
    assert "--force" in said
    assert target.read_bytes() == FOREIGN
    assert run("plan", seed_file(), "--report", str(target), "--force")[0] == 0
    assert target.read_bytes().startswith(b"<!doctype html>")
    assert run("plan", seed_file(), "--report", str(target))[0] == 0  # its own file may be replaced


def test_a_plan_that_fails_leaves_no_outdated_report(tmp_path, seed_file, run):
    target = tmp_path / "out.html"
    assert run("plan", seed_file(), "--report", str(target))[0] == 0
    far = {"kind": "line", "start": [60, 0], "end": [95, 0]}
    code, *_ = run("plan", seed_file(path=far), "--report", str(target))
    assert code != 0
    assert not target.exists()

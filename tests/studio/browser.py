"""The studio's page in a real browser: what tests open, press, drag and read there."""

import asyncio
import base64
import json
import os
import re
import shutil
import time
import zlib
from contextlib import contextmanager

import numpy as np

import selfmotion as sm
from selfmotion.exchange import problem_from
from selfmotion.motion import Motion
from selfmotion.plans import Plan
from selfmotion.profiles import BSplineProfile, ProfileCurve, SinusoidProfile

try:
    from playwright.sync_api import sync_playwright
except ImportError:
    sync_playwright = None

PATIENCE = 30.0
NAMES = ("chromium", "chromium-browser", "google-chrome")
MISSING = "THE STUDIO WAS NOT TESTED IN A BROWSER: install Debian's package chromium"
MISSING_PLAYWRIGHT = "THE STUDIO WAS NOT TESTED IN A BROWSER: install the package playwright"

# What is still asked of the server: `looks` counts questions without an answer yet, `plans` those for a plan.
_COUNTING = """
(() => {
  const fetched = globalThis.fetch, asked = (globalThis.asked = { looks: 0, plans: 0, all: 0 });
  globalThis.fetch = async (address, ...more) => {
    const kind = String(address).endsWith("/plan") ? "plans" : "looks";
    let open = true;
    const close = () => { if (open) asked[kind] -= 1; open = false; };
    asked[kind] += 1;
    asked.all += 1;
    try {
      const answer = await fetched(address, ...more);
      if (!answer.ok || !answer.body) { close(); return answer; }
      const { getReader } = answer.body, { text } = answer;
      answer.text = async () => { try { return await text.call(answer); } finally { close(); } };
      answer.body.getReader = (...given) => {
        const reader = getReader.apply(answer.body, given), { read } = reader;
        reader.read = async () => {
          try {
            const part = await read.call(reader);
            if (part.done) close();
            return part;
          } catch (error) { close(); throw error; }
        };
        return reader;
      };
      return answer;
    } catch (error) { close(); throw error; }
  };
})();
"""

_PLAIN = """
(value) => {
  const plain = (part) => {
    if (ArrayBuffer.isView(part)) {
      const array = Array.from(part, (x) => (Number.isFinite(x) ? x : String(x)));
      return { array, shape: part.shape ?? [part.length] };
    }
    if (Array.isArray(part)) return part.map(plain);
    if (part === null || typeof part !== "object") return part;
    return Object.fromEntries(Object.entries(part).map(([name, inner]) => [name, plain(inner)]));
  };
  return JSON.stringify(plain(value ?? null));
}
"""


def chromium():
    """Return where Chromium is, None if it is nowhere."""
    given = os.environ.get("SELFMOTION_CHROMIUM")
    return given or next((found for name in NAMES if (found := shutil.which(name))), None)


def missing():
    """Return why there is no browser, nothing if there is one."""
    if sync_playwright is None:
        return MISSING_PLAYWRIGHT
    return "" if chromium() else MISSING


@contextmanager
def browsing():
    """Give a browser that finds nobody but this machine; Playwright's loop is hidden from tests that have their own."""
    playwright = sync_playwright().start()
    try:
        browser = playwright.chromium.launch(
            executable_path=chromium(),
            args=["--no-sandbox", "--host-resolver-rules=MAP * ~NOTFOUND, EXCLUDE 127.0.0.1"],
        )
        loop = asyncio._get_running_loop()
        asyncio._set_running_loop(None)
        yield browser, loop
        asyncio._set_running_loop(loop)
        browser.close()
    finally:
        playwright.stop()
        asyncio._set_running_loop(None)


def until(true, seconds=PATIENCE, why="it did not come true"):
    """Wait until a function returns something true, and return that."""
    end = time.monotonic() + seconds
    while not (found := true()):
        assert time.monotonic() < end, why
        time.sleep(0.02)
    return found


def link_to(**state):
    """Return the fragment of a link that says a state of the page."""
    packer = zlib.compressobj(9, zlib.DEFLATED, -15)
    packed = packer.compress(json.dumps(state).encode()) + packer.flush()
    return "#s=" + base64.urlsafe_b64encode(packed).decode().rstrip("=")


def unpacked(value):
    """Return what the page knows with its arrays as numpy's."""
    if isinstance(value, list):
        return [unpacked(part) for part in value]
    if not isinstance(value, dict):
        return value
    if set(value) == {"array", "shape"}:
        return np.array([float(x) for x in value["array"]]).reshape(value["shape"])
    return {name: unpacked(part) for name, part in value.items()}


def as_shown(value, digits=9):
    """Return a number rounded as the page rounds what it shows."""
    return float(f"{value:.{digits - 1}e}")


def planned(data):
    """Return what the library plans for the data of a problem file."""
    made = problem_from(data)
    return sm.plan(made.problem, made.planner)


def by_curve(data, profile, a, branch=0):
    """Return the motion of a problem along a curve of a family, as a plan."""
    problem = problem_from(data).problem
    nodes = max(2 * problem.samples, int(16 * profile.cycles(a)))
    return Plan(problem, Motion(problem.arm, problem.path, ProfileCurve(profile, a), branch, nodes), "curve", {})


def by_hand(data, hand):
    """Return the motion along a curve as the page keeps it, as a plan."""
    rows = np.array(hand["coefficients"])
    branch = problem_from(data).problem.arm.branches.index(hand["branch"])
    return by_curve(data, BSplineProfile(*rows.shape), rows.ravel(), branch)


def by_sinusoid(data, frequency):
    """Return the motion along the sinusoid of a problem's planner, as a plan."""
    told = data["planner"]
    return by_curve(data, SinusoidProfile(told["offset"], told["amplitude"]), np.array(frequency))


class Watch:
    """Everything in a context that ought not to be: words on the console, errors, requests to others."""

    def __init__(self, context, homes):
        self.homes = (*homes, "data:", "blob:")
        self.found, self.allowed, self.requests = [], [], []
        context.on("console", lambda said: self._note(said.type in ("error", "warning"), f"{said.type}: {said.text}"))
        context.on("weberror", lambda error: self._note(True, f"page error: {error.error}"))
        context.on("request", self._request)

    def _request(self, request):
        self.requests.append(request.url)
        self._note(not request.url.startswith(self.homes), f"request: {request.url}")

    def _note(self, bad, text):
        if bad:
            self.found.append(text)

    def allow(self, pattern):
        """Say what is expected on the console."""
        self.allowed.append(pattern)

    def check(self):
        found, self.found = self.found, []
        left = [text for text in found if not any(re.search(pattern, text) for pattern in self.allowed)]
        assert not left, "\n".join(left)


class Scale:
    """How pixels of the window and numbers of a diagram go together: ``pixel = start + step * value``, per axis."""

    def __init__(self, x, y):
        self.x, self.y = x, y

    @classmethod
    def through(cls, values, pixels):
        """Return the scale of points (k, 2) and the pixels (k, 2) that they are seen at."""
        values, pixels = np.asarray(values, dtype=float), np.asarray(pixels, dtype=float)
        return cls(*(np.polyfit(values[:, k], pixels[:, k], 1) for k in (0, 1)))

    def pixel(self, x, y):
        return float(np.polyval(self.x, x)), float(np.polyval(self.y, y))

    def value(self, x, y):
        return (x - self.x[1]) / self.x[0], (y - self.y[1]) / self.y[0]


class Tab:
    """A page of the studio."""

    def __init__(self, page, address, watch=None):
        self.page, self.address, self.watch = page, address, watch
        page.set_default_timeout(1000 * PATIENCE)
        page.add_init_script(_COUNTING)

    def open(self, problem=None, **state):
        """Open the page, with a problem and what else is known: hand, frequency, file."""
        link = "" if problem is None else link_to(problem=problem, **state)
        self.page.goto(self.address + link)
        return self.settle()

    def value(self, expression):
        """Return the value of an expression in the page, arrays as numpy's."""
        return unpacked(json.loads(self.page.evaluate(f"() => ({_PLAIN})({expression})")))

    def until(self, expression, seconds=PATIENCE):
        """Wait until an expression in the page is true."""
        return until(
            lambda: self.page.evaluate(f"() => Boolean({expression})"), seconds, f"{expression} never became true"
        )

    def settle(self, seconds=PATIENCE):
        """Wait until nothing more is asked of the server and what came is drawn."""
        self.until(
            "globalThis.selfmotion?.model.state.problem && document.querySelector('#planner-form').children.length",
            seconds,
        )
        self.until("asked.looks === 0 && !document.querySelector('#domain-view.waiting')", seconds)
        return self

    @property
    def problem(self):
        return self.value("selfmotion.model.state.problem")

    @property
    def hand(self):
        return self.value("selfmotion.model.state.hand")

    @property
    def motion(self):
        return self.value("selfmotion.motion()")

    @property
    def found(self):
        """The plan for the problem shown."""
        return self.value("selfmotion.planning.planFor(selfmotion.model.state.problem)")

    @property
    def verdict(self):
        return self.page.locator("#verdict").inner_text().replace("\n", " ")

    @property
    def chip(self):
        return self.page.locator("#verdict .chip").inner_text()

    @property
    def figures(self):
        """Numbers of the verdict by their names."""
        pairs = self.page.locator("#verdict .figure:has(small)").evaluate_all(
            "(all) => all.map((one) => [one.firstChild.textContent, one.lastChild.textContent])"
        )
        return {name: float(re.search(r"[-\d.e]+", value.replace("−", "-"))[0]) for name, value in pairs}

    def plan(self, seconds=60.0):
        """Plan, and wait for the plan."""
        self.page.click("#plan")
        return self.planned(seconds)

    def planned(self, seconds=60.0):
        self.until("!selfmotion.planning.isRunning && asked.plans === 0", seconds)
        return self.settle()

    def press(self, keys, times=1):
        for _ in range(times):
            self.page.keyboard.press(keys)
            self.settle()
        return self

    def drag(self, start, *ways, release=True):
        """Drag with the mouse from a pixel over others, in small steps."""
        mouse = self.page.mouse
        mouse.move(*start)
        mouse.down()
        for way in ways:
            mouse.move(*way, steps=8)
        if release:
            mouse.up()
        return self.settle()

    def scale(self, panel=0):
        """Return the scale of a panel of the angle domain, as its ticks tell it."""
        return self.scale_of(self.page.locator("#domain-view svg.plot").nth(panel))

    def scale_of(self, plot):
        ticks = plot.evaluate(
            """(root) => {
              const box = root.getBoundingClientRect();
              return [...root.querySelectorAll(".tick")].map((tick) => ({
                across: tick.getAttribute("text-anchor") === "middle",
                value: Number(tick.textContent.replace("−", "-")),
                x: box.x + Number(tick.getAttribute("x")), y: box.y + Number(tick.getAttribute("y")) - 3.5,
              }));
            }"""
        )
        across = [tick for tick in ticks if tick["across"]]
        up = [tick for tick in ticks if not tick["across"]]
        x = np.polyfit([tick["value"] for tick in across], [tick["x"] for tick in across], 1)
        y = np.polyfit([tick["value"] for tick in up], [tick["y"] for tick in up], 1)
        return Scale(x, y)

    def drawn(self, selector, panel=0):
        """Return the lines of the paths of a panel that a selector finds, each an array (k, 2) of (r, u)."""
        plot = self.page.locator("#domain-view svg.plot").nth(panel)
        box, scale = plot.bounding_box(), self.scale(panel)
        texts = plot.locator(selector).evaluate_all("(all) => all.map((path) => path.getAttribute('d'))")
        lines = []
        for text in texts:
            for part in text.replace("Z", "").split("M")[1:]:
                points = np.array([[float(x) for x in pair.split()] for pair in part.split("L")])
                lines.append(np.stack(scale.value(points[:, 0] + box["x"], points[:, 1] + box["y"]), axis=-1))
        return lines

    def handle(self, name):
        """Return the middle of a handle of the arm's picture, in pixels."""
        box = self.page.locator(f'#arm-view [data-handle="{name}"]').bounding_box()
        return box["x"] + box["width"] / 2, box["y"] + box["height"] / 2

    def arm_scale(self):
        """Return the scale of the plane arm's picture, as the path drawn in it tells."""
        self.page.locator("#arm-view path.path").first.wait_for()
        box = self.page.locator("#arm-view svg").bounding_box()
        text = self.page.locator("#arm-view path.path").first.get_attribute("d")
        pixels = np.array([[float(x) for x in pair.split()] for pair in text.removeprefix("M").split("L")])
        return Scale.through(self.value("selfmotion.live.scene.path.x"), pixels + np.array([box["x"], box["y"]]))

    def grip(self, r, panel=0):
        """Return the pixel of the curve shown at r."""
        motion = self.motion
        k = int(np.argmin(np.abs(motion["r"] - r)))
        return self.scale(panel).pixel(motion["r"][k], motion["u"][k, 0])

    def screenshot(self, name):
        """Keep a picture of the page if the environment names a folder for them."""
        folder = os.environ.get("SELFMOTION_SCREENSHOTS")
        if folder:
            os.makedirs(folder, exist_ok=True)
            self.page.screenshot(path=os.path.join(folder, f"{name}.png"))

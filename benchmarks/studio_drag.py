"""Time in the studio's page from a pointer's move to the picture: the curve dragged, then a control point.

The seed's 3R arm at 1000 samples, in Chromium, a move every 16 ms as a screen has them; the page itself takes
the times, from the change to the picture. While one answer is awaited, newer moves wait, and only the latest counts.
Run alone, on a quiet machine: ``python benchmarks/studio_drag.py``; it needs playwright and Debian's package chromium.
"""

import os
import shutil
import subprocess
import sys
import tempfile

import numpy as np
from playwright.sync_api import sync_playwright

STEPS = 200
BETWEEN = 16  # [ms]
WAIT = 30_000  # [ms]
CHROMIUM = os.environ.get("SELFMOTION_CHROMIUM") or shutil.which("chromium") or shutil.which("google-chrome")
MIDDLE = """
() => {
  const curve = document.querySelector("#domain-view .grip"), box = curve.ownerSVGElement.getBoundingClientRect();
  const at = curve.getPointAtLength(curve.getTotalLength() / 2);
  return [at.x + box.x, at.y + box.y];
}
"""


DRAG = """
async ([[x, y], [across, down], steps, between]) => {
  const send = (type, a, b) => (type === "pointerdown" ? document.elementFromPoint(a, b) : window).dispatchEvent(
    new PointerEvent(type, { clientX: a, clientY: b, button: 0, buttons: 1, pointerId: 1, bubbles: true }));
  selfmotion.live.timings.length = selfmotion.live.redraws.length = 0;
  send("pointerdown", x, y);
  for (let k = 1; k <= steps; k += 1) {
    const part = Math.sin((2 * Math.PI * k) / steps);
    send("pointermove", x + across * part, y + down * part);
    await new Promise((done) => { setTimeout(done, between); });
  }
  send("pointerup", x, y);
  await new Promise((done) => { setTimeout(done, 500); });
  return [[...selfmotion.live.redraws], [...selfmotion.live.timings]];
}
"""


def dragged(page, start, way):
    """Drag from a pixel there and back along a way; return what pictures took, without and with the wait [ms].

    The events are made in the page: a driver that sends them takes half of two cores.
    """
    return np.array(page.evaluate(DRAG, [list(start), list(way), STEPS, BETWEEN]))


def main():
    """Print medians, 95 % quantiles and the longest times."""
    command = [sys.executable, "-m", "selfmotion", "studio", "--no-browser", "--folder", tempfile.mkdtemp()]
    server = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    try:
        address = server.stdout.readline().strip()
        with sync_playwright() as playwright:
            browser = playwright.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox"])
            page = browser.new_page(viewport={"width": 1280, "height": 800})
            page.goto(address)
            page.locator("#domain-view path.region").first.wait_for(timeout=WAIT)
            samples = page.evaluate("() => selfmotion.live.scene.samples")
            page.locator("#domain-view .grip").first.wait_for(state="attached", timeout=WAIT)
            page.wait_for_timeout(3000)  # the worker gets warm
            print(f"3R, {samples} samples, {STEPS} moves {BETWEEN} ms apart [ms]: asked, computed, told and drawn;")
            print("and from the move that it shows, the wait for the picture before it included")
            print(f"{'dragged':<16}{'pictures':>9}" + 2 * f"{'median':>9}{'95 %':>7}{'max':>7}")
            box = page.locator('[data-handle="path-2"]').bounding_box()
            handle = [box["x"] + box["width"] / 2, box["y"] + box["height"] / 2]
            for name, start, way in (("curve", page.evaluate(MIDDLE), (0, 25)), ("control point", handle, (-20, 20))):
                both = dragged(page, start, way)
                figures = [(np.median(took), np.quantile(took, 0.95), took.max()) for took in both]
                print(f"{name:<16}{both.shape[1]:>9}" + "".join(f"{a:>9.1f}{b:>7.1f}{c:>7.1f}" for a, b, c in figures))
            browser.close()
    finally:
        server.terminate()
        server.wait()


if __name__ == "__main__":
    main()

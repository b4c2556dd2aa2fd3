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


def dragged(page, start, way):
    """Drag from a pixel there and back along a way; return the milliseconds that the page took."""
    page.evaluate("() => { selfmotion.live.timings.length = 0; }")
    page.mouse.move(*start)
    page.mouse.down()
    for k in range(1, STEPS + 1):
        part = np.sin(2 * np.pi * k / STEPS)
        page.mouse.move(start[0] + way[0] * part, start[1] + way[1] * part)
        page.wait_for_timeout(BETWEEN)
    page.mouse.up()
    page.wait_for_timeout(500)
    return np.array(page.evaluate("() => [...selfmotion.live.timings]"))


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
            print(f"3R, {samples} samples, {STEPS} moves {BETWEEN} ms apart; from the change to the picture [ms]")
            print(f"{'dragged':<16}{'pictures':>9}{'median':>9}{'95 %':>9}{'max':>9}")
            box = page.locator('[data-handle="path-2"]').bounding_box()
            handle = [box["x"] + box["width"] / 2, box["y"] + box["height"] / 2]
            for name, start, way in (("curve", page.evaluate(MIDDLE), (0, 25)), ("control point", handle, (-20, 20))):
                took = dragged(page, start, way)
                figures = (np.median(took), np.quantile(took, 0.95), took.max())
                print(f"{name:<16}{len(took):>9}" + "".join(f"{value:>9.1f}" for value in figures))
            browser.close()
    finally:
        server.terminate()
        server.wait()


if __name__ == "__main__":
    main()

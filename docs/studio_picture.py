"""Makes the picture of the studio in these pages: python docs/studio_picture.py (needs chromium and playwright)."""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path

from playwright.sync_api import sync_playwright

PICTURE = Path(__file__).parent / "_static" / "studio.png"
SIZE = {"width": 1280, "height": 800}


def main() -> None:
    """Plan the paper's example, bend its curve by hand, and take the picture."""
    command = [sys.executable, "-m", "selfmotion", "studio", "--no-browser"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as server:
        try:
            address = server.stdout.readline().strip()  # type: ignore[union-attr]
            with sync_playwright() as driver:
                browser = driver.chromium.launch(executable_path=shutil.which("chromium"), args=["--no-sandbox"])
                page = browser.new_page(viewport=SIZE, color_scheme="light")
                page.goto(address)
                page.click("#open")
                page.locator("#dialog .choices button").nth(1).click()  # the shortest motion of the paper's arm
                page.click("#plan")
                page.wait_for_selector("#curves [data-curve=plan][aria-pressed=true]", timeout=120_000)
                grip = "#domain-view .grip"
                x, y = page.locator(grip).first.evaluate(
                    "path => { const at = path.getPointAtLength(0.72 * path.getTotalLength());"
                    " const box = path.ownerSVGElement.getBoundingClientRect(); return [at.x + box.x, at.y + box.y]; }"
                )
                page.mouse.move(x, y)
                page.mouse.down()
                page.mouse.move(x, y + 70, steps=10)
                page.mouse.up()
                page.wait_for_selector("#verdict .chip.hand")
                page.locator("#scrub").evaluate(
                    "slider => { slider.value = 0.7; slider.dispatchEvent(new Event('input')); }"
                )
                page.mouse.move(640, 60)
                page.wait_for_timeout(600)
                page.screenshot(path=PICTURE)
                browser.close()
        finally:
            server.terminate()


if __name__ == "__main__":
    main()

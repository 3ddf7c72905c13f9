#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-2-Clause
"""The report in a headless Chromium: no complaint on the console, nothing loaded from anywhere, the 3D view is drawn
and its slider moves it, also on a phone: with three.js of npm and of Debian's package, whichever are there. Skipped
(77) without Chromium (scripts/setup --browser) or three.js (--view, --npm).

Usage: report_browser_test.py NODE_MODULES
"""
import subprocess
import sys
import tempfile
from pathlib import Path

from browser import Browser, find_chromium
from small_run import FRAMES, write_run

ROOT = Path(__file__).resolve().parents[3]
sys.path.insert(0, str(ROOT / "scripts"))
from page import document  # noqa: E402
SKIPPED = 77
# Colours in the picture of the view, in a grid of its pixels.
COLOURS = """(async () => {
  const image = new Image();
  image.src = facetView.picture();
  await image.decode();
  const paper = new OffscreenCanvas(160, 120).getContext("2d");
  paper.drawImage(image, 0, 0, 160, 120);
  const data = paper.getImageData(0, 0, 160, 120).data;
  const seen = new Set();
  for (let i = 0; i < data.length; i += 4) {
    seen.add([data[i] >> 4, data[i + 1] >> 4, data[i + 2] >> 4, data[i + 3] >> 6].join());
  }
  return seen.size;
})()"""


def make_report(folder, modules):
    errors = [0.001 * (1 + i % 7) for i in range(FRAMES)]
    runs = [write_run(folder / mode, mode, errors=errors) for mode in ("s", "spr")]
    out = folder / "report.html"
    command = [ROOT / "scripts/report", *runs, "--out", out, "--no-pictures", "--modules", modules]
    done = subprocess.run([sys.executable, *map(str, command)], capture_output=True, text=True, check=False)
    assert done.returncode == 0 and not done.stderr, done.stderr
    return out


def press(browser, key, code):
    for kind in ("keyDown", "keyUp"):
        browser.call("Input.dispatchKeyEvent", type=kind, key=key, code=key, windowsVirtualKeyCode=code)


def check_view(browser):
    """The slider moves time, faces, the charts' cursor and the picture; buttons change the colours."""
    browser.wait("globalThis.facetView && facetView.run")
    assert browser.evaluate(COLOURS) > 8, "the canvas is blank"
    slider = "document.querySelector('.view input[type=range]')"
    said = "document.querySelector('.view .said').textContent"
    whole = browser.evaluate("facetView.picture()")
    assert "keyframe 32 of 32, 60 faces" in browser.evaluate(said), browser.evaluate(said)
    browser.evaluate(f"{slider}.focus()")
    press(browser, "Home", 36)
    browser.wait(f"{slider}.value === '0'")
    assert "keyframe 1 of 32, 1 faces" in browser.evaluate(said), browser.evaluate(said)
    assert browser.evaluate("facetView.picture()") != whole, "the slider changes nothing"
    for _ in range(8):
        press(browser, "ArrowRight", 39)
    assert browser.evaluate("document.querySelector('.view output').value") == "2.00 s"
    cursor = browser.evaluate("(({x1, x0}, x) => [+x0, x])((line => line.dataset)(document.querySelector('line.now')),"
                              "+document.querySelector('line.now').getAttribute('x1'))")
    assert cursor[1] > cursor[0] + 20, cursor
    plain = browser.evaluate("facetView.picture()")
    browser.evaluate("[...document.querySelectorAll('.segments button')].find(b => b.textContent.startsWith('Dist'))"
                     ".click()")
    assert browser.evaluate("facetView.state.look") == "distance"
    assert browser.evaluate("facetView.picture()") != plain, "the colours do not change"
    browser.evaluate("[...document.querySelectorAll('.segments button')].find(b => b.textContent === 'spr').click()")
    assert browser.evaluate("facetView.run.label") == "spr"


def check_page(page, width, height):
    with Browser(width, height) as browser:
        browser.call("Network.enable")
        browser.open(page.as_uri())
        check_view(browser)
        browser.evaluate("location.hash = 'run=0&look=sigma&keyframe=4&space=1'")
        browser.wait("facetView.state.look === 'sigma' && facetView.run.label === 's'")
        shown = browser.evaluate("[facetView.state.keyframe, facetView.shown.space]")
        assert shown == [4, True], (shown, browser.problems)
        sideways = browser.evaluate("document.documentElement.scrollWidth - innerWidth")
        assert sideways <= 0, f"{sideways} px wider than the screen of {width} px"
        elsewhere = [address for address in browser.requests if not address.startswith(("file:", "data:", "blob:"))]
        assert not elsewhere, elsewhere
        assert not browser.problems, browser.problems


def main():
    modules = Path(sys.argv[1])
    with tempfile.TemporaryDirectory() as name:
        none = Path(name, "none")  # then Debian's are taken
        sources = [path for path in (modules, none) if document.has_bundler(path)]
        if not find_chromium() or not sources:
            print("skipped: no Chromium, or no three.js and esbuild: scripts/setup --browser --view")
            return SKIPPED
        for source in sources:
            folder = Path(name, source.name)
            folder.mkdir()
            page = make_report(folder, source)
            for width, height in ((1366, 900), (390, 844)):
                check_page(page, width, height)
    return 0


if __name__ == "__main__":
    sys.exit(main())

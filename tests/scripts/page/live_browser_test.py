#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-2-Clause
"""The live view in a headless Chromium: a simulated flight is replayed in real time, and frames, meshes and the path
arrive in the page, whose address has the token; its closing changes nothing in the flight. Skipped (77) without
Chromium or three.js.

Usage: live_browser_test.py NODE_MODULES FACET...      the program, after the emulator that runs it if there is one
"""
import re
import subprocess
import sys
import tempfile
from pathlib import Path

from browser import Browser, find_chromium

ROOT = Path(__file__).resolve().parents[3]
sys.path.insert(0, str(ROOT / "scripts"))
from page import document  # noqa: E402

SKIPPED = 77


def watch(browser, address):
    browser.open(address)
    browser.wait("globalThis.facetView && facetView.received.frames > 10 && facetView.received.meshes > 0")
    browser.wait("facetView.received.pictures > 3 && facetView.received.points > 100 && !facetView.eye.hidden")
    assert browser.evaluate("[facetView.eye.width, facetView.eye.height].join()") == "376,240"
    badge = "document.querySelector('.badge')"
    assert browser.evaluate(f"[{badge}.textContent, {badge}.className].join()") == "TRACKING,badge state-tracking"
    assert ", quality " in browser.evaluate("document.querySelector('.said').textContent")
    browser.wait("facetView.mesh.geometry.attributes.position.count > 300")
    browser.wait("facetView.received.pieces > 50 && facetView.surface.group.children.length > 5")
    assert browser.evaluate("facetView.surface.group.visible && !facetView.mesh.visible && facetView.boxes.map.checked")
    browser.evaluate("globalThis.before = {picture: facetView.picture(), count: facetView.count}")
    browser.wait("facetView.count > before.count + 5 && facetView.picture() !== before.picture")
    assert not browser.problems, browser.problems


def main():
    modules, program = Path(sys.argv[1]), sys.argv[2:]
    if not find_chromium() or not document.has_bundler(modules):
        print("skipped: no Chromium, or no three.js and esbuild: scripts/setup --browser --view")
        return SKIPPED
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        page = folder / "live.html"
        subprocess.run([sys.executable, ROOT / "scripts/report", "--live", page, "--modules", modules], check=True)
        simulate = ["sim", "--scene", "room", "--out", folder / "log", "--duration", "8", "--samples", "1",
                    "--stand", "1"]
        subprocess.run([*program, *simulate], check=True, capture_output=True)
        token = folder / "token"
        token.write_text("0123456789abcdef\n")
        replay = [*program, "replay", folder / "log", "--quiet", "--out"]
        # The browser first: on a busy machine its start may take longer than the flight.
        with Browser(1000, 700) as browser, \
                subprocess.Popen([*replay, folder / "seen", "--realtime", "--view", "0", "--view-page", page,
                                  "--view-token", token],
                                 stderr=subprocess.PIPE, stdout=subprocess.DEVNULL, text=True) as flight:
            address = re.search(r"http://127\.0\.0\.1:\d+/", flight.stderr.readline()).group(0)
            watch(browser, f"{address}#token={token.read_text().strip()}")
            flight.stderr.read()
            assert flight.wait(60) == 0
        subprocess.run([*replay, folder / "unseen"], check=True, capture_output=True)
        seen, unseen = ((folder / which / "trajectory.csv").read_bytes() for which in ("seen", "unseen"))
        assert seen == unseen, "the trajectory differs"
    return 0


if __name__ == "__main__":
    sys.exit(main())

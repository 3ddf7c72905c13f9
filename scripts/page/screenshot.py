# SPDX-License-Identifier: BSD-2-Clause
"""A small picture of what a browser shows of a report, for documents."""
import os
import pathlib
import shutil
import subprocess

try:
    from PIL import Image
except ImportError:
    Image = None

SIZE = (1180, 800)
WAIT_MS = 4000


def take(page, out, view=""):
    """Writes a PNG of the top of a page; `view` chooses what its 3D view shows, as the page's address does.

    One sentence if it cannot be made, or None.
    """
    program = shutil.which("chromium") or shutil.which("chromium-browser")
    if not program or Image is None:
        return "No screenshot: it needs Chromium and PIL (scripts/setup --browser --plots)."
    out = pathlib.Path(out).resolve()
    options = ["--headless=new", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--hide-scrollbars",
               "--disable-dev-shm-usage", f"--window-size={SIZE[0]},{SIZE[1]}", f"--virtual-time-budget={WAIT_MS}",
               f"--screenshot={out}"]
    if os.geteuid() == 0:
        options.append("--no-sandbox")  # it does not start as root otherwise
    address = pathlib.Path(page).resolve().as_uri() + (f"#{view}" if view else "")
    done = subprocess.run([program, *options, address], capture_output=True, text=True, check=False)
    if done.returncode != 0 or not out.is_file():
        return f"No screenshot: {(done.stderr.strip().splitlines() or ['Chromium says nothing'])[-1]}"
    # Few colours make a small file; those of single chips must be among them.
    few = Image.open(out).convert("RGB").quantize(256, method=Image.Quantize.MAXCOVERAGE, dither=Image.Dither.NONE)
    few.save(out, optimize=True)
    return None

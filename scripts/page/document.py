# SPDX-License-Identifier: BSD-2-Clause
"""Puts the report together: one HTML file with everything in it."""
import base64
import datetime
import html
import json
import os
import pathlib
import shutil
import subprocess
import tempfile

from page import faults, figures, scene, tables

HERE = pathlib.Path(__file__).resolve().parent
NO_THREE = ("The interactive 3D view is left out: three.js and esbuild are not installed "
            "(scripts/setup --view installs them).")
# Where Debian's packages libjs-three and esbuild put them.
DEBIAN_THREE = pathlib.Path("/usr/share/javascript/three")
DEBIAN_ESBUILD = pathlib.Path("/usr/bin/esbuild")


def has_npm(modules):
    return (modules / ".bin/esbuild").exists() and (modules / "three").is_dir() and shutil.which("node") is not None


def has_bundler(modules):
    """Whether npm has installed three.js and esbuild below `modules`, or Debian's packages are there."""
    return has_npm(modules) or (DEBIAN_ESBUILD.exists() and (DEBIAN_THREE / "examples/jsm").is_dir())


def bundler(modules, folder):
    """esbuild, and the folder that it finds three.js in: Debian's is laid out as npm's below `folder`."""
    if has_npm(modules):
        return modules / ".bin/esbuild", modules
    three = folder / "three"
    three.mkdir()
    (three / "package.json").write_text('{"name": "three", "module": "build/three.module.js"}', encoding="utf-8")
    (three / "build").symlink_to(DEBIAN_THREE / "build")
    (three / "addons").symlink_to(DEBIAN_THREE / "examples/jsm")
    return DEBIAN_ESBUILD, folder


def bundled_view(modules, source="view.js"):
    """A source, by default view.js, and what it needs of three.js as one script, or None and one sentence why."""
    if not has_bundler(modules):
        return None, NO_THREE
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        esbuild, packages = bundler(modules, folder)
        out = folder / "view.js"
        command = [esbuild, HERE / source, "--bundle", "--minify", "--format=iife", "--legal-comments=inline",
                   "--charset=ascii", "--log-level=error", f"--outfile={out}"]
        done = subprocess.run([str(part) for part in command], env={**os.environ, "NODE_PATH": str(packages)},
                              capture_output=True, text=True, check=False)
        if done.returncode != 0 or not out.is_file():
            said = (done.stderr.strip().splitlines() or ["no output"])[0]
            return None, f"The interactive 3D view is left out: esbuild failed: {said}"
        return out.read_text(encoding="utf-8"), ""


def as_script(text):
    """JavaScript or JSON that cannot end its element early."""
    return text.replace("</", "<\\/").replace("<!--", "<\\!--")


def tile(value, unit, what):
    """A figure in large print."""
    return f"<div class='tile'><b>{value} <small>{unit}</small></b><span>{html.escape(what)}</span></div>"


def tiles(sequence):
    """The most important figures of a sequence."""
    shown = []
    for run in sequence.runs:
        error = run.figure("ate_se3", "translation_m", "rmse")
        if error is not None:
            shown.append(tile(f"{100 * error:.2f}", "cm", f"ATE RMSE, {run.label}"))
    for run in sequence.runs:
        median = run.figure("mesh", "by_trajectory", "accuracy_m", "median")
        if median is not None:
            shown.append(tile(f"{100 * median:.2f}", "cm", f"median mesh error, {run.label}"))
    run = sequence.runs[-1]
    path = run.figure("path_m") or run.summary.get("path_m")
    shown.append(tile(f"{path:.1f}", "m", f"path in {figures.time_range(sequence)[1]:.1f} s"))
    frame = (run.summary.get("timing", {}).get("processor", {}).get("all") or {}).get("mean")
    if frame is not None:
        shown.append(tile(f"{frame:.1f}", "ms", f"CPU time per frame, mean, {run.label}"))
    states = run.summary.get("frames_by_state", {})
    total = sum(states.values()) or 1
    shown.append(tile(f"{100 * states.get('TRACKING', 0) / total:.1f}", "%", f"of frames tracking, {run.label}"))
    return f"<div class='tiles'>{''.join(shown)}</div>"


def legend(sequence):
    """Which colour is which run."""
    return "<div class='legend'>" + "".join(
        f"<span><i class='key run{index}'></i>{html.escape(run.label)}</span>"
        for index, run in enumerate(sequence.runs)) + "</div>"


def grid(items):
    """Figures side by side: as many columns as leave no gap, if they can."""
    columns = {0: "", 1: "of2", 2: "of2"}.get(len(items), "of4" if len(items) % 4 == 0 or len(items) > 6 else "")
    return f"<div class='grid-of-figures {columns}'>{''.join(items)}</div>"


def figure_html(figure, sequence):
    """A chart with its caption and legend."""
    below = f"<div class='scale'>0 to {figure.scale} and more</div>" if figure.scale else ""
    below += legend(sequence) if figure.legend else ""
    return (f"<figure><figcaption><b>{html.escape(figure.title)}</b><br>{figure.note}</figcaption>"
            f"{figure.svg}{below}</figure>")


def pictures_html(pictures):
    """Still pictures of the meshes: pairs of a caption and PNG bytes."""
    items = [
        f"<figure><figcaption><b>{html.escape(title)}</b><br>{note}</figcaption><img alt='{html.escape(title)}' "
        f"src='data:image/png;base64,{base64.b64encode(png).decode('ascii')}'></figure>"
        for title, note, png in pictures]
    return f"<h3>Mesh</h3>{grid(items)}" if pictures else ""


def section_html(number, sequence, pictures):
    """All of one sequence."""
    truth = "" if any(run.figure("ate_se3") for run in sequence.runs) else " · no ground truth"
    runs = "; ".join(dict.fromkeys(run.program for run in sequence.runs))
    faults = "; ".join(dict.fromkeys(", ".join(run.summary.get("faults", [])) for run in sequence.runs)).strip("; ")
    note = f"{sequence.runs[0].dataset} · {runs}{truth}" + (f" · injected: {faults}" if faults else "")
    parts = [f"<section id='s{number}' data-sequence='{number}'><h2>{html.escape(sequence.name)}</h2>"
             f"<p class='soft'>{html.escape(note)}</p>", tiles(sequence), pictures_html(pictures)]
    for heading, drawn in figures.all_figures(sequence):
        parts.append(f"<h3>{heading}</h3>{grid([figure_html(figure, sequence) for figure in drawn])}")
    details = "".join(tables.corrections_table(run) for run in sequence.runs)
    parts.append(f"<details><summary>Calibration in figures</summary>{details}</details></section>" if details
                 else "</section>")
    return "".join(parts)


def tables_html(sequences):
    """The tables over all sequences."""
    shown = []
    if tables.is_evaluated(sequences):
        shown = [tables.paper_table(sequences), tables.published_table(sequences), tables.accuracy_table(sequences)]
    return "".join([*shown, tables.mesh_table(sequences), tables.time_table(sequences),
                    tables.optimization_table(sequences)])


def write(path, title, sequences, pictures, modules, notes, matrix=None):
    """Writes the report; returns sentences about what is not in it: `notes`, and why there is no 3D view.

    pictures: for each sequence its still pictures; matrix: a FaultMatrix. Raises OSError.
    """
    script, problem = bundled_view(modules) if modules else (None, "The 3D view was not asked for.")
    view = ""
    if script:
        data = as_script(json.dumps(scene.pack(sequences), separators=(",", ":")))
        view = (f"<h2 id='view'>In 3D</h2><div id='facet-view'></div><script type='application/json' id='facet-data'>"
                f"{data}</script><script>{as_script(script)}</script>")
    links = "".join(f"<a href='#s{number}'>{html.escape(sequence.name)}</a>"
                    for number, sequence in enumerate(sequences))
    links += "<a href='#faults'>When sensors fail</a>" if matrix else ""
    programs = "; ".join(dict.fromkeys(run.program for sequence in sequences for run in sequence.runs))
    made = datetime.datetime.now(datetime.timezone.utc).strftime("%Y-%m-%d %H:%M UTC")
    notes = [*notes, *([problem] if problem else [])]
    said = "".join(f"<p class='soft'>{html.escape(note)}</p>" for note in notes)
    text = f"""<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width, initial-scale=1">
<title>{html.escape(title)}</title><link rel="icon" href="data:,">
<style>{(HERE / 'page.css').read_text()}</style></head>
<body><header><h1>{html.escape(title)}</h1><p class="soft">{html.escape(programs)} · report made {made}</p>
<nav>{"<a href='#view'>3D view</a>" if view else ""}<a href="#tables">Tables</a>{links}</nav></header>
<main><script>{as_script((HERE / 'page.js').read_text())}</script>
{view}{said}<h2 id="tables">Tables</h2>{tables_html(sequences)}
{''.join(section_html(n, *pair) for n, pair in enumerate(zip(sequences, pictures)))}
{faults.section_html(matrix)}
</main><footer>Made by scripts/report from the files of facet replay and facet eval. World: z up, metres.</footer>
</body></html>
"""
    pathlib.Path(path).write_text(text, encoding="utf-8")
    return notes


def write_live(path, modules):
    """Writes the page that --view-page shows; one sentence if it cannot be made, or None."""
    script, problem = bundled_view(modules, "live.js")
    if not script:
        return problem
    pathlib.Path(path).write_text(f"""<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width, initial-scale=1">
<title>facet live</title><link rel="icon" href="data:,"><style>{(HERE / 'page.css').read_text()}</style></head>
<body class="live"><div class="view"><div class="stage"><canvas aria-label="the flight in 3D"></canvas>
<canvas class="eye" hidden aria-label="the left image with its landmarks"></canvas>
<b class="badge" hidden></b><div class="said"></div>
<div class="chips"><label hidden><input type="checkbox" name="map" checked> Map</label>
<label hidden title="over the horizon"><input type="checkbox" name="mesh" checked> Mesh</label>
<label><input type="checkbox" name="follow" checked> Follow</label></div></div></div>
<script>{as_script(script)}</script></body></html>
""", encoding="utf-8")
    return None

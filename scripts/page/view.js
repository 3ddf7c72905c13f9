// SPDX-License-Identifier: BSD-2-Clause
// The 3D view of the report: mesh, planes, path, camera and free space of each run over time. Bundled with three.js by
// document.py. The data are those of scene.py, in the world of the estimate: z up, metres.
import {
  AmbientLight, DirectionalLight, GridHelper, Group, PerspectiveCamera, Scene, Vector3, WebGLRenderer,
} from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";
import {
  CameraPart, clear, cssColour, LIGHT, MeshPart, PathPart, planeColour, Ramp, SpacePart,
} from "./view_parts.js";

function element(tag, options = {}, children = []) {
  const made = Object.assign(document.createElement(tag), options);
  made.append(...children);
  return made;
}

class View {
  constructor(root, data) {
    this.data = data;
    this.state = { sequence: 0, run: 0, look: "planes", keyframe: 0 };
    this.shown = { edges: true, truth: true, camera: true, landmarks: false, space: false, follow: false };
    this.root = root;
    this.makePage();
    this.renderer = new WebGLRenderer({ canvas: this.canvas, antialias: true, alpha: true });
    this.renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
    this.scene = new Scene();
    this.camera = new PerspectiveCamera(50, 1, 0.05, 500);
    this.camera.up.set(0, 0, 1);
    this.light = new DirectionalLight("#ffffff", LIGHT);
    this.scene.add(new AmbientLight("#ffffff", LIGHT), this.camera);
    this.camera.add(this.light);
    this.light.position.set(0.6, 0.9, 0.4);
    this.content = new Group();
    this.scene.add(this.content);
    this.controls = new OrbitControls(this.camera, this.canvas);
    this.controls.addEventListener("change", () => this.draw());
    new ResizeObserver(() => this.resize()).observe(this.stage);
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.load());
    this.load(true);
    this.follow(location.hash);
    window.addEventListener("hashchange", () => this.follow(location.hash));
  }

  // Shows what an address asks for, such as #sequence=0&run=1&look=distance&keyframe=40&space=1.
  follow(address) {
    const asked = new URLSearchParams(address.replace(/^#/, ""));
    const index = (key, count) => Math.min(Math.max(Number(asked.get(key)) || 0, 0), count - 1);
    if (![...asked.values()].some((value) => value)) {
      return;
    }
    for (const key of Object.keys(this.shown)) {
      this.shown[key] = asked.has(key) ? asked.get(key) === "1" : this.shown[key];
    }
    const sequence = index("sequence", this.data.sequences.length);
    const run = index("run", this.data.sequences[sequence].runs.length);
    this.set({ sequence, run, look: asked.get("look") ?? "planes" }, true);
    if (asked.has("keyframe")) {
      this.seek(index("keyframe", this.run.keyframes.times.length));
    }
  }

  get sequence() {
    return this.data.sequences[this.state.sequence];
  }

  get run() {
    return this.sequence.runs[this.state.run];
  }

  makePage() {
    this.canvas = element("canvas", { ariaLabel: "3D view of the run: drag to turn, wheel or two fingers to zoom" });
    this.said = element("div", { className: "said" });
    this.chips = element("div", { className: "chips" });
    this.stage = element("div", { className: "stage" }, [this.canvas, this.said, this.chips]);
    this.choices = element("div", { className: "bars" });
    this.slider = element("input", { type: "range", min: 0, value: 0, step: 1, ariaLabel: "keyframe" });
    this.slider.addEventListener("input", () => this.seek(Number(this.slider.value)));
    this.play = element("button", { className: "play", type: "button", textContent: "\u25b6", ariaLabel: "play" });
    this.play.addEventListener("click", () => this.toggle());
    this.home = element("button", { className: "home", type: "button", textContent: "Whole scene" });
    this.home.addEventListener("click", () => this.frame());
    this.clock = element("output");
    const bar = element("div", { className: "bars" }, [this.play, this.slider, this.clock, this.home]);
    this.root.replaceChildren(element("figure", { className: "view" }, [this.choices, this.stage, bar]));
  }

  segments(options, chosen, onChoose) {
    return element("div", { className: "segments" }, options.map(([value, name]) => {
      const button = element("button", { type: "button", textContent: name });
      button.setAttribute("aria-pressed", String(value === chosen));
      button.addEventListener("click", () => onChoose(value));
      return button;
    }));
  }

  makeChoices() {
    const parts = [];
    if (this.data.sequences.length > 1) {
      const select = element("select", { ariaLabel: "sequence" }, this.data.sequences.map((sequence, index) =>
        element("option", { value: index, textContent: sequence.name, selected: index === this.state.sequence })));
      select.addEventListener("change", () => this.set({ sequence: Number(select.value), run: 0 }, true));
      parts.push(select);
    }
    const runs = this.sequence.runs.map((run, index) => [index, run.label]);
    parts.push(this.segments(runs, this.state.run, (run) => this.set({ run })));
    const { mesh } = this.run;
    const looks = [["planes", "Planes", true], ["distance", "Distance to truth", mesh?.distances],
      ["sigma", "Reported sigma", mesh?.sigmas], ["plain", "Plain", true]].filter(([, , isThere]) => isThere);
    if (!looks.some(([look]) => look === this.state.look)) {
      this.state.look = "planes";
    }
    parts.push(this.segments(looks, this.state.look, (look) => this.set({ look })));
    const boxes = [["edges", "Edges"], ["landmarks", "Landmarks"], ["truth", "True path"], ["camera", "Camera"],
      ["space", "Free space"], ["follow", "Follow"]].filter(([key]) =>
      (key !== "space" || this.run.rays) && (key !== "truth" || this.run.path.truth));
    for (const [key, name] of boxes) {
      const box = element("input", { type: "checkbox", checked: this.shown[key] });
      box.addEventListener("change", () => {
        this.shown[key] = box.checked;
        this.seek(this.state.keyframe);
      });
      parts.push(element("label", {}, [box, name]));
    }
    this.choices.replaceChildren(...parts);
  }

  // Shows what `change` says, or other data; `whole`: looks at all of it from the beginning.
  set(change, whole = false) {
    const time = this.run.keyframes.times[this.state.keyframe];
    Object.assign(this.state, change);
    if (!whole) {
      const times = this.run.keyframes.times;
      const next = times.findIndex((t) => t >= time - 1e-3);
      this.state.keyframe = next < 0 ? times.length - 1 : next;
    }
    this.load(whole);
  }

  load(whole = false) {
    clear(this.content);
    const ramp = new Ramp();
    const { run } = this;
    const colour = cssColour(`--run${this.state.run % 4}`);
    if (whole) {
      this.state.keyframe = run.keyframes.times.length - 1;
    }
    this.makeChoices();
    this.parts = {
      mesh: run.mesh ? new MeshPart(run.mesh, run.planes, ramp) : null, path: new PathPart(run.path, ramp, colour),
      camera: new CameraPart(run.keyframes, colour), space: run.rays ? new SpacePart(run.rays) : null,
    };
    for (const part of Object.values(this.parts)) {
      if (part) {
        this.content.add(part.group);
      }
    }
    this.painted = null;
    this.slider.max = run.keyframes.times.length - 1;
    this.measure();
    this.addFloor();
    this.seek(this.state.keyframe);
    this.resize();
    if (whole) {
      this.frame();
    }
  }

  // Box of the scene without its outliers.
  measure() {
    const all = this.parts.mesh ? this.parts.mesh.vertices : this.parts.path.points;
    const path = this.parts.path.points;
    this.low = new Vector3();
    this.high = new Vector3();
    for (let axis = 0; axis < 3; ++axis) {
      const sorted = all.filter((_, i) => i % 3 === axis).sort();
      const own = path.filter((_, i) => i % 3 === axis);
      const at = (share) => sorted[Math.floor(share * (sorted.length - 1))];
      this.low.setComponent(axis, Math.min(at(0.02), ...own));
      this.high.setComponent(axis, Math.max(at(0.98), ...own));
    }
  }

  addFloor() {
    const size = Math.ceil(Math.max(this.high.x - this.low.x, this.high.y - this.low.y) / 2 + 1) * 2;
    const grid = new GridHelper(size, size, cssColour("--line"), cssColour("--line"));
    grid.rotation.x = Math.PI / 2;
    grid.position.copy(this.low).add(this.high).multiplyScalar(0.5).setZ(this.low.z - 0.02);
    this.content.add(grid);
  }

  frame() {
    const middle = this.low.clone().add(this.high).multiplyScalar(0.5);
    const points = this.parts.mesh ? this.parts.mesh.vertices : this.parts.path.points;
    const step = 3 * Math.ceil(points.length / 3000);
    const seen = [];
    for (let i = 0; i + 2 < points.length; i += step) {
      seen.push(new Vector3(points[i], points[i + 1], points[i + 2]).clamp(this.low, this.high));
    }
    let reach = this.high.distanceTo(this.low);
    const target = middle;
    // From where most of the mesh is not turned away.
    const corners = [[1, -1], [1, 1], [-1, 1], [-1, -1]]
      .map(([x, y]) => new Vector3(0.5 * x, 0.5 * y, 0.7).normalize());
    const areas = corners.map((corner) => this.parts.mesh?.facing(corner) ?? 0);
    const along = corners[areas.indexOf(Math.max(...areas))];
    // Nearer or farther, and to the side, until the points fill the picture.
    for (let round = 0; round < 8; ++round) {
      this.camera.position.copy(target).addScaledVector(along, reach);
      this.camera.lookAt(target);
      this.camera.updateMatrixWorld();
      const at = seen.map((point) => point.clone().project(this.camera));
      const range = (axis) => [Math.min(...at.map((p) => p[axis])), Math.max(...at.map((p) => p[axis]))];
      const [[x0, x1], [y0, y1]] = [range("x"), range("y")];
      const half = reach * Math.tan((this.camera.fov / 2) * (Math.PI / 180));
      const [right, up] = [0, 1].map((column) => new Vector3().setFromMatrixColumn(this.camera.matrixWorld, column));
      target.addScaledVector(right, ((x0 + x1) / 2) * half * this.camera.aspect);
      target.addScaledVector(up, ((y0 + y1) / 2) * half);
      reach *= Math.min(Math.max((x1 - x0) / 1.86, (y1 - y0) / 1.86, 0.5), 2);
    }
    this.controls.target.copy(target);
    this.controls.update();
    this.draw();
  }

  seek(keyframe) {
    const { mesh, path, camera, space } = this.parts;
    const { times } = this.run.keyframes;
    const before = camera.place(this.state.keyframe);
    this.state.keyframe = Math.min(Math.max(keyframe, 0), times.length - 1);
    const now = this.state.keyframe;
    this.slider.value = now;
    this.clock.value = `${times[now].toFixed(2)} s`;
    let faces = 0;
    if (mesh) {
      const known = this.run.planes.filter((plane) => plane.first <= now).length;
      const wanted = this.state.look === "planes" ? `planes ${known}` : this.state.look;
      if (this.painted !== wanted) {
        mesh.paint(this.state.look, now);
        this.painted = wanted;
      }
      faces = mesh.show(now);
      mesh.edges.value = this.shown.edges ? 1 : 0;
      mesh.points.visible = this.shown.landmarks;
    }
    path.show(times[now]);
    if (path.truth) {
      path.truth.visible = this.shown.truth;
    }
    camera.group.visible = this.shown.camera;
    camera.show(now);
    if (space) {
      space.group.visible = this.shown.space;
      if (this.shown.space) {
        space.show(now, camera.place(now));
      }
    }
    if (this.shown.follow) {
      const moved = camera.place(now).sub(before);
      this.camera.position.add(moved);
      this.controls.target.add(moved);
      this.controls.update();
    }
    this.tell(now, faces);
    document.dispatchEvent(new CustomEvent("facet-time",
      { detail: { sequence: this.state.sequence, time: times[now] } }));
    this.draw();
  }

  tell(now, faces) {
    const known = this.run.planes.filter((plane) => plane.first <= now);
    this.said.textContent = `keyframe ${now + 1} of ${this.run.keyframes.times.length}, ${faces} faces`;
    const limit = { distance: this.data.maxDistance, sigma: this.data.maxSigma }[this.state.look];
    if (limit) {
      this.said.append("\n0", element("span", { className: "ramp" }), `${100 * limit} cm and more`);
    }
    const shown = this.state.look === "planes" ? known : [];
    this.chips.replaceChildren(...shown.map((plane) => {
      const chip = element("i");
      chip.style.background = planeColour(plane.id).getStyle();
      const held = plane.held >= 0 && plane.held <= now ? ", held" : "";
      return element("span", {}, [`plane ${plane.id}, ${plane.kind}${held}`, chip]);
    }));
  }

  toggle() {
    const stop = this.playing;
    this.playing = null;
    this.play.textContent = "\u25b6";
    if (stop) {
      return;
    }
    const { times } = this.run.keyframes;
    if (this.state.keyframe >= times.length - 1) {
      this.seek(0);
    }
    this.play.textContent = "\u23f8";
    const begin = performance.now() - 1000 * times[this.state.keyframe];
    const step = (playing) => {
      if (this.playing !== playing) {
        return;
      }
      const time = (performance.now() - begin) / 1000;
      const next = this.run.keyframes.times.findLastIndex((t) => t <= time);
      if (next > this.state.keyframe) {
        this.seek(next);
      }
      if (next >= this.run.keyframes.times.length - 1) {
        this.toggle();
      } else {
        requestAnimationFrame(() => step(playing));
      }
    };
    this.playing = {};
    step(this.playing);
  }

  resize() {
    const { clientWidth: width, clientHeight: height } = this.stage;
    if (width && height) {
      this.renderer.setSize(width, height, false);
      this.camera.aspect = width / height;
      this.camera.updateProjectionMatrix();
      this.draw();
    }
  }

  draw() {
    if (!this.due) {
      this.due = requestAnimationFrame(() => {
        this.due = 0;
        this.renderer.render(this.scene, this.camera);
      });
    }
  }

  // What is shown as a PNG (data URL).
  picture() {
    this.renderer.render(this.scene, this.camera);
    return this.canvas.toDataURL("image/png");
  }
}

const root = document.getElementById("facet-view");
try {
  // For scripts that make pictures, and for tests.
  globalThis.facetView = new View(root, JSON.parse(document.getElementById("facet-data").textContent));
} catch (error) {
  root.textContent = `No 3D view: this browser gives no WebGL (${error.message}).`;
}

// SPDX-License-Identifier: BSD-2-Clause
// The live view of --view: the map's surface, mesh over the horizon, path, camera and its image as they come by
// WebSocket. Bundled with three.js by document.py.
import {
  AmbientLight, BufferAttribute, BufferGeometry, Color, DirectionalLight, FrontSide, GridHelper, Line,
  LineBasicMaterial, Mesh, MeshLambertMaterial, PerspectiveCamera, Scene, Vector3, WebGLRenderer,
} from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";
import { SurfacePart } from "./live_surface.js";
import { CameraPart, cssColour, LIGHT, planeColour, shadeFlat } from "./view_parts.js";

const MAX_POINTS = 40000; // of the path: half an hour at 20 Hz; then it starts over
const HEAD_BYTES = 4;
const FACE_BYTES = 40;
const POINT_BYTES = 16;
const MESH = 0;
const PICTURE = 1;
const SURFACE = 2;
const RETRY_MS = 1500;

class Live {
  constructor(root) {
    this.root = root;
    this.canvas = root.querySelector("canvas");
    this.said = root.querySelector(".said");
    this.badge = root.querySelector(".badge");
    this.renderer = new WebGLRenderer({ canvas: this.canvas, antialias: true, alpha: true });
    this.renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
    this.scene = new Scene();
    this.camera = new PerspectiveCamera(55, 1, 0.05, 500);
    this.camera.up.set(0, 0, 1);
    this.camera.position.set(-3, -3, 3);
    const light = new DirectionalLight("#ffffff", LIGHT);
    light.position.set(0.6, 0.9, 0.4);
    this.camera.add(light);
    const grid = new GridHelper(40, 40, cssColour("--line"), cssColour("--line"));
    grid.rotation.x = Math.PI / 2;
    grid.position.z = -1.5;
    this.mesh = new Mesh(new BufferGeometry(),
      new MeshLambertMaterial({ vertexColors: true, flatShading: true, side: FrontSide }));
    this.mesh.frustumCulled = false;
    this.points = new Float32Array(3 * MAX_POINTS);
    this.count = 0;
    const path = new BufferGeometry();
    path.setAttribute("position", new BufferAttribute(this.points, 3));
    this.path = new Line(path, new LineBasicMaterial({ color: cssColour("--run1") }));
    this.path.frustumCulled = false;
    this.surface = new SurfacePart();
    this.scene.add(new AmbientLight("#ffffff", LIGHT), this.camera, grid, this.mesh, this.path, this.surface.group);
    this.controls = new OrbitControls(this.camera, this.canvas);
    this.controls.addEventListener("change", () => this.draw());
    this.follow = root.querySelector("[name=follow]");
    this.boxes = { map: root.querySelector("[name=map]"), mesh: root.querySelector("[name=mesh]") };
    Object.values(this.boxes).forEach((box) => box.addEventListener("change", () => this.choose()));
    new ResizeObserver(() => this.resize()).observe(root);
    this.eye = root.querySelector(".eye");
    this.received = { frames: 0, meshes: 0, pictures: 0, points: 0, pieces: 0 };
    this.connect();
  }

  connect() {
    this.tell("connecting ...");
    // Behind a # it never leaves the browser; what is behind a ? the server, and what stands between, may note down.
    const token = [location.hash, location.search]
      .map((part) => new URLSearchParams(part.slice(1)).get("token")).find((found) => found);
    const query = token ? `?token=${encodeURIComponent(token)}` : "";
    const socket = new WebSocket(`ws://${location.host}/live${query}`);
    let isOpen = false;
    socket.addEventListener("open", () => {
      isOpen = true;
    });
    socket.binaryType = "arraybuffer";
    socket.addEventListener("message", ({ data }) => {
      if (typeof data !== "string") {
        const view = new DataView(data);
        const kind = view.getInt32(0, true);
        if (kind === MESH) {
          this.showMesh(view);
        } else if (kind === PICTURE) {
          this.showPicture(view);
        } else if (kind === SURFACE) {
          this.showSurface(data);
        }
        return;
      }
      const message = JSON.parse(data);
      if (message.camera) {
        this.begin(message.camera);
      } else {
        this.showFrame(message);
      }
    });
    socket.addEventListener("close", () => {
      this.tell(isOpen ? "the flight has ended"
        : "no connection: the flight has ended, or the address needs #token= and the right one");
      setTimeout(() => this.connect(), RETRY_MS);
    });
  }

  begin(camera) {
    if (this.frustum) {
      this.scene.remove(this.frustum.group);
    }
    this.count = 0;
    this.surface.clear();
    this.frustum = new CameraPart({ poses: "", camera }, cssColour("--run0"));
    this.scene.add(this.frustum.group);
  }

  showFrame(frame) {
    this.received.frames += 1;
    this.badge.hidden = false;
    this.badge.textContent = frame.state;
    this.badge.className = `badge state-${frame.state.toLowerCase()}`;
    const reasons = frame.reasons.replaceAll("_", " ").split("|").join(", ");
    this.tell(`${frame.t.toFixed(2)} s, quality ${frame.quality}, ${frame.tracked} features, `
      + `${frame.ms.toFixed(1)} ms${reasons ? `\n${reasons}` : ""}`);
    if (!frame.p) {
      return;
    }
    const at = new Vector3(...frame.p);
    if (this.count === MAX_POINTS) {
      this.count = 0;
    }
    at.toArray(this.points, 3 * this.count);
    this.count += 1;
    this.path.geometry.setDrawRange(0, this.count);
    this.path.geometry.attributes.position.needsUpdate = true;
    this.frustum.poses = new Float32Array([...frame.p, ...frame.q]);
    this.frustum.show(0);
    if (this.follow.checked) {
      this.camera.position.add(at).sub(this.controls.target);
      this.controls.target.copy(at);
      this.controls.update();
    }
    this.draw();
  }

  // The image with its landmarks, each in the colour of its plane.
  showPicture(view) {
    const [width, height, count] = [4, 8, 12].map((at) => view.getInt32(at, true));
    const pixels = 16 + POINT_BYTES * count;
    this.eye.width = width;
    this.eye.height = height;
    this.eye.hidden = false;
    const pen = this.eye.getContext("2d");
    const image = pen.createImageData(width, height);
    for (let i = 0; i < width * height; ++i) {
      image.data.fill(view.getUint8(pixels + i), 4 * i, 4 * i + 3);
      image.data[4 * i + 3] = 255;
    }
    pen.putImageData(image, 0, 0);
    for (let i = 0; i < count; ++i) {
      const [x, y] = [0, 4].map((at) => view.getFloat32(16 + POINT_BYTES * i + at, true));
      const plane = view.getInt32(16 + POINT_BYTES * i + 12, true);
      pen.beginPath();
      pen.arc(x + 0.5, y + 0.5, 3.2, 0, 2 * Math.PI);
      pen.fillStyle = plane >= 0 ? planeColour(plane).getStyle() : "#ffffff";
      pen.fill();
      pen.strokeStyle = "#000000";
      pen.stroke();
    }
    this.received.pictures += 1;
    this.received.points += count;
  }

  showMesh(view) {
    this.received.meshes += 1;
    const faces = (view.byteLength - HEAD_BYTES) / FACE_BYTES;
    const place = new Float32Array(9 * faces);
    const colours = new Float32Array(9 * faces);
    const plain = cssColour("--truth").lerp(new Color("#ffffff"), 0.45);
    for (let face = 0; face < faces; ++face) {
      const at = HEAD_BYTES + FACE_BYTES * face;
      const plane = view.getInt32(at + 36, true);
      const colour = plane >= 0 ? planeColour(plane) : plain;
      for (let k = 0; k < 9; ++k) {
        place[9 * face + k] = view.getFloat32(at + 4 * k, true);
      }
      [0, 3, 6].forEach((k) => colour.toArray(colours, 9 * face + k));
    }
    this.mesh.geometry.dispose();
    this.mesh.geometry = new BufferGeometry();
    this.mesh.geometry.setAttribute("position", new BufferAttribute(place, 3));
    shadeFlat(this.mesh.geometry);
    this.mesh.geometry.setAttribute("color", new BufferAttribute(colours, 3));
    this.draw();
  }

  // Once there is a map, it takes the place of the mesh.
  showSurface(data) {
    if (this.boxes.map.parentElement.hidden) {
      this.boxes.map.parentElement.hidden = false;
      this.boxes.mesh.parentElement.hidden = false;
      this.boxes.mesh.checked = false;
      this.choose();
    }
    this.received.pieces += this.surface.take(data);
    this.draw();
  }

  choose() {
    this.surface.group.visible = this.boxes.map.checked;
    this.mesh.visible = this.boxes.mesh.checked;
    this.draw();
  }

  tell(text) {
    this.said.textContent = text;
  }

  resize() {
    const { clientWidth: width, clientHeight: height } = this.root;
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / Math.max(height, 1);
    this.camera.updateProjectionMatrix();
    this.draw();
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

// For tests.
globalThis.facetView = new Live(document.querySelector(".stage"));

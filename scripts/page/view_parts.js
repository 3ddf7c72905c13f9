// SPDX-License-Identifier: BSD-2-Clause
// What the 3D view shows of one run: each part is made of the data of scene.py and has a group for the scene.
import {
  BufferAttribute, BufferGeometry, Color, DoubleSide, FrontSide, Group, Line, LineBasicMaterial, LineSegments, Mesh,
  MeshBasicMaterial, MeshLambertMaterial, Points, PointsMaterial, Quaternion, REVISION, Vector3,
} from "three";
import { Line2 } from "three/addons/lines/Line2.js";
import { LineGeometry } from "three/addons/lines/LineGeometry.js";
import { LineMaterial } from "three/addons/lines/LineMaterial.js";

// Colours that people who do not see all of them can tell apart, after Okabe and Ito.
const PLANE_COLOURS = ["#0072b2", "#e69f00", "#009e73", "#cc79a7", "#56b4e9", "#d55e00", "#e5d43c", "#8c6bb1",
  "#7f9c1e", "#a65628"];
// Of both lights. From version 155 on three.js divides what a surface reflects by pi; Debian's version 111 does not.
export const LIGHT = Number.parseInt(REVISION, 10) < 155 ? 0.6 : 1.7;
const FRUSTUM_M = 0.7;
const SIDES = [[0, 1], [1, 2], [2, 0]];
// A face is drawn as four triangles, so that its colours may differ at its corners (0 to 2) and sides (3 to 5).
const QUARTERS = [0, 3, 5, 3, 1, 4, 5, 4, 2, 3, 4, 5];

// Versions before 144 shade this material flat by normals of the faces alone.
export function shadeFlat(geometry) {
  if (Number.parseInt(REVISION, 10) < 144) {
    geometry.computeVertexNormals();
  }
}

function numbers(text, Type) {
  return new Type(Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0)).buffer);
}

function points(packed) {
  return Float32Array.from(numbers(packed.data, Int16Array), (steps) => steps * packed.step);
}

export function cssColour(name) {
  return new Color(getComputedStyle(document.documentElement).getPropertyValue(name).trim());
}

// The scale of colours of the charts: from near the truth to far from it.
export class Ramp {
  constructor() {
    this.stops = [0, 1, 2, 3, 4, 5, 6, 7].map((step) => cssColour(`--m${step}`));
  }

  at(share) {
    const place = Math.min(Math.max(share, 0), 1) * 7;
    const low = Math.min(Math.floor(place), 6);
    return this.stops[low].clone().lerp(this.stops[low + 1], place - low);
  }
}

export function planeColour(id) {
  const count = PLANE_COLOURS.length;
  const lighter = 0.25 * (Math.floor(id / count) % 2);
  return new Color(PLANE_COLOURS[id % count]).lerp(new Color("#ffffff"), lighter);
}

function lines(place, colour, opacity) {
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new BufferAttribute(place, 3));
  return new LineSegments(geometry, new LineBasicMaterial({ color: colour, transparent: true, opacity }));
}

function dots(place, colour, size) {
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new BufferAttribute(place, 3));
  return new Points(geometry, new PointsMaterial({ color: colour, size, sizeAttenuation: false }));
}

// The mesh of a run: faces appear at the keyframe at which they left the horizon.
export class MeshPart {
  constructor(mesh, planes, ramp) {
    this.mesh = mesh;
    this.planes = planes;
    this.ramp = ramp;
    this.vertices = points(mesh.vertices);
    this.triangles = numbers(mesh.triangles, Uint32Array);
    this.planeOf = numbers(mesh.planes, Int32Array);
    this.reveal = numbers(mesh.reveal, Uint16Array);
    this.sigmas = mesh.sigmas ? numbers(mesh.sigmas, Uint8Array) : null;
    this.distances = mesh.distances ? numbers(mesh.distances, Uint8Array) : null;
    this.firstOf = new Map(planes.map((plane) => [plane.id, plane.first]));
    this.group = new Group();
    this.addFaces();
    this.points = dots(this.vertices, cssColour("--ink"), 2.5);
    this.points.visible = false;
    this.group.add(this.points);
  }

  corner(face, k) {
    return this.vertices.subarray(3 * this.triangles[3 * face + k], 3 * this.triangles[3 * face + k] + 3);
  }

  addFaces() {
    const place = new Float32Array(36 * this.mesh.count);
    const six = Array.from({ length: 6 }, () => [0, 0, 0]);
    for (let face = 0; face < this.mesh.count; ++face) {
      for (let k = 0; k < 3; ++k) {
        six[k] = this.corner(face, k);
      }
      SIDES.forEach(([a, b], k) => {
        six[3 + k] = [0, 1, 2].map((axis) => 0.5 * (six[a][axis] + six[b][axis]));
      });
      QUARTERS.forEach((which, k) => place.set(six[which], 36 * face + 3 * k));
    }
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", new BufferAttribute(place, 3));
    shadeFlat(geometry);
    this.colours = new BufferAttribute(new Uint8Array(36 * this.mesh.count), 3, true);
    geometry.setAttribute("color", this.colours);
    const inside = new Uint8Array(36 * this.mesh.count);
    const shares = [[2, 0, 0], [0, 2, 0], [0, 0, 2], [1, 1, 0], [0, 1, 1], [1, 0, 1]];
    for (let i = 0; i < 12 * this.mesh.count; ++i) {
      inside.set(shares[QUARTERS[i % 12]], 3 * i);
    }
    geometry.setAttribute("inside", new BufferAttribute(inside, 3));
    this.faces = new Mesh(geometry, this.material());
    this.group.add(this.faces);
  }

  // Colours by vertex, and dark sides of the faces themselves, not of their quarters: where one of the barycentric
  // coordinates `inside` (times two) is nearly zero.
  material() {
    const material = new MeshLambertMaterial({ vertexColors: true, flatShading: true, side: FrontSide });
    this.edges = { value: 1 };
    material.onBeforeCompile = (shader) => {
      shader.uniforms.edges = this.edges;
      shader.vertexShader = `attribute vec3 inside; varying vec3 vInside;\n${shader.vertexShader}`
        .replace("#include <color_vertex>", "#include <color_vertex>\nvInside = inside;");
      shader.fragmentShader = `uniform float edges; varying vec3 vInside;\n${shader.fragmentShader}`
        .replace("#include <color_fragment>", `#include <color_fragment>
          vec3 perPixel = max(fwidth(vInside), vec3(1e-6));
          vec3 apart = vInside / perPixel;
          float edge = 1.0 - smoothstep(0.2, 1.0, min(apart.x, min(apart.y, apart.z)));
          // Of faces a few pixels small the sides would be all that is seen.
          edge *= 1.0 - smoothstep(0.15, 0.6, max(perPixel.x, max(perPixel.y, perPixel.z)));
          diffuseColor.rgb *= 1.0 - 0.3 * edges * edge;`);
    };
    return material;
  }

  // Area (m^2) of the mesh that is seen from a direction, shortened by its slant.
  facing(direction) {
    const [a, b, c] = [0, 1, 2].map(() => new Vector3());
    let area = 0;
    for (let face = 0; face < this.mesh.count; ++face) {
      [a, b, c].forEach((corner, k) => corner.fromArray(this.corner(face, k)));
      area += Math.max(0, 0.5 * b.sub(a).cross(c.sub(a)).dot(direction));
    }
    return area;
  }

  // How the six points of a face are coloured.
  colourer(look, keyframe) {
    const plain = cssColour("--truth").lerp(new Color("#ffffff"), 0.45);
    if (look === "distance" && this.distances) {
      const table = Array.from({ length: 256 }, (_, shade) => this.ramp.at(shade / 255));
      return (face, k) => table[this.distances[6 * face + k]];
    }
    if (look === "sigma" && this.sigmas) {
      const table = Array.from({ length: 256 }, (_, shade) => this.ramp.at(shade / 255));
      return (face) => table[this.sigmas[face]];
    }
    if (look === "planes") {
      const table = new Map(this.planes.map((plane) => [plane.id, planeColour(plane.id)]));
      return (face) => {
        const plane = this.planeOf[face];
        return plane >= 0 && (this.firstOf.get(plane) ?? 0) <= keyframe && table.get(plane) || plain;
      };
    }
    return () => plain;
  }

  paint(look, keyframe) {
    const colour = this.colourer(look, keyframe);
    const target = this.colours.array;
    for (let face = 0; face < this.mesh.count; ++face) {
      QUARTERS.forEach((which, k) => {
        const { r, g, b } = colour(face, which);
        const at = 36 * face + 3 * k;
        target[at] = 255 * r;
        target[at + 1] = 255 * g;
        target[at + 2] = 255 * b;
      });
    }
    this.colours.needsUpdate = true;
  }

  // Faces that are shown at a keyframe.
  show(keyframe) {
    let count = 0;
    while (count < this.mesh.count && this.reveal[count] <= keyframe) {
      ++count;
    }
    this.faces.geometry.setDrawRange(0, 12 * count);
    let last = -1;
    for (let i = 0; i < 3 * count; ++i) {
      last = Math.max(last, this.triangles[i]);
    }
    this.points.geometry.setDrawRange(0, last + 1);
    return count;
  }
}

// Estimated path up to a time, the whole of it faintly, and the true one.
export class PathPart {
  constructor(path, ramp, colour) {
    this.points = numbers(path.points, Float32Array);
    this.times = numbers(path.times, Float32Array);
    this.group = new Group();
    const count = this.times.length;
    const colours = new Float32Array(3 * count);
    const limit = path.errors ? [...path.errors].sort((a, b) => a - b)[Math.floor(0.98 * (count - 1))] || 1e-3 : 1;
    for (let i = 0; i < count; ++i) {
      (path.errors ? ramp.at(path.errors[i] / limit) : colour).toArray(colours, 3 * i);
    }
    this.geometry = new LineGeometry();
    this.geometry.setPositions(this.points);
    this.geometry.setColors(colours);
    this.line = new Line2(this.geometry, new LineMaterial({ vertexColors: true, linewidth: 4 }));
    this.line.frustumCulled = false;
    this.line.onBeforeRender = (renderer) => renderer.getSize(this.line.material.resolution);
    const whole = new BufferGeometry();
    whole.setAttribute("position", new BufferAttribute(this.points, 3));
    this.faint = new Line(whole, new LineBasicMaterial({ color: colour, transparent: true, opacity: 0.35 }));
    this.group.add(this.line, this.faint);
    if (path.truth) {
      const truth = new BufferGeometry();
      truth.setAttribute("position", new BufferAttribute(numbers(path.truth, Float32Array), 3));
      this.truth = new Line(truth, new LineBasicMaterial({ color: cssColour("--soft") }));
      this.group.add(this.truth);
    }
  }

  show(time) {
    let last = 0;
    while (last + 1 < this.times.length && this.times[last + 1] <= time + 1e-3) {
      ++last;
    }
    this.geometry.instanceCount = last;
    this.geometry.maxInstancedCount = last; // its name before version 117
  }
}

// The left camera's field of view at a keyframe.
export class CameraPart {
  constructor(keyframes, colour) {
    this.poses = numbers(keyframes.poses, Float32Array);
    this.camera = keyframes.camera ?? { p: [0, 0, 0], q: [0, 0, 0, 1], x: 0.6, y: 0.45 };
    const x = FRUSTUM_M * this.camera.x;
    const y = FRUSTUM_M * this.camera.y;
    const rim = [[-x, -y], [x, -y], [x, y], [-x, y]].map(([u, v]) => [u, v, FRUSTUM_M]);
    const edges = [];
    const sides = [];
    rim.forEach((corner, k) => {
      const next = rim[(k + 1) % 4];
      edges.push(0, 0, 0, ...corner, ...corner, ...next);
      sides.push(0, 0, 0, ...corner, ...next);
    });
    this.group = new Group();
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", new BufferAttribute(new Float32Array(sides), 3));
    const filled = { color: colour, transparent: true, opacity: 0.16, side: DoubleSide, depthWrite: false };
    this.group.add(new Mesh(geometry, new MeshBasicMaterial(filled)), lines(new Float32Array(edges), colour, 1));
  }

  show(keyframe) {
    const pose = this.poses.subarray(7 * keyframe, 7 * keyframe + 7);
    const body = new Quaternion(pose[3], pose[4], pose[5], pose[6]);
    this.group.position.set(...this.camera.p).applyQuaternion(body).add(new Vector3(pose[0], pose[1], pose[2]));
    this.group.quaternion.copy(body).multiply(new Quaternion(...this.camera.q));
  }

  place(keyframe) {
    return new Vector3(...this.poses.subarray(7 * keyframe, 7 * keyframe + 3));
  }
}

// Free stretches of the live grid at a keyframe, with what ends them.
export class SpacePart {
  constructor(rays) {
    this.ends = points(rays.ends);
    this.keyframes = numbers(rays.keyframes, Uint16Array);
    this.kinds = numbers(rays.kinds, Uint8Array);
    this.group = new Group();
    this.group.visible = false;
  }

  // The body is at `from`.
  show(keyframe, from) {
    clear(this.group);
    const own = [];
    const ends = [[], [], []];
    for (let i = 0; i < this.kinds.length; ++i) {
      if (this.keyframes[i] === keyframe) {
        const end = this.ends.subarray(3 * i, 3 * i + 3);
        own.push(from.x, from.y, from.z, ...end);
        ends[this.kinds[i]].push(...end);
      }
    }
    const [, unknown, obstacles] = ends.map((of) => new Float32Array(of));
    this.group.add(lines(new Float32Array(own), cssColour("--run0"), 0.3), dots(unknown, cssColour("--truth"), 5),
      dots(obstacles, cssColour("--run1"), 7));
  }
}

export function clear(group) {
  for (const child of [...group.children]) {
    child.geometry?.dispose();
    child.material?.dispose();
    clear(child);
    group.remove(child);
  }
}

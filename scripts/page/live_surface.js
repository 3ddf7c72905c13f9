// SPDX-License-Identifier: BSD-2-Clause
// The surface of a map that comes in pieces, one for each of its blocks (app/view/live_surface.h).
import {
  BufferAttribute, BufferGeometry, FrontSide, Group, Mesh, MeshBasicMaterial, Vector3,
} from "three";

const HEAD_BYTES = 8;
const PIECE_BYTES = 20;
const VERTEX_BYTES = 10;
const TRIANGLE_BYTES = 6;
const STEP_M = 1e-4;
const CUBE_STEPS = 12800; // pieces whose corners lie in the same cube of 1.28 m are drawn as one
const LIGHT_FROM = new Vector3(0.35, 0.2, 0.92).normalize();

// Greys as the images have them, which are lit already; a little more shade shows where bare surfaces bend.
function shaded(grey, normal) {
  const shade = 0.75 + 0.25 * normal.dot(LIGHT_FROM);
  return Math.min(255, grey * shade);
}

export class SurfacePart {
  constructor() {
    this.group = new Group();
    this.material = new MeshBasicMaterial({ vertexColors: true, side: FrontSide });
    this.cubes = new Map();
    this.surface = 0;
  }

  clear() {
    for (const cube of this.cubes.values()) {
      cube.mesh.geometry.dispose();
      this.group.remove(cube.mesh);
    }
    this.cubes.clear();
    this.surface = 0;
  }

  // Pieces of a message; returns how many there were.
  take(data) {
    const view = new DataView(data);
    const surface = view.getInt32(4, true);
    if (surface !== this.surface) {
      this.clear();
      this.surface = surface;
    }
    const changed = new Set();
    let count = 0;
    for (let at = HEAD_BYTES; at < data.byteLength; ++count) {
      const corner = [0, 4, 8].map((k) => view.getInt32(at + k, true));
      const [vertices, triangles] = [12, 16].map((k) => view.getInt32(at + k, true));
      const key = corner.map((k) => Math.floor(k / CUBE_STEPS)).join();
      if (!this.cubes.has(key)) {
        const mesh = new Mesh(new BufferGeometry(), this.material);
        this.group.add(mesh);
        this.cubes.set(key, { mesh, pieces: new Map() });
      }
      const cube = this.cubes.get(key);
      const bytes = VERTEX_BYTES * vertices + TRIANGLE_BYTES * triangles;
      // A copy: a piece that stays must not keep all of its message.
      const own = new DataView(data.slice(at + PIECE_BYTES, at + PIECE_BYTES + bytes));
      cube.pieces.set(corner.join(), { own, corner, vertices, triangles });
      changed.add(cube);
      at += 4 * Math.ceil((PIECE_BYTES + bytes) / 4);
    }
    changed.forEach((cube) => SurfacePart.build(cube));
    return count;
  }

  static build(cube) {
    const pieces = [...cube.pieces.values()];
    const total = (name) => pieces.reduce((sum, piece) => sum + piece[name], 0);
    const places = new Float32Array(3 * total("vertices"));
    const colours = new Uint8Array(3 * total("vertices"));
    const index = new Uint32Array(3 * total("triangles"));
    let [vertex, corner] = [0, 0];
    const normal = new Vector3();
    for (const piece of pieces) {
      const first = vertex;
      let at = 0;
      for (let i = 0; i < piece.vertices; ++i, ++vertex, at += VERTEX_BYTES) {
        for (let axis = 0; axis < 3; ++axis) {
          places[3 * vertex + axis] = STEP_M * (piece.corner[axis] + piece.own.getInt16(at + 2 * axis, true));
        }
        normal.set(...[6, 7, 8].map((k) => piece.own.getInt8(at + k) / 127));
        colours.fill(shaded(piece.own.getUint8(at + 9), normal), 3 * vertex, 3 * vertex + 3);
      }
      for (let i = 0; i < 3 * piece.triangles; ++i, ++corner, at += 2) {
        index[corner] = first + piece.own.getUint16(at, true);
      }
    }
    cube.mesh.geometry.dispose();
    cube.mesh.geometry = new BufferGeometry();
    cube.mesh.geometry.setAttribute("position", new BufferAttribute(places, 3));
    cube.mesh.geometry.setAttribute("color", new BufferAttribute(colours, 3, true));
    cube.mesh.geometry.setIndex(new BufferAttribute(index, 1));
  }
}

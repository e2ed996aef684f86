// What is hidden behind other meshes, for the cameras that asked for it.
//
// The engine keeps a scene of its own of all that is culled by its box, with the triangles of what may hide others. It is
// conservative at every resolution, so what it drops would have covered no pixel.

import { Scene } from 'cullet';
import { boxOf, Kind } from './bounds.js';
import { planesOfCamera } from './planes.js';

const DOUBLE_SIDE = 2;
const FRONT_SIDE = 0;
const LESS_EQUAL = 3;
const NO_BLENDING_NEEDED = (m) => !m.transparent && m.alphaTest === 0 && !m.alphaMap && !m.alphaHash;
// A buffer of this width is enough for any screen: proofs hold at every resolution.
const WIDTH = 1280;

/** Whether all triangles of a material are drawn and stand before what lies behind. */
const hides = (m) => m.visible && m.depthTest && m.depthWrite && m.depthFunc === LESS_EQUAL && NO_BLENDING_NEEDED(m) && !m.wireframe
  && (m.side === FRONT_SIDE || m.side === DOUBLE_SIDE) && !m.clippingPlanes?.length && !m.polygonOffset && !m.stencilWrite;

/** Whether what lies behind others is hidden by them. */
const hidden = (m) => m.depthTest && m.depthFunc === LESS_EQUAL && !m.polygonOffset && !m.stencilWrite;

const each = ({ material }) => (Array.isArray(material) ? material : [material]);

export class Occlusion {
  #nodes;
  #cameras;
  #preset;
  #scene = null;
  #views = new Map();
  #meshes = new Map();
  #ids = new Map();
  #stamps = new Uint32Array(0);
  #stamp = 0;
  #matrix = new Float64Array(16);
  #planes = new Float64Array(24);
  #version = -1;
  #looked = [];
  #geometries = [];
  #versions = [];
  #instances = [];
  #moved = new Map();

  constructor(nodes, cameras, preset) {
    this.#nodes = nodes;
    this.#cameras = cameras;
    this.#preset = preset;
  }

  /** The camera whose pass this is: its layers are asked for, and its frustum is this one. */
  cameraOf(layers, planes) {
    const camera = this.#cameras.find((c) => c.layers === layers);
    if (!camera || camera.isArrayCamera) return null;
    planesOfCamera(camera, this.#planes);
    // The four at the sides: those in depth differ by the renderer.
    for (let i = 0; i < 16; i++) if (!(Math.abs(this.#planes[i] - planes[i]) <= 1e-9 * (1 + Math.abs(planes[i])))) return null;
    return camera;
  }

  /** Finds what a camera may see; `false` where that is not to be known. Then `isHidden` tells of numbers and their instances. */
  cull(camera) {
    this.#look();
    let view = this.#views.get(camera);
    if (!view) this.#views.set(camera, view = this.#scene.view({ preset: this.#preset, output: 'instances', depth: depthOf(camera) }));
    multiply(camera.projectionMatrix.elements, camera.matrixWorldInverse.elements, this.#matrix);
    // A camera without size sees nothing that can be told.
    if (!this.#matrix.every(Number.isFinite)) return false;
    const { elements: p } = camera.projectionMatrix;
    const height = Math.round(Math.min(4096, Math.max(64, WIDTH * Math.abs(p[0] / p[5]))));
    let list;
    try { list = view.setCamera(this.#matrix, WIDTH, height).cull(); } catch (error) {
      if (error.code === 'camera') return false;
      throw error;
    }
    if (this.#stamps.length < this.#scene.idCount) this.#stamps = new Uint32Array(2 * this.#scene.idCount);
    this.#stamp += 1;
    const [stamps, stamp] = [this.#stamps, this.#stamp];
    for (let k = 0; k < list.length; k++) stamps[list[k]] = stamp;
    return true;
  }

  isHidden(i) {
    const ids = this.#ids.get(i);
    return ids !== undefined && this.#stamps[ids[0]] !== this.#stamp;
  }

  /** Of a list of instances, those that are not hidden, in a list that is overwritten by the next call. */
  keep(i, list) {
    const ids = this.#ids.get(i);
    if (!ids) return list;
    const [stamps, stamp] = [this.#stamps, this.#stamp];
    let count = 0;
    if (kept.length < list.length) kept = new Uint32Array(2 * list.length);
    for (let k = 0; k < list.length; k++) {
      const id = ids[list[k]];
      if (id === undefined || stamps[id] === stamp) kept[count++] = list[k];
    }
    return kept.subarray(0, count);
  }

  /** Something moved: its matrices are taken anew before the next pass. */
  moved(i) { this.#moved.set(i, true); }

  // What is drawn, and how, decides what may hide: looked at before each pass, for a mesh that is hidden must hide nothing.
  #look() {
    const { objects, kinds, hidden: under, length } = this.#nodes;
    let same = this.#scene !== null && this.#version === this.#nodes.version;
    const looked = this.#looked;
    for (let i = 0; i < length; i++) {
      if (kinds[i] < Kind.Mesh || objects[i] === null) continue;
      const object = objects[i];
      const now = under[i] === 1 || !object.visible ? -1 : this.#roleOf(object);
      const { geometry, instanceMatrix } = object;
      const version = geometry.attributes.position?.version ?? 0;
      if (looked[i] !== now || this.#geometries[i] !== geometry || this.#versions[i] !== version) same = false;
      [looked[i], this.#geometries[i], this.#versions[i]] = [now, geometry, version];
      if (instanceMatrix) {
        const instances = instanceMatrix.version + object.count / 2 ** 32;
        if (this.#instances[i] !== instances) this.#moved.set(i, true);
        this.#instances[i] = instances;
      }
    }
    // Other numbers of instances, or some that are not finite now: another scene.
    for (const i of this.#moved.keys()) same = same && this.#place(i);
    if (!same) { this.#make(); return; }
    if (this.#moved.size > 0) this.#scene.refit();
    this.#moved.clear();
  }

  // A number for all that decides an object's part: 0 it can neither hide nor be hidden, 1 be hidden, 2 and 3 hide too.
  #roleOf(object) {
    const list = each(object);
    if (!list.every(hidden)) return 0;
    const { drawRange } = object.geometry;
    const whole = drawRange.start === 0 && drawRange.count === Infinity;
    const role = list.length === 1 && !Array.isArray(object.material) && whole && hides(list[0]) ? 2 + Number(list[0].side === DOUBLE_SIDE) : 1;
    return role + 4 * (object.layers.mask >>> 0);
  }

  #make() {
    this.dispose();
    this.#scene = new Scene();
    this.#version = this.#nodes.version;
    const { objects, kinds, length } = this.#nodes;
    for (let i = 0; i < length; i++) {
      const role = this.#looked[i];
      if (kinds[i] < Kind.Mesh || objects[i] === null || role === -1 || role % 4 === 0 || kinds[i] === Kind.Batched) continue;
      if (this.#nodes.isUnculled(i)) continue;
      const mesh = this.#meshOf(objects[i].geometry, role % 4);
      const matrices = this.#matricesOf(i);
      // What is not finite stays visible, and outside this scene.
      if (!matrices.every(Number.isFinite)) continue;
      this.#ids.set(i, this.#scene.addMany(mesh, matrices, { layers: objects[i].layers.mask >>> 0, occluder: role % 4 >= 2 }));
    }
    this.#scene.commit();
    this.#moved.clear();
  }

  #matricesOf(i) {
    const object = this.#nodes.objects[i];
    const world = object.matrixWorld.elements;
    if (this.#nodes.kinds[i] !== Kind.Instanced) return Float64Array.from(world);
    const { array } = object.instanceMatrix;
    const matrices = new Float64Array(16 * Math.min(object.count, array.length / 16));
    for (let at = 0; at < matrices.length; at += 16) multiply(world, array.subarray(at, at + 16), matrices.subarray(at, at + 16));
    return matrices;
  }

  #place(i) {
    const ids = this.#ids.get(i);
    // What is drawn in any case is in no scene, unless it was only not finite.
    if (!ids) return this.#looked[i] === -1 || this.#looked[i] % 4 === 0 || this.#nodes.isUnculled(i) || this.#nodes.kinds[i] < Kind.Mesh || this.#nodes.kinds[i] === Kind.Batched;
    const matrices = this.#matricesOf(i);
    if (this.#nodes.isUnculled(i) || matrices.length !== 16 * ids.length || !matrices.every(Number.isFinite)) return false;
    this.#scene.setTransforms(ids, matrices);
    return true;
  }

  #meshOf(geometry, role) {
    const key = `${geometry.uuid} ${role}`;
    let mesh = this.#meshes.get(key);
    if (mesh !== undefined) return mesh;
    const { position } = geometry.attributes;
    const positions = new Float32Array(3 * position.count);
    for (let v = 0; v < position.count; v++) { positions[3 * v] = position.getX(v); positions[3 * v + 1] = position.getY(v); positions[3 * v + 2] = position.getZ(v); }
    const triangles = 3 * Math.floor((geometry.index ?? position).count / 3);
    const indices = new Uint32Array(triangles);
    for (let k = 0; k < triangles; k++) indices[k] = geometry.index ? geometry.index.getX(k) : k;
    const usable = positions.every(Number.isFinite) && indices.every((v) => v < position.count) && triangles > 0;
    const box = [];
    boxOf(geometry, box, 0);
    mesh = role >= 2 && usable
      ? this.#scene.addMesh(positions, indices, { twoSided: role === 3 })
      : this.#scene.addBox(box);
    this.#meshes.set(key, mesh);
    return mesh;
  }

  dispose() {
    for (const view of this.#views.values()) view.dispose();
    this.#views.clear();
    this.#meshes.clear();
    this.#ids.clear();
    this.#scene?.dispose();
    this.#scene = null;
  }
}

let kept = new Uint32Array(1024);

const depthOf = (camera) => {
  if (camera.reversedDepth) return 'reversed';
  return camera.coordinateSystem === 2001 ? 'standard' : 'webgl';
};

function multiply(a, b, to) {
  for (let c = 0; c < 16; c += 4) {
    const [x, y, z, w] = [b[c], b[c + 1], b[c + 2], b[c + 3]];
    for (let r = 0; r < 4; r++) to[c + r] = a[r] * x + a[4 + r] * y + a[8 + r] * z + a[12 + r] * w;
  }
}

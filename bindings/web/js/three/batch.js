// Instances of a BatchedMesh: three.js lists and sorts them as ever, but out of those only that were found visible.

import { BoxSet } from './engine.js';
import { never, writeBox } from './bounds.js';
import { isPassOf, multiply, planesInto, planesOfCamera } from './planes.js';

const HIDDEN = Object.freeze({ visible: false, active: true, geometryIndex: 0 });
// Calls that change one instance; all others are noticed by the version of the matrices, and everything is looked at again.
const ONE = ['setMatrixAt', 'setVisibleAt', 'setGeometryIdAt'];
const ALL = ['addInstance', 'deleteInstance', 'setGeometryAt', 'deleteGeometry', 'optimize', 'setInstanceCount'];
const world = new Float64Array(24);
const planes = new Float64Array(24);
const [box, matrix] = [new Float64Array(6), new Float64Array(16)];

export class Batch {
  #mesh;
  #set = null;
  #capacity = 0;
  #version = -1;
  #texture = null;
  #changed = [];
  #masked = [];
  #shown = [];
  #restore = [];
  #enabled = true;
  // The list that a pass made for its draws.
  #ready = null;
  /** Another number once instances or geometries came, went or changed, but for matrices and `visible`. */
  revision = 0;
  /** Instances that the last pass drew. */
  visible = 0;

  constructor(mesh) {
    this.#mesh = mesh;
    for (const name of [...ONE, ...ALL]) this.#watch(name, ONE.includes(name));
    const { _updateDrawParameters: list } = mesh;
    this.#replace('_updateDrawParameters', (camera, ...rest) => this.#list(camera, () => list.call(mesh, camera, ...rest)));
  }

  get count() { return this.#mesh.instanceCount; }

  enable(on) { this.#enabled = on; this.#ready = null; this.#mesh._visibilityChanged = true; }

  forget() { this.#version = -1; }

  #replace(name, to) {
    const mesh = this.#mesh;
    const had = Object.getOwnPropertyDescriptor(mesh, name);
    mesh[name] = to;
    this.#restore.push(() => { if (had) Object.defineProperty(mesh, name, had); else delete mesh[name]; });
  }

  #watch(name, isOne) {
    const mesh = this.#mesh;
    const call = mesh[name];
    if (!call) return;
    this.#replace(name, (...values) => {
      const current = this.#version === mesh._matricesTexture.version;
      const result = call.apply(mesh, values);
      this.#ready = null;
      if (name !== 'setMatrixAt' && name !== 'setVisibleAt') this.revision += 1;
      if (!isOne) this.#version = -1;
      else if (current) { this.#changed.push(values[0]); this.#version = mesh._matricesTexture.version; }
      return result;
    });
  }

  #write(i, boxes, matrices) {
    const mesh = this.#mesh;
    const info = mesh._instanceInfo[i];
    const geometry = info?.active ? mesh._geometryInfo[info.geometryIndex] : undefined;
    if (!geometry) { never(boxes, 6 * i); return; }
    if (geometry.boundingBox === null) mesh.getBoundingBoxAt(info.geometryIndex, scratchBox(mesh));
    writeBox(geometry.boundingBox, geometry.boundingSphere, boxes, 6 * i);
    const { data } = mesh._matricesTexture.image;
    for (let k = 16 * i; k < 16 * i + 16; k++) matrices[k] = data[k];
  }

  #look() {
    const mesh = this.#mesh;
    const length = mesh._instanceInfo.length;
    const texture = mesh._matricesTexture;
    if (this.#version === texture.version && this.#texture === texture && length <= this.#capacity) {
      if (this.#changed.length === 0) return;
      const { boxes, matrices } = { matrices: this.#set.matrices, boxes: this.#set.boxes };
      for (const i of this.#changed) { this.#write(i, boxes, matrices); this.#set.commitMoved(i, 1); }
      this.#changed.length = 0;
      return;
    }
    if (!this.#set || length > this.#capacity) {
      this.#set?.dispose();
      this.#capacity = Math.max(length, mesh.maxInstanceCount);
      this.#set = new BoxSet(this.#capacity);
    }
    const { boxes, matrices } = { matrices: this.#set.matrices, boxes: this.#set.boxes };
    for (let i = 0; i < length; i++) this.#write(i, boxes, matrices);
    this.#set.commitMoved(0, length);
    this.#changed.length = 0;
    this.#texture = texture;
    this.#version = texture.version;
    this.#masked = new Array(length).fill(HIDDEN);
    this.#shown = [];
  }

  /** What a pass of a camera draws: the mesh, whose list `keep(list)` may shorten; it holds for draws with that camera. `null` where it is empty. */
  cull(pass, worldPlanes, keep, camera) {
    const mesh = this.#mesh;
    this.#ready = null;
    this.visible = 0;
    if (!camera || worldPlanes.length !== 24 || !this.#enabled || !mesh.perObjectFrustumCulled || mesh._instanceInfo.length === 0) return mesh;
    this.#look();
    planesInto(mesh.matrixWorld.elements, worldPlanes, planes);
    const infos = mesh._instanceInfo;
    let list = this.#set.cull(planes).filter((k) => infos[k]?.visible && infos[k].active);
    if (keep) list = keep(list).slice();
    this.visible = list.length;
    this.#ready = { camera, planes: worldPlanes.slice(), list, version: mesh._matricesTexture.version };
    return list.length > 0 ? mesh : null;
  }

  /** Of a list of instances those that `test` takes, by their boxes and matrices to the world: a list of its own. */
  filter(list, test) { return list.filter((k) => { this.boxOf(k, box); return test(box, this.matrixOf(k, matrix)); }); }

  /** Instances that there are, those that went included. */
  get length() { return this.#mesh._instanceInfo.length; }

  get matricesVersion() { return this.#mesh._matricesTexture.version; }

  isShown(k) { return this.#mesh._instanceInfo[k].visible === true; }

  /** Instances by the numbers of their geometries. */
  byGeometry() {
    const lists = new Map();
    this.#mesh._instanceInfo.forEach(({ active, geometryIndex }, k) => {
      if (!active) return;
      if (!lists.has(geometryIndex)) lists.set(geometryIndex, []);
      lists.get(geometryIndex).push(k);
    });
    return lists;
  }

  /** Matrices to the world of some instances, or of all. */
  matricesOf(list) {
    const count = list?.length ?? this.length;
    const matrices = new Float64Array(16 * count);
    for (let k = 0; k < count; k++) this.matrixOf(list ? list[k] : k, matrices.subarray(16 * k, 16 * k + 16));
    return matrices;
  }

  /** One of the batch's geometries, as far as a geometry is read here: its range of positions and indices. */
  geometryOf(number) {
    const { attributes: { position }, index, uuid } = this.#mesh.geometry;
    const info = this.#mesh._geometryInfo[number];
    const shifted = (read, first, by) => ({ count: info.count, getX: (k) => read(first + k) - by });
    const { vertexStart: first, vertexCount: count } = info;
    const box = [];
    if (info.boundingBox === null) this.#mesh.getBoundingBoxAt(number, scratchBox(this.#mesh));
    writeBox(info.boundingBox, info.boundingSphere, box, 0);
    return {
      uuid: `${uuid} ${number}`,
      box,
      attributes: { position: { count, getX: (v) => position.getX(first + v), getY: (v) => position.getY(first + v), getZ: (v) => position.getZ(first + v) } },
      index: index ? shifted((k) => index.getX(k), info.start, first) : shifted((k) => k, info.start, first),
    };
  }

  /** Writes an instance's box in its own space. */
  boxOf(k, to) {
    const { geometryIndex } = this.#mesh._instanceInfo[k];
    const geometry = this.#mesh._geometryInfo[geometryIndex];
    if (geometry.boundingBox === null) this.#mesh.getBoundingBoxAt(geometryIndex, scratchBox(this.#mesh));
    writeBox(geometry.boundingBox, geometry.boundingSphere, to, 0);
  }

  /** Writes an instance's matrix to the world. */
  matrixOf(k, to) {
    multiply(this.#mesh.matrixWorld.elements, this.#mesh._matricesTexture.image.data.subarray(16 * k, 16 * k + 16), to);
    return to;
  }

  // Runs three.js's own listing over the visible instances. Its list is of this camera, so it is made for each.
  #list(camera, list) {
    const mesh = this.#mesh;
    if (!this.#enabled || !mesh.perObjectFrustumCulled || mesh._instanceInfo.length === 0) { this.visible = this.count; list(); return; }
    this.#look();
    const infos = mesh._instanceInfo;
    const masked = this.#masked;
    for (const i of this.#shown) masked[i] = HIDDEN;
    this.#shown.length = 0;
    const show = (list) => {
      for (const i of list) {
        if (i >= infos.length || masked[i] !== HIDDEN) continue;
        masked[i] = infos[i];
        this.#shown.push(i);
      }
    };
    const ready = this.#ready;
    if (ready && ready.camera === camera && ready.version === mesh._matricesTexture.version && isPassOf(camera, camera.layers, ready.planes)) show(ready.list);
    else for (const one of camera.isArrayCamera ? camera.cameras : [camera]) {
      planesOfCamera(one, world);
      planesInto(mesh.matrixWorld.elements, world, planes);
      show(this.#set.cull(planes));
    }
    this.visible = this.#shown.length;
    mesh._instanceInfo = masked;
    mesh.perObjectFrustumCulled = false;
    mesh._visibilityChanged = true;
    try { list(); } finally {
      mesh._instanceInfo = infos;
      mesh.perObjectFrustumCulled = true;
    }
  }

  dispose() {
    for (const restore of this.#restore.reverse()) restore();
    this.#set?.dispose();
    this.#set = null;
    this.#mesh._visibilityChanged = true;
  }
}

// A box of three.js's own class, taken from what the mesh has.
function scratchBox(mesh) {
  if (mesh.boundingBox === null) mesh.computeBoundingBox();
  return mesh.boundingBox.clone();
}

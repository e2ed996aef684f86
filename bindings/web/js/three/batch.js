// Instances of a BatchedMesh: three.js lists and sorts them as ever, but out of those only that were found visible.

import { BoxSet } from './engine.js';
import { never, writeBox } from './bounds.js';
import { levelFor, PLACE, place, viewIn, widen } from './levels.js';
import { isPassOf, multiply, planesInto, planesOfCamera } from './planes.js';

// Cameras of one frame whose lists are kept.
const MOST_READY = 8;
const HIDDEN = Object.freeze({ visible: false, active: true, geometryIndex: 0 });
// Calls that change one instance; all others are noticed by the version of the matrices, and everything is looked at again.
const ONE = ['setMatrixAt', 'setVisibleAt', 'setGeometryIdAt'];
const ALL = ['addInstance', 'deleteInstance', 'setGeometryAt', 'deleteGeometry', 'optimize', 'setInstanceCount'];
const world = new Float64Array(24);
const planes = new Float64Array(24);
const [box, matrix, level] = [new Float64Array(6), new Float64Array(16), new Float64Array(6)];

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
  // Lists that passes made for their draws, with the level of each instance: shadow maps may be drawn between the two.
  #ready = [];
  #places = new Float64Array(0);
  #levels = new Uint8Array(0);
  #stands = new Map();
  /** Chains by their finest geometry, as `chainOf` makes them; `null` where there are none. */
  chains = null;
  /** The level of each instance in the frustum of this pass; `null` where all are drawn in full. */
  chosen = null;
  /** Another number once instances or geometries came, went or changed, but for matrices and `visible`. */
  revision = 0;
  /** Instances that the last pass drew, and how many of them at a coarser level. */
  visible = 0;
  coarser = 0;

  constructor(mesh) {
    this.#mesh = mesh;
    for (const name of [...ONE, ...ALL]) this.#watch(name, ONE.includes(name));
    const { _updateDrawParameters: list } = mesh;
    this.#replace('_updateDrawParameters', (camera, ...rest) => this.#list(camera, () => list.call(mesh, camera, ...rest)));
  }

  get count() { return this.#mesh.instanceCount; }

  enable(on) { this.#enabled = on; this.#ready.length = 0; this.#mesh._visibilityChanged = true; }

  forget() { this.#version = -1; }

  /** Takes chains of levels, or others in their place. */
  setLevels(chains) {
    this.chains = chains?.size > 0 ? chains : null;
    this.chosen = null;
    this.#ready.length = 0;
    // Boxes hold all levels.
    this.forget();
    this.revision += 1;
  }

  /** Why something cannot be a level; `null` if it can. */
  whyNoLevel(number) { return this.#mesh._geometryInfo[number]?.active === true ? null : `is ${typeof number === 'number' ? number : typeof number}, and not one that addGeometry() of this batch returned`; }

  // A geometry that goes or changes is no level any more, and as the finest it has none.
  #dropGeometry(number) {
    if (!this.chains) return;
    this.chains.delete(number);
    for (const chain of this.chains.values()) {
      const k = chain.geometries.indexOf(number);
      if (k > 0) { chain.geometries.splice(k, 1); chain.errors.splice(k, 1); }
    }
    this.setLevels(this.chains);
  }

  /** Chooses levels for a camera's pass; for another, where `view` is `null`, everything is drawn in full. */
  choose(view, worldPlanes) {
    this.chosen = null;
    const mesh = this.#mesh;
    if (!view || !this.chains || !this.#isCulled) return;
    this.#look();
    planesInto(mesh.matrixWorld.elements, worldPlanes, planes);
    const own = viewIn(mesh.matrixWorld.elements, view);
    const infos = mesh._instanceInfo;
    if (this.#levels.length < infos.length) this.#levels = new Uint8Array(this.#capacity);
    this.chosen = this.#levels.fill(0);
    for (const k of this.#set.cull(planes)) {
      const chain = infos[k]?.active ? this.chains.get(infos[k].geometryIndex) : undefined;
      if (chain) this.chosen[k] = levelFor(own, this.#places, k, chain);
    }
  }

  /** Whether an instance is drawn in full, as far as this pass has it in its frustum. */
  isFull(k) { return !(this.chosen?.[k] > 0); }

  get #isCulled() { return this.#enabled && this.#mesh.perObjectFrustumCulled && this.#mesh._instanceInfo.length > 0; }

  // What is listed in the place of an instance.
  #standOf(info, number) {
    const geometry = number > 0 ? this.chains?.get(info.geometryIndex)?.geometries[number] : undefined;
    if (geometry === undefined) return info;
    if (!this.#stands.has(geometry)) this.#stands.set(geometry, Object.freeze({ visible: true, active: true, geometryIndex: geometry }));
    return this.#stands.get(geometry);
  }

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
      this.#ready.length = 0;
      if (name !== 'setMatrixAt' && name !== 'setVisibleAt') this.revision += 1;
      if (name === 'deleteGeometry' || name === 'setGeometryAt') this.#dropGeometry(values[0]);
      if (!isOne) this.#version = -1;
      else if (current) { this.#changed.push(values[0]); this.#version = mesh._matricesTexture.version; }
      return result;
    });
  }

  #write(i, boxes, matrices) {
    const mesh = this.#mesh;
    const info = mesh._instanceInfo[i];
    if (!info?.active || !mesh._geometryInfo[info.geometryIndex]) { never(boxes, 6 * i); return; }
    this.#boxOfGeometry(info.geometryIndex, boxes, 6 * i);
    const { data } = mesh._matricesTexture.image;
    for (let k = 16 * i; k < 16 * i + 16; k++) matrices[k] = data[k];
    if (this.chains?.has(info.geometryIndex)) place(this.#places, i, boxes, 6 * i, data, 16 * i);
  }

  // The box of a geometry, and of all its levels.
  #boxOfGeometry(number, to, at) {
    const write = (one, box, first) => {
      const info = this.#mesh._geometryInfo[one];
      if (info.boundingBox === null) this.#mesh.getBoundingBoxAt(one, scratchBox(this.#mesh));
      writeBox(info.boundingBox, info.boundingSphere, box, first);
    };
    write(number, to, at);
    const chain = this.chains?.get(number);
    if (chain) for (const one of chain.geometries) { write(one, level, 0); widen(to, at, level); }
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
    if (this.chains && this.#places.length < PLACE * this.#capacity) this.#places = new Float64Array(PLACE * this.#capacity);
    const { boxes, matrices } = { matrices: this.#set.matrices, boxes: this.#set.boxes };
    for (let i = 0; i < length; i++) this.#write(i, boxes, matrices);
    this.#set.commitMoved(0, length);
    this.#changed.length = 0;
    this.#texture = texture;
    this.#version = texture.version;
    this.#masked = new Array(length).fill(HIDDEN);
    this.#shown = [];
  }

  /** What a pass of a camera draws: the mesh, whose list `keep(list)` may shorten; it holds for draws with that camera. Nothing where it is empty. */
  cull(pass, worldPlanes, keep, camera) {
    const mesh = this.#mesh;
    const kept = this.#ready.filter((one) => one.camera !== camera && one.planes.some((p, k) => p !== worldPlanes[k]));
    this.#ready = kept.slice(-MOST_READY);
    this.visible = this.coarser = 0;
    if (!camera || worldPlanes.length !== 24 || !this.#isCulled) return [mesh];
    this.#look();
    planesInto(mesh.matrixWorld.elements, worldPlanes, planes);
    const infos = mesh._instanceInfo;
    let list = this.#set.cull(planes).filter((k) => infos[k]?.visible && infos[k].active);
    if (keep) list = keep(list).slice();
    this.visible = list.length;
    const { chosen } = this;
    const levels = chosen && Uint8Array.from(list, (k) => chosen[k]);
    if (levels) for (const one of levels) if (one > 0) this.coarser += 1;
    this.#ready.push({ camera, planes: worldPlanes.slice(), list, version: mesh._matricesTexture.version, levels });
    return list.length > 0 ? [mesh] : [];
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
    this.#boxOfGeometry(number, box, 0);
    return {
      uuid: `${uuid} ${number}`,
      box,
      attributes: { position: { count, getX: (v) => position.getX(first + v), getY: (v) => position.getY(first + v), getZ: (v) => position.getZ(first + v) } },
      index: index ? shifted((k) => index.getX(k), info.start, first) : shifted((k) => k, info.start, first),
    };
  }

  /** Writes an instance's box in its own space, that of its levels too. */
  boxOf(k, to) {
    this.#boxOfGeometry(this.#mesh._instanceInfo[k].geometryIndex, to, 0);
  }

  /** Writes an instance's matrix to the world. */
  matrixOf(k, to) {
    multiply(this.#mesh.matrixWorld.elements, this.#mesh._matricesTexture.image.data.subarray(16 * k, 16 * k + 16), to);
    return to;
  }

  // Runs three.js's own listing over the visible instances. Its list is of this camera, so it is made for each.
  #list(camera, list) {
    const mesh = this.#mesh;
    if (!this.#isCulled) { this.visible = this.count; list(); return; }
    this.#look();
    const infos = mesh._instanceInfo;
    const masked = this.#masked;
    for (const i of this.#shown) masked[i] = HIDDEN;
    this.#shown.length = 0;
    const show = (list, levels) => {
      for (let k = 0; k < list.length; k++) {
        const i = list[k];
        if (i >= infos.length || masked[i] !== HIDDEN) continue;
        masked[i] = levels ? this.#standOf(infos[i], levels[k]) : infos[i];
        this.#shown.push(i);
      }
    };
    const ready = this.#ready.find((one) => one.camera === camera);
    if (ready && ready.version === mesh._matricesTexture.version && isPassOf(camera, camera.layers, ready.planes)) show(ready.list, ready.levels);
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

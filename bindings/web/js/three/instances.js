// Instances of an InstancedMesh, compacted: each pass draws a stand-in that has the visible ones in a buffer of its own.
//
// WebGL uploads an object's instances once a render(), before shadows are drawn, so one buffer cannot serve two passes.
// A stand-in has the mesh as its prototype: material, layers, callbacks and matrices are the mesh's own.

import { BoxSet } from './engine.js';
import { boxOf } from './bounds.js';
import { levelFor, PLACE, place, viewIn, widen } from './levels.js';
import { multiply, planesInto } from './planes.js';

// The six faces of a point light, and as many again.
const MOST = 12;
const planes = new Float64Array(24);
const [box, matrix, level] = [new Float64Array(6), new Float64Array(16), new Float64Array(6)];

export class Instances {
  #mesh;
  #set = null;
  #capacity = 0;
  #attribute = null;
  #version = -1;
  #geometry = null;
  /** Stand-ins by pass (the camera's layers and the frustum, which renderers keep), each in the order asked for. */
  #pools = new Map();
  #places = new Float64Array(0);
  #levels = new Uint8Array(0);
  #lists = [];
  /** Chains by their finest geometry, as `chainOf` makes them; `null` where there are none. */
  chains = null;
  /** The level of each instance in the frustum of this pass; `null` where all are drawn in full. */
  chosen = null;
  /** Instances that the last pass drew, and how many of them at a coarser level. */
  visible = 0;
  coarser = 0;

  constructor(mesh) {
    this.#mesh = mesh;
    this.onDispose = () => this.#freePools();
    mesh.addEventListener('dispose', this.onDispose);
  }

  get count() { return this.#mesh.count; }

  /** Looks at all instances again before the next pass. */
  forget() { this.#version = -1; }

  /** Why a geometry cannot be level `k`; `null` if it can. */
  whyNoLevel(geometry, k) {
    if (k === 0) return geometry === this.#mesh.geometry ? null : 'is not that of the mesh';
    return geometry?.isBufferGeometry && !geometry.isInstancedBufferGeometry && geometry.attributes.position ? null : 'is no BufferGeometry with positions';
  }

  /** Takes chains of levels, or others in their place. */
  setLevels(chains) {
    this.chains = chains?.size > 0 ? chains : null;
    this.chosen = null;
    this.forget();
    this.#freePools();
  }

  // The chain of the mesh's geometry.
  get #chain() { return this.chains?.get(this.#mesh.geometry); }

  /** Chooses levels for a camera's pass; for another, where `view` is `null`, everything is drawn in full. */
  choose(view, worldPlanes) {
    this.chosen = null;
    const mesh = this.#mesh;
    const chain = this.#chain;
    if (!view || !chain) return;
    this.#look();
    const own = viewIn(mesh.matrixWorld.elements, view);
    if (this.#levels.length < this.#capacity) this.#levels = new Uint8Array(this.#capacity);
    this.chosen = this.#levels.fill(0);
    planesInto(mesh.matrixWorld.elements, worldPlanes, planes);
    for (const k of this.#set.cull(planes)) this.chosen[k] = levelFor(own, this.#places, k, chain);
  }

  /** Whether an instance is drawn in full, as far as this pass has it in its frustum. */
  isFull(k) { return !(this.chosen?.[k] > 0); }

  // The box of the geometry, and of all its levels.
  #boxInto(to, at) {
    boxOf(this.#mesh.geometry, to, at);
    if (this.#chain) for (const one of this.#chain.geometries) { boxOf(one, level, 0); widen(to, at, level); }
  }

  #place(first, end) {
    if (!this.#chain) return;
    if (this.#places.length < PLACE * this.#capacity) this.#places = new Float64Array(PLACE * this.#capacity);
    this.#boxInto(box, 0);
    const { array } = this.#attribute;
    for (let k = first; k < end; k++) place(this.#places, k, box, 0, array, 16 * k);
  }

  /** Takes over instances that changed: `instanceMatrix.needsUpdate` tells, its update ranges tell which. */
  #look() {
    const mesh = this.#mesh;
    const { instanceMatrix: attribute, geometry } = mesh;
    if (this.#attribute === attribute && this.#version === attribute.version && this.#geometry === geometry) return;
    const all = this.#attribute !== attribute || this.#geometry !== geometry || this.#version < 0 || attribute.updateRanges.length === 0;
    const length = attribute.count;
    if (this.#attribute !== attribute || length !== this.#capacity) {
      this.#freePools();
      this.#set?.dispose();
      this.#set = new BoxSet(length);
      this.#capacity = length;
    }
    this.#attribute = attribute;
    this.#version = attribute.version;
    this.#geometry = geometry;
    const { array } = attribute;
    const { matrices } = this.#set;
    if (all) {
      const { boxes } = this.#set;
      matrices.set(array.subarray(0, 16 * length));
      if (length > 0) this.#boxInto(boxes, 0);
      for (let filled = 6; filled < 6 * length; filled *= 2) boxes.copyWithin(filled, 0, Math.min(filled, 6 * length - filled));
      this.#set.commitMoved(0, length);
      this.#place(0, length);
    } else {
      for (const { start, count } of attribute.updateRanges) {
        const first = Math.max(0, Math.floor(start / 16));
        const end = Math.min(length, Math.ceil((start + count) / 16));
        matrices.set(array.subarray(16 * first, 16 * end), 16 * first);
        this.#set.commitMoved(first, end - first);
        this.#place(first, end);
      }
    }
    // As three.js does once it has uploaded them.
    attribute.clearUpdateRanges();
  }

  /** What a pass draws in the mesh's place: a stand-in for each level that any visible instance has. `keep(list)` may shorten the list. */
  cull(pass, worldPlanes, keep) {
    const mesh = this.#mesh;
    this.#look();
    let list;
    if (mesh.frustumCulled === false) list = null;
    else if (worldPlanes.length === 24) {
      planesInto(mesh.matrixWorld.elements, worldPlanes, planes);
      list = this.#set.cull(planes);
    } else list = this.#ofAny(worldPlanes);
    if (list && keep) list = keep(list);
    const limit = Math.min(mesh.count, this.#capacity);
    let count = list ? list.length : limit;
    while (list && count > 0 && list[count - 1] >= limit) count -= 1;
    this.visible = count;
    this.coarser = 0;
    if (count === 0) return [];
    if (!list || !this.chosen) return [this.#fill(this.#standIn(pass, count, 0), list, count)];
    const lists = this.#lists;
    const geometries = this.#chain?.geometries ?? [mesh.geometry];
    for (let k = 0; k < geometries.length; k++) (lists[k] ??= []).length = 0;
    // Levels that are kept may be of another chain.
    for (let k = 0; k < count; k++) (lists[this.chosen[list[k]] < geometries.length ? this.chosen[list[k]] : 0]).push(list[k]);
    const drawn = [];
    for (let k = 0; k < geometries.length; k++) {
      const { length } = lists[k];
      if (length === 0) continue;
      if (k > 0) this.coarser += length;
      drawn.push(this.#fill(this.#standIn(pass, length, k), lists[k], length));
    }
    return drawn;
  }

  /** Of a list of instances those that `test` takes, by the box of the geometry and the matrix to the world: a list of its own. */
  filter(list, test) {
    const { instanceMatrix: { array }, matrixWorld } = this.#mesh;
    this.#boxInto(box, 0);
    return list.filter((k) => { multiply(matrixWorld.elements, array.subarray(16 * k, 16 * k + 16), matrix); return test(box, matrix); });
  }

  // Several cameras drawn as one: what any of them sees, ascending.
  #ofAny(worldPlanes) {
    const seen = new Set();
    for (let at = 0; at < worldPlanes.length; at += 24) {
      planesInto(this.#mesh.matrixWorld.elements, worldPlanes.subarray(at, at + 24), planes);
      for (const i of this.#set.cull(planes)) seen.add(i);
    }
    return Uint32Array.from(seen).sort();
  }

  #standIn(pass, count, number) {
    let pool = this.#pools.get(pass);
    if (!pool) this.#pools.set(pass, pool = []);
    const turn = pass.turn % MOST + MOST * number;
    const had = pool[turn];
    const { instanceColor } = this.#mesh;
    const geometry = number > 0 ? this.#chain.geometries[number] : this.#mesh.geometry;
    if (had && had.geometry === geometry && had.instanceMatrix.count >= count && (had.instanceColor === null) === (instanceColor === null)) return had;
    if (had) free(had);
    // A half more than is asked for, so that a turning camera does not ask each frame.
    return pool[turn] = makeStandIn(this.#mesh, Math.min(this.#capacity, Math.max(16, Math.ceil(1.5 * count))), number > 0 ? geometry : null);
  }

  #fill(standIn, list, count) {
    const { instanceMatrix, instanceColor } = this.#mesh;
    gather(instanceMatrix, standIn.instanceMatrix, list, count, 16);
    if (instanceColor) gather(instanceColor, standIn.instanceColor, list, count, 3);
    standIn.count = count;
    return standIn;
  }

  /** Off: three.js draws the mesh itself, whose own buffer may never have been uploaded. */
  enable(on) {
    if (on) return;
    const { instanceMatrix, instanceColor } = this.#mesh;
    instanceMatrix.clearUpdateRanges();
    instanceMatrix.needsUpdate = true;
    if (instanceColor) { instanceColor.clearUpdateRanges(); instanceColor.needsUpdate = true; }
  }

  #freePools() {
    for (const pool of this.#pools.values()) for (const standIn of pool) if (standIn) free(standIn);
    this.#pools.clear();
  }

  dispose() {
    this.#freePools();
    this.#set?.dispose();
    this.#set = null;
    this.#mesh.removeEventListener('dispose', this.onDispose);
    this.enable(false);
  }
}

function gather(from, to, list, count, size) {
  const [source, target] = [from.array, to.array];
  if (!list) target.set(source.subarray(0, size * count));
  else if (size === 16) {
    for (let i = 0, at = 0; i < count; i++) {
      let s = 16 * list[i];
      for (const end = at + 16; at < end; at++, s++) target[at] = source[s];
    }
  } else for (let i = 0, at = 0; i < count; i++) for (let k = 0; k < size; k++) target[at++] = source[size * list[i] + k];
  to.clearUpdateRanges();
  to.addUpdateRange(0, size * count);
  to.needsUpdate = true;
}

const own = (value) => ({ value, writable: true, configurable: true, enumerable: true });

// `geometry`: of a coarser level; the mesh's own is not kept, since it may be given another.
function makeStandIn(mesh, capacity, geometry) {
  const attribute = (from) => {
    const to = new from.constructor(new from.array.constructor(from.itemSize * capacity), from.itemSize, from.normalized, from.meshPerAttribute);
    to.usage = from.usage;
    return to;
  };
  // For its place in the sorted list: that of the mesh, of all instances.
  if (mesh.boundingSphere === null) mesh.computeBoundingSphere();
  return Object.create(mesh, {
    instanceMatrix: own(attribute(mesh.instanceMatrix)),
    instanceColor: own(mesh.instanceColor && attribute(mesh.instanceColor)),
    ...(geometry && { geometry: own(geometry) }),
    count: own(0),
    children: own([]),
    _listeners: own({}),
    modelViewMatrix: own(mesh.modelViewMatrix.clone()),
    normalMatrix: own(mesh.normalMatrix.clone()),
    // By the sphere of all instances, as three.js has it.
    intersectsFrustum: own((frustum) => mesh.intersectsFrustum(frustum)),
  });
}

function free(standIn) {
  standIn.dispatchEvent({ type: 'dispose' });
  standIn.instanceMatrix.dispose();
  standIn.instanceColor?.dispose();
}

// The objects below a root, one number each: parents before children, what was seen of each, and its box.

import { BoxSet } from './engine.js';
import { Batch } from './batch.js';
import { boxOf, isMorphed, Kind, kindOf, never } from './bounds.js';
import { Instances } from './instances.js';

const NONE = -1;
const STATE = 10;

export class Nodes {
  /** By number: the object (`null` once removed), its kind, its parent's number (-1: the root), its own list of children. */
  objects = [];
  kinds = new Uint8Array(0);
  parents = new Int32Array(0);
  /** Hidden by a parent, whatever the object's own `visible` says. */
  hidden = new Uint8Array(0);
  /** `Instances` or `Batch` of those kinds. */
  parts = new Map();
  /** Containers, and meshes with children: their `visible` and `renderOrder` hold for what is below. */
  holders = [];
  boxes = null;
  length = 0;
  /** What three.js itself moves and draws. */
  rest = [];
  /** Raised when objects come and go, or a holder's `visible` or `renderOrder` changes. */
  version = 0;

  #numbers = new Map();
  #state = new Float64Array(0);
  #geometries = [];
  #unculled = new Uint8Array(0);
  #culled = new Uint8Array(0);
  #shown = [];
  #orders = [];
  #held = new Uint8Array(0);
  #changed = new Uint8Array(0);
  #dirty = [];
  #boxes = new Float32Array(0);
  #matrices = new Float32Array(0);
  #root;
  #hooks;

  /** `hooks`: what is done to an object that comes (`take`) and goes (`free`). */
  constructor(root, hooks) {
    this.#root = root;
    this.#hooks = hooks;
  }

  /** Room for so many objects, so that adding them makes none anew. */
  reserve(count) { if (count > this.kinds.length) this.#grow(count); }

  /** Whether an object is drawn whatever is seen: its bounds say nothing. */
  isUnculled(i) { return this.#unculled[i] === 1; }

  numberOf(object) { return this.#numbers.get(object) ?? NONE; }

  /** Takes `object` and what is below it; world matrices must be up to date. */
  add(object, parent) {
    const kind = kindOf(object, this.#hooks.movesVertices);
    const i = this.length;
    if (i === this.kinds.length) this.#grow(Math.max(64, 2 * i));
    this.length += 1;
    this.version += 1;
    this.objects[i] = object;
    this.kinds[i] = kind;
    this.parents[i] = parent;
    this.#numbers.set(object, i);
    this.#remember(i, object);
    if (kind === Kind.Instanced) this.parts.set(i, new Instances(object));
    else if (kind === Kind.Batched) this.parts.set(i, new Batch(object));
    this.#hooks.take(object, kind);
    this.#writeBounds(i);
    if (kind === Kind.Rest) { this.rest.push(i); return; }
    const { children } = object;
    if (kind === Kind.Container || children.length > 0) this.#hold(i);
    for (let k = 0; k < children.length; k++) this.add(children[k], i);
  }

  /** Lets go of `object` and of all below it. */
  remove(object) {
    const i = this.numberOf(object);
    if (i === NONE) return;
    const holds = this.#held[i] === 1;
    this.#free(i);
    if (holds) for (const child of object.children) this.remove(child);
    this.version += 1;
  }

  /** Whether most numbers are of objects that went: time to number those that are left anew. */
  get isSparse() { return this.length > 256 && this.#numbers.size < this.length / 2; }

  #free(i) {
    const object = this.objects[i];
    this.#hooks.free(object, this.kinds[i]);
    this.parts.get(i)?.dispose();
    this.parts.delete(i);
    this.#numbers.delete(object);
    this.objects[i] = null;
    this.#geometries[i] = null;
    this.kinds[i] = Kind.Rest;
  }

  #hold(i) {
    if (this.#held[i] === 1) return;
    this.#held[i] = 1;
    this.holders.push(i);
  }

  /** A mesh that has got its first child; containers are holders from the start. */
  adopt(i) { if (this.kinds[i] !== Kind.Rest && this.kinds[i] !== Kind.Container) this.#hold(i); }

  #grow(capacity) {
    const more = (old, width = 1) => { const array = new old.constructor(width * capacity); array.set(old); return array; };
    this.kinds = more(this.kinds);
    this.parents = more(this.parents);
    this.hidden = more(this.hidden);
    this.#unculled = more(this.#unculled);
    this.#culled = more(this.#culled);
    this.#held = more(this.#held);
    this.#changed = more(this.#changed);
    this.#state = more(this.#state, STATE);
    const old = this.boxes;
    this.boxes = new BoxSet(capacity);
    old?.dispose();
    this.#matrices = this.boxes.matrices;
    this.#boxes = this.boxes.boxes;
    this.#dirty.length = 0;
    for (let i = 0; i < this.length; i++) if (this.objects[i]) this.#writeBounds(i);
  }

  // Containers have an empty box, which is never visible.
  #writeBounds(i) {
    // Views are empty once the engine's memory grew.
    if (this.#matrices.length === 0) [this.#matrices, this.#boxes] = [this.boxes.matrices, this.boxes.boxes];
    if (this.#boxes.length === 0) this.#boxes = this.boxes.boxes;
    const [boxes, matrices] = [this.#boxes, this.#matrices];
    const object = this.objects[i];
    const kind = this.kinds[i];
    const at = 6 * i;
    this.#geometries[i] = object.geometry;
    this.#culled[i] = Number(Boolean(object.frustumCulled));
    this.#unculled[i] = Number(!object.frustumCulled || isMorphed(object));
    this.#hooks.placed(i);
    if (kind === Kind.Mesh) {
      if (this.#unculled[i]) never(boxes, at);
      else boxOf(object.geometry, boxes, at);
    } else if (kind === Kind.Instanced || kind === Kind.Batched) never(boxes, at);
    else { boxes.fill(1, at, at + 3); boxes.fill(-1, at + 3, at + 6); }
    const { elements } = object.matrixWorld;
    for (let k = 0; k < 16; k++) matrices[16 * i + k] = elements[k];
    this.#dirty.push(i);
  }

  /** Gives the engine the boxes that changed. */
  commit() {
    const dirty = this.#dirty;
    if (dirty.length === 0) return;
    if (dirty.length * 4 > this.length) this.boxes.commitMoved(0, this.length);
    else for (const i of dirty) this.boxes.commitMoved(i, 1);
    dirty.length = 0;
  }

  /** Numbers that any of several cameras sees, ascending: `planes` has twenty-four numbers for each. */
  seenByAny(planes) {
    const seen = new Uint8Array(this.length);
    for (let at = 0; at < planes.length; at += 24) for (const i of this.boxes.cull(planes.subarray(at, at + 24))) seen[i] = 1;
    const list = [];
    for (let i = 0; i < seen.length; i++) if (seen[i] === 1) list.push(i);
    return list;
  }

  #remember(i, { position: p, quaternion: q, scale: s }) {
    const state = this.#state;
    const at = STATE * i;
    state[at] = p.x; state[at + 1] = p.y; state[at + 2] = p.z;
    state[at + 3] = q.x; state[at + 4] = q.y; state[at + 5] = q.z; state[at + 6] = q.w;
    state[at + 7] = s.x; state[at + 8] = s.y; state[at + 9] = s.z;
  }

  /**
   * World matrices and boxes of all that moved, as `Object3D.updateMatrixWorld` would have them, but composing only where
   * position, rotation or scale are others than last time. `all`: everything anew.
   */
  look(rootMoved, all) {
    const { objects, kinds, parents, length } = this;
    const [changed, state, geometries, culled] = [this.#changed, this.#state, this.#geometries, this.#culled];
    for (let i = 0, at = 0; i < length; i++, at += STATE) {
      const object = objects[i];
      if (object === null) continue;
      const kind = kinds[i];
      const parent = parents[i];
      const force = all || (parent === NONE ? rootMoved : changed[parent] === 1);
      if (kind === Kind.Rest) { object.updateMatrixWorld(force); continue; }
      if (object.matrixAutoUpdate) {
        let moved = force || object.pivot !== null;
        if (!moved) {
          // Written out: in a function of its own it takes twice as long.
          const { position: p, quaternion: q, scale: s } = object;
          moved = state[at] !== p.x || state[at + 1] !== p.y || state[at + 2] !== p.z
            || state[at + 3] !== q.x || state[at + 4] !== q.y || state[at + 5] !== q.z || state[at + 6] !== q.w
            || state[at + 7] !== s.x || state[at + 8] !== s.y || state[at + 9] !== s.z;
        }
        if (moved) {
          object.updateMatrix();
          this.#remember(i, object);
        }
      }
      if (force || object.matrixWorldNeedsUpdate) {
        this.#place(object);
        changed[i] = 1;
        if (kind !== Kind.Container) this.#writeBounds(i);
      } else {
        changed[i] = 0;
        if (kind !== Kind.Container && (geometries[i] !== object.geometry || (culled[i] === 1) !== Boolean(object.frustumCulled))) this.#writeBounds(i);
      }
    }
  }

  /** As `look`, for what three.js itself moves each frame and nobody else may: lights, cameras, skinned meshes, ... */
  lookAtRest(rootMoved) {
    for (const i of this.rest) this.objects[i]?.updateMatrixWorld(rootMoved);
  }

  #place(object) {
    if (object.matrixWorldAutoUpdate) object.matrixWorld.multiplyMatrices(object.parent.matrixWorld, object.matrix);
    object.matrixWorldNeedsUpdate = false;
  }

  /** One object and what is below it, anew: matrices, boxes, parts. */
  refresh(first) {
    const object = this.objects[first];
    object.updateWorldMatrix(true, true, true);
    const below = new Set([first]);
    for (let i = first; i < this.length; i++) {
      if (this.objects[i] === null || !(i === first || below.has(this.parents[i]))) continue;
      below.add(i);
      this.#remember(i, this.objects[i]);
      this.parts.get(i)?.forget();
      if (this.kinds[i] !== Kind.Rest) this.#writeBounds(i);
    }
  }

  /** Whether an object is now to be treated otherwise than when it came: another material or geometry may do that. */
  changesKind(i) { return kindOf(this.objects[i], this.#hooks.movesVertices) !== this.kinds[i]; }

  /** Notices holders that were hidden, shown or ordered otherwise. */
  lookAtHolders() {
    let same = true;
    for (const i of this.holders) {
      if (this.objects[i] === null) continue;
      const { visible, renderOrder } = this.objects[i];
      if (this.#shown[i] === visible && this.#orders[i] === renderOrder) continue;
      this.#shown[i] = visible;
      this.#orders[i] = renderOrder;
      same = false;
    }
    if (!same) this.version += 1;
  }

  /** For each number, whether a holder above hides it: after `version` was raised. */
  inherit() {
    const { objects, parents, hidden } = this;
    for (let i = 0; i < this.length; i++) {
      const parent = parents[i];
      hidden[i] = parent === NONE || objects[i] === null ? 0 : Number(hidden[parent] === 1 || objects[parent].visible === false);
    }
  }

  dispose() {
    for (let i = 0; i < this.length; i++) if (this.objects[i] !== null) this.#free(i);
    this.boxes?.dispose();
    this.length = 0;
    this.holders.length = this.rest.length = 0;
  }
}

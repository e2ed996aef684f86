// What is hidden behind other meshes, for the cameras that asked for it.
//
// The engine keeps a scene of its own of all that is culled by its box, with the triangles of what may hide others. It is
// conservative at every resolution, so what it drops would have covered no pixel. An instance that is drawn at a coarser level hides
// nothing in that pass: the level may lie within the outline of the finest, which is what the engine knows.

import { Scene } from './engine.js';
import { boxOf, Kind } from './bounds.js';
import { Cut } from './clip.js';
import { worldBox } from './footprint.js';
import { callsBack, judge, May, refusal } from './hiding.js';
import { isPassOf, multiply } from './planes.js';

// A buffer of this width is enough for any screen: proofs hold at every resolution.
const WIDTH = 1280;
// How many large meshes are looked for in pieces, and in how many along their longest side.
const [MOST_TILED, TILES] = [4, 128];

// What an object does in the engine's scene.
const Role = { Absent: -1, Alone: 0, Hidden: 1, Hides: 2, HidesTwoSided: 3 };

// An instance that is drawn, one that no plane touches, and one that is drawn at a coarser level.
const State = { Shown: 1, Whole: 2, Coarse: 4 };
const NO_ID = 2 ** 32 - 1;

const named = (object) => `${object.type}${object.name ? ` "${object.name}"` : ''}`;

export class Occlusion {
  #nodes;
  #cameras;
  #preset;
  #scene = null;
  #views = new Map();
  #keys = new Map();
  #untested = false;
  #positions = [];
  #indices = [];
  #matrices = [];
  #meshes = new Map();
  #ids = new Map();
  #stamps = new Uint32Array(0);
  #stamp = 0;
  #matrix = new Float64Array(16);
  #version = -1;
  #looked = [];
  #geometries = [];
  #versions = [];
  #instances = [];
  #moved = new Map();
  #root;
  #callbacks;
  #cost;
  #judged = new Map();
  #clip = null;
  #clipKeys = [];
  #states = new Map();
  #cut = 0;
  #hasBatches = false;
  #coarse = new Set();
  #hasTiles;
  #tiles = new Map();
  #untiled = new WeakSet();
  /** Why the last pass hid nothing; `null` if it was looked for what is hidden. */
  refusal = null;

  constructor(nodes, root, { cameras, preset, callbacks, cost, hasTiles }) {
    this.#hasTiles = hasTiles;
    this.#nodes = nodes;
    this.#root = root;
    this.#cameras = cameras;
    this.#preset = preset;
    this.#callbacks = callbacks;
    this.#cost = cost;
  }

  /** The camera whose pass this is, if it is one of those given. */
  cameraOf(layers, planes) {
    const camera = this.#cameras.find((c) => c.layers === layers);
    return camera && !camera.isArrayCamera && isPassOf(camera, layers, planes) ? camera : null;
  }

  /** Finds what a camera may see; `false` where that is not to be known. Then `isHidden` tells of numbers and their instances. `clip`: planes. */
  cull(camera, scene, renderer, clip) {
    this.refusal = refusal(renderer);
    if (this.refusal) return false;
    this.#clip = clip;
    // Materials may change without telling: each is looked at once a pass.
    this.#judged.clear();
    this.#untested = !renderer.isWebGLRenderer;
    this.refusal = this.#look(scene.overrideMaterial ?? null, camera) ?? this.#lookOutside(scene, camera);
    if (this.refusal) return false;
    let view = this.#views.get(camera);
    const depth = depthOf(camera);
    const { microseconds } = this.#cost;
    const key = `${depth} ${microseconds}`;
    if (view && this.#keys.get(camera) !== key) { view.dispose(); view = undefined; }
    if (!view) {
      view = this.#scene.view({ preset: this.#preset, output: 'instances', depth, drawMicroseconds: microseconds });
      this.#views.set(camera, view);
      this.#keys.set(camera, key);
    }
    multiply(camera.projectionMatrix.elements, camera.matrixWorldInverse.elements, this.#matrix);
    // A camera without size sees nothing that can be told.
    if (!this.#matrix.every(Number.isFinite)) { this.refusal = 'the camera is not finite'; return false; }
    const { elements: p } = camera.projectionMatrix;
    const height = Math.round(Math.min(4096, Math.max(64, WIDTH * Math.abs(p[0] / p[5]))));
    let list;
    try { list = view.setCamera(this.#matrix, WIDTH, height, camera.layers.mask >>> 0).cull(); } catch (error) {
      if (error.code !== 'camera') throw error;
      this.refusal = 'the camera shows no volume';
      return false;
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
      if (id === undefined || id === NO_ID || stamps[id] === stamp) kept[count++] = list[k];
    }
    return kept.subarray(0, count);
  }

  /** Something moved: its matrices are taken anew before the next pass. */
  moved(i) { this.#moved.set(i, true); }

  #judge(material) {
    let bits = this.#judged.get(material);
    if (bits === undefined) this.#judged.set(material, bits = judge(material, this.#untested));
    return bits;
  }

  // Why an object that is drawn keeps everything from being hidden; `null` if it does not.
  #spoils(object) {
    if (!this.#callbacks && callsBack(object)) return `${named(object)} has an onBeforeRender or onAfterRender of its own, which may clear depth (the option callbacks vouches for it)`;
    const { material } = object;
    for (const m of Array.isArray(material) ? material : [material]) {
      if (!m) continue;
      const bits = this.#judge(m);
      if (bits & May.ResetDepth) return `${named(object)} writes depth where it is farther`;
      if (!this.#callbacks && bits & May.CallBack) return `the material of ${named(object)} has an onBeforeRender of its own, which may clear depth (the option callbacks vouches for it)`;
    }
    return null;
  }

  // All that is drawn of a tree, but what is below `except`: lines, points, sprites, and what three.js culls by itself.
  #spoilsBelow(top, camera, except) {
    if (top === except || !top.visible) return null;
    if (top.material && top.layers.test(camera.layers)) {
      const why = this.#spoils(top);
      if (why) return why;
    }
    for (const child of top.children) {
      const why = this.#spoilsBelow(child, camera, except);
      if (why) return why;
    }
    return null;
  }

  #lookOutside(scene, camera) {
    const { objects, rest } = this.#nodes;
    for (const i of rest) {
      const why = objects[i] === null || this.#nodes.hidden[i] === 1 ? null : this.#spoilsBelow(objects[i], camera, null);
      if (why) return why;
    }
    return this.#root === scene ? null : this.#spoilsBelow(scene, camera, this.#root);
  }

  // What is drawn, and how, decides what may hide: looked at before each pass, for a mesh that is hidden must hide nothing. Why
  // nothing may be hidden; `null` if it may.
  #look(override, camera) {
    const { objects, kinds, hidden: under, length, parts } = this.#nodes;
    if (override && this.#judge(override) & May.ResetDepth) return 'scene.overrideMaterial writes depth where it is farther';
    let same = this.#scene !== null && this.#version === this.#nodes.version;
    const looked = this.#looked;
    for (let i = 0; i < length; i++) {
      if (kinds[i] < Kind.Mesh || objects[i] === null) continue;
      const object = objects[i];
      const isDrawn = under[i] === 0 && object.visible;
      if (isDrawn && object.layers.test(camera.layers)) {
        const why = this.#spoils(object);
        if (why) return why;
      }
      const now = isDrawn ? this.#roleOf(object, override) : Role.Absent;
      const { geometry, instanceMatrix } = object;
      const { position } = geometry.attributes;
      const batch = kinds[i] === Kind.Batched ? parts.get(i) : null;
      const version = `${position?.version ?? position?.data?.version} ${geometry.index?.version} ${batch?.revision}`;
      if (looked[i] !== now || this.#geometries[i] !== geometry || this.#positions[i] !== position || this.#indices[i] !== geometry.index
        || this.#versions[i] !== version) same = false;
      [looked[i], this.#geometries[i], this.#versions[i], this.#positions[i], this.#indices[i]] = [now, geometry, version, position, geometry.index];
      if (batch) {
        if (this.#instances[i] !== batch.matricesVersion) this.#moved.set(i, true);
        this.#instances[i] = batch.matricesVersion;
      } else if (instanceMatrix) {
        const instances = instanceMatrix.version + object.count / 2 ** 32;
        if (this.#instances[i] !== instances || this.#matrices[i] !== instanceMatrix) this.#moved.set(i, true);
        [this.#instances[i], this.#matrices[i]] = [instances, instanceMatrix];
      }
    }
    // Other numbers of instances, or some that are not finite now: another scene.
    for (const i of this.#moved.keys()) same = same && this.#place(i);
    if (!same) this.#make();
    else if (this.#moved.size > 0) this.#scene.refit();
    this.#recut();
    this.#moved.clear();
    return null;
  }

  // The role of an object, and its layers.
  #roleOf(object, override) {
    const { material, geometry: { drawRange } } = object;
    let bits = override === null ? -1 : this.#judge(override);
    for (const m of Array.isArray(material) ? material : [material]) bits &= this.#judge(m);
    const isWhole = drawRange.start === 0 && drawRange.count === Infinity && !Array.isArray(material);
    let role = Role.Hidden;
    if (!(bits & May.BeHidden)) role = Role.Alone;
    else if (isWhole && bits & May.Hide) role = Role.Hides;
    else if (isWhole && bits & May.HideTwoSided) role = Role.HidesTwoSided;
    return role + 4 * (object.layers.mask >>> 0);
  }

  #make() {
    this.#free();
    this.#scene = new Scene();
    this.#version = this.#nodes.version;
    const { objects, kinds, length } = this.#nodes;
    for (let i = 0; i < length; i++) {
      const role = this.#looked[i];
      if (kinds[i] < Kind.Mesh || objects[i] === null || role === Role.Absent || role % 4 === Role.Alone || this.#nodes.isUnculled(i)) continue;
      if (kinds[i] === Kind.Batched) { this.#makeBatch(i, role); continue; }
      const mesh = this.#meshOf(objects[i].geometry, role % 4);
      const matrices = this.#matricesOf(i);
      // What is not finite stays visible, and outside this scene.
      if (!matrices.every(Number.isFinite)) continue;
      this.#ids.set(i, this.#scene.addMany(mesh, matrices, { layers: objects[i].layers.mask >>> 0, occluder: role % 4 >= Role.Hides }));
    }
    if (this.#hasTiles) this.#makeTiles();
    this.#scene.commit();
  }

  // Large meshes that receive shadows are looked for in pieces, too: what is seen of the ground says which shadows are.
  #makeTiles() {
    const { objects, kinds, length } = this.#nodes;
    const all = new Float64Array(6).fill(-Infinity);
    const large = [];
    for (const pass of [0, 1]) {
      for (let i = 0; i < length; i++) {
        if (kinds[i] !== Kind.Mesh || !this.#ids.has(i)) continue;
        boxOf(objects[i].geometry, box, 0);
        const world = new Float64Array(6);
        worldBox(box, 0, objects[i].matrixWorld.elements, 0, world, 0);
        for (let c = 0; pass === 0 && c < 3; c++) { all[c] = Math.max(all[c], -world[c]); all[3 + c] = Math.max(all[3 + c], world[3 + c]); }
        const least = Math.max(all[0] + all[3], all[1] + all[4], all[2] + all[5]) / 4;
        if (pass === 1 && objects[i].receiveShadow && !this.#untiled.has(objects[i]) && large.length < MOST_TILED && [0, 1, 2].some((c) => world[3 + c] - world[c] >= least)) large.push([i, world]);
      }
    }
    if (large.length === 0) return;
    const unit = this.#scene.addBox([0, 0, 0, 1, 1, 1]);
    for (const [i, world] of large) {
      const size = [0, 1, 2].map((c) => world[3 + c] - world[c]);
      const tile = Math.max(...size) / TILES;
      const counts = size.map((s) => Math.max(1, Math.round(s / tile)));
      // A tall building is no ground.
      if (counts[0] * counts[1] * counts[2] > 2 * TILES * TILES) continue;
      const matrices = [];
      for (let x = 0; x < counts[0]; x++) for (let y = 0; y < counts[1]; y++) for (let z = 0; z < counts[2]; z++) {
        // Not flat: the engine takes what has no volume for nothing.
        const [a, b, c] = size.map((s, k) => Math.max(s / counts[k], 0.01 * tile));
        matrices.push(a, 0, 0, 0, 0, b, 0, 0, 0, 0, c, 0, world[0] + x * size[0] / counts[0], world[1] + y * size[1] / counts[1], world[2] + z * size[2] / counts[2], 1);
      }
      const ids = this.#scene.addMany(unit, Float64Array.from(matrices), { layers: objects[i].layers.mask >>> 0, occluder: false });
      this.#tiles.set(i, { ids, matrices });
    }
  }

  // What moves is looked for as a whole from then on.
  #dropTiles(i) {
    const tiles = this.#tiles.get(i);
    if (!tiles) return;
    for (const id of tiles.ids) this.#scene.remove(id);
    this.#tiles.delete(i);
    this.#untiled.add(this.#nodes.objects[i]);
  }

  /** Boxes in the world of all that may be seen of a large mesh; `null` of another. */
  piecesOf(i) {
    const tiles = this.#tiles.get(i);
    if (!tiles) return null;
    const boxes = [];
    for (let k = 0; k < tiles.ids.length; k++) {
      if (this.#stamps[tiles.ids[k]] !== this.#stamp) continue;
      const m = tiles.matrices;
      const [x, y, z] = [m[16 * k + 12], m[16 * k + 13], m[16 * k + 14]];
      boxes.push([x, y, z, x + m[16 * k], y + m[16 * k + 5], z + m[16 * k + 10]]);
    }
    return boxes;
  }

  // What planes touch, or is drawn at a coarser level, hides nothing, until that is otherwise.
  #recut() {
    const clip = this.#clip;
    const { objects } = this.#nodes;
    const { parts } = this.#nodes;
    if (!clip.isActive && this.#cut === 0 && !this.#hasBatches && this.#coarse.size === 0 && ![...parts.values()].some(({ chosen }) => chosen)) return;
    this.#cut = 0;
    for (const [i, ids] of this.#ids) {
      const part = parts.get(i) ?? null;
      const batch = this.#nodes.kinds[i] === Kind.Batched ? part : null;
      const hides = this.#looked[i] % 4 >= Role.Hides;
      if (!hides && !batch) continue;
      const key = hides && clip.clips(objects[i]) ? clip.key + clip.keyFor(objects[i]) : '';
      if (key !== '') this.#cut += 1;
      const had = this.#clipKeys[i] ?? '';
      const isSame = had === key && (key === '' || !this.#moved.has(i));
      // Once more when none is chosen any more.
      const isCoarse = this.#coarse.delete(i);
      if (part?.chosen) this.#coarse.add(i);
      if (isSame && !batch && !isCoarse && !part?.chosen) continue;
      this.#clipKeys[i] = key;
      let states = this.#states.get(i);
      if (!states) this.#states.set(i, states = new Uint8Array(ids.length).fill(State.Shown + State.Whole));
      const matrices = key === '' || isSame ? null : this.#matricesOf(i);
      if (matrices && !batch) boxOf(objects[i].geometry, box, 0);
      for (let k = 0; k < ids.length; k++) {
        if (ids[k] === NO_ID) continue;
        if (matrices && batch) batch.boxOf(k, box);
        let now = batch && !batch.isShown(k) ? 0 : State.Shown;
        if (part && !part.isFull(k)) now += State.Coarse;
        if (isSame) now += states[k] & State.Whole;
        else if (matrices === null || clip.cut(objects[i], box, 0, matrices, 16 * k) === Cut.Whole) now += State.Whole;
        if (now === states[k]) continue;
        states[k] = now;
        this.#scene.setState(ids[k], { layers: now & State.Shown ? objects[i].layers.mask >>> 0 : 0, occluder: hides && (now & (State.Whole + State.Coarse)) === State.Whole });
      }
    }
  }

  // Instances of a batch, by their geometries; those that are in none have no id.
  #makeBatch(i, role) {
    const batch = this.#nodes.parts.get(i);
    const object = this.#nodes.objects[i];
    const lists = batch.byGeometry();
    const ids = new Uint32Array(batch.length).fill(NO_ID);
    const state = { layers: object.layers.mask >>> 0, occluder: role % 4 >= Role.Hides };
    for (const [geometry, list] of lists) {
      const matrices = batch.matricesOf(list);
      if (!matrices.every(Number.isFinite)) continue;
      this.#scene.addMany(this.#meshOf(batch.geometryOf(geometry), role % 4), matrices, state).forEach((id, k) => { ids[list[k]] = id; });
    }
    this.#ids.set(i, ids);
    this.#hasBatches = true;
  }

  #matricesOf(i) {
    const object = this.#nodes.objects[i];
    if (this.#nodes.kinds[i] === Kind.Batched) return this.#nodes.parts.get(i).matricesOf();
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
    if (!ids) return this.#looked[i] === Role.Absent || this.#looked[i] % 4 === Role.Alone || this.#nodes.isUnculled(i) || this.#nodes.kinds[i] < Kind.Mesh;
    if (this.#nodes.kinds[i] === Kind.Batched) {
      const list = ids.map((id, k) => (id === NO_ID ? NO_ID : k)).filter((k) => k !== NO_ID);
      const batch = this.#nodes.parts.get(i);
      const matrices = ids.length === batch.length && !this.#nodes.isUnculled(i) ? batch.matricesOf(list) : [NaN];
      if (!matrices.every(Number.isFinite)) return false;
      this.#scene.setTransforms(list.map((k) => ids[k]), matrices);
      return true;
    }
    const matrices = this.#matricesOf(i);
    this.#dropTiles(i);
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
    const box = geometry.box ?? [];
    if (!geometry.box) boxOf(geometry, box, 0);
    mesh = role >= Role.Hides && usable
      ? this.#scene.addMesh(positions, indices, { twoSided: role === Role.HidesTwoSided })
      : this.#scene.addBox(box);
    this.#meshes.set(key, mesh);
    return mesh;
  }

  /** Ends it. */
  dispose() { this.#free(); }

  #free() {
    for (const view of this.#views.values()) view.dispose();
    this.#views.clear();
    this.#meshes.clear();
    this.#ids.clear();
    this.#states.clear();
    this.#cut = 0;
    this.#hasBatches = false;
    this.#coarse.clear();
    this.#tiles.clear();
    this.#clipKeys.length = 0;
    this.#scene?.dispose();
    this.#scene = null;
  }
}

let kept = new Uint32Array(1024);
const box = new Float64Array(6);

const depthOf = (camera) => {
  if (camera.reversedDepth) return 'reversed';
  return camera.coordinateSystem === 2001 ? 'standard' : 'webgl';
};

// Culling of a scene or group of three.js, for every pass that a renderer makes.

import { Kind, meshClass } from './bounds.js';
import { isInert } from './init.js';
import { worldBox } from './footprint.js';
import { Clipping, Cut } from './clip.js';
import { DrawCost } from './cost.js';
import { Decisions, Fate } from './decisions.js';
import { explain } from './explain.js';
import { Chains, viewOf } from './levels.js';
import { Nodes } from './nodes.js';
import { Occlusion } from './occlusion.js';
import { isPassOf, planesOf } from './planes.js';
import { Renders } from './renders.js';
import { camerasOf, check, isBelow, nameOf, orderAbove, taken } from './roots.js';
import { casting, complete, prepare, Receivers } from './shadows.js';
import { push, shorten, stop, Walk } from './walk.js';

export class Culling {
  #root;
  #nodes;
  #walk;
  #door;
  #kids = new Map();
  #pending = [];
  #rootWorld = new Float64Array(16);
  #planes = new Float64Array(24);
  #seenVersion = -1;
  #carriers = [];
  #base = 0;
  #asked = null;
  #Mesh = null;
  #still;
  #movesVertices;
  #wanted;
  #occlusion = null;
  #renders;
  #byReceivers;
  #lights = [];
  #box = new Float64Array(6);
  #enabled = true;
  #passes = new WeakMap();
  #turns = [];
  #always;
  #disposed = false;
  #inert = false;
  #layersTest;
  #children;
  #gone;
  #cost;
  // Draws beyond one for each mesh.
  #more = 0;
  #decisions = new Decisions();
  #chains = new Chains();
  #panel = null;
  #stats = { passes: 0, objects: 0, visible: 0, instances: 0, visibleInstances: 0, coarserInstances: 0, hidden: 0, hiddenInstances: 0, clipped: 0, noOcclusion: null, keptMaps: 0, allCast: null, drawMicroseconds: 0, drawMicrosecondsFrom: 'default', milliseconds: 0 };

  constructor(root, { still = false, movesVertices = undefined, occlusion = undefined, preset = 'balanced', callbacks = false, drawMicroseconds = undefined, shadows = 'all' } = {}) {
    check(root);
    const cameras = camerasOf(occlusion);
    this.#cost = new DrawCost(drawMicroseconds);
    this.#tellCost();
    if (isInert()) {
      this.#root = root;
      this.#still = Boolean(still);
      [this.#inert, this.#disposed, this.#enabled] = [true, true, false];
      return;
    }
    this.#wanted = cameras && { cameras, preset, callbacks: Boolean(callbacks), cost: this.#cost, hasTiles: shadows === 'seen' };
    if (shadows !== 'all' && shadows !== 'seen') throw new TypeError(`cullet: shadows is 'all' or 'seen', not ${String(shadows)}`);
    this.#byReceivers = shadows === 'seen';
    this.#root = root;
    this.#still = Boolean(still);
    this.#movesVertices = movesVertices;
    taken.set(root, this);
    this.#renders = new Renders(root);
    this.#always = Object.assign(() => true, { cullet: true });
    this.#walk = new Walk((frustum) => this.#cull(this.#asked, frustum));
    this.#children = (event) => { this.#pending.push(event.child, event.target); };
    this.#gone = ({ child }) => this.#nodes.remove(child);
    this.#build();
    this.#hook();
  }

  get root() { return this.#root; }

  get enabled() { return this.#enabled; }

  set enabled(on) {
    if (this.#disposed || Boolean(on) === this.#enabled) return;
    this.#enabled = Boolean(on);
    for (const part of this.#nodes.parts.values()) part.enable(this.#enabled);
    complete(this.#lights);
    if (this.#enabled) this.update();
  }

  get still() { return this.#still; }

  set still(on) {
    this.#still = Boolean(on);
    if (!this.#still && !this.#disposed) this.update();
  }

  get stats() { return this.#stats; }

  get frozen() { return this.#decisions.isFrozen; }

  set frozen(on) {
    if (this.#disposed || Boolean(on) === this.frozen) return;
    this.#decisions.isFrozen = Boolean(on);
    complete(this.#lights);
  }

  explain(object) {
    if (!object?.isObject3D) throw new TypeError(`cullet: explain() takes an object of the scene, not ${nameOf(object)}`);
    if (this.#disposed || !this.#enabled) return { reason: 'three', text: `${nameOf(object)}: culling is off, so three.js decides.` };
    this.#flush(true);
    return explain(object, this.#root, this.#nodes, this.#decisions.last);
  }

  async panel(options) {
    if (this.#disposed && !this.#inert) throw new Error('cullet: panel() of a culling that was disposed; make another one');
    this.#panel ??= import('./panel.js').then(({ Panel }) => new Panel(this, {
      decisions: this.#decisions, nodes: () => this.#nodes, closed: () => { this.#panel = null; },
    }, options));
    return this.#panel;
  }

  update(object) {
    if (this.#inert) return;
    if (this.#disposed) throw new Error('cullet: update() of a culling that was disposed; make another one');
    this.#flush(true);
    if (object === undefined || object === this.#root) {
      this.#root.updateWorldMatrix(true, false);
      this.#rebuild();
      return;
    }
    const i = this.#nodes.numberOf(object);
    // Below a light, a camera, an LOD: three.js's own business.
    if (i < 0 || this.#nodes.kinds[i] === Kind.Rest) {
      if (!isBelow(object, this.#root)) throw new Error(`cullet: update() of ${nameOf(object)}, which is not below ${nameOf(this.#root)}; add it to that first`);
      object.updateWorldMatrix(true, true, true);
      if (i >= 0) this.#renew(object);
      return;
    }
    if (this.#nodes.changesKind(i)) this.#renew(object);
    else this.#nodes.refresh(i);
  }

  levels(mesh, list, options) {
    if (this.#inert) return;
    if (this.#disposed) throw new Error('cullet: levels() of a culling that was disposed; make another one');
    this.#flush(true);
    this.#chains.take(mesh, this.#nodes.parts.get(this.#nodes.numberOf(mesh)), this.#root, list, options);
  }

  dispose() {
    if (this.#disposed) return;
    this.#disposed = true;
    this.#panel?.then((panel) => panel.dispose());
    const root = this.#root;
    this.#occlusion?.dispose();
    complete(this.#lights);
    this.#renders.dispose();
    this.#nodes.dispose();
    this.#door.drop();
    for (const kid of this.#kids.values()) kid.drop();
    this.#kids.clear();
    delete root.updateMatrixWorld;
    delete root.raycast;
    if (root.layers.test === this.#layersTest) delete root.layers.test;
    root.removeEventListener('childadded', this.#children);
    root.removeEventListener('childremoved', this.#gone);
    taken.delete(root);
  }

  #build() {
    this.#decisions.clear();
    const nodes = this.#nodes = new Nodes(this.#root, {
      take: (object, kind) => this.#take(object, kind),
      free: (object, kind) => this.#free(object, kind),
      placed: (i) => this.#occlusion?.moved(i),
      movesVertices: this.#movesVertices,
    });
    this.#occlusion = this.#wanted ? new Occlusion(nodes, this.#root, this.#wanted) : null;
    this.#root.updateWorldMatrix(true, true);
    this.#rootWorld.set(this.#root.matrixWorld.elements);
    let count = 0;
    this.#root.traverse(() => { count += 1; });
    nodes.reserve(count);
    for (const child of this.#door?.all() ?? this.#root.children) nodes.add(child, -1);
    this.#seenVersion = -1;
  }

  #rebuild() {
    this.#occlusion?.dispose();
    this.#nodes.dispose();
    for (const kid of this.#kids.values()) kid.drop();
    this.#kids.clear();
    this.#pending.length = 0;
    this.#build();
  }

  #renew(object) {
    const parent = object.parent === this.#root ? -1 : this.#nodes.numberOf(object.parent);
    this.#nodes.remove(object);
    this.#nodes.add(object, parent);
  }

  #hook() {
    const root = this.#root;
    this.#door = shorten(root, () => { this.#prepare(); return this.#walk.children; });
    const { layers } = root;
    const test = Object.getPrototypeOf(layers).test;
    // A `layers` that someone puts in the place of this one leaves three.js to itself: all is drawn, only slower.
    this.#layersTest = (asked) => { if (this.#enabled) { this.#asked = asked; this.#door.arm(); } return test.call(layers, asked); };
    layers.test = this.#layersTest;
    // A raycaster asks for layers too.
    const { raycast } = root;
    root.raycast = (...values) => { this.#door.disarm(); return raycast.apply(root, values); };
    root.updateMatrixWorld = (force) => this.#updateMatrixWorld(force);
    root.addEventListener('childadded', this.#children);
    root.addEventListener('childremoved', this.#gone);
  }

  #take(object, kind) {
    if (kind !== Kind.Rest) {
      object.addEventListener('childadded', this.#children);
      object.addEventListener('childremoved', this.#gone);
    }
    if (object.isSkinnedMesh && !Object.hasOwn(object, 'intersectsFrustum')) object.intersectsFrustum = this.#always;
    if (kind <= Kind.Container) return;
    this.#Mesh ??= meshClass(object);
    if (kind > Kind.Mesh) this.#chains.give(object, this.#nodes.parts.get(this.#nodes.numberOf(object)));
    if (object.children.length > 0) this.#shortenMesh(object);
  }

  #free(object, kind) {
    if (kind !== Kind.Rest) {
      object.removeEventListener('childadded', this.#children);
      object.removeEventListener('childremoved', this.#gone);
    }
    if (object.intersectsFrustum?.cullet) delete object.intersectsFrustum;
    this.#kids.get(object)?.drop();
    this.#kids.delete(object);
  }

  // The children of a mesh are in the list by themselves, so a walk is not to find them at the mesh too.
  #shortenMesh(object) {
    if (!this.#kids.has(object)) this.#kids.set(object, shorten(object, () => NONE));
  }

  // Takes what was added. `matrices`: world matrices are made first.
  #flush(matrices) {
    const pending = this.#pending;
    if (pending.length === 0) return;
    for (let k = 0; k < pending.length; k += 2) {
      const [child, parent] = [pending[k], pending[k + 1]];
      // Removed again, or taken with its parent, which was added too.
      if (child.parent !== parent || this.#nodes.numberOf(child) >= 0) continue;
      const i = parent === this.#root ? -1 : this.#nodes.numberOf(parent);
      if (i < 0 && parent !== this.#root) continue;
      if (matrices) child.updateWorldMatrix(false, true, true);
      if (i >= 0 && this.#nodes.kinds[i] > Kind.Container) { this.#shortenMesh(parent); this.#nodes.adopt(i); }
      this.#nodes.add(child, i);
    }
    pending.length = 0;
    if (this.#nodes.isSparse) this.#rebuild();
  }

  #updateMatrixWorld(force) {
    this.#flushTurns();
    this.#renders.listen();
    const root = this.#root;
    if (!this.#enabled) { Object.getPrototypeOf(root).updateMatrixWorld.call(root, force); return; }
    if (root.matrixAutoUpdate) root.updateMatrix();
    if ((root.matrixWorldNeedsUpdate || force) && root.matrixWorldAutoUpdate) {
      if (root.parent === null) root.matrixWorld.copy(root.matrix);
      else root.matrixWorld.multiplyMatrices(root.parent.matrixWorld, root.matrix);
    }
    root.matrixWorldNeedsUpdate = false;
    const { elements } = root.matrixWorld;
    let moved = false;
    for (let i = 0; i < 16; i++) if (this.#rootWorld[i] !== elements[i]) { moved = true; this.#rootWorld[i] = elements[i]; }
    this.#flush(true);
    if (!this.#still || moved || force === true) this.#nodes.look(moved, force === true);
    else this.#nodes.lookAtRest(moved);
  }

  // Stand-ins of a pass are used again once the frame is over: from here on, or when the page's task has ended.
  #turn(layers, frustum) {
    let byFrustum = this.#passes.get(layers);
    if (!byFrustum) this.#passes.set(layers, byFrustum = new WeakMap());
    let pass = byFrustum.get(frustum);
    if (!pass) byFrustum.set(frustum, pass = { turn: -1 });
    if (pass.turn < 0) this.#turns.push(pass);
    if (this.#turns.length === 1 && pass.turn < 0) queueMicrotask(() => this.#flushTurns());
    pass.turn += 1;
    return pass;
  }

  #flushTurns() {
    stop();
    for (const pass of this.#turns) pass.turn = -1;
    this.#turns.length = 0;
  }

  // Before the walk reads how many children there are: a list for another render order may be new.
  #prepare() {
    this.#flush(false);
    this.#nodes.lookAtHolders();
    const base = orderAbove(this.#root);
    if (this.#base !== base) { this.#base = base; this.#nodes.version += 1; }
    if (this.#seenVersion !== this.#nodes.version) this.#list();
  }

  #cull(layers, frustum) {
    const began = performance.now();
    const nodes = this.#nodes;
    const stats = this.#stats;
    stats.passes += 1;
    stats.visible = stats.visibleInstances = stats.coarserInstances = stats.instances = stats.hidden = stats.hiddenInstances = stats.clipped = 0;
    stats.noOcclusion = null;
    this.#walk.clear();
    this.#more = 0;
    if (nodes.length === 0) { this.#walk.cut(); return; }
    nodes.commit();
    const pass = this.#turn(layers, frustum);
    const planes = planesOf(frustum, this.#planes);
    // Before the list is made: the engine's memory may grow, and views over it die.
    const scene = this.#renders.listen();
    const { renderer, current } = this.#renders;
    const isMain = current !== null && !current.isShadow && !current.seen.has(this) && isPassOf(current.camera, layers, planes);
    const receivers = isMain && this.#byReceivers && !this.frozen ? new Receivers(layers, planes, current.camera) : null;
    current?.seen.set(this, current.seen.get(this) ?? receivers);
    const shadow = isMain ? null : this.#shadowOf(frustum, current);
    const caster = shadow && casting(shadow, (current.isShadow ? current.outer : current)?.seen.get(this) ?? null, renderer);
    const own = this.#occlusion && planes.length === 24 ? this.#occlusion.cameraOf(layers, planes) : null;
    const viewer = isMain ? current.camera : own;
    const decision = viewer && this.#decisions.begin(viewer, planes, nodes.length, !current?.outer);
    const kept = decision?.isKept ? decision : null;
    if (decision) decision.occludes = own !== null;
    const camera = kept ? null : own;
    const clip = renderer && !kept && (isMain || camera) ? Clipping.of(this.#root, renderer, camera ?? current.camera, scene.overrideMaterial) : null;
    // Before occlusion: what is drawn at a coarser level hides nothing.
    const view = isMain && !kept && planes.length === 24 ? viewOf(renderer, viewer) : null;
    for (const part of nodes.parts.values()) part.choose(view, planes);
    const isTrial = camera !== null && this.#wanted.preset !== 'exact' && this.#cost.isOpen && isMain && current.outer === null && this.#measure(current, camera);
    const occlusion = camera && !isTrial && this.#occlusion.cull(camera, scene, renderer, clip) ? this.#occlusion : null;
    if (camera) stats.noOcclusion = isTrial ? 'this render goes without, to measure what a draw costs' : this.#occlusion.refusal;
    const isFree = !clip?.isActive && !occlusion && !receivers && !caster;
    const filter = { clip: clip?.isActive ? clip : null, occlusion, receivers, caster, camera: shadow?.camera ?? (isMain || current?.isShadow ? current.camera : own), lists: decision?.records ? decision.lists : null, kept, layers };
    let list;
    if (kept) list = kept.drawn(nodes);
    else if (planes.length === 24) list = nodes.boxes.cull(planes);
    else list = nodes.seenByAny(planes);
    const { objects, kinds, hidden, length } = nodes;
    const carriers = this.#carriers;
    const only = this.#walk.orders.size === 0 ? this.#walk.base : null;
    // Copied, since the parts of an object cull too.
    if (nodes.parts.size > 0 || this.#occlusion) list = list.slice();
    for (let k = 0; k < list.length; k++) {
      const i = list[k];
      if (i >= length || kinds[i] < Kind.Mesh || hidden[i] === 1) continue;
      const object = objects[i];
      let fate = Fate.Drawn;
      if (kinds[i] !== Kind.Mesh) fate = this.#pushParts(i, object, pass, planes, filter);
      else if (!isFree) fate = this.#fateOf(i, object, filter);
      if (decision !== null && kept === null) decision.fates[i] = fate;
      if (kinds[i] === Kind.Mesh) {
        if (fate !== Fate.Drawn) continue;
        push(only ?? carriers[i], object);
      }
      if (this.#kids.size > 0 && object.visible) this.#kids.get(object)?.arm();
    }
    stats.visible = this.#walk.cut() - this.#more;
    if (receivers) this.#endMain(scene, current, receivers);
    if (isMain && this.#byReceivers && this.frozen) [stats.keptMaps, stats.allCast] = [0, 'the culling is frozen'];
    if (kept) [stats.hidden, stats.hiddenInstances, stats.clipped, stats.noOcclusion] = [kept.stats.hidden, kept.stats.hiddenInstances, kept.stats.clipped, kept.stats.noOcclusion];
    stats.milliseconds = performance.now() - began;
    this.#cost.pass(stats);
    if (decision) this.#decisions.end(decision, stats);
  }

  #tellCost() { [this.#stats.drawMicroseconds, this.#stats.drawMicrosecondsFrom] = [this.#cost.microseconds, this.#cost.from]; }

  // Has the time of a render counted. Whether it is to go without occlusion.
  #measure({ began, done }, camera) {
    if (!this.#cost.begin(camera)) return false;
    done.push(() => {
      this.#cost.end(performance.now() - began);
      this.#tellCost();
    });
    return this.#cost.isTrial;
  }

  // What happens to a mesh in the frustum; what casts no shadow that is seen is outside.
  #fateOf(i, object, { clip, occlusion, receivers, caster, layers }) {
    const stats = this.#stats;
    if (clip?.clips(object) && clip.cut(object, this.#nodes.boxes.boxes, 6 * i, this.#nodes.boxes.matrices, 16 * i) === Cut.Away) {
      if (object.visible) stats.clipped += 1;
      return Fate.Clipped;
    }
    if (occlusion?.isHidden(i)) {
      // The engine leaves out what is in other layers, too.
      if (!object.layers.test(layers)) return Fate.Outside;
      if (object.visible) stats.hidden += 1;
      return Fate.Hidden;
    }
    if (receivers && object.visible && receivers.takes(object)) {
      const pieces = occlusion?.piecesOf(i);
      if (pieces) for (const box of pieces) receivers.add(box, 0, IDENTITY, 0);
      else receivers.add(this.#nodes.boxes.boxes, 6 * i, this.#nodes.boxes.matrices, 16 * i);
    }
    if (!caster) return Fate.Drawn;
    if (!object.castShadow) return Fate.Outside;
    worldBox(this.#nodes.boxes.boxes, 6 * i, this.#nodes.boxes.matrices, 16 * i, this.#box, 0);
    return caster.casts(this.#box, 0) ? Fate.Drawn : Fate.Outside;
  }

  #pushParts(i, object, pass, planes, { clip, occlusion, receivers, caster, camera, lists, kept }) {
    if (!object.visible || (caster && !object.castShadow)) return Fate.Outside;
    const stats = this.#stats;
    const part = this.#nodes.parts.get(i);
    stats.instances += part.count;
    const takes = receivers?.takes(object);
    let inside = -1;
    let keep = !clip && !occlusion && !takes && !caster && !lists ? null : (list) => {
      inside = list.length;
      let left = clip?.clips(object) ? part.filter(list, (box, matrix) => clip.cut(object, box, 0, matrix, 0) !== Cut.Away) : list;
      const unclipped = left.length;
      if (occlusion) left = occlusion.keep(i, left);
      stats.hiddenInstances += unclipped - left.length;
      if (caster) left = part.filter(left, (box, matrix) => { worldBox(box, 0, matrix, 0, this.#box, 0); return caster.casts(this.#box, 0); });
      if (takes) part.filter(left, (box, matrix) => { receivers.add(box, 0, matrix, 0); return true; });
      lists?.set(i, { inside: list.slice(), drawn: left.slice(), chosen: part.chosen?.slice() ?? null });
      return left;
    };
    if (kept) {
      keep = (list) => kept.lists.get(i)?.drawn ?? list;
      part.chosen = kept.lists.get(i)?.chosen ?? null;
    }
    const drawn = part.cull(pass, planes, keep, camera);
    if (takes && inside < 0) receivers.reason ??= 'not all instances that receive shadows have bounds';
    if (drawn.length === 0) return inside > 0 ? Fate.Hidden : Fate.Outside;
    stats.visibleInstances += part.visible;
    stats.coarserInstances += part.coarser;
    for (const one of drawn) push(this.#carriers[i], one);
    this.#more += drawn.length - 1;
    return Fate.Drawn;
  }

  // The shadow whose map a pass is for, if it is one of a light that was found in the camera's pass.
  #shadowOf(frustum, current) {
    if (!this.#byReceivers || current === null) return null;
    for (const { shadow } of this.#lights) if (current.isShadow ? shadow.camera === current.camera : shadow._frustum === frustum) return shadow;
    return null;
  }

  #endMain(scene, render, receivers) {
    const { objects, rest, hidden } = this.#nodes;
    const lights = [];
    for (const i of rest) if (objects[i] !== null && hidden[i] === 0) receivers.scan(objects[i], null, lights);
    if (scene !== this.#root) receivers.scan(scene, this.#root, lights);
    receivers.takeScene(scene);
    this.#lights = lights;
    this.#stats.keptMaps = prepare(render, lights, receivers);
    this.#stats.allCast = receivers.reason;
  }

  // Which list each object goes to, by its groups' render order, and what is in it always.
  #list() {
    const nodes = this.#nodes;
    nodes.inherit();
    const walk = this.#walk;
    walk.reset(this.#Mesh);
    const orders = [];
    this.#carriers.length = nodes.length;
    let objects = 0;
    for (let i = 0; i < nodes.length; i++) {
      const object = nodes.objects[i];
      if (object === null) continue;
      const parent = nodes.parents[i];
      const above = parent < 0 ? this.#base : orders[parent];
      orders[i] = object.isGroup ? object.renderOrder : above;
      const carrier = walk.carrier(above === this.#base ? null : above);
      this.#carriers[i] = carrier;
      if (nodes.kinds[i] === Kind.Rest) { if (nodes.hidden[i] === 0) carrier.fixed.push(object); } else if (nodes.kinds[i] > Kind.Container) objects += 1;
    }
    walk.arrange();
    this.#stats.objects = objects;
    this.#seenVersion = nodes.version;
  }
}

const NONE = Object.freeze([]);
const IDENTITY = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1];

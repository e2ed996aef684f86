// What the passes of cameras decided about each object: for `explain`, for the panel, and to keep it while a culling is frozen.

import { Kind } from './bounds.js';

/** What a camera's pass did with an object. */
export const Fate = { Outside: 0, Drawn: 1, Hidden: 2, Clipped: 3 };

/** What the last pass of one camera decided. */
export class Decision {
  /** The camera, and copies of its matrices as they were. */
  camera;
  world = new Float64Array(16);
  projection = new Float64Array(16);
  /** Planes of the pass, twenty-four numbers for each frustum. */
  planes = null;
  mask = 0;
  /** A `Fate` for each number below `length`. */
  fates = new Uint8Array(0);
  length = 0;
  /** By number, the instances in the frustum (`inside`) and those drawn (`drawn`); `null` where they were not asked for, older where not `records`. */
  lists = null;
  records = false;
  /** Whether hidden objects were looked for, or would have been. */
  occludes = false;
  /** Counts of the pass, where somebody asked for them. */
  stats = null;
  /** Whether the pass was made while the culling is frozen, so that it holds from now on. */
  isKept = false;

  constructor(camera) { this.camera = camera; }

  /** Numbers that a frozen pass draws; objects that came since are drawn too. */
  drawn({ kinds, length }) {
    const list = [];
    for (let i = 0; i < length; i++) if (i >= this.length || this.fates[i] === Fate.Drawn || kinds[i] > Kind.Mesh) list.push(i);
    return list;
  }
}

/** Decisions of all cameras. */
export class Decisions {
  #byCamera = new WeakMap();
  #isFrozen = false;
  /** The decision of the last pass of a camera, passes inside of other renders aside. */
  last = null;
  /** A panel: `isDue` asks for lists and counts of the next pass, `passed` gets each pass. */
  watcher = null;

  get isFrozen() { return this.#isFrozen; }

  set isFrozen(on) {
    this.#isFrozen = on;
    this.#byCamera = new WeakMap();
  }

  /** Forgets everything: numbers are others now. */
  clear() {
    this.#byCamera = new WeakMap();
    this.last = null;
  }

  /** The decision of a camera's pass that begins; if `isKept`, it is made already. */
  begin(camera, planes, length, isOutermost) {
    let decision = this.#byCamera.get(camera);
    if (!decision) this.#byCamera.set(camera, decision = new Decision(camera));
    if (isOutermost) this.last = decision;
    if (decision.isKept) return decision;
    decision.world.set(camera.matrixWorld.elements);
    decision.projection.set(camera.projectionMatrix.elements);
    if (decision.planes?.length === planes.length) decision.planes.set(planes);
    else decision.planes = planes.slice();
    decision.mask = camera.layers.mask;
    if (decision.fates.length < length) decision.fates = new Uint8Array(2 * length);
    else decision.fates.fill(Fate.Outside, 0, length);
    decision.length = length;
    decision.records = this.#isFrozen || this.watcher?.isDue === true;
    if (decision.records) decision.lists = new Map();
    else if (!this.watcher) decision.lists = null;
    return decision;
  }

  /** Ends a camera's pass with these counts. */
  end(decision, stats) {
    if (this.#isFrozen && !decision.isKept) [decision.isKept, decision.stats] = [true, { ...stats }];
    if (this.watcher && decision === this.last) this.watcher.passed(decision, stats);
  }
}

// What three.js walks in place of a root's children: what it culls by itself, then a mark that learns which frustum a pass has,
// and what that leaves.
//
// Both renderers do the same at an object: `layers.test`, for a mesh `intersectsFrustum`, then `children`. So a root whose layers
// were asked answers the next reading of `children` with the short list; whoever else reads it gets all of them.

// The frustum whose visible objects are being walked. They are asked for their own test too, which asks the frustum in its turn,
// so the frustum answers: nothing is done to a mesh, and every other frustum and every other object gets three.js's test.
let walking = null;
const answers = new WeakMap();
const heard = new WeakSet();

function hear(frustum) {
  if (heard.has(frustum)) return;
  heard.add(frustum);
  const base = Object.getPrototypeOf(frustum);
  let answer = answers.get(base);
  if (!answer) {
    const { intersectsObject } = base;
    answers.set(base, answer = function answer(object) { return walking === this || intersectsObject.call(this, object); });
  }
  frustum.intersectsObject = answer;
}

const nothing = { boundingSphere: null, groups: [], morphAttributes: {} };
const unseen = { visible: false };

// All that a renderer reads of a mesh before it has asked for the frustum.
class Stand {
  visible = true;
  isMesh = true;
  castShadow = true;
  receiveShadow = true;
  frustumCulled = true;
  children = [];
  material = unseen;
  geometry = nothing;
  layers = { mask: -1, test: ({ mask }) => mask !== 0 };
}

// Never drawn and in no tree. Of the class of the meshes it is walked with, since a walk over fewer shapes of objects is faster.
function askedOnce(Base, ask) {
  const mesh = Base === null ? new Stand() : new Base(nothing, unseen);
  mesh.layers.mask = -1;
  mesh.castShadow = mesh.receiveShadow = true;
  mesh.intersectsFrustum = (frustum) => { ask(frustum); return false; };
  return mesh;
}

/** A stand-in for a group in the walk, with the `renderOrder` that its children's groups have. */
const carrierOf = (order) => ({
  visible: true, isGroup: true, renderOrder: order, children: [], layers: { mask: -1, test: () => true }, count: 0, fixed: null,
});

export class Walk {
  /** What the root's `children` answer with. */
  children = [];
  /** Of objects under no group with an order of its own. */
  base = { children: [], count: 0, fixed: [] };
  orders = new Map();
  #Base = null;
  #cull;

  /** `cull(frustum)`: called in each pass, after `clear`; what it leaves visible is put into the lists, with `push`. */
  constructor(cull) { this.#cull = cull; }

  /** Forgets all orders, and what is always walked: lights, lines, and what else three.js culls by itself. `Base`: the class `Mesh`, or `null`. */
  reset(Base) {
    this.#Base = Base;
    this.orders.clear();
    this.base.fixed.length = 0;
  }

  /** The list of one order; `null` is that of the walk so far. */
  carrier(order) {
    if (order === null) return this.base;
    let carrier = this.orders.get(order);
    if (!carrier) {
      this.orders.set(order, carrier = carrierOf(order));
      carrier.fixed = [];
    }
    return carrier;
  }

  /** After all carriers were asked for and their `fixed` filled. */
  arrange() {
    const mark = askedOnce(this.#Base, (frustum) => { this.#cull(frustum); hear(frustum); walking = frustum; });
    const end = askedOnce(this.#Base, stop);
    // Read after the mark was asked.
    mark.children = this.base.children;
    const [still, seen] = [[], []];
    for (const carrier of this.orders.values()) {
      if (carrier.fixed.length > 0) still.push(Object.assign(carrierOf(carrier.renderOrder), { children: carrier.fixed }));
      seen.push(carrier);
    }
    this.children = [...this.base.fixed, ...still, mark, ...seen, end];
  }

  /** Empties the lists of a pass; `cut` ends them. In between they keep their memory. */
  clear() {
    this.base.count = 0;
    for (const carrier of this.orders.values()) carrier.count = 0;
  }

  /** How many objects the lists have now. */
  cut() {
    let count = this.base.children.length = this.base.count;
    for (const carrier of this.orders.values()) count += carrier.children.length = carrier.count;
    return count;
  }
}

/** Puts an object on a carrier's list. */
export function push(carrier, object) { carrier.children[carrier.count++] = object; }

/** No frustum answers for its objects any more: at the end of a walk, or where one broke off. */
export function stop() { walking = null; }

/**
 * Makes `object.children` answer with `short()` once after `arm()`, and with the real list ever else.
 * `drop` undoes it.
 */
export function shorten(object, short) {
  let { children } = object;
  let armed = false;
  Object.defineProperty(object, 'children', {
    configurable: true,
    enumerable: true,
    get() { if (!armed) return children; armed = false; return short(); },
    set(list) { children = list; },
  });
  return {
    arm() { armed = true; },
    disarm() { armed = false; },
    all: () => children,
    drop() { Object.defineProperty(object, 'children', { value: children, writable: true, configurable: true, enumerable: true }); },
  };
}

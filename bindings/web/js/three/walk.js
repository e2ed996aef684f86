// What three.js walks in place of a root's children: a mark that learns which frustum a pass has, and what that leaves.
//
// Both renderers do the same at an object: `layers.test`, for a mesh `intersectsFrustum`, then `children`. So a root whose layers
// were asked answers the next reading of `children` with the short list; whoever else reads it gets all of them.

const everyLayer = (ask) => ({ mask: -1, test: (layers) => { ask?.(layers); return true; }, isEnabled: () => true });

/** A stand-in for a group in the walk, with the `renderOrder` that its children's groups have (none: that of the walk so far). */
function carrierOf(order) {
  return { visible: true, layers: everyLayer(), isGroup: order !== null, renderOrder: order ?? 0, children: [], fixed: [] };
}

export class Walk {
  /** `cull(layers, frustum)`: called at the start of each pass, after `clear`; it calls `push` for what is visible. */
  constructor(cull) {
    this.orders = new Map();
    let layers = null;
    // Never drawn and in no tree: all that a renderer reads of an object before it has asked for the frustum.
    const mark = {
      visible: true, isMesh: true, castShadow: true, receiveShadow: true, frustumCulled: true, children: [],
      material: { visible: false }, geometry: { boundingSphere: null, groups: [] },
      layers: everyLayer((asked) => { layers = asked; }),
      intersectsFrustum: (frustum) => { cull(layers, frustum); return false; },
    };
    this.children = [mark];
  }

  carrier(order) {
    let carrier = this.orders.get(order);
    if (!carrier) {
      this.orders.set(order, carrier = carrierOf(order));
      this.children.push(carrier);
    }
    return carrier;
  }

  /** Forgets what is always walked: lights, lines, and what else three.js culls by itself. */
  reset() { for (const carrier of this.orders.values()) carrier.fixed.length = carrier.children.length = 0; }

  /** Leaves of each list what is always walked. */
  clear() { for (const carrier of this.orders.values()) carrier.children.length = carrier.fixed.length; }
}

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

// What a culling may be given, and how it is named in messages.

/** The culling of each root that has one. */
export const taken = new WeakMap();

export function camerasOf(given) {
  if (given === undefined || given === null || given === false) return null;
  const cameras = Array.isArray(given) ? given : [given];
  for (const camera of cameras) if (!camera?.isCamera) throw new TypeError(`cullet: occlusion takes a camera or an array of them, not ${nameOf(camera)}`);
  return cameras;
}

export const nameOf = (object) => (object?.isObject3D ? `${object.type}${object.name ? ` "${object.name}"` : ''} (id ${object.id})` : String(object));

export function isBelow(object, root) {
  for (let o = object?.parent; o; o = o.parent) if (o === root) return true;
  return false;
}

// The order that a walk has when it comes to the root's children, or `null` where that depends on where it starts.
export function orderAbove(root) {
  if (root.isGroup) return root.renderOrder;
  for (let o = root.parent; o; o = o.parent) if (o.isGroup && o.renderOrder !== 0) return null;
  return 0;
}

export function check(root) {
  if (!root?.isObject3D) throw new TypeError(`cullet: new Culling() takes a THREE.Scene or a group, not ${nameOf(root)}`);
  if (root.isMesh || root.isLight || root.isCamera || root.isLine || root.isPoints || root.isSprite || root.isLOD || root.isBundleGroup) {
    throw new TypeError(`cullet: new Culling() takes a THREE.Scene or a group, not ${nameOf(root)}; add it to a group and give that`);
  }
  for (let o = root; o; o = o.parent) {
    if (taken.has(o)) throw new Error(`cullet: ${nameOf(o)} is culled already; dispose() that culling first, or use it`);
    if (o !== root && o.isBundleGroup) throw new Error(`cullet: ${nameOf(root)} lies in a BundleGroup, which records its draws once and culls nothing`);
  }
  root.traverse((o) => { if (taken.has(o)) throw new Error(`cullet: ${nameOf(o)} below ${nameOf(root)} is culled already; dispose() that culling first`); });
}

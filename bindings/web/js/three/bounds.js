// What may be culled, and by which box.

/** Whether an object is a plain mesh, an InstancedMesh or a BatchedMesh that three.js draws where its bounds are. */
export const Kind = { Rest: 0, Container: 1, Mesh: 2, Instanced: 3, Batched: 4 };

const materialsOf = ({ material }) => (Array.isArray(material) ? material : [material]);

// Vertices that a shader moves leave the box of the geometry.
const movedByMaterial = (m) => Boolean(m) && (m.isShaderMaterial === true || (m.displacementMap ?? null) !== null
  || m.onBeforeCompile !== owner(m, 'onBeforeCompile')?.onBeforeCompile || Boolean(m.positionNode ?? m.vertexNode ?? m.castShadowPositionNode));

// Nodes may read the number of an instance, which is another once instances are compacted.
const hasNodes = (m) => m.isNodeMaterial === true && Object.keys(m).some((key) => key.endsWith('Node') && m[key]);

// The last of an object's prototypes that has `name` itself: three.js's own, without importing it (a page may have
// `three` or `three/webgpu`, and a second copy would double its size).
export function owner(object, name) {
  const first = Object.getPrototypeOf(object);
  let named = owners.get(first);
  if (!named) owners.set(first, named = {});
  if (name in named) return named[name];
  named[name] = undefined;
  for (let p = first; p; p = Object.getPrototypeOf(p)) if (Object.hasOwn(p, name)) named[name] = p;
  return named[name];
}

const owners = new WeakMap();

/** The class `Mesh` of the three.js that a mesh is from. */
export const meshClass = (object) => owner(object, 'updateMorphTargets').constructor;

/** Tells what is done with an object: a class of someone else's, with its own test or its own matrices, is left to three.js. */
export function kindOf(object, movesVertices) {
  if (object.updateMatrixWorld !== owner(object, 'updateMatrixWorld').updateMatrixWorld) return Kind.Rest;
  if (object.isMesh) {
    const base = owner(object, 'updateMorphTargets');
    if (!base || (object.intersectsFrustum !== base.intersectsFrustum)) return Kind.Rest;
    const materials = materialsOf(object);
    if (!object.geometry?.attributes?.position && !object.isBatchedMesh) return Kind.Rest;
    const moved = movesVertices ? movesVertices(object) : materials.some(movedByMaterial) || object.customDepthMaterial || object.customDistanceMaterial;
    if (moved || materials.some((m) => !m)) return Kind.Rest;
    if (object.isBatchedMesh) return canBatch(object) ? Kind.Batched : Kind.Rest;
    if (object.isInstancedMesh) return canCompact(object, materials) ? Kind.Instanced : Kind.Rest;
    return object.geometry.isInstancedBufferGeometry ? Kind.Rest : Kind.Mesh;
  }
  const drawsOrDecides = object.isLine || object.isPoints || object.isSprite || object.isLight || object.isLOD || object.isCamera
    || object.isBundleGroup || object.isClippingGroup;
  return drawsOrDecides ? Kind.Rest : Kind.Container;
}

function canCompact(mesh, materials) {
  return mesh.morphTexture === null && !mesh.instanceMatrix.isStorageInstancedBufferAttribute && !materials.some(hasNodes)
    && !Object.values(mesh.geometry.attributes).some((a) => a.isInstancedBufferAttribute || a.data?.isInstancedInterleavedBuffer);
}

// The fields of a BatchedMesh are three.js's own business: where they are not as known, it culls by itself.
function canBatch(mesh) {
  return typeof mesh._updateDrawParameters === 'function' && Array.isArray(mesh._instanceInfo) && Boolean(mesh._matricesTexture?.image?.data);
}

const known = new WeakMap();

/**
 * Writes the box of a geometry at `to[at]`, six numbers. It is that of its positions (made again when their version is another
 * than at the last call) and of its bounding sphere, where someone has set a larger one: three.js culls by the sphere.
 * Without finite positions the box is not finite either: never culled.
 */
export function boxOf(geometry, to, at) {
  const { position } = geometry.attributes;
  const version = position.version ?? position.data?.version;
  let seen = known.get(geometry);
  if (!seen || seen.version !== version || seen.position !== position || geometry.boundingBox === null) {
    if (geometry.boundingBox === null || seen) geometry.computeBoundingBox();
    seen = { version, position };
    known.set(geometry, seen);
  }
  writeBox(geometry.boundingBox, geometry.boundingSphere, to, at);
}

/** Writes a box, widened by a sphere that someone has made larger than the box's own. */
export function writeBox({ min, max }, sphere, to, at) {
  to[at] = min.x; to[at + 1] = min.y; to[at + 2] = min.z;
  to[at + 3] = max.x; to[at + 4] = max.y; to[at + 5] = max.z;
  // An empty box is of a geometry without vertices: three.js keeps it, as it keeps what is not finite.
  if (!(min.x <= max.x)) { never(to, at); return; }
  if (!sphere) return;
  const { center: c, radius: r } = sphere;
  const half = Math.hypot(max.x - min.x, max.y - min.y, max.z - min.z) / 2;
  const off = Math.hypot((min.x + max.x) / 2 - c.x, (min.y + max.y) / 2 - c.y, (min.z + max.z) / 2 - c.z);
  if (r <= half * (1 + 1e-6) && off <= half * 1e-6) return;
  to[at] = Math.min(min.x, c.x - r); to[at + 1] = Math.min(min.y, c.y - r); to[at + 2] = Math.min(min.z, c.z - r);
  to[at + 3] = Math.max(max.x, c.x + r); to[at + 4] = Math.max(max.y, c.y + r); to[at + 5] = Math.max(max.z, c.z + r);
}

/** Bounds of what is never culled. */
export function never(to, at) { for (let i = at; i < at + 6; i++) to[i] = NaN; }

/** Whether vertices go where influences take them: bounds of morph targets hold for few of them. */
export const isMorphed = ({ geometry }) => Boolean(geometry?.morphAttributes?.position?.length);

// Levels that `cullet bake` wrote into a glTF file, as geometries of three.js with their measured errors.
//
// The extension CULLET_baked is read through the parser of three.js's GLTFLoader: the chain of each mesh is a list of triangles that
// name the mesh's own vertices, in clusters. In a chain a group is a whole level, and what was made from it is the next one.

const NAME = 'CULLET_baked';
const NONE = 2 ** 32 - 1;
const TRIANGLES = new Set([undefined, 4, 5, 6]);

// What the vertices of a primitive are known by: primitives that name the same accessors share them.
const keyOf = ({ attributes: { POSITION, NORMAL, TEXCOORD_0, COLOR_0 } }) => [POSITION, NORMAL, TEXCOORD_0, COLOR_0].join();

/**
 * Where the vertices of each primitive of triangles begin among those of its mesh; `null` where they are not one after another, since
 * several meshes share them.
 */
function firstVertices(json, number) {
  const others = new Set(json.meshes.flatMap(({ primitives }, k) => (k === number ? [] : primitives.map(keyOf))));
  const firsts = new Map();
  let end = 0;
  const list = [];
  for (const [primitive, item] of json.meshes[number].primitives.entries()) {
    const vertices = json.accessors[item.attributes.POSITION]?.count ?? 0;
    const corners = item.indices === undefined ? vertices : json.accessors[item.indices].count;
    if (!TRIANGLES.has(item.mode) || corners < 3) continue;
    const key = keyOf(item);
    if (others.has(key)) return null;
    if (!firsts.has(key)) { firsts.set(key, end); end += vertices; }
    list.push({ primitive, first: firsts.get(key), count: vertices });
  }
  return list;
}

/** Corners of each level of each primitive, as vertices of the mesh, and the error of each level. */
function levelsOf(indices, clusters, groups, parts) {
  const ends = [];
  for (const count of parts) ends.push((ends.at(-1) ?? 0) + count);
  const corners = parts.map(() => []);
  for (let at = 0; at < clusters.length; at += 4) {
    const [first, count, level] = clusters.subarray(at, at + 3);
    if (level === NONE) continue;
    const list = corners[ends.findIndex((end) => first < end)][level] ??= [];
    for (let k = 3 * first; k < 3 * (first + count); k++) list.push(indices[k]);
  }
  return { corners, errors: Array.from({ length: groups.length / 5 }, (_, k) => groups[5 * k + 4]) };
}

/** A geometry of some vertices of another: each vertex once, in the order of its use. */
function part(geometry, corners) {
  const numbers = new Map();
  for (const v of corners) if (!numbers.has(v)) numbers.set(v, numbers.size);
  const made = new geometry.constructor();
  let Plain = null;
  for (const [name, attribute] of Object.entries(geometry.attributes)) {
    // A clone of an interleaved attribute stands alone.
    const from = attribute.isInterleavedBufferAttribute ? attribute.clone() : attribute;
    Plain = from.constructor;
    const { itemSize } = from;
    const array = new from.array.constructor(itemSize * numbers.size);
    for (const [v, k] of numbers) for (let c = 0; c < itemSize; c++) array[itemSize * k + c] = from.array[itemSize * v + c];
    made.setAttribute(name, new Plain(array, itemSize, from.normalized));
  }
  // Of plain attributes the class takes any array.
  const Attribute = geometry.index?.constructor ?? Plain;
  made.setIndex(new Attribute(Uint32Array.from(corners, (v) => numbers.get(v)), 1));
  made.name = geometry.name;
  return made;
}

// Vertices of the mesh as those of a primitive: one of another primitive is that of the same place, if there is one.
function toOwn(corners, { first, count }, positions, own) {
  let byPlace = null;
  const placeOf = ([x, y, z]) => `${x} ${y} ${z}`;
  return corners.map((v) => {
    if (v >= first && v < first + count) return v - first;
    if (!byPlace) { byPlace = new Map(); for (let k = 0; k < count; k++) byPlace.set(placeOf(at(own, k)), k); }
    const p = positions(v);
    return p && byPlace.get(placeOf(p));
  });
}

const at = (attribute, k) => [attribute.getX(k), attribute.getY(k), attribute.getZ(k)];

/** The chains of a file's geometries: see index.d.ts. */
export async function bakedLevels({ parser }) {
  const { json, associations } = parser;
  const chains = new Map();
  if (json.extensions?.[NAME]?.version !== 1) return chains;
  const geometries = new Map();
  for (const [object, { meshes, primitives = 0 }] of associations) {
    if (!object.isMesh || meshes === undefined) continue;
    if (!geometries.has(meshes)) geometries.set(meshes, []);
    geometries.get(meshes)[primitives] = object.geometry;
  }
  for (const [number, own] of geometries) {
    const chain = json.meshes[number].extensions?.[NAME]?.levels?.find(({ kind }) => kind === 'chain');
    const blocks = chain && firstVertices(json, number);
    if (!blocks || blocks.length !== chain.parts.length || blocks.some(({ primitive }) => !own[primitive])) continue;
    const [indices, clusters, groups] = await Promise.all([chain.indices, chain.clusters, chain.groups].map((view) => parser.getDependency('bufferView', view)));
    const { corners, errors } = levelsOf(new Uint32Array(indices), new Uint32Array(clusters), new Float32Array(groups), chain.parts);
    const positions = (v) => {
      const block = blocks.find(({ first, count }) => v >= first && v < first + count);
      return block && at(own[block.primitive].attributes.position, v - block.first);
    };
    for (const [k, block] of blocks.entries()) {
      const geometry = own[block.primitive];
      const list = [{ geometry, error: 0 }];
      for (const [level, error] of errors.entries()) {
        const vertices = corners[k][level] ? toOwn(corners[k][level], block, positions, geometry.attributes.position) : [];
        // What does not name vertices of the file is no level of it, nor is what is coarser.
        if (vertices.length === 0 || vertices.includes(undefined) || !(error >= list.at(-1).error && error < Infinity)) break;
        list.push({ geometry: part(geometry, vertices), error });
      }
      chains.set(geometry, list);
    }
  }
  return chains;
}

// Levels of a file that `cullet bake` wrote: `ring.glb` is a ring of two halves with materials of their own, 560 triangles with normals and
// texture coordinates, baked by `cullet bake ring.glb -o ring.glb --no-hierarchy`.

import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { join } from 'node:path';
import { test } from 'node:test';
import { fileURLToPath, pathToFileURL } from 'node:url';
import { modules, packageFolder } from './harness.mjs';
import { random } from './scenes.js';

const { bakedLevels } = await import(pathToFileURL(join(packageFolder, 'js/three/index.js')));
const T = await import(pathToFileURL(join(modules, 'three/build/three.module.js')));
const { GLTFLoader } = await import(pathToFileURL(join(modules, 'three/examples/jsm/loaders/GLTFLoader.js')));
const file = readFileSync(fileURLToPath(new URL('ring.glb', import.meta.url)));

/** The file, its JSON edited by `edit`. */
function parse(edit = () => {}) {
  const length = file.readUInt32LE(12);
  const json = JSON.parse(file.subarray(20, 20 + length));
  edit(json);
  const text = Buffer.from(JSON.stringify(json));
  const padded = Buffer.concat([text, Buffer.alloc((4 - text.length % 4) % 4, 32)]);
  const head = Buffer.from(file.subarray(0, 20));
  head.writeUInt32LE(file.length - length + padded.length, 8);
  head.writeUInt32LE(padded.length, 12);
  const bytes = new Uint8Array(Buffer.concat([head, padded, file.subarray(20 + length)]));
  return new GLTFLoader().parseAsync(bytes.buffer, '').then((gltf) => ({ gltf, json }));
}

function* trianglesOf({ attributes: { position }, index }) {
  for (let k = 0; k < index.count; k += 3) yield new T.Triangle(...[0, 1, 2].map((c) => new T.Vector3().fromBufferAttribute(position, index.getX(k + c))));
}

function farthest(from, to, next) {
  const near = new T.Vector3();
  let most = 0;
  for (const { a, b, c } of from) {
    for (let i = 0; i < 4; i++) {
      const [u, v] = [next(), next()].sort((x, y) => x - y);
      const p = new T.Vector3().addScaledVector(a, u).addScaledVector(b, v - u).addScaledVector(c, 1 - v);
      let least = Infinity;
      for (const triangle of to) least = Math.min(least, triangle.closestPointToPoint(p, near).distanceTo(p));
      most = Math.max(most, least);
    }
  }
  return most;
}

test('each primitive has the chain that was baked, and the errors hold', async () => {
  const { gltf, json } = await parse();
  const chains = await bakedLevels(gltf);
  const meshes = [];
  gltf.scene.traverse((o) => { if (o.isMesh) meshes.push(o); });
  const { parts, errors } = json.meshes[0].extensions.CULLET_baked.levels[0];
  assert.equal(meshes.length, 2);
  assert.equal(chains.size, 2);
  const lists = meshes.map(({ geometry }) => chains.get(geometry));
  for (const [k, list] of lists.entries()) {
    const count = ({ geometry }) => geometry.index.count / 3;
    assert.equal(list[0].geometry, meshes[k].geometry);
    assert.equal(list.reduce((all, level) => all + count(level), 0), parts[k], 'no triangle is left out');
    assert.deepEqual([list[0].error, list[1].error, list.at(-1).error], [0, errors[0], errors[1]].map(Math.fround));
    assert.ok(list.length > 4 && list.at(-1).geometry.index.count <= 12, `${list.length} levels`);
    // Places, normals and texture coordinates are those of vertices of the finest.
    const row = ({ attributes }, v) => ['position', 'normal', 'uv'].map((name) => [...attributes[name].array.slice(v * attributes[name].itemSize, (v + 1) * attributes[name].itemSize)].join());
    const rows = new Set(Array.from({ length: list[0].geometry.attributes.position.count }, (_, v) => row(list[0].geometry, v).join(' ')));
    for (const { geometry } of list.slice(1)) for (let v = 0; v < geometry.attributes.position.count; v++) assert.ok(rows.has(row(geometry, v).join(' ')));
    assert.ok(list[1].geometry.attributes.position.count < list[0].geometry.attributes.position.count, 'a level has its own vertices alone');
  }
  const next = random(3);
  const whole = (level) => lists.flatMap((list) => [...trianglesOf((list[level] ?? list.at(-1)).geometry)]);
  const finest = whole(0);
  for (let level = 1; level < lists[0].length; level++) {
    const coarse = whole(level);
    const off = Math.max(farthest(finest, coarse, next), farthest(coarse, finest, next));
    const { error } = lists[0][level];
    assert.ok(off <= 1.08 * error, `level ${level} is off by ${off}, and ${error} is told`);
    assert.ok(off >= 0.3 * error, `level ${level} is off by ${off} alone, of ${error}`);
  }
});

test('what cannot be read is no level', async () => {
  const sizeWith = async (edit) => (await bakedLevels((await parse(edit)).gltf)).size;
  assert.equal(await sizeWith((json) => { delete json.extensions; }), 0, 'no extension');
  assert.equal(await sizeWith((json) => { json.extensions.CULLET_baked.version = 2; }), 0, 'another version');
  assert.equal(await sizeWith((json) => { json.meshes[0].extensions.CULLET_baked.levels[0].kind = 'hierarchy'; }), 0, 'no chain');
  assert.equal(await sizeWith((json) => { json.meshes[0].extensions.CULLET_baked.levels[0].parts.pop(); }), 0, 'other parts');
  assert.equal(await sizeWith((json) => { json.meshes.push({ primitives: [json.meshes[0].primitives[1]] }); json.nodes.push({ mesh: 1 }); json.scenes[0].nodes.push(1); }), 0, 'meshes that share vertices');
  // A table that names vertices that are not there.
  const { gltf } = await parse((json) => { json.meshes[0].primitives.reverse(); json.accessors[json.meshes[0].primitives[0].attributes.POSITION].count -= 100; });
  for (const list of (await bakedLevels(gltf)).values()) assert.ok(list.length < 4, `${list.length} levels`);
});

test('levels go into a batch', async () => {
  const { gltf } = await parse();
  for (const list of (await bakedLevels(gltf)).values()) {
    const sum = (of) => list.reduce((all, { geometry }) => all + of(geometry), 0);
    const batch = new T.BatchedMesh(1, sum((g) => g.attributes.position.count), sum((g) => g.index.count));
    const ids = list.map(({ geometry }) => batch.addGeometry(geometry));
    assert.equal(new Set(ids).size, list.length);
    assert.ok(batch.geometry.attributes.normal && batch.geometry.attributes.uv);
  }
});

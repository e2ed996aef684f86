// The command of the package, as `npx cullet` starts it.
import assert from 'node:assert/strict';
import { spawnSync } from 'node:child_process';
import { existsSync, mkdirSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { test } from 'node:test';
import { entry, folder } from './package.mjs';

const home = mkdtempSync(join(tmpdir(), 'cullet-'));
process.on('exit', () => rmSync(home, { recursive: true, force: true }));
const manifest = JSON.parse(readFileSync(join(folder, 'package.json'), 'utf8'));
const program = join(folder, manifest.bin.cullet);
const run = (...words) => {
  const { stdout, stderr, status } = spawnSync(process.execPath, [program, ...words], { cwd: home, encoding: 'utf8' });
  return { stdout: stdout.replaceAll('\u202f', ' '), stderr, status };
};
const file = (name, content) => {
  writeFileSync(join(home, name), content);
  return name;
};
/** The record of a file, which must be read without an error. */
const record = (...words) => {
  const { stdout, stderr, status } = run('info', ...words, '--json');
  assert.equal(status, 0, stderr);
  return JSON.parse(stdout);
};

// Two quads of which one is a triangle again, and a triangle without area: 6 triangles of 4 polygons.
const OBJ = 'o plate\nv -1 0 2\nv 3 0 2\nv 3 5 2\nv -1 5 2\nv 3 0 9\nv -1 0 9\nf 1 2 3 4\nf 1 2 5 6\nf 1 2 3\nf 1 1 2\n';

/** A glTF of boxes: one mesh of 12 triangles at three places, of which one is mirrored. */
const gltf = (uri) => {
  const corners = [0, 1, 2, 3, 4, 5, 6, 7].map((i) => [i & 1, (i >> 1) & 1, i >> 2]);
  const indices = [0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4, 2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5];
  const bin = Buffer.concat([Buffer.from(new Float32Array(corners.flat()).buffer), Buffer.from(new Uint16Array(indices).buffer)]);
  const json = {
    asset: { version: '2.0' }, scene: 0, scenes: [{ nodes: [0, 1, 2] }],
    nodes: [{ mesh: 0 }, { mesh: 0, translation: [10, 0, 0] }, { mesh: 0, scale: [-1, 1, 1], translation: [0, 0, 4] }],
    meshes: [{ name: 'crate', primitives: [{ attributes: { POSITION: 0 }, indices: 1 }] }],
    accessors: [{ bufferView: 0, componentType: 5126, count: 8, type: 'VEC3', min: [0, 0, 0], max: [1, 1, 1] }, { bufferView: 1, componentType: 5123, count: 36, type: 'SCALAR' }],
    bufferViews: [{ buffer: 0, byteLength: 96 }, { buffer: 0, byteOffset: 96, byteLength: 72 }],
    buffers: [{ byteLength: bin.length, ...(uri && { uri }) }],
  };
  return { json: Buffer.from(JSON.stringify(json)), bin };
};
const glb = () => {
  const { json, bin } = gltf();
  const text = Buffer.concat([json, Buffer.alloc((4 - json.length % 4) % 4, ' ')]);
  const chunk = (type, data) => Buffer.concat([new Uint8Array(new Uint32Array([data.length]).buffer), Buffer.from(type), data]);
  const body = Buffer.concat([chunk('JSON', text), chunk('BIN\0', bin)]);
  return Buffer.concat([Buffer.from('glTF'), new Uint8Array(new Uint32Array([2, body.length + 12]).buffer), body]);
};

test('an OBJ is counted, measured and judged', () => {
  const { scene, meshes } = record(file('plate.obj', OBJ));
  assert.deepEqual([scene.triangles, scene.unique_triangles, scene.polygons, scene.instances, scene.meshes], [6, 6, 4, 1, 1]);
  assert.deepEqual(scene.extent, [[-1, 0, 2], [3, 5, 9]]);
  assert.deepEqual([meshes[0].name, meshes[0].degenerate, meshes[0].duplicate, meshes[0].solid], ['plate', 1, 1, false]);
  const { stdout } = run('info', 'plate.obj');
  for (const words of ['triangles   6 from 4 polygons (6 stored)', 'size        4.000 × 5.000 × 7.000', '1 stored triangle has no area', '1 stored triangle is a duplicate', 'Meshes that are not solids (1):', 'plate  6 triangles, two-sided: it is open']) {
    assert.ok(stdout.includes(words), `${words}:\n${stdout}`);
  }
});

test('a GLB is counted by instances and by what is stored', () => {
  const { scene, mirrored_instances, groups, meshes } = record(file('crates.glb', glb()));
  assert.deepEqual([scene.triangles, scene.unique_triangles, scene.instances, scene.meshes, scene.solids], [36, 12, 3, 1, 1]);
  assert.deepEqual(scene.extent, [[-1, 0, 0], [11, 1, 5]]);
  assert.deepEqual([mirrored_instances, groups.nodes, meshes[0].name, meshes[0].instances, meshes[0].defect], [1, 3, 'crate', 3, null]);
  const { stdout } = run('info', 'crates.glb');
  assert.ok(stdout.includes('meshes      1, a solid') && stdout.includes('1 instance is mirrored') && !stdout.includes('not solids'), stdout);
});

test('files that a model names are read beside it', () => {
  mkdirSync(join(home, 'parts'));
  const { json, bin } = gltf('parts/box.bin');
  file('crates.gltf', json);
  const missing = run('info', 'crates.gltf');
  assert.equal(missing.status, 3);
  assert.match(missing.stderr, /^error: crates\.gltf: .*parts\/box\.bin/);
  file('parts/box.bin', bin);
  assert.deepEqual(record('crates.gltf').scene.extent, [[-1, 0, 0], [11, 1, 5]]);
  file('plate.mtl', 'newmtl glass\nd 0.5\n');
  file('glass.obj', `mtllib plate.mtl\nusemtl glass\n${OBJ}`);
  const { meshes } = record('glass.obj');
  assert.match(meshes[0].defect, /not opaque/);
  // From another folder, by a longer path.
  const far = spawnSync(process.execPath, [program, 'info', join(home, 'crates.gltf')], { cwd: tmpdir(), encoding: 'utf8' });
  assert.equal(far.status, 0, far.stderr);
});

test('all meshes and warnings are listed on request, and names cannot command a terminal', () => {
  const one = (i) => `o m${i}${i === 0 ? '\u001b[31m' : ''}\nv 0 0 ${i}\nv 1 0 ${i}\nv 0 1 ${i}\nf -3 -2 -1\n`;
  file('many.obj', Array.from({ length: 25 }, (_, i) => one(i)).join(''));
  const some = run('info', 'many.obj').stdout;
  assert.ok(some.includes('Meshes that are not solids (25):') && some.includes('and 5 more; --all lists them') && !some.includes('m24'), some);
  const all = run('info', 'many.obj', '--all').stdout;
  assert.ok(all.includes('m24') && !all.includes('more;'), all);
  assert.ok(!all.includes('\u001b') && all.includes('m0\ufffd[31m'), all);
});

test('what cannot be read ends with code 3 and says what to look at', () => {
  file('noise.bin', new Uint8Array(64).fill(7));
  file('wrong.obj', 'v 0 0 0\nv 1 0 0\nf 1 2 9\n');
  file('cut.glb', glb().subarray(0, 60));
  for (const [name, words] of [['no.glb', /no file no\.glb/], ['.', /folder/], ['noise.bin', /noise\.bin: .*known are \.glb/], ['wrong.obj', /wrong\.obj: .*9/], ['cut.glb', /cut\.glb: /]]) {
    const { stdout, stderr, status } = run('info', name);
    assert.deepEqual([status, stdout], [3, ''], name);
    assert.match(stderr, words);
    assert.doesNotMatch(stderr, /\n {4}at |bug/, 'no trace of the stack');
  }
});

test('a wrong command line ends with code 2 and the usage', () => {
  for (const [words, message] of [[[], /no command/], [['info'], /needs a FILE/], [['info', 'a', 'b'], /one FILE.* 2/], [['info', 'a', '--al'], /--al\b/], [['report', 'a'], /no command report.*pycullet/], [['inf', 'a'], /unknown command inf/]]) {
    const { stdout, stderr, status } = run(...words);
    assert.deepEqual([status, stdout], [2, ''], words.join(' '));
    assert.match(stderr, message);
    assert.match(stderr, /Usage: cullet info FILE/);
  }
});

test('help shows examples and the exit codes, and the version is that of the package', () => {
  for (const words of [['--help'], ['info', '-h']]) {
    const { stdout, status } = run(...words);
    assert.equal(status, 0);
    assert.match(stdout, /npx cullet info model\.glb\n/);
    assert.match(stdout, /2 wrong command line; 3 /);
  }
  assert.equal(run('--version').stdout, `cullet ${manifest.version}\n`);
  assert.ok(existsSync(program) && readFileSync(program, 'utf8').startsWith('#!/usr/bin/env node\n'));
});

test('programs call the same', async () => {
  const { CulletError, filesNamed, info, init } = await entry('files');
  await init();
  const { json, bin } = gltf('parts/box.bin');
  assert.deepEqual(filesNamed(json, 'a.gltf'), ['parts/box.bin']);
  assert.deepEqual(filesNamed(new TextEncoder().encode(OBJ), 'a.obj'), []);
  assert.equal(info(json, 'a.gltf', { 'parts/box.bin': bin, 'other.bin': new ArrayBuffer(3) }).scene.triangles, 36);
  assert.throws(() => info(json, 'a.gltf', {}), (e) => e instanceof CulletError && e.code === 'file' && /parts\/box\.bin/.test(e.message));
  assert.throws(() => info(json, 'a.gltf', { 'parts/box.bin': bin.subarray(1) }), (e) => e.code === 'file');
  assert.throws(() => info('a.gltf'), (e) => e.code === 'argument');
  assert.throws(() => info(json, 'a.gltf', { x: 'text' }), (e) => e.code === 'argument' && /file x/.test(e.message));
});

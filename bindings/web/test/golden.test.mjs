import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { join } from 'node:path';
import { test } from 'node:test';
import { compare } from './golden.mjs';
import { entry } from './package.mjs';

const folder = process.env.CULLET_GOLDEN;
const skip = folder || process.env.CULLET_REQUIRE_DATA === '1' ? false : 'CULLET_GOLDEN names no folder: cargo xtask bindings web';
const { CulletError, init, Scene } = await entry('files');

test('baked files give the answers that every host gives', { skip }, async () => {
  assert.ok(folder, 'CULLET_GOLDEN must name the folder of the shared answers');
  await init();
  const { scenes } = JSON.parse(readFileSync(join(folder, 'golden.json'), 'utf8'));
  assert.ok(scenes.length >= 5);
  for (const scene of scenes) assert.ok(compare(Scene, readFileSync(join(folder, scene.file)), scene) > 0);
});

test('a file that is none is refused by name', async () => {
  await init();
  const refused = (bytes, name, message) => assert.throws(() => Scene.open(bytes, name), (e) => e instanceof CulletError && e.code === 'file' && message.test(e.message));
  refused(new Uint8Array(100), 'noise.bin', /noise\.bin/);
  refused(new Uint8Array(0), 'empty.glb', /empty\.glb/);
  refused(new TextEncoder().encode('v 0 0 0\nv 1 0 0\nf 1 2 9\n'), 'wrong.obj', /wrong\.obj.*9/);
  assert.throws(() => Scene.open('model.glb'), (e) => e.code === 'argument');
  const one = Scene.open(new TextEncoder().encode('v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n'), 'one.obj');
  assert.equal(one.triangleCount, 1);
  one.dispose();
});

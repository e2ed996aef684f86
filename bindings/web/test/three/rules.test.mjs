// What is noticed, mistakes and their messages, the types, and the first use.

import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { mkdirSync, mkdtempSync, readFileSync, rmSync, symlinkSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { launch, modules, open, packageFolder, root, serve } from './harness.mjs';

let server, browser;
before(async () => { server = await serve(); browser = await launch(); });
after(async () => { await browser?.close(); server?.close(); });

// In both renderers.
const inPage = (name, body) => {
  for (const api of ['webgl', 'webgpu']) {
    test(`${name}, ${api}`, async () => {
      const page = await open(browser, server.url, api);
      const answer = await page.evaluate(body);
      assert.deepEqual(page.errors, []);
      await page.close();
      assert.deepEqual(answer, answer.map(([what]) => [what, true]));
    });
  }
};

inPage('what stands still is not looked at, and what is told is', async () => {
  const T = t.three;
  const found = [];
  const is = (what, truth) => found.push([what, Boolean(truth)]);
  const scene = new T.Scene();
  const camera = new T.PerspectiveCamera(60, 1.6, 0.1, 100);
  const mesh = new T.Mesh(new T.BoxGeometry(), new T.MeshNormalMaterial());
  mesh.position.z = -5;
  scene.add(mesh);
  const culling = new t.Culling(scene, { still: true });
  const seen = () => { t.renderer.render(scene, camera); return culling.stats.visible; };
  is('seen at first', seen() === 1);
  mesh.position.z = 5;
  is('moved behind the eye, not told: still where it was', seen() === 1 && mesh.matrixWorld.elements[14] === -5);
  culling.update(mesh);
  is('told', seen() === 0);
  culling.still = false;
  mesh.position.z = -5;
  is('watched', seen() === 1);
  mesh.geometry.attributes.position.array.forEach((v, i, a) => { if (i % 3 === 2) a[i] = v + 50; });
  mesh.geometry.attributes.position.needsUpdate = true;
  mesh.geometry.computeBoundingSphere();
  culling.update(mesh);
  is('geometry changed in place', seen() === 0);
  mesh.geometry = new T.BoxGeometry();
  is('another geometry', seen() === 1);
  mesh.position.x = 500;
  is('moved aside', seen() === 0);
  mesh.frustumCulled = false;
  is('frustumCulled is heard', seen() === 1);
  const late = new T.Mesh(new T.BoxGeometry(), mesh.material);
  late.position.z = -3;
  scene.add(late);
  is('added', seen() === 2);
  late.removeFromParent();
  is('removed', seen() === 1);
  culling.enabled = false;
  is('switched off, the children are all there', scene.children.length === 1 && (t.renderer.render(scene, camera), true));
  culling.enabled = true;
  is('switched on', seen() === 1);
  culling.dispose();
  culling.dispose();
  is('given back', !Object.hasOwn(mesh, 'intersectsFrustum') && !Object.hasOwn(scene, 'updateMatrixWorld') && !Object.hasOwn(scene.layers, 'test') && scene.children.length === 1);
  return found;
});

inPage('what is not ours keeps the test of three.js, also in a frustum that answered for ours', async () => {
  const T = t.three;
  const found = [];
  const is = (what, truth) => found.push([what, Boolean(truth)]);
  const camera = new T.PerspectiveCamera(60, 1.6, 0.1, 100);
  const drawn = [];
  const named = (object, name, z) => { object.name = name; object.position.z = z; object.onBeforeRender = () => drawn.push(name); return object; };
  const geometry = new T.BoxGeometry();
  const material = new T.MeshNormalMaterial();
  const lines = () => new T.LineSegments(new T.EdgesGeometry(geometry), new T.LineBasicMaterial());
  const [scene, other] = [new T.Scene(), new T.Scene()];
  for (const z of [-5, 5]) {
    scene.add(named(new T.Mesh(geometry, material), `mesh ${z}`, z), named(lines(), `lines ${z}`, z));
    other.add(named(new T.Mesh(geometry, material), `other ${z}`, z), named(lines(), `other lines ${z}`, z));
  }
  const culling = new t.Culling(scene);
  const render = (what) => { drawn.length = 0; t.renderer.render(what, camera); return [...drawn].sort().join(); };
  for (let i = 0; i < 2; i++) {
    is('ours before the eye', render(scene) === 'lines -5,mesh -5');
    is('the other scene', render(other) === 'other -5,other lines -5');
  }
  // The walk breaks off in the middle of ours.
  const broken = new T.Mesh(new T.BoxGeometry(), material);
  broken.position.z = -5;
  scene.add(broken);
  render(scene);
  Object.defineProperty(broken, 'material', { configurable: true, get() { throw new Error('broken'); } });
  let threw = false;
  try { render(scene); } catch { threw = true; }
  await null;
  await t.frame();
  is('broken off', threw);
  is('nothing answers any more', render(other) === 'other -5,other lines -5');
  Object.defineProperty(broken, 'material', { value: material, writable: true });
  is('and on', render(scene) === 'lines -5,mesh -5');
  culling.enabled = false;
  is('off', render(scene) === 'lines -5,mesh -5');
  culling.dispose();
  return found;
});

inPage('mistakes', async () => {
  const T = t.three;
  const found = [];
  const is = (what, truth) => found.push([what, Boolean(truth)]);
  const message = (f) => { try { f(); return 'nothing thrown'; } catch (e) { return e.message; } };
  const throws = (what, f, pattern) => found.push([what, pattern.test(message(f)) || message(f)]);
  const camera = new T.PerspectiveCamera(60, 1.6, 0.1, 100);
  const empty = new T.Scene();
  const culling = new t.Culling(empty, { occlusion: camera });
  t.renderer.render(empty, camera);
  is('a scene without meshes', culling.stats.objects === 0);
  const mesh = new T.Mesh(new T.BoxGeometry(), new T.MeshNormalMaterial());
  mesh.position.z = -5;
  empty.add(mesh);
  for (const aspect of [0, NaN, Infinity]) {
    camera.aspect = aspect;
    camera.updateProjectionMatrix();
    t.renderer.render(empty, camera);
    is(`a camera of aspect ${aspect} loses nothing`, culling.stats.visible === 1);
  }
  camera.aspect = 1;
  camera.updateProjectionMatrix();
  mesh.position.set(NaN, 0, 0);
  t.renderer.render(empty, camera);
  is('NaN is kept', culling.stats.visible === 1);
  throws('twice', () => new t.Culling(empty), /Scene \(id \d+\) is culled already; dispose\(\)/);
  throws('a mesh', () => new t.Culling(mesh), /takes a THREE.Scene or a group, not Mesh/);
  throws('nothing', () => new t.Culling(undefined), /takes a THREE.Scene or a group, not undefined/);
  throws('no camera', () => new t.Culling(new T.Scene(), { occlusion: mesh }), /occlusion takes a camera/);
  throws('other shadows', () => new t.Culling(new T.Scene(), { shadows: 'none' }), /shadows is 'all' or 'seen', not none/);
  throws('a stranger', () => culling.update(new T.Mesh()), /update\(\) of Mesh \(id \d+\), which is not below Scene/);
  const inner = new T.Group();
  empty.add(inner);
  throws('below one that is culled', () => new t.Culling(inner), /is culled already/);
  culling.dispose();
  throws('after dispose', () => culling.update(), /was disposed/);
  const again = new t.Culling(empty);
  is('and again', again.root === empty);
  again.dispose();
  return found;
});

test('tsc --strict takes the declarations, and refuses what it should', () => {
  const folder = mkdtempSync(join(tmpdir(), 'cullet-three-'));
  try {
    mkdirSync(join(folder, 'node_modules'));
    for (const name of ['three', '@types', 'typescript']) symlinkSync(join(modules, name), join(folder, 'node_modules', name));
    symlinkSync(packageFolder, join(folder, 'node_modules/cullet'));
    writeFileSync(join(folder, 'package.json'), '{ "type": "module" }');
    writeFileSync(join(folder, 'use.ts'), readFileSync(join(root, 'test/three/use.ts')));
    const tsc = (...more) => execFileSync(process.execPath, [join(modules, 'typescript/bin/tsc'), '--noEmit', '--strict', '--target', 'es2022', '--lib', 'es2022,dom,dom.iterable', '--preserveSymlinks', '--types', '', ...more, 'use.ts'], { cwd: folder, encoding: 'utf8', stdio: 'pipe' });
    try { tsc('--module', 'nodenext'); tsc('--module', 'esnext', '--moduleResolution', 'bundler'); } catch (error) { assert.fail(error.stdout || error.message); }
  } finally { rmSync(folder, { recursive: true, force: true }); }
});

test('the first use: ten lines, as the README has them', async () => {
  const program = readFileSync(join(root, 'test/three/first.js'), 'utf8').trim();
  assert.ok(program.split('\n').filter((line) => line.trim()).length <= 10);
  assert.ok(readFileSync(join(root, 'README.md'), 'utf8').includes(program), 'README.md shows another program');
  const page = await browser.newPage();
  const lines = [];
  page.on('console', (m) => lines.push(m.text()));
  await page.goto(`${server.url}/test/three/first.html`);
  for (let i = 0; i < 100 && !lines.some((l) => /drawn/.test(l)); i++) await page.waitForTimeout(100);
  const [, visible, all] = /(\d+) of (\d+) drawn/.exec(lines.join('\n')) ?? assert.fail(lines.join('\n'));
  assert.ok(all === '1000' && visible > 5 && visible < 60, lines.join('\n'));
  await page.close();
});

// Levels of instances: the choice against slow oracles, and what it does to pictures.

import assert from 'node:assert/strict';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { pathToFileURL } from 'node:url';
import { launch, modules, open, packageFolder, serve } from './harness.mjs';
import { random } from './scenes.js';

const levels = await import(pathToFileURL(join(packageFolder, 'js/three/levels.js')));
const T = await import(pathToFileURL(join(modules, 'three/build/three.module.js')));

const SIZE = [960, 540];
const rendererOf = (target = null, ratio = 1) => ({
  getRenderTarget: () => target, getPixelRatio: () => ratio, getViewport: (to) => to.copy({ z: SIZE[0] / ratio, w: SIZE[1] / ratio }), domElement: { width: SIZE[0], height: SIZE[1] },
});

// A camera, the matrix of a mesh and of an instance in it, a box and a chain, all at random.
function anything(next, { isEven = false } = {}) {
  const size = () => 10 ** (3 * next() - 1.5);
  const turn = () => new T.Quaternion(next() - 0.5, next() - 0.5, next() - 0.5, next() - 0.5).normalize();
  const scaled = () => (isEven ? new T.Vector3().setScalar(size()) : new T.Vector3(size(), -size(), size()));
  const place = (reach, scale) => new T.Matrix4().compose(new T.Vector3((next() - 0.5) * reach, (next() - 0.5) * reach, (next() - 0.5) * reach), turn(), scale);
  const camera = next() < 0.3 ? new T.OrthographicCamera(-30 * next() - 1, 40 * next() + 1, 20 * next() + 1, -20, 0.1, 900) : new T.PerspectiveCamera(20 + 90 * next(), SIZE[0] / SIZE[1], 0.1, 900);
  if (next() < 0.3) camera.setViewOffset(100, 60, 50 * next(), 20 * next(), 40, 30);
  camera.updateProjectionMatrix();
  camera.matrixWorld.copy(place(40, new T.Vector3().setScalar(isEven || next() < 0.7 ? 1 : size())));
  camera.matrixWorldInverse.copy(camera.matrixWorld).invert();
  const world = place(30, isEven ? new T.Vector3(1, 1, 1) : scaled());
  const instance = place(200, scaled());
  // Skewed, too.
  if (!isEven && next() < 0.3) instance.multiply(place(1, scaled()));
  const box = [-next(), -next(), -next(), next(), next(), next()];
  let error = 0;
  const errors = Array.from({ length: 7 }, (_, k) => (error += k === 0 ? 0 : next() * 0.02 * 3 ** k));
  return { camera, world, instance, box, chain: { errors, pixels: 4 * next(), corners: next() < 0.5 } };
}

function chosen({ camera, world, instance, box, chain }, renderer = rendererOf()) {
  const view = levels.viewOf(renderer, camera);
  if (!view) return 0;
  const places = new Float64Array(levels.PLACE);
  levels.place(places, 0, box, 0, instance.elements, 0);
  return levels.levelFor(levels.viewIn(world.elements, view), places, 0, chain);
}

const project = (camera, p) => { const q = new T.Vector4(p.x, p.y, p.z, 1).applyMatrix4(camera.matrixWorldInverse).applyMatrix4(camera.projectionMatrix); return [q.x / q.w, q.y / q.w, q.w]; };

test('nothing of a level that is chosen is off by more pixels than are allowed', () => {
  const next = random(5);
  let [tried, coarse, largest] = [0, 0, 0];
  for (let i = 0; i < 12000; i++) {
    const made = anything(next);
    const { camera, world, instance, box, chain } = made;
    const level = chosen(made);
    if (level === 0) continue;
    coarse += 1;
    const whole = world.clone().multiply(instance);
    const ahead = new T.Vector3(0, 0, -1).transformDirection(camera.matrixWorld);
    const cosine = (p) => { const to = p.clone().sub(new T.Vector3().setFromMatrixPosition(camera.matrixWorld)); return to.normalize().dot(ahead); };
    for (let k = 0; k < 40; k++) {
      const p = new T.Vector3(...[0, 1, 2].map((c) => box[c] + next() * (box[3 + c] - box[c])));
      const q = new T.Vector3(next() - 0.5, next() - 0.5, next() - 0.5).setLength(chain.errors[level] * (next() < 0.5 ? 1 : next())).add(p);
      // The box holds all levels.
      if ([q.x, q.y, q.z].some((v, c) => v < box[c] || v > box[3 + c])) continue;
      for (const at of [p, q]) at.applyMatrix4(whole);
      const [one, other] = [p, q].map((at) => project(camera, at));
      if ([one, other].some(([x, y, w]) => !(w > 0 && Math.abs(x) <= 1 && Math.abs(y) <= 1))) continue;
      tried += 1;
      const pixels = Math.hypot((one[0] - other[0]) * SIZE[0] / 2, (one[1] - other[1]) * SIZE[1] / 2);
      const angle = chain.corners || camera.isOrthographicCamera ? 1 : Math.min(cosine(p), cosine(q)) ** 2;
      largest = Math.max(largest, pixels * angle / chain.pixels);
      assert.ok(pixels * angle <= chain.pixels * (1 + 1e-5), `case ${i}: level ${level} is off by ${pixels} pixels, and ${chain.pixels} are allowed`);
    }
  }
  assert.ok(coarse > 1000 && tried > 7000, `${coarse} cases with a coarser level, ${tried} points`);
  // A bound that is never nearly reached would draw too much.
  assert.ok(largest > 0.5, `at most ${largest} of what is allowed`);
});

test('a level is never coarser than the exact distance and stretch allow, and seldom finer', () => {
  const next = random(6);
  let [ours, exact] = [0, 0];
  for (let i = 0; i < 4000; i++) {
    const made = anything(next, { isEven: true });
    const { camera, world, instance, box, chain } = made;
    const level = chosen(made);
    // Scales are even here: the greatest stretch is that of any direction. The distance: by halving steps from the middle of the box.
    const whole = world.clone().multiply(instance);
    const s = new T.Vector3(1, 0, 0).applyMatrix4(new T.Matrix4().extractRotation(whole)).length() * whole.getMaxScaleOnAxis();
    const eye = new T.Vector3().setFromMatrixPosition(camera.matrixWorld).applyMatrix4(whole.clone().invert());
    const d = eye.clone().clamp(new T.Vector3(...box), new T.Vector3(...box.slice(3))).distanceTo(eye) * s;
    const p = camera.projectionMatrix.elements;
    const k = Math.max(p[0] * SIZE[0], p[5] * SIZE[1]) / 2;
    const corners = camera.isOrthographicCamera || !chain.corners ? 1 : 1 + ((1 + Math.abs(p[8])) / p[0]) ** 2 + ((1 + Math.abs(p[9])) / p[5]) ** 2;
    const pixels = (e) => e * s * k * corners / (camera.isOrthographicCamera ? 1 : d);
    let oracle = chain.errors.length - 1;
    while (oracle > 0 && !(pixels(chain.errors[oracle]) <= chain.pixels)) oracle -= 1;
    assert.ok(level <= oracle, `case ${i}: level ${level}, and ${oracle} is the coarsest within ${chain.pixels} pixels`);
    ours += level;
    exact += oracle;
  }
  // Boxes around turned boxes are nearer to the eye.
  assert.ok(ours >= 0.97 * exact && exact > 3000, `levels are ${ours} in sum, and ${exact} by the oracle`);
});

test('a skewed instance counts by its greatest stretch, which no column shows', () => {
  const camera = new T.OrthographicCamera(-48, 48, 27, -27, 0.1, 100);
  camera.updateMatrixWorld();
  const [world, instance] = [new T.Matrix4(), new T.Matrix4().set(1, 0.9, 0, 0, 0, Math.sqrt(1 - 0.81), 0, 0, 0, 0, 1, -9, 0, 0, 0, 1)];
  const made = { camera, world, instance, box: [-1, -1, -1, 1, 1, 1], chain: { errors: [0, 0.1], pixels: 1.2, corners: false } };
  // Ten pixels a unit: 0.1 is a pixel, and 1.38 along the stretch.
  assert.equal(chosen(made), 0);
  assert.equal(chosen({ ...made, instance: new T.Matrix4().setPosition(0, 0, -9) }), 1);
});

test('what is not known, and no allowance, is drawn in full', () => {
  const next = random(8);
  for (let i = 0; i < 300; i++) {
    for (const pixels of [0, -1, NaN]) { const made = anything(next); made.chain.pixels = pixels; made.chain.errors[1] = 0; assert.equal(chosen(made), 0, `${pixels} pixels`); }
    for (const bad of [NaN, Infinity]) {
      for (const name of ['world', 'instance']) {
        const made = anything(next);
        made[name].elements[Math.floor(next() * 3) + 4 * Math.floor(next() * 4)] = bad;
        assert.equal(chosen(made), 0, `${bad} in ${name}`);
      }
      const made = anything(next);
      made.box[Math.floor(6 * next())] = bad;
      if (bad !== Infinity) assert.equal(chosen(made), 0, `${bad} in the box`);
      const other = anything(next);
      other.camera.matrixWorld.elements[12] = other.camera.matrixWorldInverse.elements[12] = bad;
      if (other.camera.isPerspectiveCamera) assert.equal(chosen(other), 0, `${bad} in the camera`);
    }
    const inside = anything(next);
    if (inside.camera.isOrthographicCamera) continue;
    inside.instance.setPosition(0, 0, 0);
    inside.camera.matrixWorld.setPosition(new T.Vector3().setFromMatrixPosition(inside.world));
    inside.camera.matrixWorldInverse.copy(inside.camera.matrixWorld).invert();
    assert.equal(chosen(inside), 0, 'the eye is in the box');
  }
});

test('pixels are those of what is drawn into', () => {
  const next = random(9);
  for (let i = 0; i < 200; i++) {
    const made = anything(next);
    const full = chosen(made);
    const target = { width: 2 * SIZE[0], height: 2 * SIZE[1], viewport: { z: 2 * SIZE[0], w: 2 * SIZE[1] } };
    assert.equal(chosen(made, rendererOf(target)), chosen({ ...made, chain: { ...made.chain, pixels: made.chain.pixels / 2 } }), 'a target twice as large');
    assert.equal(chosen(made, rendererOf(null, 2)), full, 'a ratio of 2');
    const larger = { ...rendererOf(), getViewport: (to) => to.copy({ z: 4 * SIZE[0], w: 4 * SIZE[1] }) };
    assert.equal(chosen(made, larger), chosen({ ...made, chain: { ...made.chain, pixels: made.chain.pixels / 4 } }), 'a viewport larger than the canvas');
  }
});

let server, browser;
before(async () => { server = await serve(); browser = await launch(); });
after(async () => { await browser?.close(); server?.close(); });

const kinds = ['Batched', 'Instanced'];
// One page for all tests of a renderer.
const pages = {};
const inPage = async (api, body) => {
  const page = pages[api] ??= await open(browser, server.url, api);
  await body((...values) => page.evaluate(...values));
  assert.deepEqual(page.errors, []);
};

// In the sum of all steps, for so many pixels: triangles, as a share of those drawn in full, pixels that differ, and pixels with a colour that
// the other picture has nowhere within a pixel more: what shows through where two outlines meet. As measured, and up to a quarter more.
const limits = {
  1: { share: 0.08, differ: 3000, far: 16 },
  4: { share: 0.04, differ: 9000, far: 60 },
};

for (const api of ['webgl', 'webgpu']) {
  for (const kind of kinds) {
    test(`${kind}, ${api}: fewer triangles, and outlines are off by no more than is allowed`, () => inPage(api, async (evaluate) => {
      const sum = (list, what) => list.reduce((all, one) => all + one[what], 0);
      const hiding = { occlusion: true, preset: 'exact' };
      const ways = [[{}, 0], [{ pixels: 0 }, 0], [{ pixels: 0, ...hiding }, 0], [{ pixels: 1 }, 2], [{ pixels: 4 }, 5], [{ pixels: 1, ...hiding }, 2]];
      const [none, culled, exact, hidden, ...coarse] = await evaluate(([name, list]) => t.deviations(name, list), [`grove${kind}`, ways]);
      assert.deepEqual(exact.map((p) => [p.digest, p.triangles]), culled.map((p) => [p.digest, p.triangles]), '0 pixels: as without levels');
      for (const pictures of [exact, hidden]) assert.deepEqual(pictures.map((p) => p.digest), none.map((p) => p.digest), '0 pixels: as without culling');
      for (const [i, steps] of coarse.entries()) {
        const [{ pixels, occlusion }, reach] = ways[3 + i];
        const { share, differ, far } = limits[pixels];
        const said = `${pixels} pixels${occlusion ? ' and occlusion' : ''}: ${sum(steps, 'triangles')} of ${sum(culled, 'triangles')} triangles, ${sum(steps, 'differ')} pixels differ, ${sum(steps, 'far')} and ${sum(steps, 'lost')} by more than ${reach}`;
        if (process.env.VERBOSE) console.log(api, kind, said);
        assert.ok(sum(steps, 'triangles') <= share * sum(culled, 'triangles'), said);
        assert.ok(steps.every(({ stats }) => stats.coarserInstances > 0 && stats.coarserInstances <= stats.visibleInstances && stats.visible <= 1), said);
        assert.ok(sum(steps, 'differ') > 0 && sum(steps, 'differ') <= differ, said);
        assert.ok(sum(steps, 'far') <= far && sum(steps, 'lost') <= far, said);
      }
    }));

    test(`${kind}, ${api}: levels of a baked file`, () => inPage(api, async (evaluate) => {
      const [none, culled, coarse] = await evaluate(([name]) => t.deviations(name, [[{}, 0], [{ pixels: 1 }, 2]]), [`rings${kind}`]);
      const said = coarse.map(({ triangles, differ, far, lost }, i) => `${triangles} of ${culled[i].triangles} triangles, ${differ} pixels differ, ${far} and ${lost} by more than 2`).join('; ');
      if (process.env.VERBOSE) console.log(api, kind, said);
      assert.deepEqual(culled.map((p) => p.digest), none.map((p) => p.digest));
      assert.ok(coarse.every(({ triangles, differ, far, lost }, i) => triangles < [0.3, 0.14][i] * culled[i].triangles && differ > 0 && differ < 770 && far <= 18 && lost <= 18), said);
    }));

    test(`${kind}, ${api}: a coarser level hides only what it covers`, () => inPage(api, async (evaluate) => {
      for (const pixels of [0, 500]) {
        const [alone, hidden] = await evaluate(async ([name, px]) => [await t.pictures(name, { pixels: px }), await t.pictures(name, { pixels: px, occlusion: true, preset: 'exact' })], [`edge${kind}`, pixels]);
        assert.deepEqual(hidden.map((p) => p.digest), alone.map((p) => p.digest), `${pixels} pixels`);
        assert.ok(pixels > 0 || hidden.every(({ stats }) => stats.hidden === 60), 'the whole wall hides all');
        assert.ok(pixels === 0 || alone.some(({ stats }) => stats.coarserInstances === 1), 'the smaller wall is drawn');
      }
      // The camera of a pass decides: with so many pixels allowed the wall is drawn in full from near alone.
      const [far, near, back] = await evaluate(([name]) => t.pictures(name, { pixels: 30, occlusion: true, preset: 'exact' }), [`edge${kind}`]);
      assert.deepEqual([far, near, back].map(({ stats }) => [stats.coarserInstances, stats.hidden === 60]), [[1, false], [0, true], [1, false]]);
      assert.equal(back.digest, far.digest);
    }));

    test(`${kind}, ${api}: shadows are those of the finest level`, () => inPage(api, async (evaluate) => {
      for (const shadows of ['all', 'seen']) {
        const [none, drawn] = await evaluate(async ([name, how]) => [await t.pictures(name, 'none'), await t.pictures(name, how)], [`shade${kind}`, { pixels: 1000, shadows }]);
        assert.ok(drawn[0].stats.allCast === null, drawn[0].stats.allCast);
        assert.notEqual(drawn[0].digest, none[0].digest, 'the ball in the picture is coarser');
        assert.equal(drawn[1].digest, none[1].digest, 'the shadow of the ball beside it is not');
      }
    }));

    test(`${kind}, ${api}: two cameras, freezing, switching off, another chain`, () => inPage(api, async (evaluate) => {
      const answer = await evaluate(async ([name]) => {
        await t.build(name);
        t.never();
        const [{ digest: none }] = [await t.picture()];
        await t.build(name);
        t.cull({ pixels: 1 });
        const found = [];
        const is = (what, truth) => found.push([what, Boolean(truth)]);
        const { now } = t;
        const draw = async (camera = now.camera) => { const had = now.camera; now.camera = camera; const p = await t.picture(); now.camera = had; return p; };
        const first = await draw();
        const plan = now.camera.clone();
        plan.position.set(0, 90, 0);
        plan.lookAt(0, 0, 0);
        const above = await draw(plan);
        is('each camera has its own levels', above.triangles / above.stats.visibleInstances < 0.5 * first.triangles / first.stats.visibleInstances);
        is('and again', (await draw()).digest === first.digest && (await draw(plan)).digest === above.digest);
        // In one task, without a frame between.
        t.renderer.render(now.scene, now.camera); t.renderer.render(now.scene, plan);
        is('one after the other', (await draw()).digest === first.digest);
        now.culling.frozen = true;
        await draw();
        const [x, y, z] = now.camera.position.toArray();
        now.camera.position.set(0, 400, 0);
        const far = await draw();
        is('frozen: as many triangles from far away', far.triangles === first.triangles && far.stats.coarserInstances === first.stats.coarserInstances);
        now.camera.position.set(x, y, z);
        now.culling.frozen = false;
        is('no longer', (await draw()).digest === first.digest);
        now.culling.update(now.mesh);
        is('update() of the mesh keeps them', (await draw()).digest === first.digest);
        now.culling.update();
        is('so does update() of all', (await draw()).digest === first.digest);
        now.mesh.removeFromParent();
        await draw();
        now.scene.add(now.mesh);
        is('and so does adding it again', (await draw()).digest === first.digest);
        now.culling.enabled = false;
        is('off', (await draw()).digest === none);
        now.culling.enabled = true;
        is('on', (await draw()).digest === first.digest);
        now.culling.levels(now.mesh, now.chain.slice(0, 2));
        const two = await draw();
        is('another chain', two.triangles > 2 * first.triangles && two.stats.coarserInstances > 0);
        now.culling.levels(now.mesh, now.chain, { corners: true });
        const corners = await draw();
        is('corners count', corners.triangles > 1.2 * first.triangles && corners.triangles < two.triangles);
        now.culling.levels(now.mesh, null);
        const full = await draw();
        is('none', full.digest === none && full.stats.coarserInstances === 0);
        now.culling.levels(now.mesh, now.chain);
        is('with levels again', (await draw()).digest === first.digest);
        now.culling.dispose();
        is('disposed', (await draw()).digest === none);
        return found;
      }, [`grove${kind}`]);
      assert.deepEqual(answer, answer.map(([what]) => [what, true]));
    }));
  }

  test(`${api}: geometries of a batch that go or change are no levels any more`, () => inPage(api, async (evaluate) => {
    const answer = await evaluate(async () => {
      await t.build('groveBatched');
      t.cull({ pixels: 20 });
      const found = [];
      const is = (what, truth) => found.push([what, Boolean(truth)]);
      const { mesh, chain, culling } = t.now;
      const all = await t.picture();
      mesh.deleteGeometry(chain[4].geometry);
      const fewer = await t.picture();
      is('the coarsest is gone', fewer.triangles > all.triangles);
      const cube = mesh.addGeometry(new t.three.BoxGeometry());
      is('its number is used again', cube === chain[4].geometry && (await t.picture()).digest === fewer.digest);
      mesh.setGeometryAt(chain[3].geometry, new t.three.BoxGeometry());
      const least = await t.picture();
      is('one that was replaced is gone', least.triangles > fewer.triangles);
      mesh.setGeometryIdAt(5, cube);
      is('instances of another geometry have no levels', (await t.picture()).stats.coarserInstances <= least.stats.coarserInstances);
      mesh.setGeometryIdAt(5, chain[0].geometry);
      is('and have them again', (await t.picture()).digest === least.digest);
      mesh.optimize();
      is('moved within the batch', (await t.picture()).digest === least.digest);
      mesh.setVisibleAt(0, false);
      mesh.setVisibleAt(0, true);
      is('hidden and shown', (await t.picture()).digest === least.digest);
      mesh.setGeometryAt(chain[0].geometry, new t.three.SphereGeometry(1, 12, 8));
      is('another finest has none', (await t.picture()).stats.coarserInstances === 0);
      culling.dispose();
      return found;
    });
    assert.deepEqual(answer, answer.map(([what]) => [what, true]));
  }));
}

test('boxes hold all levels, and a mesh with another geometry has the chain of that', () => inPage('webgl', async (evaluate) => {
  const answer = await evaluate(async () => {
    const T = t.three;
    const found = [];
    const scene = new T.Scene();
    const camera = new T.PerspectiveCamera(60, 1.6, 0.1, 100);
    const [small, large, ball, coarse] = [new T.BoxGeometry(0.5, 0.5, 0.5), new T.BoxGeometry(8, 8, 0.5), new T.SphereGeometry(1, 16, 12), new T.SphereGeometry(1, 5, 3)];
    const mesh = new T.InstancedMesh(small, new T.MeshBasicMaterial(), 1);
    mesh.setMatrixAt(0, new T.Matrix4().setPosition(-12, 0, -10));
    const batch = new T.BatchedMesh(1, 100, 200, new T.MeshBasicMaterial());
    const ids = [small, large].map((g) => batch.addGeometry(g));
    batch.setMatrixAt(batch.addInstance(ids[0]), new T.Matrix4().setPosition(12, 0, -10));
    scene.add(mesh, batch);
    const culling = new t.Culling(scene);
    const draw = () => { t.renderer.info.reset(); t.renderer.render(scene, camera); return culling.stats; };
    found.push(['beside the picture', draw().visibleInstances === 0]);
    culling.levels(mesh, [{ geometry: small, error: 0 }, { geometry: large, error: 5 }], { pixels: 1000 });
    found.push(['a larger level of an InstancedMesh', draw().visibleInstances === 1 && culling.stats.coarserInstances === 1]);
    culling.levels(batch, [{ geometry: ids[0], error: 0 }, { geometry: ids[1], error: 5 }], { pixels: 1000 });
    found.push(['and of a BatchedMesh', draw().visibleInstances === 2 && culling.stats.coarserInstances === 2]);
    mesh.geometry = ball;
    culling.levels(mesh, [{ geometry: ball, error: 0 }, { geometry: coarse, error: 0.5 }], { pixels: 1000 });
    mesh.setMatrixAt(0, new T.Matrix4().setPosition(0, 0, -10));
    mesh.instanceMatrix.needsUpdate = true;
    batch.visible = false;
    const triangles = () => { draw(); return t.renderer.info.render.triangles; };
    found.push(['another chain', triangles() === coarse.index.count / 3]);
    mesh.geometry = small;
    found.push(['the first again', triangles() === 12]);
    mesh.geometry = large;
    found.push(['a geometry without one', triangles() === 12 && culling.stats.coarserInstances === 0]);
    mesh.geometry = ball;
    found.push(['the other again', triangles() === coarse.index.count / 3]);
    culling.dispose();
    return found;
  });
  assert.deepEqual(answer, answer.map(([what]) => [what, true]));
}));

test('mistakes', () => inPage('webgl', async (evaluate) => {
  const answer = await evaluate(async () => {
    const T = t.three;
    const found = [];
    const throws = (what, f, pattern) => { let said = 'nothing thrown'; try { f(); } catch (e) { said = `${e.name}: ${e.message}`; } found.push([what, pattern.test(said) || said]); };
    const scene = new T.Scene();
    const culling = new t.Culling(scene);
    const mesh = new T.InstancedMesh(new T.BoxGeometry(), new T.MeshBasicMaterial(), 2);
    const batch = new T.BatchedMesh(2, 100, 200, new T.MeshBasicMaterial());
    const [fine, coarse] = [batch.addGeometry(new T.BoxGeometry()), batch.addGeometry(new T.BoxGeometry())];
    const own = { geometry: mesh.geometry, error: 0 };
    const other = { geometry: new T.BoxGeometry(), error: 1 };
    throws('not below', () => culling.levels(mesh, [own]), /Error: cullet: levels\(\) of Mesh.*not below Scene/);
    const shader = new T.InstancedMesh(new T.BoxGeometry(), new T.ShaderMaterial(), 2);
    scene.add(mesh, batch, shader);
    throws('a mesh', () => culling.levels(new T.Mesh(), [own]), /TypeError.*takes a BatchedMesh or an InstancedMesh, not Mesh/);
    throws('three culls it', () => culling.levels(shader, [own]), /three.js culls by itself/);
    throws('no list', () => culling.levels(mesh), /array of 1 to 255 levels/);
    throws('an empty list', () => culling.levels(mesh, []), /array of 1 to 255 levels/);
    throws('another finest', () => culling.levels(mesh, [other]), /geometry of level 0 is not that of the mesh/);
    throws('no geometry', () => culling.levels(mesh, [own, { geometry: 3, error: 1 }]), /geometry of level 1 is no BufferGeometry with positions/);
    throws('twice', () => culling.levels(mesh, [own, other, { ...other }]), /level 2 has the geometry of level 1/);
    throws('an error of the finest', () => culling.levels(mesh, [{ ...own, error: 0.1 }]), /its error is 0, not 0.1/);
    for (const error of [NaN, -1, Infinity, undefined]) throws(`error ${error}`, () => culling.levels(mesh, [own, { ...other, error }]), /error of level 1 is .*at least 0/);
    throws('falling', () => culling.levels(mesh, [own, other, { geometry: new T.BoxGeometry(), error: 0.5 }]), /error of level 2 is 0.5.*at least 1/);
    throws('pixels', () => culling.levels(mesh, [own], { pixels: '1' }), /pixels is a number, not 1/);
    throws('no id of the batch', () => culling.levels(batch, [{ geometry: fine, error: 0 }, { geometry: 7, error: 1 }]), /geometry of level 1 is 7, and not one that addGeometry/);
    throws('a geometry in a batch', () => culling.levels(batch, [own]), /geometry of level 0 is object, and not one/);
    culling.levels(batch, [{ geometry: fine, error: 0 }, { geometry: coarse, error: 1 }]);
    culling.dispose();
    throws('disposed', () => culling.levels(batch, null), /was disposed/);
    return found;
  });
  assert.deepEqual(answer, answer.map(([what]) => [what, true]));
}));

// Shadow maps by what is seen: the same picture, to the pixel, with fewer draws; and what would show, shows.

import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { launch, open, serve } from './harness.mjs';

let server, browser;
before(async () => { server = await serve(); browser = await launch(); });
after(async () => { await browser?.close(); server?.close(); });

// CULLET_SCENES: some of them, by their names.
const names = process.env.CULLET_SCENES?.split(',') ?? ['lamps', 'shadows', 'instancesInShadow', 'batchInShadow', 'cascades', 'eyes', 'variance', 'addon', 'group', 'odd'];

const digests = (list) => list.map(({ digest }) => digest);
const sum = (list, of) => list.reduce((all, picture) => all + of(picture), 0);

for (const api of ['webgl', 'webgpu']) {
  test(api, async (context) => {
    const page = await open(browser, server.url, api);
    for (const name of names) {
      await context.test(name, async () => {
        const take = (how) => page.evaluate(([n, h]) => t.pictures(n, h), [name, how]);
        const none = await take('none');
        const all = await take({});
        const seen = await take({ shadows: 'seen' });
        const both = await take({ shadows: 'seen', occlusion: true, preset: 'exact', callbacks: true });
        assert.deepEqual(digests(seen), digests(none), JSON.stringify(seen.map(({ stats }) => [stats.keptMaps, stats.allCast])));
        assert.deepEqual(digests(both), digests(none));
        assert.ok(sum(seen, (p) => p.triangles) <= sum(all, (p) => p.triangles), `${sum(seen, (p) => p.triangles)} triangles, ${sum(all, (p) => p.triangles)} where all cast`);
        const reasons = new Set(seen.map(({ stats }) => stats.allCast));
        if (process.env.VERBOSE) console.log(api, name, sum(all, (p) => p.calls), sum(seen, (p) => p.calls), sum(both, (p) => p.calls), [...reasons]);
        if (name === 'variance') assert.match([...reasons].join(), /variance/);
        else if (!['addon', 'odd', 'group'].includes(name)) assert.deepEqual([...reasons], [null]);
        if (name === 'lamps') {
          assert.ok(sum(seen, (p) => p.calls) < sum(all, (p) => p.calls) * 0.6, `${sum(seen, (p) => p.calls)} draws, ${sum(all, (p) => p.calls)} where all cast`);
          assert.ok(sum(seen, (p) => p.stats.keptMaps) > 20, `${sum(seen, (p) => p.stats.keptMaps)} maps kept`);
          assert.ok(new Set(digests(none)).size > 8, 'steps that are not seen');
        }
      });
    }
    assert.deepEqual(page.errors, []);
    await page.close();
  });
}

// Renders beside each other in one frame, in which WebGPURenderer draws the maps of a camera once; and a mirror, which renders inside.
for (const api of ['webgl', 'webgpu']) {
  test(`several renders in a frame, ${api}`, async () => {
    const page = await open(browser, server.url, api);
    const [none, seen, reasons] = await page.evaluate(async () => {
      const taken = [];
      let reasons;
      for (const how of [null, { shadows: 'seen' }]) {
        await t.build('lamps');
        const { scene, camera, step } = t.now;
        if (how) t.cull(how); else t.never();
        const list = [];
        await t.frame();
        for (const [yaw, i] of [[0.3], [2.4], [4], [0.3, 10], [0.3]]) {
          t.now.camera = camera;
          if (i) step(i, null);
          else camera.rotation.set(-0.05, yaw, 0, 'YXZ');
          list.push((await t.picture(false)).digest);
        }
        const T = t.three;
        t.now.camera = camera;
        let mirror;
        if (t.renderer.isWebGLRenderer) {
          const { Reflector } = await import('three/addons/objects/Reflector.js');
          mirror = new Reflector(new T.PlaneGeometry(30, 20));
        } else {
          const { reflector } = await import('three/tsl');
          const node = reflector();
          mirror = new T.Mesh(new T.PlaneGeometry(30, 20), new T.MeshBasicNodeMaterial());
          mirror.material.colorNode = node;
          mirror.add(node.target);
        }
        mirror.position.set(0, 4, -9);
        if (!how) mirror.frustumCulled = false;
        scene.add(mirror);
        camera.rotation.set(-0.05, 0.2, 0, 'YXZ');
        for (let k = 0; k < 2; k++) list.push((await t.picture()).digest);
        reasons = t.now.culling?.stats.allCast;
        taken.push(list);
      }
      return [...taken, reasons];
    });
    assert.deepEqual(seen, none);
    assert.ok(new Set(none).size >= 5, none.join());
    assert.ok(reasons !== null);
    assert.deepEqual(page.errors, []);
    await page.close();
  });
}

// What goes wrong if a rule is not there.
const mutants = [
  ['a caster lost at the edge of what is seen', 'footprint.js', 'cell(at[0] - margin), cell(at[1] + margin)', 'cell(at[0] + 0.1), cell(at[1] - 0.1)'],
  ['a caster lost by its depth', 'footprint.js', '!(depths[k] < at[4])', '!(depths[k] < at[5] + 3)'],
  ['a light dropped too early', 'shadows.js', '1.001 * far', '0.4 * far'],
  ['an old map kept while casters moved into sight', 'shadows.js', 'isAny || shadow.map === null', '(isAny && !state.isPartial) || shadow.map === null'],
  ['maps that are not drawn again lack casters', 'shadows.js', 'if (!state.isPartial) continue;', 'continue;'],
  ['a light that moved keeps where its shadows were', 'shadows.js', 'shadow.matrix.makeTranslation(-x, -y, -z);', ''],
  ['half of what receives is forgotten', 'shadows.js', 'for (const end of [axis, 3 + axis])', 'for (const end of [axis])'],
  ['what receives is forgotten: instances', 'culling.js', 'receivers.add(box, 0, matrix, 0); return true;', 'return true;'],
];

test('a rule that is switched off is noticed', async () => {
  const missed = [];
  const plain = await open(browser, server.url, 'webgl');
  const none = await plain.evaluate(() => t.pictures('lamps', 'none'));
  await plain.close();
  for (const [what, file, rule, instead] of mutants) {
    const mutated = await serve({ [`/js/three/${file}`]: (text) => {
      assert.equal(text.split(rule).length, 2, `${file} has no "${rule}", or several`);
      return text.replace(rule, instead);
    } });
    try {
      const page = await open(browser, mutated.url, 'webgl');
      const seen = await page.evaluate(() => t.pictures('lamps', { shadows: 'seen' }));
      if (digests(none).join() === digests(seen).join()) missed.push(what);
      await page.close();
    } finally { mutated.close(); }
  }
  assert.deepEqual(missed, []);
});

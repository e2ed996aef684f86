// The same picture, to the pixel, with culling and with none at all; and fewer draws.

import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { launch, open, serve } from './harness.mjs';

let server, browser;
before(async () => { server = await serve(); browser = await launch(); });
after(async () => { await browser?.close(); server?.close(); });

// CULLET_SCENES: some of them, by their names.
const names = process.env.CULLET_SCENES?.split(',') ?? ['city', 'meshes', 'nested', 'odd', 'shadows', 'instances', 'instancesInShadow', 'batch', 'batchInShadow', 'eyes', 'cascades', 'group', 'variance', 'addon', 'section', 'batchedTown'];

for (const api of ['webgl', 'webgpu']) {
  test(api, async (context) => {
    const page = await open(browser, server.url, api);
    for (const name of names) {
      await context.test(name, async () => {
        const [none, ours, occluded] = await page.evaluate(async (n) => [await t.pictures(n, 'none'), await t.pictures(n, {}), await t.pictures(n, { occlusion: true, preset: 'exact' })], name);
        const short = (list) => JSON.stringify(list.map((p) => [p.digest.slice(0, 6), p.calls, p.triangles]));
        if (process.env.VERBOSE) console.log(api, name, '\n', short(none), '\n', short(ours), '\n', short(occluded), JSON.stringify(ours.at(-1).stats));
        for (const [i, picture] of ours.entries()) {
          assert.equal(picture.digest, none[i].digest, `step ${i}: another picture`);
          assert.ok(none[i].colours > 50, `step ${i}: ${none[i].colours} colours are no picture`);
          assert.ok(picture.triangles < none[i].triangles, `step ${i}: ${picture.triangles} of ${none[i].triangles} triangles`);
          assert.ok(picture.calls <= none[i].calls, `step ${i}: ${picture.calls} draws, ${none[i].calls} without`);
        }
        for (const [i, picture] of occluded.entries()) {
          assert.equal(picture.digest, none[i].digest, `step ${i}: another picture with occlusion`);
          assert.ok(picture.triangles <= ours[i].triangles, `step ${i}: ${picture.triangles} triangles with occlusion, ${ours[i].triangles} without`);
        }
        if (name === 'batchedTown') for (const [i, picture] of occluded.entries()) if (i < 4) assert.ok(picture.triangles < ours[i].triangles * 0.7, `step ${i}: ${picture.triangles} triangles with occlusion, ${ours[i].triangles} without`);
        const sum = (what) => occluded.reduce((all, { stats }) => all + stats[what], 0);
        if (name === 'section') assert.ok(occluded.every(({ stats }) => stats.noOcclusion === null) && sum('hidden') > 100 && sum('clipped') > 200, `${sum('hidden')} hidden, ${sum('clipped')} clipped`);
        if (name === 'city') assert.ok(occluded[0].triangles < ours[0].triangles / 3, `${occluded[0].triangles} triangles with occlusion, ${ours[0].triangles} without`);
        // Each step is seen: a test of pictures that do not change would hold nothing.
        assert.ok(new Set(none.map((p) => p.digest)).size > none.length / 2, short(none));
      });
    }
    assert.deepEqual(page.errors, []);
    await page.close();
  });
}

// Each rule switched off, and a scene in which that shows.
const mutants = [
  ['batchedTown', 'occlusion.js', 'now & State.Shown ? objects[i].layers.mask >>> 0 : 0', 'objects[i].layers.mask >>> 0'],
  ['batchedTown', 'batch.js', "if (name !== 'setMatrixAt' && name !== 'setVisibleAt') this.revision += 1;", ''],
  ['batchedTown', 'occlusion.js', 'this.#instances[i] !== batch.matricesVersion', 'false'],
  ['section', 'occlusion.js', 'clip.cut(objects[i], box, 0, matrices, 16 * k) === Cut.Whole', 'true'],
];

test('a rule that is switched off is noticed', async () => {
  const missed = [];
  for (const [name, file, rule, instead] of mutants) {
    const mutated = await serve({ [`/js/three/${file}`]: (text) => {
      assert.equal(text.split(rule).length, 2, `${file} has no "${rule}", or several`);
      return text.replace(rule, instead);
    } });
    try {
      const page = await open(browser, mutated.url, 'webgl');
      const [none, occluded] = await page.evaluate(async (n) => [await t.pictures(n, 'none'), await t.pictures(n, { occlusion: true, preset: 'exact' })], name);
      if (none.every(({ digest }, i) => digest === occluded[i].digest)) missed.push(`${name} without "${rule}"`);
      await page.close();
    } finally { mutated.close(); }
  }
  assert.deepEqual(missed, []);
});

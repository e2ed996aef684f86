// A browser that cannot run the engine: three.js draws as without this package.

import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { launch, serve } from './harness.mjs';

let server, browser;
before(async () => { server = await serve(); browser = await launch(); });
after(async () => { await browser?.close(); server?.close(); });

const faults = {
  'without SIMD': ['WebAssembly.validate = () => false;', /no WebAssembly SIMD.*Safari from 16\.4.*three\.js goes on drawing/],
  'without WebAssembly': ['delete globalThis.WebAssembly;', /no WebAssembly.*three\.js goes on drawing/],
};

for (const [fault, [script, warning]] of Object.entries(faults)) {
  test(`${fault} the pictures are those of three.js, and a warning says why`, async () => {
    const page = await browser.newPage({ viewport: { width: 640, height: 420 } });
    const [warnings, errors] = [[], []];
    page.on('console', (m) => { if (m.type() === 'warning' && /cullet/.test(m.text())) warnings.push(m.text()); });
    page.on('pageerror', (e) => errors.push(String(e)));
    await page.addInitScript(script);
    await page.goto(`${server.url}/test/three/page.html`);
    await page.waitForSelector('body[data-state]', { state: 'attached', timeout: 60_000 });
    await page.evaluate(() => t.start('webgl'));
    for (const name of ['meshes', 'instances', 'shadows']) {
      const [plain, ours] = await page.evaluate(async (n) => [await t.pictures(n, 'three'), await t.pictures(n, { occlusion: true })], name);
      const drawn = (list) => list.map(({ digest, calls, triangles }) => ({ digest, calls, triangles }));
      assert.deepEqual(drawn(ours), drawn(plain), name);
      assert.ok(ours.every(({ stats }) => stats.passes === 0 && stats.objects === 0));
    }
    const seen = await page.evaluate(async () => {
      const { init } = await import('cullet/three');
      const culling = t.now.culling;
      culling.enabled = true;
      culling.update();
      culling.update(t.now.scene);
      culling.dispose();
      // Nothing was taken, so that another may be made.
      new t.Culling(t.now.scene).dispose();
      return { enabled: culling.enabled, again: await init() };
    });
    assert.deepEqual(seen, { enabled: false, again: false });
    assert.deepEqual(errors, []);
    assert.equal(warnings.length, 1, warnings.join('\n'));
    assert.match(warnings[0], warning);
    await page.close();
  });
}

// Pictures of tiles with the plugin are those without, to the pixel.

import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { launch, serve } from '../three/harness.mjs';

let server, browser, page;
const errors = [];
before(async () => {
  server = await serve();
  browser = await launch();
  page = await browser.newPage({ viewport: { width: 640, height: 420 } });
  page.on('pageerror', (e) => errors.push(String(e)));
  await page.goto(`${server.url}/test/tiles/page.html`);
  await page.waitForSelector('body[data-state]', { state: 'attached', timeout: 60000 });
});
after(async () => { await browser?.close(); server?.close(); });

for (const [name, ask] of [
  ['a walk in a street, tiles replace', () => pictures.street('REPLACE')],
  ['a walk in a street, tiles add', () => pictures.street('ADD')],
  ['a globe', () => pictures.globe(false)],
  ['a globe with horizon occlusion points', () => pictures.globe(true)],
]) {
  test(`not a pixel differs: ${name}`, async () => {
    const found = await page.evaluate(ask);
    found.forEach(({ different, colours, tiles: [off, on] }, k) => {
      assert.equal(different, 0, `picture ${k}`);
      assert.ok(colours > 4, `picture ${k} has ${colours} colours`);
      assert.ok(on < 0.6 * off, `picture ${k}: ${on} of ${off} tiles`);
    });
    assert.deepEqual(errors, []);
  });
}

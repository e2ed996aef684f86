// Pictures of tiles with the plugin are those without, to the pixel.

import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { launch, serve } from '../three/harness.mjs';

let server, browser, page;
const [errors, modules] = [[], []];

async function open(script) {
  const opened = await browser.newPage({ viewport: { width: 640, height: 420 } });
  opened.on('pageerror', (e) => errors.push(String(e)));
  opened.on('request', (request) => { if (request.url().endsWith('.wasm')) modules.push(request.url().split('/').at(-1)); });
  if (script) await opened.addInitScript(script);
  await opened.goto(`${server.url}/test/tiles/page.html`);
  await opened.waitForSelector('body[data-state]', { state: 'attached', timeout: 60000 });
  return opened;
}

before(async () => {
  server = await serve();
  browser = await launch();
  page = await open();
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

test('with `cullet/three` beside it, the page loads one module', async () => {
  modules.length = 0;
  const other = await open();
  assert.equal(await other.evaluate(() => import('cullet/three').then(({ init }) => init())), true);
  assert.deepEqual(modules, ['cullet-three.wasm']);
  await other.close();
});

test('without SIMD, the horizon alone hides', async () => {
  const other = await open('WebAssembly.validate = () => false;');
  const [street, globe] = await other.evaluate(async () => [await pictures.street('ADD'), await pictures.globe(false)]);
  for (const { different, tiles: [off, on] } of street) assert.deepEqual([different, on], [0, off]);
  assert.ok(globe.every(({ different, tiles: [off, on] }) => different === 0 && on < 0.6 * off));
  assert.deepEqual(errors, []);
  await other.close();
});

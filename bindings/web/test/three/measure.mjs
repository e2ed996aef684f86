// Figures, not a test: 1e5 meshes in a cube, a tenth of them in view, nothing drawn, so that a render() is its walk and its culling.
//
// node test/three/measure.mjs [webgl|webgpu] [city]

import { launch, open, serve } from './harness.mjs';

const args = process.argv.slice(2);
const apis = args.filter((a) => a.startsWith('web'));
const { url, close } = await serve();
const browser = await launch();
console.log('chromium', browser.version());
for (const api of apis.length ? apis : ['webgl', 'webgpu']) {
  const page = await open(browser, url, api);
  for (const kind of ['mesh', 'batched']) {
    const count = 100_000;
    const of = (how) => page.evaluate(async ([how, kind, count]) => (await import('./measure.js')).culling(how, kind, count), [how, kind, count]);
    const row = {};
    for (const how of ['none', 'three', 'watching', 'still']) row[how] = await of(how);
    if (kind === 'mesh') for (const how of ['three moving', 'moving']) row[how] = await of(how);
    // The same objects in view: a sphere leaves a few more or fewer than a box.
    const [a, b] = [row.three.visible, row.still.visible];
    if (!(b > 0.8 * a && b < 1.25 * a)) throw new Error(`${a} objects in view by three.js, ${b} by cullet`);
    for (const [how, { time, matrices, visible, build }] of Object.entries(row)) {
      console.log(`${api} ${kind} ${how}: render ${time.toFixed(2)} ms, of it world matrices ${matrices.toFixed(2)} ms; ${visible} in view${build ? `; set up in ${build.toFixed(0)} ms` : ''}`);
    }
    const ratio = (x, y) => (x / y).toFixed(1);
    console.log(`${api} ${kind}: three / still ${ratio(row.three.time, row.still.time)}, without world matrices ${ratio(row.three.time - row.three.matrices, row.still.time - row.still.matrices)}; three / watching ${ratio(row.three.time, row.watching.time)}`);
  }
  if (page.errors.length) console.log(page.errors);
  await page.close();
}
await browser.close();
close();

// Figures, not a test: 1e5 meshes in a cube, a tenth of them in view, nothing drawn, so that a render() is its walk and its culling.
//
// Then the city at street level, frames until all is drawn, each picture held against that without culling.
//
// node test/three/measure.mjs [webgl] [webgpu] [city|culling]

import { launch, open, serve } from './harness.mjs';

const args = process.argv.slice(2);
const apis = args.filter((a) => a.startsWith('web'));
const { url, close } = await serve();
const browser = await launch();
console.log('chromium', browser.version());
for (const api of apis.length ? apis : ['webgl', 'webgpu']) {
  const page = await open(browser, url, api);
  for (const kind of args.includes('city') ? [] : ['mesh', 'batched']) {
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
  if (!args.includes('culling')) {
    const rows = {};
    for (const how of ['three', 'frustum', 'occlusion']) {
      rows[how] = await page.evaluate(async (kind) => {
        t.build('city', 100_000);
        if (kind !== 'three') t.cull({ still: true, occlusion: kind === 'occlusion' });
        const { digest, triangles } = await t.picture();
        return { ...(await t.frames(kind === 'three' ? 5 : 9)), digest, triangles, stats: t.now.culling && { ...t.now.culling.stats } };
      }, how);
      if (rows[how].digest !== rows.three.digest) throw new Error(`${how} draws another picture`);
      const { cpu, frame, calls, triangles, stats } = rows[how];
      console.log(`${api} city ${how}: frame ${frame.toFixed(0)} ms, render() ${cpu.toFixed(1)} ms, ${calls} draws, ${triangles} triangles, ${stats ? stats.visibleInstances : 100_000} instances; ${(rows.three.frame / frame).toFixed(1)} times as fast`);
    }
  }
  if (page.errors.length) console.log(page.errors);
  await page.close();
}
await browser.close();
close();

// Figures, not a test: 1e5 meshes, and as many instances of a BatchedMesh, in a cube, a tenth of them in view, nothing drawn, so that
// a render() is its walk and its culling.
//
// Then the city at street level, frames until all is drawn, each picture held against that without culling. A software renderer's
// time goes with what it draws: on a GPU another share of it is saved.
//
// Then the city under a sun and eight lamps with shadows: all casters of what occlusion leaves to the camera, and those that are seen.
//
// Then a town and an office of a thousand meshes each, with what a draw was found to cost.
//
// node test/three/measure.mjs [webgl] [webgpu] [city|culling|lamps|thousand] [ROUNDS]

import { loadavg } from 'node:os';
import { launch, open, serve } from './harness.mjs';

const args = process.argv.slice(2);
const apis = args.filter((a) => a.startsWith('web'));
const rounds = Number(args.find((a) => /^\d+$/.test(a)) ?? 7);
const COUNT = 100_000;
const { url, close } = await serve();
const browser = await launch();

const sorted = (list) => [...list].sort((a, b) => a - b);
const median = (list) => sorted(list)[list.length >> 1];
const range = (list, digits = 1) => `${median(list).toFixed(digits)} (${Math.min(...list).toFixed(digits)} to ${Math.max(...list).toFixed(digits)})`;
// Of each round by itself, since the load of the machine changes between them.
const ratios = (a, b) => range(a.map((x, i) => x / b[i]));

async function culling(page, api) {
  for (const kind of ['meshes', 'batch']) {
    const { times, visible } = await page.evaluate(async ([kind, count, rounds]) => (await import('./measure.js'))[kind](count, rounds), [kind, COUNT, rounds]);
    // The same objects in view: a sphere leaves a few more or fewer than a box.
    for (const [how, seen] of Object.entries(visible)) if (!(seen > 0.8 * visible.three && seen < 1.25 * visible.three)) throw new Error(`${visible.three} objects in view by three.js, ${seen} ${how}`);
    for (const [how, list] of Object.entries(times)) {
      const beside = how.includes(',') ? times['three, a tenth moving'] : times.three;
      console.log(`${api} ${kind}, ${how}: ${range(list, 2)} ms${list === beside ? '' : `; three.js takes ${ratios(beside, list)} times as long`}`);
    }
    if (times.floor) console.log(`${api} ${kind}: still / floor ${ratios(times.still, times.floor)}`);
    console.log(`${api} ${kind}: in view ${JSON.stringify(visible)}`);
  }
}

// Some steps of each in turn, as often as there are rounds. Its first and its last picture are compared.
async function city(page, api) {
  const hows = ['three', 'frustum', 'occlusion'];
  const rows = Object.fromEntries(hows.map((how) => [how, { frame: [], cpu: [] }]));
  for (let r = 0; r < rounds; r++) {
    for (const how of hows) {
      const got = await page.evaluate(async ([how, count]) => {
        if (t.now?.name !== 'measured') { await t.build('city', count); t.now.name = 'measured'; }
        if (how !== 'three') t.cull({ still: true, occlusion: how === 'occlusion' });
        t.now.walk(0);
        const first = await t.picture();
        // A step on in each frame, for to see again from where one stands may cost nothing.
        const { cpu, frame, calls } = await t.frames(5, (i) => t.now.walk((i + 1) / 30));
        const last = await t.picture();
        const digest = `${first.digest} ${last.digest}`;
        const { triangles } = last;
        const stats = t.now.culling && { ...t.now.culling.stats };
        t.now.culling?.dispose();
        t.now.culling = null;
        return { cpu, frame, calls, digest, triangles, stats };
      }, [how, COUNT]);
      if (got.digest !== (rows.three.digest ?? got.digest)) throw new Error(`${how} draws another picture: ${got.digest}, not ${rows.three.digest}`);
      rows[how].frame.push(got.frame);
      rows[how].cpu.push(got.cpu);
      Object.assign(rows[how], { digest: got.digest, triangles: got.triangles, calls: got.calls, instances: got.stats?.visibleInstances ?? COUNT });
    }
  }
  for (const [how, { frame, cpu, calls, triangles, instances, digest }] of Object.entries(rows)) {
    console.log(`${api} city, ${how}: frame ${range(frame, 0)} ms, render() ${range(cpu)} ms, ${calls} draws, ${triangles} triangles, ${instances} instances, pictures ${digest}; ${ratios(rows.three.frame, frame)} times as fast as three.js`);
  }
}

// Draws and triangles of shadow passes: those of a frame without those of a second render, which draws no maps.
async function lamps(page, api) {
  const hows = ['all', 'seen'];
  const rows = Object.fromEntries(hows.map((how) => [how, { frame: [] }]));
  for (let r = 0; r < rounds; r++) {
    for (const how of hows) {
      const got = await page.evaluate(async ([how, count]) => {
        if (t.now?.name !== 'measured') { await t.build('litCity', count); t.now.name = 'measured'; }
        t.cull({ still: true, occlusion: true, shadows: how });
        t.now.walk(0);
        const whole = await t.picture();
        const kept = t.now.culling.stats.keptMaps;
        const { shadowMap, info } = t.renderer;
        if (t.renderer.isWebGLRenderer) { shadowMap.autoUpdate = false; t.renderer.render(t.now.scene, t.now.camera); }
        info.reset();
        t.renderer.render(t.now.scene, t.now.camera);
        const calls = whole.calls - (t.renderer.isWebGPURenderer ? info.render.drawCalls : info.render.calls);
        const triangles = whole.triangles - info.render.triangles;
        if (t.renderer.isWebGLRenderer) shadowMap.autoUpdate = true;
        const { frame } = await t.frames(3, (i) => t.now.walk((i + 1) / 30));
        const { digest } = await t.picture();
        t.now.culling.dispose();
        t.now.culling = null;
        return { frame, calls, triangles, kept, digest: `${whole.digest} ${digest}` };
      }, [how, 20_000]);
      if (got.digest !== (rows.all.digest ?? got.digest)) throw new Error(`${how} draws another picture: ${got.digest}, not ${rows.all.digest}`);
      rows[how].frame.push(got.frame);
      Object.assign(rows[how], { ...got, frame: rows[how].frame });
    }
  }
  for (const [how, { frame, calls, triangles, kept }] of Object.entries(rows)) {
    console.log(`${api} lamps, ${how}: frame ${range(frame, 0)} ms; shadow passes ${calls} draws, ${triangles} triangles, ${kept} maps kept; ${ratios(rows.all.frame, frame)} times as fast as all`);
  }
}

// A thousand meshes in a town and in an office, from where they start, once the cost of a draw is known.
async function thousand(page, api) {
  for (const name of ['town', 'office']) {
    const rows = { three: [], frustum: [], occlusion: [] };
    let counts;
    for (let r = 0; r < rounds; r++) {
      for (const how of Object.keys(rows)) {
        const { cpu, frame, stats } = await page.evaluate(async ([name, how]) => {
          await t.build(name);
          if (how !== 'three') t.cull({ still: true, occlusion: how === 'occlusion' });
          const { renderer, camera } = { renderer: t.renderer, camera: t.now.camera };
          for (let i = 0; i < 42; i++) { camera.position.x += i % 2 ? 1e-3 : -1e-3; await t.frame(); renderer.render(t.now.scene, camera); }
          // A step in each frame, since to see again from where one stands may cost nothing.
          const { cpu, frame } = await t.frames(9, (i) => { camera.position.x += i % 2 ? 1e-3 : -1e-3; });
          return { cpu, frame, stats: t.now.culling && { ...t.now.culling.stats } };
        }, [name, how]);
        rows[how].push({ cpu, frame });
        if (how === 'occlusion') counts = stats;
      }
    }
    for (const [how, list] of Object.entries(rows)) {
      const of = (what, of = list) => of.map((row) => row[what]);
      console.log(`${api} ${name}, ${how}: render() ${range(of('cpu'))} ms, frame ${range(of('frame'))} ms; ${ratios(of('cpu', rows.three), of('cpu'))} and ${ratios(of('frame', rows.three), of('frame'))} times as fast as three.js`);
    }
    console.log(`${api} ${name}: ${counts.visible} drawn and ${counts.hidden} hidden of ${counts.objects}, a draw counts ${counts.drawMicroseconds} µs, ${counts.drawMicrosecondsFrom}`);
  }
}

console.log(`chromium ${browser.version()}, ${rounds} rounds, median (least to greatest), load ${loadavg()[0].toFixed(1)}`);
for (const api of apis.length ? apis : ['webgl', 'webgpu']) {
  const page = await open(browser, url, api);
  const only = ['culling', 'city', 'lamps', 'thousand'].find((kind) => args.includes(kind));
  for (const [kind, run] of Object.entries({ culling, city, lamps, thousand })) if (kind === (only ?? kind)) await run(page, api);
  if (page.errors.length) throw new Error(page.errors.join('\n'));
  await page.close();
}
console.log(`load ${loadavg()[0].toFixed(1)}`);
await browser.close();
close();

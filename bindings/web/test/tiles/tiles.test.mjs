// Culling in 3d-tiles-renderer: what is loaded and drawn with and without the plugin, and that no picture lacks anything.

import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { mkdirSync, mkdtempSync, readFileSync, rmSync, symlinkSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { test } from 'node:test';
import { fileURLToPath } from 'node:url';
import { entry, folder, tools } from '../package.mjs';
import { camera, city, gate, globe, isBehind, passes, picture, start, three } from './world.mjs';

const { CullingPlugin, init } = await entry('tiles/index');
// The renderer warns of versions of tilesets that it does not know wholly.
console.warn = () => {};

test('a plugin before the engine is loaded says so', () => {
  const { tiles } = start(city({ side: 2 }), { camera: camera([0, 0, 2], [0, 9, 2]) });
  assert.throws(() => tiles.registerPlugin(new CullingPlugin()), /init\(\)/);
  // The horizon needs no engine.
  tiles.registerPlugin(new CullingPlugin({ occlusion: false }));
});

const both = async (world, { eye, target, slots, ...rest }, options, then = (run) => run.rest()) => {
  await init();
  const runs = [];
  for (const plugin of [null, new CullingPlugin(options)]) {
    const run = start(world, { camera: camera(eye, target, rest), plugin, slots });
    await then(run);
    runs.push({ ...run, plugin });
  }
  return runs;
};
const drawn = ({ tiles }) => [...tiles.visibleTiles].map((tile) => tile.content.uri).sort();
const missing = (one, other) => one.filter((hit, i) => hit && !other[i]).length;
const different = (one, other) => one.filter((hit, i) => hit !== other[i]).length;

for (const refine of ['REPLACE', 'ADD']) {
  test(`in a street, half of the bytes are loaded and two fifths of the tiles drawn, for the same picture, ${refine}`, async () => {
    const world = city({ refine });
    const s = world.street(8);
    const [off, on] = await both(world, { eye: [s, 5, 1.7], target: [s, 100, 1.7] });
    assert.deepEqual(picture(on), picture(off));
    assert.ok(on.log.bytes <= 0.5 * off.log.bytes, `${on.log.bytes} of ${off.log.bytes} bytes`);
    assert.ok(on.tiles.visibleTiles.size <= 0.4 * off.tiles.visibleTiles.size, `${on.tiles.visibleTiles.size} of ${off.tiles.visibleTiles.size} tiles`);
    assert.ok(drawn(on).every((uri) => drawn(off).includes(uri)));
    const { stats } = on.plugin;
    assert.ok(stats.hidden > 10 && stats.beyondHorizon === 0 && stats.tested > stats.hidden && stats.passes >= stats.updates, JSON.stringify(stats));
    console.log(`street, ${refine}: ${on.log.bytes} of ${off.log.bytes} bytes, ${on.tiles.visibleTiles.size} of ${off.tiles.visibleTiles.size} tiles`);
  });

  test(`on a walk nothing is missing in any frame, ${refine}`, async () => {
    const world = city({ refine });
    const s = world.street(8);
    const shown = [[], []];
    let number = 0;
    const [off, on] = await both(world, { eye: [s, 5, 1.7], target: [s, 100, 1.7] }, {}, async (run) => {
      const list = shown[number];
      number += 1;
      await run.rest();
      run.drawn = 0;
      for (let k = 0; k < 200; k++) {
        run.camera.position.y += 0.5;
        await run.step();
        run.drawn += run.tiles.visibleTiles.size;
        if (k % 10 === 0) list.push(picture(run));
      }
      await run.rest();
      list.push(picture(run));
    });
    shown[0].forEach((hits, k) => {
      assert.equal(missing(hits, shown[1][k]), 0, `picture ${k}`);
      // A tile may be a frame or two earlier or later in its fine form.
      assert.ok(different(hits, shown[1][k]) <= hits.length / 50, `picture ${k}: ${different(hits, shown[1][k])}`);
    });
    assert.deepEqual(shown[1].at(-1), shown[0].at(-1));
    assert.ok(on.log.bytes <= 0.6 * off.log.bytes, `${on.log.bytes} of ${off.log.bytes} bytes`);
    console.log(`walk, ${refine}: ${on.log.bytes} of ${off.log.bytes} bytes, ${on.plugin.stats.passes} passes in ${on.plugin.stats.updates} updates`);
  });
}

test('siblings outside of the camera are loaded as ever, so that it may turn', async () => {
  const world = city();
  const s = world.street(8);
  const shown = [[], []];
  let number = 0;
  const [off, on] = await both(world, { eye: [s, 300, 1.7], target: [s, 400, 1.7] }, {}, async (run) => {
    const list = shown[number];
    number += 1;
    await run.rest();
    for (let k = 0; k < 40; k++) {
      run.camera.rotateOnWorldAxis(new three.Vector3(0, 0, 1), 0.02);
      await run.step();
      if (k % 4 === 0) list.push(picture(run));
    }
  });
  const beside = (run) => { run.tiles.update(); return [...run.log.loaded].length - drawn(run).length; };
  assert.ok(beside(on) > 0 && beside(off) > 0);
  shown[0].forEach((hits, k) => {
    assert.equal(missing(hits, shown[1][k]), 0, `picture ${k}`);
    assert.ok(different(hits, shown[1][k]) <= hits.length / 50, `picture ${k}: ${different(hits, shown[1][k])}`);
  });
});

test('while it loads, no frame lacks more than without the plugin, and all is there sooner', async () => {
  const world = city();
  const s = world.street(8);
  const curves = [];
  await both(world, { eye: [s, 5, 1.7], target: [s, 100, 1.7] }, {}, async (run) => {
    const list = [];
    for (let k = 0; k < 80; k++) {
      await run.step();
      list.push(picture(run, 16, 10));
    }
    await run.rest();
    const last = picture(run, 16, 10);
    curves.push(list.map((hits) => ({ missing: missing(last, hits), different: hits.filter((hit, i) => last[i] && hit !== last[i]).length })));
  });
  const [off, on] = curves;
  off.forEach((frame, k) => {
    assert.ok(on[k].missing <= frame.missing, `frame ${k}: ${on[k].missing} instead of ${frame.missing} rays miss what is seen at last`);
    assert.ok(on[k].different <= frame.different, `frame ${k}: ${on[k].different} instead of ${frame.different} rays`);
  });
  const sum = (list) => list.reduce((all, { different: n }) => all + n, 0);
  assert.ok(sum(on) <= 0.6 * sum(off), `${sum(on)} of ${sum(off)}`);
  console.log(`loading: ${sum(on)} of ${sum(off)} rays in 80 frames show something else than at last`);
});

test('a camera that shows no volume hides nothing', async () => {
  const world = city({ side: 4 });
  const [, on] = await both(world, { eye: [100, 5, 1.7], target: [100, 100, 1.7] });
  on.camera.projectionMatrix.elements[5] = NaN;
  await on.step();
  on.camera.updateProjectionMatrix();
  await on.rest();
  assert.ok(on.tiles.visibleTiles.size > 0);
});

test('what comes in sight by a jump is there as soon as it is loaded', async () => {
  const world = city();
  const [s, t] = [world.street(8), world.street(4)];
  const [off, on] = await both(world, { eye: [s, 5, 1.7], target: [s, 100, 1.7] }, {}, async (run) => {
    await run.rest();
    run.camera.position.set(t, 300, 1.7);
    run.camera.lookAt(t + 100, 300, 1.7);
    await run.rest();
  });
  assert.deepEqual(picture(on), picture(off));
});

test('of a globe no tile behind the horizon is loaded or drawn', async () => {
  for (const height of [2e7, 4e5, 1e4, 500]) {
    const world = globe({ levels: 3 });
    const { radius: r } = world;
    const [off, on] = await both(world, { eye: [r + height, 0, 0], target: [r * 0.2, r * 0.9, 0], near: 10, far: 1e8 });
    const behind = ({ tiles, log }) => {
      const spheres = new Map();
      tiles.traverse((tile) => { if (tile.content) spheres.set(tile.content.uri, tile.boundingVolume.sphere); });
      return [[...log.loaded], drawn({ tiles })].map((list) => list.filter((uri) => isBehind(on.camera.position, r - 500.5, spheres.get(uri))).length);
    };
    assert.deepEqual(behind(on), [0, 0], `${height} m`);
    const [loaded, shown] = behind(off);
    assert.ok(loaded > 5 && shown > 5, `${height} m: the renderer alone loads ${loaded} and draws ${shown}`);
    assert.deepEqual(picture(on), picture(off), `${height} m`);
    console.log(`globe from ${height} m: ${on.log.loaded.size} of ${off.log.loaded.size} tiles loaded, ${on.tiles.visibleTiles.size} of ${off.tiles.visibleTiles.size} drawn`);
  }
});

test('horizons are those of globes alone, unless the page says otherwise', async () => {
  const eye = { eye: [6371000 + 1e4, 0, 0], target: [1e6, 6e6, 0], near: 10, far: 1e8 };
  const [, none] = await both(globe(), eye, { horizon: false });
  assert.equal(none.plugin.stats.beyondHorizon, 0);
  // From below the ground nothing is hidden.
  const [off, on] = await both(globe(), { ...eye, eye: [6371000 - 600, 0, 0] });
  assert.equal(on.plugin.stats.beyondHorizon, 0);
  assert.deepEqual(drawn(on), drawn(off));
});

const extension = (value) => ({ extensions: { '3DTILES_horizon_occlusion_point': { horizonOcclusionPoint: value } } });
const low = (r, height) => ({ eye: [r + height, 0, 0], target: [r * 0.2, r * 0.9, 0], near: 10, far: 1e8 });

test('horizon occlusion points hide more than spheres do, for the same picture', async () => {
  const radius = 6371000;
  for (const [height, lowest] of [[1e4, 0], [1e4, -500]]) {
    const mark = (tile, point) => Object.assign(tile, extension(point));
    const [, without] = await both(globe(), low(radius, height), { lowest });
    const [off, on] = await both(globe({ mark }), low(radius, height), { lowest });
    assert.deepEqual(picture(on), picture(off), `${height} m, ${lowest} m`);
    assert.ok(on.log.loaded.size < without.log.loaded.size, `${height} m, ${lowest} m: ${on.log.loaded.size} of ${without.log.loaded.size}`);
    assert.ok(drawn(on).length <= drawn(without).length);
    assert.ok([...on.log.loaded].every((uri) => without.log.loaded.has(uri)));
    console.log(`points from ${height} m, lowest ${lowest} m: ${on.log.loaded.size} loaded and ${drawn(on).length} drawn, of ${without.log.loaded.size} and ${drawn(without).length} by spheres alone`);
  }
});

test('over ground below the ellipsoid tiles are seen past points that were made without it', async () => {
  // An eye 150 m above the ellipsoid sees 7.7 km far over it. Over ground 450 m below it, that is 15.5 km, and the near edge of a tile on
  // that ground shows if the tile's middle is 27.3 km away. Past a valley of 499 m the eye sees 16 km far, and on to a tile on the ellipsoid
  // 14 km beyond.
  const [radius, height, width] = [2e5, 150, Math.PI / 24];
  for (const [ground, valley, away] of [[-450, -450, 27300], [0, -499, 40000]]) {
    const mark = (tile, point) => Object.assign(tile, extension(point));
    const world = globe({ radius, ground, bands: 24, levels: 1, mark });
    const place = (longitude, up) => [Math.cos(longitude) * Math.cos(width / 2), Math.sin(longitude) * Math.cos(width / 2), Math.sin(width / 2)].map((c) => c * (radius + up));
    const eye = place(width / 2 - away / radius, height);
    const view = { eye, target: place(width / 2, 0), near: 1, far: 1e6, up: eye };
    const [off, on] = await both(world, view, { occlusion: false });
    const seen = drawn(off).filter((uri) => world.points.get(uri).some((p) => passes(eye, radius + valley - 0.01, p)));
    assert.ok(seen.length > 0, `${ground} m`);
    assert.deepEqual(seen.filter((uri) => !drawn(on).includes(uri)), [], `${ground} m`);
    assert.ok(on.plugin.stats.beyondHorizon > 10, `${ground} m`);
    // A page that says that there is no such ground gets what it says.
    const [, wrong] = await both(world, view, { occlusion: false, lowest: 0 });
    assert.ok(seen.some((uri) => !drawn(wrong).includes(uri)), `${ground} m`);
  }
});

test('the point of a content stands for tiles without others below', async () => {
  const radius = 6371000;
  const behind = [-1.5, 0, 0];
  const leaves = globe({ mark: (tile, point, isLeaf) => { if (isLeaf) Object.assign(tile.content, extension(behind)); } });
  const [off, on] = await both(leaves, low(radius, 1e4));
  assert.ok(drawn(off).length > 5);
  assert.ok(drawn(on).every((uri) => !uri.startsWith('g3-')), 'what its file says to be hidden is');
  const inner = () => globe({ mark: (tile, point, isLeaf) => { if (!isLeaf) Object.assign(tile.content, extension(behind)); } });
  const [, plain] = await both(globe(), low(radius, 1e4));
  const [, kept] = await both(inner(), low(radius, 1e4));
  assert.deepEqual(drawn(kept), drawn(plain));
});

test('what is no horizon occlusion point is passed over', async () => {
  const radius = 6371000;
  const [, plain] = await both(globe(), low(radius, 1e4));
  const odd = [undefined, null, 'NaN', ['NaN', 'NaN', 'NaN'], ['-1.5', 0, 0], [-1.5, 0], [-1.5, 0, 0, 0], [NaN, 0, 0], [-Infinity, 0, 0], [0, 0, 0], [-0.9, 0, 0], [-1e300, 0, 0], { x: -1.5 }, 7];
  let k = 0;
  const mark = (tile) => { Object.assign(tile, extension(odd[k % odd.length])); Object.assign(tile.content, extension(odd[(k + 1) % odd.length])); k += 1; };
  const [, on] = await both(globe({ mark }), low(radius, 1e4));
  assert.deepEqual(drawn(on), drawn(plain));
  const other = globe({ mark: (tile) => { tile.extensions = k % 2 ? 'no' : { '3DTILES_horizon_occlusion_point': 3 }; k += 1; } });
  const [, also] = await both(other, low(radius, 1e4));
  assert.deepEqual(drawn(also), drawn(plain));
});

test('points are those of globes alone, and hide only what they hide from all cameras', async () => {
  const radius = 6371000;
  const mark = (tile) => Object.assign(tile, extension([-1.5, 0, 0]));
  const [off, none] = await both(globe({ mark }), low(radius, 1e4), { horizon: false, occlusion: false });
  assert.deepEqual(drawn(none), drawn(off));
  const [, all] = await both(globe({ mark }), low(radius, 1e4));
  assert.deepEqual(drawn(all), []);
  // A camera on the other side has the point before it.
  const other = camera([-radius - 1e6, 0, 0], [0, 0, 0], { near: 10, far: 1e8 });
  all.tiles.setCamera(other);
  all.tiles.setResolution(other, 640, 400);
  await all.rest();
  assert.ok(drawn(all).length > 5);
});

test('what a fine form shows of what its coarse one hid is sent for in the same frame', async () => {
  const world = gate();
  const frames = [];
  let requested = -1;
  const [off, on] = await both(world, { eye: [0, 0, 1.7], target: [0, 60, 3], slots: 1 }, {}, async (run) => {
    frames.length = 0;
    for (let k = 0; k < 60; k++) {
      await run.step();
      frames.push(drawn(run).join(' '));
      if (!run.log.loaded.has('tower.bin')) requested = k + 1;
    }
    await run.rest();
  });
  // The coarse wall hides both. In the frame in which its fine form shows the tower, that is sent for.
  assert.deepEqual(frames.filter((f, k) => f !== frames[k - 1]), ['', 'wall.bin', 'left.bin right.bin', 'left.bin right.bin tower.bin']);
  assert.equal(requested, frames.indexOf('left.bin right.bin'));
  assert.deepEqual(drawn(on), ['left.bin', 'right.bin', 'tower.bin']);
  assert.deepEqual(drawn(off), ['behind.bin', 'left.bin', 'right.bin', 'tower.bin']);
  assert.ok(!on.log.loaded.has('behind.bin'));
  assert.deepEqual(picture(on), picture(off));
  assert.ok(on.plugin.stats.passes > on.plugin.stats.updates, 'an update was repeated');
});

test('far from the origin it is the same', async () => {
  const near = city();
  const s = near.street(8);
  const far = [6.3e6, -2.1e6, 4.4e6];
  const moved = city({ transform: [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, ...far, 1] });
  const at = (p) => p.map((c, a) => c + far[a]);
  const [, here] = await both(near, { eye: [s, 5, 1.7], target: [s, 100, 1.7] });
  const [, there] = await both(moved, { eye: at([s, 5, 1.7]), target: at([s, 100, 1.7]) });
  assert.deepEqual(drawn(there), drawn(here));
  assert.deepEqual([...there.log.loaded].sort(), [...here.log.loaded].sort());
});

test('what is not known to be opaque hides nothing', async () => {
  const { MeshBasicMaterial, MeshStandardMaterial } = three;
  const seen = async (material, options) => {
    const world = city({ side: 8, material });
    const s = world.street(4);
    const [off, on] = await both(world, { eye: [s, 5, 1.7], target: [s, 100, 1.7] }, options);
    return on.tiles.visibleTiles.size < off.tiles.visibleTiles.size;
  };
  assert.ok(await seen(new MeshStandardMaterial()));
  assert.ok(!await seen(new MeshBasicMaterial({ transparent: true })));
  assert.ok(!await seen(new MeshBasicMaterial({ alphaTest: 0.5 })));
  assert.ok(!await seen(new MeshBasicMaterial({ wireframe: true })));
  assert.ok(!await seen(Object.assign(new MeshBasicMaterial(), { onBeforeCompile() {} })));
  assert.ok(!await seen(new MeshBasicMaterial(), { occludes: () => false }));
  assert.ok(!await seen(new MeshBasicMaterial(), { occlusion: false }));
});

test('a tile is left out only if no camera sees it', async () => {
  await init();
  const world = city({ side: 8 });
  const s = world.street(4);
  const alone = start(world, { camera: camera([s, 5, 1.7], [s, 100, 1.7]), plugin: new CullingPlugin() });
  await alone.rest();
  const run = start(world, { camera: camera([s, 5, 1.7], [s, 100, 1.7]), plugin: new CullingPlugin() });
  const above = camera([s, 5, 300], [s, 100, 1.7]);
  const off = start(world, { camera: camera([s, 5, 1.7], [s, 100, 1.7]) });
  for (const { tiles, rest } of [run, off]) {
    tiles.setCamera(above);
    tiles.setResolution(above, 640, 400);
    await rest();
  }
  assert.ok(run.tiles.visibleTiles.size > alone.tiles.visibleTiles.size);
  for (const seen of [above, run.camera]) assert.deepEqual(picture({ ...run, camera: seen }), picture({ ...off, camera: seen }));
});

test('unregistered, it leaves the renderer as it was', async () => {
  const world = city({ side: 8 });
  const s = world.street(4);
  const [off, on] = await both(world, { eye: [s, 5, 1.7], target: [s, 100, 1.7] });
  assert.ok(on.tiles.visibleTiles.size < off.tiles.visibleTiles.size);
  assert.ok(on.tiles.unregisterPlugin(on.plugin));
  await on.rest();
  assert.deepEqual(drawn(on), drawn(off));
});

test('registered late, it culls all the same', async () => {
  await init();
  const world = city({ side: 8 });
  const s = world.street(4);
  const run = start(world, { camera: camera([s, 5, 1.7], [s, 100, 1.7]) });
  await run.rest();
  const before = run.tiles.visibleTiles.size;
  run.tiles.registerPlugin(new CullingPlugin());
  await run.rest();
  assert.ok(run.tiles.visibleTiles.size < before);
});

test('unloaded and loaded again, tiles hide as before', async () => {
  const world = city({ side: 8 });
  const s = world.street(4);
  const [, on] = await both(world, { eye: [s, 5, 1.7], target: [s, 100, 1.7] });
  const first = drawn(on);
  for (let round = 0; round < 3; round++) {
    for (const tile of [...on.tiles.lruCache.itemList]) on.tiles.lruCache.remove(tile);
    await on.rest();
    assert.deepEqual(drawn(on), first, `round ${round}`);
  }
});

test('mistakes are told', () => {
  assert.throws(() => new CullingPlugin({ lowest: NaN }), /lowest is NaN/);
  assert.throws(() => new CullingPlugin({ ahead: -1 }), /ahead is -1/);
});

test('tsc --strict takes the declarations, and refuses what it should', () => {
  const project = mkdtempSync(join(tmpdir(), 'cullet-tiles-'));
  try {
    const modules = join(tools(), 'node_modules');
    mkdirSync(join(project, 'node_modules'));
    for (const name of ['three', '@types', 'typescript']) symlinkSync(join(modules, name), join(project, 'node_modules', name));
    symlinkSync(folder, join(project, 'node_modules/cullet'));
    writeFileSync(join(project, 'package.json'), '{ "type": "module" }');
    writeFileSync(join(project, 'use.ts'), readFileSync(fileURLToPath(new URL('use.ts', import.meta.url))));
    const words = ['--noEmit', '--strict', '--target', 'es2022', '--lib', 'es2022,dom,dom.iterable', '--preserveSymlinks', '--types', '', '--module', 'nodenext'];
    try {
      execFileSync(process.execPath, [join(modules, 'typescript/bin/tsc'), ...words, 'use.ts'], { cwd: project, encoding: 'utf8', stdio: 'pipe' });
    } catch (error) { assert.fail(error.stdout || error.message); }
  } finally { rmSync(project, { recursive: true, force: true }); }
});

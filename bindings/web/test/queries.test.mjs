// Queries of scenes, and lights of views. Answers are those of the engine, which tests/queries.rs wrote to queries.txt.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { test } from 'node:test';
import { at, box, entry, perspective } from './package.mjs';

const { CulletError, init, LIGHT_REASONS, NONE, Scene, View } = await entry('queries');
await init();

const INSTANCES = 300;
const MATRIX = [1.5, 0, 0, 0, 0, 2, 0, 0, 0, 0, -1.001, -1, 0, -4, 49.9, 50];

/** The scene of tests/queries.rs, by the same numbers, which go on. */
const shared = () => {
  let seed = 7;
  const next = (n) => Math.floor((seed = (Math.imul(seed, 1664525) + 1013904223) >>> 0) * n / 2 ** 32);
  const point = () => [next(81) - 40.3, next(9) + 0.7, next(81) - 40.1];
  const scene = new Scene();
  const { positions, indices } = box(1, 1, 1);
  for (const kind of [{}, { twoSided: false }, { alpha: 'masked' }]) scene.addMesh(positions, indices, kind);
  for (let i = 0; i < INSTANCES; i++) {
    const mesh = [0, 0, 0, 0, 0, 1, 1, 2][next(8)];
    const place = [next(81) - 40, next(5), next(81) - 40];
    const [a, b, c] = [next(5) + 1, next(4) + 2, next(5) + 1];
    assert.equal(scene.add(mesh, [a, 0, 0, 0, 0, b, 0, 0, 0, 0, c, 0, ...place, 1]), i);
  }
  scene.commit();
  return { scene, next, point };
};
const theirs = readFileSync(new URL('queries.txt', import.meta.url), 'utf8').trimEnd().split('\n').map((line) => {
  const [name, ...numbers] = line.split(' ');
  return [name, numbers.map(Number)];
});

test('every answer is that of the native engine, bit for bit', () => {
  const { scene, next, point } = shared();
  const ours = [];
  const line = (name, numbers) => ours.push([name, [...numbers]]);
  const many = [];
  for (let i = 0; i < 200; i++) {
    const [from, to] = [point(), point()];
    const by = scene.lineOfSight(from, to, { bothSides: i % 4 === 1, any: i % 4 === 2, ignore: i % 4 === 3 ? [i, i + 1] : [] });
    line('line', by ? [by.id, by.triangle, by.share, ...by.point] : []);
    if (i % 4 === 0) many.push({ lines: [...from, ...to], id: by?.id ?? NONE });
  }
  assert.deepEqual([...scene.linesOfSight(many.flatMap(({ lines }) => lines))], many.map(({ id }) => id));
  const pairs = [];
  for (let i = 0; i < 200; i++) {
    const boxes = [point(), point()].map((m) => [-0.3, 0.3].flatMap((by) => m.map((v) => v + by)));
    const { sight, by } = scene.boxToBox(...boxes, { splits: i % 3, motion: i % 2 === 0 ? 0 : [0.25, 0.5] });
    line('box', [['visible', 'hidden', 'empty'].indexOf(sight), by ?? NONE]);
    if (i % 6 === 0) pairs.push({ boxes: boxes.flat(), state: ours.at(-1)[1][0] });
  }
  assert.deepEqual([...scene.boxesToBoxes(pairs.flatMap(({ boxes }) => boxes))], pairs.map(({ state }) => state));
  const region = { cellWorld: 1, width: 128 };
  const view = scene.view({ preset: 'exact' }).setCamera(MATRIX, 640, 400);
  for (let i = 0; i < 4; i++) {
    const [x, y, z] = point();
    line('region', scene.visibleFrom([x, y, z, x + 2, y + 0.5, z + 1], i === 3 ? { ...region, view } : region));
  }
  const needed = scene.neededAlong([point(), point(), point()].flat(), { ...region, radiusWorld: 0.5, reachWorld: 30 });
  line('needed', needed.ids);
  line('distances', needed.distances);
  line('among', view.cullAmong(Array.from({ length: INSTANCES }, (_, id) => id).filter((id) => id % 3 !== 0)));
  line('visible', view.cull());
  const lights = [{ kind: 'directional', direction: [0.3, -1, 0.2] }];
  for (let i = 0; i < 40; i++) {
    const [position, range] = [point(), next(4) * 3];
    lights.push(i % 2 === 0 ? { kind: 'point', position, range } : { kind: 'spot', position, direction: [0.5, -1, 0.25], halfAngleRadians: 0.5, range });
  }
  for (const anywhere of [false, true]) {
    const { kept, reasons, receivers, funnel } = view.lights(lights, { anywhere, casters: true });
    assert.deepEqual([...kept], lights.map((_, i) => i).filter((i) => LIGHT_REASONS[reasons[i]] === 'kept'));
    assert.deepEqual([funnel[0].entered, funnel.at(-1).left], [lights.length, kept.length]);
    line('reasons', reasons);
    const boxes = [...receivers];
    for (let i = 0; i < lights.length && i < boxes.length / 6; i++) line('casters', view.casters(i));
    for (let i = 0; i < boxes.length; i += 6) {
      if (anywhere) assert.deepEqual(boxes.slice(i, i + 6), [-Infinity, -Infinity, -Infinity, Infinity, Infinity, Infinity]);
      else line('receivers', boxes.slice(i, i + 6));
    }
  }
  assert.equal(ours.length, theirs.length);
  ours.forEach(([name, numbers], i) => {
    const [other, expected] = theirs[i];
    assert.equal(name, other, `line ${i + 1}`);
    // Receivers are rounded outward once more: to the next f64.
    if (name === 'receivers') numbers.forEach((v, k) => assert.equal(Math.fround(v), expected[k], `line ${i + 1}`));
    else assert.deepEqual(numbers, expected, `line ${i + 1}: ${name}`);
  });
  // Answers of every kind are among them.
  const of = (name) => ours.filter((row) => row[0] === name).map((row) => row[1]);
  assert.ok(of('line').some((n) => n.length === 0) && of('line').some((n) => n.length > 0));
  assert.deepEqual(new Set(of('box').map(([state]) => state)), new Set([0, 1]));
  assert.ok(of('region').every((n) => n.length > 0 && n.length < INSTANCES), String(of('region').map((n) => n.length)));
  assert.ok(new Set(of('reasons').flat()).size >= 4, String(of('reasons')));
  scene.dispose();
});

/** A wall at z = −10, and something behind it. */
const walled = () => {
  const scene = new Scene();
  const wall = box(5, 5, 0.5);
  const small = box(0.5, 0.5, 0.5);
  const wallId = scene.add(scene.addMesh(wall.positions, wall.indices), at(0, 0, -10));
  const id = scene.add(scene.addMesh(small.positions, small.indices), at(0, 0, -20));
  scene.commit();
  return { scene, wallId, id };
};
const around = (x, y, z, r) => [x - r, y - r, z - r, x + r, y + r, z + r];

test('a motion makes a proof harder: what stays hidden stays so wherever both go', () => {
  const { scene, wallId } = walled();
  const [eye, thing] = [around(0, 0, 0, 0.1), around(0, 0, -20, 0.5)];
  assert.deepEqual(scene.boxToBox(eye, thing), { sight: 'hidden', by: wallId });
  assert.equal(scene.boxToBox(eye, thing, { motion: 1 }).sight, 'hidden');
  assert.equal(scene.boxToBox(eye, thing, { motion: [8, 0] }).sight, 'visible', 'the eye comes round the wall');
  assert.equal(scene.boxToBox(eye, thing, { motion: [0, 8] }).sight, 'visible', 'the thing comes round it');
  assert.equal(scene.boxToBox(eye, thing, { motion: Infinity }).sight, 'visible');
  assert.deepEqual(scene.boxToBox([1, 0, 0, 0, 0, 0], thing, { motion: 9 }), { sight: 'empty', by: null });
  assert.equal(scene.boxToBox([NaN, 0, 0, 0, 0, 0], thing).sight, 'visible');
  // The motion and the boxes that it makes are one.
  for (let i = 0; i < 40; i++) {
    const m = i * 0.25;
    const given = scene.boxToBox(eye, thing, { motion: m }).sight;
    assert.equal(given, scene.boxToBox(around(0, 0, 0, 0.1 + m), around(0, 0, -20, 0.5 + m)).sight, `motion ${m}`);
  }
  scene.dispose();
});

test('layers and ignored instances do not block', () => {
  const { scene, wallId, id } = walled();
  const [from, to] = [[0, 0, 0], [0, 0, -30]];
  assert.equal(scene.lineOfSight(from, to).id, wallId);
  assert.deepEqual(scene.lineOfSight(from, to, { ignore: wallId }).id, id);
  assert.equal(scene.lineOfSight(from, to, { ignore: [id, wallId] }), null);
  assert.equal(scene.lineOfSight(from, to, { ignore: Uint32Array.of(wallId, id) }), null);
  assert.equal(scene.lineOfSight(from, to, { layers: 2 }), null);
  scene.setState(id, { layers: 2 });
  assert.deepEqual(scene.lineOfSight(from, to, { layers: 2 }).point, [0, 0, -19.5]);
  const [eye, thing] = [around(0, 0, 0, 0.1), around(0, 0, -30, 0.1)];
  assert.equal(scene.boxToBox(eye, thing, { layers: 1 }).by, wallId);
  assert.equal(scene.boxToBox(eye, thing, { layers: 4 }).sight, 'visible');
  assert.deepEqual([...scene.visibleFrom(eye, { cellWorld: 0.4, layers: 2 })], [id]);
  scene.dispose();
});

test('regions, motions and candidates of a small scene', () => {
  const { scene, wallId, id } = walled();
  assert.deepEqual([...scene.visibleFrom(around(0, 0, 0, 0.2), { cellWorld: 0.4 })], [wallId]);
  assert.deepEqual([...scene.visibleFrom(around(0, 0, 0, 9), { cellWorld: 0.4 })], [wallId, id]);
  assert.deepEqual([...scene.visibleFrom([1, 0, 0, 0, 0, 0])], []);
  const { ids, distances } = scene.neededAlong([0, 0, 0, 30, 0, 0], { cellWorld: 0.4, stepWorld: 1 });
  assert.deepEqual([...ids], [wallId, id]);
  assert.equal(distances[0], 0);
  assert.ok(distances[1] > 3 && distances[1] < 11, String(distances));
  const view = scene.view({ preset: 'exact', reasons: true }).setCamera(perspective(1, 1.6, 0.1, 500), 640, 400);
  assert.ok(view instanceof View);
  assert.deepEqual([...view.cullAmong([id])], [id], 'the wall is no candidate, and hides nothing');
  assert.equal(view.funnel().find((row) => row.stage === 'pvs').left.instances, 1);
  assert.deepEqual([...view.cull()], [wallId]);
  scene.setTransform(id, at(0, 0, 20));
  scene.refit();
  assert.equal(scene.lineOfSight([0, 0, 0], [0, 0, 30]).id, id, 'queries see what moved');
  scene.dispose();
});

test('lights are of the picture that was culled', () => {
  const { scene, id } = walled();
  const clip = perspective(1, 1.6, 0.1, 500);
  const view = scene.view({ preset: 'exact' });
  const lamp = (x, y, z, range = 3) => ({ kind: 'point', position: [x, y, z], range });
  const lights = [lamp(0, 0, -8), lamp(0, 0, -25), lamp(0, 0, 30), lamp(0, 0, -8, 0)];
  const wrong = (call, code, message) => assert.throws(call, (e) => e instanceof CulletError && e.code === code && message.test(e.message));
  wrong(() => view.lights(lights), 'camera', /setCamera/);
  view.setCamera(clip, 640, 400);
  wrong(() => view.lights(lights), 'argument', /cull first/);
  view.cull();
  const { kept, reasons } = view.lights(lights, { casters: true });
  assert.deepEqual([...kept], [0]);
  assert.equal(LIGHT_REASONS[reasons[2]], 'frustum');
  assert.equal(LIGHT_REASONS[reasons[3]], 'unlit');
  assert.ok(['occlusion', 'no-receiver'].includes(LIGHT_REASONS[reasons[1]]));
  assert.ok(!view.casters(0).includes(id));
  assert.deepEqual([...view.casters(7)], []);
  assert.deepEqual([...view.lights(lights, { anywhere: true }).kept], [0, 1]);
  view.setCamera(clip, 320, 200);
  wrong(() => view.lights(lights), 'argument', /camera has changed.*cull first/);
  view.cull();
  view.lights(lights, { casters: true });
  scene.remove(id);
  wrong(() => view.lights(lights), 'argument', /cull first/);
  wrong(() => view.casters(0), 'argument', /scene has changed/);
  scene.dispose();
});

test('mistakes in queries are errors that name the value and the limit', () => {
  const { scene, id } = walled();
  const view = scene.view();
  const eyes = around(0, 0, 0, 1);
  const wrong = [
    [() => scene.lineOfSight([0, 0], [0, 0, 1]), 'argument', /from has 2.*3/],
    [() => scene.linesOfSight([0, 0, 0]), 'argument', /3 numbers.*6/],
    [() => scene.lineOfSight([0, 0, 0], [0, 0, 1], { ignore: 99 }), 'id', /99/],
    [() => scene.lineOfSight([0, 0, 0], [0, 0, 1], { ignore: [0, 0, 0] }), 'argument', /3 ids.*2/],
    [() => scene.lineOfSight([0, 0, 0], [0, 0, 1], { nearest: true }), 'argument', /no nearest/],
    [() => scene.boxToBox(eyes, [1]), 'argument', /to has 1.*6/],
    [() => scene.boxesToBoxes(eyes), 'argument', /6 numbers.*12/],
    [() => scene.boxToBox(eyes, eyes, { splits: 17 }), 'argument', /17.*0 to 16/],
    [() => scene.boxToBox(eyes, eyes, { motion: -1 }), 'argument', /motion is -1.*at least 0/],
    [() => scene.boxToBox(eyes, eyes, { motion: [1] }), 'argument', /motion has 1.*2/],
    [() => scene.visibleFrom(eyes, { cellWorld: 0 }), 'argument', /cellWorld is 0.*above 0/],
    [() => scene.visibleFrom(eyes, { width: 7 }), 'argument', /width is 7.*8 to 4096/],
    [() => scene.visibleFrom(eyes, { nearWorld: -1 }), 'argument', /nearWorld is -1.*from 0/],
    [() => scene.visibleFrom(eyes, { view: {} }), 'argument', /scene\.view/],
    [() => scene.visibleFrom(eyes, { view }), 'camera', /setCamera/],
    [() => scene.visibleFrom(eyes, { view: scene.view().setCamera([1, 0, 0, 0, 0, 1, 0, 0, 0, 0, -0.01, 0, 0, 0, 0, 1], 64, 64) }), 'camera', /orthographic/],
    [() => scene.neededAlong([0, 0]), 'argument', /2 numbers.*3/],
    [() => scene.neededAlong([0, 0, 0], { stepWorld: 0 }), 'argument', /stepWorld is 0/],
    [() => scene.neededAlong([0, 0, 0], { radiusWorld: -1 }), 'argument', /radiusWorld is -1/],
    [() => view.cullAmong([id]), 'camera', /setCamera/],
    [() => scene.view().setCamera(MATRIX, 64, 64).cullAmong([99]), 'id', /99/],
    [() => view.lights({}), 'argument', /array/],
    [() => view.lights([{ kind: 'lamp' }]), 'argument', /"lamp".*directional, point, spot/],
    [() => view.lights([{ kind: 'point', position: [0] }]), 'argument', /position of light 0 has 1.*3/],
  ];
  for (const [call, code, message] of wrong) {
    assert.throws(call, (error) => error instanceof CulletError && error.code === code && message.test(error.message), String(call));
  }
  assert.equal(scene.lineOfSight([NaN, 0, 0], [0, 0, -20]), null, 'what is not known does not block');
  scene.dispose();
  for (const call of [() => scene.lineOfSight([0, 0, 0], [0, 0, 1]), () => scene.visibleFrom(eyes), () => view.cullAmong([])]) assert.throws(call, (e) => e.code === 'disposed');
});

test('queries allocate nothing once their memory has grown', () => {
  const { scene } = shared();
  const view = scene.view().setCamera(MATRIX, 640, 400);
  const lines = Array.from({ length: 600 }, (_, i) => (i * 37) % 61 - 30);
  const turn = (i) => {
    scene.linesOfSight(lines);
    scene.boxesToBoxes(lines, { motion: 0.1 });
    scene.visibleFrom(around(i % 7, 3, 0, 0.5), { width: 64 });
    view.cull();
    view.lights([{ kind: 'point', position: [0, 4, i % 5], range: 20 }], { casters: true });
  };
  for (let i = 0; i < 60; i++) turn(i);
  const { buffer } = view.cull();
  for (let i = 0; i < 300; i++) turn(i);
  assert.equal(view.cull().buffer, buffer, 'the memory did not grow');
  scene.dispose();
});

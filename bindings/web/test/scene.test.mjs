import assert from 'node:assert/strict';
import { test } from 'node:test';
import { at, box, entry, perspective } from './package.mjs';

const { BoxSet, CulletError, init, Scene, STAGES } = await entry('index');
await init();

const clip = perspective(1, 1.6, 0.1, 500);
/** A wall, and a row of boxes of which those behind it are hidden. */
const walled = () => {
  const scene = new Scene();
  const wall = box(20, 20, 0.5);
  const small = box(0.5, 0.5, 0.5);
  const wallId = scene.add(scene.addMesh(wall.positions, wall.indices, { twoSided: false }), at(0, 0, -20));
  const mesh = scene.addMesh(small.positions, small.indices);
  const places = [[0, 0, -10], [0, 0, -40], [2, 0, -60], [0, 0, 40], [300, 0, -20]];
  const ids = scene.addMany(mesh, Float32Array.from(places.flatMap((p) => at(...p))));
  scene.commit();
  return { scene, wallId, ids: [...ids] };
};

test('what is outside or hidden goes, with its reason and what hides it', () => {
  const { scene, wallId, ids } = walled();
  const view = scene.view({ preset: 'exact', reasons: true }).setCamera(clip, 640, 400);
  assert.deepEqual([...scene.cull(view)], [wallId, ids[0]]);
  const reasons = view.reasons();
  assert.deepEqual(ids.map((id) => STAGES[reasons[id]]), ['visible', 'occlusion', 'occlusion', 'frustum', 'frustum']);
  const hidden = view.explain(ids[1]);
  assert.equal(hidden.reason.stage, 'occlusion');
  assert.ok(hidden.hiddenBy.includes(wallId));
  assert.equal(view.explain(ids[0]).reason, null);
  assert.ok(hidden.steps.every((step) => step.finding.length > 0 && Number.isInteger(step.left)));
  const funnel = view.funnel();
  assert.equal(funnel[0].entered.instances, 6);
  const last = funnel.at(-1).left;
  assert.deepEqual([last.instances, last.triangles], [2, view.triangleCount]);
  for (let i = 1; i < funnel.length; i++) assert.deepEqual(funnel[i].entered, funnel[i - 1].left);
  const open = scene.view({ occlusion: false }).setCamera(clip, 640, 400);
  assert.deepEqual([...open.cull()], [wallId, ids[0], ids[1], ids[2]]);
  scene.dispose();
});

test('depth of WebGL, standard and reversed show the same', () => {
  const { scene } = walled();
  const webgl = [...clip];
  // z' = 2 z - w.
  for (let c = 0; c < 4; c++) webgl[4 * c + 2] = 2 * clip[4 * c + 2] - clip[4 * c + 3];
  const reversed = [...clip];
  for (let c = 0; c < 4; c++) reversed[4 * c + 2] = clip[4 * c + 3] - clip[4 * c + 2];
  const of = (depth, matrix) => [...scene.view({ depth }).setCamera(matrix, 640, 400).cull()];
  assert.deepEqual(of('webgl', webgl), of('standard', clip));
  assert.deepEqual(of('reversed', reversed), of('standard', clip));
  scene.dispose();
});

test('instances move, change their layers and go', () => {
  const { scene, wallId, ids } = walled();
  const view = scene.view({ preset: 'exact' }).setCamera(clip, 640, 400);
  view.cull();
  scene.setTransform(ids[3], at(1, 1, -5));
  scene.setTransforms([ids[4], ids[0]], [...at(-1, -1, -5), ...at(0, 0, 80)]);
  scene.refit();
  assert.deepEqual([...view.cull()], [wallId, ids[3], ids[4]]);
  scene.setState(ids[3], { layers: 0 });
  scene.setState(ids[1], { alwaysVisible: true });
  assert.deepEqual([...view.cull()], [wallId, ids[1], ids[4]]);
  scene.remove(wallId);
  assert.deepEqual([...view.cull()].sort((a, b) => a - b), [ids[1], ids[2], ids[4]]);
  assert.throws(() => scene.remove(wallId), (e) => e.code === 'id' && /removed/.test(e.message));
  assert.equal(scene.instanceCount, 5);
  scene.commit();
  assert.deepEqual([...view.cull()], [ids[1], ids[2], ids[4]]);
  scene.dispose();
});

test('draws are of the mesh\'s own order, and name ids', () => {
  const { scene, wallId, ids } = walled();
  const view = scene.view({ preset: 'exact', output: 'instances' }).setCamera(clip, 640, 400);
  view.cull();
  scene.setPlace(1, 100, 8);
  const { commands, keys, instances } = view.draws();
  assert.equal(commands.length, 10);
  assert.deepEqual([...instances].sort((a, b) => a - b), [wallId, ids[0]]);
  const of = (mesh) => { const i = [0, 1].find((d) => keys[5 * d + 2] === mesh); return [...commands.slice(5 * i, 5 * i + 5)]; };
  assert.deepEqual(of(0).slice(0, 4), [36, 1, 0, 0]);
  assert.deepEqual(of(1).slice(0, 4), [36, 1, 100, 8]);
  assert.equal(instances[of(1)[4]], ids[0]);
  assert.deepEqual([...scene.indices(1)].sort((a, b) => a - b), [...box(1, 1, 1).indices].sort((a, b) => a - b));
  const triangles = scene.view({ output: 'triangles' }).setCamera(clip, 640, 400);
  triangles.cull();
  assert.equal(triangles.draws().indices.length, triangles.triangleCount * 3);
  scene.dispose();
});

test('an answer is of the scene that was culled', () => {
  const { scene, ids } = walled();
  const view = scene.view({ reasons: true }).setCamera(clip, 640, 400);
  const stale = (call) => assert.throws(call, (e) => e.code === 'argument' && /cull first/.test(e.message));
  stale(() => view.draws());
  view.cull();
  scene.remove(ids[4]);
  scene.remove(ids[3]);
  scene.commit();
  stale(() => view.draws());
  stale(() => view.reasons());
  view.cull();
  assert.ok(view.draws().commands.length > 0);
  const hollow = scene.addMesh(new Float32Array(0), new Uint32Array(0));
  scene.add(hollow, at(0, 0, -5));
  scene.commit();
  view.cull();
  view.draws();
  assert.equal(view.reasons().length, scene.idCount);
  scene.dispose();
});

test('a mesh by its box hides nothing and is culled as a whole', () => {
  const scene = new Scene();
  const mesh = scene.addBox([-20, -20, -0.5, 20, 20, 0.5]);
  const ids = scene.addMany(mesh, [...at(0, 0, -20), ...at(0, 0, -50), ...at(0, 0, 50)]);
  scene.commit();
  assert.deepEqual([...scene.view({ preset: 'exact' }).setCamera(clip, 640, 400).cull()], [ids[0], ids[1]]);
  scene.dispose();
});

test('a frame allocates nothing, whichever of two views it culls', () => {
  const scene = new Scene();
  const { positions, indices } = box(1, 1, 1);
  const mesh = scene.addMesh(positions, indices, { twoSided: false });
  const matrices = Array.from({ length: 3000 }, (_, i) => at((i % 30) * 4 - 60, 0, -Math.floor(i / 30) * 4)).flat();
  const ids = scene.addMany(mesh, matrices);
  scene.commit();
  const views = [scene.view({ reasons: true }), scene.view({ preset: 'fast' })];
  const matrix = Float64Array.from(clip);
  const frame = (i) => {
    const view = views[i % 2];
    matrix[12] = Math.sin(i) * 3;
    scene.setTransform(ids[i % 100], at((i % 7) - 3, 0, -30));
    scene.refit();
    view.setCamera(matrix, 640, 400).cull();
    view.draws();
    return view.reasons === undefined || i % 2 === 1 || view.reasons().length;
  };
  for (let i = 0; i < 200; i++) frame(i);
  const { buffer } = views[0].cull();
  for (let i = 0; i < 2000; i++) frame(i);
  assert.equal(views[0].cull().buffer, buffer, 'the memory did not grow');
  scene.dispose();
});

test('mistakes are errors with a code that name the value and the limit', () => {
  const { scene, ids } = walled();
  const view = scene.view();
  const { positions, indices } = box(1, 1, 1);
  const wrong = [
    [() => view.cull(), 'camera', /setCamera/],
    [() => view.setCamera(new Array(16).fill(0), 640, 400), 'camera', /singular/],
    [() => view.setCamera([NaN, ...clip.slice(1)], 640, 400), 'camera', /finite/],
    [() => view.setCamera(clip, 0, 400), 'argument', /width.*0.*1 to 65536/],
    [() => view.setCamera(clip.slice(1), 1, 1), 'argument', /15.*16/],
    [() => view.reasons(), 'argument', /reasons: true/],
    [() => view.explain(ids[0]), 'camera', /setCamera/],
    [() => scene.view().setCamera(clip, 640, 400).explain(99), 'id', /99/],
    [() => scene.view({ preset: 'best' }), 'argument', /"best".*exact, balanced, fast/],
    [() => scene.view({ prest: 'fast' }), 'argument', /no prest/],
    [() => scene.addMesh([0, 0, 0], indices).length, 'mesh', /index 1 is 2, but there are 1/],
    [() => scene.addMesh(new Float64Array(3), indices), 'argument', /Float64Array.*|Float32Array/],
    [() => scene.addMesh(new Float32Array(4), indices), 'argument', /4.*3/],
    [() => scene.addMesh(positions.map(() => NaN), indices), 'mesh', /not finite/],
    [() => scene.addMesh(positions, indices, { alpha: 'clear' }), 'argument', /"clear"/],
    [() => scene.addMesh(positions, indices, { parts: [{ triangles: 5 }] }), 'mesh', /part/],
    [() => scene.add(7, at(0, 0, 0)), 'id', /mesh 7 of 2/],
    [() => scene.add(0, at(0, 0, 0).slice(1)), 'argument', /15.*16/],
    [() => scene.addMany(0, new Float32Array(17)), 'argument', /17.*16/],
    [() => scene.setTransform(1e6, at(0, 0, 0)), 'id', /1000000/],
    [() => scene.setTransform(-1, at(0, 0, 0)), 'argument', /-1/],
    [() => scene.setTransforms(new Uint32Array(2), at(0, 0, 0)), 'argument', /16.*32/],
    [() => scene.indices(9), 'id', /mesh 9/],
    [() => new Scene().cull(view), 'argument', /another scene/],
  ];
  for (const [call, name, message] of wrong) {
    assert.throws(call, (error) => error instanceof CulletError && error.code === name && message.test(error.message), String(call));
  }
  const lost = scene.add(1, [NaN, ...at(0, 0, 0).slice(1)]);
  assert.ok([...view.setCamera(clip, 64, 40).cull()].includes(lost), 'what is not known is kept');
  const empty = new Scene();
  empty.commit();
  assert.equal(empty.view().setCamera(clip, 640, 400).cull().length, 0);
  assert.equal(ids.length, 5);
  scene.dispose();
  for (const call of [() => scene.commit(), () => view.cull(), () => scene.view(), () => scene.instanceCount]) assert.throws(call, (e) => e.code === 'disposed');
  view.dispose();
  assert.throws(() => view.cull(), (e) => e.code === 'disposed');
  assert.equal(new BoxSet(1).length, 1);
});

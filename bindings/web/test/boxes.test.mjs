import assert from 'node:assert/strict';
import { test } from 'node:test';
import { entry } from './package.mjs';

// |x|, |y|, |z| ≤ 10, as inward normals and constants.
const cube = [1, 0, 0, 10, -1, 0, 0, 10, 0, 1, 0, 10, 0, -1, 0, 10, 0, 0, 1, 10, 0, 0, -1, 10];
const fill = (set) => {
  for (let i = 0; i < set.length; i++) set.boxes.set([i, 0, 0, i + 0.5, 1, 1], 6 * i);
  set.commit();
};
const code = (name) => (error) => error.name === 'CulletError' && error.code === name && error.message.startsWith('cullet: ');

for (const name of ['frustum', 'boxes', 'index', 'queries', 'files']) {
  const { BoxSet, init } = await entry(name);
  assert.throws(() => new BoxSet(1), code('not-ready'));
  await Promise.all([init(), init()]);

  test(`${name}: six planes leave what a sweep leaves`, () => {
    const set = new BoxSet(5000);
    const boxes = Array.from({ length: 5000 }, (_, i) => [Math.sin(i) * 40, Math.sin(i * 3.3) * 40, Math.sin(i * 7.1) * 40]);
    boxes.forEach(([x, y, z], i) => set.boxes.set([x, y, z, x + 1, y + 1, z + 1], 6 * i));
    set.commit();
    const sweep = (shift) => boxes.flatMap(([x, y, z], i) => ([x + shift, y, z].every((v) => v <= 10 && v + 1 >= -10) ? [i] : []));
    for (let step = 0; step < 50; step++) {
      const planes = [...cube];
      planes[3] = 10 + step * 0.37;
      planes[7] = 10 - step * 0.37;
      assert.deepEqual([...set.cull(planes, step % 3)], sweep(step * 0.37), `step ${step}`);
    }
    set.dispose();
  });

  test(`${name}: boxes go through matrices; NaN is everywhere, an inverted box nowhere`, () => {
    const set = new BoxSet(4);
    set.boxes.set([-1, -1, -1, 1, 1, 1, -1, -1, -1, 1, 1, 1, NaN, -1, -1, 1, 1, 1, 1, 1, 1, -1, -1, -1]);
    set.matrices[12] = 10.5;
    set.matrices[16 + 12] = 11.5;
    set.commitMoved();
    assert.deepEqual([...set.cull(cube)], [0, 2]);
    set.dispose();
  });
}

const { BoxSet, CulletError } = await entry('frustum');

test('each view has a list of its own, and one that stands the same object', () => {
  const set = new BoxSet(100);
  fill(set);
  const one = set.cull(cube, 1);
  const wide = cube.map((v, i) => (i === 7 ? 50 : v));
  const two = set.cull(wide, 2);
  assert.equal(one.length, 11);
  assert.equal(two.length, 51);
  assert.equal(set.cull(cube, 1), one);
  set.boxes.set([90, 0, 0, 91, 1, 1], 0);
  set.commit(0, 1);
  assert.deepEqual([...set.cull(cube, 1)], [1, 2, 3, 4, 5, 6, 7, 8, 9, 10]);
  set.forget(1);
  assert.equal(set.cull(cube, 1).length, 10);
  set.dispose();
});

test('views are made again when the memory grew', () => {
  const set = new BoxSet(1000);
  fill(set);
  const [boxes, list] = [set.boxes, set.cull(cube)];
  const more = new BoxSet(1_000_000);
  assert.equal(boxes.length, 0);
  assert.equal(list.length, 0);
  assert.equal(set.boxes.length, 6000);
  assert.equal(set.cull(cube).length, 11);
  more.dispose();
  set.dispose();
});

test('a frame allocates nothing', () => {
  const set = new BoxSet(20_000);
  fill(set);
  const planes = Float64Array.from(cube);
  const frame = (i) => {
    planes[7] = 10 + (i % 17);
    set.boxes[0] = i % 5;
    set.commit(0, 1);
    return set.cull(planes);
  };
  for (let i = 0; i < 100; i++) frame(i);
  const { buffer } = set.boxes;
  for (let i = 0; i < 5000; i++) frame(i);
  assert.equal(set.boxes.buffer, buffer, 'the memory did not grow');
  set.dispose();
});

test('making and disposing of sets does not grow the memory', () => {
  const kept = new BoxSet(1);
  for (let i = 0; i < 20; i++) new BoxSet(10_000).dispose();
  const { buffer } = kept.boxes;
  for (let i = 0; i < 500; i++) { const set = new BoxSet(10_000); fill(set); set.cull(cube); set.dispose(); if (i === 5) assert.ok(set.isDisposed); }
  assert.ok(kept.boxes.buffer.byteLength - buffer.byteLength < 4 << 20);
  kept.dispose();
});

test('mistakes are errors with a code that name the value and the limit', () => {
  const set = new BoxSet(10);
  const wrong = [
    [() => new BoxSet(-1), 'argument', /-1.*0 to/],
    [() => new BoxSet(1.5), 'argument', /1\.5/],
    [() => new BoxSet('9'), 'argument', /string/],
    [() => new BoxSet(2 ** 28), 'memory', /268435456/],
    [() => set.commit(9, 2), 'argument', /from 9 on is 2.*0 to 1/],
    [() => set.commit(11), 'argument', /11/],
    [() => set.cull(new Float32Array(23)), 'argument', /23.*24/],
    [() => set.cull(new Uint8Array(24)), 'argument', /Uint8Array of 24/],
    [() => set.cull(), 'argument', /undefined/],
    [() => set.cull(cube, 1024), 'argument', /1024.*1023/],
  ];
  for (const [call, name, message] of wrong) {
    assert.throws(call, (error) => error instanceof CulletError && error.code === name && message.test(error.message), String(call));
  }
  assert.deepEqual([...set.cull(new Array(24).fill(NaN))].length, 0, 'nothing was committed');
  set.dispose();
  set.dispose();
  for (const call of [() => set.cull(cube), () => set.boxes, () => set.commit(), () => set.sort()]) assert.throws(call, code('disposed'));
  const none = new BoxSet(0);
  none.commit();
  assert.equal(none.cull(cube).length, 0);
});

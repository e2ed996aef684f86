// Boxes behind occluders, without a scene.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { join } from 'node:path';
import { test } from 'node:test';
import { pathToFileURL } from 'node:url';
import { at, box, entry, folder, perspective } from './package.mjs';

const { BoxSet, CulletError, init, OccluderSet } = await entry('boxes');
const clip = perspective(1, 1.6, 0.1, 300);
const everywhere = new Array(24).fill(NaN);
const code = (name, message = /./) => (error) => error instanceof CulletError && error.code === name && message.test(error.message);
assert.throws(() => new OccluderSet(8, 8), code('not-ready'));
await init();

// Boxes of one unit in a plane at z, numbered by columns.
const crowd = (z, side = 12) => {
  const set = new BoxSet((2 * side + 1) ** 2);
  for (let i = 0; i < set.length; i++) {
    const [x, y] = [i % (2 * side + 1) - side, Math.floor(i / (2 * side + 1)) - side];
    set.boxes.set([x, y, z, x + 0.5, y + 0.5, z + 0.5], 6 * i);
  }
  set.commit();
  set.cull(everywhere);
  return set;
};
// By hand: the shadow of a rectangle at z = -10 on the front of a box at -29.5, seen from the origin; half a pixel of the
// buffer is left to either side.
const hiddenBy = (set, [x0, y0, x1, y1]) => [...Array(set.length).keys()].filter((i) => {
  const b = set.boxes.subarray(6 * i, 6 * i + 6);
  const scale = (z) => 10 / -z;
  const reach = (a, z) => a * scale(z);
  const ends = (a) => [-30, -29.5].flatMap((z) => [reach(b[a], z), reach(b[a + 3], z)]);
  return Math.min(...ends(0)) >= x0 && Math.max(...ends(0)) <= x1 && Math.min(...ends(1)) >= y0 && Math.max(...ends(1)) <= y1;
});

for (const [name, add] of [
  ['a box', (set) => set.addBox([-2, -1.5, -11, 2, 1.5, -10])],
  ['a closed body of triangles', (set) => {
    const { positions, indices } = box(2, 1.5, 0.5);
    const id = set.addTriangles(positions, indices, { twoSided: false });
    set.setMatrix(id, at(0, 0, -10.5));
    return id;
  }],
  ['a surface of triangles', (set) => set.addTriangles(new Float32Array([-2, -1.5, -10, 2, -1.5, -10, 2, 1.5, -10, -2, 1.5, -10]), new Uint16Array([0, 1, 2, 0, 2, 3]))],
]) {
  test(`${name} hides what lies behind it, and nothing else`, () => {
    const set = crowd(-30);
    const occluders = new OccluderSet(640, 400);
    const id = add(occluders);
    assert.equal(occluders.visible(set).length, set.length, 'all before the first draw');
    assert.ok(occluders.draw(clip) >= 1);
    const visible = new Set(occluders.visible(set));
    const hidden = [...Array(set.length).keys()].filter((i) => !visible.has(i));
    const exact = hiddenBy(set, [-2, -1.5, 2, 1.5]);
    assert.ok(exact.length > 50, `${exact.length} boxes are behind it`);
    assert.deepEqual(hidden.filter((i) => !exact.includes(i)), [], 'what is in sight is kept');
    const inner = hiddenBy(set, [-1.95, -1.45, 1.95, 1.45]);
    assert.deepEqual(inner.filter((i) => visible.has(i)), [], 'what is well behind it goes');
    // Away with it, and all is seen.
    occluders.remove(id);
    assert.equal(occluders.draw(clip), 0);
    assert.equal(occluders.visible(set).length, set.length);
    occluders.dispose();
    set.dispose();
  });
}

test('an occluder hides from where it stands, in each kind of depth', () => {
  const set = crowd(-30, 3);
  const occluders = new OccluderSet(320, 200);
  const id = occluders.addBox([-20, -20, -0.5, 20, 20, 0.5]);
  occluders.setMatrix(id, at(0, 0, -10));
  const webgl = [...clip];
  [webgl[10], webgl[14]] = [2 * clip[10] + 1, 2 * clip[14]];
  const reversed = [...clip];
  [reversed[10], reversed[14]] = [-1 - clip[10], -clip[14]];
  for (const [depth, matrix] of [['standard', clip], ['webgl', webgl], ['reversed', reversed]]) {
    occluders.draw(matrix, depth);
    assert.equal(occluders.visible(set).length, 0, depth);
  }
  occluders.setMatrix(id, at(0, 0, -40));
  occluders.draw(clip);
  assert.equal(occluders.visible(set).length, set.length, 'behind the boxes');
  // A box that is nowhere finite is always seen.
  set.boxes.set([NaN, 0, 0, 1, 1, 1], 0);
  set.commit(0, 1);
  set.cull(everywhere);
  occluders.setMatrix(id, at(0, 0, -10));
  occluders.draw(clip);
  assert.deepEqual([...occluders.visible(set)], [0]);
  // Only of what the view listed: nothing of a view that has none.
  assert.equal(occluders.visible(set, 5).length, 0);
  occluders.dispose();
  set.dispose();
});

test('mistakes are told, and change nothing', async () => {
  const occluders = new OccluderSet(64, 40);
  assert.throws(() => new OccluderSet(0, 40), code('argument', /width.* 0;/));
  assert.throws(() => occluders.addBox([0, 0, 0, -1, 1, 1]), code('argument', /least x/));
  assert.throws(() => occluders.addBox([0, 0, 0, NaN, 1, 1]), code('argument', /number 3 .*NaN/));
  assert.throws(() => occluders.addTriangles(new Float32Array(9), new Uint32Array([0, 1, 3])), code('argument', /index 2 is 3.* 3 vertices/));
  assert.throws(() => occluders.addTriangles(new Float32Array(9).fill(Infinity), new Uint32Array([0, 1, 2])), code('argument', /number 0 .*Infinity/));
  assert.throws(() => occluders.setMatrix(0, at(0, 0, 0)), code('id', /0/));
  assert.throws(() => occluders.remove(7), code('id', /7/));
  assert.throws(() => occluders.draw(new Array(16).fill(0)), code('camera', /no volume/));
  assert.throws(() => occluders.draw(clip, 'deep'), code('argument', /deep/));
  const { BoxSet: Other, init: load } = await entry('frustum');
  await load();
  assert.throws(() => occluders.visible(new Other(1)), code('argument', /another entry/));
  assert.throws(() => occluders.visible([1]), code('argument', /BoxSet/));
  occluders.dispose();
  occluders.dispose();
  assert.ok(occluders.isDisposed);
  assert.throws(() => occluders.draw(clip), code('disposed'));
});

test('the example of the book and of the types runs, and drops what the box hides', async () => {
  const text = (name) => readFileSync(new URL(name, import.meta.url), 'utf8');
  const [, example] = text('../../../docs/src/web.md').match(/```js\n(import \{ BoxSet, init, OccluderSet \}[^`]*)```/);
  const typed = text('../js/boxes.d.ts').match(/```js\n([^`]*)```/)[1].replace(/^ \* ?/gm, '');
  assert.equal(typed.trim(), example.trim());
  const program = `${example.replace("'cullet/boxes'", JSON.stringify(pathToFileURL(join(folder, 'js/boxes.js'))))}\nexport default [...visible];`;
  const { default: visible } = await import(`data:text/javascript,${encodeURIComponent(program)}`);
  // Of x from -20 to 20, which the camera sees, those beside the box.
  assert.deepEqual(visible, [...Array(11).keys()].map((i) => 30 + i).concat([...Array(12).keys()].map((i) => 59 + i)));
});

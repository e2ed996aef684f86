// The horizon in JavaScript is the engine's, and that of its own parts.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import { pathToFileURL } from 'node:url';
import { join } from 'node:path';
import { folder } from '../package.mjs';

const { Horizon, lowered, loweredOcclusionPoint } = await import(pathToFileURL(join(folder, 'js/tiles/horizon.js')));
const WGS84 = [6378137, 6378137, 6356752.314245179];

// As in crates/cullet/tests/horizon.rs, which has the same numbers.
test('answers are those of the engine', () => {
  let state = 1;
  const unit = () => { state = (Math.imul(state, 1664525) + 1013904223) >>> 0; return state / 4294967296; };
  const [a, b, c] = lowered(WGS84, 500);
  let [hash, pointsHidden, spheresHidden, tilesHidden] = [0, 0, 0, 0];
  for (let round = 0; round < 20000; round++) {
    const height = 0.5 ** (round % 24);
    const horizon = new Horizon([a, b, c], [a * (1 + height), b * (unit() * 1e-9), 0]);
    const width = Math.sqrt(2 * height) * 3;
    const [y, z, level] = [width * (unit() - 0.5), width * (unit() - 0.5), height * (unit() - 0.5)];
    const centre = [a * (1 - (y * y + z * z) * 0.5 + level), b * y, c * z];
    const size = a * width * unit() * 0.2;
    const points = Array.from({ length: 8 }, () => { const [px, py, pz] = centre.map((p) => p + size * (unit() - 0.5)); return { x: px, y: py, z: pz }; });
    const radius = size * unit() * 0.1;
    // A horizon occlusion point above the tile's middle, made for the ellipsoid that is not lowered.
    const above = 1 + height * unit();
    const tile = loweredOcclusionPoint(WGS84, 500, centre.map((p, i) => (p / WGS84[i]) * above));
    const hidden = [horizon.hidesPoints(points), horizon.hidesSphere({ x: centre[0], y: centre[1], z: centre[2] }, radius), tile !== null && horizon.hidesOcclusionPoint(tile)].map(Number);
    pointsHidden += hidden[0];
    spheresHidden += hidden[1];
    tilesHidden += hidden[2];
    hash = (Math.imul(hash, 31) + hidden[0] + 2 * hidden[1] + 4 * hidden[2]) >>> 0;
  }
  assert.deepEqual([hash, pointsHidden, spheresHidden, tilesHidden], [1527419774, 1058, 4190, 605]);
});

test('doubt keeps', () => {
  const behind = { x: -3, y: 0, z: 0 };
  const hides = (radii, eye) => { const h = new Horizon(radii, eye); return h.hidesPoints([behind]) || h.hidesSphere(behind, 0); };
  assert.ok(hides([1, 1, 1], [2, 0, 0]));
  for (const x of [0, 0.5, 1, 1 + Number.EPSILON, NaN, Infinity]) assert.ok(!hides([1, 1, 1], [x, 0, 0]), `${x}`);
  for (const r of [0, -1, NaN, Infinity]) assert.ok(!hides([r, 1, 1], [2, 0, 0]), `${r}`);
  const horizon = new Horizon([1, 1, 1], [2, 0, 0]);
  for (const odd of [NaN, Infinity, -Infinity]) assert.ok(!horizon.hidesPoints([{ x: -3, y: odd, z: 0 }]), `${odd}`);
  for (const radius of [NaN, Infinity, -1]) assert.ok(!horizon.hidesSphere(behind, radius), `${radius}`);
  assert.ok(!horizon.hidesPoints([]));
});

test('a horizon occlusion point hides by itself, and only outside of the ellipsoid', () => {
  const horizon = new Horizon([1, 1, 1], [2, 0, 0]);
  assert.ok(horizon.hidesOcclusionPoint([-3, 0, 0]) && horizon.hidesOcclusionPoint([-1, 0, 0]));
  for (const point of [[0, 0, 0], [-0.5, 0, 0], [3, 0, 0], [0, 1.5, 0], [-3, NaN, 0]]) assert.ok(!horizon.hidesOcclusionPoint(point), `${point}`);
});

test('lowered points stand for more, up to a quarter of the globe', () => {
  // A point with a cap of 30°, on ground that is lower by the cosine of 20°: a cap of 50°.
  const cos = (degrees) => Math.cos((degrees * Math.PI) / 180);
  const [x, y, z] = loweredOcclusionPoint([4, 4, 2], 2 * (1 - cos(20)), [0, 0, 1 / cos(30)]);
  assert.ok(x === 0 && y === 0 && Math.abs(z - 1 / cos(50)) < 1e-6 && z > 1 / cos(50), `${z}`);
  assert.equal(loweredOcclusionPoint([4, 4, 2], 2 * (1 - cos(20)), [0, 0, 1 / cos(71)]), null);
  assert.deepEqual(loweredOcclusionPoint([4, 4, 2], 0, [0, 0, 1.5]), [0, 0, 1.5]);
});

test('what is no point outside of an ellipsoid is none', () => {
  const none = [undefined, null, '1,2,3', 7, {}, [], [2, 0], [2, 0, 0, 0], ['2', 0, 0], ['NaN', 2, 2], [NaN, 2, 2], [2, Infinity, 0], [2, null, 0], [0, 0, 0],
    [0.9, 0, 0], [1e300, 0, 0], { 0: 2, 1: 0, 2: 0, length: 3 }];
  for (const point of none) for (const depth of [0, 0.1]) assert.equal(loweredOcclusionPoint([1, 1, 1], depth, point), null, `${JSON.stringify(point)}, ${depth}`);
  for (const depth of [NaN, Infinity, 1]) assert.equal(loweredOcclusionPoint([1, 1, 1], depth, [2, 0, 0]), null, `${depth}`);
  for (const r of [0, -1, NaN, Infinity]) assert.equal(loweredOcclusionPoint([1, r, 1], 0, [2, 0, 0]), null, `${r}`);
});

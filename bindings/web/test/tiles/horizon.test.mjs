// The horizon in JavaScript is the engine's, and that of its own parts.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import { pathToFileURL } from 'node:url';
import { join } from 'node:path';
import { folder } from '../package.mjs';

const { Horizon, lowered } = await import(pathToFileURL(join(folder, 'js/tiles/horizon.js')));
const WGS84 = [6378137, 6378137, 6356752.314245179];

// As in crates/cullet/tests/horizon.rs, which has the same numbers.
test('answers are those of the engine', () => {
  let state = 1;
  const unit = () => { state = (Math.imul(state, 1664525) + 1013904223) >>> 0; return state / 4294967296; };
  const [a, b, c] = lowered(WGS84, 500);
  let [hash, pointsHidden, spheresHidden] = [0, 0, 0];
  for (let round = 0; round < 20000; round++) {
    const height = 0.5 ** (round % 24);
    const horizon = new Horizon([a, b, c], [a * (1 + height), b * (unit() * 1e-9), 0]);
    const width = Math.sqrt(2 * height) * 3;
    const [y, z, level] = [width * (unit() - 0.5), width * (unit() - 0.5), height * (unit() - 0.5)];
    const centre = [a * (1 - (y * y + z * z) * 0.5 + level), b * y, c * z];
    const size = a * width * unit() * 0.2;
    const points = Array.from({ length: 8 }, () => { const [px, py, pz] = centre.map((p) => p + size * (unit() - 0.5)); return { x: px, y: py, z: pz }; });
    const radius = size * unit() * 0.1;
    const hidden = [Number(horizon.hidesPoints(points)), Number(horizon.hidesSphere({ x: centre[0], y: centre[1], z: centre[2] }, radius))];
    pointsHidden += hidden[0];
    spheresHidden += hidden[1];
    hash = (Math.imul(hash, 31) + hidden[0] + 2 * hidden[1]) >>> 0;
  }
  assert.deepEqual([hash, pointsHidden, spheresHidden], [4086032201, 1053, 4112]);
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

// Measures what the border costs: `node cost.mjs NATIVE`, where NATIVE is `cargo build --release -p cullet-web --example
// web_native`. Native and WebAssembly in turn, five times, the least median of each; both must list the same.
import { execFileSync } from 'node:child_process';
import { box, entry } from './package.mjs';

const [COUNT, FRAMES] = [100_000, 200];
const { BoxSet, init, Scene } = await entry('index');
await init();

const random = (seed) => () => ((seed = (Math.imul(seed, 1664525) + 1013904223) >>> 0) / (2 ** 32 - 1)) * 2 - 1;
const out = new Float64Array(16);
const clip = (frame) => {
  const [s, c] = [Math.sin(frame * 0.02), Math.cos(frame * 0.02)];
  const [y, near, far] = [1 / Math.tan(0.5), 0.1, 700];
  const [x, z, w] = [y / 1.6, far / (near - far), (near * far) / (near - far)];
  // The projection times a turn about Y.
  out.set([x * c, 0, -s * z, s, 0, y, 0, 0, x * s, 0, c * z, -c, 0, 0, w, 0]);
  return out;
};
const planes = new Float64Array(24);
const planesOf = (m) => {
  const rows = [[3, 0, 1], [3, 0, -1], [3, 1, 1], [3, 1, -1], [2, 2, 0], [3, 2, -1]];
  rows.forEach(([a, b, s], i) => { for (let j = 0; j < 4; j++) planes[4 * i + j] = m[4 * j + a] + s * m[4 * j + b]; });
  return planes;
};
const report = (frame) => {
  const times = [];
  let listed = 0;
  for (let i = 0; i < FRAMES + 20; i++) {
    const start = performance.now();
    const list = frame(i);
    let sum = 0;
    for (let k = 0; k < list.length; k++) sum += list[k];
    if (i >= 20) { times.push((performance.now() - start) * 1000); listed += sum; }
  }
  times.sort((a, b) => a - b);
  return { listed, median: times[FRAMES / 2] };
};

const next = random(7);
const places = Array.from({ length: COUNT }, () => [0, 0, 0].map(() => Math.trunc(next() * 500)));
const set = new BoxSet(COUNT);
places.forEach(([x, y, z], i) => set.boxes.set([x - 1, y - 1, z - 1, x + 1, y + 1, z + 1], 6 * i));
let from = performance.now();
set.commit();
set.cull(planesOf(clip(0)));
console.log(`committed and sorted in ${(performance.now() - from).toFixed(1)} ms`);
const scene = new Scene();
const { positions, indices } = box(1, 1, 1);
const mesh = scene.addMesh(positions, indices);
from = performance.now();
scene.addMany(mesh, Float32Array.from(places.flatMap((p) => [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, ...p, 1])));
scene.commit();
console.log(`${COUNT} instances added and committed in ${(performance.now() - from).toFixed(1)} ms`);
const views = { frustum: scene.view({ output: 'instances', occlusion: false }), occlusion: scene.view({ output: 'instances' }) };
const ours = {
  boxes: () => report((i) => set.cull(planesOf(clip(i)))),
  frustum: () => report((i) => views.frustum.setCamera(clip(i), 1280, 720).cull()),
  occlusion: () => report((i) => views.occlusion.setCamera(clip(i), 1280, 720).cull()),
};
const best = {};
for (let turn = 0; turn < 5; turn++) {
  const native = Object.fromEntries(execFileSync(process.argv[2], ['sse2'], { encoding: 'utf8' }).trim().split('\n').map((line) => {
    const [name, listed, , median] = line.split(' ');
    return [name, { listed: Number(listed), median: Number(median) }];
  }));
  for (const [name, run] of Object.entries(ours)) {
    const page = run();
    if (page.listed !== native[name].listed) throw new Error(`${name}: the page listed ${page.listed}, native ${native[name].listed}`);
    best[name] ??= [Infinity, Infinity];
    best[name] = [Math.min(best[name][0], native[name].median), Math.min(best[name][1], page.median)];
  }
}
let failed = false;
for (const [name, [native, page]] of Object.entries(best)) {
  console.log(`${name.padEnd(10)} native sse2 ${native.toFixed(0)} µs, WebAssembly ${page.toFixed(0)} µs: ${(page / native).toFixed(2)} times`);
  failed ||= page / native > 2;
}
process.exit(failed ? 1 : 0);
